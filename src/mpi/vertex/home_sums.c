/* home_sums.c: the votes that came from all ranks, merged by the numbers of their faces and added
 * to the sums of their slots; or gathered, slot by slot, for the most visible normal. */
#include "mpi/vertex/home_sums.h"
#include "core/call/output.h"
#include "core/corner/vertex_star.h"

typedef struct vote {
    uint32_t slot;
    double row[4];
} vote;

void norma_mpi_write_vote(
    unsigned char *record, int numbered, uint32_t slot, uint64_t face, const double row[4]) {
    memcpy(record, &slot, sizeof slot);
    memcpy(record + sizeof slot, row, 4 * sizeof *row);
    if (numbered) memcpy(record + sizeof slot + 4 * sizeof *row, &face, sizeof face);
}

static void read_vote(const unsigned char *record, vote *v) {
    memcpy(&v->slot, record, sizeof v->slot);
    memcpy(v->row, record + sizeof v->slot, sizeof v->row);
}

static uint64_t face_of(const unsigned char *record) {
    uint64_t face;
    memcpy(&face, record + sizeof(uint32_t) + 4 * sizeof(double), sizeof face);
    return face;
}

int norma_mpi_resolve(const vertex_sum *sum, float normal[3]) {
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
        if (child + 1 < m->waiting && comes_first(m, m->heap[child + 1], m->heap[child])) child++;
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
    m->face[rank] = face_of(norma_mpi_record(m->in, (size_t)m->next[rank]));
}

static void begin_merge(merge *m, int ranks) {
    for (int r = 0; r < ranks; r++) {
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

typedef void vote_taker(void *context, const vote *v);

static void take_in_order(const mpi_lists *in, size_t count, vote_taker *take, void *context) {
    for (size_t i = 0; i < count; i++) {
        vote v;
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
    if (result == NORMA_OK) begin_merge(&m, home->call->ranks);
    while (m.waiting) {
        vote v;
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
    vertex_sum *sums;
    uint64_t first;
} slot_sums;

static void add_vote(void *context, const vote *v) {
    const slot_sums *s = context;
    vertex_sum *sum = &s->sums[v->slot - s->first];
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
    for (size_t i = 0; i < home->count && result == NORMA_OK; i++) {
        mpi_outcome outcome = {{0, 0, 0}, 0};
        outcome.reason = (uint32_t)norma_mpi_resolve(&s.sums[i], outcome.normal);
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

static void keep_normal(void *context, const vote *v) {
    const slot_normals *s = context;
    memcpy(s->normals[s->ends[v->slot - s->first]++], v->row, sizeof s->normals[0]);
}

static void place_slots(const mpi_home *home, slot_normals *s, size_t votes) {
    uint32_t sum = 0;
    memset(s->ends, 0, home->count * sizeof *s->ends);
    for (size_t i = 0; i < votes; i++) {
        vote v;
        read_vote(norma_mpi_record(home->in, i), &v);
        s->ends[v.slot - home->first]++;
    }
    for (size_t i = 0; i < home->count; i++) {
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
    if (result == NORMA_OK) {
        place_slots(home, &s, votes);
        result = take_all(home, keep_normal, &s);
    }
    for (size_t i = 0; i < home->count && result == NORMA_OK; i++)
        home->outcomes[home->first + i] = see(&s, i);
    norma_core_release(core, s.normals, votes, sizeof *s.normals);
    norma_core_release(core, s.ends, home->count, sizeof *s.ends);
    return result;
}

norma_result norma_mpi_sum_at_home(const mpi_home *home) {
    return home->call->core->options.weight == NORMA_WEIGHT_VISIBLE ? see_slots(home)
                                                                    : sum_slots(home);
}
