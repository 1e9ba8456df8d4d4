/* acid_cells.h: the table that the acid scenes, their layout and their page are made from. */
#ifndef NORMA_ACID_CELLS_H
#define NORMA_ACID_CELLS_H
#include "acid/acid_math.h"
#include <stddef.h>

/* What a reference shows: the right normals, or those of a mistake. */
typedef enum acid_fault {
    ACID_RIGHT = 0,
    ACID_OBJECT_SPACE,
    ACID_NOT_NORMALIZED,
    ACID_MODEL_MATRIX,
    ACID_SEPARATE_SCALE,
    ACID_REVERSED,
    ACID_LOST,
    ACID_INSTANCE_IGNORED,
    ACID_NODE_APPLIED,
    ACID_NODE_NOT_CANCELLED,
    ACID_STRONGEST_JOINT,
    ACID_NOT_MORPHED,
    ACID_SMOOTHED,
    ACID_NOT_FLIPPED,
    ACID_SIGN_LOST,
    ACID_GREEN_FLIPPED,
    ACID_TANGENT_BY_NORMAL_MATRIX,
    ACID_SIGN_KEPT,
    ACID_SCALE_IGNORED,
    ACID_SCALE_ON_Z,
    ACID_FAULTS
} acid_fault;
const char *acid_fault_id(acid_fault fault); /* "right", or the mistake's id */

typedef enum acid_way { /* how the subject comes to its place */
    ACID_BAKED,
    ACID_NODES,    /* a chain of nodes, the outermost first */
    ACID_INSTANCE, /* EXT_mesh_gpu_instancing: the first step; the second one is an instance beside
                    */
    ACID_SKIN,     /* each step is a joint */
    ACID_MORPH,
    ACID_BYTES, /* KHR_mesh_quantization, under a node */
    ACID_FLAT,  /* no NORMAL */
    ACID_BACK   /* seen from behind */
} acid_way;

typedef enum acid_map_kind { ACID_NO_MAP, ACID_MAP_WITH_TANGENTS, ACID_MAP_ALONE } acid_map_kind;

typedef struct acid_step {
    double scale[3];
    double turn[4]; /* a quaternion x, y, z, w of any length; zeros: none */
} acid_step;

enum { ACID_MOST_STEPS = 2, ACID_MOST_FAULTS = 4, ACID_SUBDIVIDED = 40 };

typedef struct acid_cell {
    const char *id;
    const char *tested, *sentence, *section, *expected; /* for people */
    acid_way way;
    acid_step steps[ACID_MOST_STEPS];
    int step_count;
    acid_step own; /* the skinned node's, which is to be ignored */
    int double_sided;
    double white; /* 0: 1. Less where a reference must be brighter than the subject */
    acid_map_kind map;
    int mirrored_from; /* from which of the ACID_SUBDIVIDED columns on u runs backwards, below 0:
                          nowhere */
    double normal_scale;
    acid_fault faults[ACID_MOST_FAULTS]; /* up to the first ACID_RIGHT */
} acid_cell;

extern const acid_cell acid_cells[];
extern const size_t acid_cell_count;

acid_matrix acid_step_matrix(const acid_step *step);
void acid_step_rotation(const acid_step *step, double unit[4]);
int acid_has_turn(const acid_step *step);
const char *acid_cell_extension(const acid_cell *cell); /* that it needs; NULL: none */
size_t acid_fault_count(const acid_cell *cell);
double acid_white(const acid_cell *cell); /* of the subject's material */
#endif
