/* bench_tangents.c: norma_corner_tangents per triangle in nanoseconds: a sheet in rows and
 * shuffled, with updates of a plan, then meshes on which other generators are quadratic. The least
 * of several calls; "x rows" is how many times the cost per triangle of the sheet in rows a mesh
 * has. bench_tangents [TRIANGLES] [PART OF A NAME] */
#include "made_meshes.h"
#include "timing.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { RUNS = 5, MOST_THREADS = 2 };

typedef struct textured_mesh {
    made_mesh made;
    float (*normals)[3], (*texcoords)[2]; /* of each position */
} textured_mesh;

static void stop_at(norma_result result) {
    if (!result) return;
    fprintf(stderr, "bench_tangents: %s\n", norma_result_text(result));
    exit(3);
}

/* Normals of the mesh, and a flat texture that leans a little. */
static textured_mesh textured(made_mesh made) {
    textured_mesh m = {.made = made};
    const norma_mesh mesh = made_view(&m.made);
    m.normals = bench_memory(made.position_count, sizeof *m.normals);
    m.texcoords = bench_memory(made.position_count, sizeof *m.texcoords);
    stop_at(norma_vertex_normals(&mesh, NULL, m.normals[0], made.position_count, NULL));
    for (size_t i = 0; i < made.position_count; ++i) {
        const float *p = made.positions[i];
        m.texcoords[i][0] = p[0] + 0.1F * p[1] * p[1];
        m.texcoords[i][1] = p[1] + 0.2F * p[0] * p[0];
    }
    return m;
}

static void free_textured(textured_mesh *m) {
    free(m->normals);
    free(m->texcoords);
    made_free(&m->made);
}

/* Each face has corners of its own, and equal ones are found by what they hold. */
static made_mesh without_indices(made_mesh made) {
    made_mesh to = {.position_count = made.corner_count, .corner_count = made.corner_count};
    to.positions = bench_memory(made.corner_count, sizeof *to.positions);
    for (size_t c = 0; c < made.corner_count; ++c)
        memcpy(to.positions[c], made.positions[made.corners[c]], sizeof *to.positions);
    made_free(&made);
    return to;
}

static textured_mesh sheet(size_t triangles) { return textured(made_grid(triangles)); }
static textured_mesh shuffled(size_t triangles) {
    made_mesh made = made_grid(triangles);
    made_shuffle(&made);
    return textured(made);
}
static textured_mesh soup(size_t triangles) {
    return textured(without_indices(made_grid(triangles)));
}
static textured_mesh fan(size_t triangles) { return textured(made_fan(triangles)); }

/* A fan whose texture goes round with it: at its middle each tangent is opposed to some others. */
static textured_mesh polar_fan(size_t triangles) {
    textured_mesh m = textured(made_fan(triangles));
    for (size_t i = 0; i < m.made.position_count; ++i) {
        m.texcoords[i][0] = i ? (float)i / (float)triangles : 0.5F;
        m.texcoords[i][1] = i ? 1 : 0;
    }
    return m;
}

static textured_mesh shuffled_polar_fan(size_t triangles) {
    textured_mesh m = polar_fan(triangles);
    uint64_t seed = 7;
    for (size_t i = triangles; i > 1; --i) {
        uint32_t room[3];
        seed = seed * UINT64_C(6364136223846793005) + 1;
        const size_t j = (size_t)(seed >> 33) % i;
        memcpy(room, m.made.corners + 3 * (i - 1), sizeof room);
        memcpy(m.made.corners + 3 * (i - 1), m.made.corners + 3 * j, sizeof room);
        memcpy(m.made.corners + 3 * j, room, sizeof room);
    }
    return m;
}

static textured_mesh few_degenerate(size_t triangles) {
    textured_mesh m = sheet(triangles);
    for (size_t t = 0; t < 16000 && 3 * t < m.made.corner_count; ++t)
        m.made.corners[3 * t + 2] = m.made.corners[3 * t + t % 2];
    return m;
}

static textured_mesh three_places(size_t triangles) {
    made_mesh made = {.position_count = 3 * triangles, .corner_count = 3 * triangles};
    made.positions = bench_memory(made.position_count, sizeof *made.positions);
    for (size_t i = 0; i < made.position_count; ++i) made.positions[i][i % 3] = 1;
    return textured(made);
}

/* The same, with texture coordinates that differ: no two corners are one. */
static textured_mesh three_crowds(size_t triangles) {
    textured_mesh m = three_places(triangles);
    for (size_t i = 0; i < m.made.position_count; ++i) m.texcoords[i][0] += (float)i * 0x1p-22F;
    return m;
}

typedef struct case_of {
    const char *name;
    textured_mesh (*make)(size_t triangles);
    size_t triangles; /* 0: those that are asked for */
} case_of;

