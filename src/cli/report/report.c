/* report.c: norma report: the reports of norma check as one. */
#include "cli/report/report.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- Merged reports in their own form, the entries byte by byte, or JSON in the words
 * of any other form. */

/* ---- as it is */

static check_entry report_entry(const report_part *part) {
    return (check_entry){.path = part->path,
        .errors = part->errors,
        .warnings = part->warnings,
        .is_clean = part->is_clean != 0};
}

static int compare_parts(const void *a, const void *b) {
    const report_part *one = a, *other = b;
    const check_entry entry = report_entry(one), other_entry = report_entry(other);
    const int order = check_compare_entries(&entry, &other_entry);
    if (order) return order;
    if (one->report != other->report) return one->report < other->report ? -1 : 1;
    return one->offset < other->offset ? -1 : one->offset > other->offset;
}

static void report_sort(report_merge *merged) {
    if (merged->part_count)
        qsort(merged->parts, merged->part_count, sizeof *merged->parts, compare_parts);
}

static int report_write_json(report_merge *merged, FILE *out) {
    check_totals totals = merged->totals;
    int status = CLI_OK;
    totals.status = merged->status;
    check_format_json.begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count && !status; ++i) {
        status = report_load_part(merged, &merged->parts[i]);
        if (i) fputs(",\n", out);
        if (!status) fwrite(merged->entry, 1, (size_t)merged->parts[i].size, out);
    }
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

static int report_write_sarif(report_merge *merged, FILE *out) {
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

static int report_write_html(report_merge *merged, FILE *out) {
    int status = CLI_OK;
    check_list list = {0};
    merged->totals.status = merged->status;
    merged->totals.list = &list;
    check_format_html.begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count && !status; ++i) {
        const check_entry entry = report_entry(&merged->parts[i]);
        status = check_list_add(&list, &entry) ? report_load_part(merged, &merged->parts[i])
                                               : cli_out_of_memory();
        if (status) break;
        check_begin_entry(&list, i, &check_format_html, out);
        fwrite(merged->entry, 1, (size_t)merged->parts[i].size, out);
    }
    check_format_html.end(out, &merged->totals, &merged->settings);
    check_list_free(&list);
    return status;
}

/* ---- JSON in another form */

static const char *text_of(cli_value object, const char *key) {
    const char *text = cli_string(cli_get(object, key));
    return text ? text : "";
}

static size_t index_of(cli_value object, const char *key) {
    size_t index = SIZE_MAX;
    cli_count_of(cli_get(object, key), &index);
    return index;
}

static norma_sample read_sample(cli_value object) {
    const cli_value position = cli_get(object, "position");
    norma_sample sample = {.vertex = index_of(object, "vertex"),
        .face = index_of(object, "face"),
        .normal = SIZE_MAX,
        .has_position = cli_elements(position) == 3};
    for (uint32_t i = 0; i < 3 && sample.has_position; ++i)
        cli_number_of(cli_element(position, i), &sample.position[i]);
    return sample;
}

/* The rule is that of the table, so one that this version does not know has no place in another
 * form. */
static int read_finding(cli_value object, norma_finding *finding) {
    const cli_value worst = cli_get(object, "worst");
    double value = NAN;
    cli_number_of(cli_get(worst, "value"), &value);
    *finding = (norma_finding){.rule = cli_find_rule(text_of(object, "rule")),
        .severity = report_severity(object),
        .where = text_of(object, "where"),
        .label = text_of(object, "where"),
        .count = index_of(object, "count"),
        .worst_value = value,
        .unit = text_of(worst, "unit"),
        .worst = read_sample(worst),
        .message = text_of(object, "message"),
        .mesh = strtoull(text_of(object, "mesh"), NULL, 16)};
    if (finding->count == SIZE_MAX) finding->count = 1;
    return finding->rule != NULL;
}

static norma_check_profile read_profile(cli_value file) {
    norma_check_profile profile = NORMA_CHECK_PROFILE_RENDER;
    check_find_profile(text_of(file, "profile"), &profile);
    return profile;
}

