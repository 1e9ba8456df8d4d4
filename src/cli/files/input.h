/* input.h: the files that a command names, and opening them. */
#ifndef NORMA_CLI_INPUT_H
#define NORMA_CLI_INPUT_H
#include "cli/files/guard.h"
#include "cli/options/options.h"
#include "cli/text/report_json.h"

typedef struct cli_inputs {
    char **paths;
    size_t *tails;  /* of each path: from which byte on it is kept below --out-dir */
    size_t *within; /* the same, relative to the folder given; 0 where none was */
    size_t count, capacity;
} cli_inputs;

typedef struct cli_files {
    cli_words words, lists; /* as given: files, folders, patterns; --files-from */
    cli_inputs inputs;      /* the files that these stand for */
    const char *output, *folder;
    int in_place;
    norma_file_format format; /* unknown: by each name */
    cli_guard *guard;         /* keeps what is read from being overwritten */
} cli_files;
extern const cli_option cli_input_options[]; /* --input-format */
extern const size_t cli_input_option_count;

/* Makes room for count words and the guard. 0: out of memory, reported. */
int cli_files_begin(const cli_subcommand *command, cli_files *files, int count);
void cli_files_end(cli_files *files);

/* Opens "-" or a path. *memory is what standard input held; freed after the document. */
norma_document_result cli_open(const cli_files *files, const char *input,
    const norma_document_options *options, norma_document **document, void **memory,
    norma_document_error *error);
double cli_megabytes(const char *input); /* 0: not known */
void cli_json_notes(cli_json *json, const norma_document *document);
#endif
