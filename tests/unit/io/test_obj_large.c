/* test_obj_large.c: OBJ that is read as several stretches (256 KiB each): normals that only some of
 * them name, a fault in one of them, a statement that none of them ends in; more smoothing groups
 * that meet than a mask has bits; and statements that are rare in small files. */
#include "check.h"
#include "document_bytes.h"

enum { PIECE = 300000 };

typedef struct text {
    char *bytes;
    size_t size, room;
} text;

static void add(text *t, const char *line) {
    const size_t length = strlen(line);
    if (t->size + length + 1 > t->room) {
        t->room = 2 * (t->size + length + 1);
        t->bytes = realloc(t->bytes, t->room);
        assert_non_null(t->bytes);
    }
    memcpy(t->bytes + t->size, line, length + 1);
    t->size += length;
}

/* The line until the text is longer by at least size; how many times. */
static size_t add_lines(text *t, const char *line, size_t size) {
    const size_t end = t->size + size;
    size_t count = 0;
    for (; t->size < end; ++count) add(t, line);
    return count;
}

static document_bytes bytes_of_text(const text *t) {
    return (document_bytes){(unsigned char *)t->bytes, t->size};
}

static norma_document *open_threads(const text *t, uint32_t threads, norma_document_error *error) {
    const norma_document_options options = {.struct_size = sizeof options, .threads = threads};
    norma_document *document = NULL;
    norma_document_open_memory(t->bytes, t->size, "a.obj", &options, &document, error);
    return document;
}

/* ---- stretches */

static int add_name(void *names, const char *path) {
    strcat(names, path);
    strcat(names, "|");
    return 0;
}

/* In the first stretch, a middle one and the last; several names may be one with blanks; before and
 * behind them comments that name none.
 */
static void test_libraries_in_several_stretches(void **state) {
    (void)state;
    for (uint32_t threads = 1; threads < 4; ++threads) {
        text t = {0};
        char names[100] = "";
        norma_document_error error = {0};
        add(&t, "# mtllib no.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n\tmtllib a.mtl\n");
        add_lines(&t, "f 1 2 3\n", PIECE);
        add(&t, "mtllib b.mtl c.mtl\n");
        add_lines(&t, "f 3 2 1\n", PIECE);
        add(&t, "mtllib d.mtl\nf 1 2 3 # mtllib no.mtl\n");
        norma_document *document = open_threads(&t, threads, &error);
        if (!document) fail_msg("%s", error.message);
        assert_int_equal(norma_document_visit_files(document, add_name, names, &error), 0);
        assert_string_equal(names, "a.mtl|b.mtl c.mtl|b.mtl|c.mtl|d.mtl|");
        norma_document_close(document);
        free(t.bytes);
    }
}

/* Faces without normals, one with them, faces without: each corner names what its line says,
 * whichever stretch it stands in. */
