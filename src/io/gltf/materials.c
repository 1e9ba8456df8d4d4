/* materials.c: materials, their textures and images. */
#include "io/gltf/gltf.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* ---- The images that a material shows: its base colour and its normal map, as the
 * file has them (PNG, JPEG), with where and how they are looked up (KHR_texture_transform,
 * samplers). What cannot be read is named and not refused: the surface is drawn without it. */

typedef struct gltf_image { /* its bytes live as long as the document */
    const unsigned char *bytes;
    size_t size;
    const char *not_read;
    int looked_at;
    uint64_t device, file; /* of one of its own: several images may name it */
} gltf_image;

static int fail_image(gltf_image *image, const char *why) {
    image->not_read = why;
    return 1;
}

/* What follows returns 0 when out of memory: that is no fault of the image. */
static int keep_bytes(gltf *g, gltf_image *image, const unsigned char *bytes, size_t size) {
    unsigned char *kept = norma_scene_allocate(g->document->scene, size, 1);
    if (!kept) return 0;
    memcpy(kept, bytes, size);
    image->bytes = kept;
    image->size = size;
    return 1;
}

static int load_image_data(gltf *g, gltf_image *image, const char *uri) {
    size_t size = 0;
    errno = 0;
    unsigned char *bytes =
        norma_gltf_data_decode(uri, strlen(uri), norma_document_watch(g->document), &size);
    if (!bytes) return errno != ENOMEM && fail_image(image, "its data: URI cannot be decoded");
    const int kept = keep_bytes(g, image, bytes, size);
    free(bytes);
    return kept;
}

/* Whether an image that was read before is the same file: its bytes are then this one's. */
static int share_file(gltf *g, gltf_image *image, const struct stat *status) {
    const gltf_image *images = norma_gltf_scene_of(g)->images;
    image->device = (uint64_t)status->st_dev;
    image->file = (uint64_t)status->st_ino;
    for (const gltf_image *other = images; other < image; ++other)
        if (other->bytes && other->file == image->file && other->device == image->device &&
            other->file) {
            image->bytes = other->bytes;
            image->size = other->size;
            return 1;
        }
    return 0;
}

static int load_image_file(gltf *g, gltf_image *image, const char *uri) {
    file_bytes file;
    struct stat status;
    errno = 0;
    char *name = norma_gltf_uri_decode(uri), *path = NULL;
    const int inside = name && norma_gltf_path_inside(g->document->folder, name, &path);
    free(name);
    if (!inside)
        return errno != ENOMEM && fail_image(image, "it is not a file in the asset's folder");
    const int regular = stat(path, &status) == 0 && S_ISREG(status.st_mode),
              shared = regular && share_file(g, image, &status),
              failed = shared     ? 0
                       : !regular ? EINVAL
                                  : norma_document_load_file(g->document, path, &file);
    free(path);
    if (shared) return 1;
    if (failed) return failed != ENOMEM && fail_image(image, "its file cannot be read");
    const int kept = keep_bytes(g, image, file.data, file.size);
    norma_file_close(&file);
    return kept;
}

static int load_view(gltf *g, gltf_image *image, uint32_t token) {
    uint64_t view;
    norma_document_result result = NORMA_DOCUMENT_ERROR_MALFORMED;
    if (norma_json_uint(&g->json, token, &view) && view < g->view_count)
        result = norma_gltf_view_bytes(g, (uint32_t)view, &image->bytes, NULL);
    if (result)
        return result != NORMA_DOCUMENT_ERROR_MEMORY &&
               fail_image(image, "its bytes cannot be read");
    image->size = g->views[view].length;
    return 1;
}

static int load_image(gltf *g, gltf_image *image, uint32_t token) {
    const uint32_t view = norma_json_member(&g->json, token, "bufferView"),
                   uri = norma_json_member(&g->json, token, "uri");
    if (view != JSON_NONE) return load_view(g, image, view);
    if (!norma_json_is(&g->json, uri, JSON_STRING)) return fail_image(image, "it names no image");
    char *text = norma_json_string(&g->json, uri);
    if (!text) return 0;
    const int good = norma_gltf_uri_is_data(text) ? load_image_data(g, image, text)
                                                  : load_image_file(g, image, text);
    free(text);
    return good;
}

/* ---- textures */

