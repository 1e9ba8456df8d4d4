/* test_together.c: one surface in several files: what a pattern that locks is told to have matched.
 */
#define _POSIX_C_SOURCE 200809L
#include "check.h"
#include "document_bytes.h"
#include <norma/large.h>
#include <unistd.h>

static char folder[64] = "/tmp/norma-together-XXXXXX";

static void write_file(const char *name, const char *text, char path[100]) {
    snprintf(path, 100, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(text, 1, strlen(text), file), strlen(text));
    assert_int_equal(fclose(file), 0);
}

/* Names of meshes and materials, of objects, groups and materials, of files; in each of both passes
 * over the files they are met, and counted once. */
static void locks_say_what_they_matched(void **state) {
    static const char gltf[] =
        "{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"name\":\"skin\"}],\"meshes\":[{"
        "\"name\":"
        "\"head\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[0,0,0]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
        "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
        "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}]}",
                      obj[] = "o body\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\ng left arm\n"
                              "f 1//1 2//1 3//1\nusemtl skin\nf 1//1 2//1 3//1\n",
                      ply[] =
                          "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
                          "property float y\nproperty float z\nelement face 1\nproperty list "
                          "uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    static const char *const lock[] = {"skin", "head", "[ab]*", "hand.ply", "nobody", "arm"};
    static const size_t expected[] = {2, 1, 2, 1, 0, 1};
    size_t matches[COUNT_OF(lock)] = {99, 99, 99, 99, 99, 99};
    char paths[3][100];
    norma_document_error error = {0};
    (void)state;
    assert_non_null(mkdtemp(folder));
    write_file("a.gltf", gltf, paths[0]);
    write_file("b.obj", obj, paths[1]);
    write_file("hand.ply", ply, paths[2]);
    const norma_together_file files[] = {{.input = paths[0], .output = paths[0]},
        {.input = paths[1], .output = paths[1]}, {.input = paths[2], .output = paths[2]}};
    norma_together_options options = {.struct_size = sizeof options,
        .lock = lock,
        .lock_count = COUNT_OF(lock),
        .in_place = 1,
        .lock_matches = matches};
    const norma_compute_options compute = {
        .struct_size = sizeof compute, .weld = NORMA_WELD_DISTANCE, .weld_distance = 1e-3};
    if (norma_together_compute(files, 3, &options, &compute, &error)) fail_msg("%s", error.message);
    for (size_t i = 0; i < COUNT_OF(lock); ++i)
        if (matches[i] != expected[i])
            fail_msg("%s matched %zu names, not %zu", lock[i], matches[i], expected[i]);
    options.struct_size = offsetof(norma_together_options, lock_matches); /* of an older caller */
    matches[0] = 99;
    if (norma_together_compute(files, 3, &options, &compute, &error)) fail_msg("%s", error.message);
    assert_int_equal(matches[0], 99);
    for (int i = 0; i < 3; ++i) assert_int_equal(unlink(paths[i]), 0);
    assert_int_equal(rmdir(folder), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(locks_say_what_they_matched)};
    return cmocka_run_group_tests_name("one surface in several files", tests, NULL, NULL);
}
