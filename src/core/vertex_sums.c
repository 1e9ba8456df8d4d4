/* vertex_sums.c: the weighted sum at each position. Faces are gone through in ascending order, eight triangles at a time, and each adds to the sums of its corners;
 * when several work, each owns a range of positions and passes over the chunks of faces that do not touch it. So every sum is taken in the same order
 * whoever takes it. */
#include "vertices.h"
#include <math.h>

enum { FACES_IN_CHUNK = 1024, FEWEST_FACES_TO_SHARE = 1 << 15, RANGES_FOR_JOBS = 8, MOST_RANGES = 64 };
enum { AHEAD = 96 };                       /* corners between asking for memory and using it */

typedef struct position_range { uint32_t begin, end; } position_range;   /* from begin to before end; of a chunk of faces: what they touch */

typedef struct sum_work {
    core_vertices  *vertices;
    size_t          ranges, chunks;
    position_range *touched;               /* by each chunk; NULL for one range */
    norma_count     degenerate[MOST_RANGES];
} sum_work;

static int owns(position_range range, uint32_t position) { return position >= range.begin && position < range.end; }

static void add(vertex_sum *sum, double weight, const double normal[3])
{
    sum->x += weight * normal[0];
    sum->y += weight * normal[1];
    sum->z += weight * normal[2];
    sum->weight += weight;
}

/* ---- one face by itself: a polygon, or a triangle that doubles do not decide */

static void add_face(const core_vertices *vertices, position_range range, size_t f, norma_count *degenerate)
{
    const core_surface *surface = vertices->surface;
    const core_mesh *mesh = &surface->mesh;
    const size_t begin = norma_core_face_begin(mesh, f), end = norma_core_face_end(mesh, f);
    core_face face;
    norma_core_surface_face(surface, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) {
        if (!surface->faces && (face.flags & CORE_FACE_FINITE) && owns(range, norma_core_welded_corner(mesh, begin))) norma_core_count_one(degenerate, f);
        return;
    }
    for (size_t c = begin; c < end; c++) {
        const uint32_t position = norma_core_welded_corner(mesh, c);
        if (!owns(range, position) || !norma_core_is_kept(mesh, f, c)) continue;
        add(&vertices->sums[position], norma_core_corner_weight(mesh, surface->call->options.weight, f, &face, c), face.normal);
    }
}

/* ---- triangles, some at a time */

typedef struct triangle_lanes {
    core_batch batch;
    uint32_t   welded[3][CORE_LANES];
} triangle_lanes;

static int load_lane(const core_mesh *mesh, size_t f, triangle_lanes *t, int lane)
{
    double p[3][3];
    for (size_t i = 0; i < 3; i++) {
        const uint32_t at = norma_core_corner(mesh, 3 * f + i);
        t->welded[i][lane] = norma_core_welded(mesh, at);
        norma_core_position(mesh, at, p[i]);
    }
    for (int i = 0; i < 3; i++) {
        t->batch.u[i][lane] = p[1][i] - p[0][i];
        t->batch.v[i][lane] = p[2][i] - p[0][i];
        t->batch.a[i][lane] = p[2][i] - p[1][i];
    }
    const uint32_t a = t->welded[0][lane], b = t->welded[1][lane], c = t->welded[2][lane];
    return a != b && b != c && c != a;
}

static void add_lane(const core_vertices *vertices, position_range range, const triangle_lanes *t, int lane)
{
    const double normal[3] = {t->batch.normal[0][lane], t->batch.normal[1][lane], t->batch.normal[2][lane]};
    for (int i = 0; i < 3; i++)
        if (owns(range, t->welded[i][lane])) add(&vertices->sums[t->welded[i][lane]], t->batch.weight[i][lane], normal);
}

/* Asks for the memory of corners to come: their positions, and their sums where that takes no further look. */
static void look_ahead(const core_vertices *vertices, size_t f)
{
    const core_mesh *mesh = &vertices->surface->mesh;
    for (size_t c = 3 * f + AHEAD; c < 3 * (f + CORE_LANES) + AHEAD && c < mesh->corner_count; c++) {
        const uint32_t at = norma_core_corner(mesh, c);
        __builtin_prefetch((const unsigned char *)mesh->positions.data + at * mesh->positions.stride);
        if (mesh->weld) __builtin_prefetch(&mesh->weld[at]);
        else __builtin_prefetch(&vertices->sums[at], 1);
    }
}

