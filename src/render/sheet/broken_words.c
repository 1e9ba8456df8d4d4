/* broken_words.c: words in a strip: smaller where they would not fit, but not below what can be
 * read; then on several lines. */
#include "render/sheet/broken_words.h"
#include "render/picture/picture.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double least_text = 7.5, room_of_width = 0.96;

/* The bytes of the words that fit, up to a blank; at least one word. */
static size_t line_length(const char *words, double size, double room) {
    size_t fits = 0;
    for (size_t at = 1;; ++at) {
        char line[256];
        if (words[at - 1] == '\0') return fits;
        if (words[at] != ' ' && words[at] != '\0') continue;
        snprintf(line, sizeof line, "%.*s", (int)at, words);
        if (fits && render_text_width(line, size) > room) return fits;
        fits = at;
    }
}

render_text_lines render_break_words(const char *words, double usual, size_t width) {
    const double room = room_of_width * (double)width, wide = render_text_width(words, usual);
    render_text_lines l = {.size = wide > room ? usual * room / wide : usual, .count = 1};
    l.lengths[0] = strlen(words);
    if (l.size >= least_text || l.size >= usual) return l;
    double widest = 0;
    l.size = least_text;
    l.count = 0;
    for (const char *at = words; *at && l.count < RENDER_MOST_LINES; ++l.count) {
        char line[400];
        size_t *length = &l.lengths[l.count];
        *length = l.count + 1 < RENDER_MOST_LINES ? line_length(at, l.size, room) : strlen(at);
        snprintf(line, sizeof line, "%.*s", (int)*length, at);
        widest = fmax(widest, render_text_width(line, l.size));
        at += *length + (at[*length] == ' ');
    }
    if (widest > room) l.size *= room / widest; /* one long word, or very many */
    return l;
}
