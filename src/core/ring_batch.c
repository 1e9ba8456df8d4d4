/* ring_batch.c: what memory has to say about a batch of rings. In meshes of random order each of a corner's reads misses the caches, so they are asked for in
 * stages: the mesh's corners two batches ahead, the positions that these name and the place where the normals go one batch ahead. */
#include "ring_batch.h"

enum { CORNERS_AHEAD = 2 * BATCH_CORNERS, NEAR = 1 << 17 };

int norma_core_can_batch(const core_surface *surface)
{
    const norma_options *o = &surface->call->options;
    return !surface->faces && o->weight != NORMA_WEIGHT_VISIBLE && !(surface->mesh.weld && o->weld == NORMA_WELD_DISTANCE);
}

void norma_core_clear_list(ring_list *list)
{
    list->corner_count = 0;
    list->ring_count = 0;
}

static inline void list_corners(const core_mesh *mesh, const uint32_t *corners, size_t count, ring_list *list)
{
    const size_t at = list->corner_count;
    for (size_t i = 0; i < count; i++) {
        const uint32_t corner = corners[i], begin = corner / 3 * 3, turn = corner - begin;
        list->corners[at + i] = corner;
        list->turn[at + i] = turn;
        list->next[at + i] = norma_core_corner(mesh, turn == 2 ? begin : corner + 1);
        list->previous[at + i] = norma_core_corner(mesh, turn == 0 ? begin + 2 : corner - 1);
    }
}

static void ask_for_position(const core_mesh *mesh, uint32_t index)
{
    __builtin_prefetch((const unsigned char *)mesh->positions.data + index * mesh->positions.stride);
    if (mesh->weld) __builtin_prefetch(&mesh->weld[index]);
}

static void ask_for_memory(const core_surface *surface, const ring_visit *visit, size_t begin, size_t count, const ring_list *list)
{
    const core_around *around = &surface->around;
    const core_mesh *mesh = &surface->mesh;
    for (size_t i = 0; i < count; i++) {
        ask_for_position(mesh, list->next[list->corner_count + i]);
        if (visit->target) __builtin_prefetch((const unsigned char *)visit->target + visit->target_size * around->corners[begin + i], 1);
        if (mesh->corners && begin + i + CORNERS_AHEAD < around->corner_count)
            __builtin_prefetch((const unsigned char *)mesh->corners + mesh->corner_size * around->corners[begin + i + CORNERS_AHEAD]);
    }
}

int norma_core_list_ring(const core_surface *surface, const ring_visit *visit, uint32_t position, uint32_t count, ring_list *list)
{
    const core_around *around = &surface->around;
    const size_t begin = around->starts[position];
    if (list->corner_count + count > BATCH_CORNERS) return 0;
    list->rings[list->ring_count++] = (listed_ring){.position = position, .begin = (uint8_t)list->corner_count, .count = (uint8_t)count};
    list_corners(&surface->mesh, around->corners + begin, count, list);
    if (around->corners[begin + count - 1] - around->corners[begin] > NEAR) ask_for_memory(surface, visit, begin, count, list);
    list->corner_count += count;
    return 1;
}
