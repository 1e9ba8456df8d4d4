/* most_visible_normals.c: the most visible normal of each position, from its star; where no open
 * hemisphere holds its faces, that of each of its vertices. */
#include "core/corner/corner_sort.h"
#include "core/vertex/vertex_normals.h"

enum { OWN = 0x80 }; /* the vertex has a result of its own, since that of its position cancelled */

static void keep(const core_vertices *vertices, uint32_t index, int own, const core_fan *fan) {
    memcpy(vertices->normals[index], fan->normal, sizeof fan->normal);
    vertices->reasons[index] = (uint8_t)(fan->reason | (uint32_t)own);
}

static void see_each_vertex(const core_vertices *vertices, core_star *star) {
    star_member *members = norma_core_star_members(star);
    uint32_t *numbers = norma_core_star_numbers(star);
    core_fan fan = {.reason = NORMA_REASON_CANCELLED};
    for (uint32_t i = 0; i < star->count; i++)
        members[i] = (star_member){
            .vertex = norma_core_corner(&vertices->prepared->mesh, star->corners[i].corner),
            .index = i};
    norma_core_sort_corners(members, star->count);
    keep(vertices, star->position, OWN, &fan);
    for (size_t begin = 0, end; begin < star->count; begin = end) {
        for (end = begin; end < star->count && members[end].vertex == members[begin].vertex; end++)
            numbers[end - begin] = members[end].index;
        norma_core_star_see_some(star, numbers, end - begin, &fan);
        keep(vertices, members[begin].vertex, OWN, &fan);
    }
}

static void see_fans(void *context, const core_fans *fans, core_tally *tally) {
    const core_vertices *vertices = context;
    core_star *star = fans->star;
    (void)tally;
    if (star->fans[0].reason == NORMA_REASON_CANCELLED && vertices->prepared->mesh.weld)
        see_each_vertex(vertices, star);
    else
        keep(vertices, star->position, 0, &star->fans[0]);
}

norma_result norma_core_cone_vertices(
    core_prepared_mesh *prepared, core_vertices *vertices, core_tally *tally) {
    stars_part sum = {0};
    const position_visit visit = {.join = CORE_JOIN_ALL, .see = see_fans, .context = vertices};
    const size_t count = prepared->mesh.positions.count;
    *vertices = (core_vertices){.prepared = prepared, .count = count};
    vertices->normals = norma_core_allocate(prepared->call, count, sizeof *vertices->normals);
    vertices->reasons = norma_core_allocate(prepared->call, count, 1);
    norma_result result = vertices->normals && vertices->reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        memset(vertices->reasons, NORMA_REASON_UNREFERENCED, count);
        result = norma_core_visit_positions(prepared, &visit, &sum);
    }
    norma_core_count_add(&tally->degenerate, &sum.tally.degenerate);
    if (result != NORMA_OK) norma_core_release_vertices(vertices);
    return result;
}

int norma_core_resolve_cone(const core_vertices *vertices, size_t vertex, float normal[3]) {
    const uint32_t position = norma_core_welded(&vertices->prepared->mesh, (uint32_t)vertex);
    const int by_vertex = vertices->reasons[position] & OWN;
    const size_t index = by_vertex ? vertex : position;
    const int reason = by_vertex && !(vertices->reasons[vertex] & OWN)
                           ? NORMA_REASON_CANCELLED
                           : vertices->reasons[index] & ~OWN;
    double p[3];
    memcpy(normal, vertices->normals[index], 3 * sizeof *normal);
    if (reason != NORMA_REASON_UNREFERENCED) return reason;
    norma_core_position(&vertices->prepared->mesh, (uint32_t)vertex, p);
    return norma_core_finite(p) ? reason : NORMA_REASON_NON_FINITE;
}
