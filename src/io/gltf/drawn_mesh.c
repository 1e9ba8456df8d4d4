/* drawn_mesh.c: a mesh as a viewer draws it at rest: the weights of its morph targets and its skin
 * applied (glTF 2.0, 3.7.2.2 and 3.7.3.3), the skin by norma_skin_positions, _normals, _tangents.
 */
#include "io/gltf/gltf.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A mesh that moved, kept for the next instance of its node. */
typedef struct gltf_moved {
    size_t mesh;
    norma_drawn_mesh drawn;
    struct gltf_moved *next;
} gltf_moved;

/* What the joints of a skin do at rest. */
typedef struct gltf_joints {
    float *matrices; /* sixteen numbers for each; NULL: not yet */
    size_t count;
    double origin[3]; /* to be added to where the matrices lead */
} gltf_joints;

/* What moving a mesh works with. */
typedef struct mover {
    gltf *g;
    const gltf_primitive *p;
    const gltf_node *node;
    size_t count, normal_count, tangent_count;
    double *positions; /* as the file and its targets have them */
    float *posed;      /* where the skin moved them; NULL: it did not */
    float *normals, *tangents;
    double world[16]; /* from these positions to the scene */
} mover;

/* ---- which nodes the scene of the file has */

static int mark_roots(const gltf *g, uint8_t *shown) {
    const json *j = &g->json;
    uint64_t number = 0;
    const uint32_t list = norma_json_member(j, 0, "scenes"),
                   chosen = norma_json_member(j, 0, "scene");
    if (!norma_json_is(j, list, JSON_ARRAY) || norma_json_size(j, list) == 0) return 0;
    if (chosen != JSON_NONE && !norma_json_uint(j, chosen, &number)) return 0;
    const uint32_t scene = number < norma_json_size(j, list)
                               ? norma_json_element(j, list, (uint32_t)number)
                               : JSON_NONE,
                   roots = norma_json_member(j, scene, "nodes");
    for (uint32_t item = JSON_NONE; norma_json_each(j, roots, &item);) {
        const uint32_t node = norma_gltf_number(g, item, g->node_count);
        if (node != GLTF_NONE) shown[node] = 1;
    }
    return 1;
}

/* 1: in the scene, 2: not in it; of a file without scenes all nodes are. NULL: out of memory. */
static const uint8_t *nodes_shown(gltf *g, gltf_scene *scene) {
    if (scene->shown) return scene->shown;
    uint8_t *shown = norma_scene_allocate(g->document->scene, g->node_count, 1);
    if (!shown) return NULL;
    const int told = mark_roots(g, shown);
    for (uint32_t i = 0; i < g->node_count; ++i) {
        uint32_t at = i;
        while (!shown[at] && g->nodes[at].parent != GLTF_NONE) at = g->nodes[at].parent;
        const uint8_t found = shown[at] ? shown[at] : told ? 2 : 1;
        for (at = i; at != GLTF_NONE && !shown[at]; at = g->nodes[at].parent) shown[at] = found;
    }
    scene->shown = shown;
    return shown;
}

/* ---- morph targets */

/* The weights of a node, otherwise of its mesh; JSON_NONE: all are 0. */
static uint32_t weights_of(const gltf *g, const gltf_node *node, uint32_t mesh) {
    const uint32_t own = norma_json_member(&g->json, node->token, "weights");
    return own != JSON_NONE ? own : norma_json_member(&g->json, g->meshes[mesh].token, "weights");
}

static int has_weights(const gltf *g, const gltf_node *node, const gltf_primitive *p) {
    const uint32_t list = weights_of(g, node, p->mesh);
    double weight;
    uint32_t target = 0;
    for (uint32_t item = JSON_NONE;
         target < p->target_count && norma_json_each(&g->json, list, &item); ++target)
        if (norma_json_number(&g->json, item, &weight) && weight != 0) return 1;
    return 0;
}

