/* vertex_normals.c: vertex normals over ranks, and what has none counted and filled. */
#include "mpi/vertex/vertex.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"
#include <norma/mpi.h>

/* ---- A vertex without a normal is known to each rank that has it. Its number goes to
 * its home, which counts each once. */

enum { MISSING_SIZE = sizeof(uint64_t) + 1 };

typedef struct missing_vertices {
    const mpi_call *call;
    const uint64_t *ids;
    const uint8_t *reasons;
} missing_vertices;

static int home_of_missing(const void *context, size_t v) {
    const missing_vertices *missing = context;
    return missing->reasons[v] ? norma_mpi_home_of_number(missing->call, missing->ids[v]) : -1;
}

static void write_missing_vertex(const void *context, size_t v, unsigned char *record) {
    const missing_vertices *missing = context;
    memcpy(record, &missing->ids[v], sizeof missing->ids[v]);
    record[sizeof(uint64_t)] = missing->reasons[v];
}

static int record_less(const void *a, const void *b) {
    uint64_t one, other;
    memcpy(&one, a, sizeof one);
    memcpy(&other, b, sizeof other);
    return one < other;
}

static void count_numbers(const mpi_call *call, const mpi_lists *in, core_tally *tally) {
    const size_t count = norma_mpi_lists_total(call, in);
    uint64_t number, before = 0;
    norma_core_sort(in->bytes, count, MISSING_SIZE, record_less);
    for (size_t i = 0; i < count; ++i) {
        const unsigned char *record = norma_mpi_record(in, i);
        memcpy(&number, record, sizeof number);
        if (!i || number != before) norma_core_tally(tally, record[sizeof number], (size_t)number);
        before = number;
    }
}

/* Collective. reasons: of each position here. Each number counts once, on however many ranks. */
static norma_result mpi_count_missing(
    mpi_call *call, const mpi_part *part, const uint8_t *reasons, core_tally *tally) {
    const missing_vertices missing = {call, part->vertex_ids, reasons};
    const mpi_listing listing = {
        part->positions, MISSING_SIZE, home_of_missing, write_missing_vertex, &missing};
    mpi_lists out = {0}, in = {0};
    uint64_t any = 0;
    for (size_t v = 0; v < part->positions; ++v) any |= reasons[v];
    if (!norma_mpi_largest(call, any)) return NORMA_OK;
    const norma_result result =
        norma_mpi_exchange(call, MPI_OTHERS, norma_mpi_list(call, &listing, &out), &out, &in);
    if (!result) count_numbers(call, &in, tally);
    norma_mpi_lists_close(call, &out);
    norma_mpi_lists_close(call, &in);
    return result;
}

/* ---- the whole mesh */

void norma_mpi_add_tallies(const mpi_call *call, core_tally *tally) {
    norma_count *const counts[4] = {
        &tally->non_finite, &tally->unreferenced, &tally->cancelled, &tally->degenerate};
    uint64_t sums[4];
    for (size_t i = 0; i < 4; ++i) sums[i] = counts[i]->count;
    norma_mpi_reduce(call, sums, 4, MPI_UINT64_T, MPI_SUM);
    for (size_t i = 0; i < 4; ++i) {
        if (!sums[i]) continue;
        const uint64_t first =
            norma_mpi_least(call, counts[i]->count ? counts[i]->first : UINT64_MAX);
        *counts[i] = (norma_count){(size_t)sums[i], (size_t)first};
    }
}

/* ---- Some of those without a normal at a time are made known to all ranks; each finds
 * the nearest that it has, and the nearest of these is taken: ties go to the lower number. */

enum { FEW_QUERIES = 48, QUERIES_AT_ONCE = 1 << 14 };

typedef struct found {
    core_segment to; /* from the point that asks */
    uint64_t id;     /* UINT64_MAX: nobody has a normal */
    float normal[3], unused;
} found;

typedef struct sites {
    mpi_call *call;
    const mpi_part *part;
    core_mesh mesh;    /* positions alone */
    uint32_t *sites;   /* those with a normal, by ascending number */
    uint32_t *rank_of; /* of each position, its place among them; NULL: they ascend as they are */
    size_t count;
    core_kdtree tree;
    int planted;
} sites;

/* ---- what is here */

