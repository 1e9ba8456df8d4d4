/* asset.h: what the glTF files share: the parsed asset, how its numbers are read, and how new
 * contents and other changes get into it.
 *
 * Reading. The JSON stays as text with the place of every value (json.h). Buffers are loaded, views
 * decoded and accessors resolved where they are first needed. Nothing is trusted: what is in the
 * arrays here has been checked against what the file holds.
 *
 * Changing. New contents are put into slots (an attribute, a morph target's attribute, the indices
 * of a primitive). norma_gltf_finish then decides for each old accessor whether it is replaced (all
 * who use it get the same) or stays and new ones are added, lays out views, and edits the JSON. All
 * else (nodes, scenes) is changed by json edits. One change for a document: what is in the arrays
 * stays as it was read. */
#ifndef NORMA_IO_GLTF_H
#define NORMA_IO_GLTF_H
#include "io/format/format.h"
#include "io/text/json.h"

#define GLTF_NONE UINT32_MAX

enum {
    GLTF_BYTE = 5120,
    GLTF_UBYTE = 5121,
    GLTF_SHORT = 5122,
    GLTF_USHORT = 5123,
    GLTF_UINT = 5125,
    GLTF_FLOAT = 5126
};
enum {
    GLTF_POINTS = 0,
    GLTF_LINES,
    GLTF_LINE_LOOP,
    GLTF_LINE_STRIP,
    GLTF_TRIANGLES,
    GLTF_STRIP,
    GLTF_FAN
};

typedef enum gltf_storage {
    GLTF_STORED_BIN,
    GLTF_STORED_FILE,
    GLTF_STORED_DATA,
    GLTF_STORED_NOWHERE
} gltf_storage; /* chunk, file beside, data: URI, no bytes at all */

typedef struct gltf_buffer {
    uint32_t token;
    gltf_storage storage;
    size_t length;              /* byteLength */
    char *name;                 /* decoded URI of a file beside; else NULL */
    const unsigned char *bytes; /* NULL until loaded; at least length of them */
    size_t available;           /* so many there are, once loaded */
    file_bytes file;
    unsigned char *owned;
} gltf_buffer;

typedef struct gltf_meshopt { /* EXT_meshopt_compression of a view */
    uint32_t token;           /* of the extension's object; GLTF_NONE: not compressed */
    uint32_t buffer;
    size_t offset, length, stride, count;
    enum { GLTF_MODE_ATTRIBUTES, GLTF_MODE_TRIANGLES, GLTF_MODE_INDICES } mode;
    enum {
        GLTF_FILTER_NONE,
        GLTF_FILTER_OCTAHEDRAL,
        GLTF_FILTER_QUATERNION,
        GLTF_FILTER_EXPONENTIAL
    } filter;
} gltf_meshopt;

typedef struct gltf_view {
    uint32_t token, buffer;
    size_t offset, length, stride; /* stride 0: none given */
    gltf_meshopt meshopt;
    unsigned char *decoded;
} gltf_view;

/* Elements as they are stored (a sparse accessor's and one without a view: made dense). */
typedef struct gltf_array {
    const unsigned char *data;
    size_t count, stride;
    int component;  /* GLTF_BYTE ... */
    uint32_t width; /* numbers in an element: 1, 2, 3, 4, 9, 16 */
    int normalized;
} gltf_array;

typedef struct gltf_accessor {
    uint32_t token, view; /* GLTF_NONE: zeros */
    size_t offset, count;
    int component, normalized;
    uint32_t width;      /* 0: a type that is unknown */
    size_t element_size; /* bytes, matrix columns padded as glTF has them */
    struct {             /* count 0: not sparse */
        size_t count, indices_offset, values_offset;
        uint32_t indices_view, values_view;
        int indices_component;
    } sparse;
    uint32_t draco;    /* the primitive whose Draco stream holds its elements; GLTF_NONE: none */
    uint32_t draco_id; /* which of the stream's attributes; not for indices */
    int resolved;
    gltf_array array;
    unsigned char *owned;
    size_t
        padded; /* elements that are there, zeros behind those of the file; 0: no more than count */
} gltf_accessor;

typedef struct gltf_attribute {
    char *name;
    uint32_t token, accessor; /* token: of the number */
} gltf_attribute;

typedef struct gltf_attributes { /* a primitive's own, or one of its targets': attributes[first] ...
                                  */
    uint32_t token, first, count;
    uint32_t position, normal, tangent; /* accessors; GLTF_NONE: not there */
} gltf_attributes;

typedef struct gltf_draco { /* KHR_draco_mesh_compression of a primitive */
    uint32_t token;         /* of the extension's object; GLTF_NONE: not compressed */
    uint32_t view;
} gltf_draco;

