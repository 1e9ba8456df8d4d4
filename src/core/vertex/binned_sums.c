/* binned_sums.c: sums of a range of positions at a time, in memory that stays in the cache: how
 * large such bins are, and which thread works on which. */
#include "core/vertex/vertex.h"
#include <stdatomic.h>

enum {
    LEAST_IN_BIN = 1 << 10,
    MOST_IN_BIN = 1 << 17, /* more than the cache holds gains nothing */
    MOST_BUFFERS = 64,
    SPANS_IN_BIN = 32,
    LEAST_SPANS_IN_BIN = 6,
    BINS_FOR_EACH = 4
};

/* ---- is it worth it */

static double average_span(const core_range *ranges, size_t chunks) {
    double sum = 0;
    for (size_t i = 0; i < chunks; i++) sum += (double)(ranges[i].most - ranges[i].least) + 1;
    return chunks ? sum / (double)chunks : 1;
}

/* So large that few chunks touch two, so small that each who works has some. */
static size_t choose_size(size_t workers, size_t positions, double span, size_t most) {
    const size_t share = positions / (workers * BINS_FOR_EACH);
    size_t size = (size_t)(SPANS_IN_BIN * span);
    if (size > most) size = most - most % CORE_LANES;
    if (workers > 1 && size > share) size = share;
    if ((double)size < LEAST_SPANS_IN_BIN * span) size = (size_t)(LEAST_SPANS_IN_BIN * span);
    if (size < LEAST_IN_BIN) size = LEAST_IN_BIN;
    size = (size + CORE_LANES - 1) / CORE_LANES * CORE_LANES;
    return size < positions ? size : positions;
}

/* Whether chunks are measured for one and a half bins each at most. */
static int is_coherent(const core_bins *bins) {
    size_t touched = 0;
    for (size_t i = 0; i < bins->chunks; i++)
        touched += bins->ranges[i].most / bins->size - bins->ranges[i].least / bins->size + 1;
    return touched <= bins->chunks + bins->chunks / 2 + 1;
}

static size_t lesser_of(size_t a, size_t b) { return a < b ? a : b; }

/* A quarter of all positions at most, however many work. */
static size_t choose_buffers(const core_bins *bins, size_t workers, size_t most) {
    const size_t quarter = lesser_of(MOST_BUFFERS, 1 + (bins->count - 1) / BINS_FOR_EACH),
                 fit = most / bins->size;
    return lesser_of(workers, lesser_of(quarter, fit ? fit : 1));
}

int norma_core_plan_bins(const core_call *call, const core_mesh *mesh, const core_range *ranges,
    core_bin_limits limits, core_bins *bins) {
    const size_t workers = norma_core_shares(call), positions = mesh->positions.count,
                 chunks = norma_core_count_chunks(mesh),
                 most = lesser_of(MOST_IN_BIN, limits.in_one);
    if (!positions) return 0;
    *bins = (core_bins){.mesh = mesh,
        .ranges = ranges,
        .chunks = chunks,
        .size = choose_size(workers, positions, average_span(ranges, chunks), most)};
    bins->count = positions / bins->size + (positions % bins->size != 0);
    bins->buffers = choose_buffers(bins, workers, limits.in_all);
    bins->step =
        call->options.parallel_for || bins->buffers < workers ? bins->buffers : bins->count;
    return bins->size <= most && is_coherent(bins);
}

/* ---- who does what */

typedef struct bin_tasks {
    const core_bins *bins;
    core_bin_work *work;
    void *context;
    atomic_int taken[MOST_BUFFERS]; /* of each buffer */
} bin_tasks;

/* There are as many buffers as ever work at once, so one is free. */
static void work_on_bins(void *context, size_t task) {
    bin_tasks *tasks = context;
    const core_bins *bins = tasks->bins;
    const size_t positions = bins->mesh->positions.count;
    core_bin bin = {.buffer = 0};
    while (atomic_exchange_explicit(&tasks->taken[bin.buffer], 1, memory_order_acquire))
        bin.buffer = (bin.buffer + 1) % bins->buffers;
    for (bin.number = task; bin.number < bins->count; bin.number += bins->step) {
        bin.first = (uint32_t)(bin.number * bins->size);
        bin.count = (uint32_t)lesser_of(positions - bin.first, bins->size);
        tasks->work(tasks->context, &bin);
    }
    atomic_store_explicit(&tasks->taken[bin.buffer], 0, memory_order_release);
}

norma_result norma_core_each_bin(
    core_call *call, const core_bins *bins, core_bin_work *work, void *context) {
    bin_tasks tasks = {bins, work, context, {0}};
    for (size_t i = 0; i < bins->buffers; i++) atomic_init(&tasks.taken[i], 0);
    return norma_core_parallel(call, bins->step, work_on_bins, &tasks);
}

