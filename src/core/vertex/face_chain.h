/* face_chain.h: whether the faces at a position are one smooth fan, followed as they are added to
 * its sum, so that nobody has to sort them: nearly all positions of most meshes are.
 *
 * Each face leads from its next to its previous neighbour of the position. Faces whose ends meet
 * are chained, whatever order they come in, in a few chains at a time. All faces are one fan, every
 * edge between them shared by just two and smooth, where at the end there is one chain, all normals
 * lie within half the crease and 30 degrees of one axis, and the angles add up to what one turn can
 * hold. For then, seen along that axis, each face turns the same way round the position by less
 * than pi, and by cos 30 to 1 / cos 30 times its own angle: a closed chain turns by a multiple of 2
 * pi, which is 2 pi where its angles add up to less than 4 pi cos 30, and an open one by less than
 * 2 pi where they add up to less than 2 pi cos 30. So no neighbour is met twice, each edge has one
 * face on either side, none is another's reversed twin, and every dihedral angle is within the
 * crease. A polygon counts for as much where no corner of it bends by more than 10 degrees from its
 * normal: then 40 degrees take the place of 30. What fails may still be one fan: stars are made of
 * it. */
#ifndef NORMA_CORE_VERTEX_FACE_CHAIN_H
#define NORMA_CORE_VERTEX_FACE_CHAIN_H
#include "core/call/call.h"
#include "core/face/face.h"
#include <stdint.h>

enum { CORE_CHAINS = 3 };

typedef struct face_chains {
    float axis[3]; /* the first face's normal; NaN: stars are needed */
    int wide;      /* some normal is too far from it; another axis may do */
    uint32_t first[CORE_CHAINS], last[CORE_CHAINS]; /* where each begins and ends */
} face_chains;

static const uint32_t CORE_NO_CHAIN = UINT32_MAX; /* as first; of the first chain: no face */

/* The least cosine between normals and the axis for a crease; above 1: none will do. Floats lose
 * less of a cosine than is added here. */
static inline float norma_core_chain_cosine(double crease_angle_rad) {
    const double thirty = NORMA_PI / 6, half = 0.5 * crease_angle_rad;
    return (float)(cos(half < thirty ? half : thirty) + 1e-5);
}

CORE_INLINE void core_clear_chains(face_chains *c) {
    *c = (face_chains){.axis = {0, 0, 0}, .first = {CORE_NO_CHAIN, CORE_NO_CHAIN, CORE_NO_CHAIN}};
}

CORE_INLINE void core_break_chains(face_chains *c) {
    c->axis[0] = NAN;
    c->first[0] = 0;
}

CORE_INLINE int core_is_broken(const face_chains *c) { return !(c->axis[0] == c->axis[0]); }
CORE_INLINE int core_has_faces(const face_chains *c) { return c->first[0] != CORE_NO_CHAIN; }

/* Appends chain j to chain i, if it goes on where that ends. */
static inline int norma_core_append_chain(face_chains *c, int i, int j) {
    if (c->first[i] == CORE_NO_CHAIN || c->first[j] != c->last[i]) return 0;
    c->last[i] = c->last[j];
    c->first[j] = CORE_NO_CHAIN;
    return 1;
}

/* Into lower ones, so that all end in the first. */
static inline void norma_core_join_chains(face_chains *c) {
    for (int i = 0; i < CORE_CHAINS; i++)
        for (int j = i + 1; j < CORE_CHAINS; j++) {
            if (c->first[j] == CORE_NO_CHAIN) continue;
            if (!norma_core_append_chain(c, i, j) && norma_core_append_chain(c, j, i)) {
                c->first[i] = c->first[j];
                c->last[i] = c->last[j];
                c->first[j] = CORE_NO_CHAIN;
            } else if (c->first[j] != CORE_NO_CHAIN) {
                continue;
            }
            j = i; /* its ends are others now */
        }
}

/* A face that neither end of the first chain meets. */
static inline void norma_core_chain_apart(face_chains *c, uint32_t next, uint32_t previous) {
    for (int i = 1; i < CORE_CHAINS; i++) {
        const int is_there = c->first[i] != CORE_NO_CHAIN;
        if (is_there && c->last[i] == next) {
            c->last[i] = previous;
            return;
        }
        if (is_there && c->first[i] == previous) {
            c->first[i] = next;
            return;
        }
    }
    norma_core_join_chains(c);
    for (int i = 1; i < CORE_CHAINS; i++) {
        if (c->first[i] != CORE_NO_CHAIN) continue;
        c->first[i] = next;
        c->last[i] = previous;
        return;
    }
    core_break_chains(c);
}

/* One more face, of this normal. */
CORE_INLINE void core_follow_chains(
    face_chains *c, const float normal[3], float cosine, uint32_t next, uint32_t previous) {
    if (!core_has_faces(c)) {
        for (int k = 0; k < 3; k++) c->axis[k] = normal[k];
        c->first[0] = next;
        c->last[0] = previous;
        return;
    }
    const float along = c->axis[0] * normal[0] + c->axis[1] * normal[1] + c->axis[2] * normal[2];
    const int ends = c->last[0] == next, begins = c->first[0] == previous;
    c->wide |= !(along >= cosine);
    c->last[0] = ends ? previous : c->last[0];
    c->first[0] = (begins & !ends) ? next : c->first[0];
    if (!(ends | begins)) norma_core_chain_apart(c, next, previous);
}

static inline int norma_core_is_one_chain(const face_chains *c) {
    uint32_t others = CORE_NO_CHAIN;
    for (int i = 1; i < CORE_CHAINS; i++) others &= c->first[i];
    return others == CORE_NO_CHAIN;
}

/* Whether all faces are one chain that turns less than twice (an open one: less than once), if
 * their angles add up to this and their normals are near one axis. The limits are below 4 pi cos
 * 40, or 9.62, and 2 pi cos 30 and cos 40, or 5.44 and 4.81. */
static inline int norma_core_is_one_turn(face_chains *c, double angles, int polygons) {
    if (!core_has_faces(c) || core_is_broken(c)) return 0;
    if (!norma_core_is_one_chain(c)) norma_core_join_chains(c);
    if (!norma_core_is_one_chain(c)) return 0;
    return angles < (c->first[0] == c->last[0] ? 9 : polygons ? 4.8 : 5.4);
}
#endif
