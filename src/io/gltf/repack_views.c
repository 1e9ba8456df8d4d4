/* repack_views.c: a view in which accessors shrink, laid out without the gaps that they would
 * leave. Where its elements lie side by side in rows, the rows become shorter; else what shrinks
 * leaves for a view of its own, and the rest moves together. */
#include "io/gltf/gltf_layout.h"
#include <stdlib.h>
#include <string.h>

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
