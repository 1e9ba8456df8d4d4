/* test_render_pipeline.c: the steps of the pipeline by hand, the smallest ball, the closest frame;
 * no picture is drawn. */
#include "check.h"
#include "render/parts.h"

static void assert_near(const double *a, double x, double y, double z) {
    const double off = fabs(a[0] - x) + fabs(a[1] - y) + fabs(a[2] - z);
    if (!(off < 1e-12)) print_error("(%.17g %.17g %.17g)\n", a[0], a[1], a[2]);
    assert_true(off < 1e-12);
}

/* A camera at distance 10 in front of, right of, above the point (1, 2, 3): what lies where. */
static void world_to_view(void **state) {
    (void)state;
    const double centre[3] = {1, 2, 3}, beside[3] = {2, 2, 3};
    double m[16], seen[3];
    render_camera camera = {.centre = {1, 2, 3}, .distance = 10};
    render_world_to_view(&camera, m);
    render_point(m, centre, seen);
    assert_near(seen, 0, 0, -10);
    render_point(m, beside, seen);
    assert_near(seen, 1, 0, -10);
    camera.azimuth_deg = 90; /* from +x: what lies there is nearer */
    render_world_to_view(&camera, m);
    render_point(m, beside, seen);
    assert_near(seen, 0, 0, -9);
    camera.azimuth_deg = 0;
    camera.elevation_deg = 90; /* from above: +z is down */
    render_world_to_view(&camera, m);
    const double before[3] = {1, 2, 4}, over[3] = {1, 5, 3};
    render_point(m, before, seen);
    assert_near(seen, 0, -1, -10);
    render_point(m, over, seen);
    assert_near(seen, 0, 0, -7);
    camera.up = RENDER_UP_Z; /* then from +z, with +y up */
    render_world_to_view(&camera, m);
    render_point(m, before, seen);
    assert_near(seen, 0, 0, -9);
    render_point(m, over, seen);
    assert_near(seen, 0, 3, -10);
}

static void to_clip_and_pixels(void **state) {
    (void)state;
    const render_camera camera = {.distance = 5, .tangent = 0.5, .aspect = 2, .depth = 1};
    double m[16], clip[4], pixel[3];
    /* View points at the middle, on the upper right border, on the near and on the far plane. */
    static const struct {
        double view[3], pixel[3];
        int depth_known;
    } points[] = {{{0, 0, -4}, {100, 50, 0}, 1}, {{0, 0, -6}, {100, 50, 1}, 1},
        {{5, 2.5, -5}, {200, 0, 0}, 0}, {{-5, -2.5, -5}, {0, 100, 0}, 0}};
    render_view_to_clip(&camera, m);
    for (size_t i = 0; i < COUNT_OF(points); ++i) {
        const double *v = points[i].view;
        for (int row = 0; row < 4; ++row)
            clip[row] = m[row] * v[0] + m[4 + row] * v[1] + m[8 + row] * v[2] + m[12 + row];
        render_clip_to_viewport(clip, 200, 100, pixel);
        assert_near(pixel, points[i].pixel[0], points[i].pixel[1],
            points[i].depth_known ? points[i].pixel[2] : pixel[2]);
    }
    const render_camera flat = {.distance = 5, .half_height = 3, .aspect = 2, .depth = 1};
    render_view_to_clip(&flat, m);
    for (int row = 0; row < 4; ++row)
        clip[row] = m[row] * 6 + m[4 + row] * 3 + m[8 + row] * -4 + m[12 + row];
    render_clip_to_viewport(clip, 200, 100, pixel);
    assert_near(pixel, 200, 0, 0);
}

/* The node acts first, then what the command line gives. */
static void local_to_world(void **state) {
    (void)state;
    const double moved[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1},
                 doubled[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1},
                 origin[3] = {0, 0, 0};
    double m[16], p[3];
    render_local_to_world(moved, doubled, m);
    render_point(m, origin, p);
    assert_near(p, 2, 0, 0);
}

