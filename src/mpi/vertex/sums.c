/* sums.c: the sum at each position, in ascending number of faces, wherever they are. */
#include "mpi/vertex/vertex.h"
#include "core/call/call.h"
#include "core/corner/corner.h"

/* ---- The votes that came from all ranks, merged by the numbers of their faces and added
 * to the sums of their slots; or gathered, slot by slot, for the most visible normal. */

/* The slot, the vote, and where numbered the number of its face. */
static size_t vote_size(int numbered) {
    return sizeof(uint32_t) + 4 * sizeof(double) + (numbered ? sizeof(uint64_t) : 0);
}

typedef struct mpi_home {
    const mpi_call *call;
    const mpi_lists *in; /* votes of each rank, in ascending number of faces */
    int numbered;        /* else each rank's faces follow those of the rank before */
    uint64_t first;      /* of count slots, which all votes are for */
    size_t count;
    mpi_outcome *outcomes; /* written, of these slots */
} mpi_home;

typedef struct slot_vote {
    uint32_t slot;
    double row[4];
} slot_vote;

static void mpi_write_vote(
    unsigned char *record, int numbered, uint32_t slot, uint64_t face, const double row[4]) {
    memcpy(record, &slot, sizeof slot);
    memcpy(record + sizeof slot, row, 4 * sizeof *row);
    if (numbered) memcpy(record + sizeof slot + 4 * sizeof *row, &face, sizeof face);
}

static void read_vote(const unsigned char *record, slot_vote *v) {
    memcpy(&v->slot, record, sizeof v->slot);
    memcpy(v->row, record + sizeof v->slot, sizeof v->row);
}

static uint64_t mpi_face_of(const unsigned char *record) {
    uint64_t face;
    memcpy(&face, record + sizeof(uint32_t) + 4 * sizeof(double), sizeof face);
    return face;
}

/* What becomes of a sum. */
static int mpi_resolve(const core_vertex_sum *sum, float normal[3]) {
    const double direction[3] = {sum->x, sum->y, sum->z};
    if (!norma_core_has_votes(sum)) return NORMA_REASON_UNREFERENCED;
    if (norma_core_cancels(direction, sum->weight)) return NORMA_REASON_CANCELLED;
    norma_core_direction(direction, normal);
    return NORMA_REASON_NONE;
}

/* ---- in ascending number of faces */

/* The ranks whose next vote waits, in a heap: that of the least face on top, ties the lower rank.
 */
typedef struct merge {
    const mpi_lists *in;
    int *next;      /* of each rank: its record */
    int *heap;      /* ranks */
    uint64_t *face; /* of each rank's next vote */
    int waiting;
} merge;

static int comes_first(const merge *m, int a, int b) {
    return m->face[a] < m->face[b] || (m->face[a] == m->face[b] && a < b);
}

static void sink(merge *m, int at) {
    for (int child = 2 * at + 1; child < m->waiting; child = 2 * at + 1) {
        if (child + 1 < m->waiting && comes_first(m, m->heap[child + 1], m->heap[child])) ++child;
        if (!comes_first(m, m->heap[child], m->heap[at])) return;
        const int rank = m->heap[at];
        m->heap[at] = m->heap[child];
        m->heap[child] = rank;
        at = child;
    }
}

static int is_over(const merge *m, int rank) {
    return m->next[rank] == m->in->starts[rank] + m->in->counts[rank];
}

static void look_at_next(merge *m, int rank) {
    m->face[rank] = mpi_face_of(norma_mpi_record(m->in, (size_t)m->next[rank]));
}

static void begin_merge(merge *m, int ranks) {
    for (int r = 0; r < ranks; ++r) {
        m->next[r] = m->in->starts[r];
        if (is_over(m, r)) continue;
        look_at_next(m, r);
        m->heap[m->waiting++] = r;
    }
    for (int i = m->waiting / 2; i-- > 0;) sink(m, i);
}

