/* faulty_file.c: preloaded, it ends a program that opens a file with "faulty" in its name, by the
 * signal FAULTY_SIGNAL: what a fault of the library would do, without one. With FAULTY_END a
 * process that the program forked ends so when it exits; a file with "unplaced" in its name ends it
 * where another is to be renamed to that. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static pid_t first;

__attribute__((constructor)) static void begin(void) { first = getpid(); }

__attribute__((destructor)) static void end(void) {
    if (getenv("FAULTY_END") && getpid() != first) raise(SIGKILL);
}

typedef int open_call(const char *path, int flags, ...);

static int open_by(const char *name, const char *path, int flags, int mode) {
    const char *number = getenv("FAULTY_SIGNAL");
    if (strstr(path, "faulty")) raise(number ? atoi(number) : SIGSEGV);
    open_call *call;
    *(void **)&call = dlsym(RTLD_NEXT, name);
    return call(path, flags, mode);
}

int open(const char *path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const int mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(more, int) : 0;
    va_end(more);
    return open_by("open", path, flags, mode);
}

int open64(const char *path, int flags, ...) {
    va_list more;
    va_start(more, flags);
    const int mode = flags & (O_CREAT | __O_TMPFILE) ? va_arg(more, int) : 0;
    va_end(more);
    return open_by("open64", path, flags, mode);
}

int rename(const char *from, const char *to) {
    if (strstr(to, "unplaced")) raise(SIGKILL);
    int (*call)(const char *, const char *);
    *(void **)&call = dlsym(RTLD_NEXT, "rename");
    return call(from, to);
}
