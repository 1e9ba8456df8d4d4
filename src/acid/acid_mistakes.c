/* acid_mistakes.c: the mistakes that references of the acid scene show, and how each is mended. */
#include "acid/acid_mistakes.h"
#include <stddef.h>
#include <string.h>

static const acid_mistake mistakes[] = {
    {"object-space", "normals stay in the mesh's own space",
        "multiply them by the normal matrix of the node's world matrix"},
    {"not-normalized", "normals do not have unit length when the light is computed",
        "normalize after the transform, and again after interpolation"},
    {"model-matrix", "normals are multiplied by the model matrix itself",
        "use the normal matrix: the cofactors of the upper 3x3 times the sign of its determinant, "
        "or the inverse transpose"},
    {"separate-scale",
        "the normal matrix is made of a decomposed rotation and scale, which cannot express shear",
        "compute it from the upper 3x3 of the world matrix"},
    {"reversed", "normals point inward under a mirror",
        "multiply the cofactors by the sign of the determinant, and reverse the winding of front "
        "faces"},
    {"lost", "normals are lost where the matrix is singular",
        "use the cofactors, which exist for every matrix, instead of an inverse"},
    {"instance-ignored", "the transform of the instance does not act on normals",
        "use the normal matrix of node times instance"},
    {"node-applied", "the skinned node's own transform acts on normals",
        "ignore it: the joints alone place a skinned mesh"},
    {"node-not-cancelled",
        "the skinned node's own transform is cancelled for positions, but acts on normals twice",
        "use the normal matrix of the blended joint matrices alone; the node has no part in it"},
    {"strongest-joint", "only the joint with the largest weight acts on normals",
        "blend the joint matrices by all weights, then use the normal matrix of the sum"},
    {"normals-not-morphed", "morph targets move positions but not normals",
        "add weight times NORMAL of each target before normalizing"},
    {"smoothed", "a mesh without NORMAL is shaded smoothly",
        "compute flat normals: normalize(cross(dFdx(position), dFdy(position)))"},
    {"not-flipped", "back faces of a double-sided material keep the normal of the front",
        "negate the normal where gl_FrontFacing is false"},
    {"sign-lost", "the tangent's sign, its w, is not used",
        "bitangent = cross(normal, tangent.xyz) * tangent.w"},
    {"green-flipped", "the normal map's green channel is read downward",
        "glTF's green points up: use it as it is"},
    {"tangent-by-normal-matrix", "tangents are multiplied by the normal matrix",
        "multiply them by the model matrix itself, then make them perpendicular to the normal"},
    {"sign-kept", "the tangent's sign stays the same under a mirror",
        "multiply w by the sign of the model matrix's determinant"},
    {"scale-ignored", "normalTexture.scale is ignored",
        "multiply x and y of the sample by it, then normalize"},
    {"scale-on-z", "normalTexture.scale acts on z",
        "multiply only x and y of the sample by it, then normalize"},
};

const acid_mistake *acid_find_mistake(const char *id) {
    for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; ++i)
        if (strcmp(mistakes[i].id, id) == 0) return &mistakes[i];
    return NULL;
}
