/* test_gltf_encodings.c: glTF in all the ways that numbers can be stored: components of every type,
 * normalized or not, sparse, compressed by meshoptimizer's own encoder with each filter, indices of
 * each width. What is read, baked, computed is what the numbers mean, whichever way they are
 * stored. */
#include "check.h"
#include "message.h"
#include "gltf_asset.h"
#include "document_bytes.h"
#include "gltf_output.h"
#include <meshoptimizer.h>

enum { BYTE = 5120, UBYTE, SHORT, USHORT, UINT = 5125, FLOAT, DOUBLE = 5130, HALF };
#define UNTOLD 1e-7
#define MORE_FLOATS                                                                                \
    "\"extensionsRequired\":[\"KHR_accessor_float16\",\"KHR_accessor_float64\"],"                  \
    "\"extensionsUsed\":[\"KHR_accessor_float16\",\"KHR_accessor_float64\"],"

static double bound(int component) {
    return component == BYTE    ? 1 / 127.0
           : component == SHORT ? 1 / 32767.0
           : component == HALF  ? 1 / 4096.0 + UNTOLD
                                : UNTOLD;
}

static void assert_near(
    const float *is, const double *expected, int width, double tolerance, const char *what) {
    for (int k = 0; k < width; ++k)
        if (!(fabs((double)is[k] - expected[k]) <= tolerance))
            fail_msg(
                "%s: component %d is %.9g, expected %.9g", what, k, (double)is[k], expected[k]);
}

static document_bytes written(norma_document *document) {
    document_bytes bytes = bytes_of(document);
    norma_document_close(document);
    return bytes;
}

