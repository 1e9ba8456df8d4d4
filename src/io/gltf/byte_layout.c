/* byte_layout.c: bytes laid out without gaps: in a view of which accessors shrink, and in the
 * buffers; and the JSON that says so. */
#include "io/gltf/gltf_layout.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* ---- A view in which accessors shrink. Where its elements lie side by side in rows, the rows
 * become shorter; else what shrinks leaves for a view of its own, and the rest moves together. */

void norma_gltf_point_data_run(gltf *g, const data_run *run, uint32_t view, size_t offset) {
    if (run->token == GLTF_NONE) {
        g->patch->accessors[run->new_accessor].view = view;
        return;
    }
    if (run->old_view != view || !run->old_size)
        norma_json_set_uint(g->edits, run->token, "bufferView", view);
    if (run->old_view == view && !run->old_size)
        norma_json_set_uint(g->edits, g->views[view].token, "target", (uint64_t)run->target);
    if (run->old_offset != offset) norma_json_set_uint(g->edits, run->token, "byteOffset", offset);
}

typedef struct view_user { /* an accessor in the view */
    uint32_t token;        /* of its object */
    data_run *run;         /* NULL: it stays as it is */
    size_t offset, size, count;
    size_t place; /* in a row, or behind the ranges before it */
} view_user;

typedef struct repacking {
    gltf *g;
    uint32_t view;
    const unsigned char *bytes; /* old ones */
    size_t stride;              /* of the rows; 0: none */
    view_user *users;
    size_t count, capacity, staying;
} repacking;

static int add_view_user(repacking *r, const view_user *user) {
    view_user *added = norma_io_add(&r->users, &r->capacity, &r->count, sizeof *added);
    if (added) *added = *user;
    r->staying += !user->run;
    return added != NULL;
}

static int list_view_users(repacking *r, uint32_t first, const uint32_t *next) {
    const gltf *g = r->g;
    int ok = 1;
    for (uint32_t i = first; ok && i != GLTF_NONE; i = next[i]) {
        data_run *run = &g->patch->runs[i];
        ok = add_view_user(
            r, &(view_user){run->token, run, run->old_offset, run->old_size, run->old_count, 0});
    }
    for (uint32_t a = 0; ok && a < g->accessor_count; ++a) {
        const gltf_accessor *accessor = &g->accessors[a];
        if (accessor->view != r->view || g->patch->replaced[a] != GLTF_NONE) continue;
        ok = add_view_user(r, &(view_user){accessor->token, NULL, accessor->offset,
                                  accessor->element_size, accessor->count, 0});
    }
    return ok;
}

/* ---- rows */

static size_t column(const repacking *r, const view_user *user) { return user->offset % r->stride; }

static int compare_columns(const void *a, const void *b) {
    const view_user *x = a, *y = b;
    if (x->place != y->place) return x->place < y->place ? -1 : 1;
    return x->offset < y->offset ? -1 : x->offset > y->offset;
}

/* Bytes of a user in a new row. */
static size_t new_width(const view_user *user) {
    const size_t size = user->run ? user->run->size : user->size;
    return (size + 3) / 4 * 4;
}

/* The rows that two users of one column share hold the same new bytes. a begins before b. */
static int agree(const repacking *r, const view_user *a, const view_user *b) {
    const size_t before = (b->offset - a->offset) / r->stride;
    size_t shared = before < a->count ? a->count - before : 0;
    if (a->size != b->size || !a->run != !b->run) return 0;
    if (shared > b->count) shared = b->count;
    return !shared || !a->run ||
           (a->run->size == b->run->size && memcmp(a->run->bytes + before * a->run->size,
                                                b->run->bytes, shared * a->run->size) == 0);
}

/* Sorted by columns: whether these are apart, and agree in what they share. */
static int columns_fit(const repacking *r) {
    for (size_t i = 1, far = 0; i < r->count; ++i) {
        const view_user *a = &r->users[far], *b = &r->users[i];
        if (a->place != b->place ? a->place + a->size > b->place : !agree(r, a, b)) return 0;
        if (a->place != b->place ||
            b->offset + b->count * r->stride > a->offset + a->count * r->stride)
            far = i;
    }
    return 1;
}

