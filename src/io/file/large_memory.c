/* large_memory.c: blocks that may be large. Arrays of a large mesh are written once from end to
 * end, and what that costs is mostly their pages. */
#define _DEFAULT_SOURCE /* madvise */
#include "io/file/large_memory.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif

enum { LARGE_BLOCK = 1 << 22 };

#if defined(__linux__)
static void *large_block(size_t bytes) {
    const size_t page = (size_t)1 << 21,
                 rounded = bytes > SIZE_MAX - page ? 0 : (bytes + page - 1) / page * page;
    void *block = rounded ? aligned_alloc(page, rounded) : NULL;
    /* A last page that would stay mostly empty is not worth its memory. */
    if (block) (void)madvise(block, (bytes + page / 2) / page * page, MADV_HUGEPAGE);
    return block;
}
#else
static void *large_block(size_t bytes) { return malloc(bytes); }
#endif

/* 0: more than there can be. */
static size_t bytes_of(size_t count, size_t size) {
    return count == 0 || size == 0 ? 1 : count > SIZE_MAX / size ? 0 : count * size;
}

void *norma_io_block(size_t count, size_t size) {
    const size_t bytes = bytes_of(count, size);
    if (!bytes) return NULL;
    return bytes >= LARGE_BLOCK ? large_block(bytes) : malloc(bytes);
}

void *norma_io_move_block(void *block, size_t kept, size_t count, size_t size) {
    void *moved = norma_io_block(count, size);
    if (!moved) return NULL;
    if (kept) memcpy(moved, block, kept);
    free(block);
    return moved;
}
