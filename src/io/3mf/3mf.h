/* 3mf.h: a 3MF package: its parts that hold models, the objects in them, and where the build puts
 * their meshes. */
#ifndef NORMA_IO_3MF_H
#define NORMA_IO_3MF_H
#include "io/3mf/zip.h"
#include "io/format/format.h"

typedef struct tmf_part { /* a model in the package */
    char *name;           /* without its first slash */
    char *text;           /* unpacked, while it is read or edited */
    size_t size;
} tmf_part;

typedef struct tmf_object {
    uint32_t id, part, number; /* number: of all objects of the package, in order */
    char *name, *where;
    double *positions;
    uint32_t *corners;
    size_t vertices, faces, position_capacity, corner_capacity;
    size_t first_component, component_count;
    int has_mesh, is_other; /* other: the build may not draw it */
    int has_sets;           /* sets name its triangles by number, so none is dropped */
    size_t mesh;            /* its number in the document */
} tmf_object;

typedef struct tmf_use { /* a component or an item: an object at a place */
    uint32_t id, part;
    double matrix[16]; /* column-major */
} tmf_use;

typedef struct tmf_id { /* of a resource that is no object */
    uint32_t part, id;
} tmf_id;

typedef struct tmf_required { /* an extension that a model requires and nothing here reads */
    uint32_t part;
    char *space; /* its namespace */
} tmf_required;

typedef struct tmf_node {
    size_t mesh;
    double world[16];
    char *name, *where;
} tmf_node;

typedef struct tmf_state {
    tmf_part *parts; /* the first is the root model */
    tmf_object *objects;
    tmf_use *components, *items;
    tmf_node *nodes;
    tmf_id *others;
    tmf_required *required;
    uint32_t *meshes; /* the objects that have one */
    size_t part_count, part_capacity, object_count, object_capacity, component_count,
        component_capacity, item_count, item_capacity, node_count, node_capacity, mesh_count,
        other_count, other_capacity, required_count, required_capacity;
    size_t unpacked; /* bytes of XML so far */
    zip_archive zip; /* while the package is open */
} tmf_state;

/* ---- package.c: what follows needs the package to be open */

norma_document_result norma_3mf_open(norma_document *document, norma_document_error *error);
void norma_3mf_close(norma_document *document);

/* The root model's part, by the package's relationships; not unpacked yet. */
norma_document_result norma_3mf_find_model(norma_document *document, norma_document_error *error);
/* What a part's relationships name is in the package, and one print ticket at most. */
norma_document_result norma_3mf_check_relationships(
    norma_document *document, uint32_t part, norma_document_error *error);
/* The number of a part of this name, added if it is new. */
norma_document_result norma_3mf_add_part(norma_document *document, const char *name, size_t length,
    uint32_t *part, norma_document_error *error);
norma_document_result norma_3mf_unpack(
    norma_document *document, uint32_t part, norma_document_error *error);
/* The package with other texts in place of those of the parts that have one; texts[i] may be empty.
 */
norma_document_result norma_3mf_pack(norma_document *document, growing_bytes *texts,
    growing_bytes *package, norma_document_error *error);

/* ---- model.c */

/* Reads an unpacked part into the state. */
norma_document_result norma_3mf_read_model(
    norma_document *document, uint32_t part, norma_document_error *error);
/* The text of the unpacked part that has the object, with its triangles reversed or dropped. */
norma_document_result norma_3mf_edit_model(norma_document *document, uint32_t object,
    const norma_mesh_edit *edits, growing_bytes *text, norma_document_error *error);
/* Nodes for each mesh that the build draws. */
norma_document_result norma_3mf_place(norma_document *document, norma_document_error *error);
#endif
