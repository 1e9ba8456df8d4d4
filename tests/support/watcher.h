/* watcher.h: a progress function that counts its calls, stops at one of them if asked, and notices
 * a fraction that falls or is none. */
#ifndef NORMA_TEST_WATCHER_H
#define NORMA_TEST_WATCHER_H
#include <stddef.h>

typedef struct watcher {
    size_t calls, stop_at; /* 0: never */
    double last;
    int fell;
} watcher;

static inline int watch(void *user, double fraction) {
    watcher *w = user;
    w->fell |= fraction < w->last || !(fraction >= 0 && fraction <= 1);
    w->last = fraction;
    return ++w->calls == w->stop_at;
}
#endif
