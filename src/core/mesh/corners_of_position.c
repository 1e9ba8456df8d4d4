/* corners_of_position.c: a counting sort of corners by position. Ascending corners at each position
 * are the order of every sum. Those who work together first count a part of the corners each, in
 * memory that the sorted corners will take, so that none needs memory of its own; then each adds up
 * and places the corners of a range of positions. There is room for a few counts only, but ranges
 * may be as many as work. */
#include "core/mesh/mesh.h"
#include "core/call/call.h"

enum { CORNERS_WORTH_A_PART = 1 << 17, MOST_PARTS = 8, MOST_RANGES = 64 };

typedef struct part_work {
    const core_mesh *mesh;
    core_corners_of_position *corners_of;
    size_t parts, ranges;         /* of corners; of positions */
    uint32_t listed[MOST_RANGES]; /* by each range: how many corners */
    uint32_t most[MOST_RANGES];   /* at one position of the range */
} part_work;

/* The first of a part of count things. */
static size_t begin_of(size_t count, size_t part, size_t parts) {
    const size_t rest = count % parts;
    return count / parts * part + (part < rest ? part : rest);
}
static size_t range_begin(const part_work *w, size_t range) {
    return begin_of(w->corners_of->position_count, range, w->ranges);
}

static uint32_t *counts_of_part(const part_work *w, size_t part) {
    return w->parts == 1 ? w->corners_of->starts + 1
                         : w->corners_of->corners + part * w->corners_of->position_count;
}

/* A loop without a question inside for each of what nearly all meshes are: indices of 32 bits. */
typedef enum corner_kind { ANY_CORNERS, PLAIN_CORNERS, WELDED_CORNERS } corner_kind;

static corner_kind corners_kind(const core_mesh *mesh) {
    if (mesh->corner_size != sizeof(uint32_t) || !mesh->corners) return ANY_CORNERS;
    return mesh->weld ? WELDED_CORNERS : PLAIN_CORNERS;
}

CORE_INLINE uint32_t position_of(const core_mesh *mesh, size_t corner, corner_kind kind) {
    uint32_t index;
    if (kind == ANY_CORNERS) return norma_core_welded_corner(mesh, corner);
    memcpy(&index, (const unsigned char *)mesh->corners + sizeof index * corner, sizeof index);
    return kind == WELDED_CORNERS ? mesh->weld[index] : index;
}

/* loop is compiled for each kind. */
#define LOOP_FOR_KIND(mesh, loop, ...)                                                             \
    switch (corners_kind(mesh)) {                                                                  \
    case ANY_CORNERS:                                                                              \
        loop(__VA_ARGS__, ANY_CORNERS);                                                            \
        break;                                                                                     \
    case PLAIN_CORNERS:                                                                            \
        loop(__VA_ARGS__, PLAIN_CORNERS);                                                          \
        break;                                                                                     \
    case WELDED_CORNERS:                                                                           \
        loop(__VA_ARGS__, WELDED_CORNERS);                                                         \
        break;                                                                                     \
    }

CORE_INLINE void count_range(
    const core_mesh *mesh, size_t begin, size_t end, uint32_t *counts, corner_kind kind) {
    for (size_t c = begin; c < end; ++c) ++counts[position_of(mesh, c, kind)];
}

static void count_part(void *context, size_t part) {
    const part_work *w = context;
    const size_t begin = begin_of(w->mesh->corner_count, part, w->parts),
                 end = begin_of(w->mesh->corner_count, part + 1, w->parts);
    uint32_t *counts = counts_of_part(w, part);
    memset(counts, 0, w->corners_of->position_count * sizeof *counts);
    LOOP_FOR_KIND(w->mesh, count_range, w->mesh, begin, end, counts)
}

/* The counts of all parts lie where corners will be placed, so all are added up before any is. */
static void add_up_range(void *context, size_t range) {
    part_work *w = context;
    uint32_t *sums = w->corners_of->starts + 1, listed = 0, most = 0;
    const uint32_t *first = counts_of_part(w, 0);
    const size_t end = range_begin(w, range + 1);
    for (size_t p = range_begin(w, range); p < end; ++p) {
        uint32_t count = first[p];
        for (size_t part = 1; part < w->parts; ++part) count += counts_of_part(w, part)[p];
        sums[p] = count;
        listed += count;
        most = count > most ? count : most;
    }
    w->listed[range] = listed;
    w->most[range] = most;
}

/* Where each position's first corner will go, one entry further on than its start will be found:
 * placing moves it to where the next position starts. */
static void turn_into_places(const part_work *w, size_t range) {
    uint32_t *places = w->corners_of->starts + 1, sum = 0;
    const size_t end = range_begin(w, range + 1);
    for (size_t before = 0; before < range; ++before) sum += w->listed[before];
    for (size_t p = range_begin(w, range); p < end; ++p) {
        const uint32_t count = places[p];
        places[p] = sum;
        sum += count;
    }
}

