/* bench_core.c: the core against memcpy, in one process. 1x is the least traffic of a call on a
 * mesh of two triangles a vertex, at memcpy's rate: 24 bytes a triangle read or written, which is
 * what copying 12 bytes a triangle moves. Prints, for each case, ns per triangle, multiples of 1x,
 * what a call costs whose scratch memory is fresh, and scratch bytes, each beside what is asked.
 * All times are the least of several. */
#include "made_meshes.h"
#include "timing.h"
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef enum bench_call { FACES, VERTICES, CORNERS, SPLIT } bench_call;
typedef enum bench_shape { ROWS, SHUFFLED } bench_shape;

typedef struct bench_case {
    const char *name;
    bench_call call;
    norma_weight weight;
    norma_weld weld;
    double asked[2][2];   /* multiples of 1x: [shape][threads - 1]; 0: nothing was asked */
    double asked_scratch; /* bytes per triangle */
} bench_case;

static const bench_case CASES[] = {
    {"faces", FACES, NORMA_WEIGHT_ANGLE, NORMA_WELD_NONE, {{0, 0}, {0, 0}}, 0},
    {"vertices-index-angle", VERTICES, NORMA_WEIGHT_ANGLE, NORMA_WELD_NONE, {{8.5, 5.2}, {30, 16}},
        24},
    {"vertices-index-area", VERTICES, NORMA_WEIGHT_AREA, NORMA_WELD_NONE, {{6.5, 4.5}, {0, 0}}, 24},
    {"vertices-default", VERTICES, NORMA_WEIGHT_ANGLE, NORMA_WELD_EXACT, {{18, 10}, {41, 23}}, 24},
    {"vertices-default-area", VERTICES, NORMA_WEIGHT_AREA, NORMA_WELD_EXACT, {{0, 0}, {0, 0}}, 24},
    {"corners-60", CORNERS, NORMA_WEIGHT_ANGLE, NORMA_WELD_EXACT, {{42, 24}, {250, 140}}, 40},
    {"split-60", SPLIT, NORMA_WEIGHT_ANGLE, NORMA_WELD_EXACT, {{0, 0}, {0, 0}}, 0},
};
enum { CASES_COUNT = sizeof CASES / sizeof *CASES };

typedef struct bench {
    size_t triangles, runs;
    norma_isa isa;
    const char *only;      /* cases whose name holds this */
    double nanoseconds_1x; /* per triangle */
} bench;

static const float CREASE_60 = 1.0471975512F;

static void stop_at(norma_result result, const char *what) {
    if (!result) return;
    fprintf(stderr, "bench: %s: %s\n", what, norma_result_text(result));
    exit(3);
}

/* ---- meshes */

typedef struct outputs {
    float *normals;
    uint32_t *corners, *sources;
    size_t capacity;
} outputs;

static outputs outputs_for(const made_mesh *mesh) {
    const size_t capacity =
        mesh->corner_count > mesh->position_count ? mesh->corner_count : mesh->position_count;
    return (outputs){bench_memory(3 * capacity, sizeof(float)),
        bench_memory(capacity, sizeof(uint32_t)), bench_memory(capacity, sizeof(uint32_t)),
        capacity};
}

static void free_outputs(outputs *out) {
    free(out->normals);
    free(out->corners);
    free(out->sources);
}

static norma_result call_once(
    bench_call call, const norma_mesh *mesh, const norma_options *options, const outputs *out) {
    size_t count;
    if (call == FACES) return norma_face_normals(mesh, options, out->normals, out->capacity, NULL);
    if (call == VERTICES)
        return norma_vertex_normals(mesh, options, out->normals, out->capacity, NULL);
    if (call == CORNERS)
        return norma_corner_normals(mesh, CREASE_60, options, out->normals, out->capacity, NULL);
    return norma_split(mesh, CREASE_60, options, out->corners, out->capacity, out->sources,
        out->normals, out->capacity, &count, NULL);
}

