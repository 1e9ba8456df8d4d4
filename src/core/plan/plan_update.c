/* plan_update.c: norma_plan_update: blocks, overflow groups, and vertices without corners. */
#include "core/plan/plan.h"

/* ---- sums of overflow groups. Each streams through the faces that vote in it and keeps nothing
 * but its sum, so that it needs no memory however many there are. */

enum { CACHED_FACES = 16, SLOTS_IN_BLOCK = 1 << 16, FACES_IN_BLOCK = 1 << 16 };

typedef struct cached_face {
    uint32_t number;
    core_face face;
} cached_face; /* number: UINT32_MAX: empty */

typedef struct overflow_work {
    const plan_work *work;
    plan_work *work_of_call; /* the same, for the calling thread */
    core_mesh mesh;          /* the overflow faces, at the update's positions */
    size_t tasks, first_group, group_count;
    const uint64_t *touched; /* NULL: all groups from first_group on; else a bit of each */
    core_tally tallies[PLAN_MOST_TASKS];
} overflow_work;

/* ---- votes, in the order of members */

static uint32_t overflow_face_of(const overflow_group *overflow, uint32_t corner) {
    return overflow->corner_faces ? overflow->corner_faces[corner] : corner / 3;
}

static int serves(const overflow_group *overflow, size_t group, uint32_t vertex) {
    if (!overflow->vertex_starts) return 1;
    uint32_t low = overflow->vertex_starts[group], high = overflow->vertex_starts[group + 1];
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (overflow->vertices[middle] <= vertex)
            low = middle;
        else
            high = middle;
    }
    return overflow->vertices[low] == vertex;
}

/* A face without a direction is counted where the normal of its first corner is written. */
static void count_degenerate_overflow(const overflow_work *w, const core_face *face,
    uint32_t number, uint32_t corner, size_t group, core_tally *tally) {
    const overflow_group *overflow = &w->work->plan->overflow;
    if (!tally || (face->flags & CORE_FACE_DIRECTED) || !(face->flags & CORE_FACE_FINITE) ||
        corner != norma_core_face_begin(&w->mesh, number))
        return;
    if (serves(overflow, group, overflow->corners[corner]))
        norma_core_count_one(&tally->degenerate, overflow->faces[number]);
}

static void add_overflow_vote(double weight, const double normal[3], double sum[4]) {
    for (int k = 0; k < 3; k++) sum[k] += weight * normal[k];
    sum[3] += weight;
}

/* Groups that follow each other meet the same large polygons. */
static const core_face *measured_face_of(
    const overflow_work *w, uint32_t number, cached_face *cache) {
    cached_face *at = &cache[number % CACHED_FACES];
    if (at->number != number) {
        norma_core_face_geometry(&w->mesh, number, &at->face);
        at->number = number;
    }
    return &at->face;
}

/* ---- one group */

/* Polygons, and triangles that doubles do not decide. */
static void add_overflow_face(const overflow_work *w, size_t group, uint32_t corner, int votes,
    cached_face *cache, core_tally *tally, double sum[4]) {
    const uint32_t number = overflow_face_of(&w->work->plan->overflow, corner);
    const core_face *face = measured_face_of(w, number, cache);
    count_degenerate_overflow(w, face, number, corner, group, tally);
    if (!votes || !(face->flags & CORE_FACE_DIRECTED) ||
        !norma_core_is_kept(&w->mesh, number, corner))
        return;
    add_overflow_vote(
        norma_core_corner_weight(&w->mesh, w->work->call->options.weight, number, face, corner),
        face->normal, sum);
}

/* The triangles of eight members at most. Returns which of them doubles decide. */
static unsigned measure_members(
    const overflow_work *w, const uint32_t *members, uint32_t count, core_batch *batch) {
    size_t faces[CORE_LANES];
    for (uint32_t i = 0; i < count; i++) faces[i] = members[i] / 3;
    return norma_core_measure_triangles(
        w->work->call, &w->mesh, w->work->call->options.weight, faces, count, batch);
}

static void add_members(const overflow_work *w, size_t group, const uint32_t *members,
    uint32_t count, uint32_t vertex, cached_face *cache, core_tally *tally, double sum[4]) {
    const overflow_group *overflow = &w->work->plan->overflow;
    core_batch b;
    const unsigned sure = overflow->corner_faces ? 0 : measure_members(w, members, count, &b);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t corner = members[i], k = corner % 3;
        const int votes = vertex == UINT32_MAX || overflow->corners[corner] == vertex;
        if (!(sure >> i & 1U))
            add_overflow_face(w, group, corner, votes, cache, tally, sum);
        else if (votes)
            add_overflow_vote(b.weight[k][i],
                (const double[3]){b.normal[0][i], b.normal[1][i], b.normal[2][i]}, sum);
    }
}

