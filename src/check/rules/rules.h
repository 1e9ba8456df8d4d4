/* rules.h: the families of rules. Each function looks at its rules on one mesh, or on a scene; what
 * families share follows. */
#ifndef NORMA_CHECK_RULES_H
#define NORMA_CHECK_RULES_H
#include "check/findings/check_run.h"
#include <math.h>
#include "core/topology/topology.h"
#include "io/image/image.h"

/* ---- families, each over one mesh */

norma_result norma_check_unplaced(check_mesh *m);          /* positions.c: N002 */
norma_result norma_check_lengths(check_mesh *m);           /* stored_normals.c: N101 to N103 */
norma_result norma_check_missing_normals(check_mesh *m);   /* stored_normals.c: N104 to N106 */
norma_result norma_check_facing(check_mesh *m);            /* facing.c: N201, N202 */
norma_result norma_check_placeholder(check_mesh *m);       /* facing.c: N203 */
norma_result norma_check_deviation(check_mesh *m);         /* facing.c: N204 */
norma_result norma_check_frame(check_mesh *m);             /* facing.c: N206 */
norma_result norma_check_smoothed(check_mesh *m);          /* facing.c: N207 */
norma_result norma_check_facets(check_mesh *m);            /* stored_normals.c: N205 */
norma_result norma_check_edges(check_mesh *m);             /* edges.c: N301, N303, N305, N306 */
norma_result norma_check_open_edges(check_mesh *m);        /* edges.c: N307 */
norma_result norma_check_solids(check_mesh *m);            /* solids.c: N302, N304 */
norma_result norma_check_shapes(check_mesh *m);            /* shapes.c: N401, N402 */
norma_result norma_check_cancelled(check_mesh *m);         /* shapes.c: N403 */
norma_result norma_check_polygons(check_mesh *m);          /* shapes.c: N404, N405 */
norma_result norma_check_seams(check_mesh *m);             /* seams.c: N501 */
norma_result norma_check_coincident(check_mesh *m);        /* positions.c: N503 */
norma_result norma_check_precision(check_mesh *m);         /* positions.c: N502, N701, N702 */
norma_result norma_check_tangents(check_mesh *m);          /* tangents.c: N801 to N806 */
norma_result norma_check_tangent_deviation(check_mesh *m); /* tangents.c: N807 */
norma_result norma_check_morphs(check_mesh *m);            /* moved.c: N901 to N903 */

/* Over the primitives of one glTF mesh together, which were held until the last one came. */
norma_result norma_check_seams_joined(check_run *run);  /* seams.c: N501 */
norma_result norma_check_solids_joined(check_run *run); /* solids.c: N301, N302, N304, N307 */

/* moved.c: N601 to N605, with the materials of the meshes that nodes draw (info.mesh and material
 * of scene->meshes). world_of gives the world matrix of one instance of a node by its index in
 * scene->nodes; NULL: there is nothing but the node's own. */
typedef norma_result check_instance_world(
    void *context, size_t index, size_t instance, double world[16]);
norma_result norma_check_nodes(
    check_run *run, const norma_check_scene *scene, check_instance_world *world_of, void *context);

/* ---- what families share */

/* Of a primitive's area: what is smaller is not seen. */
#define SPECK 1e-4

/* Cosine between a face and a stored normal; NaN if the normal is missing or has no direction. */
static inline double norma_check_cosine_to(const check_mesh *m, size_t face, size_t number) {
    double n[3];
    if (number == SIZE_MAX) return NAN;
    norma_check_normal(m, number, n);
    const double square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    if (!(square >= 1e-12 && square < INFINITY)) /* N101 and N102 tell of it */
        return NAN;
    const double dot = norma_check_dot(m->faces[face].normal, n);
    return square > .99 && square < 1.01 ? dot : dot / sqrt(square);
}

/* edges.c: fills topology.partners, and adds the findings of edges that are wanted; once a mesh. */
norma_result norma_check_pairs(check_mesh *m);

/* facing.c: N206 holds: N201, N202 and N501 are silent then. */
norma_result norma_check_is_of_another_frame(check_mesh *m, int *is);

/* edges.c, for solids.c. Of the primitive whose corners begin at first_corner of a topology that
 * holds all of them; edges: how many conflicts each of the topology's faces has, at most 255;
 * sides: of those faces. An edge between primitives belongs to the one whose face is turned, or has
 * more of them. */
norma_result norma_check_conflicts_joined(check_mesh *m, const core_topology *topology,
    size_t first_corner, const uint8_t *edges, const uint8_t *sides);
