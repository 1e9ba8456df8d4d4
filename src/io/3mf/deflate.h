/* deflate.h: packing and unpacking of a zip's members. */
#ifndef NORMA_IO_3MF_DEFLATE_H
#define NORMA_IO_3MF_DEFLATE_H
#include <stddef.h>

typedef enum inflate_result { INFLATE_OK, INFLATE_NO_MEMORY, INFLATE_DAMAGED } inflate_result;

/* To exactly size bytes; damaged: the stream has more or fewer. */
inflate_result norma_inflate(const unsigned char *from, size_t packed, char *to, size_t size);
/* To be freed; NULL: there is no memory. size: at most INT32_MAX. */
unsigned char *norma_deflate(const unsigned char *from, size_t size, size_t *packed);
#endif
