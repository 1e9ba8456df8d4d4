/* near.c: the distinct positions of all files, joined by the core as those of one mesh. */
#include "io/together/near.h"
#include "core/call/call.h"
#include "core/call/vector.h"
#include "core/mesh/weld.h"
#include "io/file/memory.h"
#include <stdlib.h>
#include <string.h>

struct near_positions {
    double (*at)[3];
    size_t count, room;
    uint32_t *stands; /* for each the position that stands for its chain */
};

near_positions *norma_near_begin(void) { return calloc(1, sizeof(near_positions)); }

void norma_near_free(near_positions *near) {
    if (!near) return;
    free(near->at);
    free(near->stands);
    free(near);
}

int norma_near_add(near_positions *near, const double at[3]) {
    if (!norma_core_finite(at)) return 1;
    double(*grown)[3] = norma_io_grow(near->at, &near->room, near->count + 1, sizeof *grown);
    if (!grown) return 0;
    near->at = grown;
    memcpy(near->at[near->count++], at, sizeof near->at[0]);
    return 1;
}

static int compare_near(const void *a, const void *b) {
    const double *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p[k] != q[k]) return p[k] < q[k] ? -1 : 1;
    return 0;
}

static void sort_distinct(near_positions *near) {
    size_t kept = 0;
    qsort(near->at, near->count, sizeof near->at[0], compare_near);
    for (size_t i = 0; i < near->count; ++i)
        if (i == 0 || compare_near(near->at[i], near->at[kept - 1]) != 0)
            memmove(near->at[kept++], near->at[i], sizeof near->at[0]);
    near->count = kept;
}

/* They are sorted: the least index of a chain is its least position. */
norma_result norma_near_end(near_positions *near, double distance, uint32_t threads) {
    const norma_options options = {.struct_size = sizeof options,
        .weld = NORMA_WELD_DISTANCE,
        .weld_distance = distance,
        .threads = threads};
    core_call call;
    if (near->count) sort_distinct(near);
    if (near->count > UINT32_MAX) return NORMA_ERROR_OVERFLOW;
    const norma_mesh points = {
        .positions = {.data = near->at, .count = near->count, .format = NORMA_FORMAT_DOUBLE}};
    core_mesh mesh;
    norma_result result = norma_core_begin(&call, &options);
    if (!result) result = norma_core_mesh_shape(&points, &mesh);
    if (!result && near->count) {
        mesh.scale = 1;
        result = norma_core_weld(&call, &mesh);
    }
    if (result || !near->count || !mesh.weld) return result;
    near->stands = norma_io_allocate(near->count, sizeof *near->stands);
    if (near->stands) memcpy(near->stands, mesh.weld, near->count * sizeof *near->stands);
    norma_core_unweld(&call, &mesh);
    return near->stands ? NORMA_OK : NORMA_ERROR_MEMORY;
}

void norma_near_find(const near_positions *near, double at[3]) {
    double(*found)[3] =
        near->stands ? bsearch(at, near->at, near->count, sizeof near->at[0], compare_near) : NULL;
    if (found) memcpy(at, near->at[near->stands[found - near->at]], sizeof near->at[0]);
}
