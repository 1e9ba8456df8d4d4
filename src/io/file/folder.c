/* folder.c: the folders that files go to: opened and flushed, so that names in them survive a
 * crash, made where they are missing, and taken away again. */
#define _POSIX_C_SOURCE 200809L
#include "io/file/file.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int norma_folder_open(const char *path, int *descriptor) {
    do *descriptor = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    while (*descriptor < 0 && errno == EINTR);
    return *descriptor < 0 && errno != EACCES && errno != EPERM ? errno : 0;
}

int norma_folder_flush(int descriptor) {
    int failed;
    do failed = fsync(descriptor);
    while (failed && errno == EINTR);
    const int error = failed ? errno : 0;
    return error == EINVAL || error == EBADF || error == ENOTSUP || error == EROFS ? 0 : error;
}

/* What path lies in. */
static int flush_parent(const char *path) {
    const char *slash = strrchr(path, '/');
    const size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    char *parent = malloc(length + 2);
    int descriptor = -1;
    if (!parent) return ENOMEM;
    memcpy(parent, path, length);
    memcpy(parent + length, ".", 2);
    int error = norma_folder_open(parent, &descriptor);
    free(parent);
    if (descriptor >= 0) {
        error = norma_folder_flush(descriptor);
        close(descriptor);
    }
    return error;
}

int norma_folder_make(const char *path, int *made) {
    *made = mkdir(path, 0777) == 0;
    if (!*made) return errno == EEXIST ? 0 : errno;
    const int error = flush_parent(path);
    if (error) {
        norma_folder_remove(path);
        *made = 0;
    }
    return error;
}

int norma_folder_visit(const char *path, int (*visit)(void *user, const char *name), void *user) {
    DIR *folder = opendir(path);
    const struct dirent *entry;
    if (!folder) return errno;
    errno = 0;
    while ((entry = readdir(folder)) && !visit(user, entry->d_name)) errno = 0;
    const int error = entry ? 0 : errno;
    closedir(folder);
    return error;
}

void norma_folder_remove(const char *path) { rmdir(path); }
