/* tangent_plan.c: tangents of meshes that move. */
#include "core/tangent/tangents.h"

/* ---- What of a mesh that moves stays: topology and texture coordinates, and so which corners a
 * vertex that moves may change. An update of all corners uses none of it: to know their groups
 * saved 12 % on models of games. */

typedef struct tangent_store {
    void *memory;
    size_t count, size;
} tangent_store;

enum { TANGENT_PLAN_STORES = 12 };

struct norma_tangent_plan {
    core_call memory; /* of the creation's allocator, and of nothing else */
    norma_tangent_mode mode;
    core_mesh mesh; /* with corners of its own, and without positions */
    int by_position;
    size_t key_count, most_corners; /* most_corners: of a face */
    float (*texcoords)[2];          /* of each key */
    uint32_t *place;         /* NULL, or of each key the least with its texture coordinates */
    uint32_t *position_weld; /* NULL, or of each position the least that is equal to it */
    core_corners_of_position at_place, at_position;
    tangent_store stores[TANGENT_PLAN_STORES];
    size_t store_count, bytes;
};

static inline uint32_t tangent_place(const norma_tangent_plan *plan, size_t corner) {
    const uint32_t key =
        plan->by_position ? norma_core_corner(&plan->mesh, corner) : (uint32_t)corner;
    return plan->place ? plan->place[key] : key;
}

/* ---- What a tangent plan keeps, from the allocator of its creation. */

static void core_tangent_adopt(norma_tangent_plan *plan, void *memory, size_t count, size_t size) {
    if (!memory) return;
    plan->stores[plan->store_count++] = (tangent_store){memory, count, size};
    plan->bytes += count * size;
}

/* Memory that lives as long as the plan; adopt: that its allocator gave out
 * before, or NULL. */
static void *core_tangent_keep(norma_tangent_plan *plan, size_t count, size_t size) {
    void *memory = norma_core_allocate(&plan->memory, count, size);
    core_tangent_adopt(plan, memory, count, size);
    return memory;
}

/* ---- The tangents that some moved vertices can change, found without knowing where
 * they were before.
 *
 * A face with a moved vertex changes the tangents of its corners, and the normals of all corners at
 * their positions. Vertices with the same texture coordinates may part or become one; where that
 * can be, so may the edges of the faces there, which changes the tangents of all their corners. A
 * place is all corners of the same texture coordinates, so that places are known to a plan. */

/* The faces that some moved vertices have to do with. */
typedef struct tangent_region {
    uint8_t *wanted; /* of each key that stands for a place: its tangents may change */
    uint8_t *near;   /* of each face: it has a corner at such a place */
    size_t face_count, corner_count; /* of faces that are near */
    int is_large;                    /* nothing is won by looking at it alone */
} tangent_region;

typedef struct region_search {
    const norma_tangent_plan *plan;
    tangent_region *region;
    uint8_t *seen;    /* of each position that stands for itself */
    uint32_t *places; /* those wanted, in the order found */
    size_t place_count, corners_at_places, most_corners;
} region_search;

static int is_large(const region_search *s) { return s->corners_at_places > s->most_corners; }

static void want(region_search *s, size_t corner) {
    const uint32_t place = tangent_place(s->plan, corner);
    const uint32_t *starts = s->plan->at_place.starts;
    if (s->region->wanted[place]) return;
    s->region->wanted[place] = 1;
    s->places[s->place_count++] = place;
    s->corners_at_places += starts[place + 1] - starts[place];
}

static uint32_t position_of_corner(const norma_tangent_plan *plan, uint32_t vertex) {
    return plan->position_weld ? plan->position_weld[vertex] : vertex;
}

static void want_position(region_search *s, uint32_t vertex) {
    const core_corners_of_position *at = &s->plan->at_position;
    const uint32_t position = position_of_corner(s->plan, vertex);
    if (s->seen[position] & 1) return;
    s->seen[position] |= 1;
    for (uint32_t i = at->starts[position]; i < at->starts[position + 1]; ++i)
        want(s, at->corners[i]);
}

