/* signal.h: no signal reaches a WebAssembly program. Its host, node, is ended by them, and so ends
 * it. Handlers are taken and never called. */
#ifndef NORMA_TOOL_SIGNAL_H
#define NORMA_TOOL_SIGNAL_H
#include_next <signal.h>
#include <unistd.h>

enum { SIGHUP = 1, SIGINT = 2, SIGKILL = 9, SIGTERM = 15, SIGXFSZ = 25 };
typedef int sig_atomic_t;
struct sigaction {
    void (*sa_handler)(int number);
    sigset_t sa_mask;
    int sa_flags;
};
#define SIG_IGN ((void (*)(int))1)

static inline int sigaction(int number, const struct sigaction *action, struct sigaction *before) {
    (void)number, (void)action;
    if (before) *before = (struct sigaction){0};
    return 0;
}
static inline void (*signal(int number, void (*handler)(int)))(int) {
    return (void)number, handler;
}
static inline int kill(pid_t process, int number) { return (void)process, (void)number, -1; }
#endif
