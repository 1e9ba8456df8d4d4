/* visit_positions.c: positions in chunks of fixed size, so that partial counts do not depend on the
 * threads. Ordinary rings are made many at a time, others one by one; those that a stack has no
 * room for are few, and come last, one after the other, in memory that is taken once. Where
 * triangles without a direction turn up, their rings wait until it is known whose they borrow. */
#include "core/corner/fan_batch.h"

enum { POSITIONS_IN_CHUNK = 2048 };

typedef struct visit_all {
    core_surface *surface;
    const ring_visit *visit;
    atomic_uchar *only; /* NULL, or nonzero at the positions whose rings waited */
    ring_lanes *settle;
    rings_part *parts;
} visit_all;

void norma_core_make_ring(const core_surface *surface, core_join join, uint32_t position,
    ring_counts *counts, core_ring *ring) {
    norma_core_ring_load(surface, position, 1, ring);
    if (join == CORE_JOIN_FANS && ring->waits) return;
    if (join == CORE_JOIN_FANS)
        norma_core_ring_join_fans(surface, ring, counts);
    else
        norma_core_ring_join_all(ring);
    norma_core_ring_sum(surface, ring);
}

static void visit_position(
    const visit_all *v, uint32_t position, core_ring *ring, rings_part *part) {
    const core_around *around = &v->surface->around;
    norma_core_make_ring(
        v->surface, v->visit->join, position, v->visit->counting ? &part->counts : NULL, ring);
    if (v->visit->join == CORE_JOIN_FANS && ring->waits) {
        part->waiting++;
        return;
    }
    const core_fans fans = {position, (uint32_t)ring->count, (uint32_t)ring->fan_count,
        around->corners + around->starts[position], ring->fan_of, ring->fans,
        norma_core_ring_members(ring), ring};
    v->visit->see(v->visit->context, &fans, &part->tally);
    norma_core_count_add(&part->tally.degenerate, &ring->degenerate);
}

/* 0 where there is nothing to visit. */
static size_t ring_size(const visit_all *v, size_t position) {
    const uint32_t *starts = v->surface->around.starts;
    if (v->visit->skip && v->visit->skip[position]) return 0;
    if (v->only && !atomic_load_explicit(&v->only[position], memory_order_relaxed)) return 0;
    return starts[position + 1] - starts[position];
}

/* One by one, all in the chunk that a stack has room for. */
static void visit_chunk_singly(const visit_all *v, size_t begin, size_t end, rings_part *part) {
    ring_room room;
    core_ring ring;
    norma_core_ring_in_room(&ring, &room);
    for (size_t p = begin; p < end; p++) {
        const size_t size = ring_size(v, p);
        if (size > 0 && size <= RING_ROOM) visit_position(v, (uint32_t)p, &ring, part);
    }
}

/* Those of a list that are not ordinary after all. */
static void visit_singly(const visit_all *v, const ring_list *list, rings_part *part) {
    ring_room room;
    core_ring ring;
    norma_core_ring_in_room(&ring, &room);
    for (size_t i = 0; i < list->ring_count; i++)
        if (list->rings[i].fan_count == 0) visit_position(v, list->rings[i].position, &ring, part);
}

static void see_ordinary(
    const visit_all *v, const ring_list *list, ring_batch *batch, rings_part *part) {
    static const uint32_t one_fan[ORDINARY_CORNERS] = {0};
    ring_member members[ORDINARY_CORNERS];
    const core_around *around = &v->surface->around;
    for (size_t i = 0; i < list->ring_count; i++) {
        const listed_ring *r = &list->rings[i];
        const core_fans fans = {r->position, r->count, r->fan_count,
            around->corners + around->starts[r->position],
            r->fan_count == 1 ? one_fan : batch->fan_of + r->begin, batch->fans + r->first_fan,
            members, NULL};
        if (r->fan_count) v->visit->see(v->visit->context, &fans, &part->tally);
    }
}

/* Lists ordinary rings from position on, as many as fit; what cannot be ordinary is visited at
 * once. Returns where the next list begins. */
static size_t list_rings(
    const visit_all *v, size_t position, size_t end, ring_list *list, rings_part *part) {
    norma_core_clear_list(list, v->visit);
    for (; position < end; position++) {
        const size_t size = ring_size(v, position);
        if (size > ORDINARY_CORNERS && size <= RING_ROOM)
            visit_chunk_singly(v, position, position + 1, part);
        if (size == 0 || size > ORDINARY_CORNERS) continue;
        if (!norma_core_list_ring(v->surface, (uint32_t)position, (uint32_t)size, list)) break;
    }
    return position;
}

