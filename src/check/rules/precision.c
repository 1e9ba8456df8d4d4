/* precision.c: N502, N701 and N702: what the way of storing a mesh does to it. */
#include "check/rules/local_rules.h"
#include "check/rules/mesh_rules.h"
#include <float.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

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
    for (size_t i = 0; i < mesh->positions.count; i++) {
        double p[3];
        norma_core_position(mesh, (uint32_t)i, p);
        double most = fabs(p[0]);
        for (int k = 1; k < 3; k++) most = fabs(p[k]) > most ? fabs(p[k]) : most;
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
    for (size_t c = begin; c < end; c++) {
        const uint32_t position = t->corners[c];
        norma_core_position(&t->mesh, position, p);
        norma_core_subtract(p, before, edge);
        const double square = norma_core_dot(edge, edge);
        if (position != last && square >= 0) counts[interval_of(pass, square)]++;
        memcpy(before, p, sizeof before);
        last = position;
    }
}

static void sort_edges(void *context, size_t block, size_t begin, size_t end) {
    edge_pass *pass = context;
    size_t *counts = &pass->parts[block * (pass->count + 1)];
    if (atomic_load_explicit(&pass->beyond, memory_order_relaxed) > pass->enough) return;
    for (size_t f = begin; f < end; f++) sort_edges_of_face(pass, f, counts);
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
        norma_check_blocks(m->run, m->mesh.face_count, CORNERS_IN_BLOCK, sort_edges, &pass);
    for (size_t i = 0; i < numbers; i++) counts[i % (count + 1)] += pass.parts[i];
    norma_core_release(&m->run->call, pass.parts, numbers, sizeof *pass.parts);
    return result;
}

/* The median is known only as a length that half of the edges are shorter than: halving finds it to
 * a thousandth. */
norma_result norma_check_median_edge(
    double high, check_ask_shorter *ask, void *context, double *median) {
    double low = 0;
    norma_result result = NORMA_OK;
    for (int i = 0; i < 40 && high - low > 1e-3 * high && !result; i++) {
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
        &(check_report){
            .rule = RULE_N701, .severity = NORMA_SEVERITY_WARNING, .unit = "ratio", .hits = &hits},
        "coordinates up to %g are rounded to %g, and half of the edges are shorter than %g; faces "
        "turn by about %g degrees",
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
    check_hits hits = {0};
    char message[CHECK_MESSAGE];
    norma_check_message(message,
        "normals are stored as %s, which errs by up to %g degrees; reflections show bands",
        m->given->info.encoding, bound);
    norma_check_hit(m->run, &hits, bound, CHECK_NOWHERE);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N702,
            .severity = NORMA_SEVERITY_INFO,
            .unit = "deg",
            .hits = &hits,
            .message = message});
}

/* ---- N502: each vertex is used once, and positions coincide. STL knows no other way. */

static norma_result count_used(check_mesh *m, size_t *used, size_t *places) {
    size_t count = m->mesh.positions.count;
    uint8_t *seen = norma_core_allocate(&m->run->call, count, 1);
    if (!seen) return NORMA_ERROR_MEMORY;
    memset(seen, 0, count);
    *used = *places = 0;
    for (size_t c = 0; c < m->mesh.corner_count; c++) {
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
    char message[CHECK_MESSAGE];
    if (m->run->format == NORMA_FILE_STL || m->mesh.face_count < 2 ||
        m->mesh.positions.count < m->mesh.corner_count)
        return NORMA_OK;
    norma_result result = norma_check_weld(m);
    if (!result) result = count_used(m, &used, &places);
    if (result || used < m->mesh.corner_count || places == used) return result;
    norma_check_message(message, "%z vertices for %z corners at %z positions: nothing is shared",
        used, m->mesh.corner_count, places);
    return norma_check_add_one(
        m->run, &m->place, m, RULE_N502, NORMA_SEVERITY_INFO, CHECK_NOWHERE, message);
}

norma_result norma_check_precision(check_mesh *m) {
    norma_result result = NORMA_OK;
    if (!m->mesh.face_count) return result;
    if (norma_check_wants(m, RULE_N502)) result = check_soup(m);
    if (!result && norma_check_wants(m, RULE_N701)) result = check_distance(m);
    if (!result && norma_check_wants(m, RULE_N702)) result = norma_check_encoding_add(m);
    return result;
}
