/* info.h: what norma info found in a file, and how it is told. */
#ifndef NORMA_CLI_INFO_H
#define NORMA_CLI_INFO_H
#include "cli/text/text.h"
#include <norma/document.h>
#include <norma/norma.h>

typedef struct info_bounds {
    int known; /* 0: no finite position, or too many instances to look at each vertex of each */
    double least[3], most[3];
} info_bounds;

typedef struct off_by {
    double p50_deg, p99_deg, max_deg;
} off_by;

typedef struct cli_explained {
    norma_weight weight;
    double crease_deg; /* NaN: smooth, one normal for each position */
    int flat;
    off_by off; /* between the stored normals and those that it gives */
} cli_explained;

typedef struct cli_explained_tangents {
    norma_tangent_deviation deviation;
    off_by off;
} cli_explained_tangents;

/* One primitive, or a whole OBJ, PLY or STL. */
typedef struct mesh_part {
    norma_mesh_info info;
    int closed; /* with --deep: 1 closed, 0 open; -1: not known */
    int is_explained, has_explained_tangents;
    cli_explained explained;
    cli_explained_tangents tangents;
} mesh_part;

typedef struct contents {
    const char *path;
    size_t tile; /* of a composite with several models; SIZE_MAX: of anything else */
    norma_file_format format;
    const norma_document *document; /* NULL: a file that does not fit into memory */
    mesh_part *parts;
    size_t part_count, vertices, faces, triangles;
    norma_node_info *nodes;
    size_t node_count, skin_count;
    info_bounds bounds;
} contents;

static inline off_by off_in_degrees(double p50, double p99, double most) {
    return (off_by){cli_to_degrees(p50), cli_to_degrees(p99), cli_to_degrees(most)};
}

/* As JSON, one object: of a composite's models, where they are several, an array in it. */
void info_write_json(const contents *found, size_t count);
void info_write_failure(const char *path, const norma_document_error *error);
/* For people. */
void info_print(const contents *found);
#endif
