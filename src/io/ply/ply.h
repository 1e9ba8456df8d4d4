/* ply.h: what the files of the PLY reader and writer share. A PLY file is a text header that
 * declares elements (vertex, face, ...) with properties, then the rows of each element in that
 * order: as text, or binary in either byte order. See http://paulbourke.net/dataformats/ply/
 * (Turk's description, 1994). */
#ifndef NORMA_IO_PLY_H
#define NORMA_IO_PLY_H
#include "io/format/format.h"

typedef enum ply_type {
    PLY_INT8 = 0,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT,
    PLY_DOUBLE,
    PLY_NO_TYPE
} ply_type;
typedef enum ply_encoding { PLY_ASCII = 0, PLY_LITTLE_ENDIAN, PLY_BIG_ENDIAN } ply_encoding;

typedef struct ply_span {
    size_t offset, length;
} ply_span; /* of the file's bytes */

typedef struct ply_property {
    ply_span name, type_text, count_type_text;
    size_t line_end;     /* after the line's end in the header */
    ply_type type;       /* of the value, or of a list's items */
    ply_type count_type; /* of a list's count; PLY_NO_TYPE: no list */
} ply_property;

typedef struct ply_element {
    ply_span name, count_text;
    uint64_t count;
    size_t first_property, property_count;
    size_t fixed_size; /* bytes of a binary row without the items of its lists */
    size_t list_count;
    size_t begin, end;   /* of its rows in the file; known once located */
    size_t triangle_row; /* bytes of each row where all are one list of three items, and nothing
                            else; else 0 */
} ply_element;

enum { PLY_NONE = -1 };

typedef struct ply_header {
    ply_encoding encoding;
    ply_element *elements;
    size_t element_count, element_capacity;
    ply_property *properties; /* of all elements, one after another */
    size_t property_count, property_capacity;
    size_t body;              /* where the rows begin */
    ply_span line_break;      /* the one after "ply" */
    int vertex, face, strips; /* elements, or PLY_NONE */
    int position[3], normal[3],
        face_normal[3]; /* properties, counted within their element; PLY_NONE */
    int face_list, strip_list;
} ply_header;

/* Values that replace a property's or are put in as new ones: of row r, values[r * 3]. */
typedef struct ply_column {
    const float *floats; /* one of the two is NULL */
    const double *doubles;
    int unit; /* a component of a unit vector: text may be short */
} ply_column;
static inline double norma_ply_column_value(const ply_column *column, size_t row) {
    return column->floats ? (double)column->floats[3 * row] : column->doubles[3 * row];
}

/* What becomes of one property when an element is written. */
typedef enum ply_action {
    PLY_COPY = 0,
    PLY_VALUE,
    PLY_INDICES,
    PLY_CORNERS /* tuples of a face's corners, which turn and part with them */
} ply_action;
typedef struct ply_item {
    const ply_property *source; /* NULL: a new property */
    ply_action action;
    ply_type type, count_type;
    ply_column column; /* of PLY_VALUE */
} ply_item;

typedef struct ply_mesh { /* as decoded for the core; arrays are the state's */
    norma_vec3_view positions;
    void *own_positions; /* NULL: positions are views of the file */
    uint32_t *corners;   /* faces first, then the triangles of the strips */
    size_t corner_count;
    uint32_t *face_starts;  /* NULL: triangles only */
    size_t face_count;      /* faces and unrolled triangles of strips */
    size_t polygon_corners; /* corners of the faces alone */
    size_t polygon_count;
    size_t triangle_count;
} ply_mesh;

/* Three values a row as they are stored (codes, for integers): floats, or doubles where floats
 * would not hold all of them; or neither. */
typedef struct ply_values {
    float *floats;
    double *doubles;
    ply_type types[3];
} ply_values;
static inline int norma_ply_has_values(const ply_values *values) {
    return values->floats || values->doubles;
}

/* Changes not yet in the bytes; all NULL or 0: none. */
typedef struct ply_edit {
    ply_values normals;   /* of each output vertex */
    ply_values positions; /* of each old vertex, and of added ones where single ones are edited */
    ply_values face_normals; /* of the face element's own nx ny nz */
    uint32_t *added;         /* the vertices that the new ones at the end are copies of */
    size_t added_count;
    uint32_t *corners;      /* new corners in the order of ply_mesh.corners, or NULL */
    int reversed;           /* the winding changed: other data of corners turns with it */
    uint8_t *reversed_rows; /* with it: only in the faces where this is nonzero; or NULL: in all */
    uint8_t *dropped_rows;  /* faces that are left out, triangles of strips behind them, or NULL */
    uint8_t *cut_rows;      /* faces that become triangles, or NULL; corners is set with it */
    uint32_t *cut_corners;  /* three numbers of a face's corners each, two triangles fewer than it
                               has, from three times its first corner on */
    uint8_t *dropped_vertices; /* vertices that are left out, or NULL: values above keep a place for
                                  them, corners count without them */
} ply_edit;

