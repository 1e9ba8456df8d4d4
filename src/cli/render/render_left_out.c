/* render_left_out.c: norma render where the tool is built without libpng, libjpeg or the headers of
 * EGL and OpenGL ES: says so and fails. */
#include "cli/options/options.h"
#include "cli/process/process.h"
#include "cli/render/render.h"

static const char no_render_help[] =
    "norma render IN -o OUT.png: not in this build of norma\n"
    "\n"
    "It was built without libpng, libjpeg or the headers of EGL and OpenGL ES 3. Install them\n"
    "(Debian: libpng-dev libjpeg-dev libegl-dev libgles-dev) and build again.\n";

static int run_left_out(const cli_subcommand *command, int count, char **arguments) {
    (void)command, (void)count, (void)arguments;
    cli_error(
        "pictures are not in this build; they need libpng, libjpeg and the headers of EGL and "
        "OpenGL ES 3");
    return CLI_FILE;
}

int render_compared(
    const struct compared_pair *pair, const render_dot *dots, size_t dot_count, render_png *png) {
    (void)pair, (void)dots, (void)dot_count, (void)png;
    return run_left_out(NULL, 0, NULL);
}

const cli_subcommand cli_subcommand_render = {
    "render", "draws a picture (not in this build)", no_render_help, run_left_out};
