/* stl_passes.c: facet normals of a binary STL, block by block: each facet needs nothing but itself,
 * so one pass and a constant amount of memory suffice. A facet without a direction gets the nearest
 * normal when all are known. */
#include "io/large/nearest_site.h"
#include "io/large/output.h"
#include "io/large/passes.h"
#include "io/stl/stl.h"
#include <math.h>

enum { FACETS = 8192 };

typedef struct stl_block { /* as a file of its own: a header, then facets */
    unsigned char bytes[STL_HEADER + FACETS * STL_FACET];
    float positions[9 * FACETS], normals[3 * FACETS];
    uint8_t reasons[FACETS];
} stl_block;

typedef struct stl_passes {
    large_compute *job;
    large_file *file;
    stl_state *state; /* its bytes: those of the block */
    stl_block *block;
    size_t facets;
    large_bits without;
    size_t without_count;
    large_output output;
} stl_passes;

/* ---- reading */

static norma_document_result open_stl(stl_passes *p) {
    large_file *file = p->file;
    stl_state *state = p->state = file->document->state = norma_io_allocate(1, sizeof *state);
    p->block = norma_large_take(&file->budget, 1, sizeof *p->block);
    if (!state || !p->block) return norma_large_fail_memory(file);
    file->document->functions = &norma_stl_functions;
    state->bytes = file->document->source.data;
    state->size = (size_t)file->size;
    state->binary = 1;
    if (file->size >= STL_HEADER && !norma_stl_is_binary(state))
        return norma_document_fail(file->document, file->error, NORMA_DOCUMENT_ERROR_UNSUPPORTED,
            NULL,
            "does not fit into the memory allowed, and an STL of text is read whole; allow "
            "more memory");
    const norma_document_result result = norma_stl_read_binary(file->document, file->error);
    p->facets = state->facets;
    state->bytes = p->block->bytes;
    return result;
}

static void close_stl(stl_passes *p) {
    norma_large_give(&p->file->budget, p->block, 1, sizeof *p->block);
    if (p->state) p->state->bytes = p->file->document->source.data;
}

static norma_document_result read_block(stl_passes *p, size_t first, size_t count) {
    return norma_large_read(p->file, STL_HEADER + (uint64_t)first * STL_FACET,
        p->block->bytes + STL_HEADER, count * STL_FACET);
}

static void load_positions(const stl_passes *p, size_t count) {
    for (size_t i = 0; i < count; ++i)
        norma_stl_load(p->state, i, NULL, p->block->positions + 9 * i);
}

/* ---- computing */

static norma_document_result measure_block(stl_passes *p, size_t count, norma_report *report) {
    const norma_mesh mesh = {
        .positions = {.data = p->block->positions, .count = 3 * count}, .corner_count = 3 * count};
    norma_options core = p->job->policy.core;
    core.weld = NORMA_WELD_NONE; /* no facet needs another one */
    core.fallback = NORMA_FALLBACK_ZERO;
    core.reasons = p->block->reasons;
    core.progress = NULL;
    load_positions(p, count);
    return norma_document_fail_core(p->file->document, p->file->error,
        norma_face_normals(&mesh, &core, p->block->normals, count, report));
}

static int is_wanted(const stl_passes *p, size_t facet, float stored[3]) {
    norma_stl_load(p->state, facet, stored, NULL);
    return norma_policy_wants_facet(p->job->policy.options->only, stored);
}

static norma_document_result note_missing(stl_passes *p, size_t facet) {
    if (!p->without.words && !norma_large_bits_open(&p->file->budget, p->facets, &p->without))
        return norma_large_fail_memory(p->file);
    norma_large_bits_set(&p->without, facet);
    ++p->without_count;
    return NORMA_DOCUMENT_OK;
}

/* What stays keeps its stored normal; what has none keeps it as long as no other is known. */
static norma_document_result choose_normals(stl_passes *p, size_t first, size_t count) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < count && !result; ++i) {
        float stored[3];
        const int wanted = is_wanted(p, i, stored);
        if (p->block->reasons[i]) result = note_missing(p, first + i);
        if (p->block->reasons[i] || !wanted)
            memcpy(p->block->normals + 3 * i, stored, sizeof stored);
    }
    return result;
}

static norma_document_result compute_block(stl_passes *p, size_t first, size_t count) {
    norma_compute_summary *summary = p->job->policy.summary;
    norma_report report;
    norma_document_result result = read_block(p, first, count);
    if (!result) result = measure_block(p, count, &report);
    if (!result) {
        norma_large_add_count(&summary->report.degenerate_faces, &report.degenerate_faces, first);
        norma_large_add_count(&summary->report.non_finite, &report.non_finite, first);
        result = choose_normals(p, first, count);
    }
    if (result) return result;
    summary->changed |= norma_stl_replace_normals(p->block->bytes, 0, count, p->block->normals);
    norma_large_output_write(&p->output, p->block->bytes + STL_HEADER, count * STL_FACET);
    return norma_large_output_result(&p->output);
}

