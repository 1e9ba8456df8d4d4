/* document.h: files that contain normals. They are read, changed and written back, and every byte
 * unrelated to normals is kept.
 *
 * Open a document from a path or from memory, change it with norma_document_compute, _transform or
 * _edit, and save it. Saving writes a temporary file, flushes it and renames it, so at any time
 * either the old file or the new one is complete. A document uses its own copy of the files that it
 * was read from, so other programs may write to them meanwhile; saving in place is then refused.
 *
 * A document takes any number of changes, and may be changed further after it was saved. Mesh data
 * and infos follow the changes; pointers and strings from before a change, even one that failed,
 * are no longer valid. A change that fails leaves the document as it was, with three exceptions:
 * if memory runs out, computing the normals of an STL is cancelled, or a second change of an OBJ is
 * cancelled, it may be possible only to close the document; other calls then return an error with
 * this reason.
 *
 * Different threads may use different documents at the same time; only one thread at a time may use
 * a document. A zero-initialised option struct means the documented defaults. Strings are UTF-8,
 * belong to the document and are valid until it is closed. Options, summaries and errors may be
 * NULL; an error is written only on failure. */
#ifndef NORMA_DOCUMENT_H
#define NORMA_DOCUMENT_H
#include <norma/norma.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum norma_document_result {
    NORMA_DOCUMENT_OK = 0,
    NORMA_DOCUMENT_CANCELLED = 1, /* the progress callback cancelled the call */

    /* The call makes no sense for this document: a usage error, status 2 on the command line. */
    NORMA_DOCUMENT_ERROR_ARGUMENT = -1,
    /* The system could not open, read, write or rename a file. */
    NORMA_DOCUMENT_ERROR_FILE = -2,
    /* The contents violate the file format. */
    NORMA_DOCUMENT_ERROR_MALFORMED = -3,
    /* Valid, but this version cannot read it; the message names the reason. */
    NORMA_DOCUMENT_ERROR_UNSUPPORTED = -4,
    /* A path leads outside the asset's folder, or a file with other contents is in the way. */
    NORMA_DOCUMENT_ERROR_REFUSED = -5,
    NORMA_DOCUMENT_ERROR_MEMORY = -6
} norma_document_result;

typedef struct norma_document_error {
    norma_document_result result;
    /* One line, cut to fit: file, place (line, byte or accessor), what was found and what was
     * expected. */
    char message[1000];
} norma_document_error;

typedef enum norma_file_format {
    NORMA_FILE_UNKNOWN = 0,
    NORMA_FILE_OBJ,
    NORMA_FILE_PLY,
    NORMA_FILE_STL,
    NORMA_FILE_GLTF,
    NORMA_FILE_GLB,  /* .vrm as well */
    NORMA_FILE_B3DM, /* tiles of 3D Tiles 1.0, with a GLB inside: a model, ... */
    NORMA_FILE_I3DM, /* ... a model that is drawn at many places, ... */
    NORMA_FILE_CMPT, /* ... several tiles */
    NORMA_FILE_3MF
} norma_file_format;

/* Whether files of a format hold a glTF. */
NORMA_API int norma_file_format_is_gltf(norma_file_format format);

/* Returns "obj", "ply", "stl", "gltf", "glb", "b3dm", "i3dm", "cmpt" or "3mf"; "" for
 * unknown. */
NORMA_API const char *norma_file_format_name(norma_file_format format);

/* Returns the format that a path's extension stands for, ignoring case; GLB for .vrm. */
NORMA_API norma_file_format norma_file_format_of_path(const char *path);

/* ---- opening and closing */

typedef struct norma_document norma_document;

typedef enum norma_document_depth {
    /* Everything that computing, transforming and writing need. */
    NORMA_DOCUMENT_WHOLE = 0,
    /* Only what norma_document_mesh_info and norma_document_node_info return. The body of the file
     * is read only if a count depends on it. */
    NORMA_DOCUMENT_SUMMARY
} norma_document_depth;

typedef struct norma_document_options {
    /* sizeof(norma_document_options) of the caller; 0: the first version, up to progress_user. */
    size_t struct_size;
    norma_file_format format; /* unknown: by the path's extension */
    norma_document_depth depth;
    uint32_t threads; /* as in norma_options */
    norma_progress *progress;
    void *progress_user;

    /* Nonzero: also read files with faults that norma check reports, instead of refusing them: glTF
     * with fewer or more normals than positions (norma_document_mesh_attributes reports them), and
     * glTF that requires unknown extensions (norma_document_unread reports them). */
    int lenient;

    /* Nonzero: for a summary, too, read files into memory instead of mapping large ones. If another
     * program shortens a mapped file, reading the lost part raises SIGBUS (POSIX), which this
     * library does not catch. */
    int copied;
} norma_document_options;

/* If a file changes while it is read, or before it is saved, the result is a file error and nothing
 * is written. If it is replaced, as this library and most editors do, an open document keeps the
 * old contents, and saving in place is refused. */

/* Opens a file.
 *
 *   path       its path
 *   options    NULL for the defaults
 *   document   written: the document, NULL on failure; release it with norma_document_close
 *   error      written on failure; or NULL
 *
 * Cost: O(file). */
