/* test_threads.c: the same bits for any number of threads and for jobs run in any order; two
 * callers at once; and the meshes that tempt an implementation into quadratic time: 400,000
 * triangles round one vertex, as many copies of one position, 100,000 triangles apart. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"
#include <pthread.h>
#include <time.h>

enum { FACES, VERTICES, CORNERS, SPLIT, CALLS };

typedef struct answer {
    float *normals;
    uint32_t *corners, *sources;
    uint8_t *reasons;
    size_t room, count;
    norma_report report;
    norma_edges edges;
} answer;

static void answer_create(answer *a, size_t room) {
    memset(a, 0, sizeof *a);
    a->room = room;
    a->normals = calloc(room, 12);
    a->corners = calloc(room, 4);
    a->sources = calloc(room, 4);
    a->reasons = calloc(room, 1);
    if (!a->normals || !a->corners || !a->sources || !a->reasons) abort();
}

static void answer_free(answer *a) {
    free(a->normals);
    free(a->corners);
    free(a->sources);
    free(a->reasons);
}

static norma_result call(int kind, const norma_mesh *mesh, norma_options options, answer *a) {
    options.struct_size = sizeof options;
    options.edges = &a->edges;
    options.reasons = kind == SPLIT ? NULL : a->reasons;
    if (kind == FACES) return norma_face_normals(mesh, &options, a->normals, a->room, &a->report);
    if (kind == VERTICES)
        return norma_vertex_normals(mesh, &options, a->normals, a->room, &a->report);
    if (kind == CORNERS)
        return norma_corner_normals(mesh, 0.7f, &options, a->normals, a->room, &a->report);
    return norma_split(mesh, 0.7f, &options, a->corners, a->room, a->sources, a->normals, a->room,
        &a->count, &a->report);
}

static int same(const answer *a, const answer *b) {
    return !memcmp(a->normals, b->normals, 12 * a->room) &&
           !memcmp(a->corners, b->corners, 4 * a->room) &&
           !memcmp(a->sources, b->sources, 4 * a->room) &&
           !memcmp(a->reasons, b->reasons, a->room) && a->count == b->count &&
           !memcmp(&a->report, &b->report, sizeof a->report) &&
           !memcmp(&a->edges, &b->edges, sizeof a->edges);
}

/* Large enough that every part of the work is cut into several pieces; with what gets no normal,
 * and edges of every kind. */
static void make_mesh(mesh_file *mesh) {
    uint64_t seed = 11;
    shape_wavy_grid(mesh, SLOWER > 1 ? 100 : 170, 0);
    shape_pole_sphere(mesh, 200, 60, 1);
    const uint32_t count = (uint32_t)mesh->position_count;
    for (uint32_t i = 0; i < count; ++i)
        for (int x = 0; x < 3; ++x)
            mesh->positions[i][x] += shape_random_unit(&seed) * (i % 5 == 0 ? .03 : 0);
    for (uint32_t i = 0; i < 3000; ++i)
        mesh_file_add_face(mesh,
            (uint32_t[]){shape_random(&seed) % count, shape_random(&seed) % count,
                shape_random(&seed) % count},
            3);
    for (uint32_t i = 0; i < 200; ++i) mesh_file_add_position(mesh, i, 0, 0);
    for (uint32_t i = 0; i < count; i += 97)
        memcpy(mesh->positions[i], mesh->positions[shape_random(&seed) % count],
            sizeof *mesh->positions);
    mesh->positions[count / 3][0] = (double)NAN;
}

/* ---- a caller's jobs */

static void run_backwards(void *user, size_t count, norma_task *task, void *context) {
    ++*(size_t *)user;
    for (size_t i = count; i > 0; --i) task(context, i - 1);
}

static void run_shuffled(void *user, size_t count, norma_task *task, void *context) {
    uint64_t seed = ++*(size_t *)user;
    size_t *order = malloc((count ? count : 1) * sizeof *order);
    if (!order) abort();
    for (size_t i = 0; i < count; ++i) order[i] = i;
    for (size_t i = count; i > 1; --i) {
        const size_t j = shape_random(&seed) % i, k = order[i - 1];
        order[i - 1] = order[j];
        order[j] = k;
    }
    for (size_t i = 0; i < count; ++i) task(context, order[i]);
    free(order);
}

typedef struct half {
    norma_task *task;
    void *context;
    size_t count, from;
} half;

