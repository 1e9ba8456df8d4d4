/* compare.h: norma compare. */
#ifndef NORMA_CLI_COMPARE_COMPARE_H
#define NORMA_CLI_COMPARE_COMPARE_H
#include "cli/files/files.h"

/* What normals may differ by: --max and --share. */
enum { COMPARE_MAX = 1, COMPARE_SHARE = 2 };

typedef struct compare_limits {
    double max_rad, share;
    int given; /* COMPARE_... */
} compare_limits;
extern const cli_option compare_limit_options[];
extern const size_t compare_limit_option_count;

/* Compares names[1] with names[0] and writes lines of text, or common->json an object, to out. A
 * status: CLI_FINDINGS beyond the limits; else error says why nothing could be compared, and only
 * JSON is written. */
int compare_pair(const cli_files *files, const cli_common *common, const compare_limits *limits,
    const char *const names[2], FILE *out, norma_document_error *error);
#endif
