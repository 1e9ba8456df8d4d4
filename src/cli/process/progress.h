/* progress.h: a line on stderr while a person waits, and interrupts. */
#ifndef NORMA_CLI_PROGRESS_H
#define NORMA_CLI_PROGRESS_H

void cli_watch_interrupts(void);
int cli_interrupted(void); /* 0, or 128 plus the signal */

typedef struct cli_progress {
    int shown, enabled;
    double began, said; /* seconds */
    double megabytes;   /* of the input; 0: not known */
    const char *what, *name;
} cli_progress;
void cli_progress_start(
    cli_progress *progress, const char *what, const char *name, int quiet, double megabytes);
int cli_progress_report(void *progress, double fraction); /* a norma_progress */
/* The same for work of several steps, each of which begins at 0: shows the seconds that it took. */
int cli_progress_elapsed(void *progress, double fraction);
void cli_progress_hide(cli_progress *progress); /* until it is reported again */
void cli_progress_stop(cli_progress *progress);
/* A norma_progress that shows nothing. */
int cli_stop_when_interrupted(void *nothing, double fraction);
#endif
