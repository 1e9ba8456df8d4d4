/* plan_update.c: a plan's groups summed and their normals written: all of them by the sums of
 * norma_vertex_normals, into memory that is the plan's; some of them, or all while another update
 * has that memory, each from its members, with no memory but the stack. */
#include "core/plan/plan.h"

/* Tasks are few enough that what each one counts fits the stack. */
enum { PLAN_MOST_TASKS = 128 };

static uint32_t face_of_corner(const norma_plan *plan, uint32_t corner) {
    return plan->corner_faces ? plan->corner_faces[corner] : corner / 3;
}
static int has_bit(const uint64_t *bits, size_t i) {
    return bits && (bits[i / 64] >> (i % 64) & 1);
}

/* ---- one update */

typedef struct plan_work {
    const norma_plan *plan;
    core_call *call;
    core_mesh mesh; /* the plan's, at the update's positions */
    const core_output *output;
    const uint32_t *moved; /* NULL: all */
    size_t moved_count;
    core_tally *tally; /* what the calling thread sums up */
} plan_work;

typedef struct plan_some {
    const uint64_t *bits; /* of each of count groups from first on; NULL: all */
    size_t first, count;
} plan_some;

typedef struct sums_work {
    const plan_work *work;
    const core_kernels *kernels;
    plan_some some;
    int apart_alone; /* of them, those that are summed apart */
    size_t tasks;
    core_tally tallies[PLAN_MOST_TASKS];
} sums_work;

/* ---- faces, measured once for groups that follow each other */

enum {
    HELD_FACES = 288, /* as many as 32 KiB of stack have room for, with all else */
    HELD_PLACES = 512,
    MEMBERS_AT_ONCE = 96,
    GROUPS_AT_ONCE = 16,
    HELD_WEIGHED = 8 /* beside the flags of core_face: weight is set */
};

typedef struct held_face {
    core_face face;
    double weight[3]; /* of a triangle's corners */
} held_face;

typedef struct held_faces {
    held_face of[HELD_FACES];
    uint32_t numbers[HELD_FACES];
    uint16_t places[HELD_PLACES]; /* by a hash of the number, one more than where it is; 0: free */
    uint16_t slots[MEMBERS_AT_ONCE];
    uint32_t count, measured, slot_count;
} held_faces;

static void clear_held(held_faces *held) {
    memset(held->places, 0, sizeof held->places);
    held->count = held->measured = held->slot_count = 0;
}

static uint32_t place_of(const held_faces *held, uint32_t face) {
    uint32_t at = (face * UINT32_C(0x9e3779b1)) >> 23;
    while (held->places[at] && held->numbers[held->places[at] - 1] != face)
        at = (at + 1) & (HELD_PLACES - 1);
    return at;
}

static void hold_members(
    const norma_plan *plan, const uint32_t *members, uint32_t count, held_faces *held) {
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t face = face_of_corner(plan, members[i]), at = place_of(held, face);
        if (!held->places[at]) {
            held->numbers[held->count++] = face;
            held->places[at] = (uint16_t)held->count;
        }
        held->slots[held->slot_count++] = (uint16_t)(held->places[at] - 1);
    }
}

static void keep_batch(const core_batch *batch, unsigned sure, size_t count, held_face *out) {
    for (size_t i = 0; i < count; ++i) {
        if (!(sure >> i & 1U)) continue;
        out[i].face.flags = CORE_FACE_DIRECTED | CORE_FACE_FINITE | HELD_WEIGHED;
        for (int k = 0; k < 3; ++k) {
            out[i].face.normal[k] = batch->normal[k][i];
            out[i].weight[k] = batch->weight[k][i];
        }
    }
}

/* Triangles eight at a time; what doubles do not decide, and polygons, by themselves. */
static void measure_held(const plan_work *work, held_faces *held) {
    for (uint32_t begin = held->measured, end; begin < held->count; begin = end) {
        size_t faces[CORE_LANES];
        core_batch batch;
        unsigned sure = 0;
        end = held->count - begin < CORE_LANES ? held->count : begin + CORE_LANES;
        for (uint32_t i = begin; i < end; ++i) faces[i - begin] = held->numbers[i];
        if (!work->plan->corner_faces)
            sure = norma_core_measure_triangles(
                work->call, &work->mesh, work->call->options.weight, faces, end - begin, &batch);
        keep_batch(&batch, sure, end - begin, &held->of[begin]);
        for (uint32_t i = begin; i < end; ++i)
            if (!(sure >> (i - begin) & 1U))
                norma_core_face_geometry(&work->mesh, held->numbers[i], &held->of[i].face);
    }
    held->measured = held->count;
}

