/* buffers.c: buffers and views as the JSON describes them, and the bytes of buffers, from files
 * beside the asset (never outside its folder), data: URIs and the BIN chunk. */
#define _XOPEN_SOURCE   700
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/gltf.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- URIs of buffers and images: percent escapes (RFC 3986), data: URIs (RFC 2397) with base64
 * (RFC 4648), and whether a name stays in a folder. */

#if defined(_WIN32)
/* Absolute, with slashes, without one at its end. Links are not followed: on Windows it takes an
 * administrator to make one. */
static char *realpath(const char *path, char *resolved) {
    char *out = _fullpath(resolved, path, 0);
    size_t length = out ? strlen(out) : 0;
    for (size_t i = 0; i < length; ++i)
        if (out[i] == '\\') out[i] = '/';
    while (length > 1 && out[length - 1] == '/') out[--length] = '\0';
    return out;
}
#endif

static int uri_hex_value(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Bytes of length characters of escaped text; SIZE_MAX for a bad escape. */
static size_t unescape(const char *text, size_t length, char *out) {
    size_t size = 0;
    for (size_t i = 0; i < length; ++i) {
        char c = text[i];
        if (c == '%') {
            if (length - i < 3 || uri_hex_value(text[i + 1]) < 0 || uri_hex_value(text[i + 2]) < 0)
                return SIZE_MAX;
            c = (char)(uri_hex_value(text[i + 1]) * 16 + uri_hex_value(text[i + 2]));
            i += 2;
        }
        out[size++] = c;
    }
    return size;
}

/* Whether a colon ends the first part, as behind a scheme. */
static int begins_with_scheme(const char *text) { return text[strcspn(text, ":/")] == ':'; }

/* A colon that was escaped is part of a name: "./" in front says so (RFC 3986, 4.2). */
char *norma_gltf_uri_decode(const char *uri) {
    size_t length = strlen(uri);
    char *out = malloc(length + 3);
    size_t size = out ? unescape(uri, length, out) : SIZE_MAX;
    if (size == SIZE_MAX || memchr(out, '\0', size)) {
        free(out);
        return NULL;
    }
    out[size] = '\0';
    if (begins_with_scheme(out) && !begins_with_scheme(uri)) {
        memmove(out + 2, out, size + 1);
        memcpy(out, "./", 2);
    }
    return out;
}

static int needs_no_escape(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           (c != '\0' && strchr("-._~/!$&'()*+,;=@", c) != NULL);
}

char *norma_gltf_uri_encode(const char *name) {
    static const char hex[] = "0123456789ABCDEF";
    char *out = malloc(3 * strlen(name) + 1), *to = out;
    for (; out && *name; ++name) {
        unsigned char c = (unsigned char)*name;
        if (needs_no_escape(*name)) {
            *to++ = *name;
            continue;
        }
        *to++ = '%';
        *to++ = hex[c >> 4];
        *to++ = hex[c & 15];
    }
    if (out) *to = '\0';
    return out;
}

int norma_gltf_uri_is_data(const char *uri) {
    static const char lower[] = "data:";
    for (size_t i = 0; i < 5; ++i)
        if ((uri[i] | 0x20) != (lower[i] | 0x20)) return 0;
    return 1;
}

char *norma_gltf_image_name(const json *j, uint32_t image, int *failed) {
    const uint32_t token =
        norma_json_is(j, image, JSON_OBJECT) ? norma_json_member(j, image, "uri") : JSON_NONE;
    errno = 0;
    char *uri = norma_json_string(j, token),
         *name = uri && !norma_gltf_uri_is_data(uri) ? norma_gltf_uri_decode(uri) : NULL;
    *failed = !name && errno == ENOMEM;
    free(uri);
    return name;
}

static int base64_value(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

static size_t base64_decode(
    const char *text, size_t length, norma_watch *watch, unsigned char *out) {
    const void *asked = text;
    uint32_t bits = 0;
    size_t size = 0, held = 0;
    while (length > 0 && text[length - 1] == '=') --length;
    if (length % 4 == 1) return SIZE_MAX;
    for (size_t i = 0; i < length; ++i) {
        int value = base64_value(text[i]);
        if (value < 0 || norma_watch_passed(watch, &asked, text + i)) return SIZE_MAX;
        bits = bits << 6 | (uint32_t)value;
        held += 6;
        if (held >= 8) {
            held -= 8;
            out[size++] = (unsigned char)(bits >> held);
        }
    }
    return size;
}

/* Most have no percent escape. NULL: out of memory, or a bad one. */
static char *resolve_escapes(const char *text, size_t *length) {
    char *plain = malloc(*length + 1);
    *length = plain ? unescape(text, *length, plain) : SIZE_MAX;
    if (*length != SIZE_MAX) return plain;
    free(plain);
    return NULL;
}

unsigned char *norma_gltf_data_decode(
    const char *uri, size_t length, norma_watch *watch, size_t *size) {
    const char *comma = memchr(uri, ',', length);
    if (!comma) return NULL;
    const char *text = comma + 1;
    const int base64 = comma - uri >= 7 && memcmp(comma - 7, ";base64", 7) == 0;
    length -= (size_t)(text - uri);
    char *plain = memchr(text, '%', length) ? resolve_escapes(text, &length) : NULL;
    unsigned char *out = length == SIZE_MAX ? NULL : malloc(length + 1);
    text = plain ? plain : text;
    *size = out && base64 ? base64_decode(text, length, watch, out) : length;
    if (out && !base64) memcpy(out, text, length);
    free(plain);
    if (*size != SIZE_MAX) return out;
    free(out);
    return NULL;
}

/* No scheme, not absolute, no "..". */
static int is_below(const char *name) {
    if (name[0] == '/' || name[0] == '\0' || begins_with_scheme(name)) return 0;
    for (const char *part = name; part; part = strchr(part, '/')) {
        if (*part == '/') ++part;
        if (part[0] == '.' && part[1] == '.' && (part[2] == '/' || part[2] == '\0')) return 0;
    }
    return strchr(name, '\\') == NULL;
}

char *norma_gltf_real_path(const char *folder, const char *name) {
    char *joined = norma_io_join(folder, name), *real = joined ? realpath(joined, NULL) : NULL;
    if (!real) return joined;
    free(joined);
    return real;
}

int norma_gltf_path_inside(const char *folder, const char *name, char **path) {
    *path = NULL;
    errno = EACCES;
    if (!folder || !is_below(name)) return 0;
    size_t folder_length = strlen(folder), name_length = strlen(name);
    char *joined = malloc(folder_length + name_length + 1);
    if (!joined) return 0;
    memcpy(joined, folder, folder_length);
    memcpy(joined + folder_length, name, name_length + 1);
    char *real_folder = realpath(folder[0] ? folder : ".", NULL);
    int why = real_folder ? 0 : errno;
    char *real = real_folder ? realpath(joined, NULL) : NULL;
    if (real_folder && !real) why = errno;
    size_t length = real_folder ? strlen(real_folder) : 0;
    int root = length == 1;
    /* What is not there cannot lead elsewhere; what could not be looked at might. */
    int inside = real ? strncmp(real, real_folder, length) == 0 && (root || real[length] == '/')
                      : why != ENOMEM;
    free(real_folder);
    free(real);
    if (inside)
        *path = joined;
    else
        free(joined);
    errno = why == ENOMEM ? ENOMEM : EACCES;
    return inside;
}

char *norma_gltf_folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    char *folder = norma_io_allocate(length + 1, 1);
    if (folder) memcpy(folder, path, length);
    return folder;
}

/* ---- Buffers and views of glTF: what the JSON says of them, and their bytes, loaded when
 * first needed. A file is opened only inside the asset's folder. Lengths that do not fit are told
 * where the bytes are wanted, not before: a file may hold views that we never touch. */

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
    norma_document_result result =
        norma_gltf_read_list(g, "buffers", &buffers, &g->buffer_count, error);
    if (!result) result = norma_gltf_read_list(g, "bufferViews", &views, &g->view_count, error);
    if (result) return result;
    g->buffers = norma_io_allocate(g->buffer_count, sizeof *g->buffers);
    g->views = norma_io_allocate(g->view_count, sizeof *g->views);
    if (!g->buffers || !g->views) return norma_document_fail_memory(g->document, error);
    for (uint32_t item = JSON_NONE; norma_json_each(&g->json, buffers, &item); ++number) {
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
    for (uint32_t item = JSON_NONE; norma_json_each(&g->json, views, &item); ++number) {
        g->views[number].token = item;
        result = read_view_object(g, &g->views[number], error);
        if (result) return result;
    }
    note_overruns(g);
    return NORMA_DOCUMENT_OK;
}

/* ---- bytes */

/* That of a document read anew is nowhere else. */
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
