/* test_text_errors.c: PLY, STL and OBJ files that are not what they should be, each a few bytes:
 * what is said of them, word for word, and where. Each is read whole, where the error must be that
 * of the table, and as a summary, which may see less but must not see anything else. */
#include "check.h"
#include "document_bytes.h"

typedef struct bad_file {
    const char *bytes;
    size_t size; /* 0: up to its final zero */
    norma_document_result result;
    const char *message; /* after the file's name */
} bad_file;

#define MALFORMED   NORMA_DOCUMENT_ERROR_MALFORMED
#define UNSUPPORTED NORMA_DOCUMENT_ERROR_UNSUPPORTED
#define BYTES(text) text, sizeof(text) - 1

static norma_document_result try_reading(const bad_file *file, const char *name,
    norma_document_depth depth, norma_document_error *error) {
    const norma_document_options options = {.struct_size = sizeof options, .depth = depth};
    const size_t size = file->size ? file->size : strlen(file->bytes);
    document_bytes bytes = bytes_copy(
        file->bytes, size); /* no byte more than it is said to have, for the sanitizer to see */
    norma_document *document = NULL;
    norma_document_result result =
        norma_document_open_memory(bytes.data, size, name, &options, &document, error);
    if (result)
        assert_null(document);
    else
        assert_non_null(document);
    norma_document_close(document);
    bytes_free(&bytes);
    return result;
}

static void expect_refused(const bad_file *files, size_t count, const char *name) {
    size_t wrong = 0;
    for (size_t i = 0; i < count; ++i) {
        char expected[1000];
        norma_document_error whole = {0}, summary = {0};
        snprintf(expected, sizeof expected, "%s:%s", name, files[i].message);
        norma_document_result result = try_reading(&files[i], name, NORMA_DOCUMENT_WHOLE, &whole),
                              brief =
                                  try_reading(&files[i], name, NORMA_DOCUMENT_SUMMARY, &summary);
        if (result != files[i].result || strcmp(whole.message, expected) != 0) {
            print_error("file %zu: result %d, \"%s\"\n   expected %d, \"%s\"\n", i, (int)result,
                result ? whole.message : "", (int)files[i].result, expected);
            ++wrong;
        } else if (brief && (brief != result || strcmp(summary.message, whole.message) != 0)) {
            print_error("file %zu, as a summary: \"%s\"\n", i, summary.message);
            ++wrong;
        }
    }
    assert_int_equal(wrong, 0);
}

/* ---- PLY */

#define XYZ        "property float x\nproperty float y\nproperty float z\n"
#define LONG_NAME  "things_whose_name_is_longer_than_what_a_message_has_room_for" /* 60 bytes */
#define TEXT       "ply\nformat ascii 1.0\n"
#define LITTLE     "ply\nformat binary_little_endian 1.0\n"
#define FACES      "element face 1\nproperty list uchar int vertex_indices\n"
#define NINE       "0 0 0\n1 0 0\n0 1 0\n"
#define BINARY_XYZ "property uchar x\nproperty uchar y\nproperty uchar z\n"