/* Nanoseconds per triangle: the least of runs. */
static double time_call(const bench_case *c, const norma_mesh *mesh, const norma_options *options,
    const outputs *out, size_t runs) {
    double *times = bench_memory(runs, sizeof *times);
    for (size_t run = 0; run < runs; ++run) {
        const double begun = bench_now();
        stop_at(call_once(c->call, mesh, options, out), c->name);
        times[run] = bench_now() - begun;
    }
    const double least = bench_least(times, runs);
    free(times);
    return 1e9 * least / (double)(mesh->corner_count / 3);
}

static void print_asked(double value, double asked) {
    if (asked > 0)
        printf("%7.1fx asked %5.1fx %-4s", value, asked, value <= asked ? "ok" : "over");
    else
        printf("%7.1fx%17s", value, "");
}

/* Bytes per triangle that a call needs beside input and output. */
static double scratch_of(
    const bench_case *c, const norma_mesh *mesh, norma_options options, const outputs *out) {
    bench_pool pool = {0};
    options.allocator = bench_pool_allocator(&pool);
    (void)time_call(c, mesh, &options, out, 1);
    const double bytes = (double)pool.most_in_use / (double)(mesh->corner_count / 3);
    bench_pool_free(&pool);
    return bytes;
}

static void bench_one(const bench *b, const bench_case *c, bench_shape shape,
    const norma_mesh *mesh, const outputs *out) {
    for (uint32_t threads = 1; threads <= bench_threads(); ++threads) {
        bench_pool pool = {0};
        norma_options options = {
            .weight = c->weight, .weld = c->weld, .threads = threads, .isa = b->isa};
        const double first = time_call(c, mesh, &options, out,
            b->runs > 3 ? 3 : b->runs); /* scratch from the system, its pages not there yet */
        options.allocator = bench_pool_allocator(&pool);
        (void)time_call(c, mesh, &options, out, 1);
        const double warm = time_call(c, mesh, &options, out, b->runs);
        printf("%-22s %-8s %u thread%s %7.2f ns", c->name, shape == ROWS ? "rows" : "shuffled",
            threads, threads > 1 ? "s" : " ", warm);
        print_asked(warm / b->nanoseconds_1x, c->asked[shape][threads - 1]);
        printf("  fresh %.2f times, asked 1.5 %s\n", first / warm,
            first <= 1.5 * warm ? "ok" : "over");
        fflush(stdout);
        bench_pool_free(&pool);
    }
    if (c->asked_scratch == 0) return;
    printf("%-22s %-8s scratch, bytes a triangle, asked %.0f:", c->name,
        shape == ROWS ? "rows" : "shuffled", c->asked_scratch);
    for (uint32_t threads = 1; threads <= 8; threads *= 2)
        printf("  %u thread%s %.1f", threads, threads > 1 ? "s" : "",
            scratch_of(c, mesh,
                (norma_options){
                    .weight = c->weight, .weld = c->weld, .threads = threads, .isa = b->isa},
                out));
    printf("\n");
    fflush(stdout);
}

static int is_wanted(const bench *b, const char *name) { return !b->only || strstr(name, b->only); }

static void bench_meshes(const bench *b) {
    int any = 0;
    for (size_t i = 0; i < CASES_COUNT; ++i) any |= is_wanted(b, CASES[i].name);
    if (!any) return;
    made_mesh mesh = made_grid(b->triangles);
    outputs out = outputs_for(&mesh);
    for (int shape = ROWS; shape <= SHUFFLED; ++shape) {
        if (shape == SHUFFLED) made_shuffle(&mesh);
        const norma_mesh view = made_view(&mesh);
        for (size_t i = 0; i < CASES_COUNT; ++i)
            if (is_wanted(b, CASES[i].name))
                bench_one(b, &CASES[i], (bench_shape)shape, &view, &out);
    }
    free_outputs(&out);
    made_free(&mesh);
}

/* ---- the same mesh in other dress, beside the plain one: 32-bit triangles of floats, the best
 * instruction set */

typedef enum bench_dress { PLAIN, QUADS, SHORTS, DOUBLES, AVX2, DRESSES } bench_dress;
static const char *const DRESS_NAMES[] = {"plain", "quads", "16-bit", "doubles", "avx2"};
static const double DRESS_ASKED[] = {0, 1.5, 1.25, 1.8, 1.3};
static const bench_case DRESS_CASES[] = {{.name = "dress-faces", .call = FACES},
    {.name = "dress-index", .call = VERTICES, .weld = NORMA_WELD_NONE},
    {.name = "dress-area", .call = VERTICES, .weight = NORMA_WEIGHT_AREA, .weld = NORMA_WELD_NONE},
    {.name = "dress-default", .call = VERTICES}, {.name = "dress-corners", .call = CORNERS}};
