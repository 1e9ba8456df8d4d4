/* N301, N303, N305, N306 and N307: what is found where faces meet. */
#include "check/rules/rules.h"
#include "core/face/face.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Which pairs make up a closed solid, that stands there a second time turned inside out: of
 * those that edges hold together, the faces of one side have no border. */

typedef struct pair_edge {
    uint32_t low, high; /* positions */
    uint32_t pair;
} pair_edge;

static int edge_is_less(const void *first, const void *second) {
    const pair_edge *a = first, *b = second;
    if (a->low != b->low) return a->low < b->low;
    return a->high != b->high ? a->high < b->high : a->pair < b->pair;
}

static size_t count_pair_corners(const core_mesh *mesh, const uint32_t *faces, size_t count) {
    size_t corners = 0;
    for (size_t i = 0; i < count; ++i)
        corners += norma_core_face_end(mesh, faces[i]) - norma_core_face_begin(mesh, faces[i]);
    return corners;
}

static size_t list_edges(
    const core_topology *t, const uint32_t *faces, size_t count, pair_edge *edges) {
    size_t at = 0;
    for (size_t i = 0; i < count; ++i)
        for (size_t c = norma_core_face_begin(&t->mesh, faces[i]);
             c < norma_core_face_end(&t->mesh, faces[i]); ++c) {
            if (t->partners[c] == CORE_EDGE_NONE) continue;
            const uint32_t a = t->corners[c],
                           b = t->corners[norma_core_topology_next(t, faces[i], c)];
            edges[at++] = (pair_edge){a < b ? a : b, a < b ? b : a, (uint32_t)i};
        }
    norma_core_sort(edges, at, sizeof *edges, edge_is_less);
    return at;
}

/* sets: joined, the least of each first. open: of each pair. */
static void mark_open_sides(
    const pair_edge *edges, size_t count, uint32_t *sets, uint8_t *open, size_t pairs) {
    for (uint32_t i = 0; i < pairs; ++i) sets[i] = i;
    memset(open, 0, pairs);
    for (size_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && edges[end].low == edges[begin].low &&
                              edges[end].high == edges[begin].high;
             ++end)
            norma_core_join_sets(sets, edges[begin].pair, edges[end].pair);
        if ((end - begin) % 2) open[edges[begin].pair] = 1;
    }
    for (uint32_t i = 0; i < pairs; ++i)
        if (open[i]) open[norma_core_set_of(sets, i)] = 1;
    for (uint32_t i = 0; i < pairs; ++i) open[i] = open[norma_core_set_of(sets, i)];
}

static norma_result find_sheets(
    const check_mesh *m, const uint32_t *faces, size_t count, uint8_t *open) {
    const core_call *call = &m->run->call;
    const size_t corners = count_pair_corners(&m->topology.mesh, faces, count);
    pair_edge *edges = norma_core_allocate(call, corners, sizeof *edges);
    uint32_t *sets = norma_core_allocate(call, count, sizeof *sets);
    const norma_result result = edges && sets ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result)
        mark_open_sides(edges, list_edges(&m->topology, faces, count, edges), sets, open, count);
    norma_core_release(call, sets, count, sizeof *sets);
    norma_core_release(call, edges, corners, sizeof *edges);
    return result;
}

/* ---- the findings */

static norma_result add_solids(check_mesh *m, norma_severity severity, check_hits *hits) {
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N306, .severity = severity, .no_value = 1, .hits = hits},
        "a second copy of the solid, turned inside out: %z pair%s of back-to-back faces",
        hits->count, norma_check_plural(hits->count));
}

