/* The rules that look into normal maps: N811, N812. An image is read once for all
 * primitives that show it; of its texels those count that faces use. */
#include "check/rules/rules.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- The texels of a normal map as far as they are looked at. */

/* How many kept columns (rows) lie before x. */
static size_t count_kept_before(const map_texels *texels, size_t x) {
    const size_t cell = MAP_BLOCK * texels->step, within = x % cell;
    return x / cell * MAP_BLOCK + (within < MAP_BLOCK ? within : MAP_BLOCK);
}
static int keeps_texel(const map_texels *texels, size_t x) {
    return x % (MAP_BLOCK * texels->step) < MAP_BLOCK;
}

enum { MOST_TEXELS = 1 << 20, FEWEST_TEXELS = 1 << 12, OF_SMALL_FILE = 1 << 17 };

static int begin_texels(void *user, size_t width, size_t height) {
    map_texels *texels = user;
    texels->width = width;
    texels->height = height;
    for (texels->step = 1;; ++texels->step) {
        texels->columns = count_kept_before(texels, width);
        texels->rows = count_kept_before(texels, height);
        if (texels->columns * texels->rows <= texels->most) break;
    }
    texels->colors = malloc(3 * texels->columns * texels->rows + 1);
    return texels->colors != NULL;
}

static void keep_row(void *user, size_t y, const uint8_t *pixels) {
    const map_texels *texels = user;
    if (!keeps_texel(texels, y)) return;
    uint8_t *out = texels->colors + 3 * texels->columns * count_kept_before(texels, y);
    const size_t cell = texels->step == 1 ? texels->width : MAP_BLOCK * texels->step,
                 block = texels->step == 1 ? texels->width : MAP_BLOCK;
    for (size_t x = 0; x < texels->width; x += cell) {
        const size_t count = texels->width - x < block ? texels->width - x : block;
        memcpy(out, pixels + 3 * x, 3 * count);
        out += 3 * count;
    }
}

static size_t lesser_size(size_t a, size_t b) { return a < b ? a : b; }

/* A small file has a small image, or says the same thing everywhere. */
image_result norma_map_read(const norma_texture_info *map, size_t meshes, map_texels *texels) {
    const size_t share = 4 * (size_t)MOST_TEXELS / meshes;
    *texels = (map_texels){
        .most = lesser_size(MOST_TEXELS, lesser_size(OF_SMALL_FILE + 32 * map->size,
                                             share > FEWEST_TEXELS ? share : FEWEST_TEXELS))};
    const image_sink sink = {3, begin_texels, keep_row, texels};
    const image_result result = norma_image_read(map->bytes, map->size, &sink);
    if (result) norma_map_free(texels);
    return result;
}

void norma_map_free(map_texels *texels) {
    free(texels->colors);
    texels->colors = NULL;
}

/* ---- The texels whose centres lie in a face's triangle of texture coordinates, scaled,
 * turned and moved as KHR_texture_transform says, and wrapped as the sampler says; and the one in
 * each triangle's middle, however small it is. */

typedef struct map_mask {
    uint64_t *bits; /* rows of words */
    size_t words;   /* in a row */
} map_mask;

static int uses_texel(const map_mask *mask, size_t column, size_t row) {
    return (int)(mask->bits[row * mask->words + column / 64] >> (column % 64) & 1);
}

enum { CLAMP = 33071, MIRROR = 33648, MOST_TRIANGLES = 1 << 18 };
static const double FARTHEST = 1e9; /* texels from the origin; beyond, floats say nothing */

typedef struct painter {
    const check_mesh *m;
    const map_texels *texels;
    map_mask *mask;
    double turn[4], offset[2];
    int wrap[2];
    size_t rows_left; /* that may be painted: a face can repeat a map a million times */
} painter;

/* ---- one row */

static uint64_t low_bits(size_t count) { return count ? ~(uint64_t)0 >> (64 - count) : 0; }

static void fill(const map_mask *mask, size_t row, size_t begin_texels, size_t end) {
    uint64_t *bits = mask->bits + row * mask->words;
    for (size_t word = begin_texels / 64; word * 64 < end; ++word) {
        const size_t from = word * 64 > begin_texels ? 0 : begin_texels - word * 64,
                     to = end - word * 64 < 64 ? end - word * 64 : 64;
        bits[word] |= low_bits(to) & ~low_bits(from);
    }
}

static void fill_texels(const painter *p, size_t row, size_t begin_texels, size_t end) {
    fill(p->mask, row, count_kept_before(p->texels, begin_texels),
        count_kept_before(p->texels, end));
}

