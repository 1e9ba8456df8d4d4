/* gltf.h: a glTF asset: its JSON, and what was read of it (buffers, views, accessors, meshes,
 * nodes); what its viewers draw; changes: new contents of accessors, which become edits of the JSON
 * and bytes of the buffers; and what computing normals and tangents, and baking, share between
 * their files. */
#ifndef NORMA_IO_GLTF_H
#define NORMA_IO_GLTF_H
#include "io/format/format.h"
#include "io/text/text.h"
#include "core/face/face.h"
#include <math.h>
#include "io/file/file.h"

/* ---- What the glTF files share: the parsed asset, how its numbers are read, and how new
 * contents and other changes get into it.
 *
 * Reading. The JSON stays as text with the place of every value. Buffers are loaded, views
 * decoded and accessors resolved where they are first needed. Nothing is trusted: what is in the
 * arrays here has been checked against what the file holds.
 *
 * Changing. New contents are put into slots (an attribute, a morph target's attribute, the indices
 * of a primitive). norma_gltf_finish then decides for each old accessor whether it is replaced (all
 * who use it get the same) or stays and new ones are added, lays out views, and edits the JSON. All
 * else (nodes, scenes) is changed by json edits. One change for a document: what is in the arrays
 * stays as it was read. */

#define GLTF_NONE  UINT32_MAX
#define GLTF_DRACO "KHR_draco_mesh_compression"

