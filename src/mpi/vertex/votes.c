/* votes.c: triangles are measured eight at a time, as the core does; what doubles do not decide,
 * and polygons, by themselves. */
#include "mpi/vertex/votes.h"
#include "core/call/weight.h"

static norma_weight weight_of(const mpi_visit *visit) {
    const norma_weight weight = visit->prepared->call->options.weight;
    return weight == NORMA_WEIGHT_VISIBLE ? NORMA_WEIGHT_UNIFORM : weight;
}

static void visit_one(const mpi_visit *visit, size_t f) {
    const core_mesh *mesh = &visit->prepared->mesh;
    core_face face;
    norma_core_prepared_mesh_face(visit->prepared, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) {
        if (face.flags & CORE_FACE_FINITE) visit->degenerate(visit->context, f);
        return;
    }
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++) {
        if (!norma_core_is_kept(mesh, f, c)) continue;
        visit->vote(visit->context, f, c,
            norma_core_corner_weight(mesh, weight_of(visit), f, &face, c), face.normal);
    }
}

static void visit_lane(const mpi_visit *visit, const core_batch *batch, int lane, size_t f) {
    const norma_weight weight = weight_of(visit);
    const int even = core_weighed(weight) == CORE_BY_FACE;
    const double normal[3] = {
        batch->normal[0][lane], batch->normal[1][lane], batch->normal[2][lane]};
    for (size_t k = 0; k < 3; k++)
        visit->vote(visit->context, f, 3 * f + k,
            even ? norma_core_weight_of(weight, 0, 0, 0, 0, batch->twice_area[lane])
                 : batch->weight[k][lane],
            normal);
}

static void visit_triangles(const mpi_visit *visit, const size_t *faces, int count) {
    const core_prepared_mesh *prepared = visit->prepared;
    const norma_weight weight = weight_of(visit);
    core_batch batch;
    int edged[CORE_LANES];
    for (int i = 0; i < CORE_LANES; i++)
        edged[i] = norma_core_load_lane(&prepared->mesh, faces[i < count ? i : 0], &batch, i);
    norma_core_measure(prepared->call->level, &batch, weight,
        core_weighed(weight) == CORE_BY_FACE ? CORE_NO_CORNER : CORE_ALL_CORNERS);
    for (int i = 0; i < count; i++) {
        if (edged[i] && batch.sure[i] != 0)
            visit_lane(visit, &batch, i, faces[i]);
        else
            visit_one(visit, faces[i]);
    }
}

void norma_mpi_visit_votes(const mpi_visit *visit) {
    size_t faces[CORE_LANES];
    int count = 0;
    for (size_t i = 0; i < visit->faces->count; i++) {
        const size_t f = norma_mpi_face(visit->faces, i);
        if (!visit->wants(visit->context, f)) continue;
        if (visit->prepared->mesh.face_starts) {
            visit_one(visit, f);
            continue;
        }
        faces[count++] = f;
        if (count < CORE_LANES) continue;
        visit_triangles(visit, faces, count);
        count = 0;
    }
    if (count) visit_triangles(visit, faces, count);
}
