/* ply_number.c: a vertex with several normals keeps its number for the first of them. For each
 * further one the rank that read the corner it begins with gives the number; who asked for it then
 * tells it to all ranks that read corners of it, and to the one that writes its row. */
#include "mpi/file/ply_number.h"
#include "core/call/sort.h"

typedef struct number_work {
    mpi_job *job;
    const ply_layout *layout;
    uint64_t vertices;
    const ply_near *near;
    ply_split *split;
    size_t count; /* of new vertices */
    ply_part *part;
    ply_creased *creased;
    uint64_t *corners_before; /* of each rank, in the file */
    uint32_t *numbers;        /* of each new vertex; KEEPS: that of its source. Until they are
                                 fetched: the corner of near that it begins with, + 1 */
    uint32_t *sites;          /* of each place the first corner of near that has a normal */
} number_work;

enum { KEEPS = 0 };
static const uint32_t NO_CORNER = UINT32_MAX;
static const uint64_t NO_SITE = UINT64_MAX;

/* ---- corners that new vertices begin with */

/* New vertices are numbered in the order of the corners that they begin with. */
static void find_firsts(number_work *work) {
    const ply_near *near = work->near;
    const uint8_t *reasons = work->split->corner_reasons;
    const size_t faces = near->face_begins[work->job->call.ranks],
                 corners = norma_mpi_corner_begin(&near->part, faces);
    size_t next = 0;
    for (size_t c = 0; c < corners; c++) {
        const uint32_t place = near->part.corner[c];
        if (!norma_mpi_is_mine(near, place)) continue;
        if (work->split->corners[c] == next) {
            if (work->numbers[next] != KEEPS) work->numbers[next] = (uint32_t)c + 1;
            next++;
        }
        if (work->sites[place] == NO_CORNER && !(reasons && reasons[c]))
            work->sites[place] = (uint32_t)c;
    }
}

/* Which of them are added: numbers are not known yet. */
static norma_result mark_added(number_work *work) {
    const core_call *core = &work->job->core;
    const size_t places = norma_mpi_places(work->near);
    uint8_t *taken = norma_core_allocate(core, places, 1);
    if (!taken) return NORMA_ERROR_MEMORY;
    memset(taken, 0, places);
    for (size_t i = 0; i < places; i++) work->sites[i] = NO_CORNER;
    for (size_t k = 0; k < work->split->count; k++) {
        const uint32_t place = work->split->sources[k];
        work->numbers[k] = taken[place] ? UINT32_MAX : KEEPS;
        taken[place] = 1;
    }
    norma_core_release(core, taken, places, 1);
    find_firsts(work);
    return NORMA_OK;
}

/* ---- numbers */

static int reader_of(const number_work *work, size_t corner, uint32_t *origin) {
    const ply_near *near = work->near;
    const size_t faces = near->part.faces;
    size_t low = 0, high = faces;
    int rank = 0;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (norma_mpi_corner_begin(&near->part, middle) <= corner)
            low = middle;
        else
            high = middle;
    }
    while (near->face_begins[rank + 1] <= low) rank++;
    *origin = near->origins[low] + (uint32_t)(corner - norma_mpi_corner_begin(&near->part, low));
    return rank;
}

/* Room for each added vertex at the rank that read its first corner, or these corners. */
static norma_result list_firsts(const number_work *work, mpi_lists *out) {
    const mpi_call *call = &work->job->call;
    const size_t ranks = (size_t)call->ranks;
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    norma_result result = room ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (room) memset(room, 0, ranks * sizeof *room);
    for (int pass = 0; pass < 2 && result == NORMA_OK; pass++) {
        if (pass) result = norma_mpi_lists_open(call, room, sizeof(uint32_t), out);
        for (size_t k = 0; k < work->split->count && result == NORMA_OK; k++) {
            uint32_t origin;
            if (work->numbers[k] == KEEPS) continue;
            const int rank = reader_of(work, work->numbers[k] - 1, &origin);
            if (pass)
                memcpy(norma_mpi_lists_add(out, rank), &origin, sizeof origin);
            else
                room[rank]++;
        }
    }
    norma_core_release(call->core, room, ranks, sizeof *room);
    return result;
}

static uint32_t place_among(const uint64_t *sorted, size_t count, uint64_t number) {
    size_t low = 0, high = count;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (sorted[middle] <= number)
            low = middle;
        else
            high = middle;
    }
    return (uint32_t)low;
}