static void test_some_stretches_name_normals(void **state) {
    (void)state;
    for (uint32_t threads = 1; threads < 4; ++threads) {
        text t = {0};
        norma_mesh_data data;
        norma_document_error error = {0};
        add(&t, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 -1\n");
        const size_t before = add_lines(&t, "f 1 2 3\n", PIECE);
        add(&t, "f 1//1 2//2 3//1\n");
        const size_t faces = before + 1 + add_lines(&t, "f 3 2 1\n", 3 * (size_t)PIECE);
        norma_document *document = open_threads(&t, threads, &error);
        if (!document || norma_document_mesh_data(document, 0, &data, &error))
            fail_msg("%s", error.message);
        assert_int_equal(data.mesh.corner_count, 3 * faces);
        for (size_t c = 0; c < 3 * faces; ++c) {
            const uint32_t *corners = data.mesh.corners, at = (uint32_t)(c % 3);
            const int named = c / 3 == before;
            if (corners[c] != (c / 3 <= before ? at : 2 - at) ||
                data.corner_normals[c] != (named ? at % 2 : UINT32_MAX))
                fail_msg("corner %zu is %u//%u", c, corners[c], data.corner_normals[c]);
        }
        norma_document_close(document);
        free(t.bytes);
    }
}

/* A fault in the first stretch and one in the last: the first is told, with its line. */
static void test_the_first_fault_is_told(void **state) {
    (void)state;
    for (uint32_t threads = 1; threads < 4; ++threads) {
        text t = {0};
        norma_document_error error = {0};
        add(&t, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 three\n");
        add_lines(&t, "f 1 2 3\n", 4 * (size_t)PIECE);
        add(&t, "f one 2 3\n");
        assert_null(open_threads(&t, threads, &error));
        assert_int_equal(error.result, NORMA_DOCUMENT_ERROR_MALFORMED);
        assert_non_null(strstr(error.message, "a.obj:5: \"three\" where"));
        free(t.bytes);
    }
}

/* One face whose lines are joined by backslashes up to the end of the file: no stretch but the last
 * can end in it. */
static void test_a_statement_without_end(void **state) {
    text t = {0};
    norma_mesh_info info;
    (void)state;
    add(&t, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf");
    const size_t threes = add_lines(&t, " 1 2 3 \\\n", 2 * (size_t)PIECE);
    add(&t, "1");
    assert_int_equal(bytes_try(bytes_of_text(&t), "a.obj", &info, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(info.faces, 1);
    assert_int_equal(info.triangles, 3 * threes + 1 - 2);
    free(t.bytes);
}

/* ---- small ones */

static void test_a_position_that_is_not_there(void **state) {
    static const char source[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\nf 1 2 9\n";
    char message[1000];
    (void)state;
    document_bytes in = bytes_copy(source, sizeof source - 1);
    assert_int_equal(bytes_try(in, "a.obj", NULL, message), NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_string_equal(message, "a.obj:6: position 9 of a face, where the file holds 3 positions");
    bytes_free(&in);
}

/* A byte order mark before the first statement belongs to none: materials and UVs are found behind
 * it, and it stays. */
static void test_a_byte_order_mark(void **state) {
    static const char source[] =
        "\xef\xbb\xbfusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0.5\nf 1/1 2/1 3/1\n";
    norma_mesh_attributes attributes;
    norma_material_info material;
    (void)state;
    document_bytes in = bytes_copy(source, sizeof source - 1);
    norma_document *document = bytes_open(in, "a.obj");
    assert_int_equal(
        norma_document_mesh_attributes(document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_material_count(document), 1);
    assert_int_equal(norma_document_material_info(document, 0, &material), NORMA_DOCUMENT_OK);
    assert_string_equal(material.name, "red");
    assert_int_equal(attributes.material, 0);
    assert_true(attributes.texcoord_count == 1 && attributes.texcoords[0] == .25f &&
                attributes.texcoords[1] == .5f);
    norma_document_close(document);
    document_bytes out = bytes_computed(in, "a.obj", NULL, NULL);
    assert_memory_equal(out.data, source, 14);
    bytes_free(&out);
    bytes_free(&in);
}

#define SURFACE                                                                                    \
    "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1//1 2//1 3//1 1//1\nparm u 0 1\nparm v 0 1\nend\n"

/* Under a mirror a surface of parameters keeps their direction, and so changes its sides; that is
 * said. */
static void test_surfaces_under_a_mirror(void **state) {
    static const char source[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1 2 3\n" SURFACE;
    const norma_transform_options options = {
        .struct_size = sizeof options, .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1}};
    (void)state;
    document_bytes in = bytes_copy(source, sizeof source - 1);
    norma_document *document = bytes_open(in, "a.obj");
    assert_int_equal(norma_document_transform(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_note_count(document), 1);
    assert_string_equal(norma_document_note(document, 0),
        "the matrix mirrors; free-form surfaces keep the direction of their parameters, so their "
        "front and back are swapped");
    document_bytes out = bytes_of(document);
    assert_string_equal(
        (const char *)out.data, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 -1\nf 1 3 2\n" SURFACE);
    norma_document_close(document);
    bytes_free(&out);
    bytes_free(&in);
}

/* Text holds 1e39; that floats do not is said, of what the matrix did alone. */
static void test_moved_beyond_floats(void **state) {
    static const char source[] = "v 0 0 0\nv 1 0 0\nv 1e39 1 0\nf 1 2 3\n";
    const norma_transform_options options = {.struct_size = sizeof options,
        .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1e39, 0, -4e38, 1}};
    (void)state;
    document_bytes in = bytes_copy(source, sizeof source - 1);
    norma_document *document = bytes_open(in, "a.obj");
    assert_int_equal(norma_document_transform(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_note_count(document), 1);
    assert_string_equal(norma_document_note(document, 0),
        "3 of 3 vertices are moved beyond 3.4e+38: programs that read floats take that for "
        "infinite");
    document_bytes out = bytes_of(document);
    assert_string_equal(
        (const char *)out.data, "v 1e+39 0 -4e+38\nv 1e+39 0 -4e+38\nv 2e+39 1 -4e+38\nf 1 2 3\n");
    norma_document_close(document);
    bytes_free(&out);
    bytes_free(&in);
}

/* Turned by 90 degrees about z, then computed: the normal that the surface uses stays the first,
 * turned; the face gets one of its own. */
static void test_turned_then_computed(void **state) {
    static const char source[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 1 0 0\nf 1 2 3\n" SURFACE;
    const norma_transform_options options = {
        .struct_size = sizeof options, .matrix = {0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    (void)state;
    document_bytes in = bytes_copy(source, sizeof source - 1);
    norma_document *document = bytes_open(in, "a.obj");
    assert_int_equal(norma_document_transform(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_compute(document, NULL, NULL, NULL), NORMA_DOCUMENT_OK);
    document_bytes out = bytes_of(document);
    assert_string_equal((const char *)out.data,
        "v 0 0 0\nv 0 1 0\nv -1 0 0\nvn 0 1 0\nvn 0 0 1\nf 1//2 2//2 3//2\n" SURFACE);
    norma_document_close(document);
    bytes_free(&out);
    bytes_free(&in);
}

/* ---- smoothing groups */

/* 33 faces, each of a group of its own, each of which shares an edge with each other: unequal
 * groups share none, so every edge between two faces is hard, though a mask has 32 bits. Each
 * corner has its face's own normal, which is worked out here from the positions (the vector area).
 */
static void test_groups_that_all_meet(void **state) {
    enum { FACES = 33, ENDS = FACES * (FACES - 1) };
    static double points[ENDS][3];
    static uint32_t corner[FACES][2 * (FACES - 1)];
    text t = {0};
    char line[100];
    size_t used = 0;
    norma_compute_summary summary;
    norma_mesh_data data;
    (void)state;
    for (size_t i = 0; i < FACES; ++i)
        for (size_t k = i + 1; k < FACES;
             ++k, used += 2) { /* an edge: one way in face i, the other in face k */
            for (size_t end = 0; end < 2; ++end)
                for (size_t axis = 0; axis < 3; ++axis)
                    points[used + end][axis] =
                        axis ? (double)((used * 37 + end * 11) * (axis + 3) % 997) / 8
                             : (double)(used + end); /* all different */
            for (size_t end = 0; end < 2; ++end) {
                corner[i][2 * (k - 1) + end] = (uint32_t)(used + end);
                corner[k][2 * i + end] = (uint32_t)(used + 1 - end);
            }
        }
    for (size_t p = 0; p < ENDS; ++p) {
        snprintf(line, sizeof line, "v %.3f %.3f %.3f\n", points[p][0], points[p][1], points[p][2]);
        add(&t, line);
    }
    for (size_t i = 0; i < FACES; ++i) {
        snprintf(line, sizeof line, "s %zu\nf", i + 1);
        add(&t, line);
        for (size_t c = 0; c < 2 * (FACES - 1); ++c) {
            snprintf(line, sizeof line, " %u", corner[i][c] + 1);
            add(&t, line);
        }
        add(&t, "\n");
    }
    document_bytes out = bytes_computed(bytes_of_text(&t), "a.obj", NULL, &summary);
    assert_int_equal(summary.by_groups, 1);
    assert_int_equal(summary.hard_edges, ENDS / 2);
    norma_document *document = bytes_open(out, "a.obj");
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    for (size_t i = 0; i < FACES; ++i) {
        double area[3] = {0, 0, 0};
        const double *o = points[corner[i][0]];
        for (size_t c = 0; c + 1 < 2 * (FACES - 1); ++c)
            for (size_t axis = 0; axis < 3; ++axis) {
                const double *a = points[corner[i][c]], *b = points[corner[i][c + 1]];
                const size_t y = (axis + 1) % 3, z = (axis + 2) % 3;
                area[axis] += (a[y] - o[y]) * (b[z] - o[z]) - (a[z] - o[z]) * (b[y] - o[y]);
            }
        for (size_t c = 0; c < 2 * (FACES - 1); ++c) {
            const uint32_t number = data.corner_normals[2 * (FACES - 1) * i + c];
            assert_direction(
                (const float *)data.normals.data + 3 * number, area[0], area[1], area[2], 1e-4);
        }
    }
    norma_document_close(document);
    bytes_free(&out);
    free(t.bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_libraries_in_several_stretches),
        cmocka_unit_test(test_some_stretches_name_normals),
        cmocka_unit_test(test_the_first_fault_is_told),
        cmocka_unit_test(test_a_statement_without_end),
        cmocka_unit_test(test_a_position_that_is_not_there),
        cmocka_unit_test(test_a_byte_order_mark),
        cmocka_unit_test(test_surfaces_under_a_mirror),
        cmocka_unit_test(test_moved_beyond_floats),
        cmocka_unit_test(test_turned_then_computed),
        cmocka_unit_test(test_groups_that_all_meet),
    };
    return cmocka_run_group_tests_name("OBJ, large and rare", tests, NULL, NULL);
}
