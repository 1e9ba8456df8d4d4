/* gltf_scene.c: a glTF's triangles in world space, gathered with plain arithmetic of the tests'
 * own. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include "gltf_scene.h"

static void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static double length(const double a[3]) { return sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

static void normalise(double a[3]) {
    const double size = length(a);
    for (int k = 0; k < 3; ++k) a[k] = size > 0 ? a[k] / size : 0;
}

static void vector_at(norma_vec3_view view, size_t index, double out[3]) {
    static const size_t sizes[] = {4, 8, 1, 1, 2, 2};
    const size_t size = sizes[view.format];
    const unsigned char *at =
        (const unsigned char *)view.data + index * (view.stride ? view.stride : 3 * size);
    for (int k = 0; k < 3; ++k, at += size) {
        float f;
        int16_t s;
        uint16_t us;
        switch (view.format) {
        case NORMA_FORMAT_FLOAT:
            memcpy(&f, at, sizeof f);
            out[k] = (double)f;
            break;
        case NORMA_FORMAT_DOUBLE:
            memcpy(&out[k], at, sizeof out[k]);
            break;
        case NORMA_FORMAT_INT8:
            out[k] = (signed char)*at;
            break;
        case NORMA_FORMAT_UINT8:
            out[k] = *at;
            break;
        case NORMA_FORMAT_INT16:
            memcpy(&s, at, sizeof s);
            out[k] = s;
            break;
        case NORMA_FORMAT_UINT16:
            memcpy(&us, at, sizeof us);
            out[k] = us;
            break;
        }
    }
}

static size_t corner_at(const norma_mesh *mesh, size_t corner) {
    if (!mesh->corners) return corner;
    switch (mesh->corner_size) {
    case 1:
        return ((const uint8_t *)mesh->corners)[corner];
    case 2:
        return ((const uint16_t *)mesh->corners)[corner];
    default:
        return ((const uint32_t *)mesh->corners)[corner];
    }
}

static scene_triangle *new_triangle(drawn_scene *scene) {
    if (scene->count == scene->room) {
        scene->room = scene->room ? 2 * scene->room : 64;
        scene->triangles = realloc(scene->triangles, scene->room * sizeof *scene->triangles);
        assert_non_null(scene->triangles);
    }
    memset(&scene->triangles[scene->count], 0, sizeof *scene->triangles);
    return &scene->triangles[scene->count++];
}

/* Positions by the matrix; normals by its cofactors, and a mirror reverses the winding: so glTF's
 * renderers do. */
static void add_corner(const double world[16], const norma_mesh_data *data, size_t vertex,
    double position[3], double normal[3], int mirrored) {
    double p[3], n[3];
    vector_at(data->mesh.positions, vertex, p);
    for (int k = 0; k < 3; ++k)
        position[k] = world[k] * p[0] + world[4 + k] * p[1] + world[8 + k] * p[2] + world[12 + k];
    if (data->normals.count == 0) return;
    double cofactor[9];
    vector_at(data->normals, vertex, n);
    cross(world + 4, world + 8, cofactor);
    cross(world + 8, world, cofactor + 3);
    cross(world, world + 4, cofactor + 6);
    for (int k = 0; k < 3; ++k)
        normal[k] = (cofactor[k] * n[0] + cofactor[3 + k] * n[1] + cofactor[6 + k] * n[2]) *
                    (mirrored ? -1 : 1);
    normalise(normal);
}

static void add_mesh(
    drawn_scene *scene, const double world[16], size_t node, const norma_mesh_data *data) {
    double normal[3];
    cross(world + 4, world + 8, normal);
    const int mirrored = world[0] * normal[0] + world[1] * normal[1] + world[2] * normal[2] < 0;
    for (size_t corner = 0; corner + 2 < data->mesh.corner_count; corner += 3) {
        scene_triangle *triangle = new_triangle(scene);
        triangle->node = node;
        for (size_t k = 0; k < 3; ++k)
            add_corner(world, data, corner_at(&data->mesh, corner + (mirrored && k ? 3 - k : k)),
                triangle->position[k], triangle->normal[k], mirrored);
    }
}

void scene_read(norma_document *document, drawn_scene *scene) {
    memset(scene, 0, sizeof *scene);
    norma_document_error error;
    for (size_t i = 0; i < norma_document_node_count(document); ++i) {
        norma_node_info node;
        assert_int_equal(norma_document_node_info(document, i, &node), NORMA_DOCUMENT_OK);
        for (size_t k = 0; k < norma_document_mesh_count(document); ++k) {
            norma_mesh_info info;
            norma_mesh_data data;
            assert_int_equal(norma_document_mesh_info(document, k, &info), NORMA_DOCUMENT_OK);
            if (info.mesh != node.mesh || info.not_read) continue;
            if (norma_document_mesh_data(document, k, &data, &error) != NORMA_DOCUMENT_OK)
                fail_msg("%s", error.message);
            scene->integers |= data.mesh.positions.format != NORMA_FORMAT_FLOAT &&
                               data.mesh.positions.format != NORMA_FORMAT_DOUBLE;
            add_mesh(scene, node.world, node.node, &data);
        }
    }
}

void scene_free(drawn_scene *scene) {
    free(scene->triangles);
    memset(scene, 0, sizeof *scene);
}

typedef struct collected {
    unsigned char *bytes;
    size_t size, room;
} collected;

static int collect(void *user, const void *bytes, size_t size) {
    collected *all = user;
    if (all->size + size >= all->room) {
        all->room = 2 * (all->size + size) + 1;
        all->bytes = realloc(all->bytes, all->room);
        assert_non_null(all->bytes);
    }
    memcpy(all->bytes + all->size, bytes, size);
    all->size += size;
    all->bytes[all->size] = 0; /* tests search in it as in text */
    return 0;
}

unsigned char *scene_output(norma_document *document, size_t *size) {
    collected all = {NULL, 0, 0};
    norma_document_error error;
    if (norma_document_write(document, collect, &all, &error) != NORMA_DOCUMENT_OK)
        fail_msg("%s", error.message);
    *size = all.size;
    return all.bytes;
}

norma_document *scene_open(const char *path) {
    norma_document *document;
    norma_document_error error;
    if (norma_document_open(path, NULL, &document, &error) != NORMA_DOCUMENT_OK)
        fail_msg("%s", error.message);
    return document;
}

norma_document *scene_reopen(const unsigned char *bytes, size_t size, const char *name) {
    norma_document *document;
    norma_document_error error;
    if (norma_document_open_memory(bytes, size, name, NULL, &document, &error) != NORMA_DOCUMENT_OK)
        fail_msg("%s", error.message);
    return document;
}

norma_document *scene_of_obj(const char *text) {
    return scene_reopen((const unsigned char *)text, strlen(text), "a.obj");
}

double scene_largest(const drawn_scene *scene) {
    double largest = 0;
    for (size_t i = 0; i < scene->count; ++i)
        for (int k = 0; k < 9; ++k)
            largest = fmax(largest, fabs(scene->triangles[i].position[k / 3][k % 3]));
    return largest;
}

void scene_facet_normal(const scene_triangle *triangle, double normal[3]) {
    double a[3], b[3];
    for (int k = 0; k < 3; ++k) {
        a[k] = triangle->position[1][k] - triangle->position[0][k];
        b[k] = triangle->position[2][k] - triangle->position[0][k];
    }
    cross(a, b, normal);
    normalise(normal);
}

double scene_angle_deg(const double a[3], const double b[3]) {
    double c[3];
    cross(a, b, c);
    return atan2(length(c), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 57.29577951308232;
}
