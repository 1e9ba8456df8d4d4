/* test_render.c: pictures against closed forms, and properties that hold whatever the renderer:
 * what light there is on a sphere, view space and world space, a model and a camera that turn
 * together, mirrors, windings, errors in degrees. Skipped where nothing can be drawn. */
#include "check.h"
#include "render_scenes.h"
#include <png.h>

#define RADIANS 0.017453292519943295

/* ---- Phong's model in double precision: the oracle. Written from the paper's terms, in the axes
 * of the camera, with sRGB from IEC 61966-2-1 */

static double encoded(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void make_unit(double v[3]) {
    const double length = sqrt(dot(v, v));
    for (int k = 0; k < 3; ++k) v[k] /= length;
}

static void phong_levels(const render_look *look, const float base[3], const double normal[3],
    const double to_eye[3], double levels[3]) {
    double diffuse = 0, specular = 0;
    for (int i = 0; i < look->light_count; ++i) {
        const double a = look->lights[i].azimuth_deg * RADIANS,
                     e = look->lights[i].elevation_deg * RADIANS;
        const double to_light[3] = {sin(a) * cos(e), sin(e), cos(a) * cos(e)},
                     facing = dot(normal, to_light);
        double mirrored[3];
        if (facing <= 0) continue;
        for (int k = 0; k < 3; ++k) mirrored[k] = 2 * facing * normal[k] - to_light[k];
        diffuse += look->lights[i].strength * facing;
        specular += look->lights[i].strength * pow(fmax(dot(mirrored, to_eye), 0), look->exponent);
    }
    for (int k = 0; k < 3; ++k)
        levels[k] =
            255 * encoded(fmin(1, (double)base[k] * (look->ambient + look->diffuse * diffuse) +
                                      look->specular * specular));
}

/* The ray of a pixel's middle meets the unit sphere; 0: it does not, or so near the rim that a
 * facet's edge may be met instead. Camera axes. */
static int sphere_under(
    const render_look *look, size_t x, size_t y, double point[3], double to_eye[3]) {
    const double room = 1 - 2 * RENDER_MARGIN,
                 across = 2 * ((double)x + 0.5) / (double)look->width - 1,
                 up = 1 - 2 * ((double)y + 0.5) / (double)look->height;
    if (!(look->field_of_view_deg > 0)) {
        point[0] = across / room;
        point[1] = up / room;
        point[2] = sqrt(fmax(0, 1 - point[0] * point[0] - point[1] * point[1]));
        to_eye[0] = to_eye[1] = 0;
        to_eye[2] = 1;
        return point[2] > 0.1;
    }
    /* All of the ball within the room: the eye is where a ray at the angle whose tangent is room *
     * tan(half the angle of view) touches it. */
    const double tangent = tan(look->field_of_view_deg / 2 * RADIANS),
                 distance = 1 / sin(atan(tangent * room));
    double ray[3] = {across * tangent, up * tangent, -1};
    make_unit(ray);
    const double along = distance * -ray[2], gap = along * along - (distance * distance - 1);
    if (gap <= 0) return 0;
    for (int k = 0; k < 3; ++k) point[k] = (k == 2 ? distance : 0) + (along - sqrt(gap)) * ray[k];
    for (int k = 0; k < 3; ++k) to_eye[k] = -ray[k];
    return dot(point, to_eye) > 0.1;
}

static void check_sphere(
    double field_of_view_deg, enum render_shading shading, enum render_space space) {
    test_mesh mesh = sphere_mesh(512, 256);
    render_surface surface = surface_of(&mesh);
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(200, 200);
    look.field_of_view_deg = field_of_view_deg;
    look.lights[1] = (render_light){70, -10, 0.3};
    look.light_count = 2;
    render_panel panel = panel_of(&scene);
    panel.shading = shading;
    panel.space = space;
    render_picture picture = draw_panel(&look, &panel);
    size_t compared = 0;
    double worst = 0;
    for (size_t y = 0; y < look.height; ++y)
        for (size_t x = 0; x < look.width; ++x) {
            double point[3], to_eye[3], levels[3];
            if (!sphere_under(&look, x, y, point, to_eye)) continue;
            phong_levels(&look, surface.base_colour, point, to_eye, levels);
            for (size_t k = 0; k < 3; ++k)
                worst = fmax(
                    worst, fabs(levels[k] - (double)picture.pixels[4 * (y * look.width + x) + k]));
            ++compared;
        }
    if (!(worst <= 1)) print_error("%g levels off\n", worst);
    assert_true(worst <= 1);
    assert_true(compared > 20000);
    render_picture_free(&picture);
    free_test_mesh(&mesh);
}

static void sphere_orthographic(void **state) {
    needs_device(state);
    check_sphere(0, RENDER_PHONG, RENDER_SPACE_WORLD);
}
static void sphere_perspective(void **state) {
    needs_device(state);
    check_sphere(40, RENDER_PHONG, RENDER_SPACE_WORLD);
    check_sphere(40, RENDER_PHONG, RENDER_SPACE_VIEW);
}
/* On facets a few hundredths of a pixel high, light interpolated between vertices is the light in
 * between. */
static void sphere_gouraud(void **state) {
    needs_device(state);
    check_sphere(25, RENDER_GOURAUD, RENDER_SPACE_WORLD);
}

/* Flat shading: the light of each face of a cube, exactly the model's. */
static void cube_flat(void **state) {
    needs_device(state);
    test_mesh mesh = cube_mesh();
    render_surface surface = surface_of(&mesh);
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(160, 160);
    look.specular = 0;
    render_panel panel = panel_of(&scene);
    panel.shading = RENDER_FLAT;
    render_picture picture = draw_panel(&look, &panel);
    const double to_eye[3] = {0, 0, 1}, front[3] = {0, 0, 1};
    double levels[3];
    phong_levels(&look, surface.base_colour, front, to_eye, levels);
    size_t inside = 0;
    for (size_t i = 0; i < 160 * 160; ++i) {
        const uint8_t *p = picture.pixels + 4 * i;
        const int paper = p[0] == 255 && p[1] == 255 && p[2] == 255;
        inside += !paper;
        for (int k = 0; k < 3 && !paper; ++k) assert_true(fabs(levels[k] - (double)p[k]) <= 1);
    }
    /* From the front an orthographic cube is a square of the room that the margins leave. */
    assert_true(fabs(sqrt((double)inside) - 160 * (1 - 2 * RENDER_MARGIN)) < 1.01);
    render_picture_free(&picture);
    free_test_mesh(&mesh);
}

/* ---- properties */

static const double sheared[16] = {
    1.3, 0.2, -0.1, 0, 0.7, 0.6, 0.3, 0, -0.2, 0.1, 1.9, 0, 4, -7, 2, 1};

static void view_is_world(void **state) {
    needs_device(state);
    test_mesh mesh = sphere_mesh(24, 12);
    render_surface surface = surface_of(&mesh);
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, sheared);
    render_look look = plain_look(180, 140);
    look.field_of_view_deg = 35;
    for (int plain = 0; plain < 2; ++plain)
        for (int shading = RENDER_FLAT; shading <= RENDER_PHONG; ++shading) {
            int largest;
            render_panel panel = panel_of(&scene);
            panel.shading = (enum render_shading)shading;
            panel.azimuth_deg = 33;
            panel.elevation_deg = -12;
            panel.plain = plain;
            render_picture world = draw_panel(&look, &panel);
            panel.space = RENDER_SPACE_VIEW;
            render_picture view = draw_panel(&look, &panel);
            differing(&world, &view, 1, &largest);
            assert_true(largest <= 1);
            render_picture_free(&world);
            render_picture_free(&view);
        }
    free_test_mesh(&mesh);
}

