/* subcommand.h: a command: its name, its help, its function; and usage errors. */
#ifndef NORMA_CLI_SUBCOMMAND_H
#define NORMA_CLI_SUBCOMMAND_H
#include "cli/text/outside_text.h"

typedef struct cli_subcommand {
    const char *name, *summary, *help;
    int (*run)(const struct cli_subcommand *command, int count, char **arguments);
} cli_subcommand;

extern const cli_subcommand cli_subcommand_compute, cli_subcommand_tangents,
    cli_subcommand_transform, cli_subcommand_matrix, cli_subcommand_check, cli_subcommand_report,
    cli_subcommand_explain, cli_subcommand_info, cli_subcommand_render, cli_subcommand_view;

/* Prints "norma compute: ..." (command may be NULL). Always CLI_USAGE, so that a caller can return
 * it.
 */
CLI_FORMAT(2, 3) int cli_usage(const cli_subcommand *command, const char *format, ...);
#endif
