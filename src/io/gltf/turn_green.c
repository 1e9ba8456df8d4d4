/* turn_green.c: normal maps whose green channel is inverted. A texture, an image or a view that
 * nothing else uses changes itself; else the materials get one of their own, and all others keep
 * theirs. An image in a view or a data: URI stays in one; one in a file becomes a new file, so that
 * the old one, which other assets may show, stays as it is. */
#include "io/gltf/gltf_layout.h"
#include "io/image/image.h"
#include <stdlib.h>
#include <string.h>

typedef struct green_texture {
    uint32_t turned; /* by how many materials it is to be shown so */
    uint32_t image, made;
} green_texture;

typedef struct green_image {
    norma_texture_info map;
    growing_bytes bytes; /* the new ones */
    uint32_t kept;       /* textures that show it and stay its own */
    uint32_t made;       /* its number from now on; GLTF_NONE: it is not turned */
    int wanted;
} green_image;

typedef struct turner {
    gltf *g;
    norma_document_error *error;
    uint8_t *materials; /* marks */
    green_texture *textures;
    green_image *images;
    uint32_t *texture_uses, *image_uses, *pins;
    uint32_t texture_count, image_count, more_textures, more_images, more_views;
    given_image *given; /* as many as images at most */
    size_t given_count;
} turner;

static norma_document_result fail_green(const turner *t) {
    return norma_document_fail_memory(t->g->document, t->error);
}

/* ---- How often the JSON names each texture and each image. Extensions name them in ways
 * of their own, so each number counts whose key, or the key of whose list or object, speaks of
 * textures or images: it is better to copy one in vain than to change what something else shows. */

static int letter(char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; }

/* word: in small letters. */
static int contains(const json *j, uint32_t key, const char *word) {
    const json_token *token = &j->tokens[key];
    for (size_t at = token->start; at < token->end; ++at) {
        size_t k = 0;
        while (word[k] && at + k < token->end && letter(j->text[at + k]) == word[k]) ++k;
        if (!word[k]) return 1;
    }
    return 0;
}

/* Of a value the key under which it, or the lists around it, stand; JSON_NONE: none. */
static uint32_t use_key_of(const json *j, uint32_t token) {
    uint32_t parent = j->tokens[token].parent;
    while (parent != JSON_NONE && j->tokens[parent].type == JSON_ARRAY) {
        token = parent;
        parent = j->tokens[token].parent;
    }
    return parent == JSON_NONE ? JSON_NONE : token - 1;
}

/* What an object that names a texture says besides. */
static int is_other_member(const json *j, uint32_t key) {
    static const char *const others[] = {
        "texCoord", "scale", "strength", "rotation", "offset", "source", "sampler"};
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i)
        if (norma_json_equals(j, key, others[i])) return 1;
    return 0;
}

static int speaks_of(const json *j, uint32_t token, const char *word) {
    const uint32_t key = use_key_of(j, token);
    if (key == JSON_NONE || contains(j, key, word)) return key != JSON_NONE;
    const uint32_t object = j->tokens[key].parent, above = j->tokens[object].parent;
    return above != JSON_NONE && j->tokens[above].type == JSON_OBJECT &&
           contains(j, object - 1, word) && !is_other_member(j, key);
}

static void count_index_uses(
    const gltf *g, const char *word, const char *member, uint32_t *counts, size_t count) {
    const json *j = &g->json;
    uint64_t number;
    for (uint32_t token = 1; token < j->count; ++token) {
        const int is_member = j->tokens[j->tokens[token].parent].type == JSON_OBJECT;
        if (is_member && norma_json_equals(j, token - 1, "extras")) {
            token = j->tokens[token].next - 1;
            continue;
        }
        if (j->tokens[token].type == JSON_NUMBER && norma_json_uint(j, token, &number) &&
            number < count &&
            (speaks_of(j, token, word) ||
                (is_member && member && norma_json_equals(j, token - 1, member))))
            ++counts[number];
    }
}

/* ---- what is to be turned */

static uint32_t references_of(const turner *t, const char *name) {
    return norma_json_member(&t->g->json, 0, name);
}

/* The token of the number of a material's texture, or JSON_NONE. */
static uint32_t reference_index(const turner *t, uint32_t material, uint32_t *texture) {
    const uint32_t token = norma_json_member(
        &t->g->json, norma_gltf_normal_use(t->g, norma_gltf_material(t->g, material)), "index");
    *texture = norma_gltf_number(t->g, token, t->texture_count);
    return *texture == GLTF_NONE ? JSON_NONE : token;
}

