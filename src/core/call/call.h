/* call.h: one call of the library: the caller's options made whole, its memory, its threads, its
 * progress. */
#ifndef NORMA_CORE_CALL_H
#define NORMA_CORE_CALL_H
#include "core/call/instruction_set.h"
#include <stdatomic.h>

typedef struct core_team core_team;
typedef struct core_call {
    norma_options options; /* every field valid; absent ones at their defaults */
    size_t workers;        /* 0: not settled yet */
    core_level level;      /* of the kernels, by options.isa */
    double progress_from, progress_to,
        progress_told; /* the stage that runs now covers this part of the whole */
    int cancelled;
    core_team *team; /* threads that stay; or NULL */
} core_call;

/* ARGUMENT where an option is out of its range; options and fault may be NULL. */
norma_result norma_core_check_options(const norma_options *options, norma_fault *fault);
norma_result norma_core_begin(core_call *call, const norma_options *options);

/* Scratch memory from the caller's allocator, aligned for any type; NULL when memory runs out or
 * count * size overflows. */
void *norma_core_allocate(const core_call *call, size_t count, size_t size);
void norma_core_release(const core_call *call, void *block, size_t count,
    size_t size); /* the same count and size; NULL is fine */

/* What it gives where the caller has no allocator; free releases it. */
void *norma_core_default_block(size_t bytes);

/* Later stages report between their own two fractions. Nonzero: the caller wants to stop. */
void norma_core_stage(core_call *call, double from, double to);
int norma_core_progress(core_call *call, double fraction_of_stage);

/* The result of a call that has done its work: a caller who is told that all is done may still
 * cancel. */
norma_result norma_core_finish(core_call *call, norma_result result);

/* How many may work, where the caller has no parallel_for: at least 1. With NORMA_ALL_THREADS the
 * system is asked, which takes longer than the normals of some thousand corners: so a call says
 * first how many there are, and few are for the calling thread alone. */
void norma_core_share(core_call *call, size_t corners);
size_t norma_core_workers(const core_call *call);
/* Into how many parts work is divided that each of them must have one of: as many as may work, and
 * for the caller's jobs as many as the machine has cores, but at least eight. */
size_t norma_core_shares(const core_call *call);

/* Runs task for each index below count: by the caller's parallel_for, by threads, or here. Tasks
 * share nothing but what they only read, and what is atomic. Returns NORMA_OK or NORMA_CANCELLED
 * (then some tasks did not run). */
norma_result norma_core_parallel(core_call *call, size_t count, norma_task *task, void *context);

/* Threads for all steps between the two, where there is enough to do; without them each step begins
 * its own. */
void norma_core_gather(core_call *call, size_t corners);
void norma_core_dismiss(core_call *call);

/* Until value, which another task raises, is at least this. Only for a task of a lower index, and
 * never in the caller's parallel_for: tasks of our own threads are begun in ascending order, so
 * that one of a lower index is at work or done. */
void norma_core_wait(const atomic_size_t *value, size_t least);
#endif
