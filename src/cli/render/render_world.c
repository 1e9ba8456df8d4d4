/* render_world.c: which way is up in a file, and what of the file a picture does not show. */
#include "cli/render/render_command.h"
#include <string.h>

const char *render_up_name(enum render_up up) {
    static const char *const names[] = {"y", "z", "x", "-y", "-z", "-x"};
    return names[up];
}

/* glTF says that y points up. Where nothing shows, OBJ is taken as modellers export it, STL
 * and PLY as printers and scanners have them.
 */
void render_file_set_up(
    const render_settings *settings, render_scene_file *file, const render_scene *scene) {
    const norma_file_format format = norma_document_format(file->document);
    file->up_guessed = 0;
    file->up = settings->up_given ? settings->up : RENDER_UP_Y;
    if (settings->up_given || format == NORMA_FILE_GLTF || format == NORMA_FILE_GLB) return;
    file->up = render_guess_up(scene->surfaces, scene->surface_count,
        format == NORMA_FILE_OBJ ? RENDER_UP_Y : RENDER_UP_Z);
    file->up_guessed = 1;
}

/* ---- what is left out */

static int is_of(const char *reason, const char *word) {
    return strncmp(reason, word, strlen(word)) == 0;
}

void render_file_left_out(
    const render_settings *settings, const render_scene_file *file, render_left_out *left_out) {
    size_t *counts = left_out->counts;
    for (size_t i = 0; i < norma_document_mesh_count(file->document); ++i) {
        norma_mesh_info info;
        if (norma_document_mesh_info(file->document, i, &info) || !info.not_read) continue;
        ++counts[is_of(info.not_read, "points")  ? RENDER_NO_POINTS
                 : is_of(info.not_read, "lines") ? RENDER_NO_LINES
                 : info.compression              ? RENDER_NO_COMPRESSION
                                                 : RENDER_NO_MESHES];
    }
    counts[RENDER_NO_NODES] += file->not_shown;
    counts[RENDER_NO_IMAGES] += file->images_left_out;
    if (file->left_out_names[0])
        render_add_name(left_out->images, sizeof left_out->images, file->left_out_names);
    if (settings->show == RENDER_SHOW_MARKS) counts[RENDER_NO_PLACE] += file->found_nowhere;
}

void render_add_name(char *list, size_t room, const char *name) {
    const size_t length = strlen(list), dots = sizeof ", ...";
    if (length >= dots && strcmp(list + length - 3, "...") == 0) return;
    snprintf(list + length, room - length, "%s%s", length ? ", " : "",
        length + strlen(name) + 2 * dots < room ? name : "...");
}

static void add_words(
    char *text, size_t room, size_t count, const char *const words[2], const char *names) {
    const size_t length = strlen(text);
    if (count)
        snprintf(text + length, room - length, "%s%zu %s%s%s%s", length ? ", " : "", count,
            words[count > 1], *names ? " (" : "", names, *names ? ")" : "");
}

void render_left_out_words(const render_left_out *left_out, char *text, size_t room) {
    static const char *const files[2] = {"file that cannot be drawn", "files that cannot be drawn"};
    static const char *const words[RENDER_LEFT_OUT][2] = {
        [RENDER_NO_POINTS] = {"mesh of points", "meshes of points"},
        [RENDER_NO_LINES] = {"mesh of lines", "meshes of lines"},
        [RENDER_NO_COMPRESSION] = {"mesh with a compression that is not read",
            "meshes with a compression that is not read"},
        [RENDER_NO_MESHES] = {"mesh that is not read", "meshes that are not read"},
        [RENDER_NO_NODES] = {"mesh outside the scene", "meshes outside the scene"},
        [RENDER_NO_IMAGES] = {"image that cannot be read", "images that cannot be read"},
        [RENDER_NO_PLACE] = {"finding without a place", "findings without a place"}};
    text[0] = '\0';
    add_words(text, room, left_out->file_count, files, left_out->files);
    for (int i = 0; i < RENDER_LEFT_OUT; ++i)
        add_words(text, room, left_out->counts[i], words[i],
            i == RENDER_NO_IMAGES ? left_out->images : "");
}
