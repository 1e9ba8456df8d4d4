/* file_read.c: files read: whole, in memory of our own, or piece by piece. */
#define _POSIX_C_SOURCE 200809L
#include "io/file/file.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- The bytes of a file in memory of our own, which no other program can change while
 * they are used; and whether the file still is what was read. */

enum { FIRST_READ = 1 << 16, SMALL_FILE = 1 << 18, AT_ONCE = 1 << 24 };

/* ---- reading */

static int file_is_cancelled(const file_reading *how) {
    return how && how->progress && how->progress(how->progress_user, 0);
}

/* Appends what there is, up to capacity, in slices so small that a cancel is noticed soon. */
static int read_into(
    int descriptor, const file_reading *how, unsigned char *data, size_t capacity, size_t *size) {
    while (*size < capacity) {
        const size_t left = capacity - *size;
        const ssize_t got = read(descriptor, data + *size, left < AT_ONCE ? left : AT_ONCE);
        if (got < 0 && errno != EINTR) return errno;
        if (file_is_cancelled(how)) return FILE_CANCELLED;
        if (got == 0) return 0;
        *size += got > 0 ? (size_t)got : 0;
    }
    return 0;
}

/* One byte more than is expected shows the end. */
static int read_to_end(
    int descriptor, size_t expected, const file_reading *how, file_bytes *bytes) {
    size_t capacity = expected ? expected + 1 : FIRST_READ, size = 0;
    unsigned char *data = norma_io_block(capacity, 1);
    int error = data ? read_into(descriptor, how, data, capacity, &size) : ENOMEM;
    while (!error && size == capacity) {
        unsigned char *larger = capacity > SIZE_MAX / 2 ? NULL : realloc(data, capacity *= 2);
        data = larger ? larger : data;
        error = larger ? read_into(descriptor, how, data, capacity, &size) : ENOMEM;
    }
    if (error)
        free(data);
    else
        *bytes = (file_bytes){.data = data, .size = size, .owned = 1};
    return error;
}

