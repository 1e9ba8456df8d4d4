/* uri.c: URIs of buffers and images: percent escapes (RFC 3986), data: URIs (RFC 2397) with base64
 * (RFC 4648), and whether a name stays in a folder. */
#define _XOPEN_SOURCE 700
#include "io/gltf/asset.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

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
