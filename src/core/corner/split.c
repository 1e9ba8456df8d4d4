/* split.c: norma_split. Corners of one old vertex with one normal are one new vertex, numbered
 * where the first of them stands in the order of corners. Between the passes is kept which corners
 * are such firsts, a byte for each corner, and the normals of positions that need no split, most of
 * them. The others' corners are sorted out again in the second pass, when they have their numbers.
 */
#include "core/corner/corner.h"
#include <math.h>

typedef struct split_work {
    core_prepared_mesh *prepared;
    core_output output; /* of new vertices; normals may be NULL */
    uint8_t *firsts;    /* of each corner: whether a new vertex begins with it */
    uint32_t *before; /* of each CORNERS_COUNTED corners how many vertices begin before them; and of
                         the end: the number of any first follows from a few of the bytes above */
    uint8_t *single;  /* of each position: whether all its corners have one normal: no vertex there
                         needs to be split */
    float (*normals)[3]; /* of those */
    uint32_t *vertices;  /* of each vertex there the new one */
    uint32_t *numbers;   /* of each corner its new vertex: the caller's, or NULL */
    uint32_t *source_vertices;
    uint32_t
        *few; /* the sorted corners of all other positions, in place of the surface's; or NULL */
    size_t few_count;
    uint8_t *reasons, *wanted; /* where the nearest is to be found: of each corner; of corners that
                                  stand for a vertex with no normal at all */
} split_work;

typedef struct split_output {
    uint32_t *corners, *source_vertices;
    float *normals;
    size_t corner_capacity, vertex_capacity, *vertex_count;
} split_output;

/* ---- one position */

static void set_bits(const split_work *work, const core_fan *fan, star_member *m) {
    if (fan->reason == NORMA_REASON_NONE)
        memcpy(m->bits, fan->normal, sizeof m->bits);
    else
        memcpy(m->bits, work->output.fallback, sizeof m->bits);
}

static const core_fan *fan_of_member(const core_fans *fans, const star_member *m) {
    return &fans->fans[fans->fan_of[m->index]];
}

/* Where the nearest is asked for, a corner without a normal is one with the first corner of its
 * vertex that has one. Members come sorted by vertex and index. */
static void borrow_within_vertex(const core_fans *fans, star_member *members, size_t count) {
    const star_member *borrowed_from = NULL;
    for (size_t i = 0; i < count && !borrowed_from; ++i)
        if (fan_of_member(fans, &members[i])->reason == NORMA_REASON_NONE)
            borrowed_from = &members[i];
    for (size_t i = 0; i < count && borrowed_from; ++i)
        if (fan_of_member(fans, &members[i])->reason != NORMA_REASON_NONE)
            memcpy(members[i].bits, borrowed_from->bits, sizeof borrowed_from->bits);
}

static void list_members(const split_work *work, const core_fans *fans) {
    star_member *members = fans->members;
    for (uint32_t i = 0; i < fans->count; ++i) {
        members[i] = (star_member){
            .vertex = norma_core_corner(&work->prepared->mesh, fans->corners[i]), .index = i};
        if (!work->output.nearest) set_bits(work, &fans->fans[fans->fan_of[i]], &members[i]);
    }
    norma_core_sort_corners(members, fans->count);
    if (!work->output.nearest) return;
    for (size_t i = 0; i < fans->count; ++i)
        set_bits(work, fan_of_member(fans, &members[i]), &members[i]);
    for (size_t begin = 0, end; begin < fans->count; begin = end) {
        for (end = begin; end < fans->count && members[end].vertex == members[begin].vertex;
             ++end) {
        }
        borrow_within_vertex(fans, members + begin, end - begin);
    }
    norma_core_sort_corners(members, fans->count);
}

/* A vertex has a normal as soon as one of its corners does; first_fan is that one's, or the first
 * one's. */
static const core_fan *fan_of_group(const core_fans *fans, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
        const core_fan *fan = fan_of_member(fans, &fans->members[i]);
        if (fan->reason == NORMA_REASON_NONE) return fan;
    }
    return fan_of_member(fans, &fans->members[begin]);
}

static size_t group_end(const star_member *members, size_t begin, size_t count) {
    size_t end = begin + 1;
    while (end < count && norma_core_same_normal(&members[begin], &members[end])) ++end;
    return end;
}

