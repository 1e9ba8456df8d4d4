/* engine_jobs.c: Norma inside an engine: its jobs instead of threads of Norma's own, its memory
 * instead of malloc.
 *
 * The jobs here are four POSIX threads that take indices from a counter; the memory is one block
 * that is cut from the front. The normals have the same bits as those of a single thread. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <norma/norma.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct job {
    norma_task *task;
    void *context;
    size_t count;
    atomic_size_t next;
} job;

static void *work(void *argument) {
    job *j = argument;
    for (size_t i; (i = atomic_fetch_add(&j->next, 1)) < j->count;) j->task(j->context, i);
    return NULL;
}

/* Each index once, in any order; returns when all are done. */
static void run_jobs(void *user, size_t count, norma_task *task, void *context) {
    pthread_t threads[4];
    int started = 0;
    job j = {.task = task, .context = context, .count = count};
    while (started < 4 && !pthread_create(&threads[started], NULL, work, &j)) ++started;
    work(&j);
    while (started-- > 0) pthread_join(threads[started], NULL);
    ++*(size_t *)user;
}

typedef struct arena {
    unsigned char *block;
    size_t size, used;
} arena;

/* The calling thread alone allocates. */
static void *take(void *user, size_t size, size_t alignment) {
    arena *a = user;
    const uintptr_t at = ((uintptr_t)a->block + a->used + alignment - 1) / alignment * alignment;
    const size_t from = (size_t)(at - (uintptr_t)a->block);
    if (from > a->size || size > a->size - from) return NULL;
    a->used = from + size;
    return a->block + from;
}

static void give_back(void *user, void *block, size_t size) { (void)user, (void)block, (void)size; }

int main(void) {
    enum { SIDE = 200, VERTICES = SIDE * SIDE, CORNERS = 6 * (SIDE - 1) * (SIDE - 1) };
    static float positions[VERTICES][3], alone[VERTICES][3], with_jobs[VERTICES][3];
    static uint32_t corners[CORNERS];
    size_t c = 0;
    for (uint32_t y = 0; y < SIDE; ++y)
        for (uint32_t x = 0; x < SIDE; ++x) {
            float *p = positions[y * SIDE + x];
            p[0] = 0.05F * (float)x;
            p[1] = 0.05F * (float)y;
            p[2] = sinf(p[0]) * cosf(p[1]);
            if (x + 1 == SIDE || y + 1 == SIDE) continue;
            const uint32_t a = y * SIDE + x,
                           two[6] = {a, a + 1, a + SIDE + 1, a, a + SIDE + 1, a + SIDE};
            for (int i = 0; i < 6; ++i) corners[c++] = two[i];
        }

    size_t rounds = 0;
    arena memory = {.block = malloc(16 << 20), .size = 16 << 20};
    if (!memory.block) return 1;
    const norma_mesh mesh = {.positions = {.data = positions, .count = VERTICES},
        .corners = corners,
        .corner_count = CORNERS};
    const norma_options options = {.struct_size = sizeof options,
        .allocator = {.allocate = take, .release = give_back, .user = &memory},
        .parallel_for = run_jobs,
        .parallel_for_user = &rounds};
    if (norma_vertex_normals(&mesh, NULL, alone[0], VERTICES, NULL) != NORMA_OK) return 1;
    if (norma_vertex_normals(&mesh, &options, with_jobs[0], VERTICES, NULL) != NORMA_OK) return 1;
    printf("%d vertices: %s\n", VERTICES,
        memcmp(alone, with_jobs, sizeof alone) ? "different bits" : "the same bits");
    printf("jobs ran: %s; scratch memory from the arena: %s\n", rounds ? "yes" : "no",
        memory.used ? "yes" : "no");
    free(memory.block);
    return 0;
}