static uint32_t element(const gltf *g, const char *list, uint32_t number_token) {
    const json *j = &g->json;
    uint64_t number;
    const uint32_t array = norma_json_member(j, 0, list);
    if (number_token == JSON_NONE || !norma_json_uint(j, number_token, &number) ||
        !norma_json_is(j, array, JSON_ARRAY) || number >= norma_json_size(j, array))
        return JSON_NONE;
    uint32_t item = norma_json_first(j, array);
    for (; number > 0 && item != JSON_NONE; --number) item = norma_json_next(j, array, item);
    return item;
}

static void read_int(const gltf *g, uint32_t object, const char *key, int *value) {
    uint64_t number;
    const uint32_t token = norma_json_member(&g->json, object, key);
    if (token != JSON_NONE && norma_json_uint(&g->json, token, &number) && number < 1 << 16)
        *value = (int)number;
}

static void read_texture_sampler(const gltf *g, uint32_t texture, norma_texture_info *info) {
    const uint32_t sampler =
        element(g, "samplers", norma_json_member(&g->json, texture, "sampler"));
    read_int(g, sampler, "wrapS", &info->wrap_s);
    read_int(g, sampler, "wrapT", &info->wrap_t);
    read_int(g, sampler, "magFilter", &info->mag_filter);
    read_int(g, sampler, "minFilter", &info->min_filter);
}

static int read_image(gltf *g, uint32_t texture, norma_texture_info *info) {
    const json *j = &g->json;
    gltf_scene *scene = norma_gltf_scene_of(g);
    const uint32_t list = norma_json_member(j, 0, "images"),
                   source = norma_json_member(j, texture, "source"),
                   token = element(g, "images", source);
    uint64_t number;
    if (token == JSON_NONE || !norma_json_uint(j, source, &number)) {
        info->not_read = texture == JSON_NONE  ? "its texture is not in the file"
                         : source == JSON_NONE ? "its image is in a format that is not read"
                                               : "it names no image";
        return 1;
    }
    if (!scene->images && !(scene->images = norma_scene_allocate(g->document->scene,
                                norma_json_size(j, list), sizeof *scene->images)))
        return 0;
    gltf_image *image = &scene->images[number];
    const given_image *given = norma_document_given_image(g->document, (size_t)number);
    if (given) *image = (gltf_image){given->bytes, given->size, NULL, 1, 0, 0};
    if (!image->looked_at && !load_image(g, image, token)) return 0;
    image->looked_at = 1;
    info->bytes = image->bytes;
    info->size = image->size;
    info->not_read = image->not_read;
    info->image = (size_t)number;
    return 1;
}

/* ---- Materials as far as they bear on normals: both sides or one, lit or not, opaque or
 * not, a normal map or none; and the colour for who draws them. A member of a wrong type is as one
 * that is not there: what a material says is never a reason to refuse a mesh. */

static void read_material_floats(const gltf *g, uint32_t list, size_t count, float *out) {
    const json *j = &g->json;
    size_t i = 0;
    double number;
    if (!norma_json_is(j, list, JSON_ARRAY)) return;
    for (uint32_t item = norma_json_first(j, list); item != JSON_NONE && i < count;
         item = norma_json_next(j, list, item), ++i)
        if (norma_json_number(j, item, &number)) out[i] = (float)number;
}

static void read_float(const gltf *g, uint32_t token, float *out) {
    double number;
    if (token != JSON_NONE && norma_json_number(&g->json, token, &number)) *out = (float)number;
}

/* Of a texture's info; KHR_texture_transform may name another set. */
static size_t map_texcoord_of(const gltf *g, uint32_t texture) {
    const json *j = &g->json;
    uint32_t transform =
        norma_json_member(j, norma_json_member(j, texture, "extensions"), "KHR_texture_transform");
    uint32_t set = norma_json_member(j, transform, "texCoord");
    uint64_t number = 0;
    if (set == JSON_NONE) set = norma_json_member(j, texture, "texCoord");
    return set != JSON_NONE && norma_json_uint(j, set, &number) && number <= UINT32_MAX
               ? (size_t)number
               : 0;
}

static norma_texture_info gltf_texture_place(const gltf *g, uint32_t texture) {
    const json *j = &g->json;
    norma_texture_info place = {.scale = {1, 1},
        .strength = 1,
        .wrap_s = 10497,
        .wrap_t = 10497,
        .image = SIZE_MAX,
        .there = norma_json_is(j, texture, JSON_OBJECT)};
    if (!place.there) return place;
    place.texcoord = map_texcoord_of(g, texture);
    const uint32_t transform =
        norma_json_member(j, norma_json_member(j, texture, "extensions"), "KHR_texture_transform");
    read_material_floats(g, norma_json_member(j, transform, "offset"), 2, place.offset);
    read_material_floats(g, norma_json_member(j, transform, "scale"), 2, place.scale);
    read_float(g, norma_json_member(j, transform, "rotation"), &place.rotation);
    return place;
}

