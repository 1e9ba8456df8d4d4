/* plan_update.c: one update: block by block, then the groups without a block, then what has no
 * corners. */
#include "core/plan/plan.h"
#include "core/corner/corner.h"
#include "core/mesh/mesh.h"
#include <math.h>

/* norma_core_plan_decide of the normals that voted, by the most visible one. */
static int core_plan_decide_cone(
    double weight, norma_core_cone_at *at, const void *context, size_t count, float normal[3]) {
    double axis[3];
    if (signbit(weight)) return NORMA_REASON_UNREFERENCED;
    if (!norma_core_smallest_cone_of(at, context, count, axis)) return NORMA_REASON_CANCELLED;
    norma_core_direction(axis, normal);
    return NORMA_REASON_NONE;
}

/* ---- From vertices that moved to what of each block they touch. What a position that moves can
 * change: the faces that name it, and so the sums in which their corners vote. */

static void mark_bit(uint64_t *bits, size_t i) { bits[i / 64] |= (uint64_t)1 << (i % 64); }

/* ---- which vertices of which blocks moved */

typedef struct mark_span {
    uint32_t first, last;
} mark_span;

static mark_span mark_store(const plan_work *work, block_marks *marks, uint32_t count) {
    const norma_plan *plan = work->plan;
    mark_span span = {UINT32_MAX, 0};
    if (!marks->borrowed) memset(marks->bits, 0, ((size_t)count + 63) / 64 * sizeof *marks->bits);
    for (size_t i = 0; i < work->moved_count; i++) {
        const uint32_t end = plan->occurrence_starts[work->moved[i] + 1];
        for (uint32_t at = plan->occurrence_starts[work->moved[i]]; at < end; at++) {
            const uint32_t number = plan->occurrences[at] - marks->first_occurrence;
            if (number >= count)
                continue; /* also those before the store: the difference wraps round */
            mark_bit(marks->bits, number);
            span.first = number < span.first ? number : span.first;
            span.last = number > span.last ? number : span.last;
        }
    }
    return span;
}

static size_t count_marked(const uint64_t *bits, size_t begin, size_t end) {
    size_t count = 0;
    for (size_t i = begin; i < end; i += 64 - i % 64) {
        const size_t left = end - i < 64 - i % 64 ? end - i : 64 - i % 64;
        uint64_t word = bits[i / 64] >> (i % 64) << (64 - left);
        for (; word; word &= word - 1) count++;
    }
    return count;
}

static int any_marked(const uint64_t *bits, size_t begin, size_t end) {
    for (size_t i = begin; i < end; i += 64 - i % 64) {
        const size_t left = end - i < 64 - i % 64 ? end - i : 64 - i % 64;
        if (bits[i / 64] >> (i % 64) << (64 - left)) return 1;
    }
    return 0;
}

static uint32_t occurrences_before(const norma_plan *plan, size_t block) {
    return block < plan->block_count ? plan->blocks[block].first_occurrence
                                     : (uint32_t)plan->occurrence_count;
}

