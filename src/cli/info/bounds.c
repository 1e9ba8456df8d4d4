/* bounds.c: the box that a file's surfaces fill, vertex by vertex, so that it is exact under any
 * transform. */
#include "cli/info/bounds.h"
#include <math.h>
#include <string.h>

/* A file of a few kilobytes can ask for millions of instances. */
static const size_t most_visits = (size_t)1 << 26;

static void include(info_bounds *bounds, const double p[3]) {
    if (!isfinite(p[0]) || !isfinite(p[1]) || !isfinite(p[2])) return;
    for (int axis = 0; axis < 3; ++axis) {
        if (!bounds->known || p[axis] < bounds->least[axis]) bounds->least[axis] = p[axis];
        if (!bounds->known || p[axis] > bounds->most[axis]) bounds->most[axis] = p[axis];
    }
    bounds->known = 1;
}

/* world: column-major. In pieces, so that a large mesh takes little memory. */
static void include_mesh(info_bounds *bounds, const norma_vec3_view *view, const double world[16]) {
    enum { PIECE = 256 };
    double points[PIECE][3];
    for (size_t first = 0; first < view->count; first += PIECE) {
        const size_t count = view->count - first < PIECE ? view->count - first : PIECE;
        const norma_vec3_view piece = {points, count, 0, NORMA_FORMAT_DOUBLE};
        for (size_t i = 0; i < count; ++i) norma_view_vector(view, first + i, points[i]);
        if (norma_transform_positions_double(world, piece, points[0], 0, count)) return;
        for (size_t i = 0; i < count; ++i) include(bounds, points[i]);
    }
}

/* The primitives of a mesh under one node, each of its instances. *visits: vertices looked at. */
static norma_document_result include_node(norma_document *document, size_t index,
    const norma_node_info *node, info_bounds *bounds, size_t *visits, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < norma_document_mesh_count(document) && !result; ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        result = norma_document_mesh_info(document, i, &info);
        if (result || info.mesh != node->mesh || info.not_read) continue;
        if (info.vertices && node->instances > (most_visits - *visits) / info.vertices) {
            *visits = most_visits;
            return NORMA_DOCUMENT_OK;
        }
        *visits += node->instances * info.vertices;
        result = norma_document_mesh_data(document, i, &data, error);
        for (size_t k = 0; k < node->instances && !result; ++k) {
            double world[16];
            result = norma_document_instance_world(document, index, k, world, error);
            if (!result) include_mesh(bounds, &data.mesh.positions, world);
        }
    }
    return result;
}

static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

static norma_document_result include_stored(
    norma_document *document, info_bounds *bounds, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < norma_document_mesh_count(document) && !result; ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        result = norma_document_mesh_info(document, i, &info);
        if (result || info.not_read) continue;
        result = norma_document_mesh_data(document, i, &data, error);
        if (!result) include_mesh(bounds, &data.mesh.positions, identity);
    }
    return result;
}

norma_document_result info_find_bounds(
    norma_document *document, info_bounds *bounds, norma_document_error *error) {
    const size_t nodes = norma_document_node_count(document),
                 meshes = norma_document_mesh_count(document);
    size_t visits = 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    *bounds = (info_bounds){0};
    if (nodes == 0) return include_stored(document, bounds, error);
    for (size_t i = 0; i < nodes && !result && visits < most_visits; ++i) {
        norma_node_info node;
        result = norma_document_node_info(document, i, &node);
        /* Looking through the meshes counts as well. */
        visits = meshes < most_visits - visits ? visits + meshes : most_visits;
        if (!result) result = include_node(document, i, &node, bounds, &visits, error);
    }
    if (visits >= most_visits) bounds->known = 0;
    return result;
}
