/* test_normals.c: the cases where the field's tools disagree, one test each, against answers known
 * in closed form (FACTS: edge cases). */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

static const float PI_FLOAT = 3.14159274f; /* not below pi */

typedef struct result {
    float normals[3 * 4096];
    uint8_t reasons[4096];
    norma_report report;
    norma_edges edges;
    norma_options options;
} result;

static result *fresh(norma_options options) {
    result *r = test_calloc(1, sizeof *r);
    r->options = options;
    r->options.struct_size = sizeof r->options;
    r->options.reasons = r->reasons;
    r->options.edges = &r->edges;
    return r;
}

static result *faces(norma_mesh mesh) {
    result *r = fresh((norma_options){0});
    assert_ok(norma_face_normals(&mesh, &r->options, r->normals, 4096, &r->report));
    return r;
}

static result *vertices_with(norma_mesh mesh, norma_options options) {
    result *r = fresh(options);
    assert_ok(norma_vertex_normals(&mesh, &r->options, r->normals, 4096, &r->report));
    return r;
}

static result *vertices(norma_mesh mesh, norma_weight weight) {
    return vertices_with(mesh, (norma_options){.weight = weight});
}

static result *corners_with(norma_mesh mesh, double crease_deg, norma_options options) {
    result *r = fresh(options);
    assert_ok(
        norma_corner_normals(&mesh, crease_deg >= 180 ? PI_FLOAT : (float)(crease_deg / DEGREES),
            &r->options, r->normals, 4096, &r->report));
    return r;
}

static result *corners(norma_mesh mesh, double crease_deg) {
    return corners_with(mesh, crease_deg, (norma_options){0});
}

/* Triangles over positions of three floats each. */
#define TRIANGLES(p, c)                                                                            \
    (norma_mesh) {                                                                                 \
        .positions = {p, sizeof(p) / 12, 0, NORMA_FORMAT_FLOAT}, .corners = c,                     \
        .corner_count = COUNT_OF(c)                                                                \
    }

#define at(r, i)              ((r)->normals + 3 * (size_t)(i))
#define assert_same(r, i, j)  assert_memory_equal(at(r, i), at(r, j), 12)
#define assert_other(r, i, j) assert_memory_not_equal(at(r, i), at(r, j), 12)
#define assert_count(counter, n, least)                                                            \
    do {                                                                                           \
        assert_int_equal((counter).count, n);                                                      \
        assert_true((counter).first == (least));                                                   \
    } while (0)

/* ---- polygons */

/* A plus in the plane z = 0, counterclockwise, its first three corners a reflex turn: positions 0
 * to 11; half-width .5, arms to l. */
static void add_plus(mesh_file *mesh, double l) {
    static const double turn[4][4] = {{1, 0, 0, 1}, {0, -1, 1, 0}, {-1, 0, 0, -1}, {0, 1, -1, 0}};
    const double arm[3][2] = {{l, -.5}, {l, .5}, {.5, .5}};
    uint32_t all[12];
    for (uint32_t i = 0; i < 12; ++i) {
        const double *t = turn[i / 3], *p = arm[i % 3];
        mesh_file_add_position(mesh, t[0] * p[0] + t[1] * p[1], t[2] * p[0] + t[3] * p[1], 0);
        all[i] = (i + 1) % 12;
    }
    mesh_file_add_face(mesh, all, 12);
}

static void concave_polygon_points_the_right_way(void **state) {
    (void)state;
    static const double lengths[] = {1.2, 1.5, 2, 3.5}, twice_area[] = {7.6, 10, 14, 26};
    for (size_t i = 0; i < 4; ++i) {
        mesh_file mesh = {0};
        add_plus(&mesh, lengths[i]);
        result *r = faces(mesh_file_view(&mesh));
        assert_direction(at(r, 0), 0, 0, 1, 0);
        test_free(r);
        /* A triangle in the plane x = l, twice whose area is that of the plus, stands on corner 0:
         * area weights must lean 45 degrees there. */
        mesh_file_add_position(&mesh, lengths[i], -.5, twice_area[i]);
        mesh_file_add_position(&mesh, lengths[i], -1.5, 0);
        mesh_file_add_face(&mesh, (uint32_t[]){0, 12, 13}, 3);
        r = vertices(mesh_file_view(&mesh), NORMA_WEIGHT_AREA);
        assert_direction(at(r, 0), 1, 0, 1, 1e-5);
        test_free(r);
        mesh_file_free(&mesh);
    }
}

static void polygon_far_from_the_origin(void **state) {
    (void)state;
    for (double far = 1; far < 8e6; far *= 16) {
        mesh_file mesh = {0};
        uint32_t all[8];
        for (uint32_t i = 0; i < 8;
             ++i) { /* an octagon on the integer lattice: its normal is (1, 2, -1) wherever it is */
            static const int u[8] = {2, 3, 3, 2, 1, 0, 0, 1}, v[8] = {0, 1, 2, 3, 3, 2, 1, 0};
            mesh_file_add_position(&mesh, far + u[i], far + v[i], far + u[i] + 2 * v[i]);
            all[i] = i;
        }
        mesh_file_add_face(&mesh, all, 8);
        float floats[24];
        norma_mesh view = mesh_file_view_float(&mesh, floats);
        for (int x = 0; x < 24; ++x)
            if ((double)floats[x] != ((double *)mesh.positions)[x]) fail_msg("not a float");
        result *r = faces(view);
        assert_direction(at(r, 0), -1, -2, 1, 6e-6);
        test_free(r);
        mesh_file_free(&mesh);
    }
}

