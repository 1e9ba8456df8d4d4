/* gltf_transform.c: a matrix over an asset, and meshes moved near their origin. */
#include "io/gltf/gltf.h"
#include "io/format/format.h"
#include <math.h>
#include <stdlib.h>

/* ---- Positions of a glTF mesh brought near its origin; each node that drew it gets a
 * node below it, which draws it now and says how far it was moved: whatever moves the node, and
 * whatever else hangs on it, is as it was. */

typedef struct recentring {
    gltf *g;
    gltf_tree tree;
    unsigned char *flags; /* of nodes */
    unsigned char *moved; /* of meshes */
    double (*steps)[3];
} recentring;

/* ---- which meshes can be moved */

/* Where skins, instances or animated weights hang on the node that draws a mesh, another node
 * cannot take it over. */
static const char *obstacle_of(const recentring *r, uint32_t mesh) {
    const gltf *g = r->g;
    const char *obstacle = norma_gltf_bake_obstacle(g, mesh);
    for (uint32_t i = 0; i < g->drawing_count && !obstacle; ++i) {
        const gltf_node *node = &g->nodes[g->drawing[i]];
        if (node->mesh == mesh)
            obstacle = node->skin != GLTF_NONE                  ? "is drawn with a skin"
                       : node->instanced                        ? "is drawn by instancing"
                       : r->flags[g->drawing[i]] & BAKE_WEIGHTS ? "has animated weights"
                                                                : NULL;
    }
    return obstacle ? obstacle : g->meshes[mesh].uses == 0 ? "is drawn by no node" : NULL;
}

static int is_float(const gltf *g, uint32_t accessor) {
    return accessor != GLTF_NONE && g->accessors[accessor].component == GLTF_FLOAT &&
           g->accessors[accessor].width == 3;
}

static norma_document_result measure_offset(
    recentring *r, uint32_t mesh, int *fits, norma_document_error *error) {
    gltf *g = r->g;
    recentre_box box = norma_recentre_empty();
    *fits = 1;
    for (uint32_t i = 0; i < g->meshes[mesh].primitive_count && *fits; ++i) {
        const gltf_primitive *p = &g->primitives[g->meshes[mesh].first_primitive + i];
        gltf_array array;
        *fits = is_float(g, p->base.position);
        norma_document_result result =
            *fits ? norma_gltf_array(g, p->base.position, &array, error) : NORMA_DOCUMENT_OK;
        if (result) return result;
        for (size_t v = 0; *fits && v < array.count; ++v) {
            float element[16];
            norma_gltf_floats(&array, v, element);
            norma_recentre_add(&box,
                (const double[3]){(double)element[0], (double)element[1], (double)element[2]});
        }
    }
    *fits = *fits && norma_recentre_step(&box, r->steps[mesh]);
    return NORMA_DOCUMENT_OK;
}

/* ---- moving one */

static norma_document_result move_mesh_positions(
    recentring *r, uint32_t primitive, const double step[3], norma_document_error *error) {
    gltf *g = r->g;
    gltf_array array;
    gltf_data data;
    norma_document_result result =
        norma_gltf_array(g, g->primitives[primitive].base.position, &array, error);
    double *values = result ? NULL : norma_io_allocate(array.count + 1, 3 * sizeof *values);
    if (!values) return result ? result : norma_document_fail_memory(g->document, error);
    for (size_t v = 0; v < array.count; ++v) {
        float element[16];
        norma_gltf_floats(&array, v, element);
        for (size_t axis = 0; axis < 3; ++axis)
            values[3 * v + axis] = (double)element[axis] - step[axis];
    }
    const bake_encoded encoded = norma_gltf_encode(BAKE_POSITIONS, &array, values, &data);
    free(values);
    if (encoded) return norma_document_fail_memory(g->document, error);
    data.bounds = 1;
    const gltf_slot slot = {
        .primitive = primitive, .target = GLTF_SLOT_BASE, .attribute = "POSITION"};
    return norma_gltf_put_new(g, &slot, &data, error);
}

static void move_node(gltf_tree *tree, uint32_t node, const double step[3]) {
    const double local[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, step[0], step[1], step[2], 1};
    const uint32_t below = norma_gltf_tree_add(tree, node);
    if (below == GLTF_NONE) return;
    tree->nodes[below].mesh = tree->g->nodes[node].mesh;
    tree->nodes[below].takes_weights = tree->nodes[node].weights_removed = 1;
    tree->nodes[node].mesh = GLTF_NONE;
    tree->nodes[node].mesh_changed = 1;
    norma_gltf_tree_set_local(tree, below, local);
    norma_gltf_tree_give(tree, below, node);
}

static norma_document_result move_mesh(recentring *r, uint32_t mesh, norma_document_error *error) {
    gltf *g = r->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t i = 0; i < g->meshes[mesh].primitive_count && !result; ++i)
        result = move_mesh_positions(r, g->meshes[mesh].first_primitive + i, r->steps[mesh], error);
    for (uint32_t i = 0; i < g->drawing_count && !result; ++i)
        if (g->nodes[g->drawing[i]].mesh == mesh)
            move_node(&r->tree, g->drawing[i], r->steps[mesh]);
    return result;
}