int norma_check_count_conflicts(
    const core_topology *topology, uint8_t *edges); /* 1: there are any */
norma_result norma_check_add_open(
    check_mesh *m, const core_topology *topology, size_t first_corner);
int norma_check_wants_open(const check_run *run, const uint8_t *rules);

/* ---- rules that need no neighbours, so that a file can be looked at part by part. _look adds to
 * a sum what a mesh shows; _add makes the findings. */

/* positions.c: N002, of faces with a position that is not finite. Failed: out of memory. */
void norma_check_unplaced_look(const check_mesh *m, check_hits *sum);
norma_result norma_check_unplaced_add(check_mesh *m, check_hits *sum, norma_severity severity);

/* stored_normals.c: N101 to N103. */
enum { CHECK_LENGTH_NOT_FINITE, CHECK_LENGTH_NONE, CHECK_LENGTH_OFF, CHECK_LENGTH_ROUNDED };
typedef struct check_idle {
    size_t degenerate,
        unused; /* normals of no length that only degenerate faces, or no face, use */
} check_idle;
norma_result norma_check_lengths_look(check_mesh *m, check_sum *sum);
norma_result norma_check_lengths_add(check_mesh *m, check_sum *sum, const check_idle *idle);

/* stored_normals.c: N205. The sum's area is that of facets that are more than 10 degrees off.
 * behind: NULL, or a mark for each face whose normal is on its other side. The caller fills the
 * counts TURNED (facets whose winding is known to be wrong) and UNDECIDED (it may be). whole_area:
 * twice that of all faces. */
enum { CHECK_FACETS_ZERO, CHECK_FACETS_TURNED, CHECK_FACETS_UNDECIDED };
norma_result norma_check_facets_look(check_mesh *m, check_sum *sum, uint8_t *behind);
norma_result norma_check_facets_add(check_mesh *m, check_sum *sum, double whole_area);

/* shapes.c: N401 and N402, N404 and N405. */
norma_result norma_check_shapes_look(check_mesh *m, check_sum *sum);
norma_result norma_check_shapes_add(check_mesh *m, check_sum *sum);
norma_result norma_check_polygons_look(check_mesh *m, check_sum *sum);
norma_result norma_check_polygons_add(check_mesh *m, check_sum *sum);

/* positions.c: N701 and N702. */
typedef struct check_largest {
    double coordinate; /* its absolute value; 0: none but zeros */
    size_t vertex;
} check_largest;
/* Takes a larger one of these positions, which are those from first on. */
void norma_check_find_largest(const core_mesh *mesh, size_t first, check_largest *largest);
/* An edge below this length is too short for such coordinates; 0: none is. */
double norma_check_coarse_length(const check_mesh *m, const check_largest *largest);
/* Sorts the edges by ascending lengths: counts[i] of count + 1 numbers grows by those that are
 * shorter than length i and not than the one before. Once more than enough are no shorter than the
 * last length, the others may be left out. After norma_check_weld. */
norma_result norma_check_sort_edges(
    check_mesh *m, const double *lengths, size_t count, size_t enough, size_t *counts);
/* Finds the length below high that half of the edges are shorter than. shorter: writes how many are
 * shorter than the middle of low and high, and how many there are. */
typedef norma_result check_ask_shorter(
    void *context, double low, double high, size_t *shorter, size_t *all);
norma_result norma_check_median_edge(
    double high, check_ask_shorter *ask, void *context, double *median);
norma_result norma_check_distance_add(check_mesh *m, const check_largest *largest, double median);
norma_result norma_check_encoding_add(check_mesh *m);

/* ---- normal_maps.c: normal maps against the surface that they are for (N811, N812): their texels,
 * those that faces use, and what these say. */

/* An image, or of a large one a block of 4 x 4 texels out of each cell of 4 k x 4 k: neighbours
 * stay neighbours, and shares and slopes of a million texels say as much as those of all. */
enum { MAP_BLOCK = 4 };
typedef struct map_texels {
    size_t width, height; /* of the image */
    size_t step;          /* k; 1: all texels are kept */
    size_t columns, rows; /* kept */
    uint8_t *colors;      /* red, green, blue; row by row */
    size_t most;          /* how many may be kept, and as many rows painted for a mesh */
} map_texels;

/* For so many meshes: each looks at fewer texels where they are many. */
image_result norma_map_read(const norma_texture_info *map, size_t meshes, map_texels *texels);
void norma_map_free(map_texels *texels);

/* N811 and N812 of a mesh whose normal map was read. */
norma_result norma_check_map(
    check_mesh *m, const norma_texture_info *map, const map_texels *texels);
#endif
