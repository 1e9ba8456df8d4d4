/* accessors.c: elements of accessors: as they are stored (compressed by meshoptimizer or Draco
 * too), dense where they are sparse, as floats. */
#include "io/gltf/gltf.h"
#include <math.h>
#include "io/gltf/draco_decoder.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- The bytes of a view, as they are or decoded. */

const char *norma_gltf_extension_of(const gltf *g, const gltf_meshopt *m) {
    return norma_json_equals(&g->json, m->token - 1, "KHR_meshopt_compression")
               ? "KHR_meshopt_compression"
               : "EXT_meshopt_compression";
}

norma_document_result norma_gltf_view_bytes(
    gltf *g, uint32_t number, const unsigned char **bytes, norma_document_error *error) {
    gltf_view *view = &g->views[number];
    if (view->meshopt.token != GLTF_NONE) {
        norma_document_result result =
            view->decoded ? NORMA_DOCUMENT_OK : norma_gltf_decode_meshopt(g, number, error);
        *bytes = view->decoded;
        return result;
    }
    norma_document_result result = norma_gltf_load_buffer(g, view->buffer, error);
    if (result) return result;
    if (norma_gltf_view_overruns(g, number))
        return norma_gltf_malformed(g, error, view->token, "a view that ends inside its buffer");
    *bytes = g->buffers[view->buffer].bytes + view->offset;
    return NORMA_DOCUMENT_OK;
}

/* Elements of a view: count of them, each size bytes, from offset on. token: for messages. */
typedef struct gltf_elements {
    uint32_t token, view;
    size_t offset, count, size;
} gltf_elements;

/* Whether they are apart from one another and end inside the view; none of its bytes are read. */
static norma_document_result gltf_measure_elements(
    gltf *g, const gltf_elements *elements, size_t *stride, norma_document_error *error) {
    const gltf_view *view = &g->views[elements->view];
    const size_t offset = elements->offset, size = elements->size;
    *stride = view->stride ? view->stride : size;
    if (*stride < size) /* such elements share bytes, and none could be changed alone */
        return norma_gltf_malformed(
            g, error, elements->token, "elements no longer than their view's byteStride");
    if (offset > view->length || size > view->length - offset ||
        elements->count - 1 > (view->length - offset - size) / *stride)
        return norma_gltf_malformed(
            g, error, elements->token, "elements that end inside their view");
    return NORMA_DOCUMENT_OK;
}

/* ---- Primitives under KHR_draco_mesh_compression: their accessors have no view, or
 * one for readers without Draco; their elements come out of the stream (draco_decoder.h). A stream
 * that does not hold what the accessors declare is refused. */

/* They are looked for by their names, one after the other. */
enum { MOST_ATTRIBUTES = 1024 };

/* ---- which accessors */

static uint32_t attribute_list(const gltf *g, const gltf_primitive *p) {
    return norma_json_member(&g->json, p->draco.token, "attributes");
}

/* Which attribute of the stream an accessor gets; indices are none of them. */
enum { INDICES = INT32_MAX };

/* Why an accessor cannot be had for this attribute of the primitive's stream: two primitives may
 * share a stream and what is in it. gives: it can, and is given. */
static const char *claim_accessor(
    gltf *g, uint32_t primitive, uint32_t accessor, uint32_t id, int gives) {
    gltf_accessor *a = &g->accessors[accessor];
    if (gives && a->draco == GLTF_NONE) {
        a->draco = primitive;
        a->draco_id = id;
    }
    if (gives) return NULL;
    if (a->sparse.count) return "compressed with KHR_draco_mesh_compression and also sparse";
    if (a->draco != GLTF_NONE &&
        (g->primitives[a->draco].draco.view != g->primitives[primitive].draco.view ||
            a->draco_id != id))
        return "compressed with KHR_draco_mesh_compression, but its accessors already belong to "
               "another stream";
    return NULL;
}

/* First whether all of them can be had, then they are. */
static norma_document_result claim_accessors(
    gltf *g, uint32_t number, int gives, const char **why, norma_document_error *error) {
    const gltf_primitive *p = &g->primitives[number];
    const uint32_t list = attribute_list(g, p);
    *why = claim_accessor(g, number, p->indices, INDICES, gives);
    for (uint32_t i = p->base.first; !*why && i < p->base.first + p->base.count; ++i) {
        const uint32_t token = norma_json_member(&g->json, list, g->attributes[i].name),
                       id = norma_gltf_number(g, token, INDICES);
        if (token == JSON_NONE) continue;
        if (id == GLTF_NONE)
            return norma_gltf_malformed(
                g, error, list, "the numbers of attributes in the Draco stream");
        *why = claim_accessor(g, number, g->attributes[i].accessor, id, gives);
    }
    return NORMA_DOCUMENT_OK;
}

