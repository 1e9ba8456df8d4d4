/* large_memory.h: blocks that may be large. */
#ifndef NORMA_IO_MEMORY_H
#define NORMA_IO_MEMORY_H
#include <stddef.h>

/* A block of bytes, not zeroed, for free(); where it is large, on large pages if the system has
 * them, of which fewer are to be faulted in. What is never written takes no memory. NULL: out of
 * memory. */
void *norma_io_block(size_t count, size_t size);
/* As norma_io_block, with the first kept bytes of block, which is freed. NULL: out of memory, block
 * untouched and still owned. */
void *norma_io_move_block(void *block, size_t kept, size_t count, size_t size);
#endif
