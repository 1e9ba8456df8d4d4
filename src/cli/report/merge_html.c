/* merge_html.c: pages of norma check as one: the sections of their files, pictures included, and a
 * summary of all, from the totals that each page holds as JSON. */
#include "cli/process/errors.h"
#include "cli/report/merge.h"
#include <stdlib.h>
#include <string.h>

int report_is_html(report_text *text) {
    const char *bytes;
    size_t size;
    for (uint64_t at = 0; (bytes = report_text_at(text, at, &size)); at += size)
        for (size_t i = 0; i < size; ++i)
            if (!bytes[i] || !strchr(" \t\r\n", bytes[i])) return bytes[i] == '<';
    return 0;
}

static int refuse(const report_text *text) {
    if (!text->files->failed)
        cli_error("%s: is not an HTML report of norma check", text->files->paths[text->report]);
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
    totals->incomplete |= json_is_false(json_object_get(page, "complete"));
    json_array_foreach(json_object_get(page, "rules"), i, entry) add_rule(entry, totals);
}

/* The bytes from one place to another, in merged->entry. 0: reported. */
static int read_between(report_merge *merged, report_text *text, uint64_t from, uint64_t to) {
    const size_t size = (size_t)(to - from);
    if (!report_grow_entry(merged, size + 1)) return 0;
    if (report_files_read(text->files, text->report, from, merged->entry, size) == size) return 1;
    refuse(text);
    return 0;
}

static int read_totals(report_merge *merged, report_text *text) {
    static const char begin[] = CHECK_HTML_TOTALS;
    json_error_t error;
    uint64_t at = report_text_find(text, 0, begin), last = at;
    if (at != UINT64_MAX) last = report_text_find(text, at, "</script>");
    if (last == UINT64_MAX) return refuse(text);
    at += sizeof begin - 1;
    if (!read_between(merged, text, at, last)) return CLI_FILE;
    json_t *page = json_loadb(merged->entry, (size_t)(last - at), 0, &error);
    if (!page) return refuse(text);
    add_totals(page, &merged->totals);
    report_note_shard(merged, text->report, page);
    if (merged->totals.incomplete) merged->status = CLI_FILE;
    json_decref(page);
    return CLI_OK;
}

/* ---- sections */

/* Behind its path: whether the file was read, and whether a finding fails. */
static int note_status(report_merge *merged, report_text *text, uint64_t at) {
    static const char words[] = CHECK_HTML_STATUS, fails[] = CHECK_HTML_FAILS;
    const uint64_t end = report_text_find(text, at, ">");
    if (end == UINT64_MAX || end - at > 100) return refuse(text);
    if (!read_between(merged, text, at, end + 1)) return CLI_FILE;
    merged->entry[end + 1 - at] = '\0';
    if (strncmp(merged->entry, words, sizeof words - 1) != 0) return refuse(text);
    if (strstr(merged->entry, fails)) merged->status = cli_worse(merged->status, CLI_FINDINGS);
    if (strncmp(merged->entry + sizeof words - 1, "unreadable", 10) == 0) merged->status = CLI_FILE;
    return CLI_OK;
}

static int add_section(report_merge *merged, report_text *text, uint64_t from, uint64_t to) {
    report_part part = {.report = (uint32_t)text->report, .offset = from, .size = to - from};
    const uint64_t path = from + sizeof CHECK_HTML_FILE - 1,
                   path_end = report_text_find(text, path, "\"");
    if (path_end == UINT64_MAX || !report_copy_bytes(merged, &part, &part.hash, NULL))
        return refuse(text);
    if (!read_between(merged, text, path, path_end)) return CLI_FILE;
    merged->entry[path_end - path] = '\0';
    report_decode(merged->entry);
    part.path = merged->entry;
    const int status = report_add_part(merged, part);
    return status ? status : note_status(merged, text, path_end);
}

int report_add_html(report_merge *merged, report_text *text) {
    static const char begin[] = CHECK_HTML_FILE, end[] = CHECK_HTML_FILE_END;
    merged->kind = REPORT_HTML;
    text->stops_at_zero = 1;
    text->size = 0; /* reads the block again */
    int status = read_totals(merged, text);
    for (uint64_t at = 0; !status && (at = report_text_find(text, at, begin)) != UINT64_MAX;) {
        const uint64_t last = report_text_find(text, at, end);
        if (last == UINT64_MAX) return refuse(text);
        status = add_section(merged, text, at, last + sizeof end - 1);
        at = last + sizeof end - 1;
    }
    return text->files->failed ? CLI_FILE : status;
}

int report_write_html(report_merge *merged, FILE *out) {
    int status = CLI_OK;
    merged->totals.status = merged->status;
    check_format_html.begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count && !status; ++i)
        status = report_copy_part(merged, &merged->parts[i], out);
    check_format_html.end(out, &merged->totals, &merged->settings);
    return status;
}
