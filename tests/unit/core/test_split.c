/* test_split.c: norma_split is norma_corner_normals as an indexed mesh: the same bits for each
 * corner, the old vertex behind each new one, numbered as corners first use them, no two new
 * vertices with the same old vertex and normal. */
#include "check.h"
#include "mesh_files.h"
#include "oracle/shapes.h"

#define MOST 8192

typedef struct split {
    uint32_t corners[MOST], sources[MOST];
    float normals[3 * MOST], by_corner[3 * MOST];
    size_t count;
    norma_report report, corner_report;
    norma_edges edges, corner_edges;
} split;

static uint32_t index_of(const norma_mesh *mesh, size_t corner) {
    if (!mesh->corners) return (uint32_t)corner;
    if (mesh->corner_size == 1) return ((const uint8_t *)mesh->corners)[corner];
    if (mesh->corner_size == 2) return ((const uint16_t *)mesh->corners)[corner];
    return ((const uint32_t *)mesh->corners)[corner];
}

static void check_split(const norma_mesh *mesh, float crease, norma_options options) {
    split *s = test_calloc(1, sizeof *s);
    options.struct_size = sizeof options;
    options.edges = &s->corner_edges;
    assert_true(mesh->corner_count <= MOST);
    assert_ok(norma_corner_normals(
        mesh, crease, &options, s->by_corner, mesh->corner_count, &s->corner_report));
    options.edges = &s->edges;
    size_t counted = 99;
    assert_ok(norma_split(mesh, crease, &options, NULL, 0, NULL, NULL, 0, &counted, &s->report));
    memset(s->sources, 0xa5, sizeof s->sources);
    assert_ok(norma_split(mesh, crease, &options, s->corners, mesh->corner_count, s->sources,
        s->normals, counted, &s->count, &s->report));
    assert_int_equal(s->count, counted);
    assert_memory_equal(&s->report, &s->corner_report, sizeof s->report);
    assert_memory_equal(&s->edges, &s->corner_edges, sizeof s->edges);
    size_t seen = 0;
    for (size_t c = 0; c < mesh->corner_count; ++c) {
        const uint32_t v = s->corners[c];
        assert_true(v <= seen);
        seen += v == seen;
        assert_int_equal(s->sources[v], index_of(mesh, c));
        if (memcmp(s->normals + 3 * (size_t)v, s->by_corner + 3 * c, 12))
            fail_msg("corner %zu has other bits", c);
    }
    assert_int_equal(seen, s->count);
    assert_int_equal(s->sources[s->count], 0xa5a5a5a5);
    for (size_t i = 0; i < s->count; ++i)
        for (size_t j = 0; j < i; ++j)
            if (s->sources[i] == s->sources[j])
                assert_memory_not_equal(s->normals + 3 * i, s->normals + 3 * j, 12);
    test_free(s);
}

static void check_creases(const norma_mesh *mesh) {
    static const float creases[] = {0, 0.3f, 1.04719755f, 3.14159274f};
    for (size_t i = 0; i < COUNT_OF(creases); ++i)
        for (int fallback = NORMA_FALLBACK_ZERO; fallback <= NORMA_FALLBACK_GIVEN; ++fallback)
            for (int weld = NORMA_WELD_EXACT; weld <= NORMA_WELD_NONE; ++weld)
                check_split(mesh, creases[i],
                    (norma_options){.fallback = (norma_fallback)fallback,
                        .fallback_normal = {0, 0, 1},
                        .weld = (norma_weld)weld});
}

static void surfaces(void **state) {
    (void)state;
    for (int i = 0; i < 6; ++i) {
        mesh_file mesh = {0};
        if (i == 0) shape_box(&mesh, 1, 2, 3, 0);
        if (i == 1) shape_uv_sphere(&mesh, 12, 6, 1, 1);
        if (i == 2) shape_pole_sphere(&mesh, 12, 6, 0);
        if (i == 3) shape_wavy_grid(&mesh, 8, 1);
        if (i == 4) shape_cone(&mesh, 12, .6);
        if (i == 5) shape_box(&mesh, 1, 2, 3, 1);
        const norma_mesh view = mesh_file_view(&mesh);
        check_creases(&view);
        mesh_file_free(&mesh);
    }
}

