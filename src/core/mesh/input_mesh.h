/* input_mesh.h: the caller's mesh, checked, and read corner by corner. Corners and positions are
 * numbered in 32 bits. */
#ifndef NORMA_CORE_MESH_H
#define NORMA_CORE_MESH_H
#include "core/call/call.h"

typedef struct core_mesh {
    norma_vec3_view positions; /* its stride is never 0 */
    const void *corners;
    size_t corner_count, corner_size; /* size 0: corner c is at position c */
    const uint32_t *face_starts;      /* NULL: triangles */
    size_t face_count;
    const uint32_t *smoothing_groups;
    const uint8_t *hard_edges;
    double
        scale; /* exact power of two that brings double positions near 1; 1 for all other formats */
    const uint32_t *weld; /* NULL, or for each position the least of those that it is one with */
} core_mesh;

/* ARGUMENT or OVERFLOW: what of it can be told without reading the arrays. */
norma_result norma_core_mesh_shape(const norma_mesh *mesh, core_mesh *checked);
/* The same for who asks what is wrong, and of the offsets alone. fault may be NULL. */
norma_result norma_core_check_shape(const norma_mesh *mesh, core_mesh *checked, norma_fault *fault);
norma_result norma_core_check_face_starts(const core_mesh *mesh, norma_fault *fault);
/* ARGUMENT (face_starts) or INDEX or CANCELLED: reads the arrays. */
norma_result norma_core_mesh_content(core_call *call, core_mesh *mesh);

/* The same; and of each CORE_FACES_IN_CHUNK faces in a row, the least and the greatest position
 * that their corners name. */
enum { CORE_FACES_IN_CHUNK = 1024 };
typedef struct core_range {
    uint32_t least, most;
} core_range;
norma_result norma_core_mesh_ranges(core_call *call, core_mesh *mesh, core_range *ranges);

/* Of positions in doubles: the largest coordinate of those that are finite, 0 without any; and the
 * scale for it. */
double norma_core_largest_coordinate(const core_mesh *mesh);
double norma_core_scale_for(double largest);

/* Out of line, so that the common cases stay short. */
uint32_t norma_core_small_corner(const core_mesh *mesh, size_t corner);
void norma_core_other_position(const core_mesh *mesh, uint32_t index, double out[3]);

/* Of count corners in a row. */
void norma_core_read_corners(
    const core_mesh *mesh, size_t begin, size_t count, uint32_t *positions);

static inline uint32_t norma_core_corner(const core_mesh *mesh, size_t corner) {
    uint32_t index;
    if (mesh->corner_size != 4) return norma_core_small_corner(mesh, corner);
    memcpy(&index, (const unsigned char *)mesh->corners + 4 * corner, sizeof index);
    return index;
}

static inline void norma_core_double_position(
    const core_mesh *mesh, uint32_t index, double out[3]) {
    const unsigned char *at =
        (const unsigned char *)mesh->positions.data + index * mesh->positions.stride;
    for (size_t i = 0; i < 3; i++) {
        double p;
        memcpy(&p, at + i * sizeof p, sizeof p);
        out[i] = p * mesh->scale;
    }
}

static inline void norma_core_position(const core_mesh *mesh, uint32_t index, double out[3]) {
    if (mesh->positions.format != NORMA_FORMAT_FLOAT) {
        norma_core_other_position(mesh, index, out);
        return;
    }
    const unsigned char *at =
        (const unsigned char *)mesh->positions.data + index * mesh->positions.stride;
    for (size_t i = 0; i < 3; i++) {
        float p;
        memcpy(&p, at + i * sizeof p, sizeof p); /* one by one: no detour through memory */
        out[i] = (double)p;
    }
}

static inline uint32_t norma_core_welded(const core_mesh *mesh, uint32_t index) {
    return mesh->weld ? mesh->weld[index] : index;
}

static inline uint32_t norma_core_welded_corner(const core_mesh *mesh, size_t corner) {
    return norma_core_welded(mesh, norma_core_corner(mesh, corner));
}

static inline size_t norma_core_face_begin(const core_mesh *mesh, size_t face) {
    return mesh->face_starts ? mesh->face_starts[face] : 3 * face;
}
static inline size_t norma_core_face_end(const core_mesh *mesh, size_t face) {
    return mesh->face_starts ? mesh->face_starts[face + 1] : 3 * face + 3;
}

#endif
