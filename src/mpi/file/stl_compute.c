/* stl_compute.c: facet normals of a binary STL, a block at a time. Facets without a direction take
 * the normal of the nearest that has one; only where there are such are positions and normals kept.
 */
#include "mpi/file/shared_file.h"
#include "io/format/format.h"
#include "io/stl/stl.h"
#include "mpi/vertex/vertex.h"

enum { FACETS = MPI_BLOCK / STL_FACET };

typedef struct stl_part {
    mpi_job *job;
    uint64_t first; /* this rank's facets: count of them, from first on */
    size_t count;
    unsigned char *block;       /* an STL of FACETS facets */
    float *positions, *normals; /* of the facets of a block */
    uint8_t *reasons;
    core_tally tally;
    int keep;                             /* what follows is kept of all facets */
    float *kept_positions, *kept_normals; /* first corners */
    uint8_t *kept_reasons;
    uint64_t *ids;
} stl_part;

static int facets_fail_memory(mpi_job *job) {
    return norma_mpi_fail(job, "%s: out of memory", job->input);
}

static int facets_open_part(stl_part *p) {
    const core_call *core = &p->job->core;
    p->block = norma_core_allocate(core, STL_HEADER + FACETS * STL_FACET, 1);
    p->positions = norma_core_allocate(core, FACETS, 9 * sizeof *p->positions);
    p->normals = norma_core_allocate(core, FACETS, 3 * sizeof *p->normals);
    p->reasons = norma_core_allocate(core, FACETS, 1);
    return p->block && p->positions && p->normals && p->reasons ? 0 : facets_fail_memory(p->job);
}

static int open_kept(stl_part *p) {
    const core_call *core = &p->job->core;
    p->kept_positions = norma_core_allocate(core, p->count, 3 * sizeof *p->kept_positions);
    p->kept_normals = norma_core_allocate(core, p->count, 3 * sizeof *p->kept_normals);
    p->kept_reasons = norma_core_allocate(core, p->count, 1);
    p->ids = norma_core_allocate(core, p->count, sizeof *p->ids);
    p->keep = p->kept_positions && p->kept_normals && p->kept_reasons && p->ids;
    for (size_t i = 0; i < p->count && p->keep; i++) p->ids[i] = p->first + i;
    return p->keep ? 0 : facets_fail_memory(p->job);
}

static void facets_close_part(stl_part *p) {
    const core_call *core = &p->job->core;
    norma_core_release(core, p->block, STL_HEADER + FACETS * STL_FACET, 1);
    norma_core_release(core, p->positions, FACETS, 9 * sizeof *p->positions);
    norma_core_release(core, p->normals, FACETS, 3 * sizeof *p->normals);
    norma_core_release(core, p->reasons, FACETS, 1);
    norma_core_release(core, p->kept_positions, p->count, 3 * sizeof *p->kept_positions);
    norma_core_release(core, p->kept_normals, p->count, 3 * sizeof *p->kept_normals);
    norma_core_release(core, p->kept_reasons, p->count, 1);
    norma_core_release(core, p->ids, p->count, sizeof *p->ids);
}

/* ---- a block */

static uint64_t offset_of(const stl_part *p, size_t i) {
    return STL_HEADER + (p->first + i) * STL_FACET;
}

static int facets_compute_block(stl_part *p, size_t begin, size_t count) {
    const stl_state state = {.bytes = p->block, .binary = 1, .facets = count};
    norma_options options = p->job->options;
    if (norma_mpi_read(p->job, offset_of(p, begin), p->block + STL_HEADER, count * STL_FACET))
        return 1;
    for (size_t i = 0; i < count; i++) norma_stl_load(&state, i, NULL, p->positions + 9 * i);
    const norma_mesh mesh = {
        .positions = {.data = p->positions, .count = 3 * count}, .corner_count = 3 * count};
    options.reasons = p->reasons;
    options.fallback = NORMA_FALLBACK_ZERO;
    const norma_result result = norma_face_normals(&mesh, &options, p->normals, count, NULL);
    if (result != NORMA_OK)
        return norma_mpi_fail(p->job, "%s: %s", p->job->input, norma_result_text(result));
    for (size_t i = 0; i < count; i++) {
        if (!p->keep) norma_core_tally(&p->tally, p->reasons[i], (size_t)p->first + begin + i);
        if (p->keep)
            memcpy(p->kept_positions + 3 * (begin + i), p->positions + 9 * i, 3 * sizeof(float));
    }
    if (p->keep) memcpy(p->kept_normals + 3 * begin, p->normals, count * 3 * sizeof(float));
    if (p->keep) memcpy(p->kept_reasons + begin, p->reasons, count);
    return 0;
}

