/* read_json.c: JSON that a command reads: a configuration, a baseline, a report. Parsed by the
 * library's own reader (io/text), into a copy in which each string is decoded where it stands. */
#include "cli/text/text.h"
#include "io/text/text.h"
#include <math.h>
#include <stdlib.h>

struct cli_parsed {
    json tokens;
    char *text;
};

static const cli_value no_value = {NULL, JSON_NONE};

/* ---- parsing */

/* Lines begin between tokens only: a string has no line end until it is decoded. */
static size_t line_at(const json *tokens, size_t byte) {
    size_t line = 1, at = 0;
    for (uint32_t i = 0; i < tokens->count && tokens->tokens[i].start < byte; ++i) {
        if (tokens->tokens[i].type != JSON_STRING) continue;
        for (; at < tokens->tokens[i].start; ++at) line += tokens->text[at] == '\n';
        at = tokens->tokens[i].end;
    }
    for (; at < byte; ++at) line += tokens->text[at] == '\n';
    return line;
}

static int blame(cli_json_fault *fault, const json *tokens, size_t byte, const char *expected) {
    *fault = (cli_json_fault){.expected = expected};
    if (!expected) return 0;
    const size_t left = tokens->size - byte, room = sizeof fault->near - 1;
    memcpy(fault->near, tokens->text + byte, left < room ? left : room);
    fault->near[strcspn(fault->near, "\r\n")] = '\0';
    fault->line = line_at(tokens, byte);
    return 0;
}

static uint32_t hex_code(const char *digits) {
    char text[5] = {0};
    memcpy(text, digits, 4);
    return (uint32_t)strtoul(text, NULL, 16);
}

/* Whether each \u stands for a character that text can hold: no end of text, no half of a pair. */
static int has_characters(const char *at, const char *end) {
    for (; at < end; ++at) {
        if (*at != '\\' || *++at != 'u') continue;
        const uint32_t code = hex_code(at + 1);
        at += 4;
        if (code == 0 || (code >= 0xDC00 && code < 0xE000)) return 0;
        if (code < 0xD800 || code >= 0xE000) continue;
        const uint32_t low = end - at > 6 && at[1] == '\\' && at[2] == 'u' ? hex_code(at + 3) : 0;
        if (low < 0xDC00 || low >= 0xE000) return 0;
        at += 6;
    }
    return 1;
}

/* No longer than it was, so that it has room where it stands, with a 0 behind it. */
static int decode_string(cli_parsed *parsed, uint32_t token, cli_json_fault *fault) {
    const json_token *string = &parsed->tokens.tokens[token];
    json_span span;
    if (!has_characters(parsed->text + string->start + 1, parsed->text + string->end - 1))
        return blame(fault, &parsed->tokens, string->start,
            "a character, which \\u0000 and half of a pair are not");
    if (!norma_json_span(&parsed->tokens, token, &span)) return blame(fault, NULL, 0, NULL);
    if (span.owned) memcpy(parsed->text + string->start + 1, span.text, span.length);
    parsed->text[string->start + 1 + span.length] = '\0';
    free(span.owned);
    return 1;
}

static int check_scalars(cli_parsed *parsed, cli_json_fault *fault) {
    for (uint32_t i = 0; i < parsed->tokens.count; ++i) {
        double number = 0;
        norma_json_number(&parsed->tokens, i, &number);
        if (!isfinite(number))
            return blame(fault, &parsed->tokens, parsed->tokens.tokens[i].start,
                "a number within the range of doubles");
        if (parsed->tokens.tokens[i].type == JSON_STRING && !decode_string(parsed, i, fault))
            return 0;
    }
    return 1;
}

static int compare_texts(const void *a, const void *b) {
    const char *const *one = a, *const *other = b;
    const int order = strcmp(*one, *other);
    return order ? order : *one < *other ? -1 : *one > *other;
}

/* A member that is there twice would be read in one way here, in another elsewhere. keys: room for
 * all members of the object. */
static int check_keys(
    const cli_parsed *parsed, uint32_t object, const char **keys, cli_json_fault *fault) {
    size_t count = 0;
    for (cli_value v = cli_first((cli_value){parsed, object}); v.in; v = cli_next(v))
        keys[count++] = cli_key(v);
    qsort((void *)keys, count, sizeof *keys, compare_texts);
    for (size_t i = 1; i < count; ++i)
        if (strcmp(keys[i], keys[i - 1]) == 0)
            return blame(fault, &parsed->tokens, (size_t)(keys[i] - parsed->text),
                "each member of an object once");
    return 1;
}

static int check_objects(const cli_parsed *parsed, cli_json_fault *fault) {
    const json *tokens = &parsed->tokens;
    uint32_t most = 0;
    int fine = 1;
    for (uint32_t i = 0; i < tokens->count; ++i)
        if (norma_json_is(tokens, i, JSON_OBJECT) && tokens->tokens[i].size > most)
            most = tokens->tokens[i].size;
    const char **keys = calloc((size_t)most + 1, sizeof *keys);
    if (!keys) return blame(fault, NULL, 0, NULL);
    for (uint32_t i = 0; i < tokens->count && fine; ++i)
        if (norma_json_is(tokens, i, JSON_OBJECT)) fine = check_keys(parsed, i, keys, fault);
    free((void *)keys);
    return fine;
}