void norma_core_add_to_bin(
    const core_bins *bins, const core_bin *bin, core_add_faces *add, core_adder *adder) {
    for (size_t chunk = norma_core_chunk_of_bin(bins, bin, 0); chunk < bins->chunks;
         chunk = norma_core_chunk_of_bin(bins, bin, chunk + 1)) {
        adder->owns_all = norma_core_bin_owns(bins, bin, chunk);
        norma_core_add_chunk(
            add, adder, chunk * CORE_FACES_IN_CHUNK, norma_core_chunk_end(bins, chunk));
    }
}

/* ---- vertex normals where faces in a row touch positions near each other. Each bin, a range of
 * positions, has its sums in memory that stays in the cache from one bin to the next; the chunks of
 * faces that touch it are added, and its normals written. The sums of all positions, which would be
 * written, read and written, and read again, never reach memory: that alone was 60 of the 100 bytes
 * that a triangle moved. A chunk that touches two bins is measured for both. */

enum { AT_ONCE = 64 };

typedef struct bin_work {
    const core_prepared_mesh *prepared;
    core_bins bins;
    const core_output *output;
    core_add_faces *add;
    core_finish_sums *finish;
    core_tally *tallies; /* of each bin */
    vertex_sum *sums;    /* buffers of bins.size each */
} bin_work;

/* ---- a bin */

static void write_one(
    const bin_work *work, const vertex_sum *sum, size_t vertex, core_tally *tally) {
    float normal[3];
    const int reason = norma_core_resolve_record(&work->prepared->mesh, sum, vertex, normal);
    norma_core_write_element(work->output, vertex, reason, normal, tally);
}

static void write_bin(
    const bin_work *work, const vertex_sum *sums, size_t first, size_t count, core_tally *tally) {
    float normals[AT_ONCE][3];
    size_t held = 0, v = 0; /* normals[0 .. held) are of the vertices before v */
    while (v < count) {
        if (count - v >= CORE_LANES && work->finish(sums + v, normals + held)) {
            held += CORE_LANES;
            v += CORE_LANES;
            if (held < AT_ONCE) continue;
        }
        norma_core_write_normals(work->output, first + v - held, held, (const float(*)[3])normals);
        if (held < AT_ONCE)
            for (size_t end = count - v < CORE_LANES ? count : v + CORE_LANES; v < end; v++)
                write_one(work, &sums[v], first + v, tally);
        held = 0;
    }
    norma_core_write_normals(work->output, first + v - held, held, (const float(*)[3])normals);
}

static void compute_bin(void *context, const core_bin *bin) {
    const bin_work *work = context;
    const core_prepared_mesh *prepared = work->prepared;
    vertex_sum *sums = work->sums + bin->buffer * work->bins.size;
    core_tally *tally = &work->tallies[bin->number];
    core_face_adder face_adder = {prepared, sums, bin->first, bin->count, &tally->degenerate};
    core_adder adder = {.mesh = &prepared->mesh,
        .weight = prepared->call->options.weight,
        .sums = sums,
        .first = bin->first,
        .count = bin->count,
        .add_face = norma_core_add_face,
        .context = &face_adder};
    norma_core_clear_sums(sums, bin->count);
    norma_core_add_to_bin(&work->bins, bin, work->add, &adder);
    write_bin(work, sums, bin->first, bin->count, tally);
}

static norma_result compute_all(bin_work *work, core_tally *sum) {
    memset(work->tallies, 0, work->bins.count * sizeof *work->tallies);
    const norma_result result =
        norma_core_each_bin(work->prepared->call, &work->bins, compute_bin, work);
    for (size_t i = 0; i < work->bins.count; i++) norma_core_tally_add(sum, &work->tallies[i]);
    return result;
}

norma_result norma_core_bin_vertices(core_prepared_mesh *prepared, const core_range *ranges,
    const core_output *output, core_tally *tally, int *written) {
    core_call *call = prepared->call;
    const core_mesh *mesh = &prepared->mesh;
    bin_work work = {.prepared = prepared,
        .output = output,
        .add = mesh->face_starts ? norma_core_choose_add_polygons(call->options.isa)
                                 : norma_core_choose_add(call->options.isa),
        .finish = norma_core_choose_finish(call->options.isa)};
    *written = 0;
    if (mesh->weld || call->options.weight == NORMA_WEIGHT_VISIBLE ||
        !norma_core_plan_bins(
            call, mesh, ranges, (core_bin_limits){SIZE_MAX, SIZE_MAX}, &work.bins))
        return NORMA_OK;
    const size_t records = work.bins.buffers * work.bins.size;
    work.sums = norma_core_allocate(call, records, sizeof *work.sums);
    work.tallies = norma_core_allocate(call, work.bins.count, sizeof *work.tallies);
    norma_result result =
        work.sums && work.tallies ? compute_all(&work, tally) : NORMA_ERROR_MEMORY;
    norma_core_release(call, work.sums, records, sizeof *work.sums);
    norma_core_release(call, work.tallies, work.bins.count, sizeof *work.tallies);
    norma_core_count_add(&tally->degenerate, &prepared->degenerate_faces);
    *written = 1;
    return result;
}