/* ---- first pass: where a vertex begins */

static void keep_single(const split_work *work, const core_fans *fans) {
    work->single[fans->position] = 1;
    if (work->normals)
        memcpy(work->normals[fans->position], fans->fans[0].normal, sizeof fans->fans[0].normal);
}

/* One vertex and one fan with a normal: nothing to sort. 0 where it is not so. */
static int number_plain(const split_work *work, const core_fans *fans) {
    const core_mesh *mesh = &work->prepared->mesh;
    const uint32_t first = fans->corners[0], vertex = norma_core_corner(mesh, first);
    if (fans->fan_count != 1 || fans->fans[0].reason != NORMA_REASON_NONE) return 0;
    for (size_t i = 1; i < fans->count && mesh->weld; ++i)
        if (norma_core_corner(mesh, fans->corners[i]) != vertex) return 0;
    work->firsts[first] = 1;
    keep_single(work, fans);
    return 1;
}

static void see_to_number(void *context, const core_fans *fans, core_tally *tally) {
    const split_work *work = context;
    int whole = 1;
    for (size_t i = 0; i < fans->count; ++i) {
        const uint32_t reason = fans->fans[fans->fan_of[i]].reason;
        norma_core_tally(tally, (int)reason, fans->corners[i]);
        whole &= reason == NORMA_REASON_NONE;
    }
    if (number_plain(work, fans)) return;
    list_members(work, fans);
    for (size_t begin = 0, end; begin < fans->count; begin = end) {
        end = group_end(fans->members, begin, fans->count);
        work->firsts[fans->corners[fans->members[begin].index]] = 1;
        if (whole && begin == 0 && end == fans->count) keep_single(work, fans);
    }
    if (whole && fans->fan_count == 1) keep_single(work, fans);
}

/* ---- numbers, in blocks of corners */

enum { CORNERS_IN_BLOCK = 1 << 15, CORNERS_AT_ONCE = 1 << 8, CORNERS_COUNTED = 1 << 6 };

static size_t blocks_of(const split_work *work) {
    return work->prepared->mesh.corner_count / CORNERS_IN_BLOCK +
           (work->prepared->mesh.corner_count % CORNERS_IN_BLOCK != 0);
}

static size_t block_end(const split_work *work, size_t block) {
    const size_t count = work->prepared->mesh.corner_count, begin = block * CORNERS_IN_BLOCK;
    return count - begin < CORNERS_IN_BLOCK ? count : begin + CORNERS_IN_BLOCK;
}

static size_t firsts_counts(const split_work *work) {
    const size_t corners = work->prepared->mesh.corner_count;
    return corners / CORNERS_COUNTED + (corners % CORNERS_COUNTED != 0);
}

/* Of so many corners in a row, how many begin a vertex: eight bytes of 0 or 1 at a time. */
static uint32_t count_first_corners(const uint8_t *firsts, size_t count) {
    const uint64_t ones = UINT64_C(0x0101010101010101);
    uint32_t sum = 0;
    for (; count >= sizeof ones; firsts += sizeof ones, count -= sizeof ones) {
        uint64_t eight;
        memcpy(&eight, firsts, sizeof eight);
        sum += (uint32_t)(eight * ones >> 56);
    }
    for (size_t i = 0; i < count; ++i) sum += firsts[i];
    return sum;
}

static void count_block(void *context, size_t block) {
    const split_work *work = context;
    const size_t end = block_end(work, block);
    for (size_t c = block * CORNERS_IN_BLOCK; c < end; c += CORNERS_COUNTED)
        work->before[c / CORNERS_COUNTED + 1] = count_first_corners(
            work->firsts + c, end - c < CORNERS_COUNTED ? end - c : CORNERS_COUNTED);
}

static norma_result count_vertices(const split_work *work, size_t *count) {
    const size_t counts = firsts_counts(work);
    work->before[0] = 0;
    const norma_result result = norma_core_parallel(
        work->prepared->call, blocks_of(work), count_block, (void *)(uintptr_t)work);
    for (size_t i = 0; i < counts && !result; ++i) work->before[i + 1] += work->before[i];
    *count = !result ? work->before[counts] : 0;
    return result;
}

