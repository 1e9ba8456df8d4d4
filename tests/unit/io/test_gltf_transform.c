/* Transforms of glTF, case by case: small assets written here, each with one thing that is easily
 * got wrong, and every asset of the data set. What is drawn is read before and after through the
 * public functions and put into world space by the tests' own arithmetic; nodes and accessors are
 * looked up in the output's JSON. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include "gltf_scene.h"
#include "io/text/text.h"
#include "mesh_files.h"

/* ---- assets */

typedef struct asset {
    char text[20000];
} asset;

static void add_base64(char *text, const unsigned char *bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *at = text + strlen(text);
    for (size_t i = 0; i < size; i += 3) { /* sizes here are multiples of 12 */
        const unsigned v = (unsigned)bytes[i] << 16 | (unsigned)bytes[i + 1] << 8 | bytes[i + 2];
        for (int k = 18; k >= 0; k -= 6) *at++ = digits[v >> k & 63];
    }
    *at = 0;
}

/* Six vertices of a bent sheet with normals, tangents, morph deltas and six corners: accessors 0
 * POSITION, 1 NORMAL, 2 TANGENT, 3 position deltas, 4 normal deltas, 5 indices of a list (or a
 * strip, or a fan). rest: the members of the root besides buffers, bufferViews and accessors. */
static const float sheet[6][3] = {
    {0, 0, 0}, {1, 0, 0.1f}, {0.1f, 1, 0.2f}, {1.2f, 1.1f, -0.3f}, {0, 2, 0.5f}, {1, 2.2f, 0.7f}};

static void make_asset(asset *a, const char *rest) {
    struct {
        float position[6][3], normal[6][3], tangent[6][4], moved[6][3], turned[6][3];
        uint16_t corners[6];
    } data;
    memset(&data, 0, sizeof data);
    memcpy(data.position, sheet, sizeof sheet);
    for (int i = 0; i < 6; ++i) {
        const double angle = 0.25 * i - 0.5; /* the third normal is +Z */
        data.normal[i][0] = (float)(sin(angle) * 0.6);
        data.normal[i][1] = (float)(sin(angle) * 0.8);
        data.normal[i][2] = (float)cos(angle);
        data.tangent[i][0] = 0.6f; /* not perpendicular */
        data.tangent[i][1] = -0.8f;
        data.tangent[i][3] = i % 2 ? 1.0f : -1.0f;
        data.moved[i][i % 3] = 0.5f;
        data.turned[i][(i + 1) % 3] = -0.25f;
        data.corners[i] = (uint16_t)i;
    }
    const size_t parts[6] = {sizeof data.position, sizeof data.normal, sizeof data.tangent,
        sizeof data.moved, sizeof data.turned, sizeof data.corners};
    static const char *const types[6] = {"VEC3", "VEC3", "VEC4", "VEC3", "VEC3", "SCALAR"};
    char *text = a->text;
    size_t offset = 0;
    strcpy(text, "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":396,\"uri\":\"data:"
                 "application/octet-stream;base64,");
    assert_int_equal(sizeof data, 396);
    add_base64(text, (const unsigned char *)&data, sizeof data);
    strcat(text, "\"}],\n\"bufferViews\":[");
    for (int i = 0; i < 6; ++i) {
        sprintf(text + strlen(text),
            "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":%d}", i ? "," : "",
            offset, parts[i], i < 5 ? 34962 : 34963);
        offset += parts[i];
    }
    strcat(text, "],\n\"accessors\":[");
    for (int i = 0; i < 6; ++i)
        sprintf(text + strlen(text),
            "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":6,\"type\":\"%s\"%s}",
            i ? "," : "", i, i < 5 ? 5126 : 5123, types[i],
            i == 0   ? ",\"min\":[0,0,-0.3],\"max\":[1.2,2.2,0.7]"
            : i == 3 ? ",\"min\":[0,0,0],\"max\":[0.5,0.5,0.5]"
                     : "");
    strcat(text, "],\n");
    strcat(text, rest);
    strcat(text, "}\n");
    assert_true(strlen(text) < sizeof a->text);
}

#define PRIMITIVE "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2},\"indices\":5}"
#define MESH      "\"meshes\":[{\"name\":\"m\",\"primitives\":[" PRIMITIVE "]}]"

/* ---- transforming them */

typedef struct result {
    norma_document *before,
        *after; /* after: the output, opened again; NULL where the transform failed */
    unsigned char *bytes;
    size_t size;
    norma_transform_summary summary;
    norma_document_error error;
    norma_document_result code;
    json json; /* of the output, where it is a .gltf */
} result;

static void rows_to_columns(const double *rows, double matrix[16]) {
    for (int i = 0; rows && i < 16; ++i) matrix[i] = rows[i % 4 * 4 + i / 4];
}

static void run_on(norma_document *document, norma_document *before, const double *rows, int bake,
    const char *name, result *r) {
    norma_transform_options options = {.struct_size = sizeof options, .bake = bake};
    rows_to_columns(rows, options.matrix);
    memset(r, 0, sizeof *r);
    r->before = before;
    r->code = norma_document_transform(document, &options, &r->summary, &r->error);
    if (r->code != NORMA_DOCUMENT_OK) return;
    r->bytes = scene_output(document, &r->size);
    r->after = scene_reopen(r->bytes, r->size, name);
}

static void run(const asset *a, const double *rows, int bake, result *r) {
    norma_document *document =
        scene_reopen((const unsigned char *)a->text, strlen(a->text), "asset.gltf");
    run_on(document, scene_reopen((const unsigned char *)a->text, strlen(a->text), "asset.gltf"),
        rows, bake, "out.gltf", r);
    json_error error;
    if (r->after)
        assert_true(norma_json_parse((const char *)r->bytes, r->size, NULL, &r->json, &error));
    norma_document_close(document);
}