/* ---- all of them */

static norma_document_result move_meshes(recentring *r, int *changed, norma_document_error *error) {
    gltf *g = r->g;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (uint32_t mesh = 0; mesh < g->mesh_count && !result; ++mesh) {
        const char *obstacle = r->moved[mesh] ? obstacle_of(r, mesh) : NULL;
        int fits = 0;
        if (obstacle)
            norma_document_add_note(
                g->document, "mesh %u %s: its origin stays where it is", mesh, obstacle);
        else if (r->moved[mesh])
            result = measure_offset(r, mesh, &fits, error);
        if (!result && fits) result = move_mesh(r, mesh, error);
        *changed |= fits;
    }
    return result || !*changed ? result : norma_gltf_tree_write(&r->tree, error);
}

norma_document_result norma_gltf_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error) {
    recentring r = {.g = norma_gltf_of(document)};
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_gltf_begin_change(r.g);
    if (result) return result;
    norma_gltf_tree_read(r.g, &r.tree);
    uint32_t *order = norma_gltf_bake_order(r.g, &r.tree);
    r.flags = order ? norma_gltf_bake_flags(r.g, order) : NULL;
    r.moved = norma_io_allocate((size_t)r.g->mesh_count + 1, 1);
    r.steps = norma_io_allocate((size_t)r.g->mesh_count + 1, sizeof *r.steps);
    if (!r.flags || !r.moved || !r.steps || r.tree.failed)
        result = norma_document_fail_memory(document, error);
    for (uint32_t i = 0; i < r.g->primitive_count && !result; ++i)
        r.moved[r.g->primitives[i].mesh] |= !meshes || meshes[i];
    if (!result) result = move_meshes(&r, changed, error);
    if (!result && *changed) result = norma_gltf_finish(r.g, error);
    norma_gltf_tree_free(&r.tree);
    free(order);
    free(r.flags);
    free(r.moved);
    free(r.steps);
    return result;
}

/* ---- A matrix over a glTF. Without baking it becomes a node above the scenes' roots,
 * and no mesh is touched: animations, skins and instances follow by themselves. Baking is bake.c's.
 */

/* What a node's matrix may be off from translation, rotation and scale: columns perpendicular to a
 * relative 1e-5, as norma_kind has it. */
static const double shear_tolerance = 1e-5;

static norma_document_result check_matrix(
    const gltf *g, const double matrix[16], norma_document_error *error) {
    gltf_trs trs;
    const double shear = norma_gltf_matrix_decompose(matrix, &trs);
    if (shear > shear_tolerance)
        return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "the matrix is sheared, which no glTF node can hold; expected translation, rotation "
            "and scale, or baking (--bake)");
    return NORMA_DOCUMENT_OK;
}

/* What is drawn by some node is what the matrix acts on. */
static void count_drawn(const gltf *g, norma_transform_summary *summary) {
    for (uint32_t i = 0; i < g->mesh_count; i++) {
        if (g->meshes[i].uses == 0) continue;
        summary->meshes++;
        for (uint32_t k = 0; k < g->meshes[i].primitive_count; k++)
            summary->vertices += g->primitives[g->meshes[i].first_primitive + k].vertices;
    }
}

/* A skinned mesh goes by its joints: one without children stays a root, as validators want it. */
static norma_document_result raise_all(
    gltf *g, const double matrix[16], norma_document_error *error) {
    gltf_tree tree;
    unsigned char *wanted = norma_io_allocate((size_t)g->node_count + 1, 1);
    norma_gltf_tree_read(g, &tree);
    norma_document_result result =
        wanted ? NORMA_DOCUMENT_OK : norma_document_fail_memory(g->document, error);
    for (uint32_t i = 0; wanted && !tree.failed && i < g->node_count; i++)
        wanted[i] = !(g->nodes[i].skin != GLTF_NONE && tree.nodes[i].first == GLTF_NONE);
    if (!result) {
        norma_gltf_tree_raise(&tree, wanted, matrix);
        result = norma_gltf_tree_write(&tree, error);
    }
    free(wanted);
    norma_gltf_tree_free(&tree);
    return result;
}

norma_document_result norma_gltf_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error) {
    gltf *g = norma_gltf_of(document);
    norma_matrix_info info;
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_gltf_begin_change(g);
    double normal[9];
    if (result) return result;
    norma_normal_matrix_double(options->matrix, NORMA_WINDING_KEPT, normal, &info);
    summary->mirrored = info.mirrored;
    if (g->node_count == 0) {
        norma_document_add_note(document, "no node draws anything: there is nothing to transform");
    } else if (options->bake) {
        result = norma_gltf_bake(g, options, summary, error);
    } else if (!norma_gltf_matrix_is_identity(options->matrix)) {
        result = check_matrix(g, options->matrix, error);
        count_drawn(g, summary);
        if (!result) result = raise_all(g, options->matrix, error);
    }
    if (!result) result = norma_gltf_finish(g, error);
    summary->changed = g->changed;
    return result;
}
