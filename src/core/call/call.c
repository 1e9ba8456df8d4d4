/* call.c: options checked once, so that nothing behind needs to ask again. */
#define _DEFAULT_SOURCE /* madvise */
#include "core/call/call.h"
#include <math.h>
#include <stdlib.h>

#if defined(__linux__)
#include <sys/mman.h>
#endif

/* A caller built against a later header may not ask for what this library does not know. */
static int has_unknown_fields(const norma_options *options) {
    const unsigned char *bytes = (const unsigned char *)options;
    for (size_t i = sizeof(norma_options); i < options->struct_size; ++i)
        if (bytes[i]) return 1;
    return 0;
}

static norma_result refuse_option(norma_fault *fault, const char *argument, const char *expected) {
    return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, argument, SIZE_MAX, expected);
}

static norma_result check_choices(const norma_options *o, norma_fault *fault) {
    if (!norma_weight_name(o->weight))
        return refuse_option(fault, "options->weight", "a norma_weight");
    if (o->weld < NORMA_WELD_EXACT || o->weld > NORMA_WELD_DISTANCE)
        return refuse_option(fault, "options->weld", "a norma_weld");
    if (o->weld == NORMA_WELD_DISTANCE && !(o->weld_distance >= 0))
        return refuse_option(fault, "options->weld_distance", "0 or more");
    if (o->non_manifold < NORMA_NON_MANIFOLD_HARD || o->non_manifold > NORMA_NON_MANIFOLD_SMOOTH)
        return refuse_option(fault, "options->non_manifold", "a norma_non_manifold");
    if (o->fallback < NORMA_FALLBACK_ZERO || o->fallback > NORMA_FALLBACK_GIVEN)
        return refuse_option(fault, "options->fallback", "a norma_fallback");
    for (size_t k = 0; k < 3 && o->fallback == NORMA_FALLBACK_GIVEN; ++k)
        if (!isfinite(o->fallback_normal[k]))
            return norma_core_refuse(
                fault, NORMA_ERROR_ARGUMENT, "options->fallback_normal", k, "a finite number");
    return NORMA_OK;
}

static norma_result check_resources(const norma_options *o, norma_fault *fault) {
    if (o->normal_stride && o->normal_stride < 3 * sizeof(float))
        return refuse_option(fault, "options->normal_stride", "0, or at least 12 bytes");
    if (!o->allocator.allocate != !o->allocator.release)
        return refuse_option(fault, "options->allocator", "both functions, or neither");
    if (!norma_core_has_isa(o->isa))
        return refuse_option(fault, "options->isa", "an instruction set that this machine has");
    return NORMA_OK;
}

enum { FIRST_VERSION = offsetof(norma_options, edges) };

static size_t size_of(const norma_options *options) {
    return options->struct_size ? options->struct_size : FIRST_VERSION;
}

norma_result norma_core_check_options(const norma_options *options, norma_fault *fault) {
    if (!options) return NORMA_OK;
    if (size_of(options) < FIRST_VERSION)
        return refuse_option(fault, "options->struct_size", "sizeof(norma_options), or 0");
    if (has_unknown_fields(options))
        return refuse_option(fault, "options->struct_size",
            "0 in all bytes that this version of the library does not know");
    const norma_result result = check_choices(options, fault);
    return !result ? check_resources(options, fault) : result;
}

norma_result norma_core_begin(core_call *call, const norma_options *options) {
    *call = (core_call){0};
    const norma_result result = norma_core_check_options(options, NULL);
    if (result) return result;
    if (options)
        memcpy(&call->options, options,
            size_of(options) < sizeof(norma_options) ? size_of(options) : sizeof(norma_options));
    if (!call->options.normal_stride) call->options.normal_stride = 3 * sizeof(float);
    call->level = norma_core_level(call->options.isa);
    norma_core_stage(call, 0, 1);
    return NORMA_OK;
}

enum { SCRATCH_ALIGNMENT = 64, LARGE_BLOCK = 1 << 22 };

/* Never zero, so that a block of nothing is a block. */
static size_t block_size(size_t count, size_t size) { return count && size ? count * size : 1; }

/* Scratch of large meshes is read and written in no order that a page of 4 KiB suits: where the
 * system has larger ones, fewer of them are faulted in and looked up. */
#if defined(__linux__)
static void *allocate_large(size_t bytes) {
    const size_t page = (size_t)1 << 21,
                 rounded = bytes > SIZE_MAX - page ? 0 : (bytes + page - 1) / page * page;
    void *block = rounded ? aligned_alloc(page, rounded) : NULL;
    if (block) (void)madvise(block, rounded, MADV_HUGEPAGE);
    return block;
}
#else
static void *allocate_large(size_t bytes) { return malloc(bytes); }
#endif