enum {
    GLTF_BYTE = 5120,
    GLTF_UBYTE = 5121,
    GLTF_SHORT = 5122,
    GLTF_USHORT = 5123,
    GLTF_UINT = 5125,
    GLTF_FLOAT = 5126,
    GLTF_DOUBLE = 5130, /* KHR_accessor_float64, glTF 2.1 */
    GLTF_HALF = 5131    /* KHR_accessor_float16, glTF 2.1 */
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

extern const char *const norma_gltf_meshopt_modes[3], *const norma_gltf_meshopt_filters[4];

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
    uint32_t attribute_end; /* g->attributes from base.first to here: its own and its targets' */
    size_t vertices, faces; /* faces: triangles unrolled */
    const char *not_read;   /* NULL: triangles that can be computed */
    char where[64];         /* JSON pointer */
    uint32_t *corners;      /* cached by norma_gltf_corners, 3 * faces */
    const uint32_t *direct_corners; /* the same where the file itself has them so */
    gltf_draco draco;
    uint32_t *corner_normals; /* of each corner its normal, where there are fewer than positions;
                                 made on first use */
    size_t copied;            /* bytes of the vertices that it got last (members.c) */
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
    gltf_patch; /* gltf_layout.h: what is to become of accessors, views and buffers */

enum { TILE_DEPTH = 8 };
/* A GLB in its file: all of it, or the end of a tile of 3D Tiles 1.0 (nodes.c). */
typedef struct gltf_tile {
    size_t at, end;             /* of the GLB; of the tile or the file */
    size_t headers[TILE_DEPTH]; /* offsets of the tile's and the composites' around it */
    size_t begins; /* of a composite's tile that was opened by itself: where it begins there */
    /* i3dm: how often it draws the model, and each time how; 0: once, or each time as it stands */
    size_t instances;
    const unsigned char *up, *right, *scale, *scales; /* an element for each; NULL: none */
    int has_octahedral;                               /* up and right: two numbers of 16 bits */
    const char *not_read;                             /* why not; NULL: they were */
    double center[3]; /* RTC_CENTER: where the origin of its positions lies */
    int is_elsewhere; /* where its instances say, or a center that is not three numbers */
    uint32_t depth;   /* of them; 0: the file is the GLB */
    size_t left_out,
        left_out_at; /* tiles beside it without a GLB; where the first of them begins */
    const char *left_out_why;
} gltf_tile;

typedef struct gltf {
    norma_document *document;
    const char *text; /* the JSON */
    size_t text_size;
    const unsigned char *bin;   /* GLB: the BIN chunk; NULL: none */
    size_t bin_size, bin_chunk; /* bin_chunk: offset of its header in the file */
    size_t container_size;      /* GLB: as its header says; the file may be longer */
    gltf_tile tile;             /* where the GLB lies in the file */
    json json;
    size_t alignment; /* of new bytes: of the widest numbers that an accessor has */
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
        instances_placed; /* so far, measured by held (members.c) */
    int changed;          /* something was put or edited since it was read */
    json_edits *edits;    /* of the asset's JSON */
    gltf_patch *patch;
} gltf;

static inline uint32_t norma_gltf_u32(const unsigned char *at) { /* as GLB stores it */
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* Whether this machine stores numbers as glTF does. */
static inline int norma_gltf_is_low_first(void) {
    return norma_gltf_u32((const unsigned char *)&(const uint32_t){1}) == 1;
}

/* An unsigned integer, as an accessor stores it. */
static inline uint32_t norma_gltf_read_uint(const unsigned char *at, int component) {
    return component == GLTF_UBYTE    ? at[0]
           : component == GLTF_USHORT ? (uint32_t)at[0] | (uint32_t)at[1] << 8
                                      : norma_gltf_u32(at);
}

static inline gltf *norma_gltf_of(const norma_document *document) { return document->state; }

/* ---- reading; each gives NORMA_DOCUMENT_OK or what norma_document_fail returned */

/* nodes.c: fills g->tile; where the file is a tile of 3D Tiles 1.0, the GLB in it. */
norma_document_result norma_gltf_find_tile(gltf *g, norma_document_error *error);
/* How many a tile has; tiles: written, the first of them, as many as there is room for. left_out:
 * written, those without one. */
norma_document_result norma_gltf_find_tiles(const norma_document *document, gltf_tile *tiles,
    size_t room, size_t *found, gltf_tile *left_out, norma_document_error *error);
/* gltf_write.c: how many bytes behind the GLB are more than what aligns a tile. */
size_t norma_gltf_surplus(const gltf *g);
norma_document_result norma_gltf_read_buffers(
    gltf *g, norma_document_error *error); /* buffers.c: the descriptions, no bytes yet */
norma_document_result norma_gltf_read_accessors(
    gltf *g, norma_document_error *error); /* accessors.c */
norma_document_result norma_gltf_read_meshes(
    gltf *g, norma_document_error *error); /* primitives.c */
norma_document_result norma_gltf_read_nodes(gltf *g, norma_document_error *error); /* nodes.c */
/* nodes.c: how an i3dm turns and scales its instances (tile.not_read, if that is not in the file).
 */
norma_document_result norma_gltf_read_tile_instances(gltf *g, norma_document_error *error);
/* Where the origin of the document's positions lies, by what is not in its nodes: RTC_CENTER of a
 * tile, CESIUM_RTC. 0: at no one place. */
int norma_gltf_read_frame(const gltf *g, double center[3]);
/* buffers.c: its bytes, once */
norma_document_result norma_gltf_load_buffer(gltf *g, uint32_t buffer, norma_document_error *error);
static inline int norma_gltf_lies_in(const gltf *g, uint32_t buffer, size_t offset, size_t length) {
    const size_t room = g->buffers[buffer].length;
    return offset <= room && length <= room - offset;
}
/* Its buffer has no URI, so the program that loads the file has to bring the bytes. */
static inline int norma_gltf_has_no_bytes(const gltf *g, uint32_t view) {
    const gltf_view *v = &g->views[view];
    const uint32_t buffer = v->meshopt.token == GLTF_NONE ? v->buffer : v->meshopt.buffer;
    return g->buffers[buffer].storage == GLTF_STORED_NOWHERE;
}
int norma_gltf_view_overruns(
    const gltf *g, uint32_t view); /* buffers.c: its end lies beyond its buffer's */
/* accessors.c, as all that follows without the name of a file */
norma_document_result norma_gltf_view_bytes(gltf *g, uint32_t view, const unsigned char **bytes,
    norma_document_error *error); /* decoded where compressed; view->length of them */
/* meshopt_views.c, or meshopt_left_out.c: a compressed view's bytes */
norma_document_result norma_gltf_decode_meshopt(
    gltf *g, uint32_t view, norma_document_error *error);
const char *norma_gltf_extension_of(
    const gltf *g, const gltf_meshopt *m); /* its name in the file */
/* meshopt_views.c: compresses m->count rows of m->stride bytes by m->mode and m->filter, or by
 * others where those do not give the same bytes back; m says by which, and how long it became. To
 * be freed; NULL: out of memory. */
unsigned char *norma_gltf_encode_meshopt(gltf_meshopt *m, const unsigned char *bytes);
int norma_gltf_reads_meshopt(void); /* 0: the library is built without meshoptimizer */
/* Reads the extension of a primitive whose accessors are known, and gives the
 * accessors that it names to its stream; *why: the primitive cannot be read. */
norma_document_result norma_gltf_read_draco(
    gltf *g, uint32_t primitive, const char **why, norma_document_error *error);
/* The elements of an accessor, resolved once and cached. */
norma_document_result norma_gltf_array(
    gltf *g, uint32_t accessor, gltf_array *array, norma_document_error *error);

/* members.c: before count elements of size bytes (not 0) are decoded for what token says, before a
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
/* Of indices below vertices: the largest value of a width is none (glTF 2.0, 3.7.2.1). At least the
 * width that the primitive's have, or that of without. */
int norma_gltf_index_component(
    const gltf *g, const gltf_primitive *p, size_t vertices, int without);
unsigned char *norma_gltf_encode_indices(
    int component, const uint32_t *indices, size_t count); /* to be freed; NULL: out of memory */
/* One element, width numbers, normalised integers decoded. */
void norma_gltf_doubles(const gltf_array *array, size_t index, double *out);
void norma_gltf_floats(const gltf_array *array, size_t index, float *out);
/* Integers: a number in their range, its fraction cut off; floats: the nearest. */
void norma_gltf_write_number(unsigned char *at, int component, double number);
/* What a normalised integer is divided by; 1: none. */
double norma_gltf_largest_code(int component);
/* Whether half floats can hold a number: exactly, or rounded without becoming infinite. */
int norma_gltf_fits_half(double number, int exactly);
static inline int norma_gltf_is_float(int component) {
    return component == GLTF_FLOAT || component == GLTF_DOUBLE || component == GLTF_HALF;
}
static inline int norma_gltf_holds_units(int component, int normalized) {
    return norma_gltf_is_float(component) ||
           (normalized && (component == GLTF_BYTE || component == GLTF_SHORT));
}
void norma_gltf_uints(
    const gltf_array *array, size_t index, uint32_t *out); /* of an unsigned integer accessor */
/* Which elements a sparse accessor replaces: sparse.count numbers below count. */
norma_document_result norma_gltf_sparse_indices(
    gltf *g, uint32_t accessor, uint32_t *out, norma_document_error *error);
norma_vec3_view norma_gltf_vec3_view(
    const gltf_array *array); /* integers as they are; width must be 3; no half floats */
/* The same of an accessor of positions; half floats are decoded. */
norma_document_result norma_gltf_position_view(
    gltf *g, uint32_t accessor, norma_vec3_view *view, norma_document_error *error);

/* primitives.c: corners of the primitive's triangles (strips and fans unrolled), 3 * faces, each
 * below vertices; cached. Fails for what cannot be read. */
norma_document_result norma_gltf_corners(
    gltf *g, uint32_t primitive, const uint32_t **corners, norma_document_error *error);

/* The attributes of a morph target, or the primitive's own for GLTF_SLOT_BASE. */
enum { GLTF_SLOT_BASE = -1, GLTF_SLOT_INDICES = -2 };
static inline const gltf_attributes *norma_gltf_set_of(
    const gltf *g, const gltf_primitive *p, int32_t target) {
    return target == GLTF_SLOT_BASE ? &p->base : &g->targets[p->first_target + (uint32_t)target];
}
uint32_t norma_gltf_find(const gltf *g, const gltf_attributes *attributes,
    const char *name); /* number in g->attributes, or GLTF_NONE */
/* The accessor of "COLOR_0" and such; GLTF_NONE: none. */
uint32_t norma_gltf_numbered(const gltf *g, const gltf_primitive *p, const char *name, size_t set);
/* The same of a set of texture coordinates, a pair for each vertex. */
uint32_t norma_gltf_texcoords(const gltf *g, const gltf_primitive *p, size_t set);

/* members.c, as the rest of this part. Optional object members: 1: there (or, 2nd form, absent and
 * *value left as it was), 0: there with another type or out of range; message filled by the caller.
 */
/* A number below limit, the index of something; GLTF_NONE: it is none. */
static inline uint32_t norma_gltf_number(const gltf *g, uint32_t token, uint32_t limit) {
    uint64_t number;
    return token != JSON_NONE && norma_json_uint(&g->json, token, &number) && number < limit
               ? (uint32_t)number
               : GLTF_NONE;
}
static inline uint32_t norma_gltf_extension(const gltf *g, uint32_t object, const char *name) {
    return norma_json_member(&g->json, norma_json_member(&g->json, object, "extensions"), name);
}
int norma_gltf_size_member(const gltf *g, uint32_t object, const char *key, size_t *value);
int norma_gltf_index_member(
    const gltf *g, uint32_t object, const char *key, uint32_t limit, uint32_t *value);
/* A member as an object has it, in its own text, as one of the object that text is; if it has it.
 */
void norma_gltf_copy_member(const gltf *g, json_text *text, uint32_t object, const char *key);
/* Whether an object has another extension than those, of which NULL is the last. */
int norma_gltf_extends_beyond(const gltf *g, uint32_t object, const char *const *known);
/* Whether one of the root's lists has the name. */
int norma_gltf_lists(const gltf *g, const char *list, const char *name);
/* And the list of extensions with the last of them. */
void norma_gltf_remove_extension(
    const gltf *g, json_edits *edits, uint32_t object, const char *name);
/* A list of objects among the root's members; empty where there is none. */
norma_document_result norma_gltf_read_list(
    const gltf *g, const char *name, uint32_t *list, uint32_t *count, norma_document_error *error);
norma_document_result norma_gltf_malformed(const gltf *g, norma_document_error *error,
    uint32_t token, const char *expected); /* names the JSON pointer of token */
typedef struct gltf_place {
    char text[200]; /* a JSON pointer, cut to fit */
} gltf_place;
gltf_place norma_gltf_pointer(const gltf *g, uint32_t token);

/* ---- URIs (buffers.c) */
char *norma_gltf_uri_decode(const char *uri); /* percent escapes resolved, to be freed; NULL: out of
                                                 memory, a bad escape, or an escaped NUL */
char *norma_gltf_uri_encode(const char *name);
int norma_gltf_uri_is_data(const char *uri);
/* The URI of an image or a buffer as a name; NULL: it has none, or its bytes stand in the URI
 * itself. *failed: memory is out. */
char *norma_gltf_file_name(const json *j, uint32_t image, int *failed);
/* Of a data: URI; NULL: not base64 (or percent-encoded) as it should be, out of memory, or
 * cancelled.
 */
unsigned char *norma_gltf_data_decode(
    const char *uri, size_t length, norma_watch *watch, size_t *size);
/* 1: name (decoded) is a file in folder or below, not absolute, no scheme, without "..", also after
 * symbolic links; 0: outside; *path: to be freed. */
int norma_gltf_path_inside(const char *folder, const char *name, char **path);
/* Of a path, with its slash, "" for the current one; to be freed. */
char *norma_gltf_folder_of(const char *path);

/* ---- changing (patch.c) */

typedef struct gltf_slot {
    uint32_t copy;         /* 0: the mesh itself; else what norma_gltf_copy_mesh gave */
    uint32_t primitive;    /* number in g->primitives */
    int32_t target;        /* GLTF_SLOT_BASE, GLTF_SLOT_INDICES, or the number of a morph target */
    const char *attribute; /* "NORMAL", ...; must outlive the patch (a literal, or a name in
                              g->attributes); NULL with GLTF_SLOT_INDICES */
} gltf_slot;

/* gltf_write.c, before anything is put: forgets a change that changed nothing. */
void norma_gltf_begin_change(gltf *g);
int norma_gltf_drop_change(
    norma_document *document); /* as if it had not been begun; 0: no memory */
/* Whether it is no longer what the file is: by a change that waits, or by those before. */
static inline int norma_gltf_differs(const gltf *g) {
    return g->changed || g->document->given_count > 0;
}
size_t norma_gltf_data_size(const gltf_data *data); /* bytes of one element */
static inline gltf_array norma_gltf_array_of(const gltf_data *data) {
    return (gltf_array){data->bytes, data->count, norma_gltf_data_size(data), data->component,
        data->width, data->normalized};
}
/* Registers contents (bytes become the patch's, also on failure) and gives their number, to be put
 * into one slot or several. GLTF_NONE: out of memory. */
uint32_t norma_gltf_add_data(gltf *g, const gltf_data *data);
/* These contents in this slot. Without a word about a slot it keeps its accessor. Once for each
 * slot. 0: out of memory. */
int norma_gltf_put(gltf *g, const gltf_slot *slot, uint32_t data);
/* Both at once: contents, which the patch then owns in any case, into a slot. */
norma_document_result norma_gltf_put_new(
    gltf *g, const gltf_slot *slot, const gltf_data *data, norma_document_error *error);
/* Whether an accessor's elements are these, bit for bit. */
int norma_gltf_is_same(const gltf_array *old, const gltf_data *data);
void norma_gltf_set_mode(gltf *g, uint32_t copy, uint32_t primitive, uint32_t mode);
json_edits *norma_gltf_edits(
    gltf *g, uint32_t copy); /* 0: of the asset; else those that apply to the copy alone */
/* Normals and tangents of a primitive are removed in the JSON: no new contents for them. 0: out of
 * memory. */
int norma_gltf_strip(gltf *g, uint32_t primitive);
/* gltf_write.c: turns all that was put into edits and views. To be called once, at the end of
 * compute or transform; afterwards g->changed says whether anything is new. */
norma_document_result norma_gltf_finish(gltf *g, norma_document_error *error);

/* ---- writing, and what waits to be written (gltf_write.c) */
int norma_gltf_has_change(const norma_document *document); /* since it was read */
void norma_gltf_adopt(norma_document *document);           /* its state is its own from now on */
norma_document_result norma_gltf_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error);
norma_document_result norma_gltf_reopen(
    norma_document *document, norma_document *made, norma_document_error *error);

/* ---- commands (gltf_compute.c, gltf_tangents.c, gltf_pack.c; edit: vertex_contents.c;
 * gltf_transform.c, turn_green.c) */
norma_document_result norma_gltf_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error);
norma_document_result norma_gltf_tangents(norma_document *document,
    const norma_tangent_options *options, norma_tangent_summary *summary,
    norma_document_error *error);