/* All positions of the faces at a moved one. */
static void want_around(region_search *s, uint32_t vertex) {
    const core_mesh *mesh = &s->plan->mesh;
    const core_corners_of_position *at = &s->plan->at_position;
    const uint32_t position = position_of_corner(s->plan, vertex);
    if (s->seen[position] & 2) return;
    s->seen[position] |= 2;
    for (uint32_t i = at->starts[position]; i < at->starts[position + 1]; ++i) {
        const size_t face = norma_core_face_of(at, at->corners[i]);
        for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); ++c)
            want_position(s, norma_core_corner(mesh, c));
    }
}

/* Whether the corners there are not all of one vertex whatever moves. */
static int may_part(const norma_tangent_plan *plan, uint32_t place) {
    const core_corners_of_position *at = &plan->at_place;
    const uint32_t begin = at->starts[place], end = at->starts[place + 1];
    if (!plan->by_position) return end - begin > 1;
    for (uint32_t i = begin + 1; i < end; ++i)
        if (norma_core_corner(&plan->mesh, at->corners[i]) !=
            norma_core_corner(&plan->mesh, at->corners[begin]))
            return 1;
    return 0;
}

static void want_neighbours(region_search *s) {
    const core_mesh *mesh = &s->plan->mesh;
    const core_corners_of_position *at = &s->plan->at_place;
    const size_t count = s->place_count;
    for (size_t p = 0; p < count && !is_large(s); ++p) {
        if (!may_part(s->plan, s->places[p])) continue;
        for (uint32_t i = at->starts[s->places[p]]; i < at->starts[s->places[p] + 1]; ++i) {
            const size_t face = norma_core_face_of(at, at->corners[i]);
            for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face);
                 ++c)
                want(s, c);
        }
    }
}

static void find_faces(region_search *s) {
    const core_mesh *mesh = &s->plan->mesh;
    const core_corners_of_position *at = &s->plan->at_place;
    tangent_region *r = s->region;
    for (size_t p = 0; p < s->place_count; ++p)
        for (uint32_t i = at->starts[s->places[p]]; i < at->starts[s->places[p] + 1]; ++i) {
            const size_t face = norma_core_face_of(at, at->corners[i]);
            if (r->near[face]) continue;
            r->near[face] = 1;
            ++r->face_count;
            r->corner_count += norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face);
        }
}

static void search_region(region_search *s, const uint32_t *moved, size_t moved_count) {
    const norma_tangent_plan *plan = s->plan;
    memset(s->seen, 0, plan->mesh.positions.count);
    memset(s->region->wanted, 0, plan->key_count);
    memset(s->region->near, 0, plan->mesh.face_count);
    for (size_t i = 0; i < moved_count && !is_large(s); ++i) want_around(s, moved[i]);
    want_neighbours(s);
    if (!is_large(s)) find_faces(s);
    s->region->is_large = is_large(s) || s->region->corner_count > plan->mesh.corner_count / 2;
}

/* A part of the mesh costs more for each corner than the whole, most of all where it is small. */
enum { WORTH_IT = 4 };

static void core_tangent_region_close(
    const core_call *call, const norma_tangent_plan *plan, tangent_region *region) {
    norma_core_release(call, region->wanted, plan->key_count, 1);
    norma_core_release(call, region->near, plan->mesh.face_count, 1);
}

static norma_result core_tangent_region_open(const core_call *call, const norma_tangent_plan *plan,
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
    if (ready) search_region(&s, moved, moved_count);
    norma_core_release(call, s.seen, positions, 1);
    norma_core_release(call, s.places, plan->key_count, sizeof *s.places);
    if (ready) return NORMA_OK;
    core_tangent_region_close(call, plan, region);
    return NORMA_ERROR_MEMORY;
}

/* ---- The faces of a region as a mesh of their own, whose tangents are computed as
 * those of any mesh. Of the places that are wanted it has all faces, so that the tangents there
 * are those of the whole mesh. */

typedef struct tangent_part {
    const norma_tangent_plan *plan;
    const tangent_mesh *whole;
    tangent_mesh mesh;
    size_t face_count, corner_count;
    uint32_t *corners;     /* of the whole mesh */
    uint32_t *face_starts; /* NULL: triangles */
    uint32_t *keys;        /* of each corner */
    uint64_t *by_key;      /* keys of the whole mesh and corners, ascending */
    float (*tangents)[4];
    uint8_t *reasons;
} tangent_part;

