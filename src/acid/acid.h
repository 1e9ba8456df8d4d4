/* acid.h: scenes that show whether a renderer carries normals: their table of cells, the meshes of
 * patches, the GLB files, and which reference each subject of a picture looks like. */
#ifndef NORMA_ACID_H
#define NORMA_ACID_H
#include "io/file/file.h"
#include "io/image/image.h"
#include <stddef.h>
#include <stdint.h>

/* ---- cells: the table that the scenes, their layout and their page are made from */

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

enum { ACID_MOST_STEPS = 2, ACID_MOST_FAULTS = 4, ACID_SUBDIVIDED = 40, ACID_MOST_FUNCTIONS = 3 };

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
    int mirrored_from; /* from which of the ACID_SUBDIVIDED columns on u runs backwards, 0: nowhere
                        */
    double normal_scale;
    acid_fault faults[ACID_MOST_FAULTS]; /* up to the first ACID_RIGHT */
} acid_cell;

extern const acid_cell acid_cells[];
extern const size_t acid_cell_count;

void acid_step_rotation(const acid_step *step, double unit[4]);
const char *acid_cell_extension(const acid_cell *cell); /* that it needs; NULL: none */
size_t acid_fault_count(const acid_cell *cell);
double acid_white(const acid_cell *cell); /* of the subject's material */

/* ---- mistakes in words */

typedef struct acid_mistake {
    const char *id;
    const char *words; /* what the renderer does, as a sentence without its full stop */
    const char *mend;  /* what a shader or loader does instead */
    const char *functions[ACID_MOST_FUNCTIONS]; /* of norma.glsl that do so; then NULL */
} acid_mistake;

const char *acid_fault_id(acid_fault fault);           /* "right", or the mistake's id */
const acid_mistake *acid_find_mistake(const char *id); /* NULL: there is none of that name */

/* The text of a function of norma.glsl with its comment: where it begins, and its length; 0: there
 * is none of that name. */
size_t acid_mending_lines(const char *function, const char **begin);

/* ---- meshes: the surface of a patch, the meshes of a cell's subject, and its references */

/* Half of a patch's side, in metres. */
#define ACID_HALF 0.43
/* Bytes from -120 to 120 across a patch, and the height that one of them stands for: -127 to 127
 * hold all. */
#define ACID_BYTES_ACROSS 120.0
#define ACID_BYTE_HEIGHT  0.0037

typedef struct acid_vector {
    double x, y, z;
} acid_vector;

/* The directions of the lights, from the surface: each 30 degrees off +z. */
enum { ACID_LIGHTS = 3 };
extern const acid_vector acid_lights[ACID_LIGHTS];

typedef struct acid_vertex {
    float position[3], normal[3], tangent[4], uv[2];
    float moved[3], turned[3]; /* morph target */
    float weights[4];
    float color[3], length; /* of references with a colour; length: of the normal, 0 where it is
                               lost */
} acid_vertex;

typedef struct acid_patch {
    acid_vertex *vertices;
    uint16_t *indices;
    size_t vertex_count, index_count, columns,
        rows;        /* a grid, row by row from -y; columns 0: none */
    uint8_t *texels; /* the normal map, columns x rows from the top, red, green and blue */
    int has_color;
} acid_patch;

/* The mesh of the subject, in its own space. 0: out of memory. */
int acid_make_subject(const acid_cell *cell, acid_patch *patch);
/* The same surface as it stands in the world, about the patch's centre. */
int acid_make_reference(
    const acid_cell *cell, const acid_patch *subject, acid_fault fault, acid_patch *patch);
void acid_free_patch(acid_patch *patch);
/* A reference in side x side pixels of three bytes. white: of its material. */
void acid_draw_patch(const acid_patch *patch, double white, int side, uint8_t *pixels);

/* ---- words as triangles */

typedef struct acid_ink {
    float *positions; /* three each, four for a stroke */
    uint16_t *indices;
    size_t strokes, capacity;
    int failed;
} acid_ink;

/* ASCII from (x, y), its base line, broken behind hyphens so that no line is wider than width where
 * that can be; size: the height of capitals. */
void acid_write_lines(
    acid_ink *ink, const char *text, double x, double y, double size, double width);

/* ---- where things lie in a scene: the unit square of its picture, x to the right, y downwards */

enum { ACID_MARKS = 4, ACID_MOST_REFERENCES = 8, ACID_MOST_CELLS = 256, ACID_ID_ROOM = 40 };
extern const char *const acid_mark_colors[ACID_MARKS];

typedef struct acid_box {
    double center[2], size[2];
} acid_box;

typedef struct acid_grid { /* cells of one scene; a cell alone is a grid of one */
    size_t first, count;   /* cells */
    size_t columns, rows, slots;
    double width, height; /* of the picture, in metres; 4:3 */
} acid_grid;