static render_cloud cloud_of(const float *points, size_t count) {
    return (render_cloud){.points = points,
        .count = count,
        .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
}

/* Two points: the ball on their segment. A regular tetrahedron in a cube: the cube's. A right
 * triangle: on its longest side. Equal points: none. */
static void balls_by_hand(void **state) {
    (void)state;
    static const float two[6] = {-1, 0, 0, 3, 0, 0},
                       tetrahedron[12] = {1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1},
                       right[9] = {0, 0, 0, 4, 0, 0, 0, 3, 0}, same[6] = {7, 7, 7, 7, 7, 7};
    render_cloud cloud = cloud_of(two, 2);
    render_ball ball = render_smallest_ball(&cloud, 1);
    assert_near(ball.centre, 1, 0, 0);
    assert_true(fabs(ball.radius - 2) < 1e-9);
    cloud = cloud_of(tetrahedron, 4);
    ball = render_smallest_ball(&cloud, 1);
    assert_near(ball.centre, 0, 0, 0);
    assert_true(fabs(ball.radius - sqrt(3)) < 1e-9);
    cloud = cloud_of(right, 3);
    ball = render_smallest_ball(&cloud, 1);
    assert_true(fabs(ball.radius - 2.5) < 1e-6);
    cloud = cloud_of(same, 2);
    ball = render_smallest_ball(&cloud, 1);
    assert_near(ball.centre, 7, 7, 7);
    assert_true(ball.radius < 1e-9);
}

static double uniform(uint64_t *seed) {
    *seed = *seed * 6364136223846793005U + 1442695040888963407U;
    return (double)(*seed >> 11) / 9007199254740992.0;
}

/* Of random points: it holds all, and no ball round a centre nearby is smaller (moving the centre
 * any way leaves some point farther off). */
static void balls_of_many(void **state) {
    (void)state;
    float points[3 * 200];
    uint64_t seed = 7;
    for (int round = 0; round < 50; ++round) {
        const size_t count = 3 + (size_t)(uniform(&seed) * 190);
        for (size_t i = 0; i < 3 * count; ++i)
            points[i] = (float)(uniform(&seed) * (i % 3 == 1 ? 5 : 1) + uniform(&seed));
        const render_cloud cloud = cloud_of(points, count);
        const render_ball ball = render_smallest_ball(&cloud, 1);
        for (int direction = -1; direction < 26; ++direction) {
            double farthest = 0;
            for (size_t i = 0; i < count; ++i) {
                double squared = 0;
                for (int k = 0; k < 3; ++k) {
                    const int step = direction < 0 ? 0
                                                   : (direction + (direction >= 13)) /
                                                             (k == 0      ? 1
                                                                 : k == 1 ? 3
                                                                          : 9) %
                                                             3 -
                                                         1;
                    const double off =
                        (double)points[3 * i + (size_t)k] - ball.centre[k] - 1e-3 * step;
                    squared += off * off;
                }
                farthest = fmax(farthest, sqrt(squared));
            }
            if (direction < 0)
                assert_true(fabs(farthest - ball.radius) < 1e-6);
            else
                assert_true(farthest > ball.radius - 1e-6);
        }
    }
}

/* Every point inside the margins, and some on them: no camera could be closer. */
static void frames(void **state) {
    (void)state;
    float points[3 * 60];
    uint64_t seed = 3;
    for (int round = 0; round < 40; ++round) {
        const int orthographic = round % 2;
        render_camera camera = {.azimuth_deg = 360 * uniform(&seed),
            .elevation_deg = 180 * uniform(&seed) - 90,
            .tangent = 0.4,
            .aspect = 0.5 + uniform(&seed),
            .depth = 100};
        double right[3], up[3], back[3], view[16], clip[16], most[2] = {-9, -9}, least[2] = {9, 9};
        for (size_t i = 0; i < COUNT_OF(points); ++i) points[i] = (float)(2 * uniform(&seed) - 1);
        const render_cloud cloud = cloud_of(points, 60);
        const render_frame frame = render_closest_frame(&camera, orthographic, 0.1, &cloud, 1);
        render_camera_axes(&camera, right, up, back);
        for (int k = 0; k < 3; ++k)
            camera.centre[k] = frame.middle[0] * right[k] + frame.middle[1] * up[k];
        camera.distance = orthographic ? 50 : frame.distance;
        camera.half_height = orthographic ? frame.distance : 0;
        render_world_to_view(&camera, view);
        render_view_to_clip(&camera, clip);
        for (size_t i = 0; i < 60; ++i) {
            const double p[3] = {
                (double)points[3 * i], (double)points[3 * i + 1], (double)points[3 * i + 2]};
            double seen[3], at[4], pixel[3];
            render_point(view, p, seen);
            for (int row = 0; row < 4; ++row)
                at[row] = clip[row] * seen[0] + clip[4 + row] * seen[1] + clip[8 + row] * seen[2] +
                          clip[12 + row];
            render_clip_to_viewport(at, 1, 1, pixel);
            for (int k = 0; k < 2; ++k) {
                most[k] = fmax(most[k], pixel[k]);
                least[k] = fmin(least[k], pixel[k]);
            }
        }
        for (int k = 0; k < 2; ++k) assert_true(most[k] < 0.9 + 1e-9 && least[k] > 0.1 - 1e-9);
        assert_true(fmin(fabs(most[0] - 0.9) + fabs(least[0] - 0.1),
                        fabs(most[1] - 0.9) + fabs(least[1] - 0.1)) < 1e-9);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(world_to_view),
        cmocka_unit_test(to_clip_and_pixels), cmocka_unit_test(local_to_world),
        cmocka_unit_test(balls_by_hand), cmocka_unit_test(balls_of_many), cmocka_unit_test(frames)};
    return cmocka_run_group_tests_name("render_pipeline", tests, NULL, NULL);
}
