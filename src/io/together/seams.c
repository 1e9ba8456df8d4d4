/* seams.c: one surface in more files than one process should hold. What the faces of some tiles add
 * at the positions on their borders goes into a file of votes; such files are joined, in any order
 * and any tree; and who computes one tile takes from them what it shares with all others. Sums do
 * not depend on the order of their terms, so the bits are those of norma_together_compute for all
 * tiles at once.
 *
 * A file of votes: a head, a table of tiles by their hashes, records by their positions, a checksum
 * of each block of records, and one of all the rest. */
#include "core/call/table.h"
#include "io/together/together.h"
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { IN_BLOCK = 128, VERSION = 1, BYTE_ORDER_MARK = 0x01020304, ROUNDED = 1, EVERYWHERE = 2 };
enum { LEAST_PLACE = -30, MOST_PLACE = 40 }; /* of an open_sum's top, and more than doubles need */

static const int64_t MOST_DIGIT = (int64_t)1 << 60; /* two of them have a sum */
static const char MAGIC[8] = {'N', 'O', 'R', 'M', 'A', 'V', 'T', 'S'};
static const uint64_t JOINED_AT_ONCE = (uint64_t)1 << 26; /* bytes, of all files that are joined */

typedef struct seams_head {
    char magic[8];
    uint32_t order, version, record, weight; /* record: bytes of one */
    uint32_t flags, unused;
    uint64_t tiles, tile_bytes, records;
} seams_head;

typedef struct seams_tile {
    uint64_t hash, faces;
    const char *name, *from; /* from: the file of votes that has it */
} seams_tile;

struct seams {
    const char *path;
    seams_head head;
    char *names; /* the table; names end in zeros */
    uint64_t *sums;
    uint64_t next; /* record to be read */
    position_votes *some, last;
    size_t at, count;     /* records of some: taken, and all */
    position_votes *near; /* those that the tile at hand may share */
    size_t near_count;
    int missing, touching; /* positions of the tile that are not among them, or lie inside it */
    double where[3];
};

/* ---- what is wrong with a file */

static norma_document_result fail_seams(
    const char *path, norma_document_error *error, const char *what) {
    const norma_document named = {.path = (char *)(uintptr_t)path};
    return norma_document_fail(&named, error, NORMA_DOCUMENT_ERROR_MALFORMED, NULL, "%s", what);
}

static const char NO_VOTES[] =
    "is not a file of votes; expected a file that norma seams votes or merge wrote";
static const char DAMAGED[] = "damaged votes: a checksum does not match; make the file again";

/* ---- order */

static int compare_records(const void *a, const void *b) {
    return norma_together_compare(((const position_votes *)a)->at, ((const position_votes *)b)->at);
}

static int order_of_tiles(const void *a, const void *b) {
    const seams_tile *p = a, *q = b;
    return p->hash != q->hash ? (p->hash < q->hash ? -1 : 1) : strcmp(p->name, q->name);
}

static int has_bounded_digits(const open_sum *sum) {
    for (int k = 0; k < 4; ++k)
        for (int place = 0; place < OPEN_SUM_PLACES; ++place)
            if (sum->digits[k][place] > MOST_DIGIT || sum->digits[k][place] < -MOST_DIGIT) return 0;
    return 1;
}

/* A record that this program may have written, after the one before. */
static int is_sound(const position_votes *record, const position_votes *before) {
    return norma_core_finite(record->at) && has_bounded_digits(&record->sum) && record->rank >= 1 &&
           record->sum.top >= LEAST_PLACE && record->sum.top <= MOST_PLACE &&
           (!before || norma_together_compare(before->at, record->at) < 0);
}

/* ---- writing */

typedef struct seams_writing {
    file_writer *writer;
    const char *path;
    seams_head head;
    growing_bytes table, sums;
    position_votes *block;
    size_t in_block;
    uint64_t bytes;
    int failed;
} seams_writing;

static void put_in_seams(seams_writing *w, const void *bytes, size_t size) {
    if (!w->failed) w->failed = norma_file_writer_write(w->writer, bytes, size);
    w->bytes += size;
}

static void put_votes_block(seams_writing *w) {
    const size_t size = w->in_block * sizeof *w->block;
    const uint64_t sum = norma_core_hash(w->block, size);
    if (!w->in_block) return;
    put_in_seams(w, w->block, size);
    norma_io_append(&w->sums, &sum, sizeof sum);
    w->in_block = 0;
}