typedef struct gltf_primitive {
    uint32_t token, mesh, number; /* number within its mesh */
    uint32_t mode, indices, material;
    gltf_attributes base;
    uint32_t first_target, target_count;
    size_t vertices, faces;         /* faces: triangles unrolled */
    const char *not_read;           /* NULL: triangles that can be computed */
    char where[64];                 /* JSON pointer */
    uint32_t *corners;              /* cached by norma_gltf_corners, 3 * faces */
    const uint32_t *direct_corners; /* the same where the file itself has them so */
    gltf_draco draco;
    uint32_t *corner_normals; /* of each corner its normal, where there are fewer than positions;
                                 made on first use */
    size_t copied;            /* bytes of the vertices that it got last (limits.c) */
} gltf_primitive;

typedef struct gltf_mesh {
    uint32_t token, first_primitive, primitive_count;
    char *name;
    uint32_t uses; /* nodes that draw it */
} gltf_mesh;

typedef struct gltf_node {
    uint32_t token, parent, mesh, skin; /* GLTF_NONE: not there */
    char *name;
    double local[16], world[16];
    int has_matrix;   /* else TRS, or nothing */
    size_t instances; /* EXT_mesh_gpu_instancing: how many; else 1 */
    int instanced;
} gltf_node;

typedef struct gltf_data { /* new contents of an accessor */
    int component, normalized;
    uint32_t width;
    size_t element_size; /* 0: width times the component's size */
    size_t count;
    unsigned char *bytes; /* elements back to back, owned */
    int bounds;           /* min and max are wanted also where there were none (POSITION) */
    int is_indices;
} gltf_data;

typedef struct gltf_patch
    gltf_patch; /* patch.h: what is to become of accessors, views and buffers */

typedef struct gltf {
    norma_document *document;
    const char *text; /* the JSON */
    size_t text_size;
    const unsigned char *bin;   /* GLB: the BIN chunk; NULL: none */
    size_t bin_size, bin_chunk; /* bin_chunk: offset of its header in the file */
    size_t container_size;      /* GLB: as its header says; the file may be longer */
    json json;
    gltf_buffer *buffers;
    gltf_view *views;
    gltf_accessor *accessors;
    gltf_mesh *meshes;
    gltf_primitive *primitives;
    gltf_attributes *targets;
    gltf_attribute *attributes;
    gltf_node *nodes;
    uint32_t *drawing; /* nodes that draw a mesh, in order */
    uint32_t buffer_count, view_count, accessor_count, mesh_count, primitive_count, target_count,
        attribute_count, node_count, drawing_count, material_count, skin_count;
    size_t held; /* bytes that the file and its buffers may hold: what counts without bytes behind
                    them are measured by */
    size_t decoded, copied, corners_drawn, vertices_drawn, vertices_moved,
        instances_placed; /* so far, measured by held (limits.c) */
    int changed;          /* something was put or edited since it was read */
    json_edits *edits;    /* of the asset's JSON */
    gltf_patch *patch;
} gltf;

