/* worker.c: processes for the files of a batch, by fork. One process works on all files; only
 * behind a file that ended it another one is made, so that a batch without faults costs one fork.
 */
#define _DEFAULT_SOURCE /* kill, strsignal */
#define _POSIX_C_SOURCE 200809L
#include "cli/process/worker.h"
#include "cli/process/errors.h"
#include "cli/process/progress.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#if defined(__linux__)
#include <signal.h>
#include <sys/prctl.h>
#endif

/* Whatever ends the caller ends its worker. */
static void follow_caller(void) {
#if defined(__linux__)
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
}

int cli_worker_start(cli_worker *worker) {
    int ends[2];
    if (pipe(ends)) return -1;
    fflush(NULL); /* else the worker would write it again */
    const pid_t process = fork();
    worker->process = (int)process;
    worker->channel = ends[process == 0];
    close(ends[process != 0]);
    if (process == 0) {
        follow_caller();
        cli_be_worker();
    } else if (process > 0) {
        cli_watch_worker(worker->process);
    } else {
        close(worker->channel);
    }
    return process < 0 ? -1 : process > 0;
}

void cli_worker_send(const cli_worker *worker, const void *bytes, size_t size) {
    const char *at = bytes;
    while (size > 0) {
        const ssize_t written = write(worker->channel, at, size);
        if (written < 0 && errno != EINTR) _exit(CLI_FILE); /* nobody is there to read it */
        at += written > 0 ? written : 0;
        size -= written > 0 ? (size_t)written : 0;
    }
}

void cli_worker_finish(const cli_worker *worker) {
    close(worker->channel);
    exit(0);
}

int cli_worker_receive(const cli_worker *worker, void *bytes, size_t size) {
    char *at = bytes;
    while (size > 0) {
        const ssize_t got = read(worker->channel, at, size);
        if (got == 0 || (got < 0 && errno != EINTR)) return 0;
        at += got > 0 ? got : 0;
        size -= got > 0 ? (size_t)got : 0;
    }
    return 1;
}

static void say_why(int status, char why[CLI_WHY_ROOM]) {
    if (WIFSIGNALED(status))
        snprintf(why, CLI_WHY_ROOM, "norma ended by signal %d (%s) while it worked on this file%s",
            WTERMSIG(status), strsignal(WTERMSIG(status)),
            WTERMSIG(status) == SIGKILL ? "; perhaps memory ran out" : "");
    else
        snprintf(why, CLI_WHY_ROOM, "norma ended with status %d while it worked on this file",
            WEXITSTATUS(status));
}

int cli_worker_wait(cli_worker *worker, char why[CLI_WHY_ROOM]) {
    int status = 0;
    close(worker->channel);
    while (waitpid((pid_t)worker->process, &status, 0) < 0 && errno == EINTR) {
    }
    cli_watch_worker(0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return 1;
    say_why(status, why);
    return 0;
}
