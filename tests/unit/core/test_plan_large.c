/* test_plan_large.c: plans of meshes that take many tiles, and of those that fit none: fans of
 * thousands of triangles, polygons of thousands of corners. An update of some is one of all; an
 * update of all is norma_vertex_normals and norma_corner_normals wherever the fans are the same at
 * any positions. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

static const float ALL_ANGLES = 3.1415927f;

typedef struct mover {
    mesh_file mesh;
    norma_mesh view;
    float *floats, *out, *all, *other;
    uint8_t *reasons, *all_reasons, *other_reasons;
    uint32_t *moved;
    size_t elements;
} mover;

static void open_mover(mover *m, norma_element of) {
    const size_t room = m->mesh.corner_count + m->mesh.position_count;
    m->floats = test_calloc(3 * m->mesh.position_count, sizeof(float));
    m->view = mesh_file_view_float(&m->mesh, m->floats);
    m->elements = of == NORMA_PER_VERTEX ? m->mesh.position_count : m->mesh.corner_count;
    m->out = test_calloc(3 * room, sizeof(float));
    m->all = test_calloc(3 * room, sizeof(float));
    m->other = test_calloc(3 * room, sizeof(float));
    m->reasons = test_calloc(room, 1);
    m->all_reasons = test_calloc(room, 1);
    m->other_reasons = test_calloc(room, 1);
    m->moved = test_calloc(2 * room, sizeof *m->moved);
}

static void close_mover(mover *m) {
    void *const blocks[] = {m->floats, m->out, m->all, m->other, m->reasons, m->all_reasons,
        m->other_reasons, m->moved};
    for (size_t i = 0; i < COUNT_OF(blocks); ++i) test_free(blocks[i]);
}

/* A wave through everything: equal positions stay equal. */
static void wave(mover *m, float time) {
    for (size_t v = 0; v < m->mesh.position_count; ++v) {
        const double *p = m->mesh.positions[v];
        for (int x = 0; x < 3; ++x)
            m->floats[3 * v + (size_t)x] =
                (float)(p[x] + 0.05 * sin(3 * p[(x + 1) % 3] + (double)time));
    }
}

/* Those within a ball, or a few at random. */
static size_t push(mover *m, uint64_t *seed) {
    const uint32_t kind = shape_random(seed) % 4, count = (uint32_t)m->mesh.position_count,
                   centre = shape_random(seed) % count;
    const double reach = kind == 0 ? 1e-9 : kind == 1 ? 0.3 : 1.2;
    size_t moved = 0;
    for (uint32_t v = 0; v < count; ++v) {
        double square = 0;
        for (int x = 0; x < 3; ++x)
            square += pow(m->mesh.positions[v][x] - m->mesh.positions[centre][x], 2);
        if (kind == 3 ? shape_random(seed) % 40 != 0 : square > reach * reach) continue;
        m->moved[moved++] = v;
        if (kind == 2 && v % 7 == 0) m->moved[moved++] = v;
    }
    for (size_t i = 0; i < moved; ++i)
        m->floats[3 * m->moved[i]] += 0.01f * (float)(1 + m->moved[i] % 3);
    return moved;
}

static void assert_same(const mover *m, const char *name, const float *a, const uint8_t *a_reasons,
    const float *b, const uint8_t *b_reasons) {
    for (size_t i = 0; i < m->elements; ++i) {
        if (memcmp(a + 3 * i, b + 3 * i, 12) == 0 && a_reasons[i] == b_reasons[i]) continue;
        fail_msg("%s: element %zu: (%.9g %.9g %.9g) %d, not (%.9g %.9g %.9g) %d", name, i,
            (double)a[3 * i], (double)a[3 * i + 1], (double)a[3 * i + 2], a_reasons[i],
            (double)b[3 * i], (double)b[3 * i + 1], (double)b[3 * i + 2], b_reasons[i]);
    }
}

static norma_result update(const mover *m, const norma_plan *plan, const norma_options *base,
    const uint32_t *moved, size_t count, float *out, uint8_t *reasons) {
    norma_options options = *base;
    options.reasons = reasons;
    return norma_plan_update(
        plan, m->view.positions, moved, count, &options, out, m->elements, NULL);
}

