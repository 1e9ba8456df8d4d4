/* made.c: meshes made by additions, multiplications, divisions and square roots alone, which IEEE
 * 754 rounds in one way. Between them they have every kind of trouble: seams, polygons, groups,
 * marked edges, edges of many faces, no area, NaN, every scale, every number format. */
#include "bits.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void *own(bits_mesh *m, size_t count, size_t size) {
    return m->blocks[m->block_count++] = bits_room(count, size);
}

static void set_float(bits_mesh *m, const float *positions, size_t count) {
    m->mesh.positions = (norma_vec3_view){.data = positions, .count = count};
}

static void set_corners(bits_mesh *m, const uint32_t *corners, size_t count) {
    m->mesh.corners = corners;
    m->mesh.corner_count = count;
}

/* A grid of side x side vertices with hills; rows, or vertices and faces in no order. */
static void grid(bits_mesh *m, size_t across, size_t along, double rough, int shuffled) {
    uint64_t seed = across + along;
    size_t vertices = across * along, faces = 2 * (across - 1) * (along - 1), face = 0;
    float *positions = own(m, 3 * vertices, sizeof *positions);
    uint32_t *corners = own(m, 3 * faces, sizeof *corners),
             *place = own(m, vertices, sizeof *place);
    for (size_t i = 0; i < vertices; ++i) place[i] = (uint32_t)i;
    for (size_t i = vertices; shuffled && i > 1; --i) {
        const size_t j = bits_random(&seed) % i;
        const uint32_t other = place[j];
        place[j] = place[i - 1];
        place[i - 1] = other;
    }
    for (size_t i = 0; i < vertices; ++i) {
        const double x = (double)(i % across) / (double)across - .5,
                     y = (double)(i / across) / (double)along - .5;
        float *p = positions + 3 * (size_t)place[i];
        p[0] = (float)(x + rough * bits_random_unit(&seed));
        p[1] = (float)(y + rough * bits_random_unit(&seed));
        p[2] = (float)(16 * x * (x - .4) * (x + .3) * (y - .1) + y * y * y +
                       rough * bits_random_unit(&seed));
    }
    for (size_t y = 0; y + 1 < along; ++y)
        for (size_t x = 0; x + 1 < across; ++x) {
            const size_t a = y * across + x;
            const uint32_t quad[6] = {place[a], place[a + 1], place[a + across], place[a + 1],
                place[a + across + 1], place[a + across]};
            memcpy(corners + 3 * face, quad, sizeof quad);
            face += 2;
        }
    for (size_t i = faces; shuffled && i > 1; --i) {
        const size_t j = bits_random(&seed) % i;
        uint32_t other[3];
        memcpy(other, corners + 3 * j, sizeof other);
        memcpy(corners + 3 * j, corners + 3 * (i - 1), sizeof other);
        memcpy(corners + 3 * (i - 1), other, sizeof other);
    }
    set_float(m, positions, vertices);
    set_corners(m, corners, 3 * faces);
}

/* A cube's sides blown up to a sphere, each side with vertices of its own: equal positions along
 * all seams. Doubles, spaced. */
static void ball(bits_mesh *m, size_t n, double at) {
    const size_t vertices = 6 * (n + 1) * (n + 1), faces = 12 * n * n;
    double *positions = own(m, 4 * vertices, sizeof *positions);
    uint32_t *corners = own(m, 3 * faces, sizeof *corners), *next = corners;
    double *p = positions;
    for (int side = 0; side < 6; ++side)
        for (size_t v = 0; v <= n; ++v)
            for (size_t u = 0; u <= n; ++u, p += 4) {
                const double a = 2 * (double)u / (double)n - 1, b = 2 * (double)v / (double)n - 1,
                             c = side % 2 ? 1 : -1, length = sqrt(a * a + b * b + 1);
                p[side / 2] = at + c / length;
                p[(side / 2 + 1) % 3] = at + a / length;
                p[(side / 2 + 2) % 3] = at + b / length;
                p[3] = 7;
            }
    for (size_t side = 0; side < 6; ++side)
        for (size_t v = 0; v < n; ++v)
            for (size_t u = 0; u < n; ++u) {
                const uint32_t a = (uint32_t)((side * (n + 1) + v) * (n + 1) + u), b = a + 1,
                               c = a + (uint32_t)n + 1, d = c + 1;
                const uint32_t out[6] = {a, b, d, a, d, c}, in[6] = {a, d, b, a, c, d};
                memcpy(next, side % 2 ? out : in, sizeof out);
                next += 6;
            }
    m->mesh.positions =
        (norma_vec3_view){positions, vertices, 4 * sizeof(double), NORMA_FORMAT_DOUBLE};
    set_corners(m, corners, 3 * faces);
}

