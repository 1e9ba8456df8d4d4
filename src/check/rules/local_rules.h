/* local_rules.h: rules that need no neighbours, so that a file can be looked at part by part. Each
 * has a sum, zero-initialised, to which _look adds what a mesh shows; _add makes the findings, and
 * leaves the sum empty, as _drop does. */
#ifndef NORMA_CHECK_LOCAL_RULES_H
#define NORMA_CHECK_LOCAL_RULES_H
#include "check/findings/check_run.h"

/* lengths.c: N101 to N103. idle: normals of no length that only degenerate faces use. */
typedef struct check_lengths {
    check_hits non_finite, zero, non_unit;
} check_lengths;
void norma_check_lengths_drop(check_lengths *sum);
norma_result norma_check_lengths_look(check_mesh *m, check_lengths *sum);
norma_result norma_check_lengths_add(check_mesh *m, check_lengths *sum, size_t idle);

/* facets.c: N205. behind: NULL, or a mark for each face whose normal is on its other side. The
 * caller fills whole_area (twice the area of all faces), turned (facets whose winding is known to
 * be wrong) and undecided (it may be). */
typedef struct check_facets {
    check_hits hits;
    size_t zeros, turned, undecided;
    double twice_area, whole_area; /* twice_area: of those that were hit */
} check_facets;
norma_result norma_check_facets_look(check_mesh *m, check_facets *sum, uint8_t *behind);
norma_result norma_check_facets_add(check_mesh *m, check_facets *sum);

/* face_shapes.c: N401, N402. */
typedef struct check_shapes {
    check_hits degenerate, slivers;
} check_shapes;
void norma_check_shapes_drop(check_shapes *sum);
norma_result norma_check_shapes_look(check_mesh *m, check_shapes *sum);
norma_result norma_check_shapes_add(check_mesh *m, check_shapes *sum);

/* polygons.c: N404, N405. */
typedef struct check_folds {
    check_hits hits;
    size_t crossing; /* of them: their edges cross */
} check_folds;
typedef struct check_polygons {
    check_folds folds, slight; /* slight: what faces away is next to nothing of the polygon */
    check_hits bent;
} check_polygons;
void norma_check_polygons_drop(check_polygons *sum);
norma_result norma_check_polygons_look(check_mesh *m, check_polygons *sum);
norma_result norma_check_polygons_add(check_mesh *m, check_polygons *sum);

/* precision.c: N701 and N702. */
typedef struct check_largest {
    double coordinate; /* its absolute value; 0: none but zeros */
    size_t vertex;
} check_largest;
/* Takes a larger one of these positions, which are those from first on. */
void norma_check_find_largest(const core_mesh *mesh, size_t first, check_largest *largest);
/* An edge below this length is too short for such coordinates; 0: none is. */
double norma_check_coarse_length(const check_mesh *m, const check_largest *largest);
/* Sorts the edges by ascending lengths: counts[i] of count + 1 numbers grows by those that are
 * shorter than length i and not than the one before. Once more than enough are no shorter than the
 * last length, the others may be left out. After norma_check_weld. */
norma_result norma_check_sort_edges(
    check_mesh *m, const double *lengths, size_t count, size_t enough, size_t *counts);
/* Finds the length below high that half of the edges are shorter than. shorter: writes how many are
 * shorter than the middle of low and high, and how many there are. */
typedef norma_result check_ask_shorter(
    void *context, double low, double high, size_t *shorter, size_t *all);
norma_result norma_check_median_edge(
    double high, check_ask_shorter *ask, void *context, double *median);
norma_result norma_check_distance_add(check_mesh *m, const check_largest *largest, double median);
norma_result norma_check_encoding_add(check_mesh *m);
#endif