static void heaps(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 60; ++seed) {
        uint64_t random = seed;
        mesh_file mesh = {0};
        uint8_t c8[600];
        for (int i = 0; i < 30; ++i)
            mesh_file_add_position(&mesh, shape_random(&random) % 3, shape_random(&random) % 3,
                shape_random(&random) % 2);
        for (int f = 0; f < 80; ++f)
            mesh_file_add_face(&mesh,
                (uint32_t[]){shape_random(&random) % 30, shape_random(&random) % 30,
                    shape_random(&random) % 30},
                3);
        if (seed % 4 == 0) mesh.positions[3][0] = (double)NAN;
        norma_mesh view = mesh_file_view(&mesh);
        for (size_t i = 0; i < mesh.corner_count; ++i) c8[i] = (uint8_t)mesh.corners[i];
        check_creases(&view);
        view.corners = c8;
        view.corner_size = 1;
        check_creases(&view);
        mesh_file_free(&mesh);
    }
}

static void no_corners(void **state) {
    (void)state;
    mesh_file mesh = {0}, apart = {0};
    shape_wavy_grid(&mesh, 6, 0);
    shape_soup(&apart, &mesh);
    norma_mesh view = mesh_file_view(&apart);
    view.corners = NULL;
    check_creases(&view);
    mesh_file_free(&mesh);
    mesh_file_free(&apart);
}

static void known_counts(void **state) {
    (void)state;
    mesh_file mesh = {0};
    shape_box(&mesh, 1, 1, 1, 0);
    norma_mesh view = mesh_file_view(&mesh);
    size_t count;
    assert_ok(norma_split(&view, 1, NULL, NULL, 0, NULL, NULL, 0, &count, NULL));
    assert_int_equal(count, 24); /* a cube's corners, three sides each */
    assert_ok(norma_split(&view, 3.1415927F, NULL, NULL, 0, NULL, NULL, 0, &count, NULL));
    assert_int_equal(count, 8);
    view.corner_count = 0;
    view.face_count = 0;
    view.face_starts = NULL;
    assert_ok(norma_split(&view, 1, NULL, NULL, 0, NULL, NULL, 0, &count, NULL));
    assert_int_equal(count, 0); /* what no corner uses is left out */
    mesh_file_free(&mesh);
}

/* What may be NULL by itself, may be. */
static void parts_alone(void **state) {
    (void)state;
    mesh_file mesh = {0};
    uint32_t corners[36], sources[24], expected_corners[36], expected_sources[24];
    float normals[72], expected_normals[72];
    size_t count;
    shape_box(&mesh, 1, 2, 1, 0);
    const norma_mesh view = mesh_file_view(&mesh);
    assert_ok(norma_split(&view, 1, NULL, expected_corners, 36, expected_sources, expected_normals,
        24, &count, NULL));
    assert_ok(norma_split(&view, 1, NULL, corners, 36, NULL, NULL, 0, &count, NULL));
    assert_memory_equal(corners, expected_corners, sizeof corners);
    assert_ok(norma_split(&view, 1, NULL, NULL, 0, sources, NULL, 24, &count, NULL));
    assert_memory_equal(sources, expected_sources, sizeof sources);
    assert_ok(norma_split(&view, 1, NULL, NULL, 0, NULL, normals, 24, &count, NULL));
    assert_memory_equal(normals, expected_normals, sizeof normals);
    mesh_file_free(&mesh);
}

static void strided_normals(void **state) {
    (void)state;
    mesh_file mesh = {0};
    unsigned char out[24 * 40];
    float tight[72];
    size_t count;
    shape_box(&mesh, 1, 2, 1, 0);
    const norma_mesh view = mesh_file_view(&mesh);
    assert_ok(norma_split(&view, 1, NULL, NULL, 0, NULL, tight, 24, &count, NULL));
    for (size_t stride = 12; stride <= 40; ++stride) {
        memset(out, 0xa5, sizeof out);
        assert_ok(norma_split(&view, 1, &(norma_options){.normal_stride = stride}, NULL, 0, NULL,
            (float *)(void *)out, 24, &count, NULL));
        for (size_t i = 0; i < 24; ++i) {
            assert_memory_equal(out + i * stride, tight + 3 * i, 12);
            for (size_t gap = i * stride + 12; gap < (i + 1) * stride && gap < sizeof out; ++gap)
                assert_int_equal(out[gap], 0xa5);
        }
    }
    mesh_file_free(&mesh);
}

/* ---- more corners than one block of numbers holds */

