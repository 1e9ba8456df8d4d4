/* check_one.c: norma check on one file, which may be fixed. */
#define _POSIX_C_SOURCE 200809L
#define _XOPEN_SOURCE   700
#include "cli/check/check.h"
#include <stdlib.h>
#include <string.h>

/* ---- A document mended, judged again, and written where it was asked for. */

typedef struct check_fixed {
    norma_document *document; /* as it is now; judged by findings */
    norma_findings *findings;
    int written;
    char *table; /* counts before and after, lines of text; NULL: nothing changed */
    norma_fix_summary summary;
    check_reason *reasons; /* what could not be fixed, and why */
    size_t reason_count;
} check_fixed;

/* ---- why fixes were left out */

/* Of a rule's name, whose number is not skipped. */
static int is_rule_digit(const char *text, const char *at) {
    for (size_t i = 1; i <= 3 && i <= (size_t)(at - text); ++i)
        if (at[-(ptrdiff_t)i] == 'N') return 1;
    return 0;
}

static const char *skip_numbers(const char *text, const char *at) {
    while (*at && strchr("0123456789, ", *at) && !is_rule_digit(text, at)) ++at;
    return at;
}

/* Reasons are alike if they differ in numbers alone: of meshes, of faces. */
static int compare_but_numbers(const char *one, const char *other) {
    for (const char *a = one, *b = other;; ++a, ++b) {
        a = skip_numbers(one, a);
        b = skip_numbers(other, b);
        if (*a != *b || !*a) return (unsigned char)*a - (unsigned char)*b;
    }
}

static int compare_reasons(const void *a, const void *b) {
    const check_reason *one = a, *other = b;
    int order = compare_but_numbers(one->text, other->text);
    if (!order) order = strcmp(one->text, other->text);
    return order ? order : (one->number > other->number) - (one->number < other->number);
}

static int compare_reason_numbers(const void *a, const void *b) {
    const size_t one = ((const check_reason *)a)->number, other = ((const check_reason *)b)->number;
    return (one > other) - (one < other);
}

/* Those that are alike, of which the first gets their number. */
static void fold_alike(check_reason *reasons, size_t count) {
    for (size_t i = 0, end; i < count; i = end) {
        size_t first = i;
        for (end = i; end < count && !compare_but_numbers(reasons[i].text, reasons[end].text);
             ++end)
            if (reasons[end].number < reasons[first].number) first = end;
        if (end - i <= CHECK_MOST_LINES) continue;
        for (size_t k = i; k < end; ++k) reasons[k].is_folded = k != first;
        reasons[first].more = end - i - 1;
    }
}

/* The notes of a document from the first on, each text once. NULL: memory is out. */
static check_reason *check_list_reasons(
    const norma_document *document, size_t first, size_t *count) {
    const size_t notes = norma_document_note_count(document) - first;
    size_t kept = 0;
    check_reason *reasons = calloc(notes + 1, sizeof *reasons);
    *count = 0;
    if (!reasons) return NULL;
    for (size_t i = 0; i < notes; ++i)
        reasons[i] = (check_reason){.text = norma_document_note(document, first + i), .number = i};
    qsort(reasons, notes, sizeof *reasons, compare_reasons);
    for (size_t i = 0; i < notes; ++i)
        if (!kept || strcmp(reasons[kept - 1].text, reasons[i].text) != 0)
            reasons[kept++] = reasons[i];
    fold_alike(reasons, kept);
    qsort(reasons, kept, sizeof *reasons, compare_reason_numbers);
    *count = kept;
    return reasons;
}

/* ---- the table */

/* What a rule counts; *gravest: the highest severity of its findings so far. */
static size_t count_of_rule(
    const norma_findings *findings, const norma_rule *rule, norma_severity *gravest) {
    size_t sum = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        if (finding->rule != rule) continue;
        sum += finding->count;
        if (finding->severity > *gravest) *gravest = finding->severity;
    }
    return sum;
}

