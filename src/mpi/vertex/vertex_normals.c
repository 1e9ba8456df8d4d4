/* vertex_normals.c: norma_mpi_vertex_normals. Which positions are shared, their sums, and normals
 * handed out; where the sum of a position cancels, once more over the corners of each vertex alone;
 * then those that have no normal. */
#include "core/call/output.h"
#include "mpi/vertex/missing.h"
#include "mpi/vertex/part.h"
#include "mpi/vertex/sums.h"
#include <norma/mpi.h>

typedef struct vertex_work {
    mpi_call *call;
    mpi_part *part;
    uint8_t *take_part; /* of each position: MPI_ABSENT, ...; until it is known who shares it */
    uint8_t *reasons;   /* of each position */
    core_tally tally;
    int once_more; /* sums of positions are behind */
} vertex_work;

static void forget_part(vertex_work *work) {
    norma_core_release(work->call->core, work->take_part, work->part->positions, 1);
    work->take_part = NULL;
}

/* ---- one pass of sums */

static void receive_normal(void *context, size_t v, int reason, const float normal[3]) {
    const vertex_work *work = context;
    work->reasons[v] = (uint8_t)(work->once_more && reason ? NORMA_REASON_CANCELLED : reason);
    if (!reason) norma_core_write_normal(&work->part->output, v, normal);
}

static norma_result sum_and_hand_out(
    vertex_work *work, const mpi_keys *keys, const uint32_t *merge, norma_count *degenerate) {
    mpi_call *call = work->call;
    const size_t budget = work->part->budget;
    const int lend = call->core->options.weight != NORMA_WEIGHT_VISIBLE;
    mpi_sharing sharing;
    norma_result result = norma_mpi_share(call, keys, work->take_part, lend, budget, &sharing);
    forget_part(work);
    if (result != NORMA_OK) return result;
    mpi_sums sums = {.prepared = &work->part->prepared,
        .faces = &work->part->faces,
        .merge = merge,
        .sharing = &sharing,
        .numbered = work->part->numbered,
        .degenerate = degenerate};
    result = norma_mpi_sum_all(call, budget, &sums);
    if (result == NORMA_OK) {
        result = norma_mpi_hand_out(call, &sums, budget, receive_normal, work);
        norma_mpi_sums_close(call, &sums);
    }
    norma_mpi_sharing_close(call, &sharing);
    return result;
}

static uint32_t merged(const uint32_t *merge, size_t v) { return merge ? merge[v] : (uint32_t)v; }

/* Collective. Those that have no normal for this reason, each by the one that stands for it. */
static norma_result take_part(vertex_work *work, const uint32_t *merge, int reason) {
    const core_mesh *mesh = &work->part->prepared.mesh;
    work->take_part = norma_core_allocate(work->call->core, work->part->positions, 1);
    const norma_result result =
        norma_mpi_agree(work->call, work->take_part ? NORMA_OK : NORMA_ERROR_MEMORY);
    if (result != NORMA_OK) return result;
    memset(work->take_part, MPI_ABSENT, work->part->positions);
    for (size_t v = 0; v < work->part->positions; v++)
        if (work->reasons[v] == reason) work->take_part[merged(merge, v)] = MPI_LISTENS;
    for (size_t c = 0; c < mesh->corner_count; c++) {
        const uint32_t v = norma_core_corner(mesh, c);
        if (work->reasons[v] == reason) work->take_part[merged(merge, v)] = MPI_VOTES;
    }
    return NORMA_OK;
}

/* ---- by position */

/* A position that is not finite has no votes, and is equal to nothing that has. */
static void judge_positions(const vertex_work *work) {
    const core_mesh *mesh = &work->part->prepared.mesh;
    for (size_t v = 0; v < work->part->positions; v++) {
        double p[3];
        norma_core_position(mesh, (uint32_t)v, p);
        work->reasons[v] =
            norma_core_finite(p) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    }
}

