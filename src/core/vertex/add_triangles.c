/* add_triangles.c: eight triangles at a time are read, measured and added; eight sums at a time
 * become normals. Compiled for each instruction set. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize(                                                                              \
    "no-tree-slp-vectorize") /* this compiler gathers neighbouring addresses into vectors, only to \
                                take them out again one by one */
#endif
#include "core/vertex/vertex.h"
#include "core/vertex/add_triangles_simd.h"
#include "core/vertex/add_eight_triangles.h"
#include "core/vertex/add_triangles_wasm.h"
#include "core/vertex/normalize_simd.h"
#include "core/face/measure_simd.h"

enum {
    AHEAD = 32,
    BATCHES_AT_ONCE = 8,
    FACES_TO_WIDEN = 256
}; /* AHEAD: triangles between asking for memory and using it */

typedef struct triangle_batch {
    core_batch measured;
    uint32_t at[3 * CORE_LANES]; /* the corners' positions, welded where they are */
} triangle_batch;

static int lanes_left(size_t f, size_t end) {
    return end - f < CORE_LANES ? (int)(end - f) : CORE_LANES;
}

/* ---- reading */

/* Lanes beyond the end repeat the first. */
static void read_few_corners(
    const core_mesh *mesh, size_t f, int lanes, uint32_t at[3 * CORE_LANES]) {
    for (int i = 0; i < CORE_LANES; i++)
        for (int k = 0; k < 3; k++)
            at[3 * i + k] =
                norma_core_corner(mesh, 3 * (i < lanes ? f + (size_t)i : f) + (size_t)k);
}

static void read_other_formats(const core_mesh *mesh, triangle_batch *t) {
    core_batch *m = &t->measured;
    for (int i = 0; i < CORE_LANES; i++) {
        double p[3][3];
        for (int k = 0; k < 3; k++) norma_core_position(mesh, t->at[3 * i + k], p[k]);
        for (int k = 0; k < 3; k++) {
            m->u[k][i] = p[1][k] - p[0][k];
            m->v[k][i] = p[2][k] - p[0][k];
            m->a[k][i] = p[2][k] - p[1][k];
        }
    }
}

CORE_INLINE void read_batch(const core_mesh *mesh, size_t f, int lanes, triangle_batch *t) {
    core_points points = core_points_of(mesh, t->at, 3);
    if (mesh->corner_size == 4 && lanes == CORE_LANES)
        memcpy(t->at, (const unsigned char *)mesh->corners + 12 * f, sizeof t->at);
    else
        read_few_corners(mesh, f, lanes, t->at);
    if (!core_can_gather(mesh))
        read_other_formats(mesh, t);
    else if (!points.doubles && points.stride == 3 * sizeof(float)) {
        points.stride = 3 * sizeof(float); /* a product that costs nothing */
        core_gather_edges(points, &t->measured);
    } else
        core_gather_edges(points, &t->measured);
    if (mesh->weld)
        for (int i = 0; i < 3 * CORE_LANES; i++) t->at[i] = mesh->weld[t->at[i]];
}

/* Asks for the memory of triangles to come, into the second cache, to which twice as many requests
 * are under way at once as to the first: positions, which may lie across two lines, and sums. Where
 * there is a map of welded positions, that is asked for earlier still. */
CORE_INLINE void look_at_triangles_ahead(const core_adder *adder, size_t f) {
    const core_mesh *mesh = adder->mesh;
    const size_t begin = 3 * (f + AHEAD), end = begin + (size_t)3 * CORE_LANES,
                 map = (size_t)3 * AHEAD;
    for (size_t c = begin; c < end && c < mesh->corner_count; c++) {
        const uint32_t at = norma_core_corner(mesh, c);
        const unsigned char *position =
            (const unsigned char *)mesh->positions.data + at * mesh->positions.stride;
        __builtin_prefetch(position, 0, 2);
        __builtin_prefetch(position + 11, 0, 2);
        const uint32_t sum = norma_core_welded(mesh, at) - adder->first;
        if (sum < adder->count) __builtin_prefetch(&adder->sums[sum], 0, 2);
        if (mesh->weld && c + map < mesh->corner_count)
            __builtin_prefetch(&mesh->weld[norma_core_corner(mesh, c + map)], 0, 2);
    }
}

/* ---- adding */

