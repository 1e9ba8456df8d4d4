/* test_written_once.c: what a call writes, it writes once, and never reads back: outputs may be
 * mapped memory of a GPU. The calls get jobs that are run one by one; after each, what has been
 * written since is counted and covered up again, so that a second write is seen and a value that is
 * read back is lost. The covered values are what must have been the result. */
#include "check.h"
#include "oracle/shapes.h"

enum { MOST_OUTPUTS = 5, COVER = 0x5a };

typedef struct counted_output {
    const char *name;
    unsigned char *bytes, *written, *last, *expected;
    size_t size, element; /* bytes of an element of the output: it is written as one */
} counted_output;

typedef struct counter {
    counted_output outputs[MOST_OUTPUTS];
    size_t count;
} counter;

static void look(counter *c) {
    for (size_t o = 0; o < c->count; ++o) {
        counted_output *out = &c->outputs[o];
        for (size_t at = 0; at < out->size; at += out->element) {
            int touched = 0;
            for (size_t i = 0; i < out->element; ++i) touched |= out->bytes[at + i] != COVER;
            if (!touched) continue;
            ++out->written[at / out->element];
            memcpy(out->last + at, out->bytes + at, out->element);
            memset(out->bytes + at, COVER, out->element);
        }
    }
}

static void one_by_one(void *user, size_t count, norma_task *task, void *context) {
    for (size_t i = 0; i < count; ++i) {
        task(context, i);
        look(user);
    }
}

static void *cover(counter *c, const char *name, size_t count, size_t element) {
    counted_output *out = &c->outputs[c->count++];
    *out = (counted_output){.name = name, .size = count * element, .element = element};
    out->bytes = test_malloc(out->size);
    out->last = test_malloc(out->size);
    out->expected = test_malloc(out->size);
    out->written = test_calloc(count, 1);
    memset(out->bytes, COVER, out->size);
    return out->bytes;
}

/* expected: filled by a plain call. each: all elements must be written; else, at most once. */
static void judge(counter *c, const char *what, size_t used, int each) {
    look(c);
    for (size_t o = 0; o < c->count; ++o) {
        counted_output *out = &c->outputs[o];
        for (size_t e = 0; e < out->size / out->element; ++e) {
            const int wanted = o == 0 || e < used;
            if (out->written[e] > 1 || (each && out->written[e] != wanted))
                fail_msg("%s: %s %zu is written %d times", what, out->name, e, out->written[e]);
            if (out->written[e] && memcmp(out->last + e * out->element,
                                       out->expected + e * out->element, out->element))
                fail_msg("%s: %s %zu differs: something is read back", what, out->name, e);
        }
        test_free(out->bytes);
        test_free(out->last);
        test_free(out->expected);
        test_free(out->written);
    }
    *c = (counter){.count = 0};
}

static norma_options counting(norma_options options, counter *c) {
    options.parallel_for = one_by_one;
    options.parallel_for_user = c;
    return options;
}

static void vertices_and_faces(const norma_mesh *mesh, norma_options options, size_t faces) {
    counter c = {.count = 0};
    const size_t vertices = mesh->positions.count;
    norma_options watched = counting(options, &c);
    float *normals = cover(&c, "normal", vertices, 12);
    assert_ok(norma_vertex_normals(
        mesh, &options, (float *)(void *)c.outputs[0].expected, vertices, NULL));
    assert_ok(norma_vertex_normals(mesh, &watched, normals, vertices, NULL));
    judge(&c, "vertices", vertices, 1);
    normals = cover(&c, "normal", faces, 12);
    assert_ok(
        norma_face_normals(mesh, &options, (float *)(void *)c.outputs[0].expected, faces, NULL));
    assert_ok(norma_face_normals(mesh, &watched, normals, faces, NULL));
    judge(&c, "faces", faces, 1);
}

