/* outside_text.h: text that came from outside (names in files, paths, what a message quotes) on its
 * way to a terminal or a report. It may hold anything: escape sequences that move the cursor or
 * rename the window, marks that reverse the direction of what follows, line ends that pretend to be
 * another line, bytes that are no UTF-8. All of that is shown as \x1B or \u202E instead. */
#ifndef NORMA_CLI_OUTSIDE_TEXT_H
#define NORMA_CLI_OUTSIDE_TEXT_H
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* How many bytes the character at text takes (1 if it is not UTF-8, 0 at the end). *unsafe: 0 if it
 * may be written as it is, else its code point; for a byte that is not UTF-8 CLI_NOT_UTF8 plus it.
 */
#define CLI_NOT_UTF8 0x80000000u
size_t cli_next_character(const char *text, uint32_t *unsafe);

int cli_is_utf8(const char *text);

void cli_write_outside(FILE *out, const char *text);
/* At most so many characters of it. */
void cli_write_outside_cut(FILE *out, const char *text, size_t most);
/* The same as text in HTML and in its attributes. */
void cli_write_outside_html(FILE *out, const char *text);

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
#endif