void *norma_core_default_block(size_t bytes) {
    return bytes >= LARGE_BLOCK ? allocate_large(bytes) : malloc(bytes);
}

void *norma_core_allocate(const core_call *call, size_t count, size_t size) {
    if (count && size > SIZE_MAX / count) return NULL;
    const size_t bytes = block_size(count, size);
    if (!CORE_IS_SMALL && call->options.allocator.allocate)
        return call->options.allocator.allocate(
            call->options.allocator.user, bytes, SCRATCH_ALIGNMENT);
    return norma_core_default_block(bytes);
}

void norma_core_release(const core_call *call, void *block, size_t count, size_t size) {
    if (!block) return;
    if (!CORE_IS_SMALL && call->options.allocator.release)
        call->options.allocator.release(
            call->options.allocator.user, block, block_size(count, size));
    else
        free(block);
}

void norma_core_stage(core_call *call, double from, double to) {
    call->progress_from = from;
    call->progress_to = to;
}

int norma_core_progress(core_call *call, double fraction_of_stage) {
    if (CORE_IS_SMALL) return 0;
    if (!call->options.progress || call->cancelled) return call->cancelled;
    double fraction =
        call->progress_from + (call->progress_to - call->progress_from) * fraction_of_stage;
    if (fraction < call->progress_told) fraction = call->progress_told;
    call->progress_told = fraction;
    if (call->options.progress(call->options.progress_user, fraction)) call->cancelled = 1;
    return call->cancelled;
}

norma_result norma_core_finish(core_call *call, norma_result result) {
    norma_core_stage(call, 1, 1);
    return !result && norma_core_progress(call, 1) ? NORMA_CANCELLED : result;
}

/* ---- what the machine can run, asked of the processor, not of the compiler. */

#if defined(CORE_HAS_X86)
static int has_x86(norma_isa isa) {
    __builtin_cpu_init();
    if (isa == NORMA_ISA_SSE2) return __builtin_cpu_supports("sse2") != 0;
    if (isa == NORMA_ISA_AVX2) return __builtin_cpu_supports("avx2") != 0;
#if defined(CORE_HAS_AVX512)
    if (isa == NORMA_ISA_AVX512)
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512vl");
#endif
    return 0;
}
#endif

int norma_core_has_isa(norma_isa isa) {
    if (isa == NORMA_ISA_BEST || isa == NORMA_ISA_PORTABLE) return 1;
#if defined(CORE_HAS_X86)
    return has_x86(isa);
#elif defined(__x86_64__)
    return isa == NORMA_ISA_SSE2;
#elif defined(__aarch64__)
    return isa == NORMA_ISA_NEON;
#elif defined(__wasm_simd128__)
    return isa == NORMA_ISA_SIMD128;
#else
    return 0;
#endif
}

core_level norma_core_level(norma_isa isa) {
#if defined(CORE_HAS_X86)
    if (isa == NORMA_ISA_PORTABLE || isa == NORMA_ISA_SSE2)
        return CORE_PORTABLE; /* SSE2 is what portable code compiles to on this family */
    if (isa != NORMA_ISA_AVX2 && norma_core_has_isa(NORMA_ISA_AVX512)) return CORE_AVX512;
    if (norma_core_has_isa(NORMA_ISA_AVX2)) return CORE_AVX2;
#endif
    (void)isa;
    return CORE_PORTABLE;
}

/* ---- the text of every result, in one place, the names of weights, and the version. */

#define TEXT_OF(number)              #number
#define VERSION(major, minor, patch) TEXT_OF(major) "." TEXT_OF(minor) "." TEXT_OF(patch)

const char *norma_result_text(norma_result result) {
    switch (result) {
    case NORMA_OK:
        return "Done.";
    case NORMA_CANCELLED:
        return "Cancelled by the progress callback.";
    case NORMA_ERROR_ARGUMENT:
        return "An argument is missing, not a number, out of its range, or contradicts another.";
    case NORMA_ERROR_CAPACITY:
        return "An output buffer is too small for what would be written.";
    case NORMA_ERROR_INDEX:
        return "A corner names a position that does not exist.";
    case NORMA_ERROR_MEMORY:
        return "Memory could not be allocated.";
    case NORMA_ERROR_OVERFLOW:
        return "Counts times strides exceed the range of size_t.";
    }
    return "Unknown result code.";
}

