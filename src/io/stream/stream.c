/* stream.c: bytes on their way: work that threads share, sinks, files made piece by piece in order,
 * texts and rows that are
 * equal. */
#define _POSIX_C_SOURCE 200809L
#include "io/stream/stream.h"
#include "core/call/call.h"
#include "core/call/table.h"
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

/* ---- Work of the formats that threads share: the core's own threads. */

norma_result norma_io_tasks_told(
    const norma_options *options, size_t count, norma_task *task, void *context) {
    core_call call;
    norma_result result = norma_core_begin(&call, options);
    return result || count == 0 ? result : norma_core_parallel(&call, count, task, context);
}

/* How many threads that number means: at least 1. */
static size_t io_threads(uint32_t threads) {
    const norma_options options = {.struct_size = sizeof options, .threads = threads};
    core_call call;
    norma_core_begin(&call, &options);
    return norma_core_workers(&call);
}

/* ---- Bytes on their way out, gathered into blocks before they are handed on, or kept. */

norma_sink *norma_sink_create(norma_write *write, void *user) {
    norma_sink *sink = malloc(sizeof *sink);
    unsigned char *block = malloc(SINK_BLOCK);
    if (!sink || !block) {
        free(sink);
        free(block);
        return NULL;
    }
    *sink = (norma_sink){.write = write, .user = user, .block = block, .capacity = SINK_BLOCK};
    return sink;
}

static void hand_on_bytes(norma_sink *sink, const void *bytes, size_t size) {
    if (!sink->failed && size > 0) sink->failed = sink->write(sink->user, bytes, size) != 0;
}

/* So that size bytes more fit behind those that are kept. Without memory what is there is dropped:
 * a block, if there is one, has room for SINK_BLOCK. */
static void keep_more(norma_sink *sink, size_t size) {
    unsigned char *grown = sink->used > SIZE_MAX / 4 - size
                               ? NULL
                               : norma_io_grow(sink->block, &sink->capacity, sink->used + size, 1);
    if (grown) {
        sink->block = grown;
        return;
    }
    sink->failed = 1;
    sink->used = 0;
}

void norma_sink_flush(norma_sink *sink) {
    if (!sink->write) {
        keep_more(sink, SINK_BLOCK);
        return;
    }
    hand_on_bytes(sink, sink->block, sink->used);
    sink->used = 0;
}

void norma_sink_put_slowly(norma_sink *sink, const void *bytes, size_t size) {
    if (!sink->write) {
        keep_more(sink, size);
        if (sink->failed) return;
    } else {
        norma_sink_flush(sink);
        if (size >= SINK_BLOCK / 2) {
            hand_on_bytes(sink, bytes, size);
            return;
        }
    }
    memcpy(sink->block + sink->used, bytes, size);
    sink->used += size;
}

int norma_sink_finish(norma_sink *sink) {
    norma_sink_flush(sink);
    int failed = sink->failed;
    free(sink->block);
    free(sink);
    return failed;
}

int norma_memory_sink_write(void *growing, const void *bytes, size_t size) {
    norma_io_append(growing, bytes, size);
    return ((const growing_bytes *)growing)->failed;
}

int norma_compare_sink_write(void *compare_sink, const void *bytes, size_t size) {
    norma_compare_sink *sink = compare_sink;
    if (size > sink->left || memcmp(sink->expected, bytes, size) != 0) return 1;
    sink->expected += size;
    sink->left -= size;
    return 0;
}

/* ---- A file made piece by piece, by threads, and handed on in order. The calling thread
 * hands on what is ready, and makes pieces itself while nothing is: so that what the system needs
 * for writing goes on beside the making. */

enum { MOST_HELPERS = 255 };

typedef struct line { /* in which pieces stand */
    pthread_mutex_t lock;
    pthread_cond_t ready, room; /* told: the calling thread, the others */
    norma_make_data_run *make;
    void *context;
    norma_watch *watch;
    norma_data_run *pieces;
    unsigned char *made;
    size_t count, places;   /* piece i stands at place i % places */
    size_t next, handed_on; /* the next to be made; how many are gone */
    int stop;
} line;

static void ordered_make_run(line *l, size_t index) {
    norma_data_run *piece = &l->pieces[index % l->places];
    if (!piece->sink.block) norma_sink_flush(&piece->sink); /* its first block */
    piece->sink.used = 0;
    piece->span = NULL;
    piece->span_size = 0;
    if (!piece->sink.failed) l->make(l->context, index, piece);
}

