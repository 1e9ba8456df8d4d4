/* test_ply_encodings.c: one cube in every way that a PLY can hold it: text and both byte orders,
 * positions of every type, indices and counts of every whole type, triangles, quads, quads with a
 * strip, lists and numbers of others before, between and behind. Whatever the way, what is read,
 * computed and transformed is the same, and what is not ours keeps its bytes. */
#include "check.h"
#include "document_bytes.h"
#include "ply_rows.h"

static const char *const TYPES[] = {
    "char", "uchar", "short", "ushort", "int", "uint", "float", "double"};
static const size_t SIZES[] = {1, 1, 2, 2, 4, 4, 4, 8};
enum { WHOLE_TYPES = 6, ALL_TYPES = 8 };
typedef enum shape { TRIANGLES, QUADS, QUADS_AND_STRIP, SHAPES } shape;

typedef struct way {
    char encoding;              /* 'a', 'l', 'b' */
    int position, index, count; /* types */
    shape shape;
    int list_in_vertex, list_before; /* before the list of corners */
} way;

static const double EDGE = 100;
static const unsigned QUAD[6][4] = {
    {0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {2, 3, 7, 6}, {1, 2, 6, 5}, {3, 0, 4, 7}};

static double corner_of_cube(size_t vertex, int axis) {
    return axis == 0   ? EDGE * (double)((vertex + 1) / 2 % 2)
           : axis == 1 ? EDGE * (double)(vertex / 2 % 2)
                       : EDGE * (double)(vertex / 4);
}

/* ---- writing */

static void put(document_bytes *to, const way *w, int type, double value) {
    unsigned char bytes[8];
    char text[40];
    if (w->encoding == 'a') {
        const size_t length = (size_t)snprintf(text, sizeof text, "%g ", value);
        memcpy(to->data + to->size, text, length);
        to->size += length;
        return;
    }
    const float single = (float)value;
    const int64_t whole = (int64_t)value;
    uint64_t bits = (uint64_t)whole;
    if (type == 6) {
        uint32_t narrow;
        memcpy(&narrow, &single, 4);
        bits = narrow;
    } else if (type == 7) {
        memcpy(&bits, &value, 8);
    }
    for (size_t i = 0; i < SIZES[type]; ++i)
        bytes[w->encoding == 'l' ? i : SIZES[type] - 1 - i] = (unsigned char)(bits >> 8 * i);
    memcpy(to->data + to->size, bytes, SIZES[type]);
    to->size += SIZES[type];
}

static void end_row(document_bytes *to, const way *w) {
    if (w->encoding == 'a') to->data[to->size++] = '\n';
}

static void put_list(document_bytes *to, const way *w, const unsigned *items, size_t count) {
    put(to, w, w->count, (double)count);
    for (size_t i = 0; i < count; ++i) put(to, w, w->index, items[i]);
}

static void put_face(
    document_bytes *to, const way *w, size_t face, const unsigned *corners, size_t count) {
    if (w->list_before) {
        put(to, w, 3, (double)(face % 3));
        for (size_t i = 0; i < face % 3; ++i) put(to, w, 6, (double)i + .5);
        put(to, w, 2, (double)face - 3);
    }
    put_list(to, w, corners, count);
    if (w->list_before) put(to, w, 7, (double)face / 8);
    end_row(to, w);
}

static document_bytes cube(const way *w) {
    document_bytes file = {malloc(8192), 0};
    const size_t quads = w->shape == QUADS_AND_STRIP ? 5 : 6,
                 faces = w->shape == TRIANGLES ? 12 : quads;
    const char *const position = TYPES[w->position];
    file.size = (size_t)snprintf((char *)file.data, 4096,
        "ply\nformat %s 1.0\nelement vertex 8\nproperty %s x\n%sproperty %s y\nproperty %s "
        "z\nelement face %zu\n%sproperty list %s %s vertex_indices\n%s",
        w->encoding == 'a'   ? "ascii"
        : w->encoding == 'l' ? "binary_little_endian"
                             : "binary_big_endian",
        position, w->list_in_vertex ? "property list char short tags\n" : "", position, position,
        faces, w->list_before ? "property list ushort float values\nproperty short kind\n" : "",
        TYPES[w->count], TYPES[w->index], w->list_before ? "property double area\n" : "");
    file.size += (size_t)snprintf((char *)file.data + file.size, 200,
        w->shape == QUADS_AND_STRIP
            ? "element tristrips 1\nproperty list %s %s vertex_indices\nend_header\n"
            : "end_header\n",
        TYPES[w->count], TYPES[w->index]);
    for (size_t v = 0; v < 8; ++v) {
        put(&file, w, w->position, corner_of_cube(v, 0));
        if (w->list_in_vertex) {
            put(&file, w, 0, (double)(v % 4));
            for (size_t i = 0; i < v % 4; ++i) put(&file, w, 2, -300 * (double)i);
        }
        put(&file, w, w->position, corner_of_cube(v, 1));
        put(&file, w, w->position, corner_of_cube(v, 2));
        end_row(&file, w);
    }
    for (size_t q = 0; q < quads; ++q) {
        const unsigned *c = QUAD[q], second[3] = {c[0], c[2], c[3]};
        put_face(&file, w, q, c, w->shape == TRIANGLES ? 3 : 4);
        if (w->shape == TRIANGLES) put_face(&file, w, q + 6, second, 3);
    }
    if (w->shape == QUADS_AND_STRIP) {
        const unsigned *c = QUAD[5], strip[4] = {c[0], c[1], c[3], c[2]};
        put_list(&file, w, strip, 4);
        end_row(&file, w);
    }
    file.data[file.size] = 0;
    return file;
}

/* ---- reading back, without the library */

typedef struct solid {
    double volume, area[3]; /* the area vector's absolute parts, summed */
    size_t triangles;
} solid;

static void add_triangle(solid *s, const ply_rows *rows, const rows_element *vertex, long long a,
    long long b, long long c) {
    static const char *const axes[3] = {"x", "y", "z"};
    const long long corners[3] = {a, b, c};
    double p[3][3];
    for (int k = 0; k < 3; ++k)
        for (int axis = 0; axis < 3; ++axis) {
            assert_true(corners[k] >= 0 && corners[k] < (long long)vertex->count);
            p[k][axis] = rows_number(rows, vertex, (size_t)corners[k], axes[axis]);
        }
    for (int axis = 0; axis < 3; ++axis) {
        const int y = (axis + 1) % 3, z = (axis + 2) % 3;
        s->volume += p[0][axis] * (p[1][y] * p[2][z] - p[1][z] * p[2][y]) / 6;
        s->area[axis] += fabs((p[1][y] - p[0][y]) * (p[2][z] - p[0][z]) -
                              (p[1][z] - p[0][z]) * (p[2][y] - p[0][y])) /
                         2;
    }
    ++s->triangles;
}

static solid solid_of(const ply_rows *rows) {
    const rows_element *vertex = rows_find(rows, "vertex"), *face = rows_find(rows, "face"),
                       *strips = rows_find(rows, "tristrips");
    solid s = {0};
    long long c[64];
    for (size_t f = 0; f < face->count; ++f) {
        const size_t count = rows_list(rows, face, f, rows_property_of(face, "vertex_indices"), c);
        for (size_t i = 2; i < count; ++i) add_triangle(&s, rows, vertex, c[0], c[i - 1], c[i]);
    }
    for (size_t r = 0; strips && r < strips->count; ++r) {
        const size_t count = rows_list(rows, strips, r, 0, c);
        for (size_t i = 0, begin = 0; i + 2 < count; ++i) { /* -1 begins anew */
            if (c[i + 2] < 0) {
                i += 2;
                begin = i + 1;
                continue;
            }
            if (c[i] != c[i + 1] && c[i + 1] != c[i + 2] && c[i] != c[i + 2])
                add_triangle(&s, rows, vertex, c[i], c[i + 1 + ((i - begin) & 1)],
                    c[i + 2 - ((i - begin) & 1)]);
        }
    }
    return s;
}

static void assert_cube(const ply_rows *rows, double x, double y, double z) {
    const solid s = solid_of(rows);
    const double area[3] = {2 * y * z, 2 * x * z, 2 * x * y};
    assert_int_equal(s.triangles, 12);
    assert_true(fabs(s.volume - x * y * z) <= 1e-9 * x * y * z);
    for (int axis = 0; axis < 3; ++axis)
        assert_true(fabs(s.area[axis] - area[axis]) <= 1e-9 * area[axis]);
}

static int is_ours(const char *name) {
    static const char *const ours[] = {"x", "y", "z", "nx", "ny", "nz", "vertex_indices"};
    for (size_t i = 0; i < COUNT_OF(ours); ++i)
        if (strcmp(name, ours[i]) == 0) return 1;
    return 0;
}

/* What the library has no business with has the bytes that it had. */
static void assert_others_stay(const ply_rows *before, const ply_rows *after) {
    assert_int_equal(before->element_count, after->element_count);
    for (size_t e = 0; e < before->element_count; ++e) {
        const rows_element *was = &before->elements[e], *is = rows_find(after, was->name);
        assert_non_null(is);
        for (size_t p = 0; p < was->property_count; ++p) {
            const int at = rows_property_of(is, was->properties[p].name);
            assert_true(at >= 0);
            if (is_ours(was->properties[p].name)) continue;
            assert_string_equal(was->properties[p].type, is->properties[at].type);
            for (size_t row = 0; row < was->count && row < is->count; ++row) {
                const rows_value a = rows_value_of(was, row, (int)p),
                                 b = rows_value_of(is, row, at);
                assert_int_equal(a.size, b.size);
                assert_memory_equal(a.at, b.at, a.size);
            }
        }
    }
}

/* ---- one way */

static void check_reading(document_bytes file, const way *w) {
    const size_t faces = w->shape == TRIANGLES ? 12 : w->shape == QUADS ? 6 : 7;
    norma_mesh_info info;
    norma_mesh_data data;
    norma_document *document = bytes_open(file, "cube.ply");
    assert_int_equal(norma_document_mesh_info(document, 0, &info), NORMA_DOCUMENT_OK);
    assert_true(info.vertices == 8 && info.faces == faces && info.triangles == 12 &&
                info.normals == NORMA_NORMALS_NONE);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    double moved[24];
    const double same[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    assert_ok(norma_transform_positions_double(same, data.mesh.positions, moved, 0, 8));
    for (size_t v = 0; v < 8; ++v)
        for (int axis = 0; axis < 3; ++axis)
            assert_true(moved[3 * v + (size_t)axis] == corner_of_cube(v, axis));
    norma_document_close(document);

    const norma_document_options brief = {
        .struct_size = sizeof brief, .depth = NORMA_DOCUMENT_SUMMARY};
    assert_int_equal(
        norma_document_open_memory(file.data, file.size, "cube.ply", &brief, &document, NULL),
        NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_info(document, 0, &info), NORMA_DOCUMENT_OK);
    assert_true(info.vertices == 8 && info.faces == faces && info.triangles == 12);
    norma_document_close(document);
}

static void check_smooth(document_bytes file) {
    document_bytes out = bytes_computed(file, "cube.ply", NULL, NULL);
    ply_rows before, after;
    assert_true(
        rows_parse(file.data, file.size, &before) && rows_parse(out.data, out.size, &after));
    const rows_element *vertex = rows_find(&after, "vertex");
    assert_int_equal(vertex->count, 8);
    for (size_t v = 0; v < 8; ++v) {
        static const char *const axes[3] = {"nx", "ny", "nz"};
        for (int axis = 0; axis < 3; ++axis) {
            const double sign = corner_of_cube(v, axis) > 0 ? 1 : -1;
            assert_true(fabs(rows_number(&after, vertex, v, axes[axis]) - sign / sqrt(3)) < 1e-7);
        }
    }
    assert_cube(&after, EDGE, EDGE, EDGE);
    assert_others_stay(&before, &after);
    rows_free(&before);
    rows_free(&after);
    bytes_free(&out);
}

static void check_creases(document_bytes file) {
    const norma_compute_options options = {
        .struct_size = sizeof options, .shading = NORMA_SHADING_CREASE, .crease_angle_rad = .5};
    norma_compute_summary summary;
    document_bytes out = bytes_computed(file, "cube.ply", &options, &summary);
    ply_rows before, after;
    assert_true(
        rows_parse(file.data, file.size, &before) && rows_parse(out.data, out.size, &after));
    const rows_element *vertex = rows_find(&after, "vertex");
    assert_int_equal(vertex->count, 24);
    double sum = 0;
    for (size_t v = 0; v < 24; ++v) /* each along one axis */
        sum += fabs(rows_number(&after, vertex, v, "nx")) +
               fabs(rows_number(&after, vertex, v, "ny")) +
               fabs(rows_number(&after, vertex, v, "nz"));
    assert_true(sum == 24);
    assert_cube(&after, EDGE, EDGE, EDGE);
    assert_others_stay(&before, &after);
    rows_free(&before);
    rows_free(&after);
    bytes_free(&out);
}

/* A mirror and three scales: outside stays outside, so the volume is positive; types hold what they
 * can, or become wider. */
static void check_transform(document_bytes file) {
    static const double matrices[2][16] = {{-2, 0, 0, 0, 0, 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
        {.5, 0, 0, 0, 0, .3125, 0, 0, 0, 0, 400, 0, 7, -9, 1, 1}};
    static const double sizes[2][3] = {{200, 300, 100}, {50, 31.25, 40000}};
    for (int m = 0; m < 2; ++m) {
        norma_transform_summary summary;
        document_bytes out = bytes_transformed(file, "cube.ply", matrices[m], &summary);
        ply_rows before, after;
        assert_true(
            rows_parse(file.data, file.size, &before) && rows_parse(out.data, out.size, &after));
        assert_int_equal(summary.mirrored, m == 0);
        assert_cube(&after, sizes[m][0], sizes[m][1], sizes[m][2]);
        assert_others_stay(&before, &after);
        rows_free(&before);
        rows_free(&after);
        bytes_free(&out);
    }
}

static void check_way(const way *w) {
    document_bytes file = cube(w);
    check_reading(file, w);
    check_smooth(file);
    check_creases(file);
    check_transform(file);
    bytes_free(&file);
}

static void test_every_way(void **state) {
    static const char encodings[] = "alb";
    size_t ways = 0;
    (void)state;
    for (int e = 0; e < 3; ++e)
        for (int position = 0; position < ALL_TYPES; ++position)
            for (int index = 0; index < WHOLE_TYPES; ++index)
                for (int count = 0; count < WHOLE_TYPES; count += 1 + (index + position) % 3)
                    for (int shape_of = 0; shape_of < SHAPES; ++shape_of) {
                        const way w = {.encoding = encodings[e],
                            .position = position,
                            .index = index,
                            .count = count,
                            .shape = (shape)shape_of,
                            .list_in_vertex = (int)(ways % 2),
                            .list_before = (int)(ways / 2 % 2)};
                        if (ways++ % SLOWER == 0) check_way(&w);
                    }
    print_message("%zu ways\n", ways);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_every_way)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
