/* vertex_star.c: loading a ring of corners, and summing its fans. */
#include "core/corner/vertex_star.h"
#include "core/mesh/output.h"

void norma_core_ring_in_room(core_ring *ring, ring_room *room) {
    *ring = (core_ring){.corners = room->corners,
        .edges = room->edges,
        .sorted = room->sorted,
        .sums = room->sums,
        .fans = room->fans,
        .fan_of = room->fan_of,
        .normals = room->normals};
}

norma_result norma_core_ring_allocate(const core_call *call, core_ring *ring, size_t corners) {
    *ring = (core_ring){0};
    ring->corners = norma_core_allocate(call, corners, sizeof *ring->corners);
    ring->edges = norma_core_allocate(call, 2 * corners, sizeof *ring->edges);
    ring->sorted = norma_core_allocate(call, 2 * corners, sizeof *ring->sorted);
    ring->sums = norma_core_allocate(call, corners, sizeof *ring->sums);
    ring->fans = norma_core_allocate(call, corners, sizeof *ring->fans);
    ring->fan_of = norma_core_allocate(call, corners, sizeof *ring->fan_of);
    ring->normals = norma_core_allocate(call, corners, sizeof *ring->normals);
    if (ring->corners && ring->edges && ring->sorted && ring->sums && ring->fans && ring->fan_of &&
        ring->normals)
        return NORMA_OK;
    norma_core_ring_release(call, ring, corners);
    return NORMA_ERROR_MEMORY;
}

void norma_core_ring_release(const core_call *call, core_ring *ring, size_t corners) {
    norma_core_release(call, ring->corners, corners, sizeof *ring->corners);
    norma_core_release(call, ring->edges, 2 * corners, sizeof *ring->edges);
    norma_core_release(call, ring->sorted, 2 * corners, sizeof *ring->sorted);
    norma_core_release(call, ring->sums, corners, sizeof *ring->sums);
    norma_core_release(call, ring->fans, corners, sizeof *ring->fans);
    norma_core_release(call, ring->fan_of, corners, sizeof *ring->fan_of);
    norma_core_release(call, ring->normals, corners, sizeof *ring->normals);
    *ring = (core_ring){0};
}

/* A flat face's direction is that of its lender, once lenders are known. */
static void borrow_normal(const core_surface *surface, core_ring *ring, ring_corner *c) {
    core_face lender;
    if (!surface->lender) ring->waits |= c->flags & RING_FLAT;
    if (!surface->lender || surface->lender[c->face] == UINT32_MAX) return;
    norma_core_surface_face(surface, surface->lender[c->face], &lender);
    memcpy(c->normal, lender.normal, sizeof c->normal);
    c->flags |= RING_HAS_NORMAL;
}

/* ---- rings of polygons, which are measured already */

static void load_neighbours(const core_surface *surface, const core_face *face, ring_corner *c) {
    const core_mesh *mesh = &surface->mesh;
    c->previous_corner = (uint32_t)norma_core_previous_kept(mesh, c->face, c->corner);
    c->next = norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, c->face, c->corner));
    c->previous = norma_core_welded_corner(mesh, c->previous_corner);
    c->next_key = face->kept == 3 ? c->previous : face->key;
    c->previous_key = face->kept == 3 ? c->next : face->key;
}

static void load_polygon_corner(
    const core_surface *surface, int with_weights, core_ring *ring, ring_corner *c) {
    const core_face *face = &surface->faces[c->face];
    if (!(face->flags & CORE_FACE_EDGED) || !norma_core_is_kept(&surface->mesh, c->face, c->corner))
        return;
    c->flags = RING_KEPT;
    load_neighbours(surface, face, c);
    if (face->flags & CORE_FACE_DIRECTED) {
        memcpy(c->normal, face->normal, sizeof c->normal);
        c->flags |= RING_HAS_NORMAL | RING_VOTES;
        if (with_weights)
            c->weight = norma_core_corner_weight(
                &surface->mesh, surface->call->options.weight, c->face, face, c->corner);
        return;
    }
    if (face->flags & CORE_FACE_FINITE) c->flags |= RING_FLAT;
    borrow_normal(surface, ring, c);
}

