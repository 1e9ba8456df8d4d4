/* plan_update.c: norma_plan_update: all groups, or those that moved vertices touch. It writes
 * nothing of the plan but what one update at a time may: updates may run at once. */
#include "core/plan/plan.h"

static size_t element_count(const norma_plan *plan) {
    return plan->of == NORMA_PER_VERTEX ? plan->vertex_count : plan->mesh.corner_count;
}

static int borrow(const norma_plan *plan) {
    return !atomic_flag_test_and_set_explicit(&plan->shared->taken, memory_order_acquire);
}
static void give_back(const norma_plan *plan) {
    atomic_flag_clear_explicit(&plan->shared->taken, memory_order_release);
}

/* ---- what moved: the groups in which faces that name a moved vertex vote. Marked once in bits for
 * all of them, which are the plan's, or, while another update has those, in bits that the stack has
 * room for, some groups after the other. Faces are marked too, since several of their corners may
 * have moved: while another has the plan's bits, those of polygons alone. */

enum { MARKS = 1 << 15, AHEAD = 16 };

typedef struct mark_span {
    size_t low, high; /* what is marked lies here, both included */
} mark_span;

typedef struct plan_marks {
    const plan_work *work;
    uint64_t *groups, *faces; /* faces: NULL, or each is gone through once */
    size_t first_group, group_count, first_face, face_count;
    mark_span group_span, face_span;
    size_t marked; /* groups */
} plan_marks;

static const mark_span NOTHING = {SIZE_MAX, 0};

/* Returns whether the bit was not set. */
static int mark_once(uint64_t *bits, size_t at, mark_span *span) {
    const uint64_t bit = (uint64_t)1 << (at % 64);
    if (bits[at / 64] & bit) return 0;
    bits[at / 64] |= bit;
    span->low = at < span->low ? at : span->low;
    span->high = at > span->high ? at : span->high;
    return 1;
}

static void clear_marks(uint64_t *bits, mark_span span) {
    if (span.low > span.high) return;
    memset(bits + span.low / 64, 0, (span.high / 64 - span.low / 64 + 1) * sizeof *bits);
}

static void mark_group(plan_marks *m, size_t group) {
    const size_t at = group - m->first_group; /* of an earlier one wraps round */
    if (at < m->group_count) m->marked += (size_t)mark_once(m->groups, at, &m->group_span);
}

/* What marking a vertex to come will read, in three steps: its corners, their faces' corners. */
static void ask_for_vertex(const plan_work *work, size_t i) {
    const norma_plan *plan = work->plan;
    if (i + 2 * AHEAD < work->moved_count)
        __builtin_prefetch(&plan->at_starts[work->moved[i + 2 * AHEAD]]);
    if (i + AHEAD < work->moved_count)
        __builtin_prefetch(&plan->at[plan->at_starts[work->moved[i + AHEAD]]]);
    if (i + AHEAD / 2 >= work->moved_count) return;
    const uint32_t vertex = work->moved[i + AHEAD / 2];
    for (uint32_t at = plan->at_starts[vertex]; at < plan->at_starts[vertex + 1]; ++at)
        __builtin_prefetch(&plan->targets[plan->at[at]]);
}

/* Its other groups than the first, found by bisection. */
static void mark_others(plan_marks *m, uint32_t corner) {
    const norma_plan *plan = m->work->plan;
    size_t low = 0, high = plan->other_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (plan->others[middle] >> 32 < corner)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < plan->other_count && plan->others[low] >> 32 == corner; ++low)
        mark_group(m, (uint32_t)plan->others[low]);
}

static void mark_face(plan_marks *m, uint32_t face) {
    const norma_plan *plan = m->work->plan;
    const core_mesh *mesh = &plan->mesh;
    const size_t at = face - m->first_face;
    if (m->faces && (at >= m->face_count || !mark_once(m->faces, at, &m->face_span))) return;
    for (size_t c = norma_core_face_begin(mesh, face); c < norma_core_face_end(mesh, face); ++c) {
        const uint32_t target = plan->targets[c];
        mark_group(m, target);
        if (norma_core_has_bit(plan->apart, target)) mark_others(m, (uint32_t)c);
    }
}