NORMA_API norma_document_result norma_document_open(const char *path,
    const norma_document_options *options, norma_document **document, norma_document_error *error);

/* A composite of 3D Tiles with several models (at most 1,024) is one document: their meshes, nodes
 * and materials follow one another, and a change is made to each. This returns one of the models,
 * in the order of the file, as a document of its own, to be read only. It is closed with the
 * document. Of any other document index 0 gives the document itself. An index behind the last model
 * gives NULL. */
NORMA_API norma_document *norma_document_tile(norma_document *document, size_t index);

/* Opens a file that is in memory.
 *
 *   bytes      the file; not copied, so it must outlive the document
 *   size       bytes
 *   name       stands for the path in messages; its folder is that of external buffers. NULL: no
 *              folder, external buffers are refused
 *   options    NULL for the defaults; give the format if name has no extension
 *   document   written: the document, NULL on failure; release it with norma_document_close
 *   error      written on failure; or NULL */
NORMA_API norma_document_result norma_document_open_memory(const void *bytes, size_t size,
    const char *name, const norma_document_options *options, norma_document **document,
    norma_document_error *error);

/* Closes a document and frees everything it owns. NULL is fine. */
NORMA_API void norma_document_close(norma_document *document);

/* Returns the format that the document was read as. */
NORMA_API norma_file_format norma_document_format(const norma_document *document);

/* Returns the number of notes: things a person should know that are not errors, for example a part
 * that was skipped and why, or what was changed besides normals. */
NORMA_API size_t norma_document_note_count(const norma_document *document);

/* Returns a note, one line of text. */
NORMA_API const char *norma_document_note(const norma_document *document, size_t index);

/* ---- contents */

typedef enum norma_normal_storage {
    NORMA_NORMALS_NONE = 0,
    NORMA_NORMALS_PER_VERTEX,
    NORMA_NORMALS_PER_CORNER,
    NORMA_NORMALS_PER_FACET
} norma_normal_storage;

/* A mesh of a document: a glTF primitive, or a whole OBJ, PLY or STL. */
typedef struct norma_mesh_info {
    const char *name;       /* of the glTF mesh, the first OBJ object, the first STL solid; or "" */
    const char *where;      /* JSON pointer of the primitive; "" for a whole OBJ, PLY or STL */
    size_t mesh, primitive; /* numbers in the file; 0 outside glTF */
    size_t vertices;        /* positions; STL: three for each facet */

    /* Polygons as in the file. glTF: triangles, with strips and fans unrolled. 0 for points and
     * lines. */
    size_t faces;
    size_t triangles; /* the sum of (corners - 2) */
    norma_normal_storage normals;
    const char *encoding; /* "float", "double", "text", "snorm8", "snorm16", ...; "": no normals */
    int has_tangents, has_smoothing_groups;
    size_t morph_targets;

    /* The extension that compresses any of its data, or NULL. */
    const char *compression;

    /* NULL, or why this mesh cannot be computed or transformed: its compression, no positions,
     * points, lines. */
    const char *not_read;
} norma_mesh_info;

/* Returns the number of meshes. */
NORMA_API size_t norma_document_mesh_count(const norma_document *document);

/* Describes a mesh.
 *
 *   index   below norma_document_mesh_count, else an argument error
 *   info    written */
NORMA_API norma_document_result norma_document_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info);

/* A mesh as arrays. */
typedef struct norma_mesh_data {
    norma_mesh mesh; /* positions, corners, face_starts, smoothing_groups */

    /* The stored normals, decoded to float but not renormalised. count 0: none. */
    norma_vec3_view normals;

    /* For each corner the index of its stored normal, UINT32_MAX for none. NULL: the index of the
     * corner's position (per vertex) or face (per facet). */
    const uint32_t *corner_normals;
} norma_mesh_data;

/* Returns a mesh as arrays. They are decoded on first use and belong to the document.
 *
 *   index   below norma_document_mesh_count
 *   data    written
 *   error   written on failure; or NULL
 *
 * Errors: an argument error for a document of depth SUMMARY, or if not_read of its info is set. */
NORMA_API norma_document_result norma_document_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error);

/* A glTF node that draws a mesh. Other formats have none. */
typedef struct norma_node_info {
    const char *name;
    size_t node, mesh; /* numbers in the file */
    double world[16];  /* column-major */
    size_t instances;  /* with EXT_mesh_gpu_instancing their number; otherwise 1 */
    size_t parent;     /* number in the file; SIZE_MAX: a root */
    size_t skin;       /* number in the file; SIZE_MAX: none */

    /* What it draws, as norma_document_mesh_info counts: the primitives of its mesh follow each
     * other. */
    size_t first_mesh, mesh_count;

    /* Instances whose world matrix mirrors. With depth SUMMARY all or none, judged by the node's
     * own matrix. */
    size_t mirrored_instances;
    const char *where; /* "/nodes/4" */

    /* Names from the root on, "a/b/leg", with numbers for unnamed nodes. Very long paths are cut at
     * the front. */
    const char *path;

    /* Rules silenced by extras of the node or of a node above it; as in norma_material_info. */
    const char *ignore;
} norma_node_info;

