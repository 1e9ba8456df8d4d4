/* guarded.c: see guarded.h. Memory counts by having no access rights: each instruction that touches
 * it ends in a signal, which gives it rights, fills it with a pattern, and has the processor stop
 * after that one instruction; what the pattern no longer holds was written. A byte that is written
 * with the pattern's own value is missed, so the work is done twice, with two patterns.
 *
 * Copying what is no whole number of registers makes stores that overlap: the same value again,
 * within as many stores of eight bytes as there are, is one write. */
#define _GNU_SOURCE
#include "oracle/guarded.h"
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <ucontext.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define HAS_SANITIZER 1
#endif
#endif
#if defined(__x86_64__) && defined(__linux__) && !defined(HAS_SANITIZER)
#define CAN_WATCH 1
#endif

enum { SLOTS = 48, ROOM = 1 << 18 };

static unsigned char *base;
static size_t page, taken;

static void open_slots(void) {
    page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t step = ROOM + page;
    void *all = mmap(NULL, SLOTS * step + page, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED) abort();
    base = all;
    for (size_t i = 0; i < SLOTS; ++i)
        if (mprotect(base + page + i * step, ROOM, PROT_READ | PROT_WRITE)) abort();
}

void guarded_reset(void) { taken = 0; }

void *guarded_take(size_t size, int at_end) {
    if (!base) open_slots();
    if (taken == SLOTS || size > ROOM) {
        fprintf(stderr, "guarded: no room for %zu bytes\n", size);
        abort();
    }
    unsigned char *slot = base + page + taken++ * (ROOM + page),
                  *at = at_end ? slot + ROOM - size : slot;
    memset(at, GUARDED_POISON, size);
    return at;
}

static void (*when_crashed)(void);

static void crash(int number) {
    signal(number, SIG_DFL);
    if (when_crashed) when_crashed();
    raise(number);
}

#ifdef CAN_WATCH
enum { TRAP_FLAG = 0x100, WRITES = 2 };

static struct {
    unsigned char *memory, *truth, *writes; /* truth: what it holds */
    long *when; /* of each byte: the number of the store that last wrote it */
    size_t size;
    long reads, stores;
    int on, opened, filled, pattern;
} watch;

static unsigned char *first_page(void) {
    return (unsigned char *)((uintptr_t)watch.memory / page * page);
}

static void protect(int rights) {
    unsigned char *first = first_page();
    const size_t length = (size_t)(watch.memory + watch.size - first);
    if (mprotect(first, (length + page - 1) / page * page, rights)) abort();
}

static void on_touch(int number, siginfo_t *info, void *context) {
    ucontext_t *machine = context;
    unsigned char *at = info->si_addr;
    const size_t length = (size_t)(watch.memory + watch.size - first_page());
    if (!watch.on || watch.opened || at < first_page() ||
        at >= first_page() + (length + page - 1) / page * page) {
        crash(number);
        return;
    }
    const int is_write = (machine->uc_mcontext.gregs[REG_ERR] & WRITES) != 0;
    watch.reads += !is_write;
    watch.opened = 1;
    protect(PROT_READ | PROT_WRITE);
    watch.filled = is_write;
    watch.stores += is_write;
    if (is_write) memset(watch.memory, watch.pattern, watch.size);
    machine->uc_mcontext.gregs[REG_EFL] |= TRAP_FLAG;
}

static void on_step(int number, siginfo_t *info, void *context) {
    ucontext_t *machine = context;
    (void)info;
    if (!watch.opened) {
        crash(number);
        return;
    }
    for (size_t i = 0; i < watch.size && watch.filled; ++i)
        if (watch.memory[i] != watch.pattern) {
            const int again = watch.writes[i] && watch.truth[i] == watch.memory[i] &&
                              watch.stores - watch.when[i] <= 8 + (long)watch.size / 8;
            watch.truth[i] = watch.memory[i];
            watch.when[i] = watch.stores;
            watch.writes[i] = (unsigned char)(watch.writes[i] + (!again && watch.writes[i] < 255));
        }
    memcpy(watch.memory, watch.truth, watch.size);
    watch.opened = 0;
    protect(PROT_NONE);
    machine->uc_mcontext.gregs[REG_EFL] &= ~(greg_t)TRAP_FLAG;
}

static void watch_once(
    int pattern, void watched(void *context), void *context, unsigned char *writes) {
    memset(writes, 0, watch.size);
    memset(watch.memory, GUARDED_POISON, watch.size);
    memset(watch.truth, GUARDED_POISON, watch.size);
    watch.pattern = pattern;
    watch.writes = writes;
    watch.on = 1;
    protect(PROT_NONE);
    watched(context);
    protect(PROT_READ | PROT_WRITE);
    watch.on = 0;
}

long guarded_watch(
    void *memory, size_t size, void watched(void *context), void *context, unsigned char *writes) {
    struct sigaction touch = {.sa_sigaction = on_touch, .sa_flags = SA_SIGINFO},
                     step = {.sa_sigaction = on_step, .sa_flags = SA_SIGINFO}, before[2];
    if (!size) return 0;
    unsigned char *other = malloc(size);
    watch.memory = memory;
    watch.size = size;
    watch.truth = malloc(size);
    watch.when = calloc(size, sizeof *watch.when);
    watch.reads = 0;
    if (!other || !watch.truth || !watch.when) abort();
    sigaction(SIGSEGV, &touch, &before[0]);
    sigaction(SIGTRAP, &step, &before[1]);
    watch_once(0x5A, watched, context, other);
    watch_once(GUARDED_POISON, watched, context, writes);
    sigaction(SIGSEGV, &before[0], NULL);
    sigaction(SIGTRAP, &before[1], NULL);
    for (size_t i = 0; i < size; ++i)
        if (other[i] > writes[i]) writes[i] = other[i];
    memcpy(memory, watch.truth, size);
    free(other);
    free(watch.truth);
    free(watch.when);
    return watch.reads;
}
#else
long guarded_watch(
    void *memory, size_t size, void watched(void *context), void *context, unsigned char *writes) {
    (void)memory, (void)size, (void)watched, (void)context, (void)writes;
    return -1;
}
#endif

void guarded_on_crash(void crashed(void)) {
    static const int numbers[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP};
    when_crashed = crashed;
#ifndef HAS_SANITIZER
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) signal(numbers[i], crash);
#else
    signal(numbers[4], crash);
#endif
}
