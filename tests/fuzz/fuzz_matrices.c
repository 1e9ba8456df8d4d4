/* fuzz_matrices.c: normal matrices of any model, one and many, in any layout; normals, positions
 * and tangents through them; codes. Nothing is written beside what is meant, one gives the bits of
 * many, no NaN where there is to be none. */
#include "made_mesh.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void take_model(fuzz_bytes *bytes, float model[16]) {
    uint8_t kind = fuzz_u8(bytes);
    for (int i = 0; i < 16; ++i) model[i] = kind < 64 && i % 5 != 0 ? 0.f : fuzz_float(bytes);
}

static int finite_3x3(const float *model) {
    int finite = 1;
    for (int i = 0; i < 11; ++i) finite &= i % 4 == 3 || isfinite(model[i]);
    return finite;
}

static void one_matrix(fuzz_bytes *bytes) {
    float model[16], view[16], out[9], many[9];
    double wide[16], wide_out[9];
    norma_matrix_info info;
    norma_winding winding = (norma_winding)(fuzz_u8(bytes) & 1);
    take_model(bytes, model);
    take_model(bytes, view);
    norma_result result = norma_normal_matrix(model, winding, out, &info);
    if ((!result) != finite_3x3(model))
        fuzz_fail(
            "result %d of a model that is %sfinite", (int)result, finite_3x3(model) ? "" : "not ");
    for (int i = 0; i < 9; ++i)
        if (!isfinite(out[i]) || (out[i] == 0 && signbit(out[i])))
            fuzz_fail("entry %d is %g", i, (double)out[i]);
    if (norma_normal_matrices(model, 1, winding, many, 1) != result ||
        memcmp(many, out, sizeof out) != 0)
        fuzz_fail("one of many differs from one");
    if (info.rank < 0 || info.rank > 3 || isnan(info.determinant) || isnan(info.anisotropy) ||
        !(info.worst_error_rad >= 0 && info.worst_error_rad < 1.5708) || info.anisotropy < 1)
        fuzz_fail("info: rank %d, determinant %g, anisotropy %g, worst %g", info.rank,
            info.determinant, info.anisotropy, info.worst_error_rad);
    (void)norma_matrix_shortcut(&info);
    result = norma_normal_matrix_model_view(model, view, winding, out, &info);
    if ((!result) != (finite_3x3(model) && finite_3x3(view)))
        fuzz_fail("model and view: result %d", (int)result);
    for (int i = 0; i < 16; ++i) wide[i] = fuzz_double(bytes);
    (void)norma_normal_matrix_double(wide, winding, wide_out, &info);
    (void)norma_cofactor_matrix(wide, wide_out);
    (void)norma_inverse_transpose(wide, wide_out);
    (void)norma_axis_scale_matrix(wide, wide_out);
    norma_normal_matrix(model, winding, model, NULL);
}

static void check_between(
    const uint8_t *at, size_t count, size_t stride, size_t size, size_t room) {
    for (size_t i = 0; i < room; ++i)
        if ((i >= (count ? (count - 1) * stride + size : 0) || i % stride >= size) && at[i] != 0xA5)
            fuzz_fail("byte %zu, which belongs to no result, was written", i);
}

static void many_matrices(fuzz_bytes *bytes) {
    size_t count = fuzz_u8(bytes) % 40, model_stride = fuzz_u8(bytes),
           matrix_stride = fuzz_u8(bytes), column_stride = fuzz_u8(bytes);
    model_stride = model_stride < 64 ? 0 : model_stride;
    size_t step = model_stride ? model_stride : 64, columns = column_stride ? column_stride : 12,
           matrices = matrix_stride ? matrix_stride : 3 * columns;
    size_t room = count ? (count - 1) * matrices + 2 * columns + 12 : 0;
    uint8_t *models = malloc(count * step + 1), *out = malloc(room + 1);
    memset(out, 0xA5, room + 1);
    for (size_t i = 0; i < count; ++i) {
        float model[16];
        take_model(bytes, model);
        memset(models + i * step, 0, step);
        memcpy(models + i * step, model, sizeof model);
    }
    norma_result result =
        norma_normal_matrices_strided((const float *)(const void *)models, model_stride, count,
            NORMA_WINDING_REVERSED, (float *)(void *)out, matrix_stride, column_stride, count);
    if (result && result != NORMA_ERROR_ARGUMENT && result != NORMA_ERROR_OVERFLOW)
        fuzz_fail("strided: result %d", (int)result);
    free(models);
    free(out);
}

