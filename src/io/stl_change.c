/* stl_change.c: facet normals from the winding, and an STL under a matrix.
 *
 * A facet normal of zero is a custom that means "take the winding": it counts as missing, so `only missing` and `only broken` fill it; broken beyond that is
 * what is not finite (of N101 to N103, N101 alone is for facets). */
#include "stl.h"
#include "carry.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

/* ---- computing */

static int is_wanted(const float stored[3], norma_only only)
{
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
        if (!isfinite(stored[axis]))
            return only == NORMA_ONLY_BROKEN;
        square += (double)stored[axis] * (double)stored[axis];
    }
    return square < 1e-12;
}

/* Puts the stored normals back where they are not to change, and the sign of zeros, which says nothing. */
static void keep_stored(stl_state *state, norma_only only)
{
    for (size_t i = 0; i < state->facets; ++i) {
        const float *stored = state->stored + 3 * i;
        const int stays = only != NORMA_ONLY_ALL && !is_wanted(stored, only);
        for (size_t axis = 0; axis < 3; ++axis)
            if (stays || state->normals[3 * i + axis] == stored[axis])
                state->normals[3 * i + axis] = stored[axis];
    }
}

/* Counts the facets that got another's normal. Where no facet has a direction at all, files get the z axis. */
static size_t fill(stl_state *state, const uint8_t *reasons, norma_only only)
{
    size_t filled = 0;
    for (size_t i = 0; i < state->facets; ++i) {
        float *normal = state->normals + 3 * i;
        if (!reasons[i])
            continue;
        filled += only == NORMA_ONLY_ALL || is_wanted(state->stored + 3 * i, only);
        if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0)
            normal[2] = 1;
    }
    return filled;
}

static norma_document_result compute_normals(norma_document *document, const norma_compute_options *options, norma_compute_summary *summary, norma_document_error *error)
{
    stl_state *state = document->state;
    const norma_mesh mesh = norma_stl_core_mesh(state);
    norma_options core;
    norma_options_of_compute(options, &core);
    uint8_t *reasons = norma_io_allocate(state->facets, 1);
    state->normals = malloc(state->facets ? state->facets * 3 * sizeof *state->normals : 1);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!reasons || !state->normals)
        result = norma_document_fail_memory(document, error);
    core.reasons = reasons;
    norma_result failed = result ? NORMA_OK : norma_face_normals(&mesh, &core, state->normals, state->facets, &summary->report);
    if (failed)
        result = norma_document_fail_core(document, error, failed);
    if (!result) {
        summary->filled = fill(state, reasons, options->only);
        keep_stored(state, options->only);
    }
    free(reasons);
    return result;
}

norma_document_result norma_stl_compute(norma_document *document, const norma_compute_options *options, norma_compute_summary *summary, norma_document_error *error)
{
    if (options->shading == NORMA_SHADING_SMOOTH || options->shading == NORMA_SHADING_CREASE)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
                                   "STL holds one normal for each facet: smooth shading and creases cannot be stored; expected neither, or another format");
    norma_document_result result = norma_stl_settle(document, error);
    if (!result)
        result = norma_stl_decode(document, error);
    if (result)
        return result;
    const stl_state *state = document->state;
    const norma_count none = {0, SIZE_MAX};
    summary->report = (norma_report){none, none, none, none, none, none};
    summary->faces = state->facets;
    summary->vertices_before = summary->vertices_after = 3 * state->facets;
    summary->shading = NORMA_SHADING_FLAT;
    if (state->facets == 0)
        return NORMA_DOCUMENT_OK;
    result = compute_normals(document, options, summary, error);
    return result ? result : norma_stl_drop_idle_edit(document, &summary->changed, error);
}

/* ---- transforming */

/* Under a mirror the second and the third vertex change places, so that the winding still tells the outside. */
static void swap_vertices(double *vertices, size_t facets)
{
    for (size_t i = 0; i < facets; ++i) {
        double second[3];
        memcpy(second, vertices + 9 * i + 3, sizeof second);
        memcpy(vertices + 9 * i + 3, vertices + 9 * i + 6, sizeof second);
        memcpy(vertices + 9 * i + 6, second, sizeof second);
    }
}

static norma_document_result check_range(norma_document *document, norma_document_error *error)
{
    const stl_state *state = document->state;
    for (size_t i = 0; i < 9 * state->facets && (state->binary || !state->many_digits); ++i)
        if (isfinite(state->vertices[i]) && fabs(state->vertices[i]) > (double)FLT_MAX)
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "the matrix takes facet %zu beyond what the file's numbers hold", i / 9);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result transform_vertices(norma_document *document, const double matrix[16], int mirrored, norma_document_error *error)
{
    stl_state *state = document->state;
    const norma_mesh mesh = norma_stl_core_mesh(state);
    state->vertices = norma_io_allocate(state->facets, 9 * sizeof *state->vertices);
    if (!state->vertices)
        return norma_document_fail_memory(document, error);
    norma_result failed = norma_transform_positions_double(matrix, mesh.positions, state->vertices, 0, mesh.positions.count);
    if (failed)
        return norma_document_fail_core(document, error, failed);
    if (mirrored)
        swap_vertices(state->vertices, state->facets);
    return check_range(document, error);
}

static norma_document_result transform_normals(norma_document *document, const normal_carrier *carrier, norma_document_error *error)
{
    stl_state *state = document->state;
    const size_t numbers = 3 * state->facets;
    double *stored = norma_io_allocate(numbers, sizeof *stored);
    state->normals = norma_io_allocate(numbers, sizeof *state->normals);
    norma_document_result result = stored && state->normals ? NORMA_DOCUMENT_OK : norma_document_fail_memory(document, error);
    for (size_t i = 0; i < numbers && !result; ++i)
        stored[i] = (double)state->stored[i];
    if (!result)
        result = norma_carry_normals(document, carrier, stored, state->facets, state->normals, error);
    free(stored);
    return result;
}

norma_document_result norma_stl_transform(norma_document *document, const norma_transform_options *options, norma_transform_summary *summary, norma_document_error *error)
{
    norma_document_result result = norma_stl_settle(document, error);
    if (result)
        return result;
    summary->vertices = 3 * ((const stl_state *)document->state)->facets;
    summary->meshes = 1;
    if (norma_carry_is_identity(options->matrix))
        return NORMA_DOCUMENT_OK;
    normal_carrier carrier;
    result = norma_carry_prepare(document, options->matrix, &carrier, error);
    if (result)
        return result;
    summary->mirrored = carrier.mirrored;
    if (options->progress && options->progress(options->progress_user, 0))
        return norma_document_fail(document, error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
    result = norma_stl_decode(document, error);
    if (!result)
        result = transform_vertices(document, options->matrix, carrier.mirrored, error);
    if (!result)
        result = transform_normals(document, &carrier, error);
    if (!result)
        result = norma_stl_drop_idle_edit(document, &summary->changed, error);
    if (!result && options->progress && options->progress(options->progress_user, 1))
        return norma_document_fail(document, error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
    return result;
}
