/* batch.h: commands that change files: each is opened, changed and written, and a line says so. */
#ifndef NORMA_CLI_BATCH_H
#define NORMA_CLI_BATCH_H
#include "cli/files/input.h"
#include <norma/large.h>
#include <stdio.h>

#define CLI_FILES_HELP                                                                             \
    "Files\n"                                                                                      \
    "  IN                    a file, a folder, or a pattern in quotes\n"                           \
    "  -o, --output OUT      the output, in IN's format; - is standard output\n"                   \
    "  --out-dir FOLDER      the folder for several outputs; keeps the tree of an input folder\n"  \
    "  --in-place            replaces each input file; a failure leaves it as it was\n"            \
    "  --input-format obj|ply|stl|gltf|glb\n"                                                      \
    "                        the format of standard input; needed if IN is -\n"                    \
    "  --threads N           uses at most N threads (all processors), with the same result\n"      \
    "  --max-memory SIZE     uses at most SIZE (512M, 2G). compute reads larger binary PLY and\n"  \
    "                        STL in passes; other files that need more fail\n"                     \
    "  --json                prints a summary as JSON, one object per line\n"                      \
    "  --quiet               prints only errors\n"
extern const cli_option cli_output_options[]; /* -o --out-dir --in-place */
extern const size_t cli_output_option_count;

typedef struct cli_changer cli_changer;

/* A batch whose files are changed all at once. */
typedef struct cli_all_files {
    const cli_subcommand *command;
    const cli_common *common;
    const cli_files *files;
    const cli_changer *changer;
} cli_all_files;

/* What a command does to each file of a batch. */
struct cli_changer {
    void *work; /* the command's own: its options, and the summary of the file at hand */
    norma_document_result (*change)(void *work, norma_document *document, norma_progress *progress,
        void *progress_user, norma_document_error *error);
    void (*write_json)(const void *work, cli_json *json); /* the keys after "input" and "output" */
    /* What stands after "IN -> OUT: ", without the line's end. document: NULL after passes. */
    void (*write_text)(const void *work, const norma_document *document, FILE *out);
    /* NULL, or the same from file to file, in parts that fit into the memory allowed. */
    norma_document_result (*in_passes)(void *work, const char *input, const char *output,
        const norma_large_options *options, norma_progress *progress, void *progress_user,
        norma_document_error *error);
    /* Once all options are read: a status. */
    int (*prepare)(const cli_subcommand *command, void *work, uint32_t threads);
    /* NULL, or all files at once, where takes_all says so after prepare. A status. */
    int (*all)(const cli_all_files *all, const cli_changer *changer);
    int (*takes_all)(const void *work);
};

/* Such a command as a whole, from its arguments to its status; tables: its own options beside those
 * that all of them take. */
enum { CLI_OWN_TABLES = 2 };
int cli_run_changer(const cli_subcommand *command, const cli_changer *changer,
    const cli_table *tables, size_t table_count, int count, char **arguments);

/* Whether all have somewhere to go, each its own place; makes --out-dir. A status. */
int cli_check_outputs(const cli_subcommand *command, const cli_common *common, cli_files *files);
/* Whether no output is a source, as far as the inputs' names say. A status. */
int cli_guard_outputs(const cli_files *files);
/* The line, or the JSON object, about a file of a batch that was changed as a whole, by what
 * changer->work holds of it; before, after: its bytes, those of the files that it names among them,
 * 0 where they are not known. And for programs, of one that was not changed. */
void cli_report_grown(
    const cli_all_files *all, const char *input, const char *output, double before, double after);
void cli_report_changed(const cli_all_files *all, const char *input, const char *output,
    const norma_document_error *error);
/* To standard output. */
norma_document_result cli_write_standard(norma_document *document, norma_document_error *error);
#endif
