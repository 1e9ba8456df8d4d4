/* report_output.c: a report that goes to a file, written whole or not at all. It goes there piece
 * by piece, so a report on any number of files takes no memory. "-" is standard output. */
#define _GNU_SOURCE /* fopencookie */
#include "cli/files/report_output.h"
#include "cli/process/errors.h"
#include "cli/process/progress.h"
#include <errno.h>
#include <string.h>
#include <sys/stat.h>

/* ---- a stream whose bytes go to norma_save_piece, which remembers its first error */

#if defined(__linux__)
static ssize_t pass_on(void *user, const char *bytes, size_t count) {
    return norma_save_piece(user, bytes, count, NULL) ? 0 : (ssize_t)count;
}

static FILE *open_stream(norma_saving *saving) {
    return fopencookie(saving, "w", (cookie_io_functions_t){.write = pass_on});
}
#else
static int pass_on(void *user, const char *bytes, int count) {
    return norma_save_piece(user, bytes, (size_t)count, NULL) ? -1 : count;
}

static FILE *open_stream(norma_saving *saving) {
    return funopen(saving, NULL, pass_on, NULL, NULL);
}
#endif

/* ---- the output */

static int is_stream(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode);
}

/* The temporary file is made before the work, so what would fail in the end is said at once. */
static int begin_file(cli_output *output) {
    norma_document_error error;
    output->passes_on = is_stream(output->path);
    if (norma_save_begin(output->path, &output->saving, &error)) {
        cli_print_error(&error);
        return CLI_FILE;
    }
    cli_tidy_when_ended(norma_save_temporary(output->saving));
    output->out = open_stream(output->saving);
    if (output->out) return CLI_OK;
    cli_output_drop(output);
    return cli_out_of_memory();
}

int cli_output_begin(cli_output *output, const char *path, cli_guard *guard) {
    *output = (cli_output){.path = path, .guard = guard};
    const int status = cli_guard_output(guard, path, NULL);
    if (status || strcmp(path, "-") != 0) return status ? status : begin_file(output);
    output->out = stdout;
    output->passes_on = 1;
    return CLI_OK;
}

void cli_output_drop(cli_output *output) {
    if (output->saving && output->out) fclose(output->out);
    if (output->passes_on && output->saving) {
        norma_save_end(output->saving, NULL); /* the reader gets what there was */
    } else {
        cli_writing_begin(); /* a signal waits: the name that it would remove is freed */
        norma_save_abandon(output->saving);
        cli_tidy_when_ended(NULL);
        cli_writing_end();
    }
    *output = (cli_output){0};
}

int cli_output_end(cli_output *output) {
    if (!output->saving) return cli_finish(CLI_OK);
    norma_document_error error;
    const int refused = cli_guard_output(output->guard, output->path, NULL);
    if (refused) {
        cli_output_drop(output);
        return refused;
    }
    cli_writing_begin();
    fclose(output->out); /* a piece that cannot be written fails at the end */
    cli_tidy_when_ended(NULL);
    const int failed = norma_save_end(output->saving, &error) != NORMA_DOCUMENT_OK;
    cli_writing_end();
    if (failed) cli_print_error(&error);
    *output = (cli_output){0};
    return failed ? CLI_FILE : CLI_OK;
}
