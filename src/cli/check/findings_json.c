/* findings_json.c: findings for programs: the schema norma-check/1. Keys are fixed; more may be
 * added. */
#include "cli/check/check_command.h"
#include "cli/text/report_text.h"
#include <math.h>

static const char *fix_name(norma_fix fix) {
    return fix == NORMA_FIX_SAFE ? "safe" : fix == NORMA_FIX_UNSAFE ? "unsafe" : NULL;
}

static void write_number(cli_json *json, const char *key, size_t number) {
    if (number == SIZE_MAX)
        cli_json_null(json, key);
    else
        cli_json_size(json, key, number);
}

static void write_position(cli_json *json, const norma_sample *sample) {
    if (!sample->has_position) {
        cli_json_null(json, "position");
        return;
    }
    cli_json_open(json, "position", '[');
    for (int i = 0; i < 3; ++i) cli_json_number(json, NULL, sample->position[i]);
    cli_json_close(json, ']');
}

static void write_worst(cli_json *json, const norma_finding *finding) {
    cli_json_open(json, "worst", '{');
    cli_json_number(json, "value", finding->worst_value);
    cli_json_string(json, "unit", finding->unit);
    write_number(json, "vertex", finding->worst.vertex);
    write_number(json, "face", finding->worst.face);
    write_position(json, &finding->worst);
    cli_json_close(json, '}');
}

static void write_sample(cli_json *json, const norma_sample *sample) {
    cli_json_open(json, NULL, '{');
    if (sample->vertex != SIZE_MAX) cli_json_size(json, "vertex", sample->vertex);
    if (sample->face != SIZE_MAX) cli_json_size(json, "face", sample->face);
    if (sample->normal != SIZE_MAX) cli_json_size(json, "normal", sample->normal);
    write_position(json, sample);
    cli_json_close(json, '}');
}

/* How the stored normals were probably made, and how many corners are how far off. */
static void write_deviation(cli_json *json, const norma_deviation *deviation) {
    static const char *const shadings[] = {"default", "crease", "smooth", "flat"};
    cli_json_open(json, "deviation", '{');
    cli_json_string(json, "shading", shadings[deviation->shading]);
    cli_json_string(json, "weight",
        deviation->shading == NORMA_SHADING_FLAT ? NULL : norma_weight_name(deviation->weight));
    cli_json_number(json, "crease_deg", cli_given_degrees(deviation->crease_angle_rad));
    cli_json_number(json, "mean_deg", cli_to_degrees(deviation->mean_rad));
    cli_json_number(json, "p50_deg", cli_to_degrees(deviation->p50_rad));
    cli_json_number(json, "p99_deg", cli_to_degrees(deviation->p99_rad));
    cli_json_number(json, "max_deg", cli_to_degrees(deviation->max_rad));
    cli_json_open(json, "histogram", '[');
    for (size_t bin = 0; bin < NORMA_DEVIATION_BINS; ++bin) {
        cli_json_open(json, NULL, '{');
        cli_json_number(json, "below_deg", cli_given_degrees(norma_deviation_bound_rad(bin)));
        cli_json_size(json, "corners", deviation->histogram[bin]);
        cli_json_close(json, '}');
    }
    cli_json_close(json, ']');
    cli_json_close(json, '}');
}

static void write_item(cli_json *json, const check_item *item) {
    const norma_finding *finding = item->finding;
    cli_json_open(json, NULL, '{');
    cli_json_string(json, "rule", finding->rule->id);
    cli_json_string(json, "name", finding->rule->name);
    cli_json_string(json, "severity", check_severity_name(item->severity));
    cli_json_string(json, "where", finding->where);
    cli_json_size(json, "count", finding->count);
    write_worst(json, finding);
    cli_json_open(json, "samples", '[');
    for (size_t i = 0; i < finding->sample_count; ++i) write_sample(json, &finding->samples[i]);
    cli_json_close(json, ']');
    cli_json_string(json, "fix", fix_name(finding->fix));
    cli_json_string(json, "command", item->command);
    cli_json_string(json, "message", finding->message);
    if (finding->deviation) write_deviation(json, finding->deviation);
    cli_json_close(json, '}');
}

/* Why fixes were left out. Without --fix there is no such key. */
static void write_reasons(cli_json *json, const check_report *report) {
    if (!report->document || report->first_note == SIZE_MAX) return;
    cli_json_open(json, "not_fixed", '[');
    for (size_t i = report->first_note; i < norma_document_note_count(report->document); ++i)
        if (check_is_new_note(report->document, report->first_note, i))
            cli_json_string(json, NULL, norma_document_note(report->document, i));
    cli_json_close(json, ']');
}

static void begin(FILE *out, const check_settings *settings) {
    cli_json json = {.out = out};
    fputs("{\"schema\": \"norma-check/1\", ", out);
    check_write_shard(&json, settings);
    fputs(json.needs_comma ? ", \"files\": [\n" : "\"files\": [\n", out);
}

static void write_file(FILE *out, const check_report *report) {
    cli_json json = {.out = out};
    cli_json_open(&json, NULL, '{');
    cli_json_string(&json, "path", report->path);
    if (!cli_is_utf8(report->path)) {
        fputs(", \"path_bytes\": \"", out);
        check_write_bytes(out, report->path);
        fputc('"', out);
    }
    if (report->fail_on != (int)NORMA_SEVERITY_ERROR)
        cli_json_string(&json, "fail_on",
            report->fail_on == CHECK_FAIL_NEVER
                ? "never"
                : check_severity_name((norma_severity)report->fail_on));
    cli_json_string(&json, "profile", check_profile_name(report->profile));
    cli_json_string(&json, "status", report->status);
    cli_json_open(&json, "findings", '[');
    for (size_t i = 0; i < report->count; ++i) write_item(&json, &report->items[i]);
    cli_json_close(&json, ']');
    write_reasons(&json, report);
    if (report->by_rays + report->undecided) {
        cli_json_open(&json, "open_by_rays", '{');
        cli_json_size(&json, "decided", report->by_rays);
        cli_json_size(&json, "undecided", report->undecided);
        cli_json_number(
            &json, "least_confidence", report->by_rays ? report->least_confidence : NAN);
        cli_json_close(&json, '}');
    }
    cli_json_close(&json, '}');
}

static void end(FILE *out, const check_totals *totals, const check_settings *settings) {
    (void)settings;
    cli_json json = {.out = out, .needs_comma = 1};
    fputs("\n]", out);
    cli_json_open(&json, "summary", '{');
    cli_json_size(&json, "errors", totals->errors);
    cli_json_size(&json, "warnings", totals->warnings);
    cli_json_size(&json, "infos", totals->infos);
    cli_json_size(&json, "files", totals->files);
    cli_json_size(&json, "not_checked", totals->not_checked);
    cli_json_size(&json, "exit_status", (size_t)totals->status);
    if (totals->incomplete) cli_json_bool(&json, "complete", 0);
    cli_json_close(&json, '}');
    fputs("}\n", out);
}

const check_format check_format_json = {"json", begin, write_file, ",\n", end};
