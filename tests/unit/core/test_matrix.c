/* test_matrix.c: normal matrices against integer arithmetic, closed forms, and properties that must
 * hold. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <cmocka.h>
#include <float.h>
#include <math.h>
#include <norma/norma.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define PI      3.14159265358979323846
#define DEGREES (180.0 / PI)
__extension__ typedef __int128 wide;

/* cmocka's own compares floats. */
static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.17g is not within %g of %.17g", value, tolerance, expected);
}

static uint64_t next_random(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static int64_t random_integer(uint64_t *state, int bits) {
    const int64_t half = (int64_t)1 << bits;
    return (int64_t)(next_random(state) % (uint64_t)(2 * half - 1)) - half + 1;
}

static double random_unit(uint64_t *state) { return (double)random_integer(state, 40) / 0x1p40; }

/* Columns of the upper 3x3; a translation and a last row that must not matter. */
static void model_of(const double upper[9], float model[16]) {
    for (int i = 0; i < 9; ++i) model[i / 3 * 4 + i % 3] = (float)upper[i];
    model[3] = 3.0f, model[7] = -4.0f, model[11] = 5.0f;
    model[12] = 1e30f, model[13] = -7.0f, model[14] = 1e-30f, model[15] = 2.0f;
}

static void double_model_of(const double upper[9], double model[16]) {
    for (int i = 0; i < 9; ++i) model[i / 3 * 4 + i % 3] = upper[i];
    model[3] = 3.0, model[7] = -4.0, model[11] = 5.0;
    model[12] = 1e300, model[13] = -7.0, model[14] = 1e-300, model[15] = 2.0;
}

static wide integer_determinant(const int64_t m[9]) {
    return (wide)m[0] * ((wide)m[4] * m[8] - (wide)m[5] * m[7]) +
           (wide)m[1] * ((wide)m[5] * m[6] - (wide)m[3] * m[8]) +
           (wide)m[2] * ((wide)m[3] * m[7] - (wide)m[4] * m[6]);
}

static wide integer_cofactor(const int64_t m[9], int i) {
    const int64_t *a = m + 3 * ((i / 3 + 1) % 3), *b = m + 3 * ((i / 3 + 2) % 3);
    const int s = (i % 3 + 1) % 3, t = (i % 3 + 2) % 3;
    return (wide)a[s] * b[t] - (wide)a[t] * b[s];
}

static double angle_between(const double a[3], const double b[3]) {
    const double c[3] = {
        a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    return atan2(
        sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

static void multiply(const double m[9], const double v[3], double out[3]) {
    for (int r = 0; r < 3; ++r) out[r] = m[r] * v[0] + m[3 + r] * v[1] + m[6 + r] * v[2];
}

static void rotation(double x, double y, double z, double angle, double out[9]) {
    const double length = sqrt(x * x + y * y + z * z), c = cos(angle), s = sin(angle), t = 1 - c;
    x /= length, y /= length, z /= length;
    const double r[9] = {t * x * x + c, t * x * y + s * z, t * x * z - s * y, t * x * y - s * z,
        t * y * y + c, t * y * z + s * x, t * x * z + s * y, t * y * z - s * x, t * z * z + c};
    memcpy(out, r, sizeof r);
}

static void product(const double a[9], const double b[9], double out[9]) {
    double r[9];
    for (int c = 0; c < 3; ++c) multiply(a, b + 3 * c, r + 3 * c);
    memcpy(out, r, sizeof r);
}

static norma_matrix_info info_of(const double upper[9]) {
    float model[16], normal_matrix[9];
    norma_matrix_info info;
    model_of(upper, model);
    model[12] = model[13] = model[14] = 0.0f;
    assert_int_equal(
        norma_normal_matrix(model, NORMA_WINDING_KEPT, normal_matrix, &info), NORMA_OK);
    return info;
}

/* ---- cofactors */

/* The oracle is integer arithmetic: entries are integers of 24 bits times powers of two, one for
 * each column. */
static void cofactors_equal_integers_at_any_scale(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int round = 0; round < 20000; ++round) {
        int64_t m[9];
        double upper[9];
        int power[3];
        for (int c = 0; c < 3; ++c)
            power[c] = (int)(next_random(&seed) % 60) - 30 + (int[]){-115, 0, 73}[round % 3];
        for (int i = 0; i < 9; ++i) {
            m[i] = random_integer(&seed, 24);
            upper[i] = ldexp((double)m[i], power[i / 3]);
        }
        float model[16], kept[9], reversed[9];
        model_of(upper, model);
        assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_KEPT, kept, NULL), NORMA_OK);
        assert_int_equal(
            norma_normal_matrix(model, NORMA_WINDING_REVERSED, reversed, NULL), NORMA_OK);
        const wide determinant = integer_determinant(m);
        int shift = INT32_MAX; /* the common power of two, from the first entry that tells */
        for (int i = 0; i < 9; ++i) {
            const wide exact = integer_cofactor(m, i);
            const int column_power = power[(i / 3 + 1) % 3] + power[(i / 3 + 2) % 3];
            const long double value = ldexpl((long double)exact, column_power);
            if (exact == 0) {
                assert_true(kept[i] == 0.0f);
                continue;
            }
            if (kept[i] == 0.0f || fabsf(kept[i]) < FLT_MIN) continue;
            const long double ratio = (long double)kept[i] / value;
            const int here = (int)lroundl(log2l(ratio));
            if (shift == INT32_MAX) shift = here;
            assert_int_equal(here, shift);
            assert_true(fabsl(ldexpl(ratio, -here) - 1.0L) <= 0x1.1p-24L);
            assert_true(reversed[i] == (determinant < 0 ? -kept[i] : kept[i]));
        }
        assert_true(shift != INT32_MAX);
        for (int c = 0; c < 3; ++c) { /* no column is lost */
            const float *k = kept + 3 * c;
            assert_true(isfinite(k[0]) && isfinite(k[1]) && isfinite(k[2]));
            assert_true(fabsf(k[0]) >= FLT_MIN || fabsf(k[1]) >= FLT_MIN || fabsf(k[2]) >= FLT_MIN);
        }
        if (round % 3 == 1) assert_int_equal(shift, 0);
    }
}

static void no_power_of_two_where_none_is_needed(void **state) {
    (void)state;
    const double upper[9] = {2, 0, 0, 0, 0.5, 0, 0, 0, 1};
    const float expected[9] = {0.5f, 0, 0, 0, 2, 0, 0, 0, 1};
    float model[16], matrix[9];
    model_of(upper, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, NULL), NORMA_OK);
    assert_memory_equal(matrix, expected, sizeof matrix);
    /* Rounding noise far below a column's largest entry calls for none either. */
    const double noisy[9] = {1, 1e-23, 0, -1e-23, 1, 1e-23, 1e-23, 0, 1};
    model_of(noisy, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_KEPT, matrix, NULL), NORMA_OK);
    assert_true(matrix[0] == 1.0f && matrix[4] == 1.0f && matrix[8] == 1.0f);
}