/* Gives each user its place in the new rows. Returns their length; 0: this view has no such rows.
 */
static size_t place_columns(repacking *r) {
    size_t length = 0;
    for (size_t i = 0; i < r->count; ++i) {
        r->users[i].place = r->stride ? column(r, &r->users[i]) : 0;
        if (!r->stride || r->users[i].place + r->users[i].size > r->stride || !r->users[i].count)
            return 0;
    }
    qsort(r->users, r->count, sizeof *r->users, compare_columns);
    if (!columns_fit(r)) return 0;
    for (size_t i = 0, end; i < r->count; i = end) {
        size_t width = 0;
        const size_t old = r->users[i].place;
        for (end = i; end < r->count && r->users[end].place == old; ++end)
            if (new_width(&r->users[end]) > width) width = new_width(&r->users[end]);
        for (size_t k = i; k < end; ++k) r->users[k].place = length;
        length += width;
    }
    return (length + r->g->alignment - 1) / r->g->alignment * r->g->alignment;
}

static void write_user_rows(
    const repacking *r, const view_user *user, unsigned char *to, size_t stride) {
    const size_t size = user->run ? user->run->size : user->size;
    for (size_t i = 0; i < user->count; ++i)
        memcpy(to + i * stride,
            user->run ? user->run->bytes + i * size : r->bytes + user->offset + i * r->stride,
            size);
}

static void move_user(const repacking *r, const view_user *user, size_t offset) {
    if (user->run) {
        norma_gltf_point_data_run(r->g, user->run, r->view, offset);
        user->run->placed = 1;
    } else if (offset != user->offset) {
        norma_json_set_uint(r->g->edits, user->token, "byteOffset", offset);
    }
}

static norma_document_result shorten_rows(
    const repacking *r, size_t length, norma_document_error *error) {
    patch_view *to = &r->g->patch->views[r->view];
    size_t rows = 0;
    for (size_t i = 0; i < r->count; ++i) {
        const size_t end = r->users[i].offset / r->stride + r->users[i].count;
        if (end > rows) rows = end;
    }
    to->plain.bytes = to->owned = norma_io_allocate(rows, length);
    if (!to->owned) return norma_document_fail_memory(r->g->document, error);
    to->plain.length = rows * length;
    to->stride = to->element = length;
    for (size_t i = 0; i < r->count; ++i) {
        const view_user *user = &r->users[i];
        const size_t offset = user->offset / r->stride * length + user->place;
        write_user_rows(r, user, to->owned + offset, length);
        move_user(r, user, offset);
    }
    return NORMA_DOCUMENT_OK;
}

/* ---- what stays moves together */

static int compare_view_users(const void *a, const void *b) {
    const view_user *x = a, *y = b;
    return x->offset < y->offset ? -1 : x->offset > y->offset;
}

/* Moves by multiples of the alignment, so that everything stays aligned as it was. */
static norma_document_result close_view_gaps(repacking *r, norma_document_error *error) {
    patch_view *to = &r->g->patch->views[r->view];
    const size_t step = r->g->alignment;
    size_t reach = 0, gone = 0, length = 0;
    qsort(r->users, r->count, sizeof *r->users, compare_view_users);
    to->plain.bytes = to->owned = norma_io_allocate(r->g->views[r->view].length + 1, 1);
    if (!to->owned) return norma_document_fail_memory(r->g->document, error);
    for (size_t i = 0; i < r->count; ++i) {
        const view_user *user = &r->users[i];
        const size_t stride = r->stride ? r->stride : user->size,
                     end = user->offset + (user->count - 1) * stride + user->size;
        if (user->run || !user->count) continue;
        if (user->offset > reach) gone += (user->offset - reach) / step * step;
        memcpy(to->owned + user->offset - gone, r->bytes + user->offset, end - user->offset);
        move_user(r, user, user->offset - gone);
        if (end > reach) reach = end;
        length = reach - gone;
    }
    to->plain.length = length;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_repack_view(gltf *g, uint32_t view, uint32_t first,
    const uint32_t *next, int *done, norma_document_error *error) {
    repacking r = {.g = g, .view = view, .stride = g->views[view].stride};
    norma_document_result result = norma_gltf_view_bytes(g, view, &r.bytes, error);
    if (!result && !list_view_users(&r, first, next))
        result = norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < r.count && !g->views[view].stride; ++i) /* rows of one element each */
        r.stride = i == 0 || r.stride == r.users[i].size ? r.users[i].size : 0;
    const size_t length = result || r.count < 2 ? 0 : place_columns(&r);
    *done = 1;
    if (!result && length && length < r.stride)
        result = shorten_rows(&r, length, error);
    else if (!result && r.staying && g->views[view].meshopt.token == GLTF_NONE)
        result = close_view_gaps(&r, error);
    else
        *done = 0;
    free(r.users);
    return result;
}

