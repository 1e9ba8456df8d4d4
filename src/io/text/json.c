/* json.c: JSON: numbers and strings as they stand in it, and its text as tokens. */
#include "io/text/text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- How numbers and strings stand in JSON. */

void norma_json_add(json_text *text, const char *bytes, size_t size) {
    norma_io_append(text, bytes, size);
}

void norma_json_add_text(json_text *text, const char *terminated) {
    norma_json_add(text, terminated, strlen(terminated));
}

void norma_json_add_uint(json_text *text, uint64_t value) {
    char digits[20];
    norma_json_add(text, digits, norma_number_format_integer(value, digits));
}

void norma_json_add_number(json_text *text, double value) {
    char digits[32];
    norma_json_add(text, digits, norma_number_format_double(value, digits));
}

void norma_json_add_float(json_text *text, float value) {
    char digits[32];
    norma_json_add(text, digits, norma_number_format_float(value, digits));
}

void norma_json_add_quoted(json_text *text, const char *utf8) {
    norma_json_add(text, "\"", 1);
    for (; *utf8; ++utf8) {
        unsigned char c = (unsigned char)*utf8;
        if (c == '"' || c == '\\') {
            const char escape[2] = {'\\', (char)c};
            norma_json_add(text, escape, 2);
        } else if (c < 0x20) {
            static const char hex[] = "0123456789abcdef";
            const char escape[6] = {'\\', 'u', '0', '0', hex[c >> 4], hex[c & 15]};
            norma_json_add(text, escape, 6);
        } else {
            norma_json_add(text, utf8, 1);
        }
    }
    norma_json_add(text, "\"", 1);
}

void norma_json_add_key(json_text *text, const char *key) {
    if (text->size && text->data[text->size - 1] != '{') norma_json_add_text(text, ",");
    norma_json_add_quoted(text, key);
    norma_json_add_text(text, ":");
}

void norma_json_add_uint_member(json_text *text, const char *key, uint64_t number) {
    norma_json_add_key(text, key);
    norma_json_add_uint(text, number);
}

/* ---- Strict JSON (RFC 8259) into tokens that say where each value lies. One pass, no
 * recursion, depth bounded. Our own rather than jsmn: that one lets through wrong separators, bad
 * numbers and rubbish behind the end even in its strict mode, and checking for them afterwards is a
 * second parser. */

typedef struct parser {
    const char *text;
    size_t size, at;
    json *out;
    size_t capacity;
    uint32_t parent, depth;
    json_error *error;
    norma_watch *watch;
    const void *asked; /* where it was last asked whether to go on */
} parser;

static int json_is_cancelled(parser *p) {
    return norma_watch_passed(p->watch, &p->asked, p->text + p->at);
}

static int json_fail(parser *p, const char *expected) {
    p->error->byte = p->at;
    p->error->expected = expected;
    return 0;
}

static int json_peek(const parser *p) {
    return p->at < p->size ? (unsigned char)p->text[p->at] : -1;
}

static void skip_space(parser *p) {
    while (p->at < p->size &&
           (p->text[p->at] == ' ' || p->text[p->at] == '\n' || p->text[p->at] == '\r' ||
               p->text[p->at] == '\t') &&
           (p->at % WATCH_BYTES != 0 || !json_is_cancelled(p)))
        ++p->at;
}

static json_token *add_token(parser *p, json_type type) {
    json *out = p->out;
    json_token *grown = out->count < UINT32_MAX / 2 ? norma_io_grow(out->tokens, &p->capacity,
                                                          (size_t)out->count + 1, sizeof *grown)
                                                    : NULL;
    if (!grown) return NULL;
    out->tokens = grown;
    json_token *token = &out->tokens[out->count++];
    *token = (json_token){
        .start = p->at, .end = p->at, .parent = p->parent, .next = out->count, .type = type};
    return token;
}

static int json_is_digit(int c) { return c >= '0' && c <= '9'; }