static const char *why_stream_not_decoded(const gltf_primitive *p) {
    if (!norma_draco_reads()) return norma_draco_missing(1);
    if (p->mode != GLTF_TRIANGLES)
        return p->mode == GLTF_STRIP
                   ? "compressed with KHR_draco_mesh_compression as a strip; such a stream holds "
                     "single triangles, and viewers disagree on what they mean as a strip"
                   : "compressed with KHR_draco_mesh_compression, which holds no fans";
    return p->indices == GLTF_NONE
               ? "compressed with KHR_draco_mesh_compression, but without indices"
               : NULL;
}

norma_document_result norma_gltf_read_draco(
    gltf *g, uint32_t number, const char **why, norma_document_error *error) {
    gltf_primitive *p = &g->primitives[number];
    const json *j = &g->json;
    uint32_t view = GLTF_NONE;
    p->draco = (gltf_draco){norma_gltf_extension(g, p->token, GLTF_DRACO), GLTF_NONE};
    if (p->draco.token == GLTF_NONE || *why || (*why = why_stream_not_decoded(p)))
        return NORMA_DOCUMENT_OK;
    if (!norma_gltf_index_member(g, p->draco.token, "bufferView", g->view_count, &view) ||
        view == GLTF_NONE || !norma_json_is(j, attribute_list(g, p), JSON_OBJECT) ||
        norma_json_size(j, attribute_list(g, p)) > MOST_ATTRIBUTES)
        return norma_gltf_malformed(
            g, error, p->draco.token, "bufferView and attributes as the extension has them");
    if (norma_gltf_has_no_bytes(g, view)) {
        *why = "its buffer has no URI, so its bytes are not available";
        return NORMA_DOCUMENT_OK;
    }
    p->draco.view = view;
    norma_document_result result = claim_accessors(g, number, 0, why, error);
    if (!result && !*why) result = claim_accessors(g, number, 1, why, error);
    if (*why) p->draco.view = GLTF_NONE;
    return result;
}

/* ---- their elements */

typedef struct unpacking {
    draco_stream stream;
    draco_values *values;
    uint32_t *accessors; /* of each of the values */
    size_t count;
} unpacking;

/* Those that this primitive's stream is to fill, the indices first. */
static int gather_streams(const gltf *g, uint32_t number, unpacking *u) {
    const gltf_primitive *p = &g->primitives[number];
    u->values = norma_io_allocate((size_t)p->base.count + 1, sizeof *u->values);
    u->accessors = norma_io_allocate((size_t)p->base.count + 1, sizeof *u->accessors);
    for (uint32_t i = 0; u->values && u->accessors && i <= p->base.count; ++i) {
        const uint32_t accessor = i ? g->attributes[p->base.first + i - 1].accessor : p->indices;
        const gltf_accessor *a = &g->accessors[accessor];
        size_t k = 0;
        while (k < u->count && u->accessors[k] != accessor) ++k;
        if (a->draco != number || k < u->count) continue;
        u->accessors[u->count] = accessor;
        u->values[u->count++] = (draco_values){a->draco_id, a->width, a->component, NULL};
    }
    return u->values && u->accessors;
}

static int is_index_type(const gltf_accessor *a) {
    return a->width == 1 &&
           (a->component == GLTF_UBYTE || a->component == GLTF_USHORT || a->component == GLTF_UINT);
}

static int is_not_of_draco(const gltf *g, const gltf_accessor *a) {
    return a->width > 4 || a->component > GLTF_FLOAT ||
           norma_json_equals(&g->json, norma_json_member(&g->json, a->token, "type"), "MAT2");
}

/* libdraco takes about a hundred bytes for a triangle while it decodes. A regular grid, of
 * positions in ten bits alone, has seven triangles in a byte and forty bytes of positions; other
 * meshes have far fewer. Attributes that nobody asks for are passed over, within measure. */
enum { FACES_A_BYTE = 8, BYTES_A_BYTE = 64, FREE_FACES = 1 << 12, FREE_BYTES = 1 << 16 };

