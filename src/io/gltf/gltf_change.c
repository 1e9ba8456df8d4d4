/* gltf_change.c: the beginning and the end of a change to an asset. What was put (patch.c) becomes
 * accessors (patch.c), views (assign_views.c) and edits of the JSON. */
#include "io/gltf/gltf_layout.h"

void norma_gltf_begin_change(gltf *g) { norma_gltf_patch_free(g); /* one that changed nothing */ }

int norma_gltf_drop_change(norma_document *document) {
    gltf *g = norma_gltf_of(document);
    norma_gltf_patch_free(g);
    norma_json_edits_destroy(g->edits);
    g->edits = norma_json_edits_create(&g->json, 0);
    g->changed = 0;
    return g->edits != NULL;
}

static void append_copies(gltf *g) {
    const gltf_patch *patch = g->patch;
    for (size_t i = 0; i < patch->copy_count; ++i) {
        json_text text = {0};
        text.failed = !norma_json_write(
            patch->copies[i].edits, g->meshes[patch->copies[i].mesh].token, &text);
        norma_json_append_made(g->edits, 0, "meshes", &text);
    }
}

norma_document_result norma_gltf_finish(gltf *g, norma_document_error *error) {
    gltf_patch *patch = norma_gltf_patch_of(g);
    norma_document_result result = patch ? norma_gltf_assign_accessors(g, error)
                                         : norma_document_fail_memory(g->document, error);
    if (!result) result = norma_gltf_assign_views(g, error);
    if (!result && patch->accessor_count)
        result = norma_gltf_check_dangling(g, GLTF_LIST_ACCESSORS, error);
    if (!result && patch->view_count > g->view_count)
        result = norma_gltf_check_dangling(g, GLTF_LIST_VIEWS, error);
    if (!result && patch->copy_count)
        result = norma_gltf_check_dangling(g, GLTF_LIST_MESHES, error);
    if (!result) append_copies(g);
    if (result) return result;
    norma_gltf_edit_extensions(g);
    if (norma_json_edits_failed(g->edits)) return norma_document_fail_memory(g->document, error);
    g->changed = norma_json_edits_any(g->edits);
    for (size_t i = 0; i < patch->view_count; ++i)
        g->changed |= patch->views[i].plain.bytes != NULL;
    return NORMA_DOCUMENT_OK;
}
