/* visit_positions.c: positions in chunks of fixed size, so that partial counts do not depend on the
 * threads. Ordinary stars are made many at a time, others one by one; those that a stack has no
 * room for are few, and come last, one after the other, in memory that is taken once. Where
 * triangles without a direction turn up, their stars wait until it is known whose they borrow. */
#include "core/corner/fan_batch.h"

enum { POSITIONS_IN_CHUNK = 2048 };

typedef struct visit_all {
    core_prepared_mesh *prepared;
    const position_visit *visit;
    atomic_uchar *only; /* NULL, or nonzero at the positions whose stars waited */
    fans_simd *settle;
    stars_part *parts;
} visit_all;

void norma_core_make_star(const core_prepared_mesh *prepared, core_join join, uint32_t position,
    star_counts *counts, core_star *star) {
    norma_core_star_load(prepared, position, 1, star);
    if (join == CORE_JOIN_FANS && star->waits) return;
    if (join == CORE_JOIN_FANS)
        norma_core_star_join_fans(prepared, star, counts);
    else
        norma_core_star_join_all(star);
    norma_core_star_sum(prepared, star);
}

static void visit_position(
    const visit_all *v, uint32_t position, core_star *star, stars_part *part) {
    const core_corners_of_position *corners_of = &v->prepared->corners_of;
    norma_core_make_star(
        v->prepared, v->visit->join, position, v->visit->counting ? &part->counts : NULL, star);
    if (v->visit->join == CORE_JOIN_FANS && star->waits) {
        part->waiting++;
        return;
    }
    const core_fans fans = {position, (uint32_t)star->count, (uint32_t)star->fan_count,
        corners_of->corners + corners_of->starts[position], star->fan_of, star->fans,
        norma_core_star_members(star), star};
    v->visit->see(v->visit->context, &fans, &part->tally);
    norma_core_count_add(&part->tally.degenerate, &star->degenerate);
}

/* 0 where there is nothing to visit. */
static size_t star_size(const visit_all *v, size_t position) {
    const uint32_t *starts = v->prepared->corners_of.starts;
    if (v->visit->skip && v->visit->skip[position]) return 0;
    if (v->only && !atomic_load_explicit(&v->only[position], memory_order_relaxed)) return 0;
    return starts[position + 1] - starts[position];
}

/* One by one, all in the chunk that a stack has room for. */
static void visit_chunk_singly(const visit_all *v, size_t begin, size_t end, stars_part *part) {
    star_room room;
    core_star star;
    norma_core_star_in_room(&star, &room);
    for (size_t p = begin; p < end; p++) {
        const size_t size = star_size(v, p);
        if (size > 0 && size <= STAR_ROOM) visit_position(v, (uint32_t)p, &star, part);
    }
}

/* Those of a list that are not ordinary after all. */
static void visit_singly(const visit_all *v, const star_list *list, stars_part *part) {
    star_room room;
    core_star star;
    norma_core_star_in_room(&star, &room);
    for (size_t i = 0; i < list->star_count; i++)
        if (list->stars[i].fan_count == 0) visit_position(v, list->stars[i].position, &star, part);
}

static void see_ordinary(
    const visit_all *v, const star_list *list, fan_batch *batch, stars_part *part) {
    star_member members[ORDINARY_CORNERS];
    const core_corners_of_position *corners_of = &v->prepared->corners_of;
    for (size_t i = 0; i < list->star_count; i++) {
        const listed_star *r = &list->stars[i];
        const core_fans fans = {r->position, r->count, r->fan_count,
            corners_of->corners + corners_of->starts[r->position], batch->fan_of + r->begin,
            batch->fans + r->first_fan, members, NULL};
        if (r->fan_count) v->visit->see(v->visit->context, &fans, &part->tally);
    }
}

/* Lists ordinary stars from position on, as many as fit; what cannot be ordinary is visited at
 * once. Returns where the next list begins. */
static size_t list_stars(
    const visit_all *v, size_t position, size_t end, star_list *list, stars_part *part) {
    norma_core_clear_list(list, v->visit);
    for (; position < end; position++) {
        const size_t size = star_size(v, position);
        if (size > ORDINARY_CORNERS && size <= STAR_ROOM)
            visit_chunk_singly(v, position, position + 1, part);
        if (size == 0 || size > ORDINARY_CORNERS) continue;
        if (!norma_core_list_star(v->prepared, (uint32_t)position, (uint32_t)size, list)) break;
    }
    norma_core_read_list(v->prepared, list);
    return position;
}

