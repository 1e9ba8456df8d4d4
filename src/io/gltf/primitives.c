/* primitives.c: meshes and their primitives: which accessors they use, how many triangles they
 * draw, and the corners of those. */
#include "io/gltf/gltf.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct counts {
    uint32_t primitives, targets, attributes;
} counts;

/* How much there is, so that everything is allocated once. Types are checked here, once for both
 * passes. */
static norma_document_result count_primitive(
    const gltf *g, uint32_t primitive, counts *n, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t attributes = norma_json_member(j, primitive, "attributes"),
             targets = norma_json_member(j, primitive, "targets");
    if (!norma_json_is(j, primitive, JSON_OBJECT) || !norma_json_is(j, attributes, JSON_OBJECT))
        return norma_gltf_malformed(
            g, error, primitive, "a primitive with an object \"attributes\"");
    if (targets != JSON_NONE && !norma_json_is(j, targets, JSON_ARRAY))
        return norma_gltf_malformed(g, error, targets, "an array");
    ++n->primitives;
    n->attributes += norma_json_size(j, attributes);
    for (uint32_t target = JSON_NONE; norma_json_each(j, targets, &target);) {
        if (!norma_json_is(j, target, JSON_OBJECT))
            return norma_gltf_malformed(g, error, target, "an object");
        ++n->targets;
        n->attributes += norma_json_size(j, target);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result count_all(
    gltf *g, uint32_t meshes, counts *n, norma_document_error *error) {
    const json *j = &g->json;
    if (meshes != JSON_NONE && !norma_json_is(j, meshes, JSON_ARRAY))
        return norma_gltf_malformed(g, error, meshes, "an array");
    for (uint32_t mesh = JSON_NONE; norma_json_each(j, meshes, &mesh);) {
        uint32_t primitives = norma_json_member(j, mesh, "primitives");
        if (!norma_json_is(j, mesh, JSON_OBJECT) || !norma_json_is(j, primitives, JSON_ARRAY))
            return norma_gltf_malformed(g, error, mesh, "a mesh with an array \"primitives\"");
        for (uint32_t p = JSON_NONE; norma_json_each(j, primitives, &p);) {
            norma_document_result result = count_primitive(g, p, n, error);
            if (result) return result;
        }
    }
    return NORMA_DOCUMENT_OK;
}

/* They are looked for by their names, one after the other. */
enum { MOST_ATTRIBUTES = 1024 };

static norma_document_result read_primitive_attributes(
    gltf *g, uint32_t token, gltf_attributes *set, norma_document_error *error) {
    const json *j = &g->json;
    if (norma_json_size(j, token) > MOST_ATTRIBUTES)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            norma_gltf_pointer(g, token).text, "has %u attributes; at most %d can be read",
            (unsigned)norma_json_size(j, token), MOST_ATTRIBUTES);
    *set = (gltf_attributes){.token = token,
        .first = g->attribute_count,
        .position = GLTF_NONE,
        .normal = GLTF_NONE,
        .tangent = GLTF_NONE};
    for (uint32_t value = JSON_NONE; norma_json_each(j, token, &value);) {
        gltf_attribute *attribute = &g->attributes[g->attribute_count];
        const uint32_t accessor = norma_gltf_number(g, value, g->accessor_count);
        if (accessor == GLTF_NONE)
            return norma_gltf_malformed(g, error, value, "the number of an existing accessor");
        *attribute = (gltf_attribute){
            .name = norma_json_string(j, value - 1), .token = value, .accessor = accessor};
        ++g->attribute_count;
        if (!attribute->name) return norma_document_fail_memory(g->document, error);
        if (norma_gltf_find(g, set, attribute->name) !=
            GLTF_NONE) /* which of them others read is anybody's guess */
            return norma_gltf_malformed(g, error, value, "each name once");
        ++set->count;
        if (strcmp(attribute->name, "POSITION") == 0)
            set->position = attribute->accessor;
        else if (strcmp(attribute->name, "NORMAL") == 0)
            set->normal = attribute->accessor;
        else if (strcmp(attribute->name, "TANGENT") == 0)
            set->tangent = attribute->accessor;
    }
    return NORMA_DOCUMENT_OK;
}

uint32_t norma_gltf_find(const gltf *g, const gltf_attributes *attributes, const char *name) {
    for (uint32_t i = attributes->count; i-- > 0;)
        if (strcmp(g->attributes[attributes->first + i].name, name) == 0)
            return attributes->first + i;
    return GLTF_NONE;
}

uint32_t norma_gltf_numbered(const gltf *g, const gltf_primitive *p, const char *name, size_t set) {
    char text[40];
    snprintf(text, sizeof text, "%s_%zu", name, set);
    const uint32_t found = norma_gltf_find(g, &p->base, text);
    return found == GLTF_NONE ? GLTF_NONE : g->attributes[found].accessor;
}

uint32_t norma_gltf_texcoords(const gltf *g, const gltf_primitive *p, size_t set) {
    const uint32_t accessor = norma_gltf_numbered(g, p, "TEXCOORD", set);
    return accessor != GLTF_NONE && g->accessors[accessor].width == 2 &&
                   g->accessors[accessor].count == p->vertices
               ? accessor
               : GLTF_NONE;
}

static const char *why_not_read(const gltf *g, const gltf_primitive *p) {
    if (p->mode == GLTF_POINTS) return "points have no normals to compute";
    if (p->mode < GLTF_TRIANGLES) return "lines have no normals to compute";
    if (p->base.position == GLTF_NONE) return "no positions";
    const gltf_accessor *position = &g->accessors[p->base.position];
    if (position->width != 3 || position->component == GLTF_UINT)
        return "positions of a type that glTF does not allow";
    return NULL;
}

/* A buffer without a URI may be handed over beside the file, by whom it was made for. */
static int lacks_bytes(const gltf *g, uint32_t accessor) {
    if (accessor == GLTF_NONE) return 0;
    const gltf_accessor *a = &g->accessors[accessor];
    const uint32_t views[3] = {a->view, a->sparse.count ? a->sparse.indices_view : GLTF_NONE,
        a->sparse.count ? a->sparse.values_view : GLTF_NONE};
    for (int i = 0; i < 3; ++i) {
        if (views[i] != GLTF_NONE && norma_gltf_has_no_bytes(g, views[i])) return 1;
    }
    return 0;
}

static int lacks_decoder(const gltf *g, uint32_t accessor) {
    if (accessor == GLTF_NONE || norma_gltf_reads_meshopt()) return 0;
    const uint32_t view = g->accessors[accessor].view;
    return view != GLTF_NONE && g->views[view].meshopt.token != GLTF_NONE;
}

typedef int accessor_test(const gltf *g, uint32_t accessor);

static int any_accessor(const gltf *g, const gltf_primitive *p, accessor_test *test) {
    int any = test(g, p->indices);
    for (uint32_t i = p->base.first; i < p->attribute_end && !any; ++i)
        any = test(g, g->attributes[i].accessor);
    return any;
}

static const char *why_without_bytes(const gltf *g, const gltf_primitive *p) {
    if (any_accessor(g, p, lacks_decoder))
        return "compressed with EXT_meshopt_compression, and this Norma was built without "
               "meshoptimizer";
    return any_accessor(g, p, lacks_bytes) ? "its buffer has no URI, so its bytes are not available"
                                           : NULL;
}

static void count_primitive_faces(const gltf *g, gltf_primitive *p) {
    size_t corners = p->indices == GLTF_NONE ? p->vertices : g->accessors[p->indices].count;
    if (p->mode == GLTF_TRIANGLES)
        p->faces = corners / 3;
    else if (p->mode > GLTF_TRIANGLES)
        p->faces = corners < 3 ? 0 : corners - 2;
}

static norma_document_result read_primitive(
    gltf *g, gltf_primitive *p, norma_document_error *error) {
    const json *j = &g->json;
    p->mode = GLTF_TRIANGLES;
    p->indices = p->material = GLTF_NONE;
    if (!norma_gltf_index_member(g, p->token, "mode", 7, &p->mode) ||
        !norma_gltf_index_member(g, p->token, "indices", g->accessor_count, &p->indices) ||
        !norma_gltf_index_member(g, p->token, "material", g->material_count, &p->material))
        return norma_gltf_malformed(
            g, error, p->token, "a mode that glTF has, and indices and a material that exist");
    norma_document_result result =
        read_primitive_attributes(g, norma_json_member(j, p->token, "attributes"), &p->base, error);
    uint32_t targets = norma_json_member(j, p->token, "targets");
    p->first_target = g->target_count;
    p->target_count = norma_json_size(j, targets);
    for (uint32_t target = JSON_NONE; !result && norma_json_each(j, targets, &target);)
        result = read_primitive_attributes(g, target, &g->targets[g->target_count++], error);
    if (result) return result;
    p->attribute_end = g->attribute_count;
    p->vertices = p->base.position == GLTF_NONE ? 0 : g->accessors[p->base.position].count;
    count_primitive_faces(g, p);
    p->not_read = why_not_read(g, p);
    if (!p->not_read) p->not_read = why_without_bytes(g, p);
    return norma_gltf_read_draco(g, (uint32_t)(p - g->primitives), &p->not_read, error);
}

/* Normals too few or too many are judged by norma check, where it asks for that; as normals alone,
 * for what else has them loses them when they are fixed. */
static norma_document_result check_counts(
    gltf *g, const gltf_primitive *p, norma_document_error *error) {
    for (uint32_t i = p->base.first; i < p->attribute_end; ++i) {
        uint32_t accessor = g->attributes[i].accessor;
        int judged = g->document->lenient && i < p->base.first + p->base.count &&
                     strcmp(g->attributes[i].name, "NORMAL") == 0;
        if (g->accessors[accessor].count != p->vertices && !judged)
            return norma_gltf_malformed(g, error, g->attributes[i].token,
                "an accessor with as many elements as POSITION has");
    }
    return NORMA_DOCUMENT_OK;
}

/* If there are fewer normals than positions, zeros follow them, so that reading one normal for each
 * vertex stays inside the memory. This holds for all primitives that share them. */
static norma_document_result pad_normals(
    gltf *g, const gltf_primitive *p, norma_document_error *error) {
    gltf_accessor *a = &g->accessors[p->base.normal];
    gltf_array array;
    norma_document_result result = norma_gltf_array(g, p->base.normal, &array, error);
    if (result || array.count >= p->vertices || a->padded >= p->vertices) return result;
    result = norma_gltf_spend(g, a->token, p->vertices, a->element_size, error);
    unsigned char *padded = result ? NULL : norma_io_allocate(p->vertices, a->element_size);
    if (!padded) return result ? result : norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < array.count; ++i)
        memcpy(padded + i * a->element_size, array.data + i * array.stride, a->element_size);
    free(a->owned);
    a->owned = padded;
    a->padded = p->vertices;
    a->array.data = padded;
    a->array.stride = a->element_size;
    return NORMA_DOCUMENT_OK;
}

