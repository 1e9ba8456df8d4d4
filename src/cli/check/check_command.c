/* check_command.c: norma check: the rules over files, and the report. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The forms of a report, by their names and by the endings of files. */

static const check_format *const formats[] = {&check_format_text, &check_format_line,
    &check_format_json, &check_format_sarif, &check_format_html};

const check_format *check_find_format(const char *name) {
    for (size_t i = 0; i < CLI_COUNT(formats); ++i)
        if (strcmp(name, formats[i]->name) == 0) return formats[i];
    return NULL;
}

const check_format *check_format_of_name(const char *path) {
    const char *ending = strrchr(path, '.');
    if (!ending || strchr(ending, '/')) return NULL;
    if (strcmp(ending, ".htm") == 0) return &check_format_html;
    return strcmp(ending, ".txt") == 0 ? &check_format_text : check_find_format(ending + 1);
}

/* ---- One of several jobs that share a set of files: those whose paths, relative to the folder
 * given, have its hash, so that each job can say it of a file that it alone has. */

static int read_shard_number(const char *text, size_t length, size_t *number) {
    *number = 0;
    if (length == 0 || length > 9) return 0;
    for (size_t i = 0; i < length; ++i) {
        if (text[i] < '0' || text[i] > '9') return 0;
        *number = 10 * *number + (size_t)(text[i] - '0');
    }
    return 1;
}

static const char *read_shard(const char *text, size_t *number, size_t *count) {
    const size_t length = strcspn(text, "/");
    const int fine = text[length] == '/' && read_shard_number(text, length, number) &&
                     read_shard_number(text + length + 1, strlen(text + length + 1), count);
    return fine && *number >= 1 && *number <= *count ? NULL : "I/N, such as 2/8: I from 1 to N";
}

/* The upper half is mixed into the lower one. */
static uint64_t hash_path(const char *path) {
    const uint64_t hash = cli_hash(CLI_HASH, path, strlen(path));
    return hash ^ hash >> 32;
}

/* A path without "./" in front of it. */
static const char *plain(const char *path) {
    while (path[0] == '.' && path[1] == '/') path += 1 + strspn(path + 1, "/");
    return path;
}

static void keep_shard(cli_inputs *inputs, size_t number, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < inputs->count; ++i) {
        if (hash_path(plain(inputs->list[i].path + inputs->list[i].within)) % count == number - 1)
            inputs->list[kept++] = inputs->list[i];
        else
            free(inputs->list[i].path);
    }
    inputs->count = kept;
}

