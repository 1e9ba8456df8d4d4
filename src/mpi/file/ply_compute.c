/* ply_compute.c: a binary PLY with a normal for each vertex: smooth, or cut at creases. */
#include "core/mesh/input_mesh.h"
#include "mpi/file/formats.h"
#include "mpi/file/ply_classes.h"
#include "mpi/file/ply_number.h"
#include "mpi/file/ply_output.h"
#include "mpi/vertex/missing.h"
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
    const ply_added none = {0};
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
    if (!failed) failed = norma_mpi_failed(job, norma_mpi_plan_output(job, 0, layout));
    if (!failed) failed = norma_mpi_write_ply(job, layout, part, normals, &none);
    norma_core_release(&job->core, normals, count, 3 * sizeof *normals);
    return failed;
}

/* ---- cut at creases */

/* Collective: positions in doubles are read times one power of two on all ranks. */
static double agree_on_scale(const mpi_job *job, const ply_part *part) {
    const core_mesh mesh = norma_mpi_own_positions(part, 1);
    double mine = part->doubles ? norma_core_largest_coordinate(&mesh) : 0, all = 0;
    MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE, MPI_MAX, job->call.comm);
    return part->doubles ? norma_core_scale_for(all) : 1;
}

static void count_reasons(const mpi_job *job, const ply_creased *creased, norma_report *report) {
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    for (size_t v = 0; v < creased->own; v++) norma_core_tally(&tally, creased->reasons[v], v);
    norma_mpi_add_tallies(&job->call, &tally);
    report->non_finite = tally.non_finite;
    report->unreferenced = tally.unreferenced;
    report->cancelled = tally.cancelled;
}

static void sum_report(mpi_job *job, const ply_part *part, const ply_split *split) {
    const mpi_call *call = &job->call;
    const norma_report *mine = &split->report;
    size_t empty = 0;
    for (size_t f = 0; part->face_starts && f < part->faces; f++)
        empty += part->face_starts[f] == part->face_starts[f + 1];
    job->report.degenerate_faces.count =
        (size_t)norma_mpi_sum(call, mine->degenerate_faces.count + empty);
    job->report.non_manifold_edges.count =
        (size_t)norma_mpi_sum(call, mine->non_manifold_edges.count);
    job->report.winding_conflicts.count =
        (size_t)norma_mpi_sum(call, mine->winding_conflicts.count);
    job->hard_edges = norma_mpi_sum(call, split->edges.hard);
}

static norma_result fill_from_nearest(
    mpi_job *job, const ply_part *part, double scale, ply_creased *creased) {
    const core_mesh mesh = norma_mpi_own_positions(part, scale);
    const mpi_part own = {.prepared = {.mesh = mesh},
        .output = {.normals = (unsigned char *)creased->normals, .stride = 3 * sizeof(float)},
        .vertex_ids = creased->sites,
        .positions = creased->own};
    for (size_t v = 0; v < creased->own; v++) {
        double p[3];
        norma_core_position(&mesh, (uint32_t)v, p);
        if (creased->reasons[v] && !norma_core_finite(p))
            creased->reasons[v] = NORMA_REASON_NON_FINITE;
    }
    count_reasons(job, creased, &job->report);
    return norma_mpi_fill_nearest(&job->call, &own, creased->reasons);
}

/* Collective: vertices without a normal get that of the nearest corner that has one. */
static int fill_missing(
    mpi_job *job, const ply_layout *layout, double scale, ply_part *own, ply_creased *creased) {
    size_t missing = 0;
    for (size_t v = 0; v < creased->own; v++) missing += creased->reasons[v] != NORMA_REASON_NONE;
    if (!norma_mpi_largest(&job->call, missing)) return 0;
    return norma_mpi_failed(job, norma_mpi_read_positions(job, layout, own)) ||
           norma_mpi_failed_result(job, fill_from_nearest(job, own, scale, creased));
}

static int split_and_number(mpi_job *job, const ply_layout *layout, double scale, ply_part *part,
    uint32_t **classes, ply_creased *creased) {
    ply_near near = {0};
    ply_split split = {0};
    int failed = norma_mpi_gather_near(job, layout, part, *classes, &near);
    norma_core_release(&job->core, *classes, part->own, sizeof **classes);
    *classes = NULL;
    if (!failed) failed = norma_mpi_split_near(job, layout->vertices, scale, &near, &split);
    norma_mpi_release_positions(job, &near.part);
    if (!failed) {
        sum_report(job, part, &split);
        failed = norma_mpi_number_vertices(job, layout, &near, &split, part, creased);
    }
    norma_mpi_close_split(job, &split);
    norma_mpi_close_near(job, &near);
    return failed;
}

static int number_and_write(mpi_job *job, ply_layout *layout, double scale, ply_part *part,
    ply_part *own, ply_creased *creased) {
    uint32_t *classes = NULL;
    int failed = norma_mpi_failed_result(job, norma_mpi_find_classes(job, own, scale, &classes));
    norma_mpi_release_positions(job, own);
    if (!failed) failed = split_and_number(job, layout, scale, part, &classes, creased);
    norma_core_release(&job->core, classes, own->own, sizeof *classes);
    if (!failed)
        failed = fill_missing(job, layout, scale, own, creased) ||
                 norma_mpi_failed(job, norma_mpi_plan_output(job, creased->added.all, layout)) ||
                 norma_mpi_write_ply(job, layout, part, creased->normals, &creased->added);
    job->added = creased->added.all;
    return failed;
}

static int compute_creased(mpi_job *job, ply_layout *layout, ply_part *part) {
    ply_part own = {.first = part->first, .own = part->own};
    ply_creased creased = {0};
    int failed = norma_mpi_failed(job, norma_mpi_read_positions(job, layout, &own));
    if (!failed)
        failed = number_and_write(job, layout, agree_on_scale(job, &own), part, &own, &creased);
    norma_mpi_close_creased(job, &creased);
    norma_mpi_close_part_of_ply(job, &own);
    return failed;
}

/* ---- all */

/* Collective: what the library does not compare where creases are asked for. */
static int check_same_options(mpi_job *job) {
    const norma_options *o = &job->options;
    uint64_t numbers[6] = {(uint64_t)o->weight, (uint64_t)o->weld, (uint64_t)o->non_manifold,
        (uint64_t)job->creased, 0, 0};
    memcpy(&numbers[4], &o->weld_distance, sizeof numbers[4]);
    memcpy(&numbers[5], &job->crease_angle_rad, sizeof numbers[5]);
    const int same = norma_mpi_all_equal(&job->call, numbers, sizeof numbers / sizeof *numbers);
    return norma_mpi_failed(
        job, same ? 0 : norma_mpi_fail(job, "%s: ranks were given different options", job->input));
}

int norma_mpi_compute_ply(mpi_job *job) {
    ply_layout layout = {0};
    ply_part part = {0};
    int failed =
        check_same_options(job) || norma_mpi_failed(job, norma_mpi_read_layout(job, &layout));
    if (!failed) {
        job->faces = layout.faces;
        job->vertices = layout.vertices;
        failed = norma_mpi_read_faces(job, &layout, &part);
    }
    if (!failed && !norma_mpi_sum(&job->call, part.corners))
        failed = copy_unchanged(job); /* points, which have no normals */
    else if (!failed)
        failed = job->creased ? compute_creased(job, &layout, &part)
                              : compute_smooth(job, &layout, &part);
    norma_mpi_close_part_of_ply(job, &part);
    norma_mpi_close_layout(&layout);
    return failed;
}
