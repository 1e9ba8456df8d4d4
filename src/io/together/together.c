/* together.c: norma_together_compute: twice over all files, and their outputs at the end, all or
 * none. */
#include "io/together/together.h"
#include <stdlib.h>
#include <string.h>

/* ---- The second pass over a file, and all outputs into place. */

typedef struct writing {
    together_run *run;
    member *m;
    surface_normals *surfaces; /* by their numbers */
    size_t count, room;
} writing;

/* ---- normals */

static norma_document_result make_shared_normals(void *user, const document_surface *surface) {
    writing *w = user;
    surface_normals *grown =
        norma_io_grow(w->surfaces, &w->room, surface->number + 1, sizeof *grown);
    if (!grown) return norma_document_fail_memory(w->m->document, w->run->error);
    w->surfaces = grown;
    for (; w->count <= surface->number; ++w->count) w->surfaces[w->count] = (surface_normals){0};
    surface_normals *made = &w->surfaces[surface->number];
    return w->run->creases ? norma_creases_surface(w->run, w->m, surface, made)
                           : norma_together_surface_normals(w->run, w->m, surface, made);
}

static norma_result take_summary(
    void *user, size_t surface, const norma_mesh *mesh, float *normals, uint8_t *reasons) {
    const writing *w = user;
    const size_t count = w->run->creases ? mesh->corner_count : mesh->positions.count;
    if (surface >= w->count || w->surfaces[surface].count != count) return NORMA_ERROR_ARGUMENT;
    const surface_normals *made = &w->surfaces[surface];
    memcpy(normals, made->normals, made->count * 3 * sizeof *normals);
    if (reasons) memcpy(reasons, made->reasons, made->count);
    return NORMA_OK;
}

static int tell_written(void *user, double share) { return norma_together_tell(user, 0.8 * share); }

static norma_document_result compute_member(writing *w) {
    together_run *run = w->run;
    norma_document *document = w->m->document;
    norma_compute_summary summary;
    norma_compute_options options = run->compute;
    const shared_normals shared = {w, take_summary, w->m->locked, run->creases != NULL};
    options.weld = NORMA_WELD_EXACT;
    options.progress = tell_written;
    options.progress_user = run;
    document->shared = &shared;
    const norma_document_result result =
        norma_document_compute(document, &options, &summary, run->error);
    document->shared = NULL;
    summary.report.degenerate_faces.count = run->degenerate[run->number];
    summary.report.degenerate_faces.first = SIZE_MAX;
    if (run->files[run->number].summary) *run->files[run->number].summary = summary;
    return result;
}

/* ---- the output */

static int is_writing_cancelled(void *user, double share) {
    (void)share;
    return norma_together_tell(user, 0.9);
}

static norma_document_result prepare_output(writing *w) {
    together_run *run = w->run;
    const norma_together_file *file = &run->files[run->number];
    const norma_save_options options = {.struct_size = sizeof options,
        .in_place = run->options.in_place,
        .progress = is_writing_cancelled,
        .progress_user = run};
    run->writers.size = 0;
    norma_document_result result = norma_document_check_target(
        w->m->document, file->output, run->options.in_place, run->error);
    if (!result)
        result = norma_document_prepare(
            w->m->document, file->output, &options, &run->writers, run->error);
    if (result) return result;
    if (file->size) *file->size = run->writers.size;
    if (run->options.file_done)
        run->options.file_done(run->options.file_done_user, run->number, w->m->document);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result together_write_file(together_run *run, member *m) {
    writing w = {.run = run, .m = m};
    norma_document_result result = norma_member_visit(m, make_shared_normals, &w, run->error);
    if (!result) result = compute_member(&w);
    if (!result) result = prepare_output(&w);
    for (size_t i = 0; i < w.count; ++i) {
        free(w.surfaces[i].normals);
        free(w.surfaces[i].reasons);
    }
    free(w.surfaces);
    return result;
}

/* ---- into place */

typedef struct output {
    const char *path;
    file_writer *writer;
    size_t number;
} output;

static int compare_outputs(const void *a, const void *b) {
    const output *p = a, *q = b;
    const int order = strcmp(p->path, q->path);
    return order ? order : p->number < q->number ? -1 : p->number > q->number;
}

static void drop_output(together_run *run, size_t number) {
    norma_file_writer_abandon(run->writers.list[number]);
    run->writers.list[number] = NULL;
}

/* Assets of one folder may name one image or one buffer: it is written once where all of them write
 * the same. */
static norma_document_result join_equal_outputs(together_run *run) {
    const size_t count = run->writers.count;
    output *all = norma_io_allocate(count, sizeof *all);
    norma_document_result result =
        all ? NORMA_DOCUMENT_OK : norma_document_fail_memory(NULL, run->error);
    for (size_t i = 0; i < count && !result; ++i)
        all[i] = (output){run->writers.paths[i], run->writers.list[i], i};
    if (!result) qsort(all, count, sizeof *all, compare_outputs);
    for (size_t i = 1, kept = 0; i < count && !result; ++i) {
        const int meet = strcmp(all[kept].path, all[i].path) == 0
                             ? norma_file_writers_meet(all[kept].writer, all[i].writer)
                             : 0;
        if (meet == 0) kept = i;
        if (meet == 1) drop_output(run, all[i].number);
        if (meet == 2) {
            const norma_document named = {.path = run->writers.paths[all[i].number]};
            result = norma_document_fail(&named, run->error, NORMA_DOCUMENT_ERROR_REFUSED, NULL,
                "several outputs would write this file with different bytes; give each a buffer of "
                "its own, for example as GLB");
        }
    }
    free(all);
    return result;
}

static void close_gaps(companion_writers *writers) {
    size_t kept = 0;
    for (size_t i = 0; i < writers->count; ++i) {
        if (!writers->list[i]) {
            free(writers->paths[i]);
            continue;
        }
        writers->list[kept] = writers->list[i];
        writers->paths[kept++] = writers->paths[i];
    }
    writers->count = kept;
}

static norma_document_result together_commit(together_run *run) {
    companion_writers *writers = &run->writers;
    size_t at;
    const norma_document_result result = join_equal_outputs(run);
    if (result) return result;
    close_gaps(writers);
    if (!writers->count) return NORMA_DOCUMENT_OK;
    const int failed = norma_file_writers_commit(writers->list, writers->count, &at);
    for (size_t i = 0; i < writers->count; ++i) writers->list[i] = NULL;
    if (failed)
        return norma_document_fail_file(
            writers->paths[at], run->error, "cannot be written", failed);
    norma_document_free_writers(writers, 0);
    *writers = (companion_writers){0};
    return NORMA_DOCUMENT_OK;
}

/* together.c: a file's normals, and its output, complete but not in place. */
static char *together_folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return !slash          ? norma_io_copy_text(".", 1)
           : slash == path ? norma_io_copy_text("/", 1)
                           : norma_io_copy_text(path, (size_t)(slash - path));
}

/* ---- Norma_together_compute. Once over all files to take down what their faces add at each
 * position; then position by position what follows; then once more over the files, which get it.
 * Nothing of a file is held meanwhile. Outputs are put in place at the end, all or none. */

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
        if (norma_file_format_is_gltf(format)) return 1;
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
    if (!result) result = each_file(run, together_write_file);
    return result ? result : together_commit(run);
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
    result = each_file(run, together_write_file);
    return result ? result : together_commit(run);
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
    if (!run.folder) run.folder = run.own_folder = together_folder_of(files[0].output);
    norma_document_result result =
        run.folder ? join_all(&run) : norma_document_fail_memory(NULL, error);
    end_run(&run);
    return result;
}
