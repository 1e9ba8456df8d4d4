/* process.h: this process: errors and exit statuses, memory, progress and signals, workers. */
#ifndef NORMA_CLI_PROCESS_PROCESS_H
#define NORMA_CLI_PROCESS_PROCESS_H
#include <norma/document.h>
#include <stddef.h>
#include <stdint.h>

/* ---- Exit statuses, and the one line on standard error that says what went wrong. */

enum cli_status {
    CLI_OK = 0,
    CLI_FINDINGS = 1,
    CLI_USAGE = 2,
    CLI_FILE = 3 /* a signal ends the process: 128 plus its number */
};
int cli_status_of(norma_document_result result);
int cli_worse(int status, int other); /* of a batch: 3, then 2, then 0 */

const char *cli_input_name(const char *input); /* for people: "standard input" for "-" */
/* Gives an error without words those of its kind, puts the input's name in front of words that
 * begin with a colon, and calls bytes without a name "standard input". */
void cli_name_error(norma_document_error *error, const char *input);
/* That an input ended a worker (below), and why. */
void cli_lost_error(norma_document_error *error, const char *input, const char *why);
/* An error that was printed already: cli_print_error does not print it again. */
norma_document_result cli_reported(norma_document_error *error);
void cli_print_error(const norma_document_error *error);
void cli_print_notes(const char *input, const norma_document *document);
int cli_out_of_memory(void); /* prints that; CLI_FILE */
/* A list with room for one more than count; NULL: out of memory, and the list is as it was. */
void *cli_grow(void *list, size_t count, size_t *room, size_t size);
int cli_finish(int status); /* flushes stdout; a full disk there is status 3 */

/* ---- --max-memory, for the whole process. */

const char *cli_limit_memory(const char *value); /* NULL, or what was expected */
/* What of it may be allocated for data, beside the program itself. */
uint64_t cli_memory_for_data(void);
/* "; memory is limited to 512M (--max-memory)", or "" without a limit: the end of a message. */
enum { CLI_LIMIT_ROOM = 96 };
void cli_memory_limit_words(char text[CLI_LIMIT_ROOM]);

/* ---- A line on stderr while a person waits; and signals that end the process. */

/* SIGINT, SIGTERM and SIGHUP end the process at once, with status 128 plus the signal. Between
 * these two calls, while files are being written, they cancel the writing instead, so that nothing
 * half-written stays; the second call then ends the process. Any thread. */
void cli_watch_interrupts(void);
void cli_writing_begin(void);
void cli_writing_end(void);
/* A temporary file that a signal removes before it ends the process; NULL: none any more. */
void cli_tidy_when_ended(const char *path);
int cli_interrupted(void); /* whether a signal waits for what is being written */

typedef struct cli_progress {
    int enabled;
    struct cli_ticker *ticker;
    double began, said;        /* seconds */
    double whole, steady_from; /* how long all will take, and since when that was expected */
    double megabytes;          /* of the input; 0: not known */
    int is_uneven;             /* equal parts do not take equal time: what is left is not guessed */
    const char *what, *name;
} cli_progress;
void cli_progress_start(
    cli_progress *progress, const char *what, const char *name, int quiet, double megabytes);
int cli_progress_report(void *progress, double fraction); /* a norma_progress */
/* The same for work of several steps, each of which begins at 0: shows the seconds that it took. */
int cli_progress_elapsed(void *progress, double fraction);
/* For work that reports nothing: the seconds are shown until the line is stopped. */
void cli_progress_tick(cli_progress *progress);
/* From now on fractions are written to this descriptor, as doubles, instead of a line. */
void cli_progress_send(int descriptor);
void cli_progress_hide(cli_progress *progress); /* until it is reported again */
void cli_progress_stop(cli_progress *progress);

/* ---- Before anything is opened: closed standard streams, mapped files that become
 * shorter. */

void cli_startup_checks(void);

/* ---- Files of a batch are worked on in a process of their own. A file that ends that process
 * (a fault of ours, a driver, the system out of memory) is named, and the next process goes on
 * behind it. A signal handler could not vouch for the memory that such a file leaves behind. */

enum { CLI_WHY_ROOM = 160 };

typedef struct cli_worker {
    int process;
    int channel; /* of its messages, or into which it sends them */
} cli_worker;

/* Returns 1 in the caller, 0 in the worker, -1 if no worker could be started: the caller then does
 * the work. Only while no other thread runs. */
int cli_worker_start(cli_worker *worker);

/* In the worker. */
void cli_worker_send(const cli_worker *worker, const void *bytes, size_t size);
_Noreturn void cli_worker_finish(const cli_worker *worker);

/* In the caller. 0: the worker has ended. */
int cli_worker_receive(const cli_worker *worker, void *bytes, size_t size);
/* Waits for its end. 1: it ended as it should; else why says by what, and whether a file was at
 * fault. Ends this process as well, where a signal asked for that. */
int cli_worker_wait(cli_worker *worker, int had_file, char why[CLI_WHY_ROOM]);
#endif