static void *run_half(void *data) {
    const half *h = data;
    for (size_t i = h->from; i < h->count; i += 2) h->task(h->context, i);
    return NULL;
}

static void run_in_two_threads(void *user, size_t count, norma_task *task, void *context) {
    half odd = {task, context, count, 1}, even = {task, context, count, 0};
    pthread_t thread;
    ++*(size_t *)user;
    if (pthread_create(&thread, NULL, run_half, &odd)) abort();
    run_half(&even);
    pthread_join(thread, NULL);
}

static void same_bits(norma_options options, size_t first, size_t every) {
    static norma_parallel_for *const hooks[] = {run_backwards, run_shuffled, run_in_two_threads};
    static const uint32_t threads[] = {1, 2, 3, 8, 64, NORMA_ALL_THREADS};
    mesh_file mesh = {0};
    answer expected, got;
    make_mesh(&mesh);
    const norma_mesh view = mesh_file_view(&mesh);
    const size_t room = mesh.corner_count + mesh.position_count;
    for (int kind = 0; kind < CALLS; ++kind) {
        answer_create(&expected, room);
        assert_ok(call(kind, &view, options, &expected));
        for (size_t i = first; i < COUNT_OF(threads) + COUNT_OF(hooks); i += every) {
            size_t used = 0;
            norma_options own = options;
            answer_create(&got, room);
            if (i < COUNT_OF(threads))
                own.threads = threads[i];
            else
                own.parallel_for = hooks[i - COUNT_OF(threads)];
            own.parallel_for_user = &used;
            assert_ok(call(kind, &view, own, &got));
            if (!same(&got, &expected)) fail_msg("call %d, setting %zu: other bits", kind, i);
            if (own.parallel_for) assert_true(used > 0);
            answer_free(&got);
        }
        answer_free(&expected);
    }
    mesh_file_free(&mesh);
}

static void defaults(void **state) {
    (void)state;
    same_bits((norma_options){0}, 0, 1);
}

static void every_other_weight(void **state) {
    (void)state;
    for (int w = NORMA_WEIGHT_AREA; norma_weight_name((norma_weight)w); w += SLOWER > 1 ? 2 : 1)
        same_bits((norma_options){.weight = (norma_weight)w}, 3, 4);
}

static void other_options(void **state) {
    (void)state;
    same_bits((norma_options){.weld = NORMA_WELD_NONE,
                  .non_manifold = NORMA_NON_MANIFOLD_SMOOTH,
                  .fallback = NORMA_FALLBACK_NEAREST},
        1, 3);
    same_bits((norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = .01}, 2, 3);
}

static void every_instruction_set(void **state) {
    (void)state;
    mesh_file mesh = {0};
    answer expected, got;
    size_t compared = 0;
    make_mesh(&mesh);
    const norma_mesh view = mesh_file_view(&mesh);
    for (int kind = 0; kind < CALLS; ++kind)
        for (int w = NORMA_WEIGHT_ANGLE; norma_weight_name((norma_weight)w);
             w += SLOWER > 1 ? 6 : 1) { /* bits/ has them all */
            answer_create(&expected, mesh.corner_count + mesh.position_count);
            assert_ok(call(kind, &view,
                (norma_options){.isa = NORMA_ISA_PORTABLE, .weight = (norma_weight)w}, &expected));
            for (int isa = NORMA_ISA_BEST; isa <= NORMA_ISA_SIMD128; ++isa) {
                answer_create(&got, mesh.corner_count + mesh.position_count);
                const norma_result result = call(kind, &view,
                    (norma_options){.isa = (norma_isa)isa, .weight = (norma_weight)w}, &got);
                assert_true(!result || (isa && result == NORMA_ERROR_ARGUMENT));
                if (!result && !same(&got, &expected))
                    fail_msg("call %d, weight %d, instruction set %d: other bits", kind, w, isa);
                compared += !result;
                answer_free(&got);
            }
            answer_free(&expected);
        }
    assert_true(compared > 0);
    mesh_file_free(&mesh);
}

/* So many triangles that several threads halve their tree, and so many points that they share
 * those. */
