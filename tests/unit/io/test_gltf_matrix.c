/* Matrices as glTF's nodes can say them: what is taken apart must be the same again when put
 * together by plain multiplication, for any matrix: rotated, scaled over many powers of ten,
 * mirrored, sheared, of any rank. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>
#include "io/gltf/gltf.h"

static double random_number(uint64_t *state) {
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(int64_t)(*state >> 11) / (double)(1ll << 52) - 1;
}

static void random_matrix(uint64_t *state, int rank, double m[16]) {
    const double scale = pow(10, 12 * random_number(state));
    for (int i = 0; i < 16; ++i) m[i] = i % 4 == 3 ? i == 15 : scale * random_number(state);
    for (int i = 0; i < 3 && rank < 3; ++i)
        m[8 + i] = rank == 0 ? 0 : m[i] - (rank == 2 ? 2 * m[4 + i] : 0);
    for (int i = 0; i < 3 && rank < 2; ++i) {
        m[4 + i] = rank == 0 ? 0 : -3 * m[i];
        m[i] = rank == 0 ? 0 : m[i];
    }
}

static double largest(const double m[16]) {
    double most = 0;
    for (int i = 0; i < 12; ++i) most = fmax(most, fabs(m[i]));
    return most;
}

static void assert_near(const double a[16], const double b[16], double tolerance) {
    for (int i = 0; i < 16; ++i)
        if (!(fabs(a[i] - b[i]) <= tolerance * (i < 12 ? largest(a) : fmax(1, fabs(a[i])))))
            fail_msg("element %d: %.17g and %.17g", i, a[i], b[i]);
}

static void multiply(const double a[16], const double b[16], double out[16]) {
    for (int i = 0; i < 16; ++i) {
        out[i] = 0;
        for (int k = 0; k < 4; ++k) out[i] += a[i % 4 + 4 * k] * b[i / 4 * 4 + k];
    }
}

static double norm4(const double q[4]) {
    return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

static void test_split_is_exact(void **state) {
    (void)state;
    uint64_t seed = 1;
    for (int i = 0; i < 4000; ++i) {
        double m[16], a[16], b[16], product[16];
        random_matrix(&seed, i % 4, m);
        gltf_trs outer, inner;
        norma_gltf_matrix_split(m, &outer, &inner);
        assert_true(
            fabs(norm4(outer.rotation) - 1) < 1e-15 && fabs(norm4(inner.rotation) - 1) < 1e-15);
        norma_gltf_matrix_compose(&outer, a);
        norma_gltf_matrix_compose(&inner, b);
        multiply(a, b, product);
        assert_near(m, product, 1e-14);
    }
}

static void test_decompose(void **state) {
    (void)state;
    uint64_t seed = 2;
    for (int i = 0; i < 4000; ++i) {
        gltf_trs trs, again;
        for (int k = 0; k < 4; ++k) trs.rotation[k] = random_number(&seed);
        const double norm = norm4(trs.rotation);
        for (int k = 0; k < 4; ++k) trs.rotation[k] /= norm;
        for (int k = 0; k < 3; ++k) {
            trs.translation[k] = random_number(&seed);
            trs.scale[k] = i % 5 == k ? 0 : i % 7 == k ? -1 : pow(10, 3 * random_number(&seed));
        }
        double m[16], product[16];
        norma_gltf_matrix_compose(&trs, m);
        assert_true(norma_gltf_matrix_decompose(m, &again) < 1e-13);
        norma_gltf_matrix_compose(&again, product);
        assert_near(m, product, 1e-14);
    }
    const double shear[16] = {1, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    gltf_trs trs;
    assert_true(fabs(norma_gltf_matrix_decompose(shear, &trs) - sqrt(0.5)) < 1e-15);
}

static void test_invert(void **state) {
    (void)state;
    uint64_t seed = 3;
    for (int i = 0; i < 1000; ++i) {
        double m[16], inverse[16], product[16], one[16];
        random_matrix(&seed, 3, m);
        norma_gltf_matrix_identity(one);
        assert_true(norma_gltf_matrix_invert(m, inverse));
        const double size = largest(m);
        multiply(m, inverse, product);
        norma_gltf_matrix_multiply(m, inverse, inverse);
        for (int k = 12; k < 15; ++k) {
            product[k] /= size;
            inverse[k] /= size;
        }
        assert_near(one, product, 1e-9); /* as ill-conditioned as random ones come */
        assert_near(product, inverse, 1e-9);
    }
    const double flat[16] = {1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 5, 6, 7, 1};
    double inverse[16];
    assert_false(norma_gltf_matrix_invert(flat, inverse));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_split_is_exact),
        cmocka_unit_test(test_decompose),
        cmocka_unit_test(test_invert),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
