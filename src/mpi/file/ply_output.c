/* ply_output.c: rows of vertices are copied with the new normals put in, those of added vertices
 * behind them, faces with new numbers; all else as it is. */
#include "io/format/compute_policy.h"
#include "core/call/sort.h"
#include "mpi/file/ply_output.h"
#include "mpi/file/ply_rows.h"
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

/* ---- added vertices */

enum { WINDOW = 1 << 16 }; /* bytes that are read at once to find rows that lie apart */

/* The rows of some added vertices, in the order of their sources in the file. */
static int copy_sources(mpi_job *job, const row_copy *copy, const ply_added *added, size_t first,
    const uint64_t *order, size_t count, row_blocks *blocks) {
    const ply_layout *l = copy->layout;
    const size_t from = copy->from->fixed_size, to = copy->to->fixed_size,
                 window = from < WINDOW ? WINDOW / from : 1;
    uint64_t held = 0, held_end = 0;
    for (size_t i = 0; i < count; i++) {
        const uint64_t source = order[i] >> 32;
        const size_t at = (size_t)(order[i] & UINT32_MAX);
        if (source >= held_end) {
            held = source;
            held_end = l->vertices - held < window ? l->vertices : held + window;
            if (norma_mpi_read(job, l->vertex_begin + held * from, blocks->from,
                    (size_t)(held_end - held) * from))
                return 1;
        }
        copy_row(copy, blocks->from + (size_t)(source - held) * from,
            added->normals + 3 * (first + at), blocks->to + at * to);
    }
    return 0;
}

static int write_added(
    mpi_job *job, const row_copy *copy, const ply_added *added, row_blocks *blocks) {
    const ply_layout *l = copy->layout;
    const size_t to = copy->to->fixed_size;
    const uint64_t begin = l->header_size + (l->vertex_begin - l->body) + l->vertices * to;
    uint64_t *order = norma_core_allocate(&job->core, blocks->rows, sizeof *order);
    int failed = order ? 0 : fail_memory(job);
    for (size_t v = 0; v < added->count && !failed; v += blocks->rows) {
        const size_t some = added->count - v < blocks->rows ? added->count - v : blocks->rows;
        for (size_t i = 0; i < some; i++) order[i] = (uint64_t)added->sources[v + i] << 32 | i;
        norma_core_sort_numbers(order, some);
        failed = encode(job, copy, added->normals + 3 * v, some) ||
                 copy_sources(job, copy, added, v, order, some, blocks) ||
                 norma_mpi_write(job, begin + (added->first + v) * to, blocks->to, some * to);
    }
    norma_core_release(&job->core, order, blocks->rows, sizeof *order);
    return failed;
}

/* ---- faces with new numbers */

enum { FACE_ROOM = 4 * MPI_BLOCK }; /* a byte may become four */

static ply_type corner_type(const ply_header *header) {
    const ply_element *face = norma_ply_element(header, header->face);
    return norma_ply_property(header, face, header->face_list)->type;
}

/* What each corner takes more than it did. */
static uint64_t growth(const ply_layout *l) {
    return norma_ply_type_size(corner_type(l->to)) - norma_ply_type_size(corner_type(l->from));
}

/* Returns where the row ends in the output. */
static unsigned char *copy_face(
    const ply_layout *l, const unsigned char *row, const uint32_t **corner, unsigned char *to) {
    const ply_header *header = l->from;
    const ply_element *face = norma_ply_element(header, header->face);
    const ply_type type = corner_type(l->to);
    for (int p = 0; p < (int)face->property_count; p++) {
        const ply_property *property = norma_ply_property(header, face, p);
        const int list = norma_ply_is_list(property);
        const size_t size = list ? norma_ply_property_size(header, property, row)
                                 : norma_ply_type_size(property->type);
        const size_t kept =
            p == header->face_list ? norma_ply_type_size(property->count_type) : size;
        memcpy(to, row, kept);
        to += kept;
        for (size_t at = kept; at < size; at += norma_ply_type_size(property->type)) {
            norma_ply_put(to, type, header->encoding, (double)*(*corner)++);
            to += norma_ply_type_size(type);
        }
        row += size;
    }
    return to;
}

