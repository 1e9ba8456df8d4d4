/* large_compute.c: normals in passes: facets of STL files, smooth normals of PLY files. */
#include "io/large/large.h"
#include "core/mesh/mesh.h"
#include <math.h>
#include <stdlib.h>

/* ---- What is counted over the parts of a file. */

/* first: added to the number of the first one counted. */
static void add_part_count(norma_count *sum, const norma_count *count, size_t first) {
    if (count->count == 0) return;
    const size_t lowest = first + count->first;
    if (sum->count == 0 || lowest < sum->first) sum->first = lowest;
    sum->count += count->count;
}

/* An element without a normal: counted by its reason, with the first one's number. */
static void count_part_reason(norma_report *report, uint8_t reason, size_t element) {
    const norma_count one = {1, 0};
    if (reason == NORMA_REASON_NON_FINITE) add_part_count(&report->non_finite, &one, element);
    if (reason == NORMA_REASON_UNREFERENCED) add_part_count(&report->unreferenced, &one, element);
    if (reason == NORMA_REASON_CANCELLED) add_part_count(&report->cancelled, &one, element);
}

/* ---- A binary STL read block by block. */

norma_document_result norma_large_stl_open(large_file *file, large_stl *stl) {
    stl_state *state = file->document->state = norma_io_allocate(1, sizeof *state);
    *stl = (large_stl){.file = file, .state = state};
    stl->block = norma_large_take(&file->budget, 1, sizeof *stl->block);
    if (!state || !stl->block) return norma_large_fail_memory(file);
    file->document->functions = &norma_stl_functions;
    state->bytes = file->document->source.data;
    state->size = (size_t)file->size;
    state->binary = 1;
    if (file->size >= STL_HEADER && !norma_stl_is_binary(state))
        return norma_large_fail_whole(file, "an ASCII STL is read whole");
    const norma_document_result result = norma_stl_read_binary(file->document, file->error);
    stl->facets = state->facets;
    state->bytes = stl->block->bytes;
    return result;
}

void norma_large_stl_close(large_stl *stl) {
    if (!stl->file) return;
    norma_large_give(&stl->file->budget, stl->block, 1, sizeof *stl->block);
    if (stl->state) stl->state->bytes = stl->file->document->source.data;
}

norma_document_result norma_large_stl_read(large_stl *stl, size_t first, size_t count) {
    return norma_large_read(stl->file, STL_HEADER + (uint64_t)first * STL_FACET,
        stl->block->bytes + STL_HEADER, count * STL_FACET);
}

void norma_large_stl_positions(const large_stl *stl, size_t count) {
    for (size_t i = 0; i < count; ++i)
        norma_stl_load(stl->state, i, NULL, stl->block->positions + 9 * i);
}

/* ---- The nearest element that has a normal, block by block of elements: in each block
 * as the core finds it, the nearest of all blocks in the end. Ties go to the lower number, as
 * there. */

enum { BLOCK = 8192, BYTES_FOR_SITE = 96, BYTES_FOR_QUERY = 160, MOST_SITES = 1 << 24 };

typedef struct query_batch {
    const large_sites *sites;
    uint32_t *elements, *sources;
    core_segment *nearest; /* from each to its source */
    size_t count, capacity;
    unsigned char *positions; /* of sites in a block, then of the queries, then of the anchor */
    size_t site_capacity, element_size;
} query_batch;

/* ---- positions */

static norma_document_result read_run(
    const large_sites *sites, size_t first, size_t count, unsigned char *out, size_t size) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t done = 0; done < count && !result; done += BLOCK)
        result = sites->positions(
            sites->context, first + done, norma_large_some(count - done, BLOCK), out + done * size);
    return result;
}

static unsigned char *query_place(const query_batch *batch, size_t query) {
    return batch->positions + (batch->site_capacity + query) * batch->element_size;
}