/* Only what changed; information only if it is listed. */
static char *make_table(
    const norma_findings *before, const norma_findings *now, norma_severity least) {
    size_t count, rows = 0;
    cli_memory_stream table;
    const norma_rule *rules = norma_rules(&count);
    if (!cli_memory_open(&table)) return NULL;
    for (size_t i = 0; i < count; ++i) {
        norma_severity gravest = NORMA_SEVERITY_NONE;
        const size_t old = count_of_rule(before, &rules[i], &gravest),
                     left = count_of_rule(now, &rules[i], &gravest);
        if (old == left || gravest < least) continue;
        if (!rows++) fprintf(table.out, "    %-32s %10s %10s\n", "rule", "before", "after");
        fprintf(table.out, "    %s %-27s %10zu %10zu\n", rules[i].id, rules[i].name, old, left);
    }
    (void)cli_memory_close(&table);
    return table.text;
}

/* ---- mending and writing */

/* What could not be mended, and why. */
static void tell_reasons(const char *path, const check_fixed *mended) {
    for (size_t i = 0; i < mended->reason_count; ++i) {
        const check_reason *reason = &mended->reasons[i];
        if (reason->more)
            cli_error(
                "%s: %s (%zu more like this)", cli_input_name(path), reason->text, reason->more);
        else if (!reason->is_folded)
            cli_error("%s: %s", cli_input_name(path), reason->text);
    }
}

static norma_document_result fail_without_memory(norma_document_error *error) {
    *error = (norma_document_error){NORMA_DOCUMENT_ERROR_MEMORY, "out of memory"};
    return error->result;
}

static norma_document_result save_fixed(const check_settings *settings,
    const norma_check_options *checking, const char *output, check_fixed *mended,
    norma_document_error *error) {
    /* A copy without a change is written only where it was named. */
    if (settings->dry_run || (!settings->files->output && !mended->summary.changed))
        return NORMA_DOCUMENT_OK;
    norma_save_options options = {
        .progress = checking->progress, .progress_user = checking->progress_user};
    const norma_document_result result =
        cli_save(settings->files, mended->document, output, &options, error);
    mended->written = !result;
    return result;
}

/* before: findings of document with options, which rules the report has. 0: error says why. */
static norma_document_result check_fix(const check_settings *settings, norma_document *document,
    const norma_findings *before, const norma_check_options *options, size_t index,
    check_fixed *mended, norma_document_error *error) {
    const char *path = settings->files->inputs.list[index].path;
    *mended = (check_fixed){0};
    char *output = cli_output_of(settings->files, index, NULL);
    if (!output) return fail_without_memory(error);
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!settings->dry_run &&
        cli_guard_output(settings->files->guard, output, settings->files->in_place ? path : NULL)) {
        (void)cli_reported(error);
        result = error->result = NORMA_DOCUMENT_ERROR_ARGUMENT;
    }
    mended->document = document;
    const size_t notes = norma_document_note_count(document);
    if (!result)
        result = norma_fix_document(
            document, options, settings->fix == CHECK_FIX_UNSAFE, &mended->summary, error);
    if (!result && !(mended->reasons = check_list_reasons(document, notes, &mended->reason_count)))
        result = fail_without_memory(error);
    if (!result) tell_reasons(path, mended);
    if (!result && mended->summary.changed)
        result = norma_check_document(document, options, &mended->findings, error);
    if (!result && mended->summary.changed &&
        !(mended->table = make_table(before, mended->findings,
              settings->list_infos ? NORMA_SEVERITY_INFO : options->fix_from)))
        result = fail_without_memory(error);
    if (!result) result = save_fixed(settings, options, output, mended, error);
    free(output);
    return result;
}

static void check_fixed_free(check_fixed *mended) {
    norma_findings_free(mended->findings);
    free(mended->table);
    free(mended->reasons);
    *mended = (check_fixed){0};
}

/* ---- Norma check on one file: opened leniently, judged by the library, its findings
 * weighed by the configuration and the baseline, told by the report's form. */

/* Checking takes so many times the memory of computing normals: 1.5 and 3.8, measured. */
enum { PLY_NEED = 2, STL_NEED = 4 };

typedef struct file_check {
    const check_settings *settings;
    const check_config *config;
    const char *path;
    size_t index;   /* of the input */
    char *absolute; /* for patterns of files; NULL: none were asked for, or it is not there */
    norma_document *document;
    void *memory;
    norma_findings *findings;
    check_fixed mended; /* with --fix: what the report is then about */
    double from, to;    /* what is done now, as parts of the whole */
    double told;        /* never falls, though a fixed file is checked again */
    int fix_status;
    norma_document_error error;
} file_check;

/* ---- how far it is: reading, checking, then fixes or the trial of them */

static const double READ = 0.3, CHECKED = 0.85;

