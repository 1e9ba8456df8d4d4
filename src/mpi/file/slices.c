/* slices.c: files that ranks compute in slices: a binary PLY and a binary STL. */
#include "core/call/call.h"
#include "core/call/table.h"
#include "io/format/format.h"
#include "io/large/large.h"
#include "io/stl/stl.h"
#include "mpi/file/shared_file.h"
#include "mpi/vertex/vertex.h"
#include <errno.h>
#include <norma/mpi.h>
#include <stdlib.h>

/* ---- a binary PLY with a normal for each vertex. Each rank reads a range of faces and one of
 * vertices, with the reader of files larger than memory; positions of other vertices that its faces
 * name come from the ranks that read them. The output's rows have one size, so each rank writes
 * those of its own vertices where they belong. */

typedef struct mpi_ply {
    mpi_job *job;
    large_file file;
    large_ply ply;
    norma_document_error error;
    size_t faces, corners;
    uint32_t *corner;      /* numbers of the file; once positions are fetched, places here */
    uint32_t *face_starts; /* NULL: triangles */
    size_t corner_room, start_room;
    uint64_t first; /* this rank's own vertices: own of them, from first on */
    size_t own, others;
    uint64_t *vertex_ids; /* own, then the others that faces name, ascending */
    unsigned char *positions;
} mpi_ply;

static int rank_fail_memory(mpi_job *job) {
    return norma_mpi_fail(job, "%s: out of memory", job->input);
}

static int fail_ply(mpi_ply *p, norma_document_result result) {
    return result ? norma_mpi_fail(p->job, "%s", p->error.message) : 0;
}

/* ---- opening */

static int read_input(void *job, uint64_t offset, void *bytes, size_t size) {
    return norma_mpi_read(job, offset, bytes, size) ? EIO : 0;
}

/* Blocks of a megabyte, whatever the file's size. */
static int open_ply(mpi_ply *p) {
    enum { BUFFERS = 48 << 20 };
    mpi_job *job = p->job;
    const large_source source = {
        read_input, job, job->size, "norma-mpi reads it in parts", "use norma compute"};
    p->file = (large_file){.error = &p->error, .budget = {.most = BUFFERS}, .to = 1};
    norma_document_result result =
        norma_large_open_source(job->input, NORMA_FILE_PLY, &source, &p->file);
    if (!result) result = norma_large_ply_open(&p->file, &p->ply);
    if (result) return fail_ply(p, result);
    norma_mpi_count_memory(job, (size_t)p->file.budget.used);
    job->faces = p->ply.faces;
    job->vertices = p->ply.vertices;
    p->first = norma_mpi_share_of(job, job->vertices, job->call.rank);
    p->own = (size_t)(norma_mpi_share_of(job, job->vertices, job->call.rank + 1) - p->first);
    return 0;
}

static void close_ply(mpi_ply *p) {
    const core_call *core = &p->job->core;
    const size_t count = p->own + p->others;
    norma_core_release(core, p->corner, p->corner_room, sizeof *p->corner);
    norma_core_release(core, p->face_starts, p->start_room, sizeof *p->face_starts);
    norma_core_release(core, p->vertex_ids, count, sizeof *p->vertex_ids);
    norma_core_release(core, p->positions, count, norma_large_position_size(&p->ply));
    norma_large_ply_close(&p->ply);
    norma_large_close(&p->file);
}

/* ---- where each rank's faces begin: where rows have one size, each knows; else the first rank
 * goes through all rows once and tells */

static uint64_t rank_begin_of(const mpi_ply *p, int rank) {
    return norma_mpi_share_of(p->job, p->ply.faces, rank);
}

