/* body_normals.c: the normals of several surfaces that make up one body, such as the primitives of
 * a glTF mesh: computed as one mesh, told surface by surface. */
#include "render/surface/surface_vertices.h"
#include <stdlib.h>
#include <string.h>

typedef struct body {
    double *positions;
    uint32_t *corners, *starts;
    size_t position_count, corner_count, face_count;
    float *normals;
} body;

static void free_body(body *b) {
    free(b->positions);
    free(b->corners);
    free(b->starts);
    free(b->normals);
}

static int allocate_body(const render_surface *surfaces, size_t count, body *b) {
    size_t positions = 0, corners = 0, faces = 0;
    for (size_t i = 0; i < count; ++i) {
        positions += surfaces[i].mesh.positions.count;
        corners += surfaces[i].mesh.corner_count;
        faces += render_face_count(&surfaces[i].mesh);
    }
    if (positions > UINT32_MAX / 2 || corners > UINT32_MAX / 2) return 0;
    b->positions = malloc((3 * positions + 1) * sizeof *b->positions);
    b->corners = malloc((corners + 1) * sizeof *b->corners);
    b->starts = malloc((faces + 1) * sizeof *b->starts);
    b->normals = malloc((3 * corners + 1) * sizeof *b->normals);
    return b->positions && b->corners && b->starts && b->normals;
}

static void append_to_body(body *b, const norma_mesh *mesh) {
    const size_t base = b->position_count;
    for (size_t i = 0; i < mesh->positions.count; ++i)
        render_position(mesh, (uint32_t)i, b->positions + 3 * b->position_count++);
    for (size_t face = 0; face < render_face_count(mesh); ++face) {
        size_t first, count;
        render_face(mesh, face, &first, &count);
        b->starts[b->face_count++] = (uint32_t)b->corner_count;
        for (size_t i = 0; i < count; ++i)
            b->corners[b->corner_count++] = (uint32_t)base + norma_mesh_corner(mesh, first + i);
    }
    b->starts[b->face_count] = (uint32_t)b->corner_count;
}

static norma_result compute_body_normals(const render_surface *like, body *b) {
    const norma_options options = {.struct_size = sizeof options,
        .weight = like->weight,
        .fallback = NORMA_FALLBACK_NEAREST,
        .threads = NORMA_ALL_THREADS};
    const norma_mesh mesh = {.positions = {.data = b->positions,
                                 .count = b->position_count,
                                 .format = NORMA_FORMAT_DOUBLE},
        .corners = b->corners,
        .corner_count = b->corner_count,
        .face_starts = b->starts,
        .face_count = b->face_count};
    return norma_corner_normals(
        &mesh, (float)like->crease_rad, &options, b->normals, b->corner_count, NULL);
}

static int hand_out(const render_surface *surfaces, size_t count, const body *b, float **expected) {
    size_t at = 0;
    int good = 1;
    for (size_t i = 0; i < count; ++i) {
        const size_t corners = surfaces[i].mesh.corner_count;
        expected[i] = malloc((3 * corners + 1) * sizeof **expected);
        if (expected[i]) memcpy(expected[i], b->normals + 3 * at, 3 * corners * sizeof **expected);
        good &= expected[i] != NULL;
        at += corners;
    }
    return good;
}

enum render_result render_expect(
    const render_surface *surfaces, size_t count, float **expected, render_error *error) {
    body b = {0};
    norma_result result = allocate_body(surfaces, count, &b) ? NORMA_OK : NORMA_ERROR_MEMORY;
    for (size_t i = 0; i < count; ++i) expected[i] = NULL;
    for (size_t i = 0; i < count && !result; ++i) append_to_body(&b, &surfaces[i].mesh);
    if (!result) result = compute_body_normals(&surfaces[0], &b);
    if (!result && !hand_out(surfaces, count, &b, expected)) result = NORMA_ERROR_MEMORY;
    free_body(&b);
    for (size_t i = 0; i < count && result; ++i) {
        free(expected[i]);
        expected[i] = NULL;
    }
    if (result == NORMA_ERROR_MEMORY) return render_fail_memory(error);
    return result ? render_fail(error, RENDER_ERROR_ARGUMENT, "%s", norma_result_text(result))
                  : RENDER_OK;
}