/* Floats of an accessor of three numbers, as far as there are vertices. */
static norma_document_result read_moves(gltf *g, uint32_t accessor, size_t most,
    const float **moves, size_t *count, norma_document_error *error) {
    *count = 0;
    if (accessor == GLTF_NONE) return NORMA_DOCUMENT_OK;
    *count = g->accessors[accessor].count < most ? g->accessors[accessor].count : most;
    return norma_gltf_decode(g, accessor, 3, moves, error);
}

static norma_document_result add_weighted_target(
    mover *m, const gltf_attributes *target, double weight, norma_document_error *error) {
    const float *moves = NULL;
    size_t count;
    norma_document_result result =
        read_moves(m->g, target->position, m->count, &moves, &count, error);
    for (size_t i = 0; i < 3 * count && !result; ++i) m->positions[i] += weight * (double)moves[i];
    if (!result) result = read_moves(m->g, target->normal, m->normal_count, &moves, &count, error);
    for (size_t i = 0; i < 3 * count && !result; ++i) m->normals[i] += (float)weight * moves[i];
    if (!result)
        result = read_moves(m->g, target->tangent, m->tangent_count, &moves, &count, error);
    for (size_t i = 0; i < 3 * count && !result; ++i)
        m->tangents[4 * (i / 3) + i % 3] += (float)weight * moves[i];
    return result;
}

static norma_document_result add_targets(mover *m, norma_document_error *error) {
    const json *j = &m->g->json;
    const uint32_t list = weights_of(m->g, m->node, m->p->mesh);
    norma_document_result result = NORMA_DOCUMENT_OK;
    uint32_t target = 0;
    for (uint32_t item = JSON_NONE;
         target < m->p->target_count && !result && norma_json_each(j, list, &item); ++target) {
        double weight;
        if (norma_json_number(j, item, &weight) && weight != 0 && isfinite(weight))
            result =
                add_weighted_target(m, &m->g->targets[m->p->first_target + target], weight, error);
    }
    return result;
}

/* ---- skins */

static int has_skin(const gltf *g, const gltf_node *node, const gltf_primitive *p) {
    return node->skin != GLTF_NONE && norma_gltf_numbered(g, p, "JOINTS", 0) != GLTF_NONE &&
           norma_gltf_numbered(g, p, "WEIGHTS", 0) != GLTF_NONE;
}

norma_document_result norma_gltf_read_inverse(gltf *g, uint32_t skin, size_t joints,
    gltf_array *array, int *there, norma_document_error *error) {
    const uint32_t token = norma_json_member(&g->json, skin, "inverseBindMatrices");
    const uint32_t accessor = norma_gltf_number(g, token, g->accessor_count);
    *there = token != JSON_NONE;
    if (!*there) return NORMA_DOCUMENT_OK;
    if (accessor == GLTF_NONE)
        return norma_gltf_malformed(g, error, token, "the number of an existing accessor");
    norma_document_result result = norma_gltf_array(g, accessor, array, error);
    if (!result &&
        (array->width != 16 || !norma_gltf_is_float(array->component) || array->count < joints))
        result = norma_gltf_malformed(g, error, token, "a matrix for each joint");
    return result;
}

norma_document_result norma_gltf_read_joints(
    gltf *g, uint32_t skin, uint32_t **joints, size_t *count, norma_document_error *error) {
    const json *j = &g->json;
    const uint32_t list = norma_json_member(j, skin, "joints");
    *count = 0;
    *joints = NULL;
    if (list != JSON_NONE && !norma_json_is(j, list, JSON_ARRAY))
        return norma_gltf_malformed(g, error, list, "an array");
    *joints = norma_io_allocate(norma_json_size(j, list), sizeof **joints);
    if (!*joints) return norma_document_fail_memory(g->document, error);
    for (uint32_t item = JSON_NONE; norma_json_each(j, list, &item);) {
        const uint32_t node = norma_gltf_number(g, item, g->node_count);
        if (node == GLTF_NONE)
            return norma_gltf_malformed(g, error, item, "the number of an existing node");
        (*joints)[(*count)++] = node;
    }
    return NORMA_DOCUMENT_OK;
}

