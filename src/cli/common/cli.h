/* cli.h: what the files of the command-line tool share: exit statuses, verbs, options, the batch of
 * files, reports. Only public headers below this. */
#ifndef NORMA_CLI_H
#define NORMA_CLI_H
#include "cli/common/guard.h"
#include "cli/common/outside_text.h"
#include <norma/document.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum cli_status {
    CLI_OK = 0,
    CLI_FINDINGS = 1,
    CLI_USAGE = 2,
    CLI_FILE = 3,
    CLI_INTERRUPTED = 130
};

#define CLI_COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* ---- verbs */

typedef struct cli_subcommand {
    const char *name, *summary, *help;
    int (*run)(const struct cli_subcommand *verb, int count, char **arguments);
} cli_subcommand;

extern const cli_subcommand cli_subcommand_render, cli_subcommand_view;
extern const cli_subcommand cli_subcommand_compute, cli_subcommand_transform, cli_subcommand_matrix,
    cli_subcommand_info, cli_subcommand_check, cli_subcommand_explain;

/* ---- messages on stderr: "norma compute: ..." (verb may be NULL). Always CLI_USAGE, so that a
 * caller can return it. */
#if defined(__GNUC__)
__attribute__((format(printf, 2, 3)))
#endif
int cli_usage(const cli_subcommand *verb, const char *format, ...);
/* The name of names (each at stride bytes from the last, a const char * first) that a misspelt word
 * most likely means; NULL: none is near. */
const char *cli_suggest(const char *word, const void *names, size_t count, size_t stride);

/* The word of expected, a list such as "error, warning or info", that given most likely means; 0:
 * none is near, or expected is no such list. */
enum { CLI_LONGEST_WORD = 32 };
int cli_suggest_listed(const char *given, const char *expected, char meant[CLI_LONGEST_WORD + 1]);

/* ---- options: one table for each verb */

enum {
    CLI_NO_VALUE = 0,
    CLI_VALUE = 1,
    CLI_MAYBE_VALUE = 2 /* only as --name=value; else the value is NULL */
};

typedef struct cli_option {
    const char *name; /* without its dashes */
    char letter;      /* 'o' for -o, or 0 */
    int takes_value;
    const char *(*set)(void *settings, const char *value); /* NULL, or what was expected */
} cli_option;

typedef struct cli_table {
    const cli_option *options;
    size_t count;
    void *settings;
} cli_table;

/* Files named on the command line, in its order. */
typedef struct cli_words {
    const char **words;
    size_t count;
} cli_words;

/* Tries each table in turn. Returns CLI_OK or CLI_USAGE, said already; *help: --help was given,
 * nothing else counts. words->words has room for count words; NULL: a usage error. */
int cli_parse(const cli_subcommand *verb, const cli_table *tables, size_t table_count, int count,
    char **arguments, cli_words *words, int *help);

/* Reads the whole text as C spells numbers. Returns 0 if it is not a finite number. */
int cli_number(const char *text, double *number);
/* As many numbers as there is room for, with commas or blanks between; returns how many there are
 * (more than room: room + 1; 0 where one is no number). */
size_t cli_numbers(const char *text, double *numbers, size_t room);

/* ---- settings that several verbs share */

typedef struct cli_common {
    int json, quiet;
    uint32_t threads;
} cli_common;
extern const cli_option cli_common_options[]; /* --json --max-memory --quiet --threads */
extern const size_t cli_common_option_count;
const char *cli_limit_memory(
    const char *value); /* of --max-memory, for the whole process: NULL, or what was expected */
/* "; memory is limited to 512M (--max-memory)", or "" without a limit: the end of a message. */
enum { CLI_LIMIT_ROOM = 96 };
void cli_memory_limit_words(char text[CLI_LIMIT_ROOM]);
extern const cli_option cli_matrix_options[]; /* --scale --rotate --translate --matrix */
#define CLI_MATRIX_HELP                                                                            \
    "The matrix: options combine into one; the first is applied first\n"                           \
    "  --scale X,Y,Z         or one number for all three\n"                                        \
    "  --rotate X,Y,Z,DEG    about the axis X,Y,Z, counter-clockwise seen from its tip\n"          \
    "  --translate X,Y,Z\n"                                                                        \
    "  --matrix \"16 numbers, row by row\"\n"                                                      \
    "                        for column vectors: the translation is the last column\n"
extern const size_t cli_matrix_option_count;
typedef struct cli_matrix {
    double matrix[16]; /* column-major */
    int given;         /* how many options made it */
    int overflow;
} cli_matrix;
extern const cli_matrix cli_matrix_identity;

