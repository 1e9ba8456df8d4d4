/* test_normals_random.c: thousands of small, nasty meshes on a coarse lattice (so that degenerate
 * faces, equal positions, twins, edges of many faces and exact ties are common), and damaged grids
 * and spheres; every answer, reason and report compared with the oracle's. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/compare.h"
#include "oracle/shapes.h"

typedef struct extras {
    uint8_t hard[8192];
    uint32_t groups[4096];
} extras;

static int chance(uint64_t *seed, uint32_t in) { return shape_random(seed) % in == 0; }

static void lattice_mesh(mesh_file *mesh, uint64_t *seed) {
    const uint32_t positions = 4 + shape_random(seed) % 9, faces = 1 + shape_random(seed) % 12,
                   side = 2 + shape_random(seed) % 3, polygons = shape_random(seed) % 3;
    for (uint32_t i = 0; i < positions; ++i) {
        double p[3];
        for (int x = 0; x < 3; ++x)
            p[x] = (double)(shape_random(seed) % side) * (chance(seed, 4) ? -1 : 1);
        if (chance(seed, 60))
            p[shape_random(seed) % 3] = chance(seed, 2) ? (double)NAN : (double)INFINITY;
        mesh_file_add_position(mesh, p[0], p[1], p[2]);
    }
    for (uint32_t f = 0; f < faces; ++f) {
        uint32_t corners[8];
        const uint32_t count = polygons
                                   ? (chance(seed, 20) ? shape_random(seed) % 3
                                                       : 3 + shape_random(seed) % (2 * polygons))
                                   : 3;
        for (uint32_t i = 0; i < count; ++i) corners[i] = shape_random(seed) % positions;
        mesh_file_add_face(mesh, corners, count);
    }
}

static void copy_face(mesh_file *mesh, size_t face, int reversed, uint32_t from) {
    uint32_t corners[16];
    const size_t count = mesh->starts[face + 1] - mesh->starts[face];
    for (size_t i = 0; i < count && i < 16; ++i)
        corners[i] = mesh->corners[mesh->starts[face] +
                                   (reversed ? count - 1 - i + from : i + from) % count];
    mesh_file_add_face(mesh, corners, count);
}

/* A sphere or a grid, with faces doubled, twinned and turned, vertices moved onto their neighbours
 * or into the middle between two. */
static void damaged_mesh(mesh_file *mesh, uint64_t *seed) {
    const int kind = (int)(shape_random(seed) % 4);
    if (kind == 0) shape_uv_sphere(mesh, 6, 4, chance(seed, 2), chance(seed, 2));
    if (kind == 1) shape_wavy_grid(mesh, 4, chance(seed, 2));
    if (kind == 2) shape_pole_sphere(mesh, 6, 4, chance(seed, 2));
    if (kind == 3) shape_box(mesh, 4, 4, 1, chance(seed, 2));
    shape_round_to_float(mesh);
    const size_t faces = mesh->face_count;
    for (size_t f = 0; f < faces; ++f) {
        if (chance(seed, 8)) copy_face(mesh, f, 1, shape_random(seed) % 4);
        if (chance(seed, 20)) copy_face(mesh, f, 0, shape_random(seed) % 4);
    }
    for (size_t v = 0; v < mesh->position_count; ++v) {
        const double *a = mesh->positions[shape_random(seed) % mesh->position_count],
                     *b = mesh->positions[shape_random(seed) % mesh->position_count];
        if (chance(seed, 12)) memcpy(mesh->positions[v], a, sizeof *mesh->positions);
        if (chance(seed, 12))
            for (int x = 0; x < 3; ++x) mesh->positions[v][x] = (a[x] + b[x]) / 2;
    }
}

/* A book: some 150 pages on one edge, bound either way, in clumps of angles; bent quads, twins,
 * pages of no area and closed slits among them. */
static void book_mesh(mesh_file *mesh, uint64_t *seed) {
    const double bend = 0.2 + 0.05 * (double)(shape_random(seed) % 20);
    mesh_file_add_position(mesh, 0, 0, 0);
    mesh_file_add_position(mesh, 0, 0, 2);
    for (uint32_t f = 0; f < 150; ++f) {
        const double angle =
                         bend * (double)(shape_random(seed) % 31) + 1e-4 * shape_random_unit(seed),
                     lean = chance(seed, 10) ? shape_random_unit(seed) : 0;
        const uint32_t back = (uint32_t)chance(seed, 2), at = (uint32_t)mesh->position_count;
        mesh_file_add_position(mesh, cos(angle), sin(angle), 1 + shape_random_unit(seed));
        if (chance(seed, 30))
            mesh_file_add_position(mesh, 0, 0, 1);
        else
            mesh_file_add_position(
                mesh, cos(angle + lean), sin(angle + lean), shape_random_unit(seed));
        if (chance(seed, 12))
            mesh_file_add_face(mesh, (uint32_t[]){back, 1 - back, at, at + 1}, 4);
        else if (chance(seed, 40))
            mesh_file_add_face(mesh, (uint32_t[]){0, 1, at, 1, 0, at + 1}, 6);
        else
            mesh_file_add_face(mesh, (uint32_t[]){back, 1 - back, at + shape_random(seed) % 2}, 3);
        if (chance(seed, 8)) copy_face(mesh, mesh->face_count - 1, 1, 1);
    }
}