/* From the mesh, as it was bound, to the scene, for each joint. Where the first joint takes the
 * mesh's origin is kept apart, in doubles: a skin that stands far away loses nothing. */
static norma_document_result make_joints(
    gltf *g, uint32_t skin, gltf_joints *made, norma_document_error *error) {
    gltf_array inverse;
    uint32_t *joints;
    int there;
    norma_document_result result = norma_gltf_read_joints(g, skin, &joints, &made->count, error);
    if (!result) result = norma_gltf_read_inverse(g, skin, made->count, &inverse, &there, error);
    if (!result)
        result = norma_gltf_spend(g, skin, made->count, 16 * sizeof *made->matrices, error);
    if (!result && !(made->matrices = norma_scene_allocate(
                         g->document->scene, made->count, 16 * sizeof *made->matrices)))
        result = norma_document_fail_memory(g->document, error);
    for (size_t j = 0; !result && j < made->count; ++j) {
        double bound[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, matrix[16];
        if (there) norma_gltf_doubles(&inverse, j, bound);
        norma_gltf_matrix_multiply(g->nodes[joints[j]].world, bound, matrix);
        if (j == 0) memcpy(made->origin, matrix + 12, sizeof made->origin);
        for (int i = 0; i < 16; ++i)
            made->matrices[16 * j + (size_t)i] =
                (float)(i < 12 || i > 14 ? matrix[i] : matrix[i] - made->origin[i - 12]);
    }
    free(joints);
    return result;
}

/* A skin's matrices are the same for every node that it moves: they are made once. */
static norma_document_result read_drawn_joints(
    gltf *g, uint32_t index, const gltf_joints **joints, norma_document_error *error) {
    gltf_scene *scene = norma_gltf_scene_of(g);
    if (!scene->joints && !(scene->joints = norma_scene_allocate(
                                g->document->scene, g->skin_count, sizeof *scene->joints)))
        return norma_document_fail_memory(g->document, error);
    if (!scene->joints[index].matrices) {
        gltf_joints made = {0};
        const norma_document_result result = make_joints(g, scene->skins[index], &made, error);
        if (result) return result;
        scene->joints[index] = made;
    }
    *joints = &scene->joints[index];
    return NORMA_DOCUMENT_OK;
}

typedef struct influences { /* one set of four joints for each vertex */
    gltf_array joints, weights;
} influences;

enum { MOST_SETS = 8 };

static norma_document_result find_influences(gltf *g, const gltf_primitive *p,
    influences sets[MOST_SETS], size_t *count, norma_document_error *error) {
    for (*count = 0; *count < MOST_SETS; ++*count) {
        const uint32_t joints = norma_gltf_numbered(g, p, "JOINTS", *count),
                       weights = norma_gltf_numbered(g, p, "WEIGHTS", *count);
        if (joints == GLTF_NONE || weights == GLTF_NONE) break;
        influences *set = &sets[*count];
        norma_document_result result = norma_gltf_array(g, joints, &set->joints, error);
        if (!result) result = norma_gltf_array(g, weights, &set->weights, error);
        if (result) return result;
        if (set->joints.width != 4 || set->joints.count < p->vertices ||
            (set->joints.component != GLTF_UBYTE && set->joints.component != GLTF_USHORT))
            return norma_gltf_malformed(g, error, g->accessors[joints].token,
                "four joints for each vertex, as unsigned bytes or shorts");
        if (set->weights.width != 4 || set->weights.count < p->vertices)
            return norma_gltf_malformed(
                g, error, g->accessors[weights].token, "four weights for each vertex");
    }
    return NORMA_DOCUMENT_OK;
}

/* Viewers divide a vertex's weights by their sum, which need not be 1, and let one without weights
 * follow its first joint. A joint that weighs nothing need not exist. */
static void share_weights(uint16_t *joints, float *weights, size_t count, size_t joint_count) {
    const uint16_t first = joints[0] < joint_count ? joints[0] : 0;
    double sum = 0;
    for (size_t k = 0; k < count; ++k) {
        if (!isfinite(weights[k])) weights[k] = 0;
        if (weights[k] == 0) joints[k] = 0;
        sum += (double)weights[k];
    }
    for (size_t k = 0; k < count; ++k)
        weights[k] = sum != 0 ? (float)((double)weights[k] / sum) : k == 0;
    if (sum == 0) joints[0] = first;
}

/* Of a vertex: its joints and weights, and what callers move by them. */
static size_t influence_bytes(size_t width) {
    return width * (sizeof(uint16_t) + sizeof(float)) + 6 * sizeof(float);
}

norma_document_result norma_gltf_read_influences(
    gltf *g, uint32_t primitive, norma_skin *skin, norma_document_error *error) {
    const gltf_primitive *p = &g->primitives[primitive];
    influences sets[MOST_SETS];
    size_t count = 0;
    norma_document_result result = find_influences(g, p, sets, &count, error);
    const size_t width = 4 * count;
    if (!result && width)
        result = norma_gltf_spend(g, p->token, p->vertices, influence_bytes(width), error);
    if (result) return result;
    uint16_t *joints = norma_io_allocate(p->vertices, width * sizeof *joints);
    float *weights = norma_io_allocate(p->vertices, width * sizeof *weights);
    skin->joints = joints;
    skin->weights = weights;
    skin->influences = width;
    skin->vertex_count = p->vertices;
    if (!joints || !weights) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < p->vertices; ++i) {
        for (size_t set = 0; set < count; ++set) {
            uint32_t numbers[4];
            norma_gltf_uints(&sets[set].joints, i, numbers);
            norma_gltf_floats(&sets[set].weights, i, weights + i * width + 4 * set);
            for (size_t k = 0; k < 4; ++k) joints[i * width + 4 * set + k] = (uint16_t)numbers[k];
        }
        share_weights(joints + i * width, weights + i * width, width, skin->joint_count);
    }
    return NORMA_DOCUMENT_OK;
}