/* With one: the largest entry near 1, unless the smallest needs more room. */
static void the_power_of_two_leaves_room(void **state) {
    (void)state;
    const double huge[9] = {1e30, 0, 0, 0, 2e30, 0, 0, 0, 4e30},
                 broad[9] = {1e38, 0, 0, 0, 1e38, 0, 0, 0, 1e-38};
    float model[16], matrix[9];
    model_of(huge, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_KEPT, matrix, NULL), NORMA_OK);
    assert_true(matrix[0] >= 1.0f && matrix[0] < 2.0f);
    assert_near((double)(matrix[0] / matrix[8]), 4.0, 1e-6);
    model_of(broad, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_KEPT, matrix, NULL), NORMA_OK);
    assert_true(matrix[0] >= FLT_MIN && matrix[4] == matrix[0] && isfinite(matrix[8]));
    assert_near(
        (double)matrix[8] / (double)matrix[0] * ((double)model[10] / (double)model[0]), 1.0, 1e-6);
}

/* (M a) x (M b) = cof(M) (a x b) for every M, at entries from 1e-38 to 1e38; long double has the
 * range and 64 bits. */
static void cross_products_go_through(void **state) {
    (void)state;
    uint64_t seed = 7;
    for (int round = 0; round < 20000; ++round) {
        double upper[9];
        const double scale = pow(10.0, random_unit(&seed) * 37.9);
        for (int i = 0; i < 9; ++i) upper[i] = (double)(float)(random_unit(&seed) * scale);
        float model[16], matrix[9];
        model_of(upper, model);
        assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_KEPT, matrix, NULL), NORMA_OK);
        long double a[3], b[3], ma[3], mb[3], right[3], got[3], n[3];
        for (int i = 0; i < 3; ++i)
            a[i] = (long double)random_unit(&seed), b[i] = (long double)random_unit(&seed);
        for (int r = 0; r < 3; ++r) {
            ma[r] = mb[r] = 0;
            for (int k = 0; k < 3; ++k) {
                ma[r] += (long double)upper[3 * k + r] * a[k];
                mb[r] += (long double)upper[3 * k + r] * b[k];
            }
        }
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            right[i] = ma[j] * mb[k] - ma[k] * mb[j];
            n[i] = a[j] * b[k] - a[k] * b[j];
        }
        long double cross = 0, dot = 0, right_length = 0, got_length = 0, largest = 0;
        for (int r = 0; r < 3; ++r) {
            got[r] = (long double)matrix[r] * n[0] + (long double)matrix[3 + r] * n[1] +
                     (long double)matrix[6 + r] * n[2];
            right_length += right[r] * right[r];
            got_length += got[r] * got[r];
            dot += right[r] * got[r];
        }
        for (int i = 0; i < 9; ++i) largest = fmaxl(largest, fabsl((long double)matrix[i]));
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            const long double x = right[j] / sqrtl(right_length) * (got[k] / sqrtl(got_length)) -
                                  right[k] / sqrtl(right_length) * (got[j] / sqrtl(got_length));
            cross += x * x;
        }
        const long double n_length = sqrtl(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        assert_true(dot > 0);
        assert_true(sqrtl(cross) * sqrtl(got_length) <= 1e-6L * largest * n_length);
    }
}

/* ---- signs and zeros */

static void sign_is_that_of_the_exact_determinant(void **state) {
    (void)state;
    uint64_t seed = 3;
    int negative = 0, positive = 0, zero = 0;
    for (int round = 0; round < 20000; ++round) {
        int64_t m[9];
        for (int i = 0; i < 6; ++i) m[i] = random_integer(&seed, 22);
        const int64_t p = round % 4 ? 1 : -1; /* the third column depends on the others, all but a
                                                 last bit in half of the rounds */
        for (int i = 0; i < 3; ++i) m[6 + i] = m[i] + p * m[3 + i];
        if (round % 2) m[6 + round / 2 % 3] += round / 8 % 2 ? 1 : -1;
        double upper[9];
        const int power = (round % 5 - 2) * 48;
        for (int i = 0; i < 9; ++i) upper[i] = ldexp((double)m[i], power);
        const wide determinant = integer_determinant(m);
        float model[16], kept[9], reversed[9];
        norma_matrix_info info;
        model_of(upper, model);
        assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_KEPT, kept, NULL), NORMA_OK);
        assert_int_equal(
            norma_normal_matrix(model, NORMA_WINDING_REVERSED, reversed, &info), NORMA_OK);
        for (int i = 0; i < 9; ++i)
            assert_true(reversed[i] == (determinant < 0 ? -kept[i] : kept[i]));
        assert_int_equal(info.mirrored, determinant < 0);
        assert_true(info.determinant == ldexp((double)determinant, 3 * power));
        negative += determinant<0, positive += determinant> 0, zero += determinant == 0;
    }
    assert_true(negative > 3000 && positive > 3000 && zero >= 10000);
}

