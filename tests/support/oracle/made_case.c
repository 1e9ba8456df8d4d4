/* made_case.c: see made_case.h. A mesh is a handful of features (wheels, grids, polygons of up to
 * 300 corners, faces that are there again or the other way round, fins, slits), then damage. */
#include "oracle/made_case.h"
#include <float.h>
#include <math.h>
#include <string.h>

static const double TURN = 6.283185307179586;

/* ---- bytes as numbers: those given, then a chain that they begin */

typedef struct maker {
    const uint8_t *at;
    size_t left;
    uint64_t state;
    made_case *made;
    int kind; /* of numbers */
    int big;  /* one of its features has hundreds of corners */
} maker;

uint64_t made_case_random(uint64_t *state) {
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27) * UINT64_C(0x94d049bb133111eb);
    return z ^ z >> 31;
}

static uint32_t below(maker *m, uint32_t count) {
    if (!m->left) return (uint32_t)((made_case_random(&m->state) >> 32) % count);
    uint32_t value = *m->at++;
    if (--m->left && count > 256) value = value << 8 | *m->at++, --m->left;
    return value % count;
}

static int chance(maker *m, uint32_t one_in) { return below(m, one_in) == 0; }

/* ---- positions */

static double lattice(maker *m, uint32_t count) {
    return (double)below(m, count) - (double)(count / 2);
}

static double number(maker *m) {
    static const double wild[] = {1e-38, -1e-38, 1e38, -3.4e38, 1e-45, 0.0, -0.0, 1.0, 3.0, 1e-19,
        1e19, FLT_MAX, -FLT_MIN, (double)INFINITY, -(double)INFINITY, (double)NAN};
    double near;
    switch (m->kind) {
    case 0:
        return lattice(m, 3);
    case 1:
        return lattice(m, 7);
    case 2: /* nearly coincident */
        near = ldexp(1, -(int)below(m, 24));
        near *= lattice(m, 3);
        return near + lattice(m, 3);
    case 3:
        return (double)below(m, 1 << 16) / 32768 - 1;
    case 4: /* far from the origin */
        return 1e6 + lattice(m, 7) / 16;
    case 5:
        return wild[below(m, 16)];
    default: /* few numbers are wild */
        return chance(m, 24) ? wild[below(m, 16)] : lattice(m, 5);
    }
}

static uint32_t add_position(maker *m, double x, double y, double z) {
    made_case *c = m->made;
    if (c->position_count == CASE_POSITIONS / 4) return CASE_POSITIONS / 4 - 1;
    c->positions[c->position_count][0] = x;
    c->positions[c->position_count][1] = y;
    c->positions[c->position_count][2] = z;
    return (uint32_t)c->position_count++;
}

static uint32_t add_any(maker *m) {
    const double x = number(m), y = number(m), z = number(m);
    return add_position(m, x, y, z);
}

/* ---- faces */

static void add_face(maker *m, const uint32_t *corners, size_t count) {
    made_case *c = m->made;
    if (c->face_count == CASE_FACES || c->corner_count + count > CASE_CORNERS) return;
    if (count) memcpy(c->corners + c->corner_count, corners, count * sizeof *corners);
    c->corner_count += count;
    c->starts[++c->face_count] = (uint32_t)c->corner_count;
}

static uint32_t any(maker *m) { return below(m, (uint32_t)m->made->position_count); }

/* Mostly three and four; up to 300. */
static uint32_t size_of_face(maker *m) {
    const uint32_t kind = below(m, 256);
    return kind == 0   ? 3 + below(m, 298)
           : kind == 1 ? 90 + below(m, 50)
           : kind < 12 ? 3 + below(m, 30)
           : kind < 96 ? 4 + below(m, 3)
           : kind < 99 ? below(m, 3)
                       : 3;
}

static void any_face(maker *m) {
    uint32_t corners[320];
    const uint32_t count = size_of_face(m);
    for (uint32_t i = 0; i < count; ++i) corners[i] = any(m);
    add_face(m, corners, count);
}

