/* report.h: what the files of norma report share: reports on disk, where their entries stand, in
 * the order of paths. The entries themselves stay on disk. */
#ifndef NORMA_CLI_REPORT_REPORT_H
#define NORMA_CLI_REPORT_REPORT_H
#include "cli/check/check.h"

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

norma_severity report_severity(cli_value finding); /* NONE where none is called so */
int report_fail_on(cli_value file);                /* the least severity that fails it */
/* Notes the parts of a report, which is a page or JSON. A status. */
int report_read(report_merge *merged, size_t report);
/* Reads the text of a part into merged->entry. A status: it may not be what it was, which was said.
 */
int report_load_part(report_merge *merged, const report_part *part);
#endif
