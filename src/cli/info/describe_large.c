/* describe_large.c: what is in a file that does not fit into memory: counted piece by piece. */
#include "cli/info/describe_large.h"
#include "cli/process/memory_limit.h"
#include <norma/large.h>
#include <string.h>

norma_document_result info_describe_large(const char *path, norma_file_format *format,
    cli_progress *progress, norma_mesh_info *info, info_bounds *bounds,
    norma_document_error *error) {
    const norma_large_options options = {
        .struct_size = sizeof options, .max_memory = cli_memory_for_data(), .format = *format};
    norma_large_description found;
    const norma_document_result result =
        norma_large_describe(path, &options, cli_progress_report, progress, &found, error);
    if (result) return result;
    *format = found.format;
    *info = (norma_mesh_info){.name = "",
        .where = "",
        .vertices = found.vertices,
        .faces = found.faces,
        .triangles = found.triangles,
        .normals = found.normals,
        .encoding = found.encoding};
    bounds->known = found.has_bounds;
    memcpy(bounds->least, found.least, sizeof bounds->least);
    memcpy(bounds->most, found.most, sizeof bounds->most);
    return NORMA_DOCUMENT_OK;
}
