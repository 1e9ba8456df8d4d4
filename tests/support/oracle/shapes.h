/* shapes.h: meshes with a known form, made on the spot. All faces are wound counterclockwise seen
 * from outside. */
#ifndef NORMA_TESTS_SHAPES_H
#define NORMA_TESTS_SHAPES_H
#include "mesh_files.h"

void shape_box(mesh_file *mesh, double x, double y, double z,
    int quads); /* from 0 to (x, y, z); 8 vertices, 12 triangles or 6 quads */
/* Rings from pole to pole (z up). seam: as a modelling program writes it, the first column of
 * vertices again for its texture coordinates, and a pole for each segment; else every position
 * once. The poles' faces are triangles, all others quads or two triangles. */
void shape_uv_sphere(mesh_file *mesh, size_t segments, size_t rings, int seam, int quads);
/* As shape_uv_sphere with a seam, but of quads (or two triangles) up to the poles, where two of a
 * quad's corners lie at one position. */
void shape_pole_sphere(mesh_file *mesh, size_t segments, size_t rings, int quads);
void shape_cone(mesh_file *mesh, size_t sides,
    double height); /* of unit radius, without a base; vertex 0 is the tip */
void shape_octahedron_sphere(
    mesh_file *mesh, size_t subdivisions); /* every vertex at radius 1 (in double) */
void shape_wavy_grid(mesh_file *mesh, size_t n,
    int quads); /* z = sin x cos y over [0, 2 pi]^2, (n + 1)^2 vertices */
void shape_fan(mesh_file *mesh, size_t triangles); /* flat, closed, round vertex 0, about z */

void shape_soup(mesh_file *out, const mesh_file *mesh); /* a vertex for each corner */
void shape_scale(mesh_file *mesh, double factor);
void shape_round_to_float(mesh_file *mesh);
void shape_map(mesh_file *mesh, const double matrix[9]); /* row by row */

/* The same numbers on every machine. */
uint32_t shape_random(uint64_t *state);
double shape_random_unit(uint64_t *state); /* in [-1, 1), a multiple of 2^-31 */
#endif
