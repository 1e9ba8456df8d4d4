/* 3mf.h: a 3MF package: the zip and the XML that it is written in, its parts that hold models, the
 * objects in them, and where the build puts their meshes. */
#ifndef NORMA_IO_3MF_H
#define NORMA_IO_3MF_H
#include "io/format/format.h"

/* ---- Packing and unpacking of a zip's members. */

typedef enum inflate_result { INFLATE_OK, INFLATE_NO_MEMORY, INFLATE_DAMAGED } inflate_result;

/* To exactly size bytes; damaged: the stream has more or fewer. */
inflate_result norma_inflate(const unsigned char *from, size_t packed, char *to, size_t size);
/* To be freed; NULL: there is no memory. size: at most INT32_MAX. */
unsigned char *norma_deflate(const unsigned char *from, size_t size, size_t *packed);

/* ---- The members of a zip archive in memory. */

typedef struct zip_field { /* a number of the directory: where it is, and its width, 4 or 8 */
    size_t at, width;
} zip_field;

typedef struct zip_member {
    const char *name;             /* in the archive, not terminated */
    size_t name_length, entry;    /* entry: in the directory */
    uint64_t size, packed, local; /* local: offset of its own header */
    zip_field size_field, packed_field, local_field;
    unsigned method, flags;
    uint32_t sum, part; /* part: the caller's, 0 at first */
} zip_member;

typedef struct zip_archive {
    const unsigned char *bytes;  /* not owned */
    size_t size, directory, end; /* offsets of the directory, and of what ends it */
    zip_field directory_fields[2];
    size_t directory_field_count;
    zip_member *members;
    const zip_member **by_name; /* in the same memory */
    size_t count;
} zip_archive;

/* NULL, or what is wrong; "" where memory is out. The caller frees archive->members. */
const char *norma_zip_read(const unsigned char *bytes, size_t size, zip_archive *archive);
/* The first of this name, or SIZE_MAX, O(log(count)). Letters are compared without their case, as
 * OPC has it. */
size_t norma_zip_find(const zip_archive *archive, const char *name, size_t length);
/* The contents, to be freed; archive->members[member].size of them. *wrong as norma_zip_read. */
char *norma_zip_unpack(const zip_archive *archive, size_t member, const char **wrong);
/* Writes the archive to out, which is empty, with other contents for those members whose
 * contents[i].size is not 0, packed by the same method. All else keeps its bytes. */
const char *norma_zip_replace(
    const zip_archive *archive, const growing_bytes *contents, growing_bytes *out);

/* ---- XML in memory, tag by tag: what packages and models are written in. */

enum { XML_MOST_ATTRIBUTES = 256 }; /* of a tag: each is compared with those before it */

typedef enum xml_event {
    XML_BEGINS, /* an element; <a/> begins and ends */
    XML_ENDS,
    XML_DONE,
    XML_WRONG, /* wrong says why: no XML, a document type or another encoding than UTF-8 */
    XML_NO_MEMORY
} xml_event;

typedef struct xml_span {
    size_t at, length;
} xml_span;

typedef struct xml_reader {
    /* text, which is not owned, ends with a zero byte at text[size]. */
    const char *text;
    size_t size, begin, at;  /* the last event was from begin to at */
    const char *name;        /* of what begins */
    const char **attributes; /* names and values in turn, then NULL; references are replaced */
    char wrong[120];
    char *words; /* where name and attributes point */
    xml_span *open;
    size_t attribute_count, attribute_capacity, word_capacity, depth, open_capacity;
    int started, has_root, is_empty_tag;
} xml_reader;

/* reader: all zero but text and size. After XML_DONE and what stands behind it there it is done. */
xml_event norma_xml_next(xml_reader *reader);
/* The number of the line where the last event began. */
size_t norma_xml_line(const xml_reader *reader);
void norma_xml_free(xml_reader *reader); /* keeps the text */

/* ---- The package and what is in it. */

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