/* A face that is there, again: as it is or backwards, beginning elsewhere. */
static void again(maker *m) {
    uint32_t corners[512];
    made_case *c = m->made;
    if (!c->face_count) return;
    const size_t face = below(m, (uint32_t)c->face_count), start = c->starts[face],
                 count = c->starts[face + 1] - start;
    if (!count || count > 512) return;
    const size_t from = below(m, (uint32_t)count), backwards = (size_t)chance(m, 2);
    for (size_t i = 0; i < count; ++i)
        corners[i] = c->corners[start + (from + (backwards ? count - i : i)) % count];
    add_face(m, corners, count);
}

/* A triangle or a quad at an edge that is there: a neighbour, a conflict, a fin. */
static void at_edge(maker *m) {
    made_case *c = m->made;
    if (!c->corner_count) {
        any_face(m);
        return;
    }
    const uint32_t from = below(m, (uint32_t)c->corner_count);
    size_t face = 0;
    while (c->starts[face + 1] <= from) ++face;
    const uint32_t to = from + 1 < c->starts[face + 1] ? from + 1 : c->starts[face],
                   same_way = (uint32_t)chance(m, 4);
    const uint32_t a = c->corners[same_way ? from : to], b = c->corners[same_way ? to : from];
    const uint32_t d = chance(m, 3) ? add_any(m) : any(m), e = any(m);
    add_face(m, (uint32_t[]){a, b, d, e}, chance(m, 3) ? 4 : 3);
}

/* Names a position twice, apart; or goes out to a point and back. */
static void slit(maker *m) {
    const uint32_t a = any(m), b = any(m), c = any(m), d = any(m), e = any(m);
    const uint32_t kinds[4][8] = {
        {a, b, c, b}, {a, b, c, a, d}, {a, b, c, a, d, e, d}, {a, a, b, c, c, b, d, d}};
    static const size_t sizes[4] = {4, 5, 7, 8};
    const uint32_t kind = below(m, 4);
    add_face(m, kinds[kind], sizes[kind]);
}

/* Triangles round a position: a cone, with folds, gaps and some turned; now and then up to 500. */
static void wheel(maker *m) {
    const uint32_t sides = m->big ? 60 + below(m, 441) : 3 + below(m, 8), hub = any(m),
                   fold = 1 + below(m, 6), steep = below(m, 4), on_lattice = (uint32_t)chance(m, 2),
                   few = 2 + below(m, 8);
    uint32_t first = (uint32_t)m->made->position_count;
    const double *p = m->made->positions[hub], x = p[0], y = p[1], z = p[2];
    for (uint32_t i = 0; i < sides; ++i) {
        const double angle = TURN * i / sides, up = i % fold ? 0 : -0.3 * steep;
        if (on_lattice)
            add_any(m);
        else
            add_position(m, x + cos(angle), y + sin(angle), z + up);
    }
    const uint32_t rim = (uint32_t)m->made->position_count - first;
    if (!rim) return;
    for (uint32_t i = 0; i < sides; ++i) {
        const uint32_t a = first + i % rim, b = first + (i + 1) % rim, turned = below(m, 24) == 0;
        if (sides < 60 ? chance(m, 16) : chance(m, 64)) continue;
        if (sides >= 60 && on_lattice && i % few == 0) again(m);
        add_face(m, (uint32_t[]){hub, turned ? b : a, turned ? a : b}, 3);
    }
}

/* A sheet of quads or triangles, bent; some of its quads name a position twice. */
static void grid(maker *m) {
    const uint32_t w = 1 + below(m, 4), h = 1 + below(m, 3), bend = below(m, 4),
                   broken = below(m, 3), first = (uint32_t)m->made->position_count,
                   triangles = below(m, 2);
    if (first + (w + 1) * (h + 1) > CASE_POSITIONS / 4) return;
    for (uint32_t j = 0; j <= h; ++j)
        for (uint32_t i = 0; i <= w; ++i)
            add_position(m, i, j, bend == 0 ? 0 : bend == 1 ? (i * i) / 4.0 : number(m) / 4);
    for (uint32_t j = 0; j < h; ++j)
        for (uint32_t i = 0; i < w; ++i) {
            const uint32_t a = first + j * (w + 1) + i, b = a + 1, c = a + w + 2, d = a + w + 1;
            if (broken == 2 || (broken == 1 && chance(m, 4)))
                add_face(m, (uint32_t[]){a, b, c, b}, 4);
            else if (!triangles)
                add_face(m, (uint32_t[]){a, b, c, d}, 4);
            else {
                add_face(m, (uint32_t[]){a, b, c}, 3);
                add_face(m, (uint32_t[]){a, c, d}, 3);
            }
        }
}