/* Whether the rows of this rank, were all before triangles, are triangles too. */
static int are_even(mpi_ply *p, int *all) {
    const size_t row = norma_large_even_row(&p->ply);
    const int rank = p->job->call.rank;
    const uint64_t begin = p->ply.face ? p->ply.face->begin : 0, end = rank_begin_of(p, rank + 1);
    norma_document_result result = NORMA_DOCUMENT_OK;
    *all = !p->ply.faces || (row && p->ply.faces <= (p->file.size - begin) / row);
    for (uint64_t f = rank_begin_of(p, rank); f < end && *all && !result; f += LARGE_CHUNK)
        result = norma_large_are_even(
            &p->ply, begin + f * row, norma_large_some(end - f, LARGE_CHUNK), all);
    return fail_ply(p, result);
}

static int find_begins(mpi_ply *p, uint64_t *begins) {
    norma_document_result result = NORMA_DOCUMENT_OK;
    uint64_t face = 0;
    begins[0] = p->ply.face->begin;
    for (int rank = 1; rank <= p->job->call.ranks && !result; ++rank) {
        begins[rank] = begins[rank - 1];
        for (const uint64_t end = rank_begin_of(p, rank); face < end && !result;) {
            const size_t some = norma_large_some(end - face, LARGE_CHUNK);
            result = norma_large_ply_chunk(&p->ply, face, some, &begins[rank]);
            face += some;
        }
    }
    return fail_ply(p, result);
}

/* Collective. begin: of this rank's faces. */
static int place_faces(mpi_ply *p, uint64_t *begin, int *triangles) {
    mpi_job *job = p->job;
    const size_t ranks = (size_t)job->call.ranks;
    int all = 0, failed = are_even(p, &all);
    if (norma_mpi_failed(job, failed)) return 1;
    *triangles = norma_mpi_largest(&job->call, (uint64_t)!all) == 0;
    *begin = p->ply.face ? p->ply.face->begin : 0;
    *begin += rank_begin_of(p, job->call.rank) * norma_large_even_row(&p->ply);
    if (*triangles) return 0;
    uint64_t *begins = norma_core_allocate(&job->core, ranks + 1, sizeof *begins);
    failed = begins ? job->call.rank == 0 && find_begins(p, begins) : rank_fail_memory(job);
    failed = norma_mpi_failed(job, failed);
    if (!failed) MPI_Bcast(begins, (int)ranks + 1, MPI_UINT64_T, 0, job->call.comm);
    if (!failed) *begin = begins[job->call.rank];
    norma_core_release(&job->core, begins, ranks + 1, sizeof *begins);
    return failed;
}

/* ---- corners */

static int grow_corners(mpi_ply *p, size_t more) {
    const core_call *core = &p->job->core;
    if (p->corners + more <= p->corner_room) return 0;
    const size_t room = p->corners + more + p->corner_room / 2 + 1024;
    uint32_t *corner = room > UINT32_MAX ? NULL : norma_core_allocate(core, room, sizeof *corner);
    if (!corner) return rank_fail_memory(p->job);
    if (p->corners) memcpy(corner, p->corner, p->corners * sizeof *corner);
    norma_core_release(core, p->corner, p->corner_room, sizeof *corner);
    p->corner = corner;
    p->corner_room = room;
    return 0;
}

static int rank_take_chunk(mpi_ply *p, size_t first) {
    const large_faces *chunk = &p->ply.chunk;
    if (grow_corners(p, chunk->corner_count)) return 1;
    if (chunk->corner_count)
        memcpy(p->corner + p->corners, chunk->corners, chunk->corner_count * sizeof *p->corner);
    for (size_t i = 1; p->face_starts && i <= chunk->count; ++i)
        p->face_starts[first + i] = (uint32_t)p->corners + chunk->starts[i];
    p->corners += chunk->corner_count;
    return 0;
}

static int open_faces(mpi_ply *p, int triangles) {
    if (p->faces >= UINT32_MAX / 3) return rank_fail_memory(p->job);
    if (grow_corners(p, 3 * p->faces)) return 1;
    if (triangles) return 0;
    p->start_room = p->faces + 1;
    p->face_starts = norma_core_allocate(&p->job->core, p->start_room, sizeof *p->face_starts);
    if (!p->face_starts) return rank_fail_memory(p->job);
    p->face_starts[0] = 0;
    return 0;
}

