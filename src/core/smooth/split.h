/* split.h: norma_split of a mesh that is prepared already, or of a part of one. */
#ifndef NORMA_CORE_SPLIT_H
#define NORMA_CORE_SPLIT_H
#include "core/smooth/smooth_fans.h"

typedef struct split_output {
    uint32_t *corners, *source_vertices;
    float *normals;
    size_t corner_capacity, vertex_capacity, *vertex_count;
    const uint8_t *skip; /* NULL, or nonzero at positions whose corners get no vertex; what is
                            written to these corners means nothing */
    uint8_t *reasons;    /* NULL, or with NORMA_FALLBACK_NEAREST and normals: of each corner */
} split_output;

/* As norma_split; report and edges are those of the positions that are not skipped. smooth: as it
 * was opened with the mesh; NULL: it was opened for stars. */
norma_result norma_core_split_prepared(core_prepared_mesh *prepared, smooth_fans *smooth,
    const split_output *out, norma_report *report);
#endif