static const char check_help[] =
    "norma check IN...: checks normals, winding, texture seams and transforms, and can fix them\n"
    "\n"
    "Examples\n"
    "  norma check chair.glb\n"
    "  norma check models/ --fail-on warning           every mesh file of the folder and below\n"
    "  git diff --name-only | norma check --files-from - --format sarif -o norma.sarif\n"
    "  norma check part.stl -o part.html               a page with pictures\n"
    "\n"
    "Rules\n"
    "  --select RULES        only these: ids (N301), their beginnings (N3), names, by commas\n"
    "  --ignore RULES        skips these rules\n"
    "  --profile render|print|generated\n"
    "                        what the meshes are for (print for STL, 3MF; else render); generated\n"
    "                        judges models that a program made\n"
    "  --strict              accepts lengths of normals that differ from 1 by at most 1e-4\n"
    "  --config FILE         reads this configuration (.norma.json in the file's folder, or in\n"
    "                        the nearest folder above that has one)\n"
    "  --no-config           reads no configuration\n"
    "  --trust-config        also reads a .norma.json that belongs to another user\n"
    "  --baseline FILE       hides the findings recorded in FILE, unless they got worse\n"
    "  --write-baseline FILE records today's findings in FILE\n"
    "\n"
    "References\n"
    "  --against FOLDER      also compares each file with its namesake in FOLDER (norma compare)\n"
    "  --max DEG             status 1 if normals differ by more than DEG on\n"
    "  --share PART          more than PART of the area, from 0 to 1 (0)\n"
    "\n"
    "Report\n"
    "  --format text|line|json|sarif|html\n"
    "                        the default is the ending of -o, or text; --json is --format json\n"
    "  -o, --output FILE     writes the report to FILE (standard output); with --fix, see below\n"
    "  --info                also lists findings of severity info, else only counted\n"
    "  --color auto|always|never\n"
    "                        auto: on a terminal, unless NO_COLOR is set (auto)\n"
    "  --fail-on error|warning|info|never\n"
    "                        the lowest severity for which the exit status is 1 (error)\n"
    "  --max-samples N       lists at most N places for each finding (10)\n"
    "  --page ADDRESS        links HTML findings to norma.html, or to FOLDER/ of norma view\n"
    "  --quiet               prints only the report's last line\n"
    "\n"
    "Fixes\n"
    "  --fix                 makes the safe fixes: lengths, NaN, zeros, facet normals, tangents\n"
    "  --fix-unsafe          also changes things that may be intended: windings, sides, missing\n"
    "                        normals, transforms. --select limits it to some rules, and adds "
    "infos\n"
    "  -o, --output FILE     the fixed file; - is standard output, and the report then goes to\n"
    "                        standard error\n"
    "  --out-dir FOLDER      the folder for fixed files, if there are several inputs\n"
    "  --in-place            replaces each input file; a failure leaves it as it was\n"
    "  --open-by-rays        with --fix-unsafe: turns open surfaces (N304) outward by a majority\n"
    "                        of rays, and reports the confidence: 1 if all rays agree\n"
    "  --dry-run             reports what a fix would leave, and writes nothing\n"
    "With a fix, report and exit status are about the fixed file. A fix that would open edges or\n"
    "cause more findings of a rule is skipped, and the reason printed.\n"
    "\n"
    "Files\n"
    "  IN                    a file, a folder, or a pattern in quotes\n"
    "  --files-from FILE     reads names of files from FILE, one per line; - is standard input.\n"
    "                        Skips and counts other formats, and missing files unless all are\n"
    "  --shard I/N           checks one of N parts of the files, chosen by their paths; norma\n"
    "                        report --merge joins the reports\n"
    "  --exit findings|job   job: ends with 0 whatever was found or could not be read "
    "(findings)\n" CLI_INPUT_FORMAT_HELP
    "  --threads N           uses at most N threads (all processors)\n"
    "  --max-memory SIZE     uses at most SIZE (512M, 2G). Reads a larger binary PLY or STL in\n"
    "                        parts; N002 lists the rules not checked. Others fail\n"
    "\n"
    "Exit status: 0 fine, 1 findings at or above --fail-on, 2 wrong usage, 3 a file could not be\n"
    "read or written, 130 interrupted.\n";

typedef struct check_work {
    check_settings settings;
    const check_format *format;
    const char *config, *baseline, *new_baseline;
    check_config_trust trust;
    cli_color_mode color;
    int exits_job; /* --exit job: what is found is not told by the status */
    char *shard_options;
    cli_files files; /* the words, --input-format, and where the report or what is mended goes */
    cli_common common;
    char expected[160]; /* what a wrong list of rules may mean */
} check_work;

/* ---- options */

/* Messages are of this length at most, and stay in the work for as long as the command line is
 * read. */
static const char *set_rules(check_work *work, const char *value, uint8_t *mask) {
    static const char expected[] =
        "ids of rules (N301), their beginnings (N3) or names, with commas";
    char unknown[64] = "";
    if (!norma_rules_select(value, mask, unknown)) return NULL;
    const char *meant = cli_suggest_rule(unknown);
    if (!meant) return expected;
    snprintf(work->expected, sizeof work->expected, "%s; did you mean %s?", expected, meant);
    return work->expected;
}

static const char *set_check_select(void *settings, const char *value) {
    check_work *work = settings;
    work->settings.has_select = 1;
    return set_rules(work, value, work->settings.select);
}

static const char *set_ignore(void *settings, const char *value) {
    return set_rules(settings, value, ((check_work *)settings)->settings.ignore);
}

static const char *set_check_format(void *settings, const char *value) {
    ((check_work *)settings)->format = check_find_format(value);
    return ((check_work *)settings)->format ? NULL : CHECK_FORMAT_NAMES;
}

static const char *set_shard(void *settings, const char *value) {
    check_work *work = settings;
    return read_shard(value, &work->settings.shard, &work->settings.shards);
}