/* A status. */
static int write_file_as(const report_merge *merged, const char *path, cli_value file,
    const check_format *format, FILE *out, check_totals *totals) {
    const cli_value list = cli_get(file, "findings");
    const size_t room = cli_elements(list) + 1;
    norma_finding *findings = calloc(room, sizeof *findings);
    check_item *items = calloc(room, sizeof *items);
    const int fine = findings && items;
    check_report report = {.settings = &merged->settings,
        .path = path,
        .profile = read_profile(file),
        .status = text_of(file, "status"),
        .items = items,
        .fail_on = report_fail_on(file)};
    for (cli_value object = cli_first(list); object.in && fine; object = cli_next(object)) {
        norma_finding *finding = &findings[report.count];
        if (!read_finding(object, finding)) continue;
        items[report.count++] = (check_item){
            finding, finding->severity, (char *)(uintptr_t)cli_string(cli_get(object, "command"))};
    }
    if (fine) check_write_file(&report, format, out, totals);
    free(items);
    free(findings);
    return fine ? CLI_OK : cli_out_of_memory();
}

/* Takes over the text. Some forms have nothing to say of a file, and then need nothing between. */
static int write_or_keep(check_entry *entry, const check_format *format, FILE *out,
    const check_totals *totals, int *any) {
    if (format->is_worst_first) return check_list_add(totals->list, entry);
    if (entry->size && *any) fputs(format->between, out);
    *any |= entry->size > 0;
    fwrite(entry->text, 1, entry->size, out);
    free(entry->text);
    return 1;
}

static int write_part_as(report_merge *merged, const report_part *part, const check_format *format,
    FILE *out, check_totals *totals, int *any) {
    cli_memory_stream written;
    cli_json_fault fault;
    const check_totals before = *totals;
    int status = report_load_part(merged, part);
    if (status) return status;
    /* An entry that is what it was when it was read first can be read again. */
    cli_parsed *parsed = cli_json_parse(merged->entry, (size_t)part->size, &fault);
    if (parsed && cli_memory_open(&written))
        status =
            write_file_as(merged, part->path, cli_json_root(parsed), format, written.out, totals);
    cli_json_free(parsed);
    if (!parsed || !cli_memory_close(&written)) return status ? status : cli_out_of_memory();
    check_entry entry = {.path = part->path,
        .errors = totals->errors - before.errors,
        .warnings = totals->warnings - before.warnings,
        .is_clean = totals->clean > before.clean,
        .text = written.text,
        .size = written.size};
    if (write_or_keep(&entry, format, out, totals, any)) return status;
    free(written.text);
    return cli_out_of_memory();
}

static int report_write_as(
    report_merge *merged, const check_format *format, FILE *out, check_totals *totals) {
    int status = CLI_OK, any = 0;
    check_list list = {0};
    totals->list = &list;
    if (format->begin) format->begin(out, &merged->settings);
    for (size_t i = 0; i < merged->part_count && !status; ++i)
        status = write_part_as(merged, &merged->parts[i], format, out, totals, &any);
    check_list_sort(&list);
    if (!status && format->is_worst_first &&
        !check_list_write(&list, format, out, &merged->settings))
        status = cli_out_of_memory();
    totals->status = cli_worse(totals->status, merged->status);
    if (format->end) format->end(out, totals, &merged->settings);
    check_list_free(&list);
    return status;
}

/* ---- Reports of shards are put together only as a whole set: a shard that is missing, or there
 * twice, would make a wrong report that looks right. */

static const char *name_of_report(const report_merge *merged, size_t report) {
    return merged->files.paths[report];
}

static int same_options(const char *a, const char *b) {
    return a && b ? strcmp(a, b) == 0 : a == b;
}

/* Beside the first report. */
static int check_shard(const report_merge *merged, size_t report) {
    const report_shard *one = &merged->shards[report], *first = merged->shards;
    const char *name = name_of_report(merged, report), *first_name = name_of_report(merged, 0);
    if (one->count && (one->number == 0 || one->number > one->count)) {
        cli_error("%s: shard %zu of %zu does not exist", name, one->number, one->count);
        return CLI_FILE;
    }
    if (!one->count != !first->count) {
        cli_error("%s: is a shard, but %s is a whole report; expected all shards of a set",
            one->count ? name : first_name, one->count ? first_name : name);
        return CLI_FILE;
    }
    if (one->count != first->count) {
        cli_error("%s: is one of %zu shards, but %s is one of %zu", name, one->count, first_name,
            first->count);
        return CLI_FILE;
    }
    if (same_options(one->options, first->options)) return CLI_OK;
    cli_error("%s: was made with other options than %s: %s, not %s", name, first_name,
        one->options ? one->options : "none", first->options ? first->options : "none");
    return CLI_FILE;
}

typedef struct shard_place {
    size_t number, report;
} shard_place;

