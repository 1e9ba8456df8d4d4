/* vertex_normals.c: the weighted sums at all positions, and the normals that they become: range of
 * positions by range, each with the faces that touch it (bins), from the corners to the output, or
 * all sums kept. The groups of a plan are summed by the same two (norma_core_sum_bins,
 * norma_core_sum_all). The kernels of add_kernel.template.h add most faces and finish most sums;
 * here is what they leave. Begin at norma_vertex_normals, at the end: sums or cones first; then
 * each vertex takes what became of its position, or of itself, and is written. */
#include "core/vertex/vertex.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"
#include <stdatomic.h>

void norma_core_clear_sums(core_vertex_sum *sums, size_t count) {
    for (size_t i = 0; i < count; ++i) sums[i] = (core_vertex_sum){0, 0, 0, -0.0};
}

/* ---- one face added by itself, a polygon or a triangle that doubles do not decide: what the
 * kernels call back for (core_adder's add_alone). Corners elsewhere than at the count positions
 * from first on are passed over. The first corner's owner counts the degenerate. */

typedef struct lone_adder {
    const core_voting *voting;
    core_vertex_sum *sums;
    uint32_t first, count;
    norma_count *degenerate;
} lone_adder;

static uint32_t sum_of_corner(const core_voting *voting, size_t corner) {
    return voting->targets ? voting->targets[corner]
                           : norma_core_welded_corner(voting->mesh, corner);
}

static void add_alone(void *context, size_t f) {
    const lone_adder *adder = context;
    const core_voting *voting = adder->voting;
    const core_mesh *mesh = voting->mesh;
    const size_t begin = norma_core_face_begin(mesh, f), end = norma_core_face_end(mesh, f);
    core_face face;
    norma_core_face_geometry(mesh, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) {
        const uint32_t sum = begin < end ? sum_of_corner(voting, begin) : UINT32_MAX;
        if ((face.flags & CORE_FACE_FINITE) && sum - adder->first < adder->count &&
            (!voting->counts || voting->counts(voting->context, sum)))
            norma_core_count_one(adder->degenerate, f);
        return;
    }
    for (size_t c = begin; c < end; ++c) {
        const uint32_t sum = sum_of_corner(voting, c) - adder->first;
        if (sum >= adder->count || !norma_core_is_kept(mesh, f, c)) continue;
        norma_core_add_vote(&adder->sums[sum],
            norma_core_corner_weight(mesh, voting->call->options.weight, f, &face, c), face.normal);
    }
}

static void sum_of(const core_vertex_sum *s, double sum[3]) {
    sum[0] = s->x;
    sum[1] = s->y;
    sum[2] = s->z;
}

static int core_record_cancels(const core_vertex_sum *s) {
    double sum[3];
    sum_of(s, sum);
    return norma_core_has_votes(s) && norma_core_cancels(sum, s->weight);
}

/* Returns NORMA_REASON_NONE and the normal, or the reason why it has no normal. */
static int core_resolve_record(
    const core_mesh *mesh, const core_vertex_sum *s, size_t vertex, float normal[3]) {
    double sum[3];
    if (!norma_core_has_votes(s)) {
        norma_core_position(mesh, (uint32_t)vertex, sum);
        return norma_core_finite(sum) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    }
    sum_of(s, sum);
    if (norma_core_cancels(sum, s->weight)) return NORMA_REASON_CANCELLED;
    norma_core_direction(sum, normal);
    return NORMA_REASON_NONE;
}

/* ---- work on ranges of positions, each with all faces that touch it, where faces in a row touch
 * positions near each other. What is kept of a range's positions lies in memory that stays in the
 * cache from one range to the next. A chunk of faces that touches two ranges is measured for both.
 */

typedef struct core_bins {
    const core_mesh *mesh;
    const core_range *ranges; /* of positions, of each chunk of faces */
    size_t chunks;
    size_t first, positions; /* those that there are bins for */
    size_t count, size;      /* bins; positions in each but the last */
    size_t buffers;          /* at most so many are worked on at once */
    size_t step;             /* each task takes every step-th bin */
} core_bins;

typedef struct core_bin {
    size_t number, buffer; /* buffer: below bins->buffers, nobody else's */
    uint32_t first, count; /* positions */
} core_bin;
typedef void core_bin_work(void *context, const core_bin *bin);

/* The next chunk, from this one on, that touches the bin; bins->chunks: none. */
static size_t core_chunk_of_bin(const core_bins *bins, const core_bin *bin, size_t chunk) {
    const uint32_t last = bin->first + (bin->count - 1);
    while (chunk < bins->chunks &&
           (bins->ranges[chunk].least > last || bins->ranges[chunk].most < bin->first))
        ++chunk;
    return chunk;
}
static int core_bin_owns(const core_bins *bins, const core_bin *bin, size_t chunk) {
    return bins->ranges[chunk].least >= bin->first &&
           bins->ranges[chunk].most - bin->first < bin->count;
}
static size_t core_chunk_end(const core_bins *bins, size_t chunk) {
    const size_t begin = chunk * CORE_FACES_IN_CHUNK, faces = bins->mesh->face_count;
    return faces - begin < CORE_FACES_IN_CHUNK ? faces : begin + CORE_FACES_IN_CHUNK;
}

