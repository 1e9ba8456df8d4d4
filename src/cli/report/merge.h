/* merge.h: what the files of norma report share: the reports that were read, and their parts in the
 * order of paths. */
#ifndef NORMA_CLI_REPORT_MERGE_H
#define NORMA_CLI_REPORT_MERGE_H
#include "cli/check/check_command.h"
#include <jansson.h>

typedef enum report_kind { REPORT_UNKNOWN, REPORT_JSON, REPORT_SARIF } report_kind;

typedef struct report_part { /* a file of JSON, a result of SARIF */
    const char *path;
    const json_t *value; /* belongs to its report */
    size_t number;       /* in the order of reading */
} report_part;

typedef struct report_merge {
    check_settings settings;
    report_kind kind;
    json_t **reports;
    size_t report_count;
    report_part *parts;
    size_t part_count, part_room;
    int status; /* the worst of the runs */
} report_merge;

/* Takes the parts of a report, which merged then owns. A status; not CLI_OK: reported. */
int report_add(report_merge *merged, const char *path, json_t *report);
void report_sort(report_merge *merged); /* by path, and else as they were read */
void report_merge_free(report_merge *merged);

/* Writes all of it. JSON may become any form; format NULL: as it is. */
void report_write_json(const report_merge *merged, FILE *out, check_totals *totals);
void report_write_sarif(const report_merge *merged, FILE *out);
void report_write_as(
    const report_merge *merged, const check_format *format, FILE *out, check_totals *totals);

/* The totals of a file's entry in JSON. */
void report_count(const json_t *file, check_totals *totals);
norma_severity report_severity(const json_t *finding);
#endif