/* ---- The layout as JSON: offsets and lengths of views, lengths and URIs of buffers, and
 * how views are compressed. */

/* ---- views */

static void describe_compression(json_text *text, const patch_view *view) {
    const gltf_meshopt *m = &view->meshopt;
    norma_json_add_text(text, "{");
    norma_json_add_uint_member(text, "buffer", view->packed.buffer);
    norma_json_add_uint_member(text, "byteOffset", view->packed.offset);
    norma_json_add_uint_member(text, "byteLength", view->packed.length);
    norma_json_add_uint_member(text, "byteStride", m->stride);
    norma_json_add_uint_member(text, "count", m->count);
    norma_json_add_key(text, "mode");
    norma_json_add_quoted(text, norma_gltf_meshopt_modes[m->mode]);
    if (m->filter != GLTF_FILTER_NONE) {
        norma_json_add_key(text, "filter");
        norma_json_add_quoted(text, norma_gltf_meshopt_filters[m->filter]);
    }
    norma_json_add_text(text, "}");
}

/* Compressed bytes that only moved keep their description; of two, under both names of the
 * extension or one of them twice, the one that was read stays. */
static void edit_compression(gltf *g, uint32_t number) {
    const gltf_meshopt *m = &g->views[number].meshopt;
    const patch_view *view = &g->patch->views[number];
    const uint32_t extensions = g->json.tokens[m->token].parent;
    json_edits *edits = g->patch->layout;
    json_text text = {0};
    if (!view->packed.bytes) {
        if (view->packed.offset != m->offset)
            norma_json_set_uint(edits, m->token, "byteOffset", view->packed.offset);
        return;
    }
    describe_compression(&text, view);
    norma_json_unset(edits, extensions, "EXT_meshopt_compression");
    norma_json_unset(edits, extensions, "KHR_meshopt_compression");
    norma_json_set_made(edits, extensions, norma_gltf_extension_of(g, m), &text);
}

static void edit_view(gltf *g, uint32_t number) {
    const gltf_view *old = &g->views[number];
    const patch_view *view = &g->patch->views[number];
    json_edits *edits = g->patch->layout;
    if (old->meshopt.token != GLTF_NONE) edit_compression(g, number);
    if (view->plain.offset != old->offset)
        norma_json_set_uint(edits, old->token, "byteOffset", view->plain.offset);
    if (!view->plain.bytes) return;
    if (view->plain.buffer != old->buffer)
        norma_json_set_uint(edits, old->token, "buffer", view->plain.buffer);
    if (view->plain.length != old->length)
        norma_json_set_uint(edits, old->token, "byteLength", view->plain.length);
    if (view->stride && view->stride != old->stride)
        norma_json_set_uint(edits, old->token, "byteStride", view->stride);
    if (!view->stride && old->stride) norma_json_unset(edits, old->token, "byteStride");
}

static void describe_view(const gltf *g, json_text *text, const patch_view *view) {
    norma_json_add_text(text, "{");
    norma_json_add_uint_member(text, "buffer", view->plain.buffer);
    norma_json_add_uint_member(text, "byteOffset", view->plain.offset);
    norma_json_add_uint_member(text, "byteLength", view->plain.length);
    if (view->stride) norma_json_add_uint_member(text, "byteStride", view->stride);
    if (view->target) norma_json_add_uint_member(text, "target", (uint64_t)view->target);
    if (view->packed.bytes) {
        norma_json_add_key(text, "extensions");
        norma_json_add_text(text, "{");
        norma_json_add_key(text, norma_gltf_extension_of(g, &view->meshopt));
        describe_compression(text, view);
        norma_json_add_text(text, "}");
    }
    norma_json_add_text(text, "}");
}