static void corners_and_split(const norma_mesh *mesh, norma_options options, float crease) {
    counter c = {.count = 0};
    const size_t corners = mesh->corner_count;
    size_t made[2];
    norma_options watched = counting(options, &c);
    float *normals = cover(&c, "normal", corners, 12);
    assert_ok(norma_corner_normals(
        mesh, crease, &options, (float *)(void *)c.outputs[0].expected, corners, NULL));
    assert_ok(norma_corner_normals(mesh, crease, &watched, normals, corners, NULL));
    judge(&c, "corners", corners, 1);
    uint32_t *numbers = cover(&c, "corner", corners, 4);
    uint32_t *sources = cover(&c, "source", corners, 4);
    normals = cover(&c, "normal", corners, 12);
    assert_ok(norma_split(mesh, crease, &options, (uint32_t *)(void *)c.outputs[0].expected,
        corners, (uint32_t *)(void *)c.outputs[1].expected, (float *)(void *)c.outputs[2].expected,
        corners, &made[0], NULL));
    assert_ok(norma_split(
        mesh, crease, &watched, numbers, corners, sources, normals, corners, &made[1], NULL));
    assert_int_equal(made[0], made[1]);
    judge(&c, "split", made[0], 1);
}

static void plans(const norma_mesh *mesh, norma_options options, norma_element of, float crease) {
    counter c = {.count = 0};
    const size_t vertices = mesh->positions.count,
                 count = of == NORMA_PER_VERTEX ? vertices : mesh->corner_count;
    norma_plan *plan;
    uint32_t *moved = test_malloc(4 * vertices);
    for (size_t i = 0; i < vertices; ++i) moved[i] = (uint32_t)(i * 7 % vertices / 3);
    assert_ok(norma_plan_create(mesh, of, crease, &options, &plan));
    for (int some = 0; some < 2; ++some) {
        float *normals = cover(&c, "normal", count, 12);
        norma_options watched = counting(options, &c);
        assert_ok(norma_plan_update(plan, mesh->positions, NULL, 0, &options,
            (float *)(void *)c.outputs[0].expected, count, NULL));
        assert_ok(norma_plan_update(plan, mesh->positions, some ? moved : NULL, some ? vertices : 0,
            &watched, normals, count, NULL));
        judge(&c, "plan", count, !some);
    }
    norma_plan_destroy(plan);
    test_free(moved);
}

static void build(const norma_mesh *mesh, const norma_attribute *texcoords, norma_tangent_mode mode,
    norma_options options) {
    const size_t corners = mesh->corner_count;
    counter c = {.count = 0};
    norma_options watched = counting(options, &c);
    norma_built same = {.indexed = {.corner_capacity = corners, .vertex_capacity = corners}},
                built = same;
    built.indexed.corners = cover(&c, "corner", corners, 4);
    built.indexed.source_corners = cover(&c, "source corner", corners, 4);
    built.source_vertices = cover(&c, "source vertex", corners, 4);
    built.normals = cover(&c, "normal", corners, 12);
    built.tangents = cover(&c, "tangent", corners, 16);
    same.indexed.corners = c.outputs[0].expected;
    same.indexed.source_corners = (uint32_t *)(void *)c.outputs[1].expected;
    same.source_vertices = (uint32_t *)(void *)c.outputs[2].expected;
    same.normals = (float *)(void *)c.outputs[3].expected;
    same.tangents = (float *)(void *)c.outputs[4].expected;
    assert_ok(norma_build(mesh, texcoords, 1, mode, &options, &same, NULL));
    assert_ok(norma_build(mesh, texcoords, 1, mode, &watched, &built, NULL));
    judge(&c, "build", built.indexed.vertex_count, 1);
}

