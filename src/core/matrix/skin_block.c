/* skin_block.c: skinned vertices, 32 side by side: their joints' rows are weighted and added up one
 * after the other, turned over, and finished in lanes. A vertex whose normal doubles do not decide
 * is done again in exact arithmetic. Every instruction set gives the same bits. */
#include "core/matrix/matrix.h"
#include "core/face/eight_vectors.h"

/* ---- the normal of a skinned vertex, and whether its matrix mirrors, in exact arithmetic
 * (core/face/face_exact.c), with the blend's entries as sums that have not been rounded (Shewchuk
 * 1997, Grow-Expansion): for the vertices that doubles do not decide. */

enum { LARGEST_SUM = 16 }; /* doubles of a sum that has not been rounded: see join_parts */

/* A sum of doubles that has not been rounded: parts that do not overlap, the smallest first. */
typedef struct long_sum {
    double part[LARGEST_SUM];
    int count;
} long_sum;

/* Makes the parts as few as they can be: each is what the ones above it leave, rounded once
 * (Shewchuk 1997, Compress, its first pass). So they lie at least 52 bits apart, and sums of
 * products of floats, from 2^-298 to 2^262, have at most eleven. */
static void join_parts(long_sum *s) {
    double joined[LARGEST_SUM], rest = 0.0;
    int first = LARGEST_SUM;
    for (int i = s->count; i-- > 0;) {
        const double sum = rest + s->part[i], left = s->part[i] - (sum - rest);
        if (left != 0.0) joined[--first] = sum;
        rest = left != 0.0 ? left : sum;
    }
    if (rest != 0.0) joined[--first] = rest;
    s->count = LARGEST_SUM - first;
    memcpy(s->part, joined + first, (size_t)s->count * sizeof *joined);
}

/* Adds a number and keeps what each addition rounds off; parts of zero are dropped. Small parts may
 * stay beside each other, as many as there were additions: they are joined where room ends. */
static void add_exactly(long_sum *s, double number) {
    int kept = 0;
    if (s->count == LARGEST_SUM) join_parts(s);
    for (int i = 0; i < s->count; ++i) {
        const double sum = number + s->part[i], other = sum - number;
        const double rest = (number - (sum - other)) + (s->part[i] - other);
        number = sum;
        if (rest != 0.0) s->part[kept++] = rest;
    }
    if (number != 0.0) s->part[kept++] = number;
    s->count = kept;
}

static void blend_exactly(const skin_stream *s, size_t vertex, long_sum b[9]) {
    const size_t first = vertex * s->influences;
    for (int i = 0; i < 9; ++i) b[i].count = 0;
    for (size_t k = 0; k < s->influences; ++k) {
        const double weight = (double)s->skin->weights[first + k];
        const double *row = s->rows[norma_index_read(s->joints, s->joint_size, first + k)];
        for (int i = 0; i < 9; ++i) /* the product of two floats is exact in a double */
            if (weight != 0.0) add_exactly(&b[i], weight * row[i]);
    }
    for (int i = 0; i < 9; ++i) join_parts(&b[i]);
}

/* Adds a b c, or takes it away. */
static void add_products(
    exact_sum *sum, const long_sum *a, const long_sum *b, const double *c, int c_count, int minus) {
    for (int i = 0; i < a->count; ++i)
        for (int j = 0; j < b->count; ++j)
            for (int k = 0; k < c_count; ++k)
                norma_exact_add(sum, (const double[]){a->part[i], b->part[j], c[k]}, 3, minus);
}

/* Adds factor times entry row of b[first] x b[second], columns of three sums. */
static void add_exact_cross(exact_sum *sum, const long_sum *b, int first, int second, int row,
    const double *factor, int count) {
    const int y = (row + 1) % 3, z = (row + 2) % 3;
    add_products(sum, &b[3 * first + y], &b[3 * second + z], factor, count, 0);
    add_products(sum, &b[3 * first + z], &b[3 * second + y], factor, count, 1);
}

/* Row row of cof(B) n. */
static scaled_number exact_component(const long_sum b[9], const double n[3], int row) {
    exact_sum sum;
    norma_exact_clear(&sum);
    for (int c = 0; c < 3; ++c)
        if (n[c] != 0.0) add_exact_cross(&sum, b, (c + 1) % 3, (c + 2) % 3, row, &n[c], 1);
    return norma_exact_round(&sum);
}