/* Of the new vertex that begins with this corner. */
static uint32_t new_vertex_of(const split_work *work, uint32_t first) {
    const size_t counted = first / CORNERS_COUNTED * CORNERS_COUNTED;
    return work->before[first / CORNERS_COUNTED] +
           count_first_corners(work->firsts + counted, first - counted);
}

static void write_vertex(const split_work *work, uint32_t number, uint32_t corner) {
    const uint32_t vertex = norma_core_corner(&work->prepared->mesh, corner),
                   position = norma_core_welded(&work->prepared->mesh, vertex);
    if (work->source_vertices) work->source_vertices[number] = vertex;
    if (!work->single[position]) return;
    work->vertices[vertex] = number;
    if (work->normals)
        norma_core_write_normals(
            &work->output, number, 1, (const float(*)[3]) & work->normals[position]);
}

/* The vertices that begin in the block; few of its corners begin one, and which ones no branch
 * could foretell. */
static void write_vertices(void *context, size_t block) {
    const split_work *work = context;
    const size_t end = block_end(work, block);
    uint32_t firsts[CORNERS_AT_ONCE],
        number = work->before[block * (CORNERS_IN_BLOCK / CORNERS_COUNTED)];
    for (size_t begin = block * CORNERS_IN_BLOCK; begin < end; begin += CORNERS_AT_ONCE) {
        size_t found = 0;
        for (size_t c = begin; c < end && c < begin + CORNERS_AT_ONCE; ++c) {
            firsts[found] = (uint32_t)c;
            found += work->firsts[c];
        }
        for (size_t i = 0; i < found; ++i) write_vertex(work, number++, firsts[i]);
    }
}

/* Where a position's corners are several vertices, they get their numbers in the second pass. */
static void number_block(void *context, size_t block) {
    const split_work *work = context;
    const core_mesh *mesh = &work->prepared->mesh;
    for (size_t c = block * CORNERS_IN_BLOCK; c < block_end(work, block); ++c) {
        const uint32_t vertex = norma_core_corner(mesh, c);
        if (work->single[norma_core_welded(mesh, vertex)])
            work->numbers[c] = work->vertices[vertex];
    }
}

static void release_normals(split_work *work) {
    norma_core_release(work->prepared->call, work->normals, work->prepared->mesh.positions.count,
        sizeof *work->normals);
    work->normals = NULL;
}

/* What is done with is released before memory that nobody has touched yet is written to: the
 * caller's corners. */
static norma_result write_numbers(split_work *work) {
    core_call *call = work->prepared->call;
    const size_t blocks = blocks_of(work);
    norma_core_stage(call, 0.76, 0.78);
    norma_result result = norma_core_parallel(call, blocks, write_vertices, work);
    release_normals(work);
    norma_core_stage(call, 0.78, 0.8);
    if (!result && work->numbers) result = norma_core_parallel(call, blocks, number_block, work);
    return result;
}

/* ---- second pass: positions whose corners are several vertices */

/* The sorted corners of single positions are needed no more, where nobody is to be asked for a
 * normal. */
static norma_result thin_out(split_work *work) {
    core_corners_of_position *corners_of = &work->prepared->corners_of;
    size_t count = 0;
    for (size_t p = 0; p < corners_of->position_count; ++p)
        count += work->single[p] ? 0 : corners_of->starts[p + 1] - corners_of->starts[p];
    if (count > corners_of->corner_count / 2) return NORMA_OK;
    if (!(work->few = norma_core_allocate(work->prepared->call, count, sizeof *work->few)))
        return NORMA_ERROR_MEMORY;
    for (size_t p = 0, begin = 0, at = 0; p < corners_of->position_count; ++p) {
        const size_t end = corners_of->starts[p + 1];
        for (size_t i = begin; i < end && !work->single[p]; ++i)
            work->few[at++] = corners_of->corners[i];
        begin = end;
        corners_of->starts[p + 1] = (uint32_t)at;
    }
    norma_core_release(work->prepared->call, corners_of->corners, corners_of->corner_count,
        sizeof *corners_of->corners);
    corners_of->corners = work->few;
    corners_of->corner_count = work->few_count = count;
    return NORMA_OK;
}

