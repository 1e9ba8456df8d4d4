/* mikk_left_out.c: many float sums over the same numbers, each of which leaves out a few, in far
 * less than the time of one after the other.
 *
 * A sum is as the one that leaves out nothing until its first gap. From there on it is a sum of its
 * own, and all of those go forward together: adding rounds monotonically, so that sums in ascending
 * order stay so, and those that have become equal are one from then on. While all lie in one binade
 * and no rounding is a tie, each moves by the same distance, and only the lowest and the highest
 * are looked at. */
#include "core/call/sort.h"
#include "core/tangent/mikk_apart.h"

enum {
    RUN = 32,          /* gaps that lie nearer to each other are passed by one sum alone */
    MOST_FRESH = 8192, /* sums that have not been sorted in yet */
    FEW_FRESH = 64,
    WORTH_SORTING = 256, /* fresh sums squared, for each sum that is sorted */
    AT_A_TIME = 16
};

/* Gaps of one sum that lie near each other. After them it is put among the others, as a node; a
 * node that has met another of its value hangs on that one. A node is left at the sum's next run,
 * and forgotten once all have left it. */
typedef struct run {
    uint32_t sum, begin, end; /* begin, end: in positions */
} run;

static const uint32_t IS_FRESH = UINT32_C(1) << 31;

struct mikk_sums {
    const core_call *call;
    const mikk_left_out *left_out;
    size_t addend_count, position_count, run_count;
    const float *addends;
    run *runs;           /* sum by sum */
    uint32_t *begins;    /* of each addend: where in by_begin the runs are that begin there */
    uint32_t *by_begin;  /* numbers of runs */
    uint32_t *waits;     /* of each addend: the first run that ends there, or MIKK_NONE */
    uint32_t *next_wait; /* of each run */
    float *alone;        /* of each run: the sum once it is past */
    uint32_t *parent;    /* of each node, which has the number of its run; itself if it is a root */
    uint32_t *place;     /* of each root: where its value is */
    uint32_t *users;     /* of each root: how many sums have its value */
    float *values, *spare_values; /* ascending; the value is this plus shift */
    uint32_t *nodes, *spare_nodes;
    size_t count;
    double shift;
    float lowest, highest;
    int finite; /* all addends are */
    float fresh[MOST_FRESH];
    uint32_t fresh_nodes[MOST_FRESH];
    uint64_t ranked[MOST_FRESH];
    size_t fresh_count;
};

/* ---- runs */

static void find_runs(mikk_sums *s) {
    const mikk_left_out *l = s->left_out;
    for (uint32_t i = 0; i < l->sum_count; i++)
        for (uint32_t at = l->starts[i]; at < l->starts[i + 1]; at++) {
            if (at == l->starts[i] || l->positions[at] - l->positions[at - 1] > RUN)
                s->runs[s->run_count++] = (run){i, at, at};
            s->runs[s->run_count - 1].end = at + 1;
        }
    memset(s->begins, 0, (s->addend_count + 1) * sizeof *s->begins);
    for (size_t r = 0; r < s->run_count; r++) s->begins[l->positions[s->runs[r].begin]]++;
    uint32_t sum = 0;
    for (size_t p = 0; p <= s->addend_count; p++) s->begins[p] = sum += s->begins[p];
    for (uint32_t r = (uint32_t)s->run_count; r-- > 0;)
        s->by_begin[--s->begins[l->positions[s->runs[r].begin]]] = r;
}

mikk_sums *norma_core_mikk_sums_open(
    const core_call *call, const mikk_left_out *left_out, size_t addend_count) {
    const size_t positions = left_out->starts[left_out->sum_count];
    mikk_sums *s = norma_core_allocate(call, 1, sizeof *s);
    if (!s) return NULL;
    memset(s, 0, sizeof *s);
    s->call = call;
    s->left_out = left_out;
    s->addend_count = addend_count;
    s->position_count = positions;
    s->runs = norma_core_allocate(call, positions, sizeof *s->runs);
    s->begins = norma_core_allocate(call, addend_count + 1, sizeof *s->begins);
    s->waits = norma_core_allocate(call, addend_count, sizeof *s->waits);
    s->by_begin = norma_core_allocate(call, 7 * positions, sizeof *s->by_begin);
    s->alone = norma_core_allocate(call, 3 * positions, sizeof *s->alone);
    if (!s->runs || !s->begins || !s->waits || !s->by_begin || !s->alone) {
        norma_core_mikk_sums_close(s);
        return NULL;
    }
    s->next_wait = s->by_begin + positions;
    s->parent = s->by_begin + 2 * positions;
    s->place = s->by_begin + 3 * positions;
    s->nodes = s->by_begin + 4 * positions;
    s->spare_nodes = s->by_begin + 5 * positions;
    s->users = s->by_begin + 6 * positions;
    s->values = s->alone + positions;
    s->spare_values = s->alone + 2 * positions;
    find_runs(s);
    return s;
}