typedef struct core_chunks {
    size_t begin, end;
} core_chunks;

/* ---- how large such bins are, and which thread works on which */

enum {
    LEAST_IN_BIN = 1 << 10,
    MOST_IN_BIN = 1 << 17, /* more than the cache holds gains nothing */
    MOST_BUFFERS = 64,
    SPANS_IN_BIN = 32,
    LEAST_SPANS_IN_BIN = 6,
    LEAST_SPANS_SHARED = 4, /* where several work: a few more chunks touch two */
    BINS_FOR_EACH = 4
};

/* ---- is it worth it */

static double average_span(const core_range *ranges, size_t chunks) {
    double sum = 0;
    for (size_t i = 0; i < chunks; ++i) sum += (double)(ranges[i].most - ranges[i].least) + 1;
    return chunks ? sum / (double)chunks : 1;
}

/* What one thread takes. */
static size_t size_alone(size_t positions, double span) {
    size_t size = (size_t)(SPANS_IN_BIN * span);
    if (size > MOST_IN_BIN) size = MOST_IN_BIN;
    if (size < LEAST_IN_BIN) size = LEAST_IN_BIN;
    return size < positions ? size : positions;
}

/* So large that few chunks touch two, so small that each who works has some. */
static size_t choose_size(size_t workers, size_t positions, double span, size_t alone) {
    const size_t share = positions / (workers * BINS_FOR_EACH);
    size_t size = alone;
    if (workers > 1 && size > share) size = share;
    const double least = (workers > 1 ? LEAST_SPANS_SHARED : LEAST_SPANS_IN_BIN) * span;
    if ((double)size < least) size = (size_t)least;
    if (size < LEAST_IN_BIN) size = LEAST_IN_BIN;
    size = (size + CORE_LANES - 1) / CORE_LANES * CORE_LANES;
    return size < positions ? size : positions;
}

/* Whether chunks are measured for so many bins each at most. */
static int is_coherent(const core_bins *bins, double most) {
    size_t touched = 0;
    for (size_t i = 0; i < bins->chunks; ++i)
        touched += bins->ranges[i].most / bins->size - bins->ranges[i].least / bins->size + 1;
    return (double)touched <= most * (double)bins->chunks + 1;
}

static size_t lesser_of(size_t a, size_t b) { return a < b ? a : b; }

/* One for each who works, as far as they are together a quarter of all positions at most, or no
 * more than one thread takes. */
static size_t choose_buffers(const core_bins *bins, size_t workers, size_t alone) {
    const size_t quarter = 1 + (bins->count - 1) / BINS_FOR_EACH, as_alone = alone / bins->size,
                 useful = quarter > as_alone ? quarter : as_alone;
    return lesser_of(lesser_of(workers, MOST_BUFFERS), useful);
}

/* 0: the mesh is in no such order, and bins are not worth it. */
static int core_plan_bins(const core_voting *voting, core_bins *bins) {
    const core_call *call = voting->call;
    const size_t workers = norma_core_shares(call), positions = voting->count,
                 chunks = norma_core_count_chunks(voting->mesh);
    const double span = average_span(voting->ranges, chunks);
    const size_t alone = size_alone(positions, span);
    if (!positions) return 0;
    *bins = (core_bins){.mesh = voting->mesh,
        .ranges = voting->ranges,
        .chunks = chunks,
        .first = voting->first,
        .positions = positions,
        .size = choose_size(workers, positions, span, alone)};
    bins->count = positions / bins->size + (positions % bins->size != 0);
    bins->buffers = choose_buffers(bins, workers, alone);
    bins->step =
        call->options.parallel_for || bins->buffers < workers ? bins->buffers : bins->count;
    return bins->size <= MOST_IN_BIN && is_coherent(bins, 1.5);
}

/* ---- who does what */

typedef struct bin_tasks {
    const core_bins *bins;
    core_bin_work *work;
    void *context;
    atomic_int taken[MOST_BUFFERS]; /* of each buffer */
} bin_tasks;

/* From its number its positions. */
static void set_bin(const core_bins *bins, core_bin *bin) {
    const size_t begin = bin->number * bins->size;
    bin->first = (uint32_t)(bins->first + begin);
    bin->count = (uint32_t)lesser_of(bins->positions - begin, bins->size);
}

