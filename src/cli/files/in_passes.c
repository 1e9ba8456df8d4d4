/* in_passes.c: files that do not fit into memory, changed piece by piece; the line that a person
 * watches counts the passes. */
#define _POSIX_C_SOURCE 200809L
#include "cli/files/in_passes.h"
#include "cli/files/place_outputs.h"
#include "cli/process/errors.h"
#include "cli/process/memory_limit.h"
#include "cli/process/progress.h"
#include <string.h>
#include <sys/stat.h>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

/* No row of a file takes as much as this many times its bytes. */
enum { MOST_NEED = 200 };

int cli_can_take_passes(const cli_files *files, const char *input, uint64_t *need) {
    struct stat status;
    return strcmp(input, "-") != 0 && stat(input, &status) == 0 && S_ISREG(status.st_mode) &&
           (uint64_t)status.st_size > cli_memory_for_data() / MOST_NEED &&
           norma_large_need(input, files->format, need);
}

int cli_needs_passes(const cli_files *files, const char *input) {
    uint64_t need;
    return cli_can_take_passes(files, input, &need) && need > cli_memory_for_data();
}

typedef struct pass_line {
    cli_progress progress;
    char what[64];
    size_t passes;
} pass_line;

static void count_pass(void *user, size_t number, size_t count) {
    pass_line *line = user;
    line->passes = number;
    snprintf(line->what, sizeof line->what, "computing, pass %zu of %zu,", number, count);
}

/* Large blocks go back to the system as soon as they are freed, so that the next pass has room for
 * blocks of other sizes. */
static void return_freed_memory(void) {
#if defined(__GLIBC__)
    mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

norma_document_result cli_change_in_passes(const cli_changer *changer, const cli_common *common,
    const cli_files *files, const char *input, const char *output, uint64_t *size,
    norma_document_error *error) {
    pass_line line = {.what = "reading"};
    const norma_large_options options = {.struct_size = sizeof options,
        .max_memory = cli_memory_for_data(),
        .format = files->format,
        .in_place = files->in_place,
        .pass = count_pass,
        .pass_user = &line,
        .size = size};
    if (strcmp(output, "-") == 0) {
        snprintf(error->message, sizeof error->message,
            "%.800s: does not fit into the memory allowed, and standard output cannot be written "
            "in passes; give -o FILE",
            input);
        return NORMA_DOCUMENT_ERROR_UNSUPPORTED;
    }
    if (cli_make_folders(files, output)) return cli_reported(error);
    return_freed_memory();
    cli_progress_start(&line.progress, line.what, input, common->quiet, cli_megabytes(input));
    cli_writing_begin();
    const norma_document_result result = changer->in_passes(
        changer->work, input, output, &options, cli_progress_report, &line.progress, error);
    cli_progress_stop(&line.progress);
    cli_writing_end();
    return result;
}
