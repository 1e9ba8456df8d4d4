/* requirements.c: what a file may ask of its reader: extensions, a later version. */
#include "io/gltf/gltf_scene.h"
#include "io/gltf/draco_decoder.h"
#include <string.h>

int norma_gltf_needs_later(const gltf *g) {
    uint32_t least =
        norma_json_member(&g->json, norma_json_member(&g->json, 0, "asset"), "minVersion");
    return least != JSON_NONE && !norma_json_equals(&g->json, least, "2.0");
}

/* What a file may require without a word in it changing what its meshes' numbers mean. */
int norma_gltf_is_known(const char *name) {
    static const char *const prefixes[] = {"KHR_materials_", "KHR_texture_", "KHR_lights_",
        "EXT_lights_", "EXT_texture_", "MSFT_texture_", "KHR_animation_", "KHR_audio_"};
    static const char *const names[] = {"KHR_mesh_quantization", "EXT_meshopt_compression",
        "KHR_meshopt_compression", "EXT_mesh_gpu_instancing", "KHR_xmp_json_ld", "KHR_xmp",
        "KHR_node_visibility", "KHR_node_selectability", "KHR_node_hoverability", "MSFT_lod", "VRM",
        "VRMC_vrm"};
    for (size_t i = 0; i < sizeof prefixes / sizeof prefixes[0]; ++i)
        if (strncmp(name, prefixes[i], strlen(prefixes[i])) == 0) return 1;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
        if (strcmp(name, names[i]) == 0) return 1;
    return norma_draco_reads() && strcmp(name, "KHR_draco_mesh_compression") == 0;
}
