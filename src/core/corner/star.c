/* star.c: a star of corners loaded, its fans summed, its corners sorted by vertex and normal; and
 * the mesh made ready for stars. */
#include "core/corner/corner.h"
#include "core/face/face.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"

void norma_core_star_in_room(core_star *star, star_room *room) {
    *star = (core_star){.corners = room->corners,
        .edges = room->edges,
        .sorted = room->sorted,
        .sums = room->sums,
        .fans = room->fans,
        .joined = room->joined,
        .fan_of = room->fan_of,
        .normals = room->normals};
}

norma_result norma_core_star_allocate(const core_call *call, core_star *star, size_t corners) {
    *star = (core_star){0};
    star->corners = norma_core_allocate(call, corners, sizeof *star->corners);
    star->edges = norma_core_allocate(call, 2 * corners, sizeof *star->edges);
    star->sorted = norma_core_allocate(call, 2 * corners, sizeof *star->sorted);
    star->sums = norma_core_allocate(call, corners, sizeof *star->sums);
    star->fans = norma_core_allocate(call, corners, sizeof *star->fans);
    star->joined = norma_core_allocate(call, corners, sizeof *star->joined);
    star->fan_of = norma_core_allocate(call, corners, sizeof *star->fan_of);
    star->normals = norma_core_allocate(call, corners, sizeof *star->normals);
    if (star->corners && star->edges && star->sorted && star->sums && star->fans && star->joined &&
        star->fan_of && star->normals)
        return NORMA_OK;
    norma_core_star_release(call, star, corners);
    return NORMA_ERROR_MEMORY;
}

void norma_core_star_release(const core_call *call, core_star *star, size_t corners) {
    norma_core_release(call, star->corners, corners, sizeof *star->corners);
    norma_core_release(call, star->edges, 2 * corners, sizeof *star->edges);
    norma_core_release(call, star->sorted, 2 * corners, sizeof *star->sorted);
    norma_core_release(call, star->sums, corners, sizeof *star->sums);
    norma_core_release(call, star->fans, corners, sizeof *star->fans);
    norma_core_release(call, star->joined, corners, sizeof *star->joined);
    norma_core_release(call, star->fan_of, corners, sizeof *star->fan_of);
    norma_core_release(call, star->normals, corners, sizeof *star->normals);
    *star = (core_star){0};
}

/* All stars of a face without a direction need to know whose it borrows, those too that are passed
 * over: it is looked for at one of them. */
static void wait_for_lenders(const core_prepared_mesh *prepared, core_star *star, star_corner *c) {
    if (!(c->flags & STAR_FLAT)) return;
    star->waits = 1;
    if (!prepared->flat_at) return;
    norma_core_mark_flat(prepared, star->position);
    norma_core_mark_flat(prepared, c->next);
    norma_core_mark_flat(prepared, c->previous);
}

/* A flat face's direction is that of its borrowed_from, once lenders are known. */
static void borrow_normal(const core_prepared_mesh *prepared, core_star *star, star_corner *c) {
    core_face borrowed_from;
    if (!prepared->borrowed_from) wait_for_lenders(prepared, star, c);
    if (!prepared->borrowed_from || prepared->borrowed_from[c->face] == UINT32_MAX) return;
    norma_core_prepared_mesh_face(prepared, prepared->borrowed_from[c->face], &borrowed_from);
    memcpy(c->normal, borrowed_from.normal, sizeof c->normal);
    c->flags |= STAR_HAS_NORMAL;
}

/* ---- stars of polygons, which are measured already */

static void load_neighbours(
    const core_prepared_mesh *prepared, const core_face *face, star_corner *c) {
    const core_mesh *mesh = &prepared->mesh;
    c->previous_corner = (uint32_t)norma_core_previous_kept(mesh, c->face, c->corner);
    c->next = norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, c->face, c->corner));
    c->previous = norma_core_welded_corner(mesh, c->previous_corner);
    c->next_key = c->previous_key = face->key;
}

static void load_polygon_corner(
    const core_prepared_mesh *prepared, int with_weights, core_star *star, star_corner *c) {
    const core_face *face = &prepared->faces[c->face];
    if (!(face->flags & CORE_FACE_EDGED) ||
        !norma_core_is_kept(&prepared->mesh, c->face, c->corner))
        return;
    c->flags = STAR_KEPT;
    load_neighbours(prepared, face, c);
    if (face->flags & CORE_FACE_DIRECTED) {
        memcpy(c->normal, face->normal, sizeof c->normal);
        c->flags |= STAR_HAS_NORMAL | STAR_VOTES;
        if (with_weights)
            c->weight = norma_core_corner_weight(
                &prepared->mesh, prepared->call->options.weight, c->face, face, c->corner);
        return;
    }
    if (face->flags & CORE_FACE_FINITE) c->flags |= STAR_FLAT;
    borrow_normal(prepared, star, c);
}

/* ---- stars of triangles, which are measured here, some at a time */

