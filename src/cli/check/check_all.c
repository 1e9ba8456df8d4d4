/* Which files are checked, several at once; and their order in a report for people: the worst
 * first, those without problems last, and what several of them have in common told once. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check.h"
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int check_list_add(check_list *list, const check_entry *entry) {
    check_entry *grown = cli_grow(list->entries, list->count, &list->room, sizeof *grown);
    if (!grown) return 0;
    list->entries = grown;
    list->entries[list->count++] = *entry;
    return 1;
}

void check_list_free(check_list *list) {
    for (size_t i = 0; i < list->count; ++i) free(list->entries[i].text);
    free(list->entries);
    *list = (check_list){0};
}

static int more_first(size_t a, size_t b) { return a == b ? 0 : a > b ? -1 : 1; }

int check_compare_entries(const void *a, const void *b) {
    const check_entry *one = a, *other = b;
    int order = more_first(one->errors, other->errors);
    if (!order) order = more_first(one->warnings, other->warnings);
    if (!order) order = one->is_clean - other->is_clean;
    return order ? order : strcmp(one->path, other->path);
}

void check_list_sort(check_list *list) {
    if (list->count)
        qsort(list->entries, list->count, sizeof *list->entries, check_compare_entries);
}

/* ---- What is told once: a line with CHECK_SAME and a key in front, up to CHECK_SAME_END. The
 * first file that has it tells it, and at CHECK_ALSO names the others. */

enum { KEY_DIGITS = 16, FILES_NAMED = 3 };

typedef struct same_line {
    uint64_t key;
    size_t entry; /* of the list */
} same_line;

static int compare_same(const void *a, const void *b) {
    const same_line *one = a, *other = b;
    if (one->key != other->key) return one->key < other->key ? -1 : 1;
    return one->entry < other->entry ? -1 : one->entry > other->entry;
}

static const char *find_byte(const char *at, const char *end, char byte) {
    const char *found = at < end ? memchr(at, byte, (size_t)(end - at)) : NULL;
    return found ? found : end;
}

static uint64_t read_same_key(const char *at) {
    uint64_t key = 0;
    for (int i = 0; i < KEY_DIGITS; ++i)
        key = 16 * key + (uint64_t)(at[i] <= '9' ? at[i] - '0' : at[i] - 'a' + 10);
    return key;
}

/* lines NULL: only counts them. */
static size_t find_same(const check_list *list, same_line *lines) {
    size_t count = 0;
    for (size_t i = 0; i < list->count; ++i) {
        const char *at = list->entries[i].text, *end = at + list->entries[i].size;
        for (; (at = find_byte(at, end, CHECK_SAME)) + KEY_DIGITS < end; ++at, ++count)
            if (lines) lines[count] = (same_line){read_same_key(at + 1), i};
    }
    return count;
}

static const same_line *first_of(const same_line *lines, size_t count, uint64_t key) {
    size_t low = 0;
    while (count > low) {
        const size_t middle = low + (count - low) / 2;
        if (lines[middle].key < key)
            low = middle + 1;
        else
            count = middle;
    }
    return lines + low;
}

/* " Also in b.obj, c.obj and 2 more files." */
static void write_also(FILE *out, const check_list *list, const same_line *first,
    const same_line *end, const check_settings *settings) {
    size_t files = 0;
    for (const same_line *at = first + 1; at < end && at->key == first->key; ++at) {
        if (at->entry == at[-1].entry || files++ >= FILES_NAMED) continue;
        if (files == 1 && settings->style.width)
            fputs("\n    Also in ", out);
        else
            fputs(files == 1 ? " Also in " : ", ", out);
        cli_write_outside(out, check_shown_path(list->entries[at->entry].path));
    }
    if (files > FILES_NAMED)
        fprintf(out, " and %zu more %s", files - FILES_NAMED,
            files - FILES_NAMED == 1 ? "file" : "files");
    if (files) fputc('.', out);
}

/* From at, behind CHECK_SAME, to behind CHECK_SAME_END. */
static const char *write_same(FILE *out, const check_list *list, size_t entry, const char *at,
    const char *end, const same_line *lines, size_t count, const check_settings *settings) {
    const char *last = find_byte(at, end, CHECK_SAME_END), *also = find_byte(at, last, CHECK_ALSO);
    const same_line *first = first_of(lines, count, read_same_key(at));
    at += KEY_DIGITS;
    if (first->entry == entry) {
        fwrite(at, 1, (size_t)(also - at), out);
        write_also(out, list, first, lines + count, settings);
        if (also < last) fwrite(also + 1, 1, (size_t)(last - also - 1), out);
    }
    return last < end ? last + 1 : end;
}

