/* back_to_back.c: N306: the same face twice, wound opposite ways. */
#include "check/rules/rules.h"
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

norma_result norma_check_back_to_back(check_mesh *m, const uint32_t *faces, size_t count) {
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
