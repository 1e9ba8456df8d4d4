/* findings_sarif.c: findings as SARIF 2.1.0 (OASIS 2020), for code scanning: the place within a
 * file is a logical location (a JSON pointer), and a fingerprint that stays the same from run to
 * run tells old findings from new ones. */
#include "cli/check/check_command.h"
#include "cli/process/errors.h"
#include <string.h>

static const char *level_of(norma_severity severity) {
    return severity == NORMA_SEVERITY_ERROR     ? "error"
           : severity == NORMA_SEVERITY_WARNING ? "warning"
                                                : "note";
}

static void write_text(cli_json *json, const char *key, const char *text) {
    cli_json_open(json, key, '{');
    cli_json_string(json, "text", text);
    cli_json_close(json, '}');
}

static void write_rule(cli_json *json, const norma_rule *rule) {
    cli_json_open(json, NULL, '{');
    cli_json_string(json, "id", rule->id);
    cli_json_string(json, "name", rule->name);
    write_text(json, "shortDescription", rule->what);
    write_text(json, "fullDescription", rule->why);
    write_text(json, "help", rule->how);
    cli_json_open(json, "defaultConfiguration", '{');
    cli_json_string(json, "level", level_of(rule->render));
    cli_json_close(json, '}');
    cli_json_close(json, '}');
}

static void begin(FILE *out, const check_settings *settings) {
    (void)settings;
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    cli_json json = {.out = out};
    fputs("{\"$schema\": \"https://json.schemastore.org/sarif-2.1.0.json\", \"version\": "
          "\"2.1.0\", \"runs\": [{\"tool\": {\"driver\": {\"name\": \"norma\"",
        out);
    json.needs_comma = 1;
    cli_json_string(&json, "semanticVersion", norma_version());
    cli_json_open(&json, "rules", '[');
    for (size_t i = 0; i < count; ++i) write_rule(&json, &rules[i]);
    cli_json_close(&json, ']');
    fputs("}}, \"columnKind\": \"unicodeCodePoints\", \"results\": [\n", out);
}

/* What RFC 3986 lets stand in a path stays; all else is percent-encoded. */
static void write_uri(cli_json *json, const char *path) {
    char uri[4200];
    size_t used = 0;
    for (const unsigned char *at = (const unsigned char *)path; *at && used + 4 < sizeof uri;
         ++at) {
        int plain = (*at >= 'a' && *at <= 'z') || (*at >= 'A' && *at <= 'Z') ||
                    (*at >= '0' && *at <= '9') || strchr("-._~/!$&'()*+,;=@", *at);
        if (plain)
            uri[used++] = (char)*at;
        else
            used += (size_t)snprintf(uri + used, sizeof uri - used, "%%%02X", *at);
    }
    uri[used] = '\0';
    cli_json_string(json, "uri", uri);
}

static void write_location(
    cli_json *json, const check_report *report, const norma_finding *finding) {
    cli_json_open(json, "locations", '[');
    cli_json_open(json, NULL, '{');
    cli_json_open(json, "physicalLocation", '{');
    cli_json_open(json, "artifactLocation", '{');
    write_uri(json, strcmp(report->path, "-") ? report->path : "stdin");
    cli_json_close(json, '}');
    cli_json_close(json, '}');
    if (finding->where[0]) {
        cli_json_open(json, "logicalLocations", '[');
        cli_json_open(json, NULL, '{');
        cli_json_string(json, "fullyQualifiedName", finding->where);
        cli_json_string(json, "kind", "object");
        cli_json_close(json, '}');
        cli_json_close(json, ']');
    }
    cli_json_close(json, '}');
    cli_json_close(json, ']');
}

static void write_item(cli_json *json, const check_report *report, const check_item *item) {
    const norma_finding *finding = item->finding;
    char fingerprint[17];
    check_fingerprint(report->path, finding->rule->id, finding->where, item->severity, fingerprint);
    cli_json_open(json, NULL, '{');
    cli_json_string(json, "ruleId", finding->rule->id);
    cli_json_size(json, "ruleIndex", check_rule_number(finding->rule));
    cli_json_string(json, "level", level_of(item->severity));
    write_text(json, "message", finding->message);
    write_location(json, report, finding);
    cli_json_open(json, "partialFingerprints", '{');
    cli_json_string(json, "norma/v1", fingerprint);
    cli_json_close(json, '}');
    cli_json_open(json, "properties", '{');
    cli_json_size(json, "count", finding->count);
    cli_json_string(json, "command", item->command);
    cli_json_close(json, '}');
    cli_json_close(json, '}');
}

static void write_file(FILE *out, const check_report *report) {
    for (size_t i = 0; i < report->count; ++i) {
        cli_json json = {.out = out};
        if (i) fputs(",\n", out);
        write_item(&json, report, &report->items[i]);
    }
}

static void end(FILE *out, const check_totals *totals, const check_settings *settings) {
    (void)settings;
    fprintf(out, "\n], \"invocations\": [{\"exitCode\": %d, \"executionSuccessful\": %s}]}]}\n",
        totals->status, totals->status == CLI_FILE ? "false" : "true");
}

const check_format check_format_sarif = {"sarif", begin, write_file, ",\n", end};
