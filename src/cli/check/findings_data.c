/* findings_data.c: the forms of a report for programs. */
#include "cli/check/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Findings for programs: the schema norma-check/1. Keys are fixed; more may be
 * added. */

static void write_position(cli_json *json, const norma_sample *sample) {
    if (sample->has_position)
        cli_json_numbers(json, "position", sample->position, 3);
    else
        cli_json_null(json, "position");
}

static void write_json_worst(cli_json *json, const norma_finding *finding) {
    const norma_sample *worst = &finding->worst;
    cli_json_print(json, "worst: {value: %g, unit: %s, vertex: %zd, face: %zd",
        finding->worst_value, finding->unit, worst->vertex, worst->face);
    write_position(json, worst);
    cli_json_close(json, '}');
}

static void write_json_sample(cli_json *json, const norma_sample *sample) {
    cli_json_open(json, NULL, '{');
    if (sample->vertex != SIZE_MAX) cli_json_size(json, "vertex", sample->vertex);
    if (sample->face != SIZE_MAX) cli_json_size(json, "face", sample->face);
    if (sample->normal != SIZE_MAX) cli_json_size(json, "normal", sample->normal);
    write_position(json, sample);
    cli_json_close(json, '}');
}

/* How the stored normals were probably made, and how many corners are how far off. */
static void write_deviation(cli_json *json, const norma_deviation *deviation) {
    cli_json_print(json, "deviation: {shading: %s, weight: %s, crease_deg: %g",
        cli_shading_names[deviation->shading],
        deviation->shading == NORMA_SHADING_FLAT ? NULL : norma_weight_name(deviation->weight),
        cli_given_degrees(deviation->crease_angle_rad));
    cli_json_print(json, "mean_deg: %g, p50_deg: %g, p99_deg: %g, max_deg: %g, histogram: [",
        cli_to_degrees(deviation->mean_rad), cli_to_degrees(deviation->p50_rad),
        cli_to_degrees(deviation->p99_rad), cli_to_degrees(deviation->max_rad));
    for (size_t bin = 0; bin < NORMA_DEVIATION_BINS; ++bin)
        cli_json_print(json, "{below_deg: %g, corners: %zu}",
            cli_given_degrees(norma_deviation_bound_rad(bin)), deviation->histogram[bin]);
    cli_json_print(json, "]}");
}

static void write_json_item(cli_json *json, const check_item *item) {
    const norma_finding *finding = item->finding;
    const norma_rule *rule = finding->rule;
    cli_json_print(json, "{rule: %s, name: %s, severity: %s, where: %s, count: %zu", rule->id,
        rule->name, cli_severity_name(item->severity), finding->where, finding->count);
    write_json_worst(json, finding);
    cli_json_open(json, "samples", '[');
    for (size_t i = 0; i < finding->sample_count; ++i)
        write_json_sample(json, &finding->samples[i]);
    cli_json_print(json, "], fix: %s, command: %s, message: %s, cause: %s, impact: %s",
        cli_fix_name(finding->fix), item->command, finding->message, rule->cause, rule->why);
    if (finding->mesh && item->severity >= NORMA_SEVERITY_WARNING) {
        char mesh[17];
        snprintf(mesh, sizeof mesh, "%016" PRIx64, finding->mesh);
        cli_json_string(json, "mesh", mesh);
    }
    if (finding->deviation) write_deviation(json, finding->deviation);
    cli_json_close(json, '}');
}

/* Why fixes were left out. Without --fix there is no such key. */
static void write_json_reasons(cli_json *json, const check_report *report) {
    if (!report->reasons) return;
    cli_json_open(json, "not_fixed", '[');
    for (size_t i = 0; i < report->reason_count; ++i)
        cli_json_string(json, NULL, report->reasons[i].text);
    cli_json_close(json, ']');
}

static void begin_json(FILE *out, const check_settings *settings) {
    cli_json json = {.out = out};
    fputs("{\"schema\": \"norma-check/1\", ", out);
    check_write_shard(&json, settings);
    fputs(json.needs_comma ? ", \"files\": [\n" : "\"files\": [\n", out);
}

static void write_json_file(FILE *out, const check_report *report) {
    cli_json json = {.out = out};
    cli_json_print(&json, "{path: %s", report->path);
    if (!cli_is_utf8(report->path)) {
        fputs(", \"path_bytes\": \"", out);
        check_write_uri(out, report->path, "-._~/");
        fputc('"', out);
    }
    if (report->fail_on != (int)NORMA_SEVERITY_ERROR)
        cli_json_string(&json, "fail_on",
            report->fail_on == CHECK_FAIL_NEVER
                ? "never"
                : cli_severity_name((norma_severity)report->fail_on));
    cli_json_print(&json, "profile: %s, status: %s, findings: [",
        check_profile_name(report->profile), report->status);
    for (size_t i = 0; i < report->count; ++i) write_json_item(&json, &report->items[i]);
    cli_json_close(&json, ']');
    write_json_reasons(&json, report);
    if (report->against) cli_json_raw(&json, "against", report->against);
    if (report->by_rays + report->undecided)
        cli_json_print(&json, "open_by_rays: {decided: %zu, undecided: %zu, least_confidence: %g}",
            report->by_rays, report->undecided, report->by_rays ? report->least_confidence : NAN);
    cli_json_close(&json, '}');
}