static int rank_read_chunks(mpi_ply *p, uint64_t begin) {
    const uint64_t first = rank_begin_of(p, p->job->call.rank), end = first + p->faces;
    int failed = 0;
    for (uint64_t f = first; f < end && !failed; f += LARGE_CHUNK) {
        const size_t some = norma_large_some(end - f, LARGE_CHUNK);
        failed = fail_ply(p, norma_large_ply_chunk(&p->ply, f, some, &begin)) ||
                 rank_take_chunk(p, (size_t)(f - first));
    }
    return failed;
}

/* Collective. */
static int rank_read_faces(mpi_ply *p) {
    const int rank = p->job->call.rank;
    uint64_t begin;
    int triangles;
    p->faces = (size_t)(rank_begin_of(p, rank + 1) - rank_begin_of(p, rank));
    if (place_faces(p, &begin, &triangles)) return 1;
    return norma_mpi_failed(p->job, open_faces(p, triangles) || rank_read_chunks(p, begin));
}

/* ---- vertices: own ones, and others that faces name */

static int rank_is_own(const mpi_ply *p, uint32_t vertex) { return vertex - p->first < p->own; }

static size_t rank_drop_repeated(uint64_t *numbers, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i)
        if (!kept || numbers[i] != numbers[kept - 1]) numbers[kept++] = numbers[i];
    return kept;
}

static int rank_list_vertices(mpi_ply *p) {
    const core_call *core = &p->job->core;
    size_t most = 0, count = 0;
    for (size_t c = 0; c < p->corners; ++c) most += !rank_is_own(p, p->corner[c]);
    uint64_t *others = norma_core_allocate(core, most, sizeof *others);
    if (!others) return rank_fail_memory(p->job);
    for (size_t c = 0; c < p->corners; ++c)
        if (!rank_is_own(p, p->corner[c])) others[count++] = p->corner[c];
    norma_core_sort_numbers(others, count);
    count = rank_drop_repeated(others, count);
    uint64_t *ids = norma_core_allocate(core, p->own + count, sizeof *ids);
    for (size_t i = 0; ids && i < p->own; ++i) ids[i] = p->first + i;
    if (ids && count) memcpy(ids + p->own, others, count * sizeof *ids);
    norma_core_release(core, others, most, sizeof *others);
    if (!ids) return rank_fail_memory(p->job);
    p->vertex_ids = ids;
    p->others = count;
    return p->own + count > UINT32_MAX - 1 ? rank_fail_memory(p->job) : 0;
}

typedef struct vertex_search {
    const uint64_t *others;
    uint32_t vertex;
} vertex_search;

static int is_lower(const void *context, size_t i) {
    const vertex_search *search = context;
    return search->others[i] < search->vertex;
}

static uint32_t rank_place_of(const mpi_ply *p, uint32_t vertex) {
    const vertex_search search = {p->vertex_ids + p->own, vertex};
    return (uint32_t)(rank_is_own(p, vertex)
                          ? vertex - p->first
                          : p->own + norma_core_bisect(p->others, is_lower, &search));
}

static int rank_read_positions(mpi_ply *p) {
    const size_t size = norma_large_position_size(&p->ply);
    norma_document_result result = NORMA_DOCUMENT_OK;
    p->positions = norma_core_allocate(&p->job->core, p->own + p->others, size);
    if (!p->positions) return rank_fail_memory(p->job);
    for (size_t v = 0; v < p->own && !result; v += LARGE_BLOCK)
        result = norma_large_ply_positions(&p->ply, (size_t)p->first + v,
            norma_large_some(p->own - v, LARGE_BLOCK), p->positions + v * size);
    return fail_ply(p, result);
}

/* ---- fetching others */

static int owner_of(const mpi_ply *p, uint64_t vertex) {
    const mpi_job *job = p->job;
    int rank = (int)((double)vertex / (double)job->vertices * job->call.ranks);
    while (rank > 0 && norma_mpi_share_of(job, job->vertices, rank) > vertex) --rank;
    while (norma_mpi_share_of(job, job->vertices, rank + 1) <= vertex) ++rank;
    return rank;
}

