/* stream.c: calls that take no options: matrices; normals, positions and tangents through them;
 * packing; interpolation; winding. */
#include "bits.h"
#include <stdlib.h>
#include <string.h>

enum { MOST_VECTORS = 5000, MODELS = 64 };

static void add_info(bits_hash *hash, const norma_matrix_info *info) {
    bits_add(hash, (uint64_t)info->kind);
    bits_add(hash, (uint64_t)info->rank);
    bits_add(hash, (uint64_t)info->mirrored);
    bits_double(hash, info->determinant);
    bits_double(hash, info->anisotropy);
    bits_double(hash, info->worst_error_rad);
    bits_floats(hash, info->worst_normal, 3);
    bits_add(hash, (uint64_t)norma_matrix_shortcut(info));
}

/* Matrices of every kind: random, sheared, mirrored, of rank 2 to 0, large, small, nearly singular,
 * not finite. */
static void make_model(size_t index, uint64_t *seed, double model[16]) {
    static const double scales[] = {1, 1, 1e-30, 1e30, 1e-8, 3, .5, 1e5};
    memset(model, 0, 16 * sizeof *model);
    for (size_t i = 0; i < 16; ++i) {
        const double value = bits_random_unit(seed) * 2 - 1;
        if (i % 4 == 3)
            model[i] = i == 15;
        else
            model[i] = index % 5 == 1 && i < 12 ? (i % 5 == 0 ? 1 + (double)(index % 3) : 0)
                                                : value * scales[index % 8];
    }
    if (index % 7 == 2)
        for (int i = 0; i < 4; ++i) model[4 + i] = (index % 2 ? 2 : 1.0000001) * model[i];
    if (index % 14 == 4) memset(model, 0, 8 * sizeof *model);
    if (index % 11 == 3)
        for (int i = 0; i < 3; ++i) model[i] = -model[i];
    if (index == 40) model[5] = model[0] / (model[0] - model[0]);
}

static void add_result(bits_hash *hash, norma_result result) {
    bits_add(hash, (uint64_t)(int64_t)result);
}

static void one_model(
    const double model[16], const float single[16], const float view[16], bits_hash *hash) {
    norma_matrix_info info;
    float normal[9] = {0};
    double wide[9] = {0};
    for (int winding = NORMA_WINDING_KEPT; winding <= NORMA_WINDING_REVERSED; ++winding) {
        memset(&info, 0, sizeof info);
        add_result(hash, norma_normal_matrix(single, (norma_winding)winding, normal, &info));
        bits_floats(hash, normal, 9);
        add_info(hash, &info);
        memset(&info, 0, sizeof info);
        add_result(hash, norma_normal_matrix_double(model, (norma_winding)winding, wide, &info));
        bits_doubles(hash, wide, 9);
        add_info(hash, &info);
        memset(&info, 0, sizeof info);
        add_result(hash,
            norma_normal_matrix_model_view(single, view, (norma_winding)winding, normal, &info));
        bits_floats(hash, normal, 9);
        add_info(hash, &info);
    }
    add_result(hash, norma_cofactor_matrix(model, wide));
    bits_doubles(hash, wide, 9);
    memset(wide, 0, sizeof wide);
    add_result(hash, norma_inverse_transpose(model, wide));
    bits_doubles(hash, wide, 9);
    memset(wide, 0, sizeof wide);
    add_result(hash, norma_axis_scale_matrix(model, wide));
    bits_doubles(hash, wide, 9);
}

void bits_matrices(const bits_mesh *m, bits_hash *hash) {
    uint64_t seed = m->mesh.corner_count;
    double models[MODELS][16];
    float singles[MODELS][16], normals[9 * MODELS], spaced[12 * MODELS];
    for (size_t i = 0; i < MODELS; ++i) {
        make_model(i, &seed, models[i]);
        for (int k = 0; k < 16; ++k) singles[i][k] = (float)models[i][k];
    }
    for (size_t i = 0; i < MODELS; ++i)
        one_model(models[i], singles[i], singles[(i + 1) % MODELS], hash);
    for (int winding = NORMA_WINDING_KEPT; winding <= NORMA_WINDING_REVERSED; ++winding) {
        memset(normals, 0, sizeof normals);
        add_result(hash,
            norma_normal_matrices(singles[0], MODELS, (norma_winding)winding, normals, MODELS));
        bits_floats(hash, normals, 9 * MODELS);
        memset(spaced, 0, sizeof spaced);
        add_result(hash, norma_normal_matrices_strided(singles[0], 0, MODELS,
                             (norma_winding)winding, spaced, 48, 16, MODELS));
        bits_floats(hash, spaced, 12 * MODELS);
    }
}

