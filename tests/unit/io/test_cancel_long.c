/* test_cancel_long.c: a statement, a list, a string or a blank of many megabytes is no reason to
 * keep a caller waiting who wants to stop: while one is read and written, the progress function is
 * called at least once for each megabyte of it that a pass over it looks at; and where it cancels,
 * nothing more happens. */
#define _POSIX_C_SOURCE 200809L
#include "check.h"
#include "document_bytes.h"
#include "watcher.h"
#include <unistd.h>

enum { LONG = 12 << 20, CALLS_A_PASS = (LONG >> 20) - 1 };

typedef struct long_file {
    const char *name, *head, *unit, *tail;
    size_t read, written; /* passes over the statement: to find its end and to read it; to find and
                           * to write what a mirror makes of it */
} long_file;

static const long_file files[] = {
    {"face.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\nf", " 1 2 4 3", "\n", 2, 2},
    {"line.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl", " 1 2 3", "\n", 2, 1},
    {"comment.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n#", "no blank", "\nf 3 2 1\n", 2, 1},
    {"material.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl", " a b", "\nf 1 2 3\n", 2, 1},
    {"facets.stl", "solid a\n",
        "facet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet ",
        "endsolid\n", 1, 1},
    {"name.stl", "solid ", "name ",
        "\nfacet normal 0 0 1 outer loop vertex 0 0 0 vertex 1 0 0 vertex 0 1 0 endloop endfacet\n"
        "endsolid\n",
        2, 1},
    {"list.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n6291456",
        " 1 2 0 0", "\n", 1, 1},
    {"surplus.ply",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0",
        " word", "\n3 0 1 2\n", 1, 1},
    {"numbers.gltf", "{\"asset\":{\"version\":\"2.0\"},\"extras\":[1", ",1", "]}", 1, 0},
    {"string.gltf", "{\"asset\":{\"version\":\"2.0\"},\"extras\":\"", "word", "\"}", 1, 0},
    {"blank.gltf", "{\"asset\":{\"version\":\"2.0\"},", "    ", "\"extras\":1}", 1, 0},
    {"data.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
        "\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[0,0,0]}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],\"bufferViews\":[{\"buffer\":0,"
        "\"byteLength\":36}],\"buffers\":[{\"byteLength\":9437184,"
        "\"uri\":\"data:application/octet-stream;base64,",
        "AAAA", "\"}]}", 2, 0},
};

static document_bytes make(const long_file *of) {
    const size_t head = strlen(of->head), unit = strlen(of->unit), tail = strlen(of->tail),
                 count = LONG / unit;
    document_bytes file = {malloc(head + count * unit + tail), head + count * unit + tail};
    assert_non_null(file.data);
    char *to = (char *)file.data;
    memcpy(to, of->head, head);
    for (size_t i = 0; i < count; ++i) memcpy(to + head + i * unit, of->unit, unit);
    memcpy(to + head + count * unit, of->tail, tail);
    return file;
}

static norma_document_result open_watched(
    document_bytes file, const char *name, uint32_t threads, watcher *w, norma_document **out) {
    const norma_document_options options = {
        .struct_size = sizeof options, .threads = threads, .progress = watch, .progress_user = w};
    const norma_document_result result =
        norma_document_open_memory(file.data, file.size, name, &options, out, NULL);
    assert_false(w->fell);
    return result;
}

/* Stopped at each of a few of its calls; then not at all. */
static norma_document *check_opening(document_bytes file, const long_file *of, uint32_t threads) {
    norma_document *document = NULL;
    watcher all = {0};
    assert_int_equal(open_watched(file, of->name, threads, &all, &document), NORMA_DOCUMENT_OK);
    if (threads == 1 &&
        all.calls < of->read * CALLS_A_PASS) /* with more, it waits, and asks by time */
        fail_msg("%s: %zu calls while %zu bytes are read", of->name, all.calls, file.size);
    for (size_t stop = 1; stop <= all.calls; stop += stop < 3 ? 1 : all.calls / 4 + 1) {
        watcher w = {.stop_at = stop};
        norma_document *cancelled = NULL;
        const norma_document_result result = open_watched(file, of->name, threads, &w, &cancelled);
        if (threads == 1 || w.calls >= stop) {
            assert_int_equal(result, NORMA_DOCUMENT_CANCELLED);
            assert_null(cancelled);
            assert_int_equal(w.calls, stop); /* who is told to stop asks no more */
        }
        norma_document_close(cancelled);
    }
    return document;
}

