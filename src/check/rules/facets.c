/* facets.c: N205: the normals of STL facets against their winding. */
#include "check/rules/mesh_rules.h"
#include "check/findings/angle.h"
#include "core/face/unit_length.h"
#include <math.h>
#include <string.h>

enum { FACETS_IN_BLOCK = 1 << 14 };
static const double NEAR_COSINE = 0.9961946980917455; /* of 5 degrees */
static const double LEAST_SHARE = .001;               /* of the area: below it, the rule informs */

typedef struct facet_part {
    check_hits hits;
    size_t zeros;
    double twice_area; /* of those */
} facet_part;

typedef struct facet_pass {
    const check_mesh *m;
    facet_part *parts;
} facet_pass;

/* A facet that is degenerate has no direction to compare with; its zero normal is as right as any.
 */
static void judge_facet(const check_mesh *m, facet_part *part, size_t facet) {
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
        norma_check_hit(m->run, &part->hits,
            norma_check_arc_cosine(fmax(cosine, -1)) * (180 / 3.141592653589793),
            norma_check_face(facet));
    }
}

static void judge_facets(void *context, size_t block, size_t begin, size_t end) {
    const facet_pass *pass = context;
    for (size_t f = begin; f < end; f++) judge_facet(pass->m, &pass->parts[block], f);
}

static norma_result add_facets(check_mesh *m, check_hits *hits, size_t zeros, double twice_area) {
    char message[CHECK_MESSAGE];
    const int matters = twice_area >= LEAST_SHARE * norma_check_whole_area(m);
    if (zeros == hits->count)
        norma_check_message(message,
            "%z of %z facets have a zero normal; readers compute it from the winding", zeros,
            m->mesh.face_count);
    else if (zeros)
        norma_check_message(message,
            "%z of %z facet normals disagree with the winding, by up to %g degrees; %z of them are "
            "zero",
            hits->count, m->mesh.face_count, hits->worst, zeros);
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
            .hits = hits,
            .message = message});
}

norma_result norma_check_facets(check_mesh *m) {
    size_t count = norma_check_normal_count(m), blocks, zeros = 0;
    double twice_area = 0;
    count = count < m->mesh.face_count ? count : m->mesh.face_count;
    blocks = norma_check_block_count(count, FACETS_IN_BLOCK);
    if (m->given->info.normals != NORMA_NORMALS_PER_FACET || !count ||
        !norma_check_wants(m, RULE_N205))
        return NORMA_OK;
    norma_result result = norma_check_faces(m);
    facet_pass pass = {
        m, result ? NULL : norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    if (!pass.parts) return result ? result : NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_check_blocks(m->run, count, FACETS_IN_BLOCK, judge_facets, &pass);
    check_hits hits = {0};
    for (size_t i = 0; i < blocks; i++) {
        norma_check_hits_merge(m->run, &hits, &pass.parts[i].hits);
        zeros += pass.parts[i].zeros;
        twice_area += pass.parts[i].twice_area;
    }
    norma_core_release(&m->run->call, pass.parts, blocks, sizeof *pass.parts);
    if (!result && hits.count) return add_facets(m, &hits, zeros, twice_area);
    norma_check_hits_free(&hits);
    return result;
}