static int has_negative_determinant(const long_sum b[9]) {
    exact_sum sum;
    norma_exact_clear(&sum);
    for (int row = 0; row < 3; ++row)
        add_exact_cross(&sum, b, 1, 2, row, b[row].part, b[row].count);
    return norma_exact_round(&sum).mantissa < 0.0;
}

/* A multiple of sign(det B) cof(B) n; 0 where that is exactly zero. */
static int exact_normal(const skin_stream *s, size_t vertex, const double n[3], double out[3]) {
    long_sum b[9];
    scaled_number v[3];
    blend_exactly(s, vertex, b);
    int most = INT32_MIN;
    for (int r = 0; r < 3; ++r) {
        v[r] = exact_component(b, n, r);
        if (v[r].mantissa != 0.0 && v[r].exponent > most) most = v[r].exponent;
    }
    if (most == INT32_MIN) return 0;
    const double sign = has_negative_determinant(b) ? -1.0 : 1.0;
    for (int r = 0; r < 3; ++r)
        out[r] = v[r].mantissa == 0.0 || v[r].exponent - most < -200
                     ? 0.0
                     : sign * ldexp(v[r].mantissa, v[r].exponent - most);
    return 1;
}

static int exactly_mirrors(const skin_stream *s, size_t vertex) {
    long_sum b[9];
    blend_exactly(s, vertex, b);
    return has_negative_determinant(b);
}

/* ---- skins by dual quaternions: Kavan, Collins, Zara, O'Sullivan 2008, Geometric Skinning with
 * Approximate Dual Quaternion Blending, eq. 18. Each joint is a rotation after a stretch, M = R S,
 * with S symmetric (the right polar factor, by singular values). Where M mirrors, both are negated,
 * so that R is a rotation (Shoemake, Duff 1992). Stretches are blended linearly, rotations and
 * translations on the sphere. */

/* ---- one joint */

/* A unit vector perpendicular to the unit vector a: along the axis that a leans on least. */
static void any_perpendicular_to(const double a[3], double out[3]) {
    const double x = fabs(a[0]), y = fabs(a[1]), z = fabs(a[2]);
    const double axis[3] = {
        x <= y && x <= z, !(x <= y && x <= z) && y <= z, !(x <= y && x <= z) && !(y <= z)};
    norma_core_cross(a, axis, out);
    norma_core_normalise(out, out);
}

/* The columns of U, unit: M v / s, largest first; what a singular matrix leaves open is made
 * perpendicular to them. */
static void left_vectors(
    const double m[9], const double v[9], const double values[3], int mirrored, double u[9]) {
    int order[3] = {0, 1, 2};
    for (int i = 0; i < 2; ++i)
        for (int k = 0; k < 2; ++k)
            if (values[order[k]] < values[order[k + 1]]) {
                const int swapped = order[k];
                order[k] = order[k + 1];
                order[k + 1] = swapped;
            }
    double *first = u + 3 * order[0], *second = u + 3 * order[1], *third = u + 3 * order[2];
    for (int i = 0; i < 3; ++i)
        for (int r = 0; r < 3; ++r)
            u[3 * i + r] = m[r] * v[3 * i] + m[3 + r] * v[3 * i + 1] + m[6 + r] * v[3 * i + 2];
    const double least = 0x1p-40 * values[order[0]];
    if (values[order[0]] > 0.0)
        norma_core_normalise(first, first);
    else
        memcpy(first, v + 3 * order[0], 3 * sizeof *first);
    if (values[order[1]] > least)
        norma_core_normalise(second, second);
    else
        any_perpendicular_to(first, second);
    /* The third by the first two, so that U turns as V does, or mirrors. */
    double turn[3];
    norma_core_cross(v + 3 * order[0], v + 3 * order[1], turn);
    const double side = norma_core_dot(turn, v + 3 * order[2]) < 0.0 ? -1.0 : 1.0;
    norma_core_cross(first, second, third);
    for (int r = 0; r < 3; ++r) third[r] *= mirrored ? -side : side;
    norma_core_normalise(third, third);
}

