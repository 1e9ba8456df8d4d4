/* byte_layout.c: where in the buffers new bytes go. What a replaced view leaves behind, and nothing
 * else uses, is free; a view keeps its place where it fits, else it takes the first free place,
 * else the end. In place, a file beside is only added to: the old asset, and any other that shares
 * the file, reads what it read. */
#include "io/gltf/write/patch.h"
#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 4 };

typedef struct range {
    size_t start, end;
} range;

typedef struct ranges {
    range *list;
    size_t count, capacity;
    int failed;
} ranges;

static void add_range(ranges *r, size_t start, size_t end) {
    if (end <= start || r->failed) return;
    range *grown = norma_io_grow(r->list, &r->capacity, r->count + 1, sizeof *grown);
    if (!grown) {
        r->failed = 1;
        return;
    }
    r->list = grown;
    r->list[r->count++] = (range){start, end};
}

static int compare_ranges(const void *a, const void *b) {
    const range *x = a, *y = b;
    return x->start < y->start ? -1 : x->start > y->start;
}

static void sort_and_merge(ranges *r) {
    if (r->count < 2) return;
    qsort(r->list, r->count, sizeof *r->list, compare_ranges);
    size_t last = 0;
    for (size_t i = 1; i < r->count; ++i) {
        if (r->list[i].start > r->list[last].end)
            r->list[++last] = r->list[i];
        else if (r->list[i].end > r->list[last].end)
            r->list[last].end = r->list[i].end;
    }
    r->count = last + 1;
}

static void take_away(const ranges *from, const ranges *what, ranges *left) {
    size_t k = 0;
    for (size_t i = 0; i < from->count; ++i) {
        size_t at = from->list[i].start, end = from->list[i].end;
        while (k < what->count && what->list[k].end <= at) ++k;
        for (size_t m = k; m < what->count && what->list[m].start < end; ++m) {
            add_range(left, at, what->list[m].start);
            if (what->list[m].end > at) at = what->list[m].end;
        }
        add_range(left, at, end);
    }
}

gltf_storage norma_gltf_storage_of(const gltf *g, uint32_t buffer) {
    if (buffer < g->buffer_count) return g->buffers[buffer].storage;
    return g->document->format == NORMA_FILE_GLTF ? GLTF_STORED_FILE
           : g->buffer_count == 0                 ? GLTF_STORED_BIN
                                                  : GLTF_STORED_DATA;
}

/* A buffer that is to be made has the bytes of a BIN chunk that no buffer spoke of. */
static const unsigned char *old_bytes(const gltf *g, uint32_t buffer, size_t *length) {
    if (buffer < g->buffer_count) {
        *length = g->buffers[buffer].length;
        return g->buffers[buffer].bytes;
    }
    *length = norma_gltf_storage_of(g, buffer) == GLTF_STORED_BIN && g->bin ? g->bin_size : 0;
    return g->bin;
}

static void add_part(ranges *r, size_t offset, size_t length, size_t limit) {
    if (offset < limit) add_range(r, offset, length > limit - offset ? limit : offset + length);
}

/* The padding behind a view goes with it; what lives there is taken away again. */
static size_t padded(size_t offset, size_t length) {
    return length + (ALIGNMENT - (offset + length) % ALIGNMENT) % ALIGNMENT;
}

/* What of the buffer nobody needs once the new views are in use. */
static int find_free(const gltf *g, uint32_t buffer, size_t length, ranges *left) {
    ranges alive = {0}, dead = {0};
    for (uint32_t v = 0; v < g->view_count; ++v) {
        const gltf_view *view = &g->views[v];
        const int goes = g->patch->views[v].bytes != NULL;
        if (view->buffer == buffer)
            add_part(goes ? &dead : &alive, view->offset,
                goes ? padded(view->offset, view->length) : view->length, length);
        if (view->meshopt.token != GLTF_NONE && view->meshopt.buffer == buffer)
            add_part(goes ? &dead : &alive, view->meshopt.offset,
                goes ? padded(view->meshopt.offset, view->meshopt.length) : view->meshopt.length,
                length);
    }
    sort_and_merge(&alive);
    sort_and_merge(&dead);
    take_away(&dead, &alive, left);
    int ok = !alive.failed && !dead.failed && !left->failed;
    free(alive.list);
    free(dead.list);
    return ok;
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
        add_range(&s->left, 0, 1);
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

static norma_document_result give_places(
    gltf *g, uint32_t buffer, int only_add, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    size_t length;
    space s = {.end = 0};
    old_bytes(g, buffer, &length);
    int ok = only_add || find_free(g, buffer, length, &s.left);
    int reaches_end = s.left.count && s.left.list[s.left.count - 1].end == length;
    s.end = reaches_end ? s.left.list[s.left.count - 1].start : length;
    if (reaches_end)
        s.left.list[s.left.count - 1].end = SIZE_MAX;
    else
        add_range(&s.left, length, SIZE_MAX);
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
    ok = ok && !s.left.failed;
    free(s.left.list);
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, error);
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

static int build(const gltf *g, uint32_t number) {
    patch_buffer made = {0}, *buffer = &g->patch->buffers[number];
    size_t old_length, at = 0;
    const unsigned char *old = old_bytes(g, number, &old_length);
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

norma_document_result norma_gltf_fill_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    for (size_t v = 0; v < patch->view_count; ++v)
        patch->buffers[patch->views[v].buffer].changed |= patch->views[v].bytes != NULL;
    for (uint32_t b = 0; b <= g->buffer_count; ++b) {
        patch_buffer *buffer = &patch->buffers[b];
        if (!buffer->changed) continue;
        norma_document_result result =
            b < g->buffer_count ? norma_gltf_load_buffer(g, b, error) : NORMA_DOCUMENT_OK;
        if (!result)
            result = give_places(g, b,
                destination == GLTF_IN_PLACE && norma_gltf_storage_of(g, b) == GLTF_STORED_FILE,
                error);
        if (!result && !build(g, b)) result = norma_document_fail_memory(g->document, error);
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
