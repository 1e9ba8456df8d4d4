/* acid_judge.h: reads a picture that a renderer made of the acid scene: where its patches lie, and
 * which of its references each subject looks like. */
#ifndef NORMA_ACID_JUDGE_H
#define NORMA_ACID_JUDGE_H
#include "io/image/image.h"
#include <stddef.h>
#include <stdint.h>

/* ---- where things lie in the scene: the unit square of its picture, x to the right, y downwards
 */

enum { ACID_MARKS = 4, ACID_MOST_REFERENCES = 8, ACID_MOST_CELLS = 256, ACID_ID_ROOM = 40 };

typedef struct acid_box {
    double center[2], size[2];
} acid_box;

typedef struct acid_place { /* of a reference */
    char id[ACID_ID_ROOM];  /* "right", or the mistake that it shows */
    acid_box box;
} acid_place;

typedef struct acid_row { /* a cell */
    char id[ACID_ID_ROOM];
    acid_box subject;
    acid_place references[ACID_MOST_REFERENCES]; /* "right" is the first */
    size_t reference_count;
    int skipped; /* an extension that it needs is not there */
} acid_row;

typedef struct acid_layout {
    acid_box marks[ACID_MARKS]; /* red, green, blue, yellow */
    acid_row *rows;
    size_t row_count;
} acid_layout;

/* ---- pictures */

typedef struct acid_picture {
    size_t width, height;
    uint8_t *pixels; /* red, green and blue, eight bits each; to be freed */
} acid_picture;

/* A PNG or JPEG; what is transparent becomes darker, as over black. pixels: NULL after a failure.
 */
image_result acid_read_picture(const unsigned char *bytes, size_t size, acid_picture *picture);

/* What is wrong, if it was not read. */
const char *acid_picture_text(image_result result);
/* As a PNG; its bytes are the caller's to free in any case. 0: out of memory. */
int acid_write_picture(const acid_picture *picture, growing_bytes *png);

/* ---- registration */

typedef struct acid_map { /* a homography from the unit square to pixels, row by row; the first
                             pixel's middle is (0.5, 0.5) */
    double m[9];
} acid_map;

void acid_map_point(const acid_map *map, const double unit[2], double pixel[2]);

/* Looks for four uniform spots of the marks' hues which lie, and are as large, as the layout says.
 * 1: found; 0: not found; -1: out of memory. */
int acid_find_marks(const acid_picture *picture, const acid_layout *layout, acid_map *map);

/* ---- verdicts */

typedef enum acid_verdict {
    ACID_PASS,
    ACID_FAIL,
    ACID_UNCLEAR,
    ACID_MISSING,
    ACID_SKIPPED,
    ACID_VERDICTS
} acid_verdict;

typedef enum acid_reason { /* of ACID_UNCLEAR, and of a control that fails */
    ACID_REASON_NONE,
    ACID_REASON_CONTROL,   /* the control failed: nothing in the picture can be trusted */
    ACID_REASON_OUTSIDE,   /* a patch lies outside the picture */
    ACID_REASON_SMALL,     /* patches have too few pixels */
    ACID_REASON_NOT_DRAWN, /* the right reference is not drawn */
    ACID_REASON_ALIKE,     /* the references differ by no more than the picture's noise */
    ACID_REASON_BETWEEN,   /* the nearest two are about as near */
    ACID_REASON_FAR,       /* nothing is near, or not everywhere */
    ACID_REASON_HIDDEN,    /* drawn in the ground's colour, or not at all */
    ACID_REASON_NO_RELIEF, /* no normal map looks much the same, and no cell shows one */
    ACID_REASON_ELSEWHERE  /* other mistakes look the same here; the cell in which they do not does
                              not pass */
} acid_reason;

typedef struct acid_finding {
    acid_verdict verdict;
    acid_reason reason;
    int nearest; /* the reference that is nearest, -1: none was compared; of ACID_FAIL: the mistake,
                    or -1 where the control fails */
    double distances[ACID_MOST_REFERENCES]; /* root mean square of colours from 0 to 1 */
    double apart; /* of the nearest reference and the one that is most like it */
} acid_finding;

typedef struct acid_judgement {
    acid_finding *findings; /* of each row; to be freed */
    double noise;           /* distance between the control and its reference; 0: no control */
    size_t counts[ACID_VERDICTS];
} acid_judgement;

/* 0: out of memory. */
int acid_judge(const acid_picture *picture, const acid_layout *layout, const acid_map *map,
    acid_judgement *judgement);

/* Frames each subject by its verdict: green, red, or grey. */
void acid_frame(acid_picture *picture, const acid_layout *layout, const acid_map *map,
    const acid_judgement *judgement);
#endif
