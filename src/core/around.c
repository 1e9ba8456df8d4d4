/* around.c: a counting sort of corners by position. Ascending corners at each position are the order of every sum. */
#include "around.h"
#include "face_geometry.h"

enum { AHEAD = 64 };                   /* corners between asking for memory and using it */

static void look_ahead(const core_mesh *mesh, const core_around *around, size_t corner)
{
    const uint32_t position = norma_core_corner(mesh, corner);
    if (mesh->weld) __builtin_prefetch(&mesh->weld[position]);
    else __builtin_prefetch(&around->starts[position], 1);
}

static void count_corners(const core_mesh *mesh, core_around *around)
{
    memset(around->starts, 0, (around->position_count + 1) * sizeof *around->starts);
    for (size_t c = 0; c < mesh->corner_count; c++) {
        if (c + AHEAD < mesh->corner_count) look_ahead(mesh, around, c + AHEAD);
        around->starts[norma_core_welded_corner(mesh, c)]++;
    }
}

/* Counts become the end of each range; filling backwards turns ends into starts. */
static void counts_to_ends(core_around *around)
{
    uint32_t sum = 0;
    around->most = 0;
    for (size_t p = 0; p < around->position_count; p++) {
        if (around->starts[p] > around->most) around->most = around->starts[p];
        sum += around->starts[p];
        around->starts[p] = sum;
    }
    around->starts[around->position_count] = sum;
}

static void fill_backwards(const core_mesh *mesh, core_around *around)
{
    for (size_t c = mesh->corner_count; c-- > 0;) {
        if (c >= AHEAD) look_ahead(mesh, around, c - AHEAD);
        around->corners[--around->starts[norma_core_welded_corner(mesh, c)]] = (uint32_t)c;
    }
}

static void name_faces(const core_mesh *mesh, core_around *around)
{
    for (size_t f = 0; f < mesh->face_count; f++)
        for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++) around->faces[c] = (uint32_t)f;
}

norma_result norma_core_around_build(core_call *call, const core_mesh *mesh, core_around *around)
{
    *around = (core_around){.position_count = mesh->positions.count, .corner_count = mesh->corner_count};
    around->starts = norma_core_allocate(call, around->position_count + 1, sizeof *around->starts);
    around->corners = norma_core_allocate(call, around->corner_count, sizeof *around->corners);
    if (mesh->face_starts) around->faces = norma_core_allocate(call, around->corner_count, sizeof *around->faces);
    norma_result result = NORMA_OK;
    if (!around->starts || !around->corners || (mesh->face_starts && !around->faces)) result = NORMA_ERROR_MEMORY;
    if (result == NORMA_OK) {
        count_corners(mesh, around);
        counts_to_ends(around);
        if (norma_core_progress(call, 0.5)) result = NORMA_CANCELLED;
    }
    if (result == NORMA_OK) {
        fill_backwards(mesh, around);
        if (around->faces) name_faces(mesh, around);
        return norma_core_progress(call, 1) ? (norma_core_around_release(call, around), NORMA_CANCELLED) : NORMA_OK;
    }
    norma_core_around_release(call, around);
    return result;
}

void norma_core_around_release(const core_call *call, core_around *around)
{
    norma_core_release(call, around->starts, around->position_count + 1, sizeof *around->starts);
    norma_core_release(call, around->corners, around->corner_count, sizeof *around->corners);
    norma_core_release(call, around->faces, around->corner_count, sizeof *around->faces);
    *around = (core_around){0};
}
