/* test_skin.c: skinned positions, normals and tangents against whole numbers, in which the blend,
 * its cofactors and its determinant are exact; against closed forms of screws; against the calls
 * for one matrix. */
#include "check.h"
#include <math.h>

enum { JOINTS = 24, VERTICES = 5000, MOST = 64 };

typedef struct made_skin {
    norma_skin skin;
    float matrices[JOINTS][16], vectors[VERTICES][3];
    uint16_t joints[VERTICES * MOST];
    float weights[VERTICES * MOST];
} made_skin;

static uint32_t random_below(uint64_t *seed, uint32_t count) {
    *seed = *seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)((*seed >> 33) % count);
}

static int random_whole(uint64_t *seed, int most) {
    return (int)random_below(seed, (uint32_t)(2 * most + 1)) - most;
}

/* Whole numbers: matrices up to 50, weights up to 8, which also cancel; some matrices singular. */
static made_skin *make_skin(uint64_t seed, size_t influences) {
    made_skin *m = calloc(1, sizeof *m);
    for (int j = 0; j < JOINTS; ++j)
        for (int i = 0; i < 16; ++i)
            m->matrices[j][i] = (float)random_whole(&seed, j % 4 == 3 && i < 4 ? 0 : 50);
    for (size_t v = 0; v < VERTICES; ++v)
        for (int k = 0; k < 3; ++k) m->vectors[v][k] = (float)random_whole(&seed, 9);
    for (size_t i = 0; i < VERTICES * influences; ++i) {
        m->joints[i] = (uint16_t)random_below(&seed, JOINTS);
        m->weights[i] = (float)random_whole(&seed, 8);
    }
    m->skin = (norma_skin){.matrices = m->matrices[0],
        .joint_count = JOINTS,
        .joints = m->joints,
        .weights = m->weights,
        .influences = influences,
        .vertex_count = VERTICES};
    return m;
}

static norma_vec3_view view_of(float (*vectors)[3]) {
    return (norma_vec3_view){.data = vectors, .count = VERTICES};
}

/* B's three columns and translation, in whole numbers. */
static void whole_blend(const made_skin *m, size_t vertex, long b[4][3]) {
    memset(b, 0, 12 * sizeof b[0][0]);
    for (size_t k = 0; k < m->skin.influences; ++k) {
        const size_t i = vertex * m->skin.influences + k;
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 3; ++r)
                b[c][r] += (long)m->weights[i] * (long)m->matrices[m->joints[i]][4 * c + r];
    }
}

