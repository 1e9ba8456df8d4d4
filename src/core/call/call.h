/* call.h: what every call of the library begins and ends with: instruction sets,
 * weights, the caller's views, small vectors, counts, faults, sets and tables, options made whole,
 * memory, threads, progress, and the output. */
#ifndef NORMA_CORE_CALL_CALL_H
#define NORMA_CORE_CALL_CALL_H
#include <norma/norma.h>
#include <string.h>
#include <stdint.h>
#include <stddef.h>
#include <stdatomic.h>
#include <math.h>

/* ---- which instruction sets this machine runs, and how a loop is compiled for each. Every one
 * gives the bits of the portable C code. */

int norma_core_has_isa(norma_isa isa);

/* A kernel is an inline function in plain C over arrays of lanes, and one wrapper for each of
 * these, whose target decides what instructions it becomes. Portable code becomes SSE2, NEON or
 * SIMD128 where the compiler's target has them. */
typedef enum core_level { CORE_PORTABLE = 0, CORE_AVX2, CORE_AVX512 } core_level;
core_level norma_core_level(norma_isa isa); /* the highest that the machine has and isa allows */

#if defined(NORMA_COVERAGE) || defined(NORMA_SANITIZED) || defined(NORMA_SMALL)
#define CORE_INLINE                                                                                \
    static inline /* what is counted is the source, once, not each copy of a kernel; with the      \
                     checks of a sanitizer one file would be 16 MB; and the small module of        \
                     norma-mesh/normals has each function once */
#elif defined(__GNUC__) || defined(__clang__)
#define CORE_INLINE static inline __attribute__((always_inline))
#else
#define CORE_INLINE static inline
#endif

#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
#define CORE_HAS_X86
#if !defined(NORMA_WITHOUT_AVX512) /* a choice of the single file's users: less code */
#define CORE_HAS_AVX512
#endif
#define CORE_FOR_AVX2 __attribute__((target("avx2")))
#if defined(CORE_FOR_AVX512) /* tests/bits/avx512_in_c.h */
#elif defined(__clang__)
#define CORE_FOR_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl")))
#else
#define CORE_FOR_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl,prefer-vector-width=512")))
#endif
#define CORE_IN_REGISTERS                                                                          \
    CORE_FOR_AVX512 CORE_INLINE /* a step of a loop that is written for AVX-512 */
#endif