static const char *set_fail_on(void *settings, const char *value) {
    const norma_severity severity = cli_find_severity(value);
    ((check_work *)settings)->settings.fail_on = severity ? (int)severity : CHECK_FAIL_NEVER;
    return severity || strcmp(value, "never") == 0 ? NULL : "error, warning, info or never";
}

static const char *set_fix(void *settings, const char *value) {
    check_settings *check = &((check_work *)settings)->settings;
    (void)value;
    check->fix = check->fix ? check->fix : CHECK_FIX_SAFE;
    return NULL;
}

static const char *set_files_from(void *settings, const char *value) {
    check_work *work = settings;
    work->files.lists.words[work->files.lists.count++] = value;
    return value[0] ? NULL : "the name of a file, or -";
}

static const cli_option check_command_options[] = {
    {"select", CLI_SET(set_check_select)},
    {"ignore", CLI_SET(set_ignore)},
    {"profile", CLI_TO(CLI_CHOICE, check_work, settings.profile),
        .number = NORMA_CHECK_PROFILE_RENDER, .words = "render,print,generated",
        .expected = "render, print or generated"},
    {"strict", CLI_SETS(check_work, settings.strict, 1)},
    {"config", CLI_TO(CLI_TEXT, check_work, config), .expected = "the name of a file"},
    {"no-config", CLI_SETS(check_work, trust, CHECK_CONFIG_NONE)},
    {"trust-config", CLI_SETS(check_work, trust, CHECK_CONFIG_ANY)},
    {"baseline", CLI_TO(CLI_TEXT, check_work, baseline), .expected = "the name of a file"},
    {"write-baseline", CLI_TO(CLI_TEXT, check_work, new_baseline),
        .expected = "the name of a file"},
    {"against", CLI_TO(CLI_TEXT, check_work, settings.against), .expected = "a folder"},
    {"format", CLI_SET(set_check_format)},
    {"page", CLI_TO(CLI_TEXT, check_work, settings.page),
        .expected = "the address of norma.html, or a folder of pages"},
    {"info", CLI_SETS(check_work, settings.list_infos, 1)},
    {"color", CLI_TO(CLI_CHOICE, check_work, color), .words = "auto,always,never",
        .expected = "auto, always or never"},
    {"fix", .set = set_fix},
    {"fix-unsafe", CLI_SETS(check_work, settings.fix, CHECK_FIX_UNSAFE)},
    {"dry-run", CLI_SETS(check_work, settings.dry_run, 1)},
    {"open-by-rays", CLI_SETS(check_work, settings.open_by_rays, 1)},
    {"fail-on", CLI_SET(set_fail_on)},
    {"max-samples", CLI_TO(CLI_SIZE, check_work, settings.max_samples), .least = 1, .most = 1e9,
        .expected = CLI_WHOLE_FROM_1},
    {"files-from", CLI_SET(set_files_from)},
    {"shard", CLI_SET(set_shard)},
    {"exit", CLI_TO(CLI_CHOICE, check_work, exits_job), .words = "findings,job",
        .expected = "findings or job"},
};

/* ---- the command */

/* Without these words the command of a fix would judge differently. */
static void choose_command_options(check_work *work) {
    const char **option = work->settings.command_options;
    if (work->settings.profile)
        *option++ = "--profile", *option++ = check_profile_name(work->settings.profile);
    if (work->settings.strict) *option++ = "--strict";
    if (work->trust == CHECK_CONFIG_NONE) *option++ = "--no-config";
    if (work->trust == CHECK_CONFIG_ANY) *option++ = "--trust-config";
    if (work->config) *option++ = "--config", *option++ = work->config;
    if (work->files.format)
        *option++ = "--input-format", *option++ = norma_file_format_name(work->files.format);
}

static void write_rule_list(FILE *out, const char *key, const uint8_t *mask) {
    cli_json json = {.out = out, .needs_comma = 1};
    cli_json_open(&json, key, '[');
    for (size_t rule = 0; rule < CHECK_RULES; ++rule)
        if (mask[rule]) cli_json_size(&json, NULL, rule);
    cli_json_close(&json, ']');
}

/* What the findings of a shard depend on, beside its files: shards of other options are not parts
 * of one report. */
