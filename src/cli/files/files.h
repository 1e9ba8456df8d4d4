/* files.h: the files that a command names, where outputs go, and work on many of them. */
#ifndef NORMA_CLI_FILES_FILES_H
#define NORMA_CLI_FILES_FILES_H
#include "cli/options/options.h"
#include "cli/process/process.h"
#include <norma/large.h>

/* ---- Sources are never outputs. Every file that a command reads (meshes, buffers, lists,
 * baselines, configurations) and every file that those name (images, material libraries) is put on
 * one list; every output is compared with it before it is written. Files are told apart by device
 * and inode, so that links and other spellings of a name count as the file. */

struct cli_subcommand;
typedef struct cli_guard cli_guard;

/* A file that is read; "-" is standard input. Safe in any thread, as are all of these. */
void cli_guard_read(cli_guard *guard, const char *path);
/* The files that a glTF names, whose buffers are not read; nothing where it cannot be opened, or no
 * output exists already. Where memory is too short for that, nothing that exists is written any
 * more. */
void cli_guard_names(cli_guard *guard, const char *path, norma_file_format format);
int cli_guard_watches(const cli_guard *guard); /* an output exists already */

/* What was read and named in a worker (process.h), through its channel: *first is behind what was
 * sent before. 0: the worker has ended. */
struct cli_worker;
size_t cli_guard_count(cli_guard *guard);
void cli_guard_send(cli_guard *guard, size_t *first, const struct cli_worker *worker);
int cli_guard_receive(cli_guard *guard, const struct cli_worker *worker);

/* Called for every output before the work, when the inputs are known, and again just before it is
 * written. own: the input that it replaces in place, else NULL. CLI_OK, or the status of the error
 * that was reported. */
int cli_guard_output(cli_guard *guard, const char *output, const char *own);

/* Whether the second of two outputs would replace the first, however they are spelt. */
int cli_is_same_output(const char *a, const char *b);

/* ---- The files that a command names, and opening them. */

typedef struct cli_input {
    char *path;
    size_t tail;   /* from which byte on it is kept below --out-dir */
    size_t within; /* the same, relative to the folder given; 0 where none was */
    size_t number; /* in the order in which they were found */
} cli_input;

typedef struct cli_inputs {
    cli_input *list;
    size_t count, capacity;
    const char *moved; /* a tileset whose tiles have transforms; NULL: none was given */
} cli_inputs;

typedef struct cli_files {
    cli_words words, lists; /* as given: files, folders, patterns; --files-from */
    cli_inputs inputs;      /* the files that these stand for */
    const char *output, *folder;
    int in_place, made_folder; /* made_folder: --out-dir did not exist */
    norma_file_format format;  /* unknown: by each name */
    cli_guard *guard;          /* keeps what is read from being overwritten */
} cli_files;
extern const cli_option cli_input_options[]; /* --input-format */
extern const size_t cli_input_option_count;

/* Reads a command line, whose words name files. A status; not CLI_OK: files hold nothing. */
int cli_read_files(const cli_subcommand *command, cli_files *files, const cli_table *tables,
    size_t table_count, int count, char **arguments);
void cli_files_end(cli_files *files);

/* Opens "-" or a path. *memory is what standard input held; freed after the document. */
norma_document_result cli_open(const cli_files *files, const char *input,
    const norma_document_options *options, norma_document **document, void **memory,
    norma_document_error *error);
/* The same with what all commands ask for, and a line while a person waits. */
norma_document_result cli_read(const cli_files *files, const cli_common *common, const char *input,
    const norma_document_options *asked, norma_document **document, void **memory,
    norma_document_error *error);
/* Why there is nothing to show or draw (what): of the first mesh, why it could not be read, or what
 * the file holds instead of faces. */
norma_document_result cli_fail_empty(
    norma_document *document, const char *input, const char *what, norma_document_error *error);
/* A file or a pipe to its end, to be freed. NULL: errno or, where it is asked for, *endless says
 * why: memory stays bounded, whatever is on the other side. */
char *cli_read_all(int file, size_t *size, const char **endless);
double cli_megabytes(const char *input); /* 0: not known */
void cli_json_notes(cli_json *json, const norma_document *document);

/* ---- Which files the words of a command stand for. */

/* Adds the files that the words stand for: a file, the files of a folder and below, what a pattern
 * with *, ? and ** matches, or "-". A folder that cannot be read does not stop the others: the
 * status is then CLI_FILE and inputs hold the rest. */
int cli_find_inputs(const cli_subcommand *command, cli_files *files);
/* The same for the lines of each list; what does not exist or has no reader is left out. */
int cli_find_listed(const cli_subcommand *command, cli_files *files);
void cli_inputs_free(cli_inputs *inputs);
int cli_compare_inputs(const void *a, const void *b); /* for qsort: by path, as bytes */
/* Whether a path, component by component, is what a pattern says; ** stands for any number of
 * components. A pattern without a slash is compared with the last one. */
int cli_path_matches(const char *pattern, const char *path);
char *cli_join(const char *folder, const char *name); /* the caller's to free */
const char *cli_base_name(const char *path);          /* behind its last slash */

/* ---- Where the output of each input goes, and whether it may (outputs.c). */

int cli_ends_in(const char *path, const char *ending); /* in letters of either case */
int cli_is_folder(const char *path);
int cli_is_standard(const char *name); /* "-" */
int cli_is_stream(const char *path);   /* a pipe or a device, which is written as it is */