/* There are as many buffers as ever work at once, so one is free. */
static void work_on_bins(void *context, size_t task) {
    bin_tasks *tasks = context;
    const core_bins *bins = tasks->bins;
    core_bin bin = {.buffer = 0};
    while (atomic_exchange_explicit(&tasks->taken[bin.buffer], 1, memory_order_acquire))
        bin.buffer = (bin.buffer + 1) % bins->buffers;
    for (bin.number = task; bin.number < bins->count; bin.number += bins->step) {
        set_bin(bins, &bin);
        tasks->work(tasks->context, &bin);
    }
    atomic_store_explicit(&tasks->taken[bin.buffer], 0, memory_order_release);
}

/* All bins; MEMORY never, CANCELLED: some were left out. */
static norma_result core_each_bin(
    core_call *call, const core_bins *bins, core_bin_work *work, void *context) {
    bin_tasks tasks = {bins, work, context, {0}};
    for (size_t i = 0; i < bins->buffers; ++i) atomic_init(&tasks.taken[i], 0);
    return norma_core_parallel(call, bins->step, work_on_bins, &tasks);
}

/* ---- who adds what */

enum { FACES_TO_WIDEN = 256 };

static void add_widened(
    const core_kernels *kernels, const core_adder *adder, size_t begin, size_t end) {
    uint32_t corners[3 * FACES_TO_WIDEN];
    core_mesh mesh = *adder->mesh;
    core_adder wide = *adder;
    mesh.corner_count = 3 * (end - begin);
    norma_core_read_corners(&mesh, 3 * begin, mesh.corner_count, corners);
    mesh.corners = corners;
    mesh.corner_size = sizeof *corners;
    wide.mesh = &mesh;
    wide.first_face = begin;
    kernels->add_triangles(&wide, 0, end - begin);
}

/* The mesh's faces from begin to before end. Corners of triangles of other than 32 bits are made so
 * first, so that one loop is enough. */
static void add_faces_of_mesh(
    const core_kernels *kernels, const core_adder *adder, size_t begin, size_t end) {
    if (norma_core_face_starts(adder->mesh)) {
        kernels->add_polygons(adder, begin, end);
        return;
    }
    if (adder->mesh->corner_size == sizeof(uint32_t)) {
        kernels->add_triangles(adder, begin, end);
        return;
    }
    for (size_t f = begin; f < end; f += FACES_TO_WIDEN)
        add_widened(kernels, adder, f, end - f < FACES_TO_WIDEN ? end : f + FACES_TO_WIDEN);
}

/* Adds all faces of some chunks that touch the bin; sums, first and count of the adder are its. */
static void core_add_to_bin(const core_kernels *kernels, const core_bins *bins, const core_bin *bin,
    core_chunks chunks, core_adder *adder) {
    adder->first = bin->first;
    adder->count = bin->count;
    for (size_t chunk = core_chunk_of_bin(bins, bin, chunks.begin); chunk < chunks.end;
         chunk = core_chunk_of_bin(bins, bin, chunk + 1)) {
        adder->owns_all = core_bin_owns(bins, bin, chunk);
        add_faces_of_mesh(kernels, adder, chunk * CORE_FACES_IN_CHUNK, core_chunk_end(bins, chunk));
    }
}

/* Votes, into the sums of the bin. */
static void add_votes_of_bin(const core_voting *voting, const core_bins *bins, const core_bin *bin,
    core_chunks chunks, int scattered, core_vertex_sum *sums, norma_count *degenerate) {
    lone_adder lone = {voting, sums, bin->first, bin->count, degenerate};
    core_adder adder = {.mesh = voting->mesh,
        .targets = voting->targets,
        .weight = voting->call->options.weight,
        .sums = sums,
        .scattered = scattered,
        .by_distance = voting->by_distance,
        .add_alone = add_alone,
        .context = &lone};
    if (!chunks.begin) norma_core_clear_sums(sums, bin->count);
    core_add_to_bin(norma_core_kernels(voting->call->level), bins, bin, chunks, &adder);
}

/* ---- vertex normals where faces in a row touch positions near each other. Each bin, a range of
 * positions, has its sums in memory that stays in the cache from one bin to the next; the chunks of
 * faces that touch it are added, and its normals written. The sums of all positions, which would be
 * written, read and written, and read again, never reach memory: that alone was 60 of the 100 bytes
 * that a triangle moved. A chunk that touches two bins is measured for both. */

typedef struct bin_work {
    const core_voting *voting;
    core_bins bins;
    core_sums_receiver *receive;
    void *context;
    core_vertex_sum *sums;            /* buffers of bins.size each */
    core_tally tallies[MOST_BUFFERS]; /* of each buffer */
} bin_work;

