/* test_gltf_data.c: every glTF and GLB of the data set: computed, written, opened again. Corner by
 * corner all attributes but normals and tangents are the bytes that they were; normals are unit; a
 * second time nothing changes; the broken files answer as INDEX.tsv expects. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "document_bytes.h"
#include "io/gltf/gltf.h"

static size_t files, refused, corners_compared;
static norma_compute_options options;

static gltf_array array_of(norma_document *document, uint32_t accessor, const char *name) {
    gltf_array array;
    norma_document_error error;
    if (norma_gltf_array(norma_gltf_of(document), accessor, &array, &error))
        fail_msg("%s: %s", name, error.message);
    return array;
}

static const uint32_t *corners_of(norma_document *document, uint32_t primitive, const char *name) {
    const uint32_t *corners;
    norma_document_error error;
    if (norma_gltf_corners(norma_gltf_of(document), primitive, &corners, &error))
        fail_msg("%s: %s", name, error.message);
    return corners;
}

/* The same bytes for each corner, through whatever indices. */
static void compare_set(norma_document *before, norma_document *after, uint32_t primitive,
    const gltf_attributes *a, const gltf_attributes *b, const char *name) {
    const gltf *x = norma_gltf_of(before), *y = norma_gltf_of(after);
    const uint32_t *old = corners_of(before, primitive, name),
                   *now = corners_of(after, primitive, name);
    for (uint32_t i = a->first; i < a->first + a->count; ++i) {
        const gltf_attribute *attribute = &x->attributes[i];
        uint32_t k = norma_gltf_find(y, b, attribute->name);
        assert_true(k != GLTF_NONE);
        if (strcmp(attribute->name, "NORMAL") == 0 || strcmp(attribute->name, "TANGENT") == 0)
            continue;
        gltf_array from = array_of(before, attribute->accessor, name),
                   to = array_of(after, y->attributes[k].accessor, name);
        size_t size = x->accessors[attribute->accessor].element_size;
        assert_true(from.component == to.component && from.width == to.width &&
                    from.normalized == to.normalized);
        for (size_t c = 0; c < 3 * x->primitives[primitive].faces; ++c, ++corners_compared)
            if (memcmp(from.data + old[c] * from.stride, to.data + now[c] * to.stride, size) != 0)
                fail_msg("%s: %s of corner %zu of %s is another", name, attribute->name, c,
                    x->primitives[primitive].where);
    }
}

static void check_unit(norma_document *after, uint32_t normal, const char *name) {
    gltf_array array = array_of(after, normal, name);
    double tolerance = array.component == GLTF_BYTE    ? .00682
                       : array.component == GLTF_SHORT ? 5e-5
                                                       : 1e-6;
    for (size_t v = 0; v < array.count; ++v) {
        float n[16];
        norma_gltf_floats(&array, v, n);
        double length = sqrt((double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] +
                             (double)n[2] * (double)n[2]);
        if (!(fabs(length - 1) <= tolerance))
            fail_msg("%s: normal %zu has length %g", name, v, length);
    }
}

static void compare(norma_document *before, norma_document *after, const char *name) {
    const gltf *x = norma_gltf_of(before), *y = norma_gltf_of(after);
    assert_int_equal(x->primitive_count, y->primitive_count);
    assert_true(y->accessor_count >= x->accessor_count && y->view_count >= x->view_count);
    for (uint32_t i = 0; i < x->primitive_count; ++i) {
        const gltf_primitive *p = &x->primitives[i], *q = &y->primitives[i];
        if (p->not_read) continue;
        assert_int_equal(p->faces, q->faces);
        compare_set(before, after, i, &p->base, &q->base, name);
        for (uint32_t t = 0; t < p->target_count; ++t)
            compare_set(before, after, i, &x->targets[p->first_target + t],
                &y->targets[q->first_target + t], name);
        if (options.only == NORMA_ONLY_ALL) check_unit(after, q->base.normal, name);
    }
}

/* Whether nothing, or something that can be read, has positions. */
static int has_surface(const norma_document *document) {
    const gltf *g = norma_gltf_of(document);
    int any = 0;
    for (uint32_t i = 0; i < g->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[i];
        if (p->mode < GLTF_TRIANGLES || p->base.position == GLTF_NONE) continue;
        if (!p->not_read) return 1;
        any = 1;
    }
    return !any;
}

/* Computed into memory and opened again under the same name, so that buffers beside it are found.
 */