static void quaternion_of(const double r[9], double q[4]) {
    const double trace = r[0] + r[4] + r[8];
    if (trace > 0.0) {
        const double s = 2.0 * sqrt(trace + 1.0);
        q[3] = s / 4.0;
        q[0] = (r[5] - r[7]) / s;
        q[1] = (r[6] - r[2]) / s;
        q[2] = (r[1] - r[3]) / s;
        return;
    }
    const int i = r[0] >= r[4] && r[0] >= r[8] ? 0 : (r[4] >= r[8] ? 1 : 2), j = (i + 1) % 3,
              k = (i + 2) % 3;
    const double s = 2.0 * sqrt(1.0 + r[4 * i] - r[4 * j] - r[4 * k]);
    q[i] = s / 4.0;
    q[j] = (r[3 * i + j] + r[3 * j + i]) / s;
    q[k] = (r[3 * i + k] + r[3 * k + i]) / s;
    q[3] = (r[3 * j + k] - r[3 * k + j]) / s;
}

static void split_stretch(const double m[9], double rotation[9], double stretch[9]) {
    double scaled[9], values[3], v[9], u[9], s[9], largest = 0.0;
    int exponent = 0;
    for (int i = 0; i < 9; ++i) largest = fmax(largest, fabs(m[i]));
    if (largest > 0.0) (void)frexp(largest, &exponent);
    for (int i = 0; i < 9; ++i) scaled[i] = ldexp(m[i], 1 - exponent);
    const int mirrored = norma_matrix_mirrors(m);
    norma_singular_values(scaled, values, v);
    left_vectors(scaled, v, values, mirrored, u);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
            const double entry = u[r] * v[c] + u[3 + r] * v[3 + c] + u[6 + r] * v[6 + c];
            rotation[3 * c + r] = mirrored ? -entry : entry;
        }
    for (int c = 0; c < 3; ++c) /* S = R^T M, made symmetric */
        for (int r = 0; r < 3; ++r) s[3 * c + r] = norma_core_dot(rotation + 3 * r, m + 3 * c);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) stretch[3 * c + r] = (s[3 * c + r] + s[3 * r + c]) / 2.0;
}

void norma_skin_prepare_dual(double row[SKIN_ROW], double dual[8]) {
    double m[9], rotation[9], t[3], cross[3], *q = dual, *d = q + 4;
    memcpy(m, row, sizeof m);
    memcpy(t, row + SKIN_TRANSLATION, sizeof t);
    split_stretch(m, rotation, row);
    quaternion_of(rotation, q);
    /* (t, 0) q / 2 */
    norma_core_cross(t, q, cross);
    for (int i = 0; i < 3; ++i) d[i] = (t[i] * q[3] + cross[i]) / 2.0;
    d[3] = -norma_core_dot(t, q) / 2.0;
}

/* ---- one vertex */

static void rotate_columns(const double q[4], double square, double b[9]) {
    const double x = q[0], y = q[1], z = q[2], w = q[3], s = 2.0 / square;
    const double r[9] = {1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w),
        s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w), s * (x * z + y * w),
        s * (y * z - x * w), 1 - s * (x * x + y * y)};
    for (int c = 0; c < 3; ++c) {
        const double v[3] = {b[3 * c], b[3 * c + 1], b[3 * c + 2]};
        for (int i = 0; i < 3; ++i) b[3 * c + i] = r[i] * v[0] + r[3 + i] * v[1] + r[6 + i] * v[2];
    }
}

/* 2 d conj(q) / |q|^2: the translation of a dual quaternion that need not be of unit length. */
static void translation_of(const double q[4], const double d[4], double square, double out[3]) {
    double cross[3];
    norma_core_cross(q, d, cross);
    for (int i = 0; i < 3; ++i) out[i] = 2 * (q[3] * d[i] - d[3] * q[i] + cross[i]) / square;
}

/* Of the two quaternions of a rotation, the one on the side of the first joint that weighs
 * something (Kavan 2008, section 4.1). Where they cancel, that joint's rotation is kept. */
