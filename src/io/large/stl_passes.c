/* stl_passes.c: facet normals of a binary STL, block by block: each facet needs nothing but itself,
 * so one pass and a constant amount of memory suffice. A facet without a direction gets the nearest
 * normal when all are known. */
#include "io/large/nearest_site.h"
#include "io/large/output.h"
#include "io/large/passes.h"
#include "io/large/stl_blocks.h"
#include <math.h>

typedef struct stl_passes {
    large_compute *job;
    large_file *file;
    large_stl stl;
    large_bits without;
    size_t without_count;
    large_output output;
} stl_passes;

/* ---- computing */

static norma_document_result measure_block(stl_passes *p, size_t count, norma_report *report) {
    const norma_mesh mesh = {.positions = {.data = p->stl.block->positions, .count = 3 * count},
        .corner_count = 3 * count};
    norma_options core = p->job->policy.core;
    core.weld = NORMA_WELD_NONE; /* no facet needs another one */
    core.fallback = NORMA_FALLBACK_ZERO;
    core.reasons = p->stl.block->reasons;
    core.progress = NULL;
    norma_large_stl_positions(&p->stl, count);
    return norma_document_fail_core(p->file->document, p->file->error,
        norma_face_normals(&mesh, &core, p->stl.block->normals, count, report));
}

static int is_wanted(const stl_passes *p, size_t facet, float stored[3]) {
    norma_stl_load(p->stl.state, facet, stored, NULL);
    return norma_policy_wants_facet(p->job->policy.options->only, stored);
}

static norma_document_result note_missing(stl_passes *p, size_t facet) {
    if (!p->without.words && !norma_large_bits_open(&p->file->budget, p->stl.facets, &p->without))
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
        if (p->stl.block->reasons[i]) result = note_missing(p, first + i);
        if (p->stl.block->reasons[i] || !wanted)
            memcpy(p->stl.block->normals + 3 * i, stored, sizeof stored);
    }
    return result;
}

static norma_document_result compute_block(stl_passes *p, size_t first, size_t count) {
    norma_compute_summary *summary = p->job->policy.summary;
    norma_report report;
    norma_document_result result = norma_large_stl_read(&p->stl, first, count);
    if (!result) result = measure_block(p, count, &report);
    if (!result) {
        norma_large_add_count(&summary->report.degenerate_faces, &report.degenerate_faces, first);
        norma_large_add_count(&summary->report.non_finite, &report.non_finite, first);
        result = choose_normals(p, first, count);
    }
    if (result) return result;
    summary->changed |=
        norma_stl_replace_normals(p->stl.block->bytes, 0, count, p->stl.block->normals);
    norma_large_output_write(&p->output, p->stl.block->bytes + STL_HEADER, count * STL_FACET);
    return norma_large_output_result(&p->output);
}

static norma_document_result compute_blocks(stl_passes *p) {
    norma_document_result result = norma_large_output_copy(&p->output, 0, STL_HEADER);
    for (size_t first = 0; first < p->stl.facets && !result; first += LARGE_FACETS) {
        const size_t left = p->stl.facets - first;
        result = compute_block(p, first, left < LARGE_FACETS ? left : LARGE_FACETS);
        if (!result) result = norma_large_tell(p->file, (double)first / (double)p->stl.facets);
    }
    return result;
}

/* ---- facets without a direction */

static norma_document_result first_corners(void *context, size_t first, size_t count, void *out) {
    stl_passes *p = context;
    norma_document_result result = norma_large_stl_read(&p->stl, first, count);
    for (size_t i = 0; i < count && !result; ++i) {
        float vertices[9];
        norma_stl_load(p->stl.state, i, NULL, vertices);
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
    if (source != UINT32_MAX) result = norma_large_stl_read(&p->stl, source, 1);
    if (!result && source != UINT32_MAX) result = measure_block(p, 1, &report);
    if (source != UINT32_MAX) memcpy(normal, p->stl.block->normals, sizeof normal);
    norma_policy_point_up(normal);
    if (!result) result = norma_large_stl_read(&p->stl, facet, 1);
    if (result || !is_wanted(p, 0, stored)) return result;
    ++summary->filled;
    summary->changed |= norma_stl_replace_normals(p->stl.block->bytes, 0, 1, normal);
    return norma_large_output_patch(&p->output, STL_HEADER + (uint64_t)facet * STL_FACET,
        p->stl.block->bytes + STL_HEADER, STL_NORMAL);
}

static norma_document_result fill_nearest(stl_passes *p) {
    const large_sites sites = {.file = p->file,
        .count = p->stl.facets,
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
    if (!result) result = norma_large_stl_open(job->file, &p.stl);
    if (!result) result = norma_large_output_open(job->file, job->output, job->options, &p.output);
    summary->faces = p.stl.facets;
    summary->vertices_before = summary->vertices_after = 3 * p.stl.facets;
    if (job->options->pass) job->options->pass(job->options->pass_user, 1, 1);
    if (job->options->passes) *job->options->passes = 1;
    norma_large_stage(job->file, 0, 0.95);
    if (!result) result = compute_blocks(&p);
    norma_large_stage(job->file, 0.95, 1);
    if (!result)
        result = norma_large_output_copy(
            &p.output, STL_HEADER + (uint64_t)p.stl.facets * STL_FACET, job->file->size);
    if (!result) result = fill_nearest(&p);
    result = norma_large_output_close(&p.output, result, job->options->size);
    norma_large_bits_close(&job->file->budget, &p.without);
    norma_large_stl_close(&p.stl);
    return result;
}

/* ---- describing */

norma_document_result norma_large_describe_stl(
    large_file *file, norma_large_description *description) {
    large_stl stl;
    norma_document_result result = norma_large_stl_open(file, &stl);
    for (size_t first = 0; first < stl.facets && !result; first += LARGE_FACETS) {
        const size_t left = stl.facets - first, count = left < LARGE_FACETS ? left : LARGE_FACETS;
        result = norma_large_stl_read(&stl, first, count);
        if (result) break;
        norma_large_stl_positions(&stl, count);
        for (size_t i = 0; i < 3 * count; ++i) {
            const double at[3] = {(double)stl.block->positions[3 * i],
                (double)stl.block->positions[3 * i + 1], (double)stl.block->positions[3 * i + 2]};
            norma_large_include(description, at);
        }
        result = norma_large_tell(file, (double)first / (double)stl.facets);
    }
    description->vertices = 3 * stl.facets;
    description->faces = description->triangles = stl.facets;
    description->normals = NORMA_NORMALS_PER_FACET;
    description->encoding = "float";
    norma_large_stl_close(&stl);
    return result;
}
