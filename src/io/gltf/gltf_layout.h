/* gltf_layout.h: what is to become of a glTF: its accessors, views and buffers; its nodes; what
 * --bake does with them. */
#ifndef NORMA_IO_GLTF_LAYOUT_H
#define NORMA_IO_GLTF_LAYOUT_H
#include "io/gltf/gltf.h"

/* ---- What is to become of accessors, views and buffers: the patch. In three steps:
 * norma_gltf_finish makes of what was put accessors (patch.c) and views
 * (assign_views.c); norma_gltf_lay_out (gltf_write.c) gives what is to stand at a path its bytes in
 * the buffers, by byte_layout.c, and the JSON that says so: the layout; norma_gltf_write writes
 * that. */

typedef struct patch_slot {
    gltf_slot slot;
    uint32_t data, old, token; /* old: accessor, token: of its number; GLTF_NONE: the slot is new */
    int kept;                  /* the old contents are these already */
} patch_slot;

typedef struct patch_copy {
    uint32_t mesh;
    json_edits *edits;
} patch_copy;

typedef struct patch_unpacked { /* a primitive that Draco held, and that is written without it */
    uint32_t copy, primitive;
} patch_unpacked;

typedef struct patch_image { /* new bytes of an image in a view */
    uint32_t view;           /* GLTF_NONE: a new one, the first of them behind the old views */
    unsigned char *bytes;
    size_t size;
} patch_image;

typedef struct patch_accessor { /* a new one */
    uint32_t data, like;        /* like: the accessor whose type it has, or GLTF_NONE */
    uint32_t view;
} patch_accessor;

/* New contents of one run of elements in a view: an accessor's own, or its sparse values. */
typedef struct data_run {
    uint32_t
        token; /* of the JSON object with bufferView and byteOffset; GLTF_NONE: of new_accessor */
    uint32_t new_accessor;
    uint32_t old_view;                                  /* GLTF_NONE: has none yet */
    size_t old_offset, old_stride, old_size, old_count; /* old_size 0: a stream of Draco's is there,
                                                            and the JSON names no view */
    const unsigned char *bytes; /* count elements of size bytes back to back */
    unsigned char *owned;
    size_t size, count;
    int target;       /* of a new view: 34962, 34963, or 0 */
    int fits, placed; /* fits: over its old bytes, without harm to others */
} data_run;

typedef struct patch_place {    /* bytes of a view in a buffer: as they are read, or compressed */
    uint32_t buffer;            /* GLTF_NONE: none */
    const unsigned char *bytes; /* new ones; NULL: it keeps its old ones */
    size_t length, offset;      /* offset: by the layout */
    int placed;                 /* by the layout, over the old bytes */
} patch_place;

typedef struct patch_view { /* old ones first, then new ones */
    patch_place plain, packed;
    unsigned char *owned;        /* plain.bytes where they are the view's own, else a run's */
    unsigned char *owned_packed; /* packed.bytes */
    gltf_meshopt meshopt;        /* how packed.bytes are compressed */
    size_t stride, element;      /* stride 0: none to be said; element: bytes from row to row */
    int target;                  /* of a new one */
    uint32_t like; /* of a new one: the view that it is compressed like, or GLTF_NONE */
} patch_view;

typedef struct patch_segment { /* part of a buffer as it will be written */
    size_t offset, length;
    const unsigned char *bytes; /* NULL: zeros */
} patch_segment;

typedef struct patch_buffer { /* old ones, and one more where none can be written to */
    int changed;
    int64_t other_names;     /* in the JSON, besides those by views */
    size_t length;           /* of the bytes that are written */
    size_t byte_length;      /* as the JSON says; less where a file holds more than this asset's */
    patch_segment *segments; /* in order, without gaps */
    size_t segment_count, segment_capacity;
    char *name; /* of the file that it goes into; NULL: BIN, data: URI, or nothing */
} patch_buffer;

struct gltf_patch {
    gltf_data *datas;
    uint32_t *same; /* the first data with the same contents */
    patch_slot *slots;
    patch_copy *copies;
    patch_accessor *accessors;
    data_run *runs;
    patch_view *views;
    uint32_t *replaced; /* for each old accessor its new data, or GLTF_NONE */
    uint32_t *released; /* accessors, once for each use given up; from resolving on: those that are
                           free to be taken */
    uint32_t *pins;     /* for each old view: what uses it beside the accessors' own numbers */
    uint32_t *stripped; /* primitives that lose their normals and tangents */
    patch_unpacked *unpacked;
    patch_image *images;
    const char *unlisted[2]; /* extensions that nothing uses any more; NULL: none */
    size_t stripped_count, stripped_capacity, unpacked_count, unpacked_capacity, image_count,
        image_capacity;
    size_t data_count, data_capacity, slot_count, slot_capacity, copy_count, copy_capacity;
    size_t accessor_count, accessor_capacity, run_count, run_capacity, view_count, view_capacity,
        released_count, released_capacity;
    int tight; /* what shrinks leaves no gaps in its view */
    uint32_t
        default_buffer; /* for new views without a better place; may be g->buffer_count: one more */
    patch_buffer *buffers; /* by the layout: g->buffer_count + 1 */
    json_edits *layout;    /* the edits with those of the layout */
    char *laid_out_for; /* the path that buffers and layout are for; "" for a stream; NULL: none yet
                         */
};