/* A rotation about the vertical, as a node has it. */
static void turn_about_y(double degrees, double m[16]) {
    const double s = degrees == 90 ? 1 : sin(degrees * RADIANS),
                 c = degrees == 90 ? 0 : cos(degrees * RADIANS);
    const double turn[16] = {c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 0, 0, 1};
    memcpy(m, turn, sizeof turn);
}

static void turning_together(void **state) {
    needs_device(state);
    test_mesh mesh = cube_mesh();
    render_surface surface = surface_of(&mesh);
    render_look look = plain_look(200, 160);
    look.field_of_view_deg = 30;
    for (int k = 0; k < 3; ++k) {
        static const double turns[] = {90, 37, -143.5};
        double turn[16];
        render_draw draw, turned_draw;
        int largest;
        turn_about_y(turns[k], turn);
        render_scene scene = scene_of(&surface, &draw, NULL),
                     turned_scene = scene_of(&surface, &turned_draw, turn);
        render_panel panel = panel_of(&scene), turned = panel_of(&turned_scene);
        panel.azimuth_deg = 21;
        turned.azimuth_deg = 21 + turns[k];
        panel.elevation_deg = turned.elevation_deg = 15;
        render_picture a = draw_panel(&look, &panel), b = draw_panel(&look, &turned);
        const size_t off = differing(&a, &b, 1, &largest);
        assert_true(off <= 20); /* of 32000: where an edge runs through the middle of a pixel,
                                   rounding decides which side of it */
        render_picture_free(&a);
        render_picture_free(&b);
    }
    free_test_mesh(&mesh);
}