/* The grid whose picture is smallest, so that patches are largest. */
acid_grid acid_grid_of(size_t first, size_t count);

enum { ACID_SUBJECT_SLOT = 0, ACID_RIGHT_SLOT = 1 };
size_t acid_slot_count(const acid_cell *cell); /* subject, references, and what lies beside */
/* index: of the cell in the table. */
acid_box acid_slot_box(const acid_grid *grid, size_t index, size_t slot);
acid_box acid_mark_box(const acid_grid *grid, size_t mark);

/* The scene as a GLB file, which is the caller's to free in any case. */
image_result acid_write_scene(const acid_grid *grid, growing_bytes *file);

typedef struct acid_place { /* of a reference */
    char id[ACID_ID_ROOM];  /* "right", or the mistake that it shows */
    acid_box box;
} acid_place;

typedef struct acid_row { /* a cell */
    char id[ACID_ID_ROOM];
    acid_box subject;
    acid_place references[ACID_MOST_REFERENCES]; /* "right" is the first */
    size_t reference_count;
    int skipped; /* an extension that it needs is not there */
} acid_row;

typedef struct acid_layout {
    acid_box marks[ACID_MARKS]; /* red, green, blue, yellow */
    acid_row *rows;
    size_t row_count;
} acid_layout;

/* ---- pictures that a renderer made of a scene */

typedef struct acid_picture {
    size_t width, height;
    uint8_t *pixels; /* red, green and blue, eight bits each; to be freed */
} acid_picture;

/* A PNG or JPEG; what is transparent becomes darker, as over black. pixels: NULL after a failure.
 */
image_result acid_read_picture(const unsigned char *bytes, size_t size, acid_picture *picture);
/* As a PNG; its bytes are the caller's to free in any case. 0: out of memory. */
int acid_write_picture(const acid_picture *picture, growing_bytes *png);

typedef struct acid_map { /* a homography from the unit square to pixels, row by row; the first
                             pixel's middle is (0.5, 0.5) */
    double m[9];
} acid_map;

void acid_map_point(const acid_map *map, const double unit[2], double pixel[2]);
/* The sides of a box in the picture, along x and along y, through its middle. */
void acid_map_sides(const acid_map *map, const acid_box *box, double sides[2][2]);

/* Looks for four uniform spots of the marks' hues which lie, and are as large, as the layout says.
 * 1: found; 0: not found; -1: out of memory. */
int acid_find_marks(const acid_picture *picture, const acid_layout *layout, acid_map *map);

typedef enum acid_verdict {
    ACID_PASS,
    ACID_FAIL,
    ACID_UNCLEAR,
    ACID_MISSING,
    ACID_SKIPPED,
    ACID_VERDICTS
} acid_verdict;

typedef enum acid_reason { /* of ACID_UNCLEAR, and of a control that fails */
    ACID_REASON_NONE,
    ACID_REASON_CONTROL,   /* the control failed: nothing in the picture can be trusted */
    ACID_REASON_OUTSIDE,   /* a patch lies outside the picture */
    ACID_REASON_SMALL,     /* patches have too few pixels */
    ACID_REASON_NOT_DRAWN, /* the right reference is not drawn */
    ACID_REASON_ALIKE,     /* the references differ by no more than the picture's noise */
    ACID_REASON_BETWEEN,   /* the nearest two are about as near */
    ACID_REASON_FAR,       /* nothing is near, or not everywhere */
    ACID_REASON_HIDDEN,    /* drawn in the ground's colour, or not at all */
    ACID_REASON_NO_RELIEF, /* no normal map looks much the same, and no cell shows one */
    ACID_REASON_ELSEWHERE  /* other mistakes look the same here; the cell in which they do not does
                              not pass */
} acid_reason;

typedef struct acid_finding {
    acid_verdict verdict;
    acid_reason reason;
    int nearest; /* the reference that is nearest, -1: none was compared; of ACID_FAIL: the mistake,
                    or -1 where the control fails */
    double distances[ACID_MOST_REFERENCES]; /* root mean square of colours from 0 to 1 */
    double apart; /* of the nearest reference and the one that is most like it */
} acid_finding;

typedef struct acid_judgement {
    acid_finding *findings; /* of each row; to be freed */
    double noise;           /* distance between the control and its reference; 0: no control */
    size_t counts[ACID_VERDICTS];
} acid_judgement;

/* 0: out of memory. */
int acid_judge(const acid_picture *picture, const acid_layout *layout, const acid_map *map,
    acid_judgement *judgement);

/* Frames each subject by its verdict: green, red, or grey. */
void acid_frame(acid_picture *picture, const acid_layout *layout, const acid_map *map,
    const acid_judgement *judgement);
#endif
