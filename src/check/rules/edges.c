/* edges.c: N301, N303, N305 and N306: faces wound against each other, edges of more than two faces,
 * faces that are there twice. */
#include "check/rules/mesh_rules.h"
#include "core/face/twin_key.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct conflict { /* two faces that run along an edge in the same direction, from these
                             corners */
    uint32_t first, second;
} conflict;

typedef struct edge_part {
    check_hits many, bow_ties, duplicates, twins;
    size_t many_edges;
    conflict *conflicts;
    size_t conflict_count, conflict_room;
    int failed;
} edge_part;

typedef struct edge_pass {
    check_mesh *m;
    edge_part *parts;
} edge_pass;

/* ---- what is seen while edges are paired */

static void keep_conflict(edge_part *part, uint32_t first, uint32_t second) {
    if (part->conflict_count == part->conflict_room) {
        size_t room = part->conflict_room ? 2 * part->conflict_room : 64;
        conflict *conflicts = realloc(part->conflicts, room * sizeof *conflicts);
        if (!conflicts) {
            part->failed = 1;
            return;
        }
        part->conflicts = conflicts;
        part->conflict_room = room;
    }
    part->conflicts[part->conflict_count++] =
        (conflict){first < second ? first : second, first < second ? second : first};
}

/* Back-to-back faces explain an edge where no more than two faces are left without them. */
static int twins_explain(const core_topology *t, const core_edge_run *runs, size_t count) {
    size_t paired = 0;
    for (size_t i = 0; i < count; i++) {
        size_t alike = 0, against = 0, before = 0;
        for (size_t k = 0; k < count; k++) {
            const size_t same = runs[k].out == runs[i].out && runs[k].key == runs[i].key;
            alike += same;
            before += k < i && same;
            against += runs[k].out != runs[i].out &&
                       runs[k].key == norma_core_key_of_twin(runs[i].key) &&
                       norma_core_topology_face(t, runs[k].corner) !=
                           norma_core_topology_face(t, runs[i].corner);
        }
        paired += before < against && before < alike;
    }
    return count - paired <= 2;
}

enum { MOST_RUNS = 256 }; /* an edge of more faces is not looked at for twins */

static void see_edge(
    void *context, size_t block, uint32_t position, const core_edge_run *runs, size_t count) {
    const edge_pass *pass = context;
    edge_part *part = &pass->parts[block];
    const check_mesh *m = pass->m;
    if (count == 2) keep_conflict(part, runs[0].corner, runs[1].corner);
    if (count <= 2 || !norma_check_wants(m, RULE_N303) ||
        (count <= MOST_RUNS && twins_explain(&m->topology, runs, count)))
        return;
    part->many_edges++;
    norma_check_hit(m->run, &part->many, (double)count,
        (check_spot){position, norma_core_topology_face(&m->topology, runs[0].corner), SIZE_MAX});
}

static void see_bow_tie(void *context, size_t block, uint32_t position, size_t fans) {
    const edge_pass *pass = context;
    norma_check_hit(
        pass->m->run, &pass->parts[block].bow_ties, (double)fans, norma_check_vertex(position));
}

static void see_twins(void *context, size_t block, const core_twin *twins, size_t count) {
    const edge_pass *pass = context;
    edge_part *part = &pass->parts[block];
    size_t ways[2] = {0, 0};
    for (size_t i = 0; i < count; i++)
        if (ways[twins[i].way]++)
            norma_check_hit(
                pass->m->run, &part->duplicates, (double)count, norma_check_face(twins[i].face));
    size_t pairs = ways[0] < ways[1] ? ways[0] : ways[1], told = 0;
    for (size_t i = 0; i < count && told < pairs; i++)
        if (twins[i].way != twins[0].way) {
            norma_check_hit(
                pass->m->run, &part->twins, (double)count, norma_check_face(twins[i].face));
            told++;
        }
}

/* ---- N301 */

typedef struct conflict_count {
    const check_mesh *m;
    uint8_t *edges; /* of each face, at most 255 */
} conflict_count;

static void count_conflicts(const check_mesh *m, const edge_part *part, uint8_t *edges) {
    for (size_t i = 0; i < part->conflict_count; i++) {
        size_t faces[2] = {norma_core_topology_face(&m->topology, part->conflicts[i].first),
            norma_core_topology_face(&m->topology, part->conflicts[i].second)};
        for (int k = 0; k < 2; k++)
            edges[faces[k]] = (uint8_t)(edges[faces[k]] + (edges[faces[k]] < 255));
    }
}

