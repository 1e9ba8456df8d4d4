/* byte_layout.c: where in the buffers new bytes go. What a replaced view leaves behind, and nothing
 * else uses, is free; a view keeps its place where it fits, else it takes the first free place,
 * else the end. In place, no byte of a file beside that any asset names is written over, and the
 * file is never shortened: the old asset, and any other that shares the file, reads what it read.
 * New bytes go where nobody names any, else behind the file's real end. */
#include "io/gltf/write/own_bytes.h"
#include "io/gltf/write/patch.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 4 };

gltf_storage norma_gltf_storage_of(const gltf *g, uint32_t buffer) {
    if (buffer < g->buffer_count) return g->buffers[buffer].storage;
    return g->document->format == NORMA_FILE_GLTF ? GLTF_STORED_FILE
           : g->buffer_count == 0                 ? GLTF_STORED_BIN
                                                  : GLTF_STORED_DATA;
}

/* A buffer that is to be made has the bytes of a BIN chunk that no buffer spoke of. */
static const unsigned char *old_bytes(
    const gltf *g, uint32_t buffer, int whole_file, size_t *length) {
    if (buffer < g->buffer_count) {
        *length = whole_file ? g->buffers[buffer].available : g->buffers[buffer].length;
        return g->buffers[buffer].bytes;
    }
    *length = norma_gltf_storage_of(g, buffer) == GLTF_STORED_BIN && g->bin ? g->bin_size : 0;
    return g->bin;
}

static void add_part(ranges *r, size_t offset, size_t length, size_t limit) {
    if (offset < limit)
        norma_range_add(r, offset, length > limit - offset ? limit : offset + length);
}

/* The padding behind a view goes with it; what lives there is taken away again. */
static size_t padded(size_t offset, size_t length) {
    return length + (ALIGNMENT - (offset + length) % ALIGNMENT) % ALIGNMENT;
}

int norma_gltf_is_named_twice(const gltf *g, uint32_t buffer) {
    int twice = 0;
    for (uint32_t b = 0; b < g->buffer_count && g->document->folder && !twice; ++b) {
        if (b == buffer || !g->buffers[b].name) continue;
        char *one = norma_io_join(g->document->folder, g->buffers[buffer].name),
             *other = norma_io_join(g->document->folder, g->buffers[b].name);
        twice = !one || !other || norma_file_same(one, other);
        free(one);
        free(other);
    }
    return twice;
}

/* Whether the buffer's file is replaced by itself with more in it. */
static int keeps_file(const gltf *g, uint32_t buffer, gltf_destination destination) {
    return buffer < g->buffer_count && g->buffers[buffer].storage == GLTF_STORED_FILE &&
           (destination == GLTF_TO_MEMORY ||
               (destination == GLTF_IN_PLACE && !norma_gltf_is_named_twice(g, buffer)));
}

/* The padding behind a view that goes is free with it. */
static void add_view(
    ranges *dead, ranges *alive, int goes, size_t offset, size_t length, size_t limit) {
    add_part(goes ? dead : alive, offset, goes ? padded(offset, length) : length, limit);
}

/* What of the buffer nobody needs once the new views are in use; of a file that is kept, what
 * nobody needs now either. Returns 0 or errno. */
static int find_free(const gltf *g, uint32_t buffer, int whole_file, size_t length, ranges *left) {
    ranges alive = {0}, dead = {0};
    for (uint32_t v = 0; v < g->view_count; ++v) {
        const gltf_view *view = &g->views[v];
        const int goes = !whole_file && g->patch->views[v].bytes != NULL;
        if (whole_file && g->patch->views[v].bytes) continue;
        if (view->buffer == buffer)
            add_view(&dead, &alive, goes, view->offset, view->length, length);
        if (view->meshopt.token != GLTF_NONE && view->meshopt.buffer == buffer)
            add_view(&dead, &alive, goes, view->meshopt.offset, view->meshopt.length, length);
    }
    const int failed = whole_file ? norma_gltf_unnamed_bytes(g, buffer, &dead) : 0;
    norma_ranges_merge(&alive);
    norma_ranges_merge(&dead);
    norma_ranges_subtract(&dead, &alive, left);
    const int no_memory = alive.failed || dead.failed || left->failed;
    free(alive.list);
    free(dead.list);
    return failed ? failed : no_memory ? ENOMEM : 0;
}