/* Names the neighbours of a triangle's corner, and puts its edges into a lane. Returns whether the
 * face has edges. */
static int load_lane(const core_mesh *mesh, star_corner *c, core_batch *batch, int lane) {
    const uint32_t begin = 3 * c->face, k = c->corner - begin, next = k == 2 ? 0 : k + 1,
                   previous = k == 0 ? 2 : k - 1;
    uint32_t at[3], welded[3];
    double p[3][3];
    for (uint32_t i = 0; i < 3; ++i) {
        at[i] = norma_core_corner(mesh, begin + i);
        welded[i] = norma_core_welded(mesh, at[i]);
        norma_core_position(mesh, at[i], p[i]);
    }
    core_set_edges(batch, lane, (const double(*)[3])p);
    c->next = welded[next];
    c->previous = welded[previous];
    c->previous_corner = begin + previous;
    c->next_key = norma_core_triangle_key(c->previous);
    c->previous_key = norma_core_triangle_key(c->next);
    return welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0];
}

static void count_degenerate(core_star *star, const star_corner *c, const core_face *face) {
    if (c->corner == 3 * c->face && (face->flags & CORE_FACE_FINITE))
        norma_core_count_one(&star->degenerate, c->face);
}

/* What doubles do not decide: a thin face, or one without a direction. */
static void load_unsure(const core_prepared_mesh *prepared, core_star *star, star_corner *c) {
    core_face face;
    norma_core_face_geometry(&prepared->mesh, c->face, &face);
    if (face.flags & CORE_FACE_EDGED) c->flags = STAR_KEPT;
    if (face.flags & CORE_FACE_DIRECTED) {
        memcpy(c->normal, face.normal, sizeof c->normal);
        c->flags |= STAR_HAS_NORMAL | STAR_VOTES;
        c->weight = norma_core_corner_weight(
            &prepared->mesh, prepared->call->options.weight, c->face, &face, c->corner);
        return;
    }
    count_degenerate(star, c, &face);
    if (!(face.flags & CORE_FACE_EDGED)) return;
    if (face.flags & CORE_FACE_FINITE) c->flags |= STAR_FLAT;
    borrow_normal(prepared, star, c);
}

static void load_triangle_corners(const core_prepared_mesh *prepared, int with_weights,
    core_star *star, star_corner *corners, size_t count) {
    core_batch batch;
    int edged[CORE_LANES];
    for (int i = 0; i < CORE_LANES; ++i)
        edged[i] =
            load_lane(&prepared->mesh, &corners[(size_t)i < count ? (size_t)i : 0], &batch, i);
    norma_core_kernels(prepared->call->level)
        ->measure(&batch, with_weights ? prepared->call->options.weight : NORMA_WEIGHT_UNIFORM);
    for (int i = 0; (size_t)i < count; ++i) {
        star_corner *c = &corners[i];
        if (!edged[i] || batch.sure[i] == 0) {
            load_unsure(prepared, star, c);
            continue;
        }
        for (int k = 0; k < 3; ++k) c->normal[k] = batch.normal[k][i];
        c->weight = with_weights ? batch.weight[c->corner % 3][i] : 0;
        c->flags = STAR_KEPT | STAR_HAS_NORMAL | STAR_VOTES;
    }
}

void norma_core_star_begin(const core_prepared_mesh *prepared, uint32_t position, core_star *star) {
    double p[3];
    norma_core_position(&prepared->mesh, position, p);
    star->finite = norma_core_finite(p);
    star->position = position;
    star->count = 0;
    star->edge_count = 0;
    star->waits = 0;
    star->degenerate = (norma_count){0, 0};
}

void norma_core_star_fill(const core_prepared_mesh *prepared, const uint32_t *corners, size_t count,
    int with_weights, core_star *star) {
    star->count = count;
    for (uint32_t i = 0; i < count; ++i) {
        star_corner *c = &star->corners[i];
        c->corner = corners[i];
        c->face = (uint32_t)norma_core_face_of(&prepared->corners_of, c->corner);
        star->joined[i] = i;
        c->flags = 0;
        if (norma_core_kept_faces(prepared)) load_polygon_corner(prepared, with_weights, star, c);
    }
    if (norma_core_kept_faces(prepared)) return;
    for (size_t i = 0; i < count; i += CORE_LANES)
        load_triangle_corners(prepared, with_weights, star, star->corners + i,
            count - i < CORE_LANES ? count - i : CORE_LANES);
}

void norma_core_star_load(
    const core_prepared_mesh *prepared, uint32_t position, int with_weights, core_star *star) {
    const core_corners_of_position *corners_of = &prepared->corners_of;
    const uint32_t begin = corners_of->starts[position];
    norma_core_star_begin(prepared, position, star);
    norma_core_star_fill(prepared, corners_of->corners + begin,
        corners_of->starts[position + 1] - begin, with_weights, star);
}