static norma_result add_sheets(
    check_mesh *m, norma_severity severity, check_hits *hits, size_t of_solids) {
    const int print = m->run->profile == NORMA_CHECK_PROFILE_PRINT;
    char solids[CHECK_MESSAGE] = "";
    if (of_solids)
        norma_check_message(
            solids, "; %z of them make up a second copy of a solid, turned inside out", of_solids);
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N306, .severity = severity, .no_value = 1, .hits = hits},
        "%s: %z pair%s of back-to-back faces%s",
        print                             ? "walls without thickness"
        : m->given->material.double_sided ? "drawn twice, and flickering if their shading differs, "
                                            "as the material shows both sides"
                                          : "a sheet modelled with two sides",
        hits->count, norma_check_plural(hits->count), solids);
}

/* One finding for each severity. */
static norma_result add_back_to_back(check_mesh *m, check_hits *sheets, check_hits *solids) {
    const int print = m->run->profile == NORMA_CHECK_PROFILE_PRINT;
    const norma_severity of_sheets = print ? sheets->count + solids->count == 1
                                                 ? NORMA_SEVERITY_WARNING
                                                 : NORMA_SEVERITY_ERROR
                                     : m->given->material.double_sided ? NORMA_SEVERITY_WARNING
                                                                       : NORMA_SEVERITY_INFO,
                         of_solids = print ? of_sheets : NORMA_SEVERITY_WARNING;
    const size_t together = sheets->count && of_solids == of_sheets ? solids->count : 0;
    if (together) norma_check_hits_merge(m->run, sheets, solids);
    const norma_result result = add_sheets(m, of_sheets, sheets, together);
    return result ? result : add_solids(m, of_solids, solids);
}

/* N306, of faces that have a twin wound the other way, one of each pair; edges are paired. */
static norma_result add_paired_faces(check_mesh *m, const uint32_t *faces, size_t count) {
    check_hits sheets = {0}, solids = {0};
    uint8_t *open = norma_core_allocate(&m->run->call, count, 1);
    norma_result result = open ? find_sheets(m, faces, count, open) : NORMA_ERROR_MEMORY;
    for (size_t i = 0; !result && i < count; ++i)
        norma_check_hit(m->run, open[i] ? &sheets : &solids, 0, norma_check_face((size_t)faces[i]));
    if (!result) result = add_back_to_back(m, &sheets, &solids);
    norma_check_hits_free(&sheets);
    norma_check_hits_free(&solids);
    norma_core_release(&m->run->call, open, count, 1);
    return result;
}

/* ---- N307: edges of one face only, over one mesh by itself, or over the primitives of a
 * glTF mesh together (solids.c). For a print they are what is left to close. */