static void finish(result *r) {
    norma_json_free(&r->json);
    norma_document_close(r->before);
    norma_document_close(r->after);
    free(r->bytes);
}

static void assert_done(const result *r) {
    if (r->code != NORMA_DOCUMENT_OK) fail_msg("%s", r->error.message);
}

/* ---- what is drawn */

static void apply(const double *rows, const double p[3], double out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] = rows ? rows[4 * k] * p[0] + rows[4 * k + 1] * p[1] + rows[4 * k + 2] * p[2] +
                            rows[4 * k + 3]
                      : p[k];
}

static void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* A triangle of the input under the matrix: as the matrix's three rows say, mirrors turned round,
 * normals by cofactors. */
static scene_triangle expected_triangle(const scene_triangle *in, const double *rows) {
    scene_triangle out = *in;
    if (!rows) return out;
    double cofactor[3][3]; /* rows of cof(M): cross products of M's rows */
    for (int k = 0; k < 3; ++k)
        cross(rows + 4 * ((k + 1) % 3), rows + 4 * ((k + 2) % 3), cofactor[k]);
    const double determinant = dot(rows, cofactor[0]);
    for (int i = 0; i < 3; ++i) {
        const int from = determinant < 0 && i ? 3 - i : i;
        apply(rows, in->position[from], out.position[i]);
        double length = 0;
        for (int k = 0; k < 3; ++k) {
            out.normal[i][k] = dot(cofactor[k], in->normal[from]) * (determinant < 0 ? -1 : 1);
            length += out.normal[i][k] * out.normal[i][k];
        }
        for (int k = 0; k < 3 && length > 0; ++k) out.normal[i][k] /= sqrt(length);
    }
    return out;
}

static int same_triangle(
    const scene_triangle *a, const scene_triangle *b, double tolerance, double degrees) {
    for (int turn = 0; turn < 3; ++turn) {
        int same = 1;
        for (int i = 0; i < 3 && same; ++i) {
            const int k = (i + turn) % 3;
            for (int c = 0; c < 3; ++c)
                same &= fabs(a->position[i][c] - b->position[k][c]) <= tolerance;
            same = same && scene_angle_deg(a->normal[i], b->normal[k]) <= degrees;
        }
        if (same) return 1;
    }
    return 0;
}

/* Every triangle of the input, under the matrix, is one of the output, and there are as many. */
static void assert_same_scene(const result *r, const double *rows, double degrees) {
    drawn_scene before, after;
    scene_read(r->before, &before);
    scene_read(r->after, &after);
    const double tolerance = 1e-6 * scene_largest(&after);
    assert_true(before.count > 0);
    assert_int_equal(before.count, after.count);
    for (size_t i = 0; i < before.count; ++i) {
        const scene_triangle expected = expected_triangle(&before.triangles[i], rows);
        size_t found = i;
        if (!same_triangle(&expected, &after.triangles[i], tolerance, degrees))
            for (found = 0; found < after.count &&
                            !same_triangle(&expected, &after.triangles[found], tolerance, degrees);)
                ++found;
        if (found == after.count)
            fail_msg("triangle %zu of node %zu, now at %g %g %g, is not in the output", i,
                expected.node, expected.position[0][0], expected.position[0][1],
                expected.position[0][2]);
    }
    scene_free(&before);
    scene_free(&after);
}

static void assert_identities(norma_document *document) {
    for (size_t i = 0; i < norma_document_node_count(document); ++i) {
        norma_node_info info;
        assert_int_equal(norma_document_node_info(document, i, &info), NORMA_DOCUMENT_OK);
        for (int k = 0; k < 16; ++k)
            if (fabs(info.world[k] - (k % 5 == 0)) > 1e-9)
                fail_msg("node %zu draws, and element %d of its world matrix is %g", info.node, k,
                    info.world[k]);
    }
}

static const char *note_of(const norma_document *document, const char *part) {
    for (size_t i = 0; i < norma_document_note_count(document); ++i)
        if (strstr(norma_document_note(document, i), part)) return norma_document_note(document, i);
    return NULL;
}

/* ---- the output's JSON */

static uint32_t node_token(const result *r, uint32_t number) {
    return norma_json_element(&r->json, norma_json_member(&r->json, 0, "nodes"), number);
}

static void node_numbers(
    const result *r, uint32_t number, const char *key, double *out, uint32_t count) {
    const uint32_t list = norma_json_member(&r->json, node_token(r, number), key);
    for (uint32_t i = 0; list != JSON_NONE && i < count; ++i)
        assert_true(norma_json_number(&r->json, norma_json_element(&r->json, list, i), &out[i]));
}

static void node_local(const result *r, uint32_t number, double m[16]) {
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    node_numbers(r, number, "translation", t, 3);
    node_numbers(r, number, "rotation", q, 4);
    node_numbers(r, number, "scale", s, 3);
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double composed[16] = {(1 - 2 * (y * y + z * z)) * s[0], 2 * (x * y + z * w) * s[0],
        2 * (x * z - y * w) * s[0], 0, 2 * (x * y - z * w) * s[1], (1 - 2 * (x * x + z * z)) * s[1],
        2 * (y * z + x * w) * s[1], 0, 2 * (x * z + y * w) * s[2], 2 * (y * z - x * w) * s[2],
        (1 - 2 * (x * x + y * y)) * s[2], 0, t[0], t[1], t[2], 1};
    memcpy(m, composed, sizeof composed);
    node_numbers(r, number, "matrix", m, 16);
}

static uint32_t node_parent(const result *r, uint32_t number) {
    const uint32_t nodes = norma_json_member(&r->json, 0, "nodes");
    for (uint32_t i = 0; i < norma_json_size(&r->json, nodes); ++i) {
        const uint32_t children = norma_json_member(&r->json, node_token(r, i), "children");
        for (uint32_t child = JSON_NONE; norma_json_each(&r->json, children, &child);) {
            uint64_t is;
            if (norma_json_uint(&r->json, child, &is) && is == number) return i;
        }
    }
    return JSON_NONE;
}

