/* buffers.c: buffers and views of glTF: what the JSON says of them, and their bytes, loaded when
 * first needed. A file is opened only inside the asset's folder. Lengths that do not fit are told
 * where the bytes are wanted, not before: a file may hold views that we never touch. */
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/asset.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static norma_document_result read_list(
    const gltf *g, const char *name, uint32_t *list, uint32_t *count, norma_document_error *error) {
    const json *j = &g->json;
    *list = norma_json_member(j, 0, name);
    *count = norma_json_size(j, *list);
    if (*list != JSON_NONE && !norma_json_is(j, *list, JSON_ARRAY))
        return norma_gltf_malformed(g, error, *list, "an array");
    for (uint32_t item = norma_json_first(j, *list); item != JSON_NONE;
         item = norma_json_next(j, *list, item))
        if (!norma_json_is(j, item, JSON_OBJECT))
            return norma_gltf_malformed(g, error, item, "an object");
    return NORMA_DOCUMENT_OK;
}

static char *file_name_of(const gltf *g, uint32_t token) {
    char *uri = norma_json_string(&g->json, token), *name = uri ? norma_gltf_uri_decode(uri) : NULL;
    free(uri);
    return name;
}

static norma_document_result read_uri(gltf *g, uint32_t number, norma_document_error *error) {
    gltf_buffer *buffer = &g->buffers[number];
    uint32_t token = norma_json_member(&g->json, buffer->token, "uri");
    if (token == JSON_NONE) {
        buffer->storage = number == 0 && g->bin ? GLTF_STORED_BIN : GLTF_STORED_NOWHERE;
        return NORMA_DOCUMENT_OK;
    }
    json_span uri;
    if (!norma_json_is(&g->json, token, JSON_STRING))
        return norma_gltf_malformed(g, error, token, "a URI as a string");
    if (!norma_json_span(&g->json, token, &uri))
        return norma_document_fail_memory(g->document, error);
    buffer->storage = norma_gltf_uri_is_data(uri.text) ? GLTF_STORED_DATA : GLTF_STORED_FILE;
    free(uri.owned);
    errno = 0;
    if (buffer->storage == GLTF_STORED_FILE) buffer->name = file_name_of(g, token);
    if (buffer->storage == GLTF_STORED_FILE && !buffer->name && errno == ENOMEM)
        return norma_document_fail_memory(g->document, error);
    return buffer->storage == GLTF_STORED_FILE && !buffer->name
               ? norma_gltf_malformed(
                     g, error, token, "a URI whose percent escapes can be resolved")
               : NORMA_DOCUMENT_OK;
}

