/* fill_nearest.c: some of those without a normal at a time are made known to all ranks; each finds
 * the nearest that it has, and the nearest of these is taken: ties go to the lower number. */
#include "core/mesh/kdtree.h"
#include "mpi/vertex/missing.h"

enum { FEW_QUERIES = 48, QUERIES_AT_ONCE = 1 << 14 };

typedef struct query {
    double point[3];
} query;

typedef struct found {
    double distance; /* squared; negative: nobody has a normal */
    uint64_t id;
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

static norma_result collect(sites *s, const uint8_t *reasons) {
    const core_call *core = s->call->core;
    const size_t positions = s->part->positions;
    mpi_face_order order;
    s->sites = norma_core_allocate(core, positions, sizeof *s->sites);
    if (!s->sites) return NORMA_ERROR_MEMORY;
    norma_result result = norma_mpi_order_faces(core, s->part->vertex_ids, positions, &order);
    if (result == NORMA_OK && order.order &&
        !(s->rank_of = norma_core_allocate(core, positions, sizeof *s->rank_of)))
        result = NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < positions && result == NORMA_OK; i++) {
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
    s->planted = result == NORMA_OK;
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

static double squared_distance(const sites *s, uint32_t v, const double point[3]) {
    double p[3], sum = 0;
    norma_core_position(&s->mesh, v, p);
    for (int k = 0; k < 3; k++) sum += (p[k] - point[k]) * (p[k] - point[k]);
    return sum;
}

/* Sites are in ascending number, so the first of the nearest is that of the least. */
static uint32_t look_at_every_site(const sites *s, const double point[3]) {
    uint32_t best = s->sites[0];
    double least = squared_distance(s, best, point);
    for (size_t i = 1; i < s->count; i++) {
        const double distance = squared_distance(s, s->sites[i], point);
        if (!(distance < least)) continue;
        least = distance;
        best = s->sites[i];
    }
    return best;
}

static uint32_t first_site(const sites *s) {
    uint32_t first = s->sites[0];
    for (size_t i = 1; i < s->count && s->planted; i++) { /* the tree has reordered them */
        const uint64_t *ids = s->part->vertex_ids;
        if (ids[s->sites[i]] < ids[first]) first = s->sites[i];
    }
    return first;
}

/* For a point that is not finite: the first of all. */
static found find_here(const sites *s, uint32_t first, const query *q) {
    found f = {.distance = -1, .id = UINT64_MAX};
    if (!s->count) return f;
    const int finite = norma_core_finite(q->point);
    const uint32_t v = !finite      ? first
                       : s->planted ? norma_core_kdtree_nearest(&s->tree, q->point)
                                    : look_at_every_site(s, q->point);
    f.distance = finite ? squared_distance(s, v, q->point) : 0;
    f.id = s->part->vertex_ids[v];
    memcpy(f.normal, s->part->output.normals + v * s->part->output.stride, sizeof f.normal);
    return f;
}

static int is_nearer(const found *a, const found *b) {
    if (a->distance < 0 || b->distance < 0) return b->distance < 0 && a->distance >= 0;
    return a->distance < b->distance || (a->distance == b->distance && a->id < b->id);
}

/* As MPI_User_function asks for it. */
static void keep_nearer(void *in, void *inout, int *count, MPI_Datatype *type) {
    const found *one = in;
    found *other = inout;
    (void)type;
    for (int i = 0; i < *count; i++)
        if (is_nearer(&one[i], &other[i])) other[i] = one[i];
}

/* ---- some queries of all ranks */

typedef struct asking {
    sites *sites;
    const uint8_t *reasons;
    size_t next;       /* the first position that has not asked */
    query *mine, *all; /* room for QUERIES_AT_ONCE of this rank, of all ranks */
    found *found;
    uint32_t *askers; /* the positions of mine */
    int *counts, *starts;
    uint32_t first;
    MPI_Datatype query_type, found_type;
    MPI_Op nearer;
} asking;

static int gather_mine(asking *a, int most) {
    int count = 0;
    for (; a->next < a->sites->part->positions && count < most; a->next++) {
        if (!a->reasons[a->next]) continue;
        a->askers[count] = (uint32_t)a->next;
        norma_core_position(&a->sites->mesh, (uint32_t)a->next, a->mine[count++].point);
    }
    return count;
}

static int place_counts(const asking *a) {
    int sum = 0;
    for (int r = 0; r < a->sites->call->ranks; r++) {
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
    MPI_Allgatherv(
        a->mine, mine, a->query_type, a->all, a->counts, a->starts, a->query_type, call->comm);
    for (int i = 0; i < all; i++) a->found[i] = find_here(a->sites, a->first, &a->all[i]);
    MPI_Allreduce(MPI_IN_PLACE, a->found, all, a->found_type, a->nearer, call->comm);
    for (int i = 0; i < mine; i++) {
        const found *f = &a->found[a->starts[call->rank] + i];
        const float none[3] = {0, 0, 0};
        norma_core_write_normal(output, a->askers[i], f->distance < 0 ? none : f->normal);
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
    MPI_Type_contiguous((int)sizeof(query), MPI_BYTE, &a->query_type);
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
    for (size_t v = 0; v < part->positions; v++) mine += reasons[v] != 0;
    const uint64_t queries = norma_mpi_sum(call, mine);
    if (!queries) return NORMA_OK;
    asking a = {.sites = &s, .reasons = reasons};
    const size_t room = (size_t)QUERIES_AT_ONCE + (size_t)call->ranks;
    norma_result result = collect(&s, reasons);
    if (result == NORMA_OK) result = plant(&s, queries);
    if (result == NORMA_OK) result = open_asking(&a, room);
    result = norma_mpi_agree(call, result);
    if (result == NORMA_OK) ask_all(&a);
    close_asking(&a, room);
    close_sites(&s);
    return result;
}
