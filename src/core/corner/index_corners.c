/* index_corners.c: norma_index_corners. Corners whose values agree are found by hashes of their
 * bytes; the first of them stands for all, and new vertices are numbered in the order of firsts. */
#include "core/corner/corner.h"
#include "core/call/call.h"
#include "core/mesh/mesh.h"
#include <string.h>

enum { MOST_WITH_16_BITS = 65535 };

size_t norma_index_size(size_t vertex_count) { return vertex_count <= MOST_WITH_16_BITS ? 2 : 4; }

/* ---- what is given */

static norma_result check_stream(
    const norma_stream *s, size_t number, size_t corner_count, norma_fault *fault) {
    const size_t stride = s->stride ? s->stride : s->size;
    if (!s->size)
        return norma_core_refuse(
            fault, NORMA_ERROR_ARGUMENT, "streams->size", number, "at least one byte");
    if (s->count && !s->data)
        return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "streams->data", number,
            "an array of streams->count values");
    if (s->count && (s->count - 1 > (SIZE_MAX - s->size) / stride))
        return norma_core_refuse(fault, NORMA_ERROR_OVERFLOW, "streams->count", number,
            "fewer values than bytes can be counted");
    if (!s->corners && s->count < corner_count)
        return norma_core_refuse(fault, NORMA_ERROR_ARGUMENT, "streams->count", number,
            "at least a value for each corner");
    return NORMA_OK;
}

static norma_result check_indices(const norma_stream *s, size_t corner_count, norma_fault *fault) {
    for (size_t c = 0; s->corners && c < corner_count; ++c)
        if (s->corners[c] >= s->count)
            return norma_core_refuse(fault, NORMA_ERROR_INDEX, "streams->corners", c,
                "the number of a value, below streams->count");
    return NORMA_OK;
}

static norma_result core_check_streams(
    const norma_stream *streams, size_t stream_count, size_t corner_count, norma_fault *fault) {
    norma_result result = NORMA_OK;
    if (!streams || !stream_count)
        return norma_core_refuse(
            fault, NORMA_ERROR_ARGUMENT, "streams", SIZE_MAX, "at least one stream");
    if (corner_count >= UINT32_MAX)
        return norma_core_refuse(
            fault, NORMA_ERROR_OVERFLOW, "corner_count", SIZE_MAX, "fewer than 2^32 - 1 corners");
    for (size_t s = 0; s < stream_count && !result; ++s)
        result = check_stream(&streams[s], s, corner_count, fault);
    for (size_t s = 0; s < stream_count && !result; ++s)
        result = check_indices(&streams[s], corner_count, fault);
    return result;
}

norma_result norma_find_stream_fault(const norma_stream *streams, size_t stream_count,
    size_t corner_count, const norma_options *options, norma_fault *fault) {
    norma_core_refuse(fault, NORMA_OK, NULL, SIZE_MAX, NULL);
    const norma_result result = norma_core_check_options(options, fault);
    return !result ? core_check_streams(streams, stream_count, corner_count, fault) : result;
}

/* ---- who agrees */

typedef struct corner_values {
    const norma_stream *streams;
    size_t stream_count;
} corner_values;

static const unsigned char *value_at(const norma_stream *s, size_t corner) {
    const size_t value = s->corners ? s->corners[corner] : corner;
    return (const unsigned char *)s->data + value * (s->stride ? s->stride : s->size);
}