/* A regular polygon, with a wall of quads at some of its edges, and maybe a lid. */
static void prism(maker *m) {
    uint32_t lid[320];
    const uint32_t sides = m->big ? 80 + below(m, 221) : 3 + below(m, 7),
                   first = (uint32_t)m->made->position_count, walls = below(m, 3),
                   lids = below(m, 4), stars = (uint32_t)chance(m, 6);
    if (first + 2 * sides > CASE_POSITIONS / 4) return;
    for (uint32_t i = 0; i < 2 * sides; ++i) {
        const double angle = TURN * (i % sides) / sides, r = stars && i % 2 ? 0.5 : 2;
        add_position(m, r * cos(angle), r * sin(angle), i < sides ? 0 : 1);
    }
    for (uint32_t i = 0; i < sides; ++i) lid[i] = first + sides + i;
    add_face(m, lid, sides);
    for (uint32_t i = 0; i < sides; ++i) lid[i] = first + (sides - i) % sides;
    if (lids) add_face(m, lid, sides);
    for (uint32_t i = 0; i < sides && walls; ++i) {
        const uint32_t a = first + i, b = first + (i + 1) % sides;
        if (walls == 2 && !chance(m, 4)) continue;
        add_face(m, (uint32_t[]){a, b, b + sides, a + sides}, 4);
    }
}

/* Fins at one edge: more pairs of them than are tried one by one. */
static void crowd(maker *m) {
    const uint32_t fins = 2 * (60 + below(m, 40)), a = add_position(m, 0, 0, 0),
                   b = add_position(m, 0, 0, 1), on_lattice = (uint32_t)chance(m, 2);
    for (uint32_t i = 0; i < fins; ++i) {
        const double angle = TURN * i / fins;
        const uint32_t turned = below(m, 2),
                       tip = on_lattice ? add_any(m) : add_position(m, cos(angle), sin(angle), 0);
        add_face(m, (uint32_t[]){turned ? b : a, turned ? a : b, tip}, 3);
    }
}

/* Four positions of their own, some faces turned. */
static void tetrahedron(maker *m) {
    static const uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    uint32_t p[4];
    const uint32_t turn_one = below(m, 5), turn_all = below(m, 2);
    for (int i = 0; i < 4; ++i) p[i] = add_any(m);
    for (uint32_t f = 0; f < 4; ++f) {
        const uint32_t turn = turn_all ^ (f == turn_one), *c = faces[f];
        add_face(m, (uint32_t[]){p[c[0]], p[c[1 + turn]], p[c[2 - turn]]}, 3);
    }
}

static void feature(maker *m) {
    static void (*const features[])(maker *) = {wheel, grid, prism, tetrahedron, again, again, slit,
        at_edge, at_edge, any_face, any_face, any_face};
    features[below(m, 12)](m);
}

/* ---- damage, and how it is handed over */

static void damage(maker *m) {
    made_case *c = m->made;
    if (!c->corner_count) return;
    const uint32_t kind = below(m, 6), from = below(m, (uint32_t)c->corner_count),
                   to = below(m, (uint32_t)c->corner_count), p = any(m), q = any(m);
    const int k = (int)below(m, 3);
    switch (kind) {
    case 0:
        c->corners[to] = p;
        return;
    case 1:
        c->corners[to] = c->corners[from];
        return;
    case 2: /* the same name side by side */
        c->corners[to] = c->corners[to ? to - 1 : 0];
        return;
    case 3:
        c->positions[p][k] = number(m);
        return;
    case 4: /* nearly where it was */
        c->positions[p][k] =
            (double)nextafterf((float)c->positions[p][k], (float)lattice(m, 7) * 1e9F);
        return;
    default:
        memmove(c->positions[p], c->positions[q], sizeof *c->positions);
    }
}

