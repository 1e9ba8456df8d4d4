/* edits.c: changes that wait beside the bytes that were read, and what a matrix or a move makes of
 * positions and stored normals. */
#include "io/format/format.h"
#include "core/call/call.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Files whose changes wait beside the bytes that were read: opened, written,
 * compared, and turned into bytes of the document's own. */

norma_document_result norma_edited_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    norma_document_result result = NORMA_DOCUMENT_OK;
    norma_sink *sink = norma_sink_create(write, user);
    (void)path;
    if (!sink) return norma_document_fail_memory(document, error);
    if (format->has_edit(document->state))
        result = format->write_changed(document, sink, error);
    else
        norma_sink_put(sink, document->source.data, document->source.size);
    int failed = norma_sink_finish(sink);
    if (!result && failed)
        return norma_document_fail(
            document, error, NORMA_DOCUMENT_ERROR_FILE, NULL, "the output could not be written");
    return result;
}

norma_document_result norma_edited_drop_idle(
    norma_document *document, int *changed, norma_document_error *error) {
    norma_compare_sink same = {document->source.data, document->source.size};
    norma_document_result result =
        document->functions->write(document, NULL, norma_compare_sink_write, &same, NULL);
    *changed = result == NORMA_DOCUMENT_ERROR_FILE || same.left > 0;
    if (!*changed) document->functions->edited->forget_edit(document->state);
    return result == NORMA_DOCUMENT_ERROR_MEMORY ? norma_document_fail_memory(document, error)
                                                 : NORMA_DOCUMENT_OK;
}

/* ---- opening, closing, and changes that become bytes */

norma_document_result norma_edited_open(norma_document *document, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    document->state = norma_io_allocate(1, format->state_size);
    return document->state ? format->read(document, error)
                           : norma_document_fail_memory(document, error);
}

void norma_edited_close(norma_document *document) {
    if (!document->state) return;
    document->functions->edited->free_content(document->state);
    free(document->state);
    document->state = NULL;
}

size_t norma_edited_mesh_count(const norma_document *document) {
    (void)document;
    return 1;
}

/* Reading our own bytes finds nothing new, so notes about them are removed. */
static norma_document_result read_again(norma_document *document, norma_document_error *error) {
    const edited_format *format = document->functions->edited;
    const size_t notes = document->note_count;
    format->free_content(document->state);
    memset(document->state, 0, format->state_size);
    norma_document_result result = format->read(document, error);
    norma_scene_forget(document->scene);
    while (document->note_count > notes) free(document->notes[--document->note_count]);
    return result;
}

norma_document_result norma_edited_replace(
    norma_document *document, const growing_bytes *bytes, norma_document_error *error) {
    norma_file_close(&document->source);
    document->source =
        (file_bytes){.data = (const void *)bytes->data, .size = bytes->size, .owned = 1};
    norma_document_result result = read_again(document, error);
    document->failed |= result != NORMA_DOCUMENT_OK;
    return result;
}

void norma_edited_begin(norma_document *document) {
    document->had_edit = document->functions->edited->has_edit(document->state);
}

int norma_edited_drop(norma_document *document, norma_document_result why) {
    const edited_format *format = document->functions->edited;
    if (why == NORMA_DOCUMENT_ERROR_ARGUMENT &&
        !format->has_edit(document->state) == !document->had_edit)
        return 1; /* refused before anything was done */
    /* What came before is in the bytes only if the change could begin with flushing it. */
    if (document->had_edit && (format->gathers || why == NORMA_DOCUMENT_ERROR_MEMORY)) return 0;
    return read_again(document, NULL) == NORMA_DOCUMENT_OK;
}

unsigned char *norma_edited_own_bytes(norma_document *document) {
    file_bytes *source = &document->source;
    if (!source->owned || source->mapped) {
        unsigned char *copy = malloc(source->size ? source->size : 1);
        if (!copy) return NULL;
        if (source->size) memcpy(copy, source->data, source->size);
        const file_bytes own = {.data = copy, .size = source->size, .owned = 1};
        norma_file_close(source);
        *source = own;
    }
    return (unsigned char *)(uintptr_t)source->data;
}

