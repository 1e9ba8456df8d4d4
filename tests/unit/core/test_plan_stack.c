/* test_plan_stack.c: the tasks of an update run in a caller's jobs, whose stacks are small: each
 * task runs on a stack of its own here, painted before, and what is no longer paint afterwards was
 * used. */
#define _GNU_SOURCE
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"
#include <pthread.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) ||                         \
    __has_feature(undefined_behavior_sanitizer)
#define SANITIZED 1
#endif
#endif

enum { STACK = 1 << 20, PROMISED = 32 << 10, SIDE = 90, HUB = 2000, PAINT = 0xa5 };

typedef struct job {
    norma_task *task;
    void *context;
    size_t index;
} job;

static void *run_job(void *user) {
    const job *j = user;
    if (j->task) j->task(j->context, j->index);
    return NULL;
}

/* What a thread that runs this job leaves unpainted. */
static size_t used_by(job *j) {
    unsigned char *stack = NULL;
    pthread_attr_t attributes;
    pthread_t thread;
    size_t untouched = 0;
    assert_int_equal(posix_memalign((void **)&stack, 4096, STACK), 0);
    memset(stack, PAINT, STACK);
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstack(&attributes, stack, STACK), 0);
    assert_int_equal(pthread_create(&thread, &attributes, run_job, j), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    pthread_attr_destroy(&attributes);
    while (untouched < STACK && stack[untouched] == PAINT) ++untouched;
    free(stack);
    return STACK - untouched;
}

/* The most that a task took beyond what a thread needs to begin and to end. */
static void measure_jobs(void *user, size_t count, norma_task *task, void *context) {
    size_t *most = user;
    job nothing = {0};
    const size_t thread = used_by(&nothing);
    for (size_t i = 0; i < count; ++i) {
        job j = {task, context, i};
        const size_t used = used_by(&j) - thread;
        if (used > *most) *most = used;
    }
}

static void update(const norma_plan *plan, const norma_mesh *view, const uint32_t *moved,
    size_t count, norma_options options) {
    static const norma_weight weights[] = {
        NORMA_WEIGHT_ANGLE, NORMA_WEIGHT_ANGLE_LENGTHS, NORMA_WEIGHT_VISIBLE};
    static const norma_isa sets[] = {NORMA_ISA_BEST, NORMA_ISA_AVX2, NORMA_ISA_PORTABLE};
    const size_t corners =
        view->corner_count > view->positions.count ? view->corner_count : view->positions.count;
    float *out = test_calloc(3 * corners, sizeof *out);
    for (size_t w = 0; w < 3; ++w)
        for (size_t s = 0; s < 3; ++s) {
            size_t most = 0;
            options.weight = weights[w];
            options.isa = sets[s];
            options.parallel_for = measure_jobs;
            options.parallel_for_user = &most;
            const norma_result result = norma_plan_update(
                plan, view->positions, moved, count, &options, out, corners, NULL);
            if (result == NORMA_ERROR_ARGUMENT && sets[s] == NORMA_ISA_AVX2) continue;
            assert_ok(result);
            assert_true(most > 0);
            if (most > PROMISED)
                fail_msg(
                    "weight %d, isa %d: %zu bytes of stack", (int)weights[w], (int)sets[s], most);
        }
    test_free(out);
}

static void plan_of(const norma_mesh *view, norma_element of) {
    norma_plan *plan;
    uint32_t moved[100];
    for (uint32_t i = 0; i < 100; ++i) moved[i] = 7 * i;
    assert_ok(norma_plan_create(view, of, 1, NULL, &plan));
    update(plan, view, NULL, 0, (norma_options){0});
    update(plan, view, moved, 100, (norma_options){0});
    norma_plan_destroy(plan);
}

static void tasks_need_little(void **state) {
    (void)state;
#if defined(SANITIZED)
    skip(); /* a sanitizer's frames are larger */
#endif
    for (int quads = 0; quads < 2; ++quads) {
        mesh_file mesh = {0};
        shape_uv_sphere(&mesh, SIDE, SIDE, 0, quads);
        float *floats = test_calloc(3 * mesh.position_count, sizeof *floats);
        norma_mesh view = mesh_file_view_float(&mesh, floats);
        plan_of(&view, NORMA_PER_VERTEX);
        plan_of(&view, NORMA_PER_CORNER);
        view.positions =
            (norma_vec3_view){mesh.positions, mesh.position_count, 0, NORMA_FORMAT_DOUBLE};
        plan_of(&view, NORMA_PER_VERTEX);
        mesh_file_free(&mesh);
        test_free(floats);
    }
}

/* A hub of more corners than a block holds. */
static void hubs_need_little(void **state) {
    (void)state;
#if defined(SANITIZED)
    skip();
#endif
    float(*positions)[3] = test_calloc(HUB + 1, sizeof *positions);
    uint32_t *corners = test_calloc(3 * HUB, sizeof *corners);
    for (uint32_t i = 0; i < HUB; ++i) {
        const double turn = 6.283185307179586 * i / HUB;
        positions[i + 1][0] = (float)cos(turn);
        positions[i + 1][1] = (float)sin(turn);
        positions[i + 1][2] = (float)(i % 3) * 0.01f;
        corners[3 * i + 1] = i + 1;
        corners[3 * i + 2] = (i + 1) % HUB + 1;
    }
    const norma_mesh view = {.positions = {positions, HUB + 1, 0, NORMA_FORMAT_FLOAT},
        .corners = corners,
        .corner_count = 3 * (size_t)HUB};
    plan_of(&view, NORMA_PER_VERTEX);
    plan_of(&view, NORMA_PER_CORNER);
    test_free(positions);
    test_free(corners);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tasks_need_little), cmocka_unit_test(hubs_need_little)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
