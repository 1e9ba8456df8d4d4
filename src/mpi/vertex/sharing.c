/* sharing.c: each position goes to its home, the rank that a hash of it chooses, which sees who has
 * the same one. A position that one rank alone has is that rank's; one of which a single rank has
 * votes is summed there and lent to its home; all others get a slot at their home. Positions go in
 * rounds by their hash, so that a round holds all of one key and leaves nothing but slots behind.
 */
#include "mpi/vertex/vertex.h"
#include "core/call/call.h"
#include "core/call/table.h"

enum { MOST_KEY = 24, LEAST_LOANS = 1024 };
static const uint64_t MOST_SLOTS = UINT64_C(1) << MPI_HOME_AT; /* an answer has room for it */

typedef struct share_work {
    mpi_call *call;
    const mpi_keys *keys;
    const uint8_t *part;
    int lend;
    size_t key_size;
    uint64_t round, rounds;
    mpi_sharing *sharing;
} share_work;

/* ---- keys */

static size_t size_of_key(const mpi_keys *keys) {
    return keys->numbers ? sizeof(uint64_t) : 3 * (keys->doubles ? sizeof(double) : sizeof(float));
}

/* -0 is 0. Positions that are no doubles fit floats. */
static void write_key(const mpi_keys *keys, size_t v, unsigned char *key) {
    double p[3];
    if (keys->numbers) {
        memcpy(key, &keys->numbers[v], sizeof keys->numbers[v]);
        return;
    }
    norma_core_position(keys->mesh, (uint32_t)v, p);
    for (size_t k = 0; k < 3; k++) {
        const double exact = p[k] + 0.0;
        const float single = (float)exact;
        if (keys->doubles)
            memcpy(key + k * sizeof exact, &exact, sizeof exact);
        else
            memcpy(key + k * sizeof single, &single, sizeof single);
    }
}

/* The highest bits choose the home, lower ones the round, the lowest the place in a table. */
static int mpi_home_of(const mpi_call *call, uint64_t hash) {
    return (int)((hash >> 32) * (uint64_t)call->ranks >> 32);
}
static uint64_t round_of(const share_work *work, uint64_t hash) {
    return (hash >> 16 & 0xffff) * work->rounds >> 16;
}

int norma_mpi_home_of_number(const mpi_call *call, uint64_t number) {
    unsigned char key[sizeof number];
    memcpy(key, &number, sizeof number);
    return mpi_home_of(call, norma_core_hash(key, sizeof key));
}

/* ---- sending */

typedef void share_see(
    share_work *work, size_t v, int home, const unsigned char *key, void *context);

/* The positions of this round. */
static void for_round(share_work *work, share_see *see, void *context) {
    unsigned char key[MOST_KEY];
    for (size_t v = 0; v < work->sharing->count; v++) {
        if (work->part[v] == MPI_ABSENT) continue;
        write_key(work->keys, v, key);
        const uint64_t hash = norma_core_hash(key, work->key_size);
        if (round_of(work, hash) == work->round)
            see(work, v, mpi_home_of(work->call, hash), key, context);
    }
}

static void count_one(
    share_work *work, size_t v, int home, const unsigned char *key, void *context) {
    (void)work, (void)v, (void)key;
    ((uint64_t *)context)[home]++;
}

static void send_one(
    share_work *work, size_t v, int home, const unsigned char *key, void *context) {
    unsigned char *record = norma_mpi_lists_add(context, home);
    memcpy(record, key, work->key_size);
    record[work->key_size] = work->part[v];
}

static norma_result list_keys(share_work *work, mpi_lists *out) {
    const mpi_call *call = work->call;
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    for_round(work, count_one, room);
    const norma_result result = norma_mpi_lists_open(call, room, work->key_size + 1, out);
    norma_core_release(call->core, room, ranks, sizeof *room);
    if (result == NORMA_OK) for_round(work, send_one, out);
    return result;
}