static void blend_dual(const skin_stream *s, size_t vertex, double b[SKIN_ROW]) {
    const size_t first = vertex * s->influences;
    double sum[8] = {0};
    const double *pivot = NULL;
    for (int i = 0; i < SKIN_ROW; ++i) b[i] = 0.0;
    for (size_t k = 0; k < s->influences; ++k) {
        const double weight = (double)s->skin->weights[first + k];
        if (weight == 0.0) continue;
        const uint32_t j = norma_index_read(s->joints, s->joint_size, first + k);
        if (!pivot) pivot = s->duals[j];
        double along = 0.0;
        for (int i = 0; i < 4; ++i) along += s->duals[j][i] * pivot[i];
        for (int i = 0; i < 8; ++i) sum[i] += (along < 0 ? -weight : weight) * s->duals[j][i];
        for (int i = 0; i < 9; ++i) b[i] += weight * s->rows[j][i];
    }
    if (!pivot) return;
    double square = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2] + sum[3] * sum[3];
    if (!(square > 0x1p-80)) {
        memcpy(sum, pivot, sizeof sum);
        square = 1.0;
    }
    rotate_columns(sum, square, b);
    translation_of(sum, sum + 4, square, b + SKIN_TRANSLATION);
}

/* ---- blocks of vertices */

enum { BLOCK = 32, COLUMNS = 12 }; /* vertices; columns of B and its translation */

/* A vector below this part of what it was summed from is computed exactly. With at most 64
 * influences, a double's direction is then within 2^-24 of the exact one, and a sign right. */
#define CERTAIN_VECTOR 0x1p-18
#define CERTAIN_SIGN   0x1p-36

/* ---- the matrices of a block of vertices: B's rows, made one after the other and turned over */

typedef struct skin_block {
    _Alignas(64) double row[BLOCK][SKIN_ROW];
    double b[COLUMNS][BLOCK], in[3][BLOCK], weight[BLOCK * SKIN_MOST_INFLUENCES];
    double size; /* what entries of B were summed from, at most: the same for all */
} skin_block;

/* The weights as doubles; the largest of them, without their signs. */
CORE_INLINE float read_weights(const float *from, size_t count, double *to) {
    uint32_t most = 0;
    float largest;
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, from + i, sizeof bits);
        bits &= UINT32_C(0x7fffffff);
        most = bits > most ? bits : most;
        to[i] = (double)from[i];
    }
    memcpy(&largest, &most, sizeof largest);
    return largest;
}

/* Rows of the joints of a vertex, weighted and added up. Wide: in registers until they are stored
 * whole, since what is stored in parts cannot soon be read whole. */
CORE_INLINE void add_joints(double (*rows)[SKIN_ROW], const unsigned char *joints,
    size_t joint_size, const double *weights, size_t count, double row[SKIN_ROW], int is_wide) {
#if defined(CORE_HAS_SHUFFLES)
    core_d4 sums[COLUMNS / 4] = {{0}};
    for (size_t k = 0; k < count && is_wide; ++k) {
        const double *from = rows[norma_index_read(joints, joint_size, k)], weight = weights[k];
        for (int i = 0; i < COLUMNS / 4; ++i)
            sums[i] += core_load_row(from + 4 * i) * (core_d4){weight, weight, weight, weight};
    }
    for (int i = 0; i < COLUMNS / 4 && is_wide; ++i) core_store_row(row + 4 * i, sums[i]);
    if (is_wide) return;
#endif
    double sum[COLUMNS] = {0};
    for (size_t k = 0; k < count; ++k) {
        const double *from = rows[norma_index_read(joints, joint_size, k)], weight = weights[k];
        for (int i = 0; i < COLUMNS; ++i) sum[i] += weight * from[i];
    }
    memcpy(row, sum, sizeof sum);
}

/* Four joints of 16 bits are what nearly all files have. */
static int is_usual(const skin_stream *s) { return s->influences == 4 && s->joint_size == 2; }

CORE_INLINE void blend_rows(
    const skin_stream *s, size_t first, size_t count, skin_block *block, int is_wide) {
    const size_t influences = s->influences, size = s->joint_size, bytes = influences * size;
    const unsigned char *joints = s->joints + first * bytes;
    double(*const rows)[SKIN_ROW] = s->rows;
    if (s->skin->blend == NORMA_BLEND_DUAL_QUATERNION)
        for (size_t i = 0; i < count; ++i) blend_dual(s, first + i, block->row[i]);
    else if (is_usual(s))
        for (size_t i = 0; i < count; ++i)
            add_joints(rows, joints + 8 * i, 2, block->weight + 4 * i, 4, block->row[i], is_wide);
    else
        for (size_t i = 0; i < count; ++i)
            add_joints(rows, joints + i * bytes, size, block->weight + i * influences, influences,
                block->row[i], is_wide);
}