/* Over all members, or those that are corners of one vertex. tally: NULL where its faces are
 * counted already. */
static void sum_group(const overflow_work *w, size_t group, uint32_t vertex, cached_face *cache,
    core_tally *tally, double sum[4]) {
    const overflow_group *overflow = &w->work->plan->overflow;
    const uint32_t end = overflow->member_starts[group + 1];
    sum[0] = sum[1] = sum[2] = 0;
    sum[3] = -0.0;
    for (uint32_t i = overflow->member_starts[group]; i < end; i += CORE_LANES)
        add_members(w, group, overflow->members + i, end - i < CORE_LANES ? end - i : CORE_LANES,
            vertex, cache, tally, sum);
}

typedef struct overflow_cone {
    const overflow_work *work;
    cached_face *cache;
    const uint32_t *members;
    uint32_t vertex;
} overflow_cone;

static int overflow_cone_normal(const void *context, size_t index, double normal[3]) {
    const overflow_cone *cone = context;
    const overflow_work *w = cone->work;
    const overflow_group *overflow = &w->work->plan->overflow;
    const uint32_t corner = cone->members[index], number = overflow_face_of(overflow, corner);
    if (cone->vertex != UINT32_MAX && overflow->corners[corner] != cone->vertex) return 0;
    const core_face *face = measured_face_of(w, number, cone->cache);
    memcpy(normal, face->normal, sizeof face->normal);
    return (face->flags & CORE_FACE_DIRECTED) && norma_core_is_kept(&w->mesh, number, corner);
}

static int decide_group(const overflow_work *w, size_t group, uint32_t vertex, cached_face *cache,
    core_tally *tally, float normal[3]) {
    const overflow_group *overflow = &w->work->plan->overflow;
    const overflow_cone cone = {
        w, cache, overflow->members + overflow->member_starts[group], vertex};
    double sum[4];
    sum_group(w, group, vertex, cache, tally, sum);
    if (w->work->call->options.weight != NORMA_WEIGHT_VISIBLE)
        return norma_core_plan_decide(sum, normal);
    return norma_core_plan_decide_cone(sum[3], overflow_cone_normal, &cone,
        overflow->member_starts[group + 1] - overflow->member_starts[group], normal);
}

static int is_overflow_finite(const overflow_work *w, uint32_t vertex) {
    double p[3];
    norma_core_position(&w->mesh, vertex, p);
    return norma_core_finite(p);
}

static void write_overflow_corners(
    const overflow_work *w, size_t group, int reason, const float normal[3], core_tally *tally) {
    const overflow_group *overflow = &w->work->plan->overflow;
    for (uint32_t i = overflow->member_starts[group]; i < overflow->member_starts[group + 1]; i++) {
        const uint32_t corner = overflow->members[i];
        norma_core_write_element(w->work->output, overflow->mesh_corners[corner],
            is_overflow_finite(w, overflow->corners[corner]) ? reason : NORMA_REASON_NON_FINITE,
            normal, tally);
    }
}

/* Where the group's votes cancel, those of each vertex's own corners decide. */
static void write_overflow_vertices(const overflow_work *w, size_t group, int reason,
    const float normal[3], cached_face *cache, core_tally *tally) {
    const overflow_group *overflow = &w->work->plan->overflow;
    for (uint32_t i = overflow->vertex_starts[group]; i < overflow->vertex_starts[group + 1]; i++) {
        const uint32_t vertex = overflow->vertices[i];
        float own[3] = {0, 0, 0};
        int own_reason = reason;
        if (!is_overflow_finite(w, vertex))
            own_reason = NORMA_REASON_NON_FINITE;
        else if (reason == NORMA_REASON_CANCELLED &&
                 decide_group(w, group, vertex, cache, NULL, own) == NORMA_REASON_NONE)
            own_reason = NORMA_REASON_NONE;
        norma_core_write_element(
            w->work->output, vertex, own_reason, reason == NORMA_REASON_NONE ? normal : own, tally);
    }
}

static void update_group(
    const overflow_work *w, size_t group, cached_face *cache, core_tally *tally) {
    float normal[3] = {0, 0, 0};
    const int reason = decide_group(w, group, UINT32_MAX, cache, tally, normal);
    if (w->work->plan->of == NORMA_PER_CORNER)
        write_overflow_corners(w, group, reason, normal, tally);
    else
        write_overflow_vertices(w, group, reason, normal, cache, tally);
}

