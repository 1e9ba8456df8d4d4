/* compute_together.h: norma compute --together. */
#ifndef NORMA_CLI_COMPUTE_TOGETHER_H
#define NORMA_CLI_COMPUTE_TOGETHER_H
#include "cli/compute/compute_command.h"
#include "cli/files/files.h"

extern const cli_option
    compute_together_options[]; /* --together --lock --levels; of compute_work */
extern const size_t compute_together_option_count;

/* Says that the tiles of a tileset do not share one frame; 0: they do. */
int compute_refuse_moved(const cli_inputs *inputs);
/* A status. */
int compute_check_together(const cli_subcommand *command, const compute_work *work);
/* All files, as cli_changer.all. */
int compute_all_together(const cli_all_files *all, const cli_changer *changer);

#endif
