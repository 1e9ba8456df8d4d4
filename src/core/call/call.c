/* call.c: options checked once, so that nothing behind needs to ask again. */
#define _DEFAULT_SOURCE /* madvise */
#include "core/call/call.h"
#include "core/call/fault.h"
#include "core/call/vec3_view.h"
#include <math.h>
#include <stdlib.h>
#if defined(__linux__)
#include <sys/mman.h>
#endif

/* A caller built against a later header may not ask for what this library does not know. */
static int has_unknown_fields(const norma_options *options) {
    const unsigned char *bytes = (const unsigned char *)options;
    for (size_t i = sizeof(norma_options); i < options->struct_size; i++)
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
    for (size_t k = 0; k < 3 && o->fallback == NORMA_FALLBACK_GIVEN; k++)
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
    return result == NORMA_OK ? check_resources(options, fault) : result;
}

norma_result norma_core_begin(core_call *call, const norma_options *options) {
    *call = (core_call){0};
    const norma_result result = norma_core_check_options(options, NULL);
    if (result != NORMA_OK) return result;
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
    if (call->options.allocator.allocate)
        return call->options.allocator.allocate(
            call->options.allocator.user, bytes, SCRATCH_ALIGNMENT);
    return norma_core_default_block(bytes);
}

void norma_core_release(const core_call *call, void *block, size_t count, size_t size) {
    if (!block) return;
    if (call->options.allocator.release)
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
    return result == NORMA_OK && norma_core_progress(call, 1) ? NORMA_CANCELLED : result;
}
