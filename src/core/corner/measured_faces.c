/* measured_faces.c: eight triangles at a time, from the edges of the mesh to normals and weights.
 */
#include "core/corner/measured_faces.h"
#include "core/face/measure.h"

void norma_core_clear_measured(measured_faces *m) {
    memset(m->number, 0xff, sizeof m->number);
    memset(m->used, 0, sizeof m->used);
    m->batch = 1;
    m->waiting_count = 0;
}

static void load_triangle(const core_mesh *mesh, uint32_t face, core_batch *batch, int lane) {
    double p[3][3];
    for (size_t k = 0; k < 3; k++)
        norma_core_position(mesh, norma_core_corner(mesh, 3 * (size_t)face + k), p[k]);
    core_set_edges(batch, lane, (const double(*)[3])p);
}

static void keep(const core_batch *batch, int lane, measured_face *to) {
    for (int k = 0; k < 3; k++) {
        to->normal[k] = batch->normal[k][lane];
        to->weight[k] = batch->weight[k][lane];
    }
    to->normal[3] = batch->sure[lane];
}

void norma_core_measure_waiting(const core_prepared_mesh *prepared, measured_faces *m) {
    const core_call *call = prepared->call;
    for (uint32_t from = 0; from < m->waiting_count; from += CORE_LANES) {
        core_batch batch;
        const uint32_t left = m->waiting_count - from;
        for (uint32_t i = 0; i < CORE_LANES; i++)
            load_triangle(&prepared->mesh, m->waiting[from + (i < left ? i : 0)], &batch, (int)i);
        norma_core_measure(call->level, &batch, call->options.weight, CORE_ALL_CORNERS);
        for (uint32_t i = 0; i < CORE_LANES && i < left; i++)
            keep(&batch, (int)i, &m->faces[m->waiting_place[from + i]]);
    }
    m->waiting_count = 0;
    m->batch++;
}
