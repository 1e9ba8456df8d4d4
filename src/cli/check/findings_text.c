/* findings_text.c: what all forms of a report ask of a finding, and the forms for people. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- What all forms of the report ask of a finding or a file. */

size_t check_rule_number(const norma_rule *rule) { return (size_t)(rule - norma_rules(NULL)); }

const char *check_profile_name(norma_check_profile profile) {
    return profile == NORMA_CHECK_PROFILE_PRINT       ? "print"
           : profile == NORMA_CHECK_PROFILE_GENERATED ? "generated"
                                                      : "render";
}

int check_find_profile(const char *name, norma_check_profile *profile) {
    for (int i = NORMA_CHECK_PROFILE_RENDER; i <= NORMA_CHECK_PROFILE_GENERATED; ++i)
        if (name && strcmp(check_profile_name((norma_check_profile)i), name) == 0) {
            *profile = (norma_check_profile)i;
            return 1;
        }
    return 0;
}

static int is_problem(const check_report *report, const check_item *item) {
    return item->severity != NORMA_SEVERITY_INFO || (int)item->severity >= report->fail_on;
}

/* In reports for people: information is only counted, unless it was asked for or fails the check.
 */
static int check_is_listed(const check_report *report, const check_item *item) {
    return report->settings->list_infos || is_problem(report, item);
}

int check_is_clean(const check_report *report) {
    for (size_t i = 0; i < report->count; ++i)
        if (is_problem(report, &report->items[i])) return 0;
    return !report->against_status && strcmp(report->status, "checked") == 0;
}

int check_fails(const check_report *report) {
    for (size_t i = 0; i < report->count; ++i)
        if ((int)report->items[i].severity >= report->fail_on) return 1;
    return report->against_status != CLI_OK;
}

int check_is_same(const check_item *item, const check_item *other) {
    return item->finding->rule == other->finding->rule && item->severity == other->severity;
}

int check_is_first(const check_report *report, size_t index) {
    for (size_t i = 0; i < index; ++i)
        if (check_is_same(&report->items[i], &report->items[index])) return 0;
    return 1;
}

size_t check_count_same(const check_report *report, const check_item *item) {
    return report->same[check_rule_number(item->finding->rule)][item->severity];
}

/* one that is missing, or cannot be read */
static int check_is_picture(const check_item *item) {
    size_t tile;
    return strcmp(item->finding->rule->id, "N002") == 0 &&
           strncmp(check_where_in_tile(item->finding->where, &tile), "/images/", 8) == 0;
}

uint64_t check_key(const check_report *report, const check_item *item) {
    const norma_finding *finding = item->finding;
    const size_t of[] = {check_rule_number(finding->rule), item->severity};
    const uint64_t key = cli_hash(CLI_HASH, of, sizeof of);
    if (report->settings->file_count < 2) return 0;
    if (check_is_picture(item)) return key;
    if (!finding->mesh || item->severity < NORMA_SEVERITY_WARNING) return 0;
    return cli_hash(cli_hash(key, &finding->mesh, sizeof finding->mesh), finding->message,
        strlen(finding->message));
}

/* Open edges are faults of a print, so for rendering they are not looked at; that a surface has
 * some is known from N304. */
const char *check_unseen(const check_report *report) {
    if (report->profile != NORMA_CHECK_PROFILE_RENDER) return "";
    for (size_t i = 0; i < report->count; ++i)
        if (strcmp(report->items[i].finding->rule->id, "N304") == 0)
            return " (open edges are not looked at in profile render)";
    return "";
}

const char *check_shown_path(const char *path) {
    char folder[4096];
    const char *name = cli_input_name(path);
    if (path[0] != '/' || !getcwd(folder, sizeof folder)) return name;
    const size_t length = strlen(folder);
    return length > 1 && strncmp(path, folder, length) == 0 && path[length] == '/' &&
                   path[length + 1]
               ? path + length + 1
               : name;
}

/* ---- totals */

