/* options.h: a command line, read by the tables of its command; and the options that all commands
 * have.
 */
#ifndef NORMA_CLI_OPTIONS_H
#define NORMA_CLI_OPTIONS_H
#include "cli/options/subcommand.h"

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
#endif