static int report_stage(void *user, double fraction) {
    file_check *check = user;
    const check_settings *settings = check->settings;
    const double now = check->from + (check->to - check->from) * fraction;
    check->told = now > check->told ? now : check->told;
    return settings->progress ? settings->progress(settings->progress_user, check->told) : 0;
}

static void begin_stage(file_check *check, double to) {
    check->from = check->to;
    check->to = to;
}

/* ---- what is asked of this file */

static norma_check_profile choose_profile(const file_check *check) {
    return check->settings->profile ? check->settings->profile : check->config->profile;
}

static void choose_checked_rules(const file_check *check, uint8_t mask[CHECK_RULES]) {
    const check_settings *settings = check->settings;
    const check_config *config = check->config;
    for (size_t rule = 0; rule < CHECK_RULES; ++rule) {
        int selected = settings->has_select ? settings->select[rule]
                       : config->has_select ? config->select[rule]
                                            : 1;
        mask[rule] = selected && !settings->ignore[rule] && !config->ignore[rule] &&
                     config->severity[rule] != CHECK_SEVERITY_OFF;
    }
}

/* What is no fault is changed only where its rule is named. */
static int is_selecting(const file_check *check) {
    return check->settings->has_select || check->config->has_select;
}

enum { MOST_MARKED = 1000 };

static norma_check_options choose_options(const file_check *check, const uint8_t *rules) {
    const check_settings *settings = check->settings;
    return (norma_check_options){.struct_size = sizeof(norma_check_options),
        .profile = choose_profile(check),
        .strict = settings->strict || check->config->strict == 1,
        .max_samples = settings->pictures ? MOST_MARKED : settings->max_samples,
        .whole_components = settings->pictures,
        .rules = rules,
        .threads = settings->threads,
        .progress = report_stage,
        .progress_user = (void *)(uintptr_t)check,
        .open_by_rays = settings->open_by_rays,
        .fix_from = is_selecting(check) ? NORMA_SEVERITY_NONE : NORMA_SEVERITY_WARNING};
}

static int fail_on(const file_check *check) {
    if (check->settings->fail_on >= 0) return check->settings->fail_on;
    return check->config->fail_on >= 0 ? check->config->fail_on : (int)NORMA_SEVERITY_ERROR;
}

static norma_file_format format_of(const file_check *check) {
    return check->settings->input_format ? check->settings->input_format
                                         : norma_file_format_of_path(check->path);
}

/* What the report is about. */
static const norma_findings *findings_of(const file_check *check) {
    return check->mended.findings && !check->fix_status ? check->mended.findings : check->findings;
}

static norma_document *document_of(const file_check *check) {
    return findings_of(check) == check->findings ? check->document : check->mended.document;
}

/* CHECK_SEVERITY_OFF: it is not told. Negative: memory is out. */
static int severity_of(check_names *names, const norma_finding *finding) {
    size_t count, rule = (size_t)(finding->rule - norma_rules(&count));
    const check_config *config = names->config;
    int severity = config->severity[rule] ? config->severity[rule] : (int)finding->severity;
    for (size_t i = 0; i < config->override_count; ++i) {
        const check_override *override = &config->overrides[i];
        const int meant = override->severity[rule] ? check_is_meant(names, override, finding) : 0;
        if (meant < 0) return meant;
        if (meant) severity = override->severity[rule];
    }
    return severity;
}

/* ---- judging */

static norma_document_result open_leniently(file_check *check, norma_document_error *error) {
    const norma_document_options opening = {.struct_size = sizeof opening,
        .format = check->settings->input_format,
        .threads = check->settings->threads,
        .lenient = 1,
        .progress = report_stage,
        .progress_user = check};
    return cli_open(
        check->settings->files, check->path, &opening, &check->document, &check->memory, error);
}

/* Where it fails, the report is about the file as it is, which is opened anew: the fix may have
 * changed the document. What came through a pipe cannot be, and has a report without pictures. */
static void fix_file(file_check *check, const norma_check_options *options) {
    norma_document_error error = {0}, unwanted;
    norma_document_result result = check_fix(check->settings, check->document, check->findings,
        options, check->index, &check->mended, &error);
    check->fix_status = cli_status_of(result);
    if (!result) return;
    cli_name_error(&error, check->path);
    cli_print_error(&error);
    check_fixed_free(&check->mended);
    norma_document_close(check->document);
    check->document = NULL;
    if (!check->memory) (void)open_leniently(check, &unwanted);
}