static const unsigned char *take_first(merge *m) {
    const int rank = m->heap[0];
    const unsigned char *record = norma_mpi_record(m->in, (size_t)m->next[rank]++);
    if (is_over(m, rank))
        m->heap[0] = m->heap[--m->waiting];
    else
        look_at_next(m, rank);
    sink(m, 0);
    return record;
}

typedef void vote_taker(void *context, const slot_vote *v);

static void take_in_order(const mpi_lists *in, size_t count, vote_taker *take, void *context) {
    for (size_t i = 0; i < count; ++i) {
        slot_vote v;
        read_vote(norma_mpi_record(in, i), &v);
        take(context, &v);
    }
}

static norma_result take_merged(const mpi_home *home, vote_taker *take, void *context) {
    const core_call *core = home->call->core;
    const size_t ranks = (size_t)home->call->ranks;
    merge m = {.in = home->in,
        .next = norma_core_allocate(core, ranks, sizeof *m.next),
        .heap = norma_core_allocate(core, ranks, sizeof *m.heap),
        .face = norma_core_allocate(core, ranks, sizeof *m.face)};
    const norma_result result = m.next && m.heap && m.face ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) begin_merge(&m, home->call->ranks);
    while (m.waiting) {
        slot_vote v;
        read_vote(take_first(&m), &v);
        take(context, &v);
    }
    norma_core_release(core, m.next, ranks, sizeof *m.next);
    norma_core_release(core, m.heap, ranks, sizeof *m.heap);
    norma_core_release(core, m.face, ranks, sizeof *m.face);
    return result;
}

static norma_result take_all(const mpi_home *home, vote_taker *take, void *context) {
    if (home->numbered) return take_merged(home, take, context);
    take_in_order(home->in, norma_mpi_lists_total(home->call, home->in), take, context);
    return NORMA_OK;
}

/* ---- sums */

typedef struct slot_sums {
    core_vertex_sum *sums;
    uint64_t first;
} slot_sums;

static void add_vote(void *context, const slot_vote *v) {
    const slot_sums *s = context;
    core_vertex_sum *sum = &s->sums[v->slot - s->first];
    sum->x += v->row[0];
    sum->y += v->row[1];
    sum->z += v->row[2];
    sum->weight += v->row[3];
}

static norma_result sum_slots(const mpi_home *home) {
    const core_call *core = home->call->core;
    slot_sums s = {norma_core_allocate(core, home->count, sizeof *s.sums), home->first};
    if (!s.sums) return NORMA_ERROR_MEMORY;
    norma_core_clear_sums(s.sums, home->count);
    const norma_result result = take_all(home, add_vote, &s);
    for (size_t i = 0; i < home->count && !result; ++i) {
        mpi_outcome outcome = {{0, 0, 0}, 0};
        outcome.reason = (uint32_t)mpi_resolve(&s.sums[i], outcome.normal);
        home->outcomes[home->first + i] = outcome;
    }
    norma_core_release(core, s.sums, home->count, sizeof *s.sums);
    return result;
}

/* ---- the most visible normal */

typedef struct slot_normals {
    double (*normals)[3]; /* of each slot, one after the other */
    uint32_t *ends;       /* of each slot, while they come: where the next goes */
    uint64_t first;
} slot_normals;

static void mpi_keep_normal(void *context, const slot_vote *v) {
    const slot_normals *s = context;
    memcpy(s->normals[s->ends[v->slot - s->first]++], v->row, sizeof s->normals[0]);
}

static void place_slots(const mpi_home *home, slot_normals *s, size_t votes) {
    uint32_t sum = 0;
    memset(s->ends, 0, home->count * sizeof *s->ends);
    for (size_t i = 0; i < votes; ++i) {
        slot_vote v;
        read_vote(norma_mpi_record(home->in, i), &v);
        ++s->ends[v.slot - home->first];
    }
    for (size_t i = 0; i < home->count; ++i) {
        const uint32_t count = s->ends[i];
        s->ends[i] = sum;
        sum += count;
    }
}

