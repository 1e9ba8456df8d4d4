/* ply_classes.h: which vertices of the file lie at one position. */
#ifndef NORMA_MPI_PLY_CLASSES_H
#define NORMA_MPI_PLY_CLASSES_H
#include "core/mesh/input_mesh.h"
#include "mpi/file/ply_faces.h"

/* The positions of this rank's own vertices, as a mesh without faces. scale: for doubles. */
core_mesh norma_mpi_own_positions(const ply_part *part, double scale);

/* Collective. *classes: of each of this rank's own vertices the least vertex of the file that is
 * one with it, by job->options; to be released by the caller. part: positions are there, and
 * scale is that of all ranks. NULL on an error. */
norma_result norma_mpi_find_classes(
    mpi_job *job, const ply_part *part, double scale, uint32_t **classes);
#endif