static void double_models_are_exact_too(void **state) {
    (void)state;
    uint64_t seed = 11;
    for (int round = 0; round < 20000; ++round) {
        int64_t m[9];
        for (int i = 0; i < 9; ++i) m[i] = random_integer(&seed, 39);
        if (round % 2) {
            for (int i = 0; i < 3; ++i) m[6 + i] = m[i] - m[3 + i];
            if (round % 4 == 1) m[6] += round % 8 == 1 ? 1 : -1;
        }
        double upper[9], model[16], kept[9], reversed[9], cofactor[9], inverse[9];
        const int power = (round % 5 - 2) * 480;
        for (int i = 0; i < 9; ++i) upper[i] = ldexp((double)m[i], power);
        double_model_of(upper, model);
        const wide determinant = integer_determinant(m);
        norma_matrix_info info;
        assert_int_equal(
            norma_normal_matrix_double(model, NORMA_WINDING_KEPT, kept, &info), NORMA_OK);
        assert_int_equal(
            norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, reversed, NULL), NORMA_OK);
        assert_int_equal(norma_cofactor_matrix(model, cofactor), NORMA_OK);
        assert_memory_equal(kept, cofactor, sizeof kept);
        assert_int_equal(info.mirrored, determinant < 0);
        const double unscaled = (double)integer_cofactor(m, 0);
        int shift = 0;
        if (unscaled != 0.0) {
            double ignored = frexp(kept[0], &shift);
            int exponent;
            ignored = frexp(unscaled, &exponent);
            (void)ignored;
            shift -= exponent;
        }
        for (int i = 0; i < 9; ++i) {
            if (unscaled != 0.0)
                assert_true(ldexp(kept[i], -shift) ==
                            (double)integer_cofactor(m, i)); /* rounded once, like the conversion */
            assert_true(reversed[i] == (determinant < 0 ? -kept[i] : kept[i]));
        }
        memset(inverse, 0x55, sizeof inverse);
        const double untouched = inverse[0];
        if (determinant == 0) {
            assert_int_equal(norma_inverse_transpose(model, inverse), NORMA_ERROR_ARGUMENT);
            for (int i = 0; i < 9; ++i) assert_true(inverse[i] == untouched);
        } else if (power == 0) {
            assert_int_equal(norma_inverse_transpose(model, inverse), NORMA_OK);
            for (int i = 0; i < 9; ++i) {
                const double right = (double)integer_cofactor(m, i) / (double)determinant;
                assert_true(fabs(inverse[i] - right) <= 0x1p-51 * fabs(right));
            }
        }
    }
}

/* Mantissas of full width, exponents over the whole range, so that every limb of the exact sum is
 * used: the column sums are known. */
static void double_models_of_any_exponent(void **state) {
    (void)state;
    uint64_t seed = 17;
    for (int round = 0; round < 5000; ++round) {
        double upper[9] = {0}, model[16], reversed[9];
        int expected = 1;
        for (int i = 0; i < 3;
             ++i) { /* a diagonal and what is above it: the determinant is the diagonal's product */
            for (int j = 0; j <= i; ++j) {
                const int exponent = (int)(next_random(&seed) % 2040) - 1070;
                double value =
                    ldexp(1.0 + fabs(random_unit(&seed)), exponent < 1023 ? exponent : 1022);
                if (next_random(&seed) & 1) value = -value;
                upper[3 * i + j] = value;
            }
            if (upper[4 * i] < 0.0) expected = -expected;
        }
        double_model_of(upper, model);
        norma_matrix_info info;
        assert_int_equal(
            norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, reversed, &info), NORMA_OK);
        assert_int_equal(info.mirrored, expected < 0);
        for (int i = 0; i < 9; ++i) assert_true(isfinite(reversed[i]));
        for (int i = 0; i < 3; ++i)
            if (reversed[4 * i] != 0.0)
                assert_int_equal(reversed[4 * i] < 0.0,
                    upper[4 * i] < 0.0); /* M^-T of a triangle: 1 / its diagonal */
    }
}

static void all_zero_cofactors_give_zeros(void **state) {
    (void)state;
    const double rank_one[9] = {1e-20, 3e-20, -7e-20, 2e-20, 6e-20, -14e-20, 0, 0,
        0}; /* floats: the second column twice the first */
    float model[16], matrix[9];
    norma_matrix_info info;
    model_of(rank_one, model);
    for (int i = 0; i < 3; ++i) model[4 + i] = 2.0f * model[i];
    for (int w = 0; w < 2; ++w) {
        assert_int_equal(norma_normal_matrix(model, (norma_winding)w, matrix, &info), NORMA_OK);
        for (int i = 0; i < 9; ++i) assert_true(matrix[i] == 0.0f && !signbit(matrix[i]));
        assert_int_equal(info.rank, 1);
        assert_int_equal(info.kind, NORMA_KIND_SINGULAR);
        assert_int_equal(info.mirrored, 0);
        assert_true(isinf(info.anisotropy));
        assert_near(info.worst_error_rad, PI / 2, 0);
    }
    memset(model, 0, sizeof model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info), NORMA_OK);
    for (int i = 0; i < 9; ++i) assert_true(matrix[i] == 0.0f);
    assert_int_equal(info.rank, 0);
    assert_int_equal(info.kind, NORMA_KIND_SINGULAR);
    const double length = sqrt((double)info.worst_normal[0] * (double)info.worst_normal[0] +
                               (double)info.worst_normal[1] * (double)info.worst_normal[1] +
                               (double)info.worst_normal[2] * (double)info.worst_normal[2]);
    assert_near(length, 1.0, 1e-6);
    /* Subnormal entries have cofactors that are not zero. */
    const double tiny[9] = {1e-45, 0, 0, 0, 1e-45, 0, 0, 0, 1e-45};
    model_of(tiny, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info), NORMA_OK);
    assert_true(matrix[0] > 0.0f && matrix[0] == matrix[4] && matrix[4] == matrix[8]);
    assert_int_equal(info.kind, NORMA_KIND_UNIFORM_SCALE);
    assert_int_equal(info.rank, 3);
}

