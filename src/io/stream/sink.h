/* sink.h: bytes on their way out, gathered into blocks before they are handed on; or kept, all of
 * them, for someone else to hand on. */
#ifndef NORMA_IO_SINK_H
#define NORMA_IO_SINK_H
#include <norma/document.h>
#include <string.h>

enum { SINK_BLOCK = 1 << 16 };

typedef struct norma_sink {
    norma_write *write; /* NULL: all is kept in block, which grows */
    void *user;
    int failed; /* write answered nonzero, or memory is out: all that follows is dropped */
    size_t used, capacity;
    unsigned char *block;
} norma_sink;

/* NULL: out of memory. */
norma_sink *norma_sink_create(norma_write *write, void *user);
/* Hands on what is gathered; a sink that keeps its bytes makes room for a block more. */
void norma_sink_flush(norma_sink *sink);
/* Flushes and frees; nonzero where write answered so at any time. */
int norma_sink_finish(norma_sink *sink);
/* For what does not fit into the block any more. */
void norma_sink_put_slowly(norma_sink *sink, const void *bytes, size_t size);

static inline void norma_sink_put(norma_sink *sink, const void *bytes, size_t size) {
    if (size > sink->capacity - sink->used) {
        norma_sink_put_slowly(sink, bytes, size);
        return;
    }
    memcpy(sink->block + sink->used, bytes, size);
    sink->used += size;
}

/* Room for size bytes (at most SINK_BLOCK) that the caller fills before the next call. */
static inline unsigned char *norma_sink_room(norma_sink *sink, size_t size) {
    if (size > sink->capacity - sink->used) norma_sink_flush(sink);
    unsigned char *room = sink->block + sink->used;
    sink->used += size;
    return room;
}

/* A norma_write that appends to growing_bytes (io/file/memory.h). Answers nonzero if memory is out.
 */
int norma_memory_sink_write(void *growing, const void *bytes, size_t size);

/* A norma_write that answers nonzero at the first byte that is not the one expected; left: expected
 * and not yet seen. */
typedef struct norma_compare_sink {
    const unsigned char *expected;
    size_t left;
} norma_compare_sink;
int norma_compare_sink_write(void *compare_sink, const void *bytes, size_t size);
#endif
