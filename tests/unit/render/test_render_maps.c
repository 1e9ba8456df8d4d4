/* test_render_maps.c: images on surfaces. A normal map of one colour must look like a surface that
 * stores the normal it stands for, by stored tangents, MikkTSpace's and derivatives, also mirrored;
 * texels come out as they went in; a mask cuts. Skipped where nothing can be drawn. */
#include "check.h"
#include "render_scenes.h"

typedef struct quad {
    double positions[12];
    float normals[12], texcoords[8], tangents[16];
} quad;
static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};

/* Over x and y from -1 to 1; v runs downwards, or, turned, u runs up and v to the right. */
static quad make_quad(int turned, const float normal[3]) {
    static const double ends[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    quad q = {0};
    for (size_t i = 0; i < 4; ++i) {
        const float right = (float)(0.5 + 0.5 * ends[i][0]), up = (float)(0.5 + 0.5 * ends[i][1]);
        q.positions[3 * i] = ends[i][0];
        q.positions[3 * i + 1] = ends[i][1];
        memcpy(q.normals + 3 * i, normal, 3 * sizeof *normal);
        q.texcoords[2 * i] = turned ? up : right;
        q.texcoords[2 * i + 1] = turned ? right : 1 - up;
    }
    return q;
}

static render_surface surface_of_quad(const quad *q) {
    return (render_surface){
        .mesh = {.positions = {.data = q->positions, .count = 4, .format = NORMA_FORMAT_DOUBLE},
            .corners = corners,
            .corner_count = 6},
        .stored = RENDER_NORMALS_PER_VERTEX,
        .normals = {.data = q->normals, .count = 4},
        .crease_rad = 1,
        .base_colour = {0.6F, 0.5F, 0.4F},
        .two_sided = 1};
}

static render_picture draw(const render_surface *surface, const double *world) {
    render_draw place;
    render_scene scene = scene_of(surface, &place, world);
    render_look look = plain_look(64, 64);
    render_panel panel = panel_of(&scene);
    return draw_panel(&look, &panel);
}

enum { STORED, COMPUTED, DERIVED };

static void check_normal_map(int turned, int tangents, const double *world) {
    static const float up[3] = {0, 0, 1};
    uint8_t texel[4] = {80, 160, 230, 255}; /* -0.373, 0.255, 0.804 */
    const render_picture image = {1, 1, texel};
    const float m[3] = {2 * 80 / 255.0F - 1, 2 * 160 / 255.0F - 1, 2 * 230 / 255.0F - 1};
    const float bent[3] = {turned ? -m[1] : m[0], turned ? m[0] : m[1], m[2]};
    quad flat = make_quad(turned, up), other = make_quad(turned, bent);
    for (size_t i = 0; i < 4 && tangents == STORED; ++i) {
        flat.tangents[4 * i + (turned ? 1 : 0)] = 1;
        flat.tangents[4 * i + 3] = 1;
    }
    render_surface mapped = surface_of_quad(&flat), plain = surface_of_quad(&other);
    mapped.normal_map = (render_texture){.picture = &image, .texcoords = flat.texcoords};
    mapped.normal_strength = 1;
    mapped.tangents = tangents == COMPUTED ? NULL : flat.tangents;
    render_picture a = draw(&mapped, world), b = draw(&plain, world);
    int largest;
    const size_t count = differing(&a, &b, 1, &largest);
    if (count) print_error("turned %d, tangents %d: %d levels off\n", turned, tangents, largest);
    assert_int_equal(count, 0);
    mapped.normal_strength = 0; /* the map without strength: another picture */
    render_picture c = draw(&mapped, world);
    assert_true(world || differing(&a, &c, 4, &largest) > 1000);
    render_picture_free(&a);
    render_picture_free(&b);
    render_picture_free(&c);
}

static void normal_maps(void **state) {
    static const double mirror[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    needs_device(state);
    for (int turned = 0; turned < 2; ++turned)
        for (int tangents = STORED; tangents <= DERIVED; ++tangents) {
            check_normal_map(turned, tangents, NULL);
            check_normal_map(turned, tangents, mirror);
        }
}

static const uint8_t *pixel(const render_picture *picture, size_t x, size_t y) {
    return picture->pixels + 4 * (y * picture->width + x);
}

/* A mask cuts its outline into the clay, and lends it no colour. */
static void masks(void **state) {
    static const float up[3] = {0, 0, 1};
    uint8_t texels[16] = {200, 10, 30, 255, 20, 180, 40, 255, 5, 60, 220, 255, 90, 90, 10, 0};
    const render_picture image = {2, 2, texels};
    needs_device(state);
    quad q = make_quad(0, up);
    render_surface surface = surface_of_quad(&q);
    render_picture plain = draw(&surface, NULL);
    surface.mask = (render_texture){
        .picture = &image, .texcoords = q.texcoords, .mag_filter = 9728, .min_filter = 9728};
    render_picture all = draw(&surface, NULL);
    surface.alpha_cutoff = 0.5F;
    render_picture cut = draw(&surface, NULL);
    int largest;
    assert_int_equal(differing(&all, &plain, 0, &largest), 0);
    for (size_t i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k) {
            const size_t x = i % 2 ? 48 : 16, y = i / 2 ? 48 : 16;
            const int clay = pixel(&plain, x, y)[k];
            assert_true(clay < 250);
            assert_int_equal(pixel(&cut, x, y)[k], i < 3 ? clay : 255); /* paper */
        }
    render_picture_free(&plain);
    render_picture_free(&all);
    render_picture_free(&cut);
}

static void images(void **state) {
    uint8_t pixels[24] = {1, 2, 3, 255, 250, 0, 9, 255, 0, 0, 0, 0, 9, 9, 9, 128, 7, 7, 7, 255};
    const render_picture picture = {3, 2, pixels};
    render_picture back;
    render_png png;
    render_error error;
    (void)state;
    assert_int_equal(render_png_encode(&picture, &png, &error), RENDER_OK);
    assert_int_equal(render_image_decode(png.bytes, png.size, &back, &error), RENDER_OK);
    assert_true(back.width == 3 && back.height == 2);
    assert_memory_equal(back.pixels, pixels, sizeof pixels);
    render_picture_free(&back);
    for (size_t size = 0; size < png.size - 12; ++size) /* all but its last, empty chunk */
        assert_int_not_equal(render_image_decode(png.bytes, size, &back, &error), RENDER_OK);
    free(png.bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(normal_maps),
        cmocka_unit_test(masks),
        cmocka_unit_test(images),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    close_test_device();
    return failed;
}
