/* batch.c: the files of a batch, one after the other, in a process of its own. */
#include "cli/files/files.h"
#include "cli/process/process.h"
#include <stdio.h>

/* ---- The worker says of each file what became of it; the one that it says nothing of has ended
 * it. */

static int run_each_here(const cli_each *each, size_t first) {
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
        if (side < 0) return cli_worse(status, run_each_here(each, next));
        if (side == 0) run_in_worker(&worker, each, next);
        for (; cli_worker_receive(&worker, &one, sizeof one); ++next) {
            status = cli_worse(status, one);
            cli_guard_receive(each->guard, &worker);
        }
        if (cli_worker_wait(&worker, next < each->count, why)) continue;
        status = CLI_FILE;
        if (next < each->count)
            each->lost(each->user, next, worker.process, why);
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
    cli_guard_names(ahead->guard, ahead->inputs->list[file].path, ahead->format);
    return CLI_OK;
}

/* So will the work be. */
static void pass_over(void *user, size_t file, int worker, const char *why) {
    (void)user, (void)file, (void)worker, (void)why;
}

void cli_guard_look_ahead(cli_guard *guard, const cli_inputs *inputs, norma_file_format format) {
    if (!cli_guard_watches(guard)) return;
    look_ahead ahead = {guard, inputs, format};
    const cli_each each = {inputs->count, look_into, pass_over, &ahead, guard};
    cli_run_each(&each);
}