static inline uint32_t norma_gltf_u32(const unsigned char *at) { /* as GLB stores it */
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static inline gltf *norma_gltf_of(const norma_document *document) { return document->state; }

/* ---- reading; each gives NORMA_DOCUMENT_OK or what norma_document_fail returned */

norma_document_result norma_gltf_open(norma_document *document, norma_document_error *error);
void norma_gltf_close(norma_document *document);
norma_document_result norma_gltf_read_buffers(
    gltf *g, norma_document_error *error); /* buffers.c: the descriptions, no bytes yet */
norma_document_result norma_gltf_read_accessors(
    gltf *g, norma_document_error *error); /* accessors.c */
norma_document_result norma_gltf_read_meshes(
    gltf *g, norma_document_error *error); /* primitives.c */
norma_document_result norma_gltf_read_nodes(gltf *g, norma_document_error *error); /* node_tree.c */
norma_document_result norma_gltf_load_buffer(gltf *g, uint32_t buffer, norma_document_error *error);
int norma_gltf_view_overruns(const gltf *g, uint32_t view); /* its end lies beyond its buffer's */
norma_document_result norma_gltf_view_bytes(gltf *g, uint32_t view, const unsigned char **bytes,
    norma_document_error *error); /* decoded where compressed; view->length of them */
norma_document_result norma_gltf_decode_meshopt(
    gltf *g, uint32_t view, norma_document_error *error);

/* Elements of a view: count of them, each size bytes, from offset on. token: for messages. */
typedef struct gltf_elements {
    uint32_t token, view;
    size_t offset, count, size;
} gltf_elements;
/* Whether they are apart from one another and end inside the view; none of its bytes are read. */
norma_document_result norma_gltf_measure_elements(
    gltf *g, const gltf_elements *elements, size_t *stride, norma_document_error *error);

const char *norma_gltf_extension_of(
    const gltf *g, const gltf_meshopt *m); /* its name in the file */
/* Compresses m->count rows of m->stride bytes by m->mode and m->filter, or by others where those do
 * not give the same bytes back; m says by which, and how long it became. To be freed; NULL: out of
 * memory. */
unsigned char *norma_gltf_encode_meshopt(gltf_meshopt *m, const unsigned char *bytes);
int norma_gltf_reads_meshopt(void); /* 0: the library is built without meshoptimizer */
/* draco_primitives.c: reads the extension of a primitive whose accessors are known, and gives the
 * accessors that it names to its stream; *why: the primitive cannot be read. */
norma_document_result norma_gltf_read_draco(
    gltf *g, uint32_t primitive, const char **why, norma_document_error *error);
norma_document_result norma_gltf_decode_draco(
    gltf *g, uint32_t primitive, norma_document_error *error); /* resolves those accessors */
/* The elements of an accessor, resolved once and cached. */
norma_document_result norma_gltf_array(
    gltf *g, uint32_t accessor, gltf_array *array, norma_document_error *error);

/* limits.c: before count elements of size bytes (not 0) are decoded for what token says, before a
 * primitive's corners are read. */
norma_document_result norma_gltf_spend(
    gltf *g, uint32_t token, size_t count, size_t size, norma_document_error *error);
norma_document_result norma_gltf_draw(
    gltf *g, const gltf_primitive *p, norma_document_error *error);
norma_document_result norma_gltf_copy_vertices(gltf *g, gltf_primitive *p, size_t count,
    size_t size,
    norma_document_error *error); /* before it gets so many, of size bytes, instead of its own */
norma_document_result norma_gltf_place_instances(
    gltf *g, const gltf_node *node, norma_document_error *error); /* of a node that has any */

size_t norma_gltf_component_size(int component); /* 0: unknown */
void norma_gltf_floats(const gltf_array *array, size_t index,
    float *out); /* one element, width numbers, normalised integers decoded */
void norma_gltf_uints(
    const gltf_array *array, size_t index, uint32_t *out); /* of an unsigned integer accessor */
/* Which elements a sparse accessor replaces: sparse.count numbers below count. */
norma_document_result norma_gltf_sparse_indices(
    gltf *g, uint32_t accessor, uint32_t *out, norma_document_error *error);
norma_vec3_view norma_gltf_vec3_view(
    const gltf_array *array); /* integers as they are; width must be 3 */

/* Corners of the primitive's triangles (strips and fans unrolled), 3 * faces, each below vertices;
 * cached. Fails for what cannot be read. */
norma_document_result norma_gltf_corners(
    gltf *g, uint32_t primitive, const uint32_t **corners, norma_document_error *error);

uint32_t norma_gltf_find(const gltf *g, const gltf_attributes *attributes,
    const char *name); /* number in g->attributes, or GLTF_NONE */
void norma_gltf_multiply(
    const double a[16], const double b[16], double out[16]); /* column-major; out may not overlap */

/* Optional object members: 1: there (or, 2nd form, absent and *value left as it was), 0: there with
 * another type or out of range; message filled by the caller. */
int norma_gltf_size_member(const gltf *g, uint32_t object, const char *key, size_t *value);
int norma_gltf_index_member(
    const gltf *g, uint32_t object, const char *key, uint32_t limit, uint32_t *value);
norma_document_result norma_gltf_malformed(const gltf *g, norma_document_error *error,
    uint32_t token, const char *expected); /* names the JSON pointer of token */
char *norma_gltf_pointer(
    const gltf *g, uint32_t token, char *out, size_t capacity); /* JSON pointer, cut to fit */

/* ---- URIs (uri.c) */
char *norma_gltf_uri_decode(const char *uri); /* percent escapes resolved, to be freed; NULL: out of
                                                 memory, a bad escape, or an escaped NUL */
char *norma_gltf_uri_encode(const char *name);
int norma_gltf_uri_is_data(const char *uri);
/* An image's URI as a name; NULL: it has none, or its bytes stand in the URI itself. *failed:
 * memory is out. */
char *norma_gltf_image_name(const json *j, uint32_t image, int *failed);
/* Of a data: URI; NULL: not base64 (or percent-encoded) as it should be, out of memory, or
 * cancelled.
 */
unsigned char *norma_gltf_data_decode(
    const char *uri, size_t length, norma_watch *watch, size_t *size);
/* 1: name (decoded) is a file in folder or below, not absolute, no scheme, without "..", also after
 * symbolic links; 0: outside; *path: to be freed. */
int norma_gltf_path_inside(const char *folder, const char *name, char **path);
/* The same, every link followed; to be freed. What is not there, as it is given. NULL: out of
 * memory. */
char *norma_gltf_real_path(const char *folder, const char *name);
/* Of a path, with its slash, "" for the current one; to be freed. */
char *norma_gltf_folder_of(const char *path);

/* ---- changing (patch.c) */

enum { GLTF_SLOT_BASE = -1, GLTF_SLOT_INDICES = -2 };
typedef struct gltf_slot {
    uint32_t copy;         /* 0: the mesh itself; else what norma_gltf_copy_mesh gave */
    uint32_t primitive;    /* number in g->primitives */
    int32_t target;        /* GLTF_SLOT_BASE, GLTF_SLOT_INDICES, or the number of a morph target */
    const char *attribute; /* "NORMAL", ...; must outlive the patch (a literal, or a name in
                              g->attributes); NULL with GLTF_SLOT_INDICES */
} gltf_slot;

int norma_gltf_has_change(const norma_document *document); /* since it was read */
void norma_gltf_adopt(norma_document *document);           /* its state is its own from now on */
/* Before anything is put. */
void norma_gltf_begin_change(gltf *g);
int norma_gltf_drop_change(
    norma_document *document); /* as if it had not been begun; 0: no memory */
/* Whether it is no longer what the file is: by a change that waits, or by those before. */
static inline int norma_gltf_differs(const gltf *g) {
    return g->changed || g->document->given_count > 0;
}
size_t norma_gltf_data_size(const gltf_data *data); /* bytes of one element */
/* Registers contents (bytes become the patch's, also on failure) and gives their number, to be put
 * into one slot or several. GLTF_NONE: out of memory. */
uint32_t norma_gltf_add_data(gltf *g, const gltf_data *data);
/* These contents in this slot. Without a word about a slot it keeps its accessor. Once for each
 * slot. 0: out of memory. */
int norma_gltf_put(gltf *g, const gltf_slot *slot, uint32_t data);
void norma_gltf_set_mode(gltf *g, uint32_t copy, uint32_t primitive, uint32_t mode);
/* A copy of a mesh at the end of "meshes": its handle for slots and edits (from 1), its number in
 * the file in *mesh_number. 0: out of memory. */
uint32_t norma_gltf_copy_mesh(gltf *g, uint32_t mesh, uint32_t *mesh_number);
/* One use of an accessor outside the meshes (instancing) is given up: where nobody uses it any
 * more, new contents take its place. 0: out of memory. */
int norma_gltf_release(gltf *g, uint32_t accessor);
json_edits *norma_gltf_edits(
    gltf *g, uint32_t copy); /* 0: of the asset; else those that apply to the copy alone */
/* Nothing uses the extension (a literal) any more: it leaves extensionsUsed and extensionsRequired
 * in the end. 0: out of memory. */
int norma_gltf_unlist(gltf *g, const char *extension);
/* Normals and tangents of a primitive are removed in the JSON: no new contents for them. 0: out of
 * memory. */
int norma_gltf_strip(gltf *g, uint32_t primitive);
/* Turns all that was put into edits and views. To be called once, at the end of compute or
 * transform; afterwards g->changed says whether anything is new. */
norma_document_result norma_gltf_finish(gltf *g, norma_document_error *error);

/* ---- writing (gltf_write.c, companion_files.c) */
norma_document_result norma_gltf_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error);
norma_document_result norma_gltf_write_companions(norma_document *document, const char *path,
    int in_place, companion_writers *writers, norma_document_error *error);
