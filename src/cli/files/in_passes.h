/* in_passes.h: files that do not fit into memory, changed piece by piece. */
#ifndef NORMA_CLI_IN_PASSES_H
#define NORMA_CLI_IN_PASSES_H
#include "cli/files/batch.h"

/* Whether this input can be read in passes, as only files of some size are; need: what it takes to
 * compute its normals at once. */
int cli_can_take_passes(const cli_files *files, const char *input, uint64_t *need);
/* Whether this input does not fit into the memory allowed, but can be read in passes. */
int cli_needs_passes(const cli_files *files, const char *input);
/* Changes it so. *size: bytes of the output. */
norma_document_result cli_change_in_passes(const cli_changer *changer, const cli_common *common,
    const cli_files *files, const char *input, const char *output, uint64_t *size,
    norma_document_error *error);
#endif