static void test_ply_headers(void **state) {
    static const bad_file files[] = {
        {"pl", 0, MALFORMED, "1: not a PLY file; a PLY file begins with the line \"ply\""},
        {"plyx\nformat ascii 1.0\n", 0, MALFORMED,
            "1: not a PLY file; a PLY file begins with the line \"ply\""},
        {"ply it\nformat ascii 1.0\n", 0, MALFORMED,
            "1: \"ply it\": the first line should be \"ply\" alone"},
        {"ply\n", 0, MALFORMED, "1: the file ends within the header, before \"end_header\""},
        {TEXT "element vertex 1\n", 0, MALFORMED,
            "3: the file ends within the header, before \"end_header\""},
        {"ply\nformat ascii\nend_header\n", 0, MALFORMED,
            "2: \"format ascii\": this line should be \"format\", an encoding and \"1.0\""},
        {"ply\nformat ascii 1.1\nend_header\n", 0, MALFORMED,
            "2: \"format ascii 1.1\": this line should be \"format\", an encoding and \"1.0\""},
        {"ply\nformat binary 1.0\nend_header\n", 0, MALFORMED,
            "2: \"binary\": this encoding is not known; PLY has ascii, binary_little_endian and "
            "binary_big_endian"},
        {"ply\nelement vertex 1\n" XYZ "end_header\n", 0, MALFORMED,
            "2: \"element vertex 1\": this line should be \"format\", an encoding and \"1.0\""},
        {TEXT "element vertex\nend_header\n", 0, MALFORMED,
            "3: \"element vertex\": this line should be \"element\", a name and a count"},
        {TEXT "element vertex 1 2\nend_header\n", 0, MALFORMED,
            "3: \"element vertex 1 2\": this line should be \"element\", a name and a count"},
        {TEXT "element vertex -1\nend_header\n", 0, MALFORMED,
            "3: \"-1\": this should be the number of rows"},
        {TEXT "element vertex 1.5\nend_header\n", 0, MALFORMED,
            "3: \"1.5\": this should be the number of rows"},
        {TEXT "element vertex 9223372036854775808\nend_header\n", 0, MALFORMED,
            "3: \"9223372036854775808\": this should be the number of rows"},
        {TEXT "property float x\nend_header\n", 0, MALFORMED,
            "3: \"property float x\": a property before the first element"},
        {TEXT "element vertex 1\nproperty float\nend_header\n", 0, MALFORMED,
            "4: \"property float\": this line should be \"property\", a type and a name"},
        {TEXT "element vertex 1\nproperty half x\nend_header\n", 0, MALFORMED,
            "4: \"half\": this type is not known; PLY has char, uchar, short, ushort, int, uint, "
            "float, double and int8 to float64"},
        {TEXT "element face 1\nproperty list int vertex_indices\nend_header\n", 0, MALFORMED,
            "4: \"property list int vertex_indices\": this line should be \"property list\", the "
            "types of count and items, and a name"},
        {TEXT "element face 1\nproperty list int list vertex_indices\nend_header\n", 0, MALFORMED,
            "4: \"list\": this type is not known; PLY has char, uchar, short, ushort, int, uint, "
            "float, double and int8 to float64"},
        {TEXT "element face 1\nproperty list float int vertex_indices\nend_header\n", 0, MALFORMED,
            "4: \"float\": the count of a list should have an integer type"},
        {TEXT "element face 1\nproperty list many int vertex_indices\nend_header\n", 0, MALFORMED,
            "4: \"many\": the count of a list should have an integer type"},
        {TEXT "element vertex 1\n" XYZ "material 3\nend_header\n", 0, MALFORMED,
            "7: \"material 3\": this line should begin with element, property, comment, obj_info "
            "or end_header"},
        {TEXT "element vertex 1\n" XYZ "format ascii 1.0\nend_header\n", 0, MALFORMED,
            "7: \"format ascii 1.0\": this line should begin with element, property, comment, "
            "obj_info or end_header"},
        {TEXT "element vertex 1\n" XYZ "end_header now\n", 0, MALFORMED,
            "7: \"end_header now\": this line should begin with element, property, comment, "
            "obj_info or end_header"},
        {TEXT FACES "end_header\n", 0, MALFORMED, "5: the header declares no element \"vertex\""},
        {TEXT "element vertex 1\nproperty float x\nproperty float y\nend_header\n", 0, MALFORMED,
            "3: \"vertex\": the element needs the properties x, y and z"},
        {TEXT "element vertex 1\n" XYZ "property float nx\nend_header\n", 0, MALFORMED,
            "3: \"vertex\": the element should have all of nx, ny and nz, or none of them"},
        {TEXT "element vertex 1\n" XYZ "element vertex 2\nend_header\n", 0, MALFORMED,
            "7: \"vertex\": the element appears twice in this header"},
        {TEXT "element vertex 1\n" XYZ FACES FACES "end_header\n", 0, MALFORMED,
            "9: \"face\": the element appears twice in this header"},
        {TEXT "element vertex 1\n" XYZ "property float y\nend_header\n", 0, MALFORMED,
            "7: \"y\": the property appears twice in this element"},
        {TEXT "element vertex 1\nproperty float x\nproperty list uchar float y\nproperty float "
              "z\nend_header\n",
            0, MALFORMED, "5: \"y\": this is a list, but should be a single number"},
        {TEXT "element vertex 1\n" XYZ "element face 1\nproperty int vertex_indices\nend_header\n",
            0, MALFORMED, "8: \"vertex_indices\": this should be a list of integers"},
        {TEXT "element vertex 1\n" XYZ
              "element face 1\nproperty list uchar double vertex_index\nend_header\n",
            0, MALFORMED, "8: \"vertex_index\": this should be a list of integers"},
        {TEXT "element vertex 1\n" XYZ
              "element tristrips 1\nproperty list int float vertex_indices\nend_header\n",
            0, MALFORMED, "8: \"vertex_indices\": this should be a list of integers"},
        {"ply\rformat ascii 1.0\relement vertex 1\rproperty float\r", 0, MALFORMED,
            "4: \"property float\": this line should be \"property\", a type and a name"},
        {"ply\r\nformat ascii 1.0\r\nelement vertex 1\r\nproperty\r\n", 0, MALFORMED,
            "4: \"property\": this line should be \"property\", a type and a name"},
    };
    (void)state;
    expect_refused(files, COUNT_OF(files), "a.ply");
}

