/* not_in_npm.c: stands in for the subcommands that draw, start a browser or serve where the tool is
 * npm's (npx norma-mesh). */
#include "cli/options/options.h"
#include "cli/process/process.h"
#include "cli/render/render.h"

static const char not_in_npm_help[] =
    "This subcommand is not in the npm package: it needs OpenGL, a browser or processes. The\n"
    "native program has it: https://example.org/norma\n";

static int run_not_in_npm(const cli_subcommand *command, int count, char **arguments) {
    (void)count, (void)arguments;
    cli_error("%s is not in the npm package; the program norma has it", command->name);
    return CLI_USAGE;
}

#define NOT_IN_NPM(name)                                                                           \
    const cli_subcommand cli_subcommand_##name = {                                                 \
        #name, "(not in the npm package)", not_in_npm_help, run_not_in_npm}
NOT_IN_NPM(render);
NOT_IN_NPM(view);
NOT_IN_NPM(acid);
NOT_IN_NPM(mcp);

int render_compared(
    const struct compared_pair *pair, const render_dot *dots, size_t dot_count, render_png *png) {
    (void)pair, (void)dots, (void)dot_count, (void)png;
    cli_error("pictures are not in the npm package; the program norma draws them");
    return CLI_USAGE;
}