static int facets_write_block(stl_part *p, size_t begin, size_t count, float *normals) {
    for (size_t i = 0; i < count; i++) norma_policy_point_up(normals + 3 * i);
    norma_stl_replace_normals(p->block, 0, count, normals);
    return norma_mpi_write(p->job, offset_of(p, begin), p->block + STL_HEADER, count * STL_FACET);
}

static int for_blocks(stl_part *p, int read, int write) {
    int failed = 0;
    for (size_t at = 0; at < p->count && !failed; at += FACETS) {
        const size_t count = p->count - at < FACETS ? p->count - at : FACETS;
        if (read) failed = facets_compute_block(p, at, count);
        if (!failed && !read)
            failed =
                norma_mpi_read(p->job, offset_of(p, at), p->block + STL_HEADER, count * STL_FACET);
        if (!failed && write)
            failed = facets_write_block(p, at, count, read ? p->normals : p->kept_normals + 3 * at);
    }
    return failed;
}

/* ---- facets without a direction */

static int fill_missing(stl_part *p) {
    mpi_part sites = {.vertex_ids = p->ids, .positions = p->count};
    norma_mesh mesh = {.positions = {.data = p->kept_positions, .count = p->count}};
    norma_result result = norma_core_mesh_shape(&mesh, &sites.prepared.mesh);
    if (result == NORMA_OK)
        result = norma_core_output_open(
            &p->job->core, p->kept_normals, p->count, p->count, &sites.output);
    if (norma_mpi_failed_result(p->job, result)) return 1;
    return norma_mpi_failed_result(
        p->job, norma_mpi_fill_nearest(&p->job->call, &sites, p->kept_reasons));
}

static int facets_run(stl_part *p) {
    mpi_job *job = p->job;
    int failed = norma_mpi_failed(job, facets_open_part(p));
    if (!failed) failed = norma_mpi_open_output(job, job->size);
    if (!failed && !job->call.rank)
        failed = norma_mpi_read(job, 0, p->block, STL_HEADER) ||
                 norma_mpi_write(job, 0, p->block, STL_HEADER);
    if (!failed) failed = for_blocks(p, 1, 1);
    failed = norma_mpi_failed(job, failed);
    norma_mpi_add_tallies(&job->call, &p->tally);
    norma_core_write_report(&job->report, &p->tally, NULL, NULL);
    if (!failed && p->tally.degenerate.count + p->tally.non_finite.count) {
        failed = norma_mpi_failed(job, open_kept(p) || for_blocks(p, 1, 0));
        if (!failed) failed = fill_missing(p);
        if (!failed) failed = for_blocks(p, 0, 1);
    }
    return norma_mpi_close_output(job, failed);
}

int norma_mpi_compute_stl(mpi_job *job) {
    stl_part part = {.job = job};
    uint32_t facets = 0;
    unsigned char header[STL_HEADER];
    int failed = job->size < STL_HEADER ? 0 : norma_mpi_read(job, 0, header, sizeof header);
    if (norma_mpi_failed(job, failed)) return 1;
    for (int i = 0; i < 4; i++) facets |= (uint32_t)header[80 + i] << (8 * i);
    if (job->size < STL_HEADER || job->size != STL_HEADER + (uint64_t)facets * STL_FACET)
        return norma_mpi_fail(job,
            "%s: is not a complete binary STL; norma-mpi does not read ASCII, use norma compute",
            job->input);
    part.first = norma_mpi_share_of(job, facets, job->call.rank);
    part.count = (size_t)(norma_mpi_share_of(job, facets, job->call.rank + 1) - part.first);
    job->faces = facets;
    job->vertices = 3 * (uint64_t)facets;
    failed = facets_run(&part);
    facets_close_part(&part);
    return failed;
}
