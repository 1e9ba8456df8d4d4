/* draw.h: one panel: where its scene lies, how its camera stands, and its picture. */
#ifndef NORMA_RENDER_DRAW_H
#define NORMA_RENDER_DRAW_H
#include "render/camera/camera.h"
#include "render/gl/device.h"
#include <stddef.h>

typedef struct render_placed { /* one draw of a scene, ready */
    const render_surface *surface;
    const render_upload *upload;
    const render_line_upload *lines[RENDER_LINE_KINDS];
    double to_world[16]; /* from the surface's box; first as the file has it, then so that the
                            scene's ball is the unit ball */
} render_placed;

typedef struct render_stage { /* a panel with all that its picture needs */
    const render_look *look;
    render_panel *panel;
    render_placed *placed;
    size_t placed_count;
    render_ball ball; /* of the file's world */
    double shrunk;    /* of the file's world: by so much, about the ball's centre */
    double grown;     /* how far lines reach out of the unit ball */
    render_camera camera;
    float *tips; /* where hedgehog lines end, in the unit world */
    size_t tip_count;
    double error_top_deg;
} render_stage;

enum render_result render_stage_make(render_device *device, const render_look *look,
    render_panel *panel, render_stage *stage, render_error *error);
void render_stage_free(render_stage *stage);
/* The world so that a ball of this radius about the panel's own centre is the unit ball. */
enum render_result render_stage_scale(render_stage *stage, double radius, render_error *error);
render_frame render_stage_frame(const render_stage *stage);
void render_stage_aim(render_stage *stage, const render_frame *frame, double distance);
enum render_result render_stage_draw(
    render_device *device, const render_stage *stage, render_error *error);

/* The two matrices that a normal may go through, of a local to world matrix: 3x3, column-major, the
 * largest entry about 1. *mirrored: its determinant is below 0. */
void render_normal_matrices(
    const double to_world[16], float right[9], float plain[9], int *mirrored);

/* ---- How the words of a strip are set. */

enum { RENDER_MOST_LINES = 6 };

typedef struct render_text_lines {
    double size;                              /* of the letters, in pixels */
    size_t count, lengths[RENDER_MOST_LINES]; /* bytes; a blank lies between two lines */
} render_text_lines;
/* Of hedgehog lines; and as surface.frag has them, where they face the eye. */
enum {
    RENDER_VERTEX_COLOUR = 0x2B5C9E,
    RENDER_FACE_COLOUR = 0xC96A10,
    RENDER_EDGE_COLOUR = 0x7A4FA3,
    RENDER_FRONT_COLOUR = 0x3DB35C,
    RENDER_BACK_COLOUR = 0xDE332E,
    RENDER_NOTHING_COLOUR = 0x7B7B7B
};
#endif
