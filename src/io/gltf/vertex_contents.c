/* vertex_contents.c: what the vertices of primitives hold, copied and replaced as new contents of
 * their slots: for sets of primitives that get normals, and for edits of single faces and vectors.
 * What is not named keeps its bytes wherever its encoding stays. */
#include "io/gltf/gltf.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Vertices of a glTF primitive as a list of copies of old ones: every attribute
 * and every target's, byte by byte; and which vertices are equal in all of them. */

/* ---- a vertex's bytes */

static size_t element_size_of(const gltf *g, uint32_t accessor) {
    return g->accessors[accessor].width *
           norma_gltf_component_size(g->accessors[accessor].component);
}

size_t norma_gltf_vertex_size(const gltf *g, const gltf_primitive *p) {
    size_t size = 0;
    for (uint32_t i = p->base.first; i < p->attribute_end; ++i)
        size += element_size_of(g, g->attributes[i].accessor);
    return size;
}

/* ---- copies */

static norma_document_result copy_attribute(gltf *g, uint32_t primitive, int32_t target,
    const gltf_attribute *attribute, const norma_mesh_edit *edit, norma_document_error *error) {
    gltf_data data;
    const gltf_slot slot = {.primitive = primitive, .target = target, .attribute = attribute->name};
    const norma_document_result result = norma_gltf_copy_rows(
        g, attribute->accessor, 0, edit->source_vertices, edit->vertex_count, &data, error);
    return result ? result : norma_gltf_put_new(g, &slot, &data, error);
}

/* Whether single numbers of it are replaced as well, by whom the copies are made then. */
static int is_set(const norma_mesh_edit *edit, const char *name) {
    return (edit->set_normals && strcmp(name, "NORMAL") == 0) ||
           (edit->set_tangents && strcmp(name, "TANGENT") == 0) ||
           (edit->set_positions && strcmp(name, "POSITION") == 0);
}

static norma_document_result copy_unknown_attributes(gltf *g, uint32_t primitive, int32_t target,
    const gltf_attributes *set, const norma_mesh_edit *edit, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = set->first; !result && i < set->first + set->count; ++i)
        if (target != GLTF_SLOT_BASE || !is_set(edit, g->attributes[i].name))
            result = copy_attribute(g, primitive, target, &g->attributes[i], edit, error);
    return result;
}

/* Extensions that say nothing of vertices by their number. */
static int names_no_vertices(const gltf *g, const gltf_primitive *p) {
    static const char *const harmless[] = {"KHR_materials_variants", "EXT_mesh_features", NULL};
    return !norma_gltf_extends_beyond(g, p->token, harmless);
}

/* Each old vertex keeps its number; further ones follow. */
static int keeps_numbers(const gltf_primitive *p, const norma_mesh_edit *edit) {
    for (size_t v = 0; v < p->vertices && v < edit->vertex_count; ++v)
        if (edit->source_vertices[v] != v) return 0;
    return edit->vertex_count >= p->vertices;
}

static norma_document_result gltf_put_vertices(
    gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error) {
    gltf_primitive *p = &g->primitives[primitive];
    const gltf_attributes *base = &p->base;
    if (!keeps_numbers(p, edit) && !names_no_vertices(g, p))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
            "cannot renumber vertices: an extension may refer to them");
    if (base->normal != GLTF_NONE && g->accessors[base->normal].count != p->vertices)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, p->where,
            "vertices without a normal, or normals without a vertex, cannot be copied");
    norma_document_result result =
        norma_gltf_copy_vertices(g, p, edit->vertex_count, norma_gltf_vertex_size(g, p), error);
    if (!result) result = copy_unknown_attributes(g, primitive, GLTF_SLOT_BASE, base, edit, error);
    for (uint32_t t = 0; !result && t < p->target_count; ++t)
        result = copy_unknown_attributes(
            g, primitive, (int32_t)t, &g->targets[p->first_target + t], edit, error);
    return result;
}

/* ---- equal ones */

typedef struct vertex_rows {
    unsigned char *bytes;
    size_t size;
} vertex_rows;

static const unsigned char *copied_row_of(const void *context, size_t row, size_t *length) {
    const vertex_rows *rows = context;
    *length = rows->size;
    return rows->bytes + row * rows->size;
}

