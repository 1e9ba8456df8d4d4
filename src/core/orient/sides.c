/* sides.c: which faces are turned: those of closed parts by volume and nesting, as orient.c turns
 * them; those of open parts by rays from each piece whose faces agree. */
#include "core/orient/orient.h"
#include <string.h>

static const uint8_t NOT_CLOSED = COMPONENT_OPEN | COMPONENT_ONE_SIDED | COMPONENT_UNBALANCED;

enum { UNASKED = 0, RIGHT, TURNED, UNDECIDED }; /* what is known of a piece */

/* ---- opening */

static void turn_inward_parts(core_components *c) {
    for (size_t i = 0; i < c->count; i++)
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; k++)
            c->reverse[c->faces[k]] ^= c->each[i].verdict == COMPONENT_INWARD;
}

static norma_result find_parts(core_side_judge *j) {
    core_topology *t = &j->topology;
    const core_topology_visitor nobody = {NULL, NULL, NULL, NULL};
    norma_result result = norma_core_pair_edges(t, &nobody);
    if (result == NORMA_OK) result = norma_core_find_components(t, CORE_JOIN_CUT, &j->parts);
    if (result != NORMA_OK) return result;
    result = norma_core_measure_components(t, &j->parts, NOT_CLOSED);
    if (result == NORMA_OK) result = norma_core_judge_nesting(t, &j->parts, NOT_CLOSED);
    if (result == NORMA_OK) result = norma_core_find_components(t, CORE_JOIN_ALIKE, &j->pieces);
    if (result != NORMA_OK) return result;
    turn_inward_parts(&j->parts);
    j->room = j->pieces.count + 1;
    j->known = norma_core_allocate(&j->call, j->room, 1);
    if (j->known) memset(j->known, UNASKED, j->room);
    return j->known ? NORMA_OK : NORMA_ERROR_MEMORY;
}

norma_result norma_core_side_judge_open(
    const norma_mesh *mesh, const norma_options *options, core_side_judge *judge) {
    core_mesh checked;
    *judge = (core_side_judge){.room = 0};
    norma_result result = norma_core_begin(&judge->call, options);
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked);
    if (result == NORMA_OK) result = norma_core_mesh_content(&judge->call, &checked);
    if (result == NORMA_OK)
        result = norma_core_topology_open(&judge->call, &checked, &judge->topology);
    if (result != NORMA_OK) return result;
    result = find_parts(judge);
    if (result != NORMA_OK) norma_core_side_judge_close(judge);
    return result;
}

void norma_core_side_judge_close(core_side_judge *j) {
    norma_core_ray_scene_close(j->rays);
    norma_core_release(&j->call, j->known, j->room, 1);
    norma_core_release_components(&j->call, &j->pieces);
    norma_core_release_components(&j->call, &j->parts);
    norma_core_topology_close(&j->topology);
}

/* ---- asking */

static int has_flags(const core_side_judge *j, size_t face, uint8_t flags) {
    const core_components *parts = &j->parts;
    return parts->of[face] == UINT32_MAX || (parts->each[parts->of[face]].flags & flags) != 0;
}

/* The pieces that rays must be cast from. */
static size_t choose_pieces(core_side_judge *j, size_t first, size_t count, const uint8_t *asked) {
    core_components *pieces = &j->pieces;
    size_t chosen = 0;
    for (size_t f = first; f < first + count; f++) {
        const uint32_t piece = pieces->of[f];
        if ((asked && !asked[f - first]) || piece == UINT32_MAX || j->known[piece] != UNASKED ||
            !has_flags(j, f, NOT_CLOSED) || has_flags(j, f, COMPONENT_ONE_SIDED))
            continue;
        pieces->each[piece].flags |= COMPONENT_OPEN;
        chosen++;
    }
    return chosen;
}

static norma_result ask_rays(core_side_judge *j) {
    core_components *pieces = &j->pieces;
    core_ray_votes votes;
    norma_result result =
        j->rays ? NORMA_OK : norma_core_ray_scene_open(&j->topology, pieces, &j->rays);
    if (result == NORMA_OK) result = norma_core_ray_scene_vote(j->rays, COMPONENT_OPEN, &votes);
    for (size_t i = 0; i < pieces->count; i++) {
        core_component *piece = &pieces->each[i];
        if (piece->flags & COMPONENT_OPEN && result == NORMA_OK)
            j->known[i] = piece->flags & COMPONENT_UNDECIDED                  ? UNDECIDED
                          : pieces->reverse[pieces->faces[pieces->starts[i]]] ? TURNED
                                                                              : RIGHT;
        piece->flags = 0;
    }
    return result;
}

/* A sheet that lies on another of the same winding: made to agree, the two are closed, but hold
 * nothing that says which of them is turned. */
static int is_doubled_sheet(const core_side_judge *j, size_t face) {
    const core_component *part = &j->parts.each[j->parts.of[face]];
    return part->flags & COMPONENT_CONFLICT && part->volume == 0;
}

static uint8_t side_of(const core_side_judge *j, size_t face) {
    const uint8_t turned = j->parts.reverse[face] ? CORE_SIDE_TURNED : 0;
    if (!has_flags(j, face, NOT_CLOSED))
        return turned | (is_doubled_sheet(j, face) ? CORE_SIDE_UNDECIDED : 0);
    const uint32_t piece = j->pieces.of[face];
    const uint8_t known = piece == UINT32_MAX ? UNDECIDED : j->known[piece];
    if (known == UNASKED || known == UNDECIDED) return turned | CORE_SIDE_UNDECIDED;
    return known == TURNED ? CORE_SIDE_TURNED | CORE_SIDE_BY_RAYS : CORE_SIDE_BY_RAYS;
}

norma_result norma_core_side_judge_ask(
    core_side_judge *judge, size_t first, size_t count, const uint8_t *asked, uint8_t *sides) {
    for (size_t i = 0; i < judge->pieces.count; i++) judge->pieces.each[i].flags = 0;
    norma_result result = NORMA_OK;
    if (choose_pieces(judge, first, count, asked)) result = ask_rays(judge);
    for (size_t f = 0; f < count && result == NORMA_OK; f++) sides[f] = side_of(judge, first + f);
    return result;
}