static void rank_two_carries_the_face_normal(void **state) {
    (void)state;
    const double flat[9] = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    const float expected[9] = {0, 0, 0, 0, 0, 0, 0, 0, 1};
    float model[16], matrix[9];
    norma_matrix_info info;
    model_of(flat, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info), NORMA_OK);
    assert_memory_equal(matrix, expected, sizeof matrix);
    assert_int_equal(info.rank, 2);
    assert_int_equal(info.kind, NORMA_KIND_SINGULAR);
    assert_true(isinf(info.anisotropy));
    assert_near(info.worst_error_rad, PI / 2, 0);
    double n[3] = {(double)info.worst_normal[0], (double)info.worst_normal[1],
        (double)info.worst_normal[2]},
           plain[3], right[3];
    const double cofactor[9] = {0, 0, 0, 0, 0, 0, 0, 0, 1};
    multiply(flat, n, plain);
    multiply(cofactor, n, right);
    assert_near(angle_between(plain, right), PI / 2, 1e-7);
    assert_int_equal(info.mirrored, 0);
    /* A flattening along an oblique axis, with its plane in integers: columns (1,0,1), (0,1,2),
     * (1,1,3). */
    const double oblique[9] = {1, 0, 1, 0, 1, 2, 1, 1, 3};
    model_of(oblique, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, NULL), NORMA_OK);
    const float oblique_expected[9] = {1, 2, -1, 1, 2, -1, -1, -2, 1};
    for (int i = 0; i < 9; ++i) assert_true(matrix[i] == oblique_expected[i]);
}

/* ---- kinds */

static void kinds(void **state) {
    (void)state;
    double turn[9], m[9];
    rotation(1, 2, 3, 0.7, turn);
    const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, axes[9] = {2, 0, 0, 0, 0.5, 0, 0, 0, 1},
                 even[9] = {3, 0, 0, 0, 3, 0, 0, 0, 3};
    assert_int_equal(info_of(identity).kind, NORMA_KIND_IDENTITY);
    assert_int_equal(info_of(turn).kind, NORMA_KIND_ROTATION);
    assert_int_equal(info_of(even).kind, NORMA_KIND_UNIFORM_SCALE);
    assert_int_equal(info_of(axes).kind, NORMA_KIND_NON_UNIFORM_SCALE);
    product(turn, even, m);
    assert_int_equal(info_of(m).kind, NORMA_KIND_UNIFORM_SCALE);
    product(turn, axes, m);
    assert_int_equal(info_of(m).kind, NORMA_KIND_NON_UNIFORM_SCALE);
    product(axes, turn, m); /* scales after the rotation: the columns are no longer perpendicular */
    assert_int_equal(info_of(m).kind, NORMA_KIND_SHEAR);
    const double shear[9] = {1, 0, 0, 1, 1, 0, 0, 0, 1};
    assert_int_equal(info_of(shear).kind, NORMA_KIND_SHEAR);
    for (int power = -120; power <= 120; power += 24) {
        for (int i = 0; i < 9; ++i) m[i] = ldexp(turn[i], power);
        assert_int_equal(info_of(m).kind, power ? NORMA_KIND_UNIFORM_SCALE : NORMA_KIND_ROTATION);
        for (int i = 0; i < 9; ++i) m[i] = ldexp(shear[i], power);
        assert_int_equal(info_of(m).kind, NORMA_KIND_SHEAR);
        assert_near(info_of(m).anisotropy, (3.0 + sqrt(5.0)) / 2.0, 1e-14);
    }
    float model[16], matrix[9];
    norma_matrix_info info;
    model_of(identity, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info), NORMA_OK);
    assert_int_equal(info.kind, NORMA_KIND_TRANSLATION);
    assert_int_equal(norma_matrix_shortcut(&info), NORMA_SHORTCUT_ROTATION);
}

static void kinds_of_mirrors(void **state) {
    (void)state;
    static const struct {
        double diagonal[3];
        norma_kind kind;
        int mirrored;
    } table[] = {
        {{-1, 1, 1}, NORMA_KIND_ROTATION, 1},
        {{1, -1, 1}, NORMA_KIND_ROTATION, 1},
        {{1, 1, -1}, NORMA_KIND_ROTATION, 1},
        {{-1, -1, -1}, NORMA_KIND_ROTATION, 1},
        {{-1, -1, 1}, NORMA_KIND_ROTATION, 0},
        {{-2, 2, 2}, NORMA_KIND_UNIFORM_SCALE, 1},
        {{-2, 3, 4}, NORMA_KIND_NON_UNIFORM_SCALE, 1},
        {{-2, -3, 4}, NORMA_KIND_NON_UNIFORM_SCALE, 0},
    };
    for (size_t t = 0; t < sizeof table / sizeof *table; ++t) {
        const double m[9] = {
            table[t].diagonal[0], 0, 0, 0, table[t].diagonal[1], 0, 0, 0, table[t].diagonal[2]};
        const norma_matrix_info info = info_of(m);
        assert_int_equal(info.kind, table[t].kind);
        assert_int_equal(info.mirrored, table[t].mirrored);
    }
    const double swapped[9] = {0, 1, 0, 1, 0, 0, 0, 0, 1};
    assert_int_equal(info_of(swapped).kind, NORMA_KIND_ROTATION);
    assert_int_equal(info_of(swapped).mirrored, 1);
}

