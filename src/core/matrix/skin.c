/* skin.c: positions, normals and tangents of vertices that several joints move.
 *
 * Each vertex has a matrix of its own, B: the joints' matrices, weighted and added up in double
 * precision in ascending order of influence. Positions and tangents go through B, normals through
 * sign(det B) cof(B): the blend's normal matrix, not the blend of normal matrices. This file checks
 * what is given and shares the vertices among threads; skin_block.c moves them. */
#include "core/matrix/matrix.h"

enum {
    CHUNK = 4096, /* vertices of one task */
    CACHE_LINE = 64,
    TANGENT_BYTES = 4 * sizeof(float),
    JOINT_BYTES = (SKIN_ROW + 8) * sizeof(double)
};

/* ---- what is given */

static norma_result check_sizes(const norma_skin *s, norma_fault *fault) {
    const norma_result wrong = NORMA_ERROR_ARGUMENT;
    if (!s) return norma_core_refuse(fault, wrong, "skin", SIZE_MAX, "a skin");
    if (s->influences < 1 || s->influences > SKIN_MOST_INFLUENCES)
        return norma_core_refuse(fault, wrong, "skin->influences", SIZE_MAX, "1 to 64");
    if (s->joint_size && s->joint_size != 1 && s->joint_size != 2 && s->joint_size != 4)
        return norma_core_refuse(fault, wrong, "skin->joint_size", SIZE_MAX, "0, 1, 2 or 4");
    if (s->blend != NORMA_BLEND_LINEAR && s->blend != NORMA_BLEND_DUAL_QUATERNION)
        return norma_core_refuse(fault, wrong, "skin->blend", SIZE_MAX, "a norma_blend");
    if (s->vertex_count > SIZE_MAX / (64 * sizeof(double)))
        return norma_core_refuse(fault, NORMA_ERROR_OVERFLOW, "skin->vertex_count", SIZE_MAX,
            "fewer vertices than bytes can be counted");
    if (s->joint_count > SIZE_MAX / JOINT_BYTES - 1)
        return norma_core_refuse(fault, NORMA_ERROR_OVERFLOW, "skin->joint_count", SIZE_MAX,
            "fewer joints than bytes can be counted");
    if (!s->vertex_count) return NORMA_OK;
    if (s->joint_count && !s->matrices)
        return norma_core_refuse(fault, wrong, "skin->matrices", SIZE_MAX, "joint_count matrices");
    if (!s->joints)
        return norma_core_refuse(fault, wrong, "skin->joints", SIZE_MAX, "joints of each vertex");
    if (!s->weights)
        return norma_core_refuse(fault, wrong, "skin->weights", SIZE_MAX, "weights of each vertex");
    return NORMA_OK;
}

static int is_finite_matrix(const float m[16]) {
    float zero = 0.0F;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 3; ++r) zero += m[4 * c + r] * 0.0F;
    return zero == 0.0F;
}

/* The largest of count numbers of 1, 2 or 4 bytes: loops that compilers make vector code
 * of. */
CORE_INLINE uint32_t largest_joint(const void *joints, size_t size, size_t count) {
    uint32_t most = 0;
    if (size == sizeof(uint16_t)) {
        const unsigned char *at = joints;
        uint16_t largest = 0, number;
        for (size_t i = 0; i < count; ++i) {
            memcpy(&number, at + i * sizeof number, sizeof number);
            largest = number > largest ? number : largest;
        }
        return largest;
    }
    for (size_t i = 0; i < count; ++i) {
        const uint32_t number = norma_index_read(joints, size, i);
        most = number > most ? number : most;
    }
    return most;
}

/* Whether all are finite: an exponent of ones, and one more, is a sign. */
CORE_INLINE int all_numbers_finite(const float *numbers, size_t count) {
    uint32_t signs = 0;
    for (size_t i = 0; i < count; ++i) {
        uint32_t bits;
        memcpy(&bits, numbers + i, sizeof bits);
        signs |= (bits & UINT32_C(0x7fffffff)) + UINT32_C(0x00800000);
    }
    return !(signs >> 31);
}

