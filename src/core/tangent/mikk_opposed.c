/* mikk_opposed.c: which corners of a large group are opposed to each other: unit vectors whose
 * cosine is -1, give or take roundings, lie within a thousandth of each other once one of them is
 * turned round. So they are looked for in the cells of a grid around it. */
#include "core/call/sort.h"
#include "core/tangent/mikk_apart.h"

static float cosine(const mikk_lane *a, size_t at, const mikk_lane *b, size_t to) {
    return a[0][at] * b[0][to] + a[1][at] * b[1][to] + a[2][at] * b[2][to];
}

static int are_one_quad(const mikk_star *star, size_t i, size_t j) {
    const size_t first = i < j ? i : j, second = i < j ? j : i;
    return star->corners[first] / 3 + 1 == star->corners[second] / 3 &&
           (mikk_flags_of(star, second) & MIKK_SECOND);
}

int norma_core_mikk_are_joined(const mikk_star *star, size_t i, size_t j) {
    const mikk_corners *a = mikk_block(star, i), *b = mikk_block(star, j);
    const size_t at = mikk_lane_of(star, i), to = mikk_lane_of(star, j);
    if (i == j || mikk_follows(star, i) || mikk_follows(star, j)) return 1;
    return (cosine(a->s, at, b->s, to) > -1 && cosine(a->t, at, b->t, to) > -1) ||
           are_one_quad(star, i, j);
}

/* ---- the grids */

enum { AT_A_TIME = 16 };
static const float CELLS = 256, /* to a unit */
    REACH = 0x1p-9F,            /* more than opposed vectors can be apart */
    UNIT = 1.000001F;           /* the square of a length: more is none that was made unit */

static void read_vectors(const mikk_crowd *c, uint32_t i, float v[6]) {
    const uint32_t j = c->corners[i];
    const mikk_corners *block = mikk_block(c->star, j);
    const size_t lane = mikk_lane_of(c->star, j);
    for (int k = 0; k < 3; k++) {
        v[k] = block->s[k][lane];
        v[3 + k] = block->t[k][lane];
    }
}

/* Longer than unit, or not finite: squares of its numbers were too small for floats. */
static int is_wild(const float v[6]) {
    return !(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] <= UNIT) ||
           !(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] <= UNIT);
}

static int cell_of(float x) { return (int)(x * CELLS + CELLS * 2); }

/* Different cells may have one key: then more is looked at. */
static mikk_cell *cell_at(const mikk_grid *g, const int cell[3]) {
    const uint32_t key = (uint32_t)cell[0] * UINT32_C(73856093) ^
                         (uint32_t)cell[1] * UINT32_C(19349663) ^
                         (uint32_t)cell[2] * UINT32_C(83492791);
    size_t slot = (key * UINT32_C(2654435769) >> 7) & (g->room - 1);
    while (g->cells[slot].count && g->cells[slot].key != key) slot = (slot + 1) & (g->room - 1);
    g->cells[slot].key = key;
    return &g->cells[slot];
}

static mikk_cell *home_of(const mikk_grid *g, const float v[6]) {
    int cell[3];
    for (int k = 0; k < 3; k++) cell[k] = cell_of(v[3 * g->of_t + k]);
    return cell_at(g, cell);
}

static void place(const mikk_grid *g, uint32_t i, const float v[6]) {
    const uint32_t to = home_of(g, v)->first++;
    g->order[to] = i;
    for (size_t k = 0; k < 6; k++) g->numbers[k * g->row_length + to] = v[k];
}

static void fill(const mikk_crowd *c, mikk_grid *g) {
    float v[6];
    uint32_t sum = 0;
    memset(g->cells, 0, g->room * sizeof *g->cells);
    memset(g->numbers, 0, 6 * g->row_length * sizeof *g->numbers);
    for (uint32_t i = 0; i < c->count; i++) {
        read_vectors(c, i, v);
        if (!is_wild(v)) home_of(g, v)->count++;
    }
    for (size_t s = 0; s < g->room; s++) {
        g->cells[s].first = sum;
        sum += g->cells[s].count;
    }
    for (uint32_t i = 0; i < c->count; i++) {
        read_vectors(c, i, v);
        if (!is_wild(v)) place(g, i, v);
    }
    for (size_t s = 0; s < g->room; s++) g->cells[s].first -= g->cells[s].count;
}

static int open_grid(const mikk_crowd *c, mikk_grid *g) {
    const core_call *call = c->star->mesh->call;
    g->room = 64;
    while (g->room < 2 * c->count) g->room *= 2;
    g->row_length = c->count + AT_A_TIME;
    g->cells = norma_core_allocate(call, g->room, sizeof *g->cells);
    g->order = norma_core_allocate(call, c->count, sizeof *g->order);
    g->numbers = norma_core_allocate(call, 6 * g->row_length, sizeof *g->numbers);
    return g->cells && g->order && g->numbers;
}

