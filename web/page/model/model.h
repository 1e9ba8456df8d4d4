/* model.h: what the page draws: the meshes of a pack (web/page/model/model_pack.h) as arrays for
 * the graphics card, and their normals computed anew as the page asks. */
#ifndef NORMA_WEB_MODEL_H
#define NORMA_WEB_MODEL_H
#include "model_pack.h"
#include "crease_slider.h"

typedef struct model_mesh {
    norma_mesh mesh; /* views into the pack; triangles or polygons */
    const view_pack_mesh *record;
    norma_vec3_view stored;           /* count 0: none */
    const uint32_t *stored_of_corner; /* NULL: by storage */
    size_t triangle_count;
    uint32_t *triangle_corners; /* NULL: corner i of the mesh is corner i of the triangles */
    double centre[3],
        radius;     /* draw_positions = (position - centre) / radius: within the unit ball */
    float *normals; /* of each corner of the mesh */
    float *draw_positions, *draw_normals,
        *draw_values;         /* of each corner of each triangle; draw_normals may be normals */
    uint8_t *draw_marks;      /* the same, four bytes each; NULL until they are asked for */
    float *draw_texcoords[2]; /* two each; NULL until they are asked for */
    float *draw_tangents;     /* four each; the same */
    uint16_t *draw_colours;   /* the same */
    creases
        *creases; /* NULL before normals were first computed, and where there is no room for it */
} model_mesh;

typedef struct model {
    unsigned char *pack; /* owned */
    const view_pack_head *head;
    const view_pack_draw *draws;
    model_mesh *meshes;
} model;

/* Takes the bytes over, also where it fails: NULL, out of memory or no pack. */
model *model_open(unsigned char *pack, size_t size);
void model_close(model *model);

/* shown_findings.c */
int model_findings_are_sound(const view_pack_head *head, const unsigned char *pack);

void model_position(const model_mesh *mesh, size_t position, double out[3]);
size_t model_corner_position(const model_mesh *mesh, size_t corner);
#endif
