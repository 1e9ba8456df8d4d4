/* gltf_scene.c: what a glTF's surfaces have beside positions, corners and normals: UVs, colours,
 * tangents, morph targets, the rules that extras silence, where a node stands, and what of the file
 * was not read. */
#include "io/gltf/gltf.h"
#include "core/matrix/matrix.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- attributes */

const char *norma_gltf_encoding_name(const gltf *g, uint32_t accessor) {
    if (accessor == GLTF_NONE) return "";
    switch (g->accessors[accessor].component) {
    case GLTF_BYTE:
        return "snorm8";
    case GLTF_SHORT:
        return "snorm16";
    case GLTF_UBYTE:
        return "unorm8";
    case GLTF_USHORT:
        return "unorm16";
    case GLTF_HALF:
        return "float16";
    case GLTF_DOUBLE:
        return "double";
    default:
        return "float";
    }
}

/* A set of UVs that is there and is one; what is not, this library has no use for, and others will
 * say. */
static norma_document_result read_vertex_texcoords(gltf *g, const gltf_primitive *p, size_t set,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    char name[40];
    snprintf(name, sizeof name, "TEXCOORD_%zu", set);
    uint32_t found = norma_gltf_find(g, &p->base, name);
    uint32_t accessor = found == GLTF_NONE ? GLTF_NONE : g->attributes[found].accessor;
    if (accessor == GLTF_NONE || g->accessors[accessor].width != 2 ||
        g->accessors[accessor].count != p->vertices)
        return NORMA_DOCUMENT_OK;
    attributes->texcoord_count = p->vertices;
    return norma_gltf_decode(g, accessor, 2, &attributes->texcoords, error);
}

static norma_document_result texcoords(norma_document *document, size_t mesh, size_t set,
    const float **coordinates, size_t *count, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_mesh_attributes found = {0};
    norma_document_result result =
        read_vertex_texcoords(g, &g->primitives[mesh], set, &found, error);
    *coordinates = found.texcoords;
    *count = found.texcoord_count;
    return result;
}