static void test_ply_text_rows(void **state) {
    static const bad_file files[] = {
        {TEXT "element vertex 3\n" XYZ "end_header\n0.5 0 0\n1 0 0\n0 1\n", 0, MALFORMED,
            "11: row 2 of element \"vertex\": the file ends before the row does"},
        {TEXT "element vertex 1000000000000\n" XYZ "end_header\n" NINE, 0, MALFORMED,
            "11: row 0 of element \"vertex\": the file is too short for the rows that the header "
            "declares"},
        {TEXT "element vertex 1\n" XYZ "element " LONG_NAME
              "s 1\nproperty int a\nproperty int b\nend_header\n0 0 0\n10\n",
            0, MALFORMED,
            "13: row 0 of element \"" LONG_NAME "\": the file ends before the row does"},
        {TEXT "element vertex 1\n" XYZ "end_header\n0 zero 0\n", 0, MALFORMED,
            "8: row 0 of element \"vertex\": this is not a number of the property's type"},
        {TEXT "element vertex 2\n" XYZ "end_header\n0 0 0\n0 0 1e\n", 0, MALFORMED,
            "9: row 1 of element \"vertex\": this is not a number of the property's type"},
        {TEXT "element vertex 3\n" XYZ FACES "end_header\n" NINE "3 0 1 3\n", 0, MALFORMED,
            "13: face 0 names vertex 3; vertices are numbered from 0 to 2"},
        {TEXT "element vertex 3\n" XYZ FACES "end_header\n" NINE "3 0 1 -1\n", 0, MALFORMED,
            "13: face 0 names vertex -1; vertices are numbered from 0 to 2"},
        {TEXT "element vertex 3\n" XYZ FACES "end_header\n" NINE "3 0 1 1.5\n", 0, MALFORMED,
            "13: row 0 of element \"face\": this is not a number of the property's type"},
        {TEXT "element vertex 3\n" XYZ FACES "end_header\n" NINE "-3 0 1 2\n", 0, MALFORMED,
            "13: row 0 of element \"face\": the count of a list should be a whole number from 0 "
            "up"},
        {TEXT "element vertex 3\n" XYZ FACES "end_header\n" NINE "few 0 1 2\n", 0, MALFORMED,
            "13: row 0 of element \"face\": the count of a list should be a whole number from 0 "
            "up"},
        {TEXT "element vertex 3\n" XYZ FACES "end_header\n" NINE "4000000000 0 1 2\n", 0, MALFORMED,
            "13: row 0 of element \"face\": the list is longer than the rest of the file"},
        {TEXT "element vertex 3\n" XYZ FACES "end_header\n" NINE "4 0 1 2\n", 0, MALFORMED,
            "14: row 0 of element \"face\": the file ends before the row does"},
        {TEXT "element vertex 3\n" XYZ
              "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" NINE
              "3 0 1 5\n",
            0, MALFORMED, "13: strip 0 names vertex 5; vertices are numbered from 0 to 2"},
        {TEXT "element vertex 3\n" XYZ
              "element tristrips 1\nproperty list int int vertex_indices\nend_header\n" NINE
              "3 0 -2 1\n",
            0, MALFORMED, "13: strip 0 names vertex -2; vertices are numbered from 0 to 2"},
        {TEXT "element vertex 1\n" XYZ
              "property float nx\nproperty float ny\nproperty float nz\nend_header\n0 0 0 0 up 0\n",
            0, MALFORMED,
            "11: row 0 of element \"vertex\": this is not a number of the property's type"},
        {TEXT "element vertex 3\n" XYZ FACES
              "property float nx\nproperty float ny\nproperty float nz\nend_header\n" NINE
              "3 0 1 2 0 0 up\n",
            0, MALFORMED,
            "16: row 0 of element \"face\": this is not a number of the property's type"},
        {"ply\rformat ascii 1.0\relement vertex 1\rproperty float x\rproperty float y\rproperty "
         "float z\rend_header\r0 zero 0\r",
            0, MALFORMED,
            "8: row 0 of element \"vertex\": this is not a number of the property's type"},
    };
    (void)state;
    expect_refused(files, COUNT_OF(files), "a.ply");
}