/* Returns the number of nodes that draw a mesh. */
NORMA_API size_t norma_document_node_count(const norma_document *document);

/* Describes a node that draws a mesh.
 *
 *   index   below norma_document_node_count, else an argument error
 *   info    written */
NORMA_API norma_document_result norma_document_node_info(
    const norma_document *document, size_t index, norma_node_info *info);

/* Returns the world matrix of one instance of a node.
 *
 *   index      of the node, as in norma_document_node_info
 *   instance   below norma_node_info.instances; 0 is the node itself if it has no instances
 *   world      written: sixteen doubles, column-major
 *   error      written on failure; or NULL
 *
 * Errors: an argument error if the node or the instance does not exist. */
NORMA_API norma_document_result norma_document_instance_world(norma_document *document,
    size_t index, size_t instance, double world[16], norma_document_error *error);

/* ---- materials, attributes, morph targets, skins: for checking and drawing
 *
 * Infos and arrays are made on first use, belong to the document, and are valid until it is changed
 * or closed. Data that a format does not have is empty. An index that is out of range is an
 * argument error.
 *
 * A glTF can silence rules of norma check in the extras of its root, a mesh, a primitive, a
 * material or a node: {"norma": {"ignore": ["N201", "N3", "placeholder-normals"]}}. */

typedef struct norma_material_info {
    const char *name;    /* OBJ: the name in usemtl */
    const char *where;   /* "/materials/3"; "" in OBJ */
    float base_color[4]; /* linear, alpha last; all 1 by default */
    int double_sided, unlit;

    /* Nonzero: alphaMode is not OPAQUE, or some light passes through
     * (KHR_materials_transmission, KHR_materials_diffuse_transmission). */
    int not_opaque;
    int normal_map;         /* nonzero: it has a normal texture, possibly of its clear coat */
    size_t normal_texcoord; /* the set of UVs of the normal texture */
    const char *ignore;     /* silenced rules, "N201,N3"; "": none */

    /* glTF: how the normal texture turns and scales its UVs (KHR_texture_transform, offsets left
     * out): u' = t[0] u + t[1] v, v' = t[2] u + t[3] v. All zero: not at all. */
    float normal_turn[4];
} norma_material_info;

/* Returns the number of materials. */
NORMA_API size_t norma_document_material_count(norma_document *document);

/* Describes a material.
 *
 *   index   below norma_document_material_count
 *   info    written */
NORMA_API norma_document_result norma_document_material_info(
    norma_document *document, size_t index, norma_material_info *info);

/* An image on a surface: its file, and how it is looked up. Numbers as in glTF. */
typedef struct norma_texture_info {
    int there;                  /* 0: the material has no such texture */
    const unsigned char *bytes; /* the image's file: PNG or JPEG; NULL: none, or not read */
    size_t size;
    const char *not_read; /* NULL, or why there are no bytes */
    size_t image;         /* number in the file; SIZE_MAX: none. Equal numbers are one image */
    size_t texcoord;      /* the set of texture coordinates */

    /* KHR_texture_transform: coordinates are scaled, turned by rotation (radians, anticlockwise as
     * seen in the image), then moved. */
    float offset[2], scale[2], rotation;
    float strength;             /* of a normal map: its x and y are multiplied by it */
    int wrap_s, wrap_t;         /* 10497: repeat; 33071: clamp; 33648: mirrored */
    int mag_filter, min_filter; /* 9728: nearest, 9729: linear, ...; 0: not given */
    const char *name;           /* of the image: its file, or what the file calls it; NULL: none */
} norma_texture_info;

typedef enum norma_alpha_mode {
    NORMA_ALPHA_OPAQUE = 0,
    NORMA_ALPHA_MASK, /* drawn where alpha is at least alpha_cutoff */
    NORMA_ALPHA_BLEND
} norma_alpha_mode;

/* What drawing needs of a material besides norma_material_info. */
typedef struct norma_material_maps {
    norma_alpha_mode alpha_mode;
    float alpha_cutoff;
    norma_texture_info base_color, normal;
} norma_material_maps;

/* Returns the images of a material. They are read on first use and belong to the document. An image
 * that cannot be read is no error: see norma_texture_info.not_read.
 *
 *   index   below norma_document_material_count
 *   maps    written
 *   error   written on failure; or NULL
 *
 * Formats other than glTF have none. */
NORMA_API norma_document_result norma_document_material_maps(
    norma_document *document, size_t index, norma_material_maps *maps, norma_document_error *error);

/* Returns the normal map alone, that of the clear coat if the material has no other. Its image is
 * read on first use and belongs to the document; other images are not read.
 *
 *   index   below norma_document_material_count
 *   map     written
 *   error   written on failure; or NULL
 *
 * Formats other than glTF have none. */
NORMA_API norma_document_result norma_document_normal_map(
    norma_document *document, size_t index, norma_texture_info *map, norma_document_error *error);

