/* test_arguments.c: what the calls refuse, with which result, and that after an error nothing has
 * been written: every output is filled with a pattern before. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

enum { ROOM = 512, FACES = 0, VERTICES, CORNERS, SPLIT, CALLS };

typedef struct outputs { /* everything a call may write to */
    float normals[3 * ROOM];
    uint8_t reasons[ROOM];
    uint32_t corners[ROOM], sources[ROOM];
    size_t count;
    norma_edges edges;
    norma_report report;
} outputs;

static void fill(outputs *o) { memset(o, 0xa5, sizeof *o); }

static norma_result call(int kind, const norma_mesh *mesh, float crease,
    const norma_options *options, outputs *o, size_t capacity, size_t corner_capacity) {
    norma_options own = options ? *options : (norma_options){0};
    if (!own.struct_size) {
        own.struct_size = sizeof own;
        own.edges = &o->edges;
    }
    own.reasons = o->reasons;
    if (kind == FACES) return norma_face_normals(mesh, &own, o->normals, capacity, &o->report);
    if (kind == VERTICES) return norma_vertex_normals(mesh, &own, o->normals, capacity, &o->report);
    if (kind == CORNERS)
        return norma_corner_normals(mesh, crease, &own, o->normals, capacity, &o->report);
    return norma_split(mesh, crease, &own, o->corners, corner_capacity, o->sources, o->normals,
        capacity, &o->count, &o->report);
}

static void expect(int kind, const norma_mesh *mesh, float crease, const norma_options *options,
    size_t capacity, norma_result expected) {
    static outputs got, untouched;
    fill(&got);
    fill(&untouched);
    const norma_result result = call(kind, mesh, crease, options, &got, capacity, ROOM);
    if (result != expected)
        fail_msg("call %d: %d (%s), expected %d", kind, (int)result, norma_result_text(result),
            (int)expected);
    if (expected < 0 && memcmp(&got, &untouched, sizeof got))
        fail_msg("call %d wrote something before it failed", kind);
}

