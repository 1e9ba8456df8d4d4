/* bake_plan.c: what is known of nodes before any is baked: which are animated, joints, or carry
 * more than a mesh. */
#include "io/gltf/bake.h"
#include <stdlib.h>
#include <string.h>

uint32_t *norma_gltf_bake_order(const gltf *g, const gltf_tree *tree) {
    uint32_t *order = norma_io_allocate((size_t)g->node_count + 1, sizeof *order);
    uint32_t count = 0;
    for (uint32_t i = 0; order && i < g->node_count; i++)
        if (tree->nodes[i].parent == GLTF_NONE) order[count++] = i;
    for (uint32_t at = 0; order && at < count; at++)
        for (uint32_t child = tree->nodes[order[at]].first;
             child != GLTF_NONE && count < g->node_count; child = tree->nodes[child].after)
            order[count++] = child;
    return order;
}

static void flag_node(const gltf *g, unsigned char *flags, uint32_t token, unsigned flag) {
    uint64_t number;
    if (norma_json_uint(&g->json, token, &number) && number < g->node_count)
        flags[number] = (unsigned char)(flags[number] | flag);
}

/* KHR_animation_pointer: "/nodes/7/rotation". */
static void flag_pointer(const gltf *g, unsigned char *flags, uint32_t target) {
    const uint32_t extension = norma_json_member(
        &g->json, norma_json_member(&g->json, target, "extensions"), "KHR_animation_pointer");
    char *pointer = norma_json_string(&g->json, norma_json_member(&g->json, extension, "pointer"));
    if (pointer && strncmp(pointer, "/nodes/", 7) == 0) {
        char *end;
        const unsigned long number = strtoul(pointer + 7, &end, 10);
        if (end != pointer + 7 && number < g->node_count) {
            const int moves = strcmp(end, "/translation") == 0 || strcmp(end, "/rotation") == 0 ||
                              strcmp(end, "/scale") == 0 || strcmp(end, "/matrix") == 0;
            if (moves)
                flags[number] |= BAKE_MOVES;
            else if (strncmp(end, "/weights", 8) == 0)
                flags[number] |= BAKE_WEIGHTS;
        }
    }
    free(pointer);
}

static void flag_animations(const gltf *g, unsigned char *flags) {
    const json *j = &g->json;
    const uint32_t animations = norma_json_member(j, 0, "animations");
    for (uint32_t animation = norma_json_first(j, animations); animation != JSON_NONE;
         animation = norma_json_next(j, animations, animation)) {
        const uint32_t channels = norma_json_member(j, animation, "channels");
        for (uint32_t channel = norma_json_first(j, channels); channel != JSON_NONE;
             channel = norma_json_next(j, channels, channel)) {
            const uint32_t target = norma_json_member(j, channel, "target"),
                           path = norma_json_member(j, target, "path");
            if (norma_json_equals(j, path, "pointer"))
                flag_pointer(g, flags, target);
            else
                flag_node(g, flags, norma_json_member(j, target, "node"),
                    norma_json_equals(j, path, "weights") ? BAKE_WEIGHTS : BAKE_MOVES);
        }
    }
}

static void flag_skins(const gltf *g, unsigned char *flags) {
    const json *j = &g->json;
    const uint32_t skins = norma_json_member(j, 0, "skins");
    for (uint32_t skin = norma_json_first(j, skins); skin != JSON_NONE;
         skin = norma_json_next(j, skins, skin)) {
        const uint32_t joints = norma_json_member(j, skin, "joints");
        flag_node(g, flags, norma_json_member(j, skin, "skeleton"), BAKE_JOINT);
        for (uint32_t joint = norma_json_first(j, joints); joint != JSON_NONE;
             joint = norma_json_next(j, joints, joint))
            flag_node(g, flags, joint, BAKE_JOINT);
    }
}

/* Extensions of a node that say nothing about where it is. */
static const char *const placeless[] = {"EXT_mesh_gpu_instancing", "KHR_node_visibility",
    "KHR_node_selectability", "KHR_node_hoverability", "KHR_xmp_json_ld", "KHR_xmp"};

static int carries_more(const gltf *g, uint32_t node) {
    const json *j = &g->json;
    const uint32_t token = g->nodes[node].token,
                   extensions = norma_json_member(j, token, "extensions");
    if (norma_json_member(j, token, "camera") != JSON_NONE) return 1;
    for (uint32_t value = norma_json_first(j, extensions); value != JSON_NONE;
         value = norma_json_next(j, extensions, value)) {
        int harmless = 0;
        for (size_t i = 0; i < sizeof placeless / sizeof *placeless; i++)
            harmless |= norma_json_equals(j, value - 1, placeless[i]);
        if (!harmless) return 1;
    }
    return 0;
}

unsigned char *norma_gltf_bake_flags(const gltf *g, const uint32_t *order) {
    unsigned char *flags = norma_io_allocate((size_t)g->node_count + 1, 1);
    if (!flags) return NULL;
    flag_animations(g, flags);
    flag_skins(g, flags);
    for (uint32_t i = 0; i < g->node_count; i++) {
        const uint32_t node = order[i], parent = g->nodes[node].parent;
        if (carries_more(g, node)) flags[node] |= BAKE_CARRIES;
        if ((flags[node] & BAKE_MOVES) || (parent != GLTF_NONE && (flags[parent] & BAKE_MOVED)))
            flags[node] |= BAKE_MOVED;
    }
    return flags;
}

const char *norma_gltf_bake_obstacle(const gltf *g, uint32_t mesh) {
    for (uint32_t i = 0; i < g->meshes[mesh].primitive_count; i++) {
        const gltf_primitive *primitive = &g->primitives[g->meshes[mesh].first_primitive + i];
        const uint32_t extensions = norma_json_member(&g->json, primitive->token, "extensions");
        if (primitive->draco.token != GLTF_NONE && primitive->not_read)
            return "is compressed with KHR_draco_mesh_compression and cannot be read";
        if (norma_json_member(&g->json, extensions, "KHR_gaussian_splatting") != JSON_NONE)
            return "holds splats (KHR_gaussian_splatting)";
    }
    return NULL;
}