static void sum_bin(void *context, const core_bin *bin) {
    bin_work *work = context;
    core_vertex_sum *sums = work->sums + bin->buffer * work->bins.size;
    core_tally *tally = &work->tallies[bin->buffer];
    add_votes_of_bin(work->voting, &work->bins, bin, (core_chunks){0, work->bins.chunks}, 0, sums,
        &tally->degenerate);
    work->receive(work->context, sums, bin->first, bin->count, tally);
}

norma_result norma_core_sum_bins(const core_voting *voting, core_vertex_sum *sums,
    core_sums_receiver *receive, void *context, core_tally *tally, int *taken) {
    bin_work work = {.voting = voting, .receive = receive, .context = context, .sums = sums};
    *taken = 0;
    if (!core_plan_bins(voting, &work.bins)) return NORMA_OK;
    const size_t records = work.bins.buffers * work.bins.size;
    if (sums && records > voting->count) work.bins.buffers = work.bins.step = 1;
    if (!sums) work.sums = norma_core_allocate(voting->call, records, sizeof *sums);
    const norma_result result =
        work.sums ? core_each_bin(voting->call, &work.bins, sum_bin, &work) : NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < work.bins.buffers; ++i) norma_core_tally_add(tally, &work.tallies[i]);
    if (!sums) norma_core_release(voting->call, work.sums, records, sizeof *sums);
    *taken = 1;
    return result;
}

/* ---- the same, its normals written: those of a bin as it is taken */

enum { AT_ONCE = 64 };

typedef struct bin_output {
    const core_mesh *mesh;
    const core_output *output;
    const core_kernels *kernels;
} bin_output;

static void write_one(
    const bin_output *work, const core_vertex_sum *sum, size_t vertex, core_tally *tally) {
    float normal[3];
    const int reason = core_resolve_record(work->mesh, sum, vertex, normal);
    norma_core_write_element(work->output, vertex, reason, normal, tally);
}

static void write_bin(
    void *context, const core_vertex_sum *sums, size_t first, size_t count, core_tally *tally) {
    const bin_output *work = context;
    float normals[AT_ONCE][3];
    size_t held = 0, v = 0; /* normals[0 .. held) are of the vertices before v */
    while (v < count) {
        if (count - v >= CORE_LANES && work->kernels->finish(sums + v, normals + held)) {
            held += CORE_LANES;
            v += CORE_LANES;
            if (held < AT_ONCE) continue;
        }
        norma_core_write_normals(work->output, first + v - held, held, (const float(*)[3])normals);
        if (held < AT_ONCE)
            for (size_t end = count - v < CORE_LANES ? count : v + CORE_LANES; v < end; ++v)
                write_one(work, &sums[v], first + v, tally);
        held = 0;
    }
    norma_core_write_normals(work->output, first + v - held, held, (const float(*)[3])normals);
}

static core_voting voting_of(const core_prepared_mesh *prepared, core_range *ranges) {
    return (core_voting){.call = prepared->call,
        .mesh = &prepared->mesh,
        .ranges = ranges,
        .count = prepared->mesh.positions.count,
        .by_distance = norma_core_welds_near(prepared->call)};
}

/* *written: whether it could be done bin by bin, and all but what takes the nearest normal is
 * written. */
static norma_result bin_vertices(core_prepared_mesh *prepared, core_range *ranges,
    const core_output *output, core_tally *tally, int *written) {
    const core_voting voting = voting_of(prepared, ranges);
    bin_output to = {&prepared->mesh, output, norma_core_kernels(prepared->call->level)};
    *written = 0;
    if (prepared->mesh.weld || norma_core_sees(prepared->call)) return NORMA_OK;
    const norma_result result = norma_core_sum_bins(&voting, NULL, write_bin, &to, tally, written);
    if (*written) norma_core_count_add(&tally->degenerate, &prepared->degenerate_faces);
    return result;
}

/* ---- the weighted sum at each position, kept. Faces are gone through in ascending order, and each
 * adds to the sums of its corners; when several work, each owns a range of positions and passes
 * over the chunks of faces that do not touch it. So every sum is taken in the same order by any
 * number of threads. */

enum { FEWEST_FACES_TO_SHARE = 1 << 15, MOST_RANGES = 64, STEPS = 32 };

typedef struct sum_work {
    const core_voting *voting;
    core_vertex_sum *sums;
    core_bins bins; /* one for each who works */
    int scattered;
    core_chunks step;
    norma_count degenerate[MOST_RANGES];
} sum_work;

static void find_range(void *context, size_t chunk) {
    const core_voting *voting = context;
    const core_mesh *mesh = voting->mesh;
    core_range touched = {UINT32_MAX, 0};
    const size_t face = chunk * CORE_FACES_IN_CHUNK, left = mesh->face_count - face,
                 begin = norma_core_face_begin(mesh, face),
                 end = norma_core_face_begin(mesh, face + lesser_of(left, CORE_FACES_IN_CHUNK));
    for (size_t c = begin; c < end; ++c) {
        const uint32_t sum = sum_of_corner(voting, c);
        touched.least = sum < touched.least ? sum : touched.least;
        touched.most = sum > touched.most ? sum : touched.most;
    }
    voting->ranges[chunk] = touched;
}

