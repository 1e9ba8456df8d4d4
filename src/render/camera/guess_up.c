/* guess_up.c: which axis of a mesh points up. A ground is lower than it is wide, and nearly all of
 * it faces along the vertical; a thing that stands has a flat foot at its lowest, or feet that are
 * far apart. */
#include "render/camera/camera.h"
#include "render/render.h"
#include <math.h>
#include <string.h>

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
