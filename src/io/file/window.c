/* window.c: a file read piece by piece. Read, not mapped: what is read counts against memory only
 * as long as it is kept, and a file that another program cuts short is an error instead of a
 * signal. */
#define _POSIX_C_SOURCE 200809L
#include "io/file/window.h"
#include "io/file/file_stamp.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

struct file_window {
    int descriptor;
    file_stamp stamp;
};

static int look_at(file_window *window) {
    struct stat status;
    if (fstat(window->descriptor, &status)) return errno;
    if (S_ISDIR(status.st_mode)) return EISDIR;
    window->stamp = norma_file_stamp_of(&status);
    return S_ISREG(status.st_mode) ? 0 : FILE_NOT_REGULAR;
}

int norma_window_open(const char *path, file_window **window) {
    file_window *made = calloc(1, sizeof *made);
    *window = NULL;
    if (!made) return ENOMEM;
    do made->descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe would block */
    while (made->descriptor < 0 && errno == EINTR);
    const int error = made->descriptor < 0 ? errno : look_at(made);
    if (error)
        norma_window_close(made);
    else
        *window = made;
    return error;
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
    return !norma_file_stamps_equal(&now, &window->stamp);
}