static void see_to_write(void *context, const core_fans *fans, core_tally *tally) {
    const split_work *work = context;
    for (size_t i = 0; i < fans->count && work->reasons; ++i)
        work->reasons[fans->corners[i]] = (uint8_t)fans->fans[fans->fan_of[i]].reason;
    list_members(work, fans);
    for (size_t begin = 0, end; begin < fans->count; begin = end) {
        const uint32_t first = fans->corners[fans->members[begin].index],
                       number = new_vertex_of(work, first);
        end = group_end(fans->members, begin, fans->count);
        for (size_t i = begin; i < end && work->numbers; ++i)
            work->numbers[fans->corners[fans->members[i].index]] = number;
        if (!work->output.normals) continue;
        const core_fan *fan = fan_of_group(fans, begin, end);
        norma_core_write_element(&work->output, number, (int)fan->reason, fan->normal, tally);
        if (work->wanted) work->wanted[first] = fan->reason != NORMA_REASON_NONE;
    }
}

static void take_vertex_normal(void *context, uint32_t first, const float normal[3]) {
    const split_work *work = context;
    norma_core_write_normal(&work->output, new_vertex_of(work, first), normal);
}

static norma_result fill_vertices(split_work *work) {
    return norma_core_fill_corners(
        work->prepared, work->reasons, work->wanted, take_vertex_normal, work);
}

/* ---- the call */

static norma_result allocate_numbers(split_work *work, int lacking) {
    const core_call *call = work->prepared->call;
    const size_t corners = work->prepared->mesh.corner_count;
    work->vertices =
        norma_core_allocate(call, work->prepared->mesh.positions.count, sizeof *work->vertices);
    if (!work->vertices) return NORMA_ERROR_MEMORY;
    if (!lacking) return NORMA_OK;
    work->reasons = norma_core_allocate(call, corners, 1);
    work->wanted = norma_core_allocate(call, corners, 1);
    if (!work->reasons || !work->wanted) return NORMA_ERROR_MEMORY;
    memset(work->reasons, NORMA_REASON_NONE, corners);
    memset(work->wanted, 0, corners);
    return NORMA_OK;
}

/* lacking: some corner is to get the nearest normal. */
static norma_result write_split(split_work *work, int lacking) {
    core_prepared_mesh *prepared = work->prepared;
    stars_part ignored;
    norma_result result = lacking ? NORMA_OK : thin_out(work);
    if (!result) result = allocate_numbers(work, lacking);
    if (!result) result = write_numbers(work);
    if (result || !(work->numbers || work->output.normals)) return result;
    const position_visit visit = {
        .join = CORE_JOIN_FANS, .skip = work->single, .see = see_to_write, .context = work};
    norma_core_stage(prepared->call, 0.8, 0.97);
    result = norma_core_visit_positions(prepared, &visit, &ignored);
    return !result && lacking ? fill_vertices(work) : result;
}

static norma_result check_split_room(
    const core_prepared_mesh *prepared, const split_output *out, size_t count) {
    if (out->corners && prepared->mesh.corner_count > out->corner_capacity)
        return NORMA_ERROR_CAPACITY;
    if ((out->source_vertices || out->normals) && count > out->vertex_capacity)
        return NORMA_ERROR_CAPACITY;
    return out->normals && count > SIZE_MAX / prepared->call->options.normal_stride
               ? NORMA_ERROR_OVERFLOW
               : NORMA_OK;
}

/* The first pass. */
static norma_result find_firsts(split_work *work, const norma_report *report, stars_part *sum) {
    core_prepared_mesh *prepared = work->prepared;
    const position_visit visit = {.join = CORE_JOIN_FANS,
        .counting = norma_core_counts_edges(prepared->call, report),
        .see = see_to_number,
        .context = work};
    norma_core_stage(prepared->call, 0.5, 0.75);
    return norma_core_visit_positions(prepared, &visit, sum);
}

static norma_result split_and_report(
    core_prepared_mesh *prepared, split_work *work, const split_output *out, norma_report *report) {
    core_call *call = prepared->call;
    stars_part sum = {.tally.degenerate = prepared->degenerate_faces};
    size_t count;
    norma_result result = find_firsts(work, report, &sum);
    norma_core_stage(call, 0.75, 0.76);
    if (!result) result = count_vertices(work, &count);
    if (!result) result = check_split_room(prepared, out, count);
    if (result) return result;
    const int lacking =
        sum.tally.non_finite.count || sum.tally.unreferenced.count || sum.tally.cancelled.count;
    if (out->corners || out->source_vertices || out->normals)
        result = write_split(work, lacking && work->normals && work->output.nearest);
    if (result) return result;
    norma_core_write_report(report, &sum.tally, &sum.counts.non_manifold, &sum.counts.conflicts);
    if (call->options.edges) *call->options.edges = sum.counts.edges;
    if (out->vertex_count) *out->vertex_count = count;
    return NORMA_OK;
}