static int write_shard_options(check_work *work) {
    const check_settings *settings = &work->settings;
    static const char *const trusts[] = {"own", "none", "any"};
    cli_memory_stream text;
    if (!cli_memory_open(&text)) return cli_out_of_memory();
    cli_json json = {.out = text.out};
    cli_json_print(&json,
        "{version: %s, profile: %s, strict: %d, fail_on: %g, max_samples: %zu, "
        "input_format: %zu, info: %d, fix: %zu, open_by_rays: %d, config: %s, baseline: %d",
        norma_version(), settings->profile ? check_profile_name(settings->profile) : "default",
        settings->strict, (double)settings->fail_on, settings->max_samples,
        (size_t)settings->input_format, settings->list_infos, (size_t)settings->fix,
        settings->open_by_rays, work->config ? "given" : trusts[work->trust],
        work->baseline != NULL);
    if (settings->against)
        cli_json_print(&json, "max_deg: %g, share: %g",
            settings->limits.given & COMPARE_MAX ? cli_given_degrees(settings->limits.max_rad)
                                                 : NAN,
            settings->limits.share);
    if (settings->has_select) write_rule_list(text.out, "select", settings->select);
    write_rule_list(text.out, "ignore", settings->ignore);
    cli_json_close(&json, '}');
    if (!cli_memory_close(&text)) return cli_out_of_memory();
    work->shard_options = text.text;
    work->settings.shard_options = text.text;
    return CLI_OK;
}

static int check_against_words(const cli_subcommand *command, const check_work *work) {
    const check_settings *settings = &work->settings;
    if (!settings->against)
        return settings->limits.given ? cli_usage(command, "--%s needs --against",
                                            settings->limits.given & COMPARE_MAX ? "max" : "share")
                                      : CLI_OK;
    if (settings->limits.given == COMPARE_SHARE) return cli_usage(command, "--share needs --max");
    if (settings->fix) return cli_usage(command, "--against and --fix exclude each other");
    if (work->format != &check_format_text && work->format != &check_format_json)
        return cli_usage(command, "--against needs --format text or json");
    for (size_t i = 0; i < work->files.words.count; ++i)
        if (strcmp(work->files.words.words[i], "-") == 0)
            return cli_usage(command, "standard input has no namesake in --against FOLDER");
    if (!cli_is_folder(settings->against))
        return cli_usage(command, "--against '%s': expected a folder", settings->against);
    return CLI_OK;
}

static int check_words(const cli_subcommand *command, check_work *work) {
    if (work->common.json && work->format && work->format != &check_format_json)
        return cli_usage(command, "--json and --format %s exclude each other", work->format->name);
    if (work->common.json) work->format = &check_format_json;
    if (!work->format && work->files.output && !work->settings.fix)
        work->format = check_format_of_name(work->files.output);
    if (!work->format) work->format = &check_format_text;
    work->settings.pictures = work->format == &check_format_html;
    if (work->settings.page && !work->settings.pictures)
        return cli_usage(command, "--page needs --format html");
    if (work->settings.page && strpbrk(work->settings.page, "?#"))
        return cli_usage(command,
            "--page '%s': expected an address without ? and #, which the links add",
            work->settings.page);
    if (work->config && work->trust == CHECK_CONFIG_NONE)
        return cli_usage(command, "--config and --no-config exclude each other");
    if (work->baseline && work->new_baseline)
        return cli_usage(command, "--baseline and --write-baseline exclude each other");
    if (work->new_baseline && work->files.output &&
        cli_is_same_output(work->new_baseline, work->files.output))
        return cli_usage(
            command, "-o and --write-baseline name the same file, %s", work->new_baseline);
    if (!work->settings.fix &&
        (work->files.folder || work->files.in_place || work->settings.dry_run))
        return cli_usage(command, "--%s needs --fix or --fix-unsafe",
            work->settings.dry_run ? "dry-run"
            : work->files.folder   ? "out-dir"
                                   : "in-place");
    if (work->settings.open_by_rays && work->settings.fix != CHECK_FIX_UNSAFE)
        return cli_usage(command, "--open-by-rays needs --fix-unsafe");
    const int against = check_against_words(command, work);
    if (against) return against;
    work->settings.files = &work->files;
    work->settings.threads = work->common.threads;
    work->settings.quiet = work->common.quiet;
    if (work->common.quiet && work->format == &check_format_text)
        work->format = &check_format_quiet;
    work->settings.input_format = work->files.format;
    choose_command_options(work);
    return work->settings.shards ? write_shard_options(work) : CLI_OK;
}

