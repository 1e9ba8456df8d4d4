/* The table of rules as the public sees it, and lists of rules by name; and the command that fixes
 * a finding, as a line for a POSIX shell (IEEE 1003.1, 2.2 Quoting). Names are quoted where a shell
 * would read more into them. Names with control characters, with bytes that are not UTF-8 or with
 * marks of direction go through printf, so that what a person sees is what is run. */
#include "check/findings/check_run.h"
#include "io/text/text.h"
#include <string.h>

static const norma_rule rules[] = {
#define RULE(id, name, render, print, fix, verb, validator, what, cause, why, how)                 \
    {#id, name, NORMA_SEVERITY_##render, NORMA_SEVERITY_##print, NORMA_FIX_##fix, verb, what,      \
        cause, why, how, validator},
#include "check/findings/rules.def"
#undef RULE
};

const norma_rule *norma_rules(size_t *count) {
    if (count) *count = sizeof rules / sizeof *rules;
    return rules;
}

/* What a generated model must not have. */
int norma_check_is_required(const norma_rule *rule) {
    static const char *const ids[] = {"N203", "N206", "N302", "N303", "N305", "N306", "N307"};
    for (size_t i = 0; i < sizeof ids / sizeof *ids; ++i)
        if (strcmp(rule->id, ids[i]) == 0) return 1;
    return 0;
}

norma_severity norma_rule_severity(const norma_rule *rule, norma_check_profile profile) {
    if (profile == NORMA_CHECK_PROFILE_PRINT) return rule->print;
    if (profile != NORMA_CHECK_PROFILE_GENERATED) return rule->render;
    const norma_severity graver = rule->render > rule->print ? rule->render : rule->print;
    return norma_check_is_required(rule) ? NORMA_SEVERITY_ERROR : graver;
}

static char lower(char c) { return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c; }

/* How many characters of text the word begins with: its length where it does. */
static int begins_with(const char *text, const char *word, size_t length) {
    for (size_t i = 0; i < length; ++i)
        if (!text[i] || lower(text[i]) != lower(word[i])) return 0;
    return 1;
}

/* A beginning of an id says at least its N, so that no word of another sense is taken for one. */
static int names_rule(const norma_rule *rule, const char *word, size_t length) {
    return (length > 0 && begins_with(rule->id, word, length)) ||
           (begins_with(rule->name, word, length) && !rule->name[length]);
}

static size_t select_word(const char *word, size_t length, uint8_t *mask) {
    size_t named = 0;
    for (size_t i = 0; i < CHECK_RULE_COUNT; ++i) {
        if (!names_rule(&rules[i], word, length)) continue;
        ++named;
        if (mask) mask[i] = 1;
    }
    return named;
}

static norma_result refuse_word(const char *word, size_t length, char unknown[64]) {
    if (unknown) {
        length = length < 63 ? length : 63;
        memcpy(unknown, word, length);
        unknown[length] = 0;
    }
    return NORMA_ERROR_ARGUMENT;
}

static int is_gap(char c) { return c == ' ' || c == '\t' || c == ','; }

/* mask NULL: only looks whether each word names a rule. */
static norma_result select_words(const char *list, uint8_t *mask, char unknown[64]) {
    while (*list) {
        size_t length = 0;
        while (list[length] && !is_gap(list[length])) ++length;
        if (length && !select_word(list, length, mask)) return refuse_word(list, length, unknown);
        list += length + (list[length] != 0);
    }
    return NORMA_OK;
}

norma_result norma_rules_select(const char *list, uint8_t *mask, char unknown[64]) {
    if (!list || !mask) return NORMA_ERROR_ARGUMENT;
    norma_result result = select_words(list, NULL, unknown);
    return result ? result : select_words(list, mask, unknown);
}

/* ---- the command that fixes a finding */

typedef struct command_line {
    char *text;
    size_t capacity, length; /* length: of all that was put, even if it does not fit */
} command_line;

static void put(command_line *line, const char *text, size_t length) {
    for (size_t i = 0; i < length; ++i, ++line->length)
        if (line->length + 1 < line->capacity) line->text[line->length] = text[i];
}

static void put_text(command_line *line, const char *text) { put(line, text, strlen(text)); }

/* ---- what can be read */

/* The bytes that can stand in a command as they are; 0: the next byte must be written by its
 * number. */
static size_t legible_length(const char *word) {
    uint32_t code;
    const size_t length = norma_utf8_take(word, SIZE_MAX, &code);
    return length && norma_utf8_is_legible(code) ? length : 0;
}

static int is_legible(const char *word, size_t length) {
    for (size_t i = 0, step; i < length; i += step)
        if ((step = legible_length(word + i)) == 0) return 0;
    return 1;
}

/* ---- quoting */

/* A word in pieces: "./" before a leading dash, the name, and up to three more. */
enum { PIECES = 5 };
typedef struct command_word {
    const char *text[PIECES];
    size_t length[PIECES];
} command_word;

static command_word begin_word(const char *name, size_t length) {
    return (command_word){{"./", name, "", "", ""}, {name[0] == '-' ? 2 : 0, length, 0, 0, 0}};
}

