/* meshopt_views.c: views under EXT_meshopt_compression, through meshoptimizer, both ways. Its
 * decoder asserts what it is handed, so all of that is checked here first. The filters are our own:
 * those of its releases, and of its code for one processor and the next, differ in bits. */
#include "io/gltf/gltf.h"
#include <math.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

/* The vertex codec spends at least one byte on 64, the index codecs one on 12. */
enum { LARGEST_RATIO = 64, SMALL = 1024 };

static const char *wrong_layout(const gltf_view *view) {
    const gltf_meshopt *m = &view->meshopt;
    if (m->stride == 0) return "a byteStride that is not zero";
    if (m->count > view->length / m->stride)
        return "a byteLength of at least count times byteStride";
    const size_t size = m->count * m->stride;
    if (size > SMALL && size / LARGEST_RATIO > m->length)
        return "no more elements than the compressed bytes can hold";
    if (m->mode == GLTF_MODE_ATTRIBUTES ? m->stride % 4 != 0 || m->stride > 256
                                        : m->stride != 2 && m->stride != 4)
        return "a byteStride that its mode allows";
    if (m->mode == GLTF_MODE_TRIANGLES && m->count % 3 != 0)
        return "a count that is a multiple of 3";
    if (m->filter != GLTF_FILTER_NONE && m->mode != GLTF_MODE_ATTRIBUTES)
        return "a filter only with ATTRIBUTES";
    if ((m->filter == GLTF_FILTER_OCTAHEDRAL && m->stride != 4 && m->stride != 8) ||
        (m->filter == GLTF_FILTER_QUATERNION && m->stride != 8))
        return "a byteStride that its filter allows";
    return NULL;
}

/* To the nearest whole number, halves to even ones; for less than 2^31. */
static int nearest(float x) { return (int)(((double)x + 0x3p51) - 0x3p51); }

/* The octahedral filter (Meyer et al. 2010, as EXT_meshopt_compression has it). */
static void unfold(int n[3], float most) {
    const float one = (float)n[2];
    float x = (float)n[0], y = (float)n[1];
    const float z = one - fabsf(x) - fabsf(y), below = z < 0 ? z : 0;
    x += x >= 0 ? below : -below;
    y += y >= 0 ? below : -below;
    const float length = sqrtf(x * x + (y * y + z * z)), scale = length > 0 ? most / length : 0;
    n[0] = nearest(x * scale);
    n[1] = nearest(y * scale);
    n[2] = nearest(z * scale);
}

/* Signed numbers of one byte or two, one behind the other. */
static int signed_at(const unsigned char *bytes, size_t i, int has_two) {
    int16_t two;
    if (!has_two) return (int8_t)bytes[i];
    memcpy(&two, bytes + 2 * i, sizeof two);
    return two;
}

static void decode_octahedral(const gltf_meshopt *m, unsigned char *out) {
    const int has_two = m->stride == 8;
    for (size_t i = 0; i < m->count; ++i, out += m->stride) {
        int n[3];
        for (size_t k = 0; k < 3; ++k) n[k] = signed_at(out, k, has_two);
        unfold(n, has_two ? 32767 : 127);
        for (size_t k = 0; k < 3; ++k) {
            const int16_t two = (int16_t)n[k];
            if (has_two)
                memcpy(out + 2 * k, &two, sizeof two);
            else
                out[k] = (unsigned char)n[k];
        }
    }
}

/* Unit quaternions: three numbers on the scale of the fourth, whose last two bits say which of the
 * quaternion's numbers is left out. */
static void decode_quaternions(const gltf_meshopt *m, unsigned char *out) {
    const float unit = 1 / sqrtf(2);
    for (size_t i = 0; i < m->count; ++i, out += m->stride) {
        int16_t q[4];
        memcpy(q, out, sizeof q);
        const int left_out = q[3] & 3;
        const float scale = unit / (float)(q[3] | 3);
        const float x = q[0] * scale, y = q[1] * scale, z = q[2] * scale,
                    rest = 1 - (x * x + (y * y + z * z));
        const float parts[4] = {rest > 0 ? sqrtf(rest) : 0, x, y, z};
        for (int k = 0; k < 4; ++k) q[(left_out + k) & 3] = (int16_t)nearest(parts[k] * 32767);
        memcpy(out, q, sizeof q);
    }
}

