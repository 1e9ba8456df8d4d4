/* vertex_sums.c: the sums at all positions. Votes added one face at a time, and sums made normals
 * one at a time. The kernels of add_triangles.c do the same for many at once. */
#include "core/vertex/vertex.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"
#include <stdatomic.h>

void norma_core_add_vote(vertex_sum *sum, double weight, const double normal[3]) {
    sum->x += weight * normal[0];
    sum->y += weight * normal[1];
    sum->z += weight * normal[2];
    sum->weight += weight;
}

void norma_core_clear_sums(vertex_sum *sums, size_t count) {
    for (size_t i = 0; i < count; i++) sums[i] = (vertex_sum){0, 0, 0, -0.0};
}

void norma_core_add_face(void *context, size_t f) {
    const core_face_adder *adder = context;
    const core_prepared_mesh *prepared = adder->prepared;
    const core_mesh *mesh = &prepared->mesh;
    const size_t begin = norma_core_face_begin(mesh, f), end = norma_core_face_end(mesh, f);
    core_face face;
    norma_core_prepared_mesh_face(prepared, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) {
        if (begin < end && (face.flags & CORE_FACE_FINITE) &&
            norma_core_welded_corner(mesh, begin) - adder->first < adder->count)
            norma_core_count_one(adder->degenerate, f);
        return;
    }
    for (size_t c = begin; c < end; c++) {
        const uint32_t sum = norma_core_welded_corner(mesh, c) - adder->first;
        if (sum >= adder->count || !norma_core_is_kept(mesh, f, c)) continue;
        norma_core_add_vote(&adder->sums[sum],
            norma_core_corner_weight(mesh, prepared->call->options.weight, f, &face, c),
            face.normal);
    }
}

static void sum_of(const vertex_sum *s, double sum[3]) {
    sum[0] = s->x;
    sum[1] = s->y;
    sum[2] = s->z;
}

int norma_core_record_cancels(const vertex_sum *s) {
    double sum[3];
    sum_of(s, sum);
    return norma_core_has_votes(s) && norma_core_cancels(sum, s->weight);
}

int norma_core_resolve_record(
    const core_mesh *mesh, const vertex_sum *s, size_t vertex, float normal[3]) {
    double sum[3];
    if (!norma_core_has_votes(s)) {
        norma_core_position(mesh, (uint32_t)vertex, sum);
        return norma_core_finite(sum) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    }
    sum_of(s, sum);
    if (norma_core_cancels(sum, s->weight)) return NORMA_REASON_CANCELLED;
    norma_core_direction(sum, normal);
    return NORMA_REASON_NONE;
}

/* ---- sums of a mesh whose faces name positions far apart, by several at once. Each measures
 * chunks of faces of its own and leaves what they add in queues; then each takes what waits for a
 * part of the positions, from the first face to the last. So no face is measured twice, and every
 * sum is taken in ascending order of faces by whichever thread takes it. A segment of the faces is
 * queued and drained at a time, so that the queues stay in the cache; the next segment is queued
 * into others, so that no thread waits for the last to be drained. All jobs are tasks of one call:
 * of each segment those that queue a chunk, then those that drain a part. Tasks are begun in order,
 * so that one that waits for others waits for some that are at work. Jobs of the caller's need not
 * be: they get the tasks that wait for nothing, stage by stage. */

enum { MOST_CHUNKS = 64, LEAST_CHUNKS = 16, BYTES_FOR_EIGHT_FACES = 15, SETS = 2 };

typedef struct queue_work {
    const core_prepared_mesh *prepared;
    const core_mesh *mesh;
    core_queue_triangles *queue_faces;
    core_drain_queue *drain;
    vertex_sum *sums;
    core_queue *queues;                  /* of the chunks of two segments */
    norma_count degenerate[MOST_CHUNKS]; /* met by each of them, in all segments */
    size_t chunks, parts;                /* jobs of a segment */
    size_t segments, first_job;          /* first_job: of the tasks that run_queues now */
    uint64_t scale;                      /* of positions to parts */
    atomic_size_t *queued;               /* of each segment, its chunks */
    atomic_size_t drained[CORE_PARTS];   /* of each part, the segments */
} queue_work;

