/* gltf_scene.h: what a glTF draws, as triangles in world space, for tests of transforms: the meshes
 * through the public functions, the matrices multiplied here. */
#ifndef NORMA_TESTS_GLTF_SCENE_H
#define NORMA_TESTS_GLTF_SCENE_H
#include <norma/document.h>

typedef struct scene_triangle {
    double position[3][3];
    double normal[3][3]; /* unit, in world space; zeros where the mesh has none */
    size_t node;
} scene_triangle;

typedef struct drawn_scene {
    scene_triangle *triangles;
    size_t count, room;
    int integers; /* some positions are integers, taken as they are: wrong by a factor where they
                     are normalized */
} drawn_scene;

/* Every triangle that a node of the document draws; instances, skins and morphs aside. Fails the
 * test on an error. */
void scene_read(norma_document *document, drawn_scene *scene);
void scene_free(drawn_scene *scene);

/* The document's output as bytes in memory (the caller frees), and opened again; each fails the
 * test on an error. */
unsigned char *scene_output(norma_document *document, size_t *size);
norma_document *scene_open(const char *path);
norma_document *scene_reopen(const unsigned char *bytes, size_t size, const char *name);
norma_document *scene_of_obj(const char *text);

double scene_largest(const drawn_scene *scene); /* coordinate, in absolute value */
void scene_facet_normal(const scene_triangle *triangle, double normal[3]); /* unit, or zeros */
double scene_angle_deg(const double a[3], const double b[3]);
#endif