static norma_document_result gather_rows(
    gltf *g, const gltf_primitive *p, vertex_rows *rows, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    size_t at = 0;
    for (uint32_t i = p->base.first; i < p->attribute_end && !result; ++i) {
        gltf_array array;
        const uint32_t accessor = g->attributes[i].accessor;
        const size_t size = element_size_of(g, accessor);
        result = norma_gltf_array(g, accessor, &array, error);
        for (size_t v = 0; v < p->vertices && v < array.count && !result; ++v)
            memcpy(rows->bytes + v * rows->size + at, array.data + v * array.stride, size);
        at += size;
    }
    return result;
}

norma_document_result norma_gltf_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    gltf_primitive *p = &g->primitives[mesh];
    vertex_rows rows = {.size = norma_gltf_vertex_size(g, p)};
    if (!names_no_vertices(g, p)) {
        for (size_t v = 0; v < p->vertices; ++v) first[v] = (uint32_t)v;
        return NORMA_DOCUMENT_OK;
    }
    norma_document_result result = norma_gltf_copy_vertices(
        g, p, p->vertices, rows.size, error); /* as much room as if it got them anew */
    if (result) return result;
    rows.bytes = norma_io_allocate(p->vertices, rows.size);
    if (!rows.bytes) return norma_document_fail_memory(document, error);
    result = gather_rows(g, p, &rows, error);
    if (!result && !norma_equal_rows(copied_row_of, &rows, p->vertices, first))
        result = norma_document_fail_memory(document, error);
    free(rows.bytes);
    return result;
}

/* ---- What becomes of the attributes that the primitives of a set share. */

size_t norma_gltf_add_vertex(gltf_set *set, uint32_t vertex) {
    const size_t number = set->vertices + set->added_count;
    uint32_t *added = number >= UINT32_MAX - 1 ? NULL
                                               : norma_io_grow(set->added, &set->added_capacity,
                                                     set->added_count + 1, sizeof *added);
    if (!added) return SIZE_MAX;
    set->added = added;
    set->added[set->added_count++] = vertex;
    return number;
}

norma_document_result norma_gltf_put_in_set(
    gltf_job *job, const gltf_set *set, int32_t target, const char *attribute, gltf_data *data) {
    gltf *g = job->g;
    uint32_t number = norma_gltf_add_data(g, data);
    int ok = number != GLTF_NONE;
    for (uint32_t i = set->lead; ok && i != GLTF_NONE; i = job->next_in_set[i]) {
        const gltf_slot slot = {.primitive = i, .target = target, .attribute = attribute};
        ok = norma_gltf_put(g, &slot, number);
    }
    return ok ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, job->error);
}

norma_document_result norma_gltf_copy_elements(
    gltf_job *job, const gltf_set *set, uint32_t accessor, gltf_data *data) {
    return norma_gltf_copy_rows(job->g, accessor, set->vertices, set->added,
        set->vertices + set->added_count, data, job->error);
}

/* ---- A set's new normals, and all else that its added vertices need, as contents of
 * its attributes: old elements keep their bits, added ones are copies, tangents of new normals are
 * made perpendicular to them. */

typedef struct contents {
    gltf_job *job;
    gltf_set *set;
    size_t count;  /* vertices as they will be */
    float *stored; /* the normals as readers will decode them, for tangents; NULL: there are none */
    uint8_t *changed; /* a vertex whose normal's code is not the old one's */
} contents;

static int is_new(const gltf_set *set, size_t vertex) {
    return vertex >= set->vertices || !set->broken || set->broken[vertex];
}

/* ---- vectors of three in the accessor's own encoding */

/* How new vectors are stored: as the accessor has them, where those are of a component type that
 * holds units, else as floats. */
static int vector_component(const gltf *g, uint32_t accessor, uint32_t width) {
    const gltf_accessor *a = accessor == GLTF_NONE ? NULL : &g->accessors[accessor];
    return a && a->width == width && norma_gltf_holds_units(a->component, a->normalized)
               ? a->component
               : GLTF_FLOAT;
}

static int encode_units(
    int component, const float *units, size_t count, unsigned char *out, size_t stride) {
    const norma_vec3_view view = {.data = units, .count = count, .format = NORMA_FORMAT_FLOAT};
    if (!norma_gltf_is_float(component))
        return norma_gltf_encode_units(component, view, out, stride);
    const size_t size = norma_gltf_component_size(component);
    for (size_t i = 0; i < 3 * count; ++i)
        norma_gltf_write_number(out + i / 3 * stride + i % 3 * size, component, (double)units[i]);
    return 1;
}

