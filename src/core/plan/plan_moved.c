/* plan_moved.c: from vertices that moved to what of each block they touch. What a position that
 * moves can change: the faces that name it, and so the sums in which their corners vote. */
#include "core/plan/plan.h"

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

void norma_core_marks_open(const plan_work *work, block_marks *marks) {
    marks->next_block = 0;
    marks->bits = marks->own;
    marks->borrowed =
        work->plan->occurrence_count > MARKS_IN_BLOCK && norma_core_plan_borrow(work->plan);
    if (marks->borrowed) marks->bits = work->plan->shared->bits;
}

int norma_core_marks_next(const plan_work *work, block_marks *marks) {
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

void norma_core_marks_close(const plan_work *work, block_marks *marks) {
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

block_moved norma_core_block_moved(const block_marks *marks, const plan_block *block) {
    const size_t begin = block->first_occurrence - marks->first_occurrence;
    if (!any_marked(marks->bits, begin, begin + block->vertex_count)) return BLOCK_NOT_MOVED;
    return count_marked(marks->bits, begin, begin + block->vertex_count) == block->vertex_count
               ? BLOCK_ALL_MOVED
               : BLOCK_PARTLY_MOVED;
}

void norma_core_block_touch(
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

int norma_core_block_writes(
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
