/* worker.h: files of a batch are worked on in a process of their own. A file that ends that process
 * (a fault of ours, a driver, the system out of memory) is named, and the next process goes on
 * behind it. A signal handler could not vouch for the memory that such a file leaves behind. */
#ifndef NORMA_CLI_WORKER_H
#define NORMA_CLI_WORKER_H
#include <stddef.h>

enum { CLI_WHY_ROOM = 160 };

typedef struct cli_worker {
    int process;
    int channel; /* of its messages, or into which it sends them */
} cli_worker;

/* 1: in the caller, 0: in the worker, -1: there is none, and the work is to be done here. Only
 * where no other thread runs. */
int cli_worker_start(cli_worker *worker);

/* In the worker. */
void cli_worker_send(const cli_worker *worker, const void *bytes, size_t size);
_Noreturn void cli_worker_finish(const cli_worker *worker);

/* In the caller. 0: the worker has ended. */
int cli_worker_receive(const cli_worker *worker, void *bytes, size_t size);
/* Waits for its end. 1: it ended as it should; else why says by what. Ends this process as well,
 * where a signal asked for that. */
int cli_worker_wait(cli_worker *worker, char why[CLI_WHY_ROOM]);

#endif
