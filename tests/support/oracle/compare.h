/* compare.h: the library's answers beside the oracle's, for any mesh and options. Each disagreement
 * is printed (the first few of a call) and counted. */
#ifndef NORMA_TESTS_COMPARE_H
#define NORMA_TESTS_COMPARE_H
#include "oracle/oracle.h"

#define COMPARE_FACE_RAD  1e-7L
#define COMPARE_SUM_RAD   2e-7L /* where |sum| > 1e-3 sum of weights */
#define COMPARE_DOUBT_RAD 1e-12L

typedef struct comparison {
    size_t elements;   /* normals compared */
    size_t wrong;      /* disagreements of any kind */
    size_t doubtful;   /* not judged: at the very edge of a threshold, or nearly cancelled, or too
                          many normals for the brute force */
    long double worst; /* angle, of those judged */
} comparison;

/* What a call gave, tightly packed. Of options, weight, fallback and fallback_normal count. every:
 * compares each every-th element only (1: all, and the report as well). */
typedef struct answer {
    const float *normals;
    const uint8_t *reasons;
    const norma_report *report;
    const norma_edges *edges; /* of corners; or NULL, where edges are not counted */
} answer;
void judge_faces(comparison *total, const char *name, const oracle *o, const norma_options *options,
    const answer *a);
void judge_vertices(comparison *total, const char *name, const oracle *o,
    const norma_options *options, const answer *a, size_t every);
void judge_corners(comparison *total, const char *name, const oracle *o, const oracle_fans *fans,
    const norma_options *options, const answer *a);
/* As a plan gives them: of each vertex, over the fans that its corners lie in. */
void judge_fans_of_vertices(comparison *total, const char *name, const oracle *o,
    const oracle_fans *fans, const norma_options *options, const answer *a);

/* Options give weight, weld, non_manifold, threads and so on; the fallback is left as it is there,
 * reasons are the comparison's own. name is for messages. */
void compare_faces(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    const norma_options *options);
void compare_vertices(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    const norma_options *options, size_t every);
void compare_corners(comparison *total, const char *name, const oracle *o, const norma_mesh *mesh,
    float crease_rad, const norma_options *options);

/* All three for all weights (VISIBLE included), both treatments of non-manifold edges and the
 * creases 0, 30, 60, 180 degrees; returns how many are wrong. */
size_t compare_everything(
    const char *name, const norma_mesh *mesh, norma_weld weld, double distance);

#endif