int check_list_write(
    const check_list *list, const check_format *format, FILE *out, const check_settings *settings) {
    const size_t count = find_same(list, NULL);
    same_line *lines = malloc((count + 1) * sizeof *lines);
    if (!lines) return 0;
    find_same(list, lines);
    qsort(lines, count, sizeof *lines, compare_same);
    for (size_t i = 0; i < list->count; ++i) {
        const char *at = list->entries[i].text, *end = at + list->entries[i].size;
        check_begin_entry(list, i, format, out);
        while (at < end) {
            const char *mark = find_byte(at, end, CHECK_SAME);
            fwrite(at, 1, (size_t)(mark - at), out);
            at = mark + KEY_DIGITS < end
                     ? write_same(out, list, i, mark + 1, end, lines, count, settings)
                     : end;
        }
    }
    free(lines);
    return 1;
}

void check_begin_entry(
    const check_list *list, size_t entry, const check_format *format, FILE *out) {
    const check_entry *at = &list->entries[entry];
    if (format->before_clean && list->count > 1 && at->is_clean && (entry == 0 || !at[-1].is_clean))
        fputs(format->before_clean, out);
}

/* ---- Checks several files at once and reports them in their order. A thread takes the
 * next file and writes its part of the report into memory; parts go to the output in the order of
 * files. No file is started more than a window ahead of the output, so memory does not grow with
 * the number of files. Several files are checked in a process of their own (process.h), which sends
 * the parts: if it ends, the files that were being checked are checked again, each alone. */

enum { WINDOW = 256, MOST_WORKERS = 64 };

/* ---- the report, in the order of files */

typedef struct file_part {
    check_entry entry;
    int done;
    double fraction; /* of the file's work */
} file_part;

typedef struct check_collector {
    const check_settings *settings;
    const check_format *format;
    const cli_inputs *inputs;
    FILE *out;
    size_t told;             /* files */
    int told_any;            /* something stands in the report */
    file_part parts[WINDOW]; /* file i at i % WINDOW */
    check_totals totals;
    check_results *results; /* of SARIF, whose number is limited; NULL: parts are written at once */
    cli_progress progress;
    double work, worked; /* of all files, and what is done of it: see work_of */
} check_collector;

/* What one file gave. */
typedef struct checked_file {
    size_t file;
    cli_memory_stream report, known; /* its part of each; known: of a new baseline */
    check_totals totals;
} checked_file;

static void add_totals(check_totals *sum, const check_totals *more) {
    for (size_t i = 0; i < CHECK_SUMS; ++i) sum->sums[i] += more->sums[i];
    sum->status = cli_worse(sum->status, more->status);
    sum->incomplete |= more->incomplete;
    sum->forgot |= more->forgot;
    sum->unreported |= more->unreported;
}

/* May take over the text. */
static void write_file_part(check_collector *all, check_entry *part) {
    if (!all->results && !all->format->is_worst_first) {
        if (part->size && all->told_any) fputs(all->format->between, all->out);
        all->told_any |= part->size != 0;
        fwrite(part->text, 1, part->size, all->out);
        return;
    }
    if (all->results ? check_results_add(all->results, part->text, part->size)
                     : check_list_add(all->totals.list, part)) {
        if (!all->results) part->text = NULL;
        return;
    }
    all->totals.status = cli_out_of_memory();
    all->totals.incomplete = all->totals.unreported = 1;
}

static void tell_what_is_next(check_collector *all) {
    cli_progress_hide(&all->progress); /* a report may go to the same terminal */
    while (all->told < all->inputs->count && all->parts[all->told % WINDOW].done) {
        file_part *part = &all->parts[all->told % WINDOW];
        write_file_part(all, &part->entry);
        free(part->entry.text);
        *part = (file_part){0};
        ++all->told;
    }
}

/* Megabytes, and as much for the file itself as ten thousand of its bytes take. */
static double work_of(const check_collector *all, size_t file) {
    return cli_megabytes(all->inputs->list[file].path) + 0.01;
}

/* Never less than before: a file may be checked again. */
static void note_fraction(check_collector *all, size_t file, double fraction) {
    file_part *part = &all->parts[file % WINDOW];
    if (fraction <= part->fraction || !all->progress.enabled) return;
    all->worked += (fraction - part->fraction) * work_of(all, file);
    part->fraction = fraction;
}

