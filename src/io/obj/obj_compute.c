/* obj_compute.c: new normals for the corners that need one; of the old ones stay those that
 * something still names. Equal normals are one, numbered as corners first use them, after the old
 * ones. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "io/stream/large_memory.h"
#include "io/format/broken_normal.h"
#include "io/obj/obj.h"
#include "io/obj/deduplicate_normals.h"
#include "io/stream/tasks.h"

#define PI 3.14159265358979323846

typedef struct computation {
    norma_document *document;
    obj_state *state;
    norma_compute_summary *summary;
    norma_document_error *error;
    norma_only only;
    norma_mesh mesh;
    norma_options core;
    norma_shading shading;
    double crease;
    norma_edges edges;
    uint8_t *wanted;  /* of each corner; NULL: all */
    float *computed;  /* of each element: a point, a corner, a position or a face, as elements has
                         it; zero where the mesh has none at all */
    uint8_t *reasons; /* in step with computed */
    uint32_t *points; /* of each corner the point, numbered as corners first use them; NULL:
                         elements are no points */
    size_t element_count;
} computation;

/* ---- which corners */

static int is_broken(const float *n) {
    const double normal[3] = {(double)n[0], (double)n[1], (double)n[2]};
    return norma_normal_is_broken(normal, norma_unit_tolerance(32));
}

/* A face without normals: none of its corners names one that is there. */
static int lacks_normals(const obj_state *state, size_t face) {
    for (size_t c = norma_obj_face_start(state, face); c < norma_obj_face_start(state, face + 1);
         ++c)
        if (norma_obj_normal(state, c) < OBJ_BAD_NORMAL) return 0;
    return 1;
}

/* A corner that names a normal which is not there always gets one: left alone, it would come to
 * name one of the new ones. */
static int is_wanted(const computation *c, size_t corner) {
    uint32_t normal = norma_obj_normal(c->state, corner);
    if (normal == OBJ_BAD_NORMAL) return 1;
    if (c->only == NORMA_ONLY_MISSING)
        return normal == OBJ_NO_NORMAL &&
               c->document->lenient; /* of a face that names normals at other corners: told of by
                                        norma check */
    return normal == OBJ_NO_NORMAL || is_broken(c->state->normals + 3 * (size_t)normal);
}

/* 0: memory is out. */
static int choose_corners(computation *c, size_t *count) {
    const obj_state *state = c->state;
    *count = state->corner_count;
    if (c->only == NORMA_ONLY_ALL) return 1;
    c->wanted = norma_io_allocate(state->corner_count, 1);
    if (!c->wanted) return 0;
    *count = 0;
    for (size_t face = 0; face < state->face_count; ++face) {
        int whole = lacks_normals(state, face);
        for (size_t corner = norma_obj_face_start(state, face);
             corner < norma_obj_face_start(state, face + 1); ++corner) {
            c->wanted[corner] = (uint8_t)(whole || is_wanted(c, corner));
            *count += c->wanted[corner];
        }
    }
    return 1;
}

/* ---- computing */

static norma_result choose_shading(computation *c, const norma_compute_options *options) {
    int by_groups = options->groups == NORMA_GROUPS_AUTO && c->state->has_groups;
    c->shading = options->shading;
    c->crease = options->shading == NORMA_SHADING_CREASE ? options->crease_angle_rad
                : by_groups                              ? PI
                                                         : PI / 3;
    if (c->shading == NORMA_SHADING_DEFAULT) c->shading = NORMA_SHADING_CREASE;
    by_groups &= c->shading == NORMA_SHADING_CREASE;
    c->summary->shading = c->shading;
    c->summary->crease_angle_rad = c->shading == NORMA_SHADING_CREASE ? c->crease : 0;
    c->summary->by_groups = by_groups;
    c->mesh = norma_obj_mesh(c->state);
    if (!by_groups) return NORMA_OK;
    norma_result result = norma_obj_groups(c->state, &c->core);
    c->mesh.smoothing_groups = c->state->group_masks;
    c->mesh.hard_edges = c->state->hard_edges;
    return result;
}

/* All that the core counted without a normal of its own. */
static size_t without_normal(const norma_report *report) {
    return report->non_finite.count + report->unreferenced.count + report->cancelled.count;
}

/* Where every corner gets a new normal, those of one position that share theirs are computed as one
 * point: less to write, and less to number. */
