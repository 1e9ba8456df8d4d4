/* format.h: what the formats share with the public functions: a format is a table of functions over
 * its own state; what waits to be written; what a document tells beside its meshes; which normals
 * are computed and what is counted. */
#ifndef NORMA_IO_FORMAT_FORMAT_H
#define NORMA_IO_FORMAT_FORMAT_H
#include <norma/document.h>
#include "io/file/file.h"
#include "io/format/for_fixes.h"
#include "io/stream/stream.h"

/* ---- Normals that a document gets from outside instead of computing them from its
 * own faces alone: those of a surface that lies in several files. */

/* A mesh of a document within a surface: a glTF primitive. */
typedef struct surface_part {
    size_t mesh;           /* its number in the document */
    size_t first_position; /* in the surface */
    size_t first_corner;   /* SIZE_MAX: its triangles are those of another part */
} surface_part;

/* All triangles of a glTF mesh, whatever their primitives; a whole OBJ or PLY. */
typedef struct document_surface {
    size_t number; /* of the glTF mesh; 0 */
    const norma_mesh *mesh;
    double unit; /* what integers of its positions are multiplied by; else 1 */
    const surface_part *parts;
    size_t part_count;
} document_surface;

/* Called for each surface of a document, in order. */
typedef norma_document_result visit_surface(void *user, const document_surface *surface);

typedef struct shared_normals {
    void *user;
    /* The normals of all positions of a surface, and why some have none of their own. */
    norma_result (*take)(
        void *user, size_t surface, const norma_mesh *mesh, float *normals, uint8_t *reasons);
    /* Nonzero for each mesh (glTF), face (OBJ), or for the whole (PLY) that keeps what it has;
     * NULL: nothing does. */
    const uint8_t *locked;
    int of_corners; /* take gives the normals of all corners */
} shared_normals;

/* ---- What the formats and document.c share. A format is a table of functions over its own
 * state.
 *
 * A change waits until it is asked for or saved, in one of two ways:
 *   glTF                  by has_change, reopen, adopt and drop_change: the patch and the edits of
 *                         the JSON become a file in memory, which is read anew (flush_changes in
 *                         document.c) before anything is asked or changed.
 *   OBJ, PLY, STL         by edited (format.c): beside the bytes that were read. PLY and STL become
 *                         bytes of their own, read again, before arrays are given out or the next
 *                         change (norma_edited_flush); OBJ's wait together (edited->gathers), and
 *                         show as they are.
 * 3MF is opened by edited as well, and its bytes are replaced at once; composites (cmpt) have
 * neither. document.c begins each change (begin_change, begin_edit) and takes back what failed
 * (end_change).
 */

typedef struct format_functions format_functions;
typedef struct scene_functions scene_functions;
typedef struct edited_format edited_format;

typedef struct companion_writers { /* freed by who made it; paths: what messages name */
    file_writer **list;
    char **paths, **folders; /* folders: made for them, to go where the save fails */
    int outlive;             /* they are put in place when their documents are closed */
    size_t count, folder_count, list_capacity, path_capacity, folder_capacity;
    uint64_t
        size; /* bytes of all files beside the document, also of those that are there already */
} companion_writers;
/* format.c, these five. 0: memory is out, and the writer is abandoned. */
int norma_document_add_writer(companion_writers *writers, file_writer *writer, const char *path);
/* What one of them replaces must be the file of this stamp; which is renewed, unless they outlive
 * it.
 */
void norma_document_expect(
    const companion_writers *writers, file_writer *writer, file_stamp *stamp);
/* Makes a folder for them if it does not exist. Returns 0 or errno. */
int norma_document_add_folder(companion_writers *writers, const char *path);
/* All into place, or none; none is left to abandon. */
norma_document_result norma_document_commit(
    companion_writers *writers, norma_document_error *error);
void norma_document_free_writers(companion_writers *writers, int abandon);

typedef struct given_buffer { /* a buffer file of a .gltf that is not on the disk yet */
    unsigned char *bytes;     /* NULL: the file's */
    size_t size;
    file_stamp stamp; /* of the file that it takes the place of */
    int changed;
} given_buffer;

typedef struct given_image { /* an image of a glTF that is not on the disk yet */
    size_t number;           /* in the file's list */
    unsigned char *bytes;
    size_t size;
    char *name; /* of its file beside the output, chosen by the layout */
} given_image;