/* Quads, triangles, pentagons and concave hexagons over a grid, with smoothing groups and marked
 * edges. */
static void polygons(bits_mesh *m, size_t side) {
    uint64_t seed = 3;
    bits_mesh base = {.name = ""};
    grid(&base, side, side, .004, 0);
    const size_t most = (side - 1) * (side - 1);
    uint32_t *starts = own(m, 2 * most + 1, 4), *corners = own(m, 8 * most, 4),
             *groups = own(m, 2 * most, 4);
    uint8_t *hard = own(m, 8 * most, 1);
    float *positions = own(m, 3 * side * side, sizeof *positions);
    size_t faces = 0, at = 0;
    memcpy(positions, base.mesh.positions.data, 12 * side * side);
    bits_unmake(&base);
    starts[0] = 0;
    for (size_t y = 0; y + 1 < side; ++y)
        for (size_t x = 0; x + 2 < side; x += 2) {
            const uint32_t a = (uint32_t)(y * side + x), s = (uint32_t)side;
            const uint32_t six[6] = {a, a + 1, a + 2, a + s + 2, a + s + 1, a + s},
                           five[5] = {a, a + 1, a + s + 2, a + s + 1, a + s},
                           rest[3] = {a + 1, a + 2, a + s + 2};
            const int kind = (int)(bits_random(&seed) % 3);
            memcpy(corners + at, kind ? six : five, kind ? sizeof six : sizeof five);
            at += kind ? 6 : 5;
            starts[++faces] = (uint32_t)at;
            if (!kind) {
                memcpy(corners + at, rest, sizeof rest);
                at += 3;
                starts[++faces] = (uint32_t)at;
            }
        }
    for (size_t i = 0; i < faces; ++i)
        groups[i] = bits_random(&seed) % 7 ? 3 : (uint32_t)(bits_random(&seed) % 4);
    for (size_t i = 0; i < at; ++i) hard[i] = bits_random(&seed) % 9 == 0;
    set_float(m, positions, side * side);
    set_corners(m, corners, at);
    m->mesh.face_starts = starts;
    m->mesh.face_count = faces;
    m->mesh.smoothing_groups = groups;
    m->mesh.hard_edges = hard;
}

/* Faces at random over few vertices: edges of many faces, twins, no area, NaN, infinity, everything
 * between 1e-38 and 1e38, vertices without a face. */
static void wreck(bits_mesh *m, size_t vertices, size_t faces) {
    static const float scales[] = {1, 1, 1, 1e-38f, 1e-20f, 1e-7f, 1e12f, 3e37f};
    uint64_t seed = 5;
    float *positions = own(m, 3 * vertices, sizeof *positions);
    uint32_t *corners = own(m, 3 * faces, sizeof *corners);
    for (size_t i = 0; i < vertices; ++i) {
        const float scale = scales[bits_random(&seed) % 8];
        for (int x = 0; x < 3; ++x)
            positions[3 * i + (size_t)x] =
                scale * (float)((double)(bits_random(&seed) % 65) / 32 - 1);
    }
    positions[4] = NAN;
    positions[31] = INFINITY;
    positions[62] = -INFINITY;
    for (size_t i = 0; i < 3 * faces; ++i)
        corners[i] = (uint32_t)(bits_random(&seed) % (vertices - vertices / 8));
    for (size_t i = 0; i + 1 < faces; i += 5) { /* its neighbour's twin, back to back or not */
        const uint32_t *c = corners + 3 * i,
                       twin[3] = {c[0], i % 2 ? c[1] : c[2], i % 2 ? c[2] : c[1]};
        memcpy(corners + 3 * i + 3, twin, sizeof twin);
    }
    set_float(m, positions, vertices);
    set_corners(m, corners, 3 * faces);
}

static void fan(bits_mesh *m, size_t faces) {
    uint64_t seed = 8;
    float *positions = own(m, 3 * (faces + 1), sizeof *positions);
    uint32_t *corners = own(m, 3 * faces, sizeof *corners);
    memset(positions, 0, 12);
    for (size_t i = 0; i < faces; ++i) {
        const double t = 2 * (double)i / (double)faces - 1,
                     w = 1 + t * t; /* a circle, by rational numbers */
        float *p = positions + 3 * (i + 1);
        p[0] = (float)((1 - t * t) / w);
        p[1] = (float)(2 * t / w);
        p[2] = (float)(bits_random_unit(&seed) - .5);
        const uint32_t face[3] = {0, (uint32_t)(i + 1), (uint32_t)((i + 1) % faces + 1)};
        memcpy(corners + 3 * i, face, sizeof face);
    }
    set_float(m, positions, faces + 1);
    set_corners(m, corners, 3 * faces);
}

