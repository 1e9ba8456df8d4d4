/* mikk_kernel.c: equations 18 and 19 of Mikkelsen 2008 and what a triangle adds at its corners,
 * compiled for each instruction set of the machine's family and chosen at run time. */
#include "core/tangent/tangents.h"
#include "core/face/face.h"
#include <float.h>

/* The arc cosine from the sine, which is exact but for two roundings: the double is within some
 * units of its last place, and the float it is rounded to is that of the exact value for each of
 * the floats there are (tests/unit/core/test_tangents.c has those that lie nearest to a tie). */
CORE_INLINE float acos_of(float x) {
    const double c = (double)x, s = sqrt((1 - c) * (1 + c));
    const float angle = (float)norma_core_angle(s, c);
    return x != x ? x : angle;
}

float norma_core_mikk_acos(float x) { return acos_of(x); }

CORE_INLINE int is_zero_lane(float x) { return !(fabsf(x) > FLT_MIN); }

typedef struct vector {
    float x, y, z;
} vector;

CORE_INLINE float dot_3(vector a, vector b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
CORE_INLINE vector scale_3(float s, vector v) { return (vector){s * v.x, s * v.y, s * v.z}; }
CORE_INLINE vector subtract(vector a, vector b) {
    return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}
CORE_INLINE vector add_3(vector a, vector b) { return (vector){a.x + b.x, a.y + b.y, a.z + b.z}; }
CORE_INLINE vector normalised(vector v) {
    const int zero = is_zero_lane(v.x) & is_zero_lane(v.y) & is_zero_lane(v.z);
    return scale_3(zero ? 1 : 1 / sqrtf(dot_3(v, v)), v);
}
/* Made perpendicular to n, unit. */
CORE_INLINE vector projected(vector v, vector n) {
    return normalised(subtract(v, scale_3(dot_3(n, v), n)));
}
CORE_INLINE vector axis_at(const mikk_lane *v, int lane) {
    return (vector){v[0][lane], v[1][lane], v[2][lane]};
}

CORE_INLINE float one_of(float turn, float first, float second, float third) {
    return turn > 1 ? third : turn > 0 ? second : first;
}
/* Of a triangle's vertices, the one so many after the corner's own. */
CORE_INLINE vector value_after(const mikk_batch *b, const mikk_lane of[3][3], int after, int lane) {
    const vector p[3] = {axis_at(of[after % 3], lane), axis_at(of[(after + 1) % 3], lane),
        axis_at(of[(after + 2) % 3], lane)};
    const float turn = b->turn[lane];
    return (vector){one_of(turn, p[0].x, p[1].x, p[2].x), one_of(turn, p[0].y, p[1].y, p[2].y),
        one_of(turn, p[0].z, p[1].z, p[2].z)};
}

typedef struct derivative {
    float area;
    vector s, t; /* of any length */
} derivative;

CORE_INLINE derivative derive_lane(const mikk_batch *b, int l) {
    const float t21x = b->texcoord[1][0][l] - b->texcoord[0][0][l],
                t21y = b->texcoord[1][1][l] - b->texcoord[0][1][l],
                t31x = b->texcoord[2][0][l] - b->texcoord[0][0][l],
                t31y = b->texcoord[2][1][l] - b->texcoord[0][1][l];
    const vector origin = axis_at(b->position[0], l),
                 d1 = subtract(axis_at(b->position[1], l), origin),
                 d2 = subtract(axis_at(b->position[2], l), origin);
    return (derivative){t21x * t31y - t21y * t31x, subtract(scale_3(t31y, d1), scale_3(t21y, d2)),
        add_3(scale_3(-t31x, d1), scale_3(t21x, d2))};
}

CORE_INLINE void derive(const mikk_batch *restrict b, mikk_derivative *restrict out) {
    for (int l = 0; l < MIKK_LANES; ++l) {
        const derivative d = derive_lane(b, l);
        const int none = is_zero_lane(d.area);
        const float s = sqrtf(dot_3(d.s, d.s)) / fabsf(d.area),
                    t = sqrtf(dot_3(d.t, d.t)) / fabsf(d.area);
        out->area[l] = d.area;
        out->length_s[l] = none ? 0 : s;
        out->length_t[l] = none ? 0 : t;
    }
}

/* Unit, in the sense of the area's sign; zero where it has no length. */
CORE_INLINE vector unit(vector v, float length, float sign) {
    const int zero = is_zero_lane(length);
    const float by = sign / length;
    return (vector){zero ? 0 : by * v.x, zero ? 0 : by * v.y, zero ? 0 : by * v.z};
}

/* Of the angle at the middle one of three positions, seen along n. */
CORE_INLINE float cosine_of(vector previous, vector here, vector next, vector n) {
    const vector in = projected(subtract(previous, here), n),
                 away = projected(subtract(next, here), n);
    const float cosine = dot_3(in, away);
    return cosine > 1 ? 1 : cosine < -1 ? -1 : cosine;
}

CORE_INLINE void put_vector(mikk_lane lanes[3], int l, vector v) {
    lanes[0][l] = v.x;
    lanes[1][l] = v.y;
    lanes[2][l] = v.z;
}

/* Only of triangles that have a texture area. */
CORE_INLINE void contribute(const mikk_batch *restrict b, mikk_corners *restrict out) {
    float cosines[MIKK_LANES];
    for (int l = 0; l < MIKK_LANES; ++l) {
        const derivative d = derive_lane(b, l);
        const float sign = d.area > 0 ? 1.0F : -1.0F, length_s = sqrtf(dot_3(d.s, d.s)),
                    length_t = sqrtf(dot_3(d.t, d.t));
        const vector n = value_after(b, b->normal, 0, l),
                     s = projected(unit(d.s, length_s, sign), n),
                     t = projected(unit(d.t, length_t, sign), n);
        cosines[l] = cosine_of(value_after(b, b->position, 2, l), value_after(b, b->position, 0, l),
            value_after(b, b->position, 1, l), n);
        put_vector(out->s, l, s);
        put_vector(out->t, l, t);
        out->length_s[l] = length_s / fabsf(d.area);
        out->length_t[l] = length_t / fabsf(d.area);
    }
    for (int l = 0; l < MIKK_LANES; ++l) out->angle[l] = acos_of(cosines[l]);
}

/* In which of the six directions along the axes it points: each bit is one. */
CORE_INLINE uint32_t ends_of(vector v) {
    return (v.x > 0.5F ? 1U : 0) | (v.y > 0.5F ? 2U : 0) | (v.z > 0.5F ? 4U : 0) |
           (v.x < -0.5F ? 64U : 0) | (v.y < -0.5F ? 128U : 0) | (v.z < -0.5F ? 256U : 0);
}
CORE_INLINE int is_unit(vector v) { return fabsf(dot_3(v, v) - 1) < 0x1p-10F; /* not NaN */ }

typedef struct directions {
    mikk_lane s[3], t[3]; /* unit, in the triangle's plane */
} directions;

CORE_INLINE void derive_directions(
    const mikk_batch *restrict b, directions *restrict out, mikk_derivative *restrict lengths) {
    for (int l = 0; l < MIKK_LANES; ++l) {
        const derivative d = derive_lane(b, l);
        const int none = is_zero_lane(d.area);
        const float sign = d.area > 0 ? 1.0F : -1.0F, length_s = sqrtf(dot_3(d.s, d.s)),
                    length_t = sqrtf(dot_3(d.t, d.t)), area = fabsf(d.area);
        const vector s = unit(d.s, length_s, sign), t = unit(d.t, length_t, sign);
        put_vector(out->s, l, s);
        put_vector(out->t, l, t);
        lengths->area[l] = d.area;
        lengths->length_s[l] = none ? 0 : length_s / area;
        lengths->length_t[l] = none ? 0 : length_t / area;
    }
}

CORE_INLINE void add_up_corner(const mikk_batch *restrict b, const directions *restrict d,
    int corner, mikk_addends *restrict out) {
    mikk_lane angle;
    for (int l = 0; l < MIKK_LANES; ++l)
        angle[l] =
            cosine_of(axis_at(b->position[(corner + 2) % 3], l), axis_at(b->position[corner], l),
                axis_at(b->position[(corner + 1) % 3], l), axis_at(b->normal[corner], l));
    for (int l = 0; l < MIKK_LANES; ++l) angle[l] = acos_of(angle[l]);
    for (int l = 0; l < MIKK_LANES; ++l) {
        const vector n = axis_at(b->normal[corner], l), s = projected(axis_at(d->s, l), n),
                     t = projected(axis_at(d->t, l), n);
        out->ends[corner][l] =
            is_unit(s) & is_unit(t) ? ends_of(s) | ends_of(t) << 3 : MIKK_ALL_ENDS;
        out->sum[corner][0][l] = angle[l] * s.x;
        out->sum[corner][1][l] = angle[l] * s.y;
        out->sum[corner][2][l] = angle[l] * s.z;
    }
}

CORE_INLINE void add_up_mikk(const mikk_batch *restrict b, mikk_addends *restrict out) {
    directions d;
    derive_directions(b, &d, &out->derivative);
    for (int corner = 0; corner < 3; ++corner) add_up_corner(b, &d, corner, out);
}

static void derive_portable(const mikk_batch *restrict b, mikk_derivative *restrict out) {
    derive(b, out);
}
static void contribute_portable(const mikk_batch *restrict b, mikk_corners *restrict out) {
    contribute(b, out);
}
static void add_up_portable(const mikk_batch *restrict b, mikk_addends *restrict out) {
    add_up_mikk(b, out);
}

#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void derive_avx2(const mikk_batch *restrict b, mikk_derivative *restrict out) {
    derive(b, out);
}
CORE_FOR_AVX2 static void contribute_avx2(
    const mikk_batch *restrict b, mikk_corners *restrict out) {
    contribute(b, out);
}
CORE_FOR_AVX2 static void add_up_avx2(const mikk_batch *restrict b, mikk_addends *restrict out) {
    add_up_mikk(b, out);
}
CORE_FOR_AVX512 static void derive_avx512(
    const mikk_batch *restrict b, mikk_derivative *restrict out) {
    derive(b, out);
}
CORE_FOR_AVX512 static void contribute_avx512(
    const mikk_batch *restrict b, mikk_corners *restrict out) {
    contribute(b, out);
}
CORE_FOR_AVX512 static void add_up_avx512(
    const mikk_batch *restrict b, mikk_addends *restrict out) {
    add_up_mikk(b, out);
}
#endif

const mikk_kernels *norma_core_mikk_kernels(norma_isa isa) {
    static const mikk_kernels kernels[] = {
        {derive_portable, contribute_portable, add_up_portable},
#if defined(CORE_HAS_X86)
        {derive_avx2, contribute_avx2, add_up_avx2},
        {derive_avx512, contribute_avx512, add_up_avx512},
#endif
    };
    return &kernels[norma_core_level(isa)];
}
