/* vertex_lines.h: v lines that go and come, as a change that the writer makes. Internal to obj_*.c.
 */
#ifndef NORMA_IO_OBJ_VERTICES_H
#define NORMA_IO_OBJ_VERTICES_H
#include "io/obj/obj.h"

#define OBJ_NO_VERTEX UINT32_MAX

struct obj_vertices {
    size_t *kept_before;  /* of each old position, and the end: how many before it stay */
    uint32_t *numbers;    /* of each old position the number, from 0, that names it in the file;
                             OBJ_NO_VERTEX: none */
    uint32_t *corners;    /* the same of each corner of the faces */
    size_t face, added;   /* before this face so many are put in */
    unsigned char *lines; /* which are these lines */
    size_t lines_size;
};

norma_document_result norma_obj_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error);
norma_document_result norma_obj_edit_vertices(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error);
#endif
