/* output_names.c: names of what is written beside an asset: its buffers, and images that are given.
 */
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/gltf.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

void norma_gltf_count_texture_uses(const gltf *g, uint32_t *counts, size_t textures) {
    count_index_uses(g, "texture", NULL, counts, textures);
}

void norma_gltf_count_image_uses(const gltf *g, uint32_t *counts, size_t images) {
    count_index_uses(g, "image", "source", counts, images);
}

/* ---- The files that new images go into, beside the output and named after it:
 * "scene_normal_2.png". No file of other content is overwritten, and none takes a name that the
 * asset has for something else. On a stream they are data: URIs. */

enum { MOST_ATTEMPTS = 10000 };

static int equals_name(const char *uri, const char *name) {
    return norma_gltf_equals_any_case(uri + (strncmp(uri, "./", 2) == 0 ? 2 : 0), name);
}

/* Whether a buffer or another image has the name; -1: out of memory. */
static int is_named(const gltf *g, const given_image *image, const char *name) {
    const json *j = &g->json;
    const uint32_t images = norma_json_member(j, 0, "images");
    size_t number = 0;
    int failed = 0, found = 0;
    for (uint32_t b = 0; b < g->buffer_count; ++b)
        found |= g->buffers[b].name && equals_name(g->buffers[b].name, name);
    for (uint32_t token = JSON_NONE; !found && !failed && norma_json_each(j, images, &token);
         ++number) {
        if (number == image->number) continue;
        const given_image *given = norma_document_given_image(g->document, number);
        char *other = given ? NULL : norma_gltf_image_name(j, token, &failed);
        found = (given && given->name && equals_name(given->name, name)) ||
                (other && equals_name(other, name));
        free(other);
    }
    return failed ? -1 : found;
}

/* Whether nothing is there, or these very bytes; -1: out of memory. */
static int is_free(const given_image *image, const char *path) {
    file_bytes there;
    const int failed = norma_file_open(path, NULL, &there);
    if (failed) return failed == ENOMEM ? -1 : failed == ENOENT || failed == ENOTDIR;
    const int same = there.size == image->size && memcmp(there.data, image->bytes, there.size) == 0;
    norma_file_close(&there);
    return same;
}

static char *gltf_name_after(const char *path, const char *ending) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
               *dot = strrchr(name, '.');
    const size_t length = dot && dot != name ? (size_t)(dot - name) : strlen(name);
    char *stem = norma_io_copy_text(name, length), *out = stem ? norma_io_join(stem, ending) : NULL;
    free(stem);
    return out;
}

/* 1: chosen, 0: not, -1: out of memory. */
static int try_name(gltf *g, given_image *image, const char *path, unsigned attempt) {
    char ending[60];
    int at = snprintf(ending, sizeof ending, "_normal_%zu", image->number);
    if (attempt) at += snprintf(ending + at, 16, "-%u", attempt);
    memcpy(ending + at, ".png", 5);
    char *name = gltf_name_after(path, ending), *folder = norma_gltf_folder_of(path),
         *file = name && folder ? norma_io_join(folder, name) : NULL;
    const int named = file ? is_named(g, image, name) : -1, chosen = named < 0 ? -1
                                                                     : !named ? is_free(image, file)
                                                                              : 0;
    free(folder);
    free(file);
    if (chosen == 1)
        image->name = name;
    else
        free(name);
    return chosen;
}

static int choose_image_name(gltf *g, given_image *image, const char *path) {
    int chosen = 0;
    free(image->name);
    image->name = NULL;
    for (unsigned attempt = 0; chosen == 0 && attempt < MOST_ATTEMPTS; ++attempt)
        chosen = try_name(g, image, path, attempt);
    return chosen;
}

static void set_uri(gltf *g, uint32_t token, const given_image *image, gltf_destination to) {
    json_text uri = {0};
    char *name = to == GLTF_TO_STREAM ? NULL : norma_gltf_uri_encode(image->name);
    const patch_segment whole = {.length = image->size, .bytes = image->bytes};
    norma_json_add_text(&uri, "\"");
    norma_json_add_text(&uri, name ? name : "data:image/png;base64,");
    if (!name) norma_gltf_add_base64(&uri, &whole, 1, NULL);
    norma_json_add_text(&uri, "\"");
    uri.failed |= !name && to != GLTF_TO_STREAM;
    norma_json_set_made(g->patch->layout, token, "uri", &uri);
    free(name);
}