static void node_world(const result *r, uint32_t number, double world[16]) {
    node_local(r, number, world);
    for (uint32_t above = node_parent(r, number); above != JSON_NONE;
         above = node_parent(r, above)) {
        double local[16], product[16] = {0};
        node_local(r, above, local);
        for (int i = 0; i < 16; ++i)
            for (int k = 0; k < 4; ++k) product[i] += local[i % 4 + 4 * k] * world[i / 4 * 4 + k];
        memcpy(world, product, sizeof product);
    }
}

/* rows: the upper three of the expected matrix. */
static void assert_world(const result *r, uint32_t number, const double rows[12]) {
    double world[16];
    node_world(r, number, world);
    for (int i = 0; i < 12; ++i)
        if (fabs(world[i % 4 * 4 + i / 4] - rows[i]) > 1e-9)
            fail_msg("node %u: row %d, column %d of the world matrix is %g, expected %g", number,
                i / 4, i % 4, world[i % 4 * 4 + i / 4], rows[i]);
}

static int has_member(const result *r, uint32_t number, const char *key) {
    return norma_json_member(&r->json, node_token(r, number), key) != JSON_NONE;
}

static uint32_t count_of(const result *r, const char *key) {
    return norma_json_size(&r->json, norma_json_member(&r->json, 0, key));
}