static const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const uint32_t tetrahedron[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
static const norma_mesh good = {
    .positions = {positions, 4, 0, NORMA_FORMAT_FLOAT}, .corners = tetrahedron, .corner_count = 12};
static const size_t needed[CALLS] = {4, 4, 12, 12};

static void expect_all(
    const norma_mesh *mesh, const norma_options *options, norma_result expected) {
    for (int kind = 0; kind < CALLS; ++kind) expect(kind, mesh, 1, options, ROOM, expected);
}

static void good_mesh_is_fine(void **state) {
    (void)state;
    expect_all(&good, NULL, NORMA_OK);
    for (int kind = 0; kind < CALLS; ++kind) expect(kind, &good, 1, NULL, needed[kind], NORMA_OK);
}

static void null_mesh(void **state) {
    (void)state;
    expect_all(NULL, NULL, NORMA_ERROR_ARGUMENT);
}

static void null_positions(void **state) {
    (void)state;
    norma_mesh mesh = good;
    mesh.positions.data = NULL;
    expect_all(&mesh, NULL, NORMA_ERROR_ARGUMENT);
}

static void null_outputs(void **state) {
    (void)state;
    assert_int_equal(norma_face_normals(&good, NULL, NULL, 4, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_vertex_normals(&good, NULL, NULL, 4, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_corner_normals(&good, 1, NULL, NULL, 12, NULL), NORMA_ERROR_ARGUMENT);
}

static void null_options_and_report_are_fine(void **state) {
    (void)state;
    float normals[36];
    uint32_t corners[12], sources[12];
    size_t count;
    assert_ok(norma_face_normals(&good, NULL, normals, 4, NULL));
    assert_ok(norma_vertex_normals(&good, NULL, normals, 4, NULL));
    assert_ok(norma_corner_normals(&good, 1, NULL, normals, 12, NULL));
    assert_ok(norma_split(&good, 1, NULL, corners, 12, sources, normals, 12, &count, NULL));
    norma_split_output split = {corners, 12, sources, normals, 12, 0};
    assert_ok(norma_split_mesh(&good, 1, NULL, &split, NULL));
    assert_int_equal(split.vertex_count, count);
    split.vertex_capacity = count - 1;
    assert_int_equal(norma_split_mesh(&good, 1, NULL, &split, NULL), NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_split_mesh(&good, 1, NULL, NULL, NULL), NORMA_ERROR_ARGUMENT);
}

static void creases_beyond_pi(void **state) {
    (void)state;
    expect(CORNERS, &good, NAN, NULL, ROOM, NORMA_ERROR_ARGUMENT);
    expect(SPLIT, &good, NAN, NULL, ROOM, NORMA_ERROR_ARGUMENT);
    expect(CORNERS, &good, -1, NULL, ROOM, NORMA_OK);
    static const struct {
        float crease;
        norma_result expected;
    } cases[] = {{3.1415927F, NORMA_OK}, {3.1425F, NORMA_OK}, {3.1427F, NORMA_ERROR_ARGUMENT},
        {60, NORMA_ERROR_ARGUMENT}, {INFINITY, NORMA_ERROR_ARGUMENT},
        {-INFINITY, NORMA_ERROR_ARGUMENT}};
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        norma_plan *plan = NULL;
        expect(CORNERS, &good, cases[i].crease, NULL, ROOM, cases[i].expected);
        expect(SPLIT, &good, cases[i].crease, NULL, ROOM, cases[i].expected);
        assert_int_equal(norma_plan_create(&good, NORMA_PER_CORNER, cases[i].crease, NULL, &plan),
            cases[i].expected);
        norma_plan_destroy(plan);
    }
}

static void fallbacks_that_are_not_finite(void **state) {
    (void)state;
    for (int k = 0; k < 3; ++k) {
        norma_options options = {.fallback = NORMA_FALLBACK_GIVEN};
        expect_all(&good, &options, NORMA_OK);
        options.fallback_normal[k] = k ? NAN : -INFINITY;
        expect_all(&good, &options, NORMA_ERROR_ARGUMENT);
        options.fallback = NORMA_FALLBACK_NEAREST; /* then it is not looked at */
        expect_all(&good, &options, NORMA_OK);
    }
}

/* New corners that lie over the mesh's own, wholly or by one index at either end. */
static void split_over_its_own_corners(void **state) {
    (void)state;
    uint32_t corners[36], before[36];
    for (int i = 0; i < 36; ++i) corners[i] = tetrahedron[i % 12];
    memcpy(before, corners, sizeof before);
    norma_mesh mesh = good;
    mesh.corners = corners + 12;
    for (int shift = 1; shift < 24; ++shift) {
        assert_int_equal(
            norma_split(&mesh, 1, NULL, corners + shift, 12, NULL, NULL, 0, NULL, NULL),
            NORMA_ERROR_ARGUMENT);
        assert_memory_equal(corners, before, sizeof before);
    }
    assert_ok(norma_split(&mesh, 1, NULL, corners, 12, NULL, NULL, 0, NULL, NULL));
    assert_ok(norma_split(&mesh, 1, NULL, corners + 24, 12, NULL, NULL, 0, NULL, NULL));
}

/* ---- which argument was wrong */

static void expect_fault(const norma_mesh *mesh, const float *crease, const norma_options *options,
    norma_result result, const char *argument, size_t index) {
    norma_fault fault;
    memset(&fault, 0xa5, sizeof fault);
    assert_int_equal(norma_find_fault(mesh, crease, options, &fault), result);
    assert_int_equal(norma_find_fault(mesh, crease, options, NULL), result);
    assert_int_equal(fault.result, result);
    assert_int_equal(fault.index, index);
    assert_int_equal(!fault.argument, !argument);
    assert_int_equal(!fault.expected, !argument);
    if (argument) assert_string_equal(fault.argument, argument);
    if (crease) expect(CORNERS, mesh, *crease, options, ROOM, result);
    if (!crease) expect_all(mesh, options, result);
}

static void wrong_options_are_named(void **state) {
    (void)state;
    const norma_result wrong = NORMA_ERROR_ARGUMENT;
    const float degrees = 60, radians = 1;
    expect_fault(&good, NULL, NULL, NORMA_OK, NULL, SIZE_MAX);
    expect_fault(&good, &radians, NULL, NORMA_OK, NULL, SIZE_MAX);
    expect_fault(&good, &degrees, NULL, wrong, "crease_angle_rad", SIZE_MAX);
    norma_fault fault;
    norma_find_fault(&good, &degrees, NULL, &fault);
    assert_non_null(strstr(fault.expected, "radians"));
    expect_fault(&good, NULL, &(norma_options){.weight = (norma_weight)7}, wrong, "options->weight",
        SIZE_MAX);
    expect_fault(
        &good, NULL, &(norma_options){.weld = (norma_weld)-1}, wrong, "options->weld", SIZE_MAX);
    expect_fault(&good, NULL, &(norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = -1.0},
        wrong, "options->weld_distance", SIZE_MAX);
    expect_fault(&good, NULL, &(norma_options){.normal_stride = 11}, wrong,
        "options->normal_stride", SIZE_MAX);
    expect_fault(
        &good, NULL, &(norma_options){.isa = (norma_isa)99}, wrong, "options->isa", SIZE_MAX);
    expect_fault(&good, NULL,
        &(norma_options){.fallback = NORMA_FALLBACK_GIVEN, .fallback_normal = {0, NAN, 0}}, wrong,
        "options->fallback_normal", 1);
}

static void wrong_meshes_are_named(void **state) {
    (void)state;
    uint32_t corners[12];
    memcpy(corners, tetrahedron, sizeof corners);
    norma_mesh mesh = good;
    expect_fault(NULL, NULL, NULL, NORMA_ERROR_ARGUMENT, "mesh", SIZE_MAX);
    mesh.corners = corners;
    corners[7] = 4;
    corners[9] = UINT32_MAX;
    expect_fault(&mesh, NULL, NULL, NORMA_ERROR_INDEX, "mesh->corners", 7);
    mesh.corner_count = 11;
    expect_fault(&mesh, NULL, NULL, NORMA_ERROR_ARGUMENT, "mesh->corner_count", SIZE_MAX);
    mesh = good;
    mesh.corner_size = 3;
    expect_fault(&mesh, NULL, NULL, NORMA_ERROR_ARGUMENT, "mesh->corner_size", SIZE_MAX);
    mesh = good;
    mesh.positions.data = NULL;
    expect_fault(&mesh, NULL, NULL, NORMA_ERROR_ARGUMENT, "mesh->positions.data", SIZE_MAX);
    static const uint32_t falling[] = {0, 6, 3, 12}, late[] = {1, 6, 12}, early[] = {0, 6, 11};
    mesh = good;
    mesh.face_starts = falling;
    mesh.face_count = 3;
    expect_fault(&mesh, NULL, NULL, NORMA_ERROR_ARGUMENT, "mesh->face_starts", 2);
    mesh.face_starts = late;
    mesh.face_count = 2;
    expect_fault(&mesh, NULL, NULL, NORMA_ERROR_ARGUMENT, "mesh->face_starts", 0);
    mesh.face_starts = early;
    expect_fault(&mesh, NULL, NULL, NORMA_ERROR_ARGUMENT, "mesh->face_starts", 2);
}

static void wrong_models_are_named(void **state) {
    (void)state;
    enum { MODELS = 5 };
    float models[MODELS][16], matrices[MODELS][9];
    norma_fault fault;
    for (int i = 0; i < MODELS; ++i)
        for (int k = 0; k < 16; ++k) models[i][k] = k % 5 == 0 ? 1 : 0;
    models[1][13] = NAN; /* a translation does not matter */
    assert_ok(norma_find_model_fault(models[0], 0, MODELS, &fault));
    assert_null(fault.argument);
    models[3][6] = INFINITY;
    assert_int_equal(norma_find_model_fault(models[0], 0, MODELS, &fault), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_normal_matrices(models[0], MODELS, NORMA_WINDING_KEPT, matrices[0], MODELS),
        fault.result);
    assert_string_equal(fault.argument, "models");
    assert_int_equal(fault.index, 3);
    assert_int_equal(norma_find_model_fault(models[0], 2 * sizeof models[0], 2, NULL), NORMA_OK);
    assert_int_equal(norma_find_model_fault(NULL, 0, 1, &fault), NORMA_ERROR_ARGUMENT);
    assert_ok(norma_find_model_fault(NULL, 0, 0, &fault));
}

static void triangles_in_threes(void **state) {
    (void)state;
    norma_mesh mesh = good;
    for (size_t count = 0; count <= 12; ++count) {
        mesh.corner_count = count;
        expect_all(&mesh, NULL, count % 3 ? NORMA_ERROR_ARGUMENT : NORMA_OK);
    }
}

static void face_starts_run_from_0_to_the_end(void **state) {
    (void)state;
    static const struct {
        uint32_t starts[5];
        norma_result expected;
    } cases[] = {{{0, 3, 6, 9, 12}, NORMA_OK}, {{0, 0, 6, 6, 12}, NORMA_OK},
        {{0, 12, 12, 12, 12}, NORMA_OK}, {{1, 3, 6, 9, 12}, NORMA_ERROR_ARGUMENT},
        {{0, 3, 6, 9, 11}, NORMA_ERROR_ARGUMENT}, {{0, 3, 6, 9, 13}, NORMA_ERROR_ARGUMENT},
        {{0, 6, 3, 9, 12}, NORMA_ERROR_ARGUMENT}, {{0, 3, 15, 9, 12}, NORMA_ERROR_ARGUMENT},
        {{0, 3, 6, 0xffffffffu, 12}, NORMA_ERROR_ARGUMENT}};
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        norma_mesh mesh = good;
        mesh.face_starts = cases[i].starts;
        mesh.face_count = 4;
        expect_all(&mesh, NULL, cases[i].expected);
    }
    norma_mesh mesh = good;
    mesh.face_starts = cases[0].starts;
    mesh.face_count = 0; /* no face, yet twelve corners */
    expect_all(&mesh, NULL, NORMA_ERROR_ARGUMENT);
    mesh.face_count = 3;
    expect_all(&mesh, NULL, NORMA_ERROR_ARGUMENT);
}

static void corners_without_indices_need_positions(void **state) {
    (void)state;
    norma_mesh mesh = good;
    mesh.corners = NULL;
    expect_all(&mesh, NULL, NORMA_ERROR_ARGUMENT);
    mesh.corner_count = 3;
    expect_all(&mesh, NULL, NORMA_OK);
}

static void indices_out_of_range(void **state) {
    (void)state;
    for (size_t bad = 0; bad < 12; ++bad)
        for (int size = 1; size <= 4; size *= 2) {
            uint8_t c8[12];
            uint16_t c16[12];
            uint32_t c32[12];
            for (size_t i = 0; i < 12; ++i) {
                c32[i] = i == bad ? (size == 4 && bad & 1 ? 0xffffffffu
                                        : size == 1       ? 255
                                                          : 4)
                                  : tetrahedron[i];
                c16[i] = (uint16_t)c32[i];
                c8[i] = (uint8_t)c32[i];
            }
            norma_mesh mesh = good;
            mesh.corner_size = (size_t)size;
            mesh.corners = size == 1   ? (const void *)c8
                           : size == 2 ? (const void *)c16
                                       : (const void *)c32;
            expect_all(&mesh, NULL, NORMA_ERROR_INDEX);
        }
}

static void bad_index_far_into_a_large_mesh(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 200, 0);
    const norma_mesh view = mesh_file_view(&mesh);
    const size_t bytes = 12 * mesh.corner_count;
    float *normals = test_malloc(bytes), *untouched = test_malloc(bytes);
    memset(normals, 0xa5, bytes);
    memset(untouched, 0xa5, bytes);
    mesh.corners[mesh.corner_count - 1] = (uint32_t)mesh.position_count;
    for (uint32_t threads = 1; threads <= 8; threads *= 8) {
        const norma_options options = {.threads = threads};
        assert_int_equal(
            norma_face_normals(&view, &options, normals, mesh.face_count, NULL), NORMA_ERROR_INDEX);
        assert_int_equal(norma_vertex_normals(&view, &options, normals, mesh.position_count, NULL),
            NORMA_ERROR_INDEX);
        assert_int_equal(norma_corner_normals(&view, 1, &options, normals, mesh.corner_count, NULL),
            NORMA_ERROR_INDEX);
        assert_memory_equal(normals, untouched, bytes);
    }
    test_free(normals);
    test_free(untouched);
    mesh_file_free(&mesh);
}