/* Rows to lanes. With few registers shuffles go through memory, number by number, and take three
 * times as long as plain copies. */
CORE_INLINE void turn_rows(skin_block *block, int columns, int is_wide) {
#if defined(CORE_HAS_SHUFFLES)
    for (int i = 0; i < BLOCK && is_wide; i += 4)
        for (int column = 0; column < columns; column += 4) {
            core_d4 r[4];
            for (int k = 0; k < 4; ++k) r[k] = core_load_row(block->row[i + k] + column);
            core_turn_rows(r);
            for (int k = 0; k < 4; ++k) core_store_row(block->b[column + k] + i, r[k]);
        }
    if (is_wide) return;
#endif
    for (int i = 0; i < BLOCK; ++i)
        for (int column = 0; column < columns; ++column)
            block->b[column][i] = block->row[i][column];
}

/* ---- what is moved */

CORE_INLINE void read_vectors(
    const norma_vec3_view *in, size_t first, size_t count, double (*to)[BLOCK]) {
    if (in->format == NORMA_FORMAT_FLOAT && norma_view_stride(in) == 12 && count == BLOCK) {
        float v[3][BLOCK];
        core_threes_to_lanes((const unsigned char *)in->data + 12 * first, BLOCK, v[0], v[1], v[2]);
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < BLOCK; ++i) to[k][i] = (double)v[k][i];
        return;
    }
    for (size_t i = 0; i < count; ++i) {
        double v[3];
        norma_view_read(in, first + i, v);
        for (int k = 0; k < 3; ++k) to[k][i] = v[k];
    }
}

/* ---- normals */

/* cof(B) n of each vertex of a block, and the unit of it times sign(det B). */
typedef struct normal_lanes {
    double v[3][BLOCK], square[BLOCK], determinant[BLOCK];
    float unit[3][BLOCK], about[BLOCK];
    uint64_t certain[BLOCK];
} normal_lanes;

/* What the entries of one B were summed from, at most. */
static double size_of_sum(const skin_stream *s, size_t vertex) {
    double size = 0.0;
    for (size_t k = 0, at = vertex * s->influences; k < s->influences; ++k, ++at)
        size += fabs((double)s->skin->weights[at]) *
                s->rows[norma_index_read(s->joints, s->joint_size, at)][SKIN_SIZE];
    return size;
}

/* Whether doubles decide, for a B that was summed from size at most. */
CORE_INLINE int is_certain_sign(double determinant, double size) {
    return fabs(determinant) > CERTAIN_SIGN * size * size * size;
}
CORE_INLINE int is_certain(double determinant, double square, double normal_square, double size) {
    return is_certain_sign(determinant, size) &
           (square >
               CERTAIN_VECTOR * CERTAIN_VECTOR * (size * size) * (size * size) * normal_square);
}

/* Whether a float holds the square of a length well. */
CORE_INLINE int fits_float(double square) { return (square > 0x1p-120) & (square < 0x1p120); }

