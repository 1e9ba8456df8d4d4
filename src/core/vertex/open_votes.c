/* open_votes.c: faces vote as in norma_vertex_normals, one by one. */
#include "core/vertex/open_votes.h"
#include "core/call/call.h"
#include "core/face/face.h"

static void vote(const open_voting *voting, size_t f, const core_face *face, open_sum *sums) {
    const core_mesh *mesh = voting->mesh;
    double normal[3];
    for (int k = 0; k < 3; k++) normal[k] = voting->reversed ? -face->normal[k] : face->normal[k];
    for (size_t c = norma_core_face_begin(mesh, f); c < norma_core_face_end(mesh, f); c++)
        if (norma_core_is_kept(mesh, f, c))
            norma_core_open_sum_add(&sums[norma_core_welded_corner(mesh, c)],
                norma_core_corner_weight(mesh, voting->weight, f, face, c), normal);
}

void norma_core_open_votes(const open_voting *voting, open_sum *sums, norma_count *degenerate) {
    const core_mesh *mesh = voting->mesh;
    for (size_t f = 0; f < mesh->face_count; f++) {
        core_face face;
        if (voting->silent && voting->silent[f]) continue;
        norma_core_face_geometry(mesh, f, &face);
        if (face.flags & CORE_FACE_DIRECTED)
            vote(voting, f, &face, sums);
        else if ((face.flags & CORE_FACE_FINITE) &&
                 norma_core_face_begin(mesh, f) < norma_core_face_end(mesh, f))
            norma_core_count_one(degenerate, f);
    }
}

int norma_core_open_direction(const open_sum *sum, double direction[3]) {
    double weight;
    for (int k = 0; k < 3; k++) direction[k] = 0;
    if (!sum->votes) return NORMA_REASON_UNREFERENCED;
    norma_core_open_sum_value(sum, direction, &weight);
    return norma_core_cancels(direction, weight) ? NORMA_REASON_CANCELLED : NORMA_REASON_NONE;
}
