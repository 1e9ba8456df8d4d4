/* sharing.h: which positions other ranks have as well, and where the sum of each is taken. */
#ifndef NORMA_MPI_SHARING_H
#define NORMA_MPI_SHARING_H
#include "core/mesh/input_mesh.h"
#include "mpi/exchange/exchange.h"

/* What makes two positions one: where they are, or a number. */
typedef struct mpi_keys {
    const core_mesh *mesh;   /* positions */
    const uint64_t *numbers; /* instead, if not NULL */
    int doubles;             /* some rank's positions are doubles */
} mpi_keys;

/* A rank's part in a position. */
enum { MPI_ABSENT = 0, MPI_LISTENS, MPI_VOTES };

/* Where the sum of a position is: at this rank, alone or also waited for by others; at its home,
 * which wants each contribution; at its home, which wants nothing from here. */
typedef enum mpi_kind { MPI_OWN = 0, MPI_SHARED, MPI_ASKED, MPI_NOWHERE } mpi_kind;
typedef uint64_t mpi_place; /* 48 bits: the kind, the home, the slot; or the kind and a sum here */
enum { MPI_KIND_AT = 46, MPI_HOME_AT = 28, MPI_MOST_RANKS = 1 << (MPI_KIND_AT - MPI_HOME_AT) };
static inline mpi_place norma_mpi_place(mpi_kind kind, int home, uint64_t slot) {
    return (uint64_t)kind << MPI_KIND_AT | (uint64_t)home << MPI_HOME_AT | slot;
}
static inline mpi_kind norma_mpi_kind(mpi_place place) { return (mpi_kind)(place >> MPI_KIND_AT); }
static inline int norma_mpi_home(mpi_place place) {
    return (int)(place >> MPI_HOME_AT & (MPI_MOST_RANKS - 1));
}
static inline uint64_t norma_mpi_slot(mpi_place place) {
    const int bits = norma_mpi_kind(place) == MPI_OWN ? MPI_KIND_AT : MPI_HOME_AT;
    return place & ((UINT64_C(1) << bits) - 1);
}

/* A place as it is kept for each position, of which a part in random order has nearly three for
 * each of its triangles. */
typedef struct mpi_kept_place {
    uint16_t parts[3];
} mpi_kept_place;
static inline mpi_kept_place norma_mpi_keep_place(mpi_place place) {
    return (mpi_kept_place){{(uint16_t)place, (uint16_t)(place >> 16), (uint16_t)(place >> 32)}};
}

/* A sum that is taken here, for which its home waits. */
typedef struct mpi_loan {
    mpi_place place;
    uint64_t sum;
} mpi_loan;

typedef struct mpi_sharing {
    size_t count;
    mpi_kept_place *places; /* of each position; slots of MPI_OWN are sums here, of which the first
                               stays empty */
    mpi_loan *loans;
    size_t loan_count, loan_room;
    uint64_t own;    /* sums that are taken here */
    uint64_t *slots; /* of each rank: how many it is the home of */
} mpi_sharing;

static inline mpi_place norma_mpi_place_at(const mpi_sharing *sharing, size_t v) {
    const uint16_t *parts = sharing->places[v].parts;
    return (uint64_t)parts[2] << 32 | (uint64_t)parts[1] << 16 | parts[0];
}

/* Collective. part: of each position. lend: a position of which one rank has all votes is summed
 * there. budget: bytes that lists may take. On an error there is nothing to close. */
norma_result norma_mpi_share(mpi_call *call, const mpi_keys *keys, const uint8_t *part, int lend,
    size_t budget, mpi_sharing *sharing);
void norma_mpi_sharing_close(const mpi_call *call, mpi_sharing *sharing);

/* The home of a number. */
int norma_mpi_home_of_number(const mpi_call *call, uint64_t number);
#endif