static void put_votes(seams_writing *w, const position_votes *record) {
    w->block[w->in_block++] = *record;
    ++w->head.records;
    if (w->in_block == IN_BLOCK) put_votes_block(w);
}

static uint64_t sum_of_rest(const seams_head *head, const void *table, const void *sums) {
    const uint64_t blocks = (head->records + IN_BLOCK - 1) / IN_BLOCK,
                   parts[] = {norma_core_hash(head, sizeof *head),
                       norma_core_hash(table, (size_t)head->tile_bytes),
                       norma_core_hash(sums, (size_t)blocks * sizeof(uint64_t))};
    return norma_core_hash(parts, sizeof parts);
}

/* tiles: ordered. */
static void make_tile_table(seams_writing *w, const seams_tile *tiles, size_t count) {
    static const char zeros[8] = "";
    for (size_t i = 0; i < count; ++i) {
        const size_t length = strlen(tiles[i].name) + 1;
        const uint64_t numbers[] = {tiles[i].hash, tiles[i].faces, length + (8 - length % 8) % 8};
        norma_io_append(&w->table, numbers, sizeof numbers);
        norma_io_append(&w->table, tiles[i].name, length);
        norma_io_append(&w->table, zeros, (8 - length % 8) % 8);
    }
    w->head.tiles = count;
    w->head.tile_bytes = w->table.size;
}

static norma_document_result fail_writing(seams_writing *w, norma_document_error *error) {
    if (w->failed == ENOMEM || w->table.failed || w->sums.failed || !w->block)
        return norma_document_fail_memory(NULL, error);
    return norma_document_fail_file(w->path, error, "cannot be written", w->failed);
}

static norma_document_result begin_seams(seams_writing *w, const char *path, const seams_head *like,
    const seams_tile *tiles, size_t count, norma_document_error *error) {
    *w = (seams_writing){.path = path, .head = *like};
    memcpy(w->head.magic, MAGIC, sizeof MAGIC);
    w->head.order = BYTE_ORDER_MARK;
    w->head.version = VERSION;
    w->head.record = sizeof(position_votes);
    w->head.records = 0;
    make_tile_table(w, tiles, count);
    w->block = norma_io_allocate(IN_BLOCK, sizeof *w->block);
    if (!w->block || w->table.failed) return fail_writing(w, error);
    w->failed = norma_file_writer_open(path, &w->writer);
    put_in_seams(w, &w->head, sizeof w->head);
    put_in_seams(w, w->table.data, w->table.size);
    return w->failed ? fail_writing(w, error) : NORMA_DOCUMENT_OK;
}

/* The head is known at last. */
static norma_document_result end_seams(
    seams_writing *w, norma_document_result result, norma_document_error *error) {
    if (!result) {
        put_votes_block(w);
        if (w->sums.failed) w->failed = ENOMEM; /* and they are too few to be hashed */
        const uint64_t rest = w->failed ? 0 : sum_of_rest(&w->head, w->table.data, w->sums.data);
        put_in_seams(w, w->sums.data, w->sums.size);
        put_in_seams(w, &rest, sizeof rest);
        if (!w->failed) w->failed = norma_file_writer_patch(w->writer, 0, &w->head, sizeof w->head);
        if (!w->failed) {
            w->failed = norma_file_writer_commit(w->writer);
            w->writer = NULL;
        }
        if (w->failed) result = fail_writing(w, error);
    }
    norma_file_writer_abandon(w->writer);
    free(w->table.data);
    free(w->sums.data);
    free(w->block);
    return result;
}

/* ---- reading */

void norma_seams_close(seams *s) {
    if (!s) return;
    free(s->names);
    free(s->sums);
    free(s->some);
    free(s->near);
    free(s);
}

/* Whether a weight is one that votes have. */
static int is_summed(uint32_t weight) {
    return weight <= NORMA_WEIGHT_ANGLE_LENGTHS && weight != NORMA_WEIGHT_VISIBLE;
}

