/* deflate_elsewhere.c: the streams of a zip are packed and unpacked by npm's fflate, which
 * JavaScript loads when the first is met (web/package/decoders.js). */
#include "io/3mf/3mf.h"
#include <stdlib.h>

#define FROM_JAVASCRIPT(name) __attribute__((import_module("norma"), import_name(#name))) name

inflate_result FROM_JAVASCRIPT(inflate_bytes)(
    const unsigned char *from, size_t packed, char *to, size_t size);
size_t FROM_JAVASCRIPT(deflate_bytes)(
    const unsigned char *from, size_t size, unsigned char *out, size_t room);

inflate_result norma_inflate(const unsigned char *from, size_t packed, char *to, size_t size) {
    return inflate_bytes(from, packed, to, size);
}

/* What does not pack is stored, in blocks with heads of a few bytes. */
unsigned char *norma_deflate(const unsigned char *from, size_t size, size_t *packed) {
    const size_t room = size + size / 16 + 1024;
    unsigned char *out = malloc(room);
    *packed = out ? deflate_bytes(from, size, out, room) : 0;
    if (*packed) return out;
    free(out);
    return NULL;
}