/* Files that are checked at once share the memory. */
static norma_document_result judge_in_parts(file_check *check, const norma_check_options *options) {
    const check_settings *settings = check->settings;
    begin_stage(check, 1);
    const norma_large_options large = {.struct_size = sizeof large,
        .max_memory = cli_memory_for_data() / (settings->at_once ? settings->at_once : 1),
        .format = settings->input_format};
    const norma_document_result result =
        norma_check_large(check->path, &large, options, &check->findings, &check->error);
    if (result || !settings->fix) return result;
    cli_error(
        "%s: larger than the memory allowed, and fixing needs the whole file; allow more memory",
        cli_input_name(check->path));
    check->fix_status = CLI_FILE;
    return NORMA_DOCUMENT_OK;
}

static norma_document_result judge_whole(file_check *check, const norma_check_options *options) {
    const check_settings *settings = check->settings;
    begin_stage(check, READ);
    norma_document_result result = open_leniently(check, &check->error);
    begin_stage(check, settings->fix ? (READ + CHECKED) / 2 : CHECKED);
    if (!result)
        result = norma_check_document(check->document, options, &check->findings, &check->error);
    if (settings->fix) begin_stage(check, CHECKED);
    if (!result && settings->fix) fix_file(check, options);
    return result;
}

/* A file that turns out to need more memory than reckoned is read in parts as well, if it can be.
 */
static norma_document_result open_and_judge(file_check *check) {
    uint8_t rules[CHECK_RULES];
    uint64_t need = 0;
    choose_checked_rules(check, rules);
    const norma_check_options options = choose_options(check, rules);
    const int possible = cli_can_take_passes(check->settings->files, check->path, &need);
    need *= format_of(check) == NORMA_FILE_STL ? STL_NEED : PLY_NEED;
    if (possible && need > cli_memory_for_data()) return judge_in_parts(check, &options);
    const norma_document_result result = judge_whole(check, &options);
    if (result != NORMA_DOCUMENT_ERROR_MEMORY || !possible) return result;
    norma_document_close(check->document);
    check->document = NULL;
    return judge_in_parts(check, &options);
}

/* A command is printed where it removes its finding, as a trial shows; else the reason. */
static norma_document_result try_offers(file_check *check, const check_format *format) {
    const check_settings *settings = check->settings;
    const check_config *config = check->config;
    const int mended = findings_of(check) != check->findings,
              is_text = format == &check_format_text;
    int changes = config->override_count > 0;
    uint8_t rules[CHECK_RULES];
    if (settings->quiet || format == &check_format_line || !document_of(check))
        return NORMA_DOCUMENT_OK;
    for (size_t rule = 0; rule < CHECK_RULES; ++rule) changes |= config->severity[rule] != 0;
    choose_checked_rules(check, rules);
    begin_stage(check, 1);
    const norma_check_options options = choose_options(check, rules);
    return norma_document_try_fixes(document_of(check), &options,
        is_text && !settings->list_infos && !changes ? NORMA_SEVERITY_WARNING : NORMA_SEVERITY_INFO,
        mended ? check->mended.findings : check->findings, &check->error);
}

/* What could not be fixed is not offered again, nor anything in a file that is read in parts:
 * fixing needs the whole of it. */
static norma_fix offered_fix(const file_check *check, const norma_finding *finding) {
    if (!document_of(check)) return NORMA_FIX_NONE;
    const int fix = check->fix_status ? CHECK_FIX_NOTHING : check->settings->fix;
    const int tried =
        finding->fix == NORMA_FIX_SAFE
            ? fix != CHECK_FIX_NOTHING
            : fix == CHECK_FIX_UNSAFE &&
                  (is_selecting(check) || finding->severity >= NORMA_SEVERITY_WARNING);
    return tried ? NORMA_FIX_NONE : finding->fix;
}

/* NULL where no fix is offered; 0: memory is out. finding: NULL for norma view. */
static int make_command(
    const file_check *check, const char *path, const norma_finding *finding, char **command) {
    const char *const *options = check->settings->command_options;
    if (finding && offered_fix(check, finding) == NORMA_FIX_NONE) return 1;
    const size_t length = norma_finding_command(finding, path, options, NULL, 0);
    if (!length) return 1;
    *command = malloc(length + 1);
    if (*command) norma_finding_command(finding, path, options, *command, length + 1);
    return *command != NULL;
}

