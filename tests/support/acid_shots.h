/* acid_shots.h: screenshots of an acid scene without a renderer: patches shaded from the normals of
 * a height field in closed form, distorted as engines, browsers and people distort pictures. */
#ifndef NORMA_TESTS_ACID_SHOTS_H
#define NORMA_TESTS_ACID_SHOTS_H
#include "acid/acid.h"

enum { ACID_CURVES = 4 };
extern const char *const acid_curve_names[ACID_CURVES];

/* What a cell's subject shows instead of its reference number 0 ("right"), 1, 2, ... */
enum {
    ACID_SHOWS_NOTHING = -1,
    ACID_SHOWS_OTHER = -2
}; /* OTHER: a mistake that no reference has */

typedef struct acid_shot {
    size_t width, height;
    double corners[4][2]; /* of the unit square, in pixels, clockwise from the upper left */
    int curve;            /* of acid_curve_names */
    double exposure, gamma, environment;
    int quality; /* of a JPEG in between; 0: none */
    int antialias;
    int background;  /* 0 to 4: black, white, grey, a sky, blue */
    int marks_toned; /* unlit colours go through the tone curve as well */
    double noise;    /* of a level's 255, uniform */
    uint32_t seed;   /* of the noise */
    int shows[ACID_MOST_CELLS];
} acid_shot;

/* Rows and mistakes as ACID's table has them; the caller frees layout->rows. */
int acid_shots_layout(acid_layout *layout);

/* Whether a mistake that is shown can be named: not so sign-kept, as other mistakes look the same,
 * unless tangent-sign shows that they are not made; nor scale-on-z, unless it shows a normal map;
 * nor that nothing is drawn where a mistake may give the background's color. */
int acid_shot_can_name(const acid_shot *shot, const acid_layout *layout, size_t row);

/* A shot of that number: its size, place, curve and all else follow from the number alone. */
void acid_shot_choose(acid_shot *shot, const acid_layout *layout, uint32_t number);

/* picture->pixels is the caller's to free. 0: out of memory. */
int acid_shot_take(const acid_shot *shot, const acid_layout *layout, acid_picture *picture);
#endif
