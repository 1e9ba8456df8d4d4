/* options.h: a command line: subcommands, the options that all have, matrices, misspelt words. */
#ifndef NORMA_CLI_OPTIONS_OPTIONS_H
#define NORMA_CLI_OPTIONS_OPTIONS_H
#include "cli/text/text.h"

/* ---- A command: its name, its help, its function; and usage errors. */

typedef struct cli_subcommand {
    const char *name, *summary, *help;
    int (*run)(const struct cli_subcommand *command, int count, char **arguments);
} cli_subcommand;

extern const cli_subcommand cli_subcommand_compute, cli_subcommand_tangents,
    cli_subcommand_transform, cli_subcommand_matrix, cli_subcommand_check, cli_subcommand_report,
    cli_subcommand_explain, cli_subcommand_info, cli_subcommand_compare, cli_subcommand_render,
    cli_subcommand_view, cli_subcommand_acid, cli_subcommand_pack, cli_subcommand_mcp,
    cli_subcommand_seams;

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

/* What becomes of an option: a function is called, or its value goes to a place in the settings. */
enum cli_kind {
    CLI_CALLS,  /* set */
    CLI_FLAG,   /* an int or an enum becomes number */
    CLI_TEXT,   /* a const char *, which is not empty where expected says what it is */
    CLI_ONCE,   /* the same, refused when it is given again */
    CLI_CHOICE, /* an int or an enum: number for the first of words, and so on */
    CLI_WEIGHT, /* a norma_weight */
    CLI_INT,    /* whole numbers from least to most: an int, a uint32_t */
    CLI_SIZE,   /* a size_t */
    CLI_DOUBLE, /* any number from least to most */
    CLI_RADIANS /* of degrees */
};

typedef struct cli_option {
    const char *name;                                      /* without its dashes */
    char letter;                                           /* 'o' for -o, or 0 */
    int takes_value;                                       /* where a function is called */
    const char *(*set)(void *settings, const char *value); /* NULL, or what was expected */
    enum cli_kind kind;
    size_t at; /* of the place, in the settings */
    int number;
    const char *words, *expected; /* words: "a,b,c" */
    double least, most;
    size_t given; /* of an int that gets the bit when the option is given; bit 0: none does */
    int bit;
} cli_option;
/* The parts of an entry behind its name. */
#define CLI_SET(function)                 .takes_value = CLI_VALUE, .set = (function)
#define CLI_TO(what, settings, member)    .kind = (what), .at = offsetof(settings, member)
#define CLI_GIVEN(settings, member, set)  .given = offsetof(settings, member), .bit = (set)
#define CLI_SETS(settings, member, value) CLI_TO(CLI_FLAG, settings, member), .number = (value)
#define CLI_WHOLE_FROM_1                  "a whole number from 1 up"
#define CLI_ONLY(settings, member)                                                                 \
    CLI_TO(CLI_CHOICE, settings, member), .words = "all,missing,broken",                           \
                                          .expected = "all, missing or broken"
#define CLI_CREASE(settings, member)                                                               \
    CLI_TO(CLI_RADIANS, settings, member), .most = 180, .expected = "degrees from 0 to 180"

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

/* Tries each table in turn. Returns CLI_OK or CLI_USAGE, said already. words->words has room for
 * count words; NULL: a usage error. */
int cli_parse(const cli_subcommand *command, const cli_table *tables, size_t table_count, int count,
    char **arguments, cli_words *words);

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
enum { CLI_LONGEST_WORD = 128 };
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
int cli_is_affine(const cli_matrix *matrix); /* its last row is 0 0 0 1 */
#endif
