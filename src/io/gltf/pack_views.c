/* pack_views.c: views that EXT_meshopt_compression held, and new ones beside them, compressed
 * again, so that each byte comes back as it was put. */
#include "io/gltf/patch.h"
#include <stdlib.h>
#include <string.h>

/* How a view is to be compressed: as it was, unless it holds other things now. */
static void choose_codec(const gltf *g, uint32_t number, patch_view *view) {
    const int old = number < g->view_count;
    gltf_meshopt *m = &view->meshopt;
    *m = g->views[old ? number : view->like].meshopt;
    const int indices = view->target ? view->target == 34963 : m->mode != GLTF_MODE_ATTRIBUTES;
    if (!old || m->stride != view->element) m->filter = GLTF_FILTER_NONE;
    m->stride = view->element;
    m->count = view->plain.length / m->stride;
    if (!indices)
        m->mode = GLTF_MODE_ATTRIBUTES;
    else if (m->mode == GLTF_MODE_ATTRIBUTES || m->count % 3)
        m->mode = m->count % 3 ? GLTF_MODE_INDICES : GLTF_MODE_TRIANGLES;
}

static int suits_codec(const patch_view *view) {
    const gltf_meshopt *m = &view->meshopt;
    return m->count * m->stride == view->plain.length &&
           (m->mode == GLTF_MODE_ATTRIBUTES ? m->stride % 4 == 0 && m->stride <= 256
                                            : m->stride == 2 || m->stride == 4);
}

/* Any bytes are rows of four, once they are padded. */
static int make_rows_of_four(patch_view *view) {
    const size_t length = (view->plain.length + 3) / 4 * 4;
    unsigned char *padded = norma_io_allocate(length, 1);
    if (!padded) return 0;
    memcpy(padded, view->plain.bytes, view->plain.length);
    free(view->owned);
    view->plain.bytes = view->owned = padded;
    view->plain.length = length;
    view->meshopt.mode = GLTF_MODE_ATTRIBUTES;
    view->meshopt.filter = GLTF_FILTER_NONE;
    view->meshopt.stride = 4;
    view->meshopt.count = length / 4;
    return 1;
}

norma_document_result norma_gltf_pack_views(gltf *g, norma_document_error *error) {
    for (uint32_t v = 0; v < g->patch->view_count; ++v) {
        patch_view *view = &g->patch->views[v];
        if (view->packed.buffer == GLTF_NONE || !view->plain.bytes) continue;
        choose_codec(g, v, view);
        if (suits_codec(view) || make_rows_of_four(view))
            view->owned_packed = norma_gltf_encode_meshopt(&view->meshopt, view->plain.bytes);
        if (!view->owned_packed) return norma_document_fail_memory(g->document, error);
        view->packed.bytes = view->owned_packed;
        view->packed.length = view->meshopt.length;
    }
    return NORMA_DOCUMENT_OK;
}
