/* world.c: positions through the matrix of their node, welded by a hash table. */
#include "io/together/world.h"
#include "core/call/vec3_view.h"
#include "core/call/vector.h"
#include "io/file/large_memory.h"
#include "io/file/memory.h"
#include "io/together/join.h"
#include "io/together/near.h"
#include <stdlib.h>
#include <string.h>

void norma_together_free_world(world_mesh *w) {
    void *const blocks[] = {w->positions, w->at, w->corners, w->weld, w->firsts};
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; ++i) free(blocks[i]);
    *w = (world_mesh){0};
}

/* ---- positions */

void norma_together_position(
    const document_surface *surface, const placement *place, size_t index, double position[3]) {
    double p[3];
    const double *m = place->world;
    norma_view_read(&surface->mesh->positions, index, p);
    for (int k = 0; k < 3; ++k) p[k] *= surface->unit;
    for (int k = 0; k < 3; ++k)
        position[k] =
            place->plain ? p[k] : m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k];
}

void norma_together_at(const equality *equal, const double position[3], double at[3]) {
    for (int k = 0; k < 3; ++k)
        at[k] = (equal->rounded ? (double)(float)position[k] : position[k]) + 0.0;
    if (equal->near) norma_near_find(equal->near, at);
}

static int place_positions(
    const document_surface *surface, const placement *place, const equality *equal, world_mesh *w) {
    const size_t count = surface->mesh->positions.count;
    w->positions = norma_io_block(count, 3 * sizeof(double));
    w->at = norma_io_block(count, sizeof *w->at);
    w->weld = norma_io_block(count, sizeof *w->weld);
    w->firsts = norma_io_block(count, sizeof *w->firsts);
    if (!w->positions || !w->at || !w->weld || !w->firsts) return 0;
    for (size_t i = 0; i < count; ++i) {
        norma_together_position(surface, place, i, w->positions + 3 * i);
        norma_together_at(equal, w->positions + 3 * i, w->at[i]);
    }
    return 1;
}

/* ---- which are one */

static int weld_placed(world_mesh *w, size_t count) {
    size_t size = 16;
    while (size / 2 < count) size *= 2;
    uint32_t *table = norma_io_allocate(size, sizeof *table);
    for (size_t i = 0; table && i < count; ++i) {
        w->weld[i] = (uint32_t)i;
        if (!norma_core_finite(w->at[i])) continue;
        size_t at = (size_t)norma_together_hash(w->at[i]) & (size - 1);
        while (table[at] && memcmp(w->at[table[at] - 1], w->at[i], sizeof w->at[i]) != 0)
            at = (at + 1) & (size - 1);
        if (!table[at]) {
            table[at] = (uint32_t)i + 1;
            w->firsts[w->first_count++] = (uint32_t)i;
        }
        w->weld[i] = table[at] - 1;
    }
    free(table);
    return table != NULL;
}

/* ---- faces */

static int lies_before(const double a[3], const double b[3]) {
    for (int k = 0; k < 3; ++k)
        if (a[k] != b[k]) return a[k] < b[k];
    return 0;
}

/* From the corner that lies first, so that what a face adds does not depend on the corner that its
 * file begins with. */
static void turn_placed_faces(world_mesh *w) {
    for (size_t f = 0; f < w->mesh.face_count; ++f) {
        const size_t begin = norma_core_face_begin(&w->mesh, f),
                     count = norma_core_face_end(&w->mesh, f) - begin;
        uint32_t *corners = w->corners + begin;
        size_t first = 0;
        for (size_t k = 1; k < count; ++k)
            if (lies_before(w->at[corners[k]], w->at[corners[first]])) first = k;
        for (size_t turned = 0; turned < first; ++turned) {
            const uint32_t moved = corners[0];
            memmove(corners, corners + 1, (count - 1) * sizeof *corners);
            corners[count - 1] = moved;
        }
    }
}

static int take_placed_corners(const document_surface *surface, world_mesh *w) {
    const size_t count = surface->mesh->corner_count;
    w->corners = norma_io_block(count, sizeof *w->corners);
    for (size_t c = 0; w->corners && c < count; ++c)
        w->corners[c] = norma_mesh_corner(surface->mesh, c);
    return w->corners != NULL;
}

norma_result norma_together_place(
    const document_surface *surface, const placement *place, const equality *equal, world_mesh *w) {
    const size_t count = surface->mesh->positions.count;
    *w = (world_mesh){0};
    if (!place_positions(surface, place, equal, w) || !weld_placed(w, count) ||
        !take_placed_corners(surface, w))
        return NORMA_ERROR_MEMORY;
    const norma_mesh moved = {
        .positions = {.data = w->positions, .count = count, .format = NORMA_FORMAT_DOUBLE},
        .corners = w->corners,
        .corner_count = surface->mesh->corner_count,
        .face_starts = surface->mesh->face_starts,
        .face_count = surface->mesh->face_count};
    const norma_result result = norma_core_mesh_shape(&moved, &w->mesh);
    if (result) return result;
    w->mesh.scale = 1;
    w->mesh.weld = w->weld;
    turn_placed_faces(w);
    return NORMA_OK;
}
