/* test_morph.c: normal deltas of morph targets: right against the normals of the morphed shape,
 * none where nothing moves, equal at equal positions, sparse. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

enum { ROOM = 8192 };

typedef struct morphs {
    mesh_file mesh;
    norma_mesh view;
    float *base, *target, *far_target;
    norma_vec3_view targets[2];
    uint32_t *vertices;
    float *deltas;
    size_t starts[3];
} morphs;

/* A sphere with a seam: the first target moves a cap, the second nothing but one point far away. */
static void open_morphs(morphs *m) {
    memset(m, 0, sizeof *m);
    shape_uv_sphere(&m->mesh, 24, 16, 1, 0);
    shape_round_to_float(&m->mesh);
    m->base = test_calloc(3 * ROOM, sizeof(float));
    m->target = test_calloc(3 * ROOM, sizeof(float));
    m->far_target = test_calloc(3 * ROOM, sizeof(float));
    m->vertices = test_calloc(ROOM, sizeof *m->vertices);
    m->deltas = test_calloc(3 * ROOM, sizeof(float));
    m->view = mesh_file_view_float(&m->mesh, m->base);
    memcpy(m->target, m->base, 12 * m->mesh.position_count);
    memcpy(m->far_target, m->base, 12 * m->mesh.position_count);
    for (size_t v = 0; v < m->mesh.position_count; ++v)
        if (m->base[3 * v + 2] > 0.5f)
            m->target[3 * v + 2] = 0.5f + 2 * (m->base[3 * v + 2] - 0.5f);
    m->targets[0] = m->targets[1] = m->view.positions;
    m->targets[0].data = m->target;
    m->targets[1].data = m->far_target;
}

static void close_morphs(morphs *m) {
    mesh_file_free(&m->mesh);
    test_free(m->base);
    test_free(m->target);
    test_free(m->far_target);
    test_free(m->vertices);
    test_free(m->deltas);
}

static void deltas_lead_to_the_target(void **state) {
    (void)state;
    morphs m;
    open_morphs(&m);
    const size_t count = m.mesh.position_count;
    float *base = test_calloc(3 * ROOM, sizeof(float)),
          *target = test_calloc(3 * ROOM, sizeof(float));
    assert_ok(norma_vertex_normals(&m.view, NULL, base, count, NULL));
    m.view.positions.data = m.target;
    assert_ok(norma_vertex_normals(&m.view, NULL, target, count, NULL));
    m.view.positions.data = m.base;
    assert_ok(norma_morph_normals(
        &m.view, NULL, m.targets, 2, 0, NULL, m.starts, m.vertices, m.deltas, ROOM));
    assert_int_equal(m.starts[0], 0);
    assert_int_equal(m.starts[2], m.starts[1]); /* the second moves nothing */
    assert_true(m.starts[1] > 20 && m.starts[1] < count / 2);
    for (size_t v = 0, at = 0; v < count; ++v) {
        const int listed = at < m.starts[1] && m.vertices[at] == v;
        for (size_t x = 0; x < 3; ++x) {
            const float wanted = target[3 * v + x] - base[3 * v + x];
            assert_true((listed ? m.deltas[3 * at + x] : 0) == wanted);
        }
        at += (size_t)listed;
    }
    test_free(base);
    test_free(target);
    close_morphs(&m);
}

static void a_bound_leaves_out_what_is_small(void **state) {
    (void)state;
    morphs m;
    size_t all;
    open_morphs(&m);
    assert_ok(norma_morph_normals(&m.view, NULL, m.targets, 1, 0, NULL, m.starts, NULL, NULL, 0));
    all = m.starts[1];
    const norma_morph_output large = {m.starts, m.vertices, m.deltas, all};
    assert_ok(norma_morph_deltas(&m.view, NULL, m.targets, 1, 0.2f, NULL, &large));
    assert_int_equal(
        norma_morph_deltas(&m.view, NULL, m.targets, 1, 0.2f, NULL, NULL), NORMA_ERROR_ARGUMENT);
    assert_true(m.starts[1] > 0 && m.starts[1] < all);
    for (size_t i = 0; i < m.starts[1]; ++i)
        assert_true(hypot(hypot((double)m.deltas[3 * i], (double)m.deltas[3 * i + 1]),
                        (double)m.deltas[3 * i + 2]) > 0.19999);
    close_morphs(&m);
}