static norma_document_result flush_all(norma_document *document, norma_document_error *error) {
    growing_bytes memory = {0};
    norma_document_result result =
        document->functions->write(document, NULL, norma_memory_sink_write, &memory, error);
    if (!result) return norma_edited_replace(document, &memory, error);
    free(memory.data);
    return result == NORMA_DOCUMENT_ERROR_FILE ? norma_document_fail_memory(document, error)
                                               : result;
}

/* A change that is cancelled takes nothing of the changes before it away, so these are written to
 * their end. */
norma_document_result norma_edited_flush(norma_document *document, norma_document_error *error) {
    if (!document->functions->edited->has_edit(document->state)) return NORMA_DOCUMENT_OK;
    norma_progress *const progress = document->watch.progress;
    document->watch.progress = NULL;
    const norma_document_result result = flush_all(document, error);
    document->watch.progress = progress;
    return result;
}

size_t norma_edit_kept(const norma_mesh_edit *edit) {
    size_t kept = edit->vertex_count > 0;
    while (
        kept < edit->vertex_count && edit->source_vertices[kept] > edit->source_vertices[kept - 1])
        ++kept;
    return kept;
}

/* ---- The step that brings the middle of a box to the origin, or nearly: a multiple of a
 * power of two not below the box's size, so that it has few bits. Where the box lies eight times
 * its size away, step and positions are within a factor of two of one another, and their difference
 * is exact (Sterbenz 1974). */

static const double FAR = 8;

recentre_box norma_recentre_empty(void) {
    return (recentre_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}

void norma_recentre_add(recentre_box *box, const double position[3]) {
    if (!isfinite(position[0]) || !isfinite(position[1]) || !isfinite(position[2])) return;
    for (int axis = 0; axis < 3; ++axis) {
        box->low[axis] = fmin(box->low[axis], position[axis]);
        box->high[axis] = fmax(box->high[axis], position[axis]);
    }
}

int norma_recentre_step(const recentre_box *box, double step[3]) {
    double size = 0;
    int any = 0, exponent;
    for (int axis = 0; axis < 3; ++axis) size = fmax(size, box->high[axis] - box->low[axis]);
    for (int axis = 0; axis < 3; ++axis) {
        const double middle = box->low[axis] / 2 + box->high[axis] / 2;
        step[axis] = 0;
        if (!(box->low[axis] <= box->high[axis]) || !(fabs(middle) > FAR * size) || !isfinite(size))
            continue;
        frexp(size, &exponent);
        const double unit = ldexp(1, size > 0 ? exponent : 0),
                     rounded = size > 0 ? unit * round(middle / unit) : middle;
        step[axis] = (double)(float)rounded;
        any |= step[axis] != 0;
    }
    return any;
}

/* ---- Matrices of 4 x 4, column by column. */

int norma_matrix_is_identity(const double m[16]) {
    for (int i = 0; i < 16; ++i)
        if (m[i] != (i % 5 == 0 ? 1.0 : 0.0)) return 0;
    return 1;
}

void norma_matrix_multiply(const double a[16], const double b[16], double product[16]) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) {
            double sum = 0;
            for (int k = 0; k < 4; ++k) sum += a[4 * k + row] * b[4 * column + k];
            product[4 * column + row] = sum;
        }
}

double norma_matrix_determinant(const double m[16]) {
    return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) +
           m[8] * (m[1] * m[6] - m[5] * m[2]);
}

/* ---- Stored normals under the matrix of a whole document: cof(M) with the
 * sign of its determinant, since faces are reversed under a mirror. */

norma_document_result norma_stored_normals_progress(const norma_document *document,
    const norma_transform_options *options, double fraction, norma_document_error *error) {
    if (options->progress && options->progress(options->progress_user, fraction))
        return norma_document_fail_cancelled(document, error);
    return NORMA_DOCUMENT_OK;
}

