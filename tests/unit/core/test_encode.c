/* test_encode.c: codes of unit vectors against a search in long double: over all codes where there
 * are 65,536, else over those around. Directions of whole numbers have ties, which long double
 * decides without rounding. Every kernel gives the same codes: norma_encode_normals takes the best
 * and offers no choice, so its source is compiled here once more, with one. */
#include "core/call/call.h"
static core_level chosen_level(norma_isa isa);
#define norma_core_level         chosen_level
#define norma_encode_normals     encode_as_chosen
#define norma_decode_normals     decode_as_chosen
#define norma_encoding_error_rad error_as_chosen
#define norma_encode_snorm8      encode_8_unchosen
#define norma_encode_snorm16     encode_16_unchosen
#define norma_decode_snorm8      decode_8_unchosen
#define norma_decode_snorm16     decode_16_unchosen
#include "core/matrix/encode.c"
#undef norma_core_level
#undef norma_encode_normals
#undef norma_decode_normals
#undef norma_encoding_error_rad
#undef norma_encode_snorm8
#undef norma_encode_snorm16
#undef norma_decode_snorm8
#undef norma_decode_snorm16

#include "check.h"
#include "oracle/shapes.h"
#include <pthread.h>

static core_level chosen = CORE_PORTABLE;
static core_level chosen_level(norma_isa isa) { return (void)isa, chosen; }

static const norma_encoding all[] = {
    NORMA_ENCODING_OCT8, NORMA_ENCODING_OCT12, NORMA_ENCODING_OCT16, NORMA_ENCODING_10_10_10_2};
static const int bits_of_all[] = {8, 12, 16, 10};

static uint32_t code_of(norma_encoding encoding, double x, double y, double z) {
    const double n[3] = {x, y, z};
    uint32_t code = 0xdeadbeef;
    assert_ok(norma_encode_normals(
        (norma_vec3_view){n, 1, 0, NORMA_FORMAT_DOUBLE}, encoding, &code, 0, 1, NULL));
    return code;
}

static void vector_of(norma_encoding encoding, uint32_t code, float out[3]) {
    assert_ok(norma_decode_normals(&code, 0, 1, encoding, out, 0));
}

/* ---- decoding: the formula in long double */

static long double number_of(uint32_t code, int from, int bits) {
    long value = (long)(code >> from & ((1UL << bits) - 1));
    if (value >= 1L << (bits - 1)) value -= 1L << bits;
    const long double number = (long double)value / (long double)((1L << (bits - 1)) - 1);
    return number < -1 ? -1 : number;
}

static void formula(int encoding, uint32_t code, long double v[3]) {
    const int bits = bits_of_all[encoding];
    const long double x = number_of(code, 0, bits), y = number_of(code, bits, bits);
    v[0] = x, v[1] = y, v[2] = 1 - fabsl(x) - fabsl(y);
    if (encoding == NORMA_ENCODING_10_10_10_2) v[2] = number_of(code, 20, 10);
    if (encoding != NORMA_ENCODING_10_10_10_2 && v[2] < 0) {
        v[0] = copysignl(1 - fabsl(y), x);
        v[1] = copysignl(1 - fabsl(x), y);
    }
}

