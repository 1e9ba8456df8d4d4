/* assign_views.c: the runs of new bytes, and which views hold them, compressed again where they
 * were. */
#include "io/gltf/gltf_layout.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int add_run(gltf_patch *patch, const data_run *run) {
    data_run *added =
        norma_io_add(&patch->runs, &patch->run_capacity, &patch->run_count, sizeof *added);
    if (added)
        *added = *run;
    else
        free(run->owned);
    return added != NULL;
}

static int target_of(const gltf_data *data) { return data->is_indices ? 34963 : 34962; }

/* ---- min and max */

typedef struct bounds {
    double least[16], most[16];
    int any;
} bounds;

static bounds find_run_bounds(const gltf_data *data) {
    bounds b = {.any = data->count > 0};
    gltf_array array = norma_gltf_array_of(data);
    double element[16];
    array.normalized = 0;
    for (uint32_t k = 0; k < data->width; ++k) {
        b.least[k] = INFINITY;
        b.most[k] = -INFINITY;
    }
    for (size_t i = 0; i < data->count; ++i) {
        norma_gltf_doubles(&array, i, element);
        for (uint32_t k = 0; k < data->width; ++k) {
            const double value = element[k];
            if (value < b.least[k]) b.least[k] = value;
            if (value > b.most[k]) b.most[k] = value;
        }
    }
    for (uint32_t k = 0; k < data->width; ++k) b.any &= isfinite(b.least[k]) && isfinite(b.most[k]);
    return b;
}

static void add_bounds(json_text *text, const double *values, const gltf_data *data) {
    norma_json_add(text, "[", 1);
    for (uint32_t k = 0; k < data->width; ++k) {
        if (k) norma_json_add(text, ",", 1);
        if (data->component == GLTF_UINT)
            norma_json_add_uint(text, (uint64_t)values[k]);
        else if (data->component == GLTF_DOUBLE)
            norma_json_add_number(text, values[k]);
        else
            norma_json_add_float(text, (float)values[k]);
    }
    norma_json_add(text, "]", 1);
}

/* Whether the member says these numbers already, as floats where the data has no doubles. */
static int says_number(const gltf *g, uint32_t list, const double *values, const gltf_data *data) {
    const json *j = &g->json;
    uint32_t k = 0;
    double number;
    if (!norma_json_is(j, list, JSON_ARRAY) || norma_json_size(j, list) != data->width) return 0;
    for (uint32_t item = JSON_NONE; norma_json_each(j, list, &item); ++k)
        if (!norma_json_number(j, item, &number) ||
            (data->component == GLTF_DOUBLE ? number != values[k]
                                            : (float)number != (float)values[k]))
            return 0;
    return 1;
}

static void set_bounds(
    gltf *g, uint32_t accessor, const char *key, const double *values, const gltf_data *data) {
    uint32_t old = norma_json_member(&g->json, accessor, key);
    json_text text = {0};
    if ((old == JSON_NONE && !data->bounds) || says_number(g, old, values, data)) return;
    add_bounds(&text, values, data);
    norma_json_set_made(g->edits, accessor, key, &text);
}

static void edit_bounds(gltf *g, uint32_t accessor, const gltf_data *data) {
    int there = norma_json_member(&g->json, accessor, "min") != JSON_NONE ||
                norma_json_member(&g->json, accessor, "max") != JSON_NONE;
    if (!there && !data->bounds) return;
    bounds b = find_run_bounds(data);
    if (!b.any) {
        norma_json_unset(g->edits, accessor, "min");
        norma_json_unset(g->edits, accessor, "max");
        return;
    }
    set_bounds(g, accessor, "min", b.least, data);
    set_bounds(g, accessor, "max", b.most, data);
}

/* ---- replaced accessors */

static const char *const type_names[] = {"", "\"SCALAR\"", "\"VEC2\"", "\"VEC3\"", "\"VEC4\""};

static void edit_accessor(gltf *g, const gltf_accessor *a, const gltf_data *data) {
    if (a->component != data->component)
        norma_json_set_uint(g->edits, a->token, "componentType", (uint64_t)data->component);
    if (a->normalized != data->normalized) {
        if (data->normalized)
            norma_json_set(g->edits, a->token, "normalized", "true");
        else
            norma_json_unset(g->edits, a->token, "normalized");
    }
    if (a->count != data->count) norma_json_set_uint(g->edits, a->token, "count", data->count);
    if (a->width != data->width && data->width <= 4) /* one that was given up */
        norma_json_set(g->edits, a->token, "type", type_names[data->width]);
    edit_bounds(g, a->token, data);
}