static void values_outside_the_enums(void **state) {
    (void)state;
    norma_mesh mesh = good;
    mesh.positions.format = (norma_format)6;
    expect_all(&mesh, NULL, NORMA_ERROR_ARGUMENT);
    mesh = good;
    mesh.corner_size = 3;
    expect_all(&mesh, NULL, NORMA_ERROR_ARGUMENT);
    mesh.corner_size = 8;
    expect_all(&mesh, NULL, NORMA_ERROR_ARGUMENT);
    expect_all(&good, &(norma_options){.weight = (norma_weight)7}, NORMA_ERROR_ARGUMENT);
    expect_all(&good, &(norma_options){.weld = (norma_weld)3}, NORMA_ERROR_ARGUMENT);
    expect_all(&good, &(norma_options){.fallback = (norma_fallback)3}, NORMA_ERROR_ARGUMENT);
    expect_all(&good, &(norma_options){.isa = (norma_isa)99}, NORMA_ERROR_ARGUMENT);
}

static void instruction_sets_the_machine_lacks(void **state) {
    (void)state;
    expect_all(&good, &(norma_options){.isa = NORMA_ISA_PORTABLE}, NORMA_OK);
#if defined(__x86_64__)
    expect_all(&good, &(norma_options){.isa = NORMA_ISA_SSE2}, NORMA_OK);
    expect_all(&good, &(norma_options){.isa = NORMA_ISA_NEON}, NORMA_ERROR_ARGUMENT);
    expect_all(&good, &(norma_options){.isa = NORMA_ISA_SIMD128}, NORMA_ERROR_ARGUMENT);
#elif defined(__aarch64__)
    expect_all(&good, &(norma_options){.isa = NORMA_ISA_NEON}, NORMA_OK);
    expect_all(&good, &(norma_options){.isa = NORMA_ISA_AVX2}, NORMA_ERROR_ARGUMENT);
#endif
}