static void tolerances(void **state) {
    (void)state;
    const double just_two[9] = {1, 0, 0, 0, 1, 0, 0, 0, 0.99e-6},
                 just_three[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1.01e-6};
    assert_int_equal(info_of(just_two).rank, 2);
    assert_int_equal(info_of(just_two).kind, NORMA_KIND_SINGULAR);
    assert_true(isinf(info_of(just_two).anisotropy));
    assert_int_equal(info_of(just_three).rank, 3);
    assert_int_equal(info_of(just_three).kind, NORMA_KIND_NON_UNIFORM_SCALE);
    assert_near(info_of(just_three).anisotropy * (double)1.01e-6f, 1.0, 1e-12);
    for (int outside = 0; outside < 2; ++outside) {
        const double t = outside ? 1.2e-5 : 0.8e-5;
        const double longer[9] = {1 + t, 0, 0, 0, 1, 0, 0, 0, 1},
                     even[9] = {1 + t, 0, 0, 0, 1 + t, 0, 0, 0, 1 + t},
                     leaning[9] = {1, 0, 0, t, 1, 0, 0, 0, 1};
        assert_int_equal(
            info_of(longer).kind, outside ? NORMA_KIND_NON_UNIFORM_SCALE : NORMA_KIND_IDENTITY);
        assert_int_equal(
            info_of(even).kind, outside ? NORMA_KIND_UNIFORM_SCALE : NORMA_KIND_IDENTITY);
        assert_int_equal(info_of(leaning).kind, outside ? NORMA_KIND_SHEAR : NORMA_KIND_IDENTITY);
        double turn[9];
        rotation(0, 0, 1, t, turn);
        assert_int_equal(info_of(turn).kind, outside ? NORMA_KIND_ROTATION : NORMA_KIND_IDENTITY);
    }
    /* A rank below three by tolerance alone changes neither the matrix nor its sign. */
    const double thin[9] = {1, 0, 0, 0, 1, 0, 0, 0, -1e-9};
    float model[16], matrix[9];
    norma_matrix_info info;
    model_of(thin, model);
    assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info), NORMA_OK);
    assert_int_equal(info.rank, 2);
    assert_int_equal(info.mirrored, 1);
    assert_true(matrix[0] == 1e-9f && matrix[4] == 1e-9f && matrix[8] == -1.0f);
}

static void shortcuts(void **state) {
    (void)state;
    const double even[9] = {3, 0, 0, 0, 3, 0, 0, 0, 3}, shear[9] = {1, 0, 0, 1, 1, 0, 0, 0, 1},
                 flat[9] = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    double turn[9], m[9], model[16], by_axes[9];
    rotation(3, -1, 2, 2.1, turn);
    const double axes[9] = {-2, 0, 0, 0, 0.25, 0, 0, 0, 5};
    product(turn, axes, m);
    norma_matrix_info info = info_of(turn);
    assert_int_equal(norma_matrix_shortcut(&info), NORMA_SHORTCUT_ROTATION);
    info = info_of(even);
    assert_int_equal(norma_matrix_shortcut(&info), NORMA_SHORTCUT_UNIFORM_SCALE);
    info = info_of(shear);
    assert_int_equal(norma_matrix_shortcut(&info), NORMA_SHORTCUT_NONE);
    info = info_of(flat);
    assert_int_equal(norma_matrix_shortcut(&info), NORMA_SHORTCUT_NONE);
    info = info_of(m);
    assert_int_equal(norma_matrix_shortcut(&info), NORMA_SHORTCUT_AXIS_SCALE);
    assert_int_equal(norma_matrix_shortcut(NULL), NORMA_SHORTCUT_NONE);
    /* R diag(s) has the inverse transpose R diag(1/s). */
    double_model_of(m, model);
    assert_int_equal(norma_axis_scale_matrix(model, by_axes), NORMA_OK);
    for (int i = 0; i < 9; ++i) assert_near(by_axes[i], turn[i] / axes[i / 3 * 4], 1e-14);
    for (int i = 0; i < 3; ++i)
        m[i] = ldexp(turn[i], 900), m[3 + i] = ldexp(turn[3 + i], -100), m[6 + i] = turn[6 + i];
    double_model_of(m, model);
    assert_int_equal(norma_axis_scale_matrix(model, by_axes), NORMA_OK);
    for (int i = 0; i < 3; ++i) assert_near(ldexp(by_axes[i], 900), turn[i], 1e-14);
    double_model_of(flat, model);
    assert_int_equal(norma_axis_scale_matrix(model, by_axes), NORMA_ERROR_ARGUMENT);
}

/* ---- worst error */

static void worst_error_closed_forms(void **state) {
    (void)state;
    static const double table[][2] = {{1.5, 22.620}, {2, 36.870}, {4, 61.928}, {10, 78.579}};
    for (int t = 0; t < 4; ++t) {
        const double m[9] = {table[t][0], 0, 0, 0, 1, 0, 0, 0, 1};
        const norma_matrix_info info = info_of(m);
        assert_near(info.worst_error_rad * DEGREES, table[t][1], 5e-4);
        assert_near(info.anisotropy, table[t][0], 1e-15);
    }
    const double seed[9] = {2, 0, 0, 0, 0.5, 0, 0, 0, 1};
    const norma_matrix_info info = info_of(seed);
    assert_near(info.worst_error_rad * DEGREES, 61.928, 5e-4);
    assert_near((double)info.worst_normal[0], sqrt(0.5), 1e-7);
    assert_near((double)info.worst_normal[1], sqrt(0.5), 1e-7);
    assert_near((double)info.worst_normal[2], 0.0, 1e-7);
    double turn[9];
    rotation(1, 1, -2, 1.2, turn);
    assert_near(info_of(turn).worst_error_rad, 0.0, 1e-6);
}

/* Plain M against the inverse transpose, faces reversed under a mirror, by trying normals. */
static double error_at(const double m[9], const double inverse_transpose[9], const double n[3]) {
    double plain[3], right[3];
    multiply(m, n, plain);
    multiply(inverse_transpose, n, right);
    return angle_between(plain, right);
}

