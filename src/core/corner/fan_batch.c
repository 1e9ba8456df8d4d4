/* fan_batch.c: what memory has to say about a batch of stars. In meshes of random order each of a
 * corner's reads misses the caches, so they are asked for in stages, each while something else is
 * computed, so that memory is never idle: the mesh's corners two batches ahead, the positions that
 * these name one batch ahead, the places where the normals go when the star is first touched. */
#include "core/corner/fan_batch.h"

enum { CORNERS_AHEAD = 2 * BATCH_CORNERS, NEAR = 1 << 17 };

int norma_core_can_batch(const core_prepared_mesh *prepared) {
    const norma_options *o = &prepared->call->options;
    return o->weight != NORMA_WEIGHT_VISIBLE &&
           !(prepared->mesh.weld && o->weld == NORMA_WELD_DISTANCE);
}

void norma_core_clear_batch(fan_batch *batch) {
    norma_core_clear_measured(&batch->measured);
    memset(batch->notes, 0, sizeof batch->notes);
}

void norma_core_clear_list(star_list *list, const position_visit *visit) {
    list->visit = visit;
    list->corner_count = 0;
    list->star_count = 0;
}

static void read_polygon_corners(const core_prepared_mesh *prepared, star_list *list) {
    const core_mesh *mesh = &prepared->mesh;
    for (size_t i = 0; i < list->corner_count; i++) {
        const size_t corner = list->corners[i],
                     face = norma_core_face_of(&prepared->corners_of, list->corners[i]);
        list->face[i] = (uint32_t)face;
        list->turn[i] = 0;
        list->next[i] = norma_core_corner(mesh, norma_core_next_in_face(mesh, face, corner));
        list->previous[i] =
            norma_core_corner(mesh, norma_core_previous_in_face(mesh, face, corner));
    }
}

/* Corners of 32 bits in a loop without a question inside. */
static inline uint32_t corner_at(const core_mesh *mesh, size_t corner, int plain) {
    uint32_t index;
    if (!plain) return norma_core_corner(mesh, corner);
    memcpy(&index, (const unsigned char *)mesh->corners + 4 * corner, sizeof index);
    return index;
}

static inline void read_triangle_corners(const core_mesh *mesh, star_list *list, int plain) {
    for (size_t i = 0; i < list->corner_count; i++) {
        const uint32_t corner = list->corners[i], face = corner / 3, turn = corner - 3 * face;
        list->face[i] = face;
        list->turn[i] = turn;
        list->next[i] = corner_at(mesh, turn == 2 ? corner - 2 : corner + 1, plain);
        list->previous[i] = corner_at(mesh, turn == 0 ? corner + 2 : corner - 1, plain);
    }
}

/* Of most stars, each next is also a previous. */
static void ask_for_positions(
    const core_prepared_mesh *prepared, const star_list *list, size_t begin, size_t count) {
    const core_mesh *mesh = &prepared->mesh;
    const uint32_t *next = list->next + begin;
    for (size_t i = 0; i < count; i++) {
        __builtin_prefetch(
            (const unsigned char *)mesh->positions.data + next[i] * mesh->positions.stride);
        if (mesh->weld) __builtin_prefetch(&mesh->weld[next[i]]);
        if (prepared->faces) __builtin_prefetch(&prepared->faces[list->face[begin + i]]);
    }
}

int norma_core_list_star(
    const core_prepared_mesh *prepared, uint32_t position, uint32_t count, star_list *list) {
    const uint32_t *corners = prepared->corners_of.corners + prepared->corners_of.starts[position],
                   at = (uint32_t)list->corner_count;
    if (at + count > BATCH_CORNERS) return 0;
    memcpy(list->corners + at, corners, count * sizeof *corners);
    list->stars[list->star_count++] = (listed_star){.position = position,
        .begin = (uint16_t)at,
        .count = (uint16_t)count,
        .scattered = corners[count - 1] - corners[0] > NEAR};
    list->corner_count += count;
    return 1;
}

void norma_core_read_list(const core_prepared_mesh *prepared, star_list *list) {
    if (prepared->faces)
        read_polygon_corners(prepared, list);
    else if (prepared->mesh.corner_size == sizeof(uint32_t))
        read_triangle_corners(&prepared->mesh, list, 1);
    else
        read_triangle_corners(&prepared->mesh, list, 0);
    for (size_t i = 0; i < list->star_count; i++)
        if (list->stars[i].scattered)
            ask_for_positions(prepared, list, list->stars[i].begin, list->stars[i].count);
}

void norma_core_ask_for_targets(const star_list *list, const listed_star *star) {
    const position_visit *visit = list->visit;
    for (size_t i = star->begin; i < (size_t)star->begin + star->count && visit->target; i++)
        __builtin_prefetch(
            (const unsigned char *)visit->target + visit->target_size * list->corners[i], 1);
}

void norma_core_ask_for_corners(const core_prepared_mesh *prepared, const listed_star *star) {
    const core_corners_of_position *corners_of = &prepared->corners_of;
    const core_mesh *mesh = &prepared->mesh;
    const size_t begin = corners_of->starts[star->position] + (size_t)CORNERS_AHEAD,
                 listed = corners_of->starts[corners_of->position_count];
    for (size_t i = begin; i < begin + star->count && i < listed && mesh->corners; i++)
        __builtin_prefetch(
            (const unsigned char *)mesh->corners + mesh->corner_size * corners_of->corners[i]);
}
