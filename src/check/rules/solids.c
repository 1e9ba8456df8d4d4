/* solids.c: N302 and N304: bodies that look inward, and those of which it cannot be said. */
#include "check/rules/rules.h"
#include <stdlib.h>
#include <string.h>

/* ---- N302 and N304: components that look inward, solids in solids, and components of
 * which neither can be said. */

typedef struct check_solids {
    check_mesh *m; /* who is told: rules, place, positions */
    const core_topology *topology;
    const core_components *components;
    size_t begin, end; /* of the components' faces those that are the mesh's; one that begins there
                          is told of there */
} check_solids;

static const uint8_t NOT_CLOSED = COMPONENT_OPEN | COMPONENT_CONFLICT | COMPONENT_UNBALANCED;

/* Whether a component is told of here: its first face is. */
static int is_here(const check_solids *s, size_t number) {
    const size_t face = s->components->faces[s->components->starts[number]];
    return face >= s->begin && face < s->end;
}

static check_spot spot_of(const check_solids *s, size_t number) {
    return norma_check_face(s->components->faces[s->components->starts[number]] - s->begin);
}

/* A face of it at an edge of one face, if it has one here: where it is open. */
static check_spot open_spot_of(const check_solids *s, size_t number) {
    const core_components *c = s->components;
    const core_mesh *mesh = &s->topology->mesh;
    for (size_t i = c->starts[number]; i < c->starts[number + 1]; ++i)
        for (size_t corner = norma_core_face_begin(mesh, c->faces[i]);
             corner < norma_core_face_end(mesh, c->faces[i]); ++corner)
            if (s->topology->partners[corner] == CORE_EDGE_OPEN && c->faces[i] >= s->begin &&
                c->faces[i] < s->end)
                return norma_check_face(c->faces[i] - s->begin);
    return spot_of(s, number);
}

static size_t count_here(const check_solids *s) {
    size_t count = 0;
    for (size_t i = 0; i < s->components->count; ++i) count += (size_t)is_here(s, i);
    return count;
}

/* ---- N302 */

static norma_result add_inward(check_mesh *m, check_hits *hits, size_t count) {
    const norma_severity severity = m->run->profile == NORMA_CHECK_PROFILE_PRINT
                                        ? NORMA_SEVERITY_ERROR
                                    : m->given->material.double_sided ? NORMA_SEVERITY_INFO
                                                                      : NORMA_SEVERITY_WARNING;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N302, .severity = severity, .unit = "volume", .hits = hits},
        "faces look inward at %z of %z component%s: closed, and inside out", hits->count, count,
        norma_check_plural(count));
}

/* reaching: how many of them lie partly outside. */
static norma_result add_nested(check_mesh *m, check_hits *hits, size_t reaching) {
    check_finding finding = {.rule = RULE_N302,
        .severity = m->run->profile == NORMA_CHECK_PROFILE_PRINT ? NORMA_SEVERITY_WARNING
                                                                 : NORMA_SEVERITY_INFO,
        .unit = "volume",
        .no_fix = 1,
        .hits = hits};
    const char *plural = norma_check_plural(hits->count);
    if (!reaching)
        return norma_check_report(m, &finding,
            "a solid within a solid: %z component%s facing outward; either cavities that were "
            "turned, or separate bodies",
            hits->count, plural);
    if (reaching < hits->count)
        return norma_check_report(m, &finding,
            "solids within a solid: %z component%s facing outward, of which %z only overlap%s it",
            hits->count, plural, reaching, reaching == 1 ? "s" : "");
    return norma_check_report(m, &finding, "solids overlap: %z component%s partly in another",
        reaching, reaching == 1 ? " lies" : "s lie");
}

/* Where a surface crosses itself, edges of more than two faces cut tetrahedra out of it, which are
 * no bodies. */
static int is_cut_out(const core_components *c, size_t number) {
    return c->each[number].flags & COMPONENT_MANY && c->starts[number + 1] - c->starts[number] <= 4;
}

