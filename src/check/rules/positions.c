/* positions.c: N502, N503, N701 and N702: vertices that repeat, positions almost equal or far from
 * the origin, encodings; and the faces that no rule looks at, as their positions are no points
 * (N002). */
#include "check/rules/rules.h"
#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

/* ---- N002: a face with a position that is NaN or infinite. It has neither a direction nor a
 * height, so every rule about faces leaves it out. */

static int are_all_placed(const core_mesh *mesh) {
    double sum = 0, p[3];
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        norma_core_position(mesh, (uint32_t)i, p);
        sum += (p[0] - p[0]) + (p[1] - p[1]) + (p[2] - p[2]); /* 0 each, or NaN */
    }
    return sum == 0;
}

static int is_placed(const core_mesh *mesh, size_t face) {
    double p[3];
    int finite = 1;
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); ++c) {
        norma_core_position(mesh, norma_core_corner(mesh, c), p);
        finite &= norma_core_finite(p) != 0;
    }
    return finite;
}

void norma_check_unplaced_look(const check_mesh *m, check_hits *sum) {
    if (are_all_placed(&m->mesh)) return;
    for (size_t f = 0; f < m->mesh.face_count; ++f)
        if (!is_placed(&m->mesh, f)) norma_check_hit(m->run, sum, 0, norma_check_face(f));
}

norma_result norma_check_unplaced_add(check_mesh *m, check_hits *sum, norma_severity severity) {
    if (sum->count) norma_check_partly(m->run);
    if (!norma_check_wants(m, RULE_N002)) {
        norma_check_hits_free(sum);
        return NORMA_OK;
    }
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N002, .severity = severity, .no_value = 1, .hits = sum},
        "not checked: %z of %z face%s, for positions that are NaN or infinite", sum->count,
        m->mesh.face_count, norma_check_plural(m->mesh.face_count));
}

norma_result norma_check_unplaced(check_mesh *m) {
    check_hits sum = {.count = 0};
    norma_check_unplaced_look(m, &sum);
    return norma_check_unplaced_add(m, &sum, NORMA_SEVERITY_WARNING);
}

/* ---- N503: positions that are almost, and not quite, equal: found in a grid of cells
 * some steps wide, so that most positions are alone in their cell and far from its sides: those are
 * done. A slot knows the cell it is for, so that of all others a position is read only where
 * another one shares its cell. */

enum { POSITIONS_IN_BLOCK = 1 << 13, CELL_STEPS = 32, AT_ONCE = 32 };
static const double ALMOST_EQUAL = 1e-6; /* of the diagonal */

enum {
    POSITION_UNUSED = 0, /* by a face; or not finite; or it is equal to one that stands for it */
    POSITION_ALONE,      /* in its cell, and far from its sides */
    POSITION_TO_JUDGE
};

typedef struct grid {
    const check_mesh *m;
    double low[3], step, cell;
    size_t mask;
    _Atomic uint64_t *slots; /* a tag of the cell above the position added last; all bits: none */
    uint32_t *next;    /* of each position the one added to its cell before it; UINT32_MAX: none */
    atomic_uchar *use; /* of each position: POSITION_UNUSED and so on */
} grid;

static uint64_t hash_of_cell(const int64_t cell[3]) {
    uint64_t h = (uint64_t)cell[0] * UINT64_C(0x9e3779b97f4a7c15) +
                 (uint64_t)cell[1] * UINT64_C(0xc2b2ae3d27d4eb4f) +
                 (uint64_t)cell[2] * UINT64_C(0x165667b19e3779f9);
    return norma_check_mix(h);
}

/* Coordinates in a cell are not negative, so cutting off is rounding down; a cell before the first
 * one is asked for by its number. */
