/* find_inputs.h: which files the words of a command stand for. */
#ifndef NORMA_CLI_FIND_INPUTS_H
#define NORMA_CLI_FIND_INPUTS_H
#include "cli/files/input.h"

/* Adds the files that the words stand for: a file, the files of a folder and below, what a pattern
 * with *, ? and ** matches, or "-". A folder that cannot be read does not stop the others: the
 * status is then CLI_FILE and inputs hold the rest. */
int cli_find_inputs(const cli_subcommand *command, cli_files *files);
/* The same for the lines of each list; what does not exist or has no reader is left out. */
int cli_find_listed(const cli_subcommand *command, cli_files *files);
void cli_inputs_free(cli_inputs *inputs);
/* Whether a path, component by component, is what a pattern says; ** stands for any number of
 * components. A pattern without a slash is compared with the last one. */
int cli_path_matches(const char *pattern, const char *path);
char *cli_join(const char *folder, const char *name); /* the caller's to free */
#endif