/* No corners: each triangle has positions of its own, many of them equal; each tetrahedron at a
 * scale of its own. */
static void scales(bits_mesh *m, size_t count) {
    static const uint8_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    uint64_t seed = 13;
    double *positions = own(m, 36 * count, sizeof *positions), scale = 1e-38;
    for (size_t t = 0; t < count; ++t, scale *= t % 4 ? 1 : 8) {
        double p[4][3];
        for (int i = 0; i < 12; ++i)
            p[i / 3][i % 3] = scale * ((double)(t % 3) * 1e4 + bits_random_unit(&seed));
        for (size_t i = 0; i < 12; ++i)
            memcpy(positions + 36 * t + 3 * i, p[faces[i]], sizeof p[0]);
    }
    m->mesh.positions = (norma_vec3_view){positions, 12 * count, 0, NORMA_FORMAT_DOUBLE};
    m->mesh.corner_count = 12 * count;
}

/* A ball's positions as integers of a format, spaced. */
static void integers(bits_mesh *m, norma_format format, size_t corner_size, size_t n) {
    bits_mesh base = {.name = ""};
    ball(&base, n, 0);
    const size_t count = base.mesh.positions.count,
                 size = format == NORMA_FORMAT_INT8 || format == NORMA_FORMAT_UINT8 ? 1 : 2,
                 stride = 4 * size;
    const int is_signed = format == NORMA_FORMAT_INT8 || format == NORMA_FORMAT_INT16,
              half = size == 1 ? 127 : 32767;
    unsigned char *positions = own(m, count, stride),
                  *corners = own(m, base.mesh.corner_count, corner_size);
    for (size_t i = 0; i < count; ++i)
        for (size_t x = 0; x < 3; ++x) {
            const double at = ((const double *)base.mesh.positions.data)[4 * i + x] * half;
            const int value = (int)(at + half + .5) - (is_signed ? half : 0);
            const uint16_t wide = (uint16_t)value;
            const uint8_t narrow = (uint8_t)value;
            memcpy(
                positions + i * stride + x * size, size == 1 ? (const void *)&narrow : &wide, size);
        }
    for (size_t i = 0; i < base.mesh.corner_count; ++i) {
        const uint32_t corner = ((const uint32_t *)base.mesh.corners)[i];
        const uint16_t wide = (uint16_t)corner;
        const uint8_t narrow = (uint8_t)corner;
        memcpy(corners + i * corner_size,
            corner_size == 1   ? (const void *)&narrow
            : corner_size == 2 ? (const void *)&wide
                               : &corner,
            corner_size);
    }
    m->mesh = base.mesh;
    m->mesh.positions = (norma_vec3_view){positions, count, stride, format};
    m->mesh.corners = corners;
    m->mesh.corner_size = corner_size;
    bits_unmake(&base);
}

enum {
    HILL,
    GRID,
    BALL,
    FAR,
    POLYGONS,
    WRECK,
    FAN,
    SCALES,
    INT8,
    UINT8,
    INT16,
    UINT16,
    ROWS,
    SHUFFLED,
    MADE
};

size_t bits_made_count(void) { return MADE; }

void bits_make(size_t index, bits_mesh *m) {
    static const char *const names[MADE] = {"hill", "grid", "ball", "far", "polygons", "wreck",
        "fan", "scales", "int8", "uint8", "int16", "uint16", "rows", "shuffled"};
    *m = (bits_mesh){.name = names[index], .large = index >= ROWS};
    switch (index) {
    case HILL:
        grid(m, 9, 8, .05, 0);
        break;
    case GRID:
        grid(m, 40, 30, .01, 0);
        break;
    case BALL:
        ball(m, 13, 0);
        break;
    case FAR:
        ball(m, 9, 4.5e6);
        break;
    case POLYGONS:
        polygons(m, 37);
        break;
    case WRECK:
        wreck(m, 400, 1500);
        break;
    case FAN:
        fan(m, 3000);
        break;
    case SCALES:
        scales(m, 320);
        break;
    case INT8:
        integers(m, NORMA_FORMAT_INT8, 1, 5);
        break;
    case UINT8:
        integers(m, NORMA_FORMAT_UINT8, 1, 5);
        break;
    case INT16:
        integers(m, NORMA_FORMAT_INT16, 2, 9);
        break;
    case UINT16:
        integers(m, NORMA_FORMAT_UINT16, 4, 9);
        break;
    case ROWS:
        grid(m, 300, 150, .001, 0);
        break;
    default:
        grid(m, 150, 300, .001, 1);
        break;
    }
}

void bits_unmake(bits_mesh *m) {
    for (size_t i = 0; i < m->block_count; ++i) free(m->blocks[i]);
    *m = (bits_mesh){0};
}