static void bad_weld_distance(void **state) {
    (void)state;
    expect_all(&good, &(norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = (double)NAN},
        NORMA_ERROR_ARGUMENT);
    expect_all(&good, &(norma_options){.weld = NORMA_WELD_EXACT, .weld_distance = (double)NAN},
        NORMA_OK); /* not looked at */
    expect_all(&good, &(norma_options){.weld = NORMA_WELD_DISTANCE, .weld_distance = 0}, NORMA_OK);
}

static void capacities(void **state) {
    (void)state;
    for (int kind = 0; kind < CALLS; ++kind)
        for (size_t capacity = 0; capacity < (kind == SPLIT ? 4 : needed[kind]); ++capacity)
            expect(kind, &good, 3.1415927F, NULL, capacity, NORMA_ERROR_CAPACITY);
    expect(SPLIT, &good, 3.1415927F, NULL, 4, NORMA_OK);
    expect(SPLIT, &good, 0, NULL, 11, NORMA_ERROR_CAPACITY);
    for (size_t corner_capacity = 0; corner_capacity < 12; ++corner_capacity) {
        outputs got, untouched;
        fill(&got);
        fill(&untouched);
        assert_int_equal(
            call(SPLIT, &good, 1, NULL, &got, ROOM, corner_capacity), NORMA_ERROR_CAPACITY);
        assert_memory_equal(&got, &untouched, sizeof got);
    }
}

