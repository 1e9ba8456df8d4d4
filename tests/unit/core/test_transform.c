/* test_transform.c: streams of normals, positions and tangents, the winding, and Phong's
 * interpolation. */
#include "check.h"
#include <float.h>

static uint64_t next_random(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static double random_unit(uint64_t *state) { return (double)(int64_t)next_random(state) / 0x1p63; }

static double length_of(const float v[3]) {
    return sqrt(
        (double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] + (double)v[2] * (double)v[2]);
}

static int is_zero(const float v[3]) { return v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f; }

/* What is right, with 64 bits and a range that no float product leaves. */
static void right_normal(const float m[9], const long double n[3], double out[3]) {
    long double v[3], length = 0;
    for (int r = 0; r < 3; ++r) {
        v[r] =
            (long double)m[r] * n[0] + (long double)m[3 + r] * n[1] + (long double)m[6 + r] * n[2];
        length += v[r] * v[r];
    }
    for (int r = 0; r < 3; ++r) out[r] = (double)(v[r] / sqrtl(length));
}

static const float axes_normal_matrix[9] = {0.5f, 0, 0, 0, 2, 0, 0, 0, 1}; /* of diag(2, 0.5, 1) */

/* ---- normals */

static void worked_example(void **state) {
    (void)state;
    const float normal[3] = {0.70710678f, 0.70710678f, 0},
                plain[9] = {2, 0, 0, 0, 0.5f, 0, 0, 0, 1};
    float right[3], wrong[3];
    const norma_vec3_view in = {normal, 1, 0, NORMA_FORMAT_FLOAT};
    assert_ok(norma_transform_normals(axes_normal_matrix, in, right, 0, 1));
    assert_ok(norma_transform_normals(plain, in, wrong, 0, 1));
    assert_direction(right, 0.2425356, 0.9701425, 0, 1e-5);
    assert_direction(wrong, 0.9701425, 0.2425356, 0, 1e-5);
    assert_true(fabs(degrees_to(right, (double)wrong[0], (double)wrong[1], (double)wrong[2]) -
                     61.928) < 5e-4);
}

static void unit_over_the_whole_range(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int round = 0; round < 20000; ++round) {
        float m[9], n[3], out[3];
        const double matrix_scale = pow(10.0, 37.9 * random_unit(&seed)),
                     normal_scale = pow(10.0, 37.9 * random_unit(&seed));
        for (int i = 0; i < 9; ++i) m[i] = (float)(matrix_scale * random_unit(&seed));
        for (int i = 0; i < 3; ++i) n[i] = (float)(normal_scale * random_unit(&seed));
        double right[3];
        right_normal(m,
            (const long double[]){(long double)n[0], (long double)n[1], (long double)n[2]}, right);
        assert_ok(
            norma_transform_normals(m, (norma_vec3_view){n, 1, 0, NORMA_FORMAT_FLOAT}, out, 0, 1));
        assert_direction(out, right[0], right[1], right[2], 1e-5);
        assert_true(fabs(length_of(out) - 1.0) < 1.2e-7);
    }
    const float tiny[3] = {1e-45f, 0, 0}, huge[3] = {FLT_MAX, FLT_MAX, FLT_MAX},
                small[9] = {1e-45f, 0, 0, 0, 1e-45f, 0, 0, 0, 1e-45f};
    float out[3];
    assert_ok(norma_transform_normals(
        small, (norma_vec3_view){tiny, 1, 0, NORMA_FORMAT_FLOAT}, out, 0, 1));
    assert_direction(out, 1, 0, 0, 1e-9);
    const float large[9] = {
        FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX, FLT_MAX};
    assert_ok(norma_transform_normals(
        large, (norma_vec3_view){huge, 1, 0, NORMA_FORMAT_FLOAT}, out, 0, 1));
    assert_direction(out, 1, 1, 1, 1e-5);
}

