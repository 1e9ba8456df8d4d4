/* deduplicate_normals.c: equal normals are one, numbered in the order of their first use. Elements
 * are dealt out by a hash of their normals, in order, so that each share is small enough for a
 * table in the cache and needs nothing of the others; the first of each share's equal
 * normals stands for them, whichever thread found it. */
#include "io/obj/deduplicate_normals.h"
#include <stdlib.h>
#include <string.h>
#include "io/format/format.h"
#include "io/file/large_memory.h"
#include "io/stream/tasks.h"

enum { SHARES = 256, LEAST_SLICE = 1 << 14 };

typedef struct numberer {
    obj_numbering *n;
    size_t slices;
    uint32_t *counts; /* of each slice and share; then where its part of the share begins */
    uint64_t *dealt;  /* share after share: a place in the order below its normal's tag */
    size_t starts[SHARES + 1]; /* of each share in dealt */
    uint32_t *first; /* for each place in the order the first place with the same normal */
    size_t *firsts;  /* of each slice: how many stand for themselves; then how many before it */
    int *failed;     /* of each share */
} numberer;

static uint64_t hash_normal(const float *n) {
    uint32_t bits[3];
    memcpy(bits, n, sizeof bits);
    uint64_t hash = (bits[0] | (uint64_t)bits[1] << 32) * UINT64_C(0x9e3779b97f4a7c15);
    hash = (hash ^ hash >> 29 ^ bits[2]) * UINT64_C(0xbf58476d1ce4e5b9);
    return hash ^ hash >> 32;
}

static const float *normal_at(const obj_numbering *n, size_t place) {
    return n->normals + 3 * (n->order ? n->order[place] : place);
}

static size_t share_of(uint64_t hash) { return (size_t)(hash >> 56); }
/* The lower half of the hash, above where a place goes: most others are told apart by it, without a
 * look at normals that lie far apart. */
static uint64_t tag_of(uint64_t hash) { return hash << 32; }
static uint32_t place_of(uint64_t tagged) { return (uint32_t)tagged; }

static void count_shares(void *context, size_t slice) {
    numberer *w = context;
    uint32_t *counts = w->counts + slice * SHARES;
    const size_t end = norma_io_slice(w->n->count, w->slices, slice + 1);
    for (size_t i = norma_io_slice(w->n->count, w->slices, slice); i < end; ++i)
        ++counts[share_of(hash_normal(normal_at(w->n, i)))];
}

static void place_shares(numberer *w) {
    uint32_t at = 0;
    for (size_t share = 0; share < SHARES; ++share) {
        w->starts[share] = at;
        for (size_t slice = 0; slice < w->slices; ++slice) {
            const uint32_t count = w->counts[slice * SHARES + share];
            w->counts[slice * SHARES + share] = at;
            at += count;
        }
    }
    w->starts[SHARES] = at;
}

static void deal(void *context, size_t slice) {
    numberer *w = context;
    uint32_t *next = w->counts + slice * SHARES;
    const size_t end = norma_io_slice(w->n->count, w->slices, slice + 1);
    for (size_t i = norma_io_slice(w->n->count, w->slices, slice); i < end; ++i) {
        const uint64_t hash = hash_normal(normal_at(w->n, i));
        w->dealt[next[share_of(hash)]++] = tag_of(hash) | i;
    }
}

static int are_equal(const obj_numbering *n, uint32_t a, uint32_t b) {
    return memcmp(normal_at(n, a), normal_at(n, b), 3 * sizeof(float)) == 0;
}

/* A slot: a place + 1 below its normal's tag; 0: free. */
static void find_firsts(void *context, size_t share) {
    numberer *w = context;
    const size_t begin = w->starts[share], end = w->starts[share + 1];
    size_t size = 16;
    if (begin == end) return;
    while (size < 2 * (end - begin)) size *= 2;
    uint64_t *slots = norma_io_allocate(size, sizeof *slots);
    w->failed[share] = !slots;
    for (size_t i = begin; slots && i < end; ++i) {
        const uint32_t place = place_of(w->dealt[i]);
        const uint64_t tag = w->dealt[i] - place;
        size_t slot = (size_t)(tag >> 32) & (size - 1);
        while (slots[slot] && (slots[slot] - place_of(slots[slot]) != tag ||
                                  !are_equal(w->n, place_of(slots[slot]) - 1, place)))
            slot = (slot + 1) & (size - 1);
        if (!slots[slot]) slots[slot] = tag | (place + 1);
        w->first[place] = place_of(slots[slot]) - 1;
    }
    free(slots);
}

