/* each.c: the files of a batch, one after the other. The worker says of each what became of it; the
 * one that it says nothing of has ended it. */
#include "cli/files/each.h"
#include "cli/process/errors.h"
#include "cli/text/outside_text.h"
#include <stdio.h>
#include <string.h>

static int run_here(const cli_each *each, size_t first) {
    int status = CLI_OK;
    for (size_t file = first; file < each->count; ++file)
        status = cli_worse(status, each->one(each->user, file));
    return status;
}

/* A message for each file: its status; and one in the end, for standard output. */
static _Noreturn void run_in_worker(const cli_worker *worker, const cli_each *each, size_t first) {
    size_t sent = cli_guard_count(each->guard);
    for (size_t file = first; file <= each->count; ++file) {
        const int status = file < each->count ? each->one(each->user, file) : cli_finish(CLI_OK);
        fflush(stdout); /* what was told of it stays, whatever the next one does */
        cli_worker_send(worker, &status, sizeof status);
        cli_guard_send(each->guard, &sent, worker);
    }
    cli_worker_finish(worker);
}

int cli_run_each(const cli_each *each) {
    int status = CLI_OK, one;
    char why[CLI_WHY_ROOM];
    for (size_t next = 0; next < each->count;) {
        cli_worker worker;
        const int side = each->count > 1 ? cli_worker_start(&worker) : -1;
        if (side < 0) return cli_worse(status, run_here(each, next));
        if (side == 0) run_in_worker(&worker, each, next);
        for (; cli_worker_receive(&worker, &one, sizeof one); ++next) {
            status = cli_worse(status, one);
            cli_guard_receive(each->guard, &worker);
        }
        if (cli_worker_wait(&worker, why)) continue;
        status = CLI_FILE;
        if (next < each->count)
            each->lost(each->user, next, why);
        else
            cli_error("%s", why);
        ++next;
    }
    return status;
}

/* ---- files that are opened later */

typedef struct look_ahead {
    cli_guard *guard;
    const cli_inputs *inputs;
    norma_file_format format;
} look_ahead;

static int look_into(void *user, size_t file) {
    const look_ahead *ahead = user;
    const char *path = ahead->inputs->paths[file];
    const norma_file_format kind = ahead->format ? ahead->format : norma_file_format_of_path(path);
    const norma_document_options options = {.struct_size = sizeof options,
        .format = ahead->format,
        .depth = NORMA_DOCUMENT_SUMMARY,
        .lenient = 1};
    norma_document *document;
    norma_document_error error; /* reported when the file is read for the work */
    if (kind < NORMA_FILE_GLTF || strcmp(path, "-") == 0 ||
        norma_document_open(path, &options, &document, &error))
        return CLI_OK;
    cli_guard_document(ahead->guard, document, path);
    norma_document_close(document);
    return CLI_OK;
}

/* So will the work be. */
static void pass_over(void *user, size_t file, const char *why) {
    (void)user, (void)file, (void)why;
}

void cli_guard_look_ahead(cli_guard *guard, const cli_inputs *inputs, norma_file_format format) {
    if (!cli_guard_watches(guard)) return;
    look_ahead ahead = {guard, inputs, format};
    const cli_each each = {inputs->count, look_into, pass_over, &ahead, guard};
    cli_run_each(&each);
}
