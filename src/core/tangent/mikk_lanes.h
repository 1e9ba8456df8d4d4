/* mikk_lanes.h: many triangles' derivatives, or many corners' contributions, at once. Plain C over
 * arrays of lanes, in single precision, each operation as the reference has it, so that every
 * instruction set gives its bits. */
#ifndef NORMA_CORE_MIKK_LANES_H
#define NORMA_CORE_MIKK_LANES_H
#include "core/call/instruction_set.h"

enum { MIKK_LANES = 16, MIKK_ALL_ENDS = 0xfff };
typedef float mikk_lane[MIKK_LANES];

/* In: the three vertices of each triangle. */
typedef struct mikk_batch {
    _Alignas(64) mikk_lane position[3][3]; /* of a vertex, along an axis */
    mikk_lane normal[3][3];
    mikk_lane texcoord[3][2];
    mikk_lane turn; /* contribute: which of the three the corner is at: 0, 1 or 2 */
} mikk_batch;

/* Out: of each corner. */
typedef struct mikk_corners {
    mikk_lane s[3], t[3]; /* the tangent and the bitangent, made perpendicular to the
                                          normal, unit or next to nothing */
    mikk_lane angle, length_s, length_t;
} mikk_corners;

typedef struct mikk_derivative {
    _Alignas(64) mikk_lane area, length_s, length_t; /* lengths: |dP/du| and |dP/dv|; 0: no area */
} mikk_derivative;

/* Out: of each triangle, and of all three corners what a record holds (mikk.h). */
typedef struct mikk_addends {
    mikk_derivative derivative;
    mikk_lane sum[3][3]; /* of a corner, along an axis */
    uint32_t ends[3][MIKK_LANES];
} mikk_addends;

typedef struct mikk_kernels {
    void (*derive)(const mikk_batch *batch, mikk_derivative *out); /* normals are not looked at */
    void (*contribute)(const mikk_batch *batch, mikk_corners *out);
    void (*add_up)(const mikk_batch *batch, mikk_addends *out);
} mikk_kernels;

const mikk_kernels *norma_core_mikk_kernels(norma_isa isa);

/* acos of each x in [-1, 1] as a correctly rounded function of doubles gives it, rounded to a
 * float. */
float norma_core_mikk_acos(float x);
#endif
