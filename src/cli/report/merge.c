/* merge.c: the parts of all reports, sorted by the paths of files. */
#define _POSIX_C_SOURCE 200809L
#include "cli/report/merge.h"
#include "cli/process/errors.h"
#include <stdlib.h>
#include <string.h>

void report_merge_begin(report_merge *merged, const char *const *reports) {
    report_files_open(&merged->files, reports);
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
    free(merged->parts);
    free(merged->entry);
}

norma_severity report_severity(const json_t *finding) {
    const char *name = json_string_value(json_object_get(finding, "severity"));
    for (int severity = NORMA_SEVERITY_INFO; severity <= NORMA_SEVERITY_ERROR; ++severity)
        if (name && strcmp(name, check_severity_name((norma_severity)severity)) == 0)
            return (norma_severity)severity;
    return NORMA_SEVERITY_NONE;
}
