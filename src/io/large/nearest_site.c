/* nearest_site.c: the nearest element that has a normal, block by block of elements: in each block
 * as the core finds it, the nearest of all blocks in the end. Ties go to the lower number, as
 * there.
 */
#include "io/large/nearest_site.h"
#include "core/mesh/nearest.h"

enum { BLOCK = 8192, BYTES_FOR_SITE = 96, BYTES_FOR_QUERY = 112, MOST_SITES = 1 << 24 };

typedef struct query_batch {
    const large_sites *sites;
    uint32_t *elements, *sources;
    double *distances;
    size_t count, capacity;
    unsigned char *positions; /* of sites in a block, then of the queries, then of the anchor */
    size_t site_capacity, element_size;
} query_batch;

/* ---- positions */

static norma_document_result read_run(
    const large_sites *sites, size_t first, size_t count, unsigned char *out, size_t size) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t done = 0; done < count && !result; done += BLOCK)
        result = sites->positions(sites->context, first + done,
            count - done < BLOCK ? count - done : BLOCK, out + done * size);
    return result;
}

static unsigned char *query_place(const query_batch *batch, size_t query) {
    return batch->positions + (batch->site_capacity + query) * batch->element_size;
}

static norma_document_result add_query(query_batch *batch, size_t element) {
    const size_t query = batch->count++;
    batch->elements[query] = (uint32_t)element;
    batch->sources[query] = UINT32_MAX;
    batch->distances[query] = 0;
    return batch->sites->positions(batch->sites->context, element, 1, query_place(batch, query));
}

/* ---- one block */

static double distance(const core_mesh *mesh, uint32_t a, uint32_t b) {
    double p[3], q[3], sum = 0;
    norma_core_position(mesh, a, p);
    norma_core_position(mesh, b, q);
    for (int k = 0; k < 3; ++k) sum += (q[k] - p[k]) * (q[k] - p[k]);
    return sum;
}

static void ask(query_batch *batch, core_nearest *nearest, size_t first) {
    for (size_t i = 0; i < batch->count; ++i) {
        const uint32_t position = (uint32_t)(batch->site_capacity + i);
        const uint32_t site = norma_core_nearest_find(nearest, position);
        if (site == UINT32_MAX) continue;
        const double away = distance(nearest->mesh, site, position);
        if (batch->sources[i] != UINT32_MAX && !(away < batch->distances[i])) continue;
        batch->sources[i] = (uint32_t)(first + site);
        batch->distances[i] = away;
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
    if (!result) ask(batch, &nearest, first);
    norma_core_nearest_end(&nearest);
    return result;
}

static norma_document_result search_all(query_batch *batch) {
    const large_sites *sites = batch->sites;
    norma_document_result result = NORMA_DOCUMENT_OK;
    for (size_t first = 0; first < sites->count && !result; first += batch->site_capacity) {
        const size_t left = sites->count - first,
                     count = left < batch->site_capacity ? left : batch->site_capacity;
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
    batch->capacity = capped(left / 4 / BYTES_FOR_QUERY, 64, MOST_SITES);
    if (batch->capacity > sites->count) batch->capacity = sites->count;
    batch->site_capacity = capped(left / 2 / BYTES_FOR_SITE, BLOCK, MOST_SITES);
    if (batch->site_capacity > sites->count) batch->site_capacity = sites->count;
    batch->elements = norma_large_take(budget, batch->capacity, sizeof *batch->elements);
    batch->sources = norma_large_take(budget, batch->capacity, sizeof *batch->sources);
    batch->distances = norma_large_take(budget, batch->capacity, sizeof *batch->distances);
    batch->positions = norma_large_take_zeroed(
        budget, batch->site_capacity + batch->capacity + 1, batch->element_size);
    if (!batch->elements || !batch->sources || !batch->distances || !batch->positions)
        return norma_large_fail_memory(sites->file);
    return sites->anchor == UINT32_MAX ? NORMA_DOCUMENT_OK
                                       : sites->positions(sites->context, sites->anchor, 1,
                                             query_place(batch, batch->capacity));
}

static void close_batch(query_batch *batch) {
    large_budget *budget = &batch->sites->file->budget;
    norma_large_give(budget, batch->elements, batch->capacity, sizeof *batch->elements);
    norma_large_give(budget, batch->sources, batch->capacity, sizeof *batch->sources);
    norma_large_give(budget, batch->distances, batch->capacity, sizeof *batch->distances);
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

norma_document_result norma_large_visit_nearest(
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
