/* timing.c: the clock, the memory and the baseline of the benchmarks. */
#define _DEFAULT_SOURCE /* clock_gettime, madvise */
#include "timing.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif

static int is_busy(void) { return getenv("NORMA_BENCH_BUSY") != NULL; }

uint32_t bench_threads(void) { return is_busy() ? 1 : 2; }

double bench_now(void) {
    struct timespec now;
    clock_gettime(is_busy() ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double bench_least(const double *times, size_t count) {
    double least = times[0];
    for (size_t i = 1; i < count; ++i) least = times[i] < least ? times[i] : least;
    return least;
}

/* What the library does for its own scratch: pages of 2 MiB, where the system has them. */
static void *large_pages(size_t bytes) {
    const size_t page = (size_t)1 << 21, rounded = (bytes + page - 1) / page * page;
    if (bytes < page) return aligned_alloc(64, (bytes + 63) / 64 * 64);
    void *memory = aligned_alloc(page, rounded);
#if defined(__linux__)
    if (memory) (void)madvise(memory, rounded, MADV_HUGEPAGE);
#endif
    return memory;
}

/* What a caller has: whatever pages come. */
void *bench_memory(size_t count, size_t size) {
    void *memory = malloc(count && size ? count * size : 1);
    if (!memory) {
        fprintf(stderr, "bench: no memory for %zu times %zu bytes\n", count, size);
        exit(3);
    }
    return memset(memory, 0, count * size);
}

double bench_memcpy_seconds(size_t bytes, size_t runs) {
    unsigned char *from = bench_memory(bytes, 1), *to = bench_memory(bytes, 1);
    double *times = bench_memory(runs, sizeof *times);
    for (size_t i = 0; i < bytes; ++i) from[i] = (unsigned char)i;
    for (size_t run = 0; run < runs; ++run) {
        const double begun = bench_now();
        memcpy(to, from, bytes);
        __asm__ volatile("" : : "r"(to) : "memory"); /* the copy is wanted, whoever reads it */
        times[run] = bench_now() - begun;
    }
    const double least = bench_least(times, runs);
    free(from);
    free(to);
    free(times);
    return least;
}

/* ---- the pool */

static void *pool_allocate(void *user, size_t size, size_t alignment) {
    bench_pool *pool = user;
    bench_block *block = NULL;
    (void)alignment; /* all are of 64 bytes at least */
    for (size_t i = 0; i < pool->count && !block; ++i)
        if (!pool->blocks[i].used && pool->blocks[i].size == size) block = &pool->blocks[i];
    if (!block) {
        if (pool->count == BENCH_MOST_BLOCKS) return NULL;
        block = &pool->blocks[pool->count++];
        *block = (bench_block){.memory = large_pages(size), .size = size};
        if (!block->memory) return NULL;
    }
    block->used = 1;
    pool->in_use += size;
    if (pool->in_use > pool->most_in_use) pool->most_in_use = pool->in_use;
    return block->memory;
}

static void pool_release(void *user, void *memory, size_t size) {
    bench_pool *pool = user;
    for (size_t i = 0; i < pool->count; ++i)
        if (pool->blocks[i].memory == memory) pool->blocks[i].used = 0;
    pool->in_use -= size;
}

norma_allocator bench_pool_allocator(bench_pool *pool) {
    return (norma_allocator){pool_allocate, pool_release, pool};
}

void bench_pool_free(bench_pool *pool) {
    for (size_t i = 0; i < pool->count; ++i) free(pool->blocks[i].memory);
    *pool = (bench_pool){0};
}