static norma_result mpi_collect(sites *s, const uint8_t *reasons) {
    const core_call *core = s->call->core;
    const size_t positions = s->part->positions;
    mpi_face_order order;
    s->sites = norma_core_allocate(core, positions, sizeof *s->sites);
    if (!s->sites) return NORMA_ERROR_MEMORY;
    norma_result result = norma_mpi_order_faces(core, s->part->vertex_ids, positions, &order);
    if (!result && order.order &&
        !(s->rank_of = norma_core_allocate(core, positions, sizeof *s->rank_of)))
        result = NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < positions && !result; ++i) {
        const size_t v = norma_mpi_face(&order, i);
        if (s->rank_of) s->rank_of[v] = (uint32_t)i;
        if (!reasons[v]) s->sites[s->count++] = (uint32_t)v;
    }
    norma_mpi_order_close(core, &order);
    return result;
}

static norma_result plant(sites *s, uint64_t queries) {
    if (queries <= FEW_QUERIES || !s->count) return NORMA_OK;
    const norma_result result =
        norma_core_kdtree_build(s->call->core, &s->mesh, s->rank_of, s->sites, s->count, &s->tree);
    s->planted = !result;
    return result;
}

static void close_sites(sites *s) {
    const core_call *core = s->call->core;
    const size_t positions = s->part->positions;
    if (s->planted) norma_core_kdtree_release(core, &s->tree);
    norma_core_release(core, s->sites, positions, sizeof *s->sites);
    norma_core_release(core, s->rank_of, positions, sizeof *s->rank_of);
}

/* ---- the nearest here */

static void mpi_reach(const sites *s, uint32_t v, core_segment *to) {
    norma_core_position(&s->mesh, v, to->to);
    norma_core_measure_segment(to);
}

/* Sites are in ascending number, so the first of the nearest is that of the least. */
static uint32_t mpi_look_at_every_site(const sites *s, const double point[3]) {
    uint32_t best = s->sites[0];
    core_segment least, to;
    memcpy(to.from, point, sizeof to.from);
    mpi_reach(s, best, &to);
    least = to;
    for (size_t i = 1; i < s->count; ++i) {
        mpi_reach(s, s->sites[i], &to);
        if (norma_core_compare_lengths(&to, &least) >= 0) continue;
        least = to;
        best = s->sites[i];
    }
    return best;
}

static uint32_t first_site(const sites *s) {
    uint32_t first = s->sites[0];
    for (size_t i = 1; i < s->count && s->planted; ++i) { /* the tree has reordered them */
        const uint64_t *ids = s->part->vertex_ids;
        if (ids[s->sites[i]] < ids[first]) first = s->sites[i];
    }
    return first;
}

/* For a point that is not finite: the first of all, as far from it as any. */
static found find_here(const sites *s, uint32_t first, const double point[3]) {
    found f = {.id = UINT64_MAX};
    if (!s->count) return f;
    const int finite = norma_core_finite(point);
    const uint32_t v = !finite      ? first
                       : s->planted ? norma_core_kdtree_nearest(&s->tree, point)
                                    : mpi_look_at_every_site(s, point);
    memcpy(f.to.from, point, sizeof f.to.from);
    if (finite)
        mpi_reach(s, v, &f.to);
    else
        memset(&f.to, 0, sizeof f.to);
    f.id = s->part->vertex_ids[v];
    memcpy(f.normal, s->part->output.normals + v * s->part->output.stride, sizeof f.normal);
    return f;
}

static int is_nearer(const found *a, const found *b) {
    if (a->id == UINT64_MAX || b->id == UINT64_MAX) return a->id < b->id;
    const int longer = norma_core_compare_lengths(&a->to, &b->to);
    return longer < 0 || (!longer && a->id < b->id);
}

/* As MPI_User_function asks for it. */
static void keep_nearer(void *in, void *inout, int *count, MPI_Datatype *type) {
    const found *one = in;
    found *other = inout;
    (void)type;
    for (int i = 0; i < *count; ++i)
        if (is_nearer(&one[i], &other[i])) other[i] = one[i];
}

/* ---- some queries of all ranks */

typedef struct asking {
    sites *sites;
    const uint8_t *reasons;
    size_t next;                  /* the first position that has not asked */
    double (*mine)[3], (*all)[3]; /* points; room for QUERIES_AT_ONCE of this rank, of all ranks */
    found *found;
    uint32_t *askers; /* the positions of mine */
    int *counts, *starts;
    uint32_t first;
    MPI_Datatype query_type, found_type;
    MPI_Op nearer;
} asking;

