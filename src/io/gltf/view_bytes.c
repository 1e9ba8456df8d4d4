/* view_bytes.c: the bytes of a view, as they are or decoded. */
#include "io/gltf/asset.h"

const char *norma_gltf_extension_of(const gltf *g, const gltf_meshopt *m) {
    return norma_json_equals(&g->json, m->token - 1, "KHR_meshopt_compression")
               ? "KHR_meshopt_compression"
               : "EXT_meshopt_compression";
}

norma_document_result norma_gltf_view_bytes(
    gltf *g, uint32_t number, const unsigned char **bytes, norma_document_error *error) {
    gltf_view *view = &g->views[number];
    if (view->meshopt.token != GLTF_NONE) {
        norma_document_result result =
            view->decoded ? NORMA_DOCUMENT_OK : norma_gltf_decode_meshopt(g, number, error);
        *bytes = view->decoded;
        return result;
    }
    norma_document_result result = norma_gltf_load_buffer(g, view->buffer, error);
    if (result) return result;
    if (norma_gltf_view_overruns(g, number))
        return norma_gltf_malformed(g, error, view->token, "a view that ends inside its buffer");
    *bytes = g->buffers[view->buffer].bytes + view->offset;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_measure_elements(
    gltf *g, const gltf_elements *elements, size_t *stride, norma_document_error *error) {
    const gltf_view *view = &g->views[elements->view];
    const size_t offset = elements->offset, size = elements->size;
    *stride = view->stride ? view->stride : size;
    if (*stride < size) /* such elements share bytes, and none could be changed alone */
        return norma_gltf_malformed(
            g, error, elements->token, "elements no longer than their view's byteStride");
    if (offset > view->length || size > view->length - offset ||
        elements->count - 1 > (view->length - offset - size) / *stride)
        return norma_gltf_malformed(
            g, error, elements->token, "elements that end inside their view");
    return NORMA_DOCUMENT_OK;
}