/* While one list is worked on, the memory of the next is on its way. */
static void visit_in_batches(const visit_all *v, size_t position, size_t end, rings_part *part) {
    ring_list lists[2];
    ring_batch batch;
    int at = 0;
    position = list_rings(v, position, end, &lists[at], part);
    while (lists[at].ring_count) {
        position = list_rings(v, position, end, &lists[!at], part);
        const int all = v->settle(
            v->surface, &lists[at], &batch, v->visit->counting ? &part->counts.edges : NULL);
        see_ordinary(v, &lists[at], &batch, part);
        if (!all) visit_singly(v, &lists[at], part);
        at = !at;
    }
}

static void visit_chunk(void *context, size_t chunk) {
    const visit_all *v = context;
    const size_t count = v->surface->mesh.positions.count, begin = chunk * POSITIONS_IN_CHUNK;
    const size_t end = count - begin < POSITIONS_IN_CHUNK ? count : begin + POSITIONS_IN_CHUNK;
    const int ordinary =
        v->visit->join == CORE_JOIN_FANS && !v->only && norma_core_can_batch(v->surface);
    if (ordinary)
        visit_in_batches(v, begin, end, &v->parts[chunk]);
    else
        visit_chunk_singly(v, begin, end, &v->parts[chunk]);
}

/* Where fans may come one by one, the memory for them all can be had for a tenth. */
static int go_by_fan(const visit_all *v) {
    return v->visit->by_fan && v->visit->join == CORE_JOIN_FANS && !v->surface->faces &&
           v->surface->call->options.weight != NORMA_WEIGHT_VISIBLE;
}

static norma_result visit_large_rings(const visit_all *v, rings_part *part) {
    core_call *call = v->surface->call;
    core_ring ring = {0};
    large_ring large = {0};
    const size_t most = v->surface->around.most;
    const int by_fan = go_by_fan(v);
    if (most <= RING_ROOM) return NORMA_OK;
    norma_result result = by_fan ? norma_core_large_ring_allocate(call, &large, most)
                                 : norma_core_ring_allocate(call, &ring, most);
    for (size_t p = 0; p < v->surface->mesh.positions.count && result == NORMA_OK; p++) {
        if (ring_size(v, p) <= RING_ROOM) continue;
        if (by_fan)
            result = norma_core_visit_large_ring(v->surface, v->visit, (uint32_t)p, &large, part);
        else
            visit_position(v, (uint32_t)p, &ring, part);
        if (result == NORMA_OK && norma_core_progress(call, 1)) result = NORMA_CANCELLED;
    }
    norma_core_ring_release(call, &ring, most);
    norma_core_large_ring_release(call, &large);
    return result;
}

static void add_part(rings_part *sum, const rings_part *part) {
    norma_core_tally_add(&sum->tally, &part->tally);
    norma_core_count_add(&sum->counts.non_manifold, &part->counts.non_manifold);
    norma_core_count_add(&sum->counts.conflicts, &part->counts.conflicts);
    norma_core_edges_add(&sum->counts.edges, &part->counts.edges);
    sum->waiting += part->waiting;
}

static norma_result visit_in_parallel(visit_all *v, rings_part *sum) {
    core_call *call = v->surface->call;
    const size_t count = v->surface->mesh.positions.count,
                 chunks = count / POSITIONS_IN_CHUNK + (count % POSITIONS_IN_CHUNK != 0);
    v->parts = norma_core_allocate(call, chunks, sizeof *v->parts);
    if (!v->parts) return NORMA_ERROR_MEMORY;
    memset(v->parts, 0, chunks * sizeof *v->parts);
    norma_result result = norma_core_parallel(call, chunks, visit_chunk, v);
    if (result == NORMA_OK) result = visit_large_rings(v, sum);
    for (size_t i = 0; i < chunks; i++) add_part(sum, &v->parts[i]);
    norma_core_release(call, v->parts, chunks, sizeof *v->parts);
    return result;
}

norma_result norma_core_visit_rings(
    core_surface *surface, const ring_visit *visit, rings_part *sum) {
    visit_all v = {.surface = surface,
        .visit = visit,
        .settle = norma_core_choose_ring_lanes(surface->call->options.isa)};
    *sum = (rings_part){.tally.degenerate = surface->degenerate_faces};
    if (!surface->mesh.positions.count) return NORMA_OK;
    norma_result result = visit_in_parallel(&v, sum);
    if (result != NORMA_OK || !sum->waiting) return result;
    result = norma_core_surface_lend(surface);
    v.only = surface->flat_at;
    return result == NORMA_OK ? visit_in_parallel(&v, sum) : result;
}
