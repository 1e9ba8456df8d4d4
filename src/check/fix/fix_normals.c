/* fix_normals.c: normals and tangents put right one by one: what is no unit vector, what lies on
 * the wrong side, what is far from the surface, facets that differ from their winding, seams. New
 * ones come from the surface, by the weight and crease that the others show. */
#include "check/fix/fix.h"
#include "core/face/unit_length.h"
#include <stdlib.h>
#include <string.h>

/* What a rule names normals by: their own number in OBJ, the facet in STL, else the vertex. */
static fix_element element_of(const fix_mesh *m) {
    return m->data.corner_normals                       ? MEND_NORMAL
           : m->info.normals == NORMA_NORMALS_PER_FACET ? MEND_FACE
                                                        : MEND_VERTEX;
}

/* ---- from the surface */

enum { MEND_BAD = 1, MEND_WRONG = 2 };

typedef struct normal_sum {
    double normal[3];
    uint32_t corners;
} normal_sum;

/* A vn that corners with quite different normals name cannot be right for all of them: where the
 * old one is a direction at all, it stays. */
static int set_sum(fix_mesh *m, size_t number, const normal_sum *sum, int is_bad) {
    static const double up[3] = {0, 0, 1};
    double squares = sum->normal[0] * sum->normal[0] + sum->normal[1] * sum->normal[1] +
                     sum->normal[2] * sum->normal[2];
    if (squares > 0.25 * (double)sum->corners * (double)sum->corners)
        return norma_fix_set_normal(m, number, sum->normal);
    return !is_bad || norma_fix_set_normal(m, number, squares > 0 ? sum->normal : up);
}

/* Its corners need normals that differ visibly: one for all of them would be wrong. */
static int is_torn(const normal_sum *sum) {
    const double squares = sum->normal[0] * sum->normal[0] + sum->normal[1] * sum->normal[1] +
                           sum->normal[2] * sum->normal[2];
    return squares < (1 - 1e-6) * (double)sum->corners * (double)sum->corners;
}

/* Computing what is broken, once the edits are made, changes nothing else: every corner has a
 * normal, and no other is broken, or they are all made unit. */
static int may_compute_broken(const fix_mesh *m, const uint8_t *marks) {
    if (!m->data.corner_normals) return 0;
    for (size_t c = 0; c < m->mesh.corner_count; ++c)
        if (m->data.corner_normals[c] >= norma_fix_normal_count(m)) return 0;
    for (size_t i = 0; i < norma_fix_normal_count(m) && !norma_fix_has(m, RULE_N103); ++i) {
        double normal[3], length;
        norma_fix_normal(m, i, normal);
        if (marks[i] != MEND_BAD && norma_core_judge_length(normal, 5e-4, &length)) return 0;
    }
    return 1;
}

/* Each marked normal becomes the sum of the surface's at its corners; marks of MEND_BAD: it is no
 * direction now. A vn without a direction whose corners need different ones is left for its corners
 * to get one each. */
static norma_result recompute(fix_mesh *m, const uint8_t *marks) {
    size_t count = norma_fix_normal_count(m);
    norma_result result = m->info.normals == NORMA_NORMALS_PER_FACET ? norma_fix_face_normals(m)
                                                                     : norma_fix_surface(m);
    normal_sum *sums = result ? NULL : calloc(count + 1, sizeof *sums);
    if (!sums) return result ? result : NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < m->mesh.face_count; ++face) {
        size_t begin = norma_core_face_begin(&m->mesh, face),
               end = norma_core_face_end(&m->mesh, face);
        int reversed = m->edit->reverse_faces && m->edit->reverse_faces[face];
        for (size_t c = begin; c < end; ++c) {
            size_t number = norma_fix_normal_of(m, face, c),
                   now = reversed && c > begin ? end + begin - c : c;
            const float *normal = m->surface ? m->surface + 3 * now : m->face_normals + 3 * face;
            if (number == SIZE_MAX || !marks[number]) continue;
            for (size_t axis = 0; axis < 3; ++axis)
                sums[number].normal[axis] += (double)normal[axis];
            ++sums[number].corners;
        }
    }
    const int may_compute = !result && may_compute_broken(m, marks);
    for (size_t i = 0; i < count && !result; ++i) {
        if (marks[i] == MEND_BAD && may_compute && is_torn(&sums[i])) {
            m->plan->breaks = 1;
            m->plan->deviation = m->deviation;
        } else if (marks[i] && !set_sum(m, i, &sums[i], marks[i] == MEND_BAD))
            result = NORMA_ERROR_MEMORY;
    }
    free(sums);
    return result;
}

