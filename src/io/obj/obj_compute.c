/* obj_compute.c: new normals for the corners that need one; an OBJ under a matrix. */
#include "io/obj/obj.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Equal normals are one, numbered in the order of their first use. */

typedef struct obj_numbering {
    const float *normals; /* of elements, three each */
    size_t element_count;
    uint32_t *order; /* elements in the order of first use; NULL: all, as they are */
    size_t count;    /* of the order */
    /* found */
    uint32_t *numbers; /* of each element in the order; of others undefined */
    float *unique;     /* each normal once, by its number */
    size_t unique_count;
} obj_numbering;

static const unsigned char *normal_row(const void *context, size_t place, size_t *length) {
    const obj_numbering *n = context;
    *length = 3 * sizeof *n->normals;
    return (const unsigned char *)(n->normals + 3 * (n->order ? n->order[place] : place));
}

/* What it found is the caller's to free. 0: out of memory. */
static int obj_number(obj_numbering *n) {
    uint32_t *numbers = norma_io_block(n->count, sizeof *numbers);
    n->numbers = norma_io_block(n->element_count, sizeof *n->numbers);
    if (numbers && n->numbers &&
        norma_number_rows(normal_row, n, n->count, numbers, &n->unique_count))
        n->unique = norma_io_block(n->unique_count, 3 * sizeof *n->unique);
    for (size_t i = 0; n->unique && i < n->count; ++i) {
        size_t length;
        const unsigned char *normal = normal_row(n, i, &length);
        memcpy(n->unique + 3 * (size_t)numbers[i], normal, length);
        n->numbers[n->order ? n->order[i] : i] = numbers[i];
    }
    free(numbers);
    return n->unique != NULL;
}

/* ---- New normals for the corners that need one; of the old ones stay those that
 * something still names. Equal normals are one, numbered as corners first use them, after the old
 * ones. */

typedef struct computation {
    norma_document *document;
    obj_state *state;
    norma_document_error *error;
    compute_policy policy;
    norma_mesh mesh;
    uint8_t *wanted; /* of each corner; NULL: all */
    computed_normals made;
} computation;

/* ---- which corners */

/* A face without normals: none of its corners names one that is there. */
static int obj_lacks_normals(const obj_state *state, size_t face) {
    for (size_t c = norma_obj_face_start(state, face); c < norma_obj_face_start(state, face + 1);
         ++c)
        if (norma_obj_normal(state, c) < OBJ_BAD_NORMAL) return 0;
    return 1;
}

/* A corner that names a normal which is not there always gets one: left alone, it would come to
 * name one of the new ones. */
static int obj_is_wanted(const computation *c, size_t corner) {
    const norma_only only = c->policy.options->only;
    const uint32_t normal = norma_obj_normal(c->state, corner);
    if (normal == OBJ_BAD_NORMAL) return 1;
    /* Its face names normals at other corners, which is a matter for norma check. */
    if (normal == OBJ_NO_NORMAL) return only != NORMA_ONLY_MISSING || c->document->lenient;
    const float *n = c->state->normals + 3 * (size_t)normal;
    return norma_policy_wants(only, (double[]){(double)n[0], (double)n[1], (double)n[2]}, 32);
}

static const uint8_t *locked_faces(const computation *c) {
    return c->document->shared ? c->document->shared->locked : NULL;
}

/* 0: memory is out. */
static int choose_corners(computation *c, size_t *count) {
    const obj_state *state = c->state;
    *count = state->corner_count;
    const uint8_t *locked = locked_faces(c);
    if (c->policy.options->only == NORMA_ONLY_ALL && !locked) return 1;
    c->wanted = norma_io_allocate(state->corner_count, 1);
    if (!c->wanted) return 0;
    *count = 0;
    for (size_t face = 0; face < state->face_count; ++face) {
        int whole = obj_lacks_normals(state, face);
        for (size_t corner = norma_obj_face_start(state, face);
             corner < norma_obj_face_start(state, face + 1); ++corner) {
            const int kept =
                locked && locked[face] && norma_obj_normal(state, corner) < OBJ_BAD_NORMAL;
            c->wanted[corner] = (uint8_t)(!kept && (whole || obj_is_wanted(c, corner)));
            *count += c->wanted[corner];
        }
    }
    return 1;
}

/* ---- computing */

