/* ply_passes.c: smooth normals of a binary PLY in passes. Each pass computes the normals of a range
 * of vertices and writes their rows, so the output grows from its beginning to its end; what has no
 * normal gets the nearest one when all are known. */
#include "io/large/equal_positions.h"
#include "io/large/nearest_site.h"
#include "io/large/output.h"
#include "io/large/passes.h"
#include "io/large/ply_part.h"
#include <math.h>
#include <stdlib.h>

typedef struct ply_passes {
    large_compute *job;
    large_file *file;
    large_ply ply;
    large_survey survey;
    large_parts parts;
    large_bits without; /* vertices without a normal of their own */
    size_t without_count;
    large_output output;
    uint64_t rows_begin; /* in the output */
    large_row row;
    int had;         /* normals were there */
    int only_broken; /* and most of them stay */
} ply_passes;

/* ---- what is asked */

static norma_document_result refuse(const large_file *file, const char *what) {
    return norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
        "does not fit into the memory allowed, and %s the whole file; allow more memory", what);
}

static norma_document_result check_options(const large_compute *job) {
    const norma_compute_options *options = job->policy.options;
    if (job->policy.summary->shading != NORMA_SHADING_SMOOTH)
        return refuse(job->file, "flat normals and creases need");
    if (options->weld == NORMA_WELD_DISTANCE && options->weld_distance > 0)
        return refuse(job->file, "welding by a distance needs");
    return NORMA_DOCUMENT_OK;
}

static const ply_element *vertex_of(const ply_passes *p) { return p->ply.vertex; }

static size_t block_size(const ply_passes *p, size_t first, size_t end) {
    (void)p;
    return end - first < LARGE_BLOCK ? end - first : LARGE_BLOCK;
}

/* As ply_compute.c judges a stored normal. */
static int is_broken(const double stored[3], double scale) {
    double normal[3];
    for (int axis = 0; axis < 3; ++axis) {
        normal[axis] = stored[axis] / scale;
        if (scale > 1 && normal[axis] < -1) normal[axis] = -1;
    }
    return norma_normal_is_broken(normal, scale == 127 ? 8 : 32);
}

static norma_document_result find_broken(ply_passes *p, int *any) {
    const double scale =
        norma_ply_normal_scale(&p->ply.state->header, vertex_of(p), p->ply.state->header.normal);
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < p->ply.vertices && !result && !*any; first += LARGE_BLOCK) {
        const size_t count = block_size(p, first, p->ply.vertices);
        double *stored;
        large_view view;
        result = norma_large_ply_stored(&p->ply, first, count, &stored, &view);
        if (result) return result;
        norma_large_ply_look_away(&p->ply, &view);
        for (size_t i = 0; i < count; ++i) *any |= is_broken(stored + 3 * i, scale);
        free(stored);
    }
    return result;
}

/* ---- rows */

static int differs(
    const float *normals, const double *stored, const uint8_t *reasons, size_t count) {
    for (size_t i = 0; i < 3 * count; ++i) {
        const double now = (double)normals[i];
        if (!reasons[i / 3] && memcmp(&now, &stored[i], sizeof now) != 0) return 1;
    }
    return 0;
}

/* normals: changed into what is stored. */
static norma_document_result write_block(
    ply_passes *p, size_t first, size_t count, float *normals, const uint8_t *reasons) {
    large_file *file = p->file;
    ply_edit *edit = &p->ply.state->edit;
    double *stored;
    large_view view;
    norma_document_result result = norma_large_ply_stored(&p->ply, first, count, &stored, &view);
    if (result) return result;
    result =
        norma_ply_encode_normals(file->document, edit->normal_types, normals, count, file->error);
    for (size_t i = 0; stored && !p->only_broken && i < 3 * count; ++i)
        normals[i] = norma_policy_keep_zero(normals[i], stored[i]);
    if (stored && !p->job->policy.summary->changed)
        p->job->policy.summary->changed = differs(normals, stored, reasons, count);
    free(stored);
    if (result) {
        norma_large_ply_look_away(&p->ply, &view);
        return result;
    }
    result =
        norma_large_ply_write_rows(&p->ply, &view, normals, norma_large_output_write, &p->output);
    return result ? result : norma_large_output_result(&p->output);
}

