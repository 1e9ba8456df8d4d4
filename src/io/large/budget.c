/* budget.c: blocks of memory that count against a limit, so that work is cut smaller before the
 * system refuses. */
#include "io/large/budget.h"
#include <stdlib.h>
#include <string.h>

/* 0: more than there is. */
static size_t claim(large_budget *budget, size_t count, size_t size) {
    if (count && size > SIZE_MAX / count) return 0;
    const size_t bytes = count && size ? count * size : 1;
    if (bytes > budget->most - budget->used) return 0;
    budget->used += bytes;
    return bytes;
}

static void release_claim(large_budget *budget, size_t count, size_t size) {
    budget->used -= count && size ? count * size : 1;
}

void *norma_large_take(large_budget *budget, size_t count, size_t size) {
    const size_t bytes = claim(budget, count, size);
    void *block = bytes ? malloc(bytes) : NULL;
    if (bytes && !block) release_claim(budget, count, size);
    return block;
}

void *norma_large_take_zeroed(large_budget *budget, size_t count, size_t size) {
    const size_t bytes = claim(budget, count, size);
    void *block = bytes ? calloc(bytes, 1) : NULL;
    if (bytes && !block) release_claim(budget, count, size);
    return block;
}

void norma_large_give(large_budget *budget, void *block, size_t count, size_t size) {
    if (!block) return;
    release_claim(budget, count, size);
    free(block);
}

void *norma_large_grow(
    large_budget *budget, void *block, size_t old_count, size_t count, size_t size) {
    if (!block) return norma_large_take(budget, count, size);
    if (count <= old_count || !claim(budget, count - old_count, size)) return NULL;
    void *grown = count > SIZE_MAX / size ? NULL : realloc(block, count * size);
    if (!grown) release_claim(budget, count - old_count, size);
    return grown;
}

/* ---- for the core */

static void *allocate(void *user, size_t size, size_t alignment) {
    void *block = NULL;
    const size_t bytes = claim(user, 1, size);
    if (!bytes) return NULL;
#if defined(_WIN32)
    block = _aligned_malloc(bytes, alignment);
#else
    if (bytes <= SIZE_MAX - alignment)
        block = aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
#endif
    if (!block) release_claim(user, 1, size);
    return block;
}

static void release(void *user, void *block, size_t size) {
    release_claim(user, 1, size);
#if defined(_WIN32)
    _aligned_free(block);
#else
    free(block);
#endif
}

norma_allocator norma_large_allocator(large_budget *budget) {
    return (norma_allocator){allocate, release, budget};
}
