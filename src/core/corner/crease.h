/* crease.h: the crease rule, the one place that says which shared edges are smooth: the dihedral
 * angle is at most the crease, no side marks the edge hard, and where smoothing groups are given
 * the two faces have one in common. Most angles are decided by their cosine, which loops over many
 * edges can compare; the angle itself is taken only where the cosine is too near the crease's. */
#ifndef NORMA_CORE_CREASE_H
#define NORMA_CORE_CREASE_H
#include "core/mesh/mesh.h"

typedef struct core_crease {
    double angle;  /* the greatest dihedral angle that is smooth, the tolerance in it; beyond pi:
                      every angle */
    double cosine; /* about its cosine; 2 where no angle is smooth, -2 where all are */
} core_crease;

/* ARGUMENT where it is NaN, infinite or above pi, as degrees would be; fault may be NULL. */
norma_result norma_core_check_crease(float crease_angle_rad, norma_fault *fault);
core_crease norma_core_crease_at(double crease_angle_rad);

typedef enum core_crease_verdict {
    CORE_CREASE_UNDECIDED = -1,
    CORE_CREASE_HARD,
    CORE_CREASE_SMOOTH
} core_crease_verdict;

/* By the cosine of the dihedral angle: the dot product of the two unit normals. Its doubt is beyond
 * the rounding of both. */
static const double CORE_COSINE_DOUBT = 0x1p-30;
static inline int norma_core_is_surely_smooth(const core_crease *crease, double cosine) {
    return cosine > crease->cosine + CORE_COSINE_DOUBT;
}
static inline int norma_core_is_surely_hard(const core_crease *crease, double cosine) {
    return cosine < crease->cosine - CORE_COSINE_DOUBT;
}
static inline core_crease_verdict norma_core_crease_by_cosine(
    const core_crease *crease, double cosine) {
    if (norma_core_is_surely_smooth(crease, cosine)) return CORE_CREASE_SMOOTH;
    return norma_core_is_surely_hard(crease, cosine) ? CORE_CREASE_HARD : CORE_CREASE_UNDECIDED;
}

/* The same where the cosine does not decide it: by the angle. */
int norma_core_is_within_crease(const core_crease *crease, const double a[3], const double b[3]);

/* Whether the caller's marks leave the edge smooth: corner at which the edge begins in one face,
 * and in the face that runs along it the other way. */
static inline int norma_core_is_unmarked(const core_mesh *mesh, uint32_t corner, uint32_t face,
    uint32_t other_corner, uint32_t other_face) {
    if (mesh->hard_edges && (mesh->hard_edges[corner] || mesh->hard_edges[other_corner])) return 0;
    return !mesh->smoothing_groups ||
           (mesh->smoothing_groups[face] & mesh->smoothing_groups[other_face]);
}
#endif