static void doubles_of_any_size(void **state) {
    (void)state;
    uint64_t seed = 2;
    for (int exponent = -1074; exponent <= 1020; exponent += 3) {
        double n[3];
        for (int i = 0; i < 3; ++i)
            n[i] = ldexp(1.0 + (double)i, exponent < -1072 ? exponent : exponent - 2) *
                   (next_random(&seed) & 1 ? 1 : -1);
        float out[3];
        double right[3];
        right_normal(axes_normal_matrix,
            (const long double[]){(long double)n[0], (long double)n[1], (long double)n[2]}, right);
        assert_ok(norma_transform_normals(
            axes_normal_matrix, (norma_vec3_view){n, 1, 0, NORMA_FORMAT_DOUBLE}, out, 0, 1));
        assert_direction(out, right[0], right[1], right[2], 1e-5);
    }
}

static void zero_stays_and_not_finite_becomes_zero(void **state) {
    (void)state;
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int count = 1; count < 40; ++count) /* whole blocks and what is left of one */
        for (int at = 0; at < count; ++at) {
            float n[40][3], out[40][3];
            for (int i = 0; i < count; ++i) n[i][0] = 1, n[i][1] = 2, n[i][2] = 3;
            if (at % 4 == 3)
                memset(n[at], 0, sizeof n[at]);
            else
                n[at][at % 3] = bad[at % 4];
            assert_ok(norma_transform_normals(axes_normal_matrix,
                (norma_vec3_view){n, (size_t)count, 0, NORMA_FORMAT_FLOAT}, out[0], 0,
                (size_t)count));
            for (int i = 0; i < count; ++i)
                if (i == at)
                    assert_true(is_zero(out[i]));
                else
                    assert_direction(out[i], 0.5, 4, 3, 1e-5);
        }
    const float flat[9] = {0, 0, 0, 0, 0, 0, 0, 0, 1}, side[3] = {1, 1, 0};
    float out[3];
    assert_ok(norma_transform_normals(
        flat, (norma_vec3_view){side, 1, 0, NORMA_FORMAT_FLOAT}, out, 0, 1));
    assert_true(is_zero(out));
}

static void every_format_and_stride(void **state) {
    (void)state;
    enum { COUNT = 53 };
    static const struct {
        norma_format format;
        size_t size;
    } formats[] = {
        {NORMA_FORMAT_FLOAT, 4},
        {NORMA_FORMAT_DOUBLE, 8},
        {NORMA_FORMAT_INT8, 1},
        {NORMA_FORMAT_UINT8, 1},
        {NORMA_FORMAT_INT16, 2},
        {NORMA_FORMAT_UINT16, 2},
    };
    for (size_t f = 0; f < COUNT_OF(formats); ++f)
        for (size_t extra = 0; extra < 6; ++extra) {
            const size_t stride = 3 * formats[f].size + extra, out_stride = 12 + extra;
            unsigned char *in = malloc(COUNT * stride + 1), *out = malloc(COUNT * out_stride + 1);
            assert_non_null(in);
            assert_non_null(out);
            memset(out, 0xcd, COUNT * out_stride + 1);
            double plain[COUNT][3];
            uint64_t seed = 3;
            for (size_t i = 0; i < COUNT; ++i)
                for (size_t k = 0; k < 3; ++k) {
                    const int value = (int)(next_random(&seed) % 100) + 1;
                    plain[i][k] = value;
                    unsigned char *to = in + 1 + i * stride + k * formats[f].size;
                    switch (formats[f].format) {
                    case NORMA_FORMAT_FLOAT:
                        memcpy(to, &(float){(float)value}, 4);
                        break;
                    case NORMA_FORMAT_DOUBLE:
                        memcpy(to, &(double){(double)value}, 8);
                        break;
                    case NORMA_FORMAT_INT8:
                    case NORMA_FORMAT_UINT8:
                        *to = (unsigned char)value;
                        break;
                    case NORMA_FORMAT_INT16:
                    case NORMA_FORMAT_UINT16:
                        memcpy(to, &(int16_t){(int16_t)value}, 2);
                        break;
                    }
                }
            void *where = out + 1;
            assert_ok(norma_transform_normals(axes_normal_matrix,
                (norma_vec3_view){in + 1, COUNT, extra ? stride : 0, formats[f].format},
                (float *)where, extra ? out_stride : 0, COUNT));
            for (size_t i = 0; i < COUNT; ++i) {
                float n[3];
                memcpy(n, out + 1 + i * out_stride, sizeof n);
                assert_direction(n, 0.5 * plain[i][0], 2 * plain[i][1], plain[i][2], 1e-5);
                for (size_t k = 12; k < out_stride; ++k)
                    assert_int_equal(out[1 + i * out_stride + k],
                        0xcd); /* between the normals nothing is written */
            }
            free(in);
            free(out);
        }
}

