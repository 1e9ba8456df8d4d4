/* check.h: what the tests of the core share: cmocka, degrees, the library called with all defaults.
 */
#ifndef NORMA_TESTS_CHECK_H
#define NORMA_TESTS_CHECK_H
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <norma/norma.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DEGREES         57.29577951308232
#define COUNT_OF(array) (sizeof(array) / sizeof *(array))

/* In degrees, exact near 0 and 180. */
static inline double degrees_between(const float *a, const double *b) {
    const double x = (double)a[1] * b[2] - (double)a[2] * b[1],
                 y = (double)a[2] * b[0] - (double)a[0] * b[2],
                 z = (double)a[0] * b[1] - (double)a[1] * b[0];
    return DEGREES * atan2(sqrt(x * x + y * y + z * z),
                         (double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2]);
}

static inline double degrees_to(const float *a, double x, double y, double z) {
    const double b[3] = {x, y, z};
    return degrees_between(a, b);
}

#define assert_direction(normal, x, y, z, tolerance_deg)                                           \
    do {                                                                                           \
        const double off_ = degrees_to(normal, x, y, z);                                           \
        if (!(off_ <= (tolerance_deg)))                                                            \
            print_error("(%.9g %.9g %.9g) is %g degrees off\n", (double)(normal)[0],               \
                (double)(normal)[1], (double)(normal)[2], off_);                                   \
        assert_true(off_ <= (tolerance_deg));                                                      \
    } while (0)

/* How much less of a long test a sanitizer's build runs. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SLOWER 16
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SLOWER 16
#endif
#endif
#ifndef SLOWER
#define SLOWER 1
#endif

#define assert_ok(call) assert_int_equal(call, NORMA_OK)
#endif
