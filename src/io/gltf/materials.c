/* materials.c: materials as far as they bear on normals: both sides or one, lit or not, opaque or
 * not, a normal map or none; and the colour for who draws them. A member of a wrong type is as one
 * that is not there: what a material says is never a reason to refuse a mesh. */
#include "io/gltf/gltf_scene.h"
#include "io/gltf/sine.h"
#include <string.h>

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

static void read_color(
    const gltf *g, uint32_t material, uint32_t extensions, norma_material_info *info) {
    const json *j = &g->json;
    uint32_t metallic = norma_json_member(j, material, "pbrMetallicRoughness");
    uint32_t glossy = norma_json_member(j, extensions, "KHR_materials_pbrSpecularGlossiness");
    float glossiness = 1;
    read_material_floats(g, norma_json_member(j, metallic, "baseColorFactor"), 4, info->base_color);
    read_float(g, norma_json_member(j, metallic, "metallicFactor"), &info->metallic);
    read_float(g, norma_json_member(j, metallic, "roughnessFactor"), &info->roughness);
    if (glossy == JSON_NONE) return;
    read_material_floats(g, norma_json_member(j, glossy, "diffuseFactor"), 4, info->base_color);
    read_float(g, norma_json_member(j, glossy, "glossinessFactor"), &glossiness);
    info->metallic = 0;
    info->roughness = 1 - glossiness;
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
    return norma_gltf_texture_place(g, norma_gltf_normal_use(g, material));
}

norma_texture_info norma_gltf_texture_place(const gltf *g, uint32_t texture) {
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
    *info = (norma_material_info){.base_color = {1, 1, 1, 1}, .metallic = 1, .roughness = 1};
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
