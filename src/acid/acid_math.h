/* acid_math.h: vectors and 3x3 matrices of doubles. Sums, products, quotients and square roots
 * only: the same bits everywhere. */
#ifndef NORMA_ACID_MATH_H
#define NORMA_ACID_MATH_H
#include <math.h>

typedef struct acid_vector {
    double x, y, z;
} acid_vector;

typedef struct acid_matrix {
    acid_vector column[3];
} acid_matrix;

static inline acid_vector acid_scaled(acid_vector a, double s) {
    return (acid_vector){s * a.x, s * a.y, s * a.z};
}
static inline acid_vector acid_sum(acid_vector a, acid_vector b) {
    return (acid_vector){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline acid_vector acid_minus(acid_vector a, acid_vector b) {
    return (acid_vector){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline double acid_dot(acid_vector a, acid_vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline acid_vector acid_cross(acid_vector a, acid_vector b) {
    return (acid_vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double acid_length(acid_vector a) { return sqrt(acid_dot(a, a)); }
static inline acid_vector acid_unit(acid_vector a) { return acid_scaled(a, 1 / acid_length(a)); }

static inline acid_vector acid_times(const acid_matrix *m, acid_vector v) {
    return acid_sum(acid_sum(acid_scaled(m->column[0], v.x), acid_scaled(m->column[1], v.y)),
        acid_scaled(m->column[2], v.z));
}
static inline acid_vector acid_transposed_times(const acid_matrix *m, acid_vector v) {
    return (acid_vector){
        acid_dot(m->column[0], v), acid_dot(m->column[1], v), acid_dot(m->column[2], v)};
}
static inline acid_matrix acid_product(const acid_matrix *a, const acid_matrix *b) {
    return (acid_matrix){
        {acid_times(a, b->column[0]), acid_times(a, b->column[1]), acid_times(a, b->column[2])}};
}
static inline acid_matrix acid_cofactors(const acid_matrix *m) {
    return (acid_matrix){{acid_cross(m->column[1], m->column[2]),
        acid_cross(m->column[2], m->column[0]), acid_cross(m->column[0], m->column[1])}};
}
static inline double acid_determinant(const acid_matrix *m) {
    return acid_dot(m->column[0], acid_cross(m->column[1], m->column[2]));
}
/* The transpose of the cofactors over the determinant, times v. */
static inline acid_vector acid_solve(const acid_matrix *m, acid_vector v) {
    const acid_matrix c = acid_cofactors(m);
    return acid_scaled(acid_transposed_times(&c, v), 1 / acid_determinant(m));
}
#endif
