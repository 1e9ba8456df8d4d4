/* render_output.c: where the pictures of norma render go, and which options contradict each other:
 * said before anything is drawn. */
#define _POSIX_C_SOURCE 200809L
#include "cli/render/render_command.h"
#include "cli/files/files.h"
#include "cli/process/process.h"
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

const char *render_base_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static int ends_in_png(const char *path) {
    const char *name = render_base_name(path), *dot = strrchr(name, '.');
    return dot && dot > name && strlen(dot) == 4 && (dot[1] | 32) == 'p' && (dot[2] | 32) == 'n' &&
           (dot[3] | 32) == 'g';
}

int render_is_standard(const char *name) { return strcmp(name, "-") == 0; }

static int is_stream(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

char *render_output_of(const render_settings *settings, size_t index, int turn) {
    const cli_files *files = &settings->files;
    char ending[16] = ".png";
    if (turn >= 0) snprintf(ending, sizeof ending, "-%03d.png", turn);
    if (turn < 0 || !files->output) return cli_output_of(files, index, ending);
    const char *name = files->output, *dot = strrchr(render_base_name(name), '.');
    const int stem = dot && dot > render_base_name(name) ? (int)(dot - name) : (int)strlen(name);
    const size_t size = strlen(name) + sizeof ending;
    char *path = malloc(size);
    if (path) snprintf(path, size, "%.*s%s", stem, name, ending);
    return path;
}

static int check_outputs(const cli_subcommand *command, render_settings *settings) {
    cli_files *files = &settings->files;
    int standard = 0;
    for (size_t i = 0; i < files->inputs.count; ++i)
        standard |= render_is_standard(files->inputs.paths[i]);
    if (!files->output && !files->folder)
        return cli_usage(command, "no output was given; expected -o OUT.png or --out-dir FOLDER");
    if (files->output && files->folder)
        return cli_usage(command, "-o and --out-dir exclude each other");
    if (files->output && files->inputs.count > 1 && !settings->sheet)
        return cli_usage(command,
            "one -o for %zu inputs; expected --out-dir FOLDER, or --sheet for one picture of all",
            files->inputs.count);
    if (settings->sheet && !files->output)
        return cli_usage(command, "--sheet makes one picture; expected -o OUT.png");
    if (files->folder && standard)
        return cli_usage(command, "standard input has no name to write to; expected -o OUT.png");
    if (files->folder) return cli_place_outputs(command, files, ".png");
    if (render_is_standard(files->output) && settings->common.json)
        return cli_usage(command, "-o - and --json would both write to standard output");
    if (render_is_standard(files->output) && settings->turns)
        return cli_usage(command, "--turntable makes several files; expected -o OUT.png");
    if (render_is_standard(files->output) && isatty(STDOUT_FILENO))
        return cli_usage(command,
            "standard output is a terminal, which shows no picture; expected -o "
            "OUT.png, or a pipe");
    if (!render_is_standard(files->output) && !ends_in_png(files->output) &&
        !is_stream(files->output))
        return cli_usage(
            command, "-o %s: pictures are PNG; expected a name that ends in .png", files->output);
    return CLI_OK;
}

/* Every picture that will be drawn, those of a turntable included. */
int render_guard_outputs(const render_settings *settings) {
    const cli_inputs *inputs = &settings->files.inputs;
    const int first = settings->turns ? 0 : -1, end = settings->turns ? settings->turns : 0;
    int status = CLI_OK;
    for (size_t i = 0; i < (settings->sheet ? 1 : inputs->count); ++i)
        for (int turn = first; turn < end && !status; ++turn) {
            char *output = render_output_of(settings, i, turn);
            status = output ? cli_guard_output(settings->files.guard, output, NULL)
                            : cli_out_of_memory();
            free(output);
        }
    return status;
}

int render_settings_check(const cli_subcommand *command, render_settings *settings) {
    const double *m = settings->matrix.matrix;
    if (settings->lines & RENDER_VERTEX_LINES && settings->hedgehog)
        settings->lines = (settings->lines & RENDER_WIREFRAME) | settings->hedgehog;
    else if (settings->hedgehog)
        return cli_usage(
            command, "--lines applies only to a hedgehog; expected --show hedgehog with it");
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
        return cli_usage(command,
            "the last row of the matrix must be 0 0 0 1; the camera makes the perspective");
    if (settings->compare && settings->views)
        return cli_usage(command, "--compare and --views exclude each other");
    if (settings->turns && (settings->views || settings->sheet))
        return cli_usage(command, "--turntable excludes --views and --sheet");
    if (settings->has_select && settings->show != RENDER_SHOW_MARKS)
        return cli_usage(command, "--select applies only to findings; expected --show findings");
    if (settings->clay < 0)
        settings->clay = settings->compare || settings->show == RENDER_SHOW_ERROR ||
                         settings->show == RENDER_SHOW_MARKS;
    settings->look.steady = settings->turns > 0;
    int status = render_check_idle(command, settings);
    if (!status) status = render_plan_check(command, settings);
    if (!status) status = check_outputs(command, settings);
    if (!status) status = render_guard_outputs(settings);
    if (!status)
        cli_guard_look_ahead(
            settings->files.guard, &settings->files.inputs, settings->files.format);
    if (!status) status = render_guard_outputs(settings);
    return status ? status : cli_make_out_dir(command, &settings->files);
}
