/* encode.c: unit vectors in 16 to 32 bits, and back; and as signed normalised integers.
 *
 * A code names a point with whole coordinates, and means the direction to it, rounded to floats.
 * NORMA_ENCODING_10_10_10_2 holds the three coordinates. The octahedral encodings (Meyer
 * et al. 2010, On Floating-Point Normal Vectors) hold x and y of a point of the octahedron |x| +
 * |y| + |z| = most, whose lower half is folded outward over the edges of the upper one.
 *
 * Points and their floats are the same in all octants and for any order of the axes. So the nearest
 * is looked for among positive coordinates. On an octahedron, the two smaller coordinates form a
 * square grid that diagonals cut into triangles. None of these triangles is obtuse, seen from the
 * centre, so the nearest point is a corner of the triangle that the normal passes through, and
 * therefore of its square.
 *
 * Angles are compared in doubles, with a bound of their error, and exactly where that does not
 * decide. */
#include "core/matrix/matrix.h"

enum { CODES = 16 }; /* that are computed side by side */

typedef struct encoding_numbers {
    int bits;         /* of each number in a code */
    int32_t most;     /* the number that stands for 1 */
    double error_rad; /* proven by tests/unit/core/test_encode_bounds.c */
} encoding_numbers;

static const encoding_numbers numbers_of[] = {
    [NORMA_ENCODING_OCT8] = {8, 127, 0.01113515},
    [NORMA_ENCODING_OCT12] = {12, 2047, 0.00069094},
    [NORMA_ENCODING_OCT16] = {16, 32767, 0.00004322},
    [NORMA_ENCODING_10_10_10_2] = {10, 511, 0.00138383},
};

static const encoding_numbers *numbers_or_null(norma_encoding encoding) {
    const size_t index = (size_t)encoding;
    return index < sizeof numbers_of / sizeof *numbers_of ? &numbers_of[index] : NULL;
}

double norma_encoding_error_rad(norma_encoding encoding) {
    const encoding_numbers *numbers = numbers_or_null(encoding);
    return numbers ? numbers->error_rad : INFINITY;
}

/* ---- from code to point to direction */

CORE_INLINE int32_t number_in_code(uint32_t code, int place, int bits, int32_t most) {
    const uint32_t sign = (uint32_t)1 << (bits - 1),
                   number = code >> (place * bits) & (2 * sign - 1);
    const int32_t value = (int32_t)(number ^ sign) - (int32_t)sign;
    return value < -most ? -most : value;
}

CORE_INLINE int32_t magnitude_of(int32_t number) { return number < 0 ? -number : number; }

/* Across the edges of the upper half, and back. */
CORE_INLINE void fold_octahedron(int32_t most, int32_t *x, int32_t *y) {
    const int32_t across_x = most - magnitude_of(*y), across_y = most - magnitude_of(*x);
    *x = *x < 0 ? -across_x : across_x;
    *y = *y < 0 ? -across_y : across_y;
}

CORE_INLINE void point_of_code(
    uint32_t code, int octahedral, const encoding_numbers *numbers, int32_t point[3]) {
    const int bits = numbers->bits;
    const int32_t most = numbers->most;
    int32_t x = number_in_code(code, 0, bits, most), y = number_in_code(code, 1, bits, most);
    if (!octahedral) {
        point[2] = number_in_code(code, 2, bits, most);
    } else {
        int32_t folded_x = x, folded_y = y;
        fold_octahedron(most, &folded_x, &folded_y);
        point[2] = most - magnitude_of(x) - magnitude_of(y);
        x = point[2] < 0 ? folded_x : x;
        y = point[2] < 0 ? folded_y : y;
    }
    point[0] = x;
    point[1] = y;
}

/* The sum of the squares is exact before it is rounded, for the same floats in any order. */
CORE_INLINE void direction_of_point(const int32_t point[3], float direction[3]) {
    const int32_t square = point[0] * point[0] + point[1] * point[1] + point[2] * point[2];
    const float length = sqrtf((float)square);
    for (int i = 0; i < 3; ++i) direction[i] = square ? (float)point[i] / length : (float)(i == 2);
}

