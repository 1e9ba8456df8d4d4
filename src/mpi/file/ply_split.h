/* ply_split.h: the normals of the corners at this rank's positions, cut at creases. */
#ifndef NORMA_MPI_PLY_SPLIT_H
#define NORMA_MPI_PLY_SPLIT_H
#include "mpi/file/ply_near.h"

typedef struct ply_split {
    size_t count;      /* of new vertices, in the order of their first corners */
    uint32_t *sources; /* of each its place */
    float *normals;
    uint8_t *reasons;
    uint32_t *corners;       /* of each corner of near its new vertex, where its position is mine */
    uint8_t *corner_reasons; /* NULL: each corner has a normal */
    size_t corner_count;
    norma_report report; /* of this rank's positions; of faces: those that begin there */
    norma_edges edges;
} ply_split;

/* Collective. scale: of positions in doubles. Close in any case. */
int norma_mpi_split_near(
    mpi_job *job, uint64_t vertices, double scale, ply_near *near, ply_split *split);
void norma_mpi_release_vertices(mpi_job *job, ply_split *split); /* all that is of each new one */
void norma_mpi_close_split(mpi_job *job, ply_split *split);
#endif