static void reflex_corner_weighs_its_interior_angle(void **state) {
    (void)state;
    mesh_file mesh = {0}; /* the floor of an L-shaped room with the two walls of its reflex corner,
                             which is corner 0 */
    static const double p[][3] = {{0, 0, 0}, {0, 2, 0}, {-2, 2, 0}, {-2, -2, 0}, {2, -2, 0},
        {2, 0, 0}, {0, 0, 1}, {2, 0, 1}, {0, 2, 1}};
    for (size_t i = 0; i < COUNT_OF(p); ++i)
        mesh_file_add_position(&mesh, p[i][0], p[i][1], p[i][2]);
    mesh_file_add_face(&mesh, (uint32_t[]){0, 1, 2, 3, 4, 5}, 6);
    mesh_file_add_face(&mesh, (uint32_t[]){0, 5, 7, 6}, 4);
    mesh_file_add_face(&mesh, (uint32_t[]){0, 6, 8, 1}, 4);
    result *r = vertices(mesh_file_view(&mesh), NORMA_WEIGHT_ANGLE);
    assert_direction(at(r, 0), -1, -1, 3, 1e-5);
    test_free(r);
    r = vertices(mesh_file_view(&mesh),
        NORMA_WEIGHT_ANGLE_AREA); /* floor 12 * 3/4 turn, walls 2 * 1/4 each */
    assert_direction(at(r, 0), -4, -4, 72, 1e-5);
    test_free(r);
    r = vertices(
        mesh_file_view(&mesh), NORMA_WEIGHT_ANGLE_LENGTHS); /* 3 * 2 * 2, walls 1 * 2 * 1 */
    assert_direction(at(r, 0), -1, -1, 6, 1e-5);
    test_free(r);
    r = vertices(mesh_file_view(&mesh), NORMA_WEIGHT_MAX); /* 1 / (2 * 2), walls 1 / (2 * 1) */
    assert_direction(at(r, 0), -2, -2, 1, 1e-5);
    test_free(r);
    mesh_file_free(&mesh);
}

/* A sheet with the vector area (-y, 0, 264 + 9 y), and a flap from which the last corner leads to
 * the first: there the edges stand upright, but for tilt, and only exact arithmetic tells which
 * way. Turned by whole numbers, so that nothing is rounded, into directions that doubles do not
 * hold. */
static void upright_corner_is_reflex_exactly(void **state) {
    (void)state;
    static const double turn[3][3] = {{1, 2, 2}, {2, 1, -2}, {-2, 2, -1}};
    static const double tilts[] = {0, 0x1p-50, -0x1p-50};
    static const uint32_t c[] = {0, 1, 2, 3, 4, 5, 6, 0, 7, 8}, starts[] = {0, 7, 10};
    const double eighth = 0.785398163397448310;
    for (size_t i = 0; i < 12 * COUNT_OF(tilts); ++i) {
        const double tilt = tilts[i / 12], y = 1 + (double)(i % 12), z = 264 + 9 * y;
        const double p[9][3] = {{0, 0, 0}, {1, 0, 0}, {8, 8, 0}, {-8, 8, 0}, {-8, -8, 0},
            {0, -y, 0}, {1, tilt, 1}, {0, 1, 0}, {0, 0, 1}};
        const double angle = (tilt < 0 ? 7 : 1) * eighth / sqrt(y * y + z * z),
                     n[3] = {-y * angle + 2 * eighth, 0, z * angle};
        double turned[9][3] = {{0}}, expected[3] = {0};
        for (size_t r = 0; r < 3; ++r)
            for (size_t k = 0; k < 3; ++k) {
                for (size_t v = 0; v < 9; ++v) turned[v][(r + i) % 3] += turn[r][k] * p[v][k];
                expected[(r + i) % 3] += turn[r][k] * n[k];
            }
        const norma_mesh mesh = {.positions = {turned, 9, 0, NORMA_FORMAT_DOUBLE},
            .corners = c,
            .corner_count = 10,
            .face_starts = starts,
            .face_count = 2};
        result *r = vertices(mesh, NORMA_WEIGHT_ANGLE);
        assert_direction(at(r, 0), expected[0], expected[1], expected[2], 1e-5);
        test_free(r);
    }
}

static void repeated_corner_is_one(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -0.0f};
    static const uint32_t c[] = {0, 4, 1, 1, 2, 0, 3, 1, 0, 2, 3, 0, 4}, starts[] = {0, 5, 8, 13};
    const norma_mesh mesh = {.positions = {p, 5, 0, NORMA_FORMAT_FLOAT},
        .corners = c,
        .corner_count = 13,
        .face_starts = starts,
        .face_count = 3};
    result *r = vertices(mesh, NORMA_WEIGHT_ANGLE); /* a corner of a cube: xy upwards, xz towards
                                                       +y, yz twice over its one corner */
    assert_direction(at(r, 0), 1, 1, 1, 1e-5);
    assert_same(r, 0, 4);
    assert_int_equal(r->report.degenerate_faces.count, 0);
    test_free(r);
    r = corners(mesh, 0);
    assert_direction(at(r, 0), 0, 0, 1, 0);
    assert_same(r, 0, 1);
    assert_same(r, 2, 3);
    assert_int_equal(r->reasons[8 + 3], NORMA_REASON_NONE);
    test_free(r);
}

/* ---- faces without a direction */

static void degenerate_face_has_no_vote(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 5, 5, 5};
    static const uint32_t c[] = {0, 1, 3, 0, 1, 2, 0, 0, 1, 4, 4, 4};
    result *r = faces(TRIANGLES(p, c));
    assert_count(r->report.degenerate_faces, 3, 0);
    for (int f = 0; f < 4; ++f)
        assert_int_equal(r->reasons[f], f == 1 ? NORMA_REASON_NONE : NORMA_REASON_DEGENERATE);
    assert_direction(at(r, 1), 0, 0, 1, 0);
    test_free(r);
    for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w) {
        r = vertices(TRIANGLES(p, c), (norma_weight)w);
        for (int v = 0; v < 3; ++v) assert_direction(at(r, v), 0, 0, 1, 0);
        assert_count(r->report.degenerate_faces, 3, 0);
        assert_count(r->report.unreferenced, 2, 3);
        assert_int_equal(r->reasons[3], NORMA_REASON_UNREFERENCED);
        test_free(r);
    }
}