void norma_gltf_edit_views(gltf *g) {
    const gltf_patch *patch = g->patch;
    for (uint32_t v = 0; v < g->view_count; ++v) edit_view(g, v);
    for (size_t v = g->view_count; v < patch->view_count; ++v) {
        json_text text = {0};
        describe_view(g, &text, &patch->views[v]);
        norma_json_append_made(patch->layout, 0, "bufferViews", &text);
    }
}

/* ---- buffers */

void norma_gltf_add_base64(
    json_text *text, const patch_segment *segments, size_t count, norma_watch *watch) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    uint32_t bits = 0, held = 0;
    for (size_t i = 0; i < count && !text->failed; ++i)
        for (size_t k = 0; k < segments[i].length; ++k) {
            if (k % WATCH_BYTES == WATCH_BYTES - 1 && norma_watch_cancelled(watch)) return;
            bits = bits << 8 | (segments[i].bytes ? segments[i].bytes[k] : 0u);
            if (++held < 3) continue;
            const char four[4] = {digits[bits >> 18 & 63], digits[bits >> 12 & 63],
                digits[bits >> 6 & 63], digits[bits & 63]};
            norma_json_add(text, four, 4);
            bits = held = 0;
        }
    if (held) {
        bits <<= held == 1 ? 16 : 8;
        const char four[4] = {digits[bits >> 18 & 63], digits[bits >> 12 & 63],
            held == 2 ? digits[bits >> 6 & 63] : '=', '='};
        norma_json_add(text, four, 4);
    }
}

/* What stands before the comma of the old data: URI, where that says base64, else what glTF
 * recommends. */
static void add_data_prefix(const gltf *g, uint32_t buffer, json_text *text) {
    uint32_t token = buffer < g->buffer_count
                         ? norma_json_member(&g->json, g->buffers[buffer].token, "uri")
                         : JSON_NONE;
    if (token != JSON_NONE && g->buffers[buffer].storage == GLTF_STORED_DATA) {
        const char *start = g->text + g->json.tokens[token].start + 1,
                   *end = g->text + g->json.tokens[token].end - 1,
                   *comma = memchr(start, ',', (size_t)(end - start));
        if (comma && comma - start >= 7 && memcmp(comma - 7, ";base64", 7) == 0) {
            norma_json_add(text, start, (size_t)(comma + 1 - start));
            return;
        }
    }
    norma_json_add_text(text, "data:application/octet-stream;base64,");
}

static int write_buffer_uri(const gltf *g, uint32_t buffer, json_text *text) {
    const patch_buffer *b = &g->patch->buffers[buffer];
    if (b->name) {
        char *uri = norma_gltf_uri_encode(b->name);
        if (!uri) return 0;
        norma_json_add_quoted(text, uri);
        free(uri);
        return !text->failed;
    }
    norma_json_add_text(text, "\"");
    add_data_prefix(g, buffer, text);
    norma_gltf_add_base64(text, b->segments, b->segment_count, norma_document_watch(g->document));
    norma_json_add_text(text, "\"");
    return !text->failed;
}

static int goes_as_data(const gltf *g, uint32_t buffer, gltf_destination destination) {
    gltf_storage storage = norma_gltf_storage_of(g, buffer);
    return storage == GLTF_STORED_DATA ||
           (storage == GLTF_STORED_FILE && destination == GLTF_TO_STREAM);
}

static int add_segment(
    patch_buffer *buffer, size_t offset, size_t length, const unsigned char *bytes) {
    if (length == 0) return 1;
    patch_segment *added = norma_io_add(
        &buffer->segments, &buffer->segment_capacity, &buffer->segment_count, sizeof *added);
    if (!added) return 0;
    *added = (patch_segment){offset, length, bytes};
    buffer->length = offset + length;
    return 1;
}

/* The whole buffer as one segment, for one that goes as it was. */
static int whole(const gltf *g, uint32_t buffer) {
    patch_buffer *b = &g->patch->buffers[buffer];
    return b->segment_count ||
           add_segment(b, 0, g->buffers[buffer].length, g->buffers[buffer].bytes);
}