static void check_moving(
    mover *m, const char *name, norma_element of, float crease, norma_weight weight) {
    norma_options options = {.weight = weight};
    norma_plan *plan;
    uint64_t seed = 1 + (uint64_t)weight;
    open_mover(m, of);
    assert_ok(norma_plan_create(&m->view, of, crease, &options, &plan));
    for (int step = 0; step < 6; ++step) {
        options.threads = (uint32_t)step % 3;
        if (step % 2 == 0) wave(m, (float)step);
        assert_ok(update(m, plan, &options, NULL, 0, m->out, m->reasons));
        const size_t moved = push(m, &seed);
        assert_ok(update(m, plan, &options, m->moved, moved, m->out, m->reasons));
        assert_ok(update(m, plan, &options, NULL, 0, m->all, m->all_reasons));
        assert_same(m, name, m->out, m->reasons, m->all, m->all_reasons);
    }
    wave(m, 9);
    assert_ok(update(m, plan, &options, NULL, 0, m->all, m->all_reasons));
    options.reasons = m->other_reasons;
    if (of == NORMA_PER_CORNER && crease > 3)
        assert_ok(norma_corner_normals(&m->view, crease, &options, m->other, m->elements, NULL));
    else if (of == NORMA_PER_VERTEX && crease > 3)
        assert_ok(norma_vertex_normals(&m->view, &options, m->other, m->elements, NULL));
    if (crease > 3) assert_same(m, name, m->all, m->all_reasons, m->other, m->other_reasons);
    norma_plan_destroy(plan);
    close_mover(m);
}

static void check_all_ways(mover *m, const char *name) {
    static const norma_weight weights[] = {
        NORMA_WEIGHT_ANGLE, NORMA_WEIGHT_AREA, NORMA_WEIGHT_MAX, NORMA_WEIGHT_VISIBLE};
    for (size_t w = 0; w < COUNT_OF(weights); ++w)
        for (int of = 0; of < 2; ++of) {
            check_moving(m, name, (norma_element)of, ALL_ANGLES, weights[w]);
            check_moving(m, name, (norma_element)of, 0.1f, weights[w]);
        }
    mesh_file_free(&m->mesh);
}

static void surfaces(void **state) {
    (void)state;
    for (int quads = 0; quads < 2; ++quads) {
        mover m = {0};
        shape_uv_sphere(&m.mesh, 70, 40, 1, quads);
        shape_round_to_float(&m.mesh);
        check_all_ways(&m, "sphere with a seam");
        shape_wavy_grid(&m.mesh, 50, quads);
        check_all_ways(&m, "grid");
    }
}

static void soups(void **state) {
    (void)state;
    mover m = {0};
    mesh_file whole = {0};
    shape_uv_sphere(&whole, 40, 20, 1, 0);
    shape_round_to_float(&whole);
    shape_soup(&m.mesh, &whole);
    mesh_file_free(&whole);
    check_all_ways(&m, "soup");
}

/* More corners at one position than a tile has room for. */
static void wide_fans(void **state) {
    (void)state;
    mover m = {0};
    shape_cone(&m.mesh, 3000, 1.5);
    check_all_ways(&m, "cone");
    shape_cone(&m.mesh, 600, 0.5);
    for (uint32_t i = 1; i + 2 < 600; i += 3)
        mesh_file_add_face(&m.mesh, (uint32_t[]){i, i + 1, i + 2}, 3);
    check_all_ways(&m, "cone with a hem");
    shape_cone(&m.mesh, 600, 0.5);
    for (uint32_t i = 2; i < 600; i += 5)
        mesh_file_add_face(&m.mesh, (uint32_t[]){0, 0, i + 1, i, i},
            5); /* corners that the next one repeats have no vote */
    check_all_ways(&m, "cone with repeated corners");
}