/* ---- rings of triangles, which are measured here, some at a time */

/* Names the neighbours of a triangle's corner, and puts its edges into a lane. Returns whether the
 * face has edges. */
static int load_lane(const core_mesh *mesh, ring_corner *c, core_batch *batch, int lane) {
    const uint32_t begin = 3 * c->face, k = c->corner - begin, next = k == 2 ? 0 : k + 1,
                   previous = k == 0 ? 2 : k - 1;
    uint32_t at[3], welded[3];
    double p[3][3];
    for (uint32_t i = 0; i < 3; i++) {
        at[i] = norma_core_corner(mesh, begin + i);
        welded[i] = norma_core_welded(mesh, at[i]);
        norma_core_position(mesh, at[i], p[i]);
    }
    for (int i = 0; i < 3; i++) {
        batch->u[i][lane] = p[1][i] - p[0][i];
        batch->v[i][lane] = p[2][i] - p[0][i];
        batch->a[i][lane] = p[2][i] - p[1][i];
    }
    c->next = welded[next];
    c->previous = welded[previous];
    c->previous_corner = begin + previous;
    c->next_key = c->previous; /* the third corner is what a triangle has in common with its twin */
    c->previous_key = c->next;
    return welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0];
}

static void count_degenerate(core_ring *ring, const ring_corner *c, const core_face *face) {
    if (c->corner == 3 * c->face && (face->flags & CORE_FACE_FINITE))
        norma_core_count_one(&ring->degenerate, c->face);
}

/* What doubles do not decide: a thin face, or one without a direction. */
static void load_unsure(const core_surface *surface, core_ring *ring, ring_corner *c) {
    core_face face;
    norma_core_face_geometry(&surface->mesh, c->face, &face);
    if (face.flags & CORE_FACE_EDGED) c->flags = RING_KEPT;
    if (face.flags & CORE_FACE_DIRECTED) {
        memcpy(c->normal, face.normal, sizeof c->normal);
        c->flags |= RING_HAS_NORMAL | RING_VOTES;
        c->weight = norma_core_corner_weight(
            &surface->mesh, surface->call->options.weight, c->face, &face, c->corner);
        return;
    }
    count_degenerate(ring, c, &face);
    if (!(face.flags & CORE_FACE_EDGED)) return;
    if (face.flags & CORE_FACE_FINITE) c->flags |= RING_FLAT;
    borrow_normal(surface, ring, c);
}

static void load_triangle_corners(const core_surface *surface, int with_weights, core_ring *ring,
    ring_corner *corners, size_t count) {
    core_batch batch;
    int edged[CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++)
        edged[i] =
            load_lane(&surface->mesh, &corners[(size_t)i < count ? (size_t)i : 0], &batch, i);
    surface->call->measure(
        &batch, surface->call->options.weight, with_weights ? CORE_ALL_CORNERS : CORE_NO_CORNER);
    for (int i = 0; (size_t)i < count; i++) {
        ring_corner *c = &corners[i];
        if (!edged[i] || batch.sure[i] == 0) {
            load_unsure(surface, ring, c);
            continue;
        }
        for (int k = 0; k < 3; k++) c->normal[k] = batch.normal[k][i];
        c->weight = with_weights ? batch.weight[c->corner % 3][i] : 0;
        c->flags = RING_KEPT | RING_HAS_NORMAL | RING_VOTES;
    }
}

void norma_core_ring_begin(const core_surface *surface, uint32_t position, core_ring *ring) {
    double p[3];
    norma_core_position(&surface->mesh, position, p);
    ring->finite = norma_core_finite(p);
    ring->position = position;
    ring->count = 0;
    ring->edge_count = 0;
    ring->waits = 0;
    ring->degenerate = (norma_count){0, 0};
}

