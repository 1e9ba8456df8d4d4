/* test_gltf_errors.c: glTF texts that are not what they should be, one fault each: what is said of
 * them, word for word, and the JSON pointer of the place. Quotes are written ' here. */
#include "check.h"
#include "message.h"
#include "document_bytes.h"

typedef struct bad_text {
    const char *text;    /* the root's members beside asset */
    const char *message; /* after the file's name */
} bad_text;

#define ZEROS_36 "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA"
/* A triangle: 36 bytes of positions, which may all be zero, and what follows the accessors' list.
 */
#define BUFFERS                                                                                    \
    "'buffers':[{'byteLength':36,'uri':'data:;base64," ZEROS_36                                    \
    "'}],'bufferViews':[{'buffer':0,'byteLength':36}]"
#define POSITION   "{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}"
#define MESH(more) "'meshes':[{'primitives':[{'attributes':{'POSITION':0" more "}}]}]"

static document_bytes gltf_text(const char *members, const char *asset) {
    static char text[4000];
    snprintf(text, sizeof text, "{'asset':{%s}%s%s}", asset, members[0] ? "," : "", members);
    for (char *at = text; *at; ++at)
        if (*at == '\'') *at = '"';
    return bytes_copy(text, strlen(text));
}

static void expect_each(const bad_text *texts, size_t count, const char *asset,
    norma_document_result expected_result, norma_document_depth depth) {
    size_t wrong = 0;
    for (size_t i = 0; i < count; ++i) {
        const norma_document_options options = {.struct_size = sizeof options, .depth = depth};
        norma_document *document = NULL;
        norma_document_error error = {0};
        char expected[1000];
        document_bytes bytes = gltf_text(texts[i].text, asset);
        norma_document_result result = norma_document_open_memory(
            bytes.data, bytes.size, "a.gltf", &options, &document, &error);
        snprintf(expected, sizeof expected, "a.gltf:%s", texts[i].message);
        if (result != expected_result || !is_message(error.message, expected)) {
            print_error("text %zu: result %d, \"%s\"\n   expected %d, \"%s\"\n", i, (int)result,
                error.message, (int)expected_result, expected);
            ++wrong;
        }
        norma_document_close(document);
        bytes_free(&bytes);
    }
    assert_int_equal(wrong, 0);
}

#define VERSION_2 "'version':'2.0'"

