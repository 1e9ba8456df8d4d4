/* document.h: files that hold normals. Read, patched and written back, with every byte that is not
 * about normals kept.
 *
 * A document is opened from a path or from memory, changed by norma_document_compute, _transform or
 * _edit, and saved: to a temporary file that is flushed and renamed, so that the old file or the
 * new one is whole at any time. The source file is mapped, not copied; it must not change while its
 * document is open. A glTF document takes one change; a second, on top of the first, is an argument
 * error: save and open it again. Its mesh data and infos stay those of the file as it was read; in
 * the other formats they follow the changes. Distinct documents may be used by distinct threads at
 * once; one document by one thread at a time.
 *
 * Zero-initialised option structs mean the documented defaults. Strings are UTF-8, owned by the
 * document, valid until it is closed. */
#ifndef NORMA_DOCUMENT_H
#define NORMA_DOCUMENT_H
#include <norma/norma.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef enum norma_document_result {
    NORMA_DOCUMENT_OK = 0,
    NORMA_DOCUMENT_CANCELLED = 1,        /* by the progress callback */
    NORMA_DOCUMENT_ERROR_ARGUMENT = -1,  /* a call that makes no sense for this document: a usage
                                            error, status 2 on the command line */
    NORMA_DOCUMENT_ERROR_FILE = -2,      /* the system could not open, read, write or rename */
    NORMA_DOCUMENT_ERROR_MALFORMED = -3, /* the bytes are not what their format demands */
    NORMA_DOCUMENT_ERROR_UNSUPPORTED =
        -4, /* legal, but beyond what this version reads; the message names it */
    NORMA_DOCUMENT_ERROR_REFUSED =
        -5, /* a path outside the asset's folder, a file of other content in the way */
    NORMA_DOCUMENT_ERROR_MEMORY = -6
} norma_document_result;

typedef struct norma_document_error {
    norma_document_result result;
    char message[1000]; /* one line: file, place (line, byte, accessor), what was found and what was
                           expected; cut to fit */
} norma_document_error;

typedef enum norma_file_format {
    NORMA_FILE_UNKNOWN = 0,
    NORMA_FILE_OBJ,
    NORMA_FILE_PLY,
    NORMA_FILE_STL,
    NORMA_FILE_GLTF,
    NORMA_FILE_GLB
} norma_file_format;
NORMA_API const char *norma_file_format_name(
    norma_file_format format); /* "obj", "ply", "stl", "gltf", "glb"; "" for unknown */
NORMA_API norma_file_format norma_file_format_of_path(
    const char *path); /* by its extension, case aside */

typedef struct norma_document norma_document;

typedef enum norma_document_depth {
    NORMA_DOCUMENT_WHOLE = 0, /* all that computing, transforming and writing need */
    NORMA_DOCUMENT_SUMMARY    /* only what norma_document_mesh_info and _node tell: the body is read
                                 where a count hangs on it */
} norma_document_depth;

typedef struct norma_document_options {
    size_t
        struct_size; /* sizeof of the caller's header; 0: its first version, up to progress_user */
    norma_file_format format; /* unknown: by the path's extension */
    norma_document_depth depth;
    uint32_t threads; /* as in norma_options */
    norma_progress *progress;
    void *progress_user;
    int lenient; /* nonzero: what norma check judges is read instead of refused: glTF normals fewer
                    or more than positions (told of by norma_document_mesh_attributes), extensions
                    that a file requires and that are not known (by norma_document_unread) */
    int copied;  /* nonzero: files are read into memory. Else large ones are mapped: of a file that
                    another program shortens while the document is  open, reading what was lost
                    raises  SIGBUS (POSIX), which this library does not catch */
} norma_document_options;

/* A file that changes while it is read, or between then and saving, is a file error, and nothing is
 * written. One that is replaced, as this library and most editors do it, goes on being what it was
 * to those who have it open; in place it is then not replaced. */

/* error may be NULL. On failure *document is NULL. */
NORMA_API norma_document_result norma_document_open(const char *path,
    const norma_document_options *options, norma_document **document, norma_document_error *error);
/* bytes stay the caller's and must outlive the document; name stands for the path in messages and
 * decides the folder of external buffers (NULL: no folder, so that external buffers are refused).
 */
