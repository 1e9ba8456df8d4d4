/* acid_mesh.h: the surface of a patch, the meshes of a cell's subject, and its references. */
#ifndef NORMA_ACID_MESH_H
#define NORMA_ACID_MESH_H
#include "acid/acid_cells.h"
#include <stddef.h>
#include <stdint.h>

/* Half of a patch's side, in metres. */
#define ACID_HALF 0.43
/* Bytes from -120 to 120 across a patch, and the height that one of them stands for: -127 to 127
 * hold all. */
#define ACID_BYTES_ACROSS 120.0
#define ACID_BYTE_HEIGHT  0.0037

/* The directions of the lights, from the surface: each 30 degrees off +z. */
enum { ACID_LIGHTS = 3 };
extern const acid_vector acid_lights[ACID_LIGHTS];

/* The height field over the square from -1 to 1 in x and y, and its slopes. */
typedef struct acid_relief {
    double height, along_x, along_y;
} acid_relief;
acid_relief acid_surface(double x, double y);
acid_vector acid_surface_normal(const acid_relief *relief);

typedef struct acid_vertex {
    float position[3], normal[3], tangent[4], uv[2];
    float moved[3], turned[3]; /* morph target */
    float weights[4];
    float color[3], length; /* of references with a colour; length: of the normal, 0 where it is
                               lost */
} acid_vertex;

typedef struct acid_patch {
    acid_vertex *vertices;
    uint16_t *indices;
    size_t vertex_count, index_count, columns,
        rows;        /* a grid, row by row from -y; columns 0: none */
    uint8_t *texels; /* the normal map, columns x rows from the top, red, green and blue */
    int has_color;
} acid_patch;

/* The mesh of the subject, in its own space. 0: out of memory. */
int acid_make_subject(const acid_cell *cell, acid_patch *patch);
/* The same surface as it stands in the world, about the patch's centre. */
int acid_make_reference(
    const acid_cell *cell, const acid_patch *subject, acid_fault fault, acid_patch *patch);
void acid_free_patch(acid_patch *patch);
/* A reference in side x side pixels of three bytes. white: of its material. */
void acid_draw_patch(const acid_patch *patch, double white, int side, uint8_t *pixels);
#endif
