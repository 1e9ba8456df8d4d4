/* gltf_edit.c: triangles of glTF primitives reversed or left out, single normals, tangents and
 * positions replaced, normals taken away: as new contents of the slots that hold them. What is not
 * named keeps its bytes wherever its encoding stays. */
#include "io/gltf/gltf.h"
#include "io/format/format.h"
#include <stdlib.h>
#include <string.h>

typedef struct vector_edit {
    const char *attribute;
    bake_role role; /* decides how it is encoded */
    uint32_t width;
    const float *floats; /* one of the two */
    const double *doubles;
    const uint8_t *set;
} vector_edit;

static norma_document_result put_edit(gltf *g, uint32_t primitive, int32_t target,
    const char *attribute, const gltf_data *data, norma_document_error *error) {
    const gltf_slot slot = {.primitive = primitive, .target = target, .attribute = attribute};
    return norma_gltf_put_new(g, &slot, data, error);
}

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
    gltf_data data;
    unsigned char *copied;
    if (accessor == GLTF_NONE)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT,
            g->primitives[primitive].where, "has no %s that could be replaced", edit->attribute);
    if (g->accessors[accessor].width != edit->width ||
        g->accessors[accessor].count > g->primitives[primitive].vertices)
        return norma_gltf_malformed(
            g, error, g->accessors[accessor].token, "as many vectors as vertices");
    norma_document_result result =
        norma_gltf_copy_array(g, accessor, whole, &array, &copied, error);
    if (result) return result;
    double *values = norma_io_allocate(array.count + 1, edit->width * sizeof *values);
    bake_encoded encoded = BAKE_NO_MEMORY;
    if (values) {
        take_values(edit, &array, values);
        encoded = norma_gltf_encode(edit->role, &array, values, &data);
    }
    free(values);
    if (!encoded) keep_others(edit, &array, &data);
    free(copied);
    if (encoded == BAKE_TOO_LARGE)
        return norma_gltf_malformed(
            g, error, g->accessors[accessor].token, "numbers that floats can hold");
    return encoded ? norma_document_fail_memory(g->document, error)
                   : put_edit(g, primitive, GLTF_SLOT_BASE, edit->attribute, &data, error);
}

/* Tangents where there were none: of every vertex. */
static norma_document_result add_tangents(
    gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error) {
    const float *tangents = edit->tangents;
    gltf_data data = {.component = GLTF_FLOAT,
        .width = 4,
        .count = edit->source_vertices ? edit->vertex_count : g->primitives[primitive].vertices};
    data.bytes = norma_io_allocate(data.count, 16);
    if (!data.bytes) return norma_document_fail_memory(g->document, error);
    memcpy(data.bytes, tangents, data.count * 16);
    return put_edit(g, primitive, GLTF_SLOT_BASE, "TANGENT", &data, error);
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
    size_t size = norma_gltf_data_size(&data);
    data.bytes = norma_io_allocate(count, size);
    for (size_t i = 0; data.bytes && i < count; ++i)
        norma_gltf_write_index(data.bytes + i * size, data.component, kept[i]);
    free(kept);
    if (!data.bytes) return norma_document_fail_memory(g->document, error);
    if (p->mode != GLTF_TRIANGLES) norma_gltf_set_mode(g, 0, primitive, GLTF_TRIANGLES);
    return put_edit(g, primitive, GLTF_SLOT_INDICES, NULL, &data, error);
}

/* ---- a primitive */

/* The accessor stays in its list, since numbers never shift. */
static void strip(gltf *g, const gltf_attributes *attributes, const char *name) {
    norma_json_unset(g->edits, attributes->token, name);
}

/* Tangents mean nothing without normals, and go with them; those of targets also where the mesh has
 * none to add them to. */
static int strip_primitive(gltf *g, uint32_t primitive, int of_targets_alone) {
    const gltf_primitive *p = &g->primitives[primitive];
    int all_tangents = !of_targets_alone || p->base.tangent == GLTF_NONE;
    if (!of_targets_alone && p->base.normal != GLTF_NONE) strip(g, &p->base, "NORMAL");
    if (!of_targets_alone && p->base.tangent != GLTF_NONE) strip(g, &p->base, "TANGENT");
    for (uint32_t t = 0; t < p->target_count; ++t) {
        const gltf_attributes *target = &g->targets[p->first_target + t];
        if (target->normal != GLTF_NONE && (!of_targets_alone || p->base.normal == GLTF_NONE))
            strip(g, target, "NORMAL");
        if (target->tangent != GLTF_NONE && all_tangents) strip(g, target, "TANGENT");
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
    if (!result && edit->source_vertices)
        result = norma_gltf_put_vertices(g, primitive, edit, error);
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