/* The columns of cof(B) are the cross products of B's. Nonzero: all are certain. */
CORE_INLINE int products_of_lanes(const skin_block *of, normal_lanes *l) {
    const double size = of->size;
    uint64_t certain = 1;
    for (int i = 0; i < BLOCK; ++i) {
        const double a0 = of->b[0][i], a1 = of->b[1][i], a2 = of->b[2][i], b0 = of->b[3][i],
                     b1 = of->b[4][i], b2 = of->b[5][i], c0 = of->b[6][i], c1 = of->b[7][i],
                     c2 = of->b[8][i], x = of->in[0][i], y = of->in[1][i], z = of->in[2][i];
        const double u0 = b1 * c2 - b2 * c1, u1 = b2 * c0 - b0 * c2, u2 = b0 * c1 - b1 * c0;
        const double v0 = u0 * x + (c1 * a2 - c2 * a1) * y + (a1 * b2 - a2 * b1) * z,
                     v1 = u1 * x + (c2 * a0 - c0 * a2) * y + (a2 * b0 - a0 * b2) * z,
                     v2 = u2 * x + (c0 * a1 - c1 * a0) * y + (a0 * b1 - a1 * b0) * z;
        const double determinant = a0 * u0 + a1 * u1 + a2 * u2;
        const double square = v0 * v0 + v1 * v1 + v2 * v2;
        l->v[0][i] = v0;
        l->v[1][i] = v1;
        l->v[2][i] = v2;
        l->square[i] = square;
        l->determinant[i] = determinant;
        l->certain[i] = (uint64_t)(is_certain(determinant, square, x * x + y * y + z * z, size) &
                                   fits_float(square));
    }
    for (int i = 0; i < BLOCK; ++i) certain &= l->certain[i];
    return (int)certain;
}

/* 1 / length: a float's root and quotient are quick, and a step of Newton's method squares their
 * error, to below 2^-43. */
CORE_INLINE void units_of_lanes(normal_lanes *l) {
    for (int i = 0; i < BLOCK; ++i) l->about[i] = 1.0F / sqrtf((float)l->square[i]);
    for (int i = 0; i < BLOCK; ++i) {
        const double about = (double)l->about[i],
                     factor = about * (1.5 - 0.5 * l->square[i] * (about * about));
        for (int k = 0; k < 3; ++k)
            l->unit[k][i] = (float)(l->v[k][i] * (l->determinant[i] < 0.0 ? -factor : factor)) +
                            0.0F; /* no -0 */
    }
}

/* Where doubles do not decide: the reason why there is no normal, or none. v: cof(B) n, sign(det B)
 * times, as they have it. */
static int decide_normal(const skin_stream *s, size_t vertex, const double given[3], double v[3]) {
    double n[3] = {given[0], given[1], given[2]};
    if (!norma_core_finite(n)) return NORMA_REASON_NON_FINITE;
    if (!norma_vec3_scale(n)) return NORMA_REASON_CANCELLED;
    const int found =
        s->skin->blend == NORMA_BLEND_LINEAR ? exact_normal(s, vertex, n, v) : norma_vec3_scale(v);
    return found ? NORMA_REASON_NONE : NORMA_REASON_CANCELLED;
}

/* The size that a block has in common is more than that of most of its vertices. */
static int decide_one(const skin_stream *s, size_t vertex, const skin_block *block,
    const normal_lanes *l, size_t i, float unit[3]) {
    const double n[3] = {block->in[0][i], block->in[1][i], block->in[2][i]}, square = l->square[i],
                 sign = l->determinant[i] < 0.0 ? -1.0 : 1.0;
    double v[3] = {sign * l->v[0][i], sign * l->v[1][i], sign * l->v[2][i]};
    int reason = NORMA_REASON_NONE;
    if (is_certain(l->determinant[i], square, norma_core_dot(n, n), size_of_sum(s, vertex))) {
        if (fits_float(square)) return reason;
    } else
        reason = decide_normal(s, vertex, n, v);
    if (reason == NORMA_REASON_NONE) norma_core_direction(v, unit);
    return reason;
}

static void write_uncertain(const skin_stream *s, size_t first, size_t count,
    const skin_block *block, const normal_lanes *l, core_tally *tally) {
    for (size_t i = 0; i < count; ++i) {
        float unit[3] = {l->unit[0][i], l->unit[1][i], l->unit[2][i]};
        const int reason =
            l->certain[i] ? NORMA_REASON_NONE : decide_one(s, first + i, block, l, i, unit);
        norma_core_write_element(&s->out, first + i, reason, unit, tally);
    }
}

/* Tight floats go where they belong at once: what is written in parts cannot soon be read whole. */
CORE_INLINE void write_lanes(
    const skin_stream *s, size_t first, size_t count, float (*axis)[BLOCK]) {
    const int tight = s->out.stride == sizeof(float[3]) && count == BLOCK;
    float block[BLOCK][3];
    core_lanes_to_threes(axis[0], axis[1], axis[2], BLOCK,
        tight ? (void *)(s->out.normals + first * sizeof *block) : block);
    if (!tight)
        for (size_t i = 0; i < count; ++i) norma_core_write_normal(&s->out, first + i, block[i]);
}

