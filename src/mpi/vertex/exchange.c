/* exchange.c: all of MPI that the computation of normals needs. */
#define _POSIX_C_SOURCE 200809L /* nanosleep */
#include "mpi/vertex/vertex.h"
#include <limits.h>
#include <string.h>
#include <time.h>

norma_result norma_mpi_begin(mpi_call *call, MPI_Comm comm, core_call *core) {
    *call = (mpi_call){.core = core};
    if (MPI_Comm_dup(comm, &call->comm) != MPI_SUCCESS) return NORMA_ERROR_ARGUMENT;
    MPI_Comm_rank(call->comm, &call->rank);
    MPI_Comm_size(call->comm, &call->ranks);
    return NORMA_OK;
}

void norma_mpi_end(mpi_call *call) { MPI_Comm_free(&call->comm); }

/* ---- Ranks wait for each other where they agree. MPI's own waiting takes all of a core, which the
 * rank that is waited for may need. Here it sleeps, for an eighth of the time that it has waited.
 */

static void mpi_wait(MPI_Request *request) {
    enum { TESTS_AWAKE = 200 };
    const double longest = 1e-3;
    int done = 0;
    for (int tests = 0; tests < TESTS_AWAKE && !done; ++tests)
        MPI_Test(request, &done, MPI_STATUS_IGNORE);
    const double begin = MPI_Wtime();
    while (!done) {
        const double eighth = (MPI_Wtime() - begin) / 8,
                     pause = eighth < longest ? eighth : longest;
        nanosleep(&(struct timespec){.tv_nsec = (long)(pause * 1e9)}, NULL);
        MPI_Test(request, &done, MPI_STATUS_IGNORE);
    }
}

void norma_mpi_reduce(const mpi_call *call, void *all, int count, MPI_Datatype type, MPI_Op op) {
    MPI_Request request;
    MPI_Iallreduce(MPI_IN_PLACE, all, count, type, op, call->comm, &request);
    mpi_wait(&request);
}

/* ---- agreeing */

/* Cancelled is less than any error. */
static int gravity(norma_result result) { return result > 0 ? 1 : result < 0 ? 1 - result : 0; }

norma_result norma_mpi_agree(const mpi_call *call, norma_result mine) {
    int all = gravity(mine);
    norma_mpi_reduce(call, &all, 1, MPI_INT, MPI_MAX);
    return (norma_result)(all > 1 ? 1 - all : all);
}

norma_result norma_mpi_step(mpi_call *call, double fraction, norma_result mine) {
    if (!mine && norma_core_progress(call->core, fraction)) mine = NORMA_CANCELLED;
    return norma_mpi_agree(call, mine);
}

uint64_t norma_mpi_sum(const mpi_call *call, uint64_t mine) {
    norma_mpi_reduce(call, &mine, 1, MPI_UINT64_T, MPI_SUM);
    return mine;
}

uint64_t norma_mpi_sum_before(const mpi_call *call, uint64_t mine) {
    uint64_t before = 0;
    MPI_Exscan(&mine, &before, 1, MPI_UINT64_T, MPI_SUM, call->comm);
    return call->rank ? before : 0; /* the first rank's is undefined */
}

/* MPICH 4.0 compares numbers without a sign as if they had one: they go as numbers with a sign, in
 * the same order. */
static int64_t with_sign(uint64_t number) {
    int64_t result;
    number ^= UINT64_C(1) << 63;
    memcpy(&result, &number, sizeof result);
    return result;
}

static uint64_t without_sign(int64_t number) {
    uint64_t result;
    memcpy(&result, &number, sizeof result);
    return result ^ UINT64_C(1) << 63;
}

static uint64_t mpi_extreme(const mpi_call *call, uint64_t mine, MPI_Op op) {
    int64_t all = with_sign(mine);
    norma_mpi_reduce(call, &all, 1, MPI_INT64_T, op);
    return without_sign(all);
}