static norma_document_result widen_colors(
    gltf *g, uint32_t accessor, const float **colors, norma_document_error *error) {
    gltf_array array;
    gltf_scene *scene = norma_gltf_scene_of(g);
    norma_document_result result = scene ? norma_gltf_array(g, accessor, &array, error)
                                         : norma_document_fail_memory(g->document, error);
    if (result) return result;
    if (!scene->colors[accessor]) {
        result = norma_gltf_spend(
            g, g->accessors[accessor].token, array.count, 4 * sizeof(float), error);
        float *made =
            result ? NULL : norma_scene_allocate(g->document->scene, array.count, 4 * sizeof *made);
        if (!made) return result ? result : norma_document_fail_memory(g->document, error);
        for (size_t i = 0; i < array.count; ++i) {
            norma_gltf_floats(&array, i, made + 4 * i);
            made[4 * i + 3] = 1;
        }
        scene->colors[accessor] = made;
    }
    *colors = scene->colors[accessor];
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_vertex_colors(gltf *g, const gltf_primitive *p,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    uint32_t found = norma_gltf_find(g, &p->base, "COLOR_0"),
             accessor = found == GLTF_NONE ? GLTF_NONE : g->attributes[found].accessor;
    if (accessor == GLTF_NONE || g->accessors[accessor].count != p->vertices)
        return NORMA_DOCUMENT_OK;
    if (g->accessors[accessor].width == 4)
        return norma_gltf_decode(g, accessor, 4, &attributes->colors, error);
    return g->accessors[accessor].width == 3 ? widen_colors(g, accessor, &attributes->colors, error)
                                             : NORMA_DOCUMENT_OK;
}

static norma_document_result read_tangents(gltf *g, const gltf_primitive *p,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    if (p->base.tangent == GLTF_NONE || norma_gltf_is_placeholder(g, p->base.tangent))
        return NORMA_DOCUMENT_OK;
    attributes->tangent_count = g->accessors[p->base.tangent].count;
    attributes->tangent_encoding = norma_gltf_encoding_name(g, p->base.tangent);
    return norma_gltf_decode(g, p->base.tangent, 4, &attributes->tangents, error);
}

static void count_stored_normals(
    const gltf *g, const gltf_primitive *p, norma_mesh_attributes *attributes) {
    size_t count = p->base.normal == GLTF_NONE ? p->vertices : g->accessors[p->base.normal].count;
    attributes->normals_missing = count < p->vertices ? p->vertices - count : 0;
    attributes->normals_surplus = count > p->vertices ? count - p->vertices : 0;
}

static const char *ignored_by_primitive(gltf *g, const gltf_primitive *p) {
    gltf_scene *scene = norma_gltf_scene_of(g);
    if (!scene) return NULL;
    if (!scene->mesh_ignore[p->mesh])
        scene->mesh_ignore[p->mesh] =
            norma_gltf_ignored_with(g, norma_gltf_root_ignore(g), g->meshes[p->mesh].token);
    return norma_gltf_ignored_with(g, scene->mesh_ignore[p->mesh], p->token);
}

static norma_document_result read_vertex_attributes(norma_document *document, size_t index,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    const gltf_primitive *p = &g->primitives[index];
    size_t set = 0;
    if (p->material < document->scene->material_count) {
        attributes->material = p->material;
        const norma_material_info *material = &document->scene->materials[p->material];
        if (material->normal_map) set = material->normal_texcoord;
        memcpy(attributes->texcoord_turn, material->normal_turn, sizeof material->normal_turn);
    }
    count_stored_normals(g, p, attributes);
    attributes->ignore = ignored_by_primitive(g, p);
    if (!attributes->ignore) return norma_document_fail_memory(document, error);
    norma_document_result result = read_vertex_texcoords(g, p, set, attributes, error);
    if (!result) result = read_vertex_colors(g, p, attributes, error);
    return result ? result : read_tangents(g, p, attributes, error);
}

/* ---- morph targets */

static norma_document_result read_deltas(
    gltf *g, uint32_t accessor, norma_vec3_view *view, norma_document_error *error) {
    const float *floats;
    if (accessor == GLTF_NONE) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_gltf_decode(g, accessor, 3, &floats, error);
    if (!result)
        *view = (norma_vec3_view){
            .data = floats, .count = g->accessors[accessor].count, .format = NORMA_FORMAT_FLOAT};
    return result;
}

/* Positions that are normalised integers are given as the integers that they are; what moves them
 * is brought to their unit. */
static norma_document_result scale_moves(
    gltf *g, uint32_t base, norma_vec3_view *moves, norma_document_error *error) {
    const gltf_accessor *a = &g->accessors[base];
    const float unit = (float)norma_gltf_largest_code(a->component);
    if (!a->normalized || unit == 1 || !moves->count) return NORMA_DOCUMENT_OK;
    norma_document_result result =
        norma_gltf_spend(g, a->token, moves->count, 3 * sizeof(float), error);
    float *scaled =
        result ? NULL : norma_scene_allocate(g->document->scene, moves->count, 3 * sizeof *scaled);
    if (!scaled) return result ? result : norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < 3 * moves->count; ++i)
        scaled[i] = unit * ((const float *)moves->data)[i];
    moves->data = scaled;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result read_morph(norma_document *document, size_t mesh, size_t target,
    norma_morph_data *data, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    size_t number = g->primitives[mesh].first_target + target;
    if (!scene->morphs &&
        !(scene->morphs = norma_scene_allocate(scene, g->target_count, sizeof *scene->morphs)))
        return norma_document_fail_memory(document, error);
    if (!scene->morphs[number]) {
        const gltf_attributes *attributes = &g->targets[number];
        norma_morph_data *made = norma_scene_allocate(scene, 1, sizeof *made);
        if (!made) return norma_document_fail_memory(document, error);
        norma_document_result result =
            read_deltas(g, attributes->position, &made->positions, error);
        if (!result)
            result = scale_moves(g, g->primitives[mesh].base.position, &made->positions, error);
        if (!result) result = read_deltas(g, attributes->normal, &made->normals, error);
        if (!result) result = read_deltas(g, attributes->tangent, &made->tangents, error);
        if (result) return result;
        scene->morphs[number] = made;
    }
    *data = *scene->morphs[number];
    return NORMA_DOCUMENT_OK;
}

/* ---- nodes */

/* Names from the root; the number of an existing node that has none. What would be longer than
 * PATH_ROOM is cut in front, so that a deep tree costs no more than a shallow one. */
static const char *path_of(gltf *g, uint32_t number) {
    enum { PATH_ROOM = 400 };
    char path[PATH_ROOM + 1], unnamed[16];
    size_t at = PATH_ROOM;
    path[at] = '\0';
    for (uint32_t node = number; node != GLTF_NONE; node = g->nodes[node].parent) {
        const char *name = g->nodes[node].name;
        if (!name[0]) {
            snprintf(unnamed, sizeof unnamed, "%u", (unsigned)node);
            name = unnamed;
        }
        size_t length = strlen(name), slash = node != number;
        if (length + slash + 4 > at) {
            if (at == PATH_ROOM) /* one name that fills it */
                return norma_scene_text(g->document->scene, name);
            at -= 4;
            memcpy(path + at, ".../", 4);
            break;
        }
        at -= slash;
        if (slash) path[at] = '/';
        at -= length;
        memcpy(path + at, name, length);
    }
    return norma_scene_text(g->document->scene, path + at);
}

/* From the nearest node above that is known, or a root, down to this one: each node's extras are
 * read once. */
static const char *ignored_by_node(gltf *g, uint32_t node) {
    gltf_scene *scene = norma_gltf_scene_of(g);
    size_t depth = 0;
    uint32_t at = node;
    for (; scene && at != GLTF_NONE && !scene->node_ignore[at]; at = g->nodes[at].parent) ++depth;
    uint32_t *path = scene ? norma_io_allocate(depth, sizeof *path) : NULL;
    const char *list = path ? norma_gltf_root_ignore(g) : NULL;
    depth = 0;
    at = node;
    for (; list && at != GLTF_NONE && !scene->node_ignore[at]; at = g->nodes[at].parent)
        path[depth++] = at;
    if (list && at != GLTF_NONE) list = scene->node_ignore[at];
    while (list && depth-- > 0) {
        list = norma_gltf_ignored_with(g, list, g->nodes[path[depth]].token);
        scene->node_ignore[path[depth]] = list;
    }
    free(path);
    return list;
}

static int mirrors_space(const double world[16]) {
    double upper[9];
    return norma_matrix_upper_double(world, upper) && norma_matrix_mirrors(upper);
}

static norma_document_result count_mirrored(gltf *g, uint32_t node, size_t *mirrored) {
    const gltf_node *n = &g->nodes[node];
    gltf_instances instances;
    *mirrored = 0;
    if (!n->instanced || g->document->depth == NORMA_DOCUMENT_SUMMARY) {
        *mirrored = mirrors_space(n->world) ? n->instances : 0;
        return NORMA_DOCUMENT_OK;
    }
    norma_document_result result = norma_gltf_read_instances(g, node, &instances, NULL);
    for (size_t i = 0; !result && i < n->instances; ++i) {
        double world[16];
        norma_gltf_instance_matrix(&instances, i, world);
        norma_gltf_matrix_multiply(n->world, world, world);
        *mirrored += (size_t)mirrors_space(world);
    }
    return result;
}

static norma_document_result make_node(gltf *g, uint32_t node, norma_node_info *info) {
    info->parent = g->nodes[node].parent == GLTF_NONE ? SIZE_MAX : g->nodes[node].parent;
    info->skin = g->nodes[node].skin == GLTF_NONE ? SIZE_MAX : g->nodes[node].skin;
    info->where = norma_gltf_where(g, "nodes", node);
    info->path = path_of(g, node);
    info->ignore = ignored_by_node(g, node);
    if (!info->where || !info->path || !info->ignore) return NORMA_DOCUMENT_ERROR_MEMORY;
    return count_mirrored(g, node, &info->mirrored_instances);
}

norma_document_result norma_gltf_describe_node(
    const norma_document *document, size_t index, norma_node_info *info) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    if (!scene->nodes &&
        !(scene->nodes = norma_scene_allocate(scene, g->drawing_count, sizeof *scene->nodes)))
        return NORMA_DOCUMENT_ERROR_MEMORY;
    norma_node_info made = *info;
    norma_document_result result =
        scene->nodes[index].where ? NORMA_DOCUMENT_OK : make_node(g, g->drawing[index], &made);
    if (!result && !scene->nodes[index].where) scene->nodes[index] = made;
    if (!result) *info = scene->nodes[index];
    return result;
}