CORE_INLINE void normals_of_block(
    const skin_stream *s, size_t first, size_t count, const skin_block *block, core_tally *tally) {
    normal_lanes lanes;
    const int certain = products_of_lanes(block, &lanes);
    units_of_lanes(&lanes);
    if (certain && count == BLOCK) {
        write_lanes(s, first, BLOCK, lanes.unit);
        if (s->out.reasons) memset(s->out.reasons + first, NORMA_REASON_NONE, BLOCK);
    } else
        write_uncertain(s, first, count, block, &lanes, tally);
}

/* ---- positions and tangents */

CORE_INLINE void move_block(
    const skin_stream *s, size_t first, size_t count, const skin_block *of) {
    float moved[3][BLOCK];
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < BLOCK; ++i)
            moved[r][i] = (float)(of->b[r][i] * of->in[0][i] + of->b[3 + r][i] * of->in[1][i] +
                                  of->b[6 + r][i] * of->in[2][i] + of->b[9 + r][i]);
    write_lanes(s, first, count, moved);
}

static int mirrors(const skin_stream *s, size_t vertex, double determinant) {
    if (s->skin->blend != NORMA_BLEND_LINEAR ||
        is_certain_sign(determinant, size_of_sum(s, vertex)))
        return determinant < 0.0;
    return exactly_mirrors(s, vertex);
}

/* B t, and the unit of what is perpendicular to the normal in it. */
typedef struct tangent_lanes {
    double moved[3][BLOCK], determinant[BLOCK];
    float unit[3][BLOCK], sign[BLOCK];
    uint64_t certain[BLOCK];
} tangent_lanes;

CORE_INLINE void move_tangents(
    const skin_stream *s, size_t first, size_t count, const skin_block *of, tangent_lanes *l) {
    double t[3][BLOCK] = {{0}};
    memset(l->sign, 0, sizeof l->sign);
    for (size_t i = 0; i < count; ++i) {
        float in[4];
        memcpy(in, s->tangents + 4 * (first + i), sizeof in);
        for (int k = 0; k < 3; ++k) t[k][i] = (double)in[k];
        l->sign[i] = in[3];
    }
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < BLOCK; ++i)
            l->moved[r][i] =
                of->b[r][i] * t[0][i] + of->b[3 + r][i] * t[1][i] + of->b[6 + r][i] * t[2][i];
}

/* norma_core_perpendicular_tangent's steps, where both vectors are of ordinary length and not
 * parallel. */
CORE_INLINE void units_of_tangents(const skin_block *of, tangent_lanes *l) {
    for (int i = 0; i < BLOCK; ++i) {
        double n[3], t[3], out[3];
        for (int k = 0; k < 3; ++k) n[k] = of->in[k][i], t[k] = l->moved[k][i];
        const double n_square = norma_core_dot(n, n), t_square = norma_core_dot(t, t),
                     n_length = sqrt(n_square), t_length = sqrt(t_square);
        for (int k = 0; k < 3; ++k) n[k] /= n_length, t[k] /= t_length;
        const double along = norma_core_dot(n, t);
        for (int k = 0; k < 3; ++k) out[k] = t[k] - along * n[k];
        const double left = norma_core_dot(out, out), length = sqrt(left);
        for (int k = 0; k < 3; ++k) l->unit[k][i] = (float)(out[k] / length) + 0.0F;
        l->certain[i] = (uint64_t)((n_square > NORMA_TINIEST) & (n_square < NORMA_HUGEST) &
                                   (t_square > NORMA_TINIEST) & (t_square < NORMA_HUGEST) &
                                   (left > NOTHING_LEFT * NOTHING_LEFT));
    }
}

CORE_INLINE void signs_of_tangents(const skin_block *of, tangent_lanes *l) {
    for (int i = 0; i < BLOCK; ++i) {
        double cross[3], b[9];
        for (int k = 0; k < 9; ++k) b[k] = of->b[k][i];
        norma_core_cross(b + 3, b + 6, cross);
        const double determinant = norma_core_dot(b, cross);
        l->determinant[i] = determinant;
        l->sign[i] = determinant < 0.0 ? -l->sign[i] : l->sign[i];
        l->certain[i] &= (uint64_t)is_certain_sign(determinant, of->size);
    }
}