/* ---- queueing */

typedef struct face_queuer {
    const core_prepared_mesh *prepared;
    core_queue *queue;
    size_t begin;
    norma_count *degenerate;
} face_queuer;

/* A triangle that doubles do not decide, or whose corners are not three. */
static void queue_face(void *context, size_t f) {
    const face_queuer *q = context;
    const core_mesh *mesh = &q->prepared->mesh;
    const size_t in_chunk = f - q->begin;
    core_face face;
    norma_core_face_geometry(mesh, f, &face);
    const int directed = face.flags & CORE_FACE_DIRECTED;
    if (!directed && (face.flags & CORE_FACE_FINITE)) norma_core_count_one(q->degenerate, f);
    for (size_t k = 0; k < 3; k++) {
        q->queue->row[in_chunk][k] = face.normal[k];
        if (directed && norma_core_is_kept(mesh, f, 3 * f + k))
            q->queue->weight[in_chunk][k] = norma_core_corner_weight(
                mesh, q->prepared->call->options.weight, f, &face, 3 * f + k);
        else
            q->queue->at[3 * in_chunk + k] = CORE_NOWHERE;
    }
    q->queue->row[in_chunk][3] = 1;
}

/* Stage by stage there is nothing to wait for. */
static void wait_for(const queue_work *work, const atomic_size_t *value, size_t least) {
    if (!work->prepared->call->options.parallel_for) norma_core_wait(value, least);
}

/* The queues of a segment are those of the last but one, when that is drained. */
static void wait_until_free(const queue_work *work, size_t segment) {
    if (segment < SETS) return;
    for (size_t part = 0; part < work->parts; part++)
        wait_for(work, &work->drained[part], segment - SETS + 1);
}

static void queue_faces(queue_work *work, size_t queue, size_t begin, size_t end) {
    face_queuer queuer = {work->prepared, &work->queues[queue], begin, &work->degenerate[queue]};
    const norma_options *o = &work->prepared->call->options;
    const core_adder adder = {.mesh = work->mesh,
        .weight = o->weight,
        .sums = work->sums,
        .scattered = 1,
        .by_distance = o->weld == NORMA_WELD_DISTANCE,
        .add_face = queue_face,
        .context = &queuer};
    work->queue_faces(&adder, begin, end, work->scale, &work->queues[queue]);
}

static void queue_chunk(queue_work *work, size_t segment, size_t number) {
    const size_t begin = (segment * work->chunks + number) * CORE_FACES_IN_CHUNK,
                 faces = work->mesh->face_count;
    wait_until_free(work, segment);
    if (begin < faces)
        queue_faces(work, segment % SETS * work->chunks + number, begin,
            faces - begin < CORE_FACES_IN_CHUNK ? faces : begin + CORE_FACES_IN_CHUNK);
    atomic_fetch_add_explicit(&work->queued[segment], 1, memory_order_release);
}

/* ---- draining */

static void clear_part(void *context, size_t part) {
    const queue_work *work = context;
    const uint64_t count = work->mesh->positions.count, begin = count * part / work->parts,
                   end = count * (part + 1) / work->parts;
    norma_core_clear_sums(work->sums + begin, (size_t)(end - begin));
}

static void drain_part(queue_work *work, size_t segment, size_t part) {
    wait_for(work, &work->queued[segment], work->chunks);
    wait_for(work, &work->drained[part], segment);
    for (size_t chunk = 0;
         chunk < work->chunks &&
         (segment * work->chunks + chunk) * CORE_FACES_IN_CHUNK < work->mesh->face_count;
         chunk++)
        work->drain(&work->queues[segment % SETS * work->chunks + chunk], part, work->sums);
    atomic_store_explicit(&work->drained[part], segment + 1, memory_order_release);
}

/* ---- jobs */

