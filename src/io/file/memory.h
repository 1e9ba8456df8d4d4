/* memory.h: checked allocation, lists that grow, copies of texts. */
#ifndef NORMA_IO_FILE_MEMORY_H
#define NORMA_IO_FILE_MEMORY_H
#include <stddef.h>

/* Checked sizes: 0 where count * size overflows or memory is out. *block may be NULL before. */
void *norma_io_allocate(size_t count, size_t size); /* zeroed; never of zero bytes */
char *norma_io_copy_text(const char *text, size_t length);
char *norma_io_join(const char *folder, const char *name); /* folder: with its slash, or "" */
void *norma_io_grow(void *block, size_t *capacity, size_t needed,
    size_t size); /* doubles; NULL: out of memory, block untouched and still owned */

/* Bytes that grow; data is the caller's to free. */
typedef struct growing_bytes {
    char *data;
    size_t size, capacity;
    int failed; /* out of memory: further bytes are dropped */
} growing_bytes;
void norma_io_append(growing_bytes *to, const void *bytes, size_t size);
#endif
