/* camera.h: how a scene is framed: the ball round it, which way is up, and the way from local space
 * to pixels. */
#ifndef NORMA_RENDER_CAMERA_H
#define NORMA_RENDER_CAMERA_H
#include "render/render.h"

/* ---- The way of a vertex, one function for each step: local -> world -> view -> clip ->
 * viewport. Matrices are column-major, for column vectors. */

typedef struct render_camera {
    double azimuth_deg, elevation_deg; /* 0, 0: from the front, looking along -z; azimuth 90 from
                                          the right (+x); elevation 90 from above */
    enum render_up
        up; /* z: front is then from -y; x: from +z; -y: from -z; -z: from +y; -x: from +z */
    double centre[3];   /* in the middle of the picture, world */
    double distance;    /* of the eye from it */
    double half_height; /* orthographic: world units from the middle to the upper border; 0:
                           perspective */
    double tangent;     /* perspective: of half the angle of view, of the height */
    double aspect;      /* width over height */
    double depth;       /* everything lies within this distance of the centre, along the view */
} render_camera;

void render_multiply(
    const double a[16], const double b[16], double product[16]); /* a b; product may be neither */
void render_point(const double m[16], const double p[3], double out[3]); /* the upper 3x4 */

/* Local to world: the node's matrix, then the one that the command line gives. */
void render_local_to_world(const double node[16], const double given[16], double matrix[16]);
/* World to view: the eye at the origin, x to the right, y up, looking along -z. */
void render_world_to_view(const render_camera *camera, double matrix[16]);
/* View to clip: perspective, or orthographic where half_height is above 0. */
void render_view_to_clip(const render_camera *camera, double matrix[16]);
/* Clip to viewport: pixels from the upper left corner, depth from 0 to 1. What glViewport and the
 * division by w do, for words and tests. */
void render_clip_to_viewport(const double clip[4], size_t width, size_t height, double pixel[3]);

/* The unit axes of the camera in the world: right, up, and back (to the eye). */
void render_camera_axes(const render_camera *camera, double right[3], double up[3], double back[3]);

/* ---- Points of a scene in the world, the smallest ball round them, and how a camera
 * frames them. */

typedef struct render_cloud { /* count points, three floats each, and the matrix that takes them to
                                 the world */
    const float *points;
    size_t count;
    double matrix[16];
} render_cloud;

typedef struct render_ball {
    double centre[3], radius;
} render_ball;

/* Turns with the points, unlike a box: a model and a camera that turn together give one picture.
 * Radius 0 where there are no points. */
render_ball render_smallest_ball(const render_cloud *clouds, size_t count);

typedef struct render_frame { /* what a camera must show, seen along its axes from the ball's centre
                               */
    double most[2], least[2]; /* how far it reaches to the right and up, to the left and down, as
                                 from an eye far away that sees the same edge of the picture */
    double per[2];    /* of the distance: half of what a camera there shows; 0: there is nothing */
    double middle[2]; /* to the right and up of it, in the world's unit */
    double distance;  /* of the eye, or half the height for an orthographic camera */
} render_frame;
/* camera: its turn, tangent, aspect and centre. The closest frame in which every point is inside,
 * margin (0.1) of each side left free. */
render_frame render_closest_frame(const render_camera *camera, int orthographic, double margin,
    const render_cloud *clouds, size_t count);
/* The middle and the distance, from the rest. */
void render_fit_frame(render_frame *frame);
#endif
