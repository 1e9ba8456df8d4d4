/* test_encode_bounds.c: proofs of norma_encoding_error_rad by interval arithmetic, over every
 * triangle of an octahedron's points and every cell of 10_10_10_2. By symmetry, normals with x >= y
 * >= z >= 0 are enough. And how tight the bounds are: angles that normals really have.
 *
 * Points are compared with their exact directions. The floats of a decoded vector each differ by a
 * factor within 1 +- 2^-24 from a multiple of these, which turns it by at most asin(2^-24 / (1 -
 * 2^-24)). */
#include "check.h"
#include "oracle/shapes.h"

#define FLOATS_TURN 5.96047e-8

/* ---- numbers known to lie between two others */

typedef struct interval {
    double low, high;
} interval;

/* A rounded result lies within 2^-53 of the exact one; these go further. */
static double below(double x) { return x - fabs(x) * 0x1p-52 - 0x1p-1000; }
static double above(double x) { return x + fabs(x) * 0x1p-52 + 0x1p-1000; }

static interval exactly(double x) { return (interval){x, x}; }
static interval plus(interval a, interval b) {
    return (interval){below(a.low + b.low), above(a.high + b.high)};
}
static interval minus(interval a, interval b) {
    return (interval){below(a.low - b.high), above(a.high - b.low)};
}
static interval times(interval a, interval b) {
    const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
    return (interval){below(fmin(fmin(p, q), fmin(r, s))), above(fmax(fmax(p, q), fmax(r, s)))};
}
static interval square(interval a) {
    const double p = a.low * a.low, q = a.high * a.high;
    const int has_zero = a.low <= 0 && a.high >= 0;
    return (interval){has_zero ? 0 : below(fmin(p, q)), above(fmax(p, q))};
}
/* Of what is not negative. */
static interval root(interval a) {
    return (interval){a.low > 0 ? below(sqrt(a.low)) : 0, a.high > 0 ? above(sqrt(a.high)) : 0};
}
static interval over(interval a, interval positive) {
    return times(a, (interval){below(1 / positive.high), above(1 / positive.low)});
}

static interval square_length(const interval v[3]) {
    return plus(plus(square(v[0]), square(v[1])), square(v[2]));
}
static void cross_of(const interval a[3], const interval b[3], interval out[3]) {
    for (int k = 0; k < 3; ++k)
        out[k] =
            minus(times(a[(k + 1) % 3], b[(k + 2) % 3]), times(a[(k + 2) % 3], b[(k + 1) % 3]));
}

/* ---- octahedral: no point of a triangle is further from its nearest corner than the centre of the
 * circle through the three, which is tan r = |a x b| |b x c| |c x a| / (2 det |a| |b| |c| cos cos
 * cos) away, with the cosines of half the angles between corners. The determinant is N. Triangles
 * are taken by rectangles full, with intervals for their corners, until the bound holds. */

typedef struct triangles {
    double most, square_tangent; /* N; the square of the bound's tangent */
    size_t looked_at;
} triangles;

/* Corners of the triangles at (j, k): (j, k), (j + 1, k), (j, k + 1), and the other half of the
 * square. */
static const int corners_of[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{1, 0}, {0, 1}, {1, 1}}};

static int circle_is_within(const triangles *t, interval j, interval k, const int corners[3][2]) {
    interval c[3][3], length[3], product = exactly(1);
    for (int i = 0; i < 3; ++i) {
        c[i][1] = plus(j, exactly(corners[i][0]));
        c[i][2] = plus(k, exactly(corners[i][1]));
        c[i][0] = minus(minus(exactly(t->most), c[i][1]), c[i][2]);
        length[i] = square_length(c[i]);
    }
    for (int i = 0; i < 3; ++i) {
        const int next = (i + 1) % 3, v = corners[next][0] - corners[i][0],
                  w = corners[next][1] - corners[i][1];
        const interval edge[3] = {exactly(-v - w), exactly(v), exactly(w)};
        interval normal[3];
        cross_of(c[i], edge, normal); /* a x (b - a) */
        const interval wide = square_length(normal),
                       square_sine = over(wide, times(length[i], length[next]));
        const interval cosine = root(minus(exactly(1), square_sine)),
                       half = times(exactly(0.5), plus(exactly(1), cosine));
        product = over(times(product, wide), times(half, length[i]));
    }
    return over(product, exactly(4 * t->most * t->most)).high <= t->square_tangent;
}