static void an_index_error_is_not_hidden_by_capacity(void **state) {
    (void)state;
    norma_mesh mesh = good;
    uint32_t c[12];
    memcpy(c, tetrahedron, sizeof c);
    c[5] = 9;
    mesh.corners = c;
    for (int kind = 0; kind < CALLS; ++kind) {
        outputs got;
        fill(&got);
        const norma_result result = call(kind, &mesh, 1, NULL, &got, 0, 0);
        assert_true(result == NORMA_ERROR_INDEX || result == NORMA_ERROR_CAPACITY);
    }
}

static void products_that_overflow(void **state) {
    (void)state;
    norma_mesh mesh = good;
    mesh.positions.count = SIZE_MAX;
    expect_all(&mesh, NULL, NORMA_ERROR_OVERFLOW);
    mesh.positions.count = SIZE_MAX / 8;
    expect_all(&mesh, NULL, NORMA_ERROR_OVERFLOW);
    mesh = good;
    mesh.positions.stride = SIZE_MAX / 2;
    expect_all(&mesh, NULL, NORMA_ERROR_OVERFLOW);
    mesh = good;
    mesh.corner_count = SIZE_MAX - SIZE_MAX % 3;
    expect_all(&mesh, NULL, NORMA_ERROR_OVERFLOW);
    expect_all(&good, &(norma_options){.normal_stride = SIZE_MAX / 2}, NORMA_ERROR_OVERFLOW);
    static const uint32_t starts[] = {0, 12};
    mesh = good;
    mesh.face_starts = starts;
    mesh.face_count = SIZE_MAX;
    expect_all(&mesh, NULL, NORMA_ERROR_OVERFLOW);
}