cli_parsed *cli_json_parse(const char *text, size_t size, cli_json_fault *fault) {
    json_error error;
    cli_parsed *parsed = calloc(1, sizeof *parsed);
    *fault = (cli_json_fault){0};
    if (parsed) parsed->text = malloc(size + 1);
    if (parsed && parsed->text) {
        memcpy(parsed->text, text, size);
        if (!norma_json_parse(parsed->text, size, NULL, &parsed->tokens, &error))
            blame(fault, &parsed->tokens, error.byte, error.expected);
        else if (check_scalars(parsed, fault) && check_objects(parsed, fault))
            return parsed;
    }
    cli_json_free(parsed);
    return NULL;
}

void cli_json_free(cli_parsed *parsed) {
    if (!parsed) return;
    norma_json_free(&parsed->tokens);
    free(parsed->text);
    free(parsed);
}

/* ---- asking */

static cli_value part_at(cli_value of, uint32_t token) {
    return token == JSON_NONE ? no_value : (cli_value){of.in, token};
}

static int is_kind(cli_value value, json_type type) {
    return value.in && norma_json_is(&value.in->tokens, value.at, type);
}

int cli_is_object(cli_value value) { return is_kind(value, JSON_OBJECT); }
int cli_is_array(cli_value value) { return is_kind(value, JSON_ARRAY); }
int cli_is_true(cli_value value) { return is_kind(value, JSON_TRUE); }
int cli_is_false(cli_value value) { return is_kind(value, JSON_FALSE); }

cli_value cli_json_root(const cli_parsed *parsed) { return (cli_value){parsed, 0}; }

size_t cli_elements(cli_value array) {
    return cli_is_array(array) ? norma_json_size(&array.in->tokens, array.at) : 0;
}

cli_value cli_first(cli_value container) {
    return cli_is_array(container) || cli_is_object(container)
               ? part_at(container, norma_json_first(&container.in->tokens, container.at))
               : no_value;
}

cli_value cli_next(cli_value value) {
    const json *tokens = &value.in->tokens;
    return part_at(value, norma_json_next(tokens, tokens->tokens[value.at].parent, value.at));
}

const char *cli_key(cli_value member) { return cli_string((cli_value){member.in, member.at - 1}); }

cli_value cli_get(cli_value object, const char *key) {
    cli_value value = cli_is_object(object) ? cli_first(object) : no_value;
    while (value.in && strcmp(cli_key(value), key) != 0) value = cli_next(value);
    return value;
}

cli_value cli_element(cli_value array, uint32_t index) {
    return array.in ? part_at(array, norma_json_element(&array.in->tokens, array.at, index))
                    : no_value;
}

const char *cli_string(cli_value value) {
    return is_kind(value, JSON_STRING)
               ? value.in->text + value.in->tokens.tokens[value.at].start + 1
               : NULL;
}

int cli_number_of(cli_value value, double *number) {
    return value.in && norma_json_number(&value.in->tokens, value.at, number);
}

int cli_count_of(cli_value value, size_t *count) {
    uint64_t number;
    if (!value.in || !norma_json_uint(&value.in->tokens, value.at, &number)) return 0;
    *count = (size_t)number;
    return 1;
}

/* ---- writing it again */

static int compare_members(const void *a, const void *b) {
    return strcmp(cli_key(*(const cli_value *)a), cli_key(*(const cli_value *)b));
}

static int write_sorted(cli_json *out, const char *key, cli_value value);

/* 0: out of memory. */
static int write_members(cli_json *out, cli_value object) {
    const json *tokens = &object.in->tokens;
    cli_value *members = calloc((size_t)norma_json_size(tokens, object.at) + 1, sizeof *members);
    size_t count = 0;
    int fine = members != NULL;
    for (cli_value v = cli_first(object); v.in && fine; v = cli_next(v)) members[count++] = v;
    if (fine) qsort(members, count, sizeof *members, compare_members);
    for (size_t i = 0; i < count && fine; ++i)
        fine = write_sorted(out, cli_key(members[i]), members[i]);
    free(members);
    return fine;
}

static int write_sorted(cli_json *out, const char *key, cli_value value) {
    int fine = 1;
    double number;
    if (cli_is_object(value) || cli_is_array(value)) {
        cli_json_open(out, key, cli_is_array(value) ? '[' : '{');
        if (cli_is_object(value)) fine = write_members(out, value);
        for (cli_value v = cli_is_array(value) ? cli_first(value) : no_value; v.in && fine;
             v = cli_next(v))
            fine = write_sorted(out, NULL, v);
        cli_json_close(out, cli_is_array(value) ? ']' : '}');
    } else if (cli_is_true(value) || cli_is_false(value)) {
        cli_json_bool(out, key, cli_is_true(value));
    } else if (cli_number_of(value, &number)) {
        cli_json_number(out, key, number);
    } else {
        cli_json_string(out, key, cli_string(value)); /* or null */
    }
    return fine;
}

char *cli_json_sorted(cli_value value) {
    cli_memory_stream text;
    if (!cli_memory_open(&text)) return NULL;
    cli_json out = {.out = text.out};
    const int fine = write_sorted(&out, NULL, value);
    if (cli_memory_close(&text) && fine) return text.text;
    free(text.text);
    return NULL;
}
