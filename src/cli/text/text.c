/* What the subcommands write: text from outside, JSON, words, rules as pages. */
#define _GNU_SOURCE
#include "cli/text/text.h"
#include "io/text/text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

/* ---- One function decides what of a text from outside may be written as it is; the
 * others write the rest as escapes. */

static size_t cli_next_character(const char *text, uint32_t *unsafe) {
    uint32_t code;
    *unsafe = 0;
    if (!*text) return 0;
    const size_t length = norma_utf8_take(text, SIZE_MAX, &code);
    if (length == 0)
        *unsafe = CLI_NOT_UTF8 + (unsigned char)*text;
    else if (!norma_utf8_is_legible(code))
        *unsafe = code;
    return length ? length : 1;
}

static void write_character(FILE *out, const char *at, size_t length, uint32_t unsafe) {
    if (!unsafe)
        fwrite(at, 1, length, out);
    else if (unsafe < 0x100 || unsafe >= CLI_NOT_UTF8)
        fprintf(out, "\\x%02X", (unsigned)(unsafe & 0xFF));
    else
        fprintf(out, "\\u%04X", (unsigned)unsafe);
}

int cli_is_utf8(const char *text) {
    uint32_t unsafe;
    for (size_t length; (length = cli_next_character(text, &unsafe)); text += length)
        if (unsafe >= CLI_NOT_UTF8) return 0;
    return 1;
}

void cli_write_outside_cut(FILE *out, const char *text, size_t most) {
    uint32_t unsafe;
    for (size_t length; most-- && (length = cli_next_character(text, &unsafe)); text += length)
        write_character(out, text, length, unsafe);
}

void cli_write_outside(FILE *out, const char *text) { cli_write_outside_cut(out, text, SIZE_MAX); }

void cli_write_outside_html(FILE *out, const char *text) {
    uint32_t unsafe;
    for (size_t length; (length = cli_next_character(text, &unsafe)); text += length) {
        const char *entity = *text == '&'   ? "&amp;"
                             : *text == '<' ? "&lt;"
                             : *text == '>' ? "&gt;"
                             : *text == '"' ? "&quot;"
                                            : NULL;
        if (entity)
            fputs(entity, out);
        else
            write_character(out, text, length, unsafe);
    }
}

/* Most lines fit; a longer one is written whole if there is memory for it, else cut. */
void cli_say_list(FILE *out, const char *format, va_list arguments) {
    char brief[1024], *text = brief;
    va_list again;
    va_copy(again, arguments);
    const int length = vsnprintf(brief, sizeof brief, format, arguments);
    if (length >= (int)sizeof brief && (text = malloc((size_t)length + 1)))
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    if (length >= 0) cli_write_outside(out, text ? text : brief);
    if (text != brief) free(text);
}

void cli_say(FILE *out, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    cli_say_list(out, format, arguments);
    va_end(arguments);
}

