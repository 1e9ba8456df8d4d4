/* plan_tile_moved.c: see plan_tile_moved.h. What a position that moves can change: the faces that name it, and so the sums in which their corners vote. */
#include "plan_tile_moved.h"

static void mark(uint64_t *bits, size_t i) { bits[i / 64] |= (uint64_t)1 << (i % 64); }
static int marked(const uint64_t *bits, size_t i) { return (int)(bits[i / 64] >> (i % 64) & 1); }

/* ---- which vertices of which tiles moved */

static void mark_block(const plan_work *work, tile_marks *marks, uint32_t count)
{
    const norma_plan *plan = work->plan;
    memset(marks->bits, 0, (count + 63) / 64 * sizeof *marks->bits);
    for (size_t i = 0; i < work->moved_count; i++)
        for (uint32_t at = plan->occurrence_starts[work->moved[i]]; at < plan->occurrence_starts[work->moved[i] + 1]; at++) {
            const uint32_t number = plan->occurrences[at] - marks->first_occurrence;
            if (plan->occurrences[at] >= marks->first_occurrence && number < count) mark(marks->bits, number);
        }
}

static int any_marked(const tile_marks *marks, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i += 64 - i % 64) {
        const uint64_t bits = marks->bits[i / 64] >> (i % 64);
        const size_t left = end - i < 64 - i % 64 ? end - i : 64 - i % 64;
        if (bits << (64 - left)) return 1;
    }
    return 0;
}

static uint32_t occurrences_before(const norma_plan *plan, size_t tile) { return tile < plan->tile_count ? plan->tiles[tile].first_occurrence : (uint32_t)plan->occurrence_count; }

void norma_core_marks_open(const plan_work *work, tile_marks *marks)
{
    marks->first_tile = marks->tile_count = 0;
    marks->bits = marks->own;
    marks->borrowed = work->plan->occurrence_count > MARKS_IN_BLOCK && norma_core_plan_borrow(work->plan);
    if (marks->borrowed) marks->bits = work->plan->shared->bits;
}

int norma_core_marks_next(const plan_work *work, tile_marks *marks)
{
    const norma_plan *plan = work->plan;
    marks->first_tile += marks->tile_count;
    marks->tile_count = marks->busy = 0;
    if (marks->first_tile == plan->tile_count) return 0;
    marks->first_occurrence = occurrences_before(plan, marks->first_tile);
    const size_t room = marks->borrowed ? plan->occurrence_count : MARKS_IN_BLOCK;
    size_t end = marks->first_tile + 1;
    while (end < plan->tile_count && occurrences_before(plan, end + 1) - marks->first_occurrence <= room) end++;
    marks->tile_count = end - marks->first_tile;
    mark_block(work, marks, occurrences_before(plan, end) - marks->first_occurrence);
    for (size_t t = marks->first_tile; t < end; t++)
        marks->busy += (size_t)any_marked(marks, occurrences_before(plan, t) - marks->first_occurrence, occurrences_before(plan, t + 1) - marks->first_occurrence);
    return 1;
}

void norma_core_marks_close(const plan_work *work, tile_marks *marks)
{
    if (marks->borrowed) norma_core_plan_give_back(work->plan);
}

/* ---- what that touches in a tile */

static int joined(const tile_view *t, uint32_t slot) { return slot < t->slot_count && (t->member_starts[slot] & TILE_JOINED); }

static int has_member(const tile_view *t, uint32_t slot, uint32_t member)
{
    for (uint32_t i = norma_core_tile_start(t, slot); i < norma_core_tile_start(t, slot + 1); i++)
        if (t->members[i] == member) return 1;
    return 0;
}

/* The first slot at the position of an own vertex. */
static uint32_t first_slot(const tile_view *t, uint32_t vertex)
{
    uint32_t slot = norma_core_tile_slot_of(t, vertex);
    while (joined(t, slot)) slot--;
    return slot;
}

