/* outside_text.c: one function decides what of a text from outside may be written as it is; the
 * others write the rest as escapes. */
#define _POSIX_C_SOURCE 200809L
#include "cli/text/outside_text.h"
#include <stdlib.h>
#include <string.h>

/* The bytes of one UTF-8 character (RFC 3629: no overlong forms, no surrogates, at most U+10FFFF)
 * and its code point. Returns 0 if the bytes are not a character. */
static size_t decode(const unsigned char *text, uint32_t *code) {
    const unsigned char lead = text[0];
    const size_t length = lead < 0x80                   ? 1
                          : lead >= 0xC2 && lead < 0xE0 ? 2
                          : lead >= 0xE0 && lead < 0xF0 ? 3
                          : lead >= 0xF0 && lead < 0xF5 ? 4
                                                        : 0;
    if (length < 2) {
        *code = lead;
        return length;
    }
    *code = lead & (0x7Fu >> length);
    for (size_t i = 1; i < length; ++i) {
        if ((text[i] & 0xC0) != 0x80) return 0;
        *code = *code << 6 | (text[i] & 0x3Fu);
    }
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    return *code < least[length] || *code > 0x10FFFF || (*code >= 0xD800 && *code <= 0xDFFF)
               ? 0
               : length;
}

/* Controls (C0, DEL, C1), line and paragraph separators, marks of direction (Unicode's
 * Bidi_Control) and the byte order mark. */
static int is_unsafe(uint32_t code) {
    return code < 0x20 || (code >= 0x7F && code < 0xA0) || code == 0x61C ||
           (code >= 0x200E && code <= 0x200F) || (code >= 0x2028 && code <= 0x202E) ||
           (code >= 0x2066 && code <= 0x2069) || code == 0xFEFF;
}

size_t cli_next_character(const char *text, uint32_t *unsafe) {
    uint32_t code;
    *unsafe = 0;
    if (!*text) return 0;
    const size_t length = decode((const unsigned char *)text, &code);
    if (length == 0)
        *unsafe = CLI_NOT_UTF8 + (unsigned char)*text;
    else if (is_unsafe(code))
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