static int edit_buffer(gltf *g, uint32_t number, gltf_destination destination) {
    const gltf_buffer *old = &g->buffers[number];
    const patch_buffer *b = &g->patch->buffers[number];
    json_edits *edits = g->patch->layout;
    json_text uri = {0};
    int data = goes_as_data(g, number, destination);
    int moved = data ? b->changed || (old->storage == GLTF_STORED_FILE && old->bytes)
                     : b->name && (!old->name || strcmp(b->name, old->name) != 0);
    if (b->changed && b->byte_length != old->length)
        norma_json_set_uint(edits, old->token, "byteLength", b->byte_length);
    if (!moved) return 1;
    const int ok = whole(g, number) && write_buffer_uri(g, number, &uri);
    norma_json_set_made(edits, old->token, "uri", &uri);
    return ok;
}

static int append_buffer(gltf *g) {
    uint32_t number = g->buffer_count;
    const patch_buffer *b = &g->patch->buffers[number];
    json_text text = {0};
    int ok = 1;
    norma_json_add_text(&text, "{");
    if (norma_gltf_storage_of(g, number) != GLTF_STORED_BIN) {
        norma_json_add_key(&text, "uri");
        ok = write_buffer_uri(g, number, &text);
    }
    norma_json_add_uint_member(&text, "byteLength", b->byte_length);
    norma_json_add_text(&text, "}");
    norma_json_append_made(g->patch->layout, 0, "buffers", &text);
    return ok;
}

norma_document_result norma_gltf_edit_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error) {
    int ok = 1;
    for (uint32_t b = 0; ok && b < g->buffer_count; ++b) ok = edit_buffer(g, b, destination);
    if (ok && g->patch->buffers[g->buffer_count].changed) {
        const norma_document_result dangling =
            norma_gltf_check_dangling(g, GLTF_LIST_BUFFERS, error);
        if (dangling) return dangling;
        ok = append_buffer(g);
    }
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, error);
}

/* ---- Where in the buffers bytes go. A buffer that is written anew is compacted: what
 * was replaced, and what nothing names, is left out, the rest moves together in its order, and new
 * bytes follow; those that are as long as the old ones stand where those were. The file of a
 * buffer that is replaced in place keeps all its bytes that any asset names, and is never
 * shortened: the old asset, and any other that shares the file, reads what it read. New bytes go
 * where nobody names any, else behind the file's real end. */

enum {
    STEP = 8 /* old ones move by multiples of it, so that they stay aligned as they were */
};

static size_t align(const gltf *g, size_t offset) {
    return (offset + g->alignment - 1) / g->alignment * g->alignment;
}

gltf_storage norma_gltf_storage_of(const gltf *g, uint32_t buffer) {
    if (buffer < g->buffer_count) return g->buffers[buffer].storage;
    return g->document->format == NORMA_FILE_GLTF ? GLTF_STORED_FILE
           : g->buffer_count == 0                 ? GLTF_STORED_BIN
                                                  : GLTF_STORED_DATA;
}

int norma_gltf_is_named_twice(const gltf *g, uint32_t buffer) {
    int twice = 0;
    for (uint32_t b = 0; b < g->buffer_count && g->document->folder && !twice; ++b) {
        if (b == buffer || !g->buffers[b].name) continue;
        char *one = norma_io_join(g->document->folder, g->buffers[buffer].name),
             *other = norma_io_join(g->document->folder, g->buffers[b].name);
        twice = !one || !other ? -1 : norma_file_same(one, other);
        free(one);
        free(other);
    }
    return twice;
}

/* Whether the buffer's file is replaced by itself with more in it; -1: out of memory. */
static int keeps_buffer_file(const gltf *g, uint32_t buffer, gltf_destination destination) {
    if (buffer >= g->buffer_count || g->buffers[buffer].storage != GLTF_STORED_FILE) return 0;
    if (destination != GLTF_IN_PLACE) return destination == GLTF_TO_MEMORY;
    const int twice = norma_gltf_is_named_twice(g, buffer);
    return twice < 0 ? twice : !twice;
}

/* ---- places of views */