static const char *wrong_head(const seams_head *head, uint64_t size) {
    const uint64_t blocks = head->records / IN_BLOCK + (head->records % IN_BLOCK != 0);
    if (memcmp(head->magic, MAGIC, sizeof MAGIC) != 0) return NO_VOTES;
    if (head->order != BYTE_ORDER_MARK || head->version != VERSION ||
        head->record != sizeof(position_votes))
        return "votes of another version of norma seams, or of a machine of another byte order";
    if (head->tile_bytes > size || head->tiles > size / 32 ||
        head->records > size / sizeof(position_votes) ||
        size != sizeof *head + head->tile_bytes + head->records * sizeof(position_votes) +
                    (blocks + 1) * sizeof(uint64_t))
        return "truncated or damaged votes: does not have the size stated in its header";
    return is_summed(head->weight) ? NULL : DAMAGED;
}

static uint64_t first_of_records(const seams *s) { return sizeof s->head + s->head.tile_bytes; }

static norma_document_result read_table_and_sums(
    seams *s, const file_window *window, norma_document_error *error) {
    const uint64_t blocks = (s->head.records + IN_BLOCK - 1) / IN_BLOCK,
                   at = first_of_records(s) + s->head.records * sizeof(position_votes);
    uint64_t rest;
    s->names = norma_io_block((size_t)s->head.tile_bytes + 1, 1);
    s->sums = norma_io_block((size_t)blocks + 1, sizeof *s->sums);
    s->some = norma_io_block(
        s->head.records < IN_BLOCK ? (size_t)s->head.records + 1 : IN_BLOCK, sizeof *s->some);
    if (!s->names || !s->sums || !s->some) return norma_document_fail_memory(NULL, error);
    int failed = norma_window_read(window, sizeof s->head, s->names, (size_t)s->head.tile_bytes);
    if (!failed) failed = norma_window_read(window, at, s->sums, (size_t)blocks * sizeof *s->sums);
    if (!failed)
        failed = norma_window_read(window, at + blocks * sizeof *s->sums, &rest, sizeof rest);
    if (failed) return norma_document_fail_file(s->path, error, "cannot be read", failed);
    return rest == sum_of_rest(&s->head, s->names, s->sums) ? NORMA_DOCUMENT_OK
                                                            : fail_seams(s->path, error, DAMAGED);
}

static norma_document_result read_all_but_records(
    seams *s, const file_window *window, norma_document_error *error) {
    const uint64_t size = norma_window_stamp(window)->size;
    if (size < sizeof s->head) return fail_seams(s->path, error, NO_VOTES);
    const int failed = norma_window_read(window, 0, &s->head, sizeof s->head);
    if (failed) return norma_document_fail_file(s->path, error, "cannot be read", failed);
    const char *wrong = wrong_head(&s->head, size);
    return wrong ? fail_seams(s->path, error, wrong) : read_table_and_sums(s, window, error);
}

/* The file is opened again for each block: thousands may be joined, of which a process could not
 * keep all open. */
norma_document_result norma_seams_open(
    const char *path, seams **opened, norma_document_error *error) {
    file_window *window;
    seams *s = *opened = calloc(1, sizeof *s);
    if (!s) return norma_document_fail_memory(NULL, error);
    s->path = path;
    const int failed = norma_window_open(path, &window);
    if (failed) return norma_document_fail_file(path, error, "cannot be read", failed);
    const norma_document_result result = read_all_but_records(s, window, error);
    norma_window_close(window);
    return result;
}

/* Adds the tiles of a file to a list, as they stand in its table. 0: the table is damaged. */
static int list_tiles(const seams *s, seams_tile *tiles) {
    uint64_t at = 0;
    for (uint64_t i = 0; i < s->head.tiles; ++i) {
        uint64_t numbers[3];
        if (s->head.tile_bytes - at < sizeof numbers) return 0;
        memcpy(numbers, s->names + at, sizeof numbers);
        at += sizeof numbers;
        if (numbers[2] < 1 || numbers[2] > s->head.tile_bytes - at ||
            s->names[at + numbers[2] - 1] != '\0')
            return 0;
        tiles[i] = (seams_tile){numbers[0], numbers[1], s->names + at, s->path};
        at += numbers[2];
    }
    return at == s->head.tile_bytes;
}

