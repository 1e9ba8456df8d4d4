/* render_scenes.h: what the tests of pictures share: simple scenes, a sheet of one panel, pixels.
 */
#ifndef NORMA_TESTS_RENDER_SCENES_H
#define NORMA_TESTS_RENDER_SCENES_H
#include "render/render.h"

typedef struct test_mesh { /* triangles with a normal for each vertex */
    double *positions;
    float *normals;
    uint32_t *corners;
    size_t vertices, triangles;
} test_mesh;

/* The unit sphere by meridians and parallels; each normal is its position, to a float. */
test_mesh sphere_mesh(size_t around, size_t down);
/* Twelve triangles, four vertices a face. */
test_mesh cube_mesh(void);
void free_test_mesh(test_mesh *mesh);

render_surface surface_of(const test_mesh *mesh);
/* One surface, drawn once under a matrix (NULL: the identity). The draw is kept in *draw. */
render_scene scene_of(const render_surface *surface, render_draw *draw, const double *world);

render_look plain_look(size_t width, size_t height); /* one sample a pixel, one light from the eye's
                                                        upper left, white paper, orthographic */
render_panel panel_of(const render_scene *scene);

/* A device, or NULL where nothing can be drawn, told on standard error. One for the whole program.
 */
render_device *test_device(void);
void close_test_device(void);
#define needs_device(state)                                                                        \
    (void)(state);                                                                                 \
    if (!test_device()) skip()

/* One panel's picture; fails the test where it cannot be drawn. */
render_picture draw_panel(const render_look *look, render_panel *panel);

/* How many pixels differ by more than so many levels in any of red, green, blue; and the largest
 * difference. */
size_t differing(const render_picture *a, const render_picture *b, int levels, int *largest);
#endif