static norma_document_result measure_stream(
    const gltf *g, const gltf_primitive *p, unpacking *u, norma_document_error *error) {
    const size_t size = u->stream.size;
    size_t sum = 0;
    for (size_t i = 0; i < u->count; ++i) {
        const gltf_accessor *a = &g->accessors[u->accessors[i]];
        if (a->draco_id != INDICES) sum += a->count * a->element_size;
    }
    u->stream.most = 2 * sum + FREE_BYTES;
    if ((p->faces < FREE_FACES || (p->faces - FREE_FACES) / FACES_A_BYTE < size) &&
        (sum < FREE_BYTES || (sum - FREE_BYTES) / BYTES_A_BYTE < size))
        return NORMA_DOCUMENT_OK;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, p->where,
        "%zu triangles and %zu bytes of attributes are far more than a Draco stream of %zu bytes "
        "can hold; at most %d triangles and %d bytes are read for each byte",
        p->faces, sum, size, FACES_A_BYTE, BYTES_A_BYTE);
}

/* The view that an accessor has for readers without Draco: it is not read, but written into. */
static norma_document_result measure_fallback(
    gltf *g, const gltf_accessor *a, norma_document_error *error) {
    const gltf_elements elements = {a->token, a->view, a->offset, a->count, a->element_size};
    size_t stride;
    return a->view == GLTF_NONE ? NORMA_DOCUMENT_OK
                                : gltf_measure_elements(g, &elements, &stride, error);
}

/* What the accessors declare, all of it sound and measured before anything is decoded. */
static norma_document_result declare(
    gltf *g, const gltf_primitive *p, unpacking *u, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; !result && i < u->count; ++i) {
        const gltf_accessor *a = &g->accessors[u->accessors[i]];
        const int indices = a->draco_id == INDICES;
        if (indices ? !is_index_type(a) : is_not_of_draco(g, a))
            return norma_gltf_malformed(
                g, error, a->token, "a type that the Draco stream can hold");
        if (a->count != (indices ? 3 * p->faces : p->vertices))
            return norma_gltf_malformed(g, error, a->token,
                indices ? "a count that is a multiple of 3, three for each triangle of the stream"
                        : "a count equal to that of the primitive's POSITION");
        result = measure_fallback(g, a, error);
        if (!result) result = norma_gltf_spend(g, a->token, a->count, a->element_size, error);
        if (!result && !(u->values[i].out = norma_io_allocate(a->count, a->element_size)))
            result = norma_document_fail_memory(g->document, error);
    }
    return result ? result : measure_stream(g, p, u, error);
}

static const char *attribute_name(const gltf *g, const gltf_primitive *p, uint32_t accessor) {
    for (uint32_t i = 0; i < p->base.count; ++i)
        if (g->attributes[p->base.first + i].accessor == accessor)
            return g->attributes[p->base.first + i].name;
    return "indices";
}

/* found: by norma_draco_decode, of the attributes that it was handed. */
static norma_document_result fail_stream(const gltf *g, const gltf_primitive *p, const unpacking *u,
    draco_result wrong, size_t found, norma_document_error *error) {
    char text[240] = "is damaged or cut short; expected a stream that libdraco decodes";
    const size_t at = found == SIZE_MAX ? 0 : found + (u->stream.indices ? 1 : 0);
    const char *which = wrong >= DRACO_ATTRIBUTE ? attribute_name(g, p, u->accessors[at]) : "";
    if (wrong == DRACO_KIND)
        snprintf(text, sizeof text, "is not one of a mesh; expected a mesh, bitstream version 2.2");
    if (wrong == DRACO_FACES)
        snprintf(text, sizeof text,
            "declares %zu triangles; expected %zu, as the accessor of the indices does", found,
            p->faces);
    if (wrong == DRACO_POINTS)
        snprintf(text, sizeof text,
            "declares %zu vertices; expected %zu, as the accessor of POSITION does", found,
            p->vertices);
    if (wrong == DRACO_LARGE)
        snprintf(text, sizeof text,
            "would take %zu bytes for its attributes; expected at most %zu, by the accessors",
            found, u->stream.most);
    if (wrong == DRACO_ATTRIBUTE)
        snprintf(text, sizeof text, "has no attribute %u, which should be %.64s",
            (unsigned)u->values[at].id, which);
    if (wrong == DRACO_WIDTH)
        snprintf(text, sizeof text, "has %.64s with another number of components; expected %u",
            which, (unsigned)u->values[at].width);
    if (wrong == DRACO_VALUE)
        snprintf(text, sizeof text,
            "has values of %.64s that the accessor's componentType cannot hold", which);
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, p->where,
        "the Draco stream of %zu bytes (bufferView %u) %s", u->stream.size, (unsigned)p->draco.view,
        text);
}