/* Returns one set of texture coordinates of a glTF mesh, two numbers for each vertex.
 *
 *   mesh        below norma_document_mesh_count
 *   set         TEXCOORD_n
 *   texcoords   written: NULL if the mesh has no such set
 *   count       written: vertices
 *   error       written on failure; or NULL */
NORMA_API norma_document_result norma_document_texcoords(norma_document *document, size_t mesh,
    size_t set, const float **texcoords, size_t *count, norma_document_error *error);

/* Applies the transform of a texture (KHR_texture_transform) to texture coordinates.
 *
 *   info        offset, scale and rotation are read
 *   texcoords   two numbers for each vertex
 *   count       vertices
 *   stride      number of floats from one vertex to the next in placed; at least 2
 *   placed      written; texcoords itself if stride is 2 */
NORMA_API void norma_texture_place(const norma_texture_info *info, const float *texcoords,
    size_t count, size_t stride, float *placed);

/* The attributes of a mesh that norma_mesh_data does not contain. */
typedef struct norma_mesh_attributes {
    /* SIZE_MAX: none (glTF: the default material). OBJ with several: that of the first face. */
    size_t material;
    const uint32_t *face_materials; /* OBJ with several: one per face, UINT32_MAX: none; or NULL */

    /* Two numbers each, v as stored: the set that the normal map uses, otherwise set 0. NULL: none.
     */
    const float *texcoords;
    size_t texcoord_count;
    const uint32_t *corner_texcoords; /* OBJ: one per corner, UINT32_MAX: none. NULL: its vertex */
    const float *colors;              /* red, green, blue, alpha per vertex; or NULL */
    const float *tangents;            /* x, y, z, sign per vertex, as stored; or NULL */
    size_t tangent_count;
    const char *tangent_encoding; /* "float", "snorm8", "snorm16"; "": no tangents */

    /* Elements that lack a normal. glTF: vertices. OBJ: faces of which only some corners refer to a
     * normal. */
    size_t normals_missing;
    size_t normals_surplus; /* glTF: normals beyond the number of vertices */

    /* OBJ: faces that refer to vn 0 or to a vn that does not exist. Their corner_normals are
     * UINT32_MAX. */
    size_t normals_out_of_range;

    /* OBJ: for each face 1 if normals_missing counts it, 2 if normals_out_of_range does, else 0.
     * NULL: all are 0. */
    const uint8_t *face_faults;
    const char *ignore; /* rules silenced by extras of the root, the mesh or the primitive */

    float texcoord_turn[4]; /* normal_turn of the material whose normal map uses texcoords */
} norma_mesh_attributes;

/* Returns the attributes of a mesh that norma_mesh_data does not contain.
 *
 *   index        below norma_document_mesh_count
 *   attributes   written
 *   error        written on failure; or NULL
 *
 * Errors: those of norma_document_mesh_data. */
NORMA_API norma_document_result norma_document_mesh_attributes(norma_document *document,
    size_t index, norma_mesh_attributes *attributes, norma_document_error *error);

/* What a morph target adds to each vertex at weight 1, as floats. Positions are in the units of the
 * mesh. count 0: nothing. */
typedef struct norma_morph_data {
    norma_vec3_view positions, normals, tangents;
} norma_morph_data;

/* Returns a morph target.
 *
 *   mesh     below norma_document_mesh_count
 *   target   below norma_mesh_info.morph_targets
 *   data     written
 *   error    written on failure; or NULL */
NORMA_API norma_document_result norma_document_morph_data(norma_document *document, size_t mesh,
    size_t target, norma_morph_data *data, norma_document_error *error);

typedef struct norma_skin_info {
    const char *name, *where; /* where: "/skins/0" */
    size_t joint_count;

    /* The largest anisotropy (largest over smallest singular value) of a joint's world matrix: at
     * rest, or at any key of an animation that scales it or a node above it. INFINITY if one is
     * singular. */
    double anisotropy;
    size_t joint;       /* the joint's node with this anisotropy; SIZE_MAX: no joints */
    const char *ignore; /* rules silenced by extras of the root */

    /* The largest angle between a normal through a vertex's blended matrix itself and the same
     * normal through its normal matrix, at rest or at a key of an animation; and where that is. NaN
     * if the anisotropy is at most 1.05, or if there is nothing to measure. */
    double normal_error_rad;
    size_t error_mesh, error_vertex; /* mesh: as in norma_document_mesh_info */
    size_t error_animation;          /* SIZE_MAX: at rest */
    double error_time_s;

    /* Not all keys of a skin with very many keys and vertices are examined. */
    size_t keys, examined_keys;
} norma_skin_info;

/* Returns the number of skins. */
NORMA_API size_t norma_document_skin_count(norma_document *document);

/* Describes a skin.
 *
 *   index   below norma_document_skin_count
 *   info    written
 *   error   written on failure; or NULL */
NORMA_API norma_document_result norma_document_skin_info(
    norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error);

/* A mesh as viewers draw it at rest, at one place: the weights of its morph targets (the node's,
 * otherwise the mesh's) and its skin applied. */