/* Whether all elements but those named are zero bytes: over a base of zeros nothing else need be
 * said then. */
static int rest_is_zero(const gltf_data *data, const uint32_t *indices, size_t named) {
    size_t size = norma_gltf_data_size(data), bytes = data->count * size;
    unsigned char *rest = malloc(bytes ? bytes : 1);
    int zero = rest != NULL;
    if (!rest) return 0;
    memcpy(rest, data->bytes, bytes);
    for (size_t i = 0; i < named; ++i) memset(rest + indices[i] * size, 0, size);
    for (size_t i = 0; zero && i < bytes; ++i) zero = rest[i] == 0;
    free(rest);
    return zero;
}

static int is_zero_run(const gltf_data *data, size_t element) {
    const size_t size = norma_gltf_data_size(data);
    size_t k = 0;
    while (k < size && data->bytes[element * size + k] == 0) ++k;
    return k == size;
}

/* Elements for a sparse part to name where those it named may be gone: first those that a base of
 * zeros does not give. */
static void choose_indices(const gltf_data *data, uint32_t *indices, size_t wanted) {
    size_t other = 0, kept = 0;
    for (size_t i = 0; i < data->count; ++i) other += !is_zero_run(data, i);
    size_t spare = wanted > other ? wanted - other : 0;
    for (size_t i = 0; i < data->count && kept < wanted; ++i) {
        if (is_zero_run(data, i)) {
            if (spare == 0) continue;
            --spare;
        }
        indices[kept++] = (uint32_t)i;
    }
}

/* A run of a sparse part: of the object that is its indices or its values. It takes the bytes, or
 * frees them. */
static int add_sparse_run(gltf *g, const gltf_accessor *a, const char *member, unsigned char *bytes,
    size_t size, size_t count) {
    const int values = strcmp(member, "values") == 0;
    const size_t old_size =
        values ? a->element_size : norma_gltf_component_size(a->sparse.indices_component);
    const uint32_t old_view = values ? a->sparse.values_view : a->sparse.indices_view;
    const data_run run = {.token = norma_json_member(
                              &g->json, norma_json_member(&g->json, a->token, "sparse"), member),
        .new_accessor = GLTF_NONE,
        .old_view = old_view,
        .old_offset = values ? a->sparse.values_offset : a->sparse.indices_offset,
        .old_stride = g->views[old_view].stride ? g->views[old_view].stride : old_size,
        .old_size = old_size,
        .old_count = a->sparse.count,
        .bytes = bytes,
        .owned = bytes,
        .size = size,
        .count = count};
    return bytes && add_run(g->patch, &run);
}

/* Fewer elements than before: the indices are chosen anew, and are no more than there are elements.
 */
static int replace_indices(
    gltf *g, const gltf_accessor *a, const gltf_data *data, uint32_t *indices, size_t count) {
    const size_t size = norma_gltf_component_size(a->sparse.indices_component);
    choose_indices(data, indices, count);
    if (count != a->sparse.count)
        norma_json_set_uint(
            g->edits, norma_json_member(&g->json, a->token, "sparse"), "count", count);
    return add_sparse_run(g, a, "indices",
        norma_gltf_encode_indices(a->sparse.indices_component, indices, count), size, count);
}

/* The runs of the sparse part; *base tells whether the base must be written too. */
static norma_document_result add_sparse(
    gltf *g, uint32_t number, const gltf_data *data, int *base, norma_document_error *error) {
    const gltf_accessor *a = &g->accessors[number];
    const size_t size = norma_gltf_data_size(data),
                 count = a->sparse.count < data->count ? a->sparse.count : data->count;
    uint32_t *indices = norma_io_allocate(a->sparse.count, sizeof *indices);
    norma_document_result result = indices ? norma_gltf_sparse_indices(g, number, indices, error)
                                           : norma_document_fail_memory(g->document, error);
    if (!result && data->count < a->count && !replace_indices(g, a, data, indices, count))
        result = norma_document_fail_memory(g->document, error);
    unsigned char *values = result ? NULL : norma_io_allocate(count, size);
    if (values) {
        *base = a->view != GLTF_NONE || !rest_is_zero(data, indices, count);
        for (size_t i = 0; i < count; ++i)
            memcpy(values + i * size, data->bytes + indices[i] * size, size);
    }
    if (!result && !add_sparse_run(g, a, "values", values, size, count))
        result = norma_document_fail_memory(g->document, error);
    free(indices);
    return result;
}

