/* mesh_rules.h: the families of rules about the shape of one mesh and its normals. Each function
 * looks at its rules on one mesh. */
#ifndef NORMA_CHECK_MESH_RULES_H
#define NORMA_CHECK_MESH_RULES_H
#include "check/findings/check_run.h"

norma_result norma_check_lengths(check_mesh *m);     /* lengths.c: N101 to N103 */
norma_result norma_check_facing(check_mesh *m);      /* facing.c, far_normals.c: N201, N202 */
norma_result norma_check_placeholder(check_mesh *m); /* placeholder.c: N203 */
norma_result norma_check_deviation(check_mesh *m);   /* deviation.c: N204 */
norma_result norma_check_frame(check_mesh *m);       /* frame.c: N206 */
norma_result norma_check_facets(check_mesh *m);      /* facets.c: N205 */
norma_result norma_check_edges(check_mesh *m);       /* edges.c: N301, N303, N305, N306 */
norma_result norma_check_solids(check_mesh *m);      /* solids.c: N302, N304 */
norma_result norma_check_open_edges(check_mesh *m);  /* open_edges.c: N307 */
norma_result norma_check_shapes(check_mesh *m);      /* face_shapes.c: N401, N402 */
norma_result norma_check_cancelled(check_mesh *m);   /* cancelled.c: N403 */
norma_result norma_check_polygons(check_mesh *m);    /* polygons.c: N404, N405 */
norma_result norma_check_seams(check_mesh *m);       /* seams.c: N501 */
norma_result norma_check_coincident(check_mesh *m);  /* coincident.c: N503 */
norma_result norma_check_precision(check_mesh *m);   /* precision.c: N502, N701, N702 */

/* edges.c: fills topology.partners, and adds the findings of edges that are wanted; once a mesh. */
norma_result norma_check_pairs(check_mesh *m);

/* Each looks at what the rule is about, whether it is wanted or not, once a mesh. */
norma_result norma_check_is_placeholder(check_mesh *m, int *is); /* placeholder.c: N203 holds */
norma_result norma_check_deviation_of(
    check_mesh *m, const norma_deviation **deviation); /* deviation.c: corners 0: none */
norma_result norma_check_opposed(check_mesh *m);       /* opposed.c: fills m->opposed */
/* frame.c: N206 holds: N201, N202 and N501 are silent then. */
norma_result norma_check_is_of_another_frame(check_mesh *m, int *is);

/* sides.c: which faces are turned, as core_side_judge says; asked: a mark for each face that
 * matters. sides: of each face of the mesh. */
norma_result norma_check_sides(check_mesh *m, const uint8_t *asked, uint8_t *sides);
void norma_check_sides_drop(check_run *run);
/* Of an STL's facets whose sides neither volume nor rays decide: a normal within 25 degrees of its
 * winding, or of its winding's opposite, that agrees with its neighbours' says which it is. */
#define CHECK_LEAN_COSINE 0.9063077870366499
norma_result norma_check_sides_by_facets(
    const core_side_judge *judge, const norma_vec3_view *normals, uint8_t *sides);
int norma_check_is_turned(uint8_t side); /* shown to be, not only different from most */
/* After that: how many faces are shown to be turned, of those and of all in components whose faces
 * do not agree. */
size_t norma_check_count_turned(const check_mesh *m, const uint8_t *asked, const uint8_t *sides);

/* Primitives of one glTF mesh that were held until the last one came: seams_joined.c,
 * solids_joined.c. */
norma_result norma_check_seams_joined(check_run *run);
norma_result norma_check_solids_joined(check_run *run);
void norma_check_solids_drop(check_run *run);
#endif