struct norma_document {
    const format_functions *functions;
    norma_file_format format;
    norma_document_depth depth;
    uint32_t threads;
    norma_watch watch; /* of the opening, the transform or the saving that is under way */
    char *path;   /* as the caller gave it; what messages name; "<stdin>" or the like from memory */
    char *folder; /* with its last slash; "" the current one; NULL: none, external files are refused
                   */
    file_bytes source;   /* the whole file, mapped or the caller's */
    file_stamp stamp;    /* of the file at path when it was read */
    void *state;         /* the format's own */
    given_buffer *given; /* NULL, or of a changed glTF: by the number of the buffer */
    int replaced;        /* it was saved over its own file */
    size_t given_count;
    given_image *images; /* those that are to be files of their own */
    size_t image_count;
    char **notes;
    size_t note_count, note_capacity;
    int failed;   /* a change went wrong half-way and could not be taken back: it can only be closed
                   */
    int had_edit; /* a change waited already when the last one began */
    uint8_t
        *renew; /* NULL, or of normals just computed: the meshes whose tangents stood on old ones */
    const shared_normals *shared; /* NULL, or where its normals come from while it is computed */
    int copied;                   /* files are read into memory, for a summary too */
    int lenient;                  /* what norma check judges is read instead of refused */
    size_t tile_count;            /* of a composite with several models, */
    norma_document **tiles;       /* which are open on its bytes; or NULL */
    struct norma_scene *scene;    /* what else is told of it */
};

/* Each returns NORMA_DOCUMENT_OK or what norma_document_fail returned. State is freed by close also
 * after a failed open. */
struct format_functions {
    norma_document_result (*open)(norma_document *document, norma_document_error *error);
    void (*close)(norma_document *document);
    size_t (*mesh_count)(const norma_document *document);
    norma_document_result (*mesh_info)(
        const norma_document *document, size_t index, norma_mesh_info *info);
    norma_document_result (*mesh_data)(
        norma_document *document, size_t index, norma_mesh_data *data, norma_document_error *error);
    size_t (*node_count)(const norma_document *document); /* NULL: none */
    norma_document_result (*node_info)(
        const norma_document *document, size_t index, norma_node_info *info);
    /* compute, transform and edit: all NULL where files can only be read. */
    norma_document_result (*compute)(norma_document *document, const norma_compute_options *options,
        norma_compute_summary *summary, norma_document_error *error);
    norma_document_result (*tangents)(norma_document *document,
        const norma_tangent_options *options, norma_tangent_summary *summary,
        norma_document_error *error); /* NULL: the format holds none */
    norma_document_result (*pack)(norma_document *document, const norma_pack_options *options,
        norma_pack_summary *summary, norma_document_error *error); /* NULL: nothing to choose */
    norma_document_result (*transform)(norma_document *document,
        const norma_transform_options *options, norma_transform_summary *summary,
        norma_document_error *error);
    norma_document_result (*edit)(
        norma_document *document, const norma_mesh_edit *edits, norma_document_error *error);
    norma_document_result (*equal_vertices)(norma_document *document, size_t mesh, uint32_t *first,
        norma_document_error *error); /* NULL: vertices have nothing else to compare */
    norma_document_result (*recentre)(norma_document *document, const uint8_t *meshes, int *changed,
        norma_document_error *error); /* NULL: by a transform */
    /* NULL: the format has no materials. */
    norma_document_result (*turn_green)(
        norma_document *document, const uint8_t *meshes, int *changed, norma_document_error *error);
    /* The document's own bytes in order. glTF: the text or GLB, as it is to stand at path (NULL:
     * with data URIs). */
    norma_document_result (*write)(norma_document *document, const char *path, norma_write *write,
        void *user, norma_document_error *error);
    /* NULL, or the other files that belong beside path (a .gltf's buffers, its images), written and
     * prepared, and added to writers, which the caller commits: in order, so that they are in place
     * before the file that names them. Called when the bytes of path are written and flushed to its
     * temporary. */
    norma_document_result (*write_companions)(norma_document *document, const char *path,
        int in_place, companion_writers *writers, norma_document_error *error);
    /* NULL, or the first of the files beside its own that has changed since this document was read
     * from it, the caller's to free. */
    char *(*changed_companion)(const norma_document *document);
    /* All NULL but for glTF (above). Whether a change waits; gives made the bytes and
     * buffers that it is to be read from; makes the document's state its own; takes back a change
     * that failed (0: memory is out). */
    int (*has_change)(const norma_document *document);
    norma_document_result (*reopen)(
        norma_document *document, norma_document *made, norma_document_error *error);
    void (*adopt)(norma_document *document);
    int (*drop_change)(norma_document *document);
    /* NULL, or hands visit each file beside its own that this document was read from or names,
     * until visit returns nonzero. Returns 1 if it was stopped, -1 if memory is out, else 0. Called
     * only if the document has a folder. */
    int (*visit_files)(const norma_document *document, norma_visit_file *visit, void *user);
    const scene_functions *scene; /* NULL: nothing else is told */
    const edited_format *edited;  /* for norma_edited_open and the like */
};