static void vectors(fuzz_bytes *bytes) {
    size_t count = fuzz_u8(bytes) % 64, extra = fuzz_u8(bytes) % 8, stride = 12 + extra,
           wide = 24 + extra;
    float matrix[9], model[16];
    double model_double[16];
    void *block;
    take_model(bytes, model);
    for (int i = 0; i < 9; ++i) matrix[i] = fuzz_float(bytes);
    for (int i = 0; i < 16; ++i) model_double[i] = fuzz_double(bytes);
    norma_vec3_view in = made_view(bytes, count, &block);
    size_t room = count * wide;
    uint8_t *out = malloc(room + 1);
    memset(out, 0xA5, room);
    if (norma_transform_normals(matrix, in, (float *)(void *)out, stride, count))
        fuzz_fail("normals are refused");
    check_between(out, count, stride, 12, room);
    for (size_t i = 0; i < count; ++i) {
        float n[3];
        memcpy(n, out + i * stride, 12);
        double length = sqrt((double)n[0] * n[0] + (double)n[1] * n[1] + (double)n[2] * n[2]);
        if (!(length == 0 || fabs(length - 1) < 1e-6)) fuzz_fail("a normal of length %g", length);
    }
    memset(out, 0xA5, room);
    if (norma_transform_positions(model_double, in, (float *)(void *)out, stride, count))
        fuzz_fail("positions are refused");
    check_between(out, count, stride, 12, room);
    memset(out, 0xA5, room);
    if (norma_transform_positions_double(model_double, in, (double *)(void *)out, wide, count))
        fuzz_fail("positions are refused");
    check_between(out, count, wide, 24, room);
    if (count && norma_transform_normals(matrix, in, (float *)(void *)out, stride, count - 1) !=
                     NORMA_ERROR_CAPACITY)
        fuzz_fail("too little room is not told");
    free(out);
    free(block);
}

static void tangents(fuzz_bytes *bytes) {
    size_t count = fuzz_u8(bytes) % 64, extra = fuzz_u8(bytes) % 8, stride = 16 + extra;
    float model[16];
    void *block;
    take_model(bytes, model);
    norma_vec3_view normals = made_view(bytes, count, &block);
    uint8_t *in = calloc(count * stride + 1, 1), *out = malloc(count * stride + 1);
    for (size_t i = 0; i < 4 * count; ++i) {
        float number = fuzz_float(bytes);
        memcpy(in + i / 4 * stride + i % 4 * 4, &number, 4);
    }
    for (int twice = 0; twice < 2; ++twice) {
        memset(out, 0xA5, count * stride);
        norma_result result =
            twice ? norma_orthogonalise_tangents((const float *)(const void *)in, stride, normals,
                        count, (float *)(void *)out, stride, count)
                  : norma_transform_tangents(model, (const float *)(const void *)in, stride,
                        normals, count, (float *)(void *)out, stride, count);
        if (result && (twice || finite_3x3(model))) fuzz_fail("tangents: result %d", (int)result);
        if (!result) check_between(out, count, stride, 16, count * stride);
        for (size_t i = 0; !result && i < count; ++i) {
            float t[4];
            memcpy(t, out + i * stride, 16);
            double length = sqrt((double)t[0] * t[0] + (double)t[1] * t[1] + (double)t[2] * t[2]);
            if (!(fabs(length - 1) < 1e-6)) fuzz_fail("tangent %zu has length %g", i, length);
        }
    }
    free(in);
    free(out);
    free(block);
}

