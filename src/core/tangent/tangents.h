/* tangents.h: what every way of making tangents works on: the vertices that corners share, and the
 * caller's tangents. */
#ifndef NORMA_CORE_TANGENTS_H
#define NORMA_CORE_TANGENTS_H
#include "core/mesh/input_mesh.h"
#include "core/call/output.h"

typedef struct tangent_vertex {
    float position[3], normal[3], texcoord[2];
} tangent_vertex;

/* A key is a position where all attributes are per vertex, else a corner. */
typedef struct tangent_mesh {
    core_call *call;
    core_mesh mesh;
    const norma_attribute *normals, *texcoords;
    int by_position;
    size_t key_count;
    tangent_vertex *vertices; /* of each key */
    const uint32_t *weld;     /* NULL, or of each key the least that is equal to it (-0 = 0); NaN is
                                 equal to nothing */
    uint32_t *own_weld;       /* NULL where the weld is none, or a plan's */
    const struct tangent_known *known; /* NULL, or what a plan knows of it */
    int *is_awkward; /* NULL, or the mesh is a part: where its tangents may hang on the rest of the
                        mesh, this is set and nothing written */
} tangent_mesh;

/* ARGUMENT or OVERFLOW: what can be told without reading the arrays; mesh->mesh is checked. */
norma_result norma_core_tangent_attributes(
    tangent_mesh *mesh, const norma_attribute *normals, const norma_attribute *texcoords);
/* INDEX, MEMORY or CANCELLED; on success norma_core_tangent_close releases it. */
norma_result norma_core_tangent_open(tangent_mesh *mesh);
void norma_core_tangent_close(tangent_mesh *mesh);

/* The two steps of opening. */
norma_result norma_core_tangent_read(tangent_mesh *mesh);
norma_result norma_core_tangent_weld(tangent_mesh *mesh);
/* Reads one vertex; key: the position or, unless it is by_position, the corner. 0: a corner names
 * no value. */
int norma_core_tangent_read_key(const tangent_mesh *mesh, size_t key, tangent_vertex *vertex);
norma_result norma_core_tangent_weld_vertices(
    core_call *call, const tangent_vertex *vertices, size_t count, uint32_t *weld, size_t *found);
int norma_core_tangent_are_equal(const tangent_vertex *a, const tangent_vertex *b);

static inline uint32_t norma_core_tangent_key(const tangent_mesh *mesh, size_t corner) {
    return mesh->by_position ? norma_core_corner(&mesh->mesh, corner) : (uint32_t)corner;
}
static inline uint32_t norma_core_tangent_vertex(const tangent_mesh *mesh, size_t corner) {
    const uint32_t key = norma_core_tangent_key(mesh, corner);
    return mesh->weld ? mesh->weld[key] : key;
}

/* Where meshes are in no order, memory is slow, and asked for what is read soon. */
#if defined(__GNUC__)
#define TANGENT_PREFETCH(at) __builtin_prefetch(at)
#else
#define TANGENT_PREFETCH(at) ((void)(at))
#endif
enum { TANGENT_FACES_AHEAD = 12 };

/* Asks for the vertices of a face. */
static inline void norma_core_tangent_await(const tangent_mesh *m, size_t face) {
    if (face >= m->mesh.face_count) return;
    const size_t end = norma_core_face_end(&m->mesh, face);
    for (size_t c = norma_core_face_begin(&m->mesh, face); c < end; c++)
        TANGENT_PREFETCH(&m->vertices[norma_core_tangent_key(m, c)]);
}

static inline int norma_core_tangent_is_finite(const tangent_vertex *v) {
    float zero = 0; /* NaN minus itself is NaN, and so is infinity minus itself */
    for (int k = 0; k < 3; k++) zero += v->position[k] - v->position[k];
    for (int k = 0; k < 3; k++) zero += v->normal[k] - v->normal[k];
    for (int k = 0; k < 2; k++) zero += v->texcoord[k] - v->texcoord[k];
    return zero == 0;
}

/* ---- the caller's tangents */

typedef struct tangent_output {
    unsigned char *tangents;
    size_t stride;
    uint8_t *reasons;
} tangent_output;

typedef struct corner_tangent {
    float direction[3];
    float sign;
    int reason; /* other than NONE: the direction is not looked at */
} corner_tangent;

/* ARGUMENT, CAPACITY or OVERFLOW where count tangents cannot go to tangents. */
norma_result norma_core_tangent_output_open(const norma_options *options, float *tangents,
    size_t count, size_t capacity, tangent_output *output);

/* Writes the tangent of a corner whose own vertex this is, or what it gets instead; counts the
 * latter. */
void norma_core_write_tangent(const tangent_output *output, size_t corner,
    const tangent_vertex *vertex, const corner_tangent *tangent, core_tally *tally);

/* The same in two steps, for tangents that many corners of one vertex have. */
typedef struct written_tangent {
    float numbers[4];
    int reason;
} written_tangent;
written_tangent norma_core_tangent_to_write(
    const tangent_vertex *vertex, const corner_tangent *tangent);

static inline void norma_core_put_tangent(const tangent_output *output, size_t corner,
    const written_tangent *tangent, core_tally *tally) {
    memcpy(output->tangents + corner * output->stride, tangent->numbers, sizeof tangent->numbers);
    if (output->reasons) output->reasons[corner] = (uint8_t)tangent->reason;
    if (tangent->reason != NORMA_REASON_NONE) norma_core_tally(tally, tangent->reason, corner);
}

/* The two modes: each writes every corner once. */
norma_result norma_core_mikk_tangents(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally);
norma_result norma_core_steady_tangents(
    const tangent_mesh *mesh, const tangent_output *output, core_tally *tally);
#endif
