/* transform_tangents.c: tangents with their sign through a matrix, and made perpendicular to
 * normals.
 *
 * A tangent is a vector: it goes through M itself, never through the normal matrix, and is then
 * made perpendicular to the new normal (Gram-Schmidt). The sign, which gives the bitangent as sign
 * * cross(normal, tangent), turns where M mirrors. */
#include "core/matrix/matrix.h"
#include "core/matrix/stream.h"

/* Below this part of a tangent's length, what is perpendicular to the normal is rounding noise
 * rather than a direction. */
#define NOTHING_LEFT 0x1p-20

/* Any unit vector perpendicular to the unit vector n: the axis that n leans on least, made
 * perpendicular. */
static void any_perpendicular(const double n[3], double out[3]) {
    int axis = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(n[i]) < fabs(n[axis])) axis = i;
    for (int i = 0; i < 3; i++) out[i] = (i == axis ? 1.0 : 0.0) - n[axis] * n[i];
    (void)norma_vec3_unit(out);
}

void norma_core_perpendicular_tangent(
    const double normal[3], const double tangent[3], double out[3]) {
    double n[3] = {normal[0], normal[1], normal[2]}, t[3] = {tangent[0], tangent[1], tangent[2]};
    const int has_normal = norma_vec3_unit(n), has_tangent = norma_vec3_unit(t);
    if (!has_normal) {
        for (int i = 0; i < 3; i++) out[i] = has_tangent ? t[i] : (i == 0 ? 1.0 : 0.0);
        return;
    }
    if (has_tangent) {
        const double along = norma_core_dot(n, t);
        for (int i = 0; i < 3; i++) out[i] = t[i] - along * n[i];
        if (norma_core_dot(out, out) > NOTHING_LEFT * NOTHING_LEFT) {
            (void)norma_vec3_unit(out);
            return;
        }
    }
    any_perpendicular(n, out);
}

typedef struct tangent_stream {
    const float *tangents;
    size_t stride;
    const norma_vec3_view *normals;
    size_t count;
    float *out;
    size_t out_stride;
} tangent_stream;

static norma_result check(tangent_stream *s, size_t capacity) {
    norma_result result = norma_input_check(s->normals);
    if (result || !s->count) return result;
    if (!s->tangents || s->normals->count < s->count) return NORMA_ERROR_ARGUMENT;
    if (!s->stride) s->stride = 4 * sizeof(float);
    if (s->count > SIZE_MAX / s->stride) return NORMA_ERROR_OVERFLOW;
    return norma_output_check(s->out, &s->out_stride, 4 * sizeof(float), s->count, capacity);
}

/* linear: nine numbers, column after column, or NULL for tangents that stay where they are. */
static void run(const tangent_stream *s, const double *linear, float sign) {
    for (size_t i = 0; i < s->count; i++) {
        float in[4], out[4];
        memcpy(in, (const unsigned char *)s->tangents + i * s->stride, sizeof in);
        double t[3] = {(double)in[0], (double)in[1], (double)in[2]}, moved[3], normal[3], unit[3];
        for (int r = 0; r < 3; r++)
            moved[r] =
                linear ? linear[r] * t[0] + linear[3 + r] * t[1] + linear[6 + r] * t[2] : t[r];
        norma_view_read(s->normals, i, normal);
        norma_core_perpendicular_tangent(normal, moved, unit);
        for (int r = 0; r < 3; r++) out[r] = (float)unit[r];
        out[3] = in[3] * sign;
        memcpy((unsigned char *)s->out + i * s->out_stride, out, sizeof out);
    }
}

norma_result norma_transform_tangents(const float model[16], const float *tangents,
    size_t tangent_stride, norma_vec3_view normals, size_t count, float *out, size_t out_stride,
    size_t capacity) {
    tangent_stream s = {tangents, tangent_stride, &normals, count, out, out_stride};
    double linear[9];
    if (!model || !norma_matrix_upper_float(model, linear)) return NORMA_ERROR_ARGUMENT;
    const norma_result result = check(&s, capacity);
    if (result) return result;
    run(&s, linear, norma_exact_determinant(linear).mantissa < 0.0 ? -1.0f : 1.0f);
    return NORMA_OK;
}

norma_result norma_orthogonalise_tangents(const float *tangents, size_t tangent_stride,
    norma_vec3_view normals, size_t count, float *out, size_t out_stride, size_t capacity) {
    tangent_stream s = {tangents, tangent_stride, &normals, count, out, out_stride};
    const norma_result result = check(&s, capacity);
    if (!result) run(&s, NULL, 1.0f);
    return result;
}