norma_document_result norma_gltf_pack(norma_document *document, const norma_pack_options *options,
    norma_pack_summary *summary, norma_document_error *error);
norma_document_result norma_gltf_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);
norma_document_result norma_gltf_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);
norma_document_result norma_gltf_turn_green(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);
norma_document_result norma_gltf_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error);
/* vertex_contents.c: bytes of a vertex, those of all targets among them */
size_t norma_gltf_vertex_size(const gltf *g, const gltf_primitive *p);
/* accessors.c: an accessor's elements as new contents: the first kept ones in their places,
 * behind them those that sources names. */
norma_document_result norma_gltf_copy_rows(gltf *g, uint32_t accessor, size_t kept,
    const uint32_t *sources, size_t count, gltf_data *data, norma_document_error *error);
/* vertex_contents.c: of each vertex the first that is the same in all attributes and targets */
norma_document_result norma_gltf_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error);
/* primitives.c */
norma_document_result norma_gltf_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error);
/* How the components of an accessor are stored, in a word; "" for GLTF_NONE. */
const char *norma_gltf_encoding_name(const gltf *g, uint32_t accessor); /* accessors.c */

/* ---- 4x4 matrices as glTF's nodes can say them (nodes.c). Column-major, affine: the last row is
 * taken as 0 0 0 1. */