typedef struct norma_drawn_mesh {
    double world[16]; /* from these positions to the scene; column-major */
    int shown;        /* 0: the node is not in the scene that the file asks viewers to show */
    int moved;        /* nonzero: morph targets or a skin moved the vertices */
    int skinned;      /* nonzero: a skin moved them; all instances are then at the same place */

    /* Skinned: three floats for each vertex; moved by targets alone: three doubles. Otherwise those
     * of norma_mesh_data, whose integers world scales if they are normalised. */
    norma_vec3_view positions;
    norma_vec3_view normals; /* as many as in norma_mesh_data; of any length. count 0: none */
    const float *tangents;   /* x, y, z, sign for each; NULL: none */
} norma_drawn_mesh;

/* Returns a mesh as it is drawn. Corners and all other data are those of norma_mesh_data.
 *
 *   node       as in norma_document_node_info
 *   instance   below norma_node_info.instances
 *   mesh       below norma_document_mesh_count; a mesh that the node draws
 *   drawn      written
 *   error      written on failure; or NULL
 *
 * Skins are applied by norma_skin_positions, norma_skin_normals and norma_skin_tangents, with the
 * weights of each vertex divided by their sum.
 * Errors: those of norma_document_mesh_data and norma_document_instance_world.
 * Cost: O(vertices) at the first instance of a node. */
NORMA_API norma_document_result norma_document_drawn_mesh(norma_document *document, size_t node,
    size_t instance, size_t mesh, norma_drawn_mesh *drawn, norma_document_error *error);

/* A part of the file that was not read. */
typedef struct norma_unread {
    const char *where, *why; /* JSON pointer; one line of text */
} norma_unread;

/* Returns the number of parts that were not read. */
NORMA_API size_t norma_document_unread_count(norma_document *document);

/* Describes a part that was not read.
 *
 *   index    below norma_document_unread_count
 *   unread   written */
NORMA_API norma_document_result norma_document_unread(
    norma_document *document, size_t index, norma_unread *unread);

/* Receives the path of a file. Return nonzero to stop. */
typedef int norma_visit_file(void *user, const char *path);

/* Visits each further file that the document was read from or refers to: buffers and images of a
 * glTF, material libraries of an OBJ, texture files of a PLY. Nothing is opened.
 *
 *   visit   called once for each file. Paths are relative to the working folder, or absolute; a
 *           file may occur twice, and may be missing
 *   user    passed to visit
 *   error   written on failure; or NULL
 *
 * A document that was read from memory without a name has no such files. Errors: out of memory
 * only. */
NORMA_API norma_document_result norma_document_visit_files(
    norma_document *document, norma_visit_file *visit, void *user, norma_document_error *error);

/* Whether a path ends as a tileset does (.json). */
NORMA_API int norma_is_tileset(const char *path);

/* Visits the tiles of a tileset of 3D Tiles: the files of a known format that it names, and those
 * of the tilesets that it names. The tiles themselves are not opened.
 *
 *   path    of the tileset.json
 *   visit   called for each tile, in the order of its tileset; a file may occur twice, and may be
 *           missing
 *   user    passed to visit
 *   error   written on failure; or NULL
 *
 * Errors: refused for a tile outside its tileset's folder; unsupported for implicit tiling, which
 * lists no tiles. */
NORMA_API norma_document_result norma_tileset_visit_tiles(
    const char *path, norma_visit_file *visit, void *user, norma_document_error *error);

/* Whether a tile below the tileset's root, or a tileset that it names, has a transform: then equal
 * positions in two tiles need not lie at one place. 0 also where the tileset cannot be read. */
NORMA_API int norma_tileset_moves_tiles(const char *path);

/* ---- computing normals */

typedef enum norma_shading {
    /* Creases at 60 degrees. PLY: smooth. STL: flat. OBJ with smoothing groups: by groups alone. */
    NORMA_SHADING_DEFAULT = 0,
    NORMA_SHADING_CREASE,
    NORMA_SHADING_SMOOTH,
    NORMA_SHADING_FLAT
} norma_shading;

/* Which normals are computed. */
typedef enum norma_only { NORMA_ONLY_ALL = 0, NORMA_ONLY_MISSING, NORMA_ONLY_BROKEN } norma_only;

/* Whether smoothing groups of OBJ are respected. */
typedef enum norma_groups { NORMA_GROUPS_AUTO = 0, NORMA_GROUPS_IGNORE } norma_groups;

/* What happens to the tangents that a glTF stores when its normals are computed. */
typedef enum norma_stored_tangents {
    /* If its normal did not change, a tangent keeps its bits, unless it is further from
     * perpendicular than its encoding explains. All others are made perpendicular to their new
     * normals. */
    NORMA_STORED_TANGENTS_ORTHOGONALISE = 0,
    NORMA_STORED_TANGENTS_KEEP, /* all keep their bits */

    /* They are computed again, as norma_document_tangents does with NORMA_TANGENTS_MIKK, in each
     * primitive whose normals are computed; without texture coordinates they are made
     * perpendicular. If this fails, the document can only be closed. */
    NORMA_STORED_TANGENTS_REGENERATE
} norma_stored_tangents;

