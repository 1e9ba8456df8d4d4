/* vector.h: three doubles: products, length, direction. */
#ifndef NORMA_CORE_VECTOR_H
#define NORMA_CORE_VECTOR_H

/* Squares between these lost nothing to underflow or overflow, nor do products of three such
 * lengths. */
#define NORMA_TINIEST 0x1p-640
#define NORMA_HUGEST  0x1p640

/* Of any scale: to a unit vector, zeros stay zeros; the length. */
void norma_core_normalise(const double v[3], double unit[3]);
double norma_core_length(const double v[3]);

static inline double norma_core_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static inline void norma_core_cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}
static inline void norma_core_subtract(const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}

/* Not NaN, not infinite. */
static inline int norma_core_finite(const double v[3]) {
    const double zero = (v[0] - v[0]) + (v[1] - v[1]) + (v[2] - v[2]);
    return zero == 0;
}
#endif
