/* report_json.c: one JSON object a line, as RFC 8259 has it: always valid, whatever bytes a name
 * holds. */
#include "cli/common/cli.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How many bytes at text are one UTF-8 character (RFC 3629: no overlong forms, no surrogates, at
 * most U+10FFFF); 0: none are. */
static size_t utf8_length(const unsigned char *text) {
    unsigned char lead = text[0];
    if (lead < 0x80) return 1;
    size_t length = lead >= 0xC2 && lead < 0xE0   ? 2
                    : lead >= 0xE0 && lead < 0xF0 ? 3
                    : lead >= 0xF0 && lead < 0xF5 ? 4
                                                  : 0;
    for (size_t i = 1; i < length; ++i)
        if ((text[i] & 0xC0) != 0x80) return 0;
    if ((lead == 0xE0 && text[1] < 0xA0) || (lead == 0xED && text[1] > 0x9F) ||
        (lead == 0xF0 && text[1] < 0x90) || (lead == 0xF4 && text[1] > 0x8F))
        return 0;
    return length;
}

static void write_quoted(FILE *out, const char *text) {
    fputc('"', out);
    for (const unsigned char *at = (const unsigned char *)text; *at;) {
        size_t length = utf8_length(at);
        if (length == 0)
            fputs("\\ufffd", out);
        else if (*at == '"' || *at == '\\')
            fprintf(out, "\\%c", *at);
        else if (*at < 0x20 || *at == 0x7F)
            fprintf(out, "\\u%04x", *at);
        else
            fwrite(at, 1, length, out);
        at += length ? length : 1;
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