static int gather_mine(asking *a, int most) {
    int count = 0;
    for (; a->next < a->sites->part->positions && count < most; ++a->next) {
        if (!a->reasons[a->next]) continue;
        a->askers[count] = (uint32_t)a->next;
        norma_core_position(&a->sites->mesh, (uint32_t)a->next, a->mine[count++]);
    }
    return count;
}

static int place_counts(const asking *a) {
    int sum = 0;
    for (int r = 0; r < a->sites->call->ranks; ++r) {
        a->starts[r] = sum;
        sum += a->counts[r];
    }
    return sum;
}

/* Returns how many were asked by all. */
static int ask_some(asking *a) {
    const mpi_call *call = a->sites->call;
    const core_output *output = &a->sites->part->output;
    const int mine = gather_mine(a, QUERIES_AT_ONCE / call->ranks + 1);
    MPI_Allgather(&mine, 1, MPI_INT, a->counts, 1, MPI_INT, call->comm);
    const int all = place_counts(a);
    if (!all) return 0;
    a->sites->call->sent[MPI_OTHERS] +=
        (uint64_t)mine * sizeof *a->mine * (uint64_t)(call->ranks - 1);
    MPI_Allgatherv(
        a->mine, mine, a->query_type, a->all, a->counts, a->starts, a->query_type, call->comm);
    for (int i = 0; i < all; ++i) a->found[i] = find_here(a->sites, a->first, a->all[i]);
    MPI_Allreduce(MPI_IN_PLACE, a->found, all, a->found_type, a->nearer, call->comm);
    for (int i = 0; i < mine; ++i) {
        const found *f = &a->found[a->starts[call->rank] + i];
        const float none[3] = {0, 0, 0};
        norma_core_write_normal(output, a->askers[i], f->id == UINT64_MAX ? none : f->normal);
    }
    return all;
}

static norma_result open_asking(asking *a, size_t room) {
    const core_call *core = a->sites->call->core;
    const size_t ranks = (size_t)a->sites->call->ranks;
    a->mine = norma_core_allocate(core, room, sizeof *a->mine);
    a->all = norma_core_allocate(core, room, sizeof *a->all);
    a->found = norma_core_allocate(core, room, sizeof *a->found);
    a->askers = norma_core_allocate(core, room, sizeof *a->askers);
    a->counts = norma_core_allocate(core, ranks, sizeof *a->counts);
    a->starts = norma_core_allocate(core, ranks, sizeof *a->starts);
    return a->mine && a->all && a->found && a->askers && a->counts && a->starts
               ? NORMA_OK
               : NORMA_ERROR_MEMORY;
}

static void close_asking(asking *a, size_t room) {
    const core_call *core = a->sites->call->core;
    const size_t ranks = (size_t)a->sites->call->ranks;
    norma_core_release(core, a->mine, room, sizeof *a->mine);
    norma_core_release(core, a->all, room, sizeof *a->all);
    norma_core_release(core, a->found, room, sizeof *a->found);
    norma_core_release(core, a->askers, room, sizeof *a->askers);
    norma_core_release(core, a->counts, ranks, sizeof *a->counts);
    norma_core_release(core, a->starts, ranks, sizeof *a->starts);
}

static void ask_all(asking *a) {
    MPI_Type_contiguous((int)sizeof *a->all, MPI_BYTE, &a->query_type);
    MPI_Type_contiguous((int)sizeof(found), MPI_BYTE, &a->found_type);
    MPI_Type_commit(&a->query_type);
    MPI_Type_commit(&a->found_type);
    MPI_Op_create(keep_nearer, 1, &a->nearer);
    a->first = a->sites->count ? first_site(a->sites) : 0;
    while (ask_some(a)) continue;
    MPI_Op_free(&a->nearer);
    MPI_Type_free(&a->query_type);
    MPI_Type_free(&a->found_type);
}

norma_result norma_mpi_fill_nearest(mpi_call *call, const mpi_part *part, const uint8_t *reasons) {
    sites s = {.call = call, .part = part, .mesh = part->prepared.mesh};
    uint64_t mine = 0;
    for (size_t v = 0; v < part->positions; ++v) mine += reasons[v] != 0;
    const uint64_t queries = norma_mpi_sum(call, mine);
    if (!queries) return NORMA_OK;
    asking a = {.sites = &s, .reasons = reasons};
    const size_t room = (size_t)QUERIES_AT_ONCE + (size_t)call->ranks;
    norma_result result = mpi_collect(&s, reasons);
    if (!result) result = plant(&s, queries);
    if (!result) result = open_asking(&a, room);
    result = norma_mpi_agree(call, result);
    if (!result) ask_all(&a);
    close_asking(&a, room);
    close_sites(&s);
    return result;
}