typedef struct gltf_trs { /* translation after rotation after scale; one scale is negative where the
                             matrix mirrors */
    double translation[3], rotation[4], scale[3]; /* the rotation as a unit quaternion x, y, z, w */
} gltf_trs;

void norma_gltf_matrix_identity(double m[16]);
void norma_gltf_matrix_multiply(
    const double a[16], const double b[16], double ab[16]); /* ab may be a or b */
void norma_gltf_matrix_compose(const gltf_trs *trs, double m[16]);

/* 0 where the upper 3x3 is singular or its inverse is not finite; inverse is then undefined. */
int norma_gltf_matrix_invert(const double m[16], double inverse[16]);

/* The translation, rotation and scale nearest to m. Returns how far m is from being that: the
 * largest |cosine| between two of its columns (0: exactly perpendicular; a column of zeros is
 * perpendicular to all). */
double norma_gltf_matrix_decompose(const double m[16], gltf_trs *trs);

/* Any m, sheared and singular ones included, as the product outer inner: its singular value
 * decomposition, inner a rotation. So two nodes, one below the other, hold what one cannot. */
void norma_gltf_matrix_split(const double m[16], gltf_trs *outer, gltf_trs *inner);

/* ---- what else a glTF's surfaces have (gltf_scene.c, drawn_mesh.c, skins.c; what they and others
 * read of the JSON: members.c) */

