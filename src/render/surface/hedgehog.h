/* hedgehog.h: hedgehog lines along normals, and the edges of a wireframe. */
#ifndef NORMA_RENDER_LINES_H
#define NORMA_RENDER_LINES_H
#include "render/surface/surface_vertices.h"

enum { RENDER_LINE_FLOATS = 7 }; /* from, to (hedgehog: the normal), reach; in the surface's box */

typedef struct render_line_set {
    float *floats;
    float *colours; /* four for each line; NULL: all have one */
    size_t count, left_out;
} render_line_set;

/* kind: one of enum render_lines. reach: in parts of the local edge's length. most: of more lines
 * than that, every so many is kept. */
void render_lines_free(render_line_set *set);
enum render_result render_lines_make(const render_surface *surface, unsigned kind, double reach,
    size_t most, render_line_set *set, render_error *error);
#endif
