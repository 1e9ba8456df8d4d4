/* tangents.c: norma_corner_tangents: arguments, the vertices that corners share, then one of three
 * ways to make tangents. */
#include "core/tangent/tangents.h"

static norma_result compute_corner_tangents(
    tangent_mesh *mesh, tangent_maker *maker, const tangent_output *output, norma_report *report) {
    core_tally tally = {0};
    norma_core_stage(mesh->call, 0.05, 0.3);
    norma_result result = norma_core_tangent_open(mesh);
    if (result) return result;
    norma_core_stage(mesh->call, 0.3, 0.97);
    result = norma_core_finish(mesh->call, maker(mesh, output, &tally));
    norma_core_tangent_close(mesh);
    if (!result) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}

norma_result norma_core_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, tangent_maker *maker, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report) {
    core_call call;
    tangent_mesh checked = {.call = &call};
    tangent_output output;
    norma_result result = norma_core_begin(&call, options);
    if (!result && !maker) result = NORMA_ERROR_ARGUMENT;
    if (!result) result = norma_core_mesh_shape(mesh, &checked.mesh);
    if (!result) norma_core_share(&call, checked.mesh.corner_count);
    if (!result)
        result = norma_core_tangent_attributes(&checked,
            !CORE_IS_SMALL && maker == norma_core_steady_tangents ? NORMA_TANGENTS_STEADY
                                                                  : NORMA_TANGENTS_MIKK,
            normals, texcoords);
    if (!result)
        result = norma_core_tangent_output_open(
            options, tangents, checked.mesh.corner_count, capacity, &output);
    norma_core_stage(&call, 0, 0.05);
    if (!result) result = norma_core_mesh_content(&call, &checked.mesh);
    if (result) return result;
    norma_core_gather(&call);
    result = compute_corner_tangents(&checked, maker, &output, report);
    norma_core_dismiss(&call);
    return result;
}

norma_result norma_corner_tangents(const norma_mesh *mesh, const norma_attribute *normals,
    const norma_attribute *texcoords, norma_tangent_mode mode, const norma_options *options,
    float *tangents, size_t capacity, norma_report *report) {
    tangent_maker *maker = mode == NORMA_TANGENTS_MIKK ? norma_core_mikk_tangents
                           : !CORE_IS_SMALL && mode == NORMA_TANGENTS_STEADY
                               ? norma_core_steady_tangents
                               : NULL;
    return norma_core_corner_tangents(
        mesh, normals, texcoords, maker, options, tangents, capacity, report);
}
