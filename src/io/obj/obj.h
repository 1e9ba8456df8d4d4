/* obj.h: what an OBJ file holds: positions, polygons, normals and smoothing groups as arrays. The
 * text itself stays the file's bytes: nothing is remembered of where a statement stands, but for vn
 * lines; a writer walks over the same statements again, in the same order. Internal to obj_*.c.
 *
 * The text is cut into stretches of whole statements, which threads read and write side by side. */
#ifndef NORMA_IO_OBJ_H
#define NORMA_IO_OBJ_H
#include "io/format/format.h"
#include "io/file/file.h"
#include <stddef.h>
#include <stdint.h>
#include "io/text/text.h"
#include <norma/norma.h>

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

typedef struct obj_vertices obj_vertices; /* v lines that go and come, below */

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
    int groups_shown; /* they are what was given out, and stay until the next change */
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

/* obj_read.c. Flushing makes the changes the document's bytes, which are read again. */
extern const edited_format norma_obj_edited;
/* The core's view of positions and faces, without groups. */
norma_mesh norma_obj_mesh(const obj_state *state);

/* Sets group_masks, and hard_edges where masks do not suffice, such that faces
 * of one group other than 0 share edges, and others do not. */
norma_result norma_obj_groups(obj_state *state, const norma_options *options);

/* obj_compute.c, obj_write.c: as format_functions has them. */
norma_document_result norma_obj_compute(norma_document *document,
    const norma_compute_options *options, norma_compute_summary *summary,
    norma_document_error *error);
norma_document_result norma_obj_transform(norma_document *document,
    const norma_transform_options *options, norma_transform_summary *summary,
    norma_document_error *error);
norma_document_result norma_obj_write(norma_document *document, const char *path,
    norma_write *write, void *user, norma_document_error *error);

/* ---- OBJ text, statement by statement and token by token. Lines end in LF, CR LF or CR,
 * in any mix. A backslash before the end of a line joins the next one to the statement, in every
 * statement, but not in a comment (which may well end in the path of a Windows folder). A comment
 * begins at a # where a token could, and ends with its line. */

typedef enum obj_kind {
    OBJ_NOTHING = 0, /* an empty line, a comment */
    OBJ_POSITION,
    OBJ_NORMAL,
    OBJ_FACE,
    OBJ_SMOOTHING,
    OBJ_OBJECT,
    OBJ_REFERRING, /* may name normals by v/vt/vn: surf, curv, l, p */
    OBJ_SURFACE,   /* the same, a free-form surface */
    OBJ_LIBRARY,   /* names files of materials */
    OBJ_OTHER,     /* passed through */
    OBJ_UNKNOWN
} obj_kind;

static inline int norma_obj_is_end(char c) { return c == '\n' || c == '\r'; }
/* A byte 0 too: ZBrush ends its files with one. */
static inline int norma_obj_is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\v' || c == '\f' || c == '\0';
}

/* obj_text.c. All text lies in [p, end). */

const char *norma_obj_skip_joined(const char *p, const char *end);
int norma_obj_is_joined(const char *p, const char *end);
const char *norma_obj_find_statement_end(const char *p, const char *end, norma_watch *watch);
obj_kind norma_obj_look_up_keyword(const char *p, const char *end, const char **rest);

/* Past blanks and joined lines. */
static inline const char *norma_obj_skip_blanks(const char *p, const char *end) {
    p += p < end && *p == ' '; /* nearly always all there is */
    return p < end && (norma_obj_is_blank(*p) || *p == '\\') ? norma_obj_skip_joined(p, end) : p;
}
/* The keyword at p, which is past blanks; *rest: the byte after it. */
static inline obj_kind norma_obj_keyword(const char *p, const char *end, const char **rest) {
    if (p + 1 >= end || p[1] != ' ' || (*p != 'v' && *p != 'f'))
        return norma_obj_look_up_keyword(p, end, rest);
    *rest = p + 1; /* nearly all lines of a file */
    return *p == 'v' ? OBJ_POSITION : OBJ_FACE;
}
/* Where the statement's last line ends: at its line end, or end, also where watch says that it is
 * cancelled. p is a token's place. */
