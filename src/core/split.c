/* split.c: norma_split. Corners of one old vertex with one normal are one new vertex. The first of them, in the order of corners, stands for it: what
 * is kept between the passes is that corner's number, four bytes for each corner, and the normals of positions that need no split, most of them. */
#include "corner_fill.h"
#include "members.h"
#include <math.h>

typedef struct split_work {
    const core_surface *surface;
    core_output         output;              /* of new vertices; normals may be NULL */
    uint32_t           *numbers;             /* of each corner: first the corner that stands for it, then its new vertex */
    uint8_t            *single;              /* of each position: whether all its corners are one vertex that has a normal */
    float             (*normals)[3];         /* of those */
    uint8_t            *reasons, *wanted;    /* with the nearest fallback: of each corner; of corners that stand for a vertex with no normal at all */
} split_work;

/* ---- one position */

static void set_bits(const split_work *work, const core_fan *fan, ring_member *m)
{
    if (fan->reason == NORMA_REASON_NONE) memcpy(m->bits, fan->normal, sizeof m->bits);
    else memcpy(m->bits, work->output.fallback, sizeof m->bits);
}

static const core_fan *fan_of_member(const core_fans *fans, const ring_member *m) { return &fans->fans[fans->fan_of[m->index]]; }

/* Where the nearest is asked for, a corner without a normal is one with the first corner of its vertex that has one. Members come sorted by vertex and index. */
static void borrow_within_vertex(const core_fans *fans, ring_member *members, size_t count)
{
    const ring_member *lender = NULL;
    for (size_t i = 0; i < count && !lender; i++)
        if (fan_of_member(fans, &members[i])->reason == NORMA_REASON_NONE) lender = &members[i];
    for (size_t i = 0; i < count && lender; i++)
        if (fan_of_member(fans, &members[i])->reason != NORMA_REASON_NONE) memcpy(members[i].bits, lender->bits, sizeof lender->bits);
}

static void list_members(const split_work *work, const core_fans *fans)
{
    ring_member *members = fans->members;
    for (uint32_t i = 0; i < fans->count; i++) {
        members[i] = (ring_member){.vertex = norma_core_corner(&work->surface->mesh, fans->corners[i]), .index = i};
        if (!work->output.nearest) set_bits(work, &fans->fans[fans->fan_of[i]], &members[i]);
    }
    norma_core_sort_members(members, fans->count);
    if (!work->output.nearest) return;
    for (size_t i = 0; i < fans->count; i++) set_bits(work, fan_of_member(fans, &members[i]), &members[i]);
    for (size_t begin = 0, end; begin < fans->count; begin = end) {
        for (end = begin; end < fans->count && members[end].vertex == members[begin].vertex; end++) { }
        borrow_within_vertex(fans, members + begin, end - begin);
    }
    norma_core_sort_members(members, fans->count);
}

/* A vertex has a normal as soon as one of its corners does; first_fan is that one's, or the first one's. */
static const core_fan *fan_of_group(const core_fans *fans, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i++) {
        const core_fan *fan = fan_of_member(fans, &fans->members[i]);
        if (fan->reason == NORMA_REASON_NONE) return fan;
    }
    return fan_of_member(fans, &fans->members[begin]);
}

static size_t group_end(const ring_member *members, size_t begin, size_t count)
{
    size_t end = begin + 1;
    while (end < count && norma_core_same_normal(&members[begin], &members[end])) end++;
    return end;
}

/* ---- first pass: who stands for whom */

static void keep_single(const split_work *work, const core_fans *fans, const core_fan *fan)
{
    if (!work->single || fan->reason != NORMA_REASON_NONE) return;
    work->single[fans->position] = 1;
    memcpy(work->normals[fans->position], fan->normal, sizeof fan->normal);
}

/* One vertex and one fan with a normal: nothing to sort. 0 where it is not so. */
static int number_plain(const split_work *work, const core_fans *fans)
{
    const core_mesh *mesh = &work->surface->mesh;
    const uint32_t first = fans->corners[0], vertex = norma_core_corner(mesh, first);
    if (fans->fan_count != 1 || fans->fans[0].reason != NORMA_REASON_NONE) return 0;
    for (size_t i = 1; i < fans->count && mesh->weld; i++)
        if (norma_core_corner(mesh, fans->corners[i]) != vertex) return 0;
    for (size_t i = 0; i < fans->count; i++) work->numbers[fans->corners[i]] = first;
    keep_single(work, fans, &fans->fans[0]);
    return 1;
}

