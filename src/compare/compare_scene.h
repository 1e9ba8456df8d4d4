/* compare_scene.h: two documents as surfaces in their scenes, and by how much the normals of one
 * differ from those of the other. For norma compare and the page. */
#ifndef NORMA_COMPARE_COMPARE_SCENE_H
#define NORMA_COMPARE_COMPARE_SCENE_H
#include <norma/check.h>
#include <norma/document.h>

/* A mesh at one place of the scene; a whole OBJ, PLY or STL. */
typedef struct compared_piece {
    const char *name; /* of the glTF mesh; "" */
    size_t mesh;      /* of the document */
    size_t node, instance;
    size_t first_position, first_normal, first_corner, first_face; /* among those of all pieces */
    size_t positions, normals, corners, faces;
    int mirrored; /* its faces are turned, as renderers and exporters do */
} compared_piece;

/* All pieces, ordered by name, as they are drawn at rest. */
typedef struct compared_scene {
    const char *name; /* for messages */
    norma_document *document;
    int computed; /* some normals did not exist and were computed */
    compared_piece *pieces;
    size_t count;
    double *positions;
    float *normals;
    uint32_t *corners, *numbers, *sizes; /* corner: its position and its normal, within the piece;
                                            face: corners */
} compared_scene;

/* Pieces of one name. */
typedef struct compared_group {
    size_t first, end; /* pieces of other */
    int named;         /* compared with the mesh of that name */
    int same_faces;
    norma_comparison sum;
} compared_group;

typedef struct compared_pair {
    compared_scene base, other;
    norma_compare_sample *samples; /* of each corner of other */
    size_t corners;
    compared_group *groups;
    size_t group_count;
    norma_comparison all;
} compared_pair;

/* Computes normals that the document lacks. Close the scene whatever is returned; the document is
 * the caller's. count: 0 where nothing is drawn. */
norma_document_result compared_scene_make(norma_document *document, const char *name,
    uint32_t threads, compared_scene *scene, norma_document_error *error);

/* Fills all but base and other, which have pieces. max_rad: of share_above. Close the pair whatever
 * is returned. */
norma_document_result compared_pair_measure(
    compared_pair *pair, double max_rad, const norma_options *options, norma_document_error *error);
void compared_pair_close(compared_pair *pair);

/* The pieces from first up to end as one surface, to be freed either way. 0: out of memory. */
int compared_surface_make(
    const compared_scene *scene, size_t first, size_t end, norma_surface *surface);
void compared_surface_free(norma_surface *surface);

/* How other's corners were compared: "corners" with their counterparts, with the "nearest" points,
 * or "mixed". */
const char *compared_way(const compared_pair *pair);
#endif
