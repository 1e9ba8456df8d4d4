/* obj_compute.c: new normals for the corners that need one; of the old ones stay those that
 * something still names. Equal normals are one, numbered as corners first use them, after the old
 * ones. */
#include <stdlib.h>
#include <string.h>
#include "io/file/large_memory.h"
#include "io/format/compute_policy.h"
#include "io/obj/obj.h"
#include "io/obj/deduplicate_normals.h"
#include "io/stream/tasks.h"

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
static int lacks_normals(const obj_state *state, size_t face) {
    for (size_t c = norma_obj_face_start(state, face); c < norma_obj_face_start(state, face + 1);
         ++c)
        if (norma_obj_normal(state, c) < OBJ_BAD_NORMAL) return 0;
    return 1;
}

/* A corner that names a normal which is not there always gets one: left alone, it would come to
 * name one of the new ones. */
static int is_wanted(const computation *c, size_t corner) {
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
        int whole = lacks_normals(state, face);
        for (size_t corner = norma_obj_face_start(state, face);
             corner < norma_obj_face_start(state, face + 1); ++corner) {
            const int kept =
                locked && locked[face] && norma_obj_normal(state, corner) < OBJ_BAD_NORMAL;
            c->wanted[corner] = (uint8_t)(!kept && (whole || is_wanted(c, corner)));
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

static size_t element_of(const computation *c, size_t face, size_t corner) {
    if (c->made.points) return c->made.points[corner];
    return c->made.elements == NORMALS_OF_POSITIONS ? c->state->corners[corner]
           : c->made.elements == NORMALS_OF_FACES   ? face
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
    const size_t count = r->c->made.count, end = norma_io_slice(count, r->slices, slice + 1);
    for (size_t i = norma_io_slice(count, r->slices, slice); i < end; ++i) {
        float *n = r->c->made.normals + 3 * i;
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
            const size_t element = element_of(c, face, corner);
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
    r->slices = norma_io_slices(c->made.count, LEAST_SLICE);
    if (norma_io_tasks_watched(&c->policy.core, r->slices, finish_normals, r))
        return OBJ_NUMBERED_CANCELLED;
    if (!c->made.points && !order_elements(c, numbering)) return OBJ_NUMBERED_MEMORY;
    obj_numbered result = norma_obj_number(numbering);
    if (!result && numbering->unique_count > OBJ_MOST - r->kept) result = OBJ_NUMBERED_MEMORY;
    if (result) return result;
    r->numbers = numbering->numbers;
    r->corner_normals = c->made.points
                            ? c->made.points
                            : norma_io_block(state->corner_count, sizeof *r->corner_normals);
    if (!r->corner_normals) return OBJ_NUMBERED_MEMORY;
    r->slices = norma_io_slices(state->face_count, LEAST_SLICE);
    const int cancelled = norma_io_tasks_watched(&c->policy.core, r->slices, renumber_slice, r);
    c->made.points = NULL;
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
    obj_numbering numbering = {.normals = c->made.normals,
        .element_count = c->made.count,
        .count = c->made.points ? c->made.count : 0,
        .options = &c->policy.core};
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
    else if (r.corner_normals != c->made.points)
        free(r.corner_normals);
    c->policy.summary->changed = !numbered && !idle;
    if (numbered == OBJ_NUMBERED_CANCELLED)
        return norma_document_fail_core(c->document, c->error, NORMA_CANCELLED);
    return numbered ? norma_document_fail_memory(c->document, c->error) : NORMA_DOCUMENT_OK;
}

static norma_document_result run(computation *c) {
    size_t wanted;
    if (!choose_corners(c, &wanted)) return norma_document_fail_memory(c->document, c->error);
    if (!wanted) return NORMA_DOCUMENT_OK;
    const norma_result result = compute_elements(c);
    return result ? norma_document_fail_core(c->document, c->error, result) : store(c);
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
    norma_document_result result = run(&c);
    free(c.wanted);
    norma_computed_normals_free(&c.made);
    return result;
}
