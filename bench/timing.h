/* timing.h: what every benchmark needs: a clock, medians, memory that is counted and kept warm, and
 * the rate of memcpy to compare with. */
#ifndef NORMA_BENCH_TIMING_H
#define NORMA_BENCH_TIMING_H
#include <norma/norma.h>

/* Seconds, of a clock that never goes back; with NORMA_BENCH_BUSY in the environment those that
 * this process had a processor, for machines that others use meanwhile. */
double bench_now(void);

/* How many threads are worth timing: 2, or 1 on a busy machine, where they would be summed. */
uint32_t bench_threads(void);

/* The least of the times: what the work takes when nothing else runs meanwhile. */
double bench_least(const double *times, size_t count);

/* Seconds that memcpy takes for bytes, from one warm block to another: the least of runs. 0 where
 * there is no memory for it. */
double bench_memcpy_seconds(size_t bytes, size_t runs);

/* An allocator that counts, and keeps what is released for the next call: what scratch costs once
 * its pages are there. */
enum { BENCH_MOST_BLOCKS = 64 };
typedef struct bench_block {
    void *memory;
    size_t size;
    int used;
} bench_block;
typedef struct bench_pool {
    bench_block blocks[BENCH_MOST_BLOCKS];
    size_t count, in_use, most_in_use; /* bytes */
} bench_pool;
norma_allocator bench_pool_allocator(bench_pool *pool);
void bench_pool_free(bench_pool *pool);

/* calloc that ends the program where there is no memory. */
void *bench_memory(size_t count, size_t size);
#endif
