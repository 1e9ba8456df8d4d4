/* ply_layout.h: where things are in a binary PLY that is larger than what one rank reads. */
#ifndef NORMA_MPI_PLY_LAYOUT_H
#define NORMA_MPI_PLY_LAYOUT_H
#include "io/ply/ply.h"
#include "mpi/file/shared_file.h"

enum { MPI_MOST_ELEMENTS = 32 };

/* before and after are documents of one face and one vertex with the header of the input and that
 * of the output, so that the reader and the writer of PLY decide what a header says. */
typedef struct ply_layout {
    norma_document *before, *after;
    unsigned char *small, *written; /* their bytes */
    size_t written_size;
    const ply_header *from, *to; /* their headers, whose counts are not the file's */
    uint64_t counts[MPI_MOST_ELEMENTS];
    size_t element_count;
    char *header; /* the output's, with the counts of the file */
    size_t header_size;
    uint64_t vertices, faces, vertex_begin, face_begin, body; /* bytes of the input */
    int has_normals;
} ply_layout;

/* On this rank alone; nonzero: failed. Close in any case. */
int norma_mpi_read_layout(mpi_job *job, ply_layout *layout);
/* The same: what the output looks like, to and header. */
int norma_mpi_plan_output(mpi_job *job, ply_layout *layout);
void norma_mpi_close_layout(ply_layout *layout);
size_t norma_mpi_offset_in_row(const ply_header *header, const ply_element *element, int property);
#endif