NORMA_API norma_document_result norma_document_open_memory(const void *bytes, size_t size,
    const char *name, const norma_document_options *options, norma_document **document,
    norma_document_error *error);
NORMA_API void norma_document_close(norma_document *document); /* NULL is fine */
NORMA_API norma_file_format norma_document_format(const norma_document *document);

/* Notes: what a person should know that is not an error (a part that was passed over and why, what
 * was changed beside normals). One line each. */
NORMA_API size_t norma_document_note_count(const norma_document *document);
NORMA_API const char *norma_document_note(const norma_document *document, size_t index);

/* ---- what is in it */

typedef enum norma_normal_storage {
    NORMA_NORMALS_NONE = 0,
    NORMA_NORMALS_PER_VERTEX,
    NORMA_NORMALS_PER_CORNER,
    NORMA_NORMALS_PER_FACET
} norma_normal_storage;

typedef struct norma_mesh_info { /* one for each glTF primitive; one for a whole OBJ, PLY or STL */
    const char *name; /* of the glTF mesh, the first OBJ object, the first STL solid; "" where there
                         is none */
    const char *where;      /* JSON pointer of the primitive; "" for a whole OBJ, PLY or STL */
    size_t mesh, primitive; /* numbers in the file; 0 outside glTF */
    size_t vertices;        /* positions; STL: three for each facet */
    size_t faces; /* polygons as the file has them; glTF: triangles, strips and fans unrolled; 0 for
                     points and lines */
    size_t triangles; /* sum of corners - 2 */
    norma_normal_storage normals;
    const char *encoding; /* of the normals: "float", "double", "text", "snorm8", "snorm16", ...; ""
                             where there are none */
    int has_tangents, has_smoothing_groups;
    size_t morph_targets;
    const char *not_read; /* NULL, or why this mesh cannot be computed or transformed (its
                             compression, no positions, points, lines) */
} norma_mesh_info;

NORMA_API size_t norma_document_mesh_count(const norma_document *document);
NORMA_API norma_document_result norma_document_mesh_info(
    const norma_document *document, size_t index, norma_mesh_info *info);

/* The mesh as arrays, decoded on first use and owned by the document. Argument error for a document
 * of depth SUMMARY, and where info.not_read is set. */
typedef struct norma_mesh_data {
    norma_mesh mesh; /* positions, corners, face_starts, smoothing_groups */
    norma_vec3_view
        normals; /* stored normals, decoded to float, as stored (not renormalised); count 0: none */
    const uint32_t
        *corner_normals; /* for each corner the number of its stored normal, UINT32_MAX: none; NULL:
                            the corner's position (per vertex) or face (per facet) */
} norma_mesh_data;
NORMA_API norma_document_result norma_document_mesh_data(
    norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error);

typedef struct norma_node_info { /* glTF nodes that draw a mesh; none in other formats */
    const char *name;
    size_t node, mesh;         /* numbers in the file */
    double world[16];          /* column-major */
    size_t instances;          /* EXT_mesh_gpu_instancing: how many; else 1 */
    size_t parent;             /* number in the file; SIZE_MAX: a root */
    size_t skin;               /* number in the file; SIZE_MAX: none */
    size_t mirrored_instances; /* of the instances: those whose world matrix mirrors; of a SUMMARY
                                  all or none, by the node's own matrix */
    const char *where;         /* "/nodes/4" */
    const char *path;   /* names from the root, "a/b/leg"; a node without one: its number; cut in
                           front where it is very long */
    const char *ignore; /* as of norma_material_info: rules that extras of the node, or of a node
                           above it, silence */
} norma_node_info;
NORMA_API size_t norma_document_node_count(const norma_document *document);
NORMA_API norma_document_result norma_document_node_info(
    const norma_document *document, size_t index, norma_node_info *info);

/* World matrix of one instance (0 of a node without instancing: its own), column-major. Argument
 * error for a node or an instance that is not there; index is that of norma_document_node_info. */
NORMA_API norma_document_result norma_document_instance_world(norma_document *document,
    size_t index, size_t instance, double world[16], norma_document_error *error);

