/* report_output.c: a report that goes to a file: gathered in memory, then written whole or not at
 * all. "-" is standard output. */
#define _POSIX_C_SOURCE 200809L
#include "cli/files/report_output.h"
#include "cli/process/errors.h"
#include "cli/process/progress.h"
#include "cli/text/outside_text.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int fail(const cli_output *output, int error) {
    cli_error("%s: cannot be written: %s", output->path, strerror(error));
    return 0;
}

/* What would fail in the end is said before the work. */
static int look_ahead(const cli_output *output) {
    const char *slash = strrchr(output->path, '/');
    const size_t length = slash ? (size_t)(slash - output->path) + 1 : 0;
    char *folder = malloc(length + 2);
    if (!folder) return fail(output, ENOMEM);
    memcpy(folder, output->path, length);
    memcpy(folder + length, ".", 2);
    int fine = access(output->path, W_OK) == 0 || (errno == ENOENT && access(folder, W_OK) == 0);
    if (!fine) fail(output, errno);
    free(folder);
    return fine;
}

int cli_output_begin(cli_output *output, const char *path, cli_guard *guard) {
    *output = (cli_output){.path = path, .guard = guard};
    const int status = cli_guard_output(guard, path, NULL);
    if (status) return status;
    if (strcmp(path, "-") == 0) {
        output->out = stdout;
        return CLI_OK;
    }
    if (!look_ahead(output)) return CLI_FILE;
    if (!cli_memory_open(&output->gathered)) {
        fail(output, ENOMEM);
        return CLI_FILE;
    }
    output->out = output->gathered.out;
    return CLI_OK;
}

void cli_output_drop(cli_output *output) {
    (void)cli_memory_close(&output->gathered);
    free(output->gathered.text);
    *output = (cli_output){0};
}

int cli_output_end(cli_output *output) {
    if (output->out == stdout) return cli_finish(CLI_OK);
    norma_document_error error = {0};
    const int refused = cli_guard_output(output->guard, output->path, NULL);
    if (refused) {
        cli_output_drop(output);
        return refused;
    }
    const int whole = cli_memory_close(&output->gathered);
    cli_writing_begin();
    const int written = whole && norma_save_bytes(output->path, output->gathered.text,
                                     output->gathered.size, &error) == NORMA_DOCUMENT_OK;
    cli_writing_end();
    if (!whole)
        fail(output, ENOMEM);
    else if (!written)
        cli_print_error(&error);
    cli_output_drop(output);
    return written ? CLI_OK : CLI_FILE;
}