static size_t unreferenced_number(const norma_plan *plan, uint32_t vertex) {
    size_t low = 0, high = plan->unreferenced_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (plan->unreferenced[middle] < vertex)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void mark_moved(plan_marks *m) {
    const norma_plan *plan = m->work->plan;
    for (size_t i = 0; i < m->work->moved_count; ++i) {
        const uint32_t vertex = m->work->moved[i], begin = plan->at_starts[vertex],
                       end = plan->at_starts[vertex + 1];
        ask_for_vertex(m->work, i);
        for (uint32_t at = begin; at < end; ++at)
            mark_face(m, norma_core_plan_face(plan, plan->at[at]));
        if (begin == end && plan->unreferenced)
            mark_group(m, plan->first_unreferenced + unreferenced_number(plan, vertex));
        else if (begin == end && plan->of == NORMA_PER_VERTEX)
            mark_group(m, vertex);
    }
}

/* To sum a group by itself takes about as long as to sum so many in a row, which measures all faces
 * of each chunk that any of the row is touched by: in scans those are many. */
enum { IN_A_ROW = 6 };

static int is_faster_in_a_row(const norma_plan *plan, plan_some some, size_t marked) {
    const double groups_of_chunk =
        CORE_FACES_IN_CHUNK * (double)plan->group_count / (double)plan->mesh.face_count;
    size_t chunks = 0;
    if (marked <= (some.count + CORE_FACES_IN_CHUNK) / IN_A_ROW) return 0;
    for (size_t i = 0; i < norma_core_count_chunks(&plan->mesh); ++i)
        chunks +=
            plan->ranges[i].least < some.first + some.count && plan->ranges[i].most >= some.first;
    return (double)marked * IN_A_ROW > (double)chunks * groups_of_chunk;
}

static norma_result sum_marked(const plan_marks *m, int by_row) {
    const size_t low = m->group_span.low / 64 * 64;
    if (!m->marked) return NORMA_OK;
    const plan_some some = {
        m->groups + low / 64, m->first_group + low, m->group_span.high + 1 - low};
    return by_row && is_faster_in_a_row(m->work->plan, some, m->marked)
               ? norma_core_plan_sum_row(m->work, some)
               : norma_core_plan_sum_some(m->work, some);
}

static norma_result update_by_plans_marks(const plan_work *work) {
    plan_marks m = {.work = work,
        .groups = work->plan->shared->groups,
        .faces = work->plan->shared->faces,
        .group_count = work->plan->group_count,
        .face_count = work->plan->mesh.face_count,
        .group_span = NOTHING,
        .face_span = NOTHING};
    mark_moved(&m);
    const norma_result result = sum_marked(&m, !norma_core_sees(work->call));
    clear_marks(m.groups, m.group_span);
    clear_marks(m.faces, m.face_span);
    return result;
}

static norma_result update_by_own_marks(const plan_work *work) {
    uint64_t groups[MARKS / 64] = {0}, bits[MARKS / 64] = {0};
    const norma_plan *plan = work->plan;
    const size_t faces = plan->corner_faces ? plan->mesh.face_count : 1;
    plan_marks m = {.work = work, .groups = groups, .group_count = MARKS, .face_count = MARKS};
    if (plan->corner_faces) m.faces = bits;
    norma_result result = NORMA_OK;
    for (; m.first_group < plan->group_count && !result; m.first_group += MARKS) {
        m.group_span = NOTHING;
        m.marked = 0;
        for (m.first_face = 0; m.first_face < faces; m.first_face += MARKS) {
            m.face_span = NOTHING;
            mark_moved(&m);
            clear_marks(bits, m.face_span);
        }
        result = sum_marked(&m, 0);
        clear_marks(groups, m.group_span);
    }
    return result;
}

static norma_result update(const plan_work *work) {
    const norma_plan *plan = work->plan;
    const int borrowed = borrow(plan);
    const plan_some all = {NULL, 0, plan->group_count};
    norma_result result;
    if (work->moved)
        result = borrowed ? update_by_plans_marks(work) : update_by_own_marks(work);
    else if (borrowed && !norma_core_sees(work->call))
        result = norma_core_plan_sum_row(work, all);
    else
        result = norma_core_plan_sum_some(work, all);
    if (borrowed) give_back(plan);
    if (!work->moved) norma_core_count_add(&work->tally->degenerate, &plan->empty_faces);
    return result;
}

/* ---- the nearest normal: the one fallback that needs all others, and memory to look them up */

typedef struct plan_scratch {
    float *normals;
    uint8_t *reasons;
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

static uint32_t vertex_of_element(const norma_plan *plan, size_t element) {
    return plan->of == NORMA_PER_CORNER ? norma_core_corner(&plan->mesh, element)
                                        : (uint32_t)element;
}

static void write_nearest_normal(
    const plan_work *work, const plan_scratch *scratch, core_nearest *nearest) {
    const float zero[3] = {0, 0, 0};
    for (size_t e = 0; e < scratch->count; ++e) {
        if (scratch->reasons[e] == NORMA_REASON_NONE) continue;
        const uint32_t source = norma_core_nearest_find(nearest, vertex_of_element(work->plan, e));
        norma_core_write_normal(
            work->output, e, source == UINT32_MAX ? zero : scratch->normals + 3 * (size_t)source);
    }
}

static norma_result look_up_nearest(const plan_work *work, const plan_scratch *scratch) {
    core_nearest nearest;
    size_t wanting = 0;
    core_mesh mesh = work->mesh;
    mesh.weld = NULL; /* what was one position may have parted */
    norma_result result = norma_core_nearest_begin(work->call, &mesh, &nearest);
    if (result) return result;
    for (size_t e = 0; e < scratch->count; ++e) {
        if (scratch->reasons[e] == NORMA_REASON_NONE)
            norma_core_nearest_add(&nearest, vertex_of_element(work->plan, e), (uint32_t)e);
        else
            ++wanting;
    }
    result = norma_core_nearest_plant(&nearest, wanting);
    if (!result) write_nearest_normal(work, scratch, &nearest);
    norma_core_nearest_end(&nearest);
    return result;
}

static norma_result fill_plan_from_nearest(const plan_work *work) {
    const norma_plan *plan = work->plan;
    plan_scratch scratch = {.count = element_count(plan)};
    scratch.normals = norma_core_allocate(work->call, scratch.count, 3 * sizeof *scratch.normals);
    scratch.reasons = norma_core_allocate(work->call, scratch.count, 1);
    norma_result result = scratch.normals && scratch.reasons ? NORMA_OK : NORMA_ERROR_MEMORY;
    if (!result) result = update_scratch(work, &scratch);
    if (!result) result = look_up_nearest(work, &scratch);
    norma_core_release(work->call, scratch.normals, scratch.count, 3 * sizeof *scratch.normals);
    norma_core_release(work->call, scratch.reasons, scratch.count, 1);
    return result;
}

/* ---- the call */

/* All of them in order is all. */
static norma_result check_moved(const norma_plan *plan, const uint32_t **moved, size_t count) {
    uint32_t largest = 0, out_of_order = 0;
    for (size_t i = 0; i < count; ++i) {
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
    core_mesh checked;
    norma_result result = norma_core_mesh_shape(&points, &checked);
    if (!result && positions.count != plan->vertex_count) result = NORMA_ERROR_ARGUMENT;
    if (!result && moved) result = check_moved(plan, &moved, moved_count);
    work->mesh = plan->mesh;
    work->mesh.positions = checked.positions;
    if (positions.format != NORMA_FORMAT_DOUBLE) work->mesh.scale = checked.scale;
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
    if (!result)
        result = norma_core_output_open(&call, normals, element_count(plan), capacity, &output);
    if (!result) result = open_plan_work(plan, positions, moved, moved_count, &call, &work);
    if (!result) norma_core_share(&call, plan->mesh.corner_count);
    if (result) return result;
    result = update(&work);
    const size_t without =
        tally.non_finite.count + tally.unreferenced.count + tally.cancelled.count;
    if (!result && output.nearest && (work.moved ? moved_count : without))
        result = fill_plan_from_nearest(&work);
    if (!result && norma_core_progress(&call, 1)) result = NORMA_CANCELLED;
    if (!result) norma_core_write_report(report, &tally, NULL, NULL);
    return result;
}
