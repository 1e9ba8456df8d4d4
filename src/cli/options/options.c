/* options.c: reads a command line by the tables of its command: --name value, --name=value, -o
 * value,
 * -- for names that begin with a dash. */
#include "cli/options/options.h"
#include "cli/options/suggest.h"
#include "cli/process/errors.h"
#include "cli/process/memory_limit.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

int cli_usage(const cli_subcommand *command, const char *format, ...) {
    va_list arguments;
    fprintf(stderr, "norma%s%s: ", command ? " " : "", command ? command->name : "");
    va_start(arguments, format);
    cli_say_list(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, " (see 'norma help%s%s')\n", command ? " " : "", command ? command->name : "");
    return CLI_USAGE;
}

/* ---- parsing */

static const cli_option *find_option(const cli_table *tables, size_t table_count, const char *name,
    size_t length, char letter, const cli_table **table) {
    for (size_t t = 0; t < table_count; ++t)
        for (size_t i = 0; i < tables[t].count; ++i) {
            const cli_option *option = &tables[t].options[i];
            int found =
                letter ? option->letter == letter
                       : strlen(option->name) == length && memcmp(option->name, name, length) == 0;
            if (found) {
                *table = &tables[t];
                return option;
            }
        }
    return NULL;
}

static int unknown_option(const cli_subcommand *command, const cli_table *tables,
    size_t table_count, const char *argument) {
    char name[CLI_LONGEST_WORD + 1] = "";
    const char *meant = NULL;
    size_t length = strcspn(argument + 2, "=");
    if (argument[1] == '-' && length <= CLI_LONGEST_WORD) {
        memcpy(name, argument + 2, length);
        for (size_t t = 0; t < table_count && !meant; ++t)
            meant = cli_suggest(name, tables[t].options, tables[t].count, sizeof(cli_option));
    }
    if (meant)
        return cli_usage(command, "unknown option '%s'; did you mean --%s?", argument, meant);
    return cli_usage(command, "unknown option '%s'", argument);
}

/* A forgotten value would otherwise swallow the next option; what begins with one dash may be a
 * negative number. */
static int is_option(const cli_table *tables, size_t table_count, const char *word) {
    const cli_table *table;
    return word[0] == '-' && word[1] == '-' &&
           (word[2] == '\0' ||
               find_option(tables, table_count, word + 2, strcspn(word + 2, "="), 0, &table));
}

/* Reads the option at arguments[*at], which moves to its last word. */
static int read_option(const cli_subcommand *command, const cli_table *tables, size_t table_count,
    int count, char **arguments, int *at) {
    const char *argument = arguments[*at], *value = NULL;
    const cli_table *table;
    const cli_option *option;
    if (argument[1] == '-') {
        size_t length = strcspn(argument + 2, "=");
        option = find_option(tables, table_count, argument + 2, length, 0, &table);
        if (argument[2 + length] == '=') value = argument + 2 + length + 1;
    } else {
        option = find_option(tables, table_count, NULL, 0, argument[1], &table);
        if (argument[2]) value = argument + 2;
    }
    if (!option || (argument[1] != '-' && value && !option->takes_value))
        return unknown_option(command, tables, table_count, argument);
    if (value && !option->takes_value)
        return cli_usage(command, "--%s takes no value", option->name);
    if (!value && option->takes_value == CLI_VALUE) {
        if (*at + 1 >= count || is_option(tables, table_count, arguments[*at + 1]))
            return cli_usage(command, "%s needs a value", argument);
        value = arguments[++*at];
    }
    const char *expected = option->set(table->settings, value);
    char meant[CLI_LONGEST_WORD + 1];
    if (!expected) return CLI_OK;
    if (value && cli_suggest_listed(value, expected, meant))
        return cli_usage(command, "--%s '%s': expected %s; did you mean %s?", option->name, value,
            expected, meant);
    return value ? cli_usage(command, "--%s '%s': expected %s", option->name, value, expected)
                 : cli_usage(command, "--%s: %s", option->name, expected);
}

int cli_parse(const cli_subcommand *command, const cli_table *tables, size_t table_count, int count,
    char **arguments, cli_words *words, int *help) {
    int only_words = 0;
    *help = 0;
    for (int i = 0; i < count; ++i) {
        if (strcmp(arguments[i], "--") == 0) break;
        if (strcmp(arguments[i], "--help") == 0 || strcmp(arguments[i], "-h") == 0) {
            *help = 1;
            return CLI_OK;
        }
    }
    for (int i = 0; i < count; ++i) {
        const char *argument = arguments[i];
        if (only_words || argument[0] != '-' || argument[1] == '\0') {
            if (!words->words)
                return cli_usage(command, "takes no file, and '%s' is not an option", argument);
            words->words[words->count++] = argument;
        } else if (strcmp(argument, "--") == 0) {
            only_words = 1;
        } else {
            int status = read_option(command, tables, table_count, count, arguments, &i);
            if (status) return status;
        }
    }
    return CLI_OK;
}

/* ---- numbers */

/* strtod alone would also take "inf", "nan", hexadecimal and leading blanks. The tool stays in
 * the locale "C". */
static const char *read_number(const char *text, double *number) {
    size_t length = strspn(text, "+-.0123456789eE");
    char *end;
    *number = strtod(text, &end);
    return length > 0 && end == text + length && isfinite(*number) ? end : NULL;
}

int cli_number(const char *text, double *number) {
    const char *end = read_number(text, number);
    return end && *end == '\0';
}

size_t cli_numbers(const char *text, double *numbers, size_t room) {
    static const char blanks[] = " \t\r\n";
    size_t count = 0;
    const char *at = text + strspn(text, blanks);
    while (*at) {
        double number;
        at = read_number(at, &number);
        if (!at) return 0;
        if (count == room) return room + 1;
        numbers[count++] = number;
        const char *after = at + strspn(at, blanks);
        int comma = *after == ',';
        if (comma) after += 1 + strspn(after + 1, blanks);
        int separated = after > at;
        if (*after ? !separated : comma) return 0;
        at = after;
    }
    return count;
}

/* ---- options of every command */

static const char *set_json(void *settings, const char *value) {
    (void)value;
    ((cli_common *)settings)->json = 1;
    return NULL;
}

static const char *set_quiet(void *settings, const char *value) {
    (void)value;
    ((cli_common *)settings)->quiet = 1;
    return NULL;
}

static const char *set_threads(void *settings, const char *value) {
    double threads;
    if (!cli_number(value, &threads) || threads < 1 || threads > 65536 || threads != floor(threads))
        return "a whole number from 1 up";
    ((cli_common *)settings)->threads = (uint32_t)threads;
    return NULL;
}

static const char *set_max_memory(void *settings, const char *value) {
    (void)settings; /* it is the process's */
    return cli_limit_memory(value);
}

const cli_option cli_common_options[] = {
    {"json", 0, 0, set_json},
    {"max-memory", 0, 1, set_max_memory},
    {"quiet", 0, 0, set_quiet},
    {"threads", 0, 1, set_threads},
};
const size_t cli_common_option_count = CLI_COUNT(cli_common_options);
