/* test_document_large.c: a file of many megabytes, read in large pages, gives the bytes that it
 * gives from memory. The meshes are small, but for the glTF's; what makes the files large is
 * comments, an element and a view that nobody reads. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>
#include "document_bytes.h"
#include "gltf_asset.h"

enum { PADDING = 18 << 20, SIDE = 90 };

typedef struct text {
    char *data;
    size_t size, capacity;
} text;

static void add_bytes(text *t, const void *bytes, size_t size) {
    if (t->size + size > t->capacity) { /* a sanitizer's realloc copies every time */
        t->capacity = 2 * (t->size + size);
        t->data = realloc(t->data, t->capacity);
        assert_non_null(t->data);
    }
    memcpy(t->data + t->size, bytes, size);
    t->size += size;
}

#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
static void
add(text *t, const char *format, ...) {
    char line[256];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    assert_true(length >= 0 && (size_t)length < sizeof line);
    add_bytes(t, line, (size_t)length);
}

static void add_padding(text *t, size_t size) {
    char *padding = malloc(size);
    assert_non_null(padding);
    for (size_t i = 0; i < size; ++i)
        padding[i] = i % 64 == 0 ? '#' : i % 64 == 63 ? '\n' : (char)('a' + i / 64 % 23);
    add_bytes(t, padding, size);
    free(padding);
}

/* ---- a grid with a step in it: one hard edge from side to side */

static void position(size_t vertex, size_t side, float out[3]) {
    const size_t row = vertex / (side + 1), column = vertex % (side + 1);
    out[0] = (float)column;
    out[1] = (float)row;
    out[2] = row > side / 2 ? 4 + (float)(column % 5) * .125f : (float)(row * column % 7) * .0625f;
}

static void triangle(size_t number, size_t side, uint32_t out[3]) {
    const size_t quad = number / 2, a = quad / side * (side + 1) + quad % side;
    out[0] = (uint32_t)(number % 2 ? a + 1 : a);
    out[1] = (uint32_t)(number % 2 ? a + side + 2 : a + 1);
    out[2] = (uint32_t)(a + side + 1);
}

/* ---- from a file and from memory */

static void check(const text *file, const char *extension) {
    const char *folder = getenv("NORMA_SCRATCH");
    char from[300], to[300];
    norma_document *mapped;
    norma_document_error error;
    norma_compute_summary summary, summary_of_memory;
    norma_compute_options options = {.struct_size = sizeof options,
        .threads = 2,
        .shading = NORMA_SHADING_CREASE,
        .crease_angle_rad = 1};
    snprintf(from, sizeof from, "%s/norma-large-%ld.%s", folder ? folder : "/tmp", (long)getpid(),
        extension);
    snprintf(to, sizeof to, "%s/norma-large-%ld-out.%s", folder ? folder : "/tmp", (long)getpid(),
        extension);
    FILE *out = fopen(from, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(file->data, 1, file->size, out), file->size);
    assert_int_equal(fclose(out), 0);
    assert_int_equal(norma_document_open(from, NULL, &mapped, &error), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_compute(mapped, &options, &summary, &error), NORMA_DOCUMENT_OK);
    assert_int_equal(norma_document_save(mapped, to, NULL, &error), NORMA_DOCUMENT_OK);
    norma_document_close(mapped);
    const document_bytes source = {(unsigned char *)file->data, file->size};
    document_bytes expected = bytes_computed(source, from, &options, &summary_of_memory),
                   found = bytes_load(to);
    remove(from);
    remove(to);
    assert_true(bytes_equal(found, expected));
    assert_true(summary.changed && summary.hard_edges > 0);
    assert_memory_equal(&summary, &summary_of_memory, sizeof summary);
    bytes_free(&expected);
    bytes_free(&found);
}

static void obj(void **state) {
    text t = {0};
    (void)state;
    for (size_t v = 0; v < (SIDE + 1) * (SIDE + 1); ++v) {
        float p[3];
        position(v, SIDE, p);
        add(&t, "v %g %g %g\n", (double)p[0], (double)p[1], (double)p[2]);
    }
    add_padding(&t, PADDING);
    for (size_t f = 0; f < 2 * SIDE * SIDE; ++f) {
        uint32_t c[3];
        triangle(f, SIDE, c);
        add(&t, "f %u %u %u\n", c[0] + 1, c[1] + 1, c[2] + 1);
    }
    check(&t, "obj");
    free(t.data);
}

static void ply(void **state) {
    text t = {0};
    (void)state;
    add(&t,
        "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float "
        "y\nproperty float z\n",
        (SIDE + 1) * (SIDE + 1));
    add(&t,
        "element face %d\nproperty list uchar int vertex_indices\nelement other %d\nproperty uchar "
        "value\nend_header\n",
        2 * SIDE * SIDE, PADDING);
    for (size_t v = 0; v < (SIDE + 1) * (SIDE + 1); ++v) {
        float p[3];
        position(v, SIDE, p);
        add_bytes(&t, p, sizeof p);
    }
    for (size_t f = 0; f < 2 * SIDE * SIDE; ++f) {
        uint32_t c[3];
        triangle(f, SIDE, c);
        add_bytes(&t, "\3", 1);
        add_bytes(&t, c, sizeof c);
    }
    add_padding(&t, PADDING);
    check(&t, "ply");
    free(t.data);
}

/* A mesh of more than a million corners: it is for such that its file leaves memory. */
static void glb(void **state) {
    enum { LONG_SIDE = 420 };
    const size_t vertices = (LONG_SIDE + 1) * (LONG_SIDE + 1), faces = 2 * LONG_SIDE * LONG_SIDE;
    float *positions = malloc(vertices * 12);
    uint32_t *corners = malloc(faces * 12);
    text padding = {0}, t;
    gltf_asset a = {0};
    char json[200];
    (void)state;
    assert_true(positions && corners);
    for (size_t v = 0; v < vertices; ++v) position(v, LONG_SIDE, positions + 3 * v);
    for (size_t f = 0; f < faces; ++f) triangle(f, LONG_SIDE, corners + 3 * f);
    const int at = asset_floats(&a, positions, vertices, 3),
              view = asset_view(&a, corners, faces * 12, "");
    snprintf(json, sizeof json,
        "{\"bufferView\": %d, \"componentType\": 5125, \"count\": %zu, \"type\": \"SCALAR\"}", view,
        3 * faces);
    const int indices = asset_accessor(&a, json);
    add_padding(&padding, PADDING);
    asset_view(&a, padding.data, padding.size, "");
    snprintf(json, sizeof json,
        "\"meshes\": [{\"primitives\": [{\"attributes\": {\"POSITION\": %d}, \"indices\": %d}]}]",
        at, indices);
    asset_bytes(&a, json, &t.size);
    t.data = (char *)a.glb;
    check(&t, "glb");
    asset_free(&a);
    free(padding.data);
    free(positions);
    free(corners);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(obj), cmocka_unit_test(ply), cmocka_unit_test(glb)};
    return cmocka_run_group_tests_name("large files", tests, NULL, NULL);
}
