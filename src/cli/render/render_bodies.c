/* render_bodies.c: glTF: the primitives of a mesh are one body, whose normals are computed
 * together.
 */
#include "cli/render/render_scene.h"

int render_join_primitives(
    render_scene_file *file, render_surface *first, size_t count, norma_document_error *error) {
    float *expected[64];
    render_error trouble;
    if (count < 2 || count > CLI_COUNT(expected)) return 1;
    if (render_expect(first, count, expected, &trouble)) {
        render_file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, trouble.message);
        return 0;
    }
    int good = 1;
    for (size_t i = 0; i < count; ++i) {
        first[i].expected = expected[i];
        if (!render_file_keep(file, expected[i])) {
            first[i].expected = NULL;
            good = 0;
        }
    }
    if (!good) render_file_fail(error, NORMA_DOCUMENT_ERROR_MEMORY, file->input, "out of memory");
    return good;
}

/* Normals are computed for the surfaces of one mesh: all that are not stored and not flat, and all
 * that errors are measured against. */
int render_join_needed(
    const render_settings *settings, const render_surface *surfaces, size_t count) {
    for (size_t i = 0; i < count; ++i)
        if (settings->show == RENDER_SHOW_ERROR ||
            (surfaces[i].stored == RENDER_NORMALS_NONE && surfaces[i].crease_rad >= 0))
            return 1;
    return 0;
}
