/* no_system.c: a browser has no files. What io asks of the system, and what wasi-libc would ask of
 * its host, answers that there is none: so that the module imports nothing. Compressed glTF buffers
 * are refused here, for want of their decoder. */
#include "io/file/file.h"
#include "io/gltf/read/asset.h"
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
int norma_file_writers_commit(file_writer **writers, size_t count, size_t *failed) {
    return (void)writers, (void)count, *failed = 0, ENOSYS;
}
void norma_file_writer_abandon(file_writer *writer) { (void)writer; }
int norma_folder_make(const char *path, int *made) { return (void)path, *made = 0, ENOSYS; }
int norma_folder_visit(const char *path, int (*visit)(void *user, const char *name), void *user) {
    return (void)path, (void)visit, (void)user, ENOSYS;
}
void norma_folder_remove(const char *path) { (void)path; }

int norma_gltf_reads_meshopt(void) { return 1; } /* the reason is given below, when one is met */

norma_document_result norma_gltf_decode_meshopt(
    gltf *g, uint32_t number, norma_document_error *error) {
    (void)number;
    return norma_document_fail(g->document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "compressed with EXT_meshopt_compression, which WebAssembly builds cannot read; the "
        "command line can");
}
unsigned char *norma_gltf_encode_meshopt(gltf_meshopt *m, const unsigned char *bytes) {
    return (void)m, (void)bytes, NULL;
}

/* ---- wasi-libc */

int stat(const char *restrict path, struct stat *restrict status) {
    return (void)path, (void)status, errno = ENOSYS, -1;
}
int lstat(const char *restrict path, struct stat *restrict status) { return stat(path, status); }
char *realpath(const char *restrict path, char *restrict resolved) {
    return (void)path, (void)resolved, errno = ENOSYS, NULL;
}

/* assert and the streams of the C library end here. */
_Noreturn void abort(void) { __builtin_trap(); }

_Noreturn void __imported_wasi_snapshot_preview1_proc_exit(int32_t status);
_Noreturn void __imported_wasi_snapshot_preview1_proc_exit(int32_t status) {
    (void)status;
    __builtin_trap();
}
int32_t __imported_wasi_snapshot_preview1_fd_close(int32_t file);
int32_t __imported_wasi_snapshot_preview1_fd_close(int32_t file) { return (void)file, ENOSYS; }
int32_t __imported_wasi_snapshot_preview1_fd_seek(
    int32_t file, int64_t offset, int32_t whence, int32_t at);
int32_t __imported_wasi_snapshot_preview1_fd_seek(
    int32_t file, int64_t offset, int32_t whence, int32_t at) {
    return (void)file, (void)offset, (void)whence, (void)at, ENOSYS;
}
int32_t __imported_wasi_snapshot_preview1_fd_write(
    int32_t file, int32_t vectors, int32_t count, int32_t written);
int32_t __imported_wasi_snapshot_preview1_fd_write(
    int32_t file, int32_t vectors, int32_t count, int32_t written) {
    return (void)file, (void)vectors, (void)count, (void)written, ENOSYS;
}
int32_t __imported_wasi_snapshot_preview1_fd_fdstat_get(int32_t file, int32_t at);
int32_t __imported_wasi_snapshot_preview1_fd_fdstat_get(int32_t file, int32_t at) {
    return (void)file, (void)at, ENOSYS;
}