static norma_document_result save_watched(norma_document *document, const char *path, watcher *w) {
    const norma_save_options options = {
        .struct_size = sizeof options, .progress = watch, .progress_user = w};
    const norma_document_result result = norma_document_save(document, path, &options, NULL);
    assert_false(w->fell);
    return result;
}

/* A cancelled save leaves nothing behind, and the document can be saved afterwards. */
static void check_saving(norma_document *document, size_t size, const long_file *of) {
    char folder[] = "/tmp/norma-cancel-XXXXXX", path[100];
    const norma_transform_options mirror = {
        .struct_size = sizeof mirror, .matrix = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    assert_int_equal(norma_document_transform(document, &mirror, NULL, NULL), NORMA_DOCUMENT_OK);
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/%s", folder, of->name);
    watcher all = {0};
    assert_int_equal(save_watched(document, path, &all), NORMA_DOCUMENT_OK);
    assert_int_equal(unlink(path), 0);
    if (all.calls < of->written * CALLS_A_PASS)
        fail_msg("%s: %zu calls while %zu bytes are written", of->name, all.calls, size);
    for (size_t stop = 1; stop <= all.calls; stop += stop < 3 ? 1 : all.calls / 4 + 1) {
        watcher w = {.stop_at = stop};
        const norma_document_result result = save_watched(document, path, &w);
        assert_int_equal(result, NORMA_DOCUMENT_CANCELLED);
        assert_int_equal(w.calls, stop);
        assert_int_not_equal(access(path, F_OK), 0);
    }
    assert_int_equal(rmdir(folder), 0);
}

static norma_document_result transform_watched(norma_document *document, double step, watcher *w) {
    const norma_transform_options mirror = {.struct_size = sizeof mirror,
        .matrix = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, step, 0, 0, 1},
        .progress = w ? watch : NULL,
        .progress_user = w};
    return norma_document_transform(document, &mirror, NULL, NULL);
}

/* A cancelled change leaves what a change before it did, which still waits to become bytes. Not of
 * an OBJ, whose changes wait together. */
static void second_changes(void **state) {
    (void)state;
    const long_file *some[] = {&files[4], &files[6], &files[7]};
    for (size_t i = 0; i < sizeof some / sizeof *some; ++i) {
        document_bytes file = make(some[i]);
        norma_document *document = bytes_open(file, some[i]->name);
        assert_int_equal(transform_watched(document, 0, NULL), NORMA_DOCUMENT_OK);
        document_bytes once = bytes_of(document);
        for (size_t stop = 1; stop < 3; ++stop) {
            watcher w = {.stop_at = stop};
            assert_int_equal(transform_watched(document, 1, &w), NORMA_DOCUMENT_CANCELLED);
            document_bytes left = bytes_of(document);
            if (!bytes_equal(left, once))
                fail_msg("%s is another after call %zu", some[i]->name, stop);
            bytes_free(&left);
            norma_document_close(document);
            document = bytes_open(file, some[i]->name);
            assert_int_equal(transform_watched(document, 0, NULL), NORMA_DOCUMENT_OK);
        }
        norma_document_close(document);
        bytes_free(&once);
        bytes_free(&file);
    }
}

static void long_statements(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        document_bytes file = make(&files[i]);
        norma_document_close(check_opening(file, &files[i], 3));
        norma_document *document = check_opening(file, &files[i], 1);
        check_saving(document, file.size, &files[i]);
        norma_document_close(document);
        bytes_free(&file);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(long_statements), cmocka_unit_test(second_changes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