/* Each number is 24 bits times two to the power of the upper eight, both signed. */
static void decode_exponents(const gltf_meshopt *m, unsigned char *out) {
    for (size_t i = 0; i < m->count * m->stride; i += 4) {
        uint32_t bits, power;
        memcpy(&bits, out + i, 4);
        const int32_t whole = (int32_t)(bits << 8) / 256;
        float scale;
        power = ((bits >> 24 ^ 0x80) - 1) << 23;
        memcpy(&scale, &power, 4);
        scale *= (float)whole;
        memcpy(out + i, &scale, 4);
    }
}

static int decode_view(const gltf_meshopt *m, const unsigned char *bytes, unsigned char *out) {
    if (m->mode == GLTF_MODE_ATTRIBUTES
            ? meshopt_decodeVertexBuffer(out, m->count, m->stride, bytes, m->length)
        : m->mode == GLTF_MODE_TRIANGLES
            ? meshopt_decodeIndexBuffer(out, m->count, m->stride, bytes, m->length)
            : meshopt_decodeIndexSequence(out, m->count, m->stride, bytes, m->length))
        return 0;
    if (m->filter == GLTF_FILTER_OCTAHEDRAL)
        decode_octahedral(m, out);
    else if (m->filter == GLTF_FILTER_QUATERNION)
        decode_quaternions(m, out);
    else if (m->filter == GLTF_FILTER_EXPONENTIAL)
        decode_exponents(m, out);
    return 1;
}

int norma_gltf_reads_meshopt(void) { return 1; }

norma_document_result norma_gltf_decode_meshopt(
    gltf *g, uint32_t number, norma_document_error *error) {
    gltf_view *view = &g->views[number];
    const gltf_meshopt *m = &view->meshopt;
    const char *wrong = wrong_layout(view);
    if (wrong) return norma_gltf_malformed(g, error, m->token, wrong);
    norma_document_result result = norma_gltf_load_buffer(g, m->buffer, error);
    if (result) return result;
    if (!norma_gltf_lies_in(g, m->buffer, m->offset, m->length))
        return norma_gltf_malformed(
            g, error, m->token, "compressed bytes that end inside their buffer");
    size_t size = m->count * m->stride;
    if (view->length > size && view->length - size > SMALL)
        return norma_gltf_malformed(g, error, m->token, "a byteLength of count times byteStride");
    unsigned char *out = norma_io_allocate(view->length, 1);
    if (!out) return norma_document_fail_memory(g->document, error);
    if (!decode_view(m, g->buffers[m->buffer].bytes + m->offset, out)) {
        free(out);
        return norma_gltf_malformed(
            g, error, m->token, "bytes that meshoptimizer's decoder accepts");
    }
    view->decoded = out;
    return NORMA_DOCUMENT_OK;
}

/* ---- compressing again */

static size_t encode_rows(const gltf_meshopt *m, const void *rows, unsigned char **out) {
    const size_t bound = meshopt_encodeVertexBufferBound(m->count, m->stride);
    *out = norma_io_allocate(bound, 1);
    return *out ? meshopt_encodeVertexBuffer(*out, bound, rows, m->count, m->stride) : 0;
}

/* The extension has version 1 of the codec for indices, which is not the library's default. */
static size_t encode_index_view(
    const gltf_meshopt *m, const unsigned char *bytes, unsigned char **out) {
    uint32_t *wide = norma_io_allocate(m->count, sizeof *wide), most = 0;
    for (size_t i = 0; wide && i < m->count; ++i) {
        for (size_t k = m->stride; k-- > 0;) wide[i] = wide[i] << 8 | bytes[i * m->stride + k];
        most = wide[i] > most ? wide[i] : most;
    }
    const int triangles = m->mode == GLTF_MODE_TRIANGLES;
    const size_t vertices = (size_t)most + 1,
                 bound = triangles ? meshopt_encodeIndexBufferBound(m->count, vertices)
                                   : meshopt_encodeIndexSequenceBound(m->count, vertices);
    *out = wide ? norma_io_allocate(bound, 1) : NULL;
    meshopt_encodeIndexVersion(1);
    const size_t size = !*out       ? 0
                        : triangles ? meshopt_encodeIndexBuffer(*out, bound, wide, m->count)
                                    : meshopt_encodeIndexSequence(*out, bound, wide, m->count);
    free(wide);
    return size;
}