static norma_document_result read_meshopt(gltf *g, gltf_view *view, norma_document_error *error) {
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    const json *j = &g->json;
    gltf_meshopt *m = &view->meshopt;
    uint32_t extensions = norma_json_member(j, view->token, "extensions");
    m->token = norma_json_member(j, extensions, "EXT_meshopt_compression");
    if (m->token == JSON_NONE)
        m->token = norma_json_member(j, extensions, "KHR_meshopt_compression");
    if (m->token == JSON_NONE) return NORMA_DOCUMENT_OK;
    m->buffer = GLTF_NONE;
    int ok = norma_gltf_index_member(g, m->token, "buffer", g->buffer_count, &m->buffer) &&
             m->buffer != GLTF_NONE &&
             norma_gltf_size_member(g, m->token, "byteOffset", &m->offset) &&
             norma_gltf_size_member(g, m->token, "byteLength", &m->length) &&
             norma_gltf_size_member(g, m->token, "byteStride", &m->stride) &&
             norma_gltf_size_member(g, m->token, "count", &m->count);
    uint32_t mode = norma_json_member(j, m->token, "mode"),
             filter = norma_json_member(j, m->token, "filter");
    unsigned mode_number = 0, filter_number = 0;
    while (mode_number < 3 && !norma_json_equals(j, mode, modes[mode_number])) ++mode_number;
    while (filter != JSON_NONE && filter_number < 4 &&
           !norma_json_equals(j, filter, filters[filter_number]))
        ++filter_number;
    if (!ok || mode_number == 3 || filter_number == 4)
        return norma_gltf_malformed(g, error, m->token,
            "buffer, byteLength, byteStride, count, mode and filter as EXT_meshopt_compression has "
            "them");
    m->mode = mode_number;
    m->filter = filter_number;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_view_object(
    gltf *g, gltf_view *view, norma_document_error *error) {
    size_t missing = SIZE_MAX;
    view->buffer = GLTF_NONE;
    view->length = missing;
    if (!norma_gltf_index_member(g, view->token, "buffer", g->buffer_count, &view->buffer) ||
        view->buffer == GLTF_NONE)
        return norma_gltf_malformed(
            g, error, view->token, "the number of an existing buffer in \"buffer\"");
    if (!norma_gltf_size_member(g, view->token, "byteLength", &view->length) ||
        view->length == missing ||
        !norma_gltf_size_member(g, view->token, "byteOffset", &view->offset) ||
        !norma_gltf_size_member(g, view->token, "byteStride", &view->stride))
        return norma_gltf_malformed(
            g, error, view->token, "a byteLength, and byteOffset and byteStride as whole numbers");
    return read_meshopt(g, view, error);
}

int norma_gltf_view_overruns(const gltf *g, uint32_t view) {
    const gltf_view *v = &g->views[view];
    const size_t length = g->buffers[v->buffer].length;
    return v->offset > length || v->length > length - v->offset;
}

/* What is used of them is refused where it is used; of the others a person should know. */
static void note_overruns(gltf *g) {
    uint32_t first = GLTF_NONE, count = 0;
    for (uint32_t v = 0; v < g->view_count; ++v)
        if (norma_gltf_view_overruns(g, v)) {
            first = count ? first : v;
            ++count;
        }
    if (count == 1)
        norma_document_add_note(g->document,
            "bufferView %u ends beyond its buffer; its data is missing", (unsigned)first);
    else if (count)
        norma_document_add_note(g->document,
            "%u bufferViews, the first of them %u, end beyond their buffers; their data is missing",
            (unsigned)count, (unsigned)first);
}

norma_document_result norma_gltf_read_buffers(gltf *g, norma_document_error *error) {
    uint32_t buffers, views, number = 0;
    norma_document_result result = read_list(g, "buffers", &buffers, &g->buffer_count, error);
    if (!result) result = read_list(g, "bufferViews", &views, &g->view_count, error);
    if (result) return result;
    g->buffers = norma_io_allocate(g->buffer_count, sizeof *g->buffers);
    g->views = norma_io_allocate(g->view_count, sizeof *g->views);
    if (!g->buffers || !g->views) return norma_document_fail_memory(g->document, error);
    for (uint32_t item = norma_json_first(&g->json, buffers); item != JSON_NONE;
         item = norma_json_next(&g->json, buffers, item), ++number) {
        g->buffers[number].token = item;
        size_t length = SIZE_MAX;
        if (!norma_gltf_size_member(g, item, "byteLength", &length) || length == SIZE_MAX)
            return norma_gltf_malformed(
                g, error, item, "a whole number of bytes in \"byteLength\"");
        g->buffers[number].length = length;
        result = read_uri(g, number, error);
        if (result) return result;
    }
    number = 0;
    for (uint32_t item = norma_json_first(&g->json, views); item != JSON_NONE;
         item = norma_json_next(&g->json, views, item), ++number) {
        g->views[number].token = item;
        result = read_view_object(g, &g->views[number], error);
        if (result) return result;
    }
    note_overruns(g);
    return NORMA_DOCUMENT_OK;
}

/* ---- bytes */

/* One of a settled document is nowhere else. */
static int take_given(const gltf *g, gltf_buffer *buffer) {
    const size_t number = (size_t)(buffer - g->buffers);
    const given_buffer *given =
        number < g->document->given_count ? &g->document->given[number] : NULL;
    if (!given || !given->bytes || given->size < buffer->length) return 0;
    buffer->bytes = given->bytes;
    buffer->available = given->size;
    buffer->file.stamp = given->stamp;
    return 1;
}

static norma_document_result load_buffer_file(
    gltf *g, gltf_buffer *buffer, norma_document_error *error) {
    if (take_given(g, buffer)) return NORMA_DOCUMENT_OK;
    char place[200], *path = NULL;
    norma_gltf_pointer(g, buffer->token, place, sizeof place);
    if (!norma_gltf_path_inside(g->document->folder, buffer->name, &path))
        return errno == ENOMEM
                   ? norma_document_fail_memory(g->document, error)
                   : norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_REFUSED, place,
                         "the buffer %s is not opened, because it is not a file in the asset's "
                         "folder",
                         buffer->name);
    struct stat status;
    int failed = stat(path, &status) ? errno
                 : !S_ISREG(status.st_mode)
                     ? EINVAL
                     : norma_document_load_file(g->document, path, &buffer->file);
    free(path);
    if (failed) {
        char text[160] = "no regular file";
        if (failed != EINVAL) norma_document_system_text(failed, text, sizeof text);
        return norma_document_fail(g->document, error,
            failed == ENOMEM ? NORMA_DOCUMENT_ERROR_MEMORY : NORMA_DOCUMENT_ERROR_FILE, place,
            "the buffer %s cannot be read: %s", buffer->name, text);
    }
    buffer->bytes = buffer->file.data;
    buffer->available = buffer->file.size;
    if (buffer->file.size >= buffer->length) return NORMA_DOCUMENT_OK;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place,
        "the buffer %s has %zu bytes, but should have %zu", buffer->name, buffer->file.size,
        buffer->length);
}

