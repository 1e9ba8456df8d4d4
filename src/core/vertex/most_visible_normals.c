/* most_visible_normals.c: the most visible normal of each position, from its ring; where no open
 * hemisphere holds its faces, that of each of its vertices. */
#include "core/corner/corner_sort.h"
#include "core/vertex/vertex_normals.h"

enum { OWN = 0x80 }; /* the vertex has a result of its own, since that of its position cancelled */

static void keep(const core_vertices *vertices, uint32_t index, int own, const core_fan *fan) {
    memcpy(vertices->normals[index], fan->normal, sizeof fan->normal);
    vertices->reasons[index] = (uint8_t)(fan->reason | (uint32_t)own);
}

static void see_each_vertex(const core_vertices *vertices, core_ring *ring) {
    ring_member *members = norma_core_ring_members(ring);
    uint32_t *numbers = norma_core_ring_numbers(ring);
    core_fan fan = {.reason = NORMA_REASON_CANCELLED};
    for (uint32_t i = 0; i < ring->count; i++)
        members[i] = (ring_member){
            .vertex = norma_core_corner(&vertices->surface->mesh, ring->corners[i].corner),
            .index = i};
    norma_core_sort_members(members, ring->count);
    keep(vertices, ring->position, OWN, &fan);
    for (size_t begin = 0, end; begin < ring->count; begin = end) {
        for (end = begin; end < ring->count && members[end].vertex == members[begin].vertex; end++)
            numbers[end - begin] = members[end].index;
        norma_core_ring_see_some(ring, numbers, end - begin, &fan);
        keep(vertices, members[begin].vertex, OWN, &fan);
    }
}

static void see_fans(void *context, const core_fans *fans, core_tally *tally) {
    const core_vertices *vertices = context;
    core_ring *ring = fans->ring;
    (void)tally;
    if (ring->fans[0].reason == NORMA_REASON_CANCELLED && vertices->surface->mesh.weld)
        see_each_vertex(vertices, ring);
    else
        keep(vertices, ring->position, 0, &ring->fans[0]);
}

norma_result norma_core_cone_vertices(
    core_surface *surface, core_vertices *vertices, core_tally *tally) {
    rings_part sum = {0};
    const ring_visit visit = {.join = CORE_JOIN_ALL, .see = see_fans, .context = vertices};
    const size_t count = surface->mesh.positions.count;
    *vertices = (core_vertices){.surface = surface, .count = count};
    vertices->normals = norma_core_allocate(surface->call, count, sizeof *vertices->normals);
    vertices->reasons = norma_core_allocate(surface->call, count, 1);
    norma_result result = vertices->normals && vertices->reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        memset(vertices->reasons, NORMA_REASON_UNREFERENCED, count);
        result = norma_core_visit_rings(surface, &visit, &sum);
    }
    norma_core_count_add(&tally->degenerate, &sum.tally.degenerate);
    if (result != NORMA_OK) norma_core_release_vertices(vertices);
    return result;
}

int norma_core_resolve_cone(const core_vertices *vertices, size_t vertex, float normal[3]) {
    const uint32_t position = norma_core_welded(&vertices->surface->mesh, (uint32_t)vertex);
    const int by_vertex = vertices->reasons[position] & OWN;
    const size_t index = by_vertex ? vertex : position;
    const int reason = by_vertex && !(vertices->reasons[vertex] & OWN)
                           ? NORMA_REASON_CANCELLED
                           : vertices->reasons[index] & ~OWN;
    double p[3];
    memcpy(normal, vertices->normals[index], 3 * sizeof *normal);
    if (reason != NORMA_REASON_UNREFERENCED) return reason;
    norma_core_position(&vertices->surface->mesh, (uint32_t)vertex, p);
    return norma_core_finite(p) ? reason : NORMA_REASON_NON_FINITE;
}
