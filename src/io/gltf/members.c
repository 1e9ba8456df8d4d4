/* members.c: members of JSON objects, and what messages say of them; how much a file may ask for;
 * whether it needs a later version of glTF. */
#include "io/gltf/gltf.h"
#include "io/gltf/draco_decoder.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- How the elements of a glTF are named, and which rules their extras silence. */

char *norma_gltf_read_name(const gltf *g, uint32_t token) {
    uint32_t name = norma_json_member(&g->json, token, "name");
    return norma_json_is(&g->json, name, JSON_STRING) ? norma_json_string(&g->json, name)
                                                      : norma_io_allocate(1, 1);
}

const char *norma_gltf_name(gltf *g, uint32_t token) {
    char *decoded = norma_gltf_read_name(g, token);
    char *kept = decoded ? norma_scene_text(g->document->scene, decoded) : NULL;
    free(decoded);
    return kept;
}

const char *norma_gltf_where(gltf *g, const char *list, size_t number) {
    char text[64];
    snprintf(text, sizeof text, "/%s/%zu", list, number);
    return norma_scene_text(g->document->scene, text);
}

static void list_tokens(const json *j, const char *name, uint32_t *tokens, uint32_t count) {
    const uint32_t list = norma_json_member(j, 0, name);
    for (uint32_t item = JSON_NONE, i = 0; i < count && norma_json_each(j, list, &item);)
        tokens[i++] = item;
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
    made->skins = norma_scene_allocate(scene, g->skin_count, sizeof *made->skins);
    made->moved = norma_scene_allocate(scene, g->drawing_count, sizeof *made->moved);
    made->materials = norma_scene_allocate(scene, g->material_count, sizeof *made->materials);
    if (!made->decoded || !made->colors || !made->materials || !made->mesh_ignore ||
        !made->node_ignore || !made->skins || !made->moved)
        return NULL;
    list_tokens(&g->json, "skins", made->skins, g->skin_count);
    list_tokens(&g->json, "materials", made->materials, g->material_count);
    return scene->gltf = made;
}

uint32_t norma_gltf_material(gltf *g, size_t material) {
    const gltf_scene *scene = norma_gltf_scene_of(g);
    return scene && material < g->material_count ? scene->materials[material] : JSON_NONE;
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
        for (uint32_t item = JSON_NONE; norma_json_each(j, ignore, &item);)
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

/* ---- Members of the JSON, checked, and errors that name their place in it. */

enum { QUOTE = 80 };

gltf_place norma_gltf_pointer(const gltf *g, uint32_t token) {
    gltf_place place = {""};
    const size_t capacity = sizeof place.text;
    uint32_t chain[JSON_DEPTH + 1];
    size_t depth = 0, used = 0;
    for (uint32_t t = token;
         t != JSON_NONE && g->json.tokens[t].parent != JSON_NONE && depth < JSON_DEPTH;
         t = g->json.tokens[t].parent)
        chain[depth++] = t;
    while (depth-- > 0 && used + 1 < capacity) {
        uint32_t t = chain[depth], parent = g->json.tokens[t].parent, number = 0;
        int written;
        if (g->json.tokens[parent].type == JSON_OBJECT) {
            const json_token *key = &g->json.tokens[t - 1];
            written = snprintf(place.text + used, capacity - used, "/%.*s",
                (int)(key->end - key->start > 66 ? 64 : key->end - key->start - 2),
                g->text + key->start + 1);
        } else {
            for (uint32_t i = norma_json_first(&g->json, parent); i != t;
                 i = norma_json_next(&g->json, parent, i))
                ++number;
            written = snprintf(place.text + used, capacity - used, "/%u", (unsigned)number);
        }
        used += written > 0 ? (size_t)written : 0;
    }
    return place;
}

/* The beginning of a value as the file has it, without white space between its parts. */
static void quote(const gltf *g, uint32_t token, char out[QUOTE + 4]) {
    const json_token *t = &g->json.tokens[token];
    size_t used = 0, at = t->start;
    for (int inside = 0; at < t->end && used < QUOTE; ++at) {
        const char c = g->text[at];
        if (c == '"' && (at == t->start || g->text[at - 1] != '\\')) inside = !inside;
        if (inside || !strchr(" \t\r\n", c)) out[used++] = c;
    }
    while (at < t->end && (g->text[at] & 0xC0) == 0x80 && used > 0 && (out[--used] & 0xC0) == 0x80)
        continue;
    strcpy(out + used, at < t->end ? "..." : "");
}

norma_document_result norma_gltf_malformed(
    const gltf *g, norma_document_error *error, uint32_t token, const char *expected) {
    const gltf_place place = norma_gltf_pointer(g, token);
    char found[QUOTE + 4] = "nothing";
    if (token != JSON_NONE) quote(g, token, found);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED,
        place.text[0] ? place.text : "/", "expected %s; found %s", expected, found);
}

