/* coincident.c: N503: positions that are almost, and not quite, equal: found in a grid of cells
 * some steps wide, so that most positions are far from the sides of their cell and one look
 * suffices. A slot knows the cell it is for, so that a position is read only where another one
 * shares its cell. */
#include "check/rules/mesh_rules.h"
#include <math.h>
#include <stdatomic.h>
#include <string.h>

enum { POSITIONS_IN_BLOCK = 1 << 13, CELL_STEPS = 32, AT_ONCE = 32 };
static const double NEAR = 1e-6; /* of the diagonal */

typedef struct grid {
    const check_mesh *m;
    double low[3], step, cell;
    size_t mask;
    _Atomic uint64_t *slots; /* a tag of the cell above the position added last; all bits: none */
    uint32_t *next; /* of each position the one added to its cell before it; UINT32_MAX: none */
    uint8_t *used;  /* by a face */
    check_hits *parts;
} grid;

static uint64_t mix(uint64_t h) {
    h = (h ^ (h >> 32)) * UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ (h >> 29)) * UINT64_C(0xbf58476d1ce4e5b9);
    return h ^ (h >> 32);
}

static uint64_t hash_of(const int64_t cell[3]) {
    uint64_t h = (uint64_t)cell[0] * UINT64_C(0x9e3779b97f4a7c15) +
                 (uint64_t)cell[1] * UINT64_C(0xc2b2ae3d27d4eb4f) +
                 (uint64_t)cell[2] * UINT64_C(0x165667b19e3779f9);
    return mix(h);
}

/* Coordinates in a cell are not negative, so cutting off is rounding down; a cell before the first
 * one is asked for by its number. */
static void cell_of(const grid *g, const double p[3], int64_t cell[3]) {
    for (int k = 0; k < 3; k++) cell[k] = (int64_t)((p[k] - g->low[k]) / g->cell);
}

#define EMPTY UINT64_MAX
static uint32_t tag_of(uint64_t entry) { return (uint32_t)(entry >> 32); }

/* The slot of a hash's tag, or the empty one where it belongs. Never full: there are twice as many
 * slots as positions. */
static size_t find_slot(const grid *g, uint64_t hash, uint64_t *entry) {
    uint32_t tag = (uint32_t)(hash >> 32) & 0x7fffffff;
    for (size_t slot = (size_t)hash & g->mask;; slot = (slot + 1) & g->mask) {
        *entry = atomic_load_explicit(&g->slots[slot], memory_order_relaxed);
        if (*entry == EMPTY || tag_of(*entry) == tag) return slot;
    }
}

static void add_position(grid *g, uint32_t position, uint64_t hash) {
    uint64_t entry, tag = (hash >> 32) & 0x7fffffff;
    for (;;) {
        size_t slot = find_slot(g, hash, &entry);
        g->next[position] = entry == EMPTY ? UINT32_MAX : (uint32_t)entry;
        if (atomic_compare_exchange_strong_explicit(&g->slots[slot], &entry, tag << 32 | position,
                memory_order_relaxed, memory_order_relaxed))
            return;
    }
}

/* Hashes of some positions in a row, their slots on the way. Returns how many are used; which says
 * which. */
static size_t look_ahead(
    const grid *g, size_t begin, size_t end, uint32_t *which, uint64_t *hashes) {
    size_t count = 0;
    for (size_t i = begin; i < end; i++) {
        double p[3];
        int64_t cell[3];
        if (!g->used[i]) continue;
        norma_core_position(&g->m->mesh, (uint32_t)i, p);
        cell_of(g, p, cell);
        which[count] = (uint32_t)i;
        hashes[count] = hash_of(cell);
        __builtin_prefetch((const void *)&g->slots[(size_t)hashes[count] & g->mask]);
        count++;
    }
    return count;
}

static void add_positions(void *context, size_t block, size_t begin, size_t end) {
    grid *g = context;
    uint32_t which[AT_ONCE];
    uint64_t hashes[AT_ONCE];
    (void)block;
    for (size_t first = begin; first < end; first += AT_ONCE) {
        size_t count =
            look_ahead(g, first, end - first < AT_ONCE ? end : first + AT_ONCE, which, hashes);
        for (size_t i = 0; i < count; i++) add_position(g, which[i], hashes[i]);
    }
}

/* Whether a position of the cell lies within the step and is not equal. The order in a cell is that
 * of chance, so the first one found must do. */
static int is_near_in(const grid *g, const int64_t cell[3], size_t self, const double p[3]) {
    uint64_t entry;
    (void)find_slot(g, hash_of(cell), &entry);
    for (uint32_t i = entry == EMPTY ? UINT32_MAX : (uint32_t)entry; i != UINT32_MAX;
         i = g->next[i]) {
        double q[3], d[3];
        if (i == self) continue;
        norma_core_position(&g->m->mesh, i, q);
        norma_core_subtract(p, q, d);
        double square = norma_core_dot(d, d);
        if (square < g->step * g->step && square > 0) return 1;
    }
    return 0;
}

/* Which cells along an axis lie within a step: from -1, 0 to 0, 1. */
static void reach(const grid *g, const double p[3], const int64_t cell[3], int from[3], int to[3]) {
    for (int k = 0; k < 3; k++) {
        double in_cell = p[k] - g->low[k] - (double)cell[k] * g->cell;
        from[k] = in_cell < 1.01 * g->step ? -1 : 0;
        to[k] = in_cell > g->cell - 1.01 * g->step ? 1 : 0;
    }
}

