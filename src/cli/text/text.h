/* text.h: what the subcommands write: text from outside, JSON, numbers and words, terminals, the
 * description of a rule. */
#ifndef NORMA_CLI_TEXT_TEXT_H
#define NORMA_CLI_TEXT_TEXT_H
#include <norma/check.h>
#include <norma/document.h>
#include <norma/norma.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* ---- Text that came from outside (names in files, paths, what a message quotes) on its
 * way to a terminal or a report. It may hold anything: escape sequences that move the cursor or
 * rename the window, marks that reverse the direction of what follows, line ends that pretend to be
 * another line, bytes that are no UTF-8. All of that is shown as \x1B or \u202E instead. */

/* How many bytes the character at text takes (1 if it is not UTF-8, 0 at the end). *unsafe: 0 if it
 * may be written as it is, else its code point; for a byte that is not UTF-8 CLI_NOT_UTF8 plus it.
 */
#define CLI_NOT_UTF8 0x80000000u

int cli_is_utf8(const char *text);

void cli_write_outside(FILE *out, const char *text);
/* At most so many characters of it. */
void cli_write_outside_cut(FILE *out, const char *text, size_t most);
/* The same as text in HTML and in its attributes. */
void cli_write_outside_html(FILE *out, const char *text);
/* A help text; its commands, which begin with "norma ", are written as they can be pasted. */
void cli_help(FILE *out, const char *text);
void cli_write_base64(FILE *out, const unsigned char *bytes, size_t size);

#if defined(__GNUC__)
#define CLI_FORMAT(text, first) __attribute__((format(printf, text, first)))
#else
#define CLI_FORMAT(text, first)
#endif
/* printf, all of whose text counts as from outside; so format has no line end. */
CLI_FORMAT(2, 3) void cli_say(FILE *out, const char *format, ...);
CLI_FORMAT(2, 0) void cli_say_list(FILE *out, const char *format, va_list arguments);
/* A line on standard error: "norma: " and what cli_say would write. */
CLI_FORMAT(1, 2) void cli_error(const char *format, ...);

/* ---- Text gathered in memory, all of it or none. */

typedef struct cli_memory_stream {
    FILE *out;
    char *text; /* once closed: what was written to out, ended by a 0; the caller's to free */
    size_t size, room;
} cli_memory_stream;
/* The stream stays where it is while it is open. 0: out of memory. */
int cli_memory_open(cli_memory_stream *stream);
/* Whether all that was written is there; if not, text is NULL. */
int cli_memory_close(cli_memory_stream *stream);

/* ---- Reports for programs, one JSON object a line. */

typedef struct cli_json {
    FILE *out;
    int needs_comma;
} cli_json;
void cli_json_open(cli_json *into, const char *key, char bracket); /* key NULL within an array */
void cli_json_close(cli_json *into, char bracket);
/* text NULL: null. Bytes that are not UTF-8 become U+FFFD. */
void cli_json_string(cli_json *into, const char *key, const char *text);
void cli_json_size(cli_json *into, const char *key, size_t number);
/* Reads back as the same number; null if it is not finite. */
void cli_json_number(cli_json *into, const char *key, double number);
void cli_json_numbers(cli_json *into, const char *key, const double *numbers, size_t count);
void cli_json_bool(cli_json *into, const char *key, int value);
void cli_json_null(cli_json *into, const char *key);
void cli_json_raw(cli_json *into, const char *key, const char *text); /* which is JSON already */
/* Several at once, as the format shows them: "{path: %s, faces: %zu, where: [%g, %g], by: null}".
 * %s a text, %zu a count, %zd the same, where SIZE_MAX is null, %g a number, %d true or false; any
 * other word stands for itself. Brackets may be closed by another call. */
CLI_FORMAT(2, 3) void cli_json_print(cli_json *into, const char *format, ...);
char *cli_shortest(char text[32], double number); /* the fewest digits that read back as the same */

/* ---- JSON that was read. Strict: besides what RFC 8259 forbids, members that are there twice and
 * numbers beyond the range of doubles are faults. */

typedef struct cli_parsed cli_parsed;
typedef struct cli_value { /* a part of it, as long as that lives; in NULL: none */
    const cli_parsed *in;
    uint32_t at;
} cli_value;

