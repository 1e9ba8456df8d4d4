/* data_runs.c: replaced and new accessors as JSON, and as runs of elements that views are
 * to hold. A sparse accessor stays sparse: its base and its values are two runs, so that none of
 * its views is left without use. */
#include "io/gltf/gltf.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int add_run(gltf_patch *patch, const data_run *run) {
    data_run *grown =
        norma_io_grow(patch->runs, &patch->run_capacity, patch->run_count + 1, sizeof *grown);
    if (!grown) {
        free(run->owned);
        return 0;
    }
    patch->runs = grown;
    patch->runs[patch->run_count++] = *run;
    return 1;
}

static int target_of(const gltf_data *data) { return data->is_indices ? 34963 : 34962; }

/* ---- min and max */

typedef struct bounds {
    double least[16], most[16];
    int any;
} bounds;

static bounds find_run_bounds(const gltf_data *data) {
    bounds b = {.any = data->count > 0};
    gltf_array array = {.data = data->bytes,
        .count = data->count,
        .stride = norma_gltf_data_size(data),
        .component = data->component,
        .width = data->width};
    double element[16];
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
    for (uint32_t item = norma_json_first(j, list); item != JSON_NONE;
         item = norma_json_next(j, list, item), ++k)
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
    norma_json_add(&text, "", 1);
    if (text.failed)
        norma_json_edits_fail(g->edits);
    else
        norma_json_set(g->edits, accessor, key, text.data);
    free(text.data);
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
    unsigned char *bytes = norma_io_allocate(count, size);
    choose_indices(data, indices, count);
    for (size_t i = 0; bytes && i < count * size; ++i)
        bytes[i] = (unsigned char)(indices[i / size] >> 8 * (i % size));
    if (count != a->sparse.count)
        norma_json_set_uint(
            g->edits, norma_json_member(&g->json, a->token, "sparse"), "count", count);
    return add_sparse_run(g, a, "indices", bytes, size, count);
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

norma_document_result norma_gltf_make_data_runs(gltf *g, norma_document_error *error) {
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

/* A member as the accessor of before has it, in its own text. */
static void add_same(const gltf *g, json_text *text, uint32_t like, const char *key) {
    uint32_t value = norma_json_member(&g->json, like, key);
    if (value == JSON_NONE) return;
    const json_token *token = &g->json.tokens[value];
    norma_json_add_text(text, ",");
    norma_json_add_quoted(text, key);
    norma_json_add_text(text, ":");
    norma_json_add(text, g->text + token->start, token->end - token->start);
}

static void add_bounds_like(const gltf *g, json_text *text, uint32_t like, const char *key,
    const double *values, const gltf_data *data) {
    if (says_number(g, norma_json_member(&g->json, like, key), values, data)) {
        add_same(g, text, like, key);
        return;
    }
    norma_json_add_text(text, ",");
    norma_json_add_quoted(text, key);
    norma_json_add_text(text, ":");
    add_bounds(text, values, data);
}

/* What parts from an accessor is described as that is: its name, its extras, bounds where it has
 * them. */
static void describe_run(
    const gltf *g, json_text *text, const patch_accessor *accessor, const gltf_data *data) {
    norma_json_add_text(text, "{\"bufferView\":");
    norma_json_add_uint(text, accessor->view);
    norma_json_add_text(text, ",\"componentType\":");
    norma_json_add_uint(text, (uint64_t)data->component);
    norma_json_add_text(text, ",\"count\":");
    norma_json_add_uint(text, data->count);
    norma_json_add_text(text, ",\"type\":");
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
    add_same(g, text, like, "name");
    add_same(g, text, like, "extras");
    norma_json_add(text, "}", 2);
}

norma_document_result norma_gltf_append_accessors(gltf *g, norma_document_error *error) {
    uint32_t list = norma_json_member(&g->json, 0, "accessors");
    for (size_t i = 0; i < g->patch->accessor_count; ++i) {
        json_text text = {0};
        describe_run(
            g, &text, &g->patch->accessors[i], &g->patch->datas[g->patch->accessors[i].data]);
        if (!text.failed) norma_json_append(g->edits, list, text.data);
        free(text.data);
        if (text.failed) return norma_document_fail_memory(g->document, error);
    }
    return NORMA_DOCUMENT_OK;
}
