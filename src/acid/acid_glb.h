/* acid_glb.h: a GLB file that grows by meshes, nodes and materials. */
#ifndef NORMA_ACID_GLB_H
#define NORMA_ACID_GLB_H
#include "acid/acid_mesh.h"
#include "io/file/file.h"

typedef struct acid_list { /* the elements of an array of the JSON */
    growing_bytes text;
    size_t count;
} acid_list;

typedef struct acid_glb {
    growing_bytes binary;
    acid_list views, accessors, meshes, materials, nodes, roots, skins, images, textures, used,
        required;
    int failed; /* out of memory */
} acid_glb;

#if defined(__GNUC__)
#define ACID_FORMAT(text, first) __attribute__((format(printf, text, first)))
#else
#define ACID_FORMAT(text, first)
#endif
/* Appends text; and the beginning of an element, whose number it returns. */
ACID_FORMAT(2, 3) void acid_print(growing_bytes *to, const char *format, ...);
ACID_FORMAT(2, 3) size_t acid_add(acid_list *list, const char *format, ...);
/* "name": [numbers], the shortest text of each that reads back as the same. */
void acid_print_number(growing_bytes *to, const char *name, double number);
void acid_print_numbers(growing_bytes *to, const char *name, const double *numbers, size_t count);

/* Numbers of accessors. */
size_t acid_add_floats(
    acid_glb *glb, const float *first, size_t stride, size_t count, size_t width, int has_bounds);
size_t acid_add_bytes(
    acid_glb *glb, const float *first, size_t stride, size_t count, double scale, int is_position);
/* Of vertices with this many joints; of a skin, matrices of the identity. */
size_t acid_add_joints(acid_glb *glb, size_t count, size_t joints);
size_t acid_add_identities(acid_glb *glb, size_t joints);
size_t acid_add_indices(acid_glb *glb, const uint16_t *indices, size_t count);
/* Of a PNG: the number of a texture, which interpolates between texels. */
size_t acid_add_texture(acid_glb *glb, const void *png, size_t size);
/* Once for each name. */
void acid_use_extension(acid_glb *glb, const char *name, int is_required);

/* Puts the file together; more: further members of the JSON, each ended by a comma. glb is freed.
 * 0: out of memory. */
int acid_finish(acid_glb *glb, const growing_bytes *more, growing_bytes *file);
#endif