static void collinear_slivers_middle_weighs_nothing(void **state) {
    (void)state; /* corner 1 lies between 0 and 2: its angle is pi, its face has no normal */
    static const float p[] = {0, 0, 0, 1, 1, 1, 2, 2, 2, 1, 2, 1, 1, 1, 2};
    static const uint32_t c[] = {0, 1, 2, 1, 3, 4};
    result *r = vertices(TRIANGLES(p, c), NORMA_WEIGHT_ANGLE);
    assert_direction(at(r, 1), 1, 0, 0, 0);
    assert_count(r->report.unreferenced, 2, 0);
    test_free(r);
}

static void almost_collinear_face_has_an_exact_direction(void **state) {
    (void)
        state; /* a float apart from collinear, far away: the products differ in their last bits */
    static const float p[] = {
        8388608, 8388607, 1, 8388609, 8388608, 2, 8388610, 8388609, 3.0000002f};
    static const uint32_t c[] = {0, 1, 2};
    result *r = faces(TRIANGLES(p, c)); /* a = (1, 1, 1), b = (2, 2, 2 + e): a x b = (e, -e, 0) */
    assert_direction(at(r, 0), 1, -1, 0, 6e-6);
    test_free(r);
}

/* Faces are measured in blocks, those of equally many corners at once: regular polygons of none to
 * ten corners in turn, every other eleven seen from below, each get their own direction. */
static void each_face_of_a_mixed_mesh_has_its_own_normal(void **state) {
    enum { FACES = 300, SIZES = 11, CORNERS = FACES * SIZES };
    static float positions[CORNERS][3];
    static uint32_t starts[FACES + 1], corners[CORNERS];
    uint32_t count = 0;
    size_t degenerate = 0;
    (void)state;
    for (uint32_t f = 0; f < FACES; ++f) {
        const uint32_t n = f % SIZES;
        degenerate += n < 3;
        for (uint32_t k = 0; k < n; ++k, ++count) {
            const double turn = 6.283185307179586 * k / n * (f / SIZES % 2 ? -1 : 1);
            positions[count][0] = (float)(3 * f + cos(turn));
            positions[count][1] = (float)sin(turn);
            corners[count] = count;
        }
        starts[f + 1] = count;
    }
    const norma_mesh mesh = {.positions = {positions, count, 0, NORMA_FORMAT_FLOAT},
        .corners = corners,
        .corner_count = count,
        .face_starts = starts,
        .face_count = FACES};
    result *f = faces(mesh), *v = vertices(mesh, NORMA_WEIGHT_ANGLE);
    assert_int_equal(f->report.degenerate_faces.count, degenerate);
    assert_int_equal(v->report.degenerate_faces.count, degenerate);
    assert_int_equal(v->report.degenerate_faces.first, 0);
    for (uint32_t i = 0; i < FACES; ++i) {
        const float up = i % SIZES < 3 ? 0 : i / SIZES % 2 ? -1 : 1;
        assert_true(f->normals[3 * i + 2] == up);
        for (uint32_t c = starts[i]; c < starts[i + 1]; ++c)
            assert_true(v->normals[3 * c + 2] == up);
    }
    test_free(f);
    test_free(v);
}

static void vertex_without_a_face_gets_the_fallback(void **state) {
    (void)state;
    static const float p[] = {9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 7, 0, 1, 1};
    static const uint32_t c[] = {1, 2, 3, 1, 3, 5};
    static const float zero[3] = {0, 0, 0}, given[3] = {0.25f, -2, 1e30f};
    result *r = vertices(TRIANGLES(p, c), NORMA_WEIGHT_ANGLE);
    assert_memory_equal(at(r, 0), zero, 12);
    assert_memory_equal(at(r, 4), zero, 12);
    assert_count(r->report.unreferenced, 2, 0);
    test_free(r);
    r = vertices_with(TRIANGLES(p, c), (norma_options){.fallback = NORMA_FALLBACK_GIVEN,
                                           .fallback_normal = {given[0], given[1], given[2]}});
    assert_memory_equal(at(r, 0), given, 12);
    assert_memory_equal(at(r, 4), given, 12);
    test_free(r);
    r = vertices_with(TRIANGLES(p, c), (norma_options){.fallback = NORMA_FALLBACK_GIVEN,
                                           .fallback_normal = {-0.0f, -0.0f, -0.0f}});
    assert_memory_equal(at(r, 4), zero, 12);
    test_free(r);
    r = vertices_with(TRIANGLES(p, c), (norma_options){.fallback = NORMA_FALLBACK_NEAREST});
    assert_same(r, 4, 5);
    assert_int_equal(r->reasons[4], NORMA_REASON_UNREFERENCED);
    assert_same(r, 0, 5); /* sqrt(81 + 64 + 64) is the least */
    test_free(r);
}

static void mesh_without_any_normal_stays_zero(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 1, 0, 0, 2, 0, 0}, zero[9] = {0};
    static const uint32_t c[] = {0, 1, 2};
    result *r = vertices_with(TRIANGLES(p, c), (norma_options){.fallback = NORMA_FALLBACK_NEAREST});
    assert_memory_equal(at(r, 0), zero, sizeof zero);
    assert_count(r->report.unreferenced, 3, 0);
    test_free(r);
    r = corners_with(TRIANGLES(p, c), 180, (norma_options){.fallback = NORMA_FALLBACK_NEAREST});
    assert_memory_equal(at(r, 0), zero, sizeof zero);
    test_free(r);
}