static long double square_of(const long double v[3]) {
    return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

/* The square of the sine. */
static long double off(const long double a[3], const long double b[3]) {
    const long double c[3] = {
        a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    return square_of(c) / (square_of(a) * square_of(b));
}

static void check_formula(int encoding, uint32_t code) {
    long double exact[3], v[3];
    float got[3];
    formula(encoding, code, exact);
    vector_of(all[encoding], code, got);
    for (int k = 0; k < 3; ++k) v[k] = (long double)got[k];
    if (square_of(exact) == 0) {
        assert_true(got[0] == 0 && got[1] == 0 && got[2] == 1);
        return;
    }
    assert_true(off(v, exact) < 0x1p-48L * 1.0001L); /* a float's rounding */
    assert_true(v[0] * exact[0] + v[1] * exact[1] + v[2] * exact[2] > 0);
    assert_true(fabsl(sqrtl(square_of(v)) - 1) < 1.5e-7L);
}

static void decoding_is_the_formula(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (uint32_t code = 0; code < 65536; ++code) check_formula(NORMA_ENCODING_OCT8, code);
    for (int round = 0; round < 200000 / SLOWER; ++round)
        for (int e = 0; e < 4; ++e) check_formula(e, shape_random(&seed));
    check_formula(NORMA_ENCODING_10_10_10_2, 0);
    check_formula(NORMA_ENCODING_10_10_10_2, 3u << 30);
    float a[3], b[3];
    vector_of(NORMA_ENCODING_OCT8, 0x12340000u | 0x80, a); /* below -1; unused bits */
    vector_of(NORMA_ENCODING_OCT8, 0x81, b);
    assert_memory_equal(a, b, sizeof a);
}

/* ---- encoding: the nearest */

/* The square of the cosine, without a rounding before the last division where n has small whole
 * numbers: so that ties are equal. */
static long double closeness(const long double n[3], const float v[3]) {
    const long double f[3] = {(long double)v[0], (long double)v[1], (long double)v[2]};
    const long double dot = n[0] * f[0] + n[1] * f[1] + n[2] * f[2];
    return dot > 0 ? dot * dot / square_of(f) : -1;
}

static float oct8_vectors[65536][3];

static void all_oct8_vectors(void) {
    static uint32_t codes[65536];
    for (uint32_t code = 0; code < 65536; ++code) codes[code] = code;
    assert_ok(norma_decode_normals(codes, 0, 65536, NORMA_ENCODING_OCT8, oct8_vectors[0], 0));
}

static uint32_t nearest_oct8(const long double n[3]) {
    long double most = -1;
    uint32_t best = 0;
    for (uint32_t code = 0; code < 65536; ++code) {
        const long double c = closeness(n, oct8_vectors[code]);
        if (c <= most) continue;
        most = c;
        best = code;
    }
    return best;
}

static void oct8_is_the_nearest_of_all(void **state) {
    (void)state;
    uint64_t seed = 2;
    all_oct8_vectors();
    for (int i = 0; i < 9 * 9 * 9; i += SLOWER) {
        const long double n[3] = {i % 9 - 4, i / 9 % 9 - 4, i / 81 - 4};
        if (square_of(n) == 0) continue;
        assert_int_equal(code_of(NORMA_ENCODING_OCT8, (double)n[0], (double)n[1], (double)n[2]),
            nearest_oct8(n));
    }
    for (int round = 0; round < 500 / SLOWER; ++round) {
        long double n[3];
        for (int k = 0; k < 3; ++k) n[k] = shape_random_unit(&seed);
        assert_int_equal(code_of(NORMA_ENCODING_OCT8, (double)n[0], (double)n[1], (double)n[2]),
            nearest_oct8(n));
    }
}

enum { STEPS = 3, AROUND = (2 * STEPS + 1) * (2 * STEPS + 1) };

/* All codes within some steps of n in the square; what leaves it over an edge comes back folded. */
static int octahedral_codes_around(int encoding, const long double n[3], uint32_t codes[AROUND]) {
    const int bits = bits_of_all[encoding], most = (1 << (bits - 1)) - 1;
    const long double sum = fabsl(n[0]) + fabsl(n[1]) + fabsl(n[2]);
    long double x = n[0] / sum, y = n[1] / sum;
    if (n[2] < 0) {
        const long double u = copysignl(1 - fabsl(y), x);
        y = copysignl(1 - fabsl(x), y);
        x = u;
    }
    for (int i = 0; i < AROUND; ++i) {
        long u = lroundl(x * most) + i % (2 * STEPS + 1) - STEPS,
             v = lroundl(y * most) + i / (2 * STEPS + 1) - STEPS;
        if (labs(u) > most) u = u < 0 ? -2L * most - u : 2L * most - u, v = -v;
        if (labs(v) > most) v = v < 0 ? -2L * most - v : 2L * most - v, u = -u;
        codes[i] = ((uint32_t)u & ((1u << bits) - 1)) | ((uint32_t)v & ((1u << bits) - 1)) << bits;
    }
    return AROUND;
}

static int on_an_axis(const long double n[3]) {
    return (n[0] != 0) + (n[1] != 0) + (n[2] != 0) == 1;
}

/* Those after *sure: whether they are within a step is beyond long double. */
static int codes_within_a_step(const long double n[3], uint32_t codes[AROUND], int *sure) {
    const long double scale = 511 / sqrtl(square_of(n));
    int count = 0;
    for (int doubtful = 0; doubtful < 2; ++doubtful) {
        for (int i = 0; i < 27; ++i) {
            const int step[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
            long double furthest = 0;
            uint32_t code = 0;
            for (int k = 0; k < 3; ++k) {
                const long number = lroundl(n[k] * scale) + step[k];
                furthest = fmaxl(furthest, fabsl((long double)number - n[k] * scale));
                code |= ((uint32_t)number & 1023) << (10 * k);
            }
            const int near = fabsl(furthest - 1) < 1e-15L && !on_an_axis(n);
            codes[count] = code;
            count += doubtful ? near : furthest < 1 && !near;
        }
        if (!doubtful) *sure = count;
    }
    return count;
}

static void check_nearest(int encoding, const double given[3]) {
    const long double n[3] = {given[0], given[1], given[2]};
    const uint32_t code = code_of(all[encoding], given[0], given[1], given[2]);
    uint32_t codes[AROUND];
    float mine[3], other[3];
    int sure = AROUND;
    const int count = encoding == NORMA_ENCODING_10_10_10_2
                          ? codes_within_a_step(n, codes, &sure)
                          : octahedral_codes_around(encoding, n, codes);
    vector_of(all[encoding], code, mine);
    const long double v[3] = {(long double)mine[0], (long double)mine[1], (long double)mine[2]};
    const long double own = off(n, v);
    int found = 0;
    assert_true(own <= sinl(norma_encoding_error_rad(all[encoding])) *
                           sinl(norma_encoding_error_rad(all[encoding])));
    for (int i = 0; i < count; ++i) {
        vector_of(all[encoding], codes[i], other);
        const long double w[3] = {
            (long double)other[0], (long double)other[1], (long double)other[2]};
        const int same = memcmp(mine, other, sizeof mine) == 0;
        found |= same;
        if (i >= sure) continue;
        assert_true(own <= off(n, w) * (1 + 1e-13L) + 1e-34L);
        if (same) assert_true(code <= codes[i]);
    }
    assert_true(found);
}

static void the_nearest_of_those_around(void **state) {
    (void)state;
    uint64_t seed = 3;
    for (int e = 0; e < 4; ++e) {
        for (int round = 0; round < 20000 / SLOWER; ++round) {
            double n[3];
            for (int k = 0; k < 3; ++k) n[k] = shape_random_unit(&seed);
            if (round % 4 == 1) n[round % 3] *= 1e-3; /* near edges */
            if (round % 4 == 2) n[round % 3] *= 100;  /* near axes */
            if (round % 8 == 3) n[round % 3] = 0;
            if (round % 8 == 7) n[(round + 1) % 3] = n[round % 3] * (1 + 1e-15 * (round % 5));
            check_nearest(e, n);
        }
        for (int i = 0; i < 13 * 13 * 13; i += SLOWER) {
            const double n[3] = {i % 13 - 6, i / 13 % 13 - 6, i / 169 - 6};
            if (n[0] != 0 || n[1] != 0 || n[2] != 0) check_nearest(e, n);
        }
    }
}

/* Close to the line between two points that are neighbours: by as little as a double can say. */
static void next_to_a_tie(void **state) {
    (void)state;
    uint64_t seed = 4;
    for (int round = 0; round < 3000 / SLOWER; ++round) {
        const uint32_t x = shape_random(&seed) % 10000, y = shape_random(&seed) % 10000 + 1;
        float a[3], b[3];
        vector_of(NORMA_ENCODING_OCT16, x | y << 16, a);
        vector_of(NORMA_ENCODING_OCT16, round % 2 ? (x + 1) | y << 16 : (x + 1) | (y - 1) << 16, b);
        double n[3];
        for (int k = 0; k < 3; ++k) n[k] = (double)a[k] + (double)b[k];
        for (int step = -2; step <= 2; ++step) {
            double moved[3] = {n[0] + step * 0x1p-52, n[1], n[2]};
            check_nearest(NORMA_ENCODING_OCT16, moved);
        }
    }
}

/* 511 n has a whole number, but for a double's rounding: whether the next one below or above it is
 * less than a step away. */
static void next_to_whole_numbers(void **state) {
    (void)state;
    uint64_t seed = 6;
    for (int round = 0; round < 20000 / SLOWER; ++round) {
        const double whole = shape_random(&seed) % 510 + 1, turn = 4 * shape_random_unit(&seed),
                     beside = sqrt(511 * 511 - whole * whole);
        const double n[3] = {whole, beside * cos(turn), beside * sin(turn)};
        check_nearest(NORMA_ENCODING_10_10_10_2, n);
    }
}

/* Where x = y, the code with x and y exchanged is as near. */
static void of_two_the_lower(void **state) {
    (void)state;
    uint64_t seed = 7;
    for (int round = 0; round < 20000 / SLOWER; ++round)
        for (int e = 0; e < 4; ++e) {
            const double x = shape_random_unit(&seed), z = shape_random_unit(&seed);
            const int bits = bits_of_all[e];
            const uint32_t code = code_of(all[e], x, x, z), mask = (1u << bits) - 1,
                           low = code & mask, middle = code >> bits & mask;
            assert_true(low >= middle);
        }
}

static void known_codes(void **state) {
    (void)state;
    const norma_encoding oct8 = NORMA_ENCODING_OCT8, tens = NORMA_ENCODING_10_10_10_2;
    assert_int_equal(code_of(oct8, 0, 0, 1), 0);
    assert_int_equal(code_of(oct8, 5, 0, 0), 0x007f);
    assert_int_equal(code_of(oct8, 0, 0.1, 0), 0x7f00);
    assert_int_equal(code_of(oct8, -1, 0, 0), 0x0080); /* -128 and -127 mean -1 */
    assert_int_equal(code_of(oct8, 0, -1, 0), 0x8000);
    assert_int_equal(code_of(oct8, 0, 0, -1), 0x7f7f);      /* all four corners */
    assert_int_equal(code_of(oct8, 1, 1, 0), 0x3f40);       /* or 0x403f */
    assert_int_equal(code_of(oct8, 1, 1, 1), 0x2a2a);       /* or 0x2a2b, 0x2b2a */
    assert_int_equal(code_of(oct8, 1, 0, -1), 0x3f7f);      /* or 0x407f, and below the edge */
    assert_int_equal(code_of(oct8, 127 - 8, 5, 3), 0x0577); /* a point */
    assert_int_equal(code_of(oct8, -119, 5, -3), 0x0886);   /* (-122, 8) */
    assert_int_equal(code_of(NORMA_ENCODING_OCT12, 2047 - 8, 5, 3), 0x0057f7);
    assert_int_equal(code_of(NORMA_ENCODING_OCT12, 0, -3, 0), 0x800000);
    assert_int_equal(code_of(NORMA_ENCODING_OCT16, 5, 32767 - 8, 3), 0x7ff70005u);
    assert_int_equal(code_of(NORMA_ENCODING_OCT16, -1, 0, 0), 0x00008000u);
    assert_int_equal(code_of(tens, 0, 0, 7), 511u << 20);
    assert_int_equal(code_of(tens, -0.3, 0, 0), 0x201); /* -511 */
    assert_int_equal(code_of(tens, 2, 3, 6), 146u | 219u << 10 | 438u << 20);
    assert_int_equal(code_of(tens, -2, -3, 6), 878u | 805u << 10 | 438u << 20);
    assert_int_equal(code_of(tens, 1e-4, 0, 1), 510u << 20); /* 510 and 511 mean 1 */
}

/* ---- what is not a direction, lengths, formats, arguments */

static void any_length_and_none(void **state) {
    (void)state;
    const double in[7][3] = {{0, 0, 0}, {1e-310, 2e-310, -3e-310}, {NAN, 1, 0}, {-0.0, 0, 0},
        {1e300, 2e300, -3e300}, {0, INFINITY, 1}, {1, 2, -3}};
    for (int e = 0; e < 4; ++e) {
        uint32_t codes[7];
        norma_report report;
        assert_ok(norma_encode_normals(
            (norma_vec3_view){in, 7, 0, NORMA_FORMAT_DOUBLE}, all[e], codes, 0, 7, &report));
        const uint32_t up = code_of(all[e], 0, 0, 1);
        for (int i = 0; i < 6; ++i) assert_int_equal(codes[i], i % 3 == 1 ? codes[6] : up);
        assert_int_equal(report.cancelled.count, 2);
        assert_int_equal(report.cancelled.first, 0);
        assert_int_equal(report.non_finite.count, 2);
        assert_int_equal(report.non_finite.first, 2);
        assert_int_equal(report.unreferenced.count, 0);
        assert_true(report.unreferenced.first == SIZE_MAX);
        const int16_t shorts[3] = {-7, 300, 12};
        uint32_t code;
        assert_ok(norma_encode_normals(
            (norma_vec3_view){shorts, 1, 0, NORMA_FORMAT_INT16}, all[e], &code, 0, 1, &report));
        assert_int_equal(code, code_of(all[e], -7, 300, 12));
        assert_int_equal(report.cancelled.count + report.non_finite.count, 0);
    }
}

static void strides_and_arguments(void **state) {
    (void)state;
    const float in[2][3] = {{0, 0, 1}, {1, 0, 0}};
    const norma_vec3_view view = {in, 2, 0, NORMA_FORMAT_FLOAT};
    const norma_encoding e = NORMA_ENCODING_OCT16;
    const norma_encoding none = (norma_encoding)4;
    uint32_t codes[4] = {9, 9, 9, 9};
    float out[8];
    assert_int_equal(norma_encode_normals(view, none, codes, 0, 2, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_encode_normals(view, e, NULL, 0, 2, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_encode_normals(view, e, codes, 3, 2, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_encode_normals(view, e, codes, 0, 1, NULL), NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_encode_normals(view, e, codes, SIZE_MAX, 2, NULL), NORMA_ERROR_OVERFLOW);
    assert_int_equal(norma_encode_normals(
                         (norma_vec3_view){NULL, 2, 0, NORMA_FORMAT_FLOAT}, e, codes, 0, 2, NULL),
        NORMA_ERROR_ARGUMENT);
    assert_ok(norma_encode_normals((norma_vec3_view){0}, e, NULL, 0, 0, NULL));
    for (int i = 0; i < 4; ++i) assert_int_equal(codes[i], 9);
    assert_ok(norma_encode_normals(view, e, codes, 8, 2, NULL));
    assert_int_equal(codes[0], 0);
    assert_int_equal(codes[1], 9);
    assert_int_equal(codes[2], 32767);
    assert_int_equal(codes[3], 9);

    for (int i = 0; i < 8; ++i) out[i] = 5;
    assert_int_equal(norma_decode_normals(codes, 8, 2, none, out, 0), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_decode_normals(NULL, 8, 2, e, out, 0), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_decode_normals(codes, 2, 2, e, out, 0), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_decode_normals(codes, 8, 2, e, NULL, 0), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_decode_normals(codes, 8, 2, e, out, 11), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_decode_normals(codes, SIZE_MAX, 2, e, out, 0), NORMA_ERROR_OVERFLOW);
    assert_int_equal(norma_decode_normals(codes, 0, 2, e, out, SIZE_MAX), NORMA_ERROR_OVERFLOW);
    assert_ok(norma_decode_normals(NULL, 0, 0, e, NULL, 0));
    for (int i = 0; i < 8; ++i) assert_true(out[i] == 5);
    assert_ok(norma_decode_normals(codes, 8, 2, e, out, 16));
    const float expected[8] = {0, 0, 1, 5, 1, 0, 0, 5};
    assert_memory_equal(out, expected, sizeof out);

    unsigned char odd[9]; /* no number has to lie at a multiple of its size */
    void *at = odd + 1;
    assert_ok(norma_encode_normals(view, e, (uint32_t *)at, 0, 2, NULL));
    assert_ok(norma_decode_normals((const uint32_t *)at, 0, 2, e, out, 16));
    assert_memory_equal(out, expected, sizeof out);
    assert_true(isinf(norma_encoding_error_rad(none)));
}

/* ---- many at once */

enum { NORMALS = 100003, PARTS = 4 };
static float normals[NORMALS][3];
static uint32_t alone[NORMALS], together[NORMALS];

static void make_normals(void) {
    uint64_t seed = 5;
    for (int i = 0; i < NORMALS; ++i) {
        for (int k = 0; k < 3; ++k) normals[i][k] = (float)shape_random_unit(&seed);
        if (i % 16 == 0) normals[i][i / 16 % 3] = normals[i][(i / 16 + 1) % 3];
        if (i % 16 == 1) normals[i][i / 16 % 3] = 0;
        if (i % 256 == 2) normals[i][0] = NAN;
        if (i % 256 == 3) normals[i][0] = normals[i][1] = normals[i][2] = 0;
    }
}

static void every_kernel_gives_the_same_codes(void **state) {
    (void)state;
    static float back[2][NORMALS][3];
    const core_level best = norma_core_level(NORMA_ISA_BEST);
    make_normals();
    const norma_vec3_view view = {normals, NORMALS, 0, NORMA_FORMAT_FLOAT};
    for (int e = 0; e < 4; ++e) {
        chosen = CORE_PORTABLE;
        assert_ok(encode_as_chosen(view, all[e], alone, 0, NORMALS, NULL));
        assert_ok(decode_as_chosen(alone, 0, NORMALS, all[e], back[0][0], 0));
        for (int level = CORE_PORTABLE; level <= (int)best; ++level) {
            chosen = (core_level)level;
            assert_ok(encode_as_chosen(view, all[e], together, 0, NORMALS, NULL));
            assert_ok(decode_as_chosen(together, 0, NORMALS, all[e], back[1][0], 0));
            assert_memory_equal(alone, together, sizeof alone);
            assert_memory_equal(back[0], back[1], sizeof back[0]);
        }
        assert_ok(norma_encode_normals(view, all[e], together, 0, NORMALS, NULL));
        assert_memory_equal(alone, together, sizeof alone);
    }
}

/* The same on every machine and with every compiler: nearest codes are, whatever computes them;
 * that they are nearest is tested above. */
static void same_codes_everywhere(void **state) {
    (void)state;
    static const uint32_t expected[] = {0xbc25ae0f, 0x6cebfca4, 0x89deb89e, 0x2922071a};
    make_normals();
    for (int e = 0; e < 4; ++e) {
        uint32_t hash = 2166136261u;
        assert_ok(norma_encode_normals((norma_vec3_view){normals, NORMALS, 0, NORMA_FORMAT_FLOAT},
            all[e], alone, 0, NORMALS, NULL));
        for (int i = 0; i < NORMALS; ++i) hash = (hash ^ alone[i]) * 16777619u;
        assert_int_equal(hash, expected[e]);
    }
}

static void *encode_part(void *context) {
    const size_t part = *(const size_t *)context, first = part * (NORMALS / PARTS),
                 count = part + 1 < PARTS ? NORMALS / PARTS : NORMALS - first;
    for (int round = 0; round < 4; ++round)
        if (norma_encode_normals((norma_vec3_view){normals[first], count, 0, NORMA_FORMAT_FLOAT},
                NORMA_ENCODING_OCT16, together + first, 0, count, NULL))
            abort();
    return NULL;
}

static void callers_at_once(void **state) {
    (void)state;
    pthread_t threads[PARTS];
    size_t parts[PARTS];
    make_normals();
    memset(together, 0, sizeof together);
    assert_ok(norma_encode_normals((norma_vec3_view){normals, NORMALS, 0, NORMA_FORMAT_FLOAT},
        NORMA_ENCODING_OCT16, alone, 0, NORMALS, NULL));
    for (size_t i = 0; i < PARTS; ++i) {
        parts[i] = i;
        assert_int_equal(pthread_create(&threads[i], NULL, encode_part, &parts[i]), 0);
    }
    for (size_t i = 0; i < PARTS; ++i) pthread_join(threads[i], NULL);
    assert_memory_equal(alone, together, sizeof alone);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(decoding_is_the_formula),
        cmocka_unit_test(oct8_is_the_nearest_of_all),
        cmocka_unit_test(the_nearest_of_those_around),
        cmocka_unit_test(next_to_a_tie),
        cmocka_unit_test(next_to_whole_numbers),
        cmocka_unit_test(of_two_the_lower),
        cmocka_unit_test(known_codes),
        cmocka_unit_test(any_length_and_none),
        cmocka_unit_test(strides_and_arguments),
        cmocka_unit_test(every_kernel_gives_the_same_codes),
        cmocka_unit_test(same_codes_everywhere),
        cmocka_unit_test(callers_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
