/* guard.c: the list of sources, and the question whether an output is one of them. */
#define _POSIX_C_SOURCE 200809L
#include "cli/files/guard.h"
#include "cli/files/input.h"
#include "cli/process/worker.h"
#include "cli/process/errors.h"
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct source {
    dev_t device;
    ino_t inode;
    char *named_by; /* the input that names it; NULL: it is read itself */
} source;

struct cli_guard {
    const cli_subcommand *command;
    pthread_mutex_t lock;
    source *sources;
    size_t count, capacity;
    int watches;    /* an output exists already, so there is something to lose */
    int incomplete; /* memory was out: nothing that exists may be written any more */
};

cli_guard *cli_guard_new(const cli_subcommand *command) {
    cli_guard *guard = calloc(1, sizeof *guard);
    if (!guard) {
        cli_out_of_memory();
        return NULL;
    }
    guard->command = command;
    pthread_mutex_init(&guard->lock, NULL);
    return guard;
}

void cli_guard_free(cli_guard *guard) {
    if (!guard) return;
    for (size_t i = 0; i < guard->count; ++i) free(guard->sources[i].named_by);
    free(guard->sources);
    pthread_mutex_destroy(&guard->lock);
    free(guard);
}

/* Only regular files can be lost: devices and pipes are written as they are. */
static int regular_file(const char *path, int standard, struct stat *status) {
    const int failed = strcmp(path, "-") == 0 ? fstat(standard, status) : stat(path, status);
    return !failed && S_ISREG(status->st_mode);
}

static int is_one(const struct stat *a, const struct stat *b) {
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

/* The length of path's folder, its last slash included. */
static size_t folder_of(const char *path, struct stat *status) {
    const char *slash = strrchr(path, '/');
    const size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    char *folder = length ? strndup(path, length) : strdup(".");
    if (!folder || stat(folder, status)) *status = (struct stat){0};
    free(folder);
    return length;
}

int cli_is_same_output(const char *a, const char *b) {
    struct stat of_a, of_b;
    if (strcmp(a, b) == 0) return 1;
    if (strcmp(a, "-") == 0 || strcmp(b, "-") == 0) return 0;
    if (stat(a, &of_a) == 0 && stat(b, &of_b) == 0)
        return S_ISREG(of_a.st_mode) && is_one(&of_a, &of_b);
    return strcmp(a + folder_of(a, &of_a), b + folder_of(b, &of_b)) == 0 && is_one(&of_a, &of_b);
}

static const source *find(const cli_guard *guard, const struct stat *status) {
    for (size_t i = 0; i < guard->count; ++i)
        if (guard->sources[i].inode == status->st_ino && guard->sources[i].device == status->st_dev)
            return &guard->sources[i];
    return NULL;
}

static void add(cli_guard *guard, const struct stat *status, const char *named_by) {
    char *copy = named_by ? strdup(named_by) : NULL;
    source *grown = guard->sources;
    if (guard->count == guard->capacity) {
        const size_t capacity = guard->capacity ? 2 * guard->capacity : 64;
        grown = realloc(guard->sources, capacity * sizeof *grown);
        if (grown) guard->capacity = capacity;
    }
    if (grown) guard->sources = grown;
    if (!grown || (named_by && !copy)) {
        guard->incomplete = 1;
        free(copy);
        return;
    }
    guard->sources[guard->count++] = (source){status->st_dev, status->st_ino, copy};
}

void cli_guard_read(cli_guard *guard, const char *path) {
    struct stat status;
    if (!guard || !regular_file(path, STDIN_FILENO, &status)) return;
    pthread_mutex_lock(&guard->lock);
    add(guard, &status, NULL);
    pthread_mutex_unlock(&guard->lock);
}

typedef struct named {
    cli_guard *guard;
    const char *by;
} named;

static int add_named(void *user, const char *path) {
    const named *names = user;
    struct stat status;
    if (!regular_file(path, STDIN_FILENO, &status)) return 0;
    pthread_mutex_lock(&names->guard->lock);
    add(names->guard, &status, names->by);
    pthread_mutex_unlock(&names->guard->lock);
    return 0;
}

void cli_guard_document(cli_guard *guard, norma_document *document, const char *input) {
    named names = {guard, cli_input_name(input)};
    norma_document_error error;
    if (!guard || !guard->watches) return;
    if (norma_document_visit_files(document, add_named, &names, &error) ==
        NORMA_DOCUMENT_ERROR_MEMORY)
        guard->incomplete = 1;
}

/* ---- between processes */

typedef struct sources_message {
    size_t count;
    int incomplete;
} sources_message;

typedef struct source_message {
    dev_t device;
    ino_t inode;
    size_t name; /* bytes of it; 0: none */
} source_message;

int cli_guard_watches(const cli_guard *guard) { return guard && guard->watches; }

size_t cli_guard_count(cli_guard *guard) { return guard ? guard->count : 0; }

void cli_guard_send(cli_guard *guard, size_t *first, const cli_worker *worker) {
    if (!guard) return;
    pthread_mutex_lock(&guard->lock);
    const sources_message message = {guard->count - *first, guard->incomplete};
    cli_worker_send(worker, &message, sizeof message);
    for (; *first < guard->count; ++*first) {
        const source *from = &guard->sources[*first];
        const source_message one = {
            from->device, from->inode, from->named_by ? strlen(from->named_by) + 1 : 0};
        cli_worker_send(worker, &one, sizeof one);
        cli_worker_send(worker, from->named_by, one.name);
    }
    pthread_mutex_unlock(&guard->lock);
}

static int receive_source(cli_guard *guard, const cli_worker *worker) {
    source_message one;
    if (!cli_worker_receive(worker, &one, sizeof one)) return 0;
    char *name = one.name ? malloc(one.name) : NULL;
    const int fine = !one.name || (name && cli_worker_receive(worker, name, one.name));
    const struct stat status = {.st_dev = one.device, .st_ino = one.inode};
    if (fine) add(guard, &status, name);
    free(name);
    return fine;
}

int cli_guard_receive(cli_guard *guard, const cli_worker *worker) {
    sources_message message = {0};
    int fine = !guard || cli_worker_receive(worker, &message, sizeof message);
    for (size_t i = 0; i < message.count && fine; ++i) fine = receive_source(guard, worker);
    if (guard) guard->incomplete |= message.incomplete;
    return fine;
}

static int refuse(const cli_guard *guard, const char *output, const source *found) {
    const char *name = strcmp(output, "-") == 0 ? "standard output" : output;
    if (found->named_by)
        return cli_usage(guard->command,
            "%s is used by %s and would be overwritten; expected another name for the output", name,
            found->named_by);
    return cli_usage(guard->command,
        "%s is read by this command and would be overwritten; expected another name for the output",
        name);
}

int cli_guard_output(cli_guard *guard, const char *output, const char *own) {
    struct stat status, of_own;
    if (!guard || !regular_file(output, STDOUT_FILENO, &status)) return CLI_OK;
    if (own && regular_file(own, STDIN_FILENO, &of_own) && of_own.st_dev == status.st_dev &&
        of_own.st_ino == status.st_ino)
        return CLI_OK;
    pthread_mutex_lock(&guard->lock);
    guard->watches = 1;
    const source *found = find(guard, &status);
    const int incomplete = guard->incomplete;
    const int result = found ? refuse(guard, output, found) : CLI_OK;
    pthread_mutex_unlock(&guard->lock);
    return !result && incomplete ? cli_out_of_memory() : result;
}