static mpi_outcome see(const slot_normals *s, size_t slot) {
    const uint32_t begin = slot ? s->ends[slot - 1] : 0, count = s->ends[slot] - begin;
    mpi_outcome outcome = {{0, 0, 0}, NORMA_REASON_UNREFERENCED};
    double axis[3];
    if (!count) return outcome;
    outcome.reason = NORMA_REASON_CANCELLED;
    if (!norma_core_smallest_cone((const double(*)[3])s->normals + begin, count, axis))
        return outcome;
    norma_core_direction(axis, outcome.normal);
    outcome.reason = NORMA_REASON_NONE;
    return outcome;
}

static norma_result see_slots(const mpi_home *home) {
    const core_call *core = home->call->core;
    const size_t votes = norma_mpi_lists_total(home->call, home->in);
    slot_normals s = {norma_core_allocate(core, votes, sizeof *s.normals),
        norma_core_allocate(core, home->count, sizeof *s.ends), home->first};
    norma_result result = s.normals && s.ends ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        place_slots(home, &s, votes);
        result = take_all(home, mpi_keep_normal, &s);
    }
    for (size_t i = 0; i < home->count && !result; ++i)
        home->outcomes[home->first + i] = see(&s, i);
    norma_core_release(core, s.normals, votes, sizeof *s.normals);
    norma_core_release(core, s.ends, home->count, sizeof *s.ends);
    return result;
}

/* MEMORY, or the outcomes. */
static norma_result mpi_sum_at_home(const mpi_home *home) {
    return home->call->core->options.weight == NORMA_WEIGHT_VISIBLE ? see_slots(home)
                                                                    : sum_slots(home);
}

/* ---- Each rank goes through its faces in ascending number. Votes for positions of its own are
 * added at once; those for shared ones go to their homes, which add them in ascending number of
 * faces over all ranks. They go in rounds, each for a range of the slots of every home: a round
 * brings all votes for its slots, so that no vote waits for a later one. */

enum { LEAST_VOTES = 1 << 12 };

typedef struct sum_rounds {
    mpi_call *call;
    mpi_sums *sums;
    uint64_t round, rounds;
    uint64_t *first, *count; /* of each home: the slots of this round */
    uint64_t *room;          /* of each home: votes that this rank has for it, in this round */
    uint8_t *corner_rounds;  /* with several rounds: round_mark the round of each corner, or 0 */
    mpi_lists *out;
} sum_rounds;

/* ---- which votes go in which round */

/* The first slot of a round at a home. */
static uint64_t first_slot(const sum_rounds *r, int home, uint64_t round) {
    const uint64_t slots = r->sums->sharing->slots[home];
    return slots / r->rounds * round + slots % r->rounds * round / r->rounds;
}
static void begin_round(sum_rounds *r) {
    for (int home = 0; home < r->call->ranks; ++home) {
        r->first[home] = first_slot(r, home, r->round);
        r->count[home] = first_slot(r, home, r->round + 1) - r->first[home];
    }
}
static int is_now(const sum_rounds *r, mpi_place place) {
    const int home = norma_mpi_home(place);
    return norma_mpi_kind(place) == MPI_SHARED &&
           norma_mpi_slot(place) - r->first[home] < r->count[home];
}

/* So that rounds pass over the corners of others without a look at their places. */
static uint8_t round_mark(uint64_t round) { return (uint8_t)(1 + round % 255); }

static uint64_t round_of_slot(const sum_rounds *r, mpi_place place) {
    const int home = norma_mpi_home(place);
    const uint64_t slot = norma_mpi_slot(place);
    uint64_t round = slot * r->rounds / r->sums->sharing->slots[home];
    while (round && first_slot(r, home, round) > slot) --round;
    while (first_slot(r, home, round + 1) <= slot) ++round;
    return round;
}