char *norma_gltf_changed_companion(const norma_document *document);
norma_document_result norma_gltf_reopen(
    norma_document *document, norma_document *made, norma_document_error *error);
int norma_gltf_visit_files(const norma_document *document, norma_visit_file *visit, void *user);

/* ---- commands */
norma_document_result norma_gltf_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error);
norma_document_result norma_gltf_tangents(norma_document *document,
    const norma_tangent_options *options, norma_tangent_summary *summary,
    norma_document_error *error);
norma_document_result norma_gltf_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error);
/* vertex_copies.c: the elements of an accessor as the edit's new vertices have them (*owned: to be
 * freed; NULL: as stored); all attributes that the edit does not set, put. */
norma_document_result norma_gltf_copy_array(gltf *g, uint32_t accessor, const norma_mesh_edit *edit,
    gltf_array *array, unsigned char **owned, norma_document_error *error);
norma_document_result norma_gltf_put_vertices(
    gltf *g, uint32_t primitive, const norma_mesh_edit *edit, norma_document_error *error);
size_t norma_gltf_vertex_size(
    const gltf *g, const gltf_primitive *p); /* bytes, those of all targets among them */
norma_document_result norma_gltf_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error);
norma_document_result norma_gltf_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error);
/* How the components of an accessor are stored, in a word; "" for GLTF_NONE. */
const char *norma_gltf_encoding_name(const gltf *g, uint32_t accessor); /* gltf_scene.c */
#endif
