/* thread_pool.c: checks several files at once and reports them in their order. A worker takes the
 * next file and writes its part of the report into memory. The worker that finishes the part due
 * next writes it, and all finished parts behind it, to the output. No file is started more than a
 * window ahead of the output, so memory does not grow with the number of files. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check_command.h"
#include "cli/process/errors.h"
#include "cli/process/progress.h"
#include "cli/text/memory_stream.h"
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WINDOW = 256, MOST_WORKERS = 64 };

typedef struct file_part {
    char *bytes;
    size_t size;
    int done;
} file_part;

typedef struct check_pool {
    const check_settings *settings;
    check_configs *configs;
    const check_format *format;
    const cli_inputs *inputs;
    FILE *out;
    pthread_mutex_t lock;
    pthread_cond_t moved;    /* the output went on */
    size_t next, told;       /* files: to be taken, already told */
    int told_any;            /* something stands in the report */
    file_part parts[WINDOW]; /* file i at i % WINDOW */
    check_totals totals;
    cli_progress progress;
} check_pool;

static void add_totals(check_totals *sum, const check_totals *more) {
    sum->errors += more->errors;
    sum->warnings += more->warnings;
    sum->infos += more->infos;
    sum->files += more->files;
    sum->files_with_trouble += more->files_with_trouble;
    sum->not_checked += more->not_checked;
    sum->known += more->known;
    sum->clean += more->clean;
    sum->hidden += more->hidden;
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        for (size_t severity = 0; severity < CHECK_SEVERITIES; ++severity) {
            sum->by_rule[rule][severity].places += more->by_rule[rule][severity].places;
            sum->by_rule[rule][severity].files += more->by_rule[rule][severity].files;
        }
    sum->status = cli_worse(sum->status, more->status);
}

/* Called with the lock. */
static void tell_what_is_next(check_pool *pool) {
    cli_progress_hide(&pool->progress); /* a report may go to the same terminal */
    while (pool->told < pool->inputs->count && pool->parts[pool->told % WINDOW].done) {
        file_part *part = &pool->parts[pool->told % WINDOW];
        if (part->size && pool->told_any) fputs(pool->format->between, pool->out);
        pool->told_any |= part->size != 0;
        fwrite(part->bytes, 1, part->size, pool->out);
        free(part->bytes);
        *part = (file_part){0};
        ++pool->told;
    }
    pthread_cond_broadcast(&pool->moved);
}

/* A norma_progress of any worker: of one file the seconds, of several how many are done. */
static int report_progress(void *user, double fraction) {
    check_pool *pool = user;
    if (pool->inputs->count == 1) return cli_progress_elapsed(&pool->progress, fraction);
    if (!pool->progress.enabled || pthread_mutex_trylock(&pool->lock)) return cli_interrupted();
    const int stop =
        cli_progress_report(&pool->progress, (double)pool->told / (double)pool->inputs->count);
    pthread_mutex_unlock(&pool->lock);
    return stop;
}

static const check_config *take(check_pool *pool, size_t *file) {
    const check_config *config = NULL;
    pthread_mutex_lock(&pool->lock);
    while (pool->next < pool->inputs->count && pool->next - pool->told >= WINDOW)
        pthread_cond_wait(&pool->moved, &pool->lock);
    if (pool->next < pool->inputs->count) {
        *file = pool->next++;
        errno = 0;
        config = check_config_of(pool->configs, pool->inputs->paths[*file]);
        if (!config) { /* nothing that is checked by it could be trusted */
            pool->totals.status =
                cli_worse(pool->totals.status, errno == ENOMEM ? CLI_FILE : CLI_USAGE);
            pool->next = pool->inputs->count;
        }
    }
    pthread_mutex_unlock(&pool->lock);
    return config;
}

static void check_file(check_pool *pool, size_t file, const check_config *config) {
    file_part part = {.done = 1};
    check_totals totals = {0};
    cli_memory_stream gathered;
    if (cli_memory_open(&gathered))
        check_one_file(pool->settings, config, pool->format, file, gathered.out, &totals);
    if (cli_memory_close(&gathered)) {
        part.bytes = gathered.text;
        part.size = gathered.size;
    } else { /* half a report is worse than none */
        totals.status = cli_worse(totals.status, CLI_FILE);
        cli_error("%s: not reported: out of memory", cli_input_name(pool->inputs->paths[file]));
    }
    pthread_mutex_lock(&pool->lock);
    pool->parts[file % WINDOW] = part;
    add_totals(&pool->totals, &totals);
    tell_what_is_next(pool);
    pthread_mutex_unlock(&pool->lock);
}

static void *work(void *user) {
    check_pool *pool = user;
    size_t file;
    for (const check_config *config; (config = take(pool, &file)) != NULL;)
        check_file(pool, file, config);
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

int check_all_files(const check_settings *asked, check_configs *configs, const check_format *format,
    FILE *out, check_totals *totals) {
    const cli_inputs *inputs = &asked->files->inputs;
    check_settings settings = *asked;
    check_pool *pool = calloc(1, sizeof *pool);
    pthread_t threads[MOST_WORKERS];
    size_t workers = worker_count(settings.threads, inputs->count), started = 0;
    if (!pool) {
        cli_error("out of memory");
        return CLI_FILE;
    }
    if (workers > 1) settings.threads = 1; /* the files share the cores */
    settings.at_once = workers;
    *pool = (check_pool){
        .settings = &settings, .configs = configs, .format = format, .inputs = inputs, .out = out};
    settings.progress = report_progress;
    settings.progress_user = pool;
    cli_progress_start(&pool->progress, "checking",
        inputs->count == 1 ? cli_input_name(inputs->paths[0]) : "files", settings.quiet, 0);
    pthread_mutex_init(&pool->lock, NULL);
    pthread_cond_init(&pool->moved, NULL);
    for (size_t i = 1; i < workers; ++i)
        started += pthread_create(&threads[started], NULL, work, pool) == 0;
    work(pool);
    for (size_t i = 0; i < started; ++i) pthread_join(threads[i], NULL);
    /* After an interruption or a bad configuration, parts may be left behind one that was never
     * begun. */
    for (size_t i = 0; i < WINDOW; ++i) free(pool->parts[i].bytes);
    cli_progress_stop(&pool->progress);
    *totals = pool->totals;
    pthread_cond_destroy(&pool->moved);
    pthread_mutex_destroy(&pool->lock);
    free(pool);
    return totals->status;
}
