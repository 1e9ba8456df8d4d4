/* exact_area.h: vectors of exact dyadic numbers. The doubles of one face or one pair of points are
 * brought to a common power of two, so that differences, products and sums of them are integers
 * (GMP) without any rounding; long double is rounded to only at the very end. */
#ifndef NORMA_TESTS_EXACT_H
#define NORMA_TESTS_EXACT_H
#include <float.h>
#include <gmp.h>
#include <stddef.h>

_Static_assert(LDBL_MANT_DIG >= 64 && LDBL_MAX_EXP >= 16384,
    "the oracle's last roundings need an extended long double");

typedef struct exact_vec3 {
    mpz_t x[3];
} exact_vec3;

void exact_init(exact_vec3 *v);
void exact_clear(exact_vec3 *v);

/* The least exponent e such that every one of the count finite doubles is an integer times 2^e. */
int exact_exponent(const double *numbers, size_t count);
enum { EXACT_LEAST = -1074 - 52 }; /* serves any doubles */
/* v = p / 2^exponent, p finite, exponent at most that of p's numbers. */
void exact_set(exact_vec3 *v, const double p[3], int exponent);
void exact_sub(exact_vec3 *out, const exact_vec3 *a, const exact_vec3 *b);
void exact_cross(
    exact_vec3 *out, const exact_vec3 *a, const exact_vec3 *b); /* out is neither a nor b */
void exact_add_cross(exact_vec3 *sum, const exact_vec3 *a, const exact_vec3 *b);
void exact_dot(mpz_t out, const exact_vec3 *a, const exact_vec3 *b);
int exact_is_zero(const exact_vec3 *v);

/* n * 2^exponent, to 64 bits. */
long double exact_round(const mpz_t n, int exponent);
void exact_round_vec3(long double out[3], const exact_vec3 *v, int exponent);
#endif