static void keep_float_zero_signs(const unsigned char *old, unsigned char *new_bytes) {
    for (int k = 0; k < 3; ++k) {
        float a, b;
        memcpy(&a, old + 4 * k, sizeof a);
        memcpy(&b, new_bytes + 4 * k, sizeof b);
        b = norma_policy_keep_zero(b, (double)a);
        memcpy(new_bytes + 4 * k, &b, sizeof b);
    }
}

/* What stays of an accessor's old elements goes back over the newly encoded ones; marks what is not
 * what it was. */
static norma_document_result merge_old(
    const contents *c, uint32_t accessor, int component, gltf_data *data) {
    gltf_array old;
    size_t size = norma_gltf_data_size(data);
    norma_document_result result = norma_gltf_array(c->job->g, accessor, &old, c->job->error);
    if (result) return result;
    int same = old.component == data->component && old.width == data->width &&
               old.normalized == data->normalized;
    for (size_t v = 0; v < c->count; ++v) {
        const unsigned char *before = old.data + norma_gltf_old_vertex(c->set, v) * old.stride;
        unsigned char *now = data->bytes + v * size;
        float element[16];
        if (!is_new(c->set, v) && same) {
            memcpy(now, before, size);
        } else if (!is_new(c->set, v) && old.width == 3) {
            norma_gltf_floats(&old, v, element);
            memcpy(now, element, 3 * sizeof *element);
        } else if (same && component == GLTF_FLOAT) {
            keep_float_zero_signs(before, now);
        }
        if (c->changed) c->changed[v] = !same || memcmp(now, before, size) != 0;
    }
    return NORMA_DOCUMENT_OK;
}

static void decode_stored(const contents *c, const gltf_data *data) {
    const gltf_array array = norma_gltf_array_of(data);
    for (size_t v = 0; v < c->count; ++v) norma_gltf_floats(&array, v, c->stored + 3 * v);
}

static gltf_data vector_data(int component, size_t count) {
    gltf_data data = {.component = component,
        .normalized = !norma_gltf_is_float(component),
        .width = 3,
        .count = count};
    data.bytes = norma_io_allocate(count, norma_gltf_data_size(&data));
    return data;
}

static norma_document_result put_normals(const contents *c) {
    uint32_t old = c->job->g->primitives[c->set->lead].base.normal;
    const int component = vector_component(c->job->g, old, 3);
    gltf_data data = {.component = GLTF_FLOAT, .width = 3, .count = c->count};
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (component == GLTF_FLOAT) { /* as they are */
        data.bytes = (unsigned char *)c->set->normals;
        c->set->normals = NULL;
    } else {
        data = vector_data(component, c->count);
        if (!data.bytes || !encode_units(component, c->set->normals, c->count, data.bytes,
                               norma_gltf_data_size(&data)))
            result = norma_gltf_job_memory(c->job);
    }
    if (old == GLTF_NONE)
        memset(c->changed, 1, c->count);
    else if (!result)
        result = merge_old(c, old, component, &data);
    if (result) {
        free(data.bytes);
        return result;
    }
    if (c->stored) decode_stored(c, &data);
    return norma_gltf_put_in_set(c->job, c->set, GLTF_SLOT_BASE, "NORMAL", &data);
}

/* ---- tangents */

/* Whether a tangent leans against the normal more than its code and rounding explain: right ones
 * keep their bits. */
static int leans(const float tangent[3], const float normal[3], int component) {
    double dot = 0, squares = 0;
    for (int k = 0; k < 3; ++k) {
        dot += (double)tangent[k] * (double)normal[k];
        squares += (double)tangent[k] * (double)tangent[k];
    }
    const double most = component == GLTF_BYTE ? .0137 : component == GLTF_HALF ? 1e-3 : 2e-4;
    return !(fabs(dot) <= most * sqrt(squares));
}

