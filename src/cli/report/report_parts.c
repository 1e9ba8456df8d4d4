/* report_parts.c: reports as files, their parts in the order of paths, and shards as whole sets. */
#define _GNU_SOURCE /* memmem */
#include "cli/report/report.h"
#include "cli/check/check.h"
#include "cli/process/process.h"
#include "cli/text/text.h"
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- Reading reports by offset. Entries are sorted by path, and those of a shard lie
 * between those of all others, so the descriptors of the last reports stay open. */

/* Half of the descriptors that a process may have is enough for others. */
static void report_files_open(report_files *files, const char *const *paths) {
    const long most = sysconf(_SC_OPEN_MAX) / 2;
    *files = (report_files){.paths = paths, .keeps = 1};
    if (most > 1) files->keeps = most < REPORT_KEPT ? (size_t)most : REPORT_KEPT;
}

static void report_files_close(report_files *files) {
    for (size_t i = 0; i < REPORT_KEPT; ++i)
        if (files->kept[i].report) close(files->kept[i].file);
    *files = (report_files){0};
}

/* -1: reported. */
static int open_report(report_files *files, size_t report) {
    const size_t slot = report % files->keeps;
    if (files->kept[slot].report == report + 1) return files->kept[slot].file;
    const int file = check_open_regular(files->paths[report]);
    if (file < 0) return -1;
    if (files->kept[slot].report) close(files->kept[slot].file);
    files->kept[slot].report = report + 1;
    files->kept[slot].file = file;
    return file;
}

size_t report_files_read(
    report_files *files, size_t report, uint64_t offset, char *bytes, size_t size) {
    const int file = open_report(files, report);
    size_t filled = 0;
    files->failed |= file < 0;
    if (file < 0) return 0;
    while (filled < size) {
        const ssize_t got = pread(file, bytes + filled, size - filled, (off_t)(offset + filled));
        if (got == 0) break;
        if (got > 0)
            filled += (size_t)got;
        else if (errno != EINTR) {
            cli_error("%s: cannot be read", files->paths[report]);
            files->failed = 1;
            break;
        }
    }
    return filled;
}

/* ---- in blocks */

void report_text_begin(report_text *text, report_files *files, size_t report) {
    text->files = files;
    text->report = report;
    text->start = 0;
    text->size = 0;
    text->stops_at_zero = 0;
}

static void read_block(report_text *text, uint64_t offset) {
    text->start = offset;
    text->size =
        report_files_read(text->files, text->report, offset, text->block, sizeof text->block);
    const char *zero = text->stops_at_zero ? memchr(text->block, '\0', text->size) : NULL;
    if (zero) text->size = (size_t)(zero - text->block);
}

const char *report_text_at(report_text *text, uint64_t offset, size_t *size) {
    if (offset < text->start || offset - text->start >= text->size) read_block(text, offset);
    *size = offset < text->start ? 0 : text->size - (size_t)(offset - text->start);
    return *size ? text->block + (offset - text->start) : NULL;
}

/* Words may lie across the end of a block: the next one begins before it. */
uint64_t report_text_find(report_text *text, uint64_t offset, const char *words) {
    const size_t length = strlen(words);
    size_t size;
    for (const char *at; (at = report_text_at(text, offset, &size)); offset += size - length + 1) {
        if (size < length) {
            read_block(text, offset);
            at = text->block;
            size = text->size;
        }
        if (size < length) break;
        const char *found = memmem(at, size, words, length);
        if (found) return offset + (uint64_t)(found - at);
    }
    return UINT64_MAX;
}

/* ---- The parts of all reports, sorted by the paths of files. */

int report_merge_begin(report_merge *merged, const char *const *reports, size_t count) {
    report_files_open(&merged->files, reports);
    merged->shards = calloc(count + 1, sizeof *merged->shards);
    if (!merged->shards) return cli_out_of_memory();
    merged->report_count = count;
    return CLI_OK;
}

static int digit_of(char digit) {
    static const char digits[] = "0123456789ABCDEFabcdef";
    const char *at = digit ? strchr(digits, digit) : NULL;
    return !at ? -1 : at - digits < 16 ? (int)(at - digits) : (int)(at - digits) - 6;
}

void report_decode(char *text) {
    char *to = text;
    for (const char *at = text; *at; ++to) {
        const int high = *at == '%' ? digit_of(at[1]) : -1, low = high < 0 ? -1 : digit_of(at[2]);
        *to = low < 0 ? *at : (char)(16 * high + low);
        at += low < 0 ? 1 : 3;
    }
    *to = '\0';
}

/* Results of one file follow one another, and share its path. */
static int keep_path(const report_merge *merged, report_part *part) {
    const report_part *last = merged->part_count ? &merged->parts[merged->part_count - 1] : NULL;
    part->owns_path = !last || last->report != part->report || strcmp(last->path, part->path) != 0;
    part->path = part->owns_path ? strdup(part->path) : last->path;
    return part->path != NULL;
}

