/* skin.c: positions, normals and tangents of vertices that several joints move.
 *
 * Each vertex has a matrix of its own, B: the joints' matrices, weighted and added up in double
 * precision in ascending order of influence. Positions and tangents go through B, normals through
 * sign(det B) cof(B): the blend's normal matrix, not the blend of normal matrices. A vertex whose
 * normal doubles do not decide is done again in exact arithmetic (core/face/face_exact.c), with B's
 * entries as sums that have not been rounded (Shewchuk 1997, Grow-Expansion).
 *
 * Dual quaternions: Kavan, Collins, Zara, O'Sullivan 2008, Geometric Skinning with Approximate Dual
 * Quaternion Blending, eq. 18. Each joint is a rotation after a stretch, M = R S, with S symmetric
 * (the right polar factor, by singular values). Where M mirrors, both are negated, so that R is a
 * rotation (Shoemake, Duff 1992). Stretches are blended linearly, rotations and translations on the
 * sphere. */
#include "core/matrix/matrix.h"
#include "core/face/eight_vectors.h"

enum {
    BLOCK = 16,       /* vertices whose normals are computed side by side */
    CHUNK = 4096,     /* vertices of one task */
    LARGEST_SUM = 16, /* doubles of a sum that has not been rounded: see join_parts */
    TANGENT_BYTES = 4 * sizeof(float)
};

/* A vector below this part of what it was summed from is computed exactly. With at most 64
 * influences, a double's direction is then within 2^-24 of the exact one, and a sign right. */
#define CERTAIN_VECTOR 0x1p-18
#define CERTAIN_SIGN   0x1p-36

typedef struct skin_joint {
    double entry[12]; /* columns of three: the matrix; for dual quaternions its stretch */
    double size;      /* the largest of the first nine */
    double dual[8];   /* rotation (x, y, z, w) and the dual part, for dual quaternions */
} skin_joint;

typedef struct skin_stream {
    core_call call;
    const norma_skin *skin;
    const unsigned char *joints;
    size_t joint_size, influences;
    skin_joint *table; /* of each joint; zeros where it is not finite, and so not in use */
    norma_vec3_view in;
    const float *tangents;
    core_output out;
    core_tally *tallies; /* of each task */
} skin_stream;

/* ---- what is given */

static norma_result check_sizes(const norma_skin *s, norma_fault *fault) {
    const norma_result wrong = NORMA_ERROR_ARGUMENT;
    if (!s) return norma_core_refuse(fault, wrong, "skin", SIZE_MAX, "a skin");
    if (s->influences < 1 || s->influences > 64)
        return norma_core_refuse(fault, wrong, "skin->influences", SIZE_MAX, "1 to 64");
    if (s->joint_size && s->joint_size != 1 && s->joint_size != 2 && s->joint_size != 4)
        return norma_core_refuse(fault, wrong, "skin->joint_size", SIZE_MAX, "0, 1, 2 or 4");
    if (s->blend != NORMA_BLEND_LINEAR && s->blend != NORMA_BLEND_DUAL_QUATERNION)
        return norma_core_refuse(fault, wrong, "skin->blend", SIZE_MAX, "a norma_blend");
    if (s->vertex_count > SIZE_MAX / (64 * sizeof(double)))
        return norma_core_refuse(fault, NORMA_ERROR_OVERFLOW, "skin->vertex_count", SIZE_MAX,
            "fewer vertices than bytes can be counted");
    if (s->joint_count > SIZE_MAX / sizeof(skin_joint))
        return norma_core_refuse(fault, NORMA_ERROR_OVERFLOW, "skin->joint_count", SIZE_MAX,
            "fewer joints than bytes can be counted");
    if (!s->vertex_count) return NORMA_OK;
    if (s->joint_count && !s->matrices)
        return norma_core_refuse(fault, wrong, "skin->matrices", SIZE_MAX, "joint_count matrices");
    if (!s->joints)
        return norma_core_refuse(fault, wrong, "skin->joints", SIZE_MAX, "joints of each vertex");
    if (!s->weights)
        return norma_core_refuse(fault, wrong, "skin->weights", SIZE_MAX, "weights of each vertex");
    return NORMA_OK;
}