/* What several elements share is found out once, so that a small file that names one thing a
 * thousand times costs no more than its size. */
typedef struct gltf_scene {
    const float **decoded;    /* of each accessor; NULL: not yet */
    const float **colors;     /* of each accessor of three numbers, with an alpha of 1 */
    const char *root_ignore;  /* NULL: not yet */
    const char **mesh_ignore; /* of each mesh, that of the root in front */
    const char **node_ignore; /* of each node, those of the nodes above and of the root included */
    struct gltf_animation *animations; /* NULL: not yet */
    uint32_t animation_count;
    const norma_document_error *animation_error; /* NULL: none */
    uint32_t *skins, *materials;                 /* the token of each */
    size_t effort;                               /* steps that skins and animations took */
    size_t measured;                             /* the same, of the errors of normals */
    struct gltf_joints *joints;                  /* of each skin, at rest; NULL: not yet */
    struct gltf_moved **moved; /* of each node that draws, its meshes that morphs or skins move */
    struct gltf_image *images; /* NULL: not yet */
    const uint8_t *shown;      /* of each node: 1 in the scene, 2 not; NULL: not yet */
} gltf_scene;
/* Made on first use; NULL: out of memory. */
gltf_scene *norma_gltf_scene_of(gltf *g);
uint32_t norma_gltf_material(gltf *g, size_t material); /* its token; JSON_NONE: none */