/* Takes a piece to make, if there is one whose place is free. */
static int ordered_take(line *l, size_t *index) {
    if (l->stop || l->next >= l->count || l->next >= l->handed_on + l->places) return 0;
    *index = l->next++;
    return 1;
}

static void *ordered_help(void *context) {
    line *l = context;
    size_t index;
    pthread_mutex_lock(&l->lock);
    while (!l->stop && l->next < l->count) {
        if (!ordered_take(l, &index)) {
            pthread_cond_wait(&l->room, &l->lock);
            continue;
        }
        pthread_mutex_unlock(&l->lock);
        ordered_make_run(l, index);
        pthread_mutex_lock(&l->lock);
        l->made[index % l->places] = 1;
        pthread_cond_signal(&l->ready);
    }
    pthread_mutex_unlock(&l->lock);
    return NULL;
}

static norma_ordered_result hand_on_piece(
    const norma_data_run *piece, norma_write *write, void *user) {
    if (piece->sink.failed) return NORMA_ORDERED_MEMORY;
    if (piece->sink.used && write(user, piece->sink.block, piece->sink.used))
        return NORMA_ORDERED_REFUSED;
    return piece->span_size && write(user, piece->span, piece->span_size) ? NORMA_ORDERED_REFUSED
                                                                          : NORMA_ORDERED_OK;
}

static norma_ordered_result lead(line *l, norma_write *write, void *user) {
    norma_ordered_result result = NORMA_ORDERED_OK;
    size_t index;
    pthread_mutex_lock(&l->lock);
    while (!result && l->handed_on < l->count) {
        const size_t place = l->handed_on % l->places;
        if (l->watch && atomic_load(&l->watch->cancelled)) {
            result = NORMA_ORDERED_REFUSED;
        } else if (l->made[place]) {
            pthread_mutex_unlock(&l->lock);
            result = hand_on_piece(&l->pieces[place], write, user);
            pthread_mutex_lock(&l->lock);
            l->made[place] = 0;
            ++l->handed_on;
            pthread_cond_broadcast(&l->room);
        } else if (ordered_take(l, &index)) {
            pthread_mutex_unlock(&l->lock);
            ordered_make_run(l, index);
            pthread_mutex_lock(&l->lock);
            l->made[index % l->places] = 1;
        } else {
            norma_watch_wait(l->watch, &l->ready, &l->lock);
        }
    }
    l->stop = 1;
    pthread_cond_broadcast(&l->room);
    pthread_mutex_unlock(&l->lock);
    return result;
}

/* A thread that cannot be had is done without. Signals are for the calling thread: one that hangs
 * in a write must be the one that is interrupted. */
static size_t start_helpers(line *l, size_t threads, pthread_t helpers[MOST_HELPERS]) {
    size_t started = 0;
#if !defined(_WIN32) /* which sends signals to threads of their own */
    sigset_t all, before;
    sigfillset(&all);
    /* Signals raised by a thread's own instruction must reach their handler: blocked, they would
     * end the process. */
    static const int own[] = {SIGBUS, SIGSEGV, SIGILL, SIGFPE};
    for (size_t i = 0; i < sizeof own / sizeof *own; ++i) sigdelset(&all, own[i]);
    const int masked = pthread_sigmask(SIG_BLOCK, &all, &before) == 0;
#endif
    while (started + 1 < threads && started < MOST_HELPERS && started + 1 < l->count &&
           pthread_create(&helpers[started], NULL, ordered_help, l) == 0)
        ++started;
#if !defined(_WIN32)
    if (masked) pthread_sigmask(SIG_SETMASK, &before, NULL);
#endif
    return started;
}

static norma_ordered_result ordered_run(line *l, size_t threads, norma_write *write, void *user) {
    pthread_t helpers[MOST_HELPERS];
    const size_t started = start_helpers(l, threads, helpers);
    norma_ordered_result result = lead(l, write, user);
    for (size_t i = 0; i < started; ++i) pthread_join(helpers[i], NULL);
    return result;
}

static norma_ordered_result open_and_run(line *l, size_t threads, norma_write *write, void *user) {
    if (pthread_mutex_init(&l->lock, NULL)) return NORMA_ORDERED_MEMORY;
    norma_ordered_result result = NORMA_ORDERED_MEMORY;
    if (pthread_cond_init(&l->ready, NULL) == 0) {
        if (pthread_cond_init(&l->room, NULL) == 0) {
            result = ordered_run(l, threads, write, user);
            pthread_cond_destroy(&l->room);
        }
        pthread_cond_destroy(&l->ready);
    }
    pthread_mutex_destroy(&l->lock);
    return result;
}

