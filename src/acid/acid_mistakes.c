/* acid_mistakes.c: the mistakes that references of the acid scene show, and how each is mended. */
#include "acid/acid_mistakes.h"
#include "norma_glsl.h"
#include <string.h>

static const acid_mistake mistakes[] = {
    {"object-space", "normals stay in the mesh's own space",
        "multiply them by the normal matrix of the node's world matrix",
        {"norma_transform_normal"}},
    {"not-normalized", "normals do not have unit length when the light is computed",
        "normalize after the transform, and again after interpolation", {"norma_unit"}},
    {"model-matrix", "normals are multiplied by the model matrix itself",
        "use the normal matrix: the cofactors of the upper 3x3 times the sign of its determinant, "
        "or the inverse transpose",
        {"norma_cofactors", "norma_normal_matrix", "norma_transform_normal"}},
    {"separate-scale",
        "the normal matrix is made of a decomposed rotation and scale, which cannot express shear",
        "compute it from the upper 3x3 of the world matrix",
        {"norma_cofactors", "norma_normal_matrix"}},
    {"reversed", "normals point inward under a mirror",
        "multiply the cofactors by the sign of the determinant, and reverse the winding of front "
        "faces",
        {"norma_normal_matrix", "norma_mirror_sign"}},
    {"lost", "normals are lost where the matrix is singular",
        "use the cofactors, which exist for every matrix, instead of an inverse",
        {"norma_cofactors"}},
    {"instance-ignored", "the transform of the instance does not act on normals",
        "use the normal matrix of node times instance", {"norma_instance_normal"}},
    {"node-applied", "the skinned node's own transform acts on normals",
        "ignore it: the joints alone place a skinned mesh", {"norma_skin_normal"}},
    {"node-not-cancelled",
        "the skinned node's own transform is cancelled for positions, but acts on normals twice",
        "use the normal matrix of the blended joint matrices alone; the node has no part in it",
        {"norma_skin_normal"}},
    {"strongest-joint", "only the joint with the largest weight acts on normals",
        "blend the joint matrices by all weights, then use the normal matrix of the sum",
        {"norma_skin_matrix", "norma_skin_normal"}},
    {"normals-not-morphed", "morph targets move positions but not normals",
        "add weight times NORMAL of each target before normalizing", {NULL}},
    {"smoothed", "a mesh without NORMAL is shaded smoothly",
        "compute flat normals: normalize(cross(dFdx(position), dFdy(position)))",
        {"norma_flat_normal"}},
    {"not-flipped", "back faces of a double-sided material keep the normal of the front",
        "negate the normal where gl_FrontFacing is false", {"norma_facing_normal"}},
    {"sign-lost", "the tangent's sign, its w, is not used",
        "bitangent = cross(normal, tangent.xyz) * tangent.w", {"norma_perturb"}},
    {"green-flipped", "the normal map's green channel is read downward",
        "glTF's green points up: use it as it is", {"norma_perturb"}},
    {"tangent-by-normal-matrix", "tangents are multiplied by the normal matrix",
        "multiply them by the model matrix itself, then make them perpendicular to the normal",
        {"norma_transform_tangent"}},
    {"sign-kept", "the tangent's sign stays the same under a mirror",
        "multiply w by the sign of the model matrix's determinant", {"norma_transform_tangent"}},
    {"scale-ignored", "normalTexture.scale is ignored",
        "multiply x and y of the sample by it, then normalize", {"norma_perturb"}},
    {"scale-on-z", "normalTexture.scale acts on z",
        "multiply only x and y of the sample by it, then normalize", {"norma_perturb"}},
};

const acid_mistake *acid_find_mistake(const char *id) {
    for (size_t i = 0; i < sizeof mistakes / sizeof *mistakes; ++i)
        if (strcmp(mistakes[i].id, id) == 0) return &mistakes[i];
    return NULL;
}

/* A function begins a line, below the lines of its comment, and ends with the line of its closing
 * brace. */
size_t acid_mending_lines(const char *function, const char **begin) {
    const size_t length = strlen(function);
    const char *comment = NULL;
    for (const char *line = norma_glsl; *line;) {
        const char *end = strchr(line, '\n');
        if (line[0] == '/' && !comment) comment = line;
        const char *name = strchr(line, ' ');
        if (line[0] >= 'a' && line[0] <= 'z' && name && name < end &&
            strncmp(name + 1, function, length) == 0 && name[1 + length] == '(') {
            const char *last = end[-1] == '}' ? end : strstr(line, "\n}") + 2;
            *begin = comment ? comment : line;
            return (size_t)(last - *begin);
        }
        if (line[0] != '/') comment = NULL;
        line = end + 1;
    }
    return 0;
}
