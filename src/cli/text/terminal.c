/* terminal.c: colours by the wish of the user, the environment and the terminal; words wrapped at
 * its width. */
#define _DEFAULT_SOURCE
#include "cli/text/terminal.h"
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

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