typedef struct ply_state {
    const unsigned char *bytes; /* the document's */
    size_t size;
    ply_header header;
    ply_mesh mesh;
    ply_edit edit;
    float *normals;                    /* decoded on demand for norma_document_mesh_data */
    size_t vertices, faces, triangles; /* what the file holds; known at any depth */
    size_t tail;                       /* where bytes begin that follow the last element; 0: none */
    size_t surplus_rows, first_surplus; /* of text: rows with more values than the header declares;
                                           where the first of these values stands */
} ply_state;

/* ply_header.c */
norma_document_result norma_ply_read_header(norma_document *document, norma_document_error *error);
int norma_ply_span_is(const ply_state *state, ply_span span, const char *text);
static inline int norma_ply_is_list(const ply_property *property) {
    return property->count_type != PLY_NO_TYPE;
}
static inline const ply_property *norma_ply_property(
    const ply_header *header, const ply_element *element, int index) {
    return &header->properties[element->first_property + (size_t)index];
}
static inline const ply_element *norma_ply_element(const ply_header *header, int index) {
    return index == PLY_NONE ? NULL : &header->elements[index];
}
static inline const ply_element *norma_ply_vertex(const ply_state *state) {
    return norma_ply_element(&state->header, state->header.vertex);
}

/* ply_header.c: types, single values, and the size of binary rows */
size_t norma_ply_type_size(ply_type type);
const char *norma_ply_type_name(ply_type type, int with_bits); /* "float", or "float32" */
double norma_ply_get(const unsigned char *at, ply_type type, ply_encoding encoding);
int64_t norma_ply_get_integer(const unsigned char *at, ply_type type, ply_encoding encoding);
void norma_ply_put(unsigned char *at, ply_type type, ply_encoding encoding, double value);
int norma_ply_is_native(ply_encoding encoding);
int norma_ply_type_holds(ply_type type, double value); /* exactly; floats by range */
/* As text; the length. */
size_t norma_ply_format(ply_type type, double value, int unit, char text[32]);
/* After a row of a located binary element. */
const unsigned char *norma_ply_row_end(
    const ply_header *header, const ply_element *element, const unsigned char *row);
/* Bytes of a list or value at `at`, which must lie within the file. */
size_t norma_ply_property_size(
    const ply_header *header, const ply_property *property, const unsigned char *at);

/* Rows of one size. Where a property lies in one; three of its properties as stored, three doubles
 * a row; whether floats hold these; doubles become floats in place; three native numbers of each
 * row, of which the greatest is returned. */
size_t norma_ply_offset_in_row(const ply_header *header, const ply_element *element, int property);
void norma_ply_decode_rows(const ply_header *header, const ply_element *element,
    const int properties[3], const unsigned char *rows, size_t count, double *values);
int norma_ply_fits_float(
    const ply_header *header, const ply_element *element, const int properties[3]);
void norma_ply_narrow(double *values, size_t count);
uint32_t norma_ply_copy_triangles(
    const unsigned char *at, size_t row_size, size_t count, uint32_t *corners);

/* ply_rows.c: where each element's rows lie. Fails where the file is too short. */
norma_document_result norma_ply_locate(norma_document *document, norma_document_error *error);
/* The bytes of the binary row that begins there, or 0 where it does not lie within the file or a
 * count of a list is negative (then *bad is where); *place: where this property begins. */
size_t norma_ply_measure_row(const ply_state *state, const ply_element *element, size_t begin,
    int property, size_t *place, size_t *bad);

/* ply_header.c: the line of an offset, from 1; an error at an offset. */
size_t norma_ply_line_of(const ply_state *state, size_t offset);
norma_document_result norma_ply_fail_at(const norma_document *document, norma_document_error *error,
    size_t offset, const char *format, ...);
/* The file, of so many bytes, ends in that row; a row of faces or strips names a vertex that does
 * not exist. */
norma_document_result norma_ply_fail_short(const norma_document *document,
    norma_document_error *error, size_t size, const ply_element *element, uint64_t row);
norma_document_result norma_ply_fail_index(const norma_document *document,
    norma_document_error *error, size_t offset, const char *of, uint64_t row, int64_t index,
    size_t vertices);

/* ply_text.c: rows of text */
void norma_ply_surplus_text(const ply_state *state, char text[120]); /* of its surplus rows */
static inline int norma_ply_ends_line(unsigned char byte) { return byte >= '\n' && byte <= '\r'; }
norma_document_result norma_ply_locate_text(norma_document *document, norma_document_error *error);
norma_document_result norma_ply_read_text_columns(norma_document *document,
    const ply_element *element, const int properties[3], double *values,
    norma_document_error *error);
/* The items of the list of each row, one after another, with -1 kept; counts: those of each row.
 * The caller's to free. */
typedef struct ply_lists {
    int64_t *items;
    size_t item_count, item_capacity;
    uint32_t *counts;
} ply_lists;
norma_document_result norma_ply_read_lists(norma_document *document, const ply_element *element,
    int property, ply_lists *lists, norma_document_error *error);