static void end_json(FILE *out, const check_totals *totals, const check_settings *settings) {
    (void)settings;
    cli_json json = {.out = out, .needs_comma = 1};
    cli_json_print(&json, "\n], summary: {");
    check_write_counts(&json, totals, 0);
    cli_json_print(&json, "}}\n");
}

const check_format check_format_json = {
    "json", begin_json, write_json_file, ",\n", end_json, 0, NULL};

/* ---- Findings as SARIF 2.1.0 (OASIS 2020), for code scanning: the place within a
 * file is a logical location (a JSON pointer), and a fingerprint that stays the same from run to
 * run tells old findings from new ones. */

static const char *level_of(norma_severity severity) {
    return severity == NORMA_SEVERITY_ERROR     ? "error"
           : severity == NORMA_SEVERITY_WARNING ? "warning"
                                                : "note";
}

static void write_sarif_rule(cli_json *json, const norma_rule *rule) {
    cli_json_print(json,
        "{id: %s, name: %s, shortDescription: {text: %s}, fullDescription: {text: %s}, "
        "help: {text: %s}, defaultConfiguration: {level: %s}}",
        rule->id, rule->name, rule->what, rule->why, rule->how, level_of(rule->render));
}

static void begin_sarif(FILE *out, const check_settings *settings) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    cli_json json = {.out = out};
    cli_json_print(&json,
        "{$schema: %s, version: \"2.1.0\", runs: [{tool: {driver: {name: \"norma\", "
        "semanticVersion: %s, rules: [",
        "https://json.schemastore.org/sarif-2.1.0.json", norma_version());
    for (size_t i = 0; i < count; ++i) write_sarif_rule(&json, &rules[i]);
    cli_json_print(&json, "]}}, columnKind: \"unicodeCodePoints\"");
    if (settings->shards || settings->missing) {
        cli_json_open(&json, "properties", '{');
        check_write_shard(&json, settings);
        cli_json_close(&json, '}');
    }
    cli_json_print(&json, "results: [\n");
}

static void write_location(
    cli_json *json, const check_report *report, const norma_finding *finding) {
    cli_json_print(json, "locations: [{physicalLocation: {artifactLocation: {");
    fputs("\"uri\": \"", json->out);
    check_write_uri(json->out, strcmp(report->path, "-") ? report->path : "stdin",
        "-._~/!$&'()*+,;=@"); /* RFC 3986: of a path */
    fputs("\"}}", json->out);
    json->needs_comma = 1;
    if (finding->where[0])
        cli_json_print(
            json, "logicalLocations: [{fullyQualifiedName: %s, kind: \"object\"}]", finding->where);
    cli_json_print(json, "}]");
}

static void write_result(cli_json *json, const check_report *report, const check_item *item) {
    const norma_finding *finding = item->finding;
    const norma_rule *rule = finding->rule;
    char fingerprint[17];
    check_fingerprint(report->path, rule->id, finding->where, item->severity, fingerprint);
    cli_json_print(json, "{ruleId: %s, ruleIndex: %zu, level: %s, message: {text: %s}", rule->id,
        check_rule_number(rule), level_of(item->severity), finding->message);
    write_location(json, report, finding);
    cli_json_print(json,
        "partialFingerprints: {norma/v1: %s}, properties: {count: %zu, command: %s", fingerprint,
        finding->count, item->command);
    const int fails = (int)item->severity >= report->fail_on;
    if (fails != (item->severity == NORMA_SEVERITY_ERROR)) cli_json_bool(json, "fails", fails);
    cli_json_print(json, "}}");
}

static void write_sarif_file(FILE *out, const check_report *report) {
    for (size_t i = 0; i < report->count; ++i) {
        cli_json json = {.out = out};
        if (i) fputs(",\n", out);
        write_result(&json, report, &report->items[i]);
    }
}

/* ---- the limit */

/* Code scanning takes no more results of a run (GitHub, "SARIF support for code scanning"). */
enum { MOST_RESULTS = 25000 };

typedef struct sarif_result {
    char *text;                /* NULL: given up */
    size_t size, rule, before; /* before: the one before it of its rule that is kept */
} sarif_result;

struct check_results {
    sarif_result *results;
    size_t count, room, kept;
    size_t kept_of[CHECK_RULES], last_of[CHECK_RULES], left_out[CHECK_RULES];
};

