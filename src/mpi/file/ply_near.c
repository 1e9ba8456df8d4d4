/* ply_near.c: a face goes once to each rank that has one of its positions, as the numbers of its
 * vertices. Ranks read ascending ranges of faces, so faces ascend that are lined up by ranks. */
#include "mpi/file/ply_near.h"
#include "core/call/sort.h"

typedef struct near_work {
    mpi_job *job;
    const ply_layout *layout;
    const ply_part *part;
    uint32_t *classes; /* of all vertices that part names */
    uint64_t *last;    /* of each rank: the face that went there last, + 1 */
    uint8_t *stays;    /* of each face of part: whether it is near this rank's positions */
    ply_near *near;
} near_work;

/* ---- where a face goes */

typedef void near_see(near_work *work, size_t face, int rank, void *context);

static void for_each_rank(near_work *work, near_see *see, void *context) {
    const ply_part *part = work->part;
    memset(work->last, 0, (size_t)work->job->call.ranks * sizeof *work->last);
    for (size_t f = 0; f < part->faces; f++) {
        for (size_t c = norma_mpi_corner_begin(part, f); c < norma_mpi_corner_begin(part, f + 1);
             c++) {
            const uint32_t class = work->classes[norma_mpi_place_of(part, part->corner[c])];
            const int rank = norma_mpi_owner_of(work->job, work->layout->vertices, class);
            if (work->last[rank] == f + 1) continue;
            work->last[rank] = f + 1;
            see(work, f, rank, context);
        }
    }
}

/* Where its corners begin here, of polygons how many it has, and their vertices. */
static size_t words_of(const ply_part *part, size_t face) {
    return (part->face_starts ? 2 : 1) +
           (norma_mpi_corner_begin(part, face + 1) - norma_mpi_corner_begin(part, face));
}

static void count_words(near_work *work, size_t face, int rank, void *context) {
    if (rank == work->job->call.rank)
        work->stays[face] = 1;
    else
        ((uint64_t *)context)[rank] += words_of(work->part, face);
}

static void add_word(mpi_lists *out, int rank, uint32_t word) {
    memcpy(norma_mpi_lists_add(out, rank), &word, sizeof word);
}

static void send_words(near_work *work, size_t face, int rank, void *context) {
    const ply_part *part = work->part;
    const size_t begin = norma_mpi_corner_begin(part, face),
                 end = norma_mpi_corner_begin(part, face + 1);
    if (rank == work->job->call.rank) return;
    add_word(context, rank, (uint32_t)begin);
    if (part->face_starts) add_word(context, rank, (uint32_t)(end - begin));
    for (size_t c = begin; c < end; c++) add_word(context, rank, part->corner[c]);
}

static norma_result list_faces(near_work *work, mpi_lists *out) {
    const mpi_call *call = &work->job->call;
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    for_each_rank(work, count_words, room);
    const norma_result result = norma_mpi_lists_open(call, room, sizeof(uint32_t), out);
    norma_core_release(call->core, room, ranks, sizeof *room);
    if (result == NORMA_OK) for_each_rank(work, send_words, out);
    return result;
}

/* ---- the faces that are here, in order */

typedef void near_take(
    ply_near *near, uint32_t origin, const unsigned char *vertices, size_t corners);

static void take_own(const near_work *work, near_take *take) {
    const ply_part *part = work->part;
    for (size_t f = 0; f < part->faces; f++) {
        const size_t begin = norma_mpi_corner_begin(part, f);
        if (work->stays[f])
            take(work->near, (uint32_t)begin, (const unsigned char *)(part->corner + begin),
                norma_mpi_corner_begin(part, f + 1) - begin);
    }
}

static void take_received(const near_work *work, const mpi_lists *in, int rank, near_take *take) {
    size_t at = (size_t)in->starts[rank];
    const size_t end = at + (size_t)in->counts[rank];
    while (at < end) {
        uint32_t origin, corners = 3;
        memcpy(&origin, norma_mpi_record(in, at++), sizeof origin);
        if (work->part->face_starts) memcpy(&corners, norma_mpi_record(in, at++), sizeof corners);
        take(work->near, origin, norma_mpi_record(in, at), corners);
        at += corners;
    }
}

