/* unread_parts.c: which parts of a glTF were not read, and why. */
#include "io/gltf/gltf.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *unknown_extension(gltf *g, uint32_t token) {
    char *name = norma_json_string(&g->json, token), *why = NULL;
    size_t size = name ? strlen(name) + 64 : 0;
    if (name && (norma_gltf_is_known(name) || strcmp(name, "KHR_draco_mesh_compression") ==
                                                  0)) /* its primitives are named instead */
        why = norma_scene_text(g->document->scene, "");
    else if (name && (why = norma_scene_allocate(g->document->scene, size, 1)) != NULL)
        snprintf(why, size, "requires %s, which is unknown to this version", name);
    free(name);
    return why;
}

/* Points and lines are no surface, so nothing is left out but normals that they have. */
static const char *why_in_part(const gltf *g, const gltf_primitive *p) {
    if (p->not_read && p->mode >= GLTF_TRIANGLES) return p->not_read;
    if (p->not_read && p->base.normal == GLTF_NONE) return NULL;
    if (p->not_read) return p->mode == GLTF_POINTS ? "normals of points" : "normals of lines";
    if (p->base.normal != GLTF_NONE && norma_gltf_is_placeholder(g, p->base.normal))
        return "its normals have no data in the file; an application has to provide them";
    if (p->base.tangent != GLTF_NONE && norma_gltf_is_placeholder(g, p->base.tangent))
        return "its tangents have no data in the file; an application has to provide them";
    return NULL;
}

/* Bytes behind the end that a GLB's header declares. 0: out of memory. */
static int add_tail(gltf *g, norma_unread *unread, size_t *count) {
    const size_t size = norma_gltf_surplus(g);
    if (size == 0) return 1;
    char *texts = norma_scene_allocate(g->document->scene, 2, sizeof(char[120]));
    if (!texts) return 0;
    snprintf(texts, 120, "byte %zu", g->tile.begins + g->tile.at + g->container_size);
    snprintf(texts + 120, 120, "%zu bytes follow the end that the header declares", size);
    unread[(*count)++] = (norma_unread){texts, texts + 120};
    return 1;
}

/* Tiles of a composite beside the one that is read. 0: out of memory. */
static int add_tiles_left_out(gltf *g, norma_unread *unread, size_t *count) {
    const gltf_tile *tile = &g->tile;
    if (tile->left_out == 0) return 1;
    char *texts = norma_scene_allocate(g->document->scene, 2, sizeof(char[120]));
    if (!texts) return 0;
    snprintf(texts, 120, "byte %zu", tile->left_out_at);
    const int length = snprintf(texts + 120, 120, "this tile %s", tile->left_out_why);
    if (tile->left_out > 1)
        snprintf(texts + 120 + length, 120 - (size_t)length, "; tiles without a model besides: %zu",
            tile->left_out - 1);
    unread[(*count)++] = (norma_unread){texts, texts + 120};
    return 1;
}

norma_document_result norma_gltf_read_unread(
    norma_document *document, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    uint32_t list = norma_json_member(&g->json, 0, "extensionsRequired"), number = 0;
    norma_unread *unread = norma_scene_allocate(
        scene, (size_t)norma_json_size(&g->json, list) + g->primitive_count + 4, sizeof *unread);
    size_t count = 0;
    if (!unread || !add_tail(g, unread, &count) || !add_tiles_left_out(g, unread, &count))
        return norma_document_fail_memory(document, error);
    if (g->tile.not_read) unread[count++] = (norma_unread){"instances", g->tile.not_read};
    if (norma_gltf_needs_later(g))
        unread[count++] =
            (norma_unread){"/asset/minVersion", "needs a later version of glTF than 2.0"};
    for (uint32_t item = JSON_NONE; norma_json_each(&g->json, list, &item); ++number) {
        const norma_unread made = {
            norma_gltf_where(g, "extensionsRequired", number), unknown_extension(g, item)};
        if (!made.where || !made.why) return norma_document_fail_memory(document, error);
        if (made.why[0]) unread[count++] = made;
    }
    for (uint32_t i = 0; i < g->primitive_count; ++i) {
        const char *why = why_in_part(g, &g->primitives[i]);
        if (why) unread[count++] = (norma_unread){g->primitives[i].where, why};
    }
    scene->unread = unread;
    scene->unread_count = count;
    return NORMA_DOCUMENT_OK;
}