/* A prism whose ends are single polygons, larger than a tile; its sides are quads. */
static void wide_polygons(void **state) {
    (void)state;
    enum { SIDES = 2000 };
    mover m = {0};
    uint32_t *ring = test_calloc(SIDES, sizeof *ring);
    for (int end = 0; end < 2; ++end)
        for (int i = 0; i < SIDES; ++i)
            mesh_file_add_position(&m.mesh, cos(2 * 3.14159265358979 * i / SIDES),
                sin(2 * 3.14159265358979 * i / SIDES), end);
    for (uint32_t i = 0; i < SIDES; ++i) ring[i] = SIDES - 1 - i;
    mesh_file_add_face(&m.mesh, ring, SIDES);
    for (uint32_t i = 0; i < SIDES; ++i) ring[i] = SIDES + i;
    mesh_file_add_face(&m.mesh, ring, SIDES);
    for (uint32_t i = 0; i < SIDES; ++i)
        mesh_file_add_face(
            &m.mesh, (uint32_t[]){i, (i + 1) % SIDES, SIDES + (i + 1) % SIDES, SIDES + i}, 4);
    shape_round_to_float(&m.mesh);
    test_free(ring);
    for (int of = 0; of < 2; ++of) {
        check_moving(&m, "prism", (norma_element)of, ALL_ANGLES, NORMA_WEIGHT_ANGLE);
        check_moving(&m, "prism", (norma_element)of, 0.5f, NORMA_WEIGHT_AREA);
    }
    mesh_file_free(&m.mesh);
}

/* A sheet so large that its plan lends the marks of what moved: what one update marked, the next
 * one does not find. */
static size_t written_by(const norma_plan *plan, const norma_vec3_view positions,
    const uint32_t moved[2], float *out, size_t count) {
    size_t written = 0;
    for (size_t i = 0; i < 3 * count; ++i) out[i] = 7;
    assert_int_equal(
        norma_plan_update(plan, positions, moved, 2, NULL, out, count, NULL), NORMA_OK);
    for (size_t v = 0; v < count; ++v) written += out[3 * v] != 7;
    assert_true(out[3 * (size_t)moved[0]] != 7 && out[3 * (size_t)moved[1]] != 7);
    return written;
}

static void marks(void **state) {
    enum { SIDE = 400, COUNT = SIDE * SIDE, CORNERS = 6 * (SIDE - 1) * (SIDE - 1) };
    (void)state;
    float *positions = test_calloc(3 * (size_t)COUNT, sizeof(float)),
          *out = test_calloc(3 * (size_t)COUNT, sizeof(float));
    uint32_t *corners = test_calloc(CORNERS, sizeof *corners), *corner = corners;
    norma_plan *plan = NULL;
    for (uint32_t v = 0; v < COUNT; ++v) {
        positions[3 * (size_t)v] = (float)(v % SIDE);
        positions[3 * (size_t)v + 1] = (float)(v / SIDE);
        if (v % SIDE == SIDE - 1 || v / SIDE == SIDE - 1) continue;
        const uint32_t at[] = {v, v + 1, v + SIDE + 1, v, v + SIDE + 1, v + SIDE};
        memcpy(corner, at, sizeof at);
        corner += 6;
    }
    const norma_mesh mesh = {.positions = {positions, COUNT, 0, NORMA_FORMAT_FLOAT},
        .corners = corners,
        .corner_count = CORNERS};
    assert_int_equal(norma_plan_create(&mesh, NORMA_PER_VERTEX, 3.1415927F, NULL, &plan), NORMA_OK);
    for (uint32_t row = SIDE / 2 - 20; row > 66; row -= 66) {
        const uint32_t far = SIDE - 1 - row,
                       both[] = {row * SIDE + row,
                           far * SIDE + far}; /* between them all that were marked before */
        assert_int_equal(written_by(plan, mesh.positions, both, out, COUNT), 14);
    }
    norma_plan_destroy(plan);
    test_free(positions);
    test_free(out);
    test_free(corners);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(surfaces), cmocka_unit_test(soups),
        cmocka_unit_test(wide_fans), cmocka_unit_test(wide_polygons), cmocka_unit_test(marks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
