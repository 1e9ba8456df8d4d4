/* calls.c: the library's calls as WebAssembly exports, those that norma-mesh/normals has as well:
 * numbers and addresses only, so that JavaScript lays out no structure. Angles come in degrees, as
 * they do on the command line, and become radians here, so that both round alike. */
#include "calls.h"
#include "exports.h"
#include <stdlib.h>

#define PI 3.141592653589793

float web_radians(double degrees) { return (float)(degrees * (PI / 180)); }

/* ---- memory: blocks of the heap, and one each of what a call takes by address */

void *WEB_EXPORT(web_allocate)(size_t bytes) { return malloc(bytes ? bytes : 1); }
void WEB_EXPORT(web_release)(void *block) { free(block); }
const char *WEB_EXPORT(web_result_text)(norma_result result) { return norma_result_text(result); }
const char *WEB_EXPORT(web_version)(void) { return norma_version(); }

norma_mesh web_mesh(const web_mesh_arguments *given) {
    return (norma_mesh){.positions = {given->positions, given->position_count,
                            given->position_stride, given->format},
        .corners = given->corners,
        .corner_count = given->corners ? given->corner_count : given->position_count,
        .corner_size = given->corner_size};
}

norma_options web_options(const web_mesh_arguments *given) {
    return (norma_options){.weight = given->weight,
        .weld = given->weld,
        .weld_distance = given->weld_distance,
        .non_manifold = given->non_manifold,
        .fallback = given->fallback};
}

/* The arguments that every call on a mesh takes, in the order in which JavaScript hands them over.
 */
#define MESH_PARAMETERS                                                                            \
    const void *positions, size_t position_count, size_t position_stride, norma_format format,     \
        const void *corners, size_t corner_count, size_t corner_size, norma_weight weight,         \
        norma_weld weld, double weld_distance, norma_non_manifold non_manifold,                    \
        norma_fallback fallback
#define MESH_ARGUMENTS                                                                             \
    const web_mesh_arguments given = {positions, position_count, position_stride, format, corners, \
        corner_count, corner_size, weight, weld, weld_distance, non_manifold, fallback};           \
    const norma_mesh mesh = web_mesh(&given);                                                      \
    const norma_options options = web_options(&given)

/* report: NULL where nobody asked for the counts; else written, see web_report_counts. */
norma_result WEB_EXPORT(web_face_normals)(
    MESH_PARAMETERS, float *normals, size_t capacity, norma_report *report) {
    MESH_ARGUMENTS;
    return norma_face_normals(&mesh, &options, normals, capacity, report);
}

norma_result WEB_EXPORT(web_vertex_normals)(
    MESH_PARAMETERS, float *normals, size_t capacity, norma_report *report) {
    MESH_ARGUMENTS;
    return norma_vertex_normals(&mesh, &options, normals, capacity, report);
}

norma_result WEB_EXPORT(web_corner_normals)(
    MESH_PARAMETERS, float *normals, size_t capacity, norma_report *report, double crease_deg) {
    MESH_ARGUMENTS;
    return norma_corner_normals(
        &mesh, web_radians(crease_deg), &options, normals, capacity, report);
}

norma_result WEB_EXPORT(web_split)(MESH_PARAMETERS, float *normals, size_t vertex_capacity,
    norma_report *report, double crease_deg, uint32_t *new_corners, size_t corner_capacity,
    uint32_t *source_vertices, size_t *vertex_count) {
    MESH_ARGUMENTS;
    return norma_split(&mesh, web_radians(crease_deg), &options, new_corners, corner_capacity,
        source_vertices, normals, vertex_capacity, vertex_count, report);
}

/* counts: degenerate faces, non-finite, unreferenced and cancelled elements, non-manifold edges,
 * winding conflicts. */
void WEB_EXPORT(web_report_counts)(const norma_report *report, double counts[6]) {
    const norma_count all[] = {report->degenerate_faces, report->non_finite, report->unreferenced,
        report->cancelled, report->non_manifold_edges, report->winding_conflicts};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i) counts[i] = (double)all[i].count;
}
size_t WEB_EXPORT(web_report_size)(void) { return sizeof(norma_report); }

/* ---- tangents */

norma_result WEB_EXPORT(web_corner_tangents)(const void *positions, size_t position_count,
    size_t position_stride, norma_format format, const void *corners, size_t corner_count,
    size_t corner_size, const void *normals, size_t normal_count, size_t normal_stride,
    norma_format normal_format, norma_element normals_of, const void *texcoords,
    size_t texcoord_count, size_t texcoord_stride, norma_format texcoord_format,
    norma_element texcoords_of, norma_tangent_mode mode, norma_weight weight, float *tangents,
    size_t capacity, norma_report *report) {
    const web_mesh_arguments given = {positions, position_count, position_stride, format, corners,
        corner_count, corner_size, weight, NORMA_WELD_EXACT, 0, NORMA_NON_MANIFOLD_HARD,
        NORMA_FALLBACK_ZERO};
    const norma_mesh mesh = web_mesh(&given);
    const norma_options options = web_options(&given);
    const norma_attribute normal_values = {.data = normals,
        .count = normal_count,
        .stride = normal_stride,
        .format = normal_format,
        .of = normals_of};
    const norma_attribute texcoord_values = {.data = texcoords,
        .count = texcoord_count,
        .stride = texcoord_stride,
        .format = texcoord_format,
        .of = texcoords_of};
    return norma_corner_tangents(
        &mesh, &normal_values, &texcoord_values, mode, &options, tangents, capacity, report);
}

/* ---- matrices */

norma_result WEB_EXPORT(web_normal_matrices)(
    const float *models, size_t count, norma_winding winding, float *normal_matrices) {
    return norma_normal_matrices(models, count, winding, normal_matrices, count);
}
