/* test_cancel.c: opening, computing, transforming and saving of every format, stopped at each call
 * of the progress function in turn: the answer is that it was cancelled, no file is there, the
 * fractions never fell, and what is not stopped gives the bytes that it gives unwatched. On the
 * calling thread alone, and on three. */
#define _POSIX_C_SOURCE 200809L
#include "check.h"
#include "document_bytes.h"
#include "gltf_asset.h"
#include "mesh_files.h"
#include "watcher.h"
#include <unistd.h>

enum { SIDE = 90 }; /* squares of a wavy grid: large enough for several blocks of each kind */

static double height(int x, int y) { return 3 * sin(x * .3) * cos(y * .2); }

static document_bytes grid_obj(void) {
    document_bytes file = {malloc(1 << 21), 0};
    char *to = (char *)file.data;
    for (int y = 0; y <= SIDE; ++y)
        for (int x = 0; x <= SIDE; ++x) to += sprintf(to, "v %d %d %.4f\n", x, y, height(x, y));
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            const int a = y * (SIDE + 1) + x + 1;
            to += sprintf(to, "f %d %d %d %d\n", a, a + 1, a + SIDE + 2, a + SIDE + 1);
        }
    file.size = (size_t)(to - (char *)file.data);
    return file;
}

static document_bytes grid_ply(void) {
    document_bytes file = {malloc(1 << 21), 0};
    char *to = (char *)file.data;
    to += sprintf(to,
        "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty "
        "float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n",
        (SIDE + 1) * (SIDE + 1), SIDE * SIDE);
    for (int y = 0; y <= SIDE; ++y)
        for (int x = 0; x <= SIDE; ++x) to += sprintf(to, "%d %d %.4f\n", x, y, height(x, y));
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            const int a = y * (SIDE + 1) + x;
            to += sprintf(to, "4 %d %d %d %d\n", a, a + 1, a + SIDE + 2, a + SIDE + 1);
        }
    file.size = (size_t)(to - (char *)file.data);
    return file;
}

static document_bytes grid_stl(int binary) {
    document_bytes file = {calloc(1 << 23, 1), 0};
    char *to = (char *)file.data;
    const uint32_t facets = SIDE * SIDE;
    if (binary)
        memcpy(to + 80, &facets, 4), to += 84;
    else
        to += sprintf(to, "solid grid\n");
    for (int y = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            const float p[12] = {0, 0, 0, (float)x, (float)y, (float)height(x, y), (float)x + 1,
                (float)y, (float)height(x + 1, y), (float)x, (float)y + 1, (float)height(x, y + 1)};
            if (binary)
                memcpy(to, p, 48), to += 50;
            else
                to += sprintf(to,
                    "facet normal 0 0 0\nouter loop\nvertex %g %g %g\nvertex %g %g %g\nvertex %g "
                    "%g %g\nendloop\nendfacet\n",
                    (double)p[3], (double)p[4], (double)p[5], (double)p[6], (double)p[7],
                    (double)p[8], (double)p[9], (double)p[10], (double)p[11]);
        }
    if (!binary) to += sprintf(to, "endsolid grid\n");
    file.size = (size_t)(to - (char *)file.data);
    return file;
}

static document_bytes grid_glb(void) {
    gltf_asset a = {0};
    float *positions = calloc((SIDE + 1) * (SIDE + 1), 3 * sizeof *positions),
          *sunken = calloc((SIDE + 1) * (SIDE + 1), 3 * sizeof *sunken);
    uint16_t *corners = calloc(SIDE * SIDE, 6 * sizeof *corners);
    for (int y = 0; y <= SIDE; ++y)
        for (int x = 0; x <= SIDE; ++x) {
            float *p = positions + 3 * (y * (SIDE + 1) + x);
            p[0] = (float)x, p[1] = (float)y, p[2] = (float)height(x, y);
            sunken[3 * (y * (SIDE + 1) + x) + 2] = (float)-height(x, y) / 2;
        }
    for (int y = 0, i = 0; y < SIDE; ++y)
        for (int x = 0; x < SIDE; ++x) {
            const int v = y * (SIDE + 1) + x,
                      list[6] = {v, v + 1, v + SIDE + 2, v, v + SIDE + 2, v + SIDE + 1};
            for (int k = 0; k < 6; ++k) corners[i++] = (uint16_t)list[k];
        }
    asset_floats(&a, positions, (SIDE + 1) * (SIDE + 1), 3);
    asset_uint16(&a, corners, 6 * SIDE * SIDE);
    asset_floats(&a, sunken, (SIDE + 1) * (SIDE + 1), 3);
    document_bytes file;
    asset_bytes(&a,
        "\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0,\"scale\":[1,2,1]}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"targets\":[{"
        "\"POSITION\":2}]}]}]",
        &file.size);
    document_bytes copy = bytes_copy(a.glb, file.size);
    asset_free(&a);
    free(positions);
    free(sunken);
    free(corners);
    return copy;
}

typedef enum verb { COMPUTE, COMPUTE_CREASES, TRANSFORM, VERBS } verb;

static norma_document_result change(norma_document *document, verb what, const char *name,
    uint32_t threads, watcher *w, norma_document_error *error) {
    const norma_compute_options compute = {.struct_size = sizeof compute,
        .shading =
            what == COMPUTE || strstr(name, ".stl") ? NORMA_SHADING_DEFAULT : NORMA_SHADING_CREASE,
        .crease_angle_rad = .3,
        .morphs = 1,
        .threads = threads,
        .progress = w ? watch : NULL,
        .progress_user = w};
    const norma_transform_options transform = {.struct_size = sizeof transform,
        .matrix = {0, 2, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1},
        .bake = 1,
        .threads = threads,
        .progress = w ? watch : NULL,
        .progress_user = w};
    return what == TRANSFORM ? norma_document_transform(document, &transform, NULL, error)
                             : norma_document_compute(document, &compute, NULL, error);
}

