/* document_options.c: small things that every format needs: checked allocation, compute options as
 * the core's, sums of reports, formats and their names. */
#include "io/format/format.h"
#include <stdlib.h>
#include <string.h>

int norma_document_load_file(const norma_document *document, const char *path, file_bytes *bytes) {
    const file_reading how = {
        .progress = document->progress, .progress_user = document->progress_user};
    return norma_file_open(path, &how, bytes);
}

void norma_options_of_compute(const norma_compute_options *options, norma_options *core) {
    *core = (norma_options){
        .struct_size = sizeof *core,
        .weight = options->weight,
        .weld = options->weld,
        .weld_distance = options->weld_distance,
        .non_manifold = options->non_manifold,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = options->threads,
        .progress = options->progress,
        .progress_user = options->progress_user,
    };
}

static void add_count(norma_count *sum, const norma_count *count, size_t meshes_before) {
    if (meshes_before == 0) {
        *sum = *count;
        return;
    }
    sum->count += count->count;
    sum->first = SIZE_MAX;
}

void norma_add_report(norma_report *sum, const norma_report *report, size_t meshes_before) {
    add_count(&sum->degenerate_faces, &report->degenerate_faces, meshes_before);
    add_count(&sum->non_finite, &report->non_finite, meshes_before);
    add_count(&sum->unreferenced, &report->unreferenced, meshes_before);
    add_count(&sum->cancelled, &report->cancelled, meshes_before);
    add_count(&sum->non_manifold_edges, &report->non_manifold_edges, meshes_before);
    add_count(&sum->winding_conflicts, &report->winding_conflicts, meshes_before);
}

static const struct {
    norma_file_format format;
    const char *name; /* and the extension */
} formats[] = {
    {NORMA_FILE_OBJ, "obj"},
    {NORMA_FILE_PLY, "ply"},
    {NORMA_FILE_STL, "stl"},
    {NORMA_FILE_GLTF, "gltf"},
    {NORMA_FILE_GLB, "glb"},
};
enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };

const char *norma_file_format_name(norma_file_format format) {
    for (size_t i = 0; i < FORMAT_COUNT; ++i)
        if (formats[i].format == format) return formats[i].name;
    return "";
}

static int equal_case_aside(const char *text, const char *lower) {
    while (*text && *lower) {
        char letter = *text >= 'A' && *text <= 'Z' ? (char)(*text - 'A' + 'a') : *text;
        if (letter != *lower) return 0;
        ++text;
        ++lower;
    }
    return *text == *lower;
}

norma_file_format norma_file_format_of_path(const char *path) {
    const char *slash = path ? strrchr(path, '/') : NULL;
    const char *name = slash ? slash + 1 : path;
    const char *dot = name ? strrchr(name, '.') : NULL;
    for (size_t i = 0; dot && i < FORMAT_COUNT; ++i)
        if (equal_case_aside(dot + 1, formats[i].name)) return formats[i].format;
    return NORMA_FILE_UNKNOWN;
}
