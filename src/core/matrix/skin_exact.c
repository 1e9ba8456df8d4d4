/* skin_exact.c: the normal of a skinned vertex, and whether its matrix mirrors, in exact arithmetic
 * (core/face/face_exact.c), with the blend's entries as sums that have not been rounded (Shewchuk
 * 1997, Grow-Expansion): for the vertices that doubles do not decide. */
#include "core/matrix/matrix.h"

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

static int exactly_mirrors(const long_sum b[9]) {
    exact_sum sum;
    norma_exact_clear(&sum);
    for (int row = 0; row < 3; ++row)
        add_exact_cross(&sum, b, 1, 2, row, b[row].part, b[row].count);
    return norma_exact_round(&sum).mantissa < 0.0;
}

int norma_skin_exact_normal(const skin_stream *s, size_t vertex, const double n[3], double out[3]) {
    long_sum b[9];
    scaled_number v[3];
    blend_exactly(s, vertex, b);
    int most = INT32_MIN;
    for (int r = 0; r < 3; ++r) {
        v[r] = exact_component(b, n, r);
        if (v[r].mantissa != 0.0 && v[r].exponent > most) most = v[r].exponent;
    }
    if (most == INT32_MIN) return 0;
    const double sign = exactly_mirrors(b) ? -1.0 : 1.0;
    for (int r = 0; r < 3; ++r)
        out[r] = v[r].mantissa == 0.0 || v[r].exponent - most < -200
                     ? 0.0
                     : sign * ldexp(v[r].mantissa, v[r].exponent - most);
    return 1;
}

int norma_skin_exactly_mirrors(const skin_stream *s, size_t vertex) {
    long_sum b[9];
    blend_exactly(s, vertex, b);
    return exactly_mirrors(b);
}
