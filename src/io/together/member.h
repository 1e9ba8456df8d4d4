/* member.h: one of the files that hold a surface, opened: where its meshes are drawn, at which
 * level of detail, and what of it keeps its normals. */
#ifndef NORMA_IO_TOGETHER_MEMBER_H
#define NORMA_IO_TOGETHER_MEMBER_H
#include "io/together/world.h"
#include <norma/large.h>

typedef struct member {
    norma_document *document;
    uint32_t level;
    int has_level; /* of the whole file */
    uint32_t *node_levels;
    uint8_t
        *locked; /* of each mesh (glTF), of each face (OBJ), of the whole (PLY); NULL: nothing */
} member;

/* Opens a file and finds out what stands above. Close it in any case. */
norma_document_result norma_member_open(const norma_together_file *file, size_t number,
    const norma_together_options *options, member *m, norma_document_error *error);
void norma_member_close(member *m);

/* Calls visit for each surface. */
norma_document_result norma_member_visit(
    member *m, visit_surface *visit, void *user, norma_document_error *error);
/* All places where a surface is drawn; none in a glTF that draws others. *places is to be freed. */
norma_document_result norma_member_places(const member *m, const document_surface *surface,
    placement **places, size_t *count, norma_document_error *error);
#endif