static norma_document_result load_buffer_data(
    gltf *g, gltf_buffer *buffer, norma_document_error *error) {
    uint32_t token = norma_json_member(&g->json, buffer->token, "uri");
    json_span uri;
    if (!norma_json_span(&g->json, token, &uri))
        return norma_document_fail_memory(g->document, error);
    size_t size = 0;
    errno = 0;
    buffer->owned =
        norma_gltf_data_decode(uri.text, uri.length, norma_document_watch(g->document), &size);
    const int out_of_memory = !buffer->owned && errno == ENOMEM;
    free(uri.owned);
    if (out_of_memory) return norma_document_fail_memory(g->document, error);
    if (!buffer->owned) return norma_gltf_malformed(g, error, token, "base64 in the data: URI");
    if (size < buffer->length)
        return norma_gltf_malformed(
            g, error, token, "as many bytes in the data: URI as byteLength says");
    buffer->bytes = buffer->owned;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_load_buffer(
    gltf *g, uint32_t number, norma_document_error *error) {
    gltf_buffer *buffer = &g->buffers[number];
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (buffer->bytes) return result;
    switch (buffer->storage) {
    case GLTF_STORED_BIN:
        if (g->bin_size < buffer->length)
            return norma_gltf_malformed(
                g, error, buffer->token, "a byteLength no longer than the BIN chunk");
        buffer->bytes = g->bin;
        break;
    case GLTF_STORED_FILE:
        result = load_buffer_file(g, buffer, error);
        break;
    case GLTF_STORED_DATA:
        result = load_buffer_data(g, buffer, error);
        break;
    case GLTF_STORED_NOWHERE:
        result =
            norma_gltf_malformed(g, error, buffer->token, "a uri, since these bytes are needed");
        break;
    }
    if (!result) {
        g->held += buffer->length;
        return result;
    }
    free(buffer->owned); /* the next use loads it again */
    norma_file_close(&buffer->file);
    buffer->owned = NULL;
    buffer->bytes = NULL;
    return result;
}