/* Whether all joints exist and all weights are finite. */
CORE_INLINE int influences_in_c(const norma_skin *s, size_t size) {
    const size_t count = s->vertex_count * s->influences;
    return largest_joint(s->joints, size, count) < s->joint_count &&
           all_numbers_finite(s->weights, count);
}

static int influences_portable(const norma_skin *s, size_t size) {
    return influences_in_c(s, size);
}
#if defined(CORE_HAS_X86)
CORE_FOR_AVX2 static int influences_avx2(const norma_skin *s, size_t size) {
    return influences_in_c(s, size);
}
#endif

static norma_result check_influences(const norma_skin *s, norma_isa isa, norma_fault *fault) {
    static int (*const kernels[])(const norma_skin *, size_t) = CORE_KERNELS_TO_AVX2(influences);
    const size_t size = s->joint_size ? s->joint_size : 2;
    size_t i = 0;
    if (kernels[norma_core_level(isa)](s, size)) return NORMA_OK;
    for (const size_t count = s->vertex_count * s->influences; i < count; ++i)
        if (norma_index_read(s->joints, size, i) >= s->joint_count)
            return norma_core_refuse(fault, NORMA_ERROR_INDEX, "skin->joints", i,
                "the number of a joint, below skin->joint_count");
    for (i = 0; s->weights[i] * 0.0F == 0.0F;) ++i;
    return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "skin->weights", i, "a finite number");
}

/* Only the matrices of joints that weigh something have to be finite. */
static norma_result check_matrices(const norma_skin *s, norma_fault *fault) {
    size_t broken = 0;
    for (size_t j = 0; j < s->joint_count; ++j) broken += !is_finite_matrix(s->matrices + 16 * j);
    if (!broken) return NORMA_OK;
    const size_t count = s->vertex_count * s->influences, size = s->joint_size ? s->joint_size : 2;
    for (size_t i = 0; i < count; ++i) {
        const uint32_t joint = norma_index_read(s->joints, size, i);
        if (s->weights[i] != 0.0F && !is_finite_matrix(s->matrices + 16 * (size_t)joint))
            return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "skin->matrices", joint,
                "twelve finite numbers, since a vertex uses it");
    }
    return NORMA_OK;
}

static norma_result check_skin(const norma_skin *skin, norma_isa isa, norma_fault *fault) {
    norma_result result = check_sizes(skin, fault);
    if (!result && skin->vertex_count) result = check_influences(skin, isa, fault);
    if (!result && skin->vertex_count) result = check_matrices(skin, fault);
    return result;
}

norma_result norma_find_skin_fault(
    const norma_skin *skin, const norma_options *options, norma_fault *fault) {
    norma_core_refuse(fault, NORMA_OK, NULL, SIZE_MAX, NULL);
    const norma_result result = norma_core_check_options(options, fault);
    return !result ? check_skin(skin, NORMA_ISA_BEST, fault) : result;
}

/* ---- joints, and tasks */

static void prepare_joint(
    const float matrix[16], norma_blend blend, double row[SKIN_ROW], double dual[8]) {
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 3; ++r) row[3 * c + r] = (double)matrix[4 * c + r];
    if (blend == NORMA_BLEND_DUAL_QUATERNION) norma_skin_prepare_dual(row, dual);
    for (int i = 0; i < 9; ++i)
        if (row[SKIN_SIZE] < fabs(row[i])) row[SKIN_SIZE] = fabs(row[i]);
}

static void run_chunk(void *context, size_t index) {
    const skin_stream *s = context;
    const size_t begin = index * CHUNK, left = s->skin->vertex_count - begin;
    norma_skin_move(s, begin, left < CHUNK ? left : CHUNK, s->tallies ? &s->tallies[index] : NULL);
}

static size_t chunk_count(const skin_stream *s) {
    return (s->skin->vertex_count + CHUNK - 1) / CHUNK;
}

