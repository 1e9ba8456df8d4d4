/* compressed.c: what is stored compressed: the bytes of a view, and primitives in
 * KHR_draco_mesh_compression. */
#include "io/gltf/gltf.h"
#include "io/gltf/draco_decoder.h"
#include <stdio.h>
#include <stdlib.h>

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

norma_document_result norma_gltf_measure_elements(
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

typedef struct claim {
    uint32_t accessor, id;
} claim;

/* The next attribute behind *at that the stream holds; 0: no more, or, with at->accessor GLTF_NONE,
 * a number that is none. */
static int next_claim(const gltf *g, const gltf_primitive *p, uint32_t *at, claim *next) {
    const uint32_t list = attribute_list(g, p);
    for (; *at < p->base.count; ++*at) {
        const gltf_attribute *attribute = &g->attributes[p->base.first + *at];
        const uint32_t token = norma_json_member(&g->json, list, attribute->name);
        uint64_t id;
        if (token == JSON_NONE) continue;
        const int ok = norma_json_uint(&g->json, token, &id) && id < INDICES;
        *next = (claim){ok ? attribute->accessor : GLTF_NONE, ok ? (uint32_t)id : 0};
        ++*at;
        return ok;
    }
    *next = (claim){0, 0};
    return 0;
}

/* Two primitives may share a stream and what is in it. */
static const char *why_not_claimed(const gltf *g, const gltf_primitive *p, claim wanted) {
    const gltf_accessor *a = &g->accessors[wanted.accessor];
    if (a->sparse.count) return "compressed with KHR_draco_mesh_compression and also sparse";
    if (a->draco != GLTF_NONE &&
        (g->primitives[a->draco].draco.view != p->draco.view || a->draco_id != wanted.id))
        return "compressed with KHR_draco_mesh_compression, but its accessors already belong to "
               "another stream";
    return NULL;
}

static void give(gltf *g, uint32_t primitive, claim wanted) {
    gltf_accessor *a = &g->accessors[wanted.accessor];
    if (a->draco != GLTF_NONE) return;
    a->draco = primitive;
    a->draco_id = wanted.id;
}

/* First whether all of them can be had, then they are. */
static norma_document_result claim_accessors(
    gltf *g, uint32_t number, const char **why, norma_document_error *error) {
    const gltf_primitive *p = &g->primitives[number];
    const claim indices = {p->indices, INDICES};
    claim wanted = {0, 0};
    uint32_t at = 0;
    *why = why_not_claimed(g, p, indices);
    while (!*why && next_claim(g, p, &at, &wanted)) *why = why_not_claimed(g, p, wanted);
    if (*why) return NORMA_DOCUMENT_OK;
    if (wanted.accessor == GLTF_NONE)
        return norma_gltf_malformed(
            g, error, attribute_list(g, p), "the numbers of attributes in the Draco stream");
    give(g, number, indices);
    for (at = 0; next_claim(g, p, &at, &wanted);) give(g, number, wanted);
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
    p->draco = (gltf_draco){
        norma_json_member(j, norma_json_member(j, p->token, "extensions"), GLTF_DRACO), GLTF_NONE};
    if (p->draco.token == GLTF_NONE || *why || (*why = why_stream_not_decoded(p)))
        return NORMA_DOCUMENT_OK;
    if (!norma_gltf_index_member(g, p->draco.token, "bufferView", g->view_count, &view) ||
        view == GLTF_NONE || !norma_json_is(j, attribute_list(g, p), JSON_OBJECT) ||
        norma_json_size(j, attribute_list(g, p)) > MOST_ATTRIBUTES)
        return norma_gltf_malformed(
            g, error, p->draco.token, "bufferView and attributes as the extension has them");
    const gltf_meshopt *m = &g->views[view].meshopt;
    if (g->buffers[m->token == GLTF_NONE ? g->views[view].buffer : m->buffer].storage ==
        GLTF_STORED_NOWHERE) {
        *why = "its buffer has no URI, so its bytes are not available";
        return NORMA_DOCUMENT_OK;
    }
    p->draco.view = view;
    norma_document_result result = claim_accessors(g, number, why, error);
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
                                : norma_gltf_measure_elements(g, &elements, &stride, error);
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
    }
    return result ? result : measure_stream(g, p, u, error);
}

static norma_document_result allocate_stream(gltf *g, unpacking *u, norma_document_error *error) {
    for (size_t i = 0; i < u->count; ++i) {
        const gltf_accessor *a = &g->accessors[u->accessors[i]];
        u->values[i].out = norma_io_allocate(a->count, a->element_size);
        if (!u->values[i].out) return norma_document_fail_memory(g->document, error);
    }
    return NORMA_DOCUMENT_OK;
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
        a->array = (gltf_array){.data = a->owned,
            .count = a->count,
            .stride = a->element_size,
            .component = a->component,
            .width = a->width,
            .normalized = a->normalized};
        a->resolved = 1;
    }
}

norma_document_result norma_gltf_decode_draco(
    gltf *g, uint32_t number, norma_document_error *error) {
    const gltf_primitive *p = &g->primitives[number];
    unpacking u = {.stream = {.points = p->vertices, .faces = p->faces}};
    size_t found = 0;
    norma_document_result result = norma_gltf_view_bytes(g, p->draco.view, &u.stream.bytes, error);
    u.stream.size = g->views[p->draco.view].length;
    if (!result && !gather_streams(g, number, &u))
        result = norma_document_fail_memory(g->document, error);
    if (!result) result = declare(g, p, &u, error);
    if (!result) result = allocate_stream(g, &u, error);
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