static void touch_slots_of_face(const tile_view *t, uint32_t face, tile_touch *touch)
{
    const uint32_t begin = t->face_starts ? t->face_starts[face] : 3 * face, end = t->face_starts ? t->face_starts[face + 1] : begin + 3;
    for (uint32_t c = begin; c < end; c++) {
        if (t->corners[c] >= t->own_count) continue;
        const uint32_t member = norma_core_tile_member(t->corner_faces != NULL, face, c - begin, c);
        uint32_t slot = first_slot(t, t->corners[c]);
        if (!joined(t, slot + 1)) {
            touch->slot_is_touched[slot] = 1;
            continue;
        }
        do {
            if (has_member(t, slot, member)) touch->slot_is_touched[slot] = 1;
        } while (joined(t, ++slot));
    }
}

/* The faces that name a vertex: among the members of the slots at its position. */
static void touch_faces_of_vertex(const tile_view *t, uint32_t vertex, uint8_t *face_is_moved, tile_touch *touch)
{
    uint32_t slot = vertex < t->own_count ? first_slot(t, vertex) : t->slot_count + vertex - t->own_count;
    do {
        for (uint32_t i = norma_core_tile_start(t, slot); i < norma_core_tile_start(t, slot + 1); i++) {
            const uint32_t member = t->members[i], face = norma_core_tile_face_of(t, member);
            if (face_is_moved[face] || t->corners[norma_core_tile_corner_of(t, member)] != vertex) continue;
            face_is_moved[face] = 1;
            touch_slots_of_face(t, face, touch);
        }
    } while (joined(t, ++slot));
}

static void list_touched(const tile_view *t, tile_touch *touch)
{
    uint8_t face_is_listed[TILE_FACES];
    memset(face_is_listed, 0, t->face_count);
    for (uint32_t s = 0; s < t->slot_count; s++) {
        if (!touch->slot_is_touched[s]) continue;
        touch->slots[touch->slot_count++] = (uint16_t)s;
        for (uint32_t i = norma_core_tile_start(t, s); i < norma_core_tile_start(t, s + 1); i++) {
            const uint32_t face = norma_core_tile_face_of(t, t->members[i]);
            if (!face_is_listed[face]) touch->faces[touch->face_count++] = (uint16_t)face;
            face_is_listed[face] = 1;
        }
    }
}

int norma_core_tile_touch(const tile_marks *marks, const tile_view *t, norma_element of, tile_touch *touch)
{
    const size_t begin = t->first_occurrence - marks->first_occurrence;
    uint8_t face_is_moved[TILE_FACES];
    if (!any_marked(marks, begin, begin + t->vertex_count)) return 0;
    touch->face_count = touch->slot_count = 0;
    memset(touch->slot_is_touched, 0, t->slot_count);
    memset(face_is_moved, 0, t->face_count);
    for (uint32_t v = 0; v < t->vertex_count; v++) {
        if (!marked(marks->bits, begin + v)) continue;
        if (v < t->own_count && of == NORMA_PER_VERTEX) touch->slot_is_touched[norma_core_tile_slot_of(t, v)] = 1;
        touch_faces_of_vertex(t, v, face_is_moved, touch);
    }
    list_touched(t, touch);
    return touch->slot_count != 0;
}

int norma_core_tile_writes(const tile_view *t, norma_element of, uint32_t member, const uint8_t *slot_is_written)
{
    const uint32_t vertex = t->corners[norma_core_tile_corner_of(t, member)];
    if (vertex >= t->own_count) return 0;
    if (!slot_is_written) return 1;
    if (of == NORMA_PER_VERTEX) return slot_is_written[norma_core_tile_slot_of(t, vertex)];
    uint32_t slot = first_slot(t, vertex);
    do {
        if (slot_is_written[slot] && has_member(t, slot, member)) return 1;
    } while (joined(t, ++slot));
    return 0;
}