static void count_items(
    const check_report *report, size_t same[][CHECK_SEVERITIES], check_totals *totals) {
    for (size_t i = 0; i < report->count; ++i) {
        const check_item *item = &report->items[i];
        ++same[check_rule_number(item->finding->rule)][item->severity];
        totals->hidden += !check_is_listed(report, item);
        if ((int)item->severity >= report->fail_on)
            totals->status = cli_worse(totals->status, CLI_FINDINGS);
    }
}

/* Of one file: the findings of each rule and severity. */
static void count_findings(size_t same[][CHECK_SEVERITIES], check_totals *totals) {
    size_t of[CHECK_SEVERITIES] = {0};
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        for (size_t severity = 0; severity < CHECK_SEVERITIES; ++severity) {
            of[severity] += same[rule][severity];
            totals->by_rule[rule][severity].findings += same[rule][severity];
            totals->by_rule[rule][severity].files += same[rule][severity] > 0;
        }
    totals->errors += of[NORMA_SEVERITY_ERROR];
    totals->warnings += of[NORMA_SEVERITY_WARNING];
    totals->infos += of[NORMA_SEVERITY_INFO];
    totals->files_with_trouble += of[NORMA_SEVERITY_ERROR] + of[NORMA_SEVERITY_WARNING] > 0;
}

void check_write_file(
    check_report *report, const check_format *format, FILE *out, check_totals *totals) {
    size_t same[CHECK_RULES][CHECK_SEVERITIES] = {{0}};
    count_items(report, same, totals);
    count_findings(same, totals);
    ++totals->files;
    totals->not_checked += strcmp(report->status, "checked") != 0;
    totals->differing += report->against_status != CLI_OK;
    totals->status = cli_worse(totals->status, report->against_status);
    totals->clean += (size_t)check_is_clean(report);
    report->same = (const size_t(*)[CHECK_SEVERITIES])same;
    report->shown = check_shown_path(report->path);
    if (format->file) format->file(out, report);
}

/* ---- places and nodes */

const char *check_where_in_tile(const char *where, size_t *tile) {
    static const char tiles[] = "/tiles/";
    *tile = 0;
    if (strncmp(where, tiles, sizeof tiles - 1) != 0) return where;
    where += sizeof tiles - 1;
    for (; *where >= '0' && *where <= '9'; ++where) *tile = 10 * *tile + (size_t)(*where - '0');
    return where;
}

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
    size_t tile;
    where = check_where_in_tile(where, &tile);
    document = norma_document_tile(document, tile);
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
        cli_json_print(json, "shard: [%zu, %zu]", settings->shard, settings->shards);
        cli_json_raw(json, "options", settings->shard_options);
    } else if (settings->missing) {
        cli_json_raw(json, "missing_shards", settings->missing);
    }
}

void check_write_counts(cli_json *json, const check_totals *totals, int whole) {
    cli_json_print(json, "errors: %zu, warnings: %zu, infos: %zu, files: %zu", totals->errors,
        totals->warnings, totals->infos, totals->files);
    if (whole) cli_json_size(json, "files_with_trouble", totals->files_with_trouble);
    cli_json_size(json, "not_checked", totals->not_checked);
    if (whole) cli_json_size(json, "known", totals->known);
    cli_json_size(json, "exit_status", (size_t)totals->status);
    if (totals->incomplete) cli_json_bool(json, "complete", 0);
}

void check_write_uri(FILE *out, const char *text, const char *kept) {
    for (const unsigned char *at = (const unsigned char *)text; *at; ++at) {
        const int plain = (*at >= 'a' && *at <= 'z') || (*at >= 'A' && *at <= 'Z') ||
                          (*at >= '0' && *at <= '9') || strchr(kept, *at);
        fprintf(out, plain ? "%c" : "%%%02X", *at);
    }
}

/* ---- Findings for people: what, where, how bad, why it matters, what to do; then how
 * many of each rule, and the verdict last. Information is counted, and listed only if asked for. */

