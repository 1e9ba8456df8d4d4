/* orient.c: which faces are turned, by volume, nesting and rays; norma_orient and
 * norma_reverse_winding. */
#include "core/topology/topology.h"
#include "core/face/face.h"
#include <norma/norma.h>
#include <string.h>

/* ---- Which faces are turned: those of closed parts by volume and nesting, as orient.c turns
 * them; those of open parts by rays from each piece whose faces agree. An open part may wind by
 * little more than one half round what lies beside it: of that, rays are asked first. */

static const uint8_t PART_NOT_CLOSED = COMPONENT_OPEN | COMPONENT_ONE_SIDED | COMPONENT_UNBALANCED;

enum { UNASKED = 0, RIGHT, TURNED, UNDECIDED }; /* what is known of a piece */

/* ---- opening */

static void turn_inward_parts(core_components *c) {
    for (size_t i = 0; i < c->count; i++)
        for (size_t k = c->starts[i]; k < c->starts[i + 1]; k++)
            c->reverse[c->faces[k]] ^= c->each[i].verdict == COMPONENT_INWARD;
}

static norma_result find_side_parts(core_side_judge *j) {
    core_topology *t = &j->topology;
    const core_topology_visitor nobody = {NULL, NULL, NULL, NULL};
    norma_result result = norma_core_pair_edges(t, &nobody);
    if (result == NORMA_OK) result = norma_core_find_components(t, CORE_JOIN_CUT, &j->parts);
    if (result != NORMA_OK) return result;
    result = norma_core_measure_components(t, &j->parts, PART_NOT_CLOSED);
    if (result == NORMA_OK) result = norma_core_judge_nesting(t, &j->parts, PART_NOT_CLOSED);
    if (result == NORMA_OK) result = norma_core_find_components(t, CORE_JOIN_ALIKE, &j->pieces);
    if (result != NORMA_OK) return result;
    turn_inward_parts(&j->parts);
    j->room = j->pieces.count + 1;
    j->known = norma_core_allocate(&j->call, j->room, 1);
    j->cast = norma_core_allocate(&j->call, j->room, 1);
    if (!j->known || !j->cast) return NORMA_ERROR_MEMORY;
    memset(j->cast, UNASKED, j->room);
    norma_core_side_judge_forget(j);
    return NORMA_OK;
}

void norma_core_side_judge_forget(core_side_judge *j) { memset(j->known, UNASKED, j->room); }

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
    result = find_side_parts(judge);
    if (result != NORMA_OK) norma_core_side_judge_close(judge);
    return result;
}

