/* Normal maps with planted faults: images made here from heights that are known in closed form, and
 * written by libpng and libjpeg; beside each what comes nearest to the fault and is right. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>
#include <jpeglib.h>
#include <png.h>
#include <norma/check.h>
#include "document_bytes.h"
#include "gltf_asset.h"

enum { SIDE = 128 };
typedef struct image {
    uint8_t texels[SIDE * SIDE][3];
} image;

/* ---- images */

static void encode(uint8_t out[3], double x, double y, double z) {
    const double length = sqrt(x * x + y * y + z * z), n[3] = {x, y, z};
    for (int k = 0; k < 3; ++k) out[k] = (uint8_t)lround((n[k] / length + 1) * 127.5);
}

/* Heights h(u, v) by their slopes; v runs down, and glTF's green up. */
typedef void slope_at(double u, double v, double *across, double *down);

static void paint(image *im, slope_at *slope) {
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            double across, down;
            slope((x + .5) / SIDE, (y + .5) / SIDE, &across, &down);
            encode(im->texels[y * SIDE + x], -across, down, 1);
        }
}

/* h = a sin(6 u + 3 v) cos(5 v) and a finer one */
static void hills(double u, double v, double *across, double *down) {
    const double a = 12 * 6.283 * u / 4 + 9 * v, b = 31 * v;
    *across = .5 * cos(a) * cos(b) + .3 * cos(70 * u + 55 * v);
    *down = .5 * (9 / (12 * 6.283 / 4)) * cos(a) * cos(b) -
            .5 * (31 / (12 * 6.283 / 4)) * sin(a) * sin(b) + .3 * (55. / 70) * cos(70 * u + 55 * v);
}
/* h = r^2-shaped domes on a lattice: studs */
static void studs(double u, double v, double *across, double *down) {
    const double x = u * 8 - floor(u * 8) - .5, y = v * 8 - floor(v * 8) - .5, r = hypot(x, y),
                 steep = r < .4 ? sin(r / .4 * 3.14159) : 0;
    *across = -steep * x / (r + 1e-9);
    *down = -steep * y / (r + 1e-9);
}
/* Nothing changes along the stripes. */
static void stripes(double u, double v, double *across, double *down) {
    (void)v;
    *across = sin(60 * u);
    *down = 0;
}

static void turn_green(image *im) {
    for (size_t i = 0; i < SIDE * SIDE; ++i) im->texels[i][1] = (uint8_t)(255 - im->texels[i][1]);
}

static uint32_t next(uint32_t *seed) { return *seed = *seed * 1664525 + 1013904223; }

/* Unit vectors that belong to no surface. */
static void paint_noise(image *im, uint32_t seed) {
    for (size_t i = 0; i < SIDE * SIDE; ++i)
        encode(im->texels[i], (int)(next(&seed) >> 20) / 2048. - 1,
            (int)(next(&seed) >> 20) / 2048. - 1, 1.5);
}

static void fill(image *im, uint8_t r, uint8_t g, uint8_t b) {
    for (size_t i = 0; i < SIDE * SIDE; ++i)
        im->texels[i][0] = r, im->texels[i][1] = g, im->texels[i][2] = b;
}

static void *write_png(const image *im, size_t *size) {
    png_image png = {
        .version = PNG_IMAGE_VERSION, .width = SIDE, .height = SIDE, .format = PNG_FORMAT_RGB};
    png_alloc_size_t room = 0;
    assert_true(png_image_write_get_memory_size(png, room, 0, im->texels, 0, NULL));
    void *bytes = malloc(room);
    assert_true(png_image_write_to_memory(&png, bytes, &room, 0, im->texels, 0, NULL));
    *size = room;
    return bytes;
}

/* quality: below 90 the colours are stored with half the texels each way. */
static void *write_jpeg(const image *im, int quality, int progressive, size_t *size) {
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr manager;
    unsigned char *bytes = NULL;
    unsigned long room = 0;
    jpeg.err = jpeg_std_error(&manager);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &room);
    jpeg.image_width = jpeg.image_height = SIDE;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, quality, TRUE);
    if (quality >= 90) jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
    if (progressive) jpeg_simple_progression(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < SIDE) {
        uint8_t line[3 * SIDE];
        JSAMPROW row = line;
        memcpy(line, im->texels[SIDE * jpeg.next_scanline], sizeof line);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    *size = room;
    return bytes;
}

/* ---- a square that shows a part of it */

typedef struct shown {
    float from[2], to[2];  /* texture coordinates of two opposite corners */
    const char *transform; /* of the texture's info: "" or ",..." */
    const char *wrap;      /* samplers: "" or members */
} shown;
static const shown whole = {{0, 0}, {1, 1}, "", ""};

