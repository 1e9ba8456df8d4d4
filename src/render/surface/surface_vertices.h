/* surface_vertices.h: a surface as vertices and triangles for the graphics processor. */
#ifndef NORMA_RENDER_VERTICES_H
#define NORMA_RENDER_VERTICES_H
#include "render/picture/picture.h"

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
#endif