static void decide_tangent(const skin_stream *s, size_t vertex, const skin_block *of,
    const tangent_lanes *l, size_t i, float out[4]) {
    const double normal[3] = {of->in[0][i], of->in[1][i], of->in[2][i]},
                 moved[3] = {l->moved[0][i], l->moved[1][i], l->moved[2][i]},
                 determinant = l->determinant[i];
    double unit[3];
    norma_core_perpendicular_tangent(normal, moved, unit);
    for (int r = 0; r < 3; ++r) out[r] = (float)unit[r] + 0.0F;
    if ((determinant < 0.0) != mirrors(s, vertex, determinant)) out[3] = -out[3];
}

CORE_INLINE void tangents_of_block(
    const skin_stream *s, size_t first, size_t count, const skin_block *block) {
    tangent_lanes l;
    float out[BLOCK][4];
    move_tangents(s, first, count, block, &l);
    units_of_tangents(block, &l);
    signs_of_tangents(block, &l);
    for (int i = 0; i < BLOCK; ++i) {
        for (int k = 0; k < 3; ++k) out[i][k] = l.unit[k][i];
        out[i][3] = l.sign[i];
    }
    for (size_t i = 0; i < count; ++i)
        if (!l.certain[i]) decide_tangent(s, first + i, block, &l, i, out[i]);
    if (s->out.stride == sizeof out[0])
        memcpy(s->out.normals + first * sizeof out[0], out, count * sizeof out[0]);
    else
        for (size_t i = 0; i < count; ++i)
            memcpy(s->out.normals + (first + i) * s->out.stride, out[i], sizeof out[i]);
}

/* ---- kernels by instruction set */

CORE_INLINE void read_block_weights(
    const skin_stream *s, size_t first, size_t count, skin_block *block) {
    const float *weights = s->skin->weights + first * s->influences;
    block->size = (double)s->influences * s->largest *
                  (double)read_weights(weights, count * s->influences, block->weight);
}

/* Of B's columns: positions need all twelve, normals and tangents nine. */
static int columns_to_turn(const skin_stream *s, const core_tally *tally) {
    return s->tangents || tally ? 8 : 12;
}

CORE_INLINE void finish_block(
    const skin_stream *s, size_t first, size_t count, skin_block *block, core_tally *tally) {
    for (int i = 0; i < BLOCK; i += 4) /* the ninth column */
        for (int k = 0; k < 4; ++k) block->b[8][i + k] = block->row[i + k][8];
    read_vectors(&s->in, first, count, block->in);
    if (s->tangents)
        tangents_of_block(s, first, count, block);
    else if (tally)
        normals_of_block(s, first, count, block, tally);
    else
        move_block(s, first, count, block);
}

CORE_INLINE void skin_in_c(const skin_stream *s, size_t first, size_t count, skin_block *block,
    core_tally *tally, int is_wide) {
    read_block_weights(s, first, count, block);
    blend_rows(s, first, count, block, is_wide);
    turn_rows(block, columns_to_turn(s, tally), is_wide);
    finish_block(s, first, count, block, tally);
}

typedef void skin_kernel(
    const skin_stream *s, size_t first, size_t count, skin_block *block, core_tally *tally);

static void skin_block_portable(
    const skin_stream *s, size_t first, size_t count, skin_block *block, core_tally *tally) {
    skin_in_c(s, first, count, block, tally, 0);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void skin_block_avx2(
    const skin_stream *s, size_t first, size_t count, skin_block *block, core_tally *tally) {
    skin_in_c(s, first, count, block, tally, 1);
}
#endif

void norma_skin_move(const skin_stream *s, size_t first, size_t count, core_tally *tally) {
    static skin_kernel *const kernels[] = CORE_KERNELS_TO_AVX2(skin_block);
    const size_t end = first + count;
    skin_block block;
    memset(block.row, 0, sizeof block.row);
    for (size_t v = first; v < end; v += BLOCK)
        kernels[s->call.level](s, v, end - v < BLOCK ? end - v : BLOCK, &block, tally);
}