static void list_part_corners(tangent_part *p, const tangent_region *region) {
    const core_mesh *mesh = &p->plan->mesh;
    uint32_t corner = 0;
    for (size_t f = 0, number = 0; number < p->face_count; ++f) {
        if (!region->near[f]) continue;
        if (p->face_starts) p->face_starts[number] = corner;
        ++number;
        for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c)
            p->corners[corner++] = (uint32_t)c;
    }
    if (p->face_starts) p->face_starts[p->face_count] = corner;
}

/* Keys get numbers of their own; one vertex stays one, even if it is not a number. */
static int read_keys(tangent_part *p) {
    uint32_t number = 0;
    for (size_t i = 0; i < p->corner_count; ++i)
        p->by_key[i] =
            (uint64_t)norma_core_tangent_key(p->whole, p->corners[i]) << 32 | (uint32_t)i;
    norma_core_sort_numbers(p->by_key, p->corner_count);
    for (size_t i = 0; i < p->corner_count; ++i) {
        const uint32_t key = (uint32_t)(p->by_key[i] >> 32);
        if (i && key != p->by_key[i - 1] >> 32) ++number;
        p->keys[(uint32_t)p->by_key[i]] = number;
        if ((!i || key != p->by_key[i - 1] >> 32) &&
            !norma_core_tangent_read_key(p->whole, key, &p->mesh.vertices[number],
                p->mesh.exact ? p->mesh.exact[number] : NULL))
            return 0;
    }
    p->mesh.key_count = p->mesh.mesh.positions.count = p->corner_count ? number + 1 : 0;
    return 1;
}

static norma_result compute_region_part(tangent_part *p) {
    const tangent_output output = {(unsigned char *)p->tangents, sizeof *p->tangents, p->reasons};
    core_tally tally = {0};
    tangent_mesh *m = &p->mesh;
    m->call = p->whole->call;
    m->by_position = 1;
    m->mesh = (core_mesh){.corners = p->keys,
        .corner_count = p->corner_count,
        .corner_size = 4,
        .face_starts = p->face_starts,
        .face_count = p->face_count};
    if (!read_keys(p)) return NORMA_ERROR_INDEX;
    const norma_result result = norma_core_tangent_weld(m);
    if (result) return result;
    return p->plan->mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents(m, &output, &tally)
                                                : norma_core_steady_tangents(m, &output, &tally);
}

static void write_wanted(const tangent_part *p, const tangent_region *region,
    const tangent_output *output, core_tally *tally) {
    for (size_t i = 0; i < p->corner_count; ++i) {
        const uint32_t corner = p->corners[i];
        written_tangent out = {.reason = p->reasons[i]};
        if (!region->wanted[tangent_place(p->plan, corner)]) continue;
        memcpy(out.numbers, p->tangents[i], sizeof out.numbers);
        norma_core_put_tangent(output, corner, &out, tally);
    }
}

static int open_tangent_part(tangent_part *p, const core_call *call) {
    const size_t count = p->corner_count;
    p->corners = norma_core_allocate(call, count, sizeof *p->corners);
    p->keys = norma_core_allocate(call, count, sizeof *p->keys);
    p->by_key = norma_core_allocate(call, count, sizeof *p->by_key);
    p->mesh.vertices = norma_core_allocate(call, count, sizeof *p->mesh.vertices);
    if (p->whole->in_doubles)
        p->mesh.exact = norma_core_allocate(call, count, sizeof *p->mesh.exact);
    p->tangents = norma_core_allocate(call, count, sizeof *p->tangents);
    p->reasons = norma_core_allocate(call, count, 1);
    if (p->plan->mesh.face_starts)
        p->face_starts = norma_core_allocate(call, p->face_count + 1, sizeof *p->face_starts);
    return p->corners && p->keys && p->by_key && p->mesh.vertices && p->tangents && p->reasons &&
           (p->face_starts || !p->plan->mesh.face_starts) &&
           (p->mesh.exact || !p->whole->in_doubles);
}

static void close_tangent_part(tangent_part *p, const core_call *call) {
    const size_t count = p->corner_count;
    norma_core_release(call, p->mesh.weld, p->mesh.key_count, sizeof *p->mesh.weld);
    norma_core_release(call, p->corners, count, sizeof *p->corners);
    norma_core_release(call, p->keys, count, sizeof *p->keys);
    norma_core_release(call, p->by_key, count, sizeof *p->by_key);
    norma_core_release(call, p->mesh.vertices, count, sizeof *p->mesh.vertices);
    norma_core_release(call, p->mesh.exact, count, sizeof *p->mesh.exact);
    norma_core_release(call, p->tangents, count, sizeof *p->tangents);
    norma_core_release(call, p->reasons, count, 1);
    norma_core_release(call, p->face_starts, p->face_count + 1, sizeof *p->face_starts);
}