/* The same place by several names; now and then not quite the same place. */
static void rename_corners(maker *m) {
    made_case *c = m->made;
    const uint32_t names = 1 + below(m, 3), count = (uint32_t)c->position_count;
    for (uint32_t i = count; i < names * count; ++i) {
        memcpy(c->positions[i], c->positions[i % count], sizeof *c->positions);
        const uint32_t k = below(m, 3), change = below(m, 24);
        if (change < 2) c->positions[i][k] *= -1;
        if (change == 2) c->positions[i][k] += ldexp(1, -(int)below(m, 30));
    }
    c->position_count = names * count;
    for (size_t i = 0; i < c->corner_count; ++i) c->corners[i] += count * below(m, names);
}

/* A position for each corner. */
static void make_soup(made_case *c) {
    static double positions[CASE_POSITIONS][3];
    if (c->corner_count > CASE_POSITIONS) return;
    memcpy(positions, c->positions, sizeof positions);
    for (size_t i = 0; i < c->corner_count; ++i)
        memcpy(c->positions[i], positions[c->corners[i]], sizeof *positions);
    for (size_t i = 0; i < c->corner_count; ++i) c->corners[i] = (uint32_t)i;
    c->position_count = c->corner_count > c->position_count ? c->corner_count : c->position_count;
    c->soup = 1;
}

static double clamp(double x, double least, double most) {
    const double r = rint(x);
    return r >= least && r <= most ? r : r > most ? most : least; /* a NaN becomes the least */
}

static double as_format(double x, norma_format format) {
    switch (format) {
    case NORMA_FORMAT_FLOAT:
        return (double)(float)x;
    case NORMA_FORMAT_DOUBLE:
        return x;
    case NORMA_FORMAT_INT8:
        return clamp(8 * x, -128, 127);
    case NORMA_FORMAT_UINT8:
        return clamp(8 * x + 100, 0, 255);
    case NORMA_FORMAT_INT16:
        return clamp(64 * x, -32768, 32767);
    default:
        return clamp(64 * x + 1000, 0, 65535);
    }
}

static void hand_over(maker *m) {
    made_case *c = m->made;
    static const norma_format formats[] = {NORMA_FORMAT_FLOAT, NORMA_FORMAT_FLOAT,
        NORMA_FORMAT_FLOAT, NORMA_FORMAT_DOUBLE, NORMA_FORMAT_DOUBLE, NORMA_FORMAT_INT8,
        NORMA_FORMAT_UINT8, NORMA_FORMAT_INT16, NORMA_FORMAT_UINT16};
    static const int powers[] = {0, 0, 0, -100, 100, -20, 60};
    c->format = formats[below(m, 9)];
    c->position_gap = chance(m, 3) ? below(m, 9) : 0;
    if (chance(m, 2)) rename_corners(m);
    if (chance(m, 8)) make_soup(c);
    const double scale = m->kind < 5 ? ldexp(1, powers[below(m, 7)]) : 1; /* edges 1e-38 to 1e38 */
    for (size_t v = 0; v < c->position_count; ++v)
        for (int k = 0; k < 3; ++k) {
            const int integers =
                c->format != NORMA_FORMAT_FLOAT && c->format != NORMA_FORMAT_DOUBLE;
            c->positions[v][k] = as_format(c->positions[v][k] * (integers ? 1 : scale), c->format);
        }
    if (c->format == NORMA_FORMAT_DOUBLE && chance(m, 4)) /* beyond floats */
        for (size_t v = 0; v < c->position_count; ++v)
            for (int k = 0; k < 3; ++k) c->positions[v][k] += 1e-13 * lattice(m, 7) * scale;
    static const size_t sizes[] = {4, 0, 2, 1};
    c->corner_size = sizes[below(m, 4)];
    if (c->corner_size == 1 && c->position_count > 256) c->corner_size = 2;
    c->polygons = chance(m, 4);
    for (size_t f = 0; f < c->face_count; ++f) c->polygons |= c->starts[f + 1] - c->starts[f] != 3;
    c->has_groups = chance(m, 4);
    c->has_hard = chance(m, 4);
    /* Any two bits that follow each other decide, the last two as often as all others. */
    const uint32_t bit = !c->has_groups || chance(m, 2) ? 0 : chance(m, 2) ? 30 : below(m, 31);
    for (size_t f = 0; f < c->face_count && c->has_groups; ++f)
        c->groups[f] = chance(m, 8) ? 1U << 31 | 1 : below(m, 4) << bit;
    for (size_t i = 0; i < c->corner_count && c->has_hard; ++i) c->hard[i] = chance(m, 8) ? 1 : 0;
}

