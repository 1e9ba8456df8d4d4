/* fuzz.c: the meter, the allocator and the bytes of the fuzz targets. */
#define _DEFAULT_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "fuzz.h"
#include <math.h>
#include <sanitizer/allocator_interface.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

void fuzz_fail(const char *format, ...) {
    va_list arguments;
    fputs("fuzz: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    abort();
}

/* ---- the meter: the sanitizer tells of every block that is taken and given back */

static _Atomic size_t live, peak, at_begin;
static size_t input_size, most;
static double worst_ratio;

static void on_malloc(const volatile void *block, size_t size) {
    (void)block;
    size_t now = atomic_fetch_add(&live, size) + size, seen = atomic_load(&peak);
    while (now > seen && !atomic_compare_exchange_weak(&peak, &seen, now)) {
    }
}

static void on_free(const volatile void *block) {
    if (block)
        atomic_fetch_sub(&live, __sanitizer_get_allocated_size((const void *)(uintptr_t)block));
}

static void on_time_out(int signal_number) {
    static const char text[] = "fuzz: took longer than a second a megabyte\n";
    (void)signal_number;
    (void)!write(2, text, sizeof text - 1);
    abort();
}

/* The limit of processor time that the caller has set is reached: libFuzzer ends in good order. */
static void on_budget(int signal_number) {
    (void)signal_number;
    raise(SIGUSR1);
}

static void set_timer(time_t seconds) {
    struct itimerval timer = {.it_value.tv_sec = seconds};
    setitimer(ITIMER_PROF, &timer, NULL);
}

int LLVMFuzzerInitialize(int *argc, char ***argv) {
    (void)argc;
    (void)argv;
    __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
    struct sigaction action = {.sa_handler = on_time_out}, budget = {.sa_handler = on_budget};
    sigaction(SIGPROF, &action, NULL);
    sigaction(SIGXCPU, &budget, NULL);
    return 0;
}

static void begin(size_t size, size_t base, size_t times) {
    input_size = size;
    most = base + times * size;
    atomic_store(&at_begin, atomic_load(&live));
    atomic_store(&peak, atomic_load(&live));
    set_timer(FUZZ_SECONDS + (time_t)(size >> 17));
}

void fuzz_meter_begin(size_t size) { begin(size, FUZZ_MEMORY_BASE, FUZZ_MEMORY_TIMES); }

void fuzz_meter_begin_plain(size_t size) { begin(size, FUZZ_PLAIN_BASE, FUZZ_PLAIN_TIMES); }

void fuzz_meter_end(void) {
    set_timer(0);
    size_t used = atomic_load(&peak) - atomic_load(&at_begin);
    if (used > most) fuzz_fail("%zu bytes of memory for an input of %zu", used, input_size);
    double ratio = (double)used / (double)(input_size + 1024);
    if (ratio > worst_ratio && getenv("FUZZ_TELL_MEMORY")) {
        worst_ratio = ratio;
        fprintf(stderr, "fuzz: %zu bytes of memory for an input of %zu\n", used, input_size);
    }
}

/* ---- bytes as numbers */

void fuzz_take(fuzz_bytes *bytes, void *out, size_t size) {
    size_t there = size < bytes->left ? size : bytes->left;
    if (size) memset(out, 0, size);
    if (there) memcpy(out, bytes->at, there);
    bytes->at += there;
    bytes->left -= there;
}

uint8_t fuzz_u8(fuzz_bytes *bytes) {
    uint8_t value;
    fuzz_take(bytes, &value, 1);
    return value;
}

uint32_t fuzz_u32(fuzz_bytes *bytes) {
    uint32_t value;
    fuzz_take(bytes, &value, sizeof value);
    return value;
}

uint32_t fuzz_below(fuzz_bytes *bytes, uint32_t bound) {
    if (bound <= 1) return 0;
    return (bound <= 256 ? fuzz_u8(bytes) : fuzz_u32(bytes)) % bound;
}

/* One byte for most numbers, so that equal positions, flat faces and right angles come about; any
 * bits behind a byte of 255. */
float fuzz_float(fuzz_bytes *bytes) {
    static const float special[] = {0.f, -0.f, 1e-45f, -1e-38f, 1.17549435e-38f, 1e-20f, 1e20f,
        -3.4e38f, 3.40282347e38f, INFINITY, -INFINITY, NAN, 0.1f, 1e-7f, 16777217.f, 0.5f};
    uint8_t kind = fuzz_u8(bytes);
    if (kind == 255) {
        float any;
        fuzz_take(bytes, &any, sizeof any);
        return any;
    }
    if (kind >= 240) return special[kind - 240];
    return (float)(kind % 16) - 7.f + (float)(kind / 16) * 0.0625f;
}

double fuzz_double(fuzz_bytes *bytes) {
    if (bytes->left && bytes->at[0] == 254) {
        double any;
        fuzz_u8(bytes);
        fuzz_take(bytes, &any, sizeof any);
        return any;
    }
    return (double)fuzz_float(bytes);
}

uint32_t fuzz_random_u32(fuzz_random *random) { /* Vigna 2015, splitmix64 */
    uint64_t z = random->state += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return (uint32_t)((z ^ z >> 31) >> 32);
}

size_t fuzz_random_below(fuzz_random *random, size_t bound) {
    return bound ? fuzz_random_u32(random) % bound : 0;
}

/* ---- the allocator */

static void *counted_allocate(void *user, size_t size, size_t alignment) {
    fuzz_allocator *counts = user;
    if (alignment == 0 || alignment > 64 || (alignment & (alignment - 1)) != 0)
        fuzz_fail("an alignment of %zu was asked for", alignment);
    if (++counts->calls == counts->fail_at) return NULL;
    size_t rounded = (size + 63) / 64 * 64;
    void *block = rounded < size ? NULL : aligned_alloc(64, rounded ? rounded : 64);
    if (block) {
        counts->live += size;
        counts->peak = counts->live > counts->peak ? counts->live : counts->peak;
        memset(block, 0xA5, size);
    }
    return block;
}

static void counted_release(void *user, void *block, size_t size) {
    fuzz_allocator *counts = user;
    if (!block) return;
    if (size > counts->live) fuzz_fail("%zu bytes are given back, of %zu", size, counts->live);
    counts->live -= size;
    free(block);
}

void fuzz_allocator_start(fuzz_allocator *counts, size_t fail_at) {
    *counts = (fuzz_allocator){
        .allocator = {counted_allocate, counted_release, counts}, .fail_at = fail_at};
}

void fuzz_allocator_finish(fuzz_allocator *counts) {
    if (counts->live) fuzz_fail("%zu bytes were not given back", counts->live);
}

void fuzz_backwards(void *user, size_t count, norma_task *task, void *context) {
    (void)user;
    while (count > 0) task(context, --count);
}
