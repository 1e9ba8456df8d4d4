/* tasks.c: work of the formats that threads share: the core's own threads, without its progress. */
#include "io/stream/tasks.h"
#include "core/call/call.h"

static void begin(core_call *call, uint32_t threads) {
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    norma_core_begin(call, &options);
}

void norma_io_tasks(uint32_t threads, size_t count, norma_task *task, void *context) {
    core_call call;
    begin(&call, threads);
    if (count) norma_core_parallel(&call, count, task, context);
}

norma_result norma_io_tasks_told(
    const norma_options *options, size_t count, norma_task *task, void *context) {
    core_call call;
    norma_result result = norma_core_begin(&call, options);
    return result || count == 0 ? result : norma_core_parallel(&call, count, task, context);
}

static int tell_the_end(void *options, double fraction) {
    (void)fraction;
    return norma_io_cancelled(options);
}

int norma_io_cancelled(const norma_options *options) {
    return options->progress && options->progress(options->progress_user, 1);
}

int norma_io_tasks_watched(
    const norma_options *options, size_t count, norma_task *task, void *context) {
    const norma_options watched = {.struct_size = sizeof watched,
        .threads = options->threads,
        .progress = options->progress ? tell_the_end : NULL,
        .progress_user = (void *)(uintptr_t)options};
    return norma_io_tasks_told(&watched, count, task, context) == NORMA_CANCELLED;
}

size_t norma_io_threads(uint32_t threads) {
    core_call call;
    begin(&call, threads);
    return norma_core_workers(&call);
}