static norma_document_result turn_tangents(const contents *c, uint32_t accessor, gltf_data *data) {
    const int component = vector_component(c->job->g, accessor, 4);
    size_t size = norma_gltf_data_size(data);
    const gltf_array array = norma_gltf_array_of(data);
    float *tangents = norma_io_allocate(c->count, 4 * sizeof *tangents),
          *units = norma_io_allocate(c->count, 3 * sizeof *units);
    unsigned char *codes = norma_io_allocate(c->count, 3 * sizeof(double)),
                  *turned = norma_io_allocate(c->count, 1);
    int ok = tangents && units && codes && turned;
    for (size_t v = 0; ok && v < c->count; ++v) {
        norma_gltf_floats(&array, v, tangents + 4 * v);
        turned[v] = c->changed[v] ||
                    (is_new(c->set, v) && leans(tangents + 4 * v, c->stored + 3 * v, component));
    }
    const norma_vec3_view normals = {
        .data = c->stored, .count = c->count, .format = NORMA_FORMAT_FLOAT};
    ok = ok && !norma_orthogonalise_tangents(tangents, 0, normals, c->count, tangents, 0, c->count);
    for (size_t v = 0; ok && v < c->count; ++v)
        memcpy(units + 3 * v, tangents + 4 * v, 3 * sizeof *units);
    size_t code_size = 3 * norma_gltf_component_size(data->component);
    ok = ok && encode_units(component, units, c->count, codes, code_size);
    for (size_t v = 0; ok && v < c->count; ++v) {
        unsigned char *stored = data->bytes + v * size;
        const int stays = !turned[v] || memcmp(stored, codes + v * code_size, code_size) == 0;
        if (!stays) memcpy(stored, codes + v * code_size, code_size);
        ++*(stays ? &c->set->tangents_kept : &c->set->tangents_turned);
    }
    free(tangents);
    free(units);
    free(codes);
    free(turned);
    return ok ? NORMA_DOCUMENT_OK : norma_gltf_job_memory(c->job);
}

/* Tangents that are all zeros, for want of any bytes, are none. */
static int can_turn(const gltf_accessor *a) {
    if (a->view == GLTF_NONE && a->sparse.count == 0) return 0;
    return a->width == 4 && norma_gltf_holds_units(a->component, a->normalized);
}

static int is_tangent_turned(const contents *c, const gltf_attribute *attribute, int32_t target) {
    if (target != GLTF_SLOT_BASE || strcmp(attribute->name, "TANGENT") != 0) return 0;
    if (c->job->options->tangents != NORMA_STORED_TANGENTS_KEEP)
        return can_turn(&c->job->g->accessors[attribute->accessor]);
    c->set->tangents_kept = c->count;
    return 0;
}

static norma_document_result put_attribute(
    const contents *c, const gltf_attribute *attribute, int32_t target) {
    gltf_data data;
    const int tangent = is_tangent_turned(c, attribute, target);
    if (!tangent && c->set->added_count == 0) return NORMA_DOCUMENT_OK;
    norma_document_result result =
        norma_gltf_copy_elements(c->job, c->set, attribute->accessor, &data);
    if (!result && tangent && (result = turn_tangents(c, attribute->accessor, &data)))
        free(data.bytes);
    return result ? result : norma_gltf_put_in_set(c->job, c->set, target, attribute->name, &data);
}

/* ---- morph targets */

/* Up to half a code beyond the last one is still that, to the encoding's own rounding. */
static int fits_encoding(int component, const float *deltas, size_t count) {
    const double last = norma_gltf_largest_code(component);
    for (size_t i = 0; i < 3 * count; ++i) {
        const double delta = (double)deltas[i];
        if (!norma_gltf_is_float(component) && !(fabs(delta) * last < last + .5)) return 0;
        if (component == GLTF_HALF && !norma_gltf_fits_half(delta, 0)) return 0;
    }
    return 1;
}

/* Deltas are linear: each number by itself, nothing made unit. */
static void encode_deltas(int component, const float *deltas, size_t count, unsigned char *out) {
    const size_t size = norma_gltf_component_size(component);
    const double largest = norma_gltf_largest_code(component);
    for (size_t i = 0; i < 3 * count; ++i) {
        const double delta = (double)deltas[i];
        norma_gltf_write_number(out + i * size, component,
            norma_gltf_is_float(component) ? delta : nearbyint(delta * largest));
    }
}

