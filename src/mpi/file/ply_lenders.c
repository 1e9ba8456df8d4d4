/* ply_lenders.c: all faces at an edge meet at the ranks of both of its ends. The rank of the lower
 * end decides who lends there, and tells the ranks of the face's other positions: with the corners
 * of the lender, in case it is not there. */
#include "mpi/file/ply_lenders.h"
#include "core/corner/vertex_star.h"

typedef struct lender_work {
    mpi_job *job;
    uint64_t vertices;
    core_prepared_mesh *prepared;
    ply_near *near;
    ply_loans *loans;
} lender_work;

enum { NO_LENDER = 0 };

/* ---- faces without a direction */

static int is_flat(const core_prepared_mesh *prepared, size_t face) {
    core_face f;
    norma_core_prepared_mesh_face(prepared, face, &f);
    return (f.flags & (CORE_FACE_DIRECTED | CORE_FACE_FINITE | CORE_FACE_EDGED)) ==
           (CORE_FACE_FINITE | CORE_FACE_EDGED);
}

static size_t count_flat(const lender_work *work) {
    size_t count = 0;
    for (size_t f = 0; f < work->near->part.faces; f++)
        if (is_flat(work->prepared, f)) count++;
    return count;
}

/* Whether this rank decides who lends to the face. */
static int decides(const lender_work *work, size_t face) {
    const core_mesh *mesh = &work->prepared->mesh;
    const uint32_t corner = norma_core_longest_edge(mesh, face),
                   from = norma_core_welded_corner(mesh, corner),
                   to = norma_core_welded_corner(mesh, norma_core_next_kept(mesh, face, corner));
    return norma_mpi_is_mine(work->near, from < to ? from : to);
}

/* ---- words of a loan: who read the face, where its corners begin there, how many corners the
 * lender has, the same two of the lender, and of each of its corners the class and the position */

enum { WORDS_OF_LOAN = 5 };

static size_t words_of_corner(const ply_near *near) {
    return 1 + norma_mpi_position_size(&near->part) / sizeof(uint32_t);
}

static size_t corners_of(const ply_part *part, size_t face) {
    return norma_mpi_corner_begin(part, face + 1) - norma_mpi_corner_begin(part, face);
}

static int reader_of(const lender_work *work, size_t face) {
    int rank = 0;
    while (work->near->face_begins[rank + 1] <= face) rank++;
    return rank;
}

static void add_words(mpi_lists *out, int rank, const void *words, size_t count) {
    for (size_t i = 0; i < count; i++)
        memcpy(norma_mpi_lists_add(out, rank), (const unsigned char *)words + i * sizeof(uint32_t),
            sizeof(uint32_t));
}

static void send_loan(const lender_work *work, size_t face, int rank, mpi_lists *out) {
    const ply_near *near = work->near;
    const ply_part *part = &near->part;
    const uint32_t lender = work->prepared->borrowed_from[face];
    const size_t size = norma_mpi_position_size(part);
    uint32_t words[WORDS_OF_LOAN] = {
        (uint32_t)reader_of(work, face), near->origins[face], NO_LENDER, 0, 0};
    if (lender != UINT32_MAX) {
        words[2] = (uint32_t)corners_of(part, lender);
        words[3] = (uint32_t)reader_of(work, lender);
        words[4] = near->origins[lender];
    }
    add_words(out, rank, words, WORDS_OF_LOAN);
    for (size_t i = 0; i < words[2]; i++) {
        const uint32_t place = part->corner[norma_mpi_corner_begin(part, lender) + i];
        add_words(out, rank, &near->classes[place], 1);
        add_words(out, rank, part->positions + place * size, size / sizeof(uint32_t));
    }
}

static void count_loan(const lender_work *work, size_t face, int rank, uint64_t *room) {
    const uint32_t lender = work->prepared->borrowed_from[face];
    room[rank] += WORDS_OF_LOAN;
    if (lender != UINT32_MAX)
        room[rank] += corners_of(&work->near->part, lender) * words_of_corner(work->near);
}