/* Gives each input a place of its own below --out-dir. ending: as of cli_output_of. A status. */
int cli_place_outputs(const cli_subcommand *command, cli_files *files, const char *ending);
/* The output of an input, the caller's to free; ending (NULL: the input's own) replaces the input's
 * below --out-dir. NULL: out of memory. */
char *cli_output_of(const cli_files *files, size_t index, const char *ending);
int cli_make_out_dir(const cli_subcommand *command, cli_files *files);
/* If this run has made --out-dir: takes it away, and folders below, as far as nothing is in them.
 */
void cli_remove_empty_folders(const cli_files *files);
/* Removes what a worker that has ended was just putting in the place of an input's output. */
void cli_remove_left_by(int worker, const cli_files *files, size_t index);
/* The folders below --out-dir that an output lies in. A status. */
int cli_make_folders(const cli_files *files, const char *output);

extern const cli_option cli_output_options[]; /* -o --out-dir --in-place */
extern const size_t cli_output_option_count;

/* Whether all have somewhere to go, each its own place; makes --out-dir. A status. */
int cli_check_outputs(const cli_subcommand *command, const cli_common *common, cli_files *files);
/* Whether no output is a source, as far as the inputs' names say. ending: as of cli_output_of. A
 * status. */
int cli_guard_outputs(const cli_files *files, const char *ending);
/* The same of one output, just before it is written. */
int cli_guard_output_of(const cli_files *files, const char *input, const char *output);
/* To standard output, or to a file as files say; options: how its progress is told. */
norma_document_result cli_save(const cli_files *files, norma_document *document, const char *output,
    norma_save_options *options, norma_document_error *error);

/* ---- A report that goes to a file, whole or not at all (outputs.c). */

typedef struct cli_output {
    FILE *out;
    const char *path;
    cli_guard *guard;
    norma_saving *saving; /* NULL: standard output */
    int passes_on;        /* what is written cannot be taken back: standard output, a pipe */
} cli_output;
/* path "-" is standard output; guard may be NULL. A status; not CLI_OK: reported already. The
 * output stays where it is until it is ended or dropped. */
int cli_output_begin(cli_output *output, const char *path, cli_guard *guard);
int cli_output_end(cli_output *output);   /* a status */
void cli_output_drop(cli_output *output); /* as if it had never been begun */

/* ---- Work on the files of a batch one after the other, in a process of its own (outputs.c,
 * process.h). */

typedef struct cli_each {
    size_t count;
    int (*one)(void *user, size_t file); /* a status */
    /* That file ended a worker, the process of that number. */
    void (*lost)(void *user, size_t file, int worker, const char *why);
    void *user;
    cli_guard *guard; /* learns what one reads; may be NULL */
} cli_each;
int cli_run_each(const cli_each *each); /* the worst status */

/* Inputs that are opened later: glTF files are looked into, if an output exists, so that no output
 * of the first can replace a picture of the second. */
void cli_guard_look_ahead(cli_guard *guard, const cli_inputs *inputs, norma_file_format format);

/* ---- Commands that change files: each is opened, changed and written, and a line says so
 * (change_files.c). */

#define CLI_FORMATS "obj, ply, stl, gltf, glb, b3dm, i3dm, cmpt or 3mf"
#define CLI_INPUT_FORMAT_HELP                                                                      \
    "  --input-format FORMAT if IN is -: obj, ply, stl, gltf, glb, b3dm, i3dm, cmpt, 3mf\n"
#define CLI_FILES_HELP                                                                             \
    "Files\n"                                                                                      \
    "  IN                    a file, a folder, or a pattern in quotes\n"                           \
    "  -o, --output OUT      the output, in IN's format; - is standard output\n"                   \
    "  --out-dir FOLDER      the folder for several outputs; keeps the tree of an input folder\n"  \
    "  --in-place            replaces each input file; a failure leaves it as it "                 \
    "was\n" CLI_INPUT_FORMAT_HELP                                                                  \
    "  --threads N           uses at most N threads (all processors), with the same result\n"      \
    "  --max-memory SIZE     uses at most SIZE (512M, 2G). compute reads larger binary PLY and\n"  \
    "                        STL in passes; other files that need more fail\n"                     \
    "  --json                prints a summary as JSON, one object per line\n"                      \
    "  --quiet               prints only errors\n"

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
    int (*prepare)(const cli_subcommand *command, void *work, uint32_t threads); /* or NULL */
    /* NULL, or all files at once, where takes_all says so after prepare. A status. */
    int (*all)(const cli_all_files *all);
    int (*takes_all)(const void *work);
};

/* Such a command as a whole, from its arguments to its status; tables: its own options beside those
 * that all of them take. */
enum { CLI_OWN_TABLES = 2 };
int cli_run_changer(const cli_subcommand *command, const cli_changer *changer,
    const cli_table *tables, size_t table_count, int count, char **arguments);

/* The line, or the JSON object, about a file of a batch that was changed as a whole, by what
 * changer->work holds of it; of one that was not, whose error was printed, the object alone. bytes:
 * before and after, those of the files that it names among them, 0 where they are not known. */
void cli_report_changed(const cli_all_files *all, const char *input, const char *output,
    const double bytes[2], const norma_document_error *error);

/* ---- Files that do not fit into memory, changed piece by piece (change_files.c). */

/* Whether this input can be read in passes, as only files of some size are; need: what it takes to
 * compute its normals at once. */
int cli_can_take_passes(const cli_files *files, const char *input, uint64_t *need);
/* Whether this input does not fit into the memory allowed, but can be read in passes. */
int cli_needs_passes(const cli_files *files, const char *input);

#endif