enum {
    INDENT = 4,
    LABELS_NAMED = 3, /* of those */
    MOST_CLEAN = 10   /* if there are more files, those without problems are only counted */
};

/* ---- colours */

static const char *color_of(norma_severity severity) {
    return severity == NORMA_SEVERITY_ERROR     ? "\033[1;31m"
           : severity == NORMA_SEVERITY_WARNING ? "\033[1;33m"
                                                : "\033[1;34m";
}

static void write_severity(FILE *out, const check_settings *settings, norma_severity severity) {
    const char *name = cli_severity_name(severity);
    if (settings->style.color)
        fprintf(out, "%s%s\033[0m", color_of(severity), name);
    else
        fputs(name, out);
}

/* ---- one finding */

static void write_text_sample(FILE *out, const norma_sample *sample) {
    if (sample->vertex != SIZE_MAX)
        fprintf(out, "vertex %zu", sample->vertex);
    else if (sample->face != SIZE_MAX)
        fprintf(out, "face %zu", sample->face);
    else if (sample->normal != SIZE_MAX)
        fprintf(out, "normal %zu", sample->normal);
    else
        fputs("the place", out);
    if (sample->has_position)
        fprintf(out, " at (%.6g, %.6g, %.6g)", sample->position[0], sample->position[1],
            sample->position[2]);
}

static void write_head(FILE *line, const check_report *report, const check_item *item) {
    cli_say(line, "%s: ", report->shown);
    write_severity(line, report->settings, item->severity);
    cli_say(line, " %s %s: ", item->finding->rule->id, item->finding->rule->name);
}

static void write_sentence(FILE *line, const char *message) {
    const size_t length = strlen(message);
    cli_write_outside(line, message);
    if (length && !strchr(".!?", message[length - 1])) fputc('.', line);
}

static void write_text_worst(FILE *line, const check_report *report, const norma_finding *finding) {
    const norma_sample *worst = &finding->worst;
    if (worst->vertex == SIZE_MAX && worst->face == SIZE_MAX && !worst->has_position) return;
    fputs(" worst: ", line);
    write_text_sample(line, worst);
    const char *node = check_node_path(report->document, finding->where);
    if (node) cli_say(line, " in node %s", node);
    fputc('.', line);
}

static void write_single(FILE *line, const check_report *report, const check_item *item) {
    write_head(line, report, item);
    if (item->finding->label[0]) cli_say(line, "%s: ", item->finding->label);
    write_sentence(line, item->finding->message);
    write_text_worst(line, report, item->finding);
}

/* ---- findings of one rule in one line */

static void write_label(FILE *line, const norma_finding *finding) {
    if (finding->label[0])
        cli_write_outside(line, finding->label);
    else
        fputs("the file", line);
}

static int is_of_group(const check_item *first, const check_item *item) {
    return check_is_same(first, item) && check_is_picture(first) == check_is_picture(item);
}

/* Of the group of an item, which is its first. */
static size_t count_together(const check_report *report, const check_item *item) {
    size_t count = 0;
    for (const check_item *at = item; at < report->items + report->count; ++at)
        count += (size_t)is_of_group(item, at);
    return count;
}

static int is_first_of_group(const check_report *report, const check_item *item) {
    for (const check_item *at = report->items; at < item; ++at)
        if (is_of_group(item, at)) return 0;
    return 1;
}

static int is_told_together(const check_report *report, const check_item *item) {
    return check_is_picture(item) || check_count_same(report, item) > CHECK_MOST_LINES;
}

static void write_together(FILE *line, const check_report *report, const check_item *item) {
    const size_t count = count_together(report, item);
    size_t named = 0;
    write_head(line, report, item);
    if (check_is_picture(item))
        cli_counted(line, count,
            "texture is missing or cannot be read: ", "textures are missing or cannot be read: ");
    else
        fprintf(line, "%zu findings: in ", count);
    for (const check_item *at = item; named < count && named < LABELS_NAMED; ++at) {
        if (!is_of_group(item, at)) continue;
        fputs(named++ ? ", " : "", line);
        write_label(line, at->finding);
    }
    if (count > named) fprintf(line, " and %zu more", count - named);
    if (check_is_picture(item)) {
        fputs("; normal maps in them were not checked.", line);
        return;
    }
    fputs(". The first: ", line);
    write_sentence(line, item->finding->message);
}

