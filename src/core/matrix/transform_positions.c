/* transform_positions.c: streams of positions through a matrix.
 *
 * Blocks of vectors are taken apart into x, y and z, worked on in double precision, and put
 * together again: loops of one fixed length that compilers turn into vector instructions, with the
 * same operations in the same order for every vector, hence the same bits. In double precision the
 * product of two floats is exact. */
#include "core/matrix/stream.h"

enum { BLOCK = 16 };

typedef struct block {
    double x[BLOCK], y[BLOCK], z[BLOCK];
} block;

static void load_floats(const unsigned char *from, size_t stride, size_t count, block *b) {
    for (size_t i = 0; i < count; i++, from += stride) {
        float v[3];
        memcpy(v, from, sizeof v);
        b->x[i] = (double)v[0];
        b->y[i] = (double)v[1];
        b->z[i] = (double)v[2];
    }
}

static void load_tight_floats(const unsigned char *from, block *b) {
    float v[3 * BLOCK];
    memcpy(v, from, sizeof v);
    for (size_t i = 0; i < BLOCK; i++) {
        b->x[i] = (double)v[3 * i];
        b->y[i] = (double)v[3 * i + 1];
        b->z[i] = (double)v[3 * i + 2];
    }
}

/* count is BLOCK but at the end of the stream; the lanes beyond it keep harmless old numbers. */
static inline void load(const norma_vec3_view *in, size_t first, size_t count, block *b) {
    const size_t stride = norma_view_stride(in);
    const unsigned char *from = (const unsigned char *)in->data + first * stride;
    if (in->format == NORMA_FORMAT_FLOAT) {
        if (stride == 12 && count == BLOCK)
            load_tight_floats(from, b);
        else
            load_floats(from, stride, count, b);
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

static inline void store(const block *b, size_t count, unsigned char *to, size_t stride) {
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

static void store_doubles(const block *b, size_t count, unsigned char *to, size_t stride) {
    for (size_t i = 0; i < count; i++, to += stride)
        memcpy(to, (const double[]){b->x[i], b->y[i], b->z[i]}, 3 * sizeof(double));
}

static void positions_of_block(const double a[16], block *b) {
    for (int i = 0; i < BLOCK; i++) {
        const double x = b->x[i], y = b->y[i], z = b->z[i];
        b->x[i] = a[0] * x + a[4] * y + a[8] * z + a[12];
        b->y[i] = a[1] * x + a[5] * y + a[9] * z + a[13];
        b->z[i] = a[2] * x + a[6] * y + a[10] * z + a[14];
    }
}

/* size: of one number of the output. */
static norma_result transform(const double model[16], const norma_vec3_view *in, unsigned char *out,
    size_t stride, size_t size, size_t capacity) {
    if (!model) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_input_check(in);
    if (!result) result = norma_output_check(out, &stride, 3 * size, in->count, capacity);
    if (result) return result;
    double a[16];
    memcpy(a, model, sizeof a);
    block b = {{0}, {0}, {0}};
    for (size_t first = 0; first < in->count; first += BLOCK) {
        const size_t count = in->count - first < BLOCK ? in->count - first : BLOCK;
        load(in, first, count, &b);
        positions_of_block(a, &b);
        if (size == sizeof(float))
            store(&b, count, out + first * stride, stride);
        else
            store_doubles(&b, count, out + first * stride, stride);
    }
    return NORMA_OK;
}

norma_result norma_transform_positions(
    const double model[16], norma_vec3_view in, float *out, size_t out_stride, size_t capacity) {
    return transform(model, &in, (unsigned char *)out, out_stride, sizeof *out, capacity);
}

norma_result norma_transform_positions_double(
    const double model[16], norma_vec3_view in, double *out, size_t out_stride, size_t capacity) {
    return transform(model, &in, (unsigned char *)out, out_stride, sizeof *out, capacity);
}