static void surfaces_compared(void **state) {
    static const uint32_t threads[] = {1, 2, 7};
    (void)state;
    mesh_file meshes[2] = {0};
    norma_surface surfaces[2];
    norma_compare_sample *samples[COUNT_OF(threads)];
    for (int i = 0; i < 2; ++i) {
        shape_wavy_grid(&meshes[i], i ? 80 : 110, 0);
        surfaces[i] = (norma_surface){.mesh = mesh_file_view(&meshes[i])};
        float *normals = test_calloc(meshes[i].position_count, 12);
        assert_ok(
            norma_vertex_normals(&surfaces[i].mesh, NULL, normals, meshes[i].position_count, NULL));
        surfaces[i].normals =
            (norma_vec3_view){normals, meshes[i].position_count, 0, NORMA_FORMAT_FLOAT};
    }
    const size_t count = meshes[1].corner_count;
    for (size_t i = 0; i < COUNT_OF(threads); ++i) {
        samples[i] = test_calloc(count, sizeof **samples);
        assert_ok(norma_compare(&surfaces[0], &surfaces[1], &(norma_options){.threads = threads[i]},
            samples[i], count, NULL));
        assert_memory_equal(samples[i], samples[0], count * sizeof **samples);
    }
    for (size_t i = 0; i < COUNT_OF(threads); ++i) test_free(samples[i]);
    for (int i = 0; i < 2; ++i) {
        test_free((void *)(uintptr_t)surfaces[i].normals.data);
        mesh_file_free(&meshes[i]);
    }
}

/* ---- two callers */

typedef struct caller {
    const norma_mesh *mesh;
    const answer *expected;
    int wrong;
} caller;

static void *call_often(void *data) {
    caller *c = data;
    for (int i = 0; i < 6; ++i)
        for (int kind = 0; kind < CALLS; ++kind) {
            answer got;
            answer_create(&got, c->expected[kind].room);
            if (call(kind, c->mesh, (norma_options){.threads = (uint32_t)(1 + i % 3)}, &got) ||
                !same(&got, &c->expected[kind]))
                c->wrong = 1;
            answer_free(&got);
        }
    return NULL;
}

static void two_callers_at_once(void **state) {
    (void)state;
    mesh_file meshes[2] = {0};
    answer expected[2][CALLS];
    caller callers[4];
    pthread_t threads[4];
    shape_wavy_grid(&meshes[0], 90, 1);
    shape_pole_sphere(&meshes[1], 90, 50, 0);
    const norma_mesh views[2] = {mesh_file_view(&meshes[0]), mesh_file_view(&meshes[1])};
    for (int m = 0; m < 2; ++m)
        for (int kind = 0; kind < CALLS; ++kind) {
            answer_create(&expected[m][kind], meshes[m].corner_count + meshes[m].position_count);
            assert_ok(call(kind, &views[m], (norma_options){0}, &expected[m][kind]));
        }
    for (int i = 0; i < 4; ++i) {
        callers[i] = (caller){&views[i % 2], expected[i % 2], 0};
        assert_int_equal(pthread_create(&threads[i], NULL, call_often, &callers[i]), 0);
    }
    for (int i = 0; i < 4; ++i) {
        pthread_join(threads[i], NULL);
        assert_int_equal(callers[i].wrong, 0);
    }
    for (int m = 0; m < 2; ++m) {
        for (int kind = 0; kind < CALLS; ++kind) answer_free(&expected[m][kind]);
        mesh_file_free(&meshes[m]);
    }
}

/* ---- linear in the mesh */