/* ---- at home */

typedef struct key_group {
    uint32_t first, ranks, voters, answer;
} key_group; /* first: a record with its key */

enum { ANSWER_BITS = 30 };

typedef struct key_table {
    const mpi_lists *in;
    size_t key_size, count, slots; /* records; slots is a power of two */
    uint32_t *slot;                /* of the hash: a group + 1; 0: none */
    uint32_t *group_of;            /* of each record */
    key_group *groups;
    uint32_t group_count;
} key_table;

static norma_result open_table(const mpi_call *call, key_table *table) {
    for (table->slots = 16; table->slots < table->count + table->count / 2;) table->slots *= 2;
    table->slot = norma_core_allocate(call->core, table->slots, sizeof *table->slot);
    table->group_of = norma_core_allocate(call->core, table->count, sizeof *table->group_of);
    table->groups = norma_core_allocate(call->core, table->count, sizeof *table->groups);
    if (!table->slot || !table->group_of || !table->groups) return NORMA_ERROR_MEMORY;
    memset(table->slot, 0, table->slots * sizeof *table->slot);
    return NORMA_OK;
}

static void close_table(const mpi_call *call, key_table *table) {
    norma_core_release(call->core, table->slot, table->slots, sizeof *table->slot);
    norma_core_release(call->core, table->group_of, table->count, sizeof *table->group_of);
    norma_core_release(call->core, table->groups, table->count, sizeof *table->groups);
}

typedef struct key_search {
    const key_table *table;
    const unsigned char *key;
} key_search;

static int has_key(const void *context, uint32_t group) {
    const key_search *search = context;
    const key_table *table = search->table;
    return memcmp(norma_mpi_record(table->in, table->groups[group].first), search->key,
               table->key_size) == 0;
}

static void group_record(key_table *table, size_t record) {
    const unsigned char *key = norma_mpi_record(table->in, record);
    const key_search search = {table, key};
    uint32_t *slot = norma_core_table_find(
        table->slot, table->slots, norma_core_hash(key, table->key_size), has_key, &search);
    if (!*slot) {
        table->groups[table->group_count] = (key_group){.first = (uint32_t)record};
        *slot = ++table->group_count;
    }
    key_group *group = &table->groups[*slot - 1];
    table->group_of[record] = *slot - 1;
    group->ranks++;
    group->voters += key[table->key_size] == MPI_VOTES;
}

/* Nobody asks another rank about a position that has no votes, or no other rank. */
static int mpi_is_alone(const share_work *work, const key_group *group) {
    return group->voters == 0 || (work->lend && group->ranks == 1);
}

static norma_result mpi_give_slots(const share_work *work, key_table *table) {
    uint64_t *slots = &work->sharing->slots[work->call->rank];
    for (uint32_t g = 0; g < table->group_count; g++) {
        if (mpi_is_alone(work, &table->groups[g])) continue;
        if (*slots >= MOST_SLOTS) return NORMA_ERROR_OVERFLOW;
        table->groups[g].answer = (uint32_t)(*slots)++;
    }
    return NORMA_OK;
}

enum { ANSWER_OWN = 0, ANSWER_SHARED, ANSWER_ASKED, ANSWER_LENT };

/* What is told to the rank of a record. */
static uint32_t answer_to(const share_work *work, const key_group *group, int votes) {
    const uint32_t lends = work->lend && group->voters == 1;
    if (mpi_is_alone(work, group)) return (uint32_t)ANSWER_OWN << ANSWER_BITS;
    const uint32_t kind = !votes ? ANSWER_ASKED : lends ? ANSWER_LENT : ANSWER_SHARED;
    return kind << ANSWER_BITS | group->answer;
}

