/* bench_uses.c: the core as it is used, beside the plain case of bench_core: real meshes, cold
 * caches, double positions, 16-bit corners, positions inside a vertex record, many instances, and
 * how a call goes on more cores than the machine has. bench_uses [--only PART OF A NAME] [MESH
 * FILE...] Per triangle in nanoseconds, one thread unless said; the least of several calls, but for
 * cold ones, each of which comes after the caches were filled with other things. */
#include "made_meshes.h"
#include "timing.h"
#include <norma/document.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUNS = 25, COLD_RUNS = 5, COLD_BYTES = 128 << 20 };
static const float CREASE_60 = 1.0471975512F;

typedef enum use_call { BY_INDEX, DEFAULT, CORNERS, CALLS } use_call;
static const char *const CALL_NAMES[CALLS] = {
    "vertices, by index", "vertices, default", "corners, crease 60"};

static void stop_at(norma_result result, const char *what) {
    if (!result) return;
    fprintf(stderr, "bench: %s: %s\n", what, norma_result_text(result));
    exit(3);
}

static size_t triangles_of(const norma_mesh *mesh) {
    return mesh->face_starts ? mesh->corner_count - 2 * mesh->face_count : mesh->corner_count / 3;
}

static void call_once(use_call call, const norma_mesh *mesh, norma_options *options, float *normals,
    size_t capacity) {
    options->weld = call == BY_INDEX ? NORMA_WELD_NONE : NORMA_WELD_EXACT;
    stop_at(call == CORNERS
                ? norma_corner_normals(mesh, CREASE_60, options, normals, capacity, NULL)
                : norma_vertex_normals(mesh, options, normals, capacity, NULL),
        CALL_NAMES[call]);
}

static size_t capacity_of(const norma_mesh *mesh) {
    return mesh->corner_count > mesh->positions.count ? mesh->corner_count : mesh->positions.count;
}

/* Nanoseconds per triangle; thrown: NULL, or a block to write before each call, so that nothing of
 * the mesh is left in a cache. */
static double least_time(
    use_call call, const norma_mesh *mesh, norma_options *options, unsigned char *thrown) {
    const size_t capacity = capacity_of(mesh);
    float *normals = bench_memory(3 * capacity, sizeof *normals);
    double least = 1e300;
    for (int run = 0; run < (thrown ? COLD_RUNS : RUNS); ++run) {
        if (thrown) memset(thrown, run, COLD_BYTES);
        const double begun = bench_now();
        call_once(call, mesh, options, normals, capacity);
        const double took = bench_now() - begun;
        least = took < least ? took : least;
    }
    free(normals);
    return 1e9 * least / (double)triangles_of(mesh);
}

/* ---- layouts of one mesh */

static void print_layout(const char *name, const norma_mesh *mesh) {
    printf("%-36s", name);
    for (use_call call = BY_INDEX; call < CALLS; ++call) {
        bench_pool pool = {0};
        norma_options options = {.allocator = bench_pool_allocator(&pool)};
        printf(" %10.2f", least_time(call, mesh, &options, NULL));
        bench_pool_free(&pool);
    }
    printf("\n");
    fflush(stdout);
}

static void bench_layouts(void) {
    enum { RECORD = 8 }; /* position, normal, texture coordinates: 32 bytes a vertex */
    made_mesh made = made_grid(2000000), small = made_grid(120000);
    norma_mesh mesh = made_view(&made), narrow = made_view(&small);
    double *doubles = bench_memory(3 * made.position_count, sizeof *doubles);
    float *records = bench_memory(RECORD * made.position_count, sizeof *records);
    uint16_t *shorts = bench_memory(small.corner_count, sizeof *shorts);
    for (size_t i = 0; i < made.position_count; ++i)
        for (size_t k = 0; k < 3; ++k) {
            doubles[3 * i + k] = (double)made.positions[i][k];
            records[RECORD * i + k] = made.positions[i][k];
        }
    for (size_t i = 0; i < small.corner_count; ++i) shorts[i] = (uint16_t)small.corners[i];
    printf("%-36s %10s %10s %10s   ns per triangle\n", "how a mesh lies in memory", "by index",
        "default", "corners 60");
    print_layout("2 million, float, 12 bytes apart", &mesh);
    mesh.positions = (norma_vec3_view){doubles, made.position_count, 0, NORMA_FORMAT_DOUBLE};
    print_layout("2 million, double", &mesh);
    mesh.positions = (norma_vec3_view){
        records, made.position_count, RECORD * sizeof *records, NORMA_FORMAT_FLOAT};
    print_layout("2 million, float, 32 bytes apart", &mesh);
    print_layout("120,000, 32-bit corners", &narrow);
    narrow.corners = shorts;
    narrow.corner_size = sizeof *shorts;
    print_layout("120,000, 16-bit corners", &narrow);
    free(doubles);
    free(records);
    free(shorts);
    made_free(&made);
    made_free(&small);
}

