/* smooth_fans.c: sums and chains (face.h) of a range of positions at a time; then the normals
 * of those that are smooth fans go to all their corners, in the order of faces, or to where the
 * vertices that begin there are written. */
#include "core/smooth/smooth_fans.h"
#include "core/mesh/mesh.h"
#include "core/vertex/vertex.h"
#include <stdatomic.h>

enum {
    CORNERS_AT_ONCE = 96,
    MOST_BYTES_FOR_FACE = 25, /* for sums and chains of one bin */
    BYTES_FOR_FACE = 11,      /* of several at once */
    FEW_POSITIONS = 1 << 11
};

typedef struct smooth_work {
    const core_prepared_mesh *prepared;
    core_bins bins;
    const smooth_target *target;
    const core_kernels *kernels;
    core_vertex_sum *sums; /* buffers of bins.size each, as the chains */
    face_chains *chains;
    uint8_t *others;
    atomic_uchar *chunks; /* of each: whether it has a corner at others */
    norma_edges *edges;   /* of each bin; NULL: nobody asks */
    float cosine;
} smooth_work;

typedef struct smooth_bin {
    smooth_work *work;
    const core_bin *bin;
    core_vertex_sum *sums;
    face_chains *chains;
    norma_edges *edges; /* NULL: nobody asks */
    size_t chunk;       /* that is gone through */
} smooth_bin;

/* Some corners in a row, from first on, and their positions: those of whole faces, or a part of
 * one of more corners than a group has, and then faces is 0. */
typedef struct corner_group {
    const uint32_t *at;
    size_t first, count, face, faces;
} corner_group;
typedef void see_group(smooth_bin *b, const corner_group *g);

/* The group that begins with this face, and with this corner of it. The tail of a face that has
 * been begun is a part of it, however short. */
static corner_group group_at(const core_mesh *mesh, size_t face, size_t end, size_t corner) {
    corner_group g = {.first = corner, .face = face};
    if (!mesh->face_starts) {
        g.faces = end - face < CORNERS_AT_ONCE / 3 ? end - face : CORNERS_AT_ONCE / 3;
        g.count = 3 * g.faces;
        return g;
    }
    while (corner == mesh->face_starts[face] && face + g.faces < end &&
           mesh->face_starts[face + g.faces + 1] - corner <= CORNERS_AT_ONCE)
        g.faces++;
    g.count = mesh->face_starts[face + (g.faces ? g.faces : 1)] - corner;
    if (g.count > CORNERS_AT_ONCE) g.count = CORNERS_AT_ONCE;
    return g;
}

static void each_group_of_chunk(smooth_bin *b, see_group *see) {
    const core_mesh *mesh = &b->work->prepared->mesh;
    const size_t end = norma_core_chunk_end(&b->work->bins, b->chunk);
    uint32_t at[CORNERS_AT_ONCE];
    size_t face = b->chunk * CORE_FACES_IN_CHUNK, corner = norma_core_face_begin(mesh, face);
    while (face < end) {
        corner_group g = group_at(mesh, face, end, corner);
        norma_core_read_corners(mesh, g.first, g.count, at);
        g.at = at;
        see(b, &g);
        corner += g.count;
        face += g.faces ? g.faces : corner == norma_core_face_end(mesh, face);
    }
}

static void each_group(smooth_bin *b, see_group *see) {
    const core_bins *bins = &b->work->bins;
    for (b->chunk = norma_core_chunk_of_bin(bins, b->bin, 0); b->chunk < bins->chunks;
         b->chunk = norma_core_chunk_of_bin(bins, b->bin, b->chunk + 1))
        each_group_of_chunk(b, see);
}

static size_t corners_of_face(const core_mesh *mesh, size_t face) {
    return norma_core_face_end(mesh, face) - norma_core_face_begin(mesh, face);
}

/* NULL: in another bin. */
static inline face_chains *chains_at(const smooth_bin *b, uint32_t position) {
    const uint32_t i = position - b->bin->first;
    return i < b->bin->count ? &b->chains[i] : NULL;
}

/* ---- which positions are smooth: their normals in place of the axes */

typedef struct fan_queue {
    core_vertex_sum sums[CORE_LANES];
    face_chains *chains[CORE_LANES];
    size_t count;
} fan_queue;

/* What has no direction after all is left to stars. */
static void finish_queue(const smooth_bin *b, fan_queue *queue) {
    float normals[CORE_LANES][3];
    for (size_t i = queue->count; i < CORE_LANES; i++) queue->sums[i] = queue->sums[0];
    const int fine = queue->count && b->work->kernels->finish(queue->sums, normals);
    for (size_t i = 0; i < queue->count; i++)
        if (fine)
            memcpy(queue->chains[i]->axis, normals[i], sizeof normals[i]);
        else
            core_break_chains(queue->chains[i]);
    queue->count = 0;
}