static size_t block_of(const norma_plan *plan, size_t low, size_t high, uint32_t occurrence) {
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (plan->blocks[middle].first_occurrence <= occurrence)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void core_marks_open(const plan_work *work, block_marks *marks) {
    marks->next_block = 0;
    marks->bits = marks->own;
    marks->borrowed =
        work->plan->occurrence_count > MARKS_IN_BLOCK && norma_core_plan_borrow(work->plan);
    if (marks->borrowed) marks->bits = work->plan->shared->bits;
}

static int core_marks_next(const plan_work *work, block_marks *marks) {
    const norma_plan *plan = work->plan;
    const size_t first = marks->next_block,
                 room = marks->borrowed ? plan->occurrence_count : MARKS_IN_BLOCK;
    marks->block_count = marks->busy = 0;
    if (first == plan->block_count) return 0;
    marks->first_occurrence = occurrences_before(plan, first);
    size_t end = marks->borrowed ? plan->block_count : first + 1;
    while (end < plan->block_count &&
           occurrences_before(plan, end + 1) - marks->first_occurrence <= room)
        end++;
    marks->next_block = end;
    const mark_span span =
        mark_store(work, marks, occurrences_before(plan, end) - marks->first_occurrence);
    if (span.first > span.last) return 1;
    marks->first_block = block_of(plan, first, end, marks->first_occurrence + span.first);
    marks->block_count =
        block_of(plan, first, end, marks->first_occurrence + span.last) + 1 - marks->first_block;
    for (size_t t = marks->first_block; t < marks->first_block + marks->block_count; t++)
        marks->busy +=
            (size_t)any_marked(marks->bits, occurrences_before(plan, t) - marks->first_occurrence,
                occurrences_before(plan, t + 1) - marks->first_occurrence);
    return 1;
}

/* The plan's bits are zero between updates: to clear them all before each would take longer than to
 * move a vertex. */
static void clear_borrowed(const plan_work *work, block_marks *marks) {
    const norma_plan *plan = work->plan;
    for (size_t i = 0; i < work->moved_count; i++)
        for (uint32_t at = plan->occurrence_starts[work->moved[i]];
             at < plan->occurrence_starts[work->moved[i] + 1]; at++)
            marks->bits[plan->occurrences[at] / 64] = 0;
}

/* Marks what moved in the next blocks; 0 where none are left. */
static void core_marks_close(const plan_work *work, block_marks *marks) {
    if (!marks->borrowed) return;
    clear_borrowed(work, marks);
    norma_core_plan_give_back(work->plan);
}

/* ---- what that touches in a block */

static int joined_lists(const block_view *t, uint32_t group) {
    return group < t->group_count && (t->member_starts[group] & BLOCK_JOINED);
}

static int has_member(const block_view *t, uint32_t group, uint32_t member) {
    for (uint32_t i = norma_core_block_start(t, group); i < norma_core_block_start(t, group + 1);
         i++)
        if (t->members[i] == member) return 1;
    return 0;
}

/* The first group at the position of an own vertex. */
static uint32_t first_group(const block_view *t, uint32_t vertex) {
    uint32_t group = norma_core_block_group_of(t, vertex);
    while (joined_lists(t, group)) group--;
    return group;
}

static void touch_groups_of_face(const block_view *t, uint32_t face, block_touch *touch) {
    const uint32_t begin = t->face_starts ? t->face_starts[face] : 3 * face,
                   end = t->face_starts ? t->face_starts[face + 1] : begin + 3;
    for (uint32_t c = begin; c < end; c++) {
        if (t->corners[c] >= t->own_count) continue;
        const uint32_t member =
            norma_core_block_member(t->corner_faces != NULL, face, c - begin, c);
        uint32_t group = first_group(t, t->corners[c]);
        if (!joined_lists(t, group + 1)) {
            touch->group_is_touched[group] = 1;
            continue;
        }
        do {
            if (has_member(t, group, member)) touch->group_is_touched[group] = 1;
        } while (joined_lists(t, ++group));
    }
}

/* The faces that name a vertex: among the members of the groups at its position. */
static void touch_faces_of_vertex(
    const block_view *t, uint32_t vertex, uint8_t *face_is_moved, block_touch *touch) {
    uint32_t group =
        vertex < t->own_count ? first_group(t, vertex) : t->group_count + vertex - t->own_count;
    do {
        for (uint32_t i = norma_core_block_start(t, group);
             i < norma_core_block_start(t, group + 1); i++) {
            const uint32_t member = t->members[i], face = norma_core_block_face_of(t, member);
            if (face_is_moved[face] || t->corners[norma_core_block_corner_of(t, member)] != vertex)
                continue;
            face_is_moved[face] = 1;
            touch_groups_of_face(t, face, touch);
        }
    } while (joined_lists(t, ++group));
}

/* The numbers of the flags that are 1, up to a multiple of eight; flags are looked at eight at a
 * time. */
static uint32_t list_flags(const uint8_t *flags, uint32_t count, uint16_t *numbers) {
    uint32_t listed = 0;
    for (uint32_t i = 0; i < count; i += 8) {
        uint64_t eight;
        memcpy(&eight, flags + i, sizeof eight);
        if (!eight) continue;
        for (uint32_t k = i; k < i + 8; k++) {
            numbers[listed] =
                (uint16_t)k; /* written over by the next where there is nothing to list */
            listed += flags[k];
        }
    }
    return listed;
}

/* The eights in which a flag is set. */
static uint32_t list_eights(const uint8_t *flags, uint32_t count, uint16_t *numbers) {
    uint32_t listed = 0;
    for (uint32_t i = 0; i < norma_core_block_eights(count); i++) {
        uint64_t eight;
        memcpy(&eight, flags + (size_t)i * CORE_LANES, sizeof eight);
        numbers[listed] = (uint16_t)i;
        listed += eight != 0;
    }
    return listed;
}

/* The vertices of a block that moved. */
static uint32_t list_marked_groups(
    const uint64_t *bits, size_t begin, uint32_t count, uint16_t *numbers) {
    uint32_t listed = 0;
    for (uint32_t i = 0; i < count; i += 64 - (uint32_t)((begin + i) % 64)) {
        const uint32_t shift = (uint32_t)((begin + i) % 64),
                       left = count - i < 64 - shift ? count - i : 64 - shift;
        uint64_t word = bits[(begin + i) / 64] >> shift << (64 - left) >> (64 - left);
        for (; word; word &= word - 1)
            numbers[listed++] = (uint16_t)(i + (uint32_t)__builtin_ctzll(word));
    }
    return listed;
}

static void touch_triangles(const block_view *t, uint32_t group, uint8_t *touched) {
    const uint32_t end = norma_core_block_start(t, group + 1);
    const uint16_t *corners = t->corners,
                   *members = t->members; /* flags are bytes, and might be anything to a compiler */
    for (uint32_t m = norma_core_block_start(t, group); m < end; m++) {
        const uint16_t *at = corners + 3 * (size_t)(members[m] & (BLOCK_FACES - 1U));
        const uint16_t a = at[0], b = at[1], c = at[2];
        touched[a] = touched[b] = touched[c] = 1;
    }
}

static void touch_polygons(
    const block_view *t, uint32_t group, uint8_t *face_is_moved, uint8_t *touched) {
    const uint32_t end = norma_core_block_start(t, group + 1);
    for (uint32_t m = norma_core_block_start(t, group); m < end; m++) {
        const uint32_t face = norma_core_block_face_of(t, t->members[m]);
        for (uint32_t c = t->face_starts[face];
             c < t->face_starts[face + 1] && !face_is_moved[face]; c++)
            touched[t->corners[c]] = 1;
        face_is_moved[face] = 1;
    }
}

/* The same of all moved vertices, where each group has a position, and each position a vertex, to
 * itself: a vertex's flag is its group's, and those of vertices that are not own are nobody's. */
static void touch_plain(const uint16_t *moved, uint32_t count, const block_view *t,
    uint8_t *face_is_moved, block_touch *touch) {
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t v = moved[i],
                       group = v < t->own_count ? v : t->group_count + v - t->own_count;
        touch->group_is_touched[v] = 1;
        if (t->face_starts)
            touch_polygons(t, group, face_is_moved, touch->group_is_touched);
        else
            touch_triangles(t, group, touch->group_is_touched);
    }
    memset(
        touch->group_is_touched + t->own_count, 0, sizeof touch->group_is_touched - t->own_count);
}

