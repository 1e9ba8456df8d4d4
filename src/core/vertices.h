/* vertices.h: what becomes of each vertex, by sums or by cones, before it is written. */
#ifndef NORMA_CORE_VERTICES_H
#define NORMA_CORE_VERTICES_H
#include "rings.h"

typedef struct vertex_sum { double x, y, z, weight; } vertex_sum;   /* weight: -0 as long as nobody votes */

typedef struct core_vertices {
    core_surface *surface;
    size_t        count;                   /* vertices */
    vertex_sum   *sums;                    /* of positions */
    uint32_t     *own;                     /* NULL where nothing cancels; else of each vertex its number in own_sums, UINT32_MAX: its position's sum stands */
    vertex_sum   *own_sums;                /* of the corners of one vertex alone */
    size_t        own_count;
    float       (*normals)[3];             /* of cones, instead of sums: of positions, and of vertices with a result of their own */
    uint8_t      *reasons;
} core_vertices;

/* vertex_sums.c, vertex_cones.c. What they return but NORMA_OK leaves nothing to release. tally: degenerate faces are added. */
norma_result norma_core_sum_vertices(core_surface *surface, core_vertices *vertices, core_tally *tally);
norma_result norma_core_cone_vertices(core_surface *surface, core_vertices *vertices, core_tally *tally);
void         norma_core_release_vertices(core_vertices *vertices);

/* NORMA_REASON_NONE and its normal, or why there is none. */
int norma_core_resolve_sum(const core_vertices *vertices, size_t vertex, float normal[3]);
int norma_core_resolve_cone(const core_vertices *vertices, size_t vertex, float normal[3]);
#endif
