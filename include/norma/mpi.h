/* mpi.h: vertex normals of a mesh whose parts lie on the ranks of an MPI communicator. The library
 * libnorma-mpi is built where MPI is installed (Open MPI or MPICH); norma.h describes meshes,
 * options, results and reports. */
#ifndef NORMA_MPI_H
#define NORMA_MPI_H
#include <mpi.h>
#include <norma/norma.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Computes the unit normal of each position of a mesh that is distributed over ranks: the bits that
 * norma_vertex_normals gives for the whole mesh, however its faces are distributed and however many
 * ranks there are.
 *
 *   comm         the ranks that hold parts; all of them must call
 *   part         the faces that this rank owns (each face is on one rank) and the positions that
 *                they name; also positions that no face of this part names. It may be empty
 *   vertex_ids   the global number of each position of part. A position may be on several ranks
 *   face_ids     the global number of each face of part; or NULL on all ranks, and faces are then
 *                numbered in the order of ranks. Sums run over faces in ascending number
 *   options      as for norma_vertex_normals. weight, weld, weld_distance, non_manifold and the
 *                fallback must be the same on every rank, the rest may differ
 *   normals      written: a normal for each position of part
 *   capacity     normals that fit
 *   report       written: of the whole mesh, the same on every rank, each face and each global
 *                vertex counted once; first is a global number. Or NULL
 *
 * Returns the same result on every rank, also if only one of them is at fault. Ranks that disagree
 * on options, or of which only some give face_ids (a rank without faces may do either), get
 * NORMA_ERROR_ARGUMENT. If a global number stands for two different positions, the normals are
 * undefined. vertex_ids must not be NULL if there are positions.
 *
 * Positions that only one rank uses are summed there. Contributions to the others cross the wire
 * once, 36 bytes each (44 with face_ids), to the rank that a hash of the position chooses. They do
 * so in as many rounds as keep scratch memory small. With NORMA_WELD_DISTANCE all positions are
 * gathered on one rank to find which are one. With NORMA_FALLBACK_NEAREST, normals that were
 * written are read again. MPI must be initialized; the calling thread is the only one that calls
 * it. */
NORMA_API norma_result norma_mpi_vertex_normals(MPI_Comm comm, const norma_mesh *part,
    const uint64_t *vertex_ids, const uint64_t *face_ids, const norma_options *options,
    float *normals, size_t capacity, norma_report *report);

#ifdef __cplusplus
}
#endif
#endif
