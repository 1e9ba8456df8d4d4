/* ply_positions.c: each rank reads a range of vertices; those that its faces name beyond come from
 * the ranks that read them. */
#include "core/call/sort.h"
#include "mpi/file/ply_faces.h"

static int fail_memory(mpi_job *job) {
    return norma_mpi_fail(job, "%s: out of memory", job->input);
}

size_t norma_mpi_position_size(const ply_part *part) {
    return 3 * (part->doubles ? sizeof(double) : sizeof(float));
}

/* ---- which others */

static int is_own(const ply_part *part, uint32_t vertex) {
    return vertex - part->first < part->own;
}

static size_t drop_repeated(uint64_t *numbers, size_t count) {
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (!kept || numbers[i] != numbers[kept - 1]) numbers[kept++] = numbers[i];
    return kept;
}

/* Own vertices, then the others. */
static int list_vertices(mpi_job *job, ply_part *part) {
    size_t most = 0, count = 0;
    for (size_t c = 0; c < part->corners; c++) most += !is_own(part, part->corner[c]);
    uint64_t *others = norma_core_allocate(&job->core, most, sizeof *others);
    if (!others) return fail_memory(job);
    for (size_t c = 0; c < part->corners; c++)
        if (!is_own(part, part->corner[c])) others[count++] = part->corner[c];
    norma_core_sort_numbers(others, count);
    count = drop_repeated(others, count);
    uint64_t *ids = norma_core_allocate(&job->core, part->own + count, sizeof *ids);
    for (size_t i = 0; ids && i < part->own; i++) ids[i] = part->first + i;
    if (ids && count) memcpy(ids + part->own, others, count * sizeof *ids);
    norma_core_release(&job->core, others, most, sizeof *others);
    if (!ids) return fail_memory(job);
    part->vertex_ids = ids;
    part->others = count;
    return part->own + count > UINT32_MAX - 1 ? fail_memory(job) : 0;
}

static uint32_t place_of(const ply_part *part, uint32_t vertex) {
    const uint64_t *others = part->vertex_ids + part->own;
    size_t low = 0, high = part->others;
    if (is_own(part, vertex)) return (uint32_t)(vertex - part->first);
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (others[middle] <= vertex)
            low = middle;
        else
            high = middle;
    }
    return (uint32_t)(part->own + low);
}

/* ---- reading own ones */

static int needs_doubles(const ply_layout *layout) {
    const ply_header *header = layout->from;
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    for (int k = 0; k < 3; k++) {
        const ply_type type = norma_ply_property(header, vertex, header->position[k])->type;
        if (type == PLY_INT32 || type == PLY_UINT32 || type == PLY_DOUBLE) return 1;
    }
    return 0;
}

static void decode_row(
    const ply_layout *layout, const unsigned char *row, int doubles, unsigned char *position) {
    const ply_header *header = layout->from;
    const ply_element *vertex = norma_ply_element(header, header->vertex);
    for (size_t k = 0; k < 3; k++) {
        const int p = header->position[k];
        const double value = norma_ply_get(row + norma_mpi_offset_in_row(header, vertex, p),
            norma_ply_property(header, vertex, p)->type, header->encoding);
        const float single = (float)value;
        if (doubles)
            memcpy(position + k * sizeof value, &value, sizeof value);
        else
            memcpy(position + k * sizeof single, &single, sizeof single);
    }
}

static int read_positions(mpi_job *job, const ply_layout *layout, ply_part *part) {
    part->doubles = needs_doubles(layout);
    const size_t size = norma_mpi_position_size(part),
                 row = norma_ply_element(layout->from, layout->from->vertex)->fixed_size,
                 rows = MPI_BLOCK / row;
    unsigned char *block = norma_core_allocate(&job->core, MPI_BLOCK, 1);
    part->positions = norma_core_allocate(&job->core, part->own + part->others, size);
    int failed = block && part->positions && rows ? 0 : fail_memory(job);
    for (size_t v = 0; v < part->own && !failed;) {
        const size_t some = part->own - v < rows ? part->own - v : rows;
        failed =
            norma_mpi_read(job, layout->vertex_begin + (part->first + v) * row, block, some * row);
        for (size_t i = 0; i < some && !failed; i++)
            decode_row(layout, block + i * row, part->doubles, part->positions + (v + i) * size);
        v += some;
    }
    norma_core_release(&job->core, block, MPI_BLOCK, 1);
    return failed;
}

