/* ply_classes.c: positions that several vertices have get a slot at their home; of the vertices
 * that share a slot, the home finds the least. */
#include "mpi/file/ply_classes.h"
#include "mpi/vertex/gathered_weld.h"
#include "mpi/vertex/sharing.h"

typedef struct slot_vertex {
    uint32_t slot, vertex;
} slot_vertex;

core_mesh norma_mpi_own_positions(const ply_part *part, double scale) {
    const norma_format format = part->doubles ? NORMA_FORMAT_DOUBLE : NORMA_FORMAT_FLOAT;
    return (core_mesh){.positions = {.data = part->positions,
                           .count = part->own,
                           .stride = norma_mpi_position_size(part),
                           .format = format},
        .scale = part->doubles ? scale : 1};
}

/* ---- the least vertex of each slot */

static int is_shared(const mpi_sharing *sharing, size_t v) {
    return norma_mpi_kind(norma_mpi_place_at(sharing, v)) == MPI_SHARED;
}

static norma_result list_slots(
    const mpi_job *job, const ply_part *part, const mpi_sharing *sharing, mpi_lists *out) {
    const mpi_call *call = &job->call;
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    for (size_t v = 0; v < part->own; v++)
        if (is_shared(sharing, v)) room[norma_mpi_home(norma_mpi_place_at(sharing, v))]++;
    const norma_result result = norma_mpi_lists_open(call, room, sizeof(slot_vertex), out);
    norma_core_release(call->core, room, ranks, sizeof *room);
    for (size_t v = 0; v < part->own && result == NORMA_OK; v++) {
        const mpi_place place = norma_mpi_place_at(sharing, v);
        const slot_vertex s = {(uint32_t)norma_mpi_slot(place), (uint32_t)(part->first + v)};
        if (is_shared(sharing, v))
            memcpy(norma_mpi_lists_add(out, norma_mpi_home(place)), &s, sizeof s);
    }
    return result;
}

/* Vertices come ascending: by ranks, and each rank's in order. */
static norma_result answer_slots(
    const mpi_call *call, const mpi_sharing *sharing, const mpi_lists *in, mpi_lists *answers) {
    const size_t slots = (size_t)sharing->slots[call->rank],
                 count = norma_mpi_lists_total(call, in);
    uint32_t *least = norma_core_allocate(call->core, slots, sizeof *least);
    if (!least) return NORMA_ERROR_MEMORY;
    memset(least, 0xff, slots * sizeof *least);
    const norma_result result = norma_mpi_lists_like(call, in, sizeof *least, answers);
    for (size_t i = 0; i < count && result == NORMA_OK; i++) {
        slot_vertex s;
        memcpy(&s, norma_mpi_record(in, i), sizeof s);
        if (least[s.slot] == UINT32_MAX) least[s.slot] = s.vertex;
        memcpy(norma_mpi_record(answers, i), &least[s.slot], sizeof *least);
    }
    norma_core_release(call->core, least, slots, sizeof *least);
    return result;
}

static norma_result read_slots(const mpi_call *call, const mpi_sharing *sharing,
    const mpi_lists *back, size_t own, uint32_t *classes) {
    const size_t ranks = (size_t)call->ranks;
    int *next = norma_core_allocate(call->core, ranks, sizeof *next);
    if (!next) return NORMA_ERROR_MEMORY;
    memcpy(next, back->starts, ranks * sizeof *next);
    for (size_t v = 0; v < own; v++) {
        if (!is_shared(sharing, v)) continue;
        const size_t at = (size_t)next[norma_mpi_home(norma_mpi_place_at(sharing, v))]++;
        memcpy(&classes[v], norma_mpi_record(back, at), sizeof *classes);
    }
    norma_core_release(call->core, next, ranks, sizeof *next);
    return NORMA_OK;
}

