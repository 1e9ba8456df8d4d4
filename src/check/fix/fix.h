/* fix.h: what the files of mending share: one mesh of a document, what the rules found in it, and
 * the edit that grows out of it. */
#ifndef NORMA_CHECK_MEND_INTERNAL_H
#define NORMA_CHECK_MEND_INTERNAL_H
#include "check/findings/check_run.h"
#include <math.h>

typedef struct fix_mesh {
    norma_document *document;
    size_t index; /* of the mesh in the document */
    norma_mesh_info info;
    norma_mesh_data data;
    norma_mesh_attributes attributes;
    core_mesh mesh; /* corners as they were read */
    uint32_t threads;
    const norma_finding **findings; /* those that may be mended here */
    size_t finding_count;
    norma_mesh_edit *edit; /* its arrays are the mender's */
    const uint8_t *turned; /* faces of bodies that are reversed as a whole; NULL: none */
    const float
        *smooth; /* of each vertex, at seams of several primitives; NULL: of this one alone */
    /* Made when first needed. */
    uint32_t *corners; /* positions of the corners as they will be run along: reversed where the
                          edit says so */
    int knows_deviation;
    norma_deviation deviation; /* of the stored normals */
    float *surface; /* normals of the corners by that weight and crease, along the corners above */
    float *face_normals; /* three of each face, along the corners above */
} fix_mesh;

/* Marks elements that the findings of a rule name: vertex, face or normal, whichever number is
 * asked for. 1: there are any; 0: none; -1: out of memory. *marks is made where it is NULL, with
 * count bytes. */
typedef enum fix_element { MEND_VERTEX, MEND_FACE, MEND_NORMAL } fix_element;
int norma_fix_mark(
    const fix_mesh *m, check_rule rule, fix_element element, size_t count, uint8_t **marks);
int norma_fix_is_rule(const norma_finding *finding, check_rule rule);
int norma_fix_has(const fix_mesh *m, check_rule rule);
int norma_fix_has_edit(const norma_mesh_edit *edit);

norma_result norma_fix_corners(fix_mesh *m); /* corners */
norma_result norma_fix_surface(fix_mesh *m); /* deviation, surface */
norma_result norma_fix_face_normals(fix_mesh *m);
norma_mesh norma_fix_mesh_now(const fix_mesh *m); /* the mesh with corners as they will be */
size_t norma_fix_normal_of(const fix_mesh *m, size_t face,
    size_t corner); /* number of its stored normal; SIZE_MAX: none */
size_t norma_fix_normal_count(const fix_mesh *m);
/* A normal as it will be: the edit's where it is set, else the stored one. */
void norma_fix_normal(const fix_mesh *m, size_t number, double normal[3]);
int norma_fix_set_normal(fix_mesh *m, size_t number,
    const double
        normal[3]); /* made unit; 0: out of memory. What is no direction is left as it is */

typedef struct fix_group { /* the primitives of one glTF mesh, or the one mesh of another file */
    norma_document *document;
    const norma_findings *findings;
    const size_t *indices; /* count of them, in the document */
    const char *const *wheres;
    size_t count;
    uint32_t threads;
    int open_by_rays;
    uint8_t **turned; /* by index: set to a mark for each face, the caller's to free */
    float **smooth;   /* by index: set to a normal for each vertex, NaN where it stays; the caller's
                         to free */
    norma_fix_summary *summary;
    norma_document_error *error;
} fix_group;
norma_document_result norma_fix_turn(
    const fix_group *group, norma_result *how); /* turn_bodies.c: N302, N304 */
norma_document_result norma_fix_seams(
    const fix_group *group, norma_result *how); /* seam_normals.c: N501 between primitives */

typedef struct fix_whole { /* joined_primitives.c */
    const fix_group *group;
    core_mesh *meshes;
    size_t vertices, corner_count, face_count; /* of all */
    norma_mesh mesh;                           /* all of them as one; after norma_fix_join */
    double *positions;
    uint32_t *corners, *starts;
} fix_whole;
/* To be closed in any case. */
norma_document_result norma_fix_open_whole(
    const fix_group *group, fix_whole *whole, norma_result *how);
void norma_fix_close_whole(fix_whole *whole);
int norma_fix_join(fix_whole *whole); /* 0: out of memory */
/* inward_bodies.c: named: a mark for each face of all meshes; those of whole bodies in which a face
 * is marked become marked. */
norma_result norma_fix_whole_bodies(const core_mesh *meshes, size_t count, uint8_t *named);

norma_result norma_fix_faces(fix_mesh *m);     /* fix_faces.c: N301, N302, N305, N401 */
norma_result norma_fix_polygons(fix_mesh *m);  /* fix_polygons.c: N404, N405 */
norma_result norma_fix_positions(fix_mesh *m); /* fix_positions.c: N503 */
norma_result norma_fix_normals(
    fix_mesh *m); /* fix_normals.c: N101 to N103, N201 to N203, N205, N501 */
norma_result norma_fix_vertices(
    fix_mesh *m); /* fix_vertices.c: N403, N502; last, and only where nothing else is edited */
norma_result norma_fix_tangents(fix_mesh *m); /* fix_tangents.c: N801 to N805 */
#endif