static int compare_shards(const void *a, const void *b) {
    const shard_place *one = a, *other = b;
    if (one->number != other->number) return one->number < other->number ? -1 : 1;
    return one->report < other->report ? -1 : one->report > other->report;
}

/* Sorted; each number at most once. */
static int refuse_doubles(const report_merge *merged, const shard_place *places, size_t count) {
    for (size_t i = 1; i < count; ++i)
        if (places[i].number == places[i - 1].number) {
            cli_error("%s: shard %zu of %zu is already in %s",
                name_of_report(merged, places[i].report), places[i].number, merged->shards->count,
                name_of_report(merged, places[i - 1].report));
            return CLI_FILE;
        }
    return CLI_OK;
}

enum { MOST_NAMED = 100 };

/* As JSON; a long list ends with null. */
static char *list_missing(const shard_place *places, size_t count, size_t shards) {
    cli_memory_stream text;
    size_t next = 0, named = 0;
    if (!cli_memory_open(&text)) return NULL;
    fputc('[', text.out);
    for (size_t number = 1; number <= shards && named <= MOST_NAMED; ++number) {
        if (next < count && places[next].number == number) {
            ++next;
            continue;
        }
        if (named) fputs(", ", text.out);
        if (named++ < MOST_NAMED)
            fprintf(text.out, "%zu", number);
        else
            fputs("null", text.out);
    }
    fputc(']', text.out);
    return cli_memory_close(&text) ? text.text : NULL;
}

static int tell_missing(const report_merge *merged, const char *list, int allowed) {
    cli_error("shards %s of %zu are missing%s", list, merged->shards->count,
        allowed ? "" : "; --partial joins the others");
    return CLI_FILE;
}

/* Whether all shards of a set are there, each once, of the same options. allows_missing: --partial,
 * and *missing is then the list of those that are not there, or NULL. A status. */
static int report_check_shards(
    report_merge *merged, size_t count, int allows_missing, char **missing) {
    int status = CLI_OK;
    for (size_t i = 0; i < count && !status; ++i) status = check_shard(merged, i);
    const size_t shards = merged->shards->count;
    if (status || !shards) return status;
    shard_place *places = calloc(count, sizeof *places);
    if (!places) return cli_out_of_memory();
    for (size_t i = 0; i < count; ++i) places[i] = (shard_place){merged->shards[i].number, i};
    qsort(places, count, sizeof *places, compare_shards);
    status = refuse_doubles(merged, places, count);
    if (!status && count < shards) {
        *missing = list_missing(places, count, shards);
        if (!*missing) status = cli_out_of_memory();
        if (!status && tell_missing(merged, *missing, allows_missing) && !allows_missing)
            status = CLI_FILE;
        merged->status = CLI_FILE;
    }
    free(places);
    return status;
}

/* ---- Norma report --merge: the reports of norma check on parts of a set of files,
 * put together as the report on the whole set. What each report is, its content says. */

static const char report_help[] =
    "norma report --merge REPORT... -o OUT: joins reports of norma check into one\n"
    "\n"
    "Examples\n"
    "  norma check models/ --shard 1/2 -o 1.json       on one machine\n"
    "  norma check models/ --shard 2/2 -o 2.json       on another\n"
    "  norma report --merge 1.json 2.json -o all.json\n"
    "  norma report --merge 1.json 2.json -o all.html  a page, without pictures\n"
    "  norma report --merge *.sarif -o all.sarif\n"
    "\n"
    "Each REPORT is a JSON, SARIF or HTML report of norma check; all must have the same format.\n"
    "  --format text|line|json|sarif|html\n"
    "                        the format to make of JSON reports. The default is the ending of -o, "
    "or\n"
    "                        JSON. SARIF and HTML reports keep their format\n"
    "  -o, --output FILE     writes the report to FILE, not to standard output\n"
    "  --info                also lists findings of severity info, in the formats text and line\n"
    "  --partial             joins shards (norma check --shard) although some are missing; the\n"
    "                        report names them, and the exit status is 3\n"
    "Files are sorted by path. Shards must be of one set: each once, with the same options.\n"
    "Exit status: by the findings, as one norma check of all files; 2 wrong usage, 3 a report\n"
    "could not be read or written, or a set of shards is not whole.\n";

typedef struct report_work {
    cli_files files; /* its words: the reports */
    int merge, partial;
    char *missing;
    const char *output;
    const check_format *format; /* NULL: as the output is called */
    report_merge merged;
} report_work;