void norma_gltf_free_influences(gltf *g, uint32_t primitive, norma_skin *skin) {
    if (skin->influences)
        g->decoded -= g->primitives[primitive].vertices * influence_bytes(skin->influences);
    free((void *)skin->joints);
    free((void *)skin->weights);
}

/* Faces whose joints mirror face the other way: the mesh is reversed along x, and placed by a
 * matrix that mirrors, as under a node that does. */
static void turn_vertices(mover *m) {
    m->world[0] = -1;
    for (size_t i = 0; i < m->count; ++i) m->posed[3 * i] *= -1;
    for (size_t i = 0; i < m->normal_count; ++i) m->normals[3 * i] *= -1;
    for (size_t i = 0; i < m->tangent_count; ++i) {
        m->tangents[4 * i] *= -1;
        m->tangents[4 * i + 3] *= -1;
    }
}

/* Whether most vertices lie in matrices that mirror: such a matrix negates a tangent's sign. signs:
 * four numbers for each vertex, zeros. */
static norma_result find_mirrored(
    const norma_skin *skin, norma_vec3_view positions, float *signs, int *mirrored) {
    size_t count = 0;
    for (size_t i = 0; i < skin->vertex_count; ++i) signs[4 * i + 3] = 1;
    const norma_result result =
        norma_skin_tangents(skin, signs, positions, NULL, signs, skin->vertex_count);
    for (size_t i = 0; i < skin->vertex_count; ++i) count += signs[4 * i + 3] < 0;
    *mirrored = count > skin->vertex_count / 2;
    return result;
}