enum { DRESS_CASE_COUNT = sizeof DRESS_CASES / sizeof *DRESS_CASES };

typedef struct dressed_mesh {
    made_mesh mesh;
    double *positions;
    uint16_t *shorts;
    uint32_t *quads, *starts;
} dressed_mesh;

/* Of at most 65,536 vertices. */
static dressed_mesh dress_up(void) {
    enum { TRIANGLES = 120000 };
    dressed_mesh d = {.mesh = made_grid(TRIANGLES)};
    const size_t corners = d.mesh.corner_count, quads = corners / 6;
    d.positions = bench_memory(3 * d.mesh.position_count, sizeof *d.positions);
    d.shorts = bench_memory(corners, sizeof *d.shorts);
    d.quads = bench_memory(4 * quads, sizeof *d.quads);
    d.starts = bench_memory(quads + 1, sizeof *d.starts);
    for (size_t i = 0; i < 3 * d.mesh.position_count; ++i)
        d.positions[i] = (double)d.mesh.positions[i / 3][i % 3];
    for (size_t c = 0; c < corners; ++c) d.shorts[c] = (uint16_t)d.mesh.corners[c];
    for (size_t q = 0; q < quads; ++q) {
        const uint32_t *two = d.mesh.corners + 6 * q;
        memcpy(d.quads + 4 * q, (uint32_t[]){two[0], two[1], two[2], two[5]}, 4 * sizeof *two);
        d.starts[q + 1] = (uint32_t)(4 * (q + 1));
    }
    return d;
}

static norma_mesh dressed_view(const dressed_mesh *d, bench_dress dress) {
    norma_mesh view = made_view(&d->mesh);
    if (dress == QUADS) {
        view.corners = d->quads;
        view.face_starts = d->starts;
        view.face_count = view.corner_count / 6;
        view.corner_count = 4 * view.face_count;
    } else if (dress == SHORTS) {
        view.corners = d->shorts;
        view.corner_size = sizeof *d->shorts;
    } else if (dress == DOUBLES) {
        view.positions =
            (norma_vec3_view){d->positions, d->mesh.position_count, 0, NORMA_FORMAT_DOUBLE};
    }
    return view;
}

/* All in turn, so that what else the machine does befalls them alike; the least of each. */
static void bench_dressed(const bench *b, const bench_case *c, const dressed_mesh *d) {
    enum { TURNS = 40 };
    double least[DRESSES];
    bench_pool pool = {0};
    outputs out = outputs_for(&d->mesh);
    for (int i = 0; i < TURNS * DRESSES; ++i) {
        const bench_dress dress = (bench_dress)(i % DRESSES);
        const norma_mesh view = dressed_view(d, dress);
        const norma_options options = {.weight = c->weight,
            .weld = c->weld,
            .isa = dress == AVX2 ? NORMA_ISA_AVX2 : b->isa,
            .allocator = bench_pool_allocator(&pool)};
        const double begun = bench_now();
        stop_at(call_once(c->call, &view, &options, &out), c->name);
        const double ns = 1e9 * (bench_now() - begun) / (double)(d->mesh.corner_count / 3);
        if (i < DRESSES || ns < least[dress]) least[dress] = ns;
    }
    for (int dress = PLAIN; dress < DRESSES; ++dress) {
        printf("%-14s %-8s %7.2f ns", c->name, DRESS_NAMES[dress], least[dress]);
        if (dress != PLAIN)
            printf("  %.2f of plain, asked %.2f %s", least[dress] / least[PLAIN],
                DRESS_ASKED[dress],
                least[dress] <= DRESS_ASKED[dress] * least[PLAIN] ? "ok" : "over");
        printf("\n");
    }
    free_outputs(&out);
    bench_pool_free(&pool);
}

