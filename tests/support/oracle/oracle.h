/* oracle.h: what DESIGN.md's "Exactly" says, computed slowly and independently of the library: face
 * vectors exactly (GMP), edges by sorting all half-edges of the mesh, fans by flooding, the nearest
 * fallback by trying all. Nothing here shares code or method with src/core. */
#ifndef NORMA_TESTS_ORACLE_H
#define NORMA_TESTS_ORACLE_H
#include <norma/norma.h>

#define ORACLE_NONE SIZE_MAX

typedef enum oracle_face_kind {
    ORACLE_DIRECTED,
    ORACLE_NO_AREA,
    ORACLE_FEW,
    ORACLE_NON_FINITE,
    ORACLE_NON_FINITE_FEW
} oracle_face_kind;

/* What a corner's weights are made of: its angle, |a x b|, a . a and b . b of its edges a and b. */
typedef struct oracle_corner_measures {
    long double angle, sine_lengths, a_squared, b_squared;
    int known;
} oracle_corner_measures;

typedef struct oracle {
    size_t position_count, corner_count, face_count;
    double (*positions)[3];
    size_t *starts;  /* face_count + 1 */
    size_t *corners; /* position of each corner */
    size_t *faces;   /* face of each corner */
    size_t *shared;  /* of each position: the number of the welded position that it is */
    size_t shared_count;
    size_t *kept; /* of each corner: the corner that stands for it, itself or a later one of its
                     run; NONE: the face has no edges */
    size_t *next, *previous; /* of each corner that stands for itself: its neighbours among those */
    oracle_face_kind *kinds;
    long double (*directions)[3]; /* of each face, unit; zero without one */
    long double *areas;           /* twice the area */
    size_t *by_shared_start;      /* shared_count + 1 offsets into by_shared: */
    size_t *by_shared;            /* the kept corners at each welded position, ascending */
    const uint32_t *smoothing_groups;
    const uint8_t *hard_edges;
    oracle_corner_measures *measures; /* of each corner whose weight was once asked for */
} oracle;

/* The mesh must be valid; its groups and hard edges must outlive the oracle. Aborts when memory
 * runs out. */
void oracle_create(oracle *o, const norma_mesh *mesh, norma_weld weld, double distance);
void oracle_destroy(oracle *o);
/* The same faces and shared positions with other positions, as many. */
void oracle_move(oracle *o, const norma_vec3_view *positions);

/* Whether a kept corner's edges, seen along its face's vector area, turn the other way, exactly. */
int oracle_turns_back(const oracle *o, size_t corner);
/* A kept corner's weight, any but VISIBLE; its face must have a direction. */
long double oracle_weight(const oracle *o, size_t corner, norma_weight weight);

typedef struct oracle_normal {
    enum norma_reason reason;
    long double normal[3]; /* unit where the reason is NONE */
    long double ratio; /* |sum| / sum of weights; VISIBLE: the cosine of the smallest cone's half
                          angle (<= 0: cancelled) */
    int doubtful;      /* no answer: VISIBLE with more normals than brute force likes */
} oracle_normal;

/* The sum over the given kept corners. NONE, UNREFERENCED or CANCELLED. */
oracle_normal oracle_sum(const oracle *o, const size_t *corners, size_t count, norma_weight weight);
/* That over those of them that are the vertex's own; without any, it is cancelled. */
oracle_normal oracle_own_sum(
    const oracle *o, size_t vertex, const size_t *corners, size_t count, norma_weight weight);
oracle_normal oracle_face(const oracle *o, size_t face);

typedef struct oracle_fans {
    size_t *fan; /* of each corner: the number of its fan; a corner without edges has a fan for
                    itself */
    size_t fan_count;
    size_t *start, *corners; /* the kept corners of each fan, ascending */
    unsigned char *doubtful; /* of each fan: an edge of it lies so near the threshold that either
                                answer passes */
    norma_count non_manifold, conflicts;
    norma_edges edges;
    float crease_rad;
} oracle_fans;

/* doubt_rad: how near to the threshold a dihedral angle is doubtful. */
void oracle_fans_create(oracle_fans *fans, const oracle *o, float crease_rad,
    norma_non_manifold non_manifold, long double doubt_rad);
void oracle_fans_destroy(oracle_fans *fans);
oracle_normal oracle_corner(
    const oracle *o, const oracle_fans *fans, size_t corner, norma_weight weight);
/* The kept corners of all fans in which a corner of the vertex lies; returns how many. */
size_t oracle_fans_of(
    const oracle *o, const oracle_fans *fans, size_t vertex, size_t *corners, int *doubtful);

/* Where each element that has no normal (reasons) gets it from under NORMA_FALLBACK_NEAREST: the
 * element, or NONE. positions: of each element its vertex. */
size_t oracle_nearest(
    const oracle *o, const size_t *vertices, const uint8_t *reasons, size_t count, size_t element);

long double oracle_angle(const long double a[3], const long double b[3]);
int oracle_finite(const double p[3]);
void *oracle_allocate(size_t count, size_t size); /* zeroed; aborts when memory runs out */
#endif