/* ---- arrays of vectors */

static void packed(norma_vec3_view normals, bits_hash *hash) {
    const size_t count = normals.count;
    int8_t *bytes = bits_room(count, 4);
    int16_t *shorts = bits_room(count, 6);
    float *back = bits_room(3 * count, sizeof *back);
    add_result(hash, norma_encode_snorm8(normals, bytes, 4, count));
    bits_bytes(hash, bytes, 4 * count);
    add_result(hash, norma_decode_snorm8(bytes, 4, count, back, 0, count));
    bits_floats(hash, back, 3 * count);
    add_result(hash, norma_encode_snorm16(normals, shorts, 0, count));
    bits_bytes(hash, shorts, 6 * count);
    add_result(hash, norma_decode_snorm16(shorts, 0, count, back, 0, count));
    bits_floats(hash, back, 3 * count);
    free(bytes);
    free(shorts);
    free(back);
}

static void tangents(const float model[16], norma_vec3_view normals, bits_hash *hash) {
    const size_t count = normals.count;
    uint64_t seed = count;
    float *given = bits_room(4 * count, sizeof *given), *out = bits_room(4 * count, sizeof *out);
    for (size_t i = 0; i < 4 * count; ++i)
        given[i] = i % 4 == 3 ? (bits_random(&seed) % 2 ? 1.0f : -1.0f)
                              : (float)bits_random(&seed) / 0x1p63f - 1;
    add_result(hash, norma_transform_tangents(model, given, 0, normals, count, out, 0, count));
    bits_floats(hash, out, 4 * count);
    add_result(hash, norma_orthogonalise_tangents(given, 0, normals, count, out, 0, count));
    bits_floats(hash, out, 4 * count);
    free(given);
    free(out);
}

static void through(
    const double model[16], norma_vec3_view positions, norma_vec3_view normals, bits_hash *hash) {
    float single[16], matrix[9] = {0};
    float *out = bits_room(3 * positions.count, sizeof *out);
    double *wide = bits_room(3 * positions.count, sizeof *wide);
    for (int k = 0; k < 16; ++k) single[k] = (float)model[k];
    add_result(hash, norma_normal_matrix(single, NORMA_WINDING_REVERSED, matrix, NULL));
    add_result(hash, norma_transform_normals(matrix, normals, out, 0, normals.count));
    bits_floats(hash, out, 3 * normals.count);
    add_result(hash, norma_transform_normals(
                         matrix, positions, out, 0, positions.count)); /* any format, any length */
    bits_floats(hash, out, 3 * positions.count);
    add_result(hash, norma_transform_positions(model, positions, out, 0, positions.count));
    bits_floats(hash, out, 3 * positions.count);
    add_result(hash, norma_transform_positions_double(model, positions, wide, 0, positions.count));
    bits_doubles(hash, wide, 3 * positions.count);
    tangents(single, normals, hash);
    free(out);
    free(wide);
}

static void winding(const norma_mesh *mesh, bits_hash *hash) {
    const size_t size = mesh->corner_size ? mesh->corner_size : 4;
    if (!mesh->corners) return;
    unsigned char *copy = bits_room(mesh->corner_count, size);
    memcpy(copy, mesh->corners, mesh->corner_count * size);
    add_result(hash,
        norma_reverse_winding(copy, size, mesh->corner_count, mesh->face_starts, mesh->face_count));
    bits_bytes(hash, copy, mesh->corner_count * size);
    free(copy);
}

void bits_streams(const bits_mesh *m, bits_hash *hash) {
    norma_vec3_view positions = m->mesh.positions;
    float *normals = bits_room(3 * positions.count, sizeof *normals);
    uint64_t seed = 89;
    double model[16];
    if (norma_vertex_normals(&m->mesh, NULL, normals, positions.count, NULL))
        memset(normals, 0, 12 * positions.count);
    if (positions.count > MOST_VECTORS) positions.count = MOST_VECTORS;
    const norma_vec3_view view = {.data = normals, .count = positions.count};
    for (size_t i = 0; i < 12; ++i) {
        make_model(i * 5 + 1, &seed, model);
        through(model, positions, view, hash);
    }
    packed(view, hash);
    packed(positions, hash);
    for (size_t i = 0; i + 3 <= positions.count && i < 300; i += 3) {
        const float barycentric[3] = {.25f + (float)(i % 8), .5f, -.125f * (float)(i % 3)};
        float normal[3];
        add_result(hash, norma_interpolate_normal(normals + 3 * i, normals + 3 * i + 3,
                             normals + 3 * i + 6, barycentric, normal));
        bits_floats(hash, normal, 3);
    }
    winding(&m->mesh, hash);
    free(normals);
}