/* ---- lines */

/* The same for what several files have in common. 0: of this file alone. */
static uint64_t line_key(const check_report *report, const check_item *item) {
    uint64_t key = 0;
    for (const check_item *at = item; at < report->items + report->count; ++at) {
        if (at != item && !(is_told_together(report, item) && is_of_group(item, at))) continue;
        const uint64_t one = check_key(report, at);
        if (!one) return 0;
        if (at == item || !check_is_picture(at)) key = 31 * key + one;
    }
    return key;
}

/* Without memory to wrap it, a line is as long as it is. A command is never wrapped: on a terminal
 * it has a line of its own. */
static void write_item(FILE *out, const check_report *report, const check_item *item) {
    const size_t width = report->settings->style.width;
    void (*write)(FILE *, const check_report *, const check_item *) =
        is_told_together(report, item) ? write_together : write_single;
    const uint64_t key = line_key(report, item);
    cli_memory_stream line;
    if (key) fprintf(out, "%c%016" PRIx64, CHECK_SAME, key);
    if (cli_memory_open(&line)) write(line.out, report, item);
    if (cli_memory_close(&line))
        cli_write_wrapped(out, line.text, width, INDENT);
    else
        write(out, report, item);
    free(line.text);
    if (key) fputc(CHECK_ALSO, out);
    if (item->command)
        fprintf(out, "%s%*sFix: %s", width ? "\n" : " ", width ? INDENT : 0, "", item->command);
    fputc('\n', out);
    if (key) fputc(CHECK_SAME_END, out);
}

static void write_items(FILE *out, const check_report *report, norma_severity severity) {
    for (size_t i = 0; i < report->count; ++i) {
        const check_item *item = &report->items[i];
        if (item->severity != severity || !check_is_listed(report, item)) continue;
        if (is_told_together(report, item) && !is_first_of_group(report, item)) continue;
        write_item(out, report, item);
    }
}

/* ---- one file */

static void write_rays(FILE *out, const check_report *report) {
    const char *path = report->shown;
    if (report->by_rays) {
        cli_say(out, "%s: %zu open %s outward by a majority of rays, confidence at least %.2f",
            path, report->by_rays, report->by_rays == 1 ? "component looks" : "components look",
            floor(100 * report->least_confidence) / 100);
        fputc('\n', out);
    }
    if (report->undecided) {
        cli_say(out, "%s: %zu open %s left as %s, rays do not agree", path, report->undecided,
            report->undecided == 1 ? "component is" : "components are",
            report->undecided == 1 ? "it is" : "they are");
        fputc('\n', out);
    }
}

static void write_unchanged(FILE *out, const check_report *report) {
    const check_settings *settings = report->settings;
    cli_say(out, "%s: nothing was fixed%s", report->shown,
        settings->dry_run         ? ""
        : settings->files->output ? ", the output is the input, byte for byte"
                                  : ", no file is written");
    fputc('\n', out);
}

static void write_text_file(FILE *out, const check_report *report) {
    const int is_shown = !check_is_clean(report) || report->settings->file_count <= MOST_CLEAN;
    if (report->is_unchanged && is_shown) write_unchanged(out, report);
    if (report->mended) {
        cli_say(out, "%s: fixed", report->shown);
        fprintf(out, "\n%s", report->mended);
    }
    write_rays(out, report);
    for (int severity = NORMA_SEVERITY_ERROR; severity >= NORMA_SEVERITY_INFO; --severity)
        write_items(out, report, (norma_severity)severity);
    const int listed = report->settings->list_infos && report->count;
    if (check_is_clean(report) && !listed && report->settings->file_count <= MOST_CLEAN) {
        cli_say(out, "%s: No problems found%s", report->shown, check_unseen(report));
        fputc('\n', out);
    }
    if (report->against && is_shown) fputs(report->against, out);
}

