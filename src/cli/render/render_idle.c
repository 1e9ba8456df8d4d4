/* render_idle.c: options that have no effect: refused if the command line shows it, otherwise noted
 * once the file is open. */
#include "cli/render/render_command.h"
#include "cli/process/process.h"
#include <string.h>

static int refuse(const cli_subcommand *command, const char *option, const char *needed) {
    return cli_usage(command, "%s applies only to %s with it", option, needed);
}

int render_check_idle(const cli_subcommand *command, const render_settings *settings) {
    const unsigned given = settings->given;
    const int hedgehog = (settings->lines & ~(unsigned)RENDER_WIREFRAME) != 0,
              errors = settings->show == RENDER_SHOW_ERROR;
    if (given & RENDER_GIVEN_LENGTH && !hedgehog)
        return refuse(command, "--line-length", "a hedgehog; expected --show hedgehog");
    if (given & RENDER_GIVEN_MOST && !hedgehog)
        return refuse(command, "--most-lines", "a hedgehog; expected --show hedgehog");
    if (given & RENDER_GIVEN_WIDTH && !settings->lines && settings->show != RENDER_SHOW_MARKS)
        return refuse(command, "--line-width", "lines; expected --show hedgehog or wireframe");
    if (settings->look.error_top_deg > 0 && !errors)
        return refuse(command, "--error-top", "errors; expected --show error");
    if (settings->compute && errors)
        return cli_usage(command, "--show error compares stored normals with computed ones; "
                                  "--normals computed leaves none to compare");
    return CLI_OK;
}

/* ---- what depends on the file */

/* Whether any normal of the scenes is computed; *flat: some surface has none and is flat. */
static int computes_any(const render_scene_file *file, int *flat) {
    int any = 0;
    *flat = 0;
    for (size_t i = 0; i < file->variant_count; ++i)
        for (size_t k = 0; k < file->scenes[i].surface_count; ++k) {
            const render_surface *surface = &file->scenes[i].surfaces[k];
            const int without = surface->stored == RENDER_NORMALS_NONE;
            any |= surface->replace_zeros || (without && surface->crease_rad >= 0);
            *flat |= without && surface->crease_rad < 0;
        }
    return any;
}

/* "--crease, --weight": those of the options that were given. */
static void name_options(const render_settings *settings, int of_normals, char list[80]) {
    list[0] = '\0';
    if (of_normals && settings->crease_given) render_add_name(list, 80, "--crease");
    if (of_normals && settings->given & RENDER_GIVEN_WEIGHT) render_add_name(list, 80, "--weight");
    if (!of_normals && settings->given & RENDER_GIVEN_SHADING)
        render_add_name(list, 80, "--shading");
    if (!of_normals && settings->light_given) render_add_name(list, 80, "--light");
    if (!of_normals && settings->given & RENDER_GIVEN_PHONG) render_add_name(list, 80, "--phong");
}

static int is_lit(const render_settings *settings) {
    return settings->show == RENDER_SHOW_LIT || settings->show == RENDER_SHOW_MARKS;
}

void render_note_idle(const render_settings *settings, render_scene_file *file) {
    char list[80];
    int flat;
    name_options(settings, 1, list);
    if (list[0] && settings->show != RENDER_SHOW_ERROR && !computes_any(file, &flat))
        render_file_note(file,
            "no effect: %s. No normal is computed, because %s; --normals computed computes all",
            list, flat ? "surfaces without normals are flat here" : "all of them are stored");
    name_options(settings, 0, list);
    if (list[0] && !is_lit(settings))
        render_file_note(file, "no effect: %s. Nothing that --show draws is lit", list);
}
