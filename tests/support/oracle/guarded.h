/* guarded.h: arrays between two pages that nobody may touch, and memory that counts: how often each
 * byte is written, and whether any is read. */
#ifndef NORMA_TESTS_GUARDED_H
#define NORMA_TESTS_GUARDED_H
#include <stddef.h>

/* size bytes, the first right behind such a page (at_end 0) or the last right before one; filled
 * with GUARDED_POISON. Lies there until guarded_reset. Aborts if there is no room. */
enum { GUARDED_POISON = 0xA5 };
void *guarded_take(size_t size, int at_end);
void guarded_reset(void);

/* Watches the memory of one guarded_take (each write costs as much as filling all of it) while
 * watched(context) runs, on this thread only. After it, writes[i] says how often byte i was
 * written, and the memory holds what was. Returns how often it was read. -1: this machine cannot
 * (it is no x86-64 Linux, or a sanitizer has the signals). */
long guarded_watch(
    void *memory, size_t size, void watched(void *context), void *context, unsigned char *writes);

/* Calls crashed when a signal says that the program has gone wrong, and ends it. */
void guarded_on_crash(void crashed(void));
#endif
