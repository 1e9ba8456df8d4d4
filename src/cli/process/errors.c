/* errors.c: what went wrong, in one line on standard error, and the exit status that follows. */
#include "cli/process/errors.h"
#include "cli/process/memory_limit.h"
#include "cli/text/outside_text.h"
#include <errno.h>
#include <string.h>

const char *cli_input_name(const char *input) {
    return strcmp(input, "-") ? input : "standard input";
}

int cli_out_of_memory(void) {
    char limit[CLI_LIMIT_ROOM];
    cli_memory_limit_words(limit);
    cli_error("out of memory%s", limit);
    return CLI_FILE;
}

int cli_status_of(norma_document_result result) {
    switch (result) {
    case NORMA_DOCUMENT_OK:
        return CLI_OK;
    case NORMA_DOCUMENT_ERROR_ARGUMENT:
        return CLI_USAGE;
    default:
        return CLI_FILE;
    }
}

int cli_worse(int status, int other) { return other > status ? other : status; }

/* For an error that came without a message: nothing ends in silence. */
static const char *plain_reason(norma_document_result result) {
    switch (result) {
    case NORMA_DOCUMENT_ERROR_MALFORMED:
        return "is malformed";
    case NORMA_DOCUMENT_ERROR_UNSUPPORTED:
        return "contains something that this version cannot read";
    case NORMA_DOCUMENT_ERROR_REFUSED:
        return "was refused";
    case NORMA_DOCUMENT_ERROR_MEMORY:
        return "out of memory";
    case NORMA_DOCUMENT_ERROR_ARGUMENT:
        return "does not contain the requested data";
    default:
        return "cannot be read or written";
    }
}

static const char reported[] = "reported already";

norma_document_result cli_reported(norma_document_error *error) {
    error->result = NORMA_DOCUMENT_ERROR_FILE;
    snprintf(error->message, sizeof error->message, "%s", reported);
    return error->result;
}

/* One wording for every place that can run out of memory; names the limit if one was set. */
static void name_limit(norma_document_error *error, const char *input) {
    char limit[CLI_LIMIT_ROOM];
    cli_memory_limit_words(limit);
    snprintf(error->message, sizeof error->message, "%.800s: out of memory%s",
        cli_input_name(input), limit);
}

void cli_name_error(norma_document_error *error, const char *input) {
    static const char nameless[] = "<memory>";
    char rest[sizeof error->message];
    if (error->result && !error->message[0])
        snprintf(error->message, sizeof error->message, "%.900s: %s", cli_input_name(input),
            plain_reason(error->result));
    if (error->result == NORMA_DOCUMENT_ERROR_MEMORY) name_limit(error, input);
    if (error->message[0] == ':') {
        strcpy(rest, error->message);
        snprintf(
            error->message, sizeof error->message, "%.400s%.400s", cli_input_name(input), rest);
    }
    if (strncmp(error->message, nameless, sizeof nameless - 1) != 0) return;
    strcpy(rest, error->message + sizeof nameless - 1);
    snprintf(error->message, sizeof error->message, "standard input%.900s", rest);
}

void cli_print_error(const norma_document_error *error) {
    if (strcmp(error->message, reported) != 0) cli_error("%s", error->message);
}

void cli_print_notes(const char *input, const norma_document *document) {
    const size_t most = 20;
    size_t count = norma_document_note_count(document);
    for (size_t i = 0; i < count && i < most; ++i)
        cli_error("%s: note: %s", cli_input_name(input), norma_document_note(document, i));
    if (count > most)
        cli_error(
            "%s: note: and %zu more; --json has them all", cli_input_name(input), count - most);
}

int cli_finish(int status) {
    if (fflush(stdout) == 0 && !ferror(stdout)) return status;
    cli_error("standard output: cannot be written: %s", strerror(errno));
    return cli_worse(status, CLI_FILE);
}