static uint64_t mixed(uint64_t sum, uint64_t word) {
    const uint64_t product = (sum ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    return product ^ (product >> 29);
}

static uint64_t hash_bytes(uint64_t sum, const unsigned char *bytes, size_t size) {
    uint64_t word = 0;
    size_t at = 0;
    for (; at + sizeof word <= size; at += sizeof word) {
        memcpy(&word, bytes + at, sizeof word);
        sum = mixed(sum, word);
    }
    word = 0;
    for (size_t i = at; i < size; ++i) word = word << 8 | bytes[i];
    return at < size ? mixed(sum, word) : sum;
}

static void hash_corners(const void *context, size_t first, size_t count, uint64_t *hashes) {
    const corner_values *v = context;
    for (size_t c = 0; c < count; ++c) {
        uint64_t sum = 1;
        for (size_t s = 0; s < v->stream_count; ++s)
            sum = hash_bytes(sum, value_at(&v->streams[s], first + c), v->streams[s].size);
        hashes[c] = norma_core_weld_mix(sum);
    }
}

static int same_values(const void *context, uint32_t one, uint32_t other) {
    const corner_values *v = context;
    for (size_t s = 0; s < v->stream_count; ++s) {
        const norma_stream *stream = &v->streams[s];
        if (memcmp(value_at(stream, one), value_at(stream, other), stream->size) != 0) return 0;
    }
    return 1;
}

/* ---- what is written */

static size_t count_firsts(const uint32_t *firsts, size_t corner_count) {
    size_t count = 0;
    for (size_t c = 0; c < corner_count; ++c) count += firsts[c] == c;
    return count;
}

static norma_result check_room(const norma_indexed *to, size_t corners, size_t vertices) {
    if (to->corners && to->corner_size == 2 && vertices > MOST_WITH_16_BITS)
        return NORMA_ERROR_OVERFLOW;
    if ((to->corners && to->corner_capacity < corners) ||
        (to->source_corners && to->vertex_capacity < vertices))
        return NORMA_ERROR_CAPACITY;
    return NORMA_OK;
}

/* Numbers take the place of firsts: those of earlier corners are there already. */
static void write_indexed(uint32_t *firsts, size_t corner_count, const norma_indexed *to) {
    uint32_t count = 0;
    for (size_t c = 0; c < corner_count; ++c) {
        const int is_first = firsts[c] == c;
        const uint32_t number = is_first ? count++ : firsts[firsts[c]];
        const uint16_t narrow = (uint16_t)number;
        firsts[c] = number;
        if (is_first && to->source_corners) to->source_corners[number] = (uint32_t)c;
        if (!to->corners) continue;
        if (to->corner_size == 2)
            memcpy((unsigned char *)to->corners + 2 * c, &narrow, sizeof narrow);
        else
            memcpy((unsigned char *)to->corners + 4 * c, &number, sizeof number);
    }
}

norma_result norma_core_index_corners(core_call *call, const norma_stream *streams,
    size_t stream_count, size_t corner_count, norma_indexed *to) {
    const corner_values values = {streams, stream_count};
    const weld_keys keys = {corner_count, &values, hash_corners, same_values};
    size_t found;
    if (!corner_count) {
        to->vertex_count = 0;
        return NORMA_OK;
    }
    uint32_t *firsts = norma_core_allocate(call, corner_count, sizeof *firsts);
    if (!firsts) return NORMA_ERROR_MEMORY;
    norma_result result = norma_core_weld_keys(call, &keys, firsts, &found);
    result = norma_core_finish(call, result);
    if (!result) {
        const size_t vertices = count_firsts(firsts, corner_count);
        result = check_room(to, corner_count, vertices);
        if (!result) write_indexed(firsts, corner_count, to);
        if (!result) to->vertex_count = vertices;
    }
    norma_core_release(call, firsts, corner_count, sizeof *firsts);
    return result;
}

norma_result norma_core_check_indexed(const norma_indexed *indexed) {
    return indexed && (indexed->corner_size == 0 || indexed->corner_size == 2 ||
                          indexed->corner_size == 4)
               ? NORMA_OK
               : NORMA_ERROR_ARGUMENT;
}

norma_result norma_index_corners(const norma_stream *streams, size_t stream_count,
    size_t corner_count, const norma_options *options, norma_indexed *indexed) {
    core_call call;
    norma_result result = norma_core_begin(&call, options);
    if (!result) result = norma_core_check_indexed(indexed);
    if (!result) result = core_check_streams(streams, stream_count, corner_count, NULL);
    if (result) return result;
    norma_core_share(&call, corner_count);
    norma_core_stage(&call, 0, 0.97);
    return norma_core_index_corners(&call, streams, stream_count, corner_count, indexed);
}

norma_result norma_copy_values(const norma_stream *stream, const uint32_t *sources, size_t count,
    void *out, size_t out_stride, size_t capacity) {
    if (!stream || (count && (!sources || !out))) return NORMA_ERROR_ARGUMENT;
    const size_t step = out_stride ? out_stride : stream->size;
    norma_result result = check_stream(stream, 0, 0, NULL);
    if (!result && step < stream->size) result = NORMA_ERROR_ARGUMENT;
    if (!result && count > capacity) result = NORMA_ERROR_CAPACITY;
    if (!result && count && count - 1 > (SIZE_MAX - stream->size) / step)
        result = NORMA_ERROR_OVERFLOW;
    for (size_t i = 0; i < count && !result; ++i)
        if ((stream->corners ? stream->corners[sources[i]] : sources[i]) >= stream->count)
            result = NORMA_ERROR_INDEX;
    for (size_t i = 0; i < count && !result; ++i)
        memcpy((unsigned char *)out + i * step, value_at(stream, sources[i]), stream->size);
    return result;
}
