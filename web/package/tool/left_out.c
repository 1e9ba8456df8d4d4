/* left_out.c: the subcommands that draw or open a browser. They are not in the npm package, and say
 * so. */
#include "cli/options/options.h"
#include "cli/process/process.h"

static const char left_out_help[] =
    "This subcommand is not in the npm package: it needs a display, a browser or OpenGL. The\n"
    "program norma has it: https://example.org/norma\n";

static int run_left_out(const cli_subcommand *command, int count, char **arguments) {
    (void)count, (void)arguments;
    cli_error("%s is not in the npm package; the program norma has it", command->name);
    return CLI_USAGE;
}

#define LEFT_OUT(name)                                                                             \
    const cli_subcommand cli_subcommand_##name = {                                                 \
        #name, "(not in the npm package)", left_out_help, run_left_out}
LEFT_OUT(render);
LEFT_OUT(view);
LEFT_OUT(acid);
