/* fix_tangents.c: tangents put right one by one. Broken and missing ones are computed as
 * norma_document_tangents does, with MikkTSpace's bits, once the edits are made; without normals or
 * texture coordinates broken ones become some unit vector perpendicular to the normal. Where signs
 * of a primitive disagree, those of the smaller side turn round and nothing else does. */
#include "check/fix/fix.h"
#include <stdlib.h>
#include <string.h>

/* 0: out of memory. */
static int compute_later(const fix_mesh *m) {
    if (!m->plan->tangents) m->plan->tangents = calloc(m->plan->mesh_count + 1, 1);
    if (m->plan->tangents) m->plan->tangents[m->index] = 1;
    return m->plan->tangents != NULL;
}

static int has_inputs(const fix_mesh *m) {
    return m->attributes.texcoords && m->info.normals == NORMA_NORMALS_PER_VERTEX;
}

/* ---- which */

typedef struct tangent_marks {
    uint8_t *again, *lean, *turned; /* of each vertex: to be made; to be made perpendicular; its
                                       sign turns round. NULL: none */
} tangent_marks;

/* 1: any; 0: none; -1: out of memory. */
static int mark_again(const fix_mesh *m, tangent_marks *marks) {
    static const check_rule rules[] = {RULE_N801, RULE_N802};
    int any = 0;
    if (has_inputs(m))
        return norma_fix_has(m, RULE_N801) || norma_fix_has(m, RULE_N802) ||
                       norma_fix_has(m, RULE_N805)
                   ? compute_later(m) - 1
                   : 0;
    for (size_t i = 0; i < sizeof rules / sizeof *rules && any >= 0; i++) {
        int found = norma_fix_mark(m, rules[i], MEND_VERTEX, m->info.vertices, &marks->again);
        any = found < 0 ? found : any | found;
    }
    return any;
}

static int mark_vertices(const fix_mesh *m, tangent_marks *marks) {
    const int any = mark_again(m, marks);
    int leaning =
        any < 0 ? any : norma_fix_mark(m, RULE_N803, MEND_VERTEX, m->info.vertices, &marks->lean);
    int turning = leaning < 0
                      ? leaning
                      : norma_fix_mark(m, RULE_N804, MEND_VERTEX, m->info.vertices, &marks->turned);
    return any < 0 || leaning < 0 || turning < 0 ? -1 : any | leaning | turning;
}

/* ---- making */

static int is_marked(const uint8_t *marks, size_t i) { return marks && marks[i]; }

/* A sign that is wrong by itself keeps its vector, to the bit. */
static void turn_signs(const fix_mesh *m, const tangent_marks *marks, float *tangents) {
    for (size_t i = 0; marks->turned && i < m->attributes.tangent_count; i++) {
        if (!marks->turned[i] || is_marked(marks->again, i)) continue;
        if (!is_marked(marks->lean, i))
            memcpy(tangents + 4 * i, m->attributes.tangents + 4 * i, 3 * sizeof *tangents);
        tangents[4 * i + 3] = -m->attributes.tangents[4 * i + 3];
    }
}

static norma_result make_tangents(fix_mesh *m, const tangent_marks *marks) {
    size_t count = m->info.vertices;
    float *tangents = calloc(4 * count + 1, sizeof *tangents),
          *normals = calloc(3 * count + 1, sizeof *normals);
    uint8_t *set = calloc(count + 1, 1);
    m->edit->tangents = tangents;
    m->edit->set_tangents = set;
    norma_result result = tangents && normals && set ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < count && !result; i++) {
        double normal[3] = {0, 0, 0};
        int made = is_marked(marks->again, i);
        set[i] = (uint8_t)(made || is_marked(marks->lean, i) || is_marked(marks->turned, i));
        if (i < norma_fix_normal_count(m)) norma_fix_normal(m, i, normal);
        for (size_t k = 0; k < 3; k++) normals[3 * i + k] = (float)normal[k];
        if (made)
            tangents[4 * i + 3] = 1;
        else if (i < m->attributes.tangent_count)
            memcpy(tangents + 4 * i, m->attributes.tangents + 4 * i, 4 * sizeof *tangents);
    }
    const norma_vec3_view view = {.data = normals, .count = count, .format = NORMA_FORMAT_FLOAT};
    if (!result)
        result = norma_orthogonalise_tangents(tangents, 0, view, count, tangents, 0, count);
    if (!result) turn_signs(m, marks, tangents);
    free(normals);
    return result;
}

norma_result norma_fix_tangents(fix_mesh *m) {
    tangent_marks marks = {0};
    int any = mark_vertices(m, &marks);
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : any ? make_tangents(m, &marks) : NORMA_OK;
    free(marks.again);
    free(marks.lean);
    free(marks.turned);
    return result;
}
