/* more_calls.c: calls that norma-mesh/normals does without: encodings, what a matrix is, normals
 * transformed, tangents made perpendicular. */
#include "calls.h"
#include "exports.h"

#define PI 3.141592653589793

/* In place: tangents, four floats each, made perpendicular to normals, three floats each. */
norma_result WEB_EXPORT(web_orthogonalise_tangents)(
    float *tangents, const float *normals, size_t count) {
    return norma_orthogonalise_tangents(tangents, 0,
        (norma_vec3_view){normals, count, 0, NORMA_FORMAT_FLOAT}, count, tangents, 0, count);
}

/* numbers: determinant, anisotropy, worst error in radians, the three of the worst normal, kind,
 * rank, mirrored, shortcut. */
norma_result WEB_EXPORT(web_matrix_info)(const float *model, double numbers[10]) {
    norma_matrix_info info;
    float normal_matrix[9];
    const norma_result result =
        norma_normal_matrix(model, NORMA_WINDING_REVERSED, normal_matrix, &info);
    numbers[0] = info.determinant;
    numbers[1] = info.anisotropy;
    numbers[2] = info.worst_error_rad;
    for (int i = 0; i < 3; ++i) numbers[3 + i] = (double)info.worst_normal[i];
    numbers[6] = info.kind;
    numbers[7] = info.rank;
    numbers[8] = info.mirrored;
    numbers[9] = norma_matrix_shortcut(&info);
    return result;
}

/* codes: 32 bits each. */
norma_result WEB_EXPORT(web_encode_normals)(const void *normals, size_t count, size_t stride,
    norma_format format, norma_encoding encoding, uint32_t *codes, norma_report *report) {
    return norma_encode_normals(
        (norma_vec3_view){normals, count, stride, format}, encoding, codes, 0, count, report);
}

norma_result WEB_EXPORT(web_decode_normals)(
    const uint32_t *codes, size_t count, norma_encoding encoding, float *normals) {
    return norma_decode_normals(codes, 0, count, encoding, normals, 0);
}

double WEB_EXPORT(web_encoding_error_deg)(norma_encoding encoding) {
    return norma_encoding_error_rad(encoding) * (180 / PI);
}

norma_result WEB_EXPORT(web_transform_normals)(const float *normal_matrix, const void *normals,
    size_t count, size_t stride, norma_format format, float *out) {
    return norma_transform_normals(
        normal_matrix, (norma_vec3_view){normals, count, stride, format}, out, 0, count);
}