/* ---- giving places */

typedef struct space {
    ranges left; /* the last one reaches to the end of all: SIZE_MAX */
    size_t end;  /* of what is used */
} space;

static void use(space *s, size_t i, size_t offset, size_t length) {
    range whole = s->left.list[i];
    if (offset ==
        whole.start) { /* no empty range stays behind, to be looked at by all that follow */
        s->left.list[i].start = offset + length;
    } else {
        s->left.list[i].end = offset;
    }
    if (offset > whole.start && offset + length < whole.end) {
        norma_range_add(&s->left, 0, 1);
        if (s->left.failed) return;
        memmove(s->left.list + i + 2, s->left.list + i + 1,
            (s->left.count - i - 2) * sizeof *s->left.list);
        s->left.list[i + 1] = (range){offset + length, whole.end};
    }
    if (offset + length > s->end) s->end = offset + length;
}

static int keep_place(space *s, const gltf_view *old, patch_view *view) {
    size_t low = 0,
           high = s->left.count; /* the last range that begins at the old place or before it */
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (s->left.list[middle].start <= old->offset)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0 || view->length > old->length) return 0;
    const range *around = &s->left.list[low - 1];
    if (view->length > around->end - around->start || old->offset > around->end - view->length)
        return 0;
    view->offset = old->offset;
    use(s, low - 1, view->offset, view->length);
    return 1;
}