norma_result norma_check_add_open(check_mesh *m, const core_topology *topology, size_t first) {
    check_hits hits = {0};
    for (size_t f = 0; f < m->mesh.face_count; ++f)
        for (size_t c = norma_core_face_begin(&m->mesh, f); c < norma_core_face_end(&m->mesh, f);
             ++c)
            if (topology->partners[first + c] == CORE_EDGE_OPEN)
                norma_check_hit(
                    m->run, &hits, 0, (check_spot){norma_core_corner(&m->mesh, c), f, SIZE_MAX});
    return norma_check_report(m,
        &(check_finding){
            .rule = RULE_N307, .severity = NORMA_SEVERITY_WARNING, .no_value = 1, .hits = &hits},
        "holes, or sheets without thickness: %z edge%s of one face only; nothing separates inside "
        "from outside there",
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

/* ---- N301, N303, N305 and N306: faces wound against each other, edges of more than two faces,
 * faces that are there twice. */

typedef struct conflict { /* two faces that run along an edge in the same direction, from these
                             corners */
    uint32_t first, second;
} conflict;

typedef struct conflict_list {
    conflict *each;
    size_t count, room;
    int failed;
} conflict_list;

enum { MANY_FACES, BOW_TIES, DUPLICATES }; /* hits; the area is that of the duplicates */

typedef struct edge_part {
    check_sum sum;
    conflict_list conflicts, pairs; /* pairs: of faces back to back */
} edge_part;

typedef struct edge_pass {
    check_mesh *m;
    edge_part *parts;
} edge_pass;

/* ---- what is seen while edges are paired */

static void keep_conflict(conflict_list *list, uint32_t first, uint32_t second) {
    conflict *each = norma_check_grow(list->each, list->count, &list->room, sizeof *each);
    if (!each) {
        list->failed = 1;
        return;
    }
    list->each = each;
    list->each[list->count++] =
        (conflict){first < second ? first : second, first < second ? second : first};
}

/* Back-to-back faces explain an edge where no more than two faces are left without them. */
static int twins_explain(const core_topology *t, const core_edge_run *runs, size_t count) {
    size_t paired = 0;
    for (size_t i = 0; i < count; ++i) {
        size_t alike = 0, against = 0, before = 0;
        for (size_t k = 0; k < count; ++k) {
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

/* Faces without area are no third ones: those that have one are gathered. */
static size_t gather_faces(
    const check_mesh *m, const core_edge_run *runs, size_t count, core_edge_run *directed) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i)
        if (norma_check_directed(
                &m->faces[norma_core_topology_face(&m->topology, runs[i].corner)])) {
            if (kept < MOST_RUNS) directed[kept] = runs[i];
            ++kept;
        }
    return kept;
}

static void see_edge(
    void *context, size_t block, uint32_t position, const core_edge_run *runs, size_t count) {
    const edge_pass *pass = context;
    edge_part *part = &pass->parts[block];
    const check_mesh *m = pass->m;
    if (count == 2) keep_conflict(&part->conflicts, runs[0].corner, runs[1].corner);
    core_edge_run directed[MOST_RUNS];
    if (count <= 2 || !norma_check_wants(m, RULE_N303)) return;
    const size_t kept = gather_faces(m, runs, count, directed);
    if (kept <= 2 || (kept <= MOST_RUNS && twins_explain(&m->topology, directed, kept))) return;
    norma_check_hit(m->run, &part->sum.hits[MANY_FACES], (double)kept,
        (check_spot){
            position, norma_core_topology_face(&m->topology, directed[0].corner), SIZE_MAX});
}

static void see_bow_tie(void *context, size_t block, uint32_t position, size_t fans) {
    const edge_pass *pass = context;
    norma_check_hit(pass->m->run, &pass->parts[block].sum.hits[BOW_TIES], (double)fans,
        norma_check_vertex(position));
}

static void see_twins(void *context, size_t block, const core_twin *twins, size_t count) {
    const edge_pass *pass = context;
    edge_part *part = &pass->parts[block];
    size_t ways[2] = {0, 0};
    for (size_t i = 0; i < count; ++i)
        if (ways[twins[i].way]++) {
            norma_check_hit(pass->m->run, &part->sum.hits[DUPLICATES], (double)count,
                norma_check_face(twins[i].face));
            part->sum.twice_area += norma_check_twice_area(pass->m, twins[i].face);
        }
    size_t pairs = ways[0] < ways[1] ? ways[0] : ways[1], told = 0;
    if (!norma_check_directed(&pass->m->faces[twins[0].face])) return; /* nor have its twins */
    for (size_t i = 0; i < count && told < pairs; ++i)
        if (twins[i].way != twins[0].way) {
            keep_conflict(&part->pairs, twins[0].face, twins[i].face);
            ++told;
        }
}

/* What is shown of the faces along an edge that both run along in the same direction. */
typedef enum conflict_kind {
    CONFLICT_TURNED,
    CONFLICT_UNDECIDED,
    CONFLICT_RIGHT,
    CONFLICT_KINDS
} conflict_kind;

/* ---- N301 */

int norma_check_count_conflicts(const core_topology *t, uint8_t *edges) {
    int any = 0;
    for (size_t c = 0; c < t->mesh.corner_count; ++c) {
        const size_t face = norma_core_topology_face(t, c);
        if (t->partners[c] != CORE_EDGE_CONFLICT) continue;
        edges[face] = (uint8_t)(edges[face] + (edges[face] < 255));
        any = 1;
    }
    return any;
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

/* Of the faces of two corners that begin such an edge, by the sides of all faces. Of two that lie
 * folded over one another, or are the same, neither is wound against the other. */
static conflict_kind check_conflict_kind(
    const core_topology *t, size_t first, size_t second, const uint8_t *sides) {
    const uint8_t a = sides[norma_core_topology_face(t, first)],
                  b = sides[norma_core_topology_face(t, second)];
    if (norma_check_is_fold(t, first, second)) return CONFLICT_RIGHT;
    if (norma_check_is_turned(a) || norma_check_is_turned(b)) return CONFLICT_TURNED;
    return (a | b) & CORE_SIDE_UNDECIDED ? CONFLICT_UNDECIDED : CONFLICT_RIGHT;
}

typedef struct conflict_sum {
    check_hits hits;
    double
        twice_area; /* of the faces to turn; where that is undecided, of the smaller at each edge */
} conflict_sum;

static void add_conflict(check_mesh *m, const core_topology *t, size_t first, size_t second,
    const uint8_t *sides, check_spot spot, conflict_sum sums[CONFLICT_KINDS]) {
    core_face a, b;
    const conflict_kind kind = check_conflict_kind(t, first, second, sides);
    norma_check_hit(m->run, &sums[kind].hits, 0, spot);
    if (kind != CONFLICT_UNDECIDED) return;
    norma_core_face_geometry(&t->mesh, norma_core_topology_face(t, first), &a);
    norma_core_face_geometry(&t->mesh, norma_core_topology_face(t, second), &b);
    sums[kind].twice_area += fmin(a.twice_area, b.twice_area);
}

/* Where the material shows both sides, or next to nothing is concerned, all of it only informs. */
static norma_result add_conflicts_of(
    check_mesh *m, conflict_kind kind, size_t turned, int informs, check_hits *hits) {
    static const norma_severity severities[CONFLICT_KINDS] = {
        NORMA_SEVERITY_ERROR, NORMA_SEVERITY_WARNING, NORMA_SEVERITY_INFO};
    static const char *const messages[CONFLICT_KINDS] = {
        "neighbouring faces are wound against each other at %z edge%s: %z face%s to turn",
        "neighbouring faces are wound against each other at %z edge%s; neither volume nor rays "
        "show which faces to turn",
        "neighbouring faces are wound against each other at %z edge%s, where parts touch, or "
        "faces lie folded over one another: no face there has to be turned"};
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N301,
            .severity = informs ? NORMA_SEVERITY_INFO : severities[kind],
            .no_value = 1,
            .no_fix = kind != CONFLICT_TURNED,
            .hits = hits},
        messages[kind], hits->count, norma_check_plural(hits->count), turned,
        norma_check_plural(turned));
}

/* Reports the hits of each kind and frees them; edges and sides: of the mesh's own faces. */
static norma_result check_add_conflicts(
    check_mesh *m, const uint8_t *edges, const uint8_t *sides, conflict_sum sums[CONFLICT_KINDS]) {
    const size_t turned =
        norma_check_count_turned(m, edges, sides, &sums[CONFLICT_TURNED].twice_area);
    const double speck = SPECK * norma_check_add_areas(m, 0);
    norma_result result = NORMA_OK;
    for (int kind = 0; kind < CONFLICT_KINDS; ++kind) {
        const int informs = m->on_purpose || sums[kind].twice_area < speck;
        if (!result && sums[kind].hits.count)
            result = add_conflicts_of(m, (conflict_kind)kind, turned, informs, &sums[kind].hits);
        norma_check_hits_free(&sums[kind].hits);
    }
    return result;
}

static norma_result add_judged(check_mesh *m, const edge_part *parts, size_t blocks,
    const uint8_t *edges, const uint8_t *sides) {
    conflict_sum sums[CONFLICT_KINDS] = {{.twice_area = 0}};
    for (size_t i = 0; i < blocks; ++i)
        for (size_t k = 0; k < parts[i].conflicts.count; ++k) {
            const conflict *c = &parts[i].conflicts.each[k];
            add_conflict(
                m, &m->topology, c->first, c->second, sides, conflict_spot(m, c, edges), sums);
        }
    return check_add_conflicts(m, edges, sides, sums);
}

static norma_result add_conflicts(check_mesh *m, const edge_part *parts, size_t blocks) {
    const size_t faces = m->mesh.face_count;
    uint8_t *edges = norma_core_allocate(&m->run->call, faces, 1),
            *sides = norma_core_allocate(&m->run->call, faces, 1);
    norma_result result = edges && sides ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        memset(edges, 0, faces);
        (void)norma_check_count_conflicts(&m->topology, edges);
        result = norma_check_sides(m, edges, sides);
    }
    if (!result) result = add_judged(m, parts, blocks, edges, sides);
    norma_core_release(&m->run->call, sides, faces, 1);
    norma_core_release(&m->run->call, edges, faces, 1);
    return result;
}

/* ---- N303, N305, N306 */

static norma_result add_many(check_mesh *m, check_hits *many, check_hits *bow_ties) {
    char message[CHECK_MESSAGE];
    const size_t edges = many->count, ties = bow_ties->count;
    norma_check_hits_merge(m->run, many, bow_ties);
    if (edges && ties)
        norma_check_message(message,
            "more than two faces meet at %z edge%s, and parts touch only in a point at %z %s",
            edges, norma_check_plural(edges), ties, ties == 1 ? "vertex" : "vertices");
    else if (edges)
        norma_check_message(message,
            "more than two faces meet at %z edge%s; inside and outside are not defined there",
            edges, norma_check_plural(edges));
    else
        norma_check_message(message, "parts touch only in a point at %z %s", ties,
            ties == 1 ? "vertex" : "vertices");
    norma_severity severity = edges && m->run->profile == NORMA_CHECK_PROFILE_PRINT
                                  ? NORMA_SEVERITY_WARNING
                                  : NORMA_SEVERITY_INFO;
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N303,
            .severity = severity,
            .unit = edges ? "faces" : "fans",
            .hits = many},
        "%s", message);
}

