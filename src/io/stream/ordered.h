/* ordered.h: a file made piece by piece, by threads, and handed on in order. */
#ifndef NORMA_IO_ORDERED_H
#define NORMA_IO_ORDERED_H
#include "io/file/watch.h"
#include "io/stream/sink.h"

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
#endif