/* Two normals at one position: they stay apart, and each follows its own side. */
static void authored_normals_are_kept(void **state) {
    (void)state;
    const float p[18] = {0, 0, 0, 0, 1, 0, -1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0};
    const float n[18] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 1, 1, 0, 1, 1, 0, 1, 1};
    float q[18], deltas[18];
    const uint32_t corners[6] = {0, 1, 2, 3, 4, 5};
    uint32_t vertices[6];
    size_t starts[2];
    const norma_mesh mesh = {
        .positions = {p, 6, 0, NORMA_FORMAT_FLOAT}, .corners = corners, .corner_count = 6};
    const norma_vec3_view normals = {n, 6, 0, NORMA_FORMAT_FLOAT},
                          target = {q, 6, 0, NORMA_FORMAT_FLOAT};
    memcpy(q, p, sizeof q);
    q[17] = 1; /* the right side turns up by 45 degrees */
    assert_ok(
        norma_morph_normals(&mesh, &normals, &target, 1, 0, NULL, starts, vertices, deltas, 6));
    assert_int_equal(starts[1], 3);
    for (uint32_t i = 0; i < 3; ++i) {
        assert_int_equal(vertices[i], 3 + i);
        assert_true(fabs((double)deltas[3 * i] + sqrt(0.5)) < 1e-6 &&
                    fabs((double)deltas[3 * i + 2] - (sqrt(0.5) - 1)) < 1e-6);
    }
    assert_ok(norma_morph_normals(&mesh, NULL, &target, 1, 0, NULL, starts, vertices, deltas,
        6)); /* without them all share */
    assert_int_equal(starts[1], 5);
    assert_memory_equal(deltas, deltas + 9,
        12); /* vertex 0 and vertex 4 are at one position; listed are 0, 1, 3, 4, 5 */
}

static void wrong_arguments(void **state) {
    (void)state;
    morphs m;
    open_morphs(&m);
    norma_vec3_view shorter = m.targets[0];
    --shorter.count;
    m.deltas[0] = 5;
    assert_int_equal(
        norma_morph_normals(NULL, NULL, m.targets, 1, 0, NULL, m.starts, NULL, NULL, 0),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_morph_normals(&m.view, NULL, NULL, 1, 0, NULL, m.starts, NULL, NULL, 0),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_morph_normals(&m.view, NULL, &shorter, 1, 0, NULL, m.starts, NULL, NULL, 0),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_morph_normals(&m.view, &shorter, m.targets, 1, 0, NULL, m.starts, NULL, NULL, 0),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_morph_normals(&m.view, NULL, m.targets, 1, NAN, NULL, m.starts, NULL, NULL, 0),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_morph_normals(&m.view, NULL, m.targets, 1, -1, NULL, m.starts, NULL, NULL, 0),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_morph_normals(&m.view, NULL, m.targets, 1, 0, NULL, NULL, NULL, NULL, 0),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_morph_normals(
                         &m.view, NULL, m.targets, 1, 0, NULL, m.starts, m.vertices, m.deltas, 3),
        NORMA_ERROR_CAPACITY);
    assert_true(m.deltas[0] == 5);
    close_morphs(&m);
}

typedef struct counter {
    size_t calls, fail_at, live;
} counter;

static void *take(void *user, size_t size, size_t alignment) {
    counter *c = user;
    if (++c->calls == c->fail_at) return NULL;
    ++c->live;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void give(void *user, void *block, size_t size) {
    (void)size;
    --((counter *)user)->live;
    free(block);
}

static void failing_allocations(void **state) {
    (void)state;
    morphs m;
    open_morphs(&m);
    for (size_t fail_at = 1, done = 0; !done; ++fail_at) {
        counter c = {.fail_at = fail_at};
        norma_options options = {.allocator = {take, give, &c}};
        const norma_result result = norma_morph_normals(
            &m.view, NULL, m.targets, 2, 0, &options, m.starts, m.vertices, m.deltas, ROOM);
        done = !result && c.calls < fail_at;
        if (result) assert_int_equal(result, NORMA_ERROR_MEMORY);
        assert_int_equal(c.live, 0);
    }
    close_morphs(&m);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(deltas_lead_to_the_target),
        cmocka_unit_test(a_bound_leaves_out_what_is_small),
        cmocka_unit_test(authored_normals_are_kept), cmocka_unit_test(wrong_arguments),
        cmocka_unit_test(failing_allocations)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
