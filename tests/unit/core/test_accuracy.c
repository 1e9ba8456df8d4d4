/* test_accuracy.c: on every mesh of the data set and of assets/: face normals within 1e-7 rad of
 * the exact direction, vertex normals within 2e-7 rad of the exact weighted sum (where |sum| > 1e-3
 * of the sum of weights) for every weight, corner normals over the oracle's fans for creases of 0,
 * 30, 60 and 180 degrees. OBJ, PLY and STL are read by the tests' own loader, glTF primitives
 * through the documents. Prints the table of worst angles. Of large meshes every n-th vertex is
 * compared. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/compare.h"
#include "oracle/shapes.h"
#include <norma/document.h>

enum {
    WEIGHTS = 7,
    CREASES = 4,
    VERTEX_SAMPLE = 6000 / SLOWER,
    LARGEST = SLOWER > 1 ? 60000 : 400000
};
static const float creases[CREASES] = {0, 0.523598776f, 1.04719755f, 3.14159274f};

typedef struct table {
    size_t files, meshes, faces, unread;
    comparison face, vertex[WEIGHTS], corner[CREASES];
} table;

static void compare_mesh(table *t, const char *name, const norma_mesh *mesh) {
    oracle o;
    norma_options options = {.threads = 2};
    if (mesh->corner_count > LARGEST && SLOWER > 1) return;
    oracle_create(&o, mesh, NORMA_WELD_EXACT, 0);
    const size_t every = 1 + o.position_count / VERTEX_SAMPLE;
    ++t->meshes;
    t->faces += o.face_count;
    compare_faces(&t->face, name, &o, mesh, &options);
    for (int w = 0; w < WEIGHTS; ++w) {
        options.weight = (norma_weight)w;
        compare_vertices(&t->vertex[w], name, &o, mesh, &options, every);
    }
    options.weight = NORMA_WEIGHT_ANGLE;
    for (int i = 0; i < CREASES; ++i)
        compare_corners(&t->corner[i], name, &o, mesh, creases[i], &options);
    oracle_destroy(&o);
}

/* As floats, which is what most files hold, and as the doubles that stand there where they are
 * more. */
static void compare_file(table *t, const char *path, const char *name) {
    mesh_file mesh;
    if (mesh_file_load(path, &mesh)) {
        ++t->unread;
        return;
    }
    float *floats = test_calloc(3 * mesh.position_count + 1, sizeof *floats);
    norma_mesh view = mesh_file_view_float(&mesh, floats);
    compare_mesh(t, name, &view);
    int floats_suffice = 1;
    for (size_t i = 0; i < 3 * mesh.position_count; ++i)
        floats_suffice &= (double)floats[i] == ((double *)mesh.positions)[i] || isnan(floats[i]);
    if (!floats_suffice) {
        oracle o;
        view = mesh_file_view(&mesh);
        oracle_create(&o, &view, NORMA_WELD_EXACT, 0);
        compare_faces(&t->face, name, &o, &view, NULL);
        compare_vertices(
            &t->vertex[0], name, &o, &view, NULL, 1 + o.position_count / VERTEX_SAMPLE);
        oracle_destroy(&o);
    }
    test_free(floats);
    mesh_file_free(&mesh);
}

static void compare_document(table *t, const char *path, const char *name) {
    norma_document *document = NULL;
    if (norma_document_open(path, NULL, &document, NULL)) {
        ++t->unread;
        return;
    }
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) {
        norma_mesh_info info;
        norma_mesh_data data;
        if (norma_document_mesh_info(document, i, &info) || info.not_read ||
            norma_document_mesh_data(document, i, &data, NULL))
            continue;
        compare_mesh(t, name, &data.mesh);
    }
    norma_document_close(document);
}

static void visit(void *user, const char *path, const char *name) {
    table *t = user;
    const char *dot = strrchr(path, '.');
    ++t->files;
    if (dot && (!strcmp(dot, ".gltf") || !strcmp(dot, ".glb")))
        compare_document(t, path, name);
    else
        compare_file(t, path, name);
}

static void print_row(const char *what, const comparison *c) {
    printf("# %-24s %9zu compared  %7zu in doubt  %3zu wrong  worst %.3Le rad\n", what, c->elements,
        c->doubtful, c->wrong, c->worst);
}

