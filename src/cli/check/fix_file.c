/* fix_file.c: a document mended, judged again, and written where it was asked for; a result that is
 * worse than the file was is not written. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/fix_file.h"
#include "cli/files/batch.h"
#include "cli/files/place_outputs.h"
#include "cli/process/errors.h"
#include "cli/text/memory_stream.h"
#include <stdlib.h>
#include <string.h>

enum { MOST_STEPS = 8 };

static int is_standard(const char *output) { return strcmp(output, "-") == 0; }

/* What could not be mended, and why, is a note of the last step. */
static void tell_notes(const char *path, norma_document *document, size_t before) {
    for (size_t i = before; i < norma_document_note_count(document); ++i)
        cli_error("%s: %s", cli_input_name(path), norma_document_note(document, i));
}

/* ---- worse or better */

typedef struct verdict { /* of each rule: elements at warning or above, and the gravest severity */
    size_t counts[CHECK_RULES];
    norma_severity gravest[CHECK_RULES];
} verdict;

static verdict weigh(const norma_findings *findings) {
    verdict sum = {0};
    size_t count;
    for (size_t i = 0; i < norma_findings_count(findings); ++i) {
        const norma_finding *finding = norma_findings_get(findings, i);
        const size_t rule = (size_t)(finding->rule - norma_rules(&count));
        if (finding->severity < NORMA_SEVERITY_WARNING) continue;
        sum.counts[rule] += finding->count;
        if (finding->severity > sum.gravest[rule]) sum.gravest[rule] = finding->severity;
    }
    return sum;
}

/* Rules that report more than before, or graver, with commas. Returns whether there are any: what
 * one rule gains is no excuse for what another loses. */
static int find_worse_rules(const verdict *now, const verdict *before, char text[200]) {
    size_t count, length = 0;
    const norma_rule *rules = norma_rules(&count);
    text[0] = 0;
    for (size_t i = 0; i < count && length < 190; ++i)
        if (now->counts[i] > before->counts[i] || now->gravest[i] > before->gravest[i])
            length += (size_t)snprintf(
                text + length, 200 - length, "%s%s", length ? ", " : "", rules[i].id);
    return length > 0;
}

/* By all rules, whichever were to be mended. */
static norma_document_result judge_all(const check_settings *settings, norma_document *document,
    verdict *sum, norma_document_error *error) {
    const norma_check_options options = {.struct_size = sizeof options,
        .max_samples = 1,
        .threads = settings->threads,
        .progress = settings->progress,
        .progress_user = settings->progress_user};
    norma_findings *findings = NULL;
    norma_document_result result = norma_check_document(document, &options, &findings, error);
    if (!result) *sum = weigh(findings);
    norma_findings_free(findings);
    return result;
}

/* ---- the table */

static size_t count_of(const norma_findings *findings, const norma_rule *rule) {
    size_t sum = 0;
    for (size_t i = 0; i < norma_findings_count(findings); ++i)
        if (norma_findings_get(findings, i)->rule == rule)
            sum += norma_findings_get(findings, i)->count;
    return sum;
}

static char *make_table(const norma_findings *before, const norma_findings *now) {
    size_t count;
    cli_memory_stream table;
    const norma_rule *rules = norma_rules(&count);
    if (!cli_memory_open(&table)) return NULL;
    fprintf(table.out, "    %-32s %10s %10s\n", "rule", "before", "after");
    for (size_t i = 0; i < count; ++i) {
        size_t old = count_of(before, &rules[i]), left = count_of(now, &rules[i]);
        if (old || left)
            fprintf(table.out, "    %s %-27s %10zu %10zu\n", rules[i].id, rules[i].name, old, left);
    }
    (void)cli_memory_close(&table);
    return table.text;
}

/* ---- mending and writing */

/* One fix may uncover what another one mends: until nothing more changes. */
static norma_document_result fix_steps(const check_settings *settings, norma_document *document,
    const norma_check_options *options, const char *path, check_fixed *mended,
    norma_document_error *error) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    mended->document = document;
    mended->last.changed = 1;
    for (int step = 0; step < MOST_STEPS && !result && mended->last.changed; ++step) {
        const size_t notes = norma_document_note_count(document);
        result = norma_fix_document(
            document, options, settings->fix == CHECK_FIX_UNSAFE, &mended->last, error);
        if (!result && !mended->last.changed) tell_notes(path, document, notes);
        mended->changed |= mended->last.changed;
    }
    return result;
}

static norma_document_result save(const check_settings *settings, const char *output,
    check_fixed *mended, norma_document_error *error) {
    if (settings->dry_run || (settings->files->in_place && !mended->changed))
        return NORMA_DOCUMENT_OK;
    const norma_save_options options = {.struct_size = sizeof options,
        .in_place = settings->files->in_place,
        .progress = settings->progress,
        .progress_user = settings->progress_user};
    if (!is_standard(output) && cli_make_folders(settings->files, output))
        return cli_reported(error);
    norma_document_result result =
        is_standard(output) ? cli_write_standard(mended->document, error)
                            : norma_document_save(mended->document, output, &options, error);
    mended->written = !result;
    return result;
}

norma_document_result check_fix(const check_settings *settings, norma_document *document,
    const norma_findings *before, const norma_check_options *options, size_t index,
    check_fixed *mended, norma_document_error *error) {
    const char *path = settings->files->inputs.paths[index];
    verdict was = {0}, is = {0};
    *mended = (check_fixed){0};
    char *output = cli_output_of(settings->files, index, NULL);
    if (!output) {
        *error = (norma_document_error){NORMA_DOCUMENT_ERROR_MEMORY, "out of memory"};
        return error->result;
    }
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (!settings->dry_run &&
        cli_guard_output(settings->files->guard, output, settings->files->in_place ? path : NULL)) {
        *error = (norma_document_error){.result = NORMA_DOCUMENT_ERROR_ARGUMENT}; /* reported */
        result = error->result;
    }
    if (!result) result = judge_all(settings, document, &was, error);
    if (!result) result = fix_steps(settings, document, options, path, mended, error);
    if (!result && mended->changed)
        result = norma_check_document(mended->document, options, &mended->findings, error);
    if (!result && mended->changed) result = judge_all(settings, mended->document, &is, error);
    mended->worse = !result && mended->changed && find_worse_rules(&is, &was, mended->worse_by);
    if (!result && mended->changed && !(mended->table = make_table(before, mended->findings))) {
        *error = (norma_document_error){NORMA_DOCUMENT_ERROR_MEMORY, "out of memory"};
        result = error->result;
    }
    if (!result && !mended->worse) result = save(settings, output, mended, error);
    free(output);
    return result;
}

void check_fixed_free(check_fixed *mended) {
    norma_findings_free(mended->findings);
    free(mended->table);
    *mended = (check_fixed){0};
}
