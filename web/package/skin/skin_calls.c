/* skin_calls.c: skin.wasm: skins for the npm package, in a module of their own. */
#include "norma/norma.h"
#include "../wasm/exports.h"
#include <stdlib.h>

static norma_skin skin;
static norma_fault fault;

void *WEB_EXPORT(web_reserve)(size_t bytes) { return malloc(bytes); }
void WEB_EXPORT(web_release)(void *block) { free(block); }

void WEB_EXPORT(skin_set)(const float *matrices, size_t joint_count, const void *joints,
    size_t joint_size, const float *weights, size_t influences, size_t vertex_count, int blend) {
    skin = (norma_skin){matrices, joint_count, joints, joint_size, weights, influences,
        vertex_count, (norma_blend)blend};
}

/* normals: those of the skinned vertices; NULL: in holds normals, or with positions, these. */
int WEB_EXPORT(skin_move)(const float *in, const float *normals, int positions, float *out) {
    const norma_vec3_view view = {in, skin.vertex_count, 0, NORMA_FORMAT_FLOAT},
                          skinned = {normals, skin.vertex_count, 0, NORMA_FORMAT_FLOAT};
    const norma_result result =
        positions ? norma_skin_positions(&skin, view, NULL, out, skin.vertex_count)
        : normals ? norma_skin_tangents(&skin, in, skinned, NULL, out, skin.vertex_count)
                  : norma_skin_normals(&skin, view, NULL, out, skin.vertex_count, NULL);
    if (result) norma_find_skin_fault(&skin, NULL, &fault);
    return result;
}

/* Why the last call failed: the array of the skin, its element. */
const char *WEB_EXPORT(skin_fault_argument)(void) { return fault.argument ? fault.argument : ""; }
const char *WEB_EXPORT(skin_fault_expected)(void) { return fault.expected ? fault.expected : ""; }
size_t WEB_EXPORT(skin_fault_index)(void) { return fault.index; }