/* Where every corner gets a new normal, those of one position that share theirs are computed as one
 * point: less to write, and less to number. */
static norma_result compute_elements(computation *c) {
    const norma_compute_summary *summary = c->policy.summary;
    computed_normals *made = &c->made;
    made->elements = norma_policy_elements(summary->shading);
    made->crease_angle_rad = summary->crease_angle_rad;
    made->with_reasons = made->elements != NORMALS_OF_POINTS || c->wanted;
    if (made->elements == NORMALS_OF_POINTS && c->wanted) made->elements = NORMALS_OF_CORNERS;
    c->mesh = norma_obj_mesh(c->state);
    norma_result result =
        summary->by_groups ? norma_obj_groups(c->state, &c->policy.core) : NORMA_OK;
    if (result) return result;
    if (summary->by_groups) {
        c->mesh.smoothing_groups = c->state->group_masks;
        c->mesh.hard_edges = c->state->hard_edges;
    }
    result = norma_policy_compute(&c->policy, &c->mesh, made);
    if (made->points) c->policy.summary->filled = norma_policy_without_normal(&summary->report);
    return result;
}

/* ---- numbering */

/* Of the old normals those that stay, given their new numbers; the others UINT32_MAX. With --only,
 * lines that nothing named stay too: they are no business of ours. */
static size_t number_old(const computation *c, uint32_t *numbers) {
    const obj_state *state = c->state;
    size_t kept = 0;
    memset(numbers, c->wanted ? 1 : 0, state->normal_count * sizeof *numbers);
    for (size_t corner = 0; c->wanted && corner < state->corner_count; ++corner)
        if (c->wanted[corner] && norma_obj_normal(state, corner) < OBJ_BAD_NORMAL)
            numbers[state->corner_normals[corner]] = 0;
    for (size_t corner = 0; c->wanted && corner < state->corner_count; ++corner)
        if (!c->wanted[corner] && norma_obj_normal(state, corner) < OBJ_BAD_NORMAL)
            numbers[state->corner_normals[corner]] = 1;
    for (size_t i = 0; i < state->other_count; ++i)
        if (state->other_normals[i] < OBJ_BAD_NORMAL) numbers[state->other_normals[i]] = 1;
    for (size_t i = 0; i < state->normal_count; ++i)
        numbers[i] = numbers[i] ? (uint32_t)kept++ : UINT32_MAX;
    return kept;
}

/* ---- elements become numbers */

static size_t obj_element_of(const computation *c, size_t face, size_t corner) {
    if (c->made.points) return c->made.points[corner];
    return c->made.elements == NORMALS_OF_POSITIONS ? c->state->corners[corner]
           : c->made.elements == NORMALS_OF_FACES   ? face
                                                    : corner;
}

/* Normals as they are written: what no element of the mesh has is up; zero has no sign. */
static void finish_normals(computed_normals *made) {
    for (size_t i = 0; i < made->count; ++i) {
        float *n = made->normals + 3 * i;
        for (int k = 0; k < 3; ++k) n[k] += 0.0f;
        norma_policy_point_up(n);
    }
}

/* The elements that wanted corners use, in the order of their first use. Counts those that had no
 * normal of their own. 0: out of memory. */
static int order_elements(computation *c, obj_numbering *numbering) {
    const obj_state *state = c->state;
    uint8_t *seen = norma_io_allocate(c->made.count, 1);
    numbering->order = norma_io_block(c->made.count, sizeof *numbering->order);
    if (!seen || !numbering->order) {
        free(seen);
        return 0;
    }
    for (size_t face = 0; face < state->face_count; ++face)
        for (size_t corner = norma_obj_face_start(state, face);
             corner < norma_obj_face_start(state, face + 1); ++corner) {
            const size_t element = obj_element_of(c, face, corner);
            if (seen[element] || (c->wanted && !c->wanted[corner])) continue;
            seen[element] = 1;
            numbering->order[numbering->count++] = (uint32_t)element;
            c->policy.summary->filled += c->made.reasons[element] != NORMA_REASON_NONE;
        }
    free(seen);
    return 1;
}

/* Each wanted corner's number, the others' as they were kept. Points become numbers where they
 * stand. */