/* The block that the next record lies in, from its first on; checked. */
static norma_document_result read_votes_block(seams *s, norma_document_error *error) {
    const uint64_t block = s->next / IN_BLOCK, first = block * IN_BLOCK,
                   left = s->head.records - first;
    s->count = left < IN_BLOCK ? (size_t)left : IN_BLOCK;
    const size_t size = s->count * sizeof *s->some;
    file_window *window;
    int failed = norma_window_open(s->path, &window);
    if (failed) return norma_document_fail_file(s->path, error, "cannot be read", failed);
    failed =
        norma_window_read(window, first_of_records(s) + first * sizeof *s->some, s->some, size);
    norma_window_close(window);
    if (failed) return norma_document_fail_file(s->path, error, "cannot be read", failed);
    int sound = norma_core_hash(s->some, size) == s->sums[block];
    for (size_t i = 0; i < s->count && sound; ++i)
        sound = is_sound(&s->some[i], i ? &s->some[i - 1] : NULL);
    s->at = (size_t)(s->next - first);
    return sound ? NORMA_DOCUMENT_OK : fail_seams(s->path, error, DAMAGED);
}

/* s->last: the next record, while there is one (*more). */
static norma_document_result read_record(seams *s, int *more, norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    *more = s->next < s->head.records;
    if (*more && s->at == s->count) result = read_votes_block(s, error);
    if (!*more || result) return result;
    if (s->next && norma_together_compare(s->last.at, s->some[s->at].at) >= 0)
        return fail_seams(s->path, error, DAMAGED);
    s->last = s->some[s->at++];
    ++s->next;
    return result;
}

/* ---- a tile and the votes of all */

void norma_seams_choose(const seams *s, norma_weight *weight, int *rounded, int *everywhere) {
    *weight = (norma_weight)s->head.weight;
    *rounded = (s->head.flags & ROUNDED) != 0;
    *everywhere = (s->head.flags & EVERYWHERE) != 0;
}

static norma_document_result find_tile(together_run *run) {
    const seams *s = run->seams;
    seams_tile *tiles = norma_io_allocate((size_t)s->head.tiles, sizeof *tiles);
    int found = 0;
    if (!tiles) return norma_document_fail_memory(NULL, run->error);
    const int sound = list_tiles(s, tiles);
    for (size_t i = 0; sound && i < s->head.tiles; ++i)
        found |= tiles[i].hash == run->tile.hash && tiles[i].faces == run->tile.faces;
    free(tiles);
    if (!sound) return fail_seams(s->path, run->error, DAMAGED);
    if (found) return NORMA_DOCUMENT_OK;
    const norma_document named = {.path = (char *)(uintptr_t)run->files[0].input};
    return norma_document_fail(&named, run->error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
        "is not among the %llu tiles of %.400s: its votes are missing there, or it has changed "
        "since",
        (unsigned long long)s->head.tiles, s->path);
}

/* Bisection by blocks: the first record that is not left of the tile. */
static norma_document_result skip_to(seams *s, const double low[3], norma_document_error *error) {
    uint64_t first = 0, end = (s->head.records + IN_BLOCK - 1) / IN_BLOCK;
    while (end - first > 1) {
        const uint64_t middle = first + (end - first) / 2;
        s->next = middle * IN_BLOCK;
        const norma_document_result result = read_votes_block(s, error);
        if (result) return result;
        if (s->some[0].at[0] < low[0])
            first = middle;
        else
            end = middle;
    }
    s->next = first * IN_BLOCK;
    s->at = s->count = 0;
    s->last.at[0] = s->last.at[1] = s->last.at[2] = -INFINITY;
    return NORMA_DOCUMENT_OK;
}

static int lies_within(const double at[3], const together_run *run) {
    for (int k = 0; k < 3; ++k)
        if (at[k] < run->tile.low[k] || at[k] > run->tile.high[k]) return 0;
    return 1;
}

norma_document_result norma_seams_find(together_run *run) {
    seams *s = run->seams;
    size_t room = 0;
    int more = 1;
    norma_document_result result = find_tile(run);
    if (!result) result = skip_to(s, run->tile.low, run->error);
    while (!result && !(result = read_record(s, &more, run->error)) && more &&
           s->last.at[0] <= run->tile.high[0]) {
        if (!lies_within(s->last.at, run)) continue;
        position_votes *near = norma_io_add(&s->near, &room, &s->near_count, sizeof *near);
        if (!near) return norma_document_fail_memory(NULL, run->error);
        *near = s->last;
    }
    return result;
}

static int refuse_position(seams *s, int *reason, const double at[3]) {
    *reason = 1;
    memcpy(s->where, at, sizeof s->where);
    return -1;
}