static norma_document_result find_textures(turner *t) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t m = 0; m < t->g->material_count && !result; ++m) {
        uint32_t texture;
        norma_texture_info map;
        if (!t->materials[m] || reference_index(t, m, &texture) == JSON_NONE) continue;
        result = norma_gltf_normal_texture(t->g->document, m, &map, t->error);
        if (result || !map.bytes || map.image >= t->image_count) continue;
        t->images[map.image].map = map;
        t->images[map.image].wanted = 1;
        t->textures[texture].image = (uint32_t)map.image;
        ++t->textures[texture].turned;
    }
    return result;
}

static int is_own_image(const turner *t, uint32_t texture) {
    return t->textures[texture].turned == t->texture_uses[texture];
}

/* An image of another format beside this one would stay as it is. */
static int has_other_image(const turner *t, uint32_t texture) {
    const json *j = &t->g->json;
    const uint32_t extensions = norma_json_member(
        j, norma_json_element(j, references_of(t, "textures"), texture), "extensions");
    for (uint32_t e = JSON_NONE; norma_json_each(j, extensions, &e);)
        if (norma_json_member(j, e, "source") != JSON_NONE) return 1;
    return 0;
}

static void leave(turner *t, uint32_t image, const char *why) {
    t->images[image].made = GLTF_NONE;
    norma_document_add_note(t->g->document, "N812 map-green-flipped is not fixed at /images/%u: %s",
        (unsigned)image, why);
}

/* ---- new images */

static int is_in_view(const turner *t, uint32_t token, uint64_t *view) {
    const uint32_t number = norma_json_member(&t->g->json, token, "bufferView");
    return number != JSON_NONE && norma_json_uint(&t->g->json, number, view);
}

/* Whether nothing else lies in the view. */
static int is_own_view(const turner *t, uint64_t view) {
    const gltf *g = t->g;
    int own = t->pins[view] == 1 && g->views[view].meshopt.token == GLTF_NONE;
    for (uint32_t a = 0; own && a < g->accessor_count; ++a) own = g->accessors[a].view != view;
    return own;
}

static norma_document_result turn_image(turner *t, uint32_t number) {
    green_image *image = &t->images[number];
    const image_result how =
        norma_image_turn_green(image->map.bytes, image->map.size, &image->bytes);
    if (how == IMAGE_MEMORY) return fail_green(t);
    if (how) {
        leave(t, number, norma_image_text(how));
        return NORMA_DOCUMENT_OK;
    }
    const int own = image->kept == t->image_uses[number];
    uint64_t view;
    const uint32_t token = norma_json_element(&t->g->json, references_of(t, "images"), number);
    image->made = own ? number : t->image_count + t->more_images++;
    t->more_views += is_in_view(t, token, &view) && !(own && is_own_view(t, view));
    if (!norma_image_is_png(image->map.bytes, image->map.size))
        norma_document_add_note(t->g->document,
            "image %u, a JPEG, becomes a PNG with its green channel inverted, so that nothing more "
            "is lost",
            (unsigned)number);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result turn_images(turner *t) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; i < t->texture_count; ++i)
        if (t->textures[i].turned)
            t->images[t->textures[i].image].kept += (uint32_t)is_own_image(t, i);
    for (uint32_t i = 0; i < t->texture_count; ++i) {
        const uint32_t image = t->textures[i].image;
        if (!t->textures[i].turned || !has_other_image(t, i) || !t->images[image].wanted) continue;
        t->images[image].wanted = 0;
        leave(t, image, "its texture has the same picture in another format as well");
    }
    for (uint32_t i = 0; i < t->image_count && !result; ++i)
        if (t->images[i].wanted) result = turn_image(t, i);
    for (uint32_t i = 0; i < t->texture_count; ++i)
        t->more_textures += t->textures[i].turned && !is_own_image(t, i) &&
                            t->images[t->textures[i].image].made != GLTF_NONE;
    return result;
}

/* ---- what the JSON says of them */

static int put_in_view(
    turner *t, json_edits *edits, uint32_t token, uint64_t view, green_image *image) {
    gltf_patch *patch = norma_gltf_patch_of(t->g);
    patch_image *added = patch ? norma_io_add(&patch->images, &patch->image_capacity,
                                     &patch->image_count, sizeof *added)
                               : NULL;
    if (!added) return 0;
    const int own = image->made < t->image_count && is_own_view(t, view);
    *added = (patch_image){
        own ? (uint32_t)view : GLTF_NONE, (unsigned char *)image->bytes.data, image->bytes.size};
    image->bytes = (growing_bytes){0};
    if (!own) norma_json_set_uint(edits, token, "bufferView", t->g->view_count + t->more_views++);
    return 1;
}

