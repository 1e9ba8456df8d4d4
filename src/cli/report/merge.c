/* merge.c: the parts of all reports, sorted by the paths of files. */
#define _POSIX_C_SOURCE 200809L
#include "cli/report/merge.h"
#include "cli/process/errors.h"
#include <stdlib.h>
#include <string.h>

int report_merge_begin(report_merge *merged, const char *const *reports, size_t count) {
    report_files_open(&merged->files, reports);
    merged->shards = calloc(count + 1, sizeof *merged->shards);
    merged->report_count = count;
    return merged->shards ? CLI_OK : cli_out_of_memory();
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
    if (merged->part_count == merged->part_room) {
        const size_t room = merged->part_room ? 2 * merged->part_room : 64;
        report_part *parts = realloc(merged->parts, room * sizeof *parts);
        if (!parts) return cli_out_of_memory();
        merged->parts = parts;
        merged->part_room = room;
    }
    if (!keep_path(merged, &part)) return cli_out_of_memory();
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
        cli_out_of_memory();
        return 0;
    }
    merged->entry = entry;
    merged->entry_room = room;
    return 1;
}

static int compare_parts(const void *a, const void *b) {
    const report_part *one = a, *other = b;
    const int order = strcmp(one->path, other->path);
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

static norma_severity severity_of(const char *name) {
    for (int severity = NORMA_SEVERITY_INFO; severity <= NORMA_SEVERITY_ERROR; ++severity)
        if (name && strcmp(name, check_severity_name((norma_severity)severity)) == 0)
            return (norma_severity)severity;
    return NORMA_SEVERITY_NONE;
}

norma_severity report_severity(const json_t *finding) {
    return severity_of(json_string_value(json_object_get(finding, "severity")));
}

int report_fail_on(const json_t *file) {
    const char *name = json_string_value(json_object_get(file, "fail_on"));
    const int severity = (int)severity_of(name ? name : "error");
    return severity ? severity : CHECK_FAIL_NEVER;
}