static norma_document_result prepare_map(const norma_document *document, const double model[16],
    normal_mapping *mapping, norma_document_error *error) {
    double exact[9], greatest = 0, squares[3] = {0};
    norma_matrix_info info;
    norma_result failed = norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, exact, &info);
    if (failed) return norma_document_fail_core(document, error, failed);
    for (size_t i = 0; i < 9; ++i) greatest = fabs(exact[i]) > greatest ? fabs(exact[i]) : greatest;
    /* Near 1, so that no entry that matters is lost when it becomes a float. */
    for (size_t i = 0; i < 9; ++i) {
        exact[i] = greatest > 0 ? exact[i] / greatest : 0;
        mapping->matrix[i] = (float)exact[i];
        squares[i / 3] += exact[i] * exact[i];
    }
    size_t longest = 0;
    for (size_t column = 1; column < 3; ++column)
        longest = squares[column] > squares[longest] ? column : longest;
    for (size_t axis = 0; axis < 3; ++axis)
        mapping->flat[axis] =
            greatest > 0 ? exact[3 * longest + axis] / sqrt(squares[longest]) : axis == 2;
    mapping->mirrored = info.mirrored;
    return NORMA_DOCUMENT_OK;
}

norma_document_result norma_stored_normals_begin(const norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    normal_mapping *mapping, norma_document_error *error) {
    norma_document_result result = prepare_map(document, options->matrix, mapping, error);
    if (result) return result;
    summary->mirrored = mapping->mirrored;
    return norma_stored_normals_progress(document, options, 0, error);
}

norma_document_result norma_check_transformed_range(const norma_document *document,
    const norma_vec3_view *before, const double *after, double most, const char *what,
    size_t positions_each, norma_document_error *error) {
    for (size_t i = 0; i < before->count; ++i) {
        double old[3];
        const double *p = after + 3 * i;
        if (fabs(p[0]) <= most && fabs(p[1]) <= most && fabs(p[2]) <= most) continue;
        norma_view_read(before, i, old);
        if (!isfinite(old[0]) || !isfinite(old[1]) || !isfinite(old[2])) continue;
        for (size_t axis = 0; axis < 3; ++axis) {
            char place[40];
            if (fabs(p[axis]) <= most) continue;
            snprintf(place, sizeof place, "%s %zu", what, i / positions_each);
            return norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, place,
                "the matrix moves it beyond %.3g, the largest number that the file can hold", most);
        }
    }
    return NORMA_DOCUMENT_OK;
}

static void fill_lost(const normal_mapping *mapping, const double *before, float *after,
    size_t count, size_t *vanished, size_t *not_finite) {
    for (size_t i = 0; i < count; ++i, before += 3, after += 3) {
        if (after[0] != 0 || after[1] != 0 || after[2] != 0) continue;
        if (!isfinite(before[0]) || !isfinite(before[1]) || !isfinite(before[2])) {
            ++*not_finite;
        } else if (before[0] != 0 || before[1] != 0 || before[2] != 0) {
            ++*vanished;
            for (int axis = 0; axis < 3; ++axis) after[axis] = (float)mapping->flat[axis];
        }
    }
}

norma_document_result norma_transform_stored_normals(norma_document *document,
    const normal_mapping *mapping, const double *normals, size_t count, float *out,
    norma_document_error *error) {
    const norma_vec3_view view = {.data = normals, .count = count, .format = NORMA_FORMAT_DOUBLE};
    norma_result failed = norma_transform_normals(mapping->matrix, view, out, 0, count);
    if (failed) return norma_document_fail_core(document, error, failed);
    size_t vanished = 0, not_finite = 0;
    fill_lost(mapping, normals, out, count, &vanished, &not_finite);
    if (vanished > 0)
        norma_document_add_note(document,
            "normals that vanish under this matrix, because it flattens: %zu; they got the one "
            "direction that is left",
            vanished);
    if (not_finite > 0)
        norma_document_add_note(
            document, "normals that were not finite and became zero: %zu", not_finite);
    return NORMA_DOCUMENT_OK;
}
