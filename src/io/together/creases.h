/* creases.h: the normals of corners, where creases cut a surface that lies in several files. Unlike
 * smooth ones they are computed from all faces at once, in memory. */
#ifndef NORMA_IO_TOGETHER_CREASES_H
#define NORMA_IO_TOGETHER_CREASES_H
#include "io/together/run.h"

/* First pass: the faces of a file, wherever they are drawn. */
norma_document_result norma_creases_take(together_run *run, member *m);
/* Then the normals of all corners. */
norma_document_result norma_creases_compute(together_run *run);
/* Second pass: the surfaces of all files in the same order; made: of each corner. */
norma_document_result norma_creases_surface(
    together_run *run, member *m, const document_surface *surface, surface_normals *made);
void norma_creases_free(creases *c); /* NULL is fine */
#endif
