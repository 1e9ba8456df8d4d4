/* mesh.c: what must hold of a mesh before anything is computed or written: first its shape, then
 * what its arrays say; and the corners at each position. */
#include "core/mesh/mesh.h"
#include "core/call/call.h"
#include <math.h>
#include <stdatomic.h>

typedef core_range core_range_of(const unsigned char *corners, size_t count);

static norma_result check_positions(const norma_vec3_view *view, norma_fault *fault) {
    if (!norma_format_size(view->format))
        return norma_core_refuse(
            fault, NORMA_ERROR_ARGUMENT, "mesh->positions.format", SIZE_MAX, "a norma_format");
    if (view->count && !view->data)
        return norma_core_refuse(
            fault, NORMA_ERROR_ARGUMENT, "mesh->positions.data", SIZE_MAX, "not NULL");
    if (norma_view_overflows(view) || view->count > UINT32_MAX - 1)
        return norma_core_refuse(fault, NORMA_ERROR_OVERFLOW, "mesh->positions.count", SIZE_MAX,
            "below 2^32 - 1, and count * stride fits a size_t");
    return NORMA_OK;
}

static norma_result check_corner_count(const norma_mesh *mesh, norma_fault *fault) {
    if (!mesh->corners && mesh->corner_count > mesh->positions.count)
        return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "mesh->corner_count", SIZE_MAX,
            "without corners at most mesh->positions.count");
    if (!mesh->face_starts && mesh->corner_count % 3)
        return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "mesh->corner_count", SIZE_MAX,
            "a multiple of three, as there are no face_starts");
    if (mesh->corner_count > UINT32_MAX - 1)
        return norma_core_refuse(
            fault, NORMA_ERROR_OVERFLOW, "mesh->corner_count", SIZE_MAX, "below 2^32 - 1");
    if (mesh->face_starts && mesh->face_count > UINT32_MAX - 1)
        return norma_core_refuse(
            fault, NORMA_ERROR_OVERFLOW, "mesh->face_count", SIZE_MAX, "below 2^32 - 1");
    return NORMA_OK;
}

norma_result norma_core_check_shape(
    const norma_mesh *mesh, core_mesh *checked, norma_fault *fault) {
    if (!mesh) return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "mesh", SIZE_MAX, "not NULL");
    norma_result result = check_positions(&mesh->positions, fault);
    if (!result && mesh->corner_size != 0 && mesh->corner_size != 1 && mesh->corner_size != 2 &&
        mesh->corner_size != 4)
        result = norma_core_refuse(
            fault, NORMA_ERROR_ARGUMENT, "mesh->corner_size", SIZE_MAX, "4 (or 0), 2 or 1 bytes");
    if (!result) result = check_corner_count(mesh, fault);
    if (result) return result;
    *checked = (core_mesh){
        .positions = mesh->positions,
        .corners = mesh->corners,
        .corner_count = mesh->corner_count,
        .corner_size = !mesh->corners      ? 0
                       : mesh->corner_size ? mesh->corner_size
                                           : 4,
        .face_starts = mesh->face_starts,
        .face_count = mesh->face_starts ? mesh->face_count : mesh->corner_count / 3,
        .smoothing_groups = mesh->smoothing_groups,
        .hard_edges = mesh->hard_edges,
        .scale = 1,
    };
    checked->positions.stride = norma_view_stride(&mesh->positions);
    return NORMA_OK;
}

uint32_t norma_core_small_corner(const core_mesh *mesh, size_t corner) {
    return mesh->corner_size ? norma_index_read(mesh->corners, mesh->corner_size, corner)
                             : (uint32_t)corner;
}

CORE_INLINE void read_corners(
    const void *corners, size_t size, size_t begin, size_t count, uint32_t *positions) {
    for (size_t i = 0; i < count; ++i)
        positions[i] = size ? norma_index_read(corners, size, begin + i) : (uint32_t)(begin + i);
}

/* A loop for each size, without a question inside. */
void norma_core_read_corners(
    const core_mesh *mesh, size_t begin, size_t count, uint32_t *positions) {
    if (mesh->corner_size == 4)
        read_corners(mesh->corners, 4, begin, count, positions);
    else if (mesh->corner_size == 2)
        read_corners(mesh->corners, 2, begin, count, positions);
    else if (mesh->corner_size == 1)
        read_corners(mesh->corners, 1, begin, count, positions);
    else
        read_corners(NULL, 0, begin, count, positions);
}

void norma_core_other_position(const core_mesh *mesh, uint32_t index, double out[3]) {
    if (mesh->positions.format == NORMA_FORMAT_DOUBLE)
        norma_core_double_position(mesh, index, out);
    else
        norma_view_read(&mesh->positions, index, out);
}

norma_result norma_core_mesh_shape(const norma_mesh *mesh, core_mesh *checked) {
    return norma_core_check_shape(mesh, checked, NULL);
}

