/* scene.c: the public functions about what else belongs to a surface. */
#include "io/format/for_fixes.h"
#include "io/format/format.h"
#include <string.h>

static const scene_functions *scene_of(const norma_document *document) {
    static const scene_functions nothing = {0};
    return document->functions->scene ? document->functions->scene : &nothing;
}

static norma_document_result check_mesh(
    norma_document *document, size_t index, norma_document_error *error) {
    norma_mesh_info info;
    size_t count = norma_document_mesh_count(document);
    if (index >= count || norma_document_mesh_info(document, index, &info))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "there is no mesh %zu; the document has %zu, numbered from 0", index, count);
    if (info.not_read)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT,
            info.where[0] ? info.where : NULL, "%s", info.not_read);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result need_materials(norma_document *document) {
    if (document->scene->materials || !scene_of(document)->materials) return NORMA_DOCUMENT_OK;
    return scene_of(document)->materials(document, NULL);
}

size_t norma_document_material_count(norma_document *document) {
    return norma_document_up_to_date(document) && !need_materials(document)
               ? document->scene->material_count
               : 0;
}

norma_document_result norma_document_material_info(
    norma_document *document, size_t index, norma_material_info *info) {
    if (!info) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info =
        (norma_material_info){.name = "", .where = "", .base_color = {1, 1, 1, 1}, .ignore = ""};
    norma_document_result result =
        document ? need_materials(document) : NORMA_DOCUMENT_ERROR_ARGUMENT;
    if (result || index >= document->scene->material_count)
        return result ? result : NORMA_DOCUMENT_ERROR_ARGUMENT;
    *info = document->scene->materials[index];
    return NORMA_DOCUMENT_OK;
}

static const norma_mesh_attributes no_attributes = {
    .material = SIZE_MAX, .tangent_encoding = "", .ignore = ""};

static norma_document_result make_attributes(
    norma_document *document, size_t index, norma_document_error *error) {
    norma_scene *scene = document->scene;
    if (need_materials(document)) /* of an OBJ, its attributes as well */
        return norma_document_fail_memory(document, error);
    if (!scene->attributes &&
        !(scene->attributes = norma_scene_allocate(
              scene, norma_document_mesh_count(document), sizeof *scene->attributes)))
        return norma_document_fail_memory(document, error);
    if (scene->attributes[index]) return NORMA_DOCUMENT_OK;
    norma_mesh_attributes *made = norma_scene_allocate(scene, 1, sizeof *made);
    if (!made) return norma_document_fail_memory(document, error);
    *made = no_attributes;
    norma_document_result result =
        scene_of(document)->attributes
            ? scene_of(document)->attributes(document, index, made, error)
            : NORMA_DOCUMENT_OK;
    if (!result) scene->attributes[index] = made;
    return result;
}

norma_document_result norma_document_mesh_attributes(norma_document *document, size_t index,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    norma_document_result result = norma_document_ready(document, error);
    if (result) return result;
    if (!attributes)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no place for the attributes was given");
    *attributes = no_attributes;
    result = check_mesh(document, index, error);
    if (!result) result = make_attributes(document, index, error);
    if (!result) *attributes = *document->scene->attributes[index];
    return result;
}

norma_document_result norma_document_morph_data(norma_document *document, size_t mesh,
    size_t target, norma_morph_data *data, norma_document_error *error) {
    norma_mesh_info info;
    norma_document_result result = norma_document_ready(document, error);
    if (result) return result;
    if (!data)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no place for the target's data was given");
    *data = (norma_morph_data){0};
    result = check_mesh(document, mesh, error);
    if (result) return result;
    norma_document_mesh_info(document, mesh, &info);
    if (target >= info.morph_targets || !scene_of(document)->morph)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "there is no morph target %zu; the mesh has %zu, numbered from 0", target,
            info.morph_targets);
    return scene_of(document)->morph(document, mesh, target, data, error);
}

size_t norma_document_skin_count(norma_document *document) {
    return document && scene_of(document)->skin_count ? scene_of(document)->skin_count(document)
                                                      : 0;
}

norma_document_result norma_document_skin_info(
    norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error) {
    norma_document_result result = norma_document_ready(document, error);
    if (result) return result;
    size_t count = norma_document_skin_count(document);
    if (!info || index >= count)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "there is no skin %zu; the document has %zu, numbered from 0", index, count);
    *info = (norma_skin_info){.name = "", .where = "", .ignore = "", .joint = SIZE_MAX};
    return scene_of(document)->skin(document, index, info, error);
}

static norma_document_result need_unread(norma_document *document) {
    if (document->scene->unread || !scene_of(document)->unread) return NORMA_DOCUMENT_OK;
    return scene_of(document)->unread(document, NULL);
}

size_t norma_document_unread_count(norma_document *document) {
    return document && !need_unread(document) ? document->scene->unread_count : 0;
}

