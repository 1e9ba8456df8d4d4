/* ply_lenders.h: which faces lend their direction to faces that have none, where the longest edge
 * of such a face lies at another rank. */
#ifndef NORMA_MPI_PLY_LENDERS_H
#define NORMA_MPI_PLY_LENDERS_H
#include "core/corner/prepared_mesh.h"
#include "mpi/file/ply_near.h"

typedef struct ply_loan {
    uint32_t face, lender; /* faces here; lender: UINT32_MAX where nobody lends */
} ply_loan;

typedef struct ply_loans {
    ply_loan *loans;
    size_t count, room;
} ply_loans;

/* Collective. prepared: of near; its lenders are right for the faces whose longest edge begins or
 * ends at the lower of its positions here. loans: the lenders of the others. Lenders that are not
 * here are put behind the faces of near, with places of their own: *grown, and prepared must be
 * opened anew. Close in any case. */
norma_result norma_mpi_find_lenders(mpi_job *job, uint64_t vertices, core_prepared_mesh *prepared,
    ply_near *near, ply_loans *loans, int *grown);
void norma_mpi_close_loans(const mpi_job *job, ply_loans *loans);
#endif