static void run_queue_job(void *context, size_t task) {
    queue_work *work = context;
    const size_t job = work->first_job + task, jobs = work->chunks + work->parts,
                 segment = job / jobs, number = job % jobs;
    if (number < work->chunks)
        queue_chunk(work, segment, number);
    else
        drain_part(work, segment, number - work->chunks);
}

static norma_result run_staged(core_call *call, queue_work *work) {
    const double from = call->progress_from, to = call->progress_to;
    norma_result result = NORMA_OK;
    for (size_t segment = 0; segment < work->segments && result == NORMA_OK; segment++) {
        norma_core_stage(call, from + (to - from) * (double)segment / (double)work->segments,
            from + (to - from) * (double)(segment + 1) / (double)work->segments);
        work->first_job = segment * (work->chunks + work->parts);
        result = norma_core_parallel(call, work->chunks, run_queue_job, work);
        work->first_job += work->chunks;
        if (result == NORMA_OK)
            result = norma_core_parallel(call, work->parts, run_queue_job, work);
    }
    norma_core_stage(call, from, to);
    return result;
}

static norma_result run_queues(core_call *call, queue_work *work) {
    const double from = call->progress_from, to = call->progress_to,
                 cleared = from + 0.1 * (to - from);
    for (size_t i = 0; i < work->segments; i++) atomic_init(&work->queued[i], 0);
    for (size_t i = 0; i < work->parts; i++) atomic_init(&work->drained[i], 0);
    norma_core_stage(call, from, cleared);
    norma_result result = norma_core_parallel(call, work->parts, clear_part, work);
    norma_core_stage(call, cleared, to);
    if (result == NORMA_OK)
        result = call->options.parallel_for
                     ? run_staged(call, work)
                     : norma_core_parallel(call, work->segments * (work->chunks + work->parts),
                           run_queue_job, work);
    norma_core_stage(call, from, to);
    return result;
}

/* No more than there are at work: each part reads most of the queues. */
static size_t parts_for(const core_call *call) {
    size_t parts = 1;
    while (parts < CORE_PARTS && parts < norma_core_shares(call)) parts *= 2;
    return parts;
}

norma_result norma_core_queue_vertices(const core_prepared_mesh *prepared, const core_mesh *mesh,
    vertex_sum *sums, norma_count *degenerate, int *done) {
    core_call *call = prepared->call;
    size_t chunks = mesh->face_count / 8 * BYTES_FOR_EIGHT_FACES / sizeof(core_queue);
    *done = 0;
    if (chunks < LEAST_CHUNKS) return NORMA_OK;
    if (chunks > MOST_CHUNKS) chunks = MOST_CHUNKS;
    const size_t chunks_in_all =
        mesh->face_count / CORE_FACES_IN_CHUNK + (mesh->face_count % CORE_FACES_IN_CHUNK != 0);
    queue_work work = {.prepared = prepared,
        .mesh = mesh,
        .sums = sums,
        .queue_faces = norma_core_choose_queue(call->options.isa),
        .drain = norma_core_choose_drain(call->options.isa),
        .chunks = chunks / SETS,
        .parts = parts_for(call)};
    work.segments = chunks_in_all / work.chunks + (chunks_in_all % work.chunks != 0);
    work.scale = ((uint64_t)work.parts << CORE_PART_BITS) / mesh->positions.count;
    work.queues = norma_core_allocate(call, chunks, sizeof *work.queues);
    work.queued = norma_core_allocate(call, work.segments, sizeof *work.queued);
    const int has_memory = work.queues && work.queued;
    const norma_result result = has_memory ? run_queues(call, &work) : NORMA_OK;
    norma_core_release(call, work.queues, chunks, sizeof *work.queues);
    norma_core_release(call, work.queued, work.segments, sizeof *work.queued);
    for (size_t i = 0; i < chunks; i++) norma_core_count_add(degenerate, &work.degenerate[i]);
    *done = has_memory;
    return result;
}

