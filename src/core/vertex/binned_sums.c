/* binned_sums.c: vertex normals where faces in a row touch positions near each other. Each bin, a
 * range of positions, has its sums in memory that stays in the cache from one bin to the next; the
 * chunks of faces that touch it are added, and its normals written. The sums of all positions,
 * which would be written, read and written, and read again, never reach memory: that alone was 60
 * of the 100 bytes that a triangle moved. A chunk that touches two bins is measured for both. */
#include "core/vertex/add_polygons.h"
#include <stdatomic.h>

enum {
    LEAST_IN_BIN = 1 << 10,
    MOST_IN_BIN = 1 << 17,
    MOST_BUFFERS = 64,
    BUFFERS_FOR_JOBS = 8,
    AT_ONCE = 64,
    SPANS_IN_BIN = 32,
    LEAST_SPANS_IN_BIN = 6,
    BINS_FOR_EACH = 4
};

typedef struct bin_work {
    const core_prepared_mesh *prepared;
    const core_range *ranges;
    const core_output *output;
    core_add_faces *add;
    core_finish_sums *finish;
    core_tally *tallies; /* of each bin */
    vertex_sum *sums;    /* buffers of bin_size each */
    atomic_int *taken;   /* of each buffer */
    size_t chunks, bins, bin_size, buffers;
    size_t
        step; /* each task takes every step-th bin: never are more at work than there are buffers */
} bin_work;

/* ---- is it worth it */

static size_t count_chunks(const core_mesh *mesh) {
    return mesh->face_count / CORE_FACES_IN_CHUNK + (mesh->face_count % CORE_FACES_IN_CHUNK != 0);
}

static double average_span(const core_range *ranges, size_t chunks) {
    double sum = 0;
    for (size_t i = 0; i < chunks; i++) sum += (double)(ranges[i].most - ranges[i].least) + 1;
    return chunks ? sum / (double)chunks : 1;
}

/* So large that few chunks touch two, so small that each who works has some. */
static size_t choose_bin_size(const core_call *call, size_t positions, double span) {
    const size_t workers = call->options.parallel_for ? BUFFERS_FOR_JOBS : norma_core_workers(call),
                 share = positions / (workers * BINS_FOR_EACH);
    size_t size = (size_t)(SPANS_IN_BIN * span);
    if (size > MOST_IN_BIN) size = MOST_IN_BIN;
    if (workers > 1 && size > share) size = share;
    if ((double)size < LEAST_SPANS_IN_BIN * span) size = (size_t)(LEAST_SPANS_IN_BIN * span);
    if (size < LEAST_IN_BIN) size = LEAST_IN_BIN;
    size = (size + CORE_LANES - 1) / CORE_LANES * CORE_LANES;
    return size < positions ? size : positions;
}

/* Whether chunks are measured for one and a half bins each at most. */
static int is_coherent(const core_range *ranges, size_t chunks, size_t bin_size) {
    size_t touched = 0;
    for (size_t i = 0; i < chunks; i++)
        touched += ranges[i].most / bin_size - ranges[i].least / bin_size + 1;
    return touched <= chunks + chunks / 2 + 1;
}

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

static void compute_bin(const bin_work *work, size_t bin, vertex_sum *sums) {
    const core_prepared_mesh *prepared = work->prepared;
    const size_t first = bin * work->bin_size, positions = prepared->mesh.positions.count,
                 count = positions - first < work->bin_size ? positions - first : work->bin_size;
    core_face_adder face_adder = {
        prepared, sums, (uint32_t)first, (uint32_t)count, &work->tallies[bin].degenerate};
    core_adder adder = {&prepared->mesh, prepared->call->options.weight, sums, (uint32_t)first,
        (uint32_t)count, 0, 0, 0, 0, norma_core_add_face, &face_adder};
    norma_core_clear_sums(sums, count);
    for (size_t chunk = 0; chunk < work->chunks; chunk++) {
        if (work->ranges[chunk].least >= first + count || work->ranges[chunk].most < first)
            continue;
        const size_t begin = chunk * CORE_FACES_IN_CHUNK, faces = prepared->mesh.face_count;
        adder.owns_all =
            work->ranges[chunk].least >= first && work->ranges[chunk].most < first + count;
        norma_core_add_chunk(work->add, &adder, begin,
            faces - begin < CORE_FACES_IN_CHUNK ? faces : begin + CORE_FACES_IN_CHUNK);
    }
    write_bin(work, sums, first, count, &work->tallies[bin]);
}