static void whole_cross(const long a[3], const long b[3], long out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

/* sign(det B) cof(B) n; the number: the determinant's sign. */
static int whole_normal(const made_skin *m, size_t vertex, long out[3]) {
    long b[4][3], cof[3][3];
    whole_blend(m, vertex, b);
    for (int c = 0; c < 3; ++c) whole_cross(b[(c + 1) % 3], b[(c + 2) % 3], cof[c]);
    const long det = b[0][0] * cof[0][0] + b[0][1] * cof[0][1] + b[0][2] * cof[0][2];
    const int sign = det < 0 ? -1 : 1;
    for (int r = 0; r < 3; ++r) {
        out[r] = 0;
        for (int c = 0; c < 3; ++c) out[r] += sign * cof[c][r] * (long)m->vectors[vertex][c];
    }
    return det < 0 ? -1 : det > 0;
}

/* sin of the angle between a float vector and a direction. */
static double angle_to(const float a[3], const long b[3]) {
    const double x = (double)a[0], y = (double)a[1], z = (double)a[2], p = (double)b[0],
                 q = (double)b[1], r = (double)b[2];
    const double cross = hypot(hypot(y * r - z * q, z * p - x * r), x * q - y * p);
    return atan2(cross, x * p + y * q + z * r);
}

static void whole_numbers(void **state) {
    (void)state;
    static float positions[VERTICES][3], normals[VERTICES][3];
    static uint8_t reasons[VERTICES];
    const size_t influences[] = {1, 2, 4, 7, 64};
    size_t none = 0, mirrored = 0;
    for (size_t i = 0; i < 5; ++i) {
        made_skin *m = make_skin(i + 1, influences[i]);
        norma_options options = {.reasons = reasons};
        norma_report report;
        assert_ok(
            norma_skin_positions(&m->skin, view_of(m->vectors), NULL, positions[0], VERTICES));
        assert_ok(norma_skin_normals(
            &m->skin, view_of(m->vectors), &options, normals[0], VERTICES, &report));
        size_t cancelled = 0;
        for (size_t v = 0; v < VERTICES; ++v) {
            long b[4][3], n[3];
            whole_blend(m, v, b);
            for (int r = 0; r < 3; ++r) {
                long p = b[3][r];
                for (int c = 0; c < 3; ++c) p += b[c][r] * (long)m->vectors[v][c];
                assert_true(positions[v][r] == (float)p);
            }
            mirrored += whole_normal(m, v, n) < 0;
            if (n[0] == 0 && n[1] == 0 && n[2] == 0) {
                ++cancelled;
                assert_int_equal(reasons[v], NORMA_REASON_CANCELLED);
                assert_true(normals[v][0] == 0 && normals[v][1] == 0 && normals[v][2] == 0);
                continue;
            }
            assert_int_equal(reasons[v], NORMA_REASON_NONE);
            assert_true(angle_to(normals[v], n) < 2e-7);
        }
        assert_int_equal(report.cancelled.count, cancelled);
        none += cancelled;
        free(m);
    }
    assert_true(none > 100 && mirrored > 1000);
}

/* A float of any sign, of 24 random bits, below 2^exponent. */
static float random_float(uint64_t *seed, int exponent) {
    return (float)ldexp((double)random_below(seed, 1 << 24) - (1 << 23), exponent - 23);
}

enum { SOME = 150 };

/* Skins of every number of influences, width of joint numbers, scale and layout. */
typedef struct some_skin {
    norma_skin skin;
    float matrices[JOINTS][16], weights[SOME * 9], floats[SOME][4];
    double doubles[SOME][3];
    unsigned char joints[SOME * 9 * 4];
    norma_vec3_view in;
} some_skin;

static void make_some(some_skin *m, uint64_t seed) {
    static const size_t SIZES[] = {1, 2, 4};
    const int scale = (int)random_below(&seed, 81) - 40;
    const size_t influences = 1 + random_below(&seed, 9), size = SIZES[random_below(&seed, 3)];
    m->skin = (norma_skin){m->matrices[0], JOINTS, m->joints, size, m->weights, influences,
        1 + random_below(&seed, SOME), NORMA_BLEND_LINEAR};
    for (int j = 0; j < JOINTS; ++j) /* the last is huge */
        for (int i = 0; i < 16; ++i)
            m->matrices[j][i] = random_float(&seed, j == JOINTS - 1 ? scale + 40 : scale);
    for (size_t i = 0; i < m->skin.vertex_count * influences; ++i) {
        const uint32_t kind = random_below(&seed, 8),
                       joint = random_below(&seed, kind ? JOINTS - 1 : JOINTS);
        m->weights[i] = kind == 1 ? 0 : random_float(&seed, (int)random_below(&seed, 3));
        for (size_t b = 0; b < size; ++b) m->joints[i * size + b] = 0;
        if (size == 1) m->joints[i] = (unsigned char)joint;
        if (size == 2) memcpy(m->joints + 2 * i, &(uint16_t){(uint16_t)joint}, 2);
        if (size == 4) memcpy(m->joints + 4 * i, &joint, 4);
    }
    for (size_t v = 0; v < SOME; ++v)
        for (int k = 0; k < 3; ++k) {
            m->floats[v][k] = random_float(&seed, 0);
            m->doubles[v][k] = (double)m->floats[v][k];
        }
    m->in = (norma_vec3_view){m->floats, SOME, sizeof m->floats[0], NORMA_FORMAT_FLOAT};
    if (seed % 2) m->in = (norma_vec3_view){m->doubles, SOME, 0, NORMA_FORMAT_DOUBLE};
}

static size_t joint_of(const some_skin *m, size_t i) {
    uint32_t four = 0;
    memcpy(&four, m->joints + i * m->skin.joint_size, m->skin.joint_size);
    return four;
}

/* B by columns; what its entries were summed from, at most. */
static long double long_matrix(const some_skin *m, size_t v, long double b[3][3]) {
    long double size = 0;
    memset(b, 0, 9 * sizeof b[0][0]);
    for (size_t k = 0, i = v * m->skin.influences; k < m->skin.influences; ++k, ++i)
        for (int c = 0; c < 3; ++c)
            for (int r = 0; r < 3; ++r) {
                const long double part = (long double)m->weights[i] *
                                         (long double)m->matrices[joint_of(m, i)][4 * c + r];
                b[c][r] += part;
                size += fabsl(part);
            }
    return size;
}

/* sign(det B) cof(B) n as norma.h defines it; 0 where 64 bits of a mantissa are too few. */
static int long_normal(const some_skin *m, size_t v, long double out[3]) {
    long double b[3][3], size = long_matrix(m, v, b), length = 0;
    long double det = 0;
    for (int r = 0; r < 3; ++r) {
        const int s = (r + 1) % 3, t = (r + 2) % 3;
        det += b[0][r] * (b[1][s] * b[2][t] - b[1][t] * b[2][s]);
        out[r] = 0;
        for (int c = 0; c < 3; ++c) {
            const int d = (c + 1) % 3, e = (c + 2) % 3;
            out[r] += (b[d][s] * b[e][t] - b[d][t] * b[e][s]) * (long double)m->floats[v][c];
        }
    }
    for (int r = 0; r < 3; ++r) out[r] *= det < 0 ? -1 : 1;
    length = hypotl(hypotl(out[0], out[1]), out[2]);
    for (int r = 0; r < 3; ++r) out[r] /= length;
    return length > 0x1p-30L * size * size && fabsl(det) > 0x1p-40L * size * size * size;
}

static void by_definition(void **state) {
    (void)state;
    static some_skin m;
    static float first[SOME][3], again[SOME][3], moved[SOME][3];
    size_t held = 0;
    for (uint64_t seed = 1; seed < 600; ++seed) {
        make_some(&m, seed);
        const size_t count = m.skin.vertex_count;
        const norma_options portable = {.isa = NORMA_ISA_PORTABLE};
        assert_ok(norma_skin_normals(&m.skin, m.in, &portable, first[0], count, NULL));
        assert_ok(norma_skin_positions(&m.skin, m.in, &portable, moved[0], count));
        for (size_t v = 0; v < count; ++v) {
            long double n[3], square = 0;
            if (!long_normal(&m, v, n)) continue;
            for (int k = 0; k < 3; ++k) {
                const long double apart = (long double)first[v][k] - n[k];
                square += apart * apart;
            }
            assert_true(square < 4e-14L);
            ++held;
        }
        for (int isa = NORMA_ISA_BEST; isa <= NORMA_ISA_AVX512; ++isa) {
            const norma_options options = {.isa = (norma_isa)isa};
            const norma_result result =
                norma_skin_normals(&m.skin, m.in, &options, again[0], count, NULL);
            if (result) continue; /* this machine has it not */
            assert_memory_equal(first, again, count * sizeof *first);
            assert_ok(norma_skin_positions(&m.skin, m.in, &options, again[0], count));
            assert_memory_equal(moved, again, count * sizeof *moved);
        }
    }
    assert_true(held > 30000);
}

/* B and B t; what entries of B were summed from, at most. */
static long double long_blend(
    const some_skin *m, size_t v, const float in[4], long double b[3][3], long double t[3]) {
    const long double size = long_matrix(m, v, b);
    for (int r = 0; r < 3; ++r)
        t[r] = b[0][r] * (long double)in[0] + b[1][r] * (long double)in[1] +
               b[2][r] * (long double)in[2];
    return size;
}

/* B t made perpendicular to n, unit, and the sign of det B; 0 where 64 bits of a mantissa are too
 * few. */
static int long_tangent(const some_skin *m, size_t v, const float in[4], long double out[4]) {
    long double b[3][3], t[3], n[3], det = 0, along = 0, left = 0;
    const long double size = long_blend(m, v, in, b, t);
    for (int r = 0; r < 3; ++r) {
        const int q = (r + 1) % 3, p = (r + 2) % 3;
        det += b[0][r] * (b[1][q] * b[2][p] - b[1][p] * b[2][q]);
        n[r] = (long double)m->floats[v][r];
    }
    const long double n_length = hypotl(hypotl(n[0], n[1]), n[2]),
                      t_length = hypotl(hypotl(t[0], t[1]), t[2]);
    for (int r = 0; r < 3; ++r) along += n[r] / n_length * (t[r] / t_length);
    for (int r = 0; r < 3; ++r) {
        out[r] = t[r] / t_length - along * (n[r] / n_length);
        left += out[r] * out[r];
    }
    for (int r = 0; r < 3; ++r) out[r] /= sqrtl(left);
    out[3] = det < 0 ? -(long double)in[3] : (long double)in[3];
    return t_length > 0x1p-20L * size && left > 0x1p-20L &&
           fabsl(det) > 0x1p-40L * size * size * size;
}

/* Whatever is given, a tangent is unit and perpendicular to the normal. */
static void assert_tangent(const float t[4], const float n[3]) {
    double square = 0, along = 0, length = 0;
    for (int k = 0; k < 3; ++k) {
        square += (double)t[k] * (double)t[k];
        along += (double)t[k] * (double)n[k];
        length += (double)n[k] * (double)n[k];
    }
    assert_true(fabs(square - 1) < 1e-6 && fabs(along) <= 1e-6 * sqrt(length));
}

/* Of every skin of by_definition, a few tangents are zero, not finite, or along the normal. */
static void tangents_by_definition(void **state) {
    (void)state;
    static some_skin m;
    static float in[SOME][4], first[SOME][4], again[SOME][4], wide[SOME][6];
    size_t held = 0, turned = 0;
    for (uint64_t seed = 1; seed < 300; ++seed) {
        make_some(&m, seed);
        uint64_t random = seed;
        const size_t count = m.skin.vertex_count;
        for (size_t v = 0; v < count; ++v) {
            const uint32_t kind = random_below(&random, 64);
            for (int k = 0; k < 3; ++k) in[v][k] = kind == 1 ? 0 : random_float(&random, 0);
            in[v][3] = v % 3 ? 1 : -1;
            if (kind == 2) in[v][1] = NAN;
            if (kind == 3) memset(m.floats[v], 0, sizeof m.floats[v]);
            if (kind == 4) { /* up to rounding */
                long double b[3][3], t[3];
                (void)long_blend(&m, v, in[v], b, t);
                const long double length = hypotl(hypotl(t[0], t[1]), t[2]);
                for (int k = 0; k < 3; ++k)
                    m.floats[v][k] = length > 0 ? (float)(t[k] / length) : 0;
            }
        }
        const norma_vec3_view normals = {m.floats, SOME, sizeof m.floats[0], NORMA_FORMAT_FLOAT};
        const norma_options portable = {.isa = NORMA_ISA_PORTABLE}, strided = {.normal_stride = 24};
        assert_ok(norma_skin_tangents(&m.skin, in[0], normals, &portable, first[0], count));
        for (size_t v = 0; v < count; ++v) {
            long double t[4], square = 0;
            assert_tangent(first[v], m.floats[v]);
            if (!long_tangent(&m, v, in[v], t)) continue;
            for (int k = 0; k < 3; ++k) {
                const long double apart = (long double)first[v][k] - t[k];
                square += apart * apart;
            }
            assert_true(square < 4e-14L && (long double)first[v][3] == t[3]);
            turned += first[v][3] != in[v][3];
            ++held;
        }
        for (int isa = NORMA_ISA_BEST; isa <= NORMA_ISA_AVX512; ++isa) {
            const norma_options options = {.isa = (norma_isa)isa};
            const norma_result result =
                norma_skin_tangents(&m.skin, in[0], normals, &options, again[0], count);
            if (result) continue; /* this machine has it not */
            assert_memory_equal(first, again, count * sizeof *first);
        }
        for (size_t v = 0; v < count; ++v) /* lengths whose squares are no ordinary numbers */
            for (int k = 0; k < 3; ++k) m.doubles[v][k] = ldexp((double)m.floats[v][k], -525);
        const norma_vec3_view tiny = {m.doubles, SOME, 0, NORMA_FORMAT_DOUBLE};
        assert_ok(norma_skin_tangents(&m.skin, in[0], tiny, NULL, again[0], count));
        assert_memory_equal(first, again, count * sizeof *first);
        assert_ok(norma_skin_tangents(&m.skin, in[0], normals, &strided, wide[0], count));
        for (size_t v = 0; v < count; ++v) assert_memory_equal(wide[v], first[v], sizeof first[v]);
    }
    assert_true(held > 15000 && turned > 5000);
}

/* A large joint's part that is taken away again after a small joint's leaves the small one: doubles
 * have rounded most of it off by then. */
static void what_is_left_of_a_difference(void **state) {
    (void)state;
    float out[3], tangent[4] = {1, 2, 3, 1};
    size_t mirrored = 0;
    made_skin *m = make_skin(17, 3);
    m->skin.vertex_count = 1;
    for (uint64_t seed = 1; seed < 400; ++seed) {
        uint64_t random = seed;
        for (int i = 0; i < 11; ++i) m->matrices[0][i] = (float)random_whole(&random, 1000) / 7;
        const uint16_t small = (uint16_t)(1 + random_below(&random, JOINTS - 1));
        const made_skin *alone = m;
        long n[3];
        m->joints[0] = small, m->weights[0] = 1;
        m->skin.influences = 1;
        const int sign = whole_normal(alone, 0, n);
        mirrored += sign < 0;
        m->skin.influences = 3;
        m->joints[0] = m->joints[2] = 0;
        m->joints[1] = small;
        m->weights[0] = 0x1.234567p30F, m->weights[1] = 0x1p-20F, m->weights[2] = -m->weights[0];
        assert_ok(norma_skin_normals(&m->skin, view_of(m->vectors), NULL, out, 1, NULL));
        tangent[3] = 1;
        assert_ok(norma_skin_tangents(&m->skin, tangent, view_of(m->vectors), NULL, tangent, 1));
        assert_true(tangent[3] == (sign < 0 ? -1 : 1));
        if (n[0] || n[1] || n[2])
            assert_true(angle_to(out, n) < 2e-7);
        else
            assert_true(out[0] == 0 && out[1] == 0 && out[2] == 0);
    }
    assert_true(mirrored > 50);
    free(m);
}

/* Sums of 64 products whose rounding leaves up to fifty doubles one after the other, none of which
 * overlap: found by a search. Each is a power of two, its exponent plus 300, with the sign of the
 * product; all but 2^-35 of it cancels, so that doubles do not decide. */
static void sums_of_many_parts(void **state) {
    (void)state;
    static const int TERMS[MOST] = {540, 505, 157, -62, -437, 121, -70, -144, -98, 108, 362, -113,
        -67, -60, -68, -307, -82, 117, -79, 170, -80, -114, 125, 198, -187, 122, 133, -221, -135,
        245, -165, 231, -274, -167, 174, 261, 180, -354, -267, 411, -296, 210, -473, -322, -223,
        -318, -324, 233, -287, 432, 347, 376, 276, -341, 369, 395, -375, -389, -420, -425, -435,
        448, 455, -540};
    float matrices[MOST][16] = {{0}}, weights[MOST], normal[3] = {1, 2, -2}, out[3];
    uint16_t joints[MOST];
    for (int k = 0; k < MOST; ++k) {
        const int exponent = abs(TERMS[k]) - 300, half = exponent / 2;
        joints[k] = (uint16_t)k;
        weights[k] = (float)ldexp(TERMS[k] < 0 ? -1 : 1, exponent - half);
        for (int i = 0; i < 3; ++i) matrices[k][5 * i] = (float)ldexp(1, half);
    }
    const norma_skin skin = {.matrices = matrices[0],
        .joint_count = MOST,
        .joints = joints,
        .weights = weights,
        .influences = MOST,
        .vertex_count = 1};
    const norma_vec3_view in = {.data = normal, .count = 1};
    norma_report report;
    assert_ok(norma_skin_normals(&skin, in, NULL, out, 1, &report));
    assert_int_equal(report.cancelled.count, 0);
    for (int i = 0; i < 3; ++i) assert_true(fabs((double)out[i] - (double)normal[i] / 3) < 1e-7);
}

/* One joint is one matrix. */
static void one_joint_is_a_matrix(void **state) {
    (void)state;
    static float skinned[VERTICES][3], moved[VERTICES][3], tangents[VERTICES][4],
        turned[VERTICES][4], other[VERTICES][4];
    made_skin *m = make_skin(9, 1);
    for (size_t v = 0; v < VERTICES; ++v) {
        m->joints[v] = 2;
        m->weights[v] = 1;
        for (int k = 0; k < 3; ++k) tangents[v][k] = m->vectors[VERTICES - 1 - v][k];
        tangents[v][3] = v % 2 ? 1 : -1;
    }
    float matrix[9];
    assert_ok(norma_normal_matrix(m->matrices[2], NORMA_WINDING_REVERSED, matrix, NULL));
    for (int blend = 0; blend < 2; ++blend) {
        m->skin.blend = blend ? NORMA_BLEND_DUAL_QUATERNION : NORMA_BLEND_LINEAR;
        assert_ok(norma_transform_normals(matrix, view_of(m->vectors), moved[0], 0, VERTICES));
        assert_ok(
            norma_skin_normals(&m->skin, view_of(m->vectors), NULL, skinned[0], VERTICES, NULL));
        for (size_t v = 0; v < VERTICES; ++v)
            for (int k = 0; k < 3; ++k)
                assert_true(fabs((double)(skinned[v][k] - moved[v][k])) < 2e-7);
        for (size_t v = 7; v < VERTICES; v += 50) { /* along the tangent, up to rounding */
            const float *t = tangents[v], *b = m->matrices[2];
            double along[3], square = 0;
            for (int r = 0; r < 3; ++r) {
                along[r] = (double)(b[r] * t[0] + b[4 + r] * t[1] + b[8 + r] * t[2]);
                square += along[r] * along[r];
            }
            for (int r = 0; r < 3 && square > 0; ++r)
                skinned[v][r] = (float)(along[r] / sqrt(square));
        }
        assert_ok(norma_skin_tangents(
            &m->skin, tangents[0], view_of(skinned), NULL, turned[0], VERTICES));
        assert_ok(norma_transform_tangents(
            m->matrices[2], tangents[0], 0, view_of(skinned), VERTICES, other[0], 0, VERTICES));
        for (size_t v = 0; v < VERTICES; ++v) {
            const float *t = tangents[v], *a = turned[v], *b = other[v];
            if (t[0] == 0 && t[1] == 0 && t[2] == 0) continue;
            assert_true(a[3] == b[3]);
            for (int k = 0; k < 3; ++k) assert_true(fabs((double)(a[k] - b[k])) < 1e-4);
        }
        assert_ok(norma_skin_positions(&m->skin, view_of(m->vectors), NULL, skinned[0], VERTICES));
        assert_ok(
            norma_transform_positions((double[16]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1},
                view_of(m->vectors), moved[0], 0, VERTICES));
        for (size_t v = 0; v < VERTICES; ++v) {
            long b[4][3];
            whole_blend(m, v, b);
            for (int r = 0; r < 3; ++r) {
                long p = b[3][r];
                for (int c = 0; c < 3; ++c) p += b[c][r] * (long)m->vectors[v][c];
                assert_true(fabs((double)skinned[v][r] - (double)p) < 2e-3);
            }
        }
    }
    free(m);
}

static void make_turn(double degrees, double z, double scale, float m[16]) {
    const double a = degrees / 57.29577951308232;
    const float c = (float)(scale * cos(a)), s = (float)(scale * sin(a));
    const float turn[16] = {c, s, 0, 0, -s, c, 0, 0, 0, 0, (float)scale, 0, 0, 0, (float)z, 1};
    memcpy(m, turn, sizeof turn);
}

/* Half of a turn about z and half of none, climbing by 4: half the turn, climbing by 2, without the
 * shrinking of the linear blend. Stretches of 1 and 3 become 2. */
static void half_a_screw(void **state) {
    (void)state;
    float matrices[2][16], out[3];
    const uint32_t joints[] = {0, 1};
    const float weights[] = {0.5F, 0.5F}, point[] = {1, 0, 1};
    const norma_vec3_view in = {.data = point, .count = 1};
    const double angles[] = {90, 170, -120};
    for (int i = 0; i < 3; ++i) {
        make_turn(0, 0, 1, matrices[0]);
        make_turn(angles[i], 4, 3, matrices[1]);
        norma_skin skin = {matrices[0], 2, joints, 4, weights, 2, 1, NORMA_BLEND_DUAL_QUATERNION};
        const double half = angles[i] / 2 / 57.29577951308232;
        assert_ok(norma_skin_positions(&skin, in, NULL, out, 1));
        assert_true(fabs((double)out[0] - 2 * cos(half)) < 1e-6);
        assert_true(fabs((double)out[1] - 2 * sin(half)) < 1e-6);
        assert_true(fabs((double)out[2] - 4) < 1e-6);
        assert_ok(norma_skin_normals(&skin, in, NULL, out, 1, NULL));
        assert_true(fabs((double)out[0] - cos(half) / sqrt(2)) < 1e-7);
        assert_true(fabs((double)out[1] - sin(half) / sqrt(2)) < 1e-7);
        assert_true(fabs((double)out[2] - 1 / sqrt(2)) < 1e-7);
    }
    /* A mirrored joint: minus a rotation, minus its stretch. */
    make_turn(0, 0, 1, matrices[0]);
    for (int i = 0; i < 3; ++i) matrices[0][5 * i] = -1;
    memcpy(matrices[1], matrices[0], sizeof matrices[0]);
    norma_skin skin = {matrices[0], 2, joints, 4, weights, 2, 1, NORMA_BLEND_DUAL_QUATERNION};
    assert_ok(norma_skin_positions(&skin, in, NULL, out, 1));
    assert_true(out[0] == -1 && out[1] == 0 && out[2] == -1);
}

static void same_bits(void **state) {
    (void)state;
    static float first[VERTICES][3], again[VERTICES][3], wide[VERTICES][5];
    for (int blend = 0; blend < 2; ++blend) {
        made_skin *m = make_skin(5, 4);
        m->skin.blend = blend ? NORMA_BLEND_DUAL_QUATERNION : NORMA_BLEND_LINEAR;
        const norma_options portable = {.isa = NORMA_ISA_PORTABLE}, threads = {.threads = 3},
                            strided = {.normal_stride = 20, .threads = NORMA_ALL_THREADS};
        const norma_vec3_view in = view_of(m->vectors);
        assert_ok(norma_skin_normals(&m->skin, in, &portable, first[0], VERTICES, NULL));
        assert_ok(norma_skin_normals(&m->skin, in, &threads, again[0], VERTICES, NULL));
        assert_memory_equal(first, again, sizeof first);
        memset(wide, 1, sizeof wide);
        assert_ok(norma_skin_normals(&m->skin, in, &strided, wide[0], VERTICES, NULL));
        for (size_t v = 0; v < VERTICES; ++v) {
            assert_memory_equal(wide[v], first[v], 12);
            assert_memory_equal(wide[v] + 3, "\1\1\1\1\1\1\1\1", 8);
        }
        assert_ok(norma_skin_normals(
            &m->skin, in, &threads, m->vectors[0], VERTICES, NULL)); /* in place */
        assert_memory_equal(m->vectors, first, sizeof first);
        free(m);
    }
}

static void refused(void **state) {
    (void)state;
    static float out[VERTICES][3];
    made_skin *m = make_skin(3, 4);
    norma_fault fault;
    const norma_vec3_view in = view_of(m->vectors);
    const norma_options nearest = {.fallback = NORMA_FALLBACK_NEAREST};
    norma_vec3_view shorter = in;
    --shorter.count;
    out[0][0] = 7;
    m->joints[4001] = JOINTS;
    assert_int_equal(norma_skin_positions(&m->skin, in, NULL, out[0], VERTICES), NORMA_ERROR_INDEX);
    assert_int_equal(norma_find_skin_fault(&m->skin, NULL, &fault), NORMA_ERROR_INDEX);
    assert_string_equal(fault.argument, "skin->joints");
    assert_int_equal(fault.index, 4001);
    m->joints[4001] = 0;
    m->weights[17] = NAN;
    assert_int_equal(
        norma_skin_normals(&m->skin, in, NULL, out[0], VERTICES, NULL), NORMA_ERROR_ARGUMENT);
    norma_find_skin_fault(&m->skin, NULL, &fault);
    assert_string_equal(fault.argument, "skin->weights");
    m->weights[17] = 0;
    m->matrices[5][6] = INFINITY;
    assert_int_equal(
        norma_skin_normals(&m->skin, in, NULL, out[0], VERTICES, NULL), NORMA_ERROR_ARGUMENT);
    norma_find_skin_fault(&m->skin, NULL, &fault);
    assert_string_equal(fault.argument, "skin->matrices");
    assert_int_equal(fault.index, 5);
    for (size_t i = 0; i < (size_t)4 * VERTICES; ++i) /* who weighs nothing is not read */
        if (m->joints[i] == 5) m->weights[i] = 0;
    assert_true(out[0][0] == 7);
    assert_int_equal(
        norma_skin_positions(&m->skin, in, NULL, out[0], VERTICES - 1), NORMA_ERROR_CAPACITY);
    assert_int_equal(
        norma_skin_positions(&m->skin, shorter, NULL, out[0], VERTICES), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_skin_normals(&m->skin, in, &nearest, out[0], VERTICES, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_skin_normals(NULL, in, NULL, out[0], VERTICES, NULL), NORMA_ERROR_ARGUMENT);
    assert_int_equal(
        norma_skin_tangents(&m->skin, NULL, in, NULL, out[0], VERTICES), NORMA_ERROR_ARGUMENT);
    assert_true(out[0][0] == 7);
    m->skin.influences = 65;
    assert_int_equal(
        norma_skin_positions(&m->skin, in, NULL, out[0], VERTICES), NORMA_ERROR_ARGUMENT);
    m->skin.influences = 4;
    assert_ok(norma_skin_positions(&m->skin, in, NULL, out[0], VERTICES));
    for (size_t v = 0; v < VERTICES; ++v) assert_true(isfinite(out[v][0] + out[v][1] + out[v][2]));
    m->vectors[3][1] = NAN;
    norma_report report;
    const norma_options given = {.fallback = NORMA_FALLBACK_GIVEN, .fallback_normal = {0, 0, 1}};
    assert_ok(norma_skin_normals(&m->skin, in, &given, out[0], VERTICES, &report));
    assert_true(report.non_finite.count == 1 && report.non_finite.first == 3 && out[3][2] == 1);
    free(m);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(whole_numbers),
        cmocka_unit_test(by_definition), cmocka_unit_test(tangents_by_definition),
        cmocka_unit_test(what_is_left_of_a_difference), cmocka_unit_test(sums_of_many_parts),
        cmocka_unit_test(one_joint_is_a_matrix), cmocka_unit_test(half_a_screw),
        cmocka_unit_test(same_bits), cmocka_unit_test(refused)};
    return cmocka_run_group_tests_name("skin", tests, NULL, NULL);
}
