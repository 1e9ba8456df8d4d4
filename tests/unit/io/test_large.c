/* test_large.c: normals computed in passes have the bits of those that are computed from the whole
 * file: vertices in any order, positions that are shared, polygons, doubles, faults, old normals,
 * every weight; and what cannot be done in passes is refused. */
#define _XOPEN_SOURCE 700
#include "check.h"
#include "document_bytes.h"
#include <norma/large.h>
#include <unistd.h>

enum { SIDE = 200, VERTICES = (SIDE + 1) * (SIDE + 1), TRIANGLES = 2 * SIDE * SIDE };
static const uint64_t LITTLE = 4 << 20; /* a fifth of what the whole file takes, or less */

typedef struct made_mesh {
    double (*positions)[3];
    uint32_t (*corners)[3];
    size_t vertices, triangles;
    int quads, doubles, normals; /* some faces are quads; normals: 1 floats, 2 bytes */
} made_mesh;

static uint32_t random_below(uint32_t *state, size_t bound) {
    *state = *state * 1664525U + 1013904223U;
    return (uint32_t)(((uint64_t)*state * bound) >> 32);
}

static made_mesh make_grid(void) {
    made_mesh m = {.vertices = VERTICES, .triangles = TRIANGLES};
    m.positions = calloc((size_t)3 * TRIANGLES, sizeof *m.positions);
    m.corners = calloc(TRIANGLES, sizeof *m.corners);
    assert_non_null(m.positions);
    assert_non_null(m.corners);
    for (size_t v = 0; v < VERTICES; ++v) {
        const double x = (double)(v % (SIDE + 1)), y = (double)(v / (SIDE + 1));
        m.positions[v][0] = x;
        m.positions[v][1] = y;
        m.positions[v][2] = 4 * sin(x * 0.7) * cos(y * 0.31);
    }
    for (uint32_t q = 0; q < SIDE * SIDE; ++q) {
        const uint32_t a = q / SIDE * (SIDE + 1) + q % SIDE, c = a + SIDE + 2;
        const uint32_t two[2][3] = {{a, a + 1, c}, {a, c, a + SIDE + 1}};
        memcpy(m.corners[2 * q], two, sizeof two);
    }
    return m;
}

static void free_mesh(made_mesh *m) {
    free(m->positions);
    free(m->corners);
}

static void shuffle(made_mesh *m) {
    uint32_t seed = 7, *place = calloc(m->vertices, sizeof *place);
    double(*moved)[3] = calloc((size_t)3 * TRIANGLES, sizeof *moved);
    assert_non_null(place);
    assert_non_null(moved);
    for (size_t i = 0; i < m->vertices; ++i) place[i] = (uint32_t)i;
    for (size_t i = m->vertices - 1; i > 0; --i) {
        const uint32_t other = random_below(&seed, i + 1), held = place[i];
        place[i] = place[other];
        place[other] = held;
    }
    for (size_t i = 0; i < m->vertices; ++i)
        memcpy(moved[place[i]], m->positions[i], sizeof *moved);
    for (size_t f = 0; f < m->triangles; ++f)
        for (int k = 0; k < 3; ++k) m->corners[f][k] = place[m->corners[f][k]];
    free(m->positions);
    free(place);
    m->positions = moved;
}

/* Each corner a vertex of its own. */
static void part(made_mesh *m) {
    double(*apart)[3] = calloc((size_t)3 * TRIANGLES, sizeof *apart);
    assert_non_null(apart);
    for (size_t f = 0; f < m->triangles; ++f)
        for (size_t k = 0; k < 3; ++k) {
            memcpy(apart[3 * f + k], m->positions[m->corners[f][k]], sizeof *apart);
            m->corners[f][k] = (uint32_t)(3 * f + k);
        }
    free(m->positions);
    m->positions = apart;
    m->vertices = 3 * m->triangles;
}

/* Vertices of no face, positions that are not finite, faces without area, faces back to back. */
static void spoil(made_mesh *m) {
    for (size_t f = 3000; f < 3200; ++f)
        memcpy(m->corners[f], m->corners[f + 1], sizeof m->corners[f]);
    for (size_t f = 9000; f < 9400; ++f) m->corners[f][1] = m->corners[f][0];
    for (size_t f = 20000; f < 20600; f += 2) {
        m->corners[f + 1][0] = m->corners[f][0];
        m->corners[f + 1][1] = m->corners[f][2];
        m->corners[f + 1][2] = m->corners[f][1];
    }
    for (size_t v = 700; v < 720; ++v) m->positions[v][v % 3] = v % 2 ? NAN : INFINITY;
    for (size_t f = 0; f < m->triangles; ++f)
        for (int k = 0; k < 3; ++k)
            if (m->corners[f][k] % 997 == 0) m->corners[f][k] = 5;
}

