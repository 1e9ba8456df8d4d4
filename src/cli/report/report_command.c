/* report_command.c: norma report --merge: the reports of norma check on parts of a set of files,
 * put together as the report on the whole set. What each report is, its content says. */
#include "cli/report/merge.h"
#include "cli/files/report_output.h"
#include "cli/process/errors.h"
#include <stdlib.h>
#include <string.h>

static const char help[] =
    "norma report --merge REPORT... -o OUT: puts reports of norma check together\n"
    "\n"
    "Examples\n"
    "  norma check models/ --shard 1/2 -o 1.json       on one machine\n"
    "  norma check models/ --shard 2/2 -o 2.json       on another\n"
    "  norma report --merge 1.json 2.json -o all.json\n"
    "  norma report --merge 1.json 2.json -o all.html  a page, without pictures\n"
    "  norma report --merge *.sarif -o all.sarif\n"
    "\n"
    "REPORT is what norma check wrote as JSON, or as SARIF: all of one kind.\n"
    "  --format text|line|json|sarif|html\n"
    "                        what JSON becomes: as the ending of -o says, else JSON; SARIF stays\n"
    "                        SARIF\n"
    "  -o, --output FILE     where the report goes (standard output)\n"
    "  --info                lists informations too, in text and line\n"
    "Files are sorted by path.\n"
    "Exit status: the one that norma check would have had for all files together; 2 usage, 3 a\n"
    "report could not be read or written.\n";

typedef struct report_work {
    int merge;
    const char *output;
    const check_format *format; /* NULL: as the output is called */
    report_merge merged;
} report_work;

static const char *set_merge(void *settings, const char *value) {
    (void)value;
    ((report_work *)settings)->merge = 1;
    return NULL;
}

static const char *set_output(void *settings, const char *value) {
    ((report_work *)settings)->output = value;
    return value[0] ? NULL : "the name of a file, or -";
}

static const char *set_format(void *settings, const char *value) {
    ((report_work *)settings)->format = check_find_format(value);
    return ((report_work *)settings)->format ? NULL : CHECK_FORMAT_NAMES;
}

static const char *set_info(void *settings, const char *value) {
    (void)value;
    ((report_work *)settings)->merged.settings.list_infos = 1;
    return NULL;
}

static const cli_option options[] = {
    {"merge", 0, 0, set_merge},
    {"output", 'o', 1, set_output},
    {"format", 0, 1, set_format},
    {"info", 0, 0, set_info},
};

/* ---- reading */

static int read_reports(report_merge *merged, const cli_words *words, cli_guard *guard) {
    int status = CLI_OK;
    merged->reports = calloc(words->count, sizeof(json_t *));
    if (!merged->reports) return cli_out_of_memory();
    for (size_t i = 0; i < words->count && !status; ++i) {
        cli_guard_read(guard, words->words[i]);
        json_t *report = check_load_json(words->words[i], "a report as norma check writes it");
        status = report ? report_add(merged, words->words[i], report) : CLI_FILE;
    }
    return status;
}

/* ---- writing */

static int choose_format(const cli_subcommand *verb, report_work *work) {
    const report_kind kind = work->merged.kind;
    const check_format *own = kind == REPORT_SARIF ? &check_format_sarif : &check_format_json;
    if (!work->format) work->format = check_format_of_name(work->output);
    if (!work->format) work->format = own;
    return kind == REPORT_SARIF && work->format != own
               ? cli_usage(verb, "reports in SARIF stay SARIF; expected JSON for --format %s",
                     work->format->name)
               : CLI_OK;
}

static int write_merged(const report_work *work, cli_guard *guard) {
    cli_output output;
    check_totals totals = {0};
    const int status = cli_output_begin(&output, work->output, guard);
    if (status) return status;
    if (work->merged.kind == REPORT_SARIF)
        report_write_sarif(&work->merged, output.out);
    else if (work->format == &check_format_json)
        report_write_json(&work->merged, output.out, &totals);
    else
        report_write_as(&work->merged, work->format, output.out, &totals);
    return cli_worse(cli_worse(work->merged.status, totals.status), cli_output_end(&output));
}

static int merge(const cli_subcommand *verb, report_work *work, const cli_words *words) {
    if (!work->merge) return cli_usage(verb, "nothing to do was given; expected --merge");
    if (!words->count) return cli_usage(verb, "no report was given");
    cli_guard *guard = cli_guard_new(verb);
    if (!guard) return CLI_FILE;
    cli_files files = {.inputs.count = 0};
    int status = read_reports(&work->merged, words, guard);
    if (!status) status = choose_format(verb, work);
    if (!status) {
        files.inputs.count = work->merged.part_count;
        work->merged.settings.files = &files;
        report_sort(&work->merged);
        status = write_merged(work, guard);
    }
    cli_guard_free(guard);
    return status;
}

static int run(const cli_subcommand *verb, int count, char **arguments) {
    report_work work = {.output = "-"};
    cli_words words = {.words = calloc((size_t)count + 1, sizeof(char *))};
    const cli_table tables[] = {{options, CLI_COUNT(options), &work}};
    int wants_help = 0;
    int status = words.words ? cli_parse(verb, tables, CLI_COUNT(tables), count, arguments, &words,
                                   &wants_help)
                             : cli_out_of_memory();
    if (wants_help) {
        fputs(verb->help, stdout);
        status = cli_finish(status);
    } else if (!status)
        status = merge(verb, &work, &words);
    report_merge_free(&work.merged);
    free(words.words);
    return status;
}

const cli_subcommand cli_subcommand_report = {
    "report", "puts reports of norma check on parts of a set of files together", help, run};