/* *is_awkward: the whole mesh has to be computed; nothing has been written. */
static norma_result core_tangent_update_part(const norma_tangent_plan *plan,
    const tangent_mesh *whole, const tangent_region *region, const tangent_output *output,
    core_tally *tally, int *is_awkward) {
    tangent_part p = {.plan = plan,
        .whole = whole,
        .mesh = {.is_awkward = is_awkward},
        .face_count = region->face_count,
        .corner_count = region->corner_count};
    norma_result result = NORMA_ERROR_MEMORY;
    *is_awkward = 0;
    if (!region->corner_count) return NORMA_OK;
    if (open_tangent_part(&p, whole->call)) {
        list_part_corners(&p, region);
        result = compute_region_part(&p);
    }
    if (!result && !*is_awkward) write_wanted(&p, region, output, tally);
    close_tangent_part(&p, whole->call);
    return result;
}

/* ---- norma_tangent_plan_update */

static norma_result compute_plan_tangents(const norma_tangent_plan *plan, const tangent_mesh *m,
    const tangent_output *output, core_tally *tally) {
    return plan->mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents(m, output, tally)
                                             : norma_core_steady_tangents(m, output, tally);
}

static norma_result update_all(const norma_tangent_plan *plan, tangent_mesh *m,
    const tangent_output *output, core_tally *tally) {
    norma_core_stage(m->call, 0, 0.3);
    norma_result result = norma_core_tangent_open(m);
    if (result) return result;
    norma_core_stage(m->call, 0.3, 0.97);
    result = compute_plan_tangents(plan, m, output, tally);
    norma_core_tangent_close(m);
    return result;
}

/* How far a polygon is cut well hangs on all polygons: their time is limited together. */
static int hangs_together(const norma_tangent_plan *plan) {
    return plan->mode == NORMA_TANGENTS_MIKK && plan->most_corners > 4;
}

static norma_result update_region(const norma_tangent_plan *plan, tangent_mesh *m,
    const uint32_t *moved, size_t moved_count, const tangent_output *output, core_tally *tally) {
    tangent_region region;
    int all = 1;
    if (hangs_together(plan)) return update_all(plan, m, output, tally);
    norma_result result = core_tangent_region_open(m->call, plan, moved, moved_count, &region);
    if (result) return result;
    if (!region.is_large) result = core_tangent_update_part(plan, m, &region, output, tally, &all);
    core_tangent_region_close(m->call, plan, &region);
    return !result && all ? update_all(plan, m, output, tally) : result;
}

/* Also of the corners that an update of some vertices does not read. */
static norma_result check_moved_indices(const norma_tangent_plan *plan,
    const norma_attribute *normals, const uint32_t *moved, size_t moved_count) {
    for (size_t i = 0; i < moved_count; ++i)
        if (moved[i] >= plan->mesh.positions.count) return NORMA_ERROR_INDEX;
    for (size_t c = 0; c < plan->mesh.corner_count && normals->corners; ++c)
        if (normals->corners[c] >= normals->count) return NORMA_ERROR_INDEX;
    return NORMA_OK;
}

/* The plan's mesh at new positions. */
static norma_result open_mesh(const norma_tangent_plan *plan, norma_vec3_view positions,
    const norma_attribute *normals, const norma_attribute *texcoords, tangent_mesh *m) {
    const norma_mesh points = {.positions = positions};
    norma_result result = norma_core_mesh_shape(&points, &m->mesh);
    if (!result && positions.count != plan->mesh.positions.count) result = NORMA_ERROR_ARGUMENT;
    if (result) return result;
    const norma_vec3_view view = m->mesh.positions;
    m->mesh = plan->mesh;
    m->mesh.positions = view;
    m->by_position = plan->by_position;
    m->key_count = plan->key_count;
    result = norma_core_tangent_attributes(m, plan->mode, normals, texcoords);
    if (!result && plan->by_position && (normals->of != NORMA_PER_VERTEX || normals->corners))
        result = NORMA_ERROR_ARGUMENT;
    return result;
}