static norma_result add_duplicates(check_mesh *m, check_hits *hits, double twice_area) {
    return norma_check_report(m,
        &(check_finding){.rule = RULE_N305,
            .severity = twice_area < SPECK * norma_check_add_areas(m, 0) ? NORMA_SEVERITY_INFO
                                                                         : NORMA_SEVERITY_WARNING,
            .no_value = 1,
            .hits = hits},
        "drawn more than once: %z face%s with the winding of a face that is there already",
        hits->count, norma_check_plural(hits->count));
}

static norma_result add_pairs(check_mesh *m, const edge_part *parts, size_t blocks, size_t count) {
    uint32_t *faces = norma_core_allocate(&m->run->call, count, sizeof *faces), *at = faces;
    if (!faces) return NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < blocks; ++i)
        for (size_t k = 0; k < parts[i].pairs.count; ++k) *at++ = parts[i].pairs.each[k].second;
    const norma_result result = add_paired_faces(m, faces, count);
    norma_core_release(&m->run->call, faces, count, sizeof *faces);
    return result;
}

static norma_result add_edge_findings(check_mesh *m, edge_part *parts, size_t blocks) {
    check_sum sum = {.twice_area = 0};
    size_t conflicts = 0, pairs = 0;
    int failed = 0;
    for (size_t i = 0; i < blocks; ++i) {
        norma_check_sum_merge(m->run, &sum, &parts[i].sum);
        failed |= parts[i].conflicts.failed | parts[i].pairs.failed;
        pairs += parts[i].pairs.count;
        conflicts += parts[i].conflicts.count;
    }
    norma_result result = failed ? NORMA_ERROR_MEMORY : NORMA_OK;
    if (!result && conflicts && norma_check_wants(m, RULE_N301) && !m->siblings)
        result = add_conflicts(m, parts, blocks);
    if (!result && norma_check_wants(m, RULE_N303))
        result = add_many(m, &sum.hits[MANY_FACES], &sum.hits[BOW_TIES]);
    if (!result && sum.hits[DUPLICATES].count && norma_check_wants(m, RULE_N305))
        result = add_duplicates(m, &sum.hits[DUPLICATES], sum.twice_area);
    if (!result && pairs && norma_check_wants(m, RULE_N306))
        result = add_pairs(m, parts, blocks, pairs);
    norma_check_sum_free(&sum);
    return result;
}

