/* run.c: one run over a file or over arrays: options made whole, each mesh through all families of
 * rules, then nodes. */
#include "check/rules/rules.h"
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

static norma_check_profile profile_of(
    const norma_check_options *options, norma_file_format format) {
    if (options->profile == NORMA_CHECK_PROFILE_GENERATED) return NORMA_CHECK_PROFILE_PRINT;
    if (options->profile != NORMA_CHECK_PROFILE_AUTO) return options->profile;
    return format == NORMA_FILE_STL || format == NORMA_FILE_3MF ? NORMA_CHECK_PROFILE_PRINT
                                                                : NORMA_CHECK_PROFILE_RENDER;
}

norma_result norma_check_take_options(
    const norma_check_options *given, norma_check_options *options) {
    const size_t first = offsetof(norma_check_options, whole_components),
                 size = !given               ? 0
                        : given->struct_size ? given->struct_size
                                             : first;
    *options = (norma_check_options){0};
    if (given) memcpy(options, given, size < sizeof *options ? size : sizeof *options);
    for (size_t i = sizeof *options; i < size; ++i)
        if (((const unsigned char *)given)[i]) return NORMA_ERROR_ARGUMENT;
    if (options->profile < NORMA_CHECK_PROFILE_AUTO ||
        options->profile > NORMA_CHECK_PROFILE_GENERATED)
        return NORMA_ERROR_ARGUMENT;
    options->max_samples = options->max_samples ? options->max_samples : 10;
    return NORMA_OK;
}

norma_result norma_check_begin(
    check_run *run, const norma_check_options *options, norma_file_format format) {
    *run = (check_run){.format = format};
    norma_result result = norma_check_take_options(options, &run->options);
    if (result) return result;
    run->profile = profile_of(&run->options, format);
    if (run->options.rules)
        memcpy(run->rules, run->options.rules, sizeof run->rules);
    else
        memset(run->rules, 1, sizeof run->rules);
    norma_options core = {.struct_size = sizeof core,
        .threads = run->options.threads,
        .progress = run->options.progress,
        .progress_user = run->options.progress_user};
    result = norma_core_begin(&run->call, &core);
    if (result) return result;
    run->findings = norma_findings_new(run->options.profile == NORMA_CHECK_PROFILE_GENERATED
                                           ? run->options.profile
                                           : run->profile);
    if (!run->findings) return NORMA_ERROR_MEMORY;
    run->findings->options = run->options;
    memcpy(run->findings->rules, run->rules, sizeof run->rules);
    return NORMA_OK;
}

void norma_check_abandon(check_run *run) {
    norma_findings_free(run->findings);
    run->findings = NULL;
}

norma_findings *norma_check_finish(check_run *run) {
    norma_findings *findings = run->findings;
    run->findings = NULL;
    norma_findings_sort(findings);
    return findings;
}

norma_result norma_check_open_mesh(check_run *run, const norma_check_mesh *given, check_mesh *m) {
    *m = (check_mesh){.run = run,
        .given = given,
        .on_purpose = given->material.double_sided || given->material.not_opaque};
    memcpy(m->rules, run->rules, sizeof m->rules);
    norma_check_silence(m->rules, given->attributes.ignore);
    norma_check_silence(m->rules, given->material.ignore);
    norma_result result = norma_core_mesh_shape(&given->data.mesh, &m->mesh);
    if (!result) result = norma_core_mesh_content(&run->call, &m->mesh);
    m->mesh.scale = 1;
    if (!result && (!norma_format_size(given->data.normals.format) ||
                       (given->data.normals.count && !given->data.normals.data)))
        result = NORMA_ERROR_ARGUMENT;
    return result;
}

void norma_check_close_mesh(check_mesh *m) {
    const core_call *call = &m->run->call;
    norma_core_release(call, m->faces, m->mesh.face_count, sizeof *m->faces);
    norma_core_release(call, m->opposed, m->mesh.face_count, 1);
    norma_core_release(call, (void *)m->far, norma_check_normal_count(m), sizeof *m->far);
    norma_core_release(call, m->users, norma_check_normal_count(m), sizeof *m->users);
    if (m->has_topology) norma_core_topology_close(&m->topology);
    m->faces = NULL;
    m->opposed = NULL;
    m->far = NULL;
    m->users = NULL;
    m->has_topology = 0;
}