static void renumber(const computation *c, const uint32_t *numbers, const uint32_t *old_numbers,
    size_t kept, uint32_t *corner_normals) {
    const obj_state *state = c->state;
    for (size_t face = 0; face < state->face_count; ++face)
        for (size_t corner = norma_obj_face_start(state, face);
             corner < norma_obj_face_start(state, face + 1); ++corner) {
            const uint32_t old = norma_obj_normal(state, corner);
            if (c->wanted && !c->wanted[corner])
                corner_normals[corner] = old == OBJ_NO_NORMAL ? old : old_numbers[old];
            else
                corner_normals[corner] = (uint32_t)kept + numbers[obj_element_of(c, face, corner)];
        }
}

/* Whether every corner that gets a normal has these very numbers already (the sign of a zero
 * aside): then the file stays as it is. */
static int says_so_already(
    const computation *c, const float *normals, size_t base, const uint32_t *corner_normals) {
    const obj_state *state = c->state;
    for (size_t corner = 0; corner < state->corner_count; ++corner) {
        if (c->wanted && !c->wanted[corner]) continue;
        const uint32_t old = norma_obj_normal(state, corner);
        const float *now = normals + 3 * (corner_normals[corner] - base);
        if (old >= OBJ_BAD_NORMAL) return 0;
        for (size_t i = 0; i < 3; ++i)
            if (state->normals[3 * (size_t)old + i] != now[i]) return 0;
    }
    return 1;
}

/* Puts kept and new normals in place of the old ones. Where none are kept, the new ones are taken
 * as they are. */
static int replace_normals(
    obj_state *state, obj_numbering *numbering, const uint32_t *old_numbers, size_t kept) {
    const size_t count = kept + numbering->unique_count;
    float *normals = kept ? norma_io_block(count, 3 * sizeof *normals) : numbering->unique;
    size_t *offsets = norma_io_allocate(kept, sizeof *offsets);
    if (!normals || !offsets) {
        free(kept ? normals : NULL);
        free(offsets);
        return 0;
    }
    for (size_t i = 0; i < state->normal_count; ++i)
        if (old_numbers[i] != UINT32_MAX) {
            memcpy(
                normals + 3 * (size_t)old_numbers[i], state->normals + 3 * i, 3 * sizeof *normals);
            offsets[old_numbers[i]] = norma_obj_normal_offset(state, i);
        }
    if (kept && numbering->unique_count)
        memcpy(
            normals + 3 * kept, numbering->unique, 3 * numbering->unique_count * sizeof *normals);
    if (!kept) numbering->unique = NULL;
    for (size_t i = 0; i < state->other_count; ++i)
        if (state->other_normals[i] < OBJ_BAD_NORMAL)
            state->other_normals[i] = old_numbers[state->other_normals[i]];
    free(state->normals);
    free(state->normal_offsets);
    state->normals = normals;
    state->normal_offsets = offsets;
    state->normal_count = count;
    state->offset_count = kept;
    return 1;
}

/* Numbers for all corners, the caller's to free; NULL: out of memory. */
static uint32_t *obj_number_corners(
    computation *c, obj_numbering *numbering, const uint32_t *old_numbers, size_t kept) {
    finish_normals(&c->made);
    if ((!c->made.points && !order_elements(c, numbering)) || !obj_number(numbering) ||
        numbering->unique_count > OBJ_MOST - kept)
        return NULL;
    uint32_t *corner_normals = c->made.points
                                   ? c->made.points
                                   : norma_io_block(c->state->corner_count, sizeof *corner_normals);
    if (corner_normals) renumber(c, numbering->numbers, old_numbers, kept, corner_normals);
    c->made.points = NULL;
    return corner_normals;
}

static void take_corner_normals(obj_state *state, uint32_t *corner_normals) {
    free(state->corner_normals);
    state->corner_normals = corner_normals;
    state->has_normals = 1;
    state->bad_normal_count = 0;
    state->normals_replaced = 1;
}

static norma_document_result obj_store(computation *c) {
    obj_state *state = c->state;
    uint32_t *old_numbers = norma_io_allocate(state->normal_count, sizeof *old_numbers);
    const size_t kept = old_numbers ? number_old(c, old_numbers) : 0;
    obj_numbering numbering = {.normals = c->made.normals,
        .element_count = c->made.count,
        .count = c->made.points ? c->made.count : 0};
    uint32_t *corners = old_numbers ? obj_number_corners(c, &numbering, old_numbers, kept) : NULL;
    const int idle = corners && says_so_already(c, numbering.unique, kept, corners),
              stored = corners && !idle && replace_normals(state, &numbering, old_numbers, kept);
    free(old_numbers);
    free(numbering.order);
    free(numbering.numbers);
    free(numbering.unique);
    if (stored)
        take_corner_normals(state, corners);
    else
        free(corners);
    c->policy.summary->changed = stored;
    return idle || stored ? NORMA_DOCUMENT_OK : norma_document_fail_memory(c->document, c->error);
}