static void worst_error_by_trying(void **state) {
    (void)state;
    uint64_t seed = 23;
    for (int round = 0; round < 300; ++round) {
        double m[9], model[16], inverse[9];
        for (int i = 0; i < 9; ++i) m[i] = (double)(float)random_unit(&seed);
        if (round % 3 == 0)
            for (int i = 0; i < 3; ++i) m[3 + i] = (double)(float)(0.001 * m[3 + i]);
        const norma_matrix_info info = info_of(m);
        assert_int_equal(info.rank, 3);
        double_model_of(m, model);
        assert_int_equal(norma_inverse_transpose(model, inverse), NORMA_OK);
        const double n[3] = {(double)info.worst_normal[0], (double)info.worst_normal[1],
            (double)info.worst_normal[2]};
        assert_near(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0, 1e-6);
        assert_near(error_at(m, inverse, n), info.worst_error_rad, 1e-4);
        double best = 0.0, at[3] = {0, 0, 1}, step = 1.0;
        for (int try = 0; try < 3000; ++try) {
            double candidate[3];
            for (int i = 0; i < 3; ++i)
                candidate[i] = (try < 500 ? 0.0 : at[i]) + step * random_unit(&seed);
            const double length = sqrt(candidate[0] * candidate[0] + candidate[1] * candidate[1] +
                                       candidate[2] * candidate[2]);
            for (int i = 0; i < 3; ++i) candidate[i] /= length;
            const double error = error_at(m, inverse, candidate);
            if (error > best)
                best = error, memcpy(at, candidate, sizeof at);
            else if (try >= 500)
                step *= 0.995;
        }
        assert_true(best <= info.worst_error_rad + 1e-9);
        assert_true(best >= info.worst_error_rad - 2e-3);
    }
}

static void rotation_gives_itself(void **state) {
    (void)state;
    uint64_t seed = 5;
    for (int round = 0; round < 1000; ++round) {
        double turn[9];
        rotation(random_unit(&seed), random_unit(&seed), random_unit(&seed),
            3.0 * random_unit(&seed), turn);
        const double mirror = round % 2 ? -1.0 : 1.0;
        double m[9];
        for (int i = 0; i < 9; ++i) m[i] = turn[i] * (i < 3 ? mirror : 1.0);
        float model[16], kept[9], reversed[9];
        model_of(m, model);
        assert_int_equal(norma_normal_matrix(model, NORMA_WINDING_KEPT, kept, NULL), NORMA_OK);
        assert_int_equal(
            norma_normal_matrix(model, NORMA_WINDING_REVERSED, reversed, NULL), NORMA_OK);
        for (int i = 0; i < 9; ++i) {
            assert_near((double)kept[i], mirror * m[i], 4e-7);
            assert_near((double)reversed[i], m[i], 4e-7);
        }
    }
}

/* ---- model and view */

static void model_view_is_the_matrix_of_the_product(void **state) {
    (void)state;
    uint64_t seed = 31;
    for (int round = 0; round < 3000; ++round) {
        int64_t m[9], v[9], p[9];
        double model_upper[9], view_upper[9];
        for (int i = 0; i < 9; ++i) {
            m[i] = random_integer(&seed, 16), v[i] = random_integer(&seed, 16);
            if (round % 3 == 1 && i >= 6) m[i] = m[i - 6] + m[i - 3];
            if (round % 3 == 2 && i >= 6) m[i] = 2 * (m[i - 3] = 3 * m[i - 6]);
            model_upper[i] = ldexp((double)m[i], round % 2 ? -60 : 30),
            view_upper[i] = (double)v[i];
        }
        if (round % 3 == 2)
            for (int i = 0; i < 9; ++i) model_upper[i] = ldexp((double)m[i], round % 2 ? -60 : 30);
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
                p[3 * c + r] = v[r] * m[3 * c] + v[3 + r] * m[3 * c + 1] + v[6 + r] * m[3 * c + 2];
        float model[16], view[16], matrix[9];
        norma_matrix_info info;
        model_of(model_upper, model);
        model_of(view_upper, view);
        assert_int_equal(
            norma_normal_matrix_model_view(model, view, NORMA_WINDING_REVERSED, matrix, &info),
            NORMA_OK);
        const wide determinant = integer_determinant(p);
        assert_int_equal(info.mirrored, determinant < 0);
        for (int i = 0; i < 9; ++i) {
            const double right = ldexp((double)integer_cofactor(p, i), round % 2 ? -120 : 60) *
                                 (determinant < 0 ? -1.0 : 1.0);
            assert_true(fabs((double)matrix[i] - right) <= 0x1.1p-24 * fabs(right));
        }
        if (round % 3 == 2) assert_int_equal(info.rank, 1);
    }
}

/* The view's kernel is (1, 1, -1), and two of the model's columns differ by little else: the third
 * column of the product's cofactors is what is left of terms four million times as large. */
static void model_view_cancels_exactly(void **state) {
    (void)state;
    uint64_t seed = 37;
    for (int round = 0; round < 3000; ++round) {
        int64_t m[9], v[9], p[9];
        for (int i = 0; i < 9; ++i)
            m[i] = random_integer(&seed, 22), v[i] = random_integer(&seed, 22);
        const int64_t along = random_integer(&seed, 22);
        for (int i = 0; i < 3; ++i)
            v[6 + i] = v[i] + v[3 + i], m[3 + i] = m[i] + (i < 2 ? along : -along);
        m[3] += round % 2;
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r)
                p[3 * c + r] = v[r] * m[3 * c] + v[3 + r] * m[3 * c + 1] + v[6 + r] * m[3 * c + 2];
        double model_upper[9], view_upper[9];
        for (int i = 0; i < 9; ++i) model_upper[i] = (double)m[i], view_upper[i] = (double)v[i];
        float model[16], view[16], matrix[9];
        model_of(model_upper, model);
        model_of(view_upper, view);
        assert_int_equal(
            norma_normal_matrix_model_view(model, view, NORMA_WINDING_KEPT, matrix, NULL),
            NORMA_OK);
        for (int i = 0; i < 9; ++i) {
            const double right = (double)integer_cofactor(p, i);
            assert_true(fabs((double)matrix[i] - right) <= 0x1.1p-24 * fabs(right));
        }
    }
}