/* 0: out of memory. */
static int read_texture(gltf *g, uint32_t use, norma_texture_info *info) {
    const json *j = &g->json;
    *info = gltf_texture_place(g, use);
    if (!info->there) return 1;
    const uint32_t texture = element(g, "textures", norma_json_member(j, use, "index")),
                   strength = norma_json_member(j, use, "scale");
    double number;
    if (strength != JSON_NONE && norma_json_number(j, strength, &number))
        info->strength = (float)number;
    read_texture_sampler(g, texture, info);
    return read_image(g, texture, info);
}

static int read_maps(gltf *g, uint32_t material, norma_material_maps *maps) {
    const json *j = &g->json;
    const uint32_t metallic = norma_json_member(j, material, "pbrMetallicRoughness"),
                   glossy = norma_json_member(j, norma_json_member(j, material, "extensions"),
                       "KHR_materials_pbrSpecularGlossiness"),
                   mode = norma_json_member(j, material, "alphaMode"),
                   cutoff = norma_json_member(j, material, "alphaCutoff");
    double number;
    if (norma_json_equals(j, mode, "MASK")) maps->alpha_mode = NORMA_ALPHA_MASK;
    if (norma_json_equals(j, mode, "BLEND")) maps->alpha_mode = NORMA_ALPHA_BLEND;
    if (cutoff != JSON_NONE && norma_json_number(j, cutoff, &number))
        maps->alpha_cutoff = (float)number;
    uint32_t colour = norma_json_member(j, glossy, "diffuseTexture");
    if (glossy == JSON_NONE) colour = norma_json_member(j, metallic, "baseColorTexture");
    return read_texture(g, colour, &maps->base_color) &&
           read_texture(g, norma_json_member(j, material, "normalTexture"), &maps->normal);
}

static uint32_t material_token(const gltf *g, size_t material) {
    const uint32_t list = norma_json_member(&g->json, 0, "materials");
    uint32_t token = norma_json_first(&g->json, list);
    for (size_t i = 0; i < material; ++i) token = norma_json_next(&g->json, list, token);
    return token;
}

norma_document_result norma_gltf_material_maps(norma_document *document, size_t material,
    norma_material_maps *maps, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    return norma_gltf_scene_of(g) && read_maps(g, material_token(g, material), maps)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(document, error);
}

norma_document_result norma_gltf_normal_texture(norma_document *document, size_t material,
    norma_texture_info *map, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    const uint32_t use = norma_gltf_normal_use(g, material_token(g, material));
    return norma_gltf_scene_of(g) && read_texture(g, use, map)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(document, error);
}

static void read_color(
    const gltf *g, uint32_t material, uint32_t extensions, norma_material_info *info) {
    const json *j = &g->json;
    const uint32_t metallic = norma_json_member(j, material, "pbrMetallicRoughness"),
                   glossy = norma_json_member(j, extensions, "KHR_materials_pbrSpecularGlossiness");
    read_material_floats(g, norma_json_member(j, metallic, "baseColorFactor"), 4, info->base_color);
    read_material_floats(g, norma_json_member(j, glossy, "diffuseFactor"), 4, info->base_color);
}

static int lets_light_through(const gltf *g, uint32_t material, uint32_t extensions) {
    const json *j = &g->json;
    uint32_t mode = norma_json_member(j, material, "alphaMode");
    float transmission = 0, diffuse = 0;
    read_float(g,
        norma_json_member(j, norma_json_member(j, extensions, "KHR_materials_transmission"),
            "transmissionFactor"),
        &transmission);
    read_float(g,
        norma_json_member(j, norma_json_member(j, extensions, "KHR_materials_diffuse_transmission"),
            "diffuseTransmissionFactor"),
        &diffuse);
    return norma_json_equals(j, mode, "MASK") || norma_json_equals(j, mode, "BLEND") ||
           transmission > 0 || diffuse > 0;
}

uint32_t norma_gltf_normal_use(const gltf *g, uint32_t material) {
    const json *j = &g->json;
    const uint32_t extensions = norma_json_member(j, material, "extensions"),
                   texture = norma_json_member(j, material, "normalTexture");
    return texture != JSON_NONE
               ? texture
               : norma_json_member(j, norma_json_member(j, extensions, "KHR_materials_clearcoat"),
                     "clearcoatNormalTexture");
}