static void update_some_overflow(void *context, size_t task) {
    overflow_work *w = context;
    const plan_range range = norma_core_plan_range(w->group_count, w->tasks, task);
    cached_face cache[CACHED_FACES];
    for (int i = 0; i < CACHED_FACES; i++) cache[i].number = UINT32_MAX;
    for (size_t i = range.begin; i < range.end; i++)
        if (!w->touched || (w->touched[i / 64] >> (i % 64) & 1))
            update_group(w, w->first_group + i, cache, &w->tallies[task]);
}

static norma_result run_overflow(
    overflow_work *w, size_t first_group, size_t group_count, const uint64_t *touched) {
    plan_work *work = w->work_of_call;
    w->first_group = first_group;
    w->group_count = group_count;
    w->touched = touched;
    w->tasks = group_count < PLAN_MOST_TASKS ? group_count : PLAN_MOST_TASKS;
    memset(w->tallies, 0, sizeof w->tallies);
    const norma_result result = norma_core_parallel(work->call, w->tasks, update_some_overflow, w);
    for (size_t i = 0; i < w->tasks; i++) norma_core_tally_add(work->tally, &w->tallies[i]);
    return result;
}

/* ---- what moved: faces and groups are marked in stores that the stack has room for, each once
 * however many of its corners moved */

typedef struct group_store {
    size_t first, count, touched_count;
    uint64_t touched[SLOTS_IN_BLOCK / 64];
} group_store;

static size_t mark_moved_faces(const overflow_work *w, size_t first, size_t count, uint64_t *bits) {
    const overflow_group *overflow = &w->work->plan->overflow;
    size_t marked = 0;
    memset(bits, 0, FACES_IN_BLOCK / 8);
    for (size_t i = 0; i < w->work->moved_count; i++) {
        const uint32_t vertex = w->work->moved[i];
        for (uint32_t at = overflow->at_starts[vertex]; at < overflow->at_starts[vertex + 1];
             at++) {
            const uint32_t face = overflow_face_of(overflow, overflow->at[at]);
            if (face < first || face - first >= count) continue;
            norma_core_mark_bit(bits, face - first);
            marked++;
        }
    }
    return marked;
}

static void mark_groups_of_face(const overflow_work *w, size_t face, group_store *store) {
    const overflow_group *overflow = &w->work->plan->overflow;
    for (size_t c = norma_core_face_begin(&w->mesh, face); c < norma_core_face_end(&w->mesh, face);
         c++)
        for (uint32_t i = overflow->group_starts[c]; i < overflow->group_starts[c + 1]; i++) {
            const uint32_t group = overflow->groups[i];
            if (group < store->first || group - store->first >= store->count) continue;
            norma_core_mark_bit(store->touched, group - store->first);
            store->touched_count++;
        }
}

static void mark_groups(const overflow_work *w, group_store *store) {
    uint64_t bits[FACES_IN_BLOCK / 64];
    const size_t faces = w->mesh.face_count;
    memset(store->touched, 0, sizeof store->touched);
    store->touched_count = 0;
    for (size_t first = 0; first < faces; first += FACES_IN_BLOCK) {
        const size_t count = faces - first < FACES_IN_BLOCK ? faces - first : FACES_IN_BLOCK;
        if (!mark_moved_faces(w, first, count, bits)) continue;
        for (size_t f = 0; f < count; f++)
            if (bits[f / 64] >> (f % 64) & 1) mark_groups_of_face(w, first + f, store);
    }
}

static norma_result update_moved_overflow(overflow_work *w) {
    const size_t groups = w->work->plan->overflow.group_count;
    group_store store;
    norma_result result = NORMA_OK;
    for (store.first = 0; store.first < groups && result == NORMA_OK;
         store.first += SLOTS_IN_BLOCK) {
        store.count = groups - store.first < SLOTS_IN_BLOCK ? groups - store.first : SLOTS_IN_BLOCK;
        mark_groups(w, &store);
        if (store.touched_count) result = run_overflow(w, store.first, store.count, store.touched);
    }
    return result;
}

