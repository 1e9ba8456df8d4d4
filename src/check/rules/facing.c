/* facing.c: N201 and N202: stored normals against the directions of the faces that use them. */
#include "check/rules/mesh_rules.h"
#include "check/findings/angle.h"
#include <math.h>
#include <string.h>

enum {
    FACES_IN_BLOCK = 1 << 13,
    LARGEST_RING = 1 << 10
}; /* corners at one position: where more meet, each is held against its own faces only, or the work
      would grow with their square */
static const double ACROSS = 1e-6; /* a normal along its face, up to rounding, opposes nothing */
static const double FAR_COSINE = 0.25881904510252074; /* of 75 degrees */

typedef struct facing_part {
    check_hits opposed;
    double opposed_area; /* twice */
    size_t far_corners; /* more than 75 degrees from this face: their normals are looked at again */
} facing_part;

typedef struct facing_pass {
    const check_mesh *m;
    double across;
    facing_part *parts;
    int wants_opposed;
} facing_pass;

/* Cosine between a face and a stored normal; NaN: no normal there has a direction. */
static double cosine_to(const check_mesh *m, size_t face, size_t number) {
    double n[3];
    if (number == SIZE_MAX) return NAN;
    norma_check_normal(m, number, n);
    double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (!(square >= 1e-12 && square < INFINITY)) /* N101 and N102 tell of it */
        return NAN;
    double dot = norma_check_dot(m->faces[face].normal, n);
    return square > .99 && square < 1.01 ? dot : dot / sqrt(square);
}

static void judge_face(const facing_pass *pass, facing_part *part, size_t face) {
    const check_mesh *m = pass->m;
    size_t begin = norma_core_face_begin(&m->mesh, face), end = norma_core_face_end(&m->mesh, face);
    double greatest = -2;
    int all = end > begin && !norma_check_is_sliver(&m->faces[face]);
    if (!norma_check_directed(&m->faces[face])) return;
    for (size_t c = begin; c < end; c++) {
        double cosine = cosine_to(m, face, norma_check_normal_of(m, face, c));
        part->far_corners += cosine < FAR_COSINE;
        all &= cosine < -pass->across;
        greatest = fmax(greatest, cosine);
    }
    if (!pass->wants_opposed || !all) return;
    part->opposed_area += norma_check_twice_area(m, face);
    norma_check_hit(m->run, &part->opposed,
        norma_check_arc_cosine(fmax(greatest, -1)) * (180 / 3.141592653589793),
        norma_check_face(face));
}

static void judge_faces(void *context, size_t block, size_t begin, size_t end) {
    const facing_pass *pass = context;
    for (size_t f = begin; f < end; f++) judge_face(pass, &pass->parts[block], f);
}

static norma_result add_opposed(check_mesh *m, check_hits *hits, double twice_area) {
    char message[CHECK_MESSAGE];
    const double whole = norma_check_whole_area(m), part = whole > 0 ? twice_area / whole : 0;
    norma_severity severity = m->on_purpose ? NORMA_SEVERITY_INFO
                              : part > .01  ? NORMA_SEVERITY_ERROR
                                            : NORMA_SEVERITY_WARNING;
    norma_check_message(message,
        "%z of %z faces (%g %% of the area) have normals that point to their other side at every "
        "corner; they are lit from behind",
        hits->count, m->mesh.face_count, 100 * part);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N201,
            .severity = severity,
            .unit = "deg",
            .hits = hits,
            .message = message});
}

/* ---- N202 */

/* The greatest cosine of each normal that some corner found far; -2: not far anywhere, or of no
 * face that has a direction. */
static void find_nearest(const check_mesh *m, float *greatest) {
    size_t count = norma_check_normal_count(m);
    for (size_t i = 0; i < count; i++) greatest[i] = 2;
    for (size_t f = 0; f < m->mesh.face_count; f++) {
        if (!norma_check_directed(&m->faces[f])) continue;
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             c++) {
            size_t number = norma_check_normal_of(m, f, c);
            double cosine = cosine_to(m, f, number);
            if (!isnan(cosine) && (greatest[number] > 1.5f || cosine > (double)greatest[number]))
                greatest[number] = (float)cosine;
        }
    }
}

