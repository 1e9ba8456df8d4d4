/* mend_vertices.c: vertices put right: those of a soup that are equal in everything become one (N502), where the faces around them do not look so many ways that their average
 * would be no direction: that would be N403. A step of its own, when nothing else is left to edit in the mesh. */
#include "mend_internal.h"
#include <math.h>
#include <stdlib.h>

/* Twice what N403 minds. */
static const double CANCELLED = 2e-3;

typedef struct vertex_sum {
    double normals[3], weights;
} vertex_sum;

/* ---- weld */

/* Over the corners of all vertices that would become one, by angle, as N403 measures. */
static void add_corners(const mend_mesh *m, const uint32_t *first, vertex_sum *sums) {
    for (size_t face = 0; face < m->mesh.face_count; face++) {
        core_face geometry;
        norma_core_face_geometry(&m->mesh, face, &geometry);
        if (!(norma_core_dot(geometry.normal, geometry.normal) > 0))
            continue;
        for (size_t c = norma_core_face_begin(&m->mesh, face); c < norma_core_face_end(&m->mesh, face); c++) {
            vertex_sum *sum = &sums[first[norma_core_corner(&m->mesh, c)]];
            if (!norma_core_is_kept(&m->mesh, face, c))
                continue;
            double weight = norma_core_corner_weight(&m->mesh, NORMA_WEIGHT_ANGLE, face, &geometry, c);
            for (int k = 0; k < 3; k++) sum->normals[k] += weight * geometry.normal[k];
            sum->weights += weight;
        }
    }
}

static int cancels(const vertex_sum *sum) { return sum->weights > 0 && !(norma_core_length(sum->normals) >= CANCELLED * sum->weights); }

/* The least of those that become one, of each; the number of vertices that go. */
static size_t part_cancelled(const vertex_sum *sums, size_t count, uint32_t *first) {
    size_t gone = 0;
    for (size_t v = 0; v < count; v++) {
        if (cancels(&sums[first[v]]))
            first[v] = (uint32_t)v;
        gone += first[v] != v;
    }
    return gone;
}

static norma_result put_welded(mend_mesh *m, size_t count, size_t left, uint32_t *first) {
    uint32_t *sources = malloc((left + 1) * sizeof *sources), *corners = malloc((m->mesh.corner_count + 1) * sizeof *corners);
    size_t next = 0;
    if (!sources || !corners) {
        free(sources);
        free(corners);
        return NORMA_ERROR_MEMORY;
    }
    for (size_t v = 0; v < count; v++) {
        if (first[v] == v)
            sources[next++] = (uint32_t)v;
        first[v] = first[v] == v ? (uint32_t)next - 1 : first[first[v]]; /* its new number; the least comes before those that equal it */
    }
    for (size_t c = 0; c < m->mesh.corner_count; c++) corners[c] = first[norma_core_corner(&m->mesh, c)];
    m->edit->source_vertices = sources;
    m->edit->vertex_count = left;
    m->edit->new_corners = corners;
    return NORMA_OK;
}

static norma_result weld(mend_mesh *m) {
    const size_t count = m->data.mesh.positions.count;
    uint32_t *first = malloc((count + 1) * sizeof *first);
    vertex_sum *sums = calloc(count + 1, sizeof *sums);
    norma_result result = NORMA_ERROR_MEMORY;
    if (first && sums && norma_document_equal_vertices(m->document, m->index, first, NULL) == NORMA_DOCUMENT_OK) {
        add_corners(m, first, sums);
        size_t gone = part_cancelled(sums, count, first);
        result = gone ? put_welded(m, count, count - gone, first) : NORMA_OK;
    }
    free(first);
    free(sums);
    return result;
}

/* ---- all of it */

static int has_vertices(const mend_mesh *m) {
    const norma_file_format format = norma_document_format(m->document);
    return format == NORMA_FILE_GLTF || format == NORMA_FILE_GLB;
}

/* Vertices without normals, or normals without vertices, are another rule's (N106), which comes first. */
norma_result norma_mend_vertices(mend_mesh *m) {
    const int soup = norma_mend_has(m, RULE_N502);
    if (!soup || !has_vertices(m) || m->attributes.normals_missing || m->attributes.normals_surplus)
        return NORMA_OK;
    if (norma_mend_has_edit(m->edit)) {
        m->waits = 1;
        return NORMA_OK;
    }
    return weld(m);
}
