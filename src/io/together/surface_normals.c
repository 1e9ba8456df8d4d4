/* surface_normals.c: normals of smooth surfaces: what the faces of each file add, and what its
 * positions get. */
#include "core/call/table.h"
#include "io/together/together.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The first pass over a file. */

typedef struct taking {
    together_run *run;
    const member *m;
    const document_surface *surface;
    const placed_surface *at;
    const placement *place;
    world_mesh world;
    open_sum *sums, *kept; /* of each position; kept: NULL where nothing is locked */
    uint8_t *silent;       /* of each face; NULL */
    uint64_t *borders;     /* of each position: not 0 on an edge of one face; NULL */
} taking;

/* ---- locked parts */

static int is_locked_corner(const taking *t, const surface_part *part) {
    return t->m->document->format != NORMA_FILE_OBJ && t->m->locked && t->m->locked[part->mesh];
}

static int any_locked(const taking *t) {
    if (t->m->document->format == NORMA_FILE_OBJ) return t->m->locked != NULL;
    for (size_t i = 0; i < t->surface->part_count; ++i)
        if (is_locked_corner(t, &t->surface->parts[i])) return 1;
    return 0;
}

/* In the world, of unit length; the length of one that is stored as unit stays. */
static void keep_locked_normal(taking *t, size_t position, const double stored[3]) {
    const double *m = t->place->world;
    double normal[3] = {stored[0], stored[1], stored[2]}, length = norma_core_length(stored);
    if (!norma_core_finite(stored) || !(length > 0)) return;
    if (!t->place->plain) {
        /* The cofactors carry a normal through any matrix; under a mirror they turn it round. */
        for (int k = 0; k < 3; ++k) {
            const double *a = m + 4 * ((k + 1) % 3), *b = m + 4 * ((k + 2) % 3);
            double cross[3];
            norma_core_cross(a, b, cross);
            for (int axis = 0; axis < 3; ++axis)
                normal[axis] = (k ? normal[axis] : 0) + cross[axis] * stored[k];
        }
        if (t->place->mirrored)
            for (int k = 0; k < 3; ++k) normal[k] = -normal[k];
        length = norma_core_length(normal);
    }
    if (!(length > 0)) return;
    if (!t->place->plain || fabs(length - 1) > 1e-3)
        for (int k = 0; k < 3; ++k) normal[k] /= length;
    norma_core_open_sum_add(&t->kept[t->world.weld[position]], 1, normal);
}

static norma_document_result keep_part(taking *t, const surface_part *part) {
    norma_mesh_data data;
    const norma_document_result result =
        norma_document_mesh_data(t->m->document, part->mesh, &data, t->run->error);
    for (size_t v = 0; !result && v < data.normals.count && v < data.mesh.positions.count; ++v) {
        double normal[3];
        norma_view_read(&data.normals, v, normal);
        keep_locked_normal(t, part->first_position + v, normal);
    }
    if (result || part->first_corner == SIZE_MAX) return result;
    for (size_t c = 0; c < data.mesh.corner_count; c += 3)
        if (t->silent && !data.mesh.face_starts) t->silent[(part->first_corner + c) / 3] = 1;
    for (size_t f = 0; t->silent && data.mesh.face_starts && f < data.mesh.face_count; ++f)
        t->silent[f] = 1;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result keep_locked_faces(taking *t) {
    norma_mesh_data data;
    const norma_document_result result =
        norma_document_mesh_data(t->m->document, 0, &data, t->run->error);
    const norma_mesh *mesh = &data.mesh;
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    for (size_t f = 0; !result && f < faces; ++f) {
        const size_t begin = mesh->face_starts ? mesh->face_starts[f] : 3 * f,
                     end = mesh->face_starts ? mesh->face_starts[f + 1] : 3 * f + 3;
        int all = t->m->locked[f] && data.corner_normals;
        for (size_t c = begin; c < end && all; ++c) all = data.corner_normals[c] != UINT32_MAX;
        for (size_t c = begin; c < end && all; ++c) {
            double normal[3];
            norma_view_read(&data.normals, data.corner_normals[c], normal);
            keep_locked_normal(t, norma_mesh_corner(mesh, c), normal);
        }
        t->silent[f] = (uint8_t)all;
    }
    return result;
}

static norma_document_result keep_locked(taking *t) {
    const size_t positions = t->surface->mesh->positions.count;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!any_locked(t)) return result;
    t->kept = norma_io_allocate(positions, sizeof *t->kept);
    t->silent = norma_io_allocate(t->world.mesh.face_count, 1);
    if (!t->kept || !t->silent) return norma_together_fail_memory(t->at);
    if (t->m->document->format == NORMA_FILE_OBJ) return keep_locked_faces(t);
    for (size_t i = 0; i < t->surface->part_count && !result; ++i)
        if (is_locked_corner(t, &t->surface->parts[i]))
            result = keep_part(t, &t->surface->parts[i]);
    return result;
}