static int is_finite_matrix(const float m[16]) {
    float zero = 0.0F;
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 3; r++) zero += m[4 * c + r] * 0.0F;
    return zero == 0.0F;
}

/* The largest of count numbers of 1, 2 or 4 bytes: loops that compilers make vector code of. */
static uint32_t largest_joint(const void *joints, size_t size, size_t count) {
    uint32_t most = 0;
    if (size == sizeof(uint16_t)) {
        const unsigned char *at = joints;
        uint16_t largest = 0, number;
        for (size_t i = 0; i < count; i++) {
            memcpy(&number, at + i * sizeof number, sizeof number);
            largest = number > largest ? number : largest;
        }
        return largest;
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t number = norma_index_read(joints, size, i);
        most = number > most ? number : most;
    }
    return most;
}

/* Whether all are finite, by their exponents. */
static int all_numbers_finite(const float *numbers, size_t count) {
    uint32_t most = 0;
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, numbers + i, sizeof bits);
        bits &= UINT32_C(0x7fffffff);
        most = bits > most ? bits : most;
    }
    return most < UINT32_C(0x7f800000);
}

static norma_result check_influences(const norma_skin *s, norma_fault *fault) {
    const size_t count = s->vertex_count * s->influences, size = s->joint_size ? s->joint_size : 2;
    size_t i = 0;
    if (largest_joint(s->joints, size, count) >= s->joint_count) {
        while (norma_index_read(s->joints, size, i) < s->joint_count) i++;
        return norma_core_refuse(fault, NORMA_ERROR_INDEX, "skin->joints", i,
            "the number of a joint, below skin->joint_count");
    }
    if (!all_numbers_finite(s->weights, count)) {
        while (s->weights[i] * 0.0F == 0.0F) i++;
        return norma_core_refuse(
            fault, NORMA_ERROR_ARGUMENT, "skin->weights", i, "a finite number");
    }
    return NORMA_OK;
}

/* Only the matrices of joints that weigh something have to be finite. */
static norma_result check_matrices(const norma_skin *s, norma_fault *fault) {
    size_t broken = 0;
    for (size_t j = 0; j < s->joint_count; j++) broken += !is_finite_matrix(s->matrices + 16 * j);
    if (!broken) return NORMA_OK;
    const size_t count = s->vertex_count * s->influences, size = s->joint_size ? s->joint_size : 2;
    for (size_t i = 0; i < count; i++) {
        const uint32_t joint = norma_index_read(s->joints, size, i);
        if (s->weights[i] != 0.0F && !is_finite_matrix(s->matrices + 16 * (size_t)joint))
            return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "skin->matrices", joint,
                "twelve finite numbers, since a vertex uses it");
    }
    return NORMA_OK;
}

static norma_result check_skin(const norma_skin *skin, norma_fault *fault) {
    norma_result result = check_sizes(skin, fault);
    if (result == NORMA_OK && skin->vertex_count) result = check_influences(skin, fault);
    if (result == NORMA_OK && skin->vertex_count) result = check_matrices(skin, fault);
    return result;
}

norma_result norma_find_skin_fault(
    const norma_skin *skin, const norma_options *options, norma_fault *fault) {
    norma_core_refuse(fault, NORMA_OK, NULL, SIZE_MAX, NULL);
    const norma_result result = norma_core_check_options(options, fault);
    return result == NORMA_OK ? check_skin(skin, fault) : result;
}

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
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            if (values[order[k]] < values[order[k + 1]]) {
                const int swapped = order[k];
                order[k] = order[k + 1];
                order[k + 1] = swapped;
            }
    double *first = u + 3 * order[0], *second = u + 3 * order[1], *third = u + 3 * order[2];
    for (int i = 0; i < 3; i++)
        for (int r = 0; r < 3; r++)
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
    for (int r = 0; r < 3; r++) third[r] *= mirrored ? -side : side;
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
    for (int i = 0; i < 9; i++) largest = fmax(largest, fabs(m[i]));
    if (largest > 0.0) (void)frexp(largest, &exponent);
    for (int i = 0; i < 9; i++) scaled[i] = ldexp(m[i], 1 - exponent);
    const int mirrored = norma_matrix_mirrors(m);
    norma_singular_values(scaled, values, v);
    left_vectors(scaled, v, values, mirrored, u);
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) {
            const double entry = u[r] * v[c] + u[3 + r] * v[3 + c] + u[6 + r] * v[6 + c];
            rotation[3 * c + r] = mirrored ? -entry : entry;
        }
    for (int c = 0; c < 3; c++) /* S = R^T M, made symmetric */
        for (int r = 0; r < 3; r++) s[3 * c + r] = norma_core_dot(rotation + 3 * r, m + 3 * c);
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) stretch[3 * c + r] = (s[3 * c + r] + s[3 * r + c]) / 2.0;
}

