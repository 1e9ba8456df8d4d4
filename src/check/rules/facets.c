/* facets.c: N205: the normals of STL facets against their winding. */
#include "check/rules/local_rules.h"
#include "check/rules/mesh_rules.h"
#include "check/findings/angle.h"
#include "core/face/unit_length.h"
#include <math.h>
#include <string.h>

enum { FACETS_IN_BLOCK = 1 << 14 };
static const double NEAR_COSINE = 0.9961946980917455; /* of 5 degrees */
static const double LEAST_SHARE = .001;               /* of the area: below it, the rule informs */

typedef struct facet_pass {
    const check_mesh *m;
    check_facets *parts;
    uint8_t *behind; /* of each face: 1: its normal is on the other side; 2: nearly the opposite of
                        its winding; or NULL */
} facet_pass;

/* A facet that is degenerate has no direction to compare with; its zero normal is as right as any.
 */
static void judge_facet(const facet_pass *pass, check_facets *part, size_t facet) {
    const check_mesh *m = pass->m;
    double n[3], length;
    norma_check_normal(m, facet, n);
    const core_length is = norma_core_judge_length(n, 0, &length);
    const double cosine = norma_check_dot(m->faces[facet].normal, n) / length;
    if (is == CORE_LENGTH_NON_FINITE || !norma_check_directed(&m->faces[facet]) ||
        norma_check_is_sliver(&m->faces[facet]))
        return;
    if (is == CORE_LENGTH_ZERO || cosine < NEAR_COSINE)
        part->twice_area += norma_check_twice_area(m, facet);
    if (is == CORE_LENGTH_ZERO) {
        part->zeros++;
        norma_check_hit(m->run, &part->hits, NAN, norma_check_face(facet));
    } else if (cosine < NEAR_COSINE) {
        if (pass->behind)
            pass->behind[facet] = (uint8_t)((cosine < 0) + (cosine <= -CHECK_LEAN_COSINE));
        norma_check_hit(m->run, &part->hits,
            norma_check_arc_cosine(fmax(cosine, -1)) * (180 / 3.141592653589793),
            norma_check_face(facet));
    }
}

static void judge_facets(void *context, size_t block, size_t begin, size_t end) {
    const facet_pass *pass = context;
    for (size_t f = begin; f < end; f++) judge_facet(pass, &pass->parts[block], f);
}

/* Those that no fix of normals is for: wound wrongly while their normals are right, or perhaps. */
static norma_result count_turned(check_mesh *m, const uint8_t *behind, check_facets *sum) {
    const size_t faces = m->mesh.face_count;
    if (!memchr(behind, 1, faces) && !memchr(behind, 2, faces)) return NORMA_OK;
    uint8_t *sides = norma_core_allocate(&m->run->call, faces, 1);
    const norma_result result = sides ? norma_check_sides(m, behind, sides) : NORMA_ERROR_MEMORY;
    for (size_t f = 0; !result && f < faces; f++) {
        sum->turned += behind[f] && norma_check_is_turned(sides[f]);
        sum->undecided += behind[f] > 1 && sides[f] & CORE_SIDE_UNDECIDED;
    }
    norma_core_release(&m->run->call, sides, faces, 1);
    return result;
}

norma_result norma_check_facets_add(check_mesh *m, check_facets *sum) {
    check_hits *hits = &sum->hits;
    const size_t zeros = sum->zeros, turned = sum->turned, undecided = sum->undecided;
    char message[CHECK_MESSAGE];
    const int matters = sum->twice_area >= LEAST_SHARE * sum->whole_area;
    if (!hits->count) return NORMA_OK;
    if (zeros == hits->count)
        norma_check_message(message,
            "%z of %z facets have a zero normal; readers compute it from the winding", zeros,
            m->mesh.face_count);
    else if (zeros)
        norma_check_message(message,
            "%z of %z facet normals disagree with the winding, by up to %g degrees; %z of them are "
            "zero",
            hits->count, m->mesh.face_count, hits->worst, zeros);
    else if (turned == hits->count)
        norma_check_message(message,
            "%z of %z facet normals disagree with the winding, by up to %g degrees; there the "
            "winding is wrong and the normals are right (N301, N302)",
            hits->count, m->mesh.face_count, hits->worst);
    else if (turned + undecided == hits->count)
        norma_check_message(message,
            "%z of %z facet normals disagree with the winding, by up to %g degrees; neither volume "
            "nor rays nor neighbours show for %z of them which is wrong",
            hits->count, m->mesh.face_count, hits->worst, undecided);
    else
        norma_check_message(message,
            "%z of %z facet normals disagree with the winding, by up to %g degrees; some readers "
            "use the normal, others the winding",
            hits->count, m->mesh.face_count, hits->worst);
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N205,
            .severity = matters ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
            .unit = "deg",
            .no_value = zeros == hits->count,
            .no_fix = turned + undecided == hits->count,
            .hits = hits,
            .message = message});
}

norma_result norma_check_facets_look(check_mesh *m, check_facets *sum, uint8_t *behind) {
    const core_call *call = &m->run->call;
    const size_t normals = norma_check_normal_count(m), faces = m->mesh.face_count,
                 count = normals < faces ? normals : faces,
                 blocks = norma_check_block_count(count, FACETS_IN_BLOCK);
    if (!count) return NORMA_OK;
    norma_result result = norma_check_faces(m);
    if (result) return result;
    facet_pass pass = {m, norma_core_allocate(call, blocks, sizeof *pass.parts), behind};
    if (!pass.parts) return NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_check_blocks(m->run, count, FACETS_IN_BLOCK, judge_facets, &pass);
    for (size_t i = 0; i < blocks; i++) {
        norma_check_hits_merge(m->run, &sum->hits, &pass.parts[i].hits);
        sum->zeros += pass.parts[i].zeros;
        sum->twice_area += pass.parts[i].twice_area;
    }
    norma_core_release(call, pass.parts, blocks, sizeof *pass.parts);
    return result;
}

norma_result norma_check_facets(check_mesh *m) {
    const core_call *call = &m->run->call;
    const size_t faces = m->mesh.face_count;
    check_facets sum = {.zeros = 0};
    if (m->given->info.normals != NORMA_NORMALS_PER_FACET || !faces ||
        !norma_check_wants(m, RULE_N205))
        return NORMA_OK;
    uint8_t *behind = norma_core_allocate(call, faces, 1);
    if (!behind) return NORMA_ERROR_MEMORY;
    memset(behind, 0, faces);
    norma_result result = norma_check_facets_look(m, &sum, behind);
    if (!result) result = count_turned(m, behind, &sum);
    norma_core_release(call, behind, faces, 1);
    if (!result && sum.hits.count) sum.whole_area = norma_check_add_areas(m, 0);
    if (!result) result = norma_check_facets_add(m, &sum);
    norma_check_hits_free(&sum.hits);
    return result;
}