static void not_finite_position_poisons_nothing(void **state) {
    (void)state;
    const float bad[] = {NAN, INFINITY, -INFINITY};
    static const uint32_t c[] = {0, 1, 2, 0, 2, 3, 0, 3, 1};
    for (size_t i = 0; i < 9; ++i) {
        float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, -1, -1, 1};
        p[9 + i / 3] = bad[i % 3];
        result *r = vertices(TRIANGLES(p, c), NORMA_WEIGHT_ANGLE);
        for (int v = 0; v < 3; ++v) assert_direction(at(r, v), 0, 0, 1, 0);
        assert_count(r->report.non_finite, 1, 3);
        assert_int_equal(r->report.degenerate_faces.count, 0);
        assert_int_equal(r->reasons[3], NORMA_REASON_NON_FINITE);
        test_free(r);
        r = faces(TRIANGLES(p, c));
        assert_count(r->report.non_finite, 2, 1);
        assert_int_equal(r->report.degenerate_faces.count, 0);
        test_free(r);
        r = corners(TRIANGLES(p, c), 180);
        assert_count(r->report.non_finite, 2, 5);
        assert_direction(at(r, 0), 0, 0, 1, 0);
        assert_int_equal(
            r->reasons[3], NORMA_REASON_UNREFERENCED); /* its edges are hard, it has no direction */
        test_free(r);
    }
}

/* ---- cancelling */

static void opposite_faces_cancel(void **state) {
    (void)state; /* two triangles that meet in one position, back to back; 0 and 5 are there */
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, -1, 0, 0, -0.0f, 0, 0, 0, 0, 0};
    static const uint32_t one[] = {0, 1, 2, 0, 3, 4, 0, 4, 3, 0, 2, 1}, two[] = {0, 1, 2, 5, 4, 3};
    result *r = vertices(TRIANGLES(p, two), NORMA_WEIGHT_ANGLE);
    assert_direction(at(r, 0), 0, 0, 1, 0); /* each by the corners of its own index */
    assert_int_equal(r->reasons[0], NORMA_REASON_NONE);
    assert_int_equal(r->reasons[5], NORMA_REASON_NONE);
    assert_direction(at(r, 5), 0, 0, 1, 180);
    assert_count(r->report.cancelled, 0, SIZE_MAX);
    test_free(r);
    for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w) {
        r = vertices(TRIANGLES(p, one), (norma_weight)w);
        assert_int_equal(r->reasons[0], NORMA_REASON_CANCELLED);
        assert_int_equal(r->reasons[5],
            NORMA_REASON_CANCELLED); /* at a position that faces share, though none names it */
        assert_int_equal(r->reasons[6], NORMA_REASON_CANCELLED);
        assert_count(r->report.cancelled, 7, 0);
        test_free(r);
    }
}

static void own_index_answers_where_the_position_cancels(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0};
    static const uint32_t c[] = {0, 1, 2, 3, 2, 1};
    for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w) {
        result *r = vertices(TRIANGLES(p, c), (norma_weight)w);
        assert_direction(at(r, 0), 0, 0, 1, 0);
        assert_direction(at(r, 3), 0, 0, -1, 0);
        assert_int_equal(r->reasons[1], NORMA_REASON_CANCELLED);
        assert_count(r->report.cancelled, 2, 1);
        test_free(r);
    }
}

/* ---- fans */

/* A strip of two unit squares in four triangles, bent by degrees along y; hinge vertices 0 and 1.
 */
static void add_hinge(mesh_file *mesh, double degrees) {
    const double x = cos(degrees / DEGREES), z = sin(degrees / DEGREES);
    static const uint32_t c[] = {0, 1, 2, 1, 3, 2, 0, 4, 1, 1, 4, 5};
    mesh_file_add_position(mesh, 0, 0, 0);
    mesh_file_add_position(mesh, 0, 1, 0);
    mesh_file_add_position(mesh, -1, 0, 0);
    mesh_file_add_position(mesh, -1, 1, 0);
    mesh_file_add_position(mesh, x, 0, -z);
    mesh_file_add_position(mesh, x, 1, -z);
    for (int f = 0; f < 4; ++f) mesh_file_add_face(mesh, c + 3 * f, 3);
}

static void dihedral_at_the_threshold_is_smooth(void **state) {
    (void)state;
    for (int i = 0; i < 3; ++i) {
        const double bend = i == 0 ? 90 : i == 1 ? 45 : 30;
        mesh_file mesh = {0};
        add_hinge(&mesh, bend);
        const norma_mesh view = mesh_file_view(&mesh);
        result *r = corners(view, bend);
        assert_same(r, 0, 6);
        assert_int_equal(r->edges.smooth, 3);
        test_free(r);
        r = corners(view, bend - 5e-5); /* 8.7e-7 rad below: still smooth */
        assert_same(r, 0, 6);
        test_free(r);
        r = corners(view, bend - 7e-5); /* 1.2e-6 rad below */
        assert_other(r, 0, 6);
        assert_int_equal(r->edges.smooth, 2);
        assert_int_equal(r->edges.hard, 1);
        assert_int_equal(r->edges.open, 6);
        assert_int_equal(r->edges.count, 9);
        assert_direction(at(r, 0), 0, 0, 1, 1e-5);
        test_free(r);
        mesh_file_free(&mesh);
    }
}

static void flat_planes_at_crease_zero(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_box(&mesh, 1, 1, 1, 0);
    const double turn[9] = {.36, .48, -.8, -.8, .6, 0, .48, .64, .6};
    shape_map(&mesh, turn);
    float *floats = test_calloc(3 * mesh.position_count, sizeof *floats);
    result *r =
        corners(mesh_file_view_float(&mesh, floats), 0); /* the quads' halves are off by 1e-7 */
    for (int q = 0; q < 6; ++q) {
        assert_same(r, 6 * q, 6 * q + 3);
        assert_same(r, 6 * q + 2, 6 * q + 4);
        assert_int_equal(r->reasons[6 * q], NORMA_REASON_NONE);
    }
    assert_int_equal(r->edges.smooth, 6);
    assert_int_equal(r->edges.hard, 12);
    test_free(r);
    r = corners(mesh_file_view_float(&mesh, floats),
        -1); /* even its own plane is cut: each face for itself, its own always in */
    assert_int_equal(r->edges.smooth, 0);
    assert_int_equal(r->report.cancelled.count + r->report.unreferenced.count, 0);
    test_free(r);
    test_free(floats);
    mesh_file_free(&mesh);
}

