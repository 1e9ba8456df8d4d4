/* seam_normals.c: the normals that both sides of a seam get where it runs between two primitives of
 * a glTF mesh (N501): those of the whole mesh. */
#include "check/fix/fix.h"
#include "check/fix/edge_parts.h"
#include <stdlib.h>
#include <string.h>

typedef struct seam_place {
    double position[3];
} seam_place;

static int compare_places(const void *a, const void *b) {
    const seam_place *one = a, *other = b;
    return norma_fix_compare_points(one->position, other->position);
}

static size_t count_samples(const fix_group *g) {
    size_t count, sum = 0;
    const norma_rule *rule = norma_rules(&count) + RULE_N501;
    for (size_t k = 0; k < norma_findings_count(g->findings); k++)
        sum += norma_findings_get(g->findings, k)->rule == rule
                   ? norma_findings_get(g->findings, k)->sample_count
                   : 0;
    return sum;
}

/* Positions that findings at the mesh's primitives name. NULL: out of memory. */
static seam_place *gather_places(const fix_whole *w, size_t *count) {
    const fix_group *g = w->group;
    size_t rules;
    const norma_rule *rule = norma_rules(&rules) + RULE_N501;
    seam_place *places = calloc(count_samples(g) + 1, sizeof *places);
    *count = 0;
    for (size_t i = 0; places && i < g->count; i++)
        for (size_t k = 0; k < norma_findings_count(g->findings); k++) {
            const norma_finding *finding = norma_findings_get(g->findings, k);
            if (finding->rule != rule || !norma_fix_may(g->request, finding) ||
                strcmp(finding->where, g->wheres[i]) != 0)
                continue;
            for (size_t s = 0; s < finding->sample_count; s++)
                if (finding->samples[s].vertex < w->meshes[i].positions.count)
                    norma_core_position(&w->meshes[i], (uint32_t)finding->samples[s].vertex,
                        places[(*count)++].position);
        }
    if (places) qsort(places, *count, sizeof *places, compare_places);
    return places;
}

/* As the first primitive's stored normals show. */
static norma_document_result find_weight(
    const fix_group *g, norma_weight *weight, norma_result *how) {
    const norma_options options = {
        .struct_size = sizeof options, .threads = g->request->options.threads};
    norma_mesh_info info;
    norma_mesh_data data;
    norma_deviation deviation;
    norma_document_result result = norma_document_mesh_info(g->document, g->indices[0], &info);
    if (!result) result = norma_document_mesh_data(g->document, g->indices[0], &data, g->error);
    if (result) return result;
    *how = norma_explain_normals(&data, info.normals, &options, &deviation);
    *weight = !*how && deviation.corners ? deviation.weight : NORMA_WEIGHT_ANGLE;
    return NORMA_DOCUMENT_OK;
}

/* Of each primitive the normals at those places. */
static norma_result share_out(
    const fix_whole *w, const seam_place *places, size_t count, const float *normals) {
    size_t begin = 0;
    for (size_t i = 0; i < w->group->count; begin += w->meshes[i++].positions.count) {
        const size_t vertices = w->meshes[i].positions.count;
        float *smooth = malloc((vertices + 1) * 3 * sizeof *smooth);
        if (!smooth) return NORMA_ERROR_MEMORY;
        w->group->smooth[w->group->indices[i]] = smooth;
        for (size_t v = 0; v < vertices; v++) {
            seam_place key;
            norma_core_position(&w->meshes[i], (uint32_t)v, key.position);
            const int named = bsearch(&key, places, count, sizeof *places, compare_places) != NULL;
            for (size_t k = 0; k < 3; k++)
                smooth[3 * v + k] = named ? normals[3 * (begin + v) + k] : NAN;
        }
    }
    return NORMA_OK;
}

norma_document_result norma_fix_seams(const fix_group *group, norma_result *how) {
    fix_whole w;
    size_t count = 0;
    norma_weight weight = NORMA_WEIGHT_ANGLE;
    float *normals = NULL;
    norma_document_result result = norma_fix_open_whole(group, &w, how);
    seam_place *places = !result && !*how ? gather_places(&w, &count) : NULL;
    if (!result && !*how && !places) *how = NORMA_ERROR_MEMORY;
    if (!result && !*how && count) result = find_weight(group, &weight, how);
    if (!result && !*how && count) {
        const norma_options options = {.struct_size = sizeof options,
            .weight = weight,
            .threads = group->request->options.threads};
        normals = malloc((w.vertices + 1) * 3 * sizeof *normals);
        *how = normals && norma_fix_join(&w)
                   ? norma_vertex_normals(&w.mesh, &options, normals, w.vertices, NULL)
                   : NORMA_ERROR_MEMORY;
        if (!*how) *how = share_out(&w, places, count, normals);
    }
    norma_fix_close_whole(&w);
    free(places);
    free(normals);
    return result;
}
