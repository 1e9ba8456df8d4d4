/* sink.c: bytes on their way out, gathered into blocks before they are handed on, or kept. */
#include "io/stream/sink.h"
#include "io/file/memory.h"
#include <stdlib.h>

norma_sink *norma_sink_create(norma_write *write, void *user) {
    norma_sink *sink = malloc(sizeof *sink);
    unsigned char *block = malloc(SINK_BLOCK);
    if (!sink || !block) {
        free(sink);
        free(block);
        return NULL;
    }
    *sink = (norma_sink){.write = write, .user = user, .block = block, .capacity = SINK_BLOCK};
    return sink;
}

static void hand_on(norma_sink *sink, const void *bytes, size_t size) {
    if (!sink->failed && size > 0) sink->failed = sink->write(sink->user, bytes, size) != 0;
}

/* So that size bytes more fit behind those that are kept. Without memory what is there is dropped:
 * a block, if there is one, has room for SINK_BLOCK. */
static void keep_more(norma_sink *sink, size_t size) {
    unsigned char *grown = sink->used > SIZE_MAX / 4 - size
                               ? NULL
                               : norma_io_grow(sink->block, &sink->capacity, sink->used + size, 1);
    if (grown) {
        sink->block = grown;
        return;
    }
    sink->failed = 1;
    sink->used = 0;
}

void norma_sink_flush(norma_sink *sink) {
    if (!sink->write) {
        keep_more(sink, SINK_BLOCK);
        return;
    }
    hand_on(sink, sink->block, sink->used);
    sink->used = 0;
}

void norma_sink_put_slowly(norma_sink *sink, const void *bytes, size_t size) {
    if (!sink->write) {
        keep_more(sink, size);
        if (sink->failed) return;
    } else {
        norma_sink_flush(sink);
        if (size >= SINK_BLOCK / 2) {
            hand_on(sink, bytes, size);
            return;
        }
    }
    memcpy(sink->block + sink->used, bytes, size);
    sink->used += size;
}

int norma_sink_finish(norma_sink *sink) {
    norma_sink_flush(sink);
    int failed = sink->failed;
    free(sink->block);
    free(sink);
    return failed;
}

int norma_memory_sink_write(void *growing, const void *bytes, size_t size) {
    norma_io_append(growing, bytes, size);
    return ((const growing_bytes *)growing)->failed;
}

int norma_compare_sink_write(void *compare_sink, const void *bytes, size_t size) {
    norma_compare_sink *sink = compare_sink;
    if (size > sink->left || memcmp(sink->expected, bytes, size) != 0) return 1;
    sink->expected += size;
    sink->left -= size;
    return 0;
}
