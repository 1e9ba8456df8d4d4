/* ply_compute.c: a binary PLY with a normal for each vertex: rows are copied with the new ones put
 * in, all else as it is. */
#include "mpi/file/formats.h"
#include "mpi/file/ply_faces.h"
#include "io/format/compute_policy.h"
#include <norma/mpi.h>
#include <stdlib.h>

static int fail_memory(mpi_job *job) {
    return norma_mpi_fail(job, "%s: out of memory", job->input);
}

/* ---- rows of vertices */

typedef struct row_copy {
    const ply_layout *layout;
    const ply_element *from, *to;
    ply_type types[3]; /* of the normals in the output */
    int *source; /* of each property of the output, its offset in the input's row, or -1 - axis
                  */
} row_copy;

static int same_name(const ply_layout *l, const ply_property *a, const ply_property *b) {
    return a->name.length == b->name.length &&
           memcmp(l->written + a->name.offset, l->small + b->name.offset, a->name.length) == 0;
}

static int source_of(const ply_layout *l, const row_copy *copy, int property) {
    for (int axis = 0; axis < 3; axis++)
        if (l->to->normal[axis] == property) return -1 - axis;
    const ply_property *wanted = norma_ply_property(l->to, copy->to, property);
    for (int p = 0; p < (int)copy->from->property_count; p++)
        if (same_name(l, wanted, norma_ply_property(l->from, copy->from, p)))
            return (int)norma_mpi_offset_in_row(l->from, copy->from, p);
    return 0;
}

static int open_copy(mpi_job *job, const ply_layout *layout, row_copy *copy) {
    *copy = (row_copy){.layout = layout,
        .from = norma_ply_element(layout->from, layout->from->vertex),
        .to = norma_ply_element(layout->to, layout->to->vertex)};
    copy->source = malloc(copy->to->property_count * sizeof *copy->source);
    if (!copy->source) return fail_memory(job);
    for (int axis = 0; axis < 3; axis++)
        copy->types[axis] =
            norma_ply_property(layout->to, copy->to, layout->to->normal[axis])->type;
    for (size_t p = 0; p < copy->to->property_count; p++)
        copy->source[p] = source_of(layout, copy, (int)p);
    return 0;
}

static void copy_row(
    const row_copy *copy, const unsigned char *from, const float normal[3], unsigned char *to) {
    const ply_header *header = copy->layout->to;
    for (size_t p = 0; p < copy->to->property_count; p++) {
        const ply_type type = norma_ply_property(header, copy->to, (int)p)->type;
        if (copy->source[p] >= 0)
            memcpy(to, from + copy->source[p], norma_ply_type_size(type));
        else
            norma_ply_put(to, type, header->encoding, (double)normal[-1 - copy->source[p]]);
        to += norma_ply_type_size(type);
    }
}

static void keep_zero_signs(
    const ply_layout *l, const row_copy *copy, const unsigned char *row, float normal[3]) {
    for (int axis = 0; axis < 3; axis++) {
        const int p = l->from->normal[axis];
        const double stored = norma_ply_get(row + norma_mpi_offset_in_row(l->from, copy->from, p),
            norma_ply_property(l->from, copy->from, p)->type, l->from->encoding);
        normal[axis] = norma_policy_keep_zero(normal[axis], stored);
    }
}

/* The rows from the v-th own vertex on; normals are as they will be stored. */
static int write_some(mpi_job *job, const row_copy *copy, const ply_part *part, size_t v,
    size_t count, float *normals, unsigned char *blocks[2]) {
    const ply_layout *l = copy->layout;
    const size_t from = copy->from->fixed_size, to = copy->to->fixed_size;
    const uint64_t first = part->first + v,
                   begin = l->header_size + (l->vertex_begin - l->body) + first * to;
    if (norma_mpi_read(job, l->vertex_begin + first * from, blocks[0], count * from)) return 1;
    for (size_t i = 0; i < count; i++) {
        if (l->has_normals) keep_zero_signs(l, copy, blocks[0] + i * from, normals + 3 * i);
        copy_row(copy, blocks[0] + i * from, normals + 3 * i, blocks[1] + i * to);
    }
    return norma_mpi_write(job, begin, blocks[1], count * to);
}