static void tangents(const norma_mesh *mesh, norma_options options) {
    const size_t vertices = mesh->positions.count, corners = mesh->corner_count;
    float *normals = test_malloc(12 * vertices), *texcoords = test_malloc(8 * vertices);
    options.fallback = NORMA_FALLBACK_ZERO;
    assert_ok(norma_vertex_normals(mesh, &options, normals, vertices, NULL));
    for (size_t i = 0; i < 2 * vertices; ++i) texcoords[i] = (float)(i * 2654435761U % 997) / 997;
    const norma_attribute n = {.data = normals, .count = vertices, .corners = mesh->corners},
                          t = {.data = texcoords, .count = vertices, .corners = mesh->corners};
    for (int mode = NORMA_TANGENTS_STEADY; mode <= (int)NORMA_TANGENTS_MIKK; ++mode) {
        counter c = {.count = 0};
        norma_options watched = counting(options, &c);
        float *out = cover(&c, "tangent", corners, 16);
        assert_ok(norma_corner_tangents(mesh, &n, &t, (norma_tangent_mode)mode, &options,
            (float *)(void *)c.outputs[0].expected, corners, NULL));
        assert_ok(norma_corner_tangents(
            mesh, &n, &t, (norma_tangent_mode)mode, &watched, out, corners, NULL));
        judge(&c, "tangents", corners, 1);
        norma_indexed to = {.corner_capacity = corners, .vertex_capacity = corners}, same = to;
        to.corners = cover(&c, "corner", corners, 4);
        to.source_corners = cover(&c, "source", corners, 4);
        out = cover(&c, "tangent", corners, 16);
        same.corners = c.outputs[0].expected;
        same.source_corners = (uint32_t *)(void *)c.outputs[1].expected;
        assert_ok(norma_split_tangents(mesh, &n, &t, (norma_tangent_mode)mode, &options,
            (float *)(void *)c.outputs[2].expected, &same, NULL));
        assert_ok(
            norma_split_tangents(mesh, &n, &t, (norma_tangent_mode)mode, &watched, out, &to, NULL));
        judge(&c, "split tangents", to.vertex_count, 1);
        build(mesh, &t, (norma_tangent_mode)mode, options);
    }
    test_free(normals);
    test_free(texcoords);
}

static void all_calls(const norma_mesh *mesh, size_t faces) {
    for (int fallback = 0; fallback < 3; ++fallback)
        for (int weld = 0; weld < 2; ++weld) {
            const norma_options options = {.struct_size = sizeof options,
                .fallback = (norma_fallback)fallback,
                .fallback_normal = {0, 0, 1},
                .weld = (norma_weld)weld};
            vertices_and_faces(mesh, options, faces);
            for (int crease = 0; crease < 3; ++crease) {
                corners_and_split(mesh, options, (float)crease * 0.5F);
                plans(mesh, options, (norma_element)(crease % 2), (float)crease);
            }
            if (!fallback) tangents(mesh, options);
        }
}

/* Of a grid, some faces that are flat, some back to back, some at positions that are not finite,
 * and two vertices without any. */
static void grid(int quads, int scattered) {
    mesh_file mesh = {0};
    shape_wavy_grid(&mesh, 90, quads);
    norma_mesh view = mesh_file_view(&mesh);
    const size_t per_face = quads ? 4 : 3, faces = view.corner_count / per_face,
                 vertices = view.positions.count + 2;
    float *positions = test_malloc(12 * vertices);
    for (size_t i = 0; i < vertices; ++i) {
        double at[3] = {1, 2, 3};
        if (i + 2 < vertices) norma_view_vector(&view.positions, i, at);
        for (size_t k = 0; k < 3; ++k) positions[3 * i + k] = (float)at[k];
    }
    positions[3 * 1000 + 1] = NAN;
    for (size_t f = 0; f < faces; f += 97) {
        uint32_t *c = mesh.corners + per_face * f;
        if (f % 2) c[1] = c[0];
        if (f % 3 == 0 && f) memcpy(c, (const uint32_t[]){c[-1], c[-2], c[-3]}, 12);
    }
    for (size_t f = 0; scattered && f < faces; ++f) {
        const size_t other = (f * 7919 + 13) % faces;
        for (size_t k = 0; k < per_face; ++k) {
            const uint32_t kept = mesh.corners[per_face * f + k];
            mesh.corners[per_face * f + k] = mesh.corners[per_face * other + k];
            mesh.corners[per_face * other + k] = kept;
        }
    }
    view.positions = (norma_vec3_view){positions, vertices, 0, NORMA_FORMAT_FLOAT};
    all_calls(&view, faces);
    test_free(positions);
    mesh_file_free(&mesh);
}

static void grids(void **state) {
    (void)state;
    for (int quads = 0; quads < 2; ++quads)
        for (int scattered = 0; scattered < 2; ++scattered) grid(quads, scattered);
}

static void soups(void **state) {
    (void)state;
    mesh_file mesh = {0}, soup = {0};
    shape_box(&mesh, 1, 2, 3, 0);
    shape_soup(&soup, &mesh);
    const norma_mesh view = mesh_file_view(&soup);
    all_calls(&view, view.corner_count / 3);
    mesh_file_free(&mesh);
    mesh_file_free(&soup);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(grids), cmocka_unit_test(soups)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
