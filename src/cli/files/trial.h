/* trial.h: options that a format refuses are noticed before the first file of a batch is written.
 */
#ifndef NORMA_CLI_TRIAL_H
#define NORMA_CLI_TRIAL_H
#include "cli/files/batch.h"

/* A status: CLI_USAGE, printed already, where some input's format does not take the options. */
int cli_try_formats(const cli_files *files, const cli_changer *changer);
#endif
