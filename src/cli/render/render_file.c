/* render_file.c: a file that is drawn: opened, closed, and the blocks that live as long as it. */
#include "cli/render/render.h"
#include "cli/process/process.h"
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

norma_document_result render_file_fail(norma_document_error *error, norma_document_result result,
    const char *input, const char *what) {
    error->result = result;
    snprintf(error->message, sizeof error->message, "%.500s: %.400s", cli_input_name(input), what);
    return result;
}

norma_document_result render_file_open(const render_settings *settings, const char *input,
    render_scene_file *file, norma_document_error *error) {
    static const norma_document_options reading = {.lenient = 1};
    *file = (render_scene_file){.input = input};
    return cli_read(&settings->files, &settings->common, input, &reading, &file->document,
        &file->memory, error);
}

void render_scene_free(render_scene *scene) {
    free((void *)scene->surfaces);
    free((void *)scene->draws);
    *scene = (render_scene){0};
}

void render_file_close(render_scene_file *file) {
    for (size_t i = 0; i < file->variant_count; ++i) render_scene_free(&file->scenes[i]);
    for (size_t i = 0; i < file->owned_count; ++i) free(file->owned[i]);
    free(file->owned);
    free(file->images);
    free(file->document_meshes);
    norma_document_close(file->document);
    free(file->memory);
    *file = (render_scene_file){0};
}

void render_file_note(render_scene_file *file, const char *format, ...) {
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < file->note_count; ++i)
        if (strcmp(file->notes[i], text) == 0) return;
    if (file->note_count == sizeof file->notes / sizeof *file->notes) return;
    char *kept = malloc(strlen(text) + 1);
    if (!kept) return;
    strcpy(kept, text);
    if (render_file_keep(file, kept)) file->notes[file->note_count++] = kept;
}

int render_file_keep(render_scene_file *file, void *block) {
    void **larger = cli_grow(file->owned, file->owned_count, &file->owned_room, sizeof *larger);
    if (!larger) {
        free(block);
        return 0;
    }
    file->owned = larger;
    file->owned[file->owned_count++] = block;
    return 1;
}
