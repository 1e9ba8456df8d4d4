/* sink.c: bytes on their way out, gathered into blocks before they are handed on. */
#include "sink.h"
#include "document_internal.h"
#include <stdlib.h>

norma_sink *norma_sink_create(norma_write *write, void *user)
{
    norma_sink *sink = malloc(sizeof *sink);
    if (!sink)
        return NULL;
    sink->write = write;
    sink->user = user;
    sink->failed = 0;
    sink->used = 0;
    return sink;
}

static void hand_on(norma_sink *sink, const void *bytes, size_t size)
{
    if (!sink->failed && size > 0)
        sink->failed = sink->write(sink->user, bytes, size) != 0;
}

void norma_sink_flush(norma_sink *sink)
{
    hand_on(sink, sink->block, sink->used);
    sink->used = 0;
}

void norma_sink_put_slowly(norma_sink *sink, const void *bytes, size_t size)
{
    norma_sink_flush(sink);
    if (size >= SINK_BLOCK / 2) {
        hand_on(sink, bytes, size);
        return;
    }
    memcpy(sink->block, bytes, size);
    sink->used = size;
}

int norma_sink_finish(norma_sink *sink)
{
    norma_sink_flush(sink);
    int failed = sink->failed;
    free(sink);
    return failed;
}

int norma_memory_sink_write(void *memory_sink, const void *bytes, size_t size)
{
    norma_memory_sink *sink = memory_sink;
    if (size > SIZE_MAX - sink->size)
        return 1;
    unsigned char *grown = norma_io_grow(sink->bytes, &sink->capacity, sink->size + size, 1);
    if (!grown)
        return 1;
    sink->bytes = grown;
    memcpy(grown + sink->size, bytes, size);
    sink->size += size;
    return 0;
}

int norma_compare_sink_write(void *compare_sink, const void *bytes, size_t size)
{
    norma_compare_sink *sink = compare_sink;
    if (size > sink->left || memcmp(sink->expected, bytes, size) != 0)
        return 1;
    sink->expected += size;
    sink->left -= size;
    return 0;
}
