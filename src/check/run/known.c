/* known.c: what another document has shown already. A trial of a fix changes few meshes of its
 * copy, and of those often the normals alone: only what may differ is looked at again, the rest of
 * the findings are copied. */
#include "check/run/run.h"
#include <stdlib.h>
#include <string.h>

/* Rules that look at positions and corners only, and at whether there are normals. */
static int is_of_surface(check_rule rule) {
    return (rule >= RULE_N301 && rule <= RULE_N307) || (rule >= RULE_N401 && rule <= RULE_N405) ||
           rule == RULE_N502 || rule == RULE_N503 || rule == RULE_N701;
}

/* ---- whether meshes are the same */

static int is_same_array(const void *a, const void *b, size_t count, size_t size) {
    return a == b || (a && b && memcmp(a, b, count * size) == 0);
}

static int is_same_view(const norma_vec3_view *a, const norma_vec3_view *b) {
    const size_t size = 3 * norma_format_size(a->format);
    const char *p = a->data, *q = b->data;
    if (a->count != b->count || a->format != b->format) return 0;
    if (norma_view_stride(a) == size && norma_view_stride(b) == size)
        return is_same_array(p, q, a->count, size);
    for (size_t i = 0; i < a->count; i++, p += norma_view_stride(a), q += norma_view_stride(b))
        if (memcmp(p, q, size) != 0) return 0;
    return 1;
}

static int is_same_surface(const norma_mesh *a, const norma_mesh *b) {
    const size_t faces = a->face_starts ? a->face_count : a->corner_count / 3;
    return is_same_view(&a->positions, &b->positions) && a->corner_count == b->corner_count &&
           a->corner_size == b->corner_size && a->face_count == b->face_count &&
           is_same_array(
               a->corners, b->corners, a->corner_count, a->corner_size ? a->corner_size : 4) &&
           is_same_array(a->face_starts, b->face_starts, faces + 1, sizeof *a->face_starts) &&
           is_same_array(
               a->smoothing_groups, b->smoothing_groups, faces, sizeof *a->smoothing_groups) &&
           is_same_array(a->hard_edges, b->hard_edges, a->corner_count, sizeof *a->hard_edges);
}

static int is_same_material(const norma_material_info *a, const norma_material_info *b) {
    return a->double_sided == b->double_sided && a->unlit == b->unlit &&
           a->not_opaque == b->not_opaque && a->normal_map == b->normal_map &&
           a->normal_texcoord == b->normal_texcoord &&
           memcmp(a->normal_turn, b->normal_turn, sizeof a->normal_turn) == 0 &&
           strcmp(a->ignore ? a->ignore : "", b->ignore ? b->ignore : "") == 0;
}

static int is_same_attributes(
    const norma_mesh_attributes *a, const norma_mesh_attributes *b, const norma_mesh *mesh) {
    const size_t faces = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3;
    return a->texcoord_count == b->texcoord_count && a->tangent_count == b->tangent_count &&
           a->normals_missing == b->normals_missing && a->normals_surplus == b->normals_surplus &&
           a->normals_out_of_range == b->normals_out_of_range &&
           strcmp(a->tangent_encoding, b->tangent_encoding) == 0 &&
           memcmp(a->texcoord_turn, b->texcoord_turn, sizeof a->texcoord_turn) == 0 &&
           is_same_array(a->face_materials, b->face_materials, faces, sizeof *a->face_materials) &&
           is_same_array(a->texcoords, b->texcoords, a->texcoord_count, 2 * sizeof(float)) &&
           is_same_array(a->corner_texcoords, b->corner_texcoords, mesh->corner_count,
               sizeof *a->corner_texcoords) &&
           is_same_array(a->colors, b->colors, mesh->positions.count, 4 * sizeof(float)) &&
           is_same_array(a->tangents, b->tangents, a->tangent_count, 4 * sizeof(float)) &&
           is_same_array(a->face_faults, b->face_faults, faces, 1);
}

static int is_same_normals(const norma_check_mesh *a, const norma_check_mesh *b) {
    return strcmp(a->info.encoding, b->info.encoding) == 0 &&
           is_same_view(&a->data.normals, &b->data.normals) &&
           is_same_array(a->data.corner_normals, b->data.corner_normals, a->data.mesh.corner_count,
               sizeof *a->data.corner_normals);
}

static int is_same_morphs(const norma_check_mesh *a, const norma_check_mesh *b) {
    if (a->morph_count != b->morph_count) return 0;
    for (size_t i = 0; i < a->morph_count; i++)
        if (!is_same_view(&a->morphs[i].positions, &b->morphs[i].positions) ||
            !is_same_view(&a->morphs[i].normals, &b->morphs[i].normals) ||
            !is_same_view(&a->morphs[i].tangents, &b->morphs[i].tangents))
            return 0;
    return 1;
}

check_change norma_check_compare(const norma_check_mesh *a, const norma_check_mesh *b) {
    if (strcmp(a->info.where, b->info.where) != 0 || a->info.normals != b->info.normals ||
        a->attributes.material != b->attributes.material ||
        strcmp(a->attributes.ignore, b->attributes.ignore) != 0 ||
        !is_same_material(&a->material, &b->material) ||
        !is_same_surface(&a->data.mesh, &b->data.mesh))
        return CHECK_ALL_CHANGED;
    return is_same_normals(a, b) && is_same_morphs(a, b) &&
                   is_same_attributes(&a->attributes, &b->attributes, &a->data.mesh)
               ? CHECK_SAME
           /* Of an STL's facets the normals are evidence for their windings. */
           : a->info.normals == NORMA_NORMALS_PER_FACET ? CHECK_ALL_CHANGED
                                                        : CHECK_SAME_SURFACE;
}

/* ---- what is not looked at again */

void norma_check_leave_known(uint8_t rules[CHECK_RULE_COUNT], check_change change) {
    for (size_t rule = 0; rule < CHECK_RULE_COUNT; rule++)
        if (change == CHECK_SAME ||
            (change == CHECK_SAME_SURFACE && is_of_surface((check_rule)rule)))
            rules[rule] = 0;
}
