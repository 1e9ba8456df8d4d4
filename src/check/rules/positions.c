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

/* ---- N503: positions that are almost, and not quite, equal. Two of them lie in one cell of a grid
 * some steps wide; or sides of cells part them, along some axes, and are near both: then they lie
 * in one cell of the grid that is moved by half a cell along these axes. Few positions are near
 * sides, and most are alone in their cell. */

enum { POSITIONS_IN_BLOCK = 1 << 13, CELL_STEPS = 32 };
static const double ALMOST_EQUAL = 1e-6; /* of the diagonal */

typedef struct grid {
    check_mesh *m;
    double low[3], step, cell;
    unsigned moved;   /* bits of the axes along which it is moved */
    uint32_t *listed; /* positions: of those that are equal one, where faces use it and it is
                         finite. Those near sides along these axes are listed first */
    uint32_t *least;  /* of each listed one: the first listed in its cell, as a number in listed */
    uint32_t *next; /* another one in its cell; UINT32_MAX: none is left. From the least on, all */
    uint8_t *is_near; /* of each position: it is almost equal to another */
} grid;

/* Coordinates in a cell are not negative, so cutting off is rounding down. */
static void cell_of(const grid *g, uint32_t number, int64_t cell[3]) {
    double p[3];
    norma_core_position(&g->m->mesh, g->listed[number], p);
    for (int k = 0; k < 3; ++k)
        cell[k] = (int64_t)((p[k] - g->low[k]) / g->cell + (g->moved >> k & 1) * .5);
}

static void hash_cells(const void *context, size_t first, size_t count, uint64_t *hashes) {
    for (size_t i = 0; i < count; ++i) {
        int64_t cell[3];
        cell_of(context, (uint32_t)(first + i), cell);
        hashes[i] = norma_core_weld_mix((uint64_t)cell[0] * UINT64_C(0x9e3779b97f4a7c15) +
                                        (uint64_t)cell[1] * UINT64_C(0xc2b2ae3d27d4eb4f) +
                                        (uint64_t)cell[2] * UINT64_C(0x165667b19e3779f9));
    }
}

static int is_same_cell(const void *context, uint32_t one, uint32_t other) {
    int64_t a[3], b[3];
    cell_of(context, one, a);
    cell_of(context, other, b);
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

static void judge_cells(void *context, size_t block, size_t begin, size_t end) {
    const grid *g = context;
    (void)block;
    for (size_t i = begin; i < end; ++i) {
        double p[3], q[3], d[3];
        norma_core_position(&g->m->mesh, g->listed[i], p);
        for (uint32_t k = g->least[i]; k != UINT32_MAX && !g->is_near[g->listed[i]];
             k = g->next[k]) {
            if (k == i) continue;
            norma_core_position(&g->m->mesh, g->listed[k], q);
            norma_core_subtract(p, q, d);
            const double square = norma_core_dot(d, d);
            g->is_near[g->listed[i]] = square < g->step * g->step && square > 0;
        }
    }
}

static norma_result judge_grid(grid *g, size_t count) {
    core_call *call = &g->m->run->call;
    const weld_keys keys = {count, g, hash_cells, is_same_cell};
    size_t found;
    const norma_result result = norma_core_weld_keys(call, &keys, g->least, &found);
    if (result || !found) return result;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t least = g->least[i];
        g->next[i] = UINT32_MAX;
        if (least == i) continue;
        g->next[i] = g->next[least];
        g->next[least] = (uint32_t)i;
    }
    return norma_check_blocks(call, count, POSITIONS_IN_BLOCK, judge_cells, g);
}

/* Bits of the axes along which it is near a side. */
static unsigned sides_near(const grid *g, const double p[3]) {
    unsigned sides = 0;
    for (int k = 0; k < 3; ++k) {
        const double cells = (p[k] - g->low[k]) / g->cell,
                     within = (cells - (double)(int64_t)cells) * CELL_STEPS;
        sides |= (unsigned)(within < 1.01 || within > CELL_STEPS - 1.01) << k;
    }
    return sides;
}