static void codes(fuzz_bytes *bytes) {
    size_t count = fuzz_u8(bytes) % 64;
    void *block;
    norma_vec3_view in = made_view(bytes, count, &block);
    int8_t *small = malloc(4 * count + 1);
    int16_t *large = malloc(8 * count + 2);
    float *back = malloc(12 * count + 4);
    if (norma_encode_snorm8(in, small, 4, count) || norma_encode_snorm16(in, large, 8, count) ||
        norma_decode_snorm8(small, 4, count, back, 0, count))
        fuzz_fail("codes are refused");
    for (size_t i = 0; i < count; ++i) {
        double length =
            sqrt((double)back[3 * i] * back[3 * i] + (double)back[3 * i + 1] * back[3 * i + 1] +
                 (double)back[3 * i + 2] * back[3 * i + 2]);
        if (!(length == 0 || fabs(length - 1) <= 0.00674)) fuzz_fail("a code of length %g", length);
    }
    if (norma_decode_snorm16(large, 8, count, back, 12, count)) fuzz_fail("codes are refused");
    for (int e = NORMA_ENCODING_OCT8; e <= NORMA_ENCODING_10_10_10_2; ++e) {
        /* What is decoded is encoded as itself: the lowest code of this direction. */
        uint32_t *codes = malloc(4 * count + 4), *again = malloc(4 * count + 4);
        const norma_vec3_view decoded = {back, count, 0, NORMA_FORMAT_FLOAT};
        if (norma_encode_normals(in, (norma_encoding)e, codes, 0, count, NULL) ||
            norma_decode_normals(codes, 0, count, (norma_encoding)e, back, 0) ||
            norma_encode_normals(decoded, (norma_encoding)e, again, 0, count, NULL))
            fuzz_fail("codes are refused");
        if (e != NORMA_ENCODING_10_10_10_2 && memcmp(codes, again, 4 * count) != 0)
            fuzz_fail("encoding %d: a decoded code has another code", e);
        free(codes);
        free(again);
    }
    free(small);
    free(large);
    free(back);
    free(block);
}

static void other_calls(fuzz_bytes *bytes) {
    float a[12], normal[3];
    for (int i = 0; i < 12; ++i) a[i] = fuzz_float(bytes);
    if (norma_interpolate_normal(a, a + 3, a + 6, a + 9, normal))
        fuzz_fail("an interpolation is refused");
    double length = sqrt((double)normal[0] * normal[0] + (double)normal[1] * normal[1] +
                         (double)normal[2] * normal[2]);
    if (!(length == 0 || fabs(length - 1) < 1e-6))
        fuzz_fail("interpolated to a length of %g", length);
    made_mesh *made = made_mesh_take(bytes);
    const norma_mesh *mesh = &made->mesh;
    if (mesh->corners && mesh->corner_count < 4096) {
        size_t size = mesh->corner_size ? mesh->corner_size : 4;
        uint8_t *copy = malloc(mesh->corner_count * size + 1);
        memcpy(copy, mesh->corners, mesh->corner_count * size);
        /* Twice is as before. */
        norma_result result = norma_reverse_winding(
            copy, mesh->corner_size, mesh->corner_count, mesh->face_starts, mesh->face_count);
        if (!result)
            norma_reverse_winding(
                copy, mesh->corner_size, mesh->corner_count, mesh->face_starts, mesh->face_count);
        if (memcmp(copy, mesh->corners, mesh->corner_count * size) != 0)
            fuzz_fail("reversed twice, or refused, and yet changed");
        free(copy);
    }
    made_mesh_free(made);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static void (*const calls[])(fuzz_bytes *) = {
        one_matrix, many_matrices, vectors, tangents, codes, other_calls};
    fuzz_bytes rest = {bytes, size};
    fuzz_meter_begin(16384);
    calls[fuzz_u8(&rest) % 6](&rest);
    fuzz_meter_end();
    return 0;
}