/* For people, who paste them where they are. view: of a file as it was given. */
static int make_commands(const file_check *check, const check_format *format, check_item *items,
    size_t count, char **view) {
    int made = 1;
    const char *shown = check_shown_path(check->path),
               *path = format->is_worst_first && check->path[0] == '/' ? shown : check->path;
    for (size_t i = 0; i < count && made; ++i)
        made = make_command(check, path, items[i].finding, &items[i].command);
    if (made && check->settings->pictures && !check->settings->page && check->document &&
        document_of(check) == check->document &&
        norma_file_format_of_path(path) != NORMA_FILE_UNKNOWN)
        made = make_command(check, path, NULL, view);
    return made;
}

static void free_items(check_item *items, size_t count) {
    for (size_t i = 0; i < count; ++i) free(items[i].command);
    free(items);
}

/* items has room for all findings. 0: memory is out. */
static int weigh(const file_check *check, check_item *items, size_t *count, check_totals *totals) {
    size_t known = 0;
    check_baseline *baseline = check->settings->baseline;
    check_names names = {.config = check->config,
        .path = check->absolute ? check->absolute : check->path,
        .document = document_of(check)};
    int possible = 1;
    *count = 0;
    for (size_t i = 0; i < norma_findings_count(findings_of(check)) && possible; ++i) {
        const norma_finding *finding = norma_findings_get(findings_of(check), i);
        const int severity = severity_of(&names, finding);
        int is_known = 0;
        possible = severity >= 0;
        if (!possible || severity == CHECK_SEVERITY_OFF) continue;
        if (baseline && check_baseline_is_new(baseline))
            totals->forgot |= !check_baseline_note(
                baseline, check->path, finding, (norma_severity)severity, check->settings->known);
        else if (baseline)
            possible = check_baseline_knows(
                baseline, check->path, finding, (norma_severity)severity, &is_known);
        if (is_known)
            ++known;
        else
            items[(*count)++] = (check_item){finding, (norma_severity)severity, NULL};
    }
    totals->known += known;
    check_forget_places(&names);
    return possible;
}

/* "PATH: " and "PATH:" say again what the report says first; "PATH:12: " becomes "line 12: ". */
static void drop_path(char message[1000], const char *path) {
    char rest[1000];
    size_t length = strlen(path);
    if (strncmp(message, path, length) != 0 || message[length] != ':') return;
    strcpy(rest, message + length + 1);
    size_t digits = strspn(rest, "0123456789");
    snprintf(message, 1000, "%s%.990s", digits && rest[digits] == ':' ? "line " : "",
        rest + strspn(rest, " "));
}

/* The library's finding about a file that it could not open; without memory even for that, the
 * message alone. */
static void report_unreadable(
    file_check *check, const check_format *format, FILE *out, check_totals *totals) {
    const norma_check_options options = {
        .struct_size = sizeof options, .profile = choose_profile(check)};
    const char *path = cli_input_name(check->path);
    cli_name_error(&check->error, check->path);
    totals->status = cli_worse(totals->status, CLI_FILE);
    drop_path(check->error.message, path);
    norma_findings_free(check->findings);
    check->findings = norma_check_unreadable(&check->error, format_of(check), &options);
    if (!check->findings) {
        cli_error("%s: %s", path, check->error.message);
        totals->incomplete = totals->unreported = 1;
        return;
    }
    const check_item item = {
        .finding = norma_findings_get(check->findings, 0), .severity = NORMA_SEVERITY_ERROR};
    check_report report = {.settings = check->settings,
        .path = check->path,
        .profile = norma_findings_profile(check->findings),
        .status = "unreadable",
        .items = &item,
        .count = 1,
        .fail_on = fail_on(check)};
    check_write_file(&report, format, out, totals);
}

/* ---- The page that shows the file: norma.html; of a folder, which ends in a slash, the page that
 * norma view --out-dir made for it. */

int check_page_is_folder(const check_settings *settings) {
    const size_t length = settings->page ? strlen(settings->page) : 0;
    return length && settings->page[length - 1] == '/';
}

