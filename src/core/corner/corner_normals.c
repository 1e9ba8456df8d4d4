/* corner_normals.c: every star of a mesh, in parallel: ordinary ones many at a time, others one by
 * one, the largest last; and norma_corner_normals, which writes their fans. Begin there, at the
 * end; the largest, with which the file begins, are the rarest. */
#include "core/call/call.h"
#include "core/corner/corner.h"
#include "core/mesh/mesh.h"
#include <math.h>

enum { CORNERS_BETWEEN_TELLING = 1 << 17 };

/* ---- a star of very many corners, to the same fans, counts and bits as any star, in 20 bytes for
 * each corner instead of 260. Nothing that can be read or measured again is kept: its edges are two
 * sorted lists of numbers, joined some at a time in a star of ordinary size; its fans are summed
 * one after the other, and each is seen at once. Of triangles, and all weights but the visible one.
 */

typedef struct large_star {
    uint64_t *out, *back; /* of each corner: the position at the other end of its edge to next, from
                             previous, and its star number */
    uint32_t *fan;        /* of each corner a lower one of the same fan, or itself */
    size_t room;
} large_star;

static norma_result core_large_star_allocate(
    const core_call *call, large_star *large, size_t corners) {
    large->room = corners;
    large->out = norma_core_allocate(call, corners, sizeof *large->out);
    large->back = norma_core_allocate(call, corners, sizeof *large->back);
    large->fan = norma_core_allocate(call, corners, sizeof *large->fan);
    return large->out && large->back && large->fan ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static void core_large_star_release(const core_call *call, large_star *large) {
    norma_core_release(call, large->out, large->room, sizeof *large->out);
    norma_core_release(call, large->back, large->room, sizeof *large->back);
    norma_core_release(call, large->fan, large->room, sizeof *large->fan);
    *large = (large_star){0};
}

typedef struct large_visit {
    const core_prepared_mesh *prepared;
    const position_visit *visit;
    const large_star *large;
    const uint32_t *corners; /* of the star, count of them */
    size_t count, listed[2]; /* in out and in back: corners that have edges */
    core_star *star;         /* for some of them */
    stars_part *part;
} large_visit;

/* ---- the edges */

static uint64_t entry_of(uint32_t other, size_t number) { return (uint64_t)other << 32 | number; }

/* Nonzero where a caller who is told of progress wants to stop. */
static int stops(const large_visit *l, size_t at) {
    return at % CORNERS_BETWEEN_TELLING == 0 && norma_core_progress(l->prepared->call, 1);
}

static norma_result list_corners(large_visit *l) {
    for (size_t begin = 0; begin < l->count; begin += STAR_ROOM) {
        if (stops(l, begin)) return NORMA_CANCELLED;
        norma_core_star_fill(l->prepared, l->corners + begin,
            l->count - begin < STAR_ROOM ? l->count - begin : STAR_ROOM, 0, l->star);
        for (size_t i = 0; i < l->star->count; ++i) {
            const star_corner *c = &l->star->corners[i];
            l->large->fan[begin + i] = (uint32_t)(begin + i);
            if (!(c->flags & STAR_KEPT)) continue;
            l->large->out[l->listed[0]++] = entry_of(c->next, begin + i);
            l->large->back[l->listed[1]++] = entry_of(c->previous, begin + i);
        }
    }
    return NORMA_OK;
}

/* How far the entries of the same other position go. */
static size_t run_end(const uint64_t *entries, size_t begin, size_t count, uint32_t other) {
    while (begin < count && entries[begin] >> 32 == other) ++begin;
    return begin;
}

typedef struct edge_run {
    size_t begin[2], end[2];
} edge_run; /* in out and in back: one edge, or some in a row */

static size_t run_length(const edge_run *run) {
    return run->end[0] - run->begin[0] + run->end[1] - run->begin[1];
}

static edge_run next_edge(const large_visit *l, const size_t at[2]) {
    const uint64_t *const lists[2] = {l->large->out, l->large->back};
    uint32_t other = UINT32_MAX;
    edge_run run = {{at[0], at[1]}, {0, 0}};
    for (int side = 0; side < 2; ++side)
        if (at[side] < l->listed[side] && lists[side][at[side]] >> 32 < other)
            other = (uint32_t)(lists[side][at[side]] >> 32);
    for (int side = 0; side < 2; ++side)
        run.end[side] = run_end(lists[side], at[side], l->listed[side], other);
    return run;
}

/* What the star found joined is joined. numbers: of its corners in the large one. */
static void carry_over(const large_visit *l, core_star *star, const uint32_t *numbers) {
    for (uint32_t i = 0; i < star->count; ++i) {
        const uint32_t fan = norma_core_set_of(star->joined, i);
        if (fan != i) norma_core_join_sets(l->large->fan, numbers[i], numbers[fan]);
    }
}

/* A corner that is at two of the edges comes twice. fan_of serves for the corners' numbers, since
 * this star's fans are never numbered. */
static void join_run(const large_visit *l, const edge_run *run, core_star *star) {
    uint32_t *numbers = star->fan_of, *corners = (uint32_t *)(void *)star->sorted;
    size_t count = 0;
    for (size_t i = run->begin[0]; i < run->end[0]; ++i)
        numbers[count++] = (uint32_t)l->large->out[i];
    for (size_t i = run->begin[1]; i < run->end[1]; ++i)
        numbers[count++] = (uint32_t)l->large->back[i];
    for (size_t i = 0; i < count; ++i) corners[i] = l->corners[numbers[i]];
    norma_core_star_fill(l->prepared, corners, count, 0, star);
    star->edge_count = count;
    for (uint32_t i = 0; i < count; ++i) {
        const star_corner *c = &star->corners[i];
        if (i < run->end[0] - run->begin[0])
            star->edges[i] = (star_edge){.key = c->next_key, .other = c->next, .corner = i};
        else
            star->edges[i] =
                (star_edge){.key = c->previous_key, .other = c->previous, .back = 1, .corner = i};
    }
    norma_core_sort_edges(star);
    norma_core_star_join_listed(l->prepared, star, l->visit->counting ? &l->part->counts : NULL);
    carry_over(l, star, numbers);
}

/* An edge of more faces than an ordinary star has room for. */
static norma_result join_large_run(const large_visit *l, const edge_run *run) {
    core_star star;
    const size_t count = run_length(run);
    if (norma_core_star_allocate(l->prepared->call, &star, count)) return NORMA_ERROR_MEMORY;
    norma_core_star_begin(l->prepared, l->star->position, &star);
    join_run(l, run, &star);
    norma_core_star_release(l->prepared->call, &star, count);
    return NORMA_OK;
}

static norma_result join_edges(const large_visit *l) {
    edge_run some = {{0, 0}, {0, 0}};
    for (size_t edges = 0; some.end[0] < l->listed[0] || some.end[1] < l->listed[1]; ++edges) {
        const edge_run run = next_edge(l, some.end);
        if (stops(l, edges)) return NORMA_CANCELLED;
        if (run_length(&run) + run_length(&some) > STAR_ROOM && run_length(&some)) {
            join_run(l, &some, l->star);
            some = (edge_run){{run.begin[0], run.begin[1]}, {run.begin[0], run.begin[1]}};
        }
        if (run_length(&run) > STAR_ROOM) {
            if (join_large_run(l, &run)) return NORMA_ERROR_MEMORY;
            memcpy(some.begin, run.end, sizeof some.begin);
        }
        memcpy(some.end, run.end, sizeof some.end);
    }
    join_run(l, &some, l->star);
    return NORMA_OK;
}

/* ---- the fans */

/* The mesh's corners, fan by fan in the order of their first ones, each ascending; ends: at each
 * fan's first corner where it ends. Both in memory that the edges no longer need. */
static void order_by_fan(const large_visit *l, uint32_t *ends, uint32_t *ordered) {
    uint32_t *fan = l->large->fan, sum = 0;
    memset(ends, 0, l->count * sizeof *ends);
    for (size_t i = 0; i < l->count; ++i) {
        fan[i] = fan[fan[i]];
        ++ends[fan[i]];
    }
    for (size_t i = 0; i < l->count; ++i) {
        if (fan[i] != i) continue;
        const uint32_t count = ends[i];
        ends[i] = sum;
        sum += count;
    }
    for (size_t i = 0; i < l->count; ++i) ordered[ends[fan[i]]++] = l->corners[i];
}

static void see_fan(
    const large_visit *l, const star_sum *sum, const uint32_t *corners, size_t count) {
    core_fan fan = {
        .reason = l->star->finite ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE};
    if (l->star->finite && sum->votes) norma_core_decide_sum(sum->sum, sum->weight, &fan);
    const core_fans fans = {.position = l->star->position,
        .count = (uint32_t)count,
        .fan_count = 1,
        .corners = corners,
        .fans = &fan};
    l->visit->see(l->visit->context, &fans, &l->part->tally);
}

static norma_result see_fans(const large_visit *l) {
    uint32_t *ends = (uint32_t *)(void *)l->large->out,
             *ordered = (uint32_t *)(void *)l->large->back;
    size_t at = 0;
    order_by_fan(l, ends, ordered);
    for (size_t first = 0; first < l->count; ++first) {
        star_sum sum = {.votes = 0};
        const size_t begin = at;
        if (l->large->fan[first] != first) continue;
        for (; at < ends[first]; ++at) {
            if (stops(l, at)) return NORMA_CANCELLED;
            if (at % STAR_ROOM == 0)
                norma_core_star_fill(l->prepared, ordered + at,
                    l->count - at < STAR_ROOM ? l->count - at : STAR_ROOM, 1, l->star);
            norma_core_star_vote(&l->star->corners[at % STAR_ROOM], &sum);
        }
        see_fan(l, &sum, ordered + begin, at - begin);
    }
    return NORMA_OK;
}

static norma_result core_visit_large_star(const core_prepared_mesh *prepared,
    const position_visit *visit, uint32_t position, large_star *large, stars_part *part) {
    star_room room;
    core_star star;
    const core_corners_of_position *corners_of = &prepared->corners_of;
    const uint32_t begin = corners_of->starts[position];
    large_visit l = {.prepared = prepared,
        .visit = visit,
        .large = large,
        .corners = corners_of->corners + begin,
        .count = corners_of->starts[position + 1] - begin,
        .star = &star,
        .part = part};
    norma_core_star_in_room(&star, &room);
    norma_core_star_begin(prepared, position, &star);
    norma_result result = list_corners(&l);
    if (!result && star.waits) ++part->waiting;
    if (result || star.waits) return result;
    norma_core_count_add(&part->tally.degenerate, &star.degenerate);
    norma_core_sort_numbers(large->out, l.listed[0]);
    norma_core_sort_numbers(large->back, l.listed[1]);
    result = join_edges(&l);
    return !result ? see_fans(&l) : result;
}

/* ---- positions in chunks of fixed size, so that partial counts do not depend on the threads.
 * Ordinary stars are made many at a time, others one by one; those that a stack has no room for are
 * few, and come last, one after the other, in memory that is taken once. Where triangles without a
 * direction turn up, their stars wait until it is known whose they borrow. */

enum { POSITIONS_IN_CHUNK = 2048 };

typedef struct visit_all {
    core_prepared_mesh *prepared;
    const position_visit *visit;
    atomic_uchar *only; /* NULL, or nonzero at the positions whose stars waited */
    fans_simd *settle;
    kept_faces *kept; /* for each who works at once; NULL: stars are visited one by one */
    size_t kept_count;
    stars_part *parts;
} visit_all;

/* Loads, joins and sums the star of one position, but one that waits. star: with room for all
 * corners there. counts may be NULL. */
static void make_star(const core_prepared_mesh *prepared, core_join join, uint32_t position,
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
    make_star(
        v->prepared, v->visit->join, position, v->visit->counting ? &part->counts : NULL, star);
    if (v->visit->join == CORE_JOIN_FANS && star->waits) {
        ++part->waiting;
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
    for (size_t p = begin; p < end; ++p) {
        const size_t size = star_size(v, p);
        if (size > 0 && size <= STAR_ROOM) visit_position(v, (uint32_t)p, &star, part);
    }
}

/* Those of a list that are not ordinary after all. */
static void visit_singly(const visit_all *v, const star_list *list, stars_part *part) {
    star_room room;
    core_star star;
    norma_core_star_in_room(&star, &room);
    for (size_t i = 0; i < list->star_count; ++i)
        if (list->stars[i].fan_count == 0) visit_position(v, list->stars[i].position, &star, part);
}

/* All corners in one loop, since the end of a loop over each star's could not be foretold: corner
 * normals take 4 % less. */
static void write_ordinary(
    const core_output *output, const star_list *list, const fan_batch *batch) {
    const core_output to = *output; /* known not to change with what is written */
    const uint32_t *corners = list->corners;
    const size_t count = list->corner_count;
    for (size_t i = 0; i < count; ++i)
        norma_core_write_normal(&to, corners[i], batch->fans[batch->fan_of[i]].normal);
}

static void see_ordinary(
    const visit_all *v, const star_list *list, fan_batch *batch, stars_part *part) {
    star_member members[ORDINARY_CORNERS];
    uint32_t fan_of[ORDINARY_CORNERS];
    const core_corners_of_position *corners_of = &v->prepared->corners_of;
    for (size_t i = 0; i < list->star_count; ++i) {
        const listed_star *r = &list->stars[i];
        const core_fans fans = {r->position, r->count, r->fan_count,
            corners_of->corners + corners_of->starts[r->position], fan_of,
            batch->fans + r->first_fan, members, NULL};
        if (!r->fan_count) continue;
        for (uint32_t c = 0; c < r->count; ++c)
            fan_of[c] = batch->fan_of[r->begin + c] - r->first_fan;
        v->visit->see(v->visit->context, &fans, &part->tally);
    }
}

/* Lists ordinary stars from position on, as many as fit; what cannot be ordinary is visited at
 * once. Returns where the next list begins. */
static size_t list_stars(const visit_all *v, size_t position, size_t end, fan_batch *batch,
    star_list *list, stars_part *part) {
    const uint32_t *starts = v->prepared->corners_of.starts,
                   *corners = v->prepared->corners_of.corners;
    uint32_t count = 0, stars = 0, least = UINT32_MAX, most = 0;
    list->corners = NULL;
    for (; position < end; ++position) {
        const uint32_t size = starts[position + 1] - starts[position],
                       *at = corners + starts[position];
        if (!size || !star_size(v, position)) continue;
        if (size > ORDINARY_CORNERS) {
            if (size <= STAR_ROOM) visit_chunk_singly(v, position, position + 1, part);
            continue;
        }
        if (count + size > BATCH_CORNERS || (count && at != list->corners + count)) break;
        if (!count) list->corners = at;
        list->stars[stars++] = (listed_star){
            .position = (uint32_t)position, .begin = (uint16_t)count, .count = (uint16_t)size};
        count += size;
        least = at[0] < least ? at[0] : least;
        most = at[size - 1] > most ? at[size - 1] : most;
    }
    list->corner_count = count;
    list->star_count = stars;
    list->least = least;
    list->most = most;
    norma_core_read_list(v->prepared, batch, list);
    return position;
}

static kept_faces *take_kept(const visit_all *v) {
    size_t at = 0;
    while (atomic_exchange_explicit(&v->kept[at].taken, 1, memory_order_acquire))
        at = (at + 1) % v->kept_count;
    return &v->kept[at];
}

static void visit_in_batches(const visit_all *v, size_t position, size_t end, stars_part *part) {
    star_list list;
    fan_batch batch;
    batch.kept = take_kept(v);
    while (position = list_stars(v, position, end, &batch, &list, part), list.star_count) {
        const int all =
            v->settle(v->prepared, &list, &batch, v->visit->counting ? &part->counts.edges : NULL);
        if (all && batch.all_decided && v->visit->output)
            write_ordinary(v->visit->output, &list, &batch);
        else
            see_ordinary(v, &list, &batch, part);
        if (!all) visit_singly(v, &list, part);
    }
    atomic_store_explicit(&batch.kept->taken, 0, memory_order_release);
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
    if (v->kept)
        visit_in_batches(v, begin, end, &v->parts[chunk]);
    else
        visit_chunk_singly(v, begin, end, &v->parts[chunk]);
}

/* Where fans may come one by one, the memory for them all can be had for a tenth. */
static int go_by_fan(const visit_all *v) {
    return !CORE_IS_SMALL && v->visit->by_fan && v->visit->join == CORE_JOIN_FANS &&
           !norma_core_kept_faces(v->prepared) && !norma_core_sees(v->prepared->call);
}

static norma_result visit_large_stars(const visit_all *v, stars_part *part) {
    core_call *call = v->prepared->call;
    core_star star = {0};
    large_star large = {0};
    const size_t most = v->prepared->corners_of.most;
    const uint32_t *starts = v->prepared->corners_of.starts;
    const int by_fan = go_by_fan(v);
    if (most <= STAR_ROOM) return NORMA_OK;
    norma_result result = by_fan ? core_large_star_allocate(call, &large, most)
                                 : norma_core_star_allocate(call, &star, most);
    for (size_t p = 0; p < v->prepared->mesh.positions.count && !result; ++p) {
        if (starts[p + 1] - starts[p] <= STAR_ROOM || !star_size(v, p)) continue;
        if (by_fan)
            result = core_visit_large_star(v->prepared, v->visit, (uint32_t)p, &large, part);
        else
            visit_position(v, (uint32_t)p, &star, part);
        if (!result && norma_core_progress(call, 1)) result = NORMA_CANCELLED;
    }
    norma_core_star_release(call, &star, most);
    core_large_star_release(call, &large);
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
    v->parts = norma_core_allocate(call, chunks, sizeof *v->parts);
    if (!v->parts) return NORMA_ERROR_MEMORY;
    memset(v->parts, 0, chunks * sizeof *v->parts);
    v->kept = NULL;
    v->kept_count = norma_core_shares(call) < chunks ? norma_core_shares(call) : chunks;
    norma_result result = go_in_batches(v)
                              ? norma_core_kept_allocate(v->prepared, v->kept_count, &v->kept)
                              : NORMA_OK;
    if (!result) result = norma_core_parallel(call, chunks, visit_chunk, v);
    norma_core_kept_release(v->prepared, v->kept_count, v->kept);
    if (!result) result = visit_large_stars(v, sum);
    for (size_t i = 0; i < chunks; ++i) add_part(sum, &v->parts[i]);
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
    norma_result result =
        visit->join == CORE_JOIN_FANS ? norma_core_watch_for_flat(prepared) : NORMA_OK;
    if (!result) result = visit_in_parallel(&v, sum);
    if (result || !sum->waiting) return result;
    result = norma_core_borrow_directions(prepared);
    v.only = prepared->flat_at;
    return !result ? visit_in_parallel(&v, sum) : result;
}

/* ---- corners without a normal get that of the nearest that has one. The stars of the sources are
 * made a second time rather than all normals kept, since files where many corners lack one are
 * rare. */

typedef struct corner_request {
    uint32_t position, corner, target;
} corner_request; /* the normal of this corner, at this position, goes to target */

typedef struct corner_filling {
    const core_prepared_mesh *prepared;
    const uint8_t *reasons, *wanted;
    corner_taker *take;
    void *context;
    corner_request *requests; /* room for count of them; found: how many have a source */
    size_t count, found;
} corner_filling;

static int is_wanting(const corner_filling *f, size_t corner) {
    return f->wanted ? f->wanted[corner] : f->reasons[corner] != NORMA_REASON_NONE;
}

static norma_result find_sources(corner_filling *f) {
    const core_mesh *mesh = &f->prepared->mesh;
    core_nearest nearest;
    norma_result result = norma_core_nearest_begin(f->prepared->call, mesh, &nearest);
    if (result) return result;
    for (size_t c = 0; c < mesh->corner_count; ++c)
        if (f->reasons[c] == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, norma_core_corner(mesh, c), (uint32_t)c);
    result = norma_core_nearest_plant(&nearest, f->count);
    for (size_t c = 0; c < mesh->corner_count && !result; ++c) {
        if (!is_wanting(f, c)) continue;
        const uint32_t source = norma_core_nearest_find(&nearest, norma_core_corner(mesh, c));
        if (source == UINT32_MAX) break;
        f->requests[f->found++] =
            (corner_request){norma_core_welded_corner(mesh, source), source, (uint32_t)c};
    }
    norma_core_nearest_end(&nearest);
    return result;
}

static int request_less(const void *one, const void *other) {
    const corner_request *a = one, *b = other;
    if (a->position != b->position) return a->position < b->position;
    return a->target < b->target;
}

static const core_fan *fan_of_corner(const core_star *star, uint32_t corner) {
    size_t low = 0, high = star->count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (star->corners[middle].corner <= corner)
            low = middle;
        else
            high = middle;
    }
    return &star->fans[star->fan_of[low]];
}

static norma_result fetch_normals(const corner_filling *f) {
    const core_prepared_mesh *prepared = f->prepared;
    corner_request *requests = f->requests;
    core_star star;
    const size_t most = prepared->corners_of.most;
    if (norma_core_star_allocate(prepared->call, &star, most)) return NORMA_ERROR_MEMORY;
    norma_core_sort(requests, f->found, sizeof *requests, request_less);
    for (size_t i = 0; i < f->found; ++i) {
        if (i == 0 || requests[i].position != requests[i - 1].position)
            make_star(prepared, CORE_JOIN_FANS, requests[i].position, NULL, &star);
        f->take(f->context, requests[i].target, fan_of_corner(&star, requests[i].corner)->normal);
    }
    norma_core_star_release(prepared->call, &star, most);
    return NORMA_OK;
}

norma_result norma_core_fill_corners(const core_prepared_mesh *prepared, const uint8_t *reasons,
    const uint8_t *wanted, corner_taker *take, void *context) {
    const size_t corners = prepared->mesh.corner_count;
    const float zero[3] = {0, 0, 0};
    corner_filling f = {prepared, reasons, wanted, take, context, NULL, 0, 0};
    for (size_t c = 0; c < corners; ++c) f.count += is_wanting(&f, c) != 0;
    if (!f.count) return NORMA_OK;
    f.requests = norma_core_allocate(prepared->call, f.count, sizeof *f.requests);
    if (!f.requests) return NORMA_ERROR_MEMORY;
    norma_result result = find_sources(&f);
    if (!result && f.found) result = fetch_normals(&f);
    for (size_t c = 0; c < corners && !result && !f.found; ++c)
        if (is_wanting(&f, c)) take(context, (uint32_t)c, zero);
    norma_core_release(prepared->call, f.requests, f.count, sizeof *f.requests);
    return result;
}

/* ---- norma_corner_normals. The fans of all stars, written to the corners that are in them. */

typedef struct corner_work {
    const core_output *output;
    uint8_t *reasons; /* of each corner; NULL unless the nearest is asked for */
} corner_work;

static void write_fans(void *context, const core_fans *fans, core_tally *tally) {
    const corner_work *work = context;
    const core_output *output = work->output;
    const uint32_t *corners = fans->corners, *fan_of = fans->fan_of;
    const int reasons = work->reasons || output->reasons;
    for (size_t i = 0; i < fans->count; ++i) {
        const core_fan *fan = &fans->fans[fan_of ? fan_of[i] : 0];
        if (fan->reason == NORMA_REASON_NONE && !reasons) {
            norma_core_write_normal(output, corners[i], fan->normal);
            continue;
        }
        norma_core_write_element(output, corners[i], (int)fan->reason, fan->normal, tally);
        if (work->reasons) work->reasons[corners[i]] = (uint8_t)fan->reason;
    }
}

static void take_corner_normal(void *output, uint32_t corner, const float normal[3]) {
    norma_core_write_normal(output, corner, normal);
}

static norma_result compute_corners(
    core_prepared_mesh *prepared, const core_output *output, norma_report *report) {
    core_call *call = prepared->call;
    const size_t count = prepared->mesh.corner_count;
    corner_work work = {.output = output};
    stars_part sum = {.tally.degenerate = prepared->degenerate_faces};
    const position_visit visit = {.join = CORE_JOIN_FANS,
        .counting = norma_core_counts_edges(call, report),
        .by_fan = 1,
        .see = write_fans,
        .context = &work,
        .output = output->nearest || output->reasons ? NULL : output};
    if (output->nearest && !(work.reasons = norma_core_allocate(call, count, 1)))
        return NORMA_ERROR_MEMORY;
    if (work.reasons) memset(work.reasons, NORMA_REASON_NONE, count);
    norma_core_stage(call, 0.5, 0.97);
    norma_result result = norma_core_visit_positions(prepared, &visit, &sum);
    const size_t without =
        sum.tally.non_finite.count + sum.tally.unreferenced.count + sum.tally.cancelled.count;
    if (!result && work.reasons && without)
        result = norma_core_fill_corners(
            prepared, work.reasons, NULL, take_corner_normal, (void *)(uintptr_t)output);
    norma_core_release(call, work.reasons, count, 1);
    if (result) return result;
    norma_core_write_report(report, &sum.tally, &sum.counts.non_manifold, &sum.counts.conflicts);
    if (call->options.edges) *call->options.edges = sum.counts.edges;
    return NORMA_OK;
}

norma_result norma_corner_normals(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, float *normals, size_t capacity, norma_report *report) {
    core_call call;
    core_mesh checked;
    core_output output;
    core_prepared_mesh prepared;
    norma_result result =
        norma_core_begin_with_crease(&call, options, mesh, crease_angle_rad, &checked);
    if (!result)
        result = norma_core_output_open(&call, normals, checked.corner_count, capacity, &output);
    if (result) return result;
    norma_core_gather(&call);
    result = norma_core_prepare_fans(&call, &checked, crease_angle_rad, &prepared);
    if (!result) {
        result = norma_core_finish(&call, compute_corners(&prepared, &output, report));
        norma_core_prepared_mesh_close(&prepared);
    }
    norma_core_dismiss(&call);
    return result;
}
