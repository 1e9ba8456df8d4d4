/* buffers.c: the bytes of buffers and views: URIs and paths, what is read from them, and which
 * bytes nothing names. */
#define _XOPEN_SOURCE   700
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/gltf_layout.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- buffers and views as the JSON describes them, and the bytes of buffers, from files beside
 * the asset (never outside its folder), data: URIs and the BIN chunk. */

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
#define lstat stat
#endif

/* Bytes of length characters of escaped text; SIZE_MAX for a bad escape. */
static size_t unescape(const char *text, size_t length, char *out) {
    size_t size = 0;
    for (size_t i = 0; i < length; ++i) {
        char c = text[i];
        if (c == '%') {
            if (length - i < 3 || norma_hex_value(text[i + 1]) < 0 ||
                norma_hex_value(text[i + 2]) < 0)
                return SIZE_MAX;
            c = (char)(norma_hex_value(text[i + 1]) * 16 + norma_hex_value(text[i + 2]));
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

char *norma_gltf_file_name(const json *j, uint32_t image, int *failed) {
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

/* The same, every link followed; to be freed. What is not there, as it is given. NULL: out of
 * memory. */
static char *gltf_real_path(const char *folder, const char *name) {
    char *joined = norma_io_join(folder, name), *real = joined ? realpath(joined, NULL) : NULL;
    if (!real) return joined;
    free(joined);
    return real;
}

static int is_about_the_path(int why) {
    return why == ENOENT || why == ENOTDIR || why == EACCES || why == ELOOP || why == ENAMETOOLONG;
}

/* Whether a path leads below real, a folder: judged by the deepest part of it that is there, so
 * that nobody learns what is elsewhere and what is not. A link that leads nowhere does not. What
 * the system cannot look at does: opening it says why. The path is cut. -1: out of memory. */
static int leads_into(const char *real, char *path) {
    const size_t length = strlen(real);
    struct stat status;
    char *there, *slash;
    int is_cut = 0;
    for (; !(there = realpath(path[0] ? path : ".", NULL)); is_cut = 1) {
        if (errno == ENOMEM || !is_about_the_path(errno)) return errno == ENOMEM ? -1 : 1;
        if (!path[0] || lstat(path, &status) == 0) return 0;
        slash = strrchr(path, '/');
        *(!slash ? path : slash == path ? slash + 1 : slash) = '\0';
    }
    const char *rest = strncmp(there, real, length) == 0 ? there + length : NULL;
    const int inside = rest && (rest[0] == '\0' ? is_cut : rest[0] == '/' || length == 1);
    free(there);
    return inside;
}

int norma_gltf_path_inside(const char *folder, const char *name, char **path) {
    *path = NULL;
    errno = EACCES;
    if (!folder || !is_below(name)) return 0;
    char *joined = norma_io_join(folder, name), *cut = norma_io_join(folder, name),
         *real = realpath(folder[0] ? folder : ".", NULL);
    const int inside = !joined || !cut || (!real && errno == ENOMEM) ? -1
                       : real                                        ? leads_into(real, cut)
                                                                     : 1;
    free(cut);
    free(real);
    if (inside > 0)
        *path = joined;
    else
        free(joined);
    errno = inside < 0 ? ENOMEM : EACCES;
    return inside > 0;
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

const char *const norma_gltf_meshopt_modes[3] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
const char *const norma_gltf_meshopt_filters[4] = {
    "NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};

static norma_document_result read_meshopt(gltf *g, gltf_view *view, norma_document_error *error) {
    const json *j = &g->json;
    gltf_meshopt *m = &view->meshopt;
    m->token = norma_gltf_extension(g, view->token, "EXT_meshopt_compression");
    if (m->token == JSON_NONE)
        m->token = norma_gltf_extension(g, view->token, "KHR_meshopt_compression");
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
    while (mode_number < 3 && !norma_json_equals(j, mode, norma_gltf_meshopt_modes[mode_number]))
        ++mode_number;
    while (filter != JSON_NONE && filter_number < 4 &&
           !norma_json_equals(j, filter, norma_gltf_meshopt_filters[filter_number]))
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
    return !norma_gltf_lies_in(g, v->buffer, v->offset, v->length);
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
    const gltf_place place = norma_gltf_pointer(g, buffer->token);
    char *path = NULL;
    if (!norma_gltf_path_inside(g->document->folder, buffer->name, &path))
        return errno == ENOMEM
                   ? norma_document_fail_memory(g->document, error)
                   : norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_REFUSED,
                         place.text,
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
            failed == ENOMEM ? NORMA_DOCUMENT_ERROR_MEMORY : NORMA_DOCUMENT_ERROR_FILE, place.text,
            "the buffer %s cannot be read: %s", buffer->name, text);
    }
    buffer->bytes = buffer->file.data;
    buffer->available = buffer->file.size;
    if (buffer->file.size >= buffer->length) return NORMA_DOCUMENT_OK;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, place.text,
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

/* ---- which bytes of a buffer's file an asset may write over; other assets of its folder are
 * asked. */

/* ---- Finds and parses the JSON of a .gltf or GLB, whatever the file is called. */

enum { GLB_TEXT = 20, LARGEST_TEXT = 1 << 28 };

static int begins_like_json(const char *text, size_t size) {
    size_t at = size >= 3 && memcmp(text, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    while (at < size && (text[at] == ' ' || (text[at] >= '\t' && text[at] <= '\r'))) ++at;
    return at < size && text[at] == '{';
}

gltf_other norma_gltf_read_other(const file_bytes *file, json *j) {
    const char *text = (const char *)file->data;
    size_t size = file->size;
    json_error wrong;
    if (size > GLB_TEXT && memcmp(text, "glTF", 4) == 0) {
        const size_t length = norma_gltf_u32(file->data + 12);
        text += GLB_TEXT;
        size = length < size - GLB_TEXT ? length : size - GLB_TEXT;
    } else if (!begins_like_json(text, size)) {
        return GLTF_OTHER_NONE;
    }
    if (size > LARGEST_TEXT) return GLTF_OTHER_UNKNOWN;
    if (norma_json_parse(text, size, NULL, j, &wrong)) return GLTF_OTHER_READ;
    norma_json_free(j);
    return wrong.expected ? GLTF_OTHER_UNKNOWN : GLTF_OTHER_MEMORY;
}

/* ---- Which bytes of a buffer's file an asset may write over when it is changed in place.
 * Other assets may share the file, and a copy of the asset may be kept as a backup, so every file
 * of the folder that reads as glTF, and as far as the limits go of the folders below, is asked
 * which bytes it names. Bytes that nobody names may be used again; all others stay as they are. */

enum { MOST_ENTRIES = 4096, DEEPEST = 16, LARGEST_ASSETS = 1 << 28 };

typedef struct search {
    const gltf *g;
    const char *file;   /* the buffer's, as a path */
    const char *folder; /* the one that is looked through, with its slash */
    ranges named;
    size_t length; /* the largest that any asset says of the file */
    size_t entries[2],
        read[2]; /* in the folder itself; below it, where limits only end the search */
    int depth;   /* 0: in the folder itself */
    int unknown; /* something there may name bytes and cannot be asked */
    int failed;  /* errno: the system could not answer, or out of memory */
} search;

static void fail_if(search *s, int condition, int error) {
    if (condition && !s->failed) s->failed = error;
}

/* Whether the system could answer: a file that is not there, or nobody may look at, is an answer.
 */
static void check_answer(search *s, int yes) {
    const int error = yes ? 0 : errno;
    fail_if(s, error && error != ENOENT && error != ENOTDIR && error != ELOOP && error != EACCES,
        error);
}

/* ---- one asset */

int norma_range_add(ranges *r, size_t start, size_t end) {
    range *added = norma_io_add(&r->list, &r->capacity, &r->count, sizeof *added);
    if (added) *added = (range){start, end};
    return added != NULL;
}

static void add_named_range(search *s, size_t start, size_t end) {
    fail_if(s, !norma_range_add(&s->named, start, end), ENOMEM);
}

/* Which of its buffers are the file; NULL: none, or out of memory. */
static uint8_t *find_buffers(search *s, const json *j, uint32_t list, uint32_t count) {
    uint8_t *same = norma_io_allocate(count, 1);
    uint32_t number = 0;
    int any = 0;
    for (uint32_t item = JSON_NONE; same && norma_json_each(j, list, &item); ++number) {
        const uint32_t token = norma_json_member(j, item, "uri");
        char *uri = norma_json_string(j, token),
             *name = uri && !norma_gltf_uri_is_data(uri) ? norma_gltf_uri_decode(uri) : NULL,
             *path = name ? norma_io_join(s->folder, name) : NULL;
        const int undecoded = uri && !name && !norma_gltf_uri_is_data(uri);
        s->unknown |= undecoded && strchr(uri, '%') != NULL; /* a bad escape */
        const int is_text = token != JSON_NONE && j->tokens[token].type == JSON_STRING;
        fail_if(
            s, (name && !path) || (is_text && !uri) || (undecoded && !strchr(uri, '%')), ENOMEM);
        errno = 0;
        same[number] = path && norma_file_same(path, s->file);
        check_answer(s, same[number]);
        any |= same[number];
        free(path);
        free(name);
        free(uri);
    }
    fail_if(s, !same, ENOMEM);
    if (any) return same;
    free(same);
    return NULL;
}

static size_t size_of_named(const json *j, uint32_t object, const char *key, size_t otherwise) {
    uint64_t value;
    const uint32_t token = norma_json_member(j, object, key);
    return norma_json_uint(j, token, &value) && value < SIZE_MAX / 4 ? (size_t)value : otherwise;
}

/* Views, compressed bytes, and whatever an extension may add: each names a buffer, and a part of it
 * or all. A buffer that is named nowhere is used in a way that is not known here. */
static void add_named_bytes(search *s, const json *j) {
    const uint32_t list = norma_json_member(j, 0, "buffers"), count = norma_json_size(j, list);
    uint8_t *same = norma_json_is(j, list, JSON_ARRAY) ? find_buffers(s, j, list, count) : NULL;
    for (uint32_t object = 1; same && object < j->count; ++object) {
        const uint32_t token = norma_json_member(j, object, "buffer");
        uint64_t buffer;
        if (token == JSON_NONE || !norma_json_uint(j, token, &buffer) || buffer >= count) continue;
        if (!same[buffer]) continue;
        const size_t offset = size_of_named(j, object, "byteOffset", 0),
                     length = size_of_named(j, object, "byteLength", SIZE_MAX / 4);
        same[buffer] = 2;
        add_named_range(s, offset, offset + length);
    }
    uint32_t b = 0;
    for (uint32_t item = JSON_NONE; same && norma_json_each(j, list, &item); ++b) {
        const size_t length = same[b] ? size_of_named(j, item, "byteLength", 0) : 0;
        s->length = length > s->length ? length : s->length;
        if (same[b] == 1) add_named_range(s, 0, SIZE_MAX / 4);
    }
    free(same);
}

static void ask_asset(search *s, const file_bytes *bytes) {
    json j;
    const gltf_other kind = norma_gltf_read_other(bytes, &j);
    const int below = s->depth > 0;
    s->read[below] += kind ? bytes->size : 0;
    fail_if(s, kind == GLTF_OTHER_MEMORY, ENOMEM);
    s->unknown |= !below && (kind == GLTF_OTHER_UNKNOWN || s->read[0] > LARGEST_ASSETS);
    if (kind == GLTF_OTHER_READ && !s->unknown) add_named_bytes(s, &j);
    if (kind == GLTF_OTHER_READ) norma_json_free(&j);
}

static int visit_entry(void *user, const char *name);

/* What cannot be read there, or lies behind a link or hidden, is passed over. */
static void look_below(search *s, const char *path, const char *name) {
    const char *above = s->folder;
    char *folder = NULL;
    if (name[0] != '.' && s->depth < DEEPEST && !norma_file_is_link(path))
        fail_if(s, !(folder = norma_io_join(path, "/")), ENOMEM);
    if (!folder) return;
    s->folder = folder;
    ++s->depth;
    (void)norma_folder_visit(folder, visit_entry, s);
    --s->depth;
    s->folder = above;
    free(folder);
}

static int visit_entry(void *user, const char *name) {
    search *s = user;
    file_bytes bytes;
    const int below = s->depth > 0,
              enough = ++s->entries[below] > MOST_ENTRIES || s->read[below] > LARGEST_ASSETS;
    if (below && enough) return 1;
    char *path = norma_io_join(s->folder, name);
    s->unknown |= enough;
    fail_if(s, !path, ENOMEM);
    errno = 0;
    const int regular = path && norma_file_is_regular(path);
    check_answer(s, regular);
    const int same = regular && norma_file_same(path, s->file);
    check_answer(s, same);
    if (regular && !same && !s->failed) {
        const int error = norma_file_open(path, &(file_reading){.map_large = 1}, &bytes);
        if (!error) {
            ask_asset(s, &bytes);
            norma_file_close(&bytes);
        } else {
            fail_if(s, error != EACCES, error);
            s->unknown |= !below;
        }
    } else if (path && !regular && !s->failed) {
        look_below(s, path, name);
    }
    free(path);
    return s->unknown || s->failed;
}

/* ---- all of them */

static void look_through(search *s, const char *folder) {
    s->folder = folder;
    const int error = norma_folder_visit(folder[0] ? folder : ".", visit_entry, s);
    fail_if(s, error && error != EACCES, error);
    s->unknown |= error != 0;
}

static int compare_ranges(const void *a, const void *b) {
    const range *x = a, *y = b;
    return x->start < y->start ? -1 : x->start > y->start;
}

static void find_gaps(search *s, ranges *left) {
    size_t end = 0;
    if (s->named.count) qsort(s->named.list, s->named.count, sizeof *s->named.list, compare_ranges);
    for (size_t i = 0; i <= s->named.count; ++i) {
        const int last = i == s->named.count;
        size_t start = last ? s->length : s->named.list[i].start;
        if (start > s->length) start = s->length;
        if (start > end) fail_if(s, !norma_range_add(left, end, start), ENOMEM);
        if (!last && s->named.list[i].end > end) end = s->named.list[i].end;
    }
}

int norma_gltf_find_unnamed(const gltf *g, uint32_t buffer, ranges *left) {
    const char *folder = g->document->folder;
    char *real = gltf_real_path(folder, g->buffers[buffer].name),
         *beside = real ? norma_gltf_folder_of(real) : NULL;
    search s = {.g = g, .file = real};
    fail_if(&s, !beside, ENOMEM);
    if (!s.failed) look_through(&s, folder);
    if (!s.failed && !s.unknown && !norma_file_same(beside, folder[0] ? folder : "."))
        look_through(&s, beside);
    if (!s.failed && !s.unknown) find_gaps(&s, left);
    free(s.named.list);
    free(beside);
    free(real);
    return s.failed;
}

/* ---- what a file looks like */

int norma_gltf_is_hidden(const char *name) {
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (part[0] == '.' && part[1] != '/') return 1;
    }
    return 0;
}

static char lower_case(char c) { return (char)(c >= 'A' && c <= 'Z' ? c + 32 : c); }

int norma_gltf_equals_any_case(const char *a, const char *b) {
    for (; *a && *b; ++a, ++b)
        if (lower_case(*a) != lower_case(*b)) return 0;
    return *a == *b;
}

int norma_gltf_has_suffix(const char *name, const char *const *suffixes, size_t count) {
    const char *slash = strrchr(name, '/'), *dot = strrchr(slash ? slash : name, '.');
    for (size_t i = 0; dot && i < count; ++i)
        if (norma_gltf_equals_any_case(dot + 1, suffixes[i])) return 1;
    return 0;
}

/* Numbers of vertices hold zeros and signs; a whole file without either is a text. */
static int is_text(const unsigned char *bytes, size_t size) {
    const size_t looked_at = size < 4096 ? size : 4096;
    for (size_t i = 0; i < looked_at; ++i)
        if (bytes[i] > '~' || (bytes[i] < ' ' && (bytes[i] < '\t' || bytes[i] > '\r'))) return 0;
    return size > 0;
}

static int begins_like_another_kind(const unsigned char *bytes, size_t size) {
    static const char *const kinds[] = {
        "glTF", "\x89PNG", "\xFF\xD8\xFF\xE0", "\x7F\x45LF", "PK\3\4", "%PDF", "RIFF", "\xABKTX"};
    for (size_t i = 0; size >= 4 && i < sizeof kinds / sizeof *kinds; ++i)
        if (memcmp(bytes, kinds[i], 4) == 0) return 1;
    return is_text(bytes, size);
}

norma_document_result norma_gltf_check_own_data(
    const gltf *g, uint32_t buffer, const file_bytes *file, norma_document_error *error) {
    static const char *const suffixes[] = {"bin", "glbin", "glbuf", "buf", "buffer", "dat", "data"};
    const gltf_buffer *b = &g->buffers[buffer];
    char *real = gltf_real_path(g->document->folder, b->name);
    if (!real) return norma_document_fail_memory(g->document, error);
    const char *slash = strrchr(real, '/');
    const int looks_right =
        !norma_gltf_is_hidden(b->name) && !norma_gltf_is_hidden(slash ? slash + 1 : real) &&
        norma_gltf_has_suffix(real, suffixes, sizeof suffixes / sizeof *suffixes) &&
        !begins_like_another_kind(file->data, file->size);
    free(real);
    if (looks_right) return NORMA_DOCUMENT_OK;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_REFUSED,
        norma_gltf_pointer(g, b->token).text,
        "the buffer %s does not look like data of a glTF file, and is neither changed nor copied; "
        "expected a binary file with a name like scene.bin",
        b->name);
}
