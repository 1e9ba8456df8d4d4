/* describe_large.h: what is in a file that does not fit into memory. */
#ifndef NORMA_CLI_INFO_DESCRIBE_LARGE_H
#define NORMA_CLI_INFO_DESCRIBE_LARGE_H
#include "cli/info/bounds.h"
#include "cli/process/progress.h"

norma_document_result info_describe_large(const char *path, norma_file_format *format,
    cli_progress *progress, norma_mesh_info *info, info_bounds *bounds,
    norma_document_error *error);
#endif
