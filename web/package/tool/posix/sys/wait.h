/* wait.h: no process can be started, so that there is none to wait for (process.c works on files
 * in its own process then). */
#ifndef NORMA_TOOL_WAIT_H
#define NORMA_TOOL_WAIT_H
#include <errno.h>
#include <unistd.h>

#define WIFEXITED(status)   ((void)(status), 1)
#define WIFSIGNALED(status) ((void)(status), 0)
#define WEXITSTATUS(status) (status)
#define WTERMSIG(status)    (status)

static inline pid_t fork(void) { return errno = ENOSYS, -1; }
static inline int pipe(int ends[2]) { return (void)ends, errno = ENOSYS, -1; }
static inline pid_t waitpid(pid_t process, int *status, int how) {
    return (void)process, (void)status, (void)how, errno = ECHILD, -1;
}
#endif