/* Rules that the extras of an object silence, "N201,N3"; "" for none, NULL: out of memory. Of a
 * list beyond all measure the rest is not taken. */
const char *norma_gltf_ignore(gltf *g, uint32_t token);
const char *norma_gltf_root_ignore(gltf *g);
/* above, and behind it what an object's own extras say. */
const char *norma_gltf_ignored_with(gltf *g, const char *above, uint32_t token);
/* The "name" of an object, "" for none; NULL: out of memory. */
const char *norma_gltf_name(gltf *g, uint32_t token);
char *norma_gltf_read_name(const gltf *g, uint32_t token); /* the same, to be freed */
/* "/LIST/NUMBER"; NULL: out of memory. */
const char *norma_gltf_where(gltf *g, const char *list, size_t number);
/* accessors.c: an accessor as floats, width of them for each element, tight: the file's own bytes
 * where they are just that, else a decoded copy that the document keeps. */
norma_document_result norma_gltf_decode(
    gltf *g, uint32_t accessor, uint32_t width, const float **floats, norma_document_error *error);
/* An array as such a copy, made unless *floats is there; a number more than it has is 1. */
norma_document_result norma_gltf_widen(gltf *g, uint32_t accessor, const gltf_array *array,
    uint32_t width, const float **floats, norma_document_error *error);

uint32_t norma_gltf_normal_use(
    const gltf *g, uint32_t material); /* gltf_scene.c: the token of the normal texture's info */
/* Where a texture, by its info, is looked up: everything of it that needs no image. */
norma_texture_info norma_gltf_normal_map(const gltf *g, uint32_t material); /* or clear coat's */
int norma_gltf_moves(const norma_texture_info *place); /* its transform is not the identity */

/* drawn_mesh.c: the nodes that are a skin's joints; to be freed after a failure too. */
norma_document_result norma_gltf_read_joints(
    gltf *g, uint32_t skin, uint32_t **joints, size_t *count, norma_document_error *error);
/* drawn_mesh.c: the inverse bind matrices of a skin, if they are there. */
norma_document_result norma_gltf_read_inverse(gltf *g, uint32_t skin, size_t joints,
    gltf_array *array, int *there, norma_document_error *error);
/* drawn_mesh.c: the joints and weights of a primitive's vertices, as norma_skin_positions takes
 * them, the weights of each divided by their sum. To be freed after a failure too. */
norma_document_result norma_gltf_read_influences(
    gltf *g, uint32_t primitive, norma_skin *skin, norma_document_error *error);
/* drawn_mesh.c: and what they counted for norma_gltf_spend no longer does. */
void norma_gltf_free_influences(gltf *g, uint32_t primitive, norma_skin *skin);
/* skins.c */
size_t norma_gltf_skin_count(const norma_document *document);
norma_document_result norma_gltf_skin(
    norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error);

/* drawn_mesh.c: drawn is filled as the file stores the mesh. */
norma_document_result norma_gltf_move_drawn(norma_document *document, size_t node, size_t mesh,
    norma_drawn_mesh *drawn, norma_document_error *error);

/* gltf_scene.c */
norma_document_result norma_gltf_normal_texture(norma_document *document, size_t material,
    norma_texture_info *map, norma_document_error *error);

/* ---- nodes.c: where a node draws its mesh, again and again (EXT_mesh_gpu_instancing) */
typedef struct gltf_instances {
    gltf_array translation, rotation, scale; /* width 0: not there */
    uint32_t attributes;                     /* the JSON object that names them; JSON_NONE */
} gltf_instances;
norma_document_result norma_gltf_read_instances(
    gltf *g, uint32_t node, gltf_instances *instances, norma_document_error *error);
