/* accountant.h: an allocator that counts its blocks, fills them with what is no number that anybody
 * wrote, refuses one of them if asked, and notices a block that comes back with another size. */
#ifndef NORMA_TEST_ACCOUNTANT_H
#define NORMA_TEST_ACCOUNTANT_H
#include <stdlib.h>
#include <string.h>

typedef struct accountant {
    size_t calls, fail_at, live; /* fail_at 1: the first; 0: none */
    int wrong;                   /* a block came back with another size */
} accountant;

enum { BEFORE_BLOCK = 64 }; /* bytes in which its size is kept */

static inline void *accountant_take(void *user, size_t size, size_t alignment) {
    accountant *a = user;
    (void)alignment;
    if (++a->calls == a->fail_at) return NULL;
    ++a->live;
    unsigned char *block = malloc(size + BEFORE_BLOCK);
    memset(block, 0xA5, size + BEFORE_BLOCK);
    memcpy(block, &size, sizeof size);
    return block + BEFORE_BLOCK;
}

static inline void accountant_give(void *user, void *block, size_t size) {
    accountant *a = user;
    if (!block) return;
    unsigned char *start = (unsigned char *)block - BEFORE_BLOCK;
    a->wrong |= memcmp(start, &size, sizeof size) != 0;
    --a->live;
    free(start);
}
#endif