typedef struct decode_lanes {
    uint32_t code[CODES];
    float normal[3][CODES];
} decode_lanes;

CORE_INLINE void decode_all_lanes(
    decode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    for (int i = 0; i < CODES; ++i) {
        int32_t point[3];
        float direction[3];
        point_of_code(l->code[i], octahedral, numbers, point);
        direction_of_point(point, direction);
        for (int k = 0; k < 3; ++k) l->normal[k][i] = direction[k];
    }
}

/* ---- from direction to point */

typedef struct encode_lanes {
    double normal[3][CODES]; /* neither zero, nor so long or short that squares lose anything */
    uint32_t code[CODES];
    int certain[CODES];
} encode_lanes;

/* The square of the sine of the angle between a vector and the floats of a point, times that of the
 * vector's length. A product of cross products loses less than 1e-15 of the length. */
CORE_INLINE double square_off(double x, double y, double z, double i, double j, double k) {
    const float length = sqrtf((float)(i * i + j * j + k * k));
    const double a = (double)((float)i / length), b = (double)((float)j / length),
                 c = (double)((float)k / length);
    const double u = y * c - z * b, v = z * a - x * c, w = x * b - y * a;
    return (u * u + v * v + w * w) / (a * a + b * b + c * c);
}

/* Whether two such squares differ by more than their errors, which are at most 4e-15 times the
 * larger sine: less than 1e-9 of the square, or 4e-21. */
CORE_INLINE int squares_differ(double less, double more, double vector_square) {
    return more - less > 1e-9 * more + 4e-21 * vector_square;
}

typedef struct nearest_two {
    double least, second, i, j, k; /* the point for which it is least */
} nearest_two;

CORE_INLINE nearest_two with_point(nearest_two r, double off, double i, double j, double k) {
    const int nearer = off < r.least;
    const double beside = off < r.second ? off : r.second;
    return (nearest_two){nearer ? off : r.least, nearer ? r.least : beside, nearer ? i : r.i,
        nearer ? j : r.j, nearer ? k : r.k};
}

/* The lowest code of a point: a number that stands for 1 below 0 has two, and so have points of the
 * lower half's edges. */
CORE_INLINE uint32_t code_of_point(
    int32_t x, int32_t y, int32_t z, int octahedral, const encoding_numbers *numbers) {
    const uint32_t mask = ((uint32_t)1 << numbers->bits) - 1;
    if (!octahedral)
        return ((uint32_t)x & mask) | ((uint32_t)y & mask) << 10 | ((uint32_t)z & mask) << 20;
    int32_t folded_x = x, folded_y = y;
    fold_octahedron(numbers->most, &folded_x, &folded_y);
    x = z < 0 ? folded_x : x;
    y = z < 0 ? folded_y : y;
    x -= x == -numbers->most;
    y -= y == -numbers->most;
    return ((uint32_t)x & mask) | ((uint32_t)y & mask) << numbers->bits;
}

/* The code of the point in the octant of a normal. */
CORE_INLINE uint32_t code_in_octant(const double normal[3], int32_t x, int32_t y, int32_t z,
    int octahedral, const encoding_numbers *numbers) {
    return code_of_point(normal[0] < 0.0 ? -x : x, normal[1] < 0.0 ? -y : y,
        normal[2] < 0.0 ? -z : z, octahedral, numbers);
}

/* The four points about a normal. Its largest coordinate becomes a, by two exchanges: y and x, then
 * z and the larger of them. */