int norma_hex_value(int c) {
    if (json_is_digit(c)) return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static int skip_digits(parser *p) {
    if (!json_is_digit(json_peek(p))) return json_fail(p, "a digit");
    while (json_is_digit(json_peek(p))) ++p->at;
    return 1;
}

static int skip_number(parser *p) {
    if (json_peek(p) == '-') ++p->at;
    if (json_peek(p) == '0')
        ++p->at;
    else if (!skip_digits(p))
        return 0;
    if (json_peek(p) == '.') {
        ++p->at;
        if (!skip_digits(p)) return 0;
    }
    if (json_peek(p) == 'e' || json_peek(p) == 'E') {
        ++p->at;
        if (json_peek(p) == '+' || json_peek(p) == '-') ++p->at;
        return skip_digits(p);
    }
    return 1;
}

static int skip_escape(parser *p) {
    int c = json_peek(p);
    if (c == 'u') {
        for (int i = 1; i <= 4; ++i)
            if (p->at + (size_t)i >= p->size ||
                norma_hex_value((unsigned char)p->text[p->at + (size_t)i]) < 0)
                return json_fail(p, "four hexadecimal digits after \\u");
        p->at += 5;
        return 1;
    }
    if (c < 0 || !strchr("\"\\/bfnrt", c) || c == 0)
        return json_fail(p, "one of \"\\/bfnrtu after a backslash");
    ++p->at;
    return 1;
}

static int skip_string(parser *p) {
    ++p->at;
    for (size_t bytes = 1; p->at < p->size; ++bytes) {
        if (bytes % WATCH_BYTES == 0 && json_is_cancelled(p)) break;
        unsigned char c = (unsigned char)p->text[p->at];
        if (c == '"') {
            ++p->at;
            return 1;
        }
        if (c < 0x20) return json_fail(p, "no control character in a string");
        if (c == '\\') {
            ++p->at;
            if (!skip_escape(p)) return 0;
            continue;
        }
        uint32_t code;
        size_t length = c < 0x80 ? 1 : norma_utf8_take(p->text + p->at, p->size - p->at, &code);
        if (length == 0) return json_fail(p, "valid UTF-8");
        p->at += length;
    }
    return json_fail(p, "the closing quote of a string");
}

static int skip_word(parser *p, const char *word) {
    size_t length = strlen(word);
    if (p->size - p->at < length || memcmp(p->text + p->at, word, length) != 0)
        return json_fail(p, "a value");
    p->at += length;
    return 1;
}

/* A value that is no container. */
static int parse_scalar(parser *p) {
    int c = json_peek(p);
    json_type type = c == '"'   ? JSON_STRING
                     : c == 't' ? JSON_TRUE
                     : c == 'f' ? JSON_FALSE
                     : c == 'n' ? JSON_NULL
                                : JSON_NUMBER;
    if (type == JSON_NUMBER && c != '-' && !json_is_digit(c)) return json_fail(p, "a value");
    uint32_t number = p->out->count;
    if (!add_token(p, type)) return json_fail(p, NULL);
    int ok = type == JSON_STRING   ? skip_string(p)
             : type == JSON_NUMBER ? skip_number(p)
                                   : skip_word(p, type == JSON_TRUE    ? "true"
                                                  : type == JSON_FALSE ? "false"
                                                                       : "null");
    p->out->tokens[number].end = p->at;
    return ok;
}

static int open_container(parser *p) {
    if (p->depth == JSON_DEPTH) return json_fail(p, "arrays and objects nested at most 256 deep");
    uint32_t number = p->out->count;
    if (!add_token(p, json_peek(p) == '{' ? JSON_OBJECT : JSON_ARRAY)) return json_fail(p, NULL);
    p->parent = number;
    ++p->depth;
    ++p->at;
    return 1;
}

static void close_container(parser *p) {
    json_token *token = &p->out->tokens[p->parent];
    ++p->at;
    token->end = p->at;
    token->next = p->out->count;
    p->parent = token->parent;
    --p->depth;
}

static int parse_key(parser *p) {
    skip_space(p);
    if (json_peek(p) != '"') return json_fail(p, "a member's name in quotes");
    if (!parse_scalar(p)) return 0;
    skip_space(p);
    if (json_peek(p) != ':') return json_fail(p, "a colon");
    ++p->at;
    return 1;
}

/* Everything between a value's end and the next value's begin; *done where the root has ended. */
static int parse_between(parser *p, int *done) {
    for (;;) {
        if (p->parent == JSON_NONE) {
            *done = 1;
            return 1;
        }
        json_token *container = &p->out->tokens[p->parent];
        int object = container->type == JSON_OBJECT;
        ++container->size;
        skip_space(p);
        if (json_peek(p) == ',') {
            ++p->at;
            return !object || parse_key(p);
        }
        if (json_peek(p) != (object ? '}' : ']'))
            return json_fail(
                p, object ? "a comma or a closing brace" : "a comma or a closing bracket");
        close_container(p);
    }
}

static int parse_value(parser *p, int *ended) {
    skip_space(p);
    int c = json_peek(p);
    *ended = 1;
    if (c != '{' && c != '[') return parse_scalar(p);
    if (!open_container(p)) return 0;
    skip_space(p);
    if (json_peek(p) == (c == '{' ? '}' : ']')) {
        close_container(p);
        return 1;
    }
    *ended = 0;
    return c == '[' || parse_key(p);
}

int norma_json_parse(
    const char *text, size_t size, norma_watch *watch, json *parsed, json_error *error) {
    *parsed = (json){.text = text, .size = size};
    *error = (json_error){0};
    parser p = {.text = text,
        .size = size,
        .out = parsed,
        .parent = JSON_NONE,
        .error = error,
        .watch = watch,
        .asked = text};
    int done = 0, ended;
    while (!done) {
        if (json_is_cancelled(&p)) return json_fail(&p, "no cancel");
        if (!parse_value(&p, &ended) || (ended && !parse_between(&p, &done))) return 0;
    }
    skip_space(&p);
    return p.at == size ? 1 : json_fail(&p, "nothing after the end");
}

void norma_json_free(json *parsed) {
    free(parsed->tokens);
    *parsed = (json){0};
}

/* ---- asking */

int norma_json_is(const json *j, uint32_t token, json_type type) {
    return token != JSON_NONE && j->tokens[token].type == type;
}

uint32_t norma_json_size(const json *j, uint32_t container) {
    return container == JSON_NONE ? 0 : j->tokens[container].size;
}

uint32_t norma_json_first(const json *j, uint32_t container) {
    if (norma_json_size(j, container) == 0) return JSON_NONE;
    return container + (j->tokens[container].type == JSON_OBJECT ? 2 : 1);
}

uint32_t norma_json_next(const json *j, uint32_t container, uint32_t value) {
    uint32_t next = j->tokens[value].next;
    if (next >= j->tokens[container].next) return JSON_NONE;
    return next + (j->tokens[container].type == JSON_OBJECT);
}

int norma_json_each(const json *j, uint32_t container, uint32_t *value) {
    *value = *value == JSON_NONE ? norma_json_first(j, container)
                                 : norma_json_next(j, container, *value);
    return *value != JSON_NONE;
}

uint32_t norma_json_member(const json *j, uint32_t object, const char *key) {
    uint32_t found = JSON_NONE;
    if (!norma_json_is(j, object, JSON_OBJECT)) return JSON_NONE;
    for (uint32_t value = JSON_NONE; norma_json_each(j, object, &value);)
        if (norma_json_equals(j, value - 1, key)) found = value;
    return found;
}

uint32_t norma_json_element(const json *j, uint32_t array, uint32_t index) {
    if (!norma_json_is(j, array, JSON_ARRAY) || index >= j->tokens[array].size) return JSON_NONE;
    uint32_t value = norma_json_first(j, array);
    while (index-- > 0) value = j->tokens[value].next;
    return value;
}

static uint32_t read_hex4(const char *at) {
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value = value * 16 + (uint32_t)norma_hex_value((unsigned char)at[i]);
    return value;
}

size_t norma_put_utf8(char *out, uint32_t code) {
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    size_t length = code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    for (size_t i = length; i-- > 1; code >>= 6) out[i] = (char)(0x80 | (code & 0x3F));
    out[0] = (char)((length == 2 ? 0xC0 : length == 3 ? 0xE0 : 0xF0) | code);
    return length;
}

size_t norma_utf8_take(const char *text, size_t left, uint32_t *code) {
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned lead = left ? (unsigned char)text[0] : 0xFF;
    const size_t length = lead < 0x80                   ? 1
                          : lead >= 0xC2 && lead < 0xE0 ? 2
                          : lead >= 0xE0 && lead < 0xF0 ? 3
                          : lead >= 0xF0 && lead < 0xF5 ? 4
                                                        : 0;
    *code = length == 1 ? lead : lead & (0x7FU >> length);
    if (length > left) return 0;
    for (size_t i = 1; i < length; ++i) {
        if (((unsigned char)text[i] & 0xC0) != 0x80) return 0;
        *code = *code << 6 | ((unsigned char)text[i] & 0x3FU);
    }
    return *code < least[length] || *code > 0x10FFFF || (*code >= 0xD800 && *code < 0xE000)
               ? 0
               : length;
}

int norma_utf8_is_legible(uint32_t code) {
    return !(code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x61C ||
             (code >= 0x200E && code <= 0x200F) || (code >= 0x2028 && code <= 0x202E) ||
             (code >= 0x2066 && code <= 0x2069) || code == 0xFEFF);
}

/* One escape behind its backslash; lone surrogates become U+FFFD, U+0000 too: C strings end there.
 */
static size_t decode_escape(const char **at, const char *end, char *out) {
    static const char names[] = "bfnrt", values[] = "\b\f\n\r\t";
    char c = *(*at)++;
    if (c != 'u') {
        const char *name = strchr(names, c);
        out[0] = name && c ? values[name - names] : c;
        return 1;
    }
    uint32_t code = read_hex4(*at);
    *at += 4;
    if (code >= 0xD800 && code < 0xDC00 && end - *at >= 6 && (*at)[0] == '\\' && (*at)[1] == 'u') {
        uint32_t low = read_hex4(*at + 2);
        if (low >= 0xDC00 && low < 0xE000) {
            *at += 6;
            return norma_put_utf8(out, 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00));
        }
    }
    return norma_put_utf8(out, code == 0 || (code >= 0xD800 && code < 0xE000) ? 0xFFFD : code);
}