void norma_gltf_copy_member(const gltf *g, json_text *text, uint32_t object, const char *key) {
    const uint32_t value = norma_json_member(&g->json, object, key);
    if (value == JSON_NONE) return;
    const json_token *token = &g->json.tokens[value];
    norma_json_add_key(text, key);
    norma_json_add(text, g->text + token->start, token->end - token->start);
}

int norma_gltf_size_member(const gltf *g, uint32_t object, const char *key, size_t *value) {
    uint32_t token = norma_json_member(&g->json, object, key);
    uint64_t read;
    if (token == JSON_NONE) return 1;
    if (!norma_json_uint(&g->json, token, &read) || read > SIZE_MAX / 4) return 0;
    *value = (size_t)read;
    return 1;
}

int norma_gltf_index_member(
    const gltf *g, uint32_t object, const char *key, uint32_t limit, uint32_t *value) {
    uint32_t token = norma_json_member(&g->json, object, key);
    uint64_t read;
    if (token == JSON_NONE) return 1;
    if (!norma_json_uint(&g->json, token, &read) || read >= limit) return 0;
    *value = (uint32_t)read;
    return 1;
}

int norma_gltf_extends_beyond(const gltf *g, uint32_t object, const char *const *known) {
    const uint32_t extensions = norma_json_member(&g->json, object, "extensions");
    for (uint32_t value = JSON_NONE; norma_json_each(&g->json, extensions, &value);) {
        size_t i = 0;
        while (known[i] && !norma_json_equals(&g->json, value - 1, known[i])) ++i;
        if (!known[i]) return 1;
    }
    return 0;
}

int norma_gltf_lists(const gltf *g, const char *list, const char *name) {
    const uint32_t names = norma_json_member(&g->json, 0, list);
    for (uint32_t item = JSON_NONE; norma_json_each(&g->json, names, &item);)
        if (norma_json_equals(&g->json, item, name)) return 1;
    return 0;
}

void norma_gltf_remove_extension(
    const gltf *g, json_edits *edits, uint32_t object, const char *name) {
    const uint32_t extensions = norma_json_member(&g->json, object, "extensions");
    if (norma_json_size(&g->json, extensions) == 1)
        norma_json_unset(edits, object, "extensions");
    else
        norma_json_unset(edits, extensions, name);
}

norma_document_result norma_gltf_read_list(
    const gltf *g, const char *name, uint32_t *list, uint32_t *count, norma_document_error *error) {
    const json *j = &g->json;
    *list = norma_json_member(j, 0, name);
    *count = norma_json_size(j, *list);
    if (*list != JSON_NONE && !norma_json_is(j, *list, JSON_ARRAY))
        return norma_gltf_malformed(g, error, *list, "an array");
    for (uint32_t item = JSON_NONE; norma_json_each(j, *list, &item);)
        if (!norma_json_is(j, item, JSON_OBJECT))
            return norma_gltf_malformed(g, error, item, "an object");
    return NORMA_DOCUMENT_OK;
}

/* ---- How much a file may stand for. Elements that share bytes (many primitives of one
 * accessor, accessors that overlap, accessors without bytes) let a few kilobytes name more
 * triangles than a machine holds; so what is decoded, copied and drawn is measured by the bytes
 * that the file and its buffers hold. */

enum {
    DECODED_A_BYTE = 256,
    CORNERS_A_BYTE = 16,
    VERTICES_A_BYTE = 64,
    MOVES_A_BYTE = 16,
    INSTANCES_A_BYTE = 4,
    COPIED_A_BYTE = 512,
    FREE = 1 << 18,
    FREE_INSTANCES = 1 << 16
};

/* Whether sum stays within the bound when more is added to it; never wraps. */
static int add_within(size_t *sum, size_t more, size_t held, size_t a_byte, size_t granted) {
    const size_t bound = held > (SIZE_MAX - granted) / a_byte ? SIZE_MAX : held * a_byte + granted;
    if (more > bound || *sum > bound - more) return 0;
    *sum += more;
    return 1;
}