norma_result norma_tangent_plan_update(const norma_tangent_plan *plan, norma_vec3_view positions,
    const norma_attribute *normals, const uint32_t *moved, size_t moved_count,
    const norma_options *options, float *tangents, size_t capacity, norma_report *report) {
    core_call call;
    core_tally tally = {0};
    tangent_mesh m = {.call = &call};
    tangent_output output;
    if (!plan) return NORMA_ERROR_ARGUMENT;
    const size_t corners = plan->mesh.corner_count;
    const norma_attribute texcoords = {.data = plan->texcoords,
        .count = plan->key_count,
        .of = plan->by_position ? NORMA_PER_VERTEX : NORMA_PER_CORNER};
    norma_result result = norma_core_begin(&call, options);
    if (!result) norma_core_share(&call, corners);
    if (!result) result = open_mesh(plan, positions, normals, &texcoords, &m);
    if (!result)
        result = norma_core_tangent_output_open(options, tangents, corners, capacity, &output);
    if (!result && moved) result = check_moved_indices(plan, normals, moved, moved_count);
    if (!result && corners)
        result = moved ? update_region(plan, &m, moved, moved_count, &output, &tally)
                       : update_all(plan, &m, &output, &tally);
    result = norma_core_finish(&call, result);
    if (!result) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}

/* ---- norma_tangent_plan_create, _bytes, _destroy */

static size_t sorted_bytes(const core_corners_of_position *sorted) {
    return sorted->starts ? (sorted->position_count + 1) * sizeof *sorted->starts +
                                sorted->corner_count * sizeof *sorted->corners +
                                (sorted->faces ? sorted->corner_count * sizeof *sorted->faces : 0)
                          : 0;
}

size_t norma_tangent_plan_bytes(const norma_tangent_plan *plan) {
    if (!plan) return 0;
    return plan->bytes + sorted_bytes(&plan->at_place) + sorted_bytes(&plan->at_position);
}

static void release_sorted(const core_call *call, core_corners_of_position *sorted) {
    if (sorted->starts) norma_core_corners_of_position_release(call, sorted);
}

void norma_tangent_plan_destroy(norma_tangent_plan *plan) {
    if (!plan) return;
    core_call memory = plan->memory;
    release_sorted(&memory, &plan->at_place);
    release_sorted(&memory, &plan->at_position);
    for (size_t i = 0; i < plan->store_count; ++i)
        norma_core_release(
            &memory, plan->stores[i].memory, plan->stores[i].count, plan->stores[i].size);
    norma_core_release(&memory, plan, 1, sizeof *plan);
}

/* ---- creation, step by step */

static norma_result keep_topology(norma_tangent_plan *plan, const tangent_mesh *m) {
    const core_mesh *mesh = &m->mesh;
    plan->mesh = *mesh;
    plan->mesh.positions.data = NULL;
    plan->mesh.smoothing_groups = NULL;
    plan->mesh.hard_edges = NULL;
    if (mesh->corner_size) {
        uint32_t *corners = core_tangent_keep(plan, mesh->corner_count, sizeof *corners);
        if (!corners) return NORMA_ERROR_MEMORY;
        norma_core_read_corners(mesh, 0, mesh->corner_count, corners);
        plan->mesh.corners = corners;
        plan->mesh.corner_size = sizeof *corners;
    }
    for (size_t f = 0; f < mesh->face_count; ++f) {
        const size_t count = norma_core_face_end(mesh, f) - norma_core_face_begin(mesh, f);
        if (count > plan->most_corners) plan->most_corners = count;
    }
    if (!mesh->face_starts) return NORMA_OK;
    uint32_t *starts = core_tangent_keep(plan, mesh->face_count + 1, sizeof *starts);
    if (!starts) return NORMA_ERROR_MEMORY;
    memcpy(starts, mesh->face_starts, (mesh->face_count + 1) * sizeof *starts);
    plan->mesh.face_starts = starts;
    return NORMA_OK;
}

