/* ply_compute.c: a binary PLY with a normal for each vertex. */
#include "mpi/file/formats.h"
#include "mpi/file/ply_output.h"
#include <norma/mpi.h>

static int fail_memory(mpi_job *job) {
    return norma_mpi_fail(job, "%s: out of memory", job->input);
}

static int copy_unchanged(mpi_job *job) {
    int failed = norma_mpi_open_output(job, job->size);
    if (!failed) failed = norma_mpi_copy_share(job, 0, 0, job->size);
    return norma_mpi_close_output(job, failed);
}

/* ---- one normal for each vertex */

static int compute_smooth(mpi_job *job, ply_layout *layout, ply_part *part) {
    if (norma_mpi_fetch_positions(job, layout, part)) return 1;
    const size_t count = part->own + part->others;
    norma_mesh mesh = {.corners = part->corner, .corner_count = part->corners};
    mesh.positions.data = part->positions;
    mesh.positions.count = count;
    mesh.positions.format = part->doubles ? NORMA_FORMAT_DOUBLE : NORMA_FORMAT_FLOAT;
    mesh.face_starts = part->face_starts;
    mesh.face_count = part->face_starts ? part->faces : 0;
    float *normals = norma_core_allocate(&job->core, count, 3 * sizeof *normals);
    int failed = norma_mpi_failed(job, normals ? 0 : fail_memory(job));
    if (!failed)
        failed = norma_mpi_failed_result(
            job, norma_mpi_vertex_normals(job->call.comm, &mesh, part->vertex_ids, NULL,
                     &job->options, normals, count, &job->report));
    if (!failed) failed = norma_mpi_failed(job, norma_mpi_plan_output(job, layout));
    if (!failed) failed = norma_mpi_write_ply(job, layout, part, normals);
    norma_core_release(&job->core, normals, count, 3 * sizeof *normals);
    return failed;
}

/* ---- all */

int norma_mpi_compute_ply(mpi_job *job) {
    ply_layout layout = {0};
    ply_part part = {0};
    int failed = norma_mpi_failed(job, norma_mpi_read_layout(job, &layout));
    if (!failed) {
        job->faces = layout.faces;
        job->vertices = layout.vertices;
        failed = norma_mpi_read_faces(job, &layout, &part);
    }
    if (!failed && !norma_mpi_sum(&job->call, part.corners))
        failed = copy_unchanged(job); /* points, which have no normals */
    else if (!failed)
        failed = compute_smooth(job, &layout, &part);
    norma_mpi_close_part_of_ply(job, &part);
    norma_mpi_close_layout(&layout);
    return failed;
}
