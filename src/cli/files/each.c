/* each.c: the files of a batch, one after the other. The worker says of each what became of it; the
 * one that it says nothing of has ended it. */
#include "cli/files/each.h"
#include "cli/process/errors.h"
#include "cli/text/outside_text.h"
#include <stdio.h>

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
