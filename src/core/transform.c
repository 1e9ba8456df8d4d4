/* transform.c: streams of normals and of positions through a matrix.
 *
 * Blocks of vectors are taken apart into x, y and z, worked on in double precision, and put together again: loops of one fixed length
 * that compilers turn into vector instructions, with the same operations in the same order for every vector, hence the same bits.
 * In double precision the product of two floats is exact and no square of a length over- or underflows. */
#include "stream.h"

enum { BLOCK = 16 };

typedef struct block {
    double x[BLOCK], y[BLOCK], z[BLOCK];
} block;

static void load_floats(const unsigned char *from, size_t stride, size_t count, block *b)
{
    for (size_t i = 0; i < count; i++, from += stride) {
        float v[3];
        memcpy(v, from, sizeof v);
        b->x[i] = (double)v[0];
        b->y[i] = (double)v[1];
        b->z[i] = (double)v[2];
    }
}

static void load_tight_floats(const unsigned char *from, block *b)
{
    float v[3 * BLOCK];
    memcpy(v, from, sizeof v);
    for (size_t i = 0; i < BLOCK; i++) {
        b->x[i] = (double)v[3 * i];
        b->y[i] = (double)v[3 * i + 1];
        b->z[i] = (double)v[3 * i + 2];
    }
}

/* count is BLOCK but at the end of the stream; the lanes beyond it keep harmless old numbers. */
static inline void load(const norma_vec3_view *in, size_t first, size_t count, block *b)
{
    const size_t stride = norma_view_stride(in);
    const unsigned char *from = (const unsigned char *)in->data + first * stride;
    if (in->format == NORMA_FORMAT_FLOAT) {
        if (stride == 12 && count == BLOCK) load_tight_floats(from, b);
        else load_floats(from, stride, count, b);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        double v[3];
        norma_view_read(in, first + i, v);
        b->x[i] = v[0];
        b->y[i] = v[1];
        b->z[i] = v[2];
    }
}

static inline void store(const block *b, size_t count, unsigned char *to, size_t stride)
{
    if (stride == 12 && count == BLOCK) {
        float v[3 * BLOCK];
        for (size_t i = 0; i < BLOCK; i++) {
            v[3 * i] = (float)b->x[i];
            v[3 * i + 1] = (float)b->y[i];
            v[3 * i + 2] = (float)b->z[i];
        }
        memcpy(to, v, sizeof v);
        return;
    }
    for (size_t i = 0; i < count; i++, to += stride) {
        const float v[3] = {(float)b->x[i], (float)b->y[i], (float)b->z[i]};
        memcpy(to, v, sizeof v);
    }
}

/* b through the matrix (columns m, m + 3, m + 6), and made unit; lanes whose squared length is not safely within a double become zero.
 * Returns whether any does. Loops of one step each, without a branch, are what compilers make vector code of. */
static int normals_of_block(const double m[9], block *b)
{
    double square[BLOCK], unsafe[BLOCK], any = 0.0;
    for (int i = 0; i < BLOCK; i++) {
        const double x = b->x[i], y = b->y[i], z = b->z[i];
        b->x[i] = m[0] * x + m[3] * y + m[6] * z;
        b->y[i] = m[1] * x + m[4] * y + m[7] * z;
        b->z[i] = m[2] * x + m[5] * y + m[8] * z;
        square[i] = b->x[i] * b->x[i] + b->y[i] * b->y[i] + b->z[i] * b->z[i];
        unsafe[i] = square[i] >= 0x1p-900 && square[i] <= 0x1p900 ? 0.0 : 1.0;
    }
    for (int i = 0; i < BLOCK; i++) any += unsafe[i];
    if (any != 0.0)
        for (int i = 0; i < BLOCK; i++)
            if (unsafe[i] != 0.0) b->x[i] = b->y[i] = b->z[i] = 0.0, square[i] = 1.0;
    for (int i = 0; i < BLOCK; i++) {
        const double factor = 1.0 / sqrt(square[i]);
        b->x[i] *= factor;
        b->y[i] *= factor;
        b->z[i] *= factor;
    }
    return any != 0.0;
}

