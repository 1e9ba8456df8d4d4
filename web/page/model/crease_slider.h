/* crease_slider.h: the corner normals of one mesh under one crease after the other. What does not
 * hang on the crease is kept between two calls: which positions are one, the corners round each, in
 * what order faces meet there and how sharply; and as long as the weights stay, what each corner
 * votes for. */
#ifndef NORMA_WEB_CREASES_H
#define NORMA_WEB_CREASES_H
#include <norma/norma.h>

typedef struct creases creases;

/* mesh is kept by address and must not change. NULL: out of memory, or a mesh that
 * norma_corner_normals would not take, or one with hard edges or groups. */
creases *creases_open(const norma_mesh *mesh, norma_weld weld);
void creases_close(creases *c);

/* normals: three for each corner, the bits of norma_corner_normals. 0: it has to do it, for a
 * corner has no normal of its own, or memory ran out; normals are then undefined. */
int creases_compute(creases *c, float crease_rad, norma_weight weight, float *normals);

norma_weld creases_weld(const creases *c);
#endif