/* A node that mirrors against the same mesh with its positions mirrored, its faces wound the other
 * way, its normals mirrored. One-sided: what is turned is not drawn. */
static void mirrored_twin(void **state) {
    needs_device(state);
    const double mirror[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    test_mesh mesh = cube_mesh(), twin = cube_mesh();
    for (size_t i = 0; i < twin.vertices; ++i) {
        mesh.positions[3 * i + 1] *=
            1 + 0.3 * mesh.positions[3 * i]; /* no symmetry that would hide a mistake */
        twin.positions[3 * i + 1] = mesh.positions[3 * i + 1];
        twin.positions[3 * i] *= -1;
        twin.normals[3 * i] *= -1;
    }
    for (size_t t = 0; t < twin.triangles; ++t) {
        const uint32_t kept = twin.corners[3 * t + 1];
        twin.corners[3 * t + 1] = twin.corners[3 * t + 2];
        twin.corners[3 * t + 2] = kept;
    }
    render_surface surfaces[2] = {surface_of(&mesh), surface_of(&twin)};
    surfaces[0].two_sided = surfaces[1].two_sided = 0;
    render_look look = plain_look(160, 160);
    look.field_of_view_deg = 30;
    for (int shading = RENDER_FLAT; shading <= RENDER_PHONG; ++shading)
        for (int show = RENDER_SHOW_LIT; show <= RENDER_SHOW_WINDING; ++show) {
            render_draw draws[2];
            int largest;
            render_scene a_scene = scene_of(&surfaces[0], &draws[0], mirror),
                         b_scene = scene_of(&surfaces[1], &draws[1], NULL);
            render_panel a_panel = panel_of(&a_scene), b_panel = panel_of(&b_scene);
            a_panel.azimuth_deg = b_panel.azimuth_deg = 30;
            a_panel.elevation_deg = b_panel.elevation_deg = 25;
            a_panel.shading = b_panel.shading = (enum render_shading)shading;
            a_panel.show = b_panel.show = (enum render_show)show;
            render_picture a = draw_panel(&look, &a_panel), b = draw_panel(&look, &b_panel);
            assert_true(differing(&a, &b, 1, &largest) <= 10);
            /* And there is something to see: not the paper, nor the inside. */
            assert_true(a.pixels[4 * (80 * 160 + 80)] < 250);
            render_picture_free(&a);
            render_picture_free(&b);
        }
    free_test_mesh(&mesh);
    free_test_mesh(&twin);
}

/* The sphere's vertices lie at 45 degrees in the plane of x and y and of x and z, where plain M
 * errs most. */
static void plain_error(void **state) {
    needs_device(state);
    test_mesh mesh = sphere_mesh(32, 16);
    render_surface surface = surface_of(&mesh);
    static const double scales[] = {1.25, 1.5, 2, 4, 10};
    render_look look = plain_look(32, 32);
    for (size_t i = 0; i < COUNT_OF(scales); ++i) {
        const double s = scales[i], world[16] = {s, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 9, 9, 9, 1};
        render_draw draw;
        render_scene scene = scene_of(&surface, &draw, world);
        render_panel panel = panel_of(&scene);
        panel.plain = panel.measured = 1;
        render_picture picture = draw_panel(&look, &panel);
        assert_true(fabs(panel.worst_plain_rad - asin((s * s - 1) / (s * s + 1))) < 1e-6);
        render_picture_free(&picture);
    }
    free_test_mesh(&mesh);
}

/* ---- single pixels */

static const double square_positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const float square_normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
static const uint32_t square_corners[6] = {0, 1, 2, 0, 2, 3};

static render_surface square(void) {
    const test_mesh mesh = {
        (double *)square_positions, (float *)square_normals, (uint32_t *)square_corners, 4, 2};
    return surface_of(&mesh);
}

static const uint8_t *middle_of(const render_picture *picture) {
    return picture->pixels + 4 * (picture->height / 2 * picture->width + picture->width / 2);
}

static void windings(void **state) {
    needs_device(state);
    const double mirror[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    render_surface surface = square();
    render_look look = plain_look(32, 32);
    for (int k = 0; k < 4; ++k) {
        render_draw draw;
        render_scene scene = scene_of(&surface, &draw, k & 1 ? mirror : NULL);
        render_panel panel = panel_of(&scene);
        panel.show = RENDER_SHOW_WINDING;
        panel.azimuth_deg = k & 2 ? 180 : 0;
        surface.two_sided = k & 1;
        render_picture picture = draw_panel(&look, &panel);
        const uint8_t *p = middle_of(&picture);
        if (k & 2)
            assert_true(p[0] > p[1] + 80 && p[0] > p[2] + 80);
        else
            assert_true(p[1] > p[0] + 80 && p[1] > p[2] + 40);
        render_picture_free(&picture);
    }
}

static void normals_as_colours(void **state) {
    needs_device(state);
    test_mesh mesh = cube_mesh();
    render_surface surface = surface_of(&mesh);
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(32, 32);
    static const struct {
        double azimuth, elevation;
        int colour[3];
    } sides[] = {{0, 0, {128, 128, 255}}, {90, 0, {255, 128, 128}}, {0, 90, {128, 255, 128}},
        {180, 0, {128, 128, 0}}, {-90, 0, {0, 128, 128}}, {0, -90, {128, 0, 128}}};
    for (size_t i = 0; i < COUNT_OF(sides); ++i)
        for (int space = 0; space < 2; ++space) {
            render_panel panel = panel_of(&scene);
            panel.show = RENDER_SHOW_NORMALS;
            panel.azimuth_deg = sides[i].azimuth;
            panel.elevation_deg = sides[i].elevation;
            panel.space = (enum render_space)space;
            render_picture picture = draw_panel(&look, &panel);
            for (int k = 0; k < 3; ++k)
                assert_true(abs(middle_of(&picture)[k] - (space ? (const int[3]){128, 128, 255}[k]
                                                                : sides[i].colour[k])) <= 1);
            render_picture_free(&picture);
        }
    free_test_mesh(&mesh);
}

/* A back face of a double-sided surface is lit as the front of its other side; of a one-sided one
 * there is nothing. */
static void two_sides(void **state) {
    needs_device(state);
    render_surface surface = square();
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(32, 32);
    for (int shading = RENDER_FLAT; shading <= RENDER_PHONG; ++shading) {
        int largest;
        render_panel panel = panel_of(&scene);
        panel.shading = (enum render_shading)shading;
        surface.two_sided = 1;
        render_picture front = draw_panel(&look, &panel);
        panel.azimuth_deg = 180;
        render_picture back = draw_panel(&look, &panel);
        assert_int_equal(differing(&front, &back, 1, &largest), 0);
        surface.two_sided = 0;
        render_picture nothing = draw_panel(&look, &panel);
        assert_int_equal(middle_of(&nothing)[0], 255);
        assert_true(middle_of(&front)[0] < 250);
        render_picture_free(&front);
        render_picture_free(&back);
        render_picture_free(&nothing);
    }
}

/* Normals that lean by 10 degrees, against those of the plane they belong to. */
static void stored_errors(void **state) {
    needs_device(state);
    float leaning[12];
    for (int i = 0; i < 4; ++i) {
        leaning[3 * i] = (float)sin(10 * RADIANS);
        leaning[3 * i + 1] = 0;
        leaning[3 * i + 2] = (float)cos(10 * RADIANS);
    }
    render_surface surface = square();
    surface.normals.data = leaning;
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(64, 64);
    look.error_top_deg = 10;
    render_panel panel = panel_of(&scene);
    panel.show = RENDER_SHOW_ERROR;
    render_picture picture = draw_panel(&look, &panel);
    assert_true(fabs(panel.worst_error_rad * DEGREES - 10) < 1e-4);
    /* The top of the scale, and beside it the legend that says so. */
    const uint8_t *p = picture.pixels + 4 * (32 * 64 + 32);
    assert_true(abs(p[0] - 253) <= 2 && abs(p[1] - 231) <= 2 && abs(p[2] - 37) <= 2);
    assert_true(picture.height > 64);
    render_picture_free(&picture);
    surface.stored = RENDER_NORMALS_NONE;
    picture = draw_panel(&look, &panel);
    assert_true(isnan(panel.worst_error_rad));
    render_picture_free(&picture);
}

/* One normal of a grid is turned round: the scale is that of the others, which lean by 2.5 degrees.
 */
static void one_bad_normal(void **state) {
    needs_device(state);
    enum { SIDE = 30, POINTS = SIDE * SIDE, CORNERS = 6 * (SIDE - 1) * (SIDE - 1) };
    static float positions[3 * POINTS], normals[3 * POINTS];
    static uint32_t corners[CORNERS];
    size_t used = 0;
    for (uint32_t i = 0; i < POINTS; ++i) {
        positions[3 * i] = (float)(i % SIDE);
        positions[3 * i + 1] = (float)(i / SIDE);
        normals[3 * i] = (float)sin(2.5 * RADIANS);
        normals[3 * i + 2] = (float)cos(2.5 * RADIANS);
        if (i % SIDE == SIDE - 1 || i / SIDE == SIDE - 1) continue;
        const uint32_t face[6] = {i, i + 1, i + SIDE, i + SIDE, i + 1, i + SIDE + 1};
        memcpy(corners + used, face, sizeof face);
        used += 6;
    }
    normals[3 * (POINTS / 2 + SIDE / 2) + 2] *= -1;
    render_surface surface = square();
    surface.mesh.positions = (norma_vec3_view){.data = positions, .count = POINTS};
    surface.mesh.corners = corners;
    surface.mesh.corner_size = 4;
    surface.mesh.corner_count = CORNERS;
    surface.normals = (norma_vec3_view){.data = normals, .count = POINTS};
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    const render_look look = plain_look(64, 64);
    render_panel panel = panel_of(&scene);
    panel.show = RENDER_SHOW_ERROR;
    render_picture picture = draw_panel(&look, &panel);
    assert_true(panel.worst_error_rad * DEGREES > 170);
    assert_true(panel.most_errors_rad * DEGREES > 2.49 && panel.most_errors_rad * DEGREES < 2.7);
    /* 2.5 of 5 degrees, the middle of viridis; of 180 it would be 68, 1, 84, the colour of none. */
    const uint8_t *p = picture.pixels + 4 * (20 * 64 + 20);
    assert_true(abs(p[0] - 33) <= 4 && abs(p[1] - 145) <= 4 && abs(p[2] - 140) <= 4);
    render_picture_free(&picture);
}

/* ---- shapes */

static size_t covered(const render_picture *picture) {
    size_t count = 0;
    for (size_t i = 0; i < picture->width * picture->height; ++i)
        count += picture->pixels[4 * i] != 255 || picture->pixels[4 * i + 1] != 255;
    return count;
}

/* A plus of one polygon with twelve corners, arms of half-length 2: its area is 14 half units by 2
 * (FACTS: 7 of 16 of its square). */
static void concave_polygon(void **state) {
    needs_device(state);
    static const double plus[36] = {0.5, 0.5, 0, 2, 0.5, 0, 2, -0.5, 0, 0.5, -0.5, 0, 0.5, -2, 0,
        -0.5, -2, 0, -0.5, -0.5, 0, -2, -0.5, 0, -2, 0.5, 0, -0.5, 0.5, 0, -0.5, 2, 0, 0.5, 2, 0};
    uint32_t corners[12], starts[2] = {0, 12};
    render_look look = plain_look(200, 200);
    for (uint32_t first = 0; first < 12; ++first)
        for (int reversed = 0; reversed < 2; ++reversed) {
            for (uint32_t i = 0; i < 12; ++i)
                corners[i] = (reversed ? 24 - i + first : i + first) % 12;
            const render_surface surface = {
                .mesh = {.positions = {.data = plus, .count = 12, .format = NORMA_FORMAT_DOUBLE},
                    .corners = corners,
                    .corner_count = 12,
                    .face_starts = starts,
                    .face_count = 1},
                .two_sided = 1,
                .crease_rad = 1};
            render_draw draw;
            render_scene scene = scene_of(&surface, &draw, NULL);
            render_panel panel = panel_of(&scene);
            render_picture picture = draw_panel(&look, &panel);
            const double side = 200 * (1 - 2 * RENDER_MARGIN),
                         part = (double)covered(&picture) / (side * side);
            assert_true(fabs(part - 7.0 / 16) < 0.01);
            assert_int_equal(panel.triangles, 10);
            render_picture_free(&picture);
        }
}

/* Doubles four million from the origin: the picture is that of the mesh where it was made. */
static void far_away(void **state) {
    needs_device(state);
    test_mesh mesh = sphere_mesh(48, 24), moved = sphere_mesh(48, 24);
    for (size_t i = 0; i < moved.vertices; ++i) moved.positions[3 * i] += 4194304;
    render_surface surfaces[2] = {surface_of(&mesh), surface_of(&moved)};
    render_look look = plain_look(100, 100);
    render_picture pictures[2];
    int largest;
    for (int i = 0; i < 2; ++i) {
        render_draw draw;
        render_scene scene = scene_of(&surfaces[i], &draw, NULL);
        render_panel panel = panel_of(&scene);
        pictures[i] = draw_panel(&look, &panel);
    }
    assert_true(differing(&pictures[0], &pictures[1], 1, &largest) <= 4);
    render_picture_free(&pictures[0]);
    render_picture_free(&pictures[1]);
    free_test_mesh(&mesh);
    free_test_mesh(&moved);
}

/* Whatever the unit: 1e-30 and 1e30 are one picture. */
static void any_size(void **state) {
    needs_device(state);
    test_mesh mesh = cube_mesh();
    render_surface surface = surface_of(&mesh);
    render_look look = plain_look(100, 100);
    render_picture pictures[2];
    int largest;
    for (int i = 0; i < 2; ++i) {
        const double s = i ? 1e30 : 1e-30,
                     world[16] = {s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0, 0, 0, 0, 1};
        render_draw draw;
        render_scene scene = scene_of(&surface, &draw, world);
        render_panel panel = panel_of(&scene);
        panel.azimuth_deg = 30;
        pictures[i] = draw_panel(&look, &panel);
        assert_true(covered(&pictures[i]) > 3000);
    }
    assert_true(differing(&pictures[0], &pictures[1], 1, &largest) <= 4);
    render_picture_free(&pictures[0]);
    render_picture_free(&pictures[1]);
    free_test_mesh(&mesh);
}

/* A corner that is not finite takes its triangle along and nothing else; a position that no face
 * uses does not widen the picture. */
static void broken_positions(void **state) {
    needs_device(state);
    double positions[15];
    memcpy(positions, square_positions, sizeof square_positions);
    positions[9] = NAN;
    positions[12] = positions[13] = positions[14] = 1e9;
    const render_surface surface = {
        .mesh = {.positions = {.data = positions, .count = 5, .format = NORMA_FORMAT_DOUBLE},
            .corners = square_corners,
            .corner_count = 6},
        .two_sided = 1,
        .crease_rad = 1};
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(100, 100);
    for (int shading = RENDER_FLAT; shading <= RENDER_PHONG; ++shading) {
        render_panel panel = panel_of(&scene);
        panel.shading = (enum render_shading)shading;
        render_picture picture = draw_panel(&look, &panel);
        const double part = (double)covered(&picture) / (88 * 88);
        assert_true(fabs(part - 0.5) < 0.02);
        assert_int_equal(panel.triangles, 1);
        render_picture_free(&picture);
    }
}

/* ---- the same again, and as a file */

static void same_again(void **state) {
    needs_device(state);
    test_mesh mesh = sphere_mesh(40, 20);
    render_surface surface = surface_of(&mesh);
    surface.stored = RENDER_NORMALS_NONE;
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, sheared);
    render_look look = plain_look(150, 100);
    look.samples = 2;
    render_picture pictures[2];
    for (int i = 0; i < 2; ++i) {
        render_panel panel = panel_of(&scene);
        panel.lines = RENDER_VERTEX_LINES | RENDER_FACE_LINES | RENDER_WIREFRAME;
        panel.azimuth_deg = 50;
        pictures[i] = draw_panel(&look, &panel);
    }
    assert_memory_equal(
        pictures[0].pixels, pictures[1].pixels, 4 * pictures[0].width * pictures[0].height);
    render_picture_free(&pictures[0]);
    render_picture_free(&pictures[1]);
    free_test_mesh(&mesh);
}

static int has_chunk(const render_png *png, const char *name, size_t length) {
    for (size_t at = 8; at + 12 <= png->size;) {
        const uint8_t *b = png->bytes + at;
        const size_t size = (size_t)b[0] << 24 | (size_t)b[1] << 16 | (size_t)b[2] << 8 | b[3];
        if (memcmp(b + 4, name, 4) == 0) return size == length;
        at += 12 + size;
    }
    return 0;
}

/* Written by us, read by libpng's simplified reader: the same pixels, told to be sRGB. */
static void png_round_trip(void **state) {
    (void)state;
    for (int transparent = 0; transparent < 2; ++transparent) {
        render_picture picture = {19, 7, malloc(4 * 19 * 7)};
        render_png png;
        render_error error;
        for (size_t i = 0; i < 4 * 19 * 7; ++i)
            picture.pixels[i] = i % 4 == 3 && !transparent ? 255 : (uint8_t)(i * 37 + i / 5);
        assert_int_equal(render_png_encode(&picture, &png, &error), RENDER_OK);
        assert_true(has_chunk(&png, "sRGB", 1));
        assert_true(has_chunk(&png, "IHDR", 13));
        assert_int_equal(png.bytes[25], transparent ? 6 : 2);
        png_image image = {.version = PNG_IMAGE_VERSION};
        uint8_t read[4 * 19 * 7];
        assert_true(png_image_begin_read_from_memory(&image, png.bytes, png.size));
        image.format = PNG_FORMAT_RGBA;
        assert_true(png_image_finish_read(&image, NULL, read, 0, NULL));
        assert_memory_equal(read, picture.pixels, sizeof read);
        free(png.bytes);
        render_picture_free(&picture);
    }
}

/* A white square on black whose borders run through the middle of pixels: half of the light, which
 * is level 188, not half of the levels. */
static void means_in_linear_light(void **state) {
    needs_device(state);
    render_surface surface = square();
    for (int k = 0; k < 3; ++k) surface.base_colour[k] = 1;
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(25, 25); /* the margin is 1.5 pixels */
    look.ambient = 1;
    look.diffuse = look.specular = 0;
    look.samples = 2;
    look.background[0] = look.background[1] = look.background[2] = 0;
    render_panel panel = panel_of(&scene);
    render_picture picture = draw_panel(&look, &panel);
    static const int expected[25] = {0, 188, 255, [22] = 255, 188, 0};
    for (size_t x = 0; x < 25; ++x)
        if (x < 3 || x > 21) assert_int_equal(picture.pixels[4 * (12 * 25 + x)], expected[x]);
    render_picture_free(&picture);
}

/* A transparent background leaves only the model, and the model's colours. */
static void transparent_background(void **state) {
    needs_device(state);
    render_surface surface = square();
    render_draw draw;
    render_scene scene = scene_of(&surface, &draw, NULL);
    render_look look = plain_look(64, 64);
    look.samples = 2;
    render_panel panel = panel_of(&scene);
    panel.lines = RENDER_VERTEX_LINES;
    render_picture opaque = draw_panel(&look, &panel);
    memset(look.background, 0, 4);
    render_picture clear = draw_panel(&look, &panel);
    assert_int_equal(clear.pixels[3], 0);
    assert_int_equal(middle_of(&clear)[3], 255);
    for (int k = 0; k < 3; ++k) assert_true(abs(middle_of(&clear)[k] - middle_of(&opaque)[k]) <= 1);
    render_picture_free(&opaque);
    render_picture_free(&clear);
}

/* Two panels side by side, pixels that are of a line in neither left aside: how many differ. */
static size_t apart(const render_picture *picture) {
    size_t count = 0;
    for (size_t y = 0; y < picture->height; ++y)
        for (size_t x = 0; x < picture->width / 2; ++x) {
            const uint8_t *a = picture->pixels + 4 * (y * picture->width + x),
                          *b = a + 4 * (picture->width / 2);
            const int is_line = a[0] > a[1] + 14 || b[0] > b[1] + 14;
            count += !is_line && abs(a[1] - b[1]) > 4;
        }
    return count;
}

/* The lines of one cube stand upright, those of the other lean to the right: of one file, the cubes
 * stand in one place; of two, each is framed with its own lines. */
static void side_by_side(void **state) {
    needs_device(state);
    test_mesh meshes[2] = {cube_mesh(), cube_mesh()};
    for (size_t i = 0; i < meshes[1].vertices; ++i) {
        float *n = meshes[1].normals + 3 * i;
        n[0] = 1;
        n[1] = n[2] = 0;
    }
    render_surface surfaces[2] = {surface_of(&meshes[0]), surface_of(&meshes[1])};
    render_look look = plain_look(120, 120);
    look.reach = 2;
    render_draw draws[2];
    render_scene scenes[2] = {
        scene_of(&surfaces[0], &draws[0], NULL), scene_of(&surfaces[1], &draws[1], NULL)};
    render_panel panels[2] = {panel_of(&scenes[0]), panel_of(&scenes[1])};
    for (size_t i = 0; i < 2; ++i) {
        panels[i].shading = RENDER_FLAT;
        panels[i].azimuth_deg = panels[i].elevation_deg = 30;
        panels[i].lines = RENDER_VERTEX_LINES;
        panels[i].line_colour = 0xFF0000;
    }
    render_sheet sheet = {.panels = panels, .panel_count = 2};
    render_picture picture;
    render_error error;
    assert_int_equal(
        render_sheet_draw(test_device(), &look, &sheet, NULL, NULL, &picture, &error), RENDER_OK);
    assert_int_equal(picture.width, 240);
    assert_true(apart(&picture) <= 40); /* rims of lines */
    render_picture_free(&picture);
    render_device_forget(test_device());
    free_test_mesh(&meshes[0]);
    free_test_mesh(&meshes[1]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(side_by_side),
        cmocka_unit_test(sphere_orthographic),
        cmocka_unit_test(sphere_perspective),
        cmocka_unit_test(sphere_gouraud),
        cmocka_unit_test(cube_flat),
        cmocka_unit_test(view_is_world),
        cmocka_unit_test(turning_together),
        cmocka_unit_test(mirrored_twin),
        cmocka_unit_test(plain_error),
        cmocka_unit_test(windings),
        cmocka_unit_test(normals_as_colours),
        cmocka_unit_test(two_sides),
        cmocka_unit_test(stored_errors),
        cmocka_unit_test(one_bad_normal),
        cmocka_unit_test(concave_polygon),
        cmocka_unit_test(far_away),
        cmocka_unit_test(any_size),
        cmocka_unit_test(broken_positions),
        cmocka_unit_test(same_again),
        cmocka_unit_test(png_round_trip),
        cmocka_unit_test(transparent_background),
        cmocka_unit_test(means_in_linear_light),
    };
    const int failed = cmocka_run_group_tests_name("render", tests, NULL, NULL);
    close_test_device();
    return failed;
}