/* ---- fetching others */

static int owner_of(const mpi_job *job, uint64_t vertices, uint64_t vertex) {
    int rank = (int)((double)vertex / (double)vertices * job->call.ranks);
    while (rank > 0 && norma_mpi_share_of(job, vertices, rank) > vertex) rank--;
    while (norma_mpi_share_of(job, vertices, rank + 1) <= vertex) rank++;
    return rank;
}

typedef struct fetch {
    mpi_job *job;
    const ply_part *part;
    uint64_t vertices;
    size_t begin, end; /* others of this round, ascending: so by owners */
} fetch;

static norma_result list_wanted(const fetch *f, mpi_lists *out) {
    const core_call *core = &f->job->core;
    const size_t ranks = (size_t)f->job->call.ranks;
    const uint64_t *others = f->part->vertex_ids + f->part->own;
    uint64_t *room = norma_core_allocate(core, ranks, sizeof *room);
    if (!room) return NORMA_ERROR_MEMORY;
    memset(room, 0, ranks * sizeof *room);
    for (size_t i = f->begin; i < f->end; i++) room[owner_of(f->job, f->vertices, others[i])]++;
    const norma_result result = norma_mpi_lists_open(&f->job->call, room, sizeof(uint32_t), out);
    for (size_t i = f->begin; i < f->end && result == NORMA_OK; i++) {
        const uint32_t vertex = (uint32_t)others[i];
        memcpy(norma_mpi_lists_add(out, owner_of(f->job, f->vertices, vertex)), &vertex,
            sizeof vertex);
    }
    norma_core_release(core, room, ranks, sizeof *room);
    return result;
}

static norma_result list_positions(const fetch *f, const mpi_lists *in, mpi_lists *answers) {
    const size_t size = norma_mpi_position_size(f->part),
                 count = norma_mpi_lists_total(&f->job->call, in);
    const norma_result result = norma_mpi_lists_like(&f->job->call, in, size, answers);
    for (size_t i = 0; i < count && result == NORMA_OK; i++) {
        uint32_t vertex;
        memcpy(&vertex, norma_mpi_record(in, i), sizeof vertex);
        memcpy(norma_mpi_record(answers, i),
            f->part->positions + (size_t)(vertex - f->part->first) * size, size);
    }
    return result;
}

static norma_result fetch_some(const fetch *f) {
    mpi_call *call = &f->job->call;
    const size_t size = norma_mpi_position_size(f->part);
    mpi_lists out = {0}, in = {0}, answers = {0}, back = {0};
    norma_result result = norma_mpi_exchange(call, list_wanted(f, &out), &out, &in);
    if (result == NORMA_OK) {
        norma_result mine = list_positions(f, &in, &answers);
        if (mine == NORMA_OK) mine = norma_mpi_lists_like(call, &out, size, &back);
        result = norma_mpi_agree(call, mine);
    }
    if (result == NORMA_OK) {
        norma_mpi_answer(call, &answers, &back);
        memcpy(f->part->positions + (f->part->own + f->begin) * size, back.bytes,
            (f->end - f->begin) * size);
    }
    norma_mpi_lists_close(call, &in);
    norma_mpi_lists_close(call, &out);
    norma_mpi_lists_close(call, &answers);
    norma_mpi_lists_close(call, &back);
    return result;
}

static norma_result fetch_others(mpi_job *job, uint64_t vertices, const ply_part *part) {
    enum { AT_ONCE = 1 << 16 };
    fetch f = {.job = job, .part = part, .vertices = vertices};
    norma_result result = NORMA_OK;
    const size_t some = part->faces / 2 > AT_ONCE ? part->faces / 2 : AT_ONCE;
    const uint64_t rounds = norma_mpi_largest(&job->call, part->others / some + 1);
    for (uint64_t round = 0; round < rounds && result == NORMA_OK; round++) {
        f.begin = f.end;
        f.end = part->others - f.begin < some ? part->others : f.begin + some;
        result = fetch_some(&f);
    }
    return result;
}

int norma_mpi_fetch_positions(mpi_job *job, const ply_layout *layout, ply_part *part) {
    if (norma_mpi_failed(job, list_vertices(job, part) || read_positions(job, layout, part)))
        return 1;
    for (size_t c = 0; c < part->corners; c++) part->corner[c] = place_of(part, part->corner[c]);
    return norma_mpi_failed_result(job, fetch_others(job, layout->vertices, part));
}
