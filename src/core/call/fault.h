/* fault.h: a refusal, and what it was about, for a caller who asks. */
#ifndef NORMA_CORE_FAULT_H
#define NORMA_CORE_FAULT_H
#include <norma/norma.h>

/* Returns result. fault may be NULL: then nobody asks. index: SIZE_MAX for the argument as a whole.
 */
static inline norma_result norma_core_refuse(norma_fault *fault, norma_result result,
    const char *argument, size_t index, const char *expected) {
    if (fault)
        *fault = (norma_fault){
            .result = result, .argument = argument, .index = index, .expected = expected};
    return result;
}
#endif
