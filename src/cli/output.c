/* output.c: a report that goes to a file: whole or not at all, by a temporary file beside it that is renamed. "-" is standard output. */
#define _POSIX_C_SOURCE 200809L
#include "cli.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int fail(cli_output *output, int error) {
    fprintf(stderr, "norma: %s: cannot be written: %s\n", output->path, strerror(error));
    if (output->temporary)
        unlink(output->temporary);
    if (output->out && output->out != stdout)
        fclose(output->out);
    free(output->temporary);
    output->temporary = NULL;
    output->out = NULL;
    return 0;
}

/* A pipe or a device is written as it is: there is nothing to rename. */
static int is_stream(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode);
}

int cli_output_begin(cli_output *output, const char *path) {
    *output = (cli_output){.path = path};
    if (strcmp(path, "-") == 0) {
        output->out = stdout;
        return 1;
    }
    if (is_stream(path)) {
        output->out = fopen(path, "w");
        return output->out ? 1 : fail(output, errno);
    }
    size_t size = strlen(path) + sizeof ".XXXXXX";
    output->temporary = malloc(size);
    if (!output->temporary)
        return fail(output, ENOMEM);
    snprintf(output->temporary, size, "%s.XXXXXX", path);
    mode_t mask = umask(0);
    umask(mask);
    int descriptor = mkstemp(output->temporary);
    if (descriptor < 0) {
        int error = errno;
        free(output->temporary);
        output->temporary = NULL;
        return fail(output, error);
    }
    fchmod(descriptor, 0666 & ~mask);
    output->out = fdopen(descriptor, "w");
    return output->out ? 1 : fail(output, errno);
}

void cli_output_drop(cli_output *output) {
    if (!output->out || output->out == stdout)
        return;
    fclose(output->out);
    if (output->temporary)
        unlink(output->temporary);
    free(output->temporary);
    *output = (cli_output){0};
}

int cli_output_end(cli_output *output) {
    if (output->out == stdout)
        return cli_finish(CLI_OK);
    if (fflush(output->out) || ferror(output->out) || (output->temporary && fsync(fileno(output->out))))
        return fail(output, errno ? errno : EIO), CLI_FILE;
    FILE *out = output->out;
    output->out = NULL;
    if (fclose(out) || (output->temporary && rename(output->temporary, output->path)))
        return fail(output, errno), CLI_FILE;
    free(output->temporary);
    output->temporary = NULL;
    return CLI_OK;
}
