/* no_system.c: a browser is no system. What wasi-libc would ask of its host answers that there is
 * none, so that the module needs no host. */
#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

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