norma_result norma_core_check_face_starts(const core_mesh *mesh, norma_fault *fault) {
    const uint32_t *starts = mesh->face_starts;
    const size_t faces = mesh->face_count;
    if (!starts) return NORMA_OK;
    if (starts[0] != 0 || starts[faces] != mesh->corner_count)
        return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "mesh->face_starts",
            starts[0] != 0 ? 0 : faces, "0 at the first and mesh->corner_count at the last");
    for (size_t f = 0; f < faces; ++f)
        if (starts[f] > starts[f + 1])
            return norma_core_refuse(
                fault, NORMA_ERROR_ARGUMENT, "mesh->face_starts", f + 1, "at least the one before");
    return NORMA_OK;
}

/* A mesh with face_starts may still consist of triangles only. */
static int all_are_triangles(const core_mesh *mesh) {
    if (mesh->corner_count != 3 * mesh->face_count) return 0;
    for (size_t f = 0; f < mesh->face_count; ++f)
        if (mesh->face_starts[f] != 3 * f) return 0;
    return 1;
}

/* ---- what corners name: checked, and kept as one range for each chunk of faces */

enum { FACES_IN_TASK = 32 * CORE_FACES_IN_CHUNK };

typedef struct corner_check {
    const core_mesh *mesh;
    core_range *ranges; /* NULL, or of each chunk */
    core_range_of *range_of;
    atomic_int wrong;
} corner_check;

CORE_INLINE core_range range_of_indices(const unsigned char *corners, size_t count) {
    uint32_t least = UINT32_MAX, most = 0;
    for (size_t c = 0; c < count; ++c) {
        uint32_t index;
        memcpy(&index, corners + 4 * c, sizeof index);
        least = index < least ? index : least;
        most = index > most ? index : most;
    }
    return (core_range){least, most};
}

static core_range range_portable(const unsigned char *corners, size_t count) {
    return range_of_indices(corners, count);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static core_range range_avx2(const unsigned char *corners, size_t count) {
    return range_of_indices(corners, count);
}
static core_range_of *const RANGE_OF[] = {range_portable, range_avx2, range_avx2};
#else
static core_range_of *const RANGE_OF[] = {range_portable};
#endif

static core_range range_of_corners(const corner_check *check, size_t begin, size_t end) {
    const core_mesh *mesh = check->mesh;
    if (mesh->corner_size == 4)
        return check->range_of((const unsigned char *)mesh->corners + 4 * begin, end - begin);
    core_range range = {UINT32_MAX, 0};
    for (size_t c = begin; c < end; ++c) {
        const uint32_t index = norma_core_corner(mesh, c);
        range.least = index < range.least ? index : range.least;
        range.most = index > range.most ? index : range.most;
    }
    return range;
}

static void check_task(void *context, size_t task) {
    corner_check *check = context;
    const core_mesh *mesh = check->mesh;
    const size_t begin = task * FACES_IN_TASK, faces = mesh->face_count,
                 end = faces - begin < FACES_IN_TASK ? faces : begin + FACES_IN_TASK;
    for (size_t f = begin, next; f < end; f = next) {
        next = end - f < CORE_FACES_IN_CHUNK ? end : f + CORE_FACES_IN_CHUNK;
        const size_t first = norma_core_face_begin(mesh, f),
                     last = norma_core_face_begin(mesh, next);
        const core_range range =
            first < last ? range_of_corners(check, first, last) : (core_range){0, 0};
        if (first < last && range.most >= mesh->positions.count)
            atomic_store_explicit(&check->wrong, 1, memory_order_relaxed);
        if (check->ranges) check->ranges[f / CORE_FACES_IN_CHUNK] = range;
    }
}

static norma_result check_corners(core_call *call, const core_mesh *mesh, core_range *ranges) {
    corner_check check = {
        .mesh = mesh, .ranges = ranges, .range_of = RANGE_OF[norma_core_level(call->options.isa)]};
    if (!mesh->corner_size && !ranges) return NORMA_OK;
    const norma_result result = norma_core_parallel(call,
        mesh->face_count / FACES_IN_TASK + (mesh->face_count % FACES_IN_TASK != 0), check_task,
        &check);
    if (result) return result;
    return atomic_load_explicit(&check.wrong, memory_order_relaxed) ? NORMA_ERROR_INDEX : NORMA_OK;
}

double norma_core_largest_coordinate(const core_mesh *mesh) {
    const unsigned char *at = mesh->positions.data;
    double largest = 0;
    for (size_t i = 0; i < mesh->positions.count; ++i, at += mesh->positions.stride) {
        double p[3];
        memcpy(p, at, sizeof p);
        const double x = fabs(p[0]), y = fabs(p[1]), z = fabs(p[2]), xy = x > y ? x : y,
                     most = xy > z ? xy : z;
        if (most > largest && norma_core_finite(p)) largest = most;
    }
    return largest;
}

/* Products of four lengths must fit a double: beyond 2^200 or below 2^-200 all positions are read
 * times a power of two. */
double norma_core_scale_for(double largest) {
    if (largest == 0 || (largest > 0x1p-200 && largest < 0x1p200)) return 1;
    const int exponent = ilogb(largest);
    return ldexp(1, exponent < -1000 ? 1000 : -exponent);
}

norma_result norma_core_mesh_content(core_call *call, core_mesh *mesh) {
    return norma_core_mesh_ranges(call, mesh, NULL);
}

norma_result norma_core_mesh_ranges(core_call *call, core_mesh *mesh, core_range *ranges) {
    const norma_result starts =
        norma_core_face_starts(mesh) ? norma_core_check_face_starts(mesh, NULL) : NORMA_OK;
    if (starts) return starts;
    if (norma_core_face_starts(mesh) && all_are_triangles(mesh)) mesh->face_starts = NULL;
    const norma_result result = check_corners(call, mesh, ranges);
    if (!result && mesh->positions.format == NORMA_FORMAT_DOUBLE)
        mesh->scale = norma_core_scale_for(norma_core_largest_coordinate(mesh));
    return result;
}

/* ---- the caller's arrays, element by element, for callers. */

void norma_view_vector(const norma_vec3_view *view, size_t index, double out[3]) {
    norma_view_read(view, index, out);
}

uint32_t norma_mesh_corner(const norma_mesh *mesh, size_t corner) {
    const unsigned char *corners = mesh->corners;
    if (!corners) return (uint32_t)corner;
    return norma_index_read(
        corners, mesh->corner_size ? mesh->corner_size : sizeof(uint32_t), corner);
}

/* ---- meshes whose faces name positions far apart */

static uint32_t distance(uint32_t a, uint32_t b) { return a < b ? b - a : a - b; }

/* How far the corners of some faces in a row lie from the nearest of the faces before: two to four
 * corners back, so that one vertex of all faces is not far from itself. */
static double look_at(const core_mesh *mesh, size_t begin, size_t count) {
    uint32_t at[4];
    double sum = 0;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t here = norma_core_corner(mesh, begin + i);
        uint32_t nearest = i < 4 ? 0 : UINT32_MAX;
        for (size_t back = 2; back <= 4 && i >= 4; ++back) {
            const uint32_t found = distance(here, at[(i - back) % 4]);
            nearest = found < nearest ? found : nearest;
        }
        at[i % 4] = here;
        sum += (double)nearest;
    }
    return sum;
}