static norma_document_result add_query(query_batch *batch, size_t element) {
    const size_t query = batch->count++;
    batch->elements[query] = (uint32_t)element;
    batch->sources[query] = UINT32_MAX;
    return batch->sites->positions(batch->sites->context, element, 1, query_place(batch, query));
}

/* ---- one block */

/* A place that is not finite keeps the first that it gets. */
static int is_nearer_still(const query_batch *batch, size_t query, const core_segment *to) {
    return batch->sources[query] == UINT32_MAX ||
           (norma_core_finite(to->from) &&
               norma_core_compare_lengths(to, &batch->nearest[query]) < 0);
}

static void passes_ask(query_batch *batch, core_nearest *nearest, size_t first) {
    for (size_t i = 0; i < batch->count; ++i) {
        const uint32_t position = (uint32_t)(batch->site_capacity + i);
        const uint32_t site = norma_core_nearest_find(nearest, position);
        core_segment to;
        if (site == UINT32_MAX) continue;
        norma_core_position(nearest->mesh, position, to.from);
        norma_core_position(nearest->mesh, site, to.to);
        norma_core_measure_segment(&to);
        if (!is_nearer_still(batch, i, &to)) continue;
        batch->sources[i] = (uint32_t)(first + site);
        batch->nearest[i] = to;
    }
}

static norma_result search_block(query_batch *batch, size_t first, size_t count) {
    const large_sites *sites = batch->sites;
    norma_options options = *sites->core;
    core_call call;
    core_mesh checked;
    core_nearest nearest;
    const norma_mesh mesh = {
        .positions = {.data = batch->positions,
            .count = batch->site_capacity + batch->capacity + 1,
            .format = sites->single ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE}};
    options.progress = NULL;
    options.reasons = NULL;
    options.weld = NORMA_WELD_NONE;
    options.allocator = norma_large_allocator(&sites->file->budget);
    norma_result result = norma_core_begin(&call, &options);
    if (!result) result = norma_core_mesh_shape(&mesh, &checked);
    if (!result) result = norma_core_mesh_content(&call, &checked);
    if (!result) result = norma_core_nearest_begin(&call, &checked, &nearest);
    if (result) return result;
    for (size_t i = 0; i < count; ++i)
        if (!norma_large_bits_has(sites->without, first + i))
            norma_core_nearest_add(&nearest, (uint32_t)i, (uint32_t)i);
    result = norma_core_nearest_plant(&nearest, batch->count);
    if (!result) passes_ask(batch, &nearest, first);
    norma_core_nearest_end(&nearest);
    return result;
}

static norma_document_result search_all(query_batch *batch) {
    const large_sites *sites = batch->sites;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < sites->count && !result; first += batch->site_capacity) {
        const size_t count = norma_large_some(sites->count - first, batch->site_capacity);
        result = read_run(sites, first, count, batch->positions, batch->element_size);
        const norma_result failed = result ? NORMA_OK : search_block(batch, first, count);
        if (failed == NORMA_ERROR_MEMORY) result = norma_large_fail_memory(sites->file);
        if (failed && !result)
            result = norma_document_fail_core(sites->file->document, sites->file->error, failed);
        if (!result) result = norma_large_tell(sites->file, (double)first / (double)sites->count);
    }
    return result;
}

/* ---- batches of queries */

static size_t capped(uint64_t value, size_t least, size_t most) {
    return value < least ? least : value > most ? most : (size_t)value;
}