static void signed_integers(void **state) {
    (void)state;
    const int8_t small[3] = {-128, 127, 0};
    const int16_t wide[3] = {-32768, 0, 32767};
    const float identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    float out[3];
    assert_ok(norma_transform_normals(
        identity, (norma_vec3_view){small, 1, 0, NORMA_FORMAT_INT8}, out, 0, 1));
    assert_direction(out, -128, 127, 0, 1e-5);
    assert_ok(norma_transform_normals(
        identity, (norma_vec3_view){wide, 1, 0, NORMA_FORMAT_INT16}, out, 0, 1));
    assert_direction(out, -32768, 0, 32767, 1e-5);
}

/* The same bits in place, apart, one by one, and at any place within a block. */
static void same_bits_however_called(void **state) {
    (void)state;
    enum { COUNT = 203 }; /* blocks of 16 and 64, then one in which two are done by themselves */
    static float in[COUNT][3], apart[COUNT][3], in_place[COUNT][3], interleaved[COUNT][8];
    uint64_t seed = 5;
    float m[9];
    for (int i = 0; i < 9; ++i) m[i] = (float)random_unit(&seed);
    for (int i = 0; i < COUNT; ++i)
        for (int k = 0; k < 3; ++k) in[i][k] = i / 2 == 75 ? 0.0f : (float)random_unit(&seed);
    assert_ok(norma_transform_normals(
        m, (norma_vec3_view){in, COUNT, 0, NORMA_FORMAT_FLOAT}, apart[0], 0, COUNT));
    memcpy(in_place, in, sizeof in);
    assert_ok(norma_transform_normals(
        m, (norma_vec3_view){in_place, COUNT, 0, NORMA_FORMAT_FLOAT}, in_place[0], 0, COUNT));
    assert_memory_equal(apart, in_place, sizeof apart);
    for (int i = 0; i < COUNT; ++i) memcpy(interleaved[i] + 3, in[i], sizeof in[i]);
    assert_ok(norma_transform_normals(m,
        (norma_vec3_view){interleaved[0] + 3, COUNT, 32, NORMA_FORMAT_FLOAT}, interleaved[0] + 3,
        32, COUNT));
    for (int i = 0; i < COUNT; ++i) {
        float single[3];
        assert_ok(norma_transform_normals(
            m, (norma_vec3_view){in[i], 1, 0, NORMA_FORMAT_FLOAT}, single, 0, 1));
        assert_memory_equal(single, apart[i], sizeof single);
        assert_memory_equal(interleaved[i] + 3, apart[i], sizeof single);
        assert_true(interleaved[i][0] == 0.0f && interleaved[i][6] == 0.0f);
    }
}

