/* deflate.c: the streams of RFC 1951, through zlib. */
#include "io/3mf/deflate.h"
#include <stdint.h>
#include <stdlib.h>
#include <zlib.h>

inflate_result norma_inflate(const unsigned char *from, size_t packed, char *to, size_t size) {
    z_stream z = {.next_in = (unsigned char *)(uintptr_t)from, .next_out = (unsigned char *)to};
    int status = inflateInit2(&z, -MAX_WBITS);
    if (status != Z_OK) return INFLATE_NO_MEMORY;
    while (status == Z_OK) { /* zlib counts in 32 bits */
        const size_t in = packed < UINT32_MAX ? packed : UINT32_MAX,
                     out = size < UINT32_MAX ? size : UINT32_MAX;
        z.avail_in = (unsigned)in;
        z.avail_out = (unsigned)out;
        status = inflate(&z, Z_NO_FLUSH);
        packed -= in - z.avail_in;
        size -= out - z.avail_out;
    }
    inflateEnd(&z);
    return status == Z_STREAM_END && size == 0 ? INFLATE_OK
           : status == Z_MEM_ERROR             ? INFLATE_NO_MEMORY
                                               : INFLATE_DAMAGED;
}

unsigned char *norma_deflate(const unsigned char *from, size_t size, size_t *packed) {
    const uLong bound = compressBound((uLong)size) + 64;
    unsigned char *out = malloc(bound);
    z_stream z = {.next_in = (unsigned char *)(uintptr_t)from,
        .avail_in = (unsigned)size,
        .next_out = out,
        .avail_out = (unsigned)bound};
    if (!out || deflateInit2(&z, Z_DEFAULT_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8,
                    Z_DEFAULT_STRATEGY) != Z_OK) {
        free(out);
        return NULL;
    }
    const int status = deflate(&z, Z_FINISH);
    *packed = z.total_out;
    deflateEnd(&z);
    if (status == Z_STREAM_END) return out;
    free(out);
    return NULL;
}