norma_result norma_core_find_ranges(const core_voting *voting) {
    core_voting each = *voting;
    return norma_core_parallel(
        voting->call, norma_core_count_chunks(voting->mesh), find_range, &each);
}

static void sum_range(void *context, size_t number) {
    sum_work *work = context;
    const core_bins *bins = &work->bins;
    core_bin bin = {.number = number};
    set_bin(bins, &bin);
    add_votes_of_bin(work->voting, bins, &bin, work->step, work->scattered,
        work->sums + number * bins->size, &work->degenerate[number]);
}

static void divide_into_ranges(core_bins *bins, size_t sharing) {
    bins->size = bins->positions / sharing + 1;
    bins->count = bins->positions / bins->size + (bins->positions % bins->size != 0);
}

/* In steps where somebody is told of progress: who owns a range is done with it only at the end. */
static norma_result sum_ranges(sum_work *work) {
    core_call *call = work->voting->call;
    core_bins *bins = &work->bins;
    const double begin = call->progress_from, to = call->progress_to,
                 from = begin + 0.1 * (to - begin);
    const size_t steps = call->options.progress ? lesser_of(STEPS, 1 + bins->chunks / 8) : 1;
    norma_result result = NORMA_OK;
    norma_core_stage(call, begin, from);
    if (bins->count > 1 && bins->mesh->weld && !work->voting->targets)
        result = norma_core_find_ranges(work->voting);
    /* Faces in no order are measured by each who works, for some of their corners: two threads took
     * twice to four times as long as one, and no less where memory was waited for at each corner.
     */
    if (bins->count > 1 && !result && !is_coherent(bins, 0.75 * (double)bins->count))
        divide_into_ranges(bins, 1);
    for (size_t step = 0; step < steps && !result; ++step) {
        work->step = (core_chunks){bins->chunks * step / steps, bins->chunks * (step + 1) / steps};
        norma_core_stage(call, from + (to - from) * (double)step / (double)steps,
            from + (to - from) * (double)(step + 1) / (double)steps);
        result = norma_core_parallel(call, bins->count, sum_range, work);
    }
    norma_core_stage(call, begin, to);
    return result;
}

static size_t ranges_for(const core_voting *voting) {
    const core_call *call = voting->call;
    if (!call->options.parallel_for && voting->mesh->face_count < FEWEST_FACES_TO_SHARE) return 1;
    const size_t shares = norma_core_shares(call);
    return shares < MOST_RANGES ? shares : MOST_RANGES;
}

norma_result norma_core_sum_all(
    const core_voting *voting, core_vertex_sum *sums, core_tally *tally) {
    sum_work work = {.voting = voting,
        .sums = sums,
        .bins = {.mesh = voting->mesh,
            .ranges = voting->ranges,
            .chunks = norma_core_count_chunks(voting->mesh),
            .first = voting->first,
            .positions = voting->count},
        .scattered = norma_core_is_scattered(voting->mesh)};
    divide_into_ranges(&work.bins, ranges_for(voting));
    const norma_result result = sum_ranges(&work);
    for (size_t i = 0; i < work.bins.count; ++i)
        norma_core_count_add(&tally->degenerate, &work.degenerate[i]);
    return result;
}

/* ---- what becomes of each vertex, by sums or by cones, before it is written. */

typedef struct core_vertices {
    core_prepared_mesh *prepared;
    size_t count;          /* vertices */
    core_vertex_sum *sums; /* of positions */
    uint32_t *own; /* NULL where nothing cancels; else of each vertex its number in own_sums,
                      UINT32_MAX: its position's sum stands */
    core_vertex_sum *own_sums; /* of the corners of one vertex alone */
    size_t own_count;
    float (*normals)[3]; /* of cones, instead of sums: of positions, and of vertices with a result
                            of their own */
    uint8_t *reasons;
} core_vertices;

static void release_vertices(core_vertices *vertices) {
    const core_call *call = vertices->prepared->call;
    norma_core_release(call, vertices->sums, vertices->count, sizeof *vertices->sums);
    norma_core_release(call, vertices->own, vertices->count, sizeof *vertices->own);
    norma_core_release(call, vertices->own_sums, vertices->own_count, sizeof *vertices->own_sums);
    norma_core_release(call, vertices->normals, vertices->count, sizeof *vertices->normals);
    norma_core_release(call, vertices->reasons, vertices->count, 1);
    *vertices = (core_vertices){.prepared = vertices->prepared};
}