CORE_INLINE void encode_octahedral(encode_lanes *l, const encoding_numbers *numbers) {
    const double most = numbers->most;
    for (int lane = 0; lane < CODES; ++lane) {
        const double n[3] = {l->normal[0][lane], l->normal[1][lane], l->normal[2][lane]};
        const double x = fabs(n[0]), y = fabs(n[1]), z = fabs(n[2]);
        const double larger = y > x ? y : x, b = y > x ? x : y, a = z > larger ? z : larger,
                     c = z > larger ? larger : z, scale = most / (x + y + z);
        const double j = (double)(int32_t)(b * scale), k = (double)(int32_t)(c * scale),
                     i = most - j - k;
        nearest_two r = {INFINITY, INFINITY, 0.0, 0.0, 0.0};
        r = with_point(r, square_off(a, b, c, i, j, k), i, j, k);
        r = with_point(r, square_off(a, b, c, i - 1, j + 1, k), i - 1, j + 1, k);
        r = with_point(r, square_off(a, b, c, i - 1, j, k + 1), i - 1, j, k + 1);
        r = with_point(r, square_off(a, b, c, i - 2, j + 1, k + 1), i - 2, j + 1, k + 1);
        const double back = z > larger ? r.k : r.i;
        l->certain[lane] = squares_differ(r.least, r.second, x * x + y * y + z * z);
        l->code[lane] = code_in_octant(n, (int32_t)(y > x ? r.j : back),
            (int32_t)(y > x ? back : r.j), (int32_t)(z > larger ? r.i : r.k), 1, numbers);
    }
}

CORE_INLINE int near_whole(double number) {
    return (number > 0.0) & (fabs(number - (double)(int32_t)(number + 0.5)) < 1e-9);
}

/* The eight points about 511 n; four where a coordinate is 0. */
CORE_INLINE void encode_tens(encode_lanes *l, const encoding_numbers *numbers) {
    for (int lane = 0; lane < CODES; ++lane) {
        const double n[3] = {l->normal[0][lane], l->normal[1][lane], l->normal[2][lane]};
        const double x = fabs(n[0]), y = fabs(n[1]), z = fabs(n[2]), square = x * x + y * y + z * z,
                     scale = numbers->most / sqrt(square);
        const double p = x * scale, q = y * scale, r = z * scale;
        const double i = (double)(int32_t)p, j = (double)(int32_t)q, k = (double)(int32_t)r;
        const double no_i = p > i ? 0.0 : INFINITY, no_j = q > j ? 0.0 : INFINITY,
                     no_k = r > k ? 0.0 : INFINITY;
        nearest_two s = {INFINITY, INFINITY, 0.0, 0.0, 0.0};
        s = with_point(s, square_off(x, y, z, i, j, k), i, j, k);
        s = with_point(s, square_off(x, y, z, i + 1, j, k) + no_i, i + 1, j, k);
        s = with_point(s, square_off(x, y, z, i, j + 1, k) + no_j, i, j + 1, k);
        s = with_point(s, square_off(x, y, z, i + 1, j + 1, k) + (no_i + no_j), i + 1, j + 1, k);
        s = with_point(s, square_off(x, y, z, i, j, k + 1) + no_k, i, j, k + 1);
        s = with_point(s, square_off(x, y, z, i + 1, j, k + 1) + (no_i + no_k), i + 1, j, k + 1);
        s = with_point(s, square_off(x, y, z, i, j + 1, k + 1) + (no_j + no_k), i, j + 1, k + 1);
        s = with_point(s, square_off(x, y, z, i + 1, j + 1, k + 1) + (no_i + no_j + no_k), i + 1,
            j + 1, k + 1);
        l->certain[lane] = squares_differ(s.least, s.second, square) &
                           !(near_whole(p) | near_whole(q) | near_whole(r));
        l->code[lane] = code_in_octant(n, (int32_t)s.i, (int32_t)s.j, (int32_t)s.k, 0, numbers);
    }
}

/* ---- where doubles do not decide: one normal at a time, of positive coordinates */

