/* gltf_transform.c: a matrix over a glTF. Without baking it becomes a node above the scenes' roots,
 * and no mesh is touched: animations, skins and instances follow by themselves. Baking is bake.c's.
 */
#include "io/gltf/bake.h"
#include "io/gltf/node_matrix.h"
#include <math.h>
#include <stdlib.h>

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