static void take_all(const near_work *work, const mpi_lists *in, near_take *take) {
    ply_near *near = work->near;
    near->part.faces = near->part.corners = 0;
    for (int r = 0; r < work->job->call.ranks; r++) {
        near->face_begins[r] = near->part.faces;
        if (r == work->job->call.rank)
            take_own(work, take);
        else
            take_received(work, in, r, take);
    }
    near->face_begins[work->job->call.ranks] = near->part.faces;
}

static void count_face(
    ply_near *near, uint32_t origin, const unsigned char *vertices, size_t corners) {
    (void)origin, (void)vertices;
    near->part.faces++;
    near->part.corners += corners;
}

static void keep_face(
    ply_near *near, uint32_t origin, const unsigned char *vertices, size_t corners) {
    memcpy(near->part.corner + near->part.corners, vertices, corners * sizeof *near->part.corner);
    near->origins[near->part.faces++] = origin;
    near->part.corners += corners;
    if (near->part.face_starts)
        near->part.face_starts[near->part.faces] = (uint32_t)near->part.corners;
}

static norma_result open_near(const near_work *work) {
    const core_call *core = &work->job->core;
    ply_near *near = work->near;
    ply_part *part = &near->part;
    if (part->corners > UINT32_MAX - 1) return NORMA_ERROR_OVERFLOW;
    part->corner_room = part->corners;
    part->corner = norma_core_allocate(core, part->corner_room, sizeof *part->corner);
    near->origins = norma_core_allocate(core, part->faces, sizeof *near->origins);
    if (!part->corner || !near->origins) return NORMA_ERROR_MEMORY;
    if (!work->part->face_starts) return NORMA_OK;
    part->start_room = part->faces + 1;
    part->face_starts = norma_core_allocate(core, part->start_room, sizeof *part->face_starts);
    if (!part->face_starts) return NORMA_ERROR_MEMORY;
    part->face_starts[0] = 0;
    return NORMA_OK;
}

static norma_result exchange_faces(near_work *work) {
    mpi_call *call = &work->job->call;
    mpi_lists out = {0}, in = {0};
    norma_result result = norma_mpi_exchange(call, list_faces(work, &out), &out, &in);
    norma_mpi_lists_close(call, &out);
    if (result != NORMA_OK) return result;
    take_all(work, &in, count_face);
    const norma_result mine = open_near(work);
    if (mine == NORMA_OK) take_all(work, &in, keep_face);
    norma_mpi_lists_close(call, &in);
    return norma_mpi_agree(call, mine);
}

/* ---- classes of all vertices here; places in their order */

static norma_result fetch_classes(mpi_job *job, const ply_layout *layout, const ply_part *part,
    const uint32_t *own, uint32_t **classes) {
    const size_t count = part->own + part->others;
    *classes = norma_core_allocate(&job->core, count, sizeof **classes);
    if (*classes && part->own) memcpy(*classes, own, part->own * sizeof *own);
    const norma_result result =
        norma_mpi_agree(&job->call, *classes ? NORMA_OK : NORMA_ERROR_MEMORY);
    if (result != NORMA_OK) return result;
    const ply_values values = {
        sizeof *own, (const unsigned char *)own, (unsigned char *)(*classes + part->own)};
    return norma_mpi_fetch_values(job, layout->vertices, part, &values);
}

/* Equal classes lie one after the other, the same on every rank: so that an edge has its lower
 * end at the same rank for both. */
