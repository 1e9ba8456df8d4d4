/* test_memory.c: every call with an allocator that fails at its n-th allocation, for every n until
 * none fails: memory error or the right answer, nothing leaked, every block given back with the
 * size and the user it was asked for with, aligned as asked. Without an allocator the answer is the
 * same. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

enum { FACES, VERTICES, CORNERS, SPLIT, CALLS, MOST_BLOCKS = 4096 };

typedef struct accountant {
    size_t calls, fail_at; /* 1: the first; 0: none */
    int fail_on;           /* all after it as well */
    size_t live, bytes, most_bytes;
    struct {
        void *block, *base;
        size_t size;
    } blocks[MOST_BLOCKS];
    int wrong;
} accountant;

static void *take(void *user, size_t size, size_t alignment) {
    accountant *a = user;
    ++a->calls;
    if (a->fail_at && (a->calls == a->fail_at || (a->fail_on && a->calls > a->fail_at)))
        return NULL;
    if (alignment == 0 || alignment & (alignment - 1) || a->live == MOST_BLOCKS) a->wrong = 1;
    unsigned char *base = malloc(size + 2 * alignment + 16), *block = base;
    if (!base) return NULL;
    block += alignment - (uintptr_t)block % alignment;
    if ((uintptr_t)block % (2 * alignment) == 0)
        block += alignment; /* aligned as asked, and no better */
    memset(block, 0xcd, size);
    a->blocks[a->live].block = block;
    a->blocks[a->live].base = base;
    a->blocks[a->live].size = size;
    ++a->live;
    a->bytes += size;
    if (a->bytes > a->most_bytes) a->most_bytes = a->bytes;
    return block;
}

static void give(void *user, void *block, size_t size) {
    accountant *a = user;
    for (size_t i = 0; i < a->live; ++i)
        if (a->blocks[i].block == block) {
            if (a->blocks[i].size != size) a->wrong = 2;
            a->bytes -= size;
            free(a->blocks[i].base);
            a->blocks[i] = a->blocks[--a->live];
            return;
        }
    if (block) a->wrong = 3;
}

typedef struct answer {
    float *normals;
    uint32_t *corners, *sources;
    uint8_t *reasons;
    size_t count;
    norma_report report;
} answer;

static answer *answer_create(size_t room) {
    answer *a = test_calloc(1, sizeof *a);
    a->normals = test_calloc(room, 12);
    a->corners = test_calloc(room, 4);
    a->sources = test_calloc(room, 4);
    a->reasons = test_calloc(room, 1);
    return a;
}

static void answer_free(answer *a) {
    test_free(a->normals);
    test_free(a->corners);
    test_free(a->sources);
    test_free(a->reasons);
    test_free(a);
}

static norma_result call(
    int kind, const norma_mesh *mesh, norma_options options, answer *a, size_t room) {
    options.reasons = kind == SPLIT ? NULL : a->reasons;
    if (kind == FACES) return norma_face_normals(mesh, &options, a->normals, room, &a->report);
    if (kind == VERTICES) return norma_vertex_normals(mesh, &options, a->normals, room, &a->report);
    if (kind == CORNERS)
        return norma_corner_normals(mesh, 0.5f, &options, a->normals, room, &a->report);
    return norma_split(mesh, 0.5f, &options, a->corners, room, a->sources, a->normals, room,
        &a->count, &a->report);
}

static int same(const answer *a, const answer *b, size_t room) {
    return !memcmp(a->normals, b->normals, 12 * room) &&
           !memcmp(a->corners, b->corners, 4 * room) && !memcmp(a->sources, b->sources, 4 * room) &&
           !memcmp(a->reasons, b->reasons, room) && a->count == b->count &&
           !memcmp(&a->report, &b->report, sizeof a->report);
}

static void fail_each_allocation(const norma_mesh *mesh, norma_options options) {
    const size_t room = mesh->corner_count + mesh->positions.count;
    for (int kind = 0; kind < CALLS; ++kind) {
        answer *expected = answer_create(room);
        assert_ok(call(kind, mesh, options, expected, room));
        for (int on = 0; on < 2; ++on)
            for (size_t n = 0;; ++n) { /* 0: no failure */
                accountant *a = test_calloc(1, sizeof *a);
                answer *got = answer_create(room);
                norma_options own = options;
                a->fail_at = n;
                a->fail_on = on;
                own.allocator = (norma_allocator){take, give, a};
                const norma_result result = call(kind, mesh, own, got, room);
                const size_t calls = a->calls;
                if (a->live || a->wrong)
                    fail_msg("call %d, failure at %zu: %zu blocks leaked, fault %d", kind, n,
                        a->live, a->wrong);
                assert_true(!result || (n > 0 && result == NORMA_ERROR_MEMORY));
                if (!result && !same(got, expected, room))
                    fail_msg("call %d, failure at %zu: another answer", kind, n);
                answer_free(got);
                test_free(a);
                if (n > calls) break;
            }
        answer_free(expected);
    }
}