static void prepare_joint(const float matrix[16], norma_blend blend, skin_joint *joint) {
    double m[9], rotation[9], t[3];
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 3; r++) joint->entry[3 * c + r] = (double)matrix[4 * c + r];
    memcpy(m, joint->entry, sizeof m);
    if (blend == NORMA_BLEND_DUAL_QUATERNION) {
        memcpy(t, joint->entry + 9, sizeof t);
        split_stretch(m, rotation, joint->entry);
        double *q = joint->dual, *d = q + 4, cross[3];
        quaternion_of(rotation, q);
        /* (t, 0) q / 2 */
        norma_core_cross(t, q, cross);
        for (int i = 0; i < 3; i++) d[i] = (t[i] * q[3] + cross[i]) / 2.0;
        d[3] = -norma_core_dot(t, q) / 2.0;
    }
    joint->size = 0.0;
    for (int i = 0; i < 9; i++) joint->size = fmax(joint->size, fabs(joint->entry[i]));
}

/* ---- one vertex's matrix */

/* Four of B's twelve numbers: compilers do not find by themselves that they can be added at once.
 */
#if defined(CORE_HAS_SHUFFLES)
typedef core_d4 sum_row;
CORE_INLINE sum_row add_matrix_row(sum_row sum, double weight, const double *from) {
    sum_row row;
    memcpy(&row, from, sizeof row);
    return sum + weight * row;
}
#else
typedef struct sum_row {
    double at[4];
} sum_row;
CORE_INLINE sum_row add_matrix_row(sum_row sum, double weight, const double *from) {
    for (int i = 0; i < 4; i++) sum.at[i] += weight * from[i];
    return sum;
}
#endif

/* Columns of three: three of B and its translation. The number: what B's entries were summed from,
 * at most. */
CORE_INLINE double add_joints(
    const skin_stream *s, size_t vertex, size_t influences, size_t joint_size, double b[12]) {
    const size_t first = vertex * influences;
    double size = 0.0;
    sum_row sum[3];
    memset(sum, 0, sizeof sum);
    for (size_t k = 0; k < influences; k++) {
        const double weight = (double)s->skin->weights[first + k];
        const skin_joint *j = &s->table[norma_index_read(s->joints, joint_size, first + k)];
        for (int i = 0; i < 3; i++) sum[i] = add_matrix_row(sum[i], weight, j->entry + 4 * i);
        size += fabs(weight) * j->size;
    }
    memcpy(b, sum, sizeof sum);
    return size;
}

/* Four joints of 16 bits are what nearly all files have: a third faster in a loop of their own. */
CORE_INLINE double blend_linear(const skin_stream *s, size_t vertex, double b[12]) {
    return s->influences == 4 && s->joint_size == 2
               ? add_joints(s, vertex, 4, 2, b)
               : add_joints(s, vertex, s->influences, s->joint_size, b);
}

static void rotate_columns(const double q[4], double square, double b[9]) {
    const double x = q[0], y = q[1], z = q[2], w = q[3], s = 2.0 / square;
    const double r[9] = {1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w),
        s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w), s * (x * z + y * w),
        s * (y * z - x * w), 1 - s * (x * x + y * y)};
    for (int c = 0; c < 3; c++) {
        const double v[3] = {b[3 * c], b[3 * c + 1], b[3 * c + 2]};
        for (int i = 0; i < 3; i++) b[3 * c + i] = r[i] * v[0] + r[3 + i] * v[1] + r[6 + i] * v[2];
    }
}

/* 2 d conj(q) / |q|^2: the translation of a dual quaternion that need not be of unit length. */
static void translation_of(const double q[4], const double d[4], double square, double out[3]) {
    double cross[3];
    norma_core_cross(q, d, cross);
    for (int i = 0; i < 3; i++) out[i] = 2 * (q[3] * d[i] - d[3] * q[i] + cross[i]) / square;
}