static void put_in_uri(json_edits *edits, uint32_t token, const green_image *image) {
    json_text uri = {0};
    const patch_segment whole = {
        .length = image->bytes.size, .bytes = (const unsigned char *)image->bytes.data};
    norma_json_add_text(&uri, "\"data:image/png;base64,");
    norma_gltf_add_base64(&uri, &whole, 1, NULL);
    norma_json_add_text(&uri, "\"");
    norma_json_set_made(edits, token, "uri", &uri);
}

/* Its name is chosen when it is written. */
static void put_in_file(turner *t, json_edits *edits, uint32_t token, green_image *image) {
    t->given[t->given_count++] = (given_image){.number = image->made,
        .bytes = (unsigned char *)image->bytes.data,
        .size = image->bytes.size};
    image->bytes = (growing_bytes){0};
    norma_json_set(edits, token, "uri", "\"normal.png\"");
}

static int describe_copy(turner *t, json_edits *edits, uint32_t token, green_image *image) {
    const json *j = &t->g->json;
    const uint32_t type = norma_json_member(j, token, "mimeType");
    uint64_t view;
    int ok = 1;
    if (is_in_view(t, token, &view)) {
        ok = put_in_view(t, edits, token, view, image);
    } else {
        char *uri = norma_json_string(j, norma_json_member(j, token, "uri"));
        ok = uri != NULL;
        if (ok && norma_gltf_uri_is_data(uri))
            put_in_uri(edits, token, image);
        else if (ok)
            put_in_file(t, edits, token, image);
        free(uri);
    }
    if (ok && type != JSON_NONE && !norma_json_equals(j, type, "image/png"))
        norma_json_set(edits, token, "mimeType", "\"image/png\"");
    return ok;
}

/* A copy of an element at the end of its list. */
static void append_reference(turner *t, const char *list, json_edits *edits, uint32_t token) {
    json_text text = {0};
    text.failed = !norma_json_write(edits, token, &text);
    norma_json_append_made(t->g->edits, 0, list, &text);
}

static int edit_image(turner *t, uint32_t number) {
    green_image *image = &t->images[number];
    const uint32_t token = norma_json_element(&t->g->json, references_of(t, "images"), number);
    if (image->made == number) return describe_copy(t, t->g->edits, token, image);
    json_edits *edits = norma_json_edits_create(&t->g->json, token);
    const int ok = edits && describe_copy(t, edits, token, image);
    if (ok) append_reference(t, "images", edits, token);
    norma_json_edits_destroy(edits);
    return ok;
}

static int edit_texture(turner *t, uint32_t number) {
    green_texture *texture = &t->textures[number];
    const uint32_t token = norma_json_element(&t->g->json, references_of(t, "textures"), number),
                   source = norma_json_member(&t->g->json, token, "source"),
                   image = t->images[texture->image].made;
    texture->made = number;
    if (is_own_image(t, number)) {
        if (image != texture->image) norma_json_replace_uint(t->g->edits, source, image);
        return 1;
    }
    texture->made = t->texture_count + t->more_textures++;
    json_edits *edits = norma_json_edits_create(&t->g->json, token);
    if (!edits) return 0;
    norma_json_replace_uint(edits, source, image);
    append_reference(t, "textures", edits, token);
    norma_json_edits_destroy(edits);
    return 1;
}

static int is_turned_image(const turner *t, uint32_t texture) {
    return t->textures[texture].turned && t->images[t->textures[texture].image].made != GLTF_NONE;
}

/* In the order in which they were numbered. */
static norma_document_result edit_json(turner *t) {
    int ok = 1;
    t->more_views = t->more_textures = 0;
    for (uint32_t i = 0; i < t->image_count && ok; ++i)
        if (t->images[i].made != GLTF_NONE) ok = edit_image(t, i);
    for (uint32_t i = 0; i < t->texture_count && ok; ++i)
        if (is_turned_image(t, i)) ok = edit_texture(t, i);
    for (uint32_t m = 0; m < t->g->material_count && ok; ++m) {
        uint32_t texture;
        const uint32_t token = t->materials[m] ? reference_index(t, m, &texture) : JSON_NONE;
        if (token != JSON_NONE && is_turned_image(t, texture) &&
            t->textures[texture].made != texture)
            norma_json_replace_uint(t->g->edits, token, t->textures[texture].made);
    }
    return ok ? NORMA_DOCUMENT_OK : fail_green(t);
}

