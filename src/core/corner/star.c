/* star.c: a star of corners loaded, its fans summed, its corners sorted by vertex and normal. */
#include "core/corner/corner.h"
#include "core/face/face.h"
#include "core/call/call.h"

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