/* To each rank but this one that has a position of the face; room or out. */
static void for_ranks_of(
    const lender_work *work, size_t face, uint64_t *room, mpi_lists *out, uint64_t *last) {
    const ply_part *part = &work->near->part;
    for (size_t c = norma_mpi_corner_begin(part, face); c < norma_mpi_corner_begin(part, face + 1);
         c++) {
        const int rank =
            norma_mpi_owner_of(work->job, work->vertices, work->near->classes[part->corner[c]]);
        if (rank == work->job->call.rank || last[rank] == face + 1) continue;
        last[rank] = face + 1;
        if (room)
            count_loan(work, face, rank, room);
        else
            send_loan(work, face, rank, out);
    }
}

static norma_result list_loans(const lender_work *work, mpi_lists *out) {
    const mpi_call *call = &work->job->call;
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room),
             *last = norma_core_allocate(call->core, ranks, sizeof *last);
    norma_result result = room && last ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (int pass = 0; pass < 2 && result == NORMA_OK; pass++) {
        if (pass) result = norma_mpi_lists_open(call, room, sizeof(uint32_t), out);
        if (!pass) memset(room, 0, ranks * sizeof *room);
        memset(last, 0, ranks * sizeof *last);
        for (size_t f = 0; f < work->near->part.faces && result == NORMA_OK; f++)
            if (is_flat(work->prepared, f) && decides(work, f))
                for_ranks_of(work, f, pass ? NULL : room, out, last);
    }
    norma_core_release(call->core, room, ranks, sizeof *room);
    norma_core_release(call->core, last, ranks, sizeof *last);
    return result;
}

/* ---- what comes */

/* The face here whose corners begin there at the rank that read it; UINT32_MAX: it is not here. */
static uint32_t find_face(const ply_near *near, uint32_t reader, uint32_t origin) {
    size_t low = near->face_begins[reader], high = near->face_begins[reader + 1];
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (near->origins[middle] < origin)
            low = middle + 1;
        else
            high = middle;
    }
    return low < near->face_begins[reader + 1] && near->origins[low] == origin ? (uint32_t)low
                                                                               : UINT32_MAX;
}

typedef struct growth {
    size_t faces, corners;
} growth;

static uint32_t word_at(const mpi_lists *in, size_t at) {
    uint32_t word;
    memcpy(&word, norma_mpi_record(in, at), sizeof word);
    return word;
}

/* Puts a lender behind all faces, a place for each corner. */
static uint32_t append_lender(ply_near *near, const mpi_lists *in, size_t at, uint32_t corners) {
    ply_part *part = &near->part;
    const size_t size = norma_mpi_position_size(part);
    for (uint32_t i = 0; i < corners; i++, at += words_of_corner(near)) {
        const size_t place = norma_mpi_places(near);
        near->classes[place] = word_at(in, at);
        memcpy(part->positions + place * size, norma_mpi_record(in, at + 1), size);
        part->vertex_ids[place] = UINT32_MAX;
        part->corner[part->corners++] = (uint32_t)place;
        part->others++;
    }
    near->origins[part->faces++] = UINT32_MAX;
    if (part->face_starts) part->face_starts[part->faces] = (uint32_t)part->corners;
    return (uint32_t)(part->faces - 1);
}

/* Counts into growth, or keeps. */
static void take_loans(const lender_work *work, const mpi_lists *in, growth *more) {
    ply_near *near = work->near;
    const size_t count = norma_mpi_lists_total(&work->job->call, in);
    for (size_t at = 0; at < count;) {
        const uint32_t corners = word_at(in, at + 2);
        const uint32_t face = find_face(near, word_at(in, at), word_at(in, at + 1));
        uint32_t lender =
            corners ? find_face(near, word_at(in, at + 3), word_at(in, at + 4)) : UINT32_MAX;
        const int missing = corners && lender == UINT32_MAX;
        if (more) {
            more->faces += (size_t)missing;
            more->corners += missing ? corners : 0;
            work->loans->room++;
        } else {
            if (missing) lender = append_lender(near, in, at + WORDS_OF_LOAN, corners);
            work->loans->loans[work->loans->count++] = (ply_loan){face, lender};
        }
        at += WORDS_OF_LOAN + corners * words_of_corner(near);
    }
}