static int report_percent(check_collector *all) {
    return cli_progress_report(&all->progress, fmin(all->worked / all->work, 1));
}

/* Takes over the bytes. */
static void collect_checked(check_collector *all, const checked_file *checked) {
    file_part *part = &all->parts[checked->file % WINDOW];
    part->entry = (check_entry){.path = all->inputs->list[checked->file].path,
        .errors = checked->totals.errors,
        .warnings = checked->totals.warnings,
        .is_clean = checked->totals.clean > 0,
        .text = checked->report.text,
        .size = checked->report.size};
    part->done = 1;
    note_fraction(all, checked->file, 1);
    if (checked->totals.unreported)
        cli_error("%s: not reported: out of memory", cli_input_name(part->entry.path));
    add_totals(&all->totals, &checked->totals);
    if (all->settings->baseline)
        check_baseline_add(all->settings->baseline, checked->known.text, checked->known.size,
            checked->totals.forgot);
    free(checked->known.text);
    tell_what_is_next(all);
}

/* ---- files checked at once, here or in a worker */

typedef struct check_pool {
    check_settings settings;
    const check_configs *configs;
    check_collector *all;     /* of this process */
    const cli_worker *worker; /* NULL: not in a worker; parts go to all */
    size_t sources_sent;
    pthread_mutex_t lock;
    pthread_cond_t moved;    /* the output went on */
    size_t next, told, last; /* files: to be taken, already told, not to be taken any more */
    unsigned char done[WINDOW];
} check_pool;

enum { MESSAGE_BEGUN, MESSAGE_FRACTION, MESSAGE_DONE };

typedef struct check_message {
    int kind;
    size_t file, size, known; /* bytes of its parts */
    double fraction;
} check_message;

static void send_message(const check_pool *pool, const check_message *message) {
    cli_worker_send(pool->worker, message, sizeof *message);
}

static void send_checked(check_pool *pool, const checked_file *checked) {
    const check_message message = {.kind = MESSAGE_DONE,
        .file = checked->file,
        .size = checked->report.size,
        .known = checked->known.size};
    send_message(pool, &message);
    cli_worker_send(pool->worker, &checked->totals, sizeof checked->totals);
    cli_worker_send(pool->worker, checked->report.text, message.size);
    cli_worker_send(pool->worker, checked->known.text, message.known);
    cli_guard_send(pool->settings.files->guard, &pool->sources_sent, pool->worker);
    free(checked->report.text);
    free(checked->known.text);
}

typedef struct file_progress {
    check_pool *pool;
    size_t file;
    double told;
} file_progress;

/* A norma_progress of any thread. A worker's caller shows it. */
static int report_progress(void *user, double fraction) {
    static const double step = 0.01;
    file_progress *at = user;
    check_pool *pool = at->pool;
    check_collector *all = pool->all;
    int stop = cli_interrupted();
    if (all->inputs->count == 1) return cli_progress_report(&all->progress, fraction);
    if (!all->progress.enabled || pthread_mutex_trylock(&pool->lock)) return stop;
    if (fraction >= at->told + step) {
        const check_message message = {
            .kind = MESSAGE_FRACTION, .file = at->file, .fraction = fraction};
        at->told = fraction;
        if (pool->worker)
            send_message(pool, &message);
        else
            note_fraction(all, at->file, fraction);
    }
    if (!pool->worker) stop = report_percent(all);
    pthread_mutex_unlock(&pool->lock);
    return stop;
}

/* 0: none is left. */
static int take(check_pool *pool, size_t *file) {
    pthread_mutex_lock(&pool->lock);
    while (pool->next < pool->last && pool->next - pool->told >= WINDOW)
        pthread_cond_wait(&pool->moved, &pool->lock);
    const int is_left = pool->next < pool->last;
    if (is_left) {
        *file = pool->next++;
        const check_message begun = {.kind = MESSAGE_BEGUN, .file = *file};
        if (pool->worker) send_message(pool, &begun);
    }
    pthread_mutex_unlock(&pool->lock);
    return is_left;
}

static void deliver(check_pool *pool, const checked_file *checked) {
    pthread_mutex_lock(&pool->lock);
    if (pool->worker)
        send_checked(pool, checked);
    else
        collect_checked(pool->all, checked);
    pool->done[checked->file % WINDOW] = 1;
    for (; pool->done[pool->told % WINDOW]; ++pool->told) pool->done[pool->told % WINDOW] = 0;
    pthread_cond_broadcast(&pool->moved);
    pthread_mutex_unlock(&pool->lock);
}

