/* smoothing_groups.c: smoothing groups of any number of numbers, as the core's masks of 32 bits.
 *
 * Up to 32 groups get a bit each. Of more, only faces that meet at an edge matter to one another:
 * the faces of one group that hang together by edges are a patch, and patches that meet are
 * coloured so that no two of them share a colour, greedily, with 31 colours. Where more would be
 * needed, the patch gets the last bit, and its borders are marked hard. Meeting is judged by the
 * core's own welding, so that it is what the core will see. */
#include <stdlib.h>
#include <string.h>
#include "core/mesh/weld.h"
#include "io/obj/obj.h"

enum { COLOURS = 31 };

static int compare_numbers(const void *a, const void *b) {
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return x < y ? -1 : x > y;
}

/* The groups other than 0 that faces lie in, each once, ascending; NULL: out of memory. */
static int64_t *distinct_groups(const obj_state *state, size_t *count) {
    int64_t *groups = norma_io_allocate(state->run_count + 1, sizeof *groups);
    size_t used = 0;
    if (!groups) return NULL;
    for (size_t i = 0; i < state->run_count; ++i) {
        size_t end = i + 1 < state->run_count ? state->runs[i + 1].first_face : state->face_count;
        if (state->runs[i].group && end > state->runs[i].first_face)
            groups[used++] = state->runs[i].group;
    }
    qsort(groups, used, sizeof *groups, compare_numbers);
    *count = 0;
    for (size_t i = 0; i < used; ++i)
        if (i == 0 || groups[i] != groups[i - 1]) groups[(*count)++] = groups[i];
    return groups;
}

/* For each face its group's place among the distinct ones, from 1, or 0. */
static void number_faces(
    const obj_state *state, const int64_t *groups, size_t count, uint32_t *numbers) {
    for (size_t i = 0; i < state->run_count; ++i) {
        size_t end = i + 1 < state->run_count ? state->runs[i + 1].first_face : state->face_count;
        const int64_t *found = state->runs[i].group ? bsearch(&state->runs[i].group, groups, count,
                                                          sizeof *groups, compare_numbers)
                                                    : NULL;
        for (size_t face = state->runs[i].first_face; face < end; ++face)
            numbers[face] = found ? (uint32_t)(found - groups) + 1 : 0;
    }
}

/* A face along an edge. */
typedef struct side {
    uint32_t low, high; /* the edge's two positions, welded */
    uint32_t group, face, corner;
} side;

static int compare_sides(const void *a, const void *b) {
    const side *x = a, *y = b;
    if (x->low != y->low) return x->low < y->low ? -1 : 1;
    if (x->high != y->high) return x->high < y->high ? -1 : 1;
    if (x->group != y->group) return x->group < y->group ? -1 : 1;
    return x->corner < y->corner ? -1 : x->corner > y->corner;
}

typedef struct patches {
    const obj_state *state;
    uint32_t *numbers; /* of each face; masks at the end */
    side *sides;
    size_t side_count;
    uint32_t *root;  /* of each face, a forest towards lower faces */
    uint8_t *colour; /* of each root */
    uint64_t *pairs; /* roots that meet, each way */
    size_t pair_count, pair_room;
    uint8_t *hard;
} patches;

static void list_sides(patches *p, const core_mesh *mesh) {
    const obj_state *state = p->state;
    for (size_t face = 0; face < state->face_count; ++face) {
        size_t begin = norma_obj_face_start(state, face),
               end = norma_obj_face_start(state, face + 1);
        for (size_t c = begin; c < end && p->numbers[face]; ++c) {
            uint32_t a = norma_core_welded(mesh, state->corners[c]);
            uint32_t b = norma_core_welded(mesh, state->corners[c + 1 < end ? c + 1 : begin]);
            if (a != b)
                p->sides[p->side_count++] = (side){
                    a < b ? a : b, a < b ? b : a, p->numbers[face], (uint32_t)face, (uint32_t)c};
        }
    }
    qsort(p->sides, p->side_count, sizeof *p->sides, compare_sides);
}

static uint32_t root_of(patches *p, uint32_t face) {
    while (p->root[face] != face) face = p->root[face] = p->root[p->root[face]];
    return face;
}

static size_t edge_end(const patches *p, size_t begin) {
    size_t end = begin + 1;
    while (end < p->side_count && p->sides[end].low == p->sides[begin].low &&
           p->sides[end].high == p->sides[begin].high)
        ++end;
    return end;
}

static void join_patches(patches *p) {
    for (size_t i = 1; i < p->side_count; ++i) {
        const side *a = &p->sides[i - 1], *b = &p->sides[i];
        if (a->low != b->low || a->high != b->high || a->group != b->group) continue;
        uint32_t x = root_of(p, a->face), y = root_of(p, b->face);
        p->root[x < y ? y : x] = x < y ? x : y;
    }
}

/* The first side of each group at an edge, at most most of them; how many there are. */
static size_t groups_at_edge(
    const patches *p, size_t begin, size_t end, size_t *first, size_t most) {
    size_t count = 0;
    for (size_t i = begin; i < end; ++i)
        if (i == begin || p->sides[i].group != p->sides[i - 1].group) {
            if (count < most) first[count] = i;
            ++count;
        }
    return count;
}