/* ---- meshes that people made, warm and cold */

/* The mesh of the file with the most triangles. */
static int largest_mesh(norma_document *document, norma_mesh *mesh) {
    size_t best = SIZE_MAX, most = 0;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) {
        norma_mesh_info info;
        if (norma_document_mesh_info(document, i, &info) || info.not_read || info.triangles <= most)
            continue;
        most = info.triangles;
        best = i;
    }
    norma_mesh_data data;
    if (best == SIZE_MAX || norma_document_mesh_data(document, best, &data, NULL)) return 0;
    *mesh = data.mesh;
    return 1;
}

static void bench_file(const char *path, unsigned char *thrown) {
    norma_document *document;
    norma_document_error error;
    norma_mesh mesh;
    const char *slash = strrchr(path, '/');
    if (norma_document_open(path, NULL, &document, &error)) {
        printf("%s\n", error.message);
        return;
    }
    if (largest_mesh(document, &mesh)) {
        printf("%-32.32s %9zu", slash ? slash + 1 : path, triangles_of(&mesh));
        for (use_call call = BY_INDEX; call < CALLS; ++call) {
            bench_pool pool = {0};
            norma_options options = {.allocator = bench_pool_allocator(&pool)};
            const double warm = least_time(call, &mesh, &options, NULL),
                         cold = least_time(call, &mesh, &options, thrown);
            options.threads = bench_threads();
            printf("  | %7.1f %7.1f %7.1f", warm, least_time(call, &mesh, &options, NULL), cold);
            bench_pool_free(&pool);
        }
        printf("\n");
        fflush(stdout);
    }
    norma_document_close(document);
}

static void bench_files(int count, char **paths) {
    unsigned char *thrown = bench_memory(COLD_BYTES, 1);
    printf("%-32s %9s", "mesh", "triangles");
    for (use_call call = BY_INDEX; call < CALLS; ++call) printf("  | %-23s", CALL_NAMES[call]);
    printf("\n%-42s", "");
    for (use_call call = BY_INDEX; call < CALLS; ++call)
        printf("  | %7s %7s %7s", "warm", "2 thr.", "cold");
    printf("\n");
    for (int i = 0; i < count; ++i) bench_file(paths[i], thrown);
    free(thrown);
}

/* ---- instances */

static double seconds_of_copy(size_t bytes) { return bench_memcpy_seconds(bytes, RUNS); }

/* A forest: each tree turned about the vertical, of its own size. Copying moves what must be moved,
 * 64 bytes in and 36 out. */
static void bench_instances(void) {
    enum { INSTANCES = 100000 };
    float *models = bench_memory(16 * (size_t)INSTANCES, sizeof *models),
          *matrices = bench_memory(9 * (size_t)INSTANCES, sizeof *matrices);
    uint32_t state = 1;
    for (size_t i = 0; i < INSTANCES; ++i) {
        float *m = models + 16 * i, turn[2], size[3];
        for (int k = 0; k < 5; ++k) {
            state = state * 1664525U + 1013904223U;
            const float random = (float)(state >> 8) * 0x1p-24F;
            if (k < 2)
                turn[k] = 2 * random - 1;
            else
                size[k - 2] = 0.5F + random;
        }
        m[0] = turn[0] * size[0], m[2] = -turn[1] * size[0], m[5] = size[1],
        m[8] = turn[1] * size[2], m[10] = turn[0] * size[2], m[15] = 1;
    }
    double least = 1e300;
    for (int run = 0; run < 5 * RUNS; ++run) {
        const double begun = bench_now();
        stop_at(
            norma_normal_matrices(models, INSTANCES, NORMA_WINDING_REVERSED, matrices, INSTANCES),
            "instances");
        const double took = bench_now() - begun;
        least = took < least ? took : least;
    }
    printf("%-36s %.3f ms, %.2f ns each, %.2f of a copy\n", "100,000 instances' normal matrices",
        1e3 * least, 1e9 * least / INSTANCES, least / seconds_of_copy(50 * (size_t)INSTANCES));
    free(models);
    free(matrices);
}

