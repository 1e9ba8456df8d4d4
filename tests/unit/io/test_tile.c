/* test_tile.c: tiles of 3D Tiles 1.0: the GLB inside becomes what the same GLB becomes as a file of
 * its own, and all around it keeps its bytes but for lengths and padding. The headers are put
 * together here as OGC 18-053r2 lists their fields. */
#include "check.h"
#include "document_bytes.h"
#include "gltf_asset.h"
#include "message.h"
#include <norma/check.h>
#include <stdio.h>

typedef struct made_tile {
    unsigned char bytes[4096];
    size_t size;
} made_tile;

static void add(made_tile *tile, const void *bytes, size_t size) {
    assert_true(tile->size + size <= sizeof tile->bytes);
    memcpy(tile->bytes + tile->size, bytes, size);
    tile->size += size;
}

static void add_u32(made_tile *tile, size_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
        (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    add(tile, bytes, 4);
}

static size_t u32_at(const unsigned char *at) {
    return at[0] | (size_t)at[1] << 8 | (size_t)at[2] << 16 | (size_t)at[3] << 24;
}

static size_t aligned(size_t size) { return (size + 7) / 8 * 8; }

enum { FEATURES_SIZE = 48, BATCH_SIZE = 16, B3DM_TABLES = 28 + FEATURES_SIZE + BATCH_SIZE + 4 };
static const char FEATURES[FEATURES_SIZE] = "{\"BATCH_LENGTH\":2,\"RTC_CENTER\":[1,2,3]}",
                  BATCH[BATCH_SIZE] = "{\"id\":[7,8]}   ";

/* A b3dm, or an i3dm where the number of its format is given. */
static void add_model(made_tile *tile, document_bytes glb, int instanced, size_t inside) {
    const size_t header = instanced ? 32 : 28, tables = FEATURES_SIZE + BATCH_SIZE + 4,
                 length = aligned(header + tables + glb.size), begin = tile->size;
    add(tile, instanced ? "i3dm" : "b3dm", 4);
    add_u32(tile, 1);
    add_u32(tile, length);
    add_u32(tile, FEATURES_SIZE);
    add_u32(tile, 0);
    add_u32(tile, BATCH_SIZE);
    add_u32(tile, 4);
    if (instanced) add_u32(tile, inside);
    add(tile, FEATURES, FEATURES_SIZE);
    add(tile, BATCH, BATCH_SIZE);
    add(tile, "\1\2\3\4", 4);
    add(tile, glb.data, glb.size);
    add(tile, "\0\0\0\0\0\0\0", begin + length - tile->size);
}

static void add_points(made_tile *tile) {
    add(tile, "pnts", 4);
    add_u32(tile, 1);
    add_u32(tile, 32);
    add(tile, "twenty bytes of it..", 20);
}

/* Two triangles that meet at a right angle: a crease there splits two of their four vertices.
 * nodes: that draw them. */
static document_bytes roof_drawn_by(const char *nodes) {
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint16_t corners[] = {0, 1, 2, 1, 0, 3};
    gltf_asset a = {0};
    size_t size;
    asset_floats(&a, positions, 4, 3);
    asset_uint16(&a, corners, 6);
    char text[300];
    snprintf(text, sizeof text,
        "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[%s],\"meshes\":[{\"primitives\":["
        "{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]",
        nodes);
    asset_bytes(&a, text, &size);
    const document_bytes glb = bytes_copy(a.glb, size);
    asset_free(&a);
    return glb;
}

static document_bytes roof(void) { return roof_drawn_by("{\"mesh\":0}"); }

static void expect_computed(
    const made_tile *tile, const char *name, size_t glb_at, size_t tile_at) {
    document_bytes before = bytes_copy(tile->bytes, tile->size), glb = roof(),
                   after = bytes_computed(before, name, NULL, NULL),
                   want = bytes_computed(glb, "roof.glb", NULL, NULL);
    assert_true(want.size > glb.size);
    assert_true(after.size >= glb_at + want.size);
    assert_memory_equal(after.data + glb_at, want.data, want.size);
    const size_t old_end = tile_at + aligned(glb_at - tile_at + glb.size),
                 end = tile_at + aligned(glb_at - tile_at + want.size),
                 behind = tile->size - old_end;
    assert_int_equal(after.size, end + behind);
    assert_memory_equal(after.data + end, tile->bytes + old_end, behind);
    for (size_t i = glb_at + want.size; i < end; ++i) assert_int_equal(after.data[i], 0);
    assert_int_equal(u32_at(after.data + tile_at + 8), end - tile_at);
    if (tile_at) assert_int_equal(u32_at(after.data + 8), after.size);
    for (size_t i = 0; i < glb_at; ++i)
        if ((i < 8 || i > 11) && (i < tile_at + 8 || i > tile_at + 11))
            assert_int_equal(after.data[i], tile->bytes[i]);
    bytes_free(&before);
    bytes_free(&after);
    bytes_free(&glb);
    bytes_free(&want);
}

static void test_models(void **state) {
    document_bytes glb = roof();
    made_tile batched = {.size = 0}, instanced = {.size = 0}, composite = {.size = 0};
    add_model(&batched, glb, 0, 0);
    expect_computed(&batched, "a.b3dm", B3DM_TABLES, 0);
    add_model(&instanced, glb, 1, 1);
    expect_computed(&instanced, "a.i3dm", B3DM_TABLES + 4, 0);
    add(&composite, "cmpt", 4);
    add_u32(&composite, 1);
    add_u32(&composite, 16 + 32 + batched.size + 32);
    add_u32(&composite, 3);
    add_points(&composite);
    add(&composite, batched.bytes, batched.size);
    add_points(&composite);
    expect_computed(&composite, "a.cmpt", 16 + 32 + B3DM_TABLES, 16 + 32);
    bytes_free(&glb);
    (void)state;
}

static void test_untouched(void **state) {
    document_bytes glb = roof();
    made_tile tile = {.size = 0};
    add_model(&tile, glb, 0, 0);
    document_bytes bytes = bytes_copy(tile.bytes, tile.size);
    norma_document *document = bytes_open(bytes, "a.b3dm");
    document_bytes written = bytes_of(document);
    assert_true(bytes_equal(bytes, written));
    assert_int_equal(norma_document_note_count(document), 0); /* padding is no surplus */
    norma_document_close(document);
    bytes_free(&written);
    bytes_free(&bytes);
    bytes_free(&glb);
    (void)state;
}

static void expect_refused(
    const made_tile *tile, const char *name, norma_document_result result, const char *expected) {
    char message[1000];
    document_bytes bytes = bytes_copy(tile->bytes, tile->size);
    assert_int_equal(bytes_try(bytes, name, NULL, message), result);
    assert_string_equal(message, expected);
    bytes_free(&bytes);
}

static void test_refused(void **state) {
    const norma_document_result malformed = NORMA_DOCUMENT_ERROR_MALFORMED,
                                unsupported = NORMA_DOCUMENT_ERROR_UNSUPPORTED;
    document_bytes glb = roof();
    made_tile model = {.size = 0}, outside = {.size = 0}, points = {.size = 0};
    add_model(&model, glb, 0, 0);
    made_tile cut = model, old = model, wrong = model, version = model;
    cut.size = 8;
    expect_refused(
        &cut, "a.b3dm", malformed, "a.b3dm:byte 0: expected the header of a tile; found the end");
    wrong.bytes[8] = 255;
    wrong.bytes[9] = 255;
    expect_refused(
        &wrong, "a.b3dm", malformed, "a.b3dm:byte 8: the tile's length does not fit into the file");
    old.bytes[15] = 1;
    expect_refused(&old, "a.b3dm", malformed,
        "a.b3dm:byte 12: the tables are longer than the tile; expected the 28 bytes of a header as "
        "3D Tiles 1.0 has them");
    version.bytes[4] = 2;
    expect_refused(&version, "a.b3dm", unsupported,
        "a.b3dm:byte 4: this is not version 1 of a tile, the only one that can be read");
    add_model(&outside, glb, 1, 0);
    expect_refused(&outside, "a.i3dm", unsupported,
        "a.i3dm: the tile names a glTF file instead of holding one; give that file");
    add_points(&points);
    expect_refused(
        &points, "a.cmpt", unsupported, "a.cmpt: the tile has points, which have no faces");
    bytes_free(&glb);
    (void)state;
}

/* What a composite has beside its model is said not to be checked: outside names a file, and two
 * have points. */
static void test_left_out(void **state) {
    document_bytes glb = roof();
    made_tile model = {.size = 0}, outside = {.size = 0}, composite = {.size = 0};
    norma_document_error error;
    norma_findings *findings = NULL;
    char where[40];
    add_model(&model, glb, 0, 0);
    add_model(&outside, glb, 1, 0);
    add(&composite, "cmpt", 4);
    add_u32(&composite, 1);
    add_u32(&composite, 16 + model.size + outside.size + 64);
    add_u32(&composite, 4);
    add(&composite, model.bytes, model.size);
    const size_t outside_at = composite.size;
    add(&composite, outside.bytes, outside.size);
    add_points(&composite);
    add_points(&composite);
    document_bytes bytes = bytes_copy(composite.bytes, composite.size);
    norma_document *document = bytes_open(bytes, "a.cmpt");
    assert_int_equal(norma_check_document(document, NULL, &findings, &error), NORMA_DOCUMENT_OK);
    const norma_finding *first = norma_findings_get(findings, 0);
    snprintf(where, sizeof where, "byte %zu", outside_at);
    assert_string_equal(first->rule->id, "N002");
    assert_int_equal(first->severity, NORMA_SEVERITY_WARNING);
    assert_string_equal(first->where, where);
    assert_string_equal(first->message,
        "not checked: this tile names a glTF file instead of holding one; give that file; tiles "
        "without a model besides: 2");
    assert_true(norma_findings_partly(findings));
    norma_findings_free(findings);
    norma_document_close(document);
    bytes_free(&bytes);
    bytes_free(&glb);
    (void)state;
}

static document_bytes turned_roof(void) {
    uint8_t faces[4] = {1};
    document_bytes glb = roof();
    norma_document *document = bytes_open(glb, "a.glb");
    const norma_mesh_edit edit = {.reverse_faces = faces};
    assert_int_equal(norma_document_edit(document, &edit, NULL), NORMA_DOCUMENT_OK);
    document_bytes turned = bytes_of(document);
    norma_document_close(document);
    bytes_free(&glb);
    return turned;
}

static norma_document *open_every(document_bytes bytes, norma_document_error *error) {
    const norma_document_options options = {.struct_size = sizeof options, .lenient = 1};
    norma_document *document = NULL;
    (void)norma_document_open_memory(bytes.data, bytes.size, "a.cmpt", &options, &document, error);
    return document;
}

/* What is found in a model as a file of its own is found in the composite, in its tile. */
static size_t expect_findings(const made_tile *alone, const char *name, size_t tile,
    const norma_findings *all, size_t at, const norma_check_options *checking) {
    norma_findings *own = NULL;
    document_bytes bytes = bytes_copy(alone->bytes, alone->size);
    norma_document *document = bytes_open(bytes, name);
    assert_int_equal(norma_check_document(document, checking, &own, NULL), NORMA_DOCUMENT_OK);
    assert_true(norma_findings_count(own) > 1);
    for (size_t i = 0; i < norma_findings_count(own); ++i) {
        const norma_finding *want = norma_findings_get(own, i),
                            *got = norma_findings_get(all, at++);
        char where[100], label[200];
        assert_non_null(got);
        snprintf(where, sizeof where, "/tiles/%zu%s%s", tile,
            strcmp(want->where, "instances") == 0 ? "/" : "", want->where);
        snprintf(label, sizeof label, "tile %zu%s%s", tile, want->label[0] ? " " : "", want->label);
        assert_string_equal(got->where, where);
        assert_string_equal(got->label, label);
        assert_string_equal(got->message, want->message);
        assert_string_equal(got->rule->id, want->rule->id);
        assert_int_equal(got->severity, want->severity);
        assert_int_equal(got->count, want->count);
        assert_int_equal(got->fix, want->fix);
    }
    norma_findings_free(own);
    norma_document_close(document);
    bytes_free(&bytes);
    return at;
}

/* b3dm, points, and an i3dm in a composite within. */
static made_tile composite_of(const made_tile *first, const made_tile *second) {
    made_tile composite = {.size = 0};
    add(&composite, "cmpt", 4);
    add_u32(&composite, 1);
    add_u32(&composite, 16 + first->size + 32 + 16 + second->size);
    add_u32(&composite, 3);
    add(&composite, first->bytes, first->size);
    add_points(&composite);
    add(&composite, "cmpt", 4);
    add_u32(&composite, 1);
    add_u32(&composite, 16 + second->size);
    add_u32(&composite, 1);
    add(&composite, second->bytes, second->size);
    return composite;
}

/* What a model may stand for goes by its own bytes, whatever else a composite holds. */
static void test_hollow(void **state) {
    enum { POINTS = 400000 };
    static const char json[] =
        "{\"asset\":{\"version\":\"2.0\"},\"accessors\":[{\"componentType\":5126,\"count\":90000,"
        "\"type\":\"VEC3\"}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}   ";
    const size_t text = (sizeof json - 1) / 4 * 4;
    document_bytes one = roof();
    made_tile glb = {.size = 0}, start = {.size = 0}, model = {.size = 0};
    norma_document_error error = {0};
    add(&glb, "glTF\2\0\0", 8);
    add_u32(&glb, 20 + text);
    add_u32(&glb, text);
    add(&glb, "JSON", 4);
    add(&glb, json, text);
    add_model(&model, (document_bytes){.data = glb.bytes, .size = glb.size}, 0, 0);
    add(&start, "cmpt", 4);
    add_u32(&start, 1);
    add_u32(&start, 0);
    add_u32(&start, 3);
    add_model(&start, one, 0, 0);
    const size_t size = start.size + POINTS + model.size;
    for (size_t i = 0; i < 4; ++i) start.bytes[8 + i] = (unsigned char)(size >> (8 * i));
    const size_t points = start.size;
    add(&start, "pnts", 4);
    add_u32(&start, 1);
    add_u32(&start, POINTS);
    unsigned char *all = calloc(size, 1);
    assert_non_null(all);
    memcpy(all, start.bytes, start.size);
    memcpy(all + points + POINTS, model.bytes, model.size);
    document_bytes bytes = bytes_copy(all, size);
    assert_null(open_every(bytes, &error));
    assert_true(strncmp(error.message, "a.cmpt:tile 1: ", 15) == 0);
    bytes_free(&bytes);
    bytes_free(&one);
    free(all);
    (void)state;
}

static void test_several(void **state) {
    const norma_check_options checking = {
        .struct_size = sizeof checking, .profile = NORMA_CHECK_PROFILE_PRINT};
    document_bytes one = roof(), two = turned_roof();
    made_tile first = {.size = 0}, second = {.size = 0};
    norma_document_error error = {0};
    norma_findings *findings = NULL;
    add_model(&first, one, 0, 0);
    add_model(&second, two, 1, 1);
    const made_tile composite = composite_of(&first, &second);
    document_bytes bytes = bytes_copy(composite.bytes, composite.size);
    norma_document *document = open_every(bytes, &error);
    assert_non_null(document);
    assert_int_equal(
        norma_check_document(document, &checking, &findings, &error), NORMA_DOCUMENT_OK);
    assert_string_equal(norma_findings_get(findings, 0)->rule->id, "N002"); /* the points */
    size_t at = expect_findings(&first, "a.b3dm", 0, findings, 1, &checking);
    const size_t turned = at;
    at = expect_findings(&second, "a.i3dm", 1, findings, at, &checking);
    assert_int_equal(at, norma_findings_count(findings));
    int has_turned = 0;
    for (size_t i = turned; i < at; ++i)
        has_turned |= strcmp(norma_findings_get(findings, i)->rule->id, "N301") == 0;
    assert_true(has_turned);
    assert_true(norma_findings_partly(findings));
    assert_int_equal(norma_document_mesh_count(norma_document_tile(document, 1)), 1);
    assert_null(norma_document_tile(document, 2));
    norma_findings_free(findings);
    norma_document_close(document);
    bytes_free(&bytes);

    made_tile harmed = composite; /* the magic of the second GLB */
    harmed.bytes[16 + first.size + 32 + 16 + B3DM_TABLES + 4] = 'x';
    bytes = bytes_copy(harmed.bytes, harmed.size);
    assert_null(open_every(bytes, &error));
    assert_int_equal(error.result, NORMA_DOCUMENT_ERROR_MALFORMED);
    assert_true(strncmp(error.message, "a.cmpt:tile 1: byte ", 20) == 0);
    bytes_free(&bytes);
    bytes_free(&one);
    bytes_free(&two);
    (void)state;
}

/* A change of a composite: what is to become of each of its models as a file of its own. */
typedef norma_document_result change(norma_document *document);

static norma_document_result change_normals(norma_document *document) {
    return norma_document_compute(document, NULL, NULL, NULL);
}

static norma_document_result change_places(norma_document *document) {
    const norma_transform_options turning = {
        .struct_size = sizeof turning, .matrix = {0, 1, 0, 0, -2, 0, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1}};
    return norma_document_transform(document, &turning, NULL, NULL);
}

static norma_document_result change_faults(norma_document *document) {
    const norma_check_options checking = {
        .struct_size = sizeof checking, .profile = NORMA_CHECK_PROFILE_PRINT};
    return norma_fix_document(document, &checking, 1, NULL, NULL);
}

static document_bytes changed_by(const made_tile *tile, const char *name, change *make) {
    document_bytes bytes = bytes_copy(tile->bytes, tile->size);
    norma_document *document = bytes_open(bytes, name);
    assert_int_equal(make(document), NORMA_DOCUMENT_OK);
    const document_bytes after = bytes_of(document);
    norma_document_close(document);
    bytes_free(&bytes);
    return after;
}

/* Walks through a composite, by the lengths that it says, and finds each part that is wanted. */
static void expect_parts(
    document_bytes all, const document_bytes *first, const document_bytes *second) {
    made_tile points = {.size = 0};
    size_t at = 16;
    add_points(&points);
    assert_memory_equal(all.data, "cmpt\1\0\0", 8);
    assert_int_equal(u32_at(all.data + 8), all.size);
    assert_int_equal(u32_at(all.data + 12), 3);
    assert_int_equal(all.size, 16 + first->size + points.size + 16 + second->size);
    assert_memory_equal(all.data + at, first->data, first->size);
    assert_int_equal(u32_at(all.data + at + 8), first->size);
    at += first->size;
    assert_memory_equal(all.data + at, points.bytes, points.size);
    at += points.size;
    assert_memory_equal(all.data + at, "cmpt\1\0\0", 8);
    assert_int_equal(u32_at(all.data + at + 8), 16 + second->size);
    assert_int_equal(u32_at(all.data + at + 12), 1);
    assert_memory_equal(all.data + at + 16, second->data, second->size);
}

static void test_changes_of_several(void **state) {
    change *const changes[] = {change_normals, change_places, change_faults};
    document_bytes one = roof(), two = turned_roof();
    made_tile first = {.size = 0}, second = {.size = 0};
    add_model(&first, one, 0, 0);
    add_model(&second, two, 1, 1);
    const made_tile composite = composite_of(&first, &second);
    for (size_t i = 0; i < sizeof changes / sizeof *changes; ++i) {
        document_bytes want_first = changed_by(&first, "a.b3dm", changes[i]),
                       want_second = changed_by(&second, "a.i3dm", changes[i]),
                       got = changed_by(&composite, "a.cmpt", changes[i]);
        assert_false(want_second.size == second.size &&
                     memcmp(want_second.data, second.bytes, second.size) == 0);
        expect_parts(got, &want_first, &want_second);
        bytes_free(&want_first);
        bytes_free(&want_second);
        bytes_free(&got);
    }
    bytes_free(&one);
    bytes_free(&two);
    (void)state;
}

/* Two tiles of other RTC_CENTERs. */
static document_bytes tiles_apart(void) {
    document_bytes glb = roof();
    made_tile first = {.size = 0}, second;
    add_model(&first, glb, 0, 0);
    bytes_free(&glb);
    for (size_t i = 28; i < 28 + FEATURES_SIZE; ++i)
        if (!first.bytes[i]) first.bytes[i] = ' ';
    second = first;
    memcpy(strstr((char *)second.bytes + 28, "[1,2,3]"), "[5,4,9]", 7);
    const made_tile composite = composite_of(&first, &second);
    return bytes_copy(composite.bytes, composite.size);
}

/* Meshes and nodes follow one another; RTC_CENTER places a model beside the first. */
static void test_several_as_one(void **state) {
    norma_document_error error = {0};
    norma_compute_summary summary;
    norma_mesh_info mesh;
    norma_node_info node;
    norma_drawn_mesh drawn;
    document_bytes bytes = tiles_apart();
    norma_document *document = open_every(bytes, &error);
    assert_non_null(document);
    document_bytes written = bytes_of(document);
    assert_true(bytes_equal(bytes, written));
    bytes_free(&written);
    assert_int_equal(norma_document_mesh_count(document), 2);
    assert_int_equal(norma_document_node_count(document), 2);
    assert_int_equal(norma_document_mesh_info(document, 1, &mesh), NORMA_DOCUMENT_OK);
    assert_string_equal(mesh.where, "/tiles/1/meshes/0/primitives/0");
    assert_int_equal(norma_document_node_info(document, 1, &node), NORMA_DOCUMENT_OK);
    assert_int_equal(node.mesh, mesh.mesh);
    assert_int_equal(mesh.mesh, 1);
    assert_string_equal(node.where, "/tiles/1/nodes/0");
    assert_int_equal(
        norma_document_drawn_mesh(document, 1, 0, 1, &drawn, &error), NORMA_DOCUMENT_OK);
    /* a tile's z points up, a model's y */
    assert_true(drawn.world[12] == 4 && drawn.world[13] == 6 && drawn.world[14] == -2);
    assert_int_equal(norma_document_compute(document, NULL, &summary, &error), NORMA_DOCUMENT_OK);
    assert_int_equal(summary.faces, 4);
    assert_int_equal(summary.vertices_before, 8);
    assert_int_equal(summary.vertices_after, 12);
    assert_int_equal(norma_document_mesh_info(document, 1, &mesh), NORMA_DOCUMENT_OK);
    assert_int_equal(mesh.vertices, 6);
    norma_document_close(document);
    bytes_free(&bytes);
    (void)state;
}

/* Each would be turned where its own frame begins. */
static void test_frames_apart(void **state) {
    norma_transform_options moved = {.struct_size = sizeof moved,
                                .matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1}},
                            baked = {.struct_size = sizeof baked, .bake = 1}, scaled = moved;
    const norma_transform_options *const fine[] = {&moved, &baked};
    document_bytes bytes = tiles_apart();
    norma_document_error error = {0};
    scaled.matrix[0] = 2;
    for (size_t i = 0; i < 2; ++i) {
        norma_document *document = open_every(bytes, &error);
        assert_int_equal(
            norma_document_transform(document, fine[i], NULL, &error), NORMA_DOCUMENT_OK);
        norma_document_close(document);
    }
    norma_document *document = open_every(bytes, &error);
    assert_int_equal(norma_document_transform(document, &scaled, NULL, &error),
        NORMA_DOCUMENT_ERROR_UNSUPPORTED);
    assert_non_null(strstr(error.message, "its tiles stand in frames of their own"));
    norma_document_close(document);
    bytes_free(&bytes);
    (void)state;
}

