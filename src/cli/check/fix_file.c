/* fix_file.c: a document mended, judged again, and written where it was asked for. */
#define _POSIX_C_SOURCE 200809L
#include "cli/check/fix_file.h"
#include "cli/files/batch.h"
#include "cli/files/place_outputs.h"
#include "cli/process/errors.h"
#include "cli/process/progress.h"
#include "cli/text/memory_stream.h"
#include <stdlib.h>
#include <string.h>

static int is_standard(const char *output) { return strcmp(output, "-") == 0; }

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

/* What could not be mended, and why: each reason once. */
static void tell_notes(const char *path, const norma_document *document, size_t before) {
    for (size_t i = before; i < norma_document_note_count(document); ++i)
        if (check_is_new_note(document, before, i))
            cli_error("%s: %s", cli_input_name(path), norma_document_note(document, i));
}

static norma_document_result save(const check_settings *settings, const char *output,
    check_fixed *mended, norma_document_error *error) {
    /* A copy without a change is written only where it was named. */
    if (settings->dry_run || (!settings->files->output && !mended->summary.changed))
        return NORMA_DOCUMENT_OK;
    const norma_save_options options = {.struct_size = sizeof options,
        .in_place = settings->files->in_place,
        .progress = settings->progress,
        .progress_user = settings->progress_user};
    if (!is_standard(output) && cli_make_folders(settings->files, output))
        return cli_reported(error);
    norma_document_result result;
    if (is_standard(output)) {
        result = cli_write_standard(mended->document, error);
    } else {
        cli_writing_begin();
        result = norma_document_save(mended->document, output, &options, error);
        cli_writing_end();
    }
    mended->written = !result;
    return result;
}

norma_document_result check_fix(const check_settings *settings, norma_document *document,
    const norma_findings *before, const norma_check_options *options, size_t index,
    check_fixed *mended, norma_document_error *error) {
    const char *path = settings->files->inputs.paths[index];
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
    mended->document = document;
    const size_t notes = norma_document_note_count(document);
    mended->first_note = notes;
    if (!result)
        result = norma_fix_document(
            document, options, settings->fix == CHECK_FIX_UNSAFE, &mended->summary, error);
    if (!result) tell_notes(path, document, notes);
    if (!result && mended->summary.changed)
        result = norma_check_document(document, options, &mended->findings, error);
    if (!result && mended->summary.changed &&
        !(mended->table = make_table(before, mended->findings))) {
        *error = (norma_document_error){NORMA_DOCUMENT_ERROR_MEMORY, "out of memory"};
        result = error->result;
    }
    if (!result) result = save(settings, output, mended, error);
    free(output);
    return result;
}

void check_fixed_free(check_fixed *mended) {
    norma_findings_free(mended->findings);
    free(mended->table);
    *mended = (check_fixed){0};
}
