/* judge_matrices.c: normal matrices against exact cofactors, and what goes through matrices against
 * long doubles. See judge.h. */
#include "oracle/exact.h"
#include "oracle/guarded.h"
#include "oracle/judge.h"
#include <math.h>
#include <string.h>

static float entry(trial *t, uint32_t kind) {
    static const float wild[] = {0, 1e-38F, -1e38F, 1e-45F, 3.4e38F, 1, -1, 1e-20F, 7e19F};
    if (kind == 0) return (float)trial_below(t, 7) - 3;
    if (kind == 1) return (float)trial_below(t, 1 << 20) / 1e5F - 5;
    if (trial_below(t, 60) == 0) return trial_below(t, 2) ? NAN : -INFINITY;
    return wild[trial_below(t, 9)];
}

typedef struct cofactors {
    long double entries[9];
    int sign; /* of the determinant, +1 where it is 0 */
} cofactors;

static cofactors exact_cofactors(const float m[16]) {
    cofactors result;
    exact_vec3 columns[3], product;
    exact_init(&product);
    for (int i = 0; i < 3; ++i) {
        const double c[3] = {(double)m[4 * i], (double)m[4 * i + 1], (double)m[4 * i + 2]};
        exact_init(&columns[i]);
        exact_set(&columns[i], c, EXACT_LEAST);
    }
    for (int i = 0; i < 3; ++i) {
        exact_cross(&product, &columns[(i + 1) % 3], &columns[(i + 2) % 3]);
        exact_round_vec3(result.entries + 3 * i, &product, 2 * EXACT_LEAST);
    }
    exact_cross(&product, &columns[1], &columns[2]);
    exact_vec3 determinant;
    exact_init(&determinant);
    exact_dot(determinant.x[0], &columns[0], &product);
    result.sign = mpz_sgn(determinant.x[0]) < 0 ? -1 : 1;
    for (int i = 0; i < 3; ++i) exact_clear(&columns[i]);
    exact_clear(&product);
    exact_clear(&determinant);
    return result;
}

/* The same but for one power of two, to a float's rounding; signs and zeros exactly. */
static void judge_matrix(trial *t, const cofactors *c, int sign, const float got[9]) {
    int largest = 0, own, of_got;
    for (int i = 1; i < 9; ++i)
        if (fabsl(c->entries[i]) > fabsl(c->entries[largest])) largest = i;
    frexpl(c->entries[largest], &own);
    frexp((double)got[largest], &of_got);
    for (int i = 0; i < 9; ++i) {
        const long double is = (long double)got[i];
        const long double scaled = (long double)sign * ldexpl(c->entries[i], of_got - own);
        /* the largest may have been rounded up to the next power of two */
        const int near = fabsl(is - scaled) <= 0x1p-22L * fabsl(scaled) + 0x1p-149L ||
                         fabsl(is - 2 * scaled) <= 0x1p-22L * fabsl(2 * scaled) + 0x1p-149L ||
                         fabsl(is - scaled / 2) <= 0x1p-22L * fabsl(scaled / 2) + 0x1p-149L;
        const int underflows = is == 0 && fabsl(scaled) < 0x1p-148L;
        if (!near || (!underflows && ((is > 0) != (scaled > 0) || (is < 0) != (scaled < 0))) ||
            (got[i] == 0 && signbit(got[i])))
            complain(t, "not the exact cofactor: entry", (size_t)i);
    }
}

static void judge_vectors(trial *t, const float matrix[9]) {
    enum { COUNT = 9 };
    float *in = trial_array(t, COUNT, 12), *out = trial_array(t, COUNT, 12);
    int finite = 1;
    for (int i = 0; i < 9; ++i) finite &= isfinite(matrix[i]) != 0;
    for (size_t i = 0; i < 3 * COUNT; ++i) in[i] = entry(t, trial_below(t, 3));
    const norma_vec3_view view = {in, COUNT, 0, NORMA_FORMAT_FLOAT};
    if (norma_transform_normals(matrix, view, out, 0, COUNT)) complain(t, "normals are refused", 0);
    for (size_t i = 0; i < COUNT; ++i) {
        const float *n = in + 3 * i, *got = out + 3 * i;
        long double expected[3], size = 0, bound = 0;
        for (int k = 0; k < 3; ++k) {
            expected[k] = 0;
            for (int j = 0; j < 3; ++j) {
                const long double term = (long double)matrix[3 * j + k] * (long double)n[j];
                expected[k] += term;
                bound = fmaxl(bound, fabsl(term));
            }
            size = fmaxl(size, fabsl(expected[k]));
        }
        const int there = finite && isfinite(n[0]) && isfinite(n[1]) && isfinite(n[2]);
        const long double is[3] = {(long double)got[0], (long double)got[1], (long double)got[2]};
        if (!there || bound == 0) {
            if (got[0] != 0 || got[1] != 0 || got[2] != 0)
                complain(t, "not zero, as its input: normal", i);
        } else if (size > 1e-9L * bound && !(oracle_angle(is, expected) < 3e-7L))
            complain(t, "not the transformed normal", i);
    }
}

void judge_matrices(trial *t) {
    const uint32_t kind = trial_below(t, 3);
    float model[16], got[9], batch[9];
    const norma_winding winding = trial_below(t, 2) ? NORMA_WINDING_REVERSED : NORMA_WINDING_KEPT;
    int finite = 1;
    for (int i = 0; i < 16; ++i) model[i] = entry(t, kind);
    if (trial_below(t, 6) == 0) memcpy(model, model + 4, 12); /* singular */
    for (int i = 0; i < 11; ++i) finite &= i % 4 == 3 || isfinite(model[i]);
    norma_result result = norma_normal_matrix(model, winding, got, NULL);
    if (result != (finite ? NORMA_OK : NORMA_ERROR_ARGUMENT))
        complain(t, "a matrix's result", (size_t)-result);
    if (norma_normal_matrices(model, 1, winding, batch, 1) != result ||
        memcmp(batch, got, sizeof got))
        complain(t, "a matrix in a batch differs", 0);
    if (finite) {
        const cofactors c = exact_cofactors(model);
        judge_matrix(t, &c, winding == NORMA_WINDING_REVERSED ? c.sign : 1, got);
    }
    for (int i = 0; i < 9 && !finite; ++i)
        if (got[i] != 0) complain(t, "not zero, though the model is not finite: entry", (size_t)i);
    judge_vectors(t, got);
}