static norma_result move_by_skin(mover *m, norma_skin skin, float *signs) {
    const norma_vec3_view at = {m->positions, m->count, 0, NORMA_FORMAT_DOUBLE},
                          normals = {m->normals, m->normal_count, 0, NORMA_FORMAT_FLOAT};
    int mirrored = 0;
    norma_result result = find_mirrored(&skin, at, signs, &mirrored);
    if (!result) result = norma_skin_positions(&skin, at, NULL, m->posed, m->count);
    if (m->normal_count < skin.vertex_count) skin.vertex_count = m->normal_count;
    if (!result) result = norma_skin_normals(&skin, normals, NULL, m->normals, m->count, NULL);
    if (m->tangent_count < skin.vertex_count) skin.vertex_count = m->tangent_count;
    if (!result)
        result = norma_skin_tangents(&skin, m->tangents, normals, NULL, m->tangents, m->count);
    if (!result && mirrored) turn_vertices(m);
    return result;
}

static norma_document_result refuse_skin(
    const mover *m, const norma_skin *skin, norma_result why, norma_document_error *error) {
    norma_fault fault;
    if (why == NORMA_ERROR_MEMORY) return norma_document_fail_memory(m->g->document, error);
    norma_find_skin_fault(skin, NULL, &fault);
    if (why == NORMA_ERROR_INDEX)
        return norma_document_fail(m->g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED,
            m->p->where, "vertex %zu names joint %u; its skin has %zu, numbered from 0",
            fault.index / skin->influences, (unsigned)((const uint16_t *)skin->joints)[fault.index],
            skin->joint_count);
    return norma_document_fail(m->g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED, m->p->where,
        "joint %zu of its skin has a matrix that is not finite", fault.index);
}

static norma_document_result apply_skin(mover *m, norma_document_error *error) {
    gltf *g = m->g;
    const gltf_joints *joints;
    norma_skin skin = {.joint_size = sizeof(uint16_t)};
    norma_document_result result = read_drawn_joints(g, m->node->skin, &joints, error);
    if (result) return result;
    skin.matrices = joints->matrices;
    skin.joint_count = joints->count;
    memcpy(m->world + 12, joints->origin, sizeof joints->origin);
    m->posed = norma_scene_allocate(g->document->scene, m->count, 3 * sizeof *m->posed);
    float *signs = norma_io_allocate(m->count, 4 * sizeof *signs);
    result = m->posed && signs
                 ? norma_gltf_read_influences(g, (uint32_t)(m->p - g->primitives), &skin, error)
                 : norma_document_fail_memory(g->document, error);
    if (!result) {
        const norma_result moved = move_by_skin(m, skin, signs);
        if (moved) result = refuse_skin(m, &skin, moved, error);
    }
    free(signs);
    norma_gltf_free_influences(g, (uint32_t)(m->p - g->primitives), &skin);
    return result;
}

/* ---- the vertices as the file has them */

