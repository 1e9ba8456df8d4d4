/* obj.h: what an OBJ file holds: positions, polygons, normals and smoothing groups as arrays. The
 * text itself stays the file's bytes: nothing is remembered of where a statement stands, but for vn
 * lines; a writer walks over the same statements again, in the same order. Internal to obj_*.c.
 *
 * The text is cut into stretches of whole statements, which threads read and write side by side. */
#ifndef NORMA_IO_OBJ_H
#define NORMA_IO_OBJ_H
#include "io/format/flush_edits.h"
#include "io/format/format.h"

/* A corner's normal is a number, or one of these. */
#define OBJ_NO_NORMAL  UINT32_MAX       /* it names none */
#define OBJ_BAD_NORMAL (UINT32_MAX - 1) /* it names one that is not there */
#define OBJ_MOST                                                                                   \
    (UINT32_MAX - 2) /* elements of a kind at most, so that every number is below both */

/* Smoothing groups apply from a face on, up to the next run's first. */
typedef struct obj_run {
    size_t first_face;
    int64_t group; /* 0: none */
} obj_run;

/* Where a stretch begins, in the text and in each list. */
typedef struct obj_stretch {
    size_t offset, position, normal, face, other;
} obj_stretch;

typedef struct obj_vertices obj_vertices; /* vertex_lines.h */

typedef struct obj_state {
    obj_stretch *stretches; /* one more, at the end of all */
    size_t stretch_count;
    double *positions; /* three each */
    size_t position_count,
        position_room;        /* rooms count what norma_io_grow counts: positions, corners, ... */
    uint32_t *corners;        /* position of each corner */
    uint32_t *corner_normals; /* in step with corners; NULL: none names a normal */
    size_t corner_count, corner_room, corner_normal_room;
    uint32_t *face_starts; /* face_count + 1; NULL: all are triangles */
    size_t face_count, face_room;
    float *normals;         /* three each */
    size_t *normal_offsets; /* of the first offset_count normals the byte its statement begins at;
                               SIZE_MAX, or behind those: computed, it has none */
    size_t normal_count, offset_count, normal_room, normal_offset_room;
    uint32_t
        *other_normals; /* those that statements other than faces name, in the order of the text */
    size_t other_count, other_room;
    obj_run *runs;
    size_t run_count, run_room;
    char *name;                         /* of the first object */
    size_t first_library, last_library; /* where mtllib statements stand; SIZE_MAX: none does */
    size_t block; /* where vn lines go: where the first vn or face statement begins; SIZE_MAX: there
                     is neither */
    size_t bad_normal_count;     /* corners with OBJ_BAD_NORMAL */
    int has_normals, has_groups; /* some corner names one that is there; some face lies in a group
                                    other than 0 */
    int has_surfaces;            /* free-form ones */
    int has_long_positions;      /* some coordinate has more digits than a float needs */

    /* What changed since the file was read. */
    int normals_replaced; /* vn lines: the kept ones and the new ones stand in one block */
    int normals_turned;   /* what vn lines say is no longer what normals holds */
    int positions_moved;
    int floats_suffice; /* for the moved positions: nine digits tell all there is */
    int faces_reversed;
    const uint8_t *reverse_faces, *drop_faces,
        *cut_faces; /* marks of an edit under way, its caller's; or NULL */
    const uint32_t *cut_corners;
    obj_vertices *vertices; /* v lines that go and come; NULL: none */

    /* For norma_document_mesh_data. */
    uint32_t *shown_normals; /* corner_normals without OBJ_BAD_NORMAL */
    uint32_t *group_masks;   /* of the last norma_obj_groups */
    uint8_t *hard_edges;
} obj_state;

static inline size_t norma_obj_face_start(const obj_state *state, size_t face) {
    return state->face_starts ? state->face_starts[face] : 3 * face;
}

static inline uint32_t norma_obj_normal(const obj_state *state, size_t corner) {
    return state->corner_normals ? state->corner_normals[corner] : OBJ_NO_NORMAL;
}

static inline size_t norma_obj_normal_offset(const obj_state *state, size_t normal) {
    return normal < state->offset_count ? state->normal_offsets[normal] : SIZE_MAX;
}

/* read_parallel.c */
norma_document_result norma_obj_read(norma_document *document, norma_document_error *error);

/* obj_state.c. Flushing makes the changes the document's bytes, which are read again. */
extern const edited_format norma_obj_edited;
/* The core's view of positions and faces, without groups. */
norma_mesh norma_obj_mesh(const obj_state *state);

/* smoothing_groups.c: sets group_masks, and hard_edges where masks do not suffice, such that faces
 * of one group other than 0 share edges, and others do not. */
norma_result norma_obj_groups(obj_state *state, const norma_options *options);

/* obj_compute.c, obj_transform.c, obj_write.c: as format_functions has them. */
norma_document_result norma_obj_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error);
norma_document_result norma_obj_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error);
norma_document_result norma_obj_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error);
#endif