static void strides_below_a_vector(void **state) {
    (void)state;
    for (size_t stride = 1; stride < 12; ++stride)
        expect_all(&good, &(norma_options){.normal_stride = stride}, NORMA_ERROR_ARGUMENT);
}

static void empty_meshes(void **state) {
    (void)state;
    const norma_mesh nothing = {0};
    static const uint32_t starts[1] = {0};
    norma_mesh no_face = {.face_starts = starts}, only_positions = good;
    outputs o;
    for (int kind = 0; kind < CALLS; ++kind) {
        assert_ok(call(kind, &nothing, 1, NULL, &o, 0, 0));
        assert_ok(call(kind, &no_face, 1, NULL, &o, 0, 0));
    }
    assert_int_equal(o.count, 0);
    assert_ok(norma_face_normals(&nothing, NULL, NULL, 0, NULL));
    assert_ok(norma_vertex_normals(&nothing, NULL, NULL, 0, NULL));
    assert_ok(norma_corner_normals(&nothing, 1, NULL, NULL, 0, NULL));
    only_positions.corner_count = 0;
    only_positions.corners = NULL;
    assert_ok(call(VERTICES, &only_positions, 1, NULL, &o, 4, 0));
    assert_int_equal(o.report.unreferenced.count, 4);
    assert_int_equal(o.report.unreferenced.first, 0);
    assert_int_equal(o.report.cancelled.count, 0);
    assert_true(o.report.cancelled.first == SIZE_MAX);
    for (int i = 0; i < 12; ++i) assert_true(o.normals[i] == 0);
}

/* Only the first version's fields are read of an old caller, and what a newer caller adds must not
 * be in the way. */
static void struct_sizes(void **state) {
    (void)state;
    float normals[36];
    norma_edges edges;
    norma_options options = {0};
    struct {
        norma_options options;
        unsigned char more[64];
    } bigger;
    const size_t first = offsetof(norma_options, edges);
    memset(&edges, 0xa5, sizeof edges);
    options.edges = &edges;
    assert_ok(norma_corner_normals(
        &good, 1, &options, normals, 12, NULL)); /* 0: the first version, edges are not read */
    assert_true(edges.count > 1000);
    options.struct_size = first;
    assert_ok(norma_corner_normals(&good, 1, &options, normals, 12, NULL));
    assert_true(edges.count > 1000);
    options.struct_size = sizeof options;
    assert_ok(norma_corner_normals(&good, 1, &options, normals, 12, NULL));
    assert_int_equal(edges.count, 6);
    memset(&bigger, 0, sizeof bigger);
    memset(&edges, 0xa5, sizeof edges);
    bigger.options = options;
    bigger.options.struct_size = sizeof bigger;
    assert_ok(norma_corner_normals(&good, 1, &bigger.options, normals, 12, NULL));
    assert_int_equal(edges.count, 6);
    bigger.more[63] = 1; /* something that this library does not know is asked for */
    assert_int_equal(
        norma_corner_normals(&good, 1, &bigger.options, normals, 12, NULL), NORMA_ERROR_ARGUMENT);
    options.struct_size = 8; /* smaller than any version */
    const norma_result result = norma_corner_normals(&good, 1, &options, normals, 12, NULL);
    assert_true(result == NORMA_ERROR_ARGUMENT || !result);
}

