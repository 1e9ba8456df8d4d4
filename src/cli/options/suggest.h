/* suggest.h: what a misspelt word most likely means. */
#ifndef NORMA_CLI_SUGGEST_H
#define NORMA_CLI_SUGGEST_H
#include <stddef.h>

/* The nearest of names (each at stride bytes from the last, a const char * first). NULL: none is
 * near. */
const char *cli_suggest(const char *word, const void *names, size_t count, size_t stride);
const char *cli_suggest_rule(const char *word); /* the same of the names and ids of rules */

/* The nearest word of expected, a list such as "error, warning or info". 0: none is near, or
 * expected is no such list. */
enum { CLI_LONGEST_WORD = 32 };
int cli_suggest_listed(const char *given, const char *expected, char meant[CLI_LONGEST_WORD + 1]);
#endif