/* Three vertices of a byte an axis; places are counted from the lengths of the lines above. */
static void test_ply_binary_rows(void **state) {
#define HEAD          LITTLE "element vertex 3\n" BINARY_XYZ
#define MARK_VERTICES "\0\0\0\1\0\0\0\1\0"
    static const bad_file files[] = {
        {BYTES(HEAD "end_header\n\0\0\0\1\0"), MALFORMED,
            "byte 120: the file ends in row 1 of element \"vertex\", which should have 3 rows"},
        {BYTES(LITTLE "element vertex 9223372036854775807\n" BINARY_XYZ "end_header\n\0\0\0"),
            MALFORMED,
            "byte 136: the file ends in row 1 of element \"vertex\", which should have "
            "9223372036854775807 rows"},
        {BYTES(HEAD FACES "end_header\n" MARK_VERTICES "\3\0\0\0"), MALFORMED,
            "byte 182: the file ends in row 0 of element \"face\", which should have 1 rows"},
        {BYTES(HEAD
             "element face 2\nproperty list uchar uchar vertex_indices\nend_header\n" MARK_VERTICES
             "\3\0\1\2"),
            MALFORMED,
            "byte 184: the file ends in row 1 of element \"face\", which should have 2 rows"},
        {BYTES(HEAD
             "element face 1\nproperty list char uchar vertex_indices\nend_header\n" MARK_VERTICES
             "\xff\0\1\2"),
            MALFORMED, "byte 179: a list of negative length"},
        {BYTES(HEAD
             "element face 1\nproperty list int uchar vertex_indices\nend_header\n" MARK_VERTICES
             "\xff\xff\xff\x7f\0\1\2"),
            MALFORMED,
            "byte 185: the file ends in row 0 of element \"face\", which should have 1 rows"},
        {BYTES(HEAD "element face 1\nproperty uchar kind\nproperty list uchar uchar "
                    "vertex_indices\nproperty uchar end\nend_header\n" MARK_VERTICES "\7\3\0\1\2"),
            MALFORMED,
            "byte 224: the file ends in row 0 of element \"face\", which should have 1 rows"},
        {BYTES(HEAD FACES "end_header\n" MARK_VERTICES "\3\0\0\0\0\1\0\0\0\3\0\0\0"), MALFORMED,
            "byte 178: face 0 names vertex 3; vertices are numbered from 0 to 2"},
        {BYTES(HEAD FACES "end_header\n" MARK_VERTICES "\3\0\0\0\0\1\0\0\0\xff\xff\xff\xff"),
            MALFORMED, "byte 178: face 0 names vertex -1; vertices are numbered from 0 to 2"},
        {BYTES(HEAD
             "element face 1\nproperty list uchar uint vertex_indices\nend_header\n" MARK_VERTICES
             "\3\0\0\0\0\1\0\0\0\xff\xff\xff\xff"),
            MALFORMED,
            "byte 179: face 0 names vertex 4294967295; vertices are numbered from 0 to 2"},
        {BYTES(HEAD
             "element face 2\nproperty list uchar uchar vertex_indices\nend_header\n" MARK_VERTICES
             "\3\0\1\2\4\0\1\2\11"),
            MALFORMED, "byte 184: face 1 names vertex 9; vertices are numbered from 0 to 2"},
        {BYTES(HEAD
             "element face 1\nproperty list ushort short vertex_indices\nend_header\n" MARK_VERTICES
             "\3\0\0\0\1\0\xfe\xff"),
            MALFORMED, "byte 181: face 0 names vertex -2; vertices are numbered from 0 to 2"},
        {BYTES(HEAD "element tristrips 1\nproperty list uchar char "
                    "vertex_indices\nend_header\n" MARK_VERTICES "\3\0\xff\3"),
            MALFORMED, "byte 184: strip 0 names vertex 3; vertices are numbered from 0 to 2"},
    };
    (void)state;
    expect_refused(files, COUNT_OF(files), "a.ply");
}