static int write_rows(
    mpi_job *job, ply_rows *rows, const ply_part *part, uint64_t begin, unsigned char *block) {
    const uint32_t *corner = part->corner;
    size_t used = 0;
    for (size_t f = 0; f < part->faces; f++) {
        size_t size;
        const unsigned char *row = norma_mpi_next_row(rows, &size);
        if (!row) return 1;
        if (used + 4 * size > FACE_ROOM) {
            if (norma_mpi_write(job, begin, block, used)) return 1;
            begin += used;
            used = 0;
        }
        used = (size_t)(copy_face(rows->layout, row, &corner, block + used) - block);
    }
    return norma_mpi_write(job, begin, block, used);
}

/* begin: of this rank's faces in the output. */
static int write_faces(mpi_job *job, const ply_layout *l, const ply_part *part, uint64_t begin) {
    ply_rows rows;
    unsigned char *block = norma_core_allocate(&job->core, FACE_ROOM, 1);
    const int failed = !block ? fail_memory(job)
                              : norma_mpi_rows_open(job, l, part->begin, &rows) ||
                                    write_rows(job, &rows, part, begin, block);
    if (block) norma_mpi_rows_close(&rows);
    norma_core_release(&job->core, block, FACE_ROOM, 1);
    return failed;
}

/* ---- the output */

/* Bytes of the output at which its parts begin. */
typedef struct output_places {
    uint64_t behind; /* what follows the vertices */
    uint64_t faces;  /* this rank's, where they get new numbers */
    uint64_t rest;   /* what follows the vertices, or the faces where these get new numbers */
    uint64_t end;
} output_places;

/* Collective. */
static output_places place_output(
    const mpi_job *job, const ply_layout *l, const ply_part *part, const ply_added *added) {
    const size_t from = norma_ply_element(l->from, l->from->vertex)->fixed_size,
                 to = norma_ply_element(l->to, l->to->vertex)->fixed_size;
    const uint64_t behind = l->vertex_begin + l->vertices * from,
                   mine = part->end - part->begin + part->corners * growth(l),
                   all = norma_mpi_sum(&job->call, mine),
                   before = norma_mpi_sum_before(&job->call, mine);
    output_places places = {
        .behind = l->header_size + (l->vertex_begin - l->body) + (l->vertices + added->all) * to};
    places.faces = places.behind + (l->face_begin - behind) + before;
    places.rest = added->all ? places.behind + (l->face_begin - behind) + all : places.behind;
    places.end = places.rest + (job->size - (added->all ? part->rest : behind));
    return places;
}

static int write_all_rows(mpi_job *job, const ply_layout *l, const ply_part *part, float *normals,
    const ply_added *added) {
    row_copy copy;
    row_blocks blocks = {0};
    if (open_copy(job, l, &copy)) return 1;
    const int failed = open_blocks(job, &copy, &blocks) ||
                       write_vertices(job, &copy, part, normals, &blocks) ||
                       write_added(job, &copy, added, &blocks);
    close_blocks(job, &blocks);
    free(copy.source);
    return failed;
}

static int write_parts(mpi_job *job, const ply_layout *l, const ply_part *part, float *normals,
    const ply_added *added, const output_places *places) {
    const uint64_t behind =
        l->vertex_begin + l->vertices * norma_ply_element(l->from, l->from->vertex)->fixed_size;
    if (!job->call.rank && norma_mpi_write(job, 0, l->header, l->header_size)) return 1;
    if (norma_mpi_copy_share(job, l->body, l->header_size, l->vertex_begin - l->body)) return 1;
    if (write_all_rows(job, l, part, normals, added)) return 1;
    if (!added->all) return norma_mpi_copy_share(job, behind, places->behind, job->size - behind);
    return norma_mpi_copy_share(job, behind, places->behind, l->face_begin - behind) ||
           write_faces(job, l, part, places->faces) ||
           norma_mpi_copy_share(job, part->rest, places->rest, job->size - part->rest);
}

int norma_mpi_write_ply(mpi_job *job, const ply_layout *layout, const ply_part *part,
    float *normals, const ply_added *added) {
    const output_places places = place_output(job, layout, part, added);
    int failed = norma_mpi_open_output(job, places.end);
    if (!failed) failed = write_parts(job, layout, part, normals, added, &places);
    return norma_mpi_close_output(job, failed);
}