/* Two flattenings that meet in a line: no normal is left, and no rounding may invent one. */
static void model_view_zero_is_exact(void **state) {
    (void)state;
    const double model_upper[9] = {3, 7, 11, 5, 13, 17, 0, 0, 0},
                 view_upper[9] = {17, 34, 51, 19, 38, 57, 23, 46, 69};
    float model[16], view[16], matrix[9];
    model_of(model_upper, model);
    model_of(view_upper, view);
    assert_int_equal(
        norma_normal_matrix_model_view(model, view, NORMA_WINDING_KEPT, matrix, NULL), NORMA_OK);
    for (int i = 0; i < 9; ++i) assert_true(matrix[i] == 0.0f);
    /* Both of rank 2, their product of rank 1: view takes out the z axis, the model's plane holds
     * it. */
    const double upright[9] = {0.1, 0.3, 0.7, 0, 0, 0, 0.1, 0.3, 1.7},
                 flatten[9] = {1, 0, 0, 0, 1, 0, 0, 0, 0};
    model_of(upright, model);
    model_of(flatten, view);
    for (int i = 0; i < 2; ++i) model[8 + i] = model[i];
    assert_int_equal(
        norma_normal_matrix_model_view(model, view, NORMA_WINDING_KEPT, matrix, NULL), NORMA_OK);
    for (int i = 0; i < 9; ++i) assert_true(matrix[i] == 0.0f);
}

static void model_view_kinds(void **state) {
    (void)state;
    float model[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.1f, 0.2f, 0.3f, 1},
          view[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -0.1f, -0.2f, -0.3f, 1}, matrix[9];
    norma_matrix_info info;
    assert_int_equal(
        norma_normal_matrix_model_view(model, view, NORMA_WINDING_REVERSED, matrix, &info),
        NORMA_OK);
    assert_int_equal(info.kind, NORMA_KIND_IDENTITY);
    view[12] = 5.0f;
    assert_int_equal(
        norma_normal_matrix_model_view(model, view, NORMA_WINDING_REVERSED, matrix, &info),
        NORMA_OK);
    assert_int_equal(info.kind, NORMA_KIND_TRANSLATION);
    view[0] = NAN;
    assert_int_equal(
        norma_normal_matrix_model_view(model, view, NORMA_WINDING_REVERSED, matrix, &info),
        NORMA_ERROR_ARGUMENT);
    for (int i = 0; i < 9; ++i) assert_true(matrix[i] == 0.0f);
}

/* ---- batches */

enum { MANY = 1000 };

static void fill_models(float models[MANY][16]) {
    uint64_t seed = 41;
    for (int i = 0; i < MANY; ++i) {
        const double scale = i % 5 == 1 ? 1e30 : i % 5 == 2 ? 1e-30 : 1.0;
        for (int k = 0; k < 16; ++k) models[i][k] = (float)(scale * random_unit(&seed));
        if (i % 7 == 3) models[i][8] = models[i][9] = models[i][10] = 0.0f;
        if (i % 11 == 4) models[i][i % 3 * 4 + i / 11 % 3] = i % 2 ? NAN : -INFINITY;
    }
}

static int is_finite_model(const float model[16]) {
    for (int i = 0; i < 11; ++i)
        if (i % 4 < 3 && !isfinite(model[i])) return 0;
    return 1;
}

static void batches_equal_singles(void **state) {
    (void)state;
    static float models[MANY][16], tight[MANY][9];
    fill_models(models);
    for (int w = 0; w < 2; ++w) {
        assert_int_equal(norma_normal_matrices(models[0], MANY, (norma_winding)w, tight[0], MANY),
            NORMA_ERROR_ARGUMENT);
        for (int i = 0; i < MANY; ++i) {
            float single[9];
            const norma_result result =
                norma_normal_matrix(models[i], (norma_winding)w, single, NULL);
            assert_int_equal(result, is_finite_model(models[i]) ? NORMA_OK : NORMA_ERROR_ARGUMENT);
            assert_memory_equal(single, tight[i], sizeof single);
            if (result)
                for (int k = 0; k < 9; ++k) assert_true(single[k] == 0.0f);
        }
    }
}

static void translation_and_last_row_never_leak(void **state) {
    (void)state;
    static float models[MANY][16], a[MANY][9], b[MANY][9];
    fill_models(models);
    (void)norma_normal_matrices(models[0], MANY, NORMA_WINDING_REVERSED, a[0], MANY);
    for (int i = 0; i < MANY; ++i) {
        models[i][3] = models[i][7] = models[i][11] = models[i][15] = NAN;
        models[i][12] = INFINITY, models[i][13] = -1e38f, models[i][14] = NAN;
    }
    (void)norma_normal_matrices(models[0], MANY, NORMA_WINDING_REVERSED, b[0], MANY);
    assert_memory_equal(a, b, sizeof a);
}

static void strided_batches(void **state) {
    (void)state;
    static float models[MANY][16], tight[MANY][9];
    fill_models(models);
    (void)norma_normal_matrices(models[0], MANY, NORMA_WINDING_REVERSED, tight[0], MANY);

    enum { FROM = 71, BLOCK = 48, COLUMN = 16 }; /* std140, from models at odd addresses */
    unsigned char *odd = malloc((size_t)MANY * FROM + 1), *block = malloc((size_t)MANY * BLOCK);
    assert_non_null(odd);
    assert_non_null(block);
    memset(block, 0xab, (size_t)MANY * BLOCK);
    for (int i = 0; i < MANY; ++i) memcpy(odd + 1 + i * FROM, models[i], sizeof models[i]);
    void *from = odd + 1;
    assert_int_equal(norma_normal_matrices_strided((const float *)from, FROM, MANY,
                         NORMA_WINDING_REVERSED, (float *)(void *)block, BLOCK, COLUMN, MANY),
        NORMA_ERROR_ARGUMENT);
    for (int i = 0; i < MANY; ++i)
        for (int c = 0; c < 3; ++c) {
            assert_memory_equal(block + i * BLOCK + c * COLUMN, tight[i] + 3 * c, 12);
            for (int k = 12; k < COLUMN; ++k)
                assert_int_equal(
                    block[i * BLOCK + c * COLUMN + k], 0xab); /* padding is the caller's */
        }
    free(odd);
    free(block);

    static float columns[3][MANY][3]; /* all first columns, all second, all third */
    (void)norma_normal_matrices_strided(
        models[0], 0, MANY, NORMA_WINDING_REVERSED, columns[0][0], 12, sizeof columns[0], MANY);
    for (int i = 0; i < MANY; ++i)
        for (int c = 0; c < 3; ++c) assert_memory_equal(columns[c][i], tight[i] + 3 * c, 12);
}