static void list_touched(const block_view *t, block_touch *touch) {
    uint8_t needed[BLOCK_FACES + 8];
    memset(needed, 0, sizeof needed);
    touch->group_count = list_flags(touch->group_is_touched, t->group_count, touch->groups);
    for (uint32_t i = 0; i < touch->group_count; i++) {
        const uint32_t s = touch->groups[i], end = norma_core_block_start(t, s + 1);
        for (uint32_t m = norma_core_block_start(t, s); m < end; m++)
            needed[norma_core_block_face_of(t, t->members[m])] = 1;
    }
    touch->face_count = t->corner_faces ? list_flags(needed, t->face_count, touch->faces)
                                        : list_eights(needed, t->face_count, touch->faces);
}

static block_moved core_block_moved(const block_marks *marks, const plan_block *block) {
    const size_t begin = block->first_occurrence - marks->first_occurrence;
    if (!any_marked(marks->bits, begin, begin + block->vertex_count)) return BLOCK_NOT_MOVED;
    return count_marked(marks->bits, begin, begin + block->vertex_count) == block->vertex_count
               ? BLOCK_ALL_MOVED
               : BLOCK_PARTLY_MOVED;
}

/* Of a block that has moved in part, the groups whose normals may change, and the faces that vote
 * in them. */
