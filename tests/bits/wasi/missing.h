/* missing.h: what src/io takes from POSIX and wasi-libc does not have, for the driver of tests/bits
 * alone; missing.c defines it. Included in front of every file. */
#ifndef NORMA_BITS_MISSING_H
#define NORMA_BITS_MISSING_H
char *realpath(const char *restrict path, char *restrict resolved);
int fchown(int descriptor, unsigned owner, unsigned group);
int dup(int descriptor);
int fchmod(int descriptor, unsigned mode);
int madvise(void *address, unsigned long size, int advice);
#endif
