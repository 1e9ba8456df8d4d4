/* mapped_file.c: the bytes of a file, mapped for reading, and whether they still are what the file
 * holds. */
#define _DEFAULT_SOURCE /* madvise */
#define _POSIX_C_SOURCE 200809L
#include "io/file/file.h"
#include "io/file/file_stamp.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

/* Up to here reading costs no more than mapping, and what is read cannot vanish. */
enum { FIRST_READ = 1 << 16, SMALL_FILE = 1 << 18 };

/* ---- reading */

static int read_to_end(int descriptor, size_t expected, file_bytes *bytes) {
    size_t capacity = expected ? expected + 1 : FIRST_READ, size = 0; /* one more, to see the end */
    unsigned char *data = malloc(capacity);
    while (data) {
        if (size == capacity) {
            unsigned char *larger = capacity > SIZE_MAX / 2 ? NULL : realloc(data, capacity * 2);
            if (!larger) {
                free(data);
                return ENOMEM;
            }
            data = larger;
            capacity *= 2;
        }
        ssize_t got = read(descriptor, data + size, capacity - size);
        if (got == 0) {
            *bytes = (file_bytes){.data = data, .size = size, .owned = 1};
            return 0;
        }
        if (got > 0) {
            size += (size_t)got;
        } else if (errno != EINTR) {
            int error = errno;
            free(data);
            return error;
        }
    }
    return ENOMEM;
}

static int map_whole(int descriptor, size_t size, file_bytes *bytes) {
    void *data = mmap(NULL, size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (data == MAP_FAILED)
        return errno == ENODEV || errno == EACCES ? read_to_end(descriptor, size, bytes) : errno;
    *bytes = (file_bytes){.data = data, .size = size, .mapped = 1, .owned = 1};
    return 0;
}

/* A regular file of no size may be one of /proc, whose size is not known before it is read. */
static int read_regular(int descriptor, int copied, const struct stat *status, file_bytes *bytes) {
    struct stat after;
    if ((uintmax_t)status->st_size > SIZE_MAX / 2) return EFBIG;
    const size_t size = (size_t)status->st_size;
    int error = size > SMALL_FILE && !copied ? map_whole(descriptor, size, bytes)
                                             : read_to_end(descriptor, size, bytes);
    if (error) return error;
    if (size > 0) bytes->stamp = norma_file_stamp_of(status);
    if (bytes->mapped || size == 0) return 0;
    error = fstat(descriptor, &after) ? errno : 0;
    const file_stamp now = norma_file_stamp_of(&after);
    if (!error && !norma_file_stamps_equal(&now, &bytes->stamp)) error = FILE_CHANGED;
    if (error) norma_file_close(bytes);
    return error;
}

int norma_file_open(const char *path, int copied, file_bytes *bytes) {
    *bytes = (file_bytes){0};
    int descriptor;
    do descriptor = open(path, O_RDONLY | O_CLOEXEC);
    while (descriptor < 0 && errno == EINTR);
    if (descriptor < 0) return errno;
    struct stat status;
    int error = fstat(descriptor, &status) ? errno : 0;
    if (!error && S_ISDIR(status.st_mode)) error = EISDIR;
    if (!error)
        error = S_ISREG(status.st_mode) ? read_regular(descriptor, copied, &status, bytes)
                                        : read_to_end(descriptor, 0, bytes);
    close(descriptor);
    return error;
}

void norma_file_close(file_bytes *bytes) {
    if (bytes->owned && bytes->mapped)
        munmap((void *)(uintptr_t)bytes->data, bytes->size);
    else if (bytes->owned)
        free((void *)(uintptr_t)bytes->data);
    *bytes = (file_bytes){0};
}

void norma_file_forget(const file_bytes *bytes) {
#if defined(MADV_DONTNEED)
    const size_t large = (size_t)1 << 24;
    if (bytes->mapped && bytes->size >= large)
        (void)madvise((void *)(uintptr_t)bytes->data, bytes->size, MADV_DONTNEED);
#else
    (void)bytes;
#endif
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

static int is_same_file(const file_stamp *a, const file_stamp *b) {
    return a->device == b->device && a->inode == b->inode;
}

int norma_file_stamps_equal(const file_stamp *a, const file_stamp *b) {
    return is_same_file(a, b) && a->size == b->size && a->seconds == b->seconds &&
           a->nanoseconds == b->nanoseconds;
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
           !norma_file_stamps_equal(&now, stamp);
}

int norma_file_is_unchanged(const char *path, const file_stamp *stamp) {
    file_stamp now;
    return stamp_path(path, &now) && norma_file_stamps_equal(&now, stamp);
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
