/* vertex_normals.h: what becomes of each vertex, by sums or by cones, before it is written. */
#ifndef NORMA_CORE_VERTICES_H
#define NORMA_CORE_VERTICES_H
#include "core/corner/visit_positions.h"
#include "core/vertex/sum_record.h"

typedef struct core_vertices {
    core_prepared_mesh *prepared;
    size_t count;         /* vertices */
    vertex_sum *sums;     /* of positions */
    uint32_t *own;        /* NULL where nothing cancels; else of each vertex its number in own_sums,
                             UINT32_MAX: its position's sum stands */
    vertex_sum *own_sums; /* of the corners of one vertex alone */
    size_t own_count;
    float (*normals)[3]; /* of cones, instead of sums: of positions, and of vertices with a result
                            of their own */
    uint8_t *reasons;
} core_vertices;

static inline void norma_core_release_vertices(core_vertices *vertices) {
    const core_call *call = vertices->prepared->call;
    norma_core_release(call, vertices->sums, vertices->count, sizeof *vertices->sums);
    norma_core_release(call, vertices->own, vertices->count, sizeof *vertices->own);
    norma_core_release(call, vertices->own_sums, vertices->own_count, sizeof *vertices->own_sums);
    norma_core_release(call, vertices->normals, vertices->count, sizeof *vertices->normals);
    norma_core_release(call, vertices->reasons, vertices->count, 1);
    *vertices = (core_vertices){.prepared = vertices->prepared};
}

/* vertex_sums.c, most_visible_normals.c. What they return but NORMA_OK leaves nothing to release.
 * tally: degenerate faces are added. scattered: faces in a row lie far apart. */
norma_result norma_core_sum_vertices(
    core_prepared_mesh *prepared, int scattered, core_vertices *vertices, core_tally *tally);
norma_result norma_core_cone_vertices(
    core_prepared_mesh *prepared, core_vertices *vertices, core_tally *tally);

/* binned_sums.c: where faces in a row touch positions near each other, and none is welded, range by
 * range of positions, from the corners to the output. *written: whether it could, and all but what
 * takes the nearest normal is written; ranges: of the chunks of faces. */
norma_result norma_core_bin_vertices(core_prepared_mesh *prepared, const core_range *ranges,
    const core_output *output, core_tally *tally, int *written);

int norma_core_resolve_sum(const core_vertices *vertices, size_t vertex, float normal[3]);
int norma_core_resolve_cone(const core_vertices *vertices, size_t vertex, float normal[3]);
#endif
