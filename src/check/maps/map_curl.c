/* map_curl.c: whether normals are the slopes of a height field. Those of heights h over columns i
 * and rows j (downwards) are x/z = -dh/di and y/z = dh/dj, so d(x/z)/dj = -d(y/z)/di. With the
 * green channel turned both are equal. A chart that is turned or mirrored on the surface has its
 * normals in the image's own frame all the same. Flat and striped maps have no mixed derivatives,
 * and rounding gives them either sign as often. Slopes are whole numbers, so that their sums are
 * the same in any order. */
#include "check/maps/maps.h"
#include <stdlib.h>

enum {
    UNIT = 1 << 20,       /* a slope of 1 */
    NOT_USED = 1 << 28,   /* in place of a slope */
    STEEPEST = 77,        /* 255 z; beyond, rounding makes large errors in slopes */
    ROUNDING = UNIT / 110 /* of a difference of two texels' slopes */
};

typedef struct slopes {
    size_t columns, rows;
    int32_t *x, *y;
} slopes;

typedef struct ballot { /* of one level */
    int32_t least;      /* what may be rounding */
    int64_t agreement, whole, votes;
} ballot;

/* Of neighbours, across: x one row further down; along: y one column further right. |across +
 * along| is the curl as it is, |across - along| that with the green turned: their difference, and
 * their sum. apart: every fourth neighbour is far away. */
static void vote_row(ballot *b, const slopes *s, const int32_t *below_x, int apart) {
    int64_t agreement = 0, whole = 0, votes = 0;
    for (size_t i = 0; i + 1 < s->columns; ++i) {
        const int32_t across = below_x[i] - s->x[i], along = s->y[i + 1] - s->y[i],
                      turned = abs(across - along), as_is = abs(across + along);
        const int counts = turned + as_is > 2 * b->least && turned + as_is < NOT_USED &&
                           !(apart && i % MAP_BLOCK + 1 == MAP_BLOCK);
        agreement += counts ? turned - as_is : 0;
        whole += counts ? turned + as_is : 0;
        votes += counts;
    }
    b->agreement += agreement;
    b->whole += whole;
    b->votes += votes;
}

/* ---- texels */

typedef struct inverses {
    int32_t of[256]; /* UNIT / z, z as it is stored; 0: too steep */
} inverses;

static void make_inverses(inverses *inverse) {
    for (int c = 0; c < 256; ++c)
        inverse->of[c] = 2 * c - 255 < STEEPEST ? 0 : UNIT / (2 * c - 255);
}

static void slopes_of_row(const map_texels *texels, const map_mask *mask, const inverses *inverse,
    size_t y, const slopes *out) {
    const uint8_t *c = texels->colors + 3 * y * texels->columns;
    for (size_t x = 0; x < texels->columns; ++x, c += 3) {
        const int32_t over = norma_map_used(mask, x, y) ? inverse->of[c[2]] : 0;
        out->x[x] = over ? (2 * c[0] - 255) * over : NOT_USED;
        out->y[x] = over ? (2 * c[1] - 255) * over : NOT_USED;
    }
}

/* Of a row of blocks the sums, in it one row of texels after the other. */
static void add_to_blocks(const slopes *row, const slopes *blocks, size_t y) {
    const size_t at = y / MAP_BLOCK * blocks->columns;
    for (size_t i = 0; i < blocks->columns * MAP_BLOCK; ++i) {
        int32_t *x = &blocks->x[at + i / MAP_BLOCK], *v = &blocks->y[at + i / MAP_BLOCK];
        const int used = row->x[i] != NOT_USED && *x != NOT_USED;
        *x = used ? *x + row->x[i] / (MAP_BLOCK * MAP_BLOCK) : NOT_USED;
        *v = used ? *v + row->y[i] / (MAP_BLOCK * MAP_BLOCK) : NOT_USED;
    }
}

/* two: memory for two rows. */
static void vote_texels(const map_texels *texels, const map_mask *mask, slopes two[2],
    const slopes *blocks, ballot *b) {
    inverses inverse;
    make_inverses(&inverse);
    for (size_t y = 0; y < texels->rows; ++y) {
        const slopes *above = &two[(y + 1) % 2], *row = &two[y % 2];
        slopes_of_row(texels, mask, &inverse, y, row);
        if (y / MAP_BLOCK < blocks->rows) add_to_blocks(row, blocks, y);
        if (y > 0 && (texels->step == 1 || y % MAP_BLOCK != 0))
            vote_row(b, above, row->x, texels->step > 1);
    }
}

/* ---- means */

static void vote_means(const slopes *s, ballot *b) {
    for (size_t y = 0; y + 1 < s->rows; ++y) {
        const size_t at = y * s->columns;
        const slopes row = {s->columns, 1, s->x + at, s->y + at};
        vote_row(b, &row, s->x + at + s->columns, 0);
    }
}

static int32_t mean(const int32_t *at, size_t columns) {
    const int32_t of[4] = {at[0], at[1], at[columns], at[columns + 1]};
    int used = 1;
    for (size_t k = 0; k < 4; ++k) used &= of[k] != NOT_USED;
    return used ? (of[0] + of[1] + of[2] + of[3]) / 4 : NOT_USED;
}

/* In place: what is written was read. */
static void halve(slopes *s) {
    const size_t columns = s->columns;
    s->columns /= 2;
    s->rows /= 2;
    for (size_t y = 0; y < s->rows; ++y)
        for (size_t x = 0; x < s->columns; ++x) {
            const size_t from = 2 * y * columns + 2 * x, to = y * s->columns + x;
            s->x[to] = mean(s->x + from, columns);
            s->y[to] = mean(s->y + from, columns);
        }
}

static void count(map_curl *curl, size_t level, const ballot *b) {
    curl->votes[level] = (size_t)b->votes;
    curl->agreement[level] = b->whole ? (double)b->agreement / (double)b->whole : 0;
}

int norma_map_curl(const map_texels *texels, const map_mask *mask, map_curl *curl) {
    const size_t columns = texels->columns;
    slopes means = {.columns = columns / MAP_BLOCK, .rows = texels->rows / MAP_BLOCK};
    const size_t blocks = means.columns * means.rows;
    int32_t *memory = calloc(4 * columns + 2 * blocks + 1, sizeof *memory);
    slopes two[2] = {{columns, 1, memory, memory + columns},
        {columns, 1, memory + 2 * columns, memory + 3 * columns}};
    ballot first = {.least = ROUNDING};
    *curl = (map_curl){{0}, {0}};
    if (!memory) return 0;
    means.x = memory + 4 * columns;
    means.y = means.x + blocks;
    vote_texels(texels, mask, two, &means, &first);
    count(curl, 0, &first);
    for (size_t level = 1; level < MAP_LEVELS; ++level, halve(&means)) {
        ballot next = {.least = ROUNDING / 2};
        vote_means(&means, &next);
        count(curl, level, &next);
    }
    free(memory);
    return 1;
}
