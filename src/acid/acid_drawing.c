/* acid_drawing.c: a patch as a small picture, seen from +z in the lights of the scene. Square roots
 * encode it, not sRGB's powers: the same bytes everywhere. */
#include "acid/acid_mesh.h"

static void shade(const acid_patch *patch, double white, const acid_vertex *const corners[3],
    const double shares[3], uint8_t pixel[3]) {
    double n[3] = {0}, color[3] = {0};
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            n[k] += shares[i] * (double)corners[i]->normal[k];
            color[k] += shares[i] * (double)corners[i]->color[k];
        }
    const acid_vector normal = acid_unit((acid_vector){n[0], n[1], n[2]});
    for (int k = 0; k < ACID_LIGHTS; ++k) {
        const double lit =
            (patch->has_color ? color[k] : white) * fmax(0, acid_dot(acid_lights[k], normal));
        pixel[k] = (uint8_t)(255 * sqrt(fmin(1, lit)) + 0.5);
    }
}

/* Of a and b about c: twice their triangle's area, above 0 if they run counterclockwise. */
static double area_of(const double a[2], const double b[2], const double c[2]) {
    return (a[0] - c[0]) * (b[1] - c[1]) - (a[1] - c[1]) * (b[0] - c[0]);
}

static void draw_triangle(
    const acid_patch *patch, double white, const uint16_t *indices, int side, uint8_t *pixels) {
    const acid_vertex *corners[3];
    double at[3][2], low[2] = {side, side}, high[2] = {0, 0};
    for (int i = 0; i < 3; ++i) {
        corners[i] = &patch->vertices[indices[i]];
        for (int k = 0; k < 2; ++k) {
            const double along = (double)corners[i]->position[k] / (2 * ACID_HALF);
            at[i][k] = side * (k ? 0.5 - along : 0.5 + along);
            low[k] = fmax(0, fmin(low[k], floor(at[i][k])));
            high[k] = fmin(side, fmax(high[k], ceil(at[i][k])));
        }
    }
    const double area = area_of(at[0], at[1], at[2]);
    for (int y = (int)low[1]; y < (int)high[1] && area != 0; ++y)
        for (int x = (int)low[0]; x < (int)high[0]; ++x) {
            const double p[2] = {x + 0.5, y + 0.5},
                         shares[3] = {area_of(at[1], at[2], p) / area,
                             area_of(at[2], at[0], p) / area, area_of(at[0], at[1], p) / area};
            if (fmin(shares[0], fmin(shares[1], shares[2])) >= 0)
                shade(patch, white, corners, shares, pixels + 3 * (y * side + x));
        }
}

void acid_draw_patch(const acid_patch *patch, double white, int side, uint8_t *pixels) {
    for (size_t i = 0; i < patch->index_count; i += 3)
        draw_triangle(patch, white, patch->indices + i, side, pixels);
}
