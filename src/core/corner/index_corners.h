/* index_corners.h: an indexed mesh out of values per corner, for calls that make some of them. */
#ifndef NORMA_CORE_INDEX_CORNERS_H
#define NORMA_CORE_INDEX_CORNERS_H
#include "core/call/call.h"

norma_result norma_core_check_indexed(const norma_indexed *indexed);
norma_result norma_core_check_streams(
    const norma_stream *streams, size_t stream_count, size_t corner_count, norma_fault *fault);

/* Of checked streams. CAPACITY, OVERFLOW, MEMORY and CANCELLED leave everything as it was. */
norma_result norma_core_index_corners(core_call *call, const norma_stream *streams,
    size_t stream_count, size_t corner_count, norma_indexed *to);
#endif