/* What is wrong already in a summary. */
static void test_schema(void **state) {
    static const bad_text texts[] = {
        {"'extensionsRequired':{}", "/extensionsRequired: expected an array; found "},
        {"'extensionsRequired':[7]",
            "/extensionsRequired/0: expected the name of an extension; found "},
        {"'buffers':{}", "/buffers: expected an array; found "},
        {"'buffers':[7]", "/buffers/0: expected an object; found 7"},
        {"'buffers':[[ 'a b', "
         "'01234567890123456789012345678901234567890123456789012345678901234567890\303\244 ']]",
            "/buffers/0: expected an object; found [\"a "
            "b\",\"01234567890123456789012345678901234567890123456789012345678901234567890..."},
        {"'buffers':[{}]",
            "/buffers/0: expected a whole number of bytes in \"byteLength\"; found "},
        {"'buffers':[{'byteLength':-1}]",
            "/buffers/0: expected a whole number of bytes in \"byteLength\"; found "},
        {"'buffers':[{'byteLength':1.5}]",
            "/buffers/0: expected a whole number of bytes in \"byteLength\"; found "},
        {"'buffers':[{'byteLength':18446744073709551615}]",
            "/buffers/0: expected a whole number of bytes in \"byteLength\"; found "},
        {"'buffers':[{'byteLength':4,'uri':7}]",
            "/buffers/0/uri: expected a URI as a string; found "},
        {"'buffers':[{'byteLength':4,'uri':'a%zz.bin'}]",
            "/buffers/0/uri: expected a URI whose percent escapes can be resolved; found "},
        {"'buffers':[{'byteLength':4,'uri':'a%00.bin'}]",
            "/buffers/0/uri: expected a URI whose percent escapes can be resolved; found "},
        {"'bufferViews':'none'", "/bufferViews: expected an array; found "},
        {"'bufferViews':[{'byteLength':4}]",
            "/bufferViews/0: expected the number of an existing buffer in \"buffer\"; found "},
        {"'bufferViews':[{'buffer':0,'byteLength':4}]",
            "/bufferViews/0: expected the number of an existing buffer in \"buffer\"; found "},
        {"'buffers':[{'byteLength':4}],'bufferViews':[{'buffer':0}]",
            "/bufferViews/0: expected a byteLength, and byteOffset and byteStride as whole "
            "numbers; found "},
        {"'buffers':[{'byteLength':4}],'bufferViews':[{'buffer':0,'byteLength':4,'byteOffset':'0'}"
         "]",
            "/bufferViews/0: expected a byteLength, and byteOffset and byteStride as whole "
            "numbers; found "},
        {"'buffers':[{'byteLength':4}],'bufferViews':[{'buffer':0,'byteLength':4,'byteStride':-4}]",
            "/bufferViews/0: expected a byteLength, and byteOffset and byteStride as whole "
            "numbers; found "},
        {"'buffers':[{'byteLength':4}],'bufferViews':[{'buffer':0,'byteLength':4,'extensions':{'"
         "EXT_meshopt_compression':{}}}]",
            "/bufferViews/0/extensions/EXT_meshopt_compression: expected buffer, byteLength, "
            "byteStride, count, mode and filter as EXT_meshopt_compression has them; found "},
        {"'buffers':[{'byteLength':4}],'bufferViews':[{'buffer':0,'byteLength':4,'extensions':{'"
         "KHR_meshopt_compression':{'buffer':0,'byteLength':4,'byteStride':4,'count':1,'mode':'"
         "POINTS'}}}]",
            "/bufferViews/0/extensions/KHR_meshopt_compression: expected buffer, byteLength, "
            "byteStride, count, mode and filter as EXT_meshopt_compression has them; found "},
        {"'buffers':[{'byteLength':4}],'bufferViews':[{'buffer':0,'byteLength':4,'extensions':{'"
         "EXT_meshopt_compression':{'buffer':0,'byteLength':4,'byteStride':4,'count':1,'mode':'"
         "ATTRIBUTES','filter':'SHARPEN'}}}]",
            "/bufferViews/0/extensions/EXT_meshopt_compression: expected buffer, byteLength, "
            "byteStride, count, mode and filter as EXT_meshopt_compression has them; found "},
        {"'accessors':{}", "/accessors: expected an array; found "},
        {"'accessors':[[]]", "/accessors/0: expected an object; found "},
        {"'accessors':[{'bufferView':0}]",
            "/accessors/0: expected the number of an existing view in \"bufferView\"; found "},
        {"'accessors':[{'componentType':5126,'type':'VEC3'}]",
            "/accessors/0: expected a count from 1, and byteOffset and componentType as whole "
            "numbers; found "},
        {"'accessors':[{'componentType':5126,'count':0,'type':'VEC3'}]",
            "/accessors/0: expected a count from 1, and byteOffset and componentType as whole "
            "numbers; found "},
        {"'accessors':[{'componentType':5126,'count':3,'byteOffset':-8,'type':'VEC3'}]",
            "/accessors/0: expected a count from 1, and byteOffset and componentType as whole "
            "numbers; found "},
        {"'accessors':[{'componentType':5130,'count':3,'type':'VEC3'}]",
            "/accessors/0: expected componentType 5130 only with KHR_accessor_float64, and not "
            "normalized; found "},
        {"'accessors':[{'componentType':5132,'count':3,'type':'VEC3'}]",
            "/accessors/0: expected a componentType and type that glTF has; found "},
        {"'accessors':[{'componentType':5124,'count':3,'type':'VEC3'}]",
            "/accessors/0: expected a componentType and type that glTF has; found "},
        {"'accessors':[{'componentType':5126,'count':3,'type':'VEC5'}]",
            "/accessors/0: expected a componentType and type that glTF has; found "},
        {"'accessors':[{'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':4}}]",
            "/accessors/0/sparse: expected a count from 1 to the accessor's, and indices and "
            "values with views that exist; found "},
        {"'accessors':[{'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':1,'indices':"
         "{'bufferView':0,'componentType':5126},'values':{'bufferView':0}}}]," BUFFERS,
            "/accessors/0/sparse: expected a count from 1 to the accessor's, and indices and "
            "values with views that exist; found "},
        {"'accessors':[{'componentType':5126,'count':3,'type':'VEC3','sparse':{'count':1,'indices':"
         "{'bufferView':0,'componentType':5123},'values':{'bufferView':1}}}]," BUFFERS,
            "/accessors/0/sparse: expected a count from 1 to the accessor's, and indices and "
            "values with views that exist; found "},
        {"'meshes':{}", "/meshes: expected an array; found "},
        {"'meshes':[7]", "/meshes/0: expected a mesh with an array \"primitives\"; found "},
        {"'meshes':[{'primitives':{}}]",
            "/meshes/0: expected a mesh with an array \"primitives\"; found "},
        {"'meshes':[{'primitives':[7]}]",
            "/meshes/0/primitives/0: expected a primitive with an object \"attributes\"; found "},
        {"'meshes':[{'primitives':[{'attributes':[0]}]}]",
            "/meshes/0/primitives/0: expected a primitive with an object \"attributes\"; found "},
        {"'meshes':[{'primitives':[{'attributes':{},'targets':{}}]}]",
            "/meshes/0/primitives/0/targets: expected an array; found "},
        {"'meshes':[{'primitives':[{'attributes':{},'targets':[7]}]}]",
            "/meshes/0/primitives/0/targets/0: expected an object; found "},
        {MESH(""), "/meshes/0/primitives/0/attributes/POSITION: expected the number of an existing "
                   "accessor; found "},
        {"'meshes':[{'primitives':[{'attributes':{},'mode':7}]}]",
            "/meshes/0/primitives/0: expected a mode that glTF has, and indices and a material "
            "that exist; found "},
        {"'meshes':[{'primitives':[{'attributes':{},'indices':0}]}]",
            "/meshes/0/primitives/0: expected a mode that glTF has, and indices and a material "
            "that exist; found "},
        {"'meshes':[{'primitives':[{'attributes':{},'material':0}]}],'materials':[]",
            "/meshes/0/primitives/0: expected a mode that glTF has, and indices and a material "
            "that exist; found "},
        {"'meshes':[{'primitives':[{'attributes':{},'targets':[{'POSITION':'0'}]}]}]",
            "/meshes/0/primitives/0/targets/0/POSITION: expected the number of an existing "
            "accessor; "
            "found "},
        {"'nodes':{}", "/nodes: expected an array; found "},
        {"'nodes':[{},null]", "/nodes/1: expected an object; found "},
        {"'nodes':[{'mesh':0}]",
            "/nodes/0: expected the number of an existing mesh in \"mesh\"; found "},
        {"'nodes':[{'skin':0}],'skins':[]",
            "/nodes/0: expected the number of an existing skin in \"skin\"; found "},
        {"'nodes':[{'matrix':[1,0,0]}]", "/nodes/0: expected 16 numbers in \"matrix\"; found "},
        {"'nodes':[{'matrix':[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,'1']}]",
            "/nodes/0: expected 16 numbers in \"matrix\"; found "},
        {"'nodes':[{'translation':[1,0]}]", "/nodes/0: expected 3 numbers in \"translation\" and "
                                            "\"scale\", 4 in \"rotation\"; found "},
        {"'nodes':[{'rotation':[1,0,0]}]", "/nodes/0: expected 3 numbers in \"translation\" and "
                                           "\"scale\", 4 in \"rotation\"; found "},
        {"'nodes':[{'scale':2}]", "/nodes/0: expected 3 numbers in \"translation\" and \"scale\", "
                                  "4 in \"rotation\"; found "},
        {"'nodes':[{'children':0}]", "/nodes/0/children: expected an array; found "},
        {"'nodes':[{'children':[1]}]",
            "/nodes/0/children/0: expected the number of an existing node; found "},
        {"'nodes':[{'children':[0]}]", "/nodes/0/children/0: expected a node that is no other "
                                       "node's child and not its own; found "},
        {"'nodes':[{},{'children':[2,2]},{}]", "/nodes/1/children/1: expected a node that is no "
                                               "other node's child and not its own; found "},
        {"'nodes':[{},{'children':[3]},{'children':[1]},{'children':[2]}]",
            "/nodes/1: expected nodes that form a tree, not a loop; found "},
    };
    (void)state;
    expect_each(
        texts, COUNT_OF(texts), VERSION_2, NORMA_DOCUMENT_ERROR_MALFORMED, NORMA_DOCUMENT_SUMMARY);
    expect_each(
        texts, COUNT_OF(texts), VERSION_2, NORMA_DOCUMENT_ERROR_MALFORMED, NORMA_DOCUMENT_WHOLE);
}

