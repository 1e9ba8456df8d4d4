/* drawn_mesh.c: a mesh as a viewer draws it at rest: the weights of its morph targets and its skin
 * applied (glTF 2.0, 3.7.2.2 and 3.7.3.3), normals through the cofactors of the same matrices. */
#include "io/gltf/gltf.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A mesh that moved, kept for the next instance of its node. */
typedef struct gltf_moved {
    size_t mesh;
    norma_drawn_mesh drawn;
    struct gltf_moved *next;
} gltf_moved;

/* What moving a mesh works with. */
typedef struct mover {
    gltf *g;
    const gltf_primitive *p;
    const gltf_node *node;
    size_t count, normal_count, tangent_count;
    double *positions;
    const double *joints; /* the sixteen numbers of each joint's matrix */
    float *normals, *tangents;
    size_t joint_count;
    size_t mirrored; /* vertices that lie in matrices that mirror */
    int turned;      /* the x axis is reversed: most vertices do */
} mover;

static norma_document_result fail_drawn(const gltf *g, norma_document_error *error) {
    return norma_document_fail_memory(g->document, error);
}

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
        uint64_t node;
        if (norma_json_uint(j, item, &node) && node < g->node_count) shown[node] = 1;
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

static uint32_t accessor_of(const gltf *g, const gltf_primitive *p, const char *name, int set) {
    char text[32];
    snprintf(text, sizeof text, "%s_%d", name, set);
    const uint32_t found = norma_gltf_find(g, &p->base, text);
    return found == GLTF_NONE ? GLTF_NONE : g->attributes[found].accessor;
}

static int has_skin(const gltf *g, const gltf_node *node, const gltf_primitive *p) {
    return node->skin != GLTF_NONE && accessor_of(g, p, "JOINTS", 0) != GLTF_NONE &&
           accessor_of(g, p, "WEIGHTS", 0) != GLTF_NONE;
}

norma_document_result norma_gltf_read_inverse(gltf *g, uint32_t skin, size_t joints,
    gltf_array *array, int *there, norma_document_error *error) {
    const uint32_t token = norma_json_member(&g->json, skin, "inverseBindMatrices");
    uint64_t accessor;
    *there = token != JSON_NONE;
    if (!*there) return NORMA_DOCUMENT_OK;
    if (!norma_json_uint(&g->json, token, &accessor) || accessor >= g->accessor_count)
        return norma_gltf_malformed(g, error, token, "the number of an existing accessor");
    norma_document_result result = norma_gltf_array(g, (uint32_t)accessor, array, error);
    if (!result &&
        (array->width != 16 || !norma_gltf_is_float(array->component) || array->count < joints))
        result = norma_gltf_malformed(g, error, token, "a matrix for each joint");
    return result;
}

