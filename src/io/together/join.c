/* join.c: what is known of positions, of any number, brought together at equal or near ones, in
 * memory or by a temporary file. */
#include "io/together/together.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* ---- What every step of a call reports: a temporary file that fails, and how far it came. */

norma_document_result norma_together_fail_spill(together_run *run, int failed) {
    return norma_document_fail_file(run->folder, run->error,
        "the temporary file of this run cannot be written or read", failed);
}

int norma_together_tell(together_run *run, double share_of_file) {
    const double files = (double)run->count;
    return run->compute.progress &&
           run->compute.progress(run->compute.progress_user,
               (run->passes_done + ((double)run->number + share_of_file) / files) / run->passes);
}

/* ---- Blocks of records: those of the first megabytes in memory, the others in a file. */

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

static int spill_read(
    spill *s, size_t partition_number, size_t first, size_t count, void *records) {
    return access_records(s, partition_number, first, count, records, 0);
}

/* Records from first on, which were added before. */
static int spill_replace(
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
        const int error = spill_read(s, partition_number, p->next, some, p->seen);
        if (error) return error;
    }
    memcpy(record, p->seen + at * s->record, s->record);
    ++p->next;
    return 0;
}

/* ---- The distinct positions of all files, joined by the core as those of one mesh. */

struct near_positions {
    double (*at)[3];
    size_t count, room;
    uint32_t *stands; /* for each the position that stands for its chain */
};

near_positions *norma_near_begin(void) { return calloc(1, sizeof(near_positions)); }

void norma_near_free(near_positions *near) {
    if (!near) return;
    free(near->at);
    free(near->stands);
    free(near);
}

int norma_near_add(near_positions *near, const double at[3]) {
    if (!norma_core_finite(at)) return 1;
    double *added = norma_io_add(&near->at, &near->room, &near->count, sizeof near->at[0]);
    if (added) memcpy(added, at, sizeof near->at[0]);
    return added != NULL;
}

int norma_together_compare(const void *a, const void *b) {
    const double *p = a, *q = b;
    for (int k = 0; k < 3; ++k)
        if (p[k] != q[k]) return p[k] < q[k] ? -1 : 1;
    return 0;
}

static void sort_distinct(near_positions *near) {
    size_t kept = 0;
    qsort(near->at, near->count, sizeof near->at[0], norma_together_compare);
    for (size_t i = 0; i < near->count; ++i)
        if (i == 0 || norma_together_compare(near->at[i], near->at[kept - 1]) != 0)
            memmove(near->at[kept++], near->at[i], sizeof near->at[0]);
    near->count = kept;
}

/* They are sorted: the least index of a chain is its least position. */
norma_result norma_near_end(near_positions *near, double distance, uint32_t threads) {
    const norma_options options = {.struct_size = sizeof options,
        .weld = NORMA_WELD_DISTANCE,
        .weld_distance = distance,
        .threads = threads};
    core_call call;
    if (near->count) sort_distinct(near);
    if (near->count > UINT32_MAX) return NORMA_ERROR_OVERFLOW;
    const norma_mesh points = {
        .positions = {.data = near->at, .count = near->count, .format = NORMA_FORMAT_DOUBLE}};
    core_mesh mesh;
    norma_result result = norma_core_begin(&call, &options);
    if (!result) result = norma_core_mesh_shape(&points, &mesh);
    if (!result && near->count) {
        mesh.scale = 1;
        result = norma_core_weld(&call, &mesh);
    }
    if (result || !near->count || !mesh.weld) return result;
    near->stands = norma_io_allocate(near->count, sizeof *near->stands);
    if (near->stands) memcpy(near->stands, mesh.weld, near->count * sizeof *near->stands);
    norma_core_unweld(&call, &mesh);
    return near->stands ? NORMA_OK : NORMA_ERROR_MEMORY;
}

void norma_near_find(const near_positions *near, double at[3]) {
    double(*found)[3] = near->stands ? bsearch(at, near->at, near->count, sizeof near->at[0],
                                           norma_together_compare)
                                     : NULL;
    if (found) memcpy(at, near->at[near->stands[found - near->at]], sizeof near->at[0]);
}

/* ---- A partition at a time, the records of equal positions are joined by a hash table. */

enum { AT_ONCE = 256 };

typedef struct joining {
    spill *votes, *normals;
    size_t partition, count, round, rounds;
    position_votes *entries;
    size_t entry_count, entry_room;
    uint32_t *table; /* entry + 1; 0: free */
    size_t table_size;
    visit_position *visit;
    void *user;
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
        size_t at = (size_t)(norma_together_hash(j->entries[i].at) >> 20) & (size - 1);
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
           memcmp(j->entries[j->table[place] - 1].at, at, sizeof j->entries->at) != 0)
        place = (place + 1) & (j->table_size - 1);
    return &j->table[place];
}

