/* test_smooth_fans.c: corner normals find smooth positions by their sums
 * (core/vertex/face_chain.h); norma_split makes a star of every position. Both must give the same
 * bits and the same edges, on meshes that are smooth nearly everywhere, and on such that only look
 * so: all faces given twice, given once more the other way round, cones that meet at their tips, a
 * turn of more than 360 degrees. */
#include "check.h"
#include "oracle/shapes.h"

static const float CREASES[] = {0.3F, 0.6F, 1.0472F, 2, 3.14159274F};
enum { CREASE_COUNT = sizeof CREASES / sizeof *CREASES };

static void compare(const norma_mesh *mesh, float crease, uint32_t threads) {
    const size_t count = mesh->corner_count;
    float *wanted = test_malloc(12 * count), *given = test_malloc(12 * count);
    uint32_t *corners = test_malloc(4 * count), *sources = test_malloc(4 * count);
    size_t made;
    norma_edges edges[2] = {{0}, {0}};
    norma_report report[2];
    norma_options options = {.threads = threads, .edges = &edges[0]};
    assert_ok(norma_split(
        mesh, crease, &options, corners, count, sources, wanted, count, &made, &report[0]));
    options.edges = &edges[1];
    assert_ok(norma_corner_normals(mesh, crease, &options, given, count, &report[1]));
    for (size_t c = 0; c < count; ++c)
        assert_memory_equal(wanted + 3 * (size_t)corners[c], given + 3 * c, 12);
    assert_memory_equal(&edges[0], &edges[1], sizeof edges[0]);
    assert_int_equal(report[0].non_manifold_edges.count, report[1].non_manifold_edges.count);
    assert_int_equal(report[0].degenerate_faces.count, report[1].degenerate_faces.count);
    test_free(wanted);
    test_free(given);
    test_free(corners);
    test_free(sources);
}

static void compare_all(const norma_mesh *mesh) {
    for (int i = 0; i < CREASE_COUNT; ++i)
        for (uint32_t threads = 1; threads < 4; threads += 2) compare(mesh, CREASES[i], threads);
}

/* Its faces from the last to the first, every third one first: chains grow at both ends and meet.
 */
static void reorder(mesh_file *mesh) {
    uint32_t *to = test_malloc(4 * mesh->corner_count);
    size_t at = 0;
    for (size_t third = 0; third < 3; ++third)
        for (size_t f = mesh->face_count; f-- > 0;)
            if (f % 3 == third) memcpy(to + 3 * at++, mesh->corners + 3 * f, 12);
    memcpy(mesh->corners, to, 4 * mesh->corner_count);
    test_free(to);
}

static void smooth_meshes(void **state) {
    (void)state;
    for (int shape = 0; shape < 3; ++shape) {
        mesh_file mesh = {0};
        if (shape == 0) shape_octahedron_sphere(&mesh, 5);
        if (shape == 1) shape_wavy_grid(&mesh, 60, 0);
        if (shape == 2) shape_wavy_grid(&mesh, 12, 0);
        norma_mesh view = mesh_file_view(&mesh);
        compare_all(&view);
        reorder(&mesh);
        compare_all(&view);
        mesh_file_free(&mesh);
    }
}

/* Every edge has two faces on either side, so no normal is but its own face's. */
static void all_faces_twice(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 40, 0);
    norma_mesh view = mesh_file_view(&mesh);
    const size_t count = view.corner_count, faces = count / 3;
    uint32_t *twice = test_malloc(8 * count);
    float *normals = test_malloc(24 * count), *of_faces = test_malloc(12 * faces);
    memcpy(twice, mesh.corners, 4 * count);
    memcpy(twice + count, mesh.corners, 4 * count);
    assert_ok(norma_face_normals(&view, NULL, of_faces, faces, NULL));
    view.corners = twice;
    view.corner_count = 2 * count;
    compare_all(&view);
    assert_ok(norma_corner_normals(&view, 2, NULL, normals, 2 * count, NULL));
    for (size_t c = 0; c < 2 * count; ++c)
        for (size_t k = 0; k < 3; ++k)
            if (fabsf(normals[3 * c + k] - of_faces[3 * (c / 3 % faces) + k]) > 1e-6F)
                fail_msg("corner %zu", c);
    for (size_t f = 0; f < faces; ++f) { /* the other way round: double-sided */
        twice[count + 3 * f] = mesh.corners[3 * f + 1];
        twice[count + 3 * f + 1] = mesh.corners[3 * f];
    }
    compare_all(&view);
    test_free(twice);
    test_free(normals);
    test_free(of_faces);
    mesh_file_free(&mesh);
}

/* Sixty faces round the origin, by so many degrees each: one fan that rises a little, or two cones
 * of one tip, one within the other. */
static void turn(double degrees, int cones) {
    enum { FACES = 60 };
    float p[2 * FACES + 3][3] = {{0, 0, 0}};
    uint32_t c[6 * FACES];
    for (int cone = 0; cone < cones; ++cone)
        for (uint32_t i = 0; i <= FACES; ++i) {
            const double a = degrees * i / 57.29577951308232;
            float *at = p[1 + (uint32_t)cone * (FACES + 1) + i];
            at[0] = (float)cos(a);
            at[1] = (float)sin(a);
            at[2] = cones > 1 ? (float)(0.2 * cone + 0.2) : (float)(0.001 * i);
        }
    for (uint32_t i = 0; i < FACES * (uint32_t)cones; ++i) {
        const uint32_t first = 1 + i / FACES * (FACES + 1), at = i % FACES;
        c[3 * i] = 0;
        c[3 * i + 1] = first + at;
        c[3 * i + 2] = cones > 1 && at + 1 == FACES ? first : first + at + 1;
    }
    const norma_mesh mesh = {.positions = {p, 2 * FACES + 3, 0, NORMA_FORMAT_FLOAT},
        .corners = c,
        .corner_count = 3 * FACES * (size_t)cones};
    compare_all(&mesh);
}

static void turns(void **state) {
    (void)state;
    turn(4, 1);
    turn(5.9, 1);
    turn(6.1, 1);
    turn(11, 1);
    turn(6, 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(smooth_meshes),
        cmocka_unit_test(all_faces_twice), cmocka_unit_test(turns)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
