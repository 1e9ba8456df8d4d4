/* singular_values.c: singular values of a 3x3 by one-sided Jacobi rotations (Hestenes 1958),
 * accurate to a few units in the last place of the largest. Only + - * / and sqrt: the same bits
 * everywhere. */
#include "core/call/vector.h"
#include "core/matrix/matrix.h"
#include <math.h>
#include <string.h>

enum {
    SWEEPS = 40
}; /* quadratic convergence needs five or six; the limit only guards against cycling in the last bit
    */

static void rotate(double a[3], double b[3], double c, double s) {
    for (int i = 0; i < 3; i++) {
        const double x = a[i], y = b[i];
        a[i] = c * x - s * y;
        b[i] = s * x + c * y;
    }
}

/* Makes columns p and q perpendicular; 0 where they already are to the last bits. */
static int rotate_pair(double *u, double *v, int p, int q) {
    double *a = u + 3 * p, *b = u + 3 * q;
    const double alpha = norma_core_dot(a, a), beta = norma_core_dot(b, b),
                 gamma = norma_core_dot(a, b);
    if (fabs(gamma) <= 0x1p-53 * sqrt(alpha) * sqrt(beta) || gamma == 0.0) return 0;
    const double zeta = (beta - alpha) / (2.0 * gamma);
    const double t = (zeta < 0.0 ? -1.0 : 1.0) / (fabs(zeta) + sqrt(1.0 + zeta * zeta));
    const double c = 1.0 / sqrt(1.0 + t * t), s = c * t;
    rotate(a, b, c, s);
    rotate(v + 3 * p, v + 3 * q, c, s);
    return s != 0.0;
}

void norma_singular_values(const double matrix[9], double values[3], double v[9]) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double u[9];
    memcpy(u, matrix, sizeof u);
    memcpy(v, identity, sizeof identity);
    for (int sweep = 0, turned = 1; turned && sweep < SWEEPS; sweep++) {
        turned = rotate_pair(u, v, 0, 1);
        turned |= rotate_pair(u, v, 0, 2);
        turned |= rotate_pair(u, v, 1, 2);
    }
    for (int i = 0; i < 3; i++) values[i] = sqrt(norma_core_dot(u + 3 * i, u + 3 * i));
}