/* Lists the patches that meet; edges of more groups than there are colours are hard. */
static int list_pairs(patches *p) {
    size_t first[COLOURS];
    for (size_t begin = 0, end; begin < p->side_count; begin = end) {
        end = edge_end(p, begin);
        size_t count = groups_at_edge(p, begin, end, first, COLOURS);
        if (count > COLOURS) {
            for (size_t i = begin; i < end; ++i) p->hard[p->sides[i].corner] = 1;
            continue;
        }
        void *grown =
            norma_io_grow(p->pairs, &p->pair_room, p->pair_count + count * count, sizeof *p->pairs);
        if (!grown) return 0;
        p->pairs = grown;
        for (size_t i = 0; i < count; ++i)
            for (size_t k = 0; k < count; ++k)
                if (i != k)
                    p->pairs[p->pair_count++] = (uint64_t)root_of(p, p->sides[first[i]].face)
                                                    << 32 |
                                                root_of(p, p->sides[first[k]].face);
    }
    return 1;
}

static int compare_pairs(const void *a, const void *b) {
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return x < y ? -1 : x > y;
}

static void colour_patches(patches *p) {
    if (p->pair_count > 0) qsort(p->pairs, p->pair_count, sizeof *p->pairs, compare_pairs);
    for (size_t i = 0; i < p->pair_count;) {
        uint32_t patch = (uint32_t)(p->pairs[i] >> 32), taken = 0;
        for (; i < p->pair_count && (uint32_t)(p->pairs[i] >> 32) == patch; ++i)
            if ((uint32_t)p->pairs[i] < patch)
                taken |= UINT32_C(1) << p->colour[(uint32_t)p->pairs[i]];
        while (p->colour[patch] < COLOURS && taken >> p->colour[patch] & 1) ++p->colour[patch];
    }
}

/* The borders of patches for which no colour was left. */
static void mark_borders(patches *p) {
    for (size_t begin = 0, end; begin < p->side_count; begin = end) {
        end = edge_end(p, begin);
        if (p->sides[begin].group == p->sides[end - 1].group) continue;
        for (size_t i = begin; i < end; ++i)
            if (p->colour[root_of(p, p->sides[i].face)] == COLOURS) p->hard[p->sides[i].corner] = 1;
    }
}

static norma_result colour_groups(patches *p, const core_mesh *mesh) {
    size_t faces = p->state->face_count;
    p->sides = norma_io_allocate(p->state->corner_count, sizeof *p->sides);
    p->root = norma_io_allocate(faces, sizeof *p->root);
    p->colour = norma_io_allocate(faces, 1);
    if (!p->sides || !p->root || !p->colour) return NORMA_ERROR_MEMORY;
    for (size_t face = 0; face < faces; ++face) p->root[face] = (uint32_t)face;
    list_sides(p, mesh);
    join_patches(p);
    if (!list_pairs(p)) return NORMA_ERROR_MEMORY;
    colour_patches(p);
    mark_borders(p);
    for (size_t face = 0; face < faces; ++face)
        p->numbers[face] =
            p->numbers[face] ? UINT32_C(1) << p->colour[root_of(p, (uint32_t)face)] : 0;
    return NORMA_OK;
}

/* More than 32 groups: colours for patches, over positions welded as the options ask. */
static norma_result mask_many(obj_state *state, const norma_options *options) {
    core_call call;
    core_mesh mesh;
    norma_options quiet = *options;
    quiet.progress = NULL;
    norma_mesh view = norma_obj_mesh(state);
    norma_result result = norma_core_begin(&call, &quiet);
    if (!result) result = norma_core_mesh_shape(&view, &mesh);
    if (!result) result = norma_core_mesh_content(&call, &mesh);
    if (!result) result = norma_core_weld(&call, &mesh);
    if (result) return result;
    patches p = {.state = state,
        .numbers = state->group_masks,
        .hard = norma_io_allocate(state->corner_count, 1)};
    result = p.hard ? colour_groups(&p, &mesh) : NORMA_ERROR_MEMORY;
    free(p.sides);
    free(p.root);
    free(p.colour);
    free(p.pairs);
    norma_core_unweld(&call, &mesh);
    state->hard_edges = p.hard;
    return result;
}

norma_result norma_obj_groups(obj_state *state, const norma_options *options) {
    size_t count;
    int64_t *groups = distinct_groups(state, &count);
    free(state->group_masks);
    free(state->hard_edges);
    state->hard_edges = NULL;
    state->group_masks = norma_io_allocate(state->face_count, sizeof *state->group_masks);
    if (!groups || !state->group_masks) {
        free(groups);
        return NORMA_ERROR_MEMORY;
    }
    number_faces(state, groups, count, state->group_masks);
    free(groups);
    if (count > 32) return mask_many(state, options);
    for (size_t face = 0; face < state->face_count; ++face)
        if (state->group_masks[face])
            state->group_masks[face] = UINT32_C(1) << (state->group_masks[face] - 1);
    return NORMA_OK;
}
