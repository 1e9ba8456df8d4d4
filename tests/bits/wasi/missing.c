/* missing.c: POSIX that WASI has not. The driver only reads files, from a folder that its host has
 * opened for it and that it cannot leave. */
#include <stdlib.h>
#include <string.h>
#include "missing.h"

/* From the root, which is the working folder; without a slash at its end. No links are followed:
 * WASI itself refuses those that lead out. */
char *realpath(const char *restrict path, char *restrict resolved) {
    size_t length = strlen(path), at = 0;
    char *out = resolved ? resolved : malloc(length + 2);
    if (!out) return NULL;
    while (path[0] == '.' && (path[1] == '/' || path[1] == '\0')) path += path[1] ? 2 : 1;
    if (*path != '/') out[at++] = '/';
    length = strlen(path);
    memcpy(out + at, path, length + 1);
    for (length += at; length > 1 && out[length - 1] == '/';) out[--length] = '\0';
    return out;
}
int fchown(int descriptor, unsigned owner, unsigned group) {
    return (void)descriptor, (void)owner, (void)group, 0;
}
int fchmod(int descriptor, unsigned mode) { return (void)descriptor, (void)mode, 0; }
int madvise(void *address, unsigned long size, int advice) {
    return (void)address, (void)size, (void)advice, 0;
}
int dup(int descriptor) { return (void)descriptor, -1; }
