/* report_json.c: one JSON object a line, as RFC 8259 has it: always valid, whatever bytes a name
 * holds. */
#include "cli/text/report_json.h"
#include "cli/text/outside_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

static void begin_value(cli_json *json, const char *key) {
    if (json->needs_comma) fputs(", ", json->out);
    json->needs_comma = 1;
    if (key) {
        write_quoted(json->out, key);
        fputs(": ", json->out);
    }
}

void cli_json_open(cli_json *json, const char *key, char bracket) {
    begin_value(json, key);
    fputc(bracket, json->out);
    json->needs_comma = 0;
}

void cli_json_close(cli_json *json, char bracket) {
    fputc(bracket, json->out);
    json->needs_comma = 1;
}

void cli_json_string(cli_json *json, const char *key, const char *text) {
    begin_value(json, key);
    if (text)
        write_quoted(json->out, text);
    else
        fputs("null", json->out);
}

void cli_json_size(cli_json *json, const char *key, size_t number) {
    begin_value(json, key);
    fprintf(json->out, "%zu", number);
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

void cli_json_number(cli_json *json, const char *key, double number) {
    char text[32];
    begin_value(json, key);
    fputs(isfinite(number) ? cli_shortest(text, number) : "null", json->out);
}

void cli_json_bool(cli_json *json, const char *key, int value) {
    begin_value(json, key);
    fputs(value ? "true" : "false", json->out);
}

void cli_json_null(cli_json *json, const char *key) {
    begin_value(json, key);
    fputs("null", json->out);
}