static norma_document_result write_part(ply_passes *p, const large_part *part) {
    norma_compute_summary *summary = p->job->policy.summary;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = part->begin; first < part->end && !result; first += LARGE_BLOCK) {
        const size_t count = block_size(p, first, part->end), at = first - part->begin;
        for (size_t i = 0; i < count; ++i) {
            if (!part->reasons[at + i]) continue;
            norma_large_bits_set(&p->without, first + i);
            ++p->without_count;
            norma_large_count_reason(&summary->report, part->reasons[at + i], first + i);
        }
        result = write_block(p, first, count, part->normals + 3 * at, part->reasons + at);
        if (!result)
            result = norma_large_tell(
                p->file, 0.9 + 0.1 * (double)at / (double)(part->end - part->begin));
    }
    return result;
}

/* ---- passes */

/* Smaller and smaller, as long as it does not fit. */
static norma_document_result compute_part(ply_passes *p, large_part *part) {
    enum { LEAST = 64 };
    norma_document_result result = norma_large_part_compute(&p->parts, part);
    while (result == NORMA_DOCUMENT_ERROR_MEMORY && part->end - part->begin > LEAST) {
        norma_large_part_close(&p->parts, part);
        p->parts.share *= 0.6;
        const size_t end = norma_large_part_end(&p->parts, part->begin),
                     half = part->begin + (part->end - part->begin) / 2;
        part->end = end < half ? end : half;
        result = norma_large_part_compute(&p->parts, part);
    }
    return result == NORMA_DOCUMENT_ERROR_MEMORY ? norma_large_fail_memory(p->file) : result;
}

static norma_document_result run_passes(ply_passes *p, double from, double to) {
    const size_t vertices = p->ply.vertices;
    size_t number = 0;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t begin = 0, count = norma_large_part_count(&p->parts);
         begin < vertices && !result;) {
        large_part part = {.begin = begin, .end = norma_large_part_end(&p->parts, begin)};
        const double done = (double)begin / (double)vertices;
        if (++number > count) count = number;
        if (p->job->options->passes) *p->job->options->passes = number;
        if (p->job->options->pass) p->job->options->pass(p->job->options->pass_user, number, count);
        norma_large_stage(p->file, from + (to - from) * done,
            from + (to - from) * (double)part.end / (double)vertices);
        result = compute_part(p, &part);
        if (!result) result = write_part(p, &part);
        norma_large_add_count(
            &p->job->policy.summary->report.degenerate_faces, &part.degenerate, 0);
        begin = part.end;
        norma_large_part_close(&p->parts, &part);
    }
    return result;
}

/* ---- what has no normal */

static norma_document_result read_positions(void *context, size_t first, size_t count, void *out) {
    return norma_large_ply_positions(context, first, count, out);
}

static uint64_t row_place(const ply_passes *p, size_t vertex) {
    return p->rows_begin + (uint64_t)vertex * p->row.size;
}

/* What was written for one vertex becomes what is written for another. */
static norma_document_result patch_row(ply_passes *p, uint32_t vertex, const double normal[3]) {
    const ply_edit *edit = &p->ply.state->edit;
    double *stored;
    large_view view;
    norma_document_result result = norma_large_ply_stored(&p->ply, vertex, 1, &stored, &view);
    if (result) return result;
    norma_large_ply_look_away(&p->ply, &view);
    for (int axis = 0; axis < 3 && !result; ++axis) {
        unsigned char bytes[8];
        const float now = (float)normal[axis],
                    kept =
                        stored && !p->only_broken ? norma_policy_keep_zero(now, stored[axis]) : now;
        const double value = (double)kept;
        if (stored && memcmp(&value, &stored[axis], sizeof value) != 0)
            p->job->policy.summary->changed = 1;
        norma_ply_put(bytes, edit->normal_types[axis], p->ply.state->header.encoding, value);
        result = norma_large_output_patch(&p->output, row_place(p, vertex) + p->row.normal[axis],
            bytes, norma_ply_type_size(edit->normal_types[axis]));
    }
    free(stored);
    return result;
}

