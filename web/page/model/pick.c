/* pick.c: the point of a mesh under the cursor. */
#include "model.h"
#include "../../package/wasm/exports.h"
#include <math.h>

typedef struct ray {
    double from[3], along[3];
} ray;

static void minus(const float *a, const float *b, double out[3]) {
    for (int i = 0; i < 3; ++i) out[i] = (double)a[i] - (double)b[i];
}

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Möller, Trumbore 1997. Where the ray meets the triangle, as a part of its length, from either
 * side; hit: barycentric coordinates of the second and third corner. */
static double meet(const ray *r, const float *p, double hit[2]) {
    double e1[3], e2[3], h[3], s[3], q[3];
    minus(p + 3, p, e1);
    minus(p + 6, p, e2);
    cross(r->along, e2, h);
    const double determinant = dot(e1, h);
    if (determinant == 0) return INFINITY;
    for (int i = 0; i < 3; ++i) s[i] = r->from[i] - (double)p[i];
    hit[0] = dot(s, h) / determinant;
    if (!(hit[0] >= 0 && hit[0] <= 1)) return INFINITY;
    cross(s, e1, q);
    hit[1] = dot(r->along, q) / determinant;
    if (!(hit[1] >= 0 && hit[0] + hit[1] <= 1)) return INFINITY;
    const double at = dot(e2, q) / determinant;
    return at > 0 ? at : INFINITY;
}

/* ray: from and along, six numbers, in the space of draw_positions. found: where along the ray, the
 * triangle, and the three barycentric coordinates. Returns whether there is one. */
int WEB_EXPORT(model_pick)(
    const model *m, uint32_t index, const double numbers[6], double found[5]) {
    const model_mesh *mesh = &m->meshes[index];
    const ray r = {{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
    found[0] = INFINITY;
    for (size_t t = 0; t < mesh->triangle_count; ++t) {
        double hit[2];
        const double at = meet(&r, mesh->draw_positions + 9 * t, hit);
        if (at < found[0]) {
            found[0] = at;
            found[1] = (double)t;
            found[2] = 1 - hit[0] - hit[1];
            found[3] = hit[0];
            found[4] = hit[1];
        }
    }
    return found[0] < INFINITY;
}
