/* measured_faces.c: eight triangles at a time, from the edges of the mesh to normals and weights.
 */
#include "core/corner/measured_faces.h"
#include "core/face/eight_vectors.h"
#include "core/face/face.h"

void norma_core_clear_measured(measured_faces *m) {
    memset(m->number, 0xff, sizeof m->number);
    memset(m->used, 0, sizeof m->used);
    m->batch = 1;
    m->waiting_count = 0;
}

CORE_INLINE void load_edges(
    const core_mesh *mesh, const uint32_t at[3 * CORE_LANES], core_batch *batch) {
    double p[3][3];
    if (core_can_gather(mesh)) {
        core_gather_edges(core_points_of(mesh, at, 3), batch);
        return;
    }
    for (int i = 0; i < CORE_LANES; i++) {
        for (int k = 0; k < 3; k++) norma_core_position(mesh, at[3 * i + k], p[k]);
        core_set_edges(batch, i, (const double(*)[3])p);
    }
}

/* Eight faces, and where they go. */
typedef void measure_eight(
    const core_prepared_mesh *s, const uint32_t *faces, const uint16_t *places, measured_face *out);

CORE_INLINE void measure(const core_prepared_mesh *s, const uint32_t *faces, const uint16_t *places,
    measured_face *out) {
    uint32_t at[3 * CORE_LANES];
    core_batch b;
    core_rows normals, weights;
    for (size_t i = 0; i < CORE_LANES; i++)
        for (size_t k = 0; k < 3; k++)
            at[3 * i + k] = norma_core_corner(&s->mesh, 3 * (size_t)faces[i] + k);
    load_edges(&s->mesh, at, &b);
    norma_core_measure(s->call->level, &b, s->call->options.weight, CORE_ALL_CORNERS);
    core_lanes_to_rows(b.normal[0], b.normal[1], b.normal[2], b.sure, &normals);
    core_lanes_to_rows(b.weight[0], b.weight[1], b.weight[2], b.sure, &weights);
    for (size_t i = 0; i < CORE_LANES; i++) {
        memcpy(out[places[i]].normal, normals.row[i], sizeof out->normal);
        memcpy(out[places[i]].weight, weights.row[i], sizeof out->weight);
    }
}

static void measure_portable(const core_prepared_mesh *s, const uint32_t *faces,
    const uint16_t *places, measured_face *out) {
    measure(s, faces, places, out);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void measure_avx2(const core_prepared_mesh *s, const uint32_t *faces,
    const uint16_t *places, measured_face *out) {
    measure(s, faces, places, out);
}
static measure_eight *const MEASURE[] = {
    measure_portable, measure_avx2, measure_avx2}; /* rows are of four */
#else
static measure_eight *const MEASURE[] = {measure_portable};
#endif

void norma_core_measure_waiting(const core_prepared_mesh *prepared, measured_faces *m) {
    measure_eight *const measure_them = MEASURE[prepared->call->level];
    for (uint32_t i = m->waiting_count; i % CORE_LANES; i++) {
        m->waiting[i] = m->waiting[0];
        m->waiting_place[i] = m->waiting_place[0];
    }
    for (uint32_t i = 0; i < m->waiting_count; i += CORE_LANES)
        measure_them(prepared, m->waiting + i, m->waiting_place + i, m->room);
    m->waiting_count = 0;
    m->batch++;
}

/* ---- small meshes */

/* No more than what is small beside a thread's stack: 64 kB. */
enum { SMALL_FACES = 1 << 10, FACES_IN_TASK = 1 << 9 };
_Static_assert(SMALL_FACES <= UINT16_MAX, "a place is a face's number");

static void measure_task(void *context, size_t task) {
    const core_prepared_mesh *s = context;
    const size_t count = s->mesh.face_count, begin = task * FACES_IN_TASK,
                 end = count - begin < FACES_IN_TASK ? count : begin + FACES_IN_TASK;
    for (size_t f = begin; f < end; f += CORE_LANES) {
        uint32_t faces[CORE_LANES];
        uint16_t places[CORE_LANES];
        for (size_t i = 0; i < CORE_LANES; i++) {
            faces[i] = (uint32_t)(f + i < end ? f + i : f);
            places[i] = (uint16_t)faces[i];
        }
        MEASURE[s->call->level](s, faces, places, s->measured);
    }
}

norma_result norma_core_measure_small(core_prepared_mesh *s) {
    const size_t faces = s->mesh.face_count;
    if (s->mesh.face_starts || s->measured || faces > SMALL_FACES ||
        s->corners_of.starts[s->corners_of.position_count] < faces)
        return NORMA_OK;
    if (!(s->measured = norma_core_allocate(s->call, faces, sizeof *s->measured)))
        return NORMA_ERROR_MEMORY;
    return norma_core_parallel(
        s->call, faces / FACES_IN_TASK + (faces % FACES_IN_TASK != 0), measure_task, s);
}