/* All triangles at first <= (j, k) < first + size; those of other octants and orders are some of
 * these again. */
static int rectangle_is_within(triangles *t, int j, int k, int size) {
    const int most = (int)t->most;
    if (j + k > most - 1 || most - j - k < j - 2 || k > j + size) return 1;
    const interval js = {j, j + size - 1}, ks = {k, k + size - 1};
    ++t->looked_at;
    const int fits = j + k + 2 * size < most; /* else numbers below 0 would be among them */
    if (fits && circle_is_within(t, js, ks, corners_of[0]) &&
        circle_is_within(t, js, ks, corners_of[1]))
        return 1;
    if (size == 1) return 0;
    const int half = size / 2;
    return rectangle_is_within(t, j, k, half) && rectangle_is_within(t, j + half, k, half) &&
           rectangle_is_within(t, j, k + half, half) &&
           rectangle_is_within(t, j + half, k + half, half);
}

static int octahedron_is_within(norma_encoding encoding, int most, double angle) {
    const double r = angle - FLOATS_TURN, tangent = below(r + below(r * r * r / 3)); /* or more */
    triangles t = {most, below(tangent * tangent), 0};
    int size = 1;
    while (size < most) size *= 2;
    const int within = rectangle_is_within(&t, 0, 0, size);
    print_message("encoding %d: %s%.9g rad, %zu rectangles\n", (int)encoding,
        within ? "" : "not within ", angle, t.looked_at);
    return within;
}

static void octahedra_are_proven(void **state) {
    (void)state;
    static const int most[] = {127, 2047, 32767};
    for (int e = 0; e < 3; ++e) {
        const double angle = norma_encoding_error_rad((norma_encoding)e);
        assert_true(octahedron_is_within((norma_encoding)e, most[e], angle));
        assert_false(
            octahedron_is_within((norma_encoding)e, most[e], angle * 0.9999 - FLOATS_TURN));
    }
}

/* ---- 10_10_10_2: cells of 511 n between whole numbers, and their faces, edges and corners, where
 * a number has one candidate instead of two. Each is cut until one candidate is within the bound of
 * all its normals. */

typedef struct cell {
    double about[3][2]; /* the candidates of each number; equal where there is one */
    double square_sine;
    size_t looked_at;
} cell;

static int candidate_is_within(const cell *c, const interval p[3], int which) {
    interval point[3], off[3], normal[3];
    for (int i = 0; i < 3; ++i) {
        point[i] = exactly(c->about[i][which >> i & 1]);
        off[i] = minus(p[i], point[i]);
    }
    cross_of(off, point, normal); /* p x c */
    return over(square_length(normal), times(exactly(511.0 * 511.0), square_length(point))).high <=
           c->square_sine;
}

/* Of the middle: a guess, which the proof does not depend on. */
static int nearest_candidate(const cell *c, const interval p[3]) {
    double least = INFINITY, middle[3];
    int nearest = 0;
    for (int i = 0; i < 3; ++i) middle[i] = (p[i].low + p[i].high) / 2;
    for (int which = 0; which < 8; ++which) {
        double point[3], square = 0, off = 0;
        for (int i = 0; i < 3; ++i) point[i] = c->about[i][which >> i & 1];
        for (int i = 0; i < 3; ++i) {
            const int k = (i + 1) % 3;
            const double n = (middle[i] - point[i]) * point[k] - (middle[k] - point[k]) * point[i];
            square += point[i] * point[i];
            off += n * n;
        }
        if (off / square >= least) continue;
        least = off / square;
        nearest = which;
    }
    return nearest;
}

/* The normals with these y and z. */
static int part_is_within(cell *c, interval y, interval z, int depth) {
    interval p[3] = {root(minus(minus(exactly(511.0 * 511.0), square(y)), square(z))), y, z};
    if (p[0].low < c->about[0][0]) p[0].low = c->about[0][0];
    if (p[0].high > c->about[0][1]) p[0].high = c->about[0][1];
    if (p[0].low > p[0].high || p[0].high < y.low || y.high < z.low) return 1;
    ++c->looked_at;
    if (candidate_is_within(c, p, nearest_candidate(c, p))) return 1;
    if (depth == 0) return 0;
    if (y.high - y.low >= z.high - z.low) {
        const double middle = (y.low + y.high) / 2;
        return part_is_within(c, (interval){y.low, middle}, z, depth - 1) &&
               part_is_within(c, (interval){middle, y.high}, z, depth - 1);
    }
    const double middle = (z.low + z.high) / 2;
    return part_is_within(c, y, (interval){z.low, middle}, depth - 1) &&
           part_is_within(c, y, (interval){middle, z.high}, depth - 1);
}

