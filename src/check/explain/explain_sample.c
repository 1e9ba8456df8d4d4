/* explain_sample.c: a part of a mesh small enough to try many ways of computing normals on, with
 * whole rings around the positions that are looked at. */
#include "check/explain/explain_normals.h"
#include <string.h>

enum { MOST_AT_POSITION = 128 };

static uint64_t mix(uint64_t h) {
    h = (h ^ (h >> 32)) * UINT64_C(0x9e3779b97f4a7c15);
    h = (h ^ (h >> 29)) * UINT64_C(0xbf58476d1ce4e5b9);
    return h ^ (h >> 32);
}

typedef struct choice {
    const core_topology *topology;
    uint64_t one_in;
} choice;

static int is_chosen(const choice *c, uint32_t position) {
    const core_corners_of_position *around = &c->topology->corners_of;
    size_t count = around->starts[position + 1] - around->starts[position];
    return count > 0 && count <= MOST_AT_POSITION && mix(position) % c->one_in == 0;
}

/* The places of the ones, ascending. */
static void list_marked(const uint8_t *marks, size_t count, uint32_t *places) {
    for (const uint8_t *at = marks; (at = memchr(at, 1, count - (size_t)(at - marks))); at++)
        *places++ = (uint32_t)(at - marks);
}

static size_t place_of(const uint32_t *sorted, size_t count, uint32_t number) {
    size_t low = 0, high = count;
    while (low + 1 < high) {
        size_t middle = low + (high - low) / 2;
        if (sorted[middle] <= number)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static size_t mark(uint8_t *marks, size_t place) {
    const int is_new = !marks[place];
    marks[place] = 1;
    return (size_t)is_new;
}

/* The faces around all chosen positions; how many. */
static size_t mark_faces(const choice *c, uint8_t *marks) {
    const core_topology *t = c->topology;
    size_t count = 0;
    memset(marks, 0, t->mesh.face_count);
    for (uint32_t p = 0; p < t->corners_of.position_count; p++) {
        if (!is_chosen(c, p)) continue;
        for (uint32_t i = t->corners_of.starts[p]; i < t->corners_of.starts[p + 1]; i++)
            count += mark(marks, norma_core_topology_face(t, t->corners_of.corners[i]));
    }
    return count;
}

static int allocate(const core_call *call, const core_mesh *mesh, explain_sample *s) {
    s->positions = norma_core_allocate(call, s->corner_count, sizeof *s->positions);
    s->corners = norma_core_allocate(call, s->corner_count, sizeof *s->corners);
    s->sources = norma_core_allocate(call, s->corner_count, sizeof *s->sources);
    s->whole = norma_core_allocate(call, s->corner_count, 1);
    s->starts = norma_core_allocate(call, s->face_count + 1, sizeof *s->starts);
    s->groups =
        mesh->smoothing_groups ? norma_core_allocate(call, s->face_count, sizeof *s->groups) : NULL;
    s->hard_edges = mesh->hard_edges ? norma_core_allocate(call, s->corner_count, 1) : NULL;
    return s->positions && s->corners && s->sources && s->whole && s->starts &&
           (s->groups || !mesh->smoothing_groups) && (s->hard_edges || !mesh->hard_edges);
}

/* places: the positions that the faces use, ascending. */
static void copy_faces(
    const choice *c, const uint32_t *faces, const uint32_t *places, explain_sample *s) {
    const core_topology *t = c->topology;
    size_t at = 0;
    for (size_t i = 0; i < s->face_count; i++) {
        s->starts[i] = (uint32_t)at;
        if (s->groups) s->groups[i] = t->mesh.smoothing_groups[faces[i]];
        for (size_t corner = norma_core_face_begin(&t->mesh, faces[i]);
             corner < norma_core_face_end(&t->mesh, faces[i]); corner++, at++) {
            s->corners[at] = (uint32_t)place_of(places, s->position_count, t->corners[corner]);
            s->sources[at] = (uint32_t)corner;
            s->whole[at] = (uint8_t)is_chosen(c, t->corners[corner]);
            if (s->hard_edges) s->hard_edges[at] = t->mesh.hard_edges[corner];
        }
    }
    s->starts[s->face_count] = (uint32_t)at;
    for (size_t i = 0; i < s->position_count; i++)
        norma_core_position(&t->mesh, places[i], s->positions[i]);
    s->mesh = (norma_mesh){.positions = {s->positions, s->position_count, 0, NORMA_FORMAT_DOUBLE},
        .corners = s->corners,
        .corner_count = at,
        .face_starts = t->mesh.face_starts ? s->starts : NULL,
        .face_count = s->face_count,
        .smoothing_groups = s->groups,
        .hard_edges = s->hard_edges};
}

/* The positions that the faces use; how many. */
static size_t mark_places(
    const choice *c, const uint32_t *faces, const explain_sample *s, uint8_t *marks) {
    const core_mesh *mesh = &c->topology->mesh;
    size_t count = 0;
    memset(marks, 0, mesh->positions.count);
    for (size_t i = 0; i < s->face_count; i++)
        for (size_t corner = norma_core_face_begin(mesh, faces[i]);
             corner < norma_core_face_end(mesh, faces[i]); corner++)
            count += mark(marks, c->topology->corners[corner]);
    return count;
}

static norma_result copy_sample(
    core_call *call, const choice *c, const uint32_t *faces, explain_sample *s) {
    const core_mesh *mesh = &c->topology->mesh;
    const size_t positions = mesh->positions.count;
    for (size_t i = 0; i < s->face_count; i++)
        s->corner_count +=
            norma_core_face_end(mesh, faces[i]) - norma_core_face_begin(mesh, faces[i]);
    uint32_t *places = norma_core_allocate(call, s->corner_count, sizeof *places);
    uint8_t *marks = norma_core_allocate(call, positions, 1);
    norma_result result =
        allocate(call, mesh, s) && places && marks ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        s->position_count = mark_places(c, faces, s, marks);
        list_marked(marks, positions, places);
        copy_faces(c, faces, places, s);
    }
    norma_core_release(call, marks, positions, 1);
    norma_core_release(call, places, s->corner_count, sizeof *places);
    if (result) norma_explain_free_sample(call, s);
    return result;
}

norma_result norma_explain_take_sample(
    core_call *call, const core_topology *topology, explain_sample *sample) {
    const choice c = {topology, topology->mesh.corner_count / EXPLAIN_FACES + 1};
    const size_t all = topology->mesh.face_count;
    *sample = (explain_sample){.face_count = 0};
    uint8_t *marks = norma_core_allocate(call, all, 1);
    if (!marks) return NORMA_ERROR_MEMORY;
    const size_t count = mark_faces(&c, marks);
    uint32_t *faces = norma_core_allocate(call, count, sizeof *faces);
    if (faces) list_marked(marks, all, faces);
    norma_core_release(call, marks, all, 1);
    if (!faces) return NORMA_ERROR_MEMORY;
    sample->face_count = count;
    const norma_result result = copy_sample(call, &c, faces, sample);
    norma_core_release(call, faces, count, sizeof *faces);
    return result;
}

void norma_explain_free_sample(const core_call *call, explain_sample *s) {
    norma_core_release(call, s->positions, s->corner_count, sizeof *s->positions);
    norma_core_release(call, s->corners, s->corner_count, sizeof *s->corners);
    norma_core_release(call, s->sources, s->corner_count, sizeof *s->sources);
    norma_core_release(call, s->whole, s->corner_count, 1);
    norma_core_release(call, s->starts, s->face_count + 1, sizeof *s->starts);
    norma_core_release(call, s->groups, s->face_count, sizeof *s->groups);
    norma_core_release(call, s->hard_edges, s->corner_count, 1);
    *s = (explain_sample){.face_count = 0};
}
