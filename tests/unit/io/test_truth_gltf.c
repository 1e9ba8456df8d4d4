/* test_truth_gltf.c: glTF files whose normals another program wrote, by a rule that is known
 * (LICENSES.md of the data set, "Ground truth"): Blender's smooth spheres by the angle at each
 * corner, equal positions shared; exporters' solids by their facets. */
#include "check.h"
#include <norma/document.h>

enum { MOST_VERTICES = 20000 };

typedef enum rule { BY_ANGLE, BY_FACET } rule;
typedef struct truth {
    const char *file;
    rule rule;
    double tolerance_deg;
} truth;

static const truth truths[] = {
    {"gltf/blender/01_sphere/01_sphere.gltf", BY_ANGLE, 0.01},
    {"gltf/blender/01_metallic_sphere/01_metallic_sphere.gltf", BY_ANGLE, 0.01},
    {"gltf/blender/01_single_vs_double_sided/01_single_vs_double_sided.gltf", BY_ANGLE, 0.01},
    {"gltf/misc/shapes.glb", BY_FACET, 0.01},
    {"gltf/misc/no-indices.glb", BY_FACET, 0.01},
    {"gltf/misc/nonuniform-nested.glb", BY_FACET, 0.01},
    {"gltf/khronos/Box/Box.gltf", BY_FACET, 0.01},
    {"gltf/khronos/BoxInterleaved/BoxInterleaved.gltf", BY_FACET, 0.01},
};

static uint32_t corner_of(const norma_mesh *mesh, size_t corner) {
    if (!mesh->corners) return (uint32_t)corner;
    assert_true(mesh->corner_size == 0 || mesh->corner_size == 4);
    return ((const uint32_t *)mesh->corners)[corner];
}

static void stored_normal(const norma_mesh_data *data, uint32_t vertex, double normal[3]) {
    float n[3];
    const size_t stride = data->normals.stride ? data->normals.stride : sizeof n;
    memcpy(n, (const char *)data->normals.data + vertex * stride, sizeof n);
    for (int k = 0; k < 3; ++k) normal[k] = (double)n[k];
}

/* Returns how many normals were compared. */
static size_t compare(const norma_mesh_data *data, const truth *t) {
    static float normals[MOST_VERTICES][3];
    const size_t count =
        t->rule == BY_ANGLE ? data->mesh.positions.count : data->mesh.corner_count / 3;
    size_t compared = 0;
    assert_true(count <= MOST_VERTICES && data->normals.count == data->mesh.positions.count);
    if (t->rule == BY_ANGLE)
        assert_ok(norma_vertex_normals(&data->mesh, NULL, normals[0], MOST_VERTICES, NULL));
    else
        assert_ok(norma_face_normals(&data->mesh, NULL, normals[0], MOST_VERTICES, NULL));
    for (size_t c = 0; c < data->mesh.corner_count; ++c) {
        const uint32_t vertex = corner_of(&data->mesh, c);
        const float *ours = normals[t->rule == BY_ANGLE ? vertex : c / 3];
        double theirs[3];
        stored_normal(data, vertex, theirs);
        if (ours[0] == 0 && ours[1] == 0 && ours[2] == 0)
            continue; /* a triangle without area, at a pole */
        assert_direction(ours, theirs[0], theirs[1], theirs[2], t->tolerance_deg);
        ++compared;
    }
    return compared;
}

static void normals_are_those_that_were_written(void **state) {
    const truth *t = *state;
    const char *data_folder = getenv("NORMA_DATA") ? getenv("NORMA_DATA") : "../shared/data";
    char path[1000];
    norma_document *document;
    norma_document_error error;
    size_t compared = 0;
    snprintf(path, sizeof path, "%s/%s", data_folder, t->file);
    FILE *there = fopen(path, "rb");
    if (!there) skip();
    fclose(there);
    if (norma_document_open(path, NULL, &document, &error) != NORMA_DOCUMENT_OK)
        fail_msg("%s", error.message);
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) {
        norma_mesh_data data;
        assert_int_equal(norma_document_mesh_data(document, i, &data, &error), NORMA_DOCUMENT_OK);
        compared += compare(&data, t);
    }
    norma_document_close(document);
    assert_true(compared > 0);
}

int main(void) {
    struct CMUnitTest tests[COUNT_OF(truths)];
    for (size_t i = 0; i < COUNT_OF(truths); ++i)
        tests[i] = (struct CMUnitTest){truths[i].file, normals_are_those_that_were_written, NULL,
            NULL, (void *)(uintptr_t)&truths[i]};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