/* From the mesh, as it was bound, to the scene, for each joint of the list. */
static norma_document_result fill_joints(gltf *g, uint32_t list, const gltf_array *inverse,
    double *matrices, norma_document_error *error) {
    const json *j = &g->json;
    uint32_t number = 0;
    for (uint32_t item = JSON_NONE; norma_json_each(j, list, &item); ++number) {
        uint64_t node;
        float bound[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        double matrix[16];
        if (!norma_json_uint(j, item, &node) || node >= g->node_count)
            return norma_gltf_malformed(g, error, item, "the number of an existing node");
        if (inverse) norma_gltf_floats(inverse, number, bound);
        for (int i = 0; i < 16; ++i) matrix[i] = (double)bound[i];
        norma_gltf_matrix_multiply(g->nodes[node].world, matrix, matrices + 16 * (size_t)number);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result make_joints(gltf *g, uint32_t skin, uint32_t list, size_t count,
    double **made, norma_document_error *error) {
    gltf_array inverse;
    int there;
    norma_document_result result = norma_gltf_read_inverse(g, skin, count, &inverse, &there, error);
    if (!result) result = norma_gltf_spend(g, skin, count, 16 * sizeof **made, error);
    if (result) return result;
    *made = norma_scene_allocate(g->document->scene, count, 16 * sizeof **made);
    if (!*made) return fail_drawn(g, error);
    return fill_joints(g, list, there ? &inverse : NULL, *made, error);
}

/* A skin's matrices are the same for every node that it moves: they are made once. */
static norma_document_result read_drawn_joints(mover *m, norma_document_error *error) {
    gltf *g = m->g;
    gltf_scene *scene = norma_gltf_scene_of(g);
    uint32_t skin;
    norma_document_result result = norma_gltf_skin_token(g, m->node->skin, &skin, error);
    if (result) return result;
    const uint32_t list = norma_json_member(&g->json, skin, "joints");
    m->joint_count =
        norma_json_is(&g->json, list, JSON_ARRAY) ? norma_json_size(&g->json, list) : 0;
    if (!scene->joints && !(scene->joints = norma_scene_allocate(
                                g->document->scene, g->skin_count, sizeof *scene->joints)))
        return fail_drawn(g, error);
    if (!scene->joints[m->node->skin]) {
        double *made = NULL;
        result = make_joints(g, skin, list, m->joint_count, &made, error);
        if (result) return result;
        scene->joints[m->node->skin] = made;
    }
    m->joints = scene->joints[m->node->skin];
    return NORMA_DOCUMENT_OK;
}

typedef struct influences { /* one set of four joints for each vertex */
    gltf_array joints, weights;
} influences;

enum { MOST_SETS = 8 };

static norma_document_result read_influences(
    const mover *m, influences sets[MOST_SETS], int *count, norma_document_error *error) {
    gltf *g = m->g;
    for (*count = 0; *count < MOST_SETS; ++*count) {
        const uint32_t joints = accessor_of(g, m->p, "JOINTS", *count),
                       weights = accessor_of(g, m->p, "WEIGHTS", *count);
        if (joints == GLTF_NONE || weights == GLTF_NONE) break;
        influences *set = &sets[*count];
        norma_document_result result = norma_gltf_array(g, joints, &set->joints, error);
        if (!result) result = norma_gltf_array(g, weights, &set->weights, error);
        if (result) return result;
        if (set->joints.width != 4 || set->joints.count < m->count ||
            (set->joints.component != GLTF_UBYTE && set->joints.component != GLTF_USHORT))
            return norma_gltf_malformed(g, error, g->accessors[joints].token,
                "four joints for each vertex, as unsigned bytes or shorts");
        if (set->weights.width != 4 || set->weights.count < m->count)
            return norma_gltf_malformed(
                g, error, g->accessors[weights].token, "four weights for each vertex");
    }
    return NORMA_DOCUMENT_OK;
}

/* The mean of the matrices of a vertex's joints by their weights, whose sum need not be 1; without
 * weights, its first joint's. */
static norma_document_result blend_joints(const mover *m, const influences *sets, int count,
    size_t vertex, double matrix[16], norma_document_error *error) {
    double sum = 0;
    uint32_t first = 0;
    memset(matrix, 0, 16 * sizeof *matrix);
    for (int set = 0; set < count; ++set) {
        uint32_t joints[4];
        float weights[4];
        norma_gltf_uints(&sets[set].joints, vertex, joints);
        norma_gltf_floats(&sets[set].weights, vertex, weights);
        if (set == 0) first = joints[0];
        for (int k = 0; k < 4; ++k) {
            if (weights[k] == 0 || !isfinite(weights[k])) continue;
            if (joints[k] >= m->joint_count)
                return norma_document_fail(m->g->document, error, NORMA_DOCUMENT_ERROR_MALFORMED,
                    m->p->where, "vertex %zu names joint %u; its skin has %zu, numbered from 0",
                    vertex, (unsigned)joints[k], m->joint_count);
            sum += (double)weights[k];
            for (int i = 0; i < 16; ++i)
                matrix[i] += (double)weights[k] * m->joints[16 * (size_t)joints[k] + (size_t)i];
        }
    }
    if (sum == 0 && first < m->joint_count)
        memcpy(matrix, m->joints + 16 * (size_t)first, 16 * sizeof *matrix);
    for (int i = 0; i < 16 && sum != 0; ++i) matrix[i] /= sum;
    return NORMA_DOCUMENT_OK;
}

double norma_gltf_normal_matrix(const double m[16], double cofactors[9]) {
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
            const int c1 = (c + 1) % 3, c2 = (c + 2) % 3, r1 = (r + 1) % 3, r2 = (r + 2) % 3;
            cofactors[3 * c + r] =
                m[4 * c1 + r1] * m[4 * c2 + r2] - m[4 * c1 + r2] * m[4 * c2 + r1];
        }
    const double determinant = m[0] * cofactors[0] + m[1] * cofactors[1] + m[2] * cofactors[2];
    for (int i = 0; i < 9 && determinant < 0; ++i) cofactors[i] = -cofactors[i];
    return determinant;
}

/* A matrix of columns, step numbers from one to the next. */
static void apply(const double *m, int step, double v[3]) {
    const double x = v[0], y = v[1], z = v[2];
    for (int r = 0; r < 3; ++r) v[r] = m[r] * x + m[step + r] * y + m[2 * step + r] * z;
}

/* Normals of unit length, so that joints of small scale leave them longer than the least float. */
static void move_direction(float *floats, const double *matrix, int step) {
    double v[3] = {(double)floats[0], (double)floats[1], (double)floats[2]};
    apply(matrix, step, v);
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; ++k) floats[k] = (float)(length > 0 ? v[k] / length : 0);
}

/* Whether the matrix mirrors. */
static int move_vertex(mover *m, size_t vertex, const double matrix[16]) {
    double cofactors[9], *p = m->positions + 3 * vertex;
    const double determinant = norma_gltf_normal_matrix(matrix, cofactors);
    apply(matrix, 4, p);
    for (int k = 0; k < 3; ++k) p[k] += matrix[12 + k];
    if (vertex < m->normal_count) move_direction(m->normals + 3 * vertex, cofactors, 3);
    if (vertex < m->tangent_count) {
        move_direction(m->tangents + 4 * vertex, matrix, 4);
        if (determinant < 0) m->tangents[4 * vertex + 3] *= -1;
    }
    return determinant < 0;
}

/* Faces whose joints mirror face the other way: the mesh is reversed along x, and placed by a
 * matrix that mirrors, as under a node that does. */
static void turn_vertex(mover *m) {
    m->turned = 1;
    for (size_t i = 0; i < m->count; ++i) m->positions[3 * i] *= -1;
    for (size_t i = 0; i < m->normal_count; ++i) m->normals[3 * i] *= -1;
    for (size_t i = 0; i < m->tangent_count; ++i) {
        m->tangents[4 * i] *= -1;
        m->tangents[4 * i + 3] *= -1;
    }
}

static norma_document_result blend_vertices(
    const mover *m, see_blended *see, void *user, norma_document_error *error) {
    influences sets[MOST_SETS];
    int count = 0;
    norma_document_result result = read_influences(m, sets, &count, error);
    for (size_t i = 0; i < m->count && !result; ++i) {
        double matrix[16];
        result = blend_joints(m, sets, count, i, matrix, error);
        if (!result) see(user, i, matrix);
    }
    return result;
}

norma_document_result norma_gltf_blend(gltf *g, uint32_t primitive, const double *joints,
    size_t joint_count, see_blended *see, void *user, norma_document_error *error) {
    const mover m = {.g = g,
        .p = &g->primitives[primitive],
        .count = g->primitives[primitive].vertices,
        .joints = joints,
        .joint_count = joint_count};
    return blend_vertices(&m, see, user, error);
}

static void see_moved(void *user, size_t vertex, const double matrix[16]) {
    mover *m = user;
    m->mirrored += (size_t)move_vertex(m, vertex, matrix);
}

static norma_document_result apply_skin(mover *m, norma_document_error *error) {
    norma_document_result result = read_drawn_joints(m, error);
    if (!result) result = blend_vertices(m, see_moved, m, error);
    if (!result && m->mirrored > m->count / 2) turn_vertex(m);
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
    if (!*copy) return fail_drawn(g, error);
    memcpy(*copy, floats, *count * width * sizeof **copy);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result copy_vertices(mover *m, norma_document_error *error) {
    gltf *g = m->g;
    gltf_array array;
    m->count = m->p->vertices;
    norma_document_result result = norma_gltf_spend(
        g, m->node->token, m->count, 3 * sizeof(double) + 7 * sizeof(float), error);
    if (!result) result = norma_gltf_array(g, m->p->base.position, &array, error);
    if (result) return result;
    m->positions = norma_scene_allocate(g->document->scene, m->count, 3 * sizeof *m->positions);
    if (!m->positions) return fail_drawn(g, error);
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
    norma_document_result result = move(&m, skinned, error);
    made->mesh = mesh;
    made->drawn = (norma_drawn_mesh){.moved = 1,
        .skinned = skinned,
        .positions = {.data = m.positions, .count = m.count, .format = NORMA_FORMAT_DOUBLE},
        .normals = {.data = m.normals, .count = m.normal_count},
        .tangents = m.tangents};
    norma_gltf_matrix_identity(made->drawn.world);
    if (m.turned) made->drawn.world[0] = -1;
    return result;
}

static norma_document_result find_moved(gltf *g, size_t index, size_t mesh, int skinned,
    norma_drawn_mesh *drawn, norma_document_error *error) {
    gltf_scene *scene = norma_gltf_scene_of(g);
    if (!scene->moved && !(scene->moved = norma_scene_allocate(
                               g->document->scene, g->drawing_count, sizeof(gltf_moved *))))
        return fail_drawn(g, error);
    gltf_moved *found = scene->moved[index];
    while (found && found->mesh != mesh) found = found->next;
    if (!found) {
        found = norma_scene_allocate(g->document->scene, 1, sizeof *found);
        norma_document_result result =
            found ? make_moved(g, g->drawing[index], mesh, skinned, found, error)
                  : fail_drawn(g, error);
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
    if (!shown) return fail_drawn(g, error);
    if (p->mesh != at->mesh)
        return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, p->where,
            "node %zu does not draw this mesh", node);
    const int skinned = has_skin(g, at, p);
    drawn->shown = shown[g->drawing[node]] == 1;
    if (skinned || has_weights(g, at, p)) return find_moved(g, node, mesh, skinned, drawn, error);
    for (int i = 0; i < 12; ++i) drawn->world[i] *= unit_or_self(g, p);
    return NORMA_DOCUMENT_OK;
}