static const case_of cases[] = {{"sheet in rows", sheet, 0}, {"sheet, shuffled", shuffled, 0},
    {"sheet without indices", soup, 0}, {"valence 200,000", fan, 200000},
    {"polar fan, 2,000", polar_fan, 2000}, {"polar fan, 20,000", polar_fan, 20000},
    {"polar fan, 200,000", polar_fan, 200000},
    {"polar fan, shuffled, 2,000", shuffled_polar_fan, 2000},
    {"polar fan, shuffled, 20,000", shuffled_polar_fan, 20000},
    {"polar fan, shuffled, 200,000", shuffled_polar_fan, 200000},
    {"16,000 degenerate of 64,000", few_degenerate, 64000},
    {"100,000 corners at 3 places", three_places, 33334},
    {"the same, none equal", three_crowds, 33334}};

static double least_time(const textured_mesh *m, norma_tangent_mode mode, uint32_t threads) {
    const size_t corners = m->made.corner_count;
    const norma_mesh mesh = made_view(&m->made);
    const norma_attribute normals = {.data = m->normals, .count = m->made.position_count},
                          texcoords = {.data = m->texcoords, .count = m->made.position_count};
    float *tangents = bench_memory(corners, 4 * sizeof *tangents);
    bench_pool pool = {0};
    const norma_options options = {.threads = threads, .allocator = bench_pool_allocator(&pool)};
    double least = 1e300;
    for (int run = 0; run < RUNS; ++run) {
        const double begun = bench_now();
        stop_at(norma_corner_tangents(
            &mesh, &normals, &texcoords, mode, &options, tangents, corners, NULL));
        const double took = bench_now() - begun;
        least = took < least ? took : least;
        if (took > 3) break;
    }
    bench_pool_free(&pool);
    free(tangents);
    return 3e9 * least / (double)corners;
}

/* Microseconds of an update of a plan: all vertices, or so many neighbouring ones. */
static double least_update(
    const textured_mesh *m, norma_tangent_mode mode, uint32_t threads, size_t moved_count) {
    const size_t corners = m->made.corner_count;
    const norma_mesh mesh = made_view(&m->made);
    const norma_attribute normals = {.data = m->normals, .count = m->made.position_count},
                          texcoords = {.data = m->texcoords, .count = m->made.position_count};
    float *tangents = bench_memory(corners, 4 * sizeof *tangents);
    uint32_t *moved = bench_memory(moved_count + 1, sizeof *moved);
    bench_pool pool = {0};
    const norma_options options = {.threads = threads, .allocator = bench_pool_allocator(&pool)};
    norma_tangent_plan *plan = NULL;
    double least = 1e300;
    for (size_t i = 0; i < moved_count; ++i) moved[i] = (uint32_t)(m->made.position_count / 2 + i);
    stop_at(norma_tangent_plan_create(&mesh, &normals, &texcoords, mode, NULL, &plan));
    for (int run = 0; run < RUNS; ++run) {
        const double begun = bench_now();
        stop_at(norma_tangent_plan_update(plan, mesh.positions, &normals,
            moved_count ? moved : NULL, moved_count, &options, tangents, corners, NULL));
        const double took = bench_now() - begun;
        least = took < least ? took : least;
    }
    norma_tangent_plan_destroy(plan);
    bench_pool_free(&pool);
    free(moved);
    free(tangents);
    return 1e6 * least;
}

static void print_updates(const textured_mesh *m) {
    const double triangles = (double)m->made.corner_count / 3;
    printf("%-30s", "  updates of a plan");
    for (int mode = 0; mode < 2; ++mode)
        for (uint32_t threads = 1; threads <= MOST_THREADS; ++threads)
            printf(" %8.0f      ",
                1e3 *
                    least_update(
                        m, mode ? NORMA_TANGENTS_STEADY : NORMA_TANGENTS_MIKK, threads, 0) /
                    triangles);
    printf("\n  1,000 neighbours moved, us:  ");
    for (int mode = 0; mode < 2; ++mode)
        printf(" %8.0f                     ",
            least_update(m, mode ? NORMA_TANGENTS_STEADY : NORMA_TANGENTS_MIKK, 1, 1000));
    printf("\n");
}

int main(int count, char **arguments) {
    const size_t triangles = count > 1 ? strtoul(arguments[1], NULL, 10) : 1000000;
    double rows[2][MOST_THREADS] = {{0}};
    if (!triangles) return fprintf(stderr, "usage: bench_tangents [TRIANGLES] [NAME]\n"), 2;
    printf(
        "%-30s %8s %12s %18s %12s\n", "ns per triangle, threads:", "MIKK 1", "2", "STEADY 1", "2");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        if (count > 2 && !strstr(cases[i].name, arguments[2])) continue;
        textured_mesh m = cases[i].make(cases[i].triangles ? cases[i].triangles : triangles);
        printf("%-30s", cases[i].name);
        for (int mode = 0; mode < 2; ++mode)
            for (uint32_t threads = 1; threads <= MOST_THREADS; ++threads) {
                const double ns =
                    least_time(&m, mode ? NORMA_TANGENTS_STEADY : NORMA_TANGENTS_MIKK, threads);
                double *row = &rows[mode][threads - 1];
                if (*row == 0) *row = ns;
                printf(" %8.0f %3.1f x", ns, ns / *row);
                fflush(stdout);
            }
        printf("\n");
        if (!cases[i].triangles && m.made.position_count > 4000) print_updates(&m);
        free_textured(&m);
    }
    return 0;
}