static norma_result core_plan_update_overflow(plan_work *work) {
    const overflow_group *overflow = &work->plan->overflow;
    overflow_work w = {.work = work, .work_of_call = work, .mesh = work->mesh};
    if (!overflow->group_count) return NORMA_OK;
    w.mesh.corners = overflow->corners;
    w.mesh.corner_count = overflow->corner_count;
    w.mesh.corner_size = sizeof *overflow->corners;
    w.mesh.face_starts = overflow->face_starts;
    w.mesh.face_count = overflow->face_count;
    w.mesh.weld = work->plan->weld;
    return work->moved ? update_moved_overflow(&w)
                       : run_overflow(&w, 0, overflow->group_count, NULL);
}

static void core_plan_overflow_vertices(const norma_plan *plan, uint32_t *vertices) {
    const overflow_group *overflow = &plan->overflow;
    for (size_t c = 0; c < overflow->corner_count; c++)
        vertices[overflow->mesh_corners[c]] = overflow->corners[c];
}

/* ---- one update. It writes nothing of the plan: updates of one may run at once. */

static size_t element_count(const norma_plan *plan) {
    return plan->of == NORMA_PER_VERTEX ? plan->vertex_count : plan->corner_count;
}

/* ---- vertices without corners */

static void write_lonely(const plan_work *work, uint32_t vertex) {
    double p[3];
    norma_core_position(&work->mesh, vertex, p);
    norma_core_write_element(work->output, vertex,
        norma_core_finite(p) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE,
        work->output->fallback, work->tally);
}

static size_t lonely_number(const norma_plan *plan, uint32_t vertex) {
    size_t low = 0, high = plan->lonely_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (plan->lonely[middle] < vertex)
            low = middle + 1;
        else
            high = middle;
    }
    return low < plan->lonely_count && plan->lonely[low] == vertex ? low : SIZE_MAX;
}

enum { LONELY_IN_BLOCK = 1 << 16 };

/* Each once, however often it is named. */
static void update_moved_lonely(const plan_work *work) {
    const norma_plan *plan = work->plan;
    uint64_t bits[LONELY_IN_BLOCK / 64];
    for (size_t first = 0; first < plan->lonely_count; first += LONELY_IN_BLOCK) {
        memset(bits, 0, sizeof bits);
        for (size_t i = 0; i < work->moved_count; i++) {
            const size_t number = lonely_number(plan, work->moved[i]);
            if (number == SIZE_MAX || number < first || number - first >= LONELY_IN_BLOCK) continue;
            const uint64_t bit = (uint64_t)1 << (number % 64);
            if (!(bits[(number - first) / 64] & bit)) write_lonely(work, work->moved[i]);
            bits[(number - first) / 64] |= bit;
        }
    }
}

static void update_lonely(const plan_work *work) {
    if (work->plan->of != NORMA_PER_VERTEX) return;
    if (work->moved)
        update_moved_lonely(work);
    else
        for (size_t i = 0; i < work->plan->lonely_count; i++)
            write_lonely(work, work->plan->lonely[i]);
}

static norma_result update(plan_work *work) {
    norma_result result = norma_core_plan_update_blocks(work);
    if (result == NORMA_OK) result = core_plan_update_overflow(work);
    if (result != NORMA_OK) return result;
    update_lonely(work);
    if (!work->moved) norma_core_count_add(&work->tally->degenerate, &work->plan->empty_faces);
    return NORMA_OK;
}

/* ---- the nearest normal: the one fallback that needs all others, and memory to look them up */

typedef struct plan_scratch {
    float *normals;
    uint8_t *reasons;
    uint32_t *vertices; /* per corner: of each corner */
    size_t count;
} plan_scratch;

/* All normals and reasons, whatever moved: a normal may be wanted far from where it changed. */
static norma_result update_scratch(const plan_work *work, plan_scratch *scratch) {
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    const core_output output = {.normals = (unsigned char *)scratch->normals,
        .stride = 3 * sizeof(float),
        .reasons = scratch->reasons};
    plan_work all = *work;
    all.output = &output;
    all.moved = NULL;
    all.tally = &tally;
    return update(&all);
}

static uint32_t vertex_of_element(const plan_scratch *scratch, size_t element) {
    return scratch->vertices ? scratch->vertices[element] : (uint32_t)element;
}

static void write_nearest_normal(
    const plan_work *work, const plan_scratch *scratch, core_nearest *nearest) {
    const float zero[3] = {0, 0, 0};
    for (size_t e = 0; e < scratch->count; e++) {
        if (scratch->reasons[e] == NORMA_REASON_NONE) continue;
        const uint32_t source = norma_core_nearest_find(nearest, vertex_of_element(scratch, e));
        norma_core_write_normal(
            work->output, e, source == UINT32_MAX ? zero : scratch->normals + 3 * (size_t)source);
    }
}