/* The others from begin to end: ascending, so by owners. */
typedef struct wanted_positions {
    const mpi_ply *p;
    const uint64_t *others;
} wanted_positions;

static int owner_of_wanted(const void *context, size_t i) {
    const wanted_positions *wanted = context;
    return owner_of(wanted->p, wanted->others[i]);
}

static void write_wanted_vertex(const void *context, size_t i, unsigned char *record) {
    const uint32_t vertex = (uint32_t)((const wanted_positions *)context)->others[i];
    memcpy(record, &vertex, sizeof vertex);
}

static norma_result answer_positions(void *context, const mpi_lists *in, mpi_lists *answers) {
    const mpi_ply *p = context;
    const size_t size = answers->record, count = norma_mpi_lists_total(&p->job->call, in);
    for (size_t i = 0; i < count; ++i) {
        uint32_t vertex;
        memcpy(&vertex, norma_mpi_record(in, i), sizeof vertex);
        memcpy(
            norma_mpi_record(answers, i), p->positions + (size_t)(vertex - p->first) * size, size);
    }
    return NORMA_OK;
}

static norma_result fetch_some(mpi_ply *p, size_t begin, size_t end) {
    mpi_call *call = &p->job->call;
    const size_t size = norma_large_position_size(&p->ply);
    const wanted_positions wanted = {p, p->vertex_ids + p->own + begin};
    const mpi_listing listing = {
        end - begin, sizeof(uint32_t), owner_of_wanted, write_wanted_vertex, &wanted};
    mpi_lists back;
    const norma_result result =
        norma_mpi_ask(call, MPI_POSITIONS, &listing, size, answer_positions, p, &back);
    if (!result) memcpy(p->positions + (p->own + begin) * size, back.bytes, (end - begin) * size);
    norma_mpi_lists_close(call, &back);
    return result;
}

static norma_result fetch_others(mpi_ply *p) {
    enum { AT_ONCE = 1 << 16 };
    const size_t some = p->faces / 2 > AT_ONCE ? p->faces / 2 : AT_ONCE;
    const uint64_t rounds = norma_mpi_largest(&p->job->call, p->others / some + 1);
    norma_result result = NORMA_OK;
    size_t begin = 0;
    for (uint64_t round = 0; round < rounds && !result; ++round) {
        const size_t end = p->others - begin < some ? p->others : begin + some;
        result = fetch_some(p, begin, end);
        begin = end;
    }
    return result;
}

/* Collective. */
static int rank_read_vertices(mpi_ply *p) {
    if (norma_mpi_failed(p->job, rank_list_vertices(p) || rank_read_positions(p))) return 1;
    for (size_t c = 0; c < p->corners; ++c) p->corner[c] = rank_place_of(p, p->corner[c]);
    return norma_mpi_failed_result(p->job, fetch_others(p));
}

/* ---- the output */

typedef struct place_in_output {
    mpi_job *job;
    uint64_t at;
    int failed;
} place_in_output;

static int count_bytes(void *user, const void *bytes, size_t size) {
    (void)bytes;
    *(uint64_t *)user += size;
    return 0;
}

static int write_here(void *user, const void *bytes, size_t size) {
    place_in_output *place = user;
    if (!place->failed) place->failed = norma_mpi_write(place->job, place->at, bytes, size);
    place->at += size;
    return place->failed;
}

/* The rows of own vertices, from the v-th on; normals become as they are stored. */
static int rank_write_rows(
    mpi_ply *p, size_t v, size_t count, float *normals, place_in_output *place) {
    const size_t first = (size_t)p->first + v;
    double *stored;
    norma_document_result result = norma_large_ply_stored(&p->ply, first, count, &stored);
    if (result) return fail_ply(p, result);
    for (size_t i = 0; i < count; ++i) norma_policy_point_up(normals + 3 * i);
    result = norma_ply_encode_normals(
        p->file.document, p->ply.state->edit.normals.types, normals, count, &p->error);
    for (size_t i = 0; stored && i < 3 * count; ++i)
        normals[i] = norma_policy_keep_zero(normals[i], stored[i]);
    free(stored);
    if (!result)
        result = norma_large_ply_write_rows(&p->ply, first, count, normals, write_here, place);
    return place->failed || fail_ply(p, result);
}

