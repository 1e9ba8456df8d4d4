/* count_missing.c: a vertex without a normal is known to each rank that has it. Its number goes to
 * its home, which counts each once. */
#include "core/call/sort.h"
#include "mpi/vertex/missing.h"
#include "mpi/vertex/sharing.h"

enum { MISSING_SIZE = sizeof(uint64_t) + 1 };

static norma_result list_missing(
    const mpi_call *call, const mpi_part *part, const uint8_t *reasons, mpi_lists *out) {
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    for (size_t v = 0; v < part->positions; v++)
        if (reasons[v]) room[norma_mpi_home_of_number(call, part->vertex_ids[v])]++;
    const norma_result result = norma_mpi_lists_open(call, room, MISSING_SIZE, out);
    norma_core_release(call->core, room, ranks, sizeof *room);
    for (size_t v = 0; v < part->positions && result == NORMA_OK; v++) {
        if (!reasons[v]) continue;
        unsigned char *record =
            norma_mpi_lists_add(out, norma_mpi_home_of_number(call, part->vertex_ids[v]));
        memcpy(record, &part->vertex_ids[v], sizeof part->vertex_ids[v]);
        record[sizeof(uint64_t)] = reasons[v];
    }
    return result;
}

static int record_less(const void *a, const void *b) {
    uint64_t one, other;
    memcpy(&one, a, sizeof one);
    memcpy(&other, b, sizeof other);
    return one < other;
}

static void count_numbers(const mpi_call *call, const mpi_lists *in, core_tally *tally) {
    const size_t count = norma_mpi_lists_total(call, in);
    uint64_t number, before = 0;
    norma_core_sort(in->bytes, count, MISSING_SIZE, record_less);
    for (size_t i = 0; i < count; i++) {
        const unsigned char *record = norma_mpi_record(in, i);
        memcpy(&number, record, sizeof number);
        if (!i || number != before) norma_core_tally(tally, record[sizeof number], (size_t)number);
        before = number;
    }
}

norma_result norma_mpi_count_missing(
    mpi_call *call, const mpi_part *part, const uint8_t *reasons, core_tally *tally) {
    mpi_lists out = {0}, in = {0};
    uint64_t any = 0;
    for (size_t v = 0; v < part->positions; v++) any |= reasons[v];
    if (!norma_mpi_largest(call, any)) return NORMA_OK;
    const norma_result result =
        norma_mpi_exchange(call, list_missing(call, part, reasons, &out), &out, &in);
    if (result == NORMA_OK) count_numbers(call, &in, tally);
    norma_mpi_lists_close(call, &out);
    norma_mpi_lists_close(call, &in);
    return result;
}

/* ---- the whole mesh */

void norma_mpi_add_tallies(const mpi_call *call, core_tally *tally) {
    norma_count *const counts[4] = {
        &tally->non_finite, &tally->unreferenced, &tally->cancelled, &tally->degenerate};
    uint64_t sums[4];
    for (size_t i = 0; i < 4; i++) sums[i] = counts[i]->count;
    MPI_Allreduce(MPI_IN_PLACE, sums, 4, MPI_UINT64_T, MPI_SUM, call->comm);
    for (size_t i = 0; i < 4; i++) {
        if (!sums[i]) continue;
        const uint64_t first =
            norma_mpi_least(call, counts[i]->count ? counts[i]->first : UINT64_MAX);
        *counts[i] = (norma_count){(size_t)sums[i], (size_t)first};
    }
}