/* sorted: the corners here that begin a vertex. */
static norma_result sort_firsts(const mpi_call *call, const mpi_lists *in, uint64_t **sorted) {
    const size_t count = norma_mpi_lists_total(call, in);
    *sorted = norma_core_allocate(call->core, count, sizeof **sorted);
    if (!*sorted) return NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        uint32_t corner;
        memcpy(&corner, norma_mpi_record(in, i), sizeof corner);
        (*sorted)[i] = corner;
    }
    norma_core_sort_numbers(*sorted, count);
    return NORMA_OK;
}

/* Collective: the numbers of those that came. */
static norma_result answer_firsts(number_work *work, const mpi_lists *in, mpi_lists *answers) {
    const mpi_call *call = &work->job->call;
    const size_t count = norma_mpi_lists_total(call, in);
    uint64_t *sorted = NULL;
    const uint64_t before = norma_mpi_sum_before(call, count) + work->vertices;
    work->creased->added.all = norma_mpi_sum(call, count);
    norma_result result = sort_firsts(call, in, &sorted);
    if (work->vertices + work->creased->added.all > UINT32_MAX - 1) result = NORMA_ERROR_OVERFLOW;
    if (result == NORMA_OK) result = norma_mpi_lists_like(call, in, sizeof(uint32_t), answers);
    for (size_t i = 0; i < count && result == NORMA_OK; i++) {
        uint32_t corner;
        memcpy(&corner, norma_mpi_record(in, i), sizeof corner);
        const uint32_t number = (uint32_t)before + place_among(sorted, count, corner);
        memcpy(norma_mpi_record(answers, i), &number, sizeof number);
    }
    norma_core_release(call->core, sorted, count, sizeof *sorted);
    return result;
}

static norma_result read_numbers(number_work *work, const mpi_lists *back) {
    const mpi_call *call = &work->job->call;
    const size_t ranks = (size_t)call->ranks;
    int *next = norma_core_allocate(call->core, ranks, sizeof *next);
    if (!next) return NORMA_ERROR_MEMORY;
    memcpy(next, back->starts, ranks * sizeof *next);
    for (size_t k = 0; k < work->split->count; k++) {
        uint32_t origin;
        if (work->numbers[k] == KEEPS) continue;
        const int rank = reader_of(work, work->numbers[k] - 1, &origin);
        memcpy(
            &work->numbers[k], norma_mpi_record(back, (size_t)next[rank]++), sizeof *work->numbers);
    }
    norma_core_release(call->core, next, ranks, sizeof *next);
    return NORMA_OK;
}

static norma_result fetch_numbers(number_work *work) {
    mpi_call *call = &work->job->call;
    mpi_lists out = {0}, in = {0}, answers = {0}, back = {0};
    norma_result result = norma_mpi_exchange(call, list_firsts(work, &out), &out, &in);
    if (result == NORMA_OK) {
        norma_result mine = answer_firsts(work, &in, &answers);
        if (mine == NORMA_OK) mine = norma_mpi_lists_like(call, &out, sizeof(uint32_t), &back);
        result = norma_mpi_agree(call, mine);
    }
    if (result == NORMA_OK) {
        norma_mpi_answer(call, &answers, &back);
        result = norma_mpi_agree(call, read_numbers(work, &back));
    }
    norma_mpi_lists_close(call, &in);
    norma_mpi_lists_close(call, &out);
    norma_mpi_lists_close(call, &answers);
    norma_mpi_lists_close(call, &back);
    return result;
}

/* ---- handing over: records that are counted, listed and taken in one way */

typedef struct handing {
    size_t size;
    int (*record)(const number_work *work, size_t index, unsigned char *record); /* -1: none */
    void (*take)(number_work *work, const unsigned char *record);
    size_t count;
} handing;

enum { MOST_RECORD = 40 };

/* What is for this rank itself is taken at once. */
static norma_result list_records(number_work *work, const handing *h, mpi_lists *out) {
    const mpi_call *call = &work->job->call;
    const size_t ranks = (size_t)call->ranks;
    unsigned char record[MOST_RECORD];
    uint64_t *room = norma_core_allocate(call->core, ranks, sizeof *room);
    norma_result result = room ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (room) memset(room, 0, ranks * sizeof *room);
    for (int pass = 0; pass < 2 && result == NORMA_OK; pass++) {
        if (pass) result = norma_mpi_lists_open(call, room, h->size, out);
        for (size_t i = 0; i < h->count && result == NORMA_OK; i++) {
            const int rank = h->record(work, i, record);
            if (rank < 0) continue;
            if (rank == call->rank) {
                if (pass) h->take(work, record);
            } else if (pass) {
                memcpy(norma_mpi_lists_add(out, rank), record, h->size);
            } else {
                room[rank]++;
            }
        }
    }
    norma_core_release(call->core, room, ranks, sizeof *room);
    return result;
}

