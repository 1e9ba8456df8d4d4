/* open_edges.c: N307: edges of one face only, over one mesh by itself, or over the primitives of a
 * glTF mesh together (solids_joined.c). For a print they are what is left to close. */
#include "check/rules/solids.h"

norma_result norma_check_add_open(check_mesh *m, const core_topology *topology, size_t first) {
    check_hits hits = {0};
    for (size_t f = 0; f < m->mesh.face_count; f++)
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             c++)
            if (topology->partners[first + c] == CORE_EDGE_OPEN)
                norma_check_hit(
                    m->run, &hits, 0, (check_spot){norma_core_corner(&m->mesh, c), f, SIZE_MAX});
    return norma_check_report(m,
        &(check_report){
            .rule = RULE_N307, .severity = NORMA_SEVERITY_WARNING, .no_value = 1, .hits = &hits},
        "%z open edge%s (of one face only); nothing separates inside from outside there",
        hits.count, norma_check_plural(hits.count));
}

int norma_check_wants_open(const check_run *run, const uint8_t *rules) {
    return rules[RULE_N307] && run->profile != NORMA_CHECK_PROFILE_RENDER;
}

norma_result norma_check_open_edges(check_mesh *m) {
    if (m->siblings || !m->mesh.face_count || !norma_check_wants_open(m->run, m->rules))
        return NORMA_OK;
    const norma_result result = norma_check_pairs(m);
    return result ? result : norma_check_add_open(m, &m->topology, 0);
}