static norma_document_result gltf_instance_world(norma_document *document, size_t index,
    size_t instance, double world[16], norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    uint32_t node = g->drawing[index];
    gltf_instances instances;
    memcpy(world, g->nodes[node].world, sizeof g->nodes[node].world);
    if (!g->nodes[node].instanced) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_gltf_read_instances(g, node, &instances, error);
    if (!result) {
        double matrix[16];
        norma_gltf_instance_matrix(&instances, instance, matrix);
        norma_gltf_matrix_multiply(world, matrix, world);
    }
    return result;
}

/* ---- what was not read */

static const char *unknown_extension(gltf *g, uint32_t token) {
    char *name = norma_json_string(&g->json, token), *why = NULL;
    size_t size = name ? strlen(name) + 64 : 0;
    if (name && (norma_gltf_is_known(name) || strcmp(name, "KHR_draco_mesh_compression") ==
                                                  0)) /* its primitives are named instead */
        why = norma_scene_text(g->document->scene, "");
    else if (name && (why = norma_scene_allocate(g->document->scene, size, 1)) != NULL)
        snprintf(why, size, "requires %s, which is unknown to this version", name);
    free(name);
    return why;
}

static const char *why_in_part(const gltf *g, const gltf_primitive *p) {
    if (p->not_read) return p->mode >= GLTF_TRIANGLES ? p->not_read : NULL;
    if (p->base.normal != GLTF_NONE && norma_gltf_is_placeholder(g, p->base.normal))
        return "its normals have no data in the file; an application has to provide them";
    if (p->base.tangent != GLTF_NONE && norma_gltf_is_placeholder(g, p->base.tangent))
        return "its tangents have no data in the file; an application has to provide them";
    return NULL;
}