static norma_document_result copy_floats(gltf *g, uint32_t accessor, uint32_t width, float **copy,
    size_t *count, norma_document_error *error) {
    const float *floats;
    if (accessor == GLTF_NONE || norma_gltf_is_placeholder(g, accessor)) return NORMA_DOCUMENT_OK;
    norma_document_result result = norma_gltf_decode(g, accessor, width, &floats, error);
    if (result) return result;
    *count = g->accessors[accessor].count;
    *copy = norma_scene_allocate(g->document->scene, *count, width * sizeof **copy);
    if (!*copy) return norma_document_fail_memory(g->document, error);
    memcpy(*copy, floats, *count * width * sizeof **copy);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result copy_vertices(mover *m, norma_document_error *error) {
    gltf *g = m->g;
    gltf_array array;
    m->count = m->p->vertices;
    norma_document_result result = norma_gltf_spend(
        g, m->node->token, m->count, 3 * sizeof(double) + 10 * sizeof(float), error);
    if (!result) result = norma_gltf_array(g, m->p->base.position, &array, error);
    if (result) return result;
    m->positions = norma_scene_allocate(g->document->scene, m->count, 3 * sizeof *m->positions);
    if (!m->positions) return norma_document_fail_memory(g->document, error);
    for (size_t i = 0; i < m->count; ++i) {
        float p[3];
        norma_gltf_floats(&array, i, p);
        for (int k = 0; k < 3; ++k) m->positions[3 * i + (size_t)k] = (double)p[k];
    }
    result = copy_floats(g, m->p->base.normal, 3, &m->normals, &m->normal_count, error);
    return result ? result
                  : copy_floats(g, m->p->base.tangent, 4, &m->tangents, &m->tangent_count, error);
}

static norma_document_result move(mover *m, int skinned, norma_document_error *error) {
    norma_document_result result = copy_vertices(m, error);
    if (!result) result = add_targets(m, error);
    return result || !skinned ? result : apply_skin(m, error);
}

static norma_document_result make_moved(gltf *g, uint32_t node, size_t mesh, int skinned,
    gltf_moved *made, norma_document_error *error) {
    mover m = {.g = g, .p = &g->primitives[mesh], .node = &g->nodes[node]};
    norma_gltf_matrix_identity(m.world);
    norma_document_result result = move(&m, skinned, error);
    made->mesh = mesh;
    made->drawn = (norma_drawn_mesh){.moved = 1,
        .skinned = skinned,
        .positions = {.data = m.positions, .count = m.count, .format = NORMA_FORMAT_DOUBLE},
        .normals = {.data = m.normals, .count = m.normal_count},
        .tangents = m.tangents};
    if (skinned) made->drawn.positions = (norma_vec3_view){m.posed, m.count, 0, NORMA_FORMAT_FLOAT};
    memcpy(made->drawn.world, m.world, sizeof m.world);
    return result;
}

static norma_document_result find_moved(gltf *g, size_t index, size_t mesh, int skinned,
    norma_drawn_mesh *drawn, norma_document_error *error) {
    gltf_scene *scene = norma_gltf_scene_of(g);
    gltf_moved *found = scene->moved[index];
    while (found && found->mesh != mesh) found = found->next;
    if (!found) {
        found = norma_scene_allocate(g->document->scene, 1, sizeof *found);
        norma_document_result result =
            found ? make_moved(g, g->drawing[index], mesh, skinned, found, error)
                  : norma_document_fail_memory(g->document, error);
        if (result) return result;
        found->next = scene->moved[index];
        scene->moved[index] = found;
    }
    const int in_scene = drawn->shown;
    double world[16];
    memcpy(world, skinned ? found->drawn.world : drawn->world, sizeof world);
    *drawn = found->drawn;
    drawn->shown = in_scene;
    memcpy(drawn->world, world, sizeof world);
    return NORMA_DOCUMENT_OK;
}

/* ---- a mesh at a place */

/* Positions that are normalised integers are given as the integers that they are. */
static double unit_or_self(const gltf *g, const gltf_primitive *p) {
    const gltf_accessor *a = &g->accessors[p->base.position];
    if (!a->normalized) return 1;
    return 1 / norma_gltf_largest_code(a->component);
}

norma_document_result norma_gltf_move_drawn(norma_document *document, size_t node, size_t mesh,
    norma_drawn_mesh *drawn, norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    const gltf_node *at = &g->nodes[g->drawing[node]];
    const gltf_primitive *p = &g->primitives[mesh];
    gltf_scene *scene = norma_gltf_scene_of(g);
    const uint8_t *shown = scene ? nodes_shown(g, scene) : NULL;
    if (!shown) return norma_document_fail_memory(g->document, error);
    if (p->mesh != at->mesh)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, p->where,
            "node %zu does not draw this mesh", node);
    const int skinned = has_skin(g, at, p);
    drawn->shown = shown[g->drawing[node]] == 1;
    if (skinned || has_weights(g, at, p)) return find_moved(g, node, mesh, skinned, drawn, error);
    for (int i = 0; i < 12; ++i) drawn->world[i] *= unit_or_self(g, p);
    return NORMA_DOCUMENT_OK;
}
