/* document_options.c: small things that every format needs: files beside its own, formats and
 * their names. */
#include "io/format/format.h"
#include <stdlib.h>
#include <string.h>

int norma_document_load_file(const norma_document *document, const char *path, file_bytes *bytes) {
    const file_reading how = {
        .progress = norma_watch_tell, .progress_user = norma_document_watch(document)};
    return norma_file_open(path, &how, bytes);
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