/* Of faces in a row in a mesh in some order, corners lie near those before; in one in none, an
 * eighth of all positions away. The bound is an eighth of that. */
int norma_core_is_scattered(const core_mesh *mesh) {
    enum { LOOKS = 32, CORNERS_IN_LOOK = 96, FARTHEST = 64 };
    const size_t count = mesh->corner_count;
    double sum = 0;
    if (count < (size_t)LOOKS * CORNERS_IN_LOOK) return 0;
    for (size_t look = 0; look < LOOKS; ++look)
        sum += look_at(mesh, (count - CORNERS_IN_LOOK) / LOOKS * look, CORNERS_IN_LOOK);
    return FARTHEST * sum > (double)LOOKS * CORNERS_IN_LOOK * (double)mesh->positions.count;
}

/* ---- a counting sort of corners by position. Ascending corners at each position are the order of
 * every sum. Those who work together first count a part of the corners each, in memory that the
 * sorted corners will take, so that none needs memory of its own; then each adds up and places the
 * corners of a range of positions. There is room for a few counts only, but ranges may be as many
 * as work. */

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

static void count_part(void *context, size_t part) {
    const part_work *w = context;
    const size_t begin = begin_of(w->mesh->corner_count, part, w->parts),
                 end = begin_of(w->mesh->corner_count, part + 1, w->parts);
    uint32_t *counts = counts_of_part(w, part);
    memset(counts, 0, w->corners_of->position_count * sizeof *counts);
    for (size_t c = begin; c < end; ++c) ++counts[norma_core_welded_corner(w->mesh, c)];
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

static void place_range(void *context, size_t range) {
    const part_work *w = context;
    const uint32_t begin = (uint32_t)range_begin(w, range),
                   count = (uint32_t)range_begin(w, range + 1) - begin;
    uint32_t *places = w->corners_of->starts + 1, *corners = w->corners_of->corners;
    turn_into_places(w, range);
    for (size_t c = 0; c < w->mesh->corner_count; ++c) {
        const uint32_t p = norma_core_welded_corner(w->mesh, c);
        if (p - begin < count) corners[places[p]++] = (uint32_t)c;
    }
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
