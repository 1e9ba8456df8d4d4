/* budget.h: blocks of memory that count against a limit. */
#ifndef NORMA_IO_LARGE_BUDGET_H
#define NORMA_IO_LARGE_BUDGET_H
#include <norma/norma.h>
#include <stddef.h>
#include <stdint.h>

typedef struct large_budget {
    uint64_t most, used; /* bytes */
} large_budget;

/* NULL: beyond the limit, or the system has no more. size and count as they were taken. */
void *norma_large_take(large_budget *budget, size_t count, size_t size);
void *norma_large_take_zeroed(large_budget *budget, size_t count, size_t size);
void norma_large_give(large_budget *budget, void *block, size_t count, size_t size);
/* The block keeps its content; NULL: it stays as it is. */
void *norma_large_grow(
    large_budget *budget, void *block, size_t old_count, size_t count, size_t size);
/* For the core's scratch memory. budget must outlive it. */
norma_allocator norma_large_allocator(large_budget *budget);
#endif