/* Moves those of count listed ones to the front that are near sides along the axes along which the
 * grid is moved, or along any; how many. */
static size_t list_near_sides(const grid *g, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t position = g->listed[i];
        double p[3];
        norma_core_position(&g->m->mesh, position, p);
        const unsigned sides = sides_near(g, p);
        if (!sides || (sides & g->moved) != g->moved) continue;
        g->listed[i] = g->listed[kept];
        g->listed[kept++] = position;
    }
    return kept;
}

/* How many are listed. */
static size_t list_used(const grid *g) {
    const core_mesh *mesh = &g->m->mesh;
    size_t count = 0;
    memset(g->is_near, 0, mesh->positions.count);
    for (size_t c = 0; c < mesh->corner_count; ++c) g->is_near[g->m->topology.corners[c]] = 1;
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        double p[3];
        if (!g->is_near[i]) continue;
        g->is_near[i] = 0;
        norma_core_position(mesh, (uint32_t)i, p);
        if (norma_core_finite(p)) g->listed[count++] = (uint32_t)i;
    }
    return count;
}

/* 0: all listed ones are equal, or too far apart. */
static int lay_grid(grid *g, size_t count) {
    double high[3] = {-INFINITY, -INFINITY, -INFINITY}, square = 0;
    for (int k = 0; k < 3; ++k) g->low[k] = INFINITY;
    for (size_t i = 0; i < count; ++i) {
        double p[3];
        norma_core_position(&g->m->mesh, g->listed[i], p);
        for (int k = 0; k < 3; ++k) {
            g->low[k] = p[k] < g->low[k] ? p[k] : g->low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
        }
    }
    for (int k = 0; k < 3; ++k) square += (high[k] - g->low[k]) * (high[k] - g->low[k]);
    g->step = ALMOST_EQUAL * sqrt(square);
    g->cell = CELL_STEPS * g->step;
    for (int k = 0; k < 3; ++k) g->low[k] -= g->cell / 2; /* a plane is not at cells' sides */
    return g->step > 0 && g->step < INFINITY;
}

static norma_result add_coincident(const grid *g) {
    check_mesh *m = g->m;
    check_hits hits = {0};
    for (size_t i = 0; i < m->mesh.positions.count; ++i)
        if (g->is_near[i]) norma_check_hit(m->run, &hits, 0, norma_check_vertex(i));
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N503, .severity = NORMA_SEVERITY_INFO, .no_value = 1, .hits = &hits},
        "cracks in the surface: %z position%s closer to another than %g (a millionth of the mesh's "
        "diagonal), but not equal to it",
        hits.count, norma_check_plural(hits.count), g->step);
}

static norma_result judge_grids(grid *g) {
    const size_t used = list_used(g);
    norma_result result = NORMA_OK;
    if (!used || !lay_grid(g, used)) return result;
    result = judge_grid(g, used);
    const size_t near_sides = list_near_sides(g, used);
    for (g->moved = 1; g->moved < 8 && !result; ++g->moved)
        result = judge_grid(g, list_near_sides(g, near_sides));
    return result ? result : add_coincident(g);
}

norma_result norma_check_coincident(check_mesh *m) {
    const size_t count = m->mesh.positions.count;
    const core_call *call = &m->run->call;
    if (!m->mesh.face_count || !norma_check_wants(m, RULE_N503)) return NORMA_OK;
    norma_result result = norma_check_weld(m);
    if (result) return result;
    grid g = {.m = m,
        .listed = norma_core_allocate(call, count, sizeof *g.listed),
        .least = norma_core_allocate(call, count, sizeof *g.least),
        .next = norma_core_allocate(call, count, sizeof *g.next),
        .is_near = norma_core_allocate(call, count, 1)};
    result = g.listed && g.least && g.next && g.is_near ? judge_grids(&g) : NORMA_ERROR_MEMORY;
    norma_core_release(call, g.listed, count, sizeof *g.listed);
    norma_core_release(call, g.least, count, sizeof *g.least);
    norma_core_release(call, g.next, count, sizeof *g.next);
    norma_core_release(call, g.is_near, count, 1);
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