norma_document_result norma_gltf_put_deltas(
    gltf_job *job, gltf_set *set, uint32_t target, const char *attribute, const float *deltas) {
    const contents c = {.job = job, .set = set, .count = set->vertices + set->added_count};
    const gltf *g = job->g;
    const gltf_attributes *of = &g->targets[g->primitives[set->lead].first_target + target];
    const uint32_t old = strcmp(attribute, "NORMAL") == 0 ? of->normal : of->tangent;
    int component = vector_component(g, old, 3);
    if (!fits_encoding(component, deltas, c.count)) component = GLTF_FLOAT;
    gltf_data data = vector_data(component, c.count);
    if (!data.bytes) return norma_gltf_job_memory(c.job);
    encode_deltas(component, deltas, c.count, data.bytes);
    norma_document_result result =
        old == GLTF_NONE ? NORMA_DOCUMENT_OK : merge_old(&c, old, component, &data);
    if (result) {
        free(data.bytes);
        return result;
    }
    return norma_gltf_put_in_set(job, set, (int32_t)target, attribute, &data);
}

/* ---- a set */

norma_document_result norma_gltf_put_set(gltf_job *job, uint32_t number) {
    gltf_set *set = &job->sets[number];
    const gltf *g = job->g;
    gltf_primitive *lead = &g->primitives[set->lead];
    contents c = {.job = job, .set = set, .count = set->vertices + set->added_count};
    const int tangents = lead->base.tangent != GLTF_NONE;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (set->added_count)
        result = norma_gltf_copy_vertices(
            job->g, lead, c.count, norma_gltf_vertex_size(g, lead), job->error);
    if (result) return result;
    c.stored = tangents ? norma_io_allocate(c.count, 3 * sizeof *c.stored) : NULL;
    c.changed = norma_io_allocate(c.count, 1);
    if ((!c.stored && tangents) || !c.changed) result = norma_gltf_job_memory(c.job);
    if (!result) {
        norma_policy_fill(
            &job->policy, set->normals, set->reasons, c.count, set->broken, set->vertices);
        norma_policy_report(&job->policy.summary->report, set->reasons, c.count, set->broken,
            set->vertices, job->set_count > 1);
        result = put_normals(&c);
    }
    for (int32_t t = GLTF_SLOT_BASE; !result && t < (int32_t)lead->target_count; ++t) {
        const gltf_attributes *of = norma_gltf_set_of(g, lead, t);
        const float *deltas = t >= 0 && set->deltas ? set->deltas[t] : NULL;
        for (uint32_t i = of->first; !result && i < of->first + of->count; ++i)
            if ((t >= 0 && !deltas) || strcmp(g->attributes[i].name, "NORMAL") != 0)
                result = put_attribute(&c, &g->attributes[i], t);
        if (!result && deltas)
            result = norma_gltf_put_deltas(job, set, (uint32_t)t, "NORMAL", deltas);
    }
    free(c.stored);
    free(c.changed);
    return result;
}

/* ---- Triangles of glTF primitives reversed or left out, single normals, tangents and
 * positions replaced, normals taken away: as new contents of the slots that hold them. What is not
 * named keeps its bytes wherever its encoding stays. */

typedef struct vector_edit {
    const char *attribute;
    bake_role role; /* decides how it is encoded */
    uint32_t width;
    const float *floats; /* one of the two */
    const double *doubles;
    const uint8_t *set;
} vector_edit;

/* ---- vectors */

static void take_values(const vector_edit *edit, const gltf_array *array, double *values) {
    for (size_t i = 0; i < array->count; ++i) {
        double element[16];
        norma_gltf_doubles(array, i, element);
        for (uint32_t k = 0; k < edit->width; ++k) {
            size_t at = i * edit->width + k;
            values[at] = !edit->set[i]  ? element[k]
                         : edit->floats ? (double)edit->floats[at]
                                        : edit->doubles[at];
        }
    }
}

/* What was not named is what it was, bit for bit. */
static void keep_others(const vector_edit *edit, const gltf_array *array, gltf_data *data) {
    size_t size = norma_gltf_data_size(data),
           used = data->width * norma_gltf_component_size(data->component);
    if (data->component != array->component || data->normalized != array->normalized ||
        data->width != array->width)
        return;
    for (size_t i = 0; i < data->count; ++i)
        if (!edit->set[i]) memcpy(data->bytes + i * size, array->data + i * array->stride, used);
}

