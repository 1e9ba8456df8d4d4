/* progress.h: a line on stderr while a person waits; and signals that end the process. */
#ifndef NORMA_CLI_PROGRESS_H
#define NORMA_CLI_PROGRESS_H

/* SIGINT, SIGTERM and SIGHUP end the process at once, with status 128 plus the signal. Between
 * these two calls, while files are being written, they cancel the writing instead, so that nothing
 * half-written stays; the second call then ends the process. Any thread. */
void cli_watch_interrupts(void);
void cli_writing_begin(void);
void cli_writing_end(void);
/* A temporary file that a signal removes before it ends the process; NULL: none any more. */
void cli_tidy_when_ended(const char *path);
/* A process that is worked in: signals go on to it, and end this one when it has ended; 0: it has.
 */
void cli_watch_worker(int process);
void cli_be_worker(void);  /* this is such a process */
int cli_interrupted(void); /* whether a signal waits for what is being written */

typedef struct cli_progress {
    int enabled;
    struct cli_ticker *ticker;
    double began, said; /* seconds */
    double megabytes;   /* of the input; 0: not known */
    const char *what, *name;
} cli_progress;
void cli_progress_start(
    cli_progress *progress, const char *what, const char *name, int quiet, double megabytes);
int cli_progress_report(void *progress, double fraction); /* a norma_progress */
/* The same for work of several steps, each of which begins at 0: shows the seconds that it took. */
int cli_progress_elapsed(void *progress, double fraction);
/* For work that reports nothing: the seconds are shown until the line is stopped. */
void cli_progress_tick(cli_progress *progress);
void cli_progress_hide(cli_progress *progress); /* until it is reported again */
void cli_progress_stop(cli_progress *progress);
#endif