static double seconds(void) {
    struct timespec now;
    timespec_get(&now, TIME_UTC);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* No measure of speed but a guard against hanging: a linear call takes some seconds under a
 * sanitizer at worst, a quadratic one many minutes. */
#define FAR_TOO_LONG 120
static void finishes_soon(
    const char *name, const norma_mesh *mesh, int kind, norma_options options) {
    answer got;
    answer_create(&got, mesh->corner_count + mesh->positions.count);
    options.threads = 2;
    const double begun = seconds();
    assert_ok(call(kind, mesh, options, &got));
    const double taken = seconds() - begun;
    printf("# %s, call %d: %.2f s\n", name, kind, taken);
    assert_true(taken < FAR_TOO_LONG);
    answer_free(&got);
}

#define MANY (400000 / SLOWER)
#define SOME (MANY / 4)

static void many_triangles_round_one_vertex(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_cone(&mesh, MANY, .5);
    const norma_mesh view = mesh_file_view(&mesh);
    for (int kind = FACES; kind < CALLS; ++kind)
        finishes_soon("a fan", &view, kind, (norma_options){0});
    finishes_soon(
        "a fan, visible", &view, VERTICES, (norma_options){.weight = NORMA_WEIGHT_VISIBLE});
    finishes_soon(
        "a fan, visible", &view, CORNERS, (norma_options){.weight = NORMA_WEIGHT_VISIBLE});
    answer got;
    answer_create(&got, mesh.corner_count);
    assert_ok(call(CORNERS, &view, (norma_options){0}, &got));
    assert_direction(got.normals, 0, 0, 1, 1e-4);
    assert_memory_equal(got.normals, got.normals + 3 * (mesh.corner_count - 3), 12);
    answer_free(&got);
    mesh_file_free(&mesh);
}

/* Every face has the tip at an index of its own: one position again and again. */
static void many_copies_of_one_position(void **state) {
    (void)state;
    mesh_file mesh = {0}, cone = {0};
    shape_cone(&cone, MANY, .5);
    shape_soup(&mesh, &cone);
    norma_mesh view = mesh_file_view(&mesh);
    view.corners = NULL;
    for (int kind = VERTICES; kind < CALLS; ++kind)
        finishes_soon("copies", &view, kind, (norma_options){0});
    finishes_soon("copies within a distance", &view, VERTICES,
        (norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = 1e-9});
    mesh_file_free(&mesh);
    mesh_file_free(&cone);
}

static void make_book(mesh_file *mesh, uint32_t faces) {
    uint64_t seed = 1;
    mesh_file_add_position(mesh, 0, 0, 0);
    mesh_file_add_position(mesh, 0, 0, 1);
    for (uint32_t i = 0; i < faces; ++i) {
        mesh_file_add_position(
            mesh, shape_random_unit(&seed), shape_random_unit(&seed), shape_random_unit(&seed));
        mesh_file_add_face(mesh, (uint32_t[]){i & 1, !(i & 1), i + 2}, 3);
    }
}

/* One edge, many faces along it, also where all of them may share it. */
static void many_faces_along_one_edge(void **state) {
    (void)state;
    mesh_file mesh = {0};
    make_book(&mesh, SOME);
    norma_mesh view = mesh_file_view(&mesh);
    for (int kind = CORNERS; kind < CALLS; ++kind)
        finishes_soon("a book", &view, kind, (norma_options){0});
    mesh_file_free(&mesh);
    make_book(&mesh, MANY);
    view = mesh_file_view(&mesh);
    finishes_soon("a book, smooth", &view, CORNERS,
        (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    mesh_file_free(&mesh);
}

/* Quads that name a position twice have no direction, and there is none to borrow. */
static void many_faces_without_direction_along_one_edge(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint64_t seed = 1;
    mesh_file_add_position(&mesh, 0, 0, 0);
    mesh_file_add_position(&mesh, 0, 0, 1);
    for (uint32_t i = 0; i < SOME; ++i) {
        mesh_file_add_position(
            &mesh, shape_random_unit(&seed), shape_random_unit(&seed), shape_random_unit(&seed));
        mesh_file_add_face(&mesh, (uint32_t[]){i & 1, !(i & 1), i + 2, !(i & 1)}, 4);
    }
    const norma_mesh view = mesh_file_view(&mesh);
    finishes_soon("quads of no area, smooth", &view, CORNERS,
        (norma_options){.non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
    mesh_file_free(&mesh);
}

static void many_triangles_apart(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint64_t seed = 1;
    for (uint32_t i = 0; i < SOME; ++i) {
        const double x = 1000 * shape_random_unit(&seed), y = 1000 * shape_random_unit(&seed),
                     z = 1000 * shape_random_unit(&seed);
        for (int v = 0; v < 3; ++v)
            mesh_file_add_position(&mesh, x + shape_random_unit(&seed),
                y + shape_random_unit(&seed), z + shape_random_unit(&seed));
    }
    norma_mesh view = {.positions = {mesh.positions, mesh.position_count, 0, NORMA_FORMAT_DOUBLE},
        .corner_count = mesh.position_count};
    for (int kind = VERTICES; kind < CORNERS + 1; ++kind)
        finishes_soon("apart", &view, kind, (norma_options){0});
    finishes_soon("apart, within a distance", &view, VERTICES,
        (norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = 1e-9});
    mesh_file_free(&mesh);
}

typedef struct watched {
    double last;
    size_t midway;
} watched;

/* How often something is told while sums are taken. */
static int watch_midway(void *user, double fraction) {
    watched *w = user;
    w->midway += fraction > w->last && fraction > 0.55 && fraction < 0.89;
    w->last = fraction;
    return 0;
}

enum { DISORDERED_POSITIONS = 540000, DISORDERED_TRIANGLES = 1200000 };
typedef struct disorder {
    float (*positions)[3];
    uint32_t (*corners)[3];
} disorder;

/* So many faces with corners anywhere that several threads hand what they measure to each other;
 * some of them, and some positions, are not what they should be. Most sums cancel but for some
 * hundred-thousandth, so that their order shows. */
static norma_mesh make_disorder(disorder *d) {
    enum { POSITIONS = DISORDERED_POSITIONS, TRIANGLES = DISORDERED_TRIANGLES };
    uint64_t seed = 21;
    float(*positions)[3] = malloc(POSITIONS * sizeof *positions);
    uint32_t(*corners)[3] = malloc(TRIANGLES * sizeof *corners);
    if (!positions || !corners) abort();
    for (size_t i = 0; i < POSITIONS; ++i)
        for (int x = 0; x < 3; ++x) positions[i][x] = (float)shape_random_unit(&seed);
    for (size_t i = POSITIONS / 2 + 1; i < POSITIONS; i += 2)
        for (int x = 0; x < 3; ++x)
            positions[i][x] = positions[i - 1][x] + 1e-5f * (float)shape_random_unit(&seed);
    for (size_t i = 0; i < POSITIONS; i += 1009)
        memcpy(positions[i], positions[shape_random(&seed) % POSITIONS], sizeof *positions);
    positions[POSITIONS / 3][1] = NAN;
    for (size_t f = 0; f < TRIANGLES; ++f)
        for (int k = 0; k < 3; ++k) {
            const uint32_t other =
                k == 2 ? corners[f - f % 2][2] + 1 : corners[f - f % 2][1 - k % 2];
            if (f % 997 == 0 && k)
                corners[f][k] = corners[f][0];
            else if (f % 2)
                corners[f][k] = other; /* nearly the reverse of the face before */
            else
                corners[f][k] =
                    k == 2 ? POSITIONS / 2 + 2 * (uint32_t)(shape_random(&seed) % (POSITIONS / 4))
                           : (uint32_t)(shape_random(&seed) % (POSITIONS / 2));
        }
    *d = (disorder){positions, corners};
    return (norma_mesh){.positions = {positions, POSITIONS, 0, NORMA_FORMAT_FLOAT},
        .corners = corners,
        .corner_count = 3 * (size_t)TRIANGLES,
        .corner_size = 4};
}

static void free_disorder(disorder *d) {
    free(d->positions);
    free(d->corners);
}

static void faces_in_no_order(void **state) {
    static const uint32_t threads[] = {2, 13, 64};
    answer expected, got;
    disorder d;
    const norma_mesh mesh = make_disorder(&d);
    (void)state;
    for (int weld = NORMA_WELD_EXACT; weld <= (SLOWER > 1 ? NORMA_WELD_EXACT : NORMA_WELD_NONE);
         ++weld) {
        const norma_options options = {
            .weld = (norma_weld)weld, .weight = weld ? NORMA_WEIGHT_AREA : NORMA_WEIGHT_ANGLE};
        answer_create(&expected, DISORDERED_POSITIONS);
        assert_ok(call(VERTICES, &mesh, options, &expected));
        assert_true(expected.report.degenerate_faces.count > DISORDERED_TRIANGLES / 1000 &&
                    expected.report.degenerate_faces.first == 0);
        for (size_t i = 0; i <= COUNT_OF(threads); i += SLOWER > 1 ? 2 : 1) {
            size_t used = 0;
            watched seen = {0};
            norma_options own = options;
            if (i < COUNT_OF(threads))
                own.threads = threads[i];
            else
                own.parallel_for = run_shuffled;
            own.parallel_for_user = &used;
            own.progress = watch_midway;
            own.progress_user = &seen;
            answer_create(&got, DISORDERED_POSITIONS);
            assert_ok(call(VERTICES, &mesh, own, &got));
            if (!same(&got, &expected)) fail_msg("weld %d, setting %zu: other bits", weld, i);
            if (seen.midway < 8)
                fail_msg(
                    "weld %d, setting %zu: progress told %zu times midway", weld, i, seen.midway);
            answer_free(&got);
        }
        answer_free(&expected);
    }
    free_disorder(&d);
}

/* More threads than there is room for counts of corners: each still sorts a range of its own. */
static void corners_in_no_order(void **state) {
    static const uint32_t threads[] = {2, 13};
    answer expected, got;
    disorder d;
    const norma_mesh mesh = make_disorder(&d);
    (void)state;
    answer_create(&expected, mesh.corner_count);
    assert_ok(call(CORNERS, &mesh, (norma_options){.threads = 1}, &expected));
    for (size_t i = SLOWER > 1 ? 1 : 0; i < COUNT_OF(threads); ++i) {
        answer_create(&got, mesh.corner_count);
        assert_ok(call(CORNERS, &mesh, (norma_options){.threads = threads[i]}, &got));
        if (!same(&got, &expected)) fail_msg("%u threads: other bits", threads[i]);
        answer_free(&got);
    }
    answer_free(&expected);
    free_disorder(&d);
}

/* Half a million vertices without a face: the nearest normal is sought for each. */
static void many_without_a_normal(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 100, 0);
    for (uint32_t i = 0; i < MANY / 2; ++i) mesh_file_add_position(&mesh, 3 + i * 1e-3, 3, 5);
    for (uint32_t i = 0; i < MANY / 4; ++i)
        mesh_file_add_position(&mesh, 3, 3, 9); /* many at one place, which are also without */
    const norma_mesh view = mesh_file_view(&mesh);
    finishes_soon("without", &view, VERTICES, (norma_options){.fallback = NORMA_FALLBACK_NEAREST});
    mesh_file_free(&mesh);
}

/* Who runs the tasks one by one, and counts those that wrote normals. */
typedef struct writers {
    const float *normals; /* set to NaN before */
    size_t count, written, tasks;
} writers;

static size_t count_written(const writers *w) {
    size_t written = 0;
    for (size_t i = 0; i < w->count; ++i) written += isnan(w->normals[3 * i]) ? 0 : 1;
    return written;
}

static void count_writers(void *user, size_t count, norma_task *task, void *context) {
    writers *w = user;
    for (size_t i = 0; i < count; ++i) {
        task(context, i);
        const size_t written = count_written(w);
        w->tasks += written > w->written;
        w->written = written;
    }
}

/* A strip of ten rows of 3,000: so long that its positions make only a few ranges. As many work on
 * them as there are, not one. */
static void few_ranges_are_shared(void **state) {
    enum { ROWS = 10, LONG = 3000 };
    (void)state;
    mesh_file mesh = {0};
    for (uint32_t i = 0; i < ROWS * LONG; ++i)
        mesh_file_add_position(&mesh, i % LONG, i / LONG, sin(i % LONG * .01));
    for (uint32_t i = 0; i + LONG < ROWS * LONG; ++i) {
        if (i % LONG == LONG - 1) continue;
        mesh_file_add_face(&mesh, (uint32_t[]){i, i + 1, i + LONG}, 3);
        mesh_file_add_face(&mesh, (uint32_t[]){i + 1, i + LONG + 1, i + LONG}, 3);
    }
    const norma_mesh view = mesh_file_view(&mesh);
    answer a;
    answer_create(&a, mesh.position_count);
    memset(a.normals, 0xff, 12 * a.room);
    writers seen = {a.normals, a.room, 0, 0};
    assert_ok(call(VERTICES, &view,
        (norma_options){.parallel_for = count_writers, .parallel_for_user = &seen}, &a));
    assert_int_equal(count_written(&seen), a.room);
    if (seen.tasks < 2) fail_msg("%zu tasks wrote all normals", seen.tasks);
    answer_free(&a);
    mesh_file_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults),
        cmocka_unit_test(every_other_weight),
        cmocka_unit_test(other_options),
        cmocka_unit_test(every_instruction_set),
        cmocka_unit_test(surfaces_compared),
        cmocka_unit_test(faces_in_no_order),
        cmocka_unit_test(corners_in_no_order),
        cmocka_unit_test(few_ranges_are_shared),
        cmocka_unit_test(two_callers_at_once),
        cmocka_unit_test(many_triangles_round_one_vertex),
        cmocka_unit_test(many_copies_of_one_position),
        cmocka_unit_test(many_faces_along_one_edge),
        cmocka_unit_test(many_faces_without_direction_along_one_edge),
        cmocka_unit_test(many_triangles_apart),
        cmocka_unit_test(many_without_a_normal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
