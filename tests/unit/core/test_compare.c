/* test_compare.c: norma_compare on spheres and boxes whose angles are known, on the same surface
 * written in another order, and, corner by corner, against a search over all triangles. */
#include "accountant.h"
#include "check.h"
#include "oracle/shapes.h"
#include <float.h>

static void assert_near(double got, double expected, double most) {
    if (!(fabs(got - expected) <= most)) fail_msg("%.9g instead of %.9g", got, expected);
}

typedef struct shaded { /* a mesh with a normal for each corner, or for each position */
    mesh_file mesh;
    float *normals;
    uint32_t *numbers; /* NULL: by position */
} shaded;

static norma_surface view_of(const shaded *s) {
    norma_surface surface = {
        .mesh = mesh_file_view_polygons(&s->mesh), .corner_normals = s->numbers};
    surface.normals = (norma_vec3_view){
        s->normals, s->numbers ? s->mesh.corner_count : s->mesh.position_count, 0, 0};
    return surface;
}

static void shaded_free(shaded *s) {
    mesh_file_free(&s->mesh);
    test_free(s->normals);
    test_free(s->numbers);
}

static void shade_flat(shaded *s) {
    const norma_mesh mesh = mesh_file_view_polygons(&s->mesh);
    s->normals = test_calloc(s->mesh.corner_count, 12);
    s->numbers = test_calloc(s->mesh.corner_count, 4);
    assert_ok(norma_corner_normals(&mesh, -1, NULL, s->normals, s->mesh.corner_count, NULL));
    for (uint32_t i = 0; i < s->mesh.corner_count; ++i) s->numbers[i] = i;
}

static void shade_radial(shaded *s) {
    s->normals = test_calloc(s->mesh.position_count, 12);
    for (size_t i = 0; i < 3 * s->mesh.position_count; ++i)
        s->normals[i] = (float)s->mesh.positions[i / 3][i % 3];
}

static norma_compare_sample *compare(
    const shaded *base, const shaded *other, int *same, norma_comparison *sum, double most) {
    const norma_surface a = view_of(base), b = view_of(other);
    const size_t count = other->mesh.corner_count;
    norma_compare_sample *samples = test_calloc(count + 1, sizeof *samples);
    assert_ok(norma_compare(&a, &b, NULL, samples, count, same));
    assert_ok(norma_compare_summary(samples, count, most, NULL, sum));
    return samples;
}

/* The faces in another order, each from another corner, every corner a vertex of its own. */
static shaded shuffled(const shaded *s, uint64_t seed) {
    shaded out = {.normals = test_calloc(s->mesh.corner_count, 12),
        .numbers = test_calloc(s->mesh.corner_count, 4)};
    uint32_t *order = test_calloc(s->mesh.face_count, 4);
    for (uint32_t i = 0; i < s->mesh.face_count; ++i) {
        const uint32_t k = shape_random(&seed) % (i + 1);
        order[i] = order[k];
        order[k] = i;
    }
    for (size_t i = 0, c = 0; i < s->mesh.face_count; ++i) {
        const uint32_t begin = s->mesh.starts[order[i]];
        const size_t count = s->mesh.starts[order[i] + 1] - begin,
                     turn = shape_random(&seed) % count;
        uint32_t corners[8];
        for (size_t k = 0; k < count; ++k, ++c) {
            const uint32_t from = begin + (uint32_t)((k + turn) % count);
            const double *p = s->mesh.positions[s->mesh.corners[from]];
            mesh_file_add_position(&out.mesh, p[0], p[1], p[2]);
            corners[k] = out.numbers[c] = (uint32_t)c;
            memcpy(out.normals + 3 * c,
                s->normals + (size_t)3 * (s->numbers ? s->numbers[from] : s->mesh.corners[from]),
                12);
        }
        mesh_file_add_face(&out.mesh, corners, count);
    }
    test_free(order);
    return out;
}