/* Bytes behind the end that a GLB's header declares. 0: out of memory. */
static int add_tail(gltf *g, norma_unread *unread, size_t *count) {
    const size_t size = norma_gltf_surplus(g);
    if (size == 0) return 1;
    char *texts = norma_scene_allocate(g->document->scene, 2, sizeof(char[120]));
    if (!texts) return 0;
    snprintf(texts, 120, "byte %zu", g->tile.at + g->container_size);
    snprintf(texts + 120, 120, "%zu bytes follow the end that the header declares", size);
    unread[(*count)++] = (norma_unread){texts, texts + 120};
    return 1;
}

static norma_document_result read_unread_part(
    norma_document *document, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    uint32_t list = norma_json_member(&g->json, 0, "extensionsRequired"), number = 0;
    norma_unread *unread = norma_scene_allocate(
        scene, (size_t)norma_json_size(&g->json, list) + g->primitive_count + 2, sizeof *unread);
    size_t count = 0;
    if (!unread || !add_tail(g, unread, &count)) return norma_document_fail_memory(document, error);
    if (norma_gltf_needs_later(g))
        unread[count++] =
            (norma_unread){"/asset/minVersion", "needs a later version of glTF than 2.0"};
    for (uint32_t item = norma_json_first(&g->json, list); item != JSON_NONE;
         item = norma_json_next(&g->json, list, item), ++number) {
        const norma_unread made = {
            norma_gltf_where(g, "extensionsRequired", number), unknown_extension(g, item)};
        if (!made.where || !made.why) return norma_document_fail_memory(document, error);
        if (made.why[0]) unread[count++] = made;
    }
    for (uint32_t i = 0; i < g->primitive_count; ++i) {
        const char *why = why_in_part(g, &g->primitives[i]);
        if (why) unread[count++] = (norma_unread){g->primitives[i].where, why};
    }
    scene->unread = unread;
    scene->unread_count = count;
    return NORMA_DOCUMENT_OK;
}

const scene_functions norma_gltf_scene = {
    .materials = norma_gltf_materials,
    .attributes = read_vertex_attributes,
    .morph = read_morph,
    .skin_count = norma_gltf_skin_count,
    .skin = norma_gltf_skin,
    .unread = read_unread_part,
    .instance_world = gltf_instance_world,
    .move_drawn = norma_gltf_move_drawn,
    .material_maps = norma_gltf_material_maps,
    .normal_map = norma_gltf_normal_texture,
    .texcoords = texcoords,
};
