/* test_overwritten.c: another program overwrites a file at its old size while it is used. A
 * document that is open uses what it read, whatever the file holds now: the output is that of the
 * old file, byte for byte. A file that is overwritten again and again while it is opened is
 * refused, or read as something that a mesh can be; nothing ever reads outside its arrays, which
 * the address sanitizer watches. */
#define _GNU_SOURCE /* utimensat, pwrite */
#include <fcntl.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cmocka.h>
#include "document_bytes.h"

enum { SIDE = 110, VERTICES = (SIDE + 1) * (SIDE + 1), FACES = 2 * SIDE * SIDE, ROUNDS = 12 };

typedef struct bytes {
    char *data;
    size_t size;
} bytes;

static void add(bytes *b, const void *data, size_t size) {
    memcpy(b->data + b->size, data, size);
    b->size += size;
}

static void add_text(bytes *b, const char *text) { add(b, text, strlen(text)); }

static void position(size_t v, float out[3]) {
    out[0] = (float)(v % (SIDE + 1));
    out[1] = (float)(v / (SIDE + 1));
    out[2] = (float)(v * 7919 % 97) * .03125f;
}

static void triangle(size_t f, uint32_t out[3]) {
    const uint32_t quad = (uint32_t)(f / 2), corner = quad / SIDE * (SIDE + 1) + quad % SIDE;
    out[0] = corner + (f % 2 ? 1 : 0);
    out[1] = corner + (f % 2 ? SIDE + 2 : 1);
    out[2] = corner + SIDE + 1;
}

static void make_obj(bytes *b) {
    char line[100];
    float p[3];
    uint32_t t[3];
    for (size_t v = 0; v < VERTICES; ++v) {
        position(v, p);
        snprintf(line, sizeof line, "v %g %g %g\n", (double)p[0], (double)p[1], (double)p[2]);
        add_text(b, line);
    }
    for (size_t f = 0; f < FACES; ++f) {
        triangle(f, t);
        snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
        add_text(b, line);
    }
}

static void make_ply(bytes *b) {
    char header[400];
    float p[3];
    uint32_t t[3];
    snprintf(header, sizeof header,
        "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float "
        "y\nproperty float z\nelement face %d\nproperty list uchar int "
        "vertex_indices\nend_header\n",
        VERTICES, FACES);
    add_text(b, header);
    for (size_t v = 0; v < VERTICES; ++v) position(v, p), add(b, p, sizeof p);
    for (size_t f = 0; f < FACES; ++f) triangle(f, t), add(b, "\3", 1), add(b, t, sizeof t);
}

static void make_stl(bytes *b) {
    const uint32_t count = FACES;
    uint32_t t[3];
    float p[12] = {0};
    add(b, (const char[80]){0}, 80);
    add(b, &count, sizeof count);
    for (size_t f = 0; f < FACES; ++f) {
        triangle(f, t);
        for (int k = 0; k < 3; ++k) position(t[k], p + 3 + 3 * k);
        add(b, p, sizeof p);
        add(b, "\0", 2);
    }
}

static void make_glb(bytes *b) {
    char json[1000];
    float p[3];
    uint32_t t[3];
    const uint32_t size = 12 * (VERTICES + FACES);
    int length = snprintf(json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%u}],\"bufferViews\":[{"
        "\"buffer\":0,\"byteLength\":%d},{\"buffer\":0,\"byteOffset\":%d,\"byteLength\":%d}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%d,\"type\":\"VEC3\"},{"
        "\"bufferView\":1,\"componentType\":5125,\"count\":%d,\"type\":\"SCALAR\"}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"nodes\":[{\"mesh\":0}"
        "]}",
        size, 12 * VERTICES, 12 * VERTICES, 12 * FACES, VERTICES, 3 * FACES);
    while (length % 4) json[length++] = ' ';
    const uint32_t head[5] = {
        0x46546C67, 2, 28 + (uint32_t)length + size, (uint32_t)length, 0x4E4F534A};
    const uint32_t chunk[2] = {size, 0x004E4942};
    add(b, head, sizeof head);
    add(b, json, (size_t)length);
    add(b, chunk, sizeof chunk);
    for (size_t v = 0; v < VERTICES; ++v) position(v, p), add(b, p, sizeof p);
    for (size_t f = 0; f < FACES; ++f) triangle(f, t), add(b, t, sizeof t);
}

/* ---- files */

static void path_of(const char *name, char path[400]) {
    const char *folder = getenv("NORMA_SCRATCH");
    snprintf(path, 400, "%s/overwritten-%s", folder ? folder : "/tmp", name);
}

