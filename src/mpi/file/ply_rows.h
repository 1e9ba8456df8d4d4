/* ply_rows.h: the rows of faces of a PLY, one after the other, from any place in the file on. */
#ifndef NORMA_MPI_PLY_ROWS_H
#define NORMA_MPI_PLY_ROWS_H
#include "mpi/file/ply_faces.h"

typedef struct ply_rows {
    mpi_job *job;
    const ply_layout *layout;
    const ply_element *element;
    unsigned char *block;
    size_t held, used; /* bytes in the block, and those that are done with */
    uint64_t next;     /* of the file, behind the block */
} ply_rows;

/* Nonzero: failed. Close in any case. */
int norma_mpi_rows_open(mpi_job *job, const ply_layout *layout, uint64_t begin, ply_rows *rows);
void norma_mpi_rows_close(ply_rows *rows);
/* The next row and its bytes; NULL: failed. */
const unsigned char *norma_mpi_next_row(ply_rows *rows, size_t *size);
/* Of the row that comes next. */
uint64_t norma_mpi_place_in_file(const ply_rows *rows);
#endif