/* a: freed once the document is closed. */
static norma_document *open_square(
    gltf_asset *a, const void *bytes, size_t size, const char *type, const shown *s) {
    const float at[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                up[4][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}},
                uvs[4][2] = {{s->from[0], s->to[1]}, {s->to[0], s->to[1]}, {s->to[0], s->from[1]},
                    {s->from[0], s->from[1]}};
    const uint16_t corners[6] = {0, 1, 2, 0, 2, 3};
    char rest[1000];
    asset_floats(a, &at[0][0], 4, 3);
    asset_floats(a, &up[0][0], 4, 3);
    asset_uint16(a, corners, 6);
    asset_floats(a, &uvs[0][0], 4, 2);
    const int view = asset_view(a, bytes, size, "");
    snprintf(rest, sizeof rest,
        "\"images\":[{\"bufferView\":%d,\"mimeType\":\"image/%s\"}],\"samplers\":[{%s}],"
        "\"textures\":[{\"source\":0,\"sampler\":0}],\"materials\":[{\"normalTexture\":{"
        "\"index\":0%s}}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,"
        "\"NORMAL\":1,\"TEXCOORD_0\":3},\"indices\":2,\"material\":0}]}]",
        view, type, s->wrap, s->transform);
    return asset_open(a, rest, 1);
}