/* A visit_position: what all tiles add at a position on this one's border. */
int norma_seams_take(void *user, position_votes *votes) {
    seams *s = user;
    const position_votes *found =
        s->near_count ? bsearch(votes, s->near, s->near_count, sizeof *s->near, compare_records)
                      : NULL;
    if (!found) return votes->border ? refuse_position(s, &s->missing, votes->at) : 0;
    if (!votes->border && votes->sum.votes) return refuse_position(s, &s->touching, votes->at);
    *votes = *found;
    return 0;
}

norma_document_result norma_seams_fail(const together_run *run) {
    const seams *s = run->seams;
    const norma_document named = {.path = (char *)(uintptr_t)run->files[0].input};
    if (s->missing) return fail_seams(s->path, run->error, DAMAGED);
    return norma_document_fail(&named, run->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "the border of another tile touches this one inside, at (%.9g, %.9g, %.9g), where its "
        "votes are not in %.300s; make all votes with --everywhere",
        s->where[0], s->where[1], s->where[2], s->path);
}

/* ---- votes */

typedef struct seams_votes {
    together_run run;
    const norma_seams_options *options;
    position_votes *records; /* of all tiles */
    size_t count, room;
    seams_tile *tiles;
} seams_votes;

static int keep_border(void *user, position_votes *votes) {
    seams_votes *v = user;
    if (!votes->border) return 0;
    position_votes *record = norma_io_add(&v->records, &v->room, &v->count, sizeof *record);
    if (!record) return ENOMEM;
    *record = *votes;
    return 0;
}

static norma_document_result take_tile(seams_votes *v, size_t number, uint64_t memory) {
    together_run *run = &v->run;
    member m;
    const norma_together_file *file = &run->files[number];
    run->number = number;
    run->tile = (surface_tile){.marks = 1, .everywhere = v->options->everywhere};
    run->votes = norma_spill_open(run->folder, sizeof(position_votes));
    if (!run->votes) return norma_document_fail_memory(NULL, run->error);
    norma_document_result result = norma_member_open(run, &m);
    if (!result) result = norma_together_take_votes(run, &m);
    norma_member_close(&m);
    const int failed = result ? 0 : norma_together_join(run->votes, NULL, memory, keep_border, v);
    if (failed) result = norma_together_fail_spill(run, failed);
    norma_spill_close(run->votes);
    v->tiles[number] = (seams_tile){run->tile.hash, run->tile.faces, file->input, ""};
    if (!result && norma_together_tell(run, 1))
        result = norma_document_fail_cancelled(NULL, run->error);
    return result;
}

/* A tile without a face adds nothing, however often. */
static norma_document_result refuse_repeated(
    const seams_tile *tiles, size_t count, int within, norma_document_error *error) {
    for (size_t i = 1; i < count; ++i) {
        const seams_tile *a = &tiles[i - 1], *b = &tiles[i];
        if (a->hash != b->hash || !b->faces) continue;
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
            within ? "%.400s: the same surface as %.400s; each tile counts once"
                   : "%.400s: has the tile %.300s, which %.400s has as well; each tile counts once",
            within ? b->name : b->from, within ? a->name : b->name, a->from);
    }
    return NORMA_DOCUMENT_OK;
}

static norma_document_result write_votes(
    seams_votes *v, const char *output, norma_seams_summary *summary) {
    const seams_head like = {.weight = (uint32_t)v->run.compute.weight,
        .flags =
            (v->run.equal.rounded ? ROUNDED : 0u) | (v->options->everywhere ? EVERYWHERE : 0u)};
    seams_writing w;
    if (v->run.count) qsort(v->tiles, v->run.count, sizeof *v->tiles, order_of_tiles);
    if (v->count) qsort(v->records, v->count, sizeof *v->records, compare_records);
    norma_document_result result = refuse_repeated(v->tiles, v->run.count, 1, v->run.error);
    if (result) return result;
    result = begin_seams(&w, output, &like, v->tiles, v->run.count, v->run.error);
    for (size_t i = 0; i < v->count && !result;) {
        position_votes sum = v->records[i];
        while (++i < v->count && compare_records(&sum, &v->records[i]) == 0)
            norma_together_add_votes(&sum, &v->records[i]);
        put_votes(&w, &sum);
    }
    result = end_seams(&w, result, v->run.error);
    *summary = (norma_seams_summary){v->run.count, w.head.records, w.bytes};
    return result;
}