static norma_document_result edit_vectors(gltf *g, uint32_t primitive, uint32_t accessor,
    const norma_mesh_edit *whole, const vector_edit *edit, norma_document_error *error) {
    gltf_array array;
    gltf_data data, copy = {0};
    const gltf_slot slot = {
        .primitive = primitive, .target = GLTF_SLOT_BASE, .attribute = edit->attribute};
    if (accessor == GLTF_NONE)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT,
            g->primitives[primitive].where, "has no %s that could be replaced", edit->attribute);
    if (g->accessors[accessor].width != edit->width ||
        g->accessors[accessor].count > g->primitives[primitive].vertices)
        return norma_gltf_malformed(
            g, error, g->accessors[accessor].token, "as many vectors as vertices");
    norma_document_result result = norma_gltf_array(g, accessor, &array, error);
    if (!result && whole->source_vertices) {
        result = norma_gltf_copy_rows(
            g, accessor, 0, whole->source_vertices, whole->vertex_count, &copy, error);
        array.data = copy.bytes;
        array.count = copy.count;
        array.stride = copy.element_size;
    }
    if (result) return result;
    double *values = norma_io_allocate(array.count + 1, edit->width * sizeof *values);
    bake_encoded encoded = BAKE_NO_MEMORY;
    if (values) {
        take_values(edit, &array, values);
        encoded = norma_gltf_encode(edit->role, &array, values, &data);
    }
    free(values);
    if (!encoded) keep_others(edit, &array, &data);
    free(copy.bytes);
    if (encoded == BAKE_TOO_LARGE)
        return norma_gltf_malformed(
            g, error, g->accessors[accessor].token, "numbers that floats can hold");
    return encoded ? norma_document_fail_memory(g->document, error)
                   : norma_gltf_put_new(g, &slot, &data, error);
}

/* Tangents where there were none: of every vertex. */
static norma_document_result add_tangents(
    gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error) {
    const gltf_slot slot = {
        .primitive = primitive, .target = GLTF_SLOT_BASE, .attribute = "TANGENT"};
    gltf_data data = {.component = GLTF_FLOAT,
        .width = 4,
        .count = edit->source_vertices ? edit->vertex_count : g->primitives[primitive].vertices};
    data.bytes = norma_io_allocate(data.count, 16);
    if (!data.bytes) return norma_document_fail_memory(g->document, error);
    memcpy(data.bytes, edit->tangents, data.count * 16);
    return norma_gltf_put_new(g, &slot, &data, error);
}

/* ---- faces */

static size_t edit_corners(
    const norma_mesh_edit *edit, const uint32_t *corners, size_t faces, uint32_t *out) {
    size_t count = 0;
    for (size_t face = 0; face < faces; ++face) {
        int reversed = norma_edit_says(edit->reverse_faces, face);
        if (norma_edit_says(edit->drop_faces, face)) continue;
        out[count++] = corners[3 * face];
        out[count++] = corners[3 * face + (reversed ? 2 : 1)];
        out[count++] = corners[3 * face + (reversed ? 1 : 2)];
    }
    return count;
}

/* A primitive without one triangle is not valid (an accessor has at least one element): it keeps
 * the last that was to go. One that never had any gets an index for its new vertices, which alone
 * draws nothing. */
static norma_document_result edit_primitive_faces(
    gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error) {
    const gltf_primitive *p = &g->primitives[primitive];
    const uint32_t *corners;
    norma_document_result result = norma_gltf_corners(g, primitive, &corners, error);
    if (result || (p->faces == 0 && !edit->source_vertices)) return result;
    uint32_t *kept = norma_io_allocate(p->faces ? p->faces : 1, 3 * sizeof *kept);
    if (!kept) return norma_document_fail_memory(g->document, error);
    if (edit->new_corners && edit->source_vertices) corners = edit->new_corners;
    size_t count = edit_corners(edit, corners, p->faces, kept);
    if (count == 0) {
        if (p->faces) memcpy(kept, corners + 3 * (p->faces - 1), 3 * sizeof *kept);
        count = p->faces ? 3 : 1;
    }
    gltf_data data = {.component = norma_gltf_index_component(g, p,
                          edit->source_vertices ? edit->vertex_count : p->vertices, GLTF_UBYTE),
        .width = 1,
        .count = count,
        .is_indices = 1};
    data.bytes = norma_gltf_encode_indices(data.component, kept, count);
    free(kept);
    if (!data.bytes) return norma_document_fail_memory(g->document, error);
    if (p->mode != GLTF_TRIANGLES) norma_gltf_set_mode(g, 0, primitive, GLTF_TRIANGLES);
    return norma_gltf_put_new(
        g, &(gltf_slot){.primitive = primitive, .target = GLTF_SLOT_INDICES}, &data, error);
}