int norma_json_equals(const json *j, uint32_t string, const char *text) {
    if (!norma_json_is(j, string, JSON_STRING)) return 0;
    const char *at = j->text + j->tokens[string].start + 1,
               *end = j->text + j->tokens[string].end - 1;
    while (at < end) {
        char bytes[4];
        size_t length = 1;
        bytes[0] = *at++;
        if (bytes[0] == '\\') length = decode_escape(&at, end, bytes);
        if (strncmp(text, bytes, length) != 0) return 0;
        text += length;
    }
    return *text == '\0';
}

char *norma_json_string(const json *j, uint32_t string) {
    if (!norma_json_is(j, string, JSON_STRING)) return NULL;
    const char *at = j->text + j->tokens[string].start + 1,
               *end = j->text + j->tokens[string].end - 1;
    char *out = malloc((size_t)(end - at) + 4), *to = out;
    while (out && at < end) {
        if (*at == '\\') {
            ++at;
            to += decode_escape(&at, end, to);
        } else {
            *to++ = *at++;
        }
    }
    if (out) *to = '\0';
    return out;
}

int norma_json_span(const json *j, uint32_t string, json_span *span) {
    *span = (json_span){0};
    if (!norma_json_is(j, string, JSON_STRING)) return 0;
    span->text = j->text + j->tokens[string].start + 1;
    span->length = j->tokens[string].end - 1 - (j->tokens[string].start + 1);
    if (!memchr(span->text, '\\', span->length)) return 1;
    span->text = span->owned = norma_json_string(j, string);
    span->length = span->owned ? strlen(span->owned) : 0;
    return span->owned != NULL;
}

int norma_json_number(const json *j, uint32_t number, double *value) {
    if (!norma_json_is(j, number, JSON_NUMBER)) return 0;
    const char *end = j->text + j->tokens[number].end;
    return norma_number_parse(j->text + j->tokens[number].start, end, value) == end;
}

int norma_json_uint(const json *j, uint32_t number, uint64_t *value) {
    double read;
    if (!norma_json_number(j, number, &read) || !(read >= 0 && read <= 9007199254740992.0) ||
        read != floor(read))
        return 0;
    *value = (uint64_t)read;
    return 1;
}