static int is_plain_word(const char *text, size_t length) {
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789@%_+=:,./-";
    return strspn(text, plain) >= length;
}

static void put_plain(command_line *line, const char *text, size_t length) {
    put(line, text, length);
}

static void put_between_quotes(command_line *line, const char *text, size_t length) {
    for (size_t i = 0; i < length; ++i)
        put_text(line, text[i] == '\'' ? "'\"'\"'" : (const char[]){text[i], '\0'});
}

/* In the format of printf each byte is itself, or \ and three octal digits. */
static void put_for_printf(command_line *line, const char *text, size_t length) {
    for (size_t i = 0, step; i < length; i += step) {
        const unsigned char byte = (unsigned char)text[i];
        step = legible_length(text + i);
        const int itself = step && (byte >= 0x80 || !strchr("'\\%", byte));
        const char octal[] = {'\\', (char)('0' + (byte >> 6)), (char)('0' + (byte >> 3 & 7)),
            (char)('0' + (byte & 7)), '\0'};
        step = itself ? step : 1;
        put(line, itself ? text + i : octal, itself ? step : sizeof octal - 1);
    }
}

static const struct quoting {
    int (*suits)(const char *text, size_t length);
    void (*put)(command_line *line, const char *text, size_t length);
    const char *begin, *end;
} quotings[] = {
    {is_plain_word, put_plain, "", ""},
    {is_legible, put_between_quotes, "'", "'"},
    {NULL, put_for_printf, "\"$(printf '", "')\""},
};

static int suits(const struct quoting *quoting, const command_word *word) {
    if (!quoting->suits) return 1;
    for (size_t i = 0; i < PIECES; ++i)
        if (!quoting->suits(word->text[i], word->length[i])) return 0;
    return 1;
}

static void put_pieces(command_line *line, const command_word *word) {
    const struct quoting *quoting = quotings;
    while (!suits(quoting, word)) ++quoting;
    put_text(line, quoting->begin);
    for (size_t i = 0; i < PIECES; ++i) quoting->put(line, word->text[i], word->length[i]);
    put_text(line, quoting->end);
}

static void put_word(command_line *line, const char *name) {
    const command_word word = begin_word(name, strlen(name));
    put_pieces(line, &word);
}

/* A word that is an option stays one. */
static void put_option(command_line *line, const char *option) {
    if (option[0] == '-')
        put_text(line, option);
    else
        put_word(line, option);
}

/* The format that the options name. */
static const char *input_format(const char *const *options) {
    for (; options && *options; ++options)
        if (strcmp(*options, "--input-format") == 0) return options[1];
    return NULL;
}

/* chair.glb: chair.fixed.glb, beside it. The ending says the format. */
static void put_output(command_line *line, const char *path, const char *const *options) {
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path,
               *dot = strrchr(name, '.'), *format = input_format(options);
    const int is_known = norma_file_format_of_path(path) != NORMA_FILE_UNKNOWN;
    const char *ends[] = {
        ".fixed", format && !is_known ? "." : "", format && !is_known ? format : ""};
    size_t length = strlen(path);
    if (dot && dot > name && !ends[1][0]) {
        length = (size_t)(dot - path);
        ends[1] = dot;
    }
    command_word word = begin_word(path, length);
    for (size_t i = 0; i < sizeof ends / sizeof *ends; ++i) {
        word.text[2 + i] = ends[i];
        word.length[2 + i] = strlen(ends[i]);
    }
    put_pieces(line, &word);
}

/* chair.glb: chair.glb.html, since chair.html may be the report. */
static void put_view(command_line *line, const char *path) {
    command_word page = begin_word(path, strlen(path));
    page.text[2] = ".html", page.length[2] = strlen(page.text[2]);
    put_text(line, "norma view "); /* which the npm package has not */
    put_word(line, path);
    put_text(line, " -o ");
    put_pieces(line, &page);
}

static void put_fix(command_line *line, const norma_finding *finding, const char *path,
    const char *const *options) {
    put_text(line, NORMA_PROGRAM " check ");
    put_word(line, path);
    put_text(line, finding->fix == NORMA_FIX_SAFE ? " --fix --select " : " --fix-unsafe --select ");
    put_text(line, finding->rule->id);
    for (const char *const *option = options; option && *option; ++option) {
        put_text(line, " ");
        put_option(line, *option);
    }
    put_text(line, " -o ");
    put_output(line, path, options);
}

size_t norma_finding_command(const norma_finding *finding, const char *path,
    const char *const *options, char *command, size_t capacity) {
    command_line line = {command, command ? capacity : 0, 0};
    if (line.capacity) command[0] = '\0';
    if (!path || (finding && finding->fix == NORMA_FIX_NONE) || strcmp(path, "-") == 0) return 0;
    if (finding)
        put_fix(&line, finding, path, options);
    else
        put_view(&line, path);
    if (line.capacity)
        command[line.length < line.capacity ? line.length : line.capacity - 1] = '\0';
    return line.length;
}