static void core_block_touch(
    const block_marks *marks, const block_view *t, norma_element of, block_touch *touch) {
    uint16_t moved[BLOCK_VERTICES];
    uint8_t face_is_moved[BLOCK_FACES];
    const uint32_t count = list_marked_groups(
        marks->bits, t->first_occurrence - marks->first_occurrence, t->vertex_count, moved);
    memset(touch->group_is_touched, 0, sizeof touch->group_is_touched);
    if (!t->plain || t->face_starts) memset(face_is_moved, 0, sizeof face_is_moved);
    if (t->plain) touch_plain(moved, count, t, face_is_moved, touch);
    for (uint32_t i = 0; i < count && !t->plain; i++) {
        if (moved[i] < t->own_count && of == NORMA_PER_VERTEX)
            touch->group_is_touched[norma_core_block_group_of(t, moved[i])] = 1;
        touch_faces_of_vertex(t, moved[i], face_is_moved, touch);
    }
    list_touched(t, touch);
}

/* Whether the normal of a member's corner (its vertex) is written: by a group of this block, and
 * one of those that are written (NULL: all). */
static int core_block_writes(
    const block_view *t, norma_element of, uint32_t member, const uint8_t *group_is_written) {
    const uint32_t vertex = t->corners[norma_core_block_corner_of(t, member)];
    if (vertex >= t->own_count) return 0;
    if (!group_is_written) return 1;
    if (of == NORMA_PER_VERTEX) return group_is_written[norma_core_block_group_of(t, vertex)];
    uint32_t group = first_group(t, vertex);
    do {
        if (group_is_written[group] && has_member(t, group, member)) return 1;
    } while (joined_lists(t, ++group));
    return 0;
}

/* ---- Free threads take one block after the other, read its positions, measure its
 * faces, sum its groups and write its normals. */

/* With fewer to do than FEWEST_BLOCKS_TO_SHARE nobody is called for help; tasks are small, so that
 * all end at about the same time. */
enum { FEWEST_BLOCKS_TO_SHARE = 64, BLOCKS_IN_TASK = 16 };

typedef struct blocks_work {
    plan_work *work;
    block_kernels kernels;
    block_marks marks;
    size_t tasks, first, count; /* blocks */
    core_tally tallies[PLAN_MOST_TASKS];
} blocks_work;

/* ---- in */

static void load_block_position(
    const core_mesh *mesh, const block_view *t, uint32_t vertex, block_room *room) {
    double *position = room->positions[vertex];
    norma_core_position(mesh, t->vertices[vertex], position);
    position[3] = 0;
    room->all_finite &= norma_core_finite(position);
}

/* Of all vertices, or of those of some eights of triangles (NULL: all). */
static void load_each(
    const core_mesh *mesh, const block_view *t, const block_some *eights, block_room *room) {
    room->all_finite = 1;
    for (uint32_t v = 0; v < t->vertex_count && !eights; v++) load_block_position(mesh, t, v, room);
    for (uint32_t i = 0; eights && i < eights->count; i++)
        for (uint32_t c = 0; c < 3 * CORE_LANES; c++)
            load_block_position(mesh, t, t->corners[3 * CORE_LANES * eights->numbers[i] + c], room);
}

/* Those of some faces at least, among them the vertices of all groups in which they vote. A vertex
 * is loaded once for each corner where there are few. */
static void load_positions(
    const blocks_work *w, const block_view *t, block_some faces, block_room *room) {
    const norma_vec3_view *from = &w->work->mesh.positions;
    const block_some *eights =
        !t->corner_faces && faces.numbers && 9 * faces.count < t->vertex_count ? &faces : NULL;
    if (from->format != NORMA_FORMAT_FLOAT)
        load_each(&w->work->mesh, t, eights, room);
    else
        room->all_finite = w->kernels.load(t, eights, from->data, from->stride, room->positions);
}

