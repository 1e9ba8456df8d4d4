/* exact_area.c: see exact_area.h. */
#include "oracle/exact.h"
#include <limits.h>
#include <math.h>
#include <stdint.h>

_Static_assert(ULONG_MAX >= UINT64_MAX, "64 bits are taken from a GMP integer at a time");

/* Numbers that were given back keep their memory for the next. */
enum { MOST_KEPT = 64 };
static exact_vec3 kept[MOST_KEPT];
static size_t kept_count;

void exact_init(exact_vec3 *v) {
    if (kept_count)
        *v = kept[--kept_count];
    else
        mpz_inits(v->x[0], v->x[1], v->x[2], NULL);
    for (int i = 0; i < 3; ++i) mpz_set_ui(v->x[i], 0);
}

void exact_clear(exact_vec3 *v) {
    if (kept_count < MOST_KEPT)
        kept[kept_count++] = *v;
    else
        mpz_clears(v->x[0], v->x[1], v->x[2], NULL);
}

int exact_exponent(const double *numbers, size_t count) {
    int least = INT_MAX;
    for (size_t i = 0; i < count; ++i) {
        int exponent;
        if (numbers[i] == 0) continue;
        frexp(numbers[i], &exponent);
        if (exponent - 53 < least) least = exponent - 53;
    }
    return least == INT_MAX ? 0 : least;
}

void exact_set(exact_vec3 *v, const double p[3], int exponent) {
    for (int i = 0; i < 3; ++i) {
        int own;
        const double mantissa = frexp(p[i], &own);
        mpz_set_si(v->x[i], (long)(mantissa * 0x1p53));
        if (p[i] != 0) mpz_mul_2exp(v->x[i], v->x[i], (mp_bitcnt_t)(own - 53 - exponent));
    }
}

void exact_sub(exact_vec3 *out, const exact_vec3 *a, const exact_vec3 *b) {
    for (int i = 0; i < 3; ++i) mpz_sub(out->x[i], a->x[i], b->x[i]);
}

void exact_add_cross(exact_vec3 *sum, const exact_vec3 *a, const exact_vec3 *b) {
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        mpz_addmul(sum->x[i], a->x[j], b->x[k]);
        mpz_submul(sum->x[i], a->x[k], b->x[j]);
    }
}

void exact_cross(exact_vec3 *out, const exact_vec3 *a, const exact_vec3 *b) {
    for (int i = 0; i < 3; ++i) mpz_set_ui(out->x[i], 0);
    exact_add_cross(out, a, b);
}

void exact_dot(mpz_t out, const exact_vec3 *a, const exact_vec3 *b) {
    mpz_mul(out, a->x[0], b->x[0]);
    mpz_addmul(out, a->x[1], b->x[1]);
    mpz_addmul(out, a->x[2], b->x[2]);
}

int exact_is_zero(const exact_vec3 *v) {
    return mpz_sgn(v->x[0]) == 0 && mpz_sgn(v->x[1]) == 0 && mpz_sgn(v->x[2]) == 0;
}

long double exact_round(const mpz_t n, int exponent) {
    if (mpz_sgn(n) == 0) return 0;
    const size_t bits = mpz_sizeinbase(n, 2), cut = bits > 64 ? bits - 64 : 0;
    exact_vec3 top;
    exact_init(&top);
    if (cut) mpz_tdiv_q_2exp(top.x[0], n, cut);
    const long double size = ldexpl((long double)mpz_get_ui(cut ? top.x[0] : n),
        (int)cut + exponent); /* mpz_get_ui drops the sign */
    exact_clear(&top);
    return mpz_sgn(n) < 0 ? -size : size;
}

void exact_round_vec3(long double out[3], const exact_vec3 *v, int exponent) {
    for (int i = 0; i < 3; ++i) out[i] = exact_round(v->x[i], exponent);
}