static void add_triangles(const core_vertices *vertices, position_range range, size_t begin, size_t end, norma_count *degenerate)
{
    const core_call *call = vertices->surface->call;
    triangle_lanes t;
    int edged[CORE_LANES];
    for (size_t f = begin; f < end; f += CORE_LANES) {
        const int lanes = end - f < CORE_LANES ? (int)(end - f) : CORE_LANES;
        look_ahead(vertices, f);
        for (int i = 0; i < CORE_LANES; i++) edged[i] = load_lane(&vertices->surface->mesh, i < lanes ? f + (size_t)i : f, &t, i);
        call->measure(&t.batch, call->options.weight, CORE_ALL_CORNERS);
        for (int i = 0; i < lanes; i++) {
            if (edged[i] && t.batch.sure[i] != 0) add_lane(vertices, range, &t, i);
            else add_face(vertices, range, f + (size_t)i, degenerate);
        }
    }
}

/* ---- chunks and ranges */

static void chunk_faces(const sum_work *work, size_t chunk, size_t *begin, size_t *end)
{
    const size_t count = work->vertices->surface->mesh.face_count;
    *begin = chunk * FACES_IN_CHUNK;
    *end = count - *begin < FACES_IN_CHUNK ? count : *begin + FACES_IN_CHUNK;
}

static void touch_chunk(void *context, size_t chunk)
{
    const sum_work *work = context;
    const core_mesh *mesh = &work->vertices->surface->mesh;
    position_range touched = {UINT32_MAX, 0};
    size_t begin, end;
    chunk_faces(work, chunk, &begin, &end);
    for (size_t c = norma_core_face_begin(mesh, begin); c < norma_core_face_end(mesh, end - 1); c++) {
        const uint32_t position = norma_core_welded_corner(mesh, c);
        if (position < touched.begin) touched.begin = position;
        if (position >= touched.end) touched.end = position + 1;
    }
    work->touched[chunk] = touched;
}

static void add_chunk(sum_work *work, size_t range_number, position_range range, size_t chunk)
{
    const core_surface *surface = work->vertices->surface;
    size_t begin, end;
    if (work->touched && (work->touched[chunk].begin >= range.end || work->touched[chunk].end <= range.begin)) return;
    chunk_faces(work, chunk, &begin, &end);
    if (!surface->faces) add_triangles(work->vertices, range, begin, end, &work->degenerate[range_number]);
    else
        for (size_t f = begin; f < end; f++) add_face(work->vertices, range, f, &work->degenerate[range_number]);
}

static position_range range_of(const sum_work *work, size_t number)
{
    const uint64_t count = work->vertices->count;
    return (position_range){(uint32_t)(count * number / work->ranges), (uint32_t)(count * (number + 1) / work->ranges)};
}

static void sum_range(void *context, size_t number)
{
    sum_work *work = context;
    const position_range range = range_of(work, number);
    for (size_t v = range.begin; v < range.end; v++) work->vertices->sums[v] = (vertex_sum){0, 0, 0, -0.0};
    for (size_t chunk = 0; chunk < work->chunks; chunk++) add_chunk(work, number, range, chunk);
}

/* Alone, chunks are what progress is told by. */
static norma_result sum_alone(sum_work *work)
{
    enum { CHUNKS_BETWEEN_TELLING = 64 };
    const position_range range = range_of(work, 0);
    for (size_t v = 0; v < range.end; v++) work->vertices->sums[v] = (vertex_sum){0, 0, 0, -0.0};
    for (size_t chunk = 0; chunk < work->chunks; chunk++) {
        if (chunk % CHUNKS_BETWEEN_TELLING == 0 && norma_core_progress(work->vertices->surface->call, (double)chunk / (double)work->chunks)) return NORMA_CANCELLED;
        add_chunk(work, 0, range, chunk);
    }
    return NORMA_OK;
}

static norma_result sum_shared(sum_work *work)
{
    core_call *call = work->vertices->surface->call;
    work->touched = norma_core_allocate(call, work->chunks, sizeof *work->touched);
    if (!work->touched) return NORMA_ERROR_MEMORY;
    norma_result result = norma_core_parallel(call, work->chunks, touch_chunk, work);
    if (result == NORMA_OK) result = norma_core_parallel(call, work->ranges, sum_range, work);
    norma_core_release(call, work->touched, work->chunks, sizeof *work->touched);
    return result;
}

static size_t ranges_for(const core_surface *surface)
{
    const core_call *call = surface->call;
    if (call->options.parallel_for) return RANGES_FOR_JOBS;
    if (surface->mesh.face_count < FEWEST_FACES_TO_SHARE) return 1;
    const size_t workers = norma_core_workers(call);
    return workers < MOST_RANGES ? workers : MOST_RANGES;
}

