/* spill.h: records of one size in partitions, in memory while they are few and in a temporary file
 * without a name from then on: what is held in memory does not grow with their number, but for some
 * bytes for every 16 KiB. */
#ifndef NORMA_IO_TOGETHER_SPILL_H
#define NORMA_IO_TOGETHER_SPILL_H
#include <stddef.h>
#include <stdint.h>

enum { SPILL_PARTITIONS = 256 };

typedef struct spill spill;

/* folder: of the temporary file, which is made when it is needed; it must outlive the spill.
 * record: bytes of one. NULL: out of memory. */
spill *norma_spill_open(const char *folder, size_t record);
void norma_spill_close(spill *s); /* NULL is fine */
/* Each returns 0 or errno. */
int norma_spill_add(spill *s, size_t partition, const void *record);
size_t norma_spill_count(const spill *s, size_t partition);
/* Records from first on, which were added before. */
int norma_spill_read(spill *s, size_t partition, size_t first, size_t count, void *records);
int norma_spill_replace(
    spill *s, size_t partition, size_t first, size_t count, const void *records);
/* Each partition from its first record on, one after the other. */
void norma_spill_rewind(spill *s);
int norma_spill_next(spill *s, size_t partition, void *record);
#endif