/* What computing will trust: as many elements in each attribute, positions inside their buffer,
 * indices below the number of vertices. */
static norma_document_result check_primitive_elements(
    gltf *g, uint32_t number, norma_document_error *error) {
    gltf_primitive *p = &g->primitives[number];
    const uint32_t *corners;
    gltf_array elements;
    if (p->not_read) return NORMA_DOCUMENT_OK;
    norma_document_result result = check_counts(g, p, error);
    if (!result) result = norma_gltf_array(g, p->base.position, &elements, error);
    if (!result && p->indices != GLTF_NONE) /* their bytes count as well */
        result = norma_gltf_array(g, p->indices, &elements, error);
    if (!result) result = norma_gltf_draw(g, p, error);
    if (!result && p->base.normal != GLTF_NONE && g->accessors[p->base.normal].count < p->vertices)
        result = pad_normals(g, p, error);
    return result ? result : norma_gltf_corners(g, number, &corners, error);
}

static norma_document_result read_mesh_object(
    gltf *g, uint32_t number, norma_document_error *error) {
    gltf_mesh *mesh = &g->meshes[number];
    uint32_t primitives = norma_json_member(&g->json, mesh->token, "primitives");
    mesh->name = norma_gltf_read_name(g, mesh->token);
    if (!mesh->name) return norma_document_fail_memory(g->document, error);
    mesh->first_primitive = g->primitive_count;
    for (uint32_t token = JSON_NONE; norma_json_each(&g->json, primitives, &token);) {
        gltf_primitive *p = &g->primitives[g->primitive_count++];
        *p = (gltf_primitive){.token = token, .mesh = number, .number = mesh->primitive_count++};
        snprintf(p->where, sizeof p->where, "/meshes/%u/primitives/%u", (unsigned)number,
            (unsigned)p->number);
        norma_document_result result = read_primitive(g, p, error);
        if (result) return result;
    }
    return NORMA_DOCUMENT_OK;
}