/* Whether the two faces have a vertex of the edge in common, rather than only its positions. */
static int share_vertex(const check_mesh *m, const conflict *c) {
    const core_topology *t = &m->topology;
    size_t first_end = norma_core_topology_next(t, norma_core_topology_face(t, c->first), c->first);
    size_t second_end =
        norma_core_topology_next(t, norma_core_topology_face(t, c->second), c->second);
    return norma_core_corner(&m->mesh, c->first) == norma_core_corner(&m->mesh, c->second) ||
           norma_core_corner(&m->mesh, first_end) == norma_core_corner(&m->mesh, second_end);
}

/* Of the two faces the one with more such edges is the likelier to be wound wrongly: a single face
 * turned over has one at each side. */
static check_spot conflict_spot(const check_mesh *m, const conflict *c, const uint8_t *edges) {
    size_t first = norma_core_topology_face(&m->topology, c->first),
           second = norma_core_topology_face(&m->topology, c->second);
    uint32_t corner = edges[second] > edges[first] ? c->second : c->first;
    return (check_spot){norma_core_corner(&m->mesh, corner),
        norma_core_topology_face(&m->topology, corner), SIZE_MAX};
}

static norma_result add_conflicts_of(check_mesh *m, norma_severity severity, check_hits *hits) {
    char message[CHECK_MESSAGE];
    if (severity == NORMA_SEVERITY_WARNING)
        norma_check_message(message,
            "%z edge%s between faces wound against each other; the faces share positions but no "
            "vertices, as touching parts do",
            hits->count, norma_check_plural(hits->count));
    else
        norma_check_message(message,
            "%z edge%s between faces wound against each other; one of the two faces is seen from "
            "behind",
            hits->count, norma_check_plural(hits->count));
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N301,
            .severity = severity,
            .no_value = 1,
            .hits = hits,
            .message = message});
}

static norma_result add_conflicts(check_mesh *m, const edge_part *parts, size_t blocks) {
    check_hits joined = {0}, touching = {0};
    size_t faces = m->mesh.face_count;
    int render = m->run->profile == NORMA_CHECK_PROFILE_RENDER;
    uint8_t *edges = norma_core_allocate(&m->run->call, faces, 1);
    if (!edges) return NORMA_ERROR_MEMORY;
    memset(edges, 0, faces);
    for (size_t i = 0; i < blocks; i++) count_conflicts(m, &parts[i], edges);
    for (size_t i = 0; i < blocks; i++)
        for (size_t k = 0; k < parts[i].conflict_count; k++) {
            const conflict *c = &parts[i].conflicts[k];
            int touch = render && !m->on_purpose && !share_vertex(m, c);
            norma_check_hit(m->run, touch ? &touching : &joined, 0, conflict_spot(m, c, edges));
        }
    norma_core_release(&m->run->call, edges, faces, 1);
    norma_result result =
        joined.count
            ? add_conflicts_of(
                  m, render && m->on_purpose ? NORMA_SEVERITY_INFO : NORMA_SEVERITY_ERROR, &joined)
            : NORMA_OK;
    if (!result && touching.count) result = add_conflicts_of(m, NORMA_SEVERITY_WARNING, &touching);
    norma_check_hits_free(&joined);
    norma_check_hits_free(&touching);
    return result;
}

/* ---- N303, N305, N306 */

static norma_result add_many(check_mesh *m, edge_part *sum) {
    char message[CHECK_MESSAGE];
    size_t edges = sum->many.count, ties = sum->bow_ties.count;
    norma_check_hits_merge(m->run, &sum->many, &sum->bow_ties);
    if (edges && ties)
        norma_check_message(message,
            "%z edge%s of more than two faces, and %z %s where parts touch only in a point", edges,
            norma_check_plural(edges), ties, ties == 1 ? "vertex" : "vertices");
    else if (edges)
        norma_check_message(message,
            "%z edge%s of more than two faces; inside and outside are not defined there", edges,
            norma_check_plural(edges));
    else
        norma_check_message(message, "%z %s where parts touch only in a point", ties,
            ties == 1 ? "vertex" : "vertices");
    norma_severity severity =
        m->run->profile == NORMA_CHECK_PROFILE_PRINT ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO;
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N303,
            .severity = severity,
            .unit = edges ? "faces" : "fans",
            .hits = &sum->many,
            .message = message});
}