/* Collective, once the output is open; head: bytes of its header. */
static int rank_write_parts(mpi_ply *p, uint64_t head, const ply_row *row, float *normals) {
    mpi_job *job = p->job;
    const uint64_t body = p->ply.state->header.body, begin = p->ply.vertex->begin - body,
                   behind = p->ply.vertex->end,
                   behind_there = head + begin + job->vertices * row->size;
    place_in_output place = {.job = job};
    ply_row same;
    if (!job->call.rank &&
        (fail_ply(p, norma_large_ply_write_header(&p->ply, write_here, &place, &same)) ||
            place.failed))
        return 1;
    if (norma_mpi_copy_share(job, body, head, begin)) return 1;
    place.at = head + begin + p->first * row->size;
    for (size_t v = 0; v < p->own; v += LARGE_BLOCK)
        if (rank_write_rows(
                p, v, norma_large_some(p->own - v, LARGE_BLOCK), normals + 3 * v, &place))
            return 1;
    return norma_mpi_copy_share(job, behind, behind_there, job->size - behind);
}

static int rank_write_output(mpi_ply *p, float *normals) {
    mpi_job *job = p->job;
    uint64_t head = 0;
    ply_row row;
    const norma_document_result result =
        norma_large_ply_write_header(&p->ply, count_bytes, &head, &row);
    if (norma_mpi_failed(job, fail_ply(p, result))) return 1;
    const large_ply *ply = &p->ply;
    const uint64_t others =
        ply->vertex->begin - ply->state->header.body + job->size - ply->vertex->end;
    int failed = norma_mpi_open_output(job, head + others + job->vertices * row.size);
    if (!failed) failed = rank_write_parts(p, head, &row, normals);
    return norma_mpi_close_output(job, failed);
}

/* ---- all */

/* A reader's block of a megabyte, which a small slice alone would hardly need, is there while it is
 * read from. */
static void rank_close_reader(mpi_ply *p, large_reader *reader) {
    const uint64_t before = p->file.budget.used;
    norma_large_reader_close(reader);
    p->job->memory -= before - p->file.budget.used;
}

static int rank_open_reader(mpi_ply *p, large_reader *reader) {
    const uint64_t before = p->file.budget.used;
    if (!norma_large_reader_open(&p->file, reader)) return rank_fail_memory(p->job);
    norma_mpi_count_memory(p->job, (size_t)(p->file.budget.used - before));
    return 0;
}

static int rank_copy_unchanged(mpi_job *job) {
    int failed = norma_mpi_open_output(job, job->size);
    if (!failed) failed = norma_mpi_copy_share(job, 0, 0, job->size);
    return norma_mpi_close_output(job, failed);
}

static int rank_compute(mpi_ply *p) {
    mpi_job *job = p->job;
    rank_close_reader(p, &p->ply.rows); /* of faces */
    if (rank_read_vertices(p)) return 1;
    rank_close_reader(p, &p->ply.blocks);
    const size_t count = p->own + p->others;
    const norma_mesh mesh = {
        .positions = {.data = p->positions,
            .count = count,
            .format = p->ply.single ? NORMA_FORMAT_FLOAT : NORMA_FORMAT_DOUBLE},
        .corners = p->corner,
        .corner_count = p->corners,
        .face_starts = p->face_starts,
        .face_count = p->face_starts ? p->faces : 0};
    float *normals = norma_core_allocate(&job->core, count, 3 * sizeof *normals);
    int failed = norma_mpi_failed(job, normals ? 0 : rank_fail_memory(job));
    if (!failed)
        failed = norma_mpi_failed_result(
            job, norma_mpi_normals_of(job->call.comm, job->call.sent, &mesh, p->vertex_ids, NULL,
                     &job->options, normals, count, &job->report));
    if (!failed) failed = norma_mpi_failed(job, rank_open_reader(p, &p->ply.blocks));
    if (!failed) failed = rank_write_output(p, normals);
    norma_core_release(&job->core, normals, count, 3 * sizeof *normals);
    return failed;
}

