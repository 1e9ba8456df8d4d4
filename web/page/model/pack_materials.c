/* pack_materials.c: what a mesh's material makes it look like, as records of a pack: its colour,
 * those of its vertices, its images and where they are looked up, its tangents. */
#include "model_pack.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of all images together: more would only make the page slow to open. */
static const size_t most_bytes = (size_t)48 << 20;

/* ---- images */

static int add_image(view_pack_images *images, size_t number, view_pack_image image) {
    view_pack_image *records =
        realloc(images->records, (images->count + 1) * sizeof *images->records);
    if (records) images->records = records;
    size_t *numbers = realloc(images->numbers, (images->count + 1) * sizeof *images->numbers);
    if (numbers) images->numbers = numbers;
    if (!records || !numbers) return 0;
    images->records[images->count] = image;
    images->numbers[images->count++] = number;
    images->size += image.size;
    return 1;
}

/* The number of its record; VIEW_PACK_NONE: it cannot be read, or there is no room for it. */
static uint32_t pack_image(
    view_pack *pack, view_pack_images *images, const norma_texture_info *info) {
    if (!info->there) return VIEW_PACK_NONE;
    for (uint32_t i = 0; i < images->count; ++i)
        if (images->numbers[i] == info->image) return i;
    if (info->image == SIZE_MAX || !info->bytes || info->size > most_bytes - images->size) {
        ++images->left_out;
        return VIEW_PACK_NONE;
    }
    const view_pack_image image = {
        view_pack_append(pack, info->bytes, info->size, 1), (uint32_t)info->size};
    pack->failed |= !add_image(images, info->image, image);
    return pack->failed ? VIEW_PACK_NONE : images->count - 1;
}

void view_pack_images_free(view_pack_images *images) {
    free(images->records);
    free(images->numbers);
    *images = (view_pack_images){0};
}

/* ---- texture coordinates, as they are looked up */

static norma_document_result place_texcoords(norma_document *document, size_t mesh,
    const norma_texture_info *info, float *out, size_t count, norma_document_error *error) {
    const float *texcoords = NULL;
    size_t there = 0;
    const norma_document_result result =
        norma_document_texcoords(document, mesh, info->texcoord, &texcoords, &there, error);
    if (!result && texcoords)
        norma_texture_place(info, texcoords, there < count ? there : count, 4, out);
    return result;
}

/* Those of the base map, then those of the normal map; without a normal map the first set, along
 * which tangents lie. */
static norma_document_result pack_texcoords(norma_document *document, size_t mesh,
    const norma_material_maps *maps, view_pack *pack, view_pack_mesh *record,
    norma_document_error *error) {
    static const norma_texture_info plain = {.scale = {1, 1}};
    const size_t count = record->position_count;
    float *all = calloc(4 * count + 1, sizeof *all);
    if (!all) return NORMA_DOCUMENT_ERROR_MEMORY;
    norma_document_result result = place_texcoords(
        document, mesh, maps->base_color.there ? &maps->base_color : &plain, all, count, error);
    if (!result)
        result = place_texcoords(
            document, mesh, maps->normal.there ? &maps->normal : &plain, all + 2, count, error);
    if (!result) record->texcoords = view_pack_append(pack, all, count, 4 * sizeof *all);
    free(all);
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

/* ---- materials */

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

static void copy_sampler(const norma_texture_info *info, uint32_t wrap[2], uint32_t filter[2]) {
    wrap[0] = (uint32_t)info->wrap_s;
    wrap[1] = (uint32_t)info->wrap_t;
    filter[0] = (uint32_t)info->mag_filter;
    filter[1] = (uint32_t)info->min_filter;
}

static norma_document_result pack_maps(norma_document *document, size_t mesh, size_t material,
    view_pack_images *images, view_pack *pack, view_pack_mesh *record,
    norma_document_error *error) {
    norma_material_maps maps = {0};
    norma_document_result result = norma_document_material_maps(document, material, &maps, error);
    if (result) return result;
    record->alpha_mode = (uint32_t)maps.alpha_mode;
    record->alpha_cutoff = maps.alpha_cutoff;
    record->normal_strength = maps.normal.strength;
    record->base_map = pack_image(pack, images, &maps.base_color);
    record->normal_map = pack_image(pack, images, &maps.normal);
    copy_sampler(&maps.base_color, record->base_wrap, record->base_filter);
    copy_sampler(&maps.normal, record->normal_wrap, record->normal_filter);
    return pack_texcoords(document, mesh, &maps, pack, record, error);
}

/* White where no material says otherwise; only glTF has sides. */
static void set_colour(const norma_material_info *material, int gltf, view_pack_mesh *record) {
    for (int i = 0; i < 4; ++i) record->colour[i] = 1;
    record->double_sided = !gltf;
    if (!material) return;
    memcpy(record->colour, material->base_color, sizeof record->colour);
    record->double_sided = !gltf || material->double_sided;
    record->has_material = (uint32_t)gltf;
    record->unlit = material->unlit != 0;
}

norma_document_result view_pack_material(norma_document *document, size_t mesh,
    const uint32_t *vertices, view_pack_images *images, view_pack *pack, view_pack_mesh *record,
    norma_document_error *error) {
    const int gltf = norma_file_format_is_gltf(norma_document_format(document));
    norma_mesh_attributes attributes;
    norma_material_info material;
    record->base_map = record->normal_map = record->texcoords = record->tangents = record->colours =
        VIEW_PACK_NONE;
    norma_document_result result =
        norma_document_mesh_attributes(document, mesh, &attributes, NULL);
    const int known = !result && attributes.material != SIZE_MAX &&
                      !norma_document_material_info(document, attributes.material, &material);
    set_colour(known ? &material : NULL, gltf, record);
    pack_name(document, mesh, known ? &material : NULL, pack, record);
    if (!result && attributes.colors) pack_colours(attributes.colors, vertices, pack, record);
    if (result || vertices || !gltf)
        return result == NORMA_DOCUMENT_ERROR_MEMORY ? result : NORMA_DOCUMENT_OK;
    if (attributes.tangent_count >= record->position_count)
        record->tangents =
            view_pack_append(pack, attributes.tangents, record->position_count, 4 * sizeof(float));
    return known ? pack_maps(document, mesh, attributes.material, images, pack, record, error)
                 : NORMA_DOCUMENT_OK;
}
