/* interpolate.c: the normal inside a face (Phong 1975, p. 314): the corners' normals summed by
 * barycentric weights, made unit again. */
#include "core/matrix/stream.h"

#define CANCELLED 0x1p-20 /* of the sum's terms: below it the sum's direction is rounding */

norma_result norma_interpolate_normal(const float a[3], const float b[3], const float c[3],
    const float barycentric[3], float normal[3]) {
    if (!a || !b || !c || !barycentric || !normal) return NORMA_ERROR_ARGUMENT;
    const float *corner[3] = {a, b, c};
    double sum[3] = {0.0, 0.0, 0.0}, terms = 0.0;
    for (int k = 0; k < 3; k++) {
        double term[3];
        for (int i = 0; i < 3; i++) {
            term[i] = (double)corner[k][i] * (double)barycentric[k];
            sum[i] += term[i];
        }
        terms += sqrt(norma_core_dot(term, term));
    }
    const double length = sqrt(norma_core_dot(sum, sum));
    const int kept = length > CANCELLED * terms && length <= DBL_MAX;
    for (int i = 0; i < 3; i++) normal[i] = kept ? (float)(sum[i] / length) : 0.0f;
    return NORMA_OK;
}