void norma_together_add_votes(position_votes *to, const position_votes *votes) {
    const uint32_t voters = to->voters + votes->voters;
    const unsigned border = to->border | votes->border;
    if (votes->sum.votes) {
        if (!to->sum.votes || votes->rank < to->rank)
            *to = *votes;
        else if (votes->rank == to->rank)
            norma_core_open_sum_join(&to->sum, &votes->sum);
    } else if (!to->sum.votes && votes->rank < to->rank)
        to->rank = votes->rank; /* decides nothing, but bytes do not depend on the order */
    to->voters = voters & INT32_MAX;
    to->border = border & 1;
}

static int add_joined_position(joining *j, const position_votes *votes, uint64_t hash) {
    if (2 * j->entry_count >= j->table_size && grow_positions(j)) return ENOMEM;
    uint32_t *place = find_position(j, votes->at, hash);
    if (*place) {
        norma_together_add_votes(&j->entries[*place - 1], votes);
        return 0;
    }
    position_votes *entry =
        norma_io_add(&j->entries, &j->entry_room, &j->entry_count, sizeof *entry);
    if (!entry) return ENOMEM;
    *entry = *votes;
    *place = (uint32_t)j->entry_count;
    return 0;
}

/* ---- a round: the positions of one share of the hashes */

static int is_of_round(const joining *j, uint64_t hash) {
    return (hash >> 8) % j->rounds == j->round;
}

static int take_some(joining *j, size_t first, size_t count) {
    int error = spill_read(j->votes, j->partition, first, count, j->some);
    for (size_t i = 0; i < count && !error; ++i) {
        const uint64_t hash = norma_together_hash(j->some[i].at);
        if (is_of_round(j, hash)) error = add_joined_position(j, &j->some[i], hash);
    }
    return error;
}

/* of: a record of the position. */
static position_normal normal_of(const position_votes *all, const position_votes *of) {
    const int kept = all->rank == 0;
    position_normal normal;
    double weight;
    memset(&normal, 0, sizeof normal);
    normal.shared = all->voters > of->voters || kept;
    normal.kept = (uint8_t)kept;
    normal.reason = (uint8_t)norma_core_open_direction(&all->sum, normal.direction);
    if (kept) {
        norma_core_open_sum_value(&all->sum, normal.direction, &weight);
        for (int k = 0; k < 3; ++k) normal.direction[k] /= weight;
    }
    return normal;
}

/* The first round adds the records, the others replace those that are theirs. */
static int answer_some(joining *j, size_t first, size_t count) {
    int error = spill_read(j->votes, j->partition, first, count, j->some);
    if (!error && j->round) error = spill_read(j->normals, j->partition, first, count, j->answers);
    for (size_t i = 0; i < count && !error; ++i) {
        const uint64_t hash = norma_together_hash(j->some[i].at);
        if (is_of_round(j, hash))
            j->answers[i] =
                normal_of(&j->entries[*find_position(j, j->some[i].at, hash) - 1], &j->some[i]);
        if (!j->round) error = norma_spill_add(j->normals, j->partition, &j->answers[i]);
    }
    return error || !j->round ? error
                              : spill_replace(j->normals, j->partition, first, count, j->answers);
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
    j->count = j->votes->parts[j->partition].count;
    j->rounds = (size_t)(j->count * 2 * sizeof(position_votes) / (memory ? memory : 1)) + 1;
    for (j->round = 0; j->round < j->rounds && !error; ++j->round) {
        j->entry_count = 0;
        if (j->table) memset(j->table, 0, j->table_size * sizeof *j->table);
        error = each_record(j, take_some);
        for (size_t i = 0; j->visit && i < j->entry_count && !error; ++i)
            error = j->visit(j->user, &j->entries[i]);
        if (!error && j->normals) error = each_record(j, answer_some);
    }
    return error;
}

int norma_together_join(
    spill *votes, spill *normals, uint64_t memory, visit_position *visit, void *user) {
    joining *j = calloc(1, sizeof *j);
    int error = j ? 0 : ENOMEM;
    if (!j) return error;
    j->votes = votes;
    j->normals = normals;
    j->visit = visit;
    j->user = user;
    for (; j->partition < SPILL_PARTITIONS && !error; ++j->partition)
        error = join_partition(j, memory);
    free(j->entries);
    free(j->table);
    free(j);
    return error;
}