/* ---- sums that cancel: once more, over the corners of each vertex alone */

static void add_own(core_vertices *vertices, size_t f) {
    const core_prepared_mesh *prepared = vertices->prepared;
    const core_mesh *mesh = &prepared->mesh;
    core_face face;
    norma_core_prepared_mesh_face(prepared, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) return;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c) {
        const uint32_t number = vertices->own[norma_core_corner(mesh, c)];
        if (number == UINT32_MAX || !norma_core_is_kept(mesh, f, c)) continue;
        norma_core_add_vote(&vertices->own_sums[number],
            norma_core_corner_weight(mesh, prepared->call->options.weight, f, &face, c),
            face.normal);
    }
}

static void add_own_triangles(core_vertices *vertices, const size_t *faces, size_t count) {
    const core_prepared_mesh *prepared = vertices->prepared;
    core_batch b;
    if (!count) return;
    const unsigned decided = norma_core_measure_triangles(
        prepared->call, &prepared->mesh, prepared->call->options.weight, faces, count, &b);
    for (size_t i = 0; i < count; ++i) {
        const double normal[3] = {b.normal[0][i], b.normal[1][i], b.normal[2][i]};
        if (!(decided >> i & 1U)) add_own(vertices, faces[i]);
        for (size_t k = 0; k < 3 && (decided >> i & 1U); ++k) {
            const uint32_t number =
                vertices->own[norma_core_corner(&prepared->mesh, 3 * faces[i] + k)];
            if (number != UINT32_MAX)
                norma_core_add_vote(&vertices->own_sums[number], b.weight[k][i], normal);
        }
    }
}

static int touches_own(const core_vertices *vertices, size_t f) {
    const core_mesh *mesh = &vertices->prepared->mesh;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c)
        if (vertices->own[norma_core_corner(mesh, c)] != UINT32_MAX) return 1;
    return 0;
}

/* Triangles eight at a time, with the bits that they have in all other sums. */
static void add_all_own(core_vertices *vertices) {
    const core_mesh *mesh = &vertices->prepared->mesh;
    size_t faces[CORE_LANES], count = 0;
    for (size_t f = 0; f < mesh->face_count; ++f) {
        if (!touches_own(vertices, f)) continue;
        if (norma_core_face_starts(mesh))
            add_own(vertices, f);
        else
            faces[count++] = f;
        if (count < CORE_LANES) continue;
        add_own_triangles(vertices, faces, count);
        count = 0;
    }
    add_own_triangles(vertices, faces, count);
}

static norma_result sum_own(core_vertices *vertices) {
    const core_call *call = vertices->prepared->call;
    const core_mesh *mesh = &vertices->prepared->mesh;
    size_t cancelled = 0;
    if (!mesh->weld) return NORMA_OK; /* a position has the corners of one vertex */
    for (size_t v = 0; v < vertices->count; ++v)
        cancelled +=
            (size_t)core_record_cancels(&vertices->sums[norma_core_welded(mesh, (uint32_t)v)]);
    if (!cancelled) return NORMA_OK;
    vertices->own = norma_core_allocate(call, vertices->count, sizeof *vertices->own);
    vertices->own_sums = norma_core_allocate(call, cancelled, sizeof *vertices->own_sums);
    vertices->own_count = cancelled;
    if (!vertices->own || !vertices->own_sums) return NORMA_ERROR_MEMORY;
    uint32_t number = 0;
    for (size_t v = 0; v < vertices->count; ++v)
        vertices->own[v] =
            core_record_cancels(&vertices->sums[mesh->weld[v]]) ? number++ : UINT32_MAX;
    norma_core_clear_sums(vertices->own_sums, cancelled);
    add_all_own(vertices);
    return NORMA_OK;
}

/* The normal of a vertex by its sum, with NORMA_REASON_NONE, or the reason why it has none. */
static int resolve_sum(const core_vertices *vertices, size_t vertex, float normal[3]) {
    const core_mesh *mesh = &vertices->prepared->mesh;
    if (vertices->own && vertices->own[vertex] != UINT32_MAX) {
        const core_vertex_sum *own = &vertices->own_sums[vertices->own[vertex]];
        return norma_core_has_votes(own) ? core_resolve_record(mesh, own, vertex, normal)
                                         : NORMA_REASON_CANCELLED;
    }
    return core_resolve_record(
        mesh, &vertices->sums[norma_core_welded(mesh, (uint32_t)vertex)], vertex, normal);
}

/* All sums, kept. What it returns but NORMA_OK leaves nothing to release. tally: degenerate faces
 * are added. ranges: of the chunks of faces; those of a welded mesh may be made ranges of welded
 * positions. */