static inline const char *norma_obj_statement_end(
    const char *p, const char *end, norma_watch *watch) {
    return p < end && norma_obj_is_end(*p) ? p : norma_obj_find_statement_end(p, end, watch);
}
/* Past one line end, if there is one at p. */
static inline const char *norma_obj_skip_end(const char *p, const char *end) {
    if (p < end && *p == '\r') return p + 1 < end && p[1] == '\n' ? p + 2 : p + 1;
    return p < end && *p == '\n' ? p + 1 : p;
}
/* Whether p is where a token ends. */
static inline int norma_obj_is_delimiter(const char *p, const char *end) {
    return p >= end || norma_obj_is_blank(*p) || norma_obj_is_end(*p) || *p == '#' ||
           (*p == '\\' && norma_obj_is_joined(p, end));
}
/* The byte after the token at p. */
const char *norma_obj_token_end(const char *p, const char *end);
/* Past what follows a number, which ended at p, in its token. */
const char *norma_obj_number_end(const char *p, const char *end);
/* The number, from 1, of the line that holds the byte at p. */
size_t norma_obj_line(const char *text, const char *p);

/* v, v/vt, v//vn, v/vt/vn; also with empty parts at the end. */
typedef struct obj_corner {
    int64_t position, normal; /* as written */
    int has_normal;
    const char *begin, *end;
    const char
        *texture_end; /* of what stands before the normal's slash: v or v/vt, v where vt is empty */
    int has_texture;
} obj_corner;

/* Whether a corner stands at p, a token's place. */
int norma_obj_corner(const char *p, const char *end, obj_corner *corner);

enum { OBJ_PLAIN_LENGTH = 32 }; /* bytes from p on that norma_obj_read_plain_corner may look at */

/* A corner as nearly all are written: numbers of at most seven digits, and behind them a space or
 * the end of the line. */
typedef struct obj_plain_corner {
    uint32_t position, texture, normal; /* as written; 0 if they are missing, and if they are 0 */
    int has_normal;
    const char *end;
} obj_plain_corner;

/* The number at p and where it ends; NULL: no digit, or eight and more. */
static inline const char *norma_obj_plain_number(const char *p, uint32_t *number) {
#if NORMA_DIGITS_BY_WORD
    const uint64_t bytes = norma_digits_load(p);
    const int digits = norma_digits_count(bytes);
    if (digits == 0 || digits == 8) return NULL;
    *number = (uint32_t)norma_digits_join(bytes, digits);
    return p + digits;
#else
    (void)p, (void)number;
    return NULL;
#endif
}

/* 0: what stands at p, OBJ_PLAIN_LENGTH bytes before the end of the text at least, is something
 * else, or it cannot be told so simply. */
static inline int norma_obj_read_plain_corner(const char *p, obj_plain_corner *corner) {
    corner->texture = corner->normal = 0;
    p = norma_obj_plain_number(p, &corner->position);
    const int has_texture = p && *p == '/' && p[1] != '/';
    if (has_texture) p = norma_obj_plain_number(p + 1, &corner->texture);
    corner->has_normal = p && *p == '/';
    if (corner->has_normal) p = norma_obj_plain_number(p + (has_texture ? 1 : 2), &corner->normal);
    if (!p) return 0;
    corner->end = p;
    return *p == ' ' || norma_obj_is_end(*p);
}

/* The number, from 0, that an index as written means where count elements stand before it;
 * UINT32_MAX: none (0, or before the first). Whether it is below the final count, which is at most
 * UINT32_MAX - 2, the caller sees. */
