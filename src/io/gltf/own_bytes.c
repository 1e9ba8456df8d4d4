/* own_bytes.c: which bytes of a buffer's file an asset may write over; other assets of its folder
 * are asked. */
#define _POSIX_C_SOURCE 200809L
#include "io/gltf/gltf.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

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
    range *grown = norma_io_grow(r->list, &r->capacity, r->count + 1, sizeof *grown);
    if (!grown) return 0;
    r->list = grown;
    r->list[r->count++] = (range){start, end};
    return 1;
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
    char *real = norma_gltf_real_path(folder, g->buffers[buffer].name),
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
    char place[200], *real = norma_gltf_real_path(g->document->folder, b->name);
    if (!real) return norma_document_fail_memory(g->document, error);
    const char *slash = strrchr(real, '/');
    const int looks_right =
        !norma_gltf_is_hidden(b->name) && !norma_gltf_is_hidden(slash ? slash + 1 : real) &&
        norma_gltf_has_suffix(real, suffixes, sizeof suffixes / sizeof *suffixes) &&
        !begins_like_another_kind(file->data, file->size);
    free(real);
    if (looks_right) return NORMA_DOCUMENT_OK;
    norma_gltf_pointer(g, b->token, place, sizeof place);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_REFUSED, place,
        "the buffer %s does not look like data of a glTF file, and is neither changed nor copied; "
        "expected a binary file with a name like scene.bin",
        b->name);
}