uint64_t norma_mpi_largest(const mpi_call *call, uint64_t mine) {
    return mpi_extreme(call, mine, MPI_MAX);
}
uint64_t norma_mpi_least(const mpi_call *call, uint64_t mine) {
    return mpi_extreme(call, mine, MPI_MIN);
}

uint64_t norma_mpi_largest_before(const mpi_call *call, uint64_t mine) {
    const int64_t number = with_sign(mine);
    int64_t before = 0;
    MPI_Exscan(&number, &before, 1, MPI_INT64_T, MPI_MAX, call->comm);
    return call->rank ? without_sign(before) : 0;
}

/* The largest of each and of its complement: one message instead of many. */
int norma_mpi_all_equal(const mpi_call *call, const uint64_t *numbers, size_t count) {
    enum { AT_ONCE = 16 };
    int64_t extremes[2 * AT_ONCE];
    int equal = 1;
    for (size_t begin = 0, some; begin < count; begin += some) {
        some = count - begin < AT_ONCE ? count - begin : AT_ONCE;
        for (size_t i = 0; i < some; ++i) {
            extremes[2 * i] = with_sign(numbers[begin + i]);
            extremes[2 * i + 1] = with_sign(~numbers[begin + i]);
        }
        norma_mpi_reduce(call, extremes, (int)(2 * some), MPI_INT64_T, MPI_MAX);
        for (size_t i = 0; i < some; ++i)
            equal &= without_sign(extremes[2 * i]) == ~without_sign(extremes[2 * i + 1]);
    }
    return equal;
}

/* ---- lists */

static norma_result allocate_lists(const mpi_call *call, uint64_t total, mpi_lists *lists) {
    const size_t ranks = (size_t)call->ranks;
    if (total > INT_MAX || total * lists->record > SIZE_MAX / 2) return NORMA_ERROR_OVERFLOW;
    lists->capacity = (size_t)total * lists->record;
    lists->bytes = norma_core_allocate(call->core, lists->capacity, 1);
    lists->counts = norma_core_allocate(call->core, ranks, sizeof *lists->counts);
    lists->starts = norma_core_allocate(call->core, ranks + 1, sizeof *lists->starts);
    if (lists->bytes && lists->counts && lists->starts) return NORMA_OK;
    norma_mpi_lists_close(call, lists);
    return NORMA_ERROR_MEMORY;
}

norma_result norma_mpi_lists_open(
    const mpi_call *call, const uint64_t *room, size_t record, mpi_lists *lists) {
    uint64_t total = 0;
    *lists = (mpi_lists){.record = record};
    for (int r = 0; r < call->ranks; ++r) {
        if (room[r] > INT_MAX) return NORMA_ERROR_OVERFLOW;
        total += room[r];
    }
    const norma_result result = allocate_lists(call, total, lists);
    if (result) return result;
    lists->starts[0] = 0;
    for (int r = 0; r < call->ranks; ++r) {
        lists->counts[r] = 0;
        lists->starts[r + 1] = lists->starts[r] + (int)room[r];
    }
    return NORMA_OK;
}

/* As many records as shape has, of another size. */
static norma_result lists_like(
    const mpi_call *call, const mpi_lists *shape, size_t record, mpi_lists *lists) {
    const size_t ranks = (size_t)call->ranks;
    *lists = (mpi_lists){.record = record};
    const norma_result result = allocate_lists(call, (uint64_t)shape->starts[ranks], lists);
    if (result) return result;
    memcpy(lists->counts, shape->counts, ranks * sizeof *lists->counts);
    memcpy(lists->starts, shape->starts, (ranks + 1) * sizeof *lists->starts);
    return NORMA_OK;
}