static inline uint32_t norma_obj_resolve(int64_t index, size_t count) {
    if (index > 0)
        return index <= (int64_t)(UINT32_MAX - 2) ? (uint32_t)(index - 1) : UINT32_MAX - 2;
    return index < 0 && -(index + 1) < (int64_t)count ? (uint32_t)((int64_t)count + index)
                                                      : UINT32_MAX;
}

/* ---- What one stretch of an OBJ's text holds, counted from its own beginning.
 * obj_text.c reads such a stretch; obj_read.c asks for all of them, and puts them together. */

typedef enum obj_list { OBJ_OF_CORNER, OBJ_OF_CORNER_NORMAL, OBJ_OF_OTHER_NORMAL } obj_list;

/* A number that counts back from what stands before it, here in the text of the part: value is
 * counted from the part's beginning, and may lie before that. */
typedef struct obj_relative {
    obj_list list;
    size_t slot;
    int64_t value;
} obj_relative;

/* Things that get a note: how many there are, and where the first is. */
typedef struct obj_oddity {
    size_t count;
    const char *first;
} obj_oddity;

typedef struct obj_part {
    const char *text, *begin,
        *end;  /* text: all of it; the part is begin to end, whole statements */
    int whole; /* it is all of the text: numbers that count back are known at once */

    double *positions; /* three each */
    uint32_t *corners, *corner_normals, *face_ends, *other_normals;
    float *normals; /* three each */
    size_t *normal_offsets;
    obj_run *runs; /* one for each smoothing statement */
    obj_relative *relatives;
    size_t position_count, corner_count, face_count, normal_count, other_count, run_count,
        relative_count;
    size_t position_room, corner_room, corner_normal_room, face_room, normal_room,
        normal_offset_room, other_room, run_room, relative_room;

    uint32_t last_position,
        last_normal; /* the greatest that faces name, of those that do not count back */
    size_t bad_normal_count;
    const char *name, *name_end;        /* of the first object; NULL: none */
    size_t first_library, last_library; /* as obj_state has them */
    size_t first_normal, first_face;    /* where the first such statement begins; SIZE_MAX: there is
                                           none */
    int names_normals, has_normals, has_surfaces,
        has_polygons;       /* polygons: faces of other than three corners */
    int has_long_positions; /* as obj_state has it */
    int known;              /* some statement was OBJ's */
    obj_oddity unknown, empty_face, odd_number;
    norma_document_result result;
} obj_part;

/* Reads the statements of the part, from nothing; what it holds from before is used as room. error
 * may be NULL; the result is also the part's. */
norma_document_result norma_obj_read_part(
    const norma_document *document, obj_part *part, norma_document_error *error);
void norma_obj_free_part(obj_part *part);

/* Where the statement ends that holds the byte at from, or one soon behind it: its line's end
 * included; end, where it is cancelled. */
const char *norma_obj_part_end(
    const char *text, const char *from, const char *end, norma_watch *watch);

/* ---- V lines that go and come, as a change that the writer makes. Internal to obj_*.c. */

#define OBJ_NO_VERTEX UINT32_MAX

struct obj_vertices {
    size_t *kept_before;  /* of each old position, and the end: how many before it stay */
    uint32_t *numbers;    /* of each old position the number, from 0, that names it in the file;
                             OBJ_NO_VERTEX: none */
    uint32_t *corners;    /* the same of each corner of the faces */
    size_t face, added;   /* before this face so many are put in */
    unsigned char *lines; /* which are these lines */
    size_t lines_size;
};

norma_document_result norma_obj_equal_vertices(
    norma_document *document, size_t mesh, uint32_t *first, norma_document_error *error);
norma_document_result norma_obj_edit_vertices(
    norma_document *document, const norma_mesh_edit *edit, norma_document_error *error);

/* ---- Faces by the names of their object, groups and material. */

typedef int obj_asks_name(void *user, const char *name);

/* marks: of each face, set where asks returns nonzero for one of its names. 0: out of memory. */
int norma_obj_mark_faces(
    const norma_document *document, obj_asks_name *asks, void *user, uint8_t *marks);
#endif