/* The sign of (n.f)^2 |g|^2 - (n.g)^2 |f|^2: whether f is nearer in angle than g. */
static int exactly_nearer(const double n[3], const float f[3], const float g[3]) {
    exact_sum sum;
    norma_exact_clear(&sum);
    for (int p = 0; p < 3; ++p)
        for (int q = 0; q < 3; ++q)
            for (int r = 0; r < 3; ++r) { /* the product of two floats is exact in a double */
                const double ff = (double)f[p] * (double)f[q], gg = (double)g[r] * (double)g[r],
                             hh = (double)g[p] * (double)g[q], ee = (double)f[r] * (double)f[r];
                norma_exact_add(&sum, (const double[]){n[p], n[q], ff, gg}, 4, 0);
                norma_exact_add(&sum, (const double[]){n[p], n[q], hh, ee}, 4, 1);
            }
    const double sign = norma_exact_round(&sum).mantissa;
    return (sign > 0.0) - (sign < 0.0);
}

/* Ties that meshes are full of: points in one direction, whose coordinates are 0 or alike, and two
 * that exchange coordinates of which the normal has two alike. */
static int plainly_tied(const double n[3], const int32_t p[3], const int32_t q[3]) {
    int parallel = 1;
    for (int k = 0; k < 3; ++k) {
        const int u = (k + 1) % 3, v = (k + 2) % 3;
        if (p[k] == q[k] && p[u] == q[v] && p[v] == q[u] && !(n[u] < n[v]) && !(n[u] > n[v]))
            return 1;
        parallel &= p[u] * q[v] == p[v] * q[u];
    }
    return parallel;
}

/* 1: p is nearer than q; -1: it is further away; 0: neither. */
static int nearer_point(const double n[3], const int32_t p[3], const int32_t q[3]) {
    const double of_p = square_off(n[0], n[1], n[2], p[0], p[1], p[2]),
                 of_q = square_off(n[0], n[1], n[2], q[0], q[1], q[2]),
                 square = norma_core_dot(n, n);
    float f[3], g[3];
    if (squares_differ(of_p, of_q, square)) return 1;
    if (squares_differ(of_q, of_p, square)) return -1;
    if (plainly_tied(n, p, q)) return 0;
    direction_of_point(p, f);
    direction_of_point(q, g);
    return exactly_nearer(n, f, g);
}

static int points_of_octahedron(const double n[3], int32_t most, int32_t points[8][3]) {
    const int first = n[0] >= n[1] && n[0] >= n[2] ? 0 : (n[1] >= n[2] ? 1 : 2),
              second = (first + 1) % 3, third = (first + 2) % 3;
    const double scale = most / (n[0] + n[1] + n[2]);
    for (int t = 0; t < 4; ++t) {
        int32_t *p = points[t];
        p[second] = (int32_t)(n[second] * scale) + (t & 1);
        p[third] = (int32_t)(n[third] * scale) + (t >> 1);
        p[first] = most - p[second] - p[third];
    }
    return 4;
}

/* The whole numbers less than one step from most n[axis]: one or two. */
static void whole_numbers_about(const double n[3], int axis, int32_t most, int32_t about[2]) {
    const double number = most * n[axis] / sqrt(norma_core_dot(n, n)), square = (double)most * most;
    const int32_t nearest = (int32_t)(number + 0.5);
    about[0] = (int32_t)number;
    about[1] = about[0] + (number > about[0]);
    if (!near_whole(number) || !nearest) return;
    if (n[(axis + 1) % 3] + n[(axis + 2) % 3] == 0.0) { /* along an axis, as in boxes */
        about[0] = about[1] = most;
        return;
    }
    exact_sum sum; /* most^2 n[axis]^2 - nearest^2 |n|^2 */
    norma_exact_clear(&sum);
    norma_exact_add(&sum, (const double[]){square, n[axis], n[axis]}, 3, 0);
    for (int i = 0; i < 3; ++i)
        norma_exact_add(&sum, (const double[]){(double)nearest * nearest, n[i], n[i]}, 3, 1);
    const double sign = norma_exact_round(&sum).mantissa;
    about[0] = nearest - (sign < 0.0);
    about[1] = nearest + (sign > 0.0);
}