static const float *at(const norma_vec3_view *view, size_t i, float out[3]) {
    const double same[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    norma_vec3_view one = *view;
    one.data = (const unsigned char *)view->data + i * (view->stride ? view->stride : 12);
    one.count = 1;
    assert_ok(norma_transform_positions(same, one, out, 0, 1));
    return out;
}

static int has_text(document_bytes bytes, const char *text) {
    const size_t length = strlen(text);
    for (size_t i = 0; i + length <= bytes.size; ++i)
        if (memcmp(bytes.data + i, text, length) == 0) return 1;
    return 0;
}

static uint32_t corner(const norma_mesh_data *data, size_t number) {
    return ((const uint32_t *)data->mesh.corners)[number];
}

/* ---- baked */

typedef struct stored {
    int position, normalized, vector, delta; /* component types; whether positions are fractions */
} stored;

static const double NORMALS[4][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {0, -1, 0}, {0, 0.8, -0.6}};
static const double TANGENTS[4][4] = {{1, 0, 0, 1}, {0.8, 0, -0.6, 1}, {1, 0, 0, -1}, {1, 0, 0, 1}};
static const double DELTAS[4][3] = {{0.25, 0, 0}, {0, -0.5, 0}, {0, 0, 0}, {-1, 1, 0.5}};

static norma_document *open_stored(
    gltf_asset *a, const stored *s, double positions[4][3], const char *place) {
    const int is_unsigned = s->position == UBYTE || s->position == USHORT;
    const double size = s->normalized || s->position >= FLOAT ? 1 : 100;
    const double corners[4][3] = {
        {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {is_unsigned ? 1 : -1, 1, is_unsigned ? 1 : -1}};
    char rest[800];
    double moves[12], normals[4][3];
    memcpy(normals, NORMALS, sizeof normals);
    normals[2][1] = s->vector == BYTE    ? -128 / 127.0
                    : s->vector == SHORT ? -32768 / 32767.0
                                         : -1; /* the code below the least: -1 as well */
    for (int i = 0; i < 12; ++i) {
        positions[i / 3][i % 3] = size * corners[i / 3][i % 3];
        moves[i] = (s->position >= FLOAT || s->normalized ? 1 : 4) * DELTAS[i / 3][i % 3];
    }
    const int move = is_unsigned ? FLOAT : s->position;
    asset_numbers(a, positions[0], 4, 3, s->position, s->normalized);
    asset_numbers(a, normals[0], 4, 3, s->vector, 1);
    asset_numbers(a, TANGENTS[0], 4, 4, s->vector, 1);
    asset_numbers(a, moves, 4, 3, move, s->normalized);
    asset_numbers(a, DELTAS[0], 4, 3, s->delta, 1);
    asset_numbers(a, DELTAS[0], 4, 3, s->delta, 1);
    asset_uint16(a, (const uint16_t[]){0, 1, 2, 0, 2, 3}, 6);
    snprintf(rest, sizeof rest,
        "\"extensionsRequired\":[\"KHR_mesh_quantization\",\"KHR_accessor_float16\","
        "\"KHR_accessor_float64\"],\"extensionsUsed\":[\"KHR_mesh_quantization\","
        "\"KHR_accessor_float16\",\"KHR_accessor_float64\"],\"scene\":0,\"scenes\":[{\"nodes\":[0]}"
        "],\"nodes\":[{\"mesh\":0,%s}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2},"
        "\"targets\":[{\"POSITION\":3,\"NORMAL\":4,\"TANGENT\":5}],\"indices\":6}]}]",
        place);
    return asset_open(a, rest, 0);
}

/* x goes to -x: so do all vectors; the tangents' sign and the winding turn round; deltas of vectors
 * keep their lengths. */
static void check_mirrored(const stored *s) {
    gltf_asset a = {0};
    double positions[4][3];
    norma_transform_summary summary;
    norma_document_error error;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_morph_data morph;
    float v[3];
    const norma_transform_options options = {.struct_size = sizeof options, .bake = 1};
    norma_document *document = open_stored(&a, s, positions, "\"scale\":[-1,1,1]");
    if (norma_document_transform(document, &options, &summary, &error))
        fail_msg("%s", error.message);
    assert_true(summary.mirrored && summary.nodes_baked == 1);
    document_bytes out = written(document);
    document = bytes_open(out, "asset.glb");
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(
        norma_document_mesh_attributes(document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_morph_data(document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    const double scale = s->normalized && s->position < FLOAT ? (s->position == BYTE       ? 127
                                                                    : s->position == SHORT ? 32767
                                                                                           : 1)
                                                              : 1;
    const int whole = s->position == BYTE || s->position == SHORT;
    for (size_t i = 0; i < 4; ++i) {
        const double n[3] = {-NORMALS[i][0], NORMALS[i][1], NORMALS[i][2]},
                     t[4] = {-TANGENTS[i][0], TANGENTS[i][1], TANGENTS[i][2], -TANGENTS[i][3]};
        const double p[3] = {-positions[i][0] * (whole ? scale : 1),
            positions[i][1] * (whole ? scale : 1), positions[i][2] * (whole ? scale : 1)};
        const double d[3] = {-DELTAS[i][0], DELTAS[i][1], DELTAS[i][2]};
        assert_near(at(&data.mesh.positions, i, v), p, 3, 1e-4, "position");
        assert_near(at(&data.normals, i, v), n, 3, bound(s->vector), "normal");
        assert_near(attributes.tangents + 4 * i, t, 4, bound(s->vector), "tangent");
        assert_near(at(&morph.normals, i, v), d, 3, bound(s->delta) + bound(s->vector),
            "normal delta"); /* by the length of the normal as stored */
        assert_near(at(&morph.tangents, i, v), d, 3, bound(s->delta) + bound(s->vector) + 1e-6,
            "tangent delta");
        const double unit = s->position >= FLOAT ? 1
                            : s->normalized      ? scale
                                                 : 4,
                     m[3] = {
                         unit * d[0], unit * d[1], unit * d[2]}; /* as the positions' own codes */
        if (s->position >= FLOAT || whole)
            assert_near(at(&morph.positions, i, v), m, 3, whole ? .51 : UNTOLD, "position delta");
    }
    const uint32_t *corners = data.mesh.corners;
    assert_true(corners[0] == 0 && corners[1] == 2 && corners[2] == 1 && corners[3] == 0 &&
                corners[4] == 3 && corners[5] == 2);
    norma_document_close(document);
    bytes_free(&out);
    asset_free(&a);
}

static void test_baked(void **state) {
    static const int positions[] = {FLOAT, BYTE, UBYTE, SHORT, USHORT, DOUBLE, HALF},
                     vectors[] = {FLOAT, BYTE, SHORT, DOUBLE, HALF};
    (void)state;
    for (size_t p = 0; p < COUNT_OF(positions); ++p)
        for (size_t v = 0; v < COUNT_OF(vectors); ++v)
            for (size_t d = 0; d < COUNT_OF(vectors); ++d)
                for (int normalized = 0; normalized < 2; ++normalized) {
                    const stored s = {
                        positions[p], normalized && positions[p] < FLOAT, vectors[v], vectors[d]};
                    check_mirrored(&s);
                }
}

/* Moved by two, fractions do not fit their codes any more, and become floats. */
static void test_moved(void **state) {
    static const int types[] = {FLOAT, BYTE, UBYTE, SHORT, USHORT, DOUBLE, HALF};
    (void)state;
    for (size_t t = 0; t < COUNT_OF(types); ++t) {
        const stored s = {types[t], types[t] < FLOAT, FLOAT, FLOAT};
        gltf_asset a = {0};
        double positions[4][3];
        norma_mesh_data data;
        float v[3];
        const norma_transform_options options = {.struct_size = sizeof options, .bake = 1};
        norma_document *document = open_stored(&a, &s, positions, "\"translation\":[2,0,0]");
        assert_int_equal(
            norma_document_transform(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
        document_bytes out = written(document);
        document = bytes_open(out, "asset.glb");
        assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
        for (size_t i = 0; i < 4; ++i) {
            const double p[3] = {positions[i][0] + 2, positions[i][1], positions[i][2]};
            assert_near(at(&data.mesh.positions, i, v), p, 3, 1e-6, "moved position");
        }
        norma_document_close(document);
        bytes_free(&out);
        asset_free(&a);
    }
}

static void test_too_large(void **state) {
    const stored s = {FLOAT, 0, FLOAT, FLOAT};
    gltf_asset a = {0};
    double positions[4][3];
    norma_document_error error;
    const norma_transform_options options = {.struct_size = sizeof options,
        .matrix = {1e30, 0, 0, 0, 0, 1e30, 0, 0, 0, 0, 1e30, 0, 0, 0, 0, 1},
        .bake = 1};
    norma_document *document = open_stored(&a, &s, positions, "\"scale\":[1e20,1e20,1e20]");
    (void)state;
    assert_int_equal(norma_document_transform(document, &options, NULL, &error),
        NORMA_DOCUMENT_ERROR_UNSUPPORTED);
    assert_string_equal(error.message, "asset.glb:accessor 0: under node 0 its coordinates exceed "
                                       "the range of floats; expected a smaller scale");
    norma_document_close(document);
    asset_free(&a);
}

/* ---- deltas of normals, computed: a roof whose ridge sinks turns its normals; the deltas lie in
 * the encoding that they had, or in floats where they are too large for it */

static void test_computed_deltas(void **state) {
    static const int encodings[] = {FLOAT, BYTE, SHORT, DOUBLE, HALF};
    static const double roof[4][3] = {{-1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 0}},
                        sinks[2][4][3] = {{{0}, {0, 0, -1}, {0, 0, -1}, {0}},
                            {{0}, {0, 0, -9}, {0, 0, -9}, {0}}},
                        none[4][3] = {{0}};
    (void)state;
    for (size_t e = 0; e < COUNT_OF(encodings); ++e)
        for (int deep = 0; deep < 2; ++deep) {
            gltf_asset a = {0};
            norma_morph_data morph;
            norma_mesh_data data;
            norma_document_error error;
            float n[3], d[3];
            const norma_compute_options options = {
                .struct_size = sizeof options, .shading = NORMA_SHADING_FLAT};
            asset_numbers(&a, roof[0], 4, 3, FLOAT, 0);
            asset_numbers(&a, sinks[deep][0], 4, 3, FLOAT, 0);
            asset_numbers(&a, none[0], 4, 3, encodings[e], 1);
            asset_uint16(&a, (const uint16_t[]){0, 1, 2, 1, 3, 2}, 6);
            norma_document *document = asset_open(&a,
                MORE_FLOATS
                "\"meshes\":[{\"primitives\":[{"
                "\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1,\"NORMAL\":2}],"
                "\"indices\":3}]}]",
                0);
            if (norma_document_compute(document, &options, NULL, &error))
                fail_msg("%s", error.message);
            document_bytes out = written(document);
            document = bytes_open(out, "asset.glb");
            assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
            assert_int_equal(
                norma_document_morph_data(document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
            assert_int_equal(data.mesh.positions.count, 6);
            for (size_t c = 0; c < 6;
                 ++c) { /* normal and delta sum up to that of the sunken roof */
                const uint32_t v = corner(&data, c);
                const double side = c < 3 ? -1 : 1, height = deep ? -8 : 0,
                             length = sqrt(height * height + 1), flat = sqrt(2);
                const double before[3] = {side / flat, 0, 1 / flat};
                double delta[3] = {side * height / length - before[0], 0, 1 / length - before[2]};
                assert_near(at(&data.normals, v, n), before, 3, 1e-6, "normal");
                const double tolerance = encodings[e] == HALF ? 9 * bound(HALF)
                                         : deep               ? 1e-6
                                                              : bound(encodings[e]) / 2 + 1e-6;
                assert_near(at(&morph.normals, v, d), delta, 3, tolerance, "delta");
            }
            assert_int_equal(
                has_text(out, "\"componentType\":5120"), encodings[e] == BYTE && !deep);
            norma_document_close(document);
            bytes_free(&out);
            asset_free(&a);
        }
}

/* A wall of normal (-t, 0, 1) that turns to +X: the difference along x is a little above 1, which
 * is the largest code as long as it is rounded to it; from half a code on, floats say it. */
static void check_rounded_delta(int component, double tilt, int stays) {
    const double wall[3][3] = {{0, 0, 0}, {1, 0, tilt}, {0, 1, 0}},
                 turns[3][3] = {{0, 0, 0}, {-1, 1, -tilt}, {0, -1, 1}}, none[3][3] = {{0}},
                 length = sqrt(1 + tilt * tilt), base[3] = {-tilt / length, 0, 1 / length},
                 expected[3] = {1 - base[0], 0, -base[2]};
    const norma_compute_options options = {.struct_size = sizeof options};
    gltf_asset a = {0};
    norma_morph_data morph;
    float d[3];
    asset_numbers(&a, wall[0], 3, 3, FLOAT, 0);
    asset_numbers(&a, turns[0], 3, 3, FLOAT, 0);
    asset_numbers(&a, none[0], 3, 3, component, 1);
    norma_document *document = asset_open(&a,
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1,\"NORMAL\":2}]}]}]",
        0);
    assert_int_equal(norma_document_compute(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    gltf_output b = output_of(document);
    assert_int_equal(output_number(&b, "accessors/2/componentType", 0), stays ? component : FLOAT);
    assert_int_equal(norma_document_morph_data(b.document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    for (size_t v = 0; v < 3; ++v)
        assert_near(at(&morph.normals, v, d), expected, 3,
            (stays ? bound(component) / 2 : 0) + 1e-6, "delta");
    output_finish(&b, &a);
}

static void test_rounded_deltas(void **state) {
    (void)state;
    check_rounded_delta(BYTE, .49 / 127, 1);
    check_rounded_delta(BYTE, .51 / 127, 0);
    check_rounded_delta(SHORT, .49 / 32767, 1);
    check_rounded_delta(SHORT, .51 / 32767, 0);
}

/* Tangents along x, of a triangle whose target lifts its corner on the x axis: they turn to (1, 0,
 * 1) / sqrt 2. Their differences stay in the encoding that they had; where one tangent alone is
 * broken, the others' keep their codes. */
static void check_tangent_deltas(int component, norma_only only) {
    const double one = component == BYTE ? 127 : 32767, h = sqrt(.5), turned[3] = {h - 1, 0, h},
                 positions[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                 lifts[3][3] = {{0, 0, 0}, {0, 0, 1}, {0, 0, 0}},
                 texcoords[3][2] = {{0, 0}, {1, 0}, {0, 1}},
                 normals[3][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
                 tilts[3][3] = {{-h, 0, h - 1}, {-h, 0, h - 1}, {-h, 0, h - 1}},
                 tangents[3][4] = {{.5, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}},
                 old[3][3] = {
                     {0, 0, 0}, {11 / one, 21 / one, 31 / one}, {12 / one, 22 / one, 32 / one}};
    const norma_tangent_options options = {.struct_size = sizeof options, .only = only};
    gltf_asset a = {0};
    norma_morph_data morph;
    float d[3];
    asset_numbers(&a, positions[0], 3, 3, FLOAT, 0);
    asset_numbers(&a, lifts[0], 3, 3, FLOAT, 0);
    asset_numbers(&a, texcoords[0], 3, 2, FLOAT, 0);
    asset_numbers(&a, normals[0], 3, 3, component, 1);
    asset_numbers(&a, tilts[0], 3, 3, component, 1);
    asset_numbers(&a, tangents[0], 3, 4, component, 1);
    asset_numbers(&a, old[0], 3, 3, component, 1);
    norma_document *document = asset_open(&a,
        "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":3,\"TANGENT\":5,\"TEXCOORD_0\":2},"
        "\"targets\":[{\"POSITION\":1,\"NORMAL\":4,\"TANGENT\":6}]}]}]",
        0);
    assert_int_equal(norma_document_tangents(document, &options, NULL, NULL), NORMA_DOCUMENT_OK);
    gltf_output b = output_of(document);
    assert_int_equal(output_number(&b, "accessors/5/componentType", 0), component);
    assert_int_equal(output_number(&b, "accessors/6/componentType", 0), component);
    assert_int_equal(norma_document_morph_data(b.document, 0, 0, &morph, NULL), NORMA_DOCUMENT_OK);
    for (size_t v = 0; v < 3; ++v) {
        const int kept = only == NORMA_ONLY_BROKEN && v > 0;
        assert_near(at(&morph.tangents, v, d), kept ? old[v] : turned, 3,
            kept ? 1e-7 : 3 * bound(component), "delta");
    }
    output_finish(&b, &a);
}

static void test_tangent_deltas(void **state) {
    (void)state;
    for (int component = BYTE; component <= SHORT; component += SHORT - BYTE) {
        check_tangent_deltas(component, NORMA_ONLY_ALL);
        check_tangent_deltas(component, NORMA_ONLY_BROKEN);
    }
}

/* ---- indices */

/* Two walls that meet at a right angle, drawn with indices and, by a second primitive over the same
 * vertices, without: the crease adds vertices, which the second must not draw. */
static void check_indices(int component, size_t surplus) {
    static const double walls[6][3] = {
        {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const double list[8] = {0, 1, 2, 0, 2, 5, 3, 4};
    gltf_asset a = {0};
    norma_document_error error;
    float p[3], n[3];
    const norma_compute_options options = {
        .struct_size = sizeof options, .shading = NORMA_SHADING_CREASE, .crease_angle_rad = 0.5};
    char rest[500];
    asset_numbers(&a, walls[0], 6, 3, FLOAT, 0);
    const size_t size = component == UBYTE ? 1 : component == USHORT ? 2 : 4;
    unsigned char bytes[32] = {0};
    for (size_t i = 0; i < 6 + surplus; ++i) bytes[i * size] = (unsigned char)list[i];
    asset_view(&a, bytes, (6 + surplus) * size, "");
    snprintf(rest, sizeof rest,
        "{\"bufferView\":1,\"componentType\":%d,\"count\":%zu,\"type\":\"SCALAR\"}", component,
        6 + surplus);
    asset_accessor(&a, rest);
    norma_document *document = asset_open(&a,
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1},{"
        "\"attributes\":{\"POSITION\":0}}]}]",
        0);
    if (norma_document_compute(document, &options, NULL, &error)) fail_msg("%s", error.message);
    document_bytes out = written(document);
    document = bytes_open(out, "asset.glb");
    for (size_t m = 0; m < 2; ++m) {
        norma_mesh_data data;
        assert_int_equal(norma_document_mesh_data(document, m, &data, NULL), NORMA_DOCUMENT_OK);
        assert_int_equal(data.mesh.corner_count, 6);
        for (size_t c = 0; c < 6; ++c) {
            static const double facing[2][3] = {{0, 0, 1}, {1, 0, 0}};
            const size_t was = m == 0 ? (size_t)list[c] : c;
            assert_near(at(&data.mesh.positions, corner(&data, c), p), walls[was], 3, 0, "corner");
            assert_near(at(&data.normals, corner(&data, c), n), facing[c / 3], 3, 1e-6, "normal");
        }
    }
    norma_document_close(document);
    bytes_free(&out);
    asset_free(&a);
}

static void test_indices(void **state) {
    (void)state;
    for (size_t surplus = 0; surplus < 3; ++surplus) {
        check_indices(UBYTE, surplus);
        check_indices(USHORT, surplus);
        check_indices(UINT, surplus);
    }
}

/* ---- sparse */

static void test_sparse(void **state) {
    static const int widths[] = {UBYTE, USHORT, UINT};
    static const float rest[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}},
                       changed[2][3] = {{7, 8, 9}, {-1, -2, -3}};
    (void)state;
    for (size_t w = 0; w < COUNT_OF(widths); ++w)
        for (int over_zeros = 0; over_zeros < 2; ++over_zeros) {
            gltf_asset a = {0};
            norma_mesh_data data;
            char text[500];
            float p[3];
            unsigned char places[8] = {0};
            const size_t size = widths[w] == UBYTE ? 1 : widths[w] == USHORT ? 2 : 4;
            places[0] = 1;
            places[size] = 3;
            asset_view(&a, rest, sizeof rest, "");
            asset_view(&a, places, 2 * size, "");
            asset_view(&a, changed, sizeof changed, "");
            snprintf(text, sizeof text,
                "{%s\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
                "\"indices\":{\"bufferView\":1,\"componentType\":%d},\"values\":{\"bufferView\":2}}"
                "}",
                over_zeros ? "" : "\"bufferView\":0,", widths[w]);
            asset_accessor(&a, text);
            norma_document *document = asset_open(
                &a, "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]", 0);
            assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
            for (size_t i = 0; i < 4; ++i) {
                double expected[3];
                for (int k = 0; k < 3; ++k)
                    expected[k] = (double)(i == 1       ? changed[0][k]
                                           : i == 3     ? changed[1][k]
                                           : over_zeros ? 0
                                                        : rest[i][k]);
                assert_near(at(&data.mesh.positions, i, p), expected, 3, 0, "sparse");
            }
            norma_document_close(document);
            asset_free(&a);
        }
}

/* ---- compressed: by meshoptimizer's encoder, its filters included */

static int compressed_view(gltf_asset *a, const void *bytes, size_t count, size_t stride,
    const char *mode, const char *filter) {
    unsigned char code[4096];
    size_t size = 0;
    char members[400];
    if (mode[0] == 'A')
        size = meshopt_encodeVertexBuffer(code, sizeof code, bytes, count, stride);
    else if (mode[0] == 'T')
        size = meshopt_encodeIndexBuffer(code, sizeof code, bytes, count);
    else
        size = meshopt_encodeIndexSequence(code, sizeof code, bytes, count);
    assert_true(size > 0);
    const size_t offset = a->bin_size, whole = count * stride;
    a->bin = realloc(a->bin, offset + (size + 3) / 4 * 4 + whole + 8);
    assert_non_null(a->bin);
    snprintf(members, sizeof members,
        ",\"byteStride\":%zu,\"extensions\":{\"EXT_meshopt_compression\":{\"buffer\":0,"
        "\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%zu,\"count\":%zu,\"mode\":\"%s\","
        "\"filter\":\"%s\"}}",
        stride, offset, size, stride, count, mode, filter);
    memcpy(a->bin + offset, code, size);
    a->bin_size += (size + 3) / 4 * 4;
    unsigned char *nothing =
        calloc(whole, 1); /* where the fallback would lie: not what is to be read */
    assert_non_null(nothing);
    const int view = asset_view(
        a, nothing, whole, members + (mode[0] == 'A' ? 0 : strcspn(members + 1, ",") + 1));
    free(nothing);
    return view;
}

static void test_compressed(void **state) {
    static const float positions[4][3] = {{0, 0, 0}, {1.5F, 0, 0}, {0, 2.25F, 0}, {-3, 0.125F, 7}};
    static const float normals[4][4] = {
        {0, 0, 1, 0}, {0.6F, 0, 0.8F, 0}, {-0.6F, 0.64F, -0.48F, 0}, {0, -1, 0, 0}};
    static const unsigned corners[6] = {0, 1, 2, 0, 2, 3};
    (void)state;
    for (int wide = 0; wide < 2; ++wide)
        for (int sequence = 0; sequence < 2; ++sequence) {
            gltf_asset a = {0};
            unsigned powers[12];
            unsigned char octahedral[32];
            norma_mesh_data data;
            float v[3];
            meshopt_encodeFilterExp(powers, 4, 12, 20, positions[0]);
            meshopt_encodeFilterOct(octahedral, 4, wide ? 8 : 4, wide ? 16 : 8, normals[0]);
            compressed_view(&a, powers, 4, 12, "ATTRIBUTES", "EXPONENTIAL");
            compressed_view(&a, octahedral, 4, wide ? 8 : 4, "ATTRIBUTES", "OCTAHEDRAL");
            compressed_view(&a, corners, 6, 4, sequence ? "INDICES" : "TRIANGLES", "NONE");
            asset_accessor(
                &a, "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}");
            asset_accessor(&a, wide ? "{\"bufferView\":1,\"componentType\":5122,\"normalized\":"
                                      "true,\"count\":4,\"type\":\"VEC3\"}"
                                    : "{\"bufferView\":1,\"componentType\":5120,\"normalized\":"
                                      "true,\"count\":4,\"type\":\"VEC3\"}");
            asset_accessor(
                &a, "{\"bufferView\":2,\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\"}");
            norma_document *document = asset_open(&a,
                "\"extensionsUsed\":[\"EXT_meshopt_compression\",\"KHR_mesh_quantization\"],"
                "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},"
                "\"indices\":2}]}]",
                0);
            assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
            for (size_t i = 0; i < 4; ++i) {
                double p[3], n[3];
                for (int k = 0; k < 3; ++k)
                    p[k] = (double)positions[i][k], n[k] = (double)normals[i][k];
                assert_near(at(&data.mesh.positions, i, v), p, 3, 1e-5, "position");
                assert_near(at(&data.normals, i, v), n, 3, wide ? 1e-4 : 0.02, "normal");
            }
            for (size_t c = 0; c < 3; c += 3) /* a triangle may be turned on, not round */
                assert_true(corner(&data, c) + corner(&data, c + 1) + corner(&data, c + 2) ==
                            corners[c] + corners[c + 1] + corners[c + 2]);
            norma_document_close(document);
            asset_free(&a);
        }
}

/* What the extension's formula makes of an encoded normal, in steps of the encoding. */
static void unfold_exactly(const double encoded[3], double most, double out[3]) {
    double x = encoded[0] / encoded[2], y = encoded[1] / encoded[2];
    const double z = 1 - fabs(x) - fabs(y), below = z < 0 ? z : 0;
    x -= copysign(below, x);
    y -= copysign(below, y);
    const double length = sqrt(x * x + y * y + z * z);
    out[0] = most * x / length, out[1] = most * y / length, out[2] = most * z / length;
}

/* Every component is the whole number nearest to the formula's, on every processor. */
static void test_octahedral(void **state) {
    enum { COUNT = 200 };
    static float normals[COUNT][4];
    static unsigned char octahedral[8 * COUNT];
    (void)state;
    for (int i = 0; i < COUNT; ++i) {
        const double z = 1 - (2 * i + 1.0) / COUNT, turn = 2.399963 * i, r = sqrt(1 - z * z);
        normals[i][0] = (float)(r * cos(turn)), normals[i][1] = (float)(r * sin(turn));
        normals[i][2] = (float)z;
    }
    for (int wide = 0; wide < 2; ++wide) {
        const double most = wide ? 32767 : 127;
        gltf_asset a = {0};
        norma_mesh_data data;
        float v[3];
        meshopt_encodeFilterOct(octahedral, COUNT, wide ? 8 : 4, wide ? 16 : 8, normals[0]);
        asset_view(&a, normals, 12 * COUNT, "");
        compressed_view(&a, octahedral, COUNT, wide ? 8 : 4, "ATTRIBUTES", "OCTAHEDRAL");
        asset_accessor(
            &a, "{\"bufferView\":0,\"componentType\":5126,\"count\":200,\"type\":\"VEC3\"}");
        asset_accessor(&a, wide ? "{\"bufferView\":1,\"componentType\":5122,\"normalized\":true,"
                                  "\"count\":200,\"type\":\"VEC3\"}"
                                : "{\"bufferView\":1,\"componentType\":5120,\"normalized\":true,"
                                  "\"count\":200,\"type\":\"VEC3\"}");
        norma_document *document = asset_open(&a,
            "\"extensionsUsed\":[\"EXT_meshopt_compression\",\"KHR_mesh_quantization\"],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}]}]",
            0);
        assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
        for (size_t i = 0; i < COUNT; ++i) {
            double encoded[3], exact[3];
            for (int k = 0; k < 3; ++k) {
                int16_t two;
                memcpy(&two, octahedral + 8 * i + 2 * (size_t)k, 2);
                encoded[k] = wide ? two : (int8_t)octahedral[4 * i + (size_t)k];
            }
            unfold_exactly(encoded, most, exact);
            at(&data.normals, i, v);
            for (int k = 0; k < 3; ++k) {
                const double steps = most * (double)v[k];
                assert_true(fabs(steps - round(steps)) < 2e-3); /* a whole number of steps */
                assert_true(fabs(round(steps) - exact[k]) < 0.5 + (wide ? 5e-3 : 1e-4));
            }
        }
        norma_document_close(document);
        asset_free(&a);
    }
}

/* The bytes of a view of the output, decoded by meshoptimizer; to be freed. */
static unsigned char *decoded(const gltf_output *b, long view, const char *name) {
    const unsigned char *glb = (const unsigned char *)b->bytes.data;
    char at[120], text[200];
#define MEMBER(key) (snprintf(at, sizeof at, "bufferViews/%ld/extensions/%s/" key, view, name), at)
    const size_t count = (size_t)output_number(b, MEMBER("count"), 0),
                 stride = (size_t)output_number(b, MEMBER("byteStride"), 0),
                 size = (size_t)output_number(b, MEMBER("byteLength"), 0);
    const unsigned char *code = glb + 28 + (glb[12] | (size_t)glb[13] << 8) +
                                (size_t)output_number(b, MEMBER("byteOffset"), 0);
    snprintf(text, sizeof text, "%s", output_text(b, MEMBER("mode")));
    unsigned char *out = calloc(count, stride);
    assert_non_null(out);
    assert_int_equal(output_number(b, "bufferViews/%ld/byteLength", view), (long)(count * stride));
    if (strcmp(text, "\"ATTRIBUTES\"") == 0)
        assert_int_equal(meshopt_decodeVertexBuffer(out, count, stride, code, size), 0);
    else if (strcmp(text, "\"TRIANGLES\"") == 0)
        assert_int_equal(meshopt_decodeIndexBuffer(out, count, stride, code, size), 0);
    else
        assert_int_equal(meshopt_decodeIndexSequence(out, count, stride, code, size), 0);
    snprintf(text, sizeof text, "%s", output_text(b, MEMBER("filter")));
#undef MEMBER
    if (strcmp(text, "\"EXPONENTIAL\"") == 0) meshopt_decodeFilterExp(out, count, stride);
    if (strcmp(text, "\"OCTAHEDRAL\"") == 0) meshopt_decodeFilterOct(out, count, stride);
    return out;
}

/* A compressed mesh whose vertices part: all that was compressed is so again, in the same types,
 * and meshoptimizer finds each corner where it was; what was not compressed is not. */
static void test_compressed_again(void **state) {
    static const float positions[4][3] = {{0, 0, 0}, {1.5F, 0, 0}, {0, 2.25F, 0}, {-3, 0.125F, 7}};
    static const float normals[4][4] = {{0, 0, 1, 0}, {0, 0, 1, 0}, {0, 0, 1, 0}, {0, 0, 1, 0}};
    static const float flat[2][3] = {{0, 0, 1}, {0.919145F, 0, 0.393919F}};
    static const float coordinates[4][2] = {{0, 0}, {1, 0}, {0, 1}, {0.1F, 0.7F}};
    static const unsigned corners[6] = {0, 1, 2, 0, 2, 3};
    const norma_compute_options options = {
        .struct_size = sizeof options, .shading = NORMA_SHADING_FLAT};
    norma_document_error error;
    (void)state;
    for (int number = 0; number < 8; ++number) {
        const int wide = number & 1, sequence = number & 2, powers = number & 4;
        gltf_asset a = {0};
        unsigned filtered[12];
        float original[4][3]; /* positions as a reader finds them */
        unsigned char octahedral[32];
        meshopt_encodeFilterExp(filtered, 4, 12, 20, positions[0]);
        meshopt_encodeFilterOct(octahedral, 4, wide ? 8 : 4, wide ? 16 : 8, normals[0]);
        memcpy(original, powers ? (const void *)filtered : positions, sizeof original);
        if (powers) meshopt_decodeFilterExp(original, 4, 12);
        compressed_view(&a, powers ? (const void *)filtered : positions, 4, 12, "ATTRIBUTES",
            powers ? "EXPONENTIAL" : "NONE");
        compressed_view(&a, octahedral, 4, wide ? 8 : 4, "ATTRIBUTES", "OCTAHEDRAL");
        compressed_view(&a, corners, 6, 4, sequence ? "INDICES" : "TRIANGLES", "NONE");
        asset_accessor(
            &a, "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}");
        asset_accessor(&a, wide ? "{\"bufferView\":1,\"componentType\":5122,\"normalized\":true,"
                                  "\"count\":4,\"type\":\"VEC3\"}"
                                : "{\"bufferView\":1,\"componentType\":5120,\"normalized\":true,"
                                  "\"count\":4,\"type\":\"VEC3\"}");
        asset_accessor(
            &a, "{\"bufferView\":2,\"componentType\":5125,\"count\":6,\"type\":\"SCALAR\"}");
        asset_floats(&a, coordinates[0], 4, 2);
        norma_document *document = asset_open(&a,
            "\"extensionsUsed\":[\"EXT_meshopt_compression\",\"KHR_mesh_quantization\"],\"meshes\":"
            "[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":3},"
            "\"indices\":2}]}]",
            0);
        if (norma_document_compute(document, &options, NULL, &error)) fail_msg("%s", error.message);
        norma_mesh_info info;
        assert_int_equal(norma_document_mesh_info(document, 0, &info), NORMA_DOCUMENT_OK);
        assert_string_equal(info.compression, "EXT_meshopt_compression");
        gltf_output b = output_of(document);
        assert_int_equal(output_number(&b, "accessors/%ld/count", 0), 6);
        assert_int_equal(output_number(&b, "accessors/%ld/componentType", 0), FLOAT);
        assert_int_equal(output_number(&b, "accessors/%ld/componentType", 1), wide ? SHORT : BYTE);
        assert_string_equal(output_text(&b, "bufferViews/3/extensions"), "");
        assert_string_equal(output_text(&b, "bufferViews/4"), "");
        unsigned char *p = decoded(&b, 0, "EXT_meshopt_compression"),
                      *n = decoded(&b, 1, "EXT_meshopt_compression"),
                      *c = decoded(&b, 2, "EXT_meshopt_compression");
        for (size_t i = 0; i < 6; ++i) {
            const size_t t = i / 3;
            const unsigned vertex = ((const unsigned *)c)[i];
            assert_memory_equal(p + (size_t)12 * vertex, original[corners[i]], 12);
            for (int k = 0; k < 3; ++k) {
                short value = 0;
                memcpy(&value, n + (size_t)8 * vertex + 2 * k, 2 * (size_t)wide);
                const double is =
                    wide ? value / 32767.0 : (signed char)n[(size_t)4 * vertex + (size_t)k] / 127.0;
                assert_true(fabs(is - (double)flat[t][k]) < (wide ? 2e-5 : 4.1e-3));
            }
        }
        free(p);
        free(n);
        free(c);
        output_finish(&b, &a);
    }
}

/* A view that is said to be compressed twice, under one name or under both there are: rewritten, it
 * is compressed once, so that every reader finds the same. */
static void test_compressed_twice(void **state) {
    static const float positions[4][3] = {{0, 0, 0}, {1.5F, 0, 0}, {0, 2.25F, 0}, {-3, 0.125F, 7}};
    static const uint8_t second[4] = {0, 1, 0, 0};
    static const double moved[4][3] = {{0}, {4, 5, 6}};
    const norma_mesh_edit edit = {.positions = moved[0], .set_positions = second};
    (void)state;
    for (int twice = 0; twice < 4;
         ++twice) { /* the same name, both names, and either beside another extension */
        gltf_asset a = {0};
        char views[2000];
        norma_mesh_data data;
        float v[3];
        compressed_view(&a, positions, 4, 12, "ATTRIBUTES", "NONE");
        asset_accessor(
            &a, "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}");
        const char *said = strstr(a.views, "\"EXT_"), *end = strrchr(a.views, '}') - 1;
        const int before = (int)(said - a.views), length = (int)(end - said);
        snprintf(views, sizeof views, "%.*s%.*s,\"%s%.*s%s}}", before, a.views, length, said,
            twice & 1 ? "KHR" : "EXT", length - 4, said + 4, twice & 2 ? ",\"VENDOR_x\":{}" : "");
        free(a.views);
        a.views = malloc(strlen(views) + 1);
        assert_non_null(a.views);
        strcpy(a.views, views);
        norma_document *document = asset_open(&a,
            "\"extensionsUsed\":[\"EXT_meshopt_compression\",\"KHR_meshopt_compression\"],"
            "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]",
            0);
        assert_int_equal(norma_document_edit(document, &edit, NULL), NORMA_DOCUMENT_OK);
        gltf_output b = output_of(document);
        const char *extensions = output_text(&b, "bufferViews/0/extensions"),
                   *name = strstr(extensions, "_meshopt_compression");
        assert_non_null(name);
        assert_null(strstr(name + 1, "_meshopt_compression"));
        assert_true((strstr(extensions, "VENDOR_x") != NULL) == (twice > 1));
        assert_string_equal(output_text(&b, "extensionsUsed"),
            "[\"EXT_meshopt_compression\",\"KHR_meshopt_compression\"]");
        assert_int_equal(norma_document_mesh_data(b.document, 0, &data, NULL), NORMA_DOCUMENT_OK);
        at(&data.mesh.positions, 1, v);
        assert_true(v[0] == 4 && v[1] == 5 && v[2] == 6);
        at(&data.mesh.positions, 3, v);
        assert_true(v[0] == -3 && v[1] == 0.125F && v[2] == 7);
        output_finish(&b, &a);
    }
}

/* Instances turned by quaternions under the filter for them: a quarter about each axis. */
static void test_compressed_rotations(void **state) {
    static const float turns[3][4] = {{0.70710678F, 0, 0, 0.70710678F},
        {0, 0.70710678F, 0, 0.70710678F}, {0, 0, 0.70710678F, 0.70710678F}};
    static const double images[3][3] = {{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}}; /* of (0, 1, 0) */
    static const float positions[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    gltf_asset a = {0};
    short codes[3][4];
    (void)state;
    meshopt_encodeFilterQuat(codes, 3, 8, 16, turns[0]);
    asset_floats(&a, positions[0], 3, 3);
    compressed_view(&a, codes, 3, 8, "ATTRIBUTES", "QUATERNION");
    asset_accessor(&a, "{\"bufferView\":1,\"componentType\":5122,\"normalized\":true,\"count\":3,"
                       "\"type\":\"VEC4\"}");
    norma_document *document = asset_open(&a,
        "\"extensionsUsed\":[\"EXT_meshopt_compression\",\"EXT_mesh_gpu_instancing\"],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"nodes\":[{\"mesh\":0,"
        "\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"ROTATION\":1}}}}]",
        0);
    for (size_t i = 0; i < 3; ++i) {
        double world[16];
        assert_int_equal(
            norma_document_instance_world(document, 0, i, world, NULL), NORMA_DOCUMENT_OK);
        for (int k = 0; k < 3; ++k) assert_true(fabs(world[4 + k] - images[i][k]) < 1e-3);
    }
    norma_document_close(document);
    asset_free(&a);
}

/* Any codes under the two filters of floats and quaternions come out as meshoptimizer's own say. */
static void test_filters(void **state) {
    enum { COUNT = 240 };
    static uint32_t powers[COUNT][3];
    static int16_t codes[COUNT][4];
    gltf_asset a = {0};
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    uint32_t seed = 1;
    (void)state;
    for (size_t i = 0; i < COUNT; ++i)
        for (size_t k = 0; k < 7; ++k) {
            seed = seed * 1664525 + 1013904223;
            if (k < 3)
                powers[i][k] = seed >> 24 == 0x80 ? seed ^ 1U << 31 : seed; /* -128 is no power */
            else
                codes[i][k - 3] = (int16_t)(seed >> 16);
        }
    compressed_view(&a, powers, COUNT, 12, "ATTRIBUTES", "EXPONENTIAL");
    compressed_view(&a, codes, COUNT, 8, "ATTRIBUTES", "QUATERNION");
    asset_accessor(&a, "{\"bufferView\":0,\"componentType\":5126,\"count\":240,\"type\":\"VEC3\"}");
    asset_accessor(&a, "{\"bufferView\":1,\"componentType\":5122,\"normalized\":true,"
                       "\"count\":240,\"type\":\"VEC4\"}");
    norma_document *document = asset_open(&a,
        "\"extensionsUsed\":[\"EXT_meshopt_compression\",\"KHR_mesh_quantization\"],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TANGENT\":1}}]}]",
        0);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    assert_int_equal(
        norma_document_mesh_attributes(document, 0, &attributes, NULL), NORMA_DOCUMENT_OK);
    meshopt_decodeFilterExp(powers, COUNT, 12);
    meshopt_decodeFilterQuat(codes, COUNT, 8);
    for (size_t i = 0; i < COUNT; ++i) {
        assert_memory_equal((const char *)data.mesh.positions.data + 12 * i, powers[i], 12);
        for (size_t k = 0; k < 4; ++k)
            assert_true(attributes.tangents[4 * i + k] == fmaxf((float)codes[i][k] / 32767, -1));
    }
    norma_document_close(document);
    asset_free(&a);
}

/* ---- data: URIs */

#define IN_BASE64 "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"

static void test_data_uris(void **state) {
    static const char text[] =
        "{\"asset\":{\"version\":\"2.0\"},\"meshes\":[{\"primitives\":[{\"attributes\":{"
        "\"POSITION\":0}}]}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,"
        "\"type\":\"VEC3\"}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"buffers\":[{"
        "\"byteLength\":36,\"uri\":\"%s\"}]}";
    static const double corners[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    static const struct {
        const char *uri;
        int fine;
    } cases[] = {
        {"data:application/octet-stream;base64," IN_BASE64, 1},
        {"DATA:;base64," IN_BASE64, 1},
        {"data:;base64," IN_BASE64 "====", 1},
        {"data:;base64," IN_BASE64 "AA", 1},
        {"data:;base64,%41%41AAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA", 1},
        {"data:application/"
         "gltf-buffer,%00%00%00%00%00%00%00%00%00%00%00%00%00%00%80%3f%00%00%00%00%00%00%00%00%00%"
         "00%00%00%00%00%80%3f%00%00%00%00",
            1},
        {"data:;base64," IN_BASE64 "A", 0},
        {"data:;base64,*" IN_BASE64, 0},
        {"data:;base64,%4", 0},
        {"data:;base64,%4G", 0},
        {"data:,%0", 0},
        {"data:;base64", 0},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        char file[1000];
        norma_document *document = NULL;
        norma_mesh_data data;
        float v[3];
        snprintf(file, sizeof file, text, cases[i].uri);
        const norma_document_result result =
            norma_document_open_memory(file, strlen(file), "a.gltf", NULL, &document, NULL);
        if (result != (cases[i].fine ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MALFORMED))
            fail_msg("%s: result %d", cases[i].uri, (int)result);
        if (result) continue;
        assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
        for (size_t k = 0; k < 3; ++k)
            assert_near(at(&data.mesh.positions, k, v), corners[k], 3, 0, cases[i].uri);
        norma_document_close(document);
    }
}

/* ---- animations: scales between keys, along a line and along a spline */

static double anisotropy_of(
    const char *interpolation, const float *scales, size_t count, norma_document_error *error) {
    static const float ends[2] = {0, 2}, moments[3] = {0, 1, 2},
                       thin[3][3] = {{1, 1, 1}, {1, 1, 0.125F}, {1, 1, 1}};
    gltf_asset a = {0};
    norma_skin_info info = {.anisotropy = -1};
    char rest[800];
    asset_floats(&a, ends, 2, 1);
    asset_floats(&a, scales, count, 3);
    asset_floats(&a, moments, 3, 1);
    asset_floats(&a, thin[0], 3, 3);
    snprintf(rest, sizeof rest,
        "\"skins\":[{\"joints\":[1]}],\"nodes\":[{\"children\":[1]},{}],\"animations\":[{"
        "\"samplers\":[{\"input\":0,\"output\":1,\"interpolation\":\"%s\"},{\"input\":2,\"output\":"
        "3}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}},{\"sampler\":"
        "1,\"target\":{\"node\":1,\"path\":\"scale\"}}]}]",
        interpolation);
    norma_document *document = asset_open(&a, rest, 0);
    const norma_document_result result = norma_document_skin_info(document, 0, &info, error);
    const norma_document_result again = norma_document_skin_info(document, 0, &info, error);
    assert_int_equal(result, again);
    norma_document_close(document);
    asset_free(&a);
    return result ? -1 : info.anisotropy;
}

/* At moment 1 the joint is thin by eight; what is above it is then x times as wide, which is the
 * worst. */
static void test_between_keys(void **state) {
    static const float line[2][3] = {{1, 1, 1}, {3, 1, 1}};
    static const float spline[6][3] = {{0, 0, 0}, {1, 1, 1}, {4, 0, 0}, {-4, 0, 0}, {3, 1, 1},
        {0, 0, 0}}; /* arriving, value, leaving */
    norma_document_error error;
    (void)state;
    assert_true(fabs(anisotropy_of("LINEAR", line[0], 2, &error) - 16) < 1e-4);
    assert_true(fabs(anisotropy_of("STEP", line[0], 2, &error) - 8) < 1e-4);
    assert_true(fabs(anisotropy_of("CUBICSPLINE", spline[0], 6, &error) -
                     8 * (0.5 * 1 + 2 * 0.125 * 4 + 0.5 * 3 + 2 * 0.125 * 4)) < 1e-4);
    assert_true(anisotropy_of("CUBICSPLINE", line[0], 2, &error) < 0);
    assert_message(error.message,
        "asset.glb:/animations/0/samplers/0: expected as many values as times; found ");
}

static void test_animations_refused(void **state) {
    static const struct {
        const char *animation, *message;
    } cases[] = {
        {"{\"samplers\":[{\"input\":0}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
         "\"path\":\"scale\"}}]}",
            "asset.glb:/animations/0/samplers/0: expected the numbers of existing accessors in "
            "\"input\" "
            "and \"output\"; found "},
        {"{\"samplers\":[{\"input\":0,\"output\":9}],\"channels\":[{\"sampler\":0,\"target\":{"
         "\"node\":0,\"path\":\"rotation\"}}]}",
            "asset.glb:/animations/0/samplers/0: expected the numbers of existing accessors in "
            "\"input\" "
            "and \"output\"; found "},
        {"{\"samplers\":[{\"input\":0,\"output\":0}],\"channels\":[{\"sampler\":0,\"target\":{"
         "\"node\":0,\"path\":\"scale\"}}]}",
            "asset.glb:/accessors/0: expected vectors of three numbers; found "},
        {"{\"samplers\":[{\"input\":0,\"output\":0}],\"channels\":[{\"sampler\":0,\"target\":{"
         "\"node\":0,\"path\":\"rotation\"}}]}",
            "asset.glb:/accessors/0: expected vectors of four numbers; found "},
        {"{\"samplers\":[],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}"
         "]}",
            "asset.glb:/animations/0/channels/0: expected the number of an existing sampler; "
            "found "},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); ++i) {
        static const float moments[2] = {0, 1};
        gltf_asset a = {0};
        norma_skin_info info;
        norma_document_error error = {0};
        char rest[600];
        asset_floats(&a, moments, 2, 1);
        snprintf(rest, sizeof rest,
            "\"skins\":[{\"joints\":[0]}],\"nodes\":[{}],\"animations\":[%s]", cases[i].animation);
        norma_document *document = asset_open(&a, rest, 0);
        for (int again = 0; again < 2; ++again) { /* the second time from memory */
            assert_int_equal(norma_document_skin_info(document, 0, &info, &error),
                NORMA_DOCUMENT_ERROR_MALFORMED);
            assert_message(error.message, cases[i].message);
        }
        assert_int_equal(
            norma_document_skin_info(document, 0, &info, NULL), NORMA_DOCUMENT_ERROR_MALFORMED);
        norma_document_close(document);
        asset_free(&a);
    }
}

/* ---- half and double floats */

/* All half floats as positions: what each is, from its definition (IEEE 754-2019, 3.4). */
static void test_half_decoded(void **state) {
    enum { CODES = 0x10000, TRIPLES = CODES / 3 + 1 };
    uint16_t *codes = calloc(TRIPLES * 4, sizeof *codes);
    gltf_asset a = {0};
    norma_mesh_data data;
    (void)state;
    assert_non_null(codes);
    for (uint32_t c = 0; c < CODES; ++c) codes[c / 3 * 4 + c % 3] = (uint16_t)c;
    asset_view(&a, codes, TRIPLES * 8, ",\"byteStride\":8");
    char text[200];
    snprintf(text, sizeof text,
        "{\"bufferView\":0,\"componentType\":5131,\"count\":%d,\"type\":\"VEC3\"}", TRIPLES);
    asset_accessor(&a, text);
    norma_document *document = asset_open(
        &a, MORE_FLOATS "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]", 0);
    assert_int_equal(norma_document_mesh_data(document, 0, &data, NULL), NORMA_DOCUMENT_OK);
    for (uint32_t c = 0; c < CODES; ++c) {
        const int exponent = (int)(c >> 10 & 31);
        const double fraction = (c & 1023) / 1024.0, sign = c >> 15 ? -1 : 1,
                     size = exponent ? ldexp(1 + fraction, exponent - 15) : ldexp(fraction, -14);
        float is;
        memcpy(&is,
            (const unsigned char *)data.mesh.positions.data + c / 3 * data.mesh.positions.stride +
                c % 3 * sizeof is,
            sizeof is);
        if (exponent == 31 && fraction > 0)
            assert_true(isnan(is));
        else if (exponent == 31)
            assert_true(isinf(is) && (is > 0) == (sign > 0));
        else if ((double)is != sign * size || !signbit(is) != (sign > 0))
            fail_msg("half float %#x is %.9g, expected %.9g", (unsigned)c, (double)is, sign * size);
    }
    norma_document_close(document);
    asset_free(&a);
    free(codes);
}

/* A roof, made flat: two vertices more, normals (-+1, 0, 1) / sqrt(2) in the floats that the file
 * has, as near to them as those come; positions keep their bits, and doubles lie at multiples of
 * eight bytes (glTF 2.0, 3.6.2.4). far: where floats could not tell its corners apart. */
static void check_roof(int component, double far) {
    const double roof[4][3] = {{far - 1, 0, 0}, {far, 0, 1}, {far, 1, 1}, {far + 1, 0, 0}},
                 up[4][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, slope = sqrt(.5);
    const norma_compute_options options = {
        .struct_size = sizeof options, .shading = NORMA_SHADING_FLAT};
    const int is_half = component == HALF;
    gltf_asset a = {0}, expected = {0};
    norma_document_error error;
    asset_numbers(&a, roof[0], 4, 3, component, 0);
    asset_numbers(&a, up[0], 4, 3, component, 0);
    asset_uint16(&a, (const uint16_t[]){0, 1, 2, 1, 3, 2}, 6);
    norma_document *document = asset_open(&a,
        MORE_FLOATS "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},"
                    "\"indices\":2}]}]",
        0);
    if (norma_document_compute(document, &options, NULL, &error)) fail_msg("%s", error.message);
    gltf_output b = output_of(document);
    const norma_mesh_data data = output_mesh(&b, 0);
    assert_int_equal(data.mesh.positions.count, 6);
    for (int accessor = 0; accessor < 2; ++accessor) {
        assert_int_equal(output_number(&b, "accessors/%ld/componentType", accessor), component);
        const long offset = output_number(&b, "bufferViews/%ld/byteOffset",
            output_number(&b, "accessors/%ld/bufferView", accessor));
        assert_int_equal((offset < 0 ? 0 : offset) % (is_half ? 2 : 8), 0);
    }
    const size_t size = is_half ? 2 : 8, stride = is_half ? 8 : 24;
    for (size_t c = 0; c < 6; ++c) {
        const uint32_t v = corner(&data, c);
        const double normal[3] = {c < 3 ? -slope : slope, 0, slope};
        const double single[3] = {(double)(float)normal[0], 0, (double)(float)normal[2]};
        asset_numbers(&expected, single, 1, 3, component, 0);
        const unsigned char *is = output_bytes(&b, 1) + v * stride,
                            *should = expected.bin + c * stride;
        if (is_half)
            assert_memory_equal(is, should, 3 * size);
        else
            for (int k = 0; k < 3; ++k) {
                double number;
                memcpy(&number, is + 8 * k, 8);
                assert_true(fabs(number - normal[k]) <= UNTOLD);
            }
        const size_t old = (size_t[]){0, 1, 2, 1, 3, 2}[c];
        assert_memory_equal(output_bytes(&b, 0) + v * stride, a.bin + old * stride, 3 * size);
    }
    asset_free(&expected);
    output_finish(&b, &a);
}

static void test_more_floats_computed(void **state) {
    (void)state;
    check_roof(HALF, 0);
    check_roof(HALF, 100);
    check_roof(DOUBLE, 0);
    check_roof(DOUBLE, 1e12);
}

static void test_more_floats_refused(void **state) {
    static const double triangle[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    static const char mesh[] = "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]";
    (void)state;
    for (int component = DOUBLE; component <= HALF; ++component) {
        char expected[200];
        gltf_asset a = {0}, b = {0};
        asset_numbers(&a, triangle[0], 3, 3, component, 0);
        snprintf(expected, sizeof expected,
            "asset.glb:/accessors/0: expected componentType %d only with KHR_accessor_float%s, and "
            "not normalized; found ",
            component, component == HALF ? "16" : "64");
        assert_message(asset_refused(&a, mesh, 0), expected);
        asset_view(&b, triangle, sizeof triangle, "");
        asset_accessor(&b, component == HALF
                               ? "{\"bufferView\":0,\"componentType\":5131,"
                                 "\"normalized\":true,\"count\":3,\"type\":\"VEC3\"}"
                               : "{\"bufferView\":0,\"componentType\":5130,"
                                 "\"normalized\":true,\"count\":3,\"type\":\"VEC3\"}");
        char rest[400];
        snprintf(rest, sizeof rest, "%s%s", MORE_FLOATS, mesh);
        assert_message(asset_refused(&b, rest, 0), expected);
        asset_free(&a);
        asset_free(&b);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_baked),
        cmocka_unit_test(test_moved),
        cmocka_unit_test(test_too_large),
        cmocka_unit_test(test_computed_deltas),
        cmocka_unit_test(test_rounded_deltas),
        cmocka_unit_test(test_tangent_deltas),
        cmocka_unit_test(test_indices),
        cmocka_unit_test(test_sparse),
        cmocka_unit_test(test_compressed),
        cmocka_unit_test(test_octahedral),
        cmocka_unit_test(test_compressed_again),
        cmocka_unit_test(test_compressed_twice),
        cmocka_unit_test(test_compressed_rotations),
        cmocka_unit_test(test_filters),
        cmocka_unit_test(test_between_keys),
        cmocka_unit_test(test_animations_refused),
        cmocka_unit_test(test_data_uris),
        cmocka_unit_test(test_half_decoded),
        cmocka_unit_test(test_more_floats_computed),
        cmocka_unit_test(test_more_floats_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
