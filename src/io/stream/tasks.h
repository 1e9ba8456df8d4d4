/* tasks.h: work of the formats that threads share. */
#ifndef NORMA_IO_TASKS_H
#define NORMA_IO_TASKS_H
#include <norma/norma.h>

/* Runs task for each index below count, by as many threads as norma_options means with this number.
 * Tasks share nothing but what they only read. */
void norma_io_tasks(uint32_t threads, size_t count, norma_task *task, void *context);
/* The same with the threads and the progress of the core's options, which may cancel. */
norma_result norma_io_tasks_told(
    const norma_options *options, size_t count, norma_task *task, void *context);
/* The same after the core has told that it is done: nothing more is told but that. Nonzero:
 * cancelled, then some tasks did not run. */
int norma_io_tasks_watched(
    const norma_options *options, size_t count, norma_task *task, void *context);

/* A count cut into tasks of about equal size, not smaller than least: how many, and where one
 * begins. */
static inline size_t norma_io_slices(size_t count, size_t least) {
    return count / least < 256 ? count / least + 1 : 256;
}
static inline size_t norma_io_slice(size_t count, size_t slices, size_t slice) {
    return count / slices * slice + (slice < count % slices ? slice : count % slices);
}
#endif