static void cell_of(const grid *g, const double p[3], int64_t cell[3]) {
    for (int k = 0; k < 3; ++k) cell[k] = (int64_t)((p[k] - g->low[k]) / g->cell);
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

static int use_of(const grid *g, size_t position) {
    return atomic_load_explicit(&g->use[position], memory_order_relaxed);
}

static void set_use(grid *g, size_t position, int use) {
    atomic_store_explicit(&g->use[position], (unsigned char)use, memory_order_relaxed);
}

/* Those that share a cell are to be judged. */
static void add_position(grid *g, uint32_t position, uint64_t hash) {
    uint64_t entry, tag = (hash >> 32) & 0x7fffffff;
    size_t slot;
    do {
        slot = find_slot(g, hash, &entry);
        g->next[position] = entry == EMPTY ? UINT32_MAX : (uint32_t)entry;
    } while (!atomic_compare_exchange_strong_explicit(
        &g->slots[slot], &entry, tag << 32 | position, memory_order_relaxed, memory_order_relaxed));
    if (entry == EMPTY) return;
    set_use(g, position, POSITION_TO_JUDGE);
    set_use(g, (uint32_t)entry, POSITION_TO_JUDGE);
}

/* Which cells along an axis lie within a step: from -1, 0 to 0, 1. */
static void reach(const grid *g, const double p[3], const int64_t cell[3], int from[3], int to[3]) {
    for (int k = 0; k < 3; ++k) {
        double in_cell = p[k] - g->low[k] - (double)cell[k] * g->cell;
        from[k] = in_cell < 1.01 * g->step ? -1 : 0;
        to[k] = in_cell > g->cell - 1.01 * g->step ? 1 : 0;
    }
}

static int is_at_side(const grid *g, const double p[3], const int64_t cell[3]) {
    int from[3], to[3], any = 0;
    reach(g, p, cell, from, to);
    for (int k = 0; k < 3; ++k) any |= from[k] != to[k];
    return any;
}

/* Adds the positions in [begin, end), at most AT_ONCE: first their slots are on the way. */
static void add_some(grid *g, size_t begin, size_t end) {
    uint32_t which[AT_ONCE];
    uint64_t hashes[AT_ONCE];
    size_t count = 0;
    for (size_t i = begin; i < end; ++i) {
        double p[3];
        int64_t cell[3];
        if (use_of(g, i) == POSITION_UNUSED) continue;
        norma_core_position(&g->m->mesh, (uint32_t)i, p);
        cell_of(g, p, cell);
        if (is_at_side(g, p, cell)) set_use(g, i, POSITION_TO_JUDGE);
        which[count] = (uint32_t)i;
        hashes[count] = hash_of_cell(cell);
        __builtin_prefetch((const void *)&g->slots[(size_t)hashes[count] & g->mask]);
        ++count;
    }
    for (size_t i = 0; i < count; ++i) add_position(g, which[i], hashes[i]);
}

static void add_positions(void *context, size_t block, size_t begin, size_t end) {
    (void)block;
    for (size_t first = begin; first < end; first += AT_ONCE)
        add_some(context, first, end - first < AT_ONCE ? end : first + AT_ONCE);
}

/* Whether a position of the cell lies within the step and is not equal. The order in a cell is that
 * of chance, so the first one found must do. */
static int is_near_in(const grid *g, const int64_t cell[3], size_t self, const double p[3]) {
    uint64_t entry;
    (void)find_slot(g, hash_of_cell(cell), &entry);
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

static int is_near(const grid *g, size_t self) {
    double p[3];
    int64_t cell[3];
    int from[3], to[3];
    norma_core_position(&g->m->mesh, (uint32_t)self, p);
    cell_of(g, p, cell);
    reach(g, p, cell, from, to);
    for (int x = from[0]; x <= to[0]; ++x)
        for (int y = from[1]; y <= to[1]; ++y)
            for (int z = from[2]; z <= to[2]; ++z) {
                const int64_t there[3] = {cell[0] + x, cell[1] + y, cell[2] + z};
                if (is_near_in(g, there, self, p)) return 1;
            }
    return 0;
}

static void judge_cells(const void *context, check_sum *part, size_t begin, size_t end) {
    const grid *g = context;
    for (size_t i = begin; i < end; ++i)
        if (use_of(g, i) == POSITION_TO_JUDGE && is_near(g, i))
            norma_check_hit(g->m->run, &part->hits[0], 0, norma_check_vertex(i));
}

/* ---- the grid */

/* One of each set of equal positions that faces use, all of whose coordinates are finite; how many.
 */
static size_t find_used(grid *g, double high[3]) {
    const core_mesh *mesh = &g->m->mesh;
    size_t count = 0;
    memset((void *)g->use, POSITION_UNUSED, mesh->positions.count);
    for (size_t c = 0; c < mesh->corner_count; ++c)
        set_use(g, g->m->topology.corners[c], POSITION_ALONE);
    for (int k = 0; k < 3; ++k) {
        g->low[k] = INFINITY;
        high[k] = -INFINITY;
    }
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        double p[3];
        if (use_of(g, i) == POSITION_UNUSED) continue;
        norma_core_position(mesh, (uint32_t)i, p);
        if (!norma_core_finite(p)) {
            set_use(g, i, POSITION_UNUSED);
            continue;
        }
        ++count;
        for (int k = 0; k < 3; ++k) {
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
        &(check_finding){
            .rule = RULE_N503, .severity = NORMA_SEVERITY_INFO, .no_value = 1, .hits = hits},
        "cracks in the surface: %z position%s closer to another than %g (a millionth of the mesh's "
        "diagonal), but not equal to it",
        hits->count, norma_check_plural(hits->count), step);
}

static norma_result search(check_mesh *m, grid *g) {
    const size_t count = m->mesh.positions.count;
    check_sum sum = {.twice_area = 0};
    norma_result result =
        norma_check_blocks(&m->run->call, count, POSITIONS_IN_BLOCK, add_positions, g);
    if (!result)
        result = norma_check_gather(m->run, count, POSITIONS_IN_BLOCK, judge_cells, g, &sum);
    if (!result) result = add_coincident(m, &sum.hits[0], g->step);
    norma_check_sum_free(&sum);
    return result;
}

norma_result norma_check_coincident(check_mesh *m) {
    const size_t count = m->mesh.positions.count;
    if (!m->mesh.face_count || !norma_check_wants(m, RULE_N503)) return NORMA_OK;
    norma_result result = norma_check_weld(m);
    if (result) return result;
    const core_call *call = &m->run->call;
    grid g = {.m = m};
    g.next = norma_core_allocate(call, count, sizeof *g.next);
    g.use = norma_core_allocate(call, count, sizeof *g.use);
    result = g.next && g.use ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        double high[3], square = 0;
        const size_t used = find_used(&g, high);
        for (int k = 0; k < 3; ++k) square += (high[k] - g.low[k]) * (high[k] - g.low[k]);
        g.step = ALMOST_EQUAL * sqrt(square);
        g.cell = CELL_STEPS * g.step;
        for (int k = 0; k < 3; ++k) g.low[k] -= g.cell / 2; /* a plane is not at cells' sides */
        if (g.step > 0 && g.step < INFINITY) result = open_slots(&g, used);
        if (g.slots && !result) result = search(m, &g);
    }
    norma_core_release(call, (void *)g.slots, g.slots ? g.mask + 1 : 0, sizeof *g.slots);
    norma_core_release(call, g.next, count, sizeof *g.next);
    norma_core_release(call, (void *)g.use, count, sizeof *g.use);
    return result;
}

/* ---- N502, N701 and N702: what the way of storing a mesh does to it. */

/* ---- N701: the spacing of numbers at the largest coordinate against the median edge */

enum { CORNERS_IN_BLOCK = 1 << 14 };
static const double COARSE_RATIO = 0.02;

typedef struct edge_pass {
    const core_topology *topology;
    const double *lengths;
    size_t count, enough;
    size_t *parts;        /* count + 1 for each block */
    atomic_size_t beyond; /* edges of the blocks that are done that are no shorter than the last
                             length */
} edge_pass;

void norma_check_find_largest(const core_mesh *mesh, size_t first, check_largest *largest) {
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        double p[3];
        norma_core_position(mesh, (uint32_t)i, p);
        double most = fabs(p[0]);
        for (int k = 1; k < 3; ++k) most = fabs(p[k]) > most ? fabs(p[k]) : most;
        if (most > largest->coordinate && norma_core_finite(p))
            *largest = (check_largest){most, first + i};
    }
}

