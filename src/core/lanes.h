/* lanes.h: eight vectors of three, one after the other as they lie in memory, to eight lanes of each axis, and back. No number is changed on the way. With the compilers that have vectors of
 * their own these are shuffles of registers; going through memory, number by number, took three times as long. */
#ifndef NORMA_CORE_LANES_H
#define NORMA_CORE_LANES_H
#include "isa.h"
#include "measure.h"
#include <string.h>

typedef struct core_floats { float axis[3][CORE_LANES]; } core_floats;
typedef struct core_rows { double row[CORE_LANES][4]; } core_rows;

#if defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define CORE_HAS_SHUFFLES
#endif
#endif

#if defined(CORE_HAS_SHUFFLES)
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"    /* how a vector would be passed to a function: all here are inlined */
#endif
typedef double core_d2 __attribute__((vector_size(16)));
typedef double core_d4 __attribute__((vector_size(32)));
typedef float  core_f4 __attribute__((vector_size(16)));
typedef float  core_f8 __attribute__((vector_size(32)));

/* Three floats, and not a byte beyond them. */
CORE_INLINE core_f4 core_load_three(const unsigned char *at)
{
    double xy;
    float z;
    memcpy(&xy, at, sizeof xy);
    memcpy(&z, at + sizeof xy, sizeof z);
    core_f4 v = (core_f4)(core_d2){xy, 0};
    v[2] = z;
    return v;
}

CORE_INLINE core_f8 core_two_rows(const unsigned char *one, const unsigned char *other)
{
    return __builtin_shufflevector(core_load_three(one), core_load_three(other), 0, 1, 2, 3, 4, 5, 6, 7);
}

CORE_INLINE void core_gather_floats(const unsigned char *const at[CORE_LANES], core_floats *out)
{
    const core_f8 r0 = core_two_rows(at[0], at[4]), r1 = core_two_rows(at[1], at[5]), r2 = core_two_rows(at[2], at[6]), r3 = core_two_rows(at[3], at[7]);
    const core_f8 xy01 = __builtin_shufflevector(r0, r1, 0, 8, 1, 9, 4, 12, 5, 13), xy23 = __builtin_shufflevector(r2, r3, 0, 8, 1, 9, 4, 12, 5, 13);
    const core_f8 z01 = __builtin_shufflevector(r0, r1, 2, 10, 3, 11, 6, 14, 7, 15), z23 = __builtin_shufflevector(r2, r3, 2, 10, 3, 11, 6, 14, 7, 15);
    const core_f8 x = __builtin_shufflevector(xy01, xy23, 0, 1, 8, 9, 4, 5, 12, 13), y = __builtin_shufflevector(xy01, xy23, 2, 3, 10, 11, 6, 7, 14, 15);
    const core_f8 z = __builtin_shufflevector(z01, z23, 0, 1, 8, 9, 4, 5, 12, 13);
    memcpy(out->axis[0], &x, sizeof x);
    memcpy(out->axis[1], &y, sizeof y);
    memcpy(out->axis[2], &z, sizeof z);
}

CORE_INLINE core_d4 core_load_row(const double *row)
{
    core_d4 v;
    memcpy(&v, row, sizeof v);
    return v;
}

CORE_INLINE void core_store_row(double *row, core_d4 v) { memcpy(row, &v, sizeof v); }

/* Four rows of four, turned over. */
CORE_INLINE void core_turn_rows(core_d4 r[4])
{
    const core_d4 a = __builtin_shufflevector(r[0], r[1], 0, 4, 2, 6), b = __builtin_shufflevector(r[0], r[1], 1, 5, 3, 7);
    const core_d4 c = __builtin_shufflevector(r[2], r[3], 0, 4, 2, 6), d = __builtin_shufflevector(r[2], r[3], 1, 5, 3, 7);
    r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    r[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    r[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

CORE_INLINE void core_lanes_to_rows(const double *x, const double *y, const double *z, const double *w, core_rows *out)
{
    for (int i = 0; i < CORE_LANES; i += 4) {
        core_d4 r[4] = {core_load_row(x + i), core_load_row(y + i), core_load_row(z + i), core_load_row(w + i)};
        core_turn_rows(r);
        for (int k = 0; k < 4; k++) core_store_row(out->row[i + k], r[k]);
    }
}

CORE_INLINE void core_rows_to_lanes(const double (*rows)[4], double *x, double *y, double *z, double *w)
{
    for (int i = 0; i < CORE_LANES; i += 4) {
        core_d4 r[4] = {core_load_row(rows[i]), core_load_row(rows[i + 1]), core_load_row(rows[i + 2]), core_load_row(rows[i + 3])};
        core_turn_rows(r);
        core_store_row(x + i, r[0]);
        core_store_row(y + i, r[1]);
        core_store_row(z + i, r[2]);
        core_store_row(w + i, r[3]);
    }
}

/* sum += factor row */
CORE_INLINE void core_add_row(double *sum, const double *row, double factor)
{
    core_store_row(sum, core_load_row(sum) + core_load_row(row) * (core_d4){factor, factor, factor, factor});
}
#else
CORE_INLINE void core_gather_floats(const unsigned char *const at[CORE_LANES], core_floats *out)
{
    for (int i = 0; i < CORE_LANES; i++) {
        float v[3];
        memcpy(v, at[i], sizeof v);
        for (int k = 0; k < 3; k++) out->axis[k][i] = v[k];
    }
}

CORE_INLINE void core_lanes_to_rows(const double *x, const double *y, const double *z, const double *w, core_rows *out)
{
    for (int i = 0; i < CORE_LANES; i++) {
        out->row[i][0] = x[i];
        out->row[i][1] = y[i];
        out->row[i][2] = z[i];
        out->row[i][3] = w[i];
    }
}

CORE_INLINE void core_rows_to_lanes(const double (*rows)[4], double *x, double *y, double *z, double *w)
{
    for (int i = 0; i < CORE_LANES; i++) {
        x[i] = rows[i][0];
        y[i] = rows[i][1];
        z[i] = rows[i][2];
        w[i] = rows[i][3];
    }
}

CORE_INLINE void core_add_row(double *sum, const double *row, double factor)
{
    for (int k = 0; k < 4; k++) sum[k] += row[k] * factor;
}
#endif
#endif
