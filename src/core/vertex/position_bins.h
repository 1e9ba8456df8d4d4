/* position_bins.h: work on ranges of positions, each with all faces that touch it, where faces in a
 * row touch positions near each other. What is kept of a range's positions lies in memory that
 * stays in the cache from one range to the next. A chunk of faces that touches two ranges is
 * measured for both. */
#ifndef NORMA_CORE_VERTEX_POSITION_BINS_H
#define NORMA_CORE_VERTEX_POSITION_BINS_H
#include "core/vertex/add_triangles.h"

typedef struct core_bins {
    const core_mesh *mesh;
    const core_range *ranges; /* of positions, of each chunk of faces */
    size_t chunks;
    size_t count, size; /* bins; positions in each but the last */
    size_t buffers;     /* at most so many are worked on at once */
    size_t step;        /* each task takes every step-th bin */
} core_bins;

static inline size_t norma_core_count_chunks(const core_mesh *mesh) {
    return mesh->face_count / CORE_FACES_IN_CHUNK + (mesh->face_count % CORE_FACES_IN_CHUNK != 0);
}

typedef struct core_bin_limits { /* of positions */
    size_t in_one, in_all;       /* in one buffer; in all together, where there are several */
} core_bin_limits;

/* 0: the mesh is in no such order, and bins are not worth it. */
int norma_core_plan_bins(const core_call *call, const core_mesh *mesh, const core_range *ranges,
    core_bin_limits limits, core_bins *bins);

typedef struct core_bin {
    size_t number, buffer; /* buffer: below bins->buffers, nobody else's */
    uint32_t first, count; /* positions */
} core_bin;
typedef void core_bin_work(void *context, const core_bin *bin);
/* All bins; MEMORY never, CANCELLED: some were left out. */
norma_result norma_core_each_bin(
    core_call *call, const core_bins *bins, core_bin_work *work, void *context);

/* The next chunk, from this one on, that touches the bin; bins->chunks: none. */
static inline size_t norma_core_chunk_of_bin(
    const core_bins *bins, const core_bin *bin, size_t chunk) {
    const uint32_t last = bin->first + (bin->count - 1);
    while (chunk < bins->chunks &&
           (bins->ranges[chunk].least > last || bins->ranges[chunk].most < bin->first))
        chunk++;
    return chunk;
}
static inline int norma_core_bin_owns(const core_bins *bins, const core_bin *bin, size_t chunk) {
    return bins->ranges[chunk].least >= bin->first &&
           bins->ranges[chunk].most - bin->first < bin->count;
}
static inline size_t norma_core_chunk_end(const core_bins *bins, size_t chunk) {
    const size_t begin = chunk * CORE_FACES_IN_CHUNK, faces = bins->mesh->face_count;
    return faces - begin < CORE_FACES_IN_CHUNK ? faces : begin + CORE_FACES_IN_CHUNK;
}

/* Adds all faces that touch the bin. */
void norma_core_add_to_bin(
    const core_bins *bins, const core_bin *bin, core_add_faces *add, core_adder *adder);
#endif