/* Its part of the report, in memory, and what is known of it for a new baseline. */
static checked_file check_into_memory(const check_settings *asked, const check_collector *all,
    const check_config *config, size_t file) {
    checked_file checked = {.file = file};
    check_settings settings = *asked;
    const int is_new = asked->baseline && check_baseline_is_new(asked->baseline),
              fine = !is_new || cli_memory_open(&checked.known);
    settings.known = checked.known.out;
    if (fine && cli_memory_open(&checked.report))
        check_one_file(&settings, config, all->format, file, checked.report.out, &checked.totals);
    checked.totals.forgot |= is_new && !cli_memory_close(&checked.known);
    if (!cli_memory_close(&checked.report)) { /* half a report is worse than none */
        checked.report.size = 0;
        checked.totals.status = cli_worse(checked.totals.status, CLI_FILE);
        checked.totals.incomplete = checked.totals.unreported = 1;
    }
    if (!checked.known.text) checked.known.size = 0;
    return checked;
}

static void *work(void *user) {
    check_pool *pool = user;
    for (size_t file; take(pool, &file);) {
        file_progress progress = {.pool = pool, .file = file};
        check_settings settings = pool->settings;
        settings.progress = report_progress;
        settings.progress_user = &progress;
        const checked_file checked =
            check_into_memory(&settings, pool->all, check_config_of(pool->configs, file), file);
        deliver(pool, &checked);
    }
    pthread_mutex_lock(&pool->lock);
    pthread_cond_broadcast(&pool->moved);
    pthread_mutex_unlock(&pool->lock);
    return NULL;
}

static size_t worker_count(uint32_t threads, size_t files) {
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    size_t count = threads == NORMA_ALL_THREADS ? (size_t)(cores > 0 ? cores : 1) : threads;
    count = count > MOST_WORKERS ? MOST_WORKERS : count;
    return count > files ? files : count;
}

/* From first up to last, in this process. */
static void check_range(check_collector *all, const check_configs *configs,
    const cli_worker *worker, size_t first, size_t last) {
    pthread_t threads[MOST_WORKERS];
    const size_t workers = worker_count(all->settings->threads, last - first);
    size_t started = 0;
    check_pool pool = {.settings = *all->settings,
        .configs = configs,
        .all = all,
        .worker = worker,
        .sources_sent = cli_guard_count(all->settings->files->guard),
        .next = first,
        .told = first,
        .last = last};
    if (workers > 1) pool.settings.threads = 1; /* the files share the cores */
    pool.settings.at_once = workers;
    pthread_mutex_init(&pool.lock, NULL);
    pthread_cond_init(&pool.moved, NULL);
    for (size_t i = 1; i < workers; ++i)
        started += pthread_create(&threads[started], NULL, work, &pool) == 0;
    work(&pool);
    for (size_t i = 0; i < started; ++i) pthread_join(threads[i], NULL);
    pthread_cond_destroy(&pool.moved);
    pthread_mutex_destroy(&pool.lock);
}

static _Noreturn void check_in_worker(check_collector *all, const check_configs *configs,
    const cli_worker *worker, size_t first, size_t last) {
    check_range(all, configs, worker, first, last);
    cli_worker_finish(worker);
}

/* ---- what a worker says */

static int receive_checked(
    check_collector *all, const cli_worker *worker, const check_message *message) {
    checked_file checked = {.file = message->file,
        .report = {.text = malloc(message->size + 1), .size = message->size},
        .known = {.text = malloc(message->known + 1), .size = message->known}};
    const int fine = checked.report.text && checked.known.text &&
                     cli_worker_receive(worker, &checked.totals, sizeof checked.totals) &&
                     cli_worker_receive(worker, checked.report.text, message->size) &&
                     cli_worker_receive(worker, checked.known.text, message->known) &&
                     cli_guard_receive(all->settings->files->guard, worker);
    if (fine) {
        collect_checked(all, &checked);
        return 1;
    }
    free(checked.report.text);
    free(checked.known.text);
    return 0;
}

/* Until it ends. *next: behind the last file that it began. 0: what it said of a file was not heard
 * whole, since it ended there or there was no memory for it. */
static int listen_to(check_collector *all, const cli_worker *worker, size_t *next) {
    check_message message;
    while (cli_worker_receive(worker, &message, sizeof message)) {
        if (message.kind == MESSAGE_BEGUN) *next = message.file + 1;
        if (message.kind == MESSAGE_FRACTION) note_fraction(all, message.file, message.fraction);
        if (message.kind == MESSAGE_DONE && !receive_checked(all, worker, &message)) return 0;
        (void)report_percent(all);
    }
    return 1;
}