check_results *check_results_new(void) {
    check_results *results = calloc(1, sizeof *results);
    for (size_t rule = 0; results && rule < CHECK_RULES; ++rule) results->last_of[rule] = SIZE_MAX;
    return results;
}

void check_results_free(check_results *results) {
    for (size_t i = 0; results && i < results->count; ++i) free(results->results[i].text);
    if (results) free(results->results);
    free(results);
}

/* As write_result begins. */
static size_t rule_of(const char *text, size_t size) {
    static const char key[] = "\"ruleIndex\": ";
    size_t rule = 0;
    for (size_t at = 0; at + sizeof key <= size; ++at)
        if (memcmp(text + at, key, sizeof key - 1) == 0) {
            for (at += sizeof key - 1; at < size && text[at] >= '0' && text[at] <= '9'; ++at)
                rule = 10 * rule + (size_t)(text[at] - '0');
            break;
        }
    return rule < CHECK_RULES ? rule : CHECK_RULES - 1;
}

/* The last one of the rule that has the most. */
static size_t give_up_one(check_results *results, size_t next) {
    size_t most = next;
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        if (results->kept_of[rule] > results->kept_of[most]) most = rule;
    ++results->left_out[most];
    if (most == next) return most;
    sarif_result *last = &results->results[results->last_of[most]];
    free(last->text);
    last->text = NULL;
    results->last_of[most] = last->before;
    --results->kept_of[most];
    --results->kept;
    return most;
}

static int add_result(check_results *results, const char *text, size_t size) {
    const size_t rule = rule_of(text, size);
    if (results->kept == MOST_RESULTS && give_up_one(results, rule) == rule) return 1;
    sarif_result *grown = cli_grow(results->results, results->count, &results->room, sizeof *grown);
    if (!grown) return 0;
    results->results = grown;
    char *copy = malloc(size + 1);
    if (!copy) return 0;
    memcpy(copy, text, size);
    results->results[results->count] = (sarif_result){copy, size, rule, results->last_of[rule]};
    results->last_of[rule] = results->count++;
    ++results->kept_of[rule];
    ++results->kept;
    return 1;
}

int check_results_add(check_results *results, const char *text, size_t size) {
    int fine = 1;
    while (size > 0 && fine) {
        const char *end_sarif = memchr(text, '\n', size);
        const size_t line = end_sarif ? (size_t)(end_sarif - text) : size,
                     length = line && end_sarif && text[line - 1] == ',' ? line - 1 : line;
        fine = !length || add_result(results, text, length);
        text += line + (end_sarif != NULL);
        size -= line + (end_sarif != NULL);
    }
    return fine;
}

void check_results_write(const check_results *results, FILE *out, check_totals *totals) {
    int any = 0;
    for (size_t i = 0; i < results->count; ++i) {
        if (!results->results[i].text) continue;
        if (any) fputs(",\n", out);
        fwrite(results->results[i].text, 1, results->results[i].size, out);
        any = 1;
    }
    memcpy(totals->left_out, results->left_out, sizeof totals->left_out);
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        if (results->left_out[rule])
            cli_error("%s: %zu of %zu results left out; a SARIF report holds at most %d",
                norma_rules(NULL)[rule].id, results->left_out[rule],
                results->left_out[rule] + results->kept_of[rule], (int)MOST_RESULTS);
}

/* What the results do not show. */
static void write_notification(cli_json *json, int *any, const char *text) {
    if (!(*any)++) cli_json_open(json, "toolExecutionNotifications", '[');
    cli_json_print(json, "{level: \"warning\", message: {text: %s}}", text);
}

/* What the results do not show. */
static void write_notifications(
    cli_json *json, const check_totals *totals, const check_settings *settings) {
    char text[160];
    int any = 0;
    for (size_t rule = 0; rule < CHECK_RULES; ++rule) {
        if (!totals->left_out[rule]) continue;
        snprintf(text, sizeof text, "%s: %zu results left out; a report holds at most %d",
            norma_rules(NULL)[rule].id, totals->left_out[rule], (int)MOST_RESULTS);
        write_notification(json, &any, text);
    }
    if (settings->missing) {
        snprintf(text, sizeof text, "shards %.100s are missing", settings->missing);
        write_notification(json, &any, text);
    }
    if (any) cli_json_close(json, ']');
}

static void end_sarif(FILE *out, const check_totals *totals, const check_settings *settings) {
    cli_json json = {.out = out, .needs_comma = 1};
    cli_json_print(&json, "\n], invocations: [{exitCode: %zu, executionSuccessful: %d",
        (size_t)totals->status, totals->status != CLI_FILE);
    write_notifications(&json, totals, settings);
    cli_json_print(&json, "}]}]}\n");
}

const check_format check_format_sarif = {
    "sarif", begin_sarif, write_sarif_file, ",\n", end_sarif, 0, NULL};