/* NULL: standard input, which has no address, or memory is out. */
static char *name_on_page(const file_check *check) {
    const check_settings *settings = check->settings;
    if (!settings->page || strcmp(check->path, "-") == 0) return NULL;
    cli_files places = *settings->files;
    places.output = NULL, places.folder = "";
    return check_page_is_folder(settings) ? cli_output_of(&places, check->index, ".html")
                                          : strdup(check_shown_path(check->path));
}

/* ---- beside its reference */

/* The file is read once more, as norma compare does: as it is drawn, with all of its normals. */
static int compare_with_reference(
    const check_settings *settings, const char *path, const char *reference, FILE *out, int json) {
    const cli_common common = {.threads = settings->threads, .json = json, .quiet = 1};
    const char *const names[2] = {reference, path};
    norma_document_error error = {0};
    const int status =
        compare_pair(settings->files, &common, &settings->limits, names, out, &error);
    if (error.result && !json) {
        cli_say(out, "%s: cannot be compared with its reference: %s", path, error.message);
        fputc('\n', out);
    }
    return status;
}

/* *text: to be freed. */
static int report_against(
    const check_settings *settings, const check_format *format, size_t index, char **text) {
    const cli_inputs *inputs = &settings->files->inputs;
    cli_memory_stream gathered;
    char *reference =
        cli_join(settings->against, inputs->list[index].path + inputs->list[index].tail);
    int status = CLI_FILE;
    *text = NULL;
    if (reference && cli_memory_open(&gathered)) {
        status = compare_with_reference(settings, inputs->list[index].path, reference, gathered.out,
            format == &check_format_json);
        if (cli_memory_close(&gathered)) *text = gathered.text;
    }
    free(reference);
    if (!*text) cli_out_of_memory();
    return *text ? status : CLI_FILE;
}

static void report_findings(
    file_check *check, const check_format *format, FILE *out, check_totals *totals) {
    char *against = NULL;
    check_item *items = calloc(norma_findings_count(findings_of(check)) + 1, sizeof *items);
    size_t count = 0;
    char *view = NULL;
    if (!items || !weigh(check, items, &count, totals) ||
        !make_commands(check, format, items, count, &view)) {
        free_items(items, count);
        check->error = (norma_document_error){NORMA_DOCUMENT_ERROR_MEMORY, "out of memory"};
        report_unreadable(check, format, out, totals);
        return;
    }
    char *page = name_on_page(check);
    check_report report = {.settings = check->settings,
        .path = check->path,
        .page = page,
        .view = view,
        .profile = norma_findings_profile(findings_of(check)),
        .status = norma_findings_partly(findings_of(check)) ? "partly" : "checked",
        .items = items,
        .count = count,
        .fail_on = fail_on(check),
        .document = document_of(check),
        .reasons = check->mended.reasons,
        .reason_count = check->mended.reason_count,
        .is_unchanged = check->settings->fix && !check->fix_status && check->mended.document &&
                        !check->mended.summary.changed,
        .mended = check->mended.table,
        .by_rays = check->mended.summary.by_rays,
        .undecided = check->mended.summary.undecided,
        .least_confidence = check->mended.summary.least_confidence};
    if (check->settings->against) {
        report.against_status = report_against(check->settings, format, check->index, &against);
        report.against = against;
    }
    totals->status = cli_worse(totals->status, check->fix_status);
    totals->incomplete |= check->fix_status != CLI_OK;
    check_write_file(&report, format, out, totals);
    free(against);
    free(page);
    free(view);
    free_items(items, count);
}

void check_one_file(const check_settings *settings, const check_config *config,
    const check_format *format, size_t index, FILE *out, check_totals *totals) {
    const char *path = settings->files->inputs.list[index].path;
    file_check check = {.settings = settings, .config = config, .path = path, .index = index};
    if (config->override_count) check.absolute = realpath(path, NULL);
    if (settings->lost)
        snprintf(check.error.message, sizeof check.error.message, "%s", settings->lost);
    norma_document_result result =
        settings->lost ? NORMA_DOCUMENT_ERROR_FILE : open_and_judge(&check);
    if (config->override_count)
        check_mark_names(&(check_names){.config = config,
            .path = check.absolute ? check.absolute : path,
            .document = check.document});
    if (!result) result = try_offers(&check, format);
    if (result)
        report_unreadable(&check, format, out, totals);
    else
        report_findings(&check, format, out, totals);
    check_fixed_free(&check.mended);
    norma_findings_free(check.findings);
    norma_document_close(check.document);
    free(check.memory);
    free(check.absolute);
}
