/* gathered_weld.c: chains of steps may run through all ranks, so one of them has all positions
 * before it, in their order of ranks, and joins them as the core does. */
#include "mpi/vertex/gathered_weld.h"
#include "core/mesh/weld.h"

enum { POINT = 3 * sizeof(double) };

/* As the core reads them, its scale applied. */
static norma_result list_points(const mpi_call *call, const core_mesh *mesh, mpi_lists *out) {
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    room[0] = mesh->positions.count;
    const norma_result result = norma_mpi_lists_open(call, room, POINT, out);
    norma_core_release(call->core, room, ranks, sizeof *room);
    for (size_t v = 0; v < mesh->positions.count && result == NORMA_OK; v++) {
        double p[3];
        norma_view_read(&mesh->positions, v, p);
        memcpy(norma_mpi_lists_add(out, 0), p, POINT);
    }
    return result;
}

static norma_result weld_points(
    const mpi_call *call, const mpi_lists *in, double scale, mpi_lists *answers) {
    core_mesh all = {.positions = {.data = in->bytes,
                         .count = norma_mpi_lists_total(call, in),
                         .stride = POINT,
                         .format = NORMA_FORMAT_DOUBLE},
        .scale = scale};
    if (all.positions.count > UINT32_MAX - 1) return NORMA_ERROR_OVERFLOW;
    norma_result result = norma_core_weld(call->core, &all);
    if (result != NORMA_OK) return result;
    result = norma_mpi_lists_like(call, in, sizeof(uint32_t), answers);
    for (size_t i = 0; i < all.positions.count && result == NORMA_OK; i++) {
        const uint32_t group = norma_core_welded(&all, (uint32_t)i);
        memcpy(norma_mpi_record(answers, i), &group, sizeof group);
    }
    norma_core_unweld(call->core, &all);
    return result;
}

static norma_result read_groups(
    const mpi_call *call, const mpi_lists *back, size_t count, uint64_t **groups) {
    *groups = norma_core_allocate(call->core, count, sizeof **groups);
    if (!*groups) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < count; v++) {
        uint32_t group;
        memcpy(&group, norma_mpi_record(back, v), sizeof group);
        (*groups)[v] = group;
    }
    return NORMA_OK;
}

norma_result norma_mpi_weld_gathered(mpi_call *call, const core_mesh *mesh, uint64_t **groups) {
    mpi_lists out = {0}, in = {0}, answers = {0}, back = {0};
    double mine = mesh->scale, scale = 1;
    const size_t count = mesh->positions.count;
    *groups = NULL;
    if (!count) mine = 0; /* a rank without positions knows no scale */
    MPI_Allreduce(&mine, &scale, 1, MPI_DOUBLE, MPI_MAX, call->comm);
    norma_result result = norma_mpi_exchange(call, list_points(call, mesh, &out), &out, &in);
    if (result == NORMA_OK) {
        norma_result local = weld_points(call, &in, scale, &answers);
        if (local == NORMA_OK) local = norma_mpi_lists_like(call, &out, sizeof(uint32_t), &back);
        result = norma_mpi_agree(call, local);
    }
    if (result == NORMA_OK) {
        norma_mpi_answer(call, &answers, &back);
        const norma_result local = read_groups(call, &back, count, groups);
        result = norma_mpi_agree(call, local);
        if (result != NORMA_OK) {
            norma_core_release(call->core, *groups, count, sizeof **groups);
            *groups = NULL;
        }
    }
    norma_mpi_lists_close(call, &in);
    norma_mpi_lists_close(call, &out);
    norma_mpi_lists_close(call, &answers);
    norma_mpi_lists_close(call, &back);
    return result;
}