static void bench_dresses(const bench *b) {
    if (!is_wanted(b, "dress")) return;
    dressed_mesh d = dress_up();
    for (size_t i = 0; i < DRESS_CASE_COUNT; ++i) bench_dressed(b, &DRESS_CASES[i], &d);
    free(d.positions);
    free(d.shorts);
    free(d.quads);
    free(d.starts);
    made_free(&d.mesh);
}

/* ---- small meshes: microseconds a call, default options but for all threads, memory from malloc;
 * one with creases at most edges, and one that is smooth */

static void bench_small_mesh(const char *shape, const made_mesh *mesh) {
    enum { CALLS = 2000 };
    static const double asked[] = {0, 2, 6, 0};
    static const char *const names[] = {"faces", "vertices", "corners", "split"};
    const norma_options options = {.threads = NORMA_ALL_THREADS};
    outputs out = outputs_for(mesh);
    const norma_mesh view = made_view(mesh);
    for (int call = FACES; call <= SPLIT; ++call) {
        double times[9];
        for (int run = 0; run < 9; ++run) {
            const double begun = bench_now();
            for (int i = 0; i < CALLS; ++i)
                stop_at(call_once((bench_call)call, &view, &options, &out), names[call]);
            times[run] = 1e6 * (bench_now() - begun) / CALLS;
        }
        const double least = bench_least(times, 9);
        printf("small-%-9s %-6s %zu triangles %7.2f us a call", names[call], shape,
            mesh->corner_count / 3, least);
        if (asked[call] > 0)
            printf("  asked %.0f us %s", asked[call], least <= asked[call] ? "ok" : "over");
        printf("\n");
    }
    free_outputs(&out);
}

static void bench_small(const bench *b) {
    enum { SMALL = 160 };
    if (!is_wanted(b, "small")) return;
    made_mesh mesh = made_grid(SMALL);
    bench_small_mesh("rough", &mesh);
    for (size_t i = 0; i < mesh.position_count; ++i) mesh.positions[i][2] *= 0.05F;
    bench_small_mesh("smooth", &mesh);
    made_free(&mesh);
}

/* ---- transforms and matrices, against memcpy of the bytes that they read */

static void print_against_copy(
    const char *name, double seconds, double copy, double count, double asked) {
    printf("%-36s %7.2f ns each %7.2f of memcpy, asked %.2f %s\n", name, 1e9 * seconds / count,
        seconds / copy, asked, seconds <= asked * copy ? "ok" : "over");
}

static void bench_transforms(const bench *b) {
    enum { NORMALS = 10000000 };
    if (!is_wanted(b, "transform-normals")) return;
    const float matrix[9] = {0.5F, 0.1F, 0, -0.2F, 1.5F, 0.3F, 0, 0.25F, 2};
    float *in = bench_memory(3 * (size_t)NORMALS, sizeof *in),
          *out = bench_memory(3 * (size_t)NORMALS, sizeof *out);
    double *apart = bench_memory(b->runs, sizeof *apart),
           *in_place = bench_memory(b->runs, sizeof *in_place);
    for (size_t i = 0; i < NORMALS; ++i) {
        const double a = (double)i * 0.7, z = cos((double)i * 0.3), r = sqrt(1 - z * z);
        in[3 * i] = (float)(r * cos(a));
        in[3 * i + 1] = (float)(r * sin(a));
        in[3 * i + 2] = (float)z;
    }
    const double copy = bench_memcpy_seconds(12 * (size_t)NORMALS, b->runs);
    for (size_t run = 0; run < b->runs; ++run) {
        double begun = bench_now();
        stop_at(norma_transform_normals(
                    matrix, (norma_vec3_view){in, NORMALS, 0, NORMA_FORMAT_FLOAT}, out, 0, NORMALS),
            "transform");
        apart[run] = bench_now() - begun;
    }
    for (size_t run = 0; run < b->runs; ++run) {
        double begun = bench_now();
        stop_at(norma_transform_normals(
                    matrix, (norma_vec3_view){in, NORMALS, 0, NORMA_FORMAT_FLOAT}, in, 0, NORMALS),
            "transform");
        in_place[run] = bench_now() - begun;
    }
    print_against_copy("transform-normals", bench_least(apart, b->runs), copy, NORMALS, 0.9);
    print_against_copy(
        "transform-normals in place", bench_least(in_place, b->runs), copy, NORMALS, 0.85);
    free(in);
    free(out);
    free(apart);
    free(in_place);
}