/* There are as many buffers as ever work at once, so one is free. */
static void compute_bins(void *context, size_t task) {
    const bin_work *work = context;
    size_t buffer = 0;
    while (atomic_exchange_explicit(&work->taken[buffer], 1, memory_order_acquire))
        buffer = (buffer + 1) % work->buffers;
    for (size_t bin = task; bin < work->bins; bin += work->step)
        compute_bin(work, bin, work->sums + buffer * work->bin_size);
    atomic_store_explicit(&work->taken[buffer], 0, memory_order_release);
}

static norma_result compute_all(bin_work *work, core_tally *sum) {
    core_call *call = work->prepared->call;
    atomic_int taken[MOST_BUFFERS];
    work->taken = taken;
    for (size_t i = 0; i < work->buffers; i++) atomic_init(&taken[i], 0);
    memset(work->tallies, 0, work->bins * sizeof *work->tallies);
    const norma_result result = norma_core_parallel(call, work->step, compute_bins, work);
    for (size_t i = 0; i < work->bins; i++) norma_core_tally_add(sum, &work->tallies[i]);
    return result;
}

static size_t smaller(size_t a, size_t b) { return a < b ? a : b; }

norma_result norma_core_bin_vertices(core_prepared_mesh *prepared, const core_range *ranges,
    const core_output *output, core_tally *tally, int *done) {
    core_call *call = prepared->call;
    const core_mesh *mesh = &prepared->mesh;
    const size_t positions = mesh->positions.count, chunks = count_chunks(mesh);
    *done = 0;
    if (mesh->weld || call->options.weight == NORMA_WEIGHT_VISIBLE || !positions) return NORMA_OK;
    const size_t bin_size = choose_bin_size(call, positions, average_span(ranges, chunks)),
                 bins = positions / bin_size + (positions % bin_size != 0);
    if (!is_coherent(ranges, chunks, bin_size) || bin_size > MOST_IN_BIN)
        return NORMA_OK; /* bins larger than the cache gain nothing */
    const size_t workers = call->options.parallel_for ? BUFFERS_FOR_JOBS : norma_core_workers(call);
    const size_t buffers = smaller(smaller(workers, MOST_BUFFERS),
        1 + (bins - 1) / BINS_FOR_EACH); /* a quarter of all sums, however many work */
    bin_work work = {.prepared = prepared,
        .ranges = ranges,
        .output = output,
        .add = mesh->face_starts ? norma_core_choose_add_polygons(call->options.isa)
                                 : norma_core_choose_add(call->options.isa),
        .chunks = chunks,
        .bins = bins,
        .bin_size = bin_size,
        .finish = norma_core_choose_finish(call->options.isa),
        .buffers = buffers,
        .step = call->options.parallel_for || buffers < workers ? buffers : bins};
    work.sums = norma_core_allocate(call, buffers * bin_size, sizeof *work.sums);
    work.tallies = norma_core_allocate(call, bins, sizeof *work.tallies);
    norma_result result =
        work.sums && work.tallies ? compute_all(&work, tally) : NORMA_ERROR_MEMORY;
    norma_core_release(call, work.sums, buffers * bin_size, sizeof *work.sums);
    norma_core_release(call, work.tallies, bins, sizeof *work.tallies);
    norma_core_count_add(&tally->degenerate, &prepared->degenerate_faces);
    /* Who has no normal and takes the nearest has to find it among all sums. */
    *done = !(output->nearest &&
              tally->non_finite.count + tally->unreferenced.count + tally->cancelled.count);
    return result;
}