/* Asked again when all is read, so that neither the report nor the baseline is written if one of
 * the two would overwrite a source. */
static int guard_baseline(const check_work *work) {
    return work->new_baseline ? cli_guard_output(work->files.guard, work->new_baseline, NULL)
                              : CLI_OK;
}

/* The baseline must not replace a file that an input names, which is looked at before any file is
 * fixed. */
static int guard_before_fixing(const check_work *work) {
    const int status = guard_baseline(work);
    if (status || !work->new_baseline || !work->settings.fix) return status;
    cli_guard_look_ahead(work->files.guard, &work->files.inputs, work->files.format);
    return guard_baseline(work);
}

/* A report for a person, on the terminal that shows it. */
static void choose_style(check_work *work, FILE *out) {
    const int is_file = out != stdout && out != stderr;
    work->settings.style = (check_style){
        .color = is_file ? work->color == CLI_COLOR_ALWAYS : cli_wants_color(out, work->color),
        .width = is_file ? 0 : cli_terminal_width(out)};
}

/* found: what was said of the inputs before; a folder that cannot be read has no entry. */
static int check_files(check_work *work, check_configs *configs, int found) {
    cli_output output;
    check_list list = {0};
    check_totals totals = {.list = &list};
    const int streams = work->settings.fix && !work->settings.dry_run && work->files.output &&
                        strcmp(work->files.output, "-") == 0;
    int status = check_configs_read(configs, &work->files.inputs);
    if (!status) status = guard_before_fixing(work);
    if (!status)
        status = cli_output_begin(&output,
            work->files.output && !work->settings.fix ? work->files.output : "-",
            work->files.guard);
    if (status) return status;
    if (streams) /* the mended file has standard output */
        output.out = stderr;
    choose_style(work, output.out);
    if (work->format->begin) work->format->begin(output.out, &work->settings);
    status = check_all_files(&work->settings, configs, work->format, output.out, &totals);
    if (!work->settings.quiet) check_warn_unmatched(configs, &work->files.inputs);
    totals.incomplete |= found != CLI_OK;
    totals.status = status = cli_worse(status, found);
    if (work->exits_job && !totals.unreported && status != CLI_USAGE) status = CLI_OK;
    if (status != CLI_USAGE && guard_baseline(work)) status = CLI_USAGE;
    if (status == CLI_USAGE) {
        /* What has gone to standard output or a pipe must be whole for a program that reads it. */
        if (output.passes_on && work->format != &check_format_text &&
            work->format != &check_format_quiet && work->format->end)
            work->format->end(output.out, &totals, &work->settings);
        check_list_free(&list);
        if (!streams) cli_output_drop(&output);
        return status;
    }
    if (work->format->end) work->format->end(output.out, &totals, &work->settings);
    check_list_free(&list);
    return cli_worse(status, streams ? cli_finish(CLI_OK) : cli_output_end(&output));
}

static int open_baseline(check_work *work) {
    if (work->new_baseline)
        work->settings.baseline = check_baseline_new(work->new_baseline);
    else if (work->baseline)
        work->settings.baseline = check_baseline_read(work->baseline);
    return !(work->new_baseline || work->baseline) || work->settings.baseline;
}

/* Where mended files are to go: of all inputs that words, folders and lists named. */
static int check_fix_places(const cli_subcommand *command, check_work *work) {
    const cli_common common = {.json = 0};
    const char *output = work->files.output;
    if (output && strcmp(output, "-") == 0 && strcmp(work->format->name, "text") != 0)
        return cli_usage(command, "-o - and --format %s would both write to standard output",
            work->format->name);
    return cli_check_outputs(command, &common, &work->files);
}

