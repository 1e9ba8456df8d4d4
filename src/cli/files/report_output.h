/* report_output.h: a report that goes to a file, whole or not at all. */
#ifndef NORMA_CLI_REPORT_OUTPUT_H
#define NORMA_CLI_REPORT_OUTPUT_H
#include "cli/files/guard.h"
#include <stdio.h>

typedef struct cli_output {
    FILE *out;
    const char *path;
    cli_guard *guard;
    norma_saving *saving; /* NULL: standard output */
    int passes_on;        /* what is written cannot be taken back: standard output, a pipe */
} cli_output;
/* path "-" is standard output; guard may be NULL. A status; not CLI_OK: reported already. The
 * output stays where it is until it is ended or dropped. */
int cli_output_begin(cli_output *output, const char *path, cli_guard *guard);
int cli_output_end(cli_output *output);   /* a status */
void cli_output_drop(cli_output *output); /* as if it had never been begun */
#endif
