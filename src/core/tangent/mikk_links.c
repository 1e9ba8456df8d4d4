/* mikk_links.c: who shares an edge, among the corners of one vertex. Of the triangles along an
 * edge, in ascending order, each takes the first one before it that runs the other way and has no
 * partner yet: what the reference's search over its sorted edges comes to, also where more than two
 * meet. */
#include "core/tangent/mikk.h"

static void link_small(
    const uint32_t *next, const uint32_t *previous, size_t count, const mikk_links *links) {
    for (uint32_t j = 0; j < count; j++) {
        links->left[j] = links->right[j] = MIKK_NONE;
        for (uint32_t i = 0; i < j; i++) {
            if (previous[i] == next[j] && links->right[i] == MIKK_NONE &&
                links->left[j] == MIKK_NONE) {
                links->left[j] = i;
                links->right[i] = j;
            }
            if (next[i] == previous[j] && links->left[i] == MIKK_NONE &&
                links->right[j] == MIKK_NONE) {
                links->right[j] = i;
                links->left[i] = j;
            }
        }
    }
}

static struct mikk_edge *edge_to(const mikk_edge_table *table, size_t room, uint32_t vertex) {
    const uint32_t hash = vertex * UINT32_C(2654435769);
    size_t slot = (hash ^ hash >> 15) & (room - 1);
    while (table->edges[slot].first != MIKK_NONE && table->edges[slot].vertex != vertex)
        slot = (slot + 1) & (room - 1);
    return &table->edges[slot];
}

/* Edges that wait for a partner stand in line behind their vertex: 2 * corner, and 1 more for an
 * edge in. All in one line run the same way. A line that has become empty keeps its place, with
 * last at MIKK_NONE. */
static void meet(
    const mikk_edge_table *table, size_t room, uint32_t vertex, uint32_t edge, mikk_links *links) {
    struct mikk_edge *line = edge_to(table, room, vertex);
    const int waits = line->first != MIKK_NONE && line->last != MIKK_NONE;
    if (waits && ((line->first ^ edge) & 1)) {
        const uint32_t out = edge & 1 ? line->first : edge, in = edge & 1 ? edge : line->first;
        links->left[out / 2] = in / 2;
        links->right[in / 2] = out / 2;
        if (line->first == line->last)
            line->last = MIKK_NONE;
        else
            line->first = table->following[line->first];
        return;
    }
    if (waits)
        table->following[line->last] = edge;
    else
        line->first = edge;
    line->vertex = vertex;
    line->last = edge;
}

static size_t table_room(size_t corners) {
    size_t room = 16;
    while (room < 4 * corners) room *= 2;
    return room;
}

void norma_core_mikk_link(const uint32_t *next, const uint32_t *previous, size_t count,
    mikk_edge_table *table, mikk_links *links) {
    if (count <= MIKK_SMALL_STAR) {
        link_small(next, previous, count, links);
        return;
    }
    const size_t room = table_room(count);
    memset(table->edges, 0xff, room * sizeof *table->edges);
    memset(links->left, 0xff, count * sizeof *links->left);
    memset(links->right, 0xff, count * sizeof *links->right);
    for (uint32_t j = 0; j < count; j++) {
        meet(table, room, next[j], 2 * j, links);
        meet(table, room, previous[j], 2 * j + 1, links);
    }
}

norma_result norma_core_mikk_table_open(
    const core_call *call, size_t most_corners, mikk_edge_table *table) {
    *table = (mikk_edge_table){0};
    if (most_corners <= MIKK_SMALL_STAR) return NORMA_OK;
    table->room = table_room(most_corners);
    table->edges = norma_core_allocate(call, table->room, sizeof *table->edges);
    table->following = norma_core_allocate(call, 2 * most_corners, sizeof *table->following);
    return table->edges && table->following ? NORMA_OK : NORMA_ERROR_MEMORY;
}

void norma_core_mikk_table_close(
    const core_call *call, size_t most_corners, mikk_edge_table *table) {
    norma_core_release(call, table->edges, table->room, sizeof *table->edges);
    norma_core_release(call, table->following, 2 * most_corners, sizeof *table->following);
}
