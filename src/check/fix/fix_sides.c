/* fix_sides.c: where normals and winding disagree (N201, N205), or neighbours do (N301), which of
 * both is wrong, and what is turned. norma_fix_ask_sides judges the faces: those are turned that
 * are shown to be, by the volume of what is closed and by rays from what is open. Rays say nothing
 * of a material that is seen from both sides. The primitives of a glTF mesh are looked at together.
 * norma_fix_windings then reverses faces, and norma_fix_turn_normals normals that most of their
 * faces still oppose. Where nothing is decided nothing is turned, and a note says so; hence
 * norma_fix_may (fix_mesh.c) lets these rules in although they may have no fix, and why_idle
 * (fix.c) and norma_fix_worse_shape (fix_trial.c) speak of them. */
#include "check/fix/fix.h"
#include "check/rules/rules.h"
#include <stdlib.h>
#include <string.h>

static norma_result open_fix_judge(const fix_maker *m) {
    if (m->judge->is_open) return NORMA_OK;
    return norma_check_open_judge(m->meshes, m->count, m->request->options.threads, m->judge);
}

/* ---- whole bodies: those that look inward (N302), with what lies right inside them, if all of it
 * looks outward: then every shell has the wrong sign; and, where that is asked for, open ones
 * (N304) as a majority of rays has it */

static void mark_bodies(const core_components *c, uint8_t *marks) {
    for (size_t i = 0; i < c->count; ++i) {
        int any = 0;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k) any |= marks[c->faces[k]];
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k) marks[c->faces[k]] = (uint8_t)any;
    }
}

static void mark_shells(const core_components *c, uint8_t *marks, uint8_t *keeps) {
    for (size_t i = 0; i < c->count; ++i)
        if (c->each[i].parent != UINT32_MAX && c->each[i].verdict != COMPONENT_NESTED)
            keeps[c->each[i].parent] = 1;
    for (size_t i = 0; i < c->count; ++i) {
        const uint32_t parent = c->each[i].parent;
        if (parent == UINT32_MAX || keeps[parent] || c->each[parent].verdict != COMPONENT_INWARD ||
            !marks[c->faces[c->starts[parent]]])
            continue;
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; ++k) marks[c->faces[k]] = 1;
    }
}

static norma_result turn_shells(const core_topology *topology, core_components *c, uint8_t *marks) {
    static const uint8_t not_closed = COMPONENT_OPEN | COMPONENT_CONFLICT | COMPONENT_UNBALANCED;
    uint8_t *keeps = calloc(c->count + 1, 1);
    norma_result result =
        keeps ? norma_core_measure_components(topology, c, not_closed) : NORMA_ERROR_MEMORY;
    if (!result) result = norma_core_judge_nesting(topology, c, not_closed);
    if (!result) mark_shells(c, marks, keeps);
    free(keeps);
    return result;
}

static void add_votes(fix_plan *plan, const norma_orient_report *report) {
    if (plan->by_rays == 0 || report->least_confidence < plan->least_confidence)
        plan->least_confidence = report->least_confidence;
    plan->by_rays += report->by_rays;
    plan->undecided += report->undecided;
}

/* What rays turn is what differs from winding alike alone. marks: in, the faces that are open; out,
 * those of them to be reversed. */
static norma_result ask_rays(const fix_maker *m, uint8_t *marks) {
    const norma_options options = {
        .struct_size = sizeof options, .threads = m->request->options.threads};
    const norma_mesh *whole = &m->judge->whole.mesh;
    norma_orient_report report;
    uint8_t *alike = malloc(m->face_count + 1), *rays = malloc(m->face_count + 1);
    norma_result result = alike && rays ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result)
        result = norma_orient(whole, NORMA_ORIENT_OPEN_KEPT, &options, alike, m->face_count, NULL);
    if (!result)
        result =
            norma_orient(whole, NORMA_ORIENT_OPEN_BY_RAYS, &options, rays, m->face_count, &report);
    for (size_t f = 0; f < m->face_count && !result; ++f)
        marks[f] = marks[f] && alike[f] != rays[f];
    if (!result && report.open) add_votes(m->plan, &report);
    free(alike);
    free(rays);
    return result;
}