/* ---- borders */

static void note_hash(surface_tile *tile, const void *bytes, size_t size) {
    const uint64_t both[] = {tile->hash, norma_core_hash(bytes, size)};
    tile->hash = norma_core_hash(both, sizeof both);
}

static void widen_tile(surface_tile *tile, const double at[3]) {
    const int first = !tile->positions++;
    for (int k = 0; k < 3; ++k) {
        if (first || at[k] < tile->low[k]) tile->low[k] = at[k];
        if (first || at[k] > tile->high[k]) tile->high[k] = at[k];
    }
}

/* A face adds a number of the edge at both ends of each of its edges, or takes it away where it
 * runs from the greater position to the lesser: nothing is left where faces run both ways. */
static void add_border_edge(uint64_t *borders, uint32_t from, uint32_t to) {
    const uint32_t ends[] = {from < to ? from : to, from < to ? to : from};
    const uint64_t number = norma_core_hash(ends, sizeof ends),
                   way = from < to ? number : UINT64_C(0) - number;
    borders[from] += way;
    borders[to] += way;
}

static int mark_open_edges(taking *t) {
    const core_mesh *mesh = &t->world.mesh;
    surface_tile *tile = &t->run->tile;
    const size_t count = t->surface->mesh->positions.count;
    t->borders = norma_io_allocate(count, sizeof *t->borders);
    if (!t->borders) return 0;
    for (size_t f = 0; f < mesh->face_count; ++f)
        for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c) {
            const uint32_t from = norma_core_welded_corner(mesh, c),
                           to = norma_core_welded_corner(mesh, norma_core_next_in_face(mesh, f, c));
            if (from != to) add_border_edge(t->borders, from, to);
        }
    for (size_t i = 0; i < t->world.first_count; ++i)
        widen_tile(tile, t->world.at[t->world.firsts[i]]);
    note_hash(tile, t->world.positions, 3 * count * sizeof *t->world.positions);
    note_hash(tile, t->world.corners, mesh->corner_count * sizeof *t->world.corners);
    if (mesh->face_starts)
        note_hash(tile, mesh->face_starts, (mesh->face_count + 1) * sizeof *mesh->face_starts);
    note_hash(tile, &t->place->level, sizeof t->place->level);
    note_hash(tile, &t->place->mirrored, sizeof t->place->mirrored);
    tile->faces += mesh->face_count;
    return 1;
}

/* ---- records */

static norma_document_result add_corner_vote(taking *t, uint32_t position) {
    const int keeps = t->kept && t->kept[position].votes;
    position_votes votes;
    memset(&votes, 0, sizeof votes);
    memcpy(votes.at, t->world.at[position], sizeof votes.at);
    votes.sum = keeps ? t->kept[position] : t->sums[position];
    votes.rank = keeps ? 0 : t->place->level + 1;
    votes.voters = votes.sum.votes != 0;
    votes.border = t->borders && (t->run->tile.everywhere || t->borders[position]);
    const int failed = norma_spill_add(t->run->votes, norma_together_partition(votes.at), &votes);
    return failed ? norma_together_fail_spill(t->run, failed) : NORMA_DOCUMENT_OK;
}