/* ---- votes, in the order of members */

static int serves(const norma_plan *plan, size_t group, uint32_t vertex) {
    if (plan->of == NORMA_PER_CORNER || !plan->vertex_starts) return 1;
    uint32_t low = plan->vertex_starts[group], high = plan->vertex_starts[group + 1];
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (plan->vertices[middle] <= vertex)
            low = middle;
        else
            high = middle;
    }
    return plan->vertices[low] == vertex;
}

/* A face without a direction is counted where the normal of its first corner is written. */
static void count_degenerate_member(const plan_work *work, const core_face *face, uint32_t number,
    uint32_t corner, size_t group, core_tally *tally) {
    if ((face->flags & CORE_FACE_DIRECTED) || !(face->flags & CORE_FACE_FINITE) ||
        corner != norma_core_face_begin(&work->mesh, number))
        return;
    if (serves(work->plan, group, norma_core_corner(&work->mesh, corner)))
        norma_core_count_one(&tally->degenerate, number);
}

static void add_member_vote(const plan_work *work, const held_face *held, uint32_t number,
    uint32_t corner, core_vertex_sum *sum) {
    if (held->face.flags & HELD_WEIGHED)
        norma_core_add_vote(sum, held->weight[corner % 3], held->face.normal);
    else if ((held->face.flags & CORE_FACE_DIRECTED) &&
             norma_core_is_kept(&work->mesh, number, corner))
        norma_core_add_vote(sum,
            norma_core_corner_weight(
                &work->mesh, work->call->options.weight, number, &held->face, corner),
            held->face.normal);
}

typedef struct member_list {
    const uint32_t *corners;
    uint32_t count;
} member_list;

static member_list members_of(const norma_plan *plan, size_t group) {
    const uint32_t begin = plan->member_starts[group];
    return (member_list){plan->members + begin, plan->member_starts[group + 1] - begin};
}

/* The votes of members that are held, from a slot on. Their degenerate faces are counted. */
static void add_held(const plan_work *work, size_t group, member_list members,
    const held_faces *held, const uint16_t *slots, core_tally *tally, core_vertex_sum *sum) {
    for (uint32_t i = 0; i < members.count; ++i) {
        const held_face *face = &held->of[slots[i]];
        const uint32_t number = held->numbers[slots[i]];
        add_member_vote(work, face, number, members.corners[i], sum);
        if (!(face->face.flags & CORE_FACE_DIRECTED))
            count_degenerate_member(work, &face->face, number, members.corners[i], group, tally);
    }
}

/* The same of a group of any size. */
static void sum_large_group(const plan_work *work, size_t group, held_faces *held,
    core_tally *tally, core_vertex_sum *sum) {
    member_list all = members_of(work->plan, group);
    norma_core_clear_sums(sum, 1);
    while (all.count) {
        const member_list some = {
            all.corners, all.count < MEMBERS_AT_ONCE ? all.count : MEMBERS_AT_ONCE};
        if (held->count + some.count > HELD_FACES) clear_held(held);
        held->slot_count = 0;
        hold_members(work->plan, some.corners, some.count, held);
        measure_held(work, held);
        add_held(work, group, some, held, held->slots, tally, sum);
        all.corners += some.count;
        all.count -= some.count;
    }
}

/* ---- the most visible normal of a group's members, or of those that are corners of one vertex */

typedef struct group_cone {
    const plan_work *work;
    const uint32_t *members;
    uint32_t vertex; /* UINT32_MAX: all */
} group_cone;

static int cone_normal(const void *context, size_t index, double normal[3]) {
    const group_cone *cone = context;
    const core_mesh *mesh = &cone->work->mesh;
    const uint32_t corner = cone->members[index], number = face_of_corner(cone->work->plan, corner);
    core_face face;
    if (cone->vertex != UINT32_MAX && norma_core_corner(mesh, corner) != cone->vertex) return 0;
    norma_core_face_geometry(mesh, number, &face);
    memcpy(normal, face.normal, sizeof face.normal);
    return (face.flags & CORE_FACE_DIRECTED) && norma_core_is_kept(mesh, number, corner);
}