/* All of an accessor's elements. What a stream of Draco's held has no view yet, and may take the
 * stream's. */
static norma_document_result add_elements(
    gltf *g, const gltf_accessor *a, const gltf_data *data, norma_document_error *error) {
    data_run run = {.token = a->token,
        .new_accessor = GLTF_NONE,
        .old_view = a->view,
        .old_offset = a->offset,
        .bytes = data->bytes,
        .size = norma_gltf_data_size(data),
        .count = data->count,
        .target = target_of(data)};
    if (a->view == GLTF_NONE && a->draco != GLTF_NONE) {
        run.old_view = g->primitives[a->draco].draco.view;
    } else {
        const size_t stride = a->view == GLTF_NONE ? 0 : g->views[a->view].stride;
        run.old_stride = stride ? stride : a->element_size;
        run.old_size = a->element_size;
        run.old_count = a->count;
    }
    return add_run(g->patch, &run) ? NORMA_DOCUMENT_OK
                                   : norma_document_fail_memory(g->document, error);
}

static norma_document_result replace_accessor(
    gltf *g, uint32_t number, norma_document_error *error) {
    const gltf_accessor *a = &g->accessors[number];
    const gltf_data *data = &g->patch->datas[g->patch->replaced[number]];
    int base = 1;
    edit_accessor(g, a, data);
    if (a->sparse.count) {
        norma_document_result result = add_sparse(g, number, data, &base, error);
        if (result) return result;
    } else if (a->view == GLTF_NONE && a->draco == GLTF_NONE) {
        base = !rest_is_zero(data, NULL, 0);
    }
    return base ? add_elements(g, a, data, error) : NORMA_DOCUMENT_OK;
}

/* and edits the accessors */
static norma_document_result gltf_make_data_runs(gltf *g, norma_document_error *error) {
    gltf_patch *patch = g->patch;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; !result && i < g->accessor_count; ++i)
        if (patch->replaced[i] != GLTF_NONE) result = replace_accessor(g, i, error);
    for (uint32_t i = 0; !result && i < patch->accessor_count; ++i) {
        const gltf_data *data = &patch->datas[patch->accessors[i].data];
        const data_run run = {.token = GLTF_NONE,
            .new_accessor = i,
            .old_view = GLTF_NONE,
            .bytes = data->bytes,
            .size = norma_gltf_data_size(data),
            .count = data->count,
            .target = target_of(data)};
        if (!add_run(patch, &run)) result = norma_document_fail_memory(g->document, error);
    }
    return result;
}

/* ---- new accessors */

static void add_type(
    const gltf *g, json_text *text, const patch_accessor *accessor, const gltf_data *data) {
    if (accessor->like != GLTF_NONE && g->accessors[accessor->like].width == data->width) {
        const json_token *type =
            &g->json
                 .tokens[norma_json_member(&g->json, g->accessors[accessor->like].token, "type")];
        norma_json_add(text, g->text + type->start, type->end - type->start);
    } else {
        norma_json_add_text(text, type_names[data->width <= 4 ? data->width : 0]);
    }
}

static void add_bounds_like(const gltf *g, json_text *text, uint32_t like, const char *key,
    const double *values, const gltf_data *data) {
    if (says_number(g, norma_json_member(&g->json, like, key), values, data)) {
        norma_gltf_copy_member(g, text, like, key);
        return;
    }
    norma_json_add_key(text, key);
    add_bounds(text, values, data);
}

/* What parts from an accessor is described as that is: its name, its extras, bounds where it has
 * them. */
