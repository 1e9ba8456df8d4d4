/* stl_blocks.c: a binary STL read block by block. */
#include "io/large/stl_blocks.h"

norma_document_result norma_large_stl_open(large_file *file, large_stl *stl) {
    stl_state *state = file->document->state = norma_io_allocate(1, sizeof *state);
    *stl = (large_stl){.file = file, .state = state};
    stl->block = norma_large_take(&file->budget, 1, sizeof *stl->block);
    if (!state || !stl->block) return norma_large_fail_memory(file);
    file->document->functions = &norma_stl_functions;
    state->bytes = file->document->source.data;
    state->size = (size_t)file->size;
    state->binary = 1;
    if (file->size >= STL_HEADER && !norma_stl_is_binary(state))
        return norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            NULL,
            "does not fit into the memory allowed, and an ASCII STL is read whole; allow more "
            "memory");
    const norma_document_result result = norma_stl_read_binary(file->document, file->error);
    stl->facets = state->facets;
    state->bytes = stl->block->bytes;
    return result;
}

void norma_large_stl_close(large_stl *stl) {
    if (!stl->file) return;
    norma_large_give(&stl->file->budget, stl->block, 1, sizeof *stl->block);
    if (stl->state) stl->state->bytes = stl->file->document->source.data;
}

norma_document_result norma_large_stl_read(large_stl *stl, size_t first, size_t count) {
    return norma_large_read(stl->file, STL_HEADER + (uint64_t)first * STL_FACET,
        stl->block->bytes + STL_HEADER, count * STL_FACET);
}

void norma_large_stl_positions(const large_stl *stl, size_t count) {
    for (size_t i = 0; i < count; ++i)
        norma_stl_load(stl->state, i, NULL, stl->block->positions + 9 * i);
}