static norma_result hand_over(number_work *work, const handing *h) {
    mpi_call *call = &work->job->call;
    mpi_lists out = {0}, in = {0};
    const norma_result result = norma_mpi_exchange(call, list_records(work, h, &out), &out, &in);
    norma_mpi_lists_close(call, &out);
    if (result != NORMA_OK) return result;
    const size_t count = norma_mpi_lists_total(call, &in);
    for (size_t i = 0; i < count; i++) h->take(work, norma_mpi_record(&in, i));
    norma_mpi_lists_close(call, &in);
    return NORMA_OK;
}

/* ---- new numbers, to who read the corners */

typedef struct corner_number {
    uint32_t corner, number;
} corner_number;

static int record_corner(const number_work *work, size_t corner, unsigned char *record) {
    const ply_near *near = work->near;
    corner_number c;
    if (!norma_mpi_is_mine(near, near->part.corner[corner])) return -1;
    c.number = work->numbers[work->split->corners[corner]];
    if (c.number == KEEPS) return -1;
    const int rank = reader_of(work, corner, &c.corner);
    memcpy(record, &c, sizeof c);
    return rank;
}

static void take_corner(number_work *work, const unsigned char *record) {
    corner_number c;
    memcpy(&c, record, sizeof c);
    work->part->corner[c.corner] = c.number;
}

/* ---- normals, to who has the vertices */

typedef struct vertex_normal {
    uint64_t site;
    uint32_t vertex, reason;
    float normal[3];
} vertex_normal;

/* In the whole file. */
static uint64_t site_of(const number_work *work, uint32_t place) {
    uint32_t origin;
    if (work->sites[place] == NO_CORNER) return NO_SITE;
    const int reader = reader_of(work, work->sites[place], &origin);
    return work->corners_before[reader] + origin;
}

static int record_normal(const number_work *work, size_t k, unsigned char *record) {
    const uint32_t place = work->split->sources[k];
    vertex_normal v = {.site = site_of(work, place),
        .vertex = (uint32_t)work->near->part.vertex_ids[place],
        .reason = work->split->reasons[k]};
    if (work->numbers[k] != KEEPS) return -1;
    memcpy(v.normal, work->split->normals + 3 * k, sizeof v.normal);
    memcpy(record, &v, sizeof v);
    return norma_mpi_owner_of(work->job, work->vertices, v.vertex);
}

static void take_normal(number_work *work, const unsigned char *record) {
    vertex_normal v;
    memcpy(&v, record, sizeof v);
    const size_t own = (size_t)(v.vertex - work->part->first);
    memcpy(work->creased->normals + 3 * own, v.normal, sizeof v.normal);
    work->creased->reasons[own] = (uint8_t)v.reason;
    work->creased->sites[own] = v.site;
}

/* ---- added vertices, to who writes their rows */

typedef struct added_vertex {
    uint32_t number, source;
    float normal[3];
} added_vertex;

static int record_added(const number_work *work, size_t k, unsigned char *record) {
    const uint64_t all = work->creased->added.all;
    added_vertex a = {work->numbers[k] - (uint32_t)work->vertices,
        (uint32_t)work->near->part.vertex_ids[work->split->sources[k]], {0, 0, 0}};
    if (work->numbers[k] == KEEPS) return -1;
    memcpy(a.normal, work->split->normals + 3 * k, sizeof a.normal);
    memcpy(record, &a, sizeof a);
    return norma_mpi_owner_of(work->job, all, a.number);
}

static void take_added(number_work *work, const unsigned char *record) {
    added_vertex a;
    memcpy(&a, record, sizeof a);
    const size_t at = (size_t)(a.number - work->creased->added.first);
    work->creased->added.sources[at] = a.source;
    memcpy(work->creased->added.normals + 3 * at, a.normal, sizeof a.normal);
}

static norma_result open_added(number_work *work) {
    const core_call *core = &work->job->core;
    ply_added *a = &work->creased->added;
    const int rank = work->job->call.rank;
    a->first = norma_mpi_share_of(work->job, a->all, rank);
    a->count = (size_t)(norma_mpi_share_of(work->job, a->all, rank + 1) - a->first);
    a->sources = norma_core_allocate(core, a->count, sizeof *a->sources);
    a->normals = norma_core_allocate(core, a->count, 3 * sizeof *a->normals);
    return a->sources && a->normals ? NORMA_OK : NORMA_ERROR_MEMORY;
}

