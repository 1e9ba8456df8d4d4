/* ply_output.c: rows of vertices are copied with the new normals put in; all else as it is. */
#include "io/format/compute_policy.h"
#include "mpi/file/ply_output.h"
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

typedef struct row_blocks {
    unsigned char *from, *to; /* MPI_BLOCK bytes each */
    size_t rows;              /* that fit into both */
} row_blocks;

/* The rows from the v-th own vertex on; normals are as they will be stored. */
static int write_some(mpi_job *job, const row_copy *copy, const ply_part *part, size_t v,
    size_t count, float *normals, row_blocks *blocks) {
    const ply_layout *l = copy->layout;
    const size_t from = copy->from->fixed_size, to = copy->to->fixed_size;
    const uint64_t first = part->first + v,
                   begin = l->header_size + (l->vertex_begin - l->body) + first * to;
    if (norma_mpi_read(job, l->vertex_begin + first * from, blocks->from, count * from)) return 1;
    for (size_t i = 0; i < count; i++) {
        if (l->has_normals) keep_zero_signs(l, copy, blocks->from + i * from, normals + 3 * i);
        copy_row(copy, blocks->from + i * from, normals + 3 * i, blocks->to + i * to);
    }
    return norma_mpi_write(job, begin, blocks->to, count * to);
}

static int encode(mpi_job *job, const row_copy *copy, float *normals, size_t count) {
    norma_document_error error;
    for (size_t i = 0; i < count; i++) norma_policy_point_up(normals + 3 * i);
    if (norma_ply_encode_normals(copy->layout->before, copy->types, normals, count, &error) ==
        NORMA_DOCUMENT_OK)
        return 0;
    return norma_mpi_fail(job, "%s", error.message);
}

static int open_blocks(mpi_job *job, const row_copy *copy, row_blocks *blocks) {
    const size_t from = copy->from->fixed_size, to = copy->to->fixed_size;
    *blocks = (row_blocks){.from = norma_core_allocate(&job->core, MPI_BLOCK, 1),
        .to = norma_core_allocate(&job->core, MPI_BLOCK, 1),
        .rows = MPI_BLOCK / (to > from ? to : from)};
    return blocks->from && blocks->to ? 0 : fail_memory(job);
}

static void close_blocks(mpi_job *job, row_blocks *blocks) {
    norma_core_release(&job->core, blocks->from, MPI_BLOCK, 1);
    norma_core_release(&job->core, blocks->to, MPI_BLOCK, 1);
}

static int write_vertices(
    mpi_job *job, const row_copy *copy, const ply_part *part, float *normals, row_blocks *blocks) {
    int failed = 0;
    for (size_t v = 0; v < part->own && !failed; v += blocks->rows) {
        const size_t some = part->own - v < blocks->rows ? part->own - v : blocks->rows;
        failed = encode(job, copy, normals + 3 * v, some) ||
                 write_some(job, copy, part, v, some, normals + 3 * v, blocks);
    }
    return failed;
}

/* ---- the output */

static int write_all_rows(mpi_job *job, const ply_layout *l, const ply_part *part, float *normals) {
    row_copy copy;
    row_blocks blocks = {0};
    if (open_copy(job, l, &copy)) return 1;
    const int failed =
        open_blocks(job, &copy, &blocks) || write_vertices(job, &copy, part, normals, &blocks);
    close_blocks(job, &blocks);
    free(copy.source);
    return failed;
}

int norma_mpi_write_ply(mpi_job *job, const ply_layout *l, const ply_part *part, float *normals) {
    const uint64_t head = l->vertex_begin - l->body,
                   from = norma_ply_element(l->from, l->from->vertex)->fixed_size,
                   to = norma_ply_element(l->to, l->to->vertex)->fixed_size,
                   behind = l->vertex_begin + l->vertices * from,
                   behind_there = l->header_size + head + l->vertices * to;
    int failed = norma_mpi_open_output(job, behind_there + (job->size - behind));
    if (!failed && !job->call.rank) failed = norma_mpi_write(job, 0, l->header, l->header_size);
    if (!failed)
        failed = norma_mpi_copy_share(job, l->body, l->header_size, head) ||
                 write_all_rows(job, l, part, normals) ||
                 norma_mpi_copy_share(job, behind, behind_there, job->size - behind);
    return norma_mpi_close_output(job, failed);
}
