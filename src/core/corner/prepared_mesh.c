/* prepared_mesh.c: the stages that every call on vertices or corners begins with. */
#include "core/corner/corner.h"
#include "core/face/face.h"
#include "core/mesh/mesh.h"
#include "core/call/call.h"

enum { FACES_IN_CHUNK = 1 << 12 };

typedef struct survey_part {
    norma_count degenerate;
    int any_flat;
} survey_part;

typedef struct face_survey {
    core_prepared_mesh *prepared;
    survey_part *parts; /* of each chunk of this survey */
} face_survey;

static void survey_face(
    const face_survey *survey, size_t f, const core_face *face, survey_part *part) {
    const core_prepared_mesh *s = survey->prepared;
    const core_mesh *mesh = &s->mesh;
    s->faces[f] = *face;
    if (s->flat_at && (face->flags & CORE_FACE_EDGED))
        s->faces[f].key = norma_core_twin_key(mesh, f);
    if ((face->flags & CORE_FACE_DIRECTED) || !(face->flags & CORE_FACE_FINITE)) return;
    norma_core_count_one(&part->degenerate, f);
    if (!s->flat_at || !(face->flags & CORE_FACE_EDGED)) return;
    part->any_flat = 1;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c)
        norma_core_mark_flat(s, norma_core_welded_corner(mesh, c));
}

static void survey_chunk(void *context, size_t chunk) {
    const face_survey *survey = context;
    const core_prepared_mesh *s = survey->prepared;
    const size_t count = s->mesh.face_count, begin = chunk * FACES_IN_CHUNK,
                 end = count - begin < FACES_IN_CHUNK ? count : begin + FACES_IN_CHUNK;
    core_face faces[CORE_FACES_AT_ONCE];
    for (size_t f = begin, next; f < end; f = next) {
        next = end - f < CORE_FACES_AT_ONCE ? end : f + CORE_FACES_AT_ONCE;
        norma_core_faces_geometry(s->call, &s->mesh, f, next - f, faces);
        for (size_t i = 0; i < next - f; ++i)
            survey_face(survey, f + i, &faces[i], &survey->parts[chunk]);
    }
}

/* Measures all polygons once, and keeps them. */
static norma_result survey_faces(face_survey *survey, int *any_flat) {
    core_prepared_mesh *s = survey->prepared;
    const size_t chunks =
        s->mesh.face_count / FACES_IN_CHUNK + (s->mesh.face_count % FACES_IN_CHUNK != 0);
    survey->parts = norma_core_allocate(s->call, chunks, sizeof *survey->parts);
    if (!survey->parts) return NORMA_ERROR_MEMORY;
    memset(survey->parts, 0, chunks * sizeof *survey->parts);
    const norma_result result = norma_core_parallel(s->call, chunks, survey_chunk, survey);
    for (size_t i = 0; i < chunks; ++i) {
        norma_core_count_add(&s->degenerate_faces, &survey->parts[i].degenerate);
        *any_flat |= survey->parts[i].any_flat;
    }
    norma_core_release(s->call, survey->parts, chunks, sizeof *survey->parts);
    return result;
}

static void borrow_at_each(
    core_prepared_mesh *s, uint32_t *longest, core_star *star, uint32_t *borrowed_from) {
    memset(longest, 0xff, s->mesh.face_count * sizeof *longest);
    memset(borrowed_from, 0xff, s->mesh.face_count * sizeof *borrowed_from);
    for (size_t p = 0; p < s->mesh.positions.count; ++p) {
        if (!atomic_load_explicit(&s->flat_at[p], memory_order_relaxed)) continue;
        norma_core_star_load(s, (uint32_t)p, 0, star);
        norma_core_star_borrow_directions(s, star, longest, borrowed_from);
    }
}

norma_result norma_core_borrow_directions(core_prepared_mesh *s) {
    const size_t faces = s->mesh.face_count;
    core_star star = {0};
    uint32_t *borrowed_from = norma_core_allocate(s->call, faces, sizeof *borrowed_from),
             *longest = norma_core_allocate(s->call, faces, sizeof *longest);
    norma_result result = borrowed_from && longest
                              ? norma_core_star_allocate(s->call, &star, s->corners_of.most)
                              : NORMA_ERROR_MEMORY;
    if (!result) {
        borrow_at_each(s, longest, &star, borrowed_from);
        norma_core_star_release(s->call, &star, s->corners_of.most);
        s->borrowed_from = borrowed_from;
        borrowed_from = NULL;
    }
    norma_core_release(s->call, longest, faces, sizeof *longest);
    norma_core_release(s->call, borrowed_from, faces, sizeof *borrowed_from);
    return result;
}

norma_result norma_core_watch_for_flat(core_prepared_mesh *s) {
    const size_t positions = s->mesh.positions.count;
    if (s->flat_at) return NORMA_OK;
    s->flat_at = norma_core_allocate(s->call, positions, sizeof *s->flat_at);
    if (!s->flat_at) return NORMA_ERROR_MEMORY;
    memset((void *)s->flat_at, 0, positions * sizeof *s->flat_at); /* nobody works yet */
    return NORMA_OK;
}