/* What shows where the bytes are read. */
static void test_bytes(void **state) {
    static const bad_text texts[] = {
        {MESH("") ",'accessors':[" POSITION "],'buffers':[{'byteLength':36,'uri':'data:;base64,"
                  "AAAA'}],'bufferViews':[{'buffer':0,'byteLength':36}]",
            "/buffers/0/uri: expected as many bytes in the data: URI as byteLength says; found "},
        {MESH("") ",'accessors':[" POSITION "],'buffers':[{'byteLength':3,'uri':'data:;base64,A*AA'"
                  "}],'bufferViews':[{'buffer':0,'byteLength':36}]",
            "/buffers/0/uri: expected base64 in the data: URI; found "},
        {MESH("") ",'accessors':[" POSITION
                  "],'buffers':[{'byteLength':35,'uri':'data:;base64," ZEROS_36
                  "'}],'bufferViews':[{'buffer':0,'byteLength':36}]",
            "/bufferViews/0: expected a view that ends inside its buffer; found "},
        {MESH("") ",'accessors':[" POSITION
                  "],'buffers':[{'byteLength':36,'uri':'data:;base64," ZEROS_36
                  "'}],'bufferViews':[{'buffer':0,'byteOffset':9007199254740991,'byteLength':36}]",
            "/bufferViews/0: expected a view that ends inside its buffer; found "},
        {MESH("") ",'accessors':[{'bufferView':0,'componentType':5126,'count':3,'byteOffset':4,'"
                  "type':'VEC3'}]," BUFFERS,
            "/accessors/0: expected elements that end inside their view; found "},
        {MESH("") ",'accessors':[{'bufferView':0,'componentType':5126,'count':9007199254740991,'"
                  "type':'VEC3'}]," BUFFERS,
            "/accessors/0: expected elements that end inside their view; found "},
        {MESH("") ",'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3'}],'"
                  "buffers':[{'byteLength':36,'uri':'data:;base64," ZEROS_36
                  "'}],'bufferViews':[{'buffer':0,'byteLength':36,'byteStride':8}]",
            "/accessors/0: expected elements no longer than their view's byteStride; found "},
        {MESH(",'NORMAL':0,'NORMAL':0") ",'accessors':[" POSITION "]," BUFFERS,
            "/meshes/0/primitives/0/attributes/NORMAL: expected each name once; found "},
        {MESH("") ",'accessors':[{'componentType':5126,'count':4294967296,'type':'VEC3'}]",
            "/accessors/0: expected a count that is plausible for the size of the file; found "},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],'accessors':"
         "[" POSITION ",{'bufferView':0,'componentType':5126,'count':3,'type':'SCALAR'}]," BUFFERS,
            "/accessors/1: expected indices as unsigned whole numbers; found "},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],'accessors':"
         "[" POSITION ",{'bufferView':0,'componentType':5123,'count':3,'type':'VEC2'}]," BUFFERS,
            "/accessors/1: expected indices as unsigned whole numbers; found "},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'indices':1}]}],'accessors':"
         "[" POSITION ",{'bufferView':0,'componentType':5121,'count':3,'type':'SCALAR','sparse':{'"
         "count':1,'indices':{'bufferView':0,'componentType':5121},'values':{'"
         "bufferView':1}}}],'buffers':[{'byteLength':37,'uri':'data:;base64," ZEROS_36
         "Aw=='}],'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,'"
         "byteLength':1}]",
            "/meshes/0/primitives/0: index 0 (accessor 1) names vertex 3, but there are only 3 "
            "vertices"},
        {MESH("") ",'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','"
                  "sparse':{'count':1,'indices':{'bufferView':1,'componentType':5121},'values':{'"
                  "bufferView':0}}}],'buffers':[{'byteLength':37,'uri':'data:;base64," ZEROS_36
                  "Aw=='}],'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,"
                  "'byteLength':1}]",
            "/accessors/0: expected sparse indices below count; found "},
        {MESH("") ",'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','"
                  "sparse':{'count':1,'indices':{'bufferView':1,'componentType':5125},'values':{'"
                  "bufferView':0}}}],'buffers':[{'byteLength':40,'uri':'data:;base64," ZEROS_36
                  "AAABAA=='}],'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset'"
                  ":36,'byteLength':4}]",
            "/accessors/0: expected sparse indices below count; found "},
        {MESH("") ",'accessors':[{'bufferView':0,'componentType':5126,'count':3,'type':'VEC3','"
                  "sparse':{'count':2,'indices':{'bufferView':1,'componentType':5121},'values':{'"
                  "bufferView':0}}}],'buffers':[{'byteLength':37,'uri':'data:;base64," ZEROS_36
                  "Aw=='}],'bufferViews':[{'buffer':0,'byteLength':36},{'buffer':0,'byteOffset':36,"
                  "'byteLength':1}]",
            "/accessors/0: expected elements that end inside their view; found "},
    };
    (void)state;
    expect_each(
        texts, COUNT_OF(texts), VERSION_2, NORMA_DOCUMENT_ERROR_MALFORMED, NORMA_DOCUMENT_WHOLE);
}