/* A copy of a mesh at the end of "meshes": its handle for slots and edits (from 1), its number in
 * the file in *mesh_number. 0: out of memory. */
uint32_t norma_gltf_copy_mesh(gltf *g, uint32_t mesh, uint32_t *mesh_number);
/* One use of an accessor outside the meshes (instancing) is given up: where nobody uses it any
 * more, new contents take its place. 0: out of memory. */
int norma_gltf_release(gltf *g, uint32_t accessor);
/* Nothing uses the extension (a literal) any more: it leaves extensionsUsed and extensionsRequired
 * in the end. 0: out of memory. */
int norma_gltf_unlist(gltf *g, const char *extension);
/* From now on the file uses and requires the extension. */
void norma_gltf_require(gltf *g, const char *extension);
/* For each accessor how often meshes, animations, skins and instances name it; NULL: out of memory.
 */
uint32_t *norma_gltf_accessor_uses(const gltf *g);
gltf_patch *norma_gltf_patch_of(gltf *g); /* made on first use; NULL: out of memory */
void norma_gltf_patch_free(gltf *g);
uint32_t *norma_gltf_view_pins(const gltf *g); /* NULL: out of memory */

/* Pins of views that hold streams, once it is known which of these are kept. */
void norma_gltf_unpin_streams(gltf *g);

/* byte_layout.c: an old view of which runs shrink, without the gaps that they would leave. first:
 * of these runs, next: of each. *done 0: it is left to others. */
norma_document_result norma_gltf_repack_view(gltf *g, uint32_t view, uint32_t first,
    const uint32_t *next, int *done, norma_document_error *error);
/* byte_layout.c: says in the JSON, or of the new accessor, that the run lies there. */
void norma_gltf_point_data_run(gltf *g, const data_run *run, uint32_t view, size_t offset);

/* The steps of norma_gltf_finish: patch.c, assign_views.c, and patch.c for what was unlisted. */
norma_document_result norma_gltf_assign_accessors(gltf *g, norma_document_error *error);
void norma_gltf_edit_extensions(gltf *g);
norma_document_result norma_gltf_assign_views(gltf *g, norma_document_error *error);

typedef enum gltf_destination {
    GLTF_TO_PATH,
    GLTF_IN_PLACE,
    GLTF_TO_STREAM,
    GLTF_TO_MEMORY /* to be read again, and changed further; files only grow at their end */
} gltf_destination;
gltf_destination norma_gltf_destination(const gltf *g, const char *path); /* gltf_write.c */
/* gltf_write.c: fills patch->buffers and patch->layout for what is to stand at path (NULL: a
 * stream); what is there for this path already stays. */
norma_document_result norma_gltf_lay_out(gltf *g, const char *path, norma_document_error *error);
void norma_gltf_free_layout(gltf *g); /* patch.c */

/* ---- byte_layout.c: the bytes of buffers, and what the layout's JSON says of views and buffers */
norma_document_result norma_gltf_fill_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error);
/* watch: NULL, or asked on the way; where it cancels, the rest is missing. */
void norma_gltf_add_base64(
    json_text *text, const patch_segment *segments, size_t count, norma_watch *watch);
void norma_gltf_edit_views(gltf *g);
norma_document_result norma_gltf_edit_buffers(
    gltf *g, gltf_destination destination, norma_document_error *error);
/* Whether another buffer names the same file; -1: out of memory. */
int norma_gltf_is_named_twice(const gltf *g, uint32_t buffer);
gltf_storage norma_gltf_storage_of(
    const gltf *g, uint32_t buffer); /* of old ones and the one more */
int norma_gltf_segments_equal(const patch_buffer *buffer, const unsigned char *bytes, size_t size);

/* ---- patch.c: refuses to add to a list that some index of the file reaches beyond. */
typedef enum gltf_list {
    GLTF_LIST_ACCESSORS,
    GLTF_LIST_VIEWS,
    GLTF_LIST_BUFFERS,
    GLTF_LIST_MESHES,
    GLTF_LIST_NODES,
    GLTF_LIST_TEXTURES,
    GLTF_LIST_IMAGES
} gltf_list;
norma_document_result norma_gltf_check_dangling(
    const gltf *g, gltf_list list, norma_document_error *error);

/* ---- What of a buffer's file belongs to the asset that names it (buffers.c). */

typedef struct range {
    size_t start, end;
} range;

typedef struct ranges {
    range *list;
    size_t count, capacity;
} ranges;

int norma_range_add(ranges *r, size_t start, size_t end); /* 0: out of memory */

/* Adds, in order, the bytes of a buffer's file that no asset of its folder names, neither this one
 * as it stands on the disk nor another, below what they call its end; nothing where that cannot be
 * known. Returns 0 or errno. */
int norma_gltf_find_unnamed(const gltf *g, uint32_t buffer, ranges *left);