static norma_result answer_keys(const share_work *work, const mpi_lists *in, mpi_lists *answers) {
    key_table table = {
        .in = in, .key_size = work->key_size, .count = norma_mpi_lists_total(work->call, in)};
    norma_result result = open_table(work->call, &table);
    if (result == NORMA_OK) {
        for (size_t i = 0; i < table.count; i++) group_record(&table, i);
        result = mpi_give_slots(work, &table);
    }
    if (result == NORMA_OK)
        result = norma_mpi_lists_like(work->call, in, sizeof(uint32_t), answers);
    for (size_t i = 0; i < table.count && result == NORMA_OK; i++) {
        const int votes = norma_mpi_record(in, i)[work->key_size] == MPI_VOTES;
        const uint32_t answer = answer_to(work, &table.groups[table.group_of[i]], votes);
        memcpy(norma_mpi_record(answers, i), &answer, sizeof answer);
    }
    close_table(work->call, &table);
    return result;
}

/* ---- what comes back */

typedef struct share_reader {
    const mpi_lists *answers;
    int *next; /* of each rank */
} share_reader;

static void lend_sum(mpi_sharing *sharing, mpi_place place, uint64_t sum) {
    sharing->loans[sharing->loan_count++] = (mpi_loan){place, sum};
}

static void read_one(
    share_work *work, size_t v, int home, const unsigned char *key, void *context) {
    const share_reader *reader = context;
    mpi_sharing *sharing = work->sharing;
    uint32_t answer;
    (void)key;
    memcpy(&answer, norma_mpi_record(reader->answers, (size_t)reader->next[home]++), sizeof answer);
    const uint32_t kind = answer >> ANSWER_BITS, slot = answer & ((1U << ANSWER_BITS) - 1);
    if (kind == ANSWER_LENT)
        lend_sum(sharing, norma_mpi_place(MPI_SHARED, home, slot), sharing->own);
    mpi_place place = norma_mpi_place(MPI_OWN, 0, 0);
    if (kind == ANSWER_SHARED)
        place = norma_mpi_place(MPI_SHARED, home, slot);
    else if (kind == ANSWER_ASKED)
        place = norma_mpi_place(MPI_ASKED, home, slot);
    else if (work->part[v] == MPI_VOTES)
        place = norma_mpi_place(MPI_OWN, 0, sharing->own++);
    sharing->places[v] = norma_mpi_keep_place(place);
}

static size_t count_lent(const mpi_call *call, const mpi_lists *answers) {
    size_t lent = 0;
    for (size_t i = 0; i < (size_t)answers->starts[call->ranks]; i++) {
        uint32_t answer;
        memcpy(&answer, norma_mpi_record(answers, i), sizeof answer);
        lent += answer >> ANSWER_BITS == ANSWER_LENT;
    }
    return lent;
}

static norma_result make_room_for_loans(const mpi_call *call, mpi_sharing *sharing, size_t more) {
    if (sharing->loan_count + more <= sharing->loan_room) return NORMA_OK;
    const size_t room = sharing->loan_count + more + sharing->loan_room / 4 + LEAST_LOANS;
    mpi_loan *loans = norma_core_allocate(call->core, room, sizeof *loans);
    if (!loans) return NORMA_ERROR_MEMORY;
    if (sharing->loan_count) memcpy(loans, sharing->loans, sharing->loan_count * sizeof *loans);
    norma_core_release(call->core, sharing->loans, sharing->loan_room, sizeof *loans);
    sharing->loans = loans;
    sharing->loan_room = room;
    return NORMA_OK;
}

static norma_result read_answers(share_work *work, const mpi_lists *answers) {
    const mpi_call *call = work->call;
    const size_t ranks = (size_t)call->ranks;
    share_reader reader = {.answers = answers};
    reader.next = norma_core_allocate(call->core, ranks, sizeof *reader.next);
    norma_result result = reader.next
                              ? make_room_for_loans(call, work->sharing, count_lent(call, answers))
                              : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        memcpy(reader.next, answers->starts, ranks * sizeof *reader.next);
        for_round(work, read_one, &reader);
    }
    norma_core_release(call->core, reader.next, ranks, sizeof *reader.next);
    return result;
}