/* Those that are far from all faces of their own vertices are held against the other faces at their
 * positions, too: where vertices are split, as in a triangle soup, a smooth normal is the average
 * of faces that use other vertices. */
static norma_result find_nearest_around(check_mesh *m, float *greatest) {
    norma_result result = norma_check_around(m);
    const core_topology *t = &m->topology;
    for (size_t f = 0; !result && f < m->mesh.face_count; f++)
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             c++) {
            size_t number = norma_check_normal_of(m, f, c), place = norma_core_corner(&t->mesh, c);
            if (number == SIZE_MAX || (double)greatest[number] >= FAR_COSINE ||
                t->corners_of.starts[place + 1] - t->corners_of.starts[place] > LARGEST_RING)
                continue;
            for (size_t i = t->corners_of.starts[place]; i < t->corners_of.starts[place + 1]; i++) {
                size_t face = norma_check_face_of(m, t->corners_of.corners[i]);
                double cosine =
                    norma_check_directed(&m->faces[face]) ? cosine_to(m, face, number) : -2;
                greatest[number] =
                    cosine > (double)greatest[number] ? (float)cosine : greatest[number];
            }
        }
    return result;
}

static norma_result check_far(check_mesh *m) {
    size_t count = norma_check_normal_count(m);
    float *greatest = norma_core_allocate(&m->run->call, count, sizeof *greatest);
    check_hits hits = {0};
    char message[CHECK_MESSAGE];
    if (!greatest) return NORMA_ERROR_MEMORY;
    find_nearest(m, greatest);
    norma_result result = find_nearest_around(m, greatest);
    for (size_t i = 0; !result && i < count; i++)
        if ((double)greatest[i] < FAR_COSINE)
            norma_check_hit(m->run, &hits,
                norma_check_arc_cosine(fmax((double)greatest[i], -1)) * (180 / 3.141592653589793),
                norma_check_normal_spot(m, i));
    norma_core_release(&m->run->call, greatest, count, sizeof *greatest);
    if (result) return result;
    if (hits.count)
        norma_check_message(message,
            "%z normal%s more than 75 degrees from every face at the vertex, up to %g; averaging "
            "the faces cannot give this, except along knife-thin edges",
            hits.count, norma_check_plural(hits.count), hits.worst);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N202,
            .severity = m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_WARNING,
            .unit = "deg",
            .hits = &hits,
            .message = message});
}

/* ---- both */

norma_result norma_check_facing(check_mesh *m) {
    size_t blocks = norma_check_block_count(m->mesh.face_count, FACES_IN_BLOCK), far_corners = 0;
    int per_facet = m->given->info.normals == NORMA_NORMALS_PER_FACET; /* N205 judges those */
    if (!norma_check_normal_count(m) || per_facet || !m->mesh.face_count ||
        !norma_check_wants_any(m, RULE_N201, RULE_N202))
        return NORMA_OK;
    norma_result result = norma_check_faces(m);
    if (!result) result = norma_check_users(m);
    facing_pass pass = {m, fmax(ACROSS, norma_check_encoding_bound(m->given->info.encoding)), NULL,
        norma_check_wants(m, RULE_N201)};
    pass.parts = result ? NULL : norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts);
    if (!pass.parts) return result ? result : NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_check_blocks(m->run, m->mesh.face_count, FACES_IN_BLOCK, judge_faces, &pass);
    check_hits opposed = {0};
    double opposed_area = 0;
    for (size_t i = 0; i < blocks; i++) {
        opposed_area += pass.parts[i].opposed_area;
        norma_check_hits_merge(m->run, &opposed, &pass.parts[i].opposed);
        far_corners += pass.parts[i].far_corners;
    }
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    if (!result && opposed.count) result = add_opposed(m, &opposed, opposed_area);
    norma_check_hits_free(&opposed);
    return !result && far_corners && norma_check_wants(m, RULE_N202) ? check_far(m) : result;
}