void norma_gltf_instance_matrix(
    const gltf_instances *instances, size_t index, double matrix[16]); /* within the node */
size_t norma_gltf_tile_instance(const norma_document *document, size_t index, double matrix[16]);

/* members.c: whether a file may require the extension without a word in it changing what its
 * meshes' numbers mean. */
int norma_gltf_is_known(const char *name);
/* accessors.c: its elements have no bytes at all: zeros by the specification, that an extension or
 * the program that loads the file is to fill. What norma check judges they are not. */
int norma_gltf_is_placeholder(const gltf *g, uint32_t accessor);
/* members.c: it asks for a version later than the one that is read here. */
int norma_gltf_needs_later(const gltf *g);

/* gltf_scene.c: the fields of a node's info that are not about what it draws */
norma_document_result norma_gltf_describe_node(
    const norma_document *document, size_t index, norma_node_info *info);

/* ---- Sines of our own, for results with the same bits everywhere: the C library's differ
 * between systems. */

/* sin(x) from 0 to pi/2 by its series, within an ulp or two. */
static inline double norma_gltf_sine(double x) {
    const int steep = x > NORMA_PI / 4;
    const double y = steep ? NORMA_PI / 2 - x : x, z = y * y;
    double sum = 1;
    for (int n = steep ? 16 : 17; n > 1; n -= 2) sum = 1 - sum * z / (n * (n - 1));
    return steep ? sum : y * sum;
}

/* ---- paths (gltf_write.c) */
int norma_gltf_same_folder(
    const gltf *g, const char *path); /* path stands in the folder that the asset was read from */

/* ---- Numbers of an element's kind into an encoding (bake_mesh.c), also for those who do not bake.
 */

typedef enum bake_role {
    BAKE_POSITIONS = 0,
    BAKE_NORMALS,
    BAKE_TANGENTS,
    BAKE_POSITION_DELTAS,
    BAKE_NORMAL_DELTAS,
    BAKE_TANGENT_DELTAS,
    BAKE_WINDING
} bake_role;

/* values in the encoding of the stored array where that can hold them (positions: exactly;
 * directions: as well as it ever does; their deltas: in range), else as floats. Of an array without
 * data, shape and encoding count. */
typedef enum bake_encoded { BAKE_ENCODED = 0, BAKE_NO_MEMORY, BAKE_TOO_LARGE } bake_encoded;
bake_encoded norma_gltf_encode(
    bake_role role, const gltf_array *stored, const double *values, gltf_data *data);

/* Unit vectors as normalised bytes or shorts. 0: it failed. */
int norma_gltf_encode_units(
    int component, norma_vec3_view units, unsigned char *out, size_t stride);

/* ---- What computing normals of glTF shares between its files.
 *
 * A surface is all triangles of one mesh, whatever their primitives: a seam between materials is a
 * seam that people see. It gives normals to points: a position with one of its normals. A set is
 * the primitives that draw the same vertices (the same accessors for every attribute): there each
 * point becomes a vertex, the first of an old vertex under its number, further ones behind all
 * others. */

typedef struct gltf_surface {
    uint32_t mesh;
    norma_mesh core;
    void *positions;      /* owned, where they are not the file's own */
    uint32_t *corners;    /* owned, where there are several primitives */
    size_t *corner_start; /* for each primitive of the mesh: its first corner; SIZE_MAX: it draws no
                             triangles that are read */
    size_t *position_start;
    /* what the core found */
    uint32_t *points;  /* the point of each corner; NULL: its position */
    uint32_t *sources; /* for each point its position */
    float *normals;
    uint8_t *reasons;
    size_t point_count;
} gltf_surface;

typedef struct gltf_set {
    uint32_t lead, last; /* its first and last primitive; in between by the job's next_in_set */
    uint32_t mesh;       /* GLTF_NONE: several meshes draw it */
    int wanted, has_morphs;
    size_t vertices, added_count, added_capacity;
    uint8_t *broken; /* NULL: every vertex gets a new normal; else those that are nonzero do */
    uint8_t *taken;  /* an old vertex's number is given away */
    uint32_t *added; /* old vertex of each added one */
    float *normals;  /* of vertices + added_count */
    uint8_t *reasons;
    uint32_t *point_of; /* with morphs: the surface's point of each vertex, or GLTF_NONE */
    size_t capacity;    /* of normals, reasons, point_of */
    uint32_t *table;    /* vertices by old vertex and what they got (norma_gltf_find_vertex) */
    size_t table_size;
    float **deltas; /* for each target its new normal deltas, or NULL */
    size_t tangents_kept, tangents_turned;
} gltf_set;

