/* face_block_update.c: free threads take one block after the other, read its positions, measure its
 * faces, sum its groups and write its normals; of blocks that moved in part, what that touches. */
#include "core/plan/plan.h"

/* ---- from vertices that moved to what of each block they touch. What a position that moves can
 * change: the faces that name it, and so the sums in which their corners vote. */

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
            norma_core_mark_bit(marks->bits, number);
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

/* Marks what moved in the next blocks; 0 where none are left. */
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

/* ---- free threads take one block after the other, read its positions, measure its faces, sum its
 * groups and write its normals. */

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
    return norma_core_plan_decide_cone(
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

norma_result norma_core_plan_update_blocks(plan_work *work) {
    blocks_work w = {.work = work};
    const size_t count = work->plan->block_count;
    if (!count) return NORMA_OK;
    w.kernels = norma_core_block_kernels(work->call->options.isa);
    return work->moved ? update_moved_blocks(&w) : run_blocks(&w, 0, count, count);
}

void norma_core_plan_block_vertices(const norma_plan *plan, uint32_t *vertices) {
    for (size_t i = 0; i < plan->block_count; i++) {
        const block_view t = norma_core_block(plan, i);
        for (uint32_t m = 0; m < t.member_count; m++)
            vertices[norma_core_block_mesh_corner(&t, t.members[m])] =
                t.vertices[t.corners[norma_core_block_corner_of(&t, t.members[m])]];
    }
}