static norma_result recompute_named(fix_mesh *m) {
    size_t count = norma_fix_normal_count(m);
    uint8_t *marks = NULL, *wrong = NULL;
    int bad = norma_fix_mark(m, RULE_N101, element_of(m), count, &marks);
    int zero = norma_fix_mark(m, RULE_N102, element_of(m), count, &marks);
    int far = norma_fix_mark(m, RULE_N202, element_of(m), count, &wrong);
    int all =
            (norma_fix_has(m, RULE_N203) && !m->data.corner_normals) || norma_fix_has(m, RULE_N206),
        any = bad > 0 || zero > 0 || far > 0 || all;
    if (any && !marks) marks = calloc(count + 1, 1);
    int failed = bad < 0 || zero < 0 || far < 0 || (any && !marks);
    for (size_t i = 0; i < count && any && !failed; ++i)
        if (!marks[i] && (all || (wrong && wrong[i]))) marks[i] = MEND_WRONG;
    norma_result result = failed ? NORMA_ERROR_MEMORY : any ? recompute(m, marks) : NORMA_OK;
    free(marks);
    free(wrong);
    return result;
}

/* ---- lengths */

static norma_result normalise_named(fix_mesh *m) {
    uint8_t *marks = NULL;
    size_t count = norma_fix_normal_count(m);
    int any = norma_fix_mark(m, RULE_N103, element_of(m), count, &marks);
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : NORMA_OK;
    for (size_t i = 0; i < count && any > 0 && !result; ++i) {
        double normal[3];
        if (!marks[i] || (m->edit->set_normals && m->edit->set_normals[i])) continue;
        norma_fix_normal(m, i, normal);
        result = norma_fix_set_normal(m, i, normal) ? NORMA_OK : NORMA_ERROR_MEMORY;
    }
    free(marks);
    return result;
}

/* ---- facets */

/* A normal on the other side of a facet that is not turned back is left: 1 where it is right, as
 * the facet is shown to be turned, which is for N301, N302 and N304 to mend; 2 where nothing shows
 * which of both is wrong, and it is nearly the opposite of the winding. */
static int why_left(const fix_mesh *m, size_t facet) {
    double normal[3];
    if (m->edit->reverse_faces && m->edit->reverse_faces[facet]) return 0;
    norma_fix_normal(m, facet, normal);
    const double dot = norma_check_dot(m->face_normals + 3 * facet, normal),
                 length = norma_core_length(normal);
    if (!(dot < 0)) return 0;
    if (m->shared.sides[facet] & CORE_SIDE_UNDECIDED)
        return dot <= -CHECK_LEAN_COSINE * length ? 2 : 0;
    return m->shared.sides[facet] & CORE_SIDE_TURNED ? 1 : 0;
}

static void note_left(const fix_mesh *m, size_t facets, const char *why) {
    char text[CHECK_MESSAGE];
    if (!facets) return;
    norma_check_message(text, "N205 facet-normal-mismatch is not fixed for %z facet%s: %s", facets,
        norma_check_plural(facets), why);
    norma_fix_note(m->plan, FIX_RULE(RULE_N205), text, why);
}

/* Those that differ from their winding, and those whose winding is reversed. */
static norma_result rewrite_facets(fix_mesh *m) {
    uint8_t *marks = NULL;
    int any = norma_fix_mark(m, RULE_N205, MEND_FACE, m->mesh.face_count, &marks);
    const norma_result made = any > 0 ? norma_fix_face_normals(m) : NORMA_OK;
    if (made) {
        free(marks);
        return made;
    }
    size_t left[3] = {0};
    for (size_t f = 0; f < m->mesh.face_count && any > 0 && m->shared.sides; ++f) {
        const int why = marks[f] ? why_left(m, f) : 0;
        ++left[why];
        if (why) marks[f] = 0;
    }
    note_left(m, left[1], "there the winding is wrong and the normal is right (N301, N302)");
    note_left(m, left[2],
        "neither volume nor rays nor neighbours show whether the normal or the winding is wrong");
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : any > 0 ? recompute(m, marks) : NORMA_OK;
    free(marks);
    return result;
}

/* ---- seams: all normals at a position that is named become the smooth one there */

typedef struct seam_place {
    double position[3];
} seam_place;

static int compare_seam_places(const void *a, const void *b) {
    return norma_fix_compare_points(
        ((const seam_place *)a)->position, ((const seam_place *)b)->position);
}