static norma_document_result fill_one(void *context, uint32_t vertex, uint32_t source) {
    ply_passes *p = context;
    const ply_edit *edit = &p->ply.state->edit;
    const ply_type type = edit->normal_types[2];
    double normal[3] = {0, 0, type == PLY_INT8 ? 127 : type == PLY_INT16 ? 32767 : 1};
    for (int axis = 0; axis < 3 && source != UINT32_MAX; ++axis) {
        unsigned char bytes[8];
        norma_document_result result =
            norma_large_output_read(&p->output, row_place(p, source) + p->row.normal[axis], bytes,
                norma_ply_type_size(edit->normal_types[axis]));
        if (result) return result;
        /* A zero may have the sign of the one that it replaced. */
        normal[axis] =
            norma_ply_get(bytes, edit->normal_types[axis], p->ply.state->header.encoding) + 0.0;
    }
    return patch_row(p, vertex, normal);
}

static norma_document_result fill_nearest(ply_passes *p) {
    const large_sites sites = {.file = p->file,
        .count = p->ply.vertices,
        .without = &p->without,
        .single = p->ply.single,
        .positions = read_positions,
        .context = &p->ply,
        .anchor = p->parts.anchor,
        .core = &p->parts.core};
    p->job->policy.summary->filled = p->without_count;
    return p->without_count ? norma_large_visit_nearest(&sites, fill_one, p) : NORMA_DOCUMENT_OK;
}

/* With --only broken, all others get their stored bytes back. */
static norma_document_result restore_block(ply_passes *p, size_t first, size_t count) {
    const ply_header *header = &p->ply.state->header;
    const double scale = norma_ply_normal_scale(header, vertex_of(p), header->normal);
    unsigned char *rows = malloc(count * p->row.size);
    double *stored = NULL;
    large_view view;
    norma_document_result result =
        rows ? norma_large_ply_stored(&p->ply, first, count, &stored, &view)
             : norma_large_fail_memory(p->file);
    if (!result) norma_large_ply_look_away(&p->ply, &view);
    if (!result)
        result =
            norma_large_output_read(&p->output, row_place(p, first), rows, count * p->row.size);
    for (size_t i = 0; i < count && !result; ++i) {
        if (is_broken(stored + 3 * i, scale)) continue;
        if (norma_large_bits_has(&p->without, first + i)) --p->job->policy.summary->filled;
        for (int axis = 0; axis < 3; ++axis)
            norma_ply_put(rows + i * p->row.size + p->row.normal[axis],
                p->ply.state->edit.normal_types[axis], header->encoding,
                stored[3 * i + (size_t)axis]);
    }
    if (!result)
        result =
            norma_large_output_patch(&p->output, row_place(p, first), rows, count * p->row.size);
    free(stored);
    free(rows);
    return result;
}

static norma_document_result restore_unbroken(ply_passes *p) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    p->job->policy.summary->changed = 1;
    for (size_t first = 0; first < p->ply.vertices && !result; first += LARGE_BLOCK)
        result = restore_block(p, first, block_size(p, first, p->ply.vertices));
    return result;
}

/* ---- before the passes */

/* Doubles are scaled by their greatest, which each part then has to hold. */
static norma_document_result find_anchor(ply_passes *p) {
    double greatest = -1;
    p->parts.anchor = UINT32_MAX;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; !p->ply.single && first < p->ply.vertices && !result;
         first += LARGE_BLOCK) {
        const size_t count = block_size(p, first, p->ply.vertices);
        const double *at = p->ply.scratch;
        result = norma_large_ply_positions(&p->ply, first, count, p->ply.scratch);
        for (size_t i = 0; i < count && !result; ++i, at += 3) {
            const double most = fmax(fmax(fabs(at[0]), fabs(at[1])), fabs(at[2]));
            if (!(isfinite(at[0]) && isfinite(at[1]) && isfinite(at[2])) || most <= greatest)
                continue;
            greatest = most;
            p->parts.anchor = (uint32_t)(first + i);
        }
    }
    return result;
}

static norma_document_result find_equal(ply_passes *p) {
    large_budget *budget = &p->file->budget;
    int any = 0;
    p->parts.core.weld = NORMA_WELD_NONE;
    if (p->job->policy.core.weld == NORMA_WELD_NONE) return NORMA_DOCUMENT_OK;
    if (!norma_large_bits_open(budget, p->ply.vertices, &p->parts.equal))
        return norma_large_fail_memory(p->file);
    norma_document_result result = norma_large_find_equal(&p->ply, &p->parts.equal, &any);
    if (any)
        p->parts.core.weld = NORMA_WELD_EXACT;
    else
        norma_large_bits_close(budget, &p->parts.equal);
    return result;
}

