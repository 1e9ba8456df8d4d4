/* avx512_in_c.h: the instructions of AVX-512 that the core uses, in plain C, for machines that have
 * AVX2 only: scripts/portable.sh includes it before every file of the core, whose kernels for
 * AVX-512 then run anywhere and give their bits. What an instruction does is Intel's: "Intel
 * Intrinsics Guide", the operation under each name. */
#ifndef NORMA_AVX512_IN_C_H
#define NORMA_AVX512_IN_C_H
#include <immintrin.h>
#include <math.h>
#include <string.h>

#define CORE_FOR_AVX512           __attribute__((target("avx2")))
#define __builtin_cpu_supports(x) 1

#define IN_C        static inline __attribute__((always_inline, target("avx2"), unused))
#define EACH(count) for (int i = 0; i < (count); ++i)

/* One result for each lane i of registers a, b, c. */
#define LANES_1(name, register, count, value)                                                      \
    IN_C register name(register a) {                                                               \
        register r;                                                                                \
        EACH(count) r[i] = value;                                                                  \
        return r;                                                                                  \
    }
#define LANES_2(name, register, count, value)                                                      \
    IN_C register name(register a, register b) {                                                   \
        register r;                                                                                \
        EACH(count) r[i] = value;                                                                  \
        return r;                                                                                  \
    }
LANES_1(in_c_sqrt_pd, __m512d, 8, sqrt(a[i]))
LANES_1(in_c_sqrt_ps, __m512, 16, sqrtf(a[i]))
LANES_2(in_c_add_pd, __m512d, 8, a[i] + b[i])
LANES_2(in_c_sub_pd, __m512d, 8, a[i] - b[i])
LANES_2(in_c_mul_pd, __m512d, 8, a[i] * b[i])
LANES_2(in_c_div_ps, __m512, 16, a[i] / b[i])
LANES_2(in_c_min_pd, __m512d, 8, a[i] < b[i] ? a[i] : b[i]) /* the second, if one is NaN */
LANES_2(in_c_max_pd, __m512d, 8, a[i] > b[i] ? a[i] : b[i])
LANES_2(in_c_unpacklo_pd, __m512d, 8, i % 2 ? b[i - 1] : a[i])
LANES_2(in_c_unpackhi_pd, __m512d, 8, i % 2 ? b[i] : a[i + 1])

IN_C __m512d in_c_fmadd_pd(__m512d a, __m512d b, __m512d c) {
    EACH(8) c[i] = fma(a[i], b[i], c[i]);
    return c;
}
IN_C __m512d in_c_xor_pd(__m512d a, __m512d b) { return (__m512d)((__m512i)a ^ (__m512i)b); }

IN_C __m512d in_c_set1_pd(double x) {
    __m512d r;
    EACH(8) r[i] = x;
    return r;
}
IN_C __m512 in_c_set1_ps(float x) {
    __m512 r;
    EACH(16) r[i] = x;
    return r;
}
IN_C __m512d in_c_loadu_pd(const double *from) {
    __m512d r;
    memcpy(&r, from, sizeof r);
    return r;
}
IN_C __m512 in_c_loadu_ps(const float *from) {
    __m512 r;
    memcpy(&r, from, sizeof r);
    return r;
}
IN_C void in_c_storeu_pd(double *to, __m512d a) { memcpy(to, &a, sizeof a); }
IN_C void in_c_storeu_ps(float *to, __m512 a) { memcpy(to, &a, sizeof a); }

/* ---- masks */

IN_C int in_c_holds(double a, double b, int comparison) {
    switch (comparison) {
    case _CMP_EQ_OQ:
    case _CMP_EQ_OS:
        return a == b;
    case _CMP_LT_OQ:
    case _CMP_LT_OS:
        return a < b;
    case _CMP_LE_OQ:
    case _CMP_LE_OS:
        return a <= b;
    case _CMP_GE_OQ:
    case _CMP_GE_OS:
        return a >= b;
    default:
        __builtin_trap(); /* a comparison that nothing used when this was written */
    }
}
IN_C __mmask8 in_c_cmp_pd_mask(__m512d a, __m512d b, int comparison) {
    unsigned mask = 0;
    EACH(8) mask |= (unsigned)in_c_holds(a[i], b[i], comparison) << i;
    return (__mmask8)mask;
}
IN_C __mmask16 in_c_mask_cmp_ps_mask(__mmask16 of, __m512 a, __m512 b, int comparison) {
    unsigned mask = 0;
    EACH(16) mask |= (unsigned)in_c_holds((double)a[i], (double)b[i], comparison) << i;
    return (__mmask16)(mask & of);
}
IN_C __m512d in_c_mask_blend_pd(__mmask8 mask, __m512d no, __m512d yes) {
    EACH(8) no[i] = mask >> i & 1 ? yes[i] : no[i];
    return no;
}
IN_C __m512 in_c_mask_blend_ps(__mmask16 mask, __m512 no, __m512 yes) {
    EACH(16) no[i] = mask >> i & 1 ? yes[i] : no[i];
    return no;
}
IN_C __m128 in_c_maskz_loadu_ps(__mmask8 mask, const void *from) {
    __m128 r = {0};
    EACH(4) if (mask >> i & 1) memcpy((float *)&r + i, (const float *)from + i, sizeof(float));
    return r;
}
IN_C __m256d in_c_maskz_loadu_pd(__mmask8 mask, const void *from) {
    __m256d r = {0};
    EACH(4) if (mask >> i & 1) memcpy((double *)&r + i, (const double *)from + i, sizeof(double));
    return r;
}

/* ---- halves and widths */

