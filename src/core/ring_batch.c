/* ring_batch.c: what memory has to say about a batch of rings. In meshes of random order each of a corner's reads misses the caches, so they are asked for in
 * stages: the mesh's corners two batches ahead, the positions that these name and the place where the normals go one batch ahead. */
#include "ring_batch.h"

enum { CORNERS_AHEAD = 2 * BATCH_CORNERS };

int norma_core_can_batch(const core_surface *surface)
{
    return !surface->faces && surface->call->options.weight != NORMA_WEIGHT_VISIBLE;
}

void norma_core_clear_list(ring_list *list)
{
    list->corner_count = 0;
    list->ring_count = 0;
}

static void ask_for_position(const core_mesh *mesh, uint32_t index)
{
    __builtin_prefetch((const unsigned char *)mesh->positions.data + index * mesh->positions.stride);
    if (mesh->weld) __builtin_prefetch(&mesh->weld[index]);
}

static void list_corner(const core_mesh *mesh, uint32_t corner, ring_list *list, size_t at)
{
    const uint32_t begin = corner / 3 * 3, turn = corner - begin;
    list->corners[at] = corner;
    list->turn[at] = turn;
    list->next[at] = norma_core_corner(mesh, turn == 2 ? begin : corner + 1);
    list->previous[at] = norma_core_corner(mesh, turn == 0 ? begin + 2 : corner - 1);
    ask_for_position(mesh, list->next[at]);
    ask_for_position(mesh, list->previous[at]);
}

int norma_core_list_ring(const core_surface *surface, const ring_visit *visit, uint32_t position, uint32_t count, ring_list *list)
{
    const core_around *around = &surface->around;
    const core_mesh *mesh = &surface->mesh;
    const size_t begin = around->starts[position], at = list->corner_count;
    if (at + count > BATCH_CORNERS) return 0;
    list->rings[list->ring_count++] = (listed_ring){.position = position, .begin = (uint8_t)at, .count = (uint8_t)count};
    list->corner_count += count;
    for (size_t i = 0; i < count; i++) {
        const uint32_t corner = around->corners[begin + i];
        list_corner(mesh, corner, list, at + i);
        if (visit->target) __builtin_prefetch((const unsigned char *)visit->target + visit->target_size * corner, 1);
        if (mesh->corners && begin + i + CORNERS_AHEAD < around->corner_count)
            __builtin_prefetch((const unsigned char *)mesh->corners + mesh->corner_size * around->corners[begin + i + CORNERS_AHEAD]);
    }
    return 1;
}

static void load_at(const core_mesh *mesh, uint32_t index, batch_lane to[3], size_t at)
{
    double p[3];
    norma_core_position(mesh, index, p);
    for (int k = 0; k < 3; k++) to[k][at] = p[k];
}

/* The ring's own position is that of all its corners, unless a weld over a distance brought them together. */
static void load_own(const core_surface *surface, const ring_list *list, const listed_ring *ring, ring_batch *batch)
{
    const size_t end = ring->begin + (size_t)(ring->count <= CORE_LANES ? CORE_LANES : ORDINARY_CORNERS);
    double p[3];
    norma_core_position(&surface->mesh, ring->position, p);
    for (int k = 0; k < 3; k++)
        for (size_t i = ring->begin; i < end; i++) batch->at[k][i] = p[k];
    if (!surface->mesh.weld || surface->call->options.weld != NORMA_WELD_DISTANCE) return;
    for (size_t i = ring->begin; i < (size_t)ring->begin + ring->count; i++)
        load_at(&surface->mesh, norma_core_corner(&surface->mesh, list->corners[i]), batch->at, i);
}

static void load_ring(const core_surface *surface, const ring_list *list, listed_ring *ring, ring_batch *batch)
{
    const core_mesh *mesh = &surface->mesh;
    int edged = 1;
    load_own(surface, list, ring, batch);
    for (size_t i = ring->begin; i < (size_t)ring->begin + ring->count; i++) {
        const uint32_t next = norma_core_welded(mesh, list->next[i]), previous = norma_core_welded(mesh, list->previous[i]);
        load_at(mesh, list->next[i], batch->next_at, i);
        load_at(mesh, list->previous[i], batch->previous_at, i);
        batch->next[i] = next;
        batch->previous[i] = previous;
        batch->turn[i] = list->turn[i];
        edged &= (next != previous) & (next != ring->position) & (previous != ring->position);
    }
    ring->fan_count = (uint8_t)edged;
}

/* So that lanes beyond the last corner compute with numbers. */
static void fill_up(ring_batch *batch, size_t count)
{
    for (size_t i = count; i < count + ORDINARY_CORNERS; i++) {
        batch->next[i] = batch->previous[i] = 0;
        batch->turn[i] = 0;
        for (int k = 0; k < 3; k++) batch->at[k][i] = batch->next_at[k][i] = batch->previous_at[k][i] = 0;
    }
}

int norma_core_settle_batch(const core_surface *surface, ring_list *list, ring_batch *batch, norma_edges *edges)
{
    for (size_t i = 0; i < list->ring_count; i++) load_ring(surface, list, &list->rings[i], batch);
    fill_up(batch, list->corner_count);
    return norma_core_choose_ring_lanes(surface->call->options.isa)(surface, list, batch, edges);
}
