/* test_stl.c: STL: text and binary, what is kept, what is refused; every file of the data set
 * rewritten and compared byte by byte, where the test itself tells the places of the normals. */
#include "check.h"
#include "document_bytes.h"
#include "mesh_files.h"
#include <ctype.h>

static document_bytes text_file(const char *text) { return bytes_copy(text, strlen(text)); }

static void assert_text(document_bytes bytes, const char *expected) {
    if (bytes.size != strlen(expected) || memcmp(bytes.data, expected, bytes.size) != 0)
        fail_msg("got\n%.*s\nexpected\n%s", (int)bytes.size, (const char *)bytes.data, expected);
}

static const double mirror_x[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/* ---- text */

static const char odd_text[] =
    "\n SOLID  a name \xff\xc3\xa9\r\n\tFacet NORMAL 9 9 9\r\nouter   loop vertex 0 0 0 vertex 1.0 "
    "0 0\r\nVertex 0 1e0 0\r\nEndLoop endfacet\r\nfacet normal nan -0 1\nouter loop\nvertex 0 0 "
    "0\nvertex 0 0 0\nvertex 1 1 1\nendloop\nendfacet\nendsolid facet a "
    "name\nsolid\nendsolid\nsolid two\nfacet normal 0 0.0 1.00\nouter loop\nvertex 0 0 5\nvertex 1 "
    "0 5\nvertex 0 1 5\nendloop\nendfacet\nendsolid";

static void test_text_keeps_all_but_the_normals(void **state) {
    (void)state;
    document_bytes in = text_file(odd_text);
    norma_compute_summary summary;
    norma_mesh_info info;
    assert_int_equal(bytes_try(in, "a.stl", &info, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(info.faces, 3);
    assert_int_equal(info.vertices, 9);
    assert_int_equal(info.normals, NORMA_NORMALS_PER_FACET);
    document_bytes out = bytes_computed(in, "a.stl", NULL, &summary);
    assert_text(out,
        "\n SOLID  a name \xff\xc3\xa9\r\n\tFacet NORMAL 0 0 1\r\nouter   loop vertex 0 0 0 "
        "vertex 1.0 0 0\r\nVertex 0 1e0 0\r\nEndLoop endfacet\r\nfacet normal 0 -0 1\nouter "
        "loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 1 1 1\nendloop\nendfacet\nendsolid facet a "
        "name\nsolid\nendsolid\nsolid two\nfacet normal 0 0.0 1.00\nouter loop\nvertex 0 0 "
        "5\nvertex 1 0 5\nvertex 0 1 5\nendloop\nendfacet\nendsolid");
    assert_int_equal(summary.changed, 1);
    assert_int_equal(summary.shading, NORMA_SHADING_FLAT);
    assert_int_equal(summary.report.degenerate_faces.count, 1);
    assert_int_equal(summary.report.degenerate_faces.first, 1);
    assert_int_equal(summary.filled, 1);
    bytes_free(&in);
    bytes_free(&out);
}

static void assert_name(const char *text, const char *name) {
    document_bytes in = text_file(text);
    norma_document *document = bytes_open(in, "a.stl");
    norma_mesh_info info;
    norma_document_mesh_info(document, 0, &info);
    assert_string_equal(info.name, name);
    assert_string_equal(info.encoding, "text");
    norma_document_close(document);
    bytes_free(&in);
}

static void test_the_name_is_utf_8(void **state) {
    (void)state;
    assert_name(odd_text, "a name ?\xc3\xa9");
    /* A surrogate, an overlong slash, what lies beyond U+10FFFF, the last character. */
    assert_name("solid \xed\xa0\x80 \xe0\x80\xaf \xf4\x90\x80\x80 \xf4\x8f\xbf\xbf\nendsolid\n",
        "??? ??? ???? \xf4\x8f\xbf\xbf");
}

static void test_mirror_in_text(void **state) {
    (void)state;
    document_bytes in =
        text_file("solid\nfacet normal 0.0 0 1.0\nouter loop\nvertex 0.0 0 0\nvertex 1 0.50 "
                  "0\nvertex 0 1 2.5\nendloop\nendfacet\nendsolid\n");
    norma_transform_summary summary;
    document_bytes out = bytes_transformed(in, "a.stl", mirror_x, &summary);
    assert_text(out, "solid\nfacet normal 0.0 0 1.0\nouter loop\nvertex 0.0 0 0\nvertex 0 1 "
                     "2.5\nvertex -1 0.5 0\nendloop\nendfacet\nendsolid\n");
    assert_int_equal(summary.mirrored, 1);
    assert_int_equal(summary.vertices, 3);
    bytes_free(&in);
    bytes_free(&out);
}

/* Numbers of more digits than a float has stay exact. */
/* They may say whatever a facet does. */
static void test_comments_stay(void **state) {
    (void)state;
    document_bytes in =
        text_file("# one\nsolid a # name\n! two\nfacet // three outer\nnormal 9 0 1 ; "
                  "four\nouter loop\n vertex 0 0 0 # vertex 5 5 5\nvertex 1 0 0 "
                  "%five\n#\nvertex 0 1 0\nendloop # facet\nendfacet\n# six\n"
                  "endsolid a # seven\n# eight");
    document_bytes out = bytes_computed(in, "a.stl", NULL, NULL);
    assert_text(out, "# one\nsolid a # name\n! two\nfacet // three outer\nnormal 0 0 1 ; "
                     "four\nouter loop\n vertex 0 0 0 # vertex 5 5 5\nvertex 1 0 0 "
                     "%five\n#\nvertex 0 1 0\nendloop # facet\nendfacet\n# six\n"
                     "endsolid a # seven\n# eight");
    bytes_free(&in);
    bytes_free(&out);
}

static void test_far_coordinates_in_text(void **state) {
    (void)state;
    const double back[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -4500000, 0, 0, 1},
                 on[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1};
    document_bytes in =
        text_file("solid\nfacet normal 0 0 1\nouter loop\nvertex 4500000.125 0 0\nvertex "
                  "4500001.375 0 0\nvertex 4500000.125 1 0\nendloop\nendfacet\nendsolid\n");
    document_bytes out = bytes_transformed(in, "a.stl", back, NULL);
    assert_text(out, "solid\nfacet normal 0 0 1\nouter loop\nvertex 0.125 0 0\nvertex 1.375 0 "
                     "0\nvertex 0.125 1 0\nendloop\nendfacet\nendsolid\n");
    document_bytes far = bytes_transformed(in, "a.stl", on, NULL);
    assert_non_null(
        strstr((const char *)far.data, "vertex 4500001.125 0 0\nvertex 4500002.375 0 0\n"));
    bytes_free(&in);
    bytes_free(&out);
    bytes_free(&far);
}

/* ---- binary */

static document_bytes binary_file(
    const char *header, const float facets[][12], size_t count, const char *rest) {
    const size_t size = 84 + 50 * count + strlen(rest);
    document_bytes bytes = bytes_copy("", 0);
    bytes.data = realloc(bytes.data, size + 1);
    bytes.size = size;
    memset(bytes.data, 0, size);
    memcpy(bytes.data, header, strlen(header));
    bytes.data[80] = (unsigned char)count;
    for (size_t i = 0; i < count; ++i) {
        memcpy(bytes.data + 84 + 50 * i, facets[i], 48);
        bytes.data[84 + 50 * i + 48] = (unsigned char)(i + 1);
        bytes.data[84 + 50 * i + 49] = 0x80;
    }
    memcpy(bytes.data + 84 + 50 * count, rest, strlen(rest));
    return bytes;
}

static const float facets[4][12] = {{0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0},
    {0, 1, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0}, {NAN, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1},
    {0, 0, 3, 9, 9, 9, 9, 9, 9, 8, 8, 8}};
static const float wanted[4][3] = {{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}};

static void test_binary_that_begins_with_solid(void **state) {
    (void)state;
    document_bytes in = binary_file("solid of facets\nfacet normal", facets, 4, ""),
                   rest = binary_file("solid but binary", facets, 4, "and more");
    document_bytes *files[] = {&in, &rest};
    for (int i = 0; i < 2; ++i) {
        norma_compute_summary summary;
        document_bytes out = bytes_computed(*files[i], "a.stl", NULL, &summary);
        assert_int_equal(out.size, files[i]->size);
        assert_int_equal(summary.filled, 1);
        assert_memory_equal(out.data, files[i]->data, 84);
        for (size_t f = 0; f < 4; ++f) {
            assert_memory_equal(out.data + 84 + 50 * f + 12, files[i]->data + 84 + 50 * f + 12, 38);
            if (f < 3) assert_memory_equal(out.data + 84 + 50 * f, wanted[f], 12);
        }
        /* The nearest first corner to (9, 9, 9) is the origin of the three others, the least of
         * them. */
        assert_memory_equal(out.data + 84 + 150, wanted[3], 12);
        assert_memory_equal(out.data + 284, files[i]->data + 284, out.size - 284);
        bytes_free(&out);
    }
    bytes_free(&in);
    bytes_free(&rest);
}

static void test_only_missing_and_broken(void **state) {
    (void)state;
    document_bytes in = binary_file("", facets, 4, "");
    const norma_compute_options missing = {.struct_size = sizeof missing,
                                    .only = NORMA_ONLY_MISSING},
                                broken = {.struct_size = sizeof broken, .only = NORMA_ONLY_BROKEN};
    norma_compute_summary summary;
    document_bytes a = bytes_computed(in, "a.stl", &missing, &summary);
    assert_memory_equal(a.data + 84, wanted[0], 12);
    assert_memory_equal(a.data + 134, in.data + 134, 150); /* a NaN is not missing */
    assert_int_equal(summary.filled, 0);
    document_bytes b = bytes_computed(in, "a.stl", &broken, &summary);
    assert_memory_equal(b.data + 84, wanted[0], 12);
    assert_memory_equal(b.data + 184, wanted[2], 12);
    assert_memory_equal(b.data + 234, in.data + 234, 50); /* not of unit length, but a direction */
    bytes_free(&in);
    bytes_free(&a);
    bytes_free(&b);
}

/* More facets than are computed at a time, along the three axes in turn; then with a last one that
 * has no direction. */
static void test_many_facets(void **state) {
    (void)state;
    enum { MANY = 70001 };
    static const float turn[3][9] = {
        {0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0, 0, 0, 1, 1, 0, 0}};
    document_bytes in = {calloc(84 + 50 * MANY + 1, 1), 84 + 50 * MANY};
    const uint32_t count = MANY;
    memcpy(in.data + 80, &count, 4);
    for (size_t i = 0; i < MANY; ++i) {
        float vertices[9];
        for (size_t k = 0; k < 9; ++k) vertices[k] = turn[i % 3][k] + (k % 3 == 0 ? (float)i : 0);
        memcpy(in.data + 84 + 50 * i + 12, vertices, 36);
    }
    for (int degenerate = 0; degenerate < 2; ++degenerate) {
        norma_compute_summary summary;
        if (degenerate) memset(in.data + 84 + 50 * (MANY - 1) + 12, 0, 36);
        document_bytes out = bytes_computed(in, "a.stl", NULL, &summary);
        for (size_t i = 0; i < MANY; ++i) {
            const size_t axis =
                degenerate && i == MANY - 1 ? 2 : (i + 2) % 3; /* the nearest is facet 0 */
            float normal[3], expected[3] = {0};
            expected[axis] = 1;
            memcpy(normal, out.data + 84 + 50 * i, 12);
            for (size_t k = 0; k < 3; ++k) assert_true(normal[k] == expected[k]);
        }
        assert_int_equal(summary.report.degenerate_faces.count, degenerate);
        assert_int_equal(summary.report.degenerate_faces.first, degenerate ? MANY - 1 : SIZE_MAX);
        assert_int_equal(summary.filled, degenerate);
        bytes_free(&out);
    }
    bytes_free(&in);
}

/* Facets that are right already but for the sign of a zero, and one file in which no facet has a
 * direction. */
static void test_signs_of_zeros_and_no_direction(void **state) {
    (void)state;
    static const float right[1][12] = {{-0.0f, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}},
                       none[1][12] = {{5, 5, 5, 0, 0, 0, 1, 1, 1, 2, 2, 2}};
    document_bytes a = binary_file("", right, 1, ""), b = binary_file("", none, 1, "");
    norma_compute_summary summary;
    document_bytes same = bytes_computed(a, "a.stl", NULL, &summary);
    assert_int_equal(summary.changed, 0);
    assert_true(bytes_equal(a, same));
    document_bytes filled = bytes_computed(b, "b.stl", NULL, &summary);
    assert_memory_equal(filled.data + 84, wanted[0], 12);
    assert_int_equal(summary.filled, 1);
    bytes_free(&a);
    bytes_free(&b);
    bytes_free(&same);
    bytes_free(&filled);
}

static void test_mirror_in_binary(void **state) {
    (void)state;
    document_bytes in = binary_file("", facets, 2, ""),
                   out = bytes_transformed(in, "a.stl", mirror_x, NULL);
    const float expected[12] = {0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1};
    float got[12];
    memcpy(got, out.data + 134, 48);
    for (int i = 0; i < 12; ++i) assert_true(got[i] == expected[i]);
    memcpy(got, out.data + 84, 12);
    for (int i = 0; i < 3; ++i) assert_true(got[i] == 0); /* a zero normal stays one */
    assert_memory_equal(in.data + 132, out.data + 132, 2);
    bytes_free(&in);
    bytes_free(&out);
}

/* The identity changes nothing; numbers beyond floats a binary file cannot hold, and a text does
 * not get. */
static void test_identity_and_beyond(void **state) {
    static const double same[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                        large[16] = {1, 0, 0, 0, 0, 3e38, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    unsigned char file[184] = "binary";
    const float values[2][12] = {
        {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 2, 0}};
    (void)state;
    file[80] = 2;
    for (int i = 0; i < 2; ++i) memcpy(file + 84 + 50 * i, values[i], 48);
    document_bytes files[2] = {bytes_copy(file, sizeof file),
        text_file("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
                  "0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 "
                  "0\nvertex 0 2 0\nendloop\nendfacet\nendsolid a\n")};
    for (int i = 0; i < 2; ++i) {
        norma_transform_summary summary;
        norma_transform_options options = {.struct_size = sizeof options};
        norma_document_error error;
        document_bytes out = bytes_transformed(files[i], "a.stl", same, &summary);
        assert_true(bytes_equal(out, files[i]) && !summary.changed && summary.vertices == 6);
        norma_document *document = bytes_open(files[i], "a.stl");
        memcpy(options.matrix, large, sizeof large);
        assert_int_equal(norma_document_transform(document, &options, NULL, &error),
            NORMA_DOCUMENT_ERROR_UNSUPPORTED);
        assert_string_equal(error.message, "a.stl:facet 1: the matrix moves it beyond 3.4e+38, the "
                                           "largest number that the file can hold");
        norma_document_close(document);
        bytes_free(&out);
        bytes_free(&files[i]);
    }
}

static void test_changes_follow_one_another(void **state) {
    (void)state;
    document_bytes in = binary_file("", facets, 3, "");
    norma_document *document = bytes_open(in, "a.stl");
    norma_transform_options transform = {.struct_size = sizeof transform};
    memcpy(transform.matrix, mirror_x, sizeof mirror_x);
    norma_mesh_data data;
    norma_compute_summary summary;
    assert_int_equal(norma_document_transform(document, &transform, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_compute(document, NULL, &summary, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_null(data.mesh.corners);
    assert_int_equal(data.mesh.corner_count, 9);
    const float *normals = data.normals.data;
    assert_direction(normals, 0, 0, 1, 0);
    assert_direction(normals + 3, 0, 1, 0, 0);
    assert_direction(normals + 6, -1, 0, 0, 0);
    norma_document_close(document);
    bytes_free(&in);
}

/* ---- refusals */

static void test_smooth_shading_is_refused(void **state) {
    (void)state;
    document_bytes in = binary_file("", facets, 2, "");
    const norma_shading shadings[] = {NORMA_SHADING_SMOOTH, NORMA_SHADING_CREASE};
    for (int i = 0; i < 2; ++i) {
        norma_document *document = bytes_open(in, "a.stl");
        const norma_compute_options options = {
            .struct_size = sizeof options, .shading = shadings[i], .crease_angle_rad = 1};
        norma_document_error error;
        assert_int_equal(norma_document_compute(document, &options, NULL, &error),
            NORMA_DOCUMENT_ERROR_ARGUMENT);
        assert_non_null(strstr(error.message, "one normal for each facet"));
        norma_document_close(document);
    }
    bytes_free(&in);
}

static void test_refusals_name_the_place(void **state) {
    (void)state;
    static const struct {
        const char *text, *says;
    } files[] = {{"", "a.stl:byte 0: the file is empty"},
        {"nothing of the kind", "a.stl:byte 0: not an STL file"},
        {"solid a\nfacet normal 0 0\nouter loop\n",
            "a.stl:3: \"outer\" stands in facet 0 in place of a number"},
        {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 "
         "0\nvertex 0 0 0\nendloop\n",
            "a.stl:7: \"vertex\" stands in facet 0 in place of endloop"},
        {"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0",
            "a.stl:4: the file ends in facet 0"},
        {"solid a\nendsolid\nfacet", "a.stl:3: \"facet\" stands in facet 0 in place of solid"},
        {"solid a\rfacet\rabnormal", "a.stl:3: "}};
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        char message[1000];
        document_bytes in = text_file(files[i].text);
        assert_int_equal(bytes_try(in, "a.stl", NULL, message), NORMA_DOCUMENT_ERROR_MALFORMED);
        if (!strstr(message, files[i].says))
            fail_msg("\"%s\" does not say \"%s\"", message, files[i].says);
        bytes_free(&in);
    }
    document_bytes many = binary_file("", facets, 4, "");
    many.data[83] = 0x7f;
    assert_int_equal(bytes_try(many, "a.stl", NULL, NULL), NORMA_DOCUMENT_ERROR_MALFORMED);
    bytes_free(&many);
}

/* ---- the data set */

/* The words after "facet normal" become one space each. */
static document_bytes without_normals(document_bytes bytes) {
    document_bytes out = bytes_copy(bytes.data, bytes.size);
    out.size = 0;
    for (size_t at = 0; at < bytes.size;) {
        if (bytes.size - at < 6 || strncmp((const char *)bytes.data + at, "normal", 6) != 0) {
            out.data[out.size++] = bytes.data[at++];
            continue;
        }
        at += 6;
        for (int word = 0; word < 3; ++word) {
            while (isspace(bytes.data[at])) out.data[out.size++] = bytes.data[at++];
            while (!isspace(bytes.data[at])) ++at;
        }
    }
    return out;
}

static void blank_binary(document_bytes bytes) {
    uint32_t count;
    memcpy(&count, bytes.data + 80, 4);
    for (size_t i = 0; i < count; ++i) memset(bytes.data + 84 + 50 * i, 0, 12);
}

static int rewritten;

static void rewrite(const char *path, const char *name, const char *expect) {
    if (strcmp(expect, "reject") == 0) return;
    document_bytes in = bytes_load(path);
    norma_document *document = bytes_open(in, name);
    document_bytes same = bytes_of(document);
    norma_document_close(document);
    assert_true(bytes_equal(in, same));
    norma_compute_summary summary;
    document_bytes once = bytes_computed(in, name, NULL, &summary), twice;
    assert_int_equal(summary.changed, !bytes_equal(in, once));
    twice = bytes_computed(once, name, NULL, &summary);
    assert_int_equal(summary.changed, 0);
    assert_true(bytes_equal(once, twice));
    if (in.size >= 84 && memchr(in.data, 0, 84)) {
        blank_binary(in);
        blank_binary(once);
        assert_true(bytes_equal(in, once));
    } else {
        document_bytes a = without_normals(in), b = without_normals(once);
        assert_true(bytes_equal(a, b));
        bytes_free(&a);
        bytes_free(&b);
    }
    bytes_free(&in);
    bytes_free(&same);
    bytes_free(&once);
    bytes_free(&twice);
    ++rewritten;
}

static void test_every_file_is_rewritten(void **state) {
    (void)state;
    if (data_for_each_format("stl", rewrite) == 0) skip();
    print_message("%d STL files rewritten\n", rewritten);
    assert_true(rewritten >= 12);
}

static int wrong;

static void try_bad(const char *path, const char *name, const char *expect) {
    char message[1000];
    norma_mesh_info info = {0};
    if (strncmp(name, "bad/", 4) != 0) return;
    document_bytes in = bytes_load(path);
    const norma_document_result result = bytes_try(in, name, &info, message);
    const char *place = strstr(message, name);
    place = place ? place + strlen(name) : NULL;
    const int names_place = place && place[0] == ':' &&
                            (strncmp(place, ":byte ", 6) == 0 || isdigit((unsigned char)place[1]));
    const int ok = result ? names_place
                          : strcmp(expect, "reject") != 0 &&
                                (strcmp(expect, "reject-or-empty") != 0 || info.faces == 0);
    if (!ok) print_error("%s (%s): %d %s\n", name, expect, (int)result, message);
    wrong += !ok;
    bytes_free(&in);
}

static void test_bad_files(void **state) {
    (void)state;
    if (data_for_each_format("stl", try_bad) == 0) skip();
    assert_int_equal(wrong, 0);
}

static document_bytes data_file(const char *name) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", data_folder(), name);
    return bytes_load(path);
}

/* Boxes whose normals are the axes, text and binary; and those of CAD, whose slivers have stored
 * normals that are up to half a degree off the exact ones (by rational arithmetic; 91 of 35520 by
 * more than .01 in the first). */
static void test_truth(void **state) {
    (void)state;
    if (!data_folder()) skip();
    static const struct {
        const char *name;
        double tolerance;
    } files[] = {{"truth/box-ascii.stl", 0}, {"truth/box-binary.stl", 0},
        {"large/cad/a_drive_frame_lower.stl", .6}, {"large/cad/exhaust_filter_housing.stl", .6}};
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        document_bytes in = data_file(files[i].name),
                       out = bytes_computed(in, files[i].name, NULL, NULL);
        norma_document *before = bytes_open(in, files[i].name),
                       *after = bytes_open(out, files[i].name);
        norma_mesh_data a, b;
        assert_int_equal(norma_document_mesh_data(before, 0, &a, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(norma_document_mesh_data(after, 0, &b, NULL), NORMA_DOCUMENT_OK);
        double worst = 0;
        for (size_t f = 0; f < a.normals.count; ++f) {
            const float *stored = (const float *)a.normals.data + 3 * f;
            worst = fmax(worst, degrees_to((const float *)b.normals.data + 3 * f, (double)stored[0],
                                    (double)stored[1], (double)stored[2]));
        }
        print_message("%s: at most %.6f degrees off its stored normals\n", files[i].name, worst);
        if (worst > files[i].tolerance) fail_msg("beyond %g", files[i].tolerance);
        norma_document_close(before);
        norma_document_close(after);
        bytes_free(&in);
        bytes_free(&out);
    }
}

static void damage(const char *path, const char *name, const char *expect) {
    (void)expect;
    document_bytes in = bytes_load(path);
    for (size_t at = 0; at < in.size && in.size < 2500; ++at) {
        document_bytes part = bytes_copy(in.data, at), changed = bytes_copy(in.data, in.size);
        bytes_try(part, name, NULL, NULL);
        changed.data[at] = (unsigned char)(changed.data[at] ^ (1u << at % 8));
        norma_document *document = NULL;
        if (!norma_document_open_memory(changed.data, changed.size, name, NULL, &document, NULL) &&
            !norma_document_compute(document, NULL, NULL, NULL)) {
            document_bytes out = bytes_of(document);
            bytes_free(&out);
        }
        norma_document_close(document);
        bytes_free(&part);
        bytes_free(&changed);
    }
    bytes_free(&in);
}

static void test_damage(void **state) {
    (void)state;
    if (data_for_each_format("stl", damage) == 0) skip();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_text_keeps_all_but_the_normals),
        cmocka_unit_test(test_the_name_is_utf_8),
        cmocka_unit_test(test_mirror_in_text),
        cmocka_unit_test(test_comments_stay),
        cmocka_unit_test(test_far_coordinates_in_text),
        cmocka_unit_test(test_binary_that_begins_with_solid),
        cmocka_unit_test(test_only_missing_and_broken),
        cmocka_unit_test(test_many_facets),
        cmocka_unit_test(test_signs_of_zeros_and_no_direction),
        cmocka_unit_test(test_mirror_in_binary),
        cmocka_unit_test(test_identity_and_beyond),
        cmocka_unit_test(test_changes_follow_one_another),
        cmocka_unit_test(test_smooth_shading_is_refused),
        cmocka_unit_test(test_refusals_name_the_place),
        cmocka_unit_test(test_every_file_is_rewritten),
        cmocka_unit_test(test_bad_files),
        cmocka_unit_test(test_truth),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests_name("stl", tests, NULL, NULL);
}