/* Also which keys have the same ones: vertices that differ in nothing else. */
static norma_result keep_plan_texcoords(norma_tangent_plan *plan, const tangent_mesh *m) {
    const size_t count = m->key_count;
    size_t found = 0;
    plan->texcoords = core_tangent_keep(plan, count, sizeof *plan->texcoords);
    tangent_vertex *places = norma_core_allocate(m->call, count, sizeof *places);
    uint32_t *place = norma_core_allocate(m->call, count, sizeof *place);
    norma_result result = plan->texcoords && places && place ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t key = 0; !result && key < count; ++key) {
        places[key] = (tangent_vertex){.position = {0}};
        memcpy(places[key].texcoord, m->vertices[key].texcoord, sizeof places->texcoord);
        memcpy(plan->texcoords[key], m->vertices[key].texcoord, sizeof *plan->texcoords);
    }
    if (!result)
        result = norma_core_tangent_weld_vertices(m->call, places, NULL, count, place, &found);
    norma_core_release(m->call, places, count, sizeof *places);
    if (!result && found)
        core_tangent_adopt(plan, plan->place = place, count, sizeof *place);
    else
        norma_core_release(m->call, place, count, sizeof *place);
    return result;
}

static norma_result keep_positions(norma_tangent_plan *plan, const tangent_mesh *m) {
    core_mesh positions = m->mesh;
    m->call->options.weld = NORMA_WELD_EXACT;
    const norma_result result = norma_core_weld(m->call, &positions);
    plan->position_weld = (uint32_t *)(uintptr_t)positions.weld;
    core_tangent_adopt(
        plan, plan->position_weld, positions.positions.count, sizeof *plan->position_weld);
    return result;
}

/* The corners at each position and at each place. */
static norma_result sort_plan_corners(core_call *call, norma_tangent_plan *plan) {
    core_mesh positions = plan->mesh, places = plan->mesh;
    positions.weld = plan->position_weld;
    places.weld = plan->place;
    if (!plan->by_position) {
        places.positions.count = plan->key_count;
        places.corner_size = 0;
    }
    norma_core_stage(call, 0.5, 0.75);
    norma_result result =
        norma_core_corners_of_position_build(call, &positions, &plan->at_position);
    norma_core_stage(call, 0.75, 0.97);
    if (!result) result = norma_core_corners_of_position_build(call, &places, &plan->at_place);
    return result;
}

static norma_result fill_tangent_plan(norma_tangent_plan *plan, tangent_mesh *m) {
    plan->by_position = m->by_position;
    plan->key_count = m->key_count;
    norma_result result = keep_topology(plan, m);
    if (!result) result = keep_plan_texcoords(plan, m);
    if (!result) result = keep_positions(plan, m);
    if (!result) result = sort_plan_corners(m->call, plan);
    return result;
}

static norma_result make(tangent_mesh *m, norma_tangent_mode mode, norma_tangent_plan **made) {
    norma_core_stage(m->call, 0.05, 0.3);
    norma_result result = m->mesh.corner_count ? norma_core_tangent_read(m) : NORMA_OK;
    norma_tangent_plan *plan = norma_core_allocate(m->call, 1, sizeof *plan);
    if (plan) {
        *plan = (norma_tangent_plan){.mode = mode, .mesh = m->mesh, .bytes = sizeof *plan};
        plan->memory.options.allocator = m->call->options.allocator;
        norma_core_stage(m->call, 0.3, 0.5);
        if (m->mesh.corner_count && !result) result = fill_tangent_plan(plan, m);
        *made = plan;
    }
    norma_core_tangent_close(m);
    return norma_core_finish(m->call, plan ? result : NORMA_ERROR_MEMORY);
}

norma_result norma_tangent_plan_create(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    norma_tangent_plan **plan) {
    core_call call;
    tangent_mesh checked = {.call = &call};
    norma_tangent_plan *made = NULL;
    norma_result result = norma_core_begin(&call, options);
    if (!result && (!plan || (mode != NORMA_TANGENTS_STEADY && mode != NORMA_TANGENTS_MIKK)))
        result = NORMA_ERROR_ARGUMENT;
    if (!result) result = norma_core_mesh_shape(mesh, &checked.mesh);
    if (!result) norma_core_share(&call, checked.mesh.corner_count);
    if (!result) result = norma_core_tangent_attributes(&checked, mode, normals, texcoords);
    norma_core_stage(&call, 0, 0.05);
    if (!result) result = norma_core_mesh_content(&call, &checked.mesh);
    if (!result) result = make(&checked, mode, &made);
    if (!result)
        *plan = made;
    else
        norma_tangent_plan_destroy(made);
    return result;
}