static norma_document_result take_placed(taking *t, int count_faces) {
    norma_count degenerate = {0, 0};
    t->sums = norma_io_allocate(t->surface->mesh->positions.count, sizeof *t->sums);
    if (!t->sums) return norma_together_fail_memory(t->at);
    norma_document_result result = keep_locked(t);
    if (result) return result;
    if (t->run->tile.marks && !mark_open_edges(t)) return norma_together_fail_memory(t->at);
    const open_voting voting = {
        &t->world.mesh, t->run->compute.weight, t->silent, t->place->mirrored};
    norma_core_open_votes(&voting, t->sums, &degenerate);
    if (count_faces) t->run->degenerate[t->run->number] += degenerate.count;
    for (size_t i = 0; i < t->world.first_count && !result; ++i)
        result = add_corner_vote(t, t->world.firsts[i]);
    return result;
}

static norma_document_result take_at(taking *t, int first) {
    const norma_result placed =
        norma_together_place(t->surface, t->place, &t->run->equal, &t->world);
    norma_document_result result =
        placed ? norma_document_fail_core(t->m->document, t->run->error, placed)
               : take_placed(t, first);
    norma_together_free_world(&t->world);
    free(t->sums);
    free(t->kept);
    free(t->silent);
    free(t->borders);
    return result;
}

static norma_document_result take_surface_votes(void *user, const placed_surface *at) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    (void)user;
    for (size_t i = 0; i < at->count && !result; ++i) {
        taking t = {
            .run = at->run, .m = at->m, .surface = at->surface, .at = at, .place = &at->places[i]};
        result = take_at(&t, i == 0);
    }
    return result;
}

norma_document_result norma_together_take_votes(together_run *run, member *m) {
    return norma_member_visit(run, m, take_surface_votes, NULL);
}

/* ---- positions alone, to find those that are near each other */