/* Calls share out a batch as they like: norma_normal_matrices works on the calling thread. */
typedef struct matrix_share {
    const float *models;
    float *matrices;
    size_t count;
    norma_result result;
    pthread_t thread;
} matrix_share;

static void *make_share(void *context) {
    matrix_share *s = context;
    s->result =
        norma_normal_matrices(s->models, s->count, NORMA_WINDING_REVERSED, s->matrices, s->count);
    return NULL;
}

/* Models as scenes have them: turned, scaled unevenly, sheared, some mirrored. A copy moves what a
 * call must: 64 bytes in and 36 out, so 50 of each. */
static void bench_matrices(const bench *b) {
    enum { MODELS = 1000000 };
    if (!is_wanted(b, "normal-matrices")) return;
    float *models = bench_memory(16 * (size_t)MODELS, sizeof *models),
          *matrices = bench_memory(9 * (size_t)MODELS, sizeof *matrices);
    double *times = bench_memory(b->runs, sizeof *times);
    uint32_t state = 1;
    for (size_t i = 0; i < 16 * (size_t)MODELS; ++i) {
        state = state * 1664525U + 1013904223U;
        models[i] = (float)(state >> 8) * 0x1p-23F - 1;
    }
    const double copy = bench_memcpy_seconds(50 * (size_t)MODELS, b->runs);
    for (size_t threads = 1; threads <= bench_threads(); ++threads) {
        for (size_t run = 0; run < b->runs; ++run) {
            matrix_share shares[2];
            const double begun = bench_now();
            for (size_t i = 0; i < threads; ++i) {
                const size_t from = i * MODELS / threads;
                shares[i] = (matrix_share){
                    models + 16 * from, matrices + 9 * from, MODELS / threads, NORMA_OK, 0};
                if (i + 1 < threads &&
                    pthread_create(&shares[i].thread, NULL, make_share, &shares[i]))
                    stop_at(NORMA_ERROR_MEMORY, "a thread");
            }
            make_share(&shares[threads - 1]);
            for (size_t i = 0; i + 1 < threads; ++i) pthread_join(shares[i].thread, NULL);
            times[run] = bench_now() - begun;
            for (size_t i = 0; i < threads; ++i) stop_at(shares[i].result, "matrices");
        }
        print_against_copy(threads == 1 ? "normal-matrices, 1 thread"
                                        : "normal-matrices, 2 threads of the caller's",
            bench_least(times, b->runs), copy, MODELS, threads == 1 ? 1.1 : 0.65);
    }
    free(models);
    free(matrices);
    free(times);
}

/* ---- cost grows with the mesh, whatever its shape: beside the smallest of the same shape, from
 * which a straight line would be 1 */

typedef struct growth_shape {
    const char *name;
    made_mesh (*make)(size_t triangles);
    size_t triangles[3];
} growth_shape;

static const growth_shape GROWTH[] = {
    {"linear-rows", made_grid, {1000000, 10000000, 50000000}},
    {"linear-valence", made_fan, {100000, 1000000}}, /* all round one vertex; ten million would be
                                                        needles, which doubles do not measure */
    {"linear-position", made_tips, {100000, 1000000, 10000000}},
    {"linear-apart", made_soup, {100000, 1000000, 10000000}},
};
static const bench_case GROWTH_CASES[] = {
    {.name = "index", .call = VERTICES, .weld = NORMA_WELD_NONE},
    {.name = "default", .call = VERTICES}, {.name = "corners 60", .call = CORNERS}};
enum {
    GROWTH_COUNT = sizeof GROWTH / sizeof *GROWTH,
    GROWTH_CASE_COUNT = sizeof GROWTH_CASES / sizeof *GROWTH_CASES
};

/* The least of runs after one that brings the memory. */
static double least_time(const bench_case *c, const norma_mesh *view, const norma_options *options,
    const outputs *out, size_t runs) {
    double least = time_call(c, view, options, out, 1);
    for (size_t run = 0; run < runs; ++run) {
        const double time = time_call(c, view, options, out, 1);
        if (time < least) least = time;
    }
    return least;
}

