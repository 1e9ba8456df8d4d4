/* acid_mistakes.h: the mistakes that references of the acid scene show, in words. */
#ifndef NORMA_ACID_MISTAKES_H
#define NORMA_ACID_MISTAKES_H

#include <stddef.h>

enum { ACID_MOST_FUNCTIONS = 3 };

typedef struct acid_mistake {
    const char *id;
    const char *words; /* what the renderer does, as a sentence without its full stop */
    const char *mend;  /* what a shader or loader does instead */
    const char *functions[ACID_MOST_FUNCTIONS]; /* of norma.glsl that do so; then NULL */
} acid_mistake;

const acid_mistake *acid_find_mistake(const char *id); /* NULL: there is none of that name */

/* The text of a function of norma.glsl with its comment: where it begins, and its length; 0: there
 * is none of that name. */
size_t acid_mending_lines(const char *function, const char **begin);
#endif