static int points_within_a_step(const double n[3], int32_t most, int32_t points[8][3]) {
    int32_t about[3][2];
    int count = 0;
    for (int i = 0; i < 3; ++i) whole_numbers_about(n, i, most, about[i]);
    for (int t = 0; t < 8; ++t) {
        int again = 0;
        for (int i = 0; i < 3; ++i) {
            points[count][i] = about[i][t >> i & 1];
            again |= (t >> i & 1) && about[i][0] == about[i][1];
        }
        count += !again;
    }
    return count;
}

static uint32_t decide_code(
    const double normal[3], int octahedral, const encoding_numbers *numbers) {
    const double n[3] = {fabs(normal[0]), fabs(normal[1]), fabs(normal[2])};
    int32_t points[8][3] = {{0}}, best = 0;
    uint32_t code = 0;
    const int count = octahedral ? points_of_octahedron(n, numbers->most, points)
                                 : points_within_a_step(n, numbers->most, points);
    for (int t = 0; t < count; ++t) {
        const int32_t *p = points[t];
        const int nearer = t ? nearer_point(n, p, points[best]) : 1;
        const uint32_t own = code_in_octant(normal, p[0], p[1], p[2], octahedral, numbers);
        if (nearer < 0 || (nearer == 0 && own > code)) continue;
        best = t;
        code = own;
    }
    return code;
}

/* ---- kernels by instruction set */

typedef void encode_kernel(encode_lanes *l, int octahedral, const encoding_numbers *numbers);
typedef void decode_kernel(decode_lanes *l, int octahedral, const encoding_numbers *numbers);

CORE_INLINE void encode_all_lanes(
    encode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    if (octahedral)
        encode_octahedral(l, numbers);
    else
        encode_tens(l, numbers);
}

static void encode_portable(encode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    encode_all_lanes(l, octahedral, numbers);
}
static void decode_portable(decode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    decode_all_lanes(l, octahedral, numbers);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void encode_avx2(
    encode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    encode_all_lanes(l, octahedral, numbers);
}
CORE_FOR_AVX2 static void decode_avx2(
    decode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    decode_all_lanes(l, octahedral, numbers);
}
#endif
#if defined(CORE_HAS_AVX512)
CORE_FOR_AVX512 static void encode_avx512(
    encode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    encode_all_lanes(l, octahedral, numbers);
}
CORE_FOR_AVX512 static void decode_avx512(
    decode_lanes *l, int octahedral, const encoding_numbers *numbers) {
    decode_all_lanes(l, octahedral, numbers);
}
#endif

static encode_kernel *const ENCODE[] = CORE_KERNELS(encode);
static decode_kernel *const DECODE[] = CORE_KERNELS(decode);

/* ---- arrays */

/* One normal into its lane, at a length at which squares lose nothing; (0, 0, 1) for one without a
 * direction. */
static void load_normal(
    const norma_vec3_view *normals, size_t index, encode_lanes *l, int lane, core_tally *tally) {
    double n[3];
    norma_view_read(normals, index, n);
    const double size = fabs(n[0]) + fabs(n[1]) + fabs(n[2]);
    if (!(size > 1e-100 && size < 1e100)) {
        const int finite = norma_core_finite(n);
        if (!finite || !norma_vec3_scale(n)) {
            norma_core_tally(
                tally, finite ? NORMA_REASON_CANCELLED : NORMA_REASON_NON_FINITE, index);
            n[0] = n[1] = 0.0;
            n[2] = 1.0;
        }
    }
    for (int k = 0; k < 3; ++k) l->normal[k][lane] = n[k];
}

norma_result norma_encode_normals(norma_vec3_view normals, norma_encoding encoding, uint32_t *codes,
    size_t stride, size_t capacity, norma_report *report) {
    const encoding_numbers *numbers = numbers_or_null(encoding);
    const int octahedral = encoding != NORMA_ENCODING_10_10_10_2;
    norma_result result = numbers ? norma_input_check(&normals) : NORMA_ERROR_ARGUMENT;
    if (!result)
        result = norma_output_check(codes, &stride, sizeof *codes, normals.count, capacity);
    if (result) return result;
    encode_kernel *encode = ENCODE[norma_core_level(NORMA_ISA_BEST)];
    core_tally tally = {.non_finite = {0, 0}};
    encode_lanes l;
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < CODES; ++i) l.normal[k][i] = k == 2;
    for (size_t first = 0; first < normals.count; first += CODES) {
        const int count = normals.count - first < CODES ? (int)(normals.count - first) : CODES;
        for (int i = 0; i < count; ++i) load_normal(&normals, first + (size_t)i, &l, i, &tally);
        encode(&l, octahedral, numbers);
        for (int i = 0; i < count; ++i) {
            const double n[3] = {l.normal[0][i], l.normal[1][i], l.normal[2][i]};
            const uint32_t code = l.certain[i] ? l.code[i] : decide_code(n, octahedral, numbers);
            memcpy((unsigned char *)codes + (first + (size_t)i) * stride, &code, sizeof code);
        }
    }
    norma_core_write_report(report, &tally, NULL, NULL);
    return NORMA_OK;
}