static norma_document_result open_batch(const large_sites *sites, query_batch *batch) {
    large_budget *budget = &sites->file->budget;
    const uint64_t left = budget->most - budget->used;
    *batch = (query_batch){
        .sites = sites, .element_size = 3 * (sites->single ? sizeof(float) : sizeof(double))};
    batch->capacity =
        norma_large_some(capped(left / 4 / BYTES_FOR_QUERY, 64, MOST_SITES), sites->count);
    batch->site_capacity =
        norma_large_some(capped(left / 2 / BYTES_FOR_SITE, BLOCK, MOST_SITES), sites->count);
    batch->elements = norma_large_take(budget, batch->capacity, sizeof *batch->elements);
    batch->sources = norma_large_take(budget, batch->capacity, sizeof *batch->sources);
    batch->nearest = norma_large_take(budget, batch->capacity, sizeof *batch->nearest);
    batch->positions = norma_large_take_zeroed(
        budget, batch->site_capacity + batch->capacity + 1, batch->element_size);
    if (!batch->elements || !batch->sources || !batch->nearest || !batch->positions)
        return norma_large_fail_memory(sites->file);
    return sites->anchor == UINT32_MAX ? NORMA_DOCUMENT_OK
                                       : sites->positions(sites->context, sites->anchor, 1,
                                             query_place(batch, batch->capacity));
}

static void close_batch(query_batch *batch) {
    large_budget *budget = &batch->sites->file->budget;
    norma_large_give(budget, batch->elements, batch->capacity, sizeof *batch->elements);
    norma_large_give(budget, batch->sources, batch->capacity, sizeof *batch->sources);
    norma_large_give(budget, batch->nearest, batch->capacity, sizeof *batch->nearest);
    norma_large_give(
        budget, batch->positions, batch->site_capacity + batch->capacity + 1, batch->element_size);
}

static norma_document_result finish_batch(
    query_batch *batch, large_visit_source *visit, void *context) {
    norma_document_result result = batch->count ? search_all(batch) : NORMA_DOCUMENT_OK;
    for (size_t i = 0; i < batch->count && !result; ++i)
        result = visit(context, batch->elements[i], batch->sources[i]);
    batch->count = 0;
    return result;
}

static norma_document_result large_visit_nearest(
    const large_sites *sites, large_visit_source *visit, void *context) {
    query_batch batch;
    norma_document_result result = open_batch(sites, &batch);
    for (size_t i = 0; i < sites->count && !result; ++i) {
        if (i % 64 == 0 && !sites->without->words[i / 64]) {
            i += 63;
            continue;
        }
        if (!norma_large_bits_has(sites->without, i)) continue;
        result = add_query(&batch, i);
        if (!result && batch.count == batch.capacity) result = finish_batch(&batch, visit, context);
    }
    if (!result) result = finish_batch(&batch, visit, context);
    close_batch(&batch);
    return result;
}

/* ---- Facet normals of a binary STL, block by block: each facet needs nothing but itself,
 * so one pass and a constant amount of memory suffice. A facet without a direction gets the nearest
 * normal when all are known. */

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

static int passes_is_wanted(const stl_passes *p, size_t facet, float stored[3]) {
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
        const int wanted = passes_is_wanted(p, i, stored);
        if (p->stl.block->reasons[i]) result = note_missing(p, first + i);
        if (p->stl.block->reasons[i] || !wanted)
            memcpy(p->stl.block->normals + 3 * i, stored, sizeof stored);
    }
    return result;
}