static norma_result add_duplicates(check_mesh *m, check_hits *hits) {
    char message[CHECK_MESSAGE];
    norma_check_message(message, "%z face%s repeated with the same winding; drawn more than once",
        hits->count, norma_check_plural(hits->count));
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N305,
            .severity = NORMA_SEVERITY_WARNING,
            .no_value = 1,
            .hits = hits,
            .message = message});
}

static norma_result add_twins(check_mesh *m, check_hits *hits) {
    char message[CHECK_MESSAGE];
    int print = m->run->profile == NORMA_CHECK_PROFILE_PRINT;
    norma_check_message(message,
        print ? "%z pair%s of back-to-back faces: walls without thickness"
              : "%z pair%s of back-to-back faces: a sheet modelled with two sides",
        hits->count, norma_check_plural(hits->count));
    return norma_check_add(m->run, &m->place, m,
        &(check_report){.rule = RULE_N306,
            .severity = print ? NORMA_SEVERITY_ERROR : NORMA_SEVERITY_INFO,
            .no_value = 1,
            .hits = hits,
            .message = message});
}

static norma_result add_findings(check_mesh *m, edge_part *parts, size_t blocks) {
    edge_part sum = {.failed = 0};
    size_t conflicts = 0;
    for (size_t i = 0; i < blocks; i++) {
        norma_check_hits_merge(m->run, &sum.many, &parts[i].many);
        norma_check_hits_merge(m->run, &sum.bow_ties, &parts[i].bow_ties);
        norma_check_hits_merge(m->run, &sum.duplicates, &parts[i].duplicates);
        norma_check_hits_merge(m->run, &sum.twins, &parts[i].twins);
        sum.failed |= parts[i].failed;
        conflicts += parts[i].conflict_count;
    }
    norma_result result = sum.failed ? NORMA_ERROR_MEMORY : NORMA_OK;
    if (!result && conflicts && norma_check_wants(m, RULE_N301))
        result = add_conflicts(m, parts, blocks);
    if (!result && sum.many.count + sum.bow_ties.count && norma_check_wants(m, RULE_N303))
        result = add_many(m, &sum);
    if (!result && sum.duplicates.count && norma_check_wants(m, RULE_N305))
        result = add_duplicates(m, &sum.duplicates);
    if (!result && sum.twins.count && norma_check_wants(m, RULE_N306))
        result = add_twins(m, &sum.twins);
    norma_check_hits_free(&sum.many);
    norma_check_hits_free(&sum.bow_ties);
    norma_check_hits_free(&sum.duplicates);
    norma_check_hits_free(&sum.twins);
    return result;
}

/* ---- all */

static void free_parts(const check_mesh *m, edge_part *parts, size_t blocks) {
    for (size_t i = 0; parts && i < blocks; i++) {
        free(parts[i].conflicts);
        norma_check_hits_free(&parts[i].many);
        norma_check_hits_free(&parts[i].bow_ties);
        norma_check_hits_free(&parts[i].duplicates);
        norma_check_hits_free(&parts[i].twins);
    }
    norma_core_release(&m->run->call, parts, blocks, sizeof *parts);
}

norma_result norma_check_pairs(check_mesh *m) {
    norma_result result = norma_check_weld(m);
    if (result || m->topology.partners || !m->mesh.face_count) return result;
    size_t blocks = norma_core_topology_blocks(&m->topology);
    edge_pass pass = {m, norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    const core_topology_visitor visitor = {&pass, see_edge,
        norma_check_wants(m, RULE_N303) ? see_bow_tie : NULL,
        norma_check_wants_any(m, RULE_N305, RULE_N306) ? see_twins : NULL};
    if (!pass.parts) return NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_core_pair_edges(&m->topology, &visitor);
    if (!result) result = add_findings(m, pass.parts, blocks);
    free_parts(m, pass.parts, blocks);
    return result;
}

norma_result norma_check_edges(check_mesh *m) {
    return norma_check_wants_any(m, RULE_N301, RULE_N306) ? norma_check_pairs(m) : NORMA_OK;
}
