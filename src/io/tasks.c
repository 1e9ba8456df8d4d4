/* tasks.c: work of the formats that threads share: the core's own threads, without its progress. */
#include "tasks.h"
#include "../core/call.h"

static void begin(core_call *call, uint32_t threads)
{
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    norma_core_begin(call, &options);
}

void norma_io_tasks(uint32_t threads, size_t count, norma_task *task, void *context)
{
    core_call call;
    begin(&call, threads);
    if (count)
        norma_core_parallel(&call, count, task, context);
}

norma_result norma_io_tasks_told(const norma_options *options, size_t count, norma_task *task, void *context)
{
    core_call call;
    norma_result result = norma_core_begin(&call, options);
    return result || count == 0 ? result : norma_core_parallel(&call, count, task, context);
}

size_t norma_io_threads(uint32_t threads)
{
    core_call call;
    begin(&call, threads);
    return norma_core_workers(&call);
}
