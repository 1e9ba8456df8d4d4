/* broken_words.h: how the words of a strip are set. */
#ifndef NORMA_RENDER_BROKEN_WORDS_H
#define NORMA_RENDER_BROKEN_WORDS_H
#include <stddef.h>

enum { RENDER_MOST_LINES = 6 };

typedef struct render_text_lines {
    double size;                              /* of the letters, in pixels */
    size_t count, lengths[RENDER_MOST_LINES]; /* bytes; a blank lies between two lines */
} render_text_lines;

/* In letters of the usual size if they fit, within a strip of this width. */
render_text_lines render_break_words(const char *words, double usual, size_t width);
#endif
