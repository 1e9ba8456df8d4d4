/* weld.c: equal positions as one, those within a distance too. Equal keys are found in two steps.
 * Keys are dealt into buckets by their hash, each as a tag and its number, in ascending order; then
 * a table for each bucket, small enough for the nearest cache, finds equal tags, and only then are
 * keys looked at. The first one stands for the rest. One table for all took a miss of every cache
 * for each key; only up to 262,143 keys have one, which fits the second cache, and no buckets. */
#include "core/mesh/mesh.h"
#include "core/call/call.h"
#include <string.h>

static const uint32_t EMPTY = UINT32_MAX;

enum {
    IN_BATCH = 128,
    RECENT_BITS = 10,
    MOST_BITS = 12,
    IN_BUCKET = 2048,
    NUMBER_BITS = 18, /* in a word of the one table; the others are a tag, so that few keys that
                         differ are compared. Number and tag of only ones would be EMPTY */
    MOST_IN_ONE = (1 << NUMBER_BITS) - 1,
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
    size_t near[MOST_SLICES];  /* of each slice: those that are one with a recent one */
} welding;

static size_t buckets_of(const welding *w) { return (size_t)1 << w->bits; }
static size_t bucket_of(const welding *w, uint64_t hash) {
    return w->bits ? (size_t)(hash >> (64 - w->bits)) : 0;
}
static size_t share_of(size_t count, size_t part, size_t parts) {
    return (size_t)((uint64_t)count * part / parts);
}

/* What is done with each key of a slice that is not known to be one with an earlier one; hash 0: it
 * has none. */
typedef void see_key(const welding *w, uint32_t *cursors, uint32_t key, uint64_t hash);

/* Corners of a soup of triangles meet those of their neighbours again soon, mostly, and then need
 * not go through the buckets: corner normals of STL meshes take 12 to 22 % less. */
CORE_INLINE uint32_t find_recent(
    const weld_keys *keys, weld_entry *recent, uint32_t key, uint64_t hash) {
    weld_entry *slot = &recent[hash >> (64 - RECENT_BITS)];
    if (!hash) return key;
    if (slot->tag == (uint32_t)hash && slot->index != EMPTY &&
        keys->same(keys->context, slot->index, key))
        return slot->index;
    *slot = (weld_entry){(uint32_t)hash, key};
    return key;
}

CORE_INLINE size_t for_slice(const welding *w, size_t slice, int first_time, see_key *see) {
    uint32_t *cursors = w->cursors + slice * buckets_of(w);
    const size_t end = share_of(w->keys->count, slice + 1, w->slices);
    uint64_t hashes[IN_BATCH];
    weld_entry recent[1 << RECENT_BITS];
    size_t count, near = 0;
    memset(recent, 0xff, first_time ? sizeof recent : 0);
    for (size_t i = share_of(w->keys->count, slice, w->slices); i < end; i += count) {
        count = end - i < IN_BATCH ? end - i : IN_BATCH;
        w->keys->hash(w->keys->context, i, count, hashes);
        for (size_t k = 0; k < count; ++k) {
            const uint32_t key = (uint32_t)(i + k);
            if (first_time) w->weld[key] = find_recent(w->keys, recent, key, hashes[k]);
            if (w->weld[key] == key)
                see(w, cursors, key, hashes[k]);
            else
                ++near;
        }
    }
    return near;
}

CORE_INLINE void count_key(const welding *w, uint32_t *counts, uint32_t key, uint64_t hash) {
    (void)key;
    if (hash) ++counts[bucket_of(w, hash)];
}

static void count_slice(void *context, size_t slice) {
    welding *w = context;
    memset(w->cursors + slice * buckets_of(w), 0, buckets_of(w) * sizeof *w->cursors);
    w->near[slice] = for_slice(w, slice, 1, count_key);
}

CORE_INLINE void deal_key(const welding *w, uint32_t *cursors, uint32_t key, uint64_t hash) {
    if (hash)
        w->entries[cursors[bucket_of(w, hash)]++] =
            (weld_entry){(uint32_t)(hash >> (32 - w->bits)), key};
}

