/* fuzz_meshopt.c: compressed views of glTF. The input is, for each of three views (positions,
 * normals, indices), how it is to be decoded and its compressed bytes; a GLB is made around them,
 * so that no mutation is lost on JSON. The mutator compresses numbers of its own now and then, by
 * meshoptimizer's encoders. */
#include "fuzz.h"
#include <meshoptimizer.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { VIEWS = 3, HEAD = 8 };

typedef struct view {
    const char *mode, *filter, *type;
    unsigned component, normalized, stride;
    size_t count, length; /* elements; compressed bytes */
    const uint8_t *bytes;
} view;

/* mode and filter, component and width, stride, count (two bytes), what is odd about it, length
 * (two bytes) */
static view take_view(fuzz_bytes *bytes) {
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"}, *const filters[] = {
                                                                                   "NONE",
                                                                                   "OCTAHEDRAL",
                                                                                   "QUATERNION",
                                                                                   "EXPONENTIAL"};
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    static const unsigned components[] = {5120, 5121, 5122, 5123, 5125, 5126};
    uint8_t head[HEAD];
    fuzz_take(bytes, head, sizeof head);
    view v = {modes[head[0] % 3], filters[head[0] / 3 % 4], types[head[1] % 4],
        components[head[1] / 4 % 6], head[1] / 24 % 2, head[2], head[3] | (size_t)head[4] << 8, 0,
        bytes->at};
    v.count = head[5] == 255 ? v.count << 16 : head[5] == 254 ? v.count << 48 : v.count;
    v.length = head[6] | (size_t)head[7] << 8;
    v.length = v.length < bytes->left ? v.length : bytes->left;
    bytes->at += v.length;
    bytes->left -= v.length;
    return v;
}

static size_t write_json(const view views[VIEWS], char *json, size_t room) {
    static const char *const head =
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsUsed\":[\"EXT_meshopt_compression\"],"
        "\"extensionsRequired\":[\"EXT_meshopt_compression\",\"KHR_mesh_quantization\"],"
        "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{"
        "\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2}]}],";
    size_t total = 0, at = (size_t)snprintf(json, room, "%s\"accessors\":[", head);
    for (int i = 0; i < VIEWS; ++i) {
        const view *v = &views[i];
        at += (size_t)snprintf(json + at, room - at,
            "%s{\"bufferView\":%d,\"componentType\":%u,\"normalized\":%s,\"type\":\"%s\",\"count\":"
            "%zu}",
            i ? "," : "", i, v->component, v->normalized ? "true" : "false", v->type, v->count);
    }
    at += (size_t)snprintf(json + at, room - at, "],\"bufferViews\":[");
    for (int i = 0; i < VIEWS; ++i) {
        const view *v = &views[i];
        at += (size_t)snprintf(json + at, room - at,
            "%s{\"buffer\":1,\"byteLength\":%zu,\"byteStride\":%u,\"extensions\":{\"EXT_meshopt_"
            "compression\":{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"byteStride\":%u,"
            "\"count\":%zu,\"mode\":\"%s\",\"filter\":\"%s\"}}}",
            i ? "," : "", v->count * v->stride, v->stride, total, v->length, v->stride, v->count,
            v->mode, v->filter);
        total += v->length;
    }
    at += (size_t)snprintf(json + at, room - at,
        "],\"buffers\":[{\"byteLength\":%zu},{\"byteLength\":4294967295,\"extensions\":{\"EXT_"
        "meshopt_compression\":{\"fallback\":true}}}]}",
        total);
    while (at % 4) json[at++] = ' ';
    return at;
}

static void put_u32(uint8_t *at, size_t number) {
    for (int i = 0; i < 4; ++i) at[i] = (uint8_t)(number >> 8 * i);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes rest = {bytes, size};
    view views[VIEWS];
    for (int i = 0; i < VIEWS; ++i) views[i] = take_view(&rest);
    uint8_t *glb = malloc(4096 + size);
    size_t json = write_json(views, (char *)glb + 20, 4000), at = 20 + json + 8;
    for (int i = 0; i < VIEWS; ++i) {
        memcpy(glb + at, views[i].bytes, views[i].length);
        at += views[i].length;
    }
    while (at % 4) glb[at++] = 0;
    memcpy(glb, "glTF\2\0\0\0", 8);
    put_u32(glb + 8, at);
    put_u32(glb + 12, json);
    memcpy(glb + 16, "JSON", 4);
    put_u32(glb + 20 + json, at - 28 - json);
    memcpy(glb + 24 + json, "BIN\0", 4);
    uint8_t *exact = malloc(at); /* so that what lies behind its end is seen */
    memcpy(exact, glb, at);
    free(glb);
    fuzz_reader(exact, at, NORMA_FILE_GLB);
    free(exact);
    return 0;
}

