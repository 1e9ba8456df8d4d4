/* find_model_fault.c: norma_find_model_fault. */
#include "core/call/fault.h"
#include <math.h>
#include <string.h>

static int is_finite(const unsigned char *model) {
    float m[16];
    memcpy(m, model, sizeof m);
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++)
            if (!isfinite(m[4 * column + row])) return 0;
    return 1;
}

norma_result norma_find_model_fault(
    const float *models, size_t model_stride, size_t count, norma_fault *fault) {
    const size_t stride = model_stride ? model_stride : 16 * sizeof(float);
    norma_core_refuse(fault, NORMA_OK, NULL, SIZE_MAX, NULL);
    if (count && !models)
        return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "models", SIZE_MAX, "not NULL");
    if (count > SIZE_MAX / stride)
        return norma_core_refuse(
            fault, NORMA_ERROR_OVERFLOW, "count", SIZE_MAX, "count * model_stride fits a size_t");
    for (size_t i = 0; i < count; i++)
        if (!is_finite((const unsigned char *)models + i * stride))
            return norma_core_refuse(
                fault, NORMA_ERROR_ARGUMENT, "models", i, "finite in [0..2], [4..6] and [8..10]");
    return NORMA_OK;
}