void norma_core_ring_fill(const core_surface *surface, const uint32_t *corners, size_t count,
    int with_weights, core_ring *ring) {
    ring->count = count;
    for (uint32_t i = 0; i < count; i++) {
        ring_corner *c = &ring->corners[i];
        c->corner = corners[i];
        c->face = (uint32_t)norma_core_face_of(&surface->around, c->corner);
        c->fan = i;
        c->flags = 0;
        if (surface->faces) load_polygon_corner(surface, with_weights, ring, c);
    }
    if (surface->faces) return;
    for (size_t i = 0; i < count; i += CORE_LANES)
        load_triangle_corners(surface, with_weights, ring, ring->corners + i,
            count - i < CORE_LANES ? count - i : CORE_LANES);
}

void norma_core_ring_load(
    const core_surface *surface, uint32_t position, int with_weights, core_ring *ring) {
    const core_around *around = &surface->around;
    const uint32_t begin = around->starts[position];
    norma_core_ring_begin(surface, position, ring);
    norma_core_ring_fill(
        surface, around->corners + begin, around->starts[position + 1] - begin, with_weights, ring);
}

void norma_core_ring_join_all(core_ring *ring) {
    for (size_t i = 0; i < ring->count; i++) ring->corners[i].fan = 0;
}

void norma_core_ring_vote(const ring_corner *c, ring_sum *sum) {
    if (!(c->flags & RING_VOTES)) return;
    for (int k = 0; k < 3; k++) sum->sum[k] += c->weight * c->normal[k];
    sum->weight += c->weight;
    sum->votes++;
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

/* Votes lie in the ring as they come; those of each fan are brought together by a counting sort,
 * its offsets kept in the place of the sums' weights. */
static void decide_cones(core_ring *ring) {
    size_t end = 0;
    for (size_t f = 0; f < ring->fan_count; f++) {
        ring->sums[f].weight = (double)end;
        end += ring->sums[f].votes;
        ring->sums[f].votes = 0;
    }
    for (size_t i = 0; i < ring->count; i++) {
        ring_sum *sum = &ring->sums[ring->fan_of[i]];
        if (ring->corners[i].flags & RING_VOTES)
            memcpy(ring->normals[(size_t)sum->weight + sum->votes++], ring->corners[i].normal,
                sizeof ring->normals[0]);
    }
    for (size_t f = 0; f < ring->fan_count; f++) {
        const ring_sum *sum = &ring->sums[f];
        if (sum->votes)
            decide_cone(&ring->fans[f], (const double(*)[3])ring->normals + (size_t)sum->weight,
                sum->votes);
    }
}

/* In the order of their first corners. */
static void number_fans(core_ring *ring) {
    const uint32_t reason = ring->finite ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    ring->fan_count = 0;
    for (uint32_t i = 0; i < ring->count; i++) {
        const uint32_t first = ring->corners[i].fan;
        ring->fan_of[i] = first == i ? (uint32_t)ring->fan_count : ring->fan_of[first];
        if (first != i) continue;
        ring->sums[ring->fan_count] = (ring_sum){.votes = 0};
        ring->fans[ring->fan_count++] = (core_fan){.reason = reason};
    }
}

void norma_core_ring_sum(const core_surface *surface, core_ring *ring) {
    number_fans(ring);
    for (size_t i = 0; i < ring->count; i++)
        norma_core_ring_vote(&ring->corners[i], &ring->sums[ring->fan_of[i]]);
    if (!ring->finite) return;
    if (surface->call->options.weight == NORMA_WEIGHT_VISIBLE) {
        decide_cones(ring);
        return;
    }
    for (size_t f = 0; f < ring->fan_count; f++)
        if (ring->sums[f].votes)
            norma_core_decide_sum(ring->sums[f].sum, ring->sums[f].weight, &ring->fans[f]);
}

void norma_core_ring_see_some(
    core_ring *ring, const uint32_t *members, size_t count, core_fan *fan) {
    size_t votes = 0;
    *fan = (core_fan){.reason = NORMA_REASON_CANCELLED};
    for (size_t i = 0; i < count; i++)
        if (ring->corners[members[i]].flags & RING_VOTES)
            memcpy(
                ring->normals[votes++], ring->corners[members[i]].normal, sizeof ring->normals[0]);
    if (votes) decide_cone(fan, (const double(*)[3])ring->normals, votes);
}
