/* test_transform_range.c: a matrix that takes a finite coordinate out of the range of the file's
 * numbers is refused as content that cannot be done, with the element named, alike in OBJ, PLY and
 * STL; floats of a PLY become doubles where those hold the result; nothing ever says inf or nan.
 * An OBJ's numbers have no type: they are doubles, as far as those reach. Numbers of glTF's nodes
 * are floats wherever they are read. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>
#include "document_bytes.h"

#define PLY(type)                                                                                  \
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty " type " x\nproperty " type                 \
    " y\nproperty " type                                                                           \
    " z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"

static void scaled(norma_transform_options *options, double x) {
    *options = (norma_transform_options){.struct_size = sizeof *options};
    options->matrix[0] = x;
    options->matrix[5] = options->matrix[10] = options->matrix[15] = 1;
}

static norma_document_result transform(
    const char *text, const char *name, norma_document_error *error, norma_document **document) {
    norma_transform_options options;
    scaled(&options, 1e30);
    assert_int_equal(
        norma_document_open_memory(text, strlen(text), name, NULL, document, error), 0);
    return norma_document_transform(*document, &options, NULL, error);
}

static void assert_refused(const char *text, const char *name, const char *place) {
    norma_document_error error;
    norma_document *document;
    assert_int_equal(transform(text, name, &error, &document), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, place));
    norma_document_close(document);
}

static void what_no_number_holds_is_refused(void **state) {
    (void)state;
    assert_refused("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj", "a.obj:vertex 1: ");
    assert_refused(PLY("double") "0 0 0\n1e300 0 0\n0 1 0\n3 0 1 2\n", "a.ply", "a.ply:vertex 1: ");
    assert_refused("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e30 0 0\nvertex 0 "
                   "1 0\nendloop\nendfacet\nendsolid\n",
        "a.stl", "a.stl:facet 0: ");
}

static void floats_become_doubles(void **state) {
    norma_document_error error;
    norma_document *document;
    (void)state;
    assert_int_equal(
        transform(PLY("float") "0 0 0\n1e30 0 0\n0 1 0\n3 0 1 2\n", "a.ply", &error, &document),
        NORMA_DOCUMENT_OK);
    document_bytes out = bytes_of(document);
    char text[600] = "";
    memcpy(text, out.data, out.size < sizeof text ? out.size : sizeof text - 1);
    assert_non_null(strstr(text, "property double x\n"));
    assert_non_null(strstr(text, "e+60 0 0\n"));
    bytes_free(&out);
    norma_document_close(document);
}

static norma_document_result place(
    int is_scale, double x, double y, int bake, norma_document_error *error) {
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
        "\"camera\":0,\"children\":[1],\"translation\":[2,0,0]},{\"camera\":0}],\"cameras\":[{"
        "\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}]}";
    norma_document *document;
    norma_transform_options options;
    scaled(&options, is_scale ? x : 1);
    if (!is_scale) {
        options.matrix[12] = x;
        options.matrix[13] = y;
    }
    options.bake = bake;
    assert_int_equal(
        norma_document_open_memory(text, sizeof text - 1, "a.gltf", NULL, &document, error), 0);
    const norma_document_result result = norma_document_transform(document, &options, NULL, error);
    document_bytes out = bytes_of(document); /* a change that failed changed nothing */
    if (result) {
        assert_int_equal(out.size, sizeof text - 1);
        assert_memory_equal(out.data, text, out.size);
    }
    bytes_free(&out);
    norma_document_close(document);
    return result;
}

static void numbers_of_nodes_are_floats(void **state) {
    norma_document_error error;
    (void)state;
    for (int bake = 0; bake < 2; ++bake) {
        assert_int_equal(place(0, 1e39, 0, bake, &error), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
        assert_string_equal(error.message,
            "a.gltf:new node 2: its translation would hold 1e+39; expected numbers up to 3.4e+38, "
            "the largest float");
        assert_int_equal(place(0, 0, -3.4e48, bake, &error), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
        assert_non_null(strstr(error.message, "translation would hold -3.4e+48; "));
        assert_int_equal(place(1, 1e39, 0, bake, &error), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
        assert_non_null(strstr(error.message, "its scale would hold 1e+39; "));
        assert_int_equal(place(0, 3.4e38, 3.4e38, bake, &error), NORMA_DOCUMENT_OK);
    }
}

/* What was not finite before is no reason to refuse. */
static void infinities_stay(void **state) {
    norma_document_error error;
    norma_document *document;
    (void)state;
    assert_int_equal(
        transform("v 0 0 0\nv inf 0 0\nv 0 1 0\nf 1 2 3\n", "a.obj", &error, &document), 0);
    norma_document_close(document);
}

static void a_zero_byte_is_a_blank(void **state) {
    static const char texts[][60] = {
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n\0", "v 0 0 0\nv 1 0 0 \0\nv 0 1 0\0\nf 1 2 3\0"};
    static const size_t sizes[] = {33, 36};
    (void)state;
    for (size_t i = 0; i < 2; ++i) {
        norma_document *document;
        norma_document_error error;
        norma_compute_summary summary;
        assert_int_equal(texts[i][sizes[i] - 1], 0);
        assert_int_equal(
            norma_document_open_memory(texts[i], sizes[i], "a.obj", NULL, &document, &error), 0);
        assert_int_equal(norma_document_note_count(document), 0);
        assert_int_equal(norma_document_compute(document, NULL, &summary, &error), 0);
        assert_int_equal(summary.faces, 1);
        document_bytes out = bytes_of(document);
        assert_int_equal(out.data[out.size - 1], 0); /* it is kept */
        bytes_free(&out);
        norma_document_close(document);
    }
}

/* Not even the end of the first word is looked for: none of the many megabytes behind is read. */
static void an_obj_of_zeros_is_refused(void **state) {
    static const unsigned char zeros[100000];
    norma_document *document;
    norma_document_error error;
    (void)state;
    assert_int_equal(
        norma_document_open_memory(zeros, sizeof zeros, "a.obj", NULL, &document, &error),
        NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_non_null(strstr(error.message, "begins with zeros"));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_no_number_holds_is_refused),
        cmocka_unit_test(floats_become_doubles), cmocka_unit_test(numbers_of_nodes_are_floats),
        cmocka_unit_test(infinities_stay), cmocka_unit_test(a_zero_byte_is_a_blank),
        cmocka_unit_test(an_obj_of_zeros_is_refused)};
    return cmocka_run_group_tests_name("the range of files; zero bytes", tests, NULL, NULL);
}
