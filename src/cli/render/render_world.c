/* render_world.c: which way is up in a file, and what of the file a picture does not show. */
#include "cli/render/render_command.h"
#include <string.h>

const char *render_up_name(enum render_up up) {
    return up == RENDER_UP_X ? "x" : up == RENDER_UP_Y ? "y" : "z";
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

typedef struct sentence {
    char *text;
    size_t room;
} sentence;

static void add(sentence *s, size_t count, const char *one, const char *many) {
    const size_t length = strlen(s->text);
    if (count == 0 || length + 1 >= s->room) return;
    snprintf(s->text + length, s->room - length, "%s%zu %s", length ? ", " : "", count,
        count == 1 ? one : many);
}

static int is_of(const char *reason, const char *word) {
    return strncmp(reason, word, strlen(word)) == 0;
}

static void add_meshes(sentence *s, const norma_document *document) {
    size_t points = 0, lines = 0, compressed = 0, others = 0;
    for (size_t i = 0; i < norma_document_mesh_count(document); ++i) {
        norma_mesh_info info;
        if (norma_document_mesh_info(document, i, &info)) continue;
        if (!info.not_read) continue;
        if (is_of(info.not_read, "points"))
            ++points;
        else if (is_of(info.not_read, "lines"))
            ++lines;
        else if (info.compression)
            ++compressed;
        else
            ++others;
    }
    add(s, points, "mesh of points", "meshes of points");
    add(s, lines, "mesh of lines", "meshes of lines");
    add(s, compressed, "mesh with a compression that is not read",
        "meshes with a compression that is not read");
    add(s, others, "mesh that is not read", "meshes that are not read");
}

void render_file_left_out(
    const render_settings *settings, const render_scene_file *file, char *text, size_t room) {
    sentence s = {text, room};
    add_meshes(&s, file->document);
    add(&s, file->not_shown, "mesh outside the scene", "meshes outside the scene");
    add(&s, file->images_left_out, "image that cannot be read", "images that cannot be read");
    if (settings->show == RENDER_SHOW_MARKS)
        add(&s, file->found_nowhere, "finding without a place", "findings without a place");
}