void norma_core_star_join_all(core_star *star) {
    for (size_t i = 0; i < star->count; ++i) star->joined[i] = 0;
}

void norma_core_star_vote(const star_corner *c, star_sum *sum) {
    if (!(c->flags & STAR_VOTES)) return;
    for (int k = 0; k < 3; ++k) sum->sum[k] += c->weight * c->normal[k];
    sum->weight += c->weight;
    ++sum->votes;
}

void norma_core_decide_sum(const double sum[3], double weight, core_fan *fan) {
    fan->reason = NORMA_REASON_CANCELLED;
    if (norma_core_cancels(sum, weight)) return;
    norma_core_direction(sum, fan->normal);
    fan->reason = NORMA_REASON_NONE;
}

static void decide_cone(core_fan *fan, const double (*normals)[3], size_t count) {
    double axis[3];
    fan->reason = NORMA_REASON_CANCELLED;
    if (!norma_core_smallest_cone(normals, count, axis)) return;
    norma_core_direction(axis, fan->normal);
    fan->reason = NORMA_REASON_NONE;
}

/* Votes lie in the star as they come; those of each fan are brought together by a counting sort,
 * its offsets kept in the place of the sums' weights. */
static void decide_cones(core_star *star) {
    size_t end = 0;
    for (size_t f = 0; f < star->fan_count; ++f) {
        star->sums[f].weight = (double)end;
        end += star->sums[f].votes;
        star->sums[f].votes = 0;
    }
    for (size_t i = 0; i < star->count; ++i) {
        star_sum *sum = &star->sums[star->fan_of[i]];
        if (star->corners[i].flags & STAR_VOTES)
            memcpy(star->normals[(size_t)sum->weight + sum->votes++], star->corners[i].normal,
                sizeof star->normals[0]);
    }
    for (size_t f = 0; f < star->fan_count; ++f) {
        const star_sum *sum = &star->sums[f];
        if (sum->votes)
            decide_cone(&star->fans[f], (const double(*)[3])star->normals + (size_t)sum->weight,
                sum->votes);
    }
}

/* In the order of their first corners. */
static void number_fans(core_star *star) {
    const uint32_t reason = star->finite ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    star->fan_count = 0;
    for (uint32_t i = 0; i < star->count; ++i) {
        const uint32_t first = star->joined[i];
        star->fan_of[i] = first == i ? (uint32_t)star->fan_count : star->fan_of[first];
        if (first != i) continue;
        star->sums[star->fan_count] = (star_sum){.votes = 0};
        star->fans[star->fan_count++] = (core_fan){.reason = reason};
    }
}

void norma_core_star_sum(const core_prepared_mesh *prepared, core_star *star) {
    number_fans(star);
    for (size_t i = 0; i < star->count; ++i)
        norma_core_star_vote(&star->corners[i], &star->sums[star->fan_of[i]]);
    if (!star->finite) return;
    if (norma_core_sees(prepared->call)) {
        decide_cones(star);
        return;
    }
    for (size_t f = 0; f < star->fan_count; ++f)
        if (star->sums[f].votes)
            norma_core_decide_sum(star->sums[f].sum, star->sums[f].weight, &star->fans[f]);
}

void norma_core_star_see_some(
    core_star *star, const uint32_t *members, size_t count, core_fan *fan) {
    size_t votes = 0;
    *fan = (core_fan){.reason = NORMA_REASON_CANCELLED};
    for (size_t i = 0; i < count; ++i)
        if (star->corners[members[i]].flags & STAR_VOTES)
            memcpy(
                star->normals[votes++], star->corners[members[i]].normal, sizeof star->normals[0]);
    if (votes) decide_cone(fan, (const double(*)[3])star->normals, votes);
}

/* ---- insertion for the few of ordinary stars, a heap for the rest. */

_Static_assert(
    sizeof(star_member) <= 2 * sizeof(star_edge), "a star's members lie in the room of its edges");

static int member_less(const void *one, const void *other) {
    const star_member *a = one, *b = other;
    if (a->vertex != b->vertex) return a->vertex < b->vertex;
    for (int k = 0; k < 3; ++k)
        if (a->bits[k] != b->bits[k]) return a->bits[k] < b->bits[k];
    return a->index < b->index;
}

static void swap(star_member *a, star_member *b) {
    const star_member m = *a;
    *a = *b;
    *b = m;
}

static void sort_few_members(star_member *members, size_t count) {
    for (size_t i = 1; i < count; ++i)
        for (size_t at = i; at > 0 && member_less(&members[at], &members[at - 1]); --at)
            swap(&members[at], &members[at - 1]);
}

enum { FEW_MEMBERS = 24 };

void norma_core_sort_corners(star_member *members, size_t count) {
    if (count <= FEW_MEMBERS)
        sort_few_members(members, count);
    else
        norma_core_sort(members, count, sizeof *members, member_less);
}

/* ---- the stages that every call on vertices or corners begins with. */

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
