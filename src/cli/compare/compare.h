/* compare.h: norma compare: a file as surfaces in its scene. */
#ifndef NORMA_CLI_COMPARE_COMPARE_H
#define NORMA_CLI_COMPARE_COMPARE_H
#include "cli/files/files.h"

/* A mesh at one place of the scene; a whole OBJ, PLY or STL. */
typedef struct compared_piece {
    const char *name; /* of the glTF mesh; "" */
    size_t mesh;      /* of the document */
    size_t node, instance;
    size_t first_position, first_normal, first_corner, first_face; /* among those of all pieces */
    size_t positions, normals, corners, faces;
} compared_piece;

/* All pieces, ordered by name, as they are drawn at rest. */
typedef struct compared_scene {
    const char *input;
    norma_document *document;
    void *memory;
    int computed; /* some normals did not exist and were computed */
    compared_piece *pieces;
    size_t count;
    double *positions;
    float *normals;
    uint32_t *corners, *numbers, *sizes; /* corner: its position and its normal, within the piece;
                                            face: corners */
} compared_scene;

/* Close it whatever is returned. */
norma_document_result compared_scene_open(const cli_files *files, const cli_common *common,
    const char *input, compared_scene *scene, norma_document_error *error);
void compared_scene_close(compared_scene *scene);

/* The pieces from first up to end as one surface, whose arrays are to be freed. 0: out of memory.
 */
int compared_surface_make(
    const compared_scene *scene, size_t first, size_t end, norma_surface *surface);
void compared_surface_free(norma_surface *surface);

/* What normals may differ by: --max and --share. */
enum { COMPARE_MAX = 1, COMPARE_SHARE = 2 };

typedef struct compare_limits {
    double max_rad, share;
    int given; /* COMPARE_... */
} compare_limits;
extern const cli_option compare_limit_options[];
extern const size_t compare_limit_option_count;

/* Compares names[1] with names[0] and writes lines of text, or common->json an object, to out. A
 * status: CLI_FINDINGS beyond the limits; else error says why nothing could be compared, and only
 * JSON is written. */
int compare_pair(const cli_files *files, const cli_common *common, const compare_limits *limits,
    const char *const names[2], FILE *out, norma_document_error *error);
#endif
