/* pipeline.c: the way of a vertex: local, world, view, clip, viewport. The normals' way beside it
 * is norma_normal_matrix of the first step (draw.c). */
#include "render/camera/pipeline.h"
#include <math.h>
#include <string.h>

#define DEGREE 0.017453292519943295

void render_multiply(const double a[16], const double b[16], double product[16]) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
            product[4 * column + row] = sum;
        }
}

void render_point(const double m[16], const double p[3], double out[3]) {
    const double x = p[0], y = p[1], z = p[2];
    for (int row = 0; row < 3; ++row)
        out[row] = m[row] * x + m[4 + row] * y + m[8 + row] * z + m[12 + row];
}

void render_local_to_world(const double node[16], const double given[16], double matrix[16]) {
    render_multiply(given, node, matrix);
}

/* Quarter turns are exact: a view from the side is a view from the side. */
static void sine_cosine(double degrees, double *sine, double *cosine) {
    static const double exact[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
    const double turned = fmod(degrees, 360), quarters = turned / 90;
    if (quarters == floor(quarters)) {
        *sine = exact[((int)quarters + 4) % 4][0];
        *cosine = exact[((int)quarters + 4) % 4][1];
        return;
    }
    *sine = sin(turned * DEGREE);
    *cosine = cos(turned * DEGREE);
}

void render_camera_axes(
    const render_camera *camera, double right[3], double up[3], double back[3]) {
    double sa, ca, se, ce;
    sine_cosine(camera->azimuth_deg, &sa, &ca);
    sine_cosine(camera->elevation_deg, &se, &ce);
    const double axes[3][3] = {{ca, 0, -sa}, {-sa * se, ce, -ca * se}, {sa * ce, se, ca * ce}};
    double *const out[3] = {right, up, back};
    for (int i = 0; i < 3; ++i) {
        const double *a = axes[i];
        const double ways[RENDER_UPS][3] = {[RENDER_UP_Y] = {a[0], a[1], a[2]},
            [RENDER_UP_Z] = {a[0], -a[2], a[1]},
            [RENDER_UP_X] = {a[1], -a[0], a[2]},
            [RENDER_UP_MINUS_Y] = {a[0], -a[1], -a[2]},
            [RENDER_UP_MINUS_Z] = {a[0], a[2], -a[1]},
            [RENDER_UP_MINUS_X] = {-a[1], a[0], a[2]}};
        memcpy(out[i], ways[camera->up], sizeof ways[0]);
    }
}

void render_world_to_view(const render_camera *camera, double m[16]) {
    double axes[3][3];
    render_camera_axes(camera, axes[0], axes[1], axes[2]);
    memset(m, 0, 16 * sizeof *m);
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) {
            m[4 * column + row] = axes[row][column];
            m[12 + row] -= axes[row][column] * camera->centre[column];
        }
    }
    m[14] -= camera->distance;
    m[15] = 1;
}

void render_view_to_clip(const render_camera *camera, double m[16]) {
    const double farthest = camera->distance + camera->depth,
                 nearest = fmax(camera->distance - camera->depth, farthest * 1e-3);
    memset(m, 0, 16 * sizeof *m);
    if (camera->half_height > 0) {
        m[0] = 1 / (camera->half_height * camera->aspect);
        m[5] = 1 / camera->half_height;
        m[10] = -2 / (farthest - nearest);
        m[14] = -(farthest + nearest) / (farthest - nearest);
        m[15] = 1;
        return;
    }
    m[0] = 1 / (camera->tangent * camera->aspect);
    m[5] = 1 / camera->tangent;
    m[10] = -(farthest + nearest) / (farthest - nearest);
    m[11] = -1;
    m[14] = -2 * farthest * nearest / (farthest - nearest);
}

void render_clip_to_viewport(const double clip[4], size_t width, size_t height, double pixel[3]) {
    pixel[0] = (0.5 + 0.5 * clip[0] / clip[3]) * (double)width;
    pixel[1] = (0.5 - 0.5 * clip[1] / clip[3]) * (double)height;
    pixel[2] = 0.5 + 0.5 * clip[2] / clip[3];
}