/* ---- a primitive */

/* Tangents mean nothing without normals, and go with them; those of targets also where the mesh has
 * none to add them to. The accessor stays in its list, since numbers never shift. */
static int strip_primitive(gltf *g, uint32_t primitive, int of_targets_alone) {
    const gltf_primitive *p = &g->primitives[primitive];
    const int normals = !of_targets_alone || p->base.normal == GLTF_NONE,
              tangents = !of_targets_alone || p->base.tangent == GLTF_NONE;
    for (int32_t t = of_targets_alone ? 0 : GLTF_SLOT_BASE; t < (int32_t)p->target_count; ++t) {
        const gltf_attributes *set = norma_gltf_set_of(g, p, t);
        if (set->normal != GLTF_NONE && normals) norma_json_unset(g->edits, set->token, "NORMAL");
        if (set->tangent != GLTF_NONE && tangents)
            norma_json_unset(g->edits, set->token, "TANGENT");
    }
    return of_targets_alone || norma_gltf_strip(g, primitive);
}

/* What the caller was told nothing of, it has no marks for: primitives that are not read, and
 * normals without bytes, which are none where a document is read leniently. */
static norma_document_result check_told(
    const gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error) {
    const gltf_primitive *p = &g->primitives[primitive];
    if (p->not_read && (norma_edit_has_faces(edit) || edit->set_normals || edit->set_tangents ||
                           edit->set_positions))
        return norma_document_fail(
            g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, p->where, "%s", p->not_read);
    if (edit->set_normals && g->document->lenient && p->base.normal != GLTF_NONE &&
        norma_gltf_is_placeholder(g, p->base.normal))
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, p->where,
            "has no NORMAL that could be replaced");
    return NORMA_DOCUMENT_OK;
}

static norma_document_result edit_primitive(
    gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error) {
    const gltf_attributes *base = &g->primitives[primitive].base;
    const vector_edit normals = {"NORMAL", BAKE_NORMALS, 3, edit->normals, NULL, edit->set_normals};
    const vector_edit tangents = {
        "TANGENT", BAKE_TANGENTS, 4, edit->tangents, NULL, edit->set_tangents};
    const vector_edit positions = {
        "POSITION", BAKE_POSITIONS, 3, NULL, edit->positions, edit->set_positions};
    norma_document_result result = check_told(g, primitive, edit, error);
    if (!result && edit->source_vertices) result = gltf_put_vertices(g, primitive, edit, error);
    if (!result && edit->set_normals)
        result = edit_vectors(g, primitive, base->normal, edit, &normals, error);
    if (!result && edit->set_tangents)
        result = base->tangent == GLTF_NONE
                     ? add_tangents(g, primitive, edit, error)
                     : edit_vectors(g, primitive, base->tangent, edit, &tangents, error);
    if (!result && edit->set_positions)
        result = edit_vectors(g, primitive, base->position, edit, &positions, error);
    if (!result && norma_edit_has_faces(edit))
        result = edit_primitive_faces(g, primitive, edit, error);
    if (!result && edit->strip_normals &&
        !strip_primitive(g, primitive, edit->strip_normals == NORMA_STRIP_MORPHS))
        result = norma_document_fail_memory(g->document, error);
    return result;
}

static int is_asked(const norma_mesh_edit *edit) {
    return norma_edit_has_faces(edit) || edit->set_normals || edit->set_tangents ||
           edit->set_positions || edit->strip_normals;
}

norma_document_result norma_gltf_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_gltf_begin_change(g);
    for (uint32_t i = 0; !result && i < g->primitive_count; ++i)
        if (is_asked(&edits[i])) result = edit_primitive(g, i, &edits[i], error);
    return result ? result : norma_gltf_finish(g, error);
}