static void describe_run(
    const gltf *g, json_text *text, const patch_accessor *accessor, const gltf_data *data) {
    norma_json_add_text(text, "{");
    norma_json_add_uint_member(text, "bufferView", accessor->view);
    norma_json_add_uint_member(text, "componentType", (uint64_t)data->component);
    norma_json_add_uint_member(text, "count", data->count);
    norma_json_add_key(text, "type");
    add_type(g, text, accessor, data);
    if (data->normalized) norma_json_add_text(text, ",\"normalized\":true");
    const uint32_t like =
        accessor->like == GLTF_NONE ? JSON_NONE : g->accessors[accessor->like].token;
    bounds b = {.any = 0};
    if (data->bounds || norma_json_member(&g->json, like, "min") != JSON_NONE ||
        norma_json_member(&g->json, like, "max") != JSON_NONE)
        b = find_run_bounds(data);
    if (b.any) {
        add_bounds_like(g, text, like, "min", b.least, data);
        add_bounds_like(g, text, like, "max", b.most, data);
    }
    norma_gltf_copy_member(g, text, like, "name");
    norma_gltf_copy_member(g, text, like, "extras");
    norma_json_add_text(text, "}");
}

static void gltf_append_accessors(gltf *g) {
    for (size_t i = 0; i < g->patch->accessor_count; ++i) {
        json_text text = {0};
        describe_run(
            g, &text, &g->patch->accessors[i], &g->patch->datas[g->patch->accessors[i].data]);
        norma_json_append_made(g->edits, 0, "accessors", &text);
    }
}

/* ---- Views that EXT_meshopt_compression held, and new ones beside them, compressed
 * again, so that each byte comes back as it was put. */

/* How a view is to be compressed: as it was, unless it holds other things now. */
static void choose_codec(const gltf *g, uint32_t number, patch_view *view) {
    const int old = number < g->view_count;
    gltf_meshopt *m = &view->meshopt;
    *m = g->views[old ? number : view->like].meshopt;
    const int indices = view->target ? view->target == 34963 : m->mode != GLTF_MODE_ATTRIBUTES;
    if (!old || m->stride != view->element) m->filter = GLTF_FILTER_NONE;
    m->stride = view->element;
    m->count = view->plain.length / m->stride;
    if (!indices)
        m->mode = GLTF_MODE_ATTRIBUTES;
    else if (m->mode == GLTF_MODE_ATTRIBUTES || m->count % 3)
        m->mode = m->count % 3 ? GLTF_MODE_INDICES : GLTF_MODE_TRIANGLES;
}

static int suits_codec(const patch_view *view) {
    const gltf_meshopt *m = &view->meshopt;
    return m->count * m->stride == view->plain.length &&
           (m->mode == GLTF_MODE_ATTRIBUTES ? m->stride % 4 == 0 && m->stride <= 256
                                            : m->stride == 2 || m->stride == 4);
}

/* Any bytes are rows of four, once they are padded. */
static int make_rows_of_four(patch_view *view) {
    const size_t length = (view->plain.length + 3) / 4 * 4;
    unsigned char *padded = norma_io_allocate(length, 1);
    if (!padded) return 0;
    memcpy(padded, view->plain.bytes, view->plain.length);
    free(view->owned);
    view->plain.bytes = view->owned = padded;
    view->plain.length = length;
    view->meshopt.mode = GLTF_MODE_ATTRIBUTES;
    view->meshopt.filter = GLTF_FILTER_NONE;
    view->meshopt.stride = 4;
    view->meshopt.count = length / 4;
    return 1;
}

/* assign_views.c: compresses again what was compressed */
static norma_document_result gltf_pack_views(gltf *g, norma_document_error *error) {
    for (uint32_t v = 0; v < g->patch->view_count; ++v) {
        patch_view *view = &g->patch->views[v];
        if (view->packed.buffer == GLTF_NONE || !view->plain.bytes) continue;
        choose_codec(g, v, view);
        if (suits_codec(view) || make_rows_of_four(view))
            view->owned_packed = norma_gltf_encode_meshopt(&view->meshopt, view->plain.bytes);
        if (!view->owned_packed) return norma_document_fail_memory(g->document, error);
        view->packed.bytes = view->owned_packed;
        view->packed.length = view->meshopt.length;
    }
    return NORMA_DOCUMENT_OK;
}

/* ---- Runs find their views. What keeps its size stays where it was; interleaved
 * attributes that all grow stay interleaved; of what outgrows its place, the first takes a view
 * that nobody else needs any more, the rest get new ones. So no view is left unused. */

/* A run of elements in a view: do two of them share bytes? */
typedef struct row_bytes {
    size_t offset, stride, size, count;
} row_bytes;