/* While one list is worked on, the memory of the next is on its way. */
static void visit_in_batches(const visit_all *v, size_t position, size_t end, stars_part *part) {
    star_list lists[2];
    fan_batch batch;
    int at = 0;
    norma_core_clear_batch(&batch);
    position = list_stars(v, position, end, &lists[at], part);
    while (lists[at].star_count) {
        position = list_stars(v, position, end, &lists[!at], part);
        const int all = v->settle(
            v->prepared, &lists[at], &batch, v->visit->counting ? &part->counts.edges : NULL);
        see_ordinary(v, &lists[at], &batch, part);
        if (!all) visit_singly(v, &lists[at], part);
        at = !at;
    }
}

static int go_in_batches(const visit_all *v) {
    return v->visit->join == CORE_JOIN_FANS && !v->only && norma_core_can_batch(v->prepared);
}

static void visit_chunk(void *context, size_t chunk) {
    const visit_all *v = context;
    const size_t count = v->prepared->mesh.positions.count, begin = chunk * POSITIONS_IN_CHUNK;
    const size_t end = count - begin < POSITIONS_IN_CHUNK ? count : begin + POSITIONS_IN_CHUNK;
    const uint32_t *starts = v->prepared->corners_of.starts;
    if (starts[begin] == starts[end]) return;
    if (go_in_batches(v))
        visit_in_batches(v, begin, end, &v->parts[chunk]);
    else
        visit_chunk_singly(v, begin, end, &v->parts[chunk]);
}

/* Where fans may come one by one, the memory for them all can be had for a tenth. */
static int go_by_fan(const visit_all *v) {
    return v->visit->by_fan && v->visit->join == CORE_JOIN_FANS && !v->prepared->faces &&
           v->prepared->call->options.weight != NORMA_WEIGHT_VISIBLE;
}

static norma_result visit_large_stars(const visit_all *v, stars_part *part) {
    core_call *call = v->prepared->call;
    core_star star = {0};
    large_star large = {0};
    const size_t most = v->prepared->corners_of.most;
    const int by_fan = go_by_fan(v);
    if (most <= STAR_ROOM) return NORMA_OK;
    norma_result result = by_fan ? norma_core_large_star_allocate(call, &large, most)
                                 : norma_core_star_allocate(call, &star, most);
    for (size_t p = 0; p < v->prepared->mesh.positions.count && result == NORMA_OK; p++) {
        if (star_size(v, p) <= STAR_ROOM) continue;
        if (by_fan)
            result = norma_core_visit_large_star(v->prepared, v->visit, (uint32_t)p, &large, part);
        else
            visit_position(v, (uint32_t)p, &star, part);
        if (result == NORMA_OK && norma_core_progress(call, 1)) result = NORMA_CANCELLED;
    }
    norma_core_star_release(call, &star, most);
    norma_core_large_star_release(call, &large);
    return result;
}

static void add_part(stars_part *sum, const stars_part *part) {
    norma_core_tally_add(&sum->tally, &part->tally);
    norma_core_count_add(&sum->counts.non_manifold, &part->counts.non_manifold);
    norma_core_count_add(&sum->counts.conflicts, &part->counts.conflicts);
    norma_core_edges_add(&sum->counts.edges, &part->counts.edges);
    sum->waiting += part->waiting;
}

static norma_result visit_in_parallel(visit_all *v, stars_part *sum) {
    core_call *call = v->prepared->call;
    const size_t count = v->prepared->mesh.positions.count,
                 chunks = count / POSITIONS_IN_CHUNK + (count % POSITIONS_IN_CHUNK != 0);
    norma_result result = go_in_batches(v) ? norma_core_measure_small(v->prepared) : NORMA_OK;
    if (result != NORMA_OK) return result;
    v->parts = norma_core_allocate(call, chunks, sizeof *v->parts);
    if (!v->parts) return NORMA_ERROR_MEMORY;
    memset(v->parts, 0, chunks * sizeof *v->parts);
    result = norma_core_parallel(call, chunks, visit_chunk, v);
    if (result == NORMA_OK) result = visit_large_stars(v, sum);
    for (size_t i = 0; i < chunks; i++) add_part(sum, &v->parts[i]);
    norma_core_release(call, v->parts, chunks, sizeof *v->parts);
    return result;
}

norma_result norma_core_visit_positions(
    core_prepared_mesh *prepared, const position_visit *visit, stars_part *sum) {
    visit_all v = {.prepared = prepared,
        .visit = visit,
        .settle = norma_core_choose_fans(prepared->call->options.isa)};
    *sum = (stars_part){.tally.degenerate = prepared->degenerate_faces};
    if (!prepared->mesh.positions.count) return NORMA_OK;
    norma_result result = visit_in_parallel(&v, sum);
    if (result != NORMA_OK || !sum->waiting) return result;
    result = norma_core_find_borrowed_directions(prepared);
    v.only = prepared->flat_at;
    return result == NORMA_OK ? visit_in_parallel(&v, sum) : result;
}
