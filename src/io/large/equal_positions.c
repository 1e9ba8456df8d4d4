/* equal_positions.c: vertices that share their position with another one. Positions are hashed, and
 * two with the same hash count as equal here: what is computed later compares the positions
 * themselves, so that one marked too many costs time and changes nothing. */
#include "io/large/equal_positions.h"

/* ---- hashes */

static uint64_t mix(uint64_t x) {
    x = (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
    x = (x ^ x >> 32) * UINT64_C(0xd6e8feb86659fd93);
    return x ^ x >> 32;
}

/* 0 where it is not a number, and so equal to nothing. -0 is 0. */
static uint64_t hash_of(const double position[3]) {
    uint64_t sum = 0;
    for (int k = 0; k < 3; ++k) {
        const double p = position[k] + 0.0;
        uint64_t bits;
        if (p != p) return 0;
        memcpy(&bits, &p, sizeof bits);
        sum = (sum ^ bits) * UINT64_C(0x9e3779b97f4a7c15) + (uint64_t)k + 1;
        sum ^= sum >> 29;
    }
    const uint64_t hash = mix(sum);
    return hash ? hash : 1;
}

/* Of the vertices from first on, at most LARGE_BLOCK. */
static norma_document_result hash_block(
    large_ply *ply, size_t first, size_t count, uint64_t *hashes) {
    norma_document_result result = norma_large_ply_positions(ply, first, count, ply->scratch);
    const float *floats = (const float *)(const void *)ply->scratch;
    for (size_t i = 0; i < count && !result; ++i) {
        double position[3];
        for (size_t k = 0; k < 3; ++k)
            position[k] = ply->single ? (double)floats[3 * i + k] : ply->scratch[3 * i + k];
        hashes[i] = hash_of(position);
    }
    return result;
}

static size_t block_size(const large_ply *ply, size_t first) {
    return ply->vertices - first < LARGE_BLOCK ? ply->vertices - first : LARGE_BLOCK;
}

/* ---- which are equal to any other */

static const uint64_t EMPTY = UINT64_MAX;

typedef struct seen_table {
    uint64_t *slots; /* the upper half of a hash, and the first vertex that has it */
    size_t size;     /* a power of two */
} seen_table;

static void meet(seen_table *table, uint64_t hash, size_t vertex, large_bits *equal) {
    const uint64_t upper = hash >> 32 << 32;
    size_t slot = (size_t)hash & (table->size - 1);
    for (; table->slots[slot] != EMPTY; slot = (slot + 1) & (table->size - 1))
        if (table->slots[slot] >> 32 << 32 == upper) {
            norma_large_bits_set(equal, (size_t)(uint32_t)table->slots[slot]);
            norma_large_bits_set(equal, vertex);
            return;
        }
    table->slots[slot] = upper | vertex;
}

/* Of the parts into which hashes fall evenly, one. */
static size_t part_of(uint64_t hash, size_t parts) {
    return (size_t)(((hash >> 8 & UINT32_MAX) * parts) >> 32);
}

static norma_document_result meet_part(large_ply *ply, seen_table *table, uint64_t *hashes,
    size_t part, size_t parts, large_bits *equal) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    memset(table->slots, 0xff, table->size * sizeof *table->slots);
    for (size_t first = 0; first < ply->vertices && !result; first += LARGE_BLOCK) {
        const size_t count = block_size(ply, first);
        result = hash_block(ply, first, count, hashes);
#if defined(__GNUC__)
        for (size_t i = 0; i < count && !result; ++i)
            if (hashes[i] && part_of(hashes[i], parts) == part)
                __builtin_prefetch(&table->slots[(size_t)hashes[i] & (table->size - 1)], 1, 1);
#endif
        for (size_t i = 0; i < count && !result; ++i)
            if (hashes[i] && part_of(hashes[i], parts) == part)
                meet(table, hashes[i], first + i, equal);
        if (!result && first / LARGE_BLOCK % 32 == 0)
            result = norma_large_tell(
                ply->file, ((double)part + (double)first / (double)ply->vertices) / (double)parts);
    }
    return result;
}

/* Two slots for three vertices at least, as long as it takes no more than half of what is left. */
static size_t table_size(const large_ply *ply) {
    const large_budget *budget = &ply->file->budget;
    const uint64_t most = (budget->most - budget->used) / 2 / sizeof(uint64_t);
    size_t size = 1024;
    while (size < ply->vertices + ply->vertices / 2 && 2 * (uint64_t)size <= most) size *= 2;
    return size;
}

