/* pack_materials.c: what drawing needs of a mesh besides its shape: its name, the number of its
 * material, colours of its vertices, texture coordinates, tangents. */
#include "model_pack.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- texture coordinates */

/* turn: as norma_material_info.normal_turn, or NULL. VIEW_PACK_NONE: the mesh has no such set. */
static norma_document_result pack_set(norma_document *document, size_t mesh, size_t set,
    const float *turn, size_t count, view_pack *pack, uint32_t *at, norma_document_error *error) {
    const float *texcoords = NULL;
    size_t there = 0;
    const norma_document_result result =
        norma_document_texcoords(document, mesh, set, &texcoords, &there, error);
    if (result || !texcoords || there < count) return result;
    *at = view_pack_append(pack, texcoords, count, 2 * sizeof *texcoords);
    for (size_t i = 0; turn && i < count && !pack->failed; ++i) {
        const float *uv = texcoords + 2 * i, turned[2] = {turn[0] * uv[0] + turn[1] * uv[1],
                                                 turn[2] * uv[0] + turn[3] * uv[1]};
        memcpy(pack->bytes + *at + sizeof turned * i, turned, sizeof turned);
    }
    return NORMA_DOCUMENT_OK;
}

/* The sets that three.js looks images up by, and along which tangents lie: those of the normal map,
 * turned as it is. */
static norma_document_result pack_texcoords(norma_document *document, size_t mesh,
    const norma_material_info *material, view_pack *pack, view_pack_mesh *record,
    norma_document_error *error) {
    static const float unturned[4] = {0};
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t set = 0; set < 2 && !result; ++set)
        result = pack_set(document, mesh, set, NULL, record->position_count, pack,
            &record->texcoords[set], error);
    const size_t set = material ? material->normal_texcoord : 0;
    const int turned = material && memcmp(material->normal_turn, unturned, sizeof unturned) != 0;
    if (!turned && set < 2)
        record->map_texcoords = record->texcoords[set];
    else if (!result)
        result = pack_set(document, mesh, set, turned ? material->normal_turn : NULL,
            record->position_count, pack, &record->map_texcoords, error);
    return result;
}

/* ---- colours of vertices */

static uint16_t as_part(float x) { return (uint16_t)(65535 * fminf(fmaxf(x, 0), 1) + 0.5F); }

static void pack_colours(
    const float *colours, const uint32_t *vertices, view_pack *pack, view_pack_mesh *record) {
    const size_t count = record->position_count;
    uint16_t *parts = malloc(8 * count + 1);
    pack->failed |= !parts;
    for (size_t i = 0; parts && i < count; ++i)
        for (size_t k = 0; k < 4; ++k)
            parts[4 * i + k] = as_part(colours[4 * (vertices ? vertices[i] : i) + k]);
    if (parts) record->colours = view_pack_append(pack, parts, count, 8);
    free(parts);
}

/* ---- all of it */

static void pack_name(norma_document *document, size_t mesh, const norma_material_info *material,
    view_pack *pack, view_pack_mesh *record) {
    norma_mesh_info info;
    char text[160] = "";
    if (!norma_document_mesh_info(document, mesh, &info))
        snprintf(text, sizeof text, "%.70s%s%.70s", info.name,
            info.name[0] && material && material->name[0] ? ", " : "",
            material ? material->name : "");
    record->name = view_pack_append(pack, text, strlen(text) + 1, 1);
}

norma_document_result view_pack_material(norma_document *document, size_t mesh,
    const uint32_t *vertices, view_pack *pack, view_pack_mesh *record,
    norma_document_error *error) {
    const int gltf = norma_file_format_is_gltf(norma_document_format(document));
    norma_mesh_attributes attributes;
    norma_material_info material;
    record->material = record->texcoords[0] = record->texcoords[1] = record->map_texcoords =
        record->tangents = record->colours = VIEW_PACK_NONE;
    const norma_document_result result =
        norma_document_mesh_attributes(document, mesh, &attributes, NULL);
    const int known = !result && attributes.material != SIZE_MAX &&
                      !norma_document_material_info(document, attributes.material, &material);
    for (int i = 0; i < 4; ++i) record->colour[i] = known ? material.base_color[i] : 1;
    record->double_sided = !gltf || (known && material.double_sided); /* only glTF has sides */
    pack_name(document, mesh, known ? &material : NULL, pack, record);
    if (!result && attributes.colors) pack_colours(attributes.colors, vertices, pack, record);
    if (result || !gltf) return result == NORMA_DOCUMENT_ERROR_MEMORY ? result : NORMA_DOCUMENT_OK;
    if (known && attributes.material < VIEW_PACK_NONE)
        record->material = (uint32_t)attributes.material;
    if (vertices) return NORMA_DOCUMENT_OK; /* decimated: images would no longer fit */
    if (attributes.tangent_count >= record->position_count)
        record->tangents =
            view_pack_append(pack, attributes.tangents, record->position_count, 4 * sizeof(float));
    return pack_texcoords(document, mesh, known ? &material : NULL, pack, record, error);
}