static void arguments(void **state) {
    (void)state;
    float in[2][3] = {{1, 0, 0}, {0, 1, 0}}, out[6];
    memset(out, 0x5a, sizeof out);
    float untouched[6];
    memcpy(untouched, out, sizeof out);
    const norma_vec3_view view = {in, 2, 0, NORMA_FORMAT_FLOAT};
    assert_int_equal(norma_transform_normals(NULL, view, out, 0, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_transform_normals(axes_normal_matrix, view, NULL, 0, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_transform_normals(axes_normal_matrix,
                         (norma_vec3_view){NULL, 2, 0, NORMA_FORMAT_FLOAT}, out, 0, 2),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_transform_normals(axes_normal_matrix,
                         (norma_vec3_view){in, 2, 0, (norma_format)17}, out, 0, 2),
        NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_transform_normals(axes_normal_matrix, view, out, 8, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_transform_normals(axes_normal_matrix, view, out, 0, 1), NORMA_ERROR_CAPACITY);
    assert_int_equal(
        norma_transform_normals(axes_normal_matrix,
            (norma_vec3_view){in, SIZE_MAX / 4, 0, NORMA_FORMAT_FLOAT}, out, 0, SIZE_MAX),
        NORMA_ERROR_OVERFLOW);
    assert_int_equal(norma_transform_normals(axes_normal_matrix, view, out, SIZE_MAX / 2 + 1, 2),
        NORMA_ERROR_OVERFLOW);
    const double model[16] = {0};
    assert_int_equal(norma_transform_positions(NULL, view, out, 0, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_transform_positions(model, view, out, 0, 1), NORMA_ERROR_CAPACITY);
    assert_memory_equal(out, untouched, sizeof out);
    assert_ok(norma_transform_normals(axes_normal_matrix, (norma_vec3_view){0}, NULL, 0, 0));
    assert_ok(norma_transform_positions(model, (norma_vec3_view){0}, NULL, 0, 0));
    assert_ok(norma_transform_positions_double(model, (norma_vec3_view){0}, NULL, 0, 0));
}

/* ---- positions */

static void positions(void **state) {
    (void)state;
    enum { COUNT = 37 };
    const double model[16] = {1, 2, 3, 99, 4, 5, 6, 99, 7, 8, 9, 99, 1000, -2000, 0.5,
        99}; /* the last row says nothing */
    int16_t in[COUNT][3];
    float out[COUNT][3];
    double wide[COUNT][3];
    uint64_t seed = 7;
    for (int i = 0; i < COUNT; ++i)
        for (int k = 0; k < 3; ++k) in[i][k] = (int16_t)(next_random(&seed) % 2000);
    const norma_vec3_view view = {in, COUNT, 0, NORMA_FORMAT_INT16};
    assert_ok(norma_transform_positions(model, view, out[0], 0, COUNT));
    assert_ok(norma_transform_positions_double(model, view, wide[0], 0, COUNT));
    for (int i = 0; i < COUNT; ++i)
        for (int r = 0; r < 3; ++r) {
            const int twice = 2 * (in[i][0] * (r + 1) + in[i][1] * (r + 4) + in[i][2] * (r + 7)) +
                              (int[]){2000, -4000, 1}[r];
            assert_true(wide[i][r] == twice / 2.0);
            assert_true(out[i][r] == (float)(twice / 2.0));
        }
    float in_place[3] = {1, 2, 3};
    assert_ok(norma_transform_positions(
        model, (norma_vec3_view){in_place, 1, 0, NORMA_FORMAT_FLOAT}, in_place, 0, 1));
    assert_true(in_place[0] == 1030.0f && in_place[1] == -1964.0f && in_place[2] == 42.5f);
}

/* ---- tangents */

/* Tangents go with the surface: a tangent that lies in it before lies in it afterwards, along the
 * image of the same line. */
static void tangents_stay_in_the_surface(void **state) {
    (void)state;
    uint64_t seed = 9;
    for (int round = 0; round < 2000; ++round) {
        float model[16], matrix[9], normal[3], tangent[4], out[4];
        double n[3], t[3];
        for (int i = 0; i < 16; ++i) model[i] = (float)random_unit(&seed);
        for (int i = 0; i < 3; ++i) n[i] = random_unit(&seed), t[i] = random_unit(&seed);
        const double nn = n[0] * n[0] + n[1] * n[1] + n[2] * n[2],
                     nt = n[0] * t[0] + n[1] * t[1] + n[2] * t[2];
        for (int i = 0; i < 3; ++i)
            tangent[i] = (float)(t[i] -= n[i] * nt / nn), normal[i] = (float)n[i];
        tangent[3] = round % 2 ? 1.0f : -1.0f;
        norma_matrix_info info;
        assert_ok(norma_normal_matrix(model, NORMA_WINDING_REVERSED, matrix, &info));
        if (info.anisotropy > 50.0) continue;
        assert_ok(norma_transform_normals(
            matrix, (norma_vec3_view){normal, 1, 0, NORMA_FORMAT_FLOAT}, normal, 0, 1));
        assert_ok(norma_transform_tangents(
            model, tangent, 0, (norma_vec3_view){normal, 1, 0, NORMA_FORMAT_FLOAT}, 1, out, 0, 1));
        double moved[3];
        for (int r = 0; r < 3; ++r)
            moved[r] =
                (double)model[r] * t[0] + (double)model[4 + r] * t[1] + (double)model[8 + r] * t[2];
        assert_direction(out, moved[0], moved[1], moved[2], 2e-3);
        assert_true(fabs(length_of(out) - 1.0) < 2e-7);
        assert_true(fabs((double)out[0] * (double)normal[0] + (double)out[1] * (double)normal[1] +
                         (double)out[2] * (double)normal[2]) < 2e-7);
        assert_true(out[3] == (info.mirrored ? -tangent[3] : tangent[3]));
    }
}

/* FACTS: the inverse transpose on tangents would be 36.9 degrees off at (2, 1, 1). */
static void tangents_take_the_model_itself(void **state) {
    (void)state;
    const float model[16] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1},
                tangent[4] = {0.70710678f, 0.70710678f, 0, 1}, up[3] = {0, 0, 1};
    float out[4];
    assert_ok(norma_transform_tangents(
        model, tangent, 0, (norma_vec3_view){up, 1, 0, NORMA_FORMAT_FLOAT}, 1, out, 0, 1));
    assert_direction(out, 2, 1, 0, 1e-5);
}

static void orthogonalised_tangents(void **state) {
    (void)state;
    const float tangents[6][4] = {{1, 0, 1, -1}, {0, 0, 5, 1}, {0, 0, 0, 1}, {NAN, 0, 0, -1},
        {3, 4, 0, 1}, {1e-30f, 0, 1e-30f, 1}};
    const double normals[6][3] = {
        {0, 0, 2}, {0, 0, 1}, {0, 0, 1e-200}, {0, 1e300, 0}, {0, 0, 0}, {0, 0, 1}};
    float out[6][4];
    assert_ok(norma_orthogonalise_tangents(
        tangents[0], 0, (norma_vec3_view){normals, 6, 0, NORMA_FORMAT_DOUBLE}, 6, out[0], 0, 6));
    assert_direction(out[0], 1, 0, 0, 1e-9);
    assert_direction(out[4], 3, 4, 0, 1e-5); /* a normal that is zero asks for nothing */
    assert_direction(out[5], 1, 0, 0, 1e-9);
    for (int i = 0; i < 6; ++i) {
        assert_true(fabs(length_of(out[i]) - 1.0) < 1e-6);
        if (i != 4)
            assert_true(fabs((double)out[i][0] * normals[i][0] + (double)out[i][1] * normals[i][1] +
                             (double)out[i][2] * normals[i][2]) <=
                        1e-7 * fabs(normals[i][0] + normals[i][1] + normals[i][2]));
        assert_true(out[i][3] == tangents[i][3]);
    }
    static float both[6][4];
    memcpy(both, tangents, sizeof both);
    assert_ok(norma_orthogonalise_tangents(
        both[0], 0, (norma_vec3_view){normals, 6, 0, NORMA_FORMAT_DOUBLE}, 6, both[0], 0, 6));
    assert_memory_equal(both, out, sizeof both);
}

static void tangent_arguments(void **state) {
    (void)state;
    float model[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
          tangents[2][4] = {{1, 0, 0, 1}, {1, 0, 0, 1}}, normals[2][3] = {{0, 0, 1}, {0, 0, 1}},
          out[8];
    const norma_vec3_view view = {normals, 2, 0, NORMA_FORMAT_FLOAT};
    assert_int_equal(
        norma_transform_tangents(NULL, tangents[0], 0, view, 2, out, 0, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_transform_tangents(model, NULL, 0, view, 2, out, 0, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_transform_tangents(model, tangents[0], 0, view, 2, NULL, 0, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_transform_tangents(model, tangents[0], 0, view, 3, out, 0, 3),
        NORMA_ERROR_ARGUMENT); /* more tangents than normals */
    assert_int_equal(
        norma_transform_tangents(model, tangents[0], 0, view, 2, out, 0, 1), NORMA_ERROR_CAPACITY);
    assert_int_equal(norma_transform_tangents(model, tangents[0], SIZE_MAX, view, 2, out, 0, 2),
        NORMA_ERROR_OVERFLOW);
    assert_ok(norma_transform_tangents(model, NULL, 0, (norma_vec3_view){0}, 0, NULL, 0, 0));
    model[5] = NAN;
    assert_int_equal(
        norma_transform_tangents(model, tangents[0], 0, view, 2, out, 0, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_orthogonalise_tangents(tangents[0], 0, view, 2, out, 12, 2), NORMA_ERROR_ARGUMENT);
}

/* ---- winding */

static void winding_of_triangles(void **state) {
    (void)state;
    uint32_t wide[6] = {1, 2, 3, 70000, 5, 6};
    uint16_t middle[6] = {1, 2, 3, 700, 5, 6};
    uint8_t narrow[6] = {1, 2, 3, 200, 5, 6};
    assert_ok(norma_reverse_winding(wide, 0, 6, NULL, 0));
    assert_ok(norma_reverse_winding(middle, 2, 6, NULL, 0));
    assert_ok(norma_reverse_winding(narrow, 1, 6, NULL, 0));
    assert_memory_equal(wide, ((uint32_t[]){1, 3, 2, 70000, 6, 5}), sizeof wide);
    assert_memory_equal(middle, ((uint16_t[]){1, 3, 2, 700, 6, 5}), sizeof middle);
    assert_memory_equal(narrow, ((uint8_t[]){1, 3, 2, 200, 6, 5}), sizeof narrow);
    assert_ok(norma_reverse_winding(wide, 4, 6, NULL, 0));
    assert_memory_equal(wide, ((uint32_t[]){1, 2, 3, 70000, 5, 6}), sizeof wide);
}

static void winding_of_polygons(void **state) {
    (void)state;
    uint32_t corners[14] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};
    const uint32_t starts[] = {0, 5, 5, 6, 8, 12, 14};
    assert_ok(norma_reverse_winding(corners, 4, 14, starts, 6));
    assert_memory_equal(
        corners, ((uint32_t[]){0, 4, 3, 2, 1, 5, 6, 7, 8, 11, 10, 9, 12, 13}), sizeof corners);
}

static void winding_arguments(void **state) {
    (void)state;
    uint32_t corners[6] = {0, 1, 2, 3, 4, 5}, before[6];
    memcpy(before, corners, sizeof corners);
    const uint32_t falling[] = {0, 4, 3, 6}, late[] = {1, 3, 6}, early[] = {0, 3, 5};
    assert_int_equal(norma_reverse_winding(corners, 4, 5, NULL, 0), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_reverse_winding(NULL, 4, 6, NULL, 0), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_reverse_winding(corners, 3, 6, NULL, 0), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_reverse_winding(corners, 4, 6, falling, 3), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_reverse_winding(corners, 4, 6, late, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_reverse_winding(corners, 4, 6, early, 2), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_reverse_winding(corners, 4, SIZE_MAX / 4 + 3, NULL, 0), NORMA_ERROR_OVERFLOW);
    assert_memory_equal(corners, before, sizeof corners);
    assert_ok(norma_reverse_winding(NULL, 0, 0, NULL, 0));
}

/* A mirror baked: reversed faces and the reversed matrix agree, and so do kept faces and the kept
 * matrix. */
static void mirrors_agree_with_their_winding(void **state) {
    (void)state;
    uint64_t seed = 13;
    for (int round = 0; round < 2000; ++round) {
        float model[16], matrix[9];
        double a[3], b[3], n[3], p[3][3];
        for (int i = 0; i < 16; ++i) model[i] = (float)random_unit(&seed);
        for (int i = 0; i < 3; ++i) a[i] = random_unit(&seed), b[i] = random_unit(&seed);
        for (int i = 0; i < 3; ++i)
            n[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
        for (int r = 0; r < 3; ++r) {
            p[0][r] = 0.0;
            p[1][r] =
                (double)model[r] * a[0] + (double)model[4 + r] * a[1] + (double)model[8 + r] * a[2];
            p[2][r] =
                (double)model[r] * b[0] + (double)model[4 + r] * b[1] + (double)model[8 + r] * b[2];
        }
        for (int w = 0; w < 2; ++w) {
            uint32_t corners[3] = {0, 1, 2};
            norma_matrix_info info;
            assert_ok(norma_normal_matrix(model, (norma_winding)w, matrix, &info));
            if (w && info.mirrored) assert_ok(norma_reverse_winding(corners, 4, 3, NULL, 0));
            float out[3];
            assert_ok(norma_transform_normals(
                matrix, (norma_vec3_view){n, 1, 0, NORMA_FORMAT_DOUBLE}, out, 0, 1));
            const double *u = p[corners[1]], *v = p[corners[2]];
            const double cross[3] = {
                u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
            if (info.anisotropy < 100.0) assert_direction(out, cross[0], cross[1], cross[2], 1e-3);
        }
    }
}

/* ---- interpolation */

static void interpolated_normals(void **state) {
    (void)state;
    const float x[3] = {1, 0, 0}, y[3] = {0, 1, 0}, z[3] = {0, 0, 1}, minus_x[3] = {-1, 0, 0},
                middle[3] = {1 / 3.0f, 1 / 3.0f, 1 / 3.0f}, edge[3] = {0.5f, 0.5f, 0},
                corner[3] = {0, 0, 1};
    float n[3];
    assert_ok(norma_interpolate_normal(x, y, z, middle, n));
    assert_direction(n, 1, 1, 1, 1e-5);
    assert_true(fabs(length_of(n) - 1.0) < 1e-7);
    assert_ok(norma_interpolate_normal(x, y, z, edge, n));
    assert_direction(n, 1, 1, 0, 1e-5);
    assert_ok(norma_interpolate_normal(x, y, z, corner, n));
    assert_direction(n, 0, 0, 1, 1e-9);
    assert_ok(norma_interpolate_normal(x, minus_x, z, edge, n));
    assert_true(is_zero(n));
    const float first[3] = {0.6f, 0.8f, 0}, third[3] = {-0.99282032f, 0.11961524f, 0},
                two_thirds[3] = {0.39282032f, -0.91961524f, 0};
    assert_ok(norma_interpolate_normal(
        first, third, two_thirds, middle, n)); /* sums to rounding, not to a direction */
    assert_true(is_zero(n));
    const float nothing[3] = {NAN, 0, 0}, tiny[3] = {1e-38f, 0, 0}, huge[3] = {0, 3e38f, 0};
    assert_ok(norma_interpolate_normal(nothing, y, z, middle, n));
    assert_true(is_zero(n));
    assert_ok(norma_interpolate_normal(tiny, tiny, tiny, middle, n));
    assert_direction(n, 1, 0, 0, 1e-9);
    assert_ok(norma_interpolate_normal(huge, huge, huge, middle, n));
    assert_direction(n, 0, 1, 0, 1e-9);
    assert_int_equal(norma_interpolate_normal(NULL, y, z, middle, n), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_interpolate_normal(x, y, z, NULL, n), NORMA_ERROR_ARGUMENT);
    assert_int_equal(norma_interpolate_normal(x, y, z, middle, NULL), NORMA_ERROR_ARGUMENT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(worked_example),
        cmocka_unit_test(unit_over_the_whole_range),
        cmocka_unit_test(doubles_of_any_size),
        cmocka_unit_test(zero_stays_and_not_finite_becomes_zero),
        cmocka_unit_test(every_format_and_stride),
        cmocka_unit_test(signed_integers),
        cmocka_unit_test(same_bits_however_called),
        cmocka_unit_test(arguments),
        cmocka_unit_test(positions),
        cmocka_unit_test(tangents_stay_in_the_surface),
        cmocka_unit_test(tangents_take_the_model_itself),
        cmocka_unit_test(orthogonalised_tangents),
        cmocka_unit_test(tangent_arguments),
        cmocka_unit_test(winding_of_triangles),
        cmocka_unit_test(winding_of_polygons),
        cmocka_unit_test(winding_arguments),
        cmocka_unit_test(mirrors_agree_with_their_winding),
        cmocka_unit_test(interpolated_normals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