typedef struct norma_compute_options {
    size_t struct_size;
    norma_shading shading;
    double crease_angle_rad; /* with NORMA_SHADING_CREASE */
    norma_weight weight;
    norma_weld weld;
    double weld_distance;
    norma_non_manifold non_manifold;
    norma_groups groups;
    norma_only only;
    int morphs; /* nonzero: morph targets without normal deltas get them too */
    uint32_t threads;
    norma_progress *progress;
    void *progress_user;
    norma_stored_tangents tangents;
    const uint8_t *meshes; /* nonzero for each mesh that gets normals; NULL: all do. glTF only; a
                            * mesh that shares vertices with one that gets none gets none either */
} norma_compute_options;

typedef struct norma_compute_summary {
    int changed; /* 0: the document would be written byte for byte as it was read */
    size_t faces, vertices_before, vertices_after;
    norma_shading shading;   /* what was done: crease, smooth or flat */
    double crease_angle_rad; /* with crease: the angle applied; pi if groups alone decide */
    int by_groups;           /* nonzero: smoothing groups took part */
    int edges_counted;       /* nonzero: hard_edges and the edges of the report were counted */
    size_t hard_edges;       /* between two faces */
    size_t filled;           /* elements without a normal of their own that got the nearest one */
    norma_report report;     /* of all meshes; first is SIZE_MAX if several were summed */

    /* Stored tangents, one for each vertex, of the primitives whose normals were computed. */
    size_t tangents_kept, tangents_orthogonalised, tangents_regenerated;
} norma_compute_summary;

/* Computes normals into the document.
 *
 *   options   NULL for the defaults
 *   summary   written; or NULL
 *   error     written on failure; or NULL
 *
 * Errors: an argument error for normals that the format cannot hold (smooth shading in STL). */
NORMA_API norma_document_result norma_document_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error);

/* ---- tangents */

typedef struct norma_tangent_options {
    size_t struct_size;
    norma_tangent_mode mode;
    norma_weight weight; /* in steady mode */

    /* The set of texture coordinates, TEXCOORD_n. Without texcoord_given it is that of the
     * material's normal map, with its KHR_texture_transform; 0 without a normal map. */
    int texcoord_given;
    uint32_t texcoord;
    norma_only only; /* missing: of primitives without tangents; broken: also tangents that are not
                      * finite, not of unit length, or whose sign is neither 1 nor -1 */
    uint32_t threads;
    norma_progress *progress;
    void *progress_user;
    const uint8_t *meshes; /* nonzero for each mesh that gets tangents; NULL: all do */
    int meshopt; /* nonzero: instead of mode, the tangents of meshoptimizer 1.3 with its default
                  * weights (meshopt_generateTangents), bit for bit. Where it has none, there is a
                  * vector perpendicular to the normal */
} norma_tangent_options;

typedef struct norma_tangent_summary {
    int changed;       /* 0: the document would be written byte for byte as it was read */
    size_t primitives; /* that got tangents */
    size_t left_out;   /* primitives without normals, or without that set of coordinates */
    size_t vertices_before, vertices_after; /* of all primitives */

    /* Corners without a tangent of their own, by reason; they got a unit vector perpendicular to
     * their normal. */
    size_t degenerate, non_finite, cancelled;
} norma_tangent_summary;

/* Computes tangents into a glTF: of all its triangles that have normals and texture coordinates, as
 * norma_corner_tangents does, with the sign negated, because v runs downwards in glTF. A vertex is
 * split where its corners have different tangents. Morph targets with normals get the differences
 * of the tangents.
 *
 *   options   NULL for the defaults
 *   summary   written; or NULL
 *   error     written on failure; or NULL
 *
 * Tangents, also in morph targets, keep their encoding if it holds them; new ones are floats.
 * Errors: an argument error for formats that
 * hold no tangents. */
NORMA_API norma_document_result norma_document_tangents(norma_document *document,
    const norma_tangent_options *options, norma_tangent_summary *summary,
    norma_document_error *error);

/* ---- packing */

typedef struct norma_pack_options {
    size_t struct_size;
    double max_error_rad; /* how far a direction may turn; 0: not at all */
    norma_progress *progress;
    void *progress_user;
} norma_pack_options;

/* Accessors of normals, or of tangents, those of morph targets among them. */
typedef struct norma_pack_part {
    size_t accessors, packed;         /* packed: those that got a smaller encoding */
    size_t bytes_before, bytes_after; /* of all, with the padding of their elements */
    double max_error_rad;             /* the largest angle by which a direction turned */
} norma_pack_part;

typedef struct norma_pack_summary {
    int changed; /* 0: the document would be written byte for byte as it was read */
    norma_pack_part normals, tangents;
    size_t made_unit; /* normals and tangents whose length was not 1, and now is */
} norma_pack_summary;

/* Gives the normals and tangents of a glTF the smallest encodings of KHR_mesh_quantization (signed
 * bytes or 16-bit integers, normalised) that keep their directions within an angle. The directions
 * of a morph target are those that it gives alone at full weight.
 *
 *   options   NULL for the defaults
 *   summary   written; or NULL
 *   error     written on failure; or NULL
 *
 * Accessors keep their encoding if no smaller one is near enough, if something else uses them as
 * well, or if Draco compressed them. Zeros stay zeros.
 * Errors: an argument error for formats other than glTF and for angles outside 0 to pi. */