/* ---- bounds */

/* Every triangle of a sphere is equally far from points around its middle: a search that could rule
 * none out would take the product of both. */
static void a_dot_in_the_middle_of_a_sphere(void **state) {
    (void)state;
    shaded base = {0}, other = {0};
    shape_octahedron_sphere(&base.mesh, 34);
    shade_radial(&base);
    shape_octahedron_sphere(&other.mesh, 60);
    shade_radial(&other);
    for (size_t i = 0; i < other.mesh.position_count; ++i)
        for (int k = 0; k < 3; ++k) other.mesh.positions[i][k] *= 0x1p-20;
    const norma_surface a = view_of(&base), b = view_of(&other);
    const size_t count = other.mesh.corner_count;
    norma_compare_sample *samples = test_calloc(count, sizeof *samples);
    const norma_options options = {.struct_size = sizeof options, .threads = NORMA_ALL_THREADS};
    assert_int_equal(norma_compare(&a, &b, &options, samples, count, NULL), NORMA_ERROR_OVERFLOW);
    assert_ok(norma_compare(&b, &a, &options, samples, base.mesh.corner_count, NULL));
    test_free(samples);
    shaded_free(&base);
    shaded_free(&other);
}

/* ---- closed forms */

/* From a corner of the octahedron to the middle of its face: acos(1 / sqrt 3). */
static void an_octahedron_in_a_sphere(void **state) {
    (void)state;
    shaded base = {0}, other = {0};
    norma_comparison sum;
    int same = 1;
    shape_octahedron_sphere(&base.mesh, 24);
    shade_radial(&base);
    shape_octahedron_sphere(&other.mesh, 1);
    shade_flat(&other);
    assert_int_equal(other.mesh.face_count, 8);
    norma_compare_sample *samples = compare(&base, &other, &same, &sum, 54.7 / DEGREES);
    assert_int_equal(same, 0);
    assert_int_equal(sum.corners, 24);
    const double angle = 54.735610317245346, values[] = {sum.p50_rad, sum.p99_rad, sum.max_rad};
    for (int i = 0; i < 3; ++i) assert_near(values[i] * DEGREES, angle, 1e-5);
    assert_near(sum.area, 4 * sqrt(3), 1e-9); /* eight of sides sqrt 2 */
    assert_true(sum.max_distance < 1e-7 && sum.share_above == 1);
    assert_ok(norma_compare_summary(samples, 24, 54.8 / DEGREES, NULL, &sum));
    assert_true(sum.share_above == 0);
    test_free(samples);
    shaded_free(&base);
    shaded_free(&other);
}

/* Corners of a coarser sphere lie on the finer one, and flat shading is off by the angle between a
 * corner and the middle of its face; with the sphere's own normals nothing is. */
static void a_decimated_sphere(void **state) {
    (void)state;
    shaded base = {0}, flat = {0}, round = {0};
    norma_comparison sum;
    int same;
    shape_octahedron_sphere(&base.mesh, 32);
    shade_radial(&base);
    shape_octahedron_sphere(&flat.mesh, 4);
    shape_octahedron_sphere(&round.mesh, 4);
    shade_flat(&flat);
    shade_radial(&round);
    norma_compare_sample *samples = compare(&base, &flat, &same, &sum, 0);
    for (size_t c = 0; c < flat.mesh.corner_count; ++c) {
        const double *p = flat.mesh.positions[flat.mesh.corners[c]];
        const double expected = degrees_between(flat.normals + 3 * c, p);
        assert_near((double)samples[c].angle_rad * DEGREES, expected, 1e-4);
        assert_direction(samples[c].normal, p[0], p[1], p[2], 1e-4);
    }
    test_free(samples);
    test_free(compare(&base, &round, &same, &sum, 0.001));
    assert_true(sum.max_rad * DEGREES < 1e-4 && sum.share_above == 0);
    shaded_free(&base);
    shaded_free(&flat);
    shaded_free(&round);
}

