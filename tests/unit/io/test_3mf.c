/* test_3mf.c: 3MF packages put together here, stored and not packed: what is read of them, what a
 * change leaves as it was, and packages that are hostile. Packed ones are judged by unzip and
 * lib3mf in tests/cli/3mf.sh. */
#include "check.h"
#include "document_bytes.h"
#include "message.h"
#include <norma/check.h>

#define TMF "http://schemas.microsoft.com/3dmanufacturing/2013/01/"
#define RELS                                                                                       \
    "<Relationships><Relationship Type=\"" TMF                                                     \
    "3dmodel\" Target=\"/3D/a.model\" Id=\"r\"/></Relationships>"
#define CORE          "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\""
#define PRODUCTION    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
#define TMF_MATERIALS "http://schemas.microsoft.com/3dmanufacturing/material/2015/02"
#define TETRA(triangles)                                                                           \
    "<mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/>"           \
    "<vertex x=\"0\" y=\"1\" z=\"0\"/><vertex x=\"0\" y=\"0\" "                                    \
    "z=\"1e0\"/></vertices><triangles>" triangles "</triangles></mesh>"
#define FACES                                                                                      \
    "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"                 \
    "<triangle v1=\"1\" v2=\"2\" v3=\"3\" pid=\"5\" p1=\"0\" p2=\"1\" p3=\"2\" />"                 \
    "<triangle v1=\"2\" v2=\"0\" v3=\"3\"></triangle>"
#define MODEL(resources, build)                                                                    \
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- kept -->\n<model unit=\"inch\" " CORE        \
    " xmlns:p=\"" PRODUCTION "\"><resources>" resources "</resources><build>" build                \
    "</build></model>\n"

typedef struct made_zip {
    unsigned char bytes[1 << 16];
    unsigned char directory[4096];
    size_t size, directory_size, count;
} made_zip;

static void put(unsigned char *to, size_t *size, size_t value, size_t width) {
    for (size_t i = 0; i < width; ++i) to[(*size)++] = (unsigned char)(value >> 8 * i);
}

/* Bit by bit, as PKWARE's APPNOTE defines it. */
static uint32_t sum_of(const char *text, size_t size) {
    uint32_t sum = UINT32_MAX;
    for (size_t i = 0; i < size; ++i) {
        sum ^= (unsigned char)text[i];
        for (int bit = 0; bit < 8; ++bit) sum = sum >> 1 ^ (sum & 1 ? 0xEDB88320U : 0);
    }
    return ~sum;
}

static void put_text(unsigned char *to, size_t *size, const char *text, size_t length) {
    memcpy(to + *size, text, length);
    *size += length;
}

static void add_member(made_zip *z, const char *name, const char *text, size_t length) {
    const size_t at = z->size, name_length = strlen(name);
    for (int central = 0; central < 2; ++central) {
        unsigned char *to = central ? z->directory : z->bytes;
        size_t *size = central ? &z->directory_size : &z->size;
        put_text(to, size, central ? "PK\1\2\24\0" : "PK\3\4", central ? 6 : 4);
        put(to, size, 20, 2);
        put(to, size, 0, 2 + 2 + 4); /* flags, method, time */
        put(to, size, sum_of(text, length), 4);
        put(to, size, length, 4);
        put(to, size, length, 4);
        put(to, size, name_length, 2);
        put(to, size, 0, 2);
        if (central) put(to, size, 0, 2 + 2 + 2);
        if (central) put(to, size, 0, 4);
        if (central) put(to, size, at, 4);
        put_text(to, size, name, name_length);
        if (!central) put_text(to, size, text, length);
    }
    ++z->count;
}

static void end_zip(made_zip *z) {
    const size_t at = z->size;
    put_text(z->bytes, &z->size, (const char *)z->directory, z->directory_size);
    put_text(z->bytes, &z->size, "PK\5\6\0\0\0\0", 8);
    put(z->bytes, &z->size, z->count, 2);
    put(z->bytes, &z->size, z->count, 2);
    put(z->bytes, &z->size, z->directory_size, 4);
    put(z->bytes, &z->size, at, 4);
    put(z->bytes, &z->size, 7, 2);
    put_text(z->bytes, &z->size, "comment", 7);
}