/* Each within the count that a file without bytes may have, together far more than the file. */
static norma_document_result open_without_bytes(int meshes, norma_document_error *error) {
    enum { COUNT = 3300 };
    char members[4000], *at = members;
    for (int list = 0; list < 2; ++list) {
        at += sprintf(at, list ? "],'accessors':[" : "'meshes':[");
        for (int i = 0; i < meshes; ++i)
            at += list ? sprintf(at, "%s{'componentType':5126,'count':%d,'type':'VEC3'}",
                             i ? "," : "", COUNT)
                       : sprintf(at, "%s{'primitives':[{'attributes':{'POSITION':%d}}]}",
                             i ? "," : "", i);
    }
    strcpy(at, "]");
    document_bytes bytes = gltf_text(members, VERSION_2);
    norma_document *document = NULL;
    norma_document_result result =
        norma_document_open_memory(bytes.data, bytes.size, "a.gltf", NULL, &document, error);
    norma_document_close(document);
    bytes_free(&bytes);
    return result;
}

static void test_accessors_without_bytes(void **state) {
    (void)state;
    norma_document_error error = {0};
    assert_int_equal(open_without_bytes(36, &error),
        NORMA_DOCUMENT_ERROR_UNSUPPORTED); /* 256 KiB, and 256 times 3,500 bytes, hold 30 or so of
                                              them */
    assert_non_null(strstr(error.message,
        ": 3300 elements from here, with all before them, would take far more "
        "memory than the file; at most 256 bytes are read for each byte of it"));
    assert_int_equal(open_without_bytes(36 / 2, &error),
        NORMA_DOCUMENT_ERROR_MALFORMED); /* of half as many a file is too short for the count of one
                                          */
    assert_non_null(strstr(
        error.message, "expected a count that is plausible for the size of the file; found "));
}