/* A longer copy; NULL: out of memory, and the old one stays. */
static void *grow(const core_call *core, void *old, size_t count, size_t room, size_t size) {
    void *copy = norma_core_allocate(core, room, size);
    if (!copy) return NULL;
    if (count) memcpy(copy, old, count * size);
    norma_core_release(core, old, count, size);
    return copy;
}

static int grow_to(const core_call *core, void *array, size_t count, size_t room, size_t size) {
    void *old, *copy;
    memcpy(&old, array, sizeof old);
    if (room == count) return 1;
    if (!(copy = grow(core, old, count, room, size))) return 0;
    memcpy(array, &copy, sizeof copy);
    return 1;
}

static norma_result make_room(const lender_work *work, const growth *more) {
    const core_call *core = &work->job->core;
    ply_near *near = work->near;
    ply_part *part = &near->part;
    const size_t places = norma_mpi_places(near), all = places + more->corners;
    const size_t corners = part->corners + more->corners, faces = part->faces + more->faces;
    work->loans->loans = norma_core_allocate(core, work->loans->room, sizeof *work->loans->loans);
    if (corners > UINT32_MAX - 1 || all > UINT32_MAX - 1) return NORMA_ERROR_OVERFLOW;
    if (!work->loans->loans ||
        !grow_to(core, &part->corner, part->corner_room, corners, sizeof *part->corner) ||
        !grow_to(core, &near->origins, part->faces, faces, sizeof *near->origins) ||
        !grow_to(core, &near->classes, places, all, sizeof *near->classes) ||
        !grow_to(core, &part->vertex_ids, places, all, sizeof *part->vertex_ids) ||
        !grow_to(core, &part->positions, places, all, norma_mpi_position_size(part)))
        return NORMA_ERROR_MEMORY;
    part->corner_room = corners;
    if (!part->face_starts) return NORMA_OK;
    const size_t starts = part->start_room;
    part->start_room = faces + 1;
    return grow_to(core, &part->face_starts, starts, faces + 1, sizeof *part->face_starts)
               ? NORMA_OK
               : NORMA_ERROR_MEMORY;
}

norma_result norma_mpi_find_lenders(mpi_job *job, uint64_t vertices, core_prepared_mesh *prepared,
    ply_near *near, ply_loans *loans, int *grown) {
    mpi_call *call = &job->call;
    lender_work work = {job, vertices, prepared, near, loans};
    growth more = {0, 0};
    mpi_lists out = {0}, in = {0};
    const size_t flat = count_flat(&work);
    *grown = 0;
    if (!norma_mpi_largest(call, flat)) return NORMA_OK;
    norma_result result = NORMA_OK;
    if (flat && !prepared->borrowed_from) result = norma_core_find_borrowed_directions(prepared);
    if (result == NORMA_OK) result = list_loans(&work, &out);
    result = norma_mpi_exchange(call, result, &out, &in);
    norma_mpi_lists_close(call, &out);
    if (result != NORMA_OK) return result;
    take_loans(&work, &in, &more);
    result = make_room(&work, &more);
    if (result == NORMA_OK) take_loans(&work, &in, NULL);
    norma_mpi_lists_close(call, &in);
    *grown = more.faces != 0;
    return norma_mpi_agree(call, result);
}

void norma_mpi_close_loans(const mpi_job *job, ply_loans *loans) {
    norma_core_release(&job->core, loans->loans, loans->room, sizeof *loans->loans);
    *loans = (ply_loans){0};
}