static void close_grid(const mikk_crowd *c, mikk_grid *g) {
    const core_call *call = c->star->mesh->call;
    norma_core_release(call, g->cells, g->room, sizeof *g->cells);
    norma_core_release(call, g->order, c->count, sizeof *g->order);
    norma_core_release(call, g->numbers, 6 * g->row_length, sizeof *g->numbers);
}

int norma_core_mikk_crowd_open(mikk_crowd *c) {
    float v[6];
    c->wild = norma_core_allocate(c->star->mesh->call, c->count, sizeof *c->wild);
    c->grids[1].of_t = 1;
    if (!c->wild || !open_grid(c, &c->grids[0]) || !open_grid(c, &c->grids[1])) return 0;
    for (uint32_t i = 0; i < c->count; i++) {
        read_vectors(c, i, v);
        if (is_wild(v)) c->wild[c->wild_count++] = i;
    }
    for (size_t g = 0; g < 2; g++) fill(c, &c->grids[g]);
    return 1;
}

void norma_core_mikk_crowd_close(mikk_crowd *c) {
    norma_core_release(c->star->mesh->call, c->wild, c->count, sizeof *c->wild);
    for (size_t g = 0; g < 2; g++) close_grid(c, &c->grids[g]);
}

/* ---- looking around */

typedef struct search {
    const mikk_crowd *crowd;
    uint32_t i;
    float v[6];
    uint64_t *found;
    size_t count;
} search;

static void meet(search *s, uint32_t other) {
    const mikk_crowd *c = s->crowd;
    if (!norma_core_mikk_are_joined(c->star, c->corners[s->i], c->corners[other]))
        s->found[s->count++] = other;
}

/* Bit l: the corner at place first + l is opposed in the grid's vector, and not in s if that has a
 * grid of its own; or is of the same quad. */
static unsigned opposed_lanes(const search *s, const mikk_grid *g, size_t first) {
    const float *n = g->numbers + first, *v = s->v;
    const size_t row = g->row_length;
    int32_t apart[AT_A_TIME];
    unsigned bits = 0;
    for (size_t l = 0; l < AT_A_TIME; l++) {
        const float along_s = v[0] * n[l] + v[1] * n[row + l] + v[2] * n[2 * row + l],
                    along_t = v[3] * n[3 * row + l] + v[4] * n[4 * row + l] + v[5] * n[5 * row + l];
        apart[l] = g->of_t ? (along_t <= -1) & (along_s > -1) : along_s <= -1;
    }
    for (size_t l = 0; l < AT_A_TIME; l++) bits |= (unsigned)apart[l] << l;
    return bits;
}

static void search_cell(search *s, const mikk_grid *g, const mikk_cell *cell) {
    for (uint32_t at = 0; at < cell->count; at += AT_A_TIME) {
        unsigned bits = opposed_lanes(s, g, cell->first + at);
        for (uint32_t l = at; bits && l < cell->count; l++, bits >>= 1)
            if ((bits & 1) && s->crowd->star->mesh->has_quads)
                meet(s, g->order[cell->first + l]);
            else if (bits & 1)
                s->found[s->count++] = g->order[cell->first + l];
    }
}

/* Cells of one key are one: each is searched once. */
static void search_grid(search *s, const mikk_grid *g) {
    enum { MOST_CELLS = 27 };
    const mikk_cell *seen[MOST_CELLS];
    size_t count = 0;
    int low[3], high[3], cell[3];
    for (int k = 0; k < 3; k++) {
        low[k] = cell_of(-s->v[3 * g->of_t + k] - REACH);
        high[k] = cell_of(-s->v[3 * g->of_t + k] + REACH);
    }
    for (cell[0] = low[0]; cell[0] <= high[0]; cell[0]++)
        for (cell[1] = low[1]; cell[1] <= high[1]; cell[1]++)
            for (cell[2] = low[2]; cell[2] <= high[2]; cell[2]++) {
                const mikk_cell *at = cell_at(g, cell);
                size_t i = 0;
                while (i < count && seen[i] != at) i++;
                if (i < count || !at->count || count == MOST_CELLS) continue;
                seen[count++] = at;
                search_cell(s, g, at);
            }
}

size_t norma_core_mikk_opponents(const mikk_crowd *c, uint32_t i, uint64_t *opponents) {
    search s = {.crowd = c, .i = i, .found = opponents};
    read_vectors(c, i, s.v);
    if (is_wild(s.v)) {
        for (uint32_t other = 0; other < c->count; other++) meet(&s, other);
        return s.count;
    }
    for (size_t g = 0; g < 2; g++) search_grid(&s, &c->grids[g]);
    for (size_t w = 0; w < c->wild_count; w++) meet(&s, c->wild[w]);
    norma_core_sort_numbers(s.found, s.count);
    return s.count;
}