/* After all of them are read: only then is it known which accessors' elements Draco holds. */
static norma_document_result check_primitives(gltf *g, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; !result && i < g->primitive_count; ++i) {
        const gltf_primitive *p = &g->primitives[i];
        result = check_primitive_elements(g, i, error);
        if (!result && p->not_read && p->mode >= GLTF_TRIANGLES)
            norma_document_add_note(g->document, "%s of mesh \"%s\" was skipped: %s", p->where,
                g->meshes[p->mesh].name, p->not_read);
    }
    return result;
}

norma_document_result norma_gltf_read_meshes(gltf *g, norma_document_error *error) {
    uint32_t meshes = norma_json_member(&g->json, 0, "meshes"), number = 0;
    counts n = {0};
    norma_document_result result = count_all(g, meshes, &n, error);
    if (result) return result;
    g->material_count = norma_json_size(&g->json, norma_json_member(&g->json, 0, "materials"));
    g->meshes = norma_io_allocate(norma_json_size(&g->json, meshes), sizeof *g->meshes);
    g->primitives = norma_io_allocate(n.primitives, sizeof *g->primitives);
    g->targets = norma_io_allocate(n.targets, sizeof *g->targets);
    g->attributes = norma_io_allocate(n.attributes, sizeof *g->attributes);
    if (!g->meshes || !g->primitives || !g->targets || !g->attributes)
        return norma_document_fail_memory(g->document, error);
    for (uint32_t token = JSON_NONE; !result && norma_json_each(&g->json, meshes, &token);) {
        g->meshes[number].token = token;
        ++g->mesh_count;
        result = read_mesh_object(g, number++, error);
    }
    return result || g->document->depth != NORMA_DOCUMENT_WHOLE ? result
                                                                : check_primitives(g, error);
}