/* In place: another program's write, which keeps the file what it is. */
static void overwrite(const char *path, const void *data, size_t size) {
    const int file = open(path, O_WRONLY | O_CREAT, 0666);
    assert_true(file >= 0);
    for (size_t at = 0; at < size;) {
        const ssize_t put = write(file, (const char *)data + at, size - at);
        assert_true(put > 0);
        at += (size_t)put;
    }
    close(file);
}

static document_bytes compute(norma_document *document) {
    const norma_compute_options options = {
        .struct_size = sizeof options, .shading = NORMA_SHADING_DEFAULT};
    norma_document_error error;
    assert_int_equal(norma_document_compute(document, &options, NULL, &error), NORMA_DOCUMENT_OK);
    return bytes_of(document);
}

typedef struct kind {
    const char *name;
    void (*make)(bytes *b);
} kind;
static const kind kinds[] = {
    {"a.obj", make_obj}, {"a.ply", make_ply}, {"a.stl", make_stl}, {"a.glb", make_glb}};
enum { KINDS = sizeof kinds / sizeof kinds[0] };

static bytes make(const kind *k, char path[400]) {
    bytes b = {malloc((size_t)4 << 20), 0};
    assert_non_null(b.data);
    k->make(&b);
    path_of(k->name, path);
    overwrite(path, b.data, b.size);
    return b;
}

static norma_document *open_file(const char *path) {
    norma_document *document;
    norma_document_error error;
    assert_int_equal(norma_document_open(path, NULL, &document, &error), NORMA_DOCUMENT_OK);
    return document;
}

/* ---- tests */

static void an_open_document_keeps_what_it_read(void **state) {
    (void)state;
    for (size_t i = 0; i < KINDS; ++i) {
        char path[400];
        bytes old = make(&kinds[i], path);
        char *other = malloc(old.size);
        struct stat before;
        assert_non_null(other);
        memset(other, 0xFE, old.size);
        assert_true(old.size > 300000 && stat(path, &before) == 0);
        norma_document *document = open_file(path);
        document_bytes expected = compute(document);
        norma_document_close(document);

        document = open_file(path);
        overwrite(path, other, old.size);
        const struct timespec times[2] = {before.st_atim, before.st_mtim};
        assert_int_equal(utimensat(AT_FDCWD, path, times, 0), 0); /* nothing shows that it did */
        document_bytes got = compute(document);
        norma_document_close(document);
        assert_true(bytes_equal(got, expected));
        remove(path);
        bytes_free(&got);
        bytes_free(&expected);
        free(old.data);
        free(other);
    }
}

typedef struct writer {
    const char *path;
    const bytes *old;
    atomic_int stop;
} writer;

/* Turns part of the file into large numbers and back, as fast as it can. */
static void *write_on(void *context) {
    writer *w = context;
    char other[4096];
    unsigned seed = 1;
    const int file = open(w->path, O_RDWR);
    memset(other, 0xFE, sizeof other);
    while (file >= 0 && !atomic_load(&w->stop)) {
        seed = seed * 1664525 + 1013904223;
        const size_t at = seed / 16 % (w->old->size - sizeof other);
        ssize_t put = pwrite(file, other, sizeof other, (off_t)at);
        put += pwrite(file, w->old->data + at, sizeof other, (off_t)at);
        if (put < 0) break;
    }
    if (file >= 0) close(file);
    return NULL;
}

static void a_file_that_changes_is_refused_or_read(void **state) {
    (void)state;
    for (size_t i = 0; i < KINDS; ++i) {
        char path[400];
        bytes old = make(&kinds[i], path);
        writer w = {.path = path, .old = &old};
        pthread_t thread;
        assert_int_equal(pthread_create(&thread, NULL, write_on, &w), 0);
        for (int round = 0; round < ROUNDS; ++round) {
            norma_document *document;
            norma_document_error error;
            const norma_document_options options = {.struct_size = sizeof options,
                .depth = round % 3 ? NORMA_DOCUMENT_WHOLE : NORMA_DOCUMENT_SUMMARY};
            const norma_document_result result =
                norma_document_open(path, &options, &document, &error);
            assert_true(result == NORMA_DOCUMENT_OK || error.message[0]);
            if (!result) norma_document_compute(document, NULL, NULL, &error);
            norma_document_close(document);
        }
        atomic_store(&w.stop, 1);
        pthread_join(thread, NULL);
        remove(path);
        free(old.data);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(an_open_document_keeps_what_it_read),
        cmocka_unit_test(a_file_that_changes_is_refused_or_read)};
    return cmocka_run_group_tests_name("files overwritten while in use", tests, NULL, NULL);
}
