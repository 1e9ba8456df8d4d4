/* used_texels.c: the texels whose centres lie in a face's triangle of texture coordinates, scaled,
 * turned and moved as KHR_texture_transform says, and wrapped as the sampler says; and the one in
 * each triangle's middle, however small it is. */
#include "check/maps/maps.h"
#include <math.h>
#include <stdlib.h>

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

static void fill(const map_mask *mask, size_t row, size_t begin, size_t end) {
    uint64_t *bits = mask->bits + row * mask->words;
    for (size_t word = begin / 64; word * 64 < end; ++word) {
        const size_t from = word * 64 > begin ? 0 : begin - word * 64,
                     to = end - word * 64 < 64 ? end - word * 64 : 64;
        bits[word] |= low_bits(to) & ~low_bits(from);
    }
}

static void fill_texels(const painter *p, size_t row, size_t begin, size_t end) {
    fill(p->mask, row, norma_map_kept(p->texels, begin), norma_map_kept(p->texels, end));
}

static size_t clamped(int64_t x, size_t length) {
    return x < 0 ? 0 : (uint64_t)x >= length ? length - 1 : (size_t)x;
}

/* From begin to before end, of one repetition; mirrored ones the other way round. */
static void fill_repeated(const painter *p, size_t row, int64_t begin, int64_t end) {
    const int64_t width = (int64_t)p->texels->width;
    while (begin < end) {
        const int64_t tile = begin / width - (begin % width < 0), first = begin - tile * width,
                      last = end - tile * width < width ? end - tile * width : width;
        if (p->wrap[0] == MIRROR && tile % 2 != 0)
            fill_texels(p, row, (size_t)(width - last), (size_t)(width - first));
        else
            fill_texels(p, row, (size_t)first, (size_t)last);
        begin = tile * width + last;
    }
}

static void paint_row(const painter *p, size_t row, int64_t begin, int64_t end) {
    const size_t width = p->texels->width;
    if (begin >= end) return;
    if (p->wrap[0] == CLAMP)
        fill_texels(p, row, clamped(begin, width), clamped(end - 1, width) + 1);
    else if (end - begin >= 2 * (int64_t)width)
        fill_texels(p, row, 0, width);
    else
        fill_repeated(p, row, begin, end);
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
    return norma_map_keeps(p->texels, row) ? norma_map_kept(p->texels, row) : SIZE_MAX;
}

/* ---- one triangle, in texels */

/* Where the row's middle line is inside: between the two edges that cross it. */
static void cross(const double t[3][2], double y, double span[2]) {
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
    const int64_t begin = (int64_t)ceil(low - .5), end = (int64_t)ceil(high - .5);
    paint_middle(p, t);
    for (int64_t y = begin; y < end && p->rows_left; ++y) {
        const size_t row = row_of(p, y);
        double span[2];
        --p->rows_left;
        if (row == SIZE_MAX) continue;
        cross(t, (double)y + .5, span);
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
int norma_map_mask(
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