static void take_elements(gltf *g, unpacking *u) {
    for (size_t i = 0; i < u->count; ++i) {
        gltf_accessor *a = &g->accessors[u->accessors[i]];
        free(a->owned);
        a->owned = u->values[i].out;
        u->values[i].out = NULL;
        a->array.data = a->owned;
        a->array.stride = a->element_size;
        a->resolved = 1;
    }
}

/* resolves those accessors */
static norma_document_result gltf_decode_draco(
    gltf *g, uint32_t number, norma_document_error *error) {
    const gltf_primitive *p = &g->primitives[number];
    unpacking u = {.stream = {.points = p->vertices, .faces = p->faces}};
    size_t found = 0;
    norma_document_result result = norma_gltf_view_bytes(g, p->draco.view, &u.stream.bytes, error);
    u.stream.size = g->views[p->draco.view].length;
    if (!result && !gather_streams(g, number, &u))
        result = norma_document_fail_memory(g->document, error);
    if (!result) result = declare(g, p, &u, error);
    if (!result) {
        const size_t skipped = g->accessors[u.accessors[0]].draco_id == INDICES;
        u.stream.indices = skipped ? u.values : NULL;
        u.stream.attributes = u.values + skipped;
        u.stream.attribute_count = u.count - skipped;
        const draco_result wrong = norma_draco_decode(&u.stream, &found);
        if (wrong == DRACO_OK)
            take_elements(g, &u);
        else
            result = wrong == DRACO_MEMORY ? norma_document_fail_memory(g->document, error)
                                           : fail_stream(g, p, &u, wrong, found, error);
    }
    for (size_t i = 0; i < u.count; ++i) free(u.values[i].out);
    free(u.values);
    free(u.accessors);
    return result;
}

/* ---- Accessors: what the JSON says, and their elements, wherever they lie: in a view with
 * any stride, sparse over a view or over zeros. */

