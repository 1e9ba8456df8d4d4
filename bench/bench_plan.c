/* bench_plan.c: plans of meshes that move, against memcpy and the full calls, in one process. 1x as
 * in bench_core.c.
 *
 *     bench_plan [TRIANGLES]       100,000 and 10 million by default */
#include "made_meshes.h"
#include "timing.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const float CREASE_60 = 1.0471975512F;

typedef struct plan_bench {
    made_mesh mesh;
    norma_mesh view;
    double triangles, nanoseconds_1x;
    size_t runs;
    norma_plan *plan;
    float *out;
    uint32_t *moved;
} plan_bench;

static void stop_at(norma_result result, const char *what) {
    if (!result) return;
    fprintf(stderr, "bench_plan: %s: %s\n", what, norma_result_text(result));
    exit(3);
}

/* Seconds of one update: the least of runs. */
static double time_update(
    const plan_bench *b, uint32_t threads, const uint32_t *moved, size_t count, size_t runs) {
    const norma_options options = {.threads = threads};
    double *times = bench_memory(runs, sizeof *times);
    for (size_t run = 0; run < runs; ++run) {
        const double begun = bench_now();
        stop_at(norma_plan_update(b->plan, b->view.positions, moved, count, &options, b->out,
                    b->mesh.position_count, NULL),
            "update");
        times[run] = bench_now() - begun;
    }
    const double least = bench_least(times, runs);
    free(times);
    return least;
}

static void bench_creation(plan_bench *b) {
    enum { RUNS = 3 };
    double made[RUNS], corners[RUNS];
    float *normals = bench_memory(3 * b->mesh.corner_count, sizeof *normals);
    for (int run = 0; run < RUNS; ++run) {
        norma_plan_destroy(b->plan);
        b->plan = NULL;
        const double begun = bench_now();
        stop_at(norma_plan_create(&b->view, NORMA_PER_VERTEX, CREASE_60, NULL, &b->plan), "create");
        made[run] = bench_now() - begun;
        stop_at(
            norma_corner_normals(&b->view, CREASE_60, NULL, normals, b->mesh.corner_count, NULL),
            "corners");
        corners[run] = bench_now() - begun - made[run];
    }
    free(normals);
    const double creation = bench_least(made, RUNS), full = bench_least(corners, RUNS);
    printf("  creation %7.1f ns per triangle, %.2f of norma_corner_normals (asked 2)   %.1f bytes "
           "per triangle (asked 48)\n",
        1e9 * creation / b->triangles, creation / full,
        (double)norma_plan_bytes(b->plan) / b->triangles);
}

static double time_full_call(const plan_bench *b, norma_options options) {
    double *times = bench_memory(b->runs, sizeof *times);
    for (size_t run = 0; run < b->runs; ++run) {
        const double begun = bench_now();
        stop_at(norma_vertex_normals(&b->view, &options, b->out, b->mesh.position_count, NULL),
            "vertices");
        times[run] = bench_now() - begun;
    }
    const double least = bench_least(times, b->runs);
    free(times);
    return least;
}

static void bench_full_calls(const plan_bench *b) {
    for (uint32_t threads = 1; threads <= bench_threads(); ++threads) {
        const double by_index = time_full_call(
                         b, (norma_options){.weld = NORMA_WELD_NONE, .threads = threads}),
                     by_position = time_full_call(b, (norma_options){.threads = threads});
        printf("  norma_vertex_normals, %u thread%s %7.2f ns by index %7.2f ns by position\n",
            threads, threads > 1 ? "s" : " ", 1e9 * by_index / b->triangles,
            1e9 * by_position / b->triangles);
    }
}

/* What is asked of a mesh that the caches hold is a time, of others a multiple of the least
 * traffic. */
static void bench_updates(const plan_bench *b, int shuffled) {
    static const double multiples[2][2] = {{8.5, 5.2}, {25, 14}}, milliseconds[2] = {0.5, 0.3};
    for (uint32_t threads = 1; threads <= bench_threads(); ++threads) {
        const double seconds = time_update(b, threads, NULL, 0, b->runs),
                     nanoseconds = 1e9 * seconds / b->triangles;
        printf("  all moved, %u thread%s %7.2f ns %7.1fx %9.3f ms", threads,
            threads > 1 ? "s" : " ", nanoseconds, nanoseconds / b->nanoseconds_1x, 1e3 * seconds);
        if (b->triangles < 1e6)
            printf("   (asked %.2f ms)\n", milliseconds[threads - 1]);
        else
            printf("   (asked %.1fx)\n", multiples[shuffled][threads - 1]);
    }
}

/* A square of neighbours amid the sheet, which has rows of about side vertices; one vertex. */
static void bench_brush(const plan_bench *b) {
    const size_t side = (size_t)sqrt((double)b->mesh.position_count);
    size_t count = 0;
    for (size_t y = 0; y < 32; ++y)
        for (size_t x = 0; x < 32 && count < 1000; ++x)
            b->moved[count++] = (uint32_t)((side / 2 + y) * side + side / 3 + x);
    printf("  %zu neighbours moved  %7.1f us (asked of 100,000 triangles: 30)\n", count,
        1e6 * time_update(b, 1, b->moved, count, 201));
    printf("  one vertex moved      %7.1f us\n", 1e6 * time_update(b, 1, b->moved, 1, 201));
}

static void bench_shape(plan_bench *b, int shuffled) {
    if (shuffled) made_shuffle(&b->mesh);
    b->view = made_view(&b->mesh);
    printf("%s\n", shuffled ? "shuffled" : "rows");
    bench_creation(b);
    bench_updates(b, shuffled);
    bench_full_calls(b);
    if (!shuffled) bench_brush(b);
    norma_plan_destroy(b->plan);
    b->plan = NULL;
}

static void bench_size(size_t triangles) {
    plan_bench b = {.mesh = made_grid(triangles)};
    b.triangles = (double)(b.mesh.corner_count / 3);
    b.runs = b.triangles > 3e6 ? 5 : 51;
    b.out = bench_memory(3 * b.mesh.position_count, sizeof *b.out);
    b.moved = bench_memory(b.mesh.position_count + 1000, sizeof *b.moved);
    b.nanoseconds_1x = 1e9 * bench_memcpy_seconds((size_t)(12 * b.triangles), 9) / b.triangles;
    printf("plans, per vertex, crease 60, %.0f triangles; 1x = %.2f ns per triangle\n", b.triangles,
        b.nanoseconds_1x);
    for (int shuffled = 0; shuffled < 2; ++shuffled) bench_shape(&b, shuffled);
    free(b.out);
    free(b.moved);
    made_free(&b.mesh);
}

int main(int argc, char **argv) {
    if (argc > 1) {
        bench_size((size_t)strtoull(argv[1], NULL, 10));
        return 0;
    }
    bench_size(100000);
    bench_size(10000000);
    return 0;
}
