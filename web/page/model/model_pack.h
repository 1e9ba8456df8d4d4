/* model_pack.h: what the page needs of a document, as one block of bytes: meshes as they are
 * (positions, faces, stored normals), where each is drawn, and what norma check finds. Made by
 * `norma view` and put into the page, and made in the page of a file that is dropped on it; read by
 * web/page/model/model.c. Little-endian; every array at a multiple of eight bytes from the start.
 * Public headers only: this file and its .c are compiled for both. */
#ifndef NORMA_CLI_VIEW_PACK_H
#define NORMA_CLI_VIEW_PACK_H
#include <norma/document.h>

#define VIEW_PACK_MAGIC 0x354d524eu /* "NRM5" */
#define VIEW_PACK_NONE  UINT32_MAX

typedef struct view_pack_head {
    uint32_t magic, size; /* of all of it */
    uint32_t mesh_count, meshes, draw_count,
        draws;                        /* counts, and offsets of the two arrays of records */
    uint32_t format;                  /* norma_file_format */
    uint32_t unread_count;            /* meshes of the file that are not among these */
    uint32_t finding_count, findings; /* count VIEW_PACK_NONE: not checked */
} view_pack_head;

typedef struct view_pack_mesh {
    uint32_t position_count, positions, is_double; /* three floats or doubles each */
    uint32_t corner_count, corners;                /* uint32_t each; VIEW_PACK_NONE: 0, 1, 2, ... */
    uint32_t face_count, face_starts, groups; /* offsets; VIEW_PACK_NONE: triangles, no groups */
    uint32_t normal_count, normals, storage,
        corner_normals; /* storage: norma_normal_storage; corner_normals: VIEW_PACK_NONE, or one
                           number for each corner */
    float colour[4];    /* linear, alpha last */
    uint32_t double_sided;
    uint32_t
        decimated; /* nonzero: not all of the file's faces; what is found in it has places only */
    uint32_t name; /* offset of a text that ends in a zero */
    uint32_t texcoords[2], map_texcoords; /* TEXCOORD_0 and 1; where the normal map is looked up:
                                             two floats for each position. Or VIEW_PACK_NONE */
    uint32_t tangents;                    /* x, y, z, sign for each position; or VIEW_PACK_NONE */
    uint32_t colours; /* four numbers of 16 bits for each position, linear, alpha last, 65535: 1;
                         VIEW_PACK_NONE: none */
    uint32_t material, reserved; /* its number in a glTF; VIEW_PACK_NONE: none */
} view_pack_mesh;

typedef struct view_pack_draw {
    double world[16];
    uint32_t mesh, reserved;
} view_pack_draw;

typedef struct view_pack_finding {
    double position[3], count, worst; /* where it is worst, in the mesh's own space; worst: NaN
                                         where there is no measure */
    uint32_t severity, mesh, draw,
        has_position; /* mesh, draw: VIEW_PACK_NONE: of none that is drawn; draw: VIEW_PACK_NONE:
                         wherever the mesh is */
    uint32_t id, name, unit, label, message;  /* offsets of texts that end in a zero */
    uint32_t sample_count, samples, reserved; /* the worst first */
} view_pack_finding;

typedef struct view_pack_sample {
    uint32_t face, vertex, normal;
} view_pack_sample; /* numbers as in norma_sample; VIEW_PACK_NONE: does not apply */

typedef struct view_pack {
    unsigned char *bytes; /* the caller frees them */
    size_t size, capacity;
    int failed; /* out of memory, or beyond 2^32 bytes */
} view_pack;

/* Fewer triangles of a mesh: which of its vertices stay, and the corners among those. */
typedef struct view_decimated {
    uint32_t *vertices, *corners; /* the caller frees them */
    size_t vertex_count, corner_count;
} view_decimated;

typedef struct view_pack_options {
    uint32_t threads; /* as in norma_options */
    /* Where the meshes have more triangles together, those made of triangles alone are decimated.
     * 0: never. decimate returns 0 if memory is out. */
    size_t most_triangles;
    int (*decimate)(const norma_mesh *mesh, size_t most_triangles, view_decimated *decimated);
    int unchecked; /* norma check is not asked */
} view_pack_options;

/* Everything in the document that can be drawn, and what norma check says of it, if it is asked. */
norma_document_result view_pack_document(norma_document *document, const view_pack_options *options,
    view_pack *pack, norma_document_error *error);

/* Copies count elements into the pack; where they lie. What fails is remembered there. */
uint32_t view_pack_append(view_pack *pack, const void *bytes, size_t count, size_t size);
/* pack_materials.c: colour, texture coordinates, tangents and the name of a mesh, and the number of
 * its material, which three.js reads from the file.
 * vertices: which of the mesh's are in the record; NULL: all. */
norma_document_result view_pack_material(norma_document *document, size_t mesh,
    const uint32_t *vertices, view_pack *pack, view_pack_mesh *record, norma_document_error *error);

/* pack_findings.c: the part that norma check has. record_of: of each mesh of the document its
 * record, draw_of_node: of each node its first draw; or VIEW_PACK_NONE. meshes: the records. */
norma_document_result view_pack_findings(norma_document *document, const uint32_t *record_of,
    const uint32_t *draw_of_node, const view_pack_mesh *meshes, uint32_t threads, view_pack *pack,
    view_pack_head *head, norma_document_error *error);
#endif