/* ---- as a file */

static void put(FILE *out, const void *bytes, size_t size) {
    assert_int_equal(fwrite(bytes, 1, size, out), size);
}

static void put_vertex(FILE *out, const made_mesh *m, size_t v) {
    const float normal[3] = {v % 5 ? 0.6F : 0, v % 7 ? 0 : -0.0F, v % 5 ? 0.8F : 0};
    for (int k = 0; k < 3; ++k) {
        const float single = (float)m->positions[v][k];
        if (m->doubles)
            put(out, &m->positions[v][k], sizeof(double));
        else
            put(out, &single, sizeof single);
    }
    for (int k = 0; k < 3 && m->normals; ++k) {
        const signed char byte = (signed char)(127 * normal[k]);
        if (m->normals == 2)
            put(out, &byte, 1);
        else
            put(out, &normal[k], sizeof normal[k]);
    }
}

static void put_face(FILE *out, const made_mesh *m, size_t f) {
    const int is_quad = m->quads && f % 11 == 0;
    const uint32_t quad[4] = {
        m->corners[f][0], m->corners[f][1], m->corners[f][2], m->corners[f + 1][2]};
    const unsigned char count = is_quad ? 4 : 3;
    put(out, &count, 1);
    put(out, quad, 4 * (size_t)count);
}

static void write_ply(const made_mesh *m, const char *path) {
    FILE *out = fopen(path, "wb");
    const char *type = m->doubles ? "double" : "float", *of = m->normals == 2 ? "char" : "float";
    assert_non_null(out);
    fprintf(out, "ply\nformat binary_little_endian 1.0\nelement vertex %zu\n", m->vertices);
    for (int k = 0; k < 3; ++k) fprintf(out, "property %s %c\n", type, 'x' + k);
    for (int k = 0; k < 3 && m->normals; ++k) fprintf(out, "property %s n%c\n", of, 'x' + k);
    fprintf(out, "element face %zu\nproperty list uchar int vertex_indices\nend_header\n",
        m->triangles - 1);
    for (size_t v = 0; v < m->vertices; ++v) put_vertex(out, m, v);
    for (size_t f = 0; f + 1 < m->triangles; ++f) put_face(out, m, f);
    fputs("and a tail", out);
    assert_int_equal(fclose(out), 0);
}

/* ---- both ways */

static char folder[4096], input[4200], output[4200];

static int make_folder(void **state) {
    const char *scratch = getenv("NORMA_SCRATCH");
    (void)state;
    snprintf(folder, sizeof folder, "%s/norma-large-XXXXXX", scratch ? scratch : "/tmp");
    if (!mkdtemp(folder)) return -1;
    snprintf(input, sizeof input, "%s/in.ply", folder);
    snprintf(output, sizeof output, "%s/out.ply", folder);
    return 0;
}

static int remove_folder(void **state) {
    (void)state;
    remove(input);
    remove(output);
    return rmdir(folder);
}

static void assert_count(const norma_count *a, const norma_count *b) {
    assert_int_equal(a->count, b->count);
    assert_int_equal(a->first, b->first);
}

/* *passes: how many it took. */
static void assert_same(const norma_compute_options *options, size_t *passes) {
    norma_compute_summary whole = {0}, summary = {0};
    norma_document_error error = {0};
    const norma_large_options large = {
        .struct_size = sizeof large, .max_memory = LITTLE, .passes = passes};
    document_bytes in = bytes_load(input), expected;
    expected = bytes_computed(in, "in.ply", options, &whole);
    *passes = 0;
    if (norma_large_compute(input, output, &large, options, &summary, &error))
        fail_msg("%s", error.message);
    document_bytes out = bytes_load(output);
    assert_true(bytes_equal(out, expected));
    assert_int_equal(summary.changed, whole.changed);
    assert_int_equal(summary.filled, whole.filled);
    assert_int_equal(summary.faces, whole.faces);
    assert_int_equal(summary.vertices_after, whole.vertices_after);
    assert_count(&summary.report.degenerate_faces, &whole.report.degenerate_faces);
    assert_count(&summary.report.non_finite, &whole.report.non_finite);
    assert_count(&summary.report.unreferenced, &whole.report.unreferenced);
    assert_count(&summary.report.cancelled, &whole.report.cancelled);
    bytes_free(&in);
    bytes_free(&out);
    bytes_free(&expected);
}

static void assert_passes(const made_mesh *m, const norma_compute_options *options) {
    size_t passes;
    write_ply(m, input);
    assert_same(options, &passes);
    assert_true(passes > 2);
}