/* ---- more cores than there are: each job is timed alone, and a call on so many cores takes what
 * is outside of jobs, and between two barriers what the busiest core gets */

typedef struct core_model {
    size_t cores, barriers, jobs;
    double in_jobs, busiest; /* seconds: of all jobs; of the busiest core of each barrier, summed */
} core_model;

/* Jobs go in order to the core that is free first, as a pool of threads does it. */
static void run_jobs(void *user, size_t count, norma_task *task, void *context) {
    core_model *model = user;
    double busy[64] = {0}, most = 0;
    for (size_t i = 0; i < count; ++i) {
        const double begun = bench_now();
        task(context, i);
        const double took = bench_now() - begun;
        size_t free_first = 0;
        for (size_t c = 1; c < model->cores; ++c)
            if (busy[c] < busy[free_first]) free_first = c;
        busy[free_first] += took;
        model->in_jobs += took;
    }
    for (size_t c = 0; c < model->cores; ++c) most = busy[c] > most ? busy[c] : most;
    model->busiest += most;
    model->jobs += count;
    ++model->barriers;
}

static void bench_cores(void) {
    static const size_t cores[] = {1, 2, 4, 8, 16, 32};
    made_mesh made = made_grid(2000000);
    for (int order = 0; order < 2; ++order) {
        if (order) made_shuffle(&made);
        const norma_mesh mesh = made_view(&made);
        float *normals = bench_memory(3 * made.corner_count, sizeof *normals);
        for (use_call call = BY_INDEX; call < CALLS; ++call) {
            double alone = 0;
            for (size_t i = 0; i < sizeof cores / sizeof *cores; ++i) {
                double least = 1e300;
                core_model best = {0};
                bench_pool pool = {0};
                for (int run = 0; run < 4; ++run) {
                    core_model model = {.cores = cores[i]};
                    norma_options options = {.threads = (uint32_t)cores[i],
                        .parallel_for = run_jobs,
                        .parallel_for_user = &model,
                        .allocator = bench_pool_allocator(&pool)};
                    const double begun = bench_now();
                    call_once(call, &mesh, &options, normals, made.corner_count);
                    const double whole = bench_now() - begun,
                                 modelled = whole - model.in_jobs + model.busiest;
                    if (modelled < least) least = modelled, best = model;
                }
                if (i == 0) alone = least;
                printf("%-20s %-8s %2zu cores %8.2f ms %5.1f times  %3zu barriers %5zu jobs  "
                       "scratch %5.1f bytes a triangle\n",
                    CALL_NAMES[call], order ? "shuffled" : "rows", cores[i], 1e3 * least,
                    alone / least, best.barriers, best.jobs, (double)pool.most_in_use / 2e6);
                fflush(stdout);
                bench_pool_free(&pool);
            }
        }
        free(normals);
    }
    made_free(&made);
}

int main(int count, char **arguments) {
    const int chosen = count > 2 && !strcmp(arguments[1], "--only");
    const char *only = chosen ? arguments[2] : NULL;
    const int files = chosen ? 3 : 1;
    if (!only || strstr("layouts", only)) bench_layouts();
    if (!only || strstr("instances", only)) bench_instances();
    if (!only || strstr("cores", only)) bench_cores();
    if (files < count && (!only || strstr("files", only)))
        bench_files(count - files, arguments + files);
    return 0;
}
