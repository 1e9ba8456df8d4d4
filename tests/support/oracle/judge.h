/* judge.h: what the library says of a small mesh beyond the normals that compare.h compares: split
 * meshes, plans, orientation. Each disagreement is printed and counted. */
#ifndef NORMA_TESTS_JUDGE_H
#define NORMA_TESTS_JUDGE_H
#include "oracle/oracle.h"

/* Each returns how many are wrong; name is for messages. */

/* norma_split tells vertices apart by old vertex and the bits of the corner's normal, and numbers
 * them as corners first use them. */
size_t judge_split(
    const char *name, const norma_mesh *mesh, float crease_rad, const norma_options *options);
/* A plan per corner gives the bits of norma_corner_normals; one per vertex the sum over the fans
 * that the vertex's corners lie in. */
size_t judge_plans(const char *name, const oracle *o, const norma_mesh *mesh, float crease_rad,
    const norma_options *options);
/* After the faces that norma_orient names are turned, no two in a part that has two sides run along
 * an edge the same way, and a closed part apart from all others has no negative volume (of
 * triangles whose coordinates are small whole numbers). */
size_t judge_orientation(
    const char *name, const oracle *o, const norma_mesh *mesh, const norma_options *options);
#endif