/* Those of its faces that no sample stands for yet. */
static void add_faces(const check_solids *s, size_t number, check_hits *hits) {
    const core_components *c = s->components;
    for (size_t i = c->starts[number] + 1; i < c->starts[number + 1]; ++i)
        if (c->faces[i] >= s->begin && c->faces[i] < s->end)
            norma_check_also(s->m->run, hits, norma_check_face(c->faces[i] - s->begin));
}

static norma_result tell_inward(const check_solids *s) {
    check_mesh *m = s->m;
    const core_components *c = s->components;
    check_hits inward = {.least = 1}, nested = {0};
    norma_result result = NORMA_OK;
    size_t reaching = 0;
    for (int faces = 0; faces <= (m->run->options.whole_components != 0); ++faces)
        for (size_t i = 0; i < c->count; ++i) {
            const core_component *component = &c->each[i];
            check_hits *hits = component->verdict == COMPONENT_INWARD   ? &inward
                               : component->verdict == COMPONENT_NESTED ? &nested
                                                                        : NULL;
            if (!hits || is_cut_out(c, i) || !is_here(s, i)) continue;
            if (faces) {
                add_faces(s, i, hits);
                continue;
            }
            norma_check_hit(m->run, hits, component->volume / 6, spot_of(s, i));
            reaching += (component->flags & COMPONENT_REACHES) != 0;
        }
    if (inward.count) result = add_inward(m, &inward, count_here(s));
    if (!result && nested.count) result = add_nested(m, &nested, reaching);
    norma_check_hits_free(&inward);
    norma_check_hits_free(&nested);
    return result;
}

/* ---- N304: open, or of one side whichever faces are reversed */

/* Whether a component that has conflicts is of one side: its faces are wound alike as far as that
 * goes, and some part then still disagrees with itself. */
static norma_result find_one_sided(const core_topology *topology, core_components *c) {
    core_components parts;
    size_t conflicts = 0;
    for (size_t i = 0; i < c->count; ++i)
        conflicts +=
            (c->each[i].flags & COMPONENT_CONFLICT) != 0 && !(c->each[i].flags & COMPONENT_OPEN);
    if (!conflicts) return NORMA_OK;
    norma_result result = norma_core_find_components(topology, CORE_JOIN_CUT, &parts);
    if (result) return result;
    for (size_t i = 0; i < parts.count; ++i)
        if (parts.each[i].flags & COMPONENT_ONE_SIDED)
            c->each[c->of[parts.faces[parts.starts[i]]]].flags |= COMPONENT_ONE_SIDED;
    norma_core_release_components(topology->call, &parts);
    return NORMA_OK;
}

static norma_result tell_undecidable(const check_solids *s) {
    check_mesh *m = s->m;
    const core_components *c = s->components;
    check_hits hits = {0};
    size_t one_sided = 0;
    for (size_t i = 0; i < c->count; ++i) {
        uint8_t flags = c->each[i].flags;
        if (!(flags & (COMPONENT_OPEN | COMPONENT_ONE_SIDED | COMPONENT_UNBALANCED)) ||
            !is_here(s, i))
            continue;
        one_sided += (flags & COMPONENT_ONE_SIDED) != 0;
        norma_check_hit(
            m->run, &hits, (double)(c->starts[i + 1] - c->starts[i]), open_spot_of(s, i));
    }
    if (hits.count) {
        return norma_check_report(m,
            &(check_finding){
                .rule = RULE_N304, .severity = NORMA_SEVERITY_INFO, .unit = "faces", .hits = &hits},
            one_sided ? "no inside and outside: %z of %z component%s %s open or one-sided (%z)"
                      : "no inside and outside: %z of %z component%s %s open",
            hits.count, count_here(s), norma_check_plural(count_here(s)),
            hits.count == 1 ? "is" : "are", one_sided);
    }
    norma_check_hits_free(&hits);
    return NORMA_OK;
}

/* ---- both */

static int any_is_closed(const core_components *c) {
    size_t i = 0;
    while (i < c->count && c->each[i].flags & NOT_CLOSED) ++i;
    return i < c->count;
}

