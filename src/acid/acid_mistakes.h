/* acid_mistakes.h: the mistakes that references of the acid scene show, in words. */
#ifndef NORMA_ACID_MISTAKES_H
#define NORMA_ACID_MISTAKES_H

typedef struct acid_mistake {
    const char *id;
    const char *words; /* what the renderer does, as a sentence without its full stop */
    const char *mend;  /* what a shader or loader does instead */
} acid_mistake;

const acid_mistake *acid_find_mistake(const char *id); /* NULL: there is none of that name */
#endif