NORMA_API norma_document_result norma_document_pack(norma_document *document,
    const norma_pack_options *options, norma_pack_summary *summary, norma_document_error *error);

/* ---- transforming */

typedef struct norma_transform_options {
    size_t struct_size;
    double matrix[16]; /* applied to points; column-major; all zero: identity */
    int bake;          /* nonzero: glTF node transforms are applied to the meshes as well */
    uint32_t threads;
    norma_progress *progress;
    void *progress_user;
} norma_transform_options;

typedef struct norma_transform_summary {
    int changed;
    size_t vertices, meshes, nodes_baked;

    /* Nonzero: the matrix, or a node that was baked, mirrors. The winding was reversed there. In a
     * glTF that is not baked, renderers reverse it. */
    int mirrored;
} norma_transform_summary;

/* Transforms positions, normals and tangents, and reverses the winding under a mirror.
 *
 *   options   NULL for the defaults
 *   summary   written; or NULL
 *   error     written on failure; or NULL
 *
 * Errors: an argument error if the matrix is not finite or its last row is not 0 0 0 1;
 * NORMA_DOCUMENT_ERROR_UNSUPPORTED, with the vertex, facet or node, for a number that becomes
 * larger than the file can hold: floats in glTF and STL, doubles in OBJ, whose numbers have no
 * type, and in PLY, whose properties then become doubles. */
NORMA_API norma_document_result norma_document_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error);

/* Moves meshes that lie far from their origin close to it, to leave more digits of floats for their
 * shape. A mesh is moved along each axis on which it is more than eight times its size away, by a
 * step for which all differences are exact.
 *
 *   meshes    a byte for each mesh of the document, nonzero to move it (a glTF mesh moves if one of
 *             its primitives is marked); NULL: all
 *   changed   written: whether any mesh moved; or NULL
 *   error     written on failure; or NULL
 *
 * glTF: each node that drew the mesh gets a child that draws it instead, moved back, so nothing
 * moves in the scene. Meshes with a skin, with instancing, with animated weights, without a node,
 * or with positions that are not floats stay as they are, and a note reports them. OBJ, PLY and STL
 * cannot compensate: the mesh really moves.
 * Errors: those of norma_document_transform. Cost: O(file). */
NORMA_API norma_document_result norma_document_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);

/* ---- editing: single faces, normals, positions and tangents, as norma check --fix does */

enum { NORMA_STRIP_NOTHING = 0, NORMA_STRIP_ALL, NORMA_STRIP_MORPHS };

/* Changes to one mesh. Each pointer may be NULL; the data that it would change then stays as it is.
 * All other data keeps its bytes as long as its encoding stays. Marks are bytes, nonzero to select
 * an element. */
typedef struct norma_mesh_edit {
    /* A mark for each face: its winding is reversed; the first corner stays the first. */
    const uint8_t *reverse_faces;

    /* A mark for each face: it is removed. A glTF primitive keeps one, because it would not be
     * valid without any. */
    const uint8_t *drop_faces;

    /* OBJ, PLY: a mark for each face: it is cut into triangles, which keep the UVs and normals of
     * its corners. cut_corners has three corner numbers (from 0, within the face) for each
     * triangle. A face whose first corner is corner c of the mesh has its numbers from 3 c on, for
     * two triangles fewer than it has corners. Cannot be combined with reverse_faces. */
    const uint8_t *cut_faces;
    const uint32_t *cut_corners;

    /* A unit vector of three numbers for each stored normal: of a vertex (glTF, PLY), a vn (OBJ) or
     * a facet (STL). set_normals marks those that replace the stored ones. */
    const float *normals;
    const uint8_t *set_normals;

    /* Three numbers for each position (STL: three positions per facet), and marks. */
    const double *positions;
    const uint8_t *set_positions;

    /* glTF: x, y, z, sign for each vertex, and marks. For a primitive without tangents the marks
     * are ignored and all are written. */
    const float *tangents;
    const uint8_t *set_tangents;

    /* glTF: NORMA_STRIP_ALL removes the normals, and the tangents with them, of the mesh and its
     * morph targets; NORMA_STRIP_MORPHS removes only those of the targets, if the mesh itself has
     * none. The accessors stay, so that their numbers do not change. */
    int strip_normals;

    /* glTF, PLY, OBJ: for each new vertex the number of the old vertex that it copies, with all
     * attributes and morph targets; in OBJ the v line. The marks and numbers above then refer to
     * new vertices; in OBJ they cannot be combined with this. */
    const uint32_t *source_vertices;
    size_t vertex_count; /* of source_vertices, at least 1 */

    /* With source_vertices: the new vertex of each corner, in the order of norma_mesh_data, before
     * reverse_faces. */
    const uint32_t *new_corners;
} norma_mesh_edit;

/* Applies edits to a document.
 *
 *   edits   one for each mesh of the document, in its order
 *   error   written on failure; or NULL
 *
 * Errors: an argument error for edits of data that the format does not have. Cost: O(file). */