static norma_result keep_sums(
    core_prepared_mesh *prepared, core_range *ranges, core_vertices *vertices, core_tally *tally) {
    const core_voting voting = voting_of(prepared, ranges);
    *vertices = (core_vertices){.prepared = prepared, .count = voting.count};
    vertices->sums = norma_core_allocate(prepared->call, voting.count, sizeof *vertices->sums);
    if (!vertices->sums) return NORMA_ERROR_MEMORY;
    norma_result result = norma_core_sum_all(&voting, vertices->sums, tally);
    if (!result) result = sum_own(vertices);
    norma_core_count_add(&tally->degenerate, &prepared->degenerate_faces);
    if (result) release_vertices(vertices);
    return result;
}

/* ---- the most visible normal of each position, from its star; where no open hemisphere holds its
 * faces, that of each of its vertices. */

enum { OWN = 0x80 }; /* the vertex has a result of its own, since that of its position cancelled */

static void keep(const core_vertices *vertices, uint32_t index, int own, const core_fan *fan) {
    memcpy(vertices->normals[index], fan->normal, sizeof fan->normal);
    vertices->reasons[index] = (uint8_t)(fan->reason | (uint32_t)own);
}

static void see_each_vertex(const core_vertices *vertices, core_star *star) {
    star_member *members = norma_core_star_members(star);
    uint32_t *numbers = norma_core_star_numbers(star);
    core_fan fan = {.reason = NORMA_REASON_CANCELLED};
    for (uint32_t i = 0; i < star->count; ++i)
        members[i] = (star_member){
            .vertex = norma_core_corner(&vertices->prepared->mesh, star->corners[i].corner),
            .index = i};
    norma_core_sort_corners(members, star->count);
    keep(vertices, star->position, OWN, &fan);
    for (size_t begin = 0, end; begin < star->count; begin = end) {
        for (end = begin; end < star->count && members[end].vertex == members[begin].vertex; ++end)
            numbers[end - begin] = members[end].index;
        norma_core_star_see_some(star, numbers, end - begin, &fan);
        keep(vertices, members[begin].vertex, OWN, &fan);
    }
}

static void keep_cones(void *context, const core_fans *fans, core_tally *tally) {
    const core_vertices *vertices = context;
    core_star *star = fans->star;
    (void)tally;
    if (star->fans[0].reason == NORMA_REASON_CANCELLED && vertices->prepared->mesh.weld)
        see_each_vertex(vertices, star);
    else
        keep(vertices, star->position, 0, &star->fans[0]);
}

static norma_result cone_vertices(
    core_prepared_mesh *prepared, core_vertices *vertices, core_tally *tally) {
    stars_part sum = {0};
    const position_visit visit = {.join = CORE_JOIN_ALL, .see = keep_cones, .context = vertices};
    const size_t count = prepared->mesh.positions.count;
    *vertices = (core_vertices){.prepared = prepared, .count = count};
    vertices->normals = norma_core_allocate(prepared->call, count, sizeof *vertices->normals);
    vertices->reasons = norma_core_allocate(prepared->call, count, 1);
    norma_result result = vertices->normals && vertices->reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) {
        memset(vertices->reasons, NORMA_REASON_UNREFERENCED, count);
        result = norma_core_visit_positions(prepared, &visit, &sum);
    }
    norma_core_count_add(&tally->degenerate, &sum.tally.degenerate);
    if (result) release_vertices(vertices);
    return result;
}

static int resolve_cone(const core_vertices *vertices, size_t vertex, float normal[3]) {
    const uint32_t position = norma_core_welded(&vertices->prepared->mesh, (uint32_t)vertex);
    const int by_vertex = vertices->reasons[position] & OWN;
    const size_t index = by_vertex ? vertex : position;
    const int reason = by_vertex && !(vertices->reasons[vertex] & OWN)
                           ? NORMA_REASON_CANCELLED
                           : vertices->reasons[index] & ~OWN;
    double p[3];
    memcpy(normal, vertices->normals[index], 3 * sizeof *normal);
    if (reason != NORMA_REASON_UNREFERENCED) return reason;
    norma_core_position(&vertices->prepared->mesh, (uint32_t)vertex, p);
    return norma_core_finite(p) ? reason : NORMA_REASON_NON_FINITE;
}

/* ---- the call */

enum { VERTICES_IN_CHUNK = 16384 };

typedef struct vertex_work {
    core_vertices vertices;
    const core_output *output;
    const core_kernels *kernels;
} vertex_work;

static int normal_of_vertex(const void *context, size_t vertex, float normal[3]) {
    const core_vertices *vertices = context;
    return vertices->sums ? resolve_sum(vertices, vertex, normal)
                          : resolve_cone(vertices, vertex, normal);
}

static void write_some(const vertex_work *work, size_t begin, size_t end, core_tally *tally) {
    for (size_t v = begin; v < end; ++v) {
        float normal[3];
        const int reason = normal_of_vertex(&work->vertices, v, normal);
        norma_core_write_element(work->output, v, reason, normal, tally);
    }
}