/* The kernels of one name, by level. */
#if defined(CORE_HAS_X86)
#define CORE_KERNELS_TO_AVX2(name)                                                                 \
    { name##_portable, name##_avx2, name##_avx2 } /* what AVX-512 makes less than 15 % faster */
#else
#define CORE_KERNELS_TO_AVX2(name)                                                                 \
    { name##_portable }
#endif
#if defined(CORE_HAS_AVX512)
#define CORE_KERNELS(name)                                                                         \
    { name##_portable, name##_avx2, name##_avx512 }
#elif defined(CORE_HAS_X86)
#define CORE_KERNELS(name)                                                                         \
    { name##_portable, name##_avx2 }
#else
#define CORE_KERNELS(name)                                                                         \
    { name##_portable }
#endif

/* norma-mesh/normals is made without polygons, marked edges, the most visible normal, welding over
 * a distance, steady tangents and what only speed or little memory needs: the linker drops all that
 * this constant shuts. */
#if defined(NORMA_SMALL)
enum { CORE_IS_SMALL = 1 };
#else
enum { CORE_IS_SMALL = 0 };
#endif

/* ---- all that is particular to a weight, in one table, and what follows from it: names, the
 * weight of a corner, loops compiled once for each weight. */

/* What a weight is made of. */
typedef enum core_weighed_by {
    CORE_BY_FACE,  /* twice_area at most: the same at all corners of a face */
    CORE_BY_EDGES, /* also aa and bb, the squares of the corner's edges, and cross, the length of
                      their cross product */
    CORE_BY_ANGLE  /* also angle, between them */
} core_weighed_by;

/* The constant without NORMA_WEIGHT_, its name, what it is made of, and how. W is used with these
 * and the other arguments. */
#define CORE_SUMMED_WEIGHTS(W, ...)                                                                \
    W(ANGLE, "angle", CORE_BY_ANGLE, angle, __VA_ARGS__)                                           \
    W(AREA, "area", CORE_BY_FACE, twice_area, __VA_ARGS__)                                         \
    W(UNIFORM, "uniform", CORE_BY_FACE, 1, __VA_ARGS__)                                            \
    W(MAX, "max", CORE_BY_EDGES, (aa * bb > 0 ? cross / (aa * bb) : 0), __VA_ARGS__)               \
    W(ANGLE_AREA, "angle-area", CORE_BY_ANGLE, (angle * twice_area), __VA_ARGS__)                  \
    W(ANGLE_LENGTHS, "angle-lengths", CORE_BY_ANGLE, (angle * (sqrt(aa) * sqrt(bb))), __VA_ARGS__)

/* The same with the one that is no sum; where there must be a sum, it is uniform. */
#define CORE_WEIGHTS(W, ...)                                                                       \
    CORE_SUMMED_WEIGHTS(W, __VA_ARGS__)                                                            \
    W(VISIBLE, "visible", CORE_BY_FACE, 1, __VA_ARGS__)

#define CORE_CASE_OF_NEED(name, text, by, formula, unused)                                         \
    case NORMA_WEIGHT_##name:                                                                      \
        return by;
#define CORE_CASE_OF_FORMULA(name, text, by, formula, unused)                                      \
    case NORMA_WEIGHT_##name:                                                                      \
        return formula;
#define CORE_CASE_OF_LOOP(name, text, by, formula, loop, ...)                                      \
    case NORMA_WEIGHT_##name:                                                                      \
        loop(__VA_ARGS__, NORMA_WEIGHT_##name);                                                    \
        break;

CORE_INLINE core_weighed_by core_weighed(norma_weight weight) {
    switch (weight) { CORE_WEIGHTS(CORE_CASE_OF_NEED, ) }
    return CORE_BY_FACE;
}

/* What a corner weighs. Of what its weight is not made of, anything may be given. */
CORE_INLINE double norma_core_weight_of(
    norma_weight weight, double aa, double bb, double angle, double cross, double twice_area) {
    switch (weight) { CORE_WEIGHTS(CORE_CASE_OF_FORMULA, ) }
    return 1;
}

/* loop(..., weight), where the compiler knows the weight, so that nothing inside asks for it; made
 * small (norma-mesh/normals), once for all weights. */
#if defined(NORMA_SMALL)
#define CORE_LOOP_FOR_WEIGHT(weight, loop, ...)                                                    \
    loop(__VA_ARGS__, (weight) == NORMA_WEIGHT_VISIBLE ? NORMA_WEIGHT_UNIFORM : (weight));
#else
#define CORE_LOOP_FOR_WEIGHT(weight, loop, ...)                                                    \
    switch (weight) {                                                                              \
        CORE_SUMMED_WEIGHTS(CORE_CASE_OF_LOOP, loop, __VA_ARGS__)                                  \
    case NORMA_WEIGHT_VISIBLE:                                                                     \
        loop(__VA_ARGS__, NORMA_WEIGHT_UNIFORM);                                                   \
        break;                                                                                     \
    }
#endif

/* ---- one vector of a view, of any format, stride and alignment, as three doubles, and one index
 * of an array. Every format fits a double exactly. */

/* Bytes of one number; 0 for what is no format. */
static inline size_t norma_format_size(norma_format format) {
    switch (format) {
    case NORMA_FORMAT_FLOAT:
        return sizeof(float);
    case NORMA_FORMAT_DOUBLE:
        return sizeof(double);
    case NORMA_FORMAT_INT8:
        return sizeof(int8_t);
    case NORMA_FORMAT_UINT8:
        return sizeof(uint8_t);
    case NORMA_FORMAT_INT16:
        return sizeof(int16_t);
    case NORMA_FORMAT_UINT16:
        return sizeof(uint16_t);
    }
    return 0;
}

/* Bytes from one vector to the next, never 0 for a valid format. */
static inline size_t norma_view_stride(const norma_vec3_view *view) {
    return view->stride ? view->stride : 3 * norma_format_size(view->format);
}

/* Whether count * stride, or the end of the last vector where it is wider than the stride, is
 * beyond size_t. */
static inline int norma_view_overflows(const norma_vec3_view *view) {
    const size_t stride = norma_view_stride(view), size = 3 * norma_format_size(view->format);
    if (!view->count || !stride) return 0;
    return view->count > SIZE_MAX / stride || (view->count - 1) * stride > SIZE_MAX - size;
}

/* Vector index of the view; the caller has checked format and index. */
static inline void norma_view_read(const norma_vec3_view *view, size_t index, double out[3]) {
    const unsigned char *at = (const unsigned char *)view->data + index * norma_view_stride(view);
    switch (view->format) {
    case NORMA_FORMAT_FLOAT: {
        float v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; ++i) out[i] = (double)v[i];
        return;
    }
    case NORMA_FORMAT_DOUBLE:
        memcpy(out, at, 3 * sizeof(double));
        return;
    case NORMA_FORMAT_INT8: {
        int8_t v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; ++i) out[i] = (double)v[i];
        return;
    }
    case NORMA_FORMAT_UINT8:
        for (int i = 0; i < 3; ++i) out[i] = (double)at[i];
        return;
    case NORMA_FORMAT_INT16: {
        int16_t v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; ++i) out[i] = (double)v[i];
        return;
    }
    case NORMA_FORMAT_UINT16: {
        uint16_t v[3];
        memcpy(v, at, sizeof v);
        for (int i = 0; i < 3; ++i) out[i] = (double)v[i];
        return;
    }
    }
    out[0] = out[1] = out[2] = 0.0;
}

/* Index number of an array of integers of 1, 2 or 4 bytes. */
static inline uint32_t norma_index_read(const unsigned char *indices, size_t size, size_t number) {
    uint32_t four;
    uint16_t two;
    if (size == 1) return indices[number];
    if (size == 2) {
        memcpy(&two, indices + 2 * number, sizeof two);
        return two;
    }
    memcpy(&four, indices + 4 * number, sizeof four);
    return four;
}

/* ---- three doubles: products, length, direction. */

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
    for (int k = 0; k < 3; ++k) out[k] = a[k] - b[k];
}

/* Not NaN, not infinite. */
static inline int norma_core_finite(const double v[3]) {
    const double zero = (v[0] - v[0]) + (v[1] - v[1]) + (v[2] - v[2]);
    return zero == 0;
}

/* ---- exact_sum.c: sums of products of up to four doubles without any rounding, for signs and
 * zeros that must be exact. A long fixed-point register holds every bit that such a product can
 * have (Kulisch's accumulator). It is slow beside two or three floating-point operations, so
 * callers ask a floating-point filter first and come here only where that cannot decide. */

enum { EXACT_SUM_FACTORS = 4, EXACT_SUM_LIMBS = 264 };

/* Two's complement; the lowest bit weighs 2^(-4 * 1074). The widest sum, 2^12 products near 2^4096,
 * leaves the sign bit free. */
typedef struct exact_sum {
    uint32_t limb[EXACT_SUM_LIMBS];
} exact_sum;

/* mantissa * 2^exponent with 1 <= |mantissa| < 2, or mantissa 0: a double without its narrow range.
 */
typedef struct scaled_number {
    double mantissa;
    int exponent;
} scaled_number;

void norma_exact_clear(exact_sum *sum);
void norma_exact_add(
    exact_sum *sum, const double *factors, int count, int negative); /* all finite; count 1 to 4 */
scaled_number norma_exact_round(const exact_sum *sum);               /* to nearest, ties to even */

scaled_number norma_scaled_from_double(double value); /* finite */
double norma_scaled_to_double(
    scaled_number number); /* rounded: infinite or zero beyond a double's range */

/* Between two points, all finite; square: the squared length as doubles give it. */
typedef struct core_segment {
    double from[3], to[3], square;
} core_segment;

void norma_core_measure_segment(core_segment *segment); /* its square */
/* Whether a is longer than b: 1, 0 (as long, exactly) or -1. */
int norma_core_compare_lengths(const core_segment *a, const core_segment *b);

/* ---- the counts of a report, added up from those of parts. */

static inline void norma_core_count_one(norma_count *count, size_t index) {
    if (!count->count || index < count->first) count->first = index;
    ++count->count;
}
static inline void norma_core_count_add(norma_count *sum, const norma_count *part) {
    if (!part->count) return;
    if (!sum->count || part->first < sum->first) sum->first = part->first;
    sum->count += part->count;
}
static inline void norma_core_edges_add(norma_edges *sum, const norma_edges *part) {
    sum->count += part->count;
    sum->open += part->open;
    sum->smooth += part->smooth;
    sum->hard += part->hard;
}

/* ---- a refusal, and what it was about, for a caller who asks. */

/* Returns result. fault may be NULL: then nobody asks. index: SIZE_MAX for the argument as a whole.
 */
static inline norma_result norma_core_refuse(norma_fault *fault, norma_result result,
    const char *argument, size_t index, const char *expected) {
    if (fault)
        *fault = (norma_fault){
            .result = result, .argument = argument, .index = index, .expected = expected};
    return result;
}

/* ---- numbers joined into sets (union by the lower number, paths halved: Tarjan, van Leeuwen
 * 1984). joined[i] is a number of the same set, lower or i itself; the lowest of a set is its own.
 */

/* The lowest number of i's set. */
static inline uint32_t norma_core_set_of(uint32_t *joined, uint32_t i) {
    while (joined[i] != i) i = joined[i] = joined[joined[i]];
    return i;
}

static inline void norma_core_join_sets(uint32_t *joined, uint32_t a, uint32_t b) {
    const uint32_t set_a = norma_core_set_of(joined, a), set_b = norma_core_set_of(joined, b);
    if (set_a < set_b)
        joined[set_b] = set_a;
    else
        joined[set_a] = set_b;
}

/* ---- for what is sorted seldom and may be large (call.c). */

enum { SORT_MOST_BYTES = 32 }; /* of one item */

/* Heap sort (Williams 1964): in place, O(n log n) whatever the input; the same order everywhere
 * where less tells any two apart. */
void norma_core_sort(
    void *items, size_t count, size_t size, int (*less)(const void *a, const void *b));

/* Ascending, without further memory, O(n). */
void norma_core_sort_numbers(uint64_t *numbers, size_t count);

/* ---- one call of the library: the caller's options made whole, its memory, its threads, its
 * progress. */

typedef struct core_team core_team;
typedef struct core_call {
    norma_options options; /* every field valid; absent ones at their defaults */
    size_t workers;        /* 0: not settled yet */
    core_level level;      /* of the kernels, by options.isa */
    double progress_from, progress_to,
        progress_told; /* the stage that runs now covers this part of the whole */
    int cancelled;
    core_team *team; /* threads that stay; or NULL */
} core_call;

/* ARGUMENT where an option is out of its range; options and fault may be NULL. */
norma_result norma_core_check_options(const norma_options *options, norma_fault *fault);
norma_result norma_core_begin(core_call *call, const norma_options *options);

/* Whether weights are those of the most visible normal, and whether a distance welds. */
static inline int norma_core_sees(const core_call *call) {
    return !CORE_IS_SMALL && call->options.weight == NORMA_WEIGHT_VISIBLE;
}
static inline int norma_core_welds_near(const core_call *call) {
    return !CORE_IS_SMALL && call->options.weld == NORMA_WELD_DISTANCE;
}

/* Scratch memory from the caller's allocator, aligned for any type; NULL when memory runs out or
 * count * size overflows. */
void *norma_core_allocate(const core_call *call, size_t count, size_t size);
void norma_core_release(const core_call *call, void *block, size_t count,
    size_t size); /* the same count and size; NULL is fine */

/* What it gives where the caller has no allocator; free releases it. */
void *norma_core_default_block(size_t bytes);

/* Later stages report between their own two fractions. Nonzero: the caller wants to stop. */
void norma_core_stage(core_call *call, double from, double to);
int norma_core_progress(core_call *call, double fraction_of_stage);

/* The result of a call that has done its work: a caller who is told that all is done may still
 * cancel. */
norma_result norma_core_finish(core_call *call, norma_result result);

/* threads.c: how many may work, where the caller has no parallel_for: at least 1. To begin a
 * thread, and with NORMA_ALL_THREADS to ask the system, takes longer than the normals of some
 * thousand corners: so a call says first how many there are, and few are for the calling thread
 * alone. */
void norma_core_share(core_call *call, size_t corners);
size_t norma_core_workers(const core_call *call);
/* Into how many parts work is divided that each of them must have one of: as many as may work, and
 * for the caller's jobs as many as the machine has cores, but at least eight. */
size_t norma_core_shares(const core_call *call);

/* Runs task for each index below count: by the caller's parallel_for, by threads, or here. Tasks
 * share nothing but what they only read, and what is atomic. Returns NORMA_OK or NORMA_CANCELLED
 * (then some tasks did not run). */
norma_result norma_core_parallel(core_call *call, size_t count, norma_task *task, void *context);

/* Threads for all steps between the two; without them each step begins its own. */
void norma_core_gather(core_call *call);
void norma_core_dismiss(core_call *call);

/* ---- the caller's normals, reasons and report: checked before anything is written, written once,
 * never read. */

typedef struct core_output {
    unsigned char *normals; /* NULL: only counted (norma_split) */
    size_t stride;
    uint8_t *reasons;
    float fallback[3]; /* what an element without a normal gets, but for the nearest */
    int nearest;
} core_output;

typedef struct core_tally {
    norma_count non_finite, unreferenced, cancelled, degenerate;
} core_tally;

/* ARGUMENT, CAPACITY or OVERFLOW where count normals cannot go to normals. */
norma_result norma_core_output_open(
    const core_call *call, float *normals, size_t count, size_t capacity, core_output *output);

static inline void norma_core_write_normal(
    const core_output *output, size_t index, const float normal[3]) {
    memcpy(output->normals + index * output->stride, normal, 3 * sizeof(float));
}
/* Of count elements in a row, all with a normal of their own. */
static inline void norma_core_write_normals(
    const core_output *output, size_t first, size_t count, const float (*normals)[3]) {
    if (output->stride == 3 * sizeof(float))
        memcpy(output->normals + first * output->stride, normals, count * sizeof *normals);
    else
        for (size_t i = 0; i < count; ++i) norma_core_write_normal(output, first + i, normals[i]);
    if (output->reasons) memset(output->reasons + first, NORMA_REASON_NONE, count);
}
/* Writes the normal of an element that has one, or the fallback (not the nearest, which is written
 * later), and its reason; counts what has none. */
void norma_core_write_element(
    const core_output *output, size_t index, int reason, const float normal[3], core_tally *tally);

/* threads.c: elements below count are written, so many in a chunk; sum: what all chunks counted is
 * added. */
typedef void core_write_chunk(const void *context, size_t begin, size_t end, core_tally *tally);
norma_result norma_core_write_chunks(core_call *call, size_t count, size_t in_chunk,
    core_write_chunk *write, const void *context, core_tally *sum);

/* Of any scale, to a unit vector of floats, never -0. */
void norma_core_direction(const double direction[3], float normal[3]);
/* What is left of a sum must be more than rounding: 2^-20 of the weights that were put in. */
int norma_core_cancels(const double sum[3], double weight);

void norma_core_tally(core_tally *tally, int reason, size_t index);
void norma_core_tally_add(core_tally *sum, const core_tally *part);
/* Sets what the counts say; the firsts of empty counts become SIZE_MAX. report may be NULL. */
void norma_core_write_report(norma_report *report, const core_tally *tally,
    const norma_count *non_manifold, const norma_count *conflicts);
#endif