norma_document_result norma_large_find_equal(large_ply *ply, large_bits *equal, int *any) {
    large_budget *budget = &ply->file->budget;
    seen_table table = {.size = table_size(ply)};
    const size_t parts = ply->vertices / (table.size - table.size / 4) + 1;
    uint64_t *hashes = norma_large_take(budget, LARGE_BLOCK, sizeof *hashes);
    table.slots = norma_large_take(budget, table.size, sizeof *table.slots);
    norma_document_result result =
        hashes && table.slots ? NORMA_DOCUMENT_OK : norma_large_fail_memory(ply->file);
    for (size_t part = 0; part < parts && !result; ++part)
        result = meet_part(ply, &table, hashes, part, parts, equal);
    norma_large_give(budget, table.slots, table.size, sizeof *table.slots);
    norma_large_give(budget, hashes, LARGE_BLOCK, sizeof *hashes);
    *any = !result && norma_large_bits_count(equal) > 0;
    return result;
}

/* ---- which are equal to those of a range */

typedef struct hash_set {
    uint32_t *slots; /* 0: empty */
    size_t size;
} hash_set;

static uint32_t print_of(uint64_t hash) { return (uint32_t)(hash >> 32) | 1u; }

static void add_hash(hash_set *set, uint64_t hash) {
    size_t slot = (size_t)hash & (set->size - 1);
    while (set->slots[slot] && set->slots[slot] != print_of(hash))
        slot = (slot + 1) & (set->size - 1);
    set->slots[slot] = print_of(hash);
}

static int has_hash(const hash_set *set, uint64_t hash) {
    size_t slot = (size_t)hash & (set->size - 1);
    while (set->slots[slot] && set->slots[slot] != print_of(hash))
        slot = (slot + 1) & (set->size - 1);
    return set->slots[slot] != 0;
}

static norma_document_result gather(large_ply *ply, const large_bits *equal, size_t begin,
    size_t end, hash_set *set, uint64_t *hashes) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = begin; first < end && !result; first += LARGE_BLOCK) {
        const size_t count = end - first < LARGE_BLOCK ? end - first : LARGE_BLOCK;
        if (!norma_large_bits_any(equal, first, first + count)) continue;
        result = hash_block(ply, first, count, hashes);
        for (size_t i = 0; i < count && !result; ++i)
            if (norma_large_bits_has(equal, first + i) && hashes[i]) add_hash(set, hashes[i]);
    }
    return result;
}

static norma_document_result match(large_ply *ply, const large_bits *equal, const hash_set *set,
    uint64_t *hashes, large_bits *members) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < ply->vertices && !result; first += LARGE_BLOCK) {
        const size_t count = block_size(ply, first);
        if (!norma_large_bits_any(equal, first, first + count)) continue;
        result = hash_block(ply, first, count, hashes);
        for (size_t i = 0; i < count && !result; ++i)
            if (norma_large_bits_has(equal, first + i) && hashes[i] && has_hash(set, hashes[i]))
                norma_large_bits_set(members, first + i);
    }
    return result;
}

norma_document_result norma_large_add_equal(
    large_ply *ply, const large_bits *equal, size_t begin, size_t end, large_bits *members) {
    large_budget *budget = &ply->file->budget;
    const size_t marked =
        norma_large_bits_before(equal, end) - norma_large_bits_before(equal, begin);
    if (!marked) return NORMA_DOCUMENT_OK;
    hash_set set = {.size = 1024};
    while (set.size < 2 * marked) set.size *= 2;
    uint64_t *hashes = norma_large_take(budget, LARGE_BLOCK, sizeof *hashes);
    set.slots = norma_large_take_zeroed(budget, set.size, sizeof *set.slots);
    norma_document_result result =
        hashes && set.slots ? NORMA_DOCUMENT_OK : NORMA_DOCUMENT_ERROR_MEMORY;
    if (!result) result = gather(ply, equal, begin, end, &set, hashes);
    if (!result) result = match(ply, equal, &set, hashes, members);
    norma_large_give(budget, set.slots, set.size, sizeof *set.slots);
    norma_large_give(budget, hashes, LARGE_BLOCK, sizeof *hashes);
    return result;
}
