/* signal.h: a page is sent no signals, so that there is nothing to hold back. */
#ifndef NORMA_WEB_SIGNAL_H
#define NORMA_WEB_SIGNAL_H

typedef int sigset_t;
enum { SIG_BLOCK, SIG_UNBLOCK, SIG_SETMASK };
enum { SIGILL = 4, SIGBUS = 7, SIGFPE = 8, SIGSEGV = 11 };

static inline int sigemptyset(sigset_t *set) { return *set = 0; }
static inline int sigfillset(sigset_t *set) { return *set = 0; }
static inline int sigaddset(sigset_t *set, int number) { return (void)number, *set = 0; }
static inline int sigdelset(sigset_t *set, int number) { return (void)number, *set = 0; }
static inline int pthread_sigmask(int how, const sigset_t *set, sigset_t *before) {
    (void)how, (void)set;
    if (before) *before = 0;
    return 0;
}
#endif
