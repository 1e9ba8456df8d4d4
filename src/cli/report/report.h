/* report.h: what the files of norma report share: reports on disk, where their entries stand, in
 * the order of paths. The entries themselves stay on disk. */
#ifndef NORMA_CLI_REPORT_REPORT_H
#define NORMA_CLI_REPORT_REPORT_H
#include "cli/check/check.h"
#include <stddef.h>
#include <stdint.h>

/* ---- The reports as files, which are read twice: once to see where each entry stands,
 * and again, entry by entry, when the merged report is written. */

enum { REPORT_KEPT = 128, REPORT_BLOCK = 65536 };

typedef struct report_files {
    const char *const *paths; /* the caller's */
    int failed;               /* one could not be read, which was reported */
    size_t keeps;             /* descriptors that stay open, at most */
    struct {
        size_t report; /* its number and 1; 0: none */
        int file;
    } kept[REPORT_KEPT];
} report_files;

/* As many bytes as there are from there on, at most size. Less: the end, or failed. */
size_t report_files_read(
    report_files *files, size_t report, uint64_t offset, char *bytes, size_t size);

/* ---- from the beginning to the end, in blocks */

typedef struct report_text {
    report_files *files;
    size_t report;
    uint64_t start; /* of the block */
    size_t size;
    int stops_at_zero; /* the text ends there */
    char block[REPORT_BLOCK];
} report_text;

void report_text_begin(report_text *text, report_files *files, size_t report);
/* The bytes there, at least one of *size; NULL: the end, or failed. */
const char *report_text_at(report_text *text, uint64_t offset, size_t *size);
/* The first place from an offset on that has these words; UINT64_MAX: none, or failed. */
uint64_t report_text_find(report_text *text, uint64_t offset, const char *words);

/* ---- What the files of norma report share: where the entries of the reports stand, in the
 * order of paths. The entries themselves stay on disk. */

typedef enum report_kind { REPORT_UNKNOWN, REPORT_JSON, REPORT_SARIF, REPORT_HTML } report_kind;

typedef struct report_part { /* a file of JSON or HTML, a result of SARIF */
    const char *path;
    uint32_t report;    /* its number among the inputs */
    uint32_t owns_path; /* 0: the path is that of the part before it */
    uint64_t offset, size, hash;
    uint32_t errors, warnings, is_clean; /* of a file of HTML */
} report_part;

typedef struct report_shard { /* what a report says of itself */
    size_t number, count;     /* count 0: it is no shard */
    char *options;
} report_shard;

typedef struct report_merge {
    check_settings settings;
    report_kind kind;
    report_files files;
    report_shard *shards; /* of each report */
    size_t report_count;
    report_part *parts;
    size_t part_count, part_room;
    char *entry; /* the text of one */
    size_t entry_room;
    check_totals totals; /* of pages and JSON */
    int status;          /* by the findings, and what says that it is not whole */
} report_merge;

/* The paths of the reports are the caller's. */
int report_merge_begin(report_merge *merged, const char *const *reports, size_t count);
void report_merge_free(report_merge *merged);
void report_sort(report_merge *merged); /* pages: the worst first; by path, and as they were read */

norma_severity report_severity(cli_value finding); /* NONE where none is called so */
int report_fail_on(cli_value file);                /* the least severity that fails it */
/* The bytes of percent-encoded text, in its place. */
void report_decode(char *text);
/* What a report says of shards, in members "shard", "options", "missing_shards" of an object, or in
 * one of its members. A status. */
int report_note_shards(report_merge *merged, size_t report, cli_value object);
int report_note_shard(report_merge *merged, size_t report, const char *key, cli_value value);
/* The path is copied. A status. */
int report_add_part(report_merge *merged, report_part part);
check_entry report_entry(const report_part *part);          /* without its text */
void report_drop_parts(report_merge *merged, size_t count); /* all but so many */
int report_grow_entry(report_merge *merged, size_t size);   /* 0: out of memory, reported */

/* ---- shards (report_parts.c) */

/* Whether all shards of a set are there, each once, of the same options. allows_missing: --partial,
 * and *missing is then the list of those that are not there, or NULL. A status. */
int report_check_shards(report_merge *merged, size_t count, int allows_missing, char **missing);

/* ---- JSON and SARIF (read_reports.c) */

int report_add_json(report_merge *merged, report_text *text);

/* ---- pages (read_reports.c) */

int report_is_html(report_text *text);
int report_add_html(report_merge *merged, report_text *text);
int report_write_html(report_merge *merged, FILE *out);

/* ---- entries on disk (report_parts.c) */

/* Reads the text of a part into merged->entry, with a 0 behind it, and hashes it. 0: not all of it
 * is there, or memory ran out. */
int report_read_part(report_merge *merged, report_part *part);
/* The same of a part that is known. A status: it may not be what it was, which was said. */
int report_load_part(report_merge *merged, const report_part *part);
#endif