static norma_result take_least(
    mpi_job *job, const ply_part *part, const mpi_sharing *sharing, uint32_t *classes) {
    mpi_call *call = &job->call;
    mpi_lists out = {0}, in = {0}, answers = {0}, back = {0};
    norma_result result = norma_mpi_exchange(call, list_slots(job, part, sharing, &out), &out, &in);
    if (result == NORMA_OK) {
        norma_result mine = answer_slots(call, sharing, &in, &answers);
        if (mine == NORMA_OK) mine = norma_mpi_lists_like(call, &out, sizeof *classes, &back);
        result = norma_mpi_agree(call, mine);
    }
    if (result == NORMA_OK) {
        norma_mpi_answer(call, &answers, &back);
        result = norma_mpi_agree(call, read_slots(call, sharing, &back, part->own, classes));
    }
    norma_mpi_lists_close(call, &in);
    norma_mpi_lists_close(call, &out);
    norma_mpi_lists_close(call, &answers);
    norma_mpi_lists_close(call, &back);
    return result;
}

/* ---- by equal positions, by distance */

/* NaN is equal to nothing, infinity to itself. */
static uint8_t has_nan(const core_mesh *mesh, size_t v) {
    double p[3];
    norma_core_position(mesh, (uint32_t)v, p);
    return p[0] != p[0] || p[1] != p[1] || p[2] != p[2];
}

static norma_result share_equal(
    mpi_job *job, const ply_part *part, const core_mesh *mesh, uint32_t *classes) {
    enum { LEAST_BUDGET = 1 << 20, OF_VERTEX = 16 };
    mpi_call *call = &job->call;
    mpi_sharing sharing;
    const mpi_keys keys = {mesh, NULL, part->doubles};
    const size_t budget = part->own * OF_VERTEX + LEAST_BUDGET;
    uint8_t *takes_part = norma_core_allocate(call->core, part->own, 1);
    for (size_t v = 0; takes_part && v < part->own; v++)
        takes_part[v] = has_nan(mesh, v) ? MPI_ABSENT : MPI_VOTES;
    norma_result result = norma_mpi_agree(call, takes_part ? NORMA_OK : NORMA_ERROR_MEMORY);
    if (result == NORMA_OK) result = norma_mpi_share(call, &keys, takes_part, 1, budget, &sharing);
    if (result == NORMA_OK) {
        result = take_least(job, part, &sharing, classes);
        norma_mpi_sharing_close(call, &sharing);
    }
    norma_core_release(call->core, takes_part, part->own, 1);
    return result;
}

/* Groups are numbered by the place of their first position among all ranks' in order, which is the
 * vertex of the file. */
static norma_result gather_near(mpi_job *job, const core_mesh *mesh, uint32_t *classes) {
    uint64_t *groups;
    core_call *core = job->call.core;
    core->options.weld = NORMA_WELD_DISTANCE;
    core->options.weld_distance = job->options.weld_distance;
    const norma_result result = norma_mpi_weld_gathered(&job->call, mesh, &groups);
    for (size_t v = 0; v < mesh->positions.count && result == NORMA_OK; v++)
        classes[v] = (uint32_t)groups[v];
    norma_core_release(core, groups, mesh->positions.count, sizeof *groups);
    return result;
}

norma_result norma_mpi_find_classes(
    mpi_job *job, const ply_part *part, double scale, uint32_t **classes) {
    const core_call *core = &job->core;
    const core_mesh mesh = norma_mpi_own_positions(part, scale);
    *classes = norma_core_allocate(core, part->own, sizeof **classes);
    for (size_t v = 0; *classes && v < part->own; v++) (*classes)[v] = (uint32_t)(part->first + v);
    norma_result result = norma_mpi_agree(&job->call, *classes ? NORMA_OK : NORMA_ERROR_MEMORY);
    if (result == NORMA_OK && job->options.weld == NORMA_WELD_EXACT)
        result = share_equal(job, part, &mesh, *classes);
    if (result == NORMA_OK && job->options.weld == NORMA_WELD_DISTANCE)
        result = gather_near(job, &mesh, *classes);
    if (result == NORMA_OK) return NORMA_OK;
    norma_core_release(core, *classes, part->own, sizeof **classes);
    *classes = NULL;
    return result;
}
