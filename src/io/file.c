/* file.c: the bytes of a file, mapped for reading, and files that are written whole or not at all.
 *
 * Writing goes to a temporary file beside the target, which is flushed and renamed over it (rename is atomic in POSIX), and then the folder is flushed: whatever
 * happens, a crash or a full disk, the old file or the new one is whole. */
#define _DEFAULT_SOURCE               /* madvise */
#define _POSIX_C_SOURCE 200809L
#include "file.h"
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER_SIZE = 1 << 18, FIRST_READ = 1 << 16, MOST_LINKS = 40, MOST_NAMES = 10000 };
static const size_t WRITE_AT_ONCE = (size_t)1 << 30; /* Linux writes at most 2 GiB in one call */

/* ---- reading */

static int read_to_end(int descriptor, file_bytes *bytes) {
    size_t capacity = FIRST_READ, size = 0;
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

static int map_whole(int descriptor, uintmax_t size, file_bytes *bytes) {
    if (size > SIZE_MAX / 2)
        return EFBIG;
    void *data = mmap(NULL, (size_t)size, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (data == MAP_FAILED)
        return errno == ENODEV || errno == EACCES ? read_to_end(descriptor, bytes) : errno;
    *bytes = (file_bytes){.data = data, .size = (size_t)size, .mapped = 1, .owned = 1};
    return 0;
}

int norma_file_open(const char *path, file_bytes *bytes) {
    *bytes = (file_bytes){0};
    int descriptor;
    do descriptor = open(path, O_RDONLY | O_CLOEXEC);
    while (descriptor < 0 && errno == EINTR);
    if (descriptor < 0)
        return errno;
    struct stat status;
    int error = fstat(descriptor, &status) ? errno : 0;
    if (!error && S_ISDIR(status.st_mode))
        error = EISDIR;
    /* A regular file of no size may be one of /proc, whose size is not known before it is read. */
    if (!error)
        error = S_ISREG(status.st_mode) && status.st_size > 0 ? map_whole(descriptor, (uintmax_t)status.st_size, bytes) : read_to_end(descriptor, bytes);
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

int norma_file_same(const char *a, const char *b) {
    struct stat of_a, of_b;
    return stat(a, &of_a) == 0 && stat(b, &of_b) == 0 && of_a.st_dev == of_b.st_dev && of_a.st_ino == of_b.st_ino;
}

int norma_file_is_stream(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

/* ---- writing */

struct file_writer {
    int descriptor;
    char *target;    /* where it goes: path with its symbolic links followed */
    char *temporary; /* NULL: the target is a device or a pipe, written as it is */
    int error;       /* the first one; every later call returns it */
    size_t used;
    unsigned char buffer[BUFFER_SIZE];
};

static size_t folder_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

/* The first folder bytes of path, then name; NULL: out of memory. */
static char *join(const char *path, size_t folder, const char *name) {
    size_t length = strlen(name);
    char *joined = malloc(folder + length + 1);
    if (!joined)
        return NULL;
    memcpy(joined, path, folder);
    memcpy(joined + folder, name, length + 1);
    return joined;
}

/* Follows the symbolic links at the end of path, also to a file that is not there yet. */
static int resolve(const char *path, char **resolved) {
    char *current = join(path, 0, path), link[PATH_MAX + 1];
    for (int hops = 0; current; ++hops) {
        ssize_t length = readlink(current, link, PATH_MAX);
        if (length < 0) {
            *resolved = current;
            return 0; /* EINVAL: no link; anything else shows again when the file is made */
        }
        if (hops == MOST_LINKS) {
            free(current);
            return ELOOP;
        }
        link[length] = '\0';
        char *next = join(current, link[0] == '/' ? 0 : folder_length(current), link);
        free(current);
        current = next;
    }
    return ENOMEM;
}

static int open_temporary(file_writer *writer, mode_t mode) {
    for (unsigned number = 0; number < MOST_NAMES; ++number) {
        char name[64];
        snprintf(name, sizeof name, ".norma-%ld-%u.tmp", (long)getpid(), number);
        char *temporary = join(writer->target, folder_length(writer->target), name);
        if (!temporary)
            return ENOMEM;
        writer->descriptor = open(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode);
        if (writer->descriptor >= 0) {
            writer->temporary = temporary;
            return 0;
        }
        int error = errno;
        free(temporary);
        if (error != EEXIST && error != EINTR)
            return error;
    }
    return EEXIST;
}

/* Owner and permissions of the file that is to be replaced. Where the owner cannot be kept, neither are the bits that lend his rights. */
static int keep_permissions(int descriptor, const struct stat *old) {
    mode_t mode = old->st_mode & 07777;
    if (fchown(descriptor, old->st_uid, old->st_gid))
        mode &= 0777;
    return fchmod(descriptor, mode) ? errno : 0;
}

static int open_target(file_writer *writer) {
    struct stat old;
    if (stat(writer->target, &old))
        return errno == ENOENT ? open_temporary(writer, 0666) : errno;
    if (S_ISDIR(old.st_mode))
        return EISDIR;
    if (access(writer->target, W_OK))
        return errno;
    if (!S_ISREG(old.st_mode)) {
        writer->descriptor = open(writer->target, O_WRONLY | O_CLOEXEC);
        return writer->descriptor < 0 ? errno : 0;
    }
    int error = open_temporary(writer, 0600);
    return error ? error : keep_permissions(writer->descriptor, &old);
}

int norma_file_writer_open(const char *path, file_writer **writer) {
    *writer = NULL;
    file_writer *made = malloc(sizeof *made);
    if (!made)
        return ENOMEM;
    made->descriptor = -1;
    made->temporary = made->target = NULL;
    made->error = 0;
    made->used = 0;
    /* The links of /proc/self/fd name no path that could be opened, so what is no regular file is not resolved. */
    int error = norma_file_is_stream(path) ? ((made->target = join(path, 0, path)) ? 0 : ENOMEM) : resolve(path, &made->target);
    if (!error)
        error = open_target(made);
    if (error) {
        norma_file_writer_abandon(made);
        return error;
    }
    *writer = made;
    return 0;
}

static int write_all(file_writer *writer, const unsigned char *bytes, size_t size) {
    while (size > 0 && !writer->error) {
        ssize_t written = write(writer->descriptor, bytes, size < WRITE_AT_ONCE ? size : WRITE_AT_ONCE);
        if (written > 0) {
            bytes += written;
            size -= (size_t)written;
        } else if (written == 0) {
            writer->error = EIO;
        } else if (errno != EINTR) {
            writer->error = errno;
        }
    }
    return writer->error;
}

static int flush_buffer(file_writer *writer) {
    size_t used = writer->used;
    writer->used = 0;
    return write_all(writer, writer->buffer, used);
}

int norma_file_writer_write(file_writer *writer, const void *bytes, size_t size) {
    if (writer->error || size == 0)
        return writer->error;
    if (size > BUFFER_SIZE - writer->used && flush_buffer(writer))
        return writer->error;
    if (size >= BUFFER_SIZE)
        return write_all(writer, bytes, size);
    memcpy(writer->buffer + writer->used, bytes, size);
    writer->used += size;
    return 0;
}

int norma_file_writer_prepare(file_writer *writer) {
    if (writer->error || flush_buffer(writer))
        return writer->error;
    if (writer->temporary && fsync(writer->descriptor))
        writer->error = errno;
    return writer->error;
}

/* The new name must survive a crash as well. A folder that cannot be opened or flushed, as on some file systems, is no reason to call the file unwritten. */
static int flush_folder(const char *target) {
    char *folder = join(target, folder_length(target), ".");
    if (!folder)
        return 0;
    int descriptor = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC), error = 0;
    free(folder);
    if (descriptor < 0)
        return 0;
    if (fsync(descriptor) && errno == EIO)
        error = EIO;
    close(descriptor);
    return error;
}

int norma_file_writer_commit(file_writer *writer) {
    int error = norma_file_writer_prepare(writer);
    if (!error) {
        int descriptor = writer->descriptor;
        writer->descriptor = -1;
        if (close(descriptor) && errno != EINTR)
            error = errno;
    }
    if (!error && writer->temporary) {
        if (rename(writer->temporary, writer->target))
            error = errno;
        else {
            free(writer->temporary);
            writer->temporary = NULL;
            error = flush_folder(writer->target);
        }
    }
    norma_file_writer_abandon(writer);
    return error;
}

void norma_file_writer_abandon(file_writer *writer) {
    if (!writer)
        return;
    if (writer->descriptor >= 0)
        close(writer->descriptor);
    if (writer->temporary)
        unlink(writer->temporary);
    free(writer->temporary);
    free(writer->target);
    free(writer);
}