/* Positions that findings at a mesh name: how many; written too unless places is NULL. */
static size_t take_seam_places(
    const norma_finding **found, size_t count, const core_mesh *mesh, seam_place *places) {
    size_t taken = 0;
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; norma_fix_is_rule(found[i], RULE_N501) && k < found[i]->sample_count;
             ++k) {
            const size_t vertex = found[i]->samples[k].vertex;
            if (vertex >= mesh->positions.count) continue;
            if (places) norma_core_position(mesh, (uint32_t)vertex, places[taken].position);
            ++taken;
        }
    return taken;
}

static seam_place *gather_places(const fix_mesh *m, size_t *count) {
    *count = take_seam_places(m->findings, m->finding_count, &m->mesh, NULL);
    seam_place *places = calloc(*count + 1, sizeof *places);
    if (!places) return NULL;
    (void)take_seam_places(m->findings, m->finding_count, &m->mesh, places);
    qsort(places, *count, sizeof *places, compare_seam_places);
    return places;
}

/* A vn that corners elsewhere use as well cannot be changed without changing them. */
static void find_shared(const fix_mesh *m, const uint8_t *at_seam, uint8_t *shared) {
    for (size_t face = 0; face < m->mesh.face_count; ++face)
        for (size_t c = norma_core_face_begin(&m->mesh, face);
             c < norma_core_face_end(&m->mesh, face); ++c) {
            size_t number = norma_fix_normal_of(m, face, c);
            if (number != SIZE_MAX && !at_seam[norma_core_corner(&m->mesh, c)]) shared[number] = 1;
        }
}

static norma_result set_seam_normals(fix_mesh *m, const uint8_t *at_seam, const float *smooth) {
    uint8_t *shared = calloc(norma_fix_normal_count(m) + 1, 1);
    norma_result result = shared ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (shared) find_shared(m, at_seam, shared);
    for (size_t face = 0; face < m->mesh.face_count && !result; ++face)
        for (size_t c = norma_core_face_begin(&m->mesh, face);
             c < norma_core_face_end(&m->mesh, face) && !result; ++c) {
            uint32_t position = norma_core_corner(&m->mesh, c);
            size_t number = norma_fix_normal_of(m, face, c);
            if (number == SIZE_MAX || !at_seam[position] || shared[number]) continue;
            const double normal[3] = {(double)smooth[3 * (size_t)position],
                (double)smooth[3 * (size_t)position + 1], (double)smooth[3 * (size_t)position + 2]};
            result = norma_fix_set_normal(m, number, normal) ? NORMA_OK : NORMA_ERROR_MEMORY;
        }
    free(shared);
    return result;
}

/* Seams that several primitives have in common: their normals are given. */
static norma_result share_across(fix_mesh *m) {
    uint8_t *at_seam = calloc(m->mesh.positions.count + 1, 1);
    for (size_t i = 0; at_seam && i < m->mesh.positions.count; ++i)
        at_seam[i] = isfinite(m->shared.smooth[3 * i]) != 0;
    norma_result result =
        at_seam ? set_seam_normals(m, at_seam, m->shared.smooth) : NORMA_ERROR_MEMORY;
    free(at_seam);
    return result;
}

static norma_result share_seams(fix_mesh *m) {
    if (m->shared.smooth) return share_across(m);
    if (!norma_fix_has(m, RULE_N501)) return NORMA_OK;
    size_t count, positions = m->mesh.positions.count;
    seam_place *places = gather_places(m, &count), key;
    uint8_t *at_seam = calloc(positions + 1, 1);
    float *smooth = malloc((positions + 1) * 3 * sizeof *smooth);
    norma_result result = places && at_seam && smooth ? norma_fix_surface(m)
                                                      : NORMA_ERROR_MEMORY; /* for the weight */
    if (!result) {
        const norma_mesh now = norma_fix_mesh_now(m);
        const norma_options options = {
            .struct_size = sizeof options, .weight = m->deviation.weight, .threads = m->threads};
        result = norma_vertex_normals(&now, &options, smooth, positions, NULL);
    }
    for (size_t i = 0; i < positions && !result && count; ++i) {
        norma_core_position(&m->mesh, (uint32_t)i, key.position);
        at_seam[i] = bsearch(&key, places, count, sizeof *places, compare_seam_places) != NULL;
    }
    if (!result) result = set_seam_normals(m, at_seam, smooth);
    free(places);
    free(at_seam);
    free(smooth);
    return result;
}

norma_result norma_fix_normals(fix_mesh *m) {
    norma_result result = norma_fix_normal_count(m) ? recompute_named(m) : NORMA_OK;
    if (!result && norma_fix_normal_count(m)) result = normalise_named(m);
    if (!result) result = norma_fix_turn_normals(m);
    if (!result && m->info.normals == NORMA_NORMALS_PER_FACET) result = rewrite_facets(m);
    return result ? result : share_seams(m);
}