static document_bytes package_of(const char *model, size_t model_size, const char *rels,
    size_t rels_size, const char *model_rels) {
    made_zip *z = calloc(1, sizeof *z);
    assert_non_null(z);
    add_member(z, "_rels/.rels", rels, rels_size);
    add_member(z, "3D/a.model", model, model_size);
    if (model_rels) add_member(z, "3D/_rels/a.model.rels", model_rels, strlen(model_rels));
    add_member(z, "picture.png", "not a picture", 13);
    end_zip(z);
    const document_bytes bytes = bytes_copy(z->bytes, z->size);
    free(z);
    return bytes;
}

static document_bytes package(const char *model, const char *rels) {
    return package_of(model, strlen(model), rels, strlen(rels), NULL);
}

static void test_reads(void **state) {
    document_bytes bytes =
        package(MODEL("<object id=\"1\" name=\"tetra\">" TETRA(
                          FACES) "</object>"
                                 "<object id=\"2\"><components><component objectid=\"1\"/>"
                                 "<component objectid=\"1\" transform=\"-1 0 0 0 1 0 0 0 1 5 6 "
                                 "7\"/></components></object>",
                    "<item objectid=\"2\" transform=\"2 0 0 0 2 0 0 0 2 0 0 0\"/>"),
            RELS);
    norma_document *document = bytes_open(bytes, "a.3mf");
    norma_mesh_info info;
    norma_mesh_data data;
    norma_node_info node;
    assert_int_equal(norma_document_mesh_count(document), 1);
    assert_int_equal(norma_document_mesh_info(document, 0, &info), NORMA_DOCUMENT_OK);
    assert_string_equal(info.name, "tetra");
    assert_string_equal(info.where, "object 1");
    assert_int_equal(info.vertices, 4);
    assert_int_equal(info.faces, 4);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(((const uint32_t *)data.mesh.corners)[7], 2);
    assert_true(((const double *)data.mesh.positions.data)[11] == 1);
    assert_int_equal(norma_document_node_count(document), 2);
    assert_int_equal(norma_document_node_info(document, 1, &node), NORMA_DOCUMENT_OK);
    assert_true(node.world[0] == -2 && node.world[12] == 10 && node.world[14] == 14);
    assert_int_equal(norma_document_note_count(document), 1); /* mirrored */
    norma_document_close(document);
    bytes_free(&bytes);
    (void)state;
}

/* Reversed and dropped by hand; all other bytes of the text, and the other members, are as they
 * were. */