static int encode(mpi_job *job, const row_copy *copy, float *normals, size_t count) {
    norma_document_error error;
    for (size_t i = 0; i < count; i++) norma_policy_point_up(normals + 3 * i);
    if (norma_ply_encode_normals(copy->layout->before, copy->types, normals, count, &error) ==
        NORMA_DOCUMENT_OK)
        return 0;
    return norma_mpi_fail(job, "%s", error.message);
}

static int write_vertices(
    mpi_job *job, const ply_layout *layout, const ply_part *part, float *normals) {
    row_copy copy;
    if (open_copy(job, layout, &copy)) return 1;
    const size_t widest = copy.to->fixed_size > copy.from->fixed_size ? copy.to->fixed_size
                                                                      : copy.from->fixed_size,
                 rows = MPI_BLOCK / widest;
    unsigned char *blocks[2] = {norma_core_allocate(&job->core, MPI_BLOCK, 1),
        norma_core_allocate(&job->core, MPI_BLOCK, 1)};
    int failed = blocks[0] && blocks[1] ? 0 : fail_memory(job);
    for (size_t v = 0; v < part->own && !failed; v += rows) {
        const size_t some = part->own - v < rows ? part->own - v : rows;
        failed = encode(job, &copy, normals + 3 * v, some) ||
                 write_some(job, &copy, part, v, some, normals + 3 * v, blocks);
    }
    norma_core_release(&job->core, blocks[0], MPI_BLOCK, 1);
    norma_core_release(&job->core, blocks[1], MPI_BLOCK, 1);
    free(copy.source);
    return failed;
}

/* ---- the output */

static int write_all(mpi_job *job, const ply_layout *l, const ply_part *part, float *normals) {
    const size_t from = norma_ply_element(l->from, l->from->vertex)->fixed_size,
                 to = norma_ply_element(l->to, l->to->vertex)->fixed_size;
    const uint64_t before = l->vertex_begin - l->body,
                   behind = l->vertex_begin + l->vertices * from,
                   begin = l->header_size + before + l->vertices * to;
    int failed = norma_mpi_open_output(job, begin + (job->size - behind));
    if (!failed) {
        if (!job->call.rank) failed = norma_mpi_write(job, 0, l->header, l->header_size);
        failed = failed || norma_mpi_copy_share(job, l->body, l->header_size, before) ||
                 write_vertices(job, l, part, normals) ||
                 norma_mpi_copy_share(job, behind, begin, job->size - behind);
    }
    return norma_mpi_close_output(job, failed);
}

static int copy_unchanged(mpi_job *job) {
    int failed = norma_mpi_open_output(job, job->size);
    if (!failed) failed = norma_mpi_copy_share(job, 0, 0, job->size);
    return norma_mpi_close_output(job, failed);
}

static int compute_part(mpi_job *job, const ply_layout *layout, ply_part *part) {
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
    if (!failed) failed = write_all(job, layout, part, normals);
    norma_core_release(&job->core, normals, count, 3 * sizeof *normals);
    return failed;
}

int norma_mpi_compute_ply(mpi_job *job) {
    ply_layout layout;
    ply_part part = {0};
    int failed = norma_mpi_failed(job, norma_mpi_read_layout(job, &layout));
    if (!failed) {
        job->faces = layout.faces;
        job->vertices = layout.vertices;
        failed = norma_mpi_read_faces(job, &layout, &part);
    }
    if (!failed && !norma_mpi_sum(&job->call, part.corners)) {
        failed = copy_unchanged(job); /* points, which have no normals */
    } else if (!failed) {
        failed = norma_mpi_fetch_positions(job, &layout, &part);
        if (!failed) failed = compute_part(job, &layout, &part);
    }
    norma_mpi_close_part_of_ply(job, &part);
    norma_mpi_close_layout(&layout);
    return failed;
}