norma_texture_info norma_gltf_normal_map(const gltf *g, uint32_t material) {
    return gltf_texture_place(g, norma_gltf_normal_use(g, material));
}

int norma_gltf_moves(const norma_texture_info *place) {
    return place->offset[0] != 0 || place->offset[1] != 0 || place->scale[0] != 1 ||
           place->scale[1] != 1 || place->rotation != 0;
}

void norma_texture_place(const norma_texture_info *info, const float *texcoords, size_t count,
    size_t stride, float *placed) {
    double c, s;
    norma_gltf_turn((double)info->rotation, &c, &s);
    for (size_t i = 0; i < count; ++i) {
        const double x = (double)info->scale[0] * (double)texcoords[2 * i],
                     y = (double)info->scale[1] * (double)texcoords[2 * i + 1];
        placed[stride * i] = (float)(c * x + s * y + (double)info->offset[0]);
        placed[stride * i + 1] = (float)(c * y - s * x + (double)info->offset[1]);
    }
}

static void read_normal_map(const gltf *g, uint32_t material, norma_material_info *info) {
    const norma_texture_info place = norma_gltf_normal_map(g, material);
    info->normal_map = place.there;
    info->normal_texcoord = place.texcoord;
    if (!norma_gltf_moves(&place)) return;
    double c, s;
    norma_gltf_turn((double)place.rotation, &c, &s);
    info->normal_turn[0] = (float)(c * (double)place.scale[0]);
    info->normal_turn[1] = (float)(s * (double)place.scale[1]);
    info->normal_turn[2] = (float)(-s * (double)place.scale[0]);
    info->normal_turn[3] = (float)(c * (double)place.scale[1]);
}

/* Whether nothing of the light reaches it. What is unlit for readers that know no better, and lit
 * for those of VRM avatars (their MToon shader), is lit: it needs its normals. */
static int is_unlit(const gltf *g, uint32_t extensions, uint32_t avatar) {
    const json *j = &g->json;
    int toon = norma_json_member(j, extensions, "VRMC_materials_mtoon") != JSON_NONE ||
               norma_json_equals(j, norma_json_member(j, avatar, "shader"), "VRM/MToon");
    return norma_json_member(j, extensions, "KHR_materials_unlit") != JSON_NONE && !toon;
}

/* avatar: what VRM says of it, or JSON_NONE. */
static int read_gltf_material(
    gltf *g, uint32_t token, uint32_t avatar, size_t number, norma_material_info *info) {
    const json *j = &g->json;
    uint32_t extensions = norma_json_member(j, token, "extensions");
    *info = (norma_material_info){.base_color = {1, 1, 1, 1}};
    info->name = norma_gltf_name(g, token);
    info->where = norma_gltf_where(g, "materials", number);
    info->ignore = norma_gltf_ignore(g, token);
    info->double_sided = norma_json_is(j, norma_json_member(j, token, "doubleSided"), JSON_TRUE);
    info->unlit = is_unlit(g, extensions, avatar);
    info->not_opaque = lets_light_through(g, token, extensions);
    read_color(g, token, extensions, info);
    read_normal_map(g, token, info);
    return info->name && info->where && info->ignore;
}

norma_document_result norma_gltf_materials(norma_document *document, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    uint32_t list = norma_json_member(&g->json, 0, "materials");
    size_t count = norma_json_is(&g->json, list, JSON_ARRAY) ? norma_json_size(&g->json, list) : 0,
           number = 0;
    norma_material_info *materials = norma_scene_allocate(scene, count, sizeof *materials);
    if (!materials) return norma_document_fail_memory(document, error);
    uint32_t vrm = norma_json_member(&g->json, norma_json_member(&g->json, 0, "extensions"), "VRM"),
             avatars = norma_json_member(&g->json, vrm, "materialProperties");
    uint32_t avatar = norma_json_is(&g->json, avatars, JSON_ARRAY)
                          ? norma_json_first(&g->json, avatars)
                          : JSON_NONE;
    for (uint32_t item = norma_json_first(&g->json, list); number < count;
         item = norma_json_next(&g->json, list, item), ++number) {
        if (!read_gltf_material(g, item, avatar, number, &materials[number]))
            return norma_document_fail_memory(document, error);
        avatar = avatar == JSON_NONE ? JSON_NONE : norma_json_next(&g->json, avatars, avatar);
    }
    scene->materials = materials;
    scene->material_count = count;
    return NORMA_DOCUMENT_OK;
}