static row_bytes old_rows(const data_run *run) {
    return (row_bytes){run->old_offset, run->old_stride, run->old_size, run->old_count};
}

static int overlap(const row_bytes *a, const row_bytes *b) {
    if (a->offset + (a->count - 1) * a->stride + a->size <= b->offset ||
        b->offset + (b->count - 1) * b->stride + b->size <= a->offset)
        return 0;
    if (a->stride != b->stride) return 1;
    size_t x = a->offset % a->stride, y = b->offset % a->stride;
    return x + a->size > a->stride || y + b->size > a->stride ||
           (x < y + b->size && y < x + a->size);
}

static int same_run(const data_run *a, const data_run *b) {
    return a->old_offset == b->old_offset && a->old_stride == b->old_stride &&
           a->old_size == b->old_size && a->old_count == b->old_count && a->size == b->size &&
           a->count == b->count && memcmp(a->bytes, b->bytes, a->count * a->size) == 0;
}

/* ---- who uses a view */

static int is_accessor(const gltf *g, uint32_t token) {
    uint32_t list = g->json.tokens[token].parent;
    return list != JSON_NONE && g->json.tokens[list].parent == 0 &&
           norma_json_equals(&g->json, list - 1, "accessors");
}

uint32_t *norma_gltf_view_pins(const gltf *g) {
    const json *j = &g->json;
    uint32_t *pins = norma_io_allocate(g->view_count, sizeof *pins);
    for (uint32_t token = 2; pins && token < j->count; ++token) {
        uint32_t parent = j->tokens[token].parent;
        if (j->tokens[token].type != JSON_NUMBER || j->tokens[parent].type != JSON_OBJECT ||
            !norma_json_equals(j, token - 1, "bufferView") || is_accessor(g, parent))
            continue;
        const uint32_t view = norma_gltf_number(g, token, g->view_count);
        if (view != GLTF_NONE) ++pins[view];
    }
    return pins;
}

typedef struct placer {
    gltf *g;
    gltf_patch *patch;
    uint32_t *stays;        /* for each view: users who keep what is there */
    uint32_t *first, *next; /* runs of each view */
    uint8_t *overrun;       /* of each buffer: a view ends behind it */
    norma_document_error *error;
} placer;

static void count_stays(placer *p) {
    for (uint32_t v = 0; v < p->g->view_count; ++v) p->stays[v] = p->patch->pins[v];
    for (uint32_t a = 0; a < p->g->accessor_count; ++a)
        if (p->g->accessors[a].view != GLTF_NONE && p->patch->replaced[a] == GLTF_NONE)
            ++p->stays[p->g->accessors[a].view];
    for (size_t i = p->patch->run_count; i-- > 0;) {
        const data_run *run = &p->patch->runs[i];
        if (run->old_view == GLTF_NONE) continue;
        p->next[i] = p->first[run->old_view];
        p->first[run->old_view] = (uint32_t)i;
        if (run->target == 0) --p->stays[run->old_view];
    }
}

/* Whether the run can be written over its old bytes without harm to others. */
static int fits_old_bytes(const placer *p, uint32_t number) {
    const data_run *run = &p->patch->runs[number];
    const row_bytes own = old_rows(run);
    const uint32_t pins = p->patch->pins[run->old_view];
    if (run->size != run->old_size || run->count != run->old_count ||
        pins > (run->target == 0 ? 1u : 0u))
        return 0;
    for (uint32_t i = p->first[run->old_view]; i != GLTF_NONE; i = p->next[i]) {
        const row_bytes other = old_rows(&p->patch->runs[i]);
        if (i != number && overlap(&own, &other) && !same_run(run, &p->patch->runs[i])) return 0;
    }
    for (uint32_t a = 0; p->stays[run->old_view] && a < p->g->accessor_count; ++a) {
        const gltf_accessor *accessor = &p->g->accessors[a];
        const row_bytes other = {accessor->offset,
            p->g->views[run->old_view].stride ? p->g->views[run->old_view].stride
                                              : accessor->element_size,
            accessor->element_size, accessor->count};
        if (accessor->view == run->old_view && p->patch->replaced[a] == GLTF_NONE &&
            overlap(&own, &other))
            return 0;
    }
    return 1;
}

/* ---- contents of views */

