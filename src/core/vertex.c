/* vertex.c: norma_vertex_normals. The sum over all corners at a position; where that cancels, over the corners of each of its vertices. */
#include "members.h"
#include "nearest.h"
#include "rings.h"

enum { VERTICES_IN_CHUNK = 16384, OWN = 0x80 };    /* own: the vertex has a result of its own, since that of its position cancelled */

typedef struct vertex_work {
    core_surface      *surface;
    const core_output *output;
    float            (*normals)[3];                /* of positions, and of vertices with a result of their own */
    uint8_t           *reasons;
    core_tally        *tallies;
} vertex_work;

/* ---- positions */

static void keep(const vertex_work *work, uint32_t index, int own, const ring_fan *fan)
{
    memcpy(work->normals[index], fan->normal, sizeof fan->normal);
    work->reasons[index] = (uint8_t)(fan->reason | own);
}

static void sum_each_vertex(const vertex_work *work, core_ring *ring)
{
    ring_member *members = norma_core_ring_members(ring);
    uint32_t *numbers = norma_core_ring_numbers(ring);
    ring_fan fan = {.reason = NORMA_REASON_CANCELLED};
    for (uint32_t i = 0; i < ring->count; i++) members[i] = (ring_member){.vertex = norma_core_corner(&work->surface->mesh, ring->corners[i].corner), .index = i};
    norma_core_sort_members(members, ring->count);
    keep(work, ring->position, OWN, &fan);
    for (size_t begin = 0, end; begin < ring->count; begin = end) {
        for (end = begin; end < ring->count && members[end].vertex == members[begin].vertex; end++) numbers[end - begin] = members[end].index;
        norma_core_ring_sum_some(work->surface, ring, numbers, end - begin, &fan);
        keep(work, members[begin].vertex, OWN, &fan);
    }
}

static void visit(void *context, core_ring *ring, core_tally *tally)
{
    const vertex_work *work = context;
    (void)tally;
    if (ring->fans[0].reason == NORMA_REASON_CANCELLED && work->surface->mesh.weld) sum_each_vertex(work, ring);
    else keep(work, ring->position, 0, &ring->fans[0]);
}

/* ---- vertices */

static int resolve(const vertex_work *work, size_t vertex, float normal[3])
{
    const uint32_t position = norma_core_welded(&work->surface->mesh, (uint32_t)vertex);
    const int by_vertex = work->reasons[position] & OWN;
    const size_t index = by_vertex ? vertex : position;
    const int reason = by_vertex && !(work->reasons[vertex] & OWN) ? NORMA_REASON_CANCELLED : work->reasons[index] & ~OWN;
    double p[3];
    memcpy(normal, work->normals[index], 3 * sizeof *normal);
    if (reason != NORMA_REASON_UNREFERENCED) return reason;
    norma_core_position(&work->surface->mesh, (uint32_t)vertex, p);
    return norma_core_finite(p) ? reason : NORMA_REASON_NON_FINITE;
}

static void write_chunk(void *context, size_t chunk)
{
    const vertex_work *work = context;
    const size_t begin = chunk * VERTICES_IN_CHUNK, count = work->surface->mesh.positions.count;
    const size_t end = count - begin < VERTICES_IN_CHUNK ? count : begin + VERTICES_IN_CHUNK;
    for (size_t v = begin; v < end; v++) {
        float normal[3];
        const int reason = resolve(work, v, normal);
        norma_core_write_element(work->output, v, reason, normal, &work->tallies[chunk]);
    }
}

static norma_result write_all(vertex_work *work, core_tally *sum)
{
    core_call *call = work->surface->call;
    const size_t count = work->surface->mesh.positions.count, chunks = count / VERTICES_IN_CHUNK + (count % VERTICES_IN_CHUNK != 0);
    work->tallies = norma_core_allocate(call, chunks, sizeof *work->tallies);
    if (!work->tallies) return NORMA_ERROR_MEMORY;
    memset(work->tallies, 0, chunks * sizeof *work->tallies);
    const norma_result result = norma_core_parallel(call, chunks, write_chunk, work);
    for (size_t i = 0; i < chunks; i++) norma_core_tally_add(sum, &work->tallies[i]);
    norma_core_release(call, work->tallies, chunks, sizeof *work->tallies);
    return result;
}