/* What is under way is watched also where the document is only read. */
static inline norma_watch *norma_document_watch(const norma_document *document) {
    return &((norma_document *)(uintptr_t)document)->watch;
}

extern const format_functions norma_obj_functions, norma_ply_functions, norma_stl_functions,
    norma_gltf_functions /* all that hold one glTF */, norma_composite_functions,
    norma_3mf_functions;

/* ---- format.c: what the formats call. For visit_files: hands visit the file of a name, which is
 * relative to the document's folder or absolute. Returns 1 if visit stopped, -1 if memory is out,
 * else 0. */
int norma_document_visit_name(const norma_document *document, const char *name, size_t length,
    norma_visit_file *visit, void *user);
/* The same for names with blanks between; since a name may hold blanks, also for all of the text.
 */
int norma_document_visit_names(const norma_document *document, const char *text, size_t length,
    norma_visit_file *visit, void *user);
/* document_life.c: whether path is one of the files that visit_files names. */
int norma_document_names_file(const norma_document *document, const char *path);

/* Fills error (may be NULL) with "PATH: " and the formatted message, and returns result. place, if
 * not NULL, is put after the path: "PATH:PLACE: message" (a line number, "byte 120", "accessor 3").
 */
#if defined(__GNUC__)
__attribute__((format(printf, 5, 6)))
#endif
norma_document_result
norma_document_fail(const norma_document *document, norma_document_error *error,
    norma_document_result result, const char *place, const char *format, ...);
/* What an error of file.h means, in words. */
void norma_document_system_text(int system_error, char *text, size_t room);
/* "PATH: WHAT: the system's text", for any path; result FILE, or MEMORY where the system says so.
 */
norma_document_result norma_document_fail_file(
    const char *path, norma_document_error *error, const char *what, int system_error);
/* Inline, so that an analyser of the callers sees that it never returns OK. */
static inline norma_document_result norma_document_fail_memory(
    const norma_document *document, norma_document_error *error) {
    (void)norma_document_fail(document, error, NORMA_DOCUMENT_ERROR_MEMORY, NULL, "out of memory");
    return NORMA_DOCUMENT_ERROR_MEMORY;
}
norma_document_result norma_document_fail_cancelled(
    const norma_document *document, norma_document_error *error);
/* A core result as a document's: index, overflow and argument errors of the core are MALFORMED here
 * (the readers should have caught them), cancelled stays. */
norma_document_result norma_document_fail_core(
    const norma_document *document, norma_document_error *error, norma_result result);

/* ---- io/document: what its files share (document_life.c, where no other is named). A caller's
 * header may be older or newer than this library: what it does not know is zero, what we do not
 * know is left out; a size of 0 is that of the first version. */
void norma_document_copy_options(void *copy, size_t size, size_t first_size, const void *given);
void norma_document_clear(norma_document_error *error);
/* document.c: what is wrong with them, or NULL. */
const char *norma_document_bad_compute_option(const norma_compute_options *options);
norma_document_result norma_document_usable(const norma_document *document,
    norma_document_error *error); /* opened whole, and no change of it has failed */
norma_document *norma_document_make(const char *name, int has_folder,
    const norma_document_options *options); /* NULL: out of memory */
norma_document_result norma_document_read(
    norma_document *document, norma_document_error *error); /* by its format, from its source */
/* Whether a file that it is read from has been written to, with the error. Mapped bytes are those
 * of the file as it is now: half of them may be old, half of them new. */
int norma_document_changed(const norma_document *document, norma_document_error *error);
/* document.c: before it is asked: what a change has made of it shows, unless it cannot be read
 * anew; then it answers as it was. Whether there is a document. */
int norma_document_up_to_date(const norma_document *document);

/* format.c: of the image of this number the bytes that it will have; NULL: those of its file. */
const given_image *norma_document_given_image(const norma_document *document, size_t number);
void norma_document_forget_images(norma_document *document);

