/* camera.c: how a scene is framed: the ball round it, and the way from local space to pixels. */
#include "render/camera/camera.h"
#include <math.h>
#include <string.h>

/* ---- The smallest ball round points, found by taking in the farthest point until none
 * is outside (Gaertner 1999), and the closest frame of a camera. */

enum { MOST_SUPPORT = 4 };

typedef struct support {
    double points[MOST_SUPPORT + 1][3];
    int count;
} support;

static double distance_squared(const double a[3], const double b[3]) {
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return x * x + y * y + z * z;
}

/* Solves a system of up to three equations in place; 0: singular. */
static int solve(double m[3][4], int size) {
    for (int i = 0; i < size; ++i) {
        int best = i;
        for (int row = i + 1; row < size; ++row)
            best = fabs(m[row][i]) > fabs(m[best][i]) ? row : best;
        if (fabs(m[best][i]) < 1e-12) return 0;
        for (int k = 0; k <= 3; ++k) {
            const double kept = m[i][k];
            m[i][k] = m[best][k];
            m[best][k] = kept;
        }
        for (int row = 0; row < size; ++row) {
            const double factor = m[row][i] / m[i][i];
            for (int k = i; k <= 3 && row != i; ++k)
                m[row][k] -= k == 3 || k < size ? factor * m[i][k] : 0;
        }
    }
    return 1;
}

/* The smallest ball with all chosen points on it: its centre lies in their plane. Returns 0 if no
 * such ball exists. */
static int ball_through(const support *s, unsigned chosen, render_ball *ball) {
    double edges[3][3], system[3][4] = {{0}}, scale = 0;
    const double *origin = NULL;
    int size = 0;
    for (int i = 0; i < s->count; ++i) {
        if (!(chosen >> i & 1)) continue;
        if (!origin) {
            origin = s->points[i];
            continue;
        }
        if (size == 3) return 0;
        for (int k = 0; k < 3; ++k) edges[size][k] = s->points[i][k] - origin[k];
        scale = fmax(scale, distance_squared(s->points[i], origin));
        ++size;
    }
    if (!origin || (size > 0 && !(scale > 0))) return 0;
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j < size; ++j)
            for (int k = 0; k < 3; ++k) system[i][j] += 2 * edges[i][k] * edges[j][k] / scale;
        system[i][3] = system[i][i] / 2;
    }
    if (!solve(system, size)) return 0;
    memcpy(ball->centre, origin, sizeof ball->centre);
    for (int i = 0; i < size; ++i)
        for (int k = 0; k < 3; ++k) ball->centre[k] += system[i][3] / system[i][i] * edges[i][k];
    ball->radius = sqrt(distance_squared(ball->centre, origin));
    return 1;
}

static int holds_all(const render_ball *ball, const support *s) {
    for (int i = 0; i < s->count; ++i)
        if (sqrt(distance_squared(ball->centre, s->points[i])) > ball->radius * (1 + 1e-9))
            return 0;
    return 1;
}

/* Of at most five points: the smallest of the balls through some of them that hold all. Keeps the
 * points that lie on it. */
static void tighten(support *s, render_ball *ball) {
    unsigned kept = 0;
    render_ball best = {.radius = INFINITY}, tried;
    for (unsigned chosen = 1; chosen < 1U << s->count; ++chosen)
        if (ball_through(s, chosen, &tried) && tried.radius < best.radius && holds_all(&tried, s)) {
            best = tried;
            kept = chosen;
        }
    if (!kept) return;
    int count = 0;
    for (int i = 0; i < s->count; ++i)
        if (kept >> i & 1) memmove(s->points[count++], s->points[i], sizeof s->points[i]);
    s->count = count;
    *ball = best;
}

static double farthest_point(
    const render_cloud *clouds, size_t count, const double centre[3], double point[3]) {
    double most = -1;
    for (size_t c = 0; c < count; ++c)
        for (size_t i = 0; i < clouds[c].count; ++i) {
            const float *at = clouds[c].points + 3 * i;
            const double local[3] = {(double)at[0], (double)at[1], (double)at[2]};
            double world[3], squared;
            render_point(clouds[c].matrix, local, world);
            squared = distance_squared(world, centre);
            if (squared > most) {
                most = squared;
                memcpy(point, world, sizeof world);
            }
        }
    return most < 0 ? -1 : sqrt(most);
}