/* ---- corners */

/* Corners of triangle i among those of a strip or a fan (glTF 2.0, 3.7.2.1). */
static void unroll_primitive(uint32_t mode, size_t i, size_t out[3]) {
    if (mode == GLTF_TRIANGLES) {
        out[0] = 3 * i;
        out[1] = 3 * i + 1;
        out[2] = 3 * i + 2;
    } else if (mode == GLTF_STRIP) {
        out[0] = i;
        out[1] = i + 1 + i % 2;
        out[2] = i + 2 - i % 2;
    } else {
        out[0] = i + 1;
        out[1] = i + 2;
        out[2] = 0;
    }
}

static norma_document_result fail_corner(const gltf *g, const gltf_primitive *p, size_t at,
    uint32_t index, norma_document_error *error) {
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, p->where,
        "index %zu (accessor %u) names vertex %u, but there are only %zu vertices", at,
        (unsigned)p->indices, (unsigned)index, p->vertices);
}

/* The first count indices; one loop for each width, since this is read for every corner of a file.
 */
static void widen_indices(const gltf_array *indices, size_t count, uint32_t *out) {
    const unsigned char *at = indices->data;
    const size_t stride = indices->stride;
    if (indices->component == GLTF_UINT && stride == sizeof *out)
        memcpy(out, at, count * sizeof *out);
    else
        for (size_t i = 0; i < count; ++i, at += stride)
            out[i] = norma_gltf_read_uint(at, indices->component);
}

/* list: the indices in order; NULL: 0, 1, 2, ... It may be the corners themselves, of a triangle
 * list. */
static norma_document_result fill_primitive_corners(
    gltf *g, gltf_primitive *p, const uint32_t *list, norma_document_error *error) {
    for (size_t face = 0; face < p->faces; ++face) {
        size_t at[3];
        unroll_primitive(p->mode, face, at);
        for (size_t k = 0; k < 3; ++k) {
            uint32_t index = list ? list[at[k]] : (uint32_t)at[k];
            if (index >= p->vertices) return fail_corner(g, p, at[k], index, error);
            p->corners[3 * face + k] = index;
        }
    }
    return NORMA_DOCUMENT_OK;
}

static int all_below(const uint32_t *indices, size_t count, size_t limit) {
    uint32_t greatest = 0;
    for (size_t i = 0; i < count; ++i) greatest = indices[i] > greatest ? indices[i] : greatest;
    return count == 0 || greatest < limit;
}

/* A list of triangles whose indices lie in the file as this machine has them is used where it lies;
 * not so elements of the accessor's own, which may yet be made anew. */