/* ---- numbers that were compressed as they should be */

static size_t put_view(
    uint8_t *out, size_t room, const uint8_t head[HEAD], const uint8_t *bytes, size_t length) {
    if (length + HEAD > room) return 0;
    memcpy(out, head, HEAD);
    out[6] = (uint8_t)length;
    out[7] = (uint8_t)(length >> 8);
    memcpy(out + HEAD, bytes, length);
    return HEAD + length;
}

static size_t compressed(uint8_t *out, size_t capacity, fuzz_random *random) {
    enum { MOST = 400 };
    static uint8_t vertices[MOST * 16], code[MOST * 40];
    unsigned indices[MOST * 3];
    size_t count = 1 + fuzz_random_below(random, fuzz_random_below(random, 4) ? 12 : MOST),
           faces = 1 + fuzz_random_below(random, count), size = 0;
    unsigned quantized = fuzz_random_u32(random) % 2, filter = fuzz_random_u32(random) % 4,
             sequence = fuzz_random_u32(random) % 2, narrow = fuzz_random_u32(random) % 2;
    for (size_t i = 0; i < sizeof vertices; ++i)
        vertices[i] =
            fuzz_random_below(random, 3) ? (uint8_t)(i / 7) : (uint8_t)fuzz_random_u32(random);
    for (size_t i = 0; i < 3 * faces; ++i)
        indices[i] = (unsigned)((i / 3 + fuzz_random_below(random, 3)) % count);
    const uint8_t stride = quantized ? 8 : 12;
    size_t length = meshopt_encodeVertexBuffer(code, sizeof code, vertices, count, stride);
    const uint8_t position[HEAD] = {
        0, (uint8_t)(2 + 4 * (quantized ? 3 : 5)), stride, (uint8_t)count, (uint8_t)(count >> 8)};
    size += put_view(out + size, capacity - size, position, code, length);
    const uint8_t normal_stride = filter == 2 || (filter && narrow) ? 8 : filter == 1 ? 4 : 12;
    length = meshopt_encodeVertexBuffer(code, sizeof code, vertices, count, normal_stride);
    const uint8_t normal[HEAD] = {(uint8_t)(3 * filter),
        (uint8_t)(2 +
                  4 * (normal_stride == 4      ? 0
                          : normal_stride == 8 ? 2
                                               : 5) +
                  24 * (normal_stride < 12)),
        normal_stride, (uint8_t)count, (uint8_t)(count >> 8)};
    size += put_view(out + size, capacity - size, normal, code, length);
    length = sequence ? meshopt_encodeIndexSequence(code, sizeof code, indices, 3 * faces)
                      : meshopt_encodeIndexBuffer(code, sizeof code, indices, 3 * faces);
    const uint8_t index[HEAD] = {sequence ? 2 : 1, (uint8_t)(4 * (narrow ? 3 : 4)), narrow ? 2 : 4,
        (uint8_t)(3 * faces), (uint8_t)(3 * faces >> 8)};
    return size + put_view(out + size, capacity - size, index, code, length);
}

size_t LLVMFuzzerCustomMutator(uint8_t *bytes, size_t size, size_t capacity, unsigned seed) {
    fuzz_random random = {seed};
    if (fuzz_random_below(&random, 12) == 0) {
        size_t made = compressed(bytes, capacity, &random);
        return made ? made : LLVMFuzzerMutate(bytes, size, capacity);
    }
    if (size > HEAD && fuzz_random_below(&random, 4) == 0) { /* a head */
        fuzz_bytes rest = {bytes, size};
        for (size_t view = fuzz_random_below(&random, VIEWS); view > 0; --view) take_view(&rest);
        if (rest.left >= HEAD)
            bytes[(size_t)(rest.at - bytes) + fuzz_random_below(&random, HEAD)] =
                (uint8_t)fuzz_random_u32(&random);
        return size;
    }
    return LLVMFuzzerMutate(bytes, size, capacity);
}
