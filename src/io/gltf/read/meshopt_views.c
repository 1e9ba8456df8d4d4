/* meshopt_views.c: views under EXT_meshopt_compression, through meshoptimizer's decoder. It asserts
 * what it is handed, so all of that is checked here first. */
#include "io/gltf/read/asset.h"
#include <meshoptimizer.h>
#include <stdlib.h>

/* The vertex codec spends at least one byte on 64, the index codecs one on 12. */
enum { LARGEST_RATIO = 64, SMALL = 1024 };

static const char *wrong_layout(const gltf_view *view) {
    const gltf_meshopt *m = &view->meshopt;
    size_t size;
    if (m->stride == 0 || m->count > SIZE_MAX / m->stride)
        return "a byteStride and count whose product is sane";
    size = m->count * m->stride;
    if (size > view->length) return "a byteLength of at least count times byteStride";
    if (size > SMALL && size / LARGEST_RATIO > m->length)
        return "no more elements than the compressed bytes can hold";
    if (m->mode == GLTF_MODE_ATTRIBUTES ? m->stride % 4 != 0 || m->stride > 256
                                        : m->stride != 2 && m->stride != 4)
        return "a byteStride that its mode allows";
    if (m->mode == GLTF_MODE_TRIANGLES && m->count % 3 != 0)
        return "a count that is a multiple of 3";
    if (m->filter != GLTF_FILTER_NONE && m->mode != GLTF_MODE_ATTRIBUTES)
        return "a filter only with ATTRIBUTES";
    if ((m->filter == GLTF_FILTER_OCTAHEDRAL && m->stride != 4 && m->stride != 8) ||
        (m->filter == GLTF_FILTER_QUATERNION && m->stride != 8))
        return "a byteStride that its filter allows";
    return NULL;
}

static int decode(const gltf_meshopt *m, const unsigned char *bytes, unsigned char *out) {
    int failed;
    switch (m->mode) {
    case GLTF_MODE_ATTRIBUTES:
        failed = meshopt_decodeVertexBuffer(out, m->count, m->stride, bytes, m->length);
        break;
    case GLTF_MODE_TRIANGLES:
        failed = meshopt_decodeIndexBuffer(out, m->count, m->stride, bytes, m->length);
        break;
    default:
        failed = meshopt_decodeIndexSequence(out, m->count, m->stride, bytes, m->length);
        break;
    }
    if (failed) return 0;
    switch (m->filter) {
    case GLTF_FILTER_OCTAHEDRAL:
        meshopt_decodeFilterOct(out, m->count, m->stride);
        break;
    case GLTF_FILTER_QUATERNION:
        meshopt_decodeFilterQuat(out, m->count, m->stride);
        break;
    case GLTF_FILTER_EXPONENTIAL:
        meshopt_decodeFilterExp(out, m->count, m->stride);
        break;
    case GLTF_FILTER_NONE:
        break;
    }
    return 1;
}

int norma_gltf_reads_meshopt(void) { return 1; }

norma_document_result norma_gltf_decode_meshopt(
    gltf *g, uint32_t number, norma_document_error *error) {
    gltf_view *view = &g->views[number];
    const gltf_meshopt *m = &view->meshopt;
    const char *wrong = wrong_layout(view);
    if (wrong) return norma_gltf_malformed(g, error, m->token, wrong);
    norma_document_result result = norma_gltf_load_buffer(g, m->buffer, error);
    if (result) return result;
    size_t length = g->buffers[m->buffer].length;
    if (m->offset > length || m->length > length - m->offset)
        return norma_gltf_malformed(
            g, error, m->token, "compressed bytes that end inside their buffer");
    size_t size = m->count * m->stride;
    if (view->length > size && view->length - size > SMALL)
        return norma_gltf_malformed(g, error, m->token, "a byteLength of count times byteStride");
    unsigned char *out = norma_io_allocate(view->length, 1);
    if (!out) return norma_document_fail_memory(g->document, error);
    if (!decode(m, g->buffers[m->buffer].bytes + m->offset, out)) {
        free(out);
        return norma_gltf_malformed(
            g, error, m->token, "bytes that meshoptimizer's decoder accepts");
    }
    view->decoded = out;
    return NORMA_DOCUMENT_OK;
}