int norma_mpi_compute_ply(mpi_job *job) {
    mpi_ply p = {.job = job};
    int failed = norma_mpi_failed(job, open_ply(&p)) || rank_read_faces(&p);
    if (!failed)
        failed = norma_mpi_sum(&job->call, p.corners) ? rank_compute(&p) : rank_copy_unchanged(job);
    close_ply(&p);
    return failed;
}

/* ---- facet normals of a binary STL, a block at a time. Facets without a direction take the normal
 * of the nearest that has one; only where there are such are positions and normals kept. */

typedef struct stl_part {
    mpi_job *job;
    uint64_t first; /* this rank's facets: count of them, from first on */
    size_t count;
    large_facets *block;
    core_tally tally;
    int keep;                             /* what follows is kept of all facets */
    float *kept_positions, *kept_normals; /* first corners */
    uint8_t *kept_reasons;
    uint64_t *ids;
} stl_part;

static int open_kept(stl_part *p) {
    const core_call *core = &p->job->core;
    p->kept_positions = norma_core_allocate(core, p->count, 3 * sizeof *p->kept_positions);
    p->kept_normals = norma_core_allocate(core, p->count, 3 * sizeof *p->kept_normals);
    p->kept_reasons = norma_core_allocate(core, p->count, 1);
    p->ids = norma_core_allocate(core, p->count, sizeof *p->ids);
    p->keep = p->kept_positions && p->kept_normals && p->kept_reasons && p->ids;
    for (size_t i = 0; i < p->count && p->keep; ++i) p->ids[i] = p->first + i;
    return p->keep ? 0 : rank_fail_memory(p->job);
}

static void facets_close_part(stl_part *p) {
    const core_call *core = &p->job->core;
    norma_core_release(core, p->block, 1, sizeof *p->block);
    norma_core_release(core, p->kept_positions, p->count, 3 * sizeof *p->kept_positions);
    norma_core_release(core, p->kept_normals, p->count, 3 * sizeof *p->kept_normals);
    norma_core_release(core, p->kept_reasons, p->count, 1);
    norma_core_release(core, p->ids, p->count, sizeof *p->ids);
}

/* ---- a block */

static uint64_t offset_of(const stl_part *p, size_t i) {
    return STL_HEADER + (p->first + i) * STL_FACET;
}

static int rank_read_facets(stl_part *p, size_t begin, size_t count) {
    return norma_mpi_read(
        p->job, offset_of(p, begin), p->block->bytes + STL_HEADER, count * STL_FACET);
}

static int facets_compute_block(stl_part *p, size_t begin, size_t count) {
    large_facets *block = p->block;
    const stl_state state = {.bytes = block->bytes, .binary = 1, .facets = count};
    norma_options options = p->job->options;
    if (rank_read_facets(p, begin, count)) return 1;
    for (size_t i = 0; i < count; ++i) norma_stl_load(&state, i, NULL, block->positions + 9 * i);
    const norma_mesh mesh = {
        .positions = {.data = block->positions, .count = 3 * count}, .corner_count = 3 * count};
    options.reasons = block->reasons;
    options.fallback = NORMA_FALLBACK_ZERO;
    const norma_result result = norma_face_normals(&mesh, &options, block->normals, count, NULL);
    if (result) return norma_mpi_fail(p->job, "%s: %s", p->job->input, norma_result_text(result));
    for (size_t i = 0; i < count; ++i) {
        if (!p->keep) norma_core_tally(&p->tally, block->reasons[i], (size_t)p->first + begin + i);
        if (p->keep)
            memcpy(
                p->kept_positions + 3 * (begin + i), block->positions + 9 * i, 3 * sizeof(float));
    }
    if (p->keep) memcpy(p->kept_normals + 3 * begin, block->normals, count * 3 * sizeof(float));
    if (p->keep) memcpy(p->kept_reasons + begin, block->reasons, count);
    return 0;
}