/* ---- what else belongs to a surface: for whoever judges it or draws it
 *
 * Infos and arrays are made on first use, owned by the document, and valid until it is changed or
 * closed. What a format does not have is empty. Rules that a file silences are named in extras:
 * {"norma": {"ignore": ["N201", "N3", "placeholder-normals"]}}, of the document's root, a mesh, a
 * primitive, a material, a node. */

typedef struct norma_material_info {
    const char *name, *where; /* where: "/materials/3"; "" in OBJ, whose name is what usemtl says */
    float base_color[4];      /* linear, alpha last; ones where it is not told */
    float metallic, roughness;
    int double_sided, unlit;
    int not_opaque;         /* alphaMode other than OPAQUE, or some light passes through
                               (KHR_materials_transmission, _diffuse_transmission) */
    int normal_map;         /* a normal texture, or a normal texture of its clear coat */
    size_t normal_texcoord; /* the set of UVs that it uses */
    const char *ignore;     /* "N201,N3"; "" for none */
} norma_material_info;
NORMA_API size_t norma_document_material_count(norma_document *document);
NORMA_API norma_document_result norma_document_material_info(
    norma_document *document, size_t index, norma_material_info *info);

typedef struct norma_mesh_attributes { /* what a mesh has beside norma_mesh_data */
    size_t material; /* SIZE_MAX: none (glTF: the default material); OBJ with face_materials: of the
                        first face */
    const uint32_t *face_materials; /* OBJ with several: of each face, UINT32_MAX none; else NULL */
    const float *texcoords; /* two numbers each, v as stored: of the set that the normal map uses,
                               else of set 0; NULL: none */
    size_t texcoord_count;
    const uint32_t
        *corner_texcoords; /* OBJ: of each corner, UINT32_MAX none; NULL: the corner's vertex */
    const float *colors;   /* red, green, blue, alpha of each vertex; NULL: none */
    const float *tangents; /* x, y, z, sign of each vertex, as stored; NULL: none */
    size_t tangent_count;
    const char *tangent_encoding; /* "float", "snorm8", "snorm16"; "" where there are none */
    size_t normals_missing; /* elements without the normal that they should have: glTF vertices; OBJ
                               faces of which some corners name a normal and others none */
    size_t normals_surplus; /* glTF: normals too many */
    size_t normals_out_of_range; /* OBJ: faces with a vn that is 0 or is not there (their
                                    corner_normals: UINT32_MAX) */
    const uint8_t *face_faults;  /* OBJ: of each face 1 where it is one of normals_missing, 2 of
                                    normals_out_of_range, else 0; NULL: no face is */
    const char
        *ignore; /* rules that extras of the document's root, the mesh or the primitive silence */
} norma_mesh_attributes;
/* Argument error where norma_document_mesh_data has one. */
NORMA_API norma_document_result norma_document_mesh_attributes(norma_document *document,
    size_t index, norma_mesh_attributes *attributes, norma_document_error *error);

typedef struct norma_morph_data { /* what one target adds to each vertex at weight 1, as floats,
                                     positions in the unit of the mesh's; count 0: none */
    norma_vec3_view positions, normals, tangents;
} norma_morph_data;
NORMA_API norma_document_result norma_document_morph_data(norma_document *document, size_t mesh,
    size_t target, norma_morph_data *data, norma_document_error *error);

typedef struct norma_skin_info {
    const char *name, *where; /* where: "/skins/0" */
    size_t joint_count;
    double anisotropy; /* largest over smallest singular value of a joint's world matrix, at rest or
                          in any key of an animation that scales it or a node above it: the largest
                          there is; INFINITY where one is singular */
    size_t joint;      /* the node for which that is so; SIZE_MAX: no joints */
    const char *ignore; /* rules that extras of the document's root silence */
} norma_skin_info;
NORMA_API size_t norma_document_skin_count(norma_document *document);
NORMA_API norma_document_result norma_document_skin_info(
    norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error);

typedef struct norma_unread { /* a part that was not read */
    const char *where, *why; /* JSON pointer; one line, "compressed with KHR_draco_mesh_compression,
                                which is not read yet" */
} norma_unread;
NORMA_API size_t norma_document_unread_count(norma_document *document);
NORMA_API norma_document_result norma_document_unread(
    norma_document *document, size_t index, norma_unread *unread);

