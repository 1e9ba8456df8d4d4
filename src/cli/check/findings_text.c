/* findings_text.c: findings for people: what, where, how bad, why it matters, what to do; the
 * verdict last. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/check_command.h"
#include "cli/process/errors.h"
#include "cli/text/memory_stream.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { COLUMNS = 110, INDENT = 4 };

/* Words with line breaks before COLUMNS, an indent after each. */
static void write_wrapped(FILE *out, const char *text) {
    size_t column = 0;
    while (*text) {
        size_t blanks = strspn(text, " "), length = strcspn(text + blanks, " ");
        if (column && column + blanks + length > COLUMNS) {
            fprintf(out, "\n%*s", INDENT, "");
            column = INDENT;
            blanks = 0;
            text += strspn(text, " ");
        }
        fwrite(text, 1, blanks + length, out);
        column += blanks + length;
        text += blanks + length;
    }
    fputc('\n', out);
}

static void write_place(FILE *out, const norma_sample *sample) {
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

static void write_fix(FILE *out, const check_item *item) {
    if (item->offered == NORMA_FIX_SAFE)
        fputs(" Fix: --fix", out);
    else if (item->offered == NORMA_FIX_UNSAFE)
        fprintf(out, " Fix: norma check --fix-unsafe --select %s", item->finding->rule->id);
}

static void write_line(FILE *line, const char *path, const check_item *item) {
    const norma_finding *finding = item->finding;
    cli_say(line, "%s: %s %s %s: ", path, check_severity_name(item->severity), finding->rule->id,
        finding->rule->name);
    if (finding->label[0]) cli_say(line, "%s: ", finding->label);
    cli_write_outside(line, finding->message);
    size_t length = strlen(finding->message);
    if (length && !strchr(".!?", finding->message[length - 1])) fputc('.', line);
    int placed = finding->worst.vertex != SIZE_MAX || finding->worst.face != SIZE_MAX ||
                 finding->worst.has_position;
    if (placed) {
        fputs(" worst: ", line);
        write_place(line, &finding->worst);
        fputc('.', line);
    }
    write_fix(line, item);
}

/* Without memory to wrap it, a line is as long as it is. */
static void write_item(FILE *out, const char *path, const check_item *item) {
    cli_memory_stream line;
    if (cli_memory_open(&line)) write_line(line.out, path, item);
    if (cli_memory_close(&line)) {
        write_wrapped(out, line.text);
    } else {
        write_line(out, path, item);
        fputc('\n', out);
    }
    free(line.text);
}

static void begin(FILE *out) { (void)out; }

static void write_file(FILE *out, const check_report *report) {
    if (report->mended) {
        cli_say(out, "%s: fixed", cli_input_name(report->path));
        fprintf(out, "\n%s", report->mended);
    }
    if (report->by_rays) {
        cli_say(out, "%s: %zu open %s outward by a majority of rays, confidence at least %.2f",
            cli_input_name(report->path), report->by_rays,
            report->by_rays == 1 ? "component looks" : "components look",
            floor(100 * report->least_confidence) / 100);
        fputc('\n', out);
    }
    if (report->undecided) {
        cli_say(out, "%s: %zu open %s left as %s, rays do not agree", cli_input_name(report->path),
            report->undecided, report->undecided == 1 ? "component is" : "components are",
            report->undecided == 1 ? "it is" : "they are");
        fputc('\n', out);
    }
    for (size_t i = 0; i < report->count; ++i)
        write_item(out, cli_input_name(report->path), &report->items[i]);
}

static void end(FILE *out, const check_totals *totals) {
    fprintf(out, "%zu %s, %zu %s in %zu of %zu %s", totals->errors,
        totals->errors == 1 ? "error" : "errors", totals->warnings,
        totals->warnings == 1 ? "warning" : "warnings", totals->files_with_trouble, totals->files,
        totals->files == 1 ? "file" : "files");
    if (totals->not_checked) fprintf(out, "; %zu not checked", totals->not_checked);
    if (totals->known) fprintf(out, "; %zu known to the baseline", totals->known);
    fputc('\n', out);
}

static void write_nothing(FILE *out, const check_report *report) {
    (void)out;
    (void)report;
}

const check_format check_format_text = {"text", begin, write_file, "", end};
const check_format check_format_quiet = {
    "text", begin, write_nothing, "", end}; /* the verdict alone */