/* Two places for each view: 2 * view and, of compressed bytes, 2 * view + 1. */
typedef struct spot {
    patch_place *place;
    uint32_t buffer; /* where the bytes were; GLTF_NONE: nowhere */
    size_t start, length;
} spot;

static size_t spot_count(const gltf *g) { return 2 * g->patch->view_count; }

static spot byte_spot_of(const gltf *g, size_t number) {
    patch_view *view = &g->patch->views[number / 2];
    spot s = {.place = number % 2 ? &view->packed : &view->plain, .buffer = GLTF_NONE};
    if (number / 2 >= g->view_count) return s;
    const gltf_view *old = &g->views[number / 2];
    if (number % 2 == 0) {
        s.buffer = old->buffer;
        s.start = old->offset;
        s.length = old->length;
    } else if (old->meshopt.token != GLTF_NONE) {
        s.buffer = old->meshopt.buffer;
        s.start = old->meshopt.offset;
        s.length = old->meshopt.length;
    }
    return s;
}

/* Old bytes from the buffer's end up to another, zeros where there are none. */
static int add_old(patch_buffer *to, size_t end, const unsigned char *old, size_t length) {
    const size_t known = end < length ? end : length;
    return (to->length >= known ||
               add_segment(to, to->length, known - to->length, old + to->length)) &&
           (to->length >= end || add_segment(to, to->length, end - to->length, NULL));
}

/* New bytes that have no place yet, as many as fit between start and end, one after the other;
 * before and between them old ones. */
static int add_new(gltf *g, uint32_t buffer, range gap, const unsigned char *old, size_t length) {
    patch_buffer *to = &g->patch->buffers[buffer];
    size_t at = align(g, gap.start);
    int ok = 1;
    for (size_t i = 0; ok && i < spot_count(g); ++i) {
        patch_place *place = byte_spot_of(g, i).place;
        if (!place->bytes || place->buffer != buffer || place->placed || at > gap.end ||
            place->length > gap.end - at)
            continue;
        place->placed = 1;
        place->offset = at;
        ok = add_old(to, at, old, length) && add_segment(to, at, place->length, place->bytes);
        at = align(g, at + place->length);
    }
    return ok;
}

/* ---- a buffer that is compacted */

typedef struct span { /* of old bytes */
    size_t start, end;
    patch_place *place; /* what is written over them; NULL: they stay */
    size_t to;
} span;

typedef struct spans {
    span *list;
    size_t count, capacity;
} spans;

static int add_span(spans *s, size_t start, size_t end, patch_place *place) {
    span *added = norma_io_add(&s->list, &s->capacity, &s->count, sizeof *added);
    if (added) *added = (span){.start = start, .end = end, .place = place};
    return added != NULL;
}

/* Counts the words that the JSON has on each buffer besides views and their compressed bytes, of
 * which we do not know what they mean. */
static void count_other_names(const gltf *g) {
    const json *j = &g->json;
    patch_buffer *buffers = g->patch->buffers;
    uint64_t number;
    for (size_t i = 0; i < 2 * (size_t)g->view_count; ++i) {
        const uint32_t buffer = byte_spot_of(g, i).buffer;
        if (buffer != GLTF_NONE) --buffers[buffer].other_names;
    }
    for (uint32_t token = 2; token < j->count; ++token)
        if (j->tokens[token].type == JSON_NUMBER &&
            j->tokens[j->tokens[token].parent].type == JSON_OBJECT &&
            norma_json_equals(j, token - 1, "buffer") && norma_json_uint(j, token, &number) &&
            number < g->buffer_count)
            ++buffers[number].other_names;
}

static int find_spans(const gltf *g, uint32_t buffer, size_t length, spans *s) {
    const int whole = buffer == g->buffer_count || g->patch->buffers[buffer].other_names != 0;
    int ok = !whole || add_span(s, 0, length, NULL);
    for (size_t i = 0; ok && i < 2 * (size_t)g->view_count; ++i) {
        const spot one = byte_spot_of(g, i);
        if (one.buffer != buffer || one.start >= length || one.length == 0) continue;
        const int same = one.place->buffer == buffer && one.place->length == one.length;
        if (!one.place->bytes || same)
            ok = add_span(s, one.start,
                one.length > length - one.start ? length : one.start + one.length,
                one.place->bytes ? one.place : NULL);
    }
    return ok;
}