static void for_meshes(norma_options options) {
    for (int i = 0; i < 5; ++i) {
        mesh_file mesh = {0};
        uint64_t seed = 3;
        if (i == 0) shape_box(&mesh, 1, 1, 1, 1);
        if (i == 1) shape_pole_sphere(&mesh, 12, 7, 0);
        if (i == 2) shape_wavy_grid(&mesh, 60, 0);
        if (i == 3) {
            for (int v = 0; v < 40; ++v)
                mesh_file_add_position(&mesh, shape_random(&seed) % 3, shape_random(&seed) % 3,
                    shape_random(&seed) % 3);
            for (int f = 0; f < 100; ++f)
                mesh_file_add_face(&mesh,
                    (uint32_t[]){shape_random(&seed) % 40, shape_random(&seed) % 40,
                        shape_random(&seed) % 40, shape_random(&seed) % 40},
                    4);
        }
        if (i == 4) { /* a ring of a hundred corners, and an edge of seventy faces */
            shape_cone(&mesh, 100, .6);
            for (int f = 0; f < 70; ++f)
                mesh_file_add_face(&mesh, (uint32_t[]){0, 1, 2 + shape_random(&seed) % 90}, 3);
        }
        const norma_mesh view = mesh_file_view(&mesh);
        fail_each_allocation(&view, options);
        mesh_file_free(&mesh);
    }
}

static void defaults(void **state) {
    (void)state;
    for_meshes((norma_options){0});
}

static void nearest_fallback(void **state) {
    (void)state;
    for_meshes((norma_options){.fallback = NORMA_FALLBACK_NEAREST});
}

static void weld_by_distance(void **state) {
    (void)state;
    for_meshes((norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = 0.3});
}

static void no_weld(void **state) {
    (void)state;
    for_meshes((norma_options){.weld = NORMA_WELD_NONE, .non_manifold = NORMA_NON_MANIFOLD_SMOOTH});
}

static void visible_with_threads(void **state) {
    (void)state;
    for_meshes((norma_options){.weight = NORMA_WEIGHT_VISIBLE, .threads = 3});
}

/* Scratch memory grows with the mesh alone, not with the number of threads. How little of it is
 * enough is the business of the benchmarks. */
static void scratch_memory(void **state) {
    (void)state;
    mesh_file mesh = {0};
    double alone[2] = {0, 0};
    shape_wavy_grid(&mesh, 300, 0);
    const norma_mesh view = mesh_file_view(&mesh);
    float *normals = test_malloc(12 * mesh.corner_count);
    for (uint32_t threads = 1; threads <= 16; threads *= 4)
        for (int corners = 0; corners < 2; ++corners) {
            accountant *a = test_calloc(1, sizeof *a);
            norma_options options = {.threads = threads, .allocator = {take, give, a}};
            if (corners)
                assert_ok(
                    norma_corner_normals(&view, 1, &options, normals, mesh.corner_count, NULL));
            else
                assert_ok(
                    norma_vertex_normals(&view, &options, normals, mesh.position_count, NULL));
            const double bytes = (double)a->most_bytes / (double)mesh.face_count;
            if (threads == 1)
                printf("# scratch of %.1f bytes a triangle for %s\n", bytes,
                    corners ? "corners" : "vertices");
            if (threads == 1) alone[corners] = bytes;
            assert_true(bytes > 0 && bytes < 100);
            assert_true(bytes < alone[corners] * 1.05 + 1);
            test_free(a);
        }
    test_free(normals);
    mesh_file_free(&mesh);
}

/* No more than meshes of corners may take. */
static void check_scratch_of_corners(const mesh_file *mesh, float crease, const char *what) {
    const norma_mesh view = mesh_file_view(mesh);
    float *normals = test_malloc(12 * mesh->corner_count);
    accountant *a = test_calloc(1, sizeof *a);
    assert_ok(norma_corner_normals(&view, crease, &(norma_options){.allocator = {take, give, a}},
        normals, mesh->corner_count, NULL));
    printf("# scratch of %.1f bytes a triangle for corners of %s\n",
        (double)a->most_bytes / (double)mesh->face_count, what);
    assert_true(a->most_bytes <= 40 * mesh->face_count);
    test_free(a);
    test_free(normals);
}

/* Also where every edge is a crease, and in meshes that are not large. */
static void scratch_of_creases(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 40, 0);
    check_scratch_of_corners(&mesh, 0, "a small mesh of creases");
    mesh_file_free(&mesh);
}

/* Nothing is kept of one ring of all triangles that can be read or measured again. */
static void scratch_of_one_ring(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_fan(&mesh, 20000);
    check_scratch_of_corners(&mesh, 1, "one ring");
    mesh_file_free(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults),
        cmocka_unit_test(nearest_fallback),
        cmocka_unit_test(weld_by_distance),
        cmocka_unit_test(no_weld),
        cmocka_unit_test(visible_with_threads),
        cmocka_unit_test(scratch_memory),
        cmocka_unit_test(scratch_of_creases),
        cmocka_unit_test(scratch_of_one_ring),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