/* ---- The normals that both sides of a seam get where it runs between two primitives of
 * a glTF mesh (N501): those of the whole mesh. */

/* Those of all of the mesh's primitives: how many; written too unless places is NULL. */
static size_t take_group_places(const fix_maker *m, seam_place *places) {
    size_t count, taken = 0;
    for (size_t i = 0; i < m->count; ++i) {
        const norma_finding **found = norma_places_find(&m->mended, m->wheres[i], &count);
        taken += take_seam_places(found, count, &m->meshes[i], places ? places + taken : NULL);
    }
    return taken;
}

/* As the first primitive's stored normals show. */
static norma_result find_weight(const fix_maker *m, norma_weight *weight) {
    const norma_options options = {
        .struct_size = sizeof options, .threads = m->request->options.threads};
    norma_deviation deviation;
    const norma_deviation *known = norma_places_deviation(&m->known, m->wheres[0]);
    if (known) *weight = known->weight;
    if (known) return NORMA_OK;
    const norma_result result =
        norma_explain_normals(&m->first_data, m->first_info.normals, &options, &deviation);
    *weight = !result && deviation.corners ? deviation.weight : NORMA_WEIGHT_ANGLE;
    return result;
}

/* Of each primitive the normals at those places. */
static norma_result share_out(
    const fix_maker *m, const seam_place *places, size_t count, const float *normals) {
    size_t begin = 0;
    for (size_t i = 0; i < m->count; begin += m->meshes[i++].positions.count) {
        const size_t vertices = m->meshes[i].positions.count;
        float *smooth = malloc((vertices + 1) * 3 * sizeof *smooth);
        if (!smooth) return NORMA_ERROR_MEMORY;
        m->shared[m->indices[i]].smooth = smooth;
        for (size_t v = 0; v < vertices; ++v) {
            seam_place key;
            norma_core_position(&m->meshes[i], (uint32_t)v, key.position);
            const int named =
                bsearch(&key, places, count, sizeof *places, compare_seam_places) != NULL;
            for (size_t k = 0; k < 3; ++k)
                smooth[3 * v + k] = named ? normals[3 * (begin + v) + k] : NAN;
        }
    }
    return NORMA_OK;
}

static norma_result share_normals(
    const fix_maker *m, const seam_place *places, size_t count, norma_weight weight) {
    const norma_options options = {
        .struct_size = sizeof options, .weight = weight, .threads = m->request->options.threads};
    check_joined whole;
    norma_result result = norma_check_join(m->meshes, m->count, &whole);
    if (result) return result;
    const size_t vertices = whole.mesh.positions.count;
    float *normals = malloc((vertices + 1) * 3 * sizeof *normals);
    result = normals ? norma_vertex_normals(&whole.mesh, &options, normals, vertices, NULL)
                     : NORMA_ERROR_MEMORY;
    if (!result) result = share_out(m, places, count, normals);
    free(normals);
    norma_check_unjoin(&whole);
    return result;
}

norma_result norma_fix_seams(fix_maker *m) {
    const size_t count = take_group_places(m, NULL);
    norma_weight weight = NORMA_WEIGHT_ANGLE;
    seam_place *places = count ? calloc(count, sizeof *places) : NULL;
    if (!places) return count ? NORMA_ERROR_MEMORY : NORMA_OK;
    (void)take_group_places(m, places);
    qsort(places, count, sizeof *places, compare_seam_places);
    norma_result result = find_weight(m, &weight);
    if (!result) result = share_normals(m, places, count, weight);
    free(places);
    return result;
}

/* ---- Tangents put right one by one. Broken and missing ones are computed as
 * norma_document_tangents does, with MikkTSpace's bits, once the edits are made; without normals or
 * texture coordinates broken ones become some unit vector perpendicular to the normal. Where signs
 * of a primitive disagree, those of the smaller side turn round and nothing else does. */

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
    for (size_t i = 0; i < sizeof rules / sizeof *rules && any >= 0; ++i) {
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
    for (size_t i = 0; marks->turned && i < m->attributes.tangent_count; ++i) {
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
    for (size_t i = 0; i < count && !result; ++i) {
        double normal[3] = {0, 0, 0};
        int made = is_marked(marks->again, i);
        set[i] = (uint8_t)(made || is_marked(marks->lean, i) || is_marked(marks->turned, i));
        if (i < norma_fix_normal_count(m)) norma_fix_normal(m, i, normal);
        for (size_t k = 0; k < 3; ++k) normals[3 * i + k] = (float)normal[k];
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