static void see_to_number(void *context, const core_fans *fans, core_tally *tally)
{
    const split_work *work = context;
    for (size_t i = 0; i < fans->count; i++) {
        const uint32_t reason = fans->fans[fans->fan_of[i]].reason;
        norma_core_tally(tally, (int)reason, fans->corners[i]);
        if (work->reasons) work->reasons[fans->corners[i]] = (uint8_t)reason;
    }
    if (number_plain(work, fans)) return;
    list_members(work, fans);
    for (size_t begin = 0, end; begin < fans->count; begin = end) {
        const uint32_t first = fans->corners[fans->members[begin].index];
        end = group_end(fans->members, begin, fans->count);
        if (work->wanted) work->wanted[first] = fan_of_group(fans, begin, end)->reason != NORMA_REASON_NONE;
        if (begin == 0 && end == fans->count) keep_single(work, fans, fan_of_group(fans, begin, end));
        for (size_t i = begin; i < end; i++) work->numbers[fans->corners[fans->members[i].index]] = first;
    }
}

/* Corners in order: one that stands for itself gets the next number, the others that of the earlier one that stands for them. */
static size_t count_vertices(const split_work *work)
{
    size_t count = 0;
    for (size_t c = 0; c < work->surface->mesh.corner_count; c++) count += work->numbers[c] == c;
    return count;
}

static void write_corners(split_work *work, uint32_t *corners, uint32_t *source_vertices)
{
    uint32_t count = 0;
    for (size_t c = 0; c < work->surface->mesh.corner_count; c++) {
        const int is_new = work->numbers[c] == c;
        const uint32_t number = is_new ? count : work->numbers[work->numbers[c]];
        if (is_new && source_vertices) source_vertices[count] = norma_core_corner(&work->surface->mesh, c);
        if (corners) corners[c] = number;
        count += (uint32_t)is_new;
        work->numbers[c] = number;
    }
}

/* ---- second pass: the normals */

static void see_to_write(void *context, const core_fans *fans, core_tally *tally)
{
    const split_work *work = context;
    list_members(work, fans);
    for (size_t begin = 0, end; begin < fans->count; begin = end) {
        end = group_end(fans->members, begin, fans->count);
        const core_fan *fan = fan_of_group(fans, begin, end);
        norma_core_write_element(&work->output, work->numbers[fans->corners[fans->members[begin].index]], (int)fan->reason, fan->normal, tally);
    }
}

/* The first corner at a position stands for the rest. */
static void write_singles(const split_work *work)
{
    const core_around *around = &work->surface->around;
    core_tally ignored = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    for (size_t p = 0; p < around->position_count; p++)
        if (work->single[p]) norma_core_write_element(&work->output, work->numbers[around->corners[around->starts[p]]], NORMA_REASON_NONE, work->normals[p], &ignored);
}

static void receive(void *context, const corner_request *request, const float normal[3])
{
    const split_work *work = context;
    norma_core_write_normal(&work->output, work->numbers[request->target], normal);
}

static norma_result fill_from_nearest(split_work *work)
{
    const core_call *call = work->surface->call;
    const size_t corners = work->surface->mesh.corner_count;
    const float zero[3] = {0, 0, 0};
    size_t count = 0, found;
    for (size_t c = 0; c < corners; c++) count += work->wanted[c];
    if (!count) return NORMA_OK;
    corner_request *requests = norma_core_allocate(call, count, sizeof *requests);
    if (!requests) return NORMA_ERROR_MEMORY;
    norma_result result = norma_core_find_sources(work->surface, work->reasons, work->wanted, requests, count, &found);
    if (result == NORMA_OK && found) result = norma_core_fetch_normals(work->surface, requests, found, receive, work);
    for (size_t c = 0; c < corners && result == NORMA_OK && !found; c++)
        if (work->wanted[c]) norma_core_write_normal(&work->output, work->numbers[c], zero);
    norma_core_release(call, requests, count, sizeof *requests);
    return result;
}

/* ---- the call */

typedef struct split_output {
    uint32_t *corners, *source_vertices;
    float    *normals;
    size_t    corner_capacity, vertex_capacity, *vertex_count;
} split_output;