/* Of the two quaternions of a rotation, the one on the side of the first joint that weighs
 * something (Kavan 2008, section 4.1). Where they cancel, that joint's rotation is kept. */
static double blend_dual(const skin_stream *s, size_t vertex, double b[12]) {
    const size_t first = vertex * s->influences;
    double size = 0.0, sum[8] = {0};
    const skin_joint *pivot = NULL;
    for (int i = 0; i < 12; i++) b[i] = 0.0;
    for (size_t k = 0; k < s->influences; k++) {
        const double weight = (double)s->skin->weights[first + k];
        if (weight == 0.0) continue;
        const skin_joint *j = &s->table[norma_index_read(s->joints, s->joint_size, first + k)];
        if (!pivot) pivot = j;
        double along = 0.0;
        for (int i = 0; i < 4; i++) along += j->dual[i] * pivot->dual[i];
        for (int i = 0; i < 8; i++) sum[i] += (along < 0 ? -weight : weight) * j->dual[i];
        for (int i = 0; i < 9; i++) b[i] += weight * j->entry[i];
        size += fabs(weight) * j->size;
    }
    if (!pivot) return 0.0;
    double square = sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2] + sum[3] * sum[3];
    if (!(square > 0x1p-80)) {
        memcpy(sum, pivot->dual, sizeof sum);
        square = 1.0;
    }
    rotate_columns(sum, square, b);
    translation_of(sum, sum + 4, square, b + 9);
    return size;
}

/* ---- exactly */

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
    for (int i = 0; i < s->count; i++) {
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
    for (int i = 0; i < 9; i++) b[i].count = 0;
    for (size_t k = 0; k < s->influences; k++) {
        const double weight = (double)s->skin->weights[first + k];
        const skin_joint *j = &s->table[norma_index_read(s->joints, s->joint_size, first + k)];
        for (int i = 0; i < 9; i++) /* the product of two floats is exact in a double */
            if (weight != 0.0) add_exactly(&b[i], weight * j->entry[i]);
    }
    for (int i = 0; i < 9; i++) join_parts(&b[i]);
}

/* Adds a b c, or takes it away. */
static void add_products(
    exact_sum *sum, const long_sum *a, const long_sum *b, const double *c, int c_count, int minus) {
    for (int i = 0; i < a->count; i++)
        for (int j = 0; j < b->count; j++)
            for (int k = 0; k < c_count; k++)
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
    for (int c = 0; c < 3; c++)
        if (n[c] != 0.0) add_exact_cross(&sum, b, (c + 1) % 3, (c + 2) % 3, row, &n[c], 1);
    return norma_exact_round(&sum);
}

static int exactly_mirrors(const long_sum b[9]) {
    exact_sum sum;
    norma_exact_clear(&sum);
    for (int row = 0; row < 3; row++)
        add_exact_cross(&sum, b, 1, 2, row, b[row].part, b[row].count);
    return norma_exact_round(&sum).mantissa < 0.0;
}

/* A multiple of cof(B) n; 0 where that is exactly zero. */
static int exact_normal(const skin_stream *s, size_t vertex, const double n[3], double out[3]) {
    long_sum b[9];
    scaled_number v[3];
    blend_exactly(s, vertex, b);
    int most = INT32_MIN;
    for (int r = 0; r < 3; r++) {
        v[r] = exact_component(b, n, r);
        if (v[r].mantissa != 0.0 && v[r].exponent > most) most = v[r].exponent;
    }
    if (most == INT32_MIN) return 0;
    const double sign = exactly_mirrors(b) ? -1.0 : 1.0;
    for (int r = 0; r < 3; r++)
        out[r] = v[r].mantissa == 0.0 || v[r].exponent - most < -200
                     ? 0.0
                     : sign * ldexp(v[r].mantissa, v[r].exponent - most);
    return 1;
}

/* ---- normals */

typedef struct normal_lanes {
    double b[12][BLOCK], n[3][BLOCK], size[BLOCK]; /* in */
    double v[3][BLOCK];                            /* out: of some length */
    float unit[3][BLOCK];
    int certain[BLOCK];
} normal_lanes;

