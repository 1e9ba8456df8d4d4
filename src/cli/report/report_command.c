/* report_command.c: norma report --merge: the reports of norma check on parts of a set of files,
 * put together as the report on the whole set. What each report is, its content says. */
#include "cli/report/merge.h"
#include "cli/files/report_output.h"
#include "cli/process/errors.h"
#include <stdlib.h>
#include <string.h>

static const char help[] =
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
    int merge, partial;
    char *missing;
    const char *output;
    const check_format *format; /* NULL: as the output is called */
    report_merge merged;
} report_work;

static const char *set_merge(void *settings, const char *value) {
    (void)value;
    ((report_work *)settings)->merge = 1;
    return NULL;
}

static const char *set_partial(void *settings, const char *value) {
    (void)value;
    ((report_work *)settings)->partial = 1;
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
    {"partial", 0, 0, set_partial},
    {"output", 'o', 1, set_output},
    {"format", 0, 1, set_format},
    {"info", 0, 0, set_info},
};

/* ---- reading */

/* By its content: a page, or JSON. Notes its parts. */
static int read_report(report_merge *merged, size_t report) {
    report_text *text = malloc(sizeof *text);
    if (!text) return cli_out_of_memory();
    report_text_begin(text, &merged->files, report);
    const int status =
        report_is_html(text) ? report_add_html(merged, text) : report_add_json(merged, text);
    free(text);
    return status;
}

static const char *kind_name(report_kind kind) {
    return kind == REPORT_HTML ? "HTML" : kind == REPORT_SARIF ? "SARIF" : "JSON";
}

static int read_reports(report_merge *merged, const cli_words *words, cli_guard *guard) {
    int status = CLI_OK;
    if (!status) status = report_merge_begin(merged, words->words, words->count);
    for (size_t i = 0; i < words->count && !status; ++i) {
        const report_kind before = merged->kind;
        cli_guard_read(guard, words->words[i]);
        status = read_report(merged, i);
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
        status = report_copy_part(merged, &merged->parts[i], NULL);
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

static int write_merged(report_work *work, cli_guard *guard) {
    cli_output output;
    check_totals totals = {0};
    int status = cli_output_begin(&output, work->output, guard);
    if (status) return status;
    if (output.passes_on) status = look_again(&work->merged);
    if (!status) status = write_parts(work, output.out, &totals);
    if (status) {
        cli_output_drop(&output);
        return status;
    }
    return cli_worse(cli_worse(work->merged.status, totals.status), cli_output_end(&output));
}

static int merge(const cli_subcommand *command, report_work *work, const cli_words *words) {
    if (!work->merge) return cli_usage(command, "nothing to do was given; expected --merge");
    if (!words->count) return cli_usage(command, "no report was given");
    cli_guard *guard = cli_guard_new(command);
    if (!guard) return CLI_FILE;
    if (!work->format) work->format = check_format_of_name(work->output);
    work->merged.changes_form = work->format && work->format != &check_format_json;
    int status = read_reports(&work->merged, words, guard);
    if (!status)
        status = report_check_shards(&work->merged, words->count, work->partial, &work->missing);
    work->merged.settings.missing = work->missing;
    if (!status) status = choose_format(command, work);
    if (!status) {
        work->merged.settings.file_count = work->merged.part_count;
        report_sort(&work->merged);
        status = write_merged(work, guard);
    }
    cli_guard_free(guard);
    return status;
}

static int run(const cli_subcommand *command, int count, char **arguments) {
    report_work work = {.output = "-"};
    cli_words words = {.words = calloc((size_t)count + 1, sizeof(char *))};
    const cli_table tables[] = {{options, CLI_COUNT(options), &work}};
    int wants_help = 0;
    int status = words.words ? cli_parse(command, tables, CLI_COUNT(tables), count, arguments,
                                   &words, &wants_help)
                             : cli_out_of_memory();
    if (wants_help) {
        fputs(command->help, stdout);
        status = cli_finish(status);
    } else if (!status)
        status = merge(command, &work, &words);
    report_merge_free(&work.merged);
    free(work.missing);
    free(words.words);
    return status;
}

const cli_subcommand cli_subcommand_report = {
    "report", "joins reports of norma check into one", help, run};
