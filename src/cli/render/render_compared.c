/* render_compared.c: what norma compare found, as a picture. */
#include "cli/render/render.h"
#include "compare/compare_scene.h"
#include <stdlib.h>
#include <string.h>

enum { SIDES = 2 };

/* Of each corner: the normal of BASE that it was compared with. */
static float *base_normals(const compared_pair *pair) {
    float *normals = malloc((3 * pair->corners + 1) * sizeof *normals);
    for (size_t i = 0; i < pair->corners && normals; ++i)
        memcpy(normals + 3 * i, pair->samples[i].normal, 3 * sizeof *normals);
    return normals;
}

static enum render_up up_of(const compared_pair *pair, const render_surface *surface) {
    const norma_file_format format = norma_document_format(pair->other.document);
    if (norma_file_format_is_gltf(format)) return RENDER_UP_Y;
    return render_guess_up(surface, 1, format == NORMA_FILE_OBJ ? RENDER_UP_Y : RENDER_UP_Z);
}

static enum render_result draw_compared(const compared_pair *pair, const render_surface *surface,
    render_device *device, render_png *png, render_error *error) {
    static const render_draw draw = {.world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    const render_scene scene = {surface, 1, &draw, 1};
    char words[120], worst[32], most[32];
    render_settings settings;
    render_picture picture;
    render_panel panels[SIDES];
    render_settings_default(&settings);
    for (int i = 0; i < SIDES; ++i) {
        panels[i] = (render_panel){.scene = &scene,
            .azimuth_deg = settings.azimuth_deg + 180 * i,
            .elevation_deg = settings.elevation_deg,
            .up = up_of(pair, surface),
            .show = RENDER_SHOW_ERROR,
            .lines = RENDER_DOTS,
            .above = i ? "from behind" : "from the front"};
        memcpy(panels[i].matrix, settings.matrix.matrix, sizeof panels[i].matrix);
    }
    snprintf(words, sizeof words, "normals off by up to %s°, on 99 %% of the area by up to %s°",
        cli_decimals(worst, cli_to_degrees(pair->all.max_rad), 2),
        cli_decimals(most, cli_to_degrees(pair->all.p99_rad), 2));
    render_sheet sheet = {.panels = panels, .panel_count = SIDES, .below = words};
    enum render_result result =
        render_sheet_draw(device, &settings.look, &sheet, NULL, NULL, &picture, error);
    if (result) return result;
    result = render_png_encode(&picture, png, error);
    render_picture_free(&picture);
    return result;
}

int render_compared(
    const compared_pair *pair, const render_dot *dots, size_t dot_count, render_png *png) {
    render_device *device = NULL;
    render_error error = {.result = RENDER_ERROR_MEMORY, .message = "out of memory"};
    norma_surface other;
    int status = render_start(0, &device);
    if (status) return status;
    float *expected = base_normals(pair);
    if (compared_surface_make(&pair->other, 0, pair->other.count, &other) && expected) {
        const render_surface surface = {.mesh = other.mesh,
            .stored = RENDER_NORMALS_PER_CORNER,
            .normals = other.normals,
            .corner_normals = other.corner_normals,
            .expected = expected,
            .dots = dots,
            .dot_count = dot_count,
            .base_colour = {0.5F, 0.5F, 0.5F},
            .two_sided = 1};
        draw_compared(pair, &surface, device, png, &error);
    }
    if (!png->bytes) status = render_fail_drawing(pair->other.name, &error);
    render_device_close(device);
    compared_surface_free(&other);
    free(expected);
    return status;
}
