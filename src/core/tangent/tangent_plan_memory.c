/* tangent_plan_memory.c: what a tangent plan keeps, from the allocator of its creation. */
#include "core/tangent/tangent_plan.h"

void norma_core_tangent_adopt(norma_tangent_plan *plan, void *memory, size_t count, size_t size) {
    if (!memory) return;
    plan->stores[plan->store_count++] = (tangent_store){memory, count, size};
    plan->bytes += count * size;
}

void *norma_core_tangent_keep(norma_tangent_plan *plan, size_t count, size_t size) {
    void *memory = norma_core_allocate(&plan->memory, count, size);
    norma_core_tangent_adopt(plan, memory, count, size);
    return memory;
}
