/* buffer_names.c: the files that a written asset's buffers go into. Named after the output; in
 * place, buffers keep their names. A file of other content that is in the way is refused, unless it
 * belongs to the very asset that is to be replaced: then the new buffer takes another name, so that
 * the old asset is whole until it is replaced. */
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/other_asset.h"
#include "io/gltf/patch.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

char *norma_gltf_name_after(const char *path, const char *ending) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
               *dot = strrchr(name, '.');
    const size_t length = dot && dot != name ? (size_t)(dot - name) : strlen(name);
    char *stem = norma_io_copy_text(name, length), *out = stem ? norma_io_join(stem, ending) : NULL;
    free(stem);
    return out;
}

/* "scene.bin" for scene.gltf; several: "scene_0.bin", ...; further tries: "scene-1.bin", ... */
static char *name_after(const char *path, uint32_t number, int several, unsigned attempt) {
    char ending[40];
    int at = 0;
    if (several) at += snprintf(ending, 16, "_%u", (unsigned)number);
    if (attempt) at += snprintf(ending + at, 16, "-%u", attempt);
    memcpy(ending + at, ".bin", 5);
    return norma_gltf_name_after(path, ending);
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