static int facets_write_block(stl_part *p, size_t begin, size_t count, float *normals) {
    for (size_t i = 0; i < count; ++i) norma_policy_point_up(normals + 3 * i);
    norma_stl_replace_normals(p->block->bytes, 0, count, normals);
    return norma_mpi_write(
        p->job, offset_of(p, begin), p->block->bytes + STL_HEADER, count * STL_FACET);
}

static int for_blocks(stl_part *p, int read, int write) {
    int failed = 0;
    for (size_t at = 0; at < p->count && !failed; at += LARGE_FACETS) {
        const size_t count = norma_large_some(p->count - at, LARGE_FACETS);
        failed = read ? facets_compute_block(p, at, count) : rank_read_facets(p, at, count);
        if (!failed && write)
            failed = facets_write_block(
                p, at, count, read ? p->block->normals : p->kept_normals + 3 * at);
    }
    return failed;
}

/* ---- facets without a direction */

static int fill_missing(stl_part *p) {
    mpi_part sites = {.vertex_ids = p->ids, .positions = p->count};
    norma_mesh mesh = {.positions = {.data = p->kept_positions, .count = p->count}};
    norma_result result = norma_core_mesh_shape(&mesh, &sites.prepared.mesh);
    if (!result)
        result = norma_core_output_open(
            &p->job->core, p->kept_normals, p->count, p->count, &sites.output);
    if (norma_mpi_failed_result(p->job, result)) return 1;
    return norma_mpi_failed_result(
        p->job, norma_mpi_fill_nearest(&p->job->call, &sites, p->kept_reasons));
}

static int facets_run(stl_part *p) {
    mpi_job *job = p->job;
    p->block = norma_core_allocate(&job->core, 1, sizeof *p->block);
    int failed = norma_mpi_failed(job, p->block ? 0 : rank_fail_memory(job));
    if (!failed) failed = norma_mpi_open_output(job, job->size);
    if (!failed && !job->call.rank)
        failed = norma_mpi_read(job, 0, p->block->bytes, STL_HEADER) ||
                 norma_mpi_write(job, 0, p->block->bytes, STL_HEADER);
    if (!failed) failed = for_blocks(p, 1, 1);
    failed = norma_mpi_failed(job, failed);
    norma_mpi_add_tallies(&job->call, &p->tally);
    norma_core_write_report(&job->report, &p->tally, NULL, NULL);
    if (!failed && p->tally.degenerate.count + p->tally.non_finite.count) {
        failed = norma_mpi_failed(job, open_kept(p) || for_blocks(p, 1, 0));
        if (!failed) failed = fill_missing(p);
        if (!failed) failed = for_blocks(p, 0, 1);
    }
    return norma_mpi_close_output(job, failed);
}

int norma_mpi_compute_stl(mpi_job *job) {
    stl_part part = {.job = job};
    uint32_t facets = 0;
    unsigned char header[STL_HEADER];
    int failed = job->size < STL_HEADER ? 0 : norma_mpi_read(job, 0, header, sizeof header);
    if (norma_mpi_failed(job, failed)) return 1;
    for (int i = 0; i < 4; ++i) facets |= (uint32_t)header[80 + i] << (8 * i);
    if (job->size < STL_HEADER || job->size != STL_HEADER + (uint64_t)facets * STL_FACET)
        return norma_mpi_fail(job,
            "%s: is not a complete binary STL; norma-mpi does not read ASCII, use norma compute",
            job->input);
    part.first = norma_mpi_share_of(job, facets, job->call.rank);
    part.count = (size_t)(norma_mpi_share_of(job, facets, job->call.rank + 1) - part.first);
    job->faces = facets;
    job->vertices = 3 * (uint64_t)facets;
    failed = facets_run(&part);
    facets_close_part(&part);
    return failed;
}
