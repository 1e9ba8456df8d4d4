/* shard.c: one of several jobs that share a set of files: each N-th, so that a folder of large
 * files does not fall to one job. All jobs find the same files in the same order. */
#include "cli/check/check_command.h"
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

void check_keep_shard(cli_inputs *inputs, size_t number, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < inputs->count; ++i) {
        if (i % count != number - 1) {
            free(inputs->paths[i]);
            continue;
        }
        inputs->paths[kept] = inputs->paths[i];
        inputs->tails[kept++] = inputs->tails[i];
    }
    inputs->count = kept;
}