static norma_document_result compute_blocks(stl_passes *p) {
    norma_document_result result = norma_large_output_copy(&p->output, 0, STL_HEADER);
    for (size_t first = 0; first < p->facets && !result; first += FACETS) {
        const size_t left = p->facets - first;
        result = compute_block(p, first, left < FACETS ? left : FACETS);
        if (!result) result = norma_large_tell(p->file, (double)first / (double)p->facets);
    }
    return result;
}

/* ---- facets without a direction */

static norma_document_result first_corners(void *context, size_t first, size_t count, void *out) {
    stl_passes *p = context;
    norma_document_result result = read_block(p, first, count);
    for (size_t i = 0; i < count && !result; ++i) {
        float vertices[9];
        norma_stl_load(p->state, i, NULL, vertices);
        memcpy((float *)out + 3 * i, vertices, 3 * sizeof(float));
    }
    return result;
}

static norma_document_result fill_one(void *context, uint32_t facet, uint32_t source) {
    stl_passes *p = context;
    norma_compute_summary *summary = p->job->policy.summary;
    float stored[3], normal[3] = {0, 0, 1};
    norma_report report;
    norma_document_result result = NORMA_DOCUMENT_OK;
    if (source != UINT32_MAX) result = read_block(p, source, 1);
    if (!result && source != UINT32_MAX) result = measure_block(p, 1, &report);
    if (source != UINT32_MAX) memcpy(normal, p->block->normals, sizeof normal);
    norma_policy_point_up(normal);
    if (!result) result = read_block(p, facet, 1);
    if (result || !is_wanted(p, 0, stored)) return result;
    ++summary->filled;
    summary->changed |= norma_stl_replace_normals(p->block->bytes, 0, 1, normal);
    return norma_large_output_patch(&p->output, STL_HEADER + (uint64_t)facet * STL_FACET,
        p->block->bytes + STL_HEADER, STL_NORMAL);
}

static norma_document_result fill_nearest(stl_passes *p) {
    const large_sites sites = {.file = p->file,
        .count = p->facets,
        .without = &p->without,
        .single = 1,
        .positions = first_corners,
        .context = p,
        .anchor = UINT32_MAX,
        .core = &p->job->policy.core};
    return p->without_count ? norma_large_visit_nearest(&sites, fill_one, p) : NORMA_DOCUMENT_OK;
}

static norma_document_result check_options(const large_compute *job) {
    if (job->policy.summary->shading != NORMA_SHADING_FLAT)
        return norma_document_fail(job->file->document, job->file->error,
            NORMA_DOCUMENT_ERROR_ARGUMENT, NULL,
            "STL holds one normal for each facet: smooth shading and creases cannot be stored; use "
            "neither, or another format");
    return job->policy.options->weld == NORMA_WELD_DISTANCE
               ? norma_document_fail(job->file->document, job->file->error,
                     NORMA_DOCUMENT_ERROR_UNSUPPORTED, NULL,
                     "does not fit into the memory allowed, and welding by a distance needs the "
                     "whole file; allow more memory")
               : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_compute_stl(large_compute *job) {
    stl_passes p = {.job = job, .file = job->file};
    norma_compute_summary *summary = job->policy.summary;
    norma_document_result result = check_options(job);
    if (!result) result = open_stl(&p);
    if (!result) result = norma_large_output_open(job->file, job->output, job->options, &p.output);
    summary->faces = p.facets;
    summary->vertices_before = summary->vertices_after = 3 * p.facets;
    if (job->options->pass) job->options->pass(job->options->pass_user, 1, 1);
    if (job->options->passes) *job->options->passes = 1;
    norma_large_stage(job->file, 0, 0.95);
    if (!result) result = compute_blocks(&p);
    norma_large_stage(job->file, 0.95, 1);
    if (!result)
        result = norma_large_output_copy(
            &p.output, STL_HEADER + (uint64_t)p.facets * STL_FACET, job->file->size);
    if (!result) result = fill_nearest(&p);
    result = norma_large_output_close(&p.output, result, job->options->size);
    norma_large_bits_close(&job->file->budget, &p.without);
    close_stl(&p);
    return result;
}

/* ---- describing */

norma_document_result norma_large_describe_stl(
    large_file *file, norma_large_description *description) {
    stl_passes p = {.file = file};
    norma_document_result result = open_stl(&p);
    for (size_t first = 0; first < p.facets && !result; first += FACETS) {
        const size_t left = p.facets - first, count = left < FACETS ? left : FACETS;
        result = read_block(&p, first, count);
        if (result) break;
        load_positions(&p, count);
        for (size_t i = 0; i < 3 * count; ++i) {
            const double at[3] = {(double)p.block->positions[3 * i],
                (double)p.block->positions[3 * i + 1], (double)p.block->positions[3 * i + 2]};
            norma_large_include(description, at);
        }
        result = norma_large_tell(file, (double)first / (double)p.facets);
    }
    description->vertices = 3 * p.facets;
    description->faces = description->triangles = p.facets;
    description->normals = NORMA_NORMALS_PER_FACET;
    description->encoding = "float";
    close_stl(&p);
    return result;
}
