/* tangent_region.c: the tangents that some moved vertices can change, found without knowing where
 * they were before.
 *
 * A face with a moved vertex changes the tangents of its corners, and the normals of all corners at
 * their positions. Vertices with the same texture coordinates may part or become one; where that
 * can be, so may the edges of the faces there, which changes the tangents of all their corners. A
 * place is all corners of the same texture coordinates, so that places are known to a plan. */
#include "core/tangent/tangent_plan.h"

typedef struct region_search {
    const norma_tangent_plan *plan;
    tangent_region *region;
    uint8_t *seen;    /* of each position that stands for itself */
    uint32_t *places; /* those wanted, in the order found */
    size_t place_count, corners_at_places, most_corners;
} region_search;

static int is_large(const region_search *s) { return s->corners_at_places > s->most_corners; }

static void want(region_search *s, size_t corner) {
    const uint32_t place = norma_core_tangent_place(s->plan, corner);
    const uint32_t *starts = s->plan->at_place.starts;
    if (s->region->wanted[place]) return;
    s->region->wanted[place] = 1;
    s->places[s->place_count++] = place;
    s->corners_at_places += starts[place + 1] - starts[place];
}

static uint32_t position_of(const norma_tangent_plan *plan, uint32_t vertex) {
    return plan->position_weld ? plan->position_weld[vertex] : vertex;
}

static void want_position(region_search *s, uint32_t vertex) {
    const core_corners_of_position *at = &s->plan->at_position;
    const uint32_t position = position_of(s->plan, vertex);
    if (s->seen[position] & 1) return;
    s->seen[position] |= 1;
    for (uint32_t i = at->starts[position]; i < at->starts[position + 1]; i++)
        want(s, at->corners[i]);
}

/* All positions of the faces at a moved one. */
static void want_around(region_search *s, uint32_t vertex) {
    const core_mesh *mesh = &s->plan->mesh;
    const core_corners_of_position *at = &s->plan->at_position;
    const uint32_t position = position_of(s->plan, vertex);
    if (s->seen[position] & 2) return;
    s->seen[position] |= 2;
    for (uint32_t i = at->starts[position]; i < at->starts[position + 1]; i++) {
        const size_t face = norma_core_face_of(at, at->corners[i]);
        for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); c++)
            want_position(s, norma_core_corner(mesh, c));
    }
}

/* Whether the corners there are not all of one vertex whatever moves. */
static int may_part(const norma_tangent_plan *plan, uint32_t place) {
    const core_corners_of_position *at = &plan->at_place;
    const uint32_t begin = at->starts[place], end = at->starts[place + 1];
    if (!plan->by_position) return end - begin > 1;
    for (uint32_t i = begin + 1; i < end; i++)
        if (norma_core_corner(&plan->mesh, at->corners[i]) !=
            norma_core_corner(&plan->mesh, at->corners[begin]))
            return 1;
    return 0;
}

static void want_neighbours(region_search *s) {
    const core_mesh *mesh = &s->plan->mesh;
    const core_corners_of_position *at = &s->plan->at_place;
    const size_t count = s->place_count;
    for (size_t p = 0; p < count && !is_large(s); p++) {
        if (!may_part(s->plan, s->places[p])) continue;
        for (uint32_t i = at->starts[s->places[p]]; i < at->starts[s->places[p] + 1]; i++) {
            const size_t face = norma_core_face_of(at, at->corners[i]);
            for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face);
                 c++)
                want(s, c);
        }
    }
}

static void find_faces(region_search *s) {
    const core_mesh *mesh = &s->plan->mesh;
    const core_corners_of_position *at = &s->plan->at_place;
    tangent_region *r = s->region;
    for (size_t p = 0; p < s->place_count; p++)
        for (uint32_t i = at->starts[s->places[p]]; i < at->starts[s->places[p] + 1]; i++) {
            const size_t face = norma_core_face_of(at, at->corners[i]);
            if (r->near[face]) continue;
            r->near[face] = 1;
            r->face_count++;
            r->corner_count += norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face);
        }
}

static void search(region_search *s, const uint32_t *moved, size_t moved_count) {
    const norma_tangent_plan *plan = s->plan;
    memset(s->seen, 0, plan->mesh.positions.count);
    memset(s->region->wanted, 0, plan->key_count);
    memset(s->region->near, 0, plan->mesh.face_count);
    for (size_t i = 0; i < moved_count && !is_large(s); i++) want_around(s, moved[i]);
    want_neighbours(s);
    if (!is_large(s)) find_faces(s);
    s->region->is_large = is_large(s) || s->region->corner_count > plan->mesh.corner_count / 2;
}

/* A part of the mesh costs more for each corner than the whole, most of all where it is small. */
enum { WORTH_IT = 4 };

norma_result norma_core_tangent_region_open(const core_call *call, const norma_tangent_plan *plan,
    const uint32_t *moved, size_t moved_count, tangent_region *region) {
    const size_t positions = plan->mesh.positions.count;
    *region = (tangent_region){.wanted = norma_core_allocate(call, plan->key_count, 1),
        .near = norma_core_allocate(call, plan->mesh.face_count, 1)};
    region_search s = {.plan = plan,
        .region = region,
        .seen = norma_core_allocate(call, positions, 1),
        .places = norma_core_allocate(call, plan->key_count, sizeof *s.places),
        .most_corners = plan->mesh.corner_count / WORTH_IT};
    const int ready = region->wanted && region->near && s.seen && s.places;
    if (ready) search(&s, moved, moved_count);
    norma_core_release(call, s.seen, positions, 1);
    norma_core_release(call, s.places, plan->key_count, sizeof *s.places);
    if (ready) return NORMA_OK;
    norma_core_tangent_region_close(call, plan, region);
    return NORMA_ERROR_MEMORY;
}

void norma_core_tangent_region_close(
    const core_call *call, const norma_tangent_plan *plan, tangent_region *region) {
    norma_core_release(call, region->wanted, plan->key_count, 1);
    norma_core_release(call, region->near, plan->mesh.face_count, 1);
}
