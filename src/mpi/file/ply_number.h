/* ply_number.h: the vertices that creases add, numbered as one process numbers them: behind all
 * others, in the order of the corners that they begin with. */
#ifndef NORMA_MPI_PLY_NUMBER_H
#define NORMA_MPI_PLY_NUMBER_H
#include "mpi/file/ply_output.h"
#include "mpi/file/ply_split.h"

typedef struct ply_creased {
    float *normals;   /* of own vertices */
    uint8_t *reasons; /* why they have none */
    uint64_t *sites;  /* of each the first corner that has one, numbered through the file */
    size_t own;
    ply_added added;
} ply_creased;

/* Collective. Where vertices are added, the corners of part, which were dropped, are read again and
 * get their new numbers; split then has no vertices. Close in any case. */
int norma_mpi_number_vertices(mpi_job *job, const ply_layout *layout, const ply_near *near,
    ply_split *split, ply_part *part, ply_creased *creased);
void norma_mpi_close_creased(mpi_job *job, ply_creased *creased);
#endif
