/* take_votes.c: the first pass over a file. */
#include "core/call/vec3_view.h"
#include "core/call/vector.h"
#include "core/vertex/open_votes.h"
#include "io/file/large_memory.h"
#include "io/together/run.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct taking {
    together_run *run;
    member *m;
    const document_surface *surface;
    const placement *place;
    world_mesh world;
    open_sum *sums, *kept; /* of each position; kept: NULL where nothing is locked */
    uint8_t *silent;       /* of each face; NULL */
} taking;

static norma_document_result fail_votes(const taking *t) {
    return norma_document_fail_memory(t->m->document, t->run->error);
}

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
    if (!t->kept || !t->silent) return fail_votes(t);
    if (t->m->document->format == NORMA_FILE_OBJ) return keep_locked_faces(t);
    for (size_t i = 0; i < t->surface->part_count && !result; ++i)
        if (is_locked_corner(t, &t->surface->parts[i]))
            result = keep_part(t, &t->surface->parts[i]);
    return result;
}

/* ---- records */

static norma_document_result add_corner_vote(taking *t, uint32_t position) {
    const int keeps = t->kept && t->kept[position].votes;
    position_votes votes;
    memset(&votes, 0, sizeof votes);
    memcpy(votes.at, t->world.at[position], sizeof votes.at);
    votes.sum = keeps ? t->kept[position] : t->sums[position];
    votes.rank = keeps ? 0 : t->place->level + 1;
    const int failed = norma_spill_add(t->run->votes, norma_together_partition(votes.at), &votes);
    return failed ? norma_together_fail_spill(t->run, failed) : NORMA_DOCUMENT_OK;
}

static norma_document_result take_placed(taking *t, int count_faces) {
    norma_count degenerate = {0, 0};
    t->sums = norma_io_allocate(t->surface->mesh->positions.count, sizeof *t->sums);
    if (!t->sums) return fail_votes(t);
    norma_document_result result = keep_locked(t);
    if (result) return result;
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
    t->sums = t->kept = NULL;
    t->silent = NULL;
    return result;
}

static norma_document_result take_surface_votes(void *user, const document_surface *surface) {
    taking *t = user;
    placement *places;
    size_t count;
    t->surface = surface;
    norma_document_result result =
        norma_member_places(t->m, surface, &places, &count, t->run->error);
    for (size_t i = 0; i < count && !result; ++i) {
        t->place = &places[i];
        result = take_at(t, i == 0);
    }
    free(places);
    return result;
}

norma_document_result norma_together_take_votes(together_run *run, member *m) {
    taking t = {.run = run, .m = m};
    return norma_member_visit(m, take_surface_votes, &t, run->error);
}

/* ---- positions alone, to find those that are near each other */

static norma_document_result take_near_positions(void *user, const document_surface *surface) {
    taking *t = user;
    placement *places;
    size_t count;
    norma_document_result result =
        norma_member_places(t->m, surface, &places, &count, t->run->error);
    for (size_t i = 0; i < count && !result; ++i)
        for (size_t v = 0; v < surface->mesh->positions.count && !result; ++v) {
            double position[3], at[3];
            norma_together_position(surface, &places[i], v, position);
            norma_together_at(&t->run->equal, position, at);
            if (!norma_near_add(t->run->near, at)) result = fail_votes(t);
        }
    free(places);
    return result;
}

norma_document_result norma_together_take_positions(together_run *run, member *m) {
    taking t = {.run = run, .m = m};
    return norma_member_visit(m, take_near_positions, &t, run->error);
}