/* ---- computing normals */

typedef enum norma_shading {
    NORMA_SHADING_DEFAULT = 0, /* creases at 60 degrees; PLY: smooth; STL: facets; OBJ with
                                  smoothing groups: by them alone */
    NORMA_SHADING_CREASE,
    NORMA_SHADING_SMOOTH,
    NORMA_SHADING_FLAT
} norma_shading;
typedef enum norma_only { NORMA_ONLY_ALL = 0, NORMA_ONLY_MISSING, NORMA_ONLY_BROKEN } norma_only;
typedef enum norma_groups { NORMA_GROUPS_AUTO = 0, NORMA_GROUPS_IGNORE } norma_groups;

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
    int morphs; /* nonzero: morph targets get normal deltas also where they had none */
    uint32_t threads;
    norma_progress *progress;
    void *progress_user;
} norma_compute_options;

typedef struct norma_compute_summary {
    int changed; /* 0: the document would be written as it was read, byte for byte */
    size_t faces, vertices_before, vertices_after;
    norma_shading shading;   /* as it was done: crease, smooth or flat */
    double crease_angle_rad; /* with crease: the angle in force; pi where groups alone decide */
    int by_groups;           /* smoothing groups took part */
    int edges_counted;       /* whether the three counts of edges (hard, and two of the report) were
                                looked at */
    size_t hard_edges;       /* between two faces */
    size_t filled;           /* elements that had no normal of their own and got the nearest one */
    norma_report report;     /* over all meshes; first: SIZE_MAX where several meshes were summed */
} norma_compute_summary;

/* Computes normals into the document. Argument error for what the format cannot hold (smooth
 * shading in STL). After an error the document can only be closed. */
NORMA_API norma_document_result norma_document_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error);

/* ---- transforming */

typedef struct norma_transform_options {
    size_t struct_size;
    double matrix[16]; /* column-major, of the points; all zero: identity */
    int bake;          /* glTF: node transforms go into the meshes as well */
    uint32_t threads;
    norma_progress *progress;
    void *progress_user;
} norma_transform_options;

typedef struct norma_transform_summary {
    int changed;
    size_t vertices, meshes, nodes_baked;
    int mirrored; /* the matrix, or one of the nodes baked, mirrors: winding was reversed there (a
                     glTF that is not baked: by whoever draws it) */
} norma_transform_summary;
NORMA_API norma_document_result norma_document_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error);

/* Brings meshes that lie far from their origin near it, so that floats have digits left for their
 * shape: positions move by a step that floats hold, such that the differences are exact, along the
 * axes on which a mesh lies more than eight times its size away. glTF: a node below each node that
 * drew the mesh draws it now, moved back, so that all stays where it was; of a mesh that is drawn
 * with a skin, by instancing, with animated weights or by no node, or whose positions are no
 * floats, the origin stays, and a note says so. OBJ, PLY and STL have nothing that could make up
 * for it: the mesh then lies elsewhere. meshes: a mark for each mesh of the document (a glTF mesh
 * moves where one of its primitives is marked); NULL: all. *changed: whether any moved. A change
 * like norma_document_transform, with its errors. O(file). */
NORMA_API norma_document_result norma_document_recentre(
    norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);

/* ---- editing: single faces, normals, positions, tangents; what norma check --fix does to a file
 *
 * All that is not named keeps its bytes wherever its encoding stays. NULL: that stays as it is.
 * Marks are bytes, nonzero for what is meant. */

enum {
    NORMA_STRIP_NOTHING = 0,
    NORMA_STRIP_ALL,
    NORMA_STRIP_MORPHS
}; /* normals, and tangents with them, of the mesh and its morph targets; of
                       the targets alone, where the mesh has none */