/* Signed integers of 8 or 16 bits as the floats that the filter's encoder takes. */
static void widen_signed(const gltf_meshopt *m, const unsigned char *bytes, float *out) {
    const int has_two = m->stride == 8;
    for (size_t i = 0; i < 4 * m->count; ++i)
        out[i] = (float)signed_at(bytes, i, has_two) / (has_two ? 32767 : 127);
}

/* The other way round, with the lowest power that leaves a number within its 24 bits. */
static void encode_exponents(
    const gltf_meshopt *m, const unsigned char *bytes, unsigned char *out) {
    enum { LOWEST = -100, BITS = 23 };
    for (size_t i = 0; i < m->count * m->stride; i += 4) {
        float x;
        int power = LOWEST;
        memcpy(&x, bytes + i, 4);
        if (!isfinite(x)) x = 0; /* which does not come back: another codec takes it */
        (void)frexp(x, &power);
        power = (power > LOWEST ? power : LOWEST) - BITS;
        const int32_t whole = (int32_t)(ldexp(x, -power) + (x >= 0 ? 0.5 : -0.5));
        const uint32_t word = ((uint32_t)whole & 0xFFFFFF) | (uint32_t)power << 24;
        memcpy(out + i, &word, 4);
    }
}

static size_t encode_filtered(
    const gltf_meshopt *m, const unsigned char *bytes, unsigned char **out) {
    const int octahedral = m->filter == GLTF_FILTER_OCTAHEDRAL;
    unsigned char *rows = norma_io_allocate(m->count * m->stride, 1);
    float *floats = octahedral ? norma_io_allocate(4 * m->count, sizeof *floats) : NULL;
    size_t length = 0;
    if (rows && floats) {
        widen_signed(m, bytes, floats);
        meshopt_encodeFilterOct(rows, m->count, m->stride, m->stride == 4 ? 8 : 16, floats);
    } else if (rows && !octahedral) {
        encode_exponents(m, bytes, rows);
    }
    if (rows && (floats || !octahedral)) length = encode_rows(m, rows, out);
    free(rows);
    free(floats);
    return length;
}

/* Filters round, and the codec of triangles may begin each with another of its corners. -1: out of
 * memory, which is no reason for another codec: bytes never depend on it. */
static int gives_back(
    const gltf_meshopt *m, const unsigned char *packed, const unsigned char *bytes) {
    const size_t size = m->count * m->stride;
    unsigned char *again = norma_io_allocate(size, 1);
    const int same = again ? decode_view(m, packed, again) && memcmp(again, bytes, size) == 0 : -1;
    free(again);
    return same;
}

unsigned char *norma_gltf_encode_meshopt(gltf_meshopt *m, const unsigned char *bytes) {
    unsigned char *out = NULL;
    const int rows = m->mode == GLTF_MODE_ATTRIBUTES,
              filtered = rows && (m->filter == GLTF_FILTER_OCTAHEDRAL ||
                                     m->filter == GLTF_FILTER_EXPONENTIAL);
    if (filtered || m->mode == GLTF_MODE_TRIANGLES) {
        m->length = filtered ? encode_filtered(m, bytes, &out) : encode_index_view(m, bytes, &out);
        const int same = m->length ? gives_back(m, out, bytes) : -1;
        if (same > 0) return out;
        free(out);
        out = NULL;
        if (same < 0) return NULL;
    }
    m->mode = rows ? GLTF_MODE_ATTRIBUTES : GLTF_MODE_INDICES;
    m->filter = GLTF_FILTER_NONE;
    m->length = rows ? encode_rows(m, bytes, &out) : encode_index_view(m, bytes, &out);
    if (m->length) return out;
    free(out);
    return NULL;
}