static int decide_group_cone(
    const plan_work *work, size_t group, uint32_t vertex, float normal[3]) {
    const member_list members = members_of(work->plan, group);
    const group_cone cone = {work, members.corners, vertex};
    double axis[3];
    if (!norma_core_smallest_cone_of(cone_normal, &cone, members.count, axis))
        return NORMA_REASON_CANCELLED;
    norma_core_direction(axis, normal);
    return NORMA_REASON_NONE;
}

/* ---- what a sum amounts to: NORMA_REASON_NONE and the normal, UNREFERENCED where nobody voted, or
 * CANCELLED */

static int decide_sum(const plan_work *work, size_t group, uint32_t vertex,
    const core_vertex_sum *sum, float normal[3]) {
    const double direction[3] = {sum->x, sum->y, sum->z};
    if (!norma_core_has_votes(sum)) return NORMA_REASON_UNREFERENCED;
    if (norma_core_sees(work->call)) return decide_group_cone(work, group, vertex, normal);
    if (norma_core_cancels(direction, sum->weight)) return NORMA_REASON_CANCELLED;
    norma_core_direction(direction, normal);
    return NORMA_REASON_NONE;
}

/* Of a vertex's own corners alone. */
static int decide_own(const plan_work *work, size_t group, uint32_t vertex, float normal[3]) {
    const norma_plan *plan = work->plan;
    const uint32_t *end = plan->at + plan->at_starts[vertex + 1];
    core_vertex_sum sum;
    norma_core_clear_sums(&sum, 1);
    for (const uint32_t *at = plan->at + plan->at_starts[vertex]; at < end;) {
        held_face faces[CORE_LANES];
        size_t numbers[CORE_LANES], count = 0;
        core_batch batch;
        for (; count < CORE_LANES && at + count < end; ++count)
            numbers[count] = face_of_corner(plan, at[count]);
        const unsigned sure = plan->corner_faces
                                  ? 0
                                  : norma_core_measure_triangles(work->call, &work->mesh,
                                        work->call->options.weight, numbers, count, &batch);
        keep_batch(&batch, sure, count, faces);
        for (size_t i = 0; i < count; ++i, ++at) {
            if (!(sure >> i & 1U))
                norma_core_face_geometry(&work->mesh, numbers[i], &faces[i].face);
            add_member_vote(work, &faces[i], (uint32_t)numbers[i], *at, &sum);
        }
    }
    return decide_sum(work, group, vertex, &sum, normal);
}

/* ---- out */

static int is_vertex_finite(const plan_work *work, uint32_t vertex) {
    double p[3];
    norma_core_position(&work->mesh, vertex, p);
    return norma_core_finite(p);
}

/* Where a group has a normal and all its corners are one vertex's, that is finite: faces that have
 * a direction are. */
static int is_surely_finite(const plan_work *work, int reason) {
    return reason == NORMA_REASON_NONE && !work->mesh.weld;
}

static void write_corners(
    const plan_work *work, size_t group, int reason, const float normal[3], core_tally *tally) {
    const member_list members = members_of(work->plan, group);
    const int sure = is_surely_finite(work, reason);
    for (uint32_t i = 0; i < members.count; ++i) {
        const uint32_t corner = members.corners[i];
        const int finite = sure || is_vertex_finite(work, norma_core_corner(&work->mesh, corner));
        norma_core_write_element(
            work->output, corner, finite ? reason : NORMA_REASON_NON_FINITE, normal, tally);
    }
}

/* Where the group's votes cancel, those of each vertex's own corners decide. */
static void write_vertex_of_group(const plan_work *work, size_t group, uint32_t vertex, int reason,
    const float normal[3], core_tally *tally) {
    float own[3] = {normal[0], normal[1], normal[2]};
    if (!is_surely_finite(work, reason) && !is_vertex_finite(work, vertex))
        reason = NORMA_REASON_NON_FINITE;
    else if (reason == NORMA_REASON_CANCELLED && work->mesh.weld &&
             decide_own(work, group, vertex, own) == NORMA_REASON_NONE)
        reason = NORMA_REASON_NONE;
    norma_core_write_element(work->output, vertex, reason, own, tally);
}

