/* gltf_write.c: a change begun and ended, and a changed document written: the names of its buffers
 * and images, its layout, its container. */
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/gltf_layout.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bytes in order, until one call of write fails. */
typedef struct gltf_output {
    norma_write *write;
    void *user;
    int failed;
} gltf_output;

/* ---- names of what is written beside an asset: its buffers, and images that are given. */

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
        char *other = given ? NULL : norma_gltf_file_name(j, token, &failed);
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

/* "scene", of a path "folder/scene.glb", with an ending; further attempts: "-1", ... */
static char *gltf_name_after(
    const char *path, const char *ending, unsigned attempt, const char *suffix) {
    char all[80];
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
               *dot = strrchr(name, '.');
    const size_t length = dot && dot != name ? (size_t)(dot - name) : strlen(name);
    if (attempt)
        snprintf(all, sizeof all, "%s-%u%s", ending, attempt, suffix);
    else
        snprintf(all, sizeof all, "%s%s", ending, suffix);
    char *stem = norma_io_copy_text(name, length), *out = stem ? norma_io_join(stem, all) : NULL;
    free(stem);
    return out;
}

/* 1: chosen, 0: not, -1: out of memory. */
static int try_name(gltf *g, given_image *image, const char *path, unsigned attempt) {
    char ending[40];
    snprintf(ending, sizeof ending, "_normal_%zu", image->number);
    char *name = gltf_name_after(path, ending, attempt, ".png"),
         *folder = norma_gltf_folder_of(path),
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

static norma_document_result gltf_name_images(
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
    char ending[16] = "";
    if (several) snprintf(ending, sizeof ending, "_%u", (unsigned)number);
    return gltf_name_after(path, ending, attempt, ".bin");
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
    for (uint32_t item = JSON_NONE;
         list != JSON_NONE && !belongs && norma_json_each(&j, list, &item);) {
        int failed;
        char *name = norma_gltf_file_name(&j, item, &failed);
        belongs = name && is_named_after(path, number, several, name);
        free(name);
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

static norma_document_result gltf_name_buffers(
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

/* ---- The beginning and the end of a change: what was put becomes accessors (patch.c), views
 * (assign_views.c) and edits of the JSON. */

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

/* ---- The asset written as bytes, to a file or to be opened again. */

enum { BYTE_LENGTH = 8, ALIGNED = 8 };

size_t norma_gltf_surplus(const gltf *g) {
    const size_t size = g->container_size ? g->tile.end - g->tile.at - g->container_size : 0;
    return g->tile.depth && size < ALIGNED ? 0 : size;
}

/* ---- writing: bytes in order */

static void gltf_write_bytes(gltf_output *out, const void *bytes, size_t size) {
    if (!out->failed && size) out->failed = out->write(out->user, bytes, size);
}

static void gltf_write_fill(gltf_output *out, unsigned char fill, size_t size) {
    unsigned char block[256];
    memset(block, fill, sizeof block);
    for (; size > 0 && !out->failed; size -= size < sizeof block ? size : sizeof block)
        gltf_write_bytes(out, block, size < sizeof block ? size : sizeof block);
}

static void gltf_write_u32(gltf_output *out, uint32_t value) {
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
        (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    gltf_write_bytes(out, bytes, 4);
}

/* ---- what is around a GLB */

/* How many zeros follow a GLB of so many bytes. */
static size_t tile_padding(const gltf *g, size_t glb) {
    if (!g->tile.depth) return 0;
    const size_t length =
        g->tile.at - g->tile.headers[g->tile.depth - 1] + glb + norma_gltf_surplus(g);
    return (ALIGNED - length % ALIGNED) % ALIGNED;
}

static size_t gltf_tile_size(const gltf *g, size_t glb) {
    return g->tile.at + glb + norma_gltf_surplus(g) + tile_padding(g, glb) +
           (g->document->source.size - g->tile.end);
}

static void gltf_begin_tile(const gltf *g, size_t glb, gltf_output *out) {
    const unsigned char *source = g->document->source.data;
    const uint32_t grown = (uint32_t)(gltf_tile_size(g, glb) - g->document->source.size);
    size_t at = 0;
    for (uint32_t i = 0; i < g->tile.depth; ++i) {
        const size_t length = g->tile.headers[i] + BYTE_LENGTH;
        gltf_write_bytes(out, source + at, length - at);
        gltf_write_u32(out, norma_gltf_u32(source + length) + grown);
        at = length + 4;
    }
    gltf_write_bytes(out, source + at, g->tile.at - at);
}

static void gltf_end_tile(const gltf *g, size_t glb, gltf_output *out) {
    const unsigned char *source = g->document->source.data;
    gltf_write_bytes(out, source + g->tile.at + g->container_size, norma_gltf_surplus(g));
    gltf_write_fill(out, 0, tile_padding(g, glb));
    gltf_write_bytes(out, source + g->tile.end, g->document->source.size - g->tile.end);
}

/* ---- The asset's main file: the JSON with all edits, as text or in a GLB with its other
 * chunks as they were. */

static const uint32_t GLB_BIN = 0x004E4942;
enum { GLB_HEADER = 12, GLB_CHUNK_HEADER = 8 };

static norma_document_result gltf_lay_out_for(
    gltf *g, gltf_destination destination, const char *path, norma_document_error *error) {
    norma_document_result result = g->patch ? NORMA_DOCUMENT_OK : norma_gltf_finish(g, error);
    if (result) return result;
    gltf_patch *patch = g->patch;
    norma_gltf_free_layout(g);
    patch->buffers = norma_io_allocate((size_t)g->buffer_count + 1, sizeof *patch->buffers);
    patch->layout = norma_json_edits_copy(g->edits);
    result = patch->buffers && patch->layout ? NORMA_DOCUMENT_OK
                                             : norma_document_fail_memory(g->document, error);
    if (!result) result = norma_gltf_fill_buffers(g, destination, error);
    if (!result) result = gltf_name_buffers(g, destination, path, error);
    if (!result) result = gltf_name_images(g, destination, path, error);
    if (!result) norma_gltf_edit_views(g);
    if (!result) result = norma_gltf_edit_buffers(g, destination, error);
    if (!result && norma_json_edits_failed(patch->layout))
        result = norma_document_fail_memory(g->document, error);
    return result;
}

norma_document_result norma_gltf_lay_out(gltf *g, const char *path, norma_document_error *error) {
    const char *key = path ? path : "";
    if (g->patch && g->patch->laid_out_for && strcmp(g->patch->laid_out_for, key) == 0)
        return NORMA_DOCUMENT_OK;
    norma_document_result result =
        gltf_lay_out_for(g, norma_gltf_destination(g, path), path, error);
    if (result) return result;
    g->patch->laid_out_for = norma_io_join(key, "");
    return g->patch->laid_out_for ? NORMA_DOCUMENT_OK
                                  : norma_document_fail_memory(g->document, error);
}

static size_t padding(size_t size) { return (4 - size % 4) % 4; }

static void put_segments(gltf_output *out, const patch_buffer *buffer) {
    for (size_t i = 0; i < buffer->segment_count; ++i) {
        if (buffer->segments[i].bytes)
            gltf_write_bytes(out, buffer->segments[i].bytes, buffer->segments[i].length);
        else
            gltf_write_fill(out, 0, buffer->segments[i].length);
    }
}

static void put_bin(gltf_output *out, const patch_buffer *bin) {
    gltf_write_u32(out, (uint32_t)(bin->length + padding(bin->length)));
    gltf_write_u32(out, GLB_BIN);
    put_segments(out, bin);
    gltf_write_fill(out, 0, padding(bin->length));
}

/* The BIN chunk where it is written anew, else NULL. */
static const patch_buffer *new_bin(const gltf *g) {
    for (uint32_t b = 0; b <= g->buffer_count; ++b)
        if (g->patch->buffers[b].changed && norma_gltf_storage_of(g, b) == GLTF_STORED_BIN)
            return &g->patch->buffers[b];
    return NULL;
}

static size_t chunk_size(const gltf *g, size_t at) {
    return GLB_CHUNK_HEADER + norma_gltf_u32(g->document->source.data + g->tile.at + at);
}

static norma_document_result write_glb(
    gltf *g, const json_text *text, gltf_output *out, norma_document_error *error) {
    const unsigned char *source = g->document->source.data + g->tile.at;
    const patch_buffer *bin = new_bin(g);
    size_t first = GLB_HEADER + chunk_size(g, GLB_HEADER),
           json_size = text->size + padding(text->size);
    size_t total = GLB_HEADER + GLB_CHUNK_HEADER + json_size + (g->container_size - first);
    if (bin)
        total += GLB_CHUNK_HEADER + bin->length + padding(bin->length) -
                 (g->bin ? GLB_CHUNK_HEADER + g->bin_size : 0);
    if (gltf_tile_size(g, total) > UINT32_MAX)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
            "would become larger than the 4 GiB that a GLB can be; expected a .gltf with its "
            "buffers beside it");
    gltf_begin_tile(g, total, out);
    gltf_write_bytes(out, "glTF", 4);
    gltf_write_u32(out, 2);
    gltf_write_u32(out, (uint32_t)total);
    gltf_write_u32(out, (uint32_t)json_size);
    gltf_write_bytes(out, "JSON", 4);
    gltf_write_bytes(out, text->data, text->size);
    gltf_write_fill(out, ' ', padding(text->size));
    if (bin && !g->bin) put_bin(out, bin);
    for (size_t at = first; at < g->container_size; at += chunk_size(g, at)) {
        if (bin && g->bin && at == g->bin_chunk)
            put_bin(out, bin);
        else
            gltf_write_bytes(out, source + at, chunk_size(g, at));
    }
    gltf_end_tile(g, total, out);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result gltf_write_laid_out(
    gltf *g, norma_write *write, void *user, norma_document_error *error) {
    gltf_output out = {.write = write, .user = user};
    json_text text = {0};
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!norma_json_write(g->patch->layout, 0, &text))
        result = norma_document_fail_memory(g->document, error);
    else if (g->document->format != NORMA_FILE_GLTF)
        result = write_glb(g, &text, &out, error);
    else
        gltf_write_bytes(&out, text.data, text.size);
    free(text.data);
    if (!result && out.failed)
        result = norma_document_fail(
            g->document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
    return result;
}

norma_document_result norma_gltf_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    if (norma_gltf_differs(g)) {
        norma_document_result result = norma_gltf_lay_out(g, path, error);
        return result ? result : gltf_write_laid_out(g, write, user, error);
    }
    if (document->source.size == 0 || !write(user, document->source.data, document->source.size))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(
        document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
}

/* ---- The buffers of a changed .gltf, in memory, for the document that is read from its new
 * JSON before either is on the disk. */

static int copy_buffer(const patch_segment *segments, size_t count, size_t size, given_buffer *to) {
    to->bytes = norma_io_allocate(size, 1);
    for (size_t i = 0; to->bytes && i < count; ++i)
        if (segments[i].bytes)
            memcpy(to->bytes + segments[i].offset, segments[i].bytes, segments[i].length);
    to->size = size;
    return to->bytes != NULL;
}

static norma_document_result give_buffers(
    const gltf *g, norma_document *made, norma_document_error *error) {
    const norma_document *document = g->document;
    made->given = norma_io_allocate((size_t)g->buffer_count + 1, sizeof *made->given);
    if (!made->given) return norma_document_fail_memory(document, error);
    made->given_count = (size_t)g->buffer_count + 1;
    for (uint32_t b = 0; b < g->buffer_count; ++b) {
        given_buffer *given = &made->given[b];
        const patch_buffer *changed = &g->patch->buffers[b];
        const patch_segment whole = {0, g->buffers[b].available, g->buffers[b].bytes};
        int fine = 1;
        if (g->buffers[b].storage != GLTF_STORED_FILE) continue;
        given->changed =
            changed->changed || (b < document->given_count && document->given[b].changed);
        if (changed->changed)
            fine = copy_buffer(changed->segments, changed->segment_count, changed->length, given);
        else if (whole.bytes)
            fine = copy_buffer(&whole, 1, whole.length, given);
        given->stamp = g->buffers[b].file.stamp;
        if (!fine) return norma_document_fail_memory(document, error);
    }
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_reopen(
    norma_document *document, norma_document *made, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    growing_bytes bytes = {0};
    norma_document_result result = gltf_lay_out_for(g, GLTF_TO_MEMORY, NULL, error);
    if (!result) result = gltf_write_laid_out(g, norma_memory_sink_write, &bytes, error);
    if (result == NORMA_DOCUMENT_ERROR_FILE) /* only memory can fail of a sink in memory */
        result = norma_document_fail_memory(document, error);
    made->source = (file_bytes){.data = bytes.data ? (const void *)bytes.data : "",
        .size = bytes.size,
        .owned = bytes.data != NULL};
    return result ? result : give_buffers(g, made, error);
}

int norma_gltf_has_change(const norma_document *document) {
    return norma_gltf_of(document)->changed || document->replaced;
}

void norma_gltf_adopt(norma_document *document) {
    if (document->state) norma_gltf_of(document)->document = document;
}