static norma_result compute_points(computation *c) {
    const size_t most = c->state->corner_count;
    c->points = norma_io_block(most, sizeof *c->points);
    c->computed = norma_io_room(most, 3 * sizeof *c->computed);
    if (!c->points || !c->computed) return NORMA_ERROR_MEMORY;
    norma_result result = norma_split(&c->mesh, (float)c->crease, &c->core, c->points, most, NULL,
        c->computed, most, &c->element_count, &c->summary->report);
    c->summary->filled = without_normal(&c->summary->report);
    return result;
}

static norma_result compute_corners(computation *c) {
    return norma_corner_normals(
        &c->mesh, (float)c->crease, &c->core, c->computed, c->element_count, &c->summary->report);
}

static norma_result compute_each(computation *c) {
    const obj_state *state = c->state;
    size_t count = c->shading == NORMA_SHADING_SMOOTH ? state->position_count
                   : c->shading == NORMA_SHADING_FLAT ? state->face_count
                                                      : state->corner_count;
    c->element_count = count;
    c->computed = norma_io_block(count, 3 * sizeof *c->computed);
    c->reasons = norma_io_allocate(count, 1);
    if (!c->computed || !c->reasons) return NORMA_ERROR_MEMORY;
    c->core.reasons = c->reasons;
    if (c->shading == NORMA_SHADING_SMOOTH)
        return norma_vertex_normals(&c->mesh, &c->core, c->computed, count, &c->summary->report);
    if (c->shading == NORMA_SHADING_FLAT)
        return norma_face_normals(&c->mesh, &c->core, c->computed, count, &c->summary->report);
    return compute_corners(c);
}