static void choose_options(maker *m) {
    static const float creases[] = {0, 0.3F, 1, 1.04719755F, 0.785398163F, 1.57079637F, 3.14159274F,
        3.14159274F, 3.1425F, 2.3F, -1, 1e-6F};
    static const double distances[] = {0, 1e-7, 1e-3, 0.5, 1, 1.5, 1e30};
    static const uint32_t threads[] = {0, 1, 1, 1, 1, 1, 2, 3};
    static const norma_isa sets[] = {NORMA_ISA_BEST, NORMA_ISA_BEST, NORMA_ISA_PORTABLE,
        NORMA_ISA_SSE2, NORMA_ISA_AVX2, NORMA_ISA_AVX512};
    made_case *c = m->made;
    norma_options *o = &c->options;
    *o = (norma_options){.struct_size = sizeof *o, .weight = (norma_weight)below(m, 7)};
    o->weld = chance(m, 6)   ? NORMA_WELD_DISTANCE
              : chance(m, 3) ? NORMA_WELD_NONE
                             : NORMA_WELD_EXACT;
    o->weld_distance = distances[below(m, 7)];
    o->non_manifold = chance(m, 3) ? NORMA_NON_MANIFOLD_SMOOTH : NORMA_NON_MANIFOLD_HARD;
    o->fallback = (norma_fallback)below(m, 3);
    for (int k = 0; k < 3; ++k) o->fallback_normal[k] = (float)lattice(m, 5);
    o->threads = threads[below(m, 8)];
    o->isa = sets[below(m, 6)];
    c->backwards = chance(m, 8);
    c->normal_gap = chance(m, 3) ? below(m, 21) : 0;
    c->crease = creases[below(m, 12)];
}

void made_case_make(made_case *made, const void *bytes, size_t size) {
    maker m = {.at = bytes, .left = size, .state = UINT64_C(0xcbf29ce484222325), .made = made};
    for (size_t i = 0; i < size; ++i)
        m.state = (m.state ^ m.at[i]) * UINT64_C(0x100000001b3); /* FNV-1a */
    made->position_count = made->corner_count = made->face_count = 0;
    made->starts[0] = 0;
    made->soup = 0;
    made->salt = made_case_random(&m.state);
    choose_options(&m);
    static const int kinds[] = {0, 0, 1, 1, 1, 2, 2, 3, 3, 4, 5, 6, 6};
    m.kind = kinds[below(&m, 13)];
    const uint32_t positions = chance(&m, 12) ? 1 + below(&m, 40) : 3 + below(&m, 7);
    for (uint32_t i = 0; i < positions; ++i) add_any(&m);
    m.big = chance(&m, 64);
    if (m.big) {
        static void (*const features[])(maker *) = {wheel, prism, crowd};
        features[below(&m, 3)](&m);
    }
    m.big = 0;
    const uint32_t features = chance(&m, 40) ? below(&m, 40) : 1 + below(&m, 6);
    for (uint32_t i = 0; i < features; ++i) feature(&m);
    for (uint32_t i = chance(&m, 3) ? below(&m, 6) : 0; i > 0; --i) damage(&m);
    hand_over(&m);
}

void made_case_of_seed(made_case *made, uint64_t seed) {
    uint64_t state = seed, words[2] = {made_case_random(&state), made_case_random(&state)};
    uint8_t bytes[16];
    for (int i = 0; i < 16; ++i) bytes[i] = (uint8_t)(words[i / 8] >> 8 * (i % 8));
    made_case_make(made, bytes, sizeof bytes);
}
