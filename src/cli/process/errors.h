/* errors.h: exit statuses, and the one line on standard error that says what went wrong. */
#ifndef NORMA_CLI_ERRORS_H
#define NORMA_CLI_ERRORS_H
#include <norma/document.h>

enum cli_status {
    CLI_OK = 0,
    CLI_FINDINGS = 1,
    CLI_USAGE = 2,
    CLI_FILE = 3 /* a signal ends the process: 128 plus its number (progress.h) */
};
int cli_status_of(norma_document_result result);
int cli_worse(int status, int other); /* of a batch: 3, then 2, then 0 */

const char *cli_input_name(const char *input); /* for people: "standard input" for "-" */
/* Gives an error without words those of its kind, puts the input's name in front of words that
 * begin with a colon, and calls bytes without a name "standard input". */
void cli_name_error(norma_document_error *error, const char *input);
/* An error that was printed already: cli_print_error does not print it again. */
norma_document_result cli_reported(norma_document_error *error);
void cli_print_error(const norma_document_error *error);
void cli_print_notes(const char *input, const norma_document *document);
int cli_out_of_memory(void); /* prints that; CLI_FILE */
int cli_finish(int status);  /* flushes stdout; a full disk there is status 3 */
#endif