/* Some hundred triangles round one vertex, most in order, as a cone with folds; twins, copies,
 * turned and torn ones, fins on one edge, and some without area. */
static void hub_mesh(mesh_file *mesh, uint64_t *seed) {
    const uint32_t around = 66 + shape_random(seed) % 120, faces = around + shape_random(seed) % 60,
                   fold = 1 + shape_random(seed) % 40;
    mesh_file_add_position(mesh, 0, 0, chance(seed, 12) ? (double)NAN : 0.5);
    for (uint32_t i = 0; i < around; ++i) {
        const double angle = 6.283185307179586 * i / around, *before = mesh->positions[i];
        if (chance(seed, 40))
            mesh_file_add_position(mesh, before[0], before[1], before[2]);
        else
            mesh_file_add_position(mesh, cos(angle), sin(angle), i % fold ? 0 : 0.3);
    }
    for (uint32_t f = 0; f < faces; ++f) {
        const uint32_t at = chance(seed, 20) ? shape_random(seed) % around : f % around, a = 1 + at,
                       b = chance(seed, 12) ? shape_random(seed) % (around + 1)
                                            : 1 + (at + 1) % around;
        const uint32_t turn = shape_random(seed) % 3, corners[3] = {0, chance(seed, 15) ? 1 : a, b};
        mesh_file_add_face(
            mesh, (uint32_t[]){corners[turn], corners[(turn + 1) % 3], corners[(turn + 2) % 3]}, 3);
        if (chance(seed, 12))
            copy_face(mesh, mesh->face_count - 1, chance(seed, 2), shape_random(seed) % 3);
    }
}

static size_t compare_random(const char *name, void make(mesh_file *, uint64_t *), uint64_t seed) {
    static const norma_weld welds[] = {NORMA_WELD_EXACT, NORMA_WELD_NONE, NORMA_WELD_DISTANCE};
    mesh_file mesh = {0};
    extras *more = test_calloc(1, sizeof *more);
    char text[80];
    snprintf(text, sizeof text, "%s %llu", name, (unsigned long long)seed);
    make(&mesh, &seed);
    norma_mesh view = mesh_file_view(&mesh);
    if (chance(&seed, 3)) {
        for (size_t i = 0; i < mesh.corner_count; ++i) more->hard[i] = (uint8_t)chance(&seed, 4);
        view.hard_edges = more->hard;
    }
    if (chance(&seed, 3)) {
        for (size_t i = 0; i < mesh.face_count; ++i) more->groups[i] = shape_random(&seed) % 4;
        view.smoothing_groups = more->groups;
    }
    const norma_weld weld = welds[shape_random(&seed) % 3];
    float *floats = test_calloc(3 * mesh.position_count + 1, sizeof *floats);
    const size_t wrong = compare_everything(text, &view, weld, 1);
    if (chance(&seed, 2)) {
        view.face_starts = mesh_file_view_polygons(&mesh).face_starts;
        view.face_count = mesh.face_count;
    }
    if (chance(&seed, 2)) view.positions = mesh_file_view_float(&mesh, floats).positions;
    const size_t wrong_float = compare_everything(text, &view, weld, 1);
    test_free(floats);
    test_free(more);
    mesh_file_free(&mesh);
    return wrong + wrong_float;
}

static void lattices(void **state) {
    (void)state;
    size_t wrong = 0;
    for (uint64_t seed = 1; seed <= 1000 / SLOWER && wrong < 20; ++seed)
        wrong += compare_random("lattice", lattice_mesh, seed);
    assert_int_equal(wrong, 0);
}

static void damaged_surfaces(void **state) {
    (void)state;
    size_t wrong = 0;
    for (uint64_t seed = 1; seed <= 96 / SLOWER && wrong < 20; ++seed)
        wrong += compare_random("damaged", damaged_mesh, seed);
    assert_int_equal(wrong, 0);
}

static void books(void **state) {
    (void)state;
    size_t wrong = 0;
    for (uint64_t seed = 1; seed <= 24 / SLOWER && wrong < 20; ++seed)
        wrong += compare_random("book", book_mesh, seed);
    assert_int_equal(wrong, 0);
}

static void hubs(void **state) {
    (void)state;
    size_t wrong = 0;
    for (uint64_t seed = 1; seed <= 32 / SLOWER && wrong < 20; ++seed)
        wrong += compare_random("hub", hub_mesh, seed);
    assert_int_equal(wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(hubs), cmocka_unit_test(books),
        cmocka_unit_test(lattices), cmocka_unit_test(damaged_surfaces)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
