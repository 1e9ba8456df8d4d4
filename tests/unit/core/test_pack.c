/* test_pack.c: signed normalised integers against the bounds of rounding and an exhaustive search
 * over all codes. */
#include "check.h"

static uint64_t next_random(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

/* Uniform on the sphere: a random point of the ball, made unit. */
static void random_direction(uint64_t *state, double n[3]) {
    double square;
    do {
        square = 0.0;
        for (int i = 0; i < 3; ++i) {
            n[i] = (double)(int64_t)next_random(state) / 0x1p63;
            square += n[i] * n[i];
        }
    } while (square > 1.0 || square < 1e-6);
    for (int i = 0; i < 3; ++i) n[i] /= sqrt(square);
}

/* What the Khronos validator asks of a stored normal. */
static int validator_accepts(int x, int y, int z, double scale) {
    return fabs(sqrt((x * x + y * y + z * z) / (scale * scale)) - 1.0) <= 0.00674;
}

static double angle_to_code(const double n[3], int x, int y, int z) {
    const float code[3] = {(float)x, (float)y, (float)z};
    return degrees_between(code, n);
}

enum { CODE_LIMIT = 1 << 20 };

static size_t all_passing_codes(signed char codes[CODE_LIMIT][3]) {
    size_t count = 0;
    for (int x = -127; x <= 127; ++x)
        for (int y = -127; y <= 127; ++y)
            for (int z = -127; z <= 127; ++z)
                if (validator_accepts(x, y, z, 127.0)) {
                    assert_true(count < CODE_LIMIT);
                    codes[count][0] = (signed char)x, codes[count][1] = (signed char)y,
                    codes[count++][2] = (signed char)z;
                }
    return count;
}

/* n is 127 long. */
static void check_nearest(const double n[3], signed char codes[CODE_LIMIT][3], size_t code_count) {
    int8_t out[3];
    assert_ok(norma_encode_snorm8((norma_vec3_view){n, 1, 0, NORMA_FORMAT_DOUBLE}, out, 0, 1));
    assert_true(validator_accepts(out[0], out[1], out[2], 127.0));
    double mine = 0.0, best = 1e9;
    for (int i = 0; i < 3; ++i) mine += (out[i] - n[i]) * (out[i] - n[i]);
    for (size_t k = 0; k < code_count; ++k) {
        const double x = codes[k][0] - n[0], y = codes[k][1] - n[1], z = codes[k][2] - n[2],
                     d = x * x + y * y + z * z;
        if (d < best) best = d;
    }
    assert_true(mine <= best * (1.0 + 1e-12));
}

static void snorm8_is_the_nearest_that_passes(void **state) {
    (void)state;
    static signed char codes[CODE_LIMIT][3];
    const size_t code_count = all_passing_codes(codes);
    uint64_t seed = 1;
    for (int round = 0; round < 300; ++round) {
        double n[3];
        random_direction(&seed, n);
        for (int i = 0; i < 3; ++i) n[i] *= 127.0;
        check_nearest(n, codes, code_count);
    }
    /* Every code that rounding can give and the validator refuses, from the unit vectors in its
     * cell's corner towards the sphere. */
    size_t refused = 0;
    for (int x = -127; x <= 127; ++x)
        for (int y = -127; y <= 127; ++y)
            for (int z = -127; z <= 127; ++z) {
                if (validator_accepts(x, y, z, 127.0) ||
                    abs(x * x + y * y + z * z - 127 * 127) > 400)
                    continue;
                const int c[3] = {x, y, z}, outside = x * x + y * y + z * z > 127 * 127;
                double n[3], square = 0.0;
                for (int i = 0; i < 3; ++i) {
                    n[i] = c[i] + (outside ? -0.4999999 : 0.4999999) * (c[i] < 0 ? -1 : 1);
                    square += n[i] * n[i];
                }
                int rounds_to_it = 1;
                for (int i = 0; i < 3; ++i) {
                    n[i] *= 127.0 / sqrt(square);
                    rounds_to_it &= lround(n[i]) == c[i];
                }
                if (!rounds_to_it) continue;
                ++refused;
                check_nearest(n, codes, code_count);
            }
    assert_true(refused >= 48); /* (67, 76, 78), its permutations and signs */
}

static void bounds(void **state) {
    (void)state;
    enum { COUNT = 400000 };
    uint64_t seed = 3;
    double sum8 = 0.0, max8 = 0.0, sum16 = 0.0, max16 = 0.0;
    for (int i = 0; i < COUNT; ++i) {
        double n[3];
        int8_t small[3];
        int16_t wide[3];
        random_direction(&seed, n);
        const norma_vec3_view view = {n, 1, 0, NORMA_FORMAT_DOUBLE};
        assert_ok(norma_encode_snorm8(view, small, 0, 1));
        assert_ok(norma_encode_snorm16(view, wide, 0, 1));
        const double off8 = angle_to_code(n, small[0], small[1], small[2]),
                     off16 = angle_to_code(n, wide[0], wide[1], wide[2]);
        assert_true(validator_accepts(small[0], small[1], small[2], 127.0));
        sum8 += off8, sum16 += off16;
        if (off8 > max8) max8 = off8;
        if (off16 > max16) max16 = off16;
    }
    assert_true(fabs(sum8 / COUNT - 0.170) < 0.001);
    assert_true(
        max8 <=
        0.3907); /* that of rounding alone: where another code is taken, it is all but as near */
    assert_true(fabs(sum16 / COUNT - 0.00066) < 0.00001);
    assert_true(max16 <= 0.00151);
}

static void exact_codes_and_symmetry(void **state) {
    (void)state;
    uint64_t seed = 5;
    for (int round = 0; round < 20000; ++round) {
        double n[3], minus[3];
        int8_t a[3], b[3];
        random_direction(&seed, n);
        for (int i = 0; i < 3; ++i) minus[i] = -n[i];
        assert_ok(norma_encode_snorm8((norma_vec3_view){n, 1, 0, NORMA_FORMAT_DOUBLE}, a, 0, 1));
        assert_ok(
            norma_encode_snorm8((norma_vec3_view){minus, 1, 0, NORMA_FORMAT_DOUBLE}, b, 0, 1));
        for (int i = 0; i < 3; ++i) assert_int_equal(a[i], -b[i]);
    }
    const float axes[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    int8_t out[6][3];
    int16_t wide[6][3];
    assert_ok(norma_encode_snorm8((norma_vec3_view){axes, 6, 0, NORMA_FORMAT_FLOAT}, out[0], 0, 6));
    assert_ok(
        norma_encode_snorm16((norma_vec3_view){axes, 6, 0, NORMA_FORMAT_FLOAT}, wide[0], 0, 6));
    for (int i = 0; i < 6; ++i)
        for (int k = 0; k < 3; ++k) {
            assert_int_equal(out[i][k], (int)(127 * axes[i][k]));
            assert_int_equal(wide[i][k], (int)(32767 * axes[i][k]));
        }
}

static void any_length_and_none(void **state) {
    (void)state;
    const double in[5][3] = {
        {1e-300, 0, 1e-300}, {1e300, 0, 1e300}, {0, 0, 0}, {NAN, 1, 0}, {0, INFINITY, 0}};
    int8_t out[5][3];
    assert_ok(norma_encode_snorm8((norma_vec3_view){in, 5, 0, NORMA_FORMAT_DOUBLE}, out[0], 0, 5));
    for (int i = 0; i < 2; ++i) assert_memory_equal(out[i], ((int8_t[]){90, 0, 90}), 3);
    for (int i = 2; i < 5; ++i) assert_memory_equal(out[i], ((int8_t[]){0, 0, 0}), 3);
}

static void decoding(void **state) {
    (void)state;
    for (int code = -128; code <= 127; ++code) {
        const int8_t c[3] = {(int8_t)code, 0, 127};
        float out[3];
        assert_ok(norma_decode_snorm8(c, 0, 1, out, 0, 1));
        assert_true(out[0] == (code == -128 ? -1.0f : (float)(code / 127.0)));
        assert_true(out[1] == 0.0f && out[2] == 1.0f);
    }
    const int16_t c[3] = {-32768, -32767, 12345};
    float out[3];
    assert_ok(norma_decode_snorm16(c, 0, 1, out, 0, 1));
    assert_true(out[0] == -1.0f && out[1] == -1.0f && out[2] == (float)(12345 / 32767.0));
}

/* glTF keeps vectors of bytes on multiples of four: the fourth byte is the caller's. */
static void strides_and_arguments(void **state) {
    (void)state;
    const float in[2][3] = {{1, 0, 0}, {0, 0, -1}};
    const norma_vec3_view view = {in, 2, 0, NORMA_FORMAT_FLOAT};
    int8_t out[8], untouched[8];
    memset(out, 0x33, sizeof out);
    memcpy(untouched, out, sizeof out);
    assert_int_equal(norma_encode_snorm8(view, NULL, 4, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_encode_snorm8(view, out, 2, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_encode_snorm8(view, out, 4, 1), NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_encode_snorm8(view, out, SIZE_MAX, 2), NORMA_ERROR_OVERFLOW);
    assert_memory_equal(out, untouched, sizeof out);
    assert_ok(norma_encode_snorm8(view, out, 4, 2));
    assert_memory_equal(out, ((int8_t[]){127, 0, 0, 0x33, 0, 0, -127, 0x33}), 8);
    float back[2][4];
    memset(back, 0, sizeof back);
    assert_ok(norma_decode_snorm8(out, 4, 2, back[0], 16, 2));
    assert_true(back[0][0] == 1.0f && back[1][2] == -1.0f && back[1][3] == 0.0f);
    assert_int_equal(norma_decode_snorm8(NULL, 4, 2, back[0], 16, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_decode_snorm8(out, 4, 2, back[0], 16, 1), NORMA_ERROR_CAPACITY);
    unsigned char odd[2 * 7 + 1];
    void *at = odd + 1;
    assert_ok(norma_encode_snorm16(view, (int16_t *)at, 7, 2));
    assert_ok(norma_decode_snorm16((const int16_t *)at, 7, 2, back[0], 16, 2));
    assert_true(back[0][0] == 1.0f && back[1][2] == -1.0f);
    assert_ok(norma_encode_snorm16((norma_vec3_view){0}, NULL, 0, 0));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(snorm8_is_the_nearest_that_passes),
        cmocka_unit_test(bounds),
        cmocka_unit_test(exact_codes_and_symmetry),
        cmocka_unit_test(any_length_and_none),
        cmocka_unit_test(decoding),
        cmocka_unit_test(strides_and_arguments),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