static document_bytes result_of(document_bytes file, const char *name, verb what) {
    norma_document *document = bytes_open(file, name);
    assert_int_equal(change(document, what, name, 1, NULL, NULL), NORMA_DOCUMENT_OK);
    document_bytes out = bytes_of(document);
    norma_document_close(document);
    return out;
}

/* Every call of the first few, then ever farther apart. */
static size_t next_stop(size_t stop) {
    return stop < 6 ? stop + 1 : stop + stop / (SLOWER > 1 ? 1 : 3);
}

/* After a cancelled change a document is what it was, and the change can be made again; but a
 * binary STL whose normals were being replaced can only be closed. */
static void check_cancelled(
    norma_document *document, verb what, const char *name, document_bytes expected) {
    const norma_document_result again = change(document, what, name, 1, NULL, NULL);
    if (what == TRANSFORM || !strstr(name, "binary.stl")) {
        assert_int_equal(again, NORMA_DOCUMENT_OK);
        document_bytes out = bytes_of(document);
        assert_true(bytes_equal(out, expected));
        bytes_free(&out);
    } else {
        assert_int_equal(again, NORMA_DOCUMENT_ERROR_ARGUMENT);
    }
}

static void check_change(document_bytes file, const char *name, verb what, uint32_t threads) {
    document_bytes expected = result_of(file, name, what);
    for (size_t stop = 1;; stop = next_stop(stop)) {
        watcher w = {.stop_at = stop};
        norma_document_error error = {0};
        norma_document *document = bytes_open(file, name);
        const norma_document_result result = change(document, what, name, threads, &w, &error);
        assert_false(w.fell);
        if (w.calls < stop) {
            assert_true(stop > 1); /* it was told at least once */
            assert_int_equal(result, NORMA_DOCUMENT_OK);
            document_bytes out = bytes_of(document);
            assert_true(bytes_equal(out, expected));
            bytes_free(&out);
            norma_document_close(document);
            break;
        }
        assert_int_equal(result, NORMA_DOCUMENT_CANCELLED);
        char text[100];
        snprintf(text, sizeof text, "%s: cancelled", name);
        assert_string_equal(error.message, text);
        assert_int_equal(w.calls, stop); /* who is told to stop asks no more */
        check_cancelled(document, what, name, expected);
        norma_document_close(document);
    }
    bytes_free(&expected);
}

static void check_opening(document_bytes file, const char *name, uint32_t threads) {
    for (size_t stop = 1;; stop = next_stop(stop)) {
        watcher w = {.stop_at = stop};
        const norma_document_options options = {.struct_size = sizeof options,
            .threads = threads,
            .progress = watch,
            .progress_user = &w};
        norma_document *document = NULL;
        norma_document_error error = {0};
        const norma_document_result result =
            norma_document_open_memory(file.data, file.size, name, &options, &document, &error);
        assert_false(w.fell);
        norma_document_close(document);
        if (w.calls < stop) {
            assert_int_equal(result, NORMA_DOCUMENT_OK);
            return;
        }
        assert_int_equal(result, NORMA_DOCUMENT_CANCELLED);
        assert_null(document);
    }
}

static void check_saving(document_bytes file, const char *name) {
    char folder[] = "/tmp/norma-cancel-XXXXXX", path[100];
    document_bytes expected = result_of(file, name, COMPUTE);
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/%s", folder, name);
    for (size_t stop = 1;; stop = next_stop(stop)) {
        watcher w = {.stop_at = stop};
        const norma_save_options options = {
            .struct_size = sizeof options, .progress = watch, .progress_user = &w};
        norma_document *document = bytes_open(file, name);
        assert_int_equal(change(document, COMPUTE, name, 1, NULL, NULL), NORMA_DOCUMENT_OK);
        const norma_document_result result = norma_document_save(document, path, &options, NULL);
        assert_false(w.fell);
        norma_document_close(document);
        if (w.calls < stop) {
            assert_int_equal(result, NORMA_DOCUMENT_OK);
            document_bytes out = bytes_load(path);
            assert_true(bytes_equal(out, expected));
            bytes_free(&out);
            break;
        }
        assert_int_equal(result, NORMA_DOCUMENT_CANCELLED);
        assert_int_not_equal(access(path, F_OK), 0);
    }
    unlink(path);
    assert_int_equal(rmdir(folder), 0); /* no temporary is left in it */
    bytes_free(&expected);
}

static void check_format(document_bytes file, const char *name) {
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        check_opening(file, name, threads);
        for (int v = 0; v < VERBS; ++v) check_change(file, name, (verb)v, threads);
    }
    check_saving(file, name);
    bytes_free(&file);
}

static void test_obj(void **state) {
    (void)state;
    check_format(grid_obj(), "grid.obj");
}
static void test_ply(void **state) {
    (void)state;
    check_format(grid_ply(), "grid.ply");
}
static void test_stl_text(void **state) {
    (void)state;
    check_format(grid_stl(0), "grid.stl");
}
static void test_stl_binary(void **state) {
    (void)state;
    check_format(grid_stl(1), "binary.stl");
}
static void test_glb(void **state) {
    (void)state;
    check_format(grid_glb(), "grid.glb");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_obj), cmocka_unit_test(test_ply),
        cmocka_unit_test(test_stl_text), cmocka_unit_test(test_stl_binary),
        cmocka_unit_test(test_glb)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