static norma_result check_judge_solids(
    const core_topology *topology, core_components *c, int nesting, int sides) {
    nesting = nesting && any_is_closed(c);
    norma_result result =
        nesting ? norma_core_measure_components(topology, c, NOT_CLOSED) : NORMA_OK;
    if (!result && nesting) result = norma_core_judge_nesting(topology, c, NOT_CLOSED);
    return !result && sides ? find_one_sided(topology, c) : result;
}

/* What a component is, from outside in (N302), and whether it is of one side (N304). */
static norma_result check_tell_solids(const check_solids *s) {
    norma_result result = norma_check_wants(s->m, RULE_N302) ? tell_inward(s) : NORMA_OK;
    return !result && norma_check_wants(s->m, RULE_N304) ? tell_undecidable(s) : result;
}

/* ---- N301, N302, N304 and N307 over the primitives of one glTF mesh together: a body
 * of several materials is closed although each of its parts is open, and a cavity of one material
 * lies in a shell of another. A component that is closed within its own primitive is a body by
 * itself, even if others touch it; open parts are joined at equal positions. A component is
 * reported at the primitive of its first face. */

static uint8_t *mark_loose(const check_mesh *m, const core_components *c) {
    uint8_t *loose = calloc(m->mesh.face_count + 1, 1);
    for (size_t f = 0; loose && f < m->mesh.face_count; ++f)
        loose[f] = c->of[f] == UINT32_MAX || c->each[c->of[f]].flags != 0;
    return loose;
}

/* Of a mesh that has siblings, until the last one has come. */
static norma_result check_solids_hold(check_mesh *m, const core_components *components) {
    check_group *group = m->run->group;
    group->solids[group->solid_count++] = m;
    m->loose = mark_loose(m, components);
    m->welded = malloc((m->mesh.corner_count + 1) * sizeof *m->welded);
    if (!m->welded || !m->loose) return NORMA_ERROR_MEMORY;
    memcpy(m->welded, m->topology.corners, m->mesh.corner_count * sizeof *m->welded);
    return NORMA_OK;
}

/* ---- the whole */

/* Its corners become those of the members, whose equal positions are one. sources: room for the
 * corners of loose faces. Returns how many these are. */
static size_t list_loose(const check_group *group, check_joined *whole, uint32_t *sources) {
    size_t vertex = 0, corner = 0, loose = 0;
    for (size_t i = 0; i < group->solid_count; ++i) {
        const check_mesh *member = group->solids[i];
        for (size_t c = 0; c < member->mesh.corner_count; ++c) {
            whole->corners[corner + c] = (uint32_t)vertex + member->welded[c];
            if (member->loose[c / 3]) sources[loose++] = (uint32_t)(corner + c);
        }
        vertex += member->mesh.positions.count;
        corner += member->mesh.corner_count;
    }
    return loose;
}

static norma_result weld_loose(
    core_call *call, check_joined *whole, const uint32_t *sources, uint32_t *loose, size_t count) {
    core_mesh mesh;
    core_topology topology;
    norma_mesh all = whole->mesh;
    for (size_t i = 0; i < count; ++i) loose[i] = whole->corners[sources[i]];
    all.corners = loose;
    all.corner_count = count;
    all.face_count = 0;
    norma_result result = norma_core_mesh_shape(&all, &mesh);
    mesh.scale = 1;
    if (!result) result = norma_core_topology_open(call, &mesh, &topology);
    if (result) return result;
    for (size_t i = 0; i < count; ++i) whole->corners[sources[i]] = topology.corners[i];
    norma_core_topology_close(&topology);
    return NORMA_OK;
}

/* Loose corners at equal positions, whichever primitive they are of, become one. */
static norma_result join_loose(check_run *run, check_joined *whole) {
    const size_t corners = whole->mesh.corner_count;
    uint32_t *loose = norma_core_allocate(&run->call, corners, sizeof *loose),
             *sources = norma_core_allocate(&run->call, corners, sizeof *sources);
    norma_result result = loose && sources ? NORMA_OK : NORMA_ERROR_MEMORY;
    const size_t count = result ? 0 : list_loose(run->group, whole, sources);
    if (count) result = weld_loose(&run->call, whole, sources, loose, count);
    norma_core_release(&run->call, sources, corners, sizeof *sources);
    norma_core_release(&run->call, loose, corners, sizeof *loose);
    return result;
}