static norma_result sort_places(mpi_job *job, ply_near *near) {
    const core_call *core = &job->core;
    ply_part *part = &near->part;
    const size_t count = norma_mpi_places(near), size = norma_mpi_position_size(part);
    uint64_t *order = norma_core_allocate(core, count, sizeof *order),
             *ids = norma_core_allocate(core, count, sizeof *ids);
    uint32_t *to = norma_core_allocate(core, count, sizeof *to);
    unsigned char *positions = norma_core_allocate(core, count, size);
    const int fine = order && ids && to && positions;
    for (size_t i = 0; fine && i < count; i++)
        order[i] = (uint64_t)near->classes[i] << 32 | part->vertex_ids[i];
    if (fine) norma_core_sort_numbers(order, count);
    for (size_t i = 0; fine && i < count; i++) {
        const uint32_t vertex = (uint32_t)order[i], from = norma_mpi_place_of(part, vertex);
        to[from] = (uint32_t)i;
        ids[i] = vertex;
        memcpy(positions + i * size, part->positions + from * size, size);
        near->classes[i] = (uint32_t)(order[i] >> 32);
    }
    for (size_t c = 0; fine && c < part->corners; c++) part->corner[c] = to[part->corner[c]];
    norma_core_release(core, order, count, sizeof *order);
    norma_core_release(core, to, count, sizeof *to);
    norma_core_release(core, fine ? part->vertex_ids : ids, count, sizeof *ids);
    norma_core_release(core, fine ? part->positions : positions, count, size);
    if (!fine) return NORMA_ERROR_MEMORY;
    part->vertex_ids = ids;
    part->positions = positions;
    return NORMA_OK;
}

/* ---- all */

static norma_result open_work(near_work *work, ply_part *part) {
    const core_call *core = &work->job->core;
    const size_t ranks = (size_t)work->job->call.ranks;
    const int listed = norma_mpi_list_vertices(work->job, part) == 0;
    work->last = norma_core_allocate(core, ranks, sizeof *work->last);
    work->stays = norma_core_allocate(core, part->faces, 1);
    work->near->face_begins = norma_core_allocate(core, ranks + 1, sizeof *work->near->face_begins);
    if (!listed || !work->last || !work->stays || !work->near->face_begins)
        return NORMA_ERROR_MEMORY;
    memset(work->stays, 0, part->faces);
    return NORMA_OK;
}

static void close_work(near_work *work) {
    const core_call *core = &work->job->core;
    const size_t count = work->part->own + work->part->others;
    norma_core_release(core, work->classes, count, sizeof *work->classes);
    norma_core_release(core, work->last, (size_t)work->job->call.ranks, sizeof *work->last);
    norma_core_release(core, work->stays, work->part->faces, 1);
}

int norma_mpi_gather_near(mpi_job *job, const ply_layout *layout, ply_part *part,
    const uint32_t *classes, ply_near *near) {
    mpi_call *call = &job->call;
    near_work work = {.job = job, .layout = layout, .part = part, .near = near};
    *near = (ply_near){.part = {.first = part->first, .own = part->own}};
    norma_result result = norma_mpi_agree(call, open_work(&work, part));
    if (result == NORMA_OK) result = fetch_classes(job, layout, part, classes, &work.classes);
    if (result == NORMA_OK) result = exchange_faces(&work);
    close_work(&work);
    norma_mpi_drop_corners(job, part);
    if (norma_mpi_failed_result(job, result)) return 1;
    if (norma_mpi_fetch_positions(job, layout, &near->part)) return 1;
    result = fetch_classes(job, layout, &near->part, classes, &near->classes);
    if (result == NORMA_OK) result = norma_mpi_agree(call, sort_places(job, near));
    return norma_mpi_failed_result(job, result);
}

void norma_mpi_close_near(mpi_job *job, ply_near *near) {
    const core_call *core = &job->core;
    norma_core_release(core, near->classes, norma_mpi_places(near), sizeof *near->classes);
    norma_core_release(core, near->origins, near->part.faces, sizeof *near->origins);
    norma_core_release(
        core, near->face_begins, (size_t)job->call.ranks + 1, sizeof *near->face_begins);
    norma_mpi_close_part_of_ply(job, &near->part);
    *near = (ply_near){0};
}
