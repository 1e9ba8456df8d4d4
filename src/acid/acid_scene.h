/* acid_scene.h: the acid scenes as GLB files, and where things lie in their pictures. */
#ifndef NORMA_ACID_SCENE_H
#define NORMA_ACID_SCENE_H
#include "acid/acid_cells.h"
#include "io/file/file.h"
#include "io/image/image.h"

/* In the unit square of the picture, x to the right, y downwards. */
typedef struct acid_region {
    double center[2], size[2];
} acid_region;

typedef struct acid_grid { /* cells of one scene; a cell alone is a grid of one */
    size_t first, count;   /* cells */
    size_t columns, rows, slots;
    double width, height; /* of the picture, in metres; 4:3 */
} acid_grid;

acid_grid acid_grid_of_all(void);
acid_grid acid_grid_of_one(size_t cell);

enum { ACID_SUBJECT_SLOT = 0, ACID_RIGHT_SLOT = 1 };
size_t acid_slot_count(const acid_cell *cell); /* subject, references, and what lies beside */
/* index: of the cell in the table. */
acid_region acid_slot_region(const acid_grid *grid, size_t index, size_t slot);
acid_region acid_mark_region(const acid_grid *grid, size_t mark);
extern const char *const acid_mark_colors[4];

/* The scene as a GLB file, which is the caller's to free in any case. */
image_result acid_write_scene(const acid_grid *grid, growing_bytes *file);
#endif
