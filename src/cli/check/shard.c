/* shard.c: one of several jobs that share a set of files: those whose paths, relative to the folder
 * given, have its hash, so that each job can say it of a file that it alone has. And the order of
 * files in reports, which is the same however a set was shared. */
#include "cli/check/check_command.h"
#include "cli/files/find_inputs.h"
#include "cli/process/errors.h"
#include <stdlib.h>
#include <string.h>

static int read_number(const char *text, size_t length, size_t *number) {
    *number = 0;
    if (length == 0 || length > 9) return 0;
    for (size_t i = 0; i < length; ++i) {
        if (text[i] < '0' || text[i] > '9') return 0;
        *number = 10 * *number + (size_t)(text[i] - '0');
    }
    return 1;
}

const char *check_read_shard(const char *text, size_t *number, size_t *count) {
    const size_t length = strcspn(text, "/");
    const int fine = text[length] == '/' && read_number(text, length, number) &&
                     read_number(text + length + 1, strlen(text + length + 1), count);
    return fine && *number >= 1 && *number <= *count ? NULL : "I/N, such as 2/8: I from 1 to N";
}

/* FNV-1a (Fowler, Noll, Vo), 64 bits; its upper half is mixed into the lower one. */
static uint64_t hash_of(const char *path) {
    uint64_t hash = 14695981039346656037u;
    for (; *path; ++path) hash = (hash ^ (unsigned char)*path) * 1099511628211u;
    return hash ^ hash >> 32;
}

/* A path without "./" in front of it. */
static const char *plain(const char *path) {
    while (path[0] == '.' && path[1] == '/') path += 1 + strspn(path + 1, "/");
    return path;
}

static void move_input(cli_inputs *inputs, size_t to, const cli_inputs *from, size_t at) {
    inputs->paths[to] = from->paths[at];
    inputs->tails[to] = from->tails[at];
    inputs->within[to] = from->within[at];
}

void check_keep_shard(cli_inputs *inputs, size_t number, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < inputs->count; ++i) {
        if (hash_of(plain(inputs->paths[i] + inputs->within[i])) % count == number - 1)
            move_input(inputs, kept++, inputs, i);
        else
            free(inputs->paths[i]);
    }
    inputs->count = kept;
}

static int compare_inputs(const void *a, const void *b) {
    const char *const *one = *(const char *const *const *)a, *const *other =
                                                                 *(const char *const *const *)b;
    const int order = strcmp(*one, *other);
    return order ? order : one < other ? -1 : one > other;
}

int check_sort_inputs(cli_inputs *inputs) {
    const size_t count = inputs->count;
    char ***order = malloc((count + 1) * sizeof *order);
    cli_inputs old = *inputs;
    inputs->paths = malloc((count + 1) * sizeof *inputs->paths);
    inputs->tails = malloc((count + 1) * sizeof *inputs->tails);
    inputs->within = malloc((count + 1) * sizeof *inputs->within);
    const int fine = order && inputs->paths && inputs->tails && inputs->within;
    for (size_t i = 0; i < count && fine; ++i) order[i] = &old.paths[i];
    if (fine) qsort(order, count, sizeof *order, compare_inputs);
    for (size_t i = 0; i < count && fine; ++i)
        move_input(inputs, i, &old, (size_t)(order[i] - old.paths));
    inputs->capacity = count + 1;
    free(order);
    cli_inputs unused = fine ? old : *inputs;
    if (!fine) *inputs = old;
    unused.count = 0;
    cli_inputs_free(&unused);
    return fine ? CLI_OK : cli_out_of_memory();
}
