/* walk.h: a binary PLY or STL larger than memory, handed part by part to those who judge it. */
#ifndef NORMA_IO_LARGE_WALK_H
#define NORMA_IO_LARGE_WALK_H
#include <norma/large.h>

typedef struct large_walk large_walk;

typedef struct large_vertices { /* vertices in a row */
    size_t first;
    norma_vec3_view positions, normals; /* normals: count 0 where they are not stored here */
} large_vertices;

typedef struct large_surface { /* faces in a row */
    size_t first_face;
    norma_mesh mesh; /* these faces, and the vertices that they name */
    /* The numbers in the file of those vertices; NULL: they follow first_vertex. */
    const uint32_t *vertices;
    size_t first_vertex;
    norma_vec3_view normals; /* of facets; count 0: none */
} large_surface;

/* Faces of a part are a multiple of this, but for those of the last part. */
enum { LARGE_FACES_IN_BLOCK = 1 << 14 };

typedef norma_document_result large_visit_vertices(void *context, const large_vertices *part);
typedef norma_document_result large_visit_surface(void *context, const large_surface *part);

/* The format that they name, or that of the path. */
norma_file_format norma_large_format(const char *path, const norma_large_options *options);

/* UNSUPPORTED where the file can only be read whole. To be closed in any case. options: NULL for
 * the defaults. info: what norma_document_mesh_info says, without triangles. */
norma_document_result norma_large_walk_open(const char *path, const norma_large_options *options,
    norma_progress *progress, void *progress_user, large_walk **walk, norma_mesh_info *info,
    norma_document_error *error);
/* OK, or that the file changed meanwhile. NULL is fine. */
norma_document_result norma_large_walk_close(large_walk *walk, norma_document_result result);

/* Each goes through the file once, from beginning to end, and returns what a visit returns, if that
 * is not OK. from, to: the share of the progress. */
norma_document_result norma_large_walk_vertices(
    large_walk *walk, double from, double to, large_visit_vertices *visit, void *context);
norma_document_result norma_large_walk_surface(
    large_walk *walk, double from, double to, large_visit_surface *visit, void *context);

/* Of a vertex, or with SIZE_MAX the middle of a face. Once norma_large_walk_surface was there. */
norma_document_result norma_large_walk_locate(
    large_walk *walk, size_t vertex, size_t face, double position[3]);
#endif
