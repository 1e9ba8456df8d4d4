/* no_system.c: a browser is no system. What wasi-libc would ask of its host answers that there is
 * none, so that the module imports nothing. Compressed glTF buffers and meshes are refused here,
 * for want of their decoders. */
#include "io/gltf/read/asset.h"
#include "io/gltf/read/draco_decoder.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

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

int norma_draco_reads(void) { return 0; }

#define DRACO_WHERE                                                                                \
    "WebAssembly builds cannot read; the command line can, and gltf-transform copy unpacks it"
const char *norma_draco_missing(int of_primitive) {
    return of_primitive ? "compressed with KHR_draco_mesh_compression, which " DRACO_WHERE
                        : DRACO_WHERE;
}

draco_result norma_draco_decode(const draco_stream *stream, size_t *found) {
    return (void)stream, *found = 0, DRACO_KIND;
}

/* ---- wasi-libc */

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