/* sign(det B) cof(B) n: the columns of cof(B) are the cross products of B's. */
CORE_INLINE void normals_of_lanes(normal_lanes *l) {
    for (int i = 0; i < BLOCK; i++) {
        const double a0 = l->b[0][i], a1 = l->b[1][i], a2 = l->b[2][i], b0 = l->b[3][i],
                     b1 = l->b[4][i], b2 = l->b[5][i], c0 = l->b[6][i], c1 = l->b[7][i],
                     c2 = l->b[8][i], x = l->n[0][i], y = l->n[1][i], z = l->n[2][i];
        const double u0 = b1 * c2 - b2 * c1, u1 = b2 * c0 - b0 * c2, u2 = b0 * c1 - b1 * c0;
        const double v0 = u0 * x + (c1 * a2 - c2 * a1) * y + (a1 * b2 - a2 * b1) * z,
                     v1 = u1 * x + (c2 * a0 - c0 * a2) * y + (a2 * b0 - a0 * b2) * z,
                     v2 = u2 * x + (c0 * a1 - c1 * a0) * y + (a0 * b1 - a1 * b0) * z;
        const double determinant = a0 * u0 + a1 * u1 + a2 * u2, s = l->size[i];
        const double sign = determinant < 0.0 ? -1.0 : 1.0, square = v0 * v0 + v1 * v1 + v2 * v2,
                     least = CERTAIN_VECTOR * CERTAIN_VECTOR * (s * s) * (s * s) *
                             (x * x + y * y + z * z);
        l->v[0][i] = v0 * sign;
        l->v[1][i] = v1 * sign;
        l->v[2][i] = v2 * sign;
        const double factor = sign / sqrt(square);
        l->unit[0][i] = (float)(v0 * factor) + 0.0F; /* no -0 */
        l->unit[1][i] = (float)(v1 * factor) + 0.0F;
        l->unit[2][i] = (float)(v2 * factor) + 0.0F;
        l->certain[i] = (fabs(determinant) > CERTAIN_SIGN * s * s * s) & (square > least) &
                        (square > 0x1p-900) & (square < 0x1p900);
    }
}

/* Where doubles do not decide: the reason why there is no normal, or none. */
static int decide_normal(const skin_stream *s, size_t vertex, const double given[3],
    const double product[3], double out[3]) {
    double n[3] = {given[0], given[1], given[2]};
    if (!norma_core_finite(n)) return NORMA_REASON_NON_FINITE;
    if (!norma_vec3_scale(n)) return NORMA_REASON_CANCELLED;
    if (s->skin->blend == NORMA_BLEND_LINEAR)
        return exact_normal(s, vertex, n, out) ? NORMA_REASON_NONE : NORMA_REASON_CANCELLED;
    memcpy(out, product, 3 * sizeof *out);
    return norma_vec3_scale(out) ? NORMA_REASON_NONE : NORMA_REASON_CANCELLED;
}

static void write_normals(
    const skin_stream *s, size_t first, size_t count, const normal_lanes *l, core_tally *tally) {
    for (size_t i = 0; i < count; i++) {
        float unit[3] = {l->unit[0][i], l->unit[1][i], l->unit[2][i]};
        int reason = NORMA_REASON_NONE;
        if (!l->certain[i]) {
            const double given[3] = {l->n[0][i], l->n[1][i], l->n[2][i]},
                         v[3] = {l->v[0][i], l->v[1][i], l->v[2][i]};
            double exact[3];
            reason = decide_normal(s, first + i, given, v, exact);
            if (reason == NORMA_REASON_NONE) norma_core_direction(exact, unit);
        }
        norma_core_write_element(&s->out, first + i, reason, unit, tally);
    }
}

CORE_INLINE void skin_normals(
    const skin_stream *s, size_t first, size_t end, core_tally *tally, int dual) {
    normal_lanes lanes;
    memset(&lanes, 0, sizeof lanes);
    for (size_t v = first; v < end; v += BLOCK) {
        const size_t count = end - v < BLOCK ? end - v : BLOCK;
        for (size_t i = 0; i < count; i++) {
            double b[12], n[3];
            lanes.size[i] = dual ? blend_dual(s, v + i, b) : blend_linear(s, v + i, b);
            norma_view_read(&s->in, v + i, n);
            for (int k = 0; k < 9; k++) lanes.b[k][i] = b[k];
            for (int k = 0; k < 3; k++) lanes.n[k][i] = n[k];
        }
        normals_of_lanes(&lanes);
        write_normals(s, v, count, &lanes, tally);
    }
}