norma_document_result norma_gltf_spend(
    gltf *g, uint32_t token, size_t count, size_t size, norma_document_error *error) {
    if (count <= SIZE_MAX / size &&
        add_within(&g->decoded, count * size, g->held, DECODED_A_BYTE, FREE))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        norma_gltf_pointer(g, token).text,
        "%zu elements from here, with all before them, would take far more memory than the file; "
        "at most %d bytes are read for each byte of it",
        count, DECODED_A_BYTE);
}

norma_document_result norma_gltf_draw(
    gltf *g, const gltf_primitive *p, norma_document_error *error) {
    const size_t corners = p->faces > SIZE_MAX / 3 ? SIZE_MAX : 3 * p->faces,
                 targets = p->target_count,
                 moves =
                     targets && p->vertices > SIZE_MAX / targets ? SIZE_MAX : p->vertices * targets;
    if (!add_within(&g->corners_drawn, corners, g->held, CORNERS_A_BYTE, FREE) ||
        !add_within(&g->vertices_drawn, p->vertices, g->held, VERTICES_A_BYTE, FREE))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "%zu triangles of %zu vertices, with those of all primitives before, are far more than "
            "the file has bytes; at most %d corners and %d vertices are read for each byte",
            p->faces, p->vertices, CORNERS_A_BYTE, VERTICES_A_BYTE);
    if (!add_within(&g->vertices_moved, moves, g->held, MOVES_A_BYTE, FREE))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "%zu vertices in each of %zu morph targets, with those of all primitives before, are "
            "far more than the file has bytes; at most %d are read for each byte",
            p->vertices, targets, MOVES_A_BYTE);
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_copy_vertices(
    gltf *g, gltf_primitive *p, size_t count, size_t size, norma_document_error *error) {
    g->copied -= p->copied;
    p->copied = 0;
    if ((size && count > SIZE_MAX / size) ||
        !add_within(&g->copied, count * size, g->held, COPIED_A_BYTE, FREE))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "%zu vertices of %zu bytes each, with those of all primitives before, would take far "
            "more memory than the file; at most %d bytes are read for each byte of it",
            count, size, COPIED_A_BYTE);
    p->copied = count * size;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_place_instances(
    gltf *g, const gltf_node *node, norma_document_error *error) {
    size_t held = g->document->source.size;
    for (uint32_t i = 0; i < g->buffer_count; ++i) /* as long as they say: none of them is read yet,
                                                      and one that is shorter will not be */
        held = g->buffers[i].length < SIZE_MAX - held ? held + g->buffers[i].length : SIZE_MAX;
    if (add_within(&g->instances_placed, node->instances, held, INSTANCES_A_BYTE, FREE_INSTANCES))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
        norma_gltf_pointer(g, node->token).text,
        "%zu instances, with those of all nodes before, are far more than the file has bytes; at "
        "most %d are read for each byte",
        node->instances, INSTANCES_A_BYTE);
}

/* ---- What a file may ask of its reader: extensions, a later version. */

int norma_gltf_needs_later(const gltf *g) {
    uint32_t least =
        norma_json_member(&g->json, norma_json_member(&g->json, 0, "asset"), "minVersion");
    return least != JSON_NONE && !norma_json_equals(&g->json, least, "2.0");
}

/* What a file may require without a word in it changing what its meshes' numbers mean. */
int norma_gltf_is_known(const char *name) {
    static const char *const prefixes[] = {"KHR_materials_", "KHR_texture_", "KHR_lights_",
        "EXT_lights_", "EXT_texture_", "MSFT_texture_", "KHR_animation_", "KHR_audio_"};
    static const char *const names[] = {"KHR_mesh_quantization", "EXT_meshopt_compression",
        "KHR_meshopt_compression", "EXT_mesh_gpu_instancing", "KHR_xmp_json_ld", "KHR_xmp",
        "KHR_node_visibility", "KHR_node_selectability", "KHR_node_hoverability", "MSFT_lod", "VRM",
        "VRMC_vrm", "CESIUM_RTC", "EXT_mesh_features", "EXT_instance_features",
        "EXT_structural_metadata", "KHR_accessor_float16", "KHR_accessor_float64"};
    for (size_t i = 0; i < sizeof prefixes / sizeof prefixes[0]; ++i)
        if (strncmp(name, prefixes[i], strlen(prefixes[i])) == 0) return 1;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strcmp(name, names[i]) == 0) return 1;
    return norma_draco_reads() && strcmp(name, "KHR_draco_mesh_compression") == 0;
}
