/* mend_inward.c: bodies that N302 names, to be reversed as a whole. As the rule has it, what is closed in its own primitive is a body by itself, and the open parts of all primitives
 * of a glTF mesh are joined where their edges have equal positions. */
#include "mend_internal.h"
#include <stdlib.h>
#include <string.h>

typedef struct body_edge {
    double   a[3], b[3]; /* its ends, the lesser first */
    uint32_t face;       /* counted over all meshes */
    uint32_t mesh;
    int      way;
} body_edge;

typedef struct bodies {
    const core_mesh *meshes;
    size_t           count, face_count;
    body_edge       *edges;
    size_t           edge_count;
    uint32_t        *parts, *joined; /* of each face a face of the same part; of the same body */
    uint8_t         *open;           /* at the face that stands for a part */
} bodies;

static int compare_points(const double a[3], const double b[3]) {
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] != b[axis])
            return a[axis] < b[axis] ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b) {
    const body_edge *one = a, *other = b;
    int order = compare_points(one->a, other->a);
    order = order ? order : compare_points(one->b, other->b);
    return order ? order : one->mesh != other->mesh ? (one->mesh < other->mesh ? -1 : 1) : 0;
}

static int same_edge(const body_edge *a, const body_edge *b) { return compare_points(a->a, b->a) == 0 && compare_points(a->b, b->b) == 0; }

static uint32_t root_of(uint32_t *parents, uint32_t face) {
    while (parents[face] != face) face = parents[face] = parents[parents[face]];
    return face;
}

static void unite(uint32_t *parents, uint32_t one, uint32_t other) {
    const uint32_t a = root_of(parents, one), b = root_of(parents, other);
    parents[a > b ? a : b] = a < b ? a : b;
}

/* ---- edges: of faces that have three or more, between finite positions that differ */

static size_t read_edges(const core_mesh *mesh, size_t face, body_edge *edges) {
    const size_t begin = norma_core_face_begin(mesh, face), end = norma_core_face_end(mesh, face);
    size_t count = 0;
    for (size_t c = begin; c < end; c++) {
        body_edge *edge = &edges[count];
        double from[3], to[3];
        norma_core_position(mesh, norma_core_corner(mesh, c), from);
        norma_core_position(mesh, norma_core_corner(mesh, c + 1 < end ? c + 1 : begin), to);
        const int order = compare_points(from, to);
        if (!norma_core_finite(from) || !norma_core_finite(to) || order == 0)
            continue;
        memcpy(edge->a, order < 0 ? from : to, sizeof from);
        memcpy(edge->b, order < 0 ? to : from, sizeof to);
        edge->way = order < 0;
        count++;
    }
    return count < 3 ? 0 : count;
}

static int gather(bodies *b) {
    size_t corners = 0, face = 0;
    for (size_t i = 0; i < b->count; i++) corners += b->meshes[i].corner_count;
    b->edges = malloc((corners + 1) * sizeof *b->edges);
    for (size_t i = 0; b->edges && i < b->count; i++)
        for (size_t f = 0; f < b->meshes[i].face_count; f++, face++) {
            body_edge *edges = b->edges + b->edge_count;
            const size_t count = read_edges(&b->meshes[i], f, edges);
            for (size_t k = 0; k < count; k++) {
                edges[k].face = (uint32_t)face;
                edges[k].mesh = (uint32_t)i;
            }
            b->edge_count += count;
        }
    if (b->edges)
        qsort(b->edges, b->edge_count, sizeof *b->edges, compare_edges);
    return b->edges != NULL;
}

/* ---- parts and bodies */

static void find_parts(bodies *b) {
    const body_edge *e = b->edges;
    for (size_t i = 1; i < b->edge_count; i++)
        if (compare_edges(&e[i - 1], &e[i]) == 0)
            unite(b->parts, e[i - 1].face, e[i].face);
    for (size_t begin = 0, end; begin < b->edge_count; begin = end) {
        for (end = begin + 1; end < b->edge_count && compare_edges(&e[begin], &e[end]) == 0;) end++;
        if (end - begin != 2 || e[begin].way == e[begin + 1].way)
            b->open[root_of(b->parts, e[begin].face)] = 1;
    }
}

static void join_open(bodies *b) {
    for (size_t f = 0; f < b->face_count; f++) b->joined[f] = root_of(b->parts, (uint32_t)f);
    for (size_t begin = 0, end; begin < b->edge_count; begin = end) {
        size_t first = SIZE_MAX;
        for (end = begin; end < b->edge_count && same_edge(&b->edges[begin], &b->edges[end]); end++) {
            const uint32_t part = root_of(b->parts, b->edges[end].face);
            if (!b->open[part])
                continue;
            if (first != SIZE_MAX)
                unite(b->joined, b->edges[first].face, b->edges[end].face);
            first = end;
        }
    }
}

norma_result norma_mend_whole_bodies(const core_mesh *meshes, size_t count, uint8_t *named) {
    bodies b = {.meshes = meshes, .count = count};
    for (size_t i = 0; i < count; i++) b.face_count += meshes[i].face_count;
    b.parts = malloc((b.face_count + 1) * sizeof *b.parts);
    b.joined = malloc((b.face_count + 1) * sizeof *b.joined);
    b.open = calloc(b.face_count + 1, 1);
    uint8_t *bodies_named = calloc(b.face_count + 1, 1);
    const int fine = b.parts && b.joined && b.open && bodies_named && b.face_count < UINT32_MAX && gather(&b);
    if (fine) {
        for (size_t f = 0; f < b.face_count; f++) b.parts[f] = (uint32_t)f;
        find_parts(&b);
        join_open(&b);
        for (size_t f = 0; f < b.face_count; f++)
            if (named[f])
                bodies_named[root_of(b.joined, (uint32_t)f)] = 1;
        for (size_t f = 0; f < b.face_count; f++) named[f] = bodies_named[root_of(b.joined, (uint32_t)f)];
    }
    free(b.edges);
    free(b.parts);
    free(b.joined);
    free(b.open);
    free(bodies_named);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}
