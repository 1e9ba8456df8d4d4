/* render_scenes.c: simple scenes for the tests of pictures. */
#include "render_scenes.h"
#include "check.h"

/* The leak sanitizer looks while the driver is still loaded: what that keeps until its end is not
 * lost yet, and later no one could tell whose it was. */
#if defined(__GNUC__)
__attribute__((weak)) void __lsan_do_leak_check(void);
#endif

static test_mesh room_for(size_t vertices, size_t triangles) {
    return (test_mesh){malloc(3 * vertices * sizeof(double)), malloc(3 * vertices * sizeof(float)),
        malloc(3 * triangles * sizeof(uint32_t)), vertices, triangles};
}

void free_test_mesh(test_mesh *mesh) {
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->corners);
}

test_mesh sphere_mesh(size_t around, size_t down) {
    const double pi = 3.14159265358979323846;
    test_mesh mesh = room_for((around + 1) * (down + 1), 2 * around * down);
    uint32_t *corner = mesh.corners;
    for (size_t j = 0; j <= down; ++j)
        for (size_t i = 0; i <= around; ++i) {
            const double polar = pi * (double)j / (double)down,
                         turn = 2 * pi * (double)(i % around) / (double)around;
            double *p = mesh.positions + 3 * (j * (around + 1) + i);
            p[0] = j % down ? sin(polar) * cos(turn) : 0;
            p[1] = cos(polar);
            p[2] = j % down ? -sin(polar) * sin(turn) : 0;
            for (int k = 0; k < 3; ++k)
                mesh.normals[3 * (j * (around + 1) + i) + (size_t)k] = (float)p[k];
        }
    for (size_t j = 0; j < down; ++j)
        for (size_t i = 0; i < around; ++i) {
            const uint32_t a = (uint32_t)(j * (around + 1) + i), b = a + 1,
                           c = a + (uint32_t)around + 1, d = c + 1;
            const uint32_t six[6] = {a, c, b, b, c, d};
            memcpy(corner, six, sizeof six);
            corner += 6;
        }
    return mesh;
}

test_mesh cube_mesh(void) {
    test_mesh mesh = room_for(24, 12);
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, sign = face % 2 ? -1 : 1, u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int k = 0; k < 4; ++k) {
            double *p = mesh.positions + 3 * (4 * face + k);
            float *n = mesh.normals + 3 * (4 * face + k);
            n[0] = n[1] = n[2] = 0;
            n[axis] = (float)sign;
            p[axis] = sign;
            p[u] = (k == 1 || k == 2 ? 1 : -1) * sign;
            p[v] = k >= 2 ? 1 : -1;
        }
        const uint32_t first = (uint32_t)(4 * face),
                       six[6] = {first, first + 1, first + 2, first, first + 2, first + 3};
        memcpy(mesh.corners + 6 * face, six, sizeof six);
    }
    return mesh;
}

render_surface surface_of(const test_mesh *mesh) {
    return (render_surface){.mesh = {.positions = {.data = mesh->positions,
                                         .count = mesh->vertices,
                                         .format = NORMA_FORMAT_DOUBLE},
                                .corners = mesh->corners,
                                .corner_count = 3 * mesh->triangles},
        .stored = RENDER_NORMALS_PER_VERTEX,
        .normals = {.data = mesh->normals, .count = mesh->vertices},
        .crease_rad = 1,
        .base_colour = {0.6F, 0.5F, 0.4F},
        .two_sided = 1};
}

render_scene scene_of(const render_surface *surface, render_draw *draw, const double *world) {
    static const double identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    draw->surface = 0;
    memcpy(draw->world, world ? world : identity, sizeof draw->world);
    return (render_scene){surface, 1, draw, 1};
}

render_look plain_look(size_t width, size_t height) {
    return (render_look){.width = width,
        .height = height,
        .samples = 1,
        .background = {255, 255, 255, 255},
        .lights = {{-35, 40, 0.9}},
        .light_count = 1,
        .ambient = 0.1,
        .diffuse = 0.8,
        .specular = 0.3,
        .exponent = 20,
        .line_pixels = 1.5,
        .reach = 0.5,
        .most_lines = 1000};
}

render_panel panel_of(const render_scene *scene) {
    return (render_panel){.scene = scene,
        .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
        .shading = RENDER_PHONG};
}

static render_device *device;

render_device *test_device(void) {
    render_error error;
    if (device) return device;
    if (render_device_open(1, &device, &error)) fprintf(stderr, "%s\n", error.message);
    return device;
}

void close_test_device(void) {
    if (__lsan_do_leak_check) __lsan_do_leak_check();
    render_device_close(device);
    device = NULL;
}

render_picture draw_panel(const render_look *look, render_panel *panel) {
    render_picture picture;
    render_error error;
    render_sheet sheet = {.panels = panel, .panel_count = 1};
    if (render_sheet_draw(device, look, &sheet, NULL, NULL, &picture, &error))
        fail_msg("%s", error.message);
    render_device_forget(device);
    return picture;
}

size_t differing(const render_picture *a, const render_picture *b, int levels, int *largest) {
    size_t count = 0;
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    *largest = 0;
    for (size_t i = 0; i < a->width * a->height; ++i) {
        int most = 0;
        for (size_t k = 0; k < 3; ++k) {
            const int difference = abs((int)a->pixels[4 * i + k] - (int)b->pixels[4 * i + k]);
            most = difference > most ? difference : most;
        }
        count += most > levels;
        *largest = most > *largest ? most : *largest;
    }
    return count;
}