/* ---- the weighted sum at each position. Faces are gone through in ascending order, and each adds
 * to the sums of its corners; when several work, each owns a range of positions and passes over the
 * chunks of faces that do not touch it. So every sum is taken in the same order by any number of
 * threads. */

enum { FACES_IN_CHUNK = CORE_FACES_IN_CHUNK, FEWEST_FACES_TO_SHARE = 1 << 15, MOST_RANGES = 64 };

typedef struct position_range {
    uint32_t begin, end;
} position_range; /* from begin to before end; of a chunk of faces: what they touch */

typedef struct sum_work {
    core_vertices *vertices;
    core_mesh mesh; /* the surface's, its positions perhaps copied */
    int scattered;
    core_add_faces *add;
    size_t ranges, chunks;
    position_range *touched; /* by each chunk; NULL for one range */
    norma_count degenerate[MOST_RANGES];
} sum_work;

/* ---- chunks and ranges */

static void chunk_faces(const sum_work *work, size_t chunk, size_t *begin, size_t *end) {
    const size_t count = work->vertices->prepared->mesh.face_count;
    *begin = chunk * FACES_IN_CHUNK;
    *end = count - *begin < FACES_IN_CHUNK ? count : *begin + FACES_IN_CHUNK;
}

static void touch_chunk(void *context, size_t chunk) {
    const sum_work *work = context;
    const core_mesh *mesh = &work->vertices->prepared->mesh;
    position_range touched = {UINT32_MAX, 0};
    size_t begin, end;
    chunk_faces(work, chunk, &begin, &end);
    for (size_t c = norma_core_face_begin(mesh, begin); c < norma_core_face_end(mesh, end - 1);
         c++) {
        const uint32_t position = norma_core_welded_corner(mesh, c);
        if (position < touched.begin) touched.begin = position;
        if (position >= touched.end) touched.end = position + 1;
    }
    work->touched[chunk] = touched;
}

static void add_chunk(sum_work *work, size_t range_number, position_range range, size_t chunk) {
    const core_prepared_mesh *prepared = work->vertices->prepared;
    vertex_sum *sums = work->vertices->sums + range.begin;
    const uint32_t count = range.end - range.begin;
    size_t begin, end;
    if (work->touched &&
        (work->touched[chunk].begin >= range.end || work->touched[chunk].end <= range.begin))
        return;
    chunk_faces(work, chunk, &begin, &end);
    core_face_adder face_adder = {
        prepared, sums, range.begin, count, &work->degenerate[range_number]};
    const core_adder adder = {.mesh = &work->mesh,
        .weight = prepared->call->options.weight,
        .sums = sums,
        .first = range.begin,
        .count = count,
        .owns_all = work->ranges == 1,
        .scattered = work->scattered,
        .by_distance = prepared->call->options.weld == NORMA_WELD_DISTANCE,
        .add_face = norma_core_add_face,
        .context = &face_adder};
    norma_core_add_chunk(work->add, &adder, begin, end);
}

static position_range range_of(const sum_work *work, size_t number) {
    const uint64_t count = work->vertices->count;
    return (position_range){
        (uint32_t)(count * number / work->ranges), (uint32_t)(count * (number + 1) / work->ranges)};
}

static void sum_range(void *context, size_t number) {
    sum_work *work = context;
    const position_range range = range_of(work, number);
    norma_core_clear_sums(work->vertices->sums + range.begin, range.end - range.begin);
    for (size_t chunk = 0; chunk < work->chunks; chunk++) add_chunk(work, number, range, chunk);
}

/* Alone, chunks are what progress is told by. */
static norma_result sum_alone(sum_work *work) {
    enum { CHUNKS_BETWEEN_TELLING = 64 };
    const position_range range = range_of(work, 0);
    for (size_t v = 0; v < range.end; v++) work->vertices->sums[v] = (vertex_sum){0, 0, 0, -0.0};
    for (size_t chunk = 0; chunk < work->chunks; chunk++) {
        if (chunk % CHUNKS_BETWEEN_TELLING == 0 &&
            norma_core_progress(
                work->vertices->prepared->call, (double)chunk / (double)work->chunks))
            return NORMA_CANCELLED;
        add_chunk(work, 0, range, chunk);
    }
    return NORMA_OK;
}