norma_ordered_result norma_write_ordered(norma_ordered_how how, size_t count,
    norma_make_data_run *make, void *context, norma_write *write, void *user) {
    const size_t workers = io_threads(how.threads);
    line l = {.make = make,
        .context = context,
        .watch = how.watch,
        .count = count,
        .places = workers > count / 2 ? count + 1 : 2 * workers};
    l.pieces = norma_io_allocate(l.places, sizeof *l.pieces);
    l.made = norma_io_allocate(l.places, 1);
    norma_ordered_result result =
        l.pieces && l.made ? open_and_run(&l, workers, write, user) : NORMA_ORDERED_MEMORY;
    for (size_t i = 0; l.pieces && i < l.places; ++i) free(l.pieces[i].sink.block);
    free(l.pieces);
    free(l.made);
    return result;
}

/* ---- Texts in a table by their hash. */

typedef struct name_search {
    char *const *names;
    const char *text;
    size_t length;
} name_search;

static int has_name(const void *context, uint32_t number) {
    const name_search *search = context;
    const char *name = search->names[number];
    return strlen(name) == search->length && memcmp(name, search->text, search->length) == 0;
}

static uint32_t *name_slot(const norma_names *names, const char *text, size_t length) {
    const name_search search = {names->list, text, length};
    return norma_core_table_find(
        names->slots, names->slot_count, norma_core_hash(text, length), has_name, &search);
}

static int grow_name_slots(norma_names *names) {
    const size_t size = norma_core_table_size(2 * (names->count + 1));
    uint32_t *slots = norma_io_allocate(size, sizeof *slots);
    if (!slots) return 0;
    free(names->slots);
    names->slots = slots;
    names->slot_count = size;
    for (size_t i = 0; i < names->count; ++i)
        *name_slot(names, names->list[i], strlen(names->list[i])) = (uint32_t)i + 1;
    return 1;
}

uint32_t norma_names_number(norma_names *names, const char *text, size_t length) {
    if (2 * (names->count + 1) > names->slot_count && !grow_name_slots(names)) return UINT32_MAX;
    uint32_t *slot = name_slot(names, text, length);
    if (*slot) return *slot - 1;
    char *copy = norma_io_copy_text(text, length);
    char **name =
        copy ? norma_io_add(&names->list, &names->room, &names->count, sizeof *name) : NULL;
    if (!name) {
        free(copy);
        return UINT32_MAX;
    }
    *name = copy;
    *slot = (uint32_t)names->count;
    return *slot - 1;
}

void norma_names_free(norma_names *names) {
    for (size_t i = 0; i < names->count; ++i) free(names->list[i]);
    free(names->list);
    free(names->slots);
}

/* ---- Rows of bytes in a table by their hash; what is told is by comparing all bytes. */

typedef struct row_search {
    norma_row_of *row_of;
    const void *context;
    const unsigned char *bytes;
    size_t length;
} row_search;

static int is_equal_row(const void *context, uint32_t row) {
    const row_search *search = context;
    size_t length;
    const unsigned char *bytes = search->row_of(search->context, row, &length);
    return length == search->length && memcmp(bytes, search->bytes, length) == 0;
}

int norma_equal_rows(norma_row_of *row_of, const void *context, size_t count, uint32_t *first) {
    if (count > UINT32_MAX - 1 || count > SIZE_MAX / 16) return 0;
    const size_t size = norma_core_table_size(count);
    uint32_t *table = calloc(size, sizeof *table);
    row_search search = {.row_of = row_of, .context = context};
    if (!table) return 0;
    for (size_t row = 0; row < count; ++row) {
        search.bytes = row_of(context, row, &search.length);
        uint32_t *slot = norma_core_table_find(
            table, size, norma_core_hash(search.bytes, search.length), is_equal_row, &search);
        if (!*slot) *slot = (uint32_t)row + 1;
        first[row] = *slot - 1;
    }
    free(table);
    return 1;
}

int norma_number_rows(
    norma_row_of *row_of, const void *context, size_t count, uint32_t *numbers, size_t *distinct) {
    *distinct = 0;
    if (!norma_equal_rows(row_of, context, count, numbers)) return 0;
    for (size_t row = 0; row < count; ++row)
        numbers[row] = numbers[row] == row ? (uint32_t)(*distinct)++ : numbers[numbers[row]];
    return 1;
}