static void fold_of_180_degrees_is_shared_at_180(void **state) {
    (void)state; /* one triangle folded back on another, larger one; their normals are opposite */
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 4, 0, 0, 1, 0};
    static const uint32_t c[] = {0, 1, 2, 1, 0, 3};
    result *r = corners(TRIANGLES(p, c), 180);
    assert_same(r, 1, 3);
    assert_direction(at(r, 1), 0, 0, 1, 0); /* at vertex 1 the large one's angle wins */
    assert_int_equal(r->reasons[0], NORMA_REASON_CANCELLED); /* at vertex 0 two right angles */
    assert_count(r->report.cancelled, 2, 0);
    test_free(r);
    r = corners(TRIANGLES(p, c), 179.99);
    assert_direction(at(r, 0), 0, 0, 1, 0);
    assert_direction(at(r, 4), 0, 0, -1, 0);
    test_free(r);
}

static void fans_are_continuous_not_pairwise(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_cone(&mesh, 12, .6); /* every dihedral 15.7 degrees, opposite faces 62 */
    result *r = corners(mesh_file_view(&mesh), 30);
    for (int f = 0; f < 12; ++f) {
        const int after = (f + 1) % 12;
        assert_same(r, 3 * f, 3 * after);
        assert_same(r, 3 * f + 2, 3 * after + 1);
    }
    assert_direction(at(r, 0), 0, 0, 1, 1e-5);
    test_free(r);
    r = corners(mesh_file_view(&mesh), 15.6);
    assert_other(r, 0, 3);
    test_free(r);
    r = corners(mesh_file_view(&mesh), 15.8);
    assert_same(r, 0, 3);
    test_free(r);
    mesh_file_free(&mesh);
}

static void fans_that_touch_in_a_vertex_are_separate(void **state) {
    (void)state; /* two cones tip to tip, one upright, one hanging and wider */
    mesh_file mesh = {0}, second = {0};
    shape_cone(&mesh, 8, 1);
    shape_cone(&second, 8, 1);
    for (size_t i = 1; i < 9; ++i)
        mesh_file_add_position(&mesh, 2 * second.positions[i][0], 2 * second.positions[i][1], 2);
    for (uint32_t i = 0; i < 8; ++i)
        mesh_file_add_face(&mesh, (uint32_t[]){0, 9 + (i + 1) % 8, 9 + i}, 3);
    result *r = corners(mesh_file_view(&mesh), 180);
    assert_direction(at(r, 0), 0, 0, 1, 1e-5);
    assert_direction(at(r, 24), 0, 0, -1, 1e-5);
    test_free(r);
    r = vertices(mesh_file_view(&mesh), NORMA_WEIGHT_UNIFORM);
    assert_direction(at(r, 0), 0, 0, -1, 1e-5); /* the flatter one's z is greater: one sum */
    test_free(r);
    mesh_file_free(&mesh);
    mesh_file_free(&second);
}

static void hard_marks_cut_from_either_side(void **state) {
    (void)state;
    for (int side = 0; side < 2; ++side) {
        mesh_file mesh = {0};
        uint8_t marks[12] = {0};
        add_hinge(&mesh, 20);
        norma_mesh view = mesh_file_view(&mesh);
        marks[side ? 8 : 0] = 255; /* 0: from vertex 0 to 1; 8: from 1 to 0 */
        view.hard_edges = marks;
        result *r = corners(view, 180);
        assert_other(r, 0, 6);
        assert_direction(at(r, 0), 0, 0, 1, 1e-5);
        assert_int_equal(r->edges.hard, 1);
        test_free(r);
        mesh_file_free(&mesh);
    }
}

static void mark_of_the_last_repeated_corner_counts(void **state) {
    (void)state; /* hinge of two quads; the one on the left repeats corner 1 */
    static const float p[] = {0, 0, 0, 0, 1, 0, -1, 1, 0, -1, 0, 0, 1, 0, -1, 1, 1, -1};
    static const uint32_t c[] = {0, 0, 1, 2, 3, 0, 4, 5, 1}, starts[] = {0, 5, 9};
    for (int marked = 0; marked < 2; ++marked) {
        uint8_t marks[9] = {0};
        norma_mesh mesh = {.positions = {p, 6, 0, NORMA_FORMAT_FLOAT},
            .corners = c,
            .corner_count = 9,
            .face_starts = starts,
            .face_count = 2,
            .hard_edges = marks};
        marks[marked] = 1;
        result *r = corners(mesh, 180);
        if (marked == 0)
            assert_same(r, 0, 5);
        else
            assert_other(r, 0, 5);
        assert_same(r, 0, 1);
        test_free(r);
    }
}

static void smoothing_groups_share_by_bits(void **state) {
    (void)state;
    static const struct {
        uint32_t left, right;
        int same;
    } cases[] = {{1, 1, 1}, {1, 2, 0}, {0, 0, 0}, {0, 1, 0}, {0x80000000u, 0xc0000000u, 1},
        {6, 3, 1}, {4, 3, 0}};
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        mesh_file mesh = {0};
        uint32_t groups[4] = {cases[i].left, cases[i].left, cases[i].right, cases[i].right};
        add_hinge(&mesh, 20);
        norma_mesh view = mesh_file_view(&mesh);
        view.smoothing_groups = groups;
        result *r = corners(view, 180);
        if (cases[i].same)
            assert_same(r, 0, 6);
        else
            assert_other(r, 0, 6);
        test_free(r);
        r = corners(view, 10); /* the crease cuts as well */
        assert_other(r, 0, 6);
        test_free(r);
        mesh_file_free(&mesh);
    }
}