/* Refuses a buffer's file that does not look like data of an asset: a Makefile, a picture. */
norma_document_result norma_gltf_check_own_data(
    const gltf *g, uint32_t buffer, const file_bytes *file, norma_document_error *error);

/* The first component of a path below a folder that begins with a dot, "." itself aside. */
int norma_gltf_is_hidden(const char *name);
int norma_gltf_equals_any_case(const char *a, const char *b);
int norma_gltf_has_suffix(const char *name, const char *const *suffixes, size_t count);

/* ---- The JSON of a file that may be an asset, looked into without opening it as a
 * document (buffers.c). */

typedef enum gltf_other {
    GLTF_OTHER_NONE = 0, /* no glTF */
    GLTF_OTHER_READ,     /* *j is the caller's to free, and the file must stay open meanwhile */
    GLTF_OTHER_UNKNOWN,  /* begins like one, and cannot be read */
    GLTF_OTHER_MEMORY    /* out of memory */
} gltf_other;
gltf_other norma_gltf_read_other(const file_bytes *file, json *j);

/* ---- The node hierarchy as it is to become (new_tree.c): nodes get new parents, new nodes come
 * behind the old ones, and at the end the JSON of what changed is edited. Numbers of nodes never
 * shift. */

typedef struct tree_node {
    uint32_t parent, first, last, before, after; /* siblings in order; GLTF_NONE: the last one */
    int children_changed, local_changed, matrix_form;
    double local[16]; /* where local_changed; as TRS unless matrix_form */
    uint32_t mesh;    /* where mesh_changed, or new; GLTF_NONE: none */
    int mesh_changed, instances_removed;
    uint32_t like; /* new nodes: the old one whose name they take (and, where takes_weights, whose
                      morph weights); GLTF_NONE: none */
    int takes_weights, weights_removed;
} tree_node;

typedef struct tree_scene {
    uint32_t token; /* of the scene's object */
    uint32_t *roots;
    size_t count, capacity;
    int changed;
} tree_scene;

typedef struct gltf_tree {
    gltf *g;
    tree_node *nodes;
    size_t count, capacity; /* the first g->node_count are the file's */
    tree_scene *scenes;
    size_t scene_count;
    int failed; /* out of memory; functions below then do nothing */
} gltf_tree;

void norma_gltf_tree_read(gltf *g, gltf_tree *tree); /* failed shows at norma_gltf_tree_write */
void norma_gltf_tree_free(gltf_tree *tree);

uint32_t norma_gltf_tree_add(
    gltf_tree *tree, uint32_t like); /* a new node without parent; GLTF_NONE: out of memory */
void norma_gltf_tree_give(gltf_tree *tree, uint32_t child,
    uint32_t parent); /* moves child, from wherever it is, to the end of parent's children */
void norma_gltf_tree_make_root(gltf_tree *tree, uint32_t node); /* of the scenes that show it */

/* The node's local matrix. Where one node cannot hold it (shear), a second one is put above. */
void norma_gltf_tree_set_local(gltf_tree *tree, uint32_t node, const double local[16]);

/* Puts a node above those of the asset's roots that wanted says (one byte for each old node), one
 * for each set of scenes that the roots share. */
void norma_gltf_tree_raise(gltf_tree *tree, const unsigned char *wanted, const double matrix[16]);

norma_document_result norma_gltf_tree_write(
    gltf_tree *tree, norma_document_error *error); /* into g->edits */

/* ---- --bake: gltf_transform.c decides which nodes are baked and what becomes of the hierarchy,
 * bake_mesh.c transforms a mesh's data and reverses its triangles. */

typedef struct bake_map { /* what transforms one mesh */
    uint32_t id;          /* equal for equal matrices */
    double matrix[16];
    double normal[9];   /* sign(det) cof, times a power of two */
    double fallback[3]; /* unit: what becomes of normals that a singular matrix makes zero */
    int mirrored, rank;
    int turns; /* 0: directions stay as they are (translation, uniform scale) */
} bake_map;

/* Contents that several slots ask for, made once. */
typedef struct bake_entry {
    uint32_t role, a, b, map; /* found by these */
    uint32_t data;
} bake_entry;
typedef struct bake_cache {
    bake_entry *entries;
    uint32_t *slots; /* a hash table of their numbers (core/call/call.h) */
    size_t count, capacity, slot_count;
    double (*matrices)[16]; /* by id */
    size_t matrix_count, matrix_capacity;
} bake_cache;

void norma_gltf_bake_cache_free(bake_cache *cache);
int norma_gltf_bake_map(
    bake_cache *cache, const double matrix[16], bake_map *map); /* 0: out of memory */

/* One use of a mesh: copy is the number that its slots have, node the one that draws it. */
typedef struct mesh_use {
    uint32_t mesh, copy, node;
} mesh_use;
/* The mesh, or its copy, under the map; vertices are added to *vertices. */
norma_document_result norma_gltf_bake_mesh(gltf *g, bake_cache *cache, const mesh_use *use,
    const bake_map *map, size_t *vertices, norma_document_error *error);
#endif
