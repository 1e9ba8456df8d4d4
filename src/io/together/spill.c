/* spill.c: blocks of records: those of the first megabytes in memory, the others in a file. */
#include "io/together/spill.h"
#include "io/file/file.h"
#include "io/file/memory.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1 << 14, BLOCKS_IN_MEMORY = 1 << 9 };

typedef struct partition {
    uint32_t *blocks; /* numbers of those that are full */
    size_t block_count, block_room, count;
    unsigned char *open; /* the last one, not full yet; NULL: there is none */
    unsigned char *seen; /* the block that is read one by one */
    size_t next;
} partition;

struct spill {
    const char *folder;
    size_t record, in_block, block_count;
    file_writer *file; /* NULL: none yet */
    unsigned char *memory[BLOCKS_IN_MEMORY];
    partition parts[SPILL_PARTITIONS];
};

spill *norma_spill_open(const char *folder, size_t record) {
    spill *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    *s = (spill){.folder = folder, .record = record, .in_block = BLOCK / record};
    return s;
}

void norma_spill_close(spill *s) {
    if (!s) return;
    for (size_t i = 0; i < SPILL_PARTITIONS; ++i) {
        free(s->parts[i].blocks);
        free(s->parts[i].open);
        free(s->parts[i].seen);
    }
    for (size_t i = 0; i < BLOCKS_IN_MEMORY; ++i) free(s->memory[i]);
    norma_file_writer_abandon(s->file);
    free(s);
}

/* ---- blocks */

/* A file that is never put in place. */
static int open_spill(spill *s) {
    char *path = norma_io_join(s->folder, "/.norma-records");
    const int error = path ? norma_file_writer_open(path, &s->file) : ENOMEM;
    free(path);
    return error;
}

static int transfer(spill *s, uint32_t block, size_t from, void *bytes, size_t size, int writing) {
    if (block < BLOCKS_IN_MEMORY) {
        unsigned char *at = s->memory[block] + from;
        memcpy(writing ? at : bytes, writing ? bytes : at, size);
        return 0;
    }
    const uint64_t offset = (uint64_t)(block - BLOCKS_IN_MEMORY) * BLOCK + from;
    return writing ? norma_file_writer_patch(s->file, offset, bytes, size)
                   : norma_file_writer_read(s->file, offset, bytes, size);
}

static int keep_open_block(spill *s, partition *p) {
    uint32_t *blocks = norma_io_grow(p->blocks, &p->block_room, p->block_count + 1, sizeof *blocks);
    if (!blocks) return ENOMEM;
    p->blocks = blocks;
    const uint32_t number = (uint32_t)s->block_count;
    int error = 0;
    if (number < BLOCKS_IN_MEMORY) {
        s->memory[number] = p->open;
        p->open = NULL;
    } else {
        if (!s->file) error = open_spill(s);
        if (!error) error = norma_file_writer_write(s->file, p->open, BLOCK);
    }
    if (error) return error;
    ++s->block_count;
    p->blocks[p->block_count++] = number;
    return 0;
}

/* ---- records */

int norma_spill_add(spill *s, size_t partition_number, const void *record) {
    partition *p = &s->parts[partition_number];
    const size_t at = p->count % s->in_block;
    if (!p->open && !(p->open = malloc(BLOCK))) return ENOMEM;
    memcpy(p->open + at * s->record, record, s->record);
    ++p->count;
    return at + 1 == s->in_block ? keep_open_block(s, p) : 0;
}

size_t norma_spill_count(const spill *s, size_t partition_number) {
    return s->parts[partition_number].count;
}

/* Within one block. */
static int access_some(
    spill *s, partition *p, size_t first, size_t count, void *records, int writing) {
    const size_t block = first / s->in_block, from = first % s->in_block * s->record;
    if (block < p->block_count)
        return transfer(s, p->blocks[block], from, records, count * s->record, writing);
    memcpy(
        writing ? p->open + from : records, writing ? records : p->open + from, count * s->record);
    return 0;
}

static int access_records(
    spill *s, size_t number, size_t first, size_t count, void *records, int writing) {
    unsigned char *at = records;
    int error = 0;
    while (count > 0 && !error) {
        const size_t left = s->in_block - first % s->in_block, some = left < count ? left : count;
        error = access_some(s, &s->parts[number], first, some, at, writing);
        at += some * s->record;
        first += some;
        count -= some;
    }
    return error;
}

int norma_spill_read(spill *s, size_t partition_number, size_t first, size_t count, void *records) {
    return access_records(s, partition_number, first, count, records, 0);
}

int norma_spill_replace(
    spill *s, size_t partition_number, size_t first, size_t count, const void *records) {
    return access_records(s, partition_number, first, count, (void *)(uintptr_t)records, 1);
}

void norma_spill_rewind(spill *s) {
    for (size_t i = 0; i < SPILL_PARTITIONS; ++i) s->parts[i].next = 0;
}

int norma_spill_next(spill *s, size_t partition_number, void *record) {
    partition *p = &s->parts[partition_number];
    const size_t at = p->next % s->in_block;
    if (p->next >= p->count) return EIO;
    if (!p->seen && !(p->seen = malloc(BLOCK))) return ENOMEM;
    if (at == 0) {
        const size_t left = p->count - p->next, some = left < s->in_block ? left : s->in_block;
        const int error = norma_spill_read(s, partition_number, p->next, some, p->seen);
        if (error) return error;
    }
    memcpy(record, p->seen + at * s->record, s->record);
    ++p->next;
    return 0;
}