/* document_save.c: writes the document and what goes beside it to temporary files, and adds their
 * writers, in the order in which they are to be put in place. options: all fields are read. */
norma_document_result norma_document_prepare(norma_document *document, const char *path,
    const norma_save_options *options, companion_writers *writers, norma_document_error *error);

/* document_save.c: whether it may be written to this path. */
norma_document_result norma_document_check_target(
    const norma_document *document, const char *path, int in_place, norma_document_error *error);

/* format.c: a file beside the document's own, read into memory; cancelled by the document's
 * progress. Returns what norma_file_open does. */
int norma_document_load_file(const norma_document *document, const char *path, file_bytes *bytes);

/* Whether a text begins like a file of zeros, such as one with a hole: a reader refuses it at once
 * instead of looking for the end of its first word through gigabytes. */
static inline int norma_begins_with_zeros(const unsigned char *bytes, size_t size) {
    enum { FEW = 256 };
    size_t zeros = 0;
    while (zeros < FEW && zeros < size && bytes[zeros] == 0) ++zeros;
    return zeros == FEW;
}

/* ---- What a document tells beside its meshes: materials, attributes, morphs, skins, what was
 * not read. Made on first use, kept until the document is closed. Each format that has any of it
 * gives a table of functions; an entry that is NULL stands for none. Internal to io. */

typedef struct scene_block scene_block;

typedef struct norma_scene {
    scene_block *blocks;            /* all memory of what follows */
    norma_material_info *materials; /* NULL: not asked for yet; so for all that follows */
    size_t material_count;
    norma_mesh_attributes **attributes; /* for each mesh */
    norma_node_info *nodes; /* for each node of the file: the fields that are not about drawing */
    norma_morph_data **morphs; /* for each target, as the format numbers them */
    norma_skin_info **skins;
    norma_unread *unread;
    size_t unread_count;
    struct gltf_scene *gltf; /* what glTF's own files keep */
} norma_scene;

typedef struct scene_functions {
    norma_document_result (*materials)(norma_document *document,
        norma_document_error *error); /* fills materials and material_count */
    norma_document_result (*attributes)(norma_document *document, size_t mesh,
        norma_mesh_attributes *attributes, norma_document_error *error);
    norma_document_result (*morph)(norma_document *document, size_t mesh, size_t target,
        norma_morph_data *data, norma_document_error *error);
    size_t (*skin_count)(const norma_document *document);
    norma_document_result (*skin)(
        norma_document *document, size_t index, norma_skin_info *info, norma_document_error *error);
    norma_document_result (*unread)(
        norma_document *document, norma_document_error *error); /* fills unread and unread_count */
    norma_document_result (*instance_world)(norma_document *document, size_t node, size_t instance,
        double world[16], norma_document_error *error);
    /* as norma_document_tile_instance; NULL: no tile has the format */
    size_t (*tile_instance)(const norma_document *document, size_t index, double matrix[16]);
    /* drawn is filled as the file stores the mesh: moves it by its morph targets and its skin */
    norma_document_result (*move_drawn)(norma_document *document, size_t node, size_t mesh,
        norma_drawn_mesh *drawn, norma_document_error *error);
    norma_document_result (*material_maps)(norma_document *document, size_t material,
        norma_material_maps *maps, norma_document_error *error);
    norma_document_result (*normal_map)(norma_document *document, size_t material,
        norma_texture_info *map, norma_document_error *error);
    norma_document_result (*texcoords)(norma_document *document, size_t mesh, size_t set,
        const float **texcoords, size_t *count, norma_document_error *error);
} scene_functions;

extern const scene_functions norma_gltf_scene;

/* Zeroed memory that lives as long as the document; NULL: none is left. */
void *norma_scene_allocate(norma_scene *scene, size_t count, size_t size);
/* Places for so many things that were not read, which the scene then tells; NULL, with the error:
 * out of memory. */
norma_unread *norma_scene_tell_unread(
    norma_document *document, size_t count, norma_document_error *error);
/* Whether bytes hold nothing: blanks, line ends and zeros only. */
int norma_is_padding(const unsigned char *bytes, size_t size);
char *norma_scene_text(norma_scene *scene, const char *text);
/* Two lists of rules as one, with a comma between them where both have something. */
char *norma_scene_join(norma_scene *scene, const char *first, const char *second);

/* What was told is no longer so: the file's bytes are others now. NULL is fine. */
void norma_scene_forget(norma_scene *scene);