static void copy_seams_options(
    norma_seams_options *copy, const norma_seams_options *given, norma_document_error *error) {
    norma_document_clear(error);
    norma_document_copy_options(copy, sizeof *copy, sizeof *copy, given);
}

static const char *bad_tile_list(const char *const *paths, size_t count, const char *output) {
    if (!output) return "the votes have no path";
    if (!count || !paths) return "no files were given";
    for (size_t i = 0; i < count; ++i)
        if (!paths[i]) return "a file has no path";
    return NULL;
}

norma_document_result norma_seams_votes(const char *const *tiles, size_t count, const char *output,
    const norma_seams_options *given, norma_seams_summary *summary, norma_document_error *error) {
    norma_seams_options options;
    norma_seams_summary unused;
    copy_seams_options(&options, given, error);
    seams_votes v = {.options = &options};
    const char *bad = bad_tile_list(tiles, count, output);
    if (!bad && !is_summed((uint32_t)options.weight))
        bad = "the weight is not summed over faces; expected angle, area, uniform, max, angle_area "
              "or angle_lengths";
    if (bad)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    norma_together_file *files = norma_io_allocate(count, sizeof *files);
    v.tiles = norma_io_allocate(count, sizeof *v.tiles);
    char *folder = norma_together_folder_of(output);
    v.run = (together_run){.files = files,
        .count = count,
        .error = error,
        .options.threads = options.threads,
        .compute = {.weight = options.weight,
            .progress = options.progress,
            .progress_user = options.progress_user},
        .degenerate = norma_io_allocate(count, sizeof *v.run.degenerate),
        .folder = options.temporary_folder ? options.temporary_folder : folder,
        .passes = 1};
    norma_document_result result = files && v.tiles && folder && v.run.degenerate
                                       ? NORMA_DOCUMENT_OK
                                       : norma_document_fail_memory(NULL, error);
    for (size_t i = 0; i < count && !result; ++i)
        files[i] = (norma_together_file){.input = tiles[i], .format = options.format};
    v.run.equal.rounded = !result && (options.rounded || norma_together_rounds(files, count));
    for (size_t i = 0; i < count && !result; ++i)
        result = take_tile(&v, i, options.max_memory ? options.max_memory : JOINED_AT_ONCE);
    if (!result) result = write_votes(&v, output, summary ? summary : &unused);
    free(files);
    free(v.tiles);
    free(v.records);
    free(v.run.degenerate);
    free(folder);
    return result;
}

/* ---- merge: the files side by side, the least position first */

typedef struct seams_merging {
    seams **files;
    size_t count;
    uint32_t *heap; /* of files that have a record left */
    size_t in_heap;
    norma_document_error *error;
} seams_merging;

static int leads_in_heap(const seams_merging *m, size_t a, size_t b) {
    return compare_records(&m->files[m->heap[a]]->last, &m->files[m->heap[b]]->last) < 0;
}

static void sink_in_heap(seams_merging *m, size_t at) {
    for (size_t child; (child = 2 * at + 1) < m->in_heap; at = child) {
        const uint32_t moved = m->heap[at];
        if (child + 1 < m->in_heap && leads_in_heap(m, child + 1, child)) ++child;
        if (!leads_in_heap(m, child, at)) return;
        m->heap[at] = m->heap[child];
        m->heap[child] = moved;
    }
}

