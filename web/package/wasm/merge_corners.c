/* merge_corners.c: values of corners become values of vertices. A vertex keeps its number for the
 * value of its first corner; every other value that it has at a corner makes a new vertex, behind
 * the old ones. New vertices are found again by hashes, so that one vertex may have many. */
#include "calls.h"
#include "exports.h"
#include <stdlib.h>
#include <string.h>

static const uint32_t NONE = UINT32_MAX; /* as a corner: the vertex has no face */

typedef struct merging {
    const uint32_t *values; /* size words for each corner */
    size_t size;
    const void *corners; /* NULL: 0, 1, 2, ... */
    size_t corner_size;
    uint32_t *of_old;    /* the values of old vertices, one after the other */
    uint32_t *corner_of; /* of each vertex, the first corner that has its value */
    uint32_t first_new, vertex_count;
    uint32_t *table; /* new vertices by hash; NONE: free. NULL until there is one */
    size_t mask;     /* the table's size - 1 */
} merging;

static uint32_t vertex_of(const merging *m, size_t corner) {
    if (!m->corners) return (uint32_t)corner;
    if (m->corner_size == 4) return ((const uint32_t *)m->corners)[corner];
    if (m->corner_size == 2) return ((const uint16_t *)m->corners)[corner];
    return ((const uint8_t *)m->corners)[corner];
}

static const uint32_t *value_of(const merging *m, size_t corner) {
    return m->values + m->size * corner;
}

static int are_equal(const uint32_t *a, const uint32_t *b, size_t size) {
    for (size_t k = 0; k < size; ++k)
        if (a[k] != b[k]) return 0;
    return 1;
}

/* Where a new vertex for this corner is in the table, or would be put. */
static uint32_t *slot_of(const merging *m, uint32_t vertex, size_t corner) {
    uint32_t hash = vertex;
    for (size_t k = 0; k < m->size; ++k) {
        hash = (hash ^ value_of(m, corner)[k]) * 0x9e3779b1U;
        hash ^= hash >> 15;
    }
    for (size_t at = hash & m->mask;; at = (at + 1) & m->mask) {
        const uint32_t found = m->table[at];
        if (found == NONE) return &m->table[at];
        const uint32_t there = m->corner_of[found];
        if (vertex_of(m, there) == vertex &&
            are_equal(value_of(m, there), value_of(m, corner), m->size))
            return &m->table[at];
    }
}

/* Room for one more, at most half of it taken. Returns 0 where memory ends. */
static int grow(merging *m) {
    enum { SMALLEST = 256 };
    const size_t size = m->table ? 2 * (m->mask + 1) : SMALLEST,
                 used = m->vertex_count - m->first_new;
    if (m->table && 2 * (used + 1) <= m->mask + 1) return 1;
    free(m->table);
    m->table = malloc(size * sizeof *m->table);
    if (!m->table) return 0;
    m->mask = size - 1;
    memset(m->table, 0xff, size * sizeof *m->table);
    for (uint32_t v = m->first_new; v < m->vertex_count; ++v)
        *slot_of(m, vertex_of(m, m->corner_of[v]), m->corner_of[v]) = v;
    return 1;
}

/* The vertex of a corner whose value is not that of its old vertex; NONE: no memory. */
static uint32_t new_vertex(merging *m, uint32_t vertex, uint32_t corner) {
    if (!grow(m)) return NONE;
    uint32_t *slot = slot_of(m, vertex, corner);
    if (*slot == NONE) {
        m->corner_of[m->vertex_count] = corner;
        *slot = m->vertex_count++;
    }
    return *slot;
}

/* The old vertex, if this is its first corner or has its value. */
static uint32_t merge_corner(merging *m, uint32_t corner) {
    const uint32_t vertex = vertex_of(m, corner), *value = value_of(m, corner);
    uint32_t *kept = m->of_old + m->size * vertex;
    if (m->corner_of[vertex] == NONE) {
        m->corner_of[vertex] = corner;
        for (size_t k = 0; k < m->size; ++k) kept[k] = value[k];
        return vertex;
    }
    return are_equal(kept, value, m->size) ? vertex : new_vertex(m, vertex, corner);
}

/* merged: the new vertex of each corner. of_old: the values of old vertices, 0 for those of no
 * face. corner_of: room for a number for each vertex and each corner. Returns how many vertices
 * there are; UINT32_MAX: memory does not suffice. */
uint32_t WEB_EXPORT(web_merge_corners)(const uint32_t *values, size_t size, const void *corners,
    size_t corner_size, uint32_t corner_count, uint32_t vertex_count, uint32_t *merged,
    uint32_t *of_old, uint32_t *corner_of) {
    merging m = {.values = values,
        .size = size,
        .corners = corners,
        .corner_size = corner_size,
        .of_old = of_old,
        .corner_of = corner_of,
        .first_new = vertex_count,
        .vertex_count = vertex_count};
    memset(corner_of, 0xff, vertex_count * sizeof *corner_of);
    memset(of_old, 0, vertex_count * size * sizeof *of_old);
    for (uint32_t c = 0; c < corner_count && m.vertex_count != NONE; ++c) {
        merged[c] = merge_corner(&m, c);
        if (merged[c] == NONE) m.vertex_count = NONE;
    }
    free(m.table);
    return m.vertex_count;
}

/* Of new vertices, the corners that corner_of names: their values, and the old vertex that each is
 * a copy of. */
void WEB_EXPORT(web_gather_corners)(const uint32_t *values, size_t size, const void *corners,
    size_t corner_size, const uint32_t *corner_of, size_t count, uint32_t *out, uint32_t *sources) {
    const merging m = {
        .values = values, .size = size, .corners = corners, .corner_size = corner_size};
    for (size_t i = 0; i < count; ++i, out += size) {
        for (size_t k = 0; k < size; ++k) out[k] = value_of(&m, corner_of[i])[k];
        sources[i] = vertex_of(&m, corner_of[i]);
    }
}