/* ---- Norma_mpi_vertex_normals. Which positions are shared, their sums, and normals
 * handed out; where the sum of a position cancels, once more over the corners of each vertex alone;
 * then those that have no normal. */

typedef struct vertex_work {
    mpi_call *call;
    mpi_part *part;
    uint8_t *take_part; /* of each position: MPI_ABSENT, ...; until it is known who shares it */
    uint8_t *reasons;   /* of each position */
    core_tally tally;
    int once_more; /* sums of positions are behind */
} vertex_work;

static void forget_part(vertex_work *work) {
    norma_core_release(work->call->core, work->take_part, work->part->positions, 1);
    work->take_part = NULL;
}

/* ---- one pass of sums */

static void receive_normal(void *context, size_t v, int reason, const float normal[3]) {
    const vertex_work *work = context;
    work->reasons[v] = (uint8_t)(work->once_more && reason ? NORMA_REASON_CANCELLED : reason);
    if (!reason) norma_core_write_normal(&work->part->output, v, normal);
}

static norma_result sum_and_hand_out(
    vertex_work *work, const mpi_keys *keys, const uint32_t *merge, norma_count *degenerate) {
    mpi_call *call = work->call;
    const size_t budget = work->part->budget;
    const int lend = call->core->options.weight != NORMA_WEIGHT_VISIBLE;
    mpi_sharing sharing;
    norma_result result = norma_mpi_share(call, keys, work->take_part, lend, budget, &sharing);
    forget_part(work);
    if (result) return result;
    mpi_sums sums = {.prepared = &work->part->prepared,
        .faces = &work->part->faces,
        .merge = merge,
        .sharing = &sharing,
        .numbered = work->part->numbered,
        .degenerate = degenerate};
    result = norma_mpi_sum_all(call, budget, &sums);
    if (!result) {
        result = norma_mpi_hand_out(call, &sums, budget, receive_normal, work);
        norma_mpi_sums_close(call, &sums);
    }
    norma_mpi_sharing_close(call, &sharing);
    return result;
}

static uint32_t merged(const uint32_t *merge, size_t v) { return merge ? merge[v] : (uint32_t)v; }

/* Collective. Those that have no normal for this reason, each by the one that stands for it. */
static norma_result take_part(vertex_work *work, const uint32_t *merge, int reason) {
    const core_mesh *mesh = &work->part->prepared.mesh;
    work->take_part = norma_core_allocate(work->call->core, work->part->positions, 1);
    const norma_result result =
        norma_mpi_agree(work->call, work->take_part ? NORMA_OK : NORMA_ERROR_MEMORY);
    if (result) return result;
    memset(work->take_part, MPI_ABSENT, work->part->positions);
    for (size_t v = 0; v < work->part->positions; ++v)
        if (work->reasons[v] == reason) work->take_part[merged(merge, v)] = MPI_LISTENS;
    for (size_t c = 0; c < mesh->corner_count; ++c) {
        const uint32_t v = norma_core_corner(mesh, c);
        if (work->reasons[v] == reason) work->take_part[merged(merge, v)] = MPI_VOTES;
    }
    return NORMA_OK;
}

/* ---- by position */

/* A position that is not finite has no votes, and is equal to nothing that has. */
static void mpi_judge_positions(const vertex_work *work) {
    const core_mesh *mesh = &work->part->prepared.mesh;
    for (size_t v = 0; v < work->part->positions; ++v) {
        double p[3];
        norma_core_position(mesh, (uint32_t)v, p);
        work->reasons[v] =
            norma_core_finite(p) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    }
}

static norma_result sum_positions(vertex_work *work) {
    const mpi_part *part = work->part;
    const uint32_t *weld = part->prepared.mesh.weld;
    const mpi_keys keys = {&part->prepared.mesh,
        part->groups                                        ? part->groups
        : work->call->core->options.weld == NORMA_WELD_NONE ? part->vertex_ids
                                                            : NULL,
        part->doubles};
    mpi_judge_positions(work);
    const norma_result result = take_part(work, weld, NORMA_REASON_UNREFERENCED);
    if (result) return result;
    norma_core_stage(work->call->core, 0.2, 0.8);
    return sum_and_hand_out(work, &keys, weld, &work->tally.degenerate);
}

