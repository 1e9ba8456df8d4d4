/* camera.c: how a scene is framed: the ball round it, the way from local space to pixels, and which
 * axis of a mesh points up. */
#include "render/parts.h"
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

/* ---- Which axis of a mesh points up. A ground is lower than it is wide, and nearly all of it
 * faces along the vertical; a thing that stands has a flat foot at its lowest, or feet that are far
 * apart. */

typedef struct evidence { /* for y (1) and z (2) */
    double low[3], high[3], along[3], foot[3], area;
    double feet_low[3][3], feet_high[3][3]; /* the box of what is lowest along each axis */
} evidence;

static int read_triangle(const norma_mesh *mesh, size_t first, size_t i, double p[3][3]) {
    const size_t corners[3] = {first, first + i, first + i + 1};
    for (int k = 0; k < 3; ++k) {
        norma_view_vector(&mesh->positions, norma_mesh_corner(mesh, corners[k]), p[k]);
        if (!isfinite(p[k][0]) || !isfinite(p[k][1]) || !isfinite(p[k][2])) return 0;
    }
    return 1;
}

static double area_vector(double p[3][3], double v[3]) {
    double squares = 0;
    for (int k = 0; k < 3; ++k) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        v[k] = 0.5 * ((p[1][a] - p[0][a]) * (p[2][b] - p[0][b]) -
                         (p[1][b] - p[0][b]) * (p[2][a] - p[0][a]));
        squares += v[k] * v[k];
    }
    return sqrt(squares);
}

static void find_bounds(evidence *e, double p[3][3]) {
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) {
            e->low[k] = fmin(e->low[k], p[i][k]);
            e->high[k] = fmax(e->high[k], p[i][k]);
        }
}

/* A foot's faces may be wound either way, but have nothing below them. */
static void weigh_face(evidence *e, double p[3][3]) {
    double v[3];
    const double area = area_vector(p, v);
    e->area += area;
    for (int k = 0; k < 3; ++k) {
        const double lowest = e->low[k] + 0.02 * (e->high[k] - e->low[k]);
        e->along[k] += fabs(v[k]);
        if (fabs(v[k]) > 0.95 * area && p[0][k] <= lowest && p[1][k] <= lowest && p[2][k] <= lowest)
            e->foot[k] += fabs(v[k]);
        for (int i = 0; i < 3; ++i)
            for (int axis = 0; axis < 3 && p[i][k] <= lowest; ++axis) {
                e->feet_low[k][axis] = fmin(e->feet_low[k][axis], p[i][axis]);
                e->feet_high[k][axis] = fmax(e->feet_high[k][axis], p[i][axis]);
            }
    }
}

typedef void each_triangle(evidence *e, double p[3][3]);

static void visit(const render_surface *surfaces, size_t count, each_triangle *call, evidence *e) {
    for (size_t s = 0; s < count; ++s) {
        const norma_mesh *mesh = &surfaces[s].mesh;
        const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
        for (size_t face = 0; face < faces; ++face) {
            const size_t first = mesh->face_starts ? mesh->face_starts[face] : 3 * face,
                         end = mesh->face_starts ? mesh->face_starts[face + 1] : first + 3;
            for (size_t i = 1; first + i + 1 < end; ++i) {
                double p[3][3];
                if (read_triangle(mesh, first, i, p)) call(e, p);
            }
        }
    }
}

static int is_ground(const evidence *e, int up) {
    const double height = e->high[up] - e->low[up];
    for (int k = 0; k < 3; ++k)
        if (k != up && 2 * height > e->high[k] - e->low[k]) return 0;
    return e->along[up] > 0.8 * e->area;
}

static double floor_of(const double low[3], const double high[3], int up) {
    const int a = (up + 1) % 3, b = (up + 2) % 3;
    return (high[a] - low[a]) * (high[b] - low[b]);
}

/* The part of the floor that the foot covers. */
static double foot_of(const evidence *e, int up) {
    const double floor = floor_of(e->low, e->high, up);
    return floor > 0 ? fmin(e->foot[up] / floor, 1) : 0;
}

/* The part of the floor that its feet stand round. */
static double stance_of(const evidence *e, int up) {
    const double floor = floor_of(e->low, e->high, up);
    return floor > 0 ? floor_of(e->feet_low[up], e->feet_high[up], up) / floor : 0;
}

static enum render_up higher(double y, double z, double clearly, enum render_up otherwise) {
    return y > z + clearly ? RENDER_UP_Y : z > y + clearly ? RENDER_UP_Z : otherwise;
}

enum render_up render_guess_up(const render_surface *surfaces, size_t count, enum render_up usual) {
    evidence e = {.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
    visit(surfaces, count, find_bounds, &e);
    for (int k = 0; k < 3; ++k) {
        memcpy(e.feet_low[k], e.high, sizeof e.high);
        memcpy(e.feet_high[k], e.low, sizeof e.low);
    }
    visit(surfaces, count, weigh_face, &e);
    if (is_ground(&e, 1) != is_ground(&e, 2)) return is_ground(&e, 1) ? RENDER_UP_Y : RENDER_UP_Z;
    return higher(foot_of(&e, 1), foot_of(&e, 2), 0.15,
        higher(stance_of(&e, 1), stance_of(&e, 2), 0.2, usual));
}