/* Where all corners weigh the same, weight[0] is that, and the normals are times that. */
CORE_INLINE void measure_batch(core_batch *m, norma_weight weight) {
    if (!core_weighs_evenly(weight)) {
        core_lanes_measure(m, CORE_ALL_CORNERS, weight);
        return;
    }
    core_lanes_measure(m, CORE_NO_CORNER, weight);
    for (int i = 0; i < CORE_LANES; i++) {
        m->weight[0][i] = norma_core_weight_of(weight, 0, 0, 0, 0, m->twice_area[i]);
        for (int x = 0; x < 3; x++) m->normal[x][i] *= m->weight[0][i];
    }
}

CORE_INLINE int all_sure(const core_batch *m) {
    double sure = 0;
    for (int i = 0; i < CORE_LANES; i++) sure += m->sure[i];
    return sure == CORE_LANES;
}

CORE_INLINE unsigned which_are_sure(const core_batch *m) {
    unsigned sure = 0;
    if (all_sure(m)) return CORE_ALL_SURE;
    for (int i = 0; i < CORE_LANES; i++) sure |= m->sure[i] != 0 ? 1U << i : 0;
    return sure;
}

CORE_INLINE core_eight batch_to_rows(
    const triangle_batch *t, norma_weight weight, core_rows *rows) {
    static const double ones[CORE_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};
    const core_batch *m = &t->measured;
    core_lanes_to_rows(m->normal[0], m->normal[1], m->normal[2],
        core_weighs_evenly(weight) ? m->weight[0] : ones, rows);
    return (core_eight){
        (const double(*)[4])rows->row, m->weight, (const unsigned char *)t->at, which_are_sure(m)};
}

CORE_INLINE void add_batch(
    const core_adder *adder, const triangle_batch *t, size_t f, int lanes, norma_weight weight) {
    core_rows rows;
    const core_eight eight = batch_to_rows(t, weight, &rows);
    core_add_eight(adder, &eight, f, lanes, weight);
}

CORE_INLINE void queue_batch(const core_adder *adder, const triangle_batch *t, size_t f, int lanes,
    size_t in_chunk, core_queue *queue, norma_weight weight) {
    static const double ones[CORE_LANES] = {1, 1, 1, 1, 1, 1, 1, 1};
    const core_eight eight = batch_to_rows(t, weight, (core_rows *)(void *)queue->row[in_chunk]);
    const double *w[3];
    for (int k = 0; k < 3; k++) w[k] = core_weighs_evenly(weight) ? ones : eight.weight[k];
    core_lanes_to_rows(w[0], w[1], w[2], ones, (core_rows *)(void *)queue->weight[in_chunk]);
    memcpy(queue->at + 3 * in_chunk, t->at, sizeof t->at);
    if (core_all_are_decided(adder, &eight, lanes)) return;
    for (int i = 0; i < lanes; i++)
        if (!core_is_decided(&eight, i)) adder->add_face(adder->context, f + (size_t)i);
}

/* One batch after the other from end to end is a chain of some 200 steps that each wait for the one
 * before, too long for the processor to see the next one's beginning. So each step is taken for
 * some batches at a time: they wait for nothing of each other. queue: NULL where they are added at
 * once. */
CORE_INLINE void take_weighted(
    const core_adder *adder, size_t begin, size_t end, core_queue *queue, norma_weight weight) {
    triangle_batch t[BATCHES_AT_ONCE];
    for (size_t f = begin; f < end; f += BATCHES_AT_ONCE * CORE_LANES) {
        const size_t left = end - f, batches = left < BATCHES_AT_ONCE * CORE_LANES
                                                   ? (left + CORE_LANES - 1) / CORE_LANES
                                                   : BATCHES_AT_ONCE;
        for (size_t i = 0; i < batches; i++) {
            const size_t first = f + i * CORE_LANES;
            if (queue || adder->scattered) look_at_triangles_ahead(adder, first);
            read_batch(adder->mesh, first, lanes_left(first, end), &t[i]);
        }
        for (size_t i = 0; i < batches; i++) measure_batch(&t[i].measured, weight);
        for (size_t i = 0; i < batches; i++) {
            const size_t first = f + i * CORE_LANES;
            if (queue)
                queue_batch(
                    adder, &t[i], first, lanes_left(first, end), first - begin, queue, weight);
            else
                add_batch(adder, &t[i], first, lanes_left(first, end), weight);
        }
    }
}