static norma_document_result passes_compute_block(stl_passes *p, size_t first, size_t count) {
    norma_compute_summary *summary = p->job->policy.summary;
    norma_report report;
    norma_document_result result = norma_large_stl_read(&p->stl, first, count);
    if (!result) result = measure_block(p, count, &report);
    if (!result) {
        add_part_count(&summary->report.degenerate_faces, &report.degenerate_faces, first);
        add_part_count(&summary->report.non_finite, &report.non_finite, first);
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
        result =
            passes_compute_block(p, first, norma_large_some(p->stl.facets - first, LARGE_FACETS));
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

static norma_document_result fill_facet(void *context, uint32_t facet, uint32_t source) {
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
    if (result || !passes_is_wanted(p, 0, stored)) return result;
    ++summary->filled;
    summary->changed |= norma_stl_replace_normals(p->stl.block->bytes, 0, 1, normal);
    return norma_large_output_patch(&p->output, STL_HEADER + (uint64_t)facet * STL_FACET,
        p->stl.block->bytes + STL_HEADER, STL_NORMAL);
}

static norma_document_result fill_nearest_facets(stl_passes *p) {
    const large_sites sites = {.file = p->file,
        .count = p->stl.facets,
        .without = &p->without,
        .single = 1,
        .positions = first_corners,
        .context = p,
        .anchor = UINT32_MAX,
        .core = &p->job->policy.core};
    return p->without_count ? large_visit_nearest(&sites, fill_facet, p) : NORMA_DOCUMENT_OK;
}

norma_document_result norma_large_compute_stl(large_compute *job) {
    stl_passes p = {.job = job, .file = job->file};
    norma_compute_summary *summary = job->policy.summary;
    norma_document_result result =
        norma_stl_check_shading(job->file->document, job->policy.options, job->file->error);
    if (!result && job->policy.options->weld == NORMA_WELD_DISTANCE)
        result = norma_large_fail_whole(job->file, "welding by a distance needs the whole file");
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
    if (!result) result = fill_nearest_facets(&p);
    result = norma_large_output_close(&p.output, result, job->options->size);
    norma_large_bits_close(&job->file->budget, &p.without);
    norma_large_stl_close(&p.stl);
    return result;
}

/* ---- Smooth normals of a binary PLY in passes. Each pass computes the normals of a range
 * of vertices and writes their rows, so the output grows from its beginning to its end; what has no
 * normal gets the nearest one when all are known. */

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
    ply_row row;
    int had;         /* normals were there */
    int only_broken; /* and most of them stay */
} ply_passes;

/* ---- what is asked */

static norma_document_result check_options(const large_compute *job) {
    const norma_compute_options *options = job->policy.options;
    if (job->policy.summary->shading != NORMA_SHADING_SMOOTH)
        return norma_large_fail_whole(job->file, "flat normals and creases need the whole file");
    if (options->weld == NORMA_WELD_DISTANCE && options->weld_distance > 0)
        return norma_large_fail_whole(job->file, "welding by a distance needs the whole file");
    return NORMA_DOCUMENT_OK;
}

static norma_document_result passes_find_broken(ply_passes *p, int *any) {
    const double scale =
        norma_ply_normal_scale(&p->ply.state->header, p->ply.vertex, p->ply.state->header.normal);
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < p->ply.vertices && !result && !*any; first += LARGE_BLOCK) {
        const size_t count = norma_large_some(p->ply.vertices - first, LARGE_BLOCK);
        double *stored;
        result = norma_large_ply_stored(&p->ply, first, count, &stored);
        if (result) return result;
        for (size_t i = 0; i < count; ++i) *any |= norma_ply_is_broken(stored + 3 * i, scale);
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
static norma_document_result passes_write_block(
    ply_passes *p, size_t first, size_t count, float *normals, const uint8_t *reasons) {
    large_file *file = p->file;
    ply_edit *edit = &p->ply.state->edit;
    double *stored;
    norma_document_result result = norma_large_ply_stored(&p->ply, first, count, &stored);
    if (result) return result;
    result =
        norma_ply_encode_normals(file->document, edit->normals.types, normals, count, file->error);
    for (size_t i = 0; stored && !p->only_broken && i < 3 * count; ++i)
        normals[i] = norma_policy_keep_zero(normals[i], stored[i]);
    if (stored && !p->job->policy.summary->changed)
        p->job->policy.summary->changed = differs(normals, stored, reasons, count);
    free(stored);
    if (!result)
        result = norma_large_ply_write_rows(
            &p->ply, first, count, normals, norma_large_output_write, &p->output);
    return result ? result : norma_large_output_result(&p->output);
}

static norma_document_result passes_write_part(ply_passes *p, const large_part *part) {
    norma_compute_summary *summary = p->job->policy.summary;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = part->begin; first < part->end && !result; first += LARGE_BLOCK) {
        const size_t count = norma_large_some(part->end - first, LARGE_BLOCK),
                     at = first - part->begin;
        for (size_t i = 0; i < count; ++i) {
            if (!part->reasons[at + i]) continue;
            norma_large_bits_set(&p->without, first + i);
            ++p->without_count;
            count_part_reason(&summary->report, part->reasons[at + i], first + i);
        }
        result = passes_write_block(p, first, count, part->normals + 3 * at, part->reasons + at);
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
        if (!result) result = passes_write_part(p, &part);
        add_part_count(&p->job->policy.summary->report.degenerate_faces, &part.degenerate, 0);
        begin = part.end;
        norma_large_part_close(&p->parts, &part);
    }
    return result;
}

/* ---- what has no normal */

static norma_document_result passes_read_positions(
    void *context, size_t first, size_t count, void *out) {
    return norma_large_ply_positions(context, first, count, out);
}

static uint64_t row_place(const ply_passes *p, size_t vertex) {
    return p->rows_begin + (uint64_t)vertex * p->row.size;
}

/* What was written for one vertex becomes what is written for another. */
static norma_document_result patch_row(ply_passes *p, uint32_t vertex, const double normal[3]) {
    const ply_edit *edit = &p->ply.state->edit;
    double *stored;
    norma_document_result result = norma_large_ply_stored(&p->ply, vertex, 1, &stored);
    for (int axis = 0; axis < 3 && !result; ++axis) {
        unsigned char bytes[8];
        const float now = (float)normal[axis],
                    kept =
                        stored && !p->only_broken ? norma_policy_keep_zero(now, stored[axis]) : now;
        const double value = (double)kept;
        if (stored && memcmp(&value, &stored[axis], sizeof value) != 0)
            p->job->policy.summary->changed = 1;
        norma_ply_put(bytes, edit->normals.types[axis], p->ply.state->header.encoding, value);
        result = norma_large_output_patch(&p->output, row_place(p, vertex) + p->row.normal[axis],
            bytes, norma_ply_type_size(edit->normals.types[axis]));
    }
    free(stored);
    return result;
}

static norma_document_result fill_one(void *context, uint32_t vertex, uint32_t source) {
    ply_passes *p = context;
    const ply_edit *edit = &p->ply.state->edit;
    const ply_type type = edit->normals.types[2];
    double normal[3] = {0, 0, type == PLY_INT8 ? 127 : type == PLY_INT16 ? 32767 : 1};
    for (int axis = 0; axis < 3 && source != UINT32_MAX; ++axis) {
        unsigned char bytes[8];
        norma_document_result result =
            norma_large_output_read(&p->output, row_place(p, source) + p->row.normal[axis], bytes,
                norma_ply_type_size(edit->normals.types[axis]));
        if (result) return result;
        /* A zero may have the sign of the one that it replaced. */
        normal[axis] =
            norma_ply_get(bytes, edit->normals.types[axis], p->ply.state->header.encoding) + 0.0;
    }
    return patch_row(p, vertex, normal);
}

static norma_document_result passes_fill_nearest(ply_passes *p) {
    const large_sites sites = {.file = p->file,
        .count = p->ply.vertices,
        .without = &p->without,
        .single = p->ply.single,
        .positions = passes_read_positions,
        .context = &p->ply,
        .anchor = p->parts.anchor,
        .core = &p->parts.core};
    p->job->policy.summary->filled = p->without_count;
    return p->without_count ? large_visit_nearest(&sites, fill_one, p) : NORMA_DOCUMENT_OK;
}

/* With --only broken, all others get their stored bytes back. */
static norma_document_result restore_block(ply_passes *p, size_t first, size_t count) {
    const ply_header *header = &p->ply.state->header;
    const double scale = norma_ply_normal_scale(header, p->ply.vertex, header->normal);
    unsigned char *rows = malloc(count * p->row.size);
    double *stored = NULL;
    norma_document_result result = rows ? norma_large_ply_stored(&p->ply, first, count, &stored)
                                        : norma_large_fail_memory(p->file);
    if (!result)
        result =
            norma_large_output_read(&p->output, row_place(p, first), rows, count * p->row.size);
    for (size_t i = 0; i < count && !result; ++i) {
        if (norma_ply_is_broken(stored + 3 * i, scale)) continue;
        if (norma_large_bits_has(&p->without, first + i)) --p->job->policy.summary->filled;
        for (int axis = 0; axis < 3; ++axis)
            norma_ply_put(rows + i * p->row.size + p->row.normal[axis],
                p->ply.state->edit.normals.types[axis], header->encoding,
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
        result = restore_block(p, first, norma_large_some(p->ply.vertices - first, LARGE_BLOCK));
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
        const size_t count = norma_large_some(p->ply.vertices - first, LARGE_BLOCK);
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

static norma_document_result passes_find_equal(ply_passes *p) {
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
            norma_ply_property(header, p->ply.vertex, header->normal[axis])->type !=
            edit->normals.types[axis];
    if (!result) result = norma_large_output_result(&p->output);
    norma_large_stage(p->file, 0.27, 0.28);
    if (!result) result = norma_large_output_copy(&p->output, header->body, p->ply.vertex->begin);
    p->rows_begin = p->output.written;
    return result;
}

static norma_document_result passes_prepare(ply_passes *p) {
    large_file *file = p->file;
    p->parts = (large_parts){
        .ply = &p->ply, .survey = &p->survey, .core = p->job->policy.core, .share = 1};
    p->parts.core.fallback = NORMA_FALLBACK_ZERO;
    norma_large_stage(file, 0.15, 0.27);
    norma_document_result result = find_anchor(p);
    if (!result) result = passes_find_equal(p);
    if (!result && !norma_large_bits_open(&file->budget, p->ply.vertices, &p->without))
        result = norma_large_fail_memory(file);
    return result;
}

/* ---- all of it */

static norma_document_result copy_whole(ply_passes *p) {
    norma_large_stage(p->file, 0.3, 1);
    return norma_large_output_copy(&p->output, 0, p->file->size);
}

static norma_document_result passes_compute_all(ply_passes *p) {
    large_file *file = p->file;
    norma_document_result result = passes_prepare(p);
    if (!result) result = begin_output(p);
    if (!result) result = run_passes(p, 0.28, 0.9);
    norma_large_stage(file, 0.9, 0.95);
    if (!result) result = norma_large_output_copy(&p->output, p->ply.vertex->end, file->size);
    norma_large_stage(file, 0.95, 1);
    if (!result) result = passes_fill_nearest(p);
    if (!result && p->only_broken) result = restore_unbroken(p);
    norma_large_bits_close(&file->budget, &p->parts.equal);
    norma_large_bits_close(&file->budget, &p->without);
    return result;
}

static norma_document_result passes_compute(ply_passes *p) {
    norma_compute_summary *summary = p->job->policy.summary;
    const norma_only only = p->job->policy.options->only;
    int broken = 0;
    if (p->survey.corners == 0 || (only == NORMA_ONLY_MISSING && p->had)) return copy_whole(p);
    if (p->only_broken) {
        norma_document_result result = passes_find_broken(p, &broken);
        if (result || !broken) return result ? result : copy_whole(p);
    }
    summary->changed = !p->had;
    add_part_count(&summary->report.degenerate_faces, &p->survey.empty, 0);
    return passes_compute_all(p);
}

norma_document_result norma_large_compute_ply(large_compute *job) {
    ply_passes p = {.job = job, .file = job->file};
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
        result = passes_compute(&p);
    }
    result = norma_large_output_close(&p.output, result, job->options->size);
    norma_large_survey_close(&p.ply, &p.survey);
    norma_large_ply_close(&p.ply);
    return result;
}
