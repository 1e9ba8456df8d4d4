/* merge_shards.c: reports of shards are put together only as a whole set: a shard that is missing,
 * or there twice, would make a wrong report that looks right. */
#define _POSIX_C_SOURCE 200809L
#include "cli/report/merge.h"
#include "cli/process/errors.h"
#include "cli/text/memory_stream.h"
#include <stdlib.h>
#include <string.h>

static size_t whole_number(const json_t *value) {
    return json_is_integer(value) && json_integer_value(value) > 0
               ? (size_t)json_integer_value(value)
               : 0;
}

void report_note_shard(report_merge *merged, size_t report, const json_t *object) {
    report_shard *shard = &merged->shards[report];
    const json_t *of = json_object_get(object, "shard"),
                 *options = json_object_get(object, "options");
    if (json_array_size(json_object_get(object, "missing_shards"))) merged->status = CLI_FILE;
    if (of) {
        shard->number = whole_number(json_array_get(of, 0));
        shard->count = whole_number(json_array_get(of, 1));
    }
    if (options && !shard->options) shard->options = json_dumps(options, JSON_SORT_KEYS);
}

static const char *name_of_report(const report_merge *merged, size_t report) {
    return merged->files.paths[report];
}

static int same_options(const char *a, const char *b) {
    return a && b ? strcmp(a, b) == 0 : a == b;
}

/* Beside the first report. */
static int check_shard(const report_merge *merged, size_t report) {
    const report_shard *one = &merged->shards[report], *first = merged->shards;
    const char *name = name_of_report(merged, report), *first_name = name_of_report(merged, 0);
    if (one->count && (one->number == 0 || one->number > one->count)) {
        cli_error("%s: shard %zu of %zu does not exist", name, one->number, one->count);
        return CLI_FILE;
    }
    if (!one->count != !first->count) {
        cli_error("%s: is a shard, but %s is none; expected all shards of a set",
            one->count ? name : first_name, one->count ? first_name : name);
        return CLI_FILE;
    }
    if (one->count != first->count) {
        cli_error("%s: is one of %zu shards, but %s is one of %zu", name, one->count, first_name,
            first->count);
        return CLI_FILE;
    }
    if (same_options(one->options, first->options)) return CLI_OK;
    cli_error("%s: was made with other options than %s: %s, not %s", name, first_name,
        one->options ? one->options : "none", first->options ? first->options : "none");
    return CLI_FILE;
}

typedef struct shard_place {
    size_t number, report;
} shard_place;

static int compare_shards(const void *a, const void *b) {
    const shard_place *one = a, *other = b;
    if (one->number != other->number) return one->number < other->number ? -1 : 1;
    return one->report < other->report ? -1 : one->report > other->report;
}

/* Sorted; each number at most once. */
static int refuse_doubles(const report_merge *merged, const shard_place *places, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (places[i].number == places[i - 1].number) {
            cli_error("%s: shard %zu of %zu is already in %s",
                name_of_report(merged, places[i].report), places[i].number, merged->shards->count,
                name_of_report(merged, places[i - 1].report));
            return CLI_FILE;
        }
    return CLI_OK;
}

enum { MOST_NAMED = 100 };

/* As JSON; a long list ends with null. */
static char *list_missing(const shard_place *places, size_t count, size_t shards) {
    cli_memory_stream text;
    size_t next = 0, named = 0;
    if (!cli_memory_open(&text)) return NULL;
    fputc('[', text.out);
    for (size_t number = 1; number <= shards && named <= MOST_NAMED; ++number) {
        if (next < count && places[next].number == number) {
            ++next;
            continue;
        }
        if (named) fputs(", ", text.out);
        if (named++ < MOST_NAMED)
            fprintf(text.out, "%zu", number);
        else
            fputs("null", text.out);
    }
    fputc(']', text.out);
    return cli_memory_close(&text) ? text.text : NULL;
}

static int tell_missing(const report_merge *merged, const char *list, int allowed) {
    cli_error("shards %s of %zu are missing%s", list, merged->shards->count,
        allowed ? "" : "; --partial joins the others");
    return CLI_FILE;
}

int report_check_shards(report_merge *merged, size_t count, int allows_missing, char **missing) {
    int status = CLI_OK;
    for (size_t i = 0; i < count && !status; ++i) status = check_shard(merged, i);
    const size_t shards = merged->shards->count;
    if (status || !shards) return status;
    shard_place *places = calloc(count, sizeof *places);
    if (!places) return cli_out_of_memory();
    for (size_t i = 0; i < count; ++i) places[i] = (shard_place){merged->shards[i].number, i};
    qsort(places, count, sizeof *places, compare_shards);
    status = refuse_doubles(merged, places, count);
    if (!status && count < shards) {
        *missing = list_missing(places, count, shards);
        if (!*missing) status = cli_out_of_memory();
        if (!status && tell_missing(merged, *missing, allows_missing) && !allows_missing)
            status = CLI_FILE;
        merged->status = CLI_FILE;
    }
    free(places);
    return status;
}