/* Normals far from the first one are left to stars, though all may be near the sum. */
static void take_fan_normals(smooth_bin *b) {
    const int polygons = b->work->prepared->mesh.face_starts != NULL;
    fan_queue queue = {.count = 0};
    for (size_t i = 0; i < b->bin->count; i++) {
        face_chains *c = &b->chains[i];
        if (!core_has_faces(c)) continue;
        if (c->wide || !norma_core_is_one_turn(c, b->sums[i].weight, polygons)) {
            core_break_chains(c);
            continue;
        }
        queue.sums[queue.count] = b->sums[i];
        queue.chains[queue.count++] = c;
        if (queue.count == CORE_LANES) finish_queue(b, &queue);
    }
    finish_queue(b, &queue);
}

static void mark_others(const smooth_bin *b) {
    for (size_t i = 0; i < b->bin->count; i++)
        b->work->others[b->bin->first + i] = (uint8_t)core_is_broken(&b->chains[i]);
}

/* ---- edges to positions of higher number: of each corner that to its next, and of an open fan the
 * last one */

static void count_edges_of_group(smooth_bin *b, const corner_group *g) {
    const uint32_t *at = g->at;
    for (size_t f = g->face; f < g->face + g->faces; f++) {
        const size_t corners = corners_of_face(&b->work->prepared->mesh, f);
        for (size_t k = 0; k < corners; k++) {
            const face_chains *c = chains_at(b, at[k]);
            if (c && !core_is_broken(c)) b->edges->count += at[k] < at[k + 1 < corners ? k + 1 : 0];
        }
        at += corners;
    }
}

static void count_ends(const smooth_bin *b) {
    for (uint32_t i = 0; i < b->bin->count; i++) {
        const face_chains *c = &b->chains[i];
        if (!core_has_faces(c) || core_is_broken(c) || c->first[0] == c->last[0]) continue;
        const size_t last = b->bin->first + i < c->last[0];
        b->edges->count += last;
        b->edges->open += last + (size_t)(b->bin->first + i < c->first[0]);
    }
}

/* ---- writing */

static void mark_chunk(const smooth_bin *b) {
    atomic_store_explicit(&b->work->chunks[b->chunk], 1, memory_order_relaxed);
}

static void write_singly(const smooth_bin *b, const corner_group *g) {
    for (size_t i = 0; i < g->count; i++) {
        const face_chains *c = chains_at(b, g->at[i]);
        if (c && core_is_broken(c))
            mark_chunk(b);
        else if (c)
            norma_core_write_normals(
                b->work->target->output, g->first + i, 1, (const float(*)[3])(const void *)c->axis);
    }
}

static void write_group(smooth_bin *b, const corner_group *g) {
    float normals[CORNERS_AT_ONCE + 1][3]; /* copied with what follows the axis */
    int whole = 1;
    for (size_t i = 0; i < g->count; i++) {
        const face_chains *c = chains_at(b, g->at[i]);
        if (!c) {
            whole = 0;
            break;
        }
        memcpy(normals[i], c->axis, 4 * sizeof(float));
        whole &= !core_is_broken(c);
    }
    if (whole)
        norma_core_write_normals(
            b->work->target->output, g->first, g->count, (const float(*)[3])normals);
    else
        write_singly(b, g);
}

/* ---- telling vertices apart: each has one normal, that of its position */

/* Without a branch, which nothing could foretell. */
static void mark_firsts(smooth_bin *b, const corner_group *g) {
    const smooth_target *target = b->work->target;
    for (size_t i = 0; i < g->count; i++) {
        const face_chains *c = chains_at(b, g->at[i]);
        if (!c) continue;
        if (core_is_broken(c)) {
            mark_chunk(b);
            continue;
        }
        target->firsts[g->first + i] = !target->single[g->at[i]];
        target->single[g->at[i]] = 1;
    }
}

static void keep_normals(const smooth_bin *b) {
    const smooth_target *target = b->work->target;
    for (size_t i = 0; i < b->bin->count; i++) {
        const face_chains *c = &b->chains[i];
        if (!core_has_faces(c) || core_is_broken(c)) continue;
        target->single[b->bin->first + i] = 1;
        if (target->normals) memcpy(target->normals[b->bin->first + i], c->axis, sizeof c->axis);
    }
}

/* ---- a bin */

static void ignore_face(void *context, size_t face) {
    (void)context;
    (void)face;
}