/* Of each mesh marks of its own, where there are any. */
static norma_result share_turned(const fix_maker *m, const uint8_t *inward, const uint8_t *open) {
    size_t begin = 0;
    for (size_t i = 0; i < m->count; begin += m->meshes[i++].face_count) {
        uint8_t *marks = malloc(m->meshes[i].face_count + 1);
        int any = 0;
        if (!marks) return NORMA_ERROR_MEMORY;
        for (size_t f = 0; f < m->meshes[i].face_count; ++f)
            any |= marks[f] = inward[begin + f] ^ open[begin + f];
        if (any)
            m->shared[m->indices[i]].turned = marks;
        else
            free(marks);
    }
    return NORMA_OK;
}

static norma_result turn_bodies(const fix_maker *m, uint8_t *inward, uint8_t *open) {
    const int turns = norma_fix_mark_group(m, RULE_N302, inward),
              asks = norma_fix_mark_group(m, RULE_N304, open);
    const core_topology *topology = &m->judge->sides.topology;
    core_components c;
    norma_result result = turns || asks ? open_fix_judge(m) : NORMA_OK;
    if (result || !(turns || asks)) return result;
    result = norma_core_find_components(topology, CORE_JOIN_BODIES, &c);
    if (result) return result;
    mark_bodies(&c, inward);
    mark_bodies(&c, open);
    if (turns) result = turn_shells(topology, &c, inward);
    if (!result && asks) result = ask_rays(m, open);
    norma_core_release_components(topology->call, &c);
    return result ? result : share_turned(m, inward, open);
}

norma_result norma_fix_turn(fix_maker *m) {
    uint8_t *inward = calloc(m->face_count + 1, 1), *open = calloc(m->face_count + 1, 1);
    const norma_result result = inward && open ? turn_bodies(m, inward, open) : NORMA_ERROR_MEMORY;
    free(inward);
    free(open);
    return result;
}

/* ---- which faces are turned */

/* 1: its material is double-sided, or not opaque. */
static norma_document_result is_on_purpose(const fix_maker *m, size_t index, int *on_purpose) {
    norma_mesh_attributes attributes;
    norma_material_info material;
    *on_purpose = 0;
    norma_document_result result =
        norma_document_mesh_attributes(m->document, index, &attributes, m->error);
    if (result || attributes.material >= norma_document_material_count(m->document)) return result;
    result = norma_document_material_info(m->document, attributes.material, &material);
    *on_purpose = !result && (material.double_sided || material.not_opaque);
    return result;
}

static norma_document_result share_sides(const fix_maker *m, const uint8_t *sides) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < m->count && !result; sides += m->meshes[i++].face_count) {
        const size_t faces = m->meshes[i].face_count;
        int on_purpose;
        uint8_t *own = malloc(faces + 1);
        if (!own) return norma_fix_fail(m->error, NORMA_ERROR_MEMORY);
        memcpy(own, sides, faces);
        m->shared[m->indices[i]].sides = own;
        result = is_on_purpose(m, m->indices[i], &on_purpose);
        for (size_t f = 0; f < faces && !result && on_purpose; ++f)
            if (own[f] & CORE_SIDE_BY_RAYS) own[f] |= CORE_SIDE_UNDECIDED;
    }
    return result;
}

/* The faces whose sides matter: those that are named, those that are turned with a whole body, and
 * those at edges that two faces run along the same way. Rays are cast from the pieces of these
 * alone, as the rules do. */
static void mark_asked_faces(const fix_maker *m, uint8_t *asked) {
    (void)norma_check_count_conflicts(&m->judge->sides.topology, asked);
    (void)norma_fix_mark_group(m, RULE_N201, asked);
    (void)norma_fix_mark_group(m, RULE_N205, asked);
    size_t begin = 0;
    for (size_t i = 0; i < m->count; begin += m->meshes[i++].face_count) {
        const uint8_t *turned = m->shared[m->indices[i]].turned;
        for (size_t f = 0; turned && f < m->meshes[i].face_count; ++f)
            asked[begin + f] |= turned[f];
    }
}

/* Those of an STL by their stored normals, where nothing else decides. */
static norma_result ask_sides(const fix_maker *m, uint8_t *asked, uint8_t *sides) {
    norma_result result = open_fix_judge(m);
    if (result) return result;
    core_side_judge *judge = &m->judge->sides;
    norma_core_side_judge_forget(judge);
    mark_asked_faces(m, asked);
    result = norma_core_side_judge_ask(judge, 0, m->face_count, asked, sides);
    if (!result) result = norma_check_sides_at_folds(judge, 0, m->face_count, sides);
    return result || m->first_info.normals != NORMA_NORMALS_PER_FACET
               ? result
               : norma_check_sides_by_facets(judge, &m->first_data.normals, sides);
}

