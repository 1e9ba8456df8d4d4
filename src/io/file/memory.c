/* memory.c: checked allocation, lists and texts that grow, copies of texts. */
#include "io/file/memory.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void *norma_io_allocate(size_t count, size_t size) {
    if (size && count > SIZE_MAX / size) return NULL;
    return calloc(count ? count : 1, size ? size : 1);
}

char *norma_io_copy_text(const char *text, size_t length) {
    char *copy = norma_io_allocate(length + 1, 1);
    if (copy) memcpy(copy, text, length);
    return copy;
}

char *norma_io_join(const char *folder, const char *name) {
    const size_t a = strlen(folder), b = strlen(name);
    char *joined = norma_io_allocate(a + b + 1, 1);
    if (!joined) return NULL;
    memcpy(joined, folder, a);
    memcpy(joined + a, name, b);
    return joined;
}

void *norma_io_grow(void *block, size_t *capacity, size_t needed, size_t size) {
    if (block && needed <= *capacity) return block;
    size_t larger = *capacity > SIZE_MAX / 2 ? needed : *capacity * 2;
    if (larger < needed) larger = needed;
    if (larger < 16) larger = 16;
    if (size && larger > SIZE_MAX / size) return NULL;
    void *grown = realloc(block, larger * (size ? size : 1));
    if (grown) *capacity = larger;
    return grown;
}

void norma_io_append(growing_bytes *to, const void *bytes, size_t size) {
    if (to->failed || size == 0) return;
    if (size > to->capacity - to->size) {
        char *grown = size > SIZE_MAX - to->size
                          ? NULL
                          : norma_io_grow(to->data, &to->capacity, to->size + size, 1);
        to->failed = !grown;
        if (!grown) return;
        to->data = grown;
    }
    memcpy(to->data + to->size, bytes, size);
    to->size += size;
}