static mpi_place mpi_place_of(const mpi_sums *sums, size_t v) {
    return norma_mpi_place_at(sums->sharing, sums->merge ? sums->merge[v] : v);
}

static mpi_place place_of_corner(const mpi_sums *sums, size_t corner) {
    return mpi_place_of(sums, norma_core_corner(&sums->prepared->mesh, corner));
}

static int may_be_now(const sum_rounds *r, size_t corner) {
    return !r->corner_rounds || r->corner_rounds[corner] == round_mark(r->round);
}

/* The first round adds up what is summed here, too, and counts degenerate faces. */
static int wants_face(const sum_rounds *r, size_t f) {
    const core_mesh *mesh = &r->sums->prepared->mesh;
    if (!r->round && r->sums->degenerate) return 1;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c) {
        if (r->round && !may_be_now(r, c)) continue;
        const mpi_place place = place_of_corner(r->sums, c);
        if (is_now(r, place) || (!r->round && norma_mpi_kind(place) == MPI_OWN)) return 1;
    }
    return 0;
}

static void send_vote(const sum_rounds *r, mpi_place place, uint64_t face, const double vote[4]) {
    mpi_write_vote(norma_mpi_lists_add(r->out, norma_mpi_home(place)), r->sums->numbered,
        (uint32_t)norma_mpi_slot(place), face, vote);
}

static void take_vote(
    const sum_rounds *r, size_t face, size_t corner, double weight, const double normal[3]) {
    if (r->round && !may_be_now(r, corner)) return;
    const mpi_place place = place_of_corner(r->sums, corner);
    if (is_now(r, place)) {
        const double vote[4] = {weight * normal[0], weight * normal[1], weight * normal[2], weight};
        send_vote(r, place, norma_mpi_face_id(r->sums->faces, face), vote);
    } else if (!r->round && norma_mpi_kind(place) == MPI_OWN) {
        norma_core_add_vote(&r->sums->own[norma_mpi_slot(place)], weight, normal);
    }
}

/* ---- Triangles are measured eight at a time, as the core does; what doubles do not decide,
 * and polygons, by themselves. */

static norma_weight mpi_weight_of(const sum_rounds *r) {
    const norma_weight weight = r->call->core->options.weight;
    return weight == NORMA_WEIGHT_VISIBLE ? NORMA_WEIGHT_UNIFORM : weight;
}

static void visit_one(const sum_rounds *r, size_t f) {
    const core_mesh *mesh = &r->sums->prepared->mesh;
    norma_count *degenerate = r->round ? NULL : r->sums->degenerate;
    core_face face;
    norma_core_prepared_mesh_face(r->sums->prepared, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) {
        if (face.flags & CORE_FACE_FINITE && degenerate)
            norma_core_count_one(degenerate, (size_t)norma_mpi_face_id(r->sums->faces, f));
        return;
    }
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c) {
        if (!norma_core_is_kept(mesh, f, c)) continue;
        take_vote(
            r, f, c, norma_core_corner_weight(mesh, mpi_weight_of(r), f, &face, c), face.normal);
    }
}

static void visit_triangles(const sum_rounds *r, const size_t *faces, int count) {
    const core_prepared_mesh *prepared = r->sums->prepared;
    core_batch batch;
    const unsigned decided = norma_core_measure_triangles(
        prepared->call, &prepared->mesh, mpi_weight_of(r), faces, (size_t)count, &batch);
    for (int i = 0; i < count; ++i) {
        if (!(decided >> i & 1U)) {
            visit_one(r, faces[i]);
            continue;
        }
        const double normal[3] = {batch.normal[0][i], batch.normal[1][i], batch.normal[2][i]};
        for (size_t k = 0; k < 3; ++k)
            take_vote(r, faces[i], 3 * faces[i] + k, batch.weight[k][i], normal);
    }
}