/* The file on top goes on to its next record, or leaves. */
static norma_document_result advance_first(seams_merging *m) {
    int more;
    const norma_document_result result = read_record(m->files[m->heap[0]], &more, m->error);
    if (result) return result;
    if (!more) m->heap[0] = m->heap[--m->in_heap];
    if (m->in_heap) sink_in_heap(m, 0);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result begin_heap(seams_merging *m) {
    for (size_t i = 0; i < m->count; ++i) {
        int more;
        const norma_document_result result = read_record(m->files[i], &more, m->error);
        if (result) return result;
        if (more) m->heap[m->in_heap++] = (uint32_t)i;
    }
    for (size_t i = m->in_heap / 2; i-- > 0;) sink_in_heap(m, i);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result merge_records(
    seams_merging *m, seams_writing *w, const norma_seams_options *options) {
    uint64_t all = 0;
    norma_document_result result = begin_heap(m);
    for (size_t i = 0; i < m->count; ++i) all += m->files[i]->head.records;
    for (uint64_t done = 0; m->in_heap && !result;) {
        position_votes sum = m->files[m->heap[0]]->last;
        const uint64_t told = done;
        for (;;) {
            ++done;
            result = advance_first(m);
            const seams *next = m->in_heap ? m->files[m->heap[0]] : NULL;
            if (result || !next || compare_records(&sum, &next->last) != 0) break;
            norma_together_add_votes(&sum, &next->last);
            if (!has_bounded_digits(&sum.sum))
                return fail_seams(next->path, m->error, "more votes than one position can have");
        }
        put_votes(w, &sum);
        if (w->failed) return fail_writing(w, m->error);
        if (done >> 12 != told >> 12 && options->progress &&
            options->progress(options->progress_user, (double)done / (double)all))
            return norma_document_fail_cancelled(NULL, m->error);
    }
    return result;
}

static norma_document_result refuse_mixed(
    const seams *first, const seams *other, norma_document_error *error) {
    const seams_head *a = &first->head, *b = &other->head;
    const char *what = a->weight != b->weight ? "another weight"
                       : (a->flags ^ b->flags) & ROUNDED
                           ? "positions that are rounded to floats, or not, unlike it (a glTF's "
                             "are; --rounded does so for other tiles)"
                       : a->flags != b->flags ? "votes everywhere, or not, unlike it"
                                              : NULL;
    const norma_document named = {.path = (char *)(uintptr_t)other->path};
    return what ? norma_document_fail(&named, error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
                      "cannot be merged with %.400s: has %s", first->path, what)
                : NORMA_DOCUMENT_OK;
}

/* All tiles in their order, each once. *tiles: to be freed. */
static norma_document_result join_tiles(
    const seams_merging *m, const norma_seams_options *options, seams_tile **tiles, size_t *count) {
    size_t all = 0;
    for (size_t i = 0; i < m->count; ++i) all += (size_t)m->files[i]->head.tiles;
    *count = 0;
    *tiles = norma_io_allocate(all, sizeof **tiles);
    if (!*tiles) return norma_document_fail_memory(NULL, m->error);
    for (size_t i = 0; i < m->count; ++i) {
        if (!list_tiles(m->files[i], *tiles + *count))
            return fail_seams(m->files[i]->path, m->error, DAMAGED);
        *count += (size_t)m->files[i]->head.tiles;
    }
    if (all) qsort(*tiles, all, sizeof **tiles, order_of_tiles);
    norma_document_result result = refuse_repeated(*tiles, all, 0, m->error);
    if (!result && options->tiles && options->tiles != all)
        result = norma_document_fail(NULL, m->error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
            "the votes are of %zu tiles, expected %zu", all, options->tiles);
    return result;
}

static norma_document_result open_all(seams_merging *m, const char *const *votes) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    m->files = norma_io_allocate(m->count, sizeof *m->files);
    m->heap = norma_io_allocate(m->count, sizeof *m->heap);
    if (!m->files || !m->heap) return norma_document_fail_memory(NULL, m->error);
    for (size_t i = 0; i < m->count && !result; ++i) {
        result = norma_seams_open(votes[i], &m->files[i], m->error);
        if (!result) result = refuse_mixed(m->files[0], m->files[i], m->error);
    }
    return result;
}

norma_document_result norma_seams_merge(const char *const *votes, size_t count, const char *output,
    const norma_seams_options *given, norma_seams_summary *summary, norma_document_error *error) {
    norma_seams_options options;
    seams_merging m = {.count = count, .error = error};
    seams_tile *tiles = NULL;
    seams_writing w;
    size_t tile_count = 0;
    copy_seams_options(&options, given, error);
    const char *bad = bad_tile_list(votes, count, output);
    if (bad)
        return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", bad);
    norma_document_result result = open_all(&m, votes);
    if (!result) result = join_tiles(&m, &options, &tiles, &tile_count);
    if (!result) {
        result = begin_seams(&w, output, &m.files[0]->head, tiles, tile_count, error);
        if (!result) result = merge_records(&m, &w, &options);
        result = end_seams(&w, result, error);
        if (summary) *summary = (norma_seams_summary){tile_count, w.head.records, w.bytes};
    }
    for (size_t i = 0; m.files && i < count; ++i) norma_seams_close(m.files[i]);
    free((void *)m.files);
    free(m.heap);
    free(tiles);
    return result;
}