static norma_result sum_shared(sum_work *work) {
    core_call *call = work->vertices->prepared->call;
    work->touched = norma_core_allocate(call, work->chunks, sizeof *work->touched);
    if (!work->touched) return NORMA_ERROR_MEMORY;
    norma_result result = norma_core_parallel(call, work->chunks, touch_chunk, work);
    if (result == NORMA_OK) result = norma_core_parallel(call, work->ranges, sum_range, work);
    norma_core_release(call, work->touched, work->chunks, sizeof *work->touched);
    return result;
}

static size_t ranges_for(const core_prepared_mesh *prepared) {
    const core_call *call = prepared->call;
    if (!call->options.parallel_for && prepared->mesh.face_count < FEWEST_FACES_TO_SHARE) return 1;
    const size_t shares = norma_core_shares(call);
    return shares < MOST_RANGES ? shares : MOST_RANGES;
}

/* ---- sums that cancel: once more, over the corners of each vertex alone */

static void add_own(core_vertices *vertices, size_t f) {
    const core_prepared_mesh *prepared = vertices->prepared;
    const core_mesh *mesh = &prepared->mesh;
    core_face face;
    norma_core_prepared_mesh_face(prepared, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) return;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++) {
        const uint32_t number = vertices->own[norma_core_corner(mesh, c)];
        if (number == UINT32_MAX || !norma_core_is_kept(mesh, f, c)) continue;
        norma_core_add_vote(&vertices->own_sums[number],
            norma_core_corner_weight(mesh, prepared->call->options.weight, f, &face, c),
            face.normal);
    }
}

static void add_own_triangles(core_vertices *vertices, const size_t *faces, size_t count) {
    const core_prepared_mesh *prepared = vertices->prepared;
    core_batch b;
    if (!count) return;
    const unsigned decided = norma_core_measure_triangles(
        prepared->call, &prepared->mesh, prepared->call->options.weight, faces, count, &b);
    for (size_t i = 0; i < count; i++) {
        const double normal[3] = {b.normal[0][i], b.normal[1][i], b.normal[2][i]};
        if (!(decided >> i & 1U)) add_own(vertices, faces[i]);
        for (size_t k = 0; k < 3 && (decided >> i & 1U); k++) {
            const uint32_t number =
                vertices->own[norma_core_corner(&prepared->mesh, 3 * faces[i] + k)];
            if (number != UINT32_MAX)
                norma_core_add_vote(&vertices->own_sums[number], b.weight[k][i], normal);
        }
    }
}

static int touches_own(const core_vertices *vertices, size_t f) {
    const core_mesh *mesh = &vertices->prepared->mesh;
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++)
        if (vertices->own[norma_core_corner(mesh, c)] != UINT32_MAX) return 1;
    return 0;
}

/* Triangles eight at a time, with the bits that they have in all other sums. */
static void add_all_own(core_vertices *vertices) {
    const core_mesh *mesh = &vertices->prepared->mesh;
    size_t faces[CORE_LANES], count = 0;
    for (size_t f = 0; f < mesh->face_count; f++) {
        if (!touches_own(vertices, f)) continue;
        if (mesh->face_starts)
            add_own(vertices, f);
        else
            faces[count++] = f;
        if (count < CORE_LANES) continue;
        add_own_triangles(vertices, faces, count);
        count = 0;
    }
    add_own_triangles(vertices, faces, count);
}