NORMA_API norma_document_result norma_document_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);

/* Finds duplicate vertices in a glTF, PLY or OBJ: for each vertex of a mesh the first one that
 * equals it bit for bit in everything the file stores for it.
 *
 *   mesh    below norma_document_mesh_count
 *   first   written: norma_mesh_info.vertices numbers; each vertex gets its own number if something
 *           in the file may refer to vertices by their numbers
 *   error   written on failure; or NULL
 *
 * glTF compares attributes and morph targets, PLY the whole row (in a text file its words), OBJ the
 * words of the v line.
 * Errors: an argument error for other formats; unsupported if so many of a glTF's vertices share
 * bytes that they would need far more memory than the file.
 * Cost: O(vertices), expected. */
NORMA_API norma_document_result norma_document_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error);

/* ---- writing */

typedef struct norma_save_options {
    size_t struct_size;
    int in_place; /* nonzero: path may be the source; a .gltf keeps the names of its buffers */
    norma_progress *progress; /* if it cancels, nothing of the new file remains */
    void *progress_user;
    uint64_t *size; /* written: bytes of the saved file and the files beside it that it names; or
                       NULL */
} norma_save_options;

/* Writes the document to a path, completely or not at all; a .gltf with its buffers beside it.
 *
 *   path      refused if it is the source or one of its buffers, unless in_place is set
 *   options   NULL for the defaults
 *   error     written on failure; or NULL
 *
 * Saving needs memory of its own. If there is too little (NORMA_DOCUMENT_ERROR_MEMORY), the
 * document and the files are as they were, and the call can be repeated.
 *
 * In place, a file that another program has changed, or is replacing at the same time, is refused.
 * Whenever the process or the machine stops, path is the old file or the new one. Buffers are on
 * disk before the .gltf that needs them. In place they only grow, so the old .gltf, and others that
 * share them, still read the same bytes. Temporary files are named .norma-PROCESS-NUMBER.tmp; on
 * Linux they have no name until they are complete. */
NORMA_API norma_document_result norma_document_save(norma_document *document, const char *path,
    const norma_save_options *options, norma_document_error *error);

/* Receives the next bytes of a file. Return nonzero to stop with a file error. */
typedef int norma_write(void *user, const void *bytes, size_t size);

/* Passes the whole file to a function, in order; a .gltf with its buffers as data URIs.
 *
 *   write   called with consecutive bytes
 *   user    passed to write
 *   error   written on failure; or NULL */
NORMA_API norma_document_result norma_document_write(
    norma_document *document, norma_write *write, void *user, norma_document_error *error);

/* Writes any bytes to a path as norma_document_save does, completely or not at all: a report, a
 * picture. A device or a pipe is written directly.
 *
 *   path    replaced if it exists
 *   bytes   the contents
 *   size    bytes
 *   error   written on failure; or NULL */
NORMA_API norma_document_result norma_save_bytes(
    const char *path, const void *bytes, size_t size, norma_document_error *error);

/* A file on its way to a path, piece by piece. One thread at a time may use it. */
typedef struct norma_saving norma_saving;

/* Begins to write a file as norma_save_bytes does, for contents that are larger than memory or made
 * bit by bit. Until norma_save_end the path stays as it is.
 *
 *   path     replaced at the end if it exists
 *   saving   written: to be passed to norma_save_end or norma_save_abandon; NULL on failure
 *   error    written on failure; or NULL */
NORMA_API norma_document_result norma_save_begin(
    const char *path, norma_saving **saving, norma_document_error *error);

/* Appends bytes. After a failure, such as a full disk, every later call fails in the same way.
 *
 *   saving   of norma_save_begin
 *   bytes    copied or written before the call returns
 *   size     bytes
 *   error    written on failure; or NULL */
NORMA_API norma_document_result norma_save_piece(
    norma_saving *saving, const void *bytes, size_t size, norma_document_error *error);

/* The temporary file that would stay if the process ended now, for a signal handler to unlink; NULL
 * where it has no name (on most file systems of Linux), or for a device or a pipe. Valid until
 * norma_save_end or norma_save_abandon. */
NORMA_API const char *norma_save_temporary(const norma_saving *saving);

/* Flushes the file and puts it in place; on failure the path stays as it was. Frees saving in any
 * case.
 *
 *   saving   of norma_save_begin
 *   error    written on failure; or NULL */
NORMA_API norma_document_result norma_save_end(norma_saving *saving, norma_document_error *error);

/* Flushes several files and puts all of them in place, or none. Frees all in any case, except if
 * one is NULL. If one cannot be put in place, files that were replaced before it come back only on
 * file systems that have links, and not on Windows; elsewhere their new contents stay.
 *
 *   savings   of norma_save_begin, for different paths
 *   count     of them
 *   error     written on failure; or NULL */
NORMA_API norma_document_result norma_save_end_together(
    norma_saving **savings, size_t count, norma_document_error *error);

/* Frees saving and leaves the path as it was. NULL is fine. */
NORMA_API void norma_save_abandon(norma_saving *saving);

#ifdef __cplusplus
}
#endif
#endif
