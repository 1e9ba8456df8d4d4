/* view_pack.h: what the page needs of a document, as one block of bytes: meshes as they are (positions, faces, stored normals), and where each is drawn. Made by
 * `norma view` and put into the page, and made in the page of a file that is dropped on it; read by web/model/model.c. Little-endian; every array at a multiple of
 * eight bytes from the start. Public headers only: this file and its .c are compiled for both. */
#ifndef NORMA_CLI_VIEW_PACK_H
#define NORMA_CLI_VIEW_PACK_H
#include <norma/document.h>

#define VIEW_PACK_MAGIC 0x314d524eu /* "NRM1" */
#define VIEW_PACK_NONE  UINT32_MAX

typedef struct view_pack_head {
    uint32_t magic, size;                          /* of all of it */
    uint32_t mesh_count, meshes, draw_count, draws; /* counts, and offsets of the two arrays of records */
    uint32_t format;                               /* norma_file_format */
    uint32_t unread_count;                         /* meshes of the file that are not among these */
} view_pack_head;

typedef struct view_pack_mesh {
    uint32_t position_count, positions, is_double;          /* three floats or doubles each */
    uint32_t corner_count, corners;                         /* uint32_t each; VIEW_PACK_NONE: 0, 1, 2, ... */
    uint32_t face_count, face_starts, groups;               /* offsets; VIEW_PACK_NONE: triangles, no groups */
    uint32_t normal_count, normals, storage, corner_normals; /* storage: norma_normal_storage; corner_normals: VIEW_PACK_NONE, or one number for each corner */
    float    colour[4];                                     /* linear, alpha last */
    uint32_t double_sided, reserved;
} view_pack_mesh;

typedef struct view_pack_draw {
    double   world[16];
    uint32_t mesh, reserved;
} view_pack_draw;

typedef struct view_pack {
    unsigned char *bytes; /* the caller frees them */
    size_t size, capacity;
    int failed;           /* out of memory, or beyond 2^32 bytes */
} view_pack;

/* Everything in the document that can be drawn. */
norma_document_result view_pack_document(norma_document *document, view_pack *pack, norma_document_error *error);
#endif