void cli_error(const char *format, ...) {
    va_list arguments;
    flockfile(stderr); /* threads report at the same time */
    fputs("norma: ", stderr);
    va_start(arguments, format);
    cli_say_list(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    funlockfile(stderr);
}

void cli_help(FILE *out, const char *text) {
    static const char name[] = "norma ";
    for (const char *found; (found = strstr(text, name)); text = found + strlen(name))
        fprintf(out, "%.*s%s ", (int)(found - text), text, NORMA_PROGRAM);
    fputs(text, out);
}

void cli_write_base64(FILE *out, const unsigned char *bytes, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char text[4 * 1024];
    size_t length = 0;
    for (size_t i = 0; i < size; i += 3) {
        const size_t left = size - i;
        const unsigned long three = (unsigned long)bytes[i] << 16 |
                                    (left > 1 ? (unsigned long)bytes[i + 1] << 8 : 0) |
                                    (left > 2 ? bytes[i + 2] : 0);
        text[length++] = digits[three >> 18];
        text[length++] = digits[three >> 12 & 63];
        text[length++] = left > 1 ? digits[three >> 6 & 63] : '=';
        text[length++] = left > 2 ? digits[three & 63] : '=';
        if (length == sizeof text) {
            fwrite(text, 1, length, out);
            length = 0;
        }
    }
    fwrite(text, 1, length, out);
}

/* ---- Text gathered in memory, all of it or none. The C library's own memory streams
 * do not always tell when they could not grow (glibc 2.36 cuts the text there, without an error),
 * so where streams with functions of one's own exist, growing is done here. */

#if defined(__linux__)
static ssize_t append(void *user, const char *bytes, size_t count) {
    cli_memory_stream *stream = user;
    if (count >= stream->room - stream->size) {
        size_t room = stream->room;
        while (count >= room - stream->size) room *= 2; /* one byte for the end */
        char *text = realloc(stream->text, room);
        if (!text) return 0; /* sets the stream's error */
        stream->text = text;
        stream->room = room;
    }
    memcpy(stream->text + stream->size, bytes, count);
    stream->size += count;
    return (ssize_t)count;
}

int cli_memory_open(cli_memory_stream *stream) {
    *stream = (cli_memory_stream){.room = 4096};
    stream->text = malloc(stream->room);
    stream->out =
        stream->text ? fopencookie(stream, "w", (cookie_io_functions_t){.write = append}) : NULL;
    if (!stream->out) {
        free(stream->text);
        stream->text = NULL;
    }
    return stream->out != NULL;
}
#else
int cli_memory_open(cli_memory_stream *stream) {
    *stream = (cli_memory_stream){.out = NULL};
    stream->out = open_memstream(&stream->text, &stream->size);
    return stream->out != NULL;
}
#endif

int cli_memory_close(cli_memory_stream *stream) {
    if (!stream->out) return 0;
    const int gathered = !fflush(stream->out) && !ferror(stream->out),
              closed = fclose(stream->out) == 0;
    stream->out = NULL;
    if (gathered && closed && stream->text) {
#if defined(__linux__)
        stream->text[stream->size] = '\0';
#endif
        return 1;
    }
    free(stream->text);
    stream->text = NULL;
    return 0;
}

/* ---- One JSON object a line, as RFC 8259 has it: always valid, whatever bytes a name
 * holds. */

/* Most text is nothing but ASCII that stands as it is; these bytes go out together. */
static size_t plain_length(const char *text) {
    size_t length = 0;
    while (
        text[length] >= ' ' && text[length] <= '~' && text[length] != '"' && text[length] != '\\')
        ++length;
    return length;
}

static void write_quoted(FILE *out, const char *text) {
    uint32_t unsafe;
    fputc('"', out);
    for (size_t length; *text; text += length) {
        length = plain_length(text);
        if (length) {
            fwrite(text, 1, length, out);
            continue;
        }
        length = cli_next_character(text, &unsafe);
        if (unsafe)
            fprintf(out, "\\u%04x", unsafe >= CLI_NOT_UTF8 ? 0xFFFDu : (unsigned)unsafe);
        else if (*text == '"' || *text == '\\')
            fprintf(out, "\\%c", *text);
        else
            fwrite(text, 1, length, out);
    }
    fputc('"', out);
}

static void begin_value(cli_json *into, const char *key) {
    if (into->needs_comma) fputs(", ", into->out);
    into->needs_comma = 1;
    if (key) {
        write_quoted(into->out, key);
        fputs(": ", into->out);
    }
}

void cli_json_open(cli_json *into, const char *key, char bracket) {
    begin_value(into, key);
    fputc(bracket, into->out);
    into->needs_comma = 0;
}

void cli_json_close(cli_json *into, char bracket) {
    fputc(bracket, into->out);
    into->needs_comma = 1;
}

void cli_json_string(cli_json *into, const char *key, const char *text) {
    begin_value(into, key);
    if (text)
        write_quoted(into->out, text);
    else
        fputs("null", into->out);
}

void cli_json_size(cli_json *into, const char *key, size_t number) {
    begin_value(into, key);
    fprintf(into->out, "%zu", number);
}

char *cli_shortest(char text[32], double number) {
    if (fabs(number) < 1e15 && number == floor(number)) { /* %.15g would write all digits */
        snprintf(text, 32, "%lld", (long long)number);
        return text;
    }
    for (int digits = 15; digits <= 17; ++digits) {
        snprintf(text, 32, "%.*g", digits, number + 0.0); /* + 0: no "-0" */
        if (strtod(text, NULL) == number) break;
    }
    return text;
}

void cli_json_number(cli_json *into, const char *key, double number) {
    char text[32];
    begin_value(into, key);
    fputs(isfinite(number) ? cli_shortest(text, number) : "null", into->out);
}

void cli_json_numbers(cli_json *into, const char *key, const double *numbers, size_t count) {
    cli_json_open(into, key, '[');
    for (size_t i = 0; i < count; ++i) cli_json_number(into, NULL, numbers[i]);
    cli_json_close(into, ']');
}

void cli_json_bool(cli_json *into, const char *key, int value) {
    begin_value(into, key);
    fputs(value ? "true" : "false", into->out);
}

void cli_json_null(cli_json *into, const char *key) { cli_json_raw(into, key, "null"); }

void cli_json_raw(cli_json *into, const char *key, const char *text) {
    begin_value(into, key);
    fputs(text, into->out);
}

/* at: behind the %; what follows it. */
static const char *print_value(
    cli_json *into, const char *key, const char *at, va_list *arguments) {
    const int is_size = *at == 'z';
    at += is_size;
    const size_t count = is_size ? va_arg(*arguments, size_t) : 0;
    if (*at == 'd' && count == SIZE_MAX)
        cli_json_null(into, key);
    else if (is_size)
        cli_json_size(into, key, count);
    else if (*at == 's')
        cli_json_string(into, key, va_arg(*arguments, const char *));
    else if (*at == 'g')
        cli_json_number(into, key, va_arg(*arguments, double));
    else
        cli_json_bool(into, key, va_arg(*arguments, int));
    return at + 1;
}

void cli_json_print(cli_json *into, const char *format, ...) {
    char name[64];
    const char *key = NULL; /* of the next value */
    va_list arguments;
    va_start(arguments, format);
    for (const char *at = format; *at;) {
        const size_t length = strcspn(at, ":, {}[]%\n");
        if (length && at[length] == ':') {
            snprintf(name, sizeof name, "%.*s", (int)length, at);
            key = name;
            at += length + 1;
        } else if (length) {
            begin_value(into, key);
            fwrite(at, 1, length, into->out);
            key = NULL;
            at += length;
        } else if (*at == '%') {
            at = print_value(into, key, at + 1, &arguments);
            key = NULL;
        } else {
            if (*at == '{' || *at == '[') cli_json_open(into, key, *at), key = NULL;
            if (*at == '}' || *at == ']') cli_json_close(into, *at);
            if (*at == '\n') fputc('\n', into->out);
            ++at;
        }
    }
    va_end(arguments);
}

/* ---- What people read: counts with commas, angles without noise, names of weights and
 * kinds. */

void cli_count(FILE *out, size_t count) {
    char digits[32];
    int length = snprintf(digits, sizeof digits, "%zu", count);
    for (int i = 0; i < length; ++i) {
        if (i > 0 && (length - i) % 3 == 0) fputc(',', out);
        fputc(digits[i], out);
    }
}

void cli_counted(FILE *out, size_t count, const char *one, const char *many) {
    cli_count(out, count);
    fprintf(out, " %s", count == 1 ? one : many);
}

void cli_part(FILE *out, const char *before, size_t count, const char *one, const char *many) {
    if (!count) return;
    fputs(before, out);
    cli_counted(out, count, one, many);
}

void cli_cause(FILE *out, int *written, size_t count, const char *one, const char *many) {
    cli_part(out, *written ? ", " : " (", count, one, many);
    *written |= count > 0;
}

void cli_vertices(FILE *out, size_t before, size_t after) {
    fputs(before == after ? "; " : "; vertices ", out);
    if (before == after) {
        cli_counted(out, before, "vertex", "vertices");
        fputs(", none added", out);
        return;
    }
    cli_count(out, before);
    fputs(" -> ", out);
    cli_count(out, after);
}

char *cli_decimals(char text[32], double number, int digits) {
    snprintf(text, 32, "%.*f", digits, number);
    if (strchr(text, '.')) {
        size_t length = strlen(text);
        while (text[length - 1] == '0') --length;
        if (text[length - 1] == '.') --length;
        text[length] = '\0';
    }
    return strcmp(text, "-0") == 0 ? strcpy(text, "0") : text;
}

uint64_t cli_hash(uint64_t before, const void *bytes, size_t size) {
    const unsigned char *at = bytes;
    uint64_t hash = before;
    for (size_t i = 0; i < size; ++i) hash = (hash ^ at[i]) * UINT64_C(1099511628211);
    return hash;
}

static const double PI = 3.14159265358979323846;

double cli_radians(double degrees) { return degrees * (PI / 180); }

double cli_to_degrees(double radians) { return radians * (180 / PI); }

double cli_given_degrees(double radians) { return round(cli_to_degrees(radians) * 1e9) / 1e9; }

const char *cli_find_weight(const char *word, norma_weight *out) {
    const char *name;
    for (int weight = 0; (name = norma_weight_name((norma_weight)weight)) != NULL; ++weight)
        if (strcmp(word, name) == 0) {
            *out = (norma_weight)weight;
            return NULL;
        }
    return "angle, area, uniform, max, angle-area, visible or angle-lengths";
}

static const char *const severity_names[] = {"none", "info", "warning", "error"};

const char *cli_severity_name(norma_severity severity) { return severity_names[severity]; }

norma_severity cli_find_severity(const char *name) {
    int severity = NORMA_SEVERITY_ERROR;
    while (severity && !(name && strcmp(name, severity_names[severity]) == 0)) --severity;
    return (norma_severity)severity;
}

const char *cli_kind_name(norma_kind kind) {
    static const char *const names[] = {"identity", "translation", "rotation", "uniform-scale",
        "non-uniform-scale", "shear", "singular"};
    return names[kind];
}

const char *const cli_shading_names[] = {"default", "crease", "smooth", "flat"};

const char *cli_fix_name(norma_fix fix) {
    static const char *const names[] = {NULL, "safe", "unsafe"};
    return names[fix];
}

/* ---- Colours by the wish of the user, the environment and the terminal; words wrapped at
 * its width. */

static int is_terminal(FILE *out) { return isatty(fileno(out)); }

int cli_wants_color(FILE *out, cli_color_mode mode) {
    if (mode != CLI_COLOR_AUTO) return mode == CLI_COLOR_ALWAYS;
    const char *kind = getenv("TERM"), *without = getenv("NO_COLOR");
    return is_terminal(out) && kind && strcmp(kind, "dumb") != 0 && !(without && *without);
}

/* A width that is not known, or too small to be read in, counts as the usual one. */
size_t cli_terminal_width(FILE *out) {
    enum { USUAL = 80, LEAST = 40 };
    struct winsize size = {0};
    if (!is_terminal(out)) return 0;
    if (ioctl(fileno(out), TIOCGWINSZ, &size)) size.ws_col = 0;
    const char *columns = getenv("COLUMNS");
    const size_t width = size.ws_col ? size.ws_col : columns ? strtoul(columns, NULL, 10) : 0;
    return width >= LEAST ? width : USUAL;
}

/* Columns of the first bytes of text: characters of UTF-8, without sequences such as "\033[1m". */
static size_t columns_of(const char *text, size_t bytes) {
    size_t columns = 0;
    for (size_t i = 0; i < bytes; ++i) {
        if (text[i] == '\033')
            while (i + 1 < bytes && text[i] != 'm') ++i;
        else
            columns += ((unsigned char)text[i] & 0xC0) != 0x80;
    }
    return columns;
}

void cli_write_wrapped(FILE *out, const char *text, size_t width, int indent) {
    size_t column = 0;
    while (*text) {
        size_t blanks = strspn(text, " "), length = strcspn(text + blanks, " ");
        size_t columns = columns_of(text + blanks, length);
        if (width && column && column + blanks + columns > width) {
            fprintf(out, "\n%*s", indent, "");
            column = (size_t)indent;
            text += blanks;
            blanks = 0;
        }
        fwrite(text, 1, blanks + length, out);
        column += blanks + columns;
        text += blanks + length;
    }
}

typedef struct rule_picture {
    const char *id, *wrong, *right;
} rule_picture;

static const rule_picture pictures[] = {
#define PICTURE(id, wrong, right) {#id, wrong, right},
#include "cli/text/rule_pictures.def"
#undef PICTURE
};

void cli_write_rule_style(FILE *out) {
    fputs(
        ".meaning{border-top:1px solid var(--line,#8886);padding:.6rem 0}.meaning "
        "h3{font-size:1rem;"
        "margin:0}.meaning p{margin:.3rem "
        "0}.pair{display:flex;flex-wrap:wrap;gap:1rem;margin:.4rem "
        "0}.pair figure{margin:0}.pair figcaption{font-size:.85rem}.pair "
        "svg{width:180px;height:auto;"
        "background:#f2f4f7;border-radius:6px;font:11px sans-serif}\n"
        ".pair path{fill:none;stroke:#333;stroke-width:1.5;stroke-linecap:round;stroke-linejoin:"
        "round}.pair .f{fill:#c9d3df}.pair .g{fill:#dfe6ee}.pair "
        ".e{fill:#f5b5ae;stroke:#b3261e}.pair "
        ".s{stroke-width:2.5}.pair .h{stroke:#555;stroke-width:1}.pair "
        ".r{stroke:#b3261e;stroke-width:"
        "2.5}.pair .n{stroke:#0b57d0;stroke-width:2;marker-end:url(#norma-good)}.pair .x{stroke:"
        "#b3261e;stroke-width:2;marker-end:url(#norma-bad)}.pair .o{stroke:#0b57d0;stroke-width:6}"
        ".pair .b{stroke:#b3261e;stroke-width:8}.pair text{fill:#222}.pair .V{fill:#a01a12}\n",
        out);
}

void cli_write_rule_marks(FILE *out) {
    static const char *const marks[][2] = {{"norma-good", "#0b57d0"}, {"norma-bad", "#b3261e"}};
    fputs("<svg width=\"0\" height=\"0\" aria-hidden=\"true\" style=\"position:absolute\"><defs>",
        out);
    for (size_t i = 0; i < sizeof marks / sizeof *marks; ++i)
        fprintf(out,
            "<marker id=\"%s\" viewBox=\"0 0 8 8\" refX=\"5\" refY=\"4\" markerWidth=\"4\" "
            "markerHeight=\"4\" orient=\"auto\"><path d=\"M0 0L8 4L0 8z\" fill=\"%s\"/></marker>",
            marks[i][0], marks[i][1]);
    fputs("</defs></svg>\n", out);
}

/* "T 40 80 words": at (40, 80). */
static void write_words(FILE *out, char class, const char *text, size_t length) {
    int x = 0, y = 0, used = 0;
    if (sscanf(text, "%d %d %n", &x, &y, &used) < 2 || (size_t)used > length) return;
    fprintf(out, "<text class=\"%c\" x=\"%d\" y=\"%d\">", class, x, y);
    for (size_t i = (size_t)used; i < length; ++i)
        fputs(text[i] == '<' ? "&lt;" : (const char[]){text[i], '\0'}, out);
    fputs("</text>", out);
}

static void write_drawing(FILE *out, const char *drawing) {
    while (*drawing) {
        const size_t length = strcspn(drawing, ";");
        if (drawing[0] == 'T' || drawing[0] == 'V')
            write_words(out, drawing[0], drawing + 2, length - 2);
        else
            fprintf(
                out, "<path class=\"%c\" d=\"%.*s\"/>", drawing[0], (int)length - 2, drawing + 2);
        drawing += length + (drawing[length] == ';');
    }
}

static void write_figure(FILE *out, const norma_rule *rule, const char *word, const char *drawing) {
    fprintf(out, "<figure><svg viewBox=\"0 0 150 90\" role=\"img\" aria-label=\"%s: %s\">",
        rule->name, word);
    write_drawing(out, drawing);
    fprintf(out, "</svg><figcaption>%s</figcaption></figure>\n", word);
}

static void write_pictures(FILE *out, const norma_rule *rule) {
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; ++i) {
        if (strcmp(pictures[i].id, rule->id) != 0) continue;
        fputs("<div class=\"pair\">\n", out);
        write_figure(out, rule, "Wrong", pictures[i].wrong);
        write_figure(out, rule, "Right", pictures[i].right);
        fputs("</div>\n", out);
    }
}

static void write_html_paragraph(FILE *out, const char *label, const char *text) {
    fprintf(out, "<p>%s", label);
    cli_write_outside_html(out, text);
    fputs("</p>\n", out);
}

const norma_rule *cli_find_rule(const char *id) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t i = 0; i < count; ++i)
        if (strcmp(rules[i].id, id) == 0) return &rules[i];
    return NULL;
}

void cli_write_rule_html(FILE *out, const norma_rule *rule, int level) {
    fprintf(out, "<article class=\"meaning\" id=\"%s\"><h%d>%s %s</h%d>\n", rule->id, level,
        rule->id, rule->name, level);
    write_pictures(out, rule);
    write_html_paragraph(out, "", rule->what);
    write_html_paragraph(out, "Usual cause: ", rule->cause);
    write_html_paragraph(out, "", rule->why);
    write_html_paragraph(out, "", rule->how);
    fputs("</article>\n", out);
}