static const uint32_t *corners_in_place(
    const gltf *g, const gltf_primitive *p, const gltf_array *indices) {
    if (!norma_gltf_is_low_first() || p->mode != GLTF_TRIANGLES || p->indices == GLTF_NONE ||
        g->accessors[p->indices].owned || indices->component != GLTF_UINT ||
        indices->stride != sizeof(uint32_t) || (uintptr_t)indices->data % sizeof(uint32_t) != 0)
        return NULL;
    const uint32_t *corners = (const uint32_t *)(const void *)indices->data;
    return all_below(corners, 3 * p->faces, p->vertices) ? corners : NULL;
}

static norma_document_result read_primitive_corners(
    gltf *g, gltf_primitive *p, const gltf_array *indices, norma_document_error *error) {
    size_t count = p->mode == GLTF_TRIANGLES ? 3 * p->faces : p->faces + 2;
    if (p->indices == GLTF_NONE || p->faces == 0) return fill_primitive_corners(g, p, NULL, error);
    uint32_t *list =
        p->mode == GLTF_TRIANGLES ? p->corners : norma_io_allocate(count, sizeof *list);
    if (!list) return norma_document_fail_memory(g->document, error);
    widen_indices(indices, count, list);
    norma_document_result result = fill_primitive_corners(g, p, list, error);
    if (list != p->corners) free(list);
    return result;
}

norma_document_result norma_gltf_corners(
    gltf *g, uint32_t number, const uint32_t **corners, norma_document_error *error) {
    gltf_primitive *p = &g->primitives[number];
    gltf_array indices = {0};
    *corners = p->corners ? p->corners : p->direct_corners;
    if (*corners) return NORMA_DOCUMENT_OK;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (p->not_read)
        return norma_document_fail(
            g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, p->where, "%s", p->not_read);
    if (p->indices != GLTF_NONE) {
        const gltf_accessor *a = &g->accessors[p->indices];
        if (a->width != 1 || (a->component != GLTF_UBYTE && a->component != GLTF_USHORT &&
                                 a->component != GLTF_UINT))
            return norma_gltf_malformed(g, error, a->token, "indices as unsigned whole numbers");
        result = norma_gltf_array(g, p->indices, &indices, error);
    }
    if (result) return result;
    *corners = p->direct_corners = corners_in_place(g, p, &indices);
    if (*corners) return NORMA_DOCUMENT_OK;
    if (p->vertices > UINT32_MAX || p->faces > SIZE_MAX / (3 * sizeof(uint32_t)) ||
        !(p->corners = norma_io_block(p->faces, 3 * sizeof(uint32_t))))
        return norma_document_fail_memory(g->document, error);
    result = read_primitive_corners(g, p, &indices, error);
    if (result) {
        free(p->corners);
        p->corners = NULL;
    }
    *corners = p->corners;
    return result;
}

/* ---- arrays for others */

/* Of each corner the normal: its vertex, where that has one. */
static norma_document_result name_normals(const gltf *g, gltf_primitive *p, const uint32_t *corners,
    size_t normals, norma_document_error *error) {
    if (p->corner_normals) return NORMA_DOCUMENT_OK;
    p->corner_normals = norma_io_allocate(p->faces, 3 * sizeof *p->corner_normals);
    if (!p->corner_normals) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < 3 * p->faces; ++i)
        p->corner_normals[i] = corners[i] < normals ? corners[i] : UINT32_MAX;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_gltf_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    gltf_primitive *p = &g->primitives[index];
    const uint32_t *corners;
    norma_vec3_view positions;
    const float *normals = NULL;
    norma_document_result result = norma_gltf_corners(g, (uint32_t)index, &corners, error);
    if (!result) result = norma_gltf_position_view(g, p->base.position, &positions, error);
    if (!result && p->base.normal != GLTF_NONE &&
        !(document->lenient && norma_gltf_is_placeholder(g, p->base.normal)))
        result = norma_gltf_decode(g, p->base.normal, 3, &normals, error);
    if (result) return result;
    data->mesh.positions = positions;
    data->mesh.corners = corners;
    data->mesh.corner_count = 3 * p->faces;
    if (!normals) return NORMA_DOCUMENT_OK;
    size_t count = g->accessors[p->base.normal].count;
    data->normals = (norma_vec3_view){.data = normals,
        .count = count < p->vertices ? count : p->vertices,
        .format = NORMA_FORMAT_FLOAT};
    if (count < p->vertices) result = name_normals(g, p, corners, count, error);
    data->corner_normals = result ? NULL : p->corner_normals;
    return result;
}