/* ---- all of it */

/* An index that names nothing must not come to mean what is added. */
static int may_add(const turner *t) {
    norma_document_error why;
    const gltf *g = t->g;
    const int may =
        (!t->more_textures || !norma_gltf_check_dangling(g, GLTF_LIST_TEXTURES, &why)) &&
        (!t->more_images || !norma_gltf_check_dangling(g, GLTF_LIST_IMAGES, &why)) &&
        (!t->more_views || !norma_gltf_check_dangling(g, GLTF_LIST_VIEWS, &why));
    if (!may)
        norma_document_add_note(
            g->document, "N812 map-green-flipped is not fixed: %s", why.message);
    return may;
}

static int prepare_images(turner *t, const uint8_t *meshes) {
    const gltf *g = t->g;
    t->texture_count = norma_json_size(&g->json, references_of(t, "textures"));
    t->image_count = norma_json_size(&g->json, references_of(t, "images"));
    t->materials = norma_io_allocate(g->material_count, 1);
    t->textures = norma_io_allocate(t->texture_count, sizeof *t->textures);
    t->images = norma_io_allocate(t->image_count, sizeof *t->images);
    t->texture_uses = norma_io_allocate(t->texture_count, sizeof *t->texture_uses);
    t->image_uses = norma_io_allocate(t->image_count, sizeof *t->image_uses);
    t->given = norma_io_allocate(t->image_count, sizeof *t->given);
    t->pins = norma_gltf_view_pins(g);
    if (!t->materials || !t->textures || !t->images || !t->texture_uses || !t->image_uses ||
        !t->given || !t->pins || !norma_gltf_scene_of(t->g))
        return 0;
    for (uint32_t i = 0; i < t->image_count; ++i) t->images[i].made = GLTF_NONE;
    for (uint32_t p = 0; p < g->primitive_count; ++p)
        if (meshes[p] && g->primitives[p].material < g->material_count)
            t->materials[g->primitives[p].material] = 1;
    count_index_uses(g, "texture", NULL, t->texture_uses, t->texture_count);
    count_index_uses(g, "image", "source", t->image_uses, t->image_count);
    return 1;
}

/* Images that are files become the document's, which shows them from now on. */
static norma_document_result hand_over(turner *t) {
    norma_document *document = t->g->document;
    if (!t->given_count) return NORMA_DOCUMENT_OK;
    given_image *grown =
        realloc(document->images, (document->image_count + t->given_count) * sizeof *grown);
    if (!grown) return fail_green(t);
    document->images = grown;
    for (size_t i = 0; i < t->given_count; ++i) {
        given_image *old = NULL;
        for (size_t k = 0; k < document->image_count && !old; ++k)
            if (grown[k].number == t->given[i].number) old = &grown[k];
        if (old) {
            free(old->bytes);
            free(old->name);
        } else {
            old = &grown[document->image_count++];
        }
        *old = t->given[i];
    }
    t->given_count = 0;
    return NORMA_DOCUMENT_OK;
}

static void free_turner(turner *t) {
    for (uint32_t i = 0; t->images && i < t->image_count; ++i) free(t->images[i].bytes.data);
    for (size_t i = 0; i < t->given_count; ++i) free(t->given[i].bytes);
    void *const blocks[] = {
        t->materials, t->textures, t->images, t->texture_uses, t->image_uses, t->given, t->pins};
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; ++i) free(blocks[i]);
}

norma_document_result norma_gltf_turn_green(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    turner t = {.g = norma_gltf_of(document), .error = error};
    norma_gltf_begin_change(t.g);
    norma_document_result result = prepare_images(&t, meshes) ? find_textures(&t) : fail_green(&t);
    if (!result) result = turn_images(&t);
    *changed = 0;
    for (uint32_t i = 0; !result && i < t.image_count; ++i)
        *changed |= t.images[i].made != GLTF_NONE;
    *changed = *changed && may_add(&t);
    if (!result && *changed) {
        result = edit_json(&t);
        if (!result) result = norma_gltf_finish(t.g, error);
        if (!result) result = hand_over(&t);
    }
    free_turner(&t);
    return result;
}
