/* system_text.c: what an error number means, in the same words on every system and in every locale.
 * strerror would follow the program's locale. */
#include "io/file/system_text.h"
#include <errno.h>
#include <stddef.h>

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