norma_result norma_decode_normals(const uint32_t *codes, size_t stride, size_t count,
    norma_encoding encoding, float *normals, size_t normal_stride) {
    const encoding_numbers *numbers = numbers_or_null(encoding);
    norma_result result = NORMA_ERROR_ARGUMENT;
    if (numbers) result = norma_output_check(codes, &stride, sizeof *codes, count, count);
    if (!result)
        result = norma_output_check(normals, &normal_stride, 3 * sizeof *normals, count, count);
    if (result) return result;
    decode_kernel *decode = DECODE[norma_core_level(NORMA_ISA_BEST)];
    decode_lanes l = {.code = {0}};
    for (size_t first = 0; first < count; first += CODES) {
        const size_t size = count - first < CODES ? count - first : CODES;
        for (size_t i = 0; i < size; ++i)
            memcpy(&l.code[i], (const unsigned char *)codes + (first + i) * stride, sizeof *codes);
        decode(&l, encoding != NORMA_ENCODING_10_10_10_2, numbers);
        for (size_t i = 0; i < size; ++i) {
            const float n[3] = {l.normal[0][i], l.normal[1][i], l.normal[2][i]};
            memcpy((unsigned char *)normals + (first + i) * normal_stride, n, sizeof n);
        }
    }
    return NORMA_OK;
}

/* ---- unit vectors as signed normalised integers, c / 127 or c / 32767, and back.
 *
 * Rounding to the nearest code can make a vector whose length a reader no longer takes for 1: the
 * Khronos validator allows 0.00674, and (67, 76, 78) / 127 is 1.00680 long. Then the nearest code
 * that passes is taken; every passing code that can be nearest lies within one step of the rounded
 * one. */

#define LENGTH_TOLERANCE 0.00674 /* of the unit length */

static int passes(const int code[3], int scale) {
    const double square =
        (double)code[0] * code[0] + (double)code[1] * code[1] + (double)code[2] * code[2];
    return fabs(sqrt(square) / scale - 1.0) <= LENGTH_TOLERANCE;
}

static double code_distance(const int code[3], const double target[3]) {
    double sum = 0.0;
    for (int i = 0; i < 3; ++i) sum += (code[i] - target[i]) * (code[i] - target[i]);
    return sum;
}

/* The code nearest to target (a unit vector times scale) among those within a step of rounded; the
 * first of equals. */