/* ---- Single faces and vectors of a document changed, for norma_document_edit. Each format has
 * a file of its own. */

static inline int norma_edit_has_faces(const norma_mesh_edit *edit) {
    return edit->reverse_faces || edit->drop_faces || edit->source_vertices;
}
static inline int norma_edit_says(const uint8_t *marks, size_t index) {
    return marks && marks[index];
}
/* format.c: of its list of vertices how many are old ones that stay in their order, from the first
 * on. */
size_t norma_edit_kept(const norma_mesh_edit *edit);

/* ---- What the formats share whose changes wait beside the bytes that were read: written
 * through a sink, compared with what was there, made the document's own bytes. */

/* A format whose changes wait beside the bytes of the document: how its state is made, read and let
 * go. */
struct edited_format {
    size_t state_size;
    int gathers; /* nonzero: changes wait together; 0: each begins with flushing those before */
    int (*has_edit)(const void *state);
    void (*free_content)(void *state);
    /* From document->source, into a state of zeros. */
    norma_document_result (*read)(norma_document *document, norma_document_error *error);
    /* For norma_edited_write and norma_edited_drop_idle: the file with its changes; and these let
     * go. NULL where neither is called with a change. */
    norma_document_result (*write_changed)(
        norma_document *document, norma_sink *sink, norma_document_error *error);
    void (*forget_edit)(void *state);
};
norma_document_result norma_edited_open(norma_document *document, norma_document_error *error);
void norma_edited_close(norma_document *document);
size_t norma_edited_mesh_count(const norma_document *document); /* 1 */
/* Pieces made side by side, in order, into what the sink writes to. A sink that failed before takes
 * none. */
norma_document_result norma_edited_put_ordered(norma_document *document, norma_sink *sink,
    size_t count, norma_make_data_run *make, void *context, norma_document_error *error);
norma_document_result norma_edited_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error);
/* Forgets changes that would write the bytes that are there already; *changed: whether any are
 * left. */
norma_document_result norma_edited_drop_idle(
    norma_document *document, int *changed, norma_document_error *error);
/* The changes become the document's bytes, which are read again. Does nothing without changes. */
norma_document_result norma_edited_flush(norma_document *document, norma_document_error *error);
/* Before a change; and a change that failed for this reason is taken back, by reading the
 * document's bytes again if anything was done. 0: it cannot be, because other changes wait with it,
 * or memory is out. */
void norma_edited_begin(norma_document *document);
int norma_edited_drop(norma_document *document, norma_document_result why);
/* These bytes become the document's, which owns them from now on. */
norma_document_result norma_edited_replace(
    norma_document *document, const growing_bytes *bytes, norma_document_error *error);
/* The document's bytes to be changed in place, copied first if they belong to the caller; NULL: out
 * of memory. */
unsigned char *norma_edited_own_bytes(norma_document *document);

/* ---- How far positions that lie far from their origin are moved, so that floats hold the
 * step and what becomes of them exactly. */

typedef struct recentre_box {
    double low[3], high[3]; /* of finite positions */
} recentre_box;

recentre_box norma_recentre_empty(void);
void norma_recentre_add(recentre_box *box, const double position[3]);
/* What is to be taken from each position; 0 along an axis that is near. Whether there is anything.
 */
int norma_recentre_step(const recentre_box *box, double step[3]);

/* ---- Matrices of 4 x 4, and stored normals under that of a whole document. */

int norma_matrix_is_identity(const double m[16]); /* exactly */
void norma_matrix_multiply(const double a[16], const double b[16], double product[16]);
double norma_matrix_determinant(const double m[16]); /* of its upper 3 x 3 */

typedef struct normal_mapping {
    float matrix[9]; /* the normal matrix, its greatest entry 1 */
    double flat[3];  /* where the model flattens: the direction of the normals that remain */
    int mirrored;
} normal_mapping;

/* Progress is 0, and the summary knows whether the matrix mirrors. */
norma_document_result norma_stored_normals_begin(const norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    normal_mapping *mapping, norma_document_error *error);
norma_document_result norma_stored_normals_progress(const norma_document *document,
    const norma_transform_options *options, double fraction, norma_document_error *error);
/* normals: three doubles each, out: three floats. What the matrix takes to nothing gets the
 * direction that remains, what is not finite becomes zero; notes say how many. */