typedef struct cli_json_fault {
    size_t line;
    const char *expected; /* NULL: out of memory */
    char near[24];        /* what stands there, cut; "" at the end */
} cli_json_fault;

cli_parsed *cli_json_parse(const char *text, size_t size, cli_json_fault *fault); /* NULL: fault */
void cli_json_free(cli_parsed *parsed);
cli_value cli_json_root(const cli_parsed *parsed);

/* Of no value, or one of another kind: none, 0 or NULL. */
int cli_is_object(cli_value value);
int cli_is_array(cli_value value);
int cli_is_true(cli_value value);
int cli_is_false(cli_value value);
cli_value cli_get(cli_value object, const char *key);
size_t cli_elements(cli_value array);
cli_value cli_element(cli_value array, uint32_t index);
cli_value cli_first(cli_value container); /* of an array or an object */
cli_value cli_next(cli_value value);      /* the one behind it in its container */
const char *cli_key(cli_value member);
const char *cli_string(cli_value value);
int cli_number_of(cli_value value, double *number);
int cli_count_of(cli_value value, size_t *count); /* whole, 0 to 2^53 */
/* As text, members sorted by their keys; to be freed. NULL: out of memory. */
char *cli_json_sorted(cli_value value);

/* FNV-1a (Fowler, Noll, Vo), 64 bits, of bytes behind others; CLI_HASH: of none. */
#define CLI_HASH UINT64_C(14695981039346656037)
uint64_t cli_hash(uint64_t before, const void *bytes, size_t size);

/* ---- What people read: counts, angles, names of weights and kinds. */

void cli_count(FILE *out, size_t count); /* 1,234 */
void cli_counted(FILE *out, size_t count, const char *one, const char *many);
/* The same behind other words; nothing where there are none. */
void cli_part(FILE *out, const char *before, size_t count, const char *one, const char *many);
/* The same as one of several causes: " (3 cancelled, 1 not finite". *written: one was before. */
void cli_cause(FILE *out, int *written, size_t count, const char *one, const char *many);
void cli_vertices(FILE *out, size_t before, size_t after); /* "; vertices 8 -> 24" */
/* Rounded to so many decimals, without trailing zeros. */
char *cli_decimals(char text[32], double number, int digits);
/* NULL, or what was expected instead. */
const char *cli_find_weight(const char *word, norma_weight *out);
const char *cli_kind_name(norma_kind kind);
const char *cli_severity_name(norma_severity severity); /* "error" */
norma_severity cli_find_severity(const char *name);     /* NONE: none is called so */
const char *cli_fix_name(norma_fix fix);                /* NULL: by hand */
extern const char *const cli_shading_names[];           /* of each norma_shading */
double cli_radians(double degrees);
double cli_to_degrees(double radians);
double cli_given_degrees(double radians); /* 60 where 60 was given: rounded to 1e-9 */

/* ---- What the report of a person's terminal may look like: colours, and lines that fit its
 * width. Whatever is read by a program gets neither. */

typedef enum cli_color_mode { CLI_COLOR_AUTO, CLI_COLOR_ALWAYS, CLI_COLOR_NEVER } cli_color_mode;

/* Auto: on a terminal that knows colours, unless NO_COLOR is set (no-color.org). */
int cli_wants_color(FILE *out, cli_color_mode mode);
/* Columns; 0: not a terminal, nothing is to be wrapped. */
size_t cli_terminal_width(FILE *out);

/* Words with line breaks before the last column, and an indent after each. Escape sequences of
 * colours take no column. Width 0: one line. No line end after the last. */
void cli_write_wrapped(FILE *out, const char *text, size_t width, int indent);

const norma_rule *cli_find_rule(const char *id); /* "N301"; NULL: none is called so */

/* ---- A rule in HTML: what it means, with a picture of wrong and one of right. */

void cli_write_rule_style(FILE *out); /* CSS, and once on a page the marks, which pictures use */
void cli_write_rule_marks(FILE *out);
/* An article whose id is the rule's; level: of its heading. */
void cli_write_rule_html(FILE *out, const norma_rule *rule, int level);
#endif