static const struct {
    const char *name;
    uint32_t width;
} ELEMENT_TYPES[] = {
    {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
enum { TYPE_COUNT = sizeof ELEMENT_TYPES / sizeof ELEMENT_TYPES[0], TYPE_MAT2 = 4 };

/* What is known of a component type: its bytes, what a normalised code of it is divided by, what
 * the core and people call it. */
typedef struct component_type {
    size_t size;
    double largest;
    norma_format format;
    const char *name;
} component_type;

static const component_type *component_type_of(int component) {
    static const component_type
        unknown = {0, 1, NORMA_FORMAT_FLOAT, "float"},
        types[] = {[GLTF_BYTE - GLTF_BYTE] = {1, 127, NORMA_FORMAT_INT8, "snorm8"},
            [GLTF_UBYTE - GLTF_BYTE] = {1, 255, NORMA_FORMAT_UINT8, "unorm8"},
            [GLTF_SHORT - GLTF_BYTE] = {2, 32767, NORMA_FORMAT_INT16, "snorm16"},
            [GLTF_USHORT - GLTF_BYTE] = {2, 65535, NORMA_FORMAT_UINT16, "unorm16"},
            [GLTF_UINT - GLTF_BYTE] = {4, 1, NORMA_FORMAT_FLOAT, "float"},
            [GLTF_FLOAT - GLTF_BYTE] = {4, 1, NORMA_FORMAT_FLOAT, "float"},
            [GLTF_DOUBLE - GLTF_BYTE] = {8, 1, NORMA_FORMAT_DOUBLE, "double"},
            [GLTF_HALF - GLTF_BYTE] = {2, 1, NORMA_FORMAT_FLOAT, "float16"}};
    return component < GLTF_BYTE || component > GLTF_HALF || !types[component - GLTF_BYTE].size
               ? &unknown
               : &types[component - GLTF_BYTE];
}

size_t norma_gltf_component_size(int component) { return component_type_of(component)->size; }

double norma_gltf_largest_code(int component) { return component_type_of(component)->largest; }

const char *norma_gltf_encoding_name(const gltf *g, uint32_t accessor) {
    return accessor == GLTF_NONE ? "" : component_type_of(g->accessors[accessor].component)->name;
}

int norma_gltf_index_component(
    const gltf *g, const gltf_primitive *p, size_t vertices, int without) {
    int component = p->indices == GLTF_NONE ? without : g->accessors[p->indices].component;
    if (component == GLTF_UBYTE && vertices > UINT8_MAX) component = GLTF_USHORT;
    if (component == GLTF_USHORT && vertices > UINT16_MAX) component = GLTF_UINT;
    return component;
}

static void write_index(unsigned char *at, int component, uint32_t value) {
    const size_t size = norma_gltf_component_size(component);
    for (size_t i = 0; i < size; ++i) at[i] = (unsigned char)(value >> 8 * i);
}

unsigned char *norma_gltf_encode_indices(int component, const uint32_t *indices, size_t count) {
    const size_t size = norma_gltf_component_size(component);
    unsigned char *bytes = norma_io_block(count, size);
    for (size_t i = 0; bytes && i < count; ++i)
        write_index(bytes + i * size, component, indices[i]);
    return bytes;
}

/* Columns of small matrices begin at multiples of four bytes (glTF 2.0, 3.6.2.4). */
static size_t element_size(size_t type, size_t component_size) {
    size_t width = ELEMENT_TYPES[type].width;
    if (type < TYPE_MAT2) return width * component_size;
    size_t rows = type == TYPE_MAT2 ? 2 : type == TYPE_MAT2 + 1 ? 3 : 4;
    return rows * ((rows * component_size + 3) / 4 * 4);
}

static norma_document_result read_sparse(
    gltf *g, gltf_accessor *a, uint32_t sparse, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t indices = norma_json_member(j, sparse, "indices"),
             values = norma_json_member(j, sparse, "values");
    size_t component = 0;
    a->sparse.indices_view = a->sparse.values_view = GLTF_NONE;
    int ok =
        norma_gltf_size_member(g, sparse, "count", &a->sparse.count) &&
        norma_gltf_index_member(g, indices, "bufferView", g->view_count, &a->sparse.indices_view) &&
        norma_gltf_size_member(g, indices, "byteOffset", &a->sparse.indices_offset) &&
        norma_gltf_size_member(g, indices, "componentType", &component) &&
        norma_gltf_index_member(g, values, "bufferView", g->view_count, &a->sparse.values_view) &&
        norma_gltf_size_member(g, values, "byteOffset", &a->sparse.values_offset);
    ok = ok && a->sparse.count > 0 && a->sparse.count <= a->count &&
         a->sparse.indices_view != GLTF_NONE && a->sparse.values_view != GLTF_NONE &&
         (component == GLTF_UBYTE || component == GLTF_USHORT || component == GLTF_UINT);
    a->sparse.indices_component = (int)component;
    return ok ? NORMA_DOCUMENT_OK
              : norma_gltf_malformed(g, error, sparse,
                    "a count from 1 to the accessor's, and indices and values with views that "
                    "exist");
}

/* Half and double floats come with an extension that the file names, or with glTF 2.1. */
static int has_more_floats(const gltf *g, int component) {
    const json *j = &g->json;
    const char *name = component == GLTF_HALF ? "KHR_accessor_float16" : "KHR_accessor_float64";
    return norma_gltf_lists(g, "extensionsRequired", name) ||
           norma_gltf_lists(g, "extensionsUsed", name) ||
           !norma_json_equals(
               j, norma_json_member(j, norma_json_member(j, 0, "asset"), "version"), "2.0");
}

static norma_document_result read_accessor(gltf *g, gltf_accessor *a, norma_document_error *error) {
    const json *j = &g->json;
    size_t component = 0;
    uint32_t type = norma_json_member(j, a->token, "type"),
             sparse = norma_json_member(j, a->token, "sparse");
    a->view = a->draco = GLTF_NONE;
    if (!norma_gltf_index_member(g, a->token, "bufferView", g->view_count, &a->view))
        return norma_gltf_malformed(
            g, error, a->token, "the number of an existing view in \"bufferView\"");
    if (!norma_gltf_size_member(g, a->token, "byteOffset", &a->offset) ||
        !norma_gltf_size_member(g, a->token, "count", &a->count) || a->count == 0 ||
        !norma_gltf_size_member(g, a->token, "componentType", &component))
        return norma_gltf_malformed(g, error, a->token,
            "a count from 1, and byteOffset and componentType as whole numbers");
    size_t t = 0;
    while (t < TYPE_COUNT && !norma_json_equals(j, type, ELEMENT_TYPES[t].name)) ++t;
    size_t size = component > GLTF_HALF ? 0 : norma_gltf_component_size((int)component);
    if (t == TYPE_COUNT || size == 0)
        return norma_gltf_malformed(g, error, a->token, "a componentType and type that glTF has");
    a->component = (int)component;
    a->width = ELEMENT_TYPES[t].width;
    a->element_size = element_size(t, size);
    a->normalized = norma_json_is(j, norma_json_member(j, a->token, "normalized"), JSON_TRUE);
    if (component > GLTF_FLOAT && (a->normalized || !has_more_floats(g, (int)component)))
        return norma_gltf_malformed(g, error, a->token,
            component == GLTF_HALF
                ? "componentType 5131 only with KHR_accessor_float16, and not normalized"
                : "componentType 5130 only with KHR_accessor_float64, and not normalized");
    if (size > g->alignment) g->alignment = size;
    a->array = (gltf_array){.count = a->count,
        .component = a->component,
        .width = a->width,
        .normalized = a->normalized};
    return sparse == JSON_NONE ? NORMA_DOCUMENT_OK : read_sparse(g, a, sparse, error);
}

norma_document_result norma_gltf_read_accessors(gltf *g, norma_document_error *error) {
    uint32_t list, number = 0;
    norma_document_result result =
        norma_gltf_read_list(g, "accessors", &list, &g->accessor_count, error);
    g->alignment = 4;
    if (result) return result;
    g->accessors = norma_io_allocate(g->accessor_count, sizeof *g->accessors);
    if (!g->accessors) return norma_document_fail_memory(g->document, error);
    for (uint32_t item = JSON_NONE; !result && norma_json_each(&g->json, list, &item); ++number) {
        g->accessors[number].token = item;
        result = read_accessor(g, &g->accessors[number], error);
    }
    return result;
}

/* ---- elements */

static norma_document_result locate_elements(gltf *g, const gltf_elements *elements, size_t *stride,
    const unsigned char **data, norma_document_error *error) {
    norma_document_result result = norma_gltf_view_bytes(g, elements->view, data, error);
    if (!result) result = gltf_measure_elements(g, elements, stride, error);
    if (!result) *data += elements->offset;
    return result;
}

norma_document_result norma_gltf_sparse_indices(
    gltf *g, uint32_t accessor, uint32_t *out, norma_document_error *error) {
    const gltf_accessor *a = &g->accessors[accessor];
    const unsigned char *indices;
    size_t stride, size = norma_gltf_component_size(a->sparse.indices_component);
    norma_document_result result = locate_elements(g,
        &(gltf_elements){
            a->token, a->sparse.indices_view, a->sparse.indices_offset, a->sparse.count, size},
        &stride, &indices, error);
    for (size_t i = 0; !result && i < a->sparse.count; ++i) {
        out[i] = norma_gltf_read_uint(indices + i * stride, a->sparse.indices_component);
        if (out[i] >= a->count)
            result = norma_gltf_malformed(g, error, a->token, "sparse indices below count");
    }
    return result;
}

static norma_document_result apply_sparse(gltf *g, gltf_accessor *a, norma_document_error *error) {
    const unsigned char *values;
    size_t stride;
    norma_document_result result = locate_elements(g,
        &(gltf_elements){a->token, a->sparse.values_view, a->sparse.values_offset, a->sparse.count,
            a->element_size},
        &stride, &values, error);
    uint32_t *indices = result ? NULL : norma_io_allocate(a->sparse.count, sizeof *indices);
    if (!result)
        result = indices
                     ? norma_gltf_sparse_indices(g, (uint32_t)(a - g->accessors), indices, error)
                     : norma_document_fail_memory(g->document, error);
    for (size_t i = 0; !result && i < a->sparse.count; ++i)
        memcpy(a->owned + indices[i] * a->element_size, values + i * stride, a->element_size);
    free(indices);
    return result;
}

static norma_document_result make_dense(gltf *g, gltf_accessor *a, norma_document_error *error) {
    if (a->view == GLTF_NONE && a->count > g->held)
        return norma_gltf_malformed(
            g, error, a->token, "a count that is plausible for the size of the file");
    norma_document_result result = norma_gltf_spend(g, a->token, a->count, a->element_size, error);
    if (result) return result;
    unsigned char *owned = norma_io_allocate(a->count, a->element_size);
    if (!owned) return norma_document_fail_memory(g->document, error);
    if (a->view != GLTF_NONE)
        for (size_t i = 0; i < a->count; ++i)
            memcpy(
                owned + i * a->element_size, a->array.data + i * a->array.stride, a->element_size);
    a->owned = owned;
    a->array.data = owned;
    a->array.stride = a->element_size;
    return a->sparse.count ? apply_sparse(g, a, error) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_array(
    gltf *g, uint32_t number, gltf_array *array, norma_document_error *error) {
    gltf_accessor *a = &g->accessors[number];
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!a->resolved && a->draco != GLTF_NONE) {
        result = gltf_decode_draco(g, a->draco, error);
    } else if (!a->resolved) {
        free(a->owned);
        a->owned = NULL;
        if (a->view != GLTF_NONE)
            result = locate_elements(g,
                &(gltf_elements){a->token, a->view, a->offset, a->count, a->element_size},
                &a->array.stride, &a->array.data, error);
        if (!result && (a->view == GLTF_NONE || a->sparse.count)) result = make_dense(g, a, error);
        a->resolved = !result;
    }
    *array = a->array;
    return result;
}

norma_document_result norma_gltf_copy_rows(gltf *g, uint32_t accessor, size_t kept,
    const uint32_t *sources, size_t count, gltf_data *data, norma_document_error *error) {
    gltf_array array;
    const size_t size = g->accessors[accessor].element_size;
    norma_document_result result = norma_gltf_array(g, accessor, &array, error);
    if (result) return result;
    *data = (gltf_data){.component = array.component,
        .normalized = array.normalized,
        .width = array.width,
        .element_size = size,
        .count = count,
        .bytes = norma_io_block(count, size)};
    if (!data->bytes) return norma_document_fail_memory(g->document, error);
    if (array.stride == size) memcpy(data->bytes, array.data, kept * size);
    for (size_t v = array.stride == size ? kept : 0; v < count; ++v)
        memcpy(data->bytes + v * size,
            array.data + (v < kept ? v : sources[v - kept]) * array.stride, size);
    return NORMA_DOCUMENT_OK;
}

static double half_at(const unsigned char *at) {
    const uint32_t bits = norma_gltf_read_uint(at, GLTF_USHORT), exponent = bits >> 10 & 31,
                   fraction = bits & 1023;
    const double size = exponent == 0    ? ldexp(fraction, -24)
                        : exponent == 31 ? (fraction ? (double)NAN : (double)INFINITY)
                                         : ldexp(1024 + fraction, (int)exponent - 25);
    return bits >> 15 ? -size : size;
}

/* IEEE 754's binary16 by rounding to nearest, ties to even; a carry goes into the exponent. */
static uint32_t half_bits(double number) {
    const uint32_t sign = signbit(number) ? 0x8000 : 0;
    const double size = fabs(number);
    int exponent;
    if (isnan(number)) return sign | 0x7e00;
    if (size >= 65520) return sign | 0x7c00;
    if (size < 0x1p-14) return sign | (uint32_t)nearbyint(size * 0x1p24);
    const double fraction = nearbyint(frexp(size, &exponent) * 2048);
    return sign | (((uint32_t)(exponent + 14) << 10) + ((uint32_t)fraction - 1024));
}

int norma_gltf_fits_half(double number, int exactly) {
    unsigned char code[2];
    norma_gltf_write_number(code, GLTF_HALF, number);
    return exactly ? half_at(code) == number || isnan(number) : fabs(number) < 65520;
}

static double component_at(const unsigned char *at, int component) {
    float single;
    double number;
    int32_t code;
    switch (component) {
    case GLTF_BYTE:
        return at[0] < 128 ? at[0] : at[0] - 256;
    case GLTF_UBYTE:
        return at[0];
    case GLTF_SHORT:
        code = (int32_t)norma_gltf_read_uint(at, GLTF_USHORT);
        return code < 32768 ? code : code - 65536;
    case GLTF_USHORT:
        return norma_gltf_read_uint(at, GLTF_USHORT);
    case GLTF_FLOAT:
        memcpy(&single, at, sizeof single);
        return (double)single;
    case GLTF_DOUBLE:
        memcpy(&number, at, sizeof number);
        return number;
    case GLTF_HALF:
        return half_at(at);
    default:
        return norma_gltf_read_uint(at, GLTF_UINT);
    }
}

void norma_gltf_write_number(unsigned char *at, int component, double number) {
    const float single = (float)number;
    if (component == GLTF_FLOAT)
        memcpy(at, &single, sizeof single);
    else if (component == GLTF_DOUBLE)
        memcpy(at, &number, sizeof number);
    else
        write_index(at, component == GLTF_HALF ? GLTF_USHORT : component,
            component == GLTF_HALF ? half_bits(number) : (uint32_t)(int32_t)number);
}

void norma_gltf_doubles(const gltf_array *array, size_t index, double *out) {
    const unsigned char *at = array->data + index * array->stride;
    const size_t size = norma_gltf_component_size(array->component);
    const double by = array->normalized ? norma_gltf_largest_code(array->component) : 1;
    for (uint32_t i = 0; i < array->width; ++i, at += size) {
        out[i] = component_at(at, array->component) / by;
        if (by > 1 && out[i] < -1) out[i] = -1; /* -128 / 127 */
    }
}

void norma_gltf_floats(const gltf_array *array, size_t index, float *out) {
    double numbers[16];
    if (array->component == GLTF_FLOAT) {
        memcpy(out, array->data + index * array->stride, array->width * sizeof *out);
        return;
    }
    norma_gltf_doubles(array, index, numbers);
    for (uint32_t i = 0; i < array->width; ++i) out[i] = (float)numbers[i];
}

void norma_gltf_uints(const gltf_array *array, size_t index, uint32_t *out) {
    size_t size = norma_gltf_component_size(array->component);
    for (uint32_t i = 0; i < array->width; ++i)
        out[i] =
            norma_gltf_read_uint(array->data + index * array->stride + i * size, array->component);
}

norma_vec3_view norma_gltf_vec3_view(const gltf_array *array) {
    return (norma_vec3_view){.data = array->data,
        .count = array->count,
        .stride = array->stride,
        .format = component_type_of(array->component)->format};
}

/* ---- Accessors as floats, decoded once. */

static int is_plain_array(const gltf_array *array, uint32_t width) {
    return array->component == GLTF_FLOAT && array->stride == width * sizeof(float) &&
           (uintptr_t)array->data % sizeof(float) == 0;
}

norma_document_result norma_gltf_widen(gltf *g, uint32_t accessor, const gltf_array *array,
    uint32_t width, const float **floats, norma_document_error *error) {
    if (*floats) return NORMA_DOCUMENT_OK;
    const norma_document_result result = norma_gltf_spend(
        g, g->accessors[accessor].token, array->count, width * sizeof(float), error);
    float *copy =
        result ? NULL
               : norma_scene_allocate(g->document->scene, array->count, width * sizeof *copy);
    if (!copy) return result ? result : norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < array->count; ++i) {
        norma_gltf_floats(array, i, copy + width * i);
        if (width > array->width) copy[width * i + array->width] = 1;
    }
    *floats = copy;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_decode(
    gltf *g, uint32_t accessor, uint32_t width, const float **floats, norma_document_error *error) {
    gltf_array array;
    gltf_scene *scene = norma_gltf_scene_of(g);
    *floats = NULL;
    if (!scene) return norma_document_fail_memory(g->document, error);
    norma_document_result result = norma_gltf_array(g, accessor, &array, error);
    if (result) return result;
    if (array.width != width)
        return norma_gltf_malformed(g, error, g->accessors[accessor].token,
            width == 2   ? "pairs of numbers"
            : width == 3 ? "vectors of three numbers"
                         : "vectors of four numbers");
    if (is_plain_array(&array, width)) {
        *floats = (const float *)(const void *)array.data;
        return NORMA_DOCUMENT_OK;
    }
    result = norma_gltf_widen(g, accessor, &array, width, &scene->decoded[accessor], error);
    *floats = scene->decoded[accessor];
    return result;
}

norma_document_result norma_gltf_position_view(
    gltf *g, uint32_t accessor, norma_vec3_view *view, norma_document_error *error) {
    gltf_array array;
    const float *floats;
    norma_document_result result = norma_gltf_array(g, accessor, &array, error);
    if (!result && array.component == GLTF_HALF) {
        result = norma_gltf_decode(g, accessor, 3, &floats, error);
        array = (gltf_array){.data = (const unsigned char *)floats,
            .count = array.count,
            .stride = 3 * sizeof *floats,
            .component = GLTF_FLOAT,
            .width = 3};
    }
    if (!result) *view = norma_gltf_vec3_view(&array);
    return result;
}

int norma_gltf_is_placeholder(const gltf *g, uint32_t accessor) {
    const gltf_accessor *a = &g->accessors[accessor];
    return a->view == GLTF_NONE && a->sparse.count == 0 && a->draco == GLTF_NONE;
}
