/* shared_normals.h: normals that a document gets from outside instead of computing them from its
 * own faces alone: those of a surface that lies in several files. */
#ifndef NORMA_IO_SHARED_NORMALS_H
#define NORMA_IO_SHARED_NORMALS_H
#include <norma/document.h>

/* A mesh of a document within a surface: a glTF primitive. */
typedef struct surface_part {
    size_t mesh;           /* its number in the document */
    size_t first_position; /* in the surface */
    size_t first_corner;   /* SIZE_MAX: its triangles are those of another part */
} surface_part;

/* All triangles of a glTF mesh, whatever their primitives; a whole OBJ or PLY. */
typedef struct document_surface {
    size_t number; /* of the glTF mesh; 0 */
    const norma_mesh *mesh;
    double unit; /* what integers of its positions are multiplied by; else 1 */
    const surface_part *parts;
    size_t part_count;
} document_surface;

/* Called for each surface of a document, in order. */
typedef norma_document_result visit_surface(void *user, const document_surface *surface);

typedef struct shared_normals {
    void *user;
    /* The normals of all positions of a surface, and why some have none of their own. */
    norma_result (*take)(
        void *user, size_t surface, const norma_mesh *mesh, float *normals, uint8_t *reasons);
    /* Nonzero for each mesh (glTF), face (OBJ), or for the whole (PLY) that keeps what it has;
     * NULL: nothing does. */
    const uint8_t *locked;
    int of_corners; /* take gives the normals of all corners */
} shared_normals;
#endif
