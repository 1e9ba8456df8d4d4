/* parts.h: what the files of the renderer share that needs no OpenGL: letters and errors, surfaces
 * as vertices and lines, and how a scene is framed. */
#ifndef NORMA_RENDER_PARTS_H
#define NORMA_RENDER_PARTS_H
#include "render/render.h"

/* ---- pictures: letters on them, sRGB, and errors */

typedef struct render_srgb { /* IEC 61966-2-1, both ways; a level that is decoded and encoded is
                                itself again */
    uint16_t linear[256];    /* of 65535 */
    uint8_t encoded[65536];
} render_srgb;
void render_srgb_make(render_srgb *table);

/* Words in Open Sans. size: the height of
 * capitals in pixels; (x, y): where the line of writing begins. */
double render_text_width(const char *text, double size);
void render_text_draw(render_picture *picture, const char *text, double x, double y, double size,
    const uint8_t ink[3]);

/* The error that a call ends with, in words. */
enum render_result render_fail(
    render_error *error, enum render_result result, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* Inline, so that an analyser of the callers sees that it never returns OK. */
static inline enum render_result render_fail_memory(render_error *error) {
    (void)render_fail(error, RENDER_ERROR_MEMORY, "out of memory");
    return RENDER_ERROR_MEMORY;
}

/* What the core returned: RENDER_OK for NORMA_OK. */
enum render_result render_fail_core(norma_result result, render_error *error);

/* ---- a surface as vertices and triangles for the graphics processor */

enum render_kind {
    RENDER_SMOOTH = 0, /* a vertex for each position and normal */
    RENDER_FACETED, /* each triangle's last vertex holds its face's normal, and is no other face's
                       last */
    RENDER_ERRORS,  /* smooth, unrolled: three vertices a triangle, with degrees between stored and
                       computed normals */
    RENDER_MARKED,  /* smooth, unrolled, with the colours of marks */
    RENDER_MAPPED,  /* smooth, unrolled, with what images need */
    RENDER_MAPPED_FLAT, /* the same with the normals of faces */
    RENDER_KINDS
};

/* Positions are moved and scaled so that they lie within [-1, 1]: single precision then holds them
 * wherever and however large they are. */
typedef struct render_box {
    double origin[3], scale; /* a vertex is (position - origin) * scale */
} render_box;

typedef struct render_vertices {
    render_box box;
    size_t count, index_count;
    float *positions, *normals; /* three for each vertex */
    float *colours;             /* four for each vertex, or NULL */
    float *values;              /* degrees, or NULL */
    float *texcoords;           /* four for each vertex: of base map and normal map; or NULL */
    float *tangents;            /* four for each vertex, or NULL */
    uint32_t *indices;
    const float
        *points; /* three for each position that a triangle uses, for cameras: positions, or kept */
    size_t point_count;
    float *kept;
    double worst_error_rad; /* of RENDER_ERRORS; NaN: there is nothing to compare */
    int uncompared;         /* some values are below 0: nothing to compare there */
    double most_errors_rad; /* what 99 of 100 of them do not exceed */
} render_vertices;

enum render_result render_vertices_make(const render_surface *surface, enum render_kind kind,
    render_vertices *vertices, render_error *error);
void render_vertices_free(render_vertices *vertices);

/* ---- what these are made of, for lines as well */

float render_linear(uint32_t level); /* of a level of 255, encoded */
int render_position(
    const norma_mesh *mesh, uint32_t index, double p[3]); /* 0 where it is not finite */
size_t render_face_count(const norma_mesh *mesh);
void render_face(
    const norma_mesh *mesh, size_t face, size_t *first, size_t *count); /* its corners */
render_box render_box_of(const norma_mesh *mesh);
void render_into_box(const render_box *box, const double p[3], float out[3]);

/* The normal of each corner, shared between corners at one position: stored, or computed where
 * there are none. */
typedef struct render_split {
    size_t count;
    uint32_t *sources; /* the position of each vertex; NULL: its own number */
    uint32_t *corners; /* the vertex of each corner */
    float *normals;    /* three for each vertex */
} render_split;
enum render_result render_split_make(
    const render_surface *surface, render_split *split, render_error *error);
void render_split_free(render_split *split);

/* Degrees between the stored and the computed normal of each corner; -1 where either is not there.
 * Owned by the caller; NULL: out of memory. *worst_rad: NaN if nothing is stored; *most_rad: what
 * 99 of 100 do not exceed. */
float *render_errors(const render_surface *surface, double *worst_rad, double *most_rad);

/* ---- Hedgehog lines along normals, and the edges of a wireframe. */

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