static block_list list_between(const void *begin, const void *end) {
    return (block_list){begin, end};
}

/* What will be read of the next block, and written of this one, and the names of the vertices of
 * the one after. */
static block_ahead ahead_of_block(const blocks_work *w, const block_view *t, size_t number) {
    const plan_work *work = w->work;
    const size_t last = w->first + w->count - 1;
    const block_view next = norma_core_block(work->plan, number < last ? number + 1 : last),
                     after = norma_core_block(work->plan, number + 1 < last ? number + 2 : last);
    block_ahead ahead = {
        .lists = {list_between(after.vertices, after.vertices + after.vertex_count),
            list_between(next.corners, next.corners + next.corner_count)},
        .read = {next.vertices, next.vertex_count, work->mesh.positions.data,
            work->mesh.positions.stride},
    };
    if (next.fours) ahead.lists[2] = list_between(next.four_counts, next.fours + next.four_count);
    if (work->plan->of == NORMA_PER_VERTEX)
        ahead.written = (block_elements){
            t->vertices, t->own_count, work->output->normals, work->output->stride};
    return ahead;
}

static core_mesh local_mesh(const block_view *t, const block_room *room) {
    return (core_mesh){
        .positions = {&room->positions, t->vertex_count, sizeof room->positions[0],
            NORMA_FORMAT_DOUBLE},
        .corners = t->corners,
        .corner_count = t->corner_count,
        .corner_size = sizeof *t->corners,
        .face_starts = t->face_starts,
        .face_count = t->face_count,
        .scale = 1,
        .weld = t->weld,
    };
}

/* ---- faces that are not triangles, or that doubles do not decide */

static void keep_face_of_block(const core_mesh *mesh, norma_weight weight, const block_view *t,
    uint32_t number, block_room *room) {
    core_face face;
    const uint32_t begin = (uint32_t)norma_core_face_begin(mesh, number),
                   end = (uint32_t)norma_core_face_end(mesh, number);
    norma_core_face_geometry(mesh, number, &face);
    const int directed = (face.flags & CORE_FACE_DIRECTED) != 0;
    for (int k = 0; k < 3; k++) room->normals[number][k] = directed ? face.normal[k] : 0;
    room->normals[number][3] = 1;
    for (uint32_t c = begin; c < end; c++)
        room->weights[norma_core_block_member(t->corner_faces != NULL, number, c - begin, c)] =
            directed && norma_core_is_kept(mesh, number, c)
                ? norma_core_corner_weight(mesh, weight, number, &face, c)
                : -0.0;
    if (!directed && (face.flags & CORE_FACE_FINITE))
        room->degenerate[room->degenerate_count++] = (uint16_t)number;
}

static int block_face_has_edges(const block_view *t, uint32_t face) {
    const uint16_t *at = t->corners + 3 * (size_t)face;
    const uint32_t a = t->weld[at[0]], b = t->weld[at[1]], c = t->weld[at[2]];
    return a != b && b != c && c != a;
}

/* Corners at one position of the plan may have parted: such a triangle has no vote, whatever it
 * measures. */
static void measure_welded(const core_mesh *mesh, norma_weight weight, const block_view *t,
    block_some eights, block_room *room) {
    for (uint32_t i = 0; i < eights.count; i++)
        for (uint32_t face = CORE_LANES * (eights.numbers ? eights.numbers[i] : i),
                      end = face + CORE_LANES;
             face < end && face < t->face_count; face++)
            if (!block_face_has_edges(t, face)) keep_face_of_block(mesh, weight, t, face, room);
}