static void nearest_passing(const double target[3], int scale, const int rounded[3], int code[3]) {
    double best = DBL_MAX;
    for (int n = 0; n < 27; ++n) {
        const int steps[3] = {n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
        int tried[3];
        for (int i = 0; i < 3; ++i) {
            tried[i] = rounded[i] + steps[i];
            if (tried[i] > scale) tried[i] = scale;
            if (tried[i] < -scale) tried[i] = -scale;
        }
        const double d = code_distance(tried, target);
        if (d < best && passes(tried, scale)) {
            best = d;
            memcpy(code, tried, sizeof tried);
        }
    }
}

/* What has no direction becomes zero. */
static void encode(const double normal[3], int scale, int code[3]) {
    double target[3] = {normal[0], normal[1], normal[2]};
    code[0] = code[1] = code[2] = 0;
    if (!norma_vec3_unit(target)) return;
    int rounded[3];
    for (int i = 0; i < 3; ++i) {
        target[i] *= scale;
        rounded[i] =
            (int)(target[i] +
                  (target[i] < 0.0
                          ? -0.5
                          : 0.5)); /* half away from zero, so that -n gets the negated code */
    }
    if (passes(rounded, scale))
        memcpy(code, rounded, sizeof rounded);
    else
        nearest_passing(target, scale, rounded, code);
}

/* As codes of size bytes each. */
static norma_result encode_all(const norma_vec3_view *normals, int scale, unsigned char *out,
    size_t stride, size_t size, size_t capacity) {
    norma_result result = norma_input_check(normals);
    if (!result) result = norma_output_check(out, &stride, 3 * size, normals->count, capacity);
    if (result) return result;
    for (size_t i = 0; i < normals->count; ++i) {
        double normal[3];
        int code[3];
        norma_view_read(normals, i, normal);
        encode(normal, scale, code);
        const int8_t bytes[3] = {(int8_t)code[0], (int8_t)code[1], (int8_t)code[2]};
        const int16_t shorts[3] = {(int16_t)code[0], (int16_t)code[1], (int16_t)code[2]};
        if (size == sizeof *bytes)
            memcpy(out + i * stride, bytes, sizeof bytes);
        else
            memcpy(out + i * stride, shorts, sizeof shorts);
    }
    return NORMA_OK;
}

norma_result norma_encode_snorm8(
    norma_vec3_view normals, int8_t *out, size_t out_stride, size_t capacity) {
    return encode_all(&normals, 127, (unsigned char *)out, out_stride, sizeof *out, capacity);
}

norma_result norma_encode_snorm16(
    norma_vec3_view normals, int16_t *out, size_t out_stride, size_t capacity) {
    return encode_all(&normals, 32767, (unsigned char *)out, out_stride, sizeof *out, capacity);
}

static norma_result decode_all(
    norma_vec3_view codes, float scale, float *out, size_t out_stride, size_t capacity) {
    norma_result result = norma_input_check(&codes);
    if (!result)
        result = norma_output_check(out, &out_stride, 3 * sizeof *out, codes.count, capacity);
    if (result) return result;
    for (size_t i = 0; i < codes.count; ++i) {
        double code[3];
        float v[3];
        norma_view_read(&codes, i, code);
        for (int c = 0; c < 3; ++c) {
            v[c] = (float)code[c] / scale;
            if (v[c] < -1.0f) v[c] = -1.0f; /* the one code below -scale */
        }
        memcpy((unsigned char *)out + i * out_stride, v, sizeof v);
    }
    return NORMA_OK;
}

norma_result norma_decode_snorm8(const int8_t *codes, size_t stride, size_t count, float *out,
    size_t out_stride, size_t capacity) {
    return decode_all((norma_vec3_view){codes, count, stride, NORMA_FORMAT_INT8}, 127.0f, out,
        out_stride, capacity);
}

norma_result norma_decode_snorm16(const int16_t *codes, size_t stride, size_t count, float *out,
    size_t out_stride, size_t capacity) {
    return decode_all((norma_vec3_view){codes, count, stride, NORMA_FORMAT_INT16}, 32767.0f, out,
        out_stride, capacity);
}