/* Baking gives each node a mesh of its own: what was told of fewer meshes is told anew. */
static void test_more_meshes(void **state) {
    document_bytes glb =
        roof_drawn_by("{\"mesh\":0,\"children\":[1,2]},{\"mesh\":0,\"scale\":[1,2,3]},"
                      "{\"mesh\":0,\"scale\":[3,2,1]}");
    const norma_transform_options bake = {.struct_size = sizeof bake, .bake = 1};
    made_tile one = {.size = 0};
    norma_document_error error = {0};
    norma_mesh_info mesh;
    add_model(&one, glb, 0, 0);
    const made_tile composite = composite_of(&one, &one);
    document_bytes bytes = bytes_copy(composite.bytes, composite.size);
    norma_document *document = open_every(bytes, &error);
    assert_non_null(document);
    assert_int_equal(norma_document_mesh_count(document), 2);
    for (size_t i = 0; i < 2; ++i)
        assert_int_equal(norma_document_mesh_info(document, i, &mesh), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_transform(document, &bake, NULL, &error), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_mesh_count(document), 6);
    for (size_t i = 0; i < 6; ++i) {
        assert_int_equal(norma_document_mesh_info(document, i, &mesh), NORMA_DOCUMENT_OK);
        char where[60];
        snprintf(where, sizeof where, "/tiles/%zu/meshes/%zu/primitives/0", i / 3, i % 3);
        assert_string_equal(mesh.where, where);
        assert_int_equal(mesh.mesh, i);
    }
    norma_document_close(document);
    bytes_free(&bytes);
    bytes_free(&glb);
    (void)state;
}