/* ---- the end */

/* "    warning N602 mirrored                         3 in 2 files" */
static void write_text_total(FILE *out, const check_settings *settings, const norma_rule *rule,
    norma_severity severity, const check_rule_total *total) {
    fprintf(out, "%*s", INDENT, "");
    write_severity(out, settings, severity);
    fprintf(out, "%*s %s %-25s %6zu in %zu %s\n",
        (int)(strlen("warning") - strlen(cli_severity_name(severity))), "", rule->id, rule->name,
        total->findings, total->files, total->files == 1 ? "file" : "files");
}

static void write_text_totals(
    FILE *out, const check_totals *totals, const check_settings *settings) {
    size_t count;
    const norma_rule *rules = norma_rules(&count);
    fputs("Findings by rule:\n", out);
    for (int severity = NORMA_SEVERITY_ERROR;
         severity >= (totals->hidden ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO); --severity)
        for (size_t rule = 0; rule < count; ++rule)
            if (totals->by_rule[rule][severity].findings)
                write_text_total(out, settings, &rules[rule], (norma_severity)severity,
                    &totals->by_rule[rule][severity]);
}

void check_write_verdict(FILE *out, const check_totals *totals) {
    fprintf(out, "%zu %s, %zu %s in %zu of %zu %s", totals->errors,
        totals->errors == 1 ? "error" : "errors", totals->warnings,
        totals->warnings == 1 ? "warning" : "warnings", totals->files_with_trouble, totals->files,
        totals->files == 1 ? "file" : "files");
    if (totals->not_checked) fprintf(out, "; %zu not checked", totals->not_checked);
    if (totals->differing) fprintf(out, "; %zu not as the reference", totals->differing);
    if (totals->known) fprintf(out, "; %zu known to the baseline", totals->known);
}

static void end_quietly(FILE *out, const check_totals *totals, const check_settings *settings) {
    check_write_verdict(out, totals);
    if (settings->missing) fprintf(out, "; shards %s are missing", settings->missing);
    fputc('\n', out);
}

static void end_text(FILE *out, const check_totals *totals, const check_settings *settings) {
    const size_t listed = totals->errors + totals->warnings + totals->infos - totals->hidden;
    if (totals->clean && settings->file_count > MOST_CLEAN) {
        fputs("No problems found in ", out);
        cli_counted(out, totals->clean, "file", "files");
        fputc('\n', out);
    }
    if (totals->files > 1 && listed > 1) write_text_totals(out, totals, settings);
    if (totals->hidden && !settings->fix) {
        cli_counted(out, totals->hidden, "info", "infos");
        fprintf(out, " not listed; --info lists %s\n", totals->hidden == 1 ? "it" : "them");
    }
    end_quietly(out, totals, settings);
}

const check_format check_format_text = {"text", NULL, write_text_file, "", end_text, 1, NULL};
const check_format check_format_quiet = {
    "text", NULL, NULL, "", end_quietly, 0, NULL}; /* the verdict alone */

/* ---- Findings for grep and editors, one on each line and nothing else:
 *   path: severity rule place: message
 * The place is a JSON pointer, "/" for a whole file. */

static void write_lines(FILE *out, const check_report *report) {
    for (size_t i = 0; i < report->count; ++i) {
        const check_item *item = &report->items[i];
        if (!check_is_listed(report, item)) continue;
        const char *where = item->finding->where;
        cli_say(out, "%s: %s %s %s: %s", cli_input_name(report->path),
            cli_severity_name(item->severity), item->finding->rule->id, where[0] ? where : "/",
            item->finding->message);
        fputc('\n', out);
    }
}

const check_format check_format_line = {"line", NULL, write_lines, "", NULL, 0, NULL};