static void find_place(space *s, patch_view *view) {
    for (size_t i = 0; i < s->left.count && !s->left.failed; ++i) {
        size_t start = (s->left.list[i].start + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
        if (start > s->left.list[i].end || s->left.list[i].end - start < view->length) continue;
        view->offset = start;
        use(s, i, start, view->length);
        return;
    }
}

/* Up to where the views reach: the byteLength. What lies behind is kept, and not spoken of. */
static size_t end_of_views(const gltf *g, uint32_t buffer, size_t end) {
    for (size_t v = 0; v < g->patch->view_count; ++v) {
        const patch_view *view = &g->patch->views[v];
        if (view->bytes && view->buffer == buffer && view->offset + view->length > end)
            end = view->offset + view->length;
    }
    return end;
}

static norma_document_result give_places(
    gltf *g, uint32_t buffer, gltf_destination destination, norma_document_error *error) {
    const int whole_file = keeps_file(g, buffer, destination);
    gltf_patch *patch = g->patch;
    size_t length;
    space s = {.end = 0};
    old_bytes(g, buffer, whole_file, &length);
    int failed = whole_file && destination == GLTF_TO_MEMORY
                     ? 0
                     : find_free(g, buffer, whole_file, length, &s.left);
    const int ok = !failed;
    int reaches_end = !whole_file && s.left.count && s.left.list[s.left.count - 1].end == length;
    s.end = reaches_end ? s.left.list[s.left.count - 1].start : length;
    if (reaches_end)
        s.left.list[s.left.count - 1].end = SIZE_MAX;
    else
        norma_range_add(&s.left, length, SIZE_MAX);
    for (uint32_t v = 0; ok && v < g->view_count; ++v) {
        patch_view *view = &patch->views[v];
        view->allocated = view->bytes && view->buffer == buffer && g->views[v].buffer == buffer &&
                          g->views[v].meshopt.token == GLTF_NONE &&
                          keep_place(&s, &g->views[v], view);
    }
    for (size_t v = 0; ok && v < patch->view_count; ++v)
        if (patch->views[v].bytes && patch->views[v].buffer == buffer && !patch->views[v].allocated)
            find_place(&s, &patch->views[v]);
    patch->buffers[buffer].length = s.end;
    patch->buffers[buffer].byte_length =
        whole_file ? end_of_views(g, buffer, g->buffers[buffer].length) : s.end;
    if (ok && s.left.failed) failed = ENOMEM;
    free(s.left.list);
    if (!failed) return NORMA_DOCUMENT_OK;
    return failed == ENOMEM
               ? norma_document_fail_memory(g->document, error)
               : norma_document_fail_file(g->document->path, error,
                     "the folder cannot be searched for assets that share its buffer", failed);
}

/* ---- the buffer as it will be */

static int add_segment(
    patch_buffer *buffer, size_t offset, size_t length, const unsigned char *bytes) {
    if (length == 0) return 1;
    patch_segment *grown = norma_io_grow(
        buffer->segments, &buffer->segment_capacity, buffer->segment_count + 1, sizeof *grown);
    if (!grown) return 0;
    buffer->segments = grown;
    buffer->segments[buffer->segment_count++] =
        (patch_segment){.offset = offset, .length = length, .bytes = bytes};
    return 1;
}

static int compare_segments(const void *a, const void *b) {
    const patch_segment *x = a, *y = b;
    return x->offset < y->offset ? -1 : x->offset > y->offset;
}

/* Old bytes, then zeros, up to end. */
static int fill_gap(
    patch_buffer *buffer, size_t at, size_t end, const unsigned char *old, size_t old_length) {
    size_t known = end < old_length ? end : old_length;
    if (at < known && !add_segment(buffer, at, known - at, old + at)) return 0;
    at = at < known ? known : at;
    return at >= end || add_segment(buffer, at, end - at, NULL);
}

static int build(const gltf *g, uint32_t number, int whole_file) {
    patch_buffer made = {0}, *buffer = &g->patch->buffers[number];
    size_t old_length, at = 0;
    const unsigned char *old = old_bytes(g, number, whole_file, &old_length);
    int ok = 1;
    for (size_t v = 0; ok && v < g->patch->view_count; ++v)
        if (g->patch->views[v].bytes && g->patch->views[v].buffer == number)
            ok = add_segment(&made, g->patch->views[v].offset, g->patch->views[v].length,
                g->patch->views[v].bytes);
    if (made.segment_count)
        qsort(made.segments, made.segment_count, sizeof *made.segments, compare_segments);
    for (size_t i = 0; ok && i < made.segment_count; ++i) {
        ok = fill_gap(buffer, at, made.segments[i].offset, old, old_length) &&
             add_segment(
                 buffer, made.segments[i].offset, made.segments[i].length, made.segments[i].bytes);
        at = made.segments[i].offset + made.segments[i].length;
    }
    free(made.segments);
    return ok && fill_gap(buffer, at, buffer->length, old, old_length);
}

/* Changed since it was read from its file, and in none yet. */
static int was_changed(const gltf *g, uint32_t buffer) {
    return buffer < g->document->given_count && g->document->given[buffer].changed;
}

/* What came to it since is our own, and not looked at. */
static norma_document_result check_file(
    const gltf *g, uint32_t buffer, norma_document_error *error) {
    const gltf_buffer *b = &g->buffers[buffer];
    const size_t on_disk = b->file.stamp.known ? (size_t)b->file.stamp.size : b->available;
    const file_bytes file = {
        .data = b->bytes, .size = on_disk < b->available ? on_disk : b->available};
    return norma_gltf_check_own_data(g, buffer, &file, error);
}

norma_document_result norma_gltf_fill_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    for (size_t v = 0; v < patch->view_count; ++v)
        patch->buffers[patch->views[v].buffer].changed |= patch->views[v].bytes != NULL;
    for (uint32_t b = 0; b <= g->buffer_count; ++b) {
        patch_buffer *buffer = &patch->buffers[b];
        buffer->changed |= destination != GLTF_TO_MEMORY && was_changed(g, b);
        if (!buffer->changed) continue;
        norma_document_result result =
            b < g->buffer_count ? norma_gltf_load_buffer(g, b, error) : NORMA_DOCUMENT_OK;
        const int whole_file = keeps_file(g, b, destination);
        if (!result && whole_file && destination == GLTF_IN_PLACE) result = check_file(g, b, error);
        if (!result) result = give_places(g, b, destination, error);
        if (!result && !build(g, b, whole_file))
            result = norma_document_fail_memory(g->document, error);
        if (result) return result;
    }
    return NORMA_DOCUMENT_OK;
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
