/* solids.c: N302 and N304 over one mesh by itself, or held until the other primitives of its glTF
 * mesh have come (solids_joined.c). */
#include "check/rules/solids.h"

norma_result norma_check_solids(check_mesh *m) {
    core_components components;
    const int nesting = norma_check_wants(m, RULE_N302), sides = norma_check_wants(m, RULE_N304);
    if (!m->mesh.face_count ||
        !(nesting || sides ||
            (m->siblings &&
                (m->run->rules[RULE_N301] || m->run->rules[RULE_N302] || m->run->rules[RULE_N304] ||
                    norma_check_wants_open(m->run, m->run->rules)))))
        return NORMA_OK;
    norma_result result = norma_check_pairs(m);
    if (!result) result = norma_core_find_components(&m->topology, CORE_JOIN_BODIES, &components);
    if (result) return result;
    if (m->siblings) {
        result = norma_check_solids_hold(m, &components);
    } else {
        result = norma_check_judge_solids(&m->topology, &components, nesting, sides);
        if (!result)
            result =
                norma_check_tell_solids(&(check_solids){m, &components, 0, m->mesh.face_count});
    }
    norma_core_release_components(&m->run->call, &components);
    return result;
}