static norma_result write_split(core_surface *surface, split_work *work, const split_output *out, size_t count)
{
    rings_part ignored;
    const ring_visit visit = {.join = CORE_JOIN_FANS, .skip = work->single, .see = see_to_write, .context = work};
    if (out->corners && surface->mesh.corner_count > out->corner_capacity) return NORMA_ERROR_CAPACITY;
    if ((out->source_vertices || out->normals) && count > out->vertex_capacity) return NORMA_ERROR_CAPACITY;
    if (out->normals && count > SIZE_MAX / surface->call->options.normal_stride) return NORMA_ERROR_OVERFLOW;
    write_corners(work, out->corners, out->source_vertices);
    if (!out->normals) return NORMA_OK;
    norma_core_stage(surface->call, 0.75, 0.97);
    norma_result result = norma_core_visit_rings(surface, &visit, &ignored);
    if (result == NORMA_OK) write_singles(work);
    if (result == NORMA_OK && work->output.nearest) result = fill_from_nearest(work);
    return result;
}

static norma_result compute(core_surface *surface, split_work *work, const split_output *out, norma_report *report)
{
    core_call *call = surface->call;
    rings_part sum = {0};
    const ring_visit visit = {.join = CORE_JOIN_FANS, .counting = 1, .see = see_to_number, .context = work, .target = work->numbers,
                              .target_size = sizeof *work->numbers};
    norma_core_stage(call, 0.5, 0.75);
    norma_result result = norma_core_visit_rings(surface, &visit, &sum);
    if (result != NORMA_OK) return result;
    const size_t count = count_vertices(work);
    result = write_split(surface, work, out, count);
    if (result != NORMA_OK) return result;
    norma_core_write_report(report, &sum.tally, &sum.counts.non_manifold, &sum.counts.conflicts);
    if (call->options.edges) *call->options.edges = sum.counts.edges;
    if (out->vertex_count) *out->vertex_count = count;
    return NORMA_OK;
}

static void release_work(const core_call *call, split_work *work)
{
    const size_t corners = work->surface->mesh.corner_count, positions = work->surface->mesh.positions.count;
    norma_core_release(call, work->numbers, corners, sizeof *work->numbers);
    norma_core_release(call, work->single, positions, 1);
    norma_core_release(call, work->normals, positions, sizeof *work->normals);
    norma_core_release(call, work->reasons, corners, 1);
    norma_core_release(call, work->wanted, corners, 1);
}

static norma_result allocate_work(const core_call *call, int with_normals, split_work *work)
{
    const size_t corners = work->surface->mesh.corner_count, positions = work->surface->mesh.positions.count;
    work->numbers = norma_core_allocate(call, corners, sizeof *work->numbers);
    if (!work->numbers) return NORMA_ERROR_MEMORY;
    if (with_normals) {
        work->single = norma_core_allocate(call, positions, 1);
        work->normals = norma_core_allocate(call, positions, sizeof *work->normals);
        if (!work->single || !work->normals) return NORMA_ERROR_MEMORY;
        memset(work->single, 0, positions);
    }
    if (work->output.nearest) {
        work->reasons = norma_core_allocate(call, corners, 1);
        work->wanted = norma_core_allocate(call, corners, 1);
        if (!work->reasons || !work->wanted) return NORMA_ERROR_MEMORY;
        memset(work->wanted, 0, corners);
    }
    return NORMA_OK;
}

static norma_result allocate_and_compute(core_surface *surface, const split_output *out, norma_report *report)
{
    split_work work = {.surface = surface};
    norma_result result = norma_core_output_open(surface->call, out->normals, 0, 0, &work.output);
    if (result == NORMA_OK) result = allocate_work(surface->call, out->normals != NULL, &work);
    if (result == NORMA_OK) result = compute(surface, &work, out, report);
    release_work(surface->call, &work);
    return result;
}

norma_result norma_split(const norma_mesh *mesh, float crease_angle_rad, const norma_options *options, uint32_t *corners, size_t corner_capacity,
                         uint32_t *source_vertices, float *normals, size_t vertex_capacity, size_t *vertex_count, norma_report *report)
{
    const split_output out = {corners, source_vertices, normals, corner_capacity, vertex_capacity, vertex_count};
    core_call call;
    core_mesh checked;
    core_surface surface;
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK && isnan(crease_angle_rad)) result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked);
    if (result == NORMA_OK && corners && checked.corner_count > corner_capacity) result = NORMA_ERROR_CAPACITY;
    norma_core_stage(&call, 0, 0.05);
    if (result == NORMA_OK) result = norma_core_mesh_content(&call, &checked);
    if (result == NORMA_OK) result = norma_core_surface_open(&call, &checked, CORE_FOR_FANS, (double)crease_angle_rad, &surface);
    if (result != NORMA_OK) return result;
    result = allocate_and_compute(&surface, &out, report);
    norma_core_stage(&call, 1, 1);
    if (result == NORMA_OK && norma_core_progress(&call, 1)) result = NORMA_CANCELLED;
    norma_core_surface_close(&surface);
    return result;
}