/* Whole codes are no floats: their spacing is the encoding's, and quantised meshes know what they
 * do. OBJ text is read into floats by nearly everyone. */
static double spacing_at(const check_mesh *m, double largest) {
    int exponent;
    (void)frexp(largest, &exponent);
    if (m->mesh.positions.format == NORMA_FORMAT_FLOAT ||
        (m->mesh.positions.format == NORMA_FORMAT_DOUBLE && m->run->format == NORMA_FILE_OBJ))
        return ldexp(1, (exponent < FLT_MIN_EXP ? FLT_MIN_EXP : exponent) - FLT_MANT_DIG);
    return m->mesh.positions.format == NORMA_FORMAT_DOUBLE
               ? ldexp(1, (exponent < DBL_MIN_EXP ? DBL_MIN_EXP : exponent) - DBL_MANT_DIG)
               : 0;
}

/* The first length whose square is greater; count: none. */
static size_t interval_of(const edge_pass *pass, double square) {
    size_t low = 0, high = pass->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (square < pass->lengths[middle] * pass->lengths[middle])
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Corners at one position have no edge between them. */
static void sort_edges_of_face(const edge_pass *pass, size_t face, size_t *counts) {
    const core_topology *t = pass->topology;
    const size_t begin = norma_core_face_begin(&t->mesh, face),
                 end = norma_core_face_end(&t->mesh, face);
    if (begin == end) return;
    double before[3], p[3], edge[3];
    uint32_t last = t->corners[end - 1];
    norma_core_position(&t->mesh, last, before);
    for (size_t c = begin; c < end; ++c) {
        const uint32_t position = t->corners[c];
        norma_core_position(&t->mesh, position, p);
        norma_core_subtract(p, before, edge);
        const double square = norma_core_dot(edge, edge);
        if (position != last && square >= 0) ++counts[interval_of(pass, square)];
        memcpy(before, p, sizeof before);
        last = position;
    }
}

static void sort_edges(void *context, size_t block, size_t begin, size_t end) {
    edge_pass *pass = context;
    size_t *counts = &pass->parts[block * (pass->count + 1)];
    if (atomic_load_explicit(&pass->beyond, memory_order_relaxed) > pass->enough) return;
    for (size_t f = begin; f < end; ++f) sort_edges_of_face(pass, f, counts);
    atomic_fetch_add_explicit(&pass->beyond, counts[pass->count], memory_order_relaxed);
}

norma_result norma_check_sort_edges(
    check_mesh *m, const double *lengths, size_t count, size_t enough, size_t *counts) {
    const size_t blocks = norma_check_block_count(m->mesh.face_count, CORNERS_IN_BLOCK),
                 numbers = blocks * (count + 1);
    edge_pass pass = {.topology = &m->topology,
        .lengths = lengths,
        .count = count,
        .enough = enough,
        .parts = norma_core_allocate(&m->run->call, numbers, sizeof *pass.parts)};
    if (!pass.parts) return NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, numbers * sizeof *pass.parts);
    norma_result result =
        norma_check_blocks(&m->run->call, m->mesh.face_count, CORNERS_IN_BLOCK, sort_edges, &pass);
    for (size_t i = 0; i < numbers; ++i) counts[i % (count + 1)] += pass.parts[i];
    norma_core_release(&m->run->call, pass.parts, numbers, sizeof *pass.parts);
    return result;
}

