/* rings.c: positions in chunks of fixed size, so that partial counts do not depend on the threads. Rings that a stack has no room for are few; they
 * come last, one after the other, in memory that is taken once. */
#include "rings.h"

enum { POSITIONS_IN_CHUNK = 2048 };

typedef struct visit_all {
    core_surface  *surface;
    core_join      join;
    int            counting;
    const uint8_t *skip;
    ring_visitor  *visit;
    void          *context;
    rings_part    *parts;
} visit_all;

void norma_core_make_ring(const core_surface *surface, core_join join, uint32_t position, ring_counts *counts, core_ring *ring)
{
    norma_core_ring_load(surface, position, 1, ring);
    if (join == CORE_JOIN_FANS) norma_core_ring_join_fans(surface, ring, counts);
    else norma_core_ring_join_all(ring);
    norma_core_ring_sum(surface, ring);
}

static void visit_position(const visit_all *v, uint32_t position, core_ring *ring, rings_part *part)
{
    norma_core_make_ring(v->surface, v->join, position, v->counting ? &part->counts : NULL, ring);
    v->visit(v->context, ring, &part->tally);
}

/* 0 where there is nothing to visit. */
static size_t ring_size(const visit_all *v, size_t position)
{
    const uint32_t *starts = v->surface->around.starts;
    return v->skip && v->skip[position] ? 0 : starts[position + 1] - starts[position];
}

/* Random meshes wait for memory: the corners of faces some rings ahead are asked for, then, nearer, the positions that they name. */
static void look_ahead(const core_surface *surface, size_t position)
{
    enum { RINGS_TO_CORNERS = 12, RINGS_TO_POSITIONS = 6 };
    const core_around *around = &surface->around;
    const core_mesh *mesh = &surface->mesh;
    if (position + RINGS_TO_CORNERS >= around->position_count || surface->faces || !mesh->corner_size) return;
    const size_t far = position + RINGS_TO_CORNERS, near = position + RINGS_TO_POSITIONS;
    for (size_t i = around->starts[far]; i < around->starts[far + 1] && i < around->starts[far] + RING_ROOM; i++)
        __builtin_prefetch((const unsigned char *)mesh->corners + (size_t)around->corners[i] * mesh->corner_size);
    for (size_t i = around->starts[near]; i < around->starts[near + 1] && i < around->starts[near] + RING_ROOM; i++) {
        const size_t begin = around->corners[i] / 3 * 3;
        for (size_t c = begin; c < begin + 3; c++) {
            const uint32_t at = norma_core_corner(mesh, c);
            __builtin_prefetch((const unsigned char *)mesh->positions.data + at * mesh->positions.stride);
            if (mesh->weld) __builtin_prefetch(&mesh->weld[at]);
        }
    }
}

static void visit_chunk(void *context, size_t chunk)
{
    const visit_all *v = context;
    const size_t count = v->surface->mesh.positions.count, begin = chunk * POSITIONS_IN_CHUNK;
    const size_t end = count - begin < POSITIONS_IN_CHUNK ? count : begin + POSITIONS_IN_CHUNK;
    ring_room room;
    core_ring ring;
    norma_core_ring_in_room(&ring, &room);
    for (size_t p = begin; p < end; p++) {
        const size_t size = ring_size(v, p);
        look_ahead(v->surface, p);
        if (size > 0 && size <= RING_ROOM) visit_position(v, (uint32_t)p, &ring, &v->parts[chunk]);
    }
}

static norma_result visit_large_rings(const visit_all *v, rings_part *part)
{
    core_ring ring;
    const size_t most = v->surface->around.most;
    if (most <= RING_ROOM) return NORMA_OK;
    if (norma_core_ring_allocate(v->surface->call, &ring, most) != NORMA_OK) return NORMA_ERROR_MEMORY;
    norma_result result = NORMA_OK;
    for (size_t p = 0; p < v->surface->mesh.positions.count && result == NORMA_OK; p++) {
        if (ring_size(v, p) <= RING_ROOM) continue;
        visit_position(v, (uint32_t)p, &ring, part);
        if (norma_core_progress(v->surface->call, 1)) result = NORMA_CANCELLED;
    }
    norma_core_ring_release(v->surface->call, &ring, most);
    return result;
}

static void add_part(rings_part *sum, const rings_part *part)
{
    norma_core_tally_add(&sum->tally, &part->tally);
    norma_core_count_add(&sum->counts.non_manifold, &part->counts.non_manifold);
    norma_core_count_add(&sum->counts.conflicts, &part->counts.conflicts);
    norma_core_edges_add(&sum->counts.edges, &part->counts.edges);
}

norma_result norma_core_visit_rings(core_surface *surface, core_join join, int counting, const uint8_t *skip, ring_visitor *visit, void *context, rings_part *sum)
{
    const size_t count = surface->mesh.positions.count, chunks = count / POSITIONS_IN_CHUNK + (count % POSITIONS_IN_CHUNK != 0);
    visit_all v = {surface, join, counting, skip, visit, context, NULL};
    *sum = (rings_part){0};
    if (!count) return NORMA_OK;
    v.parts = norma_core_allocate(surface->call, chunks, sizeof *v.parts);
    if (!v.parts) return NORMA_ERROR_MEMORY;
    memset(v.parts, 0, chunks * sizeof *v.parts);
    norma_result result = norma_core_parallel(surface->call, chunks, visit_chunk, &v);
    if (result == NORMA_OK) result = visit_large_rings(&v, sum);
    for (size_t i = 0; i < chunks; i++) add_part(sum, &v.parts[i]);
    norma_core_release(surface->call, v.parts, chunks, sizeof *v.parts);
    return result;
}