static void count_firsts(void *context, size_t slice) {
    numberer *w = context;
    const size_t end = norma_io_slice(w->n->count, w->slices, slice + 1);
    size_t count = 0;
    for (size_t i = norma_io_slice(w->n->count, w->slices, slice); i < end; ++i)
        count += w->first[i] == i;
    w->firsts[slice] = count;
}

/* Those that stand for themselves get their numbers, into dealt, which has served. */
static void number_firsts(void *context, size_t slice) {
    numberer *w = context;
    const size_t end = norma_io_slice(w->n->count, w->slices, slice + 1);
    size_t number = w->firsts[slice];
    for (size_t i = norma_io_slice(w->n->count, w->slices, slice); i < end; ++i)
        if (w->first[i] == i) {
            memcpy(w->n->unique + 3 * number, normal_at(w->n, i), 3 * sizeof(float));
            w->dealt[i] = number++;
        }
}

static void number_all(void *context, size_t slice) {
    numberer *w = context;
    const size_t end = norma_io_slice(w->n->count, w->slices, slice + 1);
    for (size_t i = norma_io_slice(w->n->count, w->slices, slice); i < end; ++i)
        w->n->numbers[w->n->order ? w->n->order[i] : i] = (uint32_t)w->dealt[w->first[i]];
}

static int run(const numberer *w, size_t count, norma_task *task) {
    return !norma_io_tasks_watched(w->n->options, count, task, (void *)(uintptr_t)w);
}

static void sum_firsts(numberer *w) {
    w->n->unique_count = 0;
    for (size_t slice = 0; slice < w->slices; ++slice) {
        const size_t count = w->firsts[slice];
        w->firsts[slice] = w->n->unique_count;
        w->n->unique_count += count;
    }
}

static obj_numbered number(numberer *w) {
    obj_numbering *n = w->n;
    if (!run(w, w->slices, count_shares)) return OBJ_NUMBERED_CANCELLED;
    place_shares(w);
    if (!run(w, w->slices, deal) || !run(w, SHARES, find_firsts)) return OBJ_NUMBERED_CANCELLED;
    for (size_t share = 0; share < SHARES; ++share)
        if (w->failed[share]) return OBJ_NUMBERED_MEMORY;
    if (!run(w, w->slices, count_firsts)) return OBJ_NUMBERED_CANCELLED;
    sum_firsts(w);
    n->unique = norma_io_block(n->unique_count, 3 * sizeof *n->unique);
    n->numbers = norma_io_block(n->element_count, sizeof *n->numbers);
    if (!n->unique || !n->numbers) return OBJ_NUMBERED_MEMORY;
    return run(w, w->slices, number_firsts) && run(w, w->slices, number_all)
               ? OBJ_NUMBERED
               : OBJ_NUMBERED_CANCELLED;
}

obj_numbered norma_obj_number(obj_numbering *n) {
    numberer w = {.n = n, .slices = norma_io_slices(n->count, LEAST_SLICE)};
    w.counts = norma_io_allocate(w.slices * SHARES, sizeof *w.counts);
    w.firsts = norma_io_allocate(w.slices, sizeof *w.firsts);
    w.failed = norma_io_allocate(SHARES, sizeof *w.failed);
    w.dealt = norma_io_block(n->count, sizeof *w.dealt);
    w.first = norma_io_block(n->count, sizeof *w.first);
    obj_numbered result =
        w.counts && w.firsts && w.failed && w.dealt && w.first ? number(&w) : OBJ_NUMBERED_MEMORY;
    free(w.counts);
    free(w.firsts);
    free(w.failed);
    free(w.dealt);
    free(w.first);
    return result;
}