/* The median is known only as a length that half of the edges are shorter than: halving finds it to
 * a thousandth. */
norma_result norma_check_median_edge(
    double high, check_ask_shorter *ask, void *context, double *median) {
    double low = 0;
    norma_result result = NORMA_OK;
    for (int i = 0; i < 40 && high - low > 1e-3 * high && !result; ++i) {
        size_t shorter = 0, all = 0;
        result = ask(context, low, high, &shorter, &all);
        const double middle = low + (high - low) / 2;
        if (2 * shorter > all)
            high = middle;
        else
            low = middle;
    }
    *median = high;
    return result;
}

double norma_check_coarse_length(const check_mesh *m, const check_largest *largest) {
    return largest->coordinate > 0 ? spacing_at(m, largest->coordinate) / COARSE_RATIO : 0;
}

norma_result norma_check_distance_add(check_mesh *m, const check_largest *largest, double median) {
    const double spacing = spacing_at(m, largest->coordinate);
    check_hits hits = {0};
    norma_check_hit(m->run, &hits, spacing / median, norma_check_vertex(largest->vertex));
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N701, .severity = NORMA_SEVERITY_WARNING, .unit = "ratio", .hits = &hits},
        "steps in the surface: coordinates up to %g are rounded to %g, and half of the edges are "
        "shorter than %g; faces turn by about %g degrees",
        largest->coordinate, spacing, median, fmin(12 * spacing / median, 90));
}