#define NAME_OF(constant, name, by, formula, unused)                                               \
    case NORMA_WEIGHT_##constant:                                                                  \
        return name;

const char *norma_weight_name(norma_weight weight) {
    switch (weight) { CORE_WEIGHTS(NAME_OF, ) }
    return NULL;
}

const char *norma_version(void) {
    return VERSION(NORMA_VERSION_MAJOR, NORMA_VERSION_MINOR, NORMA_VERSION_PATCH);
}

uint32_t norma_version_number(void) { return NORMA_VERSION; }

/* ---- one place for what reaches the caller. */

norma_result norma_core_output_open(
    const core_call *call, float *normals, size_t count, size_t capacity, core_output *output) {
    const norma_options *o = &call->options;
    *output = (core_output){.normals = (unsigned char *)normals,
        .stride = o->normal_stride,
        .reasons = o->reasons,
        .nearest = o->fallback == NORMA_FALLBACK_NEAREST};
    for (int k = 0; k < 3 && o->fallback == NORMA_FALLBACK_GIVEN; ++k)
        output->fallback[k] = o->fallback_normal[k] + 0.0F; /* no -0 */
    if (count && !normals) return NORMA_ERROR_ARGUMENT;
    if (count > capacity) return NORMA_ERROR_CAPACITY;
    return count && count > SIZE_MAX / o->normal_stride ? NORMA_ERROR_OVERFLOW : NORMA_OK;
}

void norma_core_direction(const double direction[3], float normal[3]) {
    double unit[3];
    norma_core_normalise(direction, unit);
    for (int k = 0; k < 3; ++k) normal[k] = (float)unit[k] + 0.0F;
}

int norma_core_cancels(const double sum[3], double weight) {
    return norma_core_length(sum) <= 0x1p-20 * weight;
}

void norma_core_tally(core_tally *tally, int reason, size_t index) {
    if (reason == NORMA_REASON_NON_FINITE) norma_core_count_one(&tally->non_finite, index);
    if (reason == NORMA_REASON_UNREFERENCED) norma_core_count_one(&tally->unreferenced, index);
    if (reason == NORMA_REASON_CANCELLED) norma_core_count_one(&tally->cancelled, index);
    if (reason == NORMA_REASON_DEGENERATE) norma_core_count_one(&tally->degenerate, index);
}

void norma_core_write_element(
    const core_output *output, size_t index, int reason, const float normal[3], core_tally *tally) {
    if (reason == NORMA_REASON_NONE)
        norma_core_write_normal(output, index, normal);
    else if (!output->nearest)
        norma_core_write_normal(output, index, output->fallback);
    if (output->reasons) output->reasons[index] = (uint8_t)reason;
    norma_core_tally(tally, reason, index);
}

void norma_core_tally_add(core_tally *sum, const core_tally *part) {
    norma_core_count_add(&sum->non_finite, &part->non_finite);
    norma_core_count_add(&sum->unreferenced, &part->unreferenced);
    norma_core_count_add(&sum->cancelled, &part->cancelled);
    norma_core_count_add(&sum->degenerate, &part->degenerate);
}

static norma_count reported_count(const norma_count *count) {
    return count && count->count ? *count : (norma_count){0, SIZE_MAX};
}

void norma_core_write_report(norma_report *report, const core_tally *tally,
    const norma_count *non_manifold, const norma_count *conflicts) {
    if (!report) return;
    *report = (norma_report){
        .degenerate_faces = reported_count(&tally->degenerate),
        .non_finite = reported_count(&tally->non_finite),
        .unreferenced = reported_count(&tally->unreferenced),
        .cancelled = reported_count(&tally->cancelled),
        .non_manifold_edges = reported_count(non_manifold),
        .winding_conflicts = reported_count(conflicts),
    };
}

/* ---- lengths and directions of any scale: what squares of doubles cannot hold is brought near 1
 * first, by an exact power of two. */

double norma_core_length(const double v[3]) {
    const double square = norma_core_dot(v, v);
    if (square > NORMA_TINIEST && square < NORMA_HUGEST) return sqrt(square);
    const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
    if (!(largest > 0) || largest > 0x1.fffffffffffffp1023) return largest;
    const int exponent = ilogb(largest);
    const double scaled[3] = {
        ldexp(v[0], -exponent), ldexp(v[1], -exponent), ldexp(v[2], -exponent)};
    return ldexp(sqrt(norma_core_dot(scaled, scaled)), exponent);
}

