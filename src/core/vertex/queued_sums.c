/* queued_sums.c: sums of a mesh whose faces name positions far apart, by several at once. Each
 * measures chunks of faces of its own and leaves what they add in queues; then each takes what
 * waits for a part of the positions, from the first face to the last. So no face is measured twice,
 * and every sum is taken in ascending order of faces by whichever thread takes it. A segment of the
 * faces is queued and drained at a time, so that the queues stay in the cache; the next segment is
 * queued into others, so that no thread waits for the last to be drained.
 *
 * All jobs are tasks of one call: of each segment those that queue a chunk, then those that drain a
 * part. Tasks are begun in order, so that one that waits for others waits for some that are at
 * work. Jobs of the caller's need not be: they get the tasks that wait for nothing, stage by stage.
 */
#include "core/vertex/queued_sums.h"
#include <stdatomic.h>

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
    size_t segments, first_job;          /* first_job: of the tasks that run now */
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

static void run_job(void *context, size_t task) {
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
        result = norma_core_parallel(call, work->chunks, run_job, work);
        work->first_job += work->chunks;
        if (result == NORMA_OK) result = norma_core_parallel(call, work->parts, run_job, work);
    }
    norma_core_stage(call, from, to);
    return result;
}

static norma_result run(core_call *call, queue_work *work) {
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
                     : norma_core_parallel(
                           call, work->segments * (work->chunks + work->parts), run_job, work);
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
    const norma_result result = has_memory ? run(call, &work) : NORMA_OK;
    norma_core_release(call, work.queues, chunks, sizeof *work.queues);
    norma_core_release(call, work.queued, work.segments, sizeof *work.queued);
    for (size_t i = 0; i < chunks; i++) norma_core_count_add(degenerate, &work.degenerate[i]);
    *done = has_memory;
    return result;
}