static void test_rows(void **state) {
    made_mesh m = make_grid();
    (void)state;
    for (int weight = 0; weight < (SLOWER > 1 ? 1 : 7); ++weight) {
        const norma_compute_options options = {
            .struct_size = sizeof options, .weight = (norma_weight)weight, .threads = 2};
        assert_passes(&m, &options);
    }
    free_mesh(&m);
}

static void test_any_order(void **state) {
    made_mesh m = make_grid();
    (void)state;
    shuffle(&m);
    assert_passes(&m, NULL);
    m.quads = 1;
    assert_passes(&m, NULL);
    free_mesh(&m);
}

static void test_shared_positions(void **state) {
    made_mesh m = make_grid();
    const norma_compute_options apart = {.struct_size = sizeof apart, .weld = NORMA_WELD_NONE};
    (void)state;
    part(&m);
    assert_passes(&m, NULL);
    assert_passes(&m, &apart);
    shuffle(&m);
    assert_passes(&m, NULL);
    free_mesh(&m);
}

static void test_doubles_of_any_size(void **state) {
    made_mesh m = make_grid();
    (void)state;
    m.doubles = 1;
    assert_passes(&m, NULL);
    for (size_t v = 0; v < m.vertices; ++v)
        for (int k = 0; k < 3; ++k) m.positions[v][k] *= 1e-215;
    assert_passes(&m, NULL);
    free_mesh(&m);
}

/* What has no normal gets the nearest, wherever in the file that is. */
static void test_faults(void **state) {
    made_mesh m = make_grid();
    (void)state;
    spoil(&m);
    for (m.normals = 0; m.normals < 3; ++m.normals)
        for (int only = 0; only < 3; ++only) {
            const norma_compute_options options = {
                .struct_size = sizeof options, .only = (norma_only)only};
            size_t passes;
            write_ply(&m, input);
            assert_same(&options, &passes);
            assert_true(passes > 2 || (m.normals && only == NORMA_ONLY_MISSING));
        }
    free_mesh(&m);
}

/* Of two vertices that are exactly as near, one in the first block and one in the last, the first:
 * their differences are the same three numbers in another order, whose squares round otherwise. */
static void test_as_near_in_other_blocks(void **state) {
    made_mesh m = make_grid();
    size_t passes;
    (void)state;
    m.doubles = 1;
    spoil(&m);
    for (size_t i = 1; i <= 40; ++i) {
        double *here = m.positions[997 * i], *first = m.positions[10 * i],
               *last = m.positions[VERTICES - 10 * i];
        for (int k = 0; k < 3; ++k) here[k] = k ? 0 : 300 + 8 * (double)i;
        for (int k = 0; k < 3; ++k) {
            const double away =
                floor(0x1p36 / sqrt((double)(10 * i + 3 * (size_t)k + 2))) * 0x1p-36;
            first[k] = here[k] + away;
            last[(k + 1) % 3] = here[(k + 1) % 3] + away;
        }
    }
    write_ply(&m, input);
    assert_same(NULL, &passes);
    assert_true(passes > 2);
    free_mesh(&m);
}

/* Once more over its own result: nothing changes. */
static void test_again(void **state) {
    made_mesh m = make_grid();
    norma_compute_summary summary;
    const norma_large_options in_place = {
        .struct_size = sizeof in_place, .max_memory = LITTLE, .in_place = 1};
    (void)state;
    write_ply(&m, input);
    assert_int_equal(norma_large_compute(input, input, &in_place, NULL, &summary, NULL), 0);
    assert_int_equal(summary.changed, 1);
    document_bytes once = bytes_load(input);
    assert_int_equal(norma_large_compute(input, input, &in_place, NULL, &summary, NULL), 0);
    assert_int_equal(summary.changed, 0);
    document_bytes twice = bytes_load(input);
    assert_true(bytes_equal(once, twice));
    bytes_free(&once);
    bytes_free(&twice);
    free_mesh(&m);
}

/* ---- what is refused */

static int cancel_later(void *user, double fraction) {
    (void)fraction;
    return ++*(int *)user > 12;
}

static void assert_refused(
    const norma_compute_options *options, norma_document_result expected, const char *words) {
    const norma_large_options large = {.struct_size = sizeof large, .max_memory = LITTLE};
    norma_document_error error = {0};
    remove(output);
    assert_int_equal(norma_large_compute(input, output, &large, options, NULL, &error), expected);
    if (!strstr(error.message, words)) fail_msg("\"%s\" lacks \"%s\"", error.message, words);
    assert_int_not_equal(access(output, F_OK), 0);
}

