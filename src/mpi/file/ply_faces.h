/* ply_faces.h: this rank's faces of a PLY, and the positions that they name. */
#ifndef NORMA_MPI_PLY_FACES_H
#define NORMA_MPI_PLY_FACES_H
#include "mpi/file/ply_layout.h"

typedef struct ply_part {
    size_t faces, corners;
    uint32_t *corner;      /* numbers of the file; once positions are fetched, places here */
    uint32_t *face_starts; /* NULL: triangles */
    size_t corner_room, start_room;
    uint64_t first; /* this rank's own vertices: own of them, from first on */
    size_t own, others;
    uint64_t *vertex_ids; /* own, then the others that faces name, ascending */
    unsigned char *positions;
    int doubles;
    uint64_t begin, end; /* of this rank's faces in the file */
    uint64_t rest;       /* what follows all faces */
} ply_part;

/* Collective. Nonzero: failed. Close in any case. */
int norma_mpi_read_faces(mpi_job *job, const ply_layout *layout, ply_part *part);
int norma_mpi_fetch_positions(mpi_job *job, const ply_layout *layout, ply_part *part);
void norma_mpi_release_positions(mpi_job *job, ply_part *part);
void norma_mpi_close_part_of_ply(mpi_job *job, ply_part *part);
size_t norma_mpi_position_size(const ply_part *part);
#endif
