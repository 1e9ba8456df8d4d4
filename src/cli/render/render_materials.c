/* render_materials.c: what a surface's material makes it look like: its colour, its images, which
 * of its sides are there, what lets light through. */
#include "cli/render/render_scene.h"
#include <stdlib.h>
#include <string.h>

/* Linear; mid-grey, so that light and shade both show. Whatever has no material of its own, too. */
static const float clay[3] = {0.55F, 0.53F, 0.48F};

/* ---- images, each decoded once for a file */

struct render_file_image {
    size_t number; /* in the file */
    render_picture picture;
};

/* What cannot be drawn is named in the picture, and in a note with the reason. */
static void leave_image(render_scene_file *file, const char *list, size_t number, const char *why) {
    char name[48];
    snprintf(name, sizeof name, "/%s/%zu", list, number);
    ++file->images_left_out;
    render_add_name(file->left_out_names, sizeof file->left_out_names, name);
    render_file_note(file, "%s is not drawn: %.300s", name, why);
}

/* A picture without pixels: it could not be decoded. NULL: out of memory. */
static const render_picture *picture_of(render_scene_file *file, const norma_texture_info *info) {
    for (size_t i = 0; i < file->image_count; ++i)
        if (file->images[i]->number == info->image) return &file->images[i]->picture;
    struct render_file_image **list = realloc(file->images, (file->image_count + 1) * sizeof *list);
    if (list) file->images = list;
    struct render_file_image *made = list ? calloc(1, sizeof *made) : NULL;
    if (!made) return NULL;
    render_error why = {.message = "it has no bytes"};
    made->number = info->image;
    if (info->bytes) render_image_decode(info->bytes, info->size, &made->picture, &why);
    if (!made->picture.pixels)
        leave_image(file, "images", info->image, info->not_read ? info->not_read : why.message);
    if (!render_file_keep(file, made) ||
        (made->picture.pixels && !render_file_keep(file, made->picture.pixels)))
        return NULL;
    file->images[file->image_count++] = made;
    return &made->picture;
}

/* ---- texture coordinates, as they are looked up */

static norma_document_result read_texcoords(render_scene_file *file, size_t mesh,
    const norma_texture_info *info, render_texture *map, norma_document_error *error) {
    const float *texcoords = NULL;
    size_t count = 0;
    norma_document_result result =
        norma_document_texcoords(file->document, mesh, info->texcoord, &texcoords, &count, error);
    if (result || !texcoords) return result;
    float *placed = malloc((2 * count + 1) * sizeof *placed);
    if (!placed || !render_file_keep(file, placed))
        return render_file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
    norma_texture_place(info, texcoords, count, 2, placed);
    map->texcoords = placed;
    return NORMA_DOCUMENT_OK;
}

typedef struct surface_of { /* numbers in the document */
    size_t mesh, material;
} surface_of;

/* Without coordinates, or with an image that cannot be read, the surface is drawn without it. */
static norma_document_result set_map(render_scene_file *file, const surface_of *of,
    const norma_texture_info *info, render_texture *map, norma_document_error *error) {
    if (!info->there) return NORMA_DOCUMENT_OK;
    *map = (render_texture){.wrap_s = info->wrap_s,
        .wrap_t = info->wrap_t,
        .mag_filter = info->mag_filter,
        .min_filter = info->min_filter};
    norma_document_result result = read_texcoords(file, of->mesh, info, map, error);
    if (result || !map->texcoords) return result;
    if (info->image == SIZE_MAX) {
        leave_image(
            file, "materials", of->material, info->not_read ? info->not_read : "it names no image");
        return NORMA_DOCUMENT_OK;
    }
    const render_picture *picture = picture_of(file, info);
    if (!picture)
        return render_file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
    if (picture->pixels) map->picture = picture;
    return NORMA_DOCUMENT_OK;
}

/* ---- materials */

static norma_document_result set_maps(const render_settings *settings, render_scene_file *file,
    size_t mesh, size_t material, render_surface *surface, norma_document_error *error) {
    norma_material_maps maps;
    norma_document_result result =
        norma_document_material_maps(file->document, material, &maps, error);
    if (result) return result;
    if (settings->show == RENDER_SHOW_TANGENTS)
        return maps.normal.there
                   ? read_texcoords(file, mesh, &maps.normal, &surface->normal_map, error)
                   : NORMA_DOCUMENT_OK;
    if (settings->show != RENDER_SHOW_LIT || settings->clay) return NORMA_DOCUMENT_OK;
    surface->alpha_cutoff = maps.alpha_mode == NORMA_ALPHA_MASK ? maps.alpha_cutoff : 0;
    surface->blends = maps.alpha_mode == NORMA_ALPHA_BLEND;
    surface->normal_strength = maps.normal.strength;
    const surface_of of = {mesh, material};
    result = set_map(file, &of, &maps.base_color, &surface->base_map, error);
    return result ? result : set_map(file, &of, &maps.normal, &surface->normal_map, error);
}

static void set_colours(const norma_mesh_attributes *attributes,
    const norma_material_info *material, render_surface *surface) {
    surface->colours = attributes->colors;
    if (attributes->colors)
        for (int k = 0; k < 3; ++k) surface->base_colour[k] = 1;
    if (!material) return;
    memcpy(surface->base_colour, material->base_color, sizeof surface->base_colour);
    surface->alpha = material->base_color[3];
    surface->unlit = material->unlit;
}

norma_document_result render_file_set_material(const render_settings *settings,
    render_scene_file *file, size_t mesh, const norma_mesh_attributes *attributes,
    render_surface *surface, norma_document_error *error) {
    static const norma_texture_info plain = {.scale = {1, 1}};
    norma_material_info material;
    const int gltf = norma_document_format(file->document) >= NORMA_FILE_GLTF;
    const int known =
        gltf && attributes->material != SIZE_MAX &&
        !norma_document_material_info(file->document, attributes->material, &material);
    memcpy(surface->base_colour, clay, sizeof clay);
    surface->alpha = 1;
    surface->two_sided = gltf ? known && material.double_sided : 1; /* only glTF has sides */
    if (surface->stored == RENDER_NORMALS_PER_VERTEX &&
        attributes->tangent_count >= surface->mesh.positions.count)
        surface->tangents = attributes->tangents;
    if (!settings->clay) set_colours(attributes, known ? &material : NULL, surface);
    norma_document_result result =
        known ? set_maps(settings, file, mesh, attributes->material, surface, error)
              : NORMA_DOCUMENT_OK;
    if (!result && settings->show == RENDER_SHOW_TANGENTS && !surface->normal_map.texcoords)
        result = read_texcoords(file, mesh, &plain, &surface->normal_map, error);
    file->with_tangents += surface->tangents != NULL;
    file->with_texcoords += surface->normal_map.texcoords != NULL;
    return result;
}