static int compare_names(const void *a, const void *b) {
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

/* References of which the folder that is checked has no file. */
static int report_lost_files(
    const check_work *work, const cli_inputs *references, const char **names, size_t count) {
    int status = CLI_OK;
    qsort((void *)names, count, sizeof *names, compare_names);
    for (size_t i = 0; i < references->count; ++i) {
        const char *name = references->list[i].path + references->list[i].within;
        if (count && bsearch(&name, (const void *)names, count, sizeof *names, compare_names))
            continue;
        cli_error(
            "%s: has no counterpart in %s", references->list[i].path, work->files.words.words[0]);
        status = CLI_FILE;
    }
    return status;
}

/* inputs: before a shard is taken of them. */
static int find_lost_files(const cli_subcommand *command, const check_work *work) {
    const cli_inputs *inputs = &work->files.inputs;
    cli_files references = {.words = {(const char **)(uintptr_t)&work->settings.against, 1}};
    const char **names = malloc((inputs->count + 1) * sizeof *names);
    if (!names) return cli_out_of_memory();
    for (size_t i = 0; i < inputs->count; ++i)
        names[i] = inputs->list[i].path + inputs->list[i].within;
    int status = cli_find_inputs(command, &references);
    if (work->settings.shards)
        keep_shard(&references.inputs, work->settings.shard, work->settings.shards);
    status = cli_worse(status, report_lost_files(work, &references.inputs, names, inputs->count));
    cli_inputs_free(&references.inputs);
    free((void *)names);
    return status;
}

/* As norma view places the pages of the same words; before a shard is taken of the inputs. */
static int place_pages(const cli_subcommand *command, const check_work *work) {
    cli_files pages = work->files;
    pages.output = NULL;
    pages.folder = work->settings.page;
    return cli_place_outputs(command, &pages, ".html");
}

static int find_inputs(const cli_subcommand *command, check_work *work) {
    int status = cli_find_listed(command, &work->files);
    if (status == CLI_USAGE) return status;
    status = cli_worse(status, cli_find_inputs(command, &work->files));
    work->settings.file_count = work->files.inputs.count;
    if (work->settings.against && work->files.words.count == 1 &&
        cli_is_folder(work->files.words.words[0]))
        status = cli_worse(status, find_lost_files(command, work));
    const int placed = check_page_is_folder(&work->settings) ? place_pages(command, work) : CLI_OK;
    if (placed) return placed;
    if (work->settings.shards)
        keep_shard(&work->files.inputs, work->settings.shard, work->settings.shards);
    cli_inputs *inputs = &work->files.inputs;
    if (inputs->count) qsort(inputs->list, inputs->count, sizeof *inputs->list, cli_compare_inputs);
    return status;
}

static int check_all(const cli_subcommand *command, check_work *work) {
    check_configs *configs = check_configs_new(work->config, work->trust, work->files.guard);
    if (work->baseline) cli_guard_read(work->files.guard, work->baseline);
    int status = !configs              ? cli_out_of_memory()
                 : open_baseline(work) ? find_inputs(command, work)
                                       : CLI_FILE;
    const size_t inputs = work->settings.file_count;
    int placed = CLI_OK;
    if (status != CLI_USAGE && inputs && work->settings.fix && !work->settings.dry_run)
        placed = check_fix_places(command, work);
    if (!placed && configs && status != CLI_USAGE && (!status || inputs))
        status = check_files(work, configs, status);
    status = cli_worse(status, placed);
    if (!placed && work->new_baseline && work->settings.baseline && status != CLI_USAGE)
        status = cli_worse(status == CLI_FINDINGS ? CLI_OK : status,
            check_baseline_write(work->settings.baseline, work->files.guard));
    check_baseline_free(work->settings.baseline);
    check_configs_free(configs);
    return status;
}

static int check_run(const cli_subcommand *command, int count, char **arguments) {
    check_work work = {.settings = {.fail_on = -1}, .common.threads = NORMA_ALL_THREADS};
    const cli_table tables[] = {
        {check_command_options, CLI_COUNT(check_command_options), &work},
        {compare_limit_options, compare_limit_option_count, &work.settings.limits},
        {cli_output_options, cli_output_option_count, &work.files},
        {cli_input_options, cli_input_option_count, &work.files},
        {cli_common_options, cli_common_option_count, &work.common},
    };
    int status = cli_read_files(command, &work.files, tables, CLI_COUNT(tables), count, arguments);
    if (status) return status;
    status = check_words(command, &work);
    if (!status) status = check_all(command, &work);
    free(work.shard_options);
    cli_files_end(&work.files);
    return status;
}

const cli_subcommand cli_subcommand_check = {"check",
    "checks normals, winding, texture seams and transforms, and can fix them", check_help,
    check_run};
