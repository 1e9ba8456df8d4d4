/* test_threads_at_once.c: callers of the library at the same time, each with a mesh or a file of
 * its own, and with several threads of its own: every call that takes a mesh, and files from
 * reading to writing, give each caller what it gets alone. Run under the thread sanitizer too. And
 * a caller's jobs that run out of order and in threads of its own. */
#include "../../bits/bits.h"
#include "check.h"
#include <io/text/text.h>
#include <pthread.h>
#include <stdio.h>

enum { CALLERS = 4, MESHES = 6, PARTS = 8 };

static bits_of_mesh *const parts[PARTS] = {bits_faces, bits_vertices, bits_corners, bits_split,
    bits_plans, bits_morphs, bits_orient, bits_check};
static const char *const files[] = {"assets/dodecahedron.obj", "tests/cli/golden/files/roof.glb",
    "tests/cli/golden/files/roof.ply", "tests/cli/golden/files/corner.stl",
    "tests/cli/golden/files/groups.obj", "tests/cli/golden/files/roof.gltf"};

static uint64_t of_mesh(size_t index, const bits_way *way) {
    bits_hash hash = bits_begin();
    bits_mesh mesh;
    bits_make(index, &mesh);
    for (size_t p = 0; p < PARTS; ++p) parts[p](&mesh, way, &hash);
    bits_streams(&mesh, &hash);
    bits_matrices(&mesh, &hash);
    bits_unmake(&mesh);
    return hash.state;
}

static uint64_t of_file(size_t index, const bits_way *way) {
    bits_hash hash = bits_begin();
    FILE *file = fopen(files[index], "rb");
    unsigned char *bytes = bits_room(1 << 18, 1);
    if (!file) abort();
    const size_t size = fread(bytes, 1, 1 << 18, file);
    fclose(file);
    bits_file(files[index], bytes, size, way, &hash);
    free(bytes);
    return hash.state;
}

/* The many small calls under those of files, so often that two callers are surely within one at
 * once: numbers as text and back. */
static uint64_t of_numbers(size_t index, const bits_way *way) {
    uint64_t hash = 0xCBF29CE484222325u, state = index;
    (void)way;
    for (size_t i = 0; i < 100000 / SLOWER; ++i) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const double value = ldexp((double)(state >> 11), (int)(state % 61) - 80);
        char text[3][32];
        const size_t length[3] = {norma_number_format_double(value, text[0]),
            norma_number_format_float((float)value, text[1]),
            norma_number_format_normal((float)(value - floor(value)), text[2])};
        double back = 0;
        if (norma_number_parse(text[0], text[0] + length[0], &back) != text[0] + length[0] ||
            back != value)
            return 0;
        for (size_t k = 0; k < 3; ++k)
            for (size_t b = 0; b < length[k]; ++b)
                hash = (hash ^ (unsigned char)text[k][b]) * 0x100000001B3u;
    }
    return hash;
}

typedef struct caller {
    uint64_t (*of)(size_t index, const bits_way *way);
    size_t first, count;
    bits_way way;
    uint64_t got[MESHES];
} caller;

static void *call_all(void *data) {
    caller *c = data;
    for (size_t i = 0; i < c->count; ++i) {
        const size_t index = (c->first + i) % c->count; /* different ones at any time */
        c->got[index] = c->of(index, &c->way);
    }
    return NULL;
}

static void at_once(uint64_t (*of)(size_t, const bits_way *), size_t count) {
    const bits_way alone = {.threads = 1, .name = "alone"};
    uint64_t expected[MESHES];
    caller callers[CALLERS];
    pthread_t threads[CALLERS];
    for (size_t i = 0; i < count; ++i) expected[i] = of(i, &alone);
    for (size_t i = 0; i < CALLERS; ++i) {
        callers[i] = (caller){.of = of,
            .first = i,
            .count = count,
            .way = {.threads = (uint32_t)(1 + i % 3), .name = ""}};
        assert_int_equal(pthread_create(&threads[i], NULL, call_all, &callers[i]), 0);
    }
    for (size_t i = 0; i < CALLERS; ++i) {
        pthread_join(threads[i], NULL);
        for (size_t k = 0; k < count; ++k)
            if (callers[i].got[k] != expected[k])
                fail_msg("caller %zu, number %zu: other bits than alone", i, k);
    }
}

/* hill, grid, ball, far, polygons, wreck */
static void meshes_at_once(void **state) {
    (void)state;
    at_once(of_mesh, SLOWER > 1 ? 2 : MESHES);
}

static void files_at_once(void **state) {
    (void)state;
    at_once(of_file, sizeof files / sizeof *files);
}

static void numbers_at_once(void **state) {
    (void)state;
    at_once(of_numbers, MESHES);
}

/* ---- a caller's jobs */

typedef struct crew {
    norma_task *task;
    void *context;
    size_t count, from;
} crew;

static void *every_third_backwards(void *data) {
    const crew *c = data;
    for (size_t i = c->count; i > 0; --i)
        if (i % 3 == c->from) c->task(c->context, i - 1);
    return NULL;
}

static void jobs_out_of_order(void *user, size_t count, norma_task *task, void *context) {
    crew crews[3];
    pthread_t threads[3];
    (void)user;
    for (size_t i = 0; i < 3; ++i) {
        crews[i] = (crew){task, context, count, i};
        if (pthread_create(&threads[i], NULL, every_third_backwards, &crews[i])) abort();
    }
    for (size_t i = 3; i > 0; --i) pthread_join(threads[i - 1], NULL);
}

static void jobs(void **state) {
    const bits_way alone = {.threads = 1, .name = "alone"},
                   out_of_order = {.threads = 1, .jobs = jobs_out_of_order, .name = "jobs"};
    (void)state;
    for (size_t i = 0; i < (SLOWER > 1 ? 2 : MESHES); ++i)
        assert_true(of_mesh(i, &alone) == of_mesh(i, &out_of_order));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(meshes_at_once),
        cmocka_unit_test(files_at_once), cmocka_unit_test(numbers_at_once), cmocka_unit_test(jobs)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