void norma_core_mikk_sums_close(mikk_sums *s) {
    const core_call *call = s->call;
    norma_core_release(call, s->runs, s->position_count, sizeof *s->runs);
    norma_core_release(call, s->begins, s->addend_count + 1, sizeof *s->begins);
    norma_core_release(call, s->waits, s->addend_count, sizeof *s->waits);
    norma_core_release(call, s->by_begin, 7 * s->position_count, sizeof *s->by_begin);
    norma_core_release(call, s->alone, 3 * s->position_count, sizeof *s->alone);
    norma_core_release(call, s, 1, sizeof *s);
}

/* ---- sorted sums */

static uint32_t root_of(const mikk_sums *s, uint32_t node) {
    uint32_t root = node;
    while (s->parent[root] != root) root = s->parent[root];
    while (s->parent[node] != root) {
        const uint32_t next = s->parent[node];
        s->parent[node] = root;
        node = next;
    }
    return root;
}

static float value_of(const mikk_sums *s, uint32_t node) {
    const uint32_t at = s->place[root_of(s, node)];
    return at & IS_FRESH ? s->fresh[at ^ IS_FRESH] : (float)((double)s->values[at] + s->shift);
}

static uint32_t bits_of(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* In the order of floats. */
static uint32_t rank_of(float x) {
    const uint32_t bits = bits_of(x);
    return bits >> 31 ? ~bits : bits | UINT32_C(1) << 31;
}

static void settle(mikk_sums *s) {
    for (size_t i = 0; i < s->count && s->shift != 0; i++)
        s->values[i] = (float)((double)s->values[i] + s->shift);
    s->shift = 0;
}

static void find_ends(mikk_sums *s) {
    if (!s->count) return;
    s->lowest = s->values[0];
    s->highest = s->values[s->count - 1];
}

/* To the end of the sorted ones; what has the same bits as the last joins it. */
static void append(mikk_sums *s, float value, uint32_t node) {
    if (!s->users[node]) return;
    if (s->count && bits_of(s->values[s->count - 1]) == bits_of(value)) {
        s->parent[node] = s->nodes[s->count - 1];
        s->users[s->nodes[s->count - 1]] += s->users[node];
        return;
    }
    s->values[s->count] = value;
    s->nodes[s->count] = node;
    s->place[node] = (uint32_t)s->count++;
}

static void swap_spare(mikk_sums *s) {
    float *values = s->values;
    uint32_t *nodes = s->nodes;
    s->values = s->spare_values;
    s->nodes = s->spare_nodes;
    s->spare_values = values;
    s->spare_nodes = nodes;
}

/* Fresh sums go among the sorted ones. */
static void sort_in(mikk_sums *s) {
    uint64_t *ranked = s->ranked;
    const size_t count = s->count;
    size_t at = 0;
    settle(s);
    for (size_t i = 0; i < s->fresh_count; i++)
        ranked[i] = (uint64_t)rank_of(s->fresh[i]) << 32 | i;
    norma_core_sort_numbers(ranked, s->fresh_count);
    swap_spare(s);
    s->count = 0;
    for (size_t i = 0; i < s->fresh_count; i++) {
        const size_t from = (size_t)(uint32_t)ranked[i];
        for (; at < count && rank_of(s->spare_values[at]) <= ranked[i] >> 32; at++)
            append(s, s->spare_values[at], s->spare_nodes[at]);
        append(s, s->fresh[from], s->fresh_nodes[from]);
    }
    for (; at < count; at++) append(s, s->spare_values[at], s->spare_nodes[at]);
    s->fresh_count = 0;
    find_ends(s);
}

static void add_fresh(mikk_sums *s, float value, uint32_t node) {
    const size_t count = s->fresh_count;
    if (count == MOST_FRESH || (count >= FEW_FRESH && count * count >= WORTH_SORTING * s->count))
        sort_in(s);
    s->parent[node] = node;
    s->users[node] = 1;
    s->place[node] = (uint32_t)s->fresh_count | IS_FRESH;
    s->fresh_nodes[s->fresh_count] = node;
    s->fresh[s->fresh_count++] = value;
}

/* ---- a step */

/* The distance that all sums between two floats move, if it is the same for all. */
static int move_together(mikk_sums *s, float addend) {
    const float low = s->lowest + addend, high = s->highest + addend;
    const uint32_t binade = bits_of(s->lowest) >> 23;
    if (!s->finite || bits_of(s->highest) >> 23 != binade || bits_of(low) >> 23 != binade ||
        bits_of(high) >> 23 != binade || (binade & 0xff) < 26)
        return 0;
    const uint32_t half_bits = ((binade & 0xff) - 24) << 23;
    float half;
    memcpy(&half, &half_bits, sizeof half); /* of a unit of the last place */
    const double error = (double)s->lowest + (double)addend - (double)low;
    if (error == (double)half || error == -(double)half) return 0;
    s->shift += (double)low - (double)s->lowest;
    s->lowest = low;
    s->highest = high;
    return 1;
}

static void move_each(mikk_sums *s, float addend) {
    const size_t count = s->count;
    size_t equal = 0;
    settle(s);
    for (size_t i = 0; i < count; i++) s->values[i] += addend;
    for (size_t i = 1; i < count; i++) equal += bits_of(s->values[i]) == bits_of(s->values[i - 1]);
    if (equal) {
        s->count = 0;
        for (size_t i = 0; i < count; i++) append(s, s->values[i], s->nodes[i]);
    }
    find_ends(s);
}

static void step(mikk_sums *s, float addend) {
    for (size_t i = 0; i < s->fresh_count; i += AT_A_TIME) /* some more than there are */
        for (size_t l = 0; l < AT_A_TIME; l++) s->fresh[i + l] += addend;
    if (s->count && !move_together(s, addend)) move_each(s, addend);
}

/* ---- the sums */

/* The sum that this run begins with: whole before its first one. */
static float sum_before(mikk_sums *s, uint32_t r, float whole) {
    if (!r || s->runs[r - 1].sum != s->runs[r].sum) return whole;
    const float value = value_of(s, r - 1);
    s->users[root_of(s, r - 1)]--;
    return value;
}

/* Those that begin a run of gaps here go through it by themselves. */
static void begin_runs(mikk_sums *s, uint32_t position, float whole) {
    const uint32_t *positions = s->left_out->positions;
    for (uint32_t k = s->begins[position]; k < s->begins[position + 1]; k++) {
        const uint32_t r = s->by_begin[k];
        const run of = s->runs[r];
        const uint32_t last = positions[of.end - 1];
        float sum = sum_before(s, r, whole);
        uint32_t gap = of.begin;
        for (uint32_t p = position; p < last; p++) {
            if (positions[gap] == p)
                gap++;
            else
                sum += s->addends[p];
        }
        s->alone[r] = sum;
        s->next_wait[r] = s->waits[last];
        s->waits[last] = r;
    }
}

static int are_finite(const float *numbers, size_t count) {
    float zero = 0;
    for (size_t i = 0; i < count; i++) zero += numbers[i] - numbers[i];
    return zero == 0;
}

float norma_core_mikk_sums_run(mikk_sums *s, const float *addends, float *out) {
    float whole = 0;
    s->addends = addends;
    s->finite = are_finite(addends, s->addend_count);
    s->count = s->fresh_count = 0;
    s->shift = 0;
    memset(s->fresh, 0, sizeof s->fresh);
    memset(s->waits, 0xff, s->addend_count * sizeof *s->waits);
    for (uint32_t p = 0; p < s->addend_count; p++) {
        begin_runs(s, p, whole);
        whole += addends[p];
        step(s, addends[p]);
        for (uint32_t r = s->waits[p]; r != MIKK_NONE; r = s->next_wait[r])
            add_fresh(s, s->alone[r], r);
    }
    for (size_t r = 0; r < s->run_count; r++)
        if (r + 1 == s->run_count || s->runs[r + 1].sum != s->runs[r].sum)
            out[s->runs[r].sum] = value_of(s, (uint32_t)r);
    return whole;
}