/* ---- sums that cancel: once more, over the corners of each vertex alone */

static void sum_of(const vertex_sum *s, double sum[3])
{
    sum[0] = s->x;
    sum[1] = s->y;
    sum[2] = s->z;
}

static int has_votes(const vertex_sum *s) { return !signbit(s->weight); }

static int cancels(const vertex_sum *s)
{
    double sum[3];
    sum_of(s, sum);
    return has_votes(s) && norma_core_cancels(sum, s->weight);
}

static void add_own(core_vertices *vertices, size_t f)
{
    const core_surface *surface = vertices->surface;
    const core_mesh *mesh = &surface->mesh;
    core_face face;
    norma_core_surface_face(surface, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) return;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++) {
        const uint32_t number = vertices->own[norma_core_corner(mesh, c)];
        if (number == UINT32_MAX || !norma_core_is_kept(mesh, f, c)) continue;
        add(&vertices->own_sums[number], norma_core_corner_weight(mesh, surface->call->options.weight, f, &face, c), face.normal);
    }
}

static int touches_own(const core_vertices *vertices, size_t f)
{
    const core_mesh *mesh = &vertices->surface->mesh;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++)
        if (vertices->own[norma_core_corner(mesh, c)] != UINT32_MAX) return 1;
    return 0;
}

static norma_result sum_own(core_vertices *vertices)
{
    const core_call *call = vertices->surface->call;
    const core_mesh *mesh = &vertices->surface->mesh;
    size_t cancelled = 0;
    for (size_t v = 0; v < vertices->count; v++) cancelled += (size_t)cancels(&vertices->sums[norma_core_welded(mesh, (uint32_t)v)]);
    if (!cancelled || !mesh->weld) return NORMA_OK;
    vertices->own = norma_core_allocate(call, vertices->count, sizeof *vertices->own);
    vertices->own_sums = norma_core_allocate(call, cancelled, sizeof *vertices->own_sums);
    vertices->own_count = cancelled;
    if (!vertices->own || !vertices->own_sums) return NORMA_ERROR_MEMORY;
    uint32_t number = 0;
    for (size_t v = 0; v < vertices->count; v++) vertices->own[v] = cancels(&vertices->sums[mesh->weld[v]]) ? number++ : UINT32_MAX;
    for (size_t i = 0; i < cancelled; i++) vertices->own_sums[i] = (vertex_sum){0, 0, 0, -0.0};
    for (size_t f = 0; f < mesh->face_count; f++)
        if (touches_own(vertices, f)) add_own(vertices, f);
    return NORMA_OK;
}

int norma_core_resolve_sum(const core_vertices *vertices, size_t vertex, float normal[3])
{
    const core_mesh *mesh = &vertices->surface->mesh;
    const int by_vertex = vertices->own && vertices->own[vertex] != UINT32_MAX;
    const vertex_sum *s = by_vertex ? &vertices->own_sums[vertices->own[vertex]] : &vertices->sums[norma_core_welded(mesh, (uint32_t)vertex)];
    double sum[3];
    if (!has_votes(s)) {
        if (by_vertex) return NORMA_REASON_CANCELLED;
        norma_core_position(mesh, (uint32_t)vertex, sum);
        return norma_core_finite(sum) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    }
    sum_of(s, sum);
    if (norma_core_cancels(sum, s->weight)) return NORMA_REASON_CANCELLED;
    norma_core_direction(sum, normal);
    return NORMA_REASON_NONE;
}

norma_result norma_core_sum_vertices(core_surface *surface, core_vertices *vertices, core_tally *tally)
{
    const size_t count = surface->mesh.positions.count, faces = surface->mesh.face_count;
    *vertices = (core_vertices){.surface = surface, .count = count};
    vertices->sums = norma_core_allocate(surface->call, count, sizeof *vertices->sums);
    if (!vertices->sums) return NORMA_ERROR_MEMORY;
    sum_work work = {.vertices = vertices, .ranges = ranges_for(surface), .chunks = faces / FACES_IN_CHUNK + (faces % FACES_IN_CHUNK != 0)};
    norma_result result = work.ranges > 1 ? sum_shared(&work) : sum_alone(&work);
    if (result == NORMA_OK) result = sum_own(vertices);
    norma_core_count_add(&tally->degenerate, &surface->degenerate_faces);
    for (size_t i = 0; i < work.ranges; i++) norma_core_count_add(&tally->degenerate, &work.degenerate[i]);
    if (result != NORMA_OK) norma_core_release_vertices(vertices);
    return result;
}
