/* ply_rows.c: rows are looked at in a block, which moves on where the next one is not all in it. */
#include "mpi/file/ply_rows.h"

enum { MOST_ROW = MPI_BLOCK / 2 };

static int fail_short(mpi_job *job) {
    return norma_mpi_fail(job, "%s: is too short for what its header announces (byte %llu)",
        job->input, (unsigned long long)job->size);
}

/* Bytes of the row at `at`, of which so many are there; 0: not all of it. *bad: set to the offset
 * of a list's count that is negative. */
static size_t row_size(const ply_rows *r, const unsigned char *at, size_t left, size_t *bad) {
    const ply_header *header = r->layout->from;
    size_t size = 0;
    for (size_t p = 0; p < r->element->property_count; p++) {
        const ply_property *property = norma_ply_property(header, r->element, (int)p);
        const int list = norma_ply_is_list(property);
        const size_t head = norma_ply_type_size(list ? property->count_type : property->type);
        if (left - size < head) return 0;
        if (list && norma_ply_get_integer(at + size, property->count_type, header->encoding) < 0) {
            *bad = size;
            return 0;
        }
        size += list ? norma_ply_property_size(header, property, at + size) : head;
        if (left < size) return 0;
    }
    return size;
}

static int fill_block(ply_rows *r) {
    const size_t left = r->held - r->used, room = MPI_BLOCK - left;
    const uint64_t more = r->job->size - r->next;
    const size_t some = more < room ? (size_t)more : room;
    memmove(r->block, r->block + r->used, left);
    r->used = 0;
    r->held = left + some;
    if (norma_mpi_read(r->job, r->next, r->block + left, some)) return 1;
    r->next += some;
    return 0;
}

static const unsigned char *fail_row(const ply_rows *r, size_t bad) {
    if (bad != SIZE_MAX)
        norma_mpi_fail(r->job, "%s:byte %llu: a list of negative length", r->job->input,
            (unsigned long long)(norma_mpi_place_in_file(r) + bad));
    else if (r->held == MPI_BLOCK)
        norma_mpi_fail(r->job, "%s: a face takes more than %d bytes; use norma compute",
            r->job->input, (int)MOST_ROW);
    else
        fail_short(r->job);
    return NULL;
}

const unsigned char *norma_mpi_next_row(ply_rows *r, size_t *size) {
    size_t bad = SIZE_MAX;
    for (int again = 0; again < 2 && bad == SIZE_MAX; again++) {
        const unsigned char *row = r->block + r->used;
        *size = row_size(r, row, r->held - r->used, &bad);
        if (*size) {
            r->used += *size;
            return row;
        }
        if (!again && bad == SIZE_MAX && fill_block(r)) return NULL;
    }
    return fail_row(r, bad);
}

uint64_t norma_mpi_place_in_file(const ply_rows *r) { return r->next - (r->held - r->used); }

int norma_mpi_rows_open(mpi_job *job, const ply_layout *layout, uint64_t begin, ply_rows *rows) {
    *rows = (ply_rows){.job = job,
        .layout = layout,
        .element = norma_ply_element(layout->from, layout->from->face),
        .block = norma_core_allocate(&job->core, MPI_BLOCK, 1),
        .next = begin};
    return rows->block ? 0 : norma_mpi_fail(job, "%s: out of memory", job->input);
}

void norma_mpi_rows_close(ply_rows *rows) {
    norma_core_release(&rows->job->core, rows->block, MPI_BLOCK, 1);
}