IN_C __m256d in_c_half_pd(__m512d a, int high) {
    __m256d r;
    EACH(4) r[i] = a[4 * high + i];
    return r;
}
IN_C __m256 in_c_half_ps(__m512 a, int high) {
    __m256 r;
    EACH(8) r[i] = a[8 * high + i];
    return r;
}
IN_C __m512d in_c_insertf64x4(__m512d a, __m256d b, int high) {
    EACH(4) a[4 * high + i] = b[i];
    return a;
}
IN_C __m512 in_c_insertf32x8(__m512 a, __m256 b, int high) {
    EACH(8) a[8 * high + i] = b[i];
    return a;
}
IN_C __m512d in_c_cvtps_pd(__m256 a) {
    __m512d r;
    EACH(8) r[i] = (double)a[i];
    return r;
}
IN_C __m256 in_c_cvtpd_ps(__m512d a) {
    __m256 r;
    EACH(8) r[i] = (float)a[i];
    return r;
}

/* ---- order */

typedef int in_c_ints __attribute__((vector_size(64)));

IN_C __m512i in_c_set1_epi32(int x) {
    in_c_ints r;
    EACH(16) r[i] = x;
    return (__m512i)r;
}
IN_C __m512i in_c_setr_epi32(int a, int b, int c, int d, int e, int f, int g, int h, int j, int k,
    int l, int m, int n, int o, int p, int q) {
    return (__m512i)(in_c_ints){a, b, c, d, e, f, g, h, j, k, l, m, n, o, p, q};
}
IN_C __m512i in_c_set_epi64(long long h, long long g, long long f, long long e, long long d,
    long long c, long long b, long long a) {
    return (__m512i){a, b, c, d, e, f, g, h};
}
IN_C __m512d in_c_permutex2var_pd(__m512d a, __m512i places, __m512d b) {
    __m512d r;
    EACH(8) r[i] = places[i] & 8 ? b[places[i] & 7] : a[places[i] & 7];
    return r;
}
IN_C __m512 in_c_permutexvar_ps(__m512i places, __m512 a) {
    const in_c_ints from = (in_c_ints)places;
    __m512 r;
    EACH(16) r[i] = a[from[i] & 15];
    return r;
}
IN_C __m512d in_c_shuffle_f64x2(__m512d a, __m512d b, int quarters) {
    __m512d r;
    EACH(8) {
        const int from = 2 * (quarters >> i / 2 * 2 & 3) + i % 2;
        r[i] = i < 4 ? a[from] : b[from];
    }
    return r;
}

#define _mm512_add_epi32(a, b)        ((__m512i)((in_c_ints)(a) + (in_c_ints)(b)))
#define _mm512_mullo_epi32(a, b)      ((__m512i)((in_c_ints)(a) * (in_c_ints)(b)))
#define _mm512_and_si512(a, b)        ((a) & (b))
#define _mm512_add_pd                 in_c_add_pd
#define _mm512_sub_pd                 in_c_sub_pd
#define _mm512_mul_pd                 in_c_mul_pd
#define _mm512_div_ps                 in_c_div_ps
#define _mm512_min_pd                 in_c_min_pd
#define _mm512_max_pd                 in_c_max_pd
#define _mm512_sqrt_pd                in_c_sqrt_pd
#define _mm512_sqrt_ps                in_c_sqrt_ps
#define _mm512_fmadd_pd               in_c_fmadd_pd
#define _mm512_xor_pd                 in_c_xor_pd
#define _mm512_set1_pd                in_c_set1_pd
#define _mm512_set1_ps                in_c_set1_ps
#define _mm512_set1_epi32             in_c_set1_epi32
#define _mm512_setr_epi32             in_c_setr_epi32
#define _mm512_set_epi64              in_c_set_epi64
#define _mm512_loadu_pd               in_c_loadu_pd
#define _mm512_loadu_ps               in_c_loadu_ps
#define _mm512_storeu_pd              in_c_storeu_pd
#define _mm512_storeu_ps              in_c_storeu_ps
#define _mm512_cmp_pd_mask            in_c_cmp_pd_mask
#define _mm512_cmp_ps_mask(a, b, how) in_c_mask_cmp_ps_mask(0xffff, a, b, how)
#define _mm512_mask_cmp_ps_mask       in_c_mask_cmp_ps_mask
#define _mm512_mask_blend_pd          in_c_mask_blend_pd
#define _mm512_mask_blend_ps          in_c_mask_blend_ps
#define _mm_maskz_loadu_ps            in_c_maskz_loadu_ps
#define _mm256_maskz_loadu_pd         in_c_maskz_loadu_pd
#define _mm512_castpd256_pd512(a)     in_c_insertf64x4((__m512d){0}, a, 0)
#define _mm512_castps256_ps512(a)     in_c_insertf32x8((__m512){0}, a, 0)
#define _mm512_castpd512_pd256(a)     in_c_half_pd(a, 0)
#define _mm512_castps512_ps256(a)     in_c_half_ps(a, 0)
#define _mm512_extractf64x4_pd        in_c_half_pd
#define _mm512_extractf32x8_ps        in_c_half_ps
#define _mm512_insertf64x4            in_c_insertf64x4
#define _mm512_insertf32x8            in_c_insertf32x8
#define _mm512_cvtps_pd               in_c_cvtps_pd
#define _mm512_cvtpd_ps               in_c_cvtpd_ps
#define _mm512_unpacklo_pd            in_c_unpacklo_pd
#define _mm512_unpackhi_pd            in_c_unpackhi_pd
#define _mm512_permutex2var_pd        in_c_permutex2var_pd
#define _mm512_permutexvar_ps         in_c_permutexvar_ps
#define _mm512_shuffle_f64x2          in_c_shuffle_f64x2
#endif
