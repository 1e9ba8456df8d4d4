/* obj_transform.c: positions under a matrix, normals under its normal matrix, faces turned round
 * where it mirrors. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "io/format/transform_stored_normals.h"
#include "io/file/large_memory.h"
#include "io/obj/obj.h"

static int is_identity(const double m[16], int columns) {
    for (int i = 0; i < 4 * columns; ++i)
        if (i % 4 != 3 && m[i] != (i % 5 == 0)) return 0;
    return 1;
}

/* Whether floats hold the positions well enough: they lie no farther from the origin than sixteen
 * times their extent, and within the range of floats. */
static int extent_is_float(const double *positions, size_t count) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    double extent = 0, farthest = 0;
    for (size_t i = 0; i < 3 * count; ++i)
        if (isfinite(positions[i])) {
            low[i % 3] = fmin(low[i % 3], positions[i]);
            high[i % 3] = fmax(high[i % 3], positions[i]);
        }
    for (int i = 0; i < 3; ++i) {
        extent = fmax(extent, high[i] - low[i]);
        farthest = fmax(farthest, fmax(high[i], -low[i]));
    }
    return farthest <= 16 * extent && extent > 1e-30 && farthest < 1e30;
}

static norma_document_result move_positions(norma_document *document, obj_state *state,
    const double matrix[16], norma_document_error *error) {
    const norma_vec3_view view = {state->positions, state->position_count, 0, NORMA_FORMAT_DOUBLE};
    if (!state->position_count) return NORMA_DOCUMENT_OK;
    double *moved = norma_io_block(state->position_count, 3 * sizeof *moved);
    if (!moved) return norma_document_fail_memory(document, error);
    norma_document_result result = norma_document_fail_core(document, error,
        norma_transform_positions_double(matrix, view, moved, 0, state->position_count));
    if (!result)
        result = norma_check_transformed_range(document, &view, moved, DBL_MAX, "vertex", 1, error);
    if (result) {
        free(moved);
        return result;
    }
    free(state->positions);
    state->positions = moved;
    state->position_room = state->position_count;
    state->floats_suffice =
        (state->positions_moved ? state->floats_suffice : !state->has_long_positions) &&
        extent_is_float(state->positions, state->position_count);
    state->positions_moved = 1;
    return result;
}

/* The factor that brings the largest of nine numbers near 1, so that floats hold them. */
static void to_floats(const double matrix[9], float floats[9]) {
    double largest = 0;
    int exponent;
    for (int i = 0; i < 9; ++i) largest = fmax(largest, fabs(matrix[i]));
    frexp(largest, &exponent);
    for (int i = 0; i < 9; ++i) floats[i] = (float)ldexp(matrix[i], -exponent);
}

/* Normals that are not finite, and zero, stay what they are: that they are broken is not for a
 * transform to hide. So do those that a matrix without an inverse leaves no direction; *lost counts
 * them. */
static void take_turned(obj_state *state, const float *turned, size_t *lost) {
    for (size_t i = 0; i < state->normal_count; ++i) {
        float *old = state->normals + 3 * i;
        const float *new = turned + 3 * i;
        if (new[0] != 0 || new[1] != 0 || new[2] != 0)
            memcpy(old, new, 3 * sizeof *old);
        else if (isfinite(old[0]) && isfinite(old[1]) && isfinite(old[2]))
            *lost += old[0] != 0 || old[1] != 0 || old[2] != 0;
    }
}

static norma_result turn_normals(
    norma_document *document, obj_state *state, const double normal_matrix[9]) {
    const norma_vec3_view view = {state->normals, state->normal_count, 0, NORMA_FORMAT_FLOAT};
    float matrix[9];
    size_t lost = 0;
    float *turned = norma_io_allocate(state->normal_count, 3 * sizeof *turned);
    if (!turned) return NORMA_ERROR_MEMORY;
    to_floats(normal_matrix, matrix);
    norma_result result =
        state->normal_count ? norma_transform_normals(matrix, view, turned, 0, state->normal_count)
                            : NORMA_OK;
    if (!result) take_turned(state, turned, &lost);
    if (lost)
        norma_document_add_note(document,
            "%zu normals have no direction under this matrix, and stay as they were", lost);
    state->normals_turned = 1;
    free(turned);
    return result;
}

static void swap(uint32_t *a, uint32_t *b) {
    uint32_t c = *a;
    *a = *b;
    *b = c;
}

static void reverse_faces(obj_state *state) {
    for (size_t face = 0; face < state->face_count; ++face)
        for (size_t a = norma_obj_face_start(state, face) + 1,
                    b = norma_obj_face_start(state, face + 1) - 1;
             a < b; ++a, --b) {
            swap(&state->corners[a], &state->corners[b]);
            if (state->corner_normals) swap(&state->corner_normals[a], &state->corner_normals[b]);
        }
    state->faces_reversed = !state->faces_reversed;
}

norma_document_result norma_obj_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    obj_state *state = document->state;
    norma_matrix_info info;
    double normal_matrix[9];
    summary->vertices = state->position_count;
    summary->meshes = 1;
    norma_result result =
        norma_normal_matrix_double(options->matrix, NORMA_WINDING_REVERSED, normal_matrix, &info);
    if (result) return norma_document_fail_core(document, error, result);
    summary->mirrored = info.mirrored;
    if (is_identity(options->matrix, 4) || (!state->position_count && !state->normal_count))
        return NORMA_DOCUMENT_OK;
    norma_document_result told = norma_stored_normals_progress(document, options, 0, error);
    if (!told) told = move_positions(document, state, options->matrix, error);
    if (told) return told;
    summary->changed = 1;
    if (!is_identity(options->matrix, 3)) result = turn_normals(document, state, normal_matrix);
    if (result) return norma_document_fail_core(document, error, result);
    if (info.mirrored) reverse_faces(state);
    if (info.mirrored && state->has_surfaces)
        norma_document_add_note(document,
            "the matrix mirrors; free-form surfaces keep the direction of their "
            "parameters, so their front and back are swapped");
    return norma_stored_normals_progress(document, options, 1, error);
}