void norma_core_side_judge_close(core_side_judge *j) {
    norma_core_ray_scene_close(j->rays);
    norma_core_release(&j->call, j->cast, j->room, 1);
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

static int lies_in_open(const core_side_judge *j, size_t face) {
    const core_components *parts = &j->parts;
    const uint32_t parent = parts->each[parts->of[face]].parent;
    return parent != UINT32_MAX && (parts->each[parent].flags & PART_NOT_CLOSED) != 0;
}

static int is_for_rays(const core_side_judge *j, size_t face) {
    return has_flags(j, face, PART_NOT_CLOSED) || lies_in_open(j, face);
}

/* The pieces that rays must be cast from. */
static size_t choose_pieces(core_side_judge *j, size_t first, size_t count, const uint8_t *asked) {
    core_components *pieces = &j->pieces;
    size_t chosen = 0;
    for (size_t f = first; f < first + count; f++) {
        const uint32_t piece = pieces->of[f];
        if ((asked && !asked[f - first]) || piece == UINT32_MAX || j->known[piece] != UNASKED ||
            !is_for_rays(j, f) || has_flags(j, f, COMPONENT_ONE_SIDED))
            continue;
        j->known[piece] = j->cast[piece];
        if (j->cast[piece] != UNASKED) continue;
        pieces->each[piece].flags |= COMPONENT_OPEN;
        chosen++;
    }
    return chosen;
}

static norma_result ask_side_rays(core_side_judge *j) {
    core_components *pieces = &j->pieces;
    core_ray_votes votes;
    norma_result result =
        j->rays ? NORMA_OK : norma_core_ray_scene_open(&j->topology, pieces, &j->rays);
    if (result == NORMA_OK) result = norma_core_ray_scene_vote(j->rays, COMPONENT_OPEN, &votes);
    for (size_t i = 0; i < pieces->count; i++) {
        core_component *piece = &pieces->each[i];
        if (piece->flags & COMPONENT_OPEN && result == NORMA_OK)
            j->known[i] = j->cast[i] = piece->flags & COMPONENT_UNDECIDED ? UNDECIDED
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
    const uint32_t piece = j->pieces.of[face];
    const uint8_t known = is_for_rays(j, face) && piece != UINT32_MAX ? j->known[piece] : UNDECIDED;
    const int is_silent = known == UNASKED || known == UNDECIDED;
    if (is_silent && !has_flags(j, face, PART_NOT_CLOSED))
        return turned | (is_doubled_sheet(j, face) ? CORE_SIDE_UNDECIDED : 0);
    if (is_silent) return turned | CORE_SIDE_UNDECIDED;
    return known == TURNED ? CORE_SIDE_TURNED | CORE_SIDE_BY_RAYS : CORE_SIDE_BY_RAYS;
}

norma_result norma_core_side_judge_ask(
    core_side_judge *judge, size_t first, size_t count, const uint8_t *asked, uint8_t *sides) {
    for (size_t i = 0; i < judge->pieces.count; i++) judge->pieces.each[i].flags = 0;
    norma_result result = NORMA_OK;
    if (choose_pieces(judge, first, count, asked)) result = ask_side_rays(judge);
    for (size_t f = 0; f < count && result == NORMA_OK; f++) sides[f] = side_of(judge, first + f);
    return result;
}

/* ---- A consistent winding for each part, cut at edges of more than two faces; outward for
 * what is closed, by signed volume and by how the parts lie in one another. */

typedef struct edge_count {
    size_t many, conflicts;
} edge_count;

static void count_odd_edge(
    void *context, size_t block, uint32_t position, const core_edge_run *runs, size_t count) {
    edge_count *counts = context;
    (void)position;
    (void)runs;
    counts[block].many += count > 2;
    counts[block].conflicts += count == 2;
}

static norma_result pair_and_count(core_topology *t, norma_orient_report *report) {
    const size_t blocks = norma_core_topology_blocks(t);
    edge_count *counts = norma_core_allocate(t->call, blocks, sizeof *counts);
    if (!counts) return NORMA_ERROR_MEMORY;
    memset(counts, 0, blocks * sizeof *counts);
    const core_topology_visitor visitor = {.context = counts, .edge = count_odd_edge};
    const norma_result result = norma_core_pair_edges(t, &visitor);
    for (size_t i = 0; i < blocks; i++) {
        report->non_manifold_edges += counts[i].many;
        report->winding_conflicts += counts[i].conflicts;
    }
    norma_core_release(t->call, counts, blocks, sizeof *counts);
    return result;
}

static void turn_round(core_components *c, size_t part) {
    for (size_t k = c->starts[part]; k < c->starts[part + 1]; k++)
        c->reverse[c->faces[k]] = !c->reverse[c->faces[k]];
}

static void turn_outward(core_components *c, norma_orient_report *report) {
    for (size_t i = 0; i < c->count; i++) {
        const core_component *part = &c->each[i];
        report->closed += !(part->flags & PART_NOT_CLOSED);
        report->one_sided += (part->flags & COMPONENT_ONE_SIDED) != 0;
        report->open += (part->flags & PART_NOT_CLOSED) && !(part->flags & COMPONENT_ONE_SIDED);
        report->nested += part->verdict == COMPONENT_NESTED;
        report->inward += part->verdict == COMPONENT_INWARD;
        if (part->verdict == COMPONENT_INWARD) turn_round(c, i);
    }
}

static norma_result orient_parts(
    core_topology *t, norma_orient_open open, core_components *c, norma_orient_report *report) {
    norma_result result = norma_core_measure_components(t, c, PART_NOT_CLOSED);
    if (result == NORMA_OK) result = norma_core_judge_nesting(t, c, PART_NOT_CLOSED);
    if (result != NORMA_OK) return result;
    turn_outward(c, report);
    report->parts = c->count;
    report->undecided = report->open;
    if (open != NORMA_ORIENT_OPEN_BY_RAYS || !report->open) return NORMA_OK;
    core_ray_votes votes;
    result = norma_core_orient_by_rays(t, c, COMPONENT_OPEN | COMPONENT_UNBALANCED, &votes);
    report->undecided = votes.undecided;
    report->by_rays = votes.decided;
    report->least_confidence = votes.least_confidence;
    return result;
}

static norma_result orient(
    core_topology *t, norma_orient_open open, uint8_t *reverse, norma_orient_report *report) {
    core_components components;
    norma_core_stage(t->call, 0.3, 0.6);
    norma_result result = pair_and_count(t, report);
    if (result == NORMA_OK) result = norma_core_find_components(t, CORE_JOIN_CUT, &components);
    if (result != NORMA_OK) return result;
    norma_core_stage(t->call, 0.6, 1);
    result = orient_parts(t, open, &components, report);
    for (size_t f = 0; result == NORMA_OK && f < t->mesh.face_count; f++) {
        reverse[f] = components.reverse[f] != 0;
        report->reversed_faces += reverse[f];
    }
    norma_core_release_components(t->call, &components);
    return result;
}

norma_result norma_orient(const norma_mesh *mesh, norma_orient_open open,
    const norma_options *options, uint8_t *reverse, size_t capacity, norma_orient_report *report) {
    core_call call;
    core_mesh checked;
    core_topology topology;
    norma_orient_report counted = {.least_confidence = 1};
    norma_result result = norma_core_begin(&call, options);
    if (result == NORMA_OK) result = norma_core_mesh_shape(mesh, &checked);
    if (result == NORMA_OK) norma_core_share(&call, checked.corner_count);
    if (result == NORMA_OK && ((checked.face_count && !reverse) || open < NORMA_ORIENT_OPEN_KEPT ||
                                  open > NORMA_ORIENT_OPEN_BY_RAYS))
        result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK && capacity < checked.face_count) result = NORMA_ERROR_CAPACITY;
    norma_core_stage(&call, 0, 0.1);
    if (result == NORMA_OK) result = norma_core_mesh_content(&call, &checked);
    if (result != NORMA_OK) return result;
    if (checked.face_count) {
        norma_core_stage(&call, 0.1, 0.3);
        result = norma_core_topology_open(&call, &checked, &topology);
        if (result != NORMA_OK) return result;
        result = orient(&topology, open, reverse, &counted);
        norma_core_topology_close(&topology);
    }
    if (result == NORMA_OK && report) *report = counted;
    return result;
}

/* ---- Turning faces round, in place. The first corner of each face stays, so that
 * what was said of it stays true. */

static void swap_elements(unsigned char *a, unsigned char *b, size_t size) {
    unsigned char kept[4];
    memcpy(kept, a, size);
    memcpy(a, b, size);
    memcpy(b, kept, size);
}

static norma_result check_winding(
    size_t corner_size, size_t corner_count, const uint32_t *face_starts, size_t face_count) {
    if (corner_size != 1 && corner_size != 2 && corner_size != 4) return NORMA_ERROR_ARGUMENT;
    if (corner_count > SIZE_MAX / corner_size) return NORMA_ERROR_OVERFLOW;
    if (!face_starts) return corner_count % 3 ? NORMA_ERROR_ARGUMENT : NORMA_OK;
    if (face_count >= SIZE_MAX / sizeof *face_starts) return NORMA_ERROR_OVERFLOW;
    if (face_starts[0] != 0 || face_starts[face_count] != corner_count) return NORMA_ERROR_ARGUMENT;
    for (size_t f = 0; f < face_count; f++)
        if (face_starts[f + 1] < face_starts[f]) return NORMA_ERROR_ARGUMENT;
    return NORMA_OK;
}

norma_result norma_reverse_winding(void *corners, size_t corner_size, size_t corner_count,
    const uint32_t *face_starts, size_t face_count) {
    if (!corner_size) corner_size = 4;
    const norma_result result = check_winding(corner_size, corner_count, face_starts, face_count);
    if (result || !corner_count) return result;
    if (!corners) return NORMA_ERROR_ARGUMENT;
    if (!face_starts) face_count = corner_count / 3;
    for (size_t f = 0; f < face_count; f++) {
        size_t low = (face_starts ? face_starts[f] : 3 * f) + 1,
               end = face_starts ? face_starts[f + 1] : 3 * f + 3;
        for (; low + 1 < end; low++, end--)
            swap_elements((unsigned char *)corners + low * corner_size,
                (unsigned char *)corners + (end - 1) * corner_size, corner_size);
    }
    return NORMA_OK;
}
