/* mikk_tangents.c: MikkTSpace, step by step. */
#include "core/tangent/mikk.h"

/* A counting sort of the triangles' corners by vertex. */
static norma_result sort_corners(mikk_mesh *mesh) {
    const core_mesh triangles = {.positions = {.count = mesh->vertex_count},
        .corners = mesh->triangles,
        .corner_count = 3 * mesh->count,
        .corner_size = 4,
        .face_count = mesh->count};
    return norma_core_corners_of_position_build(mesh->call, &triangles, &mesh->around);
}

static norma_result sort_unsorted(mikk_mesh *mesh) {
    return mesh->is_sorted ? NORMA_OK : sort_corners(mesh);
}

/* A triangle without texture area takes its sign from others, which may take theirs from
 * triangles far away; and a corner of a quad may take the tangent of one with other texture
 * coordinates. */
static int hangs_on_others(const mikk_mesh *mesh) {
    int hangs = 0;
    for (size_t t = 0; t < mesh->count; t++) hangs |= mesh->flags[t] & MIKK_FOLLOWS;
    for (size_t i = 0; i < mesh->copy_count; i++) hangs |= mesh->copies[i].source != MIKK_NONE;
    return hangs != 0;
}

static norma_result run(mikk_mesh *mesh, const tangent_output *output, core_tally *tally) {
    norma_core_stage(mesh->call, 0.3, 0.4);
    norma_result result = norma_core_mikk_triangles(mesh);
    norma_core_stage(mesh->call, 0.4, 0.5);
    if (result == NORMA_OK) result = norma_core_mikk_flags(mesh);
    if (result == NORMA_OK && mesh->input->is_awkward && hangs_on_others(mesh)) {
        *mesh->input->is_awkward = 1;
        return NORMA_OK;
    }
    norma_core_stage(mesh->call, 0.5, 0.6);
    if (result == NORMA_OK) result = sort_unsorted(mesh);
    if (result == NORMA_OK) result = norma_core_mikk_follow(mesh);
    norma_core_stage(mesh->call, 0.6, 0.97);
    return result == NORMA_OK ? norma_core_mikk_stars(mesh, output, tally) : result;
}

static mikk_mesh mikk_of(const tangent_mesh *mesh) {
    return (mikk_mesh){.call = mesh->call,
        .input = mesh,
        .vertices = mesh->vertices,
        .vertex_count = mesh->key_count};
}

norma_result norma_core_mikk_tangents(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally) {
    mikk_mesh mikk = mikk_of(mesh);
    if (!mesh->mesh.corner_count) return NORMA_OK;
    const norma_result result = run(&mikk, output, tally);
    norma_core_mikk_release(&mikk);
    return result;
}

norma_result norma_core_mikk_keep(const tangent_mesh *mesh, mikk_mesh *kept) {
    *kept = mikk_of(mesh);
    norma_result result = norma_core_mikk_triangles(kept);
    if (result == NORMA_OK) result = sort_corners(kept);
    kept->input = NULL;
    kept->vertices = NULL;
    norma_core_release(kept->call, kept->records, 3 * kept->room, sizeof *kept->records);
    kept->records = NULL;
    if (result == NORMA_OK) return NORMA_OK;
    norma_core_mikk_release(kept);
    *kept = (mikk_mesh){.call = NULL};
    return result;
}

void norma_core_mikk_release(mikk_mesh *mesh) {
    const core_call *call = mesh->call;
    norma_core_release(call, mesh->triangles, 3 * mesh->room, sizeof *mesh->triangles);
    norma_core_release(call, mesh->corners, 3 * mesh->room, sizeof *mesh->corners);
    norma_core_release(call, mesh->flags, mesh->room, sizeof *mesh->flags);
    norma_core_release(call, mesh->records, 3 * mesh->room, sizeof *mesh->records);
    norma_core_release(call, mesh->copy_starts, mesh->vertex_count + 1, sizeof *mesh->copy_starts);
    norma_core_release(call, mesh->copies, mesh->copy_count, sizeof *mesh->copies);
    if (mesh->around.starts && !mesh->is_sorted)
        norma_core_corners_of_position_release(call, &mesh->around);
}