render_ball render_smallest_ball(const render_cloud *clouds, size_t count) {
    const int most_rounds = 60; /* each takes in a point and makes the ball larger; ten are usual */
    render_ball ball = {.radius = 0};
    support s = {.count = 0};
    double far = 0;
    for (size_t c = 0; c < count && s.count == 0; ++c)
        if (clouds[c].count > 0) {
            const double first[3] = {(double)clouds[c].points[0], (double)clouds[c].points[1],
                (double)clouds[c].points[2]};
            render_point(clouds[c].matrix, first, ball.centre);
            memcpy(s.points[s.count++], ball.centre, sizeof ball.centre);
        }
    for (int round = 0; round < most_rounds && s.count > 0; ++round) {
        double point[3];
        far = farthest_point(clouds, count, ball.centre, point);
        if (far <= ball.radius * (1 + 1e-7)) break;
        if (s.count > MOST_SUPPORT) break;
        memcpy(s.points[s.count++], point, sizeof point);
        tighten(&s, &ball);
    }
    ball.radius = fmax(ball.radius, far);
    return ball;
}

/* With the eye at distance d and shifted by (u, v), a point (x, y, z) of the camera's axes, z to
 * the eye, is inside where |x - u| <= t (d - z): the largest x + t z and -x + t z of all points
 * give u and the least d. */
render_frame render_closest_frame(const render_camera *camera, int orthographic, double margin,
    const render_cloud *clouds, size_t count) {
    const double room = 1 - 2 * margin,
                 tangent[2] = {camera->tangent * camera->aspect * room, camera->tangent * room};
    double axes[3][3];
    render_frame frame = {.most = {-INFINITY, -INFINITY}, .least = {-INFINITY, -INFINITY}};
    render_camera_axes(camera, axes[0], axes[1], axes[2]);
    for (size_t c = 0; c < count; ++c)
        for (size_t i = 0; i < clouds[c].count; ++i) {
            const float *at = clouds[c].points + 3 * i;
            const double local[3] = {(double)at[0], (double)at[1], (double)at[2]};
            double world[3], seen[3];
            render_point(clouds[c].matrix, local, world);
            for (int k = 0; k < 3; ++k)
                seen[k] = (world[0] - camera->centre[0]) * axes[k][0] +
                          (world[1] - camera->centre[1]) * axes[k][1] +
                          (world[2] - camera->centre[2]) * axes[k][2];
            for (int k = 0; k < 2; ++k) {
                const double lean = orthographic ? 0 : tangent[k] * seen[2];
                frame.most[k] = fmax(frame.most[k], seen[k] + lean);
                frame.least[k] = fmax(frame.least[k], -seen[k] + lean);
            }
        }
    for (int k = 0; k < 2 && frame.most[0] > -INFINITY; ++k)
        frame.per[k] = orthographic ? room * (k == 0 ? camera->aspect : 1) : tangent[k];
    render_fit_frame(&frame);
    return frame;
}

void render_fit_frame(render_frame *frame) {
    frame->distance = 0;
    for (int k = 0; k < 2 && frame->per[0] > 0; ++k) {
        frame->middle[k] = (frame->most[k] - frame->least[k]) / 2;
        frame->distance =
            fmax(frame->distance, (frame->most[k] + frame->least[k]) / 2 / frame->per[k]);
    }
}

/* ---- The way of a vertex: local, world, view, clip, viewport. The normals' way beside it
 * is norma_normal_matrix of the first step (draw.c). */

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
static void exact_sine_cosine(double degrees, double *sine, double *cosine) {
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
    exact_sine_cosine(camera->azimuth_deg, &sa, &ca);
    exact_sine_cosine(camera->elevation_deg, &se, &ce);
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