static void test_normals_fewer_than_positions(void **state) {
    static const bad_text texts[] = {
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0,'NORMAL':1}}]}],'accessors':"
         "[" POSITION ",{'bufferView':0,'componentType':5126,'count':2,'type':'VEC3'}]," BUFFERS,
            "/meshes/0/primitives/0/attributes/NORMAL: expected an accessor with as many elements "
            "as POSITION has; found "},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'targets':[{'POSITION':1}]}]}],'"
         "accessors':[" POSITION
         ",{'bufferView':0,'componentType':5126,'count':2,'type':'VEC3'}]," BUFFERS,
            "/meshes/0/primitives/0/targets/0/POSITION: expected an accessor with as many elements "
            "as POSITION has; found "},
    };
    (void)state;
    expect_each(
        texts, COUNT_OF(texts), VERSION_2, NORMA_DOCUMENT_ERROR_MALFORMED, NORMA_DOCUMENT_WHOLE);
}

/* Read leniently, each corner names its normal: in one array, however often it is asked for. */
static void test_fewer_normals_named(void **state) {
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    norma_document *document = NULL;
    norma_mesh_data first, again;
    document_bytes bytes = gltf_text(MESH(",'NORMAL':1") ",'accessors':[" POSITION
                                                         ",{'bufferView':0,'componentType':5126,'"
                                                         "count':2,'type':'VEC3'}]," BUFFERS,
        VERSION_2);
    (void)state;
    assert_int_equal(
        norma_document_open_memory(bytes.data, bytes.size, "a.gltf", &options, &document, NULL),
        NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &first, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_data(document, 0, &again, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(first.normals.count, 2);
    assert_int_equal(first.corner_normals[1], 1);
    assert_int_equal(first.corner_normals[2], UINT32_MAX);
    assert_ptr_equal(first.corner_normals, again.corner_normals);
    norma_document_close(document);
    bytes_free(&bytes);
}

static void test_versions(void **state) {
    static const bad_text none[] = {{"",
        "/asset/version: the version is missing; every glTF file has one"}},
                          other[] = {
                              {"", "/asset/version: is not version 2; only glTF 2.0 can be read"}};
    static const bad_text later[] = {{"", "/asset/minVersion: needs a later version of glTF than "
                                          "2.0, the only one that can be read here"}};
    (void)state;
    expect_each(
        none, 1, "'generator':'hand'", NORMA_DOCUMENT_ERROR_MALFORMED, NORMA_DOCUMENT_SUMMARY);
    expect_each(
        other, 1, "'version':'3.0'", NORMA_DOCUMENT_ERROR_UNSUPPORTED, NORMA_DOCUMENT_SUMMARY);
    expect_each(
        other, 1, "'version':2.0", NORMA_DOCUMENT_ERROR_UNSUPPORTED, NORMA_DOCUMENT_SUMMARY);
    expect_each(
        other, 1, "'version':'2'", NORMA_DOCUMENT_ERROR_UNSUPPORTED, NORMA_DOCUMENT_SUMMARY);
    expect_each(later, 1, "'version':'2.1','minVersion':'2.1'", NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        NORMA_DOCUMENT_SUMMARY);
}

/* ---- compressed views: each fault in what surrounds the compressed bytes */

static void test_meshopt(void **state) {
#define COMPRESSED(length, members)                                                                \
    MESH("")                                                                                       \
    ",'accessors':[" POSITION "],'buffers':[{'byteLength':36,'uri':'data:;base64," ZEROS_36        \
    "'},{'byteLength':36}],"                                                                       \
    "'bufferViews':[{'buffer':1,'byteLength':" length                                              \
    ",'extensions':{'EXT_meshopt_compression':{'buffer':0," members "}}}]"
#define AT "/bufferViews/0/extensions/EXT_meshopt_compression: expected "
    static const bad_text texts[] = {
        {COMPRESSED("36", "'byteLength':36,'count':3,'mode':'ATTRIBUTES'"),
            AT "a byteStride that is not zero; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':9007199254740991,'count':9007199254740991,'"
                          "mode':'ATTRIBUTES'"),
            AT "a byteLength of at least count times byteStride; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':12,'count':4,'mode':'ATTRIBUTES'"),
            AT "a byteLength of at least count times byteStride; found "},
        {COMPRESSED(
             "1200000", "'byteLength':36,'byteStride':12,'count':100000,'mode':'ATTRIBUTES'"),
            AT "no more elements than the compressed bytes can hold; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':6,'count':3,'mode':'ATTRIBUTES'"),
            AT "a byteStride that its mode allows; found "},
        {COMPRESSED("780", "'byteLength':36,'byteStride':260,'count':3,'mode':'ATTRIBUTES'"),
            AT "a byteStride that its mode allows; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':12,'count':3,'mode':'TRIANGLES'"),
            AT "a byteStride that its mode allows; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':1,'count':3,'mode':'INDICES'"),
            AT "a byteStride that its mode allows; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':4,'count':4,'mode':'TRIANGLES'"),
            AT "a count that is a multiple of 3; found "},
        {COMPRESSED("36",
             "'byteLength':36,'byteStride':4,'count':3,'mode':'TRIANGLES','filter':'EXPONENTIAL'"),
            AT "a filter only with ATTRIBUTES; found "},
        {COMPRESSED("36",
             "'byteLength':36,'byteStride':12,'count':3,'mode':'ATTRIBUTES','filter':'OCTAHEDRAL'"),
            AT "a byteStride that its filter allows; found "},
        {COMPRESSED("36",
             "'byteLength':36,'byteStride':12,'count':3,'mode':'ATTRIBUTES','filter':'QUATERNION'"),
            AT "a byteStride that its filter allows; found "},
        {COMPRESSED("36", "'byteLength':37,'byteStride':12,'count':3,'mode':'ATTRIBUTES'"),
            AT "compressed bytes that end inside their buffer; found "},
        {COMPRESSED(
             "36", "'byteOffset':1,'byteLength':36,'byteStride':12,'count':3,'mode':'ATTRIBUTES'"),
            AT "compressed bytes that end inside their buffer; found "},
        {COMPRESSED("2000", "'byteLength':36,'byteStride':12,'count':3,'mode':'ATTRIBUTES'"),
            AT "a byteLength of count times byteStride; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':12,'count':3,'mode':'ATTRIBUTES'"),
            AT "bytes that meshoptimizer's decoder accepts; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':4,'count':9,'mode':'TRIANGLES'"),
            AT "bytes that meshoptimizer's decoder accepts; found "},
        {COMPRESSED("36", "'byteLength':36,'byteStride':2,'count':9,'mode':'INDICES'"),
            AT "bytes that meshoptimizer's decoder accepts; found "},
    };
    (void)state;
    expect_each(
        texts, COUNT_OF(texts), VERSION_2, NORMA_DOCUMENT_ERROR_MALFORMED, NORMA_DOCUMENT_WHOLE);
}