norma_document_result norma_fix_ask_sides(fix_maker *m) {
    uint8_t *asked = calloc(m->face_count + 1, 1), *sides = malloc(m->face_count + 1);
    norma_result asking = asked && sides ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!asking && m->face_count) asking = ask_sides(m, asked, sides);
    const norma_document_result result =
        asking ? norma_fix_fail(m->error, asking) : share_sides(m, sides);
    free(asked);
    free(sides);
    return result;
}

/* ---- parts of a surface: faces that edges join, by exactly equal positions */

/* For each face the least face of its part. NULL: out of memory. */
static uint32_t *find_parts(const core_mesh *mesh) {
    uint32_t *parents = malloc((mesh->face_count + 1) * sizeof *parents);
    fix_edge *edges = malloc((mesh->corner_count + 1) * sizeof *edges);
    if (!parents || !edges) {
        free(parents);
        free(edges);
        return NULL;
    }
    for (size_t face = 0; face < mesh->face_count; ++face) parents[face] = (uint32_t)face;
    size_t count = 0;
    for (size_t face = 0; face < mesh->face_count; ++face)
        count += norma_fix_face_edges(mesh, face, (uint32_t)face, 0, edges + count);
    qsort(edges, count, sizeof *edges, norma_fix_compare_edges);
    for (size_t i = 1; i < count; ++i)
        if (norma_fix_compare_edges(&edges[i - 1], &edges[i]) == 0)
            norma_core_join_sets(parents, edges[i - 1].face, edges[i].face);
    for (size_t face = 0; face < mesh->face_count; ++face)
        parents[face] = norma_core_set_of(parents, (uint32_t)face);
    free(edges);
    return parents;
}

/* ---- windings: which faces are reversed */

static void note_undecided(const fix_mesh *m, check_rule rule, size_t faces) {
    static const char why[] = "neither volume nor rays show which side is outward";
    char text[CHECK_MESSAGE];
    const norma_rule *rules = norma_rules(NULL);
    norma_check_message(text, "%s %s is not fixed%s%s for %z face%s: %s", rules[rule].id,
        rules[rule].name, *m->info.where ? " at " : "", m->info.where, faces,
        norma_check_plural(faces), why);
    norma_fix_note(m->plan, FIX_RULE(rule), text, why);
}

/* A part that is turned as a whole is not what N301 asks for, unless it names one of its faces:
 * then it is wound against another primitive. */
static void leave_whole_parts(const fix_mesh *m, const uint32_t *parts, uint8_t *reverse) {
    uint8_t *stays = calloc(m->mesh.face_count + 1, 1), *named = NULL;
    const int any = norma_fix_mark(m, RULE_N301, MEND_FACE, m->mesh.face_count, &named);
    for (size_t face = 0; stays && face < m->mesh.face_count; ++face)
        if (!reverse[face] || (any > 0 && named[face])) stays[parts[face]] = 1;
    for (size_t face = 0; stays && face < m->mesh.face_count; ++face)
        reverse[face] &= stays[parts[face]];
    free(named);
    free(stays);
}

/* Those that are shown to be turned: of parts that disagree with themselves (N301). */
static norma_result reverse_turned(const fix_mesh *m, uint8_t *reverse) {
    uint32_t *parts = find_parts(&m->mesh);
    size_t undecided = 0;
    if (!parts) return NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < m->mesh.face_count; ++face) {
        reverse[face] = (uint8_t)norma_check_is_turned(m->shared.sides[face]);
        undecided +=
            m->shared.sides[face] & CORE_SIDE_TURNED && m->shared.sides[face] & CORE_SIDE_UNDECIDED;
    }
    leave_whole_parts(m, parts, reverse);
    free(parts);
    if (undecided) note_undecided(m, RULE_N301, undecided);
    return NORMA_OK;
}

/* The parts of faces whose winding is shown to be wrong, and whose normals are right (N201): all
 * that is turned in them, so that they still agree. */