/* The votes of the faces that are wanted, in ascending number of faces and corners: the numbers
 * that norma_vertex_normals adds. For the most visible normal all weigh 1. */
static void mpi_visit_votes(const sum_rounds *r) {
    size_t faces[CORE_LANES];
    int count = 0;
    for (size_t i = 0; i < r->sums->faces->count; ++i) {
        const size_t f = norma_mpi_face(r->sums->faces, i);
        if (!wants_face(r, f)) continue;
        if (r->sums->prepared->mesh.face_starts) {
            visit_one(r, f);
            continue;
        }
        faces[count++] = f;
        if (count < CORE_LANES) continue;
        visit_triangles(r, faces, count);
        count = 0;
    }
    if (count) visit_triangles(r, faces, count);
}

/* Their sums are complete after the first round's faces; nobody else votes where they go. */
static void send_loans(const sum_rounds *r) {
    const mpi_sharing *sharing = r->sums->sharing;
    for (size_t i = 0; i < sharing->loan_count; ++i) {
        const core_vertex_sum *sum = &r->sums->own[sharing->loans[i].sum];
        if (!is_now(r, sharing->loans[i].place) || !norma_core_has_votes(sum)) continue;
        send_vote(r, sharing->loans[i].place, UINT64_MAX,
            (const double[4]){sum->x, sum->y, sum->z, sum->weight});
    }
}

/* ---- rounds */

/* Of each home, at most: degenerate faces vote for nothing. */
static void count_votes(const sum_rounds *r, int all) {
    const mpi_sharing *sharing = r->sums->sharing;
    memset(r->room, 0, (size_t)r->call->ranks * sizeof *r->room);
    for (size_t c = 0; c < r->sums->prepared->mesh.corner_count; ++c) {
        if (!all && !may_be_now(r, c)) continue;
        const mpi_place place = place_of_corner(r->sums, c);
        if (all ? norma_mpi_kind(place) == MPI_SHARED : is_now(r, place))
            ++r->room[norma_mpi_home(place)];
    }
    for (size_t i = 0; i < sharing->loan_count; ++i) {
        const mpi_place place = sharing->loans[i].place;
        if (all || is_now(r, place)) ++r->room[norma_mpi_home(place)];
    }
}

static norma_result note_rounds(sum_rounds *r) {
    const size_t corners = r->sums->prepared->mesh.corner_count;
    if (r->rounds == 1) return NORMA_OK;
    r->corner_rounds = norma_core_allocate(r->call->core, corners, 1);
    if (!r->corner_rounds) return NORMA_ERROR_MEMORY;
    for (size_t c = 0; c < corners; ++c) {
        const mpi_place place = place_of_corner(r->sums, c);
        const int shared = norma_mpi_kind(place) == MPI_SHARED;
        r->corner_rounds[c] = shared ? round_mark(round_of_slot(r, place)) : 0;
    }
    return NORMA_OK;
}

/* So many that neither what a rank sends in one nor what it receives is beyond the budget. */
static norma_result choose_rounds(sum_rounds *r, size_t budget) {
    const size_t ranks = (size_t)r->call->ranks;
    uint64_t *counts = norma_core_allocate(r->call->core, ranks, sizeof *counts), sent = 0;
    norma_result result = norma_mpi_agree(r->call, counts ? NORMA_OK : NORMA_ERROR_MEMORY);
    if (!result) {
        size_t most = budget / (2 * vote_size(r->sums->numbered));
        if (most < LEAST_VOTES) most = LEAST_VOTES;
        count_votes(r, 1);
        for (size_t i = 0; i < ranks; ++i) sent += r->room[i];
        MPI_Allreduce(r->room, counts, r->call->ranks, MPI_UINT64_T, MPI_SUM, r->call->comm);
        if (counts[r->call->rank] > sent) sent = counts[r->call->rank];
        r->rounds = norma_mpi_largest(r->call, sent / most + 1);
    }
    norma_core_release(r->call->core, counts, ranks, sizeof *counts);
    return !result ? norma_mpi_agree(r->call, note_rounds(r)) : result;
}

