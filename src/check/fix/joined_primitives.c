/* joined_primitives.c: the primitives of a glTF mesh, or the one mesh of another file, side by
 * side, and joined to one mesh where that is wanted. */
#include "check/fix/fix.h"
#include <stdlib.h>

norma_document_result norma_fix_open_whole(
    const fix_group *group, fix_whole *whole, norma_result *how) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    *whole = (fix_whole){.group = group, .meshes = calloc(group->count + 1, sizeof *whole->meshes)};
    *how = whole->meshes ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < group->count && !result && !*how; i++) {
        norma_mesh_data data;
        core_mesh *mesh = &whole->meshes[i];
        result = norma_document_mesh_data(group->document, group->indices[i], &data, group->error);
        if (result) break;
        *how = norma_core_mesh_shape(&data.mesh, mesh);
        mesh->scale = 1;
        whole->vertices += mesh->positions.count;
        whole->corner_count += mesh->corner_count;
        whole->face_count += mesh->face_count;
    }
    if (!result && !*how && (whole->corner_count >= UINT32_MAX || whole->vertices >= UINT32_MAX))
        *how = NORMA_ERROR_OVERFLOW;
    return result;
}

void norma_fix_close_whole(fix_whole *whole) {
    free(whole->meshes);
    free(whole->positions);
    free(whole->corners);
    free(whole->starts);
}

int norma_fix_join(fix_whole *whole) {
    size_t vertex = 0, corner = 0, face = 0;
    if (whole->mesh.face_starts) return 1; /* it is done */
    whole->positions = malloc((whole->vertices + 1) * 3 * sizeof *whole->positions);
    whole->corners = malloc((whole->corner_count + 1) * sizeof *whole->corners);
    whole->starts = malloc((whole->face_count + 1) * sizeof *whole->starts);
    if (!whole->positions || !whole->corners || !whole->starts) return 0;
    for (size_t i = 0; i < whole->group->count; i++) {
        const core_mesh *mesh = &whole->meshes[i];
        for (size_t v = 0; v < mesh->positions.count; v++)
            norma_view_read(&mesh->positions, v, whole->positions + 3 * (vertex + v));
        for (size_t f = 0; f < mesh->face_count; f++)
            whole->starts[face++] = (uint32_t)(corner + norma_core_face_begin(mesh, f));
        for (size_t c = 0; c < mesh->corner_count; c++)
            whole->corners[corner + c] = (uint32_t)vertex + norma_core_corner(mesh, c);
        vertex += mesh->positions.count;
        corner += mesh->corner_count;
    }
    whole->starts[face] = (uint32_t)corner;
    whole->mesh = (norma_mesh){.positions = {whole->positions, vertex, 0, NORMA_FORMAT_DOUBLE},
        .corners = whole->corners,
        .corner_count = corner,
        .face_starts = whole->starts,
        .face_count = face};
    return 1;
}
