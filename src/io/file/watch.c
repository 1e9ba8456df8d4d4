/* watch.c: see watch.h. */
#define _POSIX_C_SOURCE 200809L
#include "io/file/watch.h"
#include <stddef.h>
#include <time.h>

void norma_watch_begin(norma_watch *watch, norma_progress *progress, void *user) {
    watch->progress = progress;
    watch->user = user;
    watch->told = 0;
    watch->caller = pthread_self();
    atomic_store(&watch->cancelled, 0);
}

int norma_watch_end(norma_watch *watch) {
    watch->progress = NULL;
    return atomic_exchange(&watch->cancelled, 0);
}

int norma_watch_tell(void *of, double fraction) {
    norma_watch *watch = of;
    if (atomic_load_explicit(&watch->cancelled, memory_order_relaxed)) return 1;
    if (!watch->progress) return 0;
    if (fraction > watch->told) watch->told = fraction;
    const int stop = watch->progress(watch->user, watch->told) != 0;
    if (stop) atomic_store(&watch->cancelled, 1);
    return stop;
}

static int is_caller(const norma_watch *watch) {
    return watch->progress && pthread_equal(watch->caller, pthread_self());
}

int norma_watch_cancelled(norma_watch *watch) {
    if (!watch) return 0;
    return is_caller(watch) ? norma_watch_tell(watch, 0)
                            : atomic_load_explicit(&watch->cancelled, memory_order_relaxed);
}

#if defined(__wasm__) /* one thread, which never waits */
void norma_watch_wait(norma_watch *watch, pthread_cond_t *condition, pthread_mutex_t *lock) {
    (void)watch;
    pthread_cond_wait(condition, lock);
}
#else
void norma_watch_wait(norma_watch *watch, pthread_cond_t *condition, pthread_mutex_t *lock) {
    const long pause = 20000000, second = 1000000000;
    struct timespec until;
    if (!is_caller(watch) || clock_gettime(CLOCK_REALTIME, &until)) {
        pthread_cond_wait(condition, lock);
        return;
    }
    until.tv_nsec += pause;
    until.tv_sec += until.tv_nsec / second;
    until.tv_nsec %= second;
    if (pthread_cond_timedwait(condition, lock, &until) == 0) return;
    pthread_mutex_unlock(lock);
    (void)norma_watch_cancelled(watch);
    pthread_mutex_lock(lock);
}
#endif