/* ---- what the whole file is */

static void test_json_and_glb(void **state) {
    static const struct {
        const char *name, *bytes;
        size_t size;
        norma_document_result result;
        const char *message;
    } files[] = {
        {"a.gltf", "", 0, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.gltf:byte 0: is not JSON: expected a value; found the end of the text"},
        {"a.gltf", "[]", 2, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.gltf:/: expected an object; found []"},
        {"a.gltf", "{\"asset\":{}} x", 14, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.gltf:byte 13: is not JSON: expected nothing after the end; found x"},
        {"a.glb", "glTF", 4, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 0: expected the 12 bytes of a GLB header, \"glTF\" first; found 67 6C 54 "
            "46"},
        {"a.glb", "glTG\2\0\0\0\14\0\0\0", 12, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 0: expected the 12 bytes of a GLB header, \"glTF\" first; found "},
        {"a.glb", "glTF\1\0\0\0\14\0\0\0", 12, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            "a.glb:byte 4: this is GLB version 1; only version 2 can be read"},
        {"a.glb", "glTF\2\0\0\0\377\377\377\377", 12, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 8: the header declares 4294967295 bytes, but the file has only 12"},
        {"a.glb", "glTF\2\0\0\0\14\0\0\0", 12, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 12: expected a JSON chunk; found the end of the file"},
        {"a.glb", "glTF\2\0\0\0\24\0\0\0\4\0\0\0JSON", 20, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 12: expected a chunk that ends within the length that the header declares; "
            "found "},
        {"a.glb", "glTF\2\0\0\0\24\0\0\0\377\377\377\377JSON", 20, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 12: expected a chunk that ends within the length that the header declares; "
            "found "},
        {"a.glb", "glTF\2\0\0\0\30\0\0\0\4\0\0\0BIN\0    ", 24, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 12: expected a JSON chunk first; found 04 00 00 00 42 49 4E 00"},
        {"a.glb", "glTF\2\0\0\0\33\0\0\0\4\0\0\0JSON{}  \0\0\0", 27, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 24: expected the 8 bytes of a chunk's header; found "},
        {"a.glb", "glTF\2\0\0\0\40\0\0\0\4\0\0\0JSON{}  \0\0\0\0JSON", 32,
            NORMA_DOCUMENT_ERROR_MALFORMED, "a.glb:byte 24: expected one JSON chunk; found "},
        {"a.glb", "glTF\2\0\0\0\50\0\0\0\4\0\0\0JSON{}  \0\0\0\0BIN\0\0\0\0\0BIN\0", 40,
            NORMA_DOCUMENT_ERROR_MALFORMED, "a.glb:byte 32: expected one BIN chunk; found "},
        {"a.glb", "glTF\2\0\0\0\30\0\0\0\4\0\0\0JSON{}x ", 24, NORMA_DOCUMENT_ERROR_MALFORMED,
            "a.glb:byte 22: is not JSON: expected nothing after the end; found "},
    };
    size_t wrong = 0;
    (void)state;
    for (size_t i = 0; i < COUNT_OF(files); ++i) {
        char message[1000];
        document_bytes bytes = bytes_copy(files[i].bytes, files[i].size);
        norma_document_result result = bytes_try(bytes, files[i].name, NULL, message);
        if (result != files[i].result || !is_message(message, files[i].message)) {
            print_error("file %zu: result %d, \"%s\"\n   expected \"%s\"\n", i, (int)result,
                message, files[i].message);
            ++wrong;
        }
        bytes_free(&bytes);
    }
    assert_int_equal(wrong, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_schema),
        cmocka_unit_test(test_bytes),
        cmocka_unit_test(test_accessors_without_bytes),
        cmocka_unit_test(test_normals_fewer_than_positions),
        cmocka_unit_test(test_fewer_normals_named),
        cmocka_unit_test(test_versions),
        cmocka_unit_test(test_meshopt),
        cmocka_unit_test(test_json_and_glb),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
