/* sides.c: where normals and winding disagree (N201, N205), or neighbours do (N301), which faces
 * are turned: those that are shown to be, by the volume of what is closed and by rays from what is
 * open. Rays say nothing of a material that is seen from both sides. The primitives of a glTF mesh
 * are looked at together. */
#include "check/fix/fix.h"
#include "check/rules/rules.h"
#include "core/topology/topology.h"
#include <stdlib.h>
#include <string.h>

/* 1: its material is double-sided, or not opaque. */
static norma_document_result is_on_purpose(const fix_group *group, size_t index, int *on_purpose) {
    norma_mesh_attributes attributes;
    norma_material_info material;
    *on_purpose = 0;
    norma_document_result result =
        norma_document_mesh_attributes(group->document, index, &attributes, group->error);
    if (result || attributes.material >= norma_document_material_count(group->document))
        return result;
    result = norma_document_material_info(group->document, attributes.material, &material);
    *on_purpose = !result && (material.double_sided || material.not_opaque);
    return result;
}

static norma_document_result share_out(
    const fix_whole *whole, const uint8_t *sides, norma_result *how) {
    const fix_group *group = whole->group;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < group->count && !result; sides += whole->meshes[i++].face_count) {
        const size_t faces = whole->meshes[i].face_count;
        int on_purpose;
        uint8_t *own = malloc(faces + 1);
        if (!own) {
            *how = NORMA_ERROR_MEMORY;
            return result;
        }
        memcpy(own, sides, faces);
        group->sides[group->indices[i]] = own;
        result = is_on_purpose(group, group->indices[i], &on_purpose);
        for (size_t f = 0; f < faces && !result && on_purpose; f++)
            if (own[f] & CORE_SIDE_BY_RAYS) own[f] |= CORE_SIDE_UNDECIDED;
    }
    return result;
}

/* The faces whose sides matter: those that are named, those that are turned with a whole body, and
 * those at edges that two faces run along the same way. Rays are cast from the pieces of these
 * alone, as the rules do. NULL: out of memory. */
static uint8_t *mark_asked(const fix_whole *whole, const core_topology *topology) {
    static const check_rule rules[] = {RULE_N201, RULE_N205};
    const fix_group *group = whole->group;
    uint8_t *asked = calloc(whole->face_count + 1, 1);
    if (!asked) return NULL;
    (void)norma_check_count_conflicts(topology, asked);
    for (size_t i = 0; i < sizeof rules / sizeof *rules; i++)
        (void)norma_fix_mark_named(whole, rules[i], asked);
    size_t begin = 0;
    for (size_t i = 0; i < group->count; begin += whole->meshes[i++].face_count) {
        const uint8_t *turned = group->turned[group->indices[i]];
        for (size_t f = 0; turned && f < whole->meshes[i].face_count; f++)
            asked[begin + f] |= turned[f];
    }
    return asked;
}

/* Those of an STL by their stored normals, where nothing else decides. */
static norma_document_result judge_whole(fix_whole *whole, uint8_t *sides, norma_result *how) {
    const fix_group *group = whole->group;
    const norma_options options = {
        .struct_size = sizeof options, .threads = group->request->options.threads};
    core_side_judge judge;
    norma_mesh_info info;
    norma_mesh_data data;
    norma_document_result result =
        norma_document_mesh_info(group->document, group->indices[0], &info);
    if (!result)
        result = norma_document_mesh_data(group->document, group->indices[0], &data, group->error);
    if (result || !whole->face_count) return result;
    *how = norma_core_side_judge_open(&whole->mesh, &options, &judge);
    if (*how) return result;
    uint8_t *asked = mark_asked(whole, &judge.topology);
    *how = asked ? norma_core_side_judge_ask(&judge, 0, whole->face_count, asked, sides)
                 : NORMA_ERROR_MEMORY;
    free(asked);
    if (!*how && info.normals == NORMA_NORMALS_PER_FACET)
        *how = norma_check_sides_by_facets(&judge, &data.normals, sides);
    norma_core_side_judge_close(&judge);
    return result;
}

norma_document_result norma_fix_sides(const fix_group *group, norma_result *how) {
    fix_whole whole;
    norma_document_result result = norma_fix_open_whole(group, &whole, how);
    uint8_t *sides = !result && !*how ? malloc(whole.face_count + 1) : NULL;
    if (!result && !*how && !(sides && norma_fix_join(&whole))) *how = NORMA_ERROR_MEMORY;
    if (!result && !*how) result = judge_whole(&whole, sides, how);
    if (!result && !*how) result = share_out(&whole, sides, how);
    norma_fix_close_whole(&whole);
    free(sides);
    return result;
}