/* faces: triangles by eights. */
static void measure_block_faces(
    const blocks_work *w, const block_view *t, block_some faces, block_room *room) {
    const core_mesh mesh = local_mesh(t, room);
    const norma_weight weight = w->work->call->options.weight;
    room->doubted_count = room->degenerate_count = 0;
    if (t->corner_faces) {
        for (uint32_t i = 0; i < faces.count; i++)
            keep_face_of_block(&mesh, weight, t, faces.numbers ? faces.numbers[i] : i, room);
        return;
    }
    memcpy(room->normals[BLOCK_NOBODY], (const double[4]){0, 0, 0, 1},
        sizeof room->normals[BLOCK_NOBODY]);
    room->weights[BLOCK_NOBODY] = -0.0;
    w->kernels.measure(t, faces, weight, room);
    for (uint32_t i = 0; i < room->doubted_count; i++)
        if (!t->weld || block_face_has_edges(t, room->doubted[i]))
            keep_face_of_block(&mesh, weight, t, room->doubted[i], room);
    if (t->weld) measure_welded(&mesh, weight, t, faces, room);
}

/* ---- sums that ask for more */

typedef struct block_cone {
    const block_view *t;
    const block_room *room;
    uint32_t first, vertex;
} block_cone; /* vertex: UINT32_MAX, or alone */

static int block_cone_normal(const void *context, size_t index, double normal[3]) {
    const block_cone *c = context;
    const uint32_t member = c->t->members[c->first + index];
    if (c->vertex != UINT32_MAX &&
        c->t->corners[norma_core_block_corner_of(c->t, member)] != c->vertex)
        return 0;
    memcpy(normal, c->room->normals[norma_core_block_face_of(c->t, member)], 3 * sizeof *normal);
    return !signbit(c->room->weights[member]);
}

static int decide_group_cone(const block_view *t, const block_room *room, uint32_t group,
    uint32_t vertex, double weight, float normal[3]) {
    const uint32_t first = norma_core_block_start(t, group);
    const block_cone cone = {t, room, first, vertex};
    return core_plan_decide_cone(
        weight, block_cone_normal, &cone, norma_core_block_start(t, group + 1) - first, normal);
}

/* Sums tell who has votes. */
static void decide_group_cones(const block_view *t, block_some groups, block_room *room) {
    room->all_normal = 0;
    for (uint32_t i = 0; i < groups.count; i++) {
        if (room->reasons[i] == NORMA_REASON_UNREFERENCED) continue;
        room->reasons[i] = (uint8_t)decide_group_cone(
            t, room, groups.numbers ? groups.numbers[i] : i, UINT32_MAX, 1, room->results[i]);
    }
}

/* Of a vertex's own corners alone. */
static int decide_own(const blocks_work *w, const block_view *t, const block_room *room,
    uint32_t group, uint32_t vertex, float normal[3]) {
    double sum[4] = {0, 0, 0, -0.0};
    for (uint32_t i = norma_core_block_start(t, group); i < norma_core_block_start(t, group + 1);
         i++) {
        const uint32_t member = t->members[i];
        if (t->corners[norma_core_block_corner_of(t, member)] != vertex) continue;
        for (int k = 0; k < 4; k++)
            sum[k] += room->weights[member] * room->normals[norma_core_block_face_of(t, member)][k];
    }
    return w->work->call->options.weight == NORMA_WEIGHT_VISIBLE
               ? decide_group_cone(t, room, group, vertex, sum[3], normal)
               : norma_core_plan_decide(sum, normal);
}

/* ---- out */

static int is_vertex_finite(const block_room *room, uint32_t vertex) {
    return room->all_finite || norma_core_finite(room->positions[vertex]);
}

typedef struct block_result {
    uint32_t group;
    int reason;
    float normal[3];
} block_result;

static block_result result_at(const block_room *room, block_some groups, uint32_t i) {
    return (block_result){groups.numbers ? groups.numbers[i] : i, room->reasons[i],
        {room->results[i][0], room->results[i][1], room->results[i][2]}};
}

static void write_block_vertex(const blocks_work *w, const block_view *t, const block_room *room,
    const block_result *result, uint32_t vertex, core_tally *tally) {
    block_result own = *result;
    if (!is_vertex_finite(room, vertex))
        own.reason = NORMA_REASON_NON_FINITE;
    else if (own.reason == NORMA_REASON_CANCELLED &&
             decide_own(w, t, room, own.group, vertex, own.normal) == NORMA_REASON_NONE)
        own.reason = NORMA_REASON_NONE;
    norma_core_write_element(w->work->output, t->vertices[vertex], own.reason, own.normal, tally);
}

