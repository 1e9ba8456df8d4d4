/* merge_html.c: pages of norma check as one: the sections of their files, pictures included, and a
 * summary of all, from the totals that each page holds as JSON. */
#include "cli/process/errors.h"
#include "cli/report/merge.h"
#include <stdlib.h>
#include <string.h>

int report_is_html(const char *text) { return text[strspn(text, " \t\r\n")] == '<'; }

static int refuse(const char *path) {
    cli_error("%s: is not an HTML report of norma check", path);
    return CLI_FILE;
}

/* ---- totals */

static size_t number_of(const json_t *object, const char *key) {
    const json_int_t number = json_integer_value(json_object_get(object, key));
    return number > 0 ? (size_t)number : 0;
}

static void add_rule(const json_t *entry, check_totals *totals) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    const char *id = json_string_value(json_object_get(entry, "rule"));
    const norma_severity severity = report_severity(entry);
    for (size_t rule = 0; rule < count && id && severity; ++rule)
        if (strcmp(rules[rule].id, id) == 0) {
            totals->by_rule[rule][severity].places += number_of(entry, "places");
            totals->by_rule[rule][severity].files += number_of(entry, "files");
        }
}

static void add_totals(const json_t *page, check_totals *totals) {
    size_t i;
    json_t *entry;
    totals->errors += number_of(page, "errors");
    totals->warnings += number_of(page, "warnings");
    totals->infos += number_of(page, "infos");
    totals->files += number_of(page, "files");
    totals->files_with_trouble += number_of(page, "files_with_trouble");
    totals->not_checked += number_of(page, "not_checked");
    totals->known += number_of(page, "known");
    totals->status = cli_worse(totals->status, (int)number_of(page, "exit_status"));
    json_array_foreach(json_object_get(page, "rules"), i, entry) add_rule(entry, totals);
}

static int read_totals(report_merge *merged, const char *path, const char *text) {
    static const char begin[] = CHECK_HTML_TOTALS, end[] = "</script>";
    const char *at = strstr(text, begin), *last = at ? strstr(at, end) : NULL;
    json_error_t error;
    if (!last) return refuse(path);
    at += sizeof begin - 1;
    json_t *page = json_loadb(at, (size_t)(last - at), 0, &error);
    if (!page) return refuse(path);
    add_totals(page, &merged->totals);
    json_decref(page);
    return CLI_OK;
}

/* ---- sections */

static int add_section(report_merge *merged, const char *section, size_t length) {
    const char *path = section + sizeof CHECK_HTML_FILE - 1;
    const int status =
        report_add_part(merged, (report_part){.text = section, .length = length, .path = path});
    if (status) return status;
    report_part *part = &merged->parts[merged->part_count - 1];
    part->owned = malloc(strcspn(path, "\"") + 1);
    part->path = part->owned;
    if (!part->owned) return cli_out_of_memory();
    memcpy(part->owned, path, strcspn(path, "\""));
    part->owned[strcspn(path, "\"")] = '\0';
    return CLI_OK;
}

int report_add_html(report_merge *merged, const char *path, char *text) {
    static const char end[] = CHECK_HTML_FILE_END;
    int status = read_totals(merged, path, text);
    merged->texts[merged->text_count++] = text;
    for (const char *at = text; !status && (at = strstr(at, CHECK_HTML_FILE));) {
        const char *last = strstr(at, end);
        if (!last) return refuse(path);
        last += sizeof end - 1;
        status = add_section(merged, at, (size_t)(last - at));
        at = last;
    }
    return status;
}

void report_write_html(const report_merge *merged, FILE *out) {
    check_format_html.begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count; ++i)
        fwrite(merged->parts[i].text, 1, merged->parts[i].length, out);
    check_format_html.end(out, &merged->totals, &merged->settings);
}
