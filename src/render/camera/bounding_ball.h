/* bounding_ball.h: points of a scene in the world, the smallest ball round them, and how a camera
 * frames them. */
#ifndef NORMA_RENDER_BALL_H
#define NORMA_RENDER_BALL_H
#include "render/camera/pipeline.h"

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
    double per[2]; /* of the distance: half of what a camera there shows; 0: there is nothing, or it
                      is a turntable's */
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
