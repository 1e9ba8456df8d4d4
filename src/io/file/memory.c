/* memory.c: what files need of the system: memory, words for its errors, and whether the caller
 * still waits. */
#define _DEFAULT_SOURCE /* madvise */
#define _POSIX_C_SOURCE 200809L
#include "io/file/file.h"
#include <errno.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif

/* ---- Checked allocation, lists and texts that grow, copies of texts. */

void *norma_io_allocate(size_t count, size_t size) {
    if (size && count > SIZE_MAX / size) return NULL;
    return calloc(count ? count : 1, size ? size : 1);
}

char *norma_io_copy_text(const char *text, size_t length) {
    char *copy = norma_io_allocate(length + 1, 1);
    if (copy) memcpy(copy, text, length);
    return copy;
}

char *norma_io_join(const char *folder, const char *name) {
    const size_t a = strlen(folder), b = strlen(name);
    char *joined = norma_io_allocate(a + b + 1, 1);
    if (!joined) return NULL;
    memcpy(joined, folder, a);
    memcpy(joined + a, name, b);
    return joined;
}

void *norma_io_grow(void *block, size_t *capacity, size_t needed, size_t size) {
    if (block && needed <= *capacity) return block;
    size_t larger = *capacity > SIZE_MAX / 2 ? needed : *capacity * 2;
    if (larger < needed) larger = needed;
    if (larger < 16) larger = 16;
    if (size && larger > SIZE_MAX / size) return NULL;
    void *grown = realloc(block, larger * (size ? size : 1));
    if (grown) *capacity = larger;
    return grown;
}

void *norma_io_add(void *list, size_t *capacity, size_t *count, size_t size) {
    void *block;
    memcpy(&block, list, sizeof block);
    char *grown = norma_io_grow(block, capacity, *count + 1, size);
    if (!grown) return NULL;
    memcpy(list, &grown, sizeof grown);
    return memset(grown + (*count)++ * size, 0, size);
}

void norma_io_append(growing_bytes *to, const void *bytes, size_t size) {
    if (to->failed || size == 0) return;
    if (size > to->capacity - to->size) {
        char *grown = size > SIZE_MAX - to->size
                          ? NULL
                          : norma_io_grow(to->data, &to->capacity, to->size + size, 1);
        to->failed = !grown;
        if (!grown) return;
        to->data = grown;
    }
    memcpy(to->data + to->size, bytes, size);
    to->size += size;
}

/* ---- Blocks that may be large. Arrays of a large mesh are written once from end to
 * end, and what that costs is mostly their pages. */

enum { LARGE_BLOCK = 1 << 22 };

#if defined(__linux__)
static void *large_block(size_t bytes) {
    const size_t page = (size_t)1 << 21,
                 rounded = bytes > SIZE_MAX - page ? 0 : (bytes + page - 1) / page * page;
    void *block = rounded ? aligned_alloc(page, rounded) : NULL;
    /* A last page that would stay mostly empty is not worth its memory. */
    if (block) (void)madvise(block, (bytes + page / 2) / page * page, MADV_HUGEPAGE);
    return block;
}
#else
static void *large_block(size_t bytes) { return malloc(bytes); }
#endif

/* 0: more than there can be. */
static size_t bytes_of(size_t count, size_t size) {
    return count == 0 || size == 0 ? 1 : count > SIZE_MAX / size ? 0 : count * size;
}

void *norma_io_block(size_t count, size_t size) {
    const size_t bytes = bytes_of(count, size);
    if (!bytes) return NULL;
    return bytes >= LARGE_BLOCK ? large_block(bytes) : malloc(bytes);
}

void *norma_io_move_block(void *block, size_t kept, size_t count, size_t size) {
    void *moved = norma_io_block(count, size);
    if (!moved) return NULL;
    if (kept) memcpy(moved, block, kept);
    free(block);
    return moved;
}

/* ---- What an error number means, in the same words on every system and in every locale.
 * strerror would follow the program's locale. */

static const struct {
    int error;
    const char *text;
} TEXTS[] = {
    {EACCES, "Permission denied"},
    {EBADF, "Bad file descriptor"},
    {EBUSY, "Device or resource busy"},
    {EEXIST, "File exists"},
    {EFBIG, "File too large"},
    {EINTR, "Interrupted system call"},
    {EINVAL, "Invalid argument"},
    {EIO, "Input/output error"},
    {EISDIR, "Is a directory"},
    {ELOOP, "Too many levels of symbolic links"},
    {EMFILE, "Too many open files"},
    {ENAMETOOLONG, "File name too long"},
    {ENFILE, "Too many open files in system"},
    {ENODEV, "No such device"},
    {ENOENT, "No such file or directory"},
    {ENOMEM, "Cannot allocate memory"},
    {ENOSPC, "No space left on device"},
    {ENOSYS, "Function not implemented"},
    {ENOTDIR, "Not a directory"},
    {ENXIO, "No such device or address"},
    {EPERM, "Operation not permitted"},
    {EPIPE, "Broken pipe"},
    {EROFS, "Read-only file system"},
    {ETXTBSY, "Text file busy"},
    {EXDEV, "Invalid cross-device link"},
#if defined(EDQUOT)
    {EDQUOT, "Disk quota exceeded"},
#endif
#if defined(ESTALE)
    {ESTALE, "Stale file handle"},
#endif
};

const char *norma_system_text(int error) {
    for (size_t i = 0; i < sizeof TEXTS / sizeof *TEXTS; ++i)
        if (TEXTS[i].error == error) return TEXTS[i].text;
    return NULL;
}

/* ---- Whether the caller still waits: see file.h. */

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
