/* closest.c: the points of a mesh that are nearest to given ones, by its tree of triangles. */
#include "core/topology/topology.h"

enum { CLOSEST_AT_ONCE = 1024 };

static const double MOST_SCALED = 0x1p300; /* its square times an area's fits a double */

typedef struct closest_points {
    core_call call;
    core_mesh mesh;
    core_triangle_tree tree;
    norma_vec3_view points;
    norma_closest *found;
} closest_points;

static int is_near_enough(const double scaled[3]) {
    for (int k = 0; k < 3; ++k)
        if (!(fabs(scaled[k]) <= MOST_SCALED)) return 0;
    return 1;
}

static void find_closest(const closest_points *c, size_t index, size_t *nearest) {
    static const norma_closest none = {.distance = -1, .face = UINT32_MAX};
    norma_closest found = none;
    double point[3], weights[2];
    norma_view_read(&c->points, index, point);
    for (int k = 0; k < 3; ++k) point[k] *= c->mesh.scale;
    if (c->tree.count && is_near_enough(point)) {
        norma_core_triangle_tree_nearest(&c->tree, point, nearest);
        const core_triangle *t = &c->tree.triangles[*nearest];
        found.distance = sqrt(norma_core_nearest_in_triangle(t, point, weights)) / c->mesh.scale;
        found.face = t->face;
        for (int k = 0; k < 3; ++k) {
            found.corners[k] = t->corners[k];
            found.point[k] =
                (t->corner[k] + weights[0] * t->u[k] + weights[1] * t->v[k]) / c->mesh.scale;
        }
        found.weights[0] = 1 - weights[0] - weights[1];
        memcpy(&found.weights[1], weights, sizeof weights);
    }
    c->found[index] = isfinite(found.distance) ? found : none;
}

static void find_closest_points(void *context, size_t chunk) {
    const closest_points *c = context;
    const size_t first = chunk * CLOSEST_AT_ONCE, left = c->points.count - first;
    size_t nearest = 0;
    for (size_t i = 0; i < (left < CLOSEST_AT_ONCE ? left : CLOSEST_AT_ONCE); ++i)
        find_closest(c, first + i, &nearest);
}

norma_result norma_closest_points(const norma_mesh *mesh, norma_vec3_view points,
    const norma_options *options, norma_closest *found, size_t capacity) {
    closest_points c = {.points = points, .found = found};
    norma_result result = norma_core_begin(&c.call, options);
    if (!result) result = norma_core_mesh_shape(mesh, &c.mesh);
    if (!result) result = norma_core_mesh_content(&c.call, &c.mesh);
    if (result) return result;
    if (points.count && (!points.data || !norma_format_size(points.format) || !found))
        return NORMA_ERROR_ARGUMENT;
    if (norma_view_overflows(&points)) return NORMA_ERROR_OVERFLOW;
    if (capacity < points.count) return NORMA_ERROR_CAPACITY;
    norma_core_share(&c.call, c.mesh.corner_count + points.count);
    norma_core_gather(&c.call);
    norma_core_stage(&c.call, 0, 0.5);
    result = norma_core_triangle_tree_build(&c.call, &c.mesh, CORE_TRIANGLES_CUT, &c.tree);
    if (!result) {
        norma_core_stage(&c.call, 0.5, 1);
        result = norma_core_parallel(&c.call,
            (points.count + CLOSEST_AT_ONCE - 1) / CLOSEST_AT_ONCE, find_closest_points, &c);
        norma_core_triangle_tree_release(&c.call, &c.tree);
    }
    norma_core_dismiss(&c.call);
    return norma_core_finish(&c.call, result);
}
