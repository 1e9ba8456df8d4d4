/* missing.h: what io takes from POSIX and wasi-libc does not declare; no_system.c defines it.
 * Included in front of every file of the page's module. */
#ifndef NORMA_WEB_MISSING_H
#define NORMA_WEB_MISSING_H
char *realpath(const char *restrict path, char *restrict resolved);
#endif
