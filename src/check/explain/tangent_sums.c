/* tangent_sums.c: tangents as sums over the triangles at each vertex (E. Lengyel, Computing Tangent
 * Space Basis Vectors for an Arbitrary Mesh, 2001): dP/du of each triangle, added as it is, made
 * perpendicular to the normal; the sign by the sum of dP/dv. Many exporters and engines do so. */
#include "check/explain/explain_tangents.h"
#include "core/face/triangle.h"
#include <math.h>
#include <string.h>

typedef struct vertex_sum {
    double along_u[3], along_v[3];
} vertex_sum;

static void add_triangle(const tangent_surface *s, size_t first, vertex_sum *sums) {
    uint32_t v[3];
    double p[3][3], along_u[3], along_v[3];
    for (size_t i = 0; i < 3; i++) {
        v[i] = norma_core_corner(&s->checked, first + i);
        norma_core_position(&s->checked, v[i], p[i]);
    }
    const float *a = s->texcoords + 2 * (size_t)v[0], *b = s->texcoords + 2 * (size_t)v[1],
                *c = s->texcoords + 2 * (size_t)v[2];
    const double s1 = (double)b[0] - (double)a[0], s2 = (double)c[0] - (double)a[0],
                 t1 = (double)b[1] - (double)a[1], t2 = (double)c[1] - (double)a[1],
                 area = s1 * t2 - s2 * t1;
    if (!(fabs(area) > 0)) return;
    for (int k = 0; k < 3; k++) {
        const double x1 = p[1][k] - p[0][k], x2 = p[2][k] - p[0][k];
        along_u[k] = (t2 * x1 - t1 * x2) / area;
        along_v[k] = (s1 * x2 - s2 * x1) / area;
        if (!isfinite(along_u[k]) || !isfinite(along_v[k])) return;
    }
    for (size_t i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            sums[v[i]].along_u[k] += along_u[k];
            sums[v[i]].along_v[k] += along_v[k];
        }
}

/* Rounding leaves something of a sum along the normal; that is no tangent. */
static void finish_vertex(const float *n, const vertex_sum *sum, float tangent[4]) {
    const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]},
                 along = norma_core_dot(normal, sum->along_u);
    double t[3], bitangent[3];
    for (int k = 0; k < 3; k++) t[k] = sum->along_u[k] - along * normal[k];
    const double length = sqrt(norma_core_dot(t, t));
    norma_core_cross(normal, t, bitangent);
    memset(tangent, 0, 4 * sizeof *tangent);
    if (!(length > 1e-6 * sqrt(norma_core_dot(sum->along_u, sum->along_u)))) return;
    for (int k = 0; k < 3; k++) tangent[k] = (float)(t[k] / length);
    tangent[3] = norma_core_dot(bitangent, sum->along_v) < 0 ? -1.0F : 1.0F;
}

norma_result norma_explain_tangent_sums(
    core_call *call, const tangent_surface *s, float *tangents) {
    const size_t count = s->checked.positions.count;
    vertex_sum *sums = norma_core_allocate(call, count, sizeof *sums);
    if (!sums) return NORMA_ERROR_MEMORY;
    memset(sums, 0, count * sizeof *sums);
    for (size_t f = 0; f < s->checked.face_count; f++)
        add_triangle(s, norma_core_face_begin(&s->checked, f), sums);
    for (size_t c = 0; c < s->checked.corner_count; c++) {
        const uint32_t v = norma_core_corner(&s->checked, c);
        finish_vertex(s->normals + 3 * (size_t)v, &sums[v], tangents + 4 * c);
    }
    norma_core_release(call, sums, count, sizeof *sums);
    return NORMA_OK;
}
