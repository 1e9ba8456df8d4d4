/* text_stretch.h: what one stretch of an OBJ's text holds, counted from its own beginning.
 * read_stretch.c reads one, read_parallel.c puts them together. */
#ifndef NORMA_IO_OBJ_PART_H
#define NORMA_IO_OBJ_PART_H
#include "io/obj/obj.h"

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
#endif
