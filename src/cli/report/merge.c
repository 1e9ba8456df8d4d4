/* merge.c: reports taken apart, their parts sorted by the paths of files. */
#include "cli/report/merge.h"
#include "cli/process/errors.h"
#include <stdlib.h>
#include <string.h>

static int refuse(const char *path, const char *why) {
    cli_error("%s: %s", path, why);
    return CLI_FILE;
}

int report_add_part(report_merge *merged, report_part part) {
    if (merged->part_count == merged->part_room) {
        const size_t room = merged->part_room ? 2 * merged->part_room : 64;
        report_part *parts = realloc(merged->parts, room * sizeof *parts);
        if (!parts) return cli_out_of_memory();
        merged->parts = parts;
        merged->part_room = room;
    }
    part.number = merged->part_count;
    merged->parts[merged->part_count++] = part;
    return CLI_OK;
}

static int add_part(report_merge *merged, const char *path, const json_t *value) {
    return report_add_part(merged, (report_part){.path = path, .value = value});
}

/* ---- JSON */

norma_severity report_severity(const json_t *finding) {
    const char *name = json_string_value(json_object_get(finding, "severity"));
    for (int severity = NORMA_SEVERITY_INFO; severity <= NORMA_SEVERITY_ERROR; ++severity)
        if (name && strcmp(name, check_severity_name((norma_severity)severity)) == 0)
            return (norma_severity)severity;
    return NORMA_SEVERITY_NONE;
}

/* What is read of an entry must be there. */
static int is_file(const json_t *file) {
    const json_t *findings = json_object_get(file, "findings");
    size_t i;
    json_t *finding;
    if (!json_string_value(json_object_get(file, "path")) ||
        !json_string_value(json_object_get(file, "status")) || !json_is_array(findings))
        return 0;
    json_array_foreach(findings, i, finding) {
        if (!report_severity(finding) || !json_string_value(json_object_get(finding, "rule")) ||
            !json_string_value(json_object_get(finding, "where")) ||
            !json_string_value(json_object_get(finding, "message")))
            return 0;
    }
    return 1;
}

/* Reports of earlier versions do not have the status of their run: that of --fail-on error. */
static int status_of(const json_t *report, const check_totals *totals, int unreadable) {
    const json_t *status = json_object_get(json_object_get(report, "summary"), "exit_status");
    if (json_is_integer(status)) return (int)json_integer_value(status);
    return unreadable ? CLI_FILE : totals->errors ? CLI_FINDINGS : CLI_OK;
}

static int add_json(report_merge *merged, const char *path, const json_t *report) {
    const json_t *files = json_object_get(report, "files");
    check_totals totals = {0};
    int status = CLI_OK, unreadable = 0;
    size_t i;
    json_t *file;
    json_array_foreach(files, i, file) {
        if (!is_file(file))
            return refuse(path, "expected a path, a status and findings in each file");
        unreadable |= strcmp(json_string_value(json_object_get(file, "status")), "unreadable") == 0;
        report_count(file, &totals);
        status = add_part(merged, json_string_value(json_object_get(file, "path")), file);
        if (status) return status;
    }
    merged->status = cli_worse(merged->status, status_of(report, &totals, unreadable));
    return CLI_OK;
}

void report_count(const json_t *file, check_totals *totals) {
    size_t i;
    json_t *finding;
    size_t problems = 0;
    json_array_foreach(json_object_get(file, "findings"), i, finding) {
        const norma_severity severity = report_severity(finding);
        totals->errors += severity == NORMA_SEVERITY_ERROR;
        totals->warnings += severity == NORMA_SEVERITY_WARNING;
        totals->infos += severity == NORMA_SEVERITY_INFO;
        problems += severity != NORMA_SEVERITY_INFO;
    }
    ++totals->files;
    totals->files_with_trouble += problems > 0;
    totals->not_checked +=
        strcmp(json_string_value(json_object_get(file, "status")), "checked") != 0;
}

/* ---- SARIF */

static const char *uri_of(const json_t *result) {
    const json_t *location = json_array_get(json_object_get(result, "locations"), 0),
                 *physical = json_object_get(location, "physicalLocation"),
                 *artifact = json_object_get(physical, "artifactLocation");
    const char *uri = json_string_value(json_object_get(artifact, "uri"));
    return uri ? uri : "";
}

/* Results name rules by their numbers, which other versions may have changed. */
static int is_of_this_version(const json_t *run) {
    const json_t *driver = json_object_get(json_object_get(run, "tool"), "driver");
    const char *version = json_string_value(json_object_get(driver, "semanticVersion"));
    return version && strcmp(version, norma_version()) == 0;
}

static int add_run(report_merge *merged, const char *path, const json_t *run) {
    const json_t *invocation = json_array_get(json_object_get(run, "invocations"), 0),
                 *exit = json_object_get(invocation, "exitCode");
    size_t i;
    json_t *result;
    if (!is_of_this_version(run))
        return refuse(path,
            "was not written by this version of norma check, so its rules may have other numbers");
    json_array_foreach(json_object_get(run, "results"), i, result) {
        const int status = add_part(merged, uri_of(result), result);
        if (status) return status;
    }
    merged->status = cli_worse(merged->status, (int)json_integer_value(exit));
    return CLI_OK;
}

static int add_sarif(report_merge *merged, const char *path, const json_t *report) {
    size_t i;
    json_t *run;
    int status = CLI_OK;
    json_array_foreach(json_object_get(report, "runs"), i, run) {
        if (!status) status = add_run(merged, path, run);
    }
    return status;
}

/* ---- all */

static report_kind kind_of(const json_t *report) {
    const char *schema = json_string_value(json_object_get(report, "schema"));
    if (json_is_array(json_object_get(report, "runs"))) return REPORT_SARIF;
    return schema && strcmp(schema, "norma-check/1") == 0 &&
                   json_is_array(json_object_get(report, "files"))
               ? REPORT_JSON
               : REPORT_UNKNOWN;
}

int report_add(report_merge *merged, const char *path, json_t *report) {
    const report_kind kind = kind_of(report);
    merged->reports[merged->report_count++] = report;
    if (kind == REPORT_UNKNOWN)
        return refuse(path, "is not a report of norma check; expected one in JSON or SARIF");
    merged->kind = kind;
    return kind == REPORT_SARIF ? add_sarif(merged, path, report) : add_json(merged, path, report);
}

static int compare_parts(const void *a, const void *b) {
    const report_part *one = a, *other = b;
    const int order = strcmp(one->path, other->path);
    if (order) return order;
    return one->number < other->number ? -1 : one->number > other->number;
}

void report_sort(report_merge *merged) {
    if (merged->part_count)
        qsort(merged->parts, merged->part_count, sizeof *merged->parts, compare_parts);
}

void report_merge_free(report_merge *merged) {
    for (size_t i = 0; i < merged->report_count; ++i) json_decref(merged->reports[i]);
    for (size_t i = 0; i < merged->text_count; ++i) free(merged->texts[i]);
    for (size_t i = 0; i < merged->part_count; ++i) free(merged->parts[i].owned);
    free(merged->reports);
    free(merged->texts);
    free(merged->parts);
}