/* ---- all */

static norma_result open_work(number_work *work) {
    const core_call *core = &work->job->core;
    const size_t ranks = (size_t)work->job->call.ranks, own = work->part->own;
    ply_creased *c = work->creased;
    work->corners_before = norma_core_allocate(core, ranks, sizeof *work->corners_before);
    work->numbers = norma_core_allocate(core, work->split->count, sizeof *work->numbers);
    work->sites = norma_core_allocate(core, norma_mpi_places(work->near), sizeof *work->sites);
    c->own = own;
    c->normals = norma_core_allocate(core, own, 3 * sizeof *c->normals);
    c->reasons = norma_core_allocate(core, own, 1);
    c->sites = norma_core_allocate(core, own, sizeof *c->sites);
    if (!work->corners_before || !work->numbers || !work->sites || !c->normals || !c->reasons ||
        !c->sites)
        return NORMA_ERROR_MEMORY;
    memset(c->normals, 0, own * 3 * sizeof *c->normals);
    memset(c->reasons, NORMA_REASON_UNREFERENCED, own);
    for (size_t v = 0; v < own; v++) c->sites[v] = NO_SITE;
    return NORMA_OK;
}

static void close_sites(number_work *work) {
    norma_core_release(
        &work->job->core, work->sites, norma_mpi_places(work->near), sizeof *work->sites);
    work->sites = NULL;
}

static void close_work(number_work *work) {
    const core_call *core = &work->job->core;
    const size_t ranks = (size_t)work->job->call.ranks, count = work->count;
    close_sites(work);
    norma_core_release(core, work->corners_before, ranks, sizeof *work->corners_before);
    norma_core_release(core, work->numbers, count, sizeof *work->numbers);
}

static norma_result number_all(number_work *work) {
    const mpi_call *call = &work->job->call;
    const handing normals = {sizeof(vertex_normal), record_normal, take_normal, work->split->count},
                  added = {sizeof(added_vertex), record_added, take_added, work->split->count};
    uint64_t mine = norma_mpi_sum_before(call, work->part->corners);
    MPI_Allgather(&mine, 1, MPI_UINT64_T, work->corners_before, 1, MPI_UINT64_T, call->comm);
    norma_result result = norma_mpi_agree(call, mark_added(work));
    if (result == NORMA_OK) result = fetch_numbers(work);
    if (result == NORMA_OK) result = hand_over(work, &normals);
    if (result != NORMA_OK || !work->creased->added.all) return result;
    result = norma_mpi_agree(call, open_added(work));
    return result == NORMA_OK ? hand_over(work, &added) : result;
}

/* Collective. The corners' numbers of the file have been dropped while memory was needed. */
static int renumber_corners(number_work *work) {
    mpi_job *job = work->job;
    const size_t corners = work->split->count ? work->near->part.corners : 0;
    const handing numbers = {sizeof(corner_number), record_corner, take_corner, corners};
    norma_mpi_release_vertices(job, work->split);
    close_sites(work);
    if (norma_mpi_failed(job, norma_mpi_read_corners(job, work->layout, work->part))) return 1;
    return norma_mpi_failed_result(job, hand_over(work, &numbers));
}

int norma_mpi_number_vertices(mpi_job *job, const ply_layout *layout, const ply_near *near,
    ply_split *split, ply_part *part, ply_creased *creased) {
    number_work work = {.job = job,
        .layout = layout,
        .vertices = layout->vertices,
        .near = near,
        .split = split,
        .part = part,
        .creased = creased,
        .count = split->count};
    *creased = (ply_creased){0};
    norma_result result = norma_mpi_agree(&job->call, open_work(&work));
    if (result == NORMA_OK) result = number_all(&work);
    int failed = norma_mpi_failed_result(job, result);
    if (!failed && creased->added.all) failed = renumber_corners(&work);
    close_work(&work);
    return failed;
}

void norma_mpi_close_creased(mpi_job *job, ply_creased *creased) {
    const core_call *core = &job->core;
    const size_t own = creased->own, added = creased->added.count;
    norma_core_release(core, creased->normals, own, 3 * sizeof *creased->normals);
    norma_core_release(core, creased->reasons, own, 1);
    norma_core_release(core, creased->sites, own, sizeof *creased->sites);
    norma_core_release(core, creased->added.sources, added, sizeof *creased->added.sources);
    norma_core_release(core, creased->added.normals, added, 3 * sizeof *creased->added.normals);
    *creased = (ply_creased){0};
}
