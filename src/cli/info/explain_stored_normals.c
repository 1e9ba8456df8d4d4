/* explain_stored_normals.c: which weight and crease explain the normals of a document's mesh, and
 * which way its tangents, in degrees. */
#include "cli/info/explain_stored_normals.h"
#include "cli/text/report_text.h"
#include <math.h>

static norma_document_result fail_search(
    norma_document_error *error, const char *what, norma_result result) {
    error->result =
        result == NORMA_ERROR_MEMORY ? NORMA_DOCUMENT_ERROR_MEMORY : NORMA_DOCUMENT_ERROR_MALFORMED;
    snprintf(error->message, sizeof error->message, "stored %s cannot be explained: %s", what,
        norma_result_text(result));
    return error->result;
}

/* Whole degrees went in; they come out so. */
static double whole_degrees(double radians) {
    return isnan(radians) ? radians : rint(cli_to_degrees(radians) * 1e6) / 1e6;
}

int cli_explain_normals(norma_document *document, size_t mesh, uint32_t threads,
    cli_explained *explained, norma_document_result *result, norma_document_error *error) {
    norma_mesh_info info;
    norma_mesh_data data;
    norma_deviation deviation;
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    *result = norma_document_mesh_info(document, mesh, &info);
    if (*result || info.not_read || info.normals == NORMA_NORMALS_NONE || info.faces == 0) return 0;
    *result = norma_document_mesh_data(document, mesh, &data, error);
    if (*result) return 0;
    norma_result failed = norma_explain_normals(&data, info.normals, &options, &deviation);
    if (failed) *result = fail_search(error, "normals", failed);
    if (failed || !deviation.corners) return 0;
    *explained = (cli_explained){
        .weight = deviation.weight,
        .crease_deg = whole_degrees(deviation.crease_angle_rad),
        .flat = deviation.shading == NORMA_SHADING_FLAT,
        .p50_deg = cli_to_degrees(deviation.p50_rad),
        .p99_deg = cli_to_degrees(deviation.p99_rad),
        .max_deg = cli_to_degrees(deviation.max_rad),
    };
    return 1;
}

int cli_explain_tangents(norma_document *document, size_t mesh, uint32_t threads,
    cli_explained_tangents *explained, norma_document_result *result, norma_document_error *error) {
    norma_mesh_info info;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    norma_tangent_deviation *deviation = &explained->deviation;
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    *result = norma_document_mesh_info(document, mesh, &info);
    if (*result || info.not_read || !info.has_tangents || info.faces == 0) return 0;
    *result = norma_document_mesh_data(document, mesh, &data, error);
    if (!*result) *result = norma_document_mesh_attributes(document, mesh, &attributes, error);
    if (*result) return 0;
    const norma_result failed = norma_explain_tangents(&data, &attributes, &options, deviation);
    if (failed) *result = fail_search(error, "tangents", failed);
    if (failed || !deviation->corners) return 0;
    explained->p50_deg = cli_to_degrees(deviation->p50_rad);
    explained->p99_deg = cli_to_degrees(deviation->p99_rad);
    explained->max_deg = cli_to_degrees(deviation->max_rad);
    return 1;
}
