/* write_merged.c: merged reports in their own form, value by value as norma check writes them, or
 * JSON in the words of any other form. */
#include "cli/report/merge.h"
#include "cli/process/errors.h"
#include "cli/text/memory_stream.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- as it is */

static void write_value(cli_json *json, const char *key, const json_t *value);

static void write_members(cli_json *json, const char *key, const json_t *object) {
    const char *name;
    json_t *member;
    cli_json_open(json, key, '{');
    json_object_foreach((json_t *)(uintptr_t)object, name, member) write_value(json, name, member);
    cli_json_close(json, '}');
}

static void write_elements(cli_json *json, const char *key, const json_t *array) {
    size_t i;
    json_t *element;
    cli_json_open(json, key, '[');
    json_array_foreach(array, i, element) write_value(json, NULL, element);
    cli_json_close(json, ']');
}

static void write_number(cli_json *json, const char *key, const json_t *value) {
    if (json_is_integer(value) && json_integer_value(value) >= 0)
        cli_json_size(json, key, (size_t)json_integer_value(value));
    else
        cli_json_number(json, key, json_number_value(value));
}

/* No deeper than jansson reads. */
static void write_value(cli_json *json, const char *key, const json_t *value) {
    if (json_is_object(value))
        write_members(json, key, value);
    else if (json_is_array(value))
        write_elements(json, key, value);
    else if (json_is_string(value))
        cli_json_string(json, key, json_string_value(value));
    else if (json_is_number(value))
        write_number(json, key, value);
    else if (json_is_boolean(value))
        cli_json_bool(json, key, json_is_true(value));
    else
        cli_json_null(json, key);
}

static void write_parts(const report_merge *merged, FILE *out) {
    for (size_t i = 0; i < merged->part_count; ++i) {
        cli_json json = {.out = out};
        if (i) fputs(",\n", out);
        write_value(&json, NULL, merged->parts[i].value);
    }
}

void report_write_json(const report_merge *merged, FILE *out, check_totals *totals) {
    totals->status = merged->status;
    for (size_t i = 0; i < merged->part_count; ++i) report_count(merged->parts[i].value, totals);
    check_format_json.begin(out, &merged->settings);
    write_parts(merged, out);
    check_format_json.end(out, totals, &merged->settings);
}

void report_write_sarif(const report_merge *merged, FILE *out) {
    const check_totals totals = {.status = merged->status};
    check_format_sarif.begin(out, &merged->settings);
    write_parts(merged, out);
    check_format_sarif.end(out, &totals, &merged->settings);
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

/* Memory that is out leaves the file's findings out, and the status says so. */
static void write_file(const report_merge *merged, const json_t *file, const check_format *format,
    FILE *out, check_totals *totals) {
    const json_t *list = json_object_get(file, "findings");
    const size_t room = json_array_size(list) + 1;
    norma_finding *findings = calloc(room, sizeof *findings);
    check_item *items = calloc(room, sizeof *items);
    check_report report = {.settings = &merged->settings,
        .path = text_of(file, "path"),
        .profile = read_profile(file),
        .status = text_of(file, "status"),
        .items = items,
        .fail_on = CHECK_FAIL_NEVER};
    size_t i;
    json_t *object;
    if (!findings || !items) totals->status = cli_out_of_memory();
    json_array_foreach(list, i, object) {
        if (!findings || !items || !read_finding(object, &findings[i])) continue;
        items[report.count++] = (check_item){&findings[i], findings[i].severity,
            (char *)(uintptr_t)json_string_value(json_object_get(object, "command"))};
    }
    check_write_file(&report, format, out, totals);
    free(items);
    free(findings);
}

/* Some forms have nothing to say of a file, and then need nothing between. */
void report_write_as(
    const report_merge *merged, const check_format *format, FILE *out, check_totals *totals) {
    int any = 0;
    format->begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count; ++i) {
        cli_memory_stream part;
        if (cli_memory_open(&part))
            write_file(merged, merged->parts[i].value, format, part.out, totals);
        if (!cli_memory_close(&part)) totals->status = cli_out_of_memory();
        if (part.size && any) fputs(format->between, out);
        any |= part.size > 0;
        fwrite(part.text, 1, part.size, out);
        free(part.text);
    }
    totals->status = cli_worse(totals->status, merged->status);
    format->end(out, totals, &merged->settings);
}
