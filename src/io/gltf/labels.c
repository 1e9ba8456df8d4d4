/* labels.c: how the elements of a glTF are named, and which rules their extras silence. */
#include "io/gltf/gltf_scene.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *norma_gltf_name(gltf *g, uint32_t token) {
    uint32_t name = norma_json_member(&g->json, token, "name");
    if (!norma_json_is(&g->json, name, JSON_STRING)) return "";
    char *decoded = norma_json_string(&g->json, name);
    char *kept = decoded ? norma_scene_text(g->document->scene, decoded) : NULL;
    free(decoded);
    return kept;
}

const char *norma_gltf_where(gltf *g, const char *list, size_t number) {
    char text[64];
    snprintf(text, sizeof text, "/%s/%zu", list, number);
    return norma_scene_text(g->document->scene, text);
}

gltf_scene *norma_gltf_scene_of(gltf *g) {
    norma_scene *scene = g->document->scene;
    if (scene->gltf) return scene->gltf;
    gltf_scene *made = norma_scene_allocate(scene, 1, sizeof *made);
    if (!made) return NULL;
    made->decoded = norma_scene_allocate(scene, g->accessor_count, sizeof *made->decoded);
    made->colors = norma_scene_allocate(scene, g->accessor_count, sizeof *made->colors);
    made->mesh_ignore = norma_scene_allocate(scene, g->mesh_count, sizeof *made->mesh_ignore);
    made->node_ignore = norma_scene_allocate(scene, g->node_count, sizeof *made->node_ignore);
    if (made->decoded && made->colors && made->mesh_ignore && made->node_ignore) scene->gltf = made;
    return scene->gltf;
}

enum {
    MOST_IGNORED = 600
}; /* bytes of a list: some hundred ids; a file that wants more means all */

/* 0: the list is full, or memory is out. */
static int add_ignored_rule(const gltf *g, uint32_t token, json_text *list) {
    char *rule = norma_json_string(&g->json, token);
    size_t length = rule ? strlen(rule) : 0;
    int fits = rule && length < MOST_IGNORED && list->size + length + 1 < MOST_IGNORED;
    if (fits && list->size) norma_json_add(list, ",", 1);
    if (fits) norma_json_add(list, rule, length);
    list->failed |= !rule;
    free(rule);
    return fits;
}

const char *norma_gltf_ignore(gltf *g, uint32_t token) {
    const json *j = &g->json;
    uint32_t ignore = norma_json_member(
        j, norma_json_member(j, norma_json_member(j, token, "extras"), "norma"), "ignore");
    json_text list = {0};
    if (norma_json_is(j, ignore, JSON_STRING))
        add_ignored_rule(g, ignore, &list);
    else if (norma_json_is(j, ignore, JSON_ARRAY))
        for (uint32_t item = norma_json_first(j, ignore); item != JSON_NONE;
             item = norma_json_next(j, ignore, item))
            if (norma_json_is(j, item, JSON_STRING) && !add_ignored_rule(g, item, &list)) break;
    if (!list.size && !list.failed) return "";
    norma_json_add(&list, "", 1);
    const char *kept = list.failed ? NULL : norma_scene_text(g->document->scene, list.data);
    free(list.data);
    return kept;
}

const char *norma_gltf_ignored_with(gltf *g, const char *above, uint32_t token) {
    const char *own = above ? norma_gltf_ignore(g, token) : NULL;
    if (!own || !own[0]) return own ? above : NULL;
    return !above[0] || strlen(above) + strlen(own) >= MOST_IGNORED
               ? own
               : norma_scene_join(g->document->scene, above, own);
}

/* Of the whole file: the root's extras, and the asset's. */
const char *norma_gltf_root_ignore(gltf *g) {
    gltf_scene *scene = norma_gltf_scene_of(g);
    if (scene && !scene->root_ignore)
        scene->root_ignore = norma_gltf_ignored_with(
            g, norma_gltf_ignore(g, 0), norma_json_member(&g->json, 0, "asset"));
    return scene ? scene->root_ignore : NULL;
}
