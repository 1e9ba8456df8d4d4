/* ply_output.h: a PLY as it was, with other normals. */
#ifndef NORMA_MPI_PLY_OUTPUT_H
#define NORMA_MPI_PLY_OUTPUT_H
#include "mpi/file/ply_faces.h"

/* Collective; the output is planned. normals: of own vertices, zero where there is none anywhere;
 * they become as they are stored. Nonzero: failed. */
int norma_mpi_write_ply(
    mpi_job *job, const ply_layout *layout, const ply_part *part, float *normals);
#endif
