/* no_files.c: a module without files: what io asks of the system answers that there are none. For
 * check.wasm; the page has memory_files.c. */
#include "io/file/file.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

int norma_file_open(const char *path, const file_reading *how, file_bytes *bytes) {
    (void)path;
    (void)how;
    *bytes = (file_bytes){0};
    return ENOSYS;
}
void norma_file_close(file_bytes *bytes) { *bytes = (file_bytes){0}; }
int norma_file_has_changed(const char *path, const file_stamp *stamp) {
    return (void)path, (void)stamp, 0;
}
int norma_file_same(const char *a, const char *b) { return strcmp(a, b) == 0; }
int norma_file_is_stream(const char *path) { return (void)path, 0; }
int norma_file_is_regular(const char *path) { return (void)path, 0; }
int norma_file_is_link(const char *path) { return (void)path, 0; }
int norma_file_is_unchanged(const char *path, const file_stamp *stamp) {
    return (void)path, (void)stamp, 1;
}
int norma_file_writer_open(const char *path, file_writer **writer) {
    return (void)path, *writer = NULL, ENOSYS;
}
int norma_file_writer_write(file_writer *writer, const void *bytes, size_t size) {
    return (void)writer, (void)bytes, (void)size, ENOSYS;
}
int norma_file_writer_prepare(file_writer *writer) { return (void)writer, ENOSYS; }
void norma_file_writer_expect(file_writer *writer, file_stamp *stamp) { (void)writer, (void)stamp; }
void norma_file_writer_batch(file_writer *writer, int alone) { (void)writer, (void)alone; }
void norma_file_writer_expect_once(file_writer *writer, const file_stamp *stamp) {
    (void)writer, (void)stamp;
}
int norma_file_writers_commit(file_writer **writers, size_t count, size_t *failed) {
    return (void)writers, (void)count, *failed = 0, ENOSYS;
}
void norma_file_writer_abandon(file_writer *writer) { (void)writer; }
int norma_folder_make(const char *path, int *made) { return (void)path, *made = 0, ENOSYS; }
int norma_folder_visit(const char *path, int (*visit)(void *user, const char *name), void *user) {
    return (void)path, (void)visit, (void)user, ENOSYS;
}
void norma_folder_remove(const char *path) { (void)path; }

int stat(const char *restrict path, struct stat *restrict status) {
    return (void)path, (void)status, errno = ENOSYS, -1;
}
int lstat(const char *restrict path, struct stat *restrict status) { return stat(path, status); }
char *realpath(const char *restrict path, char *restrict resolved) {
    return (void)path, (void)resolved, errno = ENOSYS, NULL;
}
