/* precision.c: N502, N701 and N702: what the way of storing a mesh does to it. */
#include "check/rules/mesh_rules.h"
#include <float.h>
#include <math.h>
#include <string.h>

/* ---- N701: the spacing of numbers at the largest coordinate against the median edge */

enum { CORNERS_IN_BLOCK = 1 << 14 };
static const double COARSE_RATIO = 0.02;

typedef struct edge_pass {
    const core_topology *topology;
    double shorter;     /* edges below this are counted, of squared length */
    size_t (*parts)[2]; /* of each block: shorter ones, all */
} edge_pass;

static size_t largest_coordinate(const core_mesh *mesh, double *largest) {
    size_t at = SIZE_MAX;
    *largest = 0;
    for (size_t i = 0; i < mesh->positions.count; i++) {
        double p[3];
        norma_core_position(mesh, (uint32_t)i, p);
        double most = fmax(fabs(p[0]), fmax(fabs(p[1]), fabs(p[2])));
        if (most > *largest && norma_core_finite(p)) {
            *largest = most;
            at = i;
        }
    }
    return at;
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

/* The squared length of the edge from a kept corner to the next; negative: no such edge exists. */
static double edge_square(const core_topology *t, size_t face, size_t corner) {
    double p[3], q[3], edge[3];
    if (!norma_core_is_kept(&t->mesh, face, corner)) return -1;
    norma_core_position(&t->mesh, t->corners[corner], p);
    norma_core_position(&t->mesh, t->corners[norma_core_next_in_face(&t->mesh, face, corner)], q);
    norma_core_subtract(q, p, edge);
    return norma_core_dot(edge, edge);
}

static void count_edges(void *context, size_t block, size_t begin, size_t end) {
    const edge_pass *pass = context;
    const core_topology *t = pass->topology;
    for (size_t f = begin; f < end; f++)
        for (size_t c = norma_core_face_begin(&t->mesh, f); c < norma_core_face_end(&t->mesh, f);
             c++) {
            double square = edge_square(t, f, c);
            pass->parts[block][0] += square >= 0 && square < pass->shorter;
            pass->parts[block][1] += square >= 0;
        }
}

/* Whether more than half of the edges are shorter. */
static norma_result count_shorter(check_mesh *m, double length, size_t *shorter, size_t *all) {
    size_t blocks = norma_check_block_count(m->mesh.face_count, CORNERS_IN_BLOCK);
    edge_pass pass = {&m->topology, length * length,
        norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    if (!pass.parts) return NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    norma_result result =
        norma_check_blocks(m->run, m->mesh.face_count, CORNERS_IN_BLOCK, count_edges, &pass);
    *shorter = *all = 0;
    for (size_t i = 0; i < blocks; i++) {
        *shorter += pass.parts[i][0];
        *all += pass.parts[i][1];
    }
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}

/* The median is known only as a length that half of the edges are shorter than: halving finds it to
 * a thousandth. */
static norma_result median_edge(check_mesh *m, double above, double *median) {
    double low = 0, high = above;
    norma_result result = NORMA_OK;
    for (int i = 0; i < 40 && high - low > 1e-3 * high && !result; i++) {
        size_t shorter = 0, all = 0;
        double middle = low + (high - low) / 2;
        result = count_shorter(m, middle, &shorter, &all);
        if (2 * shorter > all)
            high = middle;
        else
            low = middle;
    }
    *median = high;
    return result;
}

static norma_result check_distance(check_mesh *m) {
    double largest, median;
    size_t shorter, all, at = largest_coordinate(&m->mesh, &largest);
    double spacing = largest > 0 ? spacing_at(m, largest) : 0;
    norma_result result = spacing > 0 ? norma_check_weld(m) : NORMA_OK;
    if (result || spacing == 0) return result;
    result = count_shorter(m, spacing / COARSE_RATIO, &shorter, &all);
    if (result || 2 * shorter <= all) return result;
    result = median_edge(m, spacing / COARSE_RATIO, &median);
    check_hits hits = {0};
    char message[CHECK_MESSAGE];
    norma_check_hit(m->run, &hits, spacing / median, norma_check_vertex(at));
    norma_check_message(message,
        "coordinates up to %g are rounded to %g, and half of the edges are shorter than %g; faces "
        "turn by about %g degrees",
        largest, spacing, median, fmin(12 * spacing / median, 90));
    if (!result)
        return norma_check_add(m->run, &m->place, m,
            &(check_report){.rule = RULE_N701,
                .severity = NORMA_SEVERITY_WARNING,
                .unit = "ratio",
                .hits = &hits,
                .message = message});
    norma_check_hits_free(&hits);
    return result;
}

/* ---- N702 */

static norma_result check_encoding(check_mesh *m) {
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
    if (!result && norma_check_wants(m, RULE_N702)) result = check_encoding(m);
    return result;
}
