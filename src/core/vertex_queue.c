/* vertex_queue.c: sums of a mesh whose faces name positions far apart, by several at once. Each measures chunks of faces of its own and leaves what they add in queues; then each takes
 * what waits for a part of the positions, from the first face to the last. So no face is measured twice, and every sum is taken in ascending order of faces, whoever takes it. A segment of
 * the faces is queued and drained at a time, so that the queues stay in the cache. */
#include "vertex_queue.h"

enum { MOST_CHUNKS = 64, LEAST_CHUNKS = 16, BYTES_FOR_EIGHT_FACES = 15 };

typedef struct queue_work {
    const core_surface   *surface;
    const core_mesh      *mesh;
    core_queue_triangles *queue_faces;
    core_drain_queue     *drain;
    vertex_sum           *sums;
    core_queue           *queues;                      /* of the chunks of a segment */
    norma_count           degenerate[MOST_CHUNKS];     /* met by each of them, in all segments */
    size_t                first, chunks;               /* the segment: its first face, its chunks */
    size_t                parts;
    uint64_t              scale;                       /* of positions to parts */
} queue_work;

/* ---- queueing */

typedef struct face_queuer {
    const core_surface *surface;
    core_queue         *queue;
    size_t              begin;
    norma_count        *degenerate;
} face_queuer;

/* A triangle that doubles do not decide, or whose corners are not three. */
static void queue_face(void *context, size_t f)
{
    const face_queuer *q = context;
    const core_mesh *mesh = &q->surface->mesh;
    const size_t in_chunk = f - q->begin;
    core_face face;
    norma_core_face_geometry(mesh, f, &face);
    const int directed = face.flags & CORE_FACE_DIRECTED;
    if (!directed && (face.flags & CORE_FACE_FINITE)) norma_core_count_one(q->degenerate, f);
    for (size_t k = 0; k < 3; k++) {
        q->queue->row[in_chunk][k] = face.normal[k];
        if (directed && norma_core_is_kept(mesh, f, 3 * f + k)) q->queue->weight[in_chunk][k] = norma_core_corner_weight(mesh, q->surface->call->options.weight, f, &face, 3 * f + k);
        else q->queue->at[3 * in_chunk + k] = CORE_NOWHERE;
    }
    q->queue->row[in_chunk][3] = 1;
}

static void queue_chunk(void *context, size_t chunk)
{
    queue_work *work = context;
    const size_t begin = work->first + chunk * CORE_FACES_IN_CHUNK, faces = work->mesh->face_count, end = faces - begin < CORE_FACES_IN_CHUNK ? faces : begin + CORE_FACES_IN_CHUNK;
    face_queuer queuer = {work->surface, &work->queues[chunk], begin, &work->degenerate[chunk]};
    const norma_options *o = &work->surface->call->options;
    const core_adder adder = {work->mesh, o->weight, work->sums, 0, 0, 0, 1, o->weld == NORMA_WELD_DISTANCE, queue_face, &queuer};
    work->queue_faces(&adder, begin, end, work->scale, &work->queues[chunk]);
}

/* ---- draining */

static void clear_part(void *context, size_t part)
{
    const queue_work *work = context;
    const uint64_t count = work->mesh->positions.count, begin = count * part / work->parts, end = count * (part + 1) / work->parts;
    norma_core_clear_sums(work->sums + begin, (size_t)(end - begin));
}

static void drain_part(void *context, size_t part)
{
    const queue_work *work = context;
    for (size_t chunk = 0; chunk < work->chunks; chunk++) work->drain(&work->queues[chunk], part, work->sums);
}

static norma_result run(core_call *call, queue_work *work, size_t chunks_at_once)
{
    const size_t faces = work->mesh->face_count, chunks = faces / CORE_FACES_IN_CHUNK + (faces % CORE_FACES_IN_CHUNK != 0);
    const double from = call->progress_from, to = call->progress_to;
    norma_result result = norma_core_parallel(call, work->parts, clear_part, work);
    for (size_t chunk = 0; chunk < chunks && result == NORMA_OK; chunk += work->chunks) {
        work->first = chunk * CORE_FACES_IN_CHUNK;
        work->chunks = chunks - chunk < chunks_at_once ? chunks - chunk : chunks_at_once;
        norma_core_stage(call, from + (to - from) * (double)chunk / (double)chunks, from + (to - from) * (double)(chunk + work->chunks) / (double)chunks);
        result = norma_core_parallel(call, work->chunks, queue_chunk, work);
        if (result == NORMA_OK) result = norma_core_parallel(call, work->parts, drain_part, work);
    }
    norma_core_stage(call, from, to);
    return result;
}

/* No more than there are at work: each part reads most of the queues. */
static size_t parts_for(const core_call *call)
{
    size_t parts = 1;
    while (parts < CORE_PARTS && (call->options.parallel_for || parts < norma_core_workers(call))) parts *= 2;
    return parts;
}


norma_result norma_core_queue_vertices(const core_surface *surface, const core_mesh *mesh, vertex_sum *sums, norma_count *degenerate, int *done)
{
    core_call *call = surface->call;
    size_t chunks = mesh->face_count / 8 * BYTES_FOR_EIGHT_FACES / sizeof(core_queue);
    *done = 0;
    if (chunks < LEAST_CHUNKS) return NORMA_OK;
    if (chunks > MOST_CHUNKS) chunks = MOST_CHUNKS;
    queue_work work = {.surface = surface, .mesh = mesh, .sums = sums, .queue_faces = norma_core_choose_queue(call->options.isa), .drain = norma_core_choose_drain(call->options.isa),
                       .parts = parts_for(call)};
    work.scale = ((uint64_t)work.parts << CORE_PART_BITS) / mesh->positions.count;
    work.queues = norma_core_allocate(call, chunks, sizeof *work.queues);
    if (!work.queues) return NORMA_OK;
    const norma_result result = run(call, &work, chunks);
    norma_core_release(call, work.queues, chunks, sizeof *work.queues);
    for (size_t i = 0; i < chunks; i++) norma_core_count_add(degenerate, &work.degenerate[i]);
    *done = 1;
    return result;
}
