/* shared_file.h: one file that all ranks read, and one that all write, whole or not at all. */
#ifndef NORMA_MPI_SHARED_FILE_H
#define NORMA_MPI_SHARED_FILE_H
#include "io/file/file.h"
#include "mpi/vertex/vertex.h"
#include <norma/norma.h>
#include <sys/types.h>

typedef struct mpi_job {
    mpi_call call;
    core_call core;
    const char *input, *output; /* paths */
    norma_options options;      /* how normals are computed */
    char message[640];          /* why it failed, the same on every rank once agreed upon */
    MPI_File in, out;
    uint64_t size;        /* of the input */
    file_writer *writer;  /* of the first rank */
    char temporary[1024]; /* the output until it is whole; "" when there is none */
    pid_t guard;          /* takes the temporary file away should this rank end; 0: none */
    int guarded;          /* the end of a socket that it reads */
    norma_report report;
    uint64_t faces, vertices;
    uint64_t memory, most_memory; /* bytes that this rank has allocated; the most at any time */
} mpi_job;

/* Collective: the copy of comm, and memory that is counted, for the library's calls too. */
norma_result norma_mpi_open_job(mpi_job *job, MPI_Comm comm);
/* What stays allocated otherwise until the end. */
void norma_mpi_count_memory(mpi_job *job, size_t size);

/* Returns 1, and keeps the message of this rank. */
int norma_mpi_fail(mpi_job *job, const char *format, ...);
/* Collective: whether some rank failed; then all have the message of the first that did. */
int norma_mpi_failed(mpi_job *job, int mine);
/* Collective: the same of a result of the library. */
int norma_mpi_failed_result(mpi_job *job, norma_result mine);

/* From count elements those of a rank begin here. */
static inline uint64_t norma_mpi_share_of(const mpi_job *job, uint64_t count, int rank) {
    const uint64_t ranks = (uint64_t)job->call.ranks, number = (uint64_t)rank;
    return count / ranks * number + count % ranks * number / ranks;
}

enum { MPI_BLOCK = 1 << 20 }; /* bytes that are read or written at once */

/* Collective. Ranks must see files of one size. */
int norma_mpi_open_input(mpi_job *job);
/* Nonzero: failed, on this rank alone. */
int norma_mpi_read(mpi_job *job, uint64_t offset, void *bytes, size_t size);

/* Collective: a temporary file beside the output. Close puts it in its place, or removes it where
 * failed is nonzero on some rank. */
int norma_mpi_open_output(mpi_job *job, uint64_t size);
int norma_mpi_write(mpi_job *job, uint64_t offset, const void *bytes, size_t size);
int norma_mpi_close_output(mpi_job *job, int failed);
/* This rank's share of size bytes, copied as they are. */
int norma_mpi_copy_share(mpi_job *job, uint64_t from, uint64_t to, uint64_t size);

/* ---- The files that norma-mpi reads and writes. */

/* Collective; the input is open. Nonzero: failed, with a message. */
int norma_mpi_compute_ply(mpi_job *job);
int norma_mpi_compute_stl(mpi_job *job);
#endif
