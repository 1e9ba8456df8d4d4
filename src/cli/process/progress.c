/* progress.c: a line on stderr while a person waits, and Ctrl-C: a flag that the library's progress
 * callback turns into a cancel, so that nothing half-written stays. */
#define _POSIX_C_SOURCE 200809L
#include "cli/process/progress.h"
#include "cli/text/outside_text.h"
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The one variable of the tool: a signal handler has no other way to say anything. */
static volatile sig_atomic_t caught_signal, caught_count;

static void catch_signal(int number) {
    caught_signal = number;
    if (++caught_count >= 3) /* someone who insists, while something does not look at the flag */
        _exit(128 + number);
}

void cli_watch_interrupts(void) {
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = catch_signal}, old;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        if (sigaction(numbers[i], NULL, &old) == 0 &&
            old.sa_handler != SIG_IGN) /* ignored: as nohup wants it */
            sigaction(numbers[i], &action, NULL);
    signal(SIGXFSZ,
        SIG_IGN); /* a file over its limit is then an error like a full disk, which tidies up */
}

int cli_interrupted(void) { return caught_signal ? 128 + caught_signal : 0; }

static double now(void) {
    struct timespec time;
    return clock_gettime(CLOCK_MONOTONIC, &time)
               ? 0
               : (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

void cli_progress_start(
    cli_progress *progress, const char *what, const char *name, int quiet, double megabytes) {
    const char *terminal = getenv("TERM");
    int person = isatty(STDERR_FILENO) && terminal && strcmp(terminal, "dumb") != 0;
    *progress = (cli_progress){.enabled = !quiet && person,
        .what = what,
        .name = name,
        .megabytes = megabytes,
        .began = now()};
    progress->said = progress->began;
}

static void show(cli_progress *progress, double fraction, double elapsed) {
    const char *slash = strrchr(progress->name, '/');
    fprintf(stderr, "\r%s ", progress->what);
    cli_write_outside_cut(stderr, slash ? slash + 1 : progress->name, 40);
    if (fraction < 0) { /* how much there is to do is not known */
        fprintf(stderr, ": %.0f s\033[K", elapsed);
        fflush(stderr);
        progress->shown = 1;
        return;
    }
    fprintf(stderr, ": %3.0f %%", 100 * fraction);
    if (progress->megabytes > 0)
        fprintf(stderr, ", %.1f MB/s", progress->megabytes * fraction / elapsed);
    if (fraction > 0.01) fprintf(stderr, ", %.0f s left", elapsed * (1 - fraction) / fraction);
    fputs("\033[K", stderr);
    fflush(stderr);
    progress->shown = 1;
}

static void show_in_time(cli_progress *progress, double fraction) {
    const double first_wait = 0.7, between = 0.1; /* seconds: short work shows nothing */
    if (!progress->enabled) return;
    const double time = now(), elapsed = time - progress->began;
    if (elapsed < first_wait || time - progress->said < between) return;
    show(progress, fraction, elapsed);
    progress->said = time;
}

int cli_progress_report(void *user, double fraction) {
    if (fraction >= 0 && fraction <= 1) show_in_time(user, fraction);
    return cli_interrupted() != 0;
}

int cli_progress_elapsed(void *user, double fraction) {
    (void)fraction;
    show_in_time(user, -1);
    return cli_interrupted() != 0;
}

void cli_progress_hide(cli_progress *progress) {
    if (progress->shown) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
    }
    progress->shown = 0;
}

void cli_progress_stop(cli_progress *progress) {
    cli_progress_hide(progress);
    progress->enabled = 0;
}

int cli_stop_when_interrupted(void *nothing, double fraction) {
    (void)nothing;
    (void)fraction;
    return cli_interrupted() != 0;
}