static void report_lost_check(
    check_collector *all, const check_configs *configs, size_t file, const char *why) {
    check_settings settings = *all->settings;
    settings.lost = why;
    const checked_file checked =
        check_into_memory(&settings, all, check_config_of(configs, file), file);
    collect_checked(all, &checked);
}

static int is_waited_for(const check_collector *all, size_t file) {
    return all->told <= file && !all->parts[file % WINDOW].done;
}

/* One of the files that were being checked when a worker ended: alone, so that it is known which.
 */
static void check_alone(check_collector *all, const check_configs *configs, size_t file) {
    char why[CLI_WHY_ROOM];
    cli_worker worker;
    size_t next;
    const int side = cli_worker_start(&worker);
    if (side == 0) check_in_worker(all, configs, &worker, file, file + 1);
    if (side < 0) {
        check_range(all, configs, NULL, file, file + 1);
        return;
    }
    const int was_heard = listen_to(all, &worker, &next),
              ended_well = cli_worker_wait(&worker, 1, why);
    if (!was_heard && ended_well) snprintf(why, sizeof why, "out of memory");
    if (!(was_heard && ended_well) && is_waited_for(all, file)) {
        cli_remove_left_by(worker.process, all->settings->files, file);
        report_lost_check(all, configs, file, why);
    }
}

/* What a worker that ended was about. */
static void check_again(
    check_collector *all, const check_configs *configs, const cli_worker *worker, size_t next) {
    for (size_t file = all->told; file < next; ++file)
        if (is_waited_for(all, file)) {
            cli_remove_left_by(worker->process, all->settings->files, file);
            check_alone(all, configs, file);
        }
}

/* A status beside those of the files. */
static int check_in_workers(check_collector *all, const check_configs *configs) {
    const size_t count = all->inputs->count;
    for (size_t next = 0; next < count;) {
        char why[CLI_WHY_ROOM];
        cli_worker worker;
        const int side = count > 1 ? cli_worker_start(&worker) : -1;
        if (side == 0) check_in_worker(all, configs, &worker, next, count);
        if (side < 0) {
            check_range(all, configs, NULL, next, count);
            break;
        }
        const int was_heard = listen_to(all, &worker, &next),
                  is_done = next == count && all->told == count;
        if (cli_worker_wait(&worker, !is_done, why) && was_heard) break;
        if (is_done) { /* its end was no file's fault */
            cli_error("%s", why);
            return CLI_FILE;
        }
        if (next == all->told) ++next; /* it ended between two files: the next one is done alone */
        check_again(all, configs, &worker, next);
    }
    return CLI_OK;
}

static void write_list(check_collector *all) {
    check_list_sort(all->totals.list);
    if (check_list_write(all->totals.list, all->format, all->out, all->settings)) return;
    all->totals.status = cli_out_of_memory();
    all->totals.incomplete = all->totals.unreported = 1;
}

int check_all_files(const check_settings *settings, const check_configs *configs,
    const check_format *format, FILE *out, check_totals *totals) {
    const cli_inputs *inputs = &settings->files->inputs;
    check_collector *all = calloc(1, sizeof *all);
    if (!all) return cli_out_of_memory();
    *all = (check_collector){.settings = settings,
        .format = format,
        .inputs = inputs,
        .out = out,
        .totals.list = totals->list};
    cli_progress_start(&all->progress, "checking",
        inputs->count == 1 ? cli_input_name(inputs->list[0].path) : "files", settings->quiet, 0);
    all->progress.is_uneven = settings->fix != CHECK_FIX_NOTHING; /* how many passes: not known */
    for (size_t i = 0; i < inputs->count && all->progress.enabled; ++i)
        all->work += work_of(all, i);
    const int is_limited = format == &check_format_sarif && !settings->shards;
    if (is_limited && !(all->results = check_results_new())) {
        free(all);
        return cli_out_of_memory();
    }
    const int status = check_in_workers(all, configs);
    if (all->results) check_results_write(all->results, out, &all->totals);
    check_results_free(all->results);
    cli_progress_hide(&all->progress);
    if (format->is_worst_first) write_list(all);
    /* After an interruption, parts may be left behind one that was never begun. */
    for (size_t i = 0; i < WINDOW; ++i) free(all->parts[i].entry.text);
    cli_progress_stop(&all->progress);
    all->totals.status = cli_worse(all->totals.status, status);
    *totals = all->totals;
    free(all);
    return totals->status;
}