static norma_result list_votes(sum_rounds *r, mpi_lists *out) {
    if (r->rounds > 1) count_votes(r, 0);
    const norma_result result =
        norma_mpi_lists_open(r->call, r->room, vote_size(r->sums->numbered), out);
    if (result) return result;
    r->out = out;
    mpi_visit_votes(r);
    send_loans(r);
    return NORMA_OK;
}

static norma_result mpi_run_round(sum_rounds *r) {
    mpi_call *call = r->call;
    mpi_lists out = {0}, in = {0};
    begin_round(r);
    norma_result result =
        norma_mpi_exchange(call, MPI_CONTRIBUTIONS, list_votes(r, &out), &out, &in);
    norma_mpi_lists_close(call, &out);
    if (result) return result;
    const mpi_home home = {.call = call,
        .in = &in,
        .numbered = r->sums->numbered,
        .first = r->first[call->rank],
        .count = (size_t)r->count[call->rank],
        .outcomes = r->sums->outcomes};
    result = mpi_sum_at_home(&home);
    norma_mpi_lists_close(call, &in);
    return norma_mpi_step(call, (double)(r->round + 1) / (double)r->rounds, result);
}

static norma_result open_sums(const mpi_call *call, mpi_sums *sums) {
    const mpi_sharing *sharing = sums->sharing;
    const size_t slots = (size_t)sharing->slots[call->rank];
    sums->own = norma_core_allocate(call->core, (size_t)sharing->own, sizeof *sums->own);
    sums->outcomes = norma_core_allocate(call->core, slots, sizeof *sums->outcomes);
    if (!sums->own || !sums->outcomes) return NORMA_ERROR_MEMORY;
    norma_core_clear_sums(sums->own, (size_t)sharing->own);
    return NORMA_OK;
}

norma_result norma_mpi_sum_all(mpi_call *call, size_t budget, mpi_sums *sums) {
    const size_t ranks = (size_t)call->ranks;
    sum_rounds r = {.call = call,
        .sums = sums,
        .first = norma_core_allocate(call->core, ranks, sizeof *r.first),
        .count = norma_core_allocate(call->core, ranks, sizeof *r.count),
        .room = norma_core_allocate(call->core, ranks, sizeof *r.room)};
    sums->own = NULL;
    sums->outcomes = NULL;
    norma_result result = open_sums(call, sums);
    result = norma_mpi_agree(call, r.first && r.count && r.room ? result : NORMA_ERROR_MEMORY);
    if (!result) result = choose_rounds(&r, budget);
    for (; r.round < r.rounds && !result; ++r.round) result = mpi_run_round(&r);
    norma_core_release(call->core, r.first, ranks, sizeof *r.first);
    norma_core_release(call->core, r.count, ranks, sizeof *r.count);
    norma_core_release(call->core, r.room, ranks, sizeof *r.room);
    norma_core_release(call->core, r.corner_rounds, sums->prepared->mesh.corner_count, 1);
    if (result) norma_mpi_sums_close(call, sums);
    return result;
}

void norma_mpi_sums_close(const mpi_call *call, mpi_sums *sums) {
    norma_core_release(call->core, sums->own, (size_t)sums->sharing->own, sizeof *sums->own);
    norma_core_release(call->core, sums->outcomes, (size_t)sums->sharing->slots[call->rank],
        sizeof *sums->outcomes);
    sums->own = NULL;
    sums->outcomes = NULL;
}

/* ---- handing out */

typedef struct hand_out {
    mpi_call *call;
    const mpi_sums *sums;
    size_t begin, end; /* the positions of this round */
} hand_out;

enum { OUTCOME_SIZE = 3 * sizeof(float) + 1 };