norma_document_result norma_gltf_name_images(
    gltf *g, gltf_destination destination, const char *path, norma_document_error *error) {
    norma_document *document = g->document;
    for (size_t i = 0; i < document->image_count && destination != GLTF_TO_MEMORY; ++i) {
        given_image *image = &document->images[i];
        const uint32_t token = norma_json_element(
            &g->json, norma_json_member(&g->json, 0, "images"), (uint32_t)image->number);
        const int chosen = destination == GLTF_TO_STREAM ? 1 : choose_image_name(g, image, path);
        if (chosen < 0) return norma_document_fail_memory(document, error);
        if (chosen == 0)
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
                "no name is left beside the output for its normal map %zu", image->number);
        if (token != JSON_NONE) set_uri(g, token, image, destination);
    }
    return NORMA_DOCUMENT_OK;
}

/* ---- The files that a written asset's buffers go into. Named after the output; in
 * place, buffers keep their names. A file of other content that is in the way is refused, unless it
 * belongs to the very asset that is to be replaced: then the new buffer takes another name, so that
 * the old asset is whole until it is replaced. */

int norma_gltf_same_folder(const gltf *g, const char *path) {
    char *folder = norma_gltf_folder_of(path);
    int same = folder && g->document->folder &&
               norma_file_same(
                   folder[0] ? folder : ".", g->document->folder[0] ? g->document->folder : ".");
    free(folder);
    return same;
}

gltf_destination norma_gltf_destination(const gltf *g, const char *path) {
    if (!path) return GLTF_TO_STREAM;
    return norma_file_same(path, g->document->path) ? GLTF_IN_PLACE : GLTF_TO_PATH;
}

/* "scene.bin" for scene.gltf; several: "scene_0.bin", ...; further tries: "scene-1.bin", ... */
static char *name_after(const char *path, uint32_t number, int several, unsigned attempt) {
    char ending[40];
    int at = 0;
    if (several) at += snprintf(ending, 16, "_%u", (unsigned)number);
    if (attempt) at += snprintf(ending + at, 16, "-%u", attempt);
    memcpy(ending + at, ".bin", 5);
    return gltf_name_after(path, ending);
}

typedef enum found { FOUND_NOTHING, FOUND_SAME, FOUND_OTHER, FOUND_UNKNOWN } found;

static found look_for_file(const gltf *g, uint32_t buffer, const char *file) {
    const patch_buffer *b = &g->patch->buffers[buffer];
    file_bytes bytes;
    int failed = norma_file_open(file, NULL, &bytes);
    if (failed)
        return failed == ENOENT                                          ? FOUND_NOTHING
               : failed == EACCES || failed == EISDIR || failed == ELOOP ? FOUND_OTHER
                                                                         : FOUND_UNKNOWN;
    int same = b->changed ? norma_gltf_segments_equal(b, bytes.data, bytes.size)
                          : bytes.size == g->buffers[buffer].length &&
                                memcmp(bytes.data, g->buffers[buffer].bytes, bytes.size) == 0;
    norma_file_close(&bytes);
    return same ? FOUND_SAME : FOUND_OTHER;
}

/* Whether a buffer's name is one that choose_name may have given for this output. */
static int is_named_after(const char *path, uint32_t number, int several, const char *name) {
    char *plain = name_after(path, number, several, 0);
    size_t stem = plain ? strlen(plain) - strlen(".bin") : 0;
    name += strncmp(name, "./", 2) == 0 ? 2 : 0;
    const char *rest = plain && strncmp(name, plain, stem) == 0 ? name + stem : "";
    free(plain);
    if (*rest == '-') rest += 1 + strspn(rest + 1, "0123456789");
    return strcmp(rest, ".bin") == 0;
}

/* Whether the asset that stands at path now has a buffer that was named so for it. */
static int replaces_own(const char *path, uint32_t number, int several) {
    file_bytes file;
    json j;
    int belongs = 0;
    if (!norma_file_is_regular(path) || norma_file_open(path, NULL, &file)) return 0;
    const gltf_other kind = norma_gltf_read_other(&file, &j);
    const uint32_t list = kind == GLTF_OTHER_READ ? norma_json_member(&j, 0, "buffers") : JSON_NONE;
    for (uint32_t item = list == JSON_NONE ? JSON_NONE : norma_json_first(&j, list);
         item != JSON_NONE && !belongs; item = norma_json_next(&j, list, item)) {
        char *uri = norma_json_string(&j, norma_json_member(&j, item, "uri")),
             *name = uri && !norma_gltf_uri_is_data(uri) ? norma_gltf_uri_decode(uri) : NULL;
        belongs = name && is_named_after(path, number, several, name);
        free(name);
        free(uri);
    }
    if (kind == GLTF_OTHER_READ) norma_json_free(&j);
    norma_file_close(&file);
    return belongs;
}