static norma_result sum_own(core_vertices *vertices) {
    const core_call *call = vertices->prepared->call;
    const core_mesh *mesh = &vertices->prepared->mesh;
    size_t cancelled = 0;
    if (!mesh->weld) return NORMA_OK; /* a position has the corners of one vertex */
    for (size_t v = 0; v < vertices->count; v++)
        cancelled += (size_t)norma_core_record_cancels(
            &vertices->sums[norma_core_welded(mesh, (uint32_t)v)]);
    if (!cancelled) return NORMA_OK;
    vertices->own = norma_core_allocate(call, vertices->count, sizeof *vertices->own);
    vertices->own_sums = norma_core_allocate(call, cancelled, sizeof *vertices->own_sums);
    vertices->own_count = cancelled;
    if (!vertices->own || !vertices->own_sums) return NORMA_ERROR_MEMORY;
    uint32_t number = 0;
    for (size_t v = 0; v < vertices->count; v++)
        vertices->own[v] =
            norma_core_record_cancels(&vertices->sums[mesh->weld[v]]) ? number++ : UINT32_MAX;
    norma_core_clear_sums(vertices->own_sums, cancelled);
    add_all_own(vertices);
    return NORMA_OK;
}

int norma_core_resolve_sum(const core_vertices *vertices, size_t vertex, float normal[3]) {
    const core_mesh *mesh = &vertices->prepared->mesh;
    if (vertices->own && vertices->own[vertex] != UINT32_MAX) {
        const vertex_sum *own = &vertices->own_sums[vertices->own[vertex]];
        return norma_core_has_votes(own) ? norma_core_resolve_record(mesh, own, vertex, normal)
                                         : NORMA_REASON_CANCELLED;
    }
    return norma_core_resolve_record(
        mesh, &vertices->sums[norma_core_welded(mesh, (uint32_t)vertex)], vertex, normal);
}

/* Faces are measured from positions in memory of our own where they are scattered. */
static norma_result copy_positions(sum_work *work) {
    core_prepared_mesh *prepared = work->vertices->prepared;
    core_call *call = prepared->call;
    const double from = call->progress_from, to = call->progress_to,
                 copied = from + 0.1 * (to - from);
    work->mesh = prepared->mesh;
    if (!work->scattered) return NORMA_OK;
    norma_core_stage(call, from, copied);
    const norma_result result = norma_core_copy_scattered(call, &prepared->mesh, &work->mesh);
    norma_core_stage(call, copied, to);
    return result;
}

static norma_result sum_all(sum_work *work) {
    core_prepared_mesh *prepared = work->vertices->prepared;
    norma_result result = copy_positions(work);
    int done = 0;
    if (result == NORMA_OK && work->scattered && !prepared->mesh.face_starts && work->ranges > 1)
        result = norma_core_queue_vertices(
            prepared, &work->mesh, work->vertices->sums, &work->degenerate[0], &done);
    if (result == NORMA_OK && !done) result = work->ranges > 1 ? sum_shared(work) : sum_alone(work);
    norma_core_release_scattered(prepared->call, &prepared->mesh, &work->mesh);
    return result;
}

norma_result norma_core_sum_vertices(
    core_prepared_mesh *prepared, int scattered, core_vertices *vertices, core_tally *tally) {
    const size_t count = prepared->mesh.positions.count, faces = prepared->mesh.face_count;
    *vertices = (core_vertices){.prepared = prepared, .count = count};
    vertices->sums = norma_core_allocate(prepared->call, count, sizeof *vertices->sums);
    if (!vertices->sums) return NORMA_ERROR_MEMORY;
    sum_work work = {.vertices = vertices,
        .scattered = scattered,
        .add = prepared->mesh.face_starts
                   ? norma_core_choose_add_polygons(prepared->call->options.isa)
                   : norma_core_choose_add(prepared->call->options.isa),
        .ranges = ranges_for(prepared),
        .chunks = faces / FACES_IN_CHUNK + (faces % FACES_IN_CHUNK != 0)};
    norma_result result = sum_all(&work);
    if (result == NORMA_OK) result = sum_own(vertices);
    norma_core_count_add(&tally->degenerate, &prepared->degenerate_faces);
    for (size_t i = 0; i < work.ranges; i++)
        norma_core_count_add(&tally->degenerate, &work.degenerate[i]);
    if (result != NORMA_OK) norma_core_release_vertices(vertices);
    return result;
}