static norma_result look_up_nearest(const plan_work *work, const plan_scratch *scratch) {
    core_nearest nearest;
    size_t wanting = 0;
    core_mesh mesh = work->mesh;
    norma_result result = norma_core_nearest_begin(work->call, &mesh, &nearest);
    if (result != NORMA_OK) return result;
    for (size_t e = 0; e < scratch->count; e++) {
        if (scratch->reasons[e] == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, vertex_of_element(scratch, e), (uint32_t)e);
        else
            wanting++;
    }
    result = norma_core_nearest_plant(&nearest, wanting);
    if (result == NORMA_OK) write_nearest_normal(work, scratch, &nearest);
    norma_core_nearest_end(&nearest);
    return result;
}

static norma_result fill_plan_from_nearest(const plan_work *work) {
    const norma_plan *plan = work->plan;
    const int per_corner = plan->of == NORMA_PER_CORNER;
    plan_scratch scratch = {.count = element_count(plan)};
    scratch.normals = norma_core_allocate(work->call, scratch.count, 3 * sizeof *scratch.normals);
    scratch.reasons = norma_core_allocate(work->call, scratch.count, 1);
    if (per_corner)
        scratch.vertices = norma_core_allocate(work->call, scratch.count, sizeof *scratch.vertices);
    norma_result result = scratch.normals && scratch.reasons && (!per_corner || scratch.vertices)
                              ? NORMA_OK
                              : NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) result = update_scratch(work, &scratch);
    if (result == NORMA_OK && per_corner) {
        norma_core_plan_block_vertices(plan, scratch.vertices);
        core_plan_overflow_vertices(plan, scratch.vertices);
    }
    if (result == NORMA_OK) result = look_up_nearest(work, &scratch);
    norma_core_release(work->call, scratch.normals, scratch.count, 3 * sizeof *scratch.normals);
    norma_core_release(work->call, scratch.reasons, scratch.count, 1);
    norma_core_release(work->call, scratch.vertices, scratch.count, sizeof *scratch.vertices);
    return result;
}

/* ---- the call */

/* All of them in order is all. */
static norma_result check_moved(const norma_plan *plan, const uint32_t **moved, size_t count) {
    uint32_t largest = 0, out_of_order = 0;
    for (size_t i = 0; i < count; i++) {
        largest = (*moved)[i] > largest ? (*moved)[i] : largest;
        out_of_order |= (*moved)[i] ^ (uint32_t)i;
    }
    if (count && largest >= plan->vertex_count) return NORMA_ERROR_INDEX;
    if (count == plan->vertex_count && !out_of_order) *moved = NULL;
    return NORMA_OK;
}

static norma_result open_plan_work(const norma_plan *plan, norma_vec3_view positions,
    const uint32_t *moved, size_t moved_count, core_call *call, plan_work *work) {
    const norma_mesh points = {.positions = positions};
    norma_result result = norma_core_mesh_shape(&points, &work->mesh);
    if (result == NORMA_OK && positions.count != plan->vertex_count) result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK && moved) result = check_moved(plan, &moved, moved_count);
    if (positions.format == NORMA_FORMAT_DOUBLE) work->mesh.scale = plan->scale;
    work->plan = plan;
    work->call = call;
    work->moved = moved;
    work->moved_count = moved_count;
    return result;
}

norma_result norma_plan_update(const norma_plan *plan, norma_vec3_view positions,
    const uint32_t *moved, size_t moved_count, const norma_options *options, float *normals,
    size_t capacity, norma_report *report) {
    core_call call;
    core_output output;
    core_tally tally = {{0, 0}, {0, 0}, {0, 0}, {0, 0}};
    plan_work work = {.output = &output, .tally = &tally};
    if (!plan) return NORMA_ERROR_ARGUMENT;
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK)
        result = norma_core_output_open(&call, normals, element_count(plan), capacity, &output);
    if (result == NORMA_OK)
        result = open_plan_work(plan, positions, moved, moved_count, &call, &work);
    if (result == NORMA_OK) norma_core_share(&call, plan->corner_count);
    if (result != NORMA_OK) return result;
    result = update(&work);
    const size_t without =
        tally.non_finite.count + tally.unreferenced.count + tally.cancelled.count;
    if (result == NORMA_OK && output.nearest && (work.moved ? moved_count : without))
        result = fill_plan_from_nearest(&work);
    if (result == NORMA_OK && norma_core_progress(&call, 1)) result = NORMA_CANCELLED;
    if (result == NORMA_OK) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}