static norma_document_result begin_output(ply_passes *p) {
    const ply_header *header = &p->ply.state->header;
    const ply_edit *edit = &p->ply.state->edit;
    norma_document_result result =
        norma_large_ply_write_header(&p->ply, norma_large_output_write, &p->output, &p->row);
    for (int axis = 0; axis < 3 && p->had; ++axis)
        p->job->policy.summary->changed |=
            norma_ply_property(header, vertex_of(p), header->normal[axis])->type !=
            edit->normal_types[axis];
    if (!result) result = norma_large_output_result(&p->output);
    norma_large_stage(p->file, 0.27, 0.28);
    if (!result) result = norma_large_output_copy(&p->output, header->body, vertex_of(p)->begin);
    p->rows_begin = p->output.written;
    return result;
}

static norma_document_result prepare(ply_passes *p) {
    large_file *file = p->file;
    p->parts = (large_parts){
        .ply = &p->ply, .survey = &p->survey, .core = p->job->policy.core, .share = 1};
    p->parts.core.fallback = NORMA_FALLBACK_ZERO;
    norma_large_stage(file, 0.15, 0.27);
    norma_document_result result = find_anchor(p);
    if (!result) result = find_equal(p);
    if (!result && !norma_large_bits_open(&file->budget, p->ply.vertices, &p->without))
        result = norma_large_fail_memory(file);
    return result;
}

/* ---- all of it */

static norma_document_result copy_whole(ply_passes *p) {
    norma_large_stage(p->file, 0.3, 1);
    return norma_large_output_copy(&p->output, 0, p->file->size);
}

static norma_document_result compute_all(ply_passes *p) {
    large_file *file = p->file;
    norma_document_result result = prepare(p);
    if (!result) result = begin_output(p);
    if (!result) result = run_passes(p, 0.28, 0.9);
    norma_large_stage(file, 0.9, 0.95);
    if (!result) result = norma_large_output_copy(&p->output, vertex_of(p)->end, file->size);
    norma_large_stage(file, 0.95, 1);
    if (!result) result = fill_nearest(p);
    if (!result && p->only_broken) result = restore_unbroken(p);
    norma_large_bits_close(&file->budget, &p->parts.equal);
    norma_large_bits_close(&file->budget, &p->without);
    return result;
}

static norma_document_result compute(ply_passes *p) {
    norma_compute_summary *summary = p->job->policy.summary;
    const norma_only only = p->job->policy.options->only;
    int broken = 0;
    if (p->survey.corners == 0 || (only == NORMA_ONLY_MISSING && p->had)) return copy_whole(p);
    if (p->only_broken) {
        norma_document_result result = find_broken(p, &broken);
        if (result || !broken) return result ? result : copy_whole(p);
    }
    summary->changed = !p->had;
    return compute_all(p);
}

norma_document_result norma_large_compute_ply(large_compute *job) {
    ply_passes p = {.job = job, .file = job->file};
    p.ply.file = p.ply.rows.file = p.ply.blocks.file = job->file; /* closed even if not opened */
    norma_compute_summary *summary = job->policy.summary;
    norma_document_result result = check_options(job);
    if (!result) result = norma_large_ply_open(job->file, &p.ply);
    if (!result) result = norma_large_output_open(job->file, job->output, job->options, &p.output);
    norma_large_stage(job->file, 0, 0.15);
    if (!result) result = norma_large_survey(&p.ply, &p.survey);
    if (!result) {
        p.had = p.ply.state->header.normal[0] != PLY_NONE;
        p.only_broken = job->policy.options->only == NORMA_ONLY_BROKEN && p.had;
        summary->faces = (size_t)p.ply.faces;
        summary->vertices_before = summary->vertices_after = p.ply.vertices;
        norma_large_add_count(&summary->report.degenerate_faces, &p.survey.empty, 0);
        result = compute(&p);
    }
    result = norma_large_output_close(&p.output, result, job->options->size);
    norma_large_survey_close(&p.ply, &p.survey);
    norma_large_ply_close(&p.ply);
    return result;
}