static void batch_arguments(void **state) {
    (void)state;
    float models[2][16] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
          out[18];
    memset(out, 0x5a, sizeof out);
    float untouched[18];
    memcpy(untouched, out, sizeof out);
    assert_int_equal(
        norma_normal_matrices(NULL, 2, NORMA_WINDING_KEPT, out, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_normal_matrices(models[0], 2, NORMA_WINDING_KEPT, NULL, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_normal_matrices(models[0], 2, (norma_winding)7, out, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_normal_matrices(models[0], 2, NORMA_WINDING_KEPT, out, 1), NORMA_ERROR_CAPACITY);
    assert_int_equal(
        norma_normal_matrices(models[0], SIZE_MAX / 4, NORMA_WINDING_KEPT, out, SIZE_MAX),
        NORMA_ERROR_OVERFLOW);
    assert_int_equal(norma_normal_matrices_strided(
                         models[0], 64, 2, NORMA_WINDING_KEPT, out, 48, SIZE_MAX / 2, 2),
        NORMA_ERROR_OVERFLOW);
    assert_int_equal(
        norma_normal_matrices_strided(models[0], 64, 2, NORMA_WINDING_KEPT, out, 36, 8, 2),
        NORMA_ERROR_ARGUMENT); /* columns on columns */
    assert_int_equal(
        norma_normal_matrices_strided(models[0], 64, 2, NORMA_WINDING_KEPT, out, 24, 12, 2),
        NORMA_ERROR_ARGUMENT); /* matrices on matrices */
    assert_memory_equal(out, untouched, sizeof out);
    assert_int_equal(norma_normal_matrices(NULL, 0, NORMA_WINDING_KEPT, NULL, 0), NORMA_OK);
    assert_int_equal(
        norma_normal_matrix(NULL, NORMA_WINDING_KEPT, out, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_normal_matrix(models[0], NORMA_WINDING_KEPT, NULL, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_normal_matrix(models[0], NORMA_WINDING_REVERSED, models[0], NULL),
        NORMA_OK); /* in place: read before written */
    const float identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    assert_memory_equal(models[0], identity, sizeof identity);
}

static void non_finite_singles(void **state) {
    (void)state;
    for (int i = 0; i < 9; ++i)
        for (int bad = 0; bad < 3; ++bad) {
            const double value = bad == 0   ? (double)NAN
                                 : bad == 1 ? (double)INFINITY
                                            : -(double)INFINITY;
            double model[16] = {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 10, 0, 0, 0, 0, 1}, matrix[9];
            float narrow[16], narrow_matrix[9];
            norma_matrix_info info;
            model[i / 3 * 4 + i % 3] = value;
            for (int k = 0; k < 16; ++k) narrow[k] = (float)model[k];
            assert_int_equal(
                norma_normal_matrix(narrow, NORMA_WINDING_REVERSED, narrow_matrix, &info),
                NORMA_ERROR_ARGUMENT);
            assert_int_equal(info.kind, NORMA_KIND_SINGULAR);
            assert_int_equal(
                norma_normal_matrix_double(model, NORMA_WINDING_REVERSED, matrix, &info),
                NORMA_ERROR_ARGUMENT);
            for (int k = 0; k < 9; ++k) assert_true(matrix[k] == 0.0 && narrow_matrix[k] == 0.0f);
            assert_int_equal(norma_cofactor_matrix(model, matrix), NORMA_ERROR_ARGUMENT);
            assert_int_equal(norma_inverse_transpose(model, matrix), NORMA_ERROR_ARGUMENT);
            assert_int_equal(norma_axis_scale_matrix(model, matrix), NORMA_ERROR_ARGUMENT);
        }
}

static void texts(void **state) {
    (void)state;
    static const int results[] = {0, 1, -1, -2, -3, -4, -5, -99};
    for (size_t i = 0; i < sizeof results / sizeof *results; ++i) {
        const char *text = norma_result_text((norma_result)results[i]);
        assert_non_null(text);
        assert_true(strlen(text) > 4 && text[strlen(text) - 1] == '.');
        for (size_t k = 0; k < i; ++k)
            assert_string_not_equal(text, norma_result_text((norma_result)results[k]));
    }
    assert_string_equal(norma_version(), "0.1.0");
    assert_int_equal(norma_version_number(), 100);
    assert_int_equal(NORMA_VERSION, 100);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cofactors_equal_integers_at_any_scale),
        cmocka_unit_test(no_power_of_two_where_none_is_needed),
        cmocka_unit_test(the_power_of_two_leaves_room),
        cmocka_unit_test(cross_products_go_through),
        cmocka_unit_test(sign_is_that_of_the_exact_determinant),
        cmocka_unit_test(double_models_are_exact_too),
        cmocka_unit_test(double_models_of_any_exponent),
        cmocka_unit_test(all_zero_cofactors_give_zeros),
        cmocka_unit_test(rank_two_carries_the_face_normal),
        cmocka_unit_test(kinds),
        cmocka_unit_test(kinds_of_mirrors),
        cmocka_unit_test(tolerances),
        cmocka_unit_test(shortcuts),
        cmocka_unit_test(worst_error_closed_forms),
        cmocka_unit_test(worst_error_by_trying),
        cmocka_unit_test(rotation_gives_itself),
        cmocka_unit_test(model_view_is_the_matrix_of_the_product),
        cmocka_unit_test(model_view_cancels_exactly),
        cmocka_unit_test(model_view_zero_is_exact),
        cmocka_unit_test(model_view_kinds),
        cmocka_unit_test(batches_equal_singles),
        cmocka_unit_test(translation_and_last_row_never_leak),
        cmocka_unit_test(strided_batches),
        cmocka_unit_test(batch_arguments),
        cmocka_unit_test(non_finite_singles),
        cmocka_unit_test(texts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
