/* progress.c: a line on stderr while a person waits, and Ctrl-C. Only while an output is written is
 * there anything to tidy up: then a signal sets a flag, which the library's progress callback turns
 * into a cancel. At any other time it ends the process where it is, whatever is being read,
 * computed or drawn, and however long the next callback would take. */
#define _POSIX_C_SOURCE 200809L
#include "cli/process/progress.h"
#include "cli/text/outside_text.h"
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* The variables of the tool: a signal handler has no other way to know anything. */
static volatile sig_atomic_t caught_signal, caught_count, line_shown;
static atomic_int writers;
static const char *volatile left_behind;
static volatile sig_atomic_t worker, is_worker; /* the process of another, or whether this is one */

static _Noreturn void end_now(int number) {
    static const char words[] = "\r\033[Knorma: interrupted\n";
    const size_t clear = line_shown ? 0 : 4;
    if (!is_worker) { /* else the caller says so */
        const ssize_t written = write(STDERR_FILENO, words + clear, sizeof words - 1 - clear);
        (void)written;
    }
    if (left_behind) unlink(left_behind);
    _exit(128 + number);
}

/* Three times: someone insists, while a write does not come back. A worker hears a terminal's
 * signals twice, once from its caller, which waits for it. */
static void catch_signal(int number) {
    enum { INSISTING = 3 };
    const int insists = ++caught_count >= INSISTING * (is_worker ? 2 : 1);
    caught_signal = number;
    if (worker) kill((pid_t)worker, insists ? SIGKILL : number);
    if (insists || (!worker && atomic_load(&writers) == 0)) end_now(number);
}

void cli_watch_worker(int process) {
    worker = process;
    if (!process && caught_signal) end_now(caught_signal);
}

void cli_be_worker(void) {
    is_worker = 1;
    worker = 0;
    left_behind = NULL;
}

void cli_tidy_when_ended(const char *path) { left_behind = path; }

void cli_writing_begin(void) { atomic_fetch_add(&writers, 1); }

void cli_writing_end(void) {
    if (atomic_fetch_sub(&writers, 1) == 1 && caught_signal) end_now(caught_signal);
}

void cli_watch_interrupts(void) {
    static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
    struct sigaction action = {.sa_handler = catch_signal}, old;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i)
        if (sigaction(numbers[i], NULL, &old) == 0 &&
            old.sa_handler != SIG_IGN) /* ignored: as nohup wants it */
            sigaction(numbers[i], &action, NULL);
    setvbuf(stdout, NULL, _IOLBF, 0); /* what was printed of earlier files is not lost */
    signal(SIGXFSZ,
        SIG_IGN); /* a file over its limit is then an error like a full disk, which tidies up */
}

int cli_interrupted(void) { return caught_signal != 0; }

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
        line_shown = 1;
        return;
    }
    fprintf(stderr, ": %3.0f %%", 100 * fraction);
    if (progress->megabytes > 0)
        fprintf(stderr, ", %.1f MB/s", progress->megabytes * fraction / elapsed);
    if (fraction > 0.01) fprintf(stderr, ", %.0f s left", elapsed * (1 - fraction) / fraction);
    fputs("\033[K", stderr);
    fflush(stderr);
    line_shown = 1;
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
    return cli_interrupted();
}

int cli_progress_elapsed(void *user, double fraction) {
    (void)fraction;
    show_in_time(user, -1);
    return cli_interrupted();
}

void cli_progress_hide(cli_progress *progress) {
    if (progress->enabled && line_shown) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
        line_shown = 0;
    }
}

/* ---- a thread that shows the seconds */

struct cli_ticker {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t ended;
    int stop;
    cli_progress *progress;
};

static void *tick(void *user) {
    struct cli_ticker *ticker = user;
    pthread_mutex_lock(&ticker->lock);
    while (!ticker->stop) {
        struct timespec next;
        clock_gettime(CLOCK_REALTIME, &next);
        next.tv_nsec += 100000000;
        next.tv_sec += next.tv_nsec / 1000000000;
        next.tv_nsec %= 1000000000;
        pthread_cond_timedwait(&ticker->ended, &ticker->lock, &next);
        if (!ticker->stop) show_in_time(ticker->progress, -1);
    }
    pthread_mutex_unlock(&ticker->lock);
    return NULL;
}

void cli_progress_tick(cli_progress *progress) {
    struct cli_ticker *ticker = progress->enabled ? calloc(1, sizeof *ticker) : NULL;
    if (!ticker) return;
    ticker->progress = progress;
    pthread_mutex_init(&ticker->lock, NULL);
    pthread_cond_init(&ticker->ended, NULL);
    if (pthread_create(&ticker->thread, NULL, tick, ticker) == 0)
        progress->ticker = ticker;
    else
        free(ticker);
}

static void stop_ticker(struct cli_ticker *ticker) {
    pthread_mutex_lock(&ticker->lock);
    ticker->stop = 1;
    pthread_cond_signal(&ticker->ended);
    pthread_mutex_unlock(&ticker->lock);
    pthread_join(ticker->thread, NULL);
    pthread_cond_destroy(&ticker->ended);
    pthread_mutex_destroy(&ticker->lock);
    free(ticker);
}

void cli_progress_stop(cli_progress *progress) {
    if (progress->ticker) stop_ticker(progress->ticker);
    progress->ticker = NULL;
    cli_progress_hide(progress);
    progress->enabled = 0;
}