/* ---- judging */

static norma_result tell_members(
    check_run *run, const core_topology *topology, const core_components *components) {
    norma_result result = NORMA_OK;
    size_t face = 0;
    for (size_t i = 0; i < run->group->solid_count && !result; ++i) {
        check_mesh *m = run->group->solids[i];
        result = check_tell_solids(
            &(check_solids){m, topology, components, face, face + m->mesh.face_count});
        if (!result && norma_check_wants_open(run, m->rules))
            result = norma_check_add_open(m, topology, 3 * face);
        face += m->mesh.face_count;
    }
    return result;
}

/* ---- N301 */

static norma_result tell_conflicts(
    const check_group *group, const core_topology *topology, const uint8_t *edges, uint8_t *sides) {
    norma_result result = NORMA_OK;
    size_t face = 0;
    for (size_t i = 0; i < group->solid_count && !result;
         face += group->solids[i++]->mesh.face_count)
        result = norma_check_sides(group->solids[i], edges + face, sides + face);
    face = 0;
    for (size_t i = 0; i < group->solid_count && !result;
         face += group->solids[i++]->mesh.face_count)
        if (norma_check_wants(group->solids[i], RULE_N301))
            result =
                norma_check_conflicts_joined(group->solids[i], topology, 3 * face, edges, sides);
    return result;
}

static norma_result judge_conflicts(check_run *run, const core_topology *topology) {
    const size_t faces = topology->mesh.face_count;
    if (!run->rules[RULE_N301]) return NORMA_OK;
    uint8_t *edges = norma_core_allocate(&run->call, faces, 1),
            *sides = norma_core_allocate(&run->call, faces, 1);
    norma_result result = edges && sides ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        memset(edges, 0, faces);
        if (norma_check_count_conflicts(topology, edges))
            result = tell_conflicts(run->group, topology, edges, sides);
    }
    norma_core_release(&run->call, sides, faces, 1);
    norma_core_release(&run->call, edges, faces, 1);
    return result;
}

/* The positions that are to be one are one already. */
static norma_result judge_joined_solids(check_run *run, const norma_mesh *whole) {
    core_call call = run->call;
    core_mesh mesh;
    core_topology topology;
    core_components components;
    const core_topology_visitor nobody = {NULL, NULL, NULL, NULL};
    norma_result result = norma_core_mesh_shape(whole, &mesh);
    mesh.scale = 1;
    call.options.weld = NORMA_WELD_NONE;
    if (!result) result = norma_core_topology_open(&call, &mesh, &topology);
    if (result) return result;
    result = norma_core_pair_edges(&topology, &nobody);
    if (!result) result = judge_conflicts(run, &topology);
    if (!result) result = norma_core_find_components(&topology, CORE_JOIN_BODIES, &components);
    if (!result) {
        result = check_judge_solids(
            &topology, &components, run->rules[RULE_N302], run->rules[RULE_N304]);
        if (!result) result = tell_members(run, &topology, &components);
        norma_core_release_components(&call, &components);
    }
    norma_core_topology_close(&topology);
    return result;
}

norma_result norma_check_solids_joined(check_run *run) {
    check_joined whole;
    if (!run->group->solid_count) return NORMA_OK;
    norma_result result =
        norma_check_join_held(run->group->solids, run->group->solid_count, &whole);
    if (result) return result;
    result = join_loose(run, &whole);
    if (!result) result = judge_joined_solids(run, &whole.mesh);
    norma_check_unjoin(&whole);
    return result;
}

/* ---- N302 and N304 over one mesh by itself, or held until the other primitives of its glTF
 * mesh have come. */

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
        result = check_solids_hold(m, &components);
    } else {
        result = check_judge_solids(&m->topology, &components, nesting, sides);
        if (!result)
            result = check_tell_solids(
                &(check_solids){m, &m->topology, &components, 0, m->mesh.face_count});
    }
    norma_core_release_components(&m->run->call, &components);
    return result;
}
