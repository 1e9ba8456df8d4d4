/* join.h: what the files of one surface say of its positions, and what follows for each. */
#ifndef NORMA_IO_TOGETHER_JOIN_H
#define NORMA_IO_TOGETHER_JOIN_H
#include "core/vertex/open_sum.h"
#include "io/together/spill.h"

/* A position of one mesh at one place. */
typedef struct position_votes {
    double at[3];
    open_sum sum;
    uint32_t rank; /* only those of the least rank decide: 0: it keeps a normal; else its level of
                      detail, from 1 */
} position_votes;

typedef struct position_normal {
    double direction[3]; /* of a kept normal, itself */
    uint8_t reason;      /* why there is none, or NORMA_REASON_NONE */
    uint8_t shared;      /* others have votes there, too */
    uint8_t kept;
} position_normal;

/* The partition of a position. */
size_t norma_together_partition(const double at[3]);
uint64_t norma_together_hash(const double at[3]);

/* For each record of votes one of normals, in the same partition and order. memory: bytes that may
 * be taken; a partition that needs more is gone through several times. Returns 0 or errno. */
int norma_together_join(spill *votes, spill *normals, uint64_t memory);
#endif