norma_document_result norma_ply_read_text_lists(norma_document *document,
    const ply_element *element, int property, ply_lists *lists, norma_document_error *error);
void norma_ply_free_lists(ply_lists *lists);

/* ply_read.c: positions, corners, normals for the core */
norma_document_result norma_ply_read_mesh(norma_document *document, norma_document_error *error);
void norma_ply_free_mesh(ply_mesh *mesh);
/* Three properties of every row of an element as stored (codes, for integers): 3 doubles a row; the
 * caller's to free. */
norma_document_result norma_ply_read_columns(norma_document *document, const ply_element *element,
    const int properties[3], double **values, norma_document_error *error);
/* The core's mesh; valid as long as the state's is. */
norma_mesh norma_ply_core_mesh(const ply_state *state);

/* Triangle strips with restarts (-1) */
size_t norma_ply_strip_triangles(
    const int64_t *items, size_t count, uint32_t *corners); /* corners may be NULL, to count */
/* Triangles as one list of strips; -1 between them; out: room for 4 * triangles. */
size_t norma_ply_strip_encode(const uint32_t *corners, size_t triangles, int64_t *out);

/* ply_compute.c */
norma_document_result norma_ply_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error);
norma_document_result norma_ply_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error);

/* What stored codes are divided by: 127, 32767, or 1. */
double norma_ply_normal_scale(
    const ply_header *header, const ply_element *element, const int properties[3]);
static inline float norma_ply_normal_value(double stored, double scale) {
    const double value = stored / scale;
    return (float)(scale > 1 && value < -1 ? -1 : value);
}
/* As it was stored, with that scale: whole codes decode, the lowest stands for -1 as well. */
int norma_ply_is_broken(const double stored[3], double scale);
/* The types that normals are written in: as stored where that holds unit vectors, else float. */
void norma_ply_normal_types(const ply_header *header, const ply_element *element,
    const int properties[3], ply_type types[3]);
/* Unit vectors as the codes of integer types, in place; others stay. */
norma_document_result norma_ply_encode_normals(norma_document *document, const ply_type types[3],
    float *normals, size_t count, norma_document_error *error);

/* ply_write.c, ply_rows.c, ply_text.c */
norma_document_result norma_ply_write_changed(
    norma_document *document, norma_sink *sink, norma_document_error *error);
/* With normals as the only change: the header alone, and how the rows of the vertices are written;
 * those rows, of the vertices that the state is told to have. */
typedef struct ply_row {
    size_t size, normal[3]; /* bytes; where a normal's numbers lie */
} ply_row;
norma_document_result norma_ply_write_header(
    norma_document *document, norma_sink *sink, ply_row *row, norma_document_error *error);
norma_document_result norma_ply_write_vertices(
    norma_document *document, norma_sink *sink, norma_document_error *error);
int norma_ply_has_edit(const void *state); /* a ply_state */
void norma_ply_forget_edit(void *state);

/* How one element is written. */
typedef struct ply_plan {
    const ply_element *element;
    ply_item *items;
    size_t item_count;
    const uint32_t *added; /* copies of rows, after the last */
    size_t added_count;
    const uint32_t *indices; /* PLY_INDICES of faces: new corners, as many as the old list has, one
                                row after another */
    const ply_lists *lists;  /* PLY_INDICES of strips: new lists; NULL for faces */
    const uint32_t *face_starts;  /* PLY_CORNERS, cut_rows: corners of each row (NULL: 3) */
    int reversed;                 /* PLY_CORNERS: turn... */
    const uint8_t *reversed_rows; /* ...in these rows only, or NULL */
    const uint8_t *dropped_rows;  /* rows that are left out, or NULL */
    const uint8_t *cut_rows;      /* faces that become triangles, or NULL; with it indices, and
                                     cut_corners as of ply_edit */
    const uint32_t *cut_corners;
    int changed; /* 0: the rows are copied as they are */
} ply_plan;
norma_document_result norma_ply_write_rows(
    norma_document *document, const ply_plan *plan, norma_sink *sink, norma_document_error *error);
norma_document_result norma_ply_write_text_rows(
    norma_document *document, const ply_plan *plan, norma_sink *sink, norma_document_error *error);
/* A row of faces: its corners; where they begin among all. */
static inline size_t norma_ply_row_corners(const ply_plan *plan, size_t row) {
    return plan->face_starts ? plan->face_starts[row + 1] - plan->face_starts[row] : 3;
}
static inline size_t norma_ply_row_begin(const ply_plan *plan, size_t row) {
    return plan->face_starts ? plan->face_starts[row] : 3 * row;
}
static inline int norma_ply_is_cut(const ply_plan *plan, size_t row) {
    return plan->cut_rows && plan->cut_rows[row] &&
           !(plan->dropped_rows && plan->dropped_rows[row]);
}
/* Of each row of an element, where it begins (binary) or its first token lies (text), and its end;
 * the caller's to free. */
norma_document_result norma_ply_row_spans(norma_document *document, const ply_element *element,
    ply_span **spans, norma_document_error *error);
#endif
