/* test_stored_tangents.c: what computing normals does to the tangents that a glTF stores. A square
 * in the plane z = 0 whose normals lean by 30 degrees at two vertices; its tangents are
 * perpendicular to these. Everything expected follows from the square: new normals are (0, 0, 1);
 * texture coordinates are turned by 90 degrees, so that u grows along y. */
#include "check.h"
#include "document_bytes.h"
#include "gltf_asset.h"
#include <math.h>
#include <stddef.h>

static const float POSITIONS[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
static const float NORMALS[12] = {0.5f, 0, 0.8660254f, 0, 0, 1, 0, 0, 1, 0.5f, 0, 0.8660254f};
static const float TANGENTS[16] = {
    0.8660254f, 0, -0.5f, 1, 1, 0, 0, 1, 0.6f, 0.8f, 0, 1, 0.8660254f, 0, -0.5f, 1};
static const float TEXCOORDS[8] = {0, 0, 0, 1, 1, 1, 1, 0};
static const uint16_t CORNERS[6] = {0, 1, 2, 0, 2, 3};

static document_bytes square(gltf_asset *a, int texcoords, int bytes) {
    char rest[300];
    document_bytes made;
    asset_floats(a, POSITIONS, 4, 3);
    asset_floats(a, NORMALS, 4, 3);
    if (bytes)
        asset_snorm8(a, TANGENTS, 4, 4);
    else
        asset_floats(a, TANGENTS, 4, 4);
    asset_floats(a, TEXCOORDS, 4, 2);
    asset_uint16(a, CORNERS, 6);
    snprintf(rest, sizeof rest,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2%s}"
        ","
        "\"indices\":4}]}]",
        texcoords ? ",\"TEXCOORD_0\":3" : "");
    asset_bytes(a, rest, &made.size);
    made.data = a->glb;
    return made;
}

static void assert_near(float found, float expected, double bound) {
    assert_true(fabs((double)found - (double)expected) <= bound);
}

typedef struct answer {
    norma_compute_summary summary;
    float tangents[16];
} answer;

static answer compute(const norma_compute_options *options, int texcoords, int bytes) {
    gltf_asset a = {0};
    answer out;
    norma_mesh_attributes attributes;
    document_bytes made =
        bytes_computed(square(&a, texcoords, bytes), "a.glb", options, &out.summary);
    norma_document *document = bytes_open(made, "a.glb");
    assert_int_equal(
        norma_document_mesh_attributes(document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(attributes.tangent_count, 4);
    memcpy(out.tangents, attributes.tangents, sizeof out.tangents);
    norma_document_close(document);
    bytes_free(&made);
    asset_free(&a);
    return out;
}

static void assert_counts(const answer *a, size_t kept, size_t turned, size_t renewed) {
    assert_int_equal(a->summary.tangents_kept, kept);
    assert_int_equal(a->summary.tangents_orthogonalised, turned);
    assert_int_equal(a->summary.tangents_regenerated, renewed);
    assert_int_equal(a->summary.vertices_after, 4);
}

static const norma_compute_options KEEP = {.struct_size = sizeof KEEP,
                                       .tangents = NORMA_STORED_TANGENTS_KEEP},
                                   RENEW = {.struct_size = sizeof RENEW,
                                       .tangents = NORMA_STORED_TANGENTS_REGENERATE};

static void test_keep(void **state) {
    (void)state;
    const answer a = compute(&KEEP, 1, 0);
    assert_memory_equal(a.tangents, TANGENTS, sizeof TANGENTS);
    assert_counts(&a, 4, 0, 0);
}

/* The default: two tangents are right and stay, two are turned into the plane. */
static void assert_turned(const answer *a, double bound) {
    assert_counts(a, 2, 2, 0);
    for (size_t v = 0; v < 4; ++v) {
        const float *t = a->tangents + 4 * v;
        const int stays = v == 1 || v == 2;
        assert_near(t[0], stays ? TANGENTS[4 * v] : 1, bound);
        assert_near(t[1], stays ? TANGENTS[4 * v + 1] : 0, bound);
        assert_near(t[2], 0, bound);
        assert_true(t[3] == 1);
    }
}

static void test_orthogonalise(void **state) {
    (void)state;
    const answer a = compute(NULL, 1, 0), bytes = compute(NULL, 1, 1);
    assert_turned(&a, 1e-6);
    assert_memory_equal(a.tangents + 4, TANGENTS + 4, 8 * sizeof(float));
    assert_turned(&bytes, 1. / 127);
}

/* u grows along y. The area of the texture coordinates is negative, so w is 1 (v runs downwards).
 */
static void test_regenerate(void **state) {
    (void)state;
    const answer a = compute(&RENEW, 1, 0);
    assert_counts(&a, 0, 0, 4);
    assert_true(a.summary.changed);
    for (size_t v = 0; v < 4; ++v) {
        const float expected[4] = {0, 1, 0, 1};
        for (size_t k = 0; k < 4; ++k) assert_near(a.tangents[4 * v + k], expected[k], 1e-6);
    }
}

static void test_without_texcoords(void **state) {
    (void)state;
    const answer a = compute(&RENEW, 0, 0);
    assert_turned(&a, 1e-6);
}

/* A caller that was compiled before there was such a choice. */
static void test_older_caller(void **state) {
    (void)state;
    norma_compute_options options = RENEW;
    options.struct_size = offsetof(norma_compute_options, tangents);
    const answer a = compute(&options, 1, 0);
    assert_turned(&a, 1e-6);
}

static void test_refused(void **state) {
    (void)state;
    gltf_asset a = {0};
    norma_document_error error;
    norma_compute_options options = RENEW;
    options.tangents = (norma_stored_tangents)3;
    norma_document *document = bytes_open(square(&a, 1, 0), "a.glb");
    assert_int_equal(
        norma_document_compute(document, &options, NULL, &error), NORMA_DOCUMENT_ERROR_ARGUMENT);
    assert_non_null(strstr(error.message, "unknown treatment of stored tangents"));
    norma_document_close(document);
    asset_free(&a);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_keep),
        cmocka_unit_test(test_orthogonalise), cmocka_unit_test(test_regenerate),
        cmocka_unit_test(test_without_texcoords), cmocka_unit_test(test_older_caller),
        cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