CORE_INLINE void add_weighted(
    const core_adder *adder, size_t begin, size_t end, norma_weight weight) {
    take_weighted(adder, begin, end, NULL, weight);
}

#if defined(__wasm_simd128__)
/* What pairs leave, those that doubles do not decide and a last one, goes through a batch. */
CORE_INLINE void add_by_area(const core_adder *adder, size_t begin, size_t end) {
    const int pairs = core_can_add_pairs(adder);
    for (size_t f = begin, next; f < end; f = next) {
        if (pairs) f = core_add_pairs(adder, f, end);
        next = pairs && end - f > 2 ? f + 2 : end;
        add_weighted(adder, f, next, NORMA_WEIGHT_AREA);
    }
}

/* The few at the end go through a batch. */
CORE_INLINE void add_by_angle(const core_adder *adder, size_t begin, size_t end) {
    if (core_can_measure_eight(adder->mesh)) begin = core_add_eights(adder, begin, end);
    add_weighted(adder, begin, end, NORMA_WEIGHT_ANGLE);
}
#elif defined(__wasm__)
CORE_INLINE void add_by_area(const core_adder *adder, size_t begin, size_t end) {
    add_weighted(adder, begin, end, NORMA_WEIGHT_AREA);
}
CORE_INLINE void add_by_angle(const core_adder *adder, size_t begin, size_t end) {
    add_weighted(adder, begin, end, NORMA_WEIGHT_ANGLE);
}
#endif

/* In WebAssembly, what is seldom asked for goes through one loop, for the module's size. */
CORE_INLINE void add_triangles(const core_adder *adder, size_t begin, size_t end) {
#if defined(__wasm__)
    if (adder->weight == NORMA_WEIGHT_ANGLE)
        add_by_angle(adder, begin, end);
    else if (adder->weight == NORMA_WEIGHT_AREA)
        add_by_area(adder, begin, end);
    else
        add_weighted(adder, begin, end, adder->weight);
#else
    CORE_LOOP_FOR_WEIGHT(adder->weight, add_weighted, adder, begin, end)
#endif
}

/* ---- queueing */

CORE_INLINE uint32_t part_of(uint32_t at, uint64_t scale) {
    return at == CORE_NOWHERE ? CORE_PARTS : (uint32_t)((at * scale) >> CORE_PART_BITS);
}

/* A counting sort, so that a queue is no larger for many parts than for few. */
CORE_INLINE void list_queued_corners(core_queue *queue, size_t faces, uint64_t scale) {
    uint16_t next[CORE_PARTS + 2] = {0};
    for (size_t c = 0; c < 3 * faces; c++) next[part_of(queue->at[c], scale) + 1]++;
    for (size_t part = 0; part <= CORE_PARTS; part++)
        next[part + 1] = (uint16_t)(next[part + 1] + next[part]);
    memcpy(queue->begin, next, sizeof next);
    for (size_t f = 0; f < faces; f++)
        for (size_t k = 0; k < 3; k++)
            queue->list[next[part_of(queue->at[3 * f + k], scale)]++] = (uint16_t)(4 * f + k);
}

CORE_INLINE void queue_triangles(
    const core_adder *adder, size_t begin, size_t end, uint64_t scale, core_queue *queue) {
#if defined(__wasm__) /* queues are for threads, which are not there: one small loop */
    take_weighted(adder, begin, end, queue, adder->weight);
#else
    CORE_LOOP_FOR_WEIGHT(adder->weight, take_weighted, adder, begin, end, queue)
#endif
    list_queued_corners(queue, end - begin, scale);
}

CORE_INLINE vertex_sum *sum_of_corner(const core_queue *queue, uint16_t corner, vertex_sum *sums) {
    return &sums[queue->at[corner - (corner >> 2)]];
}

CORE_INLINE void drain_queue(const core_queue *queue, size_t part, vertex_sum *sums) {
    enum { CORNERS_AHEAD = 64 };
    const uint16_t *list = queue->list + queue->begin[part];
    const size_t count = (size_t)(queue->begin[part + 1] - queue->begin[part]);
    for (size_t i = 0; i < count && i < CORNERS_AHEAD; i++)
        __builtin_prefetch(sum_of_corner(queue, list[i], sums), 1, 2);
    for (size_t i = 0; i < count; i++) {
        if (i + CORNERS_AHEAD < count)
            __builtin_prefetch(sum_of_corner(queue, list[i + CORNERS_AHEAD], sums), 1, 2);
        core_add_row(&sum_of_corner(queue, list[i], sums)->x, queue->row[list[i] >> 2],
            queue->weight[list[i] >> 2][list[i] & 3]);
    }
}