static int is_near(const grid *g, size_t self) {
    double p[3];
    int64_t cell[3];
    int from[3], to[3];
    norma_core_position(&g->m->mesh, (uint32_t)self, p);
    cell_of(g, p, cell);
    reach(g, p, cell, from, to);
    for (int x = from[0]; x <= to[0]; x++)
        for (int y = from[1]; y <= to[1]; y++)
            for (int z = from[2]; z <= to[2]; z++) {
                const int64_t there[3] = {cell[0] + x, cell[1] + y, cell[2] + z};
                if (is_near_in(g, there, self, p)) return 1;
            }
    return 0;
}

static void judge_positions(void *context, size_t block, size_t begin, size_t end) {
    grid *g = context;
    uint32_t which[AT_ONCE];
    uint64_t hashes[AT_ONCE];
    for (size_t first = begin; first < end; first += AT_ONCE) {
        size_t count =
            look_ahead(g, first, end - first < AT_ONCE ? end : first + AT_ONCE, which, hashes);
        for (size_t i = 0; i < count; i++)
            if (is_near(g, which[i]))
                norma_check_hit(g->m->run, &g->parts[block], 0, norma_check_vertex(which[i]));
    }
}

/* ---- the grid */

/* One of each set of equal positions that faces use, all of whose coordinates are finite; how many.
 */
static size_t find_used(grid *g, double high[3]) {
    const core_mesh *mesh = &g->m->mesh;
    size_t count = 0;
    memset(g->used, 0, mesh->positions.count);
    for (size_t c = 0; c < mesh->corner_count; c++) g->used[g->m->topology.corners[c]] = 1;
    for (int k = 0; k < 3; k++) {
        g->low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t i = 0; i < mesh->positions.count; i++) {
        double p[3];
        if (!g->used[i]) continue;
        norma_core_position(mesh, (uint32_t)i, p);
        g->used[i] = (uint8_t)norma_core_finite(p);
        count += g->used[i];
        for (int k = 0; k < 3 && g->used[i]; k++) {
            g->low[k] = p[k] < g->low[k] ? p[k] : g->low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
        }
    }
    return count;
}

/* Twice as many slots as positions that are used: of a soup, where each is there six times, few. */
static norma_result open_slots(grid *g, size_t used) {
    size_t slots = 16;
    while (slots < 2 * used) slots *= 2;
    g->mask = slots - 1;
    g->slots = norma_core_allocate(&g->m->run->call, slots, sizeof *g->slots);
    if (!g->slots) return NORMA_ERROR_MEMORY;
    memset((void *)g->slots, 0xff, slots * sizeof *g->slots);
    return NORMA_OK;
}

static norma_result add_coincident(check_mesh *m, check_hits *hits, double step) {
    return norma_check_report(m,
        &(check_report){
            .rule = RULE_N503, .severity = NORMA_SEVERITY_INFO, .no_value = 1, .hits = hits},
        "%z position%s closer to another than %g (a millionth of the mesh's diagonal), but not "
        "equal to it; the surface has cracks there",
        hits->count, norma_check_plural(hits->count), step);
}

static norma_result search(check_mesh *m, grid *g, size_t blocks) {
    size_t count = m->mesh.positions.count;
    norma_result result = norma_check_blocks(m->run, count, POSITIONS_IN_BLOCK, add_positions, g);
    if (!result) result = norma_check_blocks(m->run, count, POSITIONS_IN_BLOCK, judge_positions, g);
    check_hits hits = {0};
    for (size_t i = 0; i < blocks; i++) norma_check_hits_merge(m->run, &hits, &g->parts[i]);
    if (!result && hits.count) return add_coincident(m, &hits, g->step);
    norma_check_hits_free(&hits);
    return result;
}

norma_result norma_check_coincident(check_mesh *m) {
    size_t count = m->mesh.positions.count,
           blocks = norma_check_block_count(count, POSITIONS_IN_BLOCK);
    if (!m->mesh.face_count || !norma_check_wants(m, RULE_N503)) return NORMA_OK;
    norma_result result = norma_check_weld(m);
    if (result) return result;
    const core_call *call = &m->run->call;
    grid g = {.m = m};
    g.next = norma_core_allocate(call, count, sizeof *g.next);
    g.used = norma_core_allocate(call, count, 1);
    g.parts = norma_core_allocate(call, blocks, sizeof *g.parts);
    result = g.next && g.used && g.parts ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        double high[3], square = 0;
        memset(g.parts, 0, blocks * sizeof *g.parts);
        const size_t used = find_used(&g, high);
        for (int k = 0; k < 3; k++) square += (high[k] - g.low[k]) * (high[k] - g.low[k]);
        g.step = NEAR * sqrt(square);
        g.cell = CELL_STEPS * g.step;
        if (g.step > 0 && g.step < INFINITY) result = open_slots(&g, used);
        if (g.slots && !result) result = search(m, &g, blocks);
    }
    norma_core_release(call, (void *)g.slots, g.slots ? g.mask + 1 : 0, sizeof *g.slots);
    norma_core_release(call, g.next, count, sizeof *g.next);
    norma_core_release(call, g.used, count, 1);
    norma_core_release(call, g.parts, blocks, sizeof *g.parts);
    return result;
}