static norma_result reverse_opposed(const fix_mesh *m, uint8_t *reverse) {
    uint8_t *named = NULL;
    const size_t faces = m->mesh.face_count;
    const int any = norma_fix_mark(m, RULE_N201, MEND_FACE, faces, &named);
    uint32_t *parts = any > 0 ? find_parts(&m->mesh) : NULL;
    uint8_t *opposed = any > 0 ? calloc(faces + 1, 1) : NULL;
    const int fine = any == 0 || (parts && opposed);
    size_t undecided = 0;
    for (size_t face = 0; face < faces && any > 0 && fine; ++face) {
        if (!named[face]) continue;
        undecided += (m->shared.sides[face] & CORE_SIDE_UNDECIDED) != 0;
        if (norma_check_is_turned(m->shared.sides[face])) opposed[parts[face]] = 1;
    }
    for (size_t face = 0; face < faces && any > 0 && fine; ++face)
        if (opposed[parts[face]] && norma_check_is_turned(m->shared.sides[face])) reverse[face] = 1;
    if (undecided && fine) note_undecided(m, RULE_N201, undecided);
    free(named);
    free(parts);
    free(opposed);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* A body that is turned as a whole (N302, N304) is turned once, whatever else names its faces. */
norma_result norma_fix_windings(fix_mesh *m) {
    const int alike = norma_fix_has(m, RULE_N301), opposed = norma_fix_has(m, RULE_N201);
    int any = 0;
    if (!alike && !opposed && !m->shared.turned) return NORMA_OK;
    uint8_t *reverse = calloc(m->mesh.face_count + 1, 1);
    norma_result result = reverse ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result && alike && m->shared.sides) result = reverse_turned(m, reverse);
    if (!result && opposed && m->shared.sides) result = reverse_opposed(m, reverse);
    for (size_t face = 0; face < m->mesh.face_count && !result; ++face) {
        if (m->shared.turned && m->shared.turned[face])
            reverse[face] = !m->shared.sides || norma_check_is_turned(m->shared.sides[face]);
        any |= reverse[face];
    }
    if (any && !result)
        m->edit->reverse_faces = reverse;
    else
        free(reverse);
    return result;
}

/* ---- normals: after the windings have become what they will be, a normal that more of its faces
 * oppose than not is turned round, unless it is unknown which of both is wrong */

typedef struct side_count {
    uint32_t with, against;
    int candidate;
} side_count;

static void count_sides(const fix_mesh *m, const uint8_t *named, side_count *sides) {
    for (size_t face = 0; face < m->mesh.face_count; ++face) {
        const float *direction = m->face_normals + 3 * face;
        const int decided = m->shared.sides && !(m->shared.sides[face] & CORE_SIDE_UNDECIDED);
        int candidate = (named && named[face] && decided) ||
                        (m->edit->reverse_faces && m->edit->reverse_faces[face]);
        for (size_t c = norma_core_face_begin(&m->mesh, face);
             c < norma_core_face_end(&m->mesh, face); ++c) {
            double normal[3];
            size_t number = norma_fix_normal_of(m, face, c);
            if (number == SIZE_MAX) continue;
            norma_fix_normal(m, number, normal);
            double dot = norma_check_dot(direction, normal);
            sides[number].with += dot > 0;
            sides[number].against += dot < 0;
            sides[number].candidate |= candidate;
        }
    }
}

norma_result norma_fix_turn_normals(fix_mesh *m) {
    uint8_t *named = NULL;
    int any = norma_fix_mark(m, RULE_N201, MEND_FACE, m->mesh.face_count, &named);
    size_t count = norma_fix_normal_count(m);
    norma_result result = any < 0 ? NORMA_ERROR_MEMORY : NORMA_OK;
    if (!result && count && (any || m->edit->reverse_faces)) {
        side_count *sides = calloc(count + 1, sizeof *sides);
        result = sides ? norma_fix_face_normals(m) : NORMA_ERROR_MEMORY;
        if (!result) count_sides(m, named, sides);
        for (size_t i = 0; i < count && !result; ++i) {
            double normal[3];
            if (!sides[i].candidate || sides[i].against <= sides[i].with) continue;
            norma_fix_normal(m, i, normal);
            for (int axis = 0; axis < 3; ++axis) normal[axis] = -normal[axis];
            result = norma_fix_set_normal(m, i, normal) ? NORMA_OK : NORMA_ERROR_MEMORY;
        }
        free(sides);
    }
    free(named);
    return result;
}
