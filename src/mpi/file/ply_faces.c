/* ply_faces.c: each rank reads a range of faces. Where all are triangles, rows have one size, and
 * each rank knows where its own begin; else the first rank goes through all rows once and tells. */
#include "mpi/file/ply_rows.h"

static int fail_memory(mpi_job *job) {
    return norma_mpi_fail(job, "%s: out of memory", job->input);
}

/* ---- where each rank's faces begin */

static size_t triangle_row(const ply_layout *layout) {
    const ply_element *element = norma_ply_element(layout->from, layout->from->face);
    const ply_property *list = norma_ply_property(layout->from, element, layout->from->face_list);
    return element->list_count == 1 ? element->fixed_size + 3 * norma_ply_type_size(list->type) : 0;
}

static size_t list_offset(const ply_layout *layout) {
    return norma_mpi_offset_in_row(
        layout->from, norma_ply_element(layout->from, layout->from->face), layout->from->face_list);
}

static uint64_t begin_of(const mpi_job *job, const ply_layout *layout, int rank) {
    return norma_mpi_share_of(job, layout->faces, rank);
}

/* Whether the rows of this rank, were all triangles, say so. *all: 0 where one does not. */
static int are_triangles(mpi_job *job, const ply_layout *layout, int *all) {
    const size_t row = triangle_row(layout), offset = list_offset(layout),
                 rows = row ? MPI_BLOCK / row : 0;
    const ply_element *element = norma_ply_element(layout->from, layout->from->face);
    const ply_property *list = norma_ply_property(layout->from, element, layout->from->face_list);
    const uint64_t end = begin_of(job, layout, job->call.rank + 1);
    unsigned char *block = norma_core_allocate(&job->core, MPI_BLOCK, 1);
    int failed = block ? 0 : fail_memory(job);
    *all = row && layout->faces <= (job->size - layout->face_begin) / row;
    for (uint64_t f = begin_of(job, layout, job->call.rank); f < end && *all && !failed;) {
        const size_t some = end - f < rows ? (size_t)(end - f) : rows;
        failed = norma_mpi_read(job, layout->face_begin + f * row, block, some * row);
        for (size_t i = 0; i < some && !failed; i++)
            *all &= norma_ply_get_integer(
                        block + i * row + offset, list->count_type, layout->from->encoding) == 3;
        f += some;
    }
    norma_core_release(&job->core, block, MPI_BLOCK, 1);
    return failed;
}

static int find_begins(mpi_job *job, const ply_layout *layout, uint64_t *begins) {
    ply_rows reader;
    int failed = norma_mpi_rows_open(job, layout, layout->face_begin, &reader), rank = 0;
    for (uint64_t f = 0; f <= layout->faces && !failed; f++) {
        size_t size;
        for (; rank <= job->call.ranks && begin_of(job, layout, rank) == f; rank++)
            begins[rank] = norma_mpi_place_in_file(&reader);
        failed = f < layout->faces && !norma_mpi_next_row(&reader, &size);
    }
    norma_mpi_rows_close(&reader);
    return failed;
}

/* begins: of each rank, and the end. */
static int place_faces(mpi_job *job, const ply_layout *layout, uint64_t *begins, int *triangles) {
    int all = 0;
    const int failed = are_triangles(job, layout, &all);
    if (norma_mpi_failed(job, failed)) return 1;
    *triangles = norma_mpi_largest(&job->call, (uint64_t)!all) == 0;
    for (int r = 0; r <= job->call.ranks && *triangles; r++)
        begins[r] = layout->face_begin + begin_of(job, layout, r) * triangle_row(layout);
    if (*triangles) return 0;
    if (norma_mpi_failed(job, job->call.rank ? 0 : find_begins(job, layout, begins))) return 1;
    MPI_Bcast(begins, job->call.ranks + 1, MPI_UINT64_T, 0, job->call.comm);
    return 0;
}

/* ---- corners */

static int grow_corners(mpi_job *job, ply_part *part, size_t more) {
    if (part->corners + more <= part->corner_room) return 0;
    const size_t room = part->corners + more + part->corner_room / 2 + 1024;
    uint32_t *corner =
        room > UINT32_MAX ? NULL : norma_core_allocate(&job->core, room, sizeof *corner);
    if (!corner) return fail_memory(job);
    if (part->corners) memcpy(corner, part->corner, part->corners * sizeof *corner);
    norma_core_release(&job->core, part->corner, part->corner_room, sizeof *corner);
    part->corner = corner;
    part->corner_room = room;
    return 0;
}