static norma_document_result number_and_keep(computation *c) {
    size_t wanted;
    if (!choose_corners(c, &wanted)) return norma_document_fail_memory(c->document, c->error);
    if (!wanted) return NORMA_DOCUMENT_OK;
    const norma_result result = compute_elements(c);
    return result ? norma_document_fail_core(c->document, c->error, result) : obj_store(c);
}

norma_document_result norma_obj_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    obj_state *state = document->state;
    computation c = {.document = document, .state = state, .error = error};
    c.policy = norma_policy_begin(options, summary, NORMA_SHADING_CREASE, state->has_groups);
    c.policy.shared = document->shared;
    summary->faces = state->face_count;
    summary->vertices_before = summary->vertices_after = state->position_count;
    norma_document_result result = number_and_keep(&c);
    free(c.wanted);
    norma_computed_normals_free(&c.made);
    return result;
}

/* ---- Positions under a matrix, normals under its normal matrix, faces turned round
 * where it mirrors. */

static int obj_is_identity(const double m[16], int columns) {
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

/* Text holds what a float cannot, but most readers take floats. */
static void tell_beyond_floats(
    norma_document *document, const double *before, const double *after, size_t position_count) {
    size_t beyond = 0;
    for (size_t i = 0; i < position_count; ++i)
        for (size_t axis = 0; axis < 3; ++axis)
            if (fabs(after[3 * i + axis]) > FLT_MAX && fabs(before[3 * i + axis]) <= FLT_MAX) {
                ++beyond;
                break;
            }
    if (beyond)
        norma_document_add_note(document,
            "%zu of %zu vertices are moved beyond %.3g: programs that read floats take that for "
            "infinite",
            beyond, position_count, (double)FLT_MAX);
}

static norma_document_result obj_move_positions(norma_document *document, obj_state *state,
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
    tell_beyond_floats(document, state->positions, moved, state->position_count);
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
static void obj_to_floats(const double matrix[9], float floats[9]) {
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
    obj_to_floats(normal_matrix, matrix);
    norma_result result =
        state->normal_count ? norma_transform_normals(matrix, view, turned, 0, state->normal_count)
                            : NORMA_OK;
    if (!result) take_turned(state, turned, &lost);
    if (lost)
        norma_document_add_note(document,
            "normals without a direction under this matrix: %zu; they stay as they were", lost);
    state->normals_turned = 1;
    free(turned);
    return result;
}

static void obj_swap(uint32_t *a, uint32_t *b) {
    uint32_t c = *a;
    *a = *b;
    *b = c;
}

static void reverse_faces(obj_state *state) {
    for (size_t face = 0; face < state->face_count; ++face)
        for (size_t a = norma_obj_face_start(state, face) + 1,
                    b = norma_obj_face_start(state, face + 1) - 1;
             a < b; ++a, --b) {
            obj_swap(&state->corners[a], &state->corners[b]);
            if (state->corner_normals)
                obj_swap(&state->corner_normals[a], &state->corner_normals[b]);
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
    if (obj_is_identity(options->matrix, 4) || (!state->position_count && !state->normal_count))
        return NORMA_DOCUMENT_OK;
    norma_document_result told = norma_stored_normals_progress(document, options, 0, error);
    if (!told) told = obj_move_positions(document, state, options->matrix, error);
    if (told) return told;
    summary->changed = 1;
    if (!obj_is_identity(options->matrix, 3)) result = turn_normals(document, state, normal_matrix);
    if (result) return norma_document_fail_core(document, error, result);
    if (info.mirrored) reverse_faces(state);
    if (info.mirrored && state->has_surfaces)
        norma_document_add_note(document,
            "the matrix mirrors; free-form surfaces keep the direction of their "
            "parameters, so their front and back are swapped");
    return norma_stored_normals_progress(document, options, 1, error);
}
