/* watch.h: whether the caller still waits for what is under way. Work that may be long without
 * handing anything on asks once in a while: a line, a list or a string may be gigabytes long. Only
 * the thread that made the call talks to the caller; the others see what it was answered. */
#ifndef NORMA_IO_WATCH_H
#define NORMA_IO_WATCH_H
#include <norma/norma.h>
#include <pthread.h>
#include <stdatomic.h>

typedef struct norma_watch {
    norma_progress *progress; /* NULL: nobody watches */
    void *user;
    double told; /* a fraction never falls */
    pthread_t caller;
    atomic_int cancelled;
} norma_watch;

enum { WATCH_BYTES = 1 << 20 }; /* of text, from one question to the next: a few milliseconds */

/* By the thread that makes the call; progress may be NULL. end: whether it was cancelled. */
void norma_watch_begin(norma_watch *watch, norma_progress *progress, void *user);
int norma_watch_end(norma_watch *watch);
/* By the thread that made the call: the fraction, and whether to stop. A norma_progress. */
int norma_watch_tell(void *watch, double fraction);
/* By any thread: whether to stop. watch may be NULL. */
int norma_watch_cancelled(norma_watch *watch);
/* The same once WATCH_BYTES lie between *asked, which moves, and at. */
static inline int norma_watch_passed(norma_watch *watch, const void **asked, const void *at) {
    if ((const char *)at - (const char *)*asked < WATCH_BYTES) return 0;
    *asked = at;
    return norma_watch_cancelled(watch);
}
/* Waits for the condition, or a little while: then the caller is asked. */
void norma_watch_wait(norma_watch *watch, pthread_cond_t *condition, pthread_mutex_t *lock);
#endif
