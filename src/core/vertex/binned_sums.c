/* binned_sums.c: vertex normals where faces in a row touch positions near each other. Each bin, a
 * range of positions, has its sums in memory that stays in the cache from one bin to the next; the
 * chunks of faces that touch it are added, and its normals written. The sums of all positions,
 * which would be written, read and written, and read again, never reach memory: that alone was 60
 * of the 100 bytes that a triangle moved. A chunk that touches two bins is measured for both. */
#include "core/vertex/add_polygons.h"
#include "core/vertex/position_bins.h"

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
