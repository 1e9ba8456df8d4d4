/* decimate.c: fewer triangles, by meshoptimizer's simplifier (quadrics, Garland and Heckbert 1997),
 * and by its clustering of vertices where that cannot go far enough. Equal positions count as one
 * vertex: the first of them stays. */
#include "cli/view/decimate.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if defined(NORMA_HAS_MESHOPTIMIZER)
#include <meshoptimizer.h>

/* As a part of the mesh's size. */
static const float largest_error = 0.02F;

typedef struct shared_mesh {
    float *positions;                  /* of each vertex that stays so far */
    uint32_t *remap, *first, *corners; /* first: its number in the mesh */
    size_t vertex_count, unique, corner_count;
} shared_mesh;

static void free_shared(shared_mesh *s) {
    free(s->positions);
    free(s->remap);
    free(s->first);
    free(s->corners);
}

static int make_room(shared_mesh *s, const norma_mesh *mesh) {
    s->vertex_count = mesh->positions.count;
    s->corner_count = mesh->corner_count;
    s->positions = calloc(3 * s->vertex_count + 1, sizeof *s->positions);
    s->remap = malloc(4 * s->vertex_count + 1);
    s->first = malloc(4 * s->vertex_count + 1);
    s->corners = malloc(4 * s->corner_count + 1);
    return s->positions && s->remap && s->first && s->corners;
}

static void read_positions(shared_mesh *s, const norma_mesh *mesh) {
    for (size_t i = 0; i < s->vertex_count; ++i) {
        double v[3];
        norma_view_vector(&mesh->positions, i, v);
        for (size_t axis = 0; axis < 3; ++axis)
            s->positions[3 * i + axis] = isfinite(v[axis]) ? (float)v[axis] : 0;
    }
}

/* Vertices of equal positions become one. 0: a corner names none. */
static int share(shared_mesh *s, const norma_mesh *mesh) {
    read_positions(s, mesh);
    s->unique = meshopt_generateVertexRemap(
        s->remap, NULL, s->vertex_count, s->positions, s->vertex_count, 12);
    for (size_t i = s->vertex_count; i-- > 0;) s->first[s->remap[i]] = (uint32_t)i;
    meshopt_remapVertexBuffer(s->positions, s->positions, s->vertex_count, 12, s->remap);
    for (size_t i = 0; i < s->corner_count; ++i) {
        const uint32_t corner = mesh->corners ? norma_mesh_corner(mesh, i) : (uint32_t)i;
        if (corner >= s->vertex_count) return 0;
        s->corners[i] = s->remap[corner];
    }
    return 1;
}

static int simplify(shared_mesh *s, size_t most_triangles) {
    uint32_t *fewer = malloc(4 * s->corner_count + 1);
    if (!fewer) return 0;
    size_t count = meshopt_simplify(fewer, s->corners, s->corner_count, s->positions, s->unique, 12,
        3 * most_triangles, largest_error, 0, NULL);
    if (count > 4 * most_triangles)
        count = meshopt_simplifySloppy(fewer, s->corners, s->corner_count, s->positions, s->unique,
            12, 3 * most_triangles, 1, NULL);
    free(s->corners);
    s->corners = fewer;
    s->corner_count = count;
    return 1;
}

/* Only vertices that are still used, in the order of the mesh. */
static int keep_used(shared_mesh *s, view_decimated *decimated) {
    decimated->vertices = malloc(4 * s->unique + 1);
    if (!decimated->vertices) return 0;
    memset(s->remap, 0, 4 * s->vertex_count);
    for (size_t i = 0; i < s->corner_count; ++i) s->remap[s->corners[i]] = 1;
    for (size_t i = 0; i < s->unique; ++i)
        if (s->remap[i]) {
            decimated->vertices[decimated->vertex_count] = s->first[i];
            s->remap[i] = (uint32_t)decimated->vertex_count++;
        }
    for (size_t i = 0; i < s->corner_count; ++i) s->corners[i] = s->remap[s->corners[i]];
    decimated->corners = s->corners;
    decimated->corner_count = s->corner_count;
    s->corners = NULL;
    return 1;
}

int view_decimate(const norma_mesh *mesh, size_t most_triangles, view_decimated *decimated) {
    shared_mesh s = {0};
    if (mesh->corner_count <= 3 * most_triangles) return 1;
    int good = make_room(&s, mesh);
    if (good && share(&s, mesh)) good = simplify(&s, most_triangles) && keep_used(&s, decimated);
    free_shared(&s);
    return good;
}
#else
int view_decimate(const norma_mesh *mesh, size_t most_triangles, view_decimated *decimated) {
    (void)mesh, (void)most_triangles, (void)decimated;
    return 1;
}
#endif