static void add_faces(const smooth_bin *b) {
    const smooth_work *work = b->work;
    core_adder adder = {.mesh = &work->prepared->mesh,
        .weight = NORMA_WEIGHT_ANGLE,
        .sums = b->sums,
        .add_face = ignore_face,
        .chains = b->chains,
        .chain_cosine = work->cosine};
    norma_core_clear_sums(b->sums, b->bin->count);
    for (size_t i = 0; i < b->bin->count; i++) core_clear_chains(&b->chains[i]);
    norma_core_add_to_bin(
        work->kernels, &work->bins, b->bin, (core_chunks){0, work->bins.chunks}, &adder);
}

static void find_fans_of_bin(void *context, const core_bin *bin) {
    smooth_work *work = context;
    const size_t buffer = bin->buffer * work->bins.size;
    smooth_bin b = {.work = work,
        .bin = bin,
        .sums = work->sums + buffer,
        .chains = work->chains + buffer,
        .edges = work->edges ? &work->edges[bin->number] : NULL};
    add_faces(&b);
    take_fan_normals(&b);
    mark_others(&b);
    if (work->target->output) {
        each_group(&b, write_group);
    } else {
        each_group(&b, mark_firsts);
        keep_normals(&b);
    }
    if (!b.edges) return;
    each_group(&b, count_edges_of_group);
    count_ends(&b);
    b.edges->smooth = b.edges->count - b.edges->open;
}

/* ---- is it worth it */

static const double LEAST_CREASE_RAD = 0.2; /* below it, few positions could be told smooth */

/* Whether sums and chains can find smooth positions: what face.h reckons with. */
static int may_be_smooth(const core_call *call, const core_mesh *mesh, double crease_angle_rad) {
    return !mesh->hard_edges && !mesh->smoothing_groups &&
           call->options.weight == NORMA_WEIGHT_ANGLE &&
           call->options.weld != NORMA_WELD_DISTANCE && crease_angle_rad > LEAST_CREASE_RAD;
}

/* Along the normal of a face's first three corners. */
static int cross_of_face(const core_mesh *mesh, size_t face, double cross[3]) {
    uint32_t at[3];
    double p[3][3];
    if (corners_of_face(mesh, face) < 3) return 0;
    norma_core_read_corners(mesh, norma_core_face_begin(mesh, face), 3, at);
    for (int k = 0; k < 3; k++) norma_core_position(mesh, at[k], p[k]);
    norma_core_subtract(p[1], p[0], p[1]);
    norma_core_subtract(p[2], p[0], p[2]);
    norma_core_cross(p[1], p[2], cross);
    return 1;
}

static int are_near(const core_mesh *mesh, size_t face, double cosine) {
    double a[3], b[3];
    if (!cross_of_face(mesh, face, a) || !cross_of_face(mesh, face + 1, b)) return 0;
    const double along = norma_core_dot(a, b);
    return along >= 0 &&
           along * along >= cosine * cosine * norma_core_dot(a, a) * norma_core_dot(b, b);
}

/* Of faces in a row, most of which share an edge in meshes of any order, whether all turn by
 * little: where some positions are left to stars, sums and stars together take longer than stars
 * alone. So a torus in rows takes 35 % less; of scans, the smoothest, a terrain, would take 13 %
 * less. */
static int looks_smooth(const core_mesh *mesh, double cosine) {
    enum { LOOKS = 64 };
    if (mesh->face_count < 2) return 0;
    for (size_t i = 0; i < LOOKS; i++)
        if (!are_near(mesh, (mesh->face_count - 2) * i / (LOOKS - 1), cosine)) return 0;
    return !norma_core_is_scattered(mesh);
}

/* ---- all bins */

static norma_result take_memory(const core_call *call, smooth_work *work, int counting) {
    const size_t records = work->bins.buffers * work->bins.size, chunks = work->bins.chunks;
    work->sums = norma_core_allocate(call, records, sizeof *work->sums);
    work->chains = norma_core_allocate(call, records, sizeof *work->chains);
    work->others =
        norma_core_allocate(call, work->prepared->mesh.positions.count, sizeof *work->others);
    work->chunks = norma_core_allocate(call, chunks, sizeof *work->chunks);
    if (counting) work->edges = norma_core_allocate(call, work->bins.count, sizeof *work->edges);
    if (!work->sums || !work->chains || !work->others || !work->chunks ||
        (counting && !work->edges))
        return NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < chunks; i++) atomic_init(&work->chunks[i], 0);
    if (counting) memset(work->edges, 0, work->bins.count * sizeof *work->edges);
    return NORMA_OK;
}

static void give_memory_back(const core_call *call, smooth_work *work) {
    const size_t records = work->bins.buffers * work->bins.size;
    norma_core_release(call, work->sums, records, sizeof *work->sums);
    norma_core_release(call, work->chains, records, sizeof *work->chains);
    norma_core_release(call, work->edges, work->bins.count, sizeof *work->edges);
}

