/* gltf_scene.c: what a glTF's surfaces have beside positions, corners and normals: UVs, colours,
 * tangents, materials and their maps, morph targets, the rules that extras silence, where a node
 * stands, and what of the file was not read. */
#include "core/matrix/matrix.h"
#include "io/gltf/gltf.h"
#include <errno.h>
#include <stdio.h>
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
    const char *name; /* for people; NULL: none */
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
    const uint32_t view = norma_gltf_number(g, token, g->view_count);
    const norma_document_result result = view == GLTF_NONE
                                             ? NORMA_DOCUMENT_ERROR_MALFORMED
                                             : norma_gltf_view_bytes(g, view, &image->bytes, NULL);
    if (result)
        return result != NORMA_DOCUMENT_ERROR_MEMORY &&
               fail_image(image, "its bytes cannot be read");
    image->size = g->views[view].length;
    return 1;
}

/* Its file, or what it is called. */
static int name_image(gltf *g, gltf_image *image, uint32_t token) {
    static const char *const keys[] = {"uri", "name"};
    for (size_t i = 0; i < 2 && !image->name; ++i) {
        const uint32_t value = norma_json_member(&g->json, token, keys[i]);
        char *text =
            norma_json_is(&g->json, value, JSON_STRING) ? norma_json_string(&g->json, value) : NULL;
        if (!text || norma_gltf_uri_is_data(text) || !*text) {
            free(text);
            continue;
        }
        char *kept = norma_scene_allocate(g->document->scene, strlen(text) + 1, 1);
        if (kept) strcpy(kept, text);
        free(text);
        if (!kept) return 0;
        image->name = kept;
    }
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

/* The cosine and the sine of any finite angle; the larger it is, the fewer of its digits count. */
static void gltf_turn(double angle, double *cosine, double *sine) {
    const double size = fabs(angle), quarters = floor(size / (NORMA_PI / 2)),
                 rest = fmin(fmax(size - quarters * (NORMA_PI / 2), 0), NORMA_PI / 2);
    const double near = norma_gltf_sine(rest), far = norma_gltf_sine(NORMA_PI / 2 - rest);
    const int quarter = (int)(quarters - 4 * floor(quarters / 4)), odd = quarter & 1;
    *cosine = (quarter == 1 || quarter == 2 ? -1 : 1) * (odd ? near : far);
    *sine = (quarter >= 2 ? -1 : 1) * (odd ? far : near) * (angle < 0 ? -1 : 1);
}

static uint32_t element(const gltf *g, const char *list, uint32_t number_token) {
    const uint32_t array = norma_json_member(&g->json, 0, list),
                   number = norma_gltf_number(g, number_token, norma_json_size(&g->json, array));
    return number == GLTF_NONE ? JSON_NONE : norma_json_element(&g->json, array, number);
}

static void read_int(const gltf *g, uint32_t object, const char *key, int *value) {
    const uint32_t number = norma_gltf_number(g, norma_json_member(&g->json, object, key), 1 << 16);
    if (number != GLTF_NONE) *value = (int)number;
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
    if (!image->looked_at && !name_image(g, image, token)) return 0;
    if (given)
        *image = (gltf_image){
            .bytes = given->bytes, .size = given->size, .name = image->name, .looked_at = 1};
    if (!image->looked_at && !load_image(g, image, token)) return 0;
    image->looked_at = 1;
    info->bytes = image->bytes;
    info->size = image->size;
    info->not_read = image->not_read;
    info->name = image->name;
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
    for (uint32_t item = JSON_NONE; i < count && norma_json_each(j, list, &item); ++i)
        if (norma_json_number(j, item, &number)) out[i] = (float)number;
}

static void read_float(const gltf *g, uint32_t token, float *out) {
    double number;
    if (token != JSON_NONE && norma_json_number(&g->json, token, &number)) *out = (float)number;
}

/* Of a texture's info; KHR_texture_transform may name another set of coordinates. */
static norma_texture_info gltf_texture_place(const gltf *g, uint32_t texture) {
    const json *j = &g->json;
    norma_texture_info place = {.scale = {1, 1},
        .strength = 1,
        .wrap_s = 10497,
        .wrap_t = 10497,
        .image = SIZE_MAX,
        .there = norma_json_is(j, texture, JSON_OBJECT)};
    if (!place.there) return place;
    const uint32_t transform = norma_gltf_extension(g, texture, "KHR_texture_transform"),
                   other = norma_json_member(j, transform, "texCoord"),
                   set = other != JSON_NONE ? other : norma_json_member(j, texture, "texCoord");
    uint64_t number;
    if (set != JSON_NONE && norma_json_uint(j, set, &number) && number <= UINT32_MAX)
        place.texcoord = (size_t)number;
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
    const uint32_t texture = element(g, "textures", norma_json_member(j, use, "index"));
    read_float(g, norma_json_member(j, use, "scale"), &info->strength);
    read_texture_sampler(g, texture, info);
    return read_image(g, texture, info);
}

static int read_maps(gltf *g, uint32_t material, norma_material_maps *maps) {
    const json *j = &g->json;
    const uint32_t metallic = norma_json_member(j, material, "pbrMetallicRoughness"),
                   glossy =
                       norma_gltf_extension(g, material, "KHR_materials_pbrSpecularGlossiness"),
                   mode = norma_json_member(j, material, "alphaMode");
    if (norma_json_equals(j, mode, "MASK")) maps->alpha_mode = NORMA_ALPHA_MASK;
    if (norma_json_equals(j, mode, "BLEND")) maps->alpha_mode = NORMA_ALPHA_BLEND;
    read_float(g, norma_json_member(j, material, "alphaCutoff"), &maps->alpha_cutoff);
    uint32_t colour = norma_json_member(j, glossy, "diffuseTexture");
    if (glossy == JSON_NONE) colour = norma_json_member(j, metallic, "baseColorTexture");
    return read_texture(g, colour, &maps->base_color) &&
           read_texture(g, norma_json_member(j, material, "normalTexture"), &maps->normal);
}

static norma_document_result gltf_material_maps(norma_document *document, size_t material,
    norma_material_maps *maps, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    return norma_gltf_scene_of(g) && read_maps(g, norma_gltf_material(g, material), maps)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(document, error);
}

norma_document_result norma_gltf_normal_texture(norma_document *document, size_t material,
    norma_texture_info *map, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    return norma_gltf_scene_of(g) &&
                   read_texture(g, norma_gltf_normal_use(g, norma_gltf_material(g, material)), map)
               ? NORMA_DOCUMENT_OK
               : norma_document_fail_memory(document, error);
}

static void read_color(const gltf *g, uint32_t material, norma_material_info *info) {
    const json *j = &g->json;
    const uint32_t metallic = norma_json_member(j, material, "pbrMetallicRoughness"),
                   glossy =
                       norma_gltf_extension(g, material, "KHR_materials_pbrSpecularGlossiness");
    read_material_floats(g, norma_json_member(j, metallic, "baseColorFactor"), 4, info->base_color);
    read_material_floats(g, norma_json_member(j, glossy, "diffuseFactor"), 4, info->base_color);
}

static int lets_light_through(const gltf *g, uint32_t material) {
    const json *j = &g->json;
    const uint32_t mode = norma_json_member(j, material, "alphaMode"),
                   clear = norma_gltf_extension(g, material, "KHR_materials_transmission"),
                   thin = norma_gltf_extension(g, material, "KHR_materials_diffuse_transmission");
    float transmission = 0, diffuse = 0;
    read_float(g, norma_json_member(j, clear, "transmissionFactor"), &transmission);
    read_float(g, norma_json_member(j, thin, "diffuseTransmissionFactor"), &diffuse);
    return norma_json_equals(j, mode, "MASK") || norma_json_equals(j, mode, "BLEND") ||
           transmission > 0 || diffuse > 0;
}

uint32_t norma_gltf_normal_use(const gltf *g, uint32_t material) {
    const uint32_t texture = norma_json_member(&g->json, material, "normalTexture");
    return texture != JSON_NONE ? texture
                                : norma_json_member(&g->json,
                                      norma_gltf_extension(g, material, "KHR_materials_clearcoat"),
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
    gltf_turn((double)info->rotation, &c, &s);
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
    gltf_turn((double)place.rotation, &c, &s);
    info->normal_turn[0] = (float)(c * (double)place.scale[0]);
    info->normal_turn[1] = (float)(s * (double)place.scale[1]);
    info->normal_turn[2] = (float)(-s * (double)place.scale[0]);
    info->normal_turn[3] = (float)(c * (double)place.scale[1]);
}

/* Whether nothing of the light reaches it. What is unlit for readers that know no better, and lit
 * for those of VRM avatars (their MToon shader), is lit: it needs its normals. */
static int is_unlit(const gltf *g, uint32_t material, uint32_t avatar) {
    const json *j = &g->json;
    int toon = norma_gltf_extension(g, material, "VRMC_materials_mtoon") != JSON_NONE ||
               norma_json_equals(j, norma_json_member(j, avatar, "shader"), "VRM/MToon");
    return norma_gltf_extension(g, material, "KHR_materials_unlit") != JSON_NONE && !toon;
}

/* avatar: what VRM says of it, or JSON_NONE. */
static int read_gltf_material(
    gltf *g, uint32_t token, uint32_t avatar, size_t number, norma_material_info *info) {
    const json *j = &g->json;
    *info = (norma_material_info){.base_color = {1, 1, 1, 1}};
    info->name = norma_gltf_name(g, token);
    info->where = norma_gltf_where(g, "materials", number);
    info->ignore = norma_gltf_ignore(g, token);
    info->double_sided = norma_json_is(j, norma_json_member(j, token, "doubleSided"), JSON_TRUE);
    info->unlit = is_unlit(g, token, avatar);
    info->not_opaque = lets_light_through(g, token);
    read_color(g, token, info);
    read_normal_map(g, token, info);
    return info->name && info->where && info->ignore;
}

static norma_document_result gltf_materials(norma_document *document, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    uint32_t list = norma_json_member(&g->json, 0, "materials");
    size_t count = norma_json_is(&g->json, list, JSON_ARRAY) ? norma_json_size(&g->json, list) : 0,
           number = 0;
    norma_material_info *materials = norma_scene_allocate(scene, count, sizeof *materials);
    if (!materials) return norma_document_fail_memory(document, error);
    uint32_t avatars =
        norma_json_member(&g->json, norma_gltf_extension(g, 0, "VRM"), "materialProperties");
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

/* ---- attributes */

/* A set of UVs that is there and is one; what is not, this library has no use for, and others will
 * say. */
static norma_document_result texcoords(norma_document *document, size_t mesh, size_t set,
    const float **coordinates, size_t *count, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    const uint32_t accessor = norma_gltf_texcoords(g, &g->primitives[mesh], set);
    *coordinates = NULL;
    *count = accessor == GLTF_NONE ? 0 : g->primitives[mesh].vertices;
    return *count ? norma_gltf_decode(g, accessor, 2, coordinates, error) : NORMA_DOCUMENT_OK;
}

static norma_document_result widen_colors(
    gltf *g, uint32_t accessor, const float **colors, norma_document_error *error) {
    gltf_array array;
    gltf_scene *scene = norma_gltf_scene_of(g);
    norma_document_result result = scene ? norma_gltf_array(g, accessor, &array, error)
                                         : norma_document_fail_memory(g->document, error);
    if (!result) result = norma_gltf_widen(g, accessor, &array, 4, &scene->colors[accessor], error);
    if (!result) *colors = scene->colors[accessor];
    return result;
}

static norma_document_result read_vertex_colors(gltf *g, const gltf_primitive *p,
    norma_mesh_attributes *attributes, norma_document_error *error) {
    const uint32_t accessor = norma_gltf_numbered(g, p, "COLOR", 0);
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
    norma_document_result result =
        texcoords(document, index, set, &attributes->texcoords, &attributes->texcoord_count, error);
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

/* From the nearest node above that is known, or a root: each node's extras are read once. */
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
    double matrix[16];
    if (result) return result;
    norma_gltf_instance_matrix(&instances, instance, matrix);
    norma_gltf_matrix_multiply(world, matrix, world);
    return NORMA_DOCUMENT_OK;
}

/* ---- Which parts of a glTF were not read, and why. */

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

/* Points and lines are no surface, so nothing is left out but normals that they have. */
static const char *why_in_part(const gltf *g, const gltf_primitive *p) {
    if (p->not_read && p->mode >= GLTF_TRIANGLES) return p->not_read;
    if (p->not_read && p->base.normal == GLTF_NONE) return NULL;
    if (p->not_read) return p->mode == GLTF_POINTS ? "normals of points" : "normals of lines";
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
    snprintf(texts, 120, "byte %zu", g->tile.begins + g->tile.at + g->container_size);
    snprintf(texts + 120, 120, "%zu bytes follow the end that the header declares", size);
    unread[(*count)++] = (norma_unread){texts, texts + 120};
    return 1;
}

/* Tiles of a composite beside the one that is read. 0: out of memory. */
static int add_tiles_left_out(gltf *g, norma_unread *unread, size_t *count) {
    const gltf_tile *tile = &g->tile;
    if (tile->left_out == 0) return 1;
    char *texts = norma_scene_allocate(g->document->scene, 2, sizeof(char[120]));
    if (!texts) return 0;
    snprintf(texts, 120, "byte %zu", tile->left_out_at);
    const int length = snprintf(texts + 120, 120, "this tile %s", tile->left_out_why);
    if (tile->left_out > 1)
        snprintf(texts + 120 + length, 120 - (size_t)length, "; tiles without a model besides: %zu",
            tile->left_out - 1);
    unread[(*count)++] = (norma_unread){texts, texts + 120};
    return 1;
}

static norma_document_result read_unread(norma_document *document, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_scene *scene = document->scene;
    uint32_t list = norma_json_member(&g->json, 0, "extensionsRequired"), number = 0;
    norma_unread *unread = norma_scene_allocate(
        scene, (size_t)norma_json_size(&g->json, list) + g->primitive_count + 4, sizeof *unread);
    size_t count = 0;
    if (!unread || !add_tail(g, unread, &count) || !add_tiles_left_out(g, unread, &count))
        return norma_document_fail_memory(document, error);
    if (g->tile.not_read) unread[count++] = (norma_unread){"instances", g->tile.not_read};
    if (norma_gltf_needs_later(g))
        unread[count++] =
            (norma_unread){"/asset/minVersion", "needs a later version of glTF than 2.0"};
    for (uint32_t item = JSON_NONE; norma_json_each(&g->json, list, &item); ++number) {
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
    .materials = gltf_materials,
    .attributes = read_vertex_attributes,
    .morph = read_morph,
    .skin_count = norma_gltf_skin_count,
    .skin = norma_gltf_skin,
    .unread = read_unread,
    .instance_world = gltf_instance_world,
    .tile_instance = norma_gltf_tile_instance,
    .move_drawn = norma_gltf_move_drawn,
    .material_maps = gltf_material_maps,
    .normal_map = norma_gltf_normal_texture,
    .texcoords = texcoords,
};
