/* write_file.c: the second pass over a file, and all outputs into place. */
#include "io/together/creases.h"
#include <stdlib.h>
#include <string.h>

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

norma_document_result norma_together_write_file(together_run *run, member *m) {
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

norma_document_result norma_together_commit(together_run *run) {
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

char *norma_together_folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return !slash          ? norma_io_copy_text(".", 1)
           : slash == path ? norma_io_copy_text("/", 1)
                           : norma_io_copy_text(path, (size_t)(slash - path));
}