static norma_document_result take_near_positions(void *user, const placed_surface *at) {
    together_run *run = user;
    for (size_t i = 0; i < at->count; ++i)
        for (size_t v = 0; v < at->surface->mesh->positions.count; ++v) {
            double position[3], place[3];
            norma_together_position(at->surface, &at->places[i], v, position);
            norma_together_at(&run->equal, position, place);
            if (!norma_near_add(run->near, place)) return norma_together_fail_memory(at);
        }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_together_take_positions(together_run *run, member *m) {
    return norma_member_visit(run, m, take_near_positions, run);
}

/* ---- Normals from the world back into the mesh of a surface. */

/* Places may differ by rounding; by more, a mesh would need one copy for each. */
static const double SAME_NORMAL = 1e-3;

typedef struct taking_back {
    const placed_surface *at;
    together_run *run;
    const document_surface *surface;
    world_mesh world;
    position_normal *found; /* of each position, by the place at hand */
    surface_normals *made;
    uint8_t *seen; /* of each position: SHARED, ALONE */
} taking_back;

static norma_document_result fail_normals(const taking_back *t, norma_result failed) {
    return norma_document_fail_core(t->at->m->document, t->run->error, failed);
}

/* ---- one normal */

/* n = M^-T m, so m is M^T n but for its length. */
void norma_together_into_mesh(
    const placement *place, const position_normal *from, float normal[3]) {
    const double *m = place->world, *n = from->direction;
    double local[3];
    if (from->kept && place->plain && fabs(norma_core_length(n) - 1) <= 1e-3) {
        for (int k = 0; k < 3; ++k) normal[k] = (float)n[k];
        return;
    }
    for (int k = 0; k < 3; ++k)
        local[k] =
            place->plain ? n[k] : m[4 * k] * n[0] + m[4 * k + 1] * n[1] + m[4 * k + 2] * n[2];
    norma_core_direction(local, normal);
}

int norma_together_differ(const float a[3], const float b[3]) {
    double square = 0;
    for (int k = 0; k < 3; ++k) {
        const double by = (double)a[k] - (double)b[k];
        square += by * by;
    }
    return square > SAME_NORMAL * SAME_NORMAL;
}

/* ---- records */

static norma_document_result read_records(taking_back *t) {
    const size_t count = t->surface->mesh->positions.count;
    int failed = 0;
    for (size_t i = 0; i < count; ++i)
        t->found[i].reason = t->world.weld[i] == i && !norma_core_finite(t->world.at[i])
                                 ? NORMA_REASON_NON_FINITE
                                 : NORMA_REASON_NONE;
    for (size_t i = 0; i < t->world.first_count && !failed; ++i) {
        const uint32_t first = t->world.firsts[i];
        failed = norma_spill_next(
            t->run->normals, norma_together_partition(t->world.at[first]), &t->found[first]);
    }
    for (size_t i = 0; i < count; ++i) t->found[i] = t->found[t->world.weld[i]];
    return failed ? norma_together_fail_spill(t->run, failed) : NORMA_DOCUMENT_OK;
}

/* Sums that cancel: over the faces of the vertex alone, as norma_vertex_normals does. */
static norma_document_result resolve_cancelled(taking_back *t, const placement *place) {
    const size_t count = t->surface->mesh->positions.count;
    size_t cancelled = 0;
    norma_count unused = {0, 0};
    for (size_t i = 0; i < count; ++i) cancelled += t->found[i].reason == NORMA_REASON_CANCELLED;
    if (!cancelled) return NORMA_DOCUMENT_OK;
    open_sum *own = norma_io_allocate(count, sizeof *own);
    if (!own) return norma_together_fail_memory(t->at);
    core_mesh apart = t->world.mesh;
    apart.weld = NULL;
    const open_voting voting = {&apart, t->run->compute.weight, NULL, place->mirrored};
    norma_core_open_votes(&voting, own, &unused);
    for (size_t i = 0; i < count; ++i)
        if (t->found[i].reason == NORMA_REASON_CANCELLED &&
            norma_core_open_direction(&own[i], t->found[i].direction) == NORMA_REASON_NONE)
            t->found[i].reason = NORMA_REASON_NONE;
    free(own);
    return NORMA_DOCUMENT_OK;
}

/* ---- a mesh at one place, or at several */

static void take_position(
    const position_normal *from, const placement *place, float normal[3], uint8_t *reason) {
    *reason = from->reason;
    if (from->reason == NORMA_REASON_NONE) norma_together_into_mesh(place, from, normal);
}

enum { SHARED = 1, ALONE = 2 }; /* at some place it shares the position with others, or does not */

norma_document_result norma_together_fail_places(const placed_surface *at) {
    norma_mesh_info info = {.name = ""};
    norma_document_mesh_info(at->m->document, at->surface->parts[0].mesh, &info);
    return norma_document_fail(at->m->document, at->run->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        info.where,
        "mesh \"%.200s\" is drawn at %zu places and would need different normals there, because "
        "different surfaces meet it; transform --bake gives each node a mesh of its own",
        info.name, at->count);
}

/* Of several places those decide where others meet the mesh. Elsewhere it has the normals that it
 * has alone. */
static norma_document_result take_shared_normals(taking_back *t, const placement *place) {
    for (size_t i = 0; i < t->surface->mesh->positions.count; ++i) {
        float normal[3];
        uint8_t reason;
        if (t->found[i].reason != NORMA_REASON_NONE) continue;
        if (!t->found[i].shared) {
            t->seen[i] |= ALONE;
            continue;
        }
        take_position(&t->found[i], place, normal, &reason);
        if (!(t->seen[i] & SHARED)) {
            memcpy(t->made->normals + 3 * i, normal, sizeof normal);
            t->made->reasons[i] = NORMA_REASON_NONE;
            t->seen[i] |= SHARED;
        } else if (norma_together_differ(normal, t->made->normals + 3 * i)) {
            return norma_together_fail_places(t->at);
        }
    }
    return NORMA_DOCUMENT_OK;
}

/* A place that shares a position with nobody wants the mesh's own normal there. */
static norma_document_result compare_alone(const taking_back *t, const float *alone) {
    for (size_t i = 0; i < t->made->count; ++i)
        if (t->seen[i] == (SHARED | ALONE) &&
            norma_together_differ(alone + 3 * i, t->made->normals + 3 * i))
            return norma_together_fail_places(t->at);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_place(taking_back *t, const placement *place) {
    norma_together_free_world(&t->world);
    const norma_result placed = norma_together_place(t->surface, place, &t->run->equal, &t->world);
    if (placed) return fail_normals(t, placed);
    const norma_document_result result = read_records(t);
    return result ? result : resolve_cancelled(t, place);
}

static norma_document_result take_one_place(taking_back *t) {
    const placement *place = &t->at->places[0];
    const norma_document_result result = read_place(t, place);
    for (size_t i = 0; !result && i < t->made->count; ++i)
        take_position(&t->found[i], place, t->made->normals + 3 * i, &t->made->reasons[i]);
    return result;
}

/* As the mesh has them alone, in its own space. */
static norma_document_result compute_alone_smooth(taking_back *t) {
    static const equality exact = {0, NULL};
    static const placement own = {
        .world = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, .plain = 1};
    const size_t count = t->made->count;
    norma_count unused = {0, 0};
    norma_together_free_world(&t->world);
    const norma_result placed = norma_together_place(t->surface, &own, &exact, &t->world);
    if (placed) return fail_normals(t, placed);
    open_sum *sums = norma_io_allocate(count, sizeof *sums);
    if (!sums) return norma_together_fail_memory(t->at);
    const open_voting voting = {&t->world.mesh, t->run->compute.weight, NULL, 0};
    norma_core_open_votes(&voting, sums, &unused);
    for (size_t i = 0; i < count; ++i) {
        t->found[i] = (position_normal){0};
        t->found[i].reason =
            (uint8_t)norma_core_open_direction(&sums[t->world.weld[i]], t->found[i].direction);
        if (!norma_core_finite(t->world.at[i])) t->found[i].reason = NORMA_REASON_NON_FINITE;
    }
    free(sums);
    const norma_document_result result = resolve_cancelled(t, &own);
    for (size_t i = 0; !result && i < count; ++i)
        take_position(&t->found[i], &own, t->made->normals + 3 * i, &t->made->reasons[i]);
    return result;
}

static norma_document_result take_many_places(taking_back *t) {
    norma_document_result result = compute_alone_smooth(t);
    float *alone = norma_io_block(t->made->count, 3 * sizeof *alone);
    t->seen = norma_io_allocate(t->made->count, 1);
    if (!result && (!alone || !t->seen)) result = norma_together_fail_memory(t->at);
    if (!result) memcpy(alone, t->made->normals, 3 * t->made->count * sizeof *alone);
    for (size_t k = 0; k < t->at->count && !result; ++k) {
        result = read_place(t, &t->at->places[k]);
        if (!result) result = take_shared_normals(t, &t->at->places[k]);
    }
    if (!result) result = compare_alone(t, alone);
    free(alone);
    return result;
}

/* ---- what has none gets the nearest */

static norma_document_result fill_joined_nearest(taking_back *t, size_t missing) {
    const norma_options options = {.struct_size = sizeof options};
    surface_normals *made = t->made;
    core_call call;
    core_nearest nearest;
    norma_result failed = norma_core_begin(&call, &options);
    if (!failed) failed = norma_core_nearest_begin(&call, &t->world.mesh, &nearest);
    if (failed) return fail_normals(t, failed);
    for (size_t i = 0; i < made->count; ++i)
        if (made->reasons[i] == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, (uint32_t)i, (uint32_t)i);
    failed = norma_core_nearest_plant(&nearest, missing);
    for (size_t i = 0; i < made->count && !failed; ++i) {
        if (made->reasons[i] == NORMA_REASON_NONE) continue;
        const uint32_t source = norma_core_nearest_find(&nearest, (uint32_t)i);
        for (size_t k = 0; k < 3; ++k)
            made->normals[3 * i + k] = source == UINT32_MAX ? 0 : made->normals[3 * source + k];
    }
    norma_core_nearest_end(&nearest);
    return fail_normals(t, failed);
}

static norma_document_result fill_missing_normals(taking_back *t) {
    size_t missing = 0;
    for (size_t i = 0; i < t->made->count; ++i) missing += t->made->reasons[i] != NORMA_REASON_NONE;
    return missing ? fill_joined_nearest(t, missing) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_together_surface_normals(
    const placed_surface *at, surface_normals *made) {
    taking_back t = {.at = at, .run = at->run, .surface = at->surface, .made = made};
    t.found = norma_io_allocate(made->count, sizeof *t.found);
    norma_document_result result = !t.found         ? norma_together_fail_memory(at)
                                   : at->count == 1 ? take_one_place(&t)
                                   : at->count      ? take_many_places(&t)
                                                    : compute_alone_smooth(&t);
    if (!result) result = fill_missing_normals(&t);
    norma_together_free_world(&t.world);
    free(t.found);
    free(t.seen);
    return result;
}
