/* each.h: work on the files of a batch one after the other, in a process of its own (worker.h). */
#ifndef NORMA_CLI_EACH_H
#define NORMA_CLI_EACH_H
#include "cli/files/input.h"
#include "cli/process/worker.h"

typedef struct cli_each {
    size_t count;
    int (*one)(void *user, size_t file);                    /* a status */
    void (*lost)(void *user, size_t file, const char *why); /* that file ended a worker */
    void *user;
    cli_guard *guard; /* learns what one reads; may be NULL */
} cli_each;
int cli_run_each(const cli_each *each); /* the worst status */

/* Inputs that are opened later: glTF files are looked into, if an output exists, so that no output
 * of the first can replace a picture of the second. */
void cli_guard_look_ahead(cli_guard *guard, const cli_inputs *inputs, norma_file_format format);
#endif