static int compare_spans(const void *a, const void *b) {
    const span *x = a, *y = b;
    return x->start < y->start ? -1 : x->start > y->start;
}

/* In order, and no two that overlap: what shares its bytes is not written over. */
static void separate_spans(spans *s) {
    size_t reach = 0, kept = 0;
    if (s->count) qsort(s->list, s->count, sizeof *s->list, compare_spans);
    for (size_t i = 0; i < s->count; ++i) {
        const span one = s->list[i];
        const int overlaps =
            one.start < reach || (i + 1 < s->count && s->list[i + 1].start < one.end);
        reach = one.end > reach ? one.end : reach;
        if (one.place && overlaps) continue;
        span *last = kept ? &s->list[kept - 1] : NULL;
        if (last && one.start < last->end)
            last->end = one.end > last->end ? one.end : last->end;
        else
            s->list[kept++] = one;
    }
    s->count = kept;
}

/* Spans one behind the other, padding between them and behind them as it was. */
static int add_spans(const spans *s, patch_buffer *to, const unsigned char *old, size_t length) {
    size_t from = 0;
    int ok = 1;
    for (size_t i = 0; ok && i <= s->count; ++i) {
        const size_t start = i < s->count ? s->list[i].start : length, at = to->length;
        if (i == s->count && start - from >= STEP) break;
        const size_t moved = at + (start - at) % STEP;
        ok = add_segment(to, at, moved - at, old && moved - at == start - from ? old + from : NULL);
        if (!ok || i == s->count) break;
        span *one = &s->list[i];
        one->to = moved;
        if (one->place) {
            one->place->offset = moved;
            one->place->placed = 1;
        }
        from = one->end;
        ok = add_segment(to, moved, from - start,
            one->place ? one->place->bytes
            : old      ? old + start
                       : NULL);
    }
    return ok;
}

static size_t moved_to(const spans *s, size_t offset) {
    size_t low = 0, high = s->count; /* the last span that begins at the offset or before it */
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (s->list[middle].start <= offset)
            low = middle + 1;
        else
            high = middle;
    }
    return low ? offset - s->list[low - 1].start + s->list[low - 1].to : offset;
}

static norma_document_result compact(gltf *g, uint32_t buffer, norma_document_error *error) {
    patch_buffer *to = &g->patch->buffers[buffer];
    const unsigned char *old = g->bin; /* a BIN chunk that no buffer spoke of goes into the first */
    size_t length = norma_gltf_storage_of(g, buffer) == GLTF_STORED_BIN ? g->bin_size : 0;
    spans s = {0};
    if (buffer < g->buffer_count) {
        old = g->buffers[buffer].bytes;
        length = g->buffers[buffer].length;
    }
    int ok = find_spans(g, buffer, length, &s);
    separate_spans(&s);
    ok = ok && add_spans(&s, to, old, length);
    for (size_t i = 0; ok && i < 2 * (size_t)g->view_count; ++i) {
        const spot one = byte_spot_of(g, i);
        if (one.buffer == buffer && !one.place->bytes) one.place->offset = moved_to(&s, one.start);
    }
    ok = ok && add_new(g, buffer, (range){to->length, SIZE_MAX}, NULL, 0);
    to->byte_length = to->length;
    free(s.list);
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, error);
}

/* ---- a file that keeps its bytes */

static size_t size_on_disk(const gltf_buffer *b) {
    return b->file.stamp.known && (size_t)b->file.stamp.size < b->available
               ? (size_t)b->file.stamp.size
               : b->available;
}

/* What earlier changes put behind the end of the file, which are not on the disk yet, is new as
 * well. */
static void gather_new(gltf *g, uint32_t buffer, size_t disk) {
    for (size_t i = 0; i < spot_count(g); ++i) {
        const spot one = byte_spot_of(g, i);
        const gltf_buffer *old = &g->buffers[buffer];
        if (one.buffer == buffer && !one.place->bytes && one.start >= disk &&
            one.start <= old->length && one.length <= old->length - one.start)
            one.place->bytes = old->bytes + one.start;
    }
}