static size_t clamped(int64_t x, size_t length) {
    return x < 0 ? 0 : (uint64_t)x >= length ? length - 1 : (size_t)x;
}

/* From begin to before end, of one repetition; mirrored ones the other way round. */
static void fill_repeated(const painter *p, size_t row, int64_t begin_texels, int64_t end) {
    const int64_t width = (int64_t)p->texels->width;
    while (begin_texels < end) {
        const int64_t tile = begin_texels / width - (begin_texels % width < 0),
                      first = begin_texels - tile * width,
                      last = end - tile * width < width ? end - tile * width : width;
        if (p->wrap[0] == MIRROR && tile % 2 != 0)
            fill_texels(p, row, (size_t)(width - last), (size_t)(width - first));
        else
            fill_texels(p, row, (size_t)first, (size_t)last);
        begin_texels = tile * width + last;
    }
}

static void paint_row(const painter *p, size_t row, int64_t begin_texels, int64_t end) {
    const size_t width = p->texels->width;
    if (begin_texels >= end) return;
    if (p->wrap[0] == CLAMP)
        fill_texels(p, row, clamped(begin_texels, width), clamped(end - 1, width) + 1);
    else if (end - begin_texels >= 2 * (int64_t)width)
        fill_texels(p, row, 0, width);
    else
        fill_repeated(p, row, begin_texels, end);
}

/* Which row of the image it is; SIZE_MAX: one that is not kept. */
static size_t row_of(const painter *p, int64_t y) {
    const int64_t height = (int64_t)p->texels->height;
    size_t row = 0;
    if (p->wrap[1] == CLAMP) {
        row = clamped(y, p->texels->height);
    } else {
        const int64_t tile = y / height - (y % height < 0), within = y - tile * height;
        row = (size_t)(p->wrap[1] == MIRROR && tile % 2 != 0 ? height - 1 - within : within);
    }
    return keeps_texel(p->texels, row) ? count_kept_before(p->texels, row) : SIZE_MAX;
}

/* ---- one triangle, in texels */

/* Where the row's middle line is inside: between the two edges that cross it. */
static void cross_row(const double t[3][2], double y, double span[2]) {
    span[0] = INFINITY, span[1] = -INFINITY;
    for (int k = 0; k < 3; ++k) {
        const double *a = t[k], *b = t[(k + 1) % 3];
        if ((a[1] <= y) == (b[1] <= y)) continue;
        const double x = a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]));
        span[0] = x < span[0] ? x : span[0];
        span[1] = x > span[1] ? x : span[1];
    }
}

static void paint_middle(const painter *p, const double t[3][2]) {
    const int64_t x = (int64_t)floor((t[0][0] + t[1][0] + t[2][0]) / 3);
    const size_t row = row_of(p, (int64_t)floor((t[0][1] + t[1][1] + t[2][1]) / 3));
    if (row != SIZE_MAX) paint_row(p, row, x, x + 1);
}

static void paint_triangle(painter *p, const double t[3][2]) {
    const double low = fmin(t[0][1], fmin(t[1][1], t[2][1])),
                 high = fmax(t[0][1], fmax(t[1][1], t[2][1]));
    const int64_t begin_texels = (int64_t)ceil(low - .5), end = (int64_t)ceil(high - .5);
    paint_middle(p, t);
    for (int64_t y = begin_texels; y < end && p->rows_left; ++y) {
        const size_t row = row_of(p, y);
        double span[2];
        --p->rows_left;
        if (row == SIZE_MAX) continue;
        cross_row(t, (double)y + .5, span);
        if (span[0] <= span[1])
            paint_row(p, row, (int64_t)ceil(span[0] - .5), (int64_t)ceil(span[1] - .5));
    }
}

/* 0: not finite, or too far away. */
static int place_corner(const painter *p, size_t vertex, double out[2]) {
    const float *uv = p->m->given->attributes.texcoords + 2 * vertex;
    const double u = (double)uv[0], v = (double)uv[1];
    out[0] = (p->turn[0] * u + p->turn[1] * v + p->offset[0]) * (double)p->texels->width;
    out[1] = (p->turn[2] * u + p->turn[3] * v + p->offset[1]) * (double)p->texels->height;
    return fabs(out[0]) < FARTHEST && fabs(out[1]) < FARTHEST;
}

