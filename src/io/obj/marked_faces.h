/* marked_faces.h: faces by the names of their object, groups and material. */
#ifndef NORMA_IO_OBJ_MARKED_FACES_H
#define NORMA_IO_OBJ_MARKED_FACES_H
#include "io/format/format.h"

typedef int obj_asks_name(void *user, const char *name);

/* marks: of each face, set where asks returns nonzero for one of its names. 0: out of memory. */
int norma_obj_mark_faces(
    const norma_document *document, obj_asks_name *asks, void *user, uint8_t *marks);
#endif