typedef struct gltf_job {
    gltf *g;
    const norma_compute_options *options;
    norma_document_error *error;
    compute_policy policy;
    gltf_set *sets;
    uint32_t set_count;
    uint32_t *set_of;      /* for each primitive; GLTF_NONE: not read */
    uint32_t *next_in_set; /* for each primitive the next one of its set, or GLTF_NONE */
    uint32_t **corners;    /* for each primitive its new corners, or NULL */
    double progress_base, progress_scale;
} gltf_job;

static inline norma_document_result norma_gltf_job_memory(const gltf_job *job) {
    return norma_document_fail_memory(job->g->document, job->error);
}

/* Whether a target is to get normals. */
static inline int norma_gltf_morphs_normals(const gltf_job *job, const gltf_attributes *target) {
    return target->normal != GLTF_NONE || (job->options->morphs && target->position != GLTF_NONE);
}

/* The set of a primitive; NULL: it is not read, or its set is not wanted. */
static inline gltf_set *norma_gltf_wanted_set(const gltf_job *job, uint32_t primitive) {
    const uint32_t set = job->set_of[primitive];
    return set == GLTF_NONE || !job->sets[set].wanted ? NULL : &job->sets[set];
}

/* The point of each corner: smooth, each position is one. */
static inline const uint32_t *norma_gltf_points(const gltf_surface *s) {
    return s->points ? s->points : (const uint32_t *)s->core.corners;
}

/* ---- vertex_sharing.c: which primitives share vertices, and the vertices that their points become
 */
norma_document_result norma_gltf_find_vertex_sharing(gltf_job *job);
/* A norma_progress whose user is the job: the core's over one mesh as that over all of them. */
int norma_gltf_pass_on(void *user, double fraction);
norma_document_result norma_gltf_take_points(
    gltf_job *job, gltf_surface *surface); /* points become corners */
norma_document_result norma_gltf_fill_unreferenced(gltf_job *job, gltf_set *set);
norma_document_result norma_gltf_put_indices(gltf_job *job, uint32_t primitive);
void norma_gltf_vertex_sharing_free(gltf_job *job);
/* The place for the number, + 1, of the vertex that copies an old one and has this code, of size
 * bytes; codes has those of all vertices. 0 stands there as long as it is none. NULL: out of
 * memory. */
uint32_t *norma_gltf_find_vertex(
    gltf_set *set, const void *codes, size_t size, uint32_t vertex, const void *code);

/* The old vertex that a vertex of a set is, or is a copy of. */
static inline uint32_t norma_gltf_old_vertex(const gltf_set *set, size_t vertex) {
    return vertex < set->vertices ? (uint32_t)vertex : set->added[vertex - set->vertices];
}

/* ---- vertex_contents.c: what a set's vertices hold, put. A further vertex behind all others, a
 * copy of an old one: its number; SIZE_MAX: out of memory, or of numbers. */
size_t norma_gltf_add_vertex(gltf_set *set, uint32_t vertex);
/* The same contents in a slot of every primitive of the set; the elements of an
 * accessor, with copies for the added vertices. */
norma_document_result norma_gltf_put_in_set(
    gltf_job *job, const gltf_set *set, int32_t target, const char *attribute, gltf_data *data);
norma_document_result norma_gltf_copy_elements(
    gltf_job *job, const gltf_set *set, uint32_t accessor, gltf_data *data);

norma_document_result norma_gltf_put_set(gltf_job *job, uint32_t set);
/* New differences of a target's normals or tangents, three numbers a vertex, in the encoding that
 * they had where that can hold them all; vertices that are not broken keep their bits. */
norma_document_result norma_gltf_put_deltas(
    gltf_job *job, gltf_set *set, uint32_t target, const char *attribute, const float *deltas);
/* gltf_tangents.c: once all sets are put, what became of their tangents: counted, and marked
 * where they are to be computed anew. */
norma_document_result norma_gltf_account_tangents(gltf_job *job);

/* ---- The surfaces of a glTF, mesh by mesh (gltf_compute.c). A mesh of which no triangle can be
 * read is left out. */
norma_document_result norma_gltf_visit_surfaces(
    norma_document *document, visit_surface *visit, void *user, norma_document_error *error);

#endif