static void test_refused(void **state) {
    made_mesh m = make_grid();
    int calls = 0;
    const norma_compute_options crease = {.struct_size = sizeof crease,
                                    .shading = NORMA_SHADING_CREASE,
                                    .crease_angle_rad = 1},
                                near = {.struct_size = sizeof near,
                                    .weld = NORMA_WELD_DISTANCE,
                                    .weld_distance = 1e-3},
                                stopped = {.struct_size = sizeof stopped,
                                    .progress = cancel_later,
                                    .progress_user = &calls};
    (void)state;
    write_ply(&m, input);
    assert_refused(&crease, NORMA_DOCUMENT_ERROR_UNSUPPORTED, "creases need the whole file");
    assert_refused(&near, NORMA_DOCUMENT_ERROR_UNSUPPORTED, "welding by a distance");
    assert_refused(&stopped, NORMA_DOCUMENT_CANCELLED, "cancelled");
    assert_int_equal(truncate(input, 1 << 20), 0);
    assert_refused(NULL, NORMA_DOCUMENT_ERROR_MALFORMED, "the file ends");
    m.corners[TRIANGLES - 9][1] = VERTICES;
    write_ply(&m, input);
    assert_refused(NULL, NORMA_DOCUMENT_ERROR_MALFORMED, "names vertex 40401");
    free_mesh(&m);
}

static void write_small(const char *header, const void *body, size_t size) {
    FILE *out = fopen(input, "wb");
    assert_non_null(out);
    fputs("ply\nformat binary_little_endian 1.0\n", out);
    fputs(header, out);
    fputs("end_header\n", out);
    put(out, body, size);
    assert_int_equal(fclose(out), 0);
}

/* No corner at all, and so no memory for corners; and lists before the vertices, which are only
 * walked over, as strictly as in memory. */
static void test_odd_rows(void **state) {
    static const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const char listed[] = "element vertex 3\nproperty float x\nproperty float y\n"
                                 "property float z\nelement face 2\n"
                                 "property list uchar int vertex_indices\n";
    unsigned char body[64] = {0};
    size_t passes;
    (void)state;
    memcpy(body, vertices, sizeof vertices);
    write_small(listed, body, sizeof vertices + 2);
    assert_same(NULL, &passes);
    char header[300];
    snprintf(header, sizeof header, "element before 1\nproperty list char char a\n%s", listed);
    body[0] = 2;
    memcpy(body + 3, vertices, sizeof vertices);
    write_small(header, body, 3 + sizeof vertices + 2);
    assert_same(NULL, &passes);
    body[0] = 0xff;
    write_small(header, body, 3 + sizeof vertices + 2);
    assert_refused(NULL, NORMA_DOCUMENT_ERROR_MALFORMED, "a list of negative length");
}

static void test_described(void **state) {
    made_mesh m = make_grid();
    norma_large_description found;
    const norma_large_options large = {.struct_size = sizeof large, .max_memory = LITTLE};
    uint64_t need;
    (void)state;
    m.quads = 1;
    m.normals = 2;
    write_ply(&m, input);
    assert_int_equal(norma_large_describe(input, &large, NULL, NULL, &found, NULL), 0);
    assert_int_equal(found.vertices, VERTICES);
    assert_int_equal(found.faces, TRIANGLES - 1);
    assert_int_equal(found.triangles, TRIANGLES - 1 + (TRIANGLES - 2) / 11 + 1);
    assert_string_equal(found.encoding, "snorm8");
    assert_true(found.has_bounds && found.least[0] == 0 && found.most[1] == SIDE);
    assert_true(norma_large_need(input, NORMA_FILE_UNKNOWN, &need));
    assert_true(need > LITTLE);
    assert_false(norma_large_need("nothing.ply", NORMA_FILE_UNKNOWN, &need));
    free_mesh(&m);
}

/* Only its beginning is read when it is asked what an STL takes: what looks for "solid" behind
 * blanks stays within that. */
static void test_blanks(void **state) {
    (void)state;
    enum { BLANKS = 700000 };
    char path[sizeof input + 8];
    uint64_t need;
    int possible;
    snprintf(path, sizeof path, "%s.stl", input);
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    for (size_t i = 0; i < BLANKS; ++i) putc(' ', out);
    assert_int_equal(fclose(out), 0);
    possible = norma_large_need(path, NORMA_FILE_UNKNOWN, &need);
    assert_true(possible == 0 || need >= BLANKS);
    remove(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_any_order),
        cmocka_unit_test(test_shared_positions),
        cmocka_unit_test(test_doubles_of_any_size),
        cmocka_unit_test(test_faults),
        cmocka_unit_test(test_as_near_in_other_blocks),
        cmocka_unit_test(test_again),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_odd_rows),
        cmocka_unit_test(test_described),
        cmocka_unit_test(test_blanks),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
