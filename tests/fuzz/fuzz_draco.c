/* fuzz_draco.c: streams under KHR_draco_mesh_compression. The input is how many points and
 * attributes the primitive declares, and a stream; a GLB is made around it, which declares as many
 * triangles as the stream does, so that no mutation is lost on JSON or on a count. */
#include "fuzz.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t varint(fuzz_bytes *bytes) {
    size_t value = 0;
    uint8_t byte = 0x80;
    for (int i = 0; i < 5 && byte & 0x80; ++i) {
        byte = fuzz_u8(bytes);
        value |= (size_t)(byte & 0x7F) << 7 * i;
    }
    return value;
}

/* Behind the header of eleven bytes: faces first, or, where connectivity is coded, one byte and the
 * vertices before them. */
static size_t faces_of(const fuzz_bytes *stream) {
    fuzz_bytes at = *stream;
    uint8_t header[11];
    fuzz_take(&at, header, sizeof header);
    if (header[8] == 0) return varint(&at);
    fuzz_u8(&at);
    varint(&at);
    return varint(&at);
}

static size_t write_json(
    char *json, size_t room, const fuzz_bytes *stream, size_t points, unsigned attributes) {
    static const struct {
        const char *name, *type;
        int component;
    } kinds[] = {{"POSITION", "VEC3", 5126}, {"NORMAL", "VEC3", 5126}, {"TEXCOORD_0", "VEC2", 5126},
        {"TANGENT", "VEC4", 5126}, {"COLOR_0", "VEC4", 5121}, {"JOINTS_0", "VEC4", 5121},
        {"WEIGHTS_0", "VEC4", 5126}};
    enum { KINDS = sizeof kinds / sizeof *kinds };
    const size_t faces = faces_of(stream);
    size_t at = (size_t)snprintf(json, room,
        "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],"
        "\"nodes\":[{\"mesh\":0}],\"buffers\":[{\"byteLength\":%zu}],\"bufferViews\":[{\"buffer\":"
        "0,\"byteLength\":%zu}],\"accessors\":[{\"componentType\":%d,\"count\":%zu,\"type\":"
        "\"SCALAR\"}",
        stream->left, stream->left, points > 65535 || attributes & 128 ? 5125 : 5123, 3 * faces);
    for (size_t i = 0; i < KINDS; ++i)
        at += (size_t)snprintf(json + at, room - at,
            ",{\"componentType\":%d,\"count\":%zu,\"type\":\"%s\"}", kinds[i].component, points,
            kinds[i].type);
    for (int draco = 0; draco < 2; ++draco) {
        at += (size_t)snprintf(json + at, room - at, "%s",
            draco ? "},\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,"
                    "\"attributes\":{"
                  : "],\"meshes\":[{\"primitives\":[{\"indices\":0,\"attributes\":{");
        for (unsigned i = 0, comma = 0; i < KINDS; ++i)
            if (i == 0 || attributes >> i & 1)
                at += (size_t)snprintf(json + at, room - at, "%s\"%s\":%u", comma++ ? "," : "",
                    kinds[i].name, draco ? i : i + 1);
    }
    at += (size_t)snprintf(json + at, room - at, "}}}}]}]}");
    while (at % 4) json[at++] = ' ';
    return at;
}

static void put_u32(uint8_t *at, size_t number) {
    for (int i = 0; i < 4; ++i) at[i] = (uint8_t)(number >> 8 * i);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    fuzz_bytes stream = {bytes, size};
    const unsigned attributes = fuzz_u8(&stream);
    const size_t points = fuzz_u8(&stream) | (size_t)fuzz_u8(&stream) << 8;
    char json[3000];
    const size_t text = write_json(json, sizeof json - 4, &stream, points, attributes),
                 bin = (stream.left + 3) / 4 * 4, whole = 28 + text + bin;
    uint8_t *glb = calloc(whole, 1); /* exactly, so that what lies behind its end is seen */
    memcpy(glb, "glTF\2\0\0\0", 8);
    put_u32(glb + 8, whole);
    put_u32(glb + 12, text);
    memcpy(glb + 16, "JSON", 4);
    memcpy(glb + 20, json, text);
    put_u32(glb + 20 + text, bin);
    memcpy(glb + 24 + text, "BIN\0", 4);
    if (stream.left) memcpy(glb + 28 + text, stream.at, stream.left);
    fuzz_reader(glb, whole, NORMA_FILE_GLB);
    free(glb);
    return 0;
}
