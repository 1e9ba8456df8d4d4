/* transform_stored_normals.c: stored normals under the matrix of a whole document: cof(M) with the
 * sign of its determinant, since faces are reversed under a mirror. */
#include "io/format/transform_stored_normals.h"
#include "core/call/vec3_view.h"
#include <math.h>
#include <stdio.h>

int norma_stored_normals_is_identity(const double model[16]) {
    for (int i = 0; i < 16; ++i)
        if (model[i] != (i % 5 == 0 ? 1.0 : 0.0)) return 0;
    return 1;
}

norma_document_result norma_stored_normals_progress(const norma_document *document,
    const norma_transform_options *options, double fraction, norma_document_error *error) {
    if (options->progress && options->progress(options->progress_user, fraction))
        return norma_document_fail_cancelled(document, error);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result prepare_map(const norma_document *document, const double model[16],
    normal_carrier *carrier, norma_document_error *error) {
    double exact[9], greatest = 0, squares[3] = {0};
    norma_matrix_info info;
    norma_result failed = norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, exact, &info);
    if (failed) return norma_document_fail_core(document, error, failed);
    for (size_t i = 0; i < 9; ++i) greatest = fabs(exact[i]) > greatest ? fabs(exact[i]) : greatest;
    /* Near 1, so that no entry that matters is lost when it becomes a float. */
    for (size_t i = 0; i < 9; ++i) {
        exact[i] = greatest > 0 ? exact[i] / greatest : 0;
        carrier->matrix[i] = (float)exact[i];
        squares[i / 3] += exact[i] * exact[i];
    }
    size_t longest = 0;
    for (size_t column = 1; column < 3; ++column)
        longest = squares[column] > squares[longest] ? column : longest;
    for (size_t axis = 0; axis < 3; ++axis)
        carrier->flat[axis] =
            greatest > 0 ? exact[3 * longest + axis] / sqrt(squares[longest]) : axis == 2;
    carrier->mirrored = info.mirrored;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_stored_normals_begin(const norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    normal_carrier *carrier, norma_document_error *error) {
    norma_document_result result = prepare_map(document, options->matrix, carrier, error);
    if (result) return result;
    summary->mirrored = carrier->mirrored;
    return norma_stored_normals_progress(document, options, 0, error);
}

norma_document_result norma_check_transformed_range(const norma_document *document,
    const norma_vec3_view *before, const double *after, double most, const char *what,
    size_t positions_each, norma_document_error *error) {
    for (size_t i = 0; i < before->count; ++i) {
        double old[3];
        const double *p = after + 3 * i;
        if (fabs(p[0]) <= most && fabs(p[1]) <= most && fabs(p[2]) <= most) continue;
        norma_view_read(before, i, old);
        if (!isfinite(old[0]) || !isfinite(old[1]) || !isfinite(old[2])) continue;
        for (size_t axis = 0; axis < 3; ++axis) {
            char place[40];
            if (fabs(p[axis]) <= most) continue;
            snprintf(place, sizeof place, "%s %zu", what, i / positions_each);
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
                "the matrix moves it beyond %.3g, the largest number that the file can hold", most);
        }
    }
    return NORMA_DOCUMENT_OK;
}

static void settle_lost(const normal_carrier *carrier, const double *before, float *after,
    size_t count, size_t *vanished, size_t *not_finite) {
    for (size_t i = 0; i < count; ++i, before += 3, after += 3) {
        if (after[0] != 0 || after[1] != 0 || after[2] != 0) continue;
        if (!isfinite(before[0]) || !isfinite(before[1]) || !isfinite(before[2])) {
            ++*not_finite;
        } else if (before[0] != 0 || before[1] != 0 || before[2] != 0) {
            ++*vanished;
            for (int axis = 0; axis < 3; ++axis) after[axis] = (float)carrier->flat[axis];
        }
    }
}

norma_document_result norma_transform_stored_normals(norma_document *document,
    const normal_carrier *carrier, const double *normals, size_t count, float *out,
    norma_document_error *error) {
    const norma_vec3_view view = {.data = normals, .count = count, .format = NORMA_FORMAT_DOUBLE};
    norma_result failed = norma_transform_normals(carrier->matrix, view, out, 0, count);
    if (failed) return norma_document_fail_core(document, error, failed);
    size_t vanished = 0, not_finite = 0;
    settle_lost(carrier, normals, out, count, &vanished, &not_finite);
    if (vanished > 0)
        norma_document_add_note(document,
            "%zu normals vanish under this matrix, because it flattens; they got the one direction "
            "that is left",
            vanished);
    if (not_finite > 0)
        norma_document_add_note(
            document, "%zu normals were not finite and became zero", not_finite);
    return NORMA_DOCUMENT_OK;
}