static norma_result survey_for_fans(core_prepared_mesh *s) {
    face_survey survey = {.prepared = s};
    int any_flat = 0;
    norma_result result = norma_core_watch_for_flat(s);
    if (!result) result = survey_faces(&survey, &any_flat);
    return !result && any_flat ? norma_core_borrow_directions(s) : result;
}

/* Faces without corners: who adds to sums of positions never meets them. */
static void count_empty_faces(core_prepared_mesh *s) {
    for (size_t f = 0; f < s->mesh.face_count; ++f)
        if (s->mesh.face_starts[f] == s->mesh.face_starts[f + 1])
            norma_core_count_one(&s->degenerate_faces, f);
}

/* For stars, polygons are measured once; triangles where they are met. */
static norma_result measure_polygons(core_prepared_mesh *s, core_use use) {
    face_survey survey = {.prepared = s};
    int any_flat = 0;
    if (use == CORE_FOR_SUMS) {
        count_empty_faces(s);
        return NORMA_OK;
    }
    if (!(s->faces = norma_core_allocate(s->call, s->mesh.face_count, sizeof *s->faces)))
        return NORMA_ERROR_MEMORY;
    return use == CORE_FOR_FANS ? survey_for_fans(s) : survey_faces(&survey, &any_flat);
}

norma_result norma_core_prepared_mesh_open(core_call *call, core_mesh *checked, core_use use,
    double crease_angle_rad, core_prepared_mesh *prepared) {
    *prepared = (core_prepared_mesh){.call = call, .mesh = *checked};
    prepared->crease = norma_core_crease_at(crease_angle_rad);
    norma_core_stage(call, 0.05, 0.2);
    norma_result result = norma_core_weld(call, &prepared->mesh);
    if (!result) result = norma_core_mark_reflex(call, &prepared->mesh);
    if (!result && use != CORE_FOR_SUMS) {
        norma_core_stage(call, 0.2, 0.35);
        result = norma_core_corners_of_position_build(call, &prepared->mesh, &prepared->corners_of);
    }
    if (!result && norma_core_face_starts(&prepared->mesh)) {
        norma_core_stage(call, 0.35, 0.5);
        result = measure_polygons(prepared, use);
    }
    if (result) norma_core_prepared_mesh_close(prepared);
    return result;
}

norma_result norma_core_begin_with_crease(core_call *call, const norma_options *options,
    const norma_mesh *mesh, float crease_angle_rad, core_mesh *checked) {
    norma_result result = norma_core_begin(call, options);
    if (!result) result = norma_core_check_crease(crease_angle_rad, NULL);
    if (!result) result = norma_core_mesh_shape(mesh, checked);
    if (!result) norma_core_share(call, checked->corner_count);
    return result;
}

norma_result norma_core_prepare_fans(
    core_call *call, core_mesh *checked, float crease_angle_rad, core_prepared_mesh *prepared) {
    norma_core_stage(call, 0, 0.05);
    const norma_result result = norma_core_mesh_content(call, checked);
    return !result ? norma_core_prepared_mesh_open(
                         call, checked, CORE_FOR_FANS, (double)crease_angle_rad, prepared)
                   : result;
}

void norma_core_prepared_mesh_close(core_prepared_mesh *prepared) {
    const core_call *call = prepared->call;
    norma_core_release(
        call, prepared->borrowed_from, prepared->mesh.face_count, sizeof *prepared->borrowed_from);
    norma_core_release(
        call, prepared->flat_at, prepared->mesh.positions.count, sizeof *prepared->flat_at);
    norma_core_release(call, prepared->faces, prepared->mesh.face_count, sizeof *prepared->faces);
    if (prepared->corners_of.starts)
        norma_core_corners_of_position_release(call, &prepared->corners_of);
    norma_core_release(
        call, (void *)(uintptr_t)prepared->mesh.reflex, prepared->mesh.corner_count, 1);
    if (prepared->mesh.weld) norma_core_unweld(call, &prepared->mesh);
    *prepared = (core_prepared_mesh){0};
}

/* ---- norma_find_fault. The checks are those that every call makes, asked once more with room for
 * what they find. */

static norma_result find_wrong_corner(const core_mesh *mesh, norma_fault *fault) {
    for (size_t c = 0; c < mesh->corner_count; ++c)
        if (norma_core_corner(mesh, c) >= mesh->positions.count)
            return norma_core_refuse(fault, NORMA_ERROR_INDEX, "mesh->corners", c,
                "the index of a position, below mesh->positions.count");
    return NORMA_OK;
}

norma_result norma_find_fault(const norma_mesh *mesh, const float *crease_angle_rad,
    const norma_options *options, norma_fault *fault) {
    core_mesh checked;
    norma_core_refuse(fault, NORMA_OK, NULL, SIZE_MAX, NULL);
    norma_result result = norma_core_check_options(options, fault);
    if (!result && crease_angle_rad) result = norma_core_check_crease(*crease_angle_rad, fault);
    if (!result) result = norma_core_check_shape(mesh, &checked, fault);
    if (!result) result = norma_core_check_face_starts(&checked, fault);
    return !result ? find_wrong_corner(&checked, fault) : result;
}