/* ---- rounds */

static norma_result run_round(share_work *work) {
    mpi_call *call = work->call;
    mpi_lists out = {0}, in = {0}, answers = {0}, back = {0};
    norma_result result = norma_mpi_exchange(call, list_keys(work, &out), &out, &in);
    if (result == NORMA_OK) {
        const norma_result mine = answer_keys(work, &in, &answers);
        const norma_result room =
            mine == NORMA_OK ? norma_mpi_lists_like(call, &out, sizeof(uint32_t), &back) : mine;
        result = norma_mpi_agree(call, room);
    }
    norma_mpi_lists_close(call, &in);
    norma_mpi_lists_close(call, &out);
    if (result == NORMA_OK) norma_mpi_answer(call, &answers, &back);
    norma_mpi_lists_close(call, &answers);
    if (result == NORMA_OK) result = norma_mpi_agree(call, read_answers(work, &back));
    norma_mpi_lists_close(call, &back);
    return result;
}

/* A key costs its record where it is sent and where it is received, and its row in the table. */
static uint64_t rounds_for(const share_work *work, size_t budget) {
    uint64_t sent = 0;
    for (size_t v = 0; v < work->sharing->count; v++) sent += work->part[v] != MPI_ABSENT;
    const uint64_t each = 2 * (work->key_size + 1) + sizeof(key_group) + 4 * sizeof(uint32_t),
                   rounds = norma_mpi_largest(work->call, sent * each / budget + 1);
    return rounds < 0x8000 ? rounds : 0x8000;
}

static norma_result open_sharing(const mpi_call *call, mpi_sharing *sharing) {
    const size_t ranks = (size_t)call->ranks;
    if (call->ranks > MPI_MOST_RANKS) return NORMA_ERROR_OVERFLOW;
    sharing->places = norma_core_allocate(call->core, sharing->count, sizeof *sharing->places);
    sharing->slots = norma_core_allocate(call->core, ranks, sizeof *sharing->slots);
    if (!sharing->places || !sharing->slots) return NORMA_ERROR_MEMORY;
    for (size_t v = 0; v < sharing->count; v++)
        sharing->places[v] = norma_mpi_keep_place(norma_mpi_place(MPI_NOWHERE, 0, 0));
    sharing->slots[call->rank] = 0;
    return NORMA_OK;
}

norma_result norma_mpi_share(mpi_call *call, const mpi_keys *keys, const uint8_t *part, int lend,
    size_t budget, mpi_sharing *sharing) {
    share_work work = {.call = call,
        .keys = keys,
        .part = part,
        .lend = lend,
        .key_size = size_of_key(keys),
        .sharing = sharing};
    *sharing = (mpi_sharing){.count = keys->mesh->positions.count, .own = 1};
    norma_result result = norma_mpi_agree(call, open_sharing(call, sharing));
    if (result == NORMA_OK) work.rounds = rounds_for(&work, budget);
    for (; work.round < work.rounds && result == NORMA_OK; work.round++) result = run_round(&work);
    if (result == NORMA_OK) {
        const uint64_t mine = sharing->slots[call->rank];
        MPI_Allgather(&mine, 1, MPI_UINT64_T, sharing->slots, 1, MPI_UINT64_T, call->comm);
    } else {
        norma_mpi_sharing_close(call, sharing);
    }
    return result;
}

void norma_mpi_sharing_close(const mpi_call *call, mpi_sharing *sharing) {
    norma_core_release(call->core, sharing->places, sharing->count, sizeof *sharing->places);
    norma_core_release(call->core, sharing->loans, sharing->loan_room, sizeof *sharing->loans);
    norma_core_release(call->core, sharing->slots, (size_t)call->ranks, sizeof *sharing->slots);
    *sharing = (mpi_sharing){0};
}