/* Up to where views reach, and no less than before. What lies behind is kept, and not named. */
static size_t end_of_views(const gltf *g, uint32_t buffer, size_t end) {
    for (size_t i = 0; i < spot_count(g); ++i) {
        const patch_place *place = byte_spot_of(g, i).place;
        if (place->bytes && place->buffer == buffer && place->offset + place->length > end)
            end = place->offset + place->length;
    }
    return end;
}

static norma_document_result append_to_file(
    gltf *g, uint32_t buffer, gltf_destination destination, norma_document_error *error) {
    const gltf_buffer *b = &g->buffers[buffer];
    patch_buffer *to = &g->patch->buffers[buffer];
    const size_t disk = size_on_disk(b);
    ranges gaps = {0};
    const int failed = destination == GLTF_IN_PLACE ? norma_gltf_find_unnamed(g, buffer, &gaps) : 0;
    int ok = !failed && norma_range_add(&gaps, disk, SIZE_MAX);
    gather_new(g, buffer, disk);
    for (size_t i = 0; ok && i < gaps.count; ++i) {
        range gap = gaps.list[i];
        if (i + 1 < gaps.count && gap.end > disk) gap.end = disk;
        ok = add_new(g, buffer, gap, b->bytes, disk);
    }
    ok = ok && add_old(to, disk, b->bytes, disk);
    to->byte_length = end_of_views(g, buffer, b->length < disk ? b->length : disk);
    free(gaps.list);
    if (failed && failed != ENOMEM)
        return norma_document_fail_file(g->document->path, error,
            "the folder cannot be searched for assets that share its buffer", failed);
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, error);
}

/* ---- all buffers */

/* Changed since it was read from its file, and in none yet. */
static int was_changed(const gltf *g, uint32_t buffer) {
    return buffer < g->document->given_count && g->document->given[buffer].changed;
}

/* What came to it since is our own, and not looked at. */
static norma_document_result check_buffer_file(
    const gltf *g, uint32_t buffer, norma_document_error *error) {
    const gltf_buffer *b = &g->buffers[buffer];
    const file_bytes file = {.data = b->bytes, .size = size_on_disk(b)};
    return norma_gltf_check_own_data(g, buffer, &file, error);
}

static void begin_layout(gltf *g) {
    for (size_t i = 0; i < spot_count(g); ++i) {
        const spot one = byte_spot_of(g, i);
        one.place->placed = 0;
        one.place->offset = one.start;
        if (one.place->bytes) g->patch->buffers[one.place->buffer].changed = 1;
    }
}

norma_document_result norma_gltf_fill_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    begin_layout(g);
    count_other_names(g);
    for (uint32_t b = 0; !result && b <= g->buffer_count; ++b) {
        patch_buffer *buffer = &g->patch->buffers[b];
        buffer->changed |= destination != GLTF_TO_MEMORY && was_changed(g, b);
        if (!buffer->changed) continue;
        if (b < g->buffer_count && g->buffers[b].storage != GLTF_STORED_NOWHERE)
            result = norma_gltf_load_buffer(g, b, error);
        const int keeps = result ? 0 : keeps_buffer_file(g, b, destination);
        if (keeps < 0) {
            result = norma_document_fail_memory(g->document, error);
        } else if (keeps) {
            if (destination == GLTF_IN_PLACE) result = check_buffer_file(g, b, error);
            if (!result) result = append_to_file(g, b, destination, error);
        } else if (!result) {
            result = compact(g, b, error);
        }
    }
    return result;
}

int norma_gltf_segments_equal(const patch_buffer *buffer, const unsigned char *bytes, size_t size) {
    static const unsigned char zeros[64];
    if (size != buffer->length) return 0;
    for (size_t i = 0; i < buffer->segment_count; ++i) {
        const patch_segment *s = &buffer->segments[i];
        if (s->bytes && memcmp(bytes + s->offset, s->bytes, s->length) != 0) return 0;
        for (size_t k = 0; !s->bytes && k < s->length; k += sizeof zeros)
            if (memcmp(bytes + s->offset + k, zeros,
                    s->length - k < sizeof zeros ? s->length - k : sizeof zeros) != 0)
                return 0;
    }
    return 1;
}