static void test_edits(void **state) {
    static const uint8_t reverse[] = {0, 0, 1, 1}, drop[] = {0, 1, 0, 0};
    const norma_mesh_edit edits[] = {{.reverse_faces = reverse, .drop_faces = drop}};
    document_bytes
        bytes = package(
            MODEL("<object id=\"1\">" TETRA(FACES) "</object>", "<item objectid=\"1\"/>"), RELS),
        want = package(
            MODEL("<object id=\"1\">" TETRA(
                      "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/>"
                      "<triangle v1=\"1\" v2=\"3\" v3=\"2\" pid=\"5\" p1=\"0\" p2=\"2\" "
                      "p3=\"1\" /><triangle v1=\"2\" v2=\"3\" v3=\"0\"></triangle>") "</object>",
                "<item objectid=\"1\"/>"),
            RELS);
    norma_document *document = bytes_open(bytes, "a.3mf");
    assert_int_equal(norma_document_edit(document, edits, NULL), NORMA_DOCUMENT_OK);
    document_bytes made = bytes_of(document);
    assert_true(bytes_equal(made, want));
    norma_document_error error;
    const uint8_t move[] = {1, 0, 0, 0};
    const double positions[12] = {0};
    const norma_mesh_edit moved[] = {{.set_positions = move, .positions = positions}};
    assert_int_equal(norma_document_edit(document, moved, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_int_equal(
        norma_document_compute(document, NULL, NULL, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_true(strstr(error.message, "3MF has no normals") != NULL);
    assert_int_equal(
        norma_document_tangents(document, NULL, NULL, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    norma_document_close(document);
    bytes_free(&made);
    bytes_free(&bytes);
    bytes_free(&want);
    (void)state;
}

/* b: the triangles of an object in another part. */
static document_bytes package_of_two(const char *a, const char *b) {
    char model[4000];
    made_zip *z = calloc(1, sizeof *z);
    assert_non_null(z);
    snprintf(model, sizeof model,
        MODEL("<object id=\"1\">" TETRA("%s") "</object>",
            "<item objectid=\"1\" p:path=\"/3D/B.Model\"/><item objectid=\"1\"/><item "
            "objectid=\"1\" p:path=\"/3D/b.model\"/>"),
        a);
    add_member(z, "picture.png", "not a picture", 13);
    add_member(z, "3D/a.model", model, strlen(model));
    add_member(z, "_rels/.rels", RELS, sizeof RELS - 1);
    snprintf(model, sizeof model, MODEL("<object id=\"1\">" TETRA("%s") "</object>", ""), b);
    add_member(z, "3D/b.model", model, strlen(model));
    add_member(z, "3D/last", "not a model", 11);
    end_zip(z);
    const document_bytes bytes = bytes_copy(z->bytes, z->size);
    free(z);
    return bytes;
}

/* A part is one in letters of either case (OPC, 6.2.2.3), and two of them change at once. */
static void test_two_parts(void **state) {
    static const uint8_t first[] = {1, 0}, second[] = {0, 1};
    static const char faces[] =
        "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>";
    const norma_mesh_edit edits[] = {{.drop_faces = first}, {.drop_faces = second}};
    document_bytes bytes = package_of_two(faces, faces),
                   want = package_of_two("<triangle v1=\"0\" v2=\"1\" v3=\"3\"/>",
                       "<triangle v1=\"0\" v2=\"2\" v3=\"1\"/>");
    norma_document *document = bytes_open(bytes, "a.3mf");
    assert_int_equal(norma_document_mesh_count(document), 2);
    assert_int_equal(norma_document_node_count(document), 3);
    assert_int_equal(norma_document_edit(document, edits, NULL), NORMA_DOCUMENT_OK);
    document_bytes made = bytes_of(document);
    assert_true(bytes_equal(made, want));
    norma_document_close(document);
    bytes_free(&made);
    bytes_free(&bytes);
    bytes_free(&want);
    (void)state;
}

/* The numbers in a set would mean other triangles. */
static void test_sets(void **state) {
    static const uint8_t drop[] = {0, 1, 0, 0};
    const norma_mesh_edit edits[] = {{.drop_faces = drop}};
    document_bytes bytes = package(
        MODEL("<object id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/></vertices>"
              "<triangles><triangle v1=\"0\" v2=\"0\" v3=\"0\"/><triangle v1=\"0\" v2=\"0\" "
              "v3=\"0\"/></triangles><t:trianglesets><t:triangleset><t:ref index=\"1\"/>"
              "</t:triangleset></t:trianglesets></mesh></object>",
            "<item objectid=\"1\"/>"),
        RELS);
    norma_document *document = bytes_open(bytes, "a.3mf");
    assert_int_equal(norma_document_edit(document, edits, NULL), NORMA_DOCUMENT_OK);
    document_bytes made = bytes_of(document);
    assert_true(bytes_equal(made, bytes));
    norma_document_close(document);
    bytes_free(&made);
    bytes_free(&bytes);
    (void)state;
}

static void expect_refused(document_bytes bytes, const char *expected) {
    char message[1000] = "";
    const norma_document_result result = bytes_try(bytes, "a.3mf", NULL, message);
    if (!result || !strstr(message, expected)) {
        print_error("%d \"%s\"\n  expected \"%s\"\n", (int)result, message, expected);
        fail();
    }
    bytes_free(&bytes);
}

static void test_broken_models(void **state) {
    static const struct {
        const char *model, *expected;
    } cases[] = {
        {"<model/>", "3D/a.model:1: expected <model> of the 3MF core namespace"},
        {"<model " CORE "></model>", "expected <resources> and <build>"},
        {"<model " CORE ">", "is not XML"},
        {"<!DOCTYPE a [<!ENTITY b \"c\">]><model " CORE "/>", "a document type is not allowed"},
        {"<?xml version=\"1.0\" encoding=\"iso-8859-1\"?><model " CORE "/>", "expected UTF-8"},
        {"<?xml version=\"1.0\" encoding=\"utf-8\"?>\r\n\r<m>\n<!-- -- --></m>",
            "3D/a.model:3: expected <model>"},
        {"\xEF\xBB\xBF<model " CORE ">\r\n\r<a>\n<!-- -- --></a></model>",
            "3D/a.model:4: is not XML: a comment"},
        {"<model " CORE "><a b='1' c='2' b='3'/></model>", "an attribute stands twice"},
        {"<model " CORE "><a b='<'/></model>", "an attribute without a sound value"},
        {"<model " CORE "><a>&nothing;</a></model>", "text with an & or ]]>"},
        {"<model " CORE "><a>\xC0\xAF</a></model>", "a byte that is in no character"},
        {"<model " CORE "><a></b></model>", "an element ends by another's name"},
        {MODEL("<object id=\"x\"/>", ""), "expected an object with an id"},
        {MODEL("<object name=\"&#60;&amp;\n\" id=\"&#x37;\"/><object id=\"7\"/>", ""),
            "object 7: is defined twice"},
        {MODEL("<object id=\"1\" type=\"cake\"/>", ""), "expected model, solidsupport"},
        {MODEL("<object id=\"1\"/><object id=\"1\"/>", ""), "object 1: is defined twice"},
        {MODEL("<basematerials id=\"1\"/><object id=\"1\"/>", ""),
            "object 1: has the id of another resource"},
        {MODEL("<object id=\"1\"/><m:colorgroup id=\"1\"><m:color id=\"2\"/></m:colorgroup>", ""),
            "object 1: has the id of another resource"},
        {MODEL("<basematerials id=\"2\"/><a id=\"3\"/><m:colorgroup id=\"2\"/>", ""),
            "3D/a.model: two resources have the id 2"},
        {MODEL("<object id=\"1\" pindex=\"0\"/>", ""), "expected a pid beside an object's pindex"},
        {"<model xml:lang=\"en\" xml:space=\"default\" " CORE "/>", "the attribute xml:space"},
        {"<model xmlns:i=\"http://www.w3.org/2001/XMLSchema-instance\" i:nil=\"1\" " CORE "/>",
            "the attribute i:nil is not allowed"},
        {"<model requiredextensions=\"p q\" xmlns:p=\"" PRODUCTION "\" " CORE "/>",
            "requires the extension q, a prefix that <model> does not declare"},
        {"<model unit=\"furlong\" " CORE "><resources/><build/></model>",
            "as the model's unit; found furlong"},
        {MODEL("<object id=\"1\">" TETRA("<triangle v1=\"0\" v2=\"2\" v3=\"4\"/>") "</object>", ""),
            "expected v3 of a triangle to be one of the 4 vertices"},
        {MODEL(
             "<object id=\"1\">" TETRA("<triangle v1=\"0\" v2=\"-1\" v3=\"1\"/>") "</object>", ""),
            "expected v2 of a triangle"},
        {MODEL("<object id=\"1\"><mesh><vertices><vertex x=\"nan\" y=\"0\" z=\"0\"/></vertices>"
               "</mesh></object>",
             ""),
            "expected a vertex with the numbers x, y and z"},
        {MODEL("", "<item objectid=\"3\"/>"), "build: names object 3, which is not defined"},
        {MODEL("<object id=\"1\" type=\"other\"/>", "<item objectid=\"1\"/>"), "of the type other"},
        {MODEL("", "<item objectid=\"3\" transform=\"1 2 3\"/>"), "a transform of twelve numbers"},
        {MODEL("<object id=\"1\"><components><component objectid=\"1\"/></components></object>",
             "<item objectid=\"1\"/>"),
            "object 1: names object 1, which is not defined before it"},
        {MODEL("", "<item objectid=\"3\" p:path=\"/3D/gone.model\"/>"),
            "the part 3D/gone.model is missing"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
        expect_refused(package(cases[i].model, RELS), cases[i].expected);
    (void)state;
}

/* Production is read, and materials say nothing about triangles; what else is required may. */
static void test_required(void **state) {
    document_bytes bytes =
        package("<model requiredextensions=\" m\tp b b\n\" xmlns:b=\"https://example.org/beams\" "
                "xmlns:p=\"" PRODUCTION "\" xmlns:m=\"" TMF_MATERIALS
                "\" xsi:like=\"undeclared\" " CORE "><resources/><build/></model>",
            RELS);
    norma_document *document = bytes_open(bytes, "a.3mf");
    norma_unread unread;
    assert_int_equal(norma_document_unread_count(document), 1);
    assert_int_equal(norma_document_unread(document, 0, &unread), NORMA_DOCUMENT_OK);
    assert_string_equal(unread.where, "3D/a.model");
    assert_string_equal(
        unread.why, "requires https://example.org/beams, which is unknown to this version");
    norma_document_close(document);
    bytes_free(&bytes);
    (void)state;
}

/* What the model's part names is looked for beside it, or from the root of the package. */
static void test_relationships(void **state) {
    static const struct {
        const char *type, *attributes, *expected;
    } cases[] = {{"3dtexture", "Target=\"/picture.png\"", NULL},
        {"3dtexture", "Target=\"../Picture.PNG\"", NULL}, {"3dtexture", "Target=\"a.model\"", NULL},
        {"of-another-kind", "Target=\"gone.png\"", NULL},
        {"3dtexture", "Target=\"/\303\245.png\"", NULL}, /* a member's name has %C3%A5 */
        {"3dtexture", "Target=\"picture.png\"",
            "names the part 3D/picture.png, which is not in the package"},
        {"printticket", "Target=\"/gone.xml\"", "3D/_rels/a.model.rels: names the part gone.xml"},
        {"printticket",
            "Target=\"/picture.png\"/><a/><Relationship Type=\"" TMF "printticket\" "
            "Target=\"a.model\"",
            "names 2 print tickets"},
        {"3dmodel", "Target=\"file:///etc/motd\" TargetMode=\"External\"", "it is not opened"},
        {"printticket",
            "Target=\"https://example.org/\" TargetMode=\"External\"/><Relationship Type=\"" TMF
            "printticket\" Target=\"a.model\"",
            "names 2 print tickets"}};
    const char *model = MODEL("", "");
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        char rels[500];
        snprintf(rels, sizeof rels,
            "<Relationships><Relationship Type=\"" TMF "%s\" %s/></Relationships>", cases[i].type,
            cases[i].attributes);
        document_bytes bytes = package_of(model, strlen(model), RELS, strlen(RELS), rels);
        if (cases[i].expected) /* the code is that of the reason which is given */
            assert_int_equal(bytes_try(bytes, "a.3mf", NULL, NULL),
                strstr(cases[i].expected, "not opened") ? NORMA_DOCUMENT_ERROR_REFUSED
                                                        : NORMA_DOCUMENT_ERROR_MALFORMED);
        if (cases[i].expected) expect_refused(bytes, cases[i].expected);
        if (cases[i].expected) continue;
        norma_document_close(bytes_open(bytes, "a.3mf"));
        bytes_free(&bytes);
    }
    (void)state;
}

/* Thirty objects that each draw the one before twice are a billion meshes. */
static void test_billion(void **state) {
    static char model[16000];
    size_t length = (size_t)snprintf(model, sizeof model,
        "<model " CORE "><resources><object id=\"1\">" TETRA(FACES) "</object>");
    for (int i = 2; i < 32; ++i)
        length += (size_t)snprintf(model + length, sizeof model - length,
            "<object id=\"%d\"><components><component objectid=\"%d\"/><component objectid=\"%d\"/>"
            "</components></object>",
            i, i - 1, i - 1);
    snprintf(model + length, sizeof model - length,
        "</resources><build><item objectid=\"31\"/></build></model>");
    expect_refused(package(model, RELS), "draw far more than the file has bytes");
    (void)state;
}

static void test_broken_zips(void **state) {
    document_bytes whole = package(MODEL("", ""), RELS);
    for (size_t size = 0; size < whole.size; ++size) { /* cut anywhere: refused, or all is there */
        document_bytes cut = bytes_copy(whole.data, size);
        (void)bytes_try(cut, "a.3mf", NULL, NULL);
        bytes_free(&cut);
    }
    for (size_t at = 0; at < whole.size; ++at) { /* and any byte another */
        document_bytes other = bytes_copy(whole.data, whole.size);
        other.data[at] ^= 0xFF;
        (void)bytes_try(other, "a.3mf", NULL, NULL);
        bytes_free(&other);
    }
    document_bytes harmed = bytes_copy(whole.data, whole.size);
    size_t comment = 0;
    while (memcmp(harmed.data + comment, "kept", 4) != 0) ++comment;
    harmed.data[comment] ^= 1;
    expect_refused(harmed, "the part 3D/a.model is damaged");
    expect_refused(bytes_copy("PK", 2), "is not the zip that a 3MF is: it has no directory");
    expect_refused(package(MODEL("", ""), "<Relationships/>"), "_rels/.rels: names 0 models");
    bytes_free(&whole);
    (void)state;
}

/* Either part, with the mark that begins it or without, and whatever it declares. */
static void test_encodings(void **state) {
    static const char begins[] = "<?xml version=\"1.0\" encoding=\"UTF-16\"?>";
    static const char *const found[] = {"zero bytes, as UTF-16 has them", "UTF-16"};
    const char *const texts[2] = {RELS, MODEL("", "")};
    for (int i = 0; i < 16; ++i) {
        const int is_model = i & 1, is_wide = i & 2, is_big = i & 4, has_mark = i & 8;
        const char *const name = is_model ? "3D/a.model:1" : "_rels/.rels";
        char one[8000], expected[200];
        unsigned char wide[16000];
        size_t size = 0;
        snprintf(one, sizeof one, "%s%s", begins, texts[is_model]);
        if (has_mark) put(wide, &size, is_big ? 0xFFFE : 0xFEFF, 2);
        for (const char *c = one; *c; ++c) put(wide, &size, (size_t)*c << (is_big ? 8 : 0), 2);
        const char *text = is_wide ? (const char *)wide : one;
        size = is_wide ? size : strlen(one);
        snprintf(expected, sizeof expected,
            "a.3mf:%s: expected UTF-8, the encoding of a 3MF; found %s", name, found[!is_wide]);
        expect_refused(is_model ? package_of(text, size, texts[0], strlen(texts[0]), NULL)
                                : package_of(texts[1], strlen(texts[1]), text, size, NULL),
            expected);
    }
    expect_refused(package(texts[1], "<!DOCTYPE a><Relationships/>"),
        "a.3mf:_rels/.rels: a document type is not allowed in a 3MF");
    (void)state;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reads),
        cmocka_unit_test(test_edits),
        cmocka_unit_test(test_two_parts),
        cmocka_unit_test(test_sets),
        cmocka_unit_test(test_broken_models),
        cmocka_unit_test(test_required),
        cmocka_unit_test(test_relationships),
        cmocka_unit_test(test_billion),
        cmocka_unit_test(test_broken_zips),
        cmocka_unit_test(test_encodings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
