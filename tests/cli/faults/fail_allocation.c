/* fail_allocation.c: a library to be preloaded, whose n-th allocation fails. FAULT_ALLOCATION: n,
 * from 1. FAULT_FROM_THERE_ON: all after it as well. FAULT_PROGRAM: only what the program itself
 * asks for is counted, not the libraries that it uses. FAULT_SHOW: says where that was (addr2line).
 * A byte on descriptor 199 tells that n was reached. glibc. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *block, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static atomic_long counted, fail_at = -1, in_main;
static int from_there_on, only_program, show;
static uintptr_t program_start, program_end;

static int must_fail(const void *caller) {
    const uintptr_t at = (uintptr_t)caller;
    if (atomic_load(&fail_at) <= 0 || !atomic_load(&in_main) ||
        (only_program && (at < program_start || at >= program_end)))
        return 0;
    const long number = atomic_fetch_add(&counted, 1) + 1, wanted = atomic_load(&fail_at);
    if (number == wanted) {
        const ssize_t told = write(199, "!", 1);
        (void)told;
        if (show) {
            void *frames[40];
            backtrace_symbols_fd(frames, backtrace(frames, 40), STDERR_FILENO);
        }
    }
    if (number != wanted && !(from_there_on && number > wanted)) return 0;
    errno = ENOMEM;
    return 1;
}

void *malloc(size_t size) {
    return must_fail(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}
void *calloc(size_t count, size_t size) {
    return must_fail(__builtin_return_address(0)) ? NULL : __libc_calloc(count, size);
}
void *realloc(void *block, size_t size) {
    return must_fail(__builtin_return_address(0)) ? NULL : __libc_realloc(block, size);
}
void *aligned_alloc(size_t alignment, size_t size) {
    return must_fail(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}
void *memalign(size_t alignment, size_t size) {
    return must_fail(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}
int posix_memalign(void **block, size_t alignment, size_t size) {
    if (must_fail(__builtin_return_address(0))) return ENOMEM;
    *block = __libc_memalign(alignment, size);
    return *block ? 0 : ENOMEM;
}

static void find_program(void *from) {
    Dl_info info;
    if (dladdr(from, &info)) program_start = (uintptr_t)info.dli_fbase;
    program_end =
        program_start +
        ((uintptr_t)1
            << 26); /* far more than the program is, and far less than to the first library */
}

/* main begins where the C library calls it. */
int __libc_start_main(int (*start)(int, char **, char **), int count, char **words,
    void (*init)(void), void (*fini)(void), void (*rtld_fini)(void), void *stack);
static int (*real_main)(int, char **, char **);

static int counted_main(int count, char **words, char **environment) {
    const char *at = getenv("FAULT_ALLOCATION");
    from_there_on = getenv("FAULT_FROM_THERE_ON") != NULL;
    only_program = getenv("FAULT_PROGRAM") != NULL;
    show = getenv("FAULT_SHOW") != NULL;
    find_program((void *)(uintptr_t)real_main);
    if (at) atomic_store(&fail_at, atol(at));
    atomic_store(&in_main, 1);
    return real_main(count, words, environment);
}

int __libc_start_main(int (*start)(int, char **, char **), int count, char **words,
    void (*init)(void), void (*fini)(void), void (*rtld_fini)(void), void *stack) {
    int (*next)(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void),
        void (*)(void), void *);
    void *symbol = dlsym(RTLD_NEXT, "__libc_start_main");
    memcpy(&next, &symbol, sizeof next);
    real_main = start;
    return next(counted_main, count, words, init, fini, rtld_fini, stack);
}