static norma_document_result refuse_name(
    const gltf *g, const char *file, norma_document_error *error) {
    const norma_document target = {.path = (char *)(uintptr_t)file};
    return norma_document_fail(&target, error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
        "exists with other content and is not overwritten; the buffer of %s would be written there",
        g->document->path);
}

static norma_document_result choose_buffer_name(gltf *g, uint32_t buffer, int several,
    const char *path, int free_only, norma_document_error *error) {
    char *folder = norma_gltf_folder_of(path);
    norma_document_result result = NORMA_DOCUMENT_OK;
    int try_more = free_only, chosen = 0;
    for (unsigned attempt = 0; !chosen && !result; ++attempt) {
        char *name = name_after(path, buffer, several, attempt),
             *file = name && folder ? norma_io_join(folder, name) : NULL;
        found there = file ? look_for_file(g, buffer, file) : FOUND_NOTHING;
        chosen = file && (there == FOUND_NOTHING || (there == FOUND_SAME && !free_only));
        if (there == FOUND_UNKNOWN)
            result = norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_FILE, NULL,
                "it cannot be determined whether %s exists; the buffer would be written there",
                file);
        if (!result && file && !chosen && !try_more &&
            !(try_more = replaces_own(path, buffer, several)))
            result = refuse_name(g, file, error);
        if (!file || attempt == 100000) result = norma_document_fail_memory(g->document, error);
        free(file);
        if (chosen && attempt && !free_only)
            norma_document_add_note(g->document,
                "the buffer is written to %s; the replaced asset's buffer keeps its old name",
                name);
        if (chosen)
            g->patch->buffers[buffer].name = name;
        else
            free(name);
    }
    free(folder);
    return result;
}

/* A buffer that no view needs may be out of reach; then its name stays as it is. */
static norma_document_result reach_buffer(
    gltf *g, uint32_t buffer, int *reached, norma_document_error *error) {
    int needed = 0;
    for (uint32_t v = 0; v < g->view_count; ++v)
        needed |= g->views[v].buffer == buffer ||
                  (g->views[v].meshopt.token != GLTF_NONE && g->views[v].meshopt.buffer == buffer);
    norma_document_result result = norma_gltf_load_buffer(g, buffer, needed ? error : NULL);
    *reached = !result;
    return needed || result == NORMA_DOCUMENT_ERROR_MEMORY ? result : NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_name_buffers(
    gltf *g, gltf_destination destination, const char *path, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    uint32_t files = 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t b = 0; b <= g->buffer_count; ++b)
        files += norma_gltf_storage_of(g, b) == GLTF_STORED_FILE &&
                 (b < g->buffer_count || patch->buffers[b].changed);
    for (uint32_t b = 0; !result && b <= g->buffer_count; ++b) {
        int old = b < g->buffer_count, reached = 1;
        if (norma_gltf_storage_of(g, b) != GLTF_STORED_FILE || (!old && !patch->buffers[b].changed))
            continue;
        if (old) result = reach_buffer(g, b, &reached, error);
        if (result || !reached || destination == GLTF_TO_STREAM || destination == GLTF_TO_MEMORY)
            continue;
        const int twice = destination == GLTF_IN_PLACE && old && patch->buffers[b].changed
                              ? norma_gltf_is_named_twice(g, b)
                              : 0;
        if (twice < 0) {
            result = norma_document_fail_memory(g->document, error);
        } else if (destination == GLTF_IN_PLACE && old && !twice) {
            patch->buffers[b].name = norma_io_join(g->buffers[b].name, "");
            result = patch->buffers[b].name ? NORMA_DOCUMENT_OK
                                            : norma_document_fail_memory(g->document, error);
        } else {
            result = choose_buffer_name(g, b, files > 1, path, destination == GLTF_IN_PLACE, error);
        }
    }
    return result;
}
