/* kernels_portable.c: the kernels for any machine. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize(                                                                              \
    "no-tree-slp-vectorize") /* this compiler gathers neighbouring addresses into                  \
                                vectors, only to take them out again one by one */
#endif
#include "core/face/vectors.h"

#define VECTORS(name) core_portable_##name
#define FOR_VECTORS
#define FOR_ROWS
#define IN_VECTORS CORE_INLINE
typedef core_portable_vector vector;
typedef core_portable_mask mask;
enum { LANES = CORE_PORTABLE_LANES };
#include "core/face/face_kernel.template.h"
#include "core/face/add_kernel.template.h"

const core_kernels *norma_core_kernels_portable(void) { return &KERNELS; }