static int is_at_home(mpi_place place) {
    return norma_mpi_kind(place) == MPI_SHARED || norma_mpi_kind(place) == MPI_ASKED;
}

static int home_of_question(const void *context, size_t i) {
    const hand_out *h = context;
    const mpi_place place = mpi_place_of(h->sums, h->begin + i);
    return is_at_home(place) ? norma_mpi_home(place) : -1;
}

static void write_question(const void *context, size_t i, unsigned char *record) {
    const hand_out *h = context;
    const uint32_t slot = (uint32_t)norma_mpi_slot(mpi_place_of(h->sums, h->begin + i));
    memcpy(record, &slot, sizeof slot);
}

static norma_result answer_outcomes(void *context, const mpi_lists *in, mpi_lists *answers) {
    const hand_out *h = context;
    const size_t count = norma_mpi_lists_total(h->call, in);
    for (size_t i = 0; i < count; ++i) {
        uint32_t slot;
        memcpy(&slot, norma_mpi_record(in, i), sizeof slot);
        const mpi_outcome *outcome = &h->sums->outcomes[slot];
        unsigned char *record = norma_mpi_record(answers, i);
        memcpy(record, outcome->normal, sizeof outcome->normal);
        record[sizeof outcome->normal] = (unsigned char)outcome->reason;
    }
    return NORMA_OK;
}

static void receive_one(const hand_out *h, size_t v, const mpi_lists *back, int *next,
    mpi_receiver *receive, void *context) {
    const mpi_place place = mpi_place_of(h->sums, v);
    float normal[3] = {0, 0, 0};
    int reason = NORMA_REASON_UNREFERENCED;
    if (norma_mpi_kind(place) == MPI_NOWHERE) return;
    if (is_at_home(place)) {
        const unsigned char *record = norma_mpi_record(back, (size_t)next[norma_mpi_home(place)]++);
        memcpy(normal, record, sizeof normal);
        reason = record[sizeof normal];
    } else {
        reason = mpi_resolve(&h->sums->own[norma_mpi_slot(place)], normal);
    }
    receive(context, v, reason, normal);
}

static norma_result receive_some(
    const hand_out *h, const mpi_lists *back, mpi_receiver *receive, void *context) {
    const size_t ranks = (size_t)h->call->ranks;
    int *next = norma_core_allocate(h->call->core, ranks, sizeof *next);
    if (!next) return NORMA_ERROR_MEMORY;
    memcpy(next, back->starts, ranks * sizeof *next);
    for (size_t v = h->begin; v < h->end; ++v) receive_one(h, v, back, next, receive, context);
    norma_core_release(h->call->core, next, ranks, sizeof *next);
    return NORMA_OK;
}

static norma_result hand_out_some(hand_out *h, mpi_receiver *receive, void *context) {
    const mpi_listing listing = {
        h->end - h->begin, sizeof(uint32_t), home_of_question, write_question, h};
    mpi_lists back;
    norma_result result =
        norma_mpi_ask(h->call, MPI_NORMALS, &listing, OUTCOME_SIZE, answer_outcomes, h, &back);
    if (!result) result = norma_mpi_agree(h->call, receive_some(h, &back, receive, context));
    norma_mpi_lists_close(h->call, &back);
    return result;
}

norma_result norma_mpi_hand_out(
    mpi_call *call, const mpi_sums *sums, size_t budget, mpi_receiver *receive, void *context) {
    const size_t count = sums->sharing->count,
                 some = budget / (2 * (sizeof(uint32_t) + OUTCOME_SIZE)) + 1;
    hand_out h = {.call = call, .sums = sums};
    const uint64_t rounds = norma_mpi_largest(call, count / some + 1);
    norma_result result = NORMA_OK;
    for (uint64_t round = 0; round < rounds && !result; ++round) {
        h.begin = h.end;
        h.end = count - h.begin < some ? count : h.begin + some;
        result = hand_out_some(&h, receive, context);
    }
    return result;
}
