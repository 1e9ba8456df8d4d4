/* normals.c: what is decided when the normals of a file are computed, and what a matrix or a move
 * makes of positions and stored normals, alike for every format. The core is called by vertex, by
 * corner, or, as by default, for vertices that are split at creases (norma_split). */
#include "io/format/format.h"
#include "core/call/call.h"
#include "core/face/unit_length.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

static const norma_count NONE = {0, SIZE_MAX};

/* ---- how the mesh is shaded */

compute_policy norma_policy_begin(const norma_compute_options *options,
    norma_compute_summary *summary, norma_shading usual, int has_groups) {
    const compute_policy policy = {.options = options,
        .summary = summary,
        .core = {.struct_size = sizeof policy.core,
            .weight = options->weight,
            .weld = options->weld,
            .weld_distance = options->weld_distance,
            .non_manifold = options->non_manifold,
            .fallback = NORMA_FALLBACK_NEAREST,
            .threads = options->threads,
            .progress = options->progress,
            .progress_user = options->progress_user}};
    summary->report = (norma_report){NONE, NONE, NONE, NONE, NONE, NONE};
    summary->shading = options->shading == NORMA_SHADING_DEFAULT ? usual : options->shading;
    if (summary->shading != NORMA_SHADING_CREASE) return policy;
    summary->by_groups = has_groups && options->groups == NORMA_GROUPS_AUTO;
    summary->crease_angle_rad = options->shading == NORMA_SHADING_CREASE ? options->crease_angle_rad
                                : summary->by_groups                     ? PI
                                                                         : PI / 3;
    return policy;
}

/* ---- which stored normals are replaced */

int norma_normal_is_broken(const double normal[3], int bits) {
    double length;
    return norma_core_judge_length(normal, norma_core_unit_tolerance(bits, 0), &length) !=
           CORE_LENGTH_UNIT;
}

int norma_policy_wants(norma_only only, const double normal[3], int bits) {
    return only == NORMA_ONLY_ALL ||
           (only == NORMA_ONLY_BROKEN && norma_normal_is_broken(normal, bits));
}

int norma_policy_wants_facet(norma_only only, const float stored[3]) {
    const double normal[3] = {(double)stored[0], (double)stored[1], (double)stored[2]};
    double length;
    const core_length is = norma_core_judge_length(normal, 0, &length);
    return only == NORMA_ONLY_ALL || is == CORE_LENGTH_ZERO ||
           (is == CORE_LENGTH_NON_FINITE && only == NORMA_ONLY_BROKEN);
}

/* ---- computing */

normal_elements norma_policy_elements(norma_shading shading) {
    return shading == NORMA_SHADING_SMOOTH ? NORMALS_OF_POSITIONS
           : shading == NORMA_SHADING_FLAT ? NORMALS_OF_FACES
                                           : NORMALS_OF_POINTS;
}

void norma_computed_normals_free(computed_normals *made) {
    free(made->normals);
    free(made->reasons);
    free(made->points);
    free(made->sources);
    *made = (computed_normals){.elements = made->elements};
}

/* Of points many may not come to be; their room is never touched. */
static int make_policy_room(const norma_mesh *mesh, computed_normals *made) {
    const int points = made->elements == NORMALS_OF_POINTS;
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    made->count = made->elements == NORMALS_OF_POSITIONS ? mesh->positions.count
                  : made->elements == NORMALS_OF_FACES   ? faces
                                                         : mesh->corner_count;
    made->normals = norma_io_block(made->count, 3 * sizeof *made->normals);
    made->points = points ? norma_io_block(made->count, sizeof *made->points) : NULL;
    made->reasons = made->with_reasons ? norma_io_allocate(made->count, 1) : NULL;
    made->sources =
        made->with_reasons && points ? norma_io_block(made->count, sizeof *made->sources) : NULL;
    return made->normals && (made->points || !points) && (made->reasons || !made->with_reasons) &&
           (made->sources || !made->with_reasons || !points);
}