CORE_INLINE void place_between(
    const part_work *w, uint32_t first, uint32_t count, corner_kind kind) {
    const core_mesh *mesh = w->mesh;
    uint32_t *places = w->corners_of->starts + 1, *corners = w->corners_of->corners;
    for (size_t c = 0; c < mesh->corner_count; ++c) {
        const uint32_t p = position_of(mesh, c, kind);
        if (p - first < count) corners[places[p]++] = (uint32_t)c;
    }
}

CORE_INLINE void place_all(const part_work *w, corner_kind kind) {
    uint32_t *places = w->corners_of->starts + 1, *corners = w->corners_of->corners;
    for (size_t c = 0; c < w->mesh->corner_count; ++c)
        corners[places[position_of(w->mesh, c, kind)]++] = (uint32_t)c;
}

static void place_range(void *context, size_t range) {
    const part_work *w = context;
    const uint32_t begin = (uint32_t)range_begin(w, range),
                   end = (uint32_t)range_begin(w, range + 1);
    turn_into_places(w, range);
    if (w->ranges == 1)
        LOOP_FOR_KIND(w->mesh, place_all, w)
    else
        LOOP_FOR_KIND(w->mesh, place_between, w, begin, end - begin)
}

static void name_faces(const core_mesh *mesh, core_corners_of_position *corners_of) {
    for (size_t f = 0; f < mesh->face_count; ++f)
        for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); ++c)
            corners_of->faces[c] = (uint32_t)f;
}

static size_t smaller(size_t a, size_t b) { return a < b ? a : b; }

/* As many as may work, each with enough to do, and all their counts with room among the sorted
 * corners; one alone counts where the starts will be. */
static void choose_parts(const core_call *call, part_work *w) {
    const size_t corners = w->corners_of->corner_count, positions = w->corners_of->position_count,
                 by_size = 1 + corners / CORNERS_WORTH_A_PART,
                 by_memory = positions ? corners / positions : 0;
    w->ranges = smaller(MOST_RANGES, smaller(norma_core_workers(call), by_size));
    w->parts = smaller(MOST_PARTS, smaller(w->ranges, by_memory ? by_memory : 1));
}

/* Runs a step of the sort, this part of the whole. */
static norma_result run_step(
    core_call *call, part_work *w, double from, double to, size_t count, norma_task *task) {
    norma_core_stage(call, from, to);
    return norma_core_parallel(call, count, task, w);
}

static norma_result place_corners_by_position(
    core_call *call, const core_mesh *mesh, core_corners_of_position *corners_of) {
    const double from = call->progress_from, to = call->progress_to, half = (from + to) / 2;
    part_work w = {.mesh = mesh, .corners_of = corners_of};
    choose_parts(call, &w);
    norma_result result = run_step(call, &w, from, half, w.parts, count_part);
    if (!result) result = run_step(call, &w, half, half, w.ranges, add_up_range);
    if (!result) result = run_step(call, &w, half, to, w.ranges, place_range);
    corners_of->starts[0] = 0;
    for (size_t range = 0; range < w.ranges; ++range)
        if (w.most[range] > corners_of->most) corners_of->most = w.most[range];
    return result;
}

norma_result norma_core_corners_of_position_build(
    core_call *call, const core_mesh *mesh, core_corners_of_position *corners_of) {
    *corners_of = (core_corners_of_position){
        .position_count = mesh->positions.count, .corner_count = mesh->corner_count};
    corners_of->starts =
        norma_core_allocate(call, corners_of->position_count + 1, sizeof *corners_of->starts);
    corners_of->corners =
        norma_core_allocate(call, corners_of->corner_count, sizeof *corners_of->corners);
    if (norma_core_face_starts(mesh))
        corners_of->faces =
            norma_core_allocate(call, corners_of->corner_count, sizeof *corners_of->faces);
    norma_result result = NORMA_ERROR_MEMORY;
    if (corners_of->starts && corners_of->corners &&
        (!norma_core_face_starts(mesh) || corners_of->faces))
        result = place_corners_by_position(call, mesh, corners_of);
    if (!result && norma_core_face_starts(mesh)) name_faces(mesh, corners_of);
    if (result) norma_core_corners_of_position_release(call, corners_of);
    return result;
}

void norma_core_corners_of_position_release(
    const core_call *call, core_corners_of_position *corners_of) {
    norma_core_release(
        call, corners_of->starts, corners_of->position_count + 1, sizeof *corners_of->starts);
    norma_core_release(
        call, corners_of->corners, corners_of->corner_count, sizeof *corners_of->corners);
    norma_core_release(
        call, corners_of->faces, corners_of->corner_count, sizeof *corners_of->faces);
    *corners_of = (core_corners_of_position){0};
}