/* Phong's normals of an octahedron at the middles of its edges are those of the sphere. */
static void normals_are_interpolated(void **state) {
    (void)state;
    shaded base = {0}, other = {0};
    norma_comparison sum;
    int same;
    shape_octahedron_sphere(&base.mesh, 1);
    shade_radial(&base);
    shape_octahedron_sphere(&other.mesh, 2);
    shade_radial(&other);
    test_free(compare(&base, &other, &same, &sum, 0));
    assert_true(sum.max_rad * DEGREES < 1e-4);
    assert_near(sum.max_distance, 1 - sqrt(0.5), 1e-6);
    shaded_free(&base);
    shaded_free(&other);
}

static void a_turned_plane(void **state) {
    (void)state;
    for (int degrees = 0; degrees <= 180; degrees += 15) {
        shaded base = {0}, other = {0};
        norma_comparison sum;
        int same = 0;
        shape_fan(&base.mesh, 6);
        shape_fan(&other.mesh, 6);
        shade_flat(&base);
        shade_flat(&other);
        for (size_t c = 0; c < other.mesh.corner_count; ++c) {
            other.normals[3 * c] = (float)sin(degrees / DEGREES);
            other.normals[3 * c + 2] *= (float)cos(degrees / DEGREES);
        }
        test_free(compare(&base, &other, &same, &sum, 0));
        assert_int_equal(same, 1);
        assert_near(sum.p50_rad * DEGREES, degrees, 1e-5);
        assert_near(sum.max_rad * DEGREES, degrees, 1e-5);
        shaded_free(&base);
        shaded_free(&other);
    }
}

/* ---- the same surface */

static void expect_equal(const shaded *s) {
    shaded other = shuffled(s, 7);
    norma_comparison sum;
    int same;
    test_free(compare(s, s, &same, &sum, 0));
    assert_true(same && sum.max_rad * DEGREES < 1e-5 && sum.max_distance == 0);
    test_free(compare(s, &other, &same, &sum, 0));
    assert_true(!same && sum.missing == 0);
    assert_true(sum.max_rad * DEGREES < 1e-5);
    shaded_free(&other);
}

static void another_order_is_no_difference(void **state) {
    (void)state;
    for (int kind = 0; kind < 5; ++kind) {
        shaded s = {0};
        if (kind == 0) shape_box(&s.mesh, 3, 1, 2, 1);
        if (kind == 1) shape_uv_sphere(&s.mesh, 30, 20, 1, 0);
        if (kind == 2) shape_cone(&s.mesh, 1000, 4); /* more faces at its tip than are kept */
        if (kind == 3) shape_wavy_grid(&s.mesh, 40, 0);
        if (kind == 4) shape_octahedron_sphere(&s.mesh, 9);
        if (kind == 3) { /* and each face's twin, seen from behind */
            const size_t faces = s.mesh.face_count;
            for (size_t f = 0; f < faces; ++f) {
                const uint32_t *c = s.mesh.corners + s.mesh.starts[f];
                mesh_file_add_face(&s.mesh, (const uint32_t[]){c[0], c[2], c[1]}, 3);
            }
        }
        shade_flat(&s);
        expect_equal(&s);
        shaded_free(&s);
    }
}

/* A box with one side shaded as the next one: a sixth of the area is 90 degrees off. */
static void a_wrong_side_is_seen(void **state) {
    (void)state;
    shaded base = {0};
    norma_comparison sum;
    int same;
    shape_box(&base.mesh, 1, 1, 1, 1);
    shade_flat(&base);
    shaded other = shuffled(&base, 3);
    const float was[3] = {other.normals[0], other.normals[1], other.normals[2]};
    for (int c = 0; c < 4; ++c)
        for (int k = 0; k < 3; ++k) other.normals[3 * c + k] = was[(k + 1) % 3];
    norma_compare_sample *samples = compare(&base, &other, &same, &sum, 1 / DEGREES);
    assert_near(sum.max_rad * DEGREES, 90, 1e-5);
    assert_near(sum.share_above, 1.0 / 6, 1e-9);
    assert_true(sum.p50_rad == 0 && sum.worst == 0);
    for (int c = 0; c < 24; ++c) assert_int_equal(samples[c].angle_rad > 1, c < 4);
    test_free(samples);
    shaded_free(&base);
    shaded_free(&other);
}