static norma_document_result fail_views(const placer *p) {
    return norma_document_fail_memory(p->g->document, p->error);
}

static void write_run_rows(unsigned char *to, size_t stride, const data_run *run) {
    for (size_t i = 0; i < run->count; ++i)
        memcpy(to + i * stride, run->bytes + i * run->size, run->size);
}

/* The view's old bytes as a copy to be written into. */
static norma_document_result own_view(placer *p, uint32_t view) {
    const gltf_view *old = &p->g->views[view];
    patch_view *to = &p->patch->views[view];
    const unsigned char *bytes;
    if (to->plain.bytes) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_gltf_view_bytes(p->g, view, &bytes, p->error);
    if (result) return result;
    to->plain.bytes = to->owned = norma_io_block(old->length, 1);
    if (!to->owned) return fail_views(p);
    memcpy(to->owned, bytes, old->length);
    return NORMA_DOCUMENT_OK;
}

/* Whether a run alone is all that an old view holds. */
static int fills_view(const placer *p, uint32_t view, const data_run *run) {
    return !p->patch->views[view].plain.bytes && run->old_offset == 0 &&
           run->old_stride == run->size && p->g->views[view].length == run->count * run->size;
}

static size_t stride_for(const data_run *run) {
    int vertex = run->target == 34962;
    return vertex && run->size % 4 ? (run->size + 3) / 4 * 4 : run->size;
}

/* Runs that left one view and have one stride share a new one, so that the JSON does not grow by
 * more than they shrink. */
static int shares_view(const gltf_patch *patch, const data_run *run, const data_run *with) {
    return patch->tight && with->old_view != GLTF_NONE && with->target == 34962 && !run->placed &&
           run->old_view == with->old_view && run->old_size && run->target == with->target &&
           stride_for(run) == stride_for(with);
}

/* Fills a view, old or new, with the run and those that share it. */
static norma_document_result take_view(placer *p, uint32_t view, size_t first) {
    gltf_patch *patch = p->patch;
    patch_view *to = &patch->views[view];
    const data_run lead = patch->runs[first];
    const size_t stride = stride_for(&lead);
    size_t rows = lead.count, end = first + 1;
    for (size_t i = end; i < patch->run_count; ++i) {
        if (!shares_view(patch, &patch->runs[i], &lead)) continue;
        rows += patch->runs[i].count;
        end = i + 1;
    }
    const int moves = stride != lead.size || rows != lead.count,
              said = view < p->g->view_count && p->g->views[view].stride == stride;
    size_t *starts = norma_io_allocate(end - first, sizeof *starts); /* rows, + 1 */
    if (moves) to->owned = norma_io_allocate(rows, stride);
    if (!starts || rows > SIZE_MAX / stride || (moves && !to->owned)) {
        free(starts);
        return fail_views(p);
    }
    to->plain.bytes = moves ? to->owned : lead.bytes;
    to->element = stride;
    to->stride = moves || said ? stride : 0;
    to->target = lead.target;
    rows = 0;
    for (size_t i = first; i < end; ++i) {
        data_run *run = &patch->runs[i];
        if (i != first && !shares_view(patch, run, &lead)) continue;
        size_t same = first; /* two accessors may be of the same bytes */
        while (same < i && !(starts[same - first] && same_run(&patch->runs[same], run))) ++same;
        const size_t start = same < i ? starts[same - first] - 1 : rows;
        starts[i - first] = start + 1;
        if (moves) write_run_rows(to->owned + start * stride, stride, run);
        norma_gltf_point_data_run(p->g, run, view, start * stride);
        rows += same < i ? 0 : run->count;
        run->placed = 1;
    }
    to->plain.length = rows * stride;
    free(starts);
    return NORMA_DOCUMENT_OK;
}

/* All users grow alike, side by side in one stride: the view grows with them. */
static int can_stay_interleaved(const placer *p, uint32_t view) {
    size_t stride = p->g->views[view].stride;
    const data_run *lead = &p->patch->runs[p->first[view]];
    if (stride == 0 || p->stays[view] || lead->count > SIZE_MAX / stride) return 0;
    for (uint32_t i = p->first[view]; i != GLTF_NONE; i = p->next[i]) {
        const data_run *run = &p->patch->runs[i];
        if (run->size != run->old_size || run->old_count != lead->old_count ||
            run->count != lead->count || run->old_offset + run->size > stride)
            return 0;
        const row_bytes own = old_rows(run);
        for (uint32_t k = p->next[i]; k != GLTF_NONE; k = p->next[k]) {
            const row_bytes other = old_rows(&p->patch->runs[k]);
            if (overlap(&own, &other) && !same_run(run, &p->patch->runs[k])) return 0;
        }
    }
    return 1;
}