static const char *noted(const char *bytes, size_t size, const char *name, size_t *count) {
    static char note[1000];
    document_bytes copy = bytes_copy(bytes, size);
    norma_document *document = bytes_open(copy, name);
    *count = norma_document_note_count(document);
    snprintf(note, sizeof note, "%s", *count ? norma_document_note(document, 0) : "");
    document_bytes out = bytes_of(document);
    assert_true(bytes_equal(copy, out)); /* kept as they are */
    bytes_free(&out);
    norma_document_close(document);
    bytes_free(&copy);
    return note;
}

/* What is odd, but no error: read, said, and kept. */
static void test_oddities_are_noted(void **state) {
    static const struct {
        const char *name, *bytes;
        size_t size;
        const char *note;
    } files[] = {
        {"a.ply",
            BYTES("ply\nformat ascii 1.0\nCreated by hand\nelement vertex 1\n" XYZ
                  "end_header\n0 0 0\n"),
            "header line 3 is not a PLY statement and was ignored: \"Created by hand\""},
        {"a.ply", BYTES(TEXT "element vertex 1\n" XYZ "end_header\n0 0 0\nmore of it\n"),
            "bytes after the last element, kept as they are: 11"},
        {"a.ply", BYTES(TEXT "element vertex 1\n" XYZ "end_header\n0 0 0\n \n"), ""},
        {"a.ply", BYTES(HEAD "end_header\n" MARK_VERTICES "abc"),
            "bytes after the last element, kept as they are: 3"},
        {"a.stl",
            BYTES("solid a\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 "
                  "endloop endfacet\n"),
            "the last solid has no \"endsolid\"; the file may have been cut off"},
        {"a.obj", BYTES("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nwidget 7\nwidget 8\n"),
            "2 statements of kinds that OBJ does not have are kept as they are, the first "
            "\"widget\" in line 5"},
        {"a.obj", BYTES("v 0 0 0\nv 1 0 0\nv 0 1 0\nf\nf 1 2 3\n"),
            "1 faces without a corner are kept as they are, the first \"f\" in line 4"},
        {"a.obj", BYTES("v 0 0 0\nv 1 0 0\nv 0 1.5+e2 0\nf 1 2 3\n"),
            "1 numbers are followed by other characters, which are ignored, the first \"1.5+e2\" "
            "in line 3"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        size_t count;
        assert_string_equal(
            noted(files[i].bytes, files[i].size, files[i].name, &count), files[i].note);
        assert_int_equal(count, files[i].note[0] != 0);
    }
}

static void test_a_binary_stl_may_go_on(void **state) {
    unsigned char file[84 + 50 + 3] = "header";
    const float facet[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    size_t count;
    (void)state;
    file[80] = 1;
    memcpy(file + 84, facet, sizeof facet);
    memcpy(file + 134, "end", 3);
    assert_string_equal(noted((const char *)file, sizeof file, "a.stl", &count),
        "3 bytes after the last of the 1 facets declared are kept as they are");
    assert_int_equal(count, 1);
}

/* ---- STL */

#define FACET                                                                                      \
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "                      \
    "0\nendloop\nendfacet\n"

static void test_stl(void **state) {
    static const bad_file files[] = {
        {"sol", 0, MALFORMED,
            "byte 0: not an STL file; an STL file begins with \"solid\" or with a binary header of "
            "84 bytes"},
        {"facet normal 0 0 1", 0, MALFORMED,
            "byte 0: not an STL file; an STL file begins with \"solid\" or with a binary header of "
            "84 bytes"},
        {"solid a\nvertex 0 0 0\n", 0, MALFORMED,
            "2: \"vertex\" stands in facet 0 in place of facet or endsolid"},
        {"solid a\nfacet\n0 0 1\n", 0, MALFORMED, "3: \"0\" stands in facet 0 in place of normal"},
        {"solid a\nfacet normal 0 0 one\n", 0, MALFORMED,
            "2: \"one\" stands in facet 0 in place of a number"},
        {"solid a\nfacet normal 0 0", 0, MALFORMED, "2: the file ends in facet 0, before a number"},
        {"solid a\n" FACET "facet normal 0 0 1 inner", 0, MALFORMED,
            "9: \"inner\" stands in facet 1 in place of outer"},
        {"solid a\n" FACET "facet normal 0 0 1 outer loops", 0, MALFORMED,
            "9: \"loops\" stands in facet 1 in place of loop"},
        {"solid a\n" FACET "facet normal 0 0 1 outer loo", 0, MALFORMED,
            "9: \"loo\" stands in facet 1 in place of loop"},
        {"solid a\nfacet normal 0 0 1 outer loop\nvertex 0 0 0\nvertex 0 1 0\nendloop\n", 0,
            MALFORMED, "5: \"endloop\" stands in facet 0 in place of vertex"},
        {"solid a\nfacet normal 0 0 1 outer loop\nvertex 0 0 0 vertex 0 1 0\nvertex 1 0 0x\n", 0,
            MALFORMED, "4: \"0x\" stands in facet 0 in place of a number"},
        {"solid a\nfacet normal 0 0 1 outer loop\nvertex 0 0 0 vertex 0 1 0 vertex 1 1 0 vertex 0 "
         "1 0",
            0, MALFORMED, "3: \"vertex\" stands in facet 0 in place of endloop"},
        {"solid a\nfacet normal 0 0 1 outer loop\nvertex 0 0 0 vertex 0 1 0 vertex 1 1 0 endloop",
            0, MALFORMED, "3: the file ends in facet 0, before endfacet"},
        {"solid a\nendsolid a\nsolids", 0, MALFORMED,
            "3: \"solids\" stands in facet 0 in place of solid"},
        {"solid a\rfacet\r0 0 1\r", 0, MALFORMED, "3: \"0\" stands in facet 0 in place of normal"},
    };
    (void)state;
    expect_refused(files, COUNT_OF(files), "a.stl");
}

static void test_binary_stl(void **state) {
    static const bad_file files[] = {
        {BYTES("0123456789012345678901234567890123456789012345678901234567890123456789012345678\n"
               "\377\377\377\377"),
            MALFORMED, "byte 80: the header declares 4294967295 facets, but the file holds only 0"},
        {BYTES("solid but with "
               "zeros\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
               "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\1\0\0\0tail"),
            MALFORMED, "byte 80: the header declares 1 facets, but the file holds only 0"},
    };
    (void)state;
    expect_refused(files, COUNT_OF(files), "a.stl");
}

/* ---- OBJ */

#define TRIANGLE "v 0 0 0\nv 1 0 0\nv 0 1 0\n"

static void test_obj(void **state) {
    static const bad_file files[] = {
        {BYTES("\xff\xfev\0 \0"), UNSUPPORTED,
            " UTF-16 text; expected ASCII or UTF-8 (convert it first)"},
        {BYTES("v\0 \0001\0"), UNSUPPORTED,
            " UTF-16 text; expected ASCII or UTF-8 (convert it first)"},
        {"v 0 0\nv 1 0 0\n", 0, MALFORMED,
            "1: the statement ends where one of a position's three numbers was expected"},
        {"v 0 0 0\nv 1 none 0\n", 0, MALFORMED,
            "2: \"none\" where one of a position's three numbers was expected"},
        {"v 0 0 0\nv 1,5 2 0\n", 0, MALFORMED,
            "2: \"1,5\" where one of a position's three numbers was expected"},
        {TRIANGLE "vn 0 0\nf 1 2 3\n", 0, MALFORMED,
            "4: the statement ends where one of a normal's three numbers was expected"},
        {TRIANGLE "f 1 2\n", 0, MALFORMED,
            "4: a face of 2 corners, where at least three were expected"},
        {TRIANGLE "f 1 # one\n", 0, MALFORMED,
            "4: a face of 1 corners, where at least three were expected"},
        {TRIANGLE "f 1 2 x\n", 0, MALFORMED,
            "4: \"x\" where a corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {TRIANGLE "f 1 2 3/x\n", 0, MALFORMED,
            "4: \"3/x\" where a corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {TRIANGLE "f 1 2 3///\n", 0, MALFORMED,
            "4: \"3///\" where a corner (v, v/vt, v//vn or v/vt/vn) was expected"},
        {TRIANGLE "f 1 2 0\n", 0, MALFORMED,
            "4: \"0\" where a position, numbered from 1, was expected"},
        {TRIANGLE "f 1 2 -4\n", 0, MALFORMED,
            "4: \"-4\" where a position that stands before this face was expected"},
        {TRIANGLE "f 1 2 -9223372036854775808\n", 0, MALFORMED,
            "4: \"-9223372036854775808\" where a position that stands before this face was "
            "expected"},
        {TRIANGLE "f 1 2 4\n", 0, MALFORMED,
            "4: position 4 of a face, where the file holds 3 positions"},
        {TRIANGLE "f 1 2 \\\n 4294967299\n", 0, MALFORMED,
            "5: position 4294967299 of a face, where the file holds 3 positions"},
        {"This is a letter.\nNot a mesh.\n", 0, MALFORMED,
            "1: \"This\" where an OBJ statement was expected"},
        {BYTES("v 0 0 0\n\1\2 3\n"), MALFORMED,
            "2: a byte of value 1 where a statement's text was expected"},
        {BYTES("v 0 0 0\r\nv 1 0 0\r\nv a 0 0\r\n"), MALFORMED,
            "3: \"a\" where one of a position's three numbers was expected"},
    };
    (void)state;
    expect_refused(files, COUNT_OF(files), "a.obj");
}

static void test_empty_files(void **state) {
    static const struct {
        const char *name, *message;
    } files[] = {
        {"a.ply", "a.ply:1: the file is empty; a PLY file begins with the line \"ply\""},
        {"a.stl", "a.stl:byte 0: the file is empty; an STL file begins with \"solid\" or with a "
                  "binary header of 84 bytes"},
        {"a.obj", "a.obj: the file is empty; expected OBJ statements"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        char message[1000];
        document_bytes none = bytes_copy("", 0);
        assert_int_equal(bytes_try(none, files[i].name, NULL, message), MALFORMED);
        assert_string_equal(message, files[i].message);
        bytes_free(&none);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ply_headers),
        cmocka_unit_test(test_ply_text_rows),
        cmocka_unit_test(test_ply_binary_rows),
        cmocka_unit_test(test_oddities_are_noted),
        cmocka_unit_test(test_a_binary_stl_may_go_on),
        cmocka_unit_test(test_stl),
        cmocka_unit_test(test_binary_stl),
        cmocka_unit_test(test_obj),
        cmocka_unit_test(test_empty_files),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
