/* plan_memory.c: what a plan keeps, from the allocator of its creation. */
#include "core/plan/plan.h"

void *norma_core_plan_keep(norma_plan *plan, size_t count, size_t size) {
    if (plan->store_count == PLAN_MOST_BLOCKS) return NULL;
    void *memory = norma_core_allocate(&plan->memory, count, size);
    if (!memory) return NULL;
    plan->stores[plan->store_count++] = (plan_store){memory, count, size};
    plan->bytes += count * size;
    return memory;
}
