/* report_facts.c: what all forms of the report ask of a finding or a file. */
#include "cli/check/check_command.h"
#include "cli/process/errors.h"
#include <string.h>

size_t check_rule_number(const norma_rule *rule) { return (size_t)(rule - norma_rules(NULL)); }

const char *check_profile_name(norma_check_profile profile) {
    return profile == NORMA_CHECK_PROFILE_PRINT       ? "print"
           : profile == NORMA_CHECK_PROFILE_GENERATED ? "generated"
                                                      : "render";
}

static int is_problem(const check_report *report, const check_item *item) {
    return item->severity != NORMA_SEVERITY_INFO || (int)item->severity >= report->fail_on;
}

int check_is_listed(const check_report *report, const check_item *item) {
    return report->settings->list_infos || is_problem(report, item);
}

int check_is_clean(const check_report *report) {
    for (size_t i = 0; i < report->count; ++i)
        if (is_problem(report, &report->items[i])) return 0;
    return strcmp(report->status, "checked") == 0;
}

int check_fails(const check_report *report) {
    for (size_t i = 0; i < report->count; ++i)
        if ((int)report->items[i].severity >= report->fail_on) return 1;
    return 0;
}

int check_is_new_note(const norma_document *document, size_t first, size_t i) {
    while (strcmp(norma_document_note(document, first), norma_document_note(document, i)) != 0)
        ++first;
    return first == i;
}

/* ---- totals */

static void count_items(
    const check_report *report, size_t places[][CHECK_SEVERITIES], check_totals *totals) {
    for (size_t i = 0; i < report->count; ++i) {
        const check_item *item = &report->items[i];
        ++places[check_rule_number(item->finding->rule)][item->severity];
        totals->hidden += !check_is_listed(report, item);
        if ((int)item->severity >= report->fail_on)
            totals->status = cli_worse(totals->status, CLI_FINDINGS);
    }
}

/* Of one file: the places of each rule and severity. */
static void add_places(size_t places[][CHECK_SEVERITIES], check_totals *totals) {
    size_t of[CHECK_SEVERITIES] = {0};
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        for (size_t severity = 0; severity < CHECK_SEVERITIES; ++severity) {
            of[severity] += places[rule][severity];
            totals->by_rule[rule][severity].places += places[rule][severity];
            totals->by_rule[rule][severity].files += places[rule][severity] > 0;
        }
    totals->errors += of[NORMA_SEVERITY_ERROR];
    totals->warnings += of[NORMA_SEVERITY_WARNING];
    totals->infos += of[NORMA_SEVERITY_INFO];
    totals->files_with_trouble += of[NORMA_SEVERITY_ERROR] + of[NORMA_SEVERITY_WARNING] > 0;
}

void check_write_file(
    check_report *report, const check_format *format, FILE *out, check_totals *totals) {
    size_t places[CHECK_RULES][CHECK_SEVERITIES] = {{0}};
    count_items(report, places, totals);
    add_places(places, totals);
    ++totals->files;
    totals->not_checked += strcmp(report->status, "checked") != 0;
    totals->clean += (size_t)check_is_clean(report);
    report->places = (const size_t(*)[CHECK_SEVERITIES])places;
    format->file(out, report);
}

/* ---- nodes */

/* The number of the mesh in "/meshes/12/primitives/3". */
static size_t mesh_number(const char *where) {
    static const char meshes[] = "/meshes/";
    size_t number = 0;
    if (strncmp(where, meshes, sizeof meshes - 1) != 0) return SIZE_MAX;
    for (const char *at = where + sizeof meshes - 1; *at >= '0' && *at <= '9'; ++at)
        number = 10 * number + (size_t)(*at - '0');
    return number;
}

const char *check_node_path(norma_document *document, const char *where) {
    norma_node_info node;
    const size_t mesh = mesh_number(where),
                 count = document ? norma_document_node_count(document) : 0;
    for (size_t i = 0; i < count; ++i)
        if (!norma_document_node_info(document, i, &node) &&
            (node.mesh == mesh || strcmp(node.where, where) == 0))
            return node.path && node.path[0] ? node.path : NULL;
    return NULL;
}

/* ---- shards */

void check_write_shard(cli_json *json, const check_settings *settings) {
    if (settings->shards) {
        cli_json_open(json, "shard", '[');
        cli_json_size(json, NULL, settings->shard);
        cli_json_size(json, NULL, settings->shards);
        cli_json_close(json, ']');
        fprintf(json->out, ", \"options\": %s", settings->shard_options);
    } else if (settings->missing) {
        fprintf(json->out, "%s\"missing_shards\": %s", json->needs_comma ? ", " : "",
            settings->missing);
        json->needs_comma = 1;
    }
}

void check_write_bytes(FILE *out, const char *path) {
    for (const unsigned char *at = (const unsigned char *)path; *at; ++at) {
        const int plain = (*at >= 'a' && *at <= 'z') || (*at >= 'A' && *at <= 'Z') ||
                          (*at >= '0' && *at <= '9') || strchr("-._~/", *at);
        fprintf(out, plain ? "%c" : "%%%02X", *at);
    }
}
