/* formats.h: the files that norma-mpi reads and writes. */
#ifndef NORMA_MPI_FORMATS_H
#define NORMA_MPI_FORMATS_H
#include "mpi/file/shared_file.h"

/* Collective; the input is open. Nonzero: failed, with a message. */
int norma_mpi_compute_ply(mpi_job *job);
int norma_mpi_compute_stl(mpi_job *job);
#endif