/* first: the times of the shape's smallest mesh, set where triangles are the first of all. */
static void bench_growth(const bench *b, const growth_shape *shape, size_t triangles,
    double first[GROWTH_CASE_COUNT][2]) {
    made_mesh mesh = shape->make(triangles);
    outputs out = outputs_for(&mesh);
    const norma_mesh view = made_view(&mesh);
    const double made = (double)(mesh.corner_count / 3);
    for (size_t i = 0; i < GROWTH_CASE_COUNT; ++i) {
        printf("%-16s %8.0f triangles  %-11s", shape->name, made, GROWTH_CASES[i].name);
        for (uint32_t threads = 1; threads <= bench_threads(); ++threads) {
            bench_pool pool = {0};
            const norma_options options = {.weld = GROWTH_CASES[i].weld,
                .threads = threads,
                .isa = b->isa,
                .allocator = bench_pool_allocator(&pool)};
            const double ns = least_time(&GROWTH_CASES[i], &view, &options, &out,
                triangles < 5000000 ? 2 * b->runs
                : b->runs < 3       ? b->runs
                                    : 3);
            if (triangles == shape->triangles[0]) first[i][threads - 1] = ns;
            printf("  %u thread%s %7.2f ns (%.2f)", threads, threads > 1 ? "s" : " ", ns,
                ns / first[i][threads - 1]);
            if (threads == bench_threads())
                printf("  scratch %5.1f bytes\n", (double)pool.most_in_use / made);
            fflush(stdout);
            bench_pool_free(&pool);
        }
    }
    free_outputs(&out);
    made_free(&mesh);
}

static void bench_linear(const bench *b) {
    if (!b->only || strncmp(b->only, "linear", 6) != 0)
        return; /* only when asked for: it takes long */
    for (size_t i = 0; i < GROWTH_COUNT; ++i) {
        double first[GROWTH_CASE_COUNT][2] = {{0}};
        for (size_t k = 0; k < 3 && GROWTH[i].triangles[k] && is_wanted(b, GROWTH[i].name); ++k)
            bench_growth(b, &GROWTH[i], GROWTH[i].triangles[k], first);
    }
}

/* ---- */

static norma_isa isa_named(const char *name) {
    static const char *const names[] = {
        "best", "portable", "sse2", "avx2", "avx512", "neon", "simd128"};
    for (int i = 0; i < (int)(sizeof names / sizeof *names); ++i)
        if (!strcmp(name, names[i])) return (norma_isa)i;
    fprintf(stderr, "bench: %s is no instruction set\n", name);
    exit(2);
}

static bench read_arguments(int count, char **arguments) {
    bench b = {.triangles = 10000000, .runs = 7};
    for (int i = 1; i < count; ++i) {
        const char *value = i + 1 < count ? arguments[i + 1] : NULL;
        if (value && !strcmp(arguments[i], "--triangles"))
            b.triangles = strtoull(value, NULL, 10);
        else if (value && !strcmp(arguments[i], "--runs"))
            b.runs = strtoull(value, NULL, 10);
        else if (value && !strcmp(arguments[i], "--isa"))
            b.isa = isa_named(value);
        else if (value && !strcmp(arguments[i], "--only"))
            b.only = value;
        else
            b.runs = 0;
        ++i;
    }
    if (b.runs && b.triangles) return b;
    fprintf(stderr, "usage: bench_core [--triangles 10000000] [--runs 7] [--isa "
                    "best|portable|sse2|avx2|avx512] [--only PART OF A NAME|linear]\n");
    exit(2);
}

int main(int count, char **arguments) {
    bench b = read_arguments(count, arguments);
    b.nanoseconds_1x = 1e9 * bench_memcpy_seconds(12 * b.triangles, b.runs) / (double)b.triangles;
    printf("1x = %.3f ns per triangle (memcpy of 12 bytes)\n", b.nanoseconds_1x);
    bench_meshes(&b);
    bench_dresses(&b);
    bench_small(&b);
    bench_transforms(&b);
    bench_matrices(&b);
    bench_linear(&b);
    return 0;
}
