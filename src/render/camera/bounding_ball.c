/* bounding_ball.c: the smallest ball round points, found by taking in the farthest point until none
 * is outside (Gaertner 1999), and the closest frame of a camera. */
#include "render/camera/bounding_ball.h"
#include <math.h>
#include <string.h>

enum { MOST_SUPPORT = 4 };

typedef struct support {
    double points[MOST_SUPPORT + 1][3];
    int count;
} support;

static double squared_distance(const double a[3], const double b[3]) {
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
        scale = fmax(scale, squared_distance(s->points[i], origin));
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
    ball->radius = sqrt(squared_distance(ball->centre, origin));
    return 1;
}

static int holds_all(const render_ball *ball, const support *s) {
    for (int i = 0; i < s->count; ++i)
        if (sqrt(squared_distance(ball->centre, s->points[i])) > ball->radius * (1 + 1e-9))
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

static double farthest(
    const render_cloud *clouds, size_t count, const double centre[3], double point[3]) {
    double most = -1;
    for (size_t c = 0; c < count; ++c)
        for (size_t i = 0; i < clouds[c].count; ++i) {
            const float *at = clouds[c].points + 3 * i;
            const double local[3] = {(double)at[0], (double)at[1], (double)at[2]};
            double world[3], squared;
            render_point(clouds[c].matrix, local, world);
            squared = squared_distance(world, centre);
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
        far = farthest(clouds, count, ball.centre, point);
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