/* ---- files in and out */

struct cli_json;

typedef struct cli_inputs {
    char **paths;
    size_t *tails; /* of each path: from which byte on it is kept below --out-dir */
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
extern const cli_option cli_input_options[],
    cli_output_options[]; /* --input-format; -o --out-dir --in-place */
extern const size_t cli_input_option_count, cli_output_option_count;

/* What --help says of what cli_run_changer reads. */
#define CLI_FILES_HELP                                                                             \
    "Files\n"                                                                                      \
    "  IN                    a file, a folder, or a pattern in quotes\n"                           \
    "  -o, --output OUT      the output, in IN's format; - is standard output\n"                   \
    "  --out-dir FOLDER      where outputs go, if there are several inputs; keeps the tree of a\n" \
    "                        folder\n"                                                             \
    "  --in-place            replaces each input, whole or not at all\n"                           \
    "  --input-format obj|ply|stl|gltf|glb\n"                                                      \
    "                        needed for standard input, which is called -\n"                       \
    "  --threads N           how many threads may work (all); the result has the same bits\n"      \
    "  --max-memory SIZE     512M, 2G: ends with 'out of memory' if a file needs more\n"           \
    "  --json                prints a summary for programs, one object a line\n"                   \
    "  --quiet               prints nothing but errors\n"

/* What a verb does to each file of a batch: opened, changed, written, told about. */
typedef struct cli_changer {
    void *work; /* the verb's own: its options, and the summary of the file at hand */
    norma_document_result (*change)(void *work, norma_document *document, norma_progress *progress,
        void *progress_user, norma_document_error *error);
    void (*write_json)(
        const void *work, struct cli_json *json); /* the keys after "input" and "output" */
    void (*write_text)(const void *work, const norma_document *document,
        FILE *out); /* what stands after "IN -> OUT: ", without the line's end */
    int (*prepare)(const cli_subcommand *verb, void *work,
        uint32_t threads); /* once all options are read: a status */
} cli_changer;
/* Makes room for count words and the guard. 0: out of memory, reported. */
int cli_files_begin(const cli_subcommand *verb, cli_files *files, int count);
void cli_files_end(cli_files *files);

/* ---- which files (find_inputs.c) */

/* Adds the files that the words stand for: a file, the files of a folder and below, what a pattern
 * with *, ? and ** matches, or "-". A folder that cannot be read does not stop the others: the
 * status is then CLI_FILE and inputs hold the rest. */
int cli_find_inputs(const cli_subcommand *verb, cli_files *files);
/* The same for the lines of each list; what does not exist or has no reader is left out. */
int cli_find_listed(const cli_subcommand *verb, cli_files *files);
void cli_inputs_free(cli_inputs *inputs);
/* Whether a path, component by component, is what a pattern says; ** stands for any number of
 * components. A pattern without a slash is compared with the last one. */
int cli_path_matches(const char *pattern, const char *path);
char *cli_join(const char *folder, const char *name); /* the caller's to free */

/* ---- where outputs go (place_outputs.c) */

/* Gives each input a place of its own below --out-dir. ending: as of cli_output_of. A status. */
int cli_place_outputs(const cli_subcommand *verb, cli_files *files, const char *ending);
/* The output of an input, the caller's to free; ending (NULL: the input's own) replaces the input's
 * below --out-dir. NULL: out of memory. */
char *cli_output_of(const cli_files *files, size_t index, const char *ending);
int cli_make_out_dir(const cli_subcommand *verb, const cli_files *files);
/* The folders below --out-dir that an output lies in. A status. */
int cli_make_folders(const cli_files *files, const char *output);

/* Whether all have somewhere to go, each its own place; makes --out-dir. A status. */
int cli_check_outputs(const cli_subcommand *verb, const cli_common *common, cli_files *files);
/* Whether no output is a source, as far as the inputs' names say. A status. */
int cli_guard_outputs(const cli_files *files);
/* Such a verb as a whole, from its arguments to its status; tables: its own options beside those
 * that all of them take. */
enum { CLI_OWN_TABLES = 2 };
int cli_run_changer(const cli_subcommand *verb, const cli_changer *changer, const cli_table *tables,
    size_t table_count, int count, char **arguments);

norma_document_result cli_write_standard(
    norma_document *document, norma_document_error *error); /* to standard output; interruptible */
/* Opens "-" or a path. *memory is what standard input held; freed after the document. */
norma_document_result cli_open(const cli_files *files, const char *input,
    const norma_document_options *options, norma_document **document, void **memory,
    norma_document_error *error);
const char *cli_input_name(const char *input); /* for people: "standard input" for "-" */
double cli_megabytes(const char *input);       /* 0: not known */
int cli_status_of(norma_document_result result);
int cli_worse(int status, int other); /* of a batch: interrupted, then 3, then 2, then 0 */
void cli_name_error(
    norma_document_error *error, const char *input); /* "standard input" for the library's word for
                                                        bytes without a name, "interrupted" */
/* An error that was printed already: a file error whose message is "reported". */
norma_document_result cli_reported(norma_document_error *error);
/* What was printed already is not printed again; an error without words gets those of its kind. */
void cli_print_error(const norma_document_error *error);
void cli_print_notes(const char *input, const norma_document *document);
void cli_json_notes(struct cli_json *json, const norma_document *document);
int cli_out_of_memory(void); /* says so; CLI_FILE */
int cli_finish(int status);  /* flushes stdout; a full disk there is status 3 */

/* A report that goes to a file, whole or not at all. */
typedef struct cli_memory_stream {
    FILE *out;
    char *text; /* once closed: what was written to out, ended by a 0; the caller's to free */
    size_t size, room;
} cli_memory_stream;
/* The stream stays where it is while it is open. 0: out of memory. */
int cli_memory_open(cli_memory_stream *stream);
/* Whether all that was written is there; where not, text is NULL. */
int cli_memory_close(cli_memory_stream *stream);

typedef struct cli_output {
    FILE *out;
    const char *path;
    cli_guard *guard;
    cli_memory_stream gathered; /* not of standard output */
} cli_output;
/* path "-" is standard output; guard may be NULL. A status; not CLI_OK: reported already. */
int cli_output_begin(cli_output *output, const char *path, cli_guard *guard);
int cli_output_end(cli_output *output);   /* a status */
void cli_output_drop(cli_output *output); /* as if it had never been begun */

/* ---- progress and interruption */

typedef struct cli_progress {
    int shown, enabled;
    double began, said; /* seconds */
    double megabytes;   /* of the input; 0: not known */
    const char *what, *name;
} cli_progress;
void cli_startup_checks(void); /* before anything is opened: closed standard streams, mapped files
                         that become shorter */
void cli_watch_interrupts(void);
int cli_interrupted(void); /* 0, or 128 plus the signal */
void cli_progress_start(
    cli_progress *progress, const char *what, const char *name, int quiet, double megabytes);
int cli_progress_report(void *progress, double fraction); /* a norma_progress */
/* The same for work of several steps, each of which begins at 0: shows the seconds that it took. */
int cli_progress_elapsed(void *progress, double fraction);
void cli_progress_hide(cli_progress *progress); /* until it is reported again */
void cli_progress_stop(cli_progress *progress);
int cli_stop_when_interrupted(
    void *nothing, double fraction); /* a norma_progress that shows nothing */

/* ---- reports for people */

void cli_count(FILE *out, size_t count); /* 1,234 */
void cli_counted(FILE *out, size_t count, const char *one, const char *many);
char *cli_decimals(char text[32], double number,
    int digits); /* rounded to so many decimals, without trailing zeros */
const char *cli_find_weight(
    const char *word, norma_weight *out); /* NULL, or what was expected instead */
const char *cli_kind_name(norma_kind kind);
double cli_radians(double degrees);
double cli_to_degrees(double radians);
double cli_given_degrees(double radians); /* 60 where 60 was given: rounded to 1e-9 */

/* ---- how stored normals were probably made */

typedef struct cli_explained {
    norma_weight weight;
    double crease_deg; /* NaN: smooth, one normal for each position */
    int flat;
    double p50_deg, p99_deg, max_deg; /* between the stored normals and those that it gives */
} cli_explained;
/* 1 where normals were there to be explained. */
int cli_explain_normals(norma_document *document, size_t mesh, uint32_t threads,
    cli_explained *explained, norma_document_result *result, norma_document_error *error);

/* ---- reports for machines */

typedef struct cli_json {
    FILE *out;
    int needs_comma;
} cli_json;
void cli_json_open(cli_json *json, const char *key, char bracket); /* key NULL within an array */
void cli_json_close(cli_json *json, char bracket);
void cli_json_string(cli_json *json, const char *key,
    const char *text); /* NULL: null. Bytes that are not UTF-8 become U+FFFD */
void cli_json_size(cli_json *json, const char *key, size_t number);
void cli_json_number(cli_json *json, const char *key,
    double number); /* reads back as the same; null where it is not finite */
void cli_json_bool(cli_json *json, const char *key, int value);
void cli_json_null(cli_json *json, const char *key);
char *cli_shortest(char text[32], double number); /* the fewest digits that read back as the same */
#endif
