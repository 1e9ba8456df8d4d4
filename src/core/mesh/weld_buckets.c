/* weld_buckets.c: equal keys are found in two steps. Keys are dealt into buckets by their hash,
 * each as a tag and its number, in ascending order; then a table for each bucket, small enough for
 * the nearest cache, finds equal tags, and only then are keys looked at. The first one stands for
 * the rest. One table for all took a miss of every cache for each key. */
#include "core/mesh/weld_buckets.h"
#include "core/call/call.h"
#include <string.h>

static const uint32_t EMPTY = UINT32_MAX;

enum {
    IN_BATCH = 128,
    MOST_BITS = 12,
    IN_BUCKET = 2048,
    MOST_SLICES = 32,
    FEWEST_IN_SLICE = 1 << 14,
    LARGE_BUCKET = 1 << 16,
    FEW = 512 /* keys that a table on the stack is enough for */
};

typedef struct weld_entry {
    uint32_t tag, index;
} weld_entry; /* tag: the bits of the hash behind those that tell the bucket; index: of the key
               */

typedef struct welding {
    const weld_keys *keys;
    uint32_t *weld;
    int bits;              /* there are 2^bits buckets */
    size_t slices, groups; /* slices of the keys, whose entries stand behind those of the slices
                              before; groups of the buckets */
    uint32_t *cursors;     /* of each slice and bucket: how many, then where the next goes */
    uint32_t *starts;      /* of the buckets in the entries, and the end */
    weld_entry *entries;
    uint32_t *tables; /* one for each group */
    size_t table_size;
    size_t found[MOST_SLICES]; /* by each group: how many keys are one with an earlier one */
} welding;

static size_t buckets_of(const welding *w) { return (size_t)1 << w->bits; }
static size_t bucket_of(const welding *w, uint64_t hash) {
    return w->bits ? (size_t)(hash >> (64 - w->bits)) : 0;
}
static size_t share_of(size_t count, size_t part, size_t parts) {
    return (size_t)((uint64_t)count * part / parts);
}

/* What is done with each key of a slice; hash 0: it has none. */
typedef void see_key(const welding *w, uint32_t *cursors, uint32_t key, uint64_t hash);

CORE_INLINE void for_slice(const welding *w, size_t slice, see_key *see) {
    uint32_t *cursors = w->cursors + slice * buckets_of(w);
    const size_t end = share_of(w->keys->count, slice + 1, w->slices);
    uint64_t hashes[IN_BATCH];
    size_t count;
    for (size_t i = share_of(w->keys->count, slice, w->slices); i < end; i += count) {
        count = end - i < IN_BATCH ? end - i : IN_BATCH;
        w->keys->hash(w->keys->context, i, count, hashes);
        for (size_t k = 0; k < count; k++) see(w, cursors, (uint32_t)(i + k), hashes[k]);
    }
}

CORE_INLINE void count_key(const welding *w, uint32_t *counts, uint32_t key, uint64_t hash) {
    (void)key;
    if (hash) counts[bucket_of(w, hash)]++;
}

static void count_slice(void *context, size_t slice) {
    const welding *w = context;
    memset(w->cursors + slice * buckets_of(w), 0, buckets_of(w) * sizeof *w->cursors);
    for_slice(w, slice, count_key);
}

CORE_INLINE void deal_key(const welding *w, uint32_t *cursors, uint32_t key, uint64_t hash) {
    w->weld[key] = key;
    if (hash)
        w->entries[cursors[bucket_of(w, hash)]++] =
            (weld_entry){(uint32_t)(hash >> (32 - w->bits)), key};
}

static void deal_slice(void *context, size_t slice) { for_slice(context, slice, deal_key); }

/* Counts become places: bucket by bucket, in each slice by slice. Returns the most that one bucket
 * holds. */
static size_t place_buckets(const welding *w) {
    uint32_t sum = 0, most = 0;
    for (size_t bucket = 0; bucket < buckets_of(w); bucket++) {
        w->starts[bucket] = sum;
        for (size_t slice = 0; slice < w->slices; slice++) {
            uint32_t *cursor = &w->cursors[slice * buckets_of(w) + bucket];
            const uint32_t count = *cursor;
            *cursor = sum;
            sum += count;
        }
        if (sum - w->starts[bucket] > most) most = sum - w->starts[bucket];
    }
    w->starts[buckets_of(w)] = sum;
    return most;
}

/* Of a table for count entries, a power of two. */
static int table_bits(size_t count) {
    int bits = 4;
    while (((size_t)1 << bits) < count + count / 2) bits++;
    return bits;
}

