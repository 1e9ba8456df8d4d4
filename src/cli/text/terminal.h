/* terminal.h: what the report of a person's terminal may look like: colours, and lines that fit its
 * width. Whatever is read by a program gets neither. */
#ifndef NORMA_CLI_TERMINAL_H
#define NORMA_CLI_TERMINAL_H
#include <stddef.h>
#include <stdio.h>

typedef enum cli_color_mode { CLI_COLOR_AUTO, CLI_COLOR_ALWAYS, CLI_COLOR_NEVER } cli_color_mode;

/* Auto: on a terminal that knows colours, unless NO_COLOR is set (no-color.org). */
int cli_wants_color(FILE *out, cli_color_mode mode);
/* Columns; 0: not a terminal, nothing is to be wrapped. */
size_t cli_terminal_width(FILE *out);

/* Words with line breaks before the last column, and an indent after each. Escape sequences of
 * colours take no column. Width 0: one line. No line end after the last. */
void cli_write_wrapped(FILE *out, const char *text, size_t width, int indent);
#endif