static norma_result run_policy(const norma_options *core, const norma_mesh *mesh,
    computed_normals *made, norma_report *report) {
    const size_t most = made->count;
    const float crease = (float)made->crease_angle_rad;
    switch (made->elements) {
    case NORMALS_OF_POSITIONS:
        return norma_vertex_normals(mesh, core, made->normals, most, report);
    case NORMALS_OF_FACES:
        return norma_face_normals(mesh, core, made->normals, most, report);
    case NORMALS_OF_CORNERS:
        return norma_corner_normals(mesh, crease, core, made->normals, most, report);
    default:
        return norma_split(mesh, crease, core, made->points, most, made->sources, made->normals,
            most, &made->count, report);
    }
}

static void add_count(norma_count *sum, const norma_count *count, size_t meshes_before) {
    sum->count = meshes_before ? sum->count + count->count : count->count;
    sum->first = meshes_before ? SIZE_MAX : count->first;
}

void norma_policy_add_report(norma_report *sum, const norma_report *report, size_t meshes_before) {
    add_count(&sum->degenerate_faces, &report->degenerate_faces, meshes_before);
    add_count(&sum->non_finite, &report->non_finite, meshes_before);
    add_count(&sum->unreferenced, &report->unreferenced, meshes_before);
    add_count(&sum->cancelled, &report->cancelled, meshes_before);
    add_count(&sum->non_manifold_edges, &report->non_manifold_edges, meshes_before);
    add_count(&sum->winding_conflicts, &report->winding_conflicts, meshes_before);
}

/* ---- normals from outside */

typedef struct corner_points {
    const float *normals;
    const uint8_t *reasons;
    uint32_t *first,
        *next; /* of each position its last point so far, of each point the one before */
} corner_points;

/* The point of the position that has these bits, or a new one. */
static uint32_t policy_point_of(
    const corner_points *from, size_t corner, uint32_t position, computed_normals *made) {
    const float *normal = from->normals + 3 * corner;
    uint32_t point = from->first[position];
    while (point != UINT32_MAX &&
           memcmp(made->normals + 3 * (size_t)point, normal, 3 * sizeof *normal) != 0)
        point = from->next[point];
    if (point != UINT32_MAX) return point;
    point = (uint32_t)made->count++;
    memcpy(made->normals + 3 * (size_t)point, normal, 3 * sizeof *normal);
    if (made->reasons) made->reasons[point] = from->reasons[corner];
    if (made->sources) made->sources[point] = position;
    from->next[point] = from->first[position];
    from->first[position] = point;
    return point;
}

static int find_policy_points(const norma_mesh *mesh, corner_points *from, computed_normals *made) {
    from->first = norma_io_block(mesh->positions.count, sizeof *from->first);
    from->next = norma_io_block(mesh->corner_count, sizeof *from->next);
    const int ok = from->first && from->next;
    for (size_t i = 0; ok && i < mesh->positions.count; ++i) from->first[i] = UINT32_MAX;
    made->count = 0;
    for (size_t c = 0; ok && c < mesh->corner_count; ++c)
        made->points[c] = policy_point_of(from, c, norma_mesh_corner(mesh, c), made);
    free(from->first);
    free(from->next);
    return ok;
}

static norma_result take_policy_points(
    compute_policy *policy, const norma_mesh *mesh, computed_normals *made) {
    const shared_normals *shared = policy->shared;
    float *normals = norma_io_block(mesh->corner_count, 3 * sizeof *normals);
    uint8_t *reasons = norma_io_allocate(mesh->corner_count, 1);
    corner_points from = {.normals = normals, .reasons = reasons};
    norma_result result = normals && reasons
                              ? shared->take(shared->user, policy->surface, mesh, normals, reasons)
                              : NORMA_ERROR_MEMORY;
    if (!result && !find_policy_points(mesh, &from, made)) result = NORMA_ERROR_MEMORY;
    free(normals);
    free(reasons);
    return result;
}

static int is_policy_shared(const compute_policy *policy, normal_elements elements) {
    if (!policy->shared) return 0;
    return policy->shared->of_corners
               ? elements == NORMALS_OF_CORNERS || elements == NORMALS_OF_POINTS
               : elements == NORMALS_OF_POSITIONS;
}

