/* fix_file.h: norma check --fix: a document mended, judged again, and written where it was asked
 * for. */
#ifndef NORMA_CLI_CHECK_FIX_H
#define NORMA_CLI_CHECK_FIX_H
#include "cli/check/check_command.h"

typedef struct check_fixed {
    norma_document *document; /* as it is now; judged by findings */
    norma_findings *findings;
    int written;
    char *table; /* counts before and after, lines of text; NULL: nothing changed */
    norma_fix_summary summary;
    size_t
        first_note; /* of the document: what could not be fixed, and why, is noted from there on */
} check_fixed;

/* before: findings of document with options, which rules the report has. 0: error says why. */
norma_document_result check_fix(const check_settings *settings, norma_document *document,
    const norma_findings *before, const norma_check_options *options, size_t index,
    check_fixed *mended, norma_document_error *error);
void check_fixed_free(check_fixed *mended);
#endif
