/* test_coincidences.c: small meshes in which everything that can coincide does: positions on a
 * lattice of four, faces that are there twice or back to back, polygons that run twice along an
 * edge, bend or have no area, hard marks, groups, tetrahedra with faces turned. Normals, counts of
 * edges, fans, split meshes, plans and orientation against the oracle. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/compare.h"
#include "oracle/judge.h"
#include "oracle/shapes.h"

enum { SEEDS = 12000 / SLOWER, MOST_CORNERS = 8, MOST_FACES = 40 };

typedef struct case_mesh {
    mesh_file file;
    norma_mesh view;
    uint32_t groups[MOST_FACES];
    uint8_t hard[MOST_FACES * MOST_CORNERS];
} case_mesh;

static uint32_t below(uint64_t *state, uint32_t count) { return shape_random(state) % count; }

static void add_positions(mesh_file *mesh, uint64_t *state, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
        const double x = below(state, 4), y = below(state, 4), z = below(state, 4);
        mesh_file_add_position(mesh, x, y, z);
    }
}

/* A face that is there, again: as it is, backwards, beginning elsewhere. */
static void add_again(mesh_file *mesh, uint64_t *state, int backwards) {
    uint32_t corners[MOST_CORNERS];
    const size_t face = below(state, (uint32_t)mesh->face_count), start = mesh->starts[face],
                 count = mesh->starts[face + 1] - start;
    const size_t from = count ? below(state, (uint32_t)count) : 0;
    for (size_t i = 0; i < count; ++i)
        corners[i] = mesh->corners[start + (from + (backwards ? count - i : i)) % count];
    mesh_file_add_face(mesh, corners, count);
}

/* Out to a point and back, once or twice within a polygon. */
static void add_slit(mesh_file *mesh, uint64_t *state, uint32_t positions) {
    uint32_t c[MOST_CORNERS];
    for (size_t i = 0; i < 5; ++i) c[i] = below(state, positions);
    const uint32_t slit[] = {c[0], c[1], c[2], c[0], c[3], c[4], c[3]};
    mesh_file_add_face(mesh, slit, below(state, 2) ? 7 : 6);
}

static void add_any(mesh_file *mesh, uint64_t *state, uint32_t positions, int polygons) {
    uint32_t c[MOST_CORNERS];
    const uint32_t count = polygons ? below(state, 7) : 3;
    for (uint32_t i = 0; i < count; ++i) c[i] = below(state, positions);
    mesh_file_add_face(mesh, c, count);
}

/* Four points of their own, some faces turned. */
static void add_tetrahedron(mesh_file *mesh, uint64_t *state, double far) {
    static const uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const uint32_t first = (uint32_t)mesh->position_count;
    for (uint32_t i = 0; i < 4; ++i) {
        const double x = below(state, 4), y = below(state, 4), z = below(state, 4);
        mesh_file_add_position(mesh, far + x, y, z);
    }
    for (uint32_t f = 0; f < 4; ++f) {
        const uint32_t turn = below(state, 3) == 0, *c = faces[f];
        mesh_file_add_face(
            mesh, (uint32_t[]){first + c[0], first + c[1 + turn], first + c[2 - turn]}, 3);
    }
}

static void make(case_mesh *m, uint64_t *state) {
    const int polygons = (int)below(state, 2), closed = below(state, 3) == 0;
    const uint32_t positions = 4 + below(state, 6), faces = 2 + below(state, 9);
    memset(m, 0, sizeof *m);
    add_positions(&m->file, state, positions);
    for (uint32_t i = 0; i < 2 && closed; ++i) add_tetrahedron(&m->file, state, 10 + 10.0 * i);
    for (uint32_t f = 0; f < faces; ++f) {
        const uint32_t kind = below(state, 8);
        if (kind < 2 && m->file.face_count)
            add_again(&m->file, state, (int)kind);
        else if (kind == 2 && polygons)
            add_slit(&m->file, state, positions);
        else
            add_any(&m->file, state, positions, polygons);
    }
    m->view = polygons ? mesh_file_view_polygons(&m->file) : mesh_file_view(&m->file);
    for (size_t f = 0; f < m->file.face_count; ++f) m->groups[f] = below(state, 4);
    for (size_t c = 0; c < m->file.corner_count; ++c) m->hard[c] = below(state, 8) == 0;
    if (below(state, 4) == 0) m->view.smoothing_groups = m->groups;
    if (below(state, 4) == 0) m->view.hard_edges = m->hard;
}

static size_t judge(uint64_t seed) {
    static const float creases[] = {0, 0.5F, 1.04719755F, 1.57079637F, 3.14159274F};
    uint64_t state = seed;
    case_mesh m;
    char name[40];
    comparison total = {0};
    oracle o;
    make(&m, &state);
    snprintf(name, sizeof name, "seed %llu", (unsigned long long)seed);
    const norma_options options = {.struct_size = sizeof options,
        .weight = (norma_weight)below(&state, 7),
        .weld = below(&state, 4) ? NORMA_WELD_EXACT : NORMA_WELD_NONE,
        .non_manifold = below(&state, 2) ? NORMA_NON_MANIFOLD_SMOOTH : NORMA_NON_MANIFOLD_HARD,
        .threads = 1 + below(&state, 2)};
    const float crease = creases[below(&state, 5)];
    oracle_create(&o, &m.view, options.weld, 0);
    compare_faces(&total, name, &o, &m.view, &options);
    compare_vertices(&total, name, &o, &m.view, &options, 1);
    compare_corners(&total, name, &o, &m.view, crease, &options);
    const size_t wrong = total.wrong + judge_split(name, &m.view, crease, &options) +
                         judge_plans(name, &o, &m.view, crease, &options) +
                         judge_orientation(name, &o, &m.view, &options);
    oracle_destroy(&o);
    mesh_file_free(&m.file);
    return wrong;
}

static void coincidences(void **state) {
    (void)state;
    size_t wrong = 0;
    for (uint64_t seed = 1; seed <= SEEDS && wrong < 20; ++seed) wrong += judge(seed);
    assert_int_equal(wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(coincidences)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
