/* inward_bodies.c: bodies that N302 names, to be reversed as a whole. As the rule has it, what is
 * closed in its own primitive is a body by itself, and the open parts of all primitives of a glTF
 * mesh are joined where their edges have equal positions. */
#include "check/fix/fix.h"
#include "check/fix/edge_parts.h"
#include <stdlib.h>

typedef struct bodies {
    const core_mesh *meshes;
    size_t count, face_count;
    fix_edge *edges;
    size_t edge_count;
    uint32_t *parts, *joined; /* of each face a face of the same part; of the same body */
    uint8_t *open;            /* at the face that stands for a part */
} bodies;

static int same_edge(const fix_edge *a, const fix_edge *b) {
    return norma_fix_compare_points(a->a, b->a) == 0 && norma_fix_compare_points(a->b, b->b) == 0;
}

/* ---- edges: of faces that have three or more */

static int gather(bodies *b) {
    size_t corners = 0, face = 0;
    for (size_t i = 0; i < b->count; i++) corners += b->meshes[i].corner_count;
    b->edges = malloc((corners + 1) * sizeof *b->edges);
    for (size_t i = 0; b->edges && i < b->count; i++)
        for (size_t f = 0; f < b->meshes[i].face_count; f++, face++) {
            fix_edge *edges = b->edges + b->edge_count;
            const size_t count =
                norma_fix_face_edges(&b->meshes[i], f, (uint32_t)face, (uint32_t)i, edges);
            b->edge_count += count < 3 ? 0 : count;
        }
    if (b->edges) qsort(b->edges, b->edge_count, sizeof *b->edges, norma_fix_compare_edges);
    return b->edges != NULL;
}

/* ---- parts and bodies */

static void find_parts(bodies *b) {
    const fix_edge *e = b->edges;
    for (size_t i = 1; i < b->edge_count; i++)
        if (norma_fix_compare_edges(&e[i - 1], &e[i]) == 0)
            norma_fix_unite(b->parts, e[i - 1].face, e[i].face);
    for (size_t begin = 0, end; begin < b->edge_count; begin = end) {
        for (end = begin + 1;
             end < b->edge_count && norma_fix_compare_edges(&e[begin], &e[end]) == 0;)
            end++;
        if (end - begin != 2 || e[begin].way == e[begin + 1].way)
            b->open[norma_fix_root(b->parts, e[begin].face)] = 1;
    }
}

static void join_open(bodies *b) {
    for (size_t f = 0; f < b->face_count; f++) b->joined[f] = norma_fix_root(b->parts, (uint32_t)f);
    for (size_t begin = 0, end; begin < b->edge_count; begin = end) {
        size_t first = SIZE_MAX;
        for (end = begin; end < b->edge_count && same_edge(&b->edges[begin], &b->edges[end]);
             end++) {
            const uint32_t part = norma_fix_root(b->parts, b->edges[end].face);
            if (!b->open[part]) continue;
            if (first != SIZE_MAX)
                norma_fix_unite(b->joined, b->edges[first].face, b->edges[end].face);
            first = end;
        }
    }
}

norma_result norma_fix_whole_bodies(const core_mesh *meshes, size_t count, uint8_t *named) {
    bodies b = {.meshes = meshes, .count = count};
    for (size_t i = 0; i < count; i++) b.face_count += meshes[i].face_count;
    b.parts = malloc((b.face_count + 1) * sizeof *b.parts);
    b.joined = malloc((b.face_count + 1) * sizeof *b.joined);
    b.open = calloc(b.face_count + 1, 1);
    uint8_t *bodies_named = calloc(b.face_count + 1, 1);
    const int fine =
        b.parts && b.joined && b.open && bodies_named && b.face_count < UINT32_MAX && gather(&b);
    if (fine) {
        for (size_t f = 0; f < b.face_count; f++) b.parts[f] = (uint32_t)f;
        find_parts(&b);
        join_open(&b);
        for (size_t f = 0; f < b.face_count; f++)
            if (named[f]) bodies_named[norma_fix_root(b.joined, (uint32_t)f)] = 1;
        for (size_t f = 0; f < b.face_count; f++)
            named[f] = bodies_named[norma_fix_root(b.joined, (uint32_t)f)];
    }
    free(b.edges);
    free(b.parts);
    free(b.joined);
    free(b.open);
    free(bodies_named);
    return fine ? NORMA_OK : NORMA_ERROR_MEMORY;
}