void norma_mpi_lists_close(const mpi_call *call, mpi_lists *lists) {
    const size_t ranks = (size_t)call->ranks;
    norma_core_release(call->core, lists->bytes, lists->capacity, 1);
    norma_core_release(call->core, lists->counts, ranks, sizeof *lists->counts);
    norma_core_release(call->core, lists->starts, ranks + 1, sizeof *lists->starts);
    *lists = (mpi_lists){0};
}

norma_result norma_mpi_list(const mpi_call *call, const mpi_listing *listing, mpi_lists *lists) {
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    for (size_t i = 0; i < listing->count; ++i) {
        const int rank = listing->rank_of(listing->context, i);
        if (rank >= 0) ++room[rank];
    }
    const norma_result result = norma_mpi_lists_open(call, room, listing->record, lists);
    norma_core_release(call->core, room, ranks, sizeof *room);
    for (size_t i = 0; i < listing->count && !result; ++i) {
        const int rank = listing->rank_of(listing->context, i);
        if (rank >= 0) listing->write(listing->context, i, norma_mpi_lists_add(lists, rank));
    }
    return result;
}

/* ---- exchanging */

static void mpi_pass(mpi_call *call, mpi_cargo cargo, const mpi_lists *out, mpi_lists *in) {
    MPI_Datatype record;
    MPI_Type_contiguous((int)out->record, MPI_BYTE, &record);
    MPI_Type_commit(&record);
    MPI_Alltoallv(out->bytes, out->counts, out->starts, record, in->bytes, in->counts, in->starts,
        record, call->comm);
    MPI_Type_free(&record);
    const size_t records = norma_mpi_lists_total(call, out) - (size_t)out->counts[call->rank];
    call->sent[cargo] += records * out->record;
}

static norma_result open_received(
    const mpi_call *call, const int *counts, size_t record, mpi_lists *in) {
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    for (size_t r = 0; r < ranks; ++r) room[r] = (uint64_t)counts[r];
    const norma_result result = norma_mpi_lists_open(call, room, record, in);
    if (!result) memcpy(in->counts, counts, ranks * sizeof *counts);
    norma_core_release(call->core, room, ranks, sizeof *room);
    return result;
}

norma_result norma_mpi_exchange(
    mpi_call *call, mpi_cargo cargo, norma_result mine, const mpi_lists *out, mpi_lists *in) {
    const size_t ranks = (size_t)call->ranks;
    int *counts = norma_core_allocate(call->core, ranks, sizeof *counts);
    *in = (mpi_lists){0};
    if (!mine && !counts) mine = NORMA_ERROR_MEMORY;
    norma_result result = norma_mpi_agree(call, mine);
    if (!result) {
        MPI_Alltoall(out->counts, 1, MPI_INT, counts, 1, MPI_INT, call->comm);
        result = norma_mpi_agree(call, open_received(call, counts, out->record, in));
        if (!result)
            mpi_pass(call, cargo, out, in);
        else
            norma_mpi_lists_close(call, in);
    }
    norma_core_release(call->core, counts, ranks, sizeof *counts);
    return result;
}

norma_result norma_mpi_ask(mpi_call *call, mpi_cargo cargo, const mpi_listing *listing,
    size_t record, mpi_answer *answer, void *context, mpi_lists *back) {
    mpi_lists out = {0}, in = {0}, answers = {0};
    *back = (mpi_lists){0};
    norma_result result =
        norma_mpi_exchange(call, cargo, norma_mpi_list(call, listing, &out), &out, &in);
    if (!result) {
        norma_result mine = lists_like(call, &in, record, &answers);
        if (!mine) mine = answer(context, &in, &answers);
        if (!mine) mine = lists_like(call, &out, record, back);
        result = norma_mpi_agree(call, mine);
    }
    norma_mpi_lists_close(call, &in);
    norma_mpi_lists_close(call, &out);
    if (!result)
        mpi_pass(call, cargo, &answers, back);
    else
        norma_mpi_lists_close(call, back);
    norma_mpi_lists_close(call, &answers);
    return result;
}