static norma_result count_shorter(
    void *context, double low, double high, size_t *shorter, size_t *all) {
    const double middle = low + (high - low) / 2;
    size_t counts[2] = {0, 0};
    const norma_result result = norma_check_sort_edges(context, &middle, 1, SIZE_MAX, counts);
    *shorter = counts[0];
    *all = counts[0] + counts[1];
    return result;
}

static norma_result check_distance(check_mesh *m) {
    check_largest largest = {.coordinate = 0};
    size_t counts[2] = {0, 0};
    double median;
    norma_check_find_largest(&m->mesh, 0, &largest);
    const double coarse = norma_check_coarse_length(m, &largest);
    norma_result result = coarse > 0 ? norma_check_weld(m) : NORMA_OK;
    if (result || coarse == 0) return result;
    /* Once half of the corners begin an edge that is long enough, the median is. */
    result = norma_check_sort_edges(m, &coarse, 1, m->mesh.corner_count / 2, counts);
    if (result || counts[0] <= counts[1]) return result;
    result = norma_check_median_edge(coarse, count_shorter, m, &median);
    return result ? result : norma_check_distance_add(m, &largest, median);
}

/* ---- N702 */

norma_result norma_check_encoding_add(check_mesh *m) {
    double bound = norma_check_encoding_bound(m->given->info.encoding) * (180 / 3.141592653589793);
    if (bound <= .25 || !norma_check_normal_count(m)) return NORMA_OK;
    return norma_check_report_one(m, RULE_N702, NORMA_SEVERITY_INFO, bound,
        "bands in reflections: normals are stored as %s, which errs by up to %g degrees",
        m->given->info.encoding, bound);
}

/* ---- N502: each vertex is used once, and positions coincide. STL knows no other way. */

static norma_result count_used(check_mesh *m, size_t *used, size_t *places) {
    size_t count = m->mesh.positions.count;
    uint8_t *seen = norma_core_allocate(&m->run->call, count, 1);
    if (!seen) return NORMA_ERROR_MEMORY;
    memset(seen, 0, count);
    *used = *places = 0;
    for (size_t c = 0; c < m->mesh.corner_count; ++c) {
        uint32_t vertex = norma_core_corner(&m->mesh, c), place = m->topology.corners[c];
        *used += !(seen[vertex] & 1);
        seen[vertex] |= 1;
        *places += !(seen[place] & 2);
        seen[place] |= 2;
    }
    norma_core_release(&m->run->call, seen, count, 1);
    return NORMA_OK;
}

static norma_result check_soup(check_mesh *m) {
    size_t used, places;
    if (m->run->format == NORMA_FILE_STL || m->mesh.face_count < 2 ||
        m->mesh.positions.count < m->mesh.corner_count)
        return NORMA_OK;
    norma_result result = norma_check_weld(m);
    if (!result) result = count_used(m, &used, &places);
    if (result || used < m->mesh.corner_count || places == used) return result;
    return norma_check_report_one(m, RULE_N502, NORMA_SEVERITY_INFO, NAN,
        "nothing is shared: %z vertices for %z corners at %z positions", used, m->mesh.corner_count,
        places);
}

norma_result norma_check_precision(check_mesh *m) {
    norma_result result = NORMA_OK;
    if (!m->mesh.face_count) return result;
    if (norma_check_wants(m, RULE_N502)) result = check_soup(m);
    if (!result && norma_check_wants(m, RULE_N701)) result = check_distance(m);
    if (!result && norma_check_wants(m, RULE_N702)) result = norma_check_encoding_add(m);
    return result;
}
