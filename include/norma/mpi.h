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

/* Computes the unit normal of each position of a mesh that is distributed over ranks. The result
 * has the same bits as norma_vertex_normals for the whole mesh, for any number of ranks and any
 * distribution of the faces.
 *
 *   comm         the ranks that hold parts; all of them must call
 *   part         the faces that this rank owns (each face is on one rank) and the positions that
 *                they use; other positions are allowed too. It may be empty
 *   vertex_ids   the global number of each position of part. A position may be on several ranks
 *   face_ids     the global number of each face of part; or NULL on all ranks: faces are then
 *                numbered in the order of ranks. Sums run over faces in ascending number
 *   options      as for norma_vertex_normals. weight, weld, weld_distance, non_manifold and the
 *                fallback must be the same on every rank, the rest may differ
 *   normals      written: a normal for each position of part
 *   capacity     normals that fit
 *   report       written: of the whole mesh, the same on every rank, each face and each global
 *                vertex counted once; first is a global number. Or NULL
 *
 * Returns the same result on every rank, also if only one of them is at fault. If ranks disagree
 * on options, or only some of them give face_ids (ranks without faces may do either), the result is
 * NORMA_ERROR_ARGUMENT. If a global number stands for two different positions, the normals are
 * undefined. vertex_ids must not be NULL if there are positions.
 *
 * Positions that only one rank uses are summed there. Contributions to other positions are sent
 * once, 36 bytes each (44 with face_ids), to the rank that a hash of the position chooses. This
 * happens in rounds, to keep scratch memory small. With NORMA_WELD_DISTANCE, all positions are
 * gathered on one rank to be joined. With NORMA_FALLBACK_NEAREST, normals that were written are
 * read again. MPI must be initialized; only the calling thread calls it. */
NORMA_API norma_result norma_mpi_vertex_normals(MPI_Comm comm, const norma_mesh *part,
    const uint64_t *vertex_ids, const uint64_t *face_ids, const norma_options *options,
    float *normals, size_t capacity, norma_report *report);

#ifdef __cplusplus
}
#endif
#endif