static norma_result take_given_normals(
    compute_policy *policy, const norma_mesh *mesh, computed_normals *made, norma_report *report) {
    const shared_normals *shared = policy->shared;
    const norma_result result =
        made->elements == NORMALS_OF_POINTS
            ? take_policy_points(policy, mesh, made)
            : shared->take(shared->user, policy->surface, mesh, made->normals, made->reasons);
    if (!result && made->reasons)
        norma_policy_report(report, made->reasons, made->count, NULL, 0, 0);
    return result;
}

norma_result norma_policy_compute(
    compute_policy *policy, const norma_mesh *mesh, computed_normals *made) {
    norma_compute_summary *summary = policy->summary;
    norma_options core = policy->core;
    norma_edges edges = {0};
    norma_report report = {NONE, NONE, NONE, NONE, NONE, NONE};
    const int creased = made->elements == NORMALS_OF_CORNERS || made->elements == NORMALS_OF_POINTS;
    if (!make_policy_room(mesh, made)) return NORMA_ERROR_MEMORY;
    core.reasons = made->reasons;
    if (creased) core.edges = &edges;
    const int shared = is_policy_shared(policy, made->elements);
    const norma_result result = shared ? take_given_normals(policy, mesh, made, &report)
                                       : run_policy(&core, mesh, made, &report);
    if (result) return result;
    norma_policy_add_report(&summary->report, &report, policy->meshes++);
    summary->edges_counted |= creased && !shared;
    summary->hard_edges += edges.hard;
    return NORMA_OK;
}

/* ---- what is written, what is counted */

void norma_policy_fill(compute_policy *policy, float *normals, const uint8_t *reasons, size_t count,
    const uint8_t *wanted, size_t wanted_count) {
    for (size_t i = 0; i < count; ++i) {
        if (!reasons[i]) continue;
        policy->summary->filled += !wanted || i >= wanted_count || wanted[i];
        norma_policy_point_up(normals + 3 * i);
    }
}

void norma_policy_forget(norma_report *report) {
    report->non_finite = report->unreferenced = report->cancelled = NONE;
}

static void count_reason(norma_count *count, size_t index, int several) {
    if (count->count++ == 0) count->first = index;
    if (several) count->first = SIZE_MAX;
}

void norma_policy_report(norma_report *report, const uint8_t *reasons, size_t count,
    const uint8_t *wanted, size_t wanted_count, int several) {
    for (size_t i = 0; i < count; ++i) {
        if (wanted && i < wanted_count && !wanted[i]) continue;
        if (reasons[i] == NORMA_REASON_NON_FINITE)
            count_reason(&report->non_finite, i, several);
        else if (reasons[i] == NORMA_REASON_UNREFERENCED)
            count_reason(&report->unreferenced, i, several);
        else if (reasons[i] == NORMA_REASON_CANCELLED)
            count_reason(&report->cancelled, i, several);
    }
}

size_t norma_policy_without_normal(const norma_report *report) {
    return report->non_finite.count + report->unreferenced.count + report->cancelled.count;
}

/* ---- The step that brings the middle of a box to the origin, or nearly: a multiple of a
 * power of two not below the box's size, so that it has few bits. Where the box lies eight times
 * its size away, step and positions are within a factor of two of one another, and their difference
 * is exact (Sterbenz 1974). */

static const double FAR = 8;

recentre_box norma_recentre_empty(void) {
    return (recentre_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

void norma_recentre_add(recentre_box *box, const double position[3]) {
    if (!isfinite(position[0]) || !isfinite(position[1]) || !isfinite(position[2])) return;
    for (int axis = 0; axis < 3; ++axis) {
        box->low[axis] = fmin(box->low[axis], position[axis]);
        box->high[axis] = fmax(box->high[axis], position[axis]);
    }
}

int norma_recentre_step(const recentre_box *box, double step[3]) {
    double size = 0;
    int any = 0, exponent;
    for (int axis = 0; axis < 3; ++axis) size = fmax(size, box->high[axis] - box->low[axis]);
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = box->low[axis] / 2 + box->high[axis] / 2;
        step[axis] = 0;
        if (!(box->low[axis] <= box->high[axis]) || !(fabs(middle) > FAR * size) || !isfinite(size))
            continue;
        frexp(size, &exponent);
        const double unit = ldexp(1, size > 0 ? exponent : 0),
                     rounded = size > 0 ? unit * round(middle / unit) : middle;
        step[axis] = (double)(float)rounded;
        any |= step[axis] != 0;
    }
    return any;
}

/* ---- Matrices of 4 x 4, column by column. */

int norma_matrix_is_identity(const double m[16]) {
    for (int i = 0; i < 16; ++i)
        if (m[i] != (i % 5 == 0 ? 1.0 : 0.0)) return 0;
    return 1;
}

void norma_matrix_multiply(const double a[16], const double b[16], double product[16]) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
            product[4 * column + row] = sum;
        }
}

