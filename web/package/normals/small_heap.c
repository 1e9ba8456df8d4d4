/* small_heap.c: malloc and free of norma-mesh/normals, a tenth of wasi-libc's: free blocks in a
 * list by address, the first that is large enough is taken, neighbours become one (Knuth, volume 1,
 * 2.5). A call of the library asks for some dozen blocks, so the list stays short. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

enum { PAGE = 65536, HEAD = 16 }; /* HEAD: before each block, and what all sizes are multiples of */

typedef struct block {
    size_t size; /* with its head */
    struct block *next;
} block;
_Static_assert(sizeof(block) <= HEAD, "a head holds it");

extern unsigned char __heap_base; /* of the linker: where the heap begins */
static block *first_free;
static uintptr_t top; /* all from here on was never handed out */

static void *taken(block *b) { return (unsigned char *)b + HEAD; }

static void *take_from_list(size_t size) {
    for (block **at = &first_free; *at; at = &(*at)->next) {
        block *b = *at;
        if (b->size < size) continue;
        if (b->size == size) {
            *at = b->next;
        } else {
            block *rest = (block *)(void *)((unsigned char *)b + size);
            *rest = (block){b->size - size, b->next};
            *at = rest;
            b->size = size;
        }
        return taken(b);
    }
    return NULL;
}

static void *take_from_top(size_t size) {
    if (!top) top = ((uintptr_t)&__heap_base + HEAD - 1) & ~(uintptr_t)(HEAD - 1);
    const size_t room = __builtin_wasm_memory_size(0) * PAGE - top,
                 pages = size > room ? (size - room + PAGE - 1) / PAGE : 0;
    if (pages && __builtin_wasm_memory_grow(0, pages) == SIZE_MAX) return NULL;
    block *b = (block *)top; // NOLINT(performance-no-int-to-ptr)
    b->size = size;
    top += size;
    return taken(b);
}

void *malloc(size_t bytes) {
    if (bytes > SIZE_MAX - 2 * PAGE) return NULL;
    const size_t size = (bytes + 2 * HEAD - 1) & ~(size_t)(HEAD - 1);
    void *found = take_from_list(size);
    return found ? found : take_from_top(size);
}

static int touches_next(const block *b) {
    return b->next && (const unsigned char *)b + b->size == (const unsigned char *)b->next;
}

static void join_next(block *b) {
    b->size += b->next->size;
    b->next = b->next->next;
}

void free(void *pointer) {
    if (!pointer) return;
    block *b = (block *)(void *)((unsigned char *)pointer - HEAD), *before = NULL;
    block **at = &first_free;
    for (; *at && *at < b; at = &(*at)->next) before = *at;
    b->next = *at;
    *at = b;
    if (touches_next(b)) join_next(b);
    if (before && touches_next(before)) join_next(before);
}

/* What wasi-libc's cos asks for where an angle is beyond a million turns, and 2 kB long: creases
 * are half a turn at most, so nothing comes here. */
int __rem_pio2_large(double *x, double *y, int exponent, int count, int precision);
int __rem_pio2_large(double *x, double *y, int exponent, int count, int precision) {
    (void)x, (void)y, (void)exponent, (void)count, (void)precision;
    __builtin_trap();
}
