/* explain_tangents.h: what the search for how tangents were made shares with its candidates. */
#ifndef NORMA_CHECK_EXPLAIN_TANGENTS_H
#define NORMA_CHECK_EXPLAIN_TANGENTS_H
#include "check/findings/check_run.h"

/* A surface with stored tangents: triangles, whose normals and texture coordinates belong to
 * vertices. */
typedef struct tangent_surface {
    const norma_mesh *mesh;
    core_mesh checked;
    const float *texcoords, *stored; /* two and four floats of each vertex */
    float *normals;                  /* three floats of each vertex */
} tangent_surface;

/* Candidates: tangents of all corners, four floats each, the sign for the texture coordinates as
 * they are stored; x, y, z zero where there is no tangent to compare with. */
norma_result norma_explain_mikk(
    core_call *call, const tangent_surface *s, float *tangents); /* explain_mikk.c */
/* On neighbours in the list put together again. across_ties: quads of two equal diagonals are cut
 * along the one that the triangles do not share. Tangents stay as they are, and *any is 0, where
 * there are no such neighbours. */
norma_result norma_explain_mikk_on_quads(
    core_call *call, const tangent_surface *s, int across_ties, float *tangents, int *any);
/* explain_tangents.c */
norma_result norma_explain_tangents_with(core_call *call, const norma_mesh_data *data,
    const norma_mesh_attributes *attributes, const core_mesh *checked,
    norma_tangent_deviation *deviation);
/* tangent_sums.c: Lengyel 2001. */
norma_result norma_explain_tangent_sums(core_call *call, const tangent_surface *s, float *tangents);
#endif
