/* format.h: what the formats and document.c share. A format is a table of functions over its own
 * state. */
#ifndef NORMA_DOCUMENT_INTERNAL_H
#define NORMA_DOCUMENT_INTERNAL_H
#include <norma/document.h>
#include "io/file/file.h"
#include "io/file/memory.h"
#include "io/file/watch.h"
#include "io/format/for_fixes.h"
#include "io/format/shared_normals.h"

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
/* 0: memory is out, and the writer is abandoned. */
int norma_document_add_writer(companion_writers *writers, file_writer *writer, const char *path);
/* What one of them replaces must be the file of this stamp; which is renewed, unless they outlive
 * it.
 */
void norma_document_expect(
    const companion_writers *writers, file_writer *writer, file_stamp *stamp);
/* Makes a folder for them if it does not exist. Returns 0 or errno. */
int norma_document_add_folder(companion_writers *writers, const char *path);
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
    struct norma_scene *scene;    /* what else is told of it (scene.h) */
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
    /* All NULL where changes show at once. Else: whether one waits; gives made the bytes and
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
    const edited_format *edited;  /* for norma_edited_open and the like (flush_edits.h) */
};

/* What is under way is watched also where the document is only read. */
static inline norma_watch *norma_document_watch(const norma_document *document) {
    return &((norma_document *)(uintptr_t)document)->watch;
}

extern const format_functions norma_obj_functions, norma_ply_functions, norma_stl_functions,
    norma_gltf_functions; /* gltf: .gltf and .glb */

/* For visit_files (named_files.c): hands visit the file of a name, which is relative to the
 * document's folder or absolute. Returns 1 if visit stopped, -1 if memory is out, else 0. */
int norma_document_visit_name(const norma_document *document, const char *name, size_t length,
    norma_visit_file *visit, void *user);
/* The same for names with blanks between; since a name may hold blanks, also for all of the text.
 */
int norma_document_visit_names(const norma_document *document, const char *text, size_t length,
    norma_visit_file *visit, void *user);
/* Whether path is one of the files that visit_files names. */
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

/* What document.c and document_save.c share. A caller's header may be older or newer than this
 * library: what it does not know is zero, what we do not know is left out; a size of 0 is that of
 * the first version. */
void norma_document_copy_options(void *copy, size_t size, size_t first_size, const void *given);
void norma_document_clear(norma_document_error *error);
/* What is wrong with them, or NULL. */
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
/* Before it is asked: what a change has made of it shows, unless it cannot be read anew; then it
 * answers as it was. Whether there is a document. */
int norma_document_up_to_date(const norma_document *document);
/* Reads a changed document anew from what it has become, where its format has changes wait. */
norma_document_result norma_document_flush(norma_document *document, norma_document_error *error);
/* Before something is given out, so that it stays where it is until the next change: nothing waits
 * that giving out something else would first have to write. Changes that wait together (OBJ) are
 * shown as they are. */
norma_document_result norma_document_settle(norma_document *document, norma_document_error *error);
norma_document_result norma_document_ready(
    norma_document *document, norma_document_error *error); /* usable, and settled */

/* Of the image of this number the bytes that it will have; NULL: those of its file. */
const given_image *norma_document_given_image(const norma_document *document, size_t number);
void norma_document_forget_images(norma_document *document);

/* Writes the document and what goes beside it to temporary files, and adds their writers, in the
 * order in which they are to be put in place. options: all fields are read. */
norma_document_result norma_document_prepare(norma_document *document, const char *path,
    const norma_save_options *options, companion_writers *writers, norma_document_error *error);

/* Whether it may be written to this path. */
norma_document_result norma_document_check_target(
    const norma_document *document, const char *path, int in_place, norma_document_error *error);

/* A file beside the document's own, read into memory; cancelled by the document's progress. Returns
 * what norma_file_open does. */
int norma_document_load_file(const norma_document *document, const char *path, file_bytes *bytes);

/* Whether a text begins like a file of zeros, such as one with a hole: a reader refuses it at once
 * instead of looking for the end of its first word through gigabytes. */
static inline int norma_begins_with_zeros(const unsigned char *bytes, size_t size) {
    enum { FEW = 256 };
    size_t zeros = 0;
    while (zeros < FEW && zeros < size && bytes[zeros] == 0) ++zeros;
    return zeros == FEW;
}

#endif