static void release_work(const core_call *call, split_work *work) {
    const size_t corners = work->prepared->mesh.corner_count,
                 positions = work->prepared->mesh.positions.count;
    norma_core_release(call, work->firsts, corners, 1);
    norma_core_release(call, work->before, firsts_counts(work) + 1, sizeof *work->before);
    norma_core_release(call, work->single, positions, 1);
    release_normals(work);
    norma_core_release(call, work->vertices, positions, sizeof *work->vertices);
    norma_core_release(call, work->reasons, corners, 1);
    norma_core_release(call, work->wanted, corners, 1);
    if (!work->few) return;
    norma_core_release(call, work->few, work->few_count, sizeof *work->few);
    work->prepared->corners_of.corners = NULL;
    work->prepared->corners_of.corner_count = corners;
}

static norma_result allocate_work(const core_call *call, split_work *work, int with_normals) {
    const size_t corners = work->prepared->mesh.corner_count,
                 positions = work->prepared->mesh.positions.count;
    work->firsts = norma_core_allocate(call, corners, 1);
    work->before = norma_core_allocate(call, firsts_counts(work) + 1, sizeof *work->before);
    work->single = norma_core_allocate(call, positions, 1);
    if (with_normals) work->normals = norma_core_allocate(call, positions, sizeof *work->normals);
    if (!work->firsts || !work->before || !work->single || (!work->normals && with_normals))
        return NORMA_ERROR_MEMORY;
    memset(work->firsts, 0, corners);
    memset(work->single, 0, positions);
    return NORMA_OK;
}

static norma_result split_prepared(
    core_prepared_mesh *prepared, const split_output *out, norma_report *report) {
    split_work work = {
        .prepared = prepared, .numbers = out->corners, .source_vertices = out->source_vertices};
    norma_result result = norma_core_output_open(prepared->call, out->normals, 0, 0, &work.output);
    if (!result) result = allocate_work(prepared->call, &work, out->normals != NULL);
    if (!result) result = split_and_report(prepared, &work, out, report);
    release_work(prepared->call, &work);
    return result;
}

/* The mesh's corners are read again after new ones have been written. */
static int overlaps_corners(const core_mesh *mesh, const uint32_t *corners) {
    const uintptr_t old = (uintptr_t)mesh->corners, new = (uintptr_t)corners;
    return corners && mesh->corners &&
           new < old + mesh->corner_count * mesh->corner_size &&old <
               new + mesh->corner_count * sizeof *corners;
}

norma_result norma_split(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, uint32_t *corners, size_t corner_capacity,
    uint32_t *source_vertices, float *normals, size_t vertex_capacity, size_t *vertex_count,
    norma_report *report) {
    const split_output out = {
        corners, source_vertices, normals, corner_capacity, vertex_capacity, vertex_count};
    core_call call;
    core_mesh checked;
    core_prepared_mesh prepared;
    norma_result result =
        norma_core_begin_with_crease(&call, options, mesh, crease_angle_rad, &checked);
    if (!result && overlaps_corners(&checked, corners)) result = NORMA_ERROR_ARGUMENT;
    if (!result && corners && checked.corner_count > corner_capacity) result = NORMA_ERROR_CAPACITY;
    if (result) return result;
    norma_core_gather(&call);
    result = norma_core_prepare_fans(&call, &checked, crease_angle_rad, &prepared);
    if (!result) {
        result = norma_core_finish(&call, split_prepared(&prepared, &out, report));
        norma_core_prepared_mesh_close(&prepared);
    }
    norma_core_dismiss(&call);
    return result;
}

norma_result norma_split_mesh(const norma_mesh *mesh, float crease_angle_rad,
    const norma_options *options, norma_split_output *split, norma_report *report) {
    if (!split) return NORMA_ERROR_ARGUMENT;
    return norma_split(mesh, crease_angle_rad, options, split->corners, split->corner_capacity,
        split->source_vertices, split->normals, split->vertex_capacity, &split->vertex_count,
        report);
}