/* share: of the time of all, on meshes of many kinds; for progress alone. */
typedef struct check_family {
    norma_result (*run)(check_mesh *m);
    double share;
} check_family;

static norma_result run_mesh(check_run *run, size_t number, size_t order) {
    static const check_family families[] = {
        {norma_check_unplaced, 0},
        {norma_check_lengths, 1},
        {norma_check_placeholder, 1},
        {norma_check_deviation, 15},
        {norma_check_frame, 1},
        {norma_check_facing, 3},
        {norma_check_smoothed, 1},
        {norma_check_facets, 1},
        {norma_check_edges, 40},
        {norma_check_solids, 20},
        {norma_check_open_edges, 1},
        {norma_check_shapes, 1},
        {norma_check_cancelled, 3},
        {norma_check_polygons, 1},
        {norma_check_seams, 1},
        {norma_check_coincident, 10},
        {norma_check_precision, 2},
        {norma_check_missing_normals, 1},
        {norma_check_tangents, 1},
        {norma_check_tangent_deviation, 5},
        {norma_check_morphs, 1},
    };
    enum { SHARES = 110 };
    const double from = run->call.progress_from, to = run->call.progress_to,
                 share = (to - from) / (double)run->group->count / SHARES;
    double done = SHARES * (double)number;
    check_mesh *m = &run->group->each[number];
    norma_core_stage(&run->call, from + share * done, from + share * done);
    norma_result result = norma_check_open_mesh(run, &run->group->meshes[number], m);
    if (result) return result;
    m->number = number;
    m->siblings = run->group->count > 1;
    m->order = order;
    for (size_t i = 0; i < sizeof families / sizeof *families && !result; ++i) {
        norma_core_stage(
            &run->call, from + share * done, from + share * (done + families[i].share));
        done += families[i].share;
        result = families[i].run(m);
    }
    norma_core_stage(&run->call, from, to);
    norma_check_close_mesh(m);
    return result;
}

norma_result norma_check_run_group(
    check_run *run, const norma_check_mesh *meshes, size_t count, const size_t *orders) {
    check_group group = {.meshes = meshes,
        .count = count,
        .each = calloc(count + 1, sizeof *group.each),
        .seams = calloc(count + 1, sizeof *group.seams),
        .solids = calloc(count + 1, sizeof *group.solids)};
    norma_result result = group.each && group.seams && group.solids ? NORMA_OK : NORMA_ERROR_MEMORY;
    group.judge = run->judge ? run->judge : &group.own;
    if (group.judge->is_open) norma_core_side_judge_forget(&group.judge->sides);
    run->group = &group;
    for (size_t i = 0; i < count && !result; ++i)
        result = run_mesh(run, i, orders ? orders[i] : run->next_order++);
    if (!result) result = norma_check_seams_joined(run);
    if (!result) result = norma_check_solids_joined(run);
    norma_check_close_judge(&group.own);
    for (size_t i = 0; i < group.solid_count; ++i) {
        free(group.solids[i]->welded);
        free(group.solids[i]->loose);
    }
    free(group.each);
    free((void *)group.seams);
    free((void *)group.solids);
    run->group = NULL;
    return result;
}

static size_t check_group_size(const norma_check_mesh *meshes, size_t count) {
    size_t size = count > 0;
    while (size < count && norma_check_siblings(&meshes[size - 1].info, &meshes[size].info)) ++size;
    return size;
}

norma_result norma_check_scene_run(
    const norma_check_scene *scene, const norma_check_options *options, norma_findings **findings) {
    check_run run;
    if (!scene || !findings || (scene->mesh_count && !scene->meshes) ||
        (scene->node_count && !scene->nodes) || (scene->skin_count && !scene->skins))
        return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_check_begin(&run, options, scene->format);
    if (result) return result;
    for (size_t i = 0, size; i < scene->mesh_count && !result; i += size) {
        size = check_group_size(&scene->meshes[i], scene->mesh_count - i);
        norma_core_stage(&run.call, (double)i / (double)scene->mesh_count,
            (double)(i + size) / (double)scene->mesh_count);
        result = norma_check_run_group(&run, &scene->meshes[i], size, NULL);
    }
    if (!result) result = norma_check_nodes(&run, scene, NULL, NULL);
    if (result)
        norma_check_abandon(&run);
    else
        *findings = norma_check_finish(&run);
    return result;
}