/* Everything that can be refused, before anything is written. */
static norma_result open_skin_stream(skin_stream *s, const norma_options *options,
    const norma_vec3_view *in, float *out, size_t capacity) {
    norma_result result = norma_core_begin(&s->call, options);
    if (!result) result = check_skin(s->skin, s->call.options.isa, NULL);
    if (!result && s->call.options.fallback == NORMA_FALLBACK_NEAREST)
        result = NORMA_ERROR_ARGUMENT;
    if (!result) result = norma_input_check(in);
    if (!result && in->count < s->skin->vertex_count) result = NORMA_ERROR_ARGUMENT;
    if (!result)
        result = norma_core_output_open(&s->call, out, s->skin->vertex_count, capacity, &s->out);
    if (result) return result;
    s->in = *in;
    s->joints = s->skin->joints;
    s->joint_size = s->skin->joint_size ? s->skin->joint_size : sizeof(uint16_t);
    s->influences = s->skin->influences;
    return NORMA_OK;
}

static norma_result run_stream(skin_stream *s) {
    const norma_skin *skin = s->skin;
    /* One more, so that rows begin with a cache line. */
    unsigned char *memory = norma_core_allocate(&s->call, skin->joint_count + 1, JOINT_BYTES);
    if (!memory) return NORMA_ERROR_MEMORY;
    double(*rows)[SKIN_ROW] = (void *)(memory + (CACHE_LINE - (uintptr_t)memory % CACHE_LINE)),
    (*duals)[8] = (void *)(rows + skin->joint_count);
    memset(rows, 0, skin->joint_count * JOINT_BYTES);
    for (size_t j = 0; j < skin->joint_count; ++j) {
        if (is_finite_matrix(skin->matrices + 16 * j))
            prepare_joint(skin->matrices + 16 * j, skin->blend, rows[j], duals[j]);
        if (s->largest < rows[j][SKIN_SIZE]) s->largest = rows[j][SKIN_SIZE];
    }
    s->rows = rows;
    s->duals = duals;
    norma_core_share(&s->call, 3 * skin->vertex_count);
    const norma_result result = norma_core_parallel(&s->call, chunk_count(s), run_chunk, s);
    norma_core_release(&s->call, memory, skin->joint_count + 1, JOINT_BYTES);
    return norma_core_finish(&s->call, result);
}

norma_result norma_skin_positions(const norma_skin *skin, norma_vec3_view in,
    const norma_options *options, float *out, size_t capacity) {
    skin_stream s = {.skin = skin};
    const norma_result result = open_skin_stream(&s, options, &in, out, capacity);
    return result || !skin->vertex_count ? result : run_stream(&s);
}

norma_result norma_skin_normals(const norma_skin *skin, norma_vec3_view in,
    const norma_options *options, float *out, size_t capacity, norma_report *report) {
    skin_stream s = {.skin = skin};
    core_tally sum = {.non_finite = {0, 0}};
    norma_result result = open_skin_stream(&s, options, &in, out, capacity);
    if (result) return result;
    if (skin->vertex_count) {
        s.tallies = norma_core_allocate(&s.call, chunk_count(&s), sizeof *s.tallies);
        if (!s.tallies) return NORMA_ERROR_MEMORY;
        memset(s.tallies, 0, chunk_count(&s) * sizeof *s.tallies);
        result = run_stream(&s);
        for (size_t i = 0; i < chunk_count(&s); ++i) norma_core_tally_add(&sum, &s.tallies[i]);
        norma_core_release(&s.call, s.tallies, chunk_count(&s), sizeof *s.tallies);
    }
    if (!result) norma_core_write_report(report, &sum, NULL, NULL);
    return result;
}

norma_result norma_skin_tangents(const norma_skin *skin, const float *in,
    norma_vec3_view skinned_normals, const norma_options *options, float *out, size_t capacity) {
    skin_stream s = {.skin = skin, .tangents = in};
    norma_result result = open_skin_stream(&s, options, &skinned_normals, out, capacity);
    if (result || !skin->vertex_count) return result;
    if (options && options->normal_stride && options->normal_stride < TANGENT_BYTES)
        return NORMA_ERROR_ARGUMENT;
    if (!in) return NORMA_ERROR_ARGUMENT;
    if (!options || !options->normal_stride) s.out.stride = TANGENT_BYTES;
    if (skin->vertex_count > SIZE_MAX / s.out.stride) return NORMA_ERROR_OVERFLOW;
    return run_stream(&s);
}