static void write_block_vertices(const blocks_work *w, const block_view *t, const block_room *room,
    block_some groups, core_tally *tally) {
    for (uint32_t i = 0; i < groups.count; i++) {
        const block_result result = result_at(room, groups, i);
        const uint32_t begin = t->vertex_starts ? t->vertex_starts[result.group] : result.group,
                       end = t->vertex_starts ? t->vertex_starts[result.group + 1] : begin + 1;
        for (uint32_t v = begin; v < end; v++) write_block_vertex(w, t, room, &result, v, tally);
    }
}

/* Nearly all blocks: a vertex for each group, all of them with a normal, and nobody asks for
 * reasons.
 */
static void write_plain(
    const blocks_work *w, const block_view *t, const block_room *room, block_some groups) {
    for (uint32_t i = 0; i < groups.count; i++)
        norma_core_write_normal(
            w->work->output, t->vertices[groups.numbers ? groups.numbers[i] : i], room->results[i]);
}

static int is_written_plain(const blocks_work *w, const block_view *t, const block_room *room) {
    return room->all_finite && room->all_normal && !t->group_of && !w->work->output->reasons;
}

static void write_block_corners(const blocks_work *w, const block_view *t, const block_room *room,
    block_some groups, core_tally *tally) {
    for (uint32_t i = 0; i < groups.count; i++) {
        const block_result result = result_at(room, groups, i);
        for (uint32_t m = norma_core_block_start(t, result.group);
             m < norma_core_block_start(t, result.group + 1); m++) {
            const uint32_t member = t->members[m],
                           vertex = t->corners[norma_core_block_corner_of(t, member)];
            norma_core_write_element(w->work->output, norma_core_block_mesh_corner(t, member),
                is_vertex_finite(room, vertex) ? result.reason : NORMA_REASON_NON_FINITE,
                result.normal, tally);
        }
    }
}

/* A face without a direction is counted where the normal of its first corner is written. */
static void count_degenerate_of_block(const blocks_work *w, const block_view *t,
    const block_room *room, const uint8_t *group_is_written, core_tally *tally) {
    for (uint32_t i = 0; i < room->degenerate_count; i++) {
        const uint32_t face = room->degenerate[i],
                       begin = t->face_starts ? t->face_starts[face] : 3 * face;
        const uint32_t member = norma_core_block_member(t->corner_faces != NULL, face, 0, begin);
        if (t->face_starts && t->face_starts[face + 1] == begin) continue;
        if (core_block_writes(t, w->work->plan->of, member, group_is_written))
            norma_core_count_one(&tally->degenerate, t->faces[face]);
    }
}

/* ---- blocks */

static void update_block(const blocks_work *w, const block_view *t, const block_touch *touch,
    const block_ahead *ahead, core_tally *tally) {
    block_room room;
    room.ahead = *ahead;
    const block_some faces = {
        touch ? touch->faces : NULL, touch             ? touch->face_count
                                     : t->corner_faces ? t->face_count
                                                       : norma_core_block_eights(t->face_count)};
    const block_some groups = {
        touch ? touch->groups : NULL, touch ? touch->group_count : t->group_count};
    load_positions(w, t, faces, &room);
    measure_block_faces(w, t, faces, &room);
    room.all_normal = w->kernels.sum(t, groups, &room);
    if (w->work->call->options.weight == NORMA_WEIGHT_VISIBLE) decide_group_cones(t, groups, &room);
    if (w->work->plan->of == NORMA_PER_CORNER)
        write_block_corners(w, t, &room, groups, tally);
    else if (is_written_plain(w, t, &room))
        write_plain(w, t, &room, groups);
    else
        write_block_vertices(w, t, &room, groups, tally);
    if (room.degenerate_count)
        count_degenerate_of_block(w, t, &room, touch ? touch->group_is_touched : NULL, tally);
}

static void update_whole(const blocks_work *w, size_t i, core_tally *tally) {
    const block_view t = norma_core_block(w->work->plan, i);
    const block_ahead ahead = ahead_of_block(w, &t, i);
    update_block(w, &t, NULL, &ahead, tally);
}

