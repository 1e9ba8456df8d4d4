/* load_json.c: reads a JSON file that someone wrote for norma check: a configuration, a baseline. A
 * pipe or a device in its place would be waited for without end, so it is refused. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check_command.h"
#include "cli/process/errors.h"
#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Without waiting for a writer, if it is a pipe. */
int check_open_regular(const char *path) {
    struct stat status;
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK),
              failed = file < 0 || fstat(file, &status);
    if (!failed && S_ISREG(status.st_mode)) return file;
    if (failed)
        cli_error("%s: cannot be opened: %s", path, strerror(errno));
    else
        cli_error("%s: is not a regular file; expected one", path);
    if (file >= 0) close(file);
    return -1;
}

static FILE *open_file(const char *path) {
    const int number = check_open_regular(path);
    if (number < 0) return NULL;
    FILE *file = fdopen(number, "r");
    if (file) return file;
    close(number);
    cli_out_of_memory();
    return NULL;
}

json_t *check_load_json(const char *path, const char *expected) {
    json_error_t error;
    FILE *file = open_file(path);
    if (!file) return NULL;
    json_t *root = json_loadf(file, JSON_REJECT_DUPLICATES, &error);
    fclose(file);
    if (!root && error.line > 0)
        cli_error("%s:%d: %s; expected %s", path, error.line, error.text, expected);
    else if (!root)
        cli_error("%s: %s; expected %s", path, error.text, expected);
    return root;
}
