/* pattern.h: names and patterns as a shell has them. */
#ifndef NORMA_IO_TOGETHER_PATTERN_H
#define NORMA_IO_TOGETHER_PATTERN_H

/* *: anything, ?: one byte, [a-z] and [!a-z]: one of them, or none of them; \\: the next as it is.
 */
int norma_matches(const char *pattern, const char *name);

#endif