static norma_findings *check_bytes(const void *bytes, size_t size, const shown *s) {
    gltf_asset a = {0};
    uint8_t mask[128] = {0};
    norma_findings *findings;
    norma_document_error error;
    assert_int_equal(norma_rules_select("N002,N811,N812", mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    norma_document *document = open_square(&a, bytes, size, "png", s);
    if (norma_check_document(document, &options, &findings, &error)) fail_msg("%s", error.message);
    norma_document_close(document);
    asset_free(&a);
    return findings;
}

/* What is found, "N811 N812"; the first finding's message in message, where it is wanted. */
static const char *rules_of(norma_findings *findings, char message[400]) {
    static char text[100];
    text[0] = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *f = norma_findings_get(findings, i);
        assert_int_equal(f->severity, NORMA_SEVERITY_WARNING);
        assert_int_equal(f->count, 1);
        assert_string_equal(
            f->where, strcmp(f->rule->id, "N002") ? "/meshes/0/primitives/0" : "/images/0");
        if (message && i == 0) snprintf(message, 400, "%s", f->message);
        snprintf(
            text + strlen(text), sizeof text - strlen(text), "%s%s", i ? " " : "", f->rule->id);
    }
    norma_findings_free(findings);
    return text;
}

/* The same of both kinds of file. */
static const char *found(const image *im, const shown *s) {
    static char first[100];
    size_t size;
    void *bytes = write_png(im, &size);
    snprintf(first, sizeof first, "%s", rules_of(check_bytes(bytes, size, s), NULL));
    free(bytes);
    for (int progressive = 0; progressive < 2; ++progressive) {
        bytes = write_jpeg(im, 95, progressive, &size);
        assert_string_equal(rules_of(check_bytes(bytes, size, s), NULL), first);
        free(bytes);
    }
    return first;
}

/* ---- N811 */

static void test_not_unit(void **state) {
    (void)state;
    static image im;
    paint(&im, hills);
    assert_string_equal(found(&im, &whole), "");
    for (size_t y = 0; y < SIDE; ++y) /* a photograph in the right half */
        for (size_t x = SIDE / 2; x < SIDE; ++x)
            for (size_t k = 0; k < 3; ++k)
                im.texels[y * SIDE + x][k] = (uint8_t)(40 + (x * 7 + y * 3 + k * 50) % 60);
    assert_string_equal(found(&im, &whole), "N811");
    assert_string_equal(found(&im, &(shown){{0, 0}, {.5F, 1}, "", ""}), "");
    /* Four per cent of what is shown, then seven. */
    assert_string_equal(found(&im, &(shown){{0, 0}, {.52F, 1}, "", ""}), "");
    assert_string_equal(found(&im, &(shown){{0, 0}, {.54F, 1}, "", ""}), "N811");
}

/* Directions below the surface are wrong whatever their length. */
static void test_below_surface(void **state) {
    (void)state;
    static image im;
    for (size_t i = 0; i < SIDE * SIDE; ++i) encode(im.texels[i], .3, i % 2 ? .2 : .1, -1);
    assert_string_equal(found(&im, &whole), "N811");
    for (size_t i = 0; i < SIDE * SIDE; ++i) encode(im.texels[i], .3, i % 2 ? .2 : .1, 1);
    assert_string_equal(found(&im, &whole), "");
}

static void test_where_it_is_looked_up(void **state) {
    (void)state;
    static image im;
    fill(&im, 128, 128, 255);
    for (size_t i = 0; i < SIDE * SIDE; ++i) /* the lower left quarter is grey */
        if (i % SIDE < SIDE / 2 && i / SIDE >= SIDE / 2)
            memset(im.texels[i], (int)(90 + i % 30), 3);
    const shown corner = {{.05F, .05F}, {.45F, .45F}, "", ""};
    assert_string_equal(found(&im, &corner), "");
#define MOVED(TEXT) ",\"extensions\":{\"KHR_texture_transform\":{" TEXT "}}"
    shown s = corner;
    s.transform = MOVED("\"offset\":[0,0.5]");
    assert_string_equal(found(&im, &s), "N811");
    s.transform = MOVED("\"offset\":[0.5,0.5]");
    assert_string_equal(found(&im, &s), "");
    s.transform = MOVED("\"offset\":[0,1],\"rotation\":1.5707963"); /* u' = v, v' = 1 - u */
    assert_string_equal(found(&im, &s), "N811");
    s.transform = MOVED("\"scale\":[1,-1]"); /* v from -.05 to -.45: the last rows, as it repeats */
    assert_string_equal(found(&im, &s), "N811");
    s.wrap = "\"wrapT\":33648"; /* mirrored: the first ones */
    assert_string_equal(found(&im, &s), "");
    s.wrap = "\"wrapT\":33071"; /* clamped: the very first one */
    assert_string_equal(found(&im, &s), "");
    /* Far away, and often: as it repeats. */
    assert_string_equal(
        found(&im, &(shown){{100.05F, -99.45F}, {100.45F, -99.05F}, "", ""}), "N811");
    assert_string_equal(found(&im, &(shown){{-40, -40}, {40, 40}, "", ""}), "N811");
}

static void test_one_value(void **state) {
    (void)state;
    static const uint8_t flat[][3] = {{128, 128, 255}, {127, 127, 255}, {127, 128, 255}};
    static image im;
    char message[400];
    for (size_t i = 0; i < 3; ++i) {
        fill(&im, flat[i][0], flat[i][1], flat[i][2]);
        size_t size;
        void *bytes = write_png(&im, &size);
        assert_string_equal(rules_of(check_bytes(bytes, size, &whole), NULL), "");
        free(bytes);
    }
    fill(&im, 255, 128, 128); /* a unit vector, the same everywhere */
    size_t size;
    void *bytes = write_png(&im, &size);
    assert_string_equal(rules_of(check_bytes(bytes, size, &whole), message), "N811");
    assert_non_null(strstr(message, "(255, 128, 128)"));
    free(bytes);
}

/* ---- N812 */

static void test_green(void **state) {
    (void)state;
    static slope_at *const surfaces[] = {hills, studs};
    static image im;
    for (size_t i = 0; i < sizeof surfaces / sizeof *surfaces; ++i) {
        paint(&im, surfaces[i]);
        assert_string_equal(found(&im, &whole), "");
        turn_green(&im);
        assert_string_equal(found(&im, &whole), "N812");
        /* A chart that is mirrored or turned on the surface shows the same image. */
        assert_string_equal(found(&im, &(shown){{1, 0}, {0, 1}, "", ""}), "N812");
        assert_string_equal(
            found(&im, &(shown){{0, 0}, {1, 1}, MOVED("\"rotation\":0.6"), ""}), "N812");
    }
}

static void test_green_undecided(void **state) {
    (void)state;
    static image im;
    paint(&im, stripes);
    for (int turned = 0; turned < 2; ++turned, turn_green(&im))
        assert_string_equal(found(&im, &whole), "");
    for (uint32_t seed = 0; seed < 20; ++seed) {
        paint_noise(&im, seed);
        size_t size;
        void *bytes = write_png(&im, &size);
        assert_string_equal(rules_of(check_bytes(bytes, size, &whole), NULL), "");
        free(bytes);
        for (int quality = 50; quality < 100; quality += 15) { /* not of unit length any more */
            bytes = write_jpeg(&im, quality, 0, &size);
            assert_null(strstr(rules_of(check_bytes(bytes, size, &whole), NULL), "N812"));
            free(bytes);
        }
    }
}

/* Half of it of one convention, half of the other. */
static void test_green_of_both_kinds(void **state) {
    (void)state;
    static image im, turned;
    paint(&im, hills);
    turned = im;
    turn_green(&turned);
    memcpy(im.texels, turned.texels, sizeof im.texels / 2);
    assert_string_equal(found(&im, &whole), "");
    assert_string_equal(found(&im, &(shown){{0, 0}, {1, .5F}, "", ""}), "N812");
    assert_string_equal(found(&im, &(shown){{0, .5F}, {1, 1}, "", ""}), "");
}

/* ---- the fix of N812 */

static void read_jpeg(const void *bytes, size_t size, image *im) {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr manager;
    jpeg.err = jpeg_std_error(&manager);
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, bytes, (unsigned long)size);
    jpeg_read_header(&jpeg, TRUE);
    jpeg_start_decompress(&jpeg);
    while (jpeg.output_scanline < SIDE) {
        JSAMPROW row = im->texels[SIDE * jpeg.output_scanline];
        jpeg_read_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_decompress(&jpeg);
    jpeg_destroy_decompress(&jpeg);
}

static void fix_green(norma_document *document) {
    uint8_t mask[128] = {0};
    norma_fix_summary summary;
    norma_document_error error;
    assert_int_equal(norma_rules_select("N812", mask, NULL), NORMA_OK);
    const norma_check_options options = {.struct_size = sizeof options, .rules = mask};
    for (int again = 0; again < 2; ++again) {
        if (norma_fix_document(document, &options, 1, &summary, &error))
            fail_msg("%s", error.message);
        assert_int_equal(summary.changed, !again);
    }
}

/* A JPEG becomes a PNG of what libjpeg makes of it, its green inverted; and the file says so. */
static void test_turn_jpeg(void **state) {
    (void)state;
    static image im, was, now;
    paint(&im, hills);
    turn_green(&im);
    for (int progressive = 0; progressive < 2; ++progressive) {
        size_t size;
        uint8_t *bytes = write_jpeg(&im, 95, progressive, &size);
        gltf_asset a = {0};
        norma_texture_info map;
        norma_document *document = open_square(&a, bytes, size, "jpeg", &whole);
        fix_green(document);
        assert_non_null(strstr(norma_document_note(document, 0), "a JPEG, becomes a PNG"));
        assert_int_equal(norma_document_normal_map(document, 0, &map, NULL), NORMA_DOCUMENT_OK);
        png_image png = {.version = PNG_IMAGE_VERSION};
        assert_true(png_image_begin_read_from_memory(&png, map.bytes, map.size));
        assert_int_equal(png.format, PNG_FORMAT_RGB);
        assert_int_equal(png.width * png.height, SIDE * SIDE);
        assert_true(png_image_finish_read(&png, NULL, now.texels, 0, NULL));
        read_jpeg(bytes, size, &was);
        turn_green(&was);
        assert_memory_equal(&was, &now, sizeof was);
        document_bytes out = bytes_of(document);
        const char *json = (const char *)out.data + 20;
        assert_non_null(strstr(json, "\"mimeType\":\"image/png\""));
        assert_null(strstr(json, "jpeg"));
        bytes_free(&out);
        norma_document_close(document);
        asset_free(&a);
        free(bytes);
    }
}

/* ---- N002 */

static void test_damaged(void **state) {
    (void)state;
    static image im;
    paint(&im, hills);
    for (int kind = 0; kind < 3; ++kind) {
        size_t size;
        uint8_t *bytes = kind ? write_jpeg(&im, 85, kind - 1, &size) : write_png(&im, &size);
        for (size_t cut = 1; cut < size - 40; cut += size / 23)
            assert_string_equal(rules_of(check_bytes(bytes, cut, &whole), NULL), "N002");
        for (size_t at = 20, seed = 1; at < size; at += size / 31 + seed++ % 3) {
            const uint8_t was = bytes[at];
            bytes[at] ^= 0x55;
            norma_findings_free(check_bytes(bytes, size, &whole));
            bytes[at] = was;
        }
        free(bytes);
    }
    assert_string_equal(rules_of(check_bytes("RIFF____WEBPVP8 ", 16, &whole), NULL), "N002");
}

/* Four inks: libjpeg makes no red, green and blue of them. */
static void test_cmyk(void **state) {
    (void)state;
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr manager;
    unsigned char *bytes = NULL;
    unsigned long room = 0;
    char message[400];
    jpeg.err = jpeg_std_error(&manager);
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &bytes, &room);
    jpeg.image_width = jpeg.image_height = 16;
    jpeg.input_components = 4;
    jpeg.in_color_space = JCS_CMYK;
    jpeg_set_defaults(&jpeg);
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < 16) {
        uint8_t line[4 * 16] = {0};
        JSAMPROW row = line;
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    assert_string_equal(rules_of(check_bytes(bytes, room, &whole), message), "N002");
    assert_non_null(strstr(message, "a JPEG in CMYK"));
    free(bytes);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_not_unit),
        cmocka_unit_test(test_below_surface),
        cmocka_unit_test(test_where_it_is_looked_up),
        cmocka_unit_test(test_one_value),
        cmocka_unit_test(test_green),
        cmocka_unit_test(test_green_undecided),
        cmocka_unit_test(test_green_of_both_kinds),
        cmocka_unit_test(test_turn_jpeg),
        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_cmyk),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