static void deal_slice(void *context, size_t slice) {
    welding *w = context;
    for_slice(w, slice, 0, deal_key);
}

/* Those that are one with a recent key are one with the first. A recent key is of the same slice;
 * what lies in another, which may be at work, is a first one. */
static void follow_slice(void *context, size_t slice) {
    const welding *w = context;
    const size_t begin = share_of(w->keys->count, slice, w->slices),
                 end = share_of(w->keys->count, slice + 1, w->slices);
    for (size_t i = begin; i < end && w->near[slice]; ++i)
        if (w->weld[i] >= begin) w->weld[i] = w->weld[w->weld[i]];
}

/* Counts become places: bucket by bucket, in each slice by slice. Returns the most that one bucket
 * holds. */
static size_t place_buckets(const welding *w) {
    uint32_t sum = 0, most = 0;
    for (size_t bucket = 0; bucket < buckets_of(w); ++bucket) {
        w->starts[bucket] = sum;
        for (size_t slice = 0; slice < w->slices; ++slice) {
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
    while (((size_t)1 << bits) < count + count / 2) ++bits;
    return bits;
}

/* Returns how many are one with an earlier one. table: of entries' numbers, open addressing. */
static size_t weld_bucket(const weld_keys *keys, const weld_entry *entries, size_t count,
    uint32_t *table, uint32_t *weld) {
    const int bits = table_bits(count);
    const uint32_t mask = (uint32_t)(((uint64_t)1 << bits) - 1);
    size_t found = 0;
    memset(table, 0xff, ((size_t)1 << bits) * sizeof *table);
    for (size_t i = 0; i < count; ++i) {
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
        ++found;
    }
    return found;
}

static void weld_group(void *context, size_t group) {
    welding *w = context;
    size_t found = 0;
    for (size_t bucket = share_of(buckets_of(w), group, w->groups);
         bucket < share_of(buckets_of(w), group + 1, w->groups); ++bucket)
        found += weld_bucket(w->keys, w->entries + w->starts[bucket],
            w->starts[bucket + 1] - w->starts[bucket], w->tables + group * w->table_size, w->weld);
    w->found[group] = found;
}

/* All in one table of words: the upper bits a tag, the lower ones the number of the first of equal
 * keys. A word for each slot is all the memory that it takes, and each key is hashed and gone
 * through once. Returns how many keys are one with an earlier one. */
static size_t weld_in_one(const weld_keys *keys, uint32_t *table, uint32_t *weld) {
    const int bits = table_bits(keys->count);
    const uint32_t mask = (uint32_t)(((uint64_t)1 << bits) - 1), number = MOST_IN_ONE;
    uint64_t hashes[IN_BATCH];
    size_t count, found = 0;
    memset(table, 0xff, ((size_t)1 << bits) * sizeof *table);
    for (size_t i = 0; i < keys->count; i += count) {
        count = keys->count - i < IN_BATCH ? keys->count - i : IN_BATCH;
        keys->hash(keys->context, i, count, hashes);
        for (size_t k = 0; k < count; ++k) {
            const uint32_t key = (uint32_t)(i + k),
                           tag = (uint32_t)(hashes[k] >> (32 - bits)) & ~number;
            uint32_t slot = (uint32_t)(hashes[k] >> (64 - bits));
            weld[key] = key;
            if (!hashes[k]) continue;
            while (
                table[slot] != EMPTY && ((table[slot] & ~number) != tag ||
                                            !keys->same(keys->context, table[slot] & number, key)))
                slot = (slot + 1) & mask;
            if (table[slot] == EMPTY) {
                table[slot] = tag | key;
                continue;
            }
            weld[key] = table[slot] & number;
            ++found;
        }
    }
    return found;
}

/* With memory for all of it. */
static norma_result run_welding(core_call *call, welding *w, size_t *found) {
    norma_result result = norma_core_parallel(call, w->slices, count_slice, w);
    if (result) return result;
    const size_t most = place_buckets(w);
    result = norma_core_parallel(call, w->slices, deal_slice, w);
    if (result) return result;
    w->table_size = (size_t)1 << table_bits(most);
    w->groups = most > LARGE_BUCKET || buckets_of(w) < w->slices ? 1 : w->slices;
    w->tables = norma_core_allocate(call, w->groups * w->table_size, sizeof *w->tables);
    if (!w->tables) return NORMA_ERROR_MEMORY;
    result = norma_core_parallel(call, w->groups, weld_group, w);
    if (!result) result = norma_core_parallel(call, w->slices, follow_slice, w);
    for (size_t i = 0; i < w->groups && !result; ++i) *found += w->found[i];
    for (size_t i = 0; i < w->slices && !result; ++i) *found += w->near[i];
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
    const size_t slices = slices_for(call, count);
    if (count <= FEW || (slices == 1 && count <= MOST_IN_ONE)) {
        uint32_t few[2 * FEW]; /* in small meshes the allocator takes longer than to weld */
        const size_t size = (size_t)1 << table_bits(count);
        uint32_t *table = count <= FEW ? few : norma_core_allocate(call, size, sizeof *table);
        if (!table) return NORMA_ERROR_MEMORY;
        *found = weld_in_one(keys, table, weld);
        if (table != few) norma_core_release(call, table, size, sizeof *table);
        return NORMA_OK;
    }
    welding w = {.keys = keys, .weld = weld, .slices = slices};
    while (w.bits < MOST_BITS && count >> w.bits > IN_BUCKET) ++w.bits;
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

/* ---- the components of "at most a step apart", by walking a tree of positions against itself. Two
 * branches are joined whole where even their farthest points are a step apart, and passed over
 * where their nearest are not, or where they are joined already: so dense clusters cost no more
 * than sparse ones, and the answer does not depend on any order. */

typedef struct joiner {
    core_call *call;
    core_kdtree tree;
    uint32_t *weld; /* a forest: each points to a lower number or to itself */
    uint8_t *whole; /* of each node of the tree: all its sites are known to be joined */
    double squared_step;
} joiner;

static void join_range(joiner *j, size_t node, size_t begin, size_t end) {
    if (j->whole[node]) return;
    for (size_t i = begin + 1; i < end; ++i)
        norma_core_join_sets(j->weld, j->tree.sites[begin], j->tree.sites[i]);
    j->whole[node] = 1;
}

static double squared_distance(const core_mesh *mesh, uint32_t a, uint32_t b) {
    double p[3], q[3], sum = 0;
    norma_core_position(mesh, a, p);
    norma_core_position(mesh, b, q);
    for (int k = 0; k < 3; ++k) sum += (p[k] - q[k]) * (p[k] - q[k]);
    return sum;
}

typedef struct branch {
    size_t node, begin, end;
} branch;

static size_t sites_of(branch b) { return b.end - b.begin; }

static branch half(branch b, int second) {
    const size_t middle = b.begin + (b.end - b.begin) / 2;
    return second ? (branch){2 * b.node + 2, middle, b.end}
                  : (branch){2 * b.node + 1, b.begin, middle};
}

static int is_leaf(const joiner *j, branch b) {
    const core_box *box = &j->tree.boxes[b.node];
    return sites_of(b) <= KDTREE_LEAF ||
           (box->low[0] == box->high[0] && box->low[1] == box->high[1] &&
               box->low[2] == box->high[2]);
}

static void join_leaves(joiner *j, branch a, branch b) {
    for (size_t i = a.begin; i < a.end; ++i)
        for (size_t k = b.begin; k < b.end; ++k)
            if (squared_distance(j->tree.mesh, j->tree.sites[i], j->tree.sites[k]) <=
                j->squared_step)
                norma_core_join_sets(j->weld, j->tree.sites[i], j->tree.sites[k]);
}

/* Whether the caller wants to stop, who is asked at large branches. */
static int is_stopped(joiner *j, size_t sites) {
    return sites >= KDTREE_MANY ? norma_core_progress(j->call, 0) : j->call->cancelled;
}

static void join_across(joiner *j, branch a, branch b) {
    if (is_stopped(j, sites_of(a) + sites_of(b))) return;
    const core_box *box_a = &j->tree.boxes[a.node], *box_b = &j->tree.boxes[b.node];
    if (norma_core_box_least(box_a, box_b) > j->squared_step) return;
    if (j->whole[a.node] && j->whole[b.node] &&
        norma_core_set_of(j->weld, j->tree.sites[a.begin]) ==
            norma_core_set_of(j->weld, j->tree.sites[b.begin]))
        return;
    if (norma_core_box_greatest(box_a, box_b) <= j->squared_step) {
        join_range(j, a.node, a.begin, a.end);
        join_range(j, b.node, b.begin, b.end);
        norma_core_join_sets(j->weld, j->tree.sites[a.begin], j->tree.sites[b.begin]);
        return;
    }
    const int leaf_a = is_leaf(j, a), leaf_b = is_leaf(j, b);
    if (leaf_a && leaf_b) {
        join_leaves(j, a, b);
        return;
    }
    const int split_a = !leaf_a && (leaf_b || sites_of(a) >= sites_of(b));
    join_across(j, split_a ? half(a, 0) : a, split_a ? b : half(b, 0));
    join_across(j, split_a ? half(a, 1) : a, split_a ? b : half(b, 1));
}

static void join_within(joiner *j, branch b) {
    if (is_stopped(j, sites_of(b))) return;
    const core_box *box = &j->tree.boxes[b.node];
    if (norma_core_box_greatest(box, box) <= j->squared_step) {
        join_range(j, b.node, b.begin, b.end);
    } else if (is_leaf(j, b)) {
        join_leaves(j, b, b);
    } else {
        const branch first = half(b, 0), second = half(b, 1);
        join_within(j, first);
        join_within(j, second);
        join_across(j, first, second);
        j->whole[b.node] = j->whole[first.node] && j->whole[second.node] &&
                           norma_core_set_of(j->weld, j->tree.sites[first.begin]) ==
                               norma_core_set_of(j->weld, j->tree.sites[second.begin]);
    }
}

static size_t collect_distinct(const core_mesh *mesh, const uint32_t *weld, uint32_t *sites) {
    size_t count = 0;
    for (size_t i = 0; i < mesh->positions.count; ++i) {
        double p[3];
        norma_core_position(mesh, (uint32_t)i, p);
        if (weld[i] == i && norma_core_finite(p)) sites[count++] = (uint32_t)i;
    }
    return count;
}

static norma_result join_sites(core_call *call, const core_mesh *mesh, double distance,
    uint32_t *weld, uint32_t *sites, size_t count) {
    joiner j = {.call = call, .weld = weld, .squared_step = distance * distance};
    norma_result result = norma_core_kdtree_build(call, mesh, NULL, sites, count, &j.tree);
    if (result) return result;
    j.whole = norma_core_allocate(call, j.tree.box_count, 1);
    if (j.whole) {
        memset(j.whole, 0, j.tree.box_count);
        join_within(&j, (branch){0, 0, count});
        if (call->cancelled) result = NORMA_CANCELLED;
    } else {
        result = NORMA_ERROR_MEMORY;
    }
    norma_core_release(call, j.whole, j.tree.box_count, 1);
    norma_core_kdtree_release(call, &j.tree);
    return result;
}

/* Joins, in a map of equal positions, those that a chain of steps of at most
 * distance (in the unit that positions are read in) connects. */
static norma_result core_weld_near(
    core_call *call, const core_mesh *mesh, double distance, uint32_t *weld) {
    uint32_t *sites = norma_core_allocate(call, mesh->positions.count, sizeof *sites);
    if (!sites) return NORMA_ERROR_MEMORY;
    const size_t count = collect_distinct(mesh, weld, sites);
    const norma_result result =
        count ? join_sites(call, mesh, distance, weld, sites, count) : NORMA_OK;
    norma_core_release(call, sites, mesh->positions.count, sizeof *sites);
    if (result) return result;
    for (size_t i = 0; i < mesh->positions.count; ++i) weld[i] = weld[weld[i]];
    return NORMA_OK;
}

/* ---- which positions are exactly equal (-0 = 0). */

/* The same bits for -0 and 0. */
static void position_key(const core_mesh *mesh, uint32_t index, uint64_t key[3]) {
    double p[3];
    norma_core_position(mesh, index, p);
    for (int k = 0; k < 3; ++k) {
        p[k] += 0.0;
        memcpy(&key[k], &p[k], sizeof key[k]);
    }
}

/* NaN is equal to nothing, infinity to itself. */
static int key_has_nan(const uint64_t key[3]) {
    const uint64_t infinity = UINT64_C(0x7ff) << 52, magnitude = ~(UINT64_C(1) << 63);
    return (key[0] & magnitude) > infinity || (key[1] & magnitude) > infinity ||
           (key[2] & magnitude) > infinity;
}

static inline uint64_t hash_key(const uint64_t key[3]) {
    const uint64_t sum = key[0] * UINT64_C(0x9e3779b97f4a7c15) +
                         key[1] * UINT64_C(0xbf58476d1ce4e5b9) +
                         key[2] * UINT64_C(0x94d049bb133111eb);
    return norma_core_weld_mix(sum);
}

/* Of floats the bits of floats, two in one factor: fewer steps. */
static uint64_t hash_floats(const unsigned char *at) {
    float p[3];
    uint32_t bits[3];
    memcpy(p, at, sizeof p);
    for (size_t k = 0; k < 3; ++k) p[k] += 0.0F;
    memcpy(bits, p, sizeof bits);
    const float all = p[0] + p[1] + p[2]; /* not a number also where infinities cancel */
    if (all != all && (p[0] != p[0] || p[1] != p[1] || p[2] != p[2])) return 0;
    const uint64_t two = bits[0] | (uint64_t)bits[1] << 32,
                   sum =
                       two * UINT64_C(0x9e3779b97f4a7c15) + bits[2] * UINT64_C(0xbf58476d1ce4e5b9);
    return norma_core_weld_mix(sum);
}

static void hash_positions(const void *context, size_t first, size_t count, uint64_t *hashes) {
    const core_mesh *mesh = context;
    const size_t stride = mesh->positions.stride;
    const unsigned char *data = (const unsigned char *)mesh->positions.data + first * stride;
    if (mesh->positions.format == NORMA_FORMAT_FLOAT) {
        for (size_t i = 0; i < count; ++i) hashes[i] = hash_floats(data + i * stride);
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        uint64_t key[3];
        position_key(mesh, (uint32_t)(first + i), key);
        hashes[i] = key_has_nan(key) ? 0 : hash_key(key);
    }
}

/* Neither is NaN, which has no hash: equal bits are equal numbers. */
static int same_position(const void *context, uint32_t one, uint32_t other) {
    const core_mesh *mesh = context;
    const unsigned char *data = mesh->positions.data;
    const size_t stride = mesh->positions.stride;
    double a[3], b[3];
    if (mesh->positions.format == NORMA_FORMAT_FLOAT &&
        !memcmp(data + one * stride, data + other * stride, 3 * sizeof(float)))
        return 1;
    norma_core_position(mesh, one, a);
    norma_core_position(mesh, other, b);
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

norma_result norma_core_weld(core_call *call, core_mesh *mesh) {
    if (call->options.weld == NORMA_WELD_NONE || !mesh->positions.count) return NORMA_OK;
    uint32_t *weld = norma_core_allocate(call, mesh->positions.count, sizeof *weld);
    if (!weld) return NORMA_ERROR_MEMORY;
    size_t found;
    const weld_keys keys = {mesh->positions.count, mesh, hash_positions, same_position};
    norma_result result = norma_core_weld_keys(call, &keys, weld, &found);
    const int by_distance = norma_core_welds_near(call) && call->options.weld_distance > 0;
    if (!result && by_distance)
        result = core_weld_near(call, mesh, call->options.weld_distance * mesh->scale, weld);
    if (!result && (found || by_distance))
        mesh->weld =
            weld; /* a map of each to itself would only cost a look into it for each corner */
    else
        norma_core_release(call, weld, mesh->positions.count, sizeof *weld);
    return result;
}

void norma_core_unweld(const core_call *call, core_mesh *mesh) {
    norma_core_release(
        call, (void *)(uintptr_t)mesh->weld, mesh->positions.count, sizeof *mesh->weld);
    mesh->weld = NULL;
}