static void write_nearest(const vertex_work *work, const core_nearest *nearest)
{
    for (size_t v = 0; v < work->surface->mesh.positions.count; v++) {
        float normal[3];
        if (resolve(work, v, normal) == NORMA_REASON_NONE) continue;
        const uint32_t source = norma_core_nearest_find(nearest, (uint32_t)v);
        if (source == UINT32_MAX) normal[0] = normal[1] = normal[2] = 0;
        else resolve(work, source, normal);
        norma_core_write_normal(work->output, v, normal);
    }
}

static norma_result fill_from_nearest(const vertex_work *work, size_t queries)
{
    core_nearest nearest;
    norma_result result = norma_core_nearest_begin(work->surface->call, &work->surface->mesh, &nearest);
    if (result != NORMA_OK) return result;
    for (size_t v = 0; v < work->surface->mesh.positions.count; v++) {
        float normal[3];
        if (resolve(work, v, normal) == NORMA_REASON_NONE) norma_core_nearest_add(&nearest, (uint32_t)v, (uint32_t)v);
    }
    result = norma_core_nearest_plant(&nearest, queries);
    if (result == NORMA_OK) write_nearest(work, &nearest);
    norma_core_nearest_end(&nearest);
    return result;
}

/* ---- the call */

static norma_result compute(core_surface *surface, const core_output *output, norma_report *report)
{
    core_call *call = surface->call;
    const size_t count = surface->mesh.positions.count;
    vertex_work work = {.surface = surface, .output = output};
    rings_part sum = {0};
    work.normals = norma_core_allocate(call, count, sizeof *work.normals);
    work.reasons = norma_core_allocate(call, count, 1);
    norma_result result = work.normals && work.reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        memset(work.reasons, NORMA_REASON_UNREFERENCED, count);
        norma_core_stage(call, 0.5, 0.9);
        result = norma_core_visit_rings(surface, CORE_JOIN_ALL, 0, visit, &work, &sum);
    }
    norma_core_stage(call, 0.9, 0.97);
    if (result == NORMA_OK) result = write_all(&work, &sum.tally);
    const size_t without = sum.tally.non_finite.count + sum.tally.unreferenced.count + sum.tally.cancelled.count;
    if (result == NORMA_OK && output->nearest && without) result = fill_from_nearest(&work, without);
    sum.tally.degenerate = surface->degenerate_faces;
    if (result == NORMA_OK) norma_core_write_report(report, &sum.tally, NULL, NULL);
    norma_core_release(call, work.normals, count, sizeof *work.normals);
    norma_core_release(call, work.reasons, count, 1);
    return result;
}

norma_result norma_vertex_normals(const norma_mesh *mesh, const norma_options *options, float *normals, size_t capacity, norma_report *report)
{
    core_call call;
    core_mesh checked;
    core_output output;
    core_surface surface;
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked);
    if (result == NORMA_OK) result = norma_core_output_open(&call, normals, checked.positions.count, capacity, &output);
    norma_core_stage(&call, 0, 0.05);
    if (result == NORMA_OK) result = norma_core_mesh_content(&call, &checked);
    if (result == NORMA_OK) result = norma_core_surface_open(&call, &checked, 0, 0, &surface);
    if (result != NORMA_OK) return result;
    result = compute(&surface, &output, report);
    norma_core_stage(&call, 1, 1);
    if (result == NORMA_OK && norma_core_progress(&call, 1)) result = NORMA_CANCELLED;
    norma_core_surface_close(&surface);
    return result;
}