typedef struct numbering {
    uint32_t *corners, *sources, *next,
        *last; /* as expected: next: of each new vertex the one before it of the same old vertex;
                  last: of each old vertex */
    float *normals;
    size_t count;
} numbering;

/* One after the other, from the normals of corners: a corner is the new vertex of its old one that
 * has its normal, or another one. */
static void number_by_hand(const norma_mesh *mesh, const float *by_corner, numbering *n) {
    const uint32_t *corners = mesh->corners;
    memset(n->last, 0xff, mesh->positions.count * sizeof *n->last);
    n->count = 0;
    for (size_t c = 0; c < mesh->corner_count; ++c) {
        uint32_t v = n->last[corners[c]];
        while (v != UINT32_MAX && memcmp(n->normals + 3 * (size_t)v, by_corner + 3 * c, 12))
            v = n->next[v];
        if (v == UINT32_MAX) {
            v = (uint32_t)n->count++;
            n->sources[v] = corners[c];
            n->next[v] = n->last[corners[c]];
            n->last[corners[c]] = v;
            memcpy(n->normals + 3 * (size_t)v, by_corner + 3 * c, 12);
        }
        n->corners[c] = v;
    }
}

static void check_large(const norma_mesh *mesh, float crease, norma_options options) {
    const size_t corners = mesh->corner_count, room = corners;
    float *by_corner = test_calloc(corners, 12), *normals = test_calloc(room, 12);
    uint32_t *found = test_calloc(corners, 4), *sources = test_calloc(room, 4);
    numbering n = {test_calloc(corners, 4), test_calloc(corners, 4), test_calloc(corners, 4),
        test_calloc(mesh->positions.count, 4), test_calloc(corners, 12), 0};
    assert_ok(norma_corner_normals(mesh, crease, &options, by_corner, corners, NULL));
    number_by_hand(mesh, by_corner, &n);
    for (int parts = 1; parts < 8; ++parts) {
        size_t count = 0;
        assert_ok(norma_split(mesh, crease, &options, parts & 1 ? found : NULL, corners,
            parts & 2 ? sources : NULL, parts & 4 ? normals : NULL, room, &count, NULL));
        assert_int_equal(count, n.count);
        if (parts & 1) assert_memory_equal(found, n.corners, 4 * corners);
        if (parts & 2) assert_memory_equal(sources, n.sources, 4 * count);
        if (parts & 4) assert_memory_equal(normals, n.normals, 12 * count);
        memset(found, 0xa5, 4 * corners);
        memset(sources, 0xa5, 4 * room);
        memset(normals, 0xa5, 12 * room);
        if (n.count > 1)
            assert_int_equal(norma_split(mesh, crease, &options, parts & 1 ? found : NULL, corners,
                                 sources, normals, n.count - 1, &count, NULL),
                NORMA_ERROR_CAPACITY);
    }
    void *const blocks[] = {
        by_corner, normals, found, sources, n.corners, n.sources, n.next, n.last, n.normals};
    for (size_t i = 0; i < COUNT_OF(blocks); ++i) test_free(blocks[i]);
}

static void many_blocks(void **state) {
    (void)state;
    for (int quads = 0; quads < 2; ++quads) {
        mesh_file mesh = {0};
        shape_wavy_grid(&mesh, 150, quads);
        for (size_t i = 0; i < mesh.position_count; i += 97)
            mesh.positions[i][2] += .3; /* peaks: creases here and there */
        for (size_t i = 1; i < mesh.position_count; i += 1009)
            memcpy(mesh.positions[i], mesh.positions[i - 1], sizeof mesh.positions[i]);
        const norma_mesh view = mesh_file_view(&mesh);
        for (uint32_t threads = 1; threads <= 3; threads += 2)
            for (int weld = NORMA_WELD_EXACT; weld <= NORMA_WELD_NONE; ++weld)
                for (int crease = 0; crease < 3; ++crease)
                    check_large(&view, (float)crease * .4f,
                        (norma_options){.threads = threads,
                            .weld = (norma_weld)weld,
                            .fallback = crease == 1 ? NORMA_FALLBACK_NEAREST : NORMA_FALLBACK_GIVEN,
                            .fallback_normal = {0, 0, 1}});
        mesh_file_free(&mesh);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces),
        cmocka_unit_test(heaps),
        cmocka_unit_test(no_corners),
        cmocka_unit_test(known_counts),
        cmocka_unit_test(parts_alone),
        cmocka_unit_test(strided_normals),
        cmocka_unit_test(many_blocks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