void norma_core_normalise(const double v[3], double unit[3]) {
    double scaled[3] = {v[0], v[1], v[2]};
    const double square = norma_core_dot(v, v);
    if (!(square > NORMA_TINIEST && square < NORMA_HUGEST)) {
        const double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
        if (!(largest > 0)) {
            unit[0] = unit[1] = unit[2] = 0;
            return;
        }
        const int exponent = ilogb(largest);
        for (int k = 0; k < 3; ++k) scaled[k] = ldexp(v[k], -exponent);
    }
    const double inverse =
        1 / sqrt(norma_core_dot(scaled, scaled)); /* as the kernel that makes eight at once */
    for (int k = 0; k < 3; ++k) unit[k] = scaled[k] * inverse;
}

/* ---- sorting: the library's own, since qsort may allocate, and orders equals as it likes. */

typedef struct heap {
    unsigned char *items;
    size_t size;
    int (*less)(const void *a, const void *b);
} heap;

static unsigned char *item(const heap *h, size_t index) { return h->items + index * h->size; }

static void swap_items(const heap *h, size_t a, size_t b) {
    unsigned char held[SORT_MOST_BYTES];
    memcpy(held, item(h, a), h->size);
    memcpy(item(h, a), item(h, b), h->size);
    memcpy(item(h, b), held, h->size);
}

static void sift(const heap *h, size_t at, size_t count) {
    for (size_t child; (child = 2 * at + 1) < count; at = child) {
        if (child + 1 < count && h->less(item(h, child), item(h, child + 1))) ++child;
        if (!h->less(item(h, at), item(h, child))) return;
        swap_items(h, at, child);
    }
}

void norma_core_sort(
    void *items, size_t count, size_t size, int (*less)(const void *a, const void *b)) {
    const heap h = {items, size, less};
    for (size_t i = count / 2; i-- > 0;) sift(&h, i, count);
    for (size_t end = count; end > 1; --end) {
        swap_items(&h, 0, end - 1);
        sift(&h, 0, end - 1);
    }
}

/* ---- numbers: dealt by the highest byte in which any two differ, in place,
 * and each part again (McIlroy, Bostic, McIlroy 1993, American flag sort) */

enum { FEW_NUMBERS = 24, BYTE_VALUES = 256 };

static void sort_few_numbers(uint64_t *numbers, size_t count) {
    for (size_t i = 1; i < count; ++i) {
        const uint64_t moved = numbers[i];
        size_t at = i;
        for (; at > 0 && moved < numbers[at - 1]; --at) numbers[at] = numbers[at - 1];
        numbers[at] = moved;
    }
}

/* The bits in which they differ; 0 where they are in order already. */
static uint64_t disorder(const uint64_t *numbers, size_t count) {
    uint64_t differ = 0;
    int ordered = 1;
    for (size_t i = 1; i < count; ++i) {
        differ |= numbers[i] ^ numbers[0];
        ordered &= numbers[i - 1] < numbers[i];
    }
    return ordered ? 0 : differ;
}

static size_t byte_of(uint64_t number, int shift) {
    return (size_t)(number >> shift) & (BYTE_VALUES - 1);
}

static void deal(uint64_t *numbers, size_t count, int shift, uint32_t ends[BYTE_VALUES]) {
    uint32_t next[BYTE_VALUES], sum = 0;
    memset(ends, 0, BYTE_VALUES * sizeof *ends);
    for (size_t i = 0; i < count; ++i) ++ends[byte_of(numbers[i], shift)];
    for (size_t value = 0; value < BYTE_VALUES; ++value) {
        next[value] = sum;
        ends[value] = sum += ends[value];
    }
    for (size_t value = 0; value < BYTE_VALUES; ++value)
        while (next[value] < ends[value]) {
            const uint64_t number = numbers[next[value]];
            const size_t to = byte_of(number, shift);
            numbers[next[value]] = numbers[next[to]];
            numbers[next[to]++] = number;
        }
}

/* Eight deep at most, as each is about a lower byte. */
void norma_core_sort_numbers(uint64_t *numbers, size_t count) {
    uint32_t ends[BYTE_VALUES], begin = 0;
    if (count <= FEW_NUMBERS) {
        sort_few_numbers(numbers, count);
        return;
    }
    const uint64_t differ = disorder(numbers, count);
    int shift = 56;
    if (!differ) return;
    while (!byte_of(differ, shift)) shift -= 8;
    deal(numbers, count, shift, ends);
    for (size_t value = 0; value < BYTE_VALUES && shift; begin = ends[value++])
        if (ends[value] - begin > 1) norma_core_sort_numbers(numbers + begin, ends[value] - begin);
}
