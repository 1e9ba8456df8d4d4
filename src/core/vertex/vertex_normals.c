/* vertex_normals.c: norma_vertex_normals. Sums or cones first; then each vertex takes what became
 * of its position, or of itself, and is written. */
#include "core/mesh/mesh.h"
#include "core/vertex/vertex.h"
#include "core/corner/corner.h"

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
    if (result) norma_core_release_vertices(vertices);
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
    return vertices->sums ? norma_core_resolve_sum(vertices, vertex, normal)
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
    return norma_core_sees(prepared->call)
               ? cone_vertices(prepared, vertices, tally)
               : norma_core_sum_vertices(prepared, ranges, vertices, tally);
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
    norma_result result = norma_core_bin_vertices(prepared, ranges, output, &tally, &written);
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
    norma_core_release_vertices(&work.vertices);
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