static void paint_face(painter *p, size_t face) {
    double t[3][2];
    for (size_t k = 0; k < 3; ++k) {
        const size_t vertex = norma_core_corner(&p->m->mesh, 3 * face + k);
        if (vertex >= p->m->given->attributes.texcoord_count || !place_corner(p, vertex, t[k]))
            return;
    }
    paint_triangle(p, (const double(*)[2])t);
}

/* Of many faces every second, third, ... is as good as all. */
static int make_mask(
    const check_mesh *m, const norma_texture_info *map, const map_texels *texels, map_mask *mask) {
    static const float not_turned[4] = {1, 0, 0, 1};
    const float *given = m->given->material.normal_turn,
                *turn = given[0] != 0 || given[1] != 0 || given[2] != 0 || given[3] != 0
                            ? given
                            : not_turned;
    painter p = {.m = m,
        .texels = texels,
        .mask = mask,
        .turn = {(double)turn[0], (double)turn[1], (double)turn[2], (double)turn[3]},
        .offset = {(double)map->offset[0], (double)map->offset[1]},
        .wrap = {map->wrap_s, map->wrap_t},
        .rows_left = 4 * texels->most};
    mask->words = texels->columns / 64 + 1;
    mask->bits = calloc(mask->words * texels->rows + 1, sizeof *mask->bits);
    if (!mask->bits) return 0;
    const size_t step = m->mesh.face_count / MOST_TRIANGLES + 1;
    for (size_t face = 0; face < m->mesh.face_count; face += step) paint_face(&p, face);
    return 1;
}

/* ---- Whether the texels that are used are unit vectors, and whether they differ at
 * all. A channel of c is the number 2 c / 255 - 1. */

typedef struct map_lengths {
    size_t used, bad;
    uint8_t first[3]; /* of the used ones */
    int one_value;
} map_lengths;

/* Longer or shorter than 1 by more than a tenth, or below the surface by more than rounding. */
static int is_bad(const uint8_t c[3]) {
    const int x = 2 * c[0] - 255, y = 2 * c[1] - 255, z = 2 * c[2] - 255,
              square = x * x + y * y + z * z;
    return z < -1 || square * 100 < 81 * 255 * 255 || square * 100 > 121 * 255 * 255;
}

static void add_row(const uint8_t *row, const uint64_t *bits, size_t columns, map_lengths *sum) {
    for (size_t x = 0; x < columns; ++x) {
        if (!bits[x / 64]) {
            x |= 63;
            continue;
        }
        const uint8_t *c = row + 3 * x;
        if (!(bits[x / 64] >> (x % 64) & 1)) continue;
        if (sum->used++ == 0) memcpy(sum->first, c, 3);
        sum->bad += (size_t)is_bad(c);
        sum->one_value &= memcmp(c, sum->first, 3) == 0;
    }
}

static void find_lengths(const map_texels *texels, const map_mask *mask, map_lengths *lengths) {
    *lengths = (map_lengths){.one_value = 1};
    for (size_t y = 0; y < texels->rows; ++y)
        add_row(texels->colors + 3 * texels->columns * y, mask->bits + y * mask->words,
            texels->columns, lengths);
}

/* ---- Whether normals are the slopes of a height field. Those of heights h over columns i
 * and rows j (downwards) are x/z = -dh/di and y/z = dh/dj, so d(x/z)/dj = -d(y/z)/di. With the
 * green channel turned both are equal. A chart that is turned or mirrored on the surface has its
 * normals in the image's own frame all the same. Flat and striped maps have no mixed derivatives,
 * and rounding gives them either sign as often. Slopes are whole numbers, so that their sums are
 * the same in any order. */

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

/* Of a height field's slopes the two mixed derivatives are equal. agreement: 1 where they are equal
 * everywhere, -1 where they are opposite, as turning the green channel makes them, and 0 where
 * they say nothing. Level 0 compares neighbouring texels, the others means of 4 x 4, 8 x 8, ... */
enum { MAP_LEVELS = 8 };
typedef struct map_curl {
    double agreement[MAP_LEVELS];
    size_t votes[MAP_LEVELS];
} map_curl;

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
        const int32_t over = uses_texel(mask, x, y) ? inverse->of[c[2]] : 0;
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

