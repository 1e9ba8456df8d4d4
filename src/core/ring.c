/* ring.c: loading a ring of corners, and summing its fans. */
#include "ring.h"
#include "output.h"

void norma_core_ring_in_room(core_ring *ring, ring_room *room)
{
    *ring = (core_ring){.corners = room->corners, .edges = room->edges, .sorted = room->sorted, .fans = room->fans, .normals = room->normals};
}

norma_result norma_core_ring_allocate(const core_call *call, core_ring *ring, size_t corners)
{
    *ring = (core_ring){0};
    ring->corners = norma_core_allocate(call, corners, sizeof *ring->corners);
    ring->edges = norma_core_allocate(call, 2 * corners, sizeof *ring->edges);
    ring->sorted = norma_core_allocate(call, 2 * corners, sizeof *ring->sorted);
    ring->fans = norma_core_allocate(call, corners, sizeof *ring->fans);
    ring->normals = norma_core_allocate(call, corners, sizeof *ring->normals);
    if (ring->corners && ring->edges && ring->sorted && ring->fans && ring->normals) return NORMA_OK;
    norma_core_ring_release(call, ring, corners);
    return NORMA_ERROR_MEMORY;
}

void norma_core_ring_release(const core_call *call, core_ring *ring, size_t corners)
{
    norma_core_release(call, ring->corners, corners, sizeof *ring->corners);
    norma_core_release(call, ring->edges, 2 * corners, sizeof *ring->edges);
    norma_core_release(call, ring->sorted, 2 * corners, sizeof *ring->sorted);
    norma_core_release(call, ring->fans, corners, sizeof *ring->fans);
    norma_core_release(call, ring->normals, corners, sizeof *ring->normals);
    *ring = (core_ring){0};
}

static void borrow_normal(const core_surface *surface, ring_corner *c)
{
    core_face lender;
    if (!surface->lender || surface->lender[c->face] == UINT32_MAX) return;
    norma_core_surface_face(surface, surface->lender[c->face], &lender);
    memcpy(c->normal, lender.normal, sizeof c->normal);
    c->flags |= RING_HAS_NORMAL;
}

/* ---- rings of polygons, which are measured already */

static void load_neighbours(const core_surface *surface, const core_face *face, ring_corner *c)
{
    const core_mesh *mesh = &surface->mesh;
    c->previous_corner = (uint32_t)norma_core_previous_kept(mesh, c->face, c->corner);
    c->next = norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, c->face, c->corner));
    c->previous = norma_core_welded_corner(mesh, c->previous_corner);
    c->next_key = face->kept == 3 ? c->previous : face->key;
    c->previous_key = face->kept == 3 ? c->next : face->key;
}

static void load_polygon_corner(const core_surface *surface, int with_weights, ring_corner *c)
{
    const core_face *face = &surface->faces[c->face];
    if (!(face->flags & CORE_FACE_EDGED) || !norma_core_is_kept(&surface->mesh, c->face, c->corner)) return;
    c->flags = RING_KEPT;
    load_neighbours(surface, face, c);
    if (face->flags & CORE_FACE_DIRECTED) {
        memcpy(c->normal, face->normal, sizeof c->normal);
        c->flags |= RING_HAS_NORMAL | RING_VOTES;
        if (with_weights) c->weight = norma_core_corner_weight(&surface->mesh, surface->call->options.weight, c->face, face, c->corner);
        return;
    }
    if (face->flags & CORE_FACE_FINITE) c->flags |= RING_FLAT;
    borrow_normal(surface, c);
}

/* ---- rings of triangles, which are measured here, some at a time */

/* Names the neighbours of a triangle's corner, and puts its edges into a lane. Returns whether the face has edges. */
static int load_lane(const core_mesh *mesh, ring_corner *c, core_batch *batch, int lane)
{
    const uint32_t begin = 3 * c->face, k = c->corner - begin, next = k == 2 ? 0 : k + 1, previous = k == 0 ? 2 : k - 1;
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
        batch->a[i][lane] = p[next][i] - p[k][i];
        batch->b[i][lane] = p[previous][i] - p[k][i];
    }
    c->next = welded[next];
    c->previous = welded[previous];
    c->previous_corner = begin + previous;
    c->next_key = c->previous;             /* the third corner is what a triangle has in common with its twin */
    c->previous_key = c->next;
    return welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0];
}

/* What doubles do not decide: a thin face, or one without a direction. */
static void load_unsure(const core_surface *surface, ring_corner *c)
{
    core_face face;
    norma_core_face_geometry(&surface->mesh, c->face, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) {
        if (face.flags & CORE_FACE_FINITE) c->flags |= RING_FLAT;
        borrow_normal(surface, c);
        return;
    }
    memcpy(c->normal, face.normal, sizeof c->normal);
    c->flags |= RING_HAS_NORMAL | RING_VOTES;
    c->weight = norma_core_corner_weight(&surface->mesh, surface->call->options.weight, c->face, &face, c->corner);
}