/* ---- progress */

typedef struct watch {
    double last;
    size_t calls, stop_after;
    int fell, outside;
} watch;

static int look(void *user, double fraction) {
    watch *w = user;
    w->fell |= fraction < w->last;
    w->outside |= !(fraction >= 0 && fraction <= 1);
    w->last = fraction;
    return ++w->calls == w->stop_after;
}

static void watch_all_calls(int one_ring) {
    mesh_file mesh = {0};
    if (one_ring)
        shape_fan(&mesh, 3000);
    else
        shape_wavy_grid(&mesh, 250, 0);
    const norma_mesh view = mesh_file_view(&mesh);
    float *normals = test_malloc(12 * mesh.corner_count);
    size_t cancelled = 0;
    for (int kind = 0; kind < CALLS; ++kind)
        for (uint32_t threads = 1; threads <= 4; threads *= 4) {
            watch w = {0};
            norma_options options = {.threads = threads, .progress = look, .progress_user = &w};
            size_t stop = 1, calls = SIZE_MAX, count;
            do {
                norma_result result;
                if (kind == FACES)
                    result = norma_face_normals(&view, &options, normals, mesh.corner_count, NULL);
                else if (kind == VERTICES)
                    result =
                        norma_vertex_normals(&view, &options, normals, mesh.corner_count, NULL);
                else if (kind == CORNERS)
                    result =
                        norma_corner_normals(&view, 1, &options, normals, mesh.corner_count, NULL);
                else
                    result = norma_split(&view, 1, &options, NULL, 0, NULL, normals,
                        mesh.corner_count, &count, NULL);
                assert_false(w.fell);
                assert_false(w.outside);
                if (calls == SIZE_MAX) {
                    assert_ok(result);
                    calls = w.calls;
                    assert_true(calls > 0);
                } else if (stop <= calls) {
                    assert_true(result == NORMA_CANCELLED || (threads > 1 && !result));
                    cancelled += result == NORMA_CANCELLED;
                }
                w = (watch){.stop_after = stop};
                stop = one_ring ? stop + (SLOWER > 1 ? 7 : 1) : stop * 2;
            } while (stop <= 2 * calls && calls > 0);
        }
    assert_true(cancelled >= CALLS);
    test_free(normals);
    mesh_file_free(&mesh);
}

static void progress_never_falls_and_cancels(void **state) {
    (void)state;
    watch_all_calls(0);
    watch_all_calls(1);
}

/* Joining positions by distance may take most of a call: the caller is asked on the way. */
static void welding_by_distance_can_be_stopped(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 250, 0);
    const norma_mesh view = mesh_file_view(&mesh);
    float *normals = test_malloc(12 * mesh.position_count);
    watch w = {0};
    norma_options options = {.progress = look, .progress_user = &w};
    assert_ok(norma_vertex_normals(&view, &options, normals, mesh.position_count, NULL));
    const size_t without = w.calls;
    options.weld = NORMA_WELD_DISTANCE;
    options.weld_distance = 1e-6;
    w = (watch){0};
    assert_ok(norma_vertex_normals(&view, &options, normals, mesh.position_count, NULL));
    assert_true(w.calls >= without + 14); /* at three levels of the tree, made and walked */
    const size_t calls = w.calls;
    for (size_t stop = 1; stop <= calls; ++stop) {
        w = (watch){.stop_after = stop};
        assert_int_equal(norma_vertex_normals(&view, &options, normals, mesh.position_count, NULL),
            NORMA_CANCELLED);
        assert_int_equal(w.calls, stop);
        assert_false(w.fell);
    }
    test_free(normals);
    mesh_file_free(&mesh);
}