static void non_manifold_edge_is_hard_and_counted(void **state) {
    (void)state; /* a flat sheet of two triangles along the edge 0 1, and a fin on it */
    static const float p[] = {0, 0, 0, 0, 1, 0, -1, 0, 0, 1, 0, 0, 0, 0, 1};
    static const uint32_t c[] = {0, 1, 2, 1, 0, 3, 1, 0, 4};
    result *r = corners(TRIANGLES(p, c), 180);
    assert_direction(at(r, 0), 0, 0, 1, 0);
    assert_direction(at(r, 4), 0, 0, 1, 0);
    assert_direction(at(r, 7), -1, 0, 0, 0);
    assert_count(r->report.non_manifold_edges, 1, 0);
    assert_int_equal(r->report.winding_conflicts.count, 0);
    assert_int_equal(r->edges.count, 7);
    assert_int_equal(r->edges.open, 6);
    test_free(r);
    r = corners_with(
        TRIANGLES(p, c), 30, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    assert_same(r, 0, 4); /* the sheet stays smooth, the fin is beyond the crease */
    assert_direction(at(r, 7), -1, 0, 0, 0);
    assert_count(r->report.non_manifold_edges, 1, 0);
    test_free(r);
    r = corners_with(
        TRIANGLES(p, c), 180, (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    assert_same(r, 0, 4);
    assert_same(r, 0, 7);
    test_free(r);
}

static void winding_conflict_is_hard_and_counted(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 0, 1, 0, -1, 0, 0, 1, 0, 0.125f};
    static const uint32_t c[] = {1, 2, 0, 3, 0, 1};
    result *r = corners(TRIANGLES(p, c), 180);
    assert_direction(at(r, 0), 0, 0, 1, 0);
    assert_direction(at(r, 5), -0.125, 0, 1, 180);
    assert_other(r, 0, 5);
    assert_count(r->report.winding_conflicts, 1, 2);
    assert_int_equal(r->report.non_manifold_edges.count, 0);
    assert_int_equal(r->edges.count, 5);
    assert_int_equal(r->edges.open, 4);
    assert_int_equal(r->edges.hard + r->edges.smooth, 0); /* each edge is counted once */
    test_free(r);
}

static void leaves_are_smooth_on_each_side(void **state) {
    (void)state;
    mesh_file mesh = {0};
    add_hinge(&mesh, 40);
    for (uint32_t f = 0; f < 4; ++f) { /* each face with its reversed twin, beginning elsewhere */
        const uint32_t *c = mesh.corners + 3 * f;
        const uint32_t twin[3] = {c[1], c[0], c[2]};
        mesh_file_add_face(&mesh, twin, 3);
    }
    result *r = corners(mesh_file_view(&mesh), 60);
    assert_same(r, 0, 6);
    const double *n = (const double[]){sin(20 / DEGREES), 0, cos(20 / DEGREES)};
    assert_true(degrees_between(at(r, 0), n) < 8); /* between the two squares' normals: angle
                                                      weights at a corner of 45 + 90 | 45 degrees */
    for (int f = 0; f < 4; ++f) { /* the back is the front's negative, to the bit */
        const float *front = at(r, 3 * f), *back = at(r, 12 + 3 * f);
        for (int x = 0; x < 3; ++x) {
            assert_true(front[x] == -back[3 + x]);
            assert_true(front[3 + x] == -back[x]);
            assert_true(front[6 + x] == -back[6 + x]);
        }
    }
    assert_int_equal(r->report.non_manifold_edges.count, 0);
    assert_int_equal(r->report.cancelled.count, 0);
    assert_int_equal(r->report.winding_conflicts.count, 0);
    assert_int_equal(r->edges.smooth, 3);
    test_free(r);
    r = vertices(mesh_file_view(&mesh), NORMA_WEIGHT_ANGLE);
    assert_count(r->report.cancelled, 6, 0);
    test_free(r);
    mesh_file_free(&mesh);
}

static void degenerate_face_does_not_cut_a_fan(void **state) {
    (void)state; /* face 0 to the left of the edge 0 1; a sliver along it with 2 in its middle;
                    faces 2 and 3 to the right, bent by 20 degrees */
    const float z = (float)tan(20 / DEGREES);
    const float p[] = {0, 0, 0, 2, 0, 0, 1, 0, 0, 1, 1, 0, 1, -1, -z};
    static const uint32_t c[] = {0, 1, 3, 1, 0, 2, 2, 0, 4, 1, 2, 4};
    result *r = corners(TRIANGLES(p, c), 21);
    assert_same(r, 0, 7);
    assert_same(r, 1, 9);
    assert_same(r, 0, 4); /* the sliver's corner takes the fan's normal */
    assert_int_equal(r->reasons[4], NORMA_REASON_NONE);
    assert_count(r->report.degenerate_faces, 1, 1);
    assert_direction(at(r, 2), 0, 0, 1, 0);
    test_free(r);
    r = corners(TRIANGLES(p, c),
        19); /* it borrows the left face's direction: the crease lies on its other side */
    assert_other(r, 0, 7);
    assert_same(r, 0, 4);
    assert_direction(at(r, 4), 0, 0, 1, 0);
    assert_int_equal(r->reasons[5],
        NORMA_REASON_UNREFERENCED); /* its middle belongs to nobody left of the crease */
    test_free(r);
}

static void borrowing_makes_no_chain(void **state) {
    (void)state; /* two slivers share their longest edge 0 1: neither has anything to lend */
    static const float p[] = {0, 0, 0, 4, 0, 0, 1, 0, 0, 3, 0, 0, 2, 1, 0, 2, -1, 0};
    static const uint32_t c[] = {0, 1, 2, 1, 0, 3, 2, 1, 4, 3, 0, 5};
    result *r = corners(TRIANGLES(p, c), 180);
    assert_int_equal(r->edges.smooth, 0);
    assert_direction(at(r, 6), 0, 0, 1, 0);
    assert_int_equal(r->reasons[0], NORMA_REASON_UNREFERENCED);
    assert_count(r->report.degenerate_faces, 2, 0);
    test_free(r);
}

static void pole_of_a_uv_sphere_is_no_crease(void **state) {
    (void)state;
    for (int quads = 0; quads < 2; ++quads) {
        mesh_file mesh = {0};
        shape_pole_sphere(&mesh, 32, 16, quads);
        float *floats = test_calloc(3 * mesh.position_count, sizeof *floats);
        result *r = corners(mesh_file_view_float(&mesh, floats), 30);
        assert_int_equal(r->report.non_manifold_edges.count, 0);
        assert_int_equal(r->report.winding_conflicts.count, 0);
        assert_int_equal(r->report.cancelled.count, 0);
        assert_int_equal(r->edges.hard, 0);
        assert_int_equal(r->edges.open, 0);
        assert_int_equal(r->edges.count, 32 * 16 + 32 * 15 + (quads ? 0 : 32 * 14));
        assert_int_equal(r->report.degenerate_faces.count, quads ? 0 : 64);
        for (size_t i = 0; i < mesh.corner_count; ++i) {
            const double *p = mesh.positions[mesh.corners[i]];
            if (r->reasons[i])
                assert_int_equal(
                    r->reasons[i], NORMA_REASON_UNREFERENCED); /* corners of the poles' empty
                                                                  halves, which have no edges */
            else
                assert_direction(at(r, i), p[0], p[1], p[2], .35);
        }
        assert_int_equal(r->report.unreferenced.count, quads ? 0 : 3 * 64);
        test_free(r);
        test_free(floats);
        mesh_file_free(&mesh);
    }
}

/* ---- welding */

static void uv_seam_vanishes(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_uv_sphere(&mesh, 32, 16, 1, 0);
    float *floats = test_calloc(3 * mesh.position_count, sizeof *floats);
    const norma_mesh view = mesh_file_view_float(&mesh, floats);
    result *r = vertices(view, NORMA_WEIGHT_AREA),
           *none = vertices_with(
               view, (norma_options){.weld = NORMA_WELD_NONE, .weight = NORMA_WEIGHT_AREA});
    double welded = 0, apart = 0; /* worst errors along the seam */
    for (size_t ring = 0; ring < 15; ++ring) {
        const size_t left = 32 + 33 * ring, right = left + 32;
        const double *p = mesh.positions[left];
        assert_same(r, left, right);
        assert_other(none, left, right);
        welded = fmax(welded, degrees_between(at(r, left), p));
        apart = fmax(
            apart, fmax(degrees_between(at(none, left), p), degrees_between(at(none, right), p)));
    }
    assert_true(apart > 5.9 && apart < 5.95);
    assert_true(welded < 1.94);
    for (int i = 1; i < 32; ++i) assert_same(r, 0, i);
    assert_direction(at(r, 0), 0, 0, 1, 1e-4);
    test_free(r);
    test_free(none);
    test_free(floats);
    mesh_file_free(&mesh);
}

static void negative_zero_is_zero(void **state) {
    (void)state;
    static const float p[] = {
        0, 0, 0, 1, 0, 0, 0, 1, 0, -0.0f, -0.0f, -0.0f, -0.0f, 1, -0.0f, -0.0f, -0.0f, 1};
    static const uint32_t c[] = {0, 1, 2, 3, 4, 5};
    result *r = vertices(TRIANGLES(p, c), NORMA_WEIGHT_ANGLE);
    assert_same(r, 0, 3);
    assert_direction(at(r, 0), 1, 0, 1, 1e-5);
    assert_same(r, 2, 4);
    test_free(r);
}

static void distance_welds_by_chains_in_any_order(void **state) {
    (void)state;
    static const int orders[][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
    for (size_t k = 0; k < COUNT_OF(orders); ++k)
        for (int far = 0; far < 2; ++far) {
            /* three triangles, each with a corner near the origin: at 0, 1, 2 (steps of exactly the
             * distance), upright in three planes */
            const float z[3][3] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
            float p[27];
            for (int t = 0; t < 3; ++t) {
                const float *n = z[orders[k][t]],
                            x = (float)orders[k][t] + (far && orders[k][t] == 2 ? 0x1p-20f : 0);
                for (int v = 0; v < 3; ++v)
                    for (int i = 0; i < 3; ++i)
                        p[9 * t + 3 * v + i] =
                            (i == 0 ? x : 0) + (v == 1      ? 100 * n[(i + 2) % 3]
                                                   : v == 2 ? 100 * n[(i + 1) % 3]
                                                            : 0);
            }
            norma_mesh mesh = {.positions = {p, 9, 0, NORMA_FORMAT_FLOAT}, .corner_count = 9};
            result *r = vertices_with(mesh, (norma_options){.weld = NORMA_WELD_DISTANCE,
                                                .weld_distance = 1,
                                                .weight = NORMA_WEIGHT_UNIFORM});
            size_t at_of[3];
            for (size_t t = 0; t < 3; ++t) at_of[orders[k][t]] = 3 * t;
            assert_same(r, at_of[0], at_of[1]);
            if (far) {
                assert_other(r, at_of[0], at_of[2]);
                assert_direction(at(r, at_of[2]), 1, 0, 0, 1e-5);
            } else {
                assert_same(r, at_of[0], at_of[2]);
                assert_direction(at(r, at_of[0]), 1, 1, 1, 1e-5);
            }
            test_free(r);
        }
}

static void weld_by_distance_empties_small_faces(void **state) {
    (void)state; /* a tiny triangle's corners become one: no edges, no direction; the face round it
                    keeps its own positions */
    static const float p[] = {0, 0, 0, 0.25f, 0, 0, 0, 0.25f, 0, 8, 0, 0, 0, 8, 0};
    static const uint32_t c[] = {0, 2, 1, 1, 3, 4};
    result *r = fresh((norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = 0.5});
    norma_mesh mesh = TRIANGLES(p, c);
    assert_ok(norma_face_normals(&mesh, &r->options, r->normals, 2, &r->report));
    assert_int_equal(r->reasons[0], NORMA_REASON_DEGENERATE);
    assert_direction(at(r, 1), 0, 0, 1, 0);
    test_free(r);
    r = vertices_with(mesh, (norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = 0.5});
    for (int v = 0; v < 5; ++v) assert_direction(at(r, v), 0, 0, 1, 0);
    assert_count(r->report.degenerate_faces, 1, 0);
    test_free(r);
}

/* ---- the whole range of floats */

static void tiny_and_huge(void **state) {
    (void)state;
    for (int e = -149; e <= 127; e += 4)
        for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w); ++w) {
            mesh_file mesh = {0};
            float floats[24];
            shape_box(&mesh, ldexp(1, e), ldexp(1, e), ldexp(1, e), 1);
            norma_mesh view = mesh_file_view_float(&mesh, floats);
            result *r = vertices(view, (norma_weight)w);
            assert_direction(at(r, 7), 1, 1, 1, 1e-5);
            assert_direction(at(r, 0), -1, -1, -1, 1e-5);
            assert_int_equal(r->report.degenerate_faces.count + r->report.cancelled.count, 0);
            test_free(r);
            r = corners_with(view, 180, (norma_options){.weight = (norma_weight)w});
            assert_direction(at(r, 0), -1, -1, -1, 1e-5);
            test_free(r);
            r = faces(view);
            assert_direction(at(r, 0), 0, 0, -1, 0);
            test_free(r);
            mesh_file_free(&mesh);
        }
}

static void edges_of_both_extremes_in_one_face(void **state) {
    (void)state;
    static const float p[] = {0, 0, 0, 1e38f, 0, 0, 0, 1e-38f, 0, 3e38f, -3e38f, 3e38f, -3e38f,
        3e38f, 3e38f, -3e38f, -3e38f, 3e38f, 0, 0, 1e-45f};
    static const uint32_t c[] = {0, 1, 2, 3, 4, 5, 0, 1, 6};
    result *r = faces(TRIANGLES(p, c));
    assert_direction(at(r, 0), 0, 0, 1, 0);
    assert_direction(at(r, 1), 0, 0, 1, 0);
    assert_direction(at(r, 2), 0, -1, 0, 0);
    test_free(r);
    r = vertices(TRIANGLES(p, c), NORMA_WEIGHT_ANGLE); /* both have a right angle at 0 */
    assert_direction(at(r, 0), 0, -1, 1, 1e-5);
    test_free(r);
}

static void doubles_of_any_size(void **state) {
    (void)state;
    for (int e = -1070; e <= 1020; e += 19) {
        mesh_file mesh = {0};
        shape_box(&mesh, ldexp(1, e), ldexp(1, e), ldexp(1, e), 0);
        result *r = vertices(mesh_file_view(&mesh), NORMA_WEIGHT_ANGLE);
        assert_direction(at(r, 7), 1, 1, 1, 1e-5);
        test_free(r);
        mesh_file_free(&mesh);
    }
}

/* ---- interpolation */

static void interpolates_as_phong(void **state) {
    (void)state;
    static const float x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1};
    static const struct {
        float weights[3];
        double expected[3];
    } cases[] = {{{1, 0, 0}, {1, 0, 0}}, {{.5f, .5f, 0}, {1, 1, 0}}, {{.25f, .25f, .5f}, {1, 1, 2}},
        {{1e-30f, 1e-30f, 1e-30f}, {1, 1, 1}}};
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        float n[3];
        assert_ok(norma_interpolate_normal(x, y, z, cases[i].weights, n));
        assert_direction(n, cases[i].expected[0], cases[i].expected[1], cases[i].expected[2], 1e-5);
        assert_true(fabs(sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] +
                              (double)n[2] * (double)n[2]) -
                         1) < 2e-7);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(concave_polygon_points_the_right_way),
        cmocka_unit_test(polygon_far_from_the_origin),
        cmocka_unit_test(reflex_corner_weighs_its_interior_angle),
        cmocka_unit_test(upright_corner_is_reflex_exactly),
        cmocka_unit_test(repeated_corner_is_one),
        cmocka_unit_test(degenerate_face_has_no_vote),
        cmocka_unit_test(collinear_slivers_middle_weighs_nothing),
        cmocka_unit_test(almost_collinear_face_has_an_exact_direction),
        cmocka_unit_test(vertex_without_a_face_gets_the_fallback),
        cmocka_unit_test(mesh_without_any_normal_stays_zero),
        cmocka_unit_test(not_finite_position_poisons_nothing),
        cmocka_unit_test(opposite_faces_cancel),
        cmocka_unit_test(own_index_answers_where_the_position_cancels),
        cmocka_unit_test(dihedral_at_the_threshold_is_smooth),
        cmocka_unit_test(flat_planes_at_crease_zero),
        cmocka_unit_test(fold_of_180_degrees_is_shared_at_180),
        cmocka_unit_test(fans_are_continuous_not_pairwise),
        cmocka_unit_test(fans_that_touch_in_a_vertex_are_separate),
        cmocka_unit_test(hard_marks_cut_from_either_side),
        cmocka_unit_test(mark_of_the_last_repeated_corner_counts),
        cmocka_unit_test(smoothing_groups_share_by_bits),
        cmocka_unit_test(non_manifold_edge_is_hard_and_counted),
        cmocka_unit_test(winding_conflict_is_hard_and_counted),
        cmocka_unit_test(leaves_are_smooth_on_each_side),
        cmocka_unit_test(degenerate_face_does_not_cut_a_fan),
        cmocka_unit_test(borrowing_makes_no_chain),
        cmocka_unit_test(pole_of_a_uv_sphere_is_no_crease),
        cmocka_unit_test(uv_seam_vanishes),
        cmocka_unit_test(negative_zero_is_zero),
        cmocka_unit_test(distance_welds_by_chains_in_any_order),
        cmocka_unit_test(weld_by_distance_empties_small_faces),
        cmocka_unit_test(tiny_and_huge),
        cmocka_unit_test(edges_of_both_extremes_in_one_face),
        cmocka_unit_test(doubles_of_any_size),
        cmocka_unit_test(each_face_of_a_mixed_mesh_has_its_own_normal),
        cmocka_unit_test(interpolates_as_phong),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