/* Some vertices at once, where each has a normal of its own: else 0, and nothing written. */
static int write_batch(const vertex_work *work, size_t begin) {
    const core_vertices *vertices = &work->vertices;
    const uint32_t *weld = vertices->prepared->mesh.weld;
    core_vertex_sum welded[CORE_LANES];
    float normals[CORE_LANES][3];
    for (size_t i = 0; weld && i < CORE_LANES; ++i) welded[i] = vertices->sums[weld[begin + i]];
    if (!work->kernels->finish(weld ? welded : vertices->sums + begin, normals)) return 0;
    norma_core_write_normals(work->output, begin, CORE_LANES, (const float(*)[3])normals);
    return 1;
}

static void write_vertex_normals(const void *context, size_t begin, size_t end, core_tally *tally) {
    const vertex_work *work = context;
    for (size_t v = begin; v < end; v += CORE_LANES) {
        const size_t batch = end - v < CORE_LANES ? end : v + CORE_LANES;
        if (work->vertices.sums && batch - v == CORE_LANES && write_batch(work, v)) continue;
        write_some(work, v, batch, tally);
    }
}

static norma_result sum_vertices(
    core_prepared_mesh *prepared, core_range *ranges, core_vertices *vertices, core_tally *tally) {
    return norma_core_sees(prepared->call) ? cone_vertices(prepared, vertices, tally)
                                           : keep_sums(prepared, ranges, vertices, tally);
}

static size_t without_normal(const core_tally *tally) {
    return tally->non_finite.count + tally->unreferenced.count + tally->cancelled.count;
}

/* Who has no normal and takes the nearest has to find it among all sums. Bins keep none: there they
 * are taken once more, and only what was left open is written. */
static norma_result compute_vertices(core_prepared_mesh *prepared, core_range *ranges,
    const core_output *output, norma_report *report) {
    core_call *call = prepared->call;
    vertex_work work = {.vertices.prepared = prepared,
        .output = output,
        .kernels = norma_core_kernels(call->level)};
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}}, again = tally;
    int written = 0;
    norma_core_stage(call, 0.5, 0.9);
    norma_result result = bin_vertices(prepared, ranges, output, &tally, &written);
    if (!result && !written) {
        result = sum_vertices(prepared, ranges, &work.vertices, &tally);
        norma_core_stage(call, 0.9, 0.97);
        if (!result)
            result = norma_core_write_chunks(
                call, work.vertices.count, VERTICES_IN_CHUNK, write_vertex_normals, &work, &tally);
    }
    const size_t without = output->nearest ? without_normal(&tally) : 0;
    norma_core_stage(call, 0.9, 0.97);
    if (!result && written && without)
        result = sum_vertices(prepared, ranges, &work.vertices, &again);
    if (!result && without) {
        const core_elements vertices = {
            &prepared->mesh, work.vertices.count, &work.vertices, normal_of_vertex, NULL};
        result = norma_core_fill_nearest(call, &vertices, output, without);
    }
    if (!result) norma_core_write_report(report, &tally, NULL, NULL);
    release_vertices(&work.vertices);
    return result;
}

static norma_result open_and_compute(core_call *call, core_mesh *checked, core_range *ranges,
    const core_output *output, norma_report *report) {
    core_prepared_mesh prepared;
    norma_core_stage(call, 0, 0.05);
    norma_result result = norma_core_mesh_ranges(call, checked, ranges);
    if (!result)
        result = norma_core_prepared_mesh_open(
            call, checked, norma_core_sees(call) ? CORE_FOR_STARS : CORE_FOR_SUMS, 0, &prepared);
    if (result) return result;
    result = norma_core_finish(call, compute_vertices(&prepared, ranges, output, report));
    norma_core_prepared_mesh_close(&prepared);
    return result;
}

norma_result norma_vertex_normals(const norma_mesh *mesh, const norma_options *options,
    float *normals, size_t capacity, norma_report *report) {
    core_call call;
    core_mesh checked;
    core_output output;
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_mesh_shape(mesh, &checked);
    if (!result) norma_core_share(&call, checked.corner_count);
    if (!result)
        result = norma_core_output_open(&call, normals, checked.positions.count, capacity, &output);
    if (result) return result;
    const size_t chunks = checked.face_count / CORE_FACES_IN_CHUNK + 1;
    core_range *ranges = norma_core_allocate(&call, chunks, sizeof *ranges);
    if (!ranges) return NORMA_ERROR_MEMORY;
    norma_core_gather(&call);
    result = open_and_compute(&call, &checked, ranges, &output, report);
    norma_core_dismiss(&call);
    norma_core_release(&call, ranges, chunks, sizeof *ranges);
    return result;
}