double norma_matrix_determinant(const double m[16]) {
    return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) +
           m[8] * (m[1] * m[6] - m[5] * m[2]);
}

/* ---- Stored normals under the matrix of a whole document: cof(M) with the
 * sign of its determinant, since faces are reversed under a mirror. */

norma_document_result norma_stored_normals_progress(const norma_document *document,
    const norma_transform_options *options, double fraction, norma_document_error *error) {
    if (options->progress && options->progress(options->progress_user, fraction))
        return norma_document_fail_cancelled(document, error);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result prepare_map(const norma_document *document, const double model[16],
    normal_mapping *mapping, norma_document_error *error) {
    double exact[9], greatest = 0, squares[3] = {0};
    norma_matrix_info info;
    norma_result failed = norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, exact, &info);
    if (failed) return norma_document_fail_core(document, error, failed);
    for (size_t i = 0; i < 9; ++i) greatest = fabs(exact[i]) > greatest ? fabs(exact[i]) : greatest;
    /* Near 1, so that no entry that matters is lost when it becomes a float. */
    for (size_t i = 0; i < 9; ++i) {
        exact[i] = greatest > 0 ? exact[i] / greatest : 0;
        mapping->matrix[i] = (float)exact[i];
        squares[i / 3] += exact[i] * exact[i];
    }
    size_t longest = 0;
    for (size_t column = 1; column < 3; ++column)
        longest = squares[column] > squares[longest] ? column : longest;
    for (size_t axis = 0; axis < 3; ++axis)
        mapping->flat[axis] =
            greatest > 0 ? exact[3 * longest + axis] / sqrt(squares[longest]) : axis == 2;
    mapping->mirrored = info.mirrored;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_stored_normals_begin(const norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    normal_mapping *mapping, norma_document_error *error) {
    norma_document_result result = prepare_map(document, options->matrix, mapping, error);
    if (result) return result;
    summary->mirrored = mapping->mirrored;
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

static void fill_lost(const normal_mapping *mapping, const double *before, float *after,
    size_t count, size_t *vanished, size_t *not_finite) {
    for (size_t i = 0; i < count; ++i, before += 3, after += 3) {
        if (after[0] != 0 || after[1] != 0 || after[2] != 0) continue;
        if (!isfinite(before[0]) || !isfinite(before[1]) || !isfinite(before[2])) {
            ++*not_finite;
        } else if (before[0] != 0 || before[1] != 0 || before[2] != 0) {
            ++*vanished;
            for (int axis = 0; axis < 3; ++axis) after[axis] = (float)mapping->flat[axis];
        }
    }
}

norma_document_result norma_transform_stored_normals(norma_document *document,
    const normal_mapping *mapping, const double *normals, size_t count, float *out,
    norma_document_error *error) {
    const norma_vec3_view view = {.data = normals, .count = count, .format = NORMA_FORMAT_DOUBLE};
    norma_result failed = norma_transform_normals(mapping->matrix, view, out, 0, count);
    if (failed) return norma_document_fail_core(document, error, failed);
    size_t vanished = 0, not_finite = 0;
    fill_lost(mapping, normals, out, count, &vanished, &not_finite);
    if (vanished > 0)
        norma_document_add_note(document,
            "normals that vanish under this matrix, because it flattens: %zu; they got the one "
            "direction that is left",
            vanished);
    if (not_finite > 0)
        norma_document_add_note(
            document, "normals that were not finite and became zero: %zu", not_finite);
    return NORMA_DOCUMENT_OK;
}
