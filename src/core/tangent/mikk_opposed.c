/* mikk_opposed.c: which corners of a large group are opposed to another one: unit vectors whose
 * cosine is -1, give or take roundings, lie within a thousandth of each other once one of them is
 * turned round. So they are looked for in the cells of a grid around it. */
#include "core/tangent/mikk_star.h"

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

/* ---- the grid: of one of the two vectors of each corner */

static const float CELLS = 128, /* to a unit */
    REACH = 0x1p-9F;            /* more than the vectors can be apart */

typedef struct grid {
    mikk_star *star;
    size_t room; /* of the table, as much as the group needs: a power of two */
    int of_t;
} grid;

static const mikk_lane *vector_of(const grid *g, uint32_t j) {
    const mikk_corners *block = mikk_block(g->star, j);
    return g->of_t ? block->t : block->s;
}

/* Different cells may have one key: then more is looked at. */
static struct mikk_edge *cell_at(const grid *g, const int cell[3]) {
    const mikk_edge_table *table = g->star->table;
    const uint32_t key = (uint32_t)cell[0] * UINT32_C(73856093) ^
                         (uint32_t)cell[1] * UINT32_C(19349663) ^
                         (uint32_t)cell[2] * UINT32_C(83492791);
    size_t slot = (key * UINT32_C(2654435769) >> 7) & (g->room - 1);
    while (table->edges[slot].first != MIKK_NONE && table->edges[slot].vertex != key)
        slot = (slot + 1) & (g->room - 1);
    table->edges[slot].vertex = key;
    return &table->edges[slot];
}

static int cell_of(float x) { return (int)(x * CELLS + CELLS * 2); }

/* 0: a number is not finite. */
static int insert(const grid *g, uint32_t j) {
    const mikk_lane *v = vector_of(g, j);
    const size_t lane = mikk_lane_of(g->star, j);
    int cell[3];
    for (int k = 0; k < 3; k++) {
        if (!(v[k][lane] > -1.5F && v[k][lane] < 1.5F)) return 0;
        cell[k] = cell_of(v[k][lane]);
    }
    struct mikk_edge *of = cell_at(g, cell);
    g->star->table->following[j] = of->first;
    of->first = j;
    return 1;
}

static int opposes_in_cell(const grid *g, uint32_t j, const int cell[3]) {
    for (uint32_t i = cell_at(g, cell)->first; i != MIKK_NONE; i = g->star->table->following[i])
        if (!norma_core_mikk_are_joined(g->star, j, i)) return 1;
    return 0;
}

static int has_opposed(const grid *g, uint32_t j) {
    const mikk_lane *v = vector_of(g, j);
    const size_t lane = mikk_lane_of(g->star, j);
    int low[3], high[3], cell[3];
    for (int k = 0; k < 3; k++) {
        low[k] = cell_of(-v[k][lane] - REACH);
        high[k] = cell_of(-v[k][lane] + REACH);
    }
    for (cell[0] = low[0]; cell[0] <= high[0]; cell[0]++)
        for (cell[1] = low[1]; cell[1] <= high[1]; cell[1]++)
            for (cell[2] = low[2]; cell[2] <= high[2]; cell[2]++)
                if (opposes_in_cell(g, j, cell)) return 1;
    return 0;
}

static int mark(const grid *g, uint32_t first, const uint32_t *following) {
    mikk_star *star = g->star;
    memset(star->table->edges, 0xff, g->room * sizeof *star->table->edges);
    for (uint32_t j = first; j != MIKK_NONE; j = following[j])
        if (!mikk_follows(star, j) && !insert(g, j)) return 0;
    for (uint32_t j = first; j != MIKK_NONE; j = following[j])
        if (!mikk_follows(star, j) && !star->marks[j]) star->marks[j] = (uint8_t)has_opposed(g, j);
    return 1;
}

int norma_core_mikk_mark_opposed(mikk_star *star, uint32_t first, const uint32_t *following) {
    grid g = {.star = star, .room = 64};
    size_t count = 0;
    for (uint32_t j = first; j != MIKK_NONE; j = following[j], count++) star->marks[j] = 0;
    while (g.room < 4 * count) g.room *= 2;
    if (!mark(&g, first, following)) return 0;
    g.of_t = 1;
    return mark(&g, first, following);
}