static void write_group_normals(
    const plan_work *work, size_t group, int reason, const float normal[3], core_tally *tally) {
    const norma_plan *plan = work->plan;
    if (plan->of == NORMA_PER_CORNER) {
        write_corners(work, group, reason, normal, tally);
        return;
    }
    if (!plan->vertices) {
        write_vertex_of_group(work, group, (uint32_t)group, reason, normal, tally);
        return;
    }
    for (uint32_t i = plan->vertex_starts[group]; i < plan->vertex_starts[group + 1]; ++i)
        write_vertex_of_group(work, group, plan->vertices[i], reason, normal, tally);
}

static void write_sum(
    const plan_work *work, size_t group, const core_vertex_sum *sum, core_tally *tally) {
    float normal[3] = {0, 0, 0};
    const int reason = decide_sum(work, group, UINT32_MAX, sum, normal);
    write_group_normals(work, group, reason, normal, tally);
}

/* Up to eight sums: at once where all have a normal. */
static void write_eight_sums(const sums_work *w, const uint32_t *groups,
    const core_vertex_sum *sums, size_t count, core_tally *tally) {
    float normals[CORE_LANES][3];
    const int fine =
        count == CORE_LANES && !norma_core_sees(w->work->call) && w->kernels->finish(sums, normals);
    for (size_t i = 0; i < count; ++i) {
        if (fine)
            write_group_normals(w->work, groups[i], NORMA_REASON_NONE, normals[i], tally);
        else
            write_sum(w->work, groups[i], &sums[i], tally);
    }
}

/* ---- some groups, each from its members */

typedef struct group_batch {
    uint32_t groups[GROUPS_AT_ONCE];
    core_vertex_sum sums[GROUPS_AT_ONCE];
    size_t count;
} group_batch;

static void sum_batch(const sums_work *w, group_batch *b, held_faces *held, core_tally *tally) {
    const uint16_t *slots = held->slots;
    measure_held(w->work, held);
    norma_core_clear_sums(b->sums, b->count);
    for (size_t i = 0; i < b->count; ++i) {
        const member_list members = members_of(w->work->plan, b->groups[i]);
        add_held(w->work, b->groups[i], members, held, slots, tally, &b->sums[i]);
        slots += members.count;
    }
    for (size_t i = 0; i < b->count; i += CORE_LANES)
        write_eight_sums(w, b->groups + i, b->sums + i,
            b->count - i < CORE_LANES ? b->count - i : CORE_LANES, tally);
    b->count = held->slot_count = 0;
    if (held->count + MEMBERS_AT_ONCE > HELD_FACES) clear_held(held);
}

static void take_group(
    const sums_work *w, uint32_t group, group_batch *b, held_faces *held, core_tally *tally) {
    const member_list members = members_of(w->work->plan, group);
    if (b->count == GROUPS_AT_ONCE || held->slot_count + members.count > MEMBERS_AT_ONCE)
        sum_batch(w, b, held, tally);
    if (members.count > MEMBERS_AT_ONCE) {
        core_vertex_sum sum;
        sum_large_group(w->work, group, held, tally, &sum);
        write_sum(w->work, group, &sum, tally);
        clear_held(held);
        return;
    }
    hold_members(w->work->plan, members.corners, members.count, held);
    b->groups[b->count++] = group;
}

static void sum_some(void *context, size_t task) {
    sums_work *w = context;
    const uint64_t count = w->some.count;
    const size_t end = (size_t)(count * (task + 1) / w->tasks);
    held_faces held;
    group_batch batch = {.count = 0};
    clear_held(&held);
    for (size_t i = (size_t)(count * task / w->tasks); i < end; ++i) {
        if (w->some.bits && !(w->some.bits[i / 64] >> (i % 64))) {
            i |= 63; /* none in the rest of the word */
            continue;
        }
        const uint32_t group = (uint32_t)(w->some.first + i);
        if ((!w->some.bits || has_bit(w->some.bits, i)) &&
            (!w->apart_alone || has_bit(w->work->plan->apart, group)))
            take_group(w, group, &batch, &held, &w->tallies[task]);
    }
    sum_batch(w, &batch, &held, &w->tallies[task]);
}

