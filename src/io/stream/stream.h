/* stream.h: bytes on their way out, and work that threads share. */
#ifndef NORMA_IO_STREAM_H
#define NORMA_IO_STREAM_H
#include <norma/norma.h>
#include <norma/document.h>
#include <string.h>
#include "io/file/file.h"
#include <stddef.h>
#include <stdint.h>

/* ---- Work of the formats that threads share. */

/* Runs task for each index below count, with the threads and the progress of the core's options,
 * which may cancel. Tasks share nothing but what they only read. */
norma_result norma_io_tasks_told(
    const norma_options *options, size_t count, norma_task *task, void *context);

/* ---- Bytes on their way out, gathered into blocks before they are handed on; or kept, all of
 * them, for someone else to hand on. */

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

/* A norma_write that appends to growing_bytes (io/file/file.h). Answers nonzero if memory is out.
 */
int norma_memory_sink_write(void *growing, const void *bytes, size_t size);

/* A norma_write that answers nonzero at the first byte that is not the one expected; left: expected
 * and not yet seen. */
typedef struct norma_compare_sink {
    const unsigned char *expected;
    size_t left;
} norma_compare_sink;
int norma_compare_sink_write(void *compare_sink, const void *bytes, size_t size);

/* ---- A file made piece by piece, by threads, and handed on in order. */

/* One piece: what make puts into sink, then span, bytes that stay where they are until they are
 * handed on. */
typedef struct norma_data_run {
    norma_sink sink; /* keeps its bytes */
    const void *span;
    size_t span_size;
} norma_data_run;

/* Makes the piece of this number. Called by any thread, for different pieces at once. A sink that
 * failed is memory that is out. */
typedef void norma_make_data_run(void *context, size_t index, norma_data_run *piece);

typedef enum norma_ordered_result {
    NORMA_ORDERED_OK = 0,
    NORMA_ORDERED_REFUSED,
    NORMA_ORDERED_MEMORY
} norma_ordered_result;

/* How: by as many threads as norma_options means with this number, the calling one among them,
 * which alone calls write. watch: NULL, or asked while it waits; what makes a piece of a size that
 * is not bounded should ask it, too. */
typedef struct norma_ordered_how {
    uint32_t threads;
    norma_watch *watch;
} norma_ordered_how;

/* Makes and hands on count pieces. No more of them wait than two for each thread. Refused: write
 * answered nonzero, or it is cancelled; then no more are made. */
norma_ordered_result norma_write_ordered(norma_ordered_how how, size_t count,
    norma_make_data_run *make, void *context, norma_write *write, void *user);

/* ---- Texts, each once, numbered in the order of their first use. */

typedef struct norma_names {
    char **list;
    size_t count, room;
    uint32_t *slots; /* a hash table of their numbers (core/call/table.h) */
    size_t slot_count;
} norma_names;

/* The number of a text; UINT32_MAX: out of memory. */
uint32_t norma_names_number(norma_names *names, const char *text, size_t length);
void norma_names_free(norma_names *names);

/* ---- Of rows of bytes, which equal one before them. */

typedef const unsigned char *norma_row_of(const void *context, size_t row, size_t *length);
/* first: of each row the first that has the same bytes. 0: out of memory. Expected linear time. */
int norma_equal_rows(norma_row_of *row_of, const void *context, size_t count, uint32_t *first);
/* numbers: of each row that of its bytes, in the order of their first rows; distinct: how many. */
int norma_number_rows(
    norma_row_of *row_of, const void *context, size_t count, uint32_t *numbers, size_t *distinct);
#endif
