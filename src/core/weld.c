/* weld.c: equal positions are found by a hash table of position numbers, open addressing, in ascending order: whoever comes first stands for the rest. */
#include "weld.h"

static const uint32_t EMPTY = UINT32_MAX;

/* The same bits for -0 and 0. */
static void position_key(const core_mesh *mesh, uint32_t index, uint64_t key[3])
{
    double p[3];
    norma_core_position(mesh, index, p);
    for (int k = 0; k < 3; k++) {
        p[k] += 0.0;
        memcpy(&key[k], &p[k], sizeof key[k]);
    }
}

/* NaN is equal to nothing, infinity to itself. */
static int key_has_nan(const uint64_t key[3])
{
    const uint64_t infinity = UINT64_C(0x7ff) << 52, magnitude = ~(UINT64_C(1) << 63);
    return (key[0] & magnitude) > infinity || (key[1] & magnitude) > infinity || (key[2] & magnitude) > infinity;
}

/* Multiply and fold (the high half of each product comes back by the shift), so that every bit of a coordinate moves the slot. */
static uint64_t hash_key(const uint64_t key[3])
{
    uint64_t h = 0;
    for (int k = 0; k < 3; k++) {
        h = (h ^ key[k]) * UINT64_C(0x9e3779b97f4a7c15);
        h ^= h >> 29;
        h *= UINT64_C(0xbf58476d1ce4e5b9);
        h ^= h >> 32;
    }
    return h;
}

static size_t table_size(size_t count)
{
    size_t size = 16;
    while (size < count + count / 2) size *= 2;
    return size;
}

static uint32_t find_or_add(const core_mesh *mesh, uint32_t *table, size_t mask, uint32_t index, const uint64_t key[3], uint64_t hash)
{
    uint64_t other[3];
    for (size_t slot = (size_t)hash & mask;; slot = (slot + 1) & mask) {
        if (table[slot] == EMPTY) {
            table[slot] = index;
            return index;
        }
        position_key(mesh, table[slot], other);
        if (key[0] == other[0] && key[1] == other[1] && key[2] == other[2]) return table[slot];
    }
}

enum { POSITIONS_IN_BLOCK = 64, BLOCKS_BETWEEN_TELLING = 1024 };

/* Keys and slots of a block first, so that the memory of all its slots is on its way when they are looked at. Whether any is one with an earlier. */
static int weld_block(const core_mesh *mesh, uint32_t *table, size_t mask, size_t begin, size_t end, uint32_t *weld)
{
    int any = 0;
    uint64_t keys[POSITIONS_IN_BLOCK][3], hashes[POSITIONS_IN_BLOCK];
    for (size_t i = begin; i < end; i++) {
        position_key(mesh, (uint32_t)i, keys[i - begin]);
        hashes[i - begin] = hash_key(keys[i - begin]);
        __builtin_prefetch(&table[(size_t)hashes[i - begin] & mask], 1);
    }
    for (size_t i = begin; i < end; i++) {
        weld[i] = key_has_nan(keys[i - begin]) ? (uint32_t)i : find_or_add(mesh, table, mask, (uint32_t)i, keys[i - begin], hashes[i - begin]);
        any |= weld[i] != i;
    }
    return any;
}

/* *any: whether two positions are one. */
static norma_result weld_equal(core_call *call, const core_mesh *mesh, uint32_t *weld, int *any)
{
    const size_t count = mesh->positions.count, size = table_size(count);
    uint32_t *table = norma_core_allocate(call, size, sizeof *table);
    if (!table) return NORMA_ERROR_MEMORY;
    memset(table, 0xff, size * sizeof *table);
    *any = 0;
    norma_result result = NORMA_OK;
    for (size_t begin = 0; begin < count && result == NORMA_OK; begin += POSITIONS_IN_BLOCK) {
        if (begin % (POSITIONS_IN_BLOCK * BLOCKS_BETWEEN_TELLING) == 0 && norma_core_progress(call, (double)begin / (double)count)) result = NORMA_CANCELLED;
        *any |= weld_block(mesh, table, size - 1, begin, count - begin < POSITIONS_IN_BLOCK ? count : begin + POSITIONS_IN_BLOCK, weld);
    }
    norma_core_release(call, table, size, sizeof *table);
    return result;
}

norma_result norma_core_weld(core_call *call, core_mesh *mesh)
{
    if (call->options.weld == NORMA_WELD_NONE || !mesh->positions.count) return NORMA_OK;
    uint32_t *weld = norma_core_allocate(call, mesh->positions.count, sizeof *weld);
    if (!weld) return NORMA_ERROR_MEMORY;
    int any;
    norma_result result = weld_equal(call, mesh, weld, &any);
    const int by_distance = call->options.weld == NORMA_WELD_DISTANCE && call->options.weld_distance > 0;
    if (result == NORMA_OK && by_distance) result = norma_core_weld_near(call, mesh, call->options.weld_distance * mesh->scale, weld);
    if (result == NORMA_OK && (any || by_distance)) mesh->weld = weld;     /* a map of each to itself would only cost a look into it for each corner */
    else norma_core_release(call, weld, mesh->positions.count, sizeof *weld);
    return result;
}

void norma_core_unweld(const core_call *call, core_mesh *mesh)
{
    norma_core_release(call, (void *)(uintptr_t)mesh->weld, mesh->positions.count, sizeof *mesh->weld);
    mesh->weld = NULL;
}