/* ---- positions and tangents */

static double blended(const skin_stream *s, size_t vertex, double b[12]) {
    return s->skin->blend == NORMA_BLEND_LINEAR ? blend_linear(s, vertex, b)
                                                : blend_dual(s, vertex, b);
}

CORE_INLINE void skin_positions(const skin_stream *s, size_t first, size_t end, int dual) {
    for (size_t v = first; v < end; v++) {
        double b[12], p[3];
        float moved[3];
        (void)(dual ? blend_dual(s, v, b) : blend_linear(s, v, b));
        norma_view_read(&s->in, v, p);
        for (int r = 0; r < 3; r++)
            moved[r] = (float)(b[r] * p[0] + b[3 + r] * p[1] + b[6 + r] * p[2] + b[9 + r]);
        norma_core_write_normal(&s->out, v, moved);
    }
}

static int mirrors(const skin_stream *s, size_t vertex, const double b[12], double size) {
    double cross[3];
    norma_core_cross(b + 3, b + 6, cross);
    const double determinant = norma_core_dot(b, cross);
    if (fabs(determinant) > CERTAIN_SIGN * size * size * size ||
        s->skin->blend != NORMA_BLEND_LINEAR)
        return determinant < 0.0;
    long_sum exact[9];
    blend_exactly(s, vertex, exact);
    return exactly_mirrors(exact);
}

static void skin_tangents(const skin_stream *s, size_t first, size_t end) {
    for (size_t v = first; v < end; v++) {
        double b[12], moved[3], normal[3], unit[3];
        float in[4], out[4];
        const double size = blended(s, v, b);
        memcpy(in, s->tangents + 4 * v, sizeof in);
        norma_view_read(&s->in, v, normal);
        for (int r = 0; r < 3; r++)
            moved[r] = b[r] * (double)in[0] + b[3 + r] * (double)in[1] + b[6 + r] * (double)in[2];
        norma_core_perpendicular_tangent(normal, moved, unit);
        for (int r = 0; r < 3; r++) out[r] = (float)unit[r] + 0.0F;
        out[3] = mirrors(s, v, b, size) ? -in[3] : in[3];
        memcpy(s->out.normals + v * s->out.stride, out, sizeof out);
    }
}

/* ---- kernels by instruction set, and tasks */

typedef void skin_kernel(const skin_stream *s, size_t first, size_t end, core_tally *tally);

static void normals_portable(const skin_stream *s, size_t first, size_t end, core_tally *tally) {
    skin_normals(s, first, end, tally, s->skin->blend == NORMA_BLEND_DUAL_QUATERNION);
}
static void positions_portable(const skin_stream *s, size_t first, size_t end, core_tally *tally) {
    (void)tally;
    skin_positions(s, first, end, s->skin->blend == NORMA_BLEND_DUAL_QUATERNION);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static void normals_avx2(
    const skin_stream *s, size_t first, size_t end, core_tally *tally) {
    skin_normals(s, first, end, tally, s->skin->blend == NORMA_BLEND_DUAL_QUATERNION);
}
CORE_FOR_AVX2 static void positions_avx2(
    const skin_stream *s, size_t first, size_t end, core_tally *tally) {
    (void)tally;
    skin_positions(s, first, end, s->skin->blend == NORMA_BLEND_DUAL_QUATERNION);
}
#endif

static skin_kernel *choose_skin_kernel(const skin_stream *s, int normals) {
#if defined(CORE_HAS_X86)
    if (s->call.level >= CORE_AVX2) return normals ? normals_avx2 : positions_avx2;
#endif
    (void)s;
    return normals ? normals_portable : positions_portable;
}

static void run_chunk(void *context, size_t index) {
    const skin_stream *s = context;
    const size_t first = index * CHUNK, left = s->skin->vertex_count - first;
    const size_t end = first + (left < CHUNK ? left : CHUNK);
    if (s->tangents)
        skin_tangents(s, first, end);
    else
        choose_skin_kernel(s, s->tallies != NULL)(
            s, first, end, s->tallies ? &s->tallies[index] : NULL);
}

static size_t chunk_count(const skin_stream *s) {
    return (s->skin->vertex_count + CHUNK - 1) / CHUNK;
}

/* Everything that can be refused, before anything is written. */
static norma_result open_skin_stream(skin_stream *s, const norma_options *options,
    const norma_vec3_view *in, float *out, size_t capacity) {
    norma_result result = norma_core_begin(&s->call, options);
    if (result == NORMA_OK) result = check_skin(s->skin, NULL);
    if (result == NORMA_OK && s->call.options.fallback == NORMA_FALLBACK_NEAREST)
        result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK) result = norma_input_check(in);
    if (result == NORMA_OK && in->count < s->skin->vertex_count) result = NORMA_ERROR_ARGUMENT;
    if (result == NORMA_OK)
        result = norma_core_output_open(&s->call, out, s->skin->vertex_count, capacity, &s->out);
    if (result != NORMA_OK) return result;
    s->in = *in;
    s->joints = s->skin->joints;
    s->joint_size = s->skin->joint_size ? s->skin->joint_size : sizeof(uint16_t);
    s->influences = s->skin->influences;
    return NORMA_OK;
}

