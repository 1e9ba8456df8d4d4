/* ply_output.h: a PLY as it was, with other normals and, where creases ask for it, added vertices.
 */
#ifndef NORMA_MPI_PLY_OUTPUT_H
#define NORMA_MPI_PLY_OUTPUT_H
#include "mpi/file/ply_faces.h"

/* Copies of vertices, behind all others in the output. */
typedef struct ply_added {
    uint64_t all, first; /* of all ranks; this rank writes count of them, from first on */
    size_t count;
    uint32_t *sources;
    float *normals;
} ply_added;

/* Collective; the output is planned. normals: of own vertices, zero where there is none anywhere;
 * they become as they are stored, as do those in added. Corners of part are numbered as in the
 * output, unless added->all is 0. Nonzero: failed. */
int norma_mpi_write_ply(mpi_job *job, const ply_layout *layout, const ply_part *part,
    float *normals, const ply_added *added);
#endif