static void load_triangle_corners(const core_surface *surface, int with_weights, ring_corner *corners, size_t count)
{
    core_batch batch;
    int edged[CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++) edged[i] = load_lane(&surface->mesh, &corners[(size_t)i < count ? (size_t)i : 0], &batch, i);
    surface->call->measure(&batch, surface->call->options.weight, with_weights ? CORE_ONE_CORNER : CORE_NO_CORNER);
    for (int i = 0; (size_t)i < count; i++) {
        ring_corner *c = &corners[i];
        if (!edged[i]) continue;
        c->flags = RING_KEPT;
        if (batch.sure[i] == 0) {
            load_unsure(surface, c);
            continue;
        }
        for (int k = 0; k < 3; k++) c->normal[k] = batch.normal[k][i];
        c->weight = with_weights ? batch.weight[0][i] : 0;
        c->flags |= RING_HAS_NORMAL | RING_VOTES;
    }
}

void norma_core_ring_load(const core_surface *surface, uint32_t position, int with_weights, core_ring *ring)
{
    const core_around *around = &surface->around;
    const uint32_t begin = around->starts[position], end = around->starts[position + 1];
    double p[3];
    norma_core_position(&surface->mesh, position, p);
    ring->finite = norma_core_finite(p);
    ring->position = position;
    ring->count = end - begin;
    ring->edge_count = 0;
    for (uint32_t i = 0; i < ring->count; i++) {
        ring_corner *c = &ring->corners[i];
        c->corner = around->corners[begin + i];
        c->face = (uint32_t)norma_core_face_of(around, c->corner);
        c->fan = i;
        c->flags = 0;
        if (surface->faces) load_polygon_corner(surface, with_weights, c);
    }
    if (surface->faces) return;
    for (size_t i = 0; i < ring->count; i += CORE_LANES)
        load_triangle_corners(surface, with_weights, ring->corners + i, ring->count - i < CORE_LANES ? ring->count - i : CORE_LANES);
}

void norma_core_ring_join_all(core_ring *ring)
{
    for (size_t i = 0; i < ring->count; i++) ring->corners[i].fan = 0;
}

static void clear_fan(ring_fan *fan) { *fan = (ring_fan){.reason = NORMA_REASON_UNREFERENCED}; }

static void add_vote(ring_fan *fan, const ring_corner *c)
{
    for (int k = 0; k < 3; k++) fan->sum[k] += c->weight * c->normal[k];
    fan->weight += c->weight;
    fan->votes++;
}

static void set_normal(ring_fan *fan, const double direction[3])
{
    norma_core_direction(direction, fan->normal);
    fan->reason = NORMA_REASON_NONE;
}

static void decide_sum(ring_fan *fan)
{
    if (norma_core_cancels(fan->sum, fan->weight)) fan->reason = NORMA_REASON_CANCELLED;
    else set_normal(fan, fan->sum);
}

static void decide_cone(ring_fan *fan, const double (*normals)[3], size_t count)
{
    double axis[3];
    if (norma_core_smallest_cone(normals, count, axis)) set_normal(fan, axis);
    else fan->reason = NORMA_REASON_CANCELLED;
}

/* Fans lie in the ring as they come; the votes of each are brought together by a counting sort, its offsets kept in the fans' own weights' place. */
static void decide_cones(core_ring *ring)
{
    size_t end = 0;
    for (size_t i = 0; i < ring->count; i++) {
        ring_fan *fan = &ring->fans[i];
        if (ring->corners[i].fan != i) continue;
        fan->weight = (double)end;
        end += fan->votes;
        fan->votes = 0;
    }
    for (size_t i = 0; i < ring->count; i++) {
        ring_fan *fan = &ring->fans[ring->corners[i].fan];
        if (ring->corners[i].flags & RING_VOTES) memcpy(ring->normals[(size_t)fan->weight + fan->votes++], ring->corners[i].normal, sizeof ring->normals[0]);
    }
    for (size_t i = 0; i < ring->count; i++)
        if (ring->corners[i].fan == i && ring->fans[i].votes) decide_cone(&ring->fans[i], (const double(*)[3])ring->normals + (size_t)ring->fans[i].weight, ring->fans[i].votes);
}

void norma_core_ring_sum(const core_surface *surface, core_ring *ring)
{
    for (size_t i = 0; i < ring->count; i++) clear_fan(&ring->fans[i]);
    for (size_t i = 0; i < ring->count; i++)
        if (ring->corners[i].flags & RING_VOTES) add_vote(&ring->fans[ring->corners[i].fan], &ring->corners[i]);
    if (!ring->finite) {
        for (size_t i = 0; i < ring->count; i++) ring->fans[i].reason = NORMA_REASON_NON_FINITE;
    } else if (surface->call->options.weight == NORMA_WEIGHT_VISIBLE) {
        decide_cones(ring);
    } else {
        for (size_t i = 0; i < ring->count; i++)
            if (ring->fans[i].votes) decide_sum(&ring->fans[i]);
    }
}

void norma_core_ring_see_some(core_ring *ring, const uint32_t *members, size_t count, ring_fan *fan)
{
    size_t votes = 0;
    clear_fan(fan);
    fan->reason = NORMA_REASON_CANCELLED;
    for (size_t i = 0; i < count; i++)
        if (ring->corners[members[i]].flags & RING_VOTES) memcpy(ring->normals[votes++], ring->corners[members[i]].normal, sizeof ring->normals[0]);
    if (votes) decide_cone(fan, (const double(*)[3])ring->normals, votes);
}
