/* test_transform_kernels.c: a stream of normals by the kernel of each instruction set that the
 * machine has: the same bits. norma_transform_normals takes the best and offers no choice, so its
 * source is compiled here once more, with one. */
#include "core/call/call.h"
static core_level chosen_level(norma_isa isa);
#define norma_core_level                 chosen_level
#define norma_transform_normals          transform_as_chosen
#define norma_transform_positions        chosen_transform_positions
#define norma_transform_positions_double chosen_transform_positions_double
#define norma_core_perpendicular_tangent chosen_core_perpendicular_tangent
#define norma_transform_tangents         chosen_transform_tangents
#define norma_orthogonalise_tangents     chosen_orthogonalise_tangents
#define norma_interpolate_normal         chosen_interpolate_normal
#include "core/matrix/transform.c"
#undef norma_core_level
#undef norma_transform_normals
#undef norma_transform_positions
#undef norma_transform_positions_double
#undef norma_core_perpendicular_tangent
#undef norma_transform_tangents
#undef norma_orthogonalise_tangents
#undef norma_interpolate_normal

#include "check.h"
#include "oracle/shapes.h"

static core_level chosen = CORE_PORTABLE;
static core_level chosen_level(norma_isa isa) { return (void)isa, chosen; }

enum { NORMALS = 4099 };

/* Of any direction and many lengths; from some on also zero, NaN, infinite, and near the ends of
 * the floats' range. */
static void make_normals(uint64_t seed, size_t strange_from, float normals[3 * NORMALS]) {
    static const float strange[] = {0.0F, -0.0F, NAN, INFINITY, 1e-40F, 3e38F, 1e-19F, 1e19F};
    for (size_t i = 0; i < (size_t)3 * NORMALS; ++i) {
        const int is_strange = i >= 3 * strange_from && shape_random(&seed) % 16 == 0;
        normals[i] =
            is_strange
                ? strange[shape_random(&seed) % COUNT_OF(strange)]
                : (float)(shape_random_unit(&seed) * ldexp(1, (int)(shape_random(&seed) % 5)));
    }
}

static void every_kernel_gives_the_same_bits(void **state) {
    static float in[3 * NORMALS], expected[3 * NORMALS], got[3 * NORMALS];
    const core_level best = norma_core_level(NORMA_ISA_BEST);
    (void)state;
    for (uint64_t seed = 1; seed <= 40; ++seed) {
        float matrix[9];
        uint64_t random = seed;
        for (int k = 0; k < 9; ++k) matrix[k] = (float)shape_random_unit(&random);
        make_normals(seed, seed % 2 ? NORMALS : (size_t)seed * 97, in);
        for (int level = CORE_PORTABLE; level <= (int)best; ++level) {
            chosen = (core_level)level;
            memset(got, 0, sizeof got);
            assert_ok(transform_as_chosen(
                matrix, (norma_vec3_view){in, NORMALS, 0, NORMA_FORMAT_FLOAT}, got, 0, NORMALS));
            if (level == CORE_PORTABLE) memcpy(expected, got, sizeof got);
            if (memcmp(expected, got, sizeof got) != 0)
                fail_msg("seed %d: level %d gives other bits than portable C", (int)seed, level);
        }
        assert_ok(norma_transform_normals(
            matrix, (norma_vec3_view){in, NORMALS, 0, NORMA_FORMAT_FLOAT}, got, 0, NORMALS));
        assert_memory_equal(expected, got, sizeof got);
    }
}

int main(void) {
    static const struct CMUnitTest tests[] = {cmocka_unit_test(every_kernel_gives_the_same_bits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