static void compute_one(const char *path, const char *name) {
    document_bytes in = bytes_load(path);
    norma_document_error error;
    norma_document *before = NULL;
    norma_compute_summary summary;
    ++files;
    if (norma_document_open(path, NULL, &before, &error)) {
        ++refused;
        assert_true(error.message[0] != '\0' && error.result < 0);
        bytes_free(&in);
        return;
    }
    if (!has_surface(before)) { /* whatever there is lacks its bytes */
        assert_int_equal(norma_document_compute(before, &options, &summary, &error),
            NORMA_DOCUMENT_ERROR_UNSUPPORTED);
        norma_document_close(before);
        bytes_free(&in);
        return;
    }
    document_bytes out = bytes_computed(in, path, &options, &summary);
    norma_document *after = bytes_open(out, path);
    compare(before, after, name);
    assert_int_equal(summary.changed, !bytes_equal(in, out));
    document_bytes again = bytes_computed(out, path, &options, &summary);
    if (!bytes_equal(again, out)) fail_msg("%s: computing again changes it", name);
    bytes_free(&again);
    norma_document_close(before);
    norma_document_close(after);
    bytes_free(&out);
    bytes_free(&in);
}

static void visit(const char *path, const char *name, const char *expect) {
    size_t before = refused;
    compute_one(path, name);
    if (strcmp(expect, "ok") == 0 || strcmp(expect, "lint") == 0) assert_int_equal(refused, before);
    if (strcmp(expect, "unsupported") == 0) assert_int_equal(refused, before + 1);
    if (strcmp(expect, "khr-clean") == 0 &&
        refused != before) { /* only ever for what is beyond 2.0 */
        norma_mesh_info info;
        document_bytes b = bytes_load(path);
        assert_int_equal(bytes_try(b, path, &info, NULL), NORMA_DOCUMENT_ERROR_UNSUPPORTED);
        bytes_free(&b);
    }
}

static void all_files(const norma_compute_options *with) {
    files = refused = corners_compared = 0;
    options = *with;
    data_for_each_format("gltf", visit);
    data_for_each_format("glb", visit);
    if (files == 0) skip();
    print_message("%zu files, %zu refused, %zu attributes of corners compared\n", files, refused,
        corners_compared);
    assert_true(files > 200 && corners_compared > 1000000);
}

static void creases(void **state) {
    (void)state;
    all_files(&(norma_compute_options){.struct_size = sizeof options});
}

static void smooth_with_morphs(void **state) {
    (void)state;
    all_files(&(norma_compute_options){
        .struct_size = sizeof options, .shading = NORMA_SHADING_SMOOTH, .morphs = 1});
}

static void flat(void **state) {
    (void)state;
    all_files(&(norma_compute_options){
        .struct_size = sizeof options, .shading = NORMA_SHADING_FLAT, .weight = NORMA_WEIGHT_AREA});
}

static void missing_alone(void **state) {
    (void)state;
    all_files(&(norma_compute_options){.struct_size = sizeof options, .only = NORMA_ONLY_MISSING});
}

static void broken_alone(void **state) {
    (void)state;
    all_files(&(norma_compute_options){.struct_size = sizeof options, .only = NORMA_ONLY_BROKEN});
}

/* Compressed and plain: the same asset, written by another program; positions and indices must be
 * the same. */
static void compressed_is_as_plain(void **state) {
    const char *data = getenv("NORMA_DATA") ? getenv("NORMA_DATA") : "../shared/data";
    char a[300], b[300];
    (void)state;
    snprintf(a, sizeof a, "%s/gltf/quantized/avocado-meshopt.glb", data);
    snprintf(b, sizeof b, "%s/gltf/quantized/avocado-quant.glb", data);
    norma_document *x = NULL, *y = NULL;
    if (norma_document_open(a, NULL, &x, NULL) || norma_document_open(b, NULL, &y, NULL)) skip();
    size_t faces = norma_gltf_of(x)->primitives[0].faces;
    assert_int_equal(faces, 682);
    assert_int_equal(norma_gltf_of(y)->primitives[0].faces, faces);
    gltf_array p = array_of(x, norma_gltf_of(x)->primitives[0].base.position, a),
               q = array_of(y, norma_gltf_of(y)->primitives[0].base.position, b);
    assert_int_equal(p.count, q.count);
    double sum_p[3] = {0}, sum_q[3] = {0}; /* the compressor may order vertices anew */
    for (size_t v = 0; v < p.count; ++v) {
        float u[16], w[16];
        norma_gltf_floats(&p, v, u);
        norma_gltf_floats(&q, v, w);
        for (int k = 0; k < 3; ++k) {
            sum_p[k] += (double)u[k];
            sum_q[k] += (double)w[k];
        }
    }
    for (int k = 0; k < 3; ++k) assert_true(sum_p[k] == sum_q[k] && sum_p[k] > 0);
    norma_document_close(x);
    norma_document_close(y);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(creases),
        cmocka_unit_test(smooth_with_morphs),
        cmocka_unit_test(flat),
        cmocka_unit_test(missing_alone),
        cmocka_unit_test(broken_alone),
        cmocka_unit_test(compressed_is_as_plain),
    };
    return cmocka_run_group_tests_name("gltf data", tests, NULL, NULL);
}