static norma_result run_stream(skin_stream *s) {
    const norma_skin *skin = s->skin;
    s->table = norma_core_allocate(&s->call, skin->joint_count, sizeof *s->table);
    if (!s->table) return NORMA_ERROR_MEMORY;
    for (size_t j = 0; j < skin->joint_count; j++) {
        const float *matrix = skin->matrices + 16 * j;
        memset(&s->table[j], 0, sizeof s->table[j]);
        if (is_finite_matrix(matrix)) prepare_joint(matrix, skin->blend, &s->table[j]);
    }
    norma_core_share(&s->call, 3 * skin->vertex_count);
    const norma_result result = norma_core_parallel(&s->call, chunk_count(s), run_chunk, s);
    norma_core_release(&s->call, s->table, skin->joint_count, sizeof *s->table);
    return norma_core_finish(&s->call, result);
}

norma_result norma_skin_positions(const norma_skin *skin, norma_vec3_view in,
    const norma_options *options, float *out, size_t capacity) {
    skin_stream s = {.skin = skin};
    const norma_result result = open_skin_stream(&s, options, &in, out, capacity);
    return result != NORMA_OK || !skin->vertex_count ? result : run_stream(&s);
}

norma_result norma_skin_normals(const norma_skin *skin, norma_vec3_view in,
    const norma_options *options, float *out, size_t capacity, norma_report *report) {
    skin_stream s = {.skin = skin};
    core_tally sum = {.non_finite = {0, 0}};
    norma_result result = open_skin_stream(&s, options, &in, out, capacity);
    if (result != NORMA_OK) return result;
    if (skin->vertex_count) {
        s.tallies = norma_core_allocate(&s.call, chunk_count(&s), sizeof *s.tallies);
        if (!s.tallies) return NORMA_ERROR_MEMORY;
        memset(s.tallies, 0, chunk_count(&s) * sizeof *s.tallies);
        result = run_stream(&s);
        for (size_t i = 0; i < chunk_count(&s); i++) norma_core_tally_add(&sum, &s.tallies[i]);
        norma_core_release(&s.call, s.tallies, chunk_count(&s), sizeof *s.tallies);
    }
    if (result == NORMA_OK) norma_core_write_report(report, &sum, NULL, NULL);
    return result;
}

norma_result norma_skin_tangents(const norma_skin *skin, const float *in,
    norma_vec3_view skinned_normals, const norma_options *options, float *out, size_t capacity) {
    skin_stream s = {.skin = skin, .tangents = in};
    norma_result result = open_skin_stream(&s, options, &skinned_normals, out, capacity);
    if (result != NORMA_OK || !skin->vertex_count) return result;
    if (options && options->normal_stride && options->normal_stride < TANGENT_BYTES)
        return NORMA_ERROR_ARGUMENT;
    if (!in) return NORMA_ERROR_ARGUMENT;
    if (!options || !options->normal_stride) s.out.stride = TANGENT_BYTES;
    if (skin->vertex_count > SIZE_MAX / s.out.stride) return NORMA_ERROR_OVERFLOW;
    return run_stream(&s);
}