static void report(const table *t) {
    size_t wrong = t->face.wrong;
    printf("# %zu files, %zu of them not read, %zu meshes, %zu faces\n", t->files, t->unread,
        t->meshes, t->faces);
    print_row("faces", &t->face);
    for (int w = 0; w < WEIGHTS; ++w) {
        char what[40];
        snprintf(what, sizeof what, "vertices, %s", norma_weight_name((norma_weight)w));
        print_row(what, &t->vertex[w]);
        wrong += t->vertex[w].wrong;
    }
    for (int i = 0; i < CREASES; ++i) {
        char what[40];
        snprintf(what, sizeof what, "corners, crease %.0f", (double)creases[i] * DEGREES);
        print_row(what, &t->corner[i]);
        wrong += t->corner[i].wrong;
    }
    assert_int_equal(wrong, 0);
}

static void data_set(void **state) {
    (void)state;
    const char *folder = data_folder();
    table t = {0};
    if (!folder) skip();
    data_for_each(folder, visit, &t);
    report(&t);
    assert_true(t.meshes > 300);
}

static void committed_meshes(void **state) {
    (void)state;
    static const char *const names[] = {
        "dodecahedron.obj", "box-rotated.obj", "concave-66gon.obj", "spider.stl"};
    table t = {0};
    for (size_t i = 0; i < COUNT_OF(names); ++i) {
        char path[600];
        snprintf(path, sizeof path, "%s/%s", assets_folder(), names[i]);
        visit(&t, path, names[i]);
    }
    report(&t);
    assert_int_equal(t.unread, 0);
}

static void made_meshes(void **state) {
    (void)state;
    table t = {0};
    for (int i = 0; i < 6; ++i) {
        mesh_file mesh = {0};
        if (i == 0) shape_uv_sphere(&mesh, 48, 24, 1, 1);
        if (i == 1) shape_wavy_grid(&mesh, 40, 1);
        if (i == 2) shape_octahedron_sphere(&mesh, 16);
        if (i == 3) shape_pole_sphere(&mesh, 40, 20, 0);
        if (i == 4) shape_cone(&mesh, 500, 20);
        if (i == 5) shape_box(&mesh, 1, 1e-5, 1e5, 0);
        const double turn[9] = {.36, .48, -.8, -.8, .6, 0, .48, .64, .6};
        shape_map(&mesh, turn);
        float *floats = test_calloc(3 * mesh.position_count, sizeof *floats);
        norma_mesh view = mesh_file_view_float(&mesh, floats);
        compare_mesh(&t, "made, float", &view);
        view = mesh_file_view(&mesh);
        compare_mesh(&t, "made, double", &view);
        for (size_t v = 0; v < mesh.position_count; ++v)
            for (int x = 0; x < 3; ++x)
                mesh.positions[v][x] +=
                    1e6 *
                    (x + 1); /* far away: what is left of the shape is rough, and no less exact */
        view = mesh_file_view_float(&mesh, floats);
        compare_mesh(&t, "made, far, float", &view);
        test_free(floats);
        mesh_file_free(&mesh);
    }
    report(&t);
}

/* Slivers: triangles whose height is a few units in the last place of their length, anywhere. */
static void slivers(void **state) {
    (void)state;
    table t = {0};
    mesh_file mesh = {0};
    uint64_t seed = 17;
    for (uint32_t f = 0; f < 20000; ++f) {
        const double far = ldexp(1, (int)(shape_random(&seed) % 60) - 30),
                     length = ldexp(1, (int)(shape_random(&seed) % 40) - 20),
                     s = shape_random_unit(&seed);
        double p[3], d[3];
        for (int x = 0; x < 3; ++x) p[x] = far * shape_random_unit(&seed);
        for (int x = 0; x < 3; ++x) d[x] = length * shape_random_unit(&seed);
        mesh_file_add_position(&mesh, p[0], p[1], p[2]);
        mesh_file_add_position(&mesh, p[0] + d[0], p[1] + d[1], p[2] + d[2]);
        mesh_file_add_position(&mesh, p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]);
        mesh_file_add_face(&mesh, (uint32_t[]){3 * f, 3 * f + 1, 3 * f + 2}, 3);
    }
    float *floats = test_calloc(3 * mesh.position_count, sizeof *floats);
    norma_mesh view = mesh_file_view_float(&mesh, floats);
    compare_mesh(&t, "slivers, float", &view);
    view = mesh_file_view(&mesh);
    compare_mesh(&t, "slivers, double", &view);
    report(&t);
    test_free(floats);
    mesh_file_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(committed_meshes),
        cmocka_unit_test(made_meshes), cmocka_unit_test(slivers), cmocka_unit_test(data_set)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
