/* cells.c: the cells of the acid scenes, a new cell being one entry, and the mistakes that their
 * references show, with how each is mended. */
#include "acid/acid.h"
#include "norma_glsl.h"
#include <math.h>
#include <string.h>

#define TRANSFORMS "glTF 2.0, 3.5.3 Transformations"
#define PLACED     "glTF 2.0, 3.7.4 Instantiation"
#define MESHES     "glTF 2.0, 3.7.2.1 Meshes, Overview"
#define SKINS      "glTF 2.0, 3.7.3 Skins"
#define NORMAL_MAP "glTF 2.0, 5.20 Material, normalTexture"
#define GLOBAL                                                                                     \
    "The global transformation matrix of a node is the product of the global transformation "      \
    "matrix of its parent node and its own local transformation matrix."
#define WINDING                                                                                    \
    "If the determinant is a positive value, the winding order triangle faces is "                 \
    "counterclockwise; in the opposite case, the winding order is clockwise."
#define BITANGENT                                                                                  \
    "The bitangent vectors MUST be computed by taking the cross product of the normal and "        \
    "tangent "                                                                                     \
    "XYZ vectors and multiplying it against the W component of the tangent."
#define SAME "The subject looks like the right reference."

const acid_cell acid_cells[] = {
    {"control", "Nothing: the subject is baked as its reference is.", GLOBAL, TRANSFORMS,
        "Both patches are equal. If they are not, the picture cannot be judged.", ACID_BAKED,
        .step_count = 0},
    {"rotation", "A node that is turned.", GLOBAL, TRANSFORMS, SAME, ACID_NODES,
        .steps = {{{1, 1, 1}, {1, 2, 6, 4}}}, .step_count = 1, .faults = {ACID_OBJECT_SPACE}},
    {"uniform-scale", "A node whose scale is 1/4.", GLOBAL, TRANSFORMS,
        "The subject is as bright as the right reference.", ACID_NODES,
        .steps = {{{0.25, 0.25, 0.25}, {0}}}, .step_count = 1, .white = 0.25,
        .faults = {ACID_NOT_NORMALIZED}},
    {"non-uniform-scale", "A turned node whose scale is 2, 1, 1/2.", GLOBAL, TRANSFORMS, SAME,
        ACID_NODES, .steps = {{{2, 1, 0.5}, {2, 5, 4, 7}}}, .step_count = 1, .white = 0.5,
        .faults = {ACID_MODEL_MATRIX, ACID_NOT_NORMALIZED, ACID_OBJECT_SPACE}},
    {"shear", "A turned node below a scaled one: together they shear.", GLOBAL, TRANSFORMS, SAME,
        ACID_NODES, .steps = {{{2, 1, 0.5}, {0}}, {{1, 1, 1}, {3, 4, 2, 7}}}, .step_count = 2,
        .faults = {ACID_MODEL_MATRIX, ACID_SEPARATE_SCALE}},
    {"mirror", "A node whose scale has one negative factor.", WINDING, PLACED, SAME, ACID_NODES,
        .steps = {{{-2, 1, 0.5}, {2, 5, 4, 7}}}, .step_count = 1,
        .faults = {ACID_REVERSED, ACID_MODEL_MATRIX}},
    {"mirror-double-sided", "A mirrored node, its material double-sided.", WINDING, PLACED, SAME,
        ACID_NODES, .steps = {{{-2, 1, 0.5}, {2, 5, 4, 7}}}, .step_count = 1, .double_sided = 1,
        .faults = {ACID_REVERSED}},
    {"mirror-twice", "A mirrored node below a mirrored one: together they do not mirror.", WINDING,
        PLACED, SAME, ACID_NODES,
        .steps = {{{-1, 1, 1.5}, {1, 2, 3, 8}}, {{1, -1.25, 1}, {3, 1, 2, 7}}}, .step_count = 2,
        .faults = {ACID_REVERSED}},
    {"flattened", "A node whose scale is 1, 1, 0: only the plane's own normal is left.", GLOBAL,
        TRANSFORMS, "The subject is evenly lit, as the right reference.", ACID_NODES,
        .steps = {{{1, 1, 0}, {2, -1, 0, 8}}}, .step_count = 1, .faults = {ACID_LOST}},
    {"instanced", "An instance whose scale differs by axis.",
        "TRANSLATION, ROTATION and SCALE of each instance make a matrix in the space of the node.",
        "EXT_mesh_gpu_instancing, Extending Nodes", SAME, ACID_INSTANCE,
        .steps = {{{3, 1.5, 1.2}, {2, 5, 4, 7}}, {{3, 1.5, 1.2}, {-3, 7, 11, 3}}}, .step_count = 2,
        .faults = {ACID_MODEL_MATRIX, ACID_INSTANCE_IGNORED}},
    {"instanced-mirror", "One instance mirrors, another one does not.", WINDING, PLACED, SAME,
        ACID_INSTANCE,
        .steps = {{{-1.5, 1.5, 1.5}, {1, 2, 3, 8}}, {{1.5, 1.5, 1.5}, {1, -2, -3, 8}}},
        .step_count = 2, .faults = {ACID_REVERSED}},
    {"skinned", "A joint whose scale differs by axis; the skinned node has a transform of its own.",
        "Only the joint transforms are applied to the skinned mesh; the transform of the skinned "
        "mesh node MUST be ignored.",
        SKINS, SAME, ACID_SKIN, .steps = {{{2, 1, 0.5}, {2, 5, 4, 7}}}, .step_count = 1,
        .own = {{1, 1, 4}, {0}},
        .faults = {ACID_MODEL_MATRIX, ACID_NODE_APPLIED, ACID_NODE_NOT_CANCELLED}},
    {"skinned-blend", "Two joints, each vertex with a share of both.",
        "The skinned vertex is the weighted sum of what the joint matrices make of it.", SKINS,
        SAME, ACID_SKIN, .steps = {{{2, 1, 0.5}, {2, 5, 4, 7}}, {{0.5, 1, 2}, {5, 1, -3, 7}}},
        .step_count = 2, .faults = {ACID_MODEL_MATRIX, ACID_STRONGEST_JOINT}},
    {"skinned-mirror", "A joint that mirrors.",
        "Only the joint transforms are applied to the skinned mesh.", SKINS, SAME, ACID_SKIN,
        .steps = {{{-1, 1, 1}, {2, 5, 4, 7}}}, .step_count = 1, .own = {.scale = {-1, 1, 1}},
        .faults = {ACID_REVERSED}},
    {"morph", "A morph target with POSITION and NORMAL, of weight 0.7.",
        "The morphed attribute is the base plus each target's displacement times its weight.",
        "glTF 2.0, 3.7.2.2 Morph Targets", SAME, ACID_MORPH,
        .faults = {ACID_NOT_MORPHED, ACID_NOT_NORMALIZED}},
    {"quantized", "Positions and normals in bytes, under the scale that undoes that.",
        "The scale of the node dequantizes; it acts on normals as any other transform.",
        "KHR_mesh_quantization, Encoding Quantized Data", SAME, ACID_BYTES,
        .steps = {{{ACID_HALF / ACID_BYTES_ACROSS, ACID_HALF / ACID_BYTES_ACROSS,
                       ACID_HALF *ACID_BYTE_HEIGHT},
            {0}}},
        .step_count = 1, .faults = {ACID_MODEL_MATRIX}},
    {"flat", "A mesh without NORMAL.",
        "When normals are not specified, client implementations MUST calculate flat normals and "
        "the provided tangents (if present) MUST be ignored.",
        MESHES, "The subject has facets.", ACID_FLAT, .faults = {ACID_SMOOTHED}},
    {"back-side", "A double-sided material, seen from behind.",
        "The back-face MUST have its normals reversed before the lighting equation is evaluated.",
        "glTF 2.0, 3.9.6 Double Sided", SAME, ACID_BACK, .double_sided = 1,
        .faults = {ACID_NOT_FLIPPED}},
    {"tangent-absent", "A normal map without TANGENT; most of the chart is mirrored.",
        "When tangents are not specified, client implementations SHOULD calculate tangents using "
        "default MikkTSpace algorithms.",
        MESHES, SAME, ACID_BAKED, .map = ACID_MAP_ALONE, .mirrored_from = 8,
        .faults = {ACID_SIGN_LOST}},
    {"tangent-sign", "TANGENT with w = 1 on the left, w = -1 on the right.", BITANGENT, MESHES,
        SAME, ACID_BAKED, .map = ACID_MAP_WITH_TANGENTS, .mirrored_from = 17,
        .faults = {ACID_SIGN_LOST, ACID_GREEN_FLIPPED}},
    {"tangent-non-uniform", "A normal map under a node whose scale is 2, 1, 1/2.", BITANGENT,
        MESHES, SAME, ACID_NODES, .steps = {{{2, 1, 0.5}, {5, 1, 1, 5}}}, .step_count = 1,
        .map = ACID_MAP_WITH_TANGENTS, .faults = {ACID_TANGENT_BY_NORMAL_MATRIX}},
    {"tangent-mirror", "A normal map under a node that mirrors.", BITANGENT, MESHES, SAME,
        ACID_NODES, .steps = {{{-1, 1, 1}, {2, 5, 4, 7}}}, .step_count = 1,
        .map = ACID_MAP_WITH_TANGENTS, .faults = {ACID_SIGN_KEPT}},
    {"tangent-skinned", "A normal map on a skin, the joint's scale 2, 1, 1/2.", BITANGENT, MESHES,
        SAME, ACID_SKIN, .steps = {{{2, 1, 0.5}, {5, 1, 1, 5}}}, .step_count = 1,
        .map = ACID_MAP_WITH_TANGENTS,
        .faults = {ACID_TANGENT_BY_NORMAL_MATRIX, ACID_MODEL_MATRIX}},
    {"normal-scale", "normalTexture.scale is 2.",
        "scaledNormal = normalize((<sampled normal texture value> * 2.0 - 1.0) * vec3(<normal "
        "scale>, <normal scale>, 1.0)).",
        NORMAL_MAP, SAME, ACID_BAKED, .map = ACID_MAP_WITH_TANGENTS, .normal_scale = 2,
        .faults = {ACID_SCALE_IGNORED, ACID_SCALE_ON_Z}},
};
const size_t acid_cell_count = sizeof acid_cells / sizeof *acid_cells;

size_t acid_fault_count(const acid_cell *cell) {
    size_t count = 0;
    while (count < ACID_MOST_FAULTS && cell->faults[count] != ACID_RIGHT) ++count;
    return count;
}

double acid_white(const acid_cell *cell) { return cell->white > 0 ? cell->white : 1; }

const char *acid_cell_extension(const acid_cell *cell) {
    return cell->way == ACID_INSTANCE ? "EXT_mesh_gpu_instancing"
           : cell->way == ACID_BYTES  ? "KHR_mesh_quantization"
                                      : NULL;
}

void acid_step_rotation(const acid_step *step, double unit[4]) {
    const double *q = step->turn,
                 length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; ++k) unit[k] = length > 0 ? q[k] / length : k == 3;
}

/* ---- mistakes */

static const acid_mistake mistakes[ACID_FAULTS] = {
    /* in the order of acid_fault */
    {"right", NULL, NULL, {NULL}},
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

const char *acid_fault_id(acid_fault fault) { return mistakes[fault].id; }

const acid_mistake *acid_find_mistake(const char *id) {
    for (int i = 1; i < ACID_FAULTS; ++i)
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