/* 0: memory */
static int find_curl(const map_texels *texels, const map_mask *mask, map_curl *curl) {
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

/* ---- What the texels that a mesh uses say of its normal map: N811, N812. */

static const double MOST_BAD = .05;
enum { FEW_TEXELS = 16 };

/* what: "the normal map NAME: " goes in front of it. */
static norma_result add_map_finding(
    check_mesh *m, const norma_texture_info *map, check_rule rule, double value, const char *what) {
    check_hits one = {0};
    char message[CHECK_MESSAGE];
    norma_check_message(message, map->name ? "normal map \"%s\": %s" : "normal map: %s%s",
        map->name ? map->name : "", what);
    norma_check_hit(m->run, &one, value, CHECK_NOWHERE);
    return norma_check_report(m,
        &(check_finding){.rule = rule,
            .severity = NORMA_SEVERITY_WARNING,
            .unit = rule == RULE_N811 ? "%" : "",
            .hits = &one},
        "%s", message);
}

/* ---- N811 */

/* An exporter's placeholder that says nothing wrong, also as JPEG gives it back. */
static int is_flat(const uint8_t c[3]) {
    return (c[0] == 127 || c[0] == 128) && (c[1] == 127 || c[1] == 128) && c[2] >= 254;
}

static double bad_share(const map_lengths *l) {
    return l->used ? (double)l->bad / (double)l->used : 0;
}

static norma_result tell_lengths(
    check_mesh *m, const norma_texture_info *map, const map_texels *texels, const map_lengths *l) {
    char message[CHECK_MESSAGE];
    const size_t all = texels->columns * texels->rows;
    const double percent = 100 * bad_share(l);
    if (l->used && l->one_value && (l->used >= FEW_TEXELS || l->used == all)) {
        if (is_flat(l->first)) return NORMA_OK;
        norma_check_message(message,
            "all texels that faces use are (%z, %z, %z); one value throughout turns every normal "
            "by the same angle",
            (size_t)l->first[0], (size_t)l->first[1], (size_t)l->first[2]);
    } else if (bad_share(l) > MOST_BAD) {
        norma_check_message(message,
            "no map of normals, or one that was resized or compressed without making them unit "
            "vectors again: %g %% of the texels that faces use are not unit vectors above the "
            "surface",
            percent);
    } else {
        return NORMA_OK;
    }
    return add_map_finding(m, map, RULE_N811, percent, message);
}

/* ---- N812 */

/* Agreement is positive if the slopes of the map fit one height field, and negative if they would
 * fit with green inverted. Measured on maps known to be right: .35 to .65 between neighbouring
 * texels, .2 to .35 between blocks of texels; the same maps with green inverted give the same
 * numbers below zero. Maps that come from no height field stay within .1, except that compression
 * can shift one level. So a map counts as inverted if two consecutive levels are negative and no
 * level is positive beyond .1. */
static const double TURNED = -.2, CONFIRMED = -.1, AS_IS = .1;
enum { FEW_VOTES = 256, FEW_TO_CONFIRM = 64, LAST_LEVEL = 4 };

static int is_turned(const map_curl *curl, double *agreement) {
    *agreement = 0;
    for (size_t level = 0; level <= LAST_LEVEL; ++level) {
        const double here = curl->agreement[level], coarser = curl->agreement[level + 1];
        if (curl->votes[level] < FEW_VOTES) continue;
        if (here > AS_IS) return 0;
        if (curl->votes[level + 1] < FEW_TO_CONFIRM || coarser > CONFIRMED) continue;
        if (here < *agreement) *agreement = here;
    }
    return *agreement < TURNED;
}

static norma_result judge_curl(
    check_mesh *m, const norma_texture_info *map, const map_texels *texels, const map_mask *mask) {
    map_curl curl;
    double agreement;
    if (!find_curl(texels, mask, &curl)) return NORMA_ERROR_MEMORY;
    if (!is_turned(&curl, &agreement)) return NORMA_OK;
    return add_map_finding(m, map, RULE_N812, -agreement,
        "bumps look like dents in light from above; it fits a surface only with its green channel "
        "inverted, so it was made for the other convention (DirectX)");
}

norma_result norma_check_map(
    check_mesh *m, const norma_texture_info *map, const map_texels *texels) {
    map_mask mask;
    map_lengths lengths;
    norma_result result = NORMA_OK;
    if (!norma_check_wants_any(m, RULE_N811, RULE_N812)) return NORMA_OK;
    if (!make_mask(m, map, texels, &mask)) return NORMA_ERROR_MEMORY;
    find_lengths(texels, &mask, &lengths);
    if (norma_check_wants(m, RULE_N811)) result = tell_lengths(m, map, texels, &lengths);
    const int are_normals = bad_share(&lengths) <= MOST_BAD; /* else they decide nothing */
    if (!result && are_normals && norma_check_wants(m, RULE_N812))
        result = judge_curl(m, map, texels, &mask);
    free(mask.bits);
    return result;
}
