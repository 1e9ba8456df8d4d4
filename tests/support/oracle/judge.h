/* judge.h: what the library says of a made case beyond normals (net.c): split meshes, plans,
 * orientation, tangents, matrices, arguments that are wrong. Each disagreement is printed and
 * counted in trial.total.wrong. */
#ifndef NORMA_TESTS_JUDGE_H
#define NORMA_TESTS_JUDGE_H
#include "oracle/compare.h"
#include "oracle/made_case.h"

typedef struct trial {
    const char *name;
    const made_case *made;
    norma_mesh mesh;       /* in guarded memory */
    norma_options options; /* as the case has them, but for stride, reasons and edges */
    oracle o;
    oracle_fans fans;
    comparison total;
    uint64_t salt;
    float *corner_normals; /* as they were judged */
} trial;

/* norma_split tells vertices apart by old vertex and the bits of the corner's normal, and numbers
 * them as corners first use them. */
void judge_split(trial *t);
/* A plan per corner gives the bits of norma_corner_normals; one per vertex the sum over the fans
 * that the vertex's corners lie in. When some vertices move, sums are those of the fans that were,
 * and nothing else is written. */
void judge_plans(trial *t);
/* After the faces that norma_orient names are turned, no two in a part that has two sides run along
 * an edge the same way, and a closed part apart from all others has no negative volume (of
 * triangles whose coordinates are small whole numbers). */
void judge_orientation(trial *t);

/* A call with one wrong argument is refused with the right result, and writes nothing. */
void judge_arguments(trial *t);
/* Steady tangents are the sums that they are said to be; all are unit, of a sign, with reasons. */
void judge_tangents(trial *t);
/* Normal matrices are exact cofactors, rounded; normals go through them. */
void judge_matrices(trial *t);

void complain(trial *t, const char *what, size_t index);
/* A random number below bound, of the case's own chain. */
uint32_t trial_below(trial *t, uint32_t bound);
void *trial_array(trial *t, size_t count, size_t size); /* guarded, poisoned, at either end */
#endif