/* A normal near the ends of the doubles' range: scaled first. Zero and what is not finite give zero. */
static void normal_of_any_size(const double m[9], const double in[3], double out[3])
{
    double n[3] = {in[0], in[1], in[2]};
    out[0] = out[1] = out[2] = 0.0;
    if (!norma_vec3_scale(n)) return;
    double v[3];
    for (int r = 0; r < 3; r++) v[r] = m[r] * n[0] + m[3 + r] * n[1] + m[6 + r] * n[2];
    if (!norma_vec3_unit(v)) return;
    memcpy(out, v, sizeof v);
}

/* The lanes that normals_of_block gave up, from the input again, which nothing has overwritten yet. */
static void mend_block(const double m[9], const block *before, block *after, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (after->x[i] != 0.0 || after->y[i] != 0.0 || after->z[i] != 0.0) continue;
        const double in[3] = {before->x[i], before->y[i], before->z[i]};
        double out[3];
        normal_of_any_size(m, in, out);
        after->x[i] = out[0];
        after->y[i] = out[1];
        after->z[i] = out[2];
    }
}

norma_result norma_transform_normals(const float normal_matrix[9], norma_vec3_view in, float *out, size_t out_stride, size_t capacity)
{
    if (!normal_matrix) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_input_check(&in);
    if (!result) result = norma_output_check(out, &out_stride, 3 * sizeof *out, in.count, capacity);
    if (result) return result;
    double m[9];
    for (int i = 0; i < 9; i++) m[i] = (double)normal_matrix[i];

    block before = {{0}, {0}, {0}};
    for (size_t first = 0; first < in.count; first += BLOCK) {
        const size_t count = in.count - first < BLOCK ? in.count - first : BLOCK;
        load(&in, first, count, &before);
        block after = before;
        if (normals_of_block(m, &after)) mend_block(m, &before, &after, count);
        store(&after, count, (unsigned char *)out + first * out_stride, out_stride);
    }
    return NORMA_OK;
}

/* ---- positions */

static void positions_of_block(const double a[16], block *b)
{
    for (int i = 0; i < BLOCK; i++) {
        const double x = b->x[i], y = b->y[i], z = b->z[i];
        b->x[i] = a[0] * x + a[4] * y + a[8] * z + a[12];
        b->y[i] = a[1] * x + a[5] * y + a[9] * z + a[13];
        b->z[i] = a[2] * x + a[6] * y + a[10] * z + a[14];
    }
}

norma_result norma_transform_positions(const double model[16], norma_vec3_view in, float *out, size_t out_stride, size_t capacity)
{
    if (!model) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_input_check(&in);
    if (!result) result = norma_output_check(out, &out_stride, 3 * sizeof *out, in.count, capacity);
    if (result) return result;
    double a[16];
    memcpy(a, model, sizeof a);
    block b = {{0}, {0}, {0}};
    for (size_t first = 0; first < in.count; first += BLOCK) {
        const size_t count = in.count - first < BLOCK ? in.count - first : BLOCK;
        load(&in, first, count, &b);
        positions_of_block(a, &b);
        store(&b, count, (unsigned char *)out + first * out_stride, out_stride);
    }
    return NORMA_OK;
}

norma_result norma_transform_positions_double(const double model[16], norma_vec3_view in, double *out, size_t out_stride, size_t capacity)
{
    if (!model) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_input_check(&in);
    if (!result) result = norma_output_check(out, &out_stride, 3 * sizeof *out, in.count, capacity);
    if (result) return result;
    double a[16];
    memcpy(a, model, sizeof a);
    block b = {{0}, {0}, {0}};
    for (size_t first = 0; first < in.count; first += BLOCK) {
        const size_t count = in.count - first < BLOCK ? in.count - first : BLOCK;
        load(&in, first, count, &b);
        positions_of_block(a, &b);
        unsigned char *to = (unsigned char *)out + first * out_stride;
        for (size_t i = 0; i < count; i++, to += out_stride) memcpy(to, (const double[]){b.x[i], b.y[i], b.z[i]}, 3 * sizeof *out);
    }
    return NORMA_OK;
}
