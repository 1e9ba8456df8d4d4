/* together.c: norma_together_compute. Once over all files to take down what their faces add at each
 * position; then position by position what follows; then once more over the files, which get it.
 * Nothing of a file is held meanwhile. Outputs are put in place at the end, all or none. */
#include "io/together/creases.h"
#include <stdlib.h>
#include <string.h>

static const uint64_t JOINING_MEMORY = (uint64_t)1 << 29;

/* ---- options */

static norma_document_result fail_option(norma_document_error *error, const char *what) {
    return norma_document_fail(NULL, error, NORMA_DOCUMENT_ERROR_ARGUMENT, NULL, "%s", what);
}

static const char *bad_choice(const norma_compute_options *o) {
    if (o->shading == NORMA_SHADING_FLAT)
        return "flat normals cannot be shared; compute each file by itself";
    if (o->weld == NORMA_WELD_NONE)
        return "without welding nothing is shared; expected exact or a distance";
    if (o->weight == NORMA_WEIGHT_VISIBLE)
        return "the weight visible is not summed over faces and cannot be shared between files; "
               "expected another weight";
    if (o->only != NORMA_ONLY_ALL)
        return "all normals of a joined surface are computed; lock those that should stay";
    return NULL;
}

static const char *bad_crease(const together_run *run) {
    return run->compute.shading == NORMA_SHADING_CREASE &&
                   (run->options.levels || run->options.lock_count)
               ? "levels of detail and locked normals need smooth normals; expected no crease"
               : NULL;
}

static const char *bad_file(const norma_together_file *files, size_t count) {
    if (count && !files) return "no files were given";
    for (size_t i = 0; i < count; ++i)
        if (!files[i].input || !files[i].output) return "a file has no path";
    return NULL;
}

static int rounds(const norma_together_file *files, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const norma_file_format format =
            files[i].format ? files[i].format : norma_file_format_of_path(files[i].input);
        if (format >= NORMA_FILE_GLTF) return 1;
    }
    return 0;
}

/* ---- the run */

static norma_document_result each_file(
    together_run *run, norma_document_result (*visit)(together_run *run, member *m)) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (run->number = 0; run->number < run->count && !result; ++run->number) {
        member m;
        result =
            norma_member_open(&run->files[run->number], run->number, &run->options, &m, run->error);
        if (!result) result = visit(run, &m);
        norma_member_close(&m);
        if (!result && norma_together_tell(run, 1))
            result =
                norma_document_fail(NULL, run->error, NORMA_DOCUMENT_CANCELLED, NULL, "cancelled");
    }
    run->passes_done += 1;
    run->options.lock_matches = NULL; /* the first time over all files counts */
    return result;
}

static norma_document_result join_near(together_run *run) {
    if (run->compute.weld != NORMA_WELD_DISTANCE) return NORMA_DOCUMENT_OK;
    run->near = norma_near_begin();
    if (!run->near) return norma_document_fail_memory(NULL, run->error);
    norma_document_result result = each_file(run, norma_together_take_positions);
    if (result) return result;
    const norma_result joined =
        norma_near_end(run->near, run->compute.weld_distance, run->compute.threads);
    run->equal.near = run->near;
    return joined ? norma_document_fail_memory(NULL, run->error) : NORMA_DOCUMENT_OK;
}

static norma_document_result run_creased(together_run *run) {
    run->degenerate = norma_io_allocate(run->count, sizeof *run->degenerate);
    if (!run->degenerate) return norma_document_fail_memory(NULL, run->error);
    norma_document_result result = each_file(run, norma_creases_take);
    if (!result) result = norma_creases_compute(run);
    if (!result) result = each_file(run, norma_together_write_file);
    return result ? result : norma_together_commit(run);
}

static norma_document_result join_all(together_run *run) {
    if (run->compute.shading == NORMA_SHADING_CREASE) return run_creased(run);
    run->votes = norma_spill_open(run->folder, sizeof(position_votes));
    run->normals = norma_spill_open(run->folder, sizeof(position_normal));
    run->degenerate = norma_io_allocate(run->count, sizeof *run->degenerate);
    if (!run->votes || !run->normals || !run->degenerate)
        return norma_document_fail_memory(NULL, run->error);
    norma_document_result result = join_near(run);
    if (!result) result = each_file(run, norma_together_take_votes);
    if (result) return result;
    const int failed = norma_together_join(run->votes, run->normals, run->options.max_memory / 4);
    if (failed) return norma_together_fail_spill(run, failed);
    norma_spill_close(run->votes);
    run->votes = NULL;
    norma_spill_rewind(run->normals);
    result = each_file(run, norma_together_write_file);
    return result ? result : norma_together_commit(run);
}

static void end_run(together_run *run) {
    norma_spill_close(run->votes);
    norma_spill_close(run->normals);
    norma_near_free(run->near);
    norma_creases_free(run->creases);
    norma_document_free_writers(&run->writers, 1);
    free(run->degenerate);
    free(run->own_folder);
}

norma_document_result norma_together_compute(const norma_together_file *files, size_t count,
    const norma_together_options *options, const norma_compute_options *compute,
    norma_document_error *error) {
    together_run run = {.files = files, .count = count, .error = error, .writers = {.outlive = 1}};
    norma_document_clear(error);
    norma_document_copy_options(
        &run.options, sizeof run.options, offsetof(norma_together_options, lock_matches), options);
    norma_document_copy_options(
        &run.compute, sizeof run.compute, offsetof(norma_compute_options, tangents), compute);
    const char *bad = bad_file(files, count);
    if (!bad) bad = norma_document_bad_compute_option(&run.compute);
    if (!bad) bad = bad_choice(&run.compute);
    if (!bad) bad = bad_crease(&run);
    if (bad) return fail_option(error, bad);
    for (size_t i = 0; run.options.lock_matches && i < run.options.lock_count; ++i)
        run.options.lock_matches[i] = 0;
    if (!count) return NORMA_DOCUMENT_OK;
    if (!run.options.max_memory) run.options.max_memory = JOINING_MEMORY;
    if (run.compute.shading == NORMA_SHADING_DEFAULT) run.compute.shading = NORMA_SHADING_SMOOTH;
    run.equal.rounded = rounds(files, count);
    const int creased = run.compute.shading == NORMA_SHADING_CREASE;
    run.passes = run.compute.weld == NORMA_WELD_DISTANCE && !creased ? 3 : 2;
    run.folder = run.options.temporary_folder;
    if (!run.folder) run.folder = run.own_folder = norma_together_folder_of(files[0].output);
    norma_document_result result =
        run.folder ? join_all(&run) : norma_document_fail_memory(NULL, error);
    end_run(&run);
    return result;
}