norma_document_result norma_transform_stored_normals(norma_document *document,
    const normal_mapping *mapping, const double *normals, size_t count, float *out,
    norma_document_error *error);
/* Refuses a matrix that takes a finite coordinate beyond most, the largest number that the file can
 * hold. what: the element that the message names, which has positions_each of them. */
norma_document_result norma_check_transformed_range(const norma_document *document,
    const norma_vec3_view *before, const double *after, double most, const char *what,
    size_t positions_each, norma_document_error *error);

/* ---- What is decided when the normals of a file are computed, alike for every
 * format: how the mesh is shaded, which stored normals are replaced, what is written for elements
 * without a normal, and what is counted. A format says how it stores normals and hands over its
 * meshes. */

typedef struct compute_policy {
    const norma_compute_options *options;
    norma_compute_summary *summary;
    norma_options core; /* options of the core's calls, with the nearest fallback in force */
    size_t meshes;      /* computed so far */
    const shared_normals *shared; /* NULL, or where the normals of positions come from */
    size_t surface;               /* the number of the surface that is to be computed */
} compute_policy;

/* Begins the summary. usual: the shading that the format gets if none was asked for; has_groups:
 * the mesh has smoothing groups, which decide about a crease if they are not to be ignored. */
compute_policy norma_policy_begin(const norma_compute_options *options,
    norma_compute_summary *summary, norma_shading usual, int has_groups);

/* ---- which stored normals are replaced */

/* By core/face/unit_length.h, in so many bits. */
int norma_normal_is_broken(const double normal[3], int bits);
/* Whether --only asks for a new one in place of a normal that is there. */
int norma_policy_wants(norma_only only, const double normal[3], int bits);
/* The same for the facet of an STL, where zero is a custom that means "take the winding": it counts
 * as missing, so that missing and broken fill it; broken beyond that is only what is not finite. */
int norma_policy_wants_facet(norma_only only, const float stored[3]);

/* ---- computing */

typedef enum normal_elements {
    NORMALS_OF_POSITIONS, /* smooth */
    NORMALS_OF_FACES,     /* flat */
    NORMALS_OF_CORNERS,   /* creased, one for each corner */
    NORMALS_OF_POINTS     /* creased, one for all corners at a vertex that share theirs */
} normal_elements;
normal_elements norma_policy_elements(norma_shading shading);

typedef struct computed_normals {
    normal_elements elements;
    int with_reasons; /* whether reasons and, of points, sources are asked for */
    double crease_angle_rad;
    float *normals;    /* of each element; zero if the mesh has no normal at all */
    uint8_t *reasons;  /* of each element, why it got the nearest normal instead of its own */
    uint32_t *points;  /* of each corner its point, numbered as corners first use them */
    uint32_t *sources; /* of each point its position */
    size_t count;      /* of elements */
} computed_normals;

/* Adds the report of one mesh to the sum; the firsts become SIZE_MAX from the second mesh on. */
void norma_policy_add_report(norma_report *sum, const norma_report *report, size_t meshes_before);

/* The normals of one mesh. Adds to the report,
 * and to the hard edges if there are creases. */
norma_result norma_policy_compute(
    compute_policy *policy, const norma_mesh *mesh, computed_normals *made);
void norma_computed_normals_free(computed_normals *made);

/* ---- what is written, what is counted */

/* Files get the z axis if the whole mesh has no direction, and so no nearest normal either. */
static inline void norma_policy_point_up(float normal[3]) {
    if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0) normal[2] = 1;
}
/* The sign of a stored zero says nothing: it stays, so that right normals stay to the bit. */
static inline float norma_policy_keep_zero(float now, double stored) {
    return now == 0 && stored == 0 ? (float)stored : now;
}
/* Points up where there is no normal, and counts the elements that were filled. wanted: of the
 * first wanted_count elements, whether they get a new normal, as all others do; may be NULL. */
void norma_policy_fill(compute_policy *policy, float *normals, const uint8_t *reasons, size_t count,
    const uint8_t *wanted, size_t wanted_count);
/* Formats whose vertices are others than the core's count them as they stand in the file: they
 * forget what the core counted without a normal of its own, and count by reasons. several: there
 * are other meshes, so no vertex is the first. */
void norma_policy_forget(norma_report *report);
void norma_policy_report(norma_report *report, const uint8_t *reasons, size_t count,
    const uint8_t *wanted, size_t wanted_count, int several);
/* What the core counted without a normal of its own. */
size_t norma_policy_without_normal(const norma_report *report);
#endif
