/* place_outputs.h: where the output of each input goes. */
#ifndef NORMA_CLI_PLACE_OUTPUTS_H
#define NORMA_CLI_PLACE_OUTPUTS_H
#include "cli/files/input.h"

/* Gives each input a place of its own below --out-dir. ending: as of cli_output_of. A status. */
int cli_place_outputs(const cli_subcommand *command, cli_files *files, const char *ending);
/* The output of an input, the caller's to free; ending (NULL: the input's own) replaces the input's
 * below --out-dir. NULL: out of memory. */
char *cli_output_of(const cli_files *files, size_t index, const char *ending);
int cli_make_out_dir(const cli_subcommand *command, const cli_files *files);
/* The folders below --out-dir that an output lies in. A status. */
int cli_make_folders(const cli_files *files, const char *output);
#endif
