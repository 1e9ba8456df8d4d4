/* join.c: a partition at a time, the records of equal positions are joined by a hash table. */
#include "io/together/join.h"
#include "core/vertex/open_votes.h"
#include "io/file/memory.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { AT_ONCE = 256 };

typedef struct entry {
    position_votes votes;
    uint32_t others; /* records with votes, beside the first */
} entry;

typedef struct joining {
    spill *votes, *normals;
    size_t partition, count, round, rounds;
    entry *entries;
    size_t entry_count, entry_room;
    uint32_t *table; /* entry + 1; 0: free */
    size_t table_size;
    position_votes some[AT_ONCE];
    position_normal answers[AT_ONCE];
} joining;

/* Steele, Lea, Flood 2014, splitmix64. */
static uint64_t mixed_position(uint64_t z) {
    z = (z + 0x9E3779B97F4A7C15u) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
}

uint64_t norma_together_hash(const double at[3]) {
    uint64_t bits[3];
    memcpy(bits, at, sizeof bits);
    return mixed_position(mixed_position(mixed_position(bits[0]) ^ bits[1]) ^ bits[2]);
}

size_t norma_together_partition(const double at[3]) {
    return (size_t)(norma_together_hash(at) % SPILL_PARTITIONS);
}

/* ---- the table */

static int grow_positions(joining *j) {
    const size_t size = j->table_size ? 2 * j->table_size : 1024;
    uint32_t *table = norma_io_allocate(size, sizeof *table);
    if (!table) return ENOMEM;
    for (size_t i = 0; i < j->entry_count; ++i) {
        size_t at = (size_t)(norma_together_hash(j->entries[i].votes.at) >> 20) & (size - 1);
        while (table[at]) at = (at + 1) & (size - 1);
        table[at] = (uint32_t)i + 1;
    }
    free(j->table);
    j->table = table;
    j->table_size = size;
    return 0;
}

/* The place in the table of this position, or the free one for it. */
static uint32_t *find_position(const joining *j, const double at[3], uint64_t hash) {
    size_t place = (size_t)(hash >> 20) & (j->table_size - 1);
    while (j->table[place] &&
           memcmp(j->entries[j->table[place] - 1].votes.at, at, sizeof j->entries->votes.at) != 0)
        place = (place + 1) & (j->table_size - 1);
    return &j->table[place];
}

static void add_position_votes(entry *e, const position_votes *votes) {
    if (!votes->sum.votes) return;
    e->others += e->votes.sum.votes != 0;
    if (!e->votes.sum.votes || votes->rank < e->votes.rank)
        e->votes = *votes;
    else if (votes->rank == e->votes.rank)
        norma_core_open_sum_join(&e->votes.sum, &votes->sum);
}

static int add_joined_position(joining *j, const position_votes *votes, uint64_t hash) {
    if (2 * j->entry_count >= j->table_size && grow_positions(j)) return ENOMEM;
    uint32_t *place = find_position(j, votes->at, hash);
    if (*place) {
        add_position_votes(&j->entries[*place - 1], votes);
        return 0;
    }
    entry *entries = norma_io_grow(j->entries, &j->entry_room, j->entry_count + 1, sizeof *entries);
    if (!entries) return ENOMEM;
    j->entries = entries;
    j->entries[j->entry_count] = (entry){.votes = *votes};
    *place = (uint32_t)++j->entry_count;
    return 0;
}

/* ---- a round: the positions of one share of the hashes */

static int is_of_round(const joining *j, uint64_t hash) {
    return (hash >> 8) % j->rounds == j->round;
}

static int take_some(joining *j, size_t first, size_t count) {
    int error = norma_spill_read(j->votes, j->partition, first, count, j->some);
    for (size_t i = 0; i < count && !error; ++i) {
        const uint64_t hash = norma_together_hash(j->some[i].at);
        if (is_of_round(j, hash)) error = add_joined_position(j, &j->some[i], hash);
    }
    return error;
}

static position_normal normal_of(const entry *e) {
    const int kept = e->votes.rank == 0;
    position_normal normal;
    double weight;
    memset(&normal, 0, sizeof normal);
    normal.shared = e->others > 0 || kept;
    normal.kept = (uint8_t)kept;
    normal.reason = (uint8_t)norma_core_open_direction(&e->votes.sum, normal.direction);
    if (kept) {
        norma_core_open_sum_value(&e->votes.sum, normal.direction, &weight);
        for (int k = 0; k < 3; ++k) normal.direction[k] /= weight;
    }
    return normal;
}

/* The first round adds the records, the others replace those that are theirs. */
static int answer_some(joining *j, size_t first, size_t count) {
    int error = norma_spill_read(j->votes, j->partition, first, count, j->some);
    if (!error && j->round)
        error = norma_spill_read(j->normals, j->partition, first, count, j->answers);
    for (size_t i = 0; i < count && !error; ++i) {
        const uint64_t hash = norma_together_hash(j->some[i].at);
        if (is_of_round(j, hash))
            j->answers[i] = normal_of(&j->entries[*find_position(j, j->some[i].at, hash) - 1]);
        if (!j->round) error = norma_spill_add(j->normals, j->partition, &j->answers[i]);
    }
    return error || !j->round
               ? error
               : norma_spill_replace(j->normals, j->partition, first, count, j->answers);
}

static int each_record(joining *j, int (*visit)(joining *j, size_t first, size_t count)) {
    int error = 0;
    for (size_t first = 0; first < j->count && !error; first += AT_ONCE) {
        const size_t left = j->count - first;
        error = visit(j, first, left < AT_ONCE ? left : AT_ONCE);
    }
    return error;
}

static int join_partition(joining *j, uint64_t memory) {
    int error = 0;
    j->count = norma_spill_count(j->votes, j->partition);
    j->rounds = (size_t)(j->count * 2 * sizeof(entry) / (memory ? memory : 1)) + 1;
    for (j->round = 0; j->round < j->rounds && !error; ++j->round) {
        j->entry_count = 0;
        if (j->table) memset(j->table, 0, j->table_size * sizeof *j->table);
        error = each_record(j, take_some);
        if (!error) error = each_record(j, answer_some);
    }
    return error;
}

int norma_together_join(spill *votes, spill *normals, uint64_t memory) {
    joining *j = calloc(1, sizeof *j);
    int error = j ? 0 : ENOMEM;
    if (!j) return error;
    j->votes = votes;
    j->normals = normals;
    for (; j->partition < SPILL_PARTITIONS && !error; ++j->partition)
        error = join_partition(j, memory);
    free(j->entries);
    free(j->table);
    free(j);
    return error;
}
