/* write_merged.c: merged reports in their own form, the entries byte by byte, or JSON in the words
 * of any other form. */
#include "cli/report/merge.h"
#include "cli/process/errors.h"
#include "cli/text/memory_stream.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- as it is */

/* An entry that is what it was when it was read first can be read again. */
static json_t *load_entry(report_merge *merged, const report_part *part, int *status) {
    json_error_t error;
    *status = report_load_part(merged, part);
    if (*status) return NULL;
    json_t *entry = json_loadb(merged->entry, (size_t)part->size, JSON_DECODE_ANY, &error);
    if (!entry) *status = cli_out_of_memory();
    return entry;
}

static int write_parts(report_merge *merged, FILE *out) {
    int status = CLI_OK;
    for (size_t i = 0; i < merged->part_count && !status; ++i) {
        if (i) fputs(",\n", out);
        status = report_copy_part(merged, &merged->parts[i], out);
    }
    return status;
}

int report_write_json(report_merge *merged, FILE *out) {
    check_totals totals = merged->totals;
    totals.status = merged->status;
    check_format_json.begin(out, &merged->settings);
    const int status = write_parts(merged, out);
    check_format_json.end(out, &totals, &merged->settings);
    return status;
}

/* Results that another program wrote over several lines are not told apart by lines. */
static int add_results(report_merge *merged, const report_part *part, check_results *results) {
    const int status = report_load_part(merged, part);
    if (status) return status;
    return check_results_add(results, merged->entry, (size_t)part->size) ? CLI_OK
                                                                         : cli_out_of_memory();
}

int report_write_sarif(report_merge *merged, FILE *out) {
    check_totals totals = {.status = merged->status};
    check_results *results = check_results_new();
    int status = results ? CLI_OK : cli_out_of_memory();
    check_format_sarif.begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count && !status; ++i)
        status = add_results(merged, &merged->parts[i], results);
    if (!status) check_results_write(results, out, &totals);
    check_results_free(results);
    check_format_sarif.end(out, &totals, &merged->settings);
    return status;
}

/* ---- JSON in another form */

static const char *text_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static size_t index_of(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return json_is_integer(value) ? (size_t)json_integer_value(value) : SIZE_MAX;
}

static norma_sample read_sample(const json_t *object) {
    const json_t *position = json_object_get(object, "position");
    norma_sample sample = {.vertex = index_of(object, "vertex"),
        .face = index_of(object, "face"),
        .normal = SIZE_MAX,
        .has_position = json_array_size(position) == 3};
    for (size_t i = 0; i < 3 && sample.has_position; ++i)
        sample.position[i] = json_number_value(json_array_get(position, i));
    return sample;
}

static const norma_rule *find_rule(const char *id) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    for (size_t i = 0; i < count; ++i)
        if (strcmp(rules[i].id, id) == 0) return &rules[i];
    return NULL;
}

/* The rule is that of the table, so one that this version does not know has no place in another
 * form. */
static int read_finding(const json_t *object, norma_finding *finding) {
    const json_t *worst = json_object_get(object, "worst"),
                 *value = json_object_get(worst, "value");
    *finding = (norma_finding){.rule = find_rule(text_of(object, "rule")),
        .severity = report_severity(object),
        .where = text_of(object, "where"),
        .label = text_of(object, "where"),
        .count = index_of(object, "count"),
        .worst_value = json_is_number(value) ? json_number_value(value) : NAN,
        .unit = text_of(worst, "unit"),
        .worst = read_sample(worst),
        .message = text_of(object, "message")};
    if (finding->count == SIZE_MAX) finding->count = 1;
    return finding->rule != NULL;
}

static norma_check_profile read_profile(const json_t *file) {
    const char *name = text_of(file, "profile");
    for (int profile = NORMA_CHECK_PROFILE_RENDER; profile <= NORMA_CHECK_PROFILE_GENERATED;
         ++profile)
        if (strcmp(check_profile_name((norma_check_profile)profile), name) == 0)
            return (norma_check_profile)profile;
    return NORMA_CHECK_PROFILE_RENDER;
}

/* A status. */
static int write_file(const report_merge *merged, const char *path, const json_t *file,
    const check_format *format, FILE *out, check_totals *totals) {
    const json_t *list = json_object_get(file, "findings");
    const size_t room = json_array_size(list) + 1;
    norma_finding *findings = calloc(room, sizeof *findings);
    check_item *items = calloc(room, sizeof *items);
    const int fine = findings && items;
    check_report report = {.settings = &merged->settings,
        .path = path,
        .profile = read_profile(file),
        .status = text_of(file, "status"),
        .items = items,
        .fail_on = report_fail_on(file)};
    size_t i;
    json_t *object;
    json_array_foreach(list, i, object) {
        if (!fine || !read_finding(object, &findings[i])) continue;
        items[report.count++] = (check_item){&findings[i], findings[i].severity,
            (char *)(uintptr_t)json_string_value(json_object_get(object, "command"))};
    }
    if (fine) check_write_file(&report, format, out, totals);
    free(items);
    free(findings);
    return fine ? CLI_OK : cli_out_of_memory();
}

/* Some forms have nothing to say of a file, and then need nothing between. */
static int write_part_as(report_merge *merged, const report_part *part, const check_format *format,
    FILE *out, check_totals *totals, int *any) {
    cli_memory_stream written;
    int status;
    json_t *entry = load_entry(merged, part, &status);
    if (!entry) return status;
    if (cli_memory_open(&written))
        status = write_file(merged, part->path, entry, format, written.out, totals);
    json_decref(entry);
    if (!cli_memory_close(&written)) return status ? status : cli_out_of_memory();
    if (written.size && *any) fputs(format->between, out);
    *any |= written.size > 0;
    fwrite(written.text, 1, written.size, out);
    free(written.text);
    return status;
}

int report_write_as(
    report_merge *merged, const check_format *format, FILE *out, check_totals *totals) {
    int status = CLI_OK, any = 0;
    format->begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count && !status; ++i)
        status = write_part_as(merged, &merged->parts[i], format, out, totals, &any);
    totals->status = cli_worse(totals->status, merged->status);
    format->end(out, totals, &merged->settings);
    return status;
}