/* Corners that a compression has moved are still compared with their own side of a crease. */
static void moved_corners_stay_on_their_side(void **state) {
    (void)state;
    shaded base = {0};
    norma_comparison sum;
    uint64_t seed = 9;
    int same;
    shape_box(&base.mesh, 1, 1, 1, 1);
    shade_flat(&base);
    shaded other = shuffled(&base, 3);
    for (size_t i = 0; i < 3 * other.mesh.position_count; ++i)
        other.mesh.positions[i / 3][i % 3] += 1e-3 * shape_random_unit(&seed);
    test_free(compare(&base, &other, &same, &sum, 0));
    assert_true(!same && sum.max_distance > 1e-4 && sum.max_distance < 2e-3);
    assert_true(sum.max_rad * DEGREES < 1e-4);
    shaded_free(&base);
    shaded_free(&other);
}

/* ---- every triangle, for every corner */

/* By Lagrange and clamping, a way of its own: the plane's point if it is inside, else the nearest
 * on an edge. */
static double distance_to(const double p[3], double corners[3][3]) {
    double normal[3], u[3], v[3], from[3], least = INFINITY;
    int inside = 1;
    for (int k = 0; k < 3; ++k) {
        u[k] = corners[1][k] - corners[0][k];
        v[k] = corners[2][k] - corners[0][k];
        from[k] = p[k] - corners[0][k];
    }
    for (int k = 0; k < 3; ++k)
        normal[k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    const double length =
        sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    for (int e = 0; e < 3; ++e) {
        const double *a = corners[e], *b = corners[(e + 1) % 3];
        double along = 0, square = 0, turn = 0, sum = 0;
        for (int k = 0; k < 3; ++k) {
            const int x = (k + 1) % 3, y = (k + 2) % 3;
            along += (p[k] - a[k]) * (b[k] - a[k]);
            square += (b[k] - a[k]) * (b[k] - a[k]);
            turn += normal[k] * ((b[x] - a[x]) * (p[y] - a[y]) - (b[y] - a[y]) * (p[x] - a[x]));
        }
        const double t = fmin(fmax(square > 0 ? along / square : 0, 0), 1);
        for (int k = 0; k < 3; ++k) {
            const double d = p[k] - a[k] - t * (b[k] - a[k]);
            sum += d * d;
        }
        least = fmin(least, sqrt(sum));
        inside = inside && turn >= 0;
    }
    const double above = (from[0] * normal[0] + from[1] * normal[1] + from[2] * normal[2]) / length;
    return inside && length > 0 ? fmin(least, fabs(above)) : least;
}

static void random_triangles(shaded *s, uint64_t *seed, size_t count, double spread) {
    for (uint32_t f = 0; f < count; ++f) {
        double middle[3];
        const double size = f % 5 ? 0.3 : 0.9, thin = f % 7 ? 1 : 1e-4;
        for (int k = 0; k < 3; ++k) middle[k] = spread * shape_random_unit(seed);
        for (int i = 0; i < 3; ++i)
            mesh_file_add_position(&s->mesh, middle[0] + size * shape_random_unit(seed),
                middle[1] + size * thin * shape_random_unit(seed),
                middle[2] + size * thin * shape_random_unit(seed));
        mesh_file_add_face(&s->mesh, (const uint32_t[]){3 * f, 3 * f + 1, 3 * f + 2}, 3);
    }
    s->normals = test_calloc(s->mesh.position_count, 12);
    for (size_t i = 0; i < 3 * s->mesh.position_count; ++i)
        s->normals[i] = (float)shape_random_unit(seed);
}

static void corners_at(const shaded *s, size_t face, double corners[3][3]) {
    for (size_t i = 0; i < 3; ++i)
        memcpy(corners[i], s->mesh.positions[s->mesh.corners[3 * face + i]], sizeof corners[i]);
}

static void every_triangle_is_asked(void **state) {
    (void)state;
    uint64_t seed = 11;
    for (int round = 0; round < 24 / SLOWER + 1; ++round) {
        shaded base = {0}, other = {0};
        norma_comparison sum;
        int same;
        random_triangles(&base, &seed, 20 + (size_t)(40 * round), 2);
        random_triangles(&other, &seed, 60, 3);
        norma_compare_sample *samples = compare(&base, &other, &same, &sum, 0);
        for (size_t c = 0; c < other.mesh.corner_count; ++c) {
            const double *p = other.mesh.positions[c];
            double least = INFINITY, corners[3][3];
            for (size_t f = 0; f < base.mesh.face_count; ++f) {
                corners_at(&base, f, corners);
                least = fmin(least, distance_to(p, corners));
            }
            corners_at(&base, samples[c].face, corners);
            assert_near((double)samples[c].distance, least, 2e-6);
            assert_true(
                distance_to(p, corners) < 2 * least + 2e-5); /* its own side may be further */
            assert_near((double)samples[c].angle_rad * DEGREES,
                degrees_between(samples[c].normal,
                    (const double[]){(double)other.normals[3 * c], (double)other.normals[3 * c + 1],
                        (double)other.normals[3 * c + 2]}),
                1e-3);
        }
        test_free(samples);
        shaded_free(&base);
        shaded_free(&other);
    }
}

/* Of so many that several threads halve their tree: each corner of a triangle lies on it. */
static void no_triangle_is_lost(void **state) {
    enum { TRIANGLES = 17000 };
    (void)state;
    shaded base = {0}, other = {0};
    uint64_t seed = 3, again = 3;
    int same;
    norma_comparison sum;
    random_triangles(&base, &seed, TRIANGLES, 2);
    random_triangles(&other, &again, TRIANGLES + 1, 2);
    norma_compare_sample *samples = compare(&base, &other, &same, &sum, 0);
    for (size_t c = 0; c < 3 * (size_t)TRIANGLES; ++c) assert_true(samples[c].distance == 0);
    test_free(samples);
    shaded_free(&base);
    shaded_free(&other);
}

/* An arrow whose fan from its first corner would cover the notch at (0.5, 0). */
static void a_concave_polygon_is_cut(void **state) {
    (void)state;
    shaded base = {0}, other = {0};
    norma_comparison sum;
    int same;
    const double corners[2][4][2] = {
        {{2, 1}, {1, 0}, {2, -1}, {-1, 0}}, {{1.5, 0}, {1.75, 0.25}, {1.25, 0}, {0, 0}}};
    for (int i = 0; i < 4; ++i) {
        mesh_file_add_position(&base.mesh, corners[0][i][0], corners[0][i][1], 0);
        mesh_file_add_position(&other.mesh, corners[1][i][0], corners[1][i][1], 0);
    }
    mesh_file_add_face(&base.mesh, (const uint32_t[]){0, 3, 2, 1}, 4);
    mesh_file_add_face(&other.mesh, (const uint32_t[]){0, 1, 2}, 3);
    shade_flat(&base);
    shade_flat(&other);
    norma_compare_sample *samples = compare(&base, &other, &same, &sum, 0);
    const double half = sqrt(0.5), expected[3] = {0.5 * half, 0.5 * half, 0.25 * half};
    for (int i = 0; i < 3; ++i) assert_near((double)samples[i].distance, expected[i], 1e-6);
    test_free(samples);
    shaded_free(&base);
    shaded_free(&other);
}

static void percentiles_are_of_area(void **state) {
    (void)state;
    norma_compare_sample samples[101];
    norma_comparison sum;
    for (int i = 0; i < 100; ++i)
        samples[i] = (norma_compare_sample){
            .area = 1, .angle_rad = 0.01f * (float)(99 - i), .distance = (float)i};
    samples[100] = (norma_compare_sample){.area = 0, .angle_rad = 3, .distance = 1000};
    assert_ok(norma_compare_summary(samples, 101, 0.895, NULL, &sum));
    assert_near(sum.p50_rad, 0.49, 1e-6);
    assert_near(sum.p99_rad, 0.98, 1e-6);
    assert_near(sum.max_rad, 0.99, 1e-6);
    assert_near(sum.share_above, 0.1, 1e-12);
    assert_true(sum.p50_distance == 49 && sum.p99_distance == 98 && sum.max_distance == 99);
    assert_int_equal(sum.worst, 0);
    samples[99].area = 300; /* the least angle, the greatest distance */
    samples[50].angle_rad = -1;
    assert_ok(norma_compare_summary(samples, 101, 0.895, NULL, &sum));
    assert_true(sum.p50_rad == 0 && sum.p50_distance == 99 && sum.missing == 1);
    assert_near(sum.share_above, 11.0 / 399, 1e-12);
}

/* ---- what every call promises */

static void no_size_and_no_thread_changes_anything(void **state) {
    (void)state;
    shaded base = {0}, other = {0};
    uint64_t seed = 5;
    random_triangles(&base, &seed, 300, 2);
    random_triangles(&other, &seed, 3000, 3);
    norma_compare_sample *expected = test_calloc(9000, sizeof *expected),
                         *got = test_calloc(9000, sizeof *got);
    norma_surface a = view_of(&base), b = view_of(&other);
    assert_ok(norma_compare(&a, &b, NULL, expected, 9000, NULL));
    assert_ok(norma_compare(&a, &b, &(norma_options){.threads = 7}, got, 9000, NULL));
    assert_memory_equal(got, expected, 9000 * sizeof *got);
    for (int power = -400; power <= 400; power += 50) {
        shape_scale(&base.mesh, ldexp(1, power));
        shape_scale(&other.mesh, ldexp(1, power));
        a = view_of(&base);
        b = view_of(&other);
        assert_ok(norma_compare(&a, &b, NULL, got, 9000, NULL));
        for (size_t i = 0; i < 9000; ++i) {
            assert_near((double)got[i].angle_rad, (double)expected[i].angle_rad, 0);
            assert_near(
                got[i].area, ldexp(expected[i].area, 2 * power), 1e-14 * ldexp(1, 2 * power));
            assert_near((double)got[i].distance,
                (double)(float)fmin(ldexp((double)expected[i].distance, power), FLT_MAX), 0);
        }
        shape_scale(&base.mesh, ldexp(1, -power));
        shape_scale(&other.mesh, ldexp(1, -power));
    }
    test_free(expected);
    test_free(got);
    shaded_free(&base);
    shaded_free(&other);
}

static void missing_normals_are_counted(void **state) {
    (void)state;
    shaded base = {0}, other = {0};
    norma_comparison sum;
    int same;
    shape_box(&base.mesh, 1, 1, 1, 1);
    shade_flat(&base);
    base.numbers[0] = UINT32_MAX; /* its triangle's instead */
    shape_box(&other.mesh, 1, 1, 1, 1);
    shade_flat(&other);
    other.numbers[4] = UINT32_MAX;
    other.normals[15] = NAN;
    memset(other.normals + 18, 0, 12);
    norma_compare_sample *samples = compare(&base, &other, &same, &sum, 10);
    assert_int_equal(same, 1);
    assert_int_equal(sum.missing, 3);
    assert_int_equal(sum.corners, 21);
    assert_near(sum.share_above, 3.0 / 24, 1e-12);
    assert_true(sum.max_rad == 0 && samples[4].angle_rad == -1 && samples[4].distance == 0);
    test_free(samples);
    base.mesh.positions[0][0] = NAN; /* the corners there are on no surface */
    test_free(compare(&base, &base, &same, &sum, 10));
    assert_true(same && sum.missing == 0 && sum.corners == 12 && sum.max_rad == 0);
    shaded_free(&base);
    shaded_free(&other);
}

static void memory_and_arguments(void **state) {
    (void)state;
    shaded base = {0}, other = {0};
    uint64_t seed = 1;
    norma_comparison sum;
    norma_compare_sample samples[300];
    random_triangles(&base, &seed, 50, 2);
    random_triangles(&other, &seed, 100, 2);
    norma_surface a = view_of(&base), b = view_of(&other), empty = {.corner_normals = NULL};
    for (size_t n = 1;; ++n) {
        accountant account = {.fail_at = n};
        const norma_options options = {.allocator = {accountant_take, accountant_give, &account}};
        norma_result result = norma_compare(&a, &b, &options, samples, 300, NULL);
        if (!result) result = norma_compare_summary(samples, 300, 0, &options, &sum);
        assert_int_equal(account.live, 0);
        assert_int_equal(account.wrong, 0);
        assert_int_equal(result, account.calls >= n ? NORMA_ERROR_MEMORY : NORMA_OK);
        if (account.calls < n) break;
    }
    assert_int_equal(norma_compare(NULL, &b, NULL, samples, 300, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_compare(&a, &b, NULL, NULL, 300, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_compare(&a, &b, NULL, samples, 299, NULL), NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_compare_summary(samples, 300, NAN, NULL, &sum), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_compare_summary(samples, 300, 0, NULL, NULL), NORMA_ERROR_ARGUMENT);
    assert_ok(norma_compare(&a, &empty, NULL, NULL, 0, NULL));
    assert_ok(norma_compare_summary(NULL, 0, 0, NULL, &sum));
    assert_true(sum.worst == SIZE_MAX && sum.area == 0 && sum.share_above == 0);
    assert_ok(norma_compare(&empty, &b, NULL, samples, 300, NULL)); /* nothing to compare with */
    assert_ok(norma_compare_summary(samples, 300, 4, NULL, &sum));
    assert_int_equal(sum.missing, 300);
    assert_true(sum.share_above == 1 && samples[0].face == UINT32_MAX && samples[0].distance == -1);
    --b.normals.count;
    assert_int_equal(norma_compare(&a, &b, NULL, samples, 300, NULL), NORMA_ERROR_INDEX);
    b.normals.count = 0;
    assert_int_equal(norma_compare(&a, &b, NULL, samples, 300, NULL), NORMA_ERROR_ARGUMENT);
    shaded_free(&base);
    shaded_free(&other);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_dot_in_the_middle_of_a_sphere),
        cmocka_unit_test(an_octahedron_in_a_sphere),
        cmocka_unit_test(a_decimated_sphere),
        cmocka_unit_test(normals_are_interpolated),
        cmocka_unit_test(a_turned_plane),
        cmocka_unit_test(another_order_is_no_difference),
        cmocka_unit_test(a_wrong_side_is_seen),
        cmocka_unit_test(moved_corners_stay_on_their_side),
        cmocka_unit_test(every_triangle_is_asked),
        cmocka_unit_test(no_triangle_is_lost),
        cmocka_unit_test(a_concave_polygon_is_cut),
        cmocka_unit_test(percentiles_are_of_area),
        cmocka_unit_test(no_size_and_no_thread_changes_anything),
        cmocka_unit_test(missing_normals_are_counted),
        cmocka_unit_test(memory_and_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