/* A smooth mesh with a face that has no direction: stars are made for the sake of the nearest. */
static void search_for_the_nearest_can_be_stopped(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 60, 0);
    norma_mesh view = mesh_file_view(&mesh);
    const size_t corners = view.corner_count + 3;
    uint32_t *more = test_calloc(corners, sizeof *more);
    memcpy(more, view.corners, view.corner_count * sizeof *more);
    view.corners = more;
    view.corner_count = corners;
    float *normals = test_malloc(12 * corners);
    watch w = {0};
    norma_options options = {
        .fallback = NORMA_FALLBACK_NEAREST, .progress = look, .progress_user = &w};
    assert_ok(norma_corner_normals(&view, 1, &options, normals, corners, NULL));
    const size_t calls = w.calls;
    for (size_t stop = 1; stop <= calls; ++stop) {
        w = (watch){.stop_after = stop};
        assert_int_equal(
            norma_corner_normals(&view, 1, &options, normals, corners, NULL), NORMA_CANCELLED);
        assert_int_equal(w.calls, stop);
    }
    test_free(normals);
    test_free(more);
    mesh_file_free(&mesh);
}

static void every_result_has_its_own_text(void **state) {
    (void)state;
    for (int i = -5; i <= 1; ++i) {
        assert_non_null(norma_result_text((norma_result)i));
        assert_true(strlen(norma_result_text((norma_result)i)) > 1);
        for (int j = -5; j < i; ++j)
            assert_string_not_equal(
                norma_result_text((norma_result)i), norma_result_text((norma_result)j));
    }
    assert_non_null(norma_result_text((norma_result)-1000));
    assert_non_null(norma_result_text((norma_result)1000));
}

/* Numbers without a name are refused where a weight is asked for. */
static void every_weight_has_its_own_name(void **state) {
    (void)state;
    static const char *const names[] = {
        "angle", "area", "uniform", "max", "angle-area", "visible", "angle-lengths"};
    const float triangle[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const norma_mesh mesh = {.positions = {.data = triangle, .count = 3}, .corner_count = 3};
    float normals[9];
    for (int w = -3; w < 12; ++w) {
        const int is_one = w >= 0 && w < (int)(sizeof names / sizeof *names);
        const norma_options options = {.struct_size = sizeof options, .weight = (norma_weight)w};
        if (is_one)
            assert_string_equal(norma_weight_name((norma_weight)w), names[w]);
        else
            assert_null(norma_weight_name((norma_weight)w));
        assert_int_equal(norma_vertex_normals(&mesh, &options, normals, 3, NULL),
            is_one ? NORMA_OK : NORMA_ERROR_ARGUMENT);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(good_mesh_is_fine),
        cmocka_unit_test(null_mesh),
        cmocka_unit_test(null_positions),
        cmocka_unit_test(null_outputs),
        cmocka_unit_test(null_options_and_report_are_fine),
        cmocka_unit_test(creases_beyond_pi),
        cmocka_unit_test(fallbacks_that_are_not_finite),
        cmocka_unit_test(split_over_its_own_corners),
        cmocka_unit_test(wrong_options_are_named),
        cmocka_unit_test(wrong_meshes_are_named),
        cmocka_unit_test(wrong_models_are_named),
        cmocka_unit_test(triangles_in_threes),
        cmocka_unit_test(face_starts_run_from_0_to_the_end),
        cmocka_unit_test(corners_without_indices_need_positions),
        cmocka_unit_test(indices_out_of_range),
        cmocka_unit_test(bad_index_far_into_a_large_mesh),
        cmocka_unit_test(values_outside_the_enums),
        cmocka_unit_test(instruction_sets_the_machine_lacks),
        cmocka_unit_test(bad_weld_distance),
        cmocka_unit_test(capacities),
        cmocka_unit_test(an_index_error_is_not_hidden_by_capacity),
        cmocka_unit_test(products_that_overflow),
        cmocka_unit_test(strides_below_a_vector),
        cmocka_unit_test(empty_meshes),
        cmocka_unit_test(struct_sizes),
        cmocka_unit_test(progress_never_falls_and_cancels),
        cmocka_unit_test(welding_by_distance_can_be_stopped),
        cmocka_unit_test(search_for_the_nearest_can_be_stopped),
        cmocka_unit_test(every_result_has_its_own_text),
        cmocka_unit_test(every_weight_has_its_own_name),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
