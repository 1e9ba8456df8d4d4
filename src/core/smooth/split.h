/* split.h: norma_split of a mesh that is prepared already, or of a part of one. */
#ifndef NORMA_CORE_SPLIT_H
#define NORMA_CORE_SPLIT_H
#include "core/smooth/smooth_fans.h"

/* Room for each new vertex. */
typedef struct split_vertices {
    uint32_t *sources;
    float *normals;
    uint8_t *reasons;
} split_vertices;

/* Memory that is asked for as late as it can be: once it is known how much, and what the step
 * before needed is released. NULL where memory runs out. */
typedef struct split_room {
    norma_result (*of_vertices)(void *context, size_t count, split_vertices *room);
    uint32_t *(*of_corners)(void *context); /* their new vertices */
    void *context;
} split_room;

typedef struct split_output {
    uint32_t *corners, *source_vertices;
    float *normals;
    size_t corner_capacity, vertex_capacity, *vertex_count;
    const split_room *room; /* NULL, or in place of the pointers above and the options' reasons */
    const uint8_t *skip;    /* NULL, or nonzero at positions whose corners get no vertex; what is
                               written to these corners means nothing */
    uint8_t **reasons; /* NULL, or set: with NORMA_FALLBACK_NEAREST, if some corner has no normal,
                          the reasons of all, to be released by the caller; else NULL */
} split_output;

/* As norma_split; report and edges are those of the positions that are not skipped. smooth: as it
 * was opened with the mesh; NULL: it was opened for stars. */
norma_result norma_core_split_prepared(core_prepared_mesh *prepared, smooth_fans *smooth,
    const split_output *out, norma_report *report);
#endif
