/* surfaces.h: clean surfaces as arrays, for tests that plant a fault in them and ask norma check
 * for it. */
#ifndef NORMA_TESTS_SURFACES_H
#define NORMA_TESTS_SURFACES_H
#include <norma/check.h>

typedef struct surface {
    float *positions, *normals, *texcoords; /* three, three and two of each vertex */
    uint32_t *corners;
    size_t vertices, faces; /* triangles */
    uint32_t *starts;       /* NULL: triangles; else polygons with face_count + 1 */
    norma_check_mesh mesh;  /* views of the above, made by surface_findings */
} surface;

/* A torus of around by across quads, two triangles each, that a seam of UVs parts both ways:
 * vertices there are doubled. Normals are the surface's own. */
surface surface_torus(size_t around, size_t across);
/* A box with 24 vertices and normals of its sides, 12 triangles; inward: wound and lit from within.
 */
surface surface_box(const double centre[3], double half, int inward);
/* Two surfaces as one. The parts are freed. */
surface surface_join(surface a, surface b);
/* Each corner its own vertex. */
surface surface_soup(surface s);
void surface_turn_face(surface *s, size_t face);
/* A triangle of three new vertices, or of old ones. Returns its number. */
size_t surface_add_face(surface *s, const uint32_t corners[3]);
uint32_t surface_add_vertex(surface *s, const float position[3], const float normal[3]);
void surface_free(surface *s);

/* What norma check says of it. options may be NULL; its findings are freed by the caller. */
norma_findings *surface_findings(
    surface *s, const norma_check_options *options, norma_file_format format);

/* The finding of a rule, of a severity (NONE: any); NULL: there is none. */
const norma_finding *finding_of(
    const norma_findings *findings, const char *id, norma_severity severity);
/* Whether anything but information was found; says what. */
int findings_trouble(const norma_findings *findings);
#endif