static norma_result sum_positions(vertex_work *work) {
    const mpi_part *part = work->part;
    const uint32_t *weld = part->prepared.mesh.weld;
    const mpi_keys keys = {&part->prepared.mesh,
        part->groups                                        ? part->groups
        : work->call->core->options.weld == NORMA_WELD_NONE ? part->vertex_ids
                                                            : NULL,
        part->doubles};
    judge_positions(work);
    const norma_result result = take_part(work, weld, NORMA_REASON_UNREFERENCED);
    if (result != NORMA_OK) return result;
    norma_core_stage(work->call->core, 0.2, 0.8);
    return sum_and_hand_out(work, &keys, weld, &work->tally.degenerate);
}

/* ---- where they cancel: by the number of the vertex */

static norma_result sum_own(vertex_work *work) {
    const mpi_part *part = work->part;
    uint32_t *same = NULL;
    uint64_t cancelled = 0;
    for (size_t v = 0; v < part->positions; v++)
        cancelled += work->reasons[v] == NORMA_REASON_CANCELLED;
    if (work->call->core->options.weld == NORMA_WELD_NONE ||
        !norma_mpi_largest(work->call, cancelled))
        return NORMA_OK;
    norma_result result = norma_mpi_agree(work->call,
        norma_mpi_weld_numbers(work->call->core, part->vertex_ids, part->positions, &same));
    if (result == NORMA_OK) {
        const mpi_keys keys = {&part->prepared.mesh, part->vertex_ids, part->doubles};
        result = take_part(work, same, NORMA_REASON_CANCELLED);
        work->once_more = 1;
        if (result == NORMA_OK) result = sum_and_hand_out(work, &keys, same, NULL);
    }
    norma_core_release(work->call->core, same, part->positions, sizeof *same);
    return result;
}

/* ---- all */

static void write_missing(const vertex_work *work) {
    const float none[3] = {0, 0, 0};
    core_tally here = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    for (size_t v = 0; v < work->part->positions; v++) {
        if (work->reasons[v])
            norma_core_write_element(&work->part->output, v, work->reasons[v], none, &here);
        else if (work->part->output.reasons)
            work->part->output.reasons[v] = NORMA_REASON_NONE;
    }
}

static norma_result open_work(vertex_work *work) {
    const core_call *core = work->call->core;
    work->reasons = norma_core_allocate(core, work->part->positions, 1);
    return work->reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static norma_result run(vertex_work *work, norma_report *report) {
    mpi_call *call = work->call;
    norma_result result = norma_mpi_agree(call, open_work(work));
    if (result == NORMA_OK) result = sum_positions(work);
    if (result == NORMA_OK) result = sum_own(work);
    if (result == NORMA_OK)
        result = norma_mpi_count_missing(call, work->part, work->reasons, &work->tally);
    if (result == NORMA_OK) {
        write_missing(work);
        if (work->part->output.nearest)
            result = norma_mpi_fill_nearest(call, work->part, work->reasons);
    }
    norma_core_stage(call->core, 1, 1);
    result = norma_mpi_step(call, 1, result);
    if (result != NORMA_OK) return result;
    norma_mpi_add_tallies(call, &work->tally);
    norma_core_write_report(report, &work->tally, NULL, NULL);
    return NORMA_OK;
}

static norma_result compute(
    mpi_call *call, norma_result begun, const mpi_input *input, norma_report *report) {
    mpi_part part;
    norma_result result = norma_mpi_open_part(call, begun, input, &part);
    if (result != NORMA_OK) return result;
    vertex_work work = {.call = call, .part = &part};
    result = run(&work, report);
    forget_part(&work);
    norma_core_release(call->core, work.reasons, part.positions, 1);
    norma_mpi_close_part(call, &part);
    return result;
}

norma_result norma_mpi_vertex_normals(MPI_Comm comm, const norma_mesh *part,
    const uint64_t *vertex_ids, const uint64_t *face_ids, const norma_options *options,
    float *normals, size_t capacity, norma_report *report) {
    core_call core;
    mpi_call call;
    const mpi_input input = {part, vertex_ids, face_ids, normals, capacity};
    const norma_result begun = norma_core_begin(&core, options);
    const norma_result result = norma_mpi_begin(&call, comm, &core);
    if (result != NORMA_OK) return result;
    const norma_result computed = compute(&call, begun, &input, report);
    norma_mpi_end(&call);
    return computed;
}