/* ---- all */

static void free_parts(const check_mesh *m, edge_part *parts, size_t blocks) {
    for (size_t i = 0; parts && i < blocks; ++i) {
        free(parts[i].conflicts.each);
        free(parts[i].pairs.each);
        norma_check_sum_free(&parts[i].sum);
    }
    norma_core_release(&m->run->call, parts, blocks, sizeof *parts);
}

norma_result norma_check_pairs(check_mesh *m) {
    norma_result result = norma_check_faces(m);
    if (result || m->topology.partners || !m->mesh.face_count) return result;
    size_t blocks = norma_core_topology_blocks(&m->topology);
    edge_pass pass = {m, norma_core_allocate(&m->run->call, blocks, sizeof *pass.parts)};
    const core_topology_visitor visitor = {&pass, see_edge,
        norma_check_wants(m, RULE_N303) ? see_bow_tie : NULL,
        norma_check_wants_any(m, RULE_N305, RULE_N306) ? see_twins : NULL};
    if (!pass.parts) return NORMA_ERROR_MEMORY;
    memset(pass.parts, 0, blocks * sizeof *pass.parts);
    result = norma_core_pair_edges(&m->topology, &visitor);
    if (!result) result = add_edge_findings(m, pass.parts, blocks);
    free_parts(m, pass.parts, blocks);
    return result;
}