static void update_part(const blocks_work *w, size_t i, core_tally *tally) {
    const block_view t = norma_core_block(w->work->plan, i);
    const block_ahead nothing = {0};
    block_touch touch;
    core_block_touch(&w->marks, &t, w->work->plan->of, &touch);
    if (touch.group_count) update_block(w, &t, &touch, &nothing, tally);
}

static void update_some_blocks(void *context, size_t task) {
    blocks_work *w = context;
    const plan_range range = norma_core_plan_range(w->count, w->tasks, task);
    for (size_t i = w->first + range.begin; i < w->first + range.end; i++) {
        const block_moved moved = w->work->moved
                                      ? core_block_moved(&w->marks, &w->work->plan->blocks[i])
                                      : BLOCK_ALL_MOVED;
        if (moved == BLOCK_ALL_MOVED)
            update_whole(w, i, &w->tallies[task]);
        else if (moved == BLOCK_PARTLY_MOVED)
            update_part(w, i, &w->tallies[task]);
    }
}

/* busy: how many blocks there is something to do in. */
static norma_result run_blocks(blocks_work *w, size_t first, size_t count, size_t busy) {
    w->first = first;
    w->count = count;
    w->tasks = busy < FEWEST_BLOCKS_TO_SHARE ? 1 : busy / BLOCKS_IN_TASK;
    if (w->tasks > PLAN_MOST_TASKS) w->tasks = PLAN_MOST_TASKS;
    memset(w->tallies, 0, w->tasks * sizeof *w->tallies);
    const norma_result result = norma_core_parallel(w->work->call, w->tasks, update_some_blocks, w);
    for (size_t i = 0; i < w->tasks; i++) norma_core_tally_add(w->work->tally, &w->tallies[i]);
    return result;
}

static norma_result update_moved_blocks(blocks_work *w) {
    norma_result result = NORMA_OK;
    core_marks_open(w->work, &w->marks);
    while (result == NORMA_OK && core_marks_next(w->work, &w->marks))
        if (w->marks.busy)
            result = run_blocks(w, w->marks.first_block, w->marks.block_count, w->marks.busy);
    core_marks_close(w->work, &w->marks);
    return result;
}

static norma_result core_plan_update_blocks(plan_work *work) {
    blocks_work w = {.work = work};
    const size_t count = work->plan->block_count;
    if (!count) return NORMA_OK;
    w.kernels = norma_core_block_kernels(work->call->options.isa);
    return work->moved ? update_moved_blocks(&w) : run_blocks(&w, 0, count, count);
}

static void core_plan_block_vertices(const norma_plan *plan, uint32_t *vertices) {
    for (size_t i = 0; i < plan->block_count; i++) {
        const block_view t = norma_core_block(plan, i);
        for (uint32_t m = 0; m < t.member_count; m++)
            vertices[norma_core_block_mesh_corner(&t, t.members[m])] =
                t.vertices[t.corners[norma_core_block_corner_of(&t, t.members[m])]];
    }
}

/* ---- Sums of overflow groups. Each streams through the faces that vote in it and keeps
 * nothing but its sum, so that it needs no memory however many there are. */

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
    return core_plan_decide_cone(sum[3], overflow_cone_normal, &cone,
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

static void mark_number(uint64_t *bits, size_t i) { bits[i / 64] |= (uint64_t)1 << (i % 64); }

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
            mark_number(bits, face - first);
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
            mark_number(store->touched, group - store->first);
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

/* Of each corner of its faces the vertex, by the corner's number in the mesh. */
static void core_plan_overflow_vertices(const norma_plan *plan, uint32_t *vertices) {
    const overflow_group *overflow = &plan->overflow;
    for (size_t c = 0; c < overflow->corner_count; c++)
        vertices[overflow->mesh_corners[c]] = overflow->corners[c];
}

/* ---- norma_plan_update. Nothing of the plan is written: updates of one plan may run at
 * once. */

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
    norma_result result = core_plan_update_blocks(work);
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
        core_plan_block_vertices(plan, scratch.vertices);
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