static const double doubled[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
static const double mirror[16] = {-1, 0, 0, 3, 0, 2, 0, 0, 0, 0, 0.5, -1, 0, 0, 0, 1};
static const double sheared[16] = {1, 0.5, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double flat[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
static const double pressed[16] = {0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
static const double line[16] = {1, 2, 3, 0, 2, 4, 6, 0, 0, 0, 0, 0, 0, 0, 0, 1};
static const double tilted[16] = {0.6, -0.8, 0, 5, 0.8, 0.6, 0, -7, 0, 0, 3, 1, 0, 0, 0, 1};

/* ---- without baking */

static void test_identity_is_the_input(void **state) {
    (void)state;
    asset a;
    make_asset(&a, MESH ",\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]");
    for (int bake = 0; bake < 2; ++bake) {
        result r;
        run(&a, NULL, bake, &r);
        assert_done(&r);
        assert_false(r.summary.changed);
        assert_int_equal(r.size, strlen(a.text));
        assert_memory_equal(r.bytes, a.text, r.size);
        finish(&r);
    }
}

static void test_node_above_roots(void **state) {
    (void)state;
    asset a;
    make_asset(&a, MESH ",\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[1,2,3]},{"
                        "\"children\":[1]}],\"scenes\":[{\"nodes\":[0,2]}]");
    result r;
    run(&a, tilted, 0, &r);
    assert_done(&r);
    assert_true(r.summary.changed && !r.summary.mirrored && r.summary.nodes_baked == 0);
    assert_same_scene(&r, tilted, 1e-4);
    assert_int_equal(count_of(&r, "nodes"), 4);
    assert_int_equal(node_parent(&r, 0), 3);
    assert_int_equal(node_parent(&r, 2), 3);
    assert_world(&r, 3, tilted);
    assert_non_null(strstr((char *)r.bytes, "\"scenes\":[{\"nodes\":[3]}]"));
    assert_non_null(
        strstr((char *)r.bytes, "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[1,2,3]},{"
                                "\"children\":[1]},")); /* old nodes keep their bytes */
    finish(&r);

    run(&a, mirror, 0, &r);
    assert_done(&r);
    assert_true(r.summary.mirrored);
    assert_same_scene(&r, mirror, 1e-4);
    finish(&r);
}

/* Scene 0 shows nodes 0 and 1, scene 1 shows 1 and 2, no scene shows 3: no new node may show what
 * its scene did not. */
static void test_scenes_that_share_roots(void **state) {
    (void)state;
    asset a;
    make_asset(&a, MESH ",\"nodes\":[{\"mesh\":0},{\"mesh\":0},{\"mesh\":0},{\"mesh\":0}],"
                        "\"scenes\":[{\"nodes\":[0,1]},{\"nodes\":[1,2]},{}]");
    result r;
    run(&a, doubled, 0, &r);
    assert_done(&r);
    assert_int_equal(count_of(&r, "nodes"), 8);
    for (uint32_t i = 0; i < 4; ++i) {
        assert_world(&r, i, doubled);
        for (uint32_t k = 0; k < i; ++k)
            assert_int_not_equal(node_parent(&r, i), node_parent(&r, k));
    }
    char expected[100];
    sprintf(expected, "\"scenes\":[{\"nodes\":[%u,%u]},{\"nodes\":[%u,%u]},{}]", node_parent(&r, 0),
        node_parent(&r, 1), node_parent(&r, 1), node_parent(&r, 2));
    assert_non_null(strstr((char *)r.bytes, expected));
    finish(&r);
}

static void test_no_scenes_no_nodes(void **state) {
    (void)state;
    asset a;
    result r;
    make_asset(&a, MESH ",\"nodes\":[{\"mesh\":0},{\"mesh\":0}]");
    run(&a, doubled, 0, &r);
    assert_done(&r);
    assert_same_scene(&r, doubled, 1e-4);
    assert_world(&r, 0, doubled);
    finish(&r);

    make_asset(&a, MESH ",\"scenes\":[{}]");
    run(&a, doubled, 0, &r);
    assert_done(&r);
    assert_false(r.summary.changed);
    assert_memory_equal(r.bytes, a.text, strlen(a.text));
    finish(&r);
}

static void test_shear_needs_baking(void **state) {
    (void)state;
    asset a;
    result r;
    make_asset(&a,
        MESH ",\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[1,2,3]}],\"cameras\":[{"
             "\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}]");
    run(&a, sheared, 0, &r);
    assert_int_equal(r.code, NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_non_null(strstr(r.error.message, "--bake"));
    finish(&r);
    run(&a, sheared, 1, &r);
    assert_done(&r);
    assert_same_scene(&r, sheared, 1e-4);
    assert_identities(r.after);
    const double camera[12] = {
        1, 0.5, 0, 2, 0, 1, 0, 2, 0, 0, 1, 3}; /* by two nodes: one cannot hold it */
    assert_world(&r, 1, camera);
    finish(&r);
}

static void assert_flat(const result *r, int axis) {
    drawn_scene after;
    scene_read(r->after, &after);
    assert_true(after.count > 0);
    for (size_t i = 0; i < after.count; ++i)
        for (int k = 0; k < 3; ++k) {
            assert_true(after.triangles[i].position[k][axis] == 0);
            assert_true(fabs(after.triangles[i].normal[k][axis]) == 1);
        }
    scene_free(&after);
}

static void test_flat_matrix(void **state) {
    (void)state;
    asset a;
    result r;
    make_asset(&a, MESH ",\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}]");
    run(&a, flat, 0, &r);
    assert_done(&r);
    assert_world(&r, 1, flat);
    assert_non_null(strstr(
        (char *)r.bytes, "\"scale\":[1,1,0]")); /* as "matrix" no reader could take it apart */
    finish(&r);
    run(&a, flat, 1, &r);
    assert_done(&r);
    assert_flat(&r, 2);
    finish(&r);
    run(&a, pressed, 1,
        &r); /* a plane that stands: the third normal lies in it, and becomes the plane's */
    assert_done(&r);
    assert_flat(&r, 0);
    finish(&r);
    run(&a, line, 1, &r); /* no normal exists */
    assert_done(&r);
    assert_flat(&r, 2);
    finish(&r);
}

/* ---- baking */

static void test_bake_hierarchy(void **state) {
    (void)state;
    asset a;
    make_asset(&a,
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}]," MESH
        ",\"nodes\":[{\"name\":\"group\",\"scale\":[2,1,1],\"children\":[1]},{\"mesh\":0,"
        "\"rotation\":[0,0,0.6,0.8],\"translation\":[1,0,0],\"children\":[2,3,4]},{\"mesh\":0,"
        "\"scale\":[1,-3,1]},{\"camera\":0,\"translation\":[0,0,5]},{\"mesh\":0,\"camera\":0,"
        "\"translation\":[0,1,0],\"children\":[5]},{\"name\":\"empty\"}],\"scenes\":[{\"nodes\":[0]"
        "}]");
    result r;
    run(&a, NULL, 1, &r);
    assert_done(&r);
    assert_int_equal(r.summary.nodes_baked, 3);
    assert_int_equal(r.summary.meshes, 3);
    assert_int_equal(r.summary.vertices, 18);
    assert_true(r.summary.mirrored);
    assert_same_scene(&r, NULL, 1e-3);
    assert_identities(r.after);
    /* scale (2,1,1) after the rotation by atan2(0.96, 0.28), translated by (1,0,0) */
    const double group[12] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const double camera[12] = {0.56, -1.92, 0, 2, 0.96, 0.28, 0, 0, 0, 0, 1, 5};
    const double both[12] = {0.56, -1.92, 0, 0.08, 0.96, 0.28, 0, 0.28, 0, 0, 1, 0};
    assert_world(&r, 0, group);
    assert_world(&r, 3, camera);
    assert_world(&r, 4, both);
    assert_world(&r, 5, both);
    assert_true(has_member(&r, 4, "camera") && !has_member(&r, 4, "mesh"));
    assert_true(has_member(&r, 1, "mesh") && has_member(&r, 2, "mesh"));
    assert_int_equal(count_of(&r, "meshes"), 3);
    finish(&r);

    run(&a, tilted, 1, &r); /* cameras go along */
    assert_done(&r);
    assert_same_scene(&r, tilted, 1e-3);
    assert_identities(r.after);
    double moved[12];
    for (int i = 0; i < 12; ++i)
        moved[i] = tilted[i / 4 * 4] * camera[i % 4] + tilted[i / 4 * 4 + 1] * camera[4 + i % 4] +
                   tilted[i / 4 * 4 + 2] * camera[8 + i % 4] + (i % 4 == 3 ? tilted[i] : 0);
    assert_world(&r, 3, moved);
    finish(&r);
}

/* A group that holds nothing but baked nodes draws nothing, and stays where it was, whatever the
 * matrix. */
static void test_bake_groups_stay(void **state) {
    (void)state;
    asset a;
    make_asset(&a, MESH ",\"nodes\":[{\"translation\":[0,0,7],\"children\":[1]},{\"mesh\":0,"
                        "\"scale\":[2,2,2]}],\"scenes\":[{\"nodes\":[0]}]");
    result r;
    run(&a, mirror, 1, &r);
    assert_done(&r);
    assert_same_scene(&r, mirror, 1e-4);
    assert_identities(r.after);
    const double group[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 7};
    assert_world(&r, 0, group);
    assert_int_equal(count_of(&r, "nodes"), 2);
    finish(&r);
}

static void test_bake_below_flat_group(void **state) {
    (void)state;
    asset a;
    make_asset(&a, MESH ",\"nodes\":[{\"scale\":[1,1,0],\"children\":[1,2]},{\"mesh\":0},{}],"
                        "\"scenes\":[{\"nodes\":[0]}]");
    result r;
    run(&a, NULL, 1, &r);
    assert_done(&r);
    assert_identities(r.after);
    assert_non_null(strstr((char *)r.bytes,
        "\"scenes\":[{\"nodes\":[0,1]}]")); /* no matrix undoes that of the group */
    assert_world(&r, 2, flat);
    finish(&r);
}

static void test_shared_mesh(void **state) {
    (void)state;
    asset a;
    make_asset(&a, MESH ",\"nodes\":[{\"mesh\":0,\"translation\":[1,2,3]},{\"mesh\":0},{\"mesh\":0,"
                        "\"translation\":[3,2,1]},{\"mesh\":0,\"translation\":[1,2,3]}]");
    result r;
    run(&a, NULL, 1, &r);
    assert_done(&r);
    assert_int_equal(r.summary.nodes_baked, 3);
    assert_same_scene(&r, NULL, 1e-4);
    assert_int_equal(count_of(&r, "meshes"), 4); /* node 1 keeps mesh 0 as it is */
    assert_int_equal(
        count_of(&r, "accessors"), 8); /* positions alone, and once where the matrices are equal */
    finish(&r);
}

static void test_what_stays_is_named(void **state) {
    (void)state;
    asset a;
    make_asset(&a,
        "\"animations\":[{\"samplers\":[{\"input\":5,\"output\":0}],\"channels\":[{\"sampler\":0,"
        "\"target\":{\"node\":0,\"path\":\"translation\"}},{\"sampler\":0,\"target\":{\"node\":2,"
        "\"path\":\"weights\"}}]}],\"skins\":[{\"joints\":[4]}]," MESH
        ",\"nodes\":[{\"name\":\"wheel\",\"mesh\":0,\"scale\":[1,2,1],\"children\":[1]},{\"name\":"
        "\"hub\",\"mesh\":0,\"scale\":[2,2,3]},{\"mesh\":0,\"scale\":[2,2,1]},{\"name\":\"body\","
        "\"mesh\":0,\"skin\":0},{\"name\":\"bone\",\"translation\":[1,1,1]}]");
    result r;
    run(&a, NULL, 1, &r);
    assert_done(&r);
    assert_int_equal(r.summary.nodes_baked, 1);
    finish(&r);
    norma_document *document =
        scene_reopen((const unsigned char *)a.text, strlen(a.text), "asset.gltf");
    run_on(document, scene_reopen((const unsigned char *)a.text, strlen(a.text), "asset.gltf"),
        doubled, 1, "out.gltf", &r);
    assert_done(&r);
    json_error error;
    assert_true(norma_json_parse((const char *)r.bytes, r.size, NULL, &r.json, &error));
    assert_non_null(note_of(document, "\"wheel\""));
    assert_non_null(note_of(document, "\"hub\""));
    assert_non_null(note_of(document, "\"body\""));
    assert_null(note_of(document, "node 2"));
    const double wheel[12] = {2, 0, 0, 0, 0, 4, 0, 0, 0, 0, 2, 0},
                 bone[12] = {2, 0, 0, 2, 0, 2, 0, 2, 0, 0, 2, 2};
    assert_world(&r, 0, wheel);
    assert_world(&r, 4, bone);
    assert_int_equal(node_parent(&r, 3), JSON_NONE); /* a skinned mesh goes by its joints */
    assert_same_scene(&(result){.before = r.before, .after = r.before}, NULL, 0);
    norma_document_close(document);
    finish(&r);
}

#define MODE_MESH(mode, indices)                                                                   \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}" indices           \
    ",\"mode\":" mode "}]}]"
#define SCALED(mesh) mesh ",\"nodes\":[{\"mesh\":0,\"scale\":[1,-2,1]}]"

/* Positions as whole numbers stay so as long as they can; else they become floats. */
static void test_integer_positions(void **state) {
    (void)state;
    static const struct {
        const char *place, *expected;
    } cases[] = {{"\"translation\":[1,2,3]", "\"componentType\":5123"},
        {"\"rotation\":[0,0,0,1],\"scale\":[2,1,3]", "\"componentType\":5123"},
        {"\"scale\":[0.5,0.25,1]", "\"componentType\":5126"},
        {"\"translation\":[-1,0,0]", "\"componentType\":5126"},
        {"\"scale\":[70000,1,1]", "\"componentType\":5126"}};
    const uint16_t corners[3][4] = {{0, 0, 0, 0}, {10, 1, 0, 0}, {0, 21, 5, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        asset a;
        strcpy(a.text,
            "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"KHR_mesh_quantization\"],"
            "\"extensionsRequired\":[\"KHR_mesh_quantization\"],\"buffers\":[{\"byteLength\":24,"
            "\"uri\":\"data:application/octet-stream;base64,");
        add_base64(a.text, (const unsigned char *)corners, sizeof corners);
        sprintf(a.text + strlen(a.text),
            "\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":24,\"byteStride\":8,\"target\":"
            "34962}],\"accessors\":[{\"bufferView\":0,\"componentType\":5123,\"count\":3,\"type\":"
            "\"VEC3\",\"min\":[0,0,0],\"max\":[10,21,5]}],\"meshes\":[{\"primitives\":[{"
            "\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0,%s}]}",
            cases[i].place);
        result r;
        run(&a, NULL, 1, &r);
        assert_done(&r);
        assert_true(r.summary.changed);
        assert_same_scene(&r, NULL, 180);
        if (!strstr((const char *)r.bytes, cases[i].expected))
            fail_msg("%s: there should be %s in %.*s here", cases[i].place, cases[i].expected,
                (int)r.size, (const char *)r.bytes);
        finish(&r);
    }
}

/* KHR_animation_pointer names nodes by JSON pointers. */
static void test_animation_pointers(void **state) {
    (void)state;
    asset a;
    make_asset(&a, "\"animations\":[{\"samplers\":[{\"input\":5,\"output\":0}],\"channels\":[{"
                   "\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_"
                   "pointer\":{\"pointer\":\"/nodes/1/"
                   "scale\"}}}},{\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{"
                   "\"KHR_animation_pointer\":{\"pointer\":\"/nodes/0/extras\"}}}}]}]," MESH
                   ",\"nodes\":[{\"mesh\":0,\"scale\":[1,2,1]},{\"mesh\":0,\"scale\":[1,2,1]}]");
    result r;
    run(&a, NULL, 1, &r);
    assert_done(&r);
    assert_int_equal(r.summary.nodes_baked, 1);
    assert_true(has_member(&r, 1, "scale") && !has_member(&r, 0, "scale"));
    assert_same_scene(&r, NULL, 1e-4);
    finish(&r);
}

static void test_mirrored_primitives(void **state) {
    (void)state;
    static const char *const rests[] = {SCALED(MODE_MESH("4", ",\"indices\":5")),
        SCALED(MODE_MESH("4", "")), SCALED(MODE_MESH("5", ",\"indices\":5")),
        SCALED(MODE_MESH("5", "")), SCALED(MODE_MESH("6", ",\"indices\":5")),
        SCALED(MODE_MESH("6", ""))};
    for (size_t i = 0; i < sizeof rests / sizeof *rests; ++i) {
        asset a;
        make_asset(&a, rests[i]);
        for (int odd = 0; odd < 2; ++odd) {
            result r;
            if (odd) /* five corners, five vertices */
                for (char *at = a.text; (at = strstr(at, "\"count\":6")) != NULL;) at[8] = '5';
            run(&a, NULL, 1, &r);
            assert_done(&r);
            assert_true(r.summary.mirrored);
            assert_same_scene(&r, NULL, 1e-4);
            assert_identities(r.after);
            finish(&r);
        }
    }
}

/* Base plus delta through the node's matrix: what a renderer shows of a morphed vertex before, it
 * must show after. */
static void accessor_floats(const result *r, uint32_t accessor, double out[6][4], uint32_t *width) {
    const json *j = &r->json;
    const uint32_t token = norma_json_element(j, norma_json_member(j, 0, "accessors"), accessor);
    uint64_t view, offset = 0, view_offset = 0, stride = 0, buffer;
    *width = norma_json_equals(j, norma_json_member(j, token, "type"), "VEC4") ? 4 : 3;
    assert_true(norma_json_uint(j, norma_json_member(j, token, "bufferView"), &view));
    norma_json_uint(j, norma_json_member(j, token, "byteOffset"), &offset);
    const uint32_t object =
        norma_json_element(j, norma_json_member(j, 0, "bufferViews"), (uint32_t)view);
    norma_json_uint(j, norma_json_member(j, object, "byteOffset"), &view_offset);
    norma_json_uint(j, norma_json_member(j, object, "byteStride"), &stride);
    assert_true(norma_json_uint(j, norma_json_member(j, object, "buffer"), &buffer));
    char *uri = norma_json_string(
        j, norma_json_member(j,
               norma_json_element(j, norma_json_member(j, 0, "buffers"), (uint32_t)buffer), "uri"));
    const char *digits = strchr(uri, ',') + 1;
    static unsigned char bytes[20000];
    size_t size = 0;
    unsigned value = 0, bits = 0;
    for (; *digits && *digits != '='; ++digits) {
        const char c = *digits;
        value = value << 6 | (unsigned)(c >= 'a'   ? c - 'a' + 26
                                        : c >= 'A' ? c - 'A'
                                        : c == '+' ? 62
                                        : c == '/' ? 63
                                                   : c - '0' + 52);
        bits += 6;
        if (bits >= 8) bytes[size++] = (unsigned char)(value >> (bits -= 8));
    }
    free(uri);
    for (size_t i = 0; i < 6; ++i)
        for (size_t k = 0; k < *width; ++k) {
            float f;
            memcpy(
                &f, bytes + view_offset + offset + i * (stride ? stride : 4 * *width) + 4 * k, 4);
            out[i][k] = (double)f;
        }
}

static uint32_t attribute_of(const result *r, int target, const char *name) {
    const json *j = &r->json;
    const uint32_t mesh = norma_json_element(j, norma_json_member(j, 0, "meshes"), 0),
                   primitive = norma_json_element(j, norma_json_member(j, mesh, "primitives"), 0);
    const uint32_t object =
        target ? norma_json_element(j, norma_json_member(j, primitive, "targets"), 0)
               : norma_json_member(j, primitive, "attributes");
    uint64_t accessor;
    assert_true(norma_json_uint(j, norma_json_member(j, object, name), &accessor));
    return (uint32_t)accessor;
}

static void test_morphs_and_tangents(void **state) {
    (void)state;
    asset a;
    make_asset(&a, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,"
                   "\"TANGENT\":2},\"targets\":[{\"POSITION\":3,\"NORMAL\":4}],\"indices\":5}]}],"
                   "\"nodes\":[{\"mesh\":0,\"matrix\":[0,2,0,0,-1,0,0,0,0,0,-3,0,4,5,6,1]}]");
    result r, same;
    run(&a, NULL, 1, &r);
    run(&a, doubled, 0, &same); /* the contents as they were */
    assert_done(&r);
    /* M = (x, y, z) -> (-y, 2x, -3z) + (4, 5, 6); M^-T n = (-n_y, n_x / 2, -n_z / 3); mirrors? det
     * = 1*2*-3 < 0: yes */
    double p[6][4], d[6][4], n[6][4], e[6][4], t[6][4], p1[6][4], d1[6][4], n1[6][4], e1[6][4],
        t1[6][4];
    uint32_t width;
    accessor_floats(&same, attribute_of(&same, 0, "POSITION"), p, &width);
    accessor_floats(&same, attribute_of(&same, 0, "NORMAL"), n, &width);
    accessor_floats(&same, attribute_of(&same, 0, "TANGENT"), t, &width);
    accessor_floats(&same, attribute_of(&same, 1, "POSITION"), d, &width);
    accessor_floats(&same, attribute_of(&same, 1, "NORMAL"), e, &width);
    accessor_floats(&r, attribute_of(&r, 0, "POSITION"), p1, &width);
    accessor_floats(&r, attribute_of(&r, 0, "NORMAL"), n1, &width);
    accessor_floats(&r, attribute_of(&r, 0, "TANGENT"), t1, &width);
    accessor_floats(&r, attribute_of(&r, 1, "POSITION"), d1, &width);
    accessor_floats(&r, attribute_of(&r, 1, "NORMAL"), e1, &width);
    for (int i = 0; i < 6; ++i) {
        const double position[3] = {-p[i][1] + 4, 2 * p[i][0] + 5, -3 * p[i][2] + 6},
                     delta[3] = {-d[i][1], 2 * d[i][0], -3 * d[i][2]};
        const double normal[3] = {-n[i][1], n[i][0] / 2, -n[i][2] / 3},
                     turned[3] = {-e[i][1], e[i][0] / 2, -e[i][2] / 3};
        const double tangent[3] = {-t[i][1], 2 * t[i][0], -3 * t[i][2]},
                     length = sqrt(dot(normal, normal)),
                     along = dot(tangent, normal) / dot(normal, normal);
        double flat_tangent[3];
        for (int k = 0; k < 3; ++k) {
            assert_true(fabs(p1[i][k] - position[k]) < 1e-6 && fabs(d1[i][k] - delta[k]) < 1e-6);
            assert_true(fabs(n1[i][k] - normal[k] / length) < 1e-6 &&
                        fabs(e1[i][k] - turned[k] / length) < 1e-6);
            flat_tangent[k] = tangent[k] - along * normal[k];
        }
        assert_true(scene_angle_deg(t1[i], flat_tangent) < 1e-4 && fabs(dot(t1[i], n1[i])) < 1e-6 &&
                    fabs(dot(t1[i], t1[i]) - 1) < 1e-6);
        assert_true(t1[i][3] == -t[i][3]);
    }
    finish(&r);
    finish(&same);
}

/* ---- the data set */

static const double turned[16] = {0.6, 0, 1.6, 3, 0, -0.5, 0, -2, -0.8, 0, 1.2, 11, 0, 0, 0,
    1}; /* a rotation after scales (1, -0.5, 2) */

/* Sums that feel every position, every winding and every normal, and no order: the area, the
 * volume, and what normals say of facets. */
typedef struct sums {
    double area, volume, facing, size;
    int integers;
} sums;

static sums sum_scene(norma_document *document, const double *rows) {
    drawn_scene scene;
    scene_read(document, &scene);
    sums s = {0, 0, 0, 0, scene.integers};
    for (size_t i = 0; i < scene.count; ++i) {
        const scene_triangle t = expected_triangle(&scene.triangles[i], rows);
        double a[3], b[3], c[3];
        for (int k = 0; k < 3; ++k) {
            a[k] = t.position[1][k] - t.position[0][k];
            b[k] = t.position[2][k] - t.position[0][k];
            s.size = fmax(s.size, fabs(t.position[0][k]));
        }
        cross(a, b, c);
        s.area += sqrt(dot(c, c));
        s.volume += dot(c, t.position[0]);
        for (int k = 0; k < 3; ++k) s.facing += dot(c, t.normal[k]);
    }
    scene_free(&scene);
    return s;
}

static int is_gltf(const char *path) {
    const norma_file_format format = norma_file_format_of_path(path);
    return format == NORMA_FILE_GLTF || format == NORMA_FILE_GLB;
}

typedef struct tally {
    size_t opened, refused, failed, compared, baked_nodes;
} tally;

static void compare_sums(const char *name, const sums *a, const sums *b, const char *what) {
    const double area = fmax(a->area, 1e-300);
    if (fabs(a->area - b->area) > 2e-4 * area ||
        fabs(a->volume - b->volume) > 2e-4 * area * a->size ||
        fabs(a->facing - b->facing) > 6e-3 * area)
        fail_msg("%s, %s: area %g and %g, volume %g and %g, facing %g and %g", name, what, a->area,
            b->area, a->volume, b->volume, a->facing, b->facing);
}

static int has_instances(norma_document *document) {
    for (size_t i = 0; i < norma_document_node_count(document); ++i) {
        norma_node_info info;
        if (norma_document_node_info(document, i, &info) == NORMA_DOCUMENT_OK &&
            info.instances != 1)
            return 1;
    }
    return 0;
}

/* Broken files may fail, with a message; what opens and transforms must open again. */
static void transform_file(void *user, const char *path, const char *name) {
    tally *count = user;
    int skinned = 0;
    const int broken = strncmp(name, "bad/", 4) == 0;
    for (int bake = 1; bake >= 0 && is_gltf(path); --bake) {
        norma_document *document;
        norma_document_error error;
        if (norma_document_open(path, NULL, &document, &error) != NORMA_DOCUMENT_OK) {
            assert_true(strlen(error.message) > 10);
            ++count->refused;
            return;
        }
        result r;
        run_on(document, scene_open(path), turned, bake, path, &r);
        skinned |= note_of(document, "skinned") != NULL; /* those are not where their node is */
        if (r.code != NORMA_DOCUMENT_OK && !broken) fail_msg("%s: %s", name, r.error.message);
        if (r.code != NORMA_DOCUMENT_OK)
            ++count->failed;
        else if (!broken && !skinned && !has_instances(r.before)) {
            const sums a = sum_scene(r.before, turned), b = sum_scene(r.after, NULL);
            if (!a.integers) compare_sums(name, &a, &b, bake ? "baked" : "a node above");
            ++count->compared;
        }
        count->baked_nodes += r.summary.nodes_baked;
        norma_document_close(document);
        finish(&r);
    }
    count->opened += (size_t)is_gltf(path);
}

static void test_every_file(void **state) {
    (void)state;
    if (!data_folder()) skip();
    tally count = {0, 0, 0, 0, 0};
    data_for_each(data_folder(), transform_file, &count);
    print_message("# %zu glTF files transformed both ways, %zu nodes baked, %zu outputs compared; "
                  "of the broken ones %zu refused, %zu transforms failed\n",
        count.opened, count.baked_nodes, count.compared, count.refused, count.failed);
    assert_true(count.opened > 90);
}

static void test_named_files(void **state) {
    (void)state;
    if (!data_folder()) skip();
    static const struct {
        const char *name;
        double degrees;
    } files[] = {{"gltf/khronos/NegativeScaleTest/NegativeScaleTest.gltf", 0.01},
        {"gltf/misc/nonuniform-nested.glb", 0.01},
        {"gltf/blender/02_shared_mesh/02_shared_mesh.gltf", 0.01},
        {"gltf/blender/02_node_hierarchy/02_node_hierarchy.gltf", 0.01},
        {"gltf/quantized/avocado-quant.glb", 1.2}, {"gltf/quantized/avocado-meshopt.glb", 1.2},
        {"gltf/khronos/MultipleScenes/MultipleScenes.gltf", 0.01},
        {"gltf/misc/mirror/one_face_123_mirror.gltf", 0.01},
        {"gltf/khronos/VertexColorTest/VertexColorTest.gltf", 0.01},
        {"gltf/khronos/OrientationTest/OrientationTest.gltf", 0.01}};
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        char path[1000];
        snprintf(path, sizeof path, "%s/%s", data_folder(), files[i].name);
        for (int given = 0; given < 2; ++given) {
            norma_document *document = scene_open(path);
            result r;
            run_on(document, scene_open(path), given ? turned : NULL, 1, path, &r);
            if (r.code != NORMA_DOCUMENT_OK) fail_msg("%s: %s", files[i].name, r.error.message);
            assert_true(r.summary.changed || !given);
            assert_identities(r.after);
            assert_same_scene(&r, given ? turned : NULL, files[i].degrees);
            norma_document_close(document);
            finish(&r);
        }
    }
}

/* 125 instances of one cube: as many meshes, and the accessors of the instances' places serve the
 * new ones. */
static void test_instances(void **state) {
    (void)state;
    if (!data_folder()) skip();
    char path[1000];
    snprintf(
        path, sizeof path, "%s/gltf/khronos/SimpleInstancing/SimpleInstancing.gltf", data_folder());
    norma_document *document = scene_open(path);
    result r;
    run_on(document, scene_open(path), turned, 1, path, &r);
    assert_done(&r);
    json_error error;
    assert_true(norma_json_parse((const char *)r.bytes, r.size, NULL, &r.json, &error));
    assert_identities(r.after);
    assert_int_equal(norma_document_node_count(r.after), 125);
    assert_int_equal(count_of(&r, "meshes"), 125);
    assert_int_equal(count_of(&r, "accessors"),
        1 + 2 * 125); /* the indices, turned once for all; positions and normals */
    assert_null(strstr((const char *)r.bytes, "EXT_mesh_gpu_instancing"));
    drawn_scene after;
    scene_read(r.after, &after);
    assert_int_equal(after.count, 125 * 12);
    for (size_t i = 0; i < after.count;
         ++i) { /* flat cubes: stored normals are those of the facets */
        double facet[3];
        scene_facet_normal(&after.triangles[i], facet);
        assert_true(scene_angle_deg(facet, after.triangles[i].normal[0]) < 0.01);
    }
    scene_free(&after);
    norma_document_close(document);
    finish(&r);
}

static void test_skinned_and_animated_files(void **state) {
    (void)state;
    if (!data_folder()) skip();
    static const struct {
        const char *name, *note;
    } files[] = {{"gltf/khronos/Fox/Fox.gltf", "skinned"},
        {"gltf/khronos/RiggedSimple/RiggedSimple.gltf", "skinned"},
        {"gltf/khronos/SimpleSkin/SimpleSkin.gltf", "skinned"},
        {"gltf/khronos/InterpolationTest/InterpolationTest.gltf", "animated"}};
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        char path[1000];
        snprintf(path, sizeof path, "%s/%s", data_folder(), files[i].name);
        norma_document *document = scene_open(path);
        result r;
        run_on(document, scene_open(path), NULL, 1, path, &r);
        if (r.code != NORMA_DOCUMENT_OK) fail_msg("%s: %s", files[i].name, r.error.message);
        if (!note_of(document, files[i].note))
            fail_msg("%s: nothing says that it is %s", files[i].name, files[i].note);
        if (strcmp(files[i].note, "skinned") == 0) assert_false(r.summary.changed);
        norma_document_close(document);
        finish(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_identity_is_the_input),
        cmocka_unit_test(test_node_above_roots),
        cmocka_unit_test(test_scenes_that_share_roots),
        cmocka_unit_test(test_no_scenes_no_nodes),
        cmocka_unit_test(test_shear_needs_baking),
        cmocka_unit_test(test_flat_matrix),
        cmocka_unit_test(test_bake_hierarchy),
        cmocka_unit_test(test_bake_groups_stay),
        cmocka_unit_test(test_bake_below_flat_group),
        cmocka_unit_test(test_shared_mesh),
        cmocka_unit_test(test_what_stays_is_named),
        cmocka_unit_test(test_integer_positions),
        cmocka_unit_test(test_animation_pointers),
        cmocka_unit_test(test_mirrored_primitives),
        cmocka_unit_test(test_morphs_and_tangents),
        cmocka_unit_test(test_named_files),
        cmocka_unit_test(test_instances),
        cmocka_unit_test(test_skinned_and_animated_files),
        cmocka_unit_test(test_every_file),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