/* Returns how many are one with an earlier one. table: of entries' numbers, open addressing. */
static size_t weld_bucket(const weld_keys *keys, const weld_entry *entries, size_t count,
    uint32_t *table, uint32_t *weld) {
    const int bits = table_bits(count);
    const uint32_t mask = (uint32_t)(((uint64_t)1 << bits) - 1);
    size_t found = 0;
    memset(table, 0xff, ((size_t)1 << bits) * sizeof *table);
    for (size_t i = 0; i < count; i++) {
        const weld_entry e = entries[i];
        uint32_t slot = (uint32_t)((uint64_t)e.tag >> (32 - bits));
        while (table[slot] != EMPTY &&
               (entries[table[slot]].tag != e.tag ||
                   !keys->same(keys->context, entries[table[slot]].index, e.index)))
            slot = (slot + 1) & mask;
        if (table[slot] == EMPTY) {
            table[slot] = (uint32_t)i;
            continue;
        }
        weld[e.index] = entries[table[slot]].index;
        found++;
    }
    return found;
}

static void weld_group(void *context, size_t group) {
    welding *w = context;
    size_t found = 0;
    for (size_t bucket = share_of(buckets_of(w), group, w->groups);
         bucket < share_of(buckets_of(w), group + 1, w->groups); bucket++)
        found += weld_bucket(w->keys, w->entries + w->starts[bucket],
            w->starts[bucket + 1] - w->starts[bucket], w->tables + group * w->table_size, w->weld);
    w->found[group] = found;
}

/* All in one bucket, without a word to the allocator: in small meshes that takes longer than to
 * weld. */
static size_t weld_few(const weld_keys *keys, uint32_t *weld) {
    uint64_t hashes[FEW];
    weld_entry entries[FEW];
    uint32_t table[2 * FEW], count = 0;
    keys->hash(keys->context, 0, keys->count, hashes);
    for (uint32_t i = 0; i < keys->count; i++) {
        weld[i] = i;
        entries[count] = (weld_entry){(uint32_t)(hashes[i] >> 32), i};
        count += hashes[i] != 0;
    }
    return weld_bucket(keys, entries, count, table, weld);
}

/* Into the one bucket of a small mesh go at most all, which need not be counted before. */
static int is_one_bucket(const welding *w) { return !w->bits && w->slices == 1; }

/* With memory for all of it. */
static norma_result run_welding(core_call *call, welding *w, size_t *found) {
    norma_result result = NORMA_OK;
    if (is_one_bucket(w))
        w->cursors[0] = (uint32_t)w->keys->count;
    else
        result = norma_core_parallel(call, w->slices, count_slice, w);
    if (result != NORMA_OK) return result;
    const size_t most = place_buckets(w);
    w->table_size = (size_t)1 << table_bits(most);
    w->groups = most > LARGE_BUCKET || buckets_of(w) < w->slices ? 1 : w->slices;
    w->tables = norma_core_allocate(call, w->groups * w->table_size, sizeof *w->tables);
    if (!w->tables) return NORMA_ERROR_MEMORY;
    result = norma_core_parallel(call, w->slices, deal_slice, w);
    if (is_one_bucket(w)) w->starts[1] = w->cursors[0];
    if (result == NORMA_OK) result = norma_core_parallel(call, w->groups, weld_group, w);
    for (size_t i = 0; i < w->groups && result == NORMA_OK; i++) *found += w->found[i];
    norma_core_release(call, w->tables, w->groups * w->table_size, sizeof *w->tables);
    return result;
}

static size_t slices_for(const core_call *call, size_t count) {
    const size_t workers = call->options.parallel_for ? MOST_SLICES : norma_core_workers(call),
                 most = 1 + count / FEWEST_IN_SLICE, told = 4;
    const size_t slices = workers > 1 || call->options.progress ? told * workers : 1;
    return slices < MOST_SLICES ? (slices < most ? slices : most)
           : MOST_SLICES < most ? MOST_SLICES
                                : most;
}

norma_result norma_core_weld_keys(
    core_call *call, const weld_keys *keys, uint32_t *weld, size_t *found) {
    const size_t count = keys->count;
    if (count <= FEW) {
        *found = weld_few(keys, weld);
        return NORMA_OK;
    }
    welding w = {.keys = keys, .weld = weld, .slices = slices_for(call, count)};
    while (w.bits < MOST_BITS && count >> w.bits > IN_BUCKET) w.bits++;
    w.entries = norma_core_allocate(call, count, sizeof *w.entries);
    w.cursors = norma_core_allocate(call, w.slices << w.bits, sizeof *w.cursors);
    w.starts = norma_core_allocate(call, buckets_of(&w) + 1, sizeof *w.starts);
    *found = 0;
    const norma_result result =
        w.entries && w.cursors && w.starts ? run_welding(call, &w, found) : NORMA_ERROR_MEMORY;
    norma_core_release(call, w.entries, count, sizeof *w.entries);
    norma_core_release(call, w.cursors, w.slices << w.bits, sizeof *w.cursors);
    norma_core_release(call, w.starts, buckets_of(&w) + 1, sizeof *w.starts);
    return result;
}