static const char *set_merged_format(void *settings, const char *value) {
    ((report_work *)settings)->format = check_find_format(value);
    return ((report_work *)settings)->format ? NULL : CHECK_FORMAT_NAMES;
}

static const cli_option report_options[] = {
    {"merge", CLI_SETS(report_work, merge, 1)},
    {"partial", CLI_SETS(report_work, partial, 1)},
    {"output", 'o', CLI_TO(CLI_TEXT, report_work, output), .expected = "the name of a file, or -"},
    {"format", CLI_SET(set_merged_format)},
    {"info", CLI_SETS(report_work, merged.settings.list_infos, 1)},
};

/* ---- reading */

static const char *kind_name(report_kind kind) {
    return kind == REPORT_HTML ? "HTML" : kind == REPORT_SARIF ? "SARIF" : "JSON";
}

static int read_reports(report_merge *merged, const cli_words *words, cli_guard *guard) {
    int status = report_merge_begin(merged, words->words, words->count);
    for (size_t i = 0; i < words->count && !status; ++i) {
        const report_kind before = merged->kind;
        cli_guard_read(guard, words->words[i]);
        status = report_read(merged, i);
        if (status || !before || before == merged->kind) continue;
        cli_error("%s: is %s, but the reports before it are %s; expected one format for all",
            words->words[i], kind_name(merged->kind), kind_name(before));
        status = CLI_FILE;
    }
    return status;
}

/* ---- writing */

/* Only JSON can become another form. */
static int choose_format(const cli_subcommand *command, report_work *work) {
    const report_kind kind = work->merged.kind;
    const check_format *own = kind == REPORT_SARIF  ? &check_format_sarif
                              : kind == REPORT_HTML ? &check_format_html
                                                    : &check_format_json;
    if (!work->format) work->format = own;
    return kind != REPORT_JSON && work->format != own
               ? cli_usage(command, "reports in %s stay %s; expected JSON for --format %s",
                     kind_name(kind), kind_name(kind), work->format->name)
               : CLI_OK;
}

/* Standard output and pipes cannot take back a part: all entries are looked at before. */
static int look_again(report_merge *merged) {
    int status = CLI_OK;
    for (size_t i = 0; i < merged->part_count && !status; ++i)
        status = report_load_part(merged, &merged->parts[i]);
    return status;
}

static int write_parts(report_work *work, FILE *out, check_totals *totals) {
    switch (work->merged.kind) {
    case REPORT_SARIF:
        return report_write_sarif(&work->merged, out);
    case REPORT_HTML:
        return report_write_html(&work->merged, out);
    default:
        return work->format == &check_format_json
                   ? report_write_json(&work->merged, out)
                   : report_write_as(&work->merged, work->format, out, totals);
    }
}

static int write_merged(report_work *work) {
    cli_output output;
    check_totals totals = {0};
    int status = cli_output_begin(&output, work->output, work->files.guard);
    if (status) return status;
    if (output.passes_on) status = look_again(&work->merged);
    if (!status) status = write_parts(work, output.out, &totals);
    if (status) {
        cli_output_drop(&output);
        return status;
    }
    return cli_worse(cli_worse(work->merged.status, totals.status), cli_output_end(&output));
}

static int merge_reports(const cli_subcommand *command, report_work *work) {
    const cli_words *words = &work->files.words;
    if (!work->merge) return cli_usage(command, "nothing to do was given; expected --merge");
    if (!words->count) return cli_usage(command, "no report was given");
    if (!work->format) work->format = check_format_of_name(work->output);
    int status = read_reports(&work->merged, words, work->files.guard);
    if (!status)
        status = report_check_shards(&work->merged, words->count, work->partial, &work->missing);
    work->merged.settings.missing = work->missing;
    if (!status) status = choose_format(command, work);
    if (!status) {
        work->merged.settings.file_count = work->merged.part_count;
        report_sort(&work->merged);
        status = write_merged(work);
    }
    return status;
}

static int report_run(const cli_subcommand *command, int count, char **arguments) {
    report_work work = {.output = "-"};
    const cli_table tables[] = {{report_options, CLI_COUNT(report_options), &work}};
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = merge_reports(command, &work);
    report_merge_free(&work.merged);
    free(work.missing);
    cli_files_end(&work.files);
    return status;
}

const cli_subcommand cli_subcommand_report = {
    "report", "joins reports of norma check into one", report_help, report_run};
