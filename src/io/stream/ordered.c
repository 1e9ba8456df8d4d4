/* ordered.c: a file made piece by piece, by threads, and handed on in order. The calling thread
 * hands on what is ready, and makes pieces itself while nothing is: so that what the system needs
 * for writing goes on beside the making. */
#define _POSIX_C_SOURCE 200809L
#include "io/stream/ordered.h"
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include "io/file/memory.h"
#include "io/stream/tasks.h"

enum { MOST_HELPERS = 255 };

typedef struct line { /* in which pieces stand */
    pthread_mutex_t lock;
    pthread_cond_t ready, room; /* told: the calling thread, the others */
    norma_make_data_run *make;
    void *context;
    norma_watch *watch;
    norma_data_run *pieces;
    unsigned char *made;
    size_t count, places;   /* piece i stands at place i % places */
    size_t next, handed_on; /* the next to be made; how many are gone */
    int stop;
} line;

static void make_run(line *l, size_t index) {
    norma_data_run *piece = &l->pieces[index % l->places];
    if (!piece->sink.block) norma_sink_flush(&piece->sink); /* its first block */
    piece->sink.used = 0;
    piece->span = NULL;
    piece->span_size = 0;
    if (!piece->sink.failed) l->make(l->context, index, piece);
}

/* Takes a piece to make, if there is one whose place is free. */
static int take(line *l, size_t *index) {
    if (l->stop || l->next >= l->count || l->next >= l->handed_on + l->places) return 0;
    *index = l->next++;
    return 1;
}

static void *help(void *context) {
    line *l = context;
    size_t index;
    pthread_mutex_lock(&l->lock);
    while (!l->stop && l->next < l->count) {
        if (!take(l, &index)) {
            pthread_cond_wait(&l->room, &l->lock);
            continue;
        }
        pthread_mutex_unlock(&l->lock);
        make_run(l, index);
        pthread_mutex_lock(&l->lock);
        l->made[index % l->places] = 1;
        pthread_cond_signal(&l->ready);
    }
    pthread_mutex_unlock(&l->lock);
    return NULL;
}

static norma_ordered_result hand_on(const norma_data_run *piece, norma_write *write, void *user) {
    if (piece->sink.failed) return NORMA_ORDERED_MEMORY;
    if (piece->sink.used && write(user, piece->sink.block, piece->sink.used))
        return NORMA_ORDERED_REFUSED;
    return piece->span_size && write(user, piece->span, piece->span_size) ? NORMA_ORDERED_REFUSED
                                                                          : NORMA_ORDERED_OK;
}

static norma_ordered_result lead(line *l, norma_write *write, void *user) {
    norma_ordered_result result = NORMA_ORDERED_OK;
    size_t index;
    pthread_mutex_lock(&l->lock);
    while (!result && l->handed_on < l->count) {
        const size_t place = l->handed_on % l->places;
        if (l->watch && atomic_load(&l->watch->cancelled)) {
            result = NORMA_ORDERED_REFUSED;
        } else if (l->made[place]) {
            pthread_mutex_unlock(&l->lock);
            result = hand_on(&l->pieces[place], write, user);
            pthread_mutex_lock(&l->lock);
            l->made[place] = 0;
            ++l->handed_on;
            pthread_cond_broadcast(&l->room);
        } else if (take(l, &index)) {
            pthread_mutex_unlock(&l->lock);
            make_run(l, index);
            pthread_mutex_lock(&l->lock);
            l->made[index % l->places] = 1;
        } else {
            norma_watch_wait(l->watch, &l->ready, &l->lock);
        }
    }
    l->stop = 1;
    pthread_cond_broadcast(&l->room);
    pthread_mutex_unlock(&l->lock);
    return result;
}

/* A thread that cannot be had is done without. Signals are for the calling thread: one that hangs
 * in a write must be the one that is interrupted. */
static size_t start_helpers(line *l, size_t threads, pthread_t helpers[MOST_HELPERS]) {
    size_t started = 0;
#if !defined(_WIN32) /* which sends signals to threads of their own */
    sigset_t all, before;
    sigfillset(&all);
    /* Signals raised by a thread's own instruction must reach their handler: blocked, they would
     * end the process. */
    static const int own[] = {SIGBUS, SIGSEGV, SIGILL, SIGFPE};
    for (size_t i = 0; i < sizeof own / sizeof *own; ++i) sigdelset(&all, own[i]);
    const int masked = pthread_sigmask(SIG_BLOCK, &all, &before) == 0;
#endif
    while (started + 1 < threads && started < MOST_HELPERS && started + 1 < l->count &&
           pthread_create(&helpers[started], NULL, help, l) == 0)
        ++started;
#if !defined(_WIN32)
    if (masked) pthread_sigmask(SIG_SETMASK, &before, NULL);
#endif
    return started;
}

static norma_ordered_result run(line *l, size_t threads, norma_write *write, void *user) {
    pthread_t helpers[MOST_HELPERS];
    const size_t started = start_helpers(l, threads, helpers);
    norma_ordered_result result = lead(l, write, user);
    for (size_t i = 0; i < started; ++i) pthread_join(helpers[i], NULL);
    return result;
}

static norma_ordered_result open_and_run(line *l, size_t threads, norma_write *write, void *user) {
    if (pthread_mutex_init(&l->lock, NULL)) return NORMA_ORDERED_MEMORY;
    norma_ordered_result result = NORMA_ORDERED_MEMORY;
    if (pthread_cond_init(&l->ready, NULL) == 0) {
        if (pthread_cond_init(&l->room, NULL) == 0) {
            result = run(l, threads, write, user);
            pthread_cond_destroy(&l->room);
        }
        pthread_cond_destroy(&l->ready);
    }
    pthread_mutex_destroy(&l->lock);
    return result;
}

norma_ordered_result norma_write_ordered(norma_ordered_how how, size_t count,
    norma_make_data_run *make, void *context, norma_write *write, void *user) {
    const size_t workers = norma_io_threads(how.threads);
    line l = {.make = make,
        .context = context,
        .watch = how.watch,
        .count = count,
        .places = workers > count / 2 ? count + 1 : 2 * workers};
    l.pieces = norma_io_allocate(l.places, sizeof *l.pieces);
    l.made = norma_io_allocate(l.places, 1);
    norma_ordered_result result =
        l.pieces && l.made ? open_and_run(&l, workers, write, user) : NORMA_ORDERED_MEMORY;
    for (size_t i = 0; l.pieces && i < l.places; ++i) free(l.pieces[i].sink.block);
    free(l.pieces);
    free(l.made);
    return result;
}