typedef struct norma_mesh_edit {
    const uint8_t *reverse_faces; /* a mark for each face: its corners run the other way round, the
                                     first stays the first */
    const uint8_t *drop_faces; /* a mark for each face: it is left out (a glTF primitive keeps one:
                                  without any it would not be valid) */
    const uint8_t *cut_faces;  /* OBJ, PLY: a mark for each face: it becomes triangles, with the
                                  corners' UVs and normals, ... */
    const uint32_t
        *cut_corners; /* ...three numbers of its corners (from 0, within the face) each: of a face
                         whose corners begin at corner c from 3 c on, two triangles fewer than it
                         has corners. Not together with reverse_faces */
    const float *normals; /* three numbers for each stored normal: of a vertex (glTF, PLY), a vn
                             (OBJ), a facet (STL); unit vectors */
    const uint8_t *set_normals; /* a mark for each: those that replace the stored ones */
    const double *positions;    /* three numbers for each position (STL: three positions a facet) */
    const uint8_t *set_positions;
    const float *tangents; /* glTF: x, y, z, sign for each vertex */
    const uint8_t
        *set_tangents; /* where the primitive has none yet, all are taken, whatever the marks */
    int strip_normals; /* glTF: normals that are taken away; their accessor stays, since numbers
                          never shift */
    const uint32_t *source_vertices; /* glTF, PLY, OBJ: these are the vertices now, each a copy of
                                        all that the old one of this number has (attributes, morph
                                        targets; of an OBJ the v line); the marks and numbers above
                                        then count the new ones. OBJ: not together with them */
    size_t vertex_count;             /* of source_vertices, at least 1 */
    const uint32_t *new_corners;     /* with it: the new vertex of each corner, in the order of
                                        norma_mesh_data (before reverse_faces) */
} norma_mesh_edit;

/* edits: one for each mesh of the document, in its order. Like compute and transform a change: of
 * an open glTF the only one. Argument error for what the format does not have. After an error the
 * document can only be closed. O(file). */
NORMA_API norma_document_result norma_document_edit(
    norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);

/* glTF, PLY, OBJ: of each vertex of a mesh the first that equals it bit for bit in all that the
 * file gives it (attributes, morph targets; PLY: the whole row, of a text its words; OBJ: the words
 * of the v line); itself where something in the file may name vertices by their numbers. first:
 * room for norma_mesh_info.vertices. Argument error for other formats; unsupported where a glTF's
 * vertices, which may share their bytes, would take far more room than the file. Expected
 * O(vertices). */
NORMA_API norma_document_result norma_document_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error);

/* ---- writing */

typedef struct norma_save_options {
    size_t struct_size;
    int in_place; /* nonzero: path may name the source; a .gltf keeps the names of its own buffers
                   */
    norma_progress *progress; /* cancelled: nothing is left of the new file */
    void *progress_user;
} norma_save_options;

/* Writes path whole or not at all; a .gltf with its buffers beside it. Refuses a path that names
 * the source or one of its buffers, unless in place, and in place what another program has changed
 * or is replacing at the same time. Whenever the process or the machine stops, path is the old file
 * or the new one: buffers are on the disk before the .gltf that needs them, and in place they only
 * gain bytes, so that the old .gltf, and others that share them, read what they read. What the
 * temporary files are called: .norma-PROCESS-NUMBER.tmp; on Linux they have no name until they are
 * whole. */
NORMA_API norma_document_result norma_document_save(norma_document *document, const char *path,
    const norma_save_options *options, norma_document_error *error);

/* Hands the whole file to write in order (nonzero from it: stop, file error); a .gltf with its
 * buffers as data URIs. */
typedef int norma_write(void *user, const void *bytes, size_t size);
NORMA_API norma_document_result norma_document_write(
    norma_document *document, norma_write *write, void *user, norma_document_error *error);

/* The document as it would be read after norma_document_save to path (NULL: after
 * norma_document_write), of its own; nothing is written. So an open glTF can be changed more than
 * once: settle between the changes, and save the last one, to the same path. options: as of
 * norma_document_open; the format stays. document stays as it is. O(file). */
NORMA_API norma_document_result norma_document_settle(norma_document *document, const char *path,
    const norma_document_options *options, norma_document **settled, norma_document_error *error);

/* Writes path as norma_document_save does, whole or not at all, with any bytes: a report, a
 * picture. A device or a pipe is written as it is. */
NORMA_API norma_document_result norma_save_bytes(
    const char *path, const void *bytes, size_t size, norma_document_error *error);

#ifdef __cplusplus
}
#endif
#endif
