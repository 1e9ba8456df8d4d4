/* options.h: a command line: subcommands, the options that all have, matrices, misspelt words. */
#ifndef NORMA_CLI_OPTIONS_OPTIONS_H
#define NORMA_CLI_OPTIONS_OPTIONS_H
#include "cli/text/text.h"
#include <stddef.h>

/* ---- A command: its name, its help, its function; and usage errors. */

typedef struct cli_subcommand {
    const char *name, *summary, *help;
    int (*run)(const struct cli_subcommand *command, int count, char **arguments);
} cli_subcommand;

extern const cli_subcommand cli_subcommand_compute, cli_subcommand_tangents,
    cli_subcommand_transform, cli_subcommand_matrix, cli_subcommand_check, cli_subcommand_report,
    cli_subcommand_explain, cli_subcommand_info, cli_subcommand_render, cli_subcommand_view;

/* Prints "norma compute: ..." (command may be NULL). Always CLI_USAGE, so that a caller can return
 * it.
 */
CLI_FORMAT(2, 3) int cli_usage(const cli_subcommand *command, const char *format, ...);

/* ---- A command line, read by the tables of its command; and the options that all commands
 * have.
 */

#define CLI_COUNT(array) (sizeof(array) / sizeof((array)[0]))

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
int cli_parse(const cli_subcommand *command, const cli_table *tables, size_t table_count, int count,
    char **arguments, cli_words *words, int *help);

/* Reads the whole text as C spells numbers. Returns 0 if it is not a finite number. */
int cli_number(const char *text, double *number);
/* As many numbers as there is room for, with commas or blanks between; returns how many there are
 * (more than room: room + 1; 0 where one is no number). */
size_t cli_numbers(const char *text, double *numbers, size_t room);

typedef struct cli_common {
    int json, quiet;
    uint32_t threads;
} cli_common;
extern const cli_option cli_common_options[]; /* --json --max-memory --quiet --threads */
extern const size_t cli_common_option_count;

/* ---- What a misspelt word most likely means. */

/* The nearest of names (each at stride bytes from the last, a const char * first). NULL: none is
 * near. */
const char *cli_suggest(const char *word, const void *names, size_t count, size_t stride);
const char *cli_suggest_rule(const char *word); /* the same of the names and ids of rules */

/* The nearest word of expected, a list such as "error, warning or info". 0: none is near, or
 * expected is no such list. */
enum { CLI_LONGEST_WORD = 32 };
int cli_suggest_listed(const char *given, const char *expected, char meant[CLI_LONGEST_WORD + 1]);

/* ---- One matrix from --scale, --rotate, --translate and --matrix. */

#define CLI_MATRIX_HELP                                                                            \
    "The matrix: several options combine; the first is applied first\n"                            \
    "  --scale X,Y,Z         one factor for each axis, or one number for all three\n"              \
    "  --rotate X,Y,Z,DEG    about the axis X,Y,Z, counter-clockwise seen from its tip\n"          \
    "  --translate X,Y,Z\n"                                                                        \
    "  --matrix \"16 numbers, row by row\"\n"                                                      \
    "                        for column vectors: the translation is the last column\n"

extern const cli_option cli_matrix_options[];
extern const size_t cli_matrix_option_count;
typedef struct cli_matrix {
    double matrix[16]; /* column-major */
    int given;         /* how many options made it */
    int overflow;
} cli_matrix;
extern const cli_matrix cli_matrix_identity;
#endif
