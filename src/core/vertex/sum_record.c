/* sum_record.c: votes added one face at a time, and sums made normals one at a time. The kernels of
 * add_triangles.c do the same for many at once. */
#include "core/vertex/sum_record.h"
#include "core/call/call.h"

void norma_core_add_vote(vertex_sum *sum, double weight, const double normal[3]) {
    sum->x += weight * normal[0];
    sum->y += weight * normal[1];
    sum->z += weight * normal[2];
    sum->weight += weight;
}

void norma_core_clear_sums(vertex_sum *sums, size_t count) {
    for (size_t i = 0; i < count; i++) sums[i] = (vertex_sum){0, 0, 0, -0.0};
}

void norma_core_add_face(void *context, size_t f) {
    const core_face_adder *adder = context;
    const core_prepared_mesh *prepared = adder->prepared;
    const core_mesh *mesh = &prepared->mesh;
    const size_t begin = norma_core_face_begin(mesh, f), end = norma_core_face_end(mesh, f);
    core_face face;
    norma_core_prepared_mesh_face(prepared, f, &face);
    if (!(face.flags & CORE_FACE_DIRECTED)) {
        if (begin < end && (face.flags & CORE_FACE_FINITE) &&
            norma_core_welded_corner(mesh, begin) - adder->first < adder->count)
            norma_core_count_one(adder->degenerate, f);
        return;
    }
    for (size_t c = begin; c < end; c++) {
        const uint32_t sum = norma_core_welded_corner(mesh, c) - adder->first;
        if (sum >= adder->count || !norma_core_is_kept(mesh, f, c)) continue;
        norma_core_add_vote(&adder->sums[sum],
            norma_core_corner_weight(mesh, prepared->call->options.weight, f, &face, c),
            face.normal);
    }
}

static void sum_of(const vertex_sum *s, double sum[3]) {
    sum[0] = s->x;
    sum[1] = s->y;
    sum[2] = s->z;
}

int norma_core_record_cancels(const vertex_sum *s) {
    double sum[3];
    sum_of(s, sum);
    return norma_core_has_votes(s) && norma_core_cancels(sum, s->weight);
}

int norma_core_resolve_record(
    const core_mesh *mesh, const vertex_sum *s, size_t vertex, float normal[3]) {
    double sum[3];
    if (!norma_core_has_votes(s)) {
        norma_core_position(mesh, (uint32_t)vertex, sum);
        return norma_core_finite(sum) ? NORMA_REASON_UNREFERENCED : NORMA_REASON_NON_FINITE;
    }
    sum_of(s, sum);
    if (norma_core_cancels(sum, s->weight)) return NORMA_REASON_CANCELLED;
    norma_core_direction(sum, normal);
    return NORMA_REASON_NONE;
}
