/* ordered.h: a file made piece by piece, by threads, and handed on in order. */
#ifndef NORMA_IO_ORDERED_H
#define NORMA_IO_ORDERED_H
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

/* Pieces are made by as many threads as norma_options means with this number, the calling one among
 * them, which alone calls write. No more of them wait than two for each thread. Refused: write
 * answered nonzero; then no more are made. */
norma_ordered_result norma_write_ordered(uint32_t threads, size_t count, norma_make_data_run *make,
    void *context, norma_write *write, void *user);
#endif