norma_result norma_check_edges(check_mesh *m) {
    return norma_check_wants_any(m, RULE_N301, RULE_N306) ? norma_check_pairs(m) : NORMA_OK;
}

/* ---- N301 over the primitives of one glTF mesh together: a part that is wound
 * against a part of another material is seen as one within a material is. */

static size_t other_face(const core_topology *t, size_t corner) {
    return norma_core_topology_face(t, t->others[corner]);
}

/* Whether the edge is told of at this corner and not at the other. */
static int is_told_here(
    const core_topology *t, size_t corner, const uint8_t *edges, const uint8_t *sides) {
    const size_t here = norma_core_topology_face(t, corner), there = other_face(t, corner);
    const int turned = norma_check_is_turned(sides[here]) - norma_check_is_turned(sides[there]);
    if (turned) return turned > 0;
    return edges[here] != edges[there] ? edges[here] > edges[there] : corner < t->others[corner];
}

norma_result norma_check_conflicts_joined(check_mesh *m, const core_topology *t,
    size_t first_corner, const uint8_t *edges, const uint8_t *sides) {
    conflict_sum sums[CONFLICT_KINDS] = {{.twice_area = 0}};
    const size_t first = first_corner / 3;
    for (size_t c = first_corner; c < first_corner + m->mesh.corner_count; ++c)
        if (t->partners[c] == CORE_EDGE_CONFLICT && is_told_here(t, c, edges, sides))
            add_conflict(m, t, c, t->others[c], sides,
                (check_spot){
                    norma_core_corner(&m->mesh, c - first_corner), c / 3 - first, SIZE_MAX},
                sums);
    return check_add_conflicts(m, edges + first, sides + first, sums);
}