static norma_result compute_elements(computation *c) {
    const int creased = c->shading == NORMA_SHADING_CREASE;
    if (creased) c->core.edges = &c->edges;
    norma_result result = creased && !c->wanted ? compute_points(c) : compute_each(c);
    c->summary->edges_counted = creased;
    c->summary->hard_edges = c->edges.hard;
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

static size_t element_of(const computation *c, size_t face, size_t corner) {
    if (c->points) return c->points[corner];
    return c->shading == NORMA_SHADING_SMOOTH ? c->state->corners[corner]
           : c->shading == NORMA_SHADING_FLAT ? face
                                              : corner;
}

enum { LEAST_SLICE = 1 << 15 };

typedef struct renumbering {
    const computation *c;
    const uint32_t *numbers, *old_numbers;
    size_t slices, kept;
    uint32_t *corner_normals;
} renumbering;

/* Normals as they are written: what no element of the mesh has is up; zero has no sign. */
static void finish_normals(void *context, size_t slice) {
    const renumbering *r = context;
    const size_t count = r->c->element_count, end = norma_io_slice(count, r->slices, slice + 1);
    for (size_t i = norma_io_slice(count, r->slices, slice); i < end; ++i) {
        float *n = r->c->computed + 3 * i;
        for (int k = 0; k < 3; ++k) n[k] += 0.0f;
        if (n[0] == 0 && n[1] == 0 && n[2] == 0) n[2] = 1;
    }
}

/* The elements that wanted corners use, in the order of their first use. Counts those that had no
 * normal of their own. 0: out of memory. */
static int order_elements(computation *c, obj_numbering *numbering) {
    const obj_state *state = c->state;
    uint8_t *seen = norma_io_allocate(c->element_count, 1);
    numbering->order = norma_io_block(c->element_count, sizeof *numbering->order);
    if (!seen || !numbering->order) {
        free(seen);
        return 0;
    }
    for (size_t face = 0; face < state->face_count; ++face)
        for (size_t corner = norma_obj_face_start(state, face);
             corner < norma_obj_face_start(state, face + 1); ++corner) {
            const size_t element = element_of(c, face, corner);
            if (seen[element] || (c->wanted && !c->wanted[corner])) continue;
            seen[element] = 1;
            numbering->order[numbering->count++] = (uint32_t)element;
            c->summary->filled += c->reasons[element] != NORMA_REASON_NONE;
        }
    free(seen);
    return 1;
}

/* Each wanted corner's number, the others' as they were kept. Points become numbers where they
 * stand. */
static void renumber_slice(void *context, size_t slice) {
    const renumbering *r = context;
    const computation *c = r->c;
    const obj_state *state = c->state;
    const size_t end = norma_io_slice(state->face_count, r->slices, slice + 1);
    for (size_t face = norma_io_slice(state->face_count, r->slices, slice); face < end; ++face)
        for (size_t corner = norma_obj_face_start(state, face);
             corner < norma_obj_face_start(state, face + 1); ++corner) {
            const uint32_t old = norma_obj_normal(state, corner);
            if (c->wanted && !c->wanted[corner])
                r->corner_normals[corner] = old == OBJ_NO_NORMAL ? old : r->old_numbers[old];
            else
                r->corner_normals[corner] =
                    (uint32_t)r->kept + r->numbers[element_of(c, face, corner)];
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

/* Numbers for all corners. */
static obj_numbered number_corners(computation *c, obj_numbering *numbering, renumbering *r) {
    const obj_state *state = c->state;
    r->slices = norma_io_slices(c->element_count, LEAST_SLICE);
    if (norma_io_tasks_watched(&c->core, r->slices, finish_normals, r))
        return OBJ_NUMBERED_CANCELLED;
    if (!c->points && !order_elements(c, numbering)) return OBJ_NUMBERED_MEMORY;
    obj_numbered result = norma_obj_number(numbering);
    if (!result && numbering->unique_count > OBJ_MOST - r->kept) result = OBJ_NUMBERED_MEMORY;
    if (result) return result;
    r->numbers = numbering->numbers;
    r->corner_normals =
        c->points ? c->points : norma_io_block(state->corner_count, sizeof *r->corner_normals);
    if (!r->corner_normals) return OBJ_NUMBERED_MEMORY;
    r->slices = norma_io_slices(state->face_count, LEAST_SLICE);
    const int cancelled = norma_io_tasks_watched(&c->core, r->slices, renumber_slice, r);
    c->points = NULL;
    return cancelled ? OBJ_NUMBERED_CANCELLED : OBJ_NUMBERED;
}

static void take_corner_normals(obj_state *state, uint32_t *corner_normals) {
    free(state->corner_normals);
    state->corner_normals = corner_normals;
    state->has_normals = 1;
    state->bad_normal_count = 0;
    state->normals_replaced = 1;
}

static norma_document_result store(computation *c) {
    obj_state *state = c->state;
    uint32_t *old_numbers = norma_io_allocate(state->normal_count, sizeof *old_numbers);
    renumbering r = {
        .c = c, .old_numbers = old_numbers, .kept = old_numbers ? number_old(c, old_numbers) : 0};
    obj_numbering numbering = {.normals = c->computed,
        .element_count = c->element_count,
        .count = c->points ? c->element_count : 0,
        .options = &c->core};
    obj_numbered numbered = old_numbers ? number_corners(c, &numbering, &r) : OBJ_NUMBERED_MEMORY;
    const int idle = !numbered && says_so_already(c, numbering.unique, r.kept, r.corner_normals);
    if (!numbered && !idle && !replace_normals(state, &numbering, old_numbers, r.kept))
        numbered = OBJ_NUMBERED_MEMORY;
    free(old_numbers);
    free(numbering.order);
    free(numbering.numbers);
    free(numbering.unique);
    if (!numbered && !idle)
        take_corner_normals(state, r.corner_normals);
    else if (r.corner_normals != c->points)
        free(r.corner_normals);
    c->summary->changed = !numbered && !idle;
    if (numbered == OBJ_NUMBERED_CANCELLED)
        return norma_document_fail_core(c->document, c->error, NORMA_CANCELLED);
    return numbered ? norma_document_fail_memory(c->document, c->error) : NORMA_DOCUMENT_OK;
}

static norma_document_result run(computation *c, const norma_compute_options *options) {
    size_t wanted;
    if (!choose_corners(c, &wanted)) return norma_document_fail_memory(c->document, c->error);
    norma_result result = choose_shading(c, options);
    if (!result && wanted) result = compute_elements(c);
    if (result) return norma_document_fail_core(c->document, c->error, result);
    return wanted ? store(c) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_obj_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error) {
    obj_state *state = document->state;
    computation c = {.document = document,
        .state = state,
        .summary = summary,
        .error = error,
        .only = options->only};
    norma_count *counts[] = {&summary->report.degenerate_faces, &summary->report.non_finite,
        &summary->report.unreferenced, &summary->report.cancelled,
        &summary->report.non_manifold_edges, &summary->report.winding_conflicts};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; ++i) counts[i]->first = SIZE_MAX;
    summary->faces = state->face_count;
    summary->vertices_before = summary->vertices_after = state->position_count;
    norma_options_of_compute(options, &c.core);
    norma_document_result result = run(&c, options);
    free(c.wanted);
    free(c.points);
    free(c.computed);
    free(c.reasons);
    return result;
}