static int map_whole(int descriptor, size_t size, const file_reading *how, file_bytes *bytes) {
    void *data = mmap(NULL, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (data == MAP_FAILED)
        return errno == ENODEV || errno == EACCES ? read_to_end(descriptor, size, how, bytes)
                                                  : errno;
    *bytes = (file_bytes){.data = data, .size = size, .mapped = 1, .owned = 1};
    return 0;
}

static int is_same_file(const file_stamp *a, const file_stamp *b) {
    return a->device == b->device && a->inode == b->inode;
}

static int file_stamps_equal(const file_stamp *a, const file_stamp *b) {
    return is_same_file(a, b) && a->size == b->size && a->seconds == b->seconds &&
           a->nanoseconds == b->nanoseconds;
}

/* A regular file of no size may be one of /proc, whose size is not known before it is read. */
static int read_regular(
    int descriptor, const file_reading *how, const struct stat *status, file_bytes *bytes) {
    struct stat after;
    if ((uintmax_t)status->st_size > SIZE_MAX / 4) return EFBIG;
    const size_t size = (size_t)status->st_size;
    int error = size > SMALL_FILE && how && how->map_large
                    ? map_whole(descriptor, size, how, bytes)
                    : read_to_end(descriptor, size, how, bytes);
    if (error) return error;
    if (size > 0) bytes->stamp = norma_file_stamp_of(status);
    if (bytes->mapped || size == 0) return 0;
    error = fstat(descriptor, &after) ? errno : 0;
    const file_stamp now = norma_file_stamp_of(&after);
    if (!error && !file_stamps_equal(&now, &bytes->stamp)) error = FILE_CHANGED;
    if (error) norma_file_close(bytes);
    return error;
}

/* The descriptor is -1, or to be closed also after an error. */
static int open_regular(const char *path, int *descriptor, struct stat *status) {
    do *descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe would block here */
    while (*descriptor < 0 && errno == EINTR);
    if (*descriptor < 0 || fstat(*descriptor, status)) return errno;
    if (S_ISDIR(status->st_mode)) return EISDIR;
    return S_ISREG(status->st_mode) ? 0 : FILE_NOT_REGULAR;
}

int norma_file_open(const char *path, const file_reading *how, file_bytes *bytes) {
    *bytes = (file_bytes){0};
    int descriptor;
    struct stat status;
    int error = open_regular(path, &descriptor, &status);
    if (!error) error = read_regular(descriptor, how, &status, bytes);
    if (descriptor >= 0) close(descriptor);
    return error;
}

void norma_file_close(file_bytes *bytes) {
    if (bytes->owned && bytes->mapped)
        munmap((void *)(uintptr_t)bytes->data, bytes->size);
    else if (bytes->owned)
        free((void *)(uintptr_t)bytes->data);
    *bytes = (file_bytes){0};
}

/* ---- stamps and names */

file_stamp norma_file_stamp_of(const struct stat *status) {
#if defined(__APPLE__)
    const struct timespec modified = status->st_mtimespec;
#elif defined(_WIN32)
    const struct {
        time_t tv_sec;
        long tv_nsec;
    } modified = {status->st_mtime, 0};
#else
    const struct timespec modified = status->st_mtim;
#endif
    return (file_stamp){.device = (uint64_t)status->st_dev,
        .inode = (uint64_t)status->st_ino,
        .size = (uint64_t)status->st_size,
        .seconds = (int64_t)modified.tv_sec,
        .nanoseconds = (int64_t)modified.tv_nsec,
        .known = S_ISREG(status->st_mode)};
}

static int stamp_path(const char *path, file_stamp *stamp) {
    struct stat status;
    if (stat(path, &status)) return 0;
    *stamp = norma_file_stamp_of(&status);
    return stamp->known;
}

int norma_file_has_changed(const char *path, const file_stamp *stamp) {
    file_stamp now;
    return stamp->known && stamp_path(path, &now) && is_same_file(&now, stamp) &&
           !file_stamps_equal(&now, stamp);
}

int norma_file_is_unchanged(const char *path, const file_stamp *stamp) {
    file_stamp now;
    return stamp_path(path, &now) && file_stamps_equal(&now, stamp);
}

int norma_file_same(const char *a, const char *b) {
    struct stat of_a, of_b;
    if (strcmp(a, b) == 0) /* also where the system does not answer */
        return 1;
    return stat(a, &of_a) == 0 && stat(b, &of_b) == 0 && of_a.st_dev == of_b.st_dev &&
           of_a.st_ino == of_b.st_ino;
}

int norma_file_is_stream(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

int norma_file_is_regular(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && S_ISREG(status.st_mode);
}

int norma_file_is_link(const char *path) {
#if defined(_WIN32)
    return (void)path, 0;
#else
    struct stat status;
    return lstat(path, &status) == 0 && S_ISLNK(status.st_mode);
#endif
}

/* ---- A file read piece by piece. Read, not mapped: what is read counts against memory only
 * as long as it is kept, and a file that another program cuts short is an error instead of a
 * signal. */

struct file_window {
    int descriptor;
    file_stamp stamp;
};

int norma_window_open(const char *path, file_window **window) {
    file_window *made = calloc(1, sizeof *made);
    *window = NULL;
    struct stat status;
    if (!made) return ENOMEM;
    const int error = open_regular(path, &made->descriptor, &status);
    if (error) {
        norma_window_close(made);
        return error;
    }
    made->stamp = norma_file_stamp_of(&status);
    *window = made;
    return 0;
}

void norma_window_close(file_window *window) {
    if (!window) return;
    if (window->descriptor >= 0) close(window->descriptor);
    free(window);
}

const file_stamp *norma_window_stamp(const file_window *window) { return &window->stamp; }

int norma_window_read(const file_window *window, uint64_t offset, void *bytes, size_t size) {
    const size_t at_once = (size_t)1 << 30; /* Linux reads at most 2 GiB in one call */
    unsigned char *at = bytes;
    while (size > 0) {
        const ssize_t got =
            pread(window->descriptor, at, size < at_once ? size : at_once, (off_t)offset);
        if (got == 0) return FILE_CHANGED;
        if (got < 0 && errno != EINTR) return errno;
        if (got < 0) continue;
        at += got;
        offset += (uint64_t)got;
        size -= (size_t)got;
    }
    return 0;
}

int norma_window_has_changed(const file_window *window) {
    struct stat status;
    if (fstat(window->descriptor, &status)) return 1;
    const file_stamp now = norma_file_stamp_of(&status);
    return !file_stamps_equal(&now, &window->stamp);
}
