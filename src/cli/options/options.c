/* options.c: a command line: misspelt words, options, matrices. */
#include "cli/options/options.h"
#include "cli/process/process.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- What a misspelt word may mean: the name with the least number of letters to put in,
 * take out, change or swap with the next. */

static size_t smaller_distance(size_t a, size_t b) { return a < b ? a : b; }

static size_t edit_distance(const char *a, const char *b) {
    size_t of_a = strlen(a), of_b = strlen(b), rows[3][CLI_LONGEST_WORD + 1];
    if (of_a > CLI_LONGEST_WORD || of_b > CLI_LONGEST_WORD) return SIZE_MAX;
    for (size_t j = 0; j <= of_b; ++j) rows[0][j] = j;
    for (size_t i = 1; i <= of_a; ++i) {
        size_t *row = rows[i % 3], *above = rows[(i + 2) % 3], *two_above = rows[(i + 1) % 3];
        row[0] = i;
        for (size_t j = 1; j <= of_b; ++j) {
            row[j] = smaller_distance(
                smaller_distance(above[j], row[j - 1]) + 1, above[j - 1] + (a[i - 1] != b[j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = smaller_distance(row[j], two_above[j - 2] + 1);
        }
    }
    return rows[of_a % 3][of_b];
}

const char *cli_suggest(const char *word, const void *names, size_t count, size_t stride) {
    const char *best = NULL;
    size_t nearest = strlen(word) < 4 ? 2 : 3; /* further off, it is no misspelling of anything */
    for (size_t i = 0; i < count; ++i) {
        const char *name;
        memcpy(&name, (const char *)names + i * stride, sizeof name);
        size_t distance = edit_distance(word, name);
        /* A word cut short: --transl. */
        if (strlen(word) >= 3 && strncmp(name, word, strlen(word)) == 0)
            distance = smaller_distance(distance, 1);
        if (distance < nearest) {
            nearest = distance;
            best = name;
        }
    }
    return best;
}

const char *cli_suggest_rule(const char *word) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    const char *name = cli_suggest(word, &rules->name, count, sizeof *rules);
    return name ? name : cli_suggest(word, &rules->id, count, sizeof *rules);
}

/* The words of a list such as "error, warning, info or never" are what is compared. What does not
 * read as such a list names nothing. */
static int next_listed(const char **text, char word[CLI_LONGEST_WORD + 1]) {
    const size_t length = strcspn(*text, ", "), quoted = **text == '"';
    if (length == 0 || length - 2 * quoted > CLI_LONGEST_WORD) return 0;
    memcpy(word, *text + quoted, length - 2 * quoted);
    word[length - 2 * quoted] = '\0';
    *text += length;
    const char *const between[] = {", ", " or "};
    for (size_t i = 0; i < sizeof between / sizeof *between; ++i)
        if (strncmp(*text, between[i], strlen(between[i])) == 0) {
            *text += strlen(between[i]);
            return 1;
        }
    return **text == '\0';
}

int cli_suggest_listed(const char *given, const char *expected, char meant[CLI_LONGEST_WORD + 1]) {
    char word[CLI_LONGEST_WORD + 1];
    size_t nearest = SIZE_MAX;
    while (*expected) {
        if (!next_listed(&expected, word)) return 0;
        const char *name = word;
        const size_t distance = edit_distance(given, word);
        if (cli_suggest(given, &name, 1, sizeof name) && distance < nearest) {
            nearest = distance;
            strcpy(meant, word);
        }
    }
    return nearest != SIZE_MAX;
}

/* ---- Reads a command line by the tables of its command: --name value, --name=value, -o
 * value,
 * -- for names that begin with a dash. */

int cli_usage(const cli_subcommand *command, const char *format, ...) {
    va_list arguments;
    fprintf(stderr, "norma%s%s: ", command ? " " : "", command ? command->name : "");
    va_start(arguments, format);
    cli_say_list(stderr, format, arguments);
    va_end(arguments);
    fprintf(stderr, " (see '" NORMA_PROGRAM " help%s%s')\n", command ? " " : "",
        command ? command->name : "");
    return CLI_USAGE;
}

/* ---- what becomes of an option */

static const char *choose_word(const cli_option *option, const char *value, void *to) {
    int number = option->number;
    for (const char *word = option->words;; ++number) {
        const size_t length = strcspn(word, ",");
        if (strlen(value) == length && memcmp(word, value, length) == 0) {
            memcpy(to, &number, sizeof number);
            return NULL;
        }
        if (!word[length]) return option->expected;
        word += length + 1;
    }
}

static const char *set_number(const cli_option *option, const char *value, void *to) {
    const int is_whole = option->kind == CLI_INT || option->kind == CLI_SIZE;
    double number;
    if (!cli_number(value, &number) || number < option->least || number > option->most ||
        (is_whole && number != floor(number)))
        return option->expected;
    if (option->kind == CLI_INT)
        *(int *)to = (int)number;
    else if (option->kind == CLI_SIZE)
        *(size_t *)to = (size_t)number;
    else
        *(double *)to = option->kind == CLI_RADIANS ? cli_radians(number) : number;
    return NULL;
}

static const char *fill_setting(const cli_option *option, const char *value, void *to) {
    switch (option->kind) {
    case CLI_FLAG:
        *(int *)to = option->number;
        return NULL;
    case CLI_ONCE:
        if (*(const char **)to) return "to be given once";
        /* fall through */
    case CLI_TEXT:
        *(const char **)to = value;
        return option->expected && !value[0] ? option->expected : NULL;
    case CLI_CHOICE:
        return choose_word(option, value, to);
    case CLI_WEIGHT:
        return cli_find_weight(value, to);
    default:
        return set_number(option, value, to);
    }
}

/* NULL, or what was expected. */
static const char *set_option(const cli_option *option, void *settings, const char *value) {
    char *base = settings;
    if (option->kind == CLI_CALLS) return option->set(settings, value);
    void *given = base + option->given;
    const char *expected = fill_setting(option, value, base + option->at);
    if (option->bit) *(int *)given |= option->bit;
    return expected;
}

static int wants_value(const cli_option *option) {
    return option->kind == CLI_CALLS  ? option->takes_value
           : option->kind == CLI_FLAG ? CLI_NO_VALUE
                                      : CLI_VALUE;
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
    if (!option || (argument[1] != '-' && value && !wants_value(option)))
        return unknown_option(command, tables, table_count, argument);
    if (value && !wants_value(option))
        return cli_usage(command, "--%s takes no value", option->name);
    if (!value && wants_value(option) == CLI_VALUE) {
        if (*at + 1 >= count || is_option(tables, table_count, arguments[*at + 1]))
            return cli_usage(command, "%s needs a value", argument);
        value = arguments[++*at];
    }
    const char *expected = set_option(option, table->settings, value);
    char meant[CLI_LONGEST_WORD + 1];
    if (!expected) return CLI_OK;
    if (value && cli_suggest_listed(value, expected, meant))
        return cli_usage(command, "--%s '%s': expected %s; did you mean %s?", option->name, value,
            expected, meant);
    return value ? cli_usage(command, "--%s '%s': expected %s", option->name, value, expected)
                 : cli_usage(command, "--%s: %s", option->name, expected);
}

int cli_parse(const cli_subcommand *command, const cli_table *tables, size_t table_count, int count,
    char **arguments, cli_words *words) {
    int only_words = 0;
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

static const char *set_max_memory(void *settings, const char *value) {
    (void)settings; /* it is the process's */
    return cli_limit_memory(value);
}

const cli_option cli_common_options[] = {
    {"json", CLI_SETS(cli_common, json, 1)},
    {"max-memory", CLI_SET(set_max_memory)},
    {"quiet", CLI_SETS(cli_common, quiet, 1)},
    {"threads", CLI_TO(CLI_INT, cli_common, threads), .least = 1, .most = 65536,
        .expected = CLI_WHOLE_FROM_1},
};
const size_t cli_common_option_count = CLI_COUNT(cli_common_options);

/* ---- One matrix from --scale, --rotate, --translate and --matrix; the first given
 * acts first on the points. */

const cli_matrix cli_matrix_identity = {.matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};

int cli_is_affine(const cli_matrix *matrix) {
    const double *m = matrix->matrix;
    return m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1;
}

/* matrix = next * matrix, column-major. */
static void compose(cli_matrix *matrix, const double next[16]) {
    double product[16];
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += next[4 * k + row] * matrix->matrix[4 * column + k];
            product[4 * column + row] = sum;
            matrix->overflow |= !isfinite(sum);
        }
    memcpy(matrix->matrix, product, sizeof product);
    ++matrix->given;
}

static const char *compose_checked(cli_matrix *matrix, const double next[16]) {
    compose(matrix, next);
    return matrix->overflow
               ? "numbers for which the combined matrix stays within the range of doubles"
               : NULL;
}

static const char *set_scale(void *settings, const char *value) {
    double s[3], next[16];
    size_t count = cli_numbers(value, s, 3);
    if (count != 3 && count != 1) return "X,Y,Z or one number for all three, such as 2,1,1";
    memcpy(next, cli_matrix_identity.matrix, sizeof next);
    for (int i = 0; i < 3; ++i) next[5 * i] = s[count == 1 ? 0 : i];
    return compose_checked(settings, next);
}

static const char *set_translate(void *settings, const char *value) {
    double next[16];
    memcpy(next, cli_matrix_identity.matrix, sizeof next);
    if (cli_numbers(value, next + 12, 3) != 3) return "X,Y,Z, such as 0,0,10";
    return compose_checked(settings, next);
}

/* Quarter turns are exact, so that a rotation by 90 degrees leaves no 6e-17 behind. */
static void sine_cosine(double degrees, double *sine, double *cosine) {
    static const double exact[4][2] = {{0, 1}, {1, 0}, {0, -1}, {-1, 0}};
    double turned = fmod(degrees, 360), quarters = turned / 90;
    if (quarters == floor(quarters)) {
        const double *pair = exact[((int)quarters + 4) % 4];
        *sine = pair[0];
        *cosine = pair[1];
        return;
    }
    *sine = sin(cli_radians(turned));
    *cosine = cos(cli_radians(turned));
}

/* Rodrigues' formula about the unit axis: R = c I + s [u]x + (1 - c) u u^T. */
static const char *set_rotate(void *settings, const char *value) {
    static const char expected[] =
        "X,Y,Z,DEG: an axis that is not 0,0,0, and degrees, such as 0,1,0,90";
    double given[4], next[16], sine, cosine;
    if (cli_numbers(value, given, 4) != 4) return expected;
    double largest = fmax(fabs(given[0]), fmax(fabs(given[1]), fabs(given[2])));
    if (largest == 0) return expected;
    double x = given[0] / largest, y = given[1] / largest, z = given[2] / largest,
           length = sqrt(x * x + y * y + z * z);
    x /= length;
    y /= length;
    z /= length;
    sine_cosine(given[3], &sine, &cosine);
    const double rest = 1 - cosine;
    memcpy(next, cli_matrix_identity.matrix, sizeof next);
    next[0] = cosine + rest * x * x, next[4] = rest * x * y - sine * z,
    next[8] = rest * x * z + sine * y;
    next[1] = rest * y * x + sine * z, next[5] = cosine + rest * y * y,
    next[9] = rest * y * z - sine * x;
    next[2] = rest * z * x - sine * y, next[6] = rest * z * y + sine * x,
    next[10] = cosine + rest * z * z;
    return compose_checked(settings, next);
}

static const char *set_matrix(void *settings, const char *value) {
    double rows[16], next[16];
    if (cli_numbers(value, rows, 16) != 16)
        return "16 numbers, row by row, such as \"1 0 0 5  0 1 0 0  0 0 1 0  0 0 0 1\"";
    /* A translation in the last row and none in the last column. */
    if ((rows[12] != 0 || rows[13] != 0 || rows[14] != 0) && rows[15] == 1 && rows[3] == 0 &&
        rows[7] == 0 && rows[11] == 0)
        return "16 numbers row by row, the last row 0 0 0 1; column-major? transpose it";
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column) next[4 * column + row] = rows[4 * row + column];
    return compose_checked(settings, next);
}

const cli_option cli_matrix_options[] = {
    {"scale", CLI_SET(set_scale)},
    {"rotate", CLI_SET(set_rotate)},
    {"translate", CLI_SET(set_translate)},
    {"matrix", CLI_SET(set_matrix)},
};
const size_t cli_matrix_option_count = CLI_COUNT(cli_matrix_options);