enum { GROUPS_IN_TASK = 1024 };

static sums_work work_on(const plan_work *work, plan_some some, int apart_alone) {
    const size_t tasks = some.count / GROUPS_IN_TASK + 1;
    return (sums_work){.work = work,
        .kernels = norma_core_kernels(work->call->level),
        .some = some,
        .apart_alone = apart_alone,
        .tasks = tasks < PLAN_MOST_TASKS ? tasks : PLAN_MOST_TASKS};
}

static norma_result run_tasks(sums_work *w, norma_task *task) {
    const norma_result result = norma_core_parallel(w->work->call, w->tasks, task, w);
    for (size_t i = 0; i < w->tasks; ++i) norma_core_tally_add(w->work->tally, &w->tallies[i]);
    return result;
}

/* Groups one by one, each from its members, with no memory but the stack. */
static norma_result sum_each(const plan_work *work, plan_some some) {
    sums_work w = work_on(work, some, 0);
    return run_tasks(&w, sum_some);
}

/* ---- groups in a row, by the sums of norma_vertex_normals */

static int is_group_chosen(const void *context, uint32_t group) {
    const sums_work *w = context;
    return (!w->some.bits || has_bit(w->some.bits, group - w->some.first)) &&
           !has_bit(w->work->plan->apart, group);
}

static void write_sums(
    void *context, const core_vertex_sum *sums, size_t first, size_t count, core_tally *tally) {
    const sums_work *w = context;
    uint32_t groups[CORE_LANES];
    core_vertex_sum chosen[CORE_LANES];
    size_t held = 0;
    for (size_t i = 0; i < count; ++i) {
        if (!is_group_chosen(w, (uint32_t)(first + i))) continue;
        groups[held] = (uint32_t)(first + i);
        chosen[held++] = sums[i];
        if (held < CORE_LANES) continue;
        write_eight_sums(w, groups, chosen, held, tally);
        held = 0;
    }
    write_eight_sums(w, groups, chosen, held, tally);
}

static void write_range(void *context, size_t task) {
    sums_work *w = context;
    const uint64_t count = w->some.count;
    const size_t begin = (size_t)(count * task / w->tasks),
                 end = (size_t)(count * (task + 1) / w->tasks);
    write_sums(w, w->work->plan->shared->sums + begin, w->some.first + begin, end - begin,
        &w->tallies[task]);
}

/* The same by the sums of norma_vertex_normals, for which all faces between the first and the last
 * are measured; whoever calls this has plan->shared. */
static norma_result sum_row(const plan_work *work, plan_some some) {
    const norma_plan *plan = work->plan;
    sums_work w = work_on(work, some, 0), apart = work_on(work, some, 1);
    const core_voting voting = {.call = work->call,
        .mesh = &work->mesh,
        .targets = plan->targets,
        .ranges = plan->ranges,
        .first = some.first,
        .count = some.count,
        .by_distance = plan->narrow,
        .counts = is_group_chosen,
        .context = &w};
    int taken = 0;
    norma_result result = NORMA_OK;
    if (!some.bits)
        result =
            norma_core_sum_bins(&voting, plan->shared->sums, write_sums, &w, work->tally, &taken);
    if (!result && !taken) {
        result = norma_core_sum_all(&voting, plan->shared->sums, work->tally);
        if (!result) result = run_tasks(&w, write_range);
    }
    return !result && plan->apart ? run_tasks(&apart, sum_some) : result;
}

/* ---- norma_plan_update: all groups, or those that moved vertices touch. It writes nothing of the
 * plan but what one update at a time may: updates may run at once. */

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

enum { MARKS = 1 << 15 };

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
        if (has_bit(plan->apart, target)) mark_others(m, (uint32_t)c);
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
        for (uint32_t at = begin; at < end; ++at) mark_face(m, face_of_corner(plan, plan->at[at]));
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
    return by_row && is_faster_in_a_row(m->work->plan, some, m->marked) ? sum_row(m->work, some)
                                                                        : sum_each(m->work, some);
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
        result = sum_row(work, all);
    else
        result = sum_each(work, all);
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
