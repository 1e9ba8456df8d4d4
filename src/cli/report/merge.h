/* merge.h: what the files of norma report share: the reports that were read, and their parts in the
 * order of paths. */
#ifndef NORMA_CLI_REPORT_MERGE_H
#define NORMA_CLI_REPORT_MERGE_H
#include "cli/check/check_command.h"
#include <jansson.h>

typedef enum report_kind { REPORT_UNKNOWN, REPORT_JSON, REPORT_SARIF, REPORT_HTML } report_kind;

typedef struct report_part { /* a file of JSON or HTML, a result of SARIF */
    const char *path;
    const json_t *value; /* belongs to its report */
    const char *text;    /* of HTML; belongs to the page */
    size_t length;
    char *owned;   /* the path, if it is a copy */
    size_t number; /* in the order of reading */
} report_part;

typedef struct report_merge {
    check_settings settings;
    report_kind kind;
    json_t **reports;
    size_t report_count;
    char **texts; /* pages */
    size_t text_count;
    report_part *parts;
    size_t part_count, part_room;
    check_totals totals; /* of pages */
    int status;          /* the worst of the runs */
} report_merge;

int report_add_part(report_merge *merged, report_part part); /* a status */

/* ---- pages (merge_html.c) */

int report_is_html(const char *text);
/* As report_add; merged then owns the text. */
int report_add_html(report_merge *merged, const char *path, char *text);
void report_write_html(const report_merge *merged, FILE *out);

/* ---- JSON and SARIF */

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