/* at: where the row lies in the file. */
static int fail_index(
    mpi_job *job, const ply_layout *layout, uint64_t at, uint64_t face, int64_t vertex) {
    return norma_mpi_fail(job,
        "%s:byte %llu: face %llu names vertex %lld; vertices are numbered from 0 to %lld",
        job->input, (unsigned long long)at, (unsigned long long)face, (long long)vertex,
        (long long)layout->vertices - 1);
}

static int take_row(
    const ply_rows *rows, const unsigned char *row, size_t size, uint64_t face, ply_part *part) {
    mpi_job *job = rows->job;
    const ply_layout *layout = rows->layout;
    const ply_header *header = layout->from;
    const ply_element *element = norma_ply_element(header, header->face);
    for (int p = 0; p < header->face_list; p++)
        row += norma_ply_property_size(header, norma_ply_property(header, element, p), row);
    const ply_property *list = norma_ply_property(header, element, header->face_list);
    const int64_t count = norma_ply_get_integer(row, list->count_type, header->encoding);
    row += norma_ply_type_size(list->count_type);
    if (count > 0 && grow_corners(job, part, (size_t)count)) return 1;
    for (int64_t i = 0; i < count; i++, row += norma_ply_type_size(list->type)) {
        const int64_t vertex = norma_ply_get_integer(row, list->type, header->encoding);
        if (vertex < 0 || (uint64_t)vertex >= layout->vertices)
            return fail_index(job, layout, norma_mpi_place_in_file(rows) - size, face, vertex);
        part->corner[part->corners++] = (uint32_t)vertex;
    }
    return 0;
}

static int read_rows(mpi_job *job, const ply_layout *layout, uint64_t begin, ply_part *part) {
    const uint64_t first = begin_of(job, layout, job->call.rank);
    ply_rows reader;
    int failed = norma_mpi_rows_open(job, layout, begin, &reader);
    for (size_t f = 0; f < part->faces && !failed; f++) {
        size_t size;
        const unsigned char *row = norma_mpi_next_row(&reader, &size);
        failed = !row || take_row(&reader, row, size, first + f, part);
        if (part->face_starts) part->face_starts[f + 1] = (uint32_t)part->corners;
    }
    norma_mpi_rows_close(&reader);
    return failed;
}

static int open_faces(mpi_job *job, int triangles, ply_part *part) {
    if (part->faces >= UINT32_MAX / 3) return fail_memory(job);
    if (grow_corners(job, part, 3 * part->faces)) return 1;
    if (triangles) return 0;
    part->start_room = part->faces + 1;
    part->face_starts =
        norma_core_allocate(&job->core, part->start_room, sizeof *part->face_starts);
    if (!part->face_starts) return fail_memory(job);
    part->face_starts[0] = 0;
    return 0;
}

int norma_mpi_read_faces(mpi_job *job, const ply_layout *layout, ply_part *part) {
    const size_t ranks = (size_t)job->call.ranks;
    int triangles = 0;
    *part = (ply_part){0};
    part->first = norma_mpi_share_of(job, layout->vertices, job->call.rank);
    part->own =
        (size_t)(norma_mpi_share_of(job, layout->vertices, job->call.rank + 1) - part->first);
    part->faces =
        (size_t)(begin_of(job, layout, job->call.rank + 1) - begin_of(job, layout, job->call.rank));
    uint64_t *begins = norma_core_allocate(&job->core, ranks + 1, sizeof *begins);
    int failed = norma_mpi_failed(job, begins ? 0 : fail_memory(job));
    if (!failed) failed = place_faces(job, layout, begins, &triangles);
    if (!failed) {
        part->begin = begins[job->call.rank];
        part->end = begins[job->call.rank + 1];
        part->rest = begins[ranks];
        failed = open_faces(job, triangles, part) ||
                 read_rows(job, layout, begins[job->call.rank], part);
        failed = norma_mpi_failed(job, failed);
    }
    norma_core_release(&job->core, begins, ranks + 1, sizeof *begins);
    return failed;
}

void norma_mpi_release_positions(mpi_job *job, ply_part *part) {
    norma_core_release(
        &job->core, part->positions, part->own + part->others, norma_mpi_position_size(part));
    part->positions = NULL;
}

void norma_mpi_close_part_of_ply(mpi_job *job, ply_part *part) {
    const size_t count = part->own + part->others;
    norma_core_release(&job->core, part->corner, part->corner_room, sizeof *part->corner);
    norma_core_release(&job->core, part->face_starts, part->start_room, sizeof *part->face_starts);
    norma_core_release(&job->core, part->vertex_ids, count, sizeof *part->vertex_ids);
    norma_mpi_release_positions(job, part);
    *part = (ply_part){0};
}