/* ---- where they cancel: by the number of the vertex */

static norma_result mpi_sum_own(vertex_work *work) {
    const mpi_part *part = work->part;
    uint32_t *same = NULL;
    uint64_t cancelled = 0;
    for (size_t v = 0; v < part->positions; ++v)
        cancelled += work->reasons[v] == NORMA_REASON_CANCELLED;
    if (work->call->core->options.weld == NORMA_WELD_NONE ||
        !norma_mpi_largest(work->call, cancelled))
        return NORMA_OK;
    norma_result result = norma_mpi_agree(work->call,
        norma_mpi_weld_numbers(work->call->core, part->vertex_ids, part->positions, &same));
    if (!result) {
        const mpi_keys keys = {&part->prepared.mesh, part->vertex_ids, part->doubles};
        result = take_part(work, same, NORMA_REASON_CANCELLED);
        work->once_more = 1;
        if (!result) result = sum_and_hand_out(work, &keys, same, NULL);
    }
    norma_core_release(work->call->core, same, part->positions, sizeof *same);
    return result;
}

/* ---- all */

static void write_missing(const vertex_work *work) {
    const float none[3] = {0, 0, 0};
    core_tally here = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    for (size_t v = 0; v < work->part->positions; ++v) {
        if (work->reasons[v])
            norma_core_write_element(&work->part->output, v, work->reasons[v], none, &here);
        else if (work->part->output.reasons)
            work->part->output.reasons[v] = NORMA_REASON_NONE;
    }
}

static norma_result mpi_open_work(vertex_work *work) {
    const core_call *core = work->call->core;
    work->reasons = norma_core_allocate(core, work->part->positions, 1);
    return work->reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
}

static norma_result mpi_run(vertex_work *work, norma_report *report) {
    mpi_call *call = work->call;
    norma_result result = norma_mpi_agree(call, mpi_open_work(work));
    if (!result) result = sum_positions(work);
    if (!result) result = mpi_sum_own(work);
    if (!result) result = mpi_count_missing(call, work->part, work->reasons, &work->tally);
    if (!result) {
        write_missing(work);
        if (work->part->output.nearest)
            result = norma_mpi_fill_nearest(call, work->part, work->reasons);
    }
    norma_core_stage(call->core, 1, 1);
    result = norma_mpi_step(call, 1, result);
    if (result) return result;
    norma_mpi_add_tallies(call, &work->tally);
    norma_core_write_report(report, &work->tally, NULL, NULL);
    return NORMA_OK;
}

static norma_result mpi_compute(
    mpi_call *call, norma_result begun, const mpi_input *input, norma_report *report) {
    mpi_part part;
    norma_result result = norma_mpi_open_part(call, begun, input, &part);
    if (result) return result;
    vertex_work work = {.call = call, .part = &part};
    result = mpi_run(&work, report);
    forget_part(&work);
    norma_core_release(call->core, work.reasons, part.positions, 1);
    norma_mpi_close_part(call, &part);
    return result;
}

norma_result norma_mpi_normals_of(MPI_Comm comm, uint64_t *sent, const norma_mesh *part,
    const uint64_t *vertex_ids, const uint64_t *face_ids, const norma_options *options,
    float *normals, size_t capacity, norma_report *report) {
    core_call core;
    mpi_call call;
    const mpi_input input = {part, vertex_ids, face_ids, normals, capacity};
    const norma_result begun = norma_core_begin(&core, options);
    const norma_result result = norma_mpi_begin(&call, comm, &core);
    if (result) return result;
    const norma_result computed = mpi_compute(&call, begun, &input, report);
    for (int i = 0; sent && i < MPI_CARGOS; ++i) sent[i] += call.sent[i];
    norma_mpi_end(&call);
    return computed;
}

norma_result norma_mpi_vertex_normals(MPI_Comm comm, const norma_mesh *part,
    const uint64_t *vertex_ids, const uint64_t *face_ids, const norma_options *options,
    float *normals, size_t capacity, norma_report *report) {
    return norma_mpi_normals_of(
        comm, NULL, part, vertex_ids, face_ids, options, normals, capacity, report);
}