static int cell_is_within(int x, int y, int z, double square_sine, size_t *looked_at) {
    const int first[3] = {x, y, z};
    for (int kind = 0; kind < 8; ++kind) { /* the cell, its faces, edges and corner at (x, y, z) */
        cell c = {.square_sine = square_sine};
        for (int i = 0; i < 3; ++i) {
            c.about[i][0] = first[i];
            c.about[i][1] = first[i] + !(kind >> i & 1);
        }
        if (!part_is_within(&c, (interval){c.about[1][0], c.about[1][1]},
                (interval){c.about[2][0], c.about[2][1]}, 40))
            return 0;
        *looked_at += c.looked_at;
    }
    return 1;
}

static int tens_are_within(double angle) {
    const double r = angle - FLOATS_TURN, sine = below(r - above(r * r * r / 6)); /* or more */
    size_t looked_at = 0;
    for (int y = 0; y <= 361; ++y) /* 511 / sqrt(2) */
        for (int z = 0; z <= y; ++z) {
            const double most = 511 * 511 - y * y - z * z, least = most - 2 * (y + z + 1);
            for (int x = least > 0 ? (int)sqrt(least) - 1 : 0; x <= (int)sqrt(most); ++x)
                if (x >= y - 1 && !cell_is_within(x, y, z, below(sine * sine), &looked_at)) {
                    print_message("10_10_10_2: not within %.9g rad at %d %d %d\n", angle, x, y, z);
                    return 0;
                }
        }
    print_message("10_10_10_2: %.9g rad, %zu parts of cells\n", angle, looked_at);
    return 1;
}

static void tens_are_proven(void **state) {
    (void)state;
    const double angle = norma_encoding_error_rad(NORMA_ENCODING_10_10_10_2);
    assert_true(tens_are_within(angle));
    assert_false(tens_are_within(angle * 0.9999 - FLOATS_TURN));
}

/* ---- how tight they are: normals where the bound is all but reached */

static double largest_angle(norma_encoding encoding, double x, double y, double z, double step) {
    uint64_t seed = 1;
    double largest = 0;
    for (int round = 0; round < 20000; ++round) {
        const double n[3] = {x + step * shape_random_unit(&seed),
            y + step * shape_random_unit(&seed), z + step * shape_random_unit(&seed)};
        uint32_t code;
        float v[3];
        assert_ok(norma_encode_normals(
            (norma_vec3_view){n, 1, 0, NORMA_FORMAT_DOUBLE}, encoding, &code, 0, 1, NULL));
        assert_ok(norma_decode_normals(&code, 0, 1, encoding, v, 0));
        const double u = n[1] * v[2] - n[2] * v[1], w = n[2] * v[0] - n[0] * v[2],
                     q = n[0] * v[1] - n[1] * v[0];
        largest = fmax(largest,
            asin(sqrt((u * u + w * w + q * q) /
                      ((n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) *
                          ((double)v[0] * v[0] + (double)v[1] * v[1] + (double)v[2] * v[2])))));
    }
    return largest;
}

static void bounds_are_tight(void **state) {
    (void)state;
    static const int most[] = {127, 2047, 32767};
    for (int e = 0; e < 4; ++e) {
        double largest = 0;
        if (e == NORMA_ENCODING_10_10_10_2)
            largest = largest_angle(NORMA_ENCODING_10_10_10_2, 510.999, 0.5, 0.5, 1e-3);
        for (int i = 0; i < 40 && e < 3; ++i) /* the middles of triangles about (1, 1, 1) */
            largest = fmax(largest, largest_angle((norma_encoding)e, most[e], most[e] + i % 7 - 3,
                                        most[e] + i / 7 - 3, 1e-2));
        const double bound = norma_encoding_error_rad((norma_encoding)e);
        print_message("encoding %d: %.9g of %.9g rad\n", e, largest, bound);
        assert_true(largest <= bound && largest >= bound * 0.9985);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(octahedra_are_proven),
        cmocka_unit_test(tens_are_proven),
        cmocka_unit_test(bounds_are_tight),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