static norma_document_result grow_interleaved(placer *p, uint32_t view) {
    patch_view *to = &p->patch->views[view];
    size_t stride = p->g->views[view].stride, count = p->patch->runs[p->first[view]].count;
    to->plain.bytes = to->owned = norma_io_allocate(count, stride);
    if (!to->owned) return fail_views(p);
    to->plain.length = count * stride;
    for (uint32_t i = p->first[view]; i != GLTF_NONE; i = p->next[i]) {
        write_run_rows(to->owned + p->patch->runs[i].old_offset, stride, &p->patch->runs[i]);
        p->patch->runs[i].placed = 1;
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result place_in_view(placer *p, uint32_t view) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    uint32_t leaver = GLTF_NONE;
    int fitting = 0, done = 0;
    if (p->patch->tight && p->patch->pins[view] == 0)
        result = norma_gltf_repack_view(p->g, view, p->first[view], p->next, &done, p->error);
    if (result || done) return result;
    for (uint32_t i = p->first[view]; i != GLTF_NONE; i = p->next[i]) {
        p->patch->runs[i].fits = fits_old_bytes(p, i);
        fitting |= p->patch->runs[i].fits;
        if (!p->patch->runs[i].fits && leaver == GLTF_NONE) leaver = i;
    }
    if (leaver != GLTF_NONE && can_stay_interleaved(p, view)) return grow_interleaved(p, view);
    for (uint32_t i = p->first[view]; !result && i != GLTF_NONE; i = p->next[i]) {
        data_run *run = &p->patch->runs[i];
        if (!run->fits) continue;
        if (fills_view(p, view, run))
            p->patch->views[view].plain.bytes = run->bytes;
        else
            result = own_view(p, view);
        if (!result && p->patch->views[view].owned)
            write_run_rows(p->patch->views[view].owned + run->old_offset, run->old_stride, run);
        run->placed = 1;
    }
    if (!result && leaver != GLTF_NONE && !fitting && p->stays[view] == 0)
        result = take_view(p, view, leaver);
    return result;
}

/* ---- buffers for new bytes */

/* A view that ends behind its buffer is a fault that must not come to mean our bytes when the
 * buffer grows. */
static int find_growing(placer *p) {
    const gltf *g = p->g;
    p->overrun = norma_io_allocate((size_t)g->buffer_count + 1, 1);
    for (uint32_t v = 0; p->overrun && v < g->view_count; ++v) {
        const gltf_meshopt *m = &g->views[v].meshopt;
        p->overrun[g->views[v].buffer] |= (uint8_t)norma_gltf_view_overruns(g, v);
        if (m->token == GLTF_NONE) continue;
        p->overrun[m->buffer] |= !norma_gltf_lies_in(g, m->buffer, m->offset, m->length);
    }
    return p->overrun != NULL;
}

static int may_grow(const placer *p, uint32_t buffer) { return !p->overrun[buffer]; }

/* Where new bytes go: the BIN chunk, else the first buffer that has bytes, else one more buffer. */
static uint32_t choose_buffer(const placer *p) {
    const gltf *g = p->g;
    for (uint32_t i = 0; i < g->buffer_count; ++i)
        if (g->buffers[i].storage == GLTF_STORED_BIN && may_grow(p, i)) return i;
    for (uint32_t i = 0; i < g->buffer_count; ++i)
        if (g->buffers[i].bytes && may_grow(p, i)) return i;
    return g->buffer_count;
}

/* Chooses the buffers of a view's new bytes by those of an old one, GLTF_NONE for none. The plain
 * bytes of a compressed view may have a buffer that holds none. */
static void choose_places(const placer *p, patch_view *to, uint32_t near) {
    const gltf_view *old = near == GLTF_NONE ? NULL : &p->g->views[near];
    const uint32_t any = p->patch->default_buffer;
    const int compressed = old && old->meshopt.token != GLTF_NONE,
              empty = old && p->g->buffers[old->buffer].storage == GLTF_STORED_NOWHERE;
    to->like = compressed ? near : GLTF_NONE;
    to->plain.buffer =
        old && may_grow(p, old->buffer) && (compressed || !empty) ? old->buffer : any;
    to->packed.buffer = !compressed                        ? GLTF_NONE
                        : may_grow(p, old->meshopt.buffer) ? old->meshopt.buffer
                                                           : any;
}

/* ---- new views */

static patch_view *add_view(gltf_patch *patch) {
    return norma_io_add(
        &patch->views, &patch->view_capacity, &patch->view_count, sizeof *patch->views);
}

static norma_document_result add_new_views(placer *p) {
    gltf_patch *patch = p->patch;
    norma_document_result result = NORMA_DOCUMENT_OK;
    uint32_t compressed = 0; /* the first such view: what is quite new is compressed like it */
    while (compressed < p->g->view_count && p->g->views[compressed].meshopt.token == GLTF_NONE)
        ++compressed;
    if (compressed == p->g->view_count) compressed = GLTF_NONE;
    for (size_t i = 0; !result && i < patch->run_count; ++i) {
        data_run *run = &patch->runs[i];
        if (run->placed) continue;
        patch_view *view = add_view(patch);
        if (!view) return fail_views(p);
        choose_places(p, view, run->old_view == GLTF_NONE ? compressed : run->old_view);
        result = take_view(p, (uint32_t)patch->view_count - 1, i);
    }
    return result;
}

/* Images are never compressed like numbers. */
static norma_document_result place_images(placer *p) {
    gltf_patch *patch = p->patch;
    for (size_t i = 0; i < patch->image_count; ++i) {
        patch_image *image = &patch->images[i];
        const int new = image->view == GLTF_NONE;
        patch_view *to = new ? add_view(patch) : &patch->views[image->view];
        if (!to) return fail_views(p);
        if (new) choose_places(p, to, GLTF_NONE);
        to->plain.bytes = to->owned = image->bytes;
        to->plain.length = image->size;
        image->bytes = NULL;
    }
    return NORMA_DOCUMENT_OK;
}

static int prepare_views(placer *p) {
    const gltf *g = p->g;
    gltf_patch *patch = p->patch;
    if (!find_growing(p)) return 0;
    patch->default_buffer = choose_buffer(p);
    patch->pins = norma_gltf_view_pins(g);
    patch->views = norma_io_allocate(g->view_count, sizeof *patch->views);
    patch->view_count = patch->view_capacity = g->view_count;
    p->stays = norma_io_allocate(g->view_count, sizeof *p->stays);
    p->first = norma_io_allocate(g->view_count, sizeof *p->first);
    p->next = norma_io_allocate(patch->run_count, sizeof *p->next);
    if (!patch->views) patch->view_count = 0;
    if (!patch->pins || !patch->views || !p->stays || !p->first || !p->next) return 0;
    norma_gltf_unpin_streams(p->g);
    memset(p->first, 0xFF, g->view_count * sizeof *p->first);
    for (uint32_t v = 0; v < g->view_count; ++v) {
        const gltf_view *old = &g->views[v];
        patch_view *view = &patch->views[v];
        choose_places(p, view, v);
        view->plain.length = old->length;
        view->packed.length = old->meshopt.length;
        view->meshopt = old->meshopt;
        view->stride = old->stride;
        view->element = old->meshopt.token != GLTF_NONE ? old->meshopt.stride : old->stride;
    }
    count_stays(p);
    return 1;
}

norma_document_result norma_gltf_assign_views(gltf *g, norma_document_error *error) {
    placer p = {.g = g, .patch = g->patch, .error = error};
    norma_document_result result = gltf_make_data_runs(g, error);
    if (!result && !prepare_views(&p)) result = fail_views(&p);
    if (!result) result = place_images(&p);
    for (uint32_t v = 0; !result && v < g->view_count; ++v)
        if (p.first[v] != GLTF_NONE) result = place_in_view(&p, v);
    if (!result) result = add_new_views(&p);
    if (!result) result = gltf_pack_views(g, error);
    if (!result) gltf_append_accessors(g);
    free(p.stays);
    free(p.first);
    free(p.next);
    free(p.overrun);
    return result;
}