static core_bin_limits limits_for(const core_mesh *mesh) {
    const size_t faces = mesh->face_count / (sizeof(core_vertex_sum) + sizeof(face_chains));
    return (core_bin_limits){
        FEW_POSITIONS + MOST_BYTES_FOR_FACE * faces, FEW_POSITIONS + BYTES_FOR_FACE * faces};
}

static void add_up(const smooth_work *work, smooth_fans *fans) {
    for (size_t i = 0; i < work->bins.count && work->edges; i++)
        norma_core_edges_add(&fans->edges, &work->edges[i]);
    for (size_t i = 0; i < work->prepared->mesh.positions.count; i++)
        fans->other_count += work->others[i];
}

static norma_result compute_bins(
    core_call *call, smooth_work *work, int counting, smooth_fans *fans) {
    norma_result result = take_memory(call, work, counting);
    if (result == NORMA_OK) result = norma_core_each_bin(call, &work->bins, find_fans_of_bin, work);
    fans->others = work->others;
    fans->chunks = (uint8_t *)work->chunks;
    if (result == NORMA_OK) add_up(work, fans);
    give_memory_back(call, work);
    return result;
}

static norma_result find_fans(
    core_prepared_mesh *prepared, const smooth_target *target, int counting, smooth_fans *fans) {
    core_call *call = prepared->call;
    smooth_work work = {.prepared = prepared,
        .target = target,
        .kernels = norma_core_kernels(call->level),
        .cosine = norma_core_chain_cosine(prepared->crease.angle)};
    if (prepared->mesh.weld || !looks_smooth(&prepared->mesh, (double)work.cosine)) return NORMA_OK;
    work.bins = (core_bins){.mesh = &prepared->mesh,
        .ranges = fans->ranges,
        .chunks = norma_core_count_chunks(&prepared->mesh)};
    if (!norma_core_plan_bins(
            call, &prepared->mesh, fans->ranges, limits_for(&prepared->mesh), &work.bins))
        return NORMA_OK;
    return compute_bins(call, &work, counting, fans);
}

/* ---- from opening to releasing */

norma_result norma_core_open_smooth_fans(core_call *call, core_mesh *checked,
    double crease_angle_rad, core_prepared_mesh *prepared, smooth_fans *fans) {
    const size_t chunks = norma_core_count_chunks(checked);
    *fans = (smooth_fans){.ranges = norma_core_allocate(call, chunks, sizeof *fans->ranges)};
    if (!fans->ranges) return NORMA_ERROR_MEMORY;
    norma_core_stage(call, 0, 0.05);
    norma_result result = norma_core_mesh_ranges(call, checked, fans->ranges);
    const int by_sums = may_be_smooth(call, checked, crease_angle_rad);
    if (result == NORMA_OK)
        result = norma_core_prepared_mesh_open(
            call, checked, by_sums ? CORE_FOR_SUMS : CORE_FOR_FANS, crease_angle_rad, prepared);
    if (result == NORMA_OK && by_sums) return NORMA_OK;
    norma_core_release(call, fans->ranges, chunks, sizeof *fans->ranges);
    fans->ranges = NULL;
    return result;
}

norma_result norma_core_find_smooth_fans(
    core_prepared_mesh *prepared, const smooth_target *target, int counting, smooth_fans *fans) {
    core_call *call = prepared->call;
    if (!fans->ranges) return NORMA_OK;
    norma_core_stage(call, 0.2, 0.45);
    const norma_result result = find_fans(prepared, target, counting, fans);
    const core_some_positions others = {fans->others, fans->chunks};
    norma_core_stage(call, 0.45, 0.5);
    if (result != NORMA_OK || !norma_core_has_others(fans)) return result;
    return norma_core_prepare_stars(prepared, fans->others ? &others : NULL);
}

norma_result norma_core_prepare_all_stars(core_prepared_mesh *prepared, const smooth_fans *fans) {
    return fans->others ? norma_core_prepare_stars(prepared, NULL) : NORMA_OK;
}

void norma_core_release_smooth_fans(const core_prepared_mesh *prepared, smooth_fans *fans) {
    const core_call *call = prepared->call;
    const core_mesh *mesh = &prepared->mesh;
    const size_t chunks = norma_core_count_chunks(mesh);
    norma_core_release(call, fans->others, mesh->positions.count, sizeof *fans->others);
    norma_core_release(call, fans->chunks, chunks, sizeof *fans->chunks);
    norma_core_release(call, fans->ranges, chunks, sizeof *fans->ranges);
    *fans = (smooth_fans){.ranges = NULL};
}