/* One more than are read. */
static void test_too_many(void **state) {
    enum { COUNT = 1025, TILE = 28 };
    unsigned char *all = calloc(16 + COUNT * TILE, 1);
    made_tile head = {.size = 0}, tile = {.size = 0};
    norma_document_error error = {0};
    assert_non_null(all);
    add(&head, "cmpt", 4);
    add_u32(&head, 1);
    add_u32(&head, 16 + COUNT * TILE);
    add_u32(&head, COUNT);
    add(&tile, "b3dm", 4);
    add_u32(&tile, 1);
    add_u32(&tile, TILE);
    memcpy(all, head.bytes, head.size);
    for (size_t i = 0; i < COUNT; ++i) memcpy(all + 16 + i * TILE, tile.bytes, tile.size);
    document_bytes bytes = bytes_copy(all, 16 + COUNT * TILE);
    assert_null(open_every(bytes, &error));
    assert_string_equal(error.message,
        "a.cmpt: the composite has 1025 tiles with meshes, more than the 1024 that are read; split "
        "it");
    bytes_free(&bytes);
    free(all);
    (void)state;
}

/* Each level is 16 bytes, so a small file could nest thousands deep. */
static void test_nested(void **state) {
    made_tile deep = {.size = 0};
    for (size_t level = 0; level < 12; ++level) {
        add(&deep, "cmpt", 4);
        add_u32(&deep, 1);
        add_u32(&deep, 16 * (12 - level));
        add_u32(&deep, 1);
    }
    expect_refused(&deep, "a.cmpt", NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        "a.cmpt:byte 128: composite tiles are nested more than eight deep");
    (void)state;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_models),
        cmocka_unit_test(test_untouched),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_left_out),
        cmocka_unit_test(test_several),
        cmocka_unit_test(test_changes_of_several),
        cmocka_unit_test(test_several_as_one),
        cmocka_unit_test(test_frames_apart),
        cmocka_unit_test(test_more_meshes),
        cmocka_unit_test(test_hollow),
        cmocka_unit_test(test_too_many),
        cmocka_unit_test(test_nested),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