norma_document_result norma_document_unread(
    norma_document *document, size_t index, norma_unread *unread) {
    if (!unread) return NORMA_DOCUMENT_ERROR_ARGUMENT;
    *unread = (norma_unread){.where = "", .why = ""};
    norma_document_result result = document ? need_unread(document) : NORMA_DOCUMENT_ERROR_ARGUMENT;
    if (result || index >= document->scene->unread_count)
        return result ? result : NORMA_DOCUMENT_ERROR_ARGUMENT;
    *unread = document->scene->unread[index];
    return NORMA_DOCUMENT_OK;
}

size_t norma_document_tile_instance(
    const norma_document *document, size_t index, double matrix[16]) {
    return scene_of(document)->tile_instance
               ? scene_of(document)->tile_instance(document, index, matrix)
               : 0;
}

norma_document_result norma_document_instance_world(norma_document *document, size_t index,
    size_t instance, double world[16], norma_document_error *error) {
    norma_node_info info;
    norma_document_clear(error);
    if (!document || !world || index >= norma_document_node_count(document))
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "there is no node %zu; the document has %zu, numbered from 0", index,
            norma_document_node_count(document));
    norma_document_result result = norma_document_node_info(document, index, &info);
    if (result) { /* its instances cannot be read; who reads them says why */
        norma_document_result why =
            scene_of(document)->instance_world
                ? scene_of(document)->instance_world(document, index, 0, world, error)
                : NORMA_DOCUMENT_OK;
        return why ? why
                   : norma_document_fail(
                         document, error, result, NULL, "node %zu cannot be described", index);
    }
    if (instance >= info.instances || !scene_of(document)->instance_world)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, info.where,
            "there is no instance %zu; the node has %zu, numbered from 0", instance,
            info.instances);
    return scene_of(document)->instance_world(document, index, instance, world, error);
}

norma_document_result norma_document_drawn_mesh(norma_document *document, size_t node,
    size_t instance, size_t mesh, norma_drawn_mesh *drawn, norma_document_error *error) {
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_document_result result = norma_document_ready(document, error);
    if (result) return result;
    if (!drawn)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no place for the drawn mesh was given");
    *drawn = (norma_drawn_mesh){.shown = 1};
    result = norma_document_instance_world(document, node, instance, drawn->world, error);
    if (!result) result = norma_document_mesh_data(document, mesh, &data, error);
    if (!result) result = norma_document_mesh_attributes(document, mesh, &attributes, error);
    if (result) return result;
    drawn->positions = data.mesh.positions;
    drawn->normals = data.normals;
    drawn->tangents = attributes.tangents;
    return scene_of(document)->move_drawn
               ? scene_of(document)->move_drawn(document, node, mesh, drawn, error)
               : NORMA_DOCUMENT_OK;
}

static const norma_texture_info no_texture = {.scale = {1, 1}, .strength = 1, .image = SIZE_MAX};

/* out: where the answer goes. */
static norma_document_result check_material(
    norma_document *document, size_t index, const void *out, norma_document_error *error) {
    const norma_document_result result = norma_document_ready(document, error);
    if (result || (out && index < norma_document_material_count(document))) return result;
    return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
        "there is no material %zu; the document has %zu, numbered from 0", index,
        norma_document_material_count(document));
}

norma_document_result norma_document_normal_map(
    norma_document *document, size_t index, norma_texture_info *map, norma_document_error *error) {
    const norma_document_result result = check_material(document, index, map, error);
    if (result) return result;
    *map = no_texture;
    return scene_of(document)->normal_map
               ? scene_of(document)->normal_map(document, index, map, error)
               : NORMA_DOCUMENT_OK;
}

norma_document_result norma_document_material_maps(norma_document *document, size_t index,
    norma_material_maps *maps, norma_document_error *error) {
    const norma_document_result result = check_material(document, index, maps, error);
    if (result) return result;
    *maps =
        (norma_material_maps){.alpha_cutoff = 0.5F, .base_color = no_texture, .normal = no_texture};
    return scene_of(document)->material_maps
               ? scene_of(document)->material_maps(document, index, maps, error)
               : NORMA_DOCUMENT_OK;
}

norma_document_result norma_document_texcoords(norma_document *document, size_t mesh, size_t set,
    const float **texcoords, size_t *count, norma_document_error *error) {
    norma_document_result result = norma_document_ready(document, error);
    if (!result) result = check_mesh(document, mesh, error);
    if (!result && (!texcoords || !count))
        result = norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "no place for the texture coordinates was given");
    if (result) return result;
    *texcoords = NULL;
    *count = 0;
    return scene_of(document)->texcoords
               ? scene_of(document)->texcoords(document, mesh, set, texcoords, count, error)
               : NORMA_DOCUMENT_OK;
}