/* ---- finishing */

CORE_INLINE int finish_sums(const vertex_sum *sums, float (*normals)[3]) {
    core_lengths lengths;
    core_lane fine = {0};
    core_lanes_lengths(sums, &lengths, fine);
    core_lanes_directions(&lengths, normals);
    return core_lanes_total(fine) == CORE_LANES;
}

/* ---- for each instruction set */

static void add_portable(const core_adder *adder, size_t begin, size_t end) {
    add_triangles(adder, begin, end);
}
static void queue_portable(
    const core_adder *adder, size_t begin, size_t end, uint64_t scale, core_queue *queue) {
    queue_triangles(adder, begin, end, scale, queue);
}
static void drain_portable(const core_queue *queue, size_t part, vertex_sum *sums) {
    drain_queue(queue, part, sums);
}
static int finish_portable(const vertex_sum *sums, float (*normals)[3]) {
    return finish_sums(sums, normals);
}

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void add_avx2(const core_adder *adder, size_t begin, size_t end) {
    add_triangles(adder, norma_core_add_eights_avx2(adder, begin, end), end);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void add_avx512(const core_adder *adder, size_t begin, size_t end) {
    add_triangles(adder, norma_core_add_eights_avx512(adder, begin, end), end);
}
#endif
CORE_FOR_AVX2 static void queue_avx2(
    const core_adder *adder, size_t begin, size_t end, uint64_t scale, core_queue *queue) {
    queue_triangles(adder, begin, end, scale, queue);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void queue_avx512(
    const core_adder *adder, size_t begin, size_t end, uint64_t scale, core_queue *queue) {
    queue_triangles(adder, begin, end, scale, queue);
}
#endif
CORE_FOR_AVX2 static void drain_avx2(const core_queue *queue, size_t part, vertex_sum *sums) {
    drain_queue(queue, part, sums);
}
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void drain_avx512(const core_queue *queue, size_t part, vertex_sum *sums) {
    drain_queue(queue, part, sums);
}
#endif
CORE_FOR_AVX2 static int finish_avx2(const vertex_sum *sums, float (*normals)[3]) {
    return finish_sums(sums, normals);
}
static core_finish_sums *const FINISH[] = {
    finish_portable, finish_avx2, finish_avx2}; /* rows are of four */
#else
static core_finish_sums *const FINISH[] = {finish_portable};
#endif
static core_add_faces *const ADD[] = CORE_KERNELS(add);
static core_queue_triangles *const QUEUE[] = CORE_KERNELS(queue);
static core_drain_queue *const DRAIN[] = CORE_KERNELS(drain);

static void add_widened(core_add_faces *add, const core_adder *adder, size_t begin, size_t end) {
    uint32_t corners[3 * FACES_TO_WIDEN];
    core_mesh mesh = *adder->mesh;
    core_adder wide = *adder;
    mesh.corner_count = 3 * (end - begin);
    norma_core_read_corners(&mesh, 3 * begin, mesh.corner_count, corners);
    mesh.corners = corners;
    mesh.corner_size = sizeof *corners;
    wide.mesh = &mesh;
    wide.first_face = begin;
    add(&wide, 0, end - begin);
}

void norma_core_add_chunk(core_add_faces *add, const core_adder *adder, size_t begin, size_t end) {
    if (adder->mesh->face_starts || adder->mesh->corner_size == sizeof(uint32_t)) {
        add(adder, begin, end);
        return;
    }
    for (size_t f = begin; f < end; f += FACES_TO_WIDEN)
        add_widened(add, adder, f, end - f < FACES_TO_WIDEN ? end : f + FACES_TO_WIDEN);
}

core_add_faces *norma_core_choose_add(norma_isa isa) { return ADD[norma_core_level(isa)]; }
core_queue_triangles *norma_core_choose_queue(norma_isa isa) {
    return QUEUE[norma_core_level(isa)];
}
core_drain_queue *norma_core_choose_drain(norma_isa isa) { return DRAIN[norma_core_level(isa)]; }
core_finish_sums *norma_core_choose_finish(norma_isa isa) { return FINISH[norma_core_level(isa)]; }