int report_add_part(report_merge *merged, report_part part) {
    report_part *parts =
        cli_grow(merged->parts, merged->part_count, &merged->part_room, sizeof *parts);
    merged->parts = parts ? parts : merged->parts;
    if (!parts || !keep_path(merged, &part)) return cli_out_of_memory();
    merged->parts[merged->part_count++] = part;
    return CLI_OK;
}

void report_drop_parts(report_merge *merged, size_t count) {
    while (merged->part_count > count) {
        const report_part *part = &merged->parts[--merged->part_count];
        if (part->owns_path) free((char *)(uintptr_t)part->path);
    }
}

int report_grow_entry(report_merge *merged, size_t size) {
    if (size <= merged->entry_room) return 1;
    const size_t room = size < 4096 ? 4096 : size + size / 2;
    char *entry = realloc(merged->entry, room);
    if (!entry) {
        merged->files.failed = cli_out_of_memory();
        return 0;
    }
    merged->entry = entry;
    merged->entry_room = room;
    return 1;
}

check_entry report_entry(const report_part *part) {
    return (check_entry){.path = part->path,
        .errors = part->errors,
        .warnings = part->warnings,
        .is_clean = part->is_clean != 0};
}

static int compare_parts(const void *a, const void *b) {
    const report_part *one = a, *other = b;
    const check_entry entry = report_entry(one), other_entry = report_entry(other);
    const int order = check_compare_entries(&entry, &other_entry);
    if (order) return order;
    if (one->report != other->report) return one->report < other->report ? -1 : 1;
    return one->offset < other->offset ? -1 : one->offset > other->offset;
}

void report_sort(report_merge *merged) {
    if (merged->part_count)
        qsort(merged->parts, merged->part_count, sizeof *merged->parts, compare_parts);
}

void report_merge_free(report_merge *merged) {
    report_drop_parts(merged, 0);
    report_files_close(&merged->files);
    for (size_t i = 0; i < merged->report_count; ++i) free(merged->shards[i].options);
    free(merged->shards);
    free(merged->parts);
    free(merged->entry);
}

norma_severity report_severity(cli_value finding) {
    return cli_find_severity(cli_string(cli_get(finding, "severity")));
}

int report_fail_on(cli_value file) {
    const char *name = cli_string(cli_get(file, "fail_on"));
    const int severity = (int)cli_find_severity(name ? name : "error");
    return severity ? severity : CHECK_FAIL_NEVER;
}

/* ---- Entries of reports read again. Their hashes were kept, so a report that was written to
 * or cut short meanwhile is seen, wherever that was. */

int report_read_part(report_merge *merged, report_part *part) {
    const size_t size = (size_t)part->size;
    if (!report_grow_entry(merged, size + 1)) return 0;
    if (report_files_read(&merged->files, part->report, part->offset, merged->entry, size) != size)
        return 0;
    merged->entry[size] = '\0';
    part->hash = cli_hash(CLI_HASH, merged->entry, size);
    return 1;
}

int report_load_part(report_merge *merged, const report_part *part) {
    report_part now = *part;
    if (report_read_part(merged, &now) && now.hash == part->hash) return CLI_OK;
    if (!merged->files.failed)
        cli_error("%s: byte %llu: the entry of %s changed while the reports were joined",
            merged->files.paths[part->report], (unsigned long long)part->offset, part->path);
    return CLI_FILE;
}

/* ---- Reports of shards are put together only as a whole set: a shard that is missing,
 * or there twice, would make a wrong report that looks right. */

static size_t whole_number(cli_value value) {
    size_t number = 0;
    cli_count_of(value, &number);
    return number;
}

int report_note_shard(report_merge *merged, size_t report, const char *key, cli_value value) {
    report_shard *shard = &merged->shards[report];
    if (strcmp(key, "missing_shards") == 0 && cli_elements(value)) merged->status = CLI_FILE;
    if (strcmp(key, "shard") == 0) {
        shard->number = whole_number(cli_element(value, 0));
        shard->count = whole_number(cli_element(value, 1));
    }
    if (strcmp(key, "options") != 0 || shard->options) return CLI_OK;
    shard->options = cli_json_sorted(value);
    return shard->options ? CLI_OK : cli_out_of_memory();
}

int report_note_shards(report_merge *merged, size_t report, cli_value object) {
    int status = CLI_OK;
    for (cli_value v = cli_is_object(object) ? cli_first(object) : (cli_value){0}; v.in && !status;
         v = cli_next(v))
        status = report_note_shard(merged, report, cli_key(v), v);
    return status;
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
        cli_error("%s: is a shard, but %s is a whole report; expected all shards of a set",
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
